"""The key `intensity` of [records]: levels of a measure, to each of which every motion is scaled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.motions.levels import MEASURES, PERIODS, Level, Measure
from pounding_risk.scene.keys import Number, Several, Unreadable, axis, options
from pounding_risk.units import DAMPING, EXAMPLES, PERIOD, exact, shown

EXAMPLE = '{measure = "sa", period = "0.5 s", levels = ["0.1 g", "0.2 g"]}'
_KEYS = {
    "measure": {"enum": list(MEASURES), "description": "What is scaled to the levels; scale is a factor."},
    "levels": {"type": ["array", "object"], "description": "Ascending values with the unit of the measure."},
    "period": {"type": "string", "description": "Period of sa.", "x-example": '"0.5 s"'},
    "periods": {
        "type": "array",
        "items": {"type": "string"},
        "description": "Shortest and longest period of sa_avg.",
        "x-example": '["0.2 s", "2 s"]',
    },
    "damping": {"type": ["number", "string"], "description": "Damping ratio of sa and sa_avg.", "x-absent": "0.05"},
}
SCHEMA = {"type": "object", "properties": _KEYS, "required": ["measure", "levels"], "additionalProperties": False}


def read_levels(value: Any, number: Number) -> tuple[Level, ...]:
    """The levels of a table {measure, period, periods, damping, levels}; all faults of it at once."""
    if isinstance(value, Sequence) and value and all(isinstance(level, Level) for level in value):
        return tuple(value)
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a table; write intensity = {EXAMPLE}")
    name = value.get("measure")
    if not isinstance(name, str) or name not in MEASURES:
        what = "missing" if name is None else f"{shown(name)} is no measure{nearest(str(name), MEASURES)}"
        raise Several([(("measure",), f"{what}; it may be {', '.join(MEASURES)}")])
    quantity, _ = MEASURES[name]
    kinds = {
        "measure": lambda text: str(text),
        "levels": lambda values: axis(quantity, "", "", "").read(values, number),
        "period": lambda text: (number(text, PERIOD),),
        "periods": lambda texts: _ends(texts, number),
        "damping": lambda text: number(text, DAMPING),
    }
    own = {"measure", "levels", *({PERIODS[name], "damping"} if name in PERIODS else ())}
    kinds = {key: reader for key, reader in kinds.items() if key in own}
    examples = {"levels": f'["{EXAMPLES[quantity.unit]}"]', "period": '"0.5 s"', "periods": '["0.2 s", "2 s"]'}
    needed = [key for key in kinds if key not in ("measure", "damping")]
    takes = f"the measure {name} takes {', '.join(kinds)}"
    read = options(value, kinds, needed, lambda key: f"missing; write {key} = {examples[key]}", takes)
    periods = read.get("period") or read.get("periods") or ()
    measure = Measure(name, periods, **({"damping": read["damping"]} if "damping" in read else {}))
    return tuple(Level(measure, level) for level in read["levels"])


def _ends(texts: Any, number: Number) -> tuple[float, float]:
    """Shortest and longest period of a range [s]."""
    if not isinstance(texts, list) or len(texts) != 2:
        raise Unreadable(f'{shown(texts)} is not two periods; write periods = ["0.2 s", "2 s"]')
    low, high = (number(text, PERIOD) for text in texts)
    if not low < high:
        raise Unreadable(f"the range {shown(texts)} is empty; write the shorter period first")
    return low, high


def written_levels(levels: Sequence[Level]) -> dict[str, Any]:
    """The table of levels as a scene file has it."""
    measure = levels[0].measure
    return measure.written() | {"levels": [exact(level.value, measure.quantity) for level in levels]}
