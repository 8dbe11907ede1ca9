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
from obspy import Stream, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._peaks import StatedPeak, check_peak, stated_peak
from pounding_risk.motions.formats._text import (
    NEWLINE,
    NUMBER,
    check_count,
    check_step,
    fixed_numbers,
    number,
    quoted,
    recogniser,
    record_facts,
    text_of,
    trace_of,
)

KIND = "GeoNet"
NETWORK = "NZ"  # of every station that GNS Science runs
COMPONENTS = 3
TEXT_LINES, WHOLE_LINES, REAL_LINES = 16, 4, 6
HEADING_LINES = TEXT_LINES + WHOLE_LINES + REAL_LINES
COLUMNS, WIDTH = 10, 8
MILLIMETRE = 0.001  # m
UNIT = "mm/s/s"
LONGEST_HIGH_BAND_STEP = 1.0 / 80.0  # s; below 80 Hz is the FDSN's band B

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
    counts: tuple[int, int, int]  # samples of acceleration, velocity and displacement


@recogniser(512)
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
    name, text = text_of(file, name, KIND)
    lines = NEWLINE.split(text)
    while not lines[-1].strip():
        lines.pop()
    components = _components(name, lines)
    codes = _codes(name, [heading for heading, _ in components])
    stats = [_stats(name, heading, code) for (heading, _), code in zip(components, codes, strict=True)]
    for heading, acceleration in components:
        check_peak(acceleration, _stated_peak(name, heading))
    samples = [len(acceleration) if headonly else acceleration for _, acceleration in components]
    return Stream([trace_of(values, MILLIMETRE, header) for values, header in zip(samples, stats, strict=True)])


def _components(name: str, lines: list[str]) -> list[tuple[Heading, NDArray]]:
    """Heading and acceleration [mm/s²] of each component; every other block is checked on the way."""
    components: list[tuple[Heading, NDArray]] = []
    at = 0
    while len(components) < COMPONENTS:
        heading = _heading(name, lines, at)
        at += HEADING_LINES
        blocks = []
        for count, quantity in zip(heading.counts, ("acceleration", "velocity", "displacement"), strict=True):
            blocks.append(_block(name, lines, at, count, quantity))
            at += ceil(count / COLUMNS)
        components.append((heading, blocks[0]))
    if at < len(lines):
        raise RecordError(
            f"{name}, line {at + 1}: {quoted(lines[at])} follows the third component, with which a GeoNet file ends; "
            "remove it, or fetch the file again"
        )
    return components


def _stated_peak(name: str, heading: Heading) -> StatedPeak | None:
    """The peak in the text of a heading; None where it was not evaluated."""
    words = _PEAKS[0].match(heading.text[13])
    return stated_peak(words[1], UNIT, 1.0, f"{name}, line {heading.line + 14}") if words else None


def _heading(name: str, lines: list[str], at: int) -> Heading:
    """The heading of the component that begins at line ``at``, checked."""
    heading_lines = lines[at : at + HEADING_LINES]
    if len(heading_lines) < HEADING_LINES:
        raise RecordError(
            f"{name}: ends with line {len(lines)}, before the end of the heading due from line {at + 1} on; a GeoNet "
            f"file has {COMPONENTS} components: the file is cut short, fetch it again"
        )
    text, places = heading_lines[:TEXT_LINES], [f"{name}, line {at + row + 1}" for row in range(len(heading_lines))]
    _check_text(places, text)
    _check_unit(name, text, at)
    numbers = [_table_row(places[row], heading_lines[row]) for row in range(TEXT_LINES, len(heading_lines))]
    for line_words, values in zip(places[TEXT_LINES:], numbers[:WHOLE_LINES], strict=False):
        _check_whole(line_words, values)
    integers = [int(value) for row in numbers[:WHOLE_LINES] for value in row]
    real = [value for row in numbers[WHOLE_LINES:] for value in row]
    dt = check_step(places[22], real[STEP], f"{real[STEP]:g}", "the time step (the sixth number)")
    label = _COMPONENT.match(text[12])[1]  # type: ignore[index]
    heading = Heading(text, integers, real, at, label, dt, _counts(name, integers, at))
    _check_points(name, heading)
    return heading


def _check_text(places: list[str], text: list[str]) -> None:
    """Raise RecordError where a line that the heading needs is something else."""
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


