"""What stands between two neighbours of a scene: contact, gap and the points where they meet, every value stated."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

from pounding_risk.models.contact.impulsive import CONTACT_MODELS, is_instant
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.structures.contact_points import (
    COLUMN,
    LevelRule,
    Point,
    automatic_points,
    floor_words,
    given_point,
    level_gap,
    usual_depth,
)
from pounding_risk.models.structures.links import LEAST_SLIP, Link
from pounding_risk.models.structures.plan import Plan
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.interface_checks import OF_LINKS, varied
from pounding_risk.scene.interfaces import NO_RESTITUTION, OF_ONE_LAW, PARAMETERS, Interface
from pounding_risk.scene.keys import Draft
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import STIFFNESS, STOREY_HEIGHT, exact, parse, say

ALWAYS_WRITTEN = {"gap", "contact_model", "yield_force", *OF_ONE_LAW}  # whatever the value, of a law that is run


class ResolvedInterface(Interface):
    """What stands between two neighbours: the keys of its table with every value stated, in SI, and where they meet.

    ``stiffness`` is a number [N/m or N/m^1.5], as the first contact model that takes one has it; None where none does.
    """

    points: tuple[Point, ...] = ()  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    links: tuple[Link, ...] = ()

    def as_written(self, gridded: Sequence[str]) -> dict[str, Any]:
        """The [[interface]] table, every value stated; ``gridded`` are the contact models of the grid."""
        models = (self.contact_model, *gridded)
        left_out = {key for key, law in OF_ONE_LAW.items() if law not in models}
        if self.restitution.words == NO_RESTITUTION:
            left_out.add("restitution")
        settings: dict[str, Any] = {
            key: setting
            for key in self.keys().keys() - left_out
            if (setting := getattr(self, key)) != type(self).model_fields[key].default
            or key in ALWAYS_WRITTEN
            or (key in OF_LINKS and self.links)
        }
        owner = stiff_model(str(self.contact_model), gridded)
        # A stiffness that is its table's own would stay when another table is given, were it written down.
        is_of_table = owner == TABULATED and self.table is not None and self.stiffness == self.table.stiffness
        if settings.pop("stiffness", None) is not None and owner is not None and not is_of_table:
            settings["stiffness"] = exact(float(self.stiffness), stiffness_quantity(CONTACT_MODELS[owner]))
        table: Interface = Interface.from_values(settings)
        return table.written()


def stiff_model(own: str, gridded: Iterable[str]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def resolved_interfaces(
    draft: Draft, buildings: Sequence[Building | Storeys], grid: Grid, row: bool
) -> tuple[tuple[ResolvedInterface, ...], list[Fault]]:
    """What stands between each two buildings, from tables without a fault; one table is for all where there is one."""
    interfaces, faults = [], []
    tables = draft.tables("interface")
    # What one interface does not say of its contact is that of the first which does.
    inherited = ("contact_model", *PARAMETERS, "equal_terms")
    shared = {key: keys.get(key) for key in inherited for keys in tables[::-1] if key in keys}
    # In a row, a grid of one yield force is that of all interfaces.
    shared_force = {"yield_force": grid.yield_force[0]} if row and len(grid.yield_force) == 1 else {}
    depths = [keys.get("floor_depth") for keys in draft.tables("building")]
    stands_apart = len({repr(side.support) for side in buildings}) > 1 or "wave_passage" in draft.table("effects").raw
    has_bumper = "bumper_length" in varied(draft) or any("bumper_length" in keys for keys in tables)
    for place, sides in enumerate(pairwise(buildings)):
        keys = tables[min(place, len(tables) - 1)]
        table = Interface.from_values(shared | dict(keys.values) | shared_force)
        # What its table does not say of the contact is the first of the grid.
        contact_model = table.contact_model or grid.contact_model[0]
        owner = stiff_model(contact_model, grid.contact_model)
        stiffness = None
        if owner == TABULATED and table.stiffness is None:
            stiffness = table.table.stiffness
        elif owner is not None:
            stiffness = parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
        here = Beside(place, sides, (depths[place], depths[place + 1]), table, keys.path)
        points, wrong = _contact_points(here)
        wrong += _wrong_links(here, stands_apart=stands_apart)
        faults += wrong
        values = {key: getattr(table, key) for key in Interface.key_names()} | {
            "gap": grid.gap[0] if table.gap is None else table.gap,
            # As an axis has it, so that all scenes of the axis have one.
            "bumper_length": 0.0 if table.bumper_length is None and has_bumper else table.bumper_length,
            "contact_model": contact_model,
            "stiffness": stiffness,
            "points": points,
            "links": _links(here, points) if not wrong and OF_LINKS & {*keys.raw, *varied(draft)} else (),
            "levels": here.rule,
        }
        interfaces.append(ResolvedInterface.from_values(values))
    return tuple(interfaces), faults


class Beside(NamedTuple):
    """Two neighbours with their tables: the left one's place in the row, from 0, and what stands between them."""

    place: int
    sides: tuple[Building | Storeys, Building | Storeys]
    depths: tuple[float | None, float | None]  # of their floors, as given [m]
    table: Interface
    base: KeyPath  # where the table stands

    @property
    def rule(self) -> LevelRule:
        """When two of their floors are one contact point."""
        left, right = (
            usual_depth(side) if depth is None else depth for side, depth in zip(self.sides, self.depths, strict=True)
        )
        return LevelRule(left, right, self.table.tolerance)


