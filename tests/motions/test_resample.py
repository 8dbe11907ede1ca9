"""A record at another time step: what stays, what is band-limited, what is flagged."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sentences import refusal

from pounding_risk.motions import catalogue
from pounding_risk.motions.processing import Step
from pounding_risk.motions.read import read_motion, read_trace


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
