"""Hazard curves, and the annual rate of contact or yielding that follows with a fragility.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded; in 50
years the probability is 1 − exp(−50 λ_f), events being independent of each other (Poisson).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import nan

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.fragility import Fragility
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import USUAL_DAMPING, read_sa, sa_at
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.hazard import annual_rate, in_years, missing_share
from pounding_risk.units import STANDARD_GRAVITY

Array = NDArray[np.float64]

STRONGEST = 4.0  # g, exceeded once in 2,475 years: more than short periods have beside the most active faults
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
    ``damping`` ratio, ``pga`` (rates,) those of the ground where the table has them. ``own`` are whole curves by their
    intensity, (intensities, rates), where rates are those that several curves share. ``reading`` as in `Hazard`.
    """

    periods: Array
    rate: Array = field(repr=False)
    im: Array = field(repr=False)
    damping: float = 0.05
    pga: Array | None = field(default=None, repr=False)
    source: str = ""
    reading: str = ""
    own: Mapping[str, tuple[Array, Array]] = field(default_factory=dict, repr=False)

    def at(self, intensity: str) -> Hazard:
        """The hazard curve of "pga" or of "sa(0.62 s)".

        One that the table has itself is whole; between two periods the intensity of each rate is a power of the
        period. Raises PoundingError for another
        intensity, for a damping ratio other than the table's, and for a period outside its periods.
        """
        damping = "" if self.damping == USUAL_DAMPING else f", {100.0 * self.damping:g} %"
        repair = f'choose one of its own, such as --intensity "sa({self.periods[0]:g} s{damping})"'
        if intensity == "pga":
            if self.pga is None:
                raise PoundingError(f"{self.source}: has no column of pga; {repair}")
            return Hazard("pga", *self.own.get("pga", (self.pga, self.rate)), self.source, self.reading)
        measure = read_sa(intensity)
        if measure is None:
            raise PoundingError(f"{self.source}: has no curve of {intensity}; {repair}")
        given_measure = sa_at(measure.period, self.damping)
        if not measure.is_same(given_measure):
            raise PoundingError(
                f"{self.source}: has spectra of {100.0 * self.damping:g} % damping, and {intensity} is asked for; "
                f'write --intensity "{given_measure.intensity}"'
            )
        first, last = float(self.periods[0]), float(self.periods[-1])
        if not first <= measure.period <= last:
            raise PoundingError(
                f"{self.source}: has spectra from {first:g} s to {last:g} s, and {intensity} is asked for; add that "
                f"period to the table, or {repair}"
            )
        for name, curve in self.own.items():
            if (own_measure := read_sa(name)) is not None and measure.is_same(own_measure):
                return Hazard(intensity, *curve, self.source, self.reading)
        log_periods = np.log(self.periods)
        im = np.array([np.exp(np.interp(np.log(measure.period), log_periods, np.log(ims))) for ims in self.im])
        reading = self.reading
        if not np.isclose(self.periods, measure.period, rtol=1e-9, atol=0.0).any():
            after = int(np.searchsorted(self.periods, measure.period))
            low, high = self.periods[after - 1], self.periods[after]
            note = f"{measure.words} is read between {low:g} s and {high:g} s, by straight lines in the logarithms at"
            reading = f"{reading} {note} equal rates.".strip()
        return Hazard(intensity, im, self.rate, self.source, reading)


def unusual(curve: Hazard) -> list[str]:
    """Sentences on a curve of accelerations that is most likely in another unit, or is not of annual rates."""
    if curve.name != "pga" and not curve.name.startswith("sa"):
        return []
    order = np.argsort(curve.rate)[np.count_nonzero(curve.rate <= 0.0) :]
    rates, levels = np.log(curve.rate[order]), np.log(curve.im[order])
    strongest = float(np.exp(np.interp(np.log(1.0 / 2475.0), rates, levels))) / STANDARD_GRAVITY if order.size else 0.0
    sentences = []
    if strongest > STRONGEST:
        sentences.append(
            f"has {strongest:.3g} g once in 2,475 years, usually {STRONGEST:g} g or less: m/s² or % read as g?"
        )
    often = curve.rate[curve.im >= 0.05 * STANDARD_GRAVITY]
    if often.size and often.max() > 1.0:
        sentence = "usually 1 a year or less: probabilities in %, or return periods in years?"
        sentences.append(f"has 0.05 g or more {often.max():.3g} times a year, {sentence}")
    return [f"hazard curve {curve.source or curve.name}: {sentence}" for sentence in sentences]


@dataclass(frozen=True)
class Rate:
    """Annual rate and 50-year probability of a failure at one gap [m], over the intensities of the table.

    ``low`` and ``high`` carry what the motions leave open of the fragility (`draws`), and nothing of the hazard's own
    uncertainty. ``below`` is P(failure) at the table's weakest intensity: weaker motions are left out, and how many
    there are a table does not say. ``above`` is the rate of motions stronger than the table, counted to fail as often
    as at its last row: what they add beyond is at most that. ``missing`` is the share of the failures that is not
    counted, were the table continued at both ends at the slope of its last rows; ``at_least`` is True where that is
    more than a twentieth: all numbers are then lower bounds.
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


def curve_doubts(curve: Hazard | None, rates: Sequence[Rate]) -> list[str]:
    """Sentences on a hazard curve that is unusual, or from which none of these rates of contact follows."""
    if curve is None:
        return []
    faults = [rate.fault for rate in rates if rate.what == "contact"]
    if not faults or not all(faults):
        return unusual(curve)
    why = "; ".join(dict.fromkeys(faults))
    return [*unusual(curve), f"hazard curve {curve.source or curve.name}: no annual rate of contact follows: {why}"]


def rate_of(hazard: Hazard, fragility: Fragility, confidence: float) -> Rate:
    """Annual rate and 50-year probability of one fragility; NaN where that could not be fitted."""
    case = (fragility.what, fragility.gap, fragility.yield_force, fragility.contact_model)
    if fragility.fault:
        return Rate(*case, nan, nan, nan, nan, nan, nan, fragility.fault)
    annual = float(annual_rate(hazard, fragility.median, fragility.dispersion))
    low = high = nan
    medians, dispersions = fragility.draws()
    if medians.size:
        tail = 50.0 * (1.0 - confidence)
        low, high = np.percentile(annual_rate(hazard, medians, dispersions), (tail, 100.0 - tail)).tolist()
    below = float(fragility_curve(hazard.im[0], fragility.median, fragility.dispersion))
    missing = missing_share(hazard, fragility.median, fragility.dispersion)
    numbers = (annual, low, high, in_years(annual), below, float(hazard.rate[-1]))
    return Rate(*case, *numbers, missing=missing, at_least=missing > COVERED)
