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
from pounding_risk.scene.building_tables import HysteresisTable, Isolation, PlanTable
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.keys import Key, Number, Table, Unreadable, list_of, located, spaced
from pounding_risk.scene.overrides import address_of, override, parts_of
from pounding_risk.scene.scene_axis import NO_UNIT, UNCERTAIN, SceneAxis, alone, has_gap, labels_of
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.scene.values import SceneValues
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
# Keys that are tables, whose numbers may be axes.
INLINE: Mapping[str, type[Table]] = {
    "equal_terms": EqualTerms,
    "isolation": Isolation,
    "plan": PlanTable,
    "hysteresis": HysteresisTable,
}
_EXAMPLE = '"building.frame.period" = ["0.2 s", "0.4 s"]'
Known = Mapping[str, Mapping[str, Key]]  # the keys of each section
Written = tuple[KeyPath, str, Any]  # where a number stands in the file, its address and what is written for it


class Placed(NamedTuple):
    """An axis, where it stands in the scene's file, and what it sets in the tables of the scene."""

    path: KeyPath
    axis: SceneAxis
    targets: tuple[KeyPath, ...] = ()


class Entry(NamedTuple):
    """The values of one address, as [grid] has them."""

    key: str  # its address, in one spelling
    path: KeyPath  # where it stands in the file
    targets: tuple[KeyPath, ...]  # what it sets in the tables of the scene
    values: tuple[Any, ...]  # as a scene file has them, in SI where they are numbers


# ------------------------------------------------------------------------------------------------ addresses


def taken_addresses(
    section: str, table: dict[str, Any], nested: str, own_keys: Container[str], value_keys: Set[str]
) -> list[Written]:
    """Take the entries under addresses out of a table of a scene file; its ``own_keys`` stay.

    An address stands in quotes, without quotes as nested tables, or in the table ``nested``, as Python gives it. A
    table with any of ``value_keys`` is a value.
    """
    nested_table = table.pop(nested, {})
    written: list[Written] = []
    if isinstance(nested_table, dict):
        written += [((section, nested, key), key, value) for key, value in nested_table.items()]
    else:
        written.append(((section, nested), "", nested_table))
    for key in list(table):
        value = table[key]
        if key in own_keys and not (key in VARIED and isinstance(value, dict)):
            continue
        if "." in key or (section == UNCERTAIN and isinstance(value, dict) and value_keys & set(value)):
            written.append(((section, key), key, table.pop(key)))
        elif isinstance(value, dict) and not value_keys & set(value):  # building.frame.period = ... without quotes
            written += _unquoted((section, key), table.pop(key), value_keys)
    return written


def _unquoted(path: KeyPath, value: Any, value_keys: Set[str]) -> Iterator[Written]:
    if isinstance(value, dict) and not value_keys & set(value):
        for key, inner_value in value.items():
            yield from _unquoted((*path, key), inner_value, value_keys)
    else:
        yield path, address_of([str(part) for part in path[1:]]), value


def addressed(
    text: str, value: Any, raw: Mapping[str, Any], keys: Known, noun: str, example: str
) -> tuple[str, tuple[KeyPath, ...]]:
    """The address of a number that varies, in one spelling, and the paths that it sets in the tables of the scene.

    ``noun`` and ``example`` are for sentences, such as "an axis". Raises Unreadable where no number may stand.
    """
    path = parts_of(text)
    if len(path) < 2:
        raise Unreadable(f"{shown(text or value)} is no key of the scene; write for example {example}")
    section = path[0]
    if section in ELSEWHERE:
        raise Unreadable(f"no key of [{section}] is {noun}: {ELSEWHERE[section]}")
    if section not in VARIED:
        sections = ", ".join(VARIED)
        raise Unreadable(f"there is no such section{nearest(section, VARIED)}; {noun} is of one of {sections}")
    key = address_of(path)
    if "/" in key:
        raise Unreadable('a dataset has no dimension with "/" in its name; write the number: building.1.period')
    scratch = copy.deepcopy({section: raw.get(section, {})})
    if "building" in raw:
        scratch["building"] = copy.deepcopy(raw["building"])
    try:
        return key, tuple(override(scratch, f"{key}=0", keys, ""))
    except SceneError as error:
        raise Unreadable(error.faults[0].removeprefix(f"--set {'.'.join(path)}: ")) from None


