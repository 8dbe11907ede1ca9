"""PEER AT2: every header in use, titles of the older database, and texts with faults."""

import gzip
from dataclasses import replace
from io import BytesIO

import numpy as np
import obspy
import pytest
from sentences import refusal

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.formats import read_file
from pounding_risk.motions.formats.peer_at2 import _is_at2, _read_at2
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.record import is_vertical
from pounding_risk.motions.write import write_motion

G = 9.80665
EL_CENTRO = catalogue.read_bytes("RSN6-180")


def with_header(lines, data=EL_CENTRO):
    """The real samples under another header."""
    return "\r\n".join(lines).encode("latin-1") + b"\r\n" + data.split(b"\n", 4)[4]


OLD = [
    "PEER STRONG MOTION DATABASE RECORD. PROCESSING BY PACIFIC ENGINEERING.",
    "IMPERIAL VALLEY 5/19/40 0439, EL CENTRO ARRAY #9, 180",
    "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=15.0 Hz",
    "NPTS=  5372, DT= .01000 SEC",
]
BARE = [*OLD[:3], " 5372 0.0100 NPTS, DT"]


@pytest.mark.parametrize("header", [OLD, BARE], ids=["old", "numbers first"])
def test_older_headers(header):
    raw = with_header(header)
    assert _is_at2(BytesIO(raw))
    trace = _read_at2(BytesIO(raw))[0]
    assert np.array_equal(trace.data, _read_at2(BytesIO(EL_CENTRO))[0].data)
    assert trace.stats.delta == 0.01
    at2 = trace.stats.peer_at2
    assert (at2.event, at2.station, at2.component) == ("IMPERIAL VALLEY", "EL CENTRO ARRAY #9", "180")
    assert (at2.date, at2.time, at2.high_pass, at2.low_pass) == ("5/19/40", "0439", 0.2, 15.0)
    assert trace.stats.starttime == obspy.UTCDateTime(1940, 5, 19)


@pytest.mark.parametrize(
    ("title", "event", "station", "component", "azimuth"),
    [
        ("LOMA PRIETA 10/18/89 00:05, GILROY #1, 000 (CDMG STATION 47379)", "LOMA PRIETA", "GILROY #1", "000", 0.0),
        ("IMPERIAL VALLEY 10/18/89 2319, AGRARIAS, UP (USGS 6618)", "IMPERIAL VALLEY", "AGRARIAS", "UP", None),
        ("NORTHRIDGE EQ 10/18/89, 12:31, ARLETA, 090", "NORTHRIDGE EQ", "ARLETA", "090", 90.0),
        ("CHI-CHI 10/18/89, TCU045, E", "CHI-CHI", "TCU045", "E", 90.0),
        ("CHI-CHI 10/18/89, TCU045, W", "CHI-CHI", "TCU045", "W", 270.0),
        ("KOBE 10/18/89, 2046, 000", "KOBE", "2046", "000", 0.0),  # no time: a station must have a name
    ],
)
def test_titles_of_the_older_database(title, event, station, component, azimuth):
    """With a time of day in either spelling, and the owner of the station after the component."""
    record = _read_at2(BytesIO(with_header([OLD[0], title, *OLD[2:]])))[0].stats.record
    assert (record.event, record.date, record.station) == (event, "1989-10-18", station)
    assert (record.component, record.azimuth) == (component, azimuth)
    assert is_vertical(record) == (component == "UP")


@pytest.mark.parametrize(
    ("step", "dt"),
    [
        ("NPTS=  5372, DT= 10.0 MSEC", 0.01),
        ("NPTS=  5372, DT= 0.5 msec,", 0.0005),
        ("NPTS=  5372, DT= .0100 Seconds", 0.01),
        ("NPTS=  5372, DT= .0100 SEC, (100 Hz)", 0.01),
        ("DT= .0100 NPTS=  5372", 0.01),
        (" 5372 5.0 NPTS, DT (MS)", 0.005),
        (" 5372 .005 NPTS, DT (SEC)", 0.005),
    ],
)
def test_the_unit_of_the_time_step_is_read(step, dt):
    assert _read_at2(BytesIO(with_header([*OLD[:3], step])))[0].stats.delta == dt


def test_a_time_step_in_another_unit_is_refused():
    with pytest.raises(RecordError, match=r'line 4: DT is in "MIN"; write it in seconds, such as "DT= \.0100 SEC"'):
        _read_at2(BytesIO(with_header([*OLD[:3], "NPTS=  5372, DT= .0100 MIN"])), name="x.at2")


@pytest.mark.parametrize(("digits", "year"), [("33", 1933), ("99", 1999), ("00", 2000), ("14", 2014), ("32", 2032)])
def test_two_digits_of_a_year_are_of_the_years_of_accelerographs(digits, year):
    """The first accelerograms are of Long Beach, 10 March 1933."""
    title = OLD[1].replace("/40", f"/{digits}")
    trace = _read_at2(BytesIO(with_header([OLD[0], title, *OLD[2:]])))[0]
    assert trace.stats.record.date == f"{year}-05-19"


@pytest.mark.parametrize("azimuth", [None, 0.0, 37.5, 270.0])
@pytest.mark.parametrize("component", ["HN1", "N", "090", "W", ""])
def test_a_written_motion_keeps_its_corners_and_its_azimuth(tmp_path, azimuth, component):
    motion = read_motion("RSN6-180")
    facts = {"component": component, "azimuth": azimuth, "low_corner": 0.0811862938, "high_corner": 37.5}
    write_motion(replace(motion, record={**motion.record, **facts}), tmp_path / "x.at2")
    back = read_motion(tmp_path / "x.at2").record
    assert (back["low_corner"], back["high_corner"]) == (0.0811862938, 37.5)
    assert azimuth is None or back["azimuth"] == azimuth
    assert (back["station"], back["date"]) == (motion.record["station"], motion.record["date"])


