"""Hazard curves, and the annual rate of contact or yielding that follows with a fragility.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded; in 50
years the probability is 1 − exp(−50 λ_f), events being independent of each other (Poisson).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.annual_rates import in_years
from pounding_risk.assessment.fragility import Fragility, fragility_curve
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import Spectral, spectral

Array = NDArray[np.float64]

DRAWS, SEED = 400, 20110314
WIDEST = 6.0  # of ln θ and ln β about the fit: a factor of 400, beyond every hazard curve
LARGEST = 700.0  # exponent of a number that there is
HALVINGS = 50  # of the range in which a median is looked for: 1e-15 of it is left
COVERED = 0.05  # the share of the failures that a table may leave out and its rate be called the rate


@dataclass(frozen=True)
class Hazard:
    """Annual rate [1/year] at which each intensity [SI] is exceeded; between rows it is a power of the intensity.

    ``name`` is the intensity, "pga", "pgv", "sa(0.5 s)" or "sa_avg(0.2-2 s)". ``reading`` are sentences on how the
    table was read: conversions to annual rates, and interpolation between periods.
    """

    name: str
    im: Array = field(repr=False)
    rate: Array = field(repr=False)
    source: str = ""
    reading: str = ""


@dataclass(frozen=True)
class HazardSpectrum:
    """Intensities that are exceeded at the same annual rates at several periods: uniform hazard spectra.

    ``periods`` [s] rise and ``rate`` [1/year] falls; ``im`` (rates, periods) are spectral accelerations [m/s2] at one
    ``damping`` ratio, ``pga`` (rates,) those of the ground where the table has them. ``reading`` as in `Hazard`.
    """

    periods: Array
    rate: Array = field(repr=False)
    im: Array = field(repr=False)
    damping: float = 0.05
    pga: Array | None = field(default=None, repr=False)
    source: str = ""
    reading: str = ""

    def at(self, intensity: str) -> Hazard:
        """The hazard curve of "pga" or of "sa(0.62 s)".

        Between two periods the intensity of each rate is a power of the period. Raises PoundingError for another
        intensity, for a damping ratio other than the table's, and for a period outside its periods.
        """
        if intensity == "pga":
            if self.pga is None:
                raise PoundingError(f"{self.source}: has no column of pga; {self._repair}")
            return Hazard("pga", self.pga, self.rate, self.source, self.reading)
        asked = spectral(intensity[3:-1]) if intensity.startswith("sa(") else None
        if asked is None:
            raise PoundingError(f"{self.source}: has no curve of {intensity}; {self._repair}")
        if not asked.is_at(Spectral(asked.period, self.damping)):
            raise PoundingError(
                f"{self.source}: has spectra of {100.0 * self.damping:g} % damping, and {intensity} is asked for; "
                f'write --intensity "{Spectral(asked.period, self.damping).intensity}"'
            )
        first, last = float(self.periods[0]), float(self.periods[-1])
        if not first <= asked.period <= last:
            raise PoundingError(
                f"{self.source}: has spectra from {first:g} s to {last:g} s, and {intensity} is asked for; add that "
                f"period to the table, or {self._repair}"
            )
        x = np.log(self.periods)
        im = np.array([np.exp(np.interp(np.log(asked.period), x, np.log(spectrum))) for spectrum in self.im])
        return Hazard(
            intensity, im, self.rate, self.source, " ".join(filter(None, (self.reading, self._between(asked))))
        )

    @property
    def _repair(self) -> str:
        damping = "" if self.damping == Spectral(1.0).damping else f", {100.0 * self.damping:g} %"
        return f'choose one of its own, such as --intensity "sa({self.periods[0]:g} s{damping})"'

    def _between(self, asked: Spectral) -> str:
        """Sentence on the periods between which a curve is read; "" at a period of the table."""
        if np.isclose(self.periods, asked.period, rtol=1e-9, atol=0.0).any():
            return ""
        after = int(np.searchsorted(self.periods, asked.period))
        low, high = self.periods[after - 1], self.periods[after]
        return (
            f"{asked.words} is read between {low:g} s and {high:g} s, by straight lines in the logarithms at equal "
            "rates."
        )


@dataclass(frozen=True)
class Rate:
    """Annual rate and 50-year probability of a failure at one gap [m], over the intensities of the table.

    ``low`` and ``high`` carry what the motions leave open of the fragility (`draws`), and nothing of the hazard's own
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


def median_at_rate(hazard: Hazard, dispersion: Array | float, rate: float, halvings: int = HALVINGS) -> Array:
    """The median at which fragilities of these dispersions fail at an annual rate; arrays give one median each.

    The rate falls from λ(first row) − λ(last row) to 0 as the median grows: found by ``halvings`` of the range of its
    logarithm. Raises ValueError for a rate that no median has.
    """
    spread = np.asarray(dispersion, dtype=float)
    if not 0.0 < rate < hazard.rate[0] - hazard.rate[-1]:
        raise ValueError(f"no median fails at {rate} a year between the rows of {hazard.name}")
    low = np.log(hazard.im[0]) - 40.0 * spread  # all fail
    high = np.log(hazard.im[-1]) + 40.0 * spread  # none does
    with np.errstate(over="ignore"):
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            often = annual_rate(hazard, np.exp(np.clip(middle, -LARGEST, LARGEST)), spread) > rate
            low, high = np.where(often, middle, low), np.where(often, high, middle)
        return np.asarray(np.exp(0.5 * (low + high)))


def _bounds(hazard: Hazard, fragility: Fragility, confidence: float) -> tuple[float, float]:
    """Bounds of the rate from the draws of the fragility."""
    medians, dispersions = draws(fragility)
    if not medians.size:
        return nan, nan
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(annual_rate(hazard, medians, dispersions), (tail, 100.0 - tail))
    return float(low), float(high)


def draws(fragility: Fragility) -> tuple[Array, Array]:
    """Medians and dispersions that the motions leave possible, (draws,) each; empty without standard errors.

    Where the capacities of the motions are known, with n the number of independent ones, these are the pivots of a
    normal sample: β² n/χ²(n − 1) for the dispersion, and ln θ normal about its estimate with that dispersion over √n
    (Krishnamoorthy and Mathew 2003). Few recordings bound a dispersion badly, and a rate grows with its square: normal
    errors of ln β would miss that. Elsewhere (ln θ, ln β) are normal with the larger standard errors.
    """
    of_median, of_dispersion = fragility.errors
    spread = np.array([of_median, of_dispersion / fragility.dispersion])
    if not np.isfinite([*spread, fragility.correlation]).all():
        return np.empty(0), np.empty(0)
    rng = np.random.default_rng(SEED)
    middle = np.log([fragility.median, fragility.dispersion])
    if fragility.independent > 1.0:
        count = fragility.independent
        dispersion = middle[1] + 0.5 * np.log(count / rng.chisquare(count - 1.0, DRAWS))
        median = middle[0] + np.exp(dispersion) / np.sqrt(count) * rng.standard_normal(DRAWS)
        drawn = np.stack([median, dispersion], axis=1)
    else:
        together = np.outer(spread, spread) * [[1.0, fragility.correlation], [fragility.correlation, 1.0]]
        drawn = rng.multivariate_normal(middle, together, DRAWS, method="eigh")
    drawn = np.exp(np.clip(drawn, middle - WIDEST, middle + WIDEST))
    return drawn[:, 0], drawn[:, 1]
