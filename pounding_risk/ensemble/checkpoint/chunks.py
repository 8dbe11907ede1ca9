"""Chunks of a study on disk: what some batches of its grid give, with a checksum and the study that it belongs to.

Chunks may have any lengths and may overlap: what a batch gives is the same in each.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.files import write_whole
from pounding_risk.ensemble.chunks import Chunk

CHUNK = r"(\d{9,})-(\d{9,})\.npz"
MARK = "mark.json"
NUMBERS = "biufc"  # kinds of numeric dtypes


class Damaged(Exception):
    """A file that is no sound chunk of the study; says why."""


def chunk_name(batches: range) -> str:
    """The file of the chunk of these batches; in a listing, chunks stand in order."""
    return f"{batches.start:09d}-{batches.stop:09d}.npz"


def batches_of(name: str) -> range | None:
    """The batches that a file's name tells; None where it is not a chunk's."""
    found = re.fullmatch(CHUNK, name)
    return range(int(found[1]), int(found[2])) if found else None


def write_chunk(folder: Path, batches: range, chunk: Mapping[str, NDArray[Any]], digest: str) -> None:
    """Write a chunk whole; raises OSError, and ValueError for arrays that are not numbers of these batches."""
    arrays = {name: np.ascontiguousarray(array) for name, array in chunk.items()}
    for name, array in arrays.items():
        if array.dtype.kind not in NUMBERS or array.shape[0] != len(batches):
            raise ValueError(
                f"{name}: {array.dtype} of shape {array.shape} is not one row of numbers a batch of {batches}"
            )

    packed = _packed(batches, arrays, digest)
    write_whole(folder / chunk_name(batches), lambda file: file.write(packed))


def _packed(batches: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> memoryview:
    """The bytes of a chunk's file, made in memory: what a full disk says is then said of one plain write."""
    found = io.BytesIO()
    try:
        with zipfile.ZipFile(found, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(MARK, json.dumps(_mark(batches, arrays, digest)))
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)
    except ValueError as error:
        # An archive with an open entry cannot be closed, and says so in place of the Ctrl-C that left it open.
        if isinstance(error.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
    return found.getbuffer()


def read_chunk(path: Path, digest: str) -> tuple[range, Chunk]:
    """The batches and arrays of a chunk file.

    Raises Damaged for whatever is wrong with it, OSError where it cannot be read.
    """
    if path.is_symlink():
        raise Damaged("it is a symbolic link, and no file of the study")
    raw = path.read_bytes()
    try:
        with np.load(io.BytesIO(raw), allow_pickle=False) as archive:
            mark = json.loads(archive[MARK])
            arrays = {name: archive[name] for name in archive.files if name != MARK}
    except Exception as error:  # what is damaged in an archive may raise anything
        raise Damaged(f"it cannot be read: {type(error).__name__}: {error}") from None
    if not isinstance(mark, dict) or mark.get("study") != digest:
        raise Damaged("it belongs to another study")
    batches = batches_of(path.name)
    if batches is None or [mark.get("start"), mark.get("stop")] != [batches.start, batches.stop]:
        raise Damaged("its name tells other batches than it holds")
    if mark != _mark(batches, arrays, digest):
        raise Damaged("its checksum is another than that of its numbers")
    return batches, arrays


def _mark(batches: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> dict[str, Any]:
    """What a chunk says of itself; the checksum is of names, types, shapes and bytes."""
    checksum = hashlib.blake2b(digest_size=32)
    for name in sorted(arrays):
        array = arrays[name]
        checksum.update(json.dumps([name, array.dtype.str, array.shape]).encode())
        checksum.update(np.ascontiguousarray(array).data)
    return {"study": digest, "start": batches.start, "stop": batches.stop, "checksum": checksum.hexdigest()}