def _table_row(where: str, line: str) -> list[float]:
    """The ten numbers of a line of the heading, in columns of eight characters."""
    words = [line[column * WIDTH : (column + 1) * WIDTH].strip() for column in range(COLUMNS)]
    values = [value for value in map(number, words) if value is not None]
    if len(values) < COLUMNS or line[COLUMNS * WIDTH :].strip():
        raise RecordError(
            f"{where}: {quoted(line)} is not a line of {COLUMNS} numbers in columns of {WIDTH} characters; restore "
            "that line of the heading, or fetch the file again"
        )
    return values


def _check_whole(where: str, row: list[float]) -> None:
    broken = [value for value in row if value != int(value)]
    if broken:
        raise RecordError(
            f"{where}: has {broken[0]:g}, where all numbers are whole; restore that line of the heading, "
            "or fetch the file again"
        )


def _check_unit(name: str, text: list[str], at: int) -> None:
    """Raise RecordError where the heading says no unit, or another than mm/s/s."""
    readings, peak = _READINGS.search(text[10]), _PEAKS[0].match(text[13])
    statements = [(10, 1.0 if number(readings[1]) == 1.0 else None, readings[2])] if readings else []
    statements += [(13, 1.0, peak[2])] if peak else []
    if not statements:
        raise RecordError(
            f"{name}, line {at + 14}: found {quoted(text[13])}, and no unit of the samples in the heading; a GeoNet "
            f'file says "Acceleration: Peak 399.7 {UNIT} at 115.37 s": restore that line, or fetch the file again'
        )
    for row, factor, unit in statements:
        if factor is None or unit.lower() != UNIT:
            raise RecordError(
                f"{name}, line {at + row + 1}: the unit of the samples is told by {quoted(text[row])}; a GeoNet file "
                f"holds acceleration in 1.00 {UNIT}: convert the samples to it, or fetch the file again"
            )


def _counts(name: str, integers: list[int], at: int) -> tuple[int, int, int]:
    """The number of samples of acceleration, velocity and displacement."""
    acceleration, velocity, displacement = integers[COUNTS]
    where = f"{name}, line {at + TEXT_LINES + WHOLE_LINES}"
    if acceleration < 2:
        raise RecordError(f"{where}: the number of acceleration samples is {acceleration}; a record needs at least 2")
    if min(velocity, displacement, integers[PREPENDED]) < 0 or integers[PREPENDED] > acceleration:
        raise RecordError(
            f"{where}: {velocity} samples of velocity, {displacement} of displacement and {integers[PREPENDED]} "
            f"prepended ones do not go with {acceleration} of acceleration; restore that line, or fetch the file again"
        )
    return acceleration, velocity, displacement


