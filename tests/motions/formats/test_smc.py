"""SMC: corrected and uncorrected files, every way to hand over a file, and the exact sentence for each fault."""

import gzip
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats.smc import _read_smc

DATA = Path(__file__).parents[2] / "data" / "formats"
FILES = {path.name: path for path in DATA.glob("smc-*.gz")}
SHAFTER, RAW, UP = (
    gzip.decompress(FILES[f"smc-{name}.smc.gz"].read_bytes()) for name in ("shafter", "alhambra-raw", "alhambra-up")
)


def read(data, **more):
    return _read_smc(BytesIO(data), **more)[0]


@pytest.mark.parametrize(
    ("data", "id", "component", "azimuth", "npts", "state", "ends"),
    [
        (SHAFTER, ".SAF0A..HNN", "360", 360.0, 6001, "processed", (1.5057, -0.28745)),
        (RAW, ".0482G..HNE", "90", 90.0, 6012, "raw", (1.0540, None)),
        (UP, ".0482H..HNZ", "up", None, 6014, "processed", (-2.7715, None)),
    ],
    ids=["corrected", "uncorrected", "vertical"],
)
def test_what_the_files_hold(data, id, component, azimuth, npts, state, ends):
    """``ends`` are the first and the last number, in cm/s², copied out of the file."""
    trace = read(data)
    assert (trace.id, trace.stats.npts, trace.stats.delta, trace.stats.calib) == (id, npts, 0.005, 1.0)
    record = trace.stats.record
    assert (record.component, record.azimuth, record.state) == (component, azimuth, state)
    assert record.units == "units: cm/s², times 0.01"
    assert trace.data.dtype == np.float64
    assert trace.data[0] == pytest.approx(0.01 * ends[0], rel=1e-12)
    last = 0.01 * float(data.decode().split()[-1][-10:]) if ends[1] is None else 0.01 * ends[1]
    assert trace.data[-1] == pytest.approx(last, rel=1e-12)


@pytest.mark.parametrize("data", [SHAFTER, RAW, UP], ids=["corrected", "uncorrected", "vertical"])
def test_the_header_peak_comes_out_of_the_samples(data):
    """The header has seven digits, the samples five: half of the last one is at most 5e-5 of a peak."""
    trace = read(data)
    peak = np.abs(trace.data).max()
    assert peak == pytest.approx(trace.stats.record.header_pga, rel=5e-5)
    text = data.decode().split("pk ")[1].split("\n")[0].replace("acc", "").replace("=", "")
    assert peak == pytest.approx(abs(float(text)) * 0.01, abs=0.00051)  # in cm/s² with one decimal


def test_the_time_of_the_header_peak_is_that_of_the_samples():
    """10.34 s, to the sample: the header's own, so the step is right."""
    trace = read(SHAFTER)
    assert np.argmin(trace.data) * trace.stats.delta == pytest.approx(10.34, abs=1e-9)
    assert np.argmax(trace.data) * trace.stats.delta == pytest.approx(10.17, abs=1e-9)


def test_the_header_goes_to_the_statistics():
    stats = read(SHAFTER).stats
    assert stats.starttime == obspy.UTCDateTime(1989, 10, 18, 0, 4)
    record = stats.record
    assert not record.timed  # it is that of the earthquake, to the minute
    assert (record.event, record.date, record.magnitude) == ("Loma Prieta, CA", "1989-10-18", 7.1)
    assert (record.station, record.distance_km) == ("San Francisco, 1295 Shafter, F", 89.0)
    assert (record.low_corner, record.high_corner) == (0.1, None)
    assert (stats.smc.latitude, stats.smc.longitude, stats.smc.problem) == (37.728, -122.385, False)
    assert (read(UP).stats.record.low_corner, read(UP).stats.record.high_corner) == (0.33, 25.0)
    assert read(RAW).stats.record.low_corner is None


def test_a_damaged_count_of_a_head_alone_takes_no_memory():
    damaged = read(changed((COUNT, "9999999999    -32768    -32768")).encode(), headonly=True)
    assert damaged.stats.npts == 9999999999


# The corrected file with twelve samples.
CUT = [line.rstrip() for line in SHAFTER.decode().split("\n")[:37]]
GOOD = "\n".join(CUT).replace("      6001    -32768", "        12    -32768")[:-40] + "\n"
GOOD = GOOD.replace("  0.1044078E+03", "  0.1505700E+01").replace(
    " -0.7882104E+02", " -0.5793300E+01"
)  # of these twelve
COUNT = "        12    -32768    -32768"


def changed(*pairs, base=GOOD):
    """The good text with words replaced, each of which is in it."""
    for old, new in pairs:
        assert old in base, old
        base = base.replace(old, new, 1)
    return base


