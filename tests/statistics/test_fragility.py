"""Fragilities against statsmodels, SciPy, closed forms and a known truth; first crossings by hand."""

import numpy as np
import pytest
from likelihoods import Lost, best_of, curvature_errors
from scipy import stats
from scipy.stats import norm

from pounding_risk.assessment.fragility import out_of_scale, shown_as
from pounding_risk.statistics import damage_fits as fits
from pounding_risk.statistics.fragility import Fit, fit, fit_capacities, stripes_of

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


RECORDINGS, COMPONENTS = 30, 2
LEVELS = np.geomspace(1.5, 6.0, 9)


def motions(levels: np.ndarray = LEVELS, steep: float = 1.3, noise: float = 0.0) -> fits.Observed:
    """Motions whose capacities are lognormal about 4, two components of a recording alike; demand (im/capacity)^1.3."""
    random = np.random.default_rng(3)
    shared = np.repeat(random.standard_normal(RECORDINGS), COMPONENTS)
    capacity = 4.0 * np.exp(0.4 * shared + 0.2 * random.standard_normal(RECORDINGS * COMPONENTS))
    ims = np.tile(levels, (capacity.size, 1))
    ratios = (ims / capacity[:, None]) ** steep * np.exp(noise * random.standard_normal(ims.shape))
    return fits.Observed(ims, ratios, np.repeat(np.arange(RECORDINGS), COMPONENTS))


def agree_with_scipy(fitted: Fit, data: stats.CensoredData) -> None:
    dispersion, _, median = stats.lognorm.fit(data, floc=0.0)
    assert (fitted.median, fitted.dispersion) == pytest.approx((median, dispersion), rel=1e-4)  # as far as scipy goes


def is_largest(fitted: Fit, lost: Lost) -> None:
    found = np.array([np.log(fitted.median), fitted.dispersion])
    assert found == pytest.approx(best_of(lost, [1.0, 0.6]), abs=1e-6)
    assert (fitted.se_median, fitted.se_dispersion) == pytest.approx(curvature_errors(lost, found), rel=1e-4)


def test_first_crossings_by_hand():
    """Between levels by straight lines; a failed level is passed over; what lies beyond the levels is told as such."""
    ims = np.tile([1.0, 2.0, 3.0, 4.0], (6, 1))
    ratios = np.array(
        [
            [0.2, 0.6, 1.4, 2.0],  # between 2 and 3, half way
            [0.5, np.nan, 1.5, 2.0],  # between 1 and 3, half way
            [0.2, 1.0, 0.4, 1.2],  # at 2, and not at 3
            [1.1, 1.2, 1.3, 1.4],
            [0.1, 0.2, 0.3, np.nan],
            [np.nan] * 4,
        ]
    )
    found = fits.capacities(ims, ratios)
    np.testing.assert_allclose(found.reached_at, [2.5, 2.0, 2.0, 1.0, 3.0, np.nan], rtol=1e-15)
    assert found.status.tolist() == [fits.KNOWN, fits.KNOWN, fits.KNOWN, fits.BELOW, fits.ABOVE, fits.NONE]
    assert found.falls_back.tolist() == [False, False, True, False, False, False]
    turned = fits.capacities(ims[:, ::-1], ratios[:, ::-1])  # levels in any order
    np.testing.assert_array_equal(turned.reached_at, found.reached_at)


def test_capacities_beyond_the_levels_are_fitted_as_scipy_does():
    seen = motions()
    found, fitted = fits.capacities(seen.ims, seen.ratios), fits.fit_ida(seen)
    known, below, above = (found.reached_at[found.status == status] for status in (fits.KNOWN, fits.BELOW, fits.ABOVE))
    assert min(below.size, above.size) > 0 and known.size > 40
    agree_with_scipy(fitted, stats.CensoredData(uncensored=known, left=below, right=above))

    def lost(point: np.ndarray) -> float:
        curve = stats.norm(*point)
        parts = curve.logpdf(np.log(known)), curve.logcdf(np.log(below)), curve.logsf(np.log(above))
        return -float(sum(part.sum() for part in parts))

    is_largest(fitted, lost)


