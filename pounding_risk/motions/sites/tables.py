"""Tables that other programs export as CSV: comment lines of facts, a head, and rows, each at its place.

OpenQuake writes its facts as ``# mean, investigation_time=50.0, imt="PGA"`` or, in one quoted cell since version 3.7,
``#,,,"generated_by='OpenQuake engine 3.15.0', kind='mean', investigation_time=50.0, imt='PGA'"`` (test files of
github.com/gem/oq-engine); SimCenter writes none.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.inputs import EXPORT, cannot_be_read, read_text
from pounding_risk.errors import RecordError
from pounding_risk.motions.sites.places import Asked, Place, Site, find_site, place
from pounding_risk.units import shown

AGAIN = "export the file again"
_FACT = re.compile(r"""(\w+)\s*=\s*(?:'([^']*)'|"([^"]*)"|(\[[^\]]*\])|([^,"]*))""")


class Row(NamedTuple):
    """A row of a table: its line in the file, and its cells."""

    line: int
    cells: tuple[str, ...]


class Table(NamedTuple):
    """A table with the facts of its comment lines, all as text; rows have as many cells as the head."""

    path: Path
    facts: dict[str, str]
    head: tuple[str, ...]
    rows: tuple[Row, ...]
    again: str = AGAIN  # the repair of a damaged one

    def fault(self, words: str, row: Row | None = None) -> RecordError:
        """The error that a row causes, or the head."""
        return RecordError(f"{self.path}{f', line {row.line}' if row else ''}: {words}")

    def number(self, row: Row, column: str) -> float:
        """The number of a cell, finite; raises RecordError with the line."""
        cell = row.cells[self.head.index(column)]
        try:
            value = float(cell)
        except ValueError:
            value = float("nan")
        if not isfinite(value) or "_" in cell:
            raise self.fault(f"{column} is {shown(cell)}; it must be a number: {self.again}", row)
        return value

    def whole_id(self, row: Row, column: str) -> str:
        """The id of a cell, a whole number of 0 or more, without zeros before it; raises RecordError with the line."""
        cell = row.cells[self.head.index(column)]
        if not (cell.isascii() and cell.isdecimal()):
            raise self.fault(f"{column} is {shown(cell)}; it must be a whole number such as 3: {self.again}", row)
        return cell.lstrip("0") or "0"

    def fact(self, key: str) -> float:
        """A number above 0 of the comment lines; raises RecordError where there is none."""
        try:
            value = float(self.facts.get(key, ""))
        except ValueError:
            value = float("nan")
        if not (isfinite(value) and value > 0.0):
            stated = f"{key} is {shown(self.facts[key])}" if key in self.facts else f"nothing says the {key}"
            raise self.fault(f"{stated}; the comment line must state it, such as # {key}=50.0: {self.again}")
        return value

    def site(self, asked: Asked | None) -> tuple[Row, Site]:
        """The row of the site that is asked for; raises as `find_site`."""
        places = [place_of(self, row) for row in self.rows]
        at = self.head.index("custom_site_id") if "custom_site_id" in self.head else -1
        ids = [row.cells[at] for row in self.rows] if at >= 0 else []
        site = find_site(places, ids, asked, str(self.path))
        return self.rows[site.position], site


def place_of(table: Table, row: Row, longitude: str = "lon", latitude: str = "lat") -> Place:
    """Longitude and latitude of a row."""
    return place(table.number(row, longitude), table.number(row, latitude), f"{table.path}, line {row.line}")


def head_of(path: Path) -> tuple[str, ...]:
    """The head of a table, without its comment lines; empty for a file that has none or cannot be read."""
    try:
        if not path.is_file():  # a pipe is never waited for
            return ()
        with path.open(encoding="utf-8-sig", errors="replace") as lines:
            first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    except OSError:
        return ()
    return _cells(first[:100_000])


def read_table(path: Path, needed: Sequence[str], again: str = AGAIN) -> Table:
    """The table of a file; raises RecordError for columns that are missing, twice there or of unequal number."""
    facts: dict[str, str] = {}
    rows = []
    try:
        text = read_text(path, EXPORT)
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"{path}: {cannot_be_read(error, again)}") from None
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("#"):
            facts |= {key: next(filter(None, values), "").strip() for key, *values in _FACT.findall(line)}
        elif line.strip():
            rows.append(Row(number, _cells(line)))
    if not rows:
        raise RecordError(f"{path}: holds no table; {again}")
    head = rows.pop(0)
    table = Table(path, facts, head.cells, tuple(rows), again)
    missing = [name for name in needed if name not in head.cells]
    twice = [name for name in head.cells if head.cells.count(name) > 1]
    if missing or twice:
        words = f"has no column {missing[0]}" if missing else f"has the column {shown(twice[0])} twice"
        raise table.fault(f"the head {shown(','.join(head.cells)[:60])} {words}; {again}", head)
    if not rows:
        raise table.fault(f"has no rows below its head; {again}")
    for row in rows:
        if len(row.cells) != len(head.cells):
            raise table.fault(f"has {len(row.cells)} cells, and the head has {len(head.cells)}; {again}", row)
    return table


def split_site(text: str) -> tuple[str, str]:
    """A file, or pattern of files, and the site after "#"; a file whose own name has a # is taken as it is."""
    name, mark, site = text.rpartition("#")
    return (name, site) if mark and name and not Path(text).exists() else (text, "")


def _cells(line: str) -> tuple[str, ...]:
    try:
        # Blanks only: 3 and a tab may have been site 37, one byte of which was damaged.
        return tuple(cell.strip(" ") for cell in chain.from_iterable(csv.reader([line])))
    except csv.Error:
        return ()
