"""Each check of quality fires on a record damaged for it, and none on the good ones that come with the project."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pounding_risk.motions import catalogue
from pounding_risk.motions.quality import CHECKS, LASTING, Finding, failed, quality
from pounding_risk.motions.read import read_motion

GOOD = [entry.id for entry in catalogue.entries() if not entry.id.startswith("RSN1690")]
RAW = [entry.id for entry in catalogue.entries() if entry.state == "raw"]
NOT_YET_AT_REST = {"offset", "velocity at the end", "displacement at the end", "tail"}


def samples(record="RSN6-180"):
    trace = catalogue.load(record)[0]
    return trace.data.astype(float), trace.stats.delta


def fails(found):
    return {finding.check for finding in found if not finding.passed}


@pytest.mark.parametrize("record", GOOD)
def test_good_records_pass_every_check(record):
    motion = read_motion(record)
    assert failed(quality(motion.acceleration, motion.dt, shortest_period=0.2)) == ()
    assert motion.flags == ()


@pytest.mark.parametrize("record", RAW)
def test_a_raw_record_fails_only_what_processing_mends(record):
    found = quality(*samples(record), state="raw")
    assert fails(found) <= NOT_YET_AT_REST
    assert {"quiet before", "signal-to-noise"} <= {finding.check for finding in found}


def clipped(a):
    return np.clip(a, -0.6 * np.abs(a).max(), 0.6 * np.abs(a).max())


def spiked(a):
    a[2000] += 0.5 * np.abs(a).max()
    return a


def glitch(place, count):
    """The record with ``count`` samples moved by its PGA."""

    def damage(a):
        a[place : (place + count) or None] += np.abs(a).max()
        return a

    return damage


def clipped_with_noise(a):
    """Counts of a 16-bit digitiser, of which the noise after the clipping moves the plateau by 3."""
    counts = clipped(a) / np.abs(a).max() * 2**15
    return np.round(counts) + np.random.default_rng(1).integers(-3, 4, len(a))


def held(share, seconds=0.5, dt=0.01):
    """The record with its value where a share of the energy is reached held for some time."""

    def damage(a):
        start = np.searchsorted(np.cumsum((a - a.mean()) ** 2), share * np.sum((a - a.mean()) ** 2))
        a[start : start + round(seconds / dt)] = a[start]
        return a

    return damage


def noisy(a):
    """White noise as strong as the shaking at 0.3 Hz: 12 % of PGA."""
    return a + np.random.default_rng(0).normal(0.0, 0.12 * np.abs(a).max(), len(a))


def with_a_level(share):
    return lambda a: a + share * np.abs(a).max()


DAMAGES = [
    ("time step", "RSN6-180", lambda a: a[::3], 0.03, {}),
    ("time step of the stiffest building", "RSN6-180", lambda a: a, 0.01, {"shortest_period": 0.05}),
    ("period of the softest building", "RSN6-180", lambda a: a, 0.01, {"longest_period": 8.1, "usable": 0.125}),
    ("duration", "CCC-HN1", lambda a: a[:2600], 0.01, {"state": "raw"}),
    ("quiet before", "CCC-HN1", lambda a: a[np.argmax(np.abs(a)) - 100 :], 0.01, {"state": "raw"}),
    ("signal-to-noise", "CCC-HN1", noisy, 0.01, {"state": "raw"}),
    ("clipping", "RSN6-180", clipped, 0.01, {}),
    ("clipping", "NAPA-HNZ", clipped, 0.005, {"state": "raw"}),
    ("clipping", "RSN77-DWN", clipped, 0.01, {}),
    ("clipping", "RSN6-180", clipped_with_noise, 0.01, {}),
    ("clipping", "CCC-HN1", clipped_with_noise, 0.01, {"state": "raw"}),
    ("spikes", "RSN6-180", spiked, 0.01, {}),
    ("spikes", "RSN6-180", glitch(0, 1), 0.01, {}),
    ("spikes", "RSN6-180", glitch(-1, 1), 0.01, {}),
    ("spikes", "RSN6-180", glitch(2000, 2), 0.01, {}),
    ("spikes", "CCC-HN1", glitch(7000, 3), 0.01, {"state": "raw"}),
    ("held values", "RSN6-180", held(0.3), 0.01, {}),
    ("held values", "CCC-HN1", held(0.5), 0.01, {"state": "raw"}),
    ("held values", "NAPA-HNN", held(0.9, dt=0.005), 0.005, {"state": "raw"}),
    ("spikes", "CCC-HNZ", spiked, 0.01, {"state": "raw"}),
    ("offset", "RSN6-180", with_a_level(0.06), 0.01, {}),
    ("late trigger", "RSN6-180", lambda a: a[213:], 0.01, {}),
    ("zero crossings", "RSN6-180", lambda a: a + np.linspace(-40.0, 40.0, len(a)), 0.01, {}),
    ("velocity at the end", "RSN6-180", with_a_level(0.002), 0.01, {}),
    ("displacement at the end", "RSN6-180", with_a_level(0.0002), 0.01, {}),
    ("tail", "RSN6-180", lambda a: a[:1000], 0.01, {}),
]


def test_every_check_has_a_damage():
    assert {damage[0] for damage in DAMAGES} == set(CHECKS)


@pytest.mark.parametrize(("name", "record", "damage", "dt", "options"), DAMAGES)
def test_a_damaged_record_fails_its_check(name, record, damage, dt, options):
    whole, step = samples(record)
    before = quality(whole, step, **{**options, "shortest_period": 0.5, "longest_period": 2.0})
    assert name not in fails(before)
    assert name in fails(quality(damage(whole), dt, **options))


def test_a_finding_says_what_was_found_and_what_is_allowed(says):
    a, dt = samples()
    findings = quality(clipped(a), dt, shortest_period=0.05)
    says([f"{each.check}: {each.found}; {each.allowed}; {each.passed}" for each in findings], failed(findings))


def test_a_record_of_nothing_is_told():
    assert quality(np.zeros(500), 0.01) == (Finding("motion", "every sample is the same", "a motion", False),)


@settings(max_examples=25)
@given(st.floats(1e-3, 1e3), st.booleans(), st.sampled_from([clipped, spiked, with_a_level(0.06), lambda a: a]))
@pytest.mark.complete
def test_unit_and_polarity_do_not_matter(factor, turned, damage):
    """Findings are ratios: the same record in another unit, or upside down, fails the same checks."""
    a, dt = samples()
    a = damage(a)
    assert fails(quality((-factor if turned else factor) * a, dt)) == fails(quality(a, dt))


@settings(max_examples=40)
@given(st.integers(10, 5300), st.sampled_from([-1.0, 1.0]), st.floats(1.0, 50.0))
@pytest.mark.complete
def test_a_spike_is_found_wherever_it_is(place, side, size):
    """From the record's PGA on, on top of whatever the motion does there."""
    a, dt = samples()
    a[place] += side * size * np.abs(a).max()
    found = {finding.check: finding for finding in quality(a, dt)}["spikes"]
    assert not found.passed
    assert found.found == f"a single sample sticks out at {place * dt:.4g} s"