def test_capacities_between_two_levels_are_fitted_as_scipy_does():
    """Of a demand that jumps: each capacity is known as an interval, below the lowest level or above the highest."""
    seen = motions()._replace(jumps=True)
    found, fitted = fits.capacities(seen.ims, seen.ratios, jumps=True), fits.fit_ida(seen)
    assert set(found.status.tolist()) == {fits.BELOW, fits.ABOVE, fits.BETWEEN}
    low = np.where(found.status == fits.BELOW, 0.0, found.below)
    high = np.where(found.status == fits.ABOVE, np.inf, found.reached_at)
    inside = found.status == fits.BETWEEN
    lines = fits.capacities(seen.ims, seen.ratios)  # of the same motions, whose demands are lines in the logarithms
    assert ((found.below < lines.reached_at) & (lines.reached_at < found.reached_at))[inside].all()
    intervals = np.stack([low[inside], high[inside]], axis=1)
    ends = {"left": high[found.status == fits.BELOW], "right": low[found.status == fits.ABOVE]}
    agree_with_scipy(fitted, stats.CensoredData(**ends, interval=intervals))

    def lost(point: np.ndarray) -> float:
        curve = stats.norm(*point)
        with np.errstate(divide="ignore"):
            return -float(np.log(curve.cdf(np.log(high)) - curve.cdf(np.log(low))).sum())

    is_largest(fitted, lost)


def test_a_cap_at_the_threshold_does_not_move_the_median():
    """A force of 0 until the touch and of the cap from yielding on, as of a column whose strength is the threshold.

    Lines between the levels end at the upper one, half a level (10 %) too high; the truth is that of the motions.
    """
    levels = np.geomspace(1.0, 12.0, 13)  # steps of 23 %
    smooth = motions(levels)
    capped = np.where(smooth.ratios < 0.7, 0.0, np.minimum(smooth.ratios, 1.0))
    truth = fits.fit_ida(motions(np.geomspace(0.5, 40.0, 400)))  # so many levels that a line is exact
    of_lines = fits.fit_ida(smooth._replace(ratios=capped))
    fitted = fits.fit_ida(smooth._replace(ratios=capped, jumps=True))
    assert of_lines.median / truth.median > 1.06
    error = truth.se_median  # an interval of half a dispersion costs little of it
    assert fitted.median == pytest.approx(truth.median, rel=0.25 * error)
    assert fitted.dispersion == pytest.approx(truth.dispersion, abs=0.25 * truth.se_dispersion)
    counted = fits.fit_stripes(smooth._replace(ratios=capped))
    assert fitted.median == pytest.approx(counted.median, rel=0.25 * error)


@pytest.mark.parametrize("method", ["stripes", "ida"])
def test_a_collapse_exceeds_every_threshold(method):
    """What is infinite counts as any demand above the threshold, in an interval between two levels."""
    seen, kind = motions(noise=0.1)._replace(jumps=True), fits.METHODS[method]
    fallen = seen._replace(ratios=np.where(seen.ratios > 1.5, np.inf, seen.ratios))
    assert kind.fit(fallen) == kind.fit(seen)
    weights = fits.bootstrap_weights(seen.recordings, 5, 5)
    np.testing.assert_array_equal(kind.drawn(fallen, weights), kind.drawn(seen, weights))
    first = fits.capacities(np.array([[1.0, 2.0]]), np.array([[0.5, np.inf]]))  # no line leads to a collapse
    assert (first.status[0], first.below[0], first.reached_at[0]) == (fits.BETWEEN, 1.0, 2.0)


def test_intervals_that_share_an_intensity_have_no_dispersion():
    ims = np.tile([1.0, 2.0, 3.0], (4, 1))
    alike = fits.Observed(ims, np.tile([0.5, 0.5, 2.0], (4, 1)), np.arange(4), jumps=True)
    beside = alike._replace(ratios=np.array([[0.5, 0.5, 2.0], [0.5, 2.0, 2.0]] * 2))  # all at 2, as far as is known
    for seen in (alike, beside):
        assert "one intensity may be the capacity of every motion" in fits.fit_ida(seen).fault
        assert np.isnan(fits.METHODS["ida"].drawn(seen, np.ones((3, 4)))).all()


