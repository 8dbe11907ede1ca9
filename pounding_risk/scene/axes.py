"""Axes of [grid] along which any number of a scene varies: "building.frame.period" = ["0.2 s", "0.4 s"].

An address is one of `--set`, and what holds at a place along the axes is the scene with its values set there: nothing
else reads them.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Container, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from math import inf
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.errors import SceneError
from pounding_risk.models.effects import EFFECTS, read_option, written_option
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.keys import Key, Number, Several, Unreadable, list_of, spaced
from pounding_risk.scene.overrides import address_of, override, parts_of
from pounding_risk.scene.scene_axis import NO_UNIT, UNCERTAIN, SceneAxis, labels_of
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import Quantity, parse, shown, si

VARIED = ("building", "interface", "effects")  # sections whose numbers may be axes
ELSEWHERE = {
    "records": (
        "records are read once for all cases; write levels in [records], such as "
        'intensity = {measure = "scale", levels = [0.5, 1.0]}, or run one scene for each'
    ),
    "solver": "all cases have one tolerance; run one scene for each",
}
AXES, ZIP = "axes", "zip"  # the keys of `Grid` that are written in words of their own
RANGE = {"start", "stop", "num"}
ADDRESS = rf"^({'|'.join(VARIED)})\."  # of a key of [grid] that is an axis
_EXAMPLE = '"building.frame.period" = ["0.2 s", "0.4 s"]'
Known = Mapping[str, Mapping[str, Key]]  # the keys of each section


class Placed(NamedTuple):
    """An axis, where it stands in the scene's file, and what it sets in the tables of the scene."""

    path: KeyPath
    axis: SceneAxis
    targets: tuple[KeyPath, ...] = ()


class Address(NamedTuple):
    """The address of a number that varies, and what it stands for."""

    key: str  # the address, in one spelling
    targets: tuple[KeyPath, ...]  # what it sets in the tables of the scene


class Entry(NamedTuple):
    """An axis as [grid] has it."""

    key: str  # its address, in one spelling
    path: KeyPath  # where it stands in the file
    targets: tuple[KeyPath, ...]  # what it sets in the tables of the scene
    values: tuple[Any, ...]  # as a scene file has them, in SI where they are numbers


# ------------------------------------------------------------------------------------------------ reading


def taken_axes(raw: dict[str, Any], outside: Sequence[KeyPath], known: Known) -> tuple[tuple[Placed, ...], list[Fault]]:
    """Take the axes of numbers out of the table [grid]: each with its place in the file; and what is wrong with them.

    An axis whose key was set from ``outside`` is one no more: the key has that value.
    """
    grid = raw.get("grid")
    if not isinstance(grid, dict):
        return (), []
    asked, zipped = _entries(grid, known["grid"]), grid.pop(ZIP, None)
    bare = raw | {"grid": grid}
    entries: list[Entry] = []
    faults: list[Fault] = []
    for path, text, value in asked:
        try:
            entries.append(_entry(path, text, value, bare, known))
        except Several as error:
            faults += [Fault((*path, *below), sentence) for below, sentence in error.faults]
        except ValueError as error:
            faults.append(Fault(path, str(error)))
    faults += _twice(entries)
    groups, wrong = _groups(zipped, [entry.key for entry in entries], bool(faults))
    kept = {entry.key: entry for entry in entries if not set(entry.targets) <= set(outside)}
    partly = [entry for entry in kept.values() if set(entry.targets) & set(outside)]
    faults += [Fault(entry.path, f"--set sets a part of what {entry.key} sets; set all of it") for entry in partly]
    placed: list[Placed] = []
    for group in groups:
        members = [kept[key] for key in group if key in kept]
        if members and len({len(member.values) for member in members}) > 1:
            counts = ", ".join(f"{len(member.values)} of {member.key}" for member in members)
            wrong.append(Fault(("grid", ZIP), f"values that move together are as many as each other, not {counts}"))
        elif members:
            axis = SceneAxis(tuple(m.key for m in members), tuple(m.values for m in members))
            placed.append(Placed(members[0].path, axis, tuple(target for m in members for target in m.targets)))
            wrong += _repeated(members)
    return tuple(placed), faults + wrong


