"""What `--set` changes in a scene, value by value, after everything that follows from it is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import Any

from pounding_risk.scene.scene import Study
from pounding_risk.units import Quantity, say

NOWHERE = "not given"
FEW = 6  # values that are all told
OF_MOTIONS = ("records.unit", "records.dt", "records.window", "records.processing")  # act on motions and nothing else


def changes(before: Study, after: Study) -> tuple[str, ...]:
    """One line a value that differs, such as "interface.gap: 10 mm -> 20 mm", under the name that `--set` has for it.

    Both scenes have every default filled in, so that what follows from a changed value is told as well.
    """
    old, new = dict(flat(before.resolved())), dict(flat(after.resolved()))
    keys = dict.fromkeys([*old, *new])
    pairs = ((key, old.get(key, NOWHERE), new.get(key, NOWHERE)) for key in keys)
    return tuple(f"{key}: {_from_to(was, now)}" for key, was, now in pairs if was != now)


def told_as_idle(changes: tuple[str, ...]) -> tuple[str, ...]:
    """The lines of `changes` where all motions stay the same, to the last bit: what acts on motions alone is idle."""
    return tuple(
        f"{line} (without effect: every motion stays the same)" if line.startswith(OF_MOTIONS) else line
        for line in changes
    )


def flat(tables: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of nested tables by its dotted name; a table of several by its ``name``, or its number from 1.

    These are the names that ``--set`` takes. `identity.flattened` counts tables instead, as no name can hide a
    difference there, and tells values to the last digit, since two studies are kept apart by it.
    """
    for key, value in tables.items():
        path = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from flat(value, f"{path}.")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for number, table in enumerate(value, start=1):
                called = table.get("name", number)
                yield from flat(table, f"{path}." if len(value) == 1 else f"{path}.{called}.")
        else:
            yield path, value


def _from_to(was: Any, now: Any) -> str:
    """Both values as an engineer writes them; to the last digit where they would read alike."""
    short = [_told(value, _rounded) for value in (was, now)]
    return " -> ".join(short if short[0] != short[1] else [_told(value, str) for value in (was, now)])


def _told(value: Any, text: Callable[[str], str]) -> str:
    """A value without the quotes of a scene file; of many values how many, the first and the last."""
    if isinstance(value, str):
        return text(value)
    if isinstance(value, list):
        told = [_told(each, text) for each in value]
        return ", ".join(told) if len(told) <= FEW else f"{len(told)} values from {told[0]} to {told[-1]}"
    return str(value)


def _rounded(text: str) -> str:
    """A quantity in SI, as `Study.resolved` has it, in the unit and with the digits that one would say."""
    number, _, unit = text.partition(" ")
    try:
        return say(float(number), Quantity(unit, -inf, inf, "")) if unit else text
    except ValueError:
        return text
