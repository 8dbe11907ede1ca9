"""P(contact) and required gaps over samples of uncertain numbers and motions, with bounds that count both.

Bounds are the exact binomial ones of `proportions`, for as many outcomes as samples and motions stand for
(`crossed.Counted`), at each gap by what its outcomes have in common. They are never narrower than those of no contact
at all, or of contact always, in as many outcomes as there are independent motions, or samples where these are fewer.
Points of a Latin hypercube and of a Sobol sequence are counted as if they were drawn independently, which is wider.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.order import enough_for
from pounding_risk.statistics.crossed import (
    AT_ONCE,
    Analysis,
    Components,
    Counted,
    Labels,
    analysed,
    counted_outcomes,
    outcome_shares,
)
from pounding_risk.statistics.proportions import exact_bounds, logs_of, numbered
from pounding_risk.statistics.required_gap import RequiredGap, between_levels, lognormal_percentiles

Array = NDArray[np.float64]

MOST_LEVELS = 256  # gaps at which bounds of a required gap are sought; of fewer outcomes at every closing
MOST_SAMPLES = 2000  # from which it is seen what outcomes have in common; of more, as many evenly among them


class Probability(NamedTuple):
    """P(contact) at some gaps, its bounds, and the independent outcomes that these are for; arrays over the gaps."""

    value: Array
    low: Array
    high: Array
    independent: Array


class CrossedClosings:
    """What motions close without contact in each sample of the uncertain numbers.

    Parameters
    ----------
    closing : array, shape (samples, motions)
        The closings [m]; inf for a motion that has no finite response, which counts as contact at every gap.
    recordings : array of int, shape (motions,)
        Equal for the motions of one recording.
    """

    is_drawn = False  # each sample meets every motion, not one that is drawn with it

    def __init__(self, closing: Array, recordings: Labels):
        order = np.argsort(recordings, kind="stable")
        self.recordings: Labels = numbered(recordings[order])
        self.order = order
        self.closing: Array = np.ascontiguousarray(closing[:, order])
        self.rising: Array = np.sort(closing, axis=None)
        self.analysis: Analysis
        self.counted: Counted
        self.analysis, self.counted = self.of_logs(self.logs)

    def of_logs(self, logs: Array) -> tuple[Analysis, Counted]:
        """Variance components of logarithms of values in the order of the closings, and how many outcomes count."""
        analysis = analysed(logs, self.recordings)
        return analysis, counted_outcomes(logs, self.recordings, analysis)

    def of_polarity(self, closed: NDArray[np.bool_], is_one: NDArray[np.bool_]) -> float:
        """The share of what is ``closed`` under the motions of one polarity."""
        return float(closed[:, is_one[self.order]].mean())

    @property
    def logs(self) -> Array:
        """Logarithms of the closings, (samples, motions), by `logs_of`."""
        return logs_of(self.closing)

    @property
    def components(self) -> Components:
        """Variance components of the logarithms of the closings."""
        return self.analysis.all

    def of_samples(self, gap: float) -> Array:
        """The share of the motions that close a gap [m], in each sample."""
        return np.asarray((self.closing > gap).mean(axis=1))

    def contact(self, gaps: Any, confidence: float, times: tuple[int, int] = (1, 1)) -> Probability:
        """P(contact) at each gap [m], over samples and motions, with bounds of this confidence.

        Bounds are those of so many ``times`` the samples and the recordings, if further ones were like these.
        """
        levels = np.atleast_1d(np.asarray(gaps, dtype=float))
        share = self._share(levels, "right")
        counted = self.counted.times(*times)
        independent = self._independent(levels, share, counted)
        return Probability(share, *_bounds((share, share), independent, counted, confidence), independent)

    def required(self, percentiles: tuple[float, ...], confidence: float) -> tuple[RequiredGap, ...]:
        """Required gap at each percentile [%] of samples and motions together, in rising order, with bounds.

        As `required_gap.required_gaps`. Of more than 256 outcomes the bounds are sought at 256 of the closings, and
        rounded outwards to them.
        """
        values = self.closing.ravel()
        asked = np.array(sorted(set(percentiles)))
        gaps, fitted = enough_for(values, asked), self._fitted(asked)
        levels = _levels(values)
        past, short = self._share(levels, "right"), self._share(levels, "left")
        independent = self._independent(levels, past, self.counted)
        low, high = _bounds((short, past), independent, self.counted, confidence)
        return between_levels(asked, (gaps, fitted), levels, (low, high))

    def _fitted(self, percentiles: Array) -> Array:
        """Percentiles of the lognormal distribution of mean and total variance; NaN where one closes nothing."""
        from scipy.special import ndtri

        if len(self.closing) == 1:
            return lognormal_percentiles(self.closing[0], percentiles)
        if not (self.closing.min() > 0.0 and np.isfinite(self.closing).all()):
            return np.full(percentiles.shape, np.nan)
        deviation = np.sqrt(max(self.components.total, 0.0)) if np.isfinite(self.components.total) else np.nan
        return np.asarray(np.exp(self.logs.mean() + ndtri(percentiles / 100.0) * deviation))

    def _share(self, levels: Array, side: Literal["left", "right"]) -> Array:
        """The share of all outcomes above each level, or with "left" at it and above."""
        total = self.rising.size
        return np.asarray((total - np.searchsorted(self.rising, levels, side)) / total)

    def _independent(self, levels: Array, share: Array, counted: Counted) -> Array:
        """The number of independent outcomes at each level, by what the outcomes there have in common."""
        if len(self.closing) == 1:
            return counted.independent(share)
        some = self.closing[:: -(-len(self.closing) // MOST_SAMPLES)]
        parts = min(-(-levels.size * some.size // AT_ONCE), levels.size)
        alike = [
            outcome_shares(some[None] > part[:, None, None], self.recordings) for part in np.array_split(levels, parts)
        ]
        return counted.independent(share, *map(np.concatenate, zip(*alike, strict=True)))


def _bounds(
    shares: tuple[Array, Array], independent: Array, counted: Counted, confidence: float
) -> tuple[Array, Array]:
    """Exact bounds, the lower of one share and the upper of another; no narrower than of outcomes all the same."""
    fewest = counted.without_contact
    low, _ = exact_bounds(shares[0] * independent, independent, confidence)
    _, high = exact_bounds(shares[1] * independent, independent, confidence)
    always, _ = exact_bounds(fewest, fewest, confidence)
    _, never = exact_bounds(0.0, fewest, confidence)
    return np.minimum(low, always), np.maximum(high, never)


def _levels(values: Array) -> Array:
    """The closings at which bounds are sought, rising: all, or many over the distribution and close in its tail."""
    rising = np.unique(values)
    if rising.size <= MOST_LEVELS:
        return rising
    tail = 1.0 - np.geomspace(0.2, 1.0 / values.size, MOST_LEVELS // 3)
    shares = np.concatenate([np.linspace(0.0, 1.0, MOST_LEVELS - tail.size), tail])
    places = np.unique(np.round(shares * (rising.size - 1)).astype(int))
    return np.asarray(rising[places])
