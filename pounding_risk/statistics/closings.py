"""P(contact) and required gaps over samples of uncertain numbers and motions, with bounds that count both.

Bounds are the exact binomial ones of `proportions`, for as many outcomes as samples and motions stand for
(`crossed.Counted`), at each gap by what its outcomes have in common. They are never narrower than those of no contact
at all, or of contact always, in as many outcomes as there are independent motions, or samples where these are fewer.
Points of a Latin hypercube and of a Sobol sequence are counted as if they were drawn independently, which is wider.

Where each sample has one motion, drawn with it, outcomes of one recording are alike, however unlike their numbers
are: samples are clusters by recording. With x = μ + b_m + r, b the part of the motion and r that of the numbers and of
both together, a mean over N samples has the variance σ² ((1 − ρ)/N + ρ Σw²), w the share of the samples that a
recording has and ρ the correlation of two samples of one recording. What the numbers do alone is not separable from
what they do together with motions: each sample has one motion, and no two of different motions have the same numbers.

Sources: Kish, Survey Sampling (1965), on the design effect; Donner, Int. Stat. Rev. 54 (1986); Searle, Casella and
McCulloch, Variance Components (1992), chapter 3, on components from means over pairs; Efron and Stein, Annals of
Statistics 9 (1981), on the jackknife, one recording left out at a time.
"""

from __future__ import annotations

