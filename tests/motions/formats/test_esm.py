"""ESM and ITACA text: real files, the spellings in use, and texts with faults."""

import numpy as np
import obspy
import pytest
from real_files import read, real

EAST, NORTH = (real(f"esm-dlfa-{stream}.asc") for stream in ("hne", "hnn"))
HEADER = 64  # lines


def changed(data, **values):
    """The file with other values in its header; "_per_" and "_pow_" in a key are / and ^, None takes the line away."""
    lines = data.decode().split("\n")
    for name, value in values.items():
        key = name.replace("_per_", "/").replace("_pow_", "^")
        at = next(at for at, line in enumerate(lines) if line.startswith(f"{key}:"))
        lines[at : at + 1] = [] if value is None else [f"{key}: {value}"]
    return "\n".join(lines).encode()


SMALL = "\n".join([*EAST.decode().split("\n")[:HEADER], "0.1", "-0.2", "0.3", "-0.227973", ""]).encode()
SMALL = changed(SMALL, NDATA=4, DURATION_S="0.020", PGA_CM_per_S_pow_2="0.3")


@pytest.mark.parametrize("data", [EAST, NORTH], ids=["HNE", "HNN"])
def test_samples_are_those_of_the_lines_and_the_peak_is_when_the_header_says(data):
    trace = read(data)[0]
    samples = [float(line) for line in data.decode().split("\n")[HEADER:] if line]
    assert np.array_equal(trace.data, np.array(samples) * 0.01)
    peak = np.abs(trace.data).argmax() * trace.stats.delta
    assert peak == pytest.approx(float(trace.stats.esm["TIME_PGA_S"]), abs=1e-6)


def test_all_lines_of_the_header_are_kept():
    header = read(EAST)[0].stats.esm
    assert header["STATION_NAME"] == "Delfoi, Greece"
    assert header["ORIGINAL_DATA_MEDIATOR"] == "http://eida.gein.noa.gr/"  # colons belong to a value
    assert len(header) == HEADER


UNFILTERED = {"LOW_CUT_FREQUENCY_HZ": "", "HIGH_CUT_FREQUENCY_HZ": "", "FILTER_ORDER": ""}


@pytest.mark.parametrize(
    ("values", "state"),
    [
        ({}, "processed"),
        ({"HIGH_CUT_FREQUENCY_HZ": ""}, "processed"),
        ({**UNFILTERED, "BASELINE_CORRECTION": "BASELINE NOT REMOVED", "PROCESSING": "none"}, "raw"),
        ({**UNFILTERED, "PROCESSING": "Automatic Paolucci et al., 2011"}, "raw"),
    ],
    ids=["band-pass", "high-pass", "unprocessed", "called processed, but without a corner"],
)
def test_a_record_is_processed_where_the_header_tells_a_corner(values, state):
    record = read(changed(EAST, **values))[0].stats.record
    assert record.state == state
    assert (record.low_corner is None and record.high_corner is None) == (state == "raw")


def test_the_spelling_of_the_turkish_archive():
    """Days with slashes, a clock with colons, an address for a location, empty values, small letters (AFAD, RawAcc)."""
    data = changed(
        SMALL,
        EVENT_DATE_YYYYMMDD="2010/11/14",
        EVENT_TIME_HHMMSS="23:08:25.75",
        DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS="14/11/2010 23:09:19.300",
        LOCATION="HATAY_HASSA_AKTEPE_SALYK_OCAY_BAHCESI",
        DURATION_S="",
        DATA_TYPE="Acceleration",
        TIME_PGA_S="",
        **UNFILTERED,
    )
    stats = read(data)[0].stats
    assert stats.starttime == obspy.UTCDateTime(2010, 11, 14, 23, 9, 19, 300000)
    assert (stats.location, stats.record.date) == ("", "2010-11-14")
    assert stats.record.state == "raw"