def likely_target(address: str, keys: Known) -> KeyPath:
    """The section and key that an address sets, without the tables of its scene; nothing where it names no key."""
    path = parts_of(address)
    key_names = [part for part in path[1:] if part in keys.get(path[0], {})] if path else []
    if not key_names:
        return ()
    path_below = [int(part) - 1 if part.isdecimal() else part for part in path[path.index(key_names[0], 1) + 1 :]]
    return (path[0], key_names[0], *path_below)


def reader_of(target: KeyPath, keys: Known) -> Callable[[Any, Number], Any]:
    """The function that reads one value of a key and writes it back."""
    section, path_inside = str(target[0]), target[2:] if isinstance(target[1], int) else target[1:]
    name, path_below = (str(path_inside[0]) if path_inside else ""), path_inside[1:]
    if section == "effects":
        option = EFFECTS[name].options[str(path_below[0])] if name in EFFECTS and path_below else None
        if not isinstance(option, Quantity):
            return lambda value, number: value
        return lambda value, number: written_option(read_option(value, option, number), option)
    key = keys[section].get(name)
    if key is not None and not path_below:
        return lambda value, number: key.write(key.read(value, number))
    inner_key = INLINE[name].keys().get(str(path_below[-1])) if name in INLINE else None
    if inner_key is not None:  # of a list of tables too: building.A.plan.2.eccentricity
        return lambda value, number: inner_key.write(inner_key.read(value, number))
    if key is not None and isinstance(path_below[0], int):
        return lambda value, number: key.write(key.read([value], number))[0]
    return lambda value, number: value


def one_value(target: KeyPath, keys: Known) -> Callable[[Any, Number], Any]:
    """The function that writes one value of a key as a resolved scene has it; a value that the key refuses stays."""
    read = reader_of(target, keys)

    def resolved(value: Any, number: Number) -> Any:
        with suppress(ValueError, TypeError, LookupError):
            written = read(value, number)
            return written if is_single(written) else value
        return value

    return resolved


def is_single(value: Any) -> bool:
    """True for a number or a text."""
    return isinstance(value, int | float | str) and not isinstance(value, bool)


# ------------------------------------------------------------------------------------------------ reading


def taken_axes(
    raw: dict[str, Any], set_paths: Sequence[KeyPath], keys: Known
) -> tuple[tuple[Placed, ...], list[Fault]]:
    """Take the axes of numbers out of the table [grid]: each with its place in the file; and their faults.

    An axis whose key is one of ``set_paths``, set by an override, is no axis: the key has that value.
    """
    grid = raw.get("grid")
    if not isinstance(grid, dict):
        return (), []
    items, zip_value = taken_addresses("grid", grid, AXES, keys["grid"], RANGE), grid.pop(ZIP, None)
    entries: list[Entry] = []
    faults: list[Fault] = []
    for path, text, value in items:
        try:
            key, targets = addressed(text, value, raw, keys, "an axis", _EXAMPLE)
            entries.append(Entry(key, path, targets, _values(value, one_value(targets[0], keys))))
        except ValueError as error:
            faults += [Fault(*fault) for fault in located(error, *path)]
    faults += _repeated_target_faults(entries)
    groups, flaws = _zipped_groups(zip_value, [entry.key for entry in entries], bool(faults))
    by_key = {entry.key: entry for entry in entries if not set(entry.targets) <= set(set_paths)}
    clashes = [entry for entry in by_key.values() if set(entry.targets) & set(set_paths)]
    faults += [Fault(entry.path, f"--set sets a part of what {entry.key} sets; set all of it") for entry in clashes]
    axes: list[Placed] = []
    for group in groups:
        members = [by_key[key] for key in group if key in by_key]
        if members and len({len(member.values) for member in members}) > 1:
            counts = ", ".join(f"{len(member.values)} of {member.key}" for member in members)
            flaws.append(Fault(("grid", ZIP), f"values that move together are as many as each other, not {counts}"))
        elif members:
            axis = SceneAxis(tuple(m.key for m in members), tuple(m.values for m in members))
            axes.append(Placed(members[0].path, axis, tuple(target for m in members for target in m.targets)))
            first: dict[tuple[Any, ...], int] = {}
            for index, labels in enumerate(zip(*axis.values, strict=True)):
                if first.setdefault(labels, index) != index:
                    sentence = f"{', '.join(map(shown, labels))} stands twice; remove one"
                    flaws.append(Fault((*members[0].path, index), sentence))
    return tuple(axes), faults + flaws


