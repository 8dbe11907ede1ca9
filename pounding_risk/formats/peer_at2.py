"""PEER AT2: acceleration in g as text, from the PEER ground motion databases.

A header of a few lines, then the samples, five or so on a line:

    PEER NGA STRONG MOTION DATABASE RECORD
    Imperial Valley-02, 5/19/1940, El Centro Array #9, 180
    ACCELERATION TIME SERIES IN UNITS OF G
    NPTS=   5372, DT=   .0100 SEC,

The older databases write ``NPTS=  4000, DT= .01000 SEC`` or ``4096 0.0100 NPTS, DT`` in the last of these
lines, and the corners of the filter in the line of the unit. Reading is strict: the number of samples must be
the one promised, and every one finite, because a cut file or a stray character otherwise passes unseen.
"""

from __future__ import annotations

import re
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from obspy import Stream, Trace, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.quantities import STANDARD_GRAVITY

HEADER_LINES = 10  # the header ends within these
SHORTEST_STEP, LONGEST_STEP = 1e-6, 1.0  # s; anything else is a damaged header
LARGEST = 256 * 2**20  # bytes; the longest record of the databases has under 2 MB

_NEWLINE = re.compile(r"\r\n|\r|\n")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"
_SAMPLE = re.compile(_NUMBER, re.ASCII)
_UNIT = re.compile(r"\bIN\s+UNITS?\s+OF\s+([^\s,;]+)", re.IGNORECASE)
_COUNT = re.compile(r"\bNPTS\s*=\s*([^\s,]+)", re.IGNORECASE)
_STEP = re.compile(r"\bDT\s*=\s*([^\s,]+)", re.IGNORECASE)
_BARE = re.compile(r"\s*(\S+)\s+(\S+)\s+NPTS\s*,\s*DT\b", re.IGNORECASE)
_CORNER = re.compile(rf"\b([HL]P)\s*=\s*({_NUMBER})", re.IGNORECASE)
_TITLE = re.compile(
    r"(?P<event>.*?)[,\s]\s*(?P<date>\d{1,2}/\d{1,2}/(?:\d{4}|\d{2}))(?:\s+(?P<time>\d{3,4}))?\s*,"
    r"\s*(?P<station>.*),\s*(?P<component>[^,]*)"
)


class Header(NamedTuple):
    """What the lines before the samples say."""

    title: str  # the line with event, date, station and component
    unit_line: str
    npts: int
    dt: float  # s
    lines: int  # of the file, up to the first sample


def _is_at2(file: Any) -> bool:
    """True for a PEER AT2 file: acceleration, its unit and NPTS are named in the first lines. Never raises.

    ``file`` is a path or a binary file, whose position is left where it was.
    """
    try:
        if hasattr(file, "read"):
            place = file.tell()
            start = file.read(4096)
            file.seek(place)
        else:
            with Path(file).open("rb") as opened:
                start = opened.read(4096)
        text = start.decode("latin-1") if isinstance(start, bytes) else start
        head = [line.upper() for line in _NEWLINE.split(text)[:HEADER_LINES]]
        of_acceleration = any("ACCELERATION" in line and _UNIT.search(line) for line in head)
        return of_acceleration and any("NPTS" in line and "DT" in line for line in head)
    except Exception:
        return False


def _read_at2(file: Any, headonly: bool = False, *, name: str = "", **_kwargs: Any) -> Stream:
    """One trace in m/s² from a PEER AT2 file: a path, or a file open for reading.

    ``stats.station`` and ``stats.channel`` are the station and the component in the header's words;
    ``stats.peer_at2`` has event, date, time, station, component, unit and filter corners. The header has no
    absolute time: ``starttime`` is the day of the earthquake at 0:00. With ``headonly`` no sample is read.
    ``name`` is what messages call a file that has no name of its own.

    Raises RecordError, naming file and line, for a header without unit, NPTS or DT, a unit other than g, a
    time step that is not positive, fewer than two samples, a number of samples other than NPTS, and for any
    sample that is no finite number.
    """
    name, text = _text(file, name)
    lines = _NEWLINE.split(text)
    header = _header(name, lines)
    stats = _stats(header)
    if headonly:
        return Stream([Trace(header={**stats, "npts": header.npts})])
    values = _samples(name, lines, header)
    return Stream([Trace(values * STANDARD_GRAVITY, header=stats)])


def _text(file: Any, name: str) -> tuple[str, str]:
    """Name and text of a file; every byte has a meaning in latin-1, so none stops the reading here."""
    if hasattr(file, "read"):
        given = getattr(file, "name", None)
        name = name or (str(given) if isinstance(given, str | Path) else "PEER AT2 record")
        raw = file.read(LARGEST + 1)
    else:
        name = name or str(file)
        try:
            with Path(file).open("rb") as opened:
                raw = opened.read(LARGEST + 1)
        except OSError as error:
            raise RecordError(f"{name}: cannot be read ({error.strerror}); check name and folder") from None
    if len(raw) > LARGEST:
        raise RecordError(
            f"{name}: is larger than {LARGEST >> 20} MiB, far more than any PEER AT2 record; check the file"
        )
    text = raw.decode("latin-1") if isinstance(raw, bytes) else str(raw)
    if not text.strip():
        what = "is blank" if text else "is empty (0 bytes)"
        raise RecordError(f"{name}: {what}; a PEER AT2 file has a header and samples: fetch it again")
    return name, text


