"""Scenes of rows: which scene is one, what its interfaces share, and where the neighbours meet.

Two single masses that meet mass to mass are a pair. Everything else is a row: more than two buildings, storeys, heights
that differ, contact points of the scene's own, and effects that act on buildings.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk._common.words import nearest
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.effects import EFFECTS, PerInterface, acts_on_buildings
from pounding_risk.models.structures.contact_points import (
    LevelRule,
    Meeting,
    Point,
    automatic_points,
    floor_words,
    given_point,
    level_gap,
    usual_depth,
)
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.buildings import has_storeys
from pounding_risk.scene.scene import Neighbour, interface_name
from pounding_risk.scene.toml import Fault, KeyPath, as_list, table, tables
from pounding_risk.units import HEIGHT, STOREY_HEIGHT, QuantityError, parse, say, shown

OF_POINTS = ("contact", "tolerance", "column_yield_force")  # keys that a pair of masses has no use for
ONE_FOR_ALL = ("contact_model", "plastic_exponent", "design_penetration", "equal_terms")


def is_row(raw: Mapping[str, Any]) -> bool:
    """True for the tables of a row, false for those of a pair, whatever is wrong with either."""
    buildings = [keys for _, keys in tables(raw, "building")]
    effects = [name for name in table(raw, "effects") if name in EFFECTS and acts_on_buildings(name)]
    return (
        len(buildings) > 2
        or any(has_storeys(keys) or "floor_depth" in keys for keys in buildings)
        or any(key in keys for _, keys in tables(raw, "interface") for key in OF_POINTS)
        or bool(effects)
        or (len(buildings) == 2 and _heights_differ(buildings))
    )


def _heights_differ(buildings: Sequence[Mapping[str, Any]]) -> bool:
    """True for two masses, or a mass and a wall, that meet part-way up one of the masses."""
    masses = []
    for keys in buildings:
        try:
            height = parse(keys["height"], HEIGHT) if "height" in keys else 0.0
        except QuantityError:
            return False
        masses.append(Building("", 1.0, 0.0 if keys.get("rigid") is True else 1.0, 0.0, height=height))
    points = automatic_points(masses[0], masses[1])
    met = [(mass, floor) for point in points for mass, floor in zip(masses, point[:2], strict=True)]
    return any(floor != 1.0 and not mass.is_rigid for mass, floor in met)


def row_checks(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """All faults that only a scene of several interfaces, or of storeys, can have."""
    yield from _count(raw)
    yield from _gridded(raw)
    yield from _listed(raw)
    if is_row(raw):
        yield from _one_for_all(raw)
        yield from _instant(raw)


def _listed(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Options of effects that are lists have one value for each interface."""
    count = most_interfaces(raw)
    each = f", or {count}, one between each two neighbours from left to right" if count > 1 else ""
    for name, options in table(raw, "effects").items():
        kinds = EFFECTS[name].options if name in EFFECTS and isinstance(options, dict) else {}
        for key in (key for key, allowed in kinds.items() if isinstance(allowed, PerInterface)):
            value = options.get(key)
            if isinstance(value, list) and len(value) not in (0, count):
                told = f"a list of {len(value)} for {counted(count, 'interface')}: write one value for all{each}"
                yield Fault(("effects", name, key), told)


