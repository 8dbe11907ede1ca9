"""Inline tables of a building: isolators under its slab, the law by which its storeys yield, plans of its floors."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Any

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.hysteresis import RULES, Hysteresis
from pounding_risk.models.structures.isolation import YIELD_DISPLACEMENT, Isolators
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
    one_of,
)
from pounding_risk.scene.not_modelled import RULES_ELSEWHERE
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import FLOOR_MASS, STIFFNESS, STOREY_HEIGHT, Quantity, exact, shown

# ------------------------------------------------------------------------------------------------------------ isolation
LENGTH = Quantity("m", 0.0, inf, "radius of a pendulum", open_low=True, open_high=True, example="2.2 m")
# Below it the slab vibrates so fast before it yields that a record takes hours.
YIELDING = LENGTH._replace(low=1e-8, open_low=False, words="yield displacement of isolators", example="10 mm")
STRENGTH = Quantity("N", 0.0, inf, "characteristic strength", open_high=True, example="900 kN")
FRICTION = Quantity("1", 0.0, 1.0, "coefficient of friction", example="0.05")
DASHPOT = Quantity("N*s/m", 0.0, inf, "dashpot", open_high=True, example="200 kN s/m")
BEARINGS, SLIDERS = ("strength", "stiffness"), ("friction", "radius")
ISOLATION_EXAMPLE = (
    '{slab_mass = "600 t", height = "1.5 m", strength = "900 kN", stiffness = "5 MN/m", yield_displacement = "10 mm"}'
)


class Isolation(Table):
    """Isolators under a building, all of them together, and the slab on them.

    Bilinear with kinematic hardening: by ``strength`` and ``stiffness``, as lead-rubber bearings have them, or by
    ``friction`` and ``radius`` of friction pendulums and the weight of the slab and all floors.
    """

    slab_mass: float = measured(
        FLOOR_MASS._replace(low=1.0, open_low=False), "Mass of the slab on the isolators.", '"600 t"'
    ).required()
    height: float = measured(
        STOREY_HEIGHT, "Height of the slab above the ground, as of a moat wall around it.", '"1.5 m"'
    ).required()
    strength: float | None = measured(
        STRENGTH,
        "Characteristic strength: force at zero displacement on the branch that yields; 0 for linear isolators.",
        absent="friction times the weight",
    ).defaults_to(None)
    stiffness: float | None = measured(
        STIFFNESS, "Stiffness past yield.", '"5 MN/m"', "the weight over radius"
    ).defaults_to(None)
    friction: float | None = measured(
        FRICTION, "Coefficient of friction of pendulums, the same at every speed.", absent="strength is given"
    ).defaults_to(None)
    radius: float | None = measured(LENGTH, "Radius of the sliding surface.", absent="stiffness is given").defaults_to(
        None
    )
    yield_displacement: float = measured(
        YIELDING,
        "Displacement at yield: before it the stiffness is that past yield plus strength over this.",
        absent='"1 mm"',
    ).defaults_to(YIELD_DISPLACEMENT)
    damping: float = measured(DASHPOT, "Dashpot between slab and ground.", absent="none").defaults_to(0.0)

    @classmethod
    def of(cls, isolators: Isolators) -> Any:
        """The table of isolators, with every value that they have."""
        return cls.from_values({key: parameter for key, parameter in vars(isolators).items() if parameter is not None})

    def isolators(self) -> Isolators:
        """The isolators as buildings of `models.structures` have them."""
        return Isolators(**vars(self))


def _isolation(value: Any, number: Number) -> Isolation:
    """A table that says strength and stiffness, or friction and radius."""
    table: Isolation = inline(Isolation, "isolation", value, number, ISOLATION_EXAMPLE)
    keys = [key for key in (*BEARINGS, *SLIDERS) if getattr(table, key) is not None]
    full_pair = next((pair for pair in (BEARINGS, SLIDERS) if set(pair) <= set(keys)), ())
    if full_pair:
        words = f"{' and '.join(full_pair)} are given, and say it already; remove one or the other"
        excess: list[tuple[KeyPath, str]] = [((key,), words) for key in keys if key not in full_pair]
        if excess:
            raise Several(excess)
        return table
    wanted_pair = SLIDERS if keys and set(keys) <= set(SLIDERS) else BEARINGS
    missing = next(key for key in wanted_pair if key not in keys)
    rest = "friction and radius, of pendulums" if wanted_pair == BEARINGS else "strength and stiffness, of bearings"
    sentence = Isolation.keys()[missing].lacks(missing)
    raise Several([((missing,), f"{sentence}; isolators have {' and '.join(wanted_pair)}, or {rest}")])


ISOLATION = Key(
    "Isolators under the building, with a slab on them: its storey 1 and floor 1.",
    _isolation,
    ISOLATION_EXAMPLE,
    "the building stands on the ground",
    write=lambda table: table.written(),
    schema={"$ref": "#/$defs/IsolationTable"},
)


# ----------------------------------------------------------------------------------------------------------- hysteresis
MULTIPLE = Quantity("1", 0.0, inf, "multiple of yield", open_low=True, open_high=True, example="4.0")
SHARE = Quantity("1", 0.0, 1.0, "share", open_low=True, example="0.3")
UNLOADING = Quantity("1", 0.0, 1.0, "exponent of unloading", open_high=True, example="0.4")
CAPACITY = MULTIPLE._replace(words="energy over yield shear times yield drift", example="60")
EXPONENT = MULTIPLE._replace(words="exponent", example="1.0")
SHARPNESS = Quantity("1", 1.0, 20.0, "exponent of Bouc and Wen", example="2")
LOSS = Quantity("1", 0.0, inf, "degradation", open_high=True, example="0.01")
HYSTERESIS_EXAMPLE = (
    '{rule = "peak_oriented", backbone = [[4.0, 1.15], [12.0, 0.3]], unloading = 0.4, energy_capacity = 60}'
)
_POINTS = "points past yield, each [drift, shear] in multiples of those at yield, such as [[4.0, 1.15], [12.0, 0.3]]"

OF_STOREYS = {name: rule for name, rule in RULES.items() if rule.USE == "storey"}
RULE = one_of(
    list(OF_STOREYS),
    "a rule of hysteresis",
    "What follows a turn: " + "; ".join(f"{name}: {rule.WORDS}" for name, rule in OF_STOREYS.items()) + ".",
    '"peak_oriented"',
    missing=f'missing; write rule = "peak_oriented", or another of {", ".join(OF_STOREYS)}',
    elsewhere=RULES_ELSEWHERE,
)


def _backbone(value: Any, number: Number) -> tuple[tuple[float, float], ...]:
    points = list_of(value, _POINTS)
    if not all(isinstance(point, list | tuple) and len(point) == 2 for point in points):
        raise Unreadable(f"{shown(value)} is no backbone; write {_POINTS}")
    return tuple((number(drift, MULTIPLE), number(shear, MULTIPLE)) for drift, shear in points)


class HysteresisTable(Table):
    """How the storeys of a building yield under the effect `inelastic_storeys`: a backbone and a rule.

    Numbers are multiples of each storey's yield drift, storey_strengths over storey_stiffnesses, and yield shear.
    """

    rule: str = RULE.required()
    backbone: tuple[tuple[float, float], ...] = Key(
        "Points of the backbone past yield, [drift, shear] each, the same in both directions; past the last one "
        "the shear stays.",
        _backbone,
        "[[4.0, 1.15], [12.0, 0.3]]",
        "a straight line by hardening of inelastic_storeys",
        write=lambda points: [list(point) for point in points],
        schema={"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
    ).defaults_to(())
    pinching_drift: float = measured(
        SHARE,
        "Of peak_oriented: how far from the start of reloading to the elastic line through its target the pinch "
        "point lies; the smaller, the earlier the storey stiffens again.",
        "0.5",
        "1",
    ).defaults_to(1.0)
    pinching_force: float = measured(
        SHARE, "Of peak_oriented: shear at the pinch point over that at the target.", absent="no pinching"
    ).defaults_to(1.0)
    unloading: float = measured(
        UNLOADING,
        "Of peak_oriented: exponent with which the stiffness of unloading falls with ductility.",
        absent="0, the elastic stiffness",
    ).defaults_to(0.0)
    energy_capacity: float = measured(
        CAPACITY,
        "Of peak_oriented: energy that a storey dissipates until it has no strength left, over its yield shear "
        "times its yield drift; strength falls with each half cycle.",
        absent="strength is kept",
    ).defaults_to(inf)
    energy_exponent: float = measured(
        EXPONENT, "Of peak_oriented: exponent c of the loss of strength.", "1.5", "1"
    ).defaults_to(1.0)
    exponent: float = measured(
        SHARPNESS, "Of bouc_wen: exponent n, the sharpness of the knee.", absent="1"
    ).defaults_to(1.0)
    beta: float = measured(
        SHARE._replace(example="0.5"), "Of bouc_wen: β, by which unloading is stiffer.", absent="0.5"
    ).defaults_to(0.5)
    delta_a: float = measured(
        LOSS, "Of bouc_wen: loss of A with the energy taken over that at yield.", "0.005", "0"
    ).defaults_to(0.0)
    delta_nu: float = measured(LOSS, "Of bouc_wen: growth of ν, loss of strength.", absent="0").defaults_to(0.0)
    delta_eta: float = measured(LOSS, "Of bouc_wen: growth of η, loss of stiffness.", "0.02", "0").defaults_to(0.0)
    collapse_drift: float = measured(
        SHARE._replace(words="drift over height", example="0.1"),
        "Drift over storey height at which a storey has collapsed and its run ends.",
        absent="0.2",
    ).defaults_to(0.2)

    @classmethod
    def of(cls, hysteresis: Hysteresis) -> Any:
        """The table of a law, with the values that differ from the defaults."""
        preset = {key: info.default for key, info in cls.model_fields.items()}
        return cls.from_values({key: value for key in preset if (value := getattr(hysteresis, key)) != preset[key]})

    def law(self) -> Hysteresis:
        """The hysteresis as storeys of `models.structures` have it."""
        return Hysteresis(**vars(self))


def _hysteresis(value: Any, number: Number) -> HysteresisTable:
    """A table whose backbone and parameters are those of its rule."""
    table: HysteresisTable = inline(HysteresisTable, "hysteresis", value, number, HYSTERESIS_EXAMPLE)
    keys_of_rule = ("rule", "backbone", "collapse_drift", *RULES[table.rule].OPTIONS)
    takers = {key: name for name, rule in RULES.items() for key in rule.OPTIONS}
    faults: list[tuple[KeyPath, str]] = [
        ((key,), f'rule = "{table.rule}" has no {key}; remove it, or write rule = "{takers[key]}"')
        for key in table.key_names()
        if key not in keys_of_rule and getattr(table, key) != HysteresisTable.model_fields[key].default
    ]
    try:
        table.law()
    except PoundingError as error:
        faults.append((("backbone",), str(error).removeprefix("backbone: ")))
    if faults:
        raise Several(faults)
    return table


HYSTERESIS = Key(
    "How its storeys yield under inelastic_storeys: a backbone of several branches, and what follows a turn.",
    _hysteresis,
    HYSTERESIS_EXAMPLE,
    "bilinear, with kinematic hardening",
    write=lambda table: table.written(),
    schema={"$ref": "#/$defs/HysteresisTable"},
)


# ----------------------------------------------------------------------------------------------------------------- plan
ACROSS = Quantity("m", -inf, inf, "place across the row", example="-8 m")
GYRATION = Quantity("m", 0.0, inf, "radius of gyration", open_low=True, open_high=True, example="6.5 m")
RATIO = Quantity("1", 0.0, 100.0, "ratio of two frequencies", open_low=True, example="1.1")
PLAN_EXAMPLE = '{face = ["-8 m", "8 m"], eccentricity = "1.5 m", gyration = "6.5 m", torsional_ratio = 1.1}'


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
        """The table of a plan, with the values that differ from the defaults."""
        preset = {key: info.default for key, info in cls.model_fields.items()} | {"centre": 0.5 * sum(plan.face)}
        return cls.from_values(
            {key: parameter for key, parameter in plan._asdict().items() if parameter != preset[key]}
        )

    def plan(self) -> Plan:
        """The plan as buildings of `models.structures` have it."""
        centre = 0.5 * sum(self.face) if self.centre is None else self.centre
        return Plan(**vars(self) | {"centre": centre})


def _plans(value: Any, number: Number) -> tuple[PlanTable, ...]:
    """One table for all floors, or a list with one for each; all of them move across the row, or none does."""
    if not isinstance(value, list | tuple):
        return (_plan(value, number),)
    example = f"[{PLAN_EXAMPLE}, ...], one for each floor from the ground up"
    tables = tuple(each(list_of(list(value), example), lambda item: _plan(item, number)))
    moves_across = [table.eccentricity_along is not None for table in tables]
    if any(moves_across) and not all(moves_across):
        words = 'is missing here, and stands in other plans of the building; write it in all, such as "0 m", or in none'
        raise Several([((moves_across.index(False), "eccentricity_along"), words)])
    return tables


def _plan(value: Any, number: Number) -> PlanTable:
    """A table whose centre of mass lies within the face."""
    table: PlanTable = inline(PlanTable, "plan", value, number, PLAN_EXAMPLE)
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
    PLAN_EXAMPLE,
    "floors move along the row alone",
    write=lambda tables: tables[0].written() if len(tables) == 1 else [table.written() for table in tables],
    schema={"anyOf": [{"$ref": "#/$defs/PlanTable"}, {"type": "array", "items": {"$ref": "#/$defs/PlanTable"}}]},
)


def plan_checks(draft: Draft) -> Iterator[Fault]:
    """The faults of floors that move across the row: they need both horizontals, and one ground under all buildings."""
    buildings = draft.tables("building")
    movers = [keys for keys in buildings if any(plan.eccentricity_along is not None for plan in keys.get("plan", ()))]
    if not movers:
        return
    name = movers[0].raw.get("name", "a building")
    if "direction" not in draft.table("records"):
        words = f"{name} moves across the row too (plan.eccentricity_along), under both horizontals of each recording"
        repair = 'write direction, that of the row, such as direction = "30 deg", or remove eccentricity_along'
        yield Fault(("records", "direction"), f"{words}; {repair}", absent=True)
    given_keys = [(keys.path, key) for keys in buildings for key in keys.raw if key.startswith("ground_")]
    given_keys += [(("effects",), "wave_passage")] if "wave_passage" in draft.table("effects").raw else []
    for path, key in given_keys:
        yield Fault((*path, key), f"is not computed where a building moves across the row, as {name} does; remove it")
