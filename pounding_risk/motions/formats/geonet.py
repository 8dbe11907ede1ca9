"""GeoNet V1A and V2A: uncorrected and corrected accelerograms of New Zealand, three components a file, mm/s².

Each component has 16 lines of text, four of whole numbers, six of real ones, and then its samples, in columns of eight
characters, ten on a line: acceleration [mm/s²] and, in a V2A file, velocity [mm/s] and displacement [mm]. They are
checked too, but only the acceleration is kept. GNS Science describes the headings (Cousins, 2008, "GNS accelerogram
data files, standard format"; the GeoNet page "Strong Motion File Formats").

A corrected record begins before the recorder's buffer does, by the quiet that was put before it; peaks of the heading
are timed from the buffer's start. The filter is known by its two transitions: the corners are where they meet the
pass band, 0.25 and 24.5 Hz of "transition bands are .10-.25 Hz and 24.50-25.50 Hz".
"""

from __future__ import annotations

import re
from math import ceil
from typing import Any, NamedTuple

from numpy.typing import NDArray
from obspy import Stream, Trace, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format, _text
from pounding_risk.motions.formats._text import NEWLINE, NUMBER, quoted

KIND = "GeoNet"
NETWORK = "NZ"  # of every station that GNS Science runs
COMPONENTS = 3
TEXT_LINES, WHOLE_LINES, REAL_LINES = 16, 4, 6
HEADING_LINES = TEXT_LINES + WHOLE_LINES + REAL_LINES
COLUMNS, WIDTH = 10, 8
MILLIMETRE = 0.001  # m
UNIT = "mm/s/s"

# Places in the whole and the real numbers of the heading, from 0.
ORIGIN, START_YEAR, START_DAY, START_MINUTE = slice(0, 3), slice(8, 10), slice(18, 20), slice(38, 40)
BEARING, DISTANCE, PREPENDED, COUNTS = 27, 29, 31, slice(33, 36)
LATITUDE, LONGITUDE, MAGNITUDE, STEP, LOW_EDGES, HIGH_EDGES = 10, 11, 14, 25, (50, 52), (55, 57)

_TITLE = re.compile(r"\s*(?P<kind>Uncorrected|Corrected) accelerogram\s+(?P<id>\S+)", re.IGNORECASE)
_LOCATION = re.compile(r"_(\w{2})$")  # the end of a title such as 20161113_110256_THZ_20
_SITE = re.compile(r"\s*Site\s+(\S+)", re.IGNORECASE)
_POINTS = re.compile(rf"\s*Number of points\s+(\d{{1,8}})\s+Duration\s+({NUMBER})\s*s", re.IGNORECASE)
_READINGS = re.compile(r"in units of\s+(\S+)\s+(\S+)", re.IGNORECASE)
_COMPONENT = re.compile(r"\s*Component\s+(\S+)", re.IGNORECASE)
_COMPASS = re.compile(r"([NS])(\d{1,3})([EW])", re.IGNORECASE)
_PEAKS = tuple(
    re.compile(rf"\s*{quantity}:\s+peak\s+({NUMBER})\s+(\S+)\s+at\b", re.IGNORECASE)
    for quantity in ("Acceleration", "Velocity", "Displacement")
)


class Heading(NamedTuple):
    """The lines before the samples of one component, with the values read from them."""

    text: list[str]
    whole: list[int]
    real: list[float]
    line: int  # the index of its first line in the file
    label: str  # of the component, such as N28W
    dt: float  # s
    counts: list[int]  # samples of acceleration, velocity and displacement


@_text.recogniser(512)
def _is_geonet(start: str) -> bool:
    """True for a GeoNet V1A or V2A file."""
    first, second = NEWLINE.split(start)[:2]
    return bool(_TITLE.match(first) and _SITE.match(second))


