"""CSMIP volumes 1 and 2: real files of four decades, records of film, and the exact sentence for each fault."""

import gzip
import re
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest
from scipy.integrate import cumulative_trapezoid

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import read_components
from pounding_risk.motions.formats.cosmos import _read_cosmos
from pounding_risk.motions.formats.csmip import _read_csmip

G = 9.80665
DATA = Path(__file__).parents[2] / "data" / "formats"
FILES = {path.name: path for path in DATA.glob("csmip-*.gz")}
POMONA, HESPERIA, PARKFIELD = (
    gzip.decompress(FILES[f"csmip-{name}.gz"].read_bytes()) for name in ("pomona.v1", "hesperia.raw", "parkfield.v2")
)


def read(data, **more):
    return _read_csmip(BytesIO(data), **more)


def peak(values):
    return np.abs(values).max()


@pytest.mark.parametrize(
    ("data", "ids", "components", "npts", "dt", "state", "start"),
    [
        (
            POMONA,
            ["CE.23837..HNN", "CE.23837..HNZ", "CE.23837..HNE"],
            ["360", "Up", "90"],
            [13400] * 3,
            0.005,
            "raw",
            (2018, 8, 29, 2, 33),
        ),
        (
            HESPERIA,
            ["CE.23583..HNE", "CE.23583..HNZ", "CE.23583..HN"],
            ["90", "Up", "180"],
            [12001] * 3,
            0.005,
            "raw",
            (1992, 6, 28, 15, 5, 37, 400000),
        ),
        # 16:42:48.2 PDT, 9.7 s after the origin at 23:42:38.5 UTC that the same header names.
        (
            PARKFIELD,
            ["CE.36456..BNE", "CE.36456..BNZ", "CE.36456..BNN"],
            ["90", "Up", "0"],
            [3251, 3250, 3250],
            0.02,
            "processed",
            (1983, 5, 2, 23, 42, 48, 200000),
        ),
    ],
    ids=["V1", "V1 of 1992", "V2"],
)
def test_what_the_files_hold(data, ids, components, npts, dt, state, start):
    stream = read(data)
    assert [trace.id for trace in stream] == ids
    assert [trace.stats.record.component for trace in stream] == components
    assert [trace.stats.npts for trace in stream] == npts
    for trace in stream:
        assert (trace.stats.delta, trace.stats.calib, trace.stats.record.state) == (dt, 1.0, state)
        assert trace.data.dtype == np.float64
        assert abs(trace.stats.starttime - obspy.UTCDateTime(*start)) < 1e-6


def test_one_record_in_two_formats_is_one_record():
    """The agency gives this record out as CSMIP volume 1 and as COSMOS stage 1, in the same digits."""
    other = _read_cosmos(BytesIO(gzip.decompress((DATA / "cosmos-pomona.v1c.gz").read_bytes())))
    for one, two in zip(read(POMONA), other, strict=True):
        assert np.array_equal(one.data, two.data)
        assert one.stats.starttime == two.stats.starttime
        same = ("component", "azimuth", "station", "state", "units")
        assert [one.stats.record[key] for key in same] == [two.stats.record[key] for key in same]


def test_header_peaks_come_out_of_the_samples():
    """Volume 2 to the last digit; volume 1 within its text, .001 g, and half of the last digit of its samples."""
    for trace in read(PARKFIELD):
        assert peak(trace.data) == pytest.approx(trace.stats.record.header_pga, rel=1e-12)
    for data, digits in ((POMONA, 1e-6), (HESPERIA, 0.0005)):
        for trace in read(data):
            assert peak(trace.data) == pytest.approx(trace.stats.record.header_pga, abs=digits * G)


def blocks(data):
    """Channel by channel the numbers of a volume 2 file's three tables, by this test's own reading, in m and s."""
    for channel in data.decode("latin-1").split("/& ")[:3]:
        parts = re.split(r" POINTS OF (?:ACCEL|VELOC|DISPL) DATA[^\n]*\n", channel)[1:]
        yield [np.array(re.findall(r"-?\d*\.\d{3}", part), dtype=float) * 0.01 for part in parts]


def test_peaks_of_velocity_and_displacement_are_those_of_the_file_and_of_the_integral():
    """The header's PGV and PGD are the crests of the file's tables, to the last digit. The acceleration's integral is
    the file's velocity within 5 % of its PGV over 65 s: volume 2 filters velocity again, which moves its baseline."""
    for trace, (acceleration, velocity, displacement) in zip(read(PARKFIELD), blocks(PARKFIELD), strict=True):
        assert np.array_equal(trace.data, acceleration)
        record = trace.stats.record
        assert peak(velocity) == pytest.approx(record.header_pgv, rel=1e-12)
        assert peak(displacement) == pytest.approx(record.header_pgd, rel=1e-12)
        integral = velocity[0] + cumulative_trapezoid(trace.data, dx=trace.stats.delta, initial=0.0)
        assert peak(integral - velocity) < 0.05 * peak(velocity)
        assert peak(integral) == pytest.approx(record.header_pgv, rel=0.02)
        assert (record.low_corner, record.high_corner) == (0.1, 23.0)


