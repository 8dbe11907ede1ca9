"""A damaged results file ends every command that reads one with a sentence that names the damage, or does no harm.

Mutants are made one by one: every variable, coordinate and attribute away, every attribute of another kind, every
dimension under another name, every axis with a label that cannot be. A sample of them, by a seed, is tried each time,
and a larger one by the complete tests.
"""

import random
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_row import STREET, made_row
from scenes import two_records, yielding_row
from sentences import refusal
from sweeps import sweep

from pounding_risk.assessment.assess import assess
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.questions.rerun import compared, rerun
from pounding_risk.reports import report
from pounding_risk.reports.drawings import draw
from pounding_risk.reports.explorer import view
from pounding_risk.results.check import COORDINATES, VARIABLES, check_scan, missing_named
from pounding_risk.results.files import open_results, save
from pounding_risk.results.provenance import recorded
from pounding_risk.results.summary import summary
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.convert import convert
from pounding_risk.studies.histories import histories

Mutants = Iterator[tuple[str, Callable[[xr.Dataset], xr.Dataset]]]
PAIR = two_records(law="jankowski", stiffness="2e9 N/m^1.5")
PAIR = PAIR.replace("[grid]", '[grid]\nyield_force = ["100 kN", "inf"]')
SHORT = (*STREET[1:3], STREET[5])
OTHER_KINDS = (7, "", "[1, 2]", '{"a": 1}', np.array([1.0, np.nan]))


@pytest.fixture(scope="module")
def sound() -> dict[str, xr.Dataset]:
    """A pair's scan, and one of a row: floors against columns, and a rigid neighbour."""
    return {"pair": scan(parse_scene(PAIR), check_fraction=0.4), "row": made_row(records=2, street=SHORT)}


@pytest.fixture(autouse=True)
def neither_scripts_nor_pictures(monkeypatch) -> None:
    """A word for Plotly's 4 MB; and for each picture, whose drawing takes as long again."""
    monkeypatch.setattr("plotly.offline.get_plotlyjs", lambda: "Plotly")
    for place in ("reports.document", "figures.style"):
        monkeypatch.setattr(f"pounding_risk.{place}.svg_text", lambda figure: "<svg/>")


def mutants(dataset: xr.Dataset) -> Mutants:
    """Each with words for it."""
    for name in dataset.variables:
        yield f"{name} away", lambda one, name=name: one.drop_vars(name)
        yield f"{name} as texts", lambda one, name=name: _with_values(one, name, one[name].astype(str).values)
        for attr in dataset[name].attrs.keys() - {"long_name"}:  # a caption that may be anything
            yield f"{name}: {attr} away", lambda one, name=name, attr=attr: _with_attr(one, name, attr, None)
            for value in (7, "days since then"):
                yield (
                    f"{name}: {attr} = {value!r}",
                    lambda one, name=name, attr=attr, value=value: _with_attr(one, name, attr, value),
                )
    for attr in dataset.attrs:
        yield f"attribute {attr} away", lambda one, attr=attr: _without(one, attr)
        for value in OTHER_KINDS:
            yield f"attribute {attr} = {value!r}", lambda one, attr=attr, value=value: one.assign_attrs({attr: value})
    for dim in dataset.dims:
        yield f"dimension {dim} renamed", lambda one, dim=dim: one.rename({dim: f"other_{dim}"})
        yield f"dimension {dim} without labels", lambda one, dim=dim: one.drop_vars(dim, errors="ignore")
        yield f"dimension {dim} empty", lambda one, dim=dim: one.isel({dim: slice(0, 0)})
        yield f"dimension {dim} summed", lambda one, dim=dim: one.sum(dim, keep_attrs=True, numeric_only=False)
    yield from _label_mutants(dataset)


def _label_mutants(dataset: xr.Dataset) -> Mutants:
    for axis in ("gap", "yield_force", "pga", "period", "building_period", "record_pga", "floor_level"):
        if axis in dataset.coords:
            for value in (np.nan, np.inf, -1.0, 0.0):
                values = np.array(dataset[axis].values, dtype=float)
                values.flat[0] = value
                yield f"{axis} with {value}", lambda one, axis=axis, values=values: _with_values(one, axis, values)
    for axis in ("record", "polarity", "contact_model", "building", "interface", "contact_point_kind"):
        if axis in dataset.coords:
            for label in ("", "../../etc", "�"):
                labels = np.full(dataset[axis].shape, label)
                yield f"{axis} all {label!r}", lambda one, axis=axis, labels=labels: _with_values(one, axis, labels)
    if "contact_point_interface" in dataset.coords:
        far = np.full(dataset["contact_point_interface"].shape, 99)
        yield "contact points elsewhere", lambda one: _with_values(one, "contact_point_interface", far)


def _with_values(one: xr.Dataset, name: str, values: np.ndarray) -> xr.Dataset:
    changed = (one[name].dims, values, one[name].attrs)
    return one.assign_coords({name: changed}) if name in one.coords else one.assign({name: changed})


