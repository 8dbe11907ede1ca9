"""Samples crossed with motions: components of variance, how many outcomes count, and coverage of the bounds."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import binom, multivariate_normal

from pounding_risk.statistics.closings import CrossedClosings
from pounding_risk.statistics.crossed import analysed, counted_outcomes, outcome_correlation, outcome_shares
from pounding_risk.statistics.proportions import independent_motions
from pounding_risk.statistics.required_gap import contact_steps

CONFIDENCE = 0.95


def drawn(rng, samples, recordings, deviations, of_one=1):
    """ln closing = a_s + b_r + c_sr, motions of one recording in a row, each with the recording's b."""
    of_samples, of_motions, rest = deviations
    labels = np.repeat(np.arange(recordings), of_one)
    logs = of_samples * rng.normal(size=(samples, 1)) + of_motions * rng.normal(size=recordings)[labels]
    return logs + rest * rng.normal(size=(samples, labels.size)), labels


def test_components_are_those_of_the_analysis_of_variance():
    values, labels = drawn(np.random.default_rng(1), 7, 5, (1.0, 1.0, 1.0))
    found = analysed(values, labels)
    rest = values - values.mean(0) - values.mean(1)[:, None] + values.mean()
    residual = (rest**2).sum() / (6 * 4)
    assert found.all.interaction == pytest.approx(residual)
    assert found.all.samples == pytest.approx(values.mean(1).var(ddof=1) - residual / 5)
    assert found.all.motions == pytest.approx(values.mean(0).var(ddof=1) - residual / 7)
    # Leaving out a recording is the analysis of the others; the centre of all does not matter where sizes are equal.
    without = analysed(values[:, 1:], labels[:-1]).all
    assert found.without_recording.samples[0] == pytest.approx(without.samples)
    assert found.without_block.motions[2] == pytest.approx(analysed(np.delete(values, 2, axis=0), labels).all.motions)


def test_components_have_no_bias_where_motions_share_recordings():
    rng = np.random.default_rng(2)
    repeats = 400
    found = np.empty((repeats, 4))
    for repeat in range(repeats):
        values, _ = drawn(rng, 6, 9, (0.4, 0.0, 0.3))
        labels = np.array([0, 0, 0, 1, 1, 2, 3, 3, 3])
        values += 0.5 * rng.normal(size=4)[labels] + 0.2 * rng.normal(size=9)
        found[repeat] = analysed(values, labels).all
    error = found.std(axis=0, ddof=1) / np.sqrt(repeats)
    assert np.all(np.abs(found.mean(axis=0) - (0.16, 0.29, 0.09, 0.25)) < 4.0 * error)
    assert np.all(error < 0.02)


def test_samples_that_are_all_the_same_add_nothing():
    rng = np.random.default_rng(4)
    logs, labels = drawn(rng, 1, 12, (0.0, 0.5, 0.0))
    closings = CrossedClosings(np.exp(np.repeat(logs, 500, axis=0)), labels)
    gap = float(np.median(np.exp(logs)))
    weight = independent_motions(logs[0], labels) / logs.size
    alone = contact_steps(np.exp(logs[0]), weight, CONFIDENCE)
    at = int(np.searchsorted(alone.gaps, gap, "right")) - 1
    together = closings.contact(gap, CONFIDENCE)
    assert together.independent[0] == pytest.approx(weight * logs.size)
    assert together.low[0] == pytest.approx(alone.low[at])
    assert together.high[0] == pytest.approx(alone.high[at])


def test_bounds_without_contact_are_those_of_the_recordings_or_of_the_samples():
    rng = np.random.default_rng(5)
    for samples, recordings in ((100, 10), (6, 30)):
        logs, labels = drawn(rng, samples, recordings, (0.3, 0.3, 0.1))
        closings = CrossedClosings(np.exp(logs), labels)
        never = closings.contact(2.0 * float(np.exp(logs.max())), CONFIDENCE)
        fewest = min(samples, recordings)
        assert never.value[0] == 0.0
        assert never.high[0] == pytest.approx(1.0 - 0.025 ** (1.0 / fewest))
        # And no gap that some outcomes close has an upper bound that is lower.
        assert closings.contact(np.percentile(closings.closing, 99.9), CONFIDENCE).high[0] >= never.high[0]
        always = closings.contact(0.0, CONFIDENCE)
        assert (always.low[0], always.high[0]) == (pytest.approx(0.025 ** (1.0 / fewest)), 1.0)


