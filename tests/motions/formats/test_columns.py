"""Plain columns: what a file and its reader state, times of every print, texts with faults, a way back."""

from io import BytesIO

import numpy as np
import obspy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sentences import refusal

from pounding_risk.errors import RecordError
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


def test_files_that_do_not_say_enough_are_not_claimed():
    assert not _is_columns(catalogue.records_folder() / "catalogue.toml")
    for text in (b"1\n2\n", b"# unit = g\n1\n2\n", b"# dt = 0.01\n1\n2\n", b"a,b\n0,1\n1,2\n"):
        assert not _is_columns(BytesIO(text))


# --- times as programs print them -----------------------------------------------------------------------------


@given(
    dt=st.sampled_from([0.0024, 0.0025, 0.005, 1 / 128, 0.01, 0.02]),
    start=st.sampled_from([0.0, -1.25, 17.5]),
    form=st.sampled_from(["{:.4f}", "{:.6f}", "{:.7e}", "{!r}", "{:.9g}"]),
    count=st.integers(3, 3000),
)
@pytest.mark.complete
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
    assert "print more digits" in refusal(read, text, kind=RecordError)


# --- refusals ---------------------------------------------------------------------------------------------


BAD = {
    "neither unit nor step": "1.5\n2.5\n",
    "no unit": ("1.5\n2.5\n", {"dt": 0.01}),
    "no step": ("1.5\n2.5\n", {"unit": "g"}),
    "times and no unit": "0 1.5\n0.1 2.5\n",
    "velocity above one column": ONE.replace("cm/s^2", "cm/s"),
    "velocity above two columns": TWO.replace("acceleration [g]", "velocity [cm/s]"),
    "counts": ("1\n2\n", {"unit": "counts", "dt": 0.01}),
    "two units in the file": "# unit = g\n" + TWO.replace("[g]", "[Gal]"),
    "a unit that the file contradicts": (TWO, {"unit": "m/s^2"}),
    "two units in comments": "# unit = g\n" + ONE,
    "a step that the file contradicts": (ONE, {"dt": 0.02}),
    "a step that the times contradict": (TWO, {"dt": 0.02}),
    "a step in the file that the times contradict": "# dt = 0.005\n" + TWO,
    "a rate for a step": ONE.replace("0.01 s", "100 Hz"),
    "nan among samples": ONE.replace("2.5", "nan"),
    "nan first": "# unit = g\nnan\n1\n",
    "the letter O": "1.O\n2.0\n",
    "decimal commas and blanks": "0,01 0,5\n0,02 0,6\n",
    "columns changed": "acceleration [g], time [s]\n1, 0\n2, 1\n",
    "two titles": "A title\nanother\n1\n",
    "comments alone": "# unit = g\n",
    "a letter": "a\n",
    "empty": "",
    "three columns": "1 2 3\n",
    "a short line": TWO + "0.03\n",
    "a blank line": ONE.replace("-2.5", ""),
    "points and commas": "# unit = g\n0;0\n0,01;0,5\n0,02;1.5\n",
    "one sample": "# unit = g\n0 1\n",
    "a sample less": "# samples = 4\n" + ONE,
    "samples in words": "# samples = x\n" + ONE,
    "a new state": "# state = new\n" + ONE,
    "day 40": "# starttime = 2019-13-40\n" + ONE,
    "the same time twice": TWO.replace("0.02,", "0.01,"),
    "an uneven step": TWO + "0.03, 0\n0.045, 0\n",
    "milliseconds": TWO.replace("[s]", "[ms]"),
    "a step of 10 s": "# unit = g\n0 1\n10 2\n20 3\n",
}


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


@given(
    samples=st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=50), dt=st.sampled_from([1 / 128, 0.0024, 1 / 3, 0.02])
)
@pytest.mark.complete
def test_any_samples_come_back_bit_for_bit(tmp_path_factory, samples, dt):
    trace = obspy.Trace(np.array(samples), header={"delta": dt})
    back = _read_columns(write_columns(trace, tmp_path_factory.getbasetemp() / "any.csv"))[0]
    assert np.array_equal(back.data, trace.data)
    assert back.stats.delta == trace.stats.delta


def test_a_motion_whose_last_number_was_cut_is_refused(tmp_path):
    """Its exponent is lost, whether the line ends there or not; the head states the peak."""
    motion = read_motion("RSN6-180")
    samples = np.append(motion.acceleration[:-1], 3.5e-5)
    path = write_columns(obspy.Trace(samples, {"delta": motion.dt}), tmp_path / "x.csv")
    whole = path.read_text()
    peak = float(np.abs(samples).max())
    assert f"\n# peak = {peak!r} m/s^2\n" in whole and whole.endswith(", 3.5e-05\n")
    path.write_text(whole.replace("3.5e-05", "3.5"))
    with pytest.raises(RecordError, match=rf"x.csv, line 5: the header says .* {peak:.6g} m/s\^2, it is 3.5; samples"):
        read_file(path)


@pytest.mark.parametrize("stated", ["2.5", "-2.5", "2.50 cm/s^2", "0.025 m/s^2", "2.5 at 0.01 s", "unknown"])
def test_a_stated_peak_is_compared(stated):
    """In the unit of the samples or its own; words that are no peak are passed over as other comments are."""
    text = ONE.replace("3.5", "0.5").replace("# dt", f"# peak: {stated}\n# dt")
    assert read(text).data.min() == -0.025
    if stated in ("unknown", "2.5 at 0.01 s"):
        assert read(text.replace("\n-2.5\n", "\n-5.0\n")).data[1] == -0.05
    else:
        with pytest.raises(RecordError, match=r"x\.csv, line 2: the header says that the largest sample is"):
            read(text.replace("\n-2.5\n", "\n-5.0\n"))


NUMBERS = {"fixed": "0.1234", "signed": "-1.2345", "exponents": "1.234E-05", "of all lengths": "0.00012345678901234"}


@pytest.mark.parametrize("form", NUMBERS)
@pytest.mark.parametrize("rows", ["{0}", "{1:.2f}, {0}"], ids=["one", "two"])
def test_a_last_number_that_was_cut_is_refused(form, rows):
    """Wherever it was cut within its decimals or its exponent; whole, it needs no line end."""
    head = "# unit = m/s^2\n" + ("# dt = 0.01 s\n" if "," not in rows else "")
    lines = [rows.format(NUMBERS[form], 0.01 * at) for at in range(12)]
    if form == "of all lengths":
        lines[3] += "567"
    text = head + "\n".join(lines)
    whole = read(text + "\n").data
    assert np.array_equal(read(text).data, whole)
    first = text.rindex(".") + 1
    for end in range(first, len(text)):
        if text[end - 1] in "E-" or not float(text[:end].split()[-1]):
            continue  # no number, which was refused before, and a zero, which is no peak
        with pytest.raises(RecordError, match=r'ends within a line, with ".*: the last number is cut'):
            read(text[:end])
        read(text[:end] + "\n")  # a program that ends its lines has written them


def test_what_cannot_be_written_is_said(tmp_path, says):
    unknown, still = (obspy.Trace(np.array([0.0, last])) for last in (np.nan, 0.0))
    says(refusal(write_columns, unknown, tmp_path / "x.csv"))
    says(refusal(write_columns, still, tmp_path / "none" / "x.csv"))
    assert list(tmp_path.iterdir()) == []
