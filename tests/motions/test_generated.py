"""Generated motions: formulas against closed forms and integrators, noise within its sampling bounds, and as records.

Velocity and displacement of the ground, and the response of oscillators, are those of formulas that are written here
again, from the sources that the kinds name.
"""

import json
import sys
import tomllib
from itertools import pairwise
from math import cos, exp, log, pi, sin, sqrt
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import scene_text
from scipy import signal
from scipy.integrate import quad, solve_ivp
from scipy.special import erf, fresnel
from scipy.stats import chi2
from sentences import refusal
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.errors import SceneError
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions import generated
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.generated import motion_kinds, recipe
from pounding_risk.motions.generated._forms import AIM
from pounding_risk.motions.generated.noise import normal_numbers, read_envelope
from pounding_risk.motions.manifest import write_manifest
from pounding_risk.motions.record import recording_numbers
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.notes import unused_keys
from pounding_risk.solver.pair.api import free_response, oscillators

# ---------------------------------------------------------------- formulas: acceleration, velocity, displacement


def ricker(t, pga=3.0, period=0.8):
    """(1 − 2x) e^−x is the derivative of τ e^−x, which is that of −e^−x period²/(2π²)."""
    tau = t - 1.8 * period
    x = (pi * tau / period) ** 2
    return pga * (1 - 2 * x) * np.exp(-x), pga * tau * np.exp(-x), -pga * period**2 / (2 * pi**2) * np.exp(-x)


def antisymmetric_ricker(t, pga=3.0, period=0.8):
    """Hermite functions: (He₃ e)' = −He₄ e, so that the integrals of He₃ are −He₂ and He₁; β of s² = 3 − √6."""
    k = 2 * pi / (sqrt(3) * period)
    s = k * (t - 2.2 * period)
    beta = sqrt(6) * sqrt(3 - sqrt(6)) * exp(-(3 - sqrt(6)) / 2)
    assert beta == pytest.approx(1.3801, abs=5e-5), "of Vassiliou and Makris"
    size, gauss = pga / beta, np.exp(-(s**2) / 2)
    return size * s * (s**2 - 3) * gauss, -size / k * (s**2 - 1) * gauss, size / k**2 * s * gauss


def gabor(t, velocity=0.7, period=1.1, width=2.0, phase=0.5):
    """The displacement is the real part of ∫ exp(−(ωτ/γ)² + i(ωτ + ν)), by the error function of a complex number."""
    w = 2 * pi / period
    p = w * (t - 0.9 * width * period)
    bell = np.exp(-((p / width) ** 2))
    slope = -w * (2 * p / width**2 * np.cos(p + phase) + np.sin(p + phase))
    area = width * sqrt(pi) / 2 * exp(-(width**2) / 4) * np.exp(1j * phase) * erf(p / width - 0.5j * width)
    return velocity * slope * bell, velocity * bell * np.cos(p + phase), velocity / w * np.real(area)


def mavroeidis(t, velocity=0.7, period=0.9, width=1.7, phase=0.5):
    """v as a sum of three cosines; the published displacement."""
    w = 2 * pi / period
    p = w * (t - width * period / 2)
    parts = [(1.0, 1.0), (0.5, 1 + 1 / width), (0.5, 1 - 1 / width)]
    a = sum(-share * rate * np.sin(rate * p + phase) for share, rate in parts)
    v = sum(share * np.cos(rate * p + phase) for share, rate in parts)
    d = sum(share / rate * np.sin(rate * p + phase) for share, rate in parts)
    return velocity * w / 2 * a, velocity / 2 * v, velocity / (2 * w) * d


def harmonic(t, pga=2.0, period=0.5, phase=0.4):
    w = 2 * pi / period
    v = pga / w * (cos(phase) - np.cos(w * t + phase))
    return pga * np.sin(w * t + phase), v, pga / w * (t * cos(phase) - (np.sin(w * t + phase) - sin(phase)) / w)


def linear_sweep(t, pga=2.0, start=0.5, end=3.0, duration=4.0):
    """Fresnel's integrals, of sin(π/2 (s² − s₀²)) with s = (start + k t) √(2/k); the displacement is not needed."""
    k = (end - start) / duration
    s, s0 = (start + k * t) * sqrt(2 / k), start * sqrt(2 / k)
    (sine, cosine), (sine0, cosine0) = fresnel(s), fresnel(s0)
    back, scale = pi / 2 * s0**2, pga / sqrt(2 * k)
    v = scale * (cos(back) * (sine - sine0) - sin(back) * (cosine - cosine0))
    return pga * np.sin(2 * pi * (start * t + k * t**2 / 2)), v, None


