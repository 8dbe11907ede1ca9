"""Fits of damage states against SciPy's own, first crossings by hand, and samples of recordings against fits."""

from __future__ import annotations

import numpy as np
import pytest
from likelihoods import Lost, best_of, curvature_errors
from scipy import stats

from pounding_risk.statistics import damage_fits as fits
from pounding_risk.statistics.fragility import Fit, fit_capacities

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
        (fits.fit_cloud(falling), "the demands fall with the intensity"),
        (fits.fit_cloud(one_level), "all motions have one intensity"),
        (fits.fit_cloud(fits.Observed(seen.ims[:1, :2], seen.ratios[:1, :2], alone[:1])), "2 runs are known"),
    ]
    for fitted, words in cases:
        assert words in fitted.fault and np.isnan(fitted.median), words