def _contact_points(here: Beside) -> tuple[tuple[Point, ...], list[Fault]]:
    """The contact points of two neighbours, and what is wrong with them."""
    table, sides, rule = here.table, here.sides, here.rule
    if table.contact:
        wrong = [
            Fault((*here.base, "contact"), sentence)
            for floors in table.contact
            if (sentence := _misplaced(sides, floors, rule))
        ]
        meetings = [] if wrong else [given_point(*sides, *floors) for floors in table.contact]
    else:
        wrong = _too_deep(here)
        meetings = [] if wrong else automatic_points(*sides, rule.is_one)
    points = [Point(here.place, *meeting) for meeting in meetings]
    if not wrong and any(_plans_of(side) for side in sides):
        points, wrong = _at_both_ends(here, points)
    return tuple(points), wrong


def _plans_of(side: Building | Storeys) -> tuple[Plan, ...]:
    return side.plans if isinstance(side, Storeys) else ()


def _at_both_ends(here: Beside, points: Sequence[Point]) -> tuple[list[Point], list[Fault]]:
    """Contact points of floors that rotate: at both ends of what the faces of two floors share, where they do."""
    left, right = (side.name for side in here.sides)
    if any(point.kind == COLUMN for point in points):
        words = (
            f"floors that rotate meet floors, and here of {left} and {right} one meets a column; write contact with "
            "the floors that meet, or a floor_depth or tolerance by which their levels are one"
        )
        return [], [Fault((*here.base, "contact"), words)]
    shared = [point._replace(across=across) for point in points for across in _shared_ends(here.sides, point)]
    apart = [point for point in points if not _shared_ends(here.sides, point)]
    if apart and (here.table.contact or not shared):
        words = f"the faces of {left} and {right} do not meet"
        if shared:
            words += f" at {floor_words(apart[0].left_floor)} of {left}; remove it from contact, or correct plan:"
        else:
            words += ";"
        return [], [Fault(("building", here.place, "plan"), f"{words} their ends are in one coordinate across the row")]
    return shared, []


def _shared_ends(sides: tuple[Any, Any], point: Point) -> tuple[float, ...]:
    """Both ends of what the faces of the floors at a contact point share [m]; none where they share nothing."""
    floors = zip(sides, (point.left_floor, point.right_floor), strict=True)
    faces = [plans[int(floor) - 1].face for side, floor in floors if (plans := _plans_of(side))]
    low, high = max(face[0] for face in faces), min(face[1] for face in faces)  # without a plan one is as long
    return (low, high) if low < high else ()