def test_the_header_goes_to_the_statistics():
    record = read(PARKFIELD)[0].stats.record
    assert (record.event, record.magnitude, record.date) == ("COALINGA EARTHQUAKE", 6.5, "1983-05-02")
    assert (record.station, record.azimuth) == ("PARKFIELD FAULT ZONE 14", 90.0)
    assert record.units == "units: cm/s², times 0.01"
    record = read(HESPERIA)[0].stats.record
    assert (record.event, record.magnitude, record.station) == ("BIG BEAR EARTHQUAKE", 6.4, "HESPERIA - 4TH & PALM")
    # A line of the record's own time, as CSMIP writes before it knows the earthquake, names none.
    unnamed = HESPERIA.replace(b"BIG BEAR EARTHQUAKE", b"Rcrd of Sun Jun 28,")
    assert read(unnamed)[0].stats.record.event == ""
    assert record.units == "units: g, times 9.80665 m/s²"


def test_a_line_of_a_megabyte_is_refused():
    """Its words would be looked for in a time that grows with the square of its length: hours, for this one."""
    broken = HESPERIA.replace(b"CHAN  1:  90 DEG", b"CHAN  1:  90 DEG" + 10**6 * b" " + b"x", 1)
    with pytest.raises(RecordError, match=r"line 7: has 10000.. characters, 2000 at most are read; restore"):
        read(broken)


# The first channels with sixteen samples.
END = "/&  ----------  End of data for channel  1  ----------\n"
ONE = POMONA.decode().replace("\r", "").split("\n")[:30]
ONE[10], ONE[27] = ONE[10].replace("13400", "   16").replace("67.000", " 0.080"), ONE[27].replace("13400", "   16")
PEAK = "-.1054327"  # of the header; every text here states the peak of its own samples
ONE = "\n".join(ONE).replace(PEAK, " .0000600").replace("(3 Chns", "(1 Chns") + "\n" + END
TWO = [line.ljust(80) for line in PARKFIELD.decode("latin-1").replace("\r", "").split("\n")[:48]]
TWO[40] = TWO[40].replace("  -267.957", "    -5.659")
TWO[11], TWO[45] = TWO[11].replace("65.000", " 0.320"), TWO[45].replace("3251", "  16")
HEAD, ROWS = "\n".join(TWO[:45]) + "\n", "\n".join(TWO[46:]) + "\n"
ACCEL = TWO[45] + "\n"
MORE = [
    ACCEL.replace("ACCEL", word).replace("CM/SEC/SEC", unit) for word, unit in (("VELOC", "CM/SEC"), ("DISPL", "CM"))
]
TWO = HEAD + ACCEL + ROWS + MORE[0] + ROWS + MORE[1] + ROWS + END


def changed(base, *pairs):
    """The text with words replaced, each of which is in it."""
    for old, new in pairs:
        assert old in base, old
        base = base.replace(old, new, 1)
    return base


def film(times, values, unit="G/10", count=None):
    """A volume 1 channel of pairs, as of digitised film, five on a line."""
    words = [f"{number:7.3f}" for pair in zip(times, values, strict=True) for number in pair]
    rows = "".join("".join(words[at : at + 10]) + "\n" for at in range(0, len(words), 10))
    text = ONE.split("\n")[:27]
    text[10] = f"NO. OF POINTS = {count or len(times):6d}  RECORD LENGTH = {times[-1]:.3f} SEC"
    text[11] = f"UNITS OF UNCOR ACCEL ARE SEC AND {unit}.     MAX  =  -.200 G, AT  11.576 SEC."
    text[20] = text[20].replace(" .0000600", f"{0.1 * peak(values):9.6f}")
    return "\n".join(text) + "\n" + rows + "/&  ----------  END OF DATA FOR CHANNEL  1  ----------\n"


# The first pairs of 116th Street School, Los Angeles, Northridge earthquake of 1994, station 14403, 90°.
TIMES = np.array([0.0, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030, 0.034, 0.040, 0.044])
VALUES = np.array([-0.006, 0.007, 0.007, 0.006, 0.006, -0.009, 0.005, 0.004, 0.003, 0.002])


