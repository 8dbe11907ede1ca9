"""What stands above the samples of a file of plain columns: comments that state facts, and the heads of the columns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._lines import LONGEST_LINE
from pounding_risk.motions.formats._text import number, quoted

COMMENTS = "#%!"
MOST_COLUMNS = 2
# What a comment may state, by the names it may use.
KEYS = {
    **{name: "unit" for name in ("unit", "units")},
    **{name: "dt" for name in ("dt", "delta", "time step", "timestep", "sampling interval")},
    **{name: "samples" for name in ("samples", "npts")},
    **{name: name for name in ("state", "starttime", "processing", "event", "date", "station", "component")},
    **{name: name for name in ("magnitude", "distance_km", "azimuth", "low_corner", "high_corner")},
}
REPEATED = "processing"  # a history has a line a step

_TIME = re.compile(r"t|times?\b.*", re.IGNORECASE)
_ACCELERATION = re.compile(r"a|acc\w*\b.*|.*\bacc(eleration)?s?", re.IGNORECASE)


class Title(NamedTuple):
    """The head of a column: its name, and the unit in brackets after it, None where there is none."""

    name: str
    unit: str | None

    def is_time(self) -> bool:
        """True where the name is that of a time."""
        return _TIME.fullmatch(self.name) is not None

    def is_acceleration(self) -> bool:
        """True where the name is that of an acceleration, or where any name has a unit, which is then read."""
        return not self.is_time() and (self.unit is not None or _ACCELERATION.fullmatch(self.name) is not None)


class Statement(NamedTuple):
    """What a comment states, and the line it stands in."""

    value: str
    line: int  # counted from 1


class Head(NamedTuple):
    """The lines above the samples, and how the first line of samples is laid out."""

    first: int  # index of the first line of samples
    columns: int
    separator: str | None  # None: blanks or tabs
    decimal_comma: bool
    statements: dict[str, Statement]
    titles: tuple[Title, ...]  # none, or one a column
    title_line: int  # counted from 1
    history: tuple[str, ...]


def parts(line: str, separator: str | None, decimal_comma: bool = False) -> list[str]:
    """The words of a line of samples, with decimal points."""
    if decimal_comma:
        line = line.replace(",", ".")
    return line.split() if separator is None else [word.strip() for word in line.split(separator)]


def layout(line: str) -> tuple[int, str | None] | None:
    """How many columns a line of numbers has, and their separator; None for any other line.

    Semicolon, comma or blanks part the columns. A decimal comma is read where semicolons do: nowhere else is it sure.
    """
    separator = next((each for each in ";," if each in line), None)
    words = parts(line, separator, separator == ";" and "," in line)
    if not words or any(number(word) is None for word in words):
        return None
    return len(words), separator


def head_of(name: str, lines: Sequence[str]) -> Head:
    """Everything above the first line of samples.

    Raises RecordError, naming the line, for a line that is no comment, no head of columns and no sample, for more than
    two columns, for heads that fit neither, and where there are no samples.
    """
    statements: dict[str, Statement] = {}
    history: list[str] = []
    titled = 0
    for at, line in enumerate(lines):
        text = line.strip()
        if not text:
            continue
        _check_length(f"{name}, line {at + 1}", text)
        if text[0] in COMMENTS:
            _state(f"{name}, line {at + 1}", text.lstrip(COMMENTS + " "), at + 1, statements, history)
            continue
        found = layout(text)
        if found is None:
            if titled or not (text[0].isalpha() or text[0] == '"'):
                raise _strange(f"{name}, line {at + 1}", text)
            titled = at + 1
            continue
        columns, separator = found
        _check_columns(f"{name}, line {at + 1}", columns)
        titles = _titles(f"{name}, line {titled}", lines[titled - 1], columns) if titled else ()
        comma = separator == ";" and any("," in line for line in lines[at:])
        return Head(at, columns, separator, comma, statements, titles, titled, tuple(history))
    if titled:
        raise _strange(f"{name}, line {titled}", lines[titled - 1])
    raise RecordError(f"{name}: has no samples, every line is blank or a comment; fetch the record again")


def _check_length(place: str, text: str) -> None:
    """Raise RecordError for a line that is longer than any head or sample; looking for words in it takes its square."""
    if len(text) > LONGEST_LINE:
        raise RecordError(
            f"{place}: has {len(text)} characters, {LONGEST_LINE} at most are read; restore its line ends, or fetch "
            "the file again"
        )


def _strange(place: str, text: str) -> RecordError:
    hint = ""
    if re.search(r"\d,\d", text):
        hint = " (a decimal comma is read only where semicolons part the columns)"
    return RecordError(
        f"{place}: {quoted(text)} is neither numbers nor the heads of columns{hint}; a file of plain columns has one "
        "column, acceleration, or two, time and acceleration, under comments after # and at most one line of heads "
        'such as "time [s], acceleration [g]": repair that line'
    )


def _check_columns(place: str, columns: int) -> None:
    if columns > MOST_COLUMNS:
        raise RecordError(
            f"{place}: has {columns} columns; one, acceleration, or two, time and acceleration, are read: keep one "
            "component a file, with one sample a line"
        )


def _state(place: str, text: str, line: int, statements: dict[str, Statement], history: list[str]) -> None:
    """Take over what a comment states; one that states nothing known is a comment."""
    before, *after = re.split("[=:]", text, maxsplit=1)
    key = KEYS.get(" ".join(before.split()).lower())
    if key is None or not after:
        return
    value = after[0].strip()
    if key == REPEATED:
        history.append(value)
    elif key in statements and statements[key].value != value:
        raise RecordError(
            f"{place}: states {key} {quoted(value)}, line {statements[key].line} states "
            f"{quoted(statements[key].value)}; keep one"
        )
    else:
        statements[key] = Statement(value, line)


def _titles(place: str, line: str, columns: int) -> tuple[Title, ...]:
    """The head of each column."""
    text = line.strip()
    pieces = re.split(r"[,;\t]", text)
    if len(pieces) < columns:
        pieces = re.split(r"(?<=[\])])\s+|\s{2,}", text)
    if len(pieces) < columns:
        pieces = text.split()
    titles = tuple(title for piece in pieces if (title := _title(piece.strip().strip('"').strip())))
    named = len(titles) == len(pieces) == columns and titles[-1].is_acceleration()
    if not named or (columns == MOST_COLUMNS and not titles[0].is_time()):
        raise _strange(place, text)
    return titles


def _title(text: str) -> Title | None:
    """Name and unit of one head, such as "acceleration [g]" or "Acc (m/s2)"."""
    if not text[:1].isalpha():
        return None
    opening = re.search(r"[\[(]", text)
    if opening is None:
        return Title(text, None)
    if text[-1] != {"[": "]", "(": ")"}[opening[0]]:
        return None
    return Title(text[: opening.start()].strip(), text[opening.end() : -1].strip())
