"""GeoNet V1A and V2A: the raw and the corrected file of one record, and the exact sentence for each fault."""

import gzip
import re
from io import BytesIO
from math import ceil
from pathlib import Path

import numpy as np
import obspy
import pytest
from scipy import signal

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import _text, read_components, read_file
from pounding_risk.motions.formats.geonet import _read_geonet
from pounding_risk.motions.read import read_motion

DATA = Path(__file__).parents[2] / "data" / "formats"
RAW, CORRECTED = (gzip.decompress((DATA / f"geonet-thz.{kind}.gz").read_bytes()) for kind in ("v1a", "v2a"))
HEADING = 26  # lines
BUFFER = obspy.UTCDateTime(2016, 11, 13, 11, 2, 33)  # the recorder's, in both files: minute 2, 33000 ms


def blocks(data):
    """Every component's heading, and its rows of acceleration, velocity and displacement, told apart by this test."""
    lines, at = data.decode().split("\n"), 0
    while at < len(lines) - 1:
        counts = [int(lines[at + 19][place : place + 8]) for place in (24, 32, 40)]
        heading, rows = lines[at : at + HEADING], []
        at += HEADING
        for count in counts:
            rows.append(lines[at : at + ceil(count / 10)])
            at += ceil(count / 10)
        yield heading, rows


def values(rows):
    return np.array([float(row[place : place + 8]) for row in rows for place in range(0, len(row), 8)])


def short(data, count=43):
    """The same file with fewer samples: every heading, and the first samples of each quantity."""
    lines = []
    for heading, rows in blocks(data):
        head = "\n".join(heading).replace("59200", f"{count:5d}").replace(" 8192", f"{count:5d}")
        step = 0.02 if b"Corrected" in data[:10] else 0.005
        head = re.sub(r"Duration \d+\.\d+", f"Duration {(count - 1) * step:.2f}", head)
        if step == 0.02:
            head = head.replace("     250     250", "       5       5")
        peak = np.abs(values(rows[0][: ceil(count / 10)])[:count]).max()
        lines.append(re.sub(r"(Acceleration:\s+peak)\s+\S+", rf"\g<1>{peak:9.1f}", head, flags=re.I))
        for block in rows:
            kept = block[: ceil(count / 10)]
            lines += [*kept[:-1], kept[-1][: 8 * (count - 10 * (len(kept) - 1))]] if kept else []
    return ("\n".join(lines) + "\n").encode()


SMALL_RAW, SMALL_CORRECTED = short(RAW), short(CORRECTED)


@pytest.mark.parametrize(
    ("data", "npts", "dt", "state", "band", "start"),
    [(RAW, 59200, 0.005, "raw", "H", BUFFER), (CORRECTED, 8192, 0.02, "processed", "B", BUFFER - 5.0)],
    ids=["V1A", "V2A"],
)
def test_a_file_gives_what_its_heading_promises(data, npts, dt, state, band, start):
    stream = _read_geonet(BytesIO(data))
    assert [trace.id for trace in stream] == [f"NZ.THZ.20.{band}N{letter}" for letter in "ENZ"]
    assert [trace.stats.record.component for trace in stream] == ["S90E", "N00E", "Up"]
    assert [trace.stats.record.azimuth for trace in stream] == [90.0, 0.0, None]
    for trace, (_, rows) in zip(stream, blocks(data), strict=True):
        assert (trace.stats.npts, trace.stats.delta, trace.stats.calib) == (npts, dt, 1.0)
        assert trace.stats.starttime == start
        assert trace.stats.record.state == state
        assert trace.data.dtype == np.float64
        assert np.array_equal(trace.data, values(rows[0]) * 0.001)