def _read_geonet(file: Any, headonly: bool = False, *, name: str = "", **_kwargs: Any) -> Stream:
    """Three traces in m/s² from a GeoNet file.

    A V1A file is raw, a V2A file processed. ``stats.channel`` ends with N, E and Z where the components are so within
    5°, otherwise with 1, 2 and Z; ``stats.record.component`` is the file's own name, such as N28W. ``stats.geonet`` has
    the title, the site's name, its latitude and longitude, and the two transitions of the filter [Hz].

    Raises RecordError, naming file and line, for a heading that is not whole or contradicts itself, a unit other than
    mm/s/s, a time step out of range, samples that are no finite numbers or not as many as the heading says, another
    largest one than it says, fewer than three components, and anything after them.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = NEWLINE.split(text.rstrip())
    components: list[tuple[Heading, NDArray]] = []
    at = 0
    while len(components) < COMPONENTS:
        heading = _heading(name, lines, at)
        at += HEADING_LINES
        blocks = []  # only the first is kept; the others are checked
        for count, quantity in zip(heading.counts, ("acceleration", "velocity", "displacement"), strict=True):
            blocks.append(_block(name, lines, at, count, quantity))
            at += ceil(count / COLUMNS)
        components.append((heading, blocks[0]))
    if at < len(lines):
        raise RecordError(
            f"{name}, line {at + 1}: {quoted(lines[at])} follows the third component, with which a GeoNet file ends; "
            "remove it, or fetch the file again"
        )
    azimuths = _azimuths(name, [heading for heading, _ in components])
    traces = []
    for (heading, acceleration), azimuth, letter in zip(components, azimuths, _letters(azimuths), strict=True):
        peak = _PEAKS[0].match(heading.text[13])
        if peak:  # otherwise it was not evaluated
            _text.check_peak(acceleration, _text.stated_peak(peak[1], UNIT, 1.0, f"{name}, line {heading.line + 14}"))
        traces.append(_trace(name, heading, azimuth, letter, len(acceleration) if headonly else acceleration))
    return Stream(traces)


def _heading(name: str, lines: list[str], at: int) -> Heading:
    """The heading of the component that begins at line ``at``, checked."""
    heading_lines = lines[at : at + HEADING_LINES]
    if len(heading_lines) < HEADING_LINES:
        raise RecordError(
            f"{name}: ends with line {len(lines)}, before the end of the heading due from line {at + 1} on; a GeoNet "
            f"file has {COMPONENTS} components: the file is cut short, fetch it again"
        )
    places = [f"{name}, line {at + row + 1}" for row in range(HEADING_LINES)]
    text = heading_lines[:TEXT_LINES]
    for row, pattern, example in (
        (0, _TITLE, "Uncorrected accelerogram 20161113_110256_THZ_20 GNS Science"),
        (1, _SITE, "Site THZ"),
        (9, _POINTS, "Number of points  59200    Duration 296.00 s"),
        (12, _COMPONENT, "Component N28W"),
    ):
        if not pattern.match(text[row]):
            raise RecordError(
                f'{places[row]}: found {quoted(text[row])} where a GeoNet file has a line such as "{example}"; '
                "restore that line, or fetch the file again"
            )
    _check_unit(places, text)
    rows = list(zip(places, heading_lines, strict=True))
    integers = [number for row in rows[TEXT_LINES:-REAL_LINES] for number in _whole_row(*row)]
    real = [number for row in rows[-REAL_LINES:] for number in _table_row(*row)]
    dt = _text.check_step(places[22], real[STEP], f"{real[STEP]:g}", "the time step (the sixth number)")
    counts, prepended = integers[COUNTS], integers[PREPENDED]
    if counts[0] < 2:
        raise RecordError(f"{places[19]}: the number of acceleration samples is {counts[0]}; a record needs at least 2")
    if min(counts[1], counts[2], prepended) < 0 or prepended > counts[0]:
        raise RecordError(
            f"{places[19]}: {counts[1]} samples of velocity, {counts[2]} of displacement and {prepended} prepended "
            f"ones do not go with {counts[0]} of acceleration; restore that line, or fetch the file again"
        )
    points = _POINTS.match(text[9])
    assert points
    if int(points[1]) != counts[0]:
        raise RecordError(
            f"{places[9]}: the text promises {int(points[1])} points, the numbers of line {at + 20} {counts[0]}; fetch "
            "the file again"
        )
    _text.check_length(places[9], counts[0], dt, _text.number(points[2]) or 0.0, 0.01, "the text")
    label = _COMPONENT.match(text[12])[1]  # type: ignore[index]
    return Heading(text, integers, real, at, label, dt, counts)


def _table_row(where: str, line: str) -> list[float]:
    """The ten numbers of a line of the heading, in columns of eight characters."""
    words = [line[column * WIDTH : (column + 1) * WIDTH].strip() for column in range(COLUMNS)]
    numbers = [number for number in map(_text.number, words) if number is not None]
    if len(numbers) < COLUMNS or line[COLUMNS * WIDTH :].strip():
        raise RecordError(
            f"{where}: {quoted(line)} is not a line of {COLUMNS} numbers in columns of {WIDTH} characters; restore "
            "that line of the heading, or fetch the file again"
        )
    return numbers


def _whole_row(where: str, line: str) -> list[int]:
    numbers = _table_row(where, line)
    if broken := [number for number in numbers if number != int(number)]:
        raise RecordError(
            f"{where}: has {broken[0]:g}, where all numbers are whole; restore that line of the heading, or fetch the "
            "file again"
        )
    return [int(number) for number in numbers]


def _check_unit(places: list[str], text: list[str]) -> None:
    """Raise RecordError where the heading says no unit, or another than mm/s/s."""
    readings, peak = _READINGS.search(text[10]), _PEAKS[0].match(text[13])
    statements = [(10, _text.number(readings[1]) == 1.0, readings[2])] if readings else []
    statements += [(13, True, peak[2])] if peak else []
    if not statements:
        raise RecordError(
            f"{places[13]}: found {quoted(text[13])}, and no unit of the samples in the heading; a GeoNet file says "
            f'"Acceleration: Peak 399.7 {UNIT} at 115.37 s": restore that line, or fetch the file again'
        )
    for row, is_one, unit in statements:
        if not is_one or unit.lower() != UNIT:
            raise RecordError(
                f"{places[row]}: the unit of the samples is stated by {quoted(text[row])}; a GeoNet file holds "
                f"acceleration in 1.00 {UNIT}: convert the samples to it, or fetch the file again"
            )


def _block(name: str, lines: list[str], at: int, count: int, quantity: str) -> NDArray:
    """The samples of one quantity, from line ``at`` on."""
    rows = lines[at : at + ceil(count / COLUMNS)]
    for row, line in enumerate(rows):
        due = min(COLUMNS, count - row * COLUMNS)
        if len(line.rstrip()) != due * WIDTH:
            raise RecordError(
                f"{name}, line {at + row + 1}: found {quoted(line)} among the samples of {quantity}, where {due} "
                f"number{'s' if due > 1 else ''} of {WIDTH} characters each {'are' if due > 1 else 'is'} due; restore "
                "that line, or fetch the file again"
            )
    samples = _text.fixed_numbers(name, rows, at, WIDTH, "-11026.2")
    _text.check_count(f"{name}, {quantity} from line {at + 1} on", count, len(samples), "the number of points")
    return samples


def _azimuths(name: str, headings: list[Heading]) -> list[float | None]:
    """Degrees clockwise from north, by a component's name and its bearing, which must agree; None for a vertical."""
    azimuths: dict[str, float | None] = {}
    for heading in headings:
        label = heading.label.upper()
        if label in azimuths:
            raise RecordError(
                f"{name}, line {heading.line + 13}: two components are called {label}, so that one of them has "
                "a wrong direction; find out which, and correct its name and its bearing"
            )
        bearing, compass = float(heading.whole[BEARING] % 360), _COMPASS.fullmatch(label)
        azimuths[label] = None if label in ("UP", "DOWN") else bearing
        if compass is None:
            continue
        side, angle, turn = compass[1], float(compass[2]), compass[3]
        named = (angle if side == "N" else 180.0 - angle) if turn == "E" else (-angle if side == "N" else 180.0 + angle)
        if abs((named - bearing + 180.0) % 360.0 - 180.0) > 1.0:
            raise RecordError(
                f"{name}, line {heading.line + 13}: the component {heading.label} points to {named % 360.0:g} degrees, "
                f"its bearing in line {heading.line + 19} is {bearing:g}; find out which is right, and correct the "
                "other"
            )
    return list(azimuths.values())