from copy import copy
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
    outcome_correlation,
    outcome_shares,
)
from pounding_risk.statistics.proportions import exact_bounds, likeness, logs_of, numbered
from pounding_risk.statistics.required_gap import RequiredGap, between_levels

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

    ``closing`` (samples, motions) is in m, inf for a motion without a finite response, which counts as contact at every
    gap; ``recordings`` (motions,) are equal for the motions of one recording.
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

    def of_polarity(self, is_closed: NDArray[np.bool_], has_polarity: NDArray[np.bool_]) -> float:
        """The share of outcomes with a closed gap under the motions of one polarity."""
        return float(is_closed[:, has_polarity[self.order]].mean())

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

    @property
    def without_lost(self) -> CrossedClosings:
        """The same with outcomes that have no finite closing as such that close nothing, for lower bounds."""
        if np.isfinite(self.closing).all():
            return self
        closings = copy(self)
        closings.closing = np.where(np.isfinite(self.closing), self.closing, 0.0)
        closings.rising = np.sort(closings.closing, axis=None)
        return closings

    def contact(self, gaps: Any, confidence: float, times: tuple[int, int] = (1, 1)) -> Probability:
        """P(contact) at each gap [m], over samples and motions, with bounds of this confidence.

        Bounds are those of so many ``times`` the samples and the recordings, if further ones were like these; outcomes
        without a finite closing are contact, and none in lower bounds.
        """
        levels = np.atleast_1d(np.asarray(gaps, dtype=float))
        share = self._share(levels, "right")
        counted = self.counted.times(*times)
        independent = self._independent(levels, share, counted)
        low_share = self.without_lost._share(levels, "right")
        return Probability(share, *_bounds((low_share, share), independent, counted, confidence), independent)

    def required(self, percentiles: tuple[float, ...], confidence: float) -> tuple[RequiredGap, ...]:
        """Required gap at each percentile [%] of samples and motions together, in rising order, with bounds.

        As `required_gap.required_gaps`. Of more than 256 outcomes the bounds are sought at 256 of the closings, and
        rounded outwards to them.
        """
        closings = self.closing.ravel()
        percents = np.array(sorted(set(percentiles)))
        gaps, fitted = enough_for(closings, percents), self._fitted(percents)
        levels = _levels(closings)
        above, from_level = self._share(levels, "right"), self.without_lost._share(levels, "left")
        independent = self._independent(levels, above, self.counted)
        low, high = _bounds((from_level, above), independent, self.counted, confidence)
        return between_levels(percents, (gaps, fitted), levels, (low, high))

    def _fitted(self, percentiles: Array) -> Array:
        """Percentiles of the lognormal distribution of mean and total variance; NaN where one closes nothing."""
        from scipy.special import ndtri

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
        rows = self.closing[:: -(-len(self.closing) // MOST_SAMPLES)]
        blocks = min(-(-levels.size * rows.size // AT_ONCE), levels.size)
        parts = [
            outcome_shares(rows[None] > gaps[:, None, None], self.recordings) for gaps in np.array_split(levels, blocks)
        ]
        return counted.independent(share, *map(np.concatenate, zip(*parts, strict=True)))


def _bounds(
    shares: tuple[Array, Array], independent: Array, counted: Counted, confidence: float
) -> tuple[Array, Array]:
    """Exact bounds, the lower of one share and the upper of another; no narrower than of outcomes all the same."""
    least_count = counted.without_contact
    low, _ = exact_bounds(shares[0] * independent, independent, confidence)
    _, high = exact_bounds(shares[1] * independent, independent, confidence)
    low_of_all, _ = exact_bounds(least_count, least_count, confidence)
    _, high_of_none = exact_bounds(0.0, least_count, confidence)
    return np.minimum(low, low_of_all), np.maximum(high, high_of_none)


def _levels(closings: Array) -> Array:
    """The closings at which bounds are sought, rising: all, or many over the distribution and close in its tail."""
    rising = np.unique(closings)
    if rising.size <= MOST_LEVELS:
        return rising
    tail = 1.0 - np.geomspace(0.2, 1.0 / closings.size, MOST_LEVELS // 3)
    shares = np.concatenate([np.linspace(0.0, 1.0, MOST_LEVELS - tail.size), tail])
    return np.asarray(rising[np.unique(np.round(shares * (rising.size - 1)).astype(int))])


# ------------------------------------------------------------------------------------------------ drawn motions


class Clusters(NamedTuple):
    """How many independent outcomes samples stand for that have one motion each; as `crossed.Counted`."""

    samples: int
    crowding: float  # Σw²: the probability that two samples, drawn with replacement, are of one recording
    alike: float  # upper bound of the correlation of two samples of one recording

    @property
    def motions(self) -> float:
        """Independent motions: so many recordings, all with as many samples, would do the same."""
        return 1.0 / self.crowding

    def independent(self, share: Array, outcomes: Any = 0.0) -> Array:
        """Effective number of independent outcomes: 1/n = (1 − ρ)/N + ρ Σw².

        ρ is the correlation of two outcomes of one recording, yes or no: that of normal values with the correlation
        ``alike``, or that of the ``outcomes`` themselves where it is larger.
        """
        correlation = np.maximum(outcomes, outcome_correlation(share, self.alike))
        return np.asarray(1.0 / ((1.0 - correlation) / self.samples + correlation * self.crowding))

    def times(self, samples: int, recordings: int) -> Clusters:
        """So many times the samples and the recordings, all like these."""
        crowding = max(self.crowding / recordings, 1.0 / (self.samples * samples))
        return self._replace(samples=self.samples * samples, crowding=crowding)

    @property
    def without_contact(self) -> float:
        """Independent outcomes where all are the same, which does not show how alike those of a recording are."""
        return self.motions

    def variance_of_mean(self, components: Components) -> float:
        """The variance of the mean over all samples; a component below 0 counts as none."""
        total = max(float(components.total), 0.0)
        shared = min(max(float(np.nan_to_num(components.recordings)), 0.0), total)
        return (total - shared) / self.samples + shared * self.crowding


def analysed_clusters(values: Array, motions: Labels, recordings: Labels) -> Analysis:
    """Variances of values by motion and within one, with the jackknife over recordings.

    Of values such as the logarithms of closings, and numbers from 0 without gaps that are equal for the samples of one
    motion and of one recording, each (samples,). Of the `Analysis` ``samples`` is the variance within a motion, of the
    numbers and of both together, ``interaction`` 0, and ``recordings`` the covariance of two samples of one recording.
    """
    departures = values - values.mean()
    recording_of = np.zeros(motions.max() + 1, dtype=np.int64)
    recording_of[motions] = recordings

    def summed(weights: Array | None) -> tuple[Array, Array]:
        """Σ over the samples of each recording, and Σ over its motions of the square of their own sum."""
        by_motion = np.bincount(motions, weights).astype(float)
        return np.bincount(recordings, weights).astype(float), np.bincount(recording_of, by_motion**2).astype(float)

    (count, count2), (total, total2), (square, _) = summed(None), summed(departures), summed(departures * departures)
    sums = np.stack([count, count2, count**2, total, total2, total**2, square])  # (sums, recordings)
    totals = sums.sum(axis=1)
    overall = _components(totals)
    return Analysis(
        Components(*map(float, overall)),
        _components(totals[:, None] - sums),
        Components(*(np.full(2, float(component)) for component in overall)),  # the jackknife over recordings has both
    )


def _components(sums: Array) -> Components:
    count, of_motions, of_recordings, total, total_motions, total_recordings, square = sums
    with np.errstate(divide="ignore", invalid="ignore"):  # nan where there are no such pairs
        neither = (total**2 - total_recordings) / (count**2 - of_recordings)
        same_motion = (total_motions - square) / (of_motions - count)
        same_recording = (total_recordings - square) / (of_recordings - count)
        # What repeats within no motion cannot be separated from what does: both are then unknown.
        return Components(square / count - same_motion, same_motion - neither, 0.0 * count, same_recording - neither)


def motion_share(analysis: Analysis, confidence: float) -> tuple[float, float, float]:
    """The share of the motions in a variance, with bounds by the jackknife over recordings; NaN where it is not known.

    It is the first-order index of the motion, drawn independently of the numbers.
    """

    def share(components: Components) -> Any:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(components.motions) / components.total

    estimate = float(share(analysis.all))
    if not np.isfinite(estimate):
        return np.nan, np.nan, np.nan
    half_width = analysis.half_width(share, 0.5 * (1.0 + confidence))
    return estimate, estimate - half_width, estimate + half_width


class DrawnClosings(CrossedClosings):
    """What is closed without contact in samples of the uncertain numbers that have one motion each.

    As `CrossedClosings`, each array (samples,); ``motions`` are equal for the samples of one motion.
    """

    is_drawn = True

    def __init__(self, closing: Array, motions: Labels, recordings: Labels):
        self.recordings: Labels = numbered(recordings)
        self.of_motions: Labels = numbered(motions)
        self.order = np.zeros(1, dtype=np.int64)
        self.closing: Array = closing[:, None]
        self.rising: Array = np.sort(closing)
        self.analysis, self.counted = self.of_logs(self.logs)

    def of_logs(self, logs: Array) -> tuple[Analysis, Any]:
        of_samples = logs[:, 0]
        crowding = float((np.bincount(self.recordings) ** 2).sum()) / float(of_samples.size) ** 2
        return (
            analysed_clusters(of_samples, self.of_motions, self.recordings),
            Clusters(of_samples.size, crowding, likeness(of_samples, self.recordings)),
        )

    def of_polarity(self, is_closed: NDArray[np.bool_], has_polarity: NDArray[np.bool_]) -> float:
        return float(is_closed[has_polarity].mean())

    def _independent(self, levels: Array, share: Array, counted: Any) -> Array:
        """By the correlation of the outcomes of two samples of one recording at each level; 0 of constant ones."""
        order = np.argsort(self.recordings, kind="stable")
        starts = np.flatnonzero(np.diff(self.recordings[order], prepend=-1))
        sizes = np.bincount(self.recordings).astype(float)
        count, pairs = sizes.sum(), (sizes**2).sum()
        blocks = min(-(-levels.size * self.closing.size // AT_ONCE), levels.size)
        correlations = []
        for gaps in np.array_split(levels, blocks):
            outcomes = self.closing[order, 0] > gaps[:, None]
            by_recording = np.add.reduceat(outcomes, starts, axis=1, dtype=np.int64).astype(float)
            total, squares = by_recording.sum(1), (by_recording**2).sum(1)
            with np.errstate(divide="ignore", invalid="ignore"):
                neither = (total**2 - squares) / (count**2 - pairs)
                correlation = ((squares - total) / (pairs - count) - neither) / (total / count - neither)
            correlations.append(np.clip(np.nan_to_num(correlation), 0.0, 1.0))
        return np.asarray(counted.independent(share, np.concatenate(correlations)))
