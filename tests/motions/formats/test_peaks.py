"""Files whose samples are not what their own header says: another peak, a shifted line, fewer channels than told."""

import re
import struct

import damage
import numpy as np
import pytest
from real_files import G, read, real
from sentences import refusal

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._text import StatedPeak, check_peak, half_digit, stated_peak

# The line of each real file's largest sample, that sample, and another in as many characters.
LARGEST = {
    "smc-shafter.smc": (290, "1.0441E+2", "1.0441E+3"),
    "smc-alhambra-raw.smc": (124, "-2.6349E+2", "-2.6649E+2"),
    "csmip-pomona.v1": (818, " -.105433", "-1.054330"),
    "csmip-hesperia.raw": (264, "  .057921  .055", "  .059921  .055"),
    "csmip-parkfield.v2": (115, "-267.957", "-268.957"),
    "cosmos-pomona.v1c": (835, " -.105433", "-1.054330"),
    "cosmos-bremner.v2c": (15297, "-6.851512e+00", "-6.851512e+14"),
    "cosmos-bayview.v0c": (957, " -985881", " -995881"),
    "esm-dlfa-hne.asc": (7327, "-0.227973", "-0.229973"),
    "geonet-thz.v1a": (2334, " 399.7", " 401.7"),
    "geonet-thz.v2a": (628, " 357.8", "-377.8"),
}


def with_line(data, number, old, new):
    """The file with words of one line replaced."""
    lines = data.split(b"\n")
    assert lines[number - 1].count(old.encode()) == 1
    lines[number - 1] = lines[number - 1].replace(old.encode(), new.encode())
    return b"\n".join(lines)


@pytest.mark.parametrize("name", LARGEST)
def test_a_sample_that_is_not_the_stated_peak_is_refused(name, says):
    """From 0.4 % beyond it to 1e14 times as much; and the file as it is, is read."""
    data = real(name)
    assert read(data)
    says(refusal(read, with_line(data, *LARGEST[name])))


@pytest.mark.parametrize("name", LARGEST)
def test_a_lost_peak_is_refused_too(name):
    """A quiet record under the heading of a strong one: every sample of the first component a hundredth."""
    stated = StatedPeak(1.0, 0.0005, "g", G, "x, line 1")
    samples = np.array(read(real(name))[0].data)
    samples *= G / np.abs(samples - samples.mean()).max()
    assert check_peak(samples - samples.mean(), stated) == stated
    with pytest.raises(RecordError, match=r"the largest sample is 1 g, it is 0\.01; samples or header are damaged"):
        check_peak((samples - samples.mean()) / 100.0, stated)


def test_sac_with_another_peak_than_its_header_is_refused():
    """DEPMIN and DEPMAX are the second and the third number of the header (SAC manual), -12345 where not set."""
    data = damage.written(damage.whole_numbers(500), "SAC")
    assert len(read(data, unit="cm/s^2")) == 1
    low, high = struct.unpack_from("<2f", data, 4)
    for stated in ((low, 2.0 * high), (10.0 * low, high), (0.5 * low, 0.5 * high)):
        changed = data[:4] + struct.pack("<2f", *stated) + data[12:]
        with pytest.raises(RecordError, match=r"x: the header says .* \(DEPMIN, DEPMAX\), it is "):
            read(changed, unit="cm/s^2")
    unset = data[:4] + struct.pack("<2f", -12345.0, -12345.0) + data[12:]
    assert np.array_equal(read(unset, unit="cm/s^2")[0].data, read(data, unit="cm/s^2")[0].data)


@pytest.mark.parametrize(
    ("word", "half"), [("-.058", 5e-4), ("12", 0.5), ("0.1044078E+03", 5e-5), ("6.", 0.5), ("-1.5D-2", 5e-4)]
)
def test_half_of_the_last_digit(word, half):
    assert half_digit(word) == pytest.approx(half, rel=1e-12)


@pytest.mark.parametrize(
    ("word", "samples", "fits"),
    [
        ("-.058", [0.01, -0.0584999], True),  # -.058 may stand for it
        ("-.058", [0.01, -0.0587], False),  # 1.4e-4 beyond half a digit and 1.1e-3 of the peak
        ("100.000", [0.0, 100.1], True),  # 980 and 981 cm/s² in one g
        ("100.000", [0.0, 100.2], False),
        ("0.0123456", [0.001, 0.012, -0.004], True),  # samples of three decimals
        ("0.0123456", [0.001, 0.011, -0.004], False),
        ("3.000", [10.0, 13.0, 7.0], True),  # less the mean of a raw record
        ("0.000", [0.0, 5.0], True),  # not evaluated
    ],
)
def test_how_far_header_and_samples_may_differ(word, samples, fits):
    stated = stated_peak(word, "g", G, "x, line 3")
    if fits:
        check_peak(np.array(samples) * G, stated)
    else:
        with pytest.raises(RecordError, match="x, line 3: the header says that the largest sample is"):
            check_peak(np.array(samples) * G, stated)


def test_a_peak_of_volume_1_may_be_in_the_unit_of_the_samples():
    """Samples in cm/s² under a peak in g or in cm/s²: the reading that fits is the header's."""
    data = real("csmip-hesperia.raw").replace(b"(UNITS: G)", b"(UNITS: cm/s2)")
    with pytest.raises(RecordError, match=r"is 0\.054 g, it is 5\.9063e-05;"):
        read(data.replace(b"      .058     9.425", b"      .054     9.425"))
    trace = read(data)[0]
    assert trace.stats.record.header_pga == pytest.approx(0.058 * 0.01)
    assert read(real("csmip-hesperia.raw"))[0].stats.record.header_pga == pytest.approx(0.058 * G)


# --- lines of columns -------------------------------------------------------------------------------------

TABLES = ["smc-shafter.smc", "csmip-pomona.v1", "csmip-parkfield.v2", "cosmos-pomona.v1c", "geonet-thz.v1a"]


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("at", [0, 3, 6, 9, 20, 41])
@pytest.mark.parametrize("change", ["a character lost", "a blank put in", "a digit put in"])
def test_a_line_shifted_by_a_character_is_refused_by_its_number(name, at, change):
    number = LARGEST[name][0] + 1
    lines = real(name).replace(b"\r", b"").split(b"\n")
    line = lines[number - 1].rstrip()
    lines[number - 1] = {
        "a character lost": line[:at] + line[at + 1 :],
        "a blank put in": line[:at] + b" " + line[at:],
        "a digit put in": line[:at] + b"1" + line[at:],
    }[change]
    with pytest.raises(RecordError, match=f"x, line {number}: .* fetch the file again"):
        read(b"\n".join(lines))


# --- channels ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["csmip-pomona.v1", "cosmos-pomona.v1c"])
def test_a_channel_missing_at_the_end_is_told(name):
    data = real(name)
    ends = [found.end() for found in re.finditer(rb"\n *(?:/&|End-of-data)[^\n]*\n", data)]
    assert len(ends) == 3
    assert all("channels" not in trace.stats.record.units for trace in read(data))
    for channels in (1, 2):
        traces = read(data[: ends[channels - 1]])
        assert len(traces) == channels
        for trace in traces:
            told = f"; the header states 3 channels, the file holds {channels}"
            assert trace.stats.record.units == f"units: g, times 9.80665 m/s²{told}"
