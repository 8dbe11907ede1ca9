"""Notes to the reader of a scene: keys that it gives without effect, and floors that nearly meet otherwise.

`UNUSED` is the table of keys without effect, by section: neither `scan` nor `simulate` reads them in this scene, since
another key overrules them or what they act on is not there. A key with its default value is not listed.

Floor to floor, a contact yields at the floors' F_E; floor to column, at the column's. Where a few centimetres of level
decide between the two, a reader of the results has to know: `level_notes`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf, isnan
from typing import Any, NamedTuple

from pounding_risk.models.contact.impulsive import is_instant, needs_floors
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import acts_on_law, wave_of
from pounding_risk.models.structures.contact_points import (
    COLUMN,
    FLOOR,
    ROUNDING,
    LevelRule,
    automatic_points,
    outlines,
)
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED
from pounding_risk.models.structures.storeys import DAMPING_RULES, Storeys
from pounding_risk.motions.generated import motion_kinds
from pounding_risk.motions.levels import FACTOR, PEAK, Measure, at_pga, say_level
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.resolved_interfaces import OF_DAMPER, OF_SPRING, ResolvedInterface
from pounding_risk.scene.scene import Scene, own_amplitude
from pounding_risk.scene.toml import KeyPath, key_name
from pounding_risk.scene.variants import Variants
from pounding_risk.units import PGA, STOREY_HEIGHT, YIELD_FORCE, parse, say

GivenKeys = Mapping[KeyPath, Any]  # the keys of a scene and their values as written; tables of an array by index from 0
Laws = Mapping[str, Any]  # the contact models that a scene runs: those of the grid, and of the interfaces
NEAR, NEAR_SHARE = 0.05, 0.2  # m, and share of the limit: nearer than the larger of both is near
MOST_NAMED = 3  # pairs of floors of an interface that are named


# ------------------------------------------------------------------------------------------------ unused keys


class Unused(NamedTuple):
    """A key without effect, and why it has none."""

    path: KeyPath
    reason: str
    on: str = ""  # what it has no effect on, where it has one elsewhere


def unused_keys(study: Scene) -> tuple[str, ...]:
    """A sentence for each key that the scene gives without effect: "interface.restitution: no effect: ...".

    A sentence that holds for several tables is given once, with the key of each.
    """
    keys: dict[tuple[str, str], list[str]] = {}  # by the key without its table, and the sentence
    for path, name, words in _unused(study):
        keys.setdefault((f"{path[0]}.{path[-1]}", words), []).append(name)
    return tuple(f"{', '.join(names)}: {words}" for (_, words), names in keys.items())


def _unused(study: Scene) -> list[tuple[KeyPath, str, str]]:
    """Path, name and words of each key without effect.

    In a scene with axes of its numbers a key counts if it has no effect at both ends of all axes; so does an axis.
    """
    if study.axes:
        variants = Variants(study)
        first, last = (_unused(variants.scene(number)) for number in (0, variants.count - 1))
        return [unused for unused in first if unused in last]
    given, laws = given_keys(study), {name: known_law(name) for name in study.model_names}
    tables = {
        "building": [{"name": building.name} for building in study.buildings],
        "interface": [{} for _ in range(_interface_table_count(given))],
    }
    items = (unused for of_section in UNUSED for unused in of_section(study, given, laws) if unused.path in given)
    return [(path, key_name(path, tables), f"no effect{on}: {reason}") for path, reason, on in items]


def given_keys(study: Scene) -> dict[KeyPath, Any]:
    """The keys that the scene's text and its overrides give; those of the resolved scene where it has no text."""
    from pounding_risk.scene.reader import written_tables

    given: dict[KeyPath, Any] = {}
    for section, value in written_tables(study).items():
        for index, table in enumerate(value) if isinstance(value, list) else [(None, value)]:
            path = (section,) if index is None else (section, index)
            given |= {(*path, key): item for key, item in table.items()}
            for key, item in table.items():
                parts = (
                    [((), item)]
                    if not isinstance(item, list)
                    else [((below,), part) for below, part in enumerate(item)]
                )
                for below, options in parts:
                    if isinstance(options, Mapping):
                        given |= {(*path, key, *below, option): setting for option, setting in options.items()}
    return given


