"""Plain columns as text: one of acceleration, or two of time and acceleration, with unit and time step stated.

    # unit = cm/s^2                                   time [s], acceleration [g]
    # dt = 0.01 s                                     0.00, 0.00012
    0.12                                              0.01, -0.00034
    -0.34

Commas, semicolons, tabs or blanks part the columns. Comments begin with #, % or !. What they may state, one a line:
unit, dt, state ("raw" or "processed"), samples (their number), peak (the largest of them, without its sign), starttime
(of the first sample), event, magnitude, date, distance_km, station, component, azimuth, vertical (true of a component
that is), low_corner, high_corner, processing (a line a step).

Where such a file states no unit or no time step, the user must state it; neither is guessed. Its
state is "processed" unless it says "# state = raw": it was made by a program that had read the record before, and
filtering a processed record again is the more common damage.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from obspy import Stream, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import TO_GIVE, Format, _text, known_unit, size_of_unit, unit_sentence
from pounding_risk.motions.formats._text import LONGEST_LINE, NEWLINE, quoted
from pounding_risk.units import STEP, QuantityError, parse

COMMENTS = "#%!"
MOST_COLUMNS = 2
# What a comment may state, by the names it may use.
KEYS = {
    **{name: "unit" for name in ("unit", "units")},
    **{name: "dt" for name in ("dt", "delta", "time step", "timestep", "sampling interval")},
    **{name: "samples" for name in ("samples", "npts")},
    **{name: name for name in ("state", "starttime", "peak", "processing", "event", "date", "station", "component")},
    **{name: name for name in ("magnitude", "distance_km", "azimuth", "vertical", "low_corner", "high_corner")},
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
    """A value that is stated, and where: "x.txt, line 2" or "x.txt: dt as given"."""

    value: Any
    place: str


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
    separator = next((mark for mark in ";," if mark in line), None)
    words = parts(line, separator, separator == ";" and "," in line)
    if not words or any(_text.number(word) is None for word in words):
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
        if len(text) > LONGEST_LINE:  # looking for words in a line takes the square of its length
            raise RecordError(
                f"{name}, line {at + 1}: has {len(text)} characters, {LONGEST_LINE} at most are read; restore its line "
                "ends, or fetch the file again"
            )
        if text[0] in COMMENTS:
            _take_statement(f"{name}, line {at + 1}", text.lstrip(COMMENTS + " "), statements, history)
            continue
        laid_out = layout(text)
        if laid_out is None:
            if titled or not (text[0].isalpha() or text[0] == '"'):
                raise _strange(f"{name}, line {at + 1}", text)
            titled = at + 1
            continue
        columns, separator = laid_out
        if columns > MOST_COLUMNS:
            raise RecordError(
                f"{name}, line {at + 1}: has {columns} columns; one, acceleration, or two, time and acceleration, are "
                "read: keep one component a file, with one sample a line"
            )
        titles = _titles(f"{name}, line {titled}", lines[titled - 1], columns) if titled else ()
        comma = separator == ";" and any("," in line for line in lines[at:])
        return Head(at, columns, separator, comma, statements, titles, titled, tuple(history))
    if titled:
        raise _strange(f"{name}, line {titled}", lines[titled - 1])
    raise RecordError(f"{name}: has no samples, every line is blank or a comment; fetch the record again")


def _strange(where: str, text: str) -> RecordError:
    hint = ""
    if re.search(r"\d,\d", text):
        hint = " (a decimal comma is read only where semicolons part the columns)"
    return RecordError(
        f"{where}: {quoted(text)} is neither numbers nor the heads of columns{hint}; a file of plain columns has one "
        "column, acceleration, or two, time and acceleration, under comments after # and at most one line of heads "
        'such as "time [s], acceleration [g]": repair that line'
    )


def _take_statement(where: str, text: str, statements: dict[str, Statement], history: list[str]) -> None:
    """Add what a comment states to the statements or the history; other comments are passed over."""
    before, *after = re.split("[=:]", text, maxsplit=1)
    key = KEYS.get(" ".join(before.split()).lower())
    if key is None or not after:
        return
    stated = after[0].strip()
    if key == REPEATED:
        history.append(stated)
    elif key in statements and statements[key].value != stated:
        raise RecordError(
            f"{where}: states {key} {quoted(stated)}, {statements[key].place.rpartition(', ')[2]} states "
            f"{quoted(statements[key].value)}; keep one"
        )
    else:
        statements[key] = Statement(stated, where)


def _titles(where: str, line: str, columns: int) -> tuple[Title, ...]:
    """The head of each column; raises RecordError where there is not one for each."""
    text = line.strip()
    pieces = re.split(r"[,;\t]", text)
    if len(pieces) < columns:
        pieces = re.split(r"(?<=[\])])\s+|\s{2,}", text)
    if len(pieces) < columns:
        pieces = text.split()
    titles = tuple(title for piece in pieces if (title := _title(piece.strip().strip('"').strip())))
    named = len(titles) == len(pieces) == columns and titles[-1].is_acceleration()
    if not named or (columns == MOST_COLUMNS and not titles[0].is_time()):
        raise _strange(where, text)
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


LOOSEST, TIGHTEST = 0.1, 1e-3  # of the time step: how far off a time may be at most, and may always be


def column(name: str, first: int, words: list[str]) -> NDArray[np.float64]:
    """The numbers of a column; ``first`` is the index of the line that its first word stands in.

    Raises RecordError, naming the line, for a word that is no finite number.
    """
    return _text.numbers(name, enumerate(words), first, "-0.0123", "every line after the head must hold")


def step_of_times(name: str, first: int, words: list[str]) -> tuple[float, float]:
    """The time step [s] of a column of times [s], and how far off the last of them may be [s].

    Times rise in equal steps where each is off its place on the line from the first to the last by no more than one
    unit of the last digit printed (of the most decimals, or of the most significant digits, whichever is coarser) and
    no more than a tenth of the step; a thousandth of it is always allowed. The step is the decimal of fewest digits
    that fits. Raises RecordError, naming the line, where they do not.
    """
    times = column(name, first, words)
    rises = np.diff(times)
    flat = np.flatnonzero(~(rises > 0.0))
    if len(flat):
        at = int(flat[0]) + 1
        raise RecordError(
            f"{name}, line {first + at + 1}: the time {words[at]} is not after the {words[at - 1]} of the line before; "
            "write times that rise, with enough digits to distinguish them"
        )
    steps = len(times) - 1
    step = float(times[-1] - times[0]) / steps
    _text.check_step(f"{name}, line {first + 1}", step, f"{step:g}", "the step of the times")
    off = np.clip(_last_digit(times, words), TIGHTEST * step, LOOSEST * step)
    if (np.abs(times - (times[0] + np.arange(steps + 1) * step)) > off).any():
        usual = float(np.median(rises))
        at = int(np.argmax(np.abs(rises - usual))) + 1
        raise RecordError(
            f"{name}, line {first + at + 1}: the times do not rise in equal steps, by {rises[at - 1]:.6g} s here and "
            f"by {usual:.6g} s elsewhere; restore missing lines, print more digits, or resample to equal steps"
        )
    # The decimal of fewest digits that fits: 0.01 and not 0.010000000000000002.
    rounded = (round(step, digits) for digits in range(16))
    return next((short for short in rounded if abs(short - step) <= float(off[-1]) / steps), step), float(off[-1])


def _last_digit(times: NDArray[np.float64], words: list[str]) -> NDArray[np.float64]:
    """One unit of the last digit printed of each time [s]."""
    decimals, digits = 0, 1
    for word in words:
        mantissa, _, exponent = word.lower().replace("d", "e").partition("e")
        integer_part, _, fraction = mantissa.lstrip("+-").partition(".")
        decimals = max(decimals, len(fraction) - int(exponent or 0))
        digits = max(digits, len((integer_part + fraction).lstrip("0")))
    leading = np.floor(np.log10(np.maximum(np.abs(times), 1e-12))) + 1.0
    return np.asarray(10.0 ** np.maximum(-min(decimals, 20), leading - digits), dtype=np.float64)


KIND = "plain columns"
STATES = ("raw", "processed")
SECONDS = ("s", "sec", "secs", "second", "seconds")
WORDS, NUMBERS = ("event", "date", "station", "component"), ("magnitude", "distance_km", "azimuth")
CORNERS = ("low_corner", "high_corner")
FACTS = (*WORDS, *NUMBERS, "vertical", *CORNERS)  # what a comment may state of the recording
TO_STATE = {
    "unit": ("the unit of its acceleration", f'write "# unit = cm/s^2" above the samples, or give it: {TO_GIVE}'),
    "dt": (
        "its time step",
        'write "# dt = 0.01 s" above the samples, or give it: records.dt = "0.01 s" in a scene, dt=0.01 in Python, '
        '--dt "0.01 s" on the command line',
    ),
}

_INSTANT = re.compile(r"\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d(?:\.\d{1,9})?)?)?Z?", re.ASCII)


@_text.recogniser()
def fits(start: str) -> bool:
    """True where text is laid out as plain columns, whether it states unit and time step or not."""
    return _start(start) is not None


@_text.recogniser()
def _is_columns(start: str) -> bool:
    """True for plain columns that state their unit and, by ``dt`` or a column, their time step."""
    head = _start(start)
    unit = head is not None and ("unit" in head.statements or bool(head.titles and head.titles[-1].unit))
    return head is not None and unit and (head.columns > 1 or "dt" in head.statements)


def _start(text: str) -> Head | None:
    """The head of plain columns, from the start of a file alone; None where that is none."""
    if "\0" in text:
        return None
    try:
        return head_of("", NEWLINE.split(_unicode(text)))
    except RecordError:
        return None


def _read_columns(
    file: Any,
    headonly: bool = False,
    *,
    name: str = "",
    unit: str | None = None,
    dt: float | None = None,
    **_kwargs: Any,
) -> Stream:
    """One trace in m/s² from plain columns.

    ``unit`` and ``dt`` [s] are what the caller knows of a file that does not say it; where both say it, they must
    agree. A column of times must rise in equal steps (`step_of_times`).

    Raises RecordError, naming file and line, for no unit or time step or two that differ, for what is no column of
    finite numbers, for times that do not fit, fewer than two samples, and another number of them than stated.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = NEWLINE.split(_unicode(text).rstrip())
    head = head_of(name, lines)
    size, units = _unit(name, head, unit, dt)
    record, start = _facts(head, units)
    words = _words(name, lines, head)
    if "samples" in head.statements:
        word, where = head.statements["samples"]
        if not re.fullmatch(r"\d{1,12}", word, re.ASCII):
            raise RecordError(f"{where}: samples is {quoted(word)}; it must be a whole number, how many there are")
        _text.check_count(where, int(word), len(words), "samples")
    step = _time_step(name, words, head, dt)
    samples: Any = len(words)
    if not headonly:
        samples = column(name, head.first, [row[-1] for row in words])
        _text.check_last(name, text, [row[-1] for row in words])
        _text.check_peak(samples * size, _stated_peak(head, size))
    named: dict[str, Any] = {"station": record.get("station", ""), "channel": record.get("component", "")}
    if head.history:
        named["processing"] = list(head.history)
    return Stream([_text.trace_of(samples, size, step, record, start, **named)])


