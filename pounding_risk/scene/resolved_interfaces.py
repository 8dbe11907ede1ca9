"""What stands between two neighbours of a scene: contact, gap and the points where they meet, every value stated."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

from pounding_risk.models.contact.impulsive import CONTACT_MODELS, is_instant
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.contact.table import Table as ForceTable
from pounding_risk.models.restitution import Restitution
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
from pounding_risk.scene.interfaces import (
    NO_RESTITUTION,
    PARAMETERS,
    EqualTerms,
    GivenRestitution,
    Interface,
)
from pounding_risk.scene.keys import Draft
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import STOREY_HEIGHT, exact, parse, say


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
        points = [] if wrong else [given_point(*sides, *floors) for floors in table.contact]
        return _numbered(here.place, points), wrong
    if wrong := _too_deep(here):
        return (), wrong
    return _numbered(here.place, automatic_points(*sides, rule.is_one)), []


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


def _numbered(place: int, meetings: Sequence[Meeting]) -> tuple[Point, ...]:
    return tuple(Point(place, *meeting) for meeting in meetings)


def _misplaced(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """What is wrong with a contact point that the scene gives; "" where nothing is."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    for side, floor, where in zip(sides, floors, words, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return f"{where}: {side.name} has {count} storey{'s' * (count != 1)}; write one of these"
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


# What is resolved as its table gives it.
AS_GIVEN = ("yield_force", "column_yield_force", *PARAMETERS, "equal_terms")


class ResolvedInterface(NamedTuple):
    """What stands between two neighbours, every value stated."""

    gap: float  # m
    contact_model: str  # name of its contact model
    stiffness: float | None  # N/m or N/m^1.5, as the first contact model that takes one has it
    restitution: Restitution
    restitution_words: str
    yield_force: float  # N, of floors; inf without yielding
    column_yield_force: float  # N, of columns that are hit part-way up; inf without yielding
    points: tuple[Point, ...]  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    given: bool = False  # whether the scene gives the points; else they follow from the heights
    relation: str = AS_PUBLISHED  # of restitution and damping
    plastic_exponent: float = 0.0  # of van_mier
    design_penetration: float = 0.0  # of bilinear [m]; 0 follows the approach speed
    table: ForceTable | None = None  # of tabulated
    equal_terms: EqualTerms | None = None


def stiff_model(own: str, gridded: Iterable[str]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def resolved_interfaces(
    draft: Draft, buildings: Sequence[Building | Storeys], grid: Grid, row: bool
) -> tuple[tuple[ResolvedInterface, ...], list[Fault]]:
    """What stands between each two buildings, from tables without a fault; one table is for all where there is one."""
    interfaces, faults = [], []
    given = draft.tables("interface")
    # What one interface does not say of its contact is that of the first which does.
    inherited = ("contact_model", *PARAMETERS, "equal_terms")
    shared = {key: keys.get(key) for key in inherited for keys in given[::-1] if key in keys}
    # In a row, a grid of one yield force is that of all interfaces.
    shared_force = {"yield_force": grid.yield_force[0]} if row and len(grid.yield_force) == 1 else {}
    depths = [keys.get("floor_depth") for keys in draft.tables("building")]
    for place, sides in enumerate(pairwise(buildings)):
        keys = given[min(place, len(given) - 1)]
        table = Interface.made(shared | dict(keys.values) | shared_force)
        here = Beside(place, sides, (depths[place], depths[place + 1]), table, keys.path)
        points, wrong = _contact_points(here)
        faults += wrong
        interfaces.append(_resolved(here, points, grid))
    return tuple(interfaces), faults


def _resolved(here: Beside, points: tuple[Point, ...], grid: Grid) -> ResolvedInterface:
    """What stands between two neighbours: what their table does not say of the contact is the first of the grid."""
    table, restitution = here.table, here.table.restitution
    contact_model = table.contact_model or grid.contact_model[0]
    owner = stiff_model(contact_model, grid.contact_model)
    stiffness = None
    if owner is not None:
        own = owner == TABULATED and table.stiffness is None
        stiffness = table.table.stiffness if own else parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
    return ResolvedInterface(
        gap=grid.gap[0] if table.gap is None else table.gap,
        contact_model=contact_model,
        stiffness=stiffness,
        restitution=restitution.rule,
        restitution_words=restitution.words,
        relation=restitution.relation,
        points=points,
        levels=here.rule,
        given=bool(table.contact),
        **{key: getattr(table, key) for key in AS_GIVEN},
    )


def _is_of_table(between: ResolvedInterface, owner: str) -> bool:
    """True for a stiffness that is its table's own: written down it would stay when another table is given."""
    return owner == TABULATED and between.table is not None and between.stiffness == between.table.stiffness


def interface_table(between: ResolvedInterface, gridded: Sequence[str]) -> Interface:
    """The table of an interface, every value stated; keys that make a row only where they were given."""
    models = (between.contact_model, *gridded)
    owner = stiff_model(between.contact_model, gridded)
    values: dict[str, Any] = {"gap": between.gap, "contact_model": between.contact_model}
    if between.stiffness is not None and owner is not None and not _is_of_table(between, owner):
        values["stiffness"] = exact(float(between.stiffness), stiffness_quantity(CONTACT_MODELS[owner]))
    if between.restitution_words != NO_RESTITUTION:
        values["restitution"] = GivenRestitution(between.restitution, between.restitution_words, between.relation)
    values["yield_force"] = between.yield_force
    if "van_mier" in models:
        values["plastic_exponent"] = between.plastic_exponent
    if "bilinear" in models:
        values["design_penetration"] = between.design_penetration
    if between.table is not None:
        values["table"] = between.table
    if between.equal_terms:
        values["equal_terms"] = between.equal_terms
    if between.column_yield_force < inf:
        values["column_yield_force"] = between.column_yield_force
    if between.levels.tolerance is not None:
        values["tolerance"] = between.levels.tolerance
    if between.given:
        values["contact"] = tuple((point.left_floor, point.right_floor) for point in between.points)
    return Interface.made(values)