def _letters(azimuths: list[float | None]) -> list[str]:
    """Directions of channel codes: N or E within 5 degrees of it, as the FDSN's naming has it, Z, otherwise 1 to 3."""
    letters = []
    for azimuth in azimuths:
        if azimuth is None:
            letters.append("Z")
        elif min(azimuth, 360.0 - azimuth) <= 5.0:
            letters.append("N")
        else:
            letters.append("E" if abs(azimuth - 90.0) <= 5.0 else "")
    if letters.count("N") == letters.count("E") == 1:
        return letters
    numbers = iter("123")
    return ["Z" if letter == "Z" else next(numbers) for letter in letters]


def _trace(name: str, heading: Heading, azimuth: float | None, letter: str, samples: NDArray | int) -> Trace:
    """The trace of a component, in m/s², with the facts of its heading."""
    text, integers, real = heading.text, heading.whole, heading.real
    title, site = _TITLE.match(text[0]), _SITE.match(text[1])
    assert title and site
    location = _LOCATION.search(title["id"])
    peaks = {}
    for key, pattern, line, unit in zip(("pga", "pgv", "pgd"), _PEAKS, text[13:16], (UNIT, "mm/s", "mm"), strict=True):
        match = pattern.match(line)
        peak = _text.number(match[1]) if match and match[2].lower() == unit else None
        peaks[f"header_{key}"] = None if peak is None else abs(peak) * MILLIMETRE
    low, high = (tuple(real[edge] for edge in edges) for edges in (LOW_EDGES, HIGH_EDGES))
    origin = _time(name, heading.line + 17, (*integers[ORIGIN], 0, 0, 0.0))
    minute, milliseconds = integers[START_MINUTE]
    buffer = (*integers[START_YEAR], *integers[START_DAY], minute, milliseconds / 1000.0)
    start = _time(name, heading.line + 17, buffer)
    record = _text.record_facts(
        **({} if start else {"timed": False}),
        state="raw" if title["kind"].lower() == "uncorrected" else "processed",
        units="units: mm/s², times 0.001",
        event=text[6].strip(),
        magnitude=real[MAGNITUDE] or None,
        date=str(origin.date) if origin else "",
        distance_km=float(integers[DISTANCE]) or None,
        station=site[1],
        component=heading.label,
        azimuth=azimuth,
        low_corner=low[1] or None,
        high_corner=high[0] or None,
        **peaks,
    )
    facts = {"title": title["id"], "site": text[2].strip(), "latitude": -real[LATITUDE], "longitude": real[LONGITUDE]}
    filtered = {"low_transition": low, "high_transition": high} if any((*low, *high)) else {}
    code = f"{_text.channel_code(heading.dt, None, False)}{letter}"
    named = {"network": NETWORK, "station": site[1], "channel": code, "location": location[1] if location else ""}
    begins = start - integers[PREPENDED] * heading.dt if start else origin
    return _text.trace_of(
        samples, MILLIMETRE, heading.dt, record, begins, **named, geonet=AttribDict({**facts, **filtered})
    )


def _time(name: str, line: int, clock: tuple[float, ...]) -> UTCDateTime | None:
    """Year, month, day, hour, minute, second as a time; None where the heading has zeros for unknown."""
    if not any(clock[:3]):
        return None
    listed = " ".join(f"{number:g}" for number in clock)
    sentence = (
        f"{name}, lines {line} to {line + 3}: the heading's numbers give the time {listed} (year, month, day, hour, "
        "minute, second), which is none; restore those lines, or fetch the file again"
    )
    if not 0.0 <= clock[5] < 61.0:
        raise RecordError(sentence)
    with _text.time_of_header(sentence):
        return UTCDateTime(*(int(number) for number in clock[:5])) + clock[5]


FORMAT = Format("GEONET", "GeoNet (.V1A, .V2A)", (".v1a", ".v2a"), _is_geonet, _read_geonet)
