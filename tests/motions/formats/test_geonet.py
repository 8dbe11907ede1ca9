"""GeoNet V1A and V2A: the raw and the corrected file of one record, and texts with faults."""

import re
from math import ceil

import numpy as np
import obspy
import pytest
from real_files import read, real
from scipy import signal

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import _text, read_components, read_file
from pounding_risk.motions.read import read_motion

RAW, CORRECTED = (real(f"geonet-thz.{kind}") for kind in ("v1a", "v2a"))
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


@pytest.mark.parametrize("data", [RAW, CORRECTED], ids=["V1A", "V2A"])
def test_samples_are_those_of_the_columns_and_peak_as_and_when_the_heading_says(data):
    """PGV and PGD of the file's own velocity and displacement, to half the last digit printed.

    Times of peaks count from the start of the buffer, five seconds after the first sample of a corrected record.
    """
    for trace, (heading, rows) in zip(read(data), blocks(data), strict=True):
        assert np.array_equal(trace.data, values(rows[0]) * 0.001)
        stated = float(re.search(r"at\s+(\S+) s", heading[13])[1])
        peak = trace.stats.starttime + float(np.abs(trace.data).argmax()) * trace.stats.delta
        assert peak - BUFFER == pytest.approx(stated, abs=0.0051)  # half of the last digit, rounded up or down
        record = trace.stats.record
        if record.state == "processed":
            assert np.abs(values(rows[1])).max() * 1e-3 == pytest.approx(record.header_pgv, abs=0.005e-3)
            assert np.abs(values(rows[2])).max() * 1e-3 == pytest.approx(record.header_pgd, abs=0.0005e-3)


def test_the_raw_and_the_corrected_record_are_one_at_the_same_times():
    """The raw one, filtered as the heading says of the corrected one, correlates best with it where it lies.

    Butterworth's filter is not the agency's, so not to 1; a start wrong by 0.02 s gives 0.96 at most, by 5 s 0.06.
    """
    for raw, corrected in zip(read(RAW), read(CORRECTED), strict=True):
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
    assert list(read(touching)[0].data[:3]) == [-11026.2 * 0.001, -11025.9 * 0.001, -0.4 * 0.001]


def test_columns_read_at_once_are_those_read_one_by_one(monkeypatch):
    """Numbers of full columns take a short way; the other one, which names faults, gives the same bits."""
    quick = read(CORRECTED)
    monkeypatch.setattr(_text.np, "frombuffer", lambda *_, **__: np.array(["no number"]))
    for trace, other in zip(read(CORRECTED), quick, strict=True):
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
    trace = read(data)[0]
    assert trace.stats.record.azimuth == azimuth
    assert trace.stats.channel == "HN1"  # only an N and an E together are called so


BAD = {
    "empty": b"",
    "cut in the first heading": SMALL_RAW[:900],
    "cut in the second heading": b"\n".join(SMALL_RAW.split(b"\n")[:31]),
    "cut in the samples": b"\n".join(SMALL_RAW.split(b"\n")[:92]),
    "two numbers of samples": SMALL_RAW.replace(b"Number of points     43", b"Number of points     44", 1),
    "two durations": SMALL_RAW.replace(b"Duration 0.21", b"Duration 0.42", 1),
    "another unit of the samples": SMALL_RAW.replace(b"1.00 mm/s/s", b"0.10 mm/s/s", 1),
    "another unit of the peak": SMALL_RAW.replace(b"0.4 mm/s/s", b"0.4 cm/s/s", 1),
    "no peak": SMALL_CORRECTED.replace(b"Acceleration:  peak", b"Acceleration", 1),
    "no component": SMALL_RAW.replace(b"Component N00E", b"Direction N00E"),
    "a component twice": SMALL_RAW.replace(b"Component N00E", b"Component S90E"),
    "two bearings": SMALL_RAW.replace(b"Component N00E", b"Component N30W"),
    "no step": SMALL_RAW.replace(b"  0.0050  0.0050", b"  0.0050  0.0000", 1),
    "nan in the heading": SMALL_RAW.replace(b"   200.0    0.70", b"   200.0     nan", 1),
    "half a month": SMALL_RAW.replace(b"    2016      11      13", b"    2016    11.5      13", 1),
    "month 14": SMALL_RAW.replace(b"    2016      11      13      11", b"    2016      14      13      11", 1),
    "more prepended than there are": SMALL_CORRECTED.replace(
        b"       5       5      43", b"      50       5      43", 1
    ),
    "NaN": SMALL_RAW.replace(b"    -0.4    -0.4", b"    -0.4     NaN", 1),
    "a sample less": SMALL_RAW.replace(b"    -0.4    -0.4", b"    -0.4", 1),
    "a line more": SMALL_RAW + b"    -0.4\n",
}
