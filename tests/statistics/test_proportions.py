"""Bounds of shares against their definition, and how they hold where motions of a recording are alike."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.stats import binomtest, norm

from pounding_risk.statistics.proportions import (
    exact_bounds,
    independent_motions,
    joined,
    labels,
    least_upper_bound,
    likeness,
    motions_to_show,
    shares,
)


@pytest.mark.parametrize("confidence", [0.68, 0.95, 0.99])
def test_bounds_are_clopper_and_pearsons(confidence):
    """SciPy finds the same bounds by root finding, to its own 1e-12 or so."""
    for runs in (1, 2, 7, 44):
        for count in range(0, runs + 1, max(runs // 7, 1)):
            known = binomtest(count, runs).proportion_ci(confidence, method="exact")
            found = exact_bounds(count, runs, confidence)
            assert found == pytest.approx((known.low, known.high), abs=1e-9)


def test_bounds_without_runs_are_not_there():
    low, high = exact_bounds([0, 3], [0, 3], 0.95)
    assert np.isnan([low[0], high[0]]).all()
    assert (low[1], high[1]) == (pytest.approx(0.025 ** (1.0 / 3.0)), 1.0)  # closed form where all fail


def test_few_motions_cannot_show_a_small_probability():
    assert least_upper_bound(4, 0.95) == pytest.approx(1.0 - 0.025**0.25)
    assert least_upper_bound(4, 0.95) > 0.6
    assert motions_to_show(0.1, 0.95) == 36
    assert least_upper_bound(36, 0.95) <= 0.1 < least_upper_bound(35, 0.95)
    assert least_upper_bound(0.0, 0.95) == 1.0


def test_motions_alone_in_their_recordings_are_independent():
    values = np.random.default_rng(1).normal(size=20)
    assert likeness(values, np.arange(20)) == 0.0
    assert independent_motions(values, np.arange(20)) == 20.0


def test_motions_that_repeat_their_recording_count_once():
    """Identical motions: as many independent ones as recordings, whatever the sizes, Kish's count of them."""
    values = np.random.default_rng(2).normal(size=6)
    recordings = np.repeat(np.arange(6), 4)
    assert likeness(values[recordings], recordings) == 1.0
    assert independent_motions(values[recordings], recordings) == pytest.approx(6.0)
    uneven = np.repeat(np.arange(3), [4, 2, 2])
    assert independent_motions(values[:3][uneven], uneven) == pytest.approx(64.0 / 24.0)  # (Σm)²/Σm²


def test_one_recording_is_one_witness():
    values = np.random.default_rng(3).normal(size=8)
    assert independent_motions(values, np.zeros(8, dtype=np.int64)) == 1.0
    assert independent_motions(np.ones(8), np.repeat(np.arange(4), 2)) == pytest.approx(4.0)  # nothing tells them apart


def test_likeness_bounds_the_truth_from_above():
    """400 ensembles of 22 recordings with four motions each and a correlation of 0.5.

    The bound is one of 95 %: 400 of them miss it in 20 +- 9 (two standard deviations of the binomial).
    """
    rng = np.random.default_rng(4)
    recordings = np.repeat(np.arange(22), 4)
    missed = 0
    for _ in range(400):
        values = np.sqrt(0.5) * rng.normal(size=22)[recordings] + np.sqrt(0.5) * rng.normal(size=88)
        missed += likeness(values, recordings) < 0.5
    assert 11 <= missed <= 29


@pytest.mark.parametrize("truth", [0.1, 0.5])
def test_bounds_by_recording_hold_where_motions_are_alike(truth):
    """22 recordings of four motions whose strengths correlate by 0.7: bounds for independent motions do not hold.

    Of 400 ensembles at least 95 % should hold the truth; two standard deviations below that is 371.
    """
    rng = np.random.default_rng(5)
    recordings = np.repeat(np.arange(22), 4)
    held = {"low": 0, "low_recordings": 0}
    for _ in range(400):
        strength = np.sqrt(0.7) * rng.normal(size=22)[recordings] + np.sqrt(0.3) * rng.normal(size=88)
        failed = (strength > norm.isf(truth)).astype(float)
        weight = independent_motions(strength, recordings) / 88.0
        (share,) = shares(failed[:, None], [{"gap": 0.0}], weight, 0.95)
        held["low"] += share.low <= truth <= share.high
        held["low_recordings"] += share.low_recordings <= truth <= share.high_recordings
    assert held["low_recordings"] >= 371
    assert held["low"] < 367  # three standard deviations below 95 %


def test_bounds_hold_where_sequences_share_their_aftershocks():
    """40 first shocks with 10 aftershocks, each behind 4 of them, of which the stronger one decides.

    The strength of a sequence is max(X, 0.3 + Y), X and Y normal and independent, so that P(strength > s) is 1 − Φ(s)
    Φ(s − 0.3). Counted by aftershock bounds hold as those by recording above; counted by first shock they do not.
    """
    rng = np.random.default_rng(6)
    after = np.repeat(np.arange(10), 4)
    numbers = joined([(("first", first), ("after", shock)) for first, shock in enumerate(after)])
    assert numbers.tolist() == after.tolist()
    level = 1.0
    truth = 1.0 - norm.cdf(level) * norm.cdf(level - 0.3)
    held = {"joined": 0, "first": 0}
    for _ in range(400):
        strength = np.maximum(rng.normal(size=40), 0.3 + rng.normal(size=10)[after])
        failed = (strength > level).astype(float)
        for name, labels_ in (("joined", numbers), ("first", np.arange(40))):
            weight = independent_motions(strength, labels_) / 40.0
            (share,) = shares(failed[:, None], [{"gap": 0.0}], weight, 0.95)
            held[name] += share.low_recordings <= truth <= share.high_recordings
    assert held["joined"] >= 371
    assert held["first"] < 367


def test_what_shares_a_key_is_joined():
    """The components of a graph, as SciPy finds them, of random sequences; a chain of them is one."""
    rng = np.random.default_rng(7)
    for shocks in (10, 40, 160):
        first, after = rng.integers(shocks, size=(2, 60))
        graph = csr_matrix((np.ones(60), (first, after)), shape=(shocks, shocks))
        known = connected_components(graph, directed=False)[1][first]
        assert joined(list(zip(first, after, strict=True))).tolist() == labels(list(known)).tolist()
    chain = joined([(number, number + 1) for number in range(5)])
    assert independent_motions(rng.normal(size=5), chain) == 1.0
    assert joined([(2,), (5, 2), (3,)]).tolist() == [0, 0, 1]


def test_runs_that_are_left_out_count_neither_way():
    failed = np.array([[1.0, np.nan], [0.0, np.nan], [np.nan, np.nan], [1.0, np.nan]])
    first, second = shares(failed, [{"gap": 0.1}, {"gap": 0.2, "yield_force": 3e6}], 0.5, 0.95)
    assert (first.count, first.runs, first.left_out) == (2, 3, 1)
    assert first.probability == pytest.approx(2.0 / 3.0)
    assert (first.low, first.high) == pytest.approx(tuple(map(float, exact_bounds(2, 3, 0.95))))
    assert (second.count, second.runs, second.left_out, second.yield_force) == (0, 0, 4, 3e6)
    assert np.isnan([second.probability, second.low, second.high_recordings]).all()


def test_labels_are_numbers_in_the_order_of_names():
    assert labels(["b", "a", "b", ("c", 1)]).tolist() == [0, 1, 0, 2]
