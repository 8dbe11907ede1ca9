"""COSMOS strong-motion format, version 1.20: what CESMD, CGS and USGS give out as .v0c, .v1c and .v2c.

A file holds one or more channels, each on its own, with thirteen lines of text, a hundred whole numbers, a hundred
real numbers, comments, and samples in the columns that a line before them names:

    Corrected acceleration    (Format v01.20 with 13 text lines) Src: ...
    ...
     100 Integer-header values follow on  10 lines, Format= (10I8)
     100 Real-header values follow on  17 lines, Format= (6F13.6)
      2 Comment line(s) follow, each starting with a "|":
       7000  acceleration pts, approx   70 secs, units=cm/sec2(04),Format=(8F10.5)

The numbers mean what their place says: the stage of processing, the quantity and its unit, the time step. Where the
text says otherwise, they are believed.

Source: COSMOS Strong Motion Programs Board, COSMOS Strong Motion Data Format, Ver. 1.20, 15 August 2001.
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
from pounding_risk.motions.formats._text import NEWLINE, Columns, Lines, quoted
from pounding_risk.units import STANDARD_GRAVITY

KIND = "COSMOS"
VERSION = "01.20"
TEXT_LINES = 13  # at least
HEADER = 100  # whole numbers, and as many real ones
PEAK = 64  # of the real numbers
UNKNOWN = -999.0  # where the text does not say another number for what is not known

ACCELERATION = 1
QUANTITIES = {
    2: "velocity",
    3: "displacement",
    4: "relative displacement",
    10: "angular acceleration",
    11: "angular velocity",
    12: "angular displacement",
    20: "absolute pressure",
    21: "relative pressure",
    30: "volumetric strain",
    31: "linear strain",
}
RAW_COUNTS, UNCORRECTED, CORRECTED = 0, 1, 2
TITLES = {"raw acc": RAW_COUNTS, "uncorrected acc": UNCORRECTED, "corrected acc": CORRECTED}
STATES = {RAW_COUNTS: "raw", UNCORRECTED: "raw", CORRECTED: "processed"}
COUNTS = 50
UNITS = {  # of acceleration: its words and m/s² in one of it
    2: ("g", STANDARD_GRAVITY),
    4: ("cm/s²", 0.01),
    7: ("in/s²", 0.0254),
    10: ("gal", 0.01),
    11: ("mg", 1e-3 * STANDARD_GRAVITY),
    12: ("µg", 1e-6 * STANDARD_GRAVITY),
}
VERTICAL = {400: "Up", 401: "Down", 402: "Vertical"}

_TITLE = re.compile(r"(.*?)\(Format v(\d\d\.\d\d) with\s+(\d{1,3}) text lines?\)", re.I)
_HEADER = re.compile(r"\s*(\d{1,4})\s+(integer|real)-header values follow on\s+\d+\s+lines?\s*,\s*format\s*=", re.I)
_COMMENTS = re.compile(r"\s*(\d{1,4})\s+comment line\(s\) follow", re.I)
_SAMPLES = re.compile(
    r"\s*(\d{1,9})\s+(\D*?)\s*pts?\b.*?units\s*=\s*([^,(]*?)\s*(?:\(\s*(\d+)\s*\)\s*)?,?\s*format\s*=", re.I
)
_UNKNOWN = re.compile(r":\s*(-?\d+)\s*,?\s*(-?\d+(?:\.\d*)?)")
_STATION = re.compile(r"code:\s*(..)-\s*(\S+)", re.I)
_ORIENTATION = re.compile(r"sta\s+cha\w*\s*:?\s*(\S*?):\s*([^(]*)", re.I)
_SCNL = re.compile(r"<SCNL>\s*(\w+)\.(\w+)\.(\w+)\.([\w-]+)", re.I)


class Channel(NamedTuple):
    """One channel: its headers, its samples in the unit of the file, and its place for messages."""

    place: str  # of the line that starts the whole numbers
    stage: int
    text: list[str]
    codes: NDArray[np.float64]
    reals: NDArray[np.float64]
    comments: list[str]
    words: str  # of the quantity, before "pts"
    npts: int
    samples: NDArray[np.float64]  # none with headonly
    peak: tuple[str, str]  # the header's number for the largest acceleration, as text, with file and line

    def code(self, number: int) -> float | None:
        """A whole number of the header, counted from 1; None where it is not known."""
        return _known(self.text, 1, self.codes[number - 1])

    def real(self, number: int) -> float | None:
        """A real number of the header, counted from 1; None where it is not known."""
        return _known(self.text, 2, self.reals[number - 1])

    def scnl(self) -> re.Match[str] | None:
        """Station, channel, network and location as a comment names them."""
        return next((match for match in map(_SCNL.search, self.comments) if match), None)


@_text.recogniser(512)
def _is_cosmos(start: str) -> bool:
    """True for a file whose first line names a version of the COSMOS format."""
    return bool(_TITLE.match(NEWLINE.split(start)[0]))


def _read_cosmos(file: Any, headonly: bool = False, *, name: str = "", **_kwargs: Any) -> Stream:
    """The traces of acceleration, in m/s², of a COSMOS file.

    Stages 0 (counts) and 1 (uncorrected) are raw, 2 (corrected) is processed. Counts become m/s² by the
    least significant bit, the gain and the sensitivity of the header, where it has all of them and they agree with
    the full scale of the sensor. ``stats.cosmos`` has stage, unit and coordinates. Velocity and displacement beside
    the acceleration are left out.

    Raises RecordError, naming file and line, for another version, headers of other lengths, a file without
    acceleration, response spectra, a unit that is none of acceleration, a time step out of range or against the
    stated length, another number of samples than promised, another largest one than stated, and any number that is not
    finite.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = Lines(name, text)
    channels: list[Channel] = []
    while not lines.ended() or not channels:
        channels.extend(_channels(lines, headonly))
    acceleration_channels = [
        channel for channel in channels if channel.code(2) in (ACCELERATION, None) and "acc" in channel.words.lower()
    ]
    if not acceleration_channels:
        code = float(channels[0].codes[1])
        quantity = QUANTITIES.get(int(code), channels[0].words or f"quantity {code:g}")
        raise RecordError(
            f"{channels[0].place}: holds {quantity}, no acceleration; take the file of acceleration of this record"
        )
    numbers = [match[1] if (match := _ORIENTATION.search(channel.text[8])) else "" for channel in acceleration_channels]
    traces = [_trace(channel) for channel in acceleration_channels]
    _text.note_missing_channels(traces, channels[0].text[6], len(channels))
    return Stream(_text.numbered(traces, numbers))


