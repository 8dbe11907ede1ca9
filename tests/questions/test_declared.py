"""Commands made from questions: one file is a command, a Python call and a method of datasets."""

import csv
import inspect
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from io import StringIO
from pathlib import Path

import pytest
from commands import done, refused
from scenes import two_records
from typer.main import get_command

import pounding_risk as pr
from pounding_risk import cli, questions
from pounding_risk.cli._common.declared import Question, parameters_of
from pounding_risk.questions import Declared, declared_questions
from pounding_risk.scene.reader import parse_scene

NEW = '''"""The largest peak closing of a dataset."""

from __future__ import annotations

from typing import Any

from pounding_risk.render.sheet import Block, number, table
from pounding_risk.units import GAP, si

ORDER = 999


def widest(results: Any, *, above: float | str = 0.0, records: tuple[str, ...] = (), twice: bool = False) -> float:
    """Largest closing of all cases.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`.
    above : float or str
        Closings below are ignored [m, or text with a unit].
    records : sequence of str
        Only these records.
    twice : bool
        Counted twice.

    Returns
    -------
    float
        In m.
    """
    from pounding_risk.results.files import open_results

    dataset = results if hasattr(results, "sizes") else open_results(results)
    values = dataset["peak_closing"].sel(record=list(records) or dataset["record"].values)
    return float(values.where(values > si(above, GAP, "above")).max()) * (2.0 if twice else 1.0)


def sheet(answer: float) -> list[Block]:
    """The closing."""
    return [table("Largest closing.", ["what", "closing [mm]"], [["all cases", number(answer, "m")]])]


def status(answer: float) -> int:
    """Exit status."""
    return 4 if answer > 1.0 else 0
'''


@pytest.fixture
def widest(tmp_path, monkeypatch) -> Iterator[Path]:
    """The dataset of a scan, with a file more among the questions while a test runs."""
    monkeypatch.chdir(tmp_path)
    pr.scan(parse_scene(two_records(law="jankowski", stiffness="2e9 N/m^1.5")), "r.nc", check_fraction=0.0)
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "widest.py").write_text(NEW, encoding="utf-8")
    monkeypatch.setattr(questions, "__path__", [*questions.__path__, str(folder)])
    found = declared_questions() | {"widest": Declared("widest", 999, NEW)}
    monkeypatch.setattr(cli.Commands, "questions", found)
    monkeypatch.setattr(questions, "declared_questions", lambda: found)
    yield tmp_path / "r.nc"
    sys.modules.pop("pounding_risk.questions.widest", None)
    vars(pr).pop("widest", None)


def test_one_file_is_a_command_a_call_and_a_method(widest):
    """Nothing else is written: options and their texts, files, status and errors follow from the file."""
    dataset = pr.open_results(widest)
    largest = float(dataset["peak_closing"].max())
    assert pr.widest(widest) == dataset.pounding.widest() == largest
    told = done("widest", "r.nc", "-o", "w.csv").stdout
    assert f"{1e3 * largest:.4g}" in told and "written: w.csv" in told
    rows = list(csv.reader(StringIO(Path("w.csv").read_text(encoding="utf-8"))))
    assert rows[2][0] == "all cases" and float(rows[2][1]) == pytest.approx(1e3 * largest, rel=1e-14)  # 15 digits
    done("widest", "r.nc", "-o", "w.html")
    assert f"{1e3 * largest:.4g}" in Path("w.html").read_text(encoding="utf-8")
    done("widest", "r.nc", "-o", "W.CSV")
    assert Path("W.CSV").read_bytes() == Path("w.csv").read_bytes()
    record = str(dataset["record"].values[0])
    one = float(dataset["peak_closing"].sel(record=record).max())
    assert f"{2e3 * one:.4g}" in done("widest", "r.nc", "--records", record, "--twice").stdout
    text = " ".join(done("widest", "--help").output.split())
    assert "Largest closing of all cases." in text and "Closings below are ignored" in text
    assert "Largest closing of all cases." in done("--help").output
    assert refused("widest", "r.nc", "--above", "3").startswith('pounding-risk: --above: "3" has no unit')


@pytest.mark.parametrize("declared", declared_questions().values(), ids=lambda declared: declared.name)
def test_every_option_is_explained(declared):
    """A parameter without a description in the docstring would be an option without a help."""
    command = get_command(cli.app).commands[declared.name]
    assert all(option.help for option in command.params if option.name != "help"), declared.name
    assert Question(declared).summary.startswith(declared.summary())


@pytest.mark.parametrize("declared", declared_questions().values(), ids=lambda declared: declared.name)
def test_every_option_and_figure_is_that_of_a_function(declared):
    """A name misspelt in OPTIONS would be an option that nothing reads, one in FIGURES an error once it is drawn."""
    question = Question(declared)
    taken = {*question.takes, *question.sheet_takes, *question.files}
    for drawing in getattr(declared.module(), "FIGURES", {}).values():
        names = re.findall(r'"([a-z_]+\.\w+)"', inspect.getsource(drawing)) if callable(drawing) else [drawing]
        for home, _, name in (full.partition(".") for full in names):
            function = getattr(import_module(f"pounding_risk.figures.{home}"), name)
            taken |= inspect.signature(function).parameters.keys()
    assert set(question.options) <= taken


def test_a_file_with_an_order_is_a_question():
    """However the line is written: without it the file would be no command, and nobody told."""
    folder = Path(questions.__file__).parent
    of_questions = {file.stem for file in folder.glob("[a-z]*.py") if "\nORDER" in file.read_text(encoding="utf-8")}
    assert of_questions == set(declared_questions())
    for line in ("ORDER = 60", "ORDER: int = 60", "ORDER = 60  # after damage"):
        assert questions._ORDER.findall(f'"""Words."""\n\n{line}\n') == ["60"]


def test_descriptions_of_several_names_and_paragraphs_are_read():
    def some(one, two, three):
        """Head.

        Parameters
        ----------
        one, two : int
            First line,
            second line.

            Another paragraph.
        three : str, optional
            Third.

        Returns
        -------
        int
        """

    words = "First line, second line. Another paragraph."
    assert parameters_of(some) == {"one": words, "two": words, "three": "Third."}
    assert parameters_of(None) == parameters_of(len) == {}


def test_a_dataset_is_written_under_a_suffix_in_capitals(tmp_path, monkeypatch):
    """Of a function that writes its own, and of one whose dataset the command writes."""
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(two_records(law="jankowski", stiffness="2e9 N/m^1.5"), encoding="utf-8")
    for words in (("compare", "s.toml", "--law", "jankowski", "--law", "linear"), ("simulate", "s.toml")):
        done(*words, "-o", f"{words[0]}.NC")
        assert pr.open_results(f"{words[0]}.NC").pounding.kind == words[0]
