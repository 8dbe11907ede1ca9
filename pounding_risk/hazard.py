"""How often the ground shakes how strongly, from a table, and how often that means contact.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded; in 50
years the probability is 1 − exp(−50 λ_f), events being independent of each other (Poisson).
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from math import nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.fragility import Fragility, fragility_curve
from pounding_risk.quantities import PGA, QuantityError, parse

Array = NDArray[np.float64]

YEARS = 50.0
DRAWS, SEED = 400, 20110314
WIDEST = 6.0  # of ln θ and ln β about the fit: a factor of 400, beyond every hazard curve
HEAD = "write a table with the head 'pga [g],annual rate [1/year]' and a row for each intensity"
A_YEAR = r".*\b(rate|frequency)\b[^\[]*(\[ *((1 */|per) *(year|yr|a)|(year|yr|a) *\^? *-1) *\])?\s*"


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
    uncertainty. ``below`` is P(failure) at the table's weakest intensity: weaker motions are left out. ``above`` is the
    rate of motions stronger than the table: they add at most that.
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


def read_hazard(path: str | Path) -> Hazard:
    """The hazard curve of a CSV file: a head that names the intensity and its unit, then rows im, annual rate.

    Lines that start with # are left out. Raises PoundingError that names the line for what is no such table, where the
    second column is no annual rate, and where intensities do not rise or rates do not fall.
    """
    source = Path(path)
    try:
        lines = source.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise PoundingError(f"{source}: cannot be read ({getattr(error, 'strerror', error)}); {HEAD}") from None
    rows = [(at, line) for at, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    if len(rows) < 3:
        raise PoundingError(f"{source}: has {max(len(rows) - 1, 0)} rows below its head, two are the least; {HEAD}")
    name, unit = _head(source, *rows[0])
    table = np.array([_row(source, at, line, unit) for at, line in rows[1:]])
    for place in range(1, len(table)):
        if not (table[place, 0] > table[place - 1, 0] and table[place, 1] < table[place - 1, 1]):
            raise PoundingError(
                f"{source}, line {rows[place + 1][0]}: intensities must rise and annual rates fall from row to row; "
                "sort the table, and leave out rows that repeat one"
            )
    return Hazard(name, table[:, 0], table[:, 1], source.name)


def _head(source: Path, at: int, line: str) -> tuple[str, str]:
    """Name and unit of the intensity."""
    cells = next(csv.reader([line]))
    found = re.fullmatch(r"\s*(.+?)\s*\[(.+)\]\s*", cells[0])
    if len(cells) != 2 or found is None:
        raise PoundingError(f"{source}, line {at}: {line.strip()!r} names no intensity with its unit; {HEAD}")
    if not re.fullmatch(A_YEAR, cells[1].strip(), re.IGNORECASE):
        raise PoundingError(
            f"{source}, line {at}: the second column is {cells[1].strip()!r}; it must be an annual rate or frequency. "
            "A probability p in t years is a rate of -ln(1 - p) / t, a return period T one of 1 / T"
        )
    return found[1].lower(), found[2]


def _row(source: Path, at: int, line: str, unit: str) -> tuple[float, float]:
    cells = next(csv.reader([line]))
    if len(cells) != 2:
        raise PoundingError(
            f"{source}, line {at}: {line.strip()!r} has {len(cells)} cells; write two, the intensity and its "
            "annual rate"
        )
    try:
        im, rate = parse(f"{cells[0].strip()} {unit}", PGA), float(cells[1])
    except (QuantityError, ValueError) as error:
        raise PoundingError(f"{source}, line {at}: {line.strip()!r} is no row of the table ({error}); {HEAD}") from None
    if not 0.0 < rate < np.inf:
        raise PoundingError(
            f"{source}, line {at}: the annual rate {cells[1].strip()} must be above 0; leave the row out"
        )
    return im, rate


def annual_rate(hazard: Hazard, median: Array | float, dispersion: Array | float) -> Array:
    """∫ Φ(ln(im/θ)/β) |dλ| over the table; an array of medians and dispersions gives one of rates.

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
    """ln(Φ(high) − Φ(low)), in the tail where the difference keeps its digits."""
    from scipy.special import log_ndtr

    upper = low + high > 0.0
    less, more = log_ndtr(np.where(upper, -high, low)), log_ndtr(np.where(upper, -low, high))
    with np.errstate(divide="ignore"):  # nothing between them: −inf, which is meant
        return np.asarray(more + np.log(-np.expm1(less - more)))


def in_years(annual: float, years: float = YEARS) -> float:
    """Probability of one or more in so many years, 1 − exp(−years × rate)."""
    return float(-np.expm1(-years * annual))


def rate_of(hazard: Hazard, fragility: Fragility, confidence: float) -> Rate:
    """Annual rate and 50-year probability of one fragility; NaN where that could not be fitted."""
    about = (fragility.what, fragility.gap, fragility.yield_force, fragility.contact_model)
    if fragility.fault:
        return Rate(*about, nan, nan, nan, nan, nan, nan, fragility.fault)
    annual = float(annual_rate(hazard, fragility.median, fragility.dispersion))
    low, high = _bounds(hazard, fragility, confidence)
    below = float(fragility_curve(hazard.im[0], fragility.median, fragility.dispersion))
    return Rate(*about, annual, low, high, in_years(annual), below, float(hazard.rate[-1]))


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
