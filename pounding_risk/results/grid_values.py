"""Values of a grid found by what a user writes: a number in SI, text with a unit, or a name."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isclose, isinf
from typing import Any

from pounding_risk._common.words import nearest, short_list
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import read_measure, say_level
from pounding_risk.units import GAP, PGA, YIELD_FORCE, Quantity, si

NEAR = 1e-9  # relative: a value of the grid that was written down and read again
FEW = 8  # values of a grid that a sentence lists
QUANTITIES = {"pga": PGA, "gap": GAP, "yield_force": YIELD_FORCE}


def quantity_of(axis: str) -> Quantity | None:
    """What the values of an axis are; None of names.

    The axis of levels of a measure goes by the word of that measure, such as "sa(0.5 s)" (`amplitudes.axis_name`).
    """
    measure = read_measure(axis)
    return QUANTITIES.get(axis) if measure is None else measure.quantity


def place_of(axis: str, known: tuple[Any, ...], value: Any) -> int:
    """Index of a value among those of an axis of `AXES`; a number in SI, or text with a unit.

    A number stands for the value that is as large, within 1e-9 of it. Raises PoundingError for what is not there.
    """
    quantity = quantity_of(axis)
    if quantity is not None:
        value = si(value, quantity, axis_words(axis))
    if known == (None,):
        raise PoundingError(
            "the scene scales its records to no PGA, so that there is none to choose; leave it out, or choose records"
        )
    for index, level in enumerate(known):
        if level == value or (quantity is not None and isclose(level, value, rel_tol=NEAR)):
            return index
    raise PoundingError(_absent(axis, known, value))


def _absent(axis: str, known: tuple[Any, ...], value: Any) -> str:
    quantity = quantity_of(axis)
    if quantity is None:
        meant = nearest(str(value), known)
        return f"{axis_words(axis)} {value!r} is not in the grid{meant}, which has {listed_values(axis, known)}"
    written = say_level(value, quantity, 10)
    beside = sorted(known, key=lambda level: abs(level - value) if not isinf(level) else inf)[:2]
    close = f" (next to it are {listed_values(axis, sorted(beside))})" if len(known) > FEW else ""
    return f"{axis_words(axis)} {written} is not in the grid, which has {listed_values(axis, known)}{close}"


def listed_values(axis: str, values: Sequence[Any]) -> str:
    """Values of an axis in words: all where they are few, otherwise how many from which to which."""
    quantity = quantity_of(axis)
    words = [str(value) if quantity is None else say_level(value, quantity, 10) for value in values]
    return short_list(words, FEW)


def axis_words(axis: str) -> str:
    """The name of an axis in a sentence."""
    measure = read_measure(axis)
    return axis.replace("_", " ") if measure is None else measure.words