VALUES = [1.0, 2.0, 3.0, 4.0, 5.0, -6.0]  # cm/s²


def film(times, values):
    """Pairs of time and acceleration, as an uncorrected record of film has them: twelve numbers, no sampling rate."""
    numbers = (number for pair in zip(times, values, strict=True) for number in pair)
    words = [f"{number:11.4E}".replace("E-0", "E-").replace("E+0", "E+") for number in numbers]
    head = changed(("  0.1700000E+39  0.2000000E+03", "  0.1700000E+39  0.1700000E+39")).split("\n")[:35]
    rows = ["".join(words[:8]), "".join(words[8:])]
    peak = f"{max(values, key=abs):15.7E}"
    return "\n".join([*head, *rows]).replace(" -0.5793300E+01", peak).replace("2 CORRECTED", "1 UNCORRECTED") + "\n"


def test_film_at_even_times_is_read_as_such():
    trace = read(film([0.01 * at for at in range(6)], VALUES).encode())
    assert trace.stats.delta == pytest.approx(0.01, rel=1e-12)
    assert trace.data == pytest.approx(0.01 * np.array(VALUES), rel=1e-12)
    assert (trace.stats.record.state, trace.stats.record.units) == ("raw", "units: cm/s², times 0.01")


def test_film_at_uneven_times_is_read_on_straight_lines_at_the_step_that_is_asked_for():
    trace = read(film([0.0, 0.004, 0.010, 0.014, 0.020, 0.030], VALUES).encode(), dt=0.005)
    expected = [1.0, 2.0 + 1.0 / 6.0, 3.0, 4.0 + 1.0 / 6.0, 5.0, -0.5, -6.0]
    assert trace.data == pytest.approx(0.01 * np.array(expected), rel=1e-12)
    assert trace.stats.delta == 0.005
    assert trace.stats.record.units == "units: cm/s², times 0.01, uneven times read at every 0.005 s"


def test_of_times_that_are_the_same_in_their_digits_the_last_counts():
    trace = read(film([0.0, 0.004, 0.010, 0.010, 0.020, 0.030], VALUES).encode(), dt=0.005)
    expected = [1.0, 2.0 + 2.0 / 6.0, 4.0, 4.5, 5.0, -0.5, -6.0]
    assert trace.data == pytest.approx(0.01 * np.array(expected), rel=1e-12)


def test_one_spare_line_of_film_is_left_out():
    """All of the twelve records of film in the public tests of gmprocess have one, of times that do not go on."""
    times = [0.0, 0.004, 0.010, 0.014, 0.020, 0.030]
    row = " 3.0070E+1-5.6038E-2 3.0071E+1-3.7377E-2 3.0073E+1-9.6096E-2 3.0074E+1-1.2702E-1\n"
    spare = read((film(times, VALUES) + row).encode(), dt=0.005)
    assert np.array_equal(spare.data, read(film(times, VALUES).encode(), dt=0.005).data)
    with pytest.raises(RecordError, match=r"line 39: .* follows the last of the 12 samples"):
        read((film(times, VALUES) + 2 * row).encode(), dt=0.005)


SPELLINGS = {
    "CRLF": (GOOD, GOOD.replace("\n", "\r\n")),
    "blank lines": (GOOD, GOOD + "\n  \n"),
    "no last newline": (GOOD, GOOD.rstrip("\n")),
    "letters": (GOOD, GOOD.replace("2 CORRECTED", "2  Corrected")),
    "D exponents": (GOOD, GOOD.replace("E+0", "D+0")),
    "no exponent": (GOOD, GOOD.replace(" 1.5057E+0", "   1.5057 ")),
}


def test_the_good_text_is_good():
    first, second = [1.5057, -2.2223, -1.9234, -3.1562, -3.2440, -3.5638], [-5.1941, -5.7933, -5.5295, -5.4933, -5.4174]
    expected = np.array([*first, *second, -4.5081])
    assert read(GOOD.encode()).data == pytest.approx(0.01 * expected, rel=1e-12)


def test_a_file_marked_as_having_a_problem_says_so():
    assert read(changed((COUNT, "        12         1    -32768")).encode()).stats.smc.problem is True


def test_time_in_seconds_and_none():
    known = changed(("         0         4         0    -32768", "         0         4        15       250"))
    stats = read(known.encode()).stats
    assert stats.starttime == obspy.UTCDateTime(1989, 10, 18, 0, 4, 15, 250000)
    assert stats.record.timed
    unknown = changed(("    -32768      1989", "    -32768    -32768"))
    stats = read(unknown.encode()).stats
    assert (stats.starttime, stats.record.date) == (obspy.UTCDateTime(0), "1989-10-18")


