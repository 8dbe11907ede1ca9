"""CSMIP volumes 1 and 2: real files of four decades, records of film, and texts with faults."""

import re

import numpy as np
import obspy
import pytest
from real_files import changed, read, real
from scipy.integrate import cumulative_trapezoid

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import read_components

POMONA, HESPERIA, PARKFIELD = (real(f"csmip-{name}") for name in ("pomona.v1", "hesperia.raw", "parkfield.v2"))


def peak(values):
    return np.abs(values).max()


def blocks(data):
    """Channel by channel the numbers of a volume 2 file's three tables, by this test's own reading, in m and s."""
    for channel in data.decode("latin-1").split("/& ")[:3]:
        parts = re.split(r" POINTS OF (?:ACCEL|VELOC|DISPL) DATA[^\n]*\n", channel)[1:]
        yield [np.array(re.findall(r"-?\d*\.\d{3}", part), dtype=float) * 0.01 for part in parts]


def test_peaks_of_velocity_and_displacement_are_those_of_the_file_and_of_the_integral():
    """The header's PGV and PGD are the extremes of the file's tables, to the last digit. The acceleration's integral is
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


def test_a_line_of_the_records_own_time_names_no_earthquake():
    """As CSMIP writes before it knows it."""
    unnamed = HESPERIA.replace(b"BIG BEAR EARTHQUAKE", b"Rcrd of Sun Jun 28,")
    assert read(unnamed)[0].stats.record.event == ""


def test_one_record_in_two_formats_is_one_record():
    """The agency gives this record out as CSMIP volume 1 and as COSMOS stage 1, in the same digits."""
    for one, two in zip(read(POMONA), read(real("cosmos-pomona.v1c")), strict=True):
        assert np.array_equal(one.data, two.data)
        assert one.stats.starttime == two.stats.starttime
        same = ("component", "azimuth", "station", "state", "units")
        assert [one.stats.record[key] for key in same] == [two.stats.record[key] for key in same]


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


def test_the_step_of_the_header_is_finer_than_that_of_the_line():
    """A 128th of a second is .0078 s in the real numbers and .008 s in the line of the samples."""
    text = changed(
        HEAD + ACCEL + ROWS,
        ("    65.000      .020", "    65.000  .0078125"),
        (" AT  .020 SEC", " AT  .008 SEC"),
        (" 0.320", " 0.125"),
    )
    assert read(text)[0].stats.delta == 1.0 / 128.0


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
    stats = read(changed(ONE, ("Start time:  8/29/18, 02:33:  .0 UTC", words)))[0].stats
    assert stats.starttime == start
    assert stats.record.date == (str(start.date) if start.timestamp else "")


BAD = {
    "empty": "",
    "spectra": "Response and Fourier amplitude spectra\n" + TWO,
    "a remark at the end": TWO + "remark\n",
    "velocity": changed(TWO, ("(UNITS: CM/SEC/SEC)", "(UNITS: CM/SEC)")),
    "a line that says not what follows": changed(TWO, ("POINTS OF ACCEL DATA", "POINTS OF DATA")),
    "two steps": changed(TWO, (" AT  .020 SEC", " AT  .030 SEC")),
    "two durations": changed(TWO, ("RECORD LENGTH =  0.320", "RECORD LENGTH = 65.000")),
    "stars for a sample": changed(TWO, ("    -3.038", "       ***")),
    "a sample less": changed(TWO, ("  16 POINTS", "  17 POINTS")),
    "half of the samples": HEAD + ACCEL + ROWS[:81] + END,
    "samples twice": HEAD + ACCEL + ROWS * 2 + END,
    "no sampling rate": changed(ONE, ("at 200 pts/sec", "at 0 pts/sec")),
    "one sample": changed(ONE, ("16 Accelerogram points", "1 Accelerogram points")),
    "day 39": changed(ONE, ("8/29/18, 02:33", "8/39/18, 02:33")),
    "cut before the real numbers": "\n".join(ONE.split("\n")[:20]),
    "cut in the text": "\n".join(ONE.split("\n")[:10]),
    "film at uneven times": film(TIMES, VALUES),
    "film whose times fall": film([0.0, 0.005, 0.010, 0.008, 0.015], VALUES[:5]),
    "film with a hole": film([0.0, 0.005, 0.010, 0.910, 0.915], VALUES[:5]),
    "film with a pair less": film(TIMES, VALUES, count=11),
    "film in millimetres": film(np.arange(10) * 0.005, VALUES, unit="MM"),
}
