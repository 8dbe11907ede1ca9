"""PEER AT2: acceleration in g as text, from the PEER ground motion databases.

A header of a few lines, then the samples, five or so on a line:

    PEER NGA STRONG MOTION DATABASE RECORD
    Imperial Valley-02, 5/19/1940, El Centro Array #9, 180
    ACCELERATION TIME SERIES IN UNITS OF G
    NPTS=   5372, DT=   .0100 SEC,

The older databases write ``NPTS=  4000, DT= .01000 SEC`` or ``4096 0.0100 NPTS, DT`` in the last of these
lines, the corners of the filter in the line of the unit, and in the title a time of day and the owner of the
station, as in ``LOMA PRIETA 10/18/89 00:05, GILROY ARRAY #1, 000 (CDMG STATION 47379)``. Reading is strict: the number
of samples must be the one promised, and every one finite, because a cut file or a stray character otherwise passes
unseen.
"""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Any, NamedTuple

from obspy import Stream, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format, _text
from pounding_risk.motions.formats._text import NEWLINE, NUMBER, quoted
from pounding_risk.units import STANDARD_GRAVITY

KIND = "PEER AT2"
HEADER_LINES = 10  # the header ends within these
LONGEST_TITLE = 500  # characters; beyond, looking for the date in it would take minutes
FIRST_YEAR = 33  # 1933, of the first accelerograms; two digits of a year below are of this century
# How many of the unit after DT a second has; NPTS may follow DT at once.
STEP_UNITS = dict.fromkeys(("", "NPTS", "S", "SEC", "SECS", "SECOND", "SECONDS"), 1.0)
STEP_UNITS |= dict.fromkeys(("MS", "MSEC", "MSECS", "MILLISECOND", "MILLISECONDS"), 1000.0)
COMPASS = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0}

_UNIT = re.compile(r"\bIN\s+UNITS?\s+OF\s+([^\s,;]+)", re.IGNORECASE)
_COUNT = re.compile(r"\bNPTS\s*=\s*([^\s,]+)", re.IGNORECASE)
_STEP = re.compile(r"\bDT\s*=\s*([^\s,]+)\s*([a-z]*)", re.IGNORECASE)
_BARE = re.compile(r"\s*(\S+)\s+(\S+)\s+NPTS\s*,\s*DT\b\W*([a-z]*)", re.IGNORECASE)
_CORNER = re.compile(rf"\b([HL]P)\s*=\s*({NUMBER})", re.IGNORECASE)
_TITLE = re.compile(
    r"(?P<event>.*?)[,\s]\s*(?P<date>\d{1,2}/\d{1,2}/(?:\d{4}|\d{2}))"
    r"(?:\s+(?P<time>\d{3,4})|[,\s]\s*(?P<clock>\d{1,2}:\d\d))?\s*,"
    r"\s*(?P<station>.*),\s*(?P<component>[^,(]*)(?:\(.*\)\s*)?"
)


class Header(NamedTuple):
    """The lines before the samples, with the values read from them."""

    title: str  # the line with event, date, station and component
    unit_line: str
    npts: int
    dt: float  # s
    lines: int  # of the file, up to the first sample


@_text.recogniser()
def _is_at2(start: str) -> bool:
    """True for a PEER AT2 file: acceleration, its unit and NPTS are named in the first lines."""
    head = [line.upper() for line in NEWLINE.split(start)[:HEADER_LINES]]
    of_acceleration = any("ACCELERATION" in line and _UNIT.search(line) for line in head)
    return of_acceleration and any("NPTS" in line and "DT" in line for line in head)


