"""Intensity measures and response spectra against closed forms, SciPy's `lsim` and published values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import interpreted
from scipy.integrate import cumulative_simpson, trapezoid
from scipy.signal import lsim

from pounding_risk._jit import sources as _jit
from pounding_risk.errors import PoundingError
from pounding_risk.motions import catalogue
from pounding_risk.motions import intensity as measures
from pounding_risk.motions import spectra as spectrum
from pounding_risk.motions.read import read_motion

G = 9.80665
CREST = (
    4e-6  # what a local maximum may be off, of the peak, at worst; (2π / 128)⁴ / 384 = 1.5e-8 where a motion is free
)
FIELDS = ("displacement", "velocity", "acceleration")


def noise(seed: int, n: int = 400) -> np.ndarray:
    """A burst with corners at every sample: the hardest that is still linear in between."""
    random = np.random.default_rng(seed)
    return random.standard_normal(n) * np.sin(np.pi * np.arange(n) / n)


def followed(ground, dt, period, damping, parts):
    """(u, u̇, ü + a_g) from rest by SciPy: matrix exponential with the input linear over a step."""
    omega = 2.0 * np.pi / period
    state = np.array([[0.0, 1.0], [-omega * omega, -2.0 * damping * omega]])
    out = np.vstack([np.eye(2), state[1]])
    times = np.arange((ground.size - 1) * parts + 1) * dt / parts
    fine = np.interp(times, np.arange(ground.size) * dt, ground)
    return lsim((state, np.array([[0.0], [-1.0]]), out, np.zeros((3, 1))), fine, times)[1].T


def at_samples(ground, dt, period, damping=0.05):
    """(u, u̇) of the kernel, one step from sample to sample."""
    workspace, path = np.empty(spectrum.ROWS * spectrum.LANES), np.empty((ground.size, 2))
    spectrum.prepare(0, period, damping, dt, workspace)
    spectrum.follow(ground, 1, 0, workspace, path)
    return path.T


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7])
@pytest.mark.parametrize("period", [0.2, 1.0, 20.0])
def test_samples_are_scipys(period, damping):
    """To rounding, summed up over 400 steps; the short steps of the long period show that nothing cancels."""
    ground = noise(1)
    found, truth = at_samples(ground, 0.01, period, damping), followed(ground, 0.01, period, damping, 1)
    for one, other in zip(found, truth, strict=False):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.3])
def test_peaks_are_those_of_the_continuous_motion(damping):
    """Above SciPy's largest of many values, by less than those can miss; periods from 0.4 to 200 steps."""
    ground, dt, parts = noise(2, 200), 0.01, 40
    periods = np.array([0.004, 0.013, 0.05, 0.21, 0.5, 2.0])
    found = measures.response_spectra(ground, dt, periods, damping)
    for k, period in enumerate(periods):
        truth = followed(ground, dt, period, damping, parts)
        for name, row in zip(FIELDS, truth, strict=True):
            peak, value = np.abs(row).max(), getattr(found, name)[k]
            # h² / 8 of the second derivative, which np.gradient gives from the values themselves.
            bend = np.abs(np.diff(row, 2)).max() / 8.0
            assert (1.0 - CREST) * peak <= value <= (1.0 + CREST) * peak + 1.1 * bend, (name, period)


def test_step_of_acceleration():
    """Undamped: Sd = 2 a / ω², Sv = a / ω, Sa = 2 a, whatever the sampling; ground that starts at once."""
    periods = np.array([0.003, 0.02, 0.11, 0.5])
    found = measures.response_spectra(np.full(101, 3.0), 0.01, periods, 0.0)
    omega = 2.0 * np.pi / periods
    np.testing.assert_allclose(found.displacement, 6.0 / omega**2, rtol=CREST)
    np.testing.assert_allclose(found.velocity, 3.0 / omega, rtol=CREST)
    np.testing.assert_allclose(found.acceleration, 6.0, rtol=CREST)
    np.testing.assert_allclose(found.pseudo_acceleration, found.acceleration, rtol=3 * CREST)
    np.testing.assert_allclose(found.pseudo_velocity * omega, found.pseudo_acceleration, rtol=1e-14)


