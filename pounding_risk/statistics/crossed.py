"""Samples of uncertain numbers crossed with motions: what each contributes to the variance, and how many count.

Every sample of the uncertain numbers meets every motion. Outcomes of one sample are alike, and so are those of one
motion in all samples, and of the motions of one recording: samples and recordings are crossed random factors. With
x = μ + a_s + b_m + c_sm, the variances of the three are those of the samples, the motions and their interaction, and a
mean over S samples and R recordings has about the variance σ_a²/S + σ_b²/R + σ_c²/(S R), however many outcomes there
are.

Sources: Searle, Casella and McCulloch, Variance Components (1992), chapter 4; Owen, The pigeonhole bootstrap, Annals of
Applied Statistics 1 (2007), on why both factors must be counted; Hoeffding, Annals of Mathematical Statistics 19
(1948), on means over pairs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.statistics.proportions import independent_motions

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

MOST_BLOCKS = 40  # of samples, one of which is left out at a time
LIKENESS_CONFIDENCE = 0.95  # of the upper bounds on how alike outcomes are, as of `proportions.likeness`
AT_ONCE = 4_000_000  # outcomes that are held in memory


class Components(NamedTuple):
    """Variances of values over samples and motions.

    ``recordings`` is the part of ``motions`` that the motions of one recording share; NaN where no recording has two.
    Estimates, which may be below 0; NaN where there is one sample, or one recording.
    """

    samples: Any
    motions: Any
    interaction: Any
    recordings: Any

    @property
    def total(self) -> Any:
        """Variance of one motion in one sample."""
        return self.samples + self.motions + self.interaction


class _Sums(NamedTuple):
    """Sums from which the means of products over pairs follow; x the values, s samples, m motions, r recordings."""

    samples: Any
    sizes: Any  # motions of each recording
    squares: Any  # Σ x²
    rows: Any  # Σ over s of (Σ x over m)²
    rows_own: Any  # Σ over s and r of (Σ x over m of r)²
    columns: Any  # Σ over m of (Σ x over s)²
    columns_own: Any  # Σ over r of (Σ x over s, and m of r)²
    total: Any  # (Σ x)²


def _components(sums: _Sums) -> Components:
    """Unbiased estimates: differences of the mean products over pairs that share a sample, a motion, or neither."""
    motions, same_pairs = float(sums.sizes.sum()), float((sums.sizes**2).sum())
    other_pairs, pairs = motions**2 - same_pairs, sums.samples * (sums.samples - 1.0)
    with np.errstate(all="ignore"):  # nan where there is one sample, or one recording
        mean_square = sums.squares / (sums.samples * motions)
        same_sample = np.divide(sums.rows - sums.rows_own, sums.samples * other_pairs)
        same_motion = np.divide(sums.columns - sums.squares, pairs * motions)
        within = sums.columns_own - sums.rows_own - (sums.columns - sums.squares)
        same_recording = np.divide(within, pairs * (same_pairs - motions))
        neither = np.divide(sums.total - sums.rows - sums.columns_own + sums.rows_own, pairs * other_pairs)
        return Components(
            same_sample - neither,
            same_motion - neither,
            mean_square - same_sample - same_motion + neither,
            same_recording - neither,
        )


class Analysis(NamedTuple):
    """Components of variance, and those without each recording and without each block of samples (the jackknife)."""

    all: Components
    without_recording: Components  # arrays over the recordings
    without_block: Components

    def error(self, function: Callable[[Components], Any]) -> tuple[float, float]:
        """Standard error of a function of the components, and its degrees of freedom (Welch and Satterthwaite).

        The variances of leaving out recordings and of leaving out samples are added: the interaction counts twice.
        """
        jackknives = []
        for left_out in (self.without_recording, self.without_block):
            estimates = np.asarray(function(left_out))
            count = estimates.size
            jackknives.append((float((count - 1.0) / count * ((estimates - estimates.mean()) ** 2).sum()), count - 1.0))
        variance = sum(part for part, _ in jackknives)
        if not variance > 0.0:
            return float(np.sqrt(variance)), 1.0
        return float(np.sqrt(variance)), float(variance**2 / sum(part**2 / freedom for part, freedom in jackknives))

    def half_width(self, function: Callable[[Components], Any], probability: float) -> float:
        """Standard error times Student's quantile at a probability; inf where there is none."""
        from scipy.special import stdtrit

        error, freedom = self.error(function)
        return float(stdtrit(freedom, probability) * error) if np.isfinite(error) else np.inf

    def variance_bounds(self, function: Callable[[Components], Any], confidence: float) -> tuple[float, float, float]:
        """A variance, at least 0, and its bounds; NaN, 0 and inf where it cannot be estimated.

        With h the half width σ² − h bounds it from below, and σ² exp(h/σ²) from above, as an estimated variance is
        skewed; where σ² < h, that is σ² + (e − 1) h.
        """
        estimate = float(function(self.all))
        if not np.isfinite(estimate):
            return np.nan, 0.0, np.inf
        width, variance = self.half_width(function, 0.5 * (1.0 + confidence)), max(estimate, 0.0)
        high = variance * np.exp(width / variance) if variance > width else variance + (np.e - 1.0) * width
        return variance, max(variance - width, 0.0), float(high)

    def most_alike(self, function: Callable[[Components], Any]) -> float:
        """Upper bound of a share of the total variance, 0 to 1; 1 where it cannot be estimated."""

        def share(components: Components) -> Any:
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.clip(np.divide(function(components), components.total), 0.0, 1.0)

        estimate = float(share(self.all))
        width = self.half_width(share, LIKENESS_CONFIDENCE)
        return min(estimate + width, 1.0) if np.isfinite(estimate + width) else 1.0