def _entries(grid: dict[str, Any], own: Container[str]) -> list[tuple[KeyPath, str, Any]]:
    """The axes of [grid] as written, taken out of it: where each stands, its address, and its values."""
    found: list[tuple[KeyPath, str, Any]] = []
    nested = grid.pop(AXES, {})
    if not isinstance(nested, dict):
        found.append((("grid", AXES), "", nested))
        nested = {}
    found += [(("grid", AXES, key), key, value) for key, value in nested.items()]
    for key in list(grid):
        first = key.partition(".")[0]
        if key in own and not (first in VARIED and isinstance(grid[key], dict)):
            continue
        if "." in key:
            found.append((("grid", key), key, grid.pop(key)))
        elif isinstance(grid[key], dict) and not RANGE & set(grid[key]):  # building.frame.period = ... unquoted
            found += unquoted(("grid", key), grid.pop(key), RANGE)
    return found


def unquoted(path: KeyPath, value: Any, ends: Set[str]) -> Iterator[tuple[KeyPath, str, Any]]:
    """The values below a key that is written without quotes, building.frame.period; a table with ``ends`` is one."""
    if isinstance(value, dict) and not ends & set(value):
        for key, inner in value.items():
            yield from unquoted((*path, key), inner, ends)
    else:
        yield path, address_of([str(part) for part in path[1:]]), value


def _entry(path: KeyPath, text: str, value: Any, raw: dict[str, Any], known: Known) -> Entry:
    """An axis as [grid] has it, from its address and values; raises Unreadable."""
    if len(parts_of(text)) < 2:
        raise Unreadable(f"{shown(text or value)} is no key of the scene; write for example {_EXAMPLE}")
    address = addressed(text, raw, known, "an axis")
    return Entry(address.key, path, address.targets, _values(value, one_value(address.targets[0], known)))


def addressed(text: str, raw: Mapping[str, Any], known: Known, what: str) -> Address:
    """The address of a number that varies; ``what`` it then is. Raises Unreadable where no number may."""
    parts = parts_of(text)
    section = parts[0]
    if section in ELSEWHERE:
        raise Unreadable(f"no key of [{section}] is {what}: {ELSEWHERE[section]}")
    if section not in VARIED:
        sections = ", ".join(VARIED)
        raise Unreadable(f"there is no such section{nearest(section, VARIED)}; {what} is of one of {sections}")
    key = address_of(parts)
    if "/" in key:
        raise Unreadable('a dataset has no dimension with "/" in its name; write the number: building.1.period')
    scratch = copy.deepcopy({section: raw.get(section, {})})
    if "building" in raw:
        scratch["building"] = copy.deepcopy(raw["building"])
    try:
        targets = override(scratch, f"{key}=0", known, "")
    except SceneError as error:
        raise Unreadable(without_label(error.faults[0], key)) from None
    return Address(key, tuple(targets))


def without_label(sentence: str, key: str) -> str:
    """A sentence of `--set` without the words that name its option."""
    return sentence.removeprefix(f"--set {key}: ")


def _values(value: Any, one: Callable[[Any, Number], Any]) -> tuple[Any, ...]:
    """The values of an axis as a scene file has them, numbers in SI; raises Unreadable."""
    if isinstance(value, dict):
        return _spaced(value, one)
    if not isinstance(value, list):
        raise Unreadable(
            f"{shown(value)} is not a list; write a list of values, or {{start = ..., stop = ..., num = 11}}"
        )
    several = [item for item in list_of(value, _EXAMPLE) if isinstance(item, bool) or not is_single(item)]
    if several:
        raise Unreadable(
            f"{shown(several[0])} is no single value; of a list vary one value by its number from 1, such as "
            '"building.frame.storey_masses.2"'
        )
    return tuple(one(item, parse) for item in value)