def test_known_capacities_are_fitted_as_such():
    """All between the levels: the mean and the deviation of their logarithms, with the errors of `fit_capacities`."""
    seen = motions(np.geomspace(0.5, 40.0, 25))
    found = fits.capacities(seen.ims, seen.ratios)
    assert (found.status == fits.KNOWN).all()
    other, fitted = fit_capacities(found.reached_at, seen.recordings), fits.fit_ida(seen)
    for name in ("median", "dispersion", "se_median", "se_dispersion", "se_median_recordings", "correlation"):
        assert getattr(fitted, name) == pytest.approx(getattr(other, name), rel=1e-9), name


def test_the_cloud_is_scipys_regression():
    seen = motions(noise=0.3)
    fitted = fits.fit_cloud(seen)
    x, y = np.log(seen.ims).ravel(), np.log(seen.ratios).ravel()
    line = stats.linregress(x, y)
    deviation = np.sqrt(((y - line.intercept - line.slope * x) ** 2).sum() / (x.size - 2))
    assert fitted.median == pytest.approx(np.exp(-line.intercept / line.slope), rel=1e-12)
    assert fitted.dispersion == pytest.approx(deviation / line.slope, rel=1e-12)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("method", fits.METHODS)
def test_errors_by_recording_are_those_of_a_bootstrap(method, jumps):
    """Two ways to one number: the sandwich of one fit, and the spread of fits to samples of recordings."""
    seen = motions(noise=0.1)._replace(jumps=jumps)
    drawn = fits.METHODS[method].drawn(seen, fits.bootstrap_weights(seen.recordings, 1000, 1))
    fitted = fits.METHODS[method].fit(seen)
    assert np.isfinite(drawn).all()
    assert drawn.std(axis=0) == pytest.approx([fitted.se_median_recordings, fitted.se_dispersion_recordings], rel=0.12)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("method", fits.METHODS)
def test_a_weight_is_a_motion_that_stands_there_so_often(method, jumps):
    seen, kind = motions(noise=0.1)._replace(jumps=jumps), fits.METHODS[method]
    weights = fits.bootstrap_weights(seen.recordings, 3, 5)
    drawn = kind.drawn(seen, np.concatenate([np.ones((1, len(seen.ims))), weights]))
    for row, weight in zip(drawn, [np.ones(len(seen.ims)), *weights], strict=True):
        index = np.repeat(np.arange(len(seen.ims)), weight.astype(int))
        fitted = kind.fit(fits.Observed(seen.ims[index], seen.ratios[index], np.arange(index.size), jumps=jumps))
        assert [np.exp(row[0]), row[1]] == pytest.approx([fitted.median, fitted.dispersion], rel=1e-6)


def test_samples_are_of_whole_recordings():
    weights = fits.bootstrap_weights(np.array([0, 0, 1, 2, 2, 2]), 200, 7)
    assert (weights[:, 0] == weights[:, 1]).all() and (weights[:, 3] == weights[:, 5]).all()
    assert (weights[:, [0, 2, 3]].sum(axis=1) == 3.0).all()  # as many recordings as there are
    np.testing.assert_array_equal(weights, fits.bootstrap_weights(np.array([0, 0, 1, 2, 2, 2]), 200, 7))


