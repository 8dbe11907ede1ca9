"""Keys that a scene gives and that change nothing in it: which, and why.

A key is listed where neither `scan` nor `simulate` reads it in this scene: another key overrules it, or what it acts
on is not there. A key with the value that holds without it is not listed, since nothing else was asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import inf, isnan
from typing import Any, NamedTuple

from pounding_risk.models.contact.impulsive import is_instant, needs_floors
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import acts_on_law, wave_of
from pounding_risk.models.structures.contact_points import COLUMN, FLOOR
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED
from pounding_risk.models.structures.storeys import DAMPING_RULES, Storeys
from pounding_risk.motions.generated import motion_kinds
from pounding_risk.motions.levels import FACTOR, PEAK, Measure
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.resolved_interfaces import ResolvedInterface
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.toml import KeyPath, key_name
from pounding_risk.units import YIELD_FORCE, parse, say

Given = Mapping[KeyPath, Any]  # the keys of a scene and their values as written; tables of an array by index from 0


class Unused(NamedTuple):
    """A key without effect, and why it has none."""

    path: KeyPath
    reason: str
    on: str = ""  # what it has no effect on, where it has one elsewhere


class Models(NamedTuple):
    """The contact models that a scene runs, by name, sorted by what they read."""

    names: tuple[str, ...]
    damped: tuple[str, ...]  # those that take a restitution
    capped: tuple[str, ...]  # those whose force is limited at the yield force
    instant: tuple[str, ...]  # those without a force
    of_floors: tuple[str, ...]  # those that read the length of a floor


def unused_keys(study: Scene) -> tuple[str, ...]:
    """A sentence for each key that the scene gives without effect: "interface.restitution: no effect: ..."."""
    given = given_keys(study)
    tables = {
        "building": [{"name": building.name} for building in study.buildings],
        "interface": [{} for _ in range(interface_tables(given))],
    }
    listed = (unused for rule in RULES for unused in rule(study, given) if unused.path in given)
    return tuple(f"{key_name(unused.path, tables)}: no effect{unused.on}: {unused.reason}" for unused in listed)


def given_keys(study: Scene) -> dict[KeyPath, Any]:
    """The keys that the scene's text and its overrides give; those of the resolved scene where it has no text."""
    from pounding_risk.scene.reader import written_tables

    given: dict[KeyPath, Any] = {}
    for section, value in written_tables(study).items():
        for index, table in enumerate(value) if isinstance(value, list) else [(None, value)]:
            path = (section,) if index is None else (section, index)
            given |= {(*path, key): item for key, item in table.items()}
            for key, item in table.items():
                inner = [((), item)] if not isinstance(item, list) else [((at,), one) for at, one in enumerate(item)]
                for at, options in inner:
                    if isinstance(options, Mapping):
                        given |= {(*path, key, *at, option): setting for option, setting in options.items()}
    return given


def interface_tables(given: Given) -> int:
    """How many [[interface]] tables the scene has: one for all neighbours, or one between each two."""
    return 1 + max((path[1] for path in given if path[0] == "interface" and isinstance(path[1], int)), default=0)


def models_of(study: Scene) -> Models:
    """The contact models of the grid and of the interface, which `simulate` runs."""
    names = study.model_names
    laws = {name: known_law(name) for name in names}
    return Models(
        names,
        tuple(name for name, law in laws.items() if law.needs_restitution),
        tuple(name for name, law in laws.items() if law.capped),
        tuple(name for name, law in laws.items() if is_instant(law)),
        tuple(name for name, law in laws.items() if needs_floors(law)),
    )


def _of_buildings(study: Scene, given: Given) -> Iterator[Unused]:
    models, yielding = models_of(study), "inelastic_storeys" in dict(study.effects)
    for index, building in enumerate(study.buildings):
        base = ("building", index)
        if building.is_rigid:
            yield Unused((*base, "mass"), "a rigid building moves with the ground, whatever its mass")
        if not models.of_floors:
            reason = f"only contact model distributed_mass reads it, and this scene runs {', '.join(models.names)}"
            yield Unused((*base, "floor_length"), reason)
            if getattr(building, "wave_speed", CONCRETE_WAVE_SPEED) != CONCRETE_WAVE_SPEED:
                yield Unused((*base, "wave_speed"), reason)
        if not study.is_row:
            yield Unused((*base, "height"), "two single masses meet mass to mass, and no run reads their height")
        if isinstance(building, Storeys):
            yield from _of_storeys(base, building, yielding)
        yield from _floor_depth((*base, "floor_depth"), study.interfaces[max(index - 1, 0) : index + 1])


