"""SMC: the text format of the USGS National Strong-Motion Program, one component a file.

Eleven lines of text, 48 whole numbers, 50 real numbers, comments that start with "|", then the samples, eight on a
line of ten characters each, which may touch:

    2 CORRECTED ACCELEROGRAM
    ...
     1.5057E+0-2.2223E+0-1.9234E+0-3.1562E+0-3.2440E+0-3.5638E+0-5.1941E+0-5.7933E+0

The numbers mean what their place says. Accelerations are in cm/s², by the definition of the format. What is not known
is the first of the whole and the first of the real numbers, -32768 and 1.7e38 as a rule. Records of film know their
start to the minute only.

Source: U.S. Geological Survey, National Strong-Motion Program, "SMC- and BBF-format Data Files" (smcfmt.txt).
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from obspy import Stream, Trace, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format, _text
from pounding_risk.motions.formats._text import NEWLINE, Columns, Even, Lines, StatedPeak, quoted

KIND = "SMC"
TEXT_LINES = 11
WHOLE, WHOLE_COLUMNS = 48, Columns(8, 10)
REAL, REAL_COLUMNS = 50, Columns(5, 15)
SAMPLES = Columns(8, 10)
UNIT = 0.01  # m/s² in one cm/s²
EXTREMES = (30, 32)  # of the real numbers: the largest and the smallest acceleration
TINY = 1e-3  # s; a time has five digits, of which the last is rounded, and the first of a record is 0
LARGEST = 1e30  # real numbers above mean: not known
STATES = {"1 UNCORRECTED ACCELEROGRAM": "raw", "2 CORRECTED ACCELEROGRAM": "processed"}

_EVENT = re.compile(r"\s*(\d{4})\s+(\d{1,2})\s+(\d{1,2})\s+(?:\d{3,4}\s+)?(.*)")
_STATION = re.compile(r"station\s*=(.*?)\s*component\s*=(.*)", re.I)


class Header(NamedTuple):
    """The texts and numbers before the samples."""

    name: str
    text: list[str]
    codes: NDArray[np.float64]
    reals: NDArray[np.float64]
    peak: StatedPeak | None

    def code(self, number: int) -> int | None:
        """A whole number of the header, counted from 1; None where it is not known."""
        code = float(self.codes[number - 1])
        return None if code == self.codes[0] or not code.is_integer() else int(code)

    def real(self, number: int) -> float | None:
        """A real number of the header, counted from 1; None where it is not known."""
        real = float(self.reals[number - 1])
        return None if real == self.reals[0] or abs(real) > LARGEST else real


@_text.recogniser(1024)
def _is_smc(start: str) -> bool:
    """True for an SMC file, of whatever it holds: magnitudes and station are where the format has them."""
    head = NEWLINE.split(start)
    magnitudes, station, instrument = head[4].lower(), head[5].lower(), head[7].lower()
    words = station.startswith("station") and "component" in station
    return magnitudes.startswith("moment mag") and words and instrument.startswith("inst type")


def _read_smc(file: Any, headonly: bool = False, *, name: str = "", dt: float | None = None, **_kwargs: Any) -> Stream:
    """One trace in m/s² from an SMC file.

    Uncorrected accelerograms are raw, corrected ones processed. Those of film that were digitised at uneven times are
    read at every ``dt`` [s] off the straight lines between them. ``stats.smc`` has the title, the coordinates and
    whether the file is marked as having a problem.

    Raises RecordError, naming file and line, for anything but acceleration, for uneven times without ``dt``, that do
    not rise or leave gaps, a time step out of range, another number of samples than the header says, another largest
    one, and any number that is not finite.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = Lines(name, text)
    head = lines.take(TEXT_LINES, "the eleven lines of text")
    title = " ".join(head[0].upper().split())
    if title not in STATES:
        allowed = " or ".join(f'"{known}"' for known in STATES)
        raise RecordError(
            f"{name}, line 1: the title is {quoted(head[0])}; an SMC file of acceleration has {allowed} there: take "
            "such a file of this record"
        )
    codes = lines.table(WHOLE, WHOLE_COLUMNS, "-32768", "whole numbers of the header")
    at = lines.at
    reals = lines.table(REAL, REAL_COLUMNS, "0.1700000E+39", "real numbers of the header")
    header = Header(name, head, codes, reals, _peak(lines, at, reals))
    count = header.code(17)
    if count is None or count < 2 or (header.real(2) is None and (count < 4 or count % 2)):
        raise RecordError(
            f"{name}, line {TEXT_LINES + 3}: the number of samples is {codes[16]:g}; a record needs at least 2, or as "
            "many pairs of time and acceleration: fetch the file again"
        )
    _check_comments(lines, header)
    where, rate = f"{name}, line {TEXT_LINES + 7}", header.real(2)
    if rate is None:  # pairs of times and accelerations
        pairs = _samples(lines, count, spare=1)
        even = _text.even_samples(where, pairs, dt, 10.0 ** (np.floor(np.log10(np.abs(pairs[0::2]) + TINY)) - 4.0))
    else:
        step = _text.check_step(where, 1.0 / rate if rate > 0.0 else None, f"1/({rate:g}/s)", "the time step")
        # A header's count may be damaged, so that nothing is allocated for it.
        samples = np.broadcast_to(0.0, count) if headonly else _samples(lines, count)
        even = Even(samples, step, "", samples)
    if not headonly:
        _text.check_peak(even.digitised * UNIT, header.peak)
    return Stream([_trace(header, STATES[title], even, headonly)])


