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


def override(raw: dict[str, Any], text: str, keys_of: Mapping[str, Container[str]], source: str) -> list[KeyPath]:
    """Set what ``text`` (path=value) says in the tables of a scene, and return the paths that were set.

    The path is dotted, as in TOML. In an array of tables the part after its name chooses an element, by its
    ``name`` ("frame | masonry" of an interface) or its number from 1 (left to right); without that part every element
    is meant. In a list of values the part after its name is a number from 1: building.frame.floor_masses.2.
    ``keys_of`` holds the keys of each section. A value that is not TOML is text, since a shell strips the quotes.

    Raises SceneError where the path does not lead anywhere.
    """
    path_parts, setting = _assignment(text, source)
    label = f"--set {'.'.join(path_parts)}"
    if len(path_parts) < 2:
        advice = 'write section.key=value, such as interface.gap="20 mm"'
        raise SceneError(source, [f"{label}: a section is not a value; {advice}"])
    section, *keys = path_parts
    if section not in keys_of:
        advice = f"{nearest(section, keys_of)}; sections are {', '.join(keys_of)}"
        raise SceneError(source, [f'{label}: there is no section "{section}"{advice}'])
    if section in ARRAYS and not raw.get(section):
        raise SceneError(source, [f"{label}: the scene has no [[{section}]] to change"])
    elements = raw.setdefault(section, {})
    paths: list[KeyPath] = [(section,)]
    if isinstance(elements, list):
        choice = _chosen_elements(section, _names(raw, section), keys, keys_of[section])
        if isinstance(choice, str):
            raise SceneError(source, [f"{label}: {choice}"])
        indices, keys = choice
        paths = [(section, index) for index in indices]
    set_paths: list[KeyPath] = []
    for path in paths:
        target = elements[path[1]] if len(path) > 1 else elements
        path_below = _assign(target, keys, setting)
        if isinstance(path_below, str):
            raise SceneError(source, [f"{label}: {path_below}"])
        set_paths.append((*path, *path_below))
    return set_paths


def parts_of(address: str) -> list[str]:
    """The parts of a dotted address, as in TOML or with names that lack their quotes; none if it is no address."""
    if address.count(".") > DEEPEST or "\n" in address:
        return []
    try:
        table = tomllib.loads(f"{address} = 0")
    except ValueError:
        bare_parts = [part.strip() for part in address.split(".")]
        return bare_parts if all(bare_parts) and set(address).isdisjoint("\"'=#") else []
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
    """The names of the elements of an array of tables; of interfaces by their buildings, where each has a table."""
    names = element_names(raw[section])
    buildings = [name or "" for name in element_names(raw.get("building"))]
    interface_names = [f"{left} | {right}" for left, right in pairwise(buildings)]
    return [*interface_names] if section == "interface" and len(interface_names) == len(names) else names


def _chosen_elements(
    section: str, names: list[str | None], keys: list[str], own_keys: Container[str]
) -> tuple[range | list[int], list[str]] | str:
    """Which elements of an array of tables are meant, and the keys below them; or a sentence on the fault."""
    element, *keys_below = keys
    if keys_below and element in names:
        return [index for index, name in enumerate(names) if name == element], keys_below
    if keys_below and element.isdecimal() and 1 <= int(element) <= len(names):
        return [int(element) - 1], keys_below
    if not keys_below or element in own_keys:
        return range(len(names)), keys
    if section == "interface" and " | " in element and len(names) == 1:
        return f'the only [[interface]] is that of all neighbours; write one for each, or leave out "{element}"'
    names_text = [name for name in names if name] or [str(index + 1) for index in range(len(names))]
    return f'there is no {section} "{element}"{nearest(element, names_text)}; it may be {", ".join(names_text)}'


def _assign(target: Any, keys: list[str], setting: Any) -> KeyPath | str:
    """Set a key below a table, or a value of a list by its number from 1; its path, or a sentence on the fault."""
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
        elif isinstance(target, list) and any(isinstance(element, dict) for element in target):
            return f"{shown(target)} is a list of tables; choose one by its number from 1, such as 1.{keys[-1]}"
        else:
            return f"{shown(target)} is not a table, so it has no key {keys[-1]}"
    target[path[-1]] = setting
    return tuple(path)