def _values(value: Any, to_text: Callable[[Any, Number], Any]) -> tuple[Any, ...]:
    """The values of an axis as a scene file has them, numbers in SI; raises Unreadable."""
    if isinstance(value, dict):  # evenly spaced from start to stop
        end_values = [value[end] for end in ("start", "stop") if isinstance(value.get(end), int | float | str)]
        labels = labels_of([to_text(end, parse) for end in end_values])
        unit = "" if labels.unit in (None, NO_UNIT) else labels.unit.replace("m/s2", "m/s^2")
        quantity = Quantity(unit or NO_UNIT, -inf, inf, "value")
        return tuple(f"{number!r} {unit}" if unit else number for number in spaced(value, quantity, parse))
    if not isinstance(value, list):
        raise Unreadable(
            f"{shown(value)} is not a list; write a list of values, or {{start = ..., stop = ..., num = 11}}"
        )
    list_elements = [element for element in list_of(value, _EXAMPLE) if not is_single(element)]
    if list_elements:
        raise Unreadable(
            f"{shown(list_elements[0])} is no single value; of a list vary one value by its number from 1, such as "
            '"building.frame.storey_masses.2"'
        )
    return tuple(to_text(element, parse) for element in value)


def _repeated_target_faults(axes: Sequence[Entry]) -> Iterator[Fault]:
    """A fault for each axis that sets what another sets."""
    setters: dict[KeyPath, str] = {}
    for axis in axes:
        for target in axis.targets:
            other_key = setters.setdefault(target, axis.key)
            if other_key != axis.key or sum(other_axis.key == axis.key for other_axis in axes) > 1:
                yield Fault(axis.path, f"sets what the axis {other_key} sets; remove one")
                break


def _zipped_groups(value: Any, keys: Sequence[str], is_faulty: bool) -> tuple[list[list[str]], list[Fault]]:
    """The keys of each axis, those of `zip` together, in the order of the axes; and the faults of `zip`."""
    faults: list[Fault] = []
    example = f'{ZIP} = [["building.frame.mass", "building.frame.period"]]'
    groups: list[list[str]] = []
    if value is not None and not isinstance(value, list):
        faults.append(Fault(("grid", ZIP), f"{shown(value)} is not a list of lists; write {example}"))
        value = None
    for index, group in enumerate(value or ()):
        if not isinstance(group, list) or len(group) < 2 or not all(isinstance(name, str) for name in group):
            words = f"{shown(group)} is not a list of two axes or more that move together; write {example}"
            faults.append(Fault(("grid", ZIP, index), words))
            continue
        names = [address_of(parts_of(name)) for name in group]
        unknown = [name for name in names if name not in keys]
        grouped = {name for members in groups for name in members}
        repeats = [name for number, name in enumerate(names) if name in names[:number] or name in grouped]
        if unknown and not is_faulty:
            hint = nearest(unknown[0], keys)
            faults.append(
                Fault(("grid", ZIP, index), f"{shown(unknown[0])} is no axis of [grid]{hint}; write its values")
            )
        elif repeats:
            faults.append(Fault(("grid", ZIP, index), f"{shown(repeats[0])} moves with others already; name it once"))
        else:
            groups.append(names)
    by_key = {key: group for group in groups for key in group}
    ordered: list[list[str]] = []
    for key in keys:
        group = by_key.get(key, [key])
        if group not in ordered:
            ordered.append(group)
    return ordered, faults


