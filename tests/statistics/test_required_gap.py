"""Required gaps against order statistics and a known distribution."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import beta, binom, lognorm

from pounding_risk._common.order import enough_for
from pounding_risk.assessment.options import percentile_for
from pounding_risk.statistics.proportions import independent_motions
from pounding_risk.statistics.required_gap import (
    contact_steps,
    lognormal_percentiles,
    lognormal_share,
    required_gaps,
    rounded_up,
)


@example(closing=[5e-324], percentile=50.0)  # below any unit of three digits
@given(
    closing=st.lists(st.floats(0.0, 0.5), min_size=1, max_size=40),
    percentile=st.sampled_from([50.0, 75.0, 84.0, 90.0, 95.0]),
)
def test_so_many_of_the_motions_need_no_more_and_no_smaller_gap_suffices(closing, percentile):
    """Counted in whole numbers, with contact where the closing is larger than the gap."""
    (found,) = required_gaps(np.array(closing), 1.0, (percentile,), 0.95)
    for gap in (found.gap, found.provided):
        # 1e-9 relative: three digits of a closing that they hold exactly.
        assert 100 * sum(value <= gap * (1.0 + 1e-9) for value in closing) >= percentile * len(closing)
    assert 100 * sum(value < found.gap for value in closing) < percentile * len(closing)
    assert found.low <= found.gap <= found.high


def test_20_of_24_motions_are_no_84_percent():
    """20 of 24 are 83.3 %: the gap is that of the 21st, which an interpolated percentile stays below."""
    closing = np.arange(1.0, 25.0) / 1e3
    (found,) = required_gaps(closing, 1.0, (84.0,), 0.95)
    assert found.gap == 0.021 > np.percentile(closing, 84.0)
    # 19 of 20 are 95 %, though 0.95 × 20 is a little more than 19 in binary.
    assert enough_for(closing[:20], 95.0) == 0.019
    # A motion without a finite response needs more than any gap, and takes no part below.
    assert enough_for([1.0, 2.0, np.inf], [66.0, 67.0]).tolist() == [2.0, np.inf]


def test_counted_gaps_along_an_axis_are_those_of_each_row():
    values = np.random.default_rng(31).lognormal(size=(3, 13, 2))
    found = enough_for(values, [50.0, 84.0], axis=1)
    assert np.array_equal(found, np.percentile(values, [50.0, 84.0], axis=1, method="inverted_cdf"))


def test_gaps_are_order_statistics():
    """Eleven closings of 0 to 100 mm: 50 % need what the sixth does, 84 % and 95 % what the tenth and the last do."""
    closing = np.linspace(0.0, 0.1, 11)
    found = required_gaps(closing, 1.0, (95.0, 50.0, 84.0, 84.0), 0.95)
    assert [each.percentile for each in found] == [50.0, 84.0, 95.0]
    assert [each.gap for each in found] == pytest.approx([0.05, 0.09, 0.1])
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
        closing = np.repeat(rng.lognormal(size=recordings), 4)  # four motions of a recording that say the same
        (found,) = required_gaps(closing, 0.25, (84.0,), 0.95)
        assert found.bounded is known
        assert found.high == closing.max()
    (found,) = required_gaps(np.array([0.02, 0.03]), 0.5, (84.0,), 0.95)
    assert (found.low, found.high, found.bounded) == (0.0, 0.03, False)


@pytest.mark.parametrize("percentile", [50.0, 84.0, 95.0])
def test_bounds_of_independent_motions_are_order_statistics(percentile):
    """By the binomial distribution: j motions or fewer lie below the percentile with P(K <= j)."""
    closing = np.random.default_rng(9).lognormal(size=200)
    rising, below = np.sort(closing), binom(closing.size, percentile / 100.0)
    (found,) = required_gaps(closing, 1.0, (percentile,), 0.95)
    upper = next(place for place in range(1, 201) if below.sf(place - 1) <= 0.025)
    lower = next(place for place in range(200, 0, -1) if below.cdf(place - 1) < 0.025)
    assert (found.low, found.high) == (rising[lower - 1], rising[upper - 1])
    assert found.low < found.gap < found.high


def test_bounds_count_motions_that_close_the_same():
    """Nine of ten at one closing: a gap of that much is closed by one, a little less by all."""
    closing = np.array([0.02] * 90 + [0.04] * 10)
    (found,) = required_gaps(closing, 1.0, (50.0,), 0.95)
    assert (found.low, found.gap, found.high) == (0.02, 0.02, 0.02)


def test_upper_bounds_hold_where_motions_of_a_recording_are_alike():
    """200 ensembles of 22 recordings with four motions that correlate by 0.8: no more than 2.5 % miss from above.

    Of 200 that is 5, and 12 with three standard deviations more. Resampling recordings misses in some 11 %.
    """
    rng = np.random.default_rng(8)
    recordings, missed, truth = np.repeat(np.arange(22), 4), 0, lognorm(1.0).ppf(0.84)
    for _ in range(200):
        logs = np.sqrt(0.8) * rng.normal(size=22)[recordings] + np.sqrt(0.2) * rng.normal(size=88)
        weight = independent_motions(logs, recordings) / logs.size
        (found,) = required_gaps(np.exp(logs), weight, (84.0,), 0.95)
        missed += found.bounded and found.high < truth
    assert missed <= 12


def test_steps_of_contact_are_the_counted_shares_with_their_bounds():
    """At, between and beyond the closings; a motion that closes a gap just so does not touch."""
    closing = np.array([0.03, 0.01, 0.03, 0.0, 0.02])
    steps = contact_steps(closing, 0.5, 0.9)
    assert steps.gaps.tolist() == [0.0, 0.01, 0.02, 0.03]
    assert steps.probability.tolist() == [0.8, 0.6, 0.4, 0.0]
    for count, low, high in zip((4, 3, 2), steps.low, steps.high, strict=False):
        # Half a motion each: the quantiles of the beta distribution, as Korn and Graubard (1998) have them.
        assert low == pytest.approx(beta.ppf(0.05, 0.5 * count, 2.5 - 0.5 * count + 1.0))
        assert high == pytest.approx(beta.ppf(0.95, 0.5 * count + 1.0, 2.5 - 0.5 * count))
    assert (steps.low[-1], steps.high[-1]) == (0.0, pytest.approx(1.0 - 0.05 ** (1.0 / 2.5)))


@given(
    closing=st.lists(st.floats(0.0, 0.5), min_size=1, max_size=60), target=st.sampled_from([0.01, 0.05, 0.1, 0.16, 0.3])
)
def test_the_gap_to_provide_keeps_the_target_as_it_is_written(closing, target):
    """Counted on the gap as three digits say it; a gap of two units less would no longer keep it."""
    (found,) = required_gaps(np.array(closing), 1.0, (percentile_for(target),), 0.95)
    provided = found.provided
    assert provided == rounded_up(found.gap)
    written = float(f"{provided:.3g}")
    allowed = target * len(closing) + 1e-9  # 0.1 × 20 is two whole motions
    # A closing that three digits hold exactly may differ from the gap by rounding.
    assert sum(value > written * (1.0 + 1e-9) for value in closing) <= allowed
    unit = 10.0 ** (np.floor(np.log10(provided)) - 2.0) if provided > 0.0 else 0.0
    assert provided == 0.0 or sum(value > provided - 2.0 * unit for value in closing) > allowed