def _interface_table_count(given: GivenKeys) -> int:
    """How many [[interface]] tables the scene has: one for all neighbours, or one between each two."""
    return 1 + max((path[1] for path in given if path[0] == "interface" and isinstance(path[1], int)), default=0)


def _unused_in_buildings(study: Scene, given: GivenKeys, laws: Laws) -> Iterator[Unused]:
    no_levels = "no building here has a height, so that there are no levels to compare"
    for index, building in enumerate(study.buildings):
        base = ("building", index)
        if building.is_rigid:
            yield Unused((*base, "mass"), "a rigid building moves with the ground, whatever its mass")
        if not any(map(needs_floors, laws.values())):
            reason = f"only contact model distributed_mass reads it, and this scene runs {', '.join(laws)}"
            yield Unused((*base, "floor_length"), reason)
            if getattr(building, "wave_speed", CONCRETE_WAVE_SPEED) != CONCRETE_WAVE_SPEED:
                yield Unused((*base, "wave_speed"), reason)
        if not study.is_row:
            yield Unused((*base, "height"), "two single masses meet mass to mass, and no run reads their height")
        if isinstance(building, Storeys):
            yields = "inelastic_storeys" in dict(study.effects) and any(force < inf for force in building.strengths)
            if "inelastic_storeys" not in dict(study.effects):
                reason = "storeys yield only under an effect: write inelastic_storeys = {} in [effects], or remove it"
                yield Unused((*base, "storey_strengths"), reason)
            elif all(strength == inf for strength in building.strengths):
                yield Unused((*base, "storey_strengths"), "every yield shear is inf, so that no storey yields")
            if building.hysteresis is not None and not yields:
                yield Unused((*base, "hysteresis"), "no storey of it yields")
            if building.damping_rule != DAMPING_RULES[0]:
                if building.damping == 0.0:
                    yield Unused((*base, "damping_rule"), "the damping ratio is 0")
                elif len(building.masses) == 1:
                    reason = "a building of one storey has one mode, damped alike by every rule"
                    yield Unused((*base, "damping_rule"), reason)
            if building.column_strength < inf:
                path = (*base, "column_strength")
                if not any(study.struck_building(point) == index for point in study.points):
                    yield Unused(path, "no floor meets a column of it")
                elif not any(law.capped for law in laws.values()):
                    yield _unused_without_cap(path, laws)
        sides = study.interfaces[max(index - 1, 0) : index + 1]
        if not _has_levels(sides):
            yield Unused((*base, "floor_depth"), no_levels)
        elif all(interface.tolerance is not None for interface in sides):
            yield Unused((*base, "floor_depth"), "interface.tolerance stands in its place")


def _unused_in_interfaces(study: Scene, given: GivenKeys, laws: Laws) -> Iterator[Unused]:
    count, has_cap = _interface_table_count(given), any(law.capped for law in laws.values())
    forces = [study.yield_force, *study.grid.yield_forces, *study.point_yield_forces()]
    for index in range(count):
        base, members = ("interface", index), study.interfaces if count == 1 else study.interfaces[index : index + 1]
        if not any(law.needs_restitution for law in laws.values()):
            yield Unused((*base, "restitution"), f"{_laws_and_verb(laws, 'takes', 'take')} no restitution")
        text = given.get((*base, "yield_force"))
        if text is not None and parse(text, YIELD_FORCE) < inf:
            path, values = (*base, "yield_force"), study.grid.yield_forces
            if all(map(is_instant, laws.values())):
                yield Unused(path, f"velocities jump under {', '.join(laws)}, and no force acts")
            elif study.is_row and ("grid", "yield_force") in given and len(values) == 1:
                if values[0] != parse(text, YIELD_FORCE):
                    value = say(values[0], YIELD_FORCE)
                    yield Unused(path, f"grid.yield_force has the one value {value}, which holds at every interface")
            elif not _has_points(members, FLOOR):
                yield Unused(path, "floors meet columns only here, and these yield at their own strength")
            elif not has_cap:
                yield _unused_without_cap(path, laws)
        if all(force == inf for force in forces) and any(interface.plastic_exponent > 0.0 for interface in members):
            yield Unused((*base, "plastic_exponent"), "every yield force is inf, so that nothing yields")
        if TABULATED not in laws:
            yield Unused((*base, "table"), f"{_laws_and_verb(laws, 'reads', 'read')} no table")
        if any(interface.column_yield_force < inf for interface in members):
            if not _has_points(members, COLUMN):
                yield Unused((*base, "column_yield_force"), "no floor meets a column here")
            elif all(
                study.own_column_force(point) < inf
                for member in members
                for point in member.points
                if point.kind == COLUMN
            ):
                reason = "column_strength of the building that is struck stands in its place"
                yield Unused((*base, "column_yield_force"), reason)
            elif not has_cap:
                yield _unused_without_cap((*base, "column_yield_force"), laws)
        yield from _unused_in_links(base, members)
        if not _has_levels(members) and any(interface.tolerance is not None for interface in members):
            reason = "no building here has a height, so that there are no levels to compare"
            yield Unused((*base, "tolerance"), reason)
    if not any(map(study.needs_equal_terms, laws)):
        reason = "every contact model of the scene takes the interface's own stiffness"
        yield Unused(("interface", 0, "equal_terms"), reason)


