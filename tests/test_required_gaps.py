"""Required gaps against order statistics and a known distribution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import lognorm

from pounding_risk.required_gaps import lognormal_percentiles, lognormal_share, required_gaps


def test_percentiles_are_those_between_order_statistics():
    """Eleven closings of 0 to 100 mm: the p-th percentile is p mm by the definition that is stated."""
    closing = np.linspace(0.0, 0.1, 11)
    found = required_gaps(closing, np.arange(11), (95.0, 50.0, 84.0, 84.0), 0.95)
    assert [each.percentile for each in found] == [50.0, 84.0, 95.0]
    assert [each.gap for each in found] == pytest.approx([0.05, 0.084, 0.095])
    assert np.isnan([each.fitted for each in found]).all()  # one motion closes nothing: no logarithm


def test_the_lognormal_fit_finds_the_truth():
    """20,000 motions: the standard error of the 84 % value is β √((1 + z²/2)/n), 0.4 % here; three of them."""
    closing = lognorm(0.5, scale=0.04).rvs(20_000, random_state=6)
    found = lognormal_percentiles(closing, np.array([50.0, 84.1344746]))
    assert found == pytest.approx([0.04, 0.04 * np.exp(0.5)], rel=0.013)
    # Two motions: mean and deviation, n - 1 below it, by hand.
    assert lognormal_percentiles(np.exp([1.0, 3.0]), np.array([84.1344746]))[0] == pytest.approx(np.exp(2.0 + 2.0**0.5))


def test_the_lognormal_share_undoes_the_percentile():
    closing = np.random.default_rng(16).lognormal(size=30)
    for percentile in (10.0, 84.0, 99.9):
        gap = float(lognormal_percentiles(closing, np.array([percentile]))[0])
        assert lognormal_share(closing, gap) == pytest.approx(1.0 - percentile / 100.0)
    assert np.isnan([lognormal_share(closing, 0.0), lognormal_share(np.zeros(3), 1.0)]).all()


def test_few_recordings_do_not_bound_a_high_percentile():
    """The largest of R lies above the p-th percentile with 1 − p^R, which must be 97.5 %: 22 recordings for 84 %."""
    rng = np.random.default_rng(7)
    for recordings, known in ((21, False), (22, True)):
        numbers = np.repeat(np.arange(recordings), 4)
        (found,) = required_gaps(rng.lognormal(size=numbers.size), numbers, (84.0,), 0.95)
        assert found.bounded is known
    (found,) = required_gaps(rng.lognormal(size=8), np.zeros(8, dtype=np.int64), (84.0,), 0.95)
    assert found.low == found.high == found.gap  # one recording, resampled, is itself


def test_recordings_of_unlike_sizes_are_resampled_whole():
    """Two recordings, one motion and three: the median of every resample is one of three values."""
    closing = np.array([0.01, 0.02, 0.03, 0.04])
    (found,) = required_gaps(closing, np.array([0, 1, 1, 1]), (50.0,), 0.95)
    assert found.gap == pytest.approx(0.025)
    assert (found.low, found.high) == pytest.approx((0.01, 0.03))  # the first twice, the second twice


def test_bounds_of_the_median_hold_where_motions_are_alike():
    """100 ensembles of 40 recordings with two motions that correlate by 0.8.

    The percentile bootstrap holds in some 95 %: 100 of them in 95 +- 7 (three standard deviations), a little fewer for
    the small ensemble. Resampling motions as if they were independent holds in some 84.
    """
    rng = np.random.default_rng(8)
    recordings, held = np.repeat(np.arange(40), 2), 0
    for _ in range(100):
        logs = np.sqrt(0.8) * rng.normal(size=40)[recordings] + np.sqrt(0.2) * rng.normal(size=80)
        (found,) = required_gaps(np.exp(logs), recordings, (50.0,), 0.95)
        held += found.low <= 1.0 <= found.high
    assert held >= 88


def test_the_same_motions_have_the_same_bounds():
    closing = np.random.default_rng(9).lognormal(size=30)
    one, other = (required_gaps(closing, np.arange(30), (84.0,), 0.95) for _ in range(2))
    assert one == other