def _header(name: str, lines: list[str]) -> Header:
    """Unit, number of samples and time step, with the line each stands in."""
    head = lines[:HEADER_LINES]
    at_unit = next((at for at, line in enumerate(head) if _UNIT.search(line)), None)
    if at_unit is None:
        raise RecordError(
            f'{name}: no line with "IN UNITS OF" among the first {HEADER_LINES}, found '
            f"{_quoted(lines[0])} first; a PEER AT2 file says ACCELERATION TIME SERIES IN UNITS OF G there: "
            "check that this is one"
        )
    _check_unit(name, at_unit + 1, head[at_unit])
    at_count = next((at for at, line in enumerate(head) if at > at_unit and "NPTS" in line.upper()), None)
    if at_count is None:
        found = _quoted(lines[at_unit + 1]) if at_unit + 1 < len(lines) else "the end of the file"
        raise RecordError(
            f"{name}: no line with NPTS and DT after line {at_unit + 1}, found {found}; a PEER AT2 file has "
            '"NPTS= 4000, DT= .0100 SEC" there: restore that line, or fetch the file again'
        )
    count, dt = _count_and_step(f"{name}, line {at_count + 1}", head[at_count])
    title = head[at_unit - 1].strip() if at_unit else ""
    return Header(title, head[at_unit], count, dt, at_count + 1)


def _check_unit(name: str, number: int, line: str) -> None:
    found = _UNIT.search(line)
    unit = found[1].rstrip(".") if found else ""
    if "ACCELERATION" not in line.upper() or unit.upper() != "G":
        quantity = "acceleration" if "ACCELERATION" in line.upper() else "something other than acceleration"
        raise RecordError(
            f'{name}, line {number}: the header says {quantity} in units of "{unit}"; a PEER AT2 file holds '
            "acceleration in units of G: convert the samples to g, or take the AT2 file of this record"
        )


def _count_and_step(place: str, line: str) -> tuple[int, float]:
    """NPTS and DT, in the words `NPTS= n, DT= dt` or `n dt NPTS, DT`."""
    bare = _BARE.match(line)
    if bare:
        count_text, step_text = bare[1], bare[2]
    else:
        count_found, step_found = _COUNT.search(line), _STEP.search(line)
        if not count_found or not step_found:
            missing = "NPTS" if not count_found else "DT"
            repair = 'write NPTS= and DT=, such as "NPTS= 4000, DT= .0100 SEC"'
            raise RecordError(f"{place}: no {missing} in {_quoted(line)}; {repair}")
        count_text, step_text = count_found[1], step_found[1]
    if not re.fullmatch(r"[+-]?\d{1,15}", count_text, re.ASCII):
        raise RecordError(f'{place}: NPTS is "{count_text}"; it must be a whole number of samples')
    count = int(count_text)
    if count < 2:
        raise RecordError(f"{place}: NPTS is {count}; a record needs at least 2 samples")
    dt = _float(step_text)
    if dt is None or not SHORTEST_STEP <= dt <= LONGEST_STEP:
        raise RecordError(
            f'{place}: DT is "{step_text}"; the time step must be a number of seconds greater than 0, '
            f"from {SHORTEST_STEP:g} to {LONGEST_STEP:g} s: restore that line, or fetch the file again"
        )
    return count, dt


def _samples(name: str, lines: list[str], header: Header) -> NDArray[np.float64]:
    """The samples in g, as many as promised."""
    values: list[float] = []
    for number, line in enumerate(lines[header.lines :], start=header.lines + 1):
        for word in line.split():
            value = _float(word)
            if value is None or not isfinite(value):
                raise RecordError(
                    f"{name}, line {number}: {_quoted(word)} is not a finite number; the samples after the "
                    "header must be plain numbers such as -.1234567E-02: repair that line, or fetch the "
                    "file again"
                )
            values.append(value)
    if len(values) != header.npts:
        fewer = len(values) < header.npts
        repair = "the file is cut short: fetch it again" if fewer else "correct NPTS, or fetch the file again"
        counts = f"the header promises {header.npts} samples, {len(values)} found"
        raise RecordError(f"{name}, line {header.lines}: {counts}; {repair}")
    return np.array(values)


def _float(word: str) -> float | None:
    """A plain number, Fortran's D exponents included; None for anything else, "nan" and "1_0" too."""
    if not _SAMPLE.fullmatch(word):
        return None
    return float(word.replace("D", "E").replace("d", "e"))


def _stats(header: Header) -> dict[str, Any]:
    """The header as ObsPy statistics."""
    told = _TITLE.fullmatch(header.title)
    facts = {key: (told[key] or "").strip(" ,") if told else "" for key in _TITLE.groupindex}
    at2: dict[str, Any] = {**facts, "title": header.title, "unit": "G"}
    for name, corner in _CORNER.findall(header.unit_line):
        at2["high_pass" if name.upper() == "HP" else "low_pass"] = _float(corner)
    stats: dict[str, Any] = {"delta": header.dt, "calib": 1.0, "peer_at2": AttribDict(at2)}
    stats.update(station=facts["station"], channel=facts["component"])
    day = _day(facts["date"])
    if day is not None:
        stats["starttime"] = day
    return stats


def _day(date: str) -> UTCDateTime | None:
    """Month/day/year as the databases write it; two digits of a year are of the twentieth century."""
    try:
        month, day, year = (int(part) for part in date.split("/"))
        return UTCDateTime(year + 1900 if year < 100 else year, month, day)
    except ValueError:
        return None


def _quoted(text: str) -> str:
    """Text of a file for a message, shortened and printable."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in text.strip())
    return f'"{shown}"' if len(shown) <= 40 else f'"{shown[:37]}..."'
