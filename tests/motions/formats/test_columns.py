"""Plain columns: what a file and its reader state, times of every print, the sentence for each fault, a way back."""

from io import BytesIO

import numpy as np
import obspy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pounding_risk.errors import PoundingError, RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.formats import read_file
from pounding_risk.motions.formats.columns import _is_columns, _read_columns, fits
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.write import write_columns

G = 9.80665
TWO = "time [s], acceleration [g]\n0.00, 0.01\n0.01, -0.02\n0.02, 0.03\n"
ONE = "# unit = cm/s^2\n# dt = 0.01 s\n1.5\n-2.5\n3.5\n"


def read(text, **choices):
    """The trace of a text."""
    return _read_columns(BytesIO(text if isinstance(text, bytes) else text.encode()), name="x.csv", **choices)[0]


def test_two_columns_with_heads():
    trace = read(TWO)
    assert np.array_equal(trace.data, np.array([0.01, -0.02, 0.03]) * G)
    assert (trace.stats.delta, trace.stats.calib, trace.data.dtype) == (0.01, 1.0, np.float64)
    assert trace.stats.record == {"state": "processed", "units": "units: g, times 9.80665"}


def test_one_column_with_comments():
    trace = read(ONE)
    assert np.array_equal(trace.data, np.array([1.5, -2.5, 3.5]) * 0.01)
    assert trace.stats.delta == 0.01
    assert trace.stats.record.units == "units: cm/s^2, times 0.01"


@pytest.mark.parametrize(
    "text",
    [
        "Time (s)  Acc (m/s2)\n0.00  1.0\n0.01  2.0\n0.02  3.0\n",
        "t [s]\ta [m/s**2]\r\n0.00\t1.0\r\n0.01\t2.0\r\n0.02\t3.0\r\n",
        "time,acc\r# unit: m/s/s\r0.00,1.0\r0.01,2.0\r0.02,3.0",
        "Time (sec);NS (m/s²)\n0,00;1,0\n0,01;2,0\n0,02;3,0\n",
        "\ufeffZeit\n".replace("Zeit", "time [s], acceleration [m/sec2]") + "0,1\n0.01,2\n0.02,3\n",
        "% Units = M/S^2\n% delta: 10 ms\n\n1\n2.\n3.0D0\n\n\n",
        "! unit = m/s^2\n0.0 1\n1e-2 2\n2e-2 3\n",
        '"time [s]","acceleration [m/s^2]"\n0,1\n0.01,2\n0.02,3\n',
        "#unit=mm/s^2\n#dt=0.01\n#samples = 3\n1000\n2000\n3000\n",
        "unit\n".replace("unit", "acceleration [Gal]") + "# dt = 0.01 sec\n100\n200\n300\n",
    ],
)
def test_layouts_that_mean_the_same(text):
    assert _is_columns(BytesIO(text.encode()))
    trace = read(text)
    assert np.array_equal(trace.data, [1.0, 2.0, 3.0])
    assert trace.stats.delta == 0.01


def test_the_caller_says_what_the_file_does_not(tmp_path):
    path = tmp_path / "quake.acc"
    path.write_text("1.5\n-2.5\n3.5\n")
    assert fits(path)
    assert not _is_columns(path)
    found = read_file(path, unit="cm/s^2", dt=0.01)
    assert (found.format, found.state, found.units) == ("COLUMNS", "processed", "units: cm/s^2, times 0.01")
    assert np.array_equal(found.trace.data, np.array([1.5, -2.5, 3.5]) * 0.01)
    # A name that promises another format does not stand in the way of what the caller says.
    other = path.rename(tmp_path / "quake.at2")
    assert np.array_equal(read_file(other, unit="cm/s^2", dt=0.01).trace.data, found.trace.data)


def test_facts_of_the_recording():
    facts = "# state = raw\n# event = Ridgecrest, 2019\n# magnitude = 7.1\n# azimuth = 90 deg\n# note: none\n"
    trace = read(facts + "# starttime = 2019-07-06T03:19:53.04Z\n# component = HNE\n# low_corner = 0.1 Hz\n" + ONE)
    record = trace.stats.record
    assert (record.state, record.event, record.magnitude, record.azimuth) == ("raw", "Ridgecrest, 2019", 7.1, 90.0)
    assert (record.component, trace.stats.channel, record.low_corner) == ("HNE", "HNE", 0.1)
    assert trace.stats.starttime == obspy.UTCDateTime(2019, 7, 6, 3, 19, 53, 40000)
    assert "note" not in record