def _links(here: Beside, points: Sequence[Point]) -> tuple[Link, ...]:
    """The links of two neighbours: where their table says, or at their highest contact point."""
    table = here.table
    places = table.link_at or ((points[-1].left_floor, points[-1].right_floor),)
    slack = -inf if table.link_slack is None else table.link_slack
    law = table.link_stiffness, table.link_damping, table.link_strength, slack, table.link_breaking_force
    brace = table.link_brace_stiffness or inf
    exponent = table.link_exponent or float(brace < inf)
    return tuple(Link(here.place, *floors, *law, exponent=exponent, brace=brace) for floors in places)


def _wrong_links(here: Beside, *, stands_apart: bool) -> list[Fault]:
    """Links at places that are none, between buildings of a row whose grounds differ, or too stiff to be followed."""
    table = here.table
    key = "link_stiffness" if table.link_stiffness else "link_damping"
    if any(_plans_of(side) for side in here.sides) and (table.link_stiffness or table.link_damping):
        return [Fault((*here.base, key), "links of floors that rotate are not computed; remove it, or plan")]
    if stands_apart and (table.link_stiffness or table.link_damping):
        words = "links are computed where all buildings stand on one ground motion; remove it, or what parts them"
        return [Fault((*here.base, key), words)]
    if table.link_strength < LEAST_SLIP * table.link_stiffness:
        slip, most = table.link_strength / table.link_stiffness, table.link_strength / LEAST_SLIP
        words = (
            f"{say(table.link_stiffness, STIFFNESS)} slips at link_strength after {slip:.2g} m; less than "
            f"{LEAST_SLIP:g} m cannot be followed, and sliding would be lost; write {say(most, STIFFNESS)} or less"
        )
        return [Fault((*here.base, "link_stiffness"), words)]
    return [
        Fault((*here.base, "link_at"), sentence)
        for floors in table.link_at
        if (sentence := _no_such_floor(here.sides, floors))
    ]


def _no_such_floor(sides: tuple[Any, Any], floors: tuple[float, float]) -> str:
    """Words on a place above a building's roof; "" where there is none."""
    for side, floor in zip(sides, floors, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return (
                f"{floor_words(floor)} of {side.name}: {side.name} has {count} storey{'s' * (count != 1)}; write one "
                "of these"
            )
    return ""


def _too_deep(here: Beside) -> list[Fault]:
    """A tolerance, or depths of floors, by which a floor could meet two floors of the other building."""
    lowest = min((height for side in here.sides if isinstance(side, Storeys) for height in side.heights), default=inf)
    rule = here.rule
    reason = (
        f"is not below half of the lowest storey here, {say(lowest, STOREY_HEIGHT)}, so that a floor could meet two"
    )
    if rule.tolerance is not None:
        if rule.tolerance < 0.5 * lowest:
            return []
        repair = "write a smaller one, or the points themselves in contact"
        return [Fault((*here.base, "tolerance"), f"{say(rule.tolerance, STOREY_HEIGHT)} {reason}; {repair}")]
    wrong = []
    for side, depth in enumerate((rule.left_depth, rule.right_depth)):
        if depth >= 0.5 * lowest:
            usual = "" if here.depths[side] is not None else "missing, and the usual "
            repair = "write the depth of the floor slabs, or the points themselves in contact"
            path = ("building", here.place + side, "floor_depth")
            wrong.append(Fault(path, f"{usual}{say(depth, STOREY_HEIGHT)} {reason}; {repair}", absent=bool(usual)))
    return wrong


def _misplaced(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """What is wrong with a contact point that the scene gives; "" where nothing is."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    if absent := _no_such_floor(sides, floors):
        return absent
    if not any(floor == int(floor) or side.is_rigid for side, floor in zip(sides, floors, strict=True)):
        return f"{words[0]} against {words[1]}: a column meets a floor; write storey in place of one of them"
    difference, limit = level_gap(*sides, *floors), rule.largest
    if difference > limit:
        key = "floor_depth" if rule.tolerance is None else "tolerance"
        what = "the depth of a floor here," if rule.tolerance is None else "the tolerance of"
        return (
            f"{words[0]} and {words[1]} are {say(difference, STOREY_HEIGHT)} apart in level, more than {what} "
            f"{say(limit, STOREY_HEIGHT)}; correct the place, or write a larger {key}"
        )
    return ""
