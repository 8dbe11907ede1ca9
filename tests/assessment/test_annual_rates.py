"""Annual rates from return periods and probabilities, against Poisson's closed form and published return periods."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import poisson
from sentences import refusal

from pounding_risk.assessment.annual_rates import read_rate, return_period_words
from pounding_risk.statistics.hazard import in_years, rate_of_probability
from pounding_risk.units import QuantityError


@pytest.mark.parametrize(
    ("text", "period"), [("10 % in 50 years", 475), ("2 % in 50 years", 2475), ("5% in 50yr", 975)]
)
def test_the_return_periods_of_codes(text, period):
    """EN 1998-1, 2.1, and ASCE 7: 475, 2475 and 975 years, rounded there."""
    assert 1.0 / read_rate(text).rate == pytest.approx(period, abs=0.7)


@pytest.mark.parametrize("probability", [1e-12, 0.02, 0.5, 0.999])
def test_a_probability_is_that_of_poissons_law(probability):
    """SciPy's P(N ≥ 1) with the mean rate × years gives the probability back; as does the function's own inverse."""
    rate = rate_of_probability(probability, 30.0)
    assert poisson.sf(0, 30.0 * rate) == pytest.approx(probability, rel=1e-12)
    assert in_years(rate, 30.0) == pytest.approx(probability, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "rate", "words", "years"),
    [
        ("0.01 in 100 years", -np.log(0.99) / 100.0, "1 % in 100 years", 100.0),
        ("Probability of 1 % in 1 year", -np.log(0.99), "1 % in 1 year", 1.0),
        ("2475 years", 1.0 / 2475.0, "once in 2475 years", 50.0),
        ("return period of 475 yr", 1.0 / 475.0, "once in 475 years", 50.0),
        ("once in 1e4 years", 1e-4, "once in 10000 years", 50.0),
        ("4e-4 a year", 4e-4, "0.0004 a year", 50.0),
        ("annual rate 0.002", 0.002, "0.002 a year", 50.0),
        (".002 1/year", 0.002, "0.002 a year", 50.0),
        (0.002, 0.002, "0.002 a year", 50.0),
    ],
)
def test_a_rate_is_read_from_its_forms(text, rate, words, years):
    found = read_rate(text)
    assert found.rate == pytest.approx(rate, rel=1e-14)
    assert (found.words, found.years) == (words, years)
    assert read_rate(found.words).rate == pytest.approx(rate, rel=1e-5)  # the words are read again


@pytest.mark.parametrize(
    "text",
    [
        "1 in 2475 years",
        "10 in 50 years",
        "100 % in 50 years",
        "0 % in 50 years",
        "1 % in 0 years",
        "0 years",
        "1e999 years",
        "2475",
        "0",
        "-1e-4 a year",
        "rarely",
        "",
        "1 % in 50",
        float("nan"),
        None,
        [1.0],
        "1e-300 % in 1e300 years",
    ],
    ids=repr,
)
def test_what_is_no_rate_is_refused_with_what_to_write(text, says):
    says(refusal(read_rate, text, "target", kind=QuantityError))


def test_a_return_period_in_words():
    assert [return_period_words(1.0 / years) for years in (475.3, 12.34, 3e7)] == [
        "once in 475 years",
        "once in 12.3 years",
        "once in 3e+07 years",
    ]