def test_files_that_do_not_say_enough_are_not_claimed(tmp_path):
    others = [catalogue.path(entry.id) for entry in catalogue.entries()]
    others += [catalogue.records_folder() / "catalogue.toml", tmp_path, tmp_path / "none", None, 3, BytesIO(b"")]
    others += [BytesIO(text) for text in (b"1\n2\n", b"# unit = g\n1\n2\n", b"# dt = 0.01\n1\n2\n", b"a,b\n0,1\n1,2\n")]
    assert not any(_is_columns(other) for other in others)


# --- times as programs print them -----------------------------------------------------------------------------


@given(
    dt=st.sampled_from([0.0024, 0.0025, 0.005, 1 / 128, 0.01, 0.02]),
    start=st.sampled_from([0.0, -1.25, 17.5]),
    form=st.sampled_from(["{:.4f}", "{:.6f}", "{:.7e}", "{!r}", "{:.9g}"]),
    count=st.integers(3, 3000),
)
def test_times_give_the_step_however_they_are_printed(dt, start, form, count):
    times = start + np.arange(count) * dt
    text = "# unit = g\n" + "\n".join(f"{form.format(float(time))} 0.1" for time in times)
    # The first and the last time are each rounded by half a unit of the last digit, 1e-4 at most here.
    assert read(text).stats.delta == pytest.approx(dt, abs=1.01e-4 / (count - 1) + 1e-15)


@pytest.mark.parametrize("form", ["{:.2f}", "{:.3f}", "{:.5g}", "{:.6e}", "{!r}"])
@pytest.mark.parametrize("lost", [1, 2, 500, 997, 998])
def test_a_lost_line_is_seen_in_the_times(form, lost):
    lines = [f"{form.format(at / 100)} 0.1" for at in range(1000)]
    text = "# unit = g\n" + "\n".join(lines)
    assert read(text).stats.delta == 0.01
    with pytest.raises(RecordError, match=f"^x.csv, line {lost + 2}: the times do not rise in equal steps, by 0.02 s"):
        read("\n".join(text.split("\n")[: lost + 1] + text.split("\n")[lost + 2 :]))


def test_too_few_digits_are_no_equal_steps():
    text = "# unit = g\n" + "\n".join(f"{at / 128:.3f} 0.1" for at in range(100))
    with pytest.raises(RecordError, match="print more digits"):
        read(text)


# --- refusals ---------------------------------------------------------------------------------------------