def _check_points(name: str, heading: Heading) -> None:
    """Raise RecordError where the text of a heading and its numbers do not agree on samples and duration."""
    points = _POINTS.match(heading.text[9])
    assert points
    promised, duration = int(points[1]), number(points[2]) or 0.0
    count = heading.counts[0]
    if promised != count:
        raise RecordError(
            f"{name}, line {heading.line + 10}: the text promises {promised} points, the numbers of line "
            f"{heading.line + TEXT_LINES + WHOLE_LINES} {count}; fetch the file again"
        )
    # Told as n dt or (n - 1) dt, to a hundredth of a second.
    if not (count - 1) * heading.dt - 0.01 <= duration <= count * heading.dt + 0.01:
        raise RecordError(
            f"{name}, line {heading.line + 10}: the duration is {duration:g} s, but {count} samples every "
            f"{heading.dt:g} s last {count * heading.dt:g} s; fetch the file again"
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
    values = fixed_numbers(name, rows, at, WIDTH, "-11026.2")
    check_count(f"{name}, {quantity} from line {at + 1} on", count, len(values), "the number of points")
    return values


def _codes(name: str, headings: list[Heading]) -> list[str]:
    """The channel codes: band, N for an accelerometer, and the direction."""
    labels = [heading.label.upper() for heading in headings]
    for at, label in enumerate(labels):
        if label in labels[:at]:
            raise RecordError(
                f"{name}, line {headings[at].line + 13}: two components are called {label}, so that one of them has "
                "a wrong direction; find out which, and correct its name and its bearing"
            )
    letters = [_letter(_azimuth(name, heading)) for heading in headings]
    if letters.count("N") != 1 or letters.count("E") != 1:
        numbers = iter("123")
        letters = ["Z" if letter == "Z" else next(numbers) for letter in letters]
    bands = ["H" if heading.dt <= LONGEST_HIGH_BAND_STEP else "B" for heading in headings]
    return [f"{band}N{letter}" for band, letter in zip(bands, letters, strict=True)]


def _letter(azimuth: float | None) -> str:
    """N or E within 5 degrees of it, as the FDSN's naming has it, Z for a vertical, otherwise nothing."""
    if azimuth is None:
        return "Z"
    if min(azimuth, 360.0 - azimuth) <= 5.0:
        return "N"
    return "E" if abs(azimuth - 90.0) <= 5.0 else ""


def _azimuth(name: str, heading: Heading) -> float | None:
    """Degrees clockwise from north, by the component's name and its bearing, which must agree; None for a vertical."""
    if heading.label.upper() in ("UP", "DOWN"):
        return None
    bearing = float(heading.whole[BEARING] % 360)
    compass = _COMPASS.fullmatch(heading.label)
    if compass is None:
        return bearing
    side, angle, turn = compass[1].upper(), float(compass[2]), compass[3].upper()
    named = (angle if side == "N" else 180.0 - angle) if turn == "E" else (-angle if side == "N" else 180.0 + angle)
    if abs((named - bearing + 180.0) % 360.0 - 180.0) > 1.0:
        raise RecordError(
            f"{name}, line {heading.line + 13}: the component {heading.label} points to {named % 360.0:g} degrees, its "
            f"bearing in line {heading.line + 19} is {bearing:g}; find out which is right, and correct the other"
        )
    return bearing


def _stats(name: str, heading: Heading, code: str) -> dict[str, Any]:
    """ObsPy statistics from the heading."""
    text, integers, real = heading.text, heading.whole, heading.real
    title, site = _TITLE.match(text[0]), _SITE.match(text[1])
    assert title and site
    location = _LOCATION.search(title["id"])
    pga, pgv, pgd = map(_peak, _PEAKS, text[13:16], (UNIT, "mm/s", "mm"))
    low, high = (tuple(real[edge] for edge in edges) for edges in (LOW_EDGES, HIGH_EDGES))
    origin = _time(name, heading.line + 17, (*integers[ORIGIN], 0, 0, 0.0))
    buffer = (
        *integers[START_YEAR],
        *integers[START_DAY],
        integers[START_MINUTE][0],
        integers[START_MINUTE][1] / 1000.0,
    )
    start = _time(name, heading.line + 17, buffer)
    record = record_facts(
        **({} if start else {"timed": False}),
        state="raw" if title["kind"].lower() == "uncorrected" else "processed",
        units="units: mm/s², times 0.001",
        event=text[6].strip(),
        magnitude=real[MAGNITUDE] or None,
        date=str(origin.date) if origin else "",
        distance_km=float(integers[DISTANCE]) or None,
        station=site[1],
        component=heading.label,
        azimuth=_azimuth(name, heading),
        low_corner=low[1] or None,
        high_corner=high[0] or None,
        header_pga=pga,
        header_pgv=pgv,
        header_pgd=pgd,
    )
    stats: dict[str, Any] = {"delta": heading.dt, "calib": 1.0, "network": NETWORK, "station": site[1], "channel": code}
    stats |= {"location": location[1] if location else "", "record": record}
    facts = {"title": title["id"], "site": text[2].strip(), "latitude": -real[LATITUDE], "longitude": real[LONGITUDE]}
    filtered = {"low_transition": low, "high_transition": high} if any((*low, *high)) else {}
    stats["geonet"] = AttribDict({**facts, **filtered})
    begins = start - integers[PREPENDED] * heading.dt if start else origin
    return {**stats, "starttime": begins} if begins else stats


def _peak(pattern: re.Pattern[str], line: str, unit: str) -> float | None:
    """The peak in a line of the heading, from millimetres to metres; None where it was not evaluated."""
    match = pattern.match(line)
    value = number(match[1]) if match and match[2].lower() == unit else None
    return None if value is None else abs(value) * MILLIMETRE


def _time(name: str, line: int, parts: tuple[float, ...]) -> UTCDateTime | None:
    """Year, month, day, hour, minute, second as a time; None where the heading has zeros for unknown."""
    if not any(parts[:3]):
        return None
    try:
        if 0.0 <= parts[5] < 61.0:
            return UTCDateTime(*(int(part) for part in parts[:5])) + parts[5]
    except (ValueError, OverflowError):
        pass  # a thirteenth month, or the like
    listed = " ".join(f"{part:g}" for part in parts)
    raise RecordError(
        f"{name}, lines {line} to {line + 3}: the heading's numbers give the time {listed} (year, month, day, hour, "
        "minute, second), which is none; restore those lines, or fetch the file again"
    )


FORMAT = Format("GEONET", "GeoNet (.V1A, .V2A)", (".v1a", ".v2a"), _is_geonet, _read_geonet)
