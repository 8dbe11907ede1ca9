"""Parts put together: what some lines give, from pieces that were solved in whatever chunks."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Part = dict[str, NDArray[Any]]  # what some lines give, plain numbers; the first axis of every array is the lines'
RAGGED = "_ragged"  # ends the name of an array that may be longer in one part than in another: filled up with zeros


def merged(ranges: Iterable[range]) -> list[range]:
    """The same lines in as few ranges as there can be, in order."""
    found: list[range] = []
    for lines in sorted((each for each in ranges if each), key=lambda each: each.start):
        if found and lines.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, lines.stop))
        else:
            found.append(lines)
    return found


def without(spans: Iterable[range], done: Iterable[range]) -> list[range]:
    """What of the spans is not done."""
    left, gone = [], merged(done)
    for span in merged(spans):
        start = span.start
        for each in gone:
            if each.stop <= start or each.start >= span.stop:
                continue
            if each.start > start:
                left.append(range(start, each.start))
            start = max(start, each.stop)
        if start < span.stop:
            left.append(range(start, span.stop))
    return left


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


class InMemory:
    """The parts of a study that nobody keeps."""

    def __init__(self) -> None:
        self._parts: dict[range, Part] = {}

    def keep(self, lines: range, part: Part, seconds: float) -> None:
        """Hold a part."""
        self._parts[lines] = part

    def parts(self, blocks: Iterable[range]) -> Iterator[Part]:
        """The arrays of the lines of each block, in order."""
        choice = chosen(self._parts)
        for block in blocks:
            yield joined(
                [
                    {name: array[lines.start - home.start : lines.stop - home.start] for name, array in whole.items()}
                    for lines, home in pieces_of(block, choice)
                    for whole in (self._parts[home],)
                ]
            )
