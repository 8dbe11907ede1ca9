"""Files of chunks: the results of a range of batches, with a checksum and the digest of the scan's identity."""

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
    """Raised for a file that is no sound chunk of the scan, with the reason."""


def chunk_name(batches: range) -> str:
    """The file name of the chunk of these batches; names sort in the order of the batches."""
    return f"{batches.start:09d}-{batches.stop:09d}.npz"


def batches_of(name: str) -> range | None:
    """The batches of a chunk from its file name; None for any other name."""
    numbers = re.fullmatch(CHUNK, name)
    return range(int(numbers[1]), int(numbers[2])) if numbers else None


def write_chunk(folder: Path, batches: range, chunk: Mapping[str, NDArray[Any]], digest: str) -> None:
    """Write a chunk atomically; raises OSError, and ValueError for arrays that are not numbers of these batches."""
    arrays = {name: np.ascontiguousarray(array) for name, array in chunk.items()}
    for name, array in arrays.items():
        if array.dtype.kind not in NUMBERS or array.shape[0] != len(batches):
            raise ValueError(
                f"{name}: {array.dtype} of shape {array.shape} is not one row of numbers a batch of {batches}"
            )

    packed = _packed(batches, arrays, digest)
    write_whole(folder / chunk_name(batches), lambda file: file.write(packed))


def _packed(batches: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> bytes:
    """The bytes of a chunk file, made in memory, so that errors of a full disk come from one plain write."""
    packed = io.BytesIO()
    try:
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(MARK, json.dumps(_mark(batches, arrays, digest)))
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)
    except ValueError as error:
        # An archive with an open entry cannot be closed: this error hides the Ctrl-C that left it open.
        if isinstance(error.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
    return packed.getvalue()  # not its buffer: Python 3.13 prints a fault of a stream that an error leaves with one


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
    except Exception as error:  # a damaged archive may raise anything
        raise Damaged(f"it cannot be read: {type(error).__name__}: {error}") from None
    if not isinstance(mark, dict) or mark.get("study") != digest:
        raise Damaged("it belongs to another study")
    batches = batches_of(path.name)
    if batches is None or [mark.get("start"), mark.get("stop")] != [batches.start, batches.stop]:
        raise Damaged("its name states other batches than it holds")
    if mark != _mark(batches, arrays, digest):
        raise Damaged("its checksum is another than that of its numbers")
    return batches, arrays


def _mark(batches: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> dict[str, Any]:
    """Scan, batches and checksum of a chunk; the checksum is of names, types, shapes and bytes."""
    checksum = hashlib.blake2b(digest_size=32)
    for name in sorted(arrays):
        array = arrays[name]
        checksum.update(json.dumps([name, array.dtype.str, array.shape]).encode())
        checksum.update(np.ascontiguousarray(array).data)
    return {"study": digest, "start": batches.start, "stop": batches.stop, "checksum": checksum.hexdigest()}
