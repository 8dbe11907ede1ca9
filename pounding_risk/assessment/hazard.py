"""Hazard curves from a table, and the annual rate of contact or yielding that follows with a fragility.

The annual rate of failure is ∫ P(failure | im) |dλ(im)|, λ the annual rate at which an intensity is exceeded; in 50
years the probability is 1 − exp(−50 λ_f), events being independent of each other (Poisson).
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from math import inf, nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.fragility import Fragility, fragility_curve
from pounding_risk.errors import PoundingError
from pounding_risk.units import PGA, Quantity, QuantityError, parse

Array = NDArray[np.float64]

YEARS = 50.0
DRAWS, SEED = 400, 20110314
WIDEST = 6.0  # of ln θ and ln β about the fit: a factor of 400, beyond every hazard curve
LARGEST = 700.0  # exponent of a number that there is
COVERED = 0.05  # the share of the failures that a table may leave out and its rate be called the rate
LONGEST = 1000  # letters of a line of a table, which holds two numbers
RATE = Quantity("1", 0.0, inf, "annual rate", open_low=True, open_high=True, example="0.002")
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


def read_hazard(path: str | Path) -> Hazard:
    """Read a hazard curve from a CSV file.

    The head names the intensity with its unit and the annual rate; each row below has an intensity and its rate. Lines
    that start with # are left out.

    Parameters
    ----------
    path : str or Path
        The file, such as ``pga [g],annual rate [1/year]`` above rows like ``0.1,0.02``.

    Returns
    -------
    Hazard
        Intensities [m/s2] in rising order and annual rates [1/year].

    Raises
    ------
    PoundingError
        With the line, for what is no such table, where the second column is no annual rate, and where intensities do
        not rise or rates do not fall.
    """
    source = Path(path)
    try:
        lines = source.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise PoundingError(f"{source}: cannot be read ({getattr(error, 'strerror', error)}); {HEAD}") from None
    rows = [(at, line) for at, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    for at, line in rows:
        if len(line) > LONGEST:
            raise PoundingError(f"{source}, line {at}: has {len(line):,} letters, and a row is two numbers; {HEAD}")
    if len(rows) < 3:
        raise PoundingError(f"{source}: has {max(len(rows) - 1, 0)} rows below its head, two are the least; {HEAD}")
    name, unit = _head(source, *rows[0])
    table = np.array([_row(source, at, line, unit) for at, line in rows[1:]])
    for row in range(1, len(table)):
        if not (table[row, 0] > table[row - 1, 0] and table[row, 1] < table[row - 1, 1]):
            raise PoundingError(
                f"{source}, line {rows[row + 1][0]}: intensities must rise and annual rates fall from row to row; "
                "sort the table, and leave out rows that repeat one"
            )
    return Hazard(name, table[:, 0], table[:, 1], source.name)


def _head(source: Path, at: int, line: str) -> tuple[str, str]:
    """Name and unit of the intensity, from the head of a table."""
    cells = _cells(line)
    match = re.fullmatch(r"\s*(.+?)\s*\[(.+)\]\s*", cells[0])
    if len(cells) != 2 or match is None:
        raise PoundingError(f"{source}, line {at}: {_shown(line)} names no intensity with its unit; {HEAD}")
    if not re.fullmatch(A_YEAR, cells[1].strip(), re.IGNORECASE):
        raise PoundingError(
            f"{source}, line {at}: the second column is {_shown(cells[1])}; it must be an annual rate or frequency. "
            "A probability p in t years is a rate of -ln(1 - p) / t, a return period T one of 1 / T"
        )
    return match[1].lower(), match[2]


def _row(source: Path, at: int, line: str, unit: str) -> tuple[float, float]:
    """Intensity [m/s2] and annual rate [1/year] of one row."""
    cells = _cells(line)
    if len(cells) != 2:
        raise PoundingError(
            f"{source}, line {at}: {_shown(line)} has {len(cells)} cells; write two, the intensity and its annual rate"
        )
    if "%" in cells[1]:
        raise PoundingError(f"{source}, line {at}: {_shown(line)} has a percentage; write a number a year; {HEAD}")
    try:
        return parse(f"{cells[0].strip()} {unit}", PGA), parse(cells[1].strip(), RATE)
    except QuantityError as error:
        raise PoundingError(f"{source}, line {at}: {_shown(line)} is no row of the table ({error}); {HEAD}") from None


def _cells(line: str) -> list[str]:
    """The cells of one line."""
    return next(csv.reader([line]))


def _shown(text: str) -> str:
    """Text of a table for an error, at most 60 letters of it."""
    text = text.strip()
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


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
