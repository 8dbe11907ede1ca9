"""Parts of a study on disk: what some lines of its grid give, with a checksum and the study that it belongs to.

Parts may have any lengths and may overlap: what a line gives is the same in each.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pounding_risk.whole_files import write_whole

Part = dict[str, NDArray[Any]]  # the first axis of every array is the lines'
PART = r"(\d{9,})-(\d{9,})\.npz"
MARK = "mark.json"
RAGGED = "_ragged"  # ends the name of an array that may be longer in one part than in another
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

    def write(file: BinaryIO) -> None:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(MARK, json.dumps(_mark(lines, arrays, digest)))
            for name, array in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)

    write_whole(folder / part_name(lines), write)


def read_part(path: Path, digest: str) -> tuple[range, Part]:
    """The lines and arrays of a part; raises Damaged for whatever is wrong with it, OSError where it cannot be read."""
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


def merged(ranges: Iterable[range]) -> list[range]:
    """The same lines in as few ranges as there can be, in order."""
    found: list[range] = []
    for lines in sorted((each for each in ranges if each), key=lambda each: each.start):
        if found and lines.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, lines.stop))
        else:
            found.append(lines)
    return found


def chosen(ranges: Iterable[range]) -> list[tuple[range, range]]:
    """Which lines to take from which part, so that none is taken twice: (lines, the part's lines), in order."""
    found: list[tuple[range, range]] = []
    end = 0
    for lines in sorted(ranges, key=lambda each: (each.start, -each.stop)):
        if lines.stop > end:
            found.append((range(max(lines.start, end), lines.stop), lines))
            end = lines.stop
    return found


def pieces_of(block: range, choice: Sequence[tuple[range, range]]) -> Iterator[tuple[range, range]]:
    """The lines of a block, from `chosen`: (lines, the part's lines) in order; lines that no part has are left out."""
    place = max(bisect_right(choice, block.start, key=lambda each: each[0].start) - 1, 0)
    for lines, home in choice[place:]:
        if lines.start >= block.stop:
            return
        both = range(max(lines.start, block.start), min(lines.stop, block.stop))
        if both:
            yield both, home


def joined(pieces: Sequence[Mapping[str, NDArray[Any]]]) -> Part:
    """Parts one after the other; a ragged array is filled up with zeros to the longest."""
    return {name: _joined(name, [piece[name] for piece in pieces]) for name in pieces[0]}


def _joined(name: str, arrays: list[NDArray[Any]]) -> NDArray[Any]:
    if not name.endswith(RAGGED) or len({array.shape[1:] for array in arrays}) == 1:
        return np.concatenate(arrays)
    longest = tuple(map(max, zip(*(array.shape[1:] for array in arrays), strict=True)))
    whole = np.zeros((sum(map(len, arrays)), *longest), dtype=np.result_type(*arrays))
    start = 0
    for array in arrays:
        whole[(slice(start, start + len(array)), *map(slice, array.shape[1:]))] = array
        start += len(array)
    return whole