def _unicode(text: str) -> str:
    """Text that was read as latin-1, decoded as UTF-8 where it is that."""
    try:
        return text.encode("latin-1").decode("utf-8-sig")
    except UnicodeError:
        return text


def _unit(name: str, head: Head, stated: str | None, dt: float | None) -> tuple[float, str]:
    """How many m/s² one unit of the samples is, with the sentence; the caller, a comment and a head must agree."""
    statements = [head.statements["unit"]] if "unit" in head.statements else []
    if head.titles and head.titles[-1].unit is not None:
        statements.append(Statement(head.titles[-1].unit, f"{name}, line {head.title_line}"))
    if stated is not None:
        statements.append(Statement(stated, f"{name}: unit as given"))
    if not statements:
        stepless = head.columns == 1 and dt is None and "dt" not in head.statements
        raise _unstated(name, "unit", *(["dt"] if stepless else []))
    sizes = [size_of_unit(statement.value, statement.place) for statement in statements]
    for other, size in zip(statements[1:], sizes[1:], strict=True):
        if size != sizes[0]:
            raise RecordError(
                f"{other.place}: the unit is {quoted(other.value)}, "
                f"{statements[0].place.removeprefix(name).strip(', ')} "
                f"says {quoted(statements[0].value)}; keep the right one"
            )
    return sizes[0], unit_sentence(str(statements[0].value), sizes[0])