def axes_in_text(grid: Mapping[str, Any], keys: Known) -> dict[str, Any]:
    """The table [grid] that Python gives, with numbers in SI of its axes as text with their unit."""
    table = dict(grid)
    axes = table.pop(AXES, {})
    table |= axes if isinstance(axes, Mapping) else {AXES: axes}
    for key, value in table.items():
        if key in keys["grid"] or not isinstance(key, str) or not isinstance(value, Mapping | Sequence):
            continue
        target = likely_target(key, keys)
        if not target:
            continue
        to_text = one_value(target, keys)
        if isinstance(value, Mapping):
            table[key] = {end: item if end == "num" else to_text(item, si) for end, item in value.items()}
        elif not isinstance(value, str):
            table[key] = [to_text(item, si) for item in value]
    return table


# ------------------------------------------------------------------------------------------------ writing


def written_axes(axes: Sequence[SceneAxis]) -> dict[str, Any]:
    """The axes as [grid] has them; samples of uncertain numbers are none of its."""
    number_axes = [axis for axis in axes if not axis.dimension]
    grid_table: dict[str, Any] = {
        key: list(labels) for axis in number_axes for key, labels in zip(axis.keys, axis.values, strict=True)
    }
    zipped_keys = [list(axis.keys) for axis in number_axes if len(axis.keys) > 1]
    return grid_table | ({ZIP: zipped_keys} if zipped_keys else {})


def _is_axis(key: str, stated_value: Any) -> bool:
    """True for a key of [grid] that is an axis of numbers, or `zip`, which says which of them move together."""
    return key not in (Grid.model_fields.keys() - {AXES, ZIP}) or (key in VARIED and isinstance(stated_value, Mapping))


