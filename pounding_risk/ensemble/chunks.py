"""Chunks put together: what some batches give, from pieces that were solved in whatever chunks."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Chunk = dict[str, NDArray[Any]]  # what some batches give, plain numbers; the first axis of every array is the batches'
RAGGED = "_ragged"  # ends the name of an array that may be longer in one chunk than in another: filled up with zeros


def merged(ranges: Iterable[range]) -> list[range]:
    """The same batches in as few ranges as there can be, in order."""
    found: list[range] = []
    for batches in sorted((each for each in ranges if each), key=lambda each: each.start):
        if found and batches.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, batches.stop))
        else:
            found.append(batches)
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
    """Which batches to take from which chunk, so that none is taken twice: (batches, the chunk's batches), in order."""
    found: list[tuple[range, range]] = []
    end = 0
    for batches in sorted(ranges, key=lambda each: (each.start, -each.stop)):
        if batches.stop > end:
            found.append((range(max(batches.start, end), batches.stop), batches))
            end = batches.stop
    return found


def pieces_of(block: range, choice: Sequence[tuple[range, range]]) -> Iterator[tuple[range, range]]:
    """The batches of a block, from `chosen`: (batches, the chunk's batches) in order.

    Batches that no chunk has are left out.
    """
    place = max(bisect_right(choice, block.start, key=lambda each: each[0].start) - 1, 0)
    for batches, home in choice[place:]:
        if batches.start >= block.stop:
            return
        both = range(max(batches.start, block.start), min(batches.stop, block.stop))
        if both:
            yield both, home


def joined(pieces: Sequence[Mapping[str, NDArray[Any]]]) -> Chunk:
    """Chunks one after the other; a ragged array is filled up with zeros to the longest."""
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


class ChunksInMemory:
    """The chunks of a study that nobody keeps."""

    def __init__(self) -> None:
        self._chunks: dict[range, Chunk] = {}

    def keep(self, batches: range, chunk: Chunk, seconds: float) -> None:
        """Hold a chunk."""
        self._chunks[batches] = chunk

    def chunks(self, blocks: Iterable[range]) -> Iterator[Chunk]:
        """The arrays of the batches of each block, in order."""
        choice = chosen(self._chunks)
        for block in blocks:
            yield joined(
                [
                    {
                        name: array[batches.start - home.start : batches.stop - home.start]
                        for name, array in whole.items()
                    }
                    for batches, home in pieces_of(block, choice)
                    for whole in (self._chunks[home],)
                ]
            )