def _unused_in_links(base: KeyPath, members: Sequence[ResolvedInterface]) -> Iterator[Unused]:
    """Keys of springs or dampers of links that have none."""
    has_spring, has_damper = (
        any(getattr(member, key) for member in members) for key in ("link_stiffness", "link_damping")
    )
    if not has_spring:
        for key in OF_SPRING:
            yield Unused((*base, key), "link_stiffness is 0 N/m, so that the link has no spring and no such force")
    if not has_damper:
        for key in OF_DAMPER:
            yield Unused((*base, key), "link_damping is 0 N s/m, so that the link has no damper")


def _unused_in_grid(study: Scene, given: GivenKeys, laws: Laws) -> Iterator[Unused]:
    forces, path = study.grid.yield_forces, ("grid", "yield_force")
    if all(force == inf for force in forces):
        return
    identical_text = f": the {len(forces)} cases of each gap are identical" if len(forces) > 1 else ""
    columns = [point for point in study.points if point.kind == COLUMN]
    if all(map(is_instant, laws.values())):
        yield Unused(path, f"velocities jump under {', '.join(laws)}, and no force acts{identical_text}")
    elif columns and len(columns) == len(study.points):
        reason = "floors meet columns only in this row, and these yield at their own strength"
        yield Unused(path, f"{reason}{identical_text}")
    else:
        if not any(law.capped for law in laws.values()):
            yield _unused_without_cap(path, laws)
        if columns:
            places = list(dict.fromkeys(study.interface_names[point.interface] for point in columns))
            points_text = f" on the {len(columns)} of {len(study.points)} contact points where a floor meets a column"
            yield Unused(path, f"these yield at their own strength, {', '.join(places)}", points_text)


def _unused_in_effects(study: Scene, given: GivenKeys, laws: Laws) -> Iterator[Unused]:
    forces = [study.yield_force, *study.grid.yield_forces, *study.point_yield_forces()]
    shears = [strength for building in study.buildings for strength in building.strengths]
    for effect in study.effects:
        base, options = ("effects", effect.name), dict(effect.options)
        if acts_on_law(effect.name) and all(force == inf for force in forces):
            yield Unused(base, "every yield force is inf, so that no contact yields")
        if effect.name == "inelastic_storeys" and all(shear == inf for shear in shears):
            yield Unused(base, "every yield shear is inf, so that no storey yields")
        if effect.name == "strain_rate" and options["code"] != "mc1990":
            yield Unused((*base, "strength"), f"only code mc1990 reads the concrete's strength, not {options['code']}")
        if effect.name == "wave_passage" and (wave := wave_of([effect])) and wave.lag == 0.0:
            yield Unused(base, "over a distance of 0 m no building has the motion later")


