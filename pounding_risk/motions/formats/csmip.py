"""CSMIP volumes 1 and 2: the text format of the California Strong Motion Instrumentation Program (CDMG, now CGS).

A file holds one or more channels. Volume 1, uncorrected, has thirteen lines of text, a hundred whole numbers, fifty
real numbers and the acceleration, or pairs of time and acceleration where a film was digitised. Volume 2, corrected,
has twenty-five lines of text, a hundred numbers of each kind, and acceleration, velocity and displacement in turn:

    Corrected accelerogram   89146-L2500-12044.02       Chan  1: 360 Deg     from
    Uncorrected Accelerogram Data             Processed: 02/13/12, CGS  146be002
    ...
     12000 points of accel data equally spaced at  .005 sec, in cm/sec2. (8f10.6)

Lines of samples name their number, step, unit and, in later files, columns. Other agencies write it too, such as
RENADIC of Chile. A trigger time counts as that of the first sample.

Source: A. F. Shakal and M. J. Huang, Standard Tape Format for CSMIP Strong-Motion Data Tapes, report OSMS 85-03, 1985.
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
from pounding_risk.motions.formats._text import NEWLINE, Columns, Even, Lines, quoted
from pounding_risk.units import STANDARD_GRAVITY

KIND = "CSMIP"
UNCORRECTED, CORRECTED, SPECTRA = 1, 2, 3
TITLES = {
    "uncorrected accelerogram data": UNCORRECTED,
    "corrected accelerogram": CORRECTED,
    "response and fourier": SPECTRA,
}
STATES = {UNCORRECTED: "raw", CORRECTED: "processed"}
TEXT_LINES = {UNCORRECTED: 13, CORRECTED: 25}
WHOLE, WHOLE_COLUMNS = 100, Columns(16, 5)
REAL, REAL_COLUMNS = {UNCORRECTED: 50, CORRECTED: 100}, Columns(8, 10)
PEAK = {UNCORRECTED: 7, CORRECTED: 66}  # of the real numbers
SAMPLES = {UNCORRECTED: Columns(8, 9), CORRECTED: Columns(8, 10)}  # where the line before them names none
PAIRS, ROUNDING = Columns(10, 7), 6e-4  # s, half of the last digit of a time and a little
HEADER_NUMBERS = (  # of volume 2: fact, place in the real numbers, its size in SI
    ("header_pgv", 67, 0.01),
    ("header_pgd", 69, 0.01),
    ("low_corner", 71, 1.0),
    ("high_corner", 72, 1.0),
)
_CM = ("cm/s²", 0.01)
UNITS = {  # of acceleration: its words and m/s² in one of it
    "g": ("g", STANDARD_GRAVITY),
    "g/10": ("g/10", 0.1 * STANDARD_GRAVITY),
    **dict.fromkeys(("cm/sec2", "cm/sec/sec", "cm/sec^2", "cm/s2", "cm/s/s", "cm/s^2", "gal"), _CM),
}
ZONES = {"UTC": 0, "GMT": 0, "PST": 8, "PDT": 7}  # hours behind UTC
CENTURY = 30  # two digits of a year from here on are of the twentieth century, as are the first records of 1933

_SERIES = re.compile(
    r"\s*(\d{1,9})\s+points of (\w+) data equally spaced at\s+(\d*\.\d+)\s*sec[.,\s]*"
    r"(?:\(units:\s*(?P<listed>[^)\s]+)\s*\)|in\s+(?P<named>[^\s(]+))",
    re.I,
)
_POINTS = re.compile(r"\s*(\d{1,9})\s+accelerogram points at\s+(\d+(?:\.\d*)?)\s*pts/sec in units of\s+(\S+)", re.I)
_PAIRED = re.compile(r"no\. of points\s*=\s*(\d{1,9})", re.I)
_PAIR_UNIT = re.compile(r"units of uncor\w*\s+\w+\s+are\s+sec\s+and\s+(\S+)", re.I)
_LENGTH = re.compile(r"record\s+length\s*=\s*(\d+(?:\.\d*)?)\s*sec", re.I)
_CHANNEL = re.compile(r"\s*chan\s*(\d+)\s*:\s*(.*?)\s*(?:\(|$)", re.I)
_MAGNITUDE = re.compile(r"\bM([WLS])\s*=\s*(\d\.\d+)", re.I)
_START = re.compile(
    r"(?:start|trigger) time:\s*(\d{1,2})[/-](\d{1,2})[/-](\d{4}|\d\d),?\s+"
    r"(\d{1,2}):\s*(\d{1,2}):\s*(\d*\.?\d*)\s*(UTC|GMT|PST|PDT)",
    re.I,
)
_NO_EVENT = re.compile(r"\s*(?:rcrd|record) of (?:mon|tue|wed|thu|fri|sat|sun)\w* ", re.I)
_NETWORK = re.compile(r"\S+?\.([A-Z]{2})\.(\w+)\.")


class Channel(NamedTuple):
    """One channel: its volume, its headers, its acceleration in the unit of the file."""

    place: str  # of its first line
    volume: int
    text: list[str]  # of volume 1; that of volume 2 starts with one more line
    reals: NDArray[np.float64]
    even: Even
    unit: str
    peak: tuple[str, str]  # the header's number for the largest sample, as text, with file and line


@_text.recogniser(1024)
def _is_csmip(start: str) -> bool:
    """True for a file of volume 1, 2 or 3: the title and, for the later volumes, those before."""
    head = NEWLINE.split(start)
    volume = _volume(head[0])
    titles = [_volume(line) for line in head[: volume or 0]]
    text = head[(volume or 0) - 1 :]
    return bool(titles) and titles[-1] == UNCORRECTED and (volume == SPECTRA or bool(_CHANNEL.match(text[6])))


def _volume(line: str) -> int | None:
    return next((volume for start, volume in TITLES.items() if line.strip().lower().startswith(start)), None)


def _read_csmip(
    file: Any, headonly: bool = False, *, name: str = "", dt: float | None = None, **_kwargs: Any
) -> Stream:
    """The traces of acceleration, in m/s², of a file of volume 1 or 2.

    Volume 1 is raw, volume 2 processed. Film that was digitised at uneven times is read at every ``dt`` [s] off the
    straight lines between them. ``stats.csmip`` has volume, channel and agency's line.

    Raises RecordError, naming file and line, for volume 3, headers cut short, an unknown unit, a time step out of
    range or against the stated length, uneven times without ``dt``, that do not rise or leave gaps, another number of
    samples than promised, another largest one than stated, and any number that is not finite.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = Lines(name, text)
    channels: list[Channel] = []
    while not lines.ended() or not channels:
        channels.append(_channel(lines, dt))
    traces = [_trace(channel, headonly) for channel in channels]
    _text.note_missing_channels(traces, channels[0].text[4], len(channels))
    return Stream(_text.numbered(traces, [trace.stats.csmip.channel for trace in traces]))