@pytest.mark.parametrize(
    ("samples", "recordings", "deviations", "of_one"),
    [
        (20, 10, (0.3, 0.5, 0.15), 1),
        (20, 22, (0.5, 0.2, 0.1), 1),
        (60, 12, (0.15, 0.5, 0.1), 4),
        (12, 12, (0.1, 0.1, 0.4), 1),
    ],
)
@pytest.mark.complete
def test_bounds_hold_the_true_probability_and_the_true_gap(samples, recordings, deviations, of_one):
    rng = np.random.default_rng(6)
    repeats, percentiles = 120, (50.0, 84.0)
    total = np.sqrt(np.square(deviations).sum())
    true_gaps = np.exp(total * ndtri(np.array(percentiles) / 100.0))
    held_probability, held_gap = np.zeros(2), np.zeros(2)
    for _ in range(repeats):
        logs, labels = drawn(rng, samples, recordings, deviations, of_one)
        closings = CrossedClosings(np.exp(logs), labels)
        contact = closings.contact(true_gaps, CONFIDENCE)
        true = 1.0 - np.array(percentiles) / 100.0
        held_probability += (contact.low <= true) & (true <= contact.high)
        required = closings.required(percentiles, CONFIDENCE)
        held_gap += [
            one.low <= gap and (gap <= one.high or not one.bounded)
            for one, gap in zip(required, true_gaps, strict=True)
        ]
    least = binom.ppf(0.001, repeats, CONFIDENCE)
    assert np.all(held_probability >= least)
    assert np.all(held_gap >= least)


@pytest.mark.complete
def test_bounds_hold_where_few_samples_close_much_more():
    """Not lognormal: 20 % of the samples close five times as much, which the logarithms alone do not show."""
    rng = np.random.default_rng(8)
    repeats, held = 150, 0
    for _ in range(repeats):
        logs, labels = drawn(rng, 25, 25, (0.0, 0.4, 0.0))
        wide = rng.random(25) < 0.2
        closings = CrossedClosings(np.exp(logs + 5.0 * wide[:, None]), labels)
        contact = closings.contact(np.exp(2.5), CONFIDENCE)
        held += bool(contact.low[0] <= 0.2 <= contact.high[0])
        assert contact.independent[0] < 26.0
    assert held >= binom.ppf(0.001, repeats, CONFIDENCE)


def test_correlation_of_outcomes_is_that_of_the_normal_distribution():
    share, correlation = np.array([0.05, 0.16, 0.5]), 0.6
    both = [
        multivariate_normal([0.0, 0.0], [[1.0, correlation], [correlation, 1.0]]).cdf([ndtri(p), ndtri(p)])
        for p in share
    ]
    np.testing.assert_allclose(
        outcome_correlation(share, correlation), (both - share**2) / (share * (1 - share)), rtol=1e-3
    )
    assert outcome_correlation(np.array(0.5), 0.6) == pytest.approx(2.0 / np.pi * np.arcsin(0.6))
    np.testing.assert_array_equal(outcome_correlation(np.array([0.0, 0.3, 1.0]), 1.0), 1.0)


def test_outcomes_that_a_sample_or_a_motion_decides():
    labels = np.arange(6)
    by_sample = np.repeat(np.array([True, False, True, False])[:, None], 6, axis=1)
    by_motion = np.repeat(np.array([True, False, False, True, True, False])[None], 4, axis=0)
    samples, motions = outcome_shares(np.stack([by_sample, by_motion, np.ones((4, 6), bool)]), labels)
    np.testing.assert_allclose(samples, (1.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(motions, (0.0, 1.0, 0.0), atol=1e-12)


@pytest.mark.complete
def test_bounds_of_deviations_hold_the_true_ones():
    rng = np.random.default_rng(9)
    repeats, held = 120, np.zeros(3)
    deviations = np.array([0.3, 0.5, 0.15])
    for _ in range(repeats):
        values, labels = drawn(rng, 40, 22, deviations)
        found = analysed(values, labels)
        parts = (lambda one: one.samples, lambda one: one.motions, lambda one: one.total)
        for place, (of, true) in enumerate(zip(parts, (0.09, 0.25, 0.3625), strict=True)):
            _, low, high = found.variance_bounds(of, CONFIDENCE)
            held[place] += low <= true <= high
    # The jackknife's bounds are not exact; a number of degrees of freedom is itself an estimate.
    assert np.all(held >= 0.92 * repeats)


@pytest.mark.parametrize("samples, motions", [(4, 1), (4, 3)])
def test_outcomes_that_never_differ_count_as_one_of_what_they_share(samples, motions):
    """One motion, or several that close the same, under numbers without influence: no component can be estimated."""
    labels = np.arange(motions)
    closings = CrossedClosings(np.full((samples, motions), 0.03), labels)
    assert (closings.counted.like_samples, closings.counted.like_motions) == (1.0, 1.0)
    contact = closings.contact([0.02, 0.04], CONFIDENCE)
    assert contact.value.tolist() == [1.0, 0.0]
    # One outcome of which nothing is known bounds a probability to 2.5 % at best.
    assert contact.low[0] >= 0.0 and contact.high[0] == 1.0 and contact.low[1] == 0.0 and contact.high[1] >= 0.6


def test_one_recording_tells_nothing_of_the_motions():
    logs, _ = drawn(np.random.default_rng(10), 30, 4, (0.3, 0.5, 0.1))
    found = analysed(logs, np.zeros(4, dtype=np.int64))
    assert np.isnan(found.all.motions)
    counted = counted_outcomes(logs, np.zeros(4, dtype=np.int64), found)
    assert counted.independent(np.array([0.5]))[0] <= 1.0
    assert (counted.like_samples, counted.like_motions) == (1.0, 1.0)
