"""ESM and ITACA text files ("DYNA"): one component of acceleration in cm/s², from the databases of INGV and ORFEUS.

A header of lines KEY: value, from EVENT_NAME to USER5 (55 lines in DYNA 1.0, 64 in 1.2), then one sample a line:

    EVENT_NAME: GREECE
    ...
    SAMPLING_INTERVAL_S: 0.005000
    NDATA: 13876
    ...
    DATA_TYPE: ACCELERATION
    PROCESSING: manual (Paolucci et al., 2011)

A record is processed where the header states a corner of the filter, LOW_CUT_FREQUENCY_HZ or HIGH_CUT_FREQUENCY_HZ, and
raw where it states none: every processing of ESM filters, while other keys are not reliable. Files of the Turkish
archive called RawAcc say "PROCESSING: Automatic" and "BASELINE REMOVED", and their samples drift as those of an
unfiltered record.
"""

from __future__ import annotations

import re
from typing import Any

from obspy import Stream, UTCDateTime
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format, _text
from pounding_risk.motions.formats._text import NEWLINE, quoted

KIND = "ESM"
UNITS = ("cm/s^2", "cm/s2")
NEEDED = ("HEADER_FORMAT", "DATA_TYPE", "UNITS", "SAMPLING_INTERVAL_S", "NDATA", "STREAM", "STATION_CODE")
FIRST_SAMPLE = "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS"
LOW, HIGH = "LOW_CUT_FREQUENCY_HZ", "HIGH_CUT_FREQUENCY_HZ"
DUE = (FIRST_SAMPLE, LOW, HIGH)  # may be empty, but a damaged key must not make a processed record raw
PEAK = "PGA_CM/S^2"
AZIMUTHS = {"N": 0.0, "E": 90.0}

_LINE = re.compile(r"\s*([A-Z][A-Z0-9_/^]*)\s*:(.*)", re.ASCII)
_START = re.compile(r"\s*EVENT_NAME\s*:")
_CLOCK = re.compile(r"[ _T](\d\d):?(\d\d):?([0-6]\d(?:\.\d*)?)$", re.ASCII)
_DAYS = (
    re.compile(r"(?P<year>\d{4})(?P<month>\d\d)(?P<day>\d\d)", re.ASCII),
    re.compile(r"(?P<year>\d{4})[-/](?P<month>\d\d)[-/](?P<day>\d\d)", re.ASCII),
    re.compile(r"(?P<day>\d\d)/(?P<month>\d\d)/(?P<year>\d{4})", re.ASCII),
)


class Header(dict[str, str]):
    """The values of a header by their keys, empty where it has none, and the place of each for messages."""

    def __init__(self, name: str, lines: list[str]):
        super().__init__()
        self.name = name
        self.lines: dict[str, int] = {}
        for line in lines:
            match = _LINE.match(line)
            if not match:
                break
            if match[1] in self:
                raise RecordError(
                    f"{name}, line {len(self) + 1}: {match[1]} is there a second time, after line "
                    f"{self.lines[match[1]]}; remove the wrong one, or fetch the file again"
                )
            self[match[1]] = match[2].strip()
            self.lines[match[1]] = len(self)

    def __missing__(self, key: str) -> str:
        return ""

    def place(self, key: str) -> str:
        """File and line of a key."""
        return f"{self.name}, line {self.lines[key]}" if key in self.lines else self.name

    def number(self, key: str) -> float | None:
        """The number of a key, None where the header leaves it open."""
        parsed = _text.number(self[key]) if self[key] else None
        if parsed is None and self[key]:
            raise RecordError(
                f"{self.place(key)}: {key} is {quoted(self[key])}; it must be a number, or empty: restore that line, "
                "or fetch the file again"
            )
        return parsed


@_text.recogniser()
def _is_esm(start: str) -> bool:
    """True for a text file of ESM or ITACA, of whatever quantity."""
    return bool(_START.match(start)) and "SAMPLING_INTERVAL_S" in start


