"""Files that are written aside: several together or none, and what killed processes leave."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import two_records
from sentences import refusal

from pounding_risk._common.files import host, move_into_place, write_together, write_whole
from pounding_risk._common.written import write_folder
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.scene.reader import parse_scene

posix = pytest.mark.skipif(os.name != "posix", reason="processes are asked for by a signal")
SLOW = """
import sys, time
from pathlib import Path
from pounding_risk._common.files import write_whole

def write(file):
    file.write(b"half")
    file.flush()
    print("begun", flush=True)
    time.sleep(600)

write_whole(Path(sys.argv[1]), write)
"""


def begun(target: Path) -> subprocess.Popen[str]:
    """A process in the middle of writing a file."""
    process = subprocess.Popen([sys.executable, "-c", SLOW, str(target)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    return process


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@posix
def test_what_a_killed_process_left_goes_with_the_next_writing(tmp_path):
    """Of the same file alone; what a process that still runs, or another machine, is writing stays."""
    target = tmp_path / "table.csv"
    killed, runs = begun(target), begun(target)
    foreign = tmp_path / f".table.csv.other-machine.{killed.pid}.partial"
    other = tmp_path / f".other.csv.{host()}.{killed.pid}.partial"
    foreign.touch()
    other.touch()
    try:
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        assert len(names(tmp_path)) == 4
        write_whole(target, lambda file: file.write(b"whole"))
        kept = [foreign.name, other.name, f".table.csv.{host()}.{runs.pid}.partial"]
        assert names(tmp_path) == sorted([*kept, "table.csv"])
    finally:
        runs.kill()
        runs.wait()
    (tmp_path / "made").write_bytes(b"moved")
    move_into_place(tmp_path / "made", target)
    assert names(tmp_path) == sorted([foreign.name, other.name, "table.csv"])
    assert target.read_bytes() == b"moved"


def test_files_are_written_together_or_not_at_all(tmp_path):
    (tmp_path / "a").write_text("older")

    def fails(_):
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        write_together([(tmp_path / "a", lambda file: file.write(b"newer")), (tmp_path / "b", fails)])
    assert names(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "older"


def test_a_folder_made_for_files_that_cannot_be_written_goes_again(tmp_path):
    def contents():
        yield "first.csv", "1"
        raise PoundingError("the second one fails")

    (tmp_path / "there").mkdir()
    for folder in (tmp_path / "new" / "tables", tmp_path / "there"):
        assert "second" in refusal(write_folder, folder, contents())
    assert names(tmp_path) == ["there"] and names(tmp_path / "there") == []


LIMITED = """
import resource, signal, sys
import pounding_risk as pr
from pounding_risk.results.files import open_results

results = open_results(sys.argv[1])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # as Python has it
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), resource.RLIM_INFINITY))
try:
    pr.report(results, sys.argv[2])
except pr.PoundingError as error:
    print(error)
"""


@posix
@pytest.mark.complete
@pytest.mark.parametrize("limit", [2_000, 300_000])
def test_a_pdf_beyond_the_limit_of_files_names_itself_and_the_limit(limit, tmp_path):
    """2 kB are too few for its tables, 300 kB for a font."""
    pytest.importorskip("typst")
    scan(parse_scene(two_records(law="jankowski", stiffness="2e9 N/m^1.5")), tmp_path / "r.nc")
    command = [sys.executable, "-c", LIMITED, tmp_path / "r.nc", tmp_path / "r.pdf", str(limit)]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ran.stdout.startswith(f"{tmp_path / 'r.pdf'}: cannot be written (File too large"), ran.stderr
    assert "raise the limit (ulimit -f)" in ran.stdout
    assert not any("pdf" in name for name in names(tmp_path))
