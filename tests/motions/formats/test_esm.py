"""ESM and ITACA text: real files, the spellings in use, and the exact sentence for each fault."""

import gzip
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest

from pounding_risk.motions.formats.esm import _read_esm

DATA = Path(__file__).parents[2] / "data" / "formats"
EAST, NORTH = (gzip.decompress((DATA / f"esm-dlfa-{stream}.asc.gz").read_bytes()) for stream in ("hne", "hnn"))
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


@pytest.mark.parametrize(("data", "stream", "azimuth"), [(EAST, "HNE", 90.0), (NORTH, "HNN", 0.0)])
def test_a_file_gives_what_its_header_promises(data, stream, azimuth):
    trace = _read_esm(BytesIO(data))[0]
    assert trace.id == f"HL.DLFA..{stream}"
    assert (trace.stats.npts, trace.stats.delta, trace.stats.calib) == (13876, 0.005, 1.0)
    assert trace.stats.starttime == obspy.UTCDateTime(2019, 7, 28, 16, 9, 5, 700000)
    assert trace.stats.record.azimuth == azimuth
    assert trace.data.dtype == np.float64
    samples = [float(line) for line in data.decode().split("\n")[HEADER:] if line]
    assert np.array_equal(trace.data, np.array(samples) * 0.01)


@pytest.mark.parametrize("data", [EAST, NORTH], ids=["HNE", "HNN"])
def test_the_peak_of_the_header_is_that_of_the_samples_and_is_when_it_says(data):
    """Both have six decimals of cm/s², so they are the same number; the time has one in six of a second."""
    trace = _read_esm(BytesIO(data))[0]
    assert np.abs(trace.data).max() == pytest.approx(trace.stats.record.header_pga, abs=0.5e-8)
    peak = np.abs(trace.data).argmax() * trace.stats.delta
    assert peak == pytest.approx(float(trace.stats.esm["TIME_PGA_S"]), abs=1e-6)


def test_the_header_goes_to_the_statistics():
    stats = _read_esm(BytesIO(EAST))[0].stats
    assert stats.record == {
        "state": "processed",
        "units": "units: cm/s², times 0.01",
        "event": "GREECE",
        "magnitude": 4.6,
        "date": "2019-07-28",
        "distance_km": 100.5,
        "station": "DLFA",
        "component": "HNE",
        "azimuth": 90.0,
        "low_corner": 0.2,
        "high_corner": 30.0,
        "header_pga": pytest.approx(0.00227973, rel=1e-15),
    }
    assert stats.esm["STATION_NAME"] == "Delfoi, Greece"
    assert stats.esm["ORIGINAL_DATA_MEDIATOR"] == "http://eida.gein.noa.gr/"  # colons belong to a value
    assert len(stats.esm) == HEADER


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
    record = _read_esm(BytesIO(changed(EAST, **values)))[0].stats.record
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
    stats = _read_esm(BytesIO(data))[0].stats
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
    stats = _read_esm(BytesIO(data))[0].stats
    assert (stats.starttime, stats.record.get("timed", True)) == (obspy.UTCDateTime(start), bool(words))


def test_the_moment_magnitude_comes_before_the_local_one():
    assert _read_esm(BytesIO(changed(SMALL, MAGNITUDE_W="4.8")))[0].stats.record.magnitude == 4.8


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


def test_the_short_file_has_its_samples():
    assert list(_read_esm(BytesIO(SMALL))[0].data) == [0.1 * 0.01, -0.2 * 0.01, 0.3 * 0.01, -0.227973 * 0.01]


def test_dyna_1_0_has_55_lines():
    assert len(_read_esm(BytesIO(changed(SMALL, **DYNA_10)))[0].stats.esm) == 55


