"""Detection of records that hold the same shaking: copied, converted, reversed, scaled, cut or resampled.

A record that stands twice in an ensemble would count as two independent ones. Two records are copies where, over the
time that both cover, the samples of one are those of the other times a number, to the rounding of the formats that
carry them. Components of one station, and different records of one earthquake, are far from that.

    >>> import numpy as np
    >>> shaking = np.random.default_rng(1).normal(size=800)
    >>> copies([(shaking, 0.01), (np.round(-2.0 * shaking, 5), 0.01)])[0].words()
    'times -2'
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations
from math import sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk.motions.processing.signals import Samples

# 1 − r² of two versions of one record, r their correlation: numbers of five significant digits leave 1e-9, whole
# counts of a record that peaks at 1000 counts 1e-6; no two of 100 horizontals of FEMA P-695 come below 0.7.
ROUNDING = 1e-5
COARSE = 0.05  # likewise about the peak alone, before offsets are taken out: what is far from it needs no closer look
ABOUT_PEAK = 128  # samples before and after it
# Files in g are converted with 980, 980.665 and 981 cm/s² a g: they differ by 7e-4.
SAME_SIZE = 1e-3
LEAST_SHARED = 0.5  # of the energy of either, within the time that both cover
SAME_STEP = 1e-6  # relative difference of time steps that are one, written with different digits
FINER = 8  # times a record may be sampled more finely than its copy


class Copy(NamedTuple):
    """A record that is a copy of another one: ``factor`` times it, at the same times or not."""

    place: int  # of the copy
    original: int  # the place of the first version
    factor: float  # below zero where it is turned round
    same_times: bool  # time step, start and end, but for what holds no shaking

    def is_same_motion(self, *, any_size: bool = False) -> bool:
        """True where the copy drives the same runs as its original; ``any_size``: where both are scaled to one PGA."""
        return self.same_times and self.factor > 0.0 and (any_size or abs(self.factor - 1.0) <= SAME_SIZE)

    def words(self) -> str:
        """The difference between the copy and its original, in words."""
        size = [] if abs(abs(self.factor) - 1.0) <= SAME_SIZE else [f"times {self.factor:.4g}"]
        turned = ["with the other sign"] if self.factor < 0.0 and not size else []
        return " and ".join([*size, *turned, *([] if self.same_times else ["cut or sampled otherwise"])])


class _Record:
    """Samples less their mean, with their peak, energy and coarser samplings."""

    def __init__(self, samples: Samples, dt: float):
        self.dt = dt
        self.samples: Samples = np.asarray(samples, dtype=np.float64) - np.mean(samples)
        self._coarser: dict[int, _Record] = {}

    @cached_property
    def peak(self) -> int:
        """Index of the largest sample."""
        return int(np.argmax(np.abs(self.samples)))

    @cached_property
    def energy(self) -> float:
        """Sum of the squared samples."""
        return float(self.samples @ self.samples)

    def every(self, step: int) -> _Record:
        """The record at every ``step``-th sample, the first one included."""
        if step == 1:
            return self
        if step not in self._coarser:
            self._coarser[step] = _Record(self.samples[::step], self.dt * step)
        return self._coarser[step]


def copies(records: Sequence[tuple[Samples, float]]) -> tuple[Copy, ...]:
    """Every record, samples [m/s²] and time step [s], that is a copy of an earlier one.

    ``original`` is the first of its kind.
    """
    prepared = [_Record(samples, dt) for samples, dt in records]
    copy_of: dict[int, Copy] = {}
    for original, number in combinations(range(len(prepared)), 2):
        if number in copy_of or original in copy_of:
            continue
        copy = _copy(prepared[original], prepared[number])
        if copy is not None:
            copy_of[number] = Copy(number, original, *copy)
    return tuple(copy_of[number] for number in sorted(copy_of))


def _copy(first: _Record, second: _Record) -> tuple[float, bool] | None:
    """The factor from one record to the other, and whether both are at the same times; None where it is no copy."""
    finer = first.dt / second.dt
    step = round(max(finer, 1.0 / finer))
    if step > FINER or abs(max(finer, 1.0 / finer) / step - 1.0) > SAME_STEP:
        return None
    first, second = (first, second.every(step)) if finer > 1.0 else (first.every(step), second)
    for lag in dict.fromkeys((0, second.peak - first.peak)):
        factor = _factor(first, second, lag)
        if factor is not None:
            # The longer of two that start together may hold no shaking after the end of the shorter one.
            end = min(len(first.samples), len(second.samples))
            is_quiet = all(np.sum(one.samples[end:] ** 2) <= ROUNDING * one.energy for one in (first, second))
            return factor, step == 1 and lag == 0 and is_quiet
    return None


def _factor(one: _Record, other: _Record, lag: int) -> float | None:
    """The factor from ``one`` to ``other``, which is ``lag`` samples later; None where they are different motions."""
    start = max(0, -lag)
    stop = min(len(one.samples), len(other.samples) - lag)
    about = slice(max(start, one.peak - ABOUT_PEAK), min(stop, one.peak + ABOUT_PEAK))
    if _unlike(one.samples[about], other.samples[about.start + lag : about.stop + lag]) > COARSE:
        return None
    first, second = one.samples[start:stop], other.samples[start + lag : stop + lag]
    if min(float(first @ first) / one.energy, float(second @ second) / other.energy) < LEAST_SHARED:
        return None
    first, second = first - first.mean(), second - second.mean()
    if _unlike(first, second) > ROUNDING:
        return None
    size = sqrt(float(second @ second) / float(first @ first))
    return size if float(first @ second) > 0.0 else -size


def _unlike(first: Samples, second: Samples) -> float:
    """1 − r² of two intervals of equal length, r their correlation; 1 where one is too short or holds no motion."""
    both = float(first @ first) * float(second @ second) if len(first) > 2 else 0.0
    return 1.0 - float(first @ second) ** 2 / both if both > 0.0 else 1.0