HOW_UNIT = (
    'write "# unit = cm/s^2" above the samples, or give it: records.unit = "cm/s^2" in a scene, '
    'unit="cm/s^2" in Python, --unit "cm/s^2" on the command line'
)
HOW_DT = (
    'write "# dt = 0.01 s" above the samples, or give it: records.dt = "0.01 s" in a scene, dt=0.01 in '
    'Python, --dt "0.01 s" on the command line'
)
STRANGE = (
    "; a file of plain columns has one column, acceleration, or two, time and acceleration, under comments after # "
    'and at most one line of heads such as "time [s], acceleration [g]": repair that line'
)
BAD = [
    ("1.5\n2.5\n", {}, f"x.csv: says neither the unit of its acceleration nor its time step; {HOW_UNIT}; {HOW_DT}"),
    ("1.5\n2.5\n", {"dt": 0.01}, f"x.csv: does not say the unit of its acceleration; {HOW_UNIT}"),
    ("1.5\n2.5\n", {"unit": "g"}, f"x.csv: does not say its time step; {HOW_DT}"),
    ("0 1.5\n0.1 2.5\n", {}, f"x.csv: does not say the unit of its acceleration; {HOW_UNIT}"),
    (
        ONE.replace("cm/s^2", "cm/s"),
        {},
        'x.csv, line 1: "cm/s" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"',
    ),
    (
        TWO.replace("acceleration [g]", "velocity [cm/s]"),
        {},
        'x.csv, line 1: "cm/s" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"',
    ),
    (
        "1\n2\n",
        {"unit": "counts", "dt": 0.01},
        'x.csv: unit as given: "counts" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"',
    ),
    (
        "# unit = g\n" + TWO.replace("[g]", "[Gal]"),
        {},
        'x.csv, line 2: the unit is "Gal", line 1 says "g"; keep the right one',
    ),
    (TWO, {"unit": "m/s^2"}, 'x.csv: unit as given: the unit is "m/s^2", line 1 says "g"; keep the right one'),
    ("# unit = g\n" + ONE, {}, 'x.csv, line 2: states unit "cm/s^2", line 1 states "g"; keep one'),
    (ONE, {"dt": 0.02}, "x.csv, line 2: dt is 0.01 s, as given it is 0.02 s; keep the right one"),
    (TWO, {"dt": 0.02}, "x.csv: dt as given: dt is 0.02 s, but the times rise by 0.01 s; correct one of them"),
    ("# dt = 0.005\n" + TWO, {}, "x.csv, line 1: dt is 0.005 s, but the times rise by 0.01 s; correct one of them"),
    (
        ONE.replace("0.01 s", "100 Hz"),
        {},
        'x.csv, line 2: dt is "100 Hz"; the time step must be a number of seconds greater than 0, from 1e-06 to 1 s: '
        "restore that line, or fetch the file again",
    ),
    (
        ONE.replace("2.5", "nan"),
        {},
        'x.csv, line 4: "-nan" is not a finite number; every line after the head must hold plain numbers such as '
        "-0.0123: repair that line, or fetch the file again",
    ),
    ("# unit = g\nnan\n1\n", {}, f'x.csv, line 2: "nan" is neither numbers nor the heads of columns{STRANGE}'),
    ("1.O\n2.0\n", {}, f'x.csv, line 1: "1.O" is neither numbers nor the heads of columns{STRANGE}'),
    (
        "0,01 0,5\n0,02 0,6\n",
        {},
        'x.csv, line 1: "0,01 0,5" is neither numbers nor the heads of columns (a decimal comma is read only where '
        f"semicolons part the columns){STRANGE}",
    ),
    (
        "acceleration [g], time [s]\n1, 0\n2, 1\n",
        {},
        f'x.csv, line 1: "acceleration [g], time [s]" is neither numbers nor the heads of columns{STRANGE}',
    ),
    ("A title\nanother\n1\n", {}, f'x.csv, line 2: "another" is neither numbers nor the heads of columns{STRANGE}'),
    ("# unit = g\n", {}, "x.csv: has no samples, every line is blank or a comment; fetch the record again"),
    ("a\n", {}, f'x.csv, line 1: "a" is neither numbers nor the heads of columns{STRANGE}'),
    ("", {}, "x.csv: is empty (0 bytes); a plain columns file has a header and samples: fetch it again"),
    (
        "1 2 3\n",
        {},
        "x.csv, line 1: has 3 columns; one, acceleration, or two, time and acceleration, are read: keep one component "
        "a file, with one sample a line",
    ),
    (
        TWO + "0.03\n",
        {},
        'x.csv, line 5: "0.03" has 1, where the first line of samples has 2 columns; repair that line, or fetch '
        "the file again",
    ),
    (
        ONE.replace("-2.5", ""),
        {},
        "x.csv, line 4: is blank, where the first line of samples has 1 column; repair that line, or fetch the file "
        "again",
    ),
    (
        "# unit = g\n0;0\n0,01;0,5\n0,02;1.5\n",
        {},
        'x.csv, line 4: "0,02;1.5" has a decimal point, other lines have decimal commas; write one of the two '
        "throughout",
    ),
    ("# unit = g\n0 1\n", {}, "x.csv: has 1 sample; a record needs at least 2"),
    (
        "# samples = 4\n" + ONE,
        {},
        "x.csv, line 1: the header promises 4 samples, 3 found; the file is cut short: fetch it again",
    ),
    ("# samples = x\n" + ONE, {}, 'x.csv, line 1: samples is "x"; it must be a whole number, how many there are'),
    ("# state = new\n" + ONE, {}, 'x.csv, line 1: state is "new"; it may be "raw" or "processed"'),
    (
        "# starttime = 2019-13-40\n" + ONE,
        {},
        'x.csv, line 1: starttime is "2019-13-40"; write a time such as 2019-07-06T03:19:53.04Z, or leave '
        "that line out",
    ),
    (
        TWO.replace("0.02,", "0.01,"),
        {},
        "x.csv, line 4: the time 0.01 is not after the 0.01 of the line before; write times that rise, with enough "
        "digits to distinguish them",
    ),
    (
        TWO + "0.03, 0\n0.045, 0\n",
        {},
        "x.csv, line 6: the times do not rise in equal steps, by 0.015 s here and by 0.01 s elsewhere; restore missing "
        "lines, print more digits, or resample to equal steps",
    ),
    (
        TWO.replace("[s]", "[ms]"),
        {},
        'x.csv, line 1: the times are in "ms"; write them in seconds, in a column headed time [s]',
    ),
    (
        "# unit = g\n0 1\n10 2\n20 3\n",
        {},
        'x.csv, line 2: the step of the times is "10"; the time step must be a number of seconds greater than 0, from '
        "1e-06 to 1 s: restore that line, or fetch the file again",
    ),
]


