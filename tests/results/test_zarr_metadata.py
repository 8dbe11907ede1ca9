"""A Zarr store from elsewhere runs no code: its metadata are read as plain JSON, and checked, before it is opened."""

from __future__ import annotations

import json
import os
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_forms import made_template, pieces
from sentences import refusal
from typer.testing import CliRunner

from pounding_risk.cli import app
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_results, stream_results
from pounding_risk.results.store import store_of


class Trap:
    """An object whose unpickling makes a folder."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


@pytest.fixture
def store(tmp_path) -> Path:
    """A sound store."""
    template = made_template((2, 1, 1, 1, 2, 1))
    target = store_of(template, tmp_path / "results.zarr")
    for block, values in pieces(template):
        target.write(block, values)
    target.finish({"command": "made"})
    return tmp_path / "results.zarr"


def change(store: Path, variable: str, **facts: object) -> None:
    """Change metadata of a variable, in its own file and among those of all."""
    own = store / variable / ".zarray"
    own.write_text(json.dumps(json.loads(own.read_text()) | facts))
    every = json.loads((store / ".zmetadata").read_text())
    every["metadata"][f"{variable}/.zarray"] |= facts
    (store / ".zmetadata").write_text(json.dumps(every))


def refused(store: Path) -> str:
    """Opened in every way there is, the store is refused in these words."""
    first, *others = (
        refusal(opened, store) for opened in (open_results, lambda path: open_results(path, lazy=True), stream_results)
    )
    assert others == [first] * 2 and str(store) in first
    return first


def test_a_sound_store_is_opened_and_one_with_a_codec_by_its_name_is_not(store):
    """Which the library itself does not take."""
    assert isinstance(open_results(store), xr.Dataset)
    change(store, "status", compressor="blosc")
    assert "is not a readable Zarr store" in refused(store)


@pytest.mark.parametrize(
    "codecs",
    [
        {"filters": [{"id": "pickle", "protocol": 5}], "compressor": None},
        {"filters": None, "compressor": {"id": "pickle", "protocol": 5}},
    ],
)
@pytest.mark.parametrize("command", ["summary", "report", "view", "assess", "rerun", "histories", "separations"])
def test_a_pickle_in_a_store_is_not_unpickled(store, codecs, command, tmp_path, monkeypatch):
    """The object of a piece makes a folder where it is unpickled, which is seen first with pickle itself."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "made by a pickle"
    code = pickle.dumps(np.array([Trap(folder)], dtype=object))
    pickle.loads(code)
    folder.rmdir()
    change(store, "status", dtype="|O", shape=[1], chunks=[1], **codecs)
    for piece in (store / "status").glob("[0-9]*"):
        piece.unlink()
    (store / "status" / "0").write_bytes(code)
    assert all(words in refused(store) for words in ("status", "'|O'", "can hold code"))
    done = CliRunner().invoke(app, [command, str(store)])
    assert isinstance(done.exception, SystemExit) and done.exit_code == 2
    assert "status" in done.stderr and "Traceback" not in done.stderr
    assert not folder.exists()


FOREIGN = {
    "a pickle": {"compressor": {"id": "pickle", "protocol": 5}},
    "an unknown codec": {"compressor": {"id": "json2"}},
    "a list for a codec": {"compressor": {"id": ["blosc"]}},
    "a filter": {"filters": [{"id": "vlen-utf8"}]},
    "a pickle as filter": {"filters": {"id": "pickle"}},
    "objects": {"dtype": "|O"},
    "a record with objects": {"dtype": [["a", "<f8"], ["b", "|O"]]},
    "raw bytes": {"dtype": "|V8"},
    "pieces of no length": {"chunks": [0, 1, 1, 1, 1]},
    "half a length": {"shape": [2.5, 1, 1, 2, 1]},
    "a piece of a terabyte": {"shape": [2], "chunks": [1 << 40]},
}