def _read_esm(file: Any, headonly: bool = False, *, name: str = "", **_kwargs: Any) -> Stream:
    """One trace in m/s² from an ESM or ITACA file.

    ``stats.channel`` and ``stats.record.component`` are the header's STREAM, such as HNE; the azimuth is known where
    that ends with N or E. ``stats.esm`` has every key of the header.

    Raises RecordError, naming file and line, for a header without a key that is needed or with one twice, a quantity
    other than acceleration, a unit other than cm/s^2, a time step out of range, a duration that contradicts it, a
    number of samples other than NDATA, a largest one other than the stated PGA, and for any sample that is no finite
    number.
    """
    name, text = _text.text_of(file, name, KIND)
    lines = NEWLINE.split(text)
    while not lines[-1].strip():
        lines.pop()
    header = Header(name, lines)
    _check_kind(header, lines)
    dt = _text.check_step(
        header.place("SAMPLING_INTERVAL_S"),
        _text.number(header["SAMPLING_INTERVAL_S"]),
        header["SAMPLING_INTERVAL_S"],
        "SAMPLING_INTERVAL_S",
    )
    count = _text.whole_count(header.place("NDATA"), header["NDATA"], "NDATA")
    _text.check_length(header.place("DURATION_S"), count, dt, header.number("DURATION_S"), 0.001, "DURATION_S")
    for at, line in enumerate(lines[len(header) :], start=len(header) + 1):
        if len(line.split()) != 1:
            raise RecordError(
                f"{name}, line {at}: found {quoted(line)} among the samples, of which an ESM file has one on a line; "
                "restore that line, or fetch the file again"
            )
    samples = _text.free_numbers(name, lines[len(header) :], len(header), "-0.227973")
    _text.check_count(header.place("NDATA"), count, len(samples), "NDATA")
    record, start = _facts(header)
    if not headonly:
        _text.check_peak(samples, _text.stated_peak(header[PEAK], "cm/s²", 1.0, header.place(PEAK)))
    location = header["LOCATION"] if len(header["LOCATION"]) <= 2 else ""  # some archives write an address there
    seed = {"network": header["NETWORK"], "station": header["STATION_CODE"], "channel": header["STREAM"]}
    more = {**seed, "location": location, "esm": AttribDict(header)}
    return Stream([_text.trace_of(count if headonly else samples, 0.01, dt, record, start, **more)])


def _check_kind(header: Header, lines: list[str]) -> None:
    """Raise RecordError for a header that is no DYNA header of acceleration in cm/s^2."""
    missing = [key for key in NEEDED if not header[key]] + [key for key in DUE if key not in header]
    if missing:
        after = quoted(lines[len(header)]) if len(header) < len(lines) else "the end of the file"
        raise RecordError(
            f"{header.name}: no {missing[0]} in the header of {len(header)} lines, before {after}; an ESM file has "
            "lines such as NDATA: 13876 from EVENT_NAME to USER5: take the file from the database again"
        )
    if not re.fullmatch(r"DYNA 1\.\d+", header["HEADER_FORMAT"], re.ASCII):
        raise RecordError(
            f"{header.place('HEADER_FORMAT')}: the header is of format {quoted(header['HEADER_FORMAT'])}; DYNA 1.0 to "
            "1.2 are read: take the file from the database again"
        )
    if header["DATA_TYPE"].upper() != "ACCELERATION":
        raise RecordError(
            f"{header.place('DATA_TYPE')}: the file holds {quoted(header['DATA_TYPE'])}; take the ACCELERATION file of "
            "this record (.ACC. in its name)"
        )
    if header["UNITS"].lower() not in UNITS:
        raise RecordError(
            f"{header.place('UNITS')}: the unit of the samples is {quoted(header['UNITS'])}; an ESM file holds "
            f"acceleration in {UNITS[0]}: convert the samples to it, or fetch the file again"
        )


def _facts(header: Header) -> tuple[AttribDict, UTCDateTime | None]:
    """The facts of the recording, and when it starts."""
    low, high, peak = header.number(LOW), header.number(HIGH), header.number(PEAK)
    magnitude = header.number("MAGNITUDE_W")
    day = _time(header, "EVENT_DATE_YYYYMMDD")
    record = _text.record_facts(
        **({} if header[FIRST_SAMPLE] else {"timed": False}),
        state="raw" if low is None and high is None else "processed",
        units="units: cm/s², times 0.01",
        event=header["EVENT_NAME"] or header["EVENT_ID"],
        magnitude=header.number("MAGNITUDE_L") if magnitude is None else magnitude,
        date="" if day is None else str(day.date),
        distance_km=header.number("EPICENTRAL_DISTANCE_KM"),
        station=header["STATION_CODE"],
        component=header["STREAM"],
        azimuth=AZIMUTHS.get(header["STREAM"][-1].upper()),
        low_corner=low,
        high_corner=high,
        header_pga=None if peak is None else abs(peak) * 0.01,
    )
    return record, _time(header, FIRST_SAMPLE) or day


def _time(header: Header, key: str) -> UTCDateTime | None:
    """The time of a key, in one of the spellings in use; None where the header leaves it open."""
    words = header[key]
    if not words:
        return None
    sentence = (
        f"{header.place(key)}: {key} is {quoted(words)}; it must be a time such as 20190728_160905.700, or empty: "
        "restore that line, or fetch the file again"
    )
    clock = _CLOCK.search(words)
    day = words[: clock.start()] if clock else words
    date = next(filter(None, (pattern.fullmatch(day) for pattern in _DAYS)), None)
    if date is None or (clock is None and key == FIRST_SAMPLE):
        raise RecordError(sentence)
    hour, minute, second = (float(digits) for digits in clock.groups()) if clock else (0.0, 0.0, 0.0)
    with _text.time_of_header(sentence):
        return UTCDateTime(*(int(date[digits]) for digits in ("year", "month", "day")), int(hour), int(minute)) + second


FORMAT = Format("ESM", "ESM and ITACA text (.asc)", (".asc",), _is_esm, _read_esm)
