"""Processing steps: offsets that a baseline finds again, another time step, noise of known spectra, its corners."""

import re
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sentences import refusal

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue, processing
from pounding_risk.motions.processing import Step, noise
from pounding_risk.motions.processing.noise import (
    BANDWIDTH,
    Corners,
    corners_from_noise,
    shared_corners,
    signal_to_noise,
)
from pounding_risk.motions.processing.signals import butterworth, energy_time, quiet_before, velocity_displacement
from pounding_risk.motions.read import read_motion, read_trace

DT, COUNT = 0.01, 15000
TIME = np.arange(COUNT) * DT
BILINEAR = [{"step": "mean"}, {"step": "baseline", "scheme": "bilinear"}]
NUMBER = r"(-?[0-9.e+-]+)"


def earthquake(seed, permanent):
    """Shaking from 25 s on with a peak of 2 m/s² and nothing below 0.15 Hz, and a rise to ``permanent`` [m] in 3 s."""
    random = np.random.default_rng(seed)
    envelope = np.clip((TIME - 25.0) / 3.0, 0.0, 1.0) * np.exp(-np.clip(TIME - 32.0, 0.0, None) / 6.0)
    band = butterworth(np.fft.rfftfreq(COUNT, DT), 0.15, 15.0, 3.0)
    shaking = np.fft.irfft(np.fft.rfft(random.normal(size=COUNT) * envelope) * band, COUNT)
    shaking *= 2.0 / np.abs(shaking).max()
    rise = np.sin(2.0 * np.pi * (TIME - 29.0) / 3.0) * ((TIME >= 29.0) & (TIME <= 32.0))
    instrument = random.normal(0.0, 2e-5, COUNT)
    return shaking + permanent * 2.0 * np.pi / 3.0**2 * rise, instrument


def corrected(samples, **options):
    return Step("baseline", {"scheme": "bilinear", **options}).apply(samples, DT)


def rest(samples):
    """Mean displacement [m] of the last 60 s."""
    return velocity_displacement(samples, DT)[1][-6000:].mean()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("permanent", "offset"), [(0.3, -0.004), (-0.5, 0.003), (0.0, 0.01)])
def test_one_offset_is_found_where_and_as_large_as_it_was(seed, permanent, offset):
    """An offset from 33 s on: its size to 0.5 %, its time to 0.2 s, the permanent displacement to 3 cm.

    What is left of the shaking in the quiet end moves the fitted line by some 0.4 mm/s at 33 s, 0.1 s of 4 mm/s², and
    that over the 60 s to the middle of the quiet end, which the line then crosses, is 2 cm.
    """
    true, instrument = earthquake(seed, permanent)
    done = corrected(true + instrument + offset * (TIME >= 33.0))
    found = re.search(rf"offset of {NUMBER} m/s² subtracted from {NUMBER} s on", done.sentence)
    assert float(found[1]) == pytest.approx(offset, rel=0.005)
    assert float(found[2]) == pytest.approx(33.0, abs=0.2)
    assert rest(done.samples) == pytest.approx(rest(true), abs=0.03)
    velocity = velocity_displacement(done.samples, DT)[0]
    assert np.abs(velocity[-2000:]).max() < 0.01 * np.abs(velocity).max()
    assert done.flags == ()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("permanent", "middle", "after"), [(0.3, 0.02, -0.004), (-0.5, 0.05, 0.003), (0.2, -0.03, 0.0)]
)
def test_two_offsets_of_known_times_are_found(seed, permanent, middle, after):
    """For the same reason the offset of 6 s is known to 0.4 mm/s / 6 s, and the displacement to 3 cm again."""
    true, instrument = earthquake(seed, permanent)
    samples = true + instrument + middle * ((TIME >= 30.0) & (TIME < 36.0)) + after * (TIME >= 36.0)
    done = corrected(samples, start=30.0, end=36.0)
    found = re.search(rf"offsets of {NUMBER} m/s² from 30 to 36 s and {NUMBER} after", done.sentence)
    assert float(found[1]) == pytest.approx(middle, abs=1e-4)
    assert float(found[2]) == pytest.approx(after, abs=1e-5)
    assert rest(done.samples) == pytest.approx(rest(true), abs=0.03)


