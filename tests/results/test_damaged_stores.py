"""Damaged Zarr stores of nine kinds of dataset: each reader ends in a sentence that names the store, or in an answer.

Copies of a sound store are damaged by edits of its files, as the format has them: metadata as JSON, a file a piece.
"""

import json
import random
import re
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from axes import pair_text
from scenes import two_records, yielding_row
from sentences import refusal
from uncertain import uncertain_text
from zarr_metadata import changed

import pounding_risk as pr
from pounding_risk._common.files import checksum
from pounding_risk.errors import PoundingError
from pounding_risk.questions.rerun import compared
from pounding_risk.results.files import open_results, save
from pounding_risk.results.provenance import recorded
from pounding_risk.scene.reader import parse_scene

pytestmark = pytest.mark.complete

pytest.importorskip("zarr")
KINDS = ("pair", "storeys", "samples", "axes", "simulate", "histories", "compare", "spectra", "damage")
SCANS = KINDS[:4]
VALUES = (None, 7, "", [1, 2], {"a": 1}, "[1, 2]", '{"a": 1}', True, "[" * 3000, "\ud800", 1e308, ["x", None], ...)
ARRAY = {
    "dtype": ("<f4", ">f8", "<i8", "|b1", "<U3", "|O", "<M8[ns]"),
    "shape": ([], [10**12], [0], [2, 2], None),
    "chunks": ([], [10**9], [1], [2, 2]),
    "fill_value": (0, None, "x", [1], 1e999),
    "compressor": (None, {"id": "zlib", "level": 1}),
    "order": (7, "F"),
}
Damage = Callable[[Path], object]


@pytest.fixture(scope="module")
def stores(tmp_path_factory) -> Path:
    """A folder with a sound store of each kind."""
    folder = tmp_path_factory.mktemp("sound")
    pair, street = map(parse_scene, (two_records(law="jankowski", stiffness="2e9 N/m^1.5"), yielding_row("3 s")))
    made = {"pair": pr.scan(pair, check_fraction=0.4), "storeys": pr.scan(street, check_fraction=0.0)}
    made["samples"] = pr.scan(parse_scene(uncertain_text()))
    made["axes"] = pr.scan(parse_scene(pair_text({"building.left.period": ["0.3 s", "0.5 s"]})))
    made |= {"simulate": pr.simulate(street), "compare": pr.compare(pair, laws=["jankowski", "linear"])}
    made |= {"spectra": pr.spectra(pair, num=3), "damage": pr.damage(made["storeys"])}
    for kind, dataset in made.items():
        pr.convert(save(dataset, folder / f"{kind}.nc"), folder / f"{kind}.zarr")
    pr.histories(folder / "pair.nc", folder / "h.nc", gaps=[0.01], pgas=["0.3 g"], records=["RSN6-180"])
    pr.convert(folder / "h.nc", folder / "histories.zarr")
    return folder


def called(store: Path, name: str, other: str) -> None:
    """Give a variable another name, or take it away where that is empty, without a trace in the store's mark."""
    every = json.loads((store / ".zmetadata").read_text())
    documents = every["metadata"]
    for part in (".zarray", ".zattrs"):
        document = documents.pop(f"{name}/{part}")
        documents |= {f"{other}/{part}": document} if other else {}
    mark = documents[".zattrs"]["pounding_risk_variables"]
    mark[mark.index(name) : mark.index(name) + 1] = [other] if other else []
    shutil.move(store / name, store / other) if other else shutil.rmtree(store / name)
    (store / ".zmetadata").write_text(json.dumps(every))
    (store / ".zattrs").write_text(json.dumps(documents[".zattrs"]))


def piece(store: Path, name: str, damage: Callable[[bytes], bytes]) -> None:
    """Change the bytes of a variable's first piece."""
    file = min(file for file in (store / name).iterdir() if not file.name.startswith("."))
    file.write_bytes(damage(file.read_bytes()))


