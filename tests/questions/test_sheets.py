"""Of every question: cells of its sheet are values of its answer, and all renderers show the same cells."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, is_dataclass
from importlib import import_module
from io import BytesIO, StringIO
from math import inf, nan
from pathlib import Path
from pkgutil import iter_modules
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
import xarray as xr
from golden_commands import page_text, prepare
from pypdf import PdfReader
from scenes import scene_text

import pounding_risk as pr
from pounding_risk import questions
from pounding_risk.assessment.spectra import shortfalls
from pounding_risk.lab.accuracy_findings import summed_up
from pounding_risk.lab.effects_findings import rows, yielding
from pounding_risk.questions.modes import answer as modes_answer
from pounding_risk.questions.separations import separations as separations_answer
from pounding_risk.render.csv_text import csv_text
from pounding_risk.render.sheet import LONG, Block, amount, between, joined, middle, noted, number, table
from pounding_risk.render.terminal import print_sheet
from pounding_risk.reports import html, pdf
from pounding_risk.reports.document import number_blocks
from pounding_risk.results.files import save
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import SHOWN

# An answer of each question that has a sheet, from the scenes of the golden files.
ANSWERS: MappingProxyType[str, Callable[[Path], Any]] = MappingProxyType(
    {
        "accuracy": lambda folder: pr.accuracy(folder / "one.toml", cases=1, budget=0.2, scipy=False),
        "advise": lambda folder: pr.advise(pr.read_scene(folder / "pair.toml")),
        "along": lambda folder: pr.assess_along(pr.scan(_along(folder), check_fraction=0.0)),
        "amplification": lambda folder: pr.amplification(pr.read_scene(folder / "pair.toml"), num=4, num_gaps=2),
        "assess": lambda folder: pr.assess(_scan(folder, "levels"), hazard=folder / "hazard.csv"),
        "compare": lambda folder: pr.compare(pr.read_scene(folder / "compare.toml"), laws=["jankowski", "linear"]),
        "damage": lambda folder: pr.damage(_scan(folder, "levels"), hazard=folder / "hazard.csv"),
        "effects": lambda folder: pr.effects(folder / "effects.toml"),
        "uncertainty": lambda folder: pr.uncertainty(folder / "uncertain.toml"),
        "modes": lambda folder: modes_answer(pr.read_scene(folder / "row.toml")),
        "rerun": lambda folder: _rerun(folder),
        "separations": lambda folder: separations_answer(_scan(folder, "pair")),
        "simulate": lambda folder: pr.simulate(folder / "one.toml"),
        "stability": lambda _: pr.stability(law=["hertz", "linear"], case=["3"], rows=True),
        "summary": lambda folder: pr.summary(_scan(folder, "pair")),
        "setback": lambda folder: pr.setbacks(_scan(folder, "pair")),
        "spectra": lambda folder: pr.spectra(pr.read_scene(folder / "pair.toml"), num=4),
        "verify": lambda _: pr.verify(["hertz_1881", "chopra_10_4"]),
    }
)
# What a sheet states beside the values of its answer, computed here once more.
DERIVED: MappingProxyType[str, Callable[[Any], Any]] = MappingProxyType(
    {
        "assess": lambda answer: [
            *(one.gap / required.gap for one in answer.interfaces for required in one.required),
            *(one.gap / rule.upper for one in answer.interfaces for rule in one.separations if rule.upper),
            *(
                rule.exceeded * one.contact_at_gap().runs
                for one in answer.interfaces
                for rule in one.separations
                if rule.exceeded is not None
            ),
        ],
        "spectra": shortfalls,
        "modes": lambda answer: [
            part
            for one in answer.buildings
            for part in (one.shares.cumsum().tolist(), list(range(1, one.shares.size + 1)))
        ],
        "separations": lambda answer: [
            round(rule.exceeded * table.motions)
            for _, table in answer.tables
            for rule in table.rules
            if rule.exceeded is not None
        ],
        "simulate": lambda answer: [
            *(answer["contact_end"] - answer["contact_start"]).values.tolist(),
            *range(1, answer.sizes["contact"] + 1),
        ],
        "stability": lambda answer: [len(answer), *(part for row in answer for part in (row.bound, row.in_row.figure))],
        "accuracy": lambda answer: [
            summed_up(answer["error"].sel(setting=setting, output=output).values)
            for setting in answer["setting"].values
            for output in answer["output"].values
        ],
        "effects": lambda answer: [*rows(answer), yielding(answer), int((answer["status"] != 0).sum())],
    }
)
WITH_SHEETS = sorted(
    name
    for _, name, _ in iter_modules(questions.__path__)
    if hasattr(import_module(f"{questions.__name__}.{name}"), "sheet")
)


def _scan(folder: Path, name: str) -> xr.Dataset:
    return pr.scan(folder / f"{name}.toml", check_fraction=0.0)


def _rerun(folder: Path) -> Any:
    """A rerun of results of which one value was changed."""
    changed = _scan(folder, "pair")
    changed["impulse"].values.flat[0] *= 1.5
    return pr.rerun(save(changed, folder / "changed.nc"))


def _along(folder: Path) -> Any:
    """The scene of the pair with two masses of one building."""
    text = (folder / "pair.toml").read_text(encoding="utf-8")
    return parse_scene(text.replace("[grid]", '[grid]\n"building.stiff.mass" = ["500 t", "600 t"]'))


@pytest.fixture(scope="module")
def answers(tmp_path_factory) -> dict[str, Any]:
    """The answers that the tests of this file have asked for so far, and the folder of their scenes."""
    folder = tmp_path_factory.mktemp("answers")
    prepare(folder)
    return {"folder": folder}


def answered(answers: dict[str, Any], name: str) -> tuple[Any, list[Block]]:
    """Answer and sheet of a question."""
    if name not in answers:
        answers[name] = ANSWERS[name](answers["folder"])
    return answers[name], import_module(f"{questions.__name__}.{name}").sheet(answers[name])


def cells(blocks: Iterable[Block]) -> Iterator[dict[str, Any]]:
    """Every cell of the tables and facts of a sheet."""
    for block in blocks:
        if block["kind"] == "table":
            yield from (cell for row in block["rows"] for cell in row)
        elif block["kind"] == "facts":
            yield from (cell for _, cell in block["rows"])


def tables(blocks: Iterable[Block]) -> list[Block]:
    """The tables and facts of a sheet."""
    return [block for block in blocks if block["kind"] in ("table", "facts")]


def _in_text(block: Block) -> Block:
    """Of a table that is long the rows that stay in the text, which a terminal shows."""
    if block["kind"] != "table" or not block["note"] or len(block["rows"]) <= LONG:
        return block
    return {**block, "rows": [block["rows"][at] for at in block["keep"]]}


def numbers(answer: Any) -> np.ndarray:
    """All numbers of an answer, and the sums of its arrays along each dimension."""
    return np.concatenate(list(_numbers(answer)))


def _numbers(part: Any) -> Iterator[np.ndarray]:
    if isinstance(part, xr.Dataset):
        for variable in part.variables.values():
            if variable.dtype.kind in "iufb":
                yield np.ravel(variable.values).astype(float)
                yield from (np.ravel(variable.sum(dim).values).astype(float) for dim in variable.dims)
        yield from _numbers(list(part.attrs.values()))
    elif isinstance(part, int | float | np.number):
        yield np.array([float(part)])
    elif isinstance(part, np.ndarray) and part.dtype.kind in "iufb":
        yield np.ravel(part).astype(float)
    elif isinstance(part, dict):
        yield from _numbers(list(part.values()))
    elif isinstance(part, list | tuple) and not hasattr(part, "_fields"):
        for each in part:
            yield from _numbers(each)
    elif (hasattr(part, "_fields") or is_dataclass(part)) and not isinstance(part, pr.Scene):
        kind = type(part)
        derived = [name for name in dir(kind) if isinstance(getattr(kind, name), property)]
        names = part._fields if hasattr(part, "_fields") else [each.name for each in fields(part)]
        yield from _numbers([getattr(part, name) for name in (*names, *derived)])


def test_every_sheet_has_an_answer_here():
    assert sorted(ANSWERS) == WITH_SHEETS


@pytest.mark.parametrize("name", WITH_SHEETS)
def test_cells_are_values_of_the_answer(answers, name):
    answer, blocks = answered(answers, name)
    known, seen = numbers([answer, DERIVED[name](answer) if name in DERIVED else []]), 0
    for cell in cells(blocks):
        for value in (cell.get("raw"), *cell.get("parts", ())):
            if isinstance(value, int | float):
                seen += 1
                # 1e-12: a share that a table has in per cent is multiplied once.
                assert np.isclose(known, value, rtol=1e-12, atol=0.0).any() or value == 0.0, cell
    assert seen > 3


@pytest.mark.parametrize("name", WITH_SHEETS)
def test_a_number_has_the_unit_of_its_head(answers, name):
    """A time in seconds under [ms] would be read as a thousandth of it, on the terminal and in the CSV."""
    for block in (block for block in answered(answers, name)[1] if block["kind"] == "table"):
        for head, cell in (
            (head, cell)
            for row in block["rows"]
            for head, whole in zip(block["heads"], row, strict=True)
            for cell in (whole, *whole.get("ends", {}).values())
        ):
            unit, _ = SHOWN.get(cell.get("unit", "1"), ("", 1.0))  # a cell of another unit has it in its text
            is_bare = unit and cell["raw"] is not None and not cell["text"].endswith(unit)
            assert not is_bare or f"[{unit}]" in head, f"{block['caption']} {head}: {cell['text']} is in {unit}"


# A scene whose PGA stands in its grid too, which is that of the runs.
TWO_AMPLITUDES = scene_text(
    records={"pga": "0.3 g", "window": ["0 s", "6 s"]}, grid={"pga": ["0.4 g", "0.5 g"]}, law="viscous_elastoplastic"
)
# All effects would be compiled where none is named.
ONE_EFFECT = '[effects]\nstrain_rate = {code = "mc2010", length = "0.6 m"}\n'
SAMPLED = '[uncertain]\nsamples = 4\n"building.right.mass" = {distribution = "normal", cov = 0.1}\n'
STATES = [{"name": "blow", "contact_force": "10 kN"}]
OF_UNUSED: MappingProxyType[str, Callable[[], Any]] = MappingProxyType(
    {
        "accuracy": lambda: pr.accuracy(parse_scene(TWO_AMPLITUDES), cases=1, budget=0.2, scipy=False),
        "advise": lambda: pr.advise(parse_scene(TWO_AMPLITUDES)),
        "compare": lambda: pr.compare(parse_scene(TWO_AMPLITUDES), laws=["viscous_elastoplastic", "jankowski"]),
        "damage": lambda: pr.damage(pr.scan(parse_scene(TWO_AMPLITUDES), check_fraction=0.0), states=STATES),
        "effects": lambda: pr.effects(parse_scene(TWO_AMPLITUDES + ONE_EFFECT), repeats=1),
        "simulate": lambda: pr.simulate(parse_scene(TWO_AMPLITUDES)),
        "uncertainty": lambda: pr.uncertainty(parse_scene(TWO_AMPLITUDES + SAMPLED)),
    }
)


@pytest.mark.parametrize("name", OF_UNUSED)
def test_a_key_without_effect_is_stated_where_the_answer_is_read(name):
    """A PGA that `--set` gives beside that of the grid changes no run: whoever reads the answer has to know."""
    blocks = import_module(f"{questions.__name__}.{name}").sheet(OF_UNUSED[name]())
    sentence = "records.pga: no effect: grid.pga gives the amplitudes, and 0.3 g is not among them; the largest, "
    assert sentence in str(blocks)


def test_stiffnesses_and_dampers_are_shown_by_the_kilonewton():
    spring, damper = amount(2.6e7, "N/m"), amount(5e5, "N s/m")
    assert (spring["text"], damper["text"]) == ("26000 kN/m", "500 kN s/m")
    assert (spring["raw"], damper["raw"]) == (2.6e7, 5e5)  # datasets and sheets keep SI


def test_csv_keeps_the_unit_of_a_number_whose_head_has_none():
    values = {"force": amount(7406769.5, "N"), "work": amount(60041.25, "J"), "speed": amount(-0.25, "m/s")}
    lines = csv_text([table("Outputs.", ("output", "value"), [list(pair) for pair in values.items()])]).splitlines()
    assert lines[2:] == ["force,7406.7695 kN", "work,60.04125 kJ", "speed,'-0.25 m/s", ""]


def test_csv_has_no_row_for_a_caption_that_is_not_there():
    blocks = [table("", ["a"], [[number(1.5)]]), table("Second.", ["b"], [[number(2.5)]])]
    assert csv_text(blocks).splitlines() == ["a", "1.5", "", "Second", "b", "2.5", ""]


def test_csv_has_a_column_for_each_end_of_a_range():
    """In full and in the unit of the head, without the marks of the text, which have a column of words."""
    low, high, median = 0.0882712345678901, 0.125, 1.0 / 3.0
    rows = [
        ["left | right", joined(number(low, "m"), number(high, "m")), middle((0.25, median, 0.5), "1")],
        ["right | last", noted(between(0.0, inf, "m"), "*", "none above"), "none"],
        ["unknown", between(nan, nan, "m"), number(nan)],
    ]
    lines = csv_text([table("Gaps.", ["neighbours", "bounds [mm]", "ratio"], rows)]).splitlines()
    assert lines[1:-1] == [
        "neighbours,bounds low [mm],bounds high [mm],bounds note,ratio,ratio low,ratio high",
        f"left | right,88.2712345678901,125.0,,{median!r},0.25,0.5",
        "right | last,0.0,∞,none above,none,,",
        "unknown,,,,,,",
    ]


@pytest.mark.parametrize("name", WITH_SHEETS)
def test_every_end_of_a_range_stands_in_csv_in_full(answers, name):
    written = [cell for row in csv.reader(StringIO(csv_text(answered(answers, name)[1]))) for cell in row]
    assert not [cell for cell in written if re.fullmatch(r"[\d.e-]+(; | to |\s?\()[\d.e-]+.*", cell)]


@pytest.mark.parametrize("name", WITH_SHEETS)
def test_a_number_in_csv_is_that_of_its_text(answers, name):
    """In full, within a third of a text of one digit, 1.5 of 2; a time in s under [ms] is a thousandth."""
    for cell in cells(answered(answers, name)[1]):
        (written,) = list(csv.reader(StringIO(csv_text([table("One.", ["one"], [[cell]])]))))[2][:1]
        shown, full = (re.match(r"'?(?:at least )?([\d.e+-]+)", text) for text in (cell["text"], written))
        if shown and full and "raw" in cell:
            assert float(full[1]) == pytest.approx(float(shown[1]), rel=0.34), cell


@pytest.mark.parametrize("name", WITH_SHEETS)
def test_all_renderers_show_the_same_cells(answers, name, capsys):
    _, blocks = answered(answers, name)
    print_sheet(blocks)
    terminal = capsys.readouterr().out
    model = {"title": "One", "about": "", "signature": [], "author": "", "program": "", "made_from": ""}
    model["sections"] = [{"name": name, "title": name, "blocks": blocks}]
    number_blocks(model["sections"])
    page = page_text(html.page(model))
    printed = "".join(sheet.extract_text() for sheet in PdfReader(BytesIO(pdf.document(model))).pages)
    table = list(csv.reader(StringIO(csv_text(blocks))))
    heads = sum(bool(block["caption"]) + (block["kind"] == "table") for block in tables(blocks))
    assert sum(map(bool, table)) == heads + sum(len(block["rows"]) for block in tables(blocks))
    closed = "".join(printed.split()).replace("\u00ad", "").replace("-", "")
    assert all(cell["text"] in terminal for cell in cells(map(_in_text, blocks)))
    for cell in cells(blocks):
        shown = cell["text"].replace("`", "")
        assert shown.replace("F_E", "FE") in page
        assert "".join(shown.split()).replace("F_E", "FE").replace("-", "") in closed, shown
