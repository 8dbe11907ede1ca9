"""Hazard curves from a table in a CSV file."""

from __future__ import annotations

import csv
import re
from math import inf
from pathlib import Path

import numpy as np

from pounding_risk.assessment.hazard import Hazard
from pounding_risk.errors import PoundingError
from pounding_risk.units import PGA, Quantity, QuantityError, parse

LONGEST = 1000  # letters of a line of a table, which holds two numbers
RATE = Quantity("1", 0.0, inf, "annual rate", open_low=True, open_high=True, example="0.002")
HEAD = "write a table with the head 'pga [g],annual rate [1/year]' and a row for each intensity"
A_YEAR = r".*\b(rate|frequency)\b[^\[]*(\[ *((1 */|per) *(year|yr|a)|(year|yr|a) *\^? *-1) *\])?\s*"


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