def _count(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """One interface for all neighbours, or one between each two of them."""
    if not isinstance(raw.get("interface"), list) or not isinstance(raw.get("building"), list):
        return
    count, buildings = len(raw["interface"]), len(raw["building"])
    if count in (1, most_interfaces(raw)):
        return
    if buildings <= 2:
        repair = (
            f"there is one between two neighbours; {'remove ' + str(count - 1) if count else 'write one [[interface]]'}"
        )
    else:
        repair = f"write {buildings - 1}, one between each two neighbours from left to right, or one for all of them"
    yield Fault(
        ("interface", count - 1) if count else ("interface",),
        f"{count} interfaces for {buildings} buildings: {repair}",
    )


def most_interfaces(raw: Mapping[str, Any]) -> int:
    """One fewer than there are buildings, one at least: more are not looked into."""
    return max(len(as_list(raw.get("building"))) - 1, 1)


def _gridded(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """The interface whose gap alone the grid varies: it is there, and so are its gaps."""
    grid = table(raw, "grid")
    named = grid.get("interface")
    if not isinstance(named, str):
        return
    known = _names(raw)
    if named not in known:
        yield Fault(
            ("grid", "interface"),
            f"{shown(named)} is not an interface{nearest(named, known)}; it may be {', '.join(map(shown, known))}",
        )
    if "gap" not in grid:
        yield Fault(
            ("grid", "interface"), 'names the interface whose gap varies; write gap = ["25 mm", "50 mm"] in [grid] too'
        )


def _names(raw: Mapping[str, Any]) -> list[str]:
    """The interfaces' names, left to right."""
    names = [str(keys.get("name", "")) for _, keys in tables(raw, "building")]
    return [interface_name(left, right) for left, right in pairwise(names)]


def lacks_gap(raw: Mapping[str, Any], index: int) -> bool:
    """True for an interface whose gap neither it nor the grid tells."""
    grid, names = table(raw, "grid"), _names(raw)
    if "gap" not in grid or grid.get("interface") not in names:
        return "gap" not in grid
    mine = names if len(tables(raw, "interface")) == 1 else names[index : index + 1]
    return mine != [grid["interface"]]


def _one_for_all(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Keys that are one for the whole row, and differ from interface to interface."""
    interfaces = tables(raw, "interface")
    for key in ONE_FOR_ALL:
        told = [(index, keys[key]) for index, keys in interfaces if key in keys]
        for index, value in told[1:]:
            if value != told[0][1]:
                yield Fault(
                    ("interface", index, key),
                    f"{shown(value)}, and interface {told[0][0] + 1} has {shown(told[0][1])}: a row has one {key}; "
                    "write the same, or leave it out here",
                )
    relations = [(index, _relation(keys["restitution"])) for index, keys in interfaces if "restitution" in keys]
    for index, relation in relations[1:]:
        if relation != relations[0][1]:
            yield Fault(
                ("interface", index, "restitution"),
                f"by the {relation} relation, and that of interface {relations[0][0] + 1} by the {relations[0][1]} "
                "one: a row has one relation of restitution and damping; write the same",
            )


def _relation(restitution: Any) -> str:
    return str(restitution.get("relation", AS_PUBLISHED)) if isinstance(restitution, dict) else AS_PUBLISHED


def _instant(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Contact models whose velocities jump, which only the pair knows."""
    grid = as_list(table(raw, "grid").get("contact_model"))
    named: list[tuple[KeyPath, Any]] = [
        *(
            (("interface", index, "contact_model"), keys.get("contact_model"))
            for index, keys in tables(raw, "interface")
        ),
        *((("grid", "contact_model", place), name) for place, name in enumerate(grid)),
    ]
    for path, name in named:
        if isinstance(name, str) and name in INSTANT_LAWS:
            why = "of floors that touch at one instant, momentum and e leave the velocities open (Halm and Posa 2021)"
            yield Fault(path, f"{name} is for a pair of single masses: {why}; in a row choose among {', '.join(LAWS)}")


class Beside(NamedTuple):
    """Two neighbours with their tables: the left one's place in the row, from 0, and what stands between them."""

    place: int
    sides: tuple[Building | Storeys, Building | Storeys]
    tables: tuple[Any, Any]  # of the [[building]] sections
    table: Any  # of the [[interface]]
    base: KeyPath  # where that one stands

    @property
    def rule(self) -> LevelRule:
        """When two of their floors are one contact point."""
        left, right = (
            usual_depth(side) if table.floor_depth is None else table.floor_depth
            for side, table in zip(self.sides, self.tables, strict=True)
        )
        return LevelRule(left, right, self.table.tolerance)


def contact_points(here: Beside) -> tuple[tuple[Point, ...], list[Fault]]:
    """The contact points of two neighbours, and what is wrong with them."""
    table, sides, rule = here.table, here.sides, here.rule
    if table.contact:
        faults = [
            Fault((*here.base, "contact"), sentence)
            for floors in table.contact
            if (sentence := _misplaced(sides, floors, rule))
        ]
        points = [] if faults else [given_point(*sides, *floors) for floors in table.contact]
        return _numbered(here.place, points), faults
    if faults := _too_deep(here):
        return (), faults
    return _numbered(here.place, automatic_points(*sides, rule.is_one)), []


def _too_deep(here: Beside) -> list[Fault]:
    """A tolerance, or depths of floors, by which a floor could meet two floors of the other building."""
    lowest = min((height for side in here.sides if isinstance(side, Storeys) for height in side.heights), default=inf)
    rule = here.rule
    told = f"is not below half of the lowest storey here, {say(lowest, STOREY_HEIGHT)}, so that a floor could meet two"
    if rule.tolerance is not None:
        if rule.tolerance < 0.5 * lowest:
            return []
        repair = "write a smaller one, or the points themselves in contact"
        return [Fault((*here.base, "tolerance"), f"{say(rule.tolerance, STOREY_HEIGHT)} {told}; {repair}")]
    faults = []
    for side, depth in enumerate((rule.left_depth, rule.right_depth)):
        if depth >= 0.5 * lowest:
            usual = "" if here.tables[side].floor_depth is not None else "missing, and the usual "
            repair = "write the depth of the floor slabs, or the points themselves in contact"
            path = ("building", here.place + side, "floor_depth")
            faults.append(Fault(path, f"{usual}{say(depth, STOREY_HEIGHT)} {told}; {repair}", absent=bool(usual)))
    return faults


def _numbered(place: int, found: Sequence[Meeting]) -> tuple[Point, ...]:
    return tuple(Point(place, *meeting) for meeting in found)


def _misplaced(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """What is wrong with a contact point that the scene gives; "" where nothing is."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    for side, floor, told in zip(sides, floors, words, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return f"{told}: {side.name} has {count} storey{'s' * (count != 1)}; write one of these"
    if not any(floor == int(floor) or side.is_rigid for side, floor in zip(sides, floors, strict=True)):
        return f"{words[0]} against {words[1]}: a column meets a floor; write storey in place of one of them"
    apart, limit = level_gap(*sides, *floors), rule.largest
    if apart > limit:
        key = "floor_depth" if rule.tolerance is None else "tolerance"
        what = "the depth of a floor here," if rule.tolerance is None else "the tolerance of"
        return (
            f"{words[0]} and {words[1]} are {say(apart, STOREY_HEIGHT)} apart in level, more than {what} "
            f"{say(limit, STOREY_HEIGHT)}; correct the place, or write a larger {key}"
        )
    return ""


def neighbour(here: Beside, points: tuple[Point, ...], gap: float, stiffness: float | None) -> Neighbour:
    """What stands between two neighbours, of an [[interface]] without a fault."""
    table = here.table
    return Neighbour(
        gap=gap,
        stiffness=stiffness,
        restitution=table.restitution[0],
        restitution_words=table.restitution[1],
        yield_force=table.yield_force,
        column_yield_force=table.column_yield_force,
        points=points,
        levels=here.rule,
        given=bool(table.contact),
    )