PLAIN = "restore that line, or fetch the file again"
HEADERS = [
    (
        {"DATA_TYPE": "VELOCITY"},
        'line 50: the file holds "VELOCITY"; take the ACCELERATION file of this record (.ACC. in its name)',
    ),
    (
        {"DATA_TYPE": "DISPLACEMENT"},
        'line 50: the file holds "DISPLACEMENT"; take the ACCELERATION file of this record (.ACC. in its name)',
    ),
    (
        {"DATA_TYPE": "ACCELERATION RESPONSE SPECTRUM"},
        'line 50: the file holds "ACCELERATION RESPONSE SPECTRUM"; take the ACCELERATION file of this record (.ACC. in '
        "its name)",
    ),
    (
        {"UNITS": "g"},
        'line 33: the unit of the samples is "g"; an ESM file holds acceleration in cm/s^2: convert the samples to it, '
        "or fetch the file again",
    ),
    (
        {"HEADER_FORMAT": "DYNA 2.0"},
        'line 49: the header is of format "DYNA 2.0"; DYNA 1.0 to 1.2 are read: take the file from the database again',
    ),
    (
        {"HEADER_FORMAT": None},
        'no HEADER_FORMAT in the header of 63 lines, before "0.1"; an ESM file has lines such as NDATA: 13876 from '
        "EVENT_NAME to USER5: take the file from the database again",
    ),
    (
        {"LOW_CUT_FREQUENCY_HZ": None},
        'no LOW_CUT_FREQUENCY_HZ in the header of 63 lines, before "0.1"; an ESM file has lines such as NDATA: 13876 '
        "from EVENT_NAME to USER5: take the file from the database again",
    ),
    (
        {"UNITS": ""},
        'no UNITS in the header of 64 lines, before "0.1"; an ESM file has lines such as NDATA: 13876 from EVENT_NAME '
        "to USER5: take the file from the database again",
    ),
    (
        {"NDATA": "5", "DURATION_S": "0.025"},
        "line 30: the header promises 5 samples, 4 found; the file is cut short: fetch it again",
    ),
    (
        {"NDATA": "3", "DURATION_S": ""},
        "line 30: the header promises 3 samples, 4 found; correct NDATA, or fetch the file again",
    ),
    ({"NDATA": "4.0"}, 'line 30: NDATA is "4.0"; it must be a whole number of samples'),
    ({"NDATA": "1"}, "line 30: NDATA is 1; a record needs at least 2 samples"),
    (
        {"SAMPLING_INTERVAL_S": "0"},
        f'line 29: SAMPLING_INTERVAL_S is "0"; the time step must be a number of seconds greater than 0, from 1e-06 to '
        f"1 s: {PLAIN}",
    ),
    (
        {"SAMPLING_INTERVAL_S": "nan"},
        f'line 29: SAMPLING_INTERVAL_S is "nan"; the time step must be a number of seconds greater than 0, from 1e-06 '
        f"to 1 s: {PLAIN}",
    ),
    (
        {"SAMPLING_INTERVAL_S": "0.01"},
        "line 31: 4 samples every 0.01 s last 0.04 s, DURATION_S says 0.02 s; correct the wrong one, or fetch the file "
        "again",
    ),
    (
        {"LOW_CUT_FREQUENCY_HZ": "low"},
        f'line 45: LOW_CUT_FREQUENCY_HZ is "low"; it must be a number, or empty: {PLAIN}',
    ),
    ({"PGA_CM_per_S_pow_2": "1,2"}, f'line 40: PGA_CM/S^2 is "1,2"; it must be a number, or empty: {PLAIN}'),
    (
        {"DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS": "20191328_160905"},
        f'line 27: DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS is "20191328_160905"; it must be a time such as '
        f"20190728_160905.700, or empty: {PLAIN}",
    ),
    (
        {"EVENT_DATE_YYYYMMDD": "July"},
        f'line 3: EVENT_DATE_YYYYMMDD is "July"; it must be a time such as 20190728_160905.700, or empty: {PLAIN}',
    ),
]
LINES = [
    (
        b"\n-0.2\n",
        b"\nNaN\n",
        'line 66: "NaN" is not a finite number; the samples after the header must be plain numbers such as -0.227973: '
        "repair that line, or fetch the file again",
    ),
    (
        b"\n-0.2\n",
        b"\n-0,2\n",
        'line 66: "-0,2" is not a finite number; the samples after the header must be plain numbers such as -0.227973: '
        "repair that line, or fetch the file again",
    ),
    (
        b"\n-0.2\n",
        b"\n-0.2 0.3\n",
        f'line 66: found "-0.2 0.3" among the samples, of which an ESM file has one on a line; {PLAIN}',
    ),
    (b"\n-0.2\n", b"\n\n", f'line 66: found "" among the samples, of which an ESM file has one on a line; {PLAIN}'),
    (
        b"STREAM: HNE",
        b"NDATA: 5",
        "line 32: NDATA is there a second time, after line 30; remove the wrong one, or fetch the file again",
    ),
    (
        b"\nUSER5: \n",
        b"\nUSER5\n",
        'line 64: "USER5" is not a finite number; the samples after the header must be plain numbers such as '
        "-0.227973: repair that line, or fetch the file again",
    ),
]


BAD = [
    (b"", "x.asc: is empty (0 bytes); fetch the record again"),
    (
        SMALL[:1000],
        "x.asc: no HEADER_FORMAT in the header of 38 lines, before the end of the file; an ESM file has lines such as "
        "NDATA: 13876 from EVENT_NAME to USER5: take the file from the database again",
    ),
    *[
        (changed(SMALL, **values), f"x.asc{', ' if sentence.startswith('line') else ': '}{sentence}")
        for values, sentence in HEADERS
    ],
    *[(SMALL.replace(old, new), f"x.asc, {sentence}") for old, new, sentence in LINES],
]
