"""What the options of effects are where a scene leaves them out: read from the effects themselves."""

from __future__ import annotations

import inspect
from math import isnan
from typing import Any

from pounding_risk.models.effects import EFFECTS
from pounding_risk.units import Quantity, exact, say

NOT_A_NUMBER = {  # options whose default follows from something else
    ("strain_rate", "strength"): "none (code mc1990 needs one)",
    ("soil_flexibility", "foundation_mass"): "the mass of the lowest floor",
}


def defaults(effect: str) -> dict[str, Any]:
    """The optional options of an effect that have a default of their own: a number in SI, or a word."""
    kind: Any = EFFECTS[effect]
    parameters = inspect.signature(kind.on).parameters
    found = {key: parameters[key].default for key in kind.optional}
    return {key: value for key, value in found.items() if isinstance(value, str) or not isnan(value)}


def default_words(effect: str, option: str) -> str:
    """The default of an option as a table tells it; "required" where there is none."""
    kind: Any = EFFECTS[effect]
    if option not in kind.optional:
        return "required"
    if (effect, option) in NOT_A_NUMBER:
        return NOT_A_NUMBER[effect, option]
    return option_words(kind.options[option], defaults(effect)[option])


def option_words(allowed: Quantity | tuple[str, ...], value: Any) -> str:
    """The value of an option as one reads it."""
    return say(value, allowed) if isinstance(allowed, Quantity) else str(value)


def default_example(effect: str, option: str) -> str:
    """The default as a scene file has it; in words where it has none of its own."""
    kind: Any = EFFECTS[effect]
    allowed, known = kind.options[option], defaults(effect)
    if option not in known:
        return default_words(effect, option)
    told = exact(known[option], allowed) if isinstance(allowed, Quantity) else known[option]
    return f'"{told}"' if isinstance(told, str) else f"{told:.6g}"