@pytest.mark.parametrize("groups", [7, 22])
@pytest.mark.complete
def test_bounds_of_a_ratio_hold_it_as_often_as_they_say(groups):
    """150 made ensembles of recordings with two components each, whose true ratio of medians is 0.8."""
    random, levels, truth = np.random.default_rng(0), np.geomspace(1.0, 12.0, 12), np.log(0.8)
    recordings, tail = np.repeat(np.arange(groups), 2), 100.0 * fits.expanded_tail(0.95, groups)
    inside = []
    for sample in range(150):
        shared, changed = (np.repeat(random.standard_normal(groups), 2) for _ in range(2))
        single, other = random.standard_normal((2, recordings.size))
        without = np.log(4.0) + 0.35 * shared + 0.2 * single
        both = (without + truth + 0.15 * changed + 0.1 * other, without)
        ims = np.tile(levels, (recordings.size, 1))
        weights = fits.bootstrap_weights(recordings, 400, sample)
        seen = (fits.Observed(ims, ims / np.exp(one)[:, None], recordings) for one in both)
        drawn = [fits.METHODS["ida"].drawn(one, weights) for one in seen]
        low, high = np.nanpercentile(drawn[0][:, 0] - drawn[1][:, 0], (tail, 100.0 - tail))
        inside.append(low <= truth <= high)
    assert 0.89 < np.mean(inside) < 0.99  # three standard errors about 94 %


def test_few_recordings_have_wider_tails():
    """Of very many the share is the plain one; of three, Student's with two degrees by SciPy's own distribution."""
    assert fits.expanded_tail(0.95, 10**7) == pytest.approx(0.025, rel=1e-5)
    student = np.sqrt(3.0 / 2.0) * stats.t.ppf(0.95, 2)
    assert fits.expanded_tail(0.9, 3) == pytest.approx(stats.norm.cdf(-student), rel=1e-12)
    assert fits.expanded_tail(0.9, 1) == pytest.approx(0.05)


def test_samples_without_a_curve_are_told_from_others():
    """All reach the state, none does, and those who do part from the others at one intensity."""
    ims = np.tile([1.0, 2.0], (4, 1))
    ratios = np.array([[2.0, 2.0], [0.1, 0.1], [0.5, 2.0], [2.0, 0.5]])
    seen = fits.Observed(ims, ratios, np.arange(4))
    weights = np.array([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [2, 2, 3, 1]], dtype=float)
    known = np.isfinite(fits.METHODS["stripes"].drawn(seen, weights)).all(axis=1)
    assert known.tolist() == [False, False, False, True]


def test_why_there_is_no_curve():
    seen = motions(noise=0.1)
    alone = np.zeros(len(seen.ims), dtype=np.int64)
    strong = fits.Observed(seen.ims, np.full_like(seen.ims, 2.0), seen.recordings)
    weak = fits.Observed(seen.ims, np.full_like(seen.ims, 0.1), seen.recordings)
    one_level = fits.Observed(seen.ims[:, :1], seen.ratios[:, :1], seen.recordings)
    nothing = fits.Observed(seen.ims, np.full_like(seen.ims, np.nan), seen.recordings)
    still = fits.Observed(seen.ims, np.where(seen.ims < 2.0, 0.0, seen.ratios), seen.recordings)
    falling = fits.Observed(seen.ims, 1.0 / seen.ratios, seen.recordings)
    cases = [
        (fits.fit_ida(strong), "every motion reaches the state at its lowest level"),
        (fits.fit_ida(weak), "no motion reaches the state at the levels"),
        (fits.fit_ida(one_level), "each motion has one level"),
        (fits.fit_ida(nothing), "no run is known"),
        (fits.fit_ida(seen._replace(recordings=alone)), "one recording has no dispersion"),
        (
            fits.fit_ida(fits.Observed(seen.ims, seen.ratios * 0.35, seen.recordings)),
            "lies above the intensities that were tested",
        ),
        (fits.fit_stripes(nothing), "no run is known"),
        (fits.fit_stripes(weak), "none of the"),
        (fits.fit_cloud(still), "the demand is 0 in"),
        (fits.fit_cloud(seen._replace(ratios=np.where(seen.ratios > 1.0, np.inf, seen.ratios))), "take stripes"),
        (fits.fit_cloud(falling), "the demands fall with the intensity"),
        (fits.fit_cloud(one_level), "all motions have one intensity"),
        (fits.fit_cloud(fits.Observed(seen.ims[:1, :2], seen.ratios[:1, :2], alone[:1])), "2 runs are known"),
    ]
    for fitted, words in cases:
        assert words in fitted.fault and np.isnan(fitted.median), words