def _with_attr(one: xr.Dataset, name: str, attr: str, value: object) -> xr.Dataset:
    attrs = {key: told for key, told in one[name].attrs.items() if key != attr}
    attrs |= {} if value is None else {attr: value}
    changed = (one[name].dims, one[name].values, attrs)
    return one.assign_coords({name: changed}) if name in one.coords else one.assign({name: changed})


def _without(one: xr.Dataset, attr: str) -> xr.Dataset:
    found = one.copy()
    del found.attrs[attr]
    return found


def readers(results: xr.Dataset | Path, folder: Path, kind: str) -> dict[str, Callable[[], object]]:
    """Everything that reads the results of a scan, short of solving; the slow ones last."""
    dataset = results if isinstance(results, xr.Dataset) else None
    read = {
        "assess": lambda: assess(results),
        "summary": lambda: summary(results),
        "view": lambda: view(results, folder / "v.html"),
        "rerun and histories": lambda: recorded(open_results(results) if dataset is None else dataset, folder),
        "report": lambda: report(results, folder / "r.html"),
    }
    if kind == "row":
        read["draw"] = lambda: draw(results, elevation=folder / "e.svg")
    return read


SHARES = sweep([("pair", 0.04), ("pair", 0.4), ("row", 0.4)], ("pair", 0.04))


@pytest.mark.parametrize(("kind", "share"), SHARES)
def test_no_mutant_ends_in_a_traceback(sound, kind, share, tmp_path):
    """Any other exception than PoundingError fails here, with the mutant and the command in its notes.

    Pictures take a second each where nothing is refused: each eighth mutant that all others accept is drawn.
    """
    tried, refused, accepted = 0, 0, 0
    made = list(mutants(sound[kind]))
    for words, damage in random.Random(kind).sample(made, int(share * len(made))):
        try:
            damaged = damage(sound[kind])
        except (TypeError, ValueError):  # texts cannot be summed: there is no such file
            continue
        tried, refusals = tried + 1, 0
        for command, read in readers(damaged, tmp_path, kind).items():
            accepted += command == "report" and not refusals
            if command in ("report", "draw") and not refusals and accepted % 8:
                continue
            try:
                read()
            except PoundingError as error:
                # A row that was made by hand has no scene that could be run.
                refusals += not (kind == "row" and command.startswith("rerun"))
                assert str(error), (words, command)
            except Exception as error:
                error.add_note(f"{command} of a {kind} with {words}")
                raise
        refused += refusals > 0
    assert tried > 400 * share and refused > tried / 3


@pytest.fixture(scope="module")
def storeys() -> xr.Dataset:
    """A row whose storeys yield and whose floors meet columns, with a state of damage: what a report reads most of."""
    return scan(parse_scene(yielding_row("6 s")), check_fraction=0.0)


NEEDED = ["peak_closing_free", "building_mass", "peak_storey_shear_free", "peak_contact_force"]


@pytest.mark.parametrize(
    ("kind", "share"), sweep([("pair", 0.4), ("storeys", 0.0), ("storeys", 0.4)], ("storeys", 0.0))
)
def test_a_report_without_one_variable_is_a_page_or_a_sentence(sound, storeys, kind, share, tmp_path):
    """Those that it needs and some others are left out in turn; the sentence names it, or what stands beside it."""
    dataset = storeys if kind == "storeys" else sound[kind]
    refused, names = {}, sorted(map(str, dataset.variables))
    for name in {*NEEDED, *random.Random(kind).sample(names, int(share * len(names)))}:
        try:
            report(dataset.drop_vars(name), tmp_path / "r.html")
        except PoundingError as told:
            refused[name] = str(told)
    assert refused.keys() >= {*NEEDED}
    assert "no variable peak_storey_shear_free" in refused["peak_storey_shear_free"]
    assert all(name in words for name, words in refused.items()), refused


def test_a_page_to_explore_without_one_variable_is_a_page_or_a_sentence(storeys, tmp_path):
    """Of a dataset in memory too, which no file was checked for."""
    refused, names = set(), sorted(map(str, storeys.variables))
    for name in {*NEEDED, *random.Random("view").sample(names, 12)}:
        try:
            view(storeys.drop_vars(name), tmp_path / "v.html")
        except PoundingError:
            refused.add(name)
    assert refused >= {"peak_closing_free"}


def test_an_error_of_a_key_that_is_no_variable_stays_one():
    with pytest.raises(KeyError, match="mine"), missing_named():
        raise KeyError("mine")


@pytest.mark.parametrize("share", sweep([0.02, 0.4], 0.02))
def test_what_a_second_run_is_held_against_may_be_damaged(sound, share):
    """What is missing, and every other difference, is told of the damaged file; of the sound one there is none."""
    assert compared(sound["pair"], sound["pair"], []).same
    made = list(mutants(sound["pair"]))
    for words, damage in random.Random(2).sample(made, int(share * len(made))):
        with suppress(TypeError, ValueError):
            damaged = damage(sound["pair"])
        with suppress(PoundingError):
            found = compared(damaged, sound["pair"], [])
            changed = ("away", "as texts", "renamed", "empty", "summed", "with", "all ")
            if " = " not in words and ": " not in words and any(word in words for word in changed):
                assert not found.same or words.startswith("attribute") or _is_the_same(damaged, sound["pair"]), words