def test_the_heading_goes_to_the_statistics():
    stats = _read_geonet(BytesIO(CORRECTED))[1].stats
    assert stats.record == {
        "state": "processed",
        "units": "units: mm/s², times 0.001",
        "event": "5 km south-west of Waiau",
        "magnitude": 7.82,
        "date": "2016-11-13",
        "distance_km": 104.0,
        "station": "THZ",
        "component": "N00E",
        "azimuth": 0.0,
        "low_corner": 0.25,
        "high_corner": 24.5,
        "header_pga": pytest.approx(0.4672, rel=1e-15),
        "header_pgv": pytest.approx(0.07216, rel=1e-15),
        "header_pgd": pytest.approx(0.03576, rel=1e-15),
    }
    assert stats.geonet == {
        "title": "20161113_110256_THZ_20",
        "site": "Top House",
        "latitude": -41.762,
        "longitude": 172.905,
        "low_transition": (0.1, 0.25),
        "high_transition": (24.5, 25.5),
    }
    raw = _read_geonet(BytesIO(RAW))[1].stats.record
    assert (raw.low_corner, raw.high_corner, raw.header_pgv, raw.header_pgd) == (None, None, None, None)


@pytest.mark.parametrize("data", [RAW, CORRECTED], ids=["V1A", "V2A"])
def test_peaks_of_the_heading_are_those_of_the_samples(data):
    """PGA of our samples; PGV and PGD of the file's own velocity and displacement. To half the last digit printed."""
    for trace, (_, rows) in zip(_read_geonet(BytesIO(data)), blocks(data), strict=True):
        record = trace.stats.record
        assert np.abs(trace.data).max() == pytest.approx(record.header_pga, abs=0.05e-3)
        if record.state == "processed":
            assert np.abs(values(rows[1])).max() * 1e-3 == pytest.approx(record.header_pgv, abs=0.005e-3)
            assert np.abs(values(rows[2])).max() * 1e-3 == pytest.approx(record.header_pgd, abs=0.0005e-3)


def test_the_velocity_of_the_heading_comes_from_our_samples_too():
    """By trapezoids: these lose a little near the filter's 25 Hz (measured up to 0.34 %), so within 0.5 %."""
    for trace in _read_geonet(BytesIO(CORRECTED)):
        velocity = np.cumsum(trace.data) * trace.stats.delta - 0.5 * trace.data * trace.stats.delta
        assert np.abs(velocity).max() == pytest.approx(trace.stats.record.header_pgv, rel=5e-3)


@pytest.mark.parametrize("data", [RAW, CORRECTED], ids=["V1A", "V2A"])
def test_peaks_are_when_the_heading_says(data):
    """Its times count from the start of the buffer, five seconds after the first sample of a corrected record."""
    for trace, (heading, _) in zip(_read_geonet(BytesIO(data)), blocks(data), strict=True):
        told = float(re.search(r"at\s+(\S+) s", heading[13])[1])
        peak = trace.stats.starttime + float(np.abs(trace.data).argmax()) * trace.stats.delta
        assert peak - BUFFER == pytest.approx(told, abs=0.0051)  # half of the last digit, rounded up or down


def test_the_raw_and_the_corrected_record_are_one_at_the_same_times():
    """The raw one, filtered as the heading says of the corrected one, correlates best with it where it lies.

    Butterworth's filter is not the agency's, so not to 1; a start wrong by 0.02 s gives 0.96 at most, by 5 s 0.06.
    """
    for raw, corrected in zip(_read_geonet(BytesIO(RAW)), _read_geonet(BytesIO(CORRECTED)), strict=True):
        sos = signal.butter(4, [0.175, 24.9], "band", fs=200.0, output="sos")
        filtered = signal.sosfiltfilt(sos, raw.data - raw.data.mean())
        times = corrected.times() + (corrected.stats.starttime - raw.stats.starttime)
        known = times >= 0.0
        there = np.interp(times[known], raw.times(), filtered)
        assert np.corrcoef(there, corrected.data[known])[0, 1] > 0.998  # measured 0.9986 to 0.9990


