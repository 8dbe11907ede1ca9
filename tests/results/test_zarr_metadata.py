"""A Zarr store from elsewhere runs no code: its metadata are read as plain JSON, and checked, before it is opened."""

import json
import os
import pickle
import shutil
from collections.abc import Iterator
from pathlib import Path

import commands
import numpy as np
import pytest
import xarray as xr
from made_forms import made_template, pieces
from sentences import refusal
from zarr_metadata import changed

from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_results, stream_results
from pounding_risk.results.store import store_of


class Trap:
    """An object whose unpickling makes a folder."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Path:
    """A sound store."""
    template = made_template((2, 1, 1, 1, 2, 1))
    target = store_of(template, tmp_path_factory.mktemp("sound") / "results.zarr")
    for block, values in pieces(template):
        target.write(block, values)
    target.finish({"command": "made"})
    return target.target


@pytest.fixture
def store(sound, tmp_path) -> Path:
    """A copy of the sound store, to be changed."""
    return Path(shutil.copytree(sound, tmp_path / "results.zarr"))


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
    changed(store, "status/.zarray", compressor="blosc")
    assert "is not a readable Zarr store" in refused(store)


@pytest.mark.parametrize(
    "codecs",
    [
        {"filters": [{"id": "pickle", "protocol": 5}], "compressor": None},
        {"filters": None, "compressor": {"id": "pickle", "protocol": 5}},
    ],
)
def test_a_pickle_in_a_store_is_not_unpickled(store, codecs, tmp_path, monkeypatch):
    """The object of a piece makes a folder where it is unpickled, which is seen first with pickle itself."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "made by a pickle"
    code = pickle.dumps(np.array([Trap(folder)], dtype=object))
    pickle.loads(code)
    folder.rmdir()
    changed(store, "status/.zarray", dtype="|O", shape=[1], chunks=[1], **codecs)
    for piece in (store / "status").glob("[0-9]*"):
        piece.unlink()
    (store / "status" / "0").write_bytes(code)
    assert all(words in refused(store) for words in ("status", "'|O'", "can hold code"))
    for command in ("summary", "report", "view", "assess", "rerun", "histories", "separations"):
        done = commands.run(command, store)
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
    changed(store, "status/.zarray", **facts)
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


def damages(store: Path) -> Iterator[tuple[str | Path, str | None]]:
    """Each metadata file empty, cut, of another kind of JSON or away (None), and each entry of the table lost."""
    some = {"status", "gap", "record"}  # a case's variable, numbers and texts of an axis; the others are as these
    files = [path.relative_to(store) for path in sorted(store.rglob(".z*")) if path.parent.name in {store.name, *some}]
    for file in files:
        for text in ("", "{", "[]", "7", "null", '"text"', "{}", "[" * 100_000, None):
            yield file, text
    every = json.loads((store / ".zmetadata").read_text())
    for key in (key for key in every["metadata"] if "/" not in key or key.partition("/")[0] in some):
        metadata = {other: facts for other, facts in every["metadata"].items() if other != key}
        yield ".zmetadata", json.dumps(every | {"metadata": metadata})


@pytest.mark.complete
def test_damaged_metadata_end_in_a_sentence_or_do_no_harm(sound, store):
    whole, refusals = open_results(sound), 0
    for file, text in damages(sound):
        kept = (store / file).read_bytes()
        (store / file).unlink() if text is None else (store / file).write_text(text)
        try:
            found = open_results(store)
        except PoundingError as told:
            assert str(store) in str(told), (file, text)
            refusals += 1
        else:
            xr.testing.assert_identical(found, whole)  # a file that the table of all makes superfluous
        (store / file).write_bytes(kept)
    assert refusals > 25  # of some 85; a variable's own .zattrs and .zgroup are not read
