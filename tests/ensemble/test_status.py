"""The state of a study: told from its folder alone, at any moment, and without holding anybody up."""

import json
import os
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from commands import done
from processes import output
from sentences import refusal

import pounding_risk as pr
from pounding_risk._common.files import host
from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint
from pounding_risk.ensemble.status import COMPLETE, NOT_BEGUN, STOPPED
from pounding_risk.errors import PoundingError

ABOUT = About(batches=100, width=3, title="A pair", command="pounding-risk scan 'my scene.toml' -o results.nc")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def begun(**choices: bool) -> Checkpoint:
    """A study of which 30 of 100 batches are kept."""
    study = Checkpoint.open("results.study", {"scene": {}}, ABOUT, **choices)
    for start in (0, 10, 50):
        study.keep(range(start, start + 10), {"raw": np.zeros((10, 3))}, 0.1)
    return study


def told(*words: str) -> dict[str, str]:
    """What the command prints, by the first word of each line."""
    return dict(re.split(r" {2,}", line, maxsplit=1) for line in done("status", *words).stdout.splitlines() if line)


def test_what_is_not_there_is_not_begun():
    found = pr.status("results.nc")
    assert (found.state, found.cases, found.total, found.is_running) == (NOT_BEGUN, 0, 0, False)
    assert found.go_on == "pounding-risk scan SCENE -o results.nc"
    assert told("results.nc")["note"] == "there is no study in results.study"
    Path("results.study").mkdir()
    Path("results.study/lock").touch()  # as a study that was killed while it began
    assert pr.status("results.study").state == NOT_BEGUN
    assert pr.status("frame.toml").go_on == "pounding-risk scan frame.toml -o frame.nc"


@pytest.mark.parametrize("name", ["results.nc", "results.zarr"])
def test_results_that_a_scan_has_not_written_yet_name_its_folder_and_what_says_how_it_goes_on(name, says):
    """Once its shards are done the scan itself writes the file, as it does after a stop."""
    begun().close()
    says(refusal(pr.assess, name))


@pytest.mark.parametrize("name", ["results.nc", "results.zarr"])
def test_results_without_a_folder_are_whole_and_tell_no_more(name):
    Path(name).mkdir() if name.endswith("zarr") else Path(name).touch()
    for path in (name, "results.study"):
        assert pr.status(path).state == COMPLETE
        assert pr.status(path).note == f"{name} is whole; no folder results.study describes its run"


def test_a_stopped_study_says_how_to_go_on(tmp_path, monkeypatch):
    begun().close()
    found = pr.status("results.nc")
    assert pr.status("results.zarr").cases == pr.status("results.study").cases == found.cases
    assert (found.state, found.title, found.cases, found.total) == (STOPPED, "A pair", 90, 300)
    assert found.parts == 3 and found.size == sum(file.stat().st_size for file in Path("results.study/parts").iterdir())
    assert found.cases_a_second == found.seconds_left == found.shards == 0
    assert found.go_on == ABOUT.command
    printed = told("results.nc")
    assert printed["cases"] == "90 of 300 (30 %)" and printed["on disk"] == "3 parts, 0.0 MB"
    assert printed["go on with:"] == found.go_on
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert pr.status(tmp_path / "results.nc").go_on == f"cd {tmp_path} && {found.go_on}"


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
def test_a_running_study_can_be_asked_and_goes_on(folder):
    """From another process, which imports neither compiler nor dataset library; and the run does not notice."""
    code = (
        "import sys, pounding_risk\n"
        "found = pounding_risk.status('results.nc')\n"
        "print(found.state, found.cases)\n"
        "print([name for name in ('numba', 'xarray', 'netCDF4', 'obspy', 'scipy') if name in sys.modules])"
    )
    with begun() as study:
        assert output("-c", code).splitlines() == [f"running on {host()} (pid {os.getpid()}) 90", "[]"]
        study.keep(range(20, 30), {"raw": np.zeros((10, 3))}, 0.1)
        assert pr.status("results.nc").go_on == ""
    assert pr.status("results.nc").state == STOPPED


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
def test_speed_and_time_left_are_those_of_the_run_under_way():
    """90 cases of an earlier run count as done and not as quick; the first part stands for reading and compiling."""
    begun().close()
    with Checkpoint.open("results.study", {"scene": {}}, ABOUT) as study:
        log = study.path / "log.jsonl"
        now = datetime.now(UTC)
        for seconds, start in ((0, 20), (10, 30), (20, 40)):
            study.keep(range(start, start + 10), {"raw": np.zeros((10, 3))}, 0.1)
            *before, last = log.read_text(encoding="utf-8").splitlines()
            line = json.loads(last) | {"time": (now + timedelta(seconds=seconds)).isoformat()}
            log.write_text("\n".join([*before, json.dumps(line), ""]), encoding="utf-8")
        found = pr.status("results.nc")
        assert found.cases == 180
        assert found.cases_a_second == pytest.approx(60 / 20)  # to the rounding of a float
        assert found.seconds_left == pytest.approx(120 / 3)
        assert told("results.nc")["cases"] == "180 of 300 (60 %), 3 a second, about 40 s left"


def test_a_complete_study_is_told_from_its_log():
    with begun() as study:
        study.clear()
    found = pr.status("results.nc")
    assert (found.state, found.cases, found.parts, found.go_on) == (COMPLETE, 300, 0, "")
    assert found.note == "its results are not beside results.study any more: moved, or removed"
    Path("results.nc").touch()
    assert pr.status("results.nc").note == ""
    assert told("results.nc", "results.study")["cases"] == "300 of 300 (100 %)"
    begun().close()  # begun again, it is complete no more
    assert pr.status("results.nc").state == STOPPED


def test_a_study_that_was_killed_before_its_results_were_written():
    with begun() as study:
        study.keep(range(0, 100), {"raw": np.zeros((100, 3))}, 0.1)
    found = pr.status("results.nc")
    assert (found.state, found.cases) == (STOPPED, 300)
    assert found.note == "every case is kept, and the results are still to be written"


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
def test_shards_are_counted():
    with begun(shared=True), begun(shared=True) as second:
        assert pr.status("results.nc").shards == 1  # of one process, and none has told its name
        second.log("shard", shard="1/8")
        second.log("shard", shard="2/8")
        assert pr.status("results.nc").is_running
        assert told("results.nc")["state"].endswith("; 2 shards so far")


def test_a_study_that_is_done_again_says_that_the_results_beside_it_are_whole():
    begun().close()
    assert pr.status("results.nc").note == ""
    Path("results.nc").touch()
    assert told("results.nc")["note"] == "results.nc is of an earlier run, and whole"


@pytest.mark.parametrize("name", [".", "..", "/"])
def test_a_folder_that_has_no_name_is_told(name):
    with pytest.raises(PoundingError, match=r"is a folder; name the results, such as .*results\.nc"):
        pr.status(name)


def test_a_folder_of_the_users_own_is_no_study(says):
    Path("results.study").mkdir()
    Path("results.study/thesis.tex").touch()
    says(refusal(pr.status, "results.nc"))