def _channels(lines: Lines, headonly: bool) -> list[Channel]:
    """The series under the next headers: one as a rule, or acceleration, velocity and displacement in turn."""
    (title,) = lines.take(1, 'a first line with "(Format v01.20 with 13 text lines)"')
    match = _TITLE.match(title)
    if not match:
        raise RecordError(
            f'{lines.place}: {quoted(title)} is no first line of a COSMOS channel, which says "(Format v01.20 with 13 '
            'text lines)"; check that this is one, or fetch the file again'
        )
    if match[2] != VERSION or int(match[3]) < TEXT_LINES:
        raise RecordError(
            f"{lines.place}: says version {match[2]} with {match[3]} text lines; version {VERSION} with at least "
            f"{TEXT_LINES} is read: fetch the record in that version"
        )
    text = [title, *lines.take(int(match[3]) - 1, "the lines of text of its header")]
    where = f"{lines.name}, line {lines.at + 1}"
    codes, _, _ = _header(lines, "integer", "-999")
    stage = _stage(where, text, codes)
    reals, columns, at = _header(lines, "real", "-999.000000")
    peak = lines.word(at, columns, PEAK)
    (line,) = lines.take(1, "the line that says how many comments follow")
    stated = _COMMENTS.match(line)
    if not stated:
        raise RecordError(
            f'{lines.place}: {quoted(line)} should be "... Comment line(s) follow"; restore that line, or fetch the '
            "file again"
        )
    comments = lines.take(int(stated[1]), "its comments")
    channels: list[Channel] = []
    while not channels or _SAMPLES.match(lines.ahead):
        (line,) = lines.take(1, "the line that says how many samples follow")
        words, count, columns = _promise(lines, line, codes)
        if headonly:
            lines.take(-(-count // columns.each), "its samples")
            samples = np.empty(0)
        else:
            samples = lines.table(count, columns, "-.12345", "samples")
        channels.append(Channel(where, stage, text, codes, reals, comments, words, count, samples, peak))
    lines.end_channel("End-of-data")
    return channels


def _header(lines: Lines, kind: str, example: str) -> tuple[NDArray[np.float64], Columns, int]:
    """The whole or real numbers of a header, their columns, and how many lines are before them.

    More than a hundred are allowed, and not used.
    """
    (line,) = lines.take(1, f"the {kind} header")
    match, columns = _HEADER.match(line), _text.columns_of(line)
    if not match or match[2].lower() != kind or columns is None:
        sample = f"100 {kind.capitalize()}-header values follow on ... lines, Format= (...)"
        raise RecordError(
            f'{lines.place}: {quoted(line)} should be "{sample}"; restore that line, or fetch the file again'
        )
    if int(match[1]) < HEADER:
        raise RecordError(
            f"{lines.place}: promises {match[1]} values of the {kind} header; the format has {HEADER}: fetch the file "
            "again"
        )
    at = lines.at
    return lines.table(int(match[1]), columns, example, f"values of the {kind} header"), columns, at


def _known(text: list[str], group: int, stated: float) -> float | None:
    """A number of a header; None for the one that stands for what is not known, as line 13 of the text says."""
    match = _UNKNOWN.search(text[12])
    return None if stated == (float(match[group]) if match else UNKNOWN) else float(stated)


def _stage(where: str, text: list[str], codes: NDArray[np.float64]) -> int:
    """The stage of processing: the first whole number or, where that is not known, the first line in words."""
    stage = _known(text, 1, codes[0])
    if stage is None:
        stage = next((number for start, number in TITLES.items() if text[0].strip().lower().startswith(start)), None)
    if stage not in STATES:
        raise RecordError(
            f"{where}: the first whole number, the stage of processing, is {codes[0]:g}; 0 (counts), 1 (uncorrected) "
            "and 2 (corrected acceleration) are read: take such a file of this record"
        )
    return int(stage)


def _promise(lines: Lines, line: str, codes: NDArray[np.float64]) -> tuple[str, int, Columns]:
    """The quantity in words, the number of samples and their columns; the unit must be that of the header."""
    match, columns = _SAMPLES.match(line), _text.columns_of(line)
    if not match or columns is None:
        sample = "7000 acceleration pts, approx 70 secs, units=cm/sec2(04), Format=(8F10.5)"
        raise RecordError(
            f'{lines.place}: {quoted(line)} does not say what follows, as "{sample}" does; restore that line, or '
            "fetch the file again"
        )
    count = int(match[1])
    _text.check_promised(lines.place, count)
    if "acc" in match[2].lower() and match[4] and float(match[4]) != codes[2]:
        raise RecordError(
            f"{lines.place}: says unit {int(match[4])}, the integer header {codes[2]:g}; correct the wrong one, or "
            "fetch the file again"
        )
    return match[2].strip(), count, columns


def _trace(channel: Channel) -> Trace:
    """A trace in m/s², with the facts of the headers."""
    stage = channel.stage
    words, factor = _counts(channel) if stage == RAW_COUNTS else _unit(channel)
    step, length = channel.real(62), channel.real(63)
    dt = _text.check_step(
        channel.place, None if step is None else 1e-3 * step, f"{channel.reals[61]:g} ms", "the 62nd real number"
    )
    # To 1 %, enough to notice a wrong digit.
    _text.check_length(channel.place, channel.npts, dt, length, 0.01 * channel.npts * dt, "the 63rd real number")
    start = _start(channel)
    peak = channel.real(PEAK)
    magnitudes = (channel.real(number) for number in (13, 15, 14, 16))  # moment, local, surface, other
    if channel.samples.size and peak is not None:
        word, line_words = channel.peak
        _text.check_peak(channel.samples, _text.stated_peak(word, words.partition(",")[0], 1.0, line_words))
    record = _text.record_facts(
        state=STATES[stage],
        units=f"units: {words}",
        date="" if start is None else str(start.date),
        timed=start is not None and channel.real(30) is not None,  # otherwise to the minute
        low_corner=channel.real(54) if stage == CORRECTED else None,
        high_corner=channel.real(57) if stage == CORRECTED else None,
        # That of counts has their offset in it.
        header_pga=None if peak is None or stage == RAW_COUNTS else abs(peak) * factor,
        event=" ".join(channel.text[1].split()),
        magnitude=next((magnitude for magnitude in magnitudes if magnitude is not None), None),
        distance_km=channel.real(17),
        **_place(channel),
    )
    cosmos = AttribDict(stage=stage, unit=int(channel.codes[2]), latitude=channel.real(1), longitude=channel.real(2))
    samples = channel.samples if channel.samples.size else channel.npts
    return _text.trace_of(samples, factor, dt, record, start, cosmos=cosmos, **_codes(channel, dt, record.azimuth))


def _unit(channel: Channel) -> tuple[str, float]:
    code = channel.code(3)
    if code not in UNITS:
        listed = ", ".join(f"{code} ({words})" for code, (words, _) in UNITS.items())
        raise RecordError(
            f"{channel.place}: the third whole number, the unit, is {channel.codes[2]:g}; acceleration is read in "
            f"{listed}: convert the samples, or take another file of this record"
        )
    words, factor = UNITS[int(code)]
    return f"{words}, times {factor:.7g}{'' if words != 'g' else ' m/s²'}", factor


def _counts(channel: Channel) -> tuple[str, float]:
    """The size of one count: (least significant bit [V]) / gain / (sensitivity [V/g]), times 9.80665 m/s²."""
    bit, gain, sensitivity, volts, full = (channel.real(number) or 0.0 for number in (22, 47, 42, 43, 44))
    agreed = abs(volts - sensitivity * full) <= 0.01 * volts
    if channel.code(3) != COUNTS or min(bit, gain, sensitivity, volts, full) <= 0.0 or not agreed:
        raise RecordError(
            f"{channel.place}: holds counts, and its headers do not say for certain what a count is (unit "
            f"{channel.codes[2]:g}, bit {bit:g} µV, gain {gain:g}, sensitivity {sensitivity:g} V/g, full scale "
            f"{volts:g} V at {full:g} g); take the V1 or V2 file of this record, which holds acceleration"
        )
    words = f"counts, times {bit:g} µV, over gain {gain:g} and {sensitivity:g} V/g, times 9.80665 m/s²"
    return words, 1e-6 * bit / gain / sensitivity * STANDARD_GRAVITY


def _start(channel: Channel) -> UTCDateTime | None:
    """The time of the first sample; None where it is not known to the minute."""
    codes = [channel.code(number) for number in (40, 42, 43, 44, 45)]
    if None in codes:
        return None
    known = [code for code in codes if code is not None]
    with _text.time_of_header(
        f"{channel.place}: the start, year month day hour minute, is {' '.join(f'{code:g}' for code in known)}; "
        "correct these whole numbers (40, 42 to 45), or write -999 where they are not known"
    ):
        return UTCDateTime(*(int(code) for code in known)) + (channel.real(30) or 0.0)


def _place(channel: Channel) -> dict[str, Any]:
    """Station and orientation: degrees from north as the header's number or text has them, or its words."""
    station = _STATION.search(channel.text[4])
    name = channel.text[4][40:].strip() or (station[2] if station else "")
    match, code = _ORIENTATION.search(channel.text[8]), channel.code(54)
    words = match[2].strip() if match else ""
    degrees = re.match(r"(\d{1,3})\s*deg", words, re.I)
    if code is not None and 1 <= code <= 360:
        return {"station": name, "component": f"{code:g}", "azimuth": float(code)}
    if code in VERTICAL:
        return {"station": name, "component": VERTICAL[int(code)], "azimuth": None}
    if degrees and 0 <= int(degrees[1]) <= 360:
        return {"station": name, "component": degrees[1], "azimuth": float(degrees[1])}
    scnl = channel.scnl()
    return {"station": name, "component": scnl[2] if scnl else words, "azimuth": None}


def _codes(channel: Channel, dt: float, azimuth: float | None) -> dict[str, str]:
    """Network, station, location and channel, as a comment names them or as the text and the orientation do."""
    scnl = channel.scnl()
    if scnl:
        return {"station": scnl[1], "channel": scnl[2], "network": scnl[3], "location": scnl[4].strip("-")}
    match = _STATION.search(channel.text[4])
    network, station = (match[1].strip(" -"), match[2]) if match else ("", "")
    vertical = channel.code(54) in VERTICAL
    return {"network": network, "station": station, "channel": _text.channel_code(dt, azimuth, vertical)}


FORMAT = Format("COSMOS", "COSMOS (.v1c, .v2c)", (".v0c", ".v1c", ".v2c"), _is_cosmos, _read_cosmos)
