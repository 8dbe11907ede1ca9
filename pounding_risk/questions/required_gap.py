"""Cells of required gaps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pounding_risk.assessment.options import NO_LOWER, NO_UPPER
from pounding_risk.render.sheet import Cell, amount, number
from pounding_risk.statistics.required_gap import RequiredGap, rounded_up


def enough(gap: float, unit: bool = False) -> Cell:
    """A required gap [m] rounded up to three digits, so that what is read suffices too."""
    return (amount if unit else number)(rounded_up(gap), "m")


def bounds_cell(required: RequiredGap) -> Cell:
    """The bounds of a required gap with the marks that `NO_BOUND` explains, in the unit of the column's head."""
    low = number(required.low, "m")["text"] if required.low > 0.0 else NO_LOWER
    high = number(rounded_up(required.high), "m")["text"]
    text = f"{low} to {high}{'' if required.bounded else f' {NO_UPPER}'}"
    return {"text": text, "parts": [required.low, required.high]}


def marks(required: Iterable[RequiredGap], words: Mapping[str, str]) -> list[str]:
    """What each mark means that stands in the bounds of these required gaps."""
    bounds = " ".join(bounds_cell(each)["text"] for each in required)
    return [f"{mark} {meaning}." for mark, meaning in words.items() if mark in bounds]