def damages(store: Path) -> Iterator[tuple[str, Damage]]:
    """Each with words for it."""
    documents = json.loads((store / ".zmetadata").read_text())["metadata"]
    noise = np.random.default_rng(30)
    for name in (name.removesuffix("/.zarray") for name in documents if name.endswith("/.zarray")):
        yield f"{name} away", lambda one, name=name: called(one, name, "")
        yield f"{name} renamed", lambda one, name=name: called(one, name, f"other_{name}")
        yield f"{name} cut", lambda one, name=name: piece(one, name, lambda raw: raw[: len(raw) // 2])
        yield f"{name} noise", lambda one, name=name: piece(one, name, lambda raw: raw[:16] + noise.bytes(len(raw)))
        for key, values in ARRAY.items():
            for value in values:
                yield (
                    f"{name}: {key} {value}",
                    lambda one, name=name, key=key, value=value: changed(one, f"{name}/.zarray", **{key: value}),
                )
    for document in (name for name in documents if name.endswith(".zattrs")):
        for key in documents[document]:
            for value in VALUES:
                yield (
                    f"{document}: {key} = {value!r:.30}",
                    lambda one, document=document, key=key, value=value: changed(one, document, **{key: value}),
                )


def readers(store: Path, kind: str, out: Path) -> dict[str, Callable[[], object]]:
    """What reads a store of a kind, short of solving and drawing; files go to the folder ``out``."""
    found: dict[str, Callable[[], object]] = {"convert": lambda: pr.convert(store, out / "c.nc")}
    if kind in SCANS:
        found |= {"assess": lambda: pr.assess(store), "view": lambda: pr.view(store, out / "v.html")}
        found["rerun"] = lambda: recorded(open_results(store), store)
    if kind in (*SCANS, "compare"):
        found["summary"] = lambda: pr.summary(store)
    if kind == "samples":
        found["uncertainty"] = lambda: pr.uncertainty(store)
    if kind == "simulate":
        found["animation"] = lambda: pr.draw(store, animation=out / "a.html")
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_store_is_a_sentence_or_an_answer(stores, kind, tmp_path, monkeypatch):
    """Some damages of each kind by a seed, and each reader; what is refused leaves no file behind."""
    monkeypatch.setattr("plotly.offline.get_plotlyjs", lambda: "Plotly")
    warnings.simplefilter("error", RuntimeWarning)
    refused = 0
    for words, damage in random.Random(kind).sample(list(damages(stores / f"{kind}.zarr")), 9):
        store, out = tmp_path / "d.zarr", tmp_path / "out"
        shutil.copytree(stores / f"{kind}.zarr", store)
        damage(store)
        for command, read in readers(store, kind, out).items():
            out.mkdir()
            try:
                read()
            except PoundingError as told:
                assert str(store) in str(told), (words, command)
                assert not list(out.iterdir()), (words, command)
                refused += 1
            except Exception as error:
                error.add_note(f"{command} of {kind} with {words}")
                raise
            shutil.rmtree(out)
        shutil.rmtree(store)
    assert refused


@pytest.fixture
def copied(stores, tmp_path) -> Callable[[str], Path]:
    """Gives a copy of a sound store of a kind."""
    return lambda kind: Path(shutil.copytree(stores / f"{kind}.zarr", tmp_path / f"{kind}.zarr"))


OPENED = {
    "a factor": ("pair", "gap/.zattrs", "scale_factor", 2.0),
    "a unit of dates": ("pair", "gap/.zattrs", "units", "days since 2000-01-01"),
    "an attribute that is nothing": ("pair", ".zattrs", "title", None),
    "letters that do not exist": ("pair", ".zattrs", "title", "\ud800"),
    "a number of coordinates": ("pair", "status/.zattrs", "coordinates", 7),
    "a dimension twice": ("pair", "status/.zattrs", "_ARRAY_DIMENSIONS", ["gap", "gap"]),
    "a length of a million millions": ("pair", "gap/.zarray", "shape", [10**12]),
    "no shape": ("spectra", "left_damping/.zarray", "shape", ...),
    "axes without keys": ("axes", ".zattrs", "scene_axes", '[{"keys": 7, "values": []}]'),
    "a variant without a name": ("axes", ".zattrs", "scene_variants", '{"tables": [[1]], "attributes": []}'),
    "variants of other axes": ("axes", ".zattrs", "scene_variants", '{"tables": [["a", [9], 1]], "attributes": []}'),
    "variants without attributes": ("axes", ".zattrs", "scene_variants", "{}"),
    "periods in kg": ("axes", "building.left.period/.zattrs", "units", "kg"),
}


@pytest.mark.parametrize("case", OPENED)
def test_what_was_changed_is_told_when_a_store_is_opened(copied, case, says):
    kind, document, key, value = OPENED[case]
    store = copied(kind)
    changed(store, document, **{key: value})
    # The libraries' own words are not ours to keep.
    says(re.sub(r"position \d+|KeyError: '\w+'", "...", refusal(open_results, store)))


def test_what_is_no_store_s_value_is_not_taken_for_one(copied, tmp_path):
    """A fill value hides no number, a piece of another size is told late, and so are letters that do not exist."""
    store = copied("pair")
    sound = open_results(store)
    changed(store, "impact_count/.zarray", fill_value=0)
    assert open_results(store)["impact_count"].dtype == np.int32
    assert open_results(store)["impact_count"].equals(sound["impact_count"])
    changed(store, "impulse/.zarray", dtype="|b1")
    for read in (pr.summary, lambda one: pr.convert(one, tmp_path / "c.nc")):
        assert "is not a readable Zarr store" in refusal(read, store)
    assert not (tmp_path / "c.nc").exists()
    changed(store, "record/.zarray", compressor=None)
    piece(store, "record", lambda _: np.full(sound["record"].dtype.itemsize // 2, 0x12FFFE00, "<u4").tobytes())
    assert "is not a readable Zarr store" in refusal(open_results, store)


ENTRIES = {
    "overrides": "true",
    "notes": "[7]",
    "motions_sha256": '{"a": []}',
    "versions": '{"numpy": {}}',
    "records": '[{"name": "RSN6-180", "event": 7}]',
}


@pytest.mark.parametrize("name", ENTRIES)
def test_entries_of_another_kind_are_told_by_every_reader(copied, tmp_path, name, says):
    store = copied("pair")
    changed(store, ".zattrs", **{name: ENTRIES[name]})
    read = readers(store, "pair", tmp_path)
    says([f"{command}: {refusal(read[command])}" for command in read if command != "convert"])


def test_lost_names_are_told_as_what_they_are(copied, says):
    axes, pair, samples = (copied(kind) for kind in ("axes", "pair", "samples"))
    called(axes, "impact_count", "other")
    called(samples, "first_impact_time", "other")
    results = open_results(pair)
    flags = results["sensitive"].assign_attrs(flag_meanings=[1, 2])
    says(
        refusal(pr.summary, axes),
        refusal(pr.assess, results.rename_dims(interface="other")),
        refusal(pr.assess, results.reset_coords("contact_point_level")),
        refusal(pr.assess, results.assign(sensitive=flags)),
        refusal(pr.scan, parse_scene(uncertain_text(samples=6)), out=samples),
    )


def test_runs_and_cases_that_are_damaged_are_told(copied, tmp_path, says):
    run, spectra = (open_results(copied(kind)) for kind in ("simulate", "spectra"))
    damaged = (
        run.assign_attrs(pga="[1, 2]"),
        run.assign_coords(time=-np.inf * run["time"]),
        run.rename(time="t"),
        run.assign_coords(contact_point_level=run["contact_point_level"] * np.inf),
    )
    says([refusal(pr.draw, one, animation=tmp_path / "a.html") for one in damaged])
    assert repr(damaged[0].pounding)
    twice = spectra.assign_coords(percentile=spectra["percentile"] * 0.0)
    says(
        refusal(twice.pounding.figure),
        refusal(spectra.drop_vars("percentile").pounding.figure),
        refusal(spectra.isel(percentile=0).pounding.figure),
        refusal(open_results(copied("histories")).assign_attrs(scene_resolved="[[1]]").pounding.case),
        refusal(open_results(copied("damage")).rename(im="other").pounding.figure),
    )


def test_damaged_numbers_overflow_without_a_warning(copied):
    warnings.simplefilter("error", RuntimeWarning)
    pair, samples = open_results(copied("pair")), open_results(copied("samples"))
    pr.summary(pair.assign_coords(building_period=pair["building_period"] * np.nan))
    samples["peak_closing_free"].values.flat[0] = -np.inf
    pr.uncertainty(samples)
    assert not compared(pair, pair.assign(impulse=pair["impulse"] * 0.0 + 1e-320), []).same


def test_a_report_beside_a_comparison_is_written(stores, tmp_path):
    page = pr.report(stores / "pair.zarr", tmp_path / "r.html", also=[stores / "compare.zarr"]).read_text("utf-8")
    assert checksum(stores / "pair.zarr") in page


@pytest.mark.parametrize("damage", ["scene_resolved", "options", "building_damping", "peak_displacement_free"])
def test_every_sentence_names_the_store(copied, damage, tmp_path):
    """Of attributes and variables that are missed late, where the dataset is known and not its file."""
    store = copied("storeys")
    if damage == "scene_resolved":
        changed(store, ".zattrs", scene_resolved=...)
    elif damage == "options":
        changed(store, ".zattrs", options="")
    elif damage == "building_damping":
        piece(store, damage, lambda raw: np.full(len(raw) // 8, np.nan).tobytes())
    else:
        called(store, damage, "")
    read = readers(store, "storeys", tmp_path)["rerun" if damage == "options" else "view"]
    with pytest.raises(PoundingError, match=re.escape(str(store))):
        read()
