"""Annual rates: the hazard integral of a fragility, and what the motions leave open of it.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded. Events
are taken to be independent of each other (Poisson).
"""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rates = TypeVar("Rates", float, NDArray[np.float64])

YEARS = 50.0  # of probabilities where no other number of years is given
DRAWS = 2**11  # of the fit: bounds of 95 % of a rate are then good to 2 % with 3 recordings, to 1 % with 6 and more
SEED = 20110314
WIDEST = 6.0  # of ln θ and ln β about the fit: a factor of 400, beyond every hazard curve
LARGEST = 700.0  # exponent of a number that there is
HALVINGS = 50  # of the range in which a median is looked for: 1e-15 of it is left


class Curve(Protocol):
    """Annual rates [1/year] in falling order at rising intensities; between two a power of the intensity."""

    @property
    def im(self) -> Array: ...

    @property
    def rate(self) -> Array: ...


def in_years(annual: float, years: float = YEARS) -> float:
    """Probability of one or more in so many years, 1 − exp(−years × rate)."""
    return float(-np.expm1(-years * annual))


def rate_of_probability(probability: Rates, years: float) -> Rates:
    """Annual rate of what has a probability in so many years, −ln(1 − p) / years."""
    rate: Any = -np.log1p(-probability) / years
    return rate if isinstance(probability, np.ndarray) else float(rate)


def annual_rate(hazard: Curve, median: Array | float, dispersion: Array | float) -> Array:
    """Annual rate of failure, ∫ Φ(ln(im/θ)/β) |dλ|; arrays of θ and β give one rate each.

    Over the table, and for the λ(last row) motions a year that are stronger as often as at that row: no fewer fail.

    Exact between two rows, where λ = A im^−k: [−λ Φ(z)] + A θ^−k exp(k²β²/2) [Φ(z + kβ)], z = ln(im/θ)/β, each bracket
    its upper end less its lower one. Over all intensities that is Cornell's (1996) k₀ θ^−k exp(k²β²/2).
    """
    from scipy.special import ndtr

    log_im, level = np.log(hazard.im), np.log(hazard.rate)
    slope = -np.diff(level) / np.diff(log_im)
    middle, spread = np.log(np.asarray(median))[..., None], np.asarray(dispersion)[..., None]
    z = (log_im - middle) / spread
    falls = -np.diff(hazard.rate * ndtr(z), axis=-1)
    shift = slope * spread
    height = level[:-1] + slope * (log_im[:-1] - middle) + 0.5 * shift**2
    shifted = np.exp(height + _log_between(z[..., :-1] + shift, z[..., 1:] + shift))
    beyond = hazard.rate[-1] * ndtr(z[..., -1])
    return np.asarray(np.maximum(falls + shifted, 0.0).sum(axis=-1) + beyond)


def _log_between(low: Array, high: Array) -> Array:
    """ln(Φ(high) − Φ(low)), evaluated in the tail where the difference keeps its digits."""
    from scipy.special import log_ndtr

    is_upper = low + high > 0.0
    log_low, log_high = log_ndtr(np.where(is_upper, -high, low)), log_ndtr(np.where(is_upper, -low, high))
    with np.errstate(divide="ignore"):  # nothing between them: −inf, which is meant
        return np.asarray(log_high + np.log(-np.expm1(log_low - log_high)))


def missing_share(hazard: Curve, median: float, dispersion: float) -> float:
    """The share of all failures that `annual_rate` leaves out, were the table continued at the slope of its last rows.

    Beyond a table's ends λ = A im^−k there. Over all im that is Cornell's k₀ θ^−k exp(k²β²/2): the difference is what
    weaker motions add, and stronger ones beyond what is counted of them. Hazard curves flatten towards weak motions,
    so that the share is more often too large than too small.
    """
    rate_inside = float(annual_rate(hazard, median, dispersion))
    tails = [_rate_beyond(hazard, end, median, dispersion) for end in (0, -1)]
    rate_in_all = rate_inside + sum(tails)
    return sum(tails) / rate_in_all if rate_in_all > 0.0 else 0.0