def test_a_title_of_a_megabyte_is_no_title():
    """Its parts are looked for in a time that grows with the square of its length: hours, for this one."""
    title = "EL CENTRO 5/19/40" + 10**6 * " " + "x"
    record = _read_at2(BytesIO(with_header([OLD[0], title, *OLD[2:]])))[0].stats.record
    assert (record.event, record.component) == ("", "")


SPELLINGS = {
    "LF": (EL_CENTRO, EL_CENTRO.replace(b"\r\n", b"\n")),
    "CR": (EL_CENTRO, EL_CENTRO.replace(b"\r\n", b"\r")),
    "D exponents": (EL_CENTRO, EL_CENTRO.replace(b"E-0", b"D-0")),
    "small g": (EL_CENTRO, EL_CENTRO.replace(b"IN UNITS OF G", b"IN UNITS OF g")),
    "blank lines at the end": (EL_CENTRO, EL_CENTRO + b"\r\n\r\n"),
}


def test_latin_1_in_the_title():
    raw = EL_CENTRO.replace(b"El Centro Array", "Düzce Meteoroloji".encode("latin-1"))
    assert _read_at2(BytesIO(raw))[0].stats.station == "Düzce Meteoroloji #9"


def test_velocity_is_not_claimed():
    velocity = with_header([*OLD[:2], "VELOCITY TIME SERIES IN UNITS OF CM/S", OLD[3]])
    assert not _is_at2(BytesIO(velocity))


SAMPLES = "  .1000000E-02  .2000000E-02\n -.3000000E-02  .4000000E-02\n"
HEAD = "PEER NGA\nEvent, 1/2/1990, Station, 90\nACCELERATION TIME SERIES IN UNITS OF G\n"
GOOD = HEAD + "NPTS= 4, DT= .0100 SEC\n" + SAMPLES
BAD = {
    "empty": "",
    "blank": " \n\n",
    "no NPTS": HEAD + "4 samples\n" + SAMPLES,
    "no DT": HEAD + "NPTS= 4, TIME STEP .0100 SEC\n" + SAMPLES,
    "a sample less": GOOD.replace("NPTS= 4", "NPTS= 5"),
    "a sample more": GOOD.replace("NPTS= 4", "NPTS= 3"),
    "half a sample": GOOD.replace("NPTS= 4", "NPTS= 4.5"),
    "one sample": GOOD.replace("NPTS= 4", "NPTS= 1"),
    "NaN": GOOD.replace("-.3000000E-02", "NaN"),
    "beyond all numbers": GOOD.replace(".4000000E-02", "1E999"),
    "a decimal comma": GOOD.replace(".2000000E-02", "0,0020"),
    "cm/s/s": GOOD.replace("UNITS OF G", "UNITS OF CM/S/S"),
    "velocity": GOOD.replace("ACCELERATION", "VELOCITY").replace("OF G", "OF CM/S"),
    "no step": GOOD.replace(".0100", "0.0"),
    "a step backwards": GOOD.replace(".0100", "-.01"),
    "a web page": "<html><body>Please log in</body></html>",
    "columns": "time,acceleration\n0,0.1\n",
}


def test_a_file_that_is_cut_within_its_last_number_is_refused():
    """By three characters, which turn .9E-03 g into 9 g; one that lacks the last line end alone is whole."""
    whole = EL_CENTRO.rstrip()
    assert np.array_equal(_read_at2(BytesIO(whole))[0].data, _read_at2(BytesIO(EL_CENTRO))[0].data)
    for lost in (1, 4, 6):
        with pytest.raises(RecordError, match=r'ends within a line, with ".*the last number is cut'):
            _read_at2(BytesIO(whole[:-lost]))


def test_a_unit_given_for_a_file_that_states_its_own_is_told(tmp_path):
    """The file is believed, and the history of the motion says so."""
    (tmp_path / "x.at2").write_text(GOOD)
    given = read_file(tmp_path / "x.at2", unit="cm/s^2", dt=0.02)
    plain = read_file(tmp_path / "x.at2")
    assert np.array_equal(given.trace.data, plain.trace.data) and given.trace.stats.delta == 0.01
    assert given.units == f"{plain.units}; the file states its own, the unit and dt given went unused"


def test_a_folder_and_a_missing_file(tmp_path, says):
    (tmp_path / "RSN6.at2").write_text(GOOD)
    says(refusal(read_file, tmp_path), refusal(read_file, tmp_path / "RSN66.at2"))
    says(refusal(_read_at2, tmp_path / "none.at2"))


def test_a_pickle_is_never_read(tmp_path):
    """ObsPy's own detection would run the code in a file like this."""
    path = tmp_path / "x.mseed"
    path.write_bytes(b"\x80\x04\x95obspy.core.stream")
    assert "is a Python pickle, which can run code and is never read" in refusal(read_file, path, kind=RecordError)


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (gzip.compress(EL_CENTRO), "is compressed by gzip; unpack it, and take the file that comes out"),
        (EL_CENTRO.decode().encode("utf-16"), "save it as text in UTF-8, in Excel as the type CSV UTF-8"),
    ],
)
@pytest.mark.parametrize("suffix", [".AT2", ".csv", ".AT2.gz"])
def test_a_packed_file_and_one_in_utf_16_are_named_as_such(tmp_path, raw, words, suffix):
    path = tmp_path / f"x{suffix}"
    path.write_bytes(raw)
    with pytest.raises(RecordError, match=words):
        read_file(path)