def test_resonance():
    """Steady state at Ω = ω: Sd = a / (2 ζ ω²), Sa = a sqrt(1 + 4 ζ²) / (2 ζ).

    After 60 periods exp(-2 π ζ 60) = 7e-9 is missing; chords of the sine are 1 - (Ω h)² / 12 = 1 - 1.3e-5 of it.
    """
    ground = np.sin(2.0 * np.pi * np.arange(30001) * 0.002)
    found = measures.response_spectra(ground, 0.002, 1.0)
    assert found.displacement[0] == pytest.approx(10.0 / (2.0 * np.pi) ** 2, rel=3e-5)
    assert found.acceleration[0] == pytest.approx(10.0 * np.sqrt(1.01), rel=3e-5)


def test_sine_over_whole_periods():
    """Sums over the chords of a sine, in closed form; to rounding."""
    n, periods, amplitude = 40, 7, 2.0
    dt, angle = 0.05, 2.0 * np.pi / n
    ground = amplitude * np.sin(angle * np.arange(n * periods + 1))
    found = measures.measure(ground, dt)
    mean_square = amplitude**2 / 2.0 * (2.0 + np.cos(angle)) / 3.0
    assert found.arias == pytest.approx(np.pi / (2.0 * G) * mean_square * n * periods * dt, rel=1e-13)
    assert found.cav == pytest.approx(2 * periods * amplitude * dt / np.tan(angle / 2.0), rel=1e-13)
    # From rest the velocity is that of 1 - cos: largest in the middle of each period.
    assert found.pgv == pytest.approx(amplitude * dt / np.tan(angle / 2.0), rel=1e-13)


def test_durations_of_a_steady_signal():
    for ground in (np.ones(1001), np.cos(np.pi * np.arange(1001))):
        found = measures.measure(ground, 0.02)
        assert (found.d5_95, found.d5_75) == (pytest.approx(18.0, rel=1e-12), pytest.approx(14.0, rel=1e-12))
        assert measures.significant_duration(ground, 0.02, (0.0, 1.0)) == pytest.approx(20.0, rel=1e-12)


def test_ground_that_does_not_move():
    found = measures.measure(np.zeros(50), 0.01)
    assert (found.pga, found.pgv, found.pgd, found.arias, found.cav) == (0.0,) * 5
    assert np.isnan([found.d5_75, found.d5_95]).all()
    still = measures.response_spectra(np.zeros(50), 0.01, [0.1, 1.0])
    assert [list(getattr(still, name)) for name in FIELDS] == [[0.0, 0.0]] * 3


SAMPLES = st.lists(st.floats(-10.0, 10.0).map(lambda x: round(x, 3)), min_size=2, max_size=9).map(np.array)


@settings(max_examples=60)
@given(SAMPLES)
def test_integrals_and_peaks_against_fine_quadrature(ground):
    """Simpson's rule on 200 parts of each interval is exact but for corners; turns are missed by (1/200)² / 8."""
    dt, parts = 0.1, 200
    times = np.arange((ground.size - 1) * parts + 1) / parts
    fine = np.interp(times, np.arange(ground.size), ground)
    v = cumulative_simpson(fine, dx=dt / parts, initial=0.0)
    u = cumulative_simpson(v, dx=dt / parts, initial=0.0)
    found = measures.measure(ground, dt)
    near = 1e-5 * np.abs(ground).max()  # the largest value missed on either side, and Simpson at a corner
    assert found.cav == pytest.approx(trapezoid(np.abs(fine), dx=dt / parts), abs=near)
    squares = cumulative_simpson(fine**2, dx=dt / parts, initial=0.0)[-1]
    assert found.arias == pytest.approx(np.pi / (2.0 * G) * squares, rel=1e-5, abs=1e-12)
    assert found.pgv == pytest.approx(np.abs(v).max(), abs=near)
    assert found.pgd == pytest.approx(np.abs(u).max(), abs=near)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.floats(1e-3, 1e3))
def test_spectra_are_linear_and_have_no_sign(seed, factor):
    ground, periods = noise(seed, 60), [0.03, 0.4, 3.0]
    once = measures.response_spectra(ground, 0.01, periods)
    turned = measures.response_spectra(-ground, 0.01, periods)
    scaled = measures.response_spectra(factor * ground, 0.01, periods)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(turned, name), getattr(once, name))
        np.testing.assert_allclose(getattr(scaled, name), factor * getattr(once, name), rtol=1e-10)
    one, other = measures.measure(ground, 0.01), measures.measure(-factor * ground, 0.01)
    for name, power in (("pga", 1), ("pgv", 1), ("pgd", 1), ("cav", 1), ("arias", 2), ("d5_75", 0), ("d5_95", 0)):
        assert getattr(other, name) == pytest.approx(factor**power * getattr(one, name), rel=1e-9), name


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(2, 60), st.sampled_from([0.0, 0.05, 0.7]))
def test_more_samples_on_the_same_lines_change_nothing(seed, n, damping):
    """Local maxima are found whichever the nodes are, also two in one step and in the first step from rest."""
    ground, periods = np.random.default_rng(seed).standard_normal(n), np.geomspace(0.004, 8.0, 12)
    finer = np.interp(np.arange(16 * (n - 1) + 1) / 16.0, np.arange(n), ground)
    once = measures.response_spectra(ground, 0.01, periods, damping)
    again = measures.response_spectra(finer, 0.01 / 16, periods, damping)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(again, name), getattr(once, name), rtol=CREST)


