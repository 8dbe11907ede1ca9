"""Targets, percentiles and confidences: one convention, one following from the other, and no verdict from a slip."""

from __future__ import annotations

import doctest
import re

import pytest

from pounding_risk.assessment import options as assessment_options
from pounding_risk.assessment.options import percentile_for, percentile_of, read_criterion
from pounding_risk.errors import PoundingError
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
    ("given", "words"),
    [
        ({"percentile": "0.9 %"}, 'percentile: "0.9 %" is 0.9 %; it must lie between 50 % and 100 %'),
        ({"percentile": 10}, "percentile: 10 is 10 %; it must lie between 50 % and 100 %"),
        ({"percentile": 50}, "percentile: 50 is 50 %"),
        ({"percentile": 100}, "percentile: 100 is 100 %"),
        ({"percentile": 1}, "percentile: 1 could be 1 % or 100 %"),
        ({"percentile": float("nan")}, "percentile: nan is out of range"),
        ({"target": 84}, "target: 84 is 84 %; it must lie between 0 % and 50 %"),
        ({"target": 0.99}, "target: 0.99 is 99 %"),
        ({"target": 0}, "target: 0 is 0 %"),
        ({"target": -0.1}, "target: -0.1 is out of range"),
        ({"target": 1e-12}, "target: 1e-12 is less than 1e-09"),
        ({"target": True}, "target: true is not"),
        ({"target": "ten"}, 'target: "ten" is not a number'),
        ({"target": [0.1]}, "target: [0.1] is not"),
        ({"confidence": 0.3}, "confidence: 0.3 is 30 %; it must lie between 50 % and 100 %"),
        ({"confidence": 1.0}, "confidence: 1.0 could be 1 % or 100 %"),
    ],
)
def test_what_cannot_be_meant_is_refused(given, words):
    with pytest.raises(PoundingError, match=re.escape(words)):
        read_criterion(**given)


def test_a_refusal_says_what_the_number_is():
    """A percentile in the target's place, and a target in the percentile's."""
    with pytest.raises(PoundingError, match="It is the probability of contact that is accepted"):
        read_criterion(target=84)
    with pytest.raises(PoundingError, match="It is the share of the motions that the gap required is for"):
        read_criterion(percentile=16)


def test_what_was_read_is_told_and_which_the_verdict_uses():
    follows = read_criterion(target="10 %").words
    assert "at most 10 % (the target); the gap required is that of 90 % of the motions; bounds of 95 %" in follows
    both = read_criterion("10 %", 84)
    assert not both.agrees and both.target_percentile == 90.0
    assert "that of 84 % of the motions, which leaves 16 %: the verdict uses the target" in both.words
    assert "the verdict uses" not in read_criterion(0.16, 84).words