@settings(max_examples=40)
@given(st.integers(0, 5300), st.sampled_from([-1.0, 1.0]), st.floats(2.0, 50.0), st.sampled_from([2, 3]))
@pytest.mark.complete
def test_a_glitch_of_two_or_three_samples_is_found_wherever_it_is(place, side, size, count):
    """From twice the record's PGA on, as the shaking at its peak bends by half of it in two samples."""
    a, dt = samples()
    a[place : place + count] += side * size * np.abs(a).max()
    (found,) = quality(a, dt, checks=("spikes",))
    assert found.found.startswith("two or three samples stick out at ")
    assert place * dt <= float(found.found.split()[-2]) + 0.01 < (place + count + 1) * dt


@settings(max_examples=40)
@given(st.integers(175, 3400), st.integers(10, 60))
@pytest.mark.complete
def test_a_held_value_is_found_wherever_the_ground_shakes(place, count):
    """Samples 175 to 3492 hold 1 to 99 % of the energy."""
    a, dt = samples()
    a[place : place + count] = a[place]
    assert fails(quality(a, dt, checks=("held values",))) == {"held values"}


def test_what_is_no_held_value():
    """Quiet before, between and after two earthquakes, and digits so coarse that the ground moves by few of them."""
    a, dt = samples()
    quiet = np.zeros(2000)
    coarse = np.round(a / np.abs(a).max() * 20.0)
    for good in (np.concatenate([quiet, a, quiet, a, quiet]), coarse):
        assert fails(quality(good, dt, checks=("held values",))) == set()


def test_a_record_that_starts_and_ends_in_motion_has_no_spike_there():
    """A cosine of 1 Hz from its steepest place or its top: 100 samples a period, as smooth as they come."""
    for phase in (0.0, 0.25, 0.6):
        wave = np.cos(2.0 * np.pi * (np.arange(1001) * 0.01 + phase))
        assert fails(quality(wave, 0.01, checks=("spikes",))) == set()


# --- flags of a motion ------------------------------------------------------------------------------------


HARMS = {
    "clipped": clipped,
    "spiked": spiked,
    "first": glitch(0, 1),
    "two": glitch(2000, 2),
    "held": held(0.5),
    "plateau": clipped_with_noise,
    "level": with_a_level(0.002),
    "cut": lambda a: a[:1000],
}


@pytest.mark.parametrize("words", HARMS)
def test_what_fails_is_a_flag_of_the_motion(words, says):
    trace = catalogue.load("RSN6-180")[0]
    trace.data = HARMS[words](trace.data.astype(float))
    says(read_motion(trace).flags)


def test_a_generated_motion_has_no_fault_of_an_instrument():
    """A constant acceleration is clipped and held by its formula, and as short as is wanted, whatever steps follow."""
    flags = read_motion("constant_acceleration: pga=0.2 g, duration=2 s", processing=[{"step": "taper"}]).flags
    assert not {flag.partition(":")[0] for flag in flags} & set(LASTING)


def test_a_flag_is_about_the_record_and_not_about_a_window_of_it():
    assert read_motion("RSN6-180", window=(0.0, 4.0)).flags == ()


def test_drift_is_flagged_unless_it_was_corrected():
    drifts = {"displacement at the end", "tail"}
    flags = read_motion("CCC-HN1", processing=[{"step": "mean"}]).flags
    assert drifts <= {flag.partition(":")[0] for flag in flags}
    for scheme in ("polynomial", "bilinear"):
        steps = [{"step": "mean"}, {"step": "baseline", "scheme": scheme}]
        assert not drifts & {flag.partition(":")[0] for flag in read_motion("CCC-HN1", processing=steps).flags}


def test_what_lasts_is_checked_before_the_chain():
    """A filter rounds flat tops off; they are seen in the record as it came."""
    trace = catalogue.load("RSN6-180")[0]
    trace.data = clipped(trace.data)
    steps = [{"step": "bandpass", "low": 0.1, "high": 20.0}]
    assert any(flag.startswith("clipping: ") for flag in read_motion(trace, processing=steps).flags)
    assert set(LASTING) < set(CHECKS)
