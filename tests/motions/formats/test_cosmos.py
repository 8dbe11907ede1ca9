"""COSMOS: real files of every stage, every way to hand over a file, and the exact sentence for each fault."""

import gzip
import re
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import read_components, read_file
from pounding_risk.motions.formats.cosmos import _read_cosmos
from pounding_risk.motions.read import read_motion

G = 9.80665
DATA = Path(__file__).parents[2] / "data" / "formats"
FILES = {path.name: path for path in DATA.glob("cosmos-*.gz")}
RAW, CORRECTED, COUNTS, EXAMPLE = (
    gzip.decompress(FILES[f"cosmos-{name}.gz"].read_bytes())
    for name in ("pomona.v1c", "bremner.v2c", "bayview.v0c", "yucaipa.v1")
)


def read(data, **more):
    return _read_cosmos(BytesIO(data), **more)


def peak(trace):
    return np.abs(trace.data).max()


@pytest.mark.parametrize(
    ("data", "ids", "components", "npts", "dt", "state"),
    [
        (RAW, ["CE.23837..HNN", "CE.23837..HNZ", "CE.23837..HNE"], ["360", "Up", "90"], 13400, 0.005, "raw"),
        (CORRECTED, ["AK.BMR..BNZ"], ["BNZ"], 42000, 0.005, "processed"),
        (COUNTS, ["NP.1795..HNE", "NP.1795..HNN", "NP.1795..HNZ"], ["90", "360", "Up"], 20000, 0.005, "raw"),
        (EXAMPLE, ["CE.J2236..HN"], ["340"], 7000, 0.01, "processed"),
    ],
    ids=["V1", "V2", "V0", "example"],
)
def test_what_the_files_hold(data, ids, components, npts, dt, state):
    stream = read(data)
    assert [trace.id for trace in stream] == ids
    assert [trace.stats.record.component for trace in stream] == components
    for trace in stream:
        assert (trace.stats.npts, trace.stats.delta, trace.stats.calib) == (npts, dt, 1.0)
        assert trace.data.dtype == np.float64
        assert trace.stats.record.state == state


def test_the_samples_are_those_of_the_files_in_metres():
    """The first and the last number of a channel, copied out of the file."""
    north, _, east = read(RAW)
    assert (north.data[0], east.data[-1]) == (pytest.approx(-0.000023 * G, rel=1e-12), pytest.approx(last(RAW) * G))
    assert read(CORRECTED)[0].data[[0, -1]] == pytest.approx([3.437285e-06, last(CORRECTED) * 0.01], rel=1e-12)
    assert read(EXAMPLE)[0].data[[0, -1]] == pytest.approx([-1e-7, -3e-7], rel=1e-12)


def last(data):
    """The last number before the last line of a file."""
    return float(data.decode().strip().splitlines()[-2].split()[-1])


def test_header_peaks_come_out_of_the_samples():
    """To the last digit where the header has as many as the samples; the example's has three decimals of cm/s²."""
    for data, tolerance in ((RAW, 1e-12), (CORRECTED, 1e-12), (EXAMPLE, 0.0005 / 161.9)):
        for trace in read(data):
            assert peak(trace) == pytest.approx(trace.stats.record.header_pga, rel=tolerance)
    pga = [0.105433, 0.048757, 0.059022]  # g, of the file's real numbers; its text says .105, .049 and .059
    assert [peak(trace) / G for trace in read(RAW)] == pytest.approx(pga, rel=1e-9)


def test_counts_become_acceleration_by_the_header():
    """The sensor's full scale, 3.43 g at 4.116 V, and the header's peak and mean of the counts, each channel's own."""
    per_count = 3.43 * G / (4.116 / 0.794729e-6)
    found = [header_numbers(COUNTS, channel, (64, 66)) for channel in range(3)]
    assert found[0] == [985881.0, -982511.903150]
    for trace, (largest, mean) in zip(read(COUNTS), found, strict=True):
        # The header's mean is rounded to six decimals of a count.
        assert peak(trace) == pytest.approx(largest * per_count, rel=1e-12)
        assert trace.data.mean() == pytest.approx(mean * per_count, rel=1e-9)
        assert trace.stats.record.header_pga is None
        assert "counts, times 0.794729 µV, over gain 1 and 1.2 V/g, times 9.80665 m/s²" in trace.stats.record.units


