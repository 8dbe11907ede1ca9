"""What holds where the system has no locks on files, as on Windows."""

import sys

from pounding_risk.ensemble.checkpoint.lock import Lock, running


def test_without_locks_of_the_system_a_checkpoint_is_open_to_all(tmp_path, monkeypatch):
    """Nobody waits or is refused, and nobody is said to be running: the docs say so."""
    monkeypatch.setitem(sys.modules, "fcntl", None)
    first, second = Lock(tmp_path / "lock"), Lock(tmp_path / "lock")
    assert first.take(shared=False) and second.take(shared=False)
    assert running(tmp_path / "lock") == []
    first.close()
    second.close()
    assert not first.is_open