def without_axes(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scene without the axes of numbers in [grid], and without uncertain numbers."""
    grid = tables.get("grid", {})
    other_tables = {name: table for name, table in tables.items() if name != UNCERTAIN}
    return {**other_tables, "grid": {key: value for key, value in grid.items() if not _is_axis(key, value)}}


def keeping_axes(overrides: Sequence[str]) -> tuple[str, ...]:
    """The overrides that write neither an axis of numbers nor uncertain ones."""

    def sets_axis(path: Sequence[str]) -> bool:
        if path[:1] == [UNCERTAIN]:
            return True
        return len(path) > 1 and path[0] == "grid" and _is_axis(path[1], {} if len(path) > 2 else None)

    return tuple(text for text in overrides if not sets_axis(parts_of(text.partition("=")[0])))


# ------------------------------------------------------------------------------------------------ checks

OF_PERIODS = "the periods that the levels of intensity are of, which are relative to a building's"
OF_GAPS = ("the gaps of the grid", "the interface whose gap varies")  # these follow from a gap that is drawn
IN_GRID = {
    OF_GAPS[0]: "write gap = [...] in [grid] instead",
    OF_GAPS[1]: "write gap = [...] in [grid] instead",
    "the yield forces of the grid": "write yield_force = [...] in [grid] instead",
    "the contact models of the grid": "write contact_model = [...] in [grid] instead",
    OF_PERIODS: "motions are scaled once for all cases: write them in s, or run one scene for each",
}
# What all scenes of one grid have in common.
COMMON: dict[str, Callable[[SceneValues], Any]] = {
    OF_GAPS[0]: lambda scene: scene.grid.gaps,
    "the yield forces of the grid": lambda scene: scene.grid.yield_forces,
    "the contact models of the grid": lambda scene: (scene.grid.contact_models, scene.model_names),
    "the names of the buildings": lambda scene: [building.name for building in scene.buildings],
    "which buildings are rigid, or have how many storeys": lambda scene: [
        (building.is_rigid, len(getattr(building, "masses", (0,)))) for building in scene.buildings
    ],
    # Read once, beside the records of the scene.
    "the records of their own that buildings stand on": lambda scene: [
        building.support.records for building in scene.buildings
    ],
    "which floors meet": lambda scene: [
        (point.interface, point.kind, point.left_floor, point.right_floor) for point in scene.points
    ],
    OF_GAPS[1]: lambda scene: scene.gridded_interface,
    OF_PERIODS: lambda scene: scene.grid.measure,
    "the effects": lambda scene: [effect.name for effect in scene.effects],
    "the solver": lambda scene: scene.is_row,
}


def unlike(study: SceneValues, other: SceneValues) -> Iterator[tuple[str, str]]:
    """The facts that all scenes of one grid must share and in which these two differ, each with the repair."""
    draws_gap = study.uncertain is not None and has_gap(study.uncertain.keys)
    changed_facts = [fact for fact, of_scene in COMMON.items() if of_scene(study) != of_scene(other)]
    silent_facts: tuple[str, ...] = ()
    if draws_gap:
        silent_facts = OF_GAPS
    elif OF_GAPS[0] in changed_facts:  # one repair serves both facts on gaps
        silent_facts = OF_GAPS[1:]
    for fact in (fact for fact in changed_facts if fact not in silent_facts):
        repair = IN_GRID.get(fact, "run one scene for each")
        if fact in OF_GAPS and len(names := _changed_gaps(study, other)) == 1 < len(study.interfaces):
            repair += f", with interface = {shown(*names)} beside it"
        yield fact, repair


def _changed_gaps(study: SceneValues, other: SceneValues) -> list[str]:
    """The names of the interfaces whose own gaps differ."""
    pairs = zip(study.interface_names, study.interfaces, other.interfaces, strict=True)
    return [name for name, interface, other_interface in pairs if interface.gap != other_interface.gap]


def axis_faults(
    study: SceneValues, placed: Sequence[Placed], make: Callable[[Sequence[str]], SceneValues]
) -> Iterator[Fault]:
    """A fault for each value along an axis that the scene cannot have; ``make`` gives the scene with values set."""
    paths = {item.axis.name: item.path for item in placed}
    for axis, place, overrides in alone([item.axis for item in placed]):
        path = paths[axis.name]
        label = ", ".join(shown(labels[place]) for labels in axis.values)
        head = label
        if axis.dimension:
            head = f"sample {place} ({', '.join(text.replace('=', ' = ', 1) for text in overrides)})"
        try:
            variant = make(overrides)
        except SceneError as error:
            for fault in error.faults:
                sentence = (
                    fault if axis.dimension else fault.removeprefix(f"--set {axis.name}: ").removeprefix("--set ")
                )
                is_named = not axis.dimension and sentence.startswith(label)
                yield Fault(path if axis.dimension else (*path, place), sentence if is_named else f"{head}: {sentence}")
            if axis.dimension:
                return
            continue
        changes = list(unlike(study, variant))
        yield from (Fault(path, f"{head} changes {fact}; {repair}") for fact, repair in changes)
        idle_keys = [] if changes else list(_keys_without_effect(study, variant))
        for fact in idle_keys:
            sentence = f"changes no case: [grid] has its own {fact}"
            if fact == "gap" and axis.dimension:
                sentence = (
                    f"the uncertain gap {sentence}, and contact at any gap follows from the closing of each sample"
                )
            yield Fault(path, f"{sentence}; remove one")
        if changes or idle_keys:
            return  # the other values do the same


def _keys_without_effect(study: SceneValues, variant: SceneValues) -> Iterator[str]:
    """The keys of interfaces that the variant changes without changing any case of the grid."""
    of_scene, of_variant = ([item.gap for item in scene.interfaces] for scene in (study, variant))
    gaps = zip(study.grid.gaps, variant.grid.gaps, strict=True)
    if of_scene != of_variant and all(
        study.interface_gaps(gap) == variant.interface_gaps(variant_gap) for gap, variant_gap in gaps
    ):
        yield "gap"
    of_scene, of_variant = ([item.yield_force for item in scene.interfaces] for scene in (study, variant))
    if of_scene != of_variant and len(study.grid.yield_forces) > 1:
        yield "yield_force"
