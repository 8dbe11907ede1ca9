"""Hazard curves, and the annual rate of contact or yielding that follows with a fragility.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded; in 50
years the probability is 1 − exp(−50 λ_f), events being independent of each other (Poisson).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.fragility import Fragility, fragility_curve

Array = NDArray[np.float64]

YEARS = 50.0
DRAWS, SEED = 400, 20110314
WIDEST = 6.0  # of ln θ and ln β about the fit: a factor of 400, beyond every hazard curve
LARGEST = 700.0  # exponent of a number that there is
COVERED = 0.05  # the share of the failures that a table may leave out and its rate be called the rate


@dataclass(frozen=True)
class Hazard:
    """Annual rate [1/year] at which each intensity [m/s2] is exceeded; between rows it is a power of the intensity."""

    name: str
    im: Array = field(repr=False)
    rate: Array = field(repr=False)
    source: str = ""


@dataclass(frozen=True)
class Rate:
    """Annual rate and 50-year probability of a failure at one gap [m], over the intensities of the table.

    ``low`` and ``high`` carry the fragility's standard errors, the larger ones, and nothing of the hazard's own
    uncertainty. ``below`` is P(failure) at the table's weakest intensity: weaker motions are left out, and how many
    there are a table does not say. ``above`` is the rate of motions stronger than the table: they add at most that.
    ``missing`` is the share of the failures that the table leaves out, were it continued at both ends at the slope of
    its last rows; ``at_least`` is True where that is more than a twentieth: all numbers are then lower bounds.
    """

    what: str
    gap: float
    yield_force: float | None
    contact_model: str | None
    annual: float
    low: float
    high: float
    fifty_years: float
    below: float
    above: float
    fault: str = ""
    missing: float = nan
    at_least: bool = False


def annual_rate(hazard: Hazard, median: Array | float, dispersion: Array | float) -> Array:
    """Annual rate of failure, ∫ Φ(ln(im/θ)/β) |dλ| over the table; arrays of θ and β give one rate each.

    Exact between two rows, where λ = A im^−k: [−λ Φ(z)] + A θ^−k exp(k²β²/2) [Φ(z + kβ)], z = ln(im/θ)/β, each bracket
    its upper end less its lower one. Over all intensities that is Cornell's (1996) k₀ θ^−k exp(k²β²/2).
    """
    from scipy.special import ndtr

    x, level = np.log(hazard.im), np.log(hazard.rate)
    steep = -np.diff(level) / np.diff(x)
    middle, spread = np.log(np.asarray(median))[..., None], np.asarray(dispersion)[..., None]
    z = (x - middle) / spread
    falls = -np.diff(hazard.rate * ndtr(z), axis=-1)
    moved = steep * spread
    height = level[:-1] + steep * (x[:-1] - middle) + 0.5 * moved**2
    rest = np.exp(height + _log_between(z[..., :-1] + moved, z[..., 1:] + moved))
    return np.asarray(np.maximum(falls + rest, 0.0).sum(axis=-1))


def _log_between(low: Array, high: Array) -> Array:
    """ln(Φ(high) − Φ(low)), evaluated in the tail where the difference keeps its digits."""
    from scipy.special import log_ndtr

    upper = low + high > 0.0
    less, more = log_ndtr(np.where(upper, -high, low)), log_ndtr(np.where(upper, -low, high))
    with np.errstate(divide="ignore"):  # nothing between them: −inf, which is meant
        return np.asarray(more + np.log(-np.expm1(less - more)))


def in_years(annual: float, years: float = YEARS) -> float:
    """Probability of one or more in so many years, 1 − exp(−years × rate)."""
    return float(-np.expm1(-years * annual))


def missing_share(hazard: Hazard, median: float, dispersion: float) -> float:
    """The share of all failures that the table leaves out, were it continued at the slope of its last rows; 0 to 1.

    Beyond a table's ends λ = A im^−k there. Over all im that is Cornell's k₀ θ^−k exp(k²β²/2), over a table's rows
    `annual_rate`: the difference is what weaker and stronger motions add. Hazard curves flatten towards weak motions,
    so that the share is more often told too large than too small.
    """
    inside = float(annual_rate(hazard, median, dispersion))
    tails = [_beyond(hazard, end, median, dispersion) for end in (0, -1)]
    whole = inside + sum(tails)
    return sum(tails) / whole if whole > 0.0 else 0.0


def _beyond(hazard: Hazard, end: int, median: float, dispersion: float) -> float:
    """The rate of failures by motions beyond one end of the table, 0 the weakest and −1 the strongest.

    With x the intensity at that end, λ its rate, k the slope and z = ln(x/θ)/β: below x
    −λ Φ(z) + λ (x/θ)^k exp(k²β²/2) Φ(z + kβ), above it λ Φ(z) + λ (x/θ)^k exp(k²β²/2) [1 − Φ(z + kβ)].
    """
    from scipy.special import log_ndtr, ndtr

    pair = slice(0, 2) if end == 0 else slice(-2, None)
    steep = float(-np.diff(np.log(hazard.rate[pair]))[0] / np.diff(np.log(hazard.im[pair]))[0])
    rate, away = float(hazard.rate[end]), float(np.log(hazard.im[end] / median))
    z, side = away / dispersion, 1.0 if end == 0 else -1.0
    moved = steep * dispersion
    grown = steep * away + 0.5 * moved**2 + float(log_ndtr(side * (z + moved)))
    return max(rate * (float(np.exp(min(grown, LARGEST))) - side * float(ndtr(z))), 0.0)


def rate_of(hazard: Hazard, fragility: Fragility, confidence: float) -> Rate:
    """Annual rate and 50-year probability of one fragility; NaN where that could not be fitted."""
    about = (fragility.what, fragility.gap, fragility.yield_force, fragility.contact_model)
    if fragility.fault:
        return Rate(*about, nan, nan, nan, nan, nan, nan, fragility.fault)
    annual = float(annual_rate(hazard, fragility.median, fragility.dispersion))
    low, high = _bounds(hazard, fragility, confidence)
    below = float(fragility_curve(hazard.im[0], fragility.median, fragility.dispersion))
    missing = missing_share(hazard, fragility.median, fragility.dispersion)
    numbers = (annual, low, high, in_years(annual), below, float(hazard.rate[-1]))
    return Rate(*about, *numbers, missing=missing, at_least=missing > COVERED)


def _bounds(hazard: Hazard, fragility: Fragility, confidence: float) -> tuple[float, float]:
    """Bounds of the rate from draws of (ln θ, ln β), normal with the larger errors of the fragility."""
    of_median, of_dispersion = fragility.errors
    spread = np.array([of_median, of_dispersion / fragility.dispersion])
    if not np.isfinite([*spread, fragility.correlation]).all():
        return nan, nan
    together = np.outer(spread, spread) * [[1.0, fragility.correlation], [fragility.correlation, 1.0]]
    middle = np.log([fragility.median, fragility.dispersion])
    draws = np.random.default_rng(SEED).multivariate_normal(middle, together, DRAWS, method="eigh")
    draws = np.exp(np.clip(draws, middle - WIDEST, middle + WIDEST))
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(annual_rate(hazard, draws[:, 0], draws[:, 1]), (tail, 100.0 - tail))
    return float(low), float(high)
