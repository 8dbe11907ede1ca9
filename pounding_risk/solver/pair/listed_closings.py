"""Largest closings without contact of chosen pairs of oscillators, as those of many samples of two buildings.

It is the method of `closings`, and its code. Each pair passes nodes of its own: at least 32 of the shorter of its two
periods, so that one stiff sample does not divide the steps of the others. Pairs with nodes of one width go in chunks,
which hold each oscillator once, through the whole motion: each slab leaves the largest difference at its nodes and how
much more there may be between them. Only slabs that may hold more than the largest at any node are then passed again
and searched, in their order. So the result of a pair does not depend on what other pairs there are, not in a bit.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel
from pounding_risk.motions.spectra import larger, parts_of
from pounding_risk.solver.pair.closings import (
    PULL,
    SLAB,
    Closings,
    divided,
    fill_maps,
    follow_slab,
    room_for,
    search_slab,
    spread_of,
)

CHUNK = 64  # pairs that pass a slab together: their oscillators stay in the processor's cache
AHEAD, BEHIND, REACH = 0, 1, 2  # of a pair in a slab: largest of both signs at nodes, and the most between above it


@kernel
def mark_slabs(nodes, h, pairs, starts, marks, closings, those):
    """The pairs of a chunk through the whole motion, from ``starts[0]``: the marks of each slab, the largest of all.

    ``starts`` becomes the states of the oscillators at the beginning of each slab.
    """
    for slab in range(marks.shape[0]):
        first, state = slab * SLAB, starts[slab + 1]
        steps = min(SLAB, nodes.size - 1 - first)
        for k in range(state.shape[0]):
            state[k, 0], state[k, 1] = starts[slab, k, 0], starts[slab, k, 1]
        follow_slab(nodes, first, steps, state, those)
        for pair in range(pairs.shape[0]):
            left, right = pairs[pair, 0], pairs[pair, 1]
            ahead, behind = spread_of(those.paths[0, left], those.paths[0, right])
            reach = 0.125 * h * h * (those.extents[left, PULL] + those.extents[right, PULL])
            marks[slab, pair, AHEAD], marks[slab, pair, BEHIND], marks[slab, pair, REACH] = ahead, behind, reach
            closings[pair, AHEAD] = larger(ahead, closings[pair, AHEAD])
            closings[pair, BEHIND] = larger(behind, closings[pair, BEHIND])


@kernel
def search_marked(nodes, h, pairs, starts, marks, closings, those):
    """Search the slabs of a chunk that may hold more between their nodes than the largest so far."""
    for slab in range(marks.shape[0]):
        first = slab * SLAB
        steps = min(SLAB, nodes.size - 1 - first)
        is_followed = False
        for pair in range(pairs.shape[0]):
            reach = marks[slab, pair, REACH]
            for way in range(2):
                if marks[slab, pair, way] + reach > closings[pair, way]:
                    if not is_followed:
                        follow_slab(nodes, first, steps, starts[slab], those)
                        is_followed = True
                    sign, limits = 1.0 - 2.0 * way, (reach, closings[pair, way])
                    ends = pairs[pair, 0], pairs[pair, 1]
                    closings[pair, way] = search_slab(nodes, (first, steps), ends, sign, h, limits, those)


@kernel
def close_listed(nodes, h, oscillators, pairs, chunks, starts, marks, those, closings):
    """Largest u_left − u_right and u_right − u_left of every pair, into ``closings`` (pairs, 2), zeros before.

    ``oscillators`` are periods and dampings, chunk by chunk, ``pairs`` numbers within their chunk. ``chunks`` has the
    first oscillator and the first pair of each, and the numbers of both at its end.
    """
    for chunk in range(chunks.shape[0] - 1):
        first, last = chunks[chunk, 0], chunks[chunk + 1, 0]
        begin, end = chunks[chunk, 1], chunks[chunk + 1, 1]
        fill_maps(oscillators[0][first:last], oscillators[1][first:last], h, those.maps)
        of_chunk = starts[: (marks.shape[0] + 1) * (last - first) * 2].reshape(marks.shape[0] + 1, last - first, 2)
        of_chunk[0] = 0.0
        mark_slabs(nodes, h, pairs[begin:end], of_chunk, marks, closings[begin:end], those)
        search_marked(nodes, h, pairs[begin:end], of_chunk, marks, closings[begin:end], those)


class Batch(NamedTuple):
    """Pairs with nodes of one width, as `close_listed` takes them."""

    parts: int  # of the time between two samples
    numbers: np.ndarray  # of the pairs in the list
    oscillators: tuple[np.ndarray, np.ndarray]
    pairs: np.ndarray
    chunks: np.ndarray

    @property
    def most(self) -> tuple[int, int]:
        """The largest numbers of oscillators and pairs in a chunk."""
        return tuple(np.diff(self.chunks, axis=0).max(axis=0).tolist())


class PairList:
    """Pairs of linear oscillators on one ground, to be followed through any number of motions.

    Parameters
    ----------
    left, right : pair of ndarray
        Periods [s] and damping ratios of the oscillators of a side, one for each pair; a period of 0 moves with the
        ground.
    """

    def __init__(self, left, right):
        sides = [np.stack([np.asarray(values, dtype=np.float64) for values in side], axis=1) for side in (left, right)]
        # Each oscillator and each pair once; the first oscillator is the ground, beside which each one shows its peak.
        ground = np.zeros((1, 2))
        self.oscillators, numbers = np.unique(np.concatenate([ground, *sides]), axis=0, return_inverse=True)
        self.sides = numbers.reshape(-1)[1:].reshape(2, -1)
        pairs, self.which = np.unique(self.sides, axis=1, return_inverse=True)
        self.which = self.which.reshape(-1)
        self.count = pairs.shape[1]
        alone = np.arange(1, len(self.oscillators))
        self.pairs = np.concatenate([pairs.T, np.stack([alone, np.zeros_like(alone)], axis=1)])
        self._batches: dict[float, list[Batch]] = {}

    def batches(self, dt: float) -> list[Batch]:
        """The pairs by the width of their nodes in a motion of this time step [s]."""
        if dt not in self._batches:
            periods = np.where(self.oscillators[:, 0] > 0.0, self.oscillators[:, 0], inf)
            parts = np.array([parts_of(dt, period) for period in periods[self.pairs].min(axis=1).tolist()])
            # Each oscillator beside the ground where its first pair is.
            first = np.zeros(len(self.oscillators), dtype=np.int64)
            first[self.pairs[: self.count][::-1]] = np.arange(self.count)[::-1, None]
            order = np.concatenate([np.arange(self.count), first[1:]])
            ranked = np.lexsort((order, parts))
            splits = np.flatnonzero(np.diff(parts[ranked])) + 1
            self._batches[dt] = [self._batch(int(parts[part[0]]), part) for part in np.split(ranked, splits)]
        return self._batches[dt]

    def _batch(self, parts: int, numbers: np.ndarray) -> Batch:
        oscillators, pairs, chunks = [], [], [(0, 0)]
        for begin in range(0, numbers.size, CHUNK):
            members, local = np.unique(self.pairs[numbers[begin : begin + CHUNK]], return_inverse=True)
            oscillators.append(self.oscillators[members])
            pairs.append(local.reshape(-1, 2))
            chunks.append((chunks[-1][0] + members.size, begin + len(pairs[-1])))
        periods, dampings = np.ascontiguousarray(np.concatenate(oscillators).T)
        return Batch(parts, numbers, (periods, dampings), np.concatenate(pairs), np.array(chunks))

    def closings(self, acceleration, dt: float) -> Closings:
        """Largest u_left − u_right from rest of every pair, and the peaks of both its oscillators.

        Parameters
        ----------
        acceleration : ndarray, shape (n,)
            Ground acceleration [m/s²], linear between the samples.
        dt : float
            Time step [s].

        Returns
        -------
        Closings
            For the motion and for the motion reversed, (2, pairs), and the peaks, (pairs,).
        """
        largest = np.zeros((len(self.pairs), 2))
        for batch in self.batches(dt):
            nodes = divided(acceleration, batch.parts)
            slabs = -(-(nodes.size - 1) // SLAB)
            oscillators, pairs = batch.most
            starts, marks = np.empty((slabs + 1) * oscillators * 2), np.empty((slabs, pairs, 3))
            closings = np.zeros((len(batch.pairs), 2))
            room = starts, marks, room_for(oscillators)
            close_listed(nodes, dt / batch.parts, batch.oscillators, batch.pairs, batch.chunks, *room, closings)
            largest[batch.numbers] = closings
        peaks = np.append(0.0, largest[self.count :].max(axis=1))
        both = np.ascontiguousarray(largest[: self.count][self.which].T)
        return Closings(both, *peaks[self.sides])