def _channel(lines: Lines, dt: float | None) -> Channel:
    volume = _volume(lines.ahead)
    where = f"{lines.name}, line {lines.at + 1}"
    if volume not in STATES:
        allowed = '"Uncorrected Accelerogram Data" (volume 1) or "Corrected accelerogram" (volume 2)'
        raise RecordError(
            f"{where}: {quoted(lines.ahead)} is not the title of a channel of acceleration, {allowed}; take such a "
            "file of this record"
        )
    text = lines.take(TEXT_LINES[volume], "the lines of text of its header")[volume - 1 :]
    lines.table(WHOLE, WHOLE_COLUMNS, "-999", "whole numbers of the header")
    at = lines.at
    reals = lines.table(REAL[volume], REAL_COLUMNS, "-999.00000", "real numbers of the header")
    peak = lines.word(at, REAL_COLUMNS, PEAK[volume])
    if _SERIES.match(lines.ahead) or _POINTS.match(lines.ahead):
        even, unit = _series(lines, volume, text, reals)
    else:
        even, unit = _pairs(lines, volume, text, dt)
    while volume == CORRECTED and _SERIES.match(lines.ahead):  # velocity and displacement
        _series(lines, volume, text, reals)
    lines.end_channel("/& and End of data")
    return Channel(where, volume, text, reals, even, unit, peak)


def _series(lines: Lines, volume: int, text: list[str], reals: NDArray[np.float64]) -> tuple[Even, str]:
    """Samples at even times and their unit, as the line before them promises."""
    (line,) = lines.take(1, "the line that says how many samples follow")
    series, points = _SERIES.match(line), _POINTS.match(line)
    if series:
        count, unit = int(series[1]), series["listed"] or series["named"]
        dt = _rounded(lines.place, series[3], float(reals[60]) if volume == CORRECTED else None)
    elif points:
        count, unit, rate = int(points[1]), points[3], float(points[2])
        dt = _text.check_step(lines.place, 1.0 / rate if rate else None, f"1/({points[2]}/s)", "the time step")
    _text.check_promised(lines.place, count)
    length = _LENGTH.search(text[10])
    # To 1 %, enough to notice a wrong digit.
    _text.check_length(lines.place, count, dt, float(length[1]) if length else None, 0.01 * count * dt, "the text")
    samples = lines.table(count, _text.columns_of(line) or SAMPLES[volume], "-.123456", "samples")
    return Even(samples, dt, "", samples), unit


def _pairs(lines: Lines, volume: int, text: list[str], dt: float | None) -> tuple[Even, str]:
    """Acceleration of pairs with times, whose number and unit the text has: film of volume 1."""
    count, unit = _PAIRED.search(text[10]), _PAIR_UNIT.search(text[11])
    if volume != UNCORRECTED or not count or not unit:
        raise RecordError(
            f'{lines.name}, line {lines.at + 1}: {quoted(lines.ahead)} does not say what follows, as "12000 points of '
            'accel data equally spaced at .005 sec, in cm/sec2" does; restore that line, or fetch the file again'
        )
    where = f"{lines.name}, line {lines.at + 1}"
    _text.check_promised(where, int(count[1]))
    even = _text.even_samples(where, lines.table(2 * int(count[1]), PAIRS, ".123", "numbers in pairs"), dt, ROUNDING)
    return even, unit[1]