def _is_the_same(one: xr.Dataset, other: xr.Dataset) -> bool:
    return one.drop_attrs().identical(other.drop_attrs())


def test_what_is_declared_is_what_a_scan_writes(sound):
    """Dimensions, units and kinds of every variable that is declared, in a pair's scan and in a row's.

    A new output need not be declared: what is declared is what commands read.
    """
    for dataset in sound.values():
        check_scan(dataset, "sound")
    declared = VARIABLES | COORDINATES
    pair = sound["pair"]
    for name, variable in pair.variables.items():
        if name in declared:
            assert set(variable.dims) == set(declared[name].dims), name
            assert variable.attrs.get("units") == declared[name].unit, name


DAMAGES: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "one building": lambda one: one.rename(building="house"),
    "another unit": lambda one: _with_attr(one, "peak_closing_free", "units", "mm"),
    "a gap that is NaN": lambda one: _with_values(one, "gap", np.array([np.nan, 0.01, 0.02, 0.04])),
    "no records": lambda one: _without(one, "records"),
    "no scene": lambda one: _without(one, "scene_resolved"),
    "no closings": lambda one: one.drop_vars("peak_closing_free"),
    "records that are no JSON": lambda one: one.assign_attrs(records="[]x"),
    "another scene than its digest's": lambda one: one.assign_attrs(scene_resolved="[scene"),
    "a scene that is no TOML": lambda one: _without(one, "scene_sha256").assign_attrs(scene_resolved="[scene"),
    "steps that are no texts": lambda one: one.assign_attrs(processing='{"RSN6-180": [true]}'),
    "codes without meanings": lambda one: _with_attr(one, "status", "flag_meanings", "fine"),
    "no record": lambda one: one.isel(record=slice(0, 0)),
    "counts as texts": lambda one: _with_values(one, "impact_count", one["impact_count"].astype(str).values),
    "several damages": lambda one: _with_attr(_without(one, "records"), "gap", "units", "mm"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_the_damage_is_named(sound, damage, says, tmp_path):
    """Of a file, which is named, as of a dataset in memory; the libraries' own words are not ours to keep."""
    damaged = DAMAGES[damage](sound["pair"])
    file = save(damaged, tmp_path / "results.nc")
    told, expected = (re.sub(r"<U\d+|\(Expected .*\)\)", "...", refusal(assess, one)) for one in (file, damaged))
    assert told.replace(str(file), "the dataset") == expected
    says(told)


PLACES = [("cut", 0.5), ("overwritten", 0.1), ("overwritten", 0.5), ("overwritten", 0.9)]


@pytest.mark.parametrize(("damage", "place"), sweep(PLACES, ("cut", 0.5), ("overwritten", 0.1)))
def test_bytes_that_are_damaged_are_told_or_do_no_harm(sound, place, damage, tmp_path):
    """A netCDF file cut off, or with a thousand bytes of noise: whatever HDF5 raises of it."""
    file = tmp_path / "results.nc"
    save(sound["pair"], file)
    raw = bytearray(file.read_bytes())
    at = int(place * len(raw))
    if damage == "cut":
        del raw[at:]
    else:
        raw[at : at + 1000] = np.random.default_rng(at).bytes(min(1000, len(raw) - at))
    file.write_bytes(raw)
    for read in readers(file, tmp_path, "pair").values():
        try:
            read()
        except PoundingError as told:
            assert str(file) in str(told) or str(tmp_path) in str(told)
            continue
        assert damage == "overwritten"


@pytest.mark.complete
def test_damaged_bytes_are_a_sentence_before_any_work(sound, tmp_path, monkeypatch):
    """Single bytes of a file's compressed values changed: what reads them late says what all others say."""
    whole = save(sound["pair"], tmp_path / "whole.nc").read_bytes()
    monkeypatch.setattr("pounding_risk.questions.rerun.scan", lambda *_, **__: pytest.fail("damage was seen too late"))
    read = {
        "convert": lambda file: convert(file, tmp_path / "copy.zarr"),
        "rerun": rerun,
        "histories": lambda file: histories(file, tmp_path / "runs.nc", largest_of="peak_contact_force"),
    }
    refused = dict.fromkeys(read, 0)
    draw_of = np.random.default_rng(31)
    for number in range(30):
        file, at = tmp_path / f"damaged{number}.nc", int(draw_of.integers(len(whole)))
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        try:
            open_results(file)
            continue  # a byte that nothing needs
        except PoundingError as error:
            if "HDF error" not in str(error):
                continue
            for command, call in read.items():
                try:
                    call(file)
                except PoundingError as error:
                    assert f"{file.name}: is not a readable netCDF file" in str(error)
                    refused[command] += 1
                else:
                    assert command == "histories"  # it reads what it needs
    assert min(refused.values()) >= 2, refused
    assert not (tmp_path / "copy.zarr").exists()
