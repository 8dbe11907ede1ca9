"""What each uncertain number contributes to the variance of an output: Sobol indices, and a tornado.

The first-order index of a number is the share of the variance that would go, on average, were it known exactly; the
total index is the share that would remain, were all others known. Independent numbers have both from a design of their
own (Saltelli), any numbers the first from samples that are there already. Indices of correlated numbers share what the
numbers have in common, and their sum may be above 1.

Sources: Sobol, Mathematics and Computers in Simulation 55 (2001); Saltelli and others, Computer Physics Communications
181 (2010), as `scipy.stats.sobol_indices` has it; Plischke, Borgonovo and Smith, European Journal of Operational
Research 226 (2013), on indices from given samples; Kelley, PNAS 21 (1935), on the correlation ratio without bias.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.scene.sampling import SOBOL, points_of

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

RESAMPLES = 200  # of the bootstrap
MOST_BINS = 25
LEAST_SAMPLES = 8  # from which indices are given
FEW_VALUES = 8  # of a number; each has a bin of its own
SEED = 20260101  # of the bootstrap: the same bounds for the same outputs
QUANTILES = (0.1, 0.5, 0.9)  # between which a tornado moves a number


class Indices(NamedTuple):
    """Indices of each output and number, with bounds, each (outputs, numbers); NaN where an output does not vary."""

    value: Array
    low: Array
    high: Array


# ------------------------------------------------------------------------------------------------ a design of its own


def saltelli_points(numbers: int, num: int, seed: int) -> Array:
    """Points of the unit cube for Sobol indices, (num × (numbers + 2), numbers).

    A, B, and for each number A with the column of B; A and B are the halves of scrambled Sobol points.

    Parameters
    ----------
    numbers : int
        Dimensions of the cube.
    num : int
        Points of A and of B, a power of two.
    seed : int
        Of the scrambling.
    """
    both = points_of(SOBOL, num, 2 * numbers, seed)
    a, b = both[:, :numbers], both[:, numbers:]
    mixed = [np.where(np.arange(numbers) == column, b, a) for column in range(numbers)]
    return np.concatenate([a, b, *mixed])


def power_of_two(num: int) -> int:
    """The next power of two that is no less."""
    return 1 << max(int(num) - 1, 0).bit_length()


def sobol_indices(outputs: Array, numbers: int, confidence: float) -> tuple[Indices, Indices]:
    """First-order and total indices from outputs at `saltelli_points`, (outputs, points), with bootstrapped bounds.

    Whole rows of the design are drawn again; its points are counted as if they were drawn independently.
    """
    from scipy import stats

    num = outputs.shape[1] // (numbers + 2)
    varies = np.ptp(outputs[:, : 2 * num], axis=1) > 0.0
    centred = np.where(varies[:, None], outputs - outputs[:, : 2 * num].mean(axis=1, keepdims=True), 0.0)
    parts = centred[varies].reshape(-1, numbers + 2, num)

    def indices(rows: Any) -> Array:
        chosen = parts[:, :, rows]
        indices_of_rows = stats.sobol_indices(
            func={"f_A": chosen[:, 0], "f_B": chosen[:, 1], "f_AB": chosen[:, 2:].swapaxes(0, 1)}, n=num
        )
        return np.stack([indices_of_rows.first_order, indices_of_rows.total_order]).reshape(2, len(parts), numbers)

    shape = (2, len(outputs), numbers)
    value, low, high = (np.full(shape, np.nan) for _ in range(3))
    if varies.any():
        draw = np.random.default_rng(SEED)
        with np.errstate(divide="ignore", invalid="ignore"):  # a drawn part that does not vary
            drawn = np.stack([indices(draw.integers(num, size=num)) for _ in range(RESAMPLES)])
        value[:, varies] = indices(slice(None))
        low[:, varies], high[:, varies] = _middle(drawn, confidence)
    return Indices(value[0], low[0], high[0]), Indices(value[1], low[1], high[1])


def _middle(drawn: Array, confidence: float) -> Array:
    """The quantiles between which the drawn values lie with a confidence."""
    tail = 50.0 * (1.0 - confidence)
    known = np.where(np.isfinite(drawn), drawn, np.nan)  # a draw may have samples of one output alone
    return np.asarray(np.nanpercentile(known, [tail, 100.0 - tail], axis=0))


# --------------------------------------------------------------------------------------------- samples that are there


class _Binned(NamedTuple):
    """A number's samples in bins of equal count, and the rank of each within all, 0 to 1; both (samples,)."""

    bins: Labels
    ranks: Array


