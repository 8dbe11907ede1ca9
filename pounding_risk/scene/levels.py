"""The key `intensity` of [records]: levels of a measure, to each of which every motion is scaled."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.motions.levels import MEASURES, PERIODS, Level, Measure
from pounding_risk.scene.keys import Number, Several, Unreadable, axis, options
from pounding_risk.units import DAMPING, EXAMPLES, PERIOD, Quantity, exact, parse, shown

EXAMPLE = '{measure = "sa", period = "0.5 s", levels = ["0.1 g", "0.2 g"]}'
SHARE = Quantity("1", 0.0, 100.0, "period over that of a building", open_low=True, example="0.2")
_KEYS = {
    "measure": {"enum": list(MEASURES), "description": "What is scaled to the levels; scale is a factor."},
    "levels": {"type": ["array", "object"], "description": "Ascending values with the unit of the measure."},
    "period": {"type": "string", "description": "Period of sa; or relative, such as 1 T.", "x-example": '"0.5 s"'},
    "periods": {
        "type": "array",
        "items": {"type": "string"},
        "description": "Shortest and longest period of sa_avg; or relative, such as 0.2 T and 1.5 T.",
        "x-example": '["0.2 s", "2 s"]',
    },
    "of": {
        "type": "string",
        "description": "The building whose first period T is, where periods are relative.",
        "x-example": '"frame"',
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
        flaw = "missing" if name is None else f"{shown(name)} is no measure{nearest(str(name), MEASURES)}"
        raise Several([(("measure",), f"{flaw}; it may be {', '.join(MEASURES)}")])
    quantity, _ = MEASURES[name]

    def building(text: Any) -> str:  # its name, which may be written as an address, "building.frame"
        if not isinstance(text, str) or not text.strip():
            raise Unreadable(f'{shown(text)} is no name of a building; write of = "NAME"')
        return text.removeprefix("building.")

    kinds = {
        "measure": lambda text: str(text),
        "levels": lambda values: axis(quantity, "", "", "").read(values, number),
        "period": lambda text: _periods([text], number),
        "periods": lambda texts: _period_range(texts, number),
        "damping": lambda text: number(text, DAMPING),
        "of": building,
    }
    keys_of_measure = {"measure", "levels", *({PERIODS[name], "damping", "of"} if name in PERIODS else ())}
    kinds = {key: reader for key, reader in kinds.items() if key in keys_of_measure}
    examples = {"levels": f'["{EXAMPLES[quantity.unit]}"]', "period": '"0.5 s"', "periods": '["0.2 s", "2 s"]'}
    needed = [key for key in kinds if key not in ("measure", "damping", "of")]
    takes = f"the measure {name} takes {', '.join(kinds)}"
    settings = options(value, kinds, needed, lambda key: f"missing; write {key} = {examples[key]}", takes)
    periods, is_relative = settings.get("period") or settings.get("periods") or ((), False)
    if is_relative and "of" not in settings:
        raise Several([(("of",), 'missing; write of = "NAME", the building whose first period T is')])
    if "of" in settings and not is_relative:
        example = '"1 T"' if name == "sa" else '["0.2 T", "1.5 T"]'
        raise Several([(("of",), f"no period is relative to a building's; write {PERIODS[name]} = {example}")])
    setting = {"shares": periods, "building": settings["of"]} if is_relative else {"periods": periods}
    measure = Measure(name, **setting, **({"damping": settings["damping"]} if "damping" in settings else {}))
    return tuple(Level(measure, level) for level in settings["levels"])


def _periods(texts: Sequence[Any], number: Number) -> tuple[tuple[float, ...], bool]:
    """Periods [s], or their ratios to the first period of a building, such as "0.2 T", and which of the two."""
    matches = [re.fullmatch(r"\s*(\S+?)\s*T\s*", text) if isinstance(text, str) else None for text in texts]
    if not any(matches):
        return tuple(number(text, PERIOD) for text in texts), False
    if not all(matches):
        raise Unreadable(f"{shown(list(texts))} mixes a period in s and a relative one; write both in s, or both in T")
    return tuple(parse(match[1], SHARE) for match in matches if match is not None), True


def relative_faults(levels: Sequence[Level], buildings: Sequence[Any]) -> Iterator[str]:
    """Why the relative periods of levels belong to no building of a scene."""
    name = levels[0].measure.building if levels else ""
    names = [building.name for building in buildings]
    if name and name not in names:
        yield f"{shown(name)} is no building of the scene{nearest(name, names)}; it has {', '.join(names)}"
    elif name and buildings[names.index(name)].is_rigid:
        yield f"{name} is rigid and has no period; name a building that vibrates, or write the periods in s"


def at_periods(levels: Sequence[Level], buildings: Sequence[Any]) -> tuple[Level, ...]:
    """The levels with their relative periods at the first period of their building, as it is without contact.

    That of an isolated one is its period while the isolators yield.
    """
    building = next((one for one in buildings if levels and one.name == levels[0].measure.building), None)
    period = None if building is None else getattr(building, "isolated_period", building.period)
    return tuple(one if period is None else Level(one.measure.at_period(period), one.value) for one in levels)


def _period_range(texts: Any, number: Number) -> tuple[tuple[float, ...], bool]:
    """Shortest and longest period of a range [s], and whether they are relative to a building's instead."""
    if not isinstance(texts, list) or len(texts) != 2:
        raise Unreadable(f'{shown(texts)} is not two periods; write periods = ["0.2 s", "2 s"]')
    (low, high), is_relative = _periods(texts, number)
    if not low < high:
        raise Unreadable(f"the range {shown(texts)} is empty; write the shorter period first")
    return (low, high), is_relative


def written_levels(levels: Sequence[Level]) -> dict[str, Any]:
    """The table of levels as a scene file has it."""
    measure = levels[0].measure
    return measure.written() | {"levels": [exact(level.value, measure.quantity) for level in levels]}
