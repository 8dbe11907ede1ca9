"""Every file that a word of a user names: a regular one of bounded size, or a sentence, and never a wait."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from sentences import refusal
from test_tables import TABLES

from pounding_risk._common import inputs
from pounding_risk.assessment.gmfs import read_fields
from pounding_risk.lab.verification.case import read_case
from pounding_risk.motions.formats import read_components
from pounding_risk.scene.damage import read_states
from pounding_risk.scene.reader import read_scene

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with a name are a matter of POSIX")
READERS: dict[str, Callable[[Path], object]] = {
    "scene.toml": read_scene,
    "states.toml": lambda path: read_states(path, ()),
    "case.toml": read_case,
    "gmf-data_1.csv": read_fields,
    "record.AT2": read_components,
}
OF_TABLES = ("hazard.csv", "street.csv", "forces.csv", "target.csv", "manifest.csv")
READERS |= {name: TABLES[name][0] for name in OF_TABLES}


@pytest.mark.parametrize("name", READERS)
def test_a_pipe_or_a_device_without_end_is_not_waited_for(name, tmp_path, says):
    """Without the check this test does not end."""
    os.mkfifo(tmp_path / name)
    says(refusal(READERS[name], tmp_path / name))
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    says(refusal(READERS[name], tmp_path / name))


SLOW = ("hazard.csv", "target.csv")  # seconds each


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.complete if name in SLOW else ()) for name in READERS]
)
def test_a_file_above_the_size_of_its_kind_is_not_read(name, tmp_path, says):
    """Holes take no space on the disk; a byte more than the largest of all limits."""
    with open(tmp_path / name, "wb") as file:
        file.truncate(inputs.EXPORT + 1)
    says(refusal(READERS[name], tmp_path / name))


def test_the_limit_itself_is_read(tmp_path):
    (tmp_path / "file").write_bytes(b"12345")
    assert inputs.read_whole(tmp_path / "file", 5) == b"12345"
    with pytest.raises(inputs.Unfit):
        inputs.read_whole(tmp_path / "file", 4)


def test_a_folder_and_a_name_that_is_none_stay_what_they_are(tmp_path):
    with pytest.raises(IsADirectoryError):
        inputs.read_whole(tmp_path, 5)
    with pytest.raises(FileNotFoundError):
        inputs.read_whole(tmp_path / "none", 5)


def test_text_has_plain_line_ends_and_no_mark(tmp_path):
    (tmp_path / "file").write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert inputs.read_text(tmp_path / "file", 100) == "a\nb\nc\n"


READ_STDIN = "from pathlib import Path; from pounding_risk._common.inputs import read_whole; "
READ_STDIN += "print(read_whole(Path('/dev/stdin'), 5).decode())"


@pytest.mark.skipif(not Path("/dev/stdin").exists(), reason="standard input has no name here")
def test_standard_input_may_be_a_pipe():
    for given, status in (("12345", 0), ("123456", 1)):
        done = subprocess.run(
            [sys.executable, "-c", READ_STDIN], input=given, capture_output=True, text=True, timeout=60
        )
        assert done.returncode == status
        assert done.stdout.strip() == given if status == 0 else "Unfit" in done.stderr


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="open files have no names here")
def test_what_a_shell_writes_for_a_command_is_refused():
    """``<(...)`` is /dev/fd/N of a pipe."""
    reader, writer = os.pipe()
    try:
        assert "is a pipe" in refusal(inputs.read_whole, Path(f"/dev/fd/{reader}"), 5, kind=inputs.Unfit)
    finally:
        os.close(reader)
        os.close(writer)
