"""Chunks: the results of a range of batches, and how results of any range are assembled from chunks.

Chunks may have any boundaries and may overlap, as the results of a batch are the same in each.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError

Chunk = dict[str, NDArray[Any]]  # arrays of plain numbers; the first axis of each is the batches'
RAGGED = "_ragged"  # ends the name of an array whose other axes may be longer in one chunk than in another


def merged(spans: Iterable[range]) -> list[range]:
    """The same batches in as few ranges as possible, in order."""
    union: list[range] = []
    for span in sorted(filter(None, spans), key=lambda span: span.start):
        if union and span.start <= union[-1].stop:
            union[-1] = range(union[-1].start, max(union[-1].stop, span.stop))
        else:
            union.append(span)
    return union


def without(spans: Iterable[range], done: Iterable[range]) -> list[range]:
    """The batches of ``spans`` that are not in ``done``, in order."""
    missing, done = [], merged(done)
    for span in merged(spans):
        start = span.start
        for done_span in done:
            if done_span.stop <= start or done_span.start >= span.stop:
                continue
            if done_span.start > start:
                missing.append(range(start, done_span.start))
            start = max(start, done_span.stop)
        if start < span.stop:
            missing.append(range(start, span.stop))
    return missing


def parted(span: range, spans: Iterable[range]) -> Iterator[tuple[range, bool]]:
    """The batches of a range in order, in pieces that lie wholly inside ``spans`` (True) or outside them (False)."""
    missing = without([span], spans)
    edges = sorted({span.start, span.stop, *(edge for piece in missing for edge in (piece.start, piece.stop))})
    for start, stop in pairwise(edges):
        yield range(start, stop), not any(start in piece for piece in missing)


def chosen(chunks: Iterable[range]) -> list[tuple[range, range]]:
    """Which batches to take from which chunk so that none is taken twice: (batches, the chunk's batches), in order."""
    choice: list[tuple[range, range]] = []
    end = 0
    for chunk in sorted(chunks, key=lambda chunk: (chunk.start, -chunk.stop)):
        if chunk.stop > end:
            choice.append((range(max(chunk.start, end), chunk.stop), chunk))
            end = chunk.stop
    return choice


def pieces_of(block: range, choice: Sequence[tuple[range, range]]) -> Iterator[tuple[range, range]]:
    """The batches of a block as `chosen` has them: (batches, the chunk's batches), in order.

    Batches without a chunk are left out.
    """
    first = max(bisect_right(choice, block.start, key=lambda pair: pair[0].start) - 1, 0)
    for batches, chunk in choice[first:]:
        if batches.start >= block.stop:
            return
        overlap = range(max(batches.start, block.start), min(batches.stop, block.stop))
        if overlap:
            yield overlap, chunk


def by_scene(batches: range, per_scene: int) -> Iterator[tuple[int, range, slice]]:
    """Batches by scene, ``per_scene`` each: the scene's number, its own batches, and their slice of ``batches``.

    >>> list(by_scene(range(3, 6), 4))
    [(0, range(3, 4), slice(0, 1, None)), (1, range(0, 2), slice(1, 3, None))]
    """
    start = batches.start
    while start < batches.stop:
        number, first = divmod(start, per_scene)
        count = min(per_scene - first, batches.stop - start)
        yield number, range(first, first + count), slice(start - batches.start, start - batches.start + count)
        start += count


def joined(pieces: Sequence[Mapping[str, NDArray[Any]]]) -> Chunk:
    """Concatenate chunks; a ragged array is filled up with zeros to the longest."""
    return {name: _joined(name, [piece[name] for piece in pieces]) for name in pieces[0]}


def _joined(name: str, arrays: list[NDArray[Any]]) -> NDArray[Any]:
    if not name.endswith(RAGGED) or len({array.shape[1:] for array in arrays}) == 1:
        return np.concatenate(arrays)
    longest = tuple(map(max, zip(*(array.shape[1:] for array in arrays), strict=True)))
    total = np.zeros((sum(map(len, arrays)), *longest), dtype=np.result_type(*arrays))
    start = 0
    for array in arrays:
        total[(slice(start, start + len(array)), *map(slice, array.shape[1:]))] = array
        start += len(array)
    return total


def assembled(
    blocks: Iterable[range], chunks: Iterable[range], read: Callable[[range], Chunk], store: object
) -> Iterator[Chunk]:
    """The arrays of the batches of each block, in order, from chunks that are read one after the other.

    Memory is bounded by a block and a chunk. Raises PoundingError, naming ``store``, for batches without a chunk.
    """
    choice = chosen(chunks)
    chunk_batches, chunk = range(0), Chunk()
    for block in blocks:
        pieces, end = [], block.start
        for batches, source in pieces_of(block, choice):
            if batches.start != end:
                break
            if source != chunk_batches:
                chunk_batches, chunk = source, read(source)
            rows = slice(batches.start - chunk_batches.start, batches.stop - chunk_batches.start)
            # Copied, as a view would keep the whole chunk in memory.
            pieces.append({name: array[rows].copy() for name, array in chunk.items()})
            end = batches.stop
        if end < block.stop:
            raise PoundingError(f"{store}: of the batches from {end} on there is no chunk; run the same command again")
        yield joined(pieces)


class ChunksInMemory:
    """The chunks of a scan that writes no file."""

    def __init__(self) -> None:
        self._chunks: dict[range, Chunk] = {}

    def keep(self, batches: range, chunk: Chunk, seconds: float) -> None:
        """Add the chunk of a range of batches to those in memory."""
        self._chunks[batches] = chunk

    def chunks(self, blocks: Iterable[range]) -> Iterator[Chunk]:
        """The arrays of the batches of each block, in order."""
        return assembled(blocks, self._chunks, self._chunks.__getitem__, "memory")
