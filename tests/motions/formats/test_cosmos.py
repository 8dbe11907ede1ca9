"""COSMOS: real files of every stage, what channels may hold, and texts with faults."""

import re
from functools import partial

import numpy as np
import obspy
import pytest
import real_files
from real_files import G, read, real

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import read_components, read_file
from pounding_risk.motions.read import read_motion

RAW, COUNTS, EXAMPLE = (real(f"cosmos-{name}") for name in ("pomona.v1c", "bayview.v0c", "yucaipa.v1"))


def peak(trace):
    return np.abs(trace.data).max()


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
changed = partial(real_files.changed, GOOD)


CODES = "       2       1       4     120       1"


@pytest.mark.parametrize(
    ("code", "metres"),
    [(2, G), (4, 0.01), (7, 0.0254), (10, 0.01), (11, G / 1000), (12, G / 1e6)],
    ids=["g", "cm/s²", "in/s²", "gal", "mg", "µg"],
)
def test_units_of_acceleration(code, metres):
    text = changed((CODES, f"       2       1{code:8d}     120       1"), ("(04)", f"({code:02d})"))
    assert read(text)[0].data[1] == pytest.approx(0.00013 * metres, rel=1e-12)


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
        stream = read(text)
        assert len(stream) == 1
        assert np.array_equal(stream[0].data, read(GOOD)[0].data)


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
    record = read(text)[0].stats.record
    assert (record.component, record.azimuth) == (component, azimuth)


def test_no_time_where_the_header_has_none():
    stats = read(changed(("       1    2005", "       1    -999")))[0].stats
    assert (stats.starttime, stats.record.date, stats.record.timed) == (obspy.UTCDateTime(0), "", False)
    to_the_minute = changed(("  -999.000000  -999.000000     4.400000", "  -999.000000  -999.000000  -999.000000"))
    stats = read(to_the_minute)[0].stats
    assert (stats.starttime, stats.record.timed) == (obspy.UTCDateTime(2005, 6, 16, 20, 53), False)
    assert read(GOOD)[0].stats.record.timed


BAD = {
    "empty": "",
    "no first line of a channel": "Corrected acceleration\n1 2 3\n",
    "another version": changed(("v01.20", "v01.00")),
    "no whole numbers": changed(("100 Integer-header", "100 Whole-header")),
    "99 real numbers promised": changed(("100 Real-header", "99 Real-header")),
    "98 real numbers found": changed(
        ("  -999.000000  -999.000000  -999.000000  -999.000000\n", "  -999.000000  -999.000000\n")
    ),
    "a real number in words": changed(("    34.046000", "      unknown")),
    "no line of comments": changed(("  2 Comment line(s) follow", "  2 Comments")),
    "a line that says not what follows": changed(("  16  acceleration pts", "  16  acceleration points")),
    "one sample": changed(("     16  accel", "      1  accel")),
    "two units": changed(("(04)", "(02)")),
    "a unit of velocity": changed((CODES, "       2       1       5     120       1"), ("(04)", "(05)")),
    "velocity": changed((CODES, "       2       2       5     120       1"), ("acceleration pts", "velocity pts")),
    "angular acceleration": changed((CODES, "       2      10      23     120       1"), ("(04)", "(23)")),
    "response spectra": changed((CODES, "       3       1       4     120       1")),
    "counts of an unknown sensor": changed(
        (CODES, "       0       1      50     120       1"), ("(04)", "(50)"), ("220.00000", "200.00000")
    ),
    "no time step": changed(("  -999.000000    10.000000", "  -999.000000  -999.000000")),
    "another duration": changed(("  -999.000000    10.000000", "  -999.000000    20.000000")),
    "month 13": changed(("     167       6      16", "     167      13      16")),
    "half of the samples": HEAD + SAMPLES.splitlines(keepends=True)[0] + END,
    "a sample less": HEAD + SAMPLES[:-11] + "\n" + END,
    "a sample more": HEAD.replace("     16  accel", "     15  accel") + SAMPLES + END,
    "samples twice": HEAD + SAMPLES * 2 + END,
    "a sign in a number": changed(("    .00013", "    .000-3")),
    "NaN": changed(("    .00013", "       NaN")),
    "a ninth column": changed((".00019\n", ".00019 .00002\n")),
    "cut in the text": "\n".join(GOOD.split("\n")[:5]),
    "cut before the samples": "\n".join(GOOD.split("\n")[:45]),
}
