"""What each uncertain number contributes to the variance of an output: Sobol indices, and a tornado.

The first-order index of a number is the share of the variance that would go, on average, were it known exactly; the
total index is the share that would remain, were all others known. Independent numbers have both from a design of their
own (Saltelli), any numbers the first from samples that are there already. Indices of correlated numbers share what the
numbers have in common, and their sum may be above 1.

Sources: Sobol, Mathematics and Computers in Simulation 55 (2001); Saltelli and others, Computer Physics Communications
181 (2010), as `scipy.stats.sobol_indices` has it; Plischke, Borgonovo and Smith, European Journal of Operational
Research 226 (2013), on indices from given samples; Kelley, PNAS 21 (1935), on the correlation ratio without bias;
Doksum and Samarov, Annals of Statistics 23 (1995), on its estimate by a smooth fit and its influence function; Hastie,
Tibshirani and Friedman, The Elements of Statistical Learning (2009), 5.2.1, on natural splines.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESAMPLES = 200  # of the bootstrap
LEAST_SAMPLES = 128  # from which indices are given, and their bounds hold
MOST_COEFFICIENTS = 32  # of a spline
OUTER_KNOT = 0.02  # quantile of the first knot, and of the last from above
FEW_VALUES = 8  # of a number; each has a mean of its own
LEAST_LEFT = 1e-24  # of the variance, below which residuals are rounding
MOST_LEVERAGE = 1.0 - 1e-9
SEED = 20260101  # of the bootstrap: the same bounds for the same outputs
QUANTILES = (0.1, 0.5, 0.9)  # between which a tornado moves a number


class Indices(NamedTuple):
    """Indices of each output and number, with bounds, each (outputs, numbers); NaN where an output does not vary."""

    value: Array
    low: Array
    high: Array

    @property
    def width(self) -> Array:
        """Mean width of the bounds of each output, (outputs,)."""
        return np.asarray((self.high - self.low).mean(axis=1))


# ------------------------------------------------------------------------------------------------ a design of its own


def saltelli_points(points: Array) -> Array:
    """Points of a cube for Sobol indices, A, B, and for each number A with the column of B, below each other.

    A and B are the halves of scrambled Sobol points (num, 2 × numbers), num a power of two.
    """
    numbers = points.shape[1] // 2
    a, b = points[:, :numbers], points[:, numbers:]
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
    is_varying = np.ptp(outputs[:, : 2 * num], axis=1) > 0.0
    centred = np.where(is_varying[:, None], outputs - outputs[:, : 2 * num].mean(axis=1, keepdims=True), 0.0)
    blocks = centred[is_varying].reshape(-1, numbers + 2, num)

    def indices(rows: Any) -> Array:
        sample = blocks[:, :, rows]
        indices_of_rows = stats.sobol_indices(
            func={"f_A": sample[:, 0], "f_B": sample[:, 1], "f_AB": sample[:, 2:].swapaxes(0, 1)}, n=num
        )
        return np.stack([indices_of_rows.first_order, indices_of_rows.total_order]).reshape(2, len(blocks), numbers)

    estimate, low, high = (np.full((2, len(outputs), numbers), np.nan) for _ in range(3))
    if is_varying.any():
        draw = np.random.default_rng(SEED)
        with np.errstate(divide="ignore", invalid="ignore"):  # a drawn part that does not vary
            drawn_indices = np.stack([indices(draw.integers(num, size=num)) for _ in range(RESAMPLES)])
        estimate[:, is_varying] = indices(slice(None))
        low[:, is_varying], high[:, is_varying] = _quantile_bounds(drawn_indices, confidence)
    return Indices(estimate[0], low[0], high[0]), Indices(estimate[1], low[1], high[1])


def _quantile_bounds(drawn: Array, confidence: float) -> Array:
    """The quantiles between which the drawn values lie with a confidence."""
    tail = 50.0 * (1.0 - confidence)
    finite = np.where(np.isfinite(drawn), drawn, np.nan)  # a draw may have samples of one output alone
    return np.asarray(np.nanpercentile(finite, [tail, 100.0 - tail], axis=0))


# --------------------------------------------------------------------------------------------- samples that are there


def given_indices(
    values: Sequence[NDArray[Any]], outputs: Array, confidence: float, is_balanced: bool = False
) -> Indices:
    """First-order indices from samples that are there, correlated or not, with bounds; NaN of too few samples.

    The mean of the output, given a number, is fitted by a natural cubic spline of k = √n coefficients beside the mean,
    or by the mean of each value of texts and of few values. With R the variance of the residuals, over n − k − 1, and
    V that of the output, the index is 1 − R/V. Bounds are those of ln(R/V), whose variance is that of its influence
    function, (residual/√(1 − leverage))²/R − (deviation from the mean)²/V over n samples, and 2k/n² for what the k
    coefficients have by chance; Student's quantile of n − k − 1. So no bound is above 1. docs/theory/uncertain.md has
    how often bounds of 95 % hold; below `LEAST_SAMPLES` a narrow maximum is missed.

    In Sobol points the other numbers are spread evenly beside each value of one, and k coefficients have little or
    nothing by chance. R is then that over n − 1, and its lower bound is that over n − k − 1.

    Of each number there is its value in each sample, a number or a text; ``outputs`` are (outputs, samples).
    ``is_balanced`` says that the samples are Sobol points.
    """
    samples = outputs.shape[1]
    columns = (np.full((3, len(outputs)), np.nan) for _ in values)
    if samples >= LEAST_SAMPLES:
        columns = (_index(_basis(np.asarray(number)), outputs, confidence, is_balanced) for number in values)
    return Indices(*np.stack(list(columns), axis=-1))


def _index(basis: Array, outputs: Array, confidence: float, is_balanced: bool) -> Array:
    """Index and bounds of each output by a fit in the columns of an orthonormal basis, (3, outputs)."""
    from scipy import special

    samples, size = basis.shape
    freedom = samples - size
    bounds = np.full((3, len(outputs)), np.nan)
    is_varying = np.ptp(outputs, axis=1) > 0.0
    if not is_varying.any() or size < 2 or freedom < samples // 2:
        return bounds
    deviations = outputs[is_varying] - outputs[is_varying].mean(axis=1, keepdims=True)
    variance = (deviations**2).sum(axis=1, keepdims=True) / (samples - 1)
    residuals = deviations - deviations @ basis @ basis.T
    residual_variance = np.maximum((residuals**2).sum(axis=1, keepdims=True) / freedom, LEAST_LEFT * variance)
    leverage = np.minimum((basis**2).sum(axis=1), MOST_LEVERAGE)
    influence = residuals**2 / (1.0 - leverage) / residual_variance - deviations**2 / variance
    influence -= influence.mean(axis=1, keepdims=True)
    error = np.sqrt((influence**2).mean(axis=1) / samples + 2.0 * (size - 1) / samples**2)
    half_width = special.stdtrit(freedom, 0.5 + 0.5 * confidence) * error
    ratio = (residual_variance / variance)[:, 0]
    least_ratio = ratio * freedom / (samples - 1) if is_balanced else ratio  # were nothing of the fit by chance
    bounds[:, is_varying] = 1.0 - least_ratio, 1.0 - ratio * np.exp(half_width), 1.0 - least_ratio * np.exp(-half_width)
    return bounds


def _basis(values: NDArray[Any]) -> Array:
    """An orthonormal basis of functions of a number, the constant among them, (samples, functions)."""
    levels, places = np.unique(values, return_inverse=True)
    if levels.size <= FEW_VALUES or values.dtype.kind not in "fiu":
        functions = (places[:, None] == np.arange(levels.size)).astype(float)
    else:
        functions = _natural_spline(values.astype(float))
    return np.asarray(np.linalg.qr(functions)[0])


def _natural_spline(values: Array) -> Array:
    """Natural cubic splines, straight beyond the outer knots, with knots at quantiles of the values."""
    count = min(round(values.size**0.5), MOST_COEFFICIENTS) + 1
    knots = np.unique(np.quantile(values, np.linspace(OUTER_KNOT, 1.0 - OUTER_KNOT, count)))
    places, knots = (values - knots[0]) / np.ptp(knots), (knots - knots[0]) / np.ptp(knots)
    beyond = np.clip(places[:, None] - knots, 0.0, None) ** 3
    slopes = (beyond[:, :-1] - beyond[:, -1:]) / (1.0 - knots[:-1])
    return np.column_stack([np.ones_like(places), places, slopes[:, :-1] - slopes[:, -1:]])


# ---------------------------------------------------------------------------------------------------------- a tornado


def tornado_points(numbers: int) -> Array:
    """Points of the unit cube: all at their medians, then each number alone at its 10 % and at its 90 % quantile."""
    low, middle, high = QUANTILES
    points = np.full((1 + 2 * numbers, numbers), middle)
    for number in range(numbers):
        points[1 + 2 * number, number], points[2 + 2 * number, number] = low, high
    return points
