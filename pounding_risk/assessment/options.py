"""The criterion of an assessment: target probability, percentile of the required gap, and confidence of bounds.

A share may be written 0.84, 84 or "84 %", with one meaning; an ambiguous one is refused, so that no verdict follows
from a slip. A percentile leaves a target, 16 % of 84 %, and a target asks for a percentile: of the two the one that is
not given follows from the other.

    >>> from pounding_risk.assessment.options import read_criterion
    >>> read_criterion(target="10 %")
    Criterion(target=0.1, percentile=90.0, confidence=0.95)
"""

from __future__ import annotations

from typing import Any, NamedTuple

from pounding_risk.statistics.required_gap import DIGITS, target_left_by
from pounding_risk.units import QuantityError, share, shown

USUAL_PERCENTILE = 84.0  # %
USUAL_CONFIDENCE = 0.95
HALF = 0.5  # of the motions: the most that a target accepts, the least that a gap is required for, or bounds hold
SUREST = 0.999999  # a confidence is smaller: sentences have six digits of it
LEAST = 1e-9  # a target, or what a percentile leaves, is larger
SAME = 1e-10  # two shares that differ by less are one, rounded apart
NO_LOWER, NO_UPPER, PUSHED = "–", "*", "†"  # marks of a required gap's bounds that are none
NO_BOUND = {
    NO_LOWER: "no lower bound above 0: with so few recordings even a gap that all motions close may suffice",
    NO_UPPER: "the largest gap that a motion needs: with so few recordings there is no upper bound",
    PUSHED: "no upper bound: across gaps wider than the row was run at, neighbours may push the two together",
}


class Criterion(NamedTuple):
    """Accepted probability of contact, percentile [%] of the required gap, and confidence of all bounds.

    The verdict uses ``target``, whether or not ``percentile`` leaves the same.
    """

    target: float
    percentile: float
    confidence: float

    @property
    def agrees(self) -> bool:
        """Whether the percentile leaves exactly the target."""
        return abs(target_left_by(self.percentile) - self.target) < SAME

    @property
    def target_percentile(self) -> float:
        """The percentile [%] whose gap leaves the target."""
        return self.percentile if self.agrees else percentile_for(self.target)

    @property
    def words(self) -> str:
        """Sentence on the target, percentile and confidence as they were read."""
        target, confidence = percent_words(self.target), percent_words(self.confidence)
        gap = f"the gap required is that of {self.percentile:g} % of the motions"
        if not self.agrees:
            gap += f", which leaves {percent_words(target_left_by(self.percentile))}: the verdict uses the target"
        return f"Held against a probability of contact of at most {target} (the target); {gap}; bounds of {confidence}."


def read_criterion(
    target: float | str | None = None,
    percentile: float | str | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    prefix: str = "",
) -> Criterion:
    """Criterion from the shares that the user gave; each default follows from the other.

    A target is below 50 %, a percentile and the confidence above it; ``prefix`` stands before the names in an error,
    such as ``--`` of a command's options. Raises QuantityError for what is no share, and for one that cannot be meant.
    """
    target_share = None if target is None else _read_target(target, f"{prefix}target")
    if percentile is not None:
        gap_percentile = percentile_of(percentile, f"{prefix}percentile")
    else:
        gap_percentile = USUAL_PERCENTILE if target_share is None else percentile_for(target_share)
    level = share(confidence, f"{prefix}confidence", low=HALF, high=SUREST)
    return Criterion(target_left_by(gap_percentile) if target_share is None else target_share, gap_percentile, level)


def percentile_of(value: float | str, name: str = "percentile") -> float:
    """A percentile in %, between 50 and 100, from 84, 0.84 or "84 %"; raises QuantityError that names it."""
    try:
        return round(100.0 * share(value, name, low=HALF, high=1.0 - LEAST), DIGITS)
    except QuantityError as error:
        raise QuantityError(
            f"{error}. It is the share of the motions that the gap required is for, such as 84 %"
        ) from None


def percentile_for(target: float) -> float:
    """The percentile [%] whose gap leaves ``target``."""
    return round(100.0 * (1.0 - target), DIGITS)


def percent_words(fraction: float) -> str:
    """A fraction in %, in full: 0.1 is "10 %", 0.0025 is "0.25 %"."""
    return f"{round(100.0 * fraction, DIGITS):.12g} %"


def _read_target(value: Any, name: str) -> float:
    if isinstance(value, str) and "year" in value:
        raise QuantityError(
            f"{name}: {shown(value)} is a rate; write it as --target-rate (target_rate in Python), beside a hazard "
            "curve. The target is the probability of contact under one motion of the dataset, such as 10 %"
        )
    try:
        target = share(value, name, high=HALF)
        if target < LEAST:
            raise QuantityError(f"{name}: {value} is less than {LEAST:g}, which no number of motions shows")
        return target
    except QuantityError as error:
        raise QuantityError(f"{error}. It is the probability of contact that is accepted, such as 10 %") from None
