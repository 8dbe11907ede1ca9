"""The gap that a share of the motions needs: percentiles of the closing without contact, with bounds.

A motion closes a gap if and only if its closing without contact is larger, whatever the contact model or F_E: the
percentiles need no contact run.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

USUAL_PERCENTILES = (50.0, 84.0, 95.0)
RESAMPLES = 2000
SEED = 20110314  # the same bounds for the same motions on any day


@dataclass(frozen=True)
class RequiredGap:
    """The gap [m] that is wide enough for ``percentile`` % of the motions.

    ``low`` and ``high`` are bounds by resampling recordings; ``bounded`` is False where so few recordings cannot bound
    the percentile from above at this confidence: then ``high`` is only the largest closing seen. ``fitted`` is that of
    a lognormal distribution with the motions' mean and deviation; NaN where a motion closes nothing.
    """

    percentile: float
    gap: float
    low: float
    high: float
    bounded: bool
    fitted: float


def required_gaps(
    closing: Array, recordings: NDArray[np.int64], percentiles: tuple[float, ...], confidence: float
) -> tuple[RequiredGap, ...]:
    """The gap at each percentile, in rising order.

    Percentiles of the sample are NumPy's "linear": between the order statistics at (i − 1)/(n − 1). Bounds are those
    of 2000 resamples of whole recordings with all their motions (the percentile bootstrap, seeded), since the motions
    of a recording are not independent. A percentile p is bounded from above by the largest of R independent recordings
    only where p^R is below half of 1 − ``confidence``.
    """
    asked = np.array(sorted(set(percentiles)))
    gaps = np.percentile(closing, asked)
    low, high = _resampled(closing, recordings, asked, confidence)
    groups = int(recordings.max()) + 1
    bounded = (asked / 100.0) ** groups <= 0.5 * (1.0 - confidence)
    fitted = lognormal_percentiles(closing, asked)
    columns = zip(asked, gaps, low, high, bounded, fitted, strict=True)
    return tuple(
        RequiredGap(float(p), float(gap), float(a), float(b), bool(known), float(fit))
        for p, gap, a, b, known, fit in columns
    )


def lognormal_percentiles(closing: Array, percentiles: Array) -> Array:
    """exp(m + z s): m and s the mean and deviation (n − 1) of ln closing; NaN where a closing is 0 or alone."""
    from scipy.special import ndtri

    if closing.size < 2 or closing.min() <= 0.0:
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


def _resampled(
    closing: Array, recordings: NDArray[np.int64], percentiles: Array, confidence: float
) -> tuple[Array, Array]:
    """Bounds of each percentile over resamples of whole recordings."""
    groups = [closing[recordings == group] for group in range(int(recordings.max()) + 1)]
    draws = np.random.default_rng(SEED).integers(len(groups), size=(RESAMPLES, len(groups)))
    if len({group.size for group in groups}) == 1:
        found = np.percentile(np.stack(groups)[draws].reshape(RESAMPLES, -1), percentiles, axis=1)
    else:
        found = np.stack(
            [np.percentile(np.concatenate([groups[at] for at in draw]), percentiles) for draw in draws], axis=1
        )
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(found, (tail, 100.0 - tail), axis=1)
    return low, high
