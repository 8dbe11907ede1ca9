"""Parts put together: what some lines give, from pieces that were solved in whatever chunks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pounding_risk.jobs import RAGGED, Part


def merged(spans: Iterable[range]) -> list[range]:
    """Spans of lines in order, those that touch or overlap as one."""
    found: list[range] = []
    for span in sorted(spans, key=lambda each: each.start):
        if found and span.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, span.stop))
        elif span:
            found.append(span)
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


def joined(pieces: Sequence[Part]) -> Part:
    """Pieces of neighbouring lines, in order, as one."""
    if len(pieces) == 1:
        return pieces[0]
    return {name: np.concatenate(_alike(name, [piece[name] for piece in pieces])) for name in pieces[0]}


def _alike(name: str, arrays: list[NDArray]) -> list[NDArray]:
    """Arrays whose last axis is as long as the longest one's."""
    most = max(array.shape[-1] for array in arrays) if name.endswith(RAGGED) else 0
    if not most:
        return arrays
    blank = [(0, 0)] * (arrays[0].ndim - 1)
    return [np.pad(array, [*blank, (0, most - array.shape[-1])]) for array in arrays]


class InMemory:
    """The parts of a study that nobody keeps."""

    def __init__(self) -> None:
        self._parts: dict[int, tuple[range, Part]] = {}

    def keep(self, lines: range, part: Part, seconds: float) -> None:
        """Hold a part."""
        self._parts[lines.start] = lines, part

    def parts(self, blocks: Iterable[range]) -> Iterator[Part]:
        """What each block of lines gives, in order; every part is let go once it is used up."""
        waiting = sorted(self._parts.values(), key=lambda each: each[0].start)
        self._parts.clear()
        first = 0
        for block in blocks:
            pieces = []
            for lines, part in waiting[first:]:
                if lines.start >= block.stop:
                    break
                here = slice(max(block.start - lines.start, 0), min(block.stop, lines.stop) - lines.start)
                pieces.append({name: array[here] for name, array in part.items()})
                first += lines.stop <= block.stop
            yield joined(pieces)