def test_film_at_even_times_is_read_as_such():
    times = np.arange(12) * 0.005
    trace = read(film(times, np.arange(12) / 1000.0).encode())[0]
    assert trace.stats.delta == pytest.approx(0.005, rel=1e-12)
    assert trace.data == pytest.approx(np.arange(12) / 1000.0 * G / 10, rel=1e-12)
    assert trace.stats.record.units == "units: g/10, times 0.980665 m/s²"


def test_film_at_uneven_times_is_read_on_straight_lines_at_the_step_that_is_asked_for():
    trace = read(film(TIMES, VALUES).encode(), dt=0.01)[0]
    # At 0.03 s the sample itself, at 0.04 s too; between 0.034 and 0.040 nothing is read at this step.
    assert trace.data == pytest.approx(np.array([-0.006, 0.007, 0.006, 0.005, 0.003]) * G / 10, rel=1e-12)
    fine = read(film(TIMES, VALUES).encode(), dt=0.004)[0]
    assert fine.data[9] == pytest.approx((0.004 + (0.036 - 0.034) / 0.006 * -0.001) * G / 10, rel=1e-9)
    assert (fine.stats.npts, fine.stats.delta) == (12, 0.004)
    assert fine.stats.record.units == "units: g/10, times 0.980665 m/s², uneven times read at every 0.004 s"


WORDS_OF_1992 = "16 POINTS OF ACCEL DATA EQUALLY SPACED AT .005 SEC.  (UNITS: G)"
SPELLINGS = {
    "CRLF": (TWO, TWO.replace("\n", "\r\n")),
    "DOS": (TWO, TWO + "\x1a" * 100),
    "no last line": (TWO, TWO.removesuffix(END)),
    "no velocity": (TWO, HEAD + ACCEL + ROWS + END),
    "columns named": (TWO, TWO.replace("(UNITS: CM/SEC/SEC)", "in cm/sec2. (8f10.3)")),
    "columns not named": (ONE, ONE.replace("in units of g.       Format: (8f9.6)", "in units of g.")),
    "words of 1992": (ONE, re.sub(r"16 Accelerogram points.*", WORDS_OF_1992, ONE)),
}


def test_the_good_texts_are_good():
    assert read(ONE.encode())[0].data[:3] == pytest.approx(np.array([-0.000023, -0.000009, 0.000009]) * G, rel=1e-12)
    assert read(TWO.encode())[0].data[-1] == pytest.approx(-0.00955, rel=1e-12)
    assert len(read(TWO.encode())) == 1


def test_the_step_of_the_header_is_finer_than_that_of_the_line():
    """A 128th of a second is .0078 s in the real numbers and .008 s in the line of the samples."""
    text = changed(
        HEAD + ACCEL + ROWS,
        ("    65.000      .020", "    65.000  .0078125"),
        (" AT  .020 SEC", " AT  .008 SEC"),
        (" 0.320", " 0.125"),
    )
    assert read(text.encode())[0].stats.delta == 1.0 / 128.0


def test_channels_of_one_direction_have_their_number(tmp_path):
    path = tmp_path / "building.v2"
    path.write_text(changed(TWO, ("CHAN  1:  90", "CHAN  7:  90")).replace("\nCHAN  1", "\nCHAN  7") + TWO)
    assert [each.component for each in read_components(path)] == ["90 channel 7", "90 channel 1"]


@pytest.mark.parametrize(
    ("words", "start"),
    [
        ("TRIGGER TIME: 2/27/2010 3:55:43.000 GMT", obspy.UTCDateTime(2010, 2, 27, 3, 55, 43)),
        ("Start time: 12/31/99, 22:59:58.5 PST", obspy.UTCDateTime(2000, 1, 1, 6, 59, 58, 500000)),
        ("Start time: 12/31/99, 22:59:58.5", obspy.UTCDateTime(0)),
        ("", obspy.UTCDateTime(0)),
    ],
)
def test_times(words, start):
    stats = read(changed(ONE, ("Start time:  8/29/18, 02:33:  .0 UTC", words)).encode())[0].stats
    assert stats.starttime == start
    assert stats.record.date == (str(start.date) if start.timestamp else "")