def _floor_depth(path: KeyPath, interfaces: tuple[ResolvedInterface, ...]) -> Iterator[Unused]:
    """The depth of a building's floors, beside the neighbours that it has."""
    if not _levels_known(interfaces):
        yield Unused(path, "no building here has a height, so that there are no levels to compare")
    elif all(interface.levels.tolerance is not None for interface in interfaces):
        yield Unused(path, "interface.tolerance stands in its place")


def _of_storeys(base: KeyPath, building: Storeys, yielding: bool) -> Iterator[Unused]:
    if not yielding:
        reason = "storeys yield only under an effect: write inelastic_storeys = {} in [effects], or remove it"
        yield Unused((*base, "storey_strengths"), reason)
    elif all(strength == inf for strength in building.strengths):
        yield Unused((*base, "storey_strengths"), "every yield shear is inf, so that no storey yields")
    if building.damping_rule != DAMPING_RULES[0]:
        if building.damping == 0.0:
            yield Unused((*base, "damping_rule"), "the damping ratio is 0")
        elif len(building.masses) == 1:
            yield Unused((*base, "damping_rule"), "a building of one storey has one mode, damped alike by every rule")


def _of_interfaces(study: Scene, given: Given) -> Iterator[Unused]:
    models, count = models_of(study), interface_tables(given)
    for index in range(count):
        base = ("interface", index)
        if not models.damped:
            yield Unused((*base, "restitution"), f"{_verb(models.names, 'takes', 'take')} no restitution")
        if _is_finite(given.get((*base, "yield_force"))):
            yield from _yield_force((*base, "yield_force"), study, given, index)
        here = _interfaces_of(study, index, count)
        if not _may_yield(study) and any(interface.plastic_exponent > 0.0 for interface in here):
            yield Unused((*base, "plastic_exponent"), "every yield force is inf, so that nothing yields")
        if TABULATED not in models.names:
            yield Unused((*base, "table"), f"{_verb(models.names, 'reads', 'read')} no table")
        yield from _of_levels(base, here, models)
    if not any(study.needs_equal_terms(name) for name in models.names):
        yield Unused(
            ("interface", 0, "equal_terms"), "every contact model of the scene takes the interface's own stiffness"
        )


def _yield_force(path: KeyPath, study: Scene, given: Given, index: int) -> Iterator[Unused]:
    """The yield force of the floors of an interface."""
    models, gridded = models_of(study), study.grid.yield_forces
    if len(models.instant) == len(models.names):
        yield Unused(path, f"{_jump(models.names)}, and no force acts")
    elif study.is_row and ("grid", "yield_force") in given and len(gridded) == 1:
        if gridded[0] != parse(given[path], YIELD_FORCE):
            yield Unused(
                path,
                f"grid.yield_force has the one value {say(gridded[0], YIELD_FORCE)}, which holds at every interface",
            )
    elif not _kind_at(_interfaces_of(study, index, interface_tables(given)), FLOOR):
        yield Unused(path, "floors meet columns only here, and these yield at column_yield_force")
    elif not models.capped:
        yield _uncapped(path, models)


def _interfaces_of(study: Scene, index: int, count: int) -> tuple[ResolvedInterface, ...]:
    """The interfaces that table ``index`` of ``count`` stands for."""
    return study.interfaces if count == 1 else study.interfaces[index : index + 1]


def _of_levels(base: KeyPath, interfaces: tuple[ResolvedInterface, ...], models: Models) -> Iterator[Unused]:
    """What the contact points of these interfaces leave without use."""
    if any(interface.column_yield_force < inf for interface in interfaces):
        path = (*base, "column_yield_force")
        if not _kind_at(interfaces, COLUMN):
            yield Unused(path, "no floor meets a column here")
        elif not models.capped:
            yield _uncapped(path, models)
    if not _levels_known(interfaces) and any(interface.levels.tolerance is not None for interface in interfaces):
        yield Unused((*base, "tolerance"), "no building here has a height, so that there are no levels to compare")


def _levels_known(interfaces: tuple[ResolvedInterface, ...]) -> bool:
    """Whether any contact point of these interfaces has a level above the ground."""
    return not all(isnan(point.level) for interface in interfaces for point in interface.points)


