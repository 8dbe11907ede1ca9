"""Annual rates, return periods and probabilities in some years, each from the others.

Events are taken to be independent of each other (Poisson): with an annual rate λ the mean return period is 1/λ, and the
probability of one or more in t years is 1 − exp(−λ t).

    >>> from pounding_risk.assessment.annual_rates import read_rate
    >>> read_rate("10 % in 50 years").words
    '10 % in 50 years'
    >>> round(1.0 / read_rate("10 % in 50 years").rate, 1)  # years
    474.6
    >>> read_rate("475 years").rate == 1.0 / 475.0
    True
"""

from __future__ import annotations

import re
from math import inf, isfinite
from typing import Any, NamedTuple

from pounding_risk.statistics.hazard import YEARS, rate_of_probability
from pounding_risk.units import QuantityError, shown

MOST = 1.0  # a year, of a rate that is a plain number: what is larger was meant as a return period
REPAIR = 'write "1 % in 50 years", a return period such as "2475 years", or a rate such as "4e-4 a year"'
_NUMBER = r"(\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?)"
_UNIT = r"(?:years?|yrs?|a)"
_PROBABILITY = re.compile(rf"(?:probability of )?{_NUMBER} *(%?) *in *{_NUMBER} *{_UNIT}")
_RETURN_PERIOD = re.compile(rf"(?:(?:a )?return period(?: of)?|once in|every)? *{_NUMBER} *{_UNIT}")
_RATE = re.compile(rf"(?:annual (?:rate|frequency)(?: of)?)? *{_NUMBER} *(?:(?:a|per) year|(?:1 */|/) *{_UNIT}|)")


class AnnualRate(NamedTuple):
    """A rate [1/year], the words in which it was given, and the years of probabilities that are stated beside it."""

    rate: float
    words: str
    years: float = YEARS


def return_period_words(rate: float) -> str:
    """The return period of an annual rate: "once in 2475 years"."""
    period = 1.0 / rate
    return f"once in {f'{period:.0f}' if period < 1e6 and period >= 100.0 else f'{period:.3g}'} years"


def read_rate(stated: float | str, name: str = "rate") -> AnnualRate:
    """Read an annual rate from "1 % in 50 years", "2475 years", "4e-4 a year", or a plain number a year.

    ``name`` is the parameter or option, which an error names first. Raises QuantityError for text that is none of
    these, a probability that does not lie between 0 and 1, a number of years or a rate that is not above 0, and a plain
    number of 1 a year or more, which is meant as a return period.
    """
    if isinstance(stated, str):
        return _rate_of_text(stated, name)
    try:
        number = float(stated)
    except (TypeError, ValueError):
        raise QuantityError(f"{name}: {shown(stated)} is no rate; {REPAIR}") from None
    return _plain_rate(number, stated, name)


def read_target_rate(stated: AnnualRate | float | str | None, has_hazard: bool) -> AnnualRate | None:
    """The rate of contact that the user accepts, None where none is given.

    Raises QuantityError as `read_rate`, and without a hazard curve.
    """
    if stated is None or isinstance(stated, AnnualRate):
        return stated
    if not has_hazard:
        raise QuantityError("target_rate: a rate of contact follows from a hazard curve; add --hazard hazard.csv")
    return read_rate(stated, "target_rate")


def _rate_of_text(text: str, name: str) -> AnnualRate:
    lowered = " ".join(text.lower().split())
    if match := _PROBABILITY.fullmatch(lowered):
        probability, years = float(match[1]) / (100.0 if match[2] else 1.0), _checked_years(match[3], text, name)
        if not 0.0 < probability < 1.0:
            raise QuantityError(
                f"{name}: {shown(text)} has a probability of {probability:g}, which must lie between 0 and 1 (100 %), "
                f"ends excluded; {REPAIR}"
            )
        rate = rate_of_probability(probability, years)
        return AnnualRate(_finite_rate(rate, text, name), f"{100.0 * probability:.6g} % in {_span(years)}", years)
    if match := _RETURN_PERIOD.fullmatch(lowered):
        period = _checked_years(match[1], text, name)
        return AnnualRate(_finite_rate(1.0 / period, text, name), f"once in {_span(period)}")
    if match := _RATE.fullmatch(lowered):
        return _plain_rate(float(match[1]), text, name)
    raise QuantityError(f"{name}: {shown(text)} is no rate; {REPAIR}")


def _plain_rate(rate: float, value: Any, name: str) -> AnnualRate:
    if not 0.0 < rate < MOST:
        raise QuantityError(
            f"{name}: {shown(value)} is a rate of {rate:g} a year, which must be above 0 and below {MOST:g}; {REPAIR}"
        )
    return AnnualRate(rate, f"{rate:.6g} a year")


def _checked_years(number: str, text: str, name: str) -> float:
    years = float(number)
    if not 0.0 < years < inf:
        raise QuantityError(f"{name}: {shown(text)} has {years:g} years, which must be above 0 and finite; {REPAIR}")
    return years


def _finite_rate(rate: float, text: str, name: str) -> float:
    if not (isfinite(rate) and rate > 0.0):
        raise QuantityError(f"{name}: {shown(text)} is a rate of {rate:g} a year, which no number holds; {REPAIR}")
    return rate


def _span(years: float) -> str:
    return "1 year" if years == 1.0 else f"{years:.6g} years"
