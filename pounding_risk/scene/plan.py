"""The key `plan` of a building: inline tables of floors that rotate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import Any

from pounding_risk.models.structures.plan import Plan
from pounding_risk.scene.keys import (
    REQUIRED,
    Draft,
    Key,
    Number,
    Several,
    Table,
    Unreadable,
    each,
    inline,
    list_of,
    measured,
)
from pounding_risk.scene.toml import Fault
from pounding_risk.units import Quantity, exact, shown

ACROSS = Quantity("m", -inf, inf, "place across the row", example="-8 m")
GYRATION = Quantity("m", 0.0, inf, "radius of gyration", open_low=True, open_high=True, example="6.5 m")
RATIO = Quantity("1", 0.0, 100.0, "ratio of two frequencies", open_low=True, example="1.1")
EXAMPLE = '{face = ["-8 m", "8 m"], eccentricity = "1.5 m", gyration = "6.5 m", torsional_ratio = 1.1}'


def _face(value: Any, number: Number) -> tuple[float, float]:
    places = each(list_of(value, 'both ends, such as ["-8 m", "8 m"]'), lambda end: number(end, ACROSS))
    if len(places) != 2 or not places[0] < places[1]:
        raise Unreadable(f'{shown(value)} is no face; write both ends, the lower first, such as ["-8 m", "8 m"]')
    return places[0], places[1]


class PlanTable(Table):
    """The plan of one floor and the storey below it, or of all, by which floors rotate as they move along the row."""

    face: tuple[float, float] = Key(
        "Both ends of the faces towards the neighbours: places across the row, in one coordinate of all buildings, "
        "that grows to the left of who looks along the row.",
        _face,
        '["-8 m", "8 m"]',
        REQUIRED,
        write=lambda ends: [exact(end, ACROSS) for end in ends],
        schema={"type": "array", "items": {"type": "string"}},
    ).required()
    eccentricity: float = measured(
        ACROSS._replace(words="eccentricity", example="1.5 m"),
        "Place of the centre of stiffness across the row, from the centre of mass.",
    ).required()
    gyration: float = measured(GYRATION, "Radius of gyration of a floor about its centre of mass.").required()
    torsional_ratio: float = measured(
        RATIO, "Frequency of rotation about the centre of stiffness over that of translation, each alone."
    ).required()
    centre: float | None = measured(
        ACROSS, "Place of the centre of mass.", '"0 m"', "the middle of the face"
    ).defaults_to(None)
    eccentricity_along: float | None = measured(
        ACROSS._replace(words="eccentricity", example="1 m"),
        "Place of the centre of stiffness along the row, from the centre of mass, positive to the right: floors "
        "then move across the row too, under both horizontals of each recording, turned by direction in [records].",
        absent="floors move along the row and rotate",
    ).defaults_to(None)
    across_ratio: float = measured(
        RATIO, "Frequency of translation across the row over that along it, each alone.", "0.9", "1"
    ).defaults_to(1.0)
    centre_along: float = measured(
        ACROSS._replace(words="place along the row", example="2 m"),
        "Place of the centre of mass along the row, of floors with unlike plans: from one vertical axis of the "
        "building, positive to the right.",
        absent="centres of mass above each other along the row",
    ).defaults_to(0.0)

    @classmethod
    def of(cls, plan: Plan) -> Any:
        """The table of a plan, every value stated."""
        usual = {key: about.default for key, about in cls.model_fields.items()} | {"centre": 0.5 * sum(plan.face)}
        return cls.from_values({key: parameter for key, parameter in plan._asdict().items() if parameter != usual[key]})

    def plan(self) -> Plan:
        """The plan as buildings of `models.structures` have it."""
        centre = 0.5 * sum(self.face) if self.centre is None else self.centre
        return Plan(**vars(self) | {"centre": centre})


def plans_of(tables: Sequence[PlanTable], count: int) -> tuple[Plan, ...]:
    """The plans of so many floors, from a table for each of them or one for all; none from none."""
    plans = tuple(table.plan() for table in tables)
    return plans * count if len(plans) == 1 else plans


def tables_of(plans: Sequence[Plan]) -> tuple[PlanTable, ...]:
    """A table for each plan, or one where all are equal."""
    return tuple(PlanTable.of(plan) for plan in (plans[:1] if len(set(plans)) == 1 else plans))


def _plans(value: Any, number: Number) -> tuple[PlanTable, ...]:
    """One table for all floors, or a list with one for each; all of them move across the row, or none does."""
    if not isinstance(value, list | tuple):
        return (_plan(value, number),)
    example = f"[{EXAMPLE}, ...], one for each floor from the ground up"
    tables = tuple(each(list_of(list(value), example), lambda item: _plan(item, number)))
    moving = [table.eccentricity_along is not None for table in tables]
    if any(moving) and not all(moving):
        words = 'is missing here, and stands in other plans of the building; write it in all, such as "0 m", or in none'
        raise Several([((moving.index(False), "eccentricity_along"), words)])
    return tables


def _plan(value: Any, number: Number) -> PlanTable:
    """A table whose centre of mass lies within the face."""
    table: PlanTable = inline(PlanTable, "plan", value, number, EXAMPLE)
    low, high = table.face
    if table.centre is not None and not low <= table.centre <= high:
        raise Several([(("centre",), "is outside the face; check both, in the one coordinate across the row")])
    if table.across_ratio != 1.0 and table.eccentricity_along is None:
        words = 'floors move along the row and rotate; write eccentricity_along too, such as "1 m", or remove it'
        raise Several([(("across_ratio",), words)])
    return table


PLAN = Key(
    "Floors that rotate: elastic storeys whose centre of stiffness is not that of mass, under one component of ground "
    "motion, or two; one plan for all floors, or a list with one for each, from the ground up.",
    _plans,
    EXAMPLE,
    "floors move along the row alone",
    write=lambda tables: tables[0].written() if len(tables) == 1 else [table.written() for table in tables],
    schema={"anyOf": [{"$ref": "#/$defs/PlanTable"}, {"type": "array", "items": {"$ref": "#/$defs/PlanTable"}}]},
)


def plan_checks(draft: Draft) -> Iterator[Fault]:
    """What floors that move across the row need: both horizontals, and one ground under all buildings."""
    buildings = draft.tables("building")
    moving = [keys for keys in buildings if any(plan.eccentricity_along is not None for plan in keys.get("plan", ()))]
    if not moving:
        return
    name = moving[0].raw.get("name", "a building")
    if "direction" not in draft.table("records"):
        words = f"{name} moves across the row too (plan.eccentricity_along), under both horizontals of each recording"
        repair = 'write direction, that of the row, such as direction = "30 deg", or remove eccentricity_along'
        yield Fault(("records", "direction"), f"{words}; {repair}", absent=True)
    given_keys = [(keys.path, key) for keys in buildings for key in keys.raw if key.startswith("ground_")]
    given_keys += [(("effects",), "wave_passage")] if "wave_passage" in draft.table("effects").raw else []
    for path, key in given_keys:
        yield Fault((*path, key), f"is not computed where a building moves across the row, as {name} does; remove it")