ALLOWED = '"Uncorrected Accelerogram Data" (volume 1) or "Corrected accelerogram" (volume 2)'
CUT = "the file is cut short: fetch it again"
BAD = [
    ("", "x.v2: is empty (0 bytes); fetch the record again"),
    (
        "Response and Fourier amplitude spectra\n" + TWO,
        'x.v2, line 1: "Response and Fourier amplitude spectra" is not the title of a channel of acceleration, '
        f"{ALLOWED}; take such a file of this record",
    ),
    (
        TWO + "remark\n",
        f'x.v2, line 56: "remark" is not the title of a channel of acceleration, {ALLOWED}; take such a file of this '
        "record",
    ),
    (
        changed(TWO, ("(UNITS: CM/SEC/SEC)", "(UNITS: CM/SEC)")),
        'x.v2, line 1: the channel that starts here is in "cm/sec"; acceleration is read in g, g/10, cm/sec2, '
        "cm/sec/sec, cm/sec^2, cm/s2, cm/s/s, cm/s^2, gal: convert the samples, or take the file of acceleration of "
        "this record",
    ),
    (
        changed(TWO, ("POINTS OF ACCEL DATA", "POINTS OF DATA")),
        'x.v2, line 46: "16 POINTS OF DATA EQUALLY SPACED AT  ..." does not say what follows, as "12000 points of '
        'accel data equally spaced at .005 sec, in cm/sec2" does; restore that line, or fetch the file again',
    ),
    (
        changed(TWO, (" AT  .020 SEC", " AT  .030 SEC")),
        "x.v2, line 46: says a step of .030 s, the 61st real number of the header 0.02 s; correct the wrong one, or "
        "fetch the file again",
    ),
    (
        changed(TWO, ("RECORD LENGTH =  0.320", "RECORD LENGTH = 65.000")),
        "x.v2, line 46: 16 samples every 0.02 s last 0.32 s, the text says 65 s; correct the wrong one, or fetch "
        "the file again",
    ),
    (
        changed(TWO, ("    -3.038", "       ***")),
        'x.v2, line 47: "***" is not a finite number; the samples must be plain numbers such as -.123456: repair that '
        "line, or fetch the file again",
    ),
    (
        changed(TWO, ("  16 POINTS", "  17 POINTS")),
        'x.v2, line 49: "16 POIN" is not a finite number; the samples must be plain numbers such as -.123456: repair '
        "that line, or fetch the file again",
    ),
    (
        HEAD + ACCEL + ROWS[:81] + END,
        f"x.v2, line 46: 16 samples should follow, 8 found; {CUT}",
    ),
    (
        HEAD + ACCEL + ROWS * 2 + END,
        'x.v2, line 49: "-3.038     -.787     2.288     4.106 ..." follows the last promised sample, where /& and '
        "End of data should be; correct the number of samples, or fetch the file again",
    ),
    (
        changed(ONE, ("at 200 pts/sec", "at 0 pts/sec")),
        'x.v2, line 28: the time step is "1/(0/s)"; the time step must be a number of seconds greater than 0, from '
        "1e-06 to 1 s: restore that line, or fetch the file again",
    ),
    (
        changed(ONE, ("16 Accelerogram points", "1 Accelerogram points")),
        "x.v2, line 28: promises 1 samples; a record needs at least 2: fetch the file again",
    ),
    (
        changed(ONE, ("8/29/18, 02:33", "8/39/18, 02:33")),
        'x.v2, line 1: the channel that starts here has no valid time in "Start time:  8/39/18, 02:33:  .0 UTC"; '
        "correct that line, or remove the time where it is not known",
    ),
    (
        "\n".join(ONE.split("\n")[:20]),
        "x.v2, line 20: 50 real numbers of the header should follow, 0 found; " + CUT,
    ),
    (
        "\n".join(ONE.split("\n")[:10]),
        f"x.v2: ends at line 10, where the lines of text of its header should be; {CUT}",
    ),
    (
        film(TIMES, VALUES),
        "x.v2, line 28: holds pairs of times and accelerations, at steps from 0.004 to 0.006 s; give the even step at "
        'which to read them: records.dt = "0.005 s" in a scene, dt=0.005 in Python, --dt "0.005 s" on the command '
        "line, or take the corrected file of this record",
    ),
    (
        film([0.0, 0.005, 0.010, 0.008, 0.015], VALUES[:5]),
        "x.v2, line 28: after the time 0.01 s comes 0.008 s; times must rise, by at most 0.05 s: take the corrected "
        "file of this record, or cut it there and hand it over in columns",
    ),
    (
        film([0.0, 0.005, 0.010, 0.910, 0.915], VALUES[:5]),
        "x.v2, line 28: after the time 0.01 s comes 0.91 s; times must rise, by at most 0.05 s: take the corrected "
        "file of this record, or cut it there and hand it over in columns",
    ),
    (
        film(TIMES, VALUES, count=11),
        f"x.v2, line 27: 22 numbers in pairs should follow, 20 found; {CUT}",
    ),
    (
        film(np.arange(10) * 0.005, VALUES, unit="MM"),
        'x.v2, line 1: the channel that starts here is in "mm"; acceleration is read in g, g/10, cm/sec2, cm/sec/sec, '
        "cm/sec^2, cm/s2, cm/s/s, cm/s^2, gal: convert the samples, or take the file of acceleration of this record",
    ),
]
