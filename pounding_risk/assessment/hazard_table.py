"""Hazard curves from a table in a CSV file: at one intensity, or spectra of several annual rates.

Four shapes are read, recognised by the first line:

- ``pga [g],annual rate [1/year]``: a row for each intensity of one curve; it may be ``pgv [cm/s]``, ``sa(0.5 s) [g]``
  or ``sa_avg(0.2-2 s) [g]`` too;
- ``return period [years],pga [g],sa(0.2 s) [g],sa(1 s) [g]``: a row for each return period, a uniform hazard spectrum;
- ``period [s],475 years [g],2475 years [g]``: a row for each period of vibration, 0 for PGA;
- ``sa [g],annual rate at 0.2 s [1/year],annual rate at 1 s [1/year]``: a row for each intensity of several curves.

How often an intensity is exceeded may be an annual rate, a return period T [years], which is a rate of 1/T, or a
probability p in t years, which is one of −ln(1 − p)/t. Exports of the OpenQuake engine are read too.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import inf, isclose, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.tables import Row, read_table, short, split_unit
from pounding_risk.assessment.annual_rates import read_rate
from pounding_risk.assessment.hazard import Hazard, HazardSpectrum
from pounding_risk.assessment.hazard_openquake import Exported, exported
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import Measure, read_measure, read_sa, sa_at
from pounding_risk.results.amplitudes import intensity_quantity
from pounding_risk.statistics.hazard import rate_of_probability
from pounding_risk.units import PERIOD, Quantity, QuantityError, parse

Array = NDArray[np.float64]

LONGEST = 10_000  # letters of a line of a table; a spectrum of a hundred periods has fewer
RATE = Quantity("1", 0.0, inf, "annual rate", open_low=True, open_high=True, example="0.002")
RETURN_PERIOD = Quantity("1", 0.0, inf, "return period in years", open_low=True, open_high=True, example="475")
PROBABILITY = Quantity("1", 0.0, 1.0, "probability of exceedance", open_low=True, open_high=True, example="0.1")
PERCENT = Quantity("1", 0.0, 100.0, "probability in %", open_low=True, open_high=True, example="10")
HEAD = "write a table with the head 'pga [g],annual rate [1/year]' and a row for each intensity"
SPECTRA = "write a table with the head 'return period [years],sa(0.2 s) [g],sa(1 s) [g]', or 'period [s],475 years [g]'"
CURVES = "write a table with the head 'sa [g],annual rate at 0.2 s [1/year],annual rate at 1 s [1/year]'"
A_YEAR = r".*\b(rate|frequency)\b[^\[]*(\[ *((1 */|per) *(year|yr|a)|(year|yr|a) *\^? *-1) *\])?\s*"
OF_RETURN = r".*\breturn period\b[^\[]*(\[ *(years?|yrs?|a) *\])?\s*"
OF_PROBABILITY = r".*\b(?:probability|poe)\b[^\[]*\bin *(\d+\.?\d*) *(?:years?|yrs?|a)\b[^\[]*(?:\[ *(%|1|-) *\])?\s*"
ANNUAL_PROBABILITY = r".*\bannual probability\b[^\[]*(?:\[ *(%|1|-) *\])?\s*"
OFTEN = "an annual rate or frequency, a return period [years], or a probability in a number of years"
FALLS = {
    "annual rate": "annual rates fall",
    "return period": "return periods rise",
    "probability": "probabilities fall",
}


class Statement(NamedTuple):
    """How a column states how often an intensity is exceeded."""

    kind: str  # of FALLS
    years: float = nan  # of a probability
    percent: bool = False

    @property
    def reading(self) -> str:
        """Sentence on how the numbers are read as annual rates; "" of annual rates."""
        if self.kind == "return period":
            return "Return periods T are read as annual rates 1/T."
        if self.kind == "probability":
            span = "1 year" if self.years == 1.0 else f"{self.years:g} years"
            return (
                f"Probabilities p in {span} are read as annual rates -ln(1 - p)/{self.years:g}, events being "
                "independent of each other (Poisson)."
            )
        return ""

    def rate(self, cell: str) -> float:
        """Annual rate of a cell; raises QuantityError for what is none."""
        if self.kind == "annual rate":
            return parse(cell, RATE)
        if self.kind == "return period":
            return 1.0 / parse(cell, RETURN_PERIOD)
        is_percent = self.percent and "%" not in cell
        return rate_of_probability(parse(cell, PERCENT) / 100.0 if is_percent else parse(cell, PROBABILITY), self.years)


class Column(NamedTuple):
    """Intensity of a column: its name in lower case, and its unit."""

    name: str
    unit: str

    @property
    def quantity(self) -> Quantity:
        """The quantity, with unit and bounds, that its intensities are values of."""
        return intensity_quantity(self.name)


def read_hazard(path: str | Path) -> Hazard | HazardSpectrum:
    """Read a hazard curve, or hazard spectra, from a CSV file.

    The head says what each column holds (the four shapes of the module's docstring). Lines that start with # are left
    out. Hazard curves and uniform hazard spectra of OpenQuake are read as they are.

    Parameters
    ----------
    path : str or Path
        The file, such as ``pga [g],annual rate [1/year]`` above rows like ``0.1,0.02``. Of an export of OpenQuake the
        site stands after "#", ``hazard_curve-mean-PGA_1.csv#23.73,37.98``, with ``within 20 km`` after it for one that
        is farther than 10 km; a pattern, ``hazard_curve-mean-*.csv``, stands for the curves of several intensities.

    Returns
    -------
    Hazard or HazardSpectrum
        Intensities [SI] in rising order and annual rates [1/year]; a spectrum where the table has several periods.

    Raises
    ------
    PoundingError
        With the line, for what is no such table, where no column says how often an intensity is exceeded, for a
        probability that does not lie between 0 and 1, where intensities do not rise or rates do not fall, for several
        sites of which none is named, and for one that is too far.
    """
    curves = exported(path)
    if curves is not None:
        return _of_openquake(curves)
    table = read_table(Path(path), HEAD, error=PoundingError, longest=LONGEST)
    lines, cells = [table.head_row, *table.rows], table.head
    if re.fullmatch(r"period *\[.*\]", cells[0], re.IGNORECASE):
        return _by_period(lines)
    if len(table.rows) < 2:
        raise table.fault(f"has {counted(len(table.rows), 'row')} below its head, two are the least; {HEAD}")
    form = statement(cells[0])
    if form is not None:
        return _by_rate(lines, form)
    has_period = len(cells) > 2 or re.search(r" at (\.?\d|pga\b)", cells[-1], re.IGNORECASE)
    return _by_intensity(lines) if has_period else _one_curve(lines)


def _of_openquake(curves: Exported) -> Hazard | HazardSpectrum:
    """Annual rates from the probabilities of curves of one site."""
    reading = " ".join((*curves.reading, Statement("probability", curves.years).reading))
    rates = [rate_of_probability(poe, curves.years) for poe in curves.probabilities]
    if len(rates) == 1:
        return Hazard(curves.intensities[0], curves.levels[0], rates[0], curves.name, reading)
    head = Row(Path(curves.name), 1, (), PoundingError)
    return _at_common_rates(head, curves.intensities, list(zip(curves.levels, rates, strict=True)), reading)


def statement(head: str) -> Statement | None:
    """How a column states how often its intensity is exceeded, by its head; None of another column."""
    if match := re.fullmatch(OF_PROBABILITY, head, re.IGNORECASE):
        years = float(match[1])
        return Statement("probability", years, match[2] == "%") if years > 0.0 else None
    if match := re.fullmatch(ANNUAL_PROBABILITY, head, re.IGNORECASE):
        return Statement("probability", 1.0, match[1] == "%")
    if re.fullmatch(OF_RETURN, head, re.IGNORECASE):
        return Statement("return period")
    return Statement("annual rate") if re.fullmatch(A_YEAR, head, re.IGNORECASE) else None


def _one_curve(lines: list[Row]) -> Hazard:
    """A curve of two columns, the intensity and how often it is exceeded."""
    head = lines[0]
    column = _column(head, head.cells[0])
    if column is None or len(head.cells) != 2:
        raise head.fault(f"{head.shown} names no intensity with its unit; {HEAD}")
    form = statement(head.cells[1])
    if form is None:
        repair = "write 'annual rate [1/year]', 'return period [years]' or 'probability in 50 years'"
        if re.search(r"\b(probability|poe)\b", head.cells[1], re.IGNORECASE):
            repair = "a probability needs its years, such as 'probability in 50 years'"
        raise head.fault(f"the second column is {short(head.cells[1])}; it must be {OFTEN}: {repair}")
    rows = [(_intensity(line, line.cells[0], column), _rate(line, line.cells[1], form)) for line in lines[1:]]
    table = np.array(rows)
    _check_order(lines[1:], table[:, 0], table[:, 1], form)
    return Hazard(column.name, table[:, 0], table[:, 1], lines[0].source.name, form.reading)


def _rate(line: Row, cell: str, form: Statement) -> float:
    if "%" in cell and form.kind != "probability":
        raise line.fault(f"{line.shown} has a percentage; write a number a year; {HEAD}")
    try:
        return form.rate(cell)
    except QuantityError as error:
        advice = "; leave out rows of 0 and of 1" if form.kind == "probability" else ""
        percent_advice = ", and end the head in [%] where numbers are in %" if advice and not form.percent else ""
        raise line.fault(f"{line.shown} is no row of the table ({error}){advice}{percent_advice}; {HEAD}") from None


def _intensity(line: Row, cell: str, column: Column) -> float:
    try:
        return parse(f"{cell} {column.unit}", column.quantity)
    except QuantityError as error:
        raise line.fault(f"{line.shown} is no row of the table ({error}); {HEAD}") from None


def _check_order(lines: Sequence[Row], im: Array, rate: Array, form: Statement, name: str = "intensities") -> None:
    """Raise PoundingError with the line where intensities do not rise or rates do not fall."""
    for row in range(1, len(im)):
        if not (im[row] > im[row - 1] and rate[row] < rate[row - 1]):
            raise lines[row].fault(
                f"{name} must rise and {FALLS[form.kind]} from row to row; sort the table, and leave out rows that "
                "repeat one"
            )


def _by_rate(lines: list[Row], form: Statement) -> Hazard | HazardSpectrum:
    """A row for each annual rate: a curve where there is one intensity, spectra where there are several."""
    head = lines[0]
    columns = [_column(head, cell) for cell in head.cells[1:]]
    im_columns = [column for column in columns if column is not None]
    if not im_columns or len(im_columns) < len(columns):
        raise head.fault(f"{head.shown} has a column that names no intensity with its unit; {SPECTRA}")
    rows = []
    for line in lines[1:]:
        spectrum = [_intensity(line, cell, column) for cell, column in zip(line.cells[1:], im_columns, strict=True)]
        rows.append([_rate(line, line.cells[0], form), *spectrum])
    table = np.array(rows)
    for place, column in enumerate(im_columns, start=1):
        _check_order(lines[1:], table[:, place], table[:, 0], form, f"intensities of {column.name}")
    if len(im_columns) == 1:
        return Hazard(im_columns[0].name, table[:, 1], table[:, 0], head.source.name, form.reading)
    return _spectrum(head, [column.name for column in im_columns], table[:, 0], table[:, 1:], form.reading)


def _by_period(lines: list[Row]) -> HazardSpectrum:
    """A row for each period of vibration, 0 for PGA, and a column for each annual rate."""
    head, columns = lines[0], []
    for cell in head.cells[1:]:
        column = _column(head, cell)
        if column is None:
            raise head.fault(f"{short(cell)} has no unit of its intensities; {SPECTRA}")
        try:
            columns.append((read_rate(column.name), column))
        except QuantityError as error:
            raise head.fault(f"{short(cell)} says not how often it is exceeded ({error})") from None
    if len(columns) < 2:
        raise head.fault(f"has spectra of {counted(len(columns), 'rate')}, two are the least; {SPECTRA}")
    names, rows = [], []
    for line in lines[1:]:
        names.append(_period_name(line, line.cells[0], head.cells[0]))
        rows.append([_intensity(line, cell, column) for cell, (_, column) in zip(line.cells[1:], columns, strict=True)])
    rates = np.array([level.rate for level, _ in columns])
    order = np.argsort(-rates)
    table = np.array(rows)[:, order]
    for line, spectrum in zip(lines[1:], table, strict=True):
        if not (np.diff(spectrum) > 0.0).all() or not (np.diff(rates[order]) < 0.0).all():
            raise line.fault("intensities must rise as the annual rates of the columns fall; leave out equal columns")
    words, values = map(", ".join, zip(*((rate.words, f"{rate.rate:.3g}") for rate, _ in columns), strict=True))
    reading = (
        f"The columns {words} are read as annual rates of {values}, events being independent of each other (Poisson)."
    )
    return _spectrum(head, names, rates[order], table.T, reading)


def _by_intensity(lines: list[Row]) -> HazardSpectrum:
    """A row for each intensity, and a column for the curve of each period; an empty cell ends its curve."""
    head = lines[0]
    column = _column(head, head.cells[0])
    if column is None:
        raise head.fault(f"{head.shown} names no intensity with its unit; {HEAD}")
    rate_columns = [_rate_at_period(head, cell) for cell in head.cells[1:]]
    if not rate_columns or len({form for form, _ in rate_columns}) > 1:
        raise head.fault(f"{head.shown} has not one form of rates at several periods; {CURVES}")
    form, curves = rate_columns[0][0], []
    for place, (_, name) in enumerate(rate_columns, start=1):
        rows = [line for line in lines[1:] if line.cells[place]]
        if len(rows) < 2:
            raise head.fault(f"has {counted(len(rows), 'rate')} of {name}, two are the least; {CURVES}")
        im = np.array([_intensity(line, line.cells[0], column) for line in rows])
        rate = np.array([_rate(line, line.cells[place], form) for line in rows])
        _check_order(rows, im, rate, form)
        curves.append((im, rate))
    return _at_common_rates(head, [name for _, name in rate_columns], curves, form.reading)


def _rate_at_period(head: Row, cell: str) -> tuple[Statement, str]:
    """How a column states rates, and the intensity whose curve it holds: "annual rate at 0.5 s [1/year]"."""
    match = re.fullmatch(r"(.*?) at ([^\[\]]+?)\s*(\[[^\]]*\])?", cell)
    form = statement(f"{match[1]} {match[3] or ''}".strip()) if match else None
    if match is None or form is None:
        raise head.fault(f"{short(cell)} says not how often intensities at which period are exceeded; {CURVES}")
    if match[2].lower() == "pga":
        return form, "pga"
    try:
        return form, sa_at(parse(match[2], PERIOD)).intensity
    except QuantityError as error:
        raise head.fault(f"{short(cell)} names no period ({error}); {CURVES}") from None


def _at_common_rates(
    head: Row, names: Sequence[str], curves: Sequence[tuple[Array, Array]], reading: str
) -> HazardSpectrum:
    """Spectra at the rates that all curves have, each curve straight in the logarithms between its rows."""
    low_rate, high_rate = max(rate[-1] for _, rate in curves), min(rate[0] for _, rate in curves)
    rates = np.unique(np.concatenate([rate for _, rate in curves]))
    rates = rates[(rates >= low_rate) & (rates <= high_rate)][::-1]
    if rates.size < 2:
        raise head.fault("has curves that share no two rates; write rows that reach further")
    spectra = [np.exp(np.interp(-np.log(rates), -np.log(rate), np.log(im))) for im, rate in curves]
    return replace(
        _spectrum(head, names, rates, np.array(spectra).T, reading), own=dict(zip(names, curves, strict=True))
    )


def _period_name(line: Row, cell: str, head: str) -> str:
    """The intensity of a row that starts with a period: "pga" of 0, or "sa(0.5 s)"."""
    unit = split_unit(head)[1]
    if cell.lower() == "pga" or re.fullmatch(r"0*\.?0+", cell):
        return "pga"
    try:
        return sa_at(parse(f"{cell} {unit}", PERIOD)).intensity
    except QuantityError as error:
        raise line.fault(f"{line.shown} starts with no period ({error}); {SPECTRA}") from None


def _spectrum(head: Row, names: Sequence[str], rate: Array, im: Array, reading: str) -> HazardSpectrum:
    """Spectra by rising period, from ``im`` (rates, intensities); raises PoundingError for other intensities."""
    measures: list[Measure] = []  # with the period 0 of PGA
    for name in names:
        measure = sa_at(0.0) if name == "pga" else read_sa(name)
        if measure is None:
            raise head.fault(f"{short(name)} is neither pga nor sa at a period such as sa(0.5 s); {SPECTRA}")
        measures.append(measure)
    periods = [measure.period for measure in measures]
    for place, period in enumerate(periods):
        if period in periods[:place]:
            raise head.fault(f"has {names[place]} twice; leave one of them out")
    sa_measures = [measure for measure in measures if measure.period > 0.0]
    if not sa_measures:
        raise head.fault(f"has no sa at a period; {SPECTRA}")
    if not all(isclose(measure.damping, sa_measures[0].damping) for measure in sa_measures):
        raise head.fault("has spectra of several damping ratios; write a table for each")
    order = np.argsort(periods)
    sorted_periods, table = np.array(periods)[order], im[:, order]
    has_pga = bool(sorted_periods[0] == 0.0)
    curves = sorted_periods[has_pga:], rate, table[:, has_pga:], sa_measures[0].damping
    return HazardSpectrum(*curves, table[:, 0] if has_pga else None, head.source.name, reading)


def _column(head: Row, cell: str) -> Column | None:
    """Name and unit of an intensity, from the head of its column; None where it names none with a unit."""
    label, unit = split_unit(cell)
    if not label or not unit:
        return None
    name = label.lower()
    if re.match(r"pgd\b", name):
        raise head.fault(
            f"the hazard is one of {name}, which datasets do not hold for their motions; take a curve of pga or pgv, "
            "or of sa at a period such as sa(0.5 s)"
        )
    measure = read_measure(name)
    if name.startswith("sa_avg") and measure is None:
        raise head.fault(f"{short(cell)} names no range of periods; write sa_avg(0.2-2 s) [g]")
    return Column(name if measure is None or measure.name != "sa_avg" else measure.intensity, unit)