def exponential_sweep(t, pga=2.0, start=0.5, end=3.0, duration=4.0):
    return (
        pga * np.sin(2 * pi * start * duration * ((end / start) ** (t / duration) - 1) / log(end / start)),
        None,
        None,
    )


def constant(t, pga=1.5, duration=2.0, rise=0.25):
    """A trapezoid, piece by piece."""
    up, down = np.clip(t, 0, rise), np.clip(t - (duration - rise), 0, rise)
    a = pga * (up - down) / rise
    v = pga * (up**2 / (2 * rise) + np.maximum(t - rise, 0) - down**2 / (2 * rise) - np.maximum(t - duration, 0))
    d = (np.minimum(t, rise) ** 3 / 6 / rise) + np.where(t > rise, (t - rise) * rise / 2 + (t - rise) ** 2 / 2, 0)
    return a, v, pga * (d - down**3 / (6 * rise))


FORMULAS = {
    "ricker": (ricker, {"pga": 3.0, "period": 0.8}),
    "antisymmetric ricker": (antisymmetric_ricker, {"pga": 3.0, "period": 0.8, "shape": "antisymmetric"}),
    "gabor": (gabor, {"velocity": 0.7, "period": 1.1, "width": 2.0, "phase": np.degrees(0.5)}),
    "mavroeidis_papageorgiou": (mavroeidis, {"velocity": 0.7, "period": 0.9, "width": 1.7, "phase": np.degrees(0.5)}),
    "harmonic": (harmonic, {"pga": 2.0, "period": 0.5, "cycles": 6.0, "phase": np.degrees(0.4)}),
    "linear swept_sine": (
        linear_sweep,
        {"pga": 2.0, "start": 0.5, "end": 3.0, "duration": 4.0, "sweep": "linear", "rise": 0.0},
    ),
    "exponential swept_sine": (exponential_sweep, {"pga": 2.0, "start": 0.5, "end": 3.0, "duration": 4.0, "rise": 0.0}),
    "constant_acceleration": (constant, {"pga": 1.5, "duration": 2.0, "rise": 0.25}),
}
GIVEN = pytest.mark.parametrize("name", FORMULAS)


def asked(name):
    """The formula of a motion, and its recipe."""
    formula, keys = FORMULAS[name]
    return formula, recipe(name.rpartition(" ")[2], **keys)


def integrated(function, duration, times, corners=()):
    """y' = function(t, y) from rest at the start, by DOP853 with steps that end at corners of the function."""
    size = 2
    state, found = np.zeros(size), np.zeros((size, len(times)))
    edges = [0.0, *sorted(corner for corner in corners if 0.0 < corner < duration), duration]
    for start, end in pairwise(edges):
        inside = (times >= start) & (times <= end)
        solved = solve_ivp(
            function, (start, end), state, "DOP853", dense_output=True, rtol=1e-13, atol=1e-15, max_step=0.02
        )
        found[:, inside] = solved.sol(times[inside])
        state = solved.y[:, -1]
    return found


@GIVEN
def test_samples_are_those_of_the_formula_and_the_ground_moves_as_it_says(name):
    """Samples to rounding; velocity and displacement of the formula against DOP853 on it, to 1e-9 of the peak."""
    formula, wanted = asked(name)
    (source,) = wanted.sources()
    step, samples = source.trace.stats.delta, source.trace.data
    duration = wanted.form().duration
    times = np.minimum(step * np.arange(round(duration / step) + 1), duration)
    acceleration, velocity, displacement = formula(times)
    assert_allclose(samples[: len(times)], acceleration, rtol=0, atol=1e-11)
    corners = (0.25, 1.75) if formula is constant else ()
    places = np.linspace(0.0, duration, 300)
    own = wanted.form().acceleration
    found = integrated(lambda t, y: [y[1], float(own(np.array([t]))[0])], duration, places, corners)
    _, velocity, displacement = formula(places)
    for numbers, closed in ((found[1], velocity), (found[0], displacement)):
        if closed is not None:
            assert_allclose(numbers, closed - closed[0], rtol=0, atol=1e-9 * np.abs(closed).max())