def _rate_beyond(hazard: Curve, end: int, median: float, dispersion: float) -> float:
    """The rate of failures beyond one end of the table that is not counted, 0 the weakest and −1 the strongest.

    With x the intensity at that end, λ its rate, k the slope and z = ln(x/θ)/β: below x
    −λ Φ(z) + λ (x/θ)^k exp(k²β²/2) Φ(z + kβ), above it λ (x/θ)^k exp(k²β²/2) [1 − Φ(z + kβ)] beside λ Φ(z).
    """
    from scipy.special import log_ndtr, ndtr

    ends = slice(0, 2) if end == 0 else slice(-2, None)
    slope = float(-np.diff(np.log(hazard.rate[ends]))[0] / np.diff(np.log(hazard.im[ends]))[0])
    rate, distance = float(hazard.rate[end]), float(np.log(hazard.im[end] / median))
    z, sign = distance / dispersion, 1.0 if end == 0 else -1.0
    shift = slope * dispersion
    exponent = slope * distance + 0.5 * shift**2 + float(log_ndtr(sign * (z + shift)))
    return max(rate * (float(np.exp(min(exponent, LARGEST))) - (float(ndtr(z)) if end == 0 else 0.0)), 0.0)


def median_at_rate(hazard: Curve, dispersion: Array | float, rate: float, halvings: int = HALVINGS) -> Array:
    """The median at which fragilities of these dispersions fail at an annual rate; arrays give one median each.

    The rate falls from λ(first row) to 0 as the median grows: found by ``halvings`` of the range of its logarithm.
    Raises ValueError for a rate that no median has.
    """
    dispersions = np.asarray(dispersion, dtype=float)
    if not 0.0 < rate < hazard.rate[0]:
        raise ValueError(f"no median fails at {rate} a year between the rows of the hazard curve")
    low = np.log(hazard.im[0]) - 40.0 * dispersions  # all fail
    high = np.log(hazard.im[-1]) + 40.0 * dispersions  # none does
    with np.errstate(over="ignore"):
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            is_above = annual_rate(hazard, np.exp(np.clip(middle, -LARGEST, LARGEST)), dispersions) > rate
            low, high = np.where(is_above, middle, low), np.where(is_above, high, middle)
        return np.asarray(np.exp(0.5 * (low + high)))


def draws(estimates: tuple[float, float], median_error: float, degrees: float) -> tuple[Array, Array]:
    """Medians and dispersions that the motions leave possible, (draws,) each.

    Those of a normal sample whose deviation has so many ``degrees`` of freedom ν: β² (ν + 1)/χ²(ν) for the dispersion,
    the estimate being that of maximum likelihood, and ln θ normal about its own with ``median_error`` times the drawn
    dispersion over the estimate (Krishnamoorthy and Mathew 2003). Few recordings bound a dispersion badly, and a rate
    grows with exp(β²): normal errors of ln β would miss that.
    """
    from scipy.special import gammaincinv, ndtri

    middle = np.log(estimates)
    abscissa, ordinate = _hammersley()
    wider = 0.5 * np.log((degrees + 1.0) / (2.0 * gammaincinv(0.5 * degrees, abscissa)))
    drawn = middle + np.stack([median_error * np.exp(wider) * ndtri(ordinate), wider], axis=1)
    drawn = np.exp(np.clip(drawn, middle - WIDEST, middle + WIDEST))
    return drawn[:, 0], drawn[:, 1]


def _hammersley() -> tuple[Array, Array]:
    """Points that fill the unit square evenly (Hammersley 1960), in the middle of their cells; a power of 2 of them."""
    places = np.arange(DRAWS)
    mirrored = np.zeros(DRAWS, dtype=int)
    for digit in range(DRAWS.bit_length() - 1):
        mirrored = 2 * mirrored + (places >> digit & 1)
    return (places + 0.5) / DRAWS, (mirrored + 0.5) / DRAWS


def counted_gap(hazard: Curve, unit: Array, rate: float) -> float:
    """The gap [m] that motions of these capacities a metre close at a rate, each as often as the hazard curve says.

    The rate of a motion is λ at its capacity: stronger ones close the gap too, those beyond the last row among them.
    Beyond that row λ goes on at the slope of the last two, and below the first it is that row's.
    """
    from scipy.optimize import brentq

    im, annual = np.log(hazard.im), np.log(hazard.rate)
    slope = (annual[-2] - annual[-1]) / (im[-1] - im[-2])

    def often(log_gap: float) -> float:
        capacities = np.log(unit) + log_gap
        excess = slope * np.maximum(capacities - im[-1], 0.0)
        return float(np.exp(np.interp(capacities, im, annual) - excess).mean())

    low, high = im[0] - np.log(unit.max()), im[-1] - np.log(unit.min())
    high += max(annual[-1] - np.log(rate), 0.0) / slope
    return float(np.exp(brentq(lambda log_gap: often(log_gap) - rate, low, high)))