def _samples(lines: Lines, count: int, spare: int = 0) -> NDArray[np.float64]:
    """The numbers after the comments; raises RecordError where other lines than blank ones follow them.

    Files of pairs have a ``spare`` line, of times that do not go on from the promised ones, which is left out; those
    of the Loma Prieta earthquake do.
    """
    samples = lines.table(count, SAMPLES, "-2.2223E+0", "samples")
    if spare and not lines.ended():
        lines.take(spare, "its last line")
    if not lines.ended():
        raise RecordError(
            f"{lines.name}, line {lines.at + 1}: {quoted(lines.ahead)} follows the last of the {count} samples that "
            f"line {TEXT_LINES + 3} promises; correct that number, or fetch the file again"
        )
    return samples


def _check_comments(lines: Lines, header: Header) -> None:
    count = header.code(16)
    if count is None or count < 0:
        raise RecordError(
            f"{header.name}, line {TEXT_LINES + 2}: the number of comments is {header.codes[15]:g}; it must be 0 or "
            "more: fetch the file again"
        )
    for at, line in enumerate(lines.take(count, "its comments"), start=lines.at - count + 1):
        if not line.startswith("|"):
            raise RecordError(
                f'{header.name}, line {at}: {quoted(line)} should be one of {count} comments, which start with "|"; '
                "restore that line, or fetch the file again"
            )


def _trace(header: Header, state: str, even: Even, headonly: bool) -> Trace:
    """The trace in m/s², with the facts of the header."""
    vertical, direction = header.code(13) in (0, 180), header.code(14)
    azimuth = None if vertical or direction is None or not 0 <= direction <= 360 else float(direction)
    event, station = _EVENT.match(header.text[3]), _STATION.match(header.text[5])
    record = _text.record_facts(
        state=state,
        units=f"units: cm/s², times 0.01{even.words}",
        event=event[4].strip() if event else header.text[3].strip(),
        date=f"{event[1]}-{int(event[2]):02d}-{int(event[3]):02d}" if event else "",
        station=station[1].strip() if station else header.text[2].strip(),
        component=station[2].strip() if station else "",
        azimuth=azimuth,
        magnitude=next((magnitude for magnitude in map(header.real, (6, 8, 7, 9)) if magnitude is not None), None),
        distance_km=header.real(17),
        low_corner=header.real(33) if state == "processed" else None,
        high_corner=header.real(35) if state == "processed" else None,
        header_pga=None if header.peak is None else header.peak.value * UNIT,
        timed=header.code(6) is not None and header.code(7) is not None,  # otherwise to the minute, as of film
        **({"doubt": "its header marks a problem with the record"} if header.code(18) == 1 else {}),
    )
    smc = {"title": header.text[0].strip(), "latitude": header.real(11), "longitude": header.real(12)}
    named = {"station": header.text[2].strip(" \0*"), "channel": _text.channel_code(even.dt, azimuth, vertical)}
    problem = AttribDict({**smc, "problem": header.code(18) == 1})
    samples = len(even.samples) if headonly else even.samples
    return _text.trace_of(samples, UNIT, even.dt, record, _start(header), **named, smc=problem)


def _peak(lines: Lines, at: int, reals: NDArray[np.float64]) -> StatedPeak | None:
    """The larger of the header's largest and smallest acceleration; None where one of them is not known."""
    extremes = [
        _text.stated_peak(word, "cm/s²", UNIT, place)
        for word, place in (lines.word(at, REAL_COLUMNS, number) for number in EXTREMES)
    ]
    stated_peaks = [peak for peak in extremes if peak is not None and peak.value not in (reals[0], -reals[0])]
    stated_peaks = [peak for peak in stated_peaks if peak.value <= LARGEST]
    return max(stated_peaks) if len(stated_peaks) == len(EXTREMES) else None


def _start(header: Header) -> UTCDateTime | None:
    """Year, day of the year, hour, minute, second and millisecond; None where not known to the minute."""
    year, day, hour, minute = (header.code(number) for number in (2, 3, 4, 5))
    if not year or day is None or hour is None or minute is None:
        return None
    with _text.time_of_header(
        f"{header.name}, line {TEXT_LINES + 1}: the time, year day hour minute, is {year} {day} {hour} {minute}; "
        f"correct these whole numbers, or write {header.codes[0]:g} where they are not known"
    ):
        start = UTCDateTime(year=year, julday=day, hour=hour, minute=minute)
        return start + (header.code(6) or 0) + 1e-3 * (header.code(7) or 0)


FORMAT = Format("SMC", "SMC (.smc)", (".smc",), _is_smc, _read_smc, takes=("dt",))
