"""Required gaps: the smallest gaps that a share of the motions, counted, do not close, with bounds.

A motion closes a gap if and only if its closing without contact is larger, whatever the contact model or F_E: the
percentiles need no contact run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite, isinf, nan

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pounding_risk._common.order import enough_for
from pounding_risk.statistics.proportions import exact_bounds

Array = NDArray[np.float64]

USUAL_PERCENTILES = (50.0, 84.0, 95.0)
DIGITS = 12  # after the point: 1 - 0.84 is 0.16, not 0.16000000000000003
SAME_GAP = 1e-9  # m, by which two gaps may differ that are one


@dataclass(frozen=True)
class RunGaps:
    """Gaps [m] at which a row was run, in which neighbours push; that of a pair, at which nobody does, is every gap.

    ``widest`` is the widest. ``steps`` are those of a grid in which all gaps vary together, in rising order: a run says
    nothing of another gap there. Without them a run in which the two do not touch says that they do at no wider gap.
    """

    widest: float = inf
    steps: tuple[float, ...] = ()

    def is_known(self, gap: float) -> bool:
        """True where runs say of each motion whether the two touch at a gap [m]."""
        if self.steps:
            return bool(np.isclose(self.steps, gap, rtol=0.0, atol=SAME_GAP).any())
        return gap <= self.widest + SAME_GAP

    def below(self, gaps: ArrayLike) -> Array:
        """What a motion needs at most [m] that is shown to leave each of these gaps [m] open; −inf where none is."""
        gaps = np.asarray(gaps, dtype=float)
        if not self.steps:
            return np.minimum(gaps, self.widest)
        steps = np.array([-inf, *self.steps])
        lower_steps = steps[np.searchsorted(steps, gaps + SAME_GAP, "right") - 1]
        return np.where(gaps > self.widest + SAME_GAP, -inf, lower_steps)

    def above(self, gap: float) -> float:
        """The narrowest gap [m] that is shown to be enough where ``gap`` is needed at least; inf where none is."""
        if gap > self.widest + SAME_GAP:
            return inf
        return next((step for step in self.steps if step >= gap - SAME_GAP), gap)


EVERY_GAP = RunGaps()  # of a pair


@dataclass(frozen=True)
class RequiredGap:
    """The gap [m] that is wide enough for ``percentile`` % of the motions, by count: one of the closings.

    ``low`` and ``high`` are bounds by recording, those at which a verdict would turn; ``low`` is 0 where there is none.
    ``bounded`` is False where so few recordings cannot bound the percentile from above at this confidence: then
    ``high`` is only the largest closing seen. ``fitted`` is that of a lognormal distribution with the motions' mean and
    deviation; NaN where a motion closes nothing. ``provided`` is the gap in the digits in which it is written.
    ``enough`` is the gap up to which neighbours may still push the two together, as the row was not run between the
    two: ``gap`` itself where that is known, infinite where no run is so wide. ``high`` has those pushes in it.
    """

    percentile: float
    gap: float
    low: float
    high: float
    bounded: bool
    fitted: float
    enough: float = nan
    is_pushed: bool = False

    @property
    def at_least(self) -> bool:
        """True where the gap is a lower bound: neighbours may push the two together across any that was run."""
        return isinf(self.enough) and isfinite(self.gap)

    @property
    def is_between(self) -> bool:
        """True where it is known to lie between ``gap`` and ``enough`` alone."""
        return self.gap < self.enough < inf

    @property
    def shown(self) -> float:
        """The gap [m] that is shown to be enough; ``gap``, a lower bound, where no run shows one."""
        return self.enough if self.is_between else self.gap

    def in_row(self, run: RunGaps) -> RequiredGap:
        """The same in a row that was run at some gaps; without an upper bound, ``is_pushed``, where none is so wide."""
        high = run.above(self.high)
        is_pushed = isinf(high) and isfinite(self.high)
        high = high if isfinite(high) else self.high
        bounded = self.bounded and not is_pushed
        return replace(self, enough=run.above(self.gap), high=high, bounded=bounded, is_pushed=is_pushed)

    @property
    def provided(self) -> float:
        """The gap [m] rounded up to three digits: what is written down suffices for the percentile too."""
        return rounded_up(self.gap)


def target_left_by(percentile: float) -> float:
    """The probability of contact that the gap of a percentile [%] leaves: 0.16 of 84."""
    return round(1.0 - percentile / 100.0, DIGITS)


def required_gaps(
    closing: Array, independent: float, percentiles: tuple[float, ...], confidence: float
) -> tuple[RequiredGap, ...]:
    """Required gap at each percentile, in rising order; one motion counts for ``independent``, at most 1.

    It is the smallest gap that at least this share of the motions, counted, do not close, whose closing may be equal to
    it: an order statistic (`enough_for`), so that "84 % of the motions need no more" is true. Bounds are the gaps
    at which the exact bounds of the probability of contact pass what a percentile p leaves, 1 − p: at ``high`` the
    upper bound is no more than that, below ``low`` the lower one is above it. For independent motions these are the
    order statistics between which the binomial distribution has the percentile (David and Nagaraja, Order Statistics,
    2003, 7.1).
    """
    percents = np.array(sorted(set(percentiles)))
    gaps, fitted = enough_for(closing, percents), lognormal_percentiles(closing, percents)
    levels = np.unique(closing)
    rising, runs = np.sort(closing), closing.size * independent
    count_above = closing.size - np.searchsorted(rising, levels, "right")  # motions that close more than the level
    count_from = closing.size - np.searchsorted(rising, levels, "left")  # and no less than it
    _, high = exact_bounds(count_above * independent, runs, confidence)
    low, _ = exact_bounds(count_from * independent, runs, confidence)
    return between_levels(percents, (gaps, fitted), levels, (low, high))


def between_levels(
    percentiles: Array, estimates: tuple[Array, Array], levels: Array, bounds: tuple[Array, Array]
) -> tuple[RequiredGap, ...]:
    """Required gaps, counted and fitted, with bounds from those of P(contact) at rising ``levels``.

    The upper one is the level after the last at which the upper bound of P(contact) exceeds what the percentile leaves:
    bounds need not fall everywhere.
    """
    required = []
    for percentile, gap, fit in zip(percentiles.tolist(), *(column.tolist() for column in estimates), strict=True):
        target = target_left_by(percentile)
        low_levels, above = levels[bounds[0] > target], np.flatnonzero(bounds[1] > target)
        first = int(above[-1]) + 1 if above.size else 0
        is_bounded = first < levels.size
        low = float(low_levels[-1]) if low_levels.size else 0.0
        required.append(RequiredGap(percentile, gap, low, float(levels[first if is_bounded else -1]), is_bounded, fit))
    return tuple(required)


@dataclass(frozen=True)
class ContactSteps:
    """P(contact) against the gap in steps, each from one entry of ``gaps`` [m] to the next.

    ``gaps`` are 0 and the closings in rising order; ``probability`` at a gap and up to the next one, with ``low`` and
    ``high``, its bounds by recording. Contact is a closing that is larger than the gap: at a closing itself the step is
    already down.
    """

    gaps: Array
    probability: Array
    low: Array
    high: Array


def contact_steps(closing: Array, independent: float, confidence: float, run: RunGaps = EVERY_GAP) -> ContactSteps:
    """P(contact) at every gap, with bounds by recording; one motion counts for ``independent``, at most 1.

    Exact, but for what neighbours may push at gaps at which a row was not run, which is in the upper bounds alone.
    """
    beyond = (run.widest + 2.0 * SAME_GAP,) * bool(run.steps)  # wider gaps that no run covers
    gaps = np.unique(np.r_[0.0, closing, run.steps, beyond])
    count, most = (closing.size - np.searchsorted(np.sort(closing), at, "right") for at in (gaps, run.below(gaps)))
    low, _ = exact_bounds(count * independent, closing.size * independent, confidence)
    _, high = exact_bounds(most * independent, closing.size * independent, confidence)
    return ContactSteps(gaps, count / closing.size, low, high)


def lognormal_percentiles(closing: Array, percentiles: Array) -> Array:
    """exp(m + z s), m and s the mean and deviation (n − 1) of ln closing; NaN where one is 0, infinite or alone."""
    from scipy.special import ndtri

    if closing.size < 2 or closing.min() <= 0.0 or np.isinf(closing.max()):
        return np.full(percentiles.shape, nan)
    logs = np.log(closing)
    return np.asarray(np.exp(logs.mean() + ndtri(percentiles / 100.0) * logs.std(ddof=1)))


def lognormal_share(closing: Array, gap: float) -> float:
    """1 − Φ((ln gap − m)/s), the share that closes more than ``gap`` [m], as `lognormal_percentiles`."""
    from scipy.special import ndtr

    if closing.size < 2 or closing.min() <= 0.0 or gap <= 0.0 or np.ptp(closing) == 0.0:
        return nan
    logs = np.log(closing)
    return float(ndtr((logs.mean() - np.log(gap)) / logs.std(ddof=1)))


def rounded_up(gap: float) -> float:
    """A gap [m] rounded up to three digits, 0 where it is not above 0; one that is infinite stays so."""
    if not gap > 0.0:
        return 0.0
    if np.isinf(gap):
        return gap
    unit = 10.0 ** max(np.floor(np.log10(gap)) - 2.0, -300.0)  # no division by what underflows
    return float(max(np.ceil(gap / unit - 1e-9), 1.0) * unit)  # 1: what is below the unit is rounded up too