def header_numbers(data, channel, numbers):
    """Real numbers of a channel's header, by this test's own reading."""
    block = re.split(rb"Real-header values follow[^\n]*\n", data)[channel + 1]
    values = block.split(b"Comment")[0].replace(b"-", b" -").split()
    return [float(values[number - 1]) for number in numbers]


def test_the_header_goes_to_the_statistics():
    stats = read(CORRECTED)[0].stats
    assert abs(stats.starttime - obspy.UTCDateTime(2018, 11, 30, 17, 29, 39, 137490)) < 1e-6
    record = stats.record
    assert record.event == "Record of Point MacKenzie Earthquake of Fri Nov 30, 2018 17:29 UTC"
    assert (record.magnitude, record.distance_km, record.date) == (7.0, 290.060822, "2018-11-30")
    assert (record.station, record.azimuth) == ("Bremner River, AK, USA", None)
    assert (record.low_corner, record.high_corner) == (0.03, 20.0)
    assert (stats.cosmos.stage, stats.cosmos.latitude) == (2, 60.9677)
    north = read(RAW)[0].stats.record
    assert (north.azimuth, north.magnitude, north.low_corner) == (360.0, None, None)
    assert north.units == "units: g, times 9.80665 m/s²"


def test_a_head_alone_needs_the_lines_of_its_samples():
    with pytest.raises(RecordError, match="ends at line 1000, where its samples should be"):
        read(b"\n".join(RAW.split(b"\n")[:1000]), headonly=True)


def test_a_component_is_named_after_the_file(tmp_path):
    path = tmp_path / "CE23837.v1c"
    path.write_bytes(RAW)
    assert [each.component for each in read_components(path)] == ["360", "Up", "90"]
    motion = read_motion(f"{path}#90")
    assert motion.record["station"] == "Pomona - Orange Grove & Fairplex"
    assert motion.record["state"] == "raw"


# The example with sixteen samples.
HEAD = (
    EXAMPLE[: EXAMPLE.index(b"   -.00001")]
    .decode()
    .replace("   7000  accel", "     16  accel")
    .replace("70.000000", " 0.160000")
    .replace("-161.962000", "   0.000200")
)
SAMPLES = (
    "   -.00001    .00013    .00000    .00014    .00000    .00013    .00003    .00019\n"
    "    .00001    .00011   -.00002    .00018    .00011    .00020    .00000    .00009\n"
)
END = "/&  ----------  End of data for channel  1  ----------\n"
GOOD = HEAD + SAMPLES + END
PROMISE = "     16  acceleration pts, approx   70 secs, units=cm/sec2(04),Format=(8F10.5)\n"


def changed(*pairs, base=GOOD):
    """The good text with words replaced, each of which is in it."""
    for old, new in pairs:
        assert old in base, old
        base = base.replace(old, new, 1)
    return base


CODES = "       2       1       4     120       1"


@pytest.mark.parametrize(
    ("code", "metres"),
    [(2, G), (4, 0.01), (7, 0.0254), (10, 0.01), (11, G / 1000), (12, G / 1e6)],
    ids=["g", "cm/s²", "in/s²", "gal", "mg", "µg"],
)
def test_units_of_acceleration(code, metres):
    text = changed((CODES, f"       2       1{code:8d}     120       1"), ("(04)", f"({code:02d})"))
    assert read(text.encode())[0].data[1] == pytest.approx(0.00013 * metres, rel=1e-12)


SPELLINGS = {
    "CRLF": (GOOD, GOOD.replace("\n", "\r\n")),
    "no last line": (GOOD, HEAD + SAMPLES),
    "blank lines": (GOOD, GOOD + "\n   \n"),
    "scaled": (GOOD, GOOD.replace("(8F10.5)", "(8(1PE10.3))")),
    "stage and quantity in words only": (GOOD, changed((CODES, "    -999    -999       4     120       1"))),
    "no code": (GOOD, changed(("units=cm/sec2(04)", "units=cm/s^2"))),
    "one column": (
        GOOD,
        HEAD.replace("(8F10.5)", "(1E15.6)") + "".join(f"{float(word):15.6E}\n" for word in SAMPLES.split()) + END,
    ),
}