def test_a_single_offset_is_taken_off_to_rounding():
    """No noise, no shaking after 60 s: velocity and displacement at rest, also for a step between two samples."""
    pulse = np.where((TIME > 30.0) & (TIME < 32.0), np.sin(np.pi * (TIME - 30.0)), 0.0)
    for start in (31.0, 31.003):
        shifted = pulse + 0.01 * np.clip((TIME - start) / DT + 0.5, 0.0, 1.0)
        velocity, displacement = velocity_displacement(corrected(shifted).samples, DT)
        assert np.abs(velocity[6500:]).max() < 1e-9
        assert displacement[-1] == pytest.approx(velocity_displacement(pulse, DT)[1][-1], abs=1e-7)


def test_the_raw_record_of_ridgecrest_keeps_a_permanent_displacement(says):
    """CCC-HN1: PGV 79.1 cm/s and PGD 45.9 cm for a line fitted to the velocity after 60 s (Boore 2001).

    Measured so with other code; the displacement that stays was 10 to 18 cm there as the fit's start moved, and is
    19 cm here, with the fit from 53.5 s on. No survey at the site confirms it.
    """
    motion = read_motion("CCC-HN1", processing=BILINEAR)
    velocity, displacement = motion.velocity_displacement()
    assert 100.0 * np.abs(velocity).max() == pytest.approx(79.1, abs=0.05)
    assert 100.0 * np.abs(displacement).max() == pytest.approx(45.9, abs=0.1)
    assert 0.08 < displacement[-1] < 0.20
    assert abs(velocity[-1]) < 0.002 * np.abs(velocity).max()
    assert motion.flags == ()
    says(motion.processing[-1])


@pytest.mark.parametrize("record", ["CCC-HN2", "CCC-HNZ", "NAPA-HNE", "NAPA-HNN", "NAPA-HNZ"])
def test_velocity_ends_at_rest_on_every_raw_record(record):
    """What swings on at the end is the noise of the instrument and late waves: 1.5 % of the peak."""
    motion = read_motion(record, processing=BILINEAR)
    velocity, displacement = motion.velocity_displacement()
    assert abs(velocity[-1]) < 0.015 * np.abs(velocity).max()
    assert np.abs(displacement).max() < 0.35  # metres of drift before
    assert motion.flags == ()
    assert "permanent displacement" in motion.processing[-1]


@settings(max_examples=25)
@given(st.floats(-0.5, 0.5), st.floats(-0.05, 0.05), st.floats(26.0, 44.0), st.floats(0.5, 12.0), st.integers(0, 3))
def test_velocity_comes_to_rest_whatever_the_offset_and_the_times(permanent, offset, start, length, seed):
    """The line is taken off the quiet end, so the mean velocity of that is zero; the last 80 s are nearly that."""
    true, instrument = earthquake(seed, permanent)
    done = corrected(true + instrument + offset * (TIME >= 33.0), start=start, end=start + length)
    assert abs(velocity_displacement(done.samples, DT)[0][-8000:].mean()) < 1e-4