@pytest.mark.parametrize(
    ("name", "left"),
    [
        ("ricker", 0.0),
        ("antisymmetric ricker", 0.0),
        ("gabor", 0.7 * sqrt(pi) * 2.0 / (2 * pi / 1.1) * exp(-1.0) * cos(0.5)),
        ("mavroeidis_papageorgiou", 0.7 * sin(1.7 * pi) * cos(0.5) / (2 * pi / 0.9 * (1 - 1.7**2))),
    ],
)
def test_pulses_leave_the_displacement_of_their_docstrings(name, left):
    """And no velocity, to the error of the trapezoidal rule at their step, and of their ends."""
    _, wanted = asked(name)
    motion = pr.read_motion(wanted)
    velocity, displacement = motion.velocity_displacement()
    assert abs(velocity[-1]) < 2e-5 * np.abs(velocity).max()
    assert displacement[-1] == pytest.approx(left, abs=2e-4 * np.abs(displacement).max())


@pytest.mark.complete
def test_ground_that_does_not_move_lets_a_release_be_run():
    """A mass that moves against a stop, published as 9950 N (code_aster V5.01.101, SDND101): v0 √m K/√(k + K)."""
    mass = {"name": "mass", "mass": "100 kg", "stiffness": "10 kN/m", "damping": 0.0, "initial_velocity": "1 m/s"}
    contact = pr.Interface(gap="0 mm", contact_model="linear", stiffness="1 MN/m")
    still = pr.Records(generated=[{"kind": "still", "duration": "1 s"}])
    scene = pr.Scene([mass, {"name": "stop", "rigid": True}], [contact], still, solver={"rtol": 1e-10})
    found = pr.simulate(scene)
    assert float(found["peak_contact_force"].squeeze()) == pytest.approx(10.0 * 1e6 / np.sqrt(1.01e6), rel=1e-9)
    assert not any("still" in sentence for sentence in pr.validate(scene).notes)


def test_constant_acceleration_ends_with_a_velocity_and_a_jump_is_told():
    motion = pr.generate_motion("constant_acceleration", pga=1.5, duration="2 s", rise="0.25 s")
    assert motion.velocity_displacement()[0][-1] == pytest.approx(1.5 * 1.75, rel=1e-12)
    assert "the ground ends with the velocity 2.625 m/s at the displacement 2.625 m" in motion.processing
    assert motion.acceleration[0] == motion.acceleration[-1] == 0.0 and not motion.flags
    jump = pr.generate_motion("constant_acceleration", pga="0.1 g", duration="2 s", rise="0 s")
    assert jump.acceleration[0] == jump.acceleration[-2] == pytest.approx(0.980665) and jump.acceleration[-1] == 0.0
    starts, ends = jump.flags
    assert starts == "the acceleration starts with a jump from 0 to 0.1 g, on ground at rest"
    assert ends == "the acceleration falls from 0.1 g to 0 within one step of 0.01 s at its end"


# ---------------------------------------------------------------- oscillators


@pytest.mark.parametrize("name", sweep(FORMULAS, "gabor", "linear swept_sine", "harmonic"))
def test_an_oscillator_moves_as_under_the_formula(name):
    """The solver at a step of 1e-5 of the fastest period or less, against DOP853 on the formula: 1e-9 of the peak.

    Straight lines between samples of a sine take (ωh)²/12 = 3e-10 of it then.
    """
    formula, wanted = asked(name)
    form = wanted.form()
    periods = form.duration / form.shortest_period
    steps = 2000 if formula is constant else round(periods / (7e-6 if periods < 5 else 1e-5))
    step = form.duration / steps
    samples = form.sampled(step, 0).samples[: steps + 1]
    left, right = Building("left", 1e4, 0.31, 0.03), Building("right", 1e4, 0.7, 0.1)
    free = free_response(oscillators(left, right), samples, step)
    assert len(free.states) == steps + 1
    places = np.linspace(0, steps, 400).astype(int)
    corners = (0.25, 1.75) if formula is constant else ()
    for number, (period, ratio) in enumerate(((0.31, 0.03), (0.7, 0.1))):
        w = 2 * pi / period

        def motion(t, y, w=w, ratio=ratio):
            ground = float(formula(np.array([t]))[0][0])
            return [y[1], -ground - 2 * ratio * w * y[1] - w * w * y[0]]

        found = integrated(motion, form.duration, np.minimum(step * places, form.duration), corners)[0]
        assert_allclose(free.states[places, number], found, rtol=0, atol=1e-9 * np.abs(found).max())