def _rounded(where: str, shown: str, finer: float | None) -> float:
    """The time step [s] of a line, or the one of the header where that has more digits of the same step."""
    half = 0.5 * 10.0 ** -len(shown.partition(".")[2])
    dt = float(shown)
    if finer is not None and finer > 0.0:
        if abs(finer - dt) > 1.001 * half:
            raise RecordError(
                f"{where}: says a step of {shown} s, the 61st real number of the header {finer:g} s; correct the wrong "
                "one, or fetch the file again"
            )
        dt = finer
    return _text.check_step(where, dt, f"{dt:g}", "the time step")


def _trace(channel: Channel, headonly: bool) -> Trace:
    """A trace in m/s², with the facts of the headers."""
    words, factor = _unit(channel)
    number, component, azimuth = _orientation(channel.text[6])
    # The header's peak is in cm/s² in volume 2, in volume 1 in g or in the unit of its samples.
    units = (_CM,) if channel.volume == CORRECTED else dict.fromkeys((UNITS["g"], (words, factor)))
    readings = [_text.stated_peak(channel.peak[0], *unit, channel.peak[1]) for unit in units]
    peak = readings[0] if headonly else _text.check_peak(channel.even.digitised * factor, *readings)
    start = _start(channel)
    magnitudes = {kind.upper(): float(magnitude) for kind, magnitude in _MAGNITUDE.findall(channel.text[8])}
    of_volume_2 = {}
    if channel.volume == CORRECTED:  # peaks of velocity and displacement [m/s, m], and corners [Hz]
        for key, at, scale in HEADER_NUMBERS:
            of_volume_2[key] = abs(float(channel.reals[at])) * scale or None
    record = _text.record_facts(
        state=STATES[channel.volume],
        units=f"units: {words}, times {factor:.7g}{' m/s²' if 'g' in words else ''}{channel.even.words}",
        date="" if start is None else str(start.date),
        timed=start is not None,
        # A line that has the record's own time alone, which differs from station to station, names no earthquake.
        event="" if _NO_EVENT.match(channel.text[1]) else re.split(r"\s{2,}", channel.text[1].strip())[0],
        magnitude=next((magnitudes[kind] for kind in "WLS" if magnitudes.get(kind)), None),  # moment, local, surface
        station=re.split(r"\s{2,}", channel.text[5].strip())[0],
        component=component,
        azimuth=azimuth,
        header_pga=None if peak is None else peak.value * peak.size,
        **of_volume_2,
    )
    # Of the record's id in later files, otherwise the station's number and, of CSMIP, CE.
    named = _NETWORK.match(channel.text[3])
    network = "CE" if re.search(r"\b(CDMG|CGS)\b", channel.text[0]) else ""
    network, station = (named[1], named[2]) if named else (network, channel.text[4][11:19].strip())
    vertical = component.lower() in ("up", "down", "v", "vert", "vertical", "z")
    csmip = AttribDict(volume=channel.volume, channel=number, processed=channel.text[0].strip())
    code = _text.channel_code(channel.even.dt, azimuth, vertical)
    samples = len(channel.even.samples) if headonly else channel.even.samples
    return _text.trace_of(
        samples, factor, channel.even.dt, record, start, network=network, station=station, channel=code, csmip=csmip
    )


def _unit(channel: Channel) -> tuple[str, float]:
    unit = channel.unit.rstrip(".,").lower()
    if unit not in UNITS:
        raise RecordError(
            f"{channel.place}: the channel that starts here is in {quoted(unit)}; acceleration is read in "
            f"{', '.join(UNITS)}: convert the samples, or take the file of acceleration of this record"
        )
    return UNITS[unit]


def _orientation(line: str) -> tuple[str, str, float | None]:
    """The channel's number, its direction in the file's words, and its azimuth [degrees] where it has one."""
    match = _CHANNEL.match(line)
    number, words = (match[1], match[2]) if match else ("", line.strip())
    degrees = re.match(r"(\d{1,3})\s*deg", words, re.I)
    if degrees and int(degrees[1]) <= 360:
        return number, degrees[1], float(degrees[1])
    return number, words.capitalize() if words.lower() in ("up", "down") else words, None


def _start(channel: Channel) -> UTCDateTime | None:
    """The time of the first sample in UTC; None where the text has none with a zone."""
    match = _START.search(channel.text[3])
    if not match:
        return None
    month, day, year, hour, minute = (int(match[group]) for group in range(1, 6))
    if year < 100:
        year += 1900 if year >= CENTURY else 2000
    with _text.time_of_header(
        f"{channel.place}: the channel that starts here has no valid time in {quoted(match[0])}; correct that line, or "
        "remove the time where it is not known"
    ):
        local = UTCDateTime(year, month, day, hour, minute) + float(match[6] or 0.0)
        return local + 3600.0 * ZONES[match[7].upper()]


FORMAT = Format(
    "CSMIP", "CSMIP volumes 1 and 2 (.v1, .v2, .raw)", (".v1", ".v2", ".raw"), _is_csmip, _read_csmip, takes=("dt",)
)
