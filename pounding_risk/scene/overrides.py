"""`--set building.frame.mass="50 t"`: a value of a scene changed from outside the file."""

from __future__ import annotations

import tomllib
from collections.abc import Container, Iterable, Mapping
from itertools import pairwise
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.errors import SceneError
from pounding_risk.scene.toml import KeyPath, element_names, toml_key
from pounding_risk.units import shown

ARRAYS = ("building", "interface", "damage")
WITHOUT_RUNS = ("scene", "damage")  # sections that no run reads
DEEPEST = 20  # parts of a path; a quoted name of a building may have dots of its own


def override(raw: dict[str, Any], text: str, known: Mapping[str, Container[str]], source: str) -> list[KeyPath]:
    """Set what ``text`` (path=value) says in the tables of a scene, and return the paths that were set.

    The path is dotted, as in TOML. In an array of tables the part after its name chooses an element, by its
    ``name`` ("frame | masonry" of an interface) or its number from 1 (left to right); without that part every element
    is meant. In a list of values the part after its name is a number from 1: building.frame.floor_masses.2. ``known``
    holds the keys of each section. The value is TOML; what is not TOML is text, since a shell strips the quotes.

    Raises SceneError where the path does not lead anywhere.
    """
    path_parts, setting = _assignment(text, source)
    label = f"--set {'.'.join(path_parts)}"
    if len(path_parts) < 2:
        advice = 'write section.key=value, such as interface.gap="20 mm"'
        raise SceneError(source, [f"{label}: a section is not a value; {advice}"])
    section, *keys = path_parts
    if section not in known:
        advice = f"{nearest(section, known)}; sections are {', '.join(known)}"
        raise SceneError(source, [f'{label}: there is no section "{section}"{advice}'])
    if section in ARRAYS and not raw.get(section):
        raise SceneError(source, [f"{label}: the scene has no [[{section}]] to change"])
    elements = raw.setdefault(section, {})
    paths: list[KeyPath] = [(section,)]
    if isinstance(elements, list):
        chosen = _chosen(section, _names(raw, section), keys, known[section])
        if isinstance(chosen, str):
            raise SceneError(source, [f"{label}: {chosen}"])
        indices, keys = chosen
        paths = [(section, index) for index in indices]
    set_paths: list[KeyPath] = []
    for path in paths:
        target = elements[path[1]] if len(path) > 1 else elements
        below = _assign(target, keys, setting)
        if isinstance(below, str):
            raise SceneError(source, [f"{label}: {below}"])
        set_paths.append((*path, *below))
    return set_paths


def parts_of(address: str) -> list[str]:
    """The parts of a dotted address, as in TOML or with names that lack their quotes; none of a text that is none."""
    if address.count(".") > DEEPEST or "\n" in address:
        return []
    try:
        table = tomllib.loads(f"{address} = 0")
    except ValueError:
        unquoted = [part.strip() for part in address.split(".")]
        return unquoted if all(unquoted) and set(address).isdisjoint("\"'=#") else []
    parts = []
    while isinstance(table, dict) and len(table) == 1:
        ((part, table),) = table.items()
        parts.append(part)
    return parts


def address_of(parts: Iterable[str]) -> str:
    """The dotted address of these parts: the one spelling of it."""
    return ".".join(map(toml_key, parts))


def _assignment(text: str, source: str) -> tuple[list[str], Any]:
    """Split an override `path=value` into the path of the key and the text of the value."""
    left, equals, right = text.partition("=")
    if left.count(".") > DEEPEST:
        sentence = f"the path has {left.count('.') + 1} parts, and no key of a scene more than {DEEPEST}"
        raise SceneError(source, [f"--set {shown(text)}: {sentence}"])
    parts = parts_of(left) if equals else []
    if not parts:
        advice = 'write for example --set interface.gap="20 mm"'
        raise SceneError(source, [f"--set {shown(text)} is not path=value; {advice}"])
    try:
        return parts, tomllib.loads(f"value = {right}")["value"]
    except (ValueError, RecursionError):
        return parts, right.strip()


def _names(raw: Mapping[str, Any], section: str) -> list[str | None]:
    """How the elements of an array of tables may be called; an interface by its buildings, where each has its own."""
    names = element_names(raw[section])
    buildings = [name or "" for name in element_names(raw.get("building"))]
    between = [f"{left} | {right}" for left, right in pairwise(buildings)]
    return [*between] if section == "interface" and len(between) == len(names) else names


def _chosen(
    section: str, names: list[str | None], keys: list[str], known: Container[str]
) -> tuple[range | list[int], list[str]] | str:
    """Which elements of an array of tables are meant, and the keys below them; or what is wrong."""
    first, *below = keys
    if below and first in names:
        return [index for index, name in enumerate(names) if name == first], below
    if below and first.isdecimal() and 1 <= int(first) <= len(names):
        return [int(first) - 1], below
    if not below or first in known:
        return range(len(names)), keys
    if section == "interface" and " | " in first and len(names) == 1:
        return f'the only [[interface]] is that of all neighbours; write one for each, or leave out "{first}"'
    called = [name for name in names if name] or [str(index + 1) for index in range(len(names))]
    return f'there is no {section} "{first}"{nearest(first, called)}; it may be {", ".join(called)}'


def _assign(target: Any, keys: list[str], setting: Any) -> KeyPath | str:
    """Set a key below a table, or a value of a list by its number from 1: where it is; or what is wrong."""
    path: list[str | int] = []
    for key in keys:
        if path:
            target = target.setdefault(path[-1], {}) if isinstance(target, dict) else target[path[-1]]
        if isinstance(target, list) and key.isdecimal() and 1 <= int(key) <= len(target):
            path.append(int(key) - 1)
        elif isinstance(target, dict):
            path.append(key)
        elif isinstance(target, list) and key.isdecimal():
            return f"{shown(target)} has no value {key}; its {len(target)} values count from 1"
        elif isinstance(target, list) and any(isinstance(one, dict) for one in target):
            return f"{shown(target)} is a list of tables; choose one by its number from 1, such as 1.{keys[-1]}"
        else:
            return f"{shown(target)} is not a table, so it has no key {keys[-1]}"
    target[path[-1]] = setting
    return tuple(path)
