"""Shares of few motions with exact bounds, for motions of one recording that are not independent.

Components and polarities of one recording are not independent: one strong recording closes a gap in several of them.
Bounds that count every motion as independent are then too narrow. The design effect (Kish 1965) says how many motions
stand for one independent motion; with the count of independent motions the exact binomial bounds of Clopper and
Pearson (1934) are those of Korn and Graubard (1998).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

LIKENESS_CONFIDENCE = 0.95


@dataclass(frozen=True)
class Share:
    """Share of the motions that fail at one gap [m], by contact, or by yielding at one F_E [N] and contact model.

    ``low`` and ``high`` are exact for motions that are independent of each other, ``low_recordings`` and
    ``high_recordings`` for as many as they really stand for (see `independent_motions`). ``left_out`` are runs that
    failed, or in which an instant jump has no force: they count neither way.
    """

    gap: float
    count: int
    runs: int
    probability: float
    low: float
    high: float
    low_recordings: float
    high_recordings: float
    left_out: int = 0
    yield_force: float | None = None
    contact_model: str | None = None


def shares(failed: Array, cases: Sequence[dict[str, Any]], independent: float, confidence: float) -> tuple[Share, ...]:
    """One share for each column of ``failed`` (motions, columns): 1, 0, or NaN for a run that is left out.

    ``independent`` is what one motion counts for, at most 1; ``cases`` are a column's gap and the like.
    """
    is_run = ~np.isnan(failed)
    runs, counts = is_run.sum(axis=0), np.where(is_run, failed, 0.0).sum(axis=0)
    low, high = exact_bounds(counts, runs, confidence)
    low_recordings, high_recordings = exact_bounds(counts * independent, runs * independent, confidence)
    probabilities = counts / np.where(runs > 0, runs, np.nan)
    columns = zip(cases, counts, runs, probabilities, low, high, low_recordings, high_recordings, strict=True)
    return tuple(
        Share(
            count=int(count),
            runs=int(number),
            probability=float(probability),
            low=float(low),
            high=float(high),
            low_recordings=float(low_recordings),
            high_recordings=float(high_recordings),
            left_out=len(failed) - int(number),
            **case,
        )
        for case, count, number, probability, low, high, low_recordings, high_recordings in columns
    )


def exact_bounds(count: ArrayLike, runs: ArrayLike, confidence: float) -> tuple[Array, Array]:
    """Clopper and Pearson's two-sided bounds of a probability of which ``count`` of ``runs`` are seen.

    low = B(α/2; k, n − k + 1), high = B(1 − α/2; k + 1, n − k), B the quantile of the beta distribution and α = 1 −
    ``confidence``; 0 and 1 where k is 0 and n, NaN without runs. Counts need not be whole (Korn and Graubard 1998).
    Source: Clopper and Pearson, Biometrika 26 (1934).

    >>> low, high = exact_bounds(0, 10, 0.95)
    >>> round(float(high), 4)  # 1 - 0.025^(1/10)
    0.3085
    """
    from scipy.special import betaincinv  # `scipy.stats`, which has its bits, takes longer to import than to answer

    k, n = np.broadcast_arrays(np.asarray(count, dtype=float), np.asarray(runs, dtype=float))
    tail = 0.5 * (1.0 - confidence)
    is_none, is_all = k <= 0.0, k >= n
    low = np.where(is_none, 0.0, betaincinv(np.where(is_none, 1.0, k), np.maximum(n - k, 0.0) + 1.0, tail))
    high = np.where(is_all, 1.0, betaincinv(k + 1.0, np.where(is_all, 1.0, n - k), 1.0 - tail))
    return np.where(n > 0.0, low, np.nan), np.where(n > 0.0, high, np.nan)


def least_upper_bound(motions: float, confidence: float) -> float:
    """The upper bound where none of so many independent motions fails: 1 − (α/2)^(1/n); 1 without motions."""
    return 1.0 - (0.5 * (1.0 - confidence)) ** (1.0 / motions) if motions > 0.0 else 1.0


def motions_to_show(target: float, confidence: float) -> int:
    """Independent motions, none of them failing, that bring the upper bound down to ``target``."""
    return int(np.ceil(np.log(0.5 * (1.0 - confidence)) / np.log1p(-target) - 1e-9))


def likeness(values: Array, recordings: NDArray[np.int64]) -> float:
    """Upper bound, at 95 %, of the intraclass correlation of ``values`` within recordings, 0 to 1.

    ρ = (f − 1)/(f + m₀ − 1), f = F/F₀.₀₅, F = MSB/MSW of the analysis of variance, F₀.₀₅ the 5 % quantile of its
    distribution with R − 1 and N − R degrees of freedom, m₀ = (N − Σm²/N)/(R − 1), for R recordings of m motions, N in
    all. A bound, since few recordings do not show how alike their motions are: it is 1 for one recording. 0 where no
    recording has two motions. Source: Donner, Int. Stat. Rev. 54 (1986).
    """
    from scipy.special import fdtri

    sizes, sums = np.bincount(recordings), np.bincount(recordings, values)
    total, groups = values.size, sizes.size
    if groups == total:
        return 0.0
    if groups < 2:
        return 1.0
    means = sums / sizes
    between = float((sizes * (means - values.mean()) ** 2).sum()) / (groups - 1)
    within = float(((values - means[recordings]) ** 2).sum()) / (total - groups)
    mean_size = (total - float((sizes**2).sum()) / total) / (groups - 1)
    raised_between = between / float(fdtri(groups - 1, total - groups, 1.0 - LIKENESS_CONFIDENCE))
    denominator = raised_between + (mean_size - 1.0) * within
    return float(np.clip((raised_between - within) / denominator, 0.0, 1.0)) if denominator > 0.0 else 1.0


def independent_motions(values: Array, recordings: NDArray[np.int64]) -> float:
    """Effective number of independent motions: N over the design effect 1 + (Σm²/N − 1) ρ.

    ``values`` show how alike motions of a recording are, such as the logarithm of the closing. Outcomes, yes or no, of
    values that are normal are no more alike; those of a few recordings that close far more in all their motions are.
    Between the number of recordings and that of motions.
    """
    sizes = np.bincount(recordings)
    total = float(values.size)
    effect = 1.0 + (float((sizes**2).sum()) / total - 1.0) * likeness(values, recordings)
    return max(total / effect, 1.0)


def numbered(recordings: NDArray[np.int64]) -> NDArray[np.int64]:
    """Recordings numbered from 0 without gaps, in their order."""
    return np.unique(recordings, return_inverse=True)[1].astype(np.int64)


def labels(names: list[Any]) -> NDArray[np.int64]:
    """Numbers from 0, equal where the names are equal, in the order in which they come."""
    numbers: dict[Any, int] = {}
    return np.array([numbers.setdefault(name, len(numbers)) for name in names], dtype=np.int64)


def joined(keys: Iterable[Sequence[Hashable]]) -> NDArray[np.int64]:
    """Numbers from 0, equal for those that share a key, with each other or through others, in the order of `labels`."""
    joins: dict[Hashable, Hashable] = {}

    def root(key: Hashable) -> Hashable:
        while joins.setdefault(key, key) != key:
            key = joins[key]
        return key

    first_keys = []
    for key, *further_keys in keys:
        for other in further_keys:
            joins[root(other)] = root(key)
        first_keys.append(key)
    return labels([root(key) for key in first_keys])


def logs_of(closing: Array) -> Array:
    """Logarithms of closings; what closes nothing counts as the least that does, and inf as the largest."""
    finite = closing[(closing > 0.0) & np.isfinite(closing)]
    return np.asarray(np.log(np.clip(closing, finite.min(initial=1.0), finite.max(initial=0.0) or 1.0)))
