"""Fragilities against statsmodels, closed forms and a known truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from pounding_risk.assessment.fragility import out_of_scale, shown_as
from pounding_risk.statistics.fragility import fit, fit_capacities, stripes_of

IM = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
COUNTS = np.array([0, 3, 9, 18, 25, 33])
RUNS = 40


def stripes(counts: np.ndarray = COUNTS, im: np.ndarray = IM, runs: int = RUNS) -> tuple[np.ndarray, np.ndarray]:
    """(intensities, failed) by motion; the first motions of each stripe fail."""
    return np.repeat(im, runs), np.concatenate([np.arange(runs) < count for count in counts])


def test_the_fit_is_that_of_statsmodels():
    """statsmodels 0.15.0, Probit(...).fit(tol=1e-14), its covariance turned to (ln θ, β) by the delta method.

    Errors by recording: its cov_type "cluster" without correction, times √(40/39); motion i of each stripe is
    recording i. All digits that were printed agree.
    """
    found = fit(*stripes(), np.tile(np.arange(RUNS), IM.size))
    assert found.median == pytest.approx(0.41563376537, rel=1e-9)
    assert found.dispersion == pytest.approx(0.46122629358, rel=1e-9)
    assert (found.se_median, found.se_dispersion) == pytest.approx((0.04626722, 0.06177825), rel=1e-6)
    assert (found.se_median_recordings, found.se_dispersion_recordings) == pytest.approx(
        (0.0762847, 0.06506021), rel=1e-6
    )
    assert found.correlation == pytest.approx(0.00108212223, rel=1e-5)


def test_the_truth_lies_within_the_bounds():
    """400 ensembles of 40 motions at six intensities: 95 % bounds of ln θ and β hold in 95 %.

    That is 380 of 400; three standard deviations of the binomial are 13, and β's bounds, symmetric where its
    distribution is not, may lose 2 % more (Wald's bounds in samples of this size).
    """
    rng, held = np.random.default_rng(10), np.zeros(2)
    chance = norm.cdf(np.log(IM / 0.35) / 0.45)
    for _ in range(400):
        im, failed = stripes(np.zeros(IM.size))
        failed = rng.random(im.size) < np.repeat(chance, RUNS)
        found = fit(im, failed, np.arange(im.size))
        off = np.array([np.log(found.median / 0.35) / found.se_median, (found.dispersion - 0.45) / found.se_dispersion])
        held += np.abs(off) < 1.96
    assert held[0] >= 367
    assert held[1] >= 359
    assert (held < 396).all()  # bounds that always hold are no 95 % bounds


def test_bounds_hold_for_motions_each_at_its_own_intensity():
    rng, held = np.random.default_rng(11), 0
    for _ in range(400):
        im = 0.4 * np.exp(0.8 * rng.normal(size=120))
        found = fit(im, rng.random(120) < norm.cdf(np.log(im / 0.4) / 0.5), np.arange(120))
        held += abs(np.log(found.median / 0.4)) < 1.96 * found.se_median
    assert 367 <= held < 396  # as above


def test_errors_by_recording_see_that_motions_repeat_each_other():
    """Every motion twice: the errors by recording are those of one of each, those of all a factor √2 smaller."""
    im, failed = stripes()
    once = fit(im, failed, np.arange(im.size))
    twice = fit(np.tile(im, 2), np.tile(failed, 2), np.tile(np.arange(im.size), 2))
    assert (twice.median, twice.dispersion) == pytest.approx((once.median, once.dispersion), rel=1e-9)
    assert twice.se_median == pytest.approx(once.se_median / np.sqrt(2.0), rel=1e-8)
    assert twice.se_median_recordings == pytest.approx(once.se_median_recordings, rel=1e-8)


def test_capacities_have_their_closed_form():
    logs = np.random.default_rng(12).normal(np.log(2.0), 0.4, size=50)
    found = fit_capacities(np.exp(logs), np.arange(50))
    assert found.median == pytest.approx(np.exp(logs.mean()))
    assert found.dispersion == pytest.approx(logs.std())
    assert (found.se_median, found.se_dispersion) == pytest.approx((logs.std() / 50**0.5, logs.std() / 100**0.5))
    # Recordings of one motion: the mean's error from the scores is exact, with n − 1 in place of n.
    assert found.se_median_recordings == pytest.approx(logs.std(ddof=1) / 50**0.5)


def test_capacities_and_stripes_tell_the_same_fragility():
    """4000 motions with known capacities, looked at directly and at seven intensities: within three errors."""
    capacity = 0.4 * np.exp(0.5 * np.random.default_rng(13).normal(size=4000))
    im = np.linspace(0.1, 1.0, 7)
    seen = fit(np.repeat(im, 4000), (capacity < im[:, None]).ravel(), np.tile(np.arange(4000), 7))
    known = fit_capacities(capacity, np.arange(4000))
    assert abs(np.log(seen.median / known.median)) < 3.0 * seen.se_median_recordings
    assert abs(seen.dispersion - known.dispersion) < 3.0 * seen.se_dispersion_recordings


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ([0, 0, 0, 0, 0, 0], "none of the 240 runs reach it"),
        ([40] * 6, "all of the 240 runs reach it"),
        ([0, 0, 0, 40, 40, 40], "no run that does not reach it"),
        (
            [0, 0, 7, 40, 40, 40],
            "no run that does not reach it",
        ),  # one mixed stripe alone tells no dispersion
        ([33, 25, 18, 9, 3, 0], "become rarer as the intensity grows"),
        ([20, 19, 20, 20, 21, 20], "hardly become more frequent as the intensity grows"),
    ],
)
def test_what_cannot_be_fitted_is_told(counts, words):
    found = fit(*stripes(np.array(counts)), np.arange(240))
    assert words in found.fault
    assert np.isnan([found.median, found.dispersion, found.se_median]).all()


def test_two_mixed_stripes_are_enough():
    """The line through two shares is the likelihood's largest: nothing is left to misfit."""
    found = fit(*stripes(np.array([7, 31]), np.array([0.3, 0.4])), np.arange(80))
    line = norm.ppf([7 / 40, 31 / 40])
    slope = (line[1] - line[0]) / np.log(0.4 / 0.3)
    assert 1.0 / found.dispersion == pytest.approx(slope)
    assert np.log(found.median / 0.3) == pytest.approx(-line[0] / slope)


def test_one_intensity_and_one_motion_are_told():
    assert "one intensity" in fit(np.ones(10), np.arange(10) < 5, np.arange(10)).fault
    assert "one recording" in fit_capacities(np.array([0.3, 0.4]), np.zeros(2, dtype=np.int64)).fault
    assert "one recording" in fit(*stripes(), np.zeros(IM.size * RUNS, dtype=np.int64)).fault
    assert "no dispersion" in fit_capacities(np.array([0.3, 0.3]), np.arange(2)).fault
    assert "closed gap" in fit_capacities(np.array([0.0, 0.1]), np.arange(2)).fault
    assert "closes nothing" in fit_capacities(np.array([np.inf, 0.1]), np.arange(2)).fault


def at_sa(count: int, apart: float, seed: int = 21) -> np.ndarray:
    """Intensities of an ensemble that is scaled to 0.7 g: ``apart`` is the deviation of their logarithms."""
    return 0.7 * 9.80665 * np.exp(apart * np.random.default_rng(seed).normal(size=count))


@pytest.mark.parametrize("apart", [0.0, 1.5e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.99, 1.0])
def test_an_ensemble_scaled_to_one_intensity_has_no_curve(apart, share):
    """What scaling and the solver's tolerance leave between the motions is no shaking of another strength."""
    im = at_sa(44, apart)
    failed = np.random.default_rng(5).random(44) < share
    fault = fit(im, failed, np.arange(44) // 2, shown_as("pga")).fault
    assert fault.startswith("all motions have one intensity, 0.7 g: a curve needs several")
    assert "no dispersion" in fit_capacities(im, np.arange(44)).fault
    (stripe,) = stripes_of(im, failed)
    assert (stripe.count, stripe.runs) == (failed.sum(), 44)
    assert stripe.im == pytest.approx(0.7 * 9.80665, rel=1e-3)


def test_failures_that_intensity_does_not_explain_have_no_curve():
    """Coins tossed at intensities 5 % apart: the slope is told from 0 in 5 % of the ensembles, one-sided, by Wald.

    That is 20 of 400; three standard deviations of the binomial are 13, and errors by recording, the larger of both
    counting, take some away.
    """
    rng, fitted = np.random.default_rng(31), 0
    for seed in range(400):
        im, failed = at_sa(60, 0.05, seed), rng.random(60) < 0.5
        fitted += not fit(im, failed, np.arange(60)).fault
    assert fitted <= 33


def test_a_dispersion_that_its_error_does_not_tell_from_none_is_refused():
    """One weak failure among ten at 0.3 and one strong survivor at 0.31: parted but for two, at intensities 3 % apart.

    By hand: between them lies all that tells the dispersion. The same motions ten times over carry it.
    """
    im = np.concatenate([np.linspace(0.1, 0.30, 10), np.linspace(0.31, 0.6, 10)])
    failed = np.arange(20) >= 10
    failed[[9, 10]] = True, False
    once = fit(im, failed, np.arange(20))
    assert "carry no dispersion: it would be" in once.fault and "scan more records" in once.fault
    many = fit(np.tile(im, 10), np.tile(failed, 10), np.arange(200))
    assert not many.fault and many.dispersion > 0.0


def test_a_median_outside_the_tested_intensities_is_refused():
    """A quarter of the motions fail at the strongest of three stripes: the median lies beyond it."""
    im, failed = stripes(np.array([1, 4, 9]), np.array([0.3, 0.4, 0.5]))
    found = fit(im, failed, np.arange(im.size), shown_as("pga"))
    assert "lies above the intensities that were tested, between 0.0306 g and 0.051 g: scan stronger motions" in (
        found.fault
    )
    assert np.isnan(found.median)
    im, failed = stripes(np.array([31, 36, 39]), np.array([0.3, 0.4, 0.5]))
    assert "lies below the intensities that were tested" in fit(im, failed, np.arange(im.size)).fault


@pytest.mark.parametrize(
    ("factors", "nearest", "words"),
    [
        ([0.41], 0.41, ""),
        ([3.9], 3.9, ""),
        ([0.2], 0.2, "times 0.2, outside 0.25 to 4: scan weaker motions"),
        ([40.0, 5.0], 5.0, "times 5, outside 0.25 to 4: scan stronger motions"),
        ([20.0, 0.1], 0.1, ""),  # between two scanned amplitudes
    ],
)
def test_scaling_beyond_the_usual_factors_is_refused(factors, nearest, words):
    found = fit_capacities(np.array([2.0, 3.0, 4.0]), np.arange(3))
    factor, fault = out_of_scale(found, np.array(factors))
    assert factor == nearest
    assert fault.endswith(words) and bool(fault) == bool(words)


def test_stripes_are_counted():
    found = stripes_of(np.array([0.2, 0.1, 0.2]), np.array([True, False, False]))
    assert [(each.im, each.count, each.runs) for each in found] == [(0.1, 0, 1), (0.2, 1, 2)]