@pytest.mark.parametrize(("text", "choices", "sentence"), BAD, ids=range(len(BAD)))
def test_bad_files_say_what_is_wrong(text, choices, sentence):
    with pytest.raises(RecordError) as caught:
        read(text, **choices)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    "text",
    [
        "1" * 200_000 + "x\n1\n",
        "a" + " " * 200_000 + "b\n1\n",
        "# a" + " " * 200_000 + "\n",
        "acceleration [" + "g" * 1_000_000 + "]\n1\n",
        "# unit = " + "sec" * 300_000 + "\n1\n",
        "# unit = " + "m**2*" * 200_000 + "\n1\n",
    ],
)
def test_absurd_lines_take_no_time(text):
    """Patterns that search in the square of a line's length would take minutes here, a million letters hours."""
    with pytest.raises(RecordError):
        read(text)


def test_lines_that_are_too_long_are_refused_by_their_number():
    with pytest.raises(RecordError, match=r"line 2: has 2005 characters, 2000 at most are read; restore its line ends"):
        read("# dt = 0.01 s\nacc [" + "g" * 1999 + "]\n1\n2\n")


def test_a_unit_that_is_too_long_is_none():
    with pytest.raises(RecordError, match=r'unit as given: "secsec.*" is not a unit of acceleration; write one such'):
        read("1\n2\n", unit="sec" * 20_000, dt=0.01)


# --- writing ----------------------------------------------------------------------------------------------


def test_a_motion_comes_back_bit_for_bit(tmp_path):
    motion = read_motion("RSN6-180", window=(0.0, 6.0), pga="0.5 g")
    path = write_columns(motion, tmp_path / "El Centro.csv")
    assert _is_columns(path)
    back = read_motion(path)
    assert np.array_equal(back.acceleration, motion.acceleration)
    assert back.dt == motion.dt
    assert back.processing == (*motion.processing, "units: m/s^2, times 1")
    kept = ("event", "date", "station", "component", "state")
    assert [back.record[key] for key in kept] == [motion.record[key] for key in kept]
    assert [each.name for each in tmp_path.iterdir()] == ["El Centro.csv"]


def test_a_raw_trace_stays_raw_until_it_is_processed(tmp_path):
    trace = catalogue.load("NAPA-HNE")[0]
    trace.stats.record = {"state": "raw"}
    back = _read_columns(write_columns(trace, tmp_path / "raw.txt"))[0]
    assert np.array_equal(back.data, trace.data)
    assert (back.stats.record.state, back.stats.starttime) == ("raw", trace.stats.starttime)
    assert back.stats.delta == trace.stats.delta
    done = _read_columns(write_columns(trace.detrend("demean"), tmp_path / "done.txt"))[0]
    assert done.stats.record.state == "processed"


@given(
    samples=st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=50), dt=st.sampled_from([1 / 128, 0.0024, 1 / 3, 0.02])
)
def test_any_samples_come_back_bit_for_bit(tmp_path_factory, samples, dt):
    trace = obspy.Trace(np.array(samples), header={"delta": dt})
    back = _read_columns(write_columns(trace, tmp_path_factory.getbasetemp() / "any.csv"))[0]
    assert np.array_equal(back.data, trace.data)
    assert back.stats.delta == trace.stats.delta


def test_what_cannot_be_written_is_said(tmp_path):
    trace = obspy.Trace(np.array([0.0, np.nan]))
    with pytest.raises(RecordError, match="1 sample is not finite"):
        write_columns(trace, tmp_path / "x.csv")
    with pytest.raises(PoundingError, match=r"none/x.csv: cannot be written \(No such file or directory\)"):
        write_columns(obspy.Trace(np.zeros(5)), tmp_path / "none" / "x.csv")
    assert list(tmp_path.iterdir()) == []