def test_a_coarse_harmonic_has_the_amplitude_that_its_docstring_says():
    """sinc²(π h/T) of it: the steady response at its own frequency, against that of the formula."""
    period, step, ratio = 0.5, 0.025, 0.05
    samples = pr.generate_motion("harmonic", pga=1.0, period=period, cycles=60, step=step).acceleration
    building = Building("one", 1e4, 0.4, ratio)
    fine = np.interp(np.arange(0, 60 * period, step / 50), step * np.arange(len(samples)), samples)
    free = free_response(oscillators(building, building), fine, step / 50)
    per_cycle = round(period / step * 50)
    last = free.states[-4 * per_cycle - 1 : -1, 0]
    amplitude = 2 * abs(np.mean(last * np.exp(-2j * pi * np.arange(len(last)) / per_cycle)))
    r = 0.4 / period
    closed = (0.4 / (2 * pi)) ** 2 / sqrt((1 - r**2) ** 2 + (2 * ratio * r) ** 2)
    assert amplitude / closed == pytest.approx(np.sinc(step / period) ** 2, rel=2e-5)
    assert np.sinc(step / period) ** 2 == pytest.approx(1 - (2 * pi * step / period) ** 2 / 12, abs=1e-4)


# ---------------------------------------------------------------- the step and its error


@pytest.mark.parametrize("step", [0.0125, 0.005, 0.001])
@pytest.mark.parametrize("name", ["harmonic", "ricker", "gabor"])
def test_the_error_of_the_step_is_that_of_straight_lines(name, step):
    """h²/8 max|a''|, where the curvature is largest at the largest acceleration: harmonic (ω²) and Ricker (6π²/T²)."""
    _, wanted = asked(name)
    form = wanted.form()
    curvature = {"harmonic": (2 * pi / 0.5) ** 2, "ricker": 6 * (pi / 0.8) ** 2}.get(name)
    if curvature is None:
        times = np.linspace(0, form.duration, 200001)
        values = form.acceleration(times)
        curvature = np.abs(np.diff(values, 2)).max() / (times[1] ** 2 * np.abs(values).max())
    assert form.sampled(step, 0).error == pytest.approx(step**2 / 8 * curvature, rel=0.02)


@GIVEN
def test_the_step_that_is_chosen_is_round_and_fine_enough(name):
    _, wanted = asked(name)
    (source,) = wanted.sources()
    assert source.record["interpolation_error"] <= AIM
    step, form = source.trace.stats.delta, wanted.form()
    assert 2 * form.sampled(4 * step, 0).error > AIM or step >= 0.005, "finer than it need be"
    assert form.duration / step == pytest.approx(round(form.duration / step), abs=1e-6)
    assert any("straight lines between samples are within" in sentence for sentence in source.trace.stats.processing)


TOO_LONG = {
    "ricker": ("ricker", {"pga": 3.0, "period": "0.8 s", "step": "0.2 s"}),
    "samples": ("harmonic", {"pga": 1.0, "period": 0.5, "step": 1e-8}),
    "filter": ("kanai_tajimi", {"rms": 1.0, "duration": 20.0, "step": 0.05}),
}


@pytest.mark.parametrize("words", TOO_LONG)
def test_a_step_that_does_not_fit_is_refused_with_one_that_does(words, says):
    kind, keys = TOO_LONG[words]
    told = refusal(pr.generate_motion, kind, **keys)
    says(told)
    if words == "ricker":
        keys["step"] = told.partition('such as "')[2].partition('"')[0]
        assert pr.generate_motion(kind, **keys).record["interpolation_error"] <= AIM


@pytest.mark.complete
def test_a_step_that_makes_too_many_samples_is_refused(says):
    says(refusal(pr.generate_motion, "swept_sine", pga=1.0, start=1.0, end=1000.0, duration=1e5))


# ---------------------------------------------------------------- noise


def kanai_tajimi(w, wg=2 * pi * 2.5, z=0.6):
    r = w / wg
    return (1 + 4 * z * z * r * r) / ((1 - r * r) ** 2 + 4 * z * z * r * r)


def clough_penzien(w, wf=2 * pi * 0.25, z=0.6):
    r = w / wf
    return kanai_tajimi(w) * r**4 / ((1 - r * r) ** 2 + 4 * z * z * r * r)


SPECTRA = {"kanai_tajimi": kanai_tajimi, "clough_penzien": clough_penzien}
FILTERED = pytest.mark.parametrize("name", SPECTRA)


