"""Names that steer a terminal, mislead a reader or break a format: refused at the entry, escaped at the exit."""

import csv
import subprocess
import sys
from io import StringIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from processes import PACKAGE, bare_environment
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk._common.letters import cell, plain, refused, without_mark
from pounding_risk.cli import _sentences
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.motions.manifest import read_manifest, write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.reports.exports.csv import table
from pounding_risk.results.check import check_scan
from pounding_risk.scene.reader import parse_scene
from pounding_risk.streets.table import read_table

REFUSED = [0x00, 0x07, 0x09, 0x0A, 0x0D, 0x1B, 0x7F, 0x80, 0x9B, 0x2028, 0x2029, 0x202A, 0x202E, 0x2066, 0x2069, 0xFFFF]
FINE = ["Bâtiment 3", "\u05d1\u05d9\u05ea", "\u9ad8\u697c", "</script>", "=1+1", "\u200dx", "\U0001f3e0"]
SHORT = ['records.names=["RSN6-180"]', 'records.window=["0 s", "2 s"]']


def text(name: str = "left") -> str:
    left, right = single(name, "10 t", "0.5 s"), single("right", "20 t", "0.3 s")
    return scene_text(left, right, law="linear", gap="20 mm")


@pytest.mark.parametrize("code", REFUSED, ids=hex)
def test_a_name_of_a_scene_is_refused_by_line_key_and_code_point(code):
    with pytest.raises(SceneError) as error:
        parse_scene(text(f"a\\u{code:04x}b"))
    (sentence,) = error.value.faults
    assert sentence.startswith("line ") and ".name: " in sentence
    assert f"has U+{code:04X} at place 2 of " in sentence and sentence.endswith("; leave it out")


@pytest.mark.parametrize("name", FINE)
def test_other_names_stay(name):
    assert parse_scene(text(name)).buildings[0].name == name
    assert plain(name) == name


def test_every_text_of_a_scene_is_looked_at(says):
    """Files as well as names, with --set as well as in the file."""
    for override in ('scene.name="a\\u001b[2J"', 'records.files=["a\\u202e.AT2"]'):
        says(refusal(parse_scene, text(), overrides=[override]).splitlines()[1])


@pytest.mark.parametrize("code", [0x1B, 0x202E, 0x00])
def test_a_name_of_a_table_is_refused(code, tmp_path):
    (tmp_path / "street.csv").write_bytes(f"name,storeys,height [m]\nx{chr(code)}y,3,10\nz,2,7\n".encode())
    with pytest.raises(PoundingError, match=rf"line 2, name: has U\+{code:04X} at place 2"):
        read_table(tmp_path / "street.csv")


@pytest.fixture(scope="module")
def dataset():
    return pr.scan(parse_scene(text("=A"), overrides=SHORT))


def test_a_dataset_with_such_a_label_or_title_is_refused(dataset, says):
    check_scan(dataset, "it")
    named = dataset.assign_coords(building=["a\u001b[2J", "right"])
    says([refusal(check_scan, made, "it") for made in (named, dataset.assign_attrs(title="a\u202eb"))])


@pytest.mark.complete
def test_a_refused_scene_steers_no_terminal(tmp_path):
    """A name that is refused, a key that is quoted, and a file's own name, by a process of its own."""
    (tmp_path / "s\x1b[2J.toml").write_text(text("\u202ea\u009b") + '\n["\u009b\u202e"]\nx = 1\n', encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pounding_risk", "validate", "s\x1b[2J.toml"],
        env=bare_environment(PYTHONPATH=str(PACKAGE.parent)),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2 and "has U+202E at place 1" in done.stderr
    assert not any(map(refused, (done.stdout + done.stderr).split("\n")))


def test_what_a_command_prints_is_escaped(capsys):
    with _sentences():
        print("name \u001b[2J \u202e \u009b \x7f", "tab\there")
    assert capsys.readouterr().out == "name \\u001b[2J \\u202e \\u009b \\u007f tab\there\n"


FORMULAS = ["=1+1", "+A1", "-A1+1", "@SUM(1)", "\t=1", "\r=1", '=HYPERLINK("http://x")', "'=1", "''=1", "-", "+1 A"]
NUMBERS = ["-3", "+2.5e-3", "-.5", "-inf", "1e5", "nan", "-0.0"]


@pytest.mark.parametrize("name", FORMULAS)
def test_no_cell_begins_as_a_formula_and_the_way_back_is_exact(name):
    assert cell(name) == f"'{name}"
    assert without_mark(cell(name)) == name


@pytest.mark.parametrize("value", [*NUMBERS, -3.5, 4, None, "left", "'quoted'", ""])
def test_numbers_and_other_texts_are_as_they_were(value):
    assert cell(value) == value
    assert not isinstance(value, str) or without_mark(value) == value


@given(st.text())
def test_every_text_comes_back(text):
    assert without_mark(cell(text)) == text


def test_the_manifest_comes_back(tmp_path):
    motions = [Motion("=cmd|x", np.array([0.0, 1.5, -2.0]), 0.01, {"event": "@home", "sha256": "ab"})]
    path = write_manifest(motions, tmp_path / "manifest.csv")
    (raw,) = csv.DictReader(StringIO(path.read_text(encoding="utf-8")))
    assert (raw["name"], raw["event"]) == ("'=cmd|x", "'@home")
    (row,) = read_manifest(path)
    assert (row["name"], row["event"]) == ("=cmd|x", "@home")


def test_a_street_comes_back(tmp_path):
    (tmp_path / "street.csv").write_text("name,storeys,height [m]\n'=A,3,10\nB,2,7\n", encoding="utf-8")
    assert [entry.values["name"] for entry in read_table(tmp_path / "street.csv").entries] == ["=A", "B"]


def test_the_tables_of_a_scan_have_no_formula(dataset):
    name = next(str(name) for name, values in dataset.data_vars.items() if "building" in values.dims)
    written = table(dataset, [name])
    assert ",'=A," in written and ",=A," not in written
