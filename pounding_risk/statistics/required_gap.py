"""Required gaps: the smallest gaps that a share of the motions, counted, do not close, with bounds.

A motion closes a gap if and only if its closing without contact is larger, whatever the contact model or F_E: the
percentiles need no contact run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.order import enough_for
from pounding_risk.statistics.proportions import exact_bounds

Array = NDArray[np.float64]

USUAL_PERCENTILES = (50.0, 84.0, 95.0)
DIGITS = 12  # after the point: 1 - 0.84 is 0.16, not 0.16000000000000003


@dataclass(frozen=True)
class RequiredGap:
    """The gap [m] that is wide enough for ``percentile`` % of the motions, by count: one of the closings.

    ``low`` and ``high`` are bounds by recording, those at which a verdict would turn; ``low`` is 0 where there is none.
    ``bounded`` is False where so few recordings cannot bound the percentile from above at this confidence: then
    ``high`` is only the largest closing seen. ``fitted`` is that of a lognormal distribution with the motions' mean and
    deviation; NaN where a motion closes nothing. ``provided`` is the gap in the digits in which it is written.
    ``run_to`` is the widest gap at which a row was run: what neighbours push across wider ones is in none of these.
    """

    percentile: float
    gap: float
    low: float
    high: float
    bounded: bool
    fitted: float
    run_to: float = inf

    @property
    def at_least(self) -> bool:
        """True where the gap is a lower bound: neighbours may push the two together across it."""
        return self.gap > self.run_to

    @property
    def is_pushed(self) -> bool:
        """True where that leaves it without an upper bound."""
        return self.high > self.run_to

    def in_row(self, run_to: float) -> RequiredGap:
        """The same in a row that was run at gaps of up to ``run_to`` [m]: bounded from above within these alone."""
        return replace(self, run_to=run_to, bounded=self.bounded and self.high <= run_to)

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
    past = closing.size - np.searchsorted(rising, levels, "right")  # motions that close a gap of so much
    short = closing.size - np.searchsorted(rising, levels, "left")  # and one that is a little less
    _, high = exact_bounds(past * independent, runs, confidence)
    low, _ = exact_bounds(short * independent, runs, confidence)
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
        left = target_left_by(percentile)
        too_little, above = levels[bounds[0] > left], np.flatnonzero(bounds[1] > left)
        first = int(above[-1]) + 1 if above.size else 0
        is_bounded = first < levels.size
        low = float(too_little[-1]) if too_little.size else 0.0
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


def contact_steps(closing: Array, independent: float, confidence: float) -> ContactSteps:
    """P(contact) at every gap, exactly, with bounds by recording; one motion counts for ``independent``, at most 1."""
    gaps = np.unique(np.r_[0.0, closing])
    count = closing.size - np.searchsorted(np.sort(closing), gaps, "right")
    low, high = exact_bounds(count * independent, closing.size * independent, confidence)
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