def stationary(name, seed, duration=200.0, **keys):
    """Samples of noise without an envelope, S₀ = 0.01 m²/s³, without the zero at the end."""
    keys = {"psd": 0.01, "duration": duration, "envelope": "none", "seed": seed} | keys
    return pr.generate_motion(name, **keys).acceleration[:-1]


@FILTERED
def test_variance_and_correlation_are_the_integrals_of_the_spectrum(name):
    made = recipe(name, psd=1.0, duration=20.0).form().filter
    spectrum = SPECTRA[name]
    variance = 2 * quad(spectrum, 0, 60, limit=500)[0] + 2 * quad(spectrum, 60, np.inf, limit=500)[0]
    assert made.variance() == pytest.approx(variance, rel=1e-8)
    for lag in (0.005, 0.1, 1.0):
        integral = 2 * quad(spectrum, 0, np.inf, weight="cos", wvar=lag, limit=2000)[0]
        assert made.correlation(lag) == pytest.approx(integral / variance, abs=1e-6)


def test_the_variance_of_kanai_and_tajimi_is_its_closed_form():
    wg, z = 2 * pi * 3.2, 0.35
    made = recipe("kanai_tajimi", psd=1.0, duration=20.0, frequency=3.2, damping=z).form()
    assert made.filter.variance() == pytest.approx(pi * wg * (1 + 4 * z * z) / (2 * z), rel=1e-12)
    asked = recipe("kanai_tajimi", rms=2.0, duration=20.0, frequency=3.2, damping=z).form()
    assert asked.density(0.005) * made.filter.variance() == pytest.approx(4.0, rel=1e-12)