@pytest.mark.parametrize("lasting", [False, True])
def test_no_crest_of_many_alike_is_overlooked(lasting):
    """Blows or steps with weak noise, undamped: maxima differ by less than their nodes, and a largest node misleads."""
    periods = np.linspace(0.33, 0.9, 60)
    first, second = (1e-3 * np.random.default_rng(seed).standard_normal(900) for seed in (13, 14))
    first[: 900 if lasting else 1] += 1.0
    second[15 : 900 if lasting else 16] += 1.0  # a quarter of 0.6 s later: round in a circle
    fine = np.arange(16 * 899 + 1) / 16.0
    finer = [np.interp(fine, np.arange(900), each) for each in (first, second)]
    once = measures.response_spectra([first, second], 0.01, periods, 0.0)
    again = measures.response_spectra(finer, 0.01 / 16, periods, 0.0)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(once, name), getattr(again, name), rtol=CREST)
    turned = measures.rotated_spectra((first, second), 0.01, periods[::3], 0.0)
    truth = measures.rotated_spectra((finer[0], finer[1]), 0.01 / 16, periods[::3], 0.0)
    np.testing.assert_allclose(turned.acceleration, truth.acceleration, rtol=1e-5)


def test_many_records_at_once():
    """Whatever their lengths and steps, and the periods in any order: the same bits as each alone."""
    records, steps = [noise(6, 300), noise(7, 33), noise(8, 2)], [0.01, 0.02, 0.005]
    periods = np.array([1.0, 0.05, 0.3, *np.geomspace(0.02, 5.0, 20)])
    together = measures.response_spectra(records, steps, periods)
    assert together.acceleration.shape == (3, periods.size)
    for k, (record, dt) in enumerate(zip(records, steps, strict=True)):
        alone = measures.response_spectra(record, dt, periods)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(together, name)[k], getattr(alone, name))


def test_rotated_components():
    """Along 0° and 90° the components themselves; one alone projects as |cos|; the basis does not matter."""
    first, second, periods = noise(9), noise(10), [0.1, 1.0]
    found = measures.rotated_spectra((first, second), 0.01, periods)
    for column, ground in ((0, first), (90, second)):
        alone = measures.response_spectra(ground, 0.01, periods)
        # Local maxima between nodes of a coarser path: what their cubics are off.
        np.testing.assert_allclose(found.acceleration[:, column], alone.pseudo_acceleration, rtol=1e-5)
    c, s = np.cos(np.deg2rad(30)), np.sin(np.deg2rad(30))
    turned = measures.rotated_spectra((c * first + s * second, c * second - s * first), 0.01, periods)
    np.testing.assert_allclose(np.roll(found.acceleration, -30, axis=1), turned.acceleration, rtol=1e-10)
    for percentile in (50, 100):
        assert turned.rotd_pga(percentile) == pytest.approx(found.rotd_pga(percentile), rel=1e-10)
    one = measures.rotated_spectra((first, 0.0 * first), 0.01, periods)
    away = np.abs(np.cos(np.deg2rad(measures.ANGLES)))
    np.testing.assert_allclose(one.acceleration, one.rotd(100)[:, None] * away, rtol=1e-9, atol=1e-15)


# RotD50 of PGA and of PSA at 5 % [g], from the flatfile of NGA-West2 (PEER 2013).
FLATFILE = {
    ("RSN77-164", "RSN77-254", 1.2217): {0.5: 2.110259, 1.0: 1.031737, 3.0: 0.1555216},
    ("RSN753-000", "RSN753-090", 0.5): {0.2: 1.044453, 1.0: 0.5048154, 3.0: 0.07374632},
}


