"""Conditional spectra as the OpenQuake engine exports them: median and standard deviation of ln Sa over periods.

Versions up to 3.15 write ``sa_period,val0,std0,val1,std1`` with a pair of columns for each probability of exceedance;
later ones a row for each probability and period, ``poe,stat,period,mea,std``. Sa in g is the exponential of the mean of
ln Sa, and the deviation that of ln Sa (calculators/postproc/conditional_spectrum.py of github.com/gem/oq-engine).
"""

from __future__ import annotations

from math import isclose
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pounding_risk._common.tables import AGAIN, Row, Table, head_of, read_table
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import STANDARD_GRAVITY, shown

WIDE = ("sa_period", "val0", "std0")
LONG = ("poe", "period", "mea", "std")


class ConditionalSpectrum(NamedTuple):
    """Periods [s], medians of Sa [m/s²] and standard deviations of ln Sa, and where they are from."""

    periods: Samples
    median: Samples
    deviation: Samples
    words: str


def is_conditional(path: Path) -> bool:
    """True for a conditional spectrum of OpenQuake."""
    head = head_of(path)
    return set(WIDE) <= set(head) or set(LONG) <= set(head)


def read_conditional(path: Path, poe: str = "") -> ConditionalSpectrum:
    """The spectrum of one probability of exceedance of a file.

    ``poe`` is one of the file's, or "val1" where it has columns without their probabilities; empty where it has one.
    Raises RecordError, with the line, for a damaged file, and for several probabilities of which none is chosen.
    """
    if set(WIDE) <= set(head_of(path)):
        table = read_table(path, error=RecordError, needed=WIDE)
        columns = [name for name in table.head if name.startswith("val")]
        name = _chosen(table, poe, columns)
        rows, median, deviation, period = list(table.rows), name, f"std{name[3:]}", "sa_period"
        if deviation not in table.head:
            raise table.fault(f"has {name} without {deviation}; {AGAIN}")
    else:
        table = read_table(path, error=RecordError, needed=LONG)
        name = _chosen(table, poe, list(dict.fromkeys(row.cells[table.head.index("poe")] for row in table.rows)))
        rows = [row for row in table.rows if row.cells[table.head.index("poe")] == name]
        rows, median, deviation, period = _means(table, rows), "mea", "std", "period"
    values = np.array([[table.number(row, key) for key in (period, median, deviation)] for row in rows])
    for row, (at, value, spread) in zip(rows, values, strict=True):
        if not (at >= 0.0 and value > 0.0 and spread >= 0.0):
            raise row.fault(f"period {at:g} s, Sa {value:g} g, deviation {spread:g}: one is out of range; {AGAIN}")
    site = f" at {table.facts['lon']}, {table.facts['lat']}" if {"lon", "lat"} <= set(table.facts) else ""
    which = f"{name} of {', '.join(columns)}" if "sa_period" in table.head else f"PoE {float(name):g}"
    words = f"conditional spectrum of OpenQuake{site}, {which}, {len(rows)} periods"
    return ConditionalSpectrum(values[:, 0], STANDARD_GRAVITY * values[:, 1], values[:, 2], words)


def _chosen(table: Table, wanted: str, known: list[str]) -> str:
    """The probability, or column, of a file that is requested; its only one where none is."""
    repair = f"choose one with --poe, or # after the name of the file: {', '.join(known)}"
    if not wanted:
        if len(known) != 1:
            raise table.fault(f"has spectra of {len(known)} probabilities of exceedance; {repair}")
        return known[0]
    for name in known:
        try:
            same = name == wanted or isclose(float(name), float(wanted), rel_tol=1e-6)
        except ValueError:
            same = False
        if same:
            return name
    raise table.fault(f"has no probability {shown(wanted)}; {repair}")


def _means(table: Table, rows: list[Row]) -> list[Row]:
    """The rows of the mean of the realisations; raises RecordError for several realisations without it."""
    for key in ("stat", "rlz_id", "rlz"):
        if key in table.head:
            at = table.head.index(key)
            kinds = list(dict.fromkeys(row.cells[at] for row in rows))
            if len(kinds) > 1 and "mean" not in kinds:
                raise table.fault(f"has spectra of {len(kinds)} realisations; export the mean, cs-stats")
            rows = [row for row in rows if row.cells[at] == ("mean" if "mean" in kinds else kinds[0])]
    return rows
