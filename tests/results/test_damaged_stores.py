"""Damaged Zarr stores of nine kinds of dataset: each reader ends in a sentence that names the store, or in an answer.

Copies of a sound store are damaged by edits of its files, as the format has them: metadata as JSON, a file a piece.
"""

from __future__ import annotations

import json
import random
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from axes import pair_text
from scenes import scene_text, single, storeyed, two_records
from uncertain import uncertain_text

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_results, save
from pounding_risk.results.provenance import recorded
from pounding_risk.scene.reader import parse_scene

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
    buildings = (
        storeyed("A", "200 t", "200 MN/m", "3.6 m", storeys=2, storey_strengths="900 kN"),
        storeyed("B", "180 t", "400 MN/m", storeys=2, storey_strengths="900 kN"),
        single("C", "150 t", "0.25 s", height="6 m"),
    )
    records = {"names": ["RSN6-180", "NAPA-HNE"], "window": ["0 s", "3 s"], "pga": "0.5 g"}
    row = scene_text(*buildings, law="linear", records=records, effects={"inelastic_storeys": {}}, gap="10 mm")
    row += '\n[[damage]]\nname = "slight"\ndrift = "0.5 %"\n'
    pair, street = parse_scene(two_records(law="jankowski", stiffness="2e9 N/m^1.5")), parse_scene(row)
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


def changed(store: Path, document: str, key: str, value: Any) -> None:
    """Change an entry of a document of metadata, in its own file and among those of all; ``...`` takes it away."""
    every = json.loads((store / ".zmetadata").read_text())
    every["metadata"][document] |= {key: value} if value is not ... else {}
    if value is ...:
        every["metadata"][document].pop(key)
    (store / ".zmetadata").write_text(json.dumps(every))
    (store / document).write_text(json.dumps(every["metadata"][document]))


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
                    lambda one, name=name, key=key, value=value: changed(one, f"{name}/.zarray", key, value),
                )
    for document in (name for name in documents if name.endswith(".zattrs")):
        for key in documents[document]:
            for value in VALUES:
                yield (
                    f"{document}: {key} = {value!r:.30}",
                    lambda one, document=document, key=key, value=value: changed(one, document, key, value),
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_store_is_a_sentence_or_an_answer(stores, kind, tmp_path, monkeypatch):
    """Nine damages of each kind by a seed, and each reader; what is refused leaves no file behind."""
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