REFUSED = {
    "an order of no polynomial": {"order": 3.0},
    "times of a polynomial": {"scheme": "polynomial", "start": 3.0},
    "an end before the start": {"start": 36.0, "end": 30.0},
    "too short a quiet": {"end": 148.0},
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_does_not_fit_is_refused(words, says):
    says(refusal(corrected, earthquake(0, 0.3)[0], **REFUSED[words]))


def resampled(samples, before, **options):
    return Step("resample", options).apply(samples, before)


def tone(frequency, dt, duration=20.0):
    """A burst of one frequency that starts and ends at zero: its spectrum ends some 2 Hz beside it."""
    time = np.arange(round(duration / dt) + 1) * dt
    return np.exp(-(((time - duration / 2) / 2.0) ** 2)) * np.sin(2.0 * np.pi * frequency * (time - duration / 2))


@settings(max_examples=30)
@given(
    st.sampled_from([0.005, 0.01, 0.02, 0.0024, 1 / 300]), st.integers(1, 12), st.sampled_from(["linear", "fourier"])
)
def test_a_step_that_divides_keeps_every_old_sample(dt, parts, method):
    """Linear to the bit, as old samples fall on whole places; Fourier to the rounding of two transforms."""
    samples = catalogue.load("RSN6-180")[0].data[:1500]
    done = resampled(samples, dt, dt=dt / parts, method=method)
    assert done.dt == dt / parts
    assert len(done.samples) == (len(samples) - 1) * parts + 1
    apart = np.abs(done.samples[::parts] - samples).max()
    assert apart == 0.0 if method == "linear" else apart < 1e-12
    if method == "linear":
        assert np.abs(done.samples).max() == np.abs(samples).max()
        assert done.flags == ()


@pytest.mark.parametrize(("record", "ratio"), [("RSN6-180", 1.0005), ("RSN753-000", 1.0019), ("RSN1690-090", 1.0124)])
def test_the_band_limited_peaks_of_scipy(record, ratio):
    """PGA ten times finer over PGA: `scipy.signal.resample`, another transform with other zeros; four digits."""
    trace = catalogue.load(record)[0]
    done = resampled(trace.data, trace.stats.delta, dt=trace.stats.delta / 10, method="fourier")
    assert np.abs(done.samples).max() / np.abs(trace.data).max() == pytest.approx(ratio, abs=2e-4)


@pytest.mark.parametrize("after", [0.004, 0.0025, 0.015, 0.02])
def test_a_tone_below_the_corner_is_the_same_tone(after):
    """5 Hz of a sampling at 100 Hz; the filter's gain there is 1 - 1e-11 for the coarsest step."""
    found = resampled(tone(5.0, 0.01), 0.01, dt=after, method="fourier").samples
    expected = tone(5.0, after)[: len(found)]
    assert np.abs(found - expected[: len(found)]).max() < 1e-8


@pytest.mark.parametrize("method", ["linear", "fourier"])
def test_a_tone_above_the_new_nyquist_frequency_is_no_alias(method):
    """40 Hz at dt 0.04 s would fold to 10 Hz; order 20 leaves (10/40)^20 of it."""
    done = resampled(tone(40.0, 0.005), 0.005, dt=0.04, method=method)
    assert np.abs(done.samples).max() < 1e-6
    assert "resampling changed PGA by -100.0 %" in done.flags
    assert done.sentence == f"resample: from 0.005 s to 0.04 s, {method}, after an acausal low-pass at 10 Hz"


def test_a_motion_has_the_new_step_and_starts_when_it_did():
    steps = [{"step": "window", "start": "20 s", "end": "60 s"}, {"step": "resample", "dt": "0.004 s"}]
    trace = read_trace("CCC-HN1", processing=steps)
    assert trace.stats.delta == 0.004
    assert trace.stats.npts == 10001
    assert trace.stats.starttime == catalogue.load("CCC-HN1")[0].stats.starttime + 20.0
    again = read_trace("CCC-HN1", processing=[*steps[::-1], {"step": "resample", "dt": "0.01 s"}])
    assert again.stats.starttime == trace.stats.starttime
    assert read_motion("CCC-HN1", processing=steps).dt == 0.004


def test_the_response_to_straight_lines_does_not_see_finer_samples():
    """The run takes a_g as linear between samples, so velocity at old samples stays, to rounding."""
    motion = read_motion("RSN6-180", processing=[{"step": "resample", "dt": "0.002 s"}])
    fine, coarse = motion.velocity_displacement()[0][::5], read_motion("RSN6-180").velocity_displacement()[0]
    assert np.abs(fine - coarse).max() < 1e-13


@pytest.mark.parametrize("options", [{"dt": 60.0}, {"dt": np.pi / 400, "method": "fourier"}], ids=["long", "no ratio"])
def test_what_cannot_be_is_refused(options, says):
    says(refusal(resampled, tone(5.0, 0.01), 0.01, **options))


HALVED = '''"""Half of the motion."""

from pounding_risk.motions.processing import Done, step


@step("halved")
def halved(samples, dt):
    """Divide by two, in place."""
    samples /= 2.0
    return Done(samples, "halved: divided by two")
'''


@pytest.fixture
def one_more_file(tmp_path, monkeypatch):
    """The folder of the steps with one file more, forgotten afterwards."""
    (tmp_path / "halved.py").write_text(HALVED, encoding="utf-8")
    monkeypatch.setattr(processing, "__path__", [*processing.__path__, str(tmp_path)])
    monkeypatch.setattr(processing._REGISTRY, "members", dict(processing.known_steps()))
    monkeypatch.setattr(processing._REGISTRY, "folder", processing.__name__)
    yield
    sys.modules.pop("pounding_risk.motions.processing.halved", None)


def test_adding_a_step_is_adding_a_file(one_more_file):
    asked = [{"step": "halved"}]
    motion, plain = (read_motion("RSN6-180", processing=steps) for steps in (asked, "none"))
    assert motion.pga == plain.pga / 2.0 and "halved: divided by two" in motion.processing
    with pytest.raises(RecordError, match=r"it may be bandpass, .*, halved, "):
        read_motion("RSN6-180", processing=[{"step": "half"}])


STEP, LENGTH, ARRIVAL = 0.01, 200.0, 100.0


def brune(frequency, corner, plateau):
    """|A(f)| = plateau · (f/fc)² / (1 + (f/fc)²) [m/s], the acceleration of Brune's (1970) source."""
    return plateau * (frequency / corner) ** 2 / (1.0 + (frequency / corner) ** 2)


def noisy(spectrum):
    """A motion of that amplitude spectrum: some seven pulses 8 s apart, the middle one 50 s after the arrival.

    A delay that swings with frequency, eight times in 1 Hz, makes the pulses and leaves |A(f)| as it is.
    """
    size = round(LENGTH / STEP)
    frequency = np.fft.rfftfreq(size, STEP)
    phase = -2.0 * np.pi * (ARRIVAL + 50.0) * frequency + 2.0 * np.cos(2.0 * np.pi * 8.0 * frequency)
    amplitude = spectrum(frequency)
    amplitude[-1] = 0.0
    return np.fft.irfft(amplitude * np.exp(1j * phase), size) / STEP


def crossing(level, plateau=1.0, corner=2.0):
    """Where signal and white noise together are twice the noise: the signal is √3 of it, as energies add."""
    share = np.sqrt(3.0) * level / plateau
    return corner * np.sqrt(share / (1.0 - share))


def white(seed):
    return np.random.default_rng(seed).normal(0.0, 1.0, round(LENGTH / STEP))


def amplitude_of_noise(sigma, samples):
    """What the mean Fourier amplitude of white noise is: σ dt √n √π/2 for a window of n, less its tapered ends.

    The root of the sum of squared weights: half a cosine keeps 3/8 of each tapered 5 %.
    """
    window = energy_time(samples, STEP, 0.95) + 5.0 - quiet_before(samples, STEP)
    return sigma * np.sqrt(window * STEP * (0.9 + 0.1 * 3.0 / 8.0)) * np.sqrt(np.pi) / 2.0


@pytest.mark.parametrize("seed", range(4))
def test_a_known_spectrum_crosses_known_noise_where_it_should(seed):
    """White noise under Brune's spectrum: they cross at 0.48 Hz.

    The noise's level over all frequencies is known to 2 % from some thousands of them. The crossing is allowed 25 %: in
    70 s of shaking some 11 frequencies fall into the smoothing at 0.48 Hz, the ratio there is known to 16 %, and the
    highest frequency of several that fails is taken; twelve seeds gave 0.78 to 1.17 of the true one.
    """
    samples = noisy(lambda f: brune(f, 2.0, 1.0)) + 0.05 * white(seed)
    spectra = signal_to_noise(samples, STEP)
    level = amplitude_of_noise(0.05, samples)
    # The median of a smoothed amplitude is its mean; at 20 Hz and more each holds hundreds of frequencies.
    assert np.median(spectra.noise[spectra.frequency > 20.0]) == pytest.approx(level, rel=0.03)
    found = spectra.frequency[np.flatnonzero((spectra.ratio < 2.0) & (spectra.frequency < 1.0))[-1]]
    assert found == pytest.approx(crossing(level), rel=0.25)
    corners = corners_from_noise(samples, STEP)
    assert found <= corners.low < 1.13 * found  # the next frequency, or a step of the search for drift after it
    assert any(flag.startswith("signal-to-noise is ") for flag in corners.flags)


@pytest.mark.parametrize("seed", range(4))
def test_the_upper_corner_is_where_the_noise_takes_over(seed):
    """exp(-πκf) with κ 0.06 s falls below √3 of the noise near 13 Hz; 10 %, as the noise there is known to 3 %."""
    samples = noisy(lambda f: brune(f, 0.2, 1.0) * np.exp(-np.pi * 0.06 * f)) + 0.05 * white(seed)
    expected = np.log(1.0 / (np.sqrt(3.0) * amplitude_of_noise(0.05, samples))) / (np.pi * 0.06)
    assert 10.0 < expected < 20.0
    assert corners_from_noise(samples, STEP).high == pytest.approx(expected, rel=0.1)


def test_an_amplitude_spectrum_is_that_of_the_motion():
    """A smooth spectrum passes window and smoothing: 4 % for the taper and for curvature within b = 20."""
    samples = noisy(lambda f: brune(f, 2.0, 1.0)) + np.random.default_rng(1).normal(0.0, 1e-6, round(LENGTH / STEP))
    spectra = signal_to_noise(samples, STEP)
    within = (spectra.frequency > 0.5) & (spectra.frequency < 40.0)
    assert spectra.signal[within] == pytest.approx(brune(spectra.frequency[within], 2.0, 1.0), rel=0.04)


def test_smoothing_agrees_with_obspy():
    """The same window of Konno and Ohmachi, in full there, within its first zeros here: 2 % of a noise."""
    from obspy.signal.konnoohmachismoothing import konno_ohmachi_smoothing

    from pounding_risk.motions.processing.noise import _smoothed

    size = 2048
    amplitudes = np.abs(np.fft.rfft(np.random.default_rng(3).normal(size=size)))
    frequency = np.fft.rfftfreq(size, STEP)
    theirs = konno_ohmachi_smoothing(amplitudes, frequency, bandwidth=BANDWIDTH, normalize=True)
    ours = _smoothed(amplitudes, STEP, size, frequency[20:])
    assert ours == pytest.approx(theirs[20:], rel=0.02)


# --- real records -----------------------------------------------------------------------------------------
def prepared(record):
    """As the chain hands it to the filter."""
    return read_trace(record, processing=[{"step": "mean"}, {"step": "taper"}]).data


@pytest.mark.parametrize(
    ("record", "low", "factor"), [("CCC-HN1", 0.0618, 1.35), ("CCC-HN2", 0.0618, 1.35), ("CCC-HNZ", 0.0247, 3.0)]
)
def test_the_corners_are_of_gmprocess_order(record, low, factor):
    """gmprocess chose 0.0618 Hz for both horizontals, 0.0247 Hz for the vertical, 37.5 Hz above.

    Ours are 0.081 and 0.072 Hz: its search takes the first corner whose drift is 2 %, ours the first from above, as
    the drift of the vertical is 5 to 10 % again between.
    """
    found = corners_from_noise(prepared(record), 0.01)
    assert low < found.low < factor * low
    assert found.high == 37.5
    assert found.flags == ()
    assert "the displacement drifts below" in found.words


def test_a_record_that_drifts_with_every_corner_is_not_said_to_stop_drifting():
    """An offset that changes sign in the shaking: the lower corner is the default, and the doubt says why."""
    samples = prepared("CCC-HN1") + np.where(np.arange(15000) > 4000, 3.0, 0.0)
    found = corners_from_noise(samples, 0.01)
    assert any("no lower corner up to 0.5 Hz" in flag for flag in found.flags)
    assert "drifts" not in found.words


def test_both_components_share_the_stricter_corners(monkeypatch):
    each = iter([Corners(0.1, 30.0, "one", ()), Corners(0.3, 40.0, "other", ())])
    monkeypatch.setattr(noise, "corners_from_noise", lambda samples, dt: next(each))
    assert shared_corners([np.zeros(2), np.zeros(2)], 0.01)[:2] == (0.3, 30.0)


def test_a_taper_before_the_filter_hides_no_noise():
    """The first second of the quiet is left out, so that the noise of a tapered record is the same."""
    plain = signal_to_noise(read_trace("CCC-HN1", processing=[{"step": "mean"}]).data, 0.01)
    tapered = signal_to_noise(prepared("CCC-HN1"), 0.01)
    assert tapered.noise == pytest.approx(
        plain.noise, rel=1e-3
    )  # the tail's taper ends the earthquake a sample earlier


def test_the_filter_tells_where_its_corners_are_from(says):
    before = [{"step": "mean"}, {"step": "taper"}]
    given = ("auto", *([*before, {"step": "bandpass", **keys}] for keys in ({"corners": "default"}, {"low": 0.2})))
    says([read_motion("CCC-HN1", processing=steps).processing[3] for steps in given])


def test_without_quiet_the_corners_are_the_default_and_say_so(says):
    found = corners_from_noise(catalogue.load("RSN6-180")[0].data, 0.01)
    assert (found.low, found.high) == (0.08, 37.5)
    says(found.words)


def test_a_record_of_noise_is_flagged():
    """Shaking at 8 to 12 Hz and none at 1 Hz."""
    samples = np.random.default_rng(0).normal(0.0, 1e-3, round(LENGTH / STEP))
    samples += noisy(lambda f: 0.1 * np.exp(-(((f - 10.0) / 2.0) ** 2)))
    found = corners_from_noise(samples, STEP)
    assert (found.low, found.high) == (0.08, 37.5)
    assert found.flags == ("at 1 Hz the earthquake is less than 2 times the noise: the record says little",)


def test_a_record_that_is_quiet_in_every_bit_has_no_noise():
    samples = prepared("CCC-HN1").copy()
    samples[:2100] = 0.0
    assert np.isinf(signal_to_noise(samples, 0.01).ratio).all()
    assert corners_from_noise(samples, 0.01).low == corners_from_noise(prepared("CCC-HN1"), 0.01).low


def test_kept_pads_bring_velocity_and_displacement_to_rest():
    """Boore (2005): with its pads the filtered motion starts and ends at rest, no baseline correction needed."""
    steps = [{"step": "mean"}, {"step": "taper"}, {"step": "bandpass", "low": 0.1, "high": 30.0, "pads": "kept"}]
    trace = read_trace("CCC-HN1", processing=steps)
    pad = 3750  # 0.75 · 5 / 0.1 Hz
    assert trace.stats.npts == 15000 + 2 * pad
    assert trace.stats.starttime == catalogue.load("CCC-HN1")[0].stats.starttime - 37.5
    motion = read_motion("CCC-HN1", processing=steps)
    velocity, displacement = motion.velocity_displacement()
    assert abs(velocity[-1]) < 1e-3 * np.abs(velocity).max()
    assert abs(displacement[-1]) < 2e-3 * np.abs(displacement).max()
    assert motion.processing[-1].endswith("37.5 s of zeros at both ends, kept")
    stripped = Step("bandpass", {"low": 0.1, "high": 30.0}).apply(prepared("CCC-HN1"), 0.01).samples
    assert np.array_equal(motion.acceleration[pad:-pad], stripped)


def test_a_motion_knows_the_band_that_its_filters_left():
    """Lowest usable frequency 1.25 times the corner, as in the flatfile of NGA-West2; of two filters the narrower."""
    record = read_motion("CCC-HN1").record
    assert record["low_corner"] == pytest.approx(0.08119, abs=5e-6)
    assert record["high_corner"] == 37.5
    assert record["lowest_usable_frequency"] == 1.25 * record["low_corner"]
    twice = [{"step": "bandpass", "low": low, "high": high} for low, high in ((0.1, 20.0), (0.05, 30.0))]
    narrow = read_motion("CCC-HN1", processing=twice).record
    assert (narrow["low_corner"], narrow["high_corner"]) == (0.1, 20.0)
    untouched = read_motion("CCC-HN1", processing=[{"step": "mean"}]).record
    assert not untouched.get("low_corner") and not untouched.get("lowest_usable_frequency")
