"""The verdict on a gap by its annual rate of contact, and the gap to provide for a target rate.

A gap is adequate where the upper bound of the rate is no more than the target, inadequate where the lower bound is
above it, and depends otherwise. A rate that a hazard curve gives only a lower bound of, as it ends where contact does
not, shows no gap to be adequate, and neither do motions some of which have no finite response.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, isnan
from typing import NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk.assessment.annual_rates import AnnualRate, return_period_words
from pounding_risk.assessment.gap_for_rate import GapForRate
from pounding_risk.assessment.hazard import Rate
from pounding_risk.assessment.options import percent_words
from pounding_risk.assessment.verdict import ADEQUATE, DEPENDS, INADEQUATE
from pounding_risk.statistics.hazard import in_years
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import GAP, say

SHAPE = "Scaling a motion keeps the shape of its spectrum; that of motions as rare as the hazard curve says may differ."
TOO_SHORT = "the hazard curve ends where contact does not"


@dataclass(frozen=True)
class RateVerdict:
    """The verdict on a gap by the target rate [1/year], ``words`` as it was given, and the gap to provide for it.

    ``annual``, ``low`` and ``high`` are the rate of contact at the gap and its bounds; NaN where it has none.
    ``conclusion`` stands in that of the `Verdict` too.
    """

    word: str
    sentence: str
    conclusion: tuple[str, ...]
    target: float
    words: str
    annual: float
    low: float
    high: float
    required: GapForRate


class RateCriterion(NamedTuple):
    """What a rate of contact is held against: the target, the confidence of the bounds, and the name of the hazard."""

    target: AnnualRate
    confidence: float
    source: str


def judge_rate(here: Rate, required: GapForRate, criterion: RateCriterion, lost: int = 0) -> RateVerdict:
    """The verdict on a gap by its rate of contact; the docstring of this module states the rule.

    Parameters
    ----------
    here : Rate
        The rate of contact at the gap.
    required : GapForRate
        The gap that keeps contact to the target.
    criterion : RateCriterion
        What the rate is held against.
    lost : int
        Number of motions without a finite response, which are in neither.
    """
    target, confidence = criterion.target, percent_words(criterion.confidence)
    word = _word(here, target, lost)
    sentence = f"{word.capitalize()} by rate: {_finding(here, target, confidence)}{_why(word, here, target, lost)}"
    provide = _provide(required, criterion)
    return RateVerdict(
        word=word,
        sentence=sentence,
        conclusion=(f"{sentence} {provide}",),
        target=target.rate,
        words=target.words,
        annual=here.annual,
        low=here.low,
        high=here.high,
        required=required,
    )


def _word(here: Rate, target: AnnualRate, lost: int) -> str:
    if here.low > target.rate:
        return INADEQUATE
    return ADEQUATE if here.high <= target.rate and not (here.at_least or lost) else DEPENDS


def _finding(here: Rate, target: AnnualRate, confidence: str) -> str:
    gap = say(here.gap, GAP, 3)
    if here.fault:
        return f"how often contact comes at a gap of {gap} is not known ({here.fault})"
    least = "at least " if here.at_least else ""
    shares = [in_years(rate, target.years) for rate in (here.annual, here.low, here.high)]
    chance, *ends = (f"{100.0 * share:.2g} %" for share in shares)
    bounds = f" ({confidence} bounds {ends[0]} to {ends[1]})" if isfinite(here.low) else ""
    often = return_period_words(here.annual) if here.annual > 0.0 else "never"
    span = "1 year" if target.years == 1.0 else f"{target.years:g} years"
    return f"at a gap of {gap} contact comes {least}{often}, {least}{chance} in {span}{bounds}"


def _why(word: str, here: Rate, target: AnnualRate, lost: int) -> str:
    if here.fault:
        return "."
    aim = target.words if target.words.endswith("%") else f"the target of {target.words}"
    if word == ADEQUATE:
        return f", within {aim} throughout."
    if word == INADEQUATE:
        return f", above {aim} throughout."
    reason = ""
    if here.high <= target.rate:
        reason = f", as {TOO_SHORT}" if here.at_least else f", as {counted(lost, 'motion')} without a finite response"
        reason += "" if here.at_least else f" {'is' if lost == 1 else 'are'} not in it"
    return f": on which side of {aim} it is stays open{reason}."


def _provide(required: GapForRate, criterion: RateCriterion) -> str:
    target = criterion.target
    often = target.words if target.words.startswith("once") else f"{target.words} ({return_period_words(target.rate)})"
    aim = f"contact no more often than {often} under {criterion.source}"
    if required.fault:
        return f"No gap can be given for {aim}: {required.fault}."
    gap = say(rounded_up(required.gap), GAP, 3)
    least = "at least " if required.at_least else ""
    sentence = f"Provide {least}{gap} for {aim} ({percent_words(criterion.confidence)} bounds {gap_bounds(required)})"
    sentence += f", as {TOO_SHORT}." if required.at_least else "."
    if not isnan(required.counted):
        sentence += f" Counted motion by motion, without a lognormal curve, it is {say(required.counted, GAP, 3)}."
    return sentence


def gap_bounds(required: GapForRate) -> str:
    """Bounds of a gap in words: "118 mm to 176 mm", "at least 118 mm", or "none"."""
    if isnan(required.low):
        return "none"
    low = say(required.low, GAP, 3)
    return f"{low} to {say(required.high, GAP, 3)}" if isfinite(required.high) else f"at least {low}"