def analysed(values: Array, recordings: Labels) -> Analysis:
    """Variance components of values (samples, motions), with the jackknife over recordings and blocks of samples.

    ``recordings`` (motions,) are numbers from 0 without gaps, equal for the motions of one recording.
    """
    values = values - values.mean()
    samples, groups = len(values), int(recordings.max()) + 1
    members = np.eye(groups)[recordings]
    blocks = np.arange(samples) % min(samples, MOST_BLOCKS)
    order = np.argsort(blocks, kind="stable")
    starts = np.searchsorted(blocks[order], np.arange(blocks.max() + 1))
    ordered = values[order]
    by_recording = ordered @ members
    grams = np.stack([rows.T @ rows for rows in np.split(by_recording, starts[1:])])
    columns = np.add.reduceat(ordered, starts, axis=0)
    squares = np.add.reduceat(ordered**2 @ members, starts, axis=0)
    counts = np.bincount(blocks).astype(float)
    sizes = np.bincount(recordings).astype(float)

    def without(block: int | None, recording: int | None) -> Components:
        gram, column, square, count = grams.sum(0), columns.sum(0), squares.sum(0), counts.sum()
        if block is not None:
            gram, column = gram - grams[block], column - columns[block]
            square, count = square - squares[block], count - counts[block]
        keep = np.arange(groups) != recording if recording is not None else np.ones(groups, dtype=bool)
        gram, column = gram[np.ix_(keep, keep)], np.where(keep[recordings], column, 0.0)
        shared = column @ members
        return _components(
            _Sums(
                count, sizes[keep], square[keep].sum(), gram.sum(), np.trace(gram), column @ column, shared @ shared,
                column.sum() ** 2,
            )
        )  # fmt: skip

    def stacked(left_out: list[Components]) -> Components:
        return Components(*np.array(left_out).T)

    return Analysis(
        Components(*map(float, without(None, None))),
        stacked([without(None, recording) for recording in range(groups)]),
        stacked([without(block, None) for block in range(len(counts))]),
    )