def is_single(value: Any) -> bool:
    """True for a number or a text."""
    return isinstance(value, int | float | str)


def _spaced(value: dict[str, Any], one: Callable[[Any, Number], Any]) -> tuple[Any, ...]:
    """``num`` values from start to stop, both included, evenly spaced."""
    ends = [value[end] for end in ("start", "stop") if is_single(value.get(end))]
    labels = labels_of([one(end, parse) for end in ends])
    unit = "" if labels.unit in (None, NO_UNIT) else labels.unit.replace("m/s2", "m/s^2")
    quantity = Quantity(unit or NO_UNIT, -inf, inf, "value")
    return tuple(f"{number!r} {unit}" if unit else number for number in spaced(value, quantity, parse))


def one_value(target: KeyPath, known: Known) -> Callable[[Any, Number], Any]:
    """What brings one value of a key into the form of a resolved scene; what the key cannot take stays as it is."""
    read = reader_of(target, known)

    def one(value: Any, number: Number) -> Any:
        with suppress(ValueError, TypeError, LookupError):
            written = read(value, number)
            return written if is_single(written) and not isinstance(written, bool) else value
        return value

    return one


def reader_of(target: KeyPath, known: Known) -> Callable[[Any, Number], Any]:
    """How one value of a key is read and written."""
    section, inside = str(target[0]), target[2:] if isinstance(target[1], int) else target[1:]
    name, below = (str(inside[0]) if inside else ""), inside[1:]
    if section == "effects":
        allowed = EFFECTS[name].options[str(below[0])] if name in EFFECTS and below else None
        if not isinstance(allowed, Quantity):
            return lambda value, number: value
        return lambda value, number: written_option(read_option(value, allowed, number), allowed)
    key = known[section].get(name)
    if key is not None and not below:
        return lambda value, number: key.write(key.read(value, number))
    if key is not None and isinstance(below[0], int):
        return lambda value, number: key.write(key.read([value], number))[0]
    of_terms = EqualTerms.keys().get(str(below[0])) if name == "equal_terms" else None
    if of_terms is not None:
        return lambda value, number: of_terms.write(of_terms.read(value, number))
    return lambda value, number: value


def _twice(entries: Sequence[Entry]) -> Iterator[Fault]:
    """A fault for each axis that sets what another sets."""
    setters: dict[KeyPath, str] = {}
    for entry in entries:
        for target in entry.targets:
            other = setters.setdefault(target, entry.key)
            if other != entry.key or sum(one.key == entry.key for one in entries) > 1:
                yield Fault(entry.path, f"sets what the axis {other} sets; remove one")
                break


def _repeated(members: Sequence[Entry]) -> Iterator[Fault]:
    """A fault for an axis with one place twice."""
    first: dict[tuple[Any, ...], int] = {}
    for place, values in enumerate(zip(*(member.values for member in members), strict=True)):
        if first.setdefault(values, place) != place:
            stands = f"{', '.join(map(shown, values))} stands twice; remove one"
            yield Fault((*members[0].path, place), stands)