@pytest.mark.parametrize("record", FLATFILE, ids=lambda record: record[0])
def test_rotd50_of_the_flatfile(record):
    """The flatfile's numbers are of values at samples: those to its digits, the peaks above by what samples miss."""
    traces = [catalogue.load(name)[0] for name in record[:2]]
    dt, n = traces[0].stats.delta, min(len(trace) for trace in traces)
    first, second = (trace.data[:n].astype(float) for trace in traces)
    periods = np.array(list(FLATFILE[record]))
    found = measures.rotated_spectra((first, second), dt, periods)
    assert found.rotd_pga(50) / G == pytest.approx(record[2], rel=5e-5)  # half of its last digit
    angles = np.deg2rad(measures.ANGLES)
    for k, (period, published) in enumerate(FLATFILE[record].items()):
        x, y = at_samples(first, dt, period)[0], at_samples(second, dt, period)[0]
        sampled = np.abs(np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y)).max(axis=1)
        assert np.median(sampled) * (2.0 * np.pi / period) ** 2 / G == pytest.approx(published, rel=3e-6)
        # h² / 8 max|ü|, and |ü| is at most that of the oscillator, a little above PSA, and that of the ground.
        missed = (2.0 * np.pi / period * dt) ** 2 / 8.0 * 1.1 * (1.0 + found.rotd_pga(100) / G / published)
        assert published * (1.0 - 3e-6) <= found.rotd(50)[k] / G <= published * (1.0 + missed)


def test_eqsig_on_el_centro():
    """What eqsig 1.2.17 finds with values at samples and the trapezoidal rule, and how far that is from lines."""
    motion = read_motion("RSN6-180")
    a, dt = motion.acceleration, motion.dt
    found = measures.measure(a, dt)
    # A local maximum between samples is at most h |a| / 8 above, one of u h |v| / 8.
    assert 0.309287 <= found.pgv <= 0.309287 + dt * found.pga / 8.0
    assert 0.0866122 <= found.pgd <= 0.0866124 + dt * found.pgv / 8.0
    # The trapezoidal rule takes a line's square for larger than it is, by h (a1 - a0)² / 6.
    above = np.pi / (2.0 * G) * dt / 6.0 * float((np.diff(a) ** 2).sum())
    assert (found.arias + above) * G / 9.81 == pytest.approx(1.5551295, rel=1e-7)  # its g is 9.81 m/s²
    assert found.cav == pytest.approx(13.30923, rel=5e-3)  # eqsig adds what a sign change takes away
    # It counts from the first sample inside to the last one, up to 2 h less, on the trapezoidal curve.
    assert 0.0 <= found.d5_95 - 24.17 <= 3 * dt
    assert 0.0 <= found.d5_75 - 12.16 <= 3 * dt


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: measures.measure([1.0], 0.01), "1 sample; a record needs at least 2"),
        (lambda: measures.measure([1.0, np.nan], 0.01), "1 sample is not finite"),
        (lambda: measures.measure([1.0, 2.0], 0.0), "time step is 0 s"),
        (lambda: measures.response_spectra([[1.0, 2.0], [1.0]], 0.01, 1.0), "record 1: has 1 sample"),
        (lambda: measures.response_spectra([1.0, 2.0], 0.01, [1.0, 9e-4]), "period 0.0009 s .* at least 0.001 s"),
        (lambda: measures.response_spectra([1.0, 2.0], 0.01, np.inf), "period inf s"),
        (lambda: measures.response_spectra([1.0, 2.0], 0.01, 1.0, 5.0), "damping 5 is out of range: .* 5 % is 0.05"),
        (lambda: measures.rotated_spectra(([1.0, 2.0, 0.0], [1.0, 2.0]), 0.01, 1.0), "3 and 2 samples"),
    ],
)
def test_what_cannot_be_measured_is_told(call, told):
    with pytest.raises(PoundingError, match=told):
        call()


def bits() -> list[str]:
    """Every bit of spectra and directions on a small case that has local maxima between nodes."""
    first, second, periods = noise(11, 50), noise(12, 50), [0.01, 0.1, 0.5]
    found = measures.response_spectra([first, second], 0.01, periods)
    rotated = measures.rotated_spectra((first, second), 0.01, periods)
    values = [*(getattr(found, name) for name in FIELDS), rotated.acceleration]
    return [float(value).hex() for array in values for value in array.ravel()]


@pytest.mark.skipif(_jit.INTERPRETED, reason="NUMBA_DISABLE_JIT is set: there is nothing compiled")
@pytest.mark.complete
def test_interpreted_spectra_are_the_same_bits():
    code = "import json, test_intensity; print(json.dumps(test_intensity.bits()))"
    assert interpreted(code) == bits()