def test_one_component_is_named_after_the_file(tmp_path):
    path = tmp_path / "thz.V2A"
    path.write_bytes(CORRECTED)
    assert [each.component for each in read_components(path)] == ["S90E", "N00E", "Up"]
    with pytest.raises(RecordError, match=re.escape('holds 3 components ("S90E", "N00E", "Up"), one is needed')):
        read_file(path)
    motion = read_motion(f"{path}#N00E")
    assert motion.pga == pytest.approx(0.4672, abs=0.05e-3)
    assert motion.record["azimuth"] == 0.0
    assert motion.record["state"] == "processed"


SPELLINGS = {
    "CR LF": (SMALL_CORRECTED, SMALL_CORRECTED.replace(b"\n", b"\r\n")),
    "blank lines at the end": (SMALL_CORRECTED, SMALL_CORRECTED + b"\n\n"),
    "capitals": (SMALL_CORRECTED, SMALL_CORRECTED.replace(b"mm/s/s", b"MM/S/S")),
}


def test_numbers_that_touch_are_told_apart_by_their_columns():
    """As in the record of 3 g at Te Mara, whose 31541.5 mm/s² leave no blank beside a negative number."""
    first = SMALL_RAW.split(b"\n")[HEADING]
    touching = SMALL_RAW.replace(first, b"-11026.2-11025.9" + first[16:], 1)
    touching = re.sub(rb"(Acceleration:\s+Peak\s+)\S+", rb"\g<1>11026.2", touching, count=1)
    assert list(_read_geonet(BytesIO(touching))[0].data[:3]) == [-11026.2 * 0.001, -11025.9 * 0.001, -0.4 * 0.001]


def test_columns_read_at_once_are_those_read_one_by_one(monkeypatch):
    """Numbers of full columns take a short way; the other one, which names faults, gives the same bits."""
    quick = _read_geonet(BytesIO(CORRECTED))
    monkeypatch.setattr(_text.np, "frombuffer", lambda *_, **__: np.array(["no number"]))
    for trace, other in zip(_read_geonet(BytesIO(CORRECTED)), quick, strict=True):
        assert np.array_equal(trace.data, other.data)


@pytest.mark.parametrize(
    ("label", "bearing", "azimuth", "code"),
    [("N28W", 332, 332.0, "1"), ("S62W", 242, 242.0, "1"), ("S74E", 106, 106.0, "1"), ("N03E", 3, 3.0, "N")],
)
def test_directions(label, bearing, azimuth, code):
    """The names are those of real files (WTMC, WPWS), whose bearings their headings give beside them."""
    data = SMALL_RAW.replace(b"Component S90E", f"Component {label}".encode())
    data = data.replace(b"      90      90     175", f"      90{bearing:8d}     175".encode(), 1)
    if code == "N":
        data = data.replace(b"Component N00E", b"Component N87W")
        data = data.replace(b"      90       0     175", b"      90     273     175", 1)
    trace = _read_geonet(BytesIO(data))[0]
    assert trace.stats.record.azimuth == azimuth
    assert trace.stats.channel == "HN1"  # only an N and an E together are called so


