"""Going through a text file line by line: blocks of lines, tables in Fortran's columns, and where they are."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import RecordError
from pounding_risk.formats._text import NEWLINE, fixed_numbers, quoted

END = re.compile(r"\s*(?:end.of.data|/&)", re.I)  # starts the line that ends a channel
_COLUMNS = re.compile(
    r"\(\s*(\d{1,3})\s*\(?\s*(?:1?P,?)?\s*[IFEDG]\s*(\d{1,2})(?:\.\d{1,2})?(?:E\d?)?\s*\)?\s*\)", re.I
)


class Columns(NamedTuple):
    """How Fortran lays numbers out: how many on a line, in how many characters each."""

    each: int
    width: int


def columns_of(text: str) -> Columns | None:
    """The columns that a format in parentheses, such as (8F10.5) or (1E15.6), stands for; None for no such format."""
    found = _COLUMNS.search(text)
    columns = Columns(int(found[1]), int(found[2])) if found else None
    return columns if columns and min(columns) > 0 else None


class Lines:
    """The lines of a file and the place that the reading has come to.

    ``name`` is what messages call the file, ``at`` how many lines are behind.
    """

    def __init__(self, name: str, text: str):
        self.name = name
        self.at = 0
        self._lines = NEWLINE.split(text)
        if not self._lines[-1]:  # what follows the last newline is no line
            self._lines.pop()

    @property
    def place(self) -> str:
        """File and number of the line last taken."""
        return f"{self.name}, line {self.at}"

    @property
    def ahead(self) -> str:
        """The next line, not taken; empty at the end of the file."""
        return self._lines[self.at] if self.at < len(self._lines) else ""

    def ended(self) -> bool:
        """True where nothing but blank lines is left; blank lines are passed over."""
        while self.at < len(self._lines) and not self._lines[self.at].strip():
            self.at += 1
        return self.at == len(self._lines)

    def take(self, count: int, what: str) -> list[str]:
        """The next ``count`` lines; raises RecordError where the file ends before them."""
        if self.at + count > len(self._lines):
            raise RecordError(
                f"{self.name}: ends at line {len(self._lines)}, where {what} should be; the file is cut short: "
                "fetch it again"
            )
        self.at += count
        return self._lines[self.at - count : self.at]

    def table(self, count: int, columns: Columns, example: str, what: str) -> NDArray[np.float64]:
        """The next ``count`` numbers, in columns, on as many lines as that takes.

        ``what`` says in messages what they are. Raises RecordError where there are fewer or more on these lines, and
        where one is no finite number.
        """
        promise, first = self.place, self.at
        lines = self._lines[first : first + -(-count // columns.each)]
        # What ends a channel ends it before its time where lines are missing.
        end = next((at for at, line in enumerate(lines) if END.match(line)), None)
        lines = lines if end is None else lines[:end]
        self._check_width(lines, columns)
        wide = columns.each * columns.width
        values = fixed_numbers(self.name, [line[:wide] for line in lines], first, columns.width, example, what)
        if len(values) != count:
            cut = "the file is cut short: fetch it again"
            repair = cut if len(values) < count else "correct that number, or fetch the file again"
            raise RecordError(f"{promise}: {count} {what} should follow, {len(values)} found; {repair}")
        self.at += len(lines)
        return values

    def _check_width(self, lines: list[str], columns: Columns) -> None:
        """Raise RecordError for a line that goes on after its last column."""
        wide = columns.each * columns.width
        for at, line in enumerate(lines):
            if len(line) > wide and line[wide:].strip():
                raise RecordError(
                    f"{self.name}, line {self.at + at + 1}: has {quoted(line[wide:])} after its {columns.each} "
                    f"columns of {columns.width} characters; repair that line, or fetch the file again"
                )

    def skip(self, count: int, columns: Columns) -> None:
        """Pass over a table without a look at its numbers; raises RecordError where the file ends before."""
        self.take(-(-count // columns.each), "its samples")


def channel_code(dt: float, azimuth: float | None, vertical: bool) -> str:
    """A channel's code in SEED's habit: the band by the time step, N for an accelerometer, the direction."""
    band = "H" if dt <= 1.0 / 80.0 else "B"
    directions = {0.0: "N", 90.0: "E", 360.0: "N"}
    direction = "Z" if vertical else directions.get(-1.0 if azimuth is None else azimuth, "")
    return f"{band}N{direction}"