def _unused_in_records(study: Scene, given: GivenKeys, laws: Laws) -> Iterator[Unused]:
    """Keys of files that records do not need, and amplitudes that another key overrules."""
    request, has_pga = study.records, ("grid", "pga") in given
    if has_pga and request.pga is not None and study.grid.levels != (request.pga,):  # not of a scene as it is resolved
        path, largest = ("records", "pga"), say_level(max(filter(None, study.grid.levels)), PGA)
        if own_amplitude(study) == at_pga(request.pga):
            reason = (
                "grid.pga gives their amplitudes, and this key the one that is assessed, simulated alone and exported"
            )
            yield Unused(path, reason, " on the runs of a scan")
        else:
            reason = f"grid.pga gives the amplitudes, and {say_level(request.pga, PGA)} is not among them"
            yield Unused(path, f"{reason}; the largest, {largest}, is assessed, simulated alone and exported")
    if request.names or request.set:
        source = "names" if request.names else "set"
        yield Unused(("records", "dt"), f"every record of {source} has a time step of its own")
    if request.generated:
        yield Unused(("records", "dt"), "a generated motion has its own; write step in its [[records.generated]]")
        yield Unused(("records", "unit"), "a generated motion is in m/s^2")
    ruling_key = "grid.pga" if has_pga else "records.pga" if request.pga is not None else ""
    if study.grid.measure not in (PEAK, Measure(FACTOR)):
        ruling_key = "records.intensity"
    ruling_key = ruling_key or ("records.sa" if request.sa is not None else "")
    for index, recipe in enumerate(request.generated if ruling_key else ()):
        for key in motion_kinds()[recipe.kind].amplitude:
            yield Unused(("records", "generated", index, key), f"{ruling_key} sets the amplitude of every motion")


UNUSED: tuple[Callable[[Scene, GivenKeys, Laws], Iterable[Unused]], ...] = (
    _unused_in_buildings,
    _unused_in_interfaces,
    _unused_in_effects,
    _unused_in_records,
    _unused_in_grid,
)


def _has_levels(interfaces: Sequence[ResolvedInterface]) -> bool:
    """Whether any contact point of these interfaces has a level above the ground."""
    return not all(isnan(point.level) for interface in interfaces for point in interface.points)


def _has_points(interfaces: Sequence[ResolvedInterface], kind: str) -> bool:
    """True where one of the contact points of these interfaces is of this kind."""
    return any(point.kind == kind for interface in interfaces for point in interface.points)


def _unused_without_cap(path: KeyPath, laws: Laws) -> Unused:
    limits = _laws_and_verb(laws, "limits", "limit")
    return Unused(path, f"{limits} none; results count where one reaches the yield force", " on any force")


def _laws_and_verb(laws: Laws, singular: str, plural: str) -> str:
    return f"{', '.join(laws)} {singular if len(laws) == 1 else plural}"


# ------------------------------------------------------------------------------------------------ close calls


class CloseCall(NamedTuple):
    """Two floors whose kind of contact a small change of levels or depths would alter."""

    left_floor: int
    right_floor: int
    difference: float  # m, of their levels
    limit: float  # m, up to which they are one contact point
    is_one: bool


def level_notes(study: Scene) -> dict[str, str]:
    """What to know of each interface of a row where close calls decide what meets what, by its name."""
    notes = {}
    for place, interface in enumerate(study.interfaces):
        sides = study.buildings[place], study.buildings[place + 1]
        calls = [] if interface.contact else close_calls(*sides, interface.levels)
        sentences = [_close_call_sentence(sides, interface.levels, calls)] if calls else []
        sentences += [
            _BEARINGS.format(study.buildings[struck].name) for struck in _struck_at_bearings(study, interface)
        ]
        sentences += _parted_face_words(sides, interface)
        if sentences:
            notes[study.interface_names[place]] = " ".join(sentences)
    return notes


_BEARINGS = (
    "A floor strikes {} below its slab, where it has isolators and no columns: the slab takes its share of the "
    "force all the same; give the points that meet in contact."
)