def given_indices(values: Sequence[NDArray[Any]], outputs: Array, confidence: float) -> Indices:
    """First-order indices from samples that are there, correlated or not, with bootstrapped bounds.

    A number's samples are put into bins of equal count, equal values into one. The mean of the output, given the
    number, is a straight line over its ranks in each bin; the index is the share of the variance that these lines have,
    less what they have by chance: 1 − (Σ beside the lines/(n − k))/(Σ whole/(n − 1)), for n samples and lines of k
    coefficients.

    Parameters
    ----------
    values : sequence of array
        Of each number its value in each sample: numbers or texts.
    outputs : array, shape (outputs, samples)
        The outputs.
    confidence : float
        Of the bounds.
    """
    numbers = [_binned(np.asarray(one)) for one in values]
    value, low, high = (np.full((len(outputs), len(numbers)), np.nan) for _ in range(3))
    samples = outputs.shape[1]
    draws = np.random.default_rng(SEED).integers(samples, size=(RESAMPLES, samples))
    for row, output in enumerate(outputs):
        if samples < LEAST_SAMPLES or not np.ptp(output) > 0.0:
            continue
        centred = output - output.mean()
        for column, number in enumerate(numbers):
            these = _Binned(number.bins[None], number.ranks[None])
            share, corrected = (float(part[0]) for part in _ratio(these, centred[None]))
            # What is drawn varies about the share of these samples, chance and all: the bounds lose that chance too.
            drawn = _ratio(_Binned(number.bins[draws], number.ranks[draws]), centred[draws])[1] - (share - corrected)
            value[row, column] = corrected
            low[row, column], high[row, column] = _middle(drawn, confidence)
    return Indices(value, low, high)


def _binned(values: NDArray[Any]) -> _Binned:
    """Bins of equal count by rising value, √n/4 of them or one; of texts and of few values, one for each value."""
    count = int(np.clip(round(0.25 * np.sqrt(values.size)), 1, MOST_BINS))
    known, places, sizes = np.unique(values, return_inverse=True, return_counts=True)
    if known.size <= FEW_VALUES or values.dtype.kind not in "fiu":
        return _Binned(places.astype(np.int64), np.zeros(values.size))
    ranks = ((np.cumsum(sizes) - 0.5 * sizes) / values.size)[places]
    bins = np.unique((ranks * count).astype(np.int64), return_inverse=True)[1]
    return _Binned(bins.astype(np.int64), ranks)


def _ratio(number: _Binned, outputs: Array) -> tuple[Array, Array]:
    """Share of the variance that the lines have, of these samples and less chance, of each row of (rows, samples)."""
    rows, samples = outputs.shape
    most = int(number.bins.max()) + 1
    flat = (number.bins + most * np.arange(rows)[:, None]).ravel()

    def summed(weights: Array | None = None) -> Array:
        whole = None if weights is None else weights.ravel()
        return np.bincount(flat, whole, minlength=rows * most).reshape(rows, most).astype(float)

    counts, of_outputs, of_ranks = summed(), summed(outputs), summed(number.ranks)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = summed(number.ranks**2) - of_ranks**2 / counts
        slanted = spread > 1e-12
        between = np.where(counts > 0.0, of_outputs**2 / counts, 0.0)
        together = summed(number.ranks * outputs) - of_ranks * of_outputs / counts
        lines = np.where(slanted, together**2 / spread, 0.0)
        mean = outputs.sum(axis=1) ** 2 / samples
        share = ((between + lines).sum(axis=1) - mean) / ((outputs**2).sum(axis=1) - mean)
        used = (counts > 0.0).sum(axis=1) + slanted.sum(axis=1)
        return share, 1.0 - (1.0 - share) * (samples - 1.0) / np.maximum(samples - used, 1.0)


# ---------------------------------------------------------------------------------------------------------- a tornado


def tornado_points(numbers: int) -> Array:
    """Points of the unit cube: all at their medians, then each number alone at its 10 % and at its 90 % quantile."""
    low, middle, high = QUANTILES
    points = np.full((1 + 2 * numbers, numbers), middle)
    for number in range(numbers):
        points[1 + 2 * number, number], points[2 + 2 * number, number] = low, high
    return points