def outcome_shares(outcomes: NDArray[np.bool_], recordings: Labels) -> tuple[Array, Array]:
    """Shares of the variance that samples and motions have, 0 to 1, each (columns,); 0 of constant outcomes.

    Outcomes, such as whether a gap is closed, are (columns, samples, motions), recordings (motions,) in rising order.
    """
    starts = np.flatnonzero(np.diff(recordings, prepend=-1))
    by_recording = np.add.reduceat(outcomes, starts, axis=2, dtype=np.int32).astype(float)
    rows, columns = by_recording.sum(2), outcomes.sum(1, dtype=float)
    shared = by_recording.sum(1)
    sums = _Sums(
        float(outcomes.shape[1]),
        np.bincount(recordings).astype(float),
        rows.sum(1),
        (rows**2).sum(1),
        (by_recording**2).sum((1, 2)),
        (columns**2).sum(1),
        (shared**2).sum(1),
        rows.sum(1) ** 2,
    )
    components = _components(sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        samples, motions = (np.clip(variance / components.total, 0.0, 1.0) for variance in components[:2])
    return np.nan_to_num(samples), np.nan_to_num(motions)


class Counted(NamedTuple):
    """How many independent outcomes samples and motions stand for.

    ``like_samples`` and ``like_motions`` are upper bounds of the shares of the variance that outcomes of one sample,
    and of one motion, have in common.
    """

    samples: int
    motions: float  # independent ones, by how alike those of a recording are
    like_samples: float
    like_motions: float

    def independent(self, share: Array, samples: Any = 0.0, motions: Any = 0.0) -> Array:
        """Effective number of independent outcomes: 1/n = φ_s/S + φ_m/M + (1 − φ_s − φ_m)/(S M).

        φ_s and φ_m are the correlations of two outcomes, yes or no, of one sample and of one motion: those of normal
        values with the correlations ``like_samples`` and ``like_motions``, at the ``share`` that is contact, or those
        of the outcomes themselves, ``samples`` and ``motions``, where these are larger.
        """
        alike_samples = np.maximum(samples, outcome_correlation(share, self.like_samples))
        alike_motions = np.maximum(motions, outcome_correlation(share, self.like_motions))
        unlike = np.maximum(1.0 - alike_samples - alike_motions, 0.0)
        inverse = alike_samples / self.samples + alike_motions / self.motions + unlike / (self.samples * self.motions)
        return np.asarray(1.0 / inverse)

    def times(self, samples: int, recordings: int) -> Counted:
        """So many times the samples and the recordings, all like these."""
        return self._replace(samples=self.samples * samples, motions=self.motions * recordings)

    def variance_of_mean(self, components: Components) -> float:
        """The variance of the mean over samples and motions; a component below 0 counts as none."""
        samples, motions, interaction = (max(float(component), 0.0) for component in components[:3])
        return samples / self.samples + motions / self.motions + interaction / (self.samples * self.motions)

    @property
    def without_contact(self) -> float:
        """Independent outcomes where all are the same, which does not show what they have in common."""
        return min(self.motions, float(self.samples))


def outcome_correlation(share: Array, correlation: float) -> Array:
    """Correlation of the outcomes that two correlated normal values lie above the quantile that a share exceeds.

    (Φ₂(q, q; ρ) − p²)/(p (1 − p)), p the share, q = Φ⁻¹(p), Φ₂ by Owen's function T: Φ(q) − 2 T(q, √((1 − ρ)/(1 + ρ)));
    ρ at p = 0 and 1. Source: Owen, Annals of Mathematical Statistics 27 (1956).
    """
    from scipy.special import ndtri, owens_t

    is_inside = (share > 0.0) & (share < 1.0)
    p = np.where(is_inside, share, 0.5)
    p_both = p - 2.0 * owens_t(ndtri(p), np.sqrt((1.0 - correlation) / (1.0 + correlation)))
    return np.where(is_inside, (p_both - p**2) / (p * (1.0 - p)), correlation)


def counted_outcomes(logs: Array, recordings: Labels, analysis: Analysis) -> Counted:
    """How many independent outcomes there are, from the logarithms of closings (samples, motions)."""
    return Counted(
        len(logs),
        independent_motions(logs.mean(axis=0), recordings),
        analysis.most_alike(lambda components: components.samples),
        analysis.most_alike(lambda components: components.motions),
    )
