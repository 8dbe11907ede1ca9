"""Changes of a scene by `--set`, value by value, with the values that follow from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import Any

from pounding_risk.scene.scene import Scene
from pounding_risk.units import Quantity, say

NOWHERE = "not given"
FEW = 6  # values of a list that are shown one by one
OF_MOTIONS = ("records.unit", "records.dt", "records.window", "records.processing")  # act on motions and nothing else


def changes(before: Scene, after: Scene) -> tuple[str, ...]:
    """A line for each value that differs, such as "interface.gap: 10 mm -> 20 mm", with the names of `--set`.

    Defaults are filled in on both sides, so that values that follow from a changed one are listed too.
    """
    old, new = dict(flat(before.resolved())), dict(flat(after.resolved()))
    keys = dict.fromkeys([*old, *new])
    lines = []
    for key in keys:
        settings = [old.get(key, NOWHERE), new.get(key, NOWHERE)]
        words = [_setting_words(setting, _rounded) for setting in settings]
        if settings[0] != settings[1]:  # with all digits where they would read alike
            words = words if words[0] != words[1] else [_setting_words(setting, str) for setting in settings]
            lines.append(f"{key}: {' -> '.join(words)}")
    return tuple(lines)


def marked_as_idle(changes: tuple[str, ...]) -> tuple[str, ...]:
    """The lines of `changes` for equal motions: keys that act on motions alone are marked as without effect."""
    idle = " (without effect: every motion stays the same)"
    return tuple(f"{line}{idle}" if line.startswith(OF_MOTIONS) else line for line in changes)


def flat(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of nested tables by its dotted name; a table of several by its ``name``, or its number from 1.

    These are the names that ``--set`` takes. `identity.flattened` numbers the tables instead, so that equal names
    cannot hide a difference.
    """
    for key, setting in tables.items():
        path = f"{prefix}{key}"
        if isinstance(setting, Mapping):
            yield from flat(setting, f"{path}.")
        elif isinstance(setting, list) and setting and isinstance(setting[0], Mapping):
            for number, table in enumerate(setting, start=1):
                name = table.get("name", number)
                yield from flat(table, f"{path}." if len(setting) == 1 else f"{path}.{name}.")
        else:
            yield path, setting


def _setting_words(setting: Any, text: Callable[[str], str]) -> str:
    """A value without quotes; of a long list the length, the first and the last value."""
    if isinstance(setting, str):
        return text(setting)
    if isinstance(setting, list):
        words = [_setting_words(element, text) for element in setting]
        return ", ".join(words) if len(words) <= FEW else f"{len(words)} values from {words[0]} to {words[-1]}"
    return str(setting)


def _rounded(text: str) -> str:
    """A quantity in SI, as in `Scene.resolved`, rounded and in a convenient unit."""
    number, _, unit = text.partition(" ")
    try:
        return say(float(number), Quantity(unit, -inf, inf, "")) if unit else text
    except ValueError:
        return text