def _unstated(name: str, *missing: str) -> RecordError:
    nouns = " nor ".join(TO_STATE[key][0] for key in missing)
    repair = "; ".join(TO_STATE[key][1] for key in missing)
    return RecordError(f"{name}: {'says neither' if len(missing) > 1 else 'does not say'} {nouns}; {repair}")


def _stated_step(head: Head) -> Statement | None:
    """The time step that a comment states [s]; a number without a unit is in seconds, as in every format."""
    statement = head.statements.get("dt")
    if statement is None:
        return None
    step = _text.number(statement.value)
    if step is None:
        try:
            step = parse(re.sub(r"(?<=[\d. ])sec(onds?)?$", "s", statement.value), STEP)
        except QuantityError:
            step = None
    return statement._replace(value=_text.check_step(statement.place, step, statement.value, "dt"))


def _facts(head: Head, units: str) -> tuple[AttribDict, UTCDateTime | None]:
    """Facts of the recording, and when it starts."""
    facts: dict[str, Any] = {key: head.statements[key].value for key in WORDS if key in head.statements}
    for key in (*NUMBERS, *CORNERS):
        fact = _text.number(head.statements[key].value.split(" ")[0]) if key in head.statements else None
        if fact is not None:
            facts[key] = fact
    if "vertical" in head.statements and head.statements["vertical"].value.lower() == "true":
        facts["vertical"] = True
    state, start, begins = head.statements.get("state"), head.statements.get("starttime"), None
    if state is not None and state.value not in STATES:
        raise RecordError(f'{state.place}: state is {quoted(state.value)}; it may be "raw" or "processed"')
    if start is not None:
        sentence = (
            f"{start.place}: starttime is {quoted(start.value)}; write a time such as "
            "2019-07-06T03:19:53.04Z, or leave that line out"
        )
        if not _INSTANT.fullmatch(start.value):
            raise RecordError(sentence)
        with _text.time_of_header(sentence):
            begins = UTCDateTime(start.value)
    return _text.record_facts(state=state.value if state else "processed", units=units, **facts), begins


