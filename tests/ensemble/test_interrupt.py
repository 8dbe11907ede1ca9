"""Ctrl-C: the command is gone at once, keeps what is done and says how to go on. No run is lost by kills."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from processes import output, python
from scenes import scene_text, single

from pounding_risk import cli
from pounding_risk.ensemble.status import status

# A weak motion that closes no gap and is done at once; then lines of 10,000 runs of a stiff pair over 150 s, each of
# them one compiled call that takes the better part of a minute.
SCENE = scene_text(
    single("left", "500 t", "0.1 s"),
    single("right", "800 t", "0.06 s"),
    name="stopped",
    law="viscous_elastoplastic",
    gap=None,
    records={"names": ["CCC-HN1"]},
    grid={
        "gap": ["0.02 mm", "0.03 mm", "0.04 mm"],
        "pga": ["0.001 g", "0.5 g"],
        "yield_force": {"start": "10 kN", "stop": "20 kN", "num": 10000},
    },
    solver={"rtol": 1e-11},
)


def started(folder: Path) -> subprocess.Popen[str]:
    command = ["-m", "pounding_risk", "scan", "scene.toml", "-o", "r.nc", "--no-screening", "--workers", "2"]
    return python(*command, cwd=folder)


def events(folder: Path) -> list[str]:
    log = folder / "r.study" / "log.jsonl"
    return [json.loads(line)["event"] for line in log.read_text().splitlines()] if log.exists() else []


@pytest.mark.complete
def test_ctrl_c_waits_for_no_kernel_and_keeps_what_is_done(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    child = started(tmp_path)
    try:
        limit = time.monotonic() + 300.0
        while events(tmp_path).count("kept") < 2 and child.poll() is None and time.monotonic() < limit:
            time.sleep(0.05)
        time.sleep(0.5)  # both threads are in kernels by then
        child.send_signal(signal.SIGINT)
        # The kernels under way take far longer than this.
        _, err = child.communicate(timeout=20.0)
    finally:
        child.kill()
    assert child.returncode == 130, err
    assert "stopped by Ctrl-C" in err and "the same command goes on from there" in err, err
    assert "Traceback" not in err
    assert not (tmp_path / "r.nc").exists()
    assert events(tmp_path)[-1] == "stop"
    told = status(tmp_path / "r.nc")
    assert told.state == "stopped" and 0 < told.cases < told.total
    assert f"{told.cases} of {told.total} cases are kept" in err


def test_ctrl_c_before_a_command_is_reached_shows_no_traceback(monkeypatch):
    """While typer still builds the commands, which takes some tenths of a second."""

    def interrupted(**_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "app", interrupted)
    monkeypatch.setattr(cli, "_exit_past_threads", lambda end: None)  # other tests' threads may live here
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 130


SCRIPT = Path(__file__).parents[1] / "killed_scans.py"


@pytest.mark.complete
def test_a_killed_scan_ends_in_the_file_of_one_that_nobody_disturbed(tmp_path):
    """Fifty kills at random moments of five studies.

    Bit-identical each time, with one to four threads, and at no moment a partial file under the final name.
    """
    if not hasattr(os, "fork"):
        pytest.skip("SIGKILL and fork are POSIX")
    told = json.loads(output(SCRIPT, tmp_path, 5, 50, 20110314, timeout=600))
    assert told["wrong"] == []
    assert told["kills"] >= 50 and told["studies"] >= 5