BAD = [
    (b"", "x.V1A: is empty (0 bytes); fetch the record again"),
    (
        SMALL_RAW[:900],
        "x.V1A: ends with line 19, before the end of the heading due from line 1 on; a GeoNet file has 3 components: "
        "the file is cut short, fetch it again",
    ),
    (
        b"\n".join(SMALL_RAW.split(b"\n")[:31]),
        "x.V1A: ends with line 31, before the end of the heading due from line 32 on; a GeoNet file has 3 components: "
        "the file is cut short, fetch it again",
    ),
    (
        b"\n".join(SMALL_RAW.split(b"\n")[:92]),
        "x.V1A, acceleration from line 89 on: the header promises 43 samples, 40 found; the file is cut short: fetch "
        "it again",
    ),
    (
        SMALL_RAW.replace(b"Number of points     43", b"Number of points     44", 1),
        "x.V1A, line 10: the text promises 44 points, the numbers of line 20 43; fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"Duration 0.21", b"Duration 0.42", 1),
        "x.V1A, line 10: 43 samples every 0.005 s last 0.215 s, the text says 0.42 s; correct the wrong one, or fetch "
        "the file again",
    ),
    (
        SMALL_RAW.replace(b"1.00 mm/s/s", b"0.10 mm/s/s", 1),
        'x.V1A, line 11: the unit of the samples is stated by "Raw readings in units of 0.10 mm/s/s ..."; a GeoNet '
        "file holds acceleration in 1.00 mm/s/s: convert the samples to it, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"0.4 mm/s/s", b"0.4 cm/s/s", 1),
        'x.V1A, line 14: the unit of the samples is stated by "Acceleration:  Peak      0.4 cm/s/s a..."; a GeoNet '
        "file holds acceleration in 1.00 mm/s/s: convert the samples to it, or fetch the file again",
    ),
    (
        SMALL_CORRECTED.replace(b"Acceleration:  peak", b"Acceleration", 1),
        'x.V1A, line 14: found "Acceleration      0.0 mm/s/s at 115.3...", and no unit of the samples in the heading; '
        'a GeoNet file says "Acceleration: Peak 399.7 mm/s/s at 115.37 s": restore that line, or fetch the file again',
    ),
    (
        SMALL_RAW.replace(b"Component N00E", b"Direction N00E"),
        'x.V1A, line 44: found "Direction N00E" where a GeoNet file has a line such as "Component N28W"; restore that '
        "line, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"Component N00E", b"Component S90E"),
        "x.V1A, line 44: two components are called S90E, so that one of them has a wrong direction; find out which, "
        "and correct its name and its bearing",
    ),
    (
        SMALL_RAW.replace(b"Component N00E", b"Component N30W"),
        "x.V1A, line 44: the component N30W points to 330 degrees, its bearing in line 50 is 0; find out which is "
        "right, and correct the other",
    ),
    (
        SMALL_RAW.replace(b"  0.0050  0.0050", b"  0.0050  0.0000", 1),
        'x.V1A, line 23: the time step (the sixth number) is "0"; the time step must be a number of seconds greater '
        "than 0, from 1e-06 to 1 s: restore that line, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"   200.0    0.70", b"   200.0     nan", 1),
        'x.V1A, line 21: "200.0     nan    0.00   0.000  0.0000..." is not a line of 10 numbers in columns of 8 '
        "characters; restore that line of the heading, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"    2016      11      13", b"    2016    11.5      13", 1),
        "x.V1A, line 17: has 11.5, where all numbers are whole; restore that line of the heading, or fetch the file "
        "again",
    ),
    (
        SMALL_RAW.replace(b"    2016      11      13      11", b"    2016      14      13      11", 1),
        "x.V1A, lines 17 to 20: the heading's numbers give the time 2016 14 13 0 0 0 (year, month, day, hour, minute, "
        "second), which is none; restore those lines, or fetch the file again",
    ),
    (
        SMALL_CORRECTED.replace(b"       5       5      43", b"      50       5      43", 1),
        "x.V1A, line 20: 43 samples of velocity, 43 of displacement and 50 prepended ones do not go with 43 of "
        "acceleration; restore that line, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"    -0.4    -0.4", b"    -0.4     NaN", 1),
        'x.V1A, line 27: "NaN" is not a finite number; the samples after the header must be plain numbers such as '
        "-11026.2: repair that line, or fetch the file again",
    ),
    (
        SMALL_RAW.replace(b"    -0.4    -0.4", b"    -0.4", 1),
        'x.V1A, line 27: found "-0.4    -0.4    -0.4    -0.4    -0.4 ..." among the samples of acceleration, where 10 '
        "numbers of 8 characters each are due; restore that line, or fetch the file again",
    ),
    (
        SMALL_RAW + b"    -0.4\n",
        'x.V1A, line 94: "-0.4" follows the third component, with which a GeoNet file ends; remove it, or fetch the '
        "file again",
    ),
]