def _stated_peak(head: Head, size: float) -> _text.StatedPeak | None:
    """The largest acceleration that a comment states; without a unit it is in that of the samples, of ``size`` m/s²."""
    if "peak" not in head.statements:
        return None
    (word, _, unit), where = head.statements["peak"].value.partition(" "), head.statements["peak"].place
    size_of_peak = known_unit(unit) if unit else size
    return None if size_of_peak is None else _text.stated_peak(word, unit or "of its unit", size_of_peak, where)


def _words(name: str, lines: Sequence[str], head: Head) -> list[list[str]]:
    """The words of every line of samples; each must have as many as the first."""
    rows = [parts(line, head.separator, head.decimal_comma) for line in lines[head.first :]]
    for at, row in enumerate(rows, head.first):
        if head.decimal_comma and "." in lines[at]:
            raise RecordError(
                f"{name}, line {at + 1}: {quoted(lines[at])} has a decimal point, other lines have decimal commas; "
                "write one of the two throughout"
            )
        if len(row) != head.columns or not row[0]:
            contents = f"{quoted(lines[at])} has {len(row)}" if lines[at].strip() else "is blank"
            raise RecordError(
                f"{name}, line {at + 1}: {contents}, where the first line of samples has {head.columns} "
                f"column{'s' if head.columns > 1 else ''}; repair that line, or fetch the file again"
            )
    if len(rows) < 2:
        raise RecordError(f"{name}: has 1 sample; a record needs at least 2")
    return rows


def _time_step(name: str, words: list[list[str]], head: Head, stated: float | None) -> float:
    """The time step [s] that the caller, a comment and a column of times agree upon."""
    statement = _stated_step(head)
    if stated is not None:
        _text.check_step(f"{name}: dt as given", stated, f"{stated:g}", "dt")
        if statement is not None and abs(statement.value - stated) > TIGHTEST * stated:
            raise RecordError(
                f"{statement.place}: dt is {statement.value:g} s, as given it is {stated:g} s; keep the right one"
            )
        statement = statement or Statement(stated, f"{name}: dt as given")
    if head.columns == 1:
        if statement is None:
            raise _unstated(name, "dt")
        return float(statement.value)
    of_times = head.titles[0].unit if head.titles else None
    if of_times is not None and of_times.lower() not in SECONDS:
        raise RecordError(
            f"{name}, line {head.title_line}: the times are in {quoted(of_times)}; write them in seconds, in a column "
            "headed time [s]"
        )
    step, drift = step_of_times(name, head.first, [row[0] for row in words])
    if statement is None:
        return step
    if abs(statement.value - step) * (len(words) - 1) > drift:
        raise RecordError(
            f"{statement.place}: dt is {statement.value:g} s, but the times rise by {step:g} s; correct one of them"
        )
    return float(statement.value)


FORMAT = Format(
    "COLUMNS",
    "plain columns (.csv, .txt, .dat)",
    (".csv", ".txt", ".dat"),
    _is_columns,
    _read_columns,
    takes=("unit", "dt"),
)
