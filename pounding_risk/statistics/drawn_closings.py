"""P(contact) and required gaps over samples each of which has one motion, drawn with it; bounds that count recordings.

Outcomes of one recording are alike, however unlike their numbers are: samples are clusters by recording. With
x = μ + b_m + r, b the part of the motion and r that of the numbers and of both together, a mean over N samples has the
variance σ² ((1 − ρ)/N + ρ Σw²), w the share of the samples that a recording has and ρ the correlation of two samples of
one recording. What the numbers do alone and what they do together with motions is not told apart: each sample has one
motion, and no two samples of different motions have the same numbers.

Sources: Kish, Survey Sampling (1965), on the design effect; Donner, Int. Stat. Rev. 54 (1986); Searle, Casella and
McCulloch, Variance Components (1992), chapter 3, on components from means over pairs; Efron and Stein, Annals of
Statistics 9 (1981), on the jackknife, one recording left out at a time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.statistics.crossed import AT_ONCE, Analysis, Components, Labels, outcome_correlation
from pounding_risk.statistics.crossed_contact import CrossedClosings
from pounding_risk.statistics.proportions import likeness, numbered

Array = NDArray[np.float64]


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

    Parameters
    ----------
    values : array, shape (samples,)
        Such as the logarithms of closings.
    motions, recordings : array of int, shape (samples,)
        Equal for the samples of one motion, and of one recording; numbers from 0 without gaps.

    Returns
    -------
    Analysis
        ``samples`` is the variance within a motion, of the numbers and of both together, ``interaction`` 0, and
        ``recordings`` the covariance of two samples of one recording.
    """
    x = values - values.mean()
    of_motion = np.zeros(motions.max() + 1, dtype=np.int64)
    of_motion[motions] = recordings

    def summed(weights: Array | None) -> tuple[Array, Array]:
        """Σ over the samples of each recording, and Σ over its motions of the square of their own sum."""
        by_motion = np.bincount(motions, weights).astype(float)
        return np.bincount(recordings, weights).astype(float), np.bincount(of_motion, by_motion**2).astype(float)

    (count, count2), (total, total2), (square, _) = summed(None), summed(x), summed(x * x)
    sums = np.stack([count, count2, count**2, total, total2, total**2, square])  # (sums, recordings)
    whole = sums.sum(axis=1)
    everything = _components(whole)
    return Analysis(
        Components(*map(float, everything)),
        _components(whole[:, None] - sums),
        Components(*(np.full(2, float(part)) for part in everything)),  # the jackknife over recordings has both
    )


def _components(sums: Array) -> Components:
    count, of_motions, of_recordings, total, total_motions, total_recordings, square = sums
    with np.errstate(divide="ignore", invalid="ignore"):  # nan where there are no such pairs
        neither = (total**2 - total_recordings) / (count**2 - of_recordings)
        same_motion = (total_motions - square) / (of_motions - count)
        same_recording = (total_recordings - square) / (of_recordings - count)
        # What repeats within no motion is not told from what does: both are then unknown.
        return Components(square / count - same_motion, same_motion - neither, 0.0 * count, same_recording - neither)


def motion_share(analysis: Analysis, confidence: float) -> tuple[float, float, float]:
    """The share of the motions in a variance, with bounds by the jackknife over recordings; NaN where it is not known.

    It is the first-order index of the motion, drawn independently of the numbers.
    """

    def share(components: Components) -> Any:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(components.motions) / components.total

    value = float(share(analysis.all))
    if not np.isfinite(value):
        return np.nan, np.nan, np.nan
    half = analysis.half_width(share, 0.5 * (1.0 + confidence))
    return value, value - half, value + half


class DrawnClosings(CrossedClosings):
    """What is closed without contact in samples of the uncertain numbers that have one motion each.

    Parameters
    ----------
    closing : array, shape (samples,)
        The closings [m]; inf for a motion that has no finite response, which counts as contact at every gap.
    motions, recordings : array of int, shape (samples,)
        Equal for the samples of one motion, and of one recording.
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
        values = logs[:, 0]
        sizes = np.bincount(self.recordings)
        crowding = float((sizes**2).sum()) / float(values.size) ** 2
        return (
            analysed_clusters(values, self.of_motions, self.recordings),
            Clusters(values.size, crowding, likeness(values, self.recordings)),
        )

    def of_polarity(self, closed: NDArray[np.bool_], is_one: NDArray[np.bool_]) -> float:
        return float(closed[is_one].mean())

    def _independent(self, levels: Array, share: Array, counted: Any) -> Array:
        parts = min(-(-levels.size * self.closing.size // AT_ONCE), levels.size)
        alike = [self._alike(part) for part in np.array_split(levels, parts)]
        return np.asarray(counted.independent(share, np.concatenate(alike)))

    def _alike(self, levels: Array) -> Array:
        """Correlation of the outcomes of two samples of one recording at each level, 0 to 1; 0 of constant ones."""
        order = np.argsort(self.recordings, kind="stable")
        starts = np.flatnonzero(np.diff(self.recordings[order], prepend=-1))
        outcomes = self.closing[order, 0] > levels[:, None]
        by_recording = np.add.reduceat(outcomes, starts, axis=1, dtype=np.int64).astype(float)
        sizes = np.bincount(self.recordings).astype(float)
        count, total, squares, own = sizes.sum(), by_recording.sum(1), (by_recording**2).sum(1), (sizes**2).sum()
        with np.errstate(divide="ignore", invalid="ignore"):
            neither = (total**2 - squares) / (count**2 - own)
            correlation = ((squares - total) / (own - count) - neither) / (total / count - neither)
        return np.clip(np.nan_to_num(correlation), 0.0, 1.0)
