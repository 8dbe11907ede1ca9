"""A processing step is one file: found in its folder, named in sentences, asked for by name."""

from __future__ import annotations

import sys

import pytest

from pounding_risk import read_motion
from pounding_risk.errors import RecordError
from pounding_risk.motions import processing

HALVED = '''"""Half of the motion."""

from pounding_risk.motions.processing import Done, step


@step("halved")
def halved(samples, dt):
    """Divide by two, in place."""
    samples /= 2.0
    return Done(samples, "halved: divided by two")
'''


@pytest.fixture
def one_more_file(tmp_path, monkeypatch):
    """The folder of the steps with one file more, forgotten afterwards."""
    (tmp_path / "halved.py").write_text(HALVED, encoding="utf-8")
    monkeypatch.setattr(processing, "__path__", [*processing.__path__, str(tmp_path)])
    monkeypatch.setattr(processing._REGISTRY, "members", dict(processing.known_steps()))
    monkeypatch.setattr(processing._REGISTRY, "folder", processing.__name__)
    yield
    sys.modules.pop("pounding_risk.motions.processing.halved", None)


def test_adding_a_step_is_adding_a_file(one_more_file):
    asked = [{"step": "halved"}]
    motion, plain = (read_motion("RSN6-180", processing=steps) for steps in (asked, "none"))
    assert motion.pga == plain.pga / 2.0 and "halved: divided by two" in motion.processing
    with pytest.raises(RecordError, match=r"it may be bandpass, .*, halved, "):
        read_motion("RSN6-180", processing=[{"step": "half"}])