def test_velocity_and_displacement_beside_acceleration_are_left_out():
    more = PROMISE.replace("acceleration", "velocity    ").replace("cm/sec2(04)", "cm/sec (05)") + SAMPLES
    beside = HEAD + SAMPLES + more + more.replace("velocity    ", "displacement") + END
    own = changed((CODES, "       2       2       5     120       1"), ("acceleration pts", "velocity pts"))
    for text in (beside, GOOD + own, own + GOOD):
        stream = read(text.encode())
        assert len(stream) == 1
        assert np.array_equal(stream[0].data, read(GOOD.encode())[0].data)


def test_components_that_share_an_orientation_are_counted(tmp_path):
    path = tmp_path / "building.v2c"
    path.write_text(GOOD + changed(("    .00013", "    .00033"), ("   0.000200", "   0.000330")))
    assert [each.component for each in read_components(path)] == ["340 channel 1", "340 channel 2"]
    assert read_file(path, "340 channel 2").trace.data[1] == pytest.approx(0.00033e-2)


@pytest.mark.parametrize(
    ("orientation", "words", "component", "azimuth"),
    [
        ("400", "1: Up ", "Up", None),
        ("-999", "1: 27 deg ", "27", 27.0),
        ("-999", "1: Tran ", "Tran", None),
        ("  90", "1: 340 deg ", "90", 90.0),
    ],
)
def test_orientations(orientation, words, component, azimuth):
    text = changed(("    1889     340", f"    1889{orientation:>8s}"), ("1: 340 deg ", words))
    record = read(text.encode())[0].stats.record
    assert (record.component, record.azimuth) == (component, azimuth)


def test_no_time_where_the_header_has_none():
    stats = read(changed(("       1    2005", "       1    -999")).encode())[0].stats
    assert (stats.starttime, stats.record.date, stats.record.timed) == (obspy.UTCDateTime(0), "", False)
    to_the_minute = changed(("  -999.000000  -999.000000     4.400000", "  -999.000000  -999.000000  -999.000000"))
    stats = read(to_the_minute.encode())[0].stats
    assert (stats.starttime, stats.record.timed) == (obspy.UTCDateTime(2005, 6, 16, 20, 53), False)
    assert read(GOOD.encode())[0].stats.record.timed


