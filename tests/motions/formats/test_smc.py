"""SMC: corrected and uncorrected files, records of film, and texts with faults."""

from functools import partial

import numpy as np
import obspy
import pytest
import real_files
from real_files import read, real

from pounding_risk.errors import RecordError
from pounding_risk.motions.read import read_motion

SHAFTER, RAW, UP = (real(f"smc-{name}.smc") for name in ("shafter", "alhambra-raw", "alhambra-up"))


def test_the_time_of_the_header_peak_is_that_of_the_samples():
    """10.34 s, to the sample: the header's own, so the step is right."""
    trace = read(SHAFTER)[0]
    assert np.argmin(trace.data) * trace.stats.delta == pytest.approx(10.34, abs=1e-9)
    assert np.argmax(trace.data) * trace.stats.delta == pytest.approx(10.17, abs=1e-9)
    assert np.abs(trace.data).max() == pytest.approx(trace.stats.record.header_pga, rel=1e-3)


def test_a_damaged_count_of_a_head_alone_takes_no_memory():
    damaged = read(changed((COUNT, "9999999999    -32768    -32768")), headonly=True)[0]
    assert damaged.stats.npts == 9999999999


# The corrected file with twelve samples.
CUT = [line.rstrip() for line in SHAFTER.decode().split("\n")[:37]]
GOOD = "\n".join(CUT).replace("      6001    -32768", "        12    -32768")[:-40] + "\n"
GOOD = GOOD.replace("  0.1044078E+03", "  0.1505700E+01").replace(
    " -0.7882104E+02", " -0.5793300E+01"
)  # of these twelve
changed = partial(real_files.changed, GOOD)
COUNT = "        12    -32768    -32768"


VALUES = [1.0, 2.0, 3.0, 4.0, 5.0, -6.0]  # cm/s²


def film(times, values):
    """Pairs of time and acceleration, as an uncorrected record of film has them: twelve numbers, no sampling rate."""
    numbers = (number for pair in zip(times, values, strict=True) for number in pair)
    words = [f"{number:11.4E}".replace("E-0", "E-").replace("E+0", "E+") for number in numbers]
    head = changed(("  0.1700000E+39  0.2000000E+03", "  0.1700000E+39  0.1700000E+39")).split("\n")[:35]
    rows = ["".join(words[:8]), "".join(words[8:])]
    peak = f"{max(values, key=abs):15.7E}"
    return "\n".join([*head, *rows]).replace(" -0.5793300E+01", peak).replace("2 CORRECTED", "1 UNCORRECTED") + "\n"


def test_of_times_that_are_the_same_in_their_digits_the_last_counts():
    trace = read(film([0.0, 0.004, 0.010, 0.010, 0.020, 0.030], VALUES), dt=0.005)[0]
    expected = [1.0, 2.0 + 2.0 / 6.0, 4.0, 4.5, 5.0, -0.5, -6.0]
    assert trace.data == pytest.approx(0.01 * np.array(expected), rel=1e-12)


def test_one_spare_line_of_film_is_left_out():
    """All of the twelve records of film in the public tests of gmprocess have one, of times that do not go on."""
    times = [0.0, 0.004, 0.010, 0.014, 0.020, 0.030]
    row = " 3.0070E+1-5.6038E-2 3.0071E+1-3.7377E-2 3.0073E+1-9.6096E-2 3.0074E+1-1.2702E-1\n"
    spare = read((film(times, VALUES) + row), dt=0.005)[0]
    assert np.array_equal(spare.data, read(film(times, VALUES), dt=0.005)[0].data)
    with pytest.raises(RecordError, match=r"line 39: .* follows the last of the 12 samples"):
        read((film(times, VALUES) + 2 * row), dt=0.005)[0]


SPELLINGS = {
    "CRLF": (GOOD, GOOD.replace("\n", "\r\n")),
    "blank lines": (GOOD, GOOD + "\n  \n"),
    "no last newline": (GOOD, GOOD.rstrip("\n")),
    "letters": (GOOD, GOOD.replace("2 CORRECTED", "2  Corrected")),
    "D exponents": (GOOD, GOOD.replace("E+0", "D+0")),
    "no exponent": (GOOD, GOOD.replace(" 1.5057E+0", "   1.5057 ")),
}


def test_a_file_marked_as_having_a_problem_says_so(tmp_path):
    text = changed((COUNT, "        12         1    -32768"))
    assert read(text)[0].stats.smc.problem is True
    path = tmp_path / "marked.smc"
    path.write_text(text)
    assert "its header marks a problem with the record" in read_motion(path).flags


def test_time_in_seconds_and_none():
    known = changed(("         0         4         0    -32768", "         0         4        15       250"))
    stats = read(known)[0].stats
    assert stats.starttime == obspy.UTCDateTime(1989, 10, 18, 0, 4, 15, 250000)
    assert stats.record.timed
    unknown = changed(("    -32768      1989", "    -32768    -32768"))
    stats = read(unknown)[0].stats
    assert (stats.starttime, stats.record.date) == (obspy.UTCDateTime(0), "1989-10-18")


BAD = {
    "empty": "",
    "velocity": changed(("2 CORRECTED ACCELEROGRAM", "3 VELOCITY")),
    "displacement": changed(("2 CORRECTED ACCELEROGRAM", "4 DISPLACEMENT")),
    "response spectra": changed(("2 CORRECTED ACCELEROGRAM", "5 RESPONSE SPECTRA")),
    "no title": changed(("2 CORRECTED ACCELEROGRAM", "*")),
    "no number of samples": changed((COUNT, "    -32768    -32768    -32768")),
    "a sample less": changed((COUNT, "        13    -32768    -32768")),
    "a sample more": changed((COUNT, "        11    -32768    -32768")),
    "a line more": changed((COUNT, "         8    -32768    -32768")),
    "film at uneven times": film([0.0, 0.0014, 0.0028, 0.0042, 0.0057, 0.0071], VALUES),
    "film whose times fall": film([0.0, 0.01, 0.02, 0.01, 0.03, 0.04], VALUES),
    "film with a hole": film([0.0, 0.01, 0.02, 1.46, 1.47, 1.48], VALUES),
    "no sampling rate": changed(("  0.2000000E+03", "  0.0000000E+00")),
    "a sampling rate beyond all": changed(("  0.2000000E+03", "  0.2000000E+09")),
    "a comment less": changed(("       101         8", "       101         9")),
    "a negative number of comments": changed(("       101         8", "       101        -8")),
    "NaN": changed(("-2.2223E+0", "       NaN")),
    "a sign lost in a number": changed(("-2.2223E+0", "-2.22230+0")),
    "stars for a year": changed(("      1989       291", "      1989       ***")),
    "day 391": changed(("      1989       291", "      1989       391")),
    "cut in the real numbers": "\n".join(CUT[:20]),
    "cut before the comments": "\n".join(CUT[:30]),
}