def _groups(zipped: Any, keys: Sequence[str], is_faulty: bool) -> tuple[list[list[str]], list[Fault]]:
    """The keys of each axis, those of `zip` together, in the order of the axes; and what is wrong with `zip`."""
    faults: list[Fault] = []
    example = f'{ZIP} = [["building.frame.mass", "building.frame.period"]]'
    groups: list[list[str]] = []
    if zipped is not None and not isinstance(zipped, list):
        faults.append(Fault(("grid", ZIP), f"{shown(zipped)} is not a list of lists; write {example}"))
        zipped = None
    for at, group in enumerate(zipped or ()):
        if not isinstance(group, list) or len(group) < 2 or not all(isinstance(name, str) for name in group):
            words = f"{shown(group)} is not a list of two axes or more that move together; write {example}"
            faults.append(Fault(("grid", ZIP, at), words))
            continue
        names = [address_of(parts_of(name)) for name in group]
        unknown = [name for name in names if name not in keys]
        others = {name for other in groups for name in other}
        taken = [name for number, name in enumerate(names) if name in names[:number] or name in others]
        if unknown and not is_faulty:
            hint = nearest(unknown[0], keys)
            faults.append(Fault(("grid", ZIP, at), f"{shown(unknown[0])} is no axis of [grid]{hint}; write its values"))
        elif taken:
            faults.append(Fault(("grid", ZIP, at), f"{shown(taken[0])} moves with others already; name it once"))
        else:
            groups.append(names)
    together = {key: group for group in groups for key in group}
    ordered: list[list[str]] = []
    for key in keys:
        group = together.get(key, [key])
        if group not in ordered:
            ordered.append(group)
    return ordered, faults


def axes_in_text(grid: Mapping[str, Any], known: Known) -> dict[str, Any]:
    """The table [grid] that Python gives, with numbers in SI of its axes as text with their unit."""
    written = dict(grid)
    nested = written.pop(AXES, {})
    written |= nested if isinstance(nested, Mapping) else {AXES: nested}
    for key, value in written.items():
        if key in known["grid"] or not isinstance(key, str) or not isinstance(value, Mapping | Sequence):
            continue
        target = likely_target(key, known)
        if not target:
            continue
        one = one_value(target, known)
        if isinstance(value, Mapping):
            written[key] = {end: inner if end == "num" else one(inner, si) for end, inner in value.items()}
        elif not isinstance(value, str):
            written[key] = [one(inner, si) for inner in value]
    return written


def likely_target(address: str, known: Known) -> KeyPath:
    """What an address sets, without the tables of its scene: section and key; nothing where it names no key."""
    parts = parts_of(address)
    names = [part for part in parts[1:] if part in known.get(parts[0], {})] if parts else []
    if not names:
        return ()
    below = [int(part) - 1 if part.isdecimal() else part for part in parts[parts.index(names[0], 1) + 1 :]]
    return (parts[0], names[0], *below)


# ------------------------------------------------------------------------------------------------ places


def written_axes(axes: Sequence[SceneAxis]) -> dict[str, Any]:
    """The axes as [grid] has them; samples of uncertain numbers are none of its."""
    own = [axis for axis in axes if not axis.dimension]
    written: dict[str, Any] = {
        key: list(values) for axis in own for key, values in zip(axis.keys, axis.values, strict=True)
    }
    together = [list(axis.keys) for axis in own if len(axis.keys) > 1]
    return written | ({ZIP: together} if together else {})


def is_axis(key: str, value: Any) -> bool:
    """True for a key of [grid] that is an axis of numbers, or tells of them."""
    own = Grid.model_fields.keys() - {AXES, ZIP}
    return key not in own or (key in VARIED and isinstance(value, Mapping))


def without_axes(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scene without the axes of numbers in [grid], and without uncertain numbers."""
    grid = tables.get("grid", {})
    others = {name: table for name, table in tables.items() if name != UNCERTAIN}
    return {**others, "grid": {key: value for key, value in grid.items() if not is_axis(key, value)}}


def keeping_axes(overrides: Sequence[str]) -> tuple[str, ...]:
    """The overrides that write neither an axis of numbers nor uncertain ones."""
    return tuple(text for text in overrides if not _sets_axis(parts_of(text.partition("=")[0])))


def _sets_axis(parts: Sequence[str]) -> bool:
    if parts[:1] == [UNCERTAIN]:
        return True
    return len(parts) > 1 and parts[0] == "grid" and is_axis(parts[1], {} if len(parts) > 2 else None)