@FILTERED
@pytest.mark.parametrize("step", sweep([0.005, 0.02], 0.02))
def test_the_variance_of_samples_is_within_its_sampling_bounds(name, step):
    """Over 6 seeds: chi-square with N²/Σρ² degrees of freedom, whatever the step; the bounds hold 99.9 % of cases."""
    made = recipe(name, psd=0.01, duration=200.0).form().filter
    samples = np.concatenate([stationary(name, seed, step=step) for seed in range(6)])
    lags = np.arange(1, round(20.0 / step))
    correlation = np.array([made.correlation(step * lag) for lag in lags[:: max(1, len(lags) // 400)]])
    spacing = max(1, len(lags) // 400)
    freedom = len(samples) / (1 + 2 * spacing * np.sum(correlation**2))
    low, high = chi2.ppf([0.0005, 0.9995], freedom) / freedom
    assert low < np.mean(samples**2) / (0.01 * made.variance()) < high
    assert high - low < 0.3, "bounds that hold anything"


@FILTERED
def test_noise_is_stationary_from_its_first_sample(name):
    """The first sample of 500 seeds has the variance of the process; and the tenth."""
    made = recipe(name, psd=1.0, duration=20.0).form().filter
    samples = np.array(
        [made.sampled(0.005, normal_numbers(seed, (10, len(made.drive))))[[0, 9]] for seed in range(500)]
    )
    low, high = chi2.ppf([0.0005, 0.9995], 500) / 500
    assert np.all(low < np.mean(samples**2, axis=0) / made.variance())
    assert np.all(np.mean(samples**2, axis=0) / made.variance() < high)


@FILTERED
@pytest.mark.complete
def test_the_spectrum_of_samples_is_within_its_sampling_bounds(name):
    """Periodograms of 30 seeds, averaged over bands: each ratio to the spectrum is chi-square, 99.99 % of cases.

    Aliases, of the spectrum about the sampling rate and the next, are added to it.
    """
    step, count = 0.005, 8192
    lines, periodograms = None, []
    for seed in range(30):
        frequency, power = signal.periodogram(stationary(name, seed, 41.0)[:count], 1 / step, "hann", detrend=False)
        periodograms.append(power / (4 * pi))  # one-sided per Hz to two-sided per rad/s
        lines = 2 * pi * frequency
    mean = np.mean(periodograms, axis=0)
    rate = 2 * pi / step
    wanted = 0.01 * sum(SPECTRA[name](np.abs(lines + k * rate)) for k in range(-40, 41))
    edges = np.searchsorted(lines / (2 * pi), np.geomspace(0.15, 80.0, 13))
    for start, end in pairwise(edges):
        bins = end - start
        freedom = 2 * 30 * bins / (1.0 if bins == 1 else 1.9)  # lines of a Hann window share half of their power
        low, high = chi2.ppf([5e-5, 1 - 5e-5], freedom) / freedom
        assert low < np.mean(mean[start:end] / wanted[start:end]) < high
    assert high - low < 0.1


def test_white_noise_is_white_up_to_its_step():
    """Independent samples of the variance 2π S₀/h: a chi-square of N; their periodogram is S₀ at all frequencies."""
    step = 0.005
    samples = np.concatenate([stationary("white_noise", seed, step=step) for seed in range(5)])
    low, high = chi2.ppf([0.0005, 0.9995], len(samples)) / len(samples)
    assert low < np.mean(samples**2) / (2 * pi * 0.01 / step) < high
    for lag in (1, 2, 3, 10):
        assert abs(np.mean(samples[lag:] * samples[:-lag])) < 4 * np.mean(samples**2) / sqrt(len(samples))
    motion = pr.generate_motion("white_noise", rms=1.0, duration=20.0, step=step)
    assert any("keep 66.7 % of the variance" in sentence for sentence in motion.processing)
    fine = np.interp(np.linspace(0, len(samples) - 1, 20 * len(samples)), np.arange(len(samples)), samples)
    assert np.mean(fine**2) / np.mean(samples**2) == pytest.approx(2 / 3, rel=0.02)


@pytest.mark.parametrize("name", ["white_noise", "clough_penzien"])
def test_noise_may_end_at_rest(name):
    """To rounding, by a line that is below 3 % of the rms; as drawn it ends elsewhere, which is told."""
    keys = {"rms": 1.0, "duration": 20.0, "seed": 3}
    drawn, rest = (pr.generate_motion(name, **keys, ends=ends) for ends in ("as drawn", "at rest"))
    for numbers, others in zip(rest.velocity_displacement(), drawn.velocity_displacement(), strict=True):
        assert abs(numbers[-1]) < 1e-10 * np.abs(numbers).max() and abs(others[-1]) > 0.02 * np.abs(others).max()
    taken = drawn.acceleration - rest.acceleration
    assert 0.0 < np.abs(taken).max() < 0.03 and taken[0] == taken[-1] == 0.0
    assert "the ground ends with the velocity 0 m/s at the displacement 0 m" in rest.processing
    assert any(sentence.startswith("ends at rest: less a straight line") for sentence in rest.processing)


def test_an_oscillator_under_white_noise_has_the_variance_of_the_books():
    """σ² = π S₀ / (2ζω³) of the stationary displacement; chi-square with 2ζω of a second, over 6 seeds of 200 s."""
    ratio, w, step = 0.1, 2 * pi / 0.5, 0.005
    building = Building("one", 1e4, 0.5, ratio)
    squares = []
    for seed in range(6):
        free = free_response(oscillators(building, building), stationary("white_noise", seed, step=step), step)
        squares.append(np.mean(free.states[round(10.0 / step) :, 0] ** 2))  # ten seconds from rest, exp(−2ζω t) = 1e-11
    freedom = 2 * ratio * w * 190.0 * 6
    low, high = chi2.ppf([0.0005, 0.9995], freedom) / freedom
    assert low < np.mean(squares) / (pi * 0.01 / (2 * ratio * w**3)) < high
    assert high - low < 0.3


@pytest.mark.complete
def test_a_seed_gives_its_motion_and_another_seed_another_one():
    one, again, other = (stationary("clough_penzien", seed) for seed in (3, 3, 4))
    assert np.array_equal(one, again)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.1
    # Of this generator, so that results can be made again with another version of NumPy.
    assert_allclose(normal_numbers(1, (3,)), FIRST_NORMALS, rtol=1e-13)


FIRST_NORMALS = (0.029636756665895332, 1.64936633448324, -1.0618159984556077)


@pytest.mark.parametrize("name", ["trapezoid", "exponential", "gamma"])
def test_envelopes_reach_one_at_their_rise_and_end_as_asked(name):
    times = np.linspace(0.0, 20.0, 20001)
    values = read_envelope(name, 20.0, 3.0, None, 0.05).at(times)
    assert values[0] == 0.0 and values.max() == pytest.approx(1.0, abs=1e-9)
    assert values[3000] == pytest.approx(1.0, abs=1e-12) and values[-1] == pytest.approx(0.05, rel=1e-9)
    ratio = {"trapezoid": 0.25, "gamma": None, "exponential": None}[name]
    if ratio:
        assert values[1500] == pytest.approx(ratio) and np.all(values[3000:11000] == 1.0)
    assert np.all(np.diff(values[11000:]) < 0.0)


# ---------------------------------------------------------------- as records

PULSE = {"kind": "ricker", "pga": "0.4 g", "period": "0.8 s"}
NOISE = {"kind": "clough_penzien", "rms": "0.1 g", "duration": "4 s", "count": 3}


def scene_of(*motions, **records):
    """A scene under generated motions."""
    return pr.read_scene(scene_text(records={**records, "generated": list(motions)}))


def faults_of(*motions, **records):
    with pytest.raises(SceneError) as refused:
        scene_of(*motions, **records)
    return sorted(fault.partition(", ")[2] for fault in refused.value.faults)


def test_a_scene_names_them_and_is_written_back():
    scene = scene_of(PULSE, NOISE)
    again = pr.read_scene(scene.to_toml())
    assert again == scene and again.records.generated == scene.records.generated
    below = '[[records.generated]]\nkind = "ricker"\npga = "0.4 g"\nperiod = "0.8 s"\n'
    apart = pr.read_scene(scene_text().replace('names = ["RSN6-180"]\n', below))
    assert apart.records.generated == scene_of(PULSE).records.generated
    python = pr.Records(generated=[recipe("ricker", pga="0.4 g", period=0.8), {**NOISE, "duration": 4.0}])
    assert python.generated == scene.records.generated
    assert scene.replace('records.generated.1.pga="0.2 g"').records.generated[0] == recipe(
        "ricker", pga="0.2 g", period=0.8
    )


def test_their_motions_are_named_and_told_where_they_are_from(says):
    motions = read_ensemble(
        scene_of(PULSE, NOISE, {**PULSE, "name": "first"}).records, Path()
    ).motions  # one stands twice
    says([f"{motion.name}: {motion.record['origin']}" for motion in motions])
    assert len({motion.record["sha256"] for motion in motions}) == 4
    stiffer = {**NOISE, "frequency": "5 Hz", "name": "stiff"}
    shared = read_ensemble(scene_of(NOISE, stiffer).records, Path()).motions
    assert [motion.name for motion in shared[3:]] == [f"stiff-seed{seed}" for seed in (1, 2, 3)]
    numbers = recording_numbers([motion.record for motion in shared], [motion.name for motion in shared])
    assert list(numbers) == [0, 1, 2, 0, 1, 2], "the same random numbers through another filter are no other recording"
    assert motions[2].digest == pr.read_motion(motions[2].record["source"]).digest
    both = read_ensemble(scene_of(PULSE, {**PULSE, "pga": "0.2 g"}).records, Path()).motions
    assert [motion.name for motion in both] == [motion.record["source"] for motion in both], "told apart by their keys"


FAULTS = {
    "several": [{**PULSE, "period": "-1 s", "with": 2}, {"kind": "riker"}, {"pga": "1 g"}, NOISE | {"tail": "1 s"}],
    "values": [{"kind": "ricker", "pga": 3.0}, {**NOISE, "psd": "1 m^2/s^3"}, {**NOISE, "seed": 1.5}],
}


def test_every_fault_is_told_at_once_with_its_key(says):
    says(faults_of(*FAULTS["several"]), faults_of(*FAULTS["values"]))
    says(faults_of(PULSE, names=["RSN6-180"], direction="30 deg"))


def test_keys_without_effect_are_told(says):
    told = unused_keys(scene_of(PULSE, NOISE, pga="0.3 g", unit="g", dt="0.01 s"))
    says([sentence for sentence in told if sentence.startswith("records.")])
    assert not any(sentence.startswith("records.") for sentence in unused_keys(scene_of(PULSE, NOISE, scale=2.0)))


def test_a_manifest_and_a_file_hold_them(tmp_path):
    motions = read_ensemble(scene_of(PULSE, NOISE).records, tmp_path).motions
    write_manifest(motions, tmp_path / "chosen.csv")
    again = read_ensemble(pr.Records(manifest="chosen.csv").request(), tmp_path).motions
    assert [motion.digest for motion in again] == [motion.digest for motion in motions]
    path = pr.motions.write_motion(motions[1], tmp_path / "noise.csv")
    assert_allclose(pr.read_motion(path).acceleration, motions[1].acceleration, rtol=1e-12)


def test_words_of_the_command_line_name_them(says):
    motion = pr.read_motion("ricker: pga=0.4 g, period=0.8 s", polarity="reversed", tail="1 s")
    assert motion.name == "ricker-0.8s" and motion.acceleration[-1] == 0.0 and motion.pga == pytest.approx(3.92266)
    noise = "white_noise: rms=1 m/s^2, duration=2 s, count=2"
    says(
        [refusal(pr.read_motion, words) for words in ("riker: pga=0.4 g", "ricker: pga=0.4 g", "ricker: 0.4 g", noise)]
    )


def test_a_stiff_building_is_not_in_doubt_under_a_pulse_whose_error_is_known():
    """The check of the time step is of records, which are not known between samples; of noise neither."""
    stiff = scene_text(
        {"name": "a", "mass": "10 t", "period": "0.02 s"},
        {"name": "b", "mass": "10 t", "period": "0.5 s"},
        records={"generated": [PULSE, NOISE]},
    )
    flags = [" ".join(motion.flags) for motion in motions_of(pr.read_scene(stiff))]
    assert "stiffest" not in flags[0] and "stiffest" in flags[1]


# ---------------------------------------------------------------- a kind is one file

DOUBLE = '''"""Two steps."""

import jsonschema
import numpy as np

from pounding_risk.motions.generated import Option, Wave, motion_kind
from pounding_risk.units import PGA


@motion_kind("triangle", amplitude=("pga",), pga=Option("Its height.", PGA))
def triangle(*, pga):
    """A triangle of 1 s."""
    return Wave(lambda times: pga * np.clip(np.minimum(times, 1.0 - times) * 2.0, 0.0, 1.0), 1.0, 1.0, (0.5,))
'''


@pytest.fixture
def one_more_kind(tmp_path, monkeypatch):
    """The folder of the kinds with one file more, forgotten afterwards."""
    (tmp_path / "triangle.py").write_text(DOUBLE, encoding="utf-8")
    monkeypatch.setattr(generated, "__path__", [*generated.__path__, str(tmp_path)])
    monkeypatch.setattr(motion_kinds(), "members", dict(motion_kinds()))
    monkeypatch.setattr(motion_kinds(), "folder", generated.__name__)
    yield
    sys.modules.pop("pounding_risk.motions.generated.triangle", None)


def test_adding_a_kind_is_adding_a_file(one_more_kind):
    motion = scene_of({"kind": "triangle", "pga": "0.3 g"}).records.generated[0]
    made = pr.read_motion(motion)
    assert made.pga == pytest.approx(0.3 * 9.80665) and made.record["interpolation_error"] < 1e-12
    assert "triangle" in motion_kinds()


def test_every_kind_says_what_it_is_and_its_example_is_a_motion():
    for name, kind in motion_kinds().items():
        assert kind.words.endswith(".") and len(kind.words) > 30, name
        assert all(option.words for option in kind.options.values())
        example = pr.read_scene(scene_text().replace('names = ["RSN6-180"]', f"generated = [{kind.example()}]"))
        assert read_ensemble(example.records, Path()).motions[0].record["event"].startswith(f"generated: {name}")


# ---------------------------------------------------------------- a scan


@pytest.mark.complete
def test_a_scan_runs_them_and_they_are_made_again_from_its_results(tmp_path):
    """Names and keys stand in the dataset; from its file alone every number comes again to the last bit."""
    scene = scene_of(PULSE, NOISE, window=["0 s", "3 s"], polarity=["as recorded", "reversed"])
    dataset = scene.scan(tmp_path / "results.nc", check_fraction=0.0)
    names = ["ricker-0.8s", *(f"clough_penzien-seed{seed}" for seed in (1, 2, 3))]
    assert list(dataset["record"].values) == names and int(dataset["impact_count"].sum()) > 0
    kept = {record["name"]: record for record in json.loads(dataset.attrs["records"])}
    assert kept[names[0]]["origin"] == "generated ricker: pga=3.92266 m/s^2, period=0.8 s, shape=symmetric"
    assert len(set(dataset["record_recording"].values)) == 4
    again = pr.rerun(tmp_path / "results.nc")
    assert not again.differences and not again.notes
    assert pr.assess(dataset).unused_keys == ()
    single = pr.simulate(scene, record=names[2])
    assert single.attrs["record"] == names[2]


def test_editors_know_the_keys_of_every_kind():
    scene = tomllib.loads(scene_text().replace('names = ["RSN6-180"]', ""))
    schema = pr.schema()
    fits = jsonschema.validators.validator_for(schema)(schema).is_valid
    for kind in motion_kinds().values():
        motion = tomllib.loads(f"motion = {kind.example()}")["motion"]
        assert fits(scene | {"records": {"generated": [motion]}})
        for change in ({"wrong": 1}, {"step": 1}, {"kind": "other"}):
            assert not fits(scene | {"records": {"generated": [motion | change]}})