def _of_grid(study: Scene, given: Given) -> Iterator[Unused]:
    models, forces, path = models_of(study), study.grid.yield_forces, ("grid", "yield_force")
    if all(force == inf for force in forces):
        return
    columns = [point for point in study.points if point.kind == COLUMN]
    if len(models.instant) == len(models.names):
        yield Unused(path, f"{_jump(models.names)}, and no force acts{_alike(len(forces))}")
        return
    if columns and len(columns) == len(study.points):
        reason = "floors meet columns only in this row, and these yield at column_yield_force of their interface"
        yield Unused(path, f"{reason}{_alike(len(forces))}")
        return
    if not models.capped:
        yield _uncapped(path, models)
    if columns:
        places = list(dict.fromkeys(study.interface_names[point.interface] for point in columns))
        where = f" on the {len(columns)} of {len(study.points)} contact points where a floor meets a column"
        yield Unused(path, f"these yield at column_yield_force of their interface, {', '.join(places)}", where)


def _of_effects(study: Scene, given: Given) -> Iterator[Unused]:
    for effect in study.effects:
        base, options = ("effects", effect.name), dict(effect.options)
        if acts_on_law(effect.name) and not _may_yield(study):
            yield Unused(base, "every yield force is inf, so that no contact yields")
        if effect.name == "inelastic_storeys" and not _storeys_may_yield(study):
            yield Unused(base, "every yield shear is inf, so that no storey yields")
        if effect.name == "strain_rate" and options["code"] != "mc1990":
            yield Unused((*base, "strength"), f"only code mc1990 reads the concrete's strength, not {options['code']}")
        if effect.name == "wave_passage" and (wave := wave_of([effect])) and wave.lag == 0.0:
            yield Unused(base, "over a distance of 0 m no building has the motion later")


def _of_records(study: Scene, given: Given) -> Iterator[Unused]:
    asked = study.records
    if ("grid", "pga") in given:
        yield Unused(("records", "pga"), "grid.pga sets the amplitude of every motion")
    if asked.names or asked.set:
        named = "names" if asked.names else "set"
        yield Unused(("records", "dt"), f"every record of {named} has a time step of its own")
    yield from _of_generated(study, given)


def _of_generated(study: Scene, given: Given) -> Iterator[Unused]:
    """Keys of files beside generated motions, and amplitudes of these that another key overrules."""
    asked = study.records
    if asked.generated:
        yield Unused(("records", "dt"), "a generated motion has its own; write step in its [[records.generated]]")
        yield Unused(("records", "unit"), "a generated motion is in m/s^2")
    ruling = "grid.pga" if ("grid", "pga") in given else "records.pga" if asked.pga is not None else ""
    if study.grid.measure not in (PEAK, Measure(FACTOR)):
        ruling = "records.intensity"
    ruling = ruling or ("records.sa" if asked.sa is not None else "")
    for index, recipe in enumerate(asked.generated if ruling else ()):
        for key in motion_kinds()[recipe.kind].amplitude:
            yield Unused(("records", "generated", index, key), f"{ruling} sets the amplitude of every motion")


RULES: tuple[Callable[[Scene, Given], Iterable[Unused]], ...] = (
    _of_buildings,
    _of_interfaces,
    _of_effects,
    _of_records,
    _of_grid,
)


def _is_finite(text: Any) -> bool:
    return text is not None and parse(text, YIELD_FORCE) < inf


def _may_yield(study: Scene) -> bool:
    """True where a contact of the scan or of `simulate` has a finite yield force."""
    forces = [study.yield_force, *study.grid.yield_forces]
    return any(force < inf for force in (*forces, *study.point_yield_forces()))


def _storeys_may_yield(study: Scene) -> bool:
    return any(strength < inf for building in study.buildings for strength in getattr(building, "strengths", ()))


def _kind_at(interfaces: Iterable[ResolvedInterface], kind: str) -> bool:
    """True where one of the contact points of these interfaces is of this kind."""
    return any(point.kind == kind for interface in interfaces for point in interface.points)


def _uncapped(path: KeyPath, models: Models) -> Unused:
    limits = _verb(models.names, "limits", "limit")
    return Unused(path, f"{limits} none; results count where one reaches the yield force", " on any force")


def _alike(count: int) -> str:
    return f": the {count} cases of each gap are identical" if count > 1 else ""


def _verb(names: tuple[str, ...], one: str, several: str) -> str:
    return f"{', '.join(names)} {one if len(names) == 1 else several}"


def _jump(names: tuple[str, ...]) -> str:
    return f"velocities jump under {', '.join(names)}"