@pytest.mark.parametrize(
    ("words", "start"),
    [
        ("20190728_160905", "2019-07-28T16:09:05"),
        ("2019-07-28T16:09:05.700000", "2019-07-28T16:09:05.7"),
        ("2019/07/28 16:09:05.7", "2019-07-28T16:09:05.7"),
        ("", "2019-07-28T00:00:00"),
    ],
    ids=["seconds", "ISO", "slashes", "unknown: the day of the earthquake"],
)
def test_the_first_sample_is_when_the_header_says(words, start):
    data = changed(SMALL, DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS=words)
    stats = read(data)[0].stats
    assert (stats.starttime, stats.record.get("timed", True)) == (obspy.UTCDateTime(start), bool(words))


def test_the_moment_magnitude_comes_before_the_local_one():
    assert read(changed(SMALL, MAGNITUDE_W="4.8"))[0].stats.record.magnitude == 4.8


DYNA_10 = {
    **dict.fromkeys(("SENSOR_DEPTH_M", "DATA_LICENSE", "DATA_CITATION", "DATA_CREATOR", "USER5")),
    **dict.fromkeys(("ORIGINAL_DATA_MEDIATOR_CITATION", "ORIGINAL_DATA_MEDIATOR")),
    **dict.fromkeys(("ORIGINAL_DATA_CREATOR_CITATION", "ORIGINAL_DATA_CREATOR")),
    "HEADER_FORMAT": "DYNA 1.0",
}


SPELLINGS = {
    "DYNA 1.0": (SMALL, changed(SMALL, **DYNA_10)),
    "CR LF": (SMALL, SMALL.replace(b"\n", b"\r\n")),
    "blank lines at the end": (SMALL, SMALL + b"\n \n"),
    "no last newline": (SMALL, SMALL[:-1]),
    "exponents": (SMALL, SMALL.replace(b"\n0.1\n", b"\n  1.0E-01 \n")),
    "cm/s2": (SMALL, changed(SMALL, UNITS="cm/s2")),
    "n - 1 steps": (SMALL, changed(SMALL, DURATION_S="0.015")),
}


HEADERS = {
    "velocity": {"DATA_TYPE": "VELOCITY"},
    "displacement": {"DATA_TYPE": "DISPLACEMENT"},
    "a response spectrum": {"DATA_TYPE": "ACCELERATION RESPONSE SPECTRUM"},
    "in g": {"UNITS": "g"},
    "DYNA 2.0": {"HEADER_FORMAT": "DYNA 2.0"},
    "no format": {"HEADER_FORMAT": None},
    "no corner": {"LOW_CUT_FREQUENCY_HZ": None},
    "no unit": {"UNITS": ""},
    "a sample less": {"NDATA": "5", "DURATION_S": "0.025"},
    "a sample more": {"NDATA": "3", "DURATION_S": ""},
    "4.0 samples": {"NDATA": "4.0"},
    "one sample": {"NDATA": "1"},
    "no step": {"SAMPLING_INTERVAL_S": "0"},
    "step nan": {"SAMPLING_INTERVAL_S": "nan"},
    "two durations": {"SAMPLING_INTERVAL_S": "0.01"},
    "a corner in words": {"LOW_CUT_FREQUENCY_HZ": "low"},
    "a decimal comma in the header": {"PGA_CM_per_S_pow_2": "1,2"},
    "month 13": {"DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS": "20191328_160905"},
    "a month alone": {"EVENT_DATE_YYYYMMDD": "July"},
}
LINES = {
    "NaN": (b"\n-0.2\n", b"\nNaN\n"),
    "a decimal comma": (b"\n-0.2\n", b"\n-0,2\n"),
    "two on a line": (b"\n-0.2\n", b"\n-0.2 0.3\n"),
    "a blank line": (b"\n-0.2\n", b"\n\n"),
    "a key twice": (b"STREAM: HNE", b"NDATA: 5"),
    "a key without a colon": (b"\nUSER5: \n", b"\nUSER5\n"),
}
BAD = {
    "empty": b"",
    "cut in the header": SMALL[:1000],
    **{name: changed(SMALL, **values) for name, values in HEADERS.items()},
    **{f"line: {name}": SMALL.replace(old, new) for name, (old, new) in LINES.items()},
}
