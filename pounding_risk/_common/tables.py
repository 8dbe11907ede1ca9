"""Tables of text in CSV: comment lines with facts, a head, and rows, each known by its line.

Every table that is read passes here: of hazard, ground-motion fields, sites, spectra, streets, forces, and manifests.
Lines that start with # are comments and may state facts. OpenQuake writes them as ``# mean, investigation_time=50.0,
imt="PGA"`` or, in one quoted cell since version 3.7, ``#,,,"generated_by='OpenQuake engine 3.15.0', kind='mean'"``
(test files of github.com/gem/oq-engine).

    >>> from pathlib import Path
    >>> faults: list[str] = []
    >>> csv_rows('# unit = g\\nname,height [m]\\n\\nA,12.5\\n', faults, "write a head")
    [(2, ['name', 'height [m]']), (4, ['A', '12.5'])]
    >>> split_unit("height [m]")
    ('height', 'm')
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence, Sized
from functools import partial
from math import isfinite, nan
from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk._common.inputs import EXPORT, Unfit, text_of
from pounding_risk.errors import PoundingError

AGAIN = "export the file again"
_FACT = re.compile(r"""(\w+)\s*=\s*(?:'([^']*)'|"([^"]*)"|(\[[^\]]*\])|([^,"]*))""")
_HEAD = re.compile(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", re.DOTALL)
LONGEST_HEAD = 100_000  # letters that are looked at where the kind of a table is asked for


class Row(NamedTuple):
    """A row of a table, or its head: the file, the line in it, and the cells."""

    source: Path
    line: int
    cells: tuple[str, ...]
    error: type[PoundingError]

    def fault(self, words: str) -> PoundingError:
        """The error that this row causes."""
        return self.error(f"{self.source}, line {self.line}: {words}")

    @property
    def shown(self) -> str:
        """The row for an error."""
        return short(",".join(self.cells))


class Table(NamedTuple):
    """A table with the facts of its comment lines, all as text; rows have as many cells as the head."""

    path: Path
    facts: dict[str, str]
    head: tuple[str, ...]
    rows: tuple[Row, ...]
    head_row: Row
    again: str = AGAIN  # the repair of a damaged one

    def fault(self, words: str) -> PoundingError:
        """The error that the table as a whole causes."""
        return self.head_row.error(f"{self.path}: {words}")

    def number(self, row: Row, column: str) -> float:
        """The number of a cell, finite; raises the table's error with the line."""
        cell = row.cells[self.head.index(column)]
        value = _float(cell)
        if not isfinite(value):
            raise row.fault(f"{column} is {short(cell)}; it must be a number: {self.again}")
        return value

    def whole_id(self, row: Row, column: str) -> str:
        """The id of a cell, a whole number of 0 or more, without zeros before it; raises the table's error."""
        cell = row.cells[self.head.index(column)]
        if not (cell.isascii() and cell.isdecimal()):
            raise row.fault(f"{column} is {short(cell)}; it must be a whole number such as 3: {self.again}")
        return cell.lstrip("0") or "0"

    def fact(self, key: str) -> float:
        """A number above 0 of the comment lines; raises the table's error where there is none."""
        value = _float(self.facts.get(key, ""))
        if not (isfinite(value) and value > 0.0):
            stated_text = f"{key} is {short(self.facts[key])}" if key in self.facts else f"nothing says the {key}"
            raise self.fault(f"{stated_text}; the comment line must state it, such as # {key}=50.0: {self.again}")
        return value


def read_table(
    path: Path,
    again: str = AGAIN,
    *,
    error: type[PoundingError],
    needed: Sequence[str] = (),
    most: int = EXPORT,
    longest: int | None = None,
    mark: str = ",",
    is_ours: bool = False,
) -> Table:
    """The table of a file, whose rows all have as many cells as its head.

    Parameters
    ----------
    path : Path
        The file.
    again : str
        The repair of a table that is damaged, or none.
    error : type
        What is raised for faults.
    needed : sequence of str
        Columns that it must have; then no column may be there twice.
    most : int
        Most bytes.
    longest : int, optional
        Most letters of a line.
    mark : str
        What parts the columns.
    is_ours : bool
        Whether this package wrote it, so that no line is a comment, blanks are part of a cell, and no rows are a table
        too.

    Raises
    ------
    PoundingError
        Of the class ``error``, with file and line.
    """
    faults: list[str] = []
    try:
        text = text_of(path, most)
    except Unfit as unfit:
        raise error(f"{path}: {unfit.strerror}") from None
    for number, line in enumerate(text.splitlines(), start=1) if longest is not None else ():
        if longest is not None and len(line) > longest:
            raise error(f"{path}, line {number}: has {len(line):,} letters, and a row is a few numbers; {again}")
    # Blanks only: 3 and a tab may have been site 37, one byte of which was damaged.
    rows = [
        Row(path, line, tuple(cells) if is_ours else tuple(cell.strip(" ") for cell in cells), error)
        for line, cells in csv_rows(text, faults, again, mark, is_ours=is_ours)
    ]
    if faults:
        raise error(f"{path}{', ' if faults[0].startswith('line') else ': '}{faults[0]}")
    head = rows.pop(0)
    comments = (line for line in text.splitlines() if line.startswith("#") and not is_ours)
    facts = {key: next(filter(None, values), "").strip() for line in comments for key, *values in _FACT.findall(line)}
    table = Table(path, facts, head.cells, tuple(rows), head, again)
    missing = [name for name in needed if name not in head.cells]
    repeats = [name for name in head.cells if needed and head.cells.count(name) > 1]
    if missing or repeats:
        words = f"has no column {missing[0]}" if missing else f"has the column {short(repeats[0])} twice"
        raise head.fault(f"the head {head.shown} {words}; {again}")
    if not rows and not is_ours:
        raise table.fault(f"has no rows below its head; {again}")
    for row in rows:
        if words := uneven(row.cells, head.cells):
            raise row.fault(f"{words}; {again}")
    return table


def csv_rows(
    text: str, faults: list[str], repair: str, mark: str = ",", *, is_ours: bool = False
) -> list[tuple[int, list[str]]]:
    """Line and cells of each row that is not blank, the head first; [] with a fault that ends with the ``repair``.

    Lines that start with # are left out, and blanks before cells; neither of a file that this package wrote
    (``is_ours``). A cell in quotes may go on over several lines, and counts for the last one.
    """
    lines = ("\n" if line.startswith("#") and not is_ours else line for line in text.splitlines(keepends=True))
    reader = csv.reader(lines, strict=True, skipinitialspace=not is_ours, delimiter=mark)
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        faults.append(f"line {reader.line_num}: is not CSV ({error}); {repair}")
        return []
    if not rows:
        faults.append(f"the file is empty; {repair}")
        return []
    at, heads = rows[0]
    if len(heads) == 1 and (";" in heads[0] or "\t" in heads[0]):
        marks = "semicolons" if ";" in heads[0] else "tabs"
        words = f"the columns are parted by {marks}; write commas between columns, and decimal points in numbers"
        faults.append(f"line {at}: {words}")
        return []
    return rows


def uneven(cells: Sized, heads: Sized) -> str:
    """Words on a row with another number of cells than the head; "" where both have as many."""
    if len(cells) == len(heads):
        return ""
    quotes = ", in quotes where it holds a comma" if len(cells) > len(heads) else ""
    return f"has {counted(len(cells), 'cell')}, the head has {len(heads)}; write one a column{quotes}"


def split_unit(head: str) -> tuple[str, str]:
    """Name and unit of the head of a column, such as "height [m]"; the unit is "" where it has none."""
    match = _HEAD.fullmatch(head)
    return (match[1], (match[2] or "").strip()) if match else (head, "")


def head_of(path: Path) -> tuple[str, ...]:
    """The head of a table, without its comment lines; empty for a file that has none or cannot be read."""
    rows = csv_rows(first_line(path), [], "")
    return tuple(cell.strip(" ") for cell in rows[0][1]) if rows else ()


def first_line(path: Path) -> str:
    """The first line of a table that is no comment, at most `LONGEST_HEAD` letters of it; "" where there is none."""
    try:
        if not path.is_file():  # a pipe is never waited for
            return ""
        with path.open(encoding="utf-8-sig", errors="replace") as lines:
            is_begun = False
            for piece in iter(partial(lines.readline, LONGEST_HEAD), ""):  # never a line of a thousand megabytes
                if not is_begun and piece.strip() and not piece.startswith("#"):
                    return piece
                is_begun = not piece.endswith("\n")
    except OSError:
        pass
    return ""


def short(text: str) -> str:
    """Text of a table for an error: in quotes, printable, at most 60 letters of it."""
    text = "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text.strip(" \n\r")[:61])
    return f'"{text if len(text) <= 60 else f"{text[:57]}..."}"'


def _float(cell: str) -> float:
    """The number of a cell; NaN of what is none, digits parted by _ too."""
    try:
        return nan if "_" in cell else float(cell)
    except ValueError:
        return nan