TITLES = '"1 UNCORRECTED ACCELEROGRAM" or "2 CORRECTED ACCELEROGRAM"'
BAD = [
    ("", "x.smc: is empty (0 bytes); fetch the record again"),
    *[
        (
            changed(("2 CORRECTED ACCELEROGRAM", title)),
            f'x.smc, line 1: the title is "{title}"; an SMC file of acceleration has {TITLES} there: take such a file '
            "of this record",
        )
        for title in ("3 VELOCITY", "4 DISPLACEMENT", "5 RESPONSE SPECTRA", "*")
    ],
    (
        changed((COUNT, "    -32768    -32768    -32768")),
        "x.smc, line 14: the number of samples is -32768; a record needs at least 2, or as many pairs of time "
        "and acceleration: fetch the file again",
    ),
    (
        changed((COUNT, "        13    -32768    -32768")),
        "x.smc, line 35: 13 samples should follow, 12 found; the file is cut short: fetch it again",
    ),
    (
        changed((COUNT, "        11    -32768    -32768")),
        "x.smc, line 35: 11 samples should follow, 12 found; correct that number, or fetch the file again",
    ),
    (
        changed((COUNT, "         8    -32768    -32768")),
        'x.smc, line 37: "-5.5295E+0-5.4933E+0-5.4174E+0-4.5081E+0" follows the last of the 8 samples that line 14 '
        "promises; correct that number, or fetch the file again",
    ),
    (
        film([0.0, 0.0014, 0.0028, 0.0042, 0.0057, 0.0071], VALUES),
        "x.smc, line 18: holds pairs of times and accelerations, at steps from 0.0014 to 0.0015 s; give the even "
        'step at which to read them: records.dt = "0.005 s" in a scene, dt=0.005 in Python, --dt "0.005 s" on the '
        "command line, or take the corrected file of this record",
    ),
    (
        film([0.0, 0.01, 0.02, 0.01, 0.03, 0.04], VALUES),
        "x.smc, line 18: after the time 0.02 s comes 0.01 s; times must rise, by at most 0.05 s: take the corrected "
        "file of this record, or cut it there and hand it over in columns",
    ),
    (
        film([0.0, 0.01, 0.02, 1.46, 1.47, 1.48], VALUES),
        "x.smc, line 18: after the time 0.02 s comes 1.46 s; times must rise, by at most 0.05 s: take the corrected "
        "file of this record, or cut it there and hand it over in columns",
    ),
    (
        changed(("  0.2000000E+03", "  0.0000000E+00")),
        'x.smc, line 18: the time step is "1/(0/s)"; the time step must be a number of seconds greater than 0, from '
        "1e-06 to 1 s: restore that line, or fetch the file again",
    ),
    (
        changed(("  0.2000000E+03", "  0.2000000E+09")),
        'x.smc, line 18: the time step is "1/(2e+08/s)"; the time step must be a number of seconds greater than 0, '
        "from 1e-06 to 1 s: restore that line, or fetch the file again",
    ),
    (
        changed(("       101         8", "       101         9")),
        'x.smc, line 36: "1.5057E+0-2.2223E+0-1.9234E+0-3.1562E..." should be one of 9 comments, which start with "|"; '
        "restore that line, or fetch the file again",
    ),
    (
        changed(("       101         8", "       101        -8")),
        "x.smc, line 13: the number of comments is -8; it must be 0 or more: fetch the file again",
    ),
    (
        changed(("-2.2223E+0", "       NaN")),
        'x.smc, line 36: "NaN" is not a finite number; the samples must be plain numbers such as -2.2223E+0: repair '
        "that line, or fetch the file again",
    ),
    (
        changed(("-2.2223E+0", "-2.22230+0")),
        'x.smc, line 36: "-2.22230+0" is not a finite number; the samples must be plain numbers such as -2.2223E+0: '
        "repair that line, or fetch the file again",
    ),
    (
        changed(("      1989       291", "      1989       ***")),
        'x.smc, line 12: "***" is not a finite number; the whole numbers of the header must be plain numbers such as '
        "-32768: repair that line, or fetch the file again",
    ),
    (
        changed(("      1989       291", "      1989       391")),
        "x.smc, line 12: the time, year day hour minute, is 1989 391 0 4; correct these whole numbers, or write -32768 "
        "where they are not known",
    ),
    (
        "\n".join(CUT[:20]),
        "x.smc, line 17: 50 real numbers of the header should follow, 15 found; the file is cut short: fetch it again",
    ),
    (
        "\n".join(CUT[:30]),
        "x.smc: ends at line 30, where its comments should be; the file is cut short: fetch it again",
    ),
]