def _read_at2(file: Any, headonly: bool = False, *, name: str = "", **_kwargs: Any) -> Stream:
    """One trace in m/s² from a PEER AT2 file.

    ``stats.station`` and ``stats.channel`` are the station and the component in the header's words;
    ``stats.peer_at2`` has event, date, time, station, component, unit and filter corners. The header has no
    absolute time: ``starttime`` is the day of the earthquake at 0:00.

    Raises RecordError, naming file and line, for a header without unit, NPTS or DT, a unit other than g, a
    time step that is not positive, fewer than two samples, a number of samples other than NPTS, and for any
    sample that is no finite number.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = NEWLINE.split(text)
    header = _header(name, lines)
    title = _TITLE.fullmatch(header.title) if len(header.title) <= LONGEST_TITLE else None
    facts = {key: (title[key] or "").strip(" ,") if title else "" for key in _TITLE.groupindex}
    facts["time"] = facts.pop("clock") or facts["time"]
    corners = {kind.upper(): _text.number(corner) for kind, corner in _CORNER.findall(header.unit_line)}
    at2: dict[str, Any] = {**facts, "title": header.title, "unit": "G"}
    at2 |= {key: corners[kind] for key, kind in (("high_pass", "HP"), ("low_pass", "LP")) if kind in corners}
    day = None
    with suppress(ValueError):
        month, day_of_month, year = (int(digits) for digits in facts["date"].split("/"))
        century = 0 if year > 99 else 1900 if year >= FIRST_YEAR else 2000
        day = UTCDateTime(century + year, month, day_of_month)
    record = _text.record_facts(
        state="processed",
        timed=False,  # a header states the day alone
        units="units: g, times 9.80665 m/s²",
        event=facts["event"],
        date=facts["date"] if day is None else str(day.date),
        station=facts["station"],
        component=facts["component"],
        azimuth=azimuth_of(facts["component"]),
        low_corner=corners.get("HP"),
        high_corner=corners.get("LP"),
    )
    if not headonly:
        numbers = _text.free_numbers(name, lines[header.lines :], header.lines, "-.1234567E-02")
        _text.check_count(f"{name}, line {header.lines}", header.npts, len(numbers), "NPTS")
        _text.check_last(name, text, [word for line in lines[header.lines :] for word in line.split()])
    named = {"station": facts["station"], "channel": facts["component"], "peer_at2": AttribDict(at2)}
    samples = header.npts if headonly else numbers
    return Stream([_text.trace_of(samples, STANDARD_GRAVITY, header.dt, record, day, **named)])


def azimuth_of(component: str) -> float | None:
    """Degrees clockwise from north that the name of a component says: 090, 37.5 or E; None for any other."""
    if re.fullmatch(r"\d{1,3}(\.\d+)?", component, re.ASCII) and float(component) <= 360.0:
        return float(component)
    return COMPASS.get(component.upper())


def _header(name: str, lines: list[str]) -> Header:
    """Unit, number of samples and time step, with the line each stands in."""
    head = lines[:HEADER_LINES]
    at_unit = next((at for at, line in enumerate(head) if _UNIT.search(line)), None)
    if at_unit is None:
        raise RecordError(
            f'{name}: no line with "IN UNITS OF" among the first {HEADER_LINES}, found '
            f"{quoted(lines[0])} first; a PEER AT2 file says ACCELERATION TIME SERIES IN UNITS OF G there: "
            "check that this is one"
        )
    unit = _UNIT.search(head[at_unit])[1].rstrip(".")  # type: ignore[index]
    is_acceleration = "ACCELERATION" in head[at_unit].upper()
    if not is_acceleration or unit.upper() != "G":
        quantity = "acceleration" if is_acceleration else "something other than acceleration"
        raise RecordError(
            f"{name}, line {at_unit + 1}: the header says {quantity} in units of {quoted(unit)}; a PEER AT2 file holds "
            "acceleration in units of G: convert the samples to g, or take the AT2 file of this record"
        )
    at_count = next((at for at, line in enumerate(head) if at > at_unit and "NPTS" in line.upper()), None)
    if at_count is None:
        next_line = quoted(lines[at_unit + 1]) if at_unit + 1 < len(lines) else "the end of the file"
        raise RecordError(
            f"{name}: no line with NPTS and DT after line {at_unit + 1}, found {next_line}; a PEER AT2 file has "
            '"NPTS= 4000, DT= .0100 SEC" there: restore that line, or fetch the file again'
        )
    count, dt = _count_and_step(f"{name}, line {at_count + 1}", head[at_count])
    return Header(head[at_unit - 1].strip() if at_unit else "", head[at_unit], count, dt, at_count + 1)


def _count_and_step(where: str, line: str) -> tuple[int, float]:
    """NPTS and DT, in the words `NPTS= n, DT= dt` or `n dt NPTS, DT`."""
    bare = _BARE.match(line)
    if bare:
        count_text, step_text, unit = bare[1], bare[2], bare[3]
    else:
        count_found, step_found = _COUNT.search(line), _STEP.search(line)
        if not count_found or not step_found:
            missing = "NPTS" if not count_found else "DT"
            repair = 'write NPTS= and DT=, such as "NPTS= 4000, DT= .0100 SEC"'
            raise RecordError(f"{where}: no {missing} in {quoted(line)}; {repair}")
        count_text, step_text, unit = count_found[1], step_found[1], step_found[2]
    if unit.upper() not in STEP_UNITS:
        raise RecordError(f'{where}: DT is in {quoted(unit)}; write it in seconds, such as "DT= .0100 SEC"')
    step = _text.number(step_text)
    step = None if step is None else step / STEP_UNITS[unit.upper()]
    return _text.whole_count(where, count_text, "NPTS"), _text.check_step(where, step, f"{step_text} {unit}")


FORMAT = Format("PEER_AT2", "PEER AT2 (.at2)", (".at2",), _is_at2, _read_at2)