BAD = [
    ("", "x.v2c: is empty (0 bytes); fetch the record again"),
    (
        "Corrected acceleration\n1 2 3\n",
        'x.v2c, line 1: "Corrected acceleration" is no first line of a COSMOS channel, which says "(Format v01.20 with '
        '13 text lines)"; check that this is one, or fetch the file again',
    ),
    (
        changed(("v01.20", "v01.00")),
        "x.v2c, line 1: says version 01.00 with 13 text lines; version 01.20 with at least 13 is read: fetch the "
        "record in that version",
    ),
    (
        changed(("100 Integer-header", "100 Whole-header")),
        'x.v2c, line 14: "100 Whole-header values follow on  10..." should be "100 Integer-header values follow on ... '
        'lines, Format= (...)"; restore that line, or fetch the file again',
    ),
    (
        changed(("100 Real-header", "99 Real-header")),
        "x.v2c, line 25: promises 99 values of the real header; the format has 100: fetch the file again",
    ),
    (
        changed(("  -999.000000  -999.000000  -999.000000  -999.000000\n", "  -999.000000  -999.000000\n")),
        "x.v2c, line 25: 100 values of the real header should follow, 98 found; the file is cut short: fetch it again",
    ),
    (
        changed(("    34.046000", "      unknown")),
        'x.v2c, line 26: "unknown" is not a finite number; the values of the real header must be plain numbers such as '
        "-999.000000: repair that line, or fetch the file again",
    ),
    (
        changed(("  2 Comment line(s) follow", "  2 Comments")),
        'x.v2c, line 43: "2 Comments, each starting with a "|":" should be "... Comment line(s) follow"; restore that '
        "line, or fetch the file again",
    ),
    (
        changed(("  16  acceleration pts", "  16  acceleration points")),
        'x.v2c, line 46: "16  acceleration points, approx   70 ..." does not say what follows, as "7000 acceleration '
        'pts, approx 70 secs, units=cm/sec2(04), Format=(8F10.5)" does; restore that line, or fetch the file again',
    ),
    (
        changed(("     16  accel", "      1  accel")),
        "x.v2c, line 46: promises 1 samples; a record needs at least 2: fetch the file again",
    ),
    (
        changed(("(04)", "(02)")),
        "x.v2c, line 46: says unit 2, the integer header 4; correct the wrong one, or fetch the file again",
    ),
    (
        changed((CODES, "       2       1       5     120       1"), ("(04)", "(05)")),
        "x.v2c, line 14: the third whole number, the unit, is 5; acceleration is read in 2 (g), 4 (cm/s²), 7 (in/s²), "
        "10 (gal), 11 (mg), 12 (µg): convert the samples, or take another file of this record",
    ),
    (
        changed((CODES, "       2       2       5     120       1"), ("acceleration pts", "velocity pts")),
        "x.v2c, line 14: holds velocity, no acceleration; take the file of acceleration of this record",
    ),
    (
        changed((CODES, "       2      10      23     120       1"), ("(04)", "(23)")),
        "x.v2c, line 14: holds angular acceleration, no acceleration; take the file of acceleration of this record",
    ),
    (
        changed((CODES, "       3       1       4     120       1")),
        "x.v2c, line 14: the first whole number, the stage of processing, is 3; 0 (counts), 1 (uncorrected) and 2 "
        "(corrected acceleration) are read: take such a file of this record",
    ),
    (
        changed((CODES, "       0       1      50     120       1"), ("(04)", "(50)"), ("220.00000", "200.00000")),
        "x.v2c, line 14: holds counts, and its headers do not say for certain what a count is (unit 50, bit 123.45 µV, "
        "gain 1, sensitivity 200 V/g, full scale 100 V at 2 g); take the V1 or V2 file of this record, which holds "
        "acceleration",
    ),
    (
        changed(("  -999.000000    10.000000", "  -999.000000  -999.000000")),
        'x.v2c, line 14: the 62nd real number is "-999 ms"; the time step must be a number of seconds greater than 0, '
        "from 1e-06 to 1 s: restore that line, or fetch the file again",
    ),
    (
        changed(("  -999.000000    10.000000", "  -999.000000    20.000000")),
        "x.v2c, line 14: 16 samples every 0.02 s last 0.32 s, the 63rd real number says 0.16 s; correct the wrong one, "
        "or fetch the file again",
    ),
    (
        changed(("     167       6      16", "     167      13      16")),
        "x.v2c, line 14: the start, year month day hour minute, is 2005 13 16 20 53; correct these whole numbers (40, "
        "42 to 45), or write -999 where they are not known",
    ),
    (
        HEAD + SAMPLES.splitlines(keepends=True)[0] + END,
        "x.v2c, line 46: 16 samples should follow, 8 found; the file is cut short: fetch it again",
    ),
    (
        HEAD + SAMPLES[:-11] + "\n" + END,
        "x.v2c, line 46: 16 samples should follow, 15 found; the file is cut short: fetch it again",
    ),
    (
        HEAD.replace("     16  accel", "     15  accel") + SAMPLES + END,
        "x.v2c, line 46: 15 samples should follow, 16 found; correct that number, or fetch the file again",
    ),
    (
        HEAD + SAMPLES * 2 + END,
        'x.v2c, line 49: "-.00001    .00013    .00000    .00014..." follows the last promised sample, where '
        "End-of-data should be; correct the number of samples, or fetch the file again",
    ),
    (
        changed(("    .00013", "    .000-3")),
        'x.v2c, line 47: ".000-3" is not a finite number; the samples must be plain numbers such as -.12345: repair '
        "that line, or fetch the file again",
    ),
    (
        changed(("    .00013", "       NaN")),
        'x.v2c, line 47: "NaN" is not a finite number; the samples must be plain numbers such as -.12345: repair that '
        "line, or fetch the file again",
    ),
    (
        changed((".00019\n", ".00019 .00002\n")),
        'x.v2c, line 47: has ".00002" after its 8 columns of 10 characters; repair that line, or fetch the file again',
    ),
    (
        "\n".join(GOOD.split("\n")[:5]),
        "x.v2c: ends at line 5, where the lines of text of its header should be; the file is cut short: fetch it again",
    ),
    (
        "\n".join(GOOD.split("\n")[:45]),
        "x.v2c: ends at line 45, where the line that says how many samples follow should be; the file is cut short: "
        "fetch it again",
    ),
]


def test_the_good_text_is_good():
    expected = np.array([float(word) for word in SAMPLES.split()]) * 0.01
    assert np.array_equal(read(GOOD.encode())[0].data, expected)
