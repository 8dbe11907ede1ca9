"""Parts of a study on disk: what some lines of its grid give, with a checksum and the study that it belongs to.

Parts may have any lengths and may overlap: what a line gives is the same in each.
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
from pounding_risk.ensemble.chunks import Part

PART = r"(\d{9,})-(\d{9,})\.npz"
MARK = "mark.json"
NUMBERS = "biufc"  # kinds of numeric dtypes


class Damaged(Exception):
    """A file that is no sound part of the study; says why."""


def part_name(lines: range) -> str:
    """The file of the part of these lines; in a listing, parts stand in order."""
    return f"{lines.start:09d}-{lines.stop:09d}.npz"


def lines_of(name: str) -> range | None:
    """The lines that a file's name tells; None where it is not a part's."""
    found = re.fullmatch(PART, name)
    return range(int(found[1]), int(found[2])) if found else None


def write_part(folder: Path, lines: range, part: Mapping[str, NDArray[Any]], digest: str) -> None:
    """Write a part whole; raises OSError, and ValueError for arrays that are not numbers of these lines."""
    arrays = {name: np.ascontiguousarray(array) for name, array in part.items()}
    for name, array in arrays.items():
        if array.dtype.kind not in NUMBERS or array.shape[0] != len(lines):
            raise ValueError(
                f"{name}: {array.dtype} of shape {array.shape} is not one row of numbers a line of {lines}"
            )

    packed = _packed(lines, arrays, digest)
    write_whole(folder / part_name(lines), lambda file: file.write(packed))


def _packed(lines: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> memoryview:
    """The bytes of a part's file, made in memory: what a full disk says is then said of one plain write."""
    found = io.BytesIO()
    try:
        with zipfile.ZipFile(found, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(MARK, json.dumps(_mark(lines, arrays, digest)))
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)
    except ValueError as error:
        # An archive with an open entry cannot be closed, and says so in place of the Ctrl-C that left it open.
        if isinstance(error.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
    return found.getbuffer()


def read_part(path: Path, digest: str) -> tuple[range, Part]:
    """The lines and arrays of a part; raises Damaged for whatever is wrong with it, OSError where it cannot be read."""
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
    lines = lines_of(path.name)
    if lines is None or [mark.get("start"), mark.get("stop")] != [lines.start, lines.stop]:
        raise Damaged("its name tells other lines than it holds")
    if mark != _mark(lines, arrays, digest):
        raise Damaged("its checksum is another than that of its numbers")
    return lines, arrays


def _mark(lines: range, arrays: Mapping[str, NDArray[Any]], digest: str) -> dict[str, Any]:
    """What a part says of itself; the checksum is of names, types, shapes and bytes."""
    checksum = hashlib.blake2b(digest_size=32)
    for name in sorted(arrays):
        array = arrays[name]
        checksum.update(json.dumps([name, array.dtype.str, array.shape]).encode())
        checksum.update(np.ascontiguousarray(array).data)
    return {"study": digest, "start": lines.start, "stop": lines.stop, "checksum": checksum.hexdigest()}