@pytest.mark.parametrize("facts", FOREIGN.values(), ids=FOREIGN)
def test_what_is_not_ours_is_named(store, facts, says):
    change(store, "status", **facts)
    says(refused(store))


def test_metadata_of_a_variable_s_own_file_are_checked_too(store, says):
    """The library reads those of all; another version may read these."""
    own = store / "status" / ".zarray"
    own.write_text(json.dumps(json.loads(own.read_text()) | {"dtype": "|O"}))
    says(refused(store))


@pytest.mark.parametrize("entry", ["../elsewhere/.zarray", "a/b/.zarray", "status/../../x/.zattrs", "status/.zother"])
def test_names_stay_in_the_store(store, entry):
    every = json.loads((store / ".zmetadata").read_text())
    every["metadata"][entry] = every["metadata"]["status/.zarray"]
    (store / ".zmetadata").write_text(json.dumps(every))
    assert "which is no entry of such a store" in refused(store)


def test_links_folders_and_a_third_format_are_refused(store, tmp_path):
    victim = tmp_path / "secret"
    victim.write_bytes(b"secret")
    piece = next((store / "status").glob("[0-9]*"))
    kept = piece.read_bytes()
    piece.unlink()
    piece.symlink_to(victim)
    assert f"status{os.sep}{piece.name} is a symbolic link" in refused(store)
    piece.unlink()
    piece.write_bytes(kept)
    for make, remove, words in (
        (lambda: (store / "linked").symlink_to(tmp_path, target_is_directory=True), "linked", "is a symbolic link"),
        (lambda: (store / "status" / "inner").mkdir(), f"status{os.sep}inner", "is a folder"),
        (lambda: os.mkfifo(store / "pipe"), "pipe", "is no plain file"),
        (lambda: (store / "zarr.json").write_text("{}"), "zarr.json", "is of Zarr's third format"),
    ):
        if remove == "pipe" and not hasattr(os, "mkfifo"):
            continue
        make()
        assert f"{remove} {words}" in refused(store)
        shutil.rmtree(store / remove) if "inner" in remove else (store / remove).unlink()
    open_results(store)


def damages(store: Path):
    """Each metadata file of a store emptied, cut, or of another kind of JSON, and each entry of the table lost."""
    some = {"status", "gap", "record"}  # a case's variable, numbers and texts of an axis; the others are as these
    files = [path.relative_to(store) for path in sorted(store.rglob(".z*")) if path.parent.name in {store.name, *some}]
    for file in files:
        for text in ("", "{", "[]", "7", "null", '"text"', "{}", "[" * 100_000):
            yield f"{file} = {text[:8]!r}", lambda copy, file=file, text=text: (copy / file).write_text(text)
        yield f"{file} away", lambda copy, file=file: (copy / file).unlink()
    keys = json.loads((store / ".zmetadata").read_text())["metadata"]
    for key in (key for key in keys if "/" not in key or key.partition("/")[0] in some):
        yield f"{key} out of the table", lambda copy, key=key: _without(copy, key)


def _without(store: Path, key: str) -> None:
    every = json.loads((store / ".zmetadata").read_text())
    del every["metadata"][key]
    (store / ".zmetadata").write_text(json.dumps(every))


@pytest.mark.complete
def test_damaged_metadata_end_in_a_sentence_or_do_no_harm(store, tmp_path):
    sound = open_results(store)
    refusals = 0
    for words, damage in damages(store):
        copy = tmp_path / "copy.zarr"
        shutil.copytree(store, copy)
        damage(copy)
        try:
            found = open_results(copy)
        except PoundingError as told:
            assert str(copy) in str(told), words
            refusals += 1
        else:
            xr.testing.assert_identical(found, sound)  # a file that the table of all makes superfluous
        shutil.rmtree(copy)
    assert refusals > 25  # of some 85; a variable's own .zattrs and .zgroup are not read
