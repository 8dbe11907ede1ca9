"""Targets, percentiles and confidences: one convention, one following from the other, and no verdict from a slip."""

from __future__ import annotations

import doctest

import pytest
from sentences import refusal

from pounding_risk.assessment import options as assessment_options
from pounding_risk.assessment.options import percentile_for, percentile_of, read_criterion
from pounding_risk.statistics.required_gap import target_left_by


def test_examples_in_docstrings_are_right():
    assert doctest.testmod(assessment_options).failed == 0


@pytest.mark.parametrize("value", [0.84, 84, "0.84", "84", "84 %", "84%"])
def test_a_percentile_is_the_same_however_it_is_written(value):
    assert read_criterion(percentile=value) == (0.16, 84.0, 0.95)


@pytest.mark.parametrize("value", [0.1, 10, "0.1", "10", "10 %"])
def test_a_target_asks_for_the_percentile_that_leaves_it(value):
    assert read_criterion(target=value) == (0.1, 90.0, 0.95)
    assert read_criterion(target=value).target_percentile == 90.0


@pytest.mark.parametrize("value", [0.9, 90, "90 %"])
def test_a_confidence_is_the_same_however_it_is_written(value):
    assert read_criterion(confidence=value) == (0.16, 84.0, 0.9)


def test_one_percent_less_than_all_is_no_rounding():
    """Each percentile in thousandths leaves a target from which the same percentile follows."""
    for thousandths in range(50_001, 100_000, 7):
        percentile = thousandths / 1000
        target = target_left_by(percentile)
        assert percentile_for(target) == percentile_of(percentile) == percentile
        assert read_criterion(target, percentile).agrees


@pytest.mark.parametrize(
    "given",
    [
        {"percentile": "0.9 %"},
        {"percentile": 10},
        {"percentile": 50},
        {"percentile": 100},
        {"percentile": 1},
        {"percentile": float("nan")},
        {"target": 84},
        {"target": 0.99},
        {"target": 0},
        {"target": -0.1},
        {"target": 1e-12},
        {"target": True},
        {"target": "ten"},
        {"target": [0.1]},
        {"confidence": 0.3},
        {"confidence": 1.0},
    ],
    ids=str,
)
def test_what_cannot_be_meant_is_refused(given, says):
    says(refusal(read_criterion, **given))


def test_a_refusal_says_what_the_number_is(says):
    """A percentile in the target's place, and a target in the percentile's."""
    says(refusal(read_criterion, target=84), refusal(read_criterion, percentile=16))


def test_what_was_read_is_told_and_which_the_verdict_uses():
    follows = read_criterion(target="10 %").words
    assert "at most 10 % (the target); the gap required is that of 90 % of the motions; bounds of 95 %" in follows
    both = read_criterion("10 %", 84)
    assert not both.agrees and both.target_percentile == 90.0
    assert "that of 84 % of the motions, which leaves 16 %: the verdict uses the target" in both.words
    assert "the verdict uses" not in read_criterion(0.16, 84).words