def _parted_face_words(sides: tuple[Any, Any], interface: ResolvedInterface) -> Iterator[str]:
    """The floors at one level whose faces do not meet, by the plans of floors that rotate."""
    if interface.contact or not any(getattr(side, "plans", ()) for side in sides):
        return
    met_floors = {(point.left_floor, point.right_floor) for point in interface.points}
    meetings = [meeting[:2] for meeting in automatic_points(*sides, interface.levels.is_one)]
    if parted_floors := [str(int(left)) for left, right in meetings if (left, right) not in met_floors]:
        floors = f"floor{'s' * (len(parted_floors) > 1)} {', '.join(parted_floors)} of {sides[0].name}"
        yield f"By the faces of their plans {floors} and the floors of {sides[1].name} at that level do not meet."


def _struck_at_bearings(study: Scene, interface: ResolvedInterface) -> Iterator[int]:
    """The isolated buildings that a floor strikes below their slab, by their places in the row."""
    for point in interface.points:
        struck = study.struck_building(point)
        floors = {point.interface: point.left_floor, point.interface + 1: point.right_floor}
        if struck is not None and floors[struck] < 1.0 and getattr(study.buildings[struck], "isolators", None):
            yield struck


def close_calls(left: Any, right: Any, rule: LevelRule) -> list[CloseCall]:
    """Floors whose kind of contact a small change of levels, depths or tolerance would alter, from the ground up.

    The difference of their levels is within 50 mm or 20 % of the limit, whichever is more; or it is above a tolerance
    and below the depth of the higher floor, so that slabs that overlap are not taken to meet.
    """
    levels = [side.levels for side in outlines(left, right)]
    if isnan(levels[0][-1]):
        return []

    def kinds(flipped: tuple[float, float] | None = None) -> list[str]:
        """The kinds of the contact points, the rule reversed for floors at the two levels ``flipped``."""

        def is_one(low: float, high: float) -> bool:
            return rule.is_one(low, high) != ((low, high) == flipped)

        return [kind for _, _, kind, _ in automatic_points(left, right, is_one)]

    by_depth, usual_kinds, close = rule._replace(tolerance=None), kinds(), []
    for i, low in enumerate(levels[0], 1):
        for j, high in enumerate(levels[1], 1):
            difference, limit, is_one = abs(low - high), rule.limit(low, high), rule.is_one(low, high)
            is_near = abs(difference - limit) < max(NEAR, NEAR_SHARE * limit) - ROUNDING
            if (is_near or (by_depth.is_one(low, high) and not is_one)) and kinds((low, high)) != usual_kinds:
                close.append(CloseCall(i, j, difference, limit, is_one))
    return close


def _close_call_sentence(sides: tuple[Any, Any], rule: LevelRule, calls: list[CloseCall]) -> str:
    """Which floors and columns are taken to meet, what would change it, and how a scene decides it."""
    pairs = []
    for call in calls[:MOST_NAMED]:
        kind = "floor to floor" if call.is_one else "floor to column"
        floors = f"floors {call.left_floor} of {sides[0].name} and {call.right_floor} of {sides[1].name}"
        difference, limit = (say(length, STOREY_HEIGHT) for length in (call.difference, call.limit))
        pairs.append(f"{floors} are {difference} apart in level, limit {limit}: taken as {kind}")
    more_text = f" and {len(calls) - MOST_NAMED} more" if len(calls) > MOST_NAMED else ""
    words = "; ".join(pairs)
    sentences = [f"{words[0].upper()}{words[1:]}{more_text}."]
    if any(call.is_one for call in calls):
        sentences.append("Slightly farther apart, floors strike columns, and the contact yields at their strength.")
    if any(not call.is_one for call in calls):
        sentences.append("Slightly nearer, or deeper, floors meet floors, and the contact yields at yield_force.")
    if rule.tolerance is None:
        sentences.append("Check the levels, write the floor_depth of both buildings, or give the points in contact.")
    else:
        depths = " and ".join(dict.fromkeys(say(depth, STOREY_HEIGHT) for depth in rule[:2]))
        sentences.append(
            f"The tolerance of {say(rule.tolerance, STOREY_HEIGHT)} stands in place of floors {depths} deep; check the "
            "levels, or remove tolerance."
        )
    return " ".join(sentences)
