"""The [[building]] tables of a scene: a rigid wall, one mass, storeys by their numbers, or storeys of a typology.

What the keys of a table make together is checked on the tables as written, whatever else is wrong with the scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import pi, sqrt
from typing import Any

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys, generated
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.scene.toml import Fault, tables
from pounding_risk.units import (
    FLOOR_LENGTH,
    FLOOR_MASS,
    HEIGHT,
    MASS,
    PERIOD,
    STIFFNESS,
    STOREY_HEIGHT,
    STOREY_STRENGTH,
    WAVE_SPEED,
    Quantity,
    exact,
    shown,
)

# A wave takes 0.29 ms through a metre of concrete, so that no building, of 4 h / c, vibrates faster than in 0.1 ms; and
# what weighs less than a kilogram is none. The work of a run grows with both, without end.
LEAST_PERIOD = 1e-4  # s
BUILDING_PERIOD = PERIOD._replace(low=LEAST_PERIOD, open_low=False)
BUILDING_MASS = MASS._replace(low=1.0, open_low=False)
LEAST_FLOOR_MASS = FLOOR_MASS._replace(low=1.0, open_low=False)

RIGID, MASS_ALONE, STOREYS, GENERATED = "rigid", "mass", "storeys", "generated"
LISTS = ("floor_masses", "storey_stiffnesses", "storey_heights")  # what tells the storeys, each a list or one value
OF_TYPOLOGY = ("height", "storeys", "typology", "floor_mass")
OF_ALL = ("rigid", "floor_depth")
# The keys that each kind of building takes beside its name; of those that it does not take, and what to do about them.
TAKES: Mapping[str, tuple[str, ...]] = {
    RIGID: (*OF_ALL, "mass", "height"),
    MASS_ALONE: (*OF_ALL, "mass", "period", "stiffness", "damping", "floor_length", "wave_speed", "height"),
    STOREYS: (*OF_ALL, *LISTS, "storeys", "damping", "damping_rule", "storey_strengths"),
    GENERATED: (*OF_ALL, *OF_TYPOLOGY, "period", "damping", "damping_rule"),
}
KEYS = tuple(dict.fromkeys(key for keys in TAKES.values() for key in keys))
REPAIRS = {
    RIGID: "a rigid building moves with the ground and has no {key}; remove {key}, or rigid = true",
    MASS_ALONE: "a building of one mass has no {key}; remove {key}, or write floor_masses, storey_stiffnesses and "
    "storey_heights in place of mass and period",
    STOREYS: "a building with floor_masses, storey_stiffnesses and storey_heights takes no {key}; remove {key}, "
    "or these",
    GENERATED: "a building generated from its typology takes no {key}; remove {key}, or write floor_masses, "
    "storey_stiffnesses and storey_heights in place of typology and floor_mass",
}
ABSENT = {
    "floor_masses": 'missing; write floor_masses = "44 t" for all floors, or a list with one value for each',
    "storey_stiffnesses": 'missing; write storey_stiffnesses = "40 MN/m" for all storeys, or a list with one for each',
    "storey_heights": 'missing; write storey_heights = "3 m" for all storeys, or a list with one value for each',
    "height": 'missing; write height = "12 m", of the roof above the ground',
    "storeys": "missing; write storeys = 4",
    "typology": f'missing; write typology = "concrete_frame", or another of {", ".join(TYPOLOGIES)}',
    "floor_mass": 'missing; write floor_mass = "200 t", of every floor',
}


def kind_of(keys: Mapping[str, Any]) -> str:
    """What a table is of, by the keys that it has."""
    if keys.get("rigid") is True:
        return RIGID
    if any(key in keys for key in LISTS):
        return STOREYS
    if "typology" in keys or "floor_mass" in keys or ("storeys" in keys and "mass" not in keys):
        return GENERATED
    return MASS_ALONE


def has_storeys(keys: Mapping[str, Any]) -> bool:
    """True for a table of a building with more than a mass, even one of a single storey."""
    return kind_of(keys) in (STOREYS, GENERATED)


def building_checks(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """All faults that more than one key of the buildings takes part in."""
    buildings = tables(raw, "building")
    first: dict[str, int] = {}
    for index, keys in buildings:
        name = keys.get("name")
        if isinstance(name, str) and name and first.setdefault(name, index) != index:
            yield Fault(
                ("building", index, "name"),
                f"{shown(name)} is the name of building {first[name] + 1} too; give every building a name of its own",
            )
        yield from _of_one(index, keys)
    count = len(raw["building"]) if isinstance(raw.get("building"), list) else 2
    if count < 2:
        yield Fault(
            ("building",),
            f"{count} building{'s' * (count != 1)}: a scene has two, left and right; "
            "write a second [[building]] (rigid = true for a wall that moves with the ground)",
        )
    yield from _walls(buildings, count)


def _walls(buildings: list[tuple[int, dict[str, Any]]], count: int) -> Iterator[Fault]:
    """Faults for neighbours that are both rigid: neither moves against the other."""
    rigid = {index for index, keys in buildings if keys.get("rigid") is True}
    if count == 2 and len(rigid) == 2:
        yield Fault(
            ("building", 1, "rigid"),
            "both buildings are rigid, so that no run is needed; give one of them a mass and a period",
        )
        return
    for index in sorted(rigid & {index + 1 for index in rigid}):
        yield Fault(
            ("building", index, "rigid"),
            "its left neighbour is rigid too, and two walls never meet; write both as one, or give one a mass and a "
            "period",
        )


def _of_one(index: int, keys: Mapping[str, Any]) -> Iterator[Fault]:
    """What one building has too much and too little of."""
    base, kind = ("building", index), kind_of(keys)
    for key in KEYS:
        if key in keys and key not in TAKES[kind]:
            yield Fault((*base, key), REPAIRS[kind].format(key=key))
    if kind == MASS_ALONE:
        yield from _of_a_mass(base, keys)
    if kind == STOREYS:
        yield from (Fault((*base, key), ABSENT[key], absent=True) for key in LISTS if key not in keys)
        yield from _lengths(base, keys)
    if kind == GENERATED:
        yield from (Fault((*base, key), ABSENT[key], absent=True) for key in OF_TYPOLOGY if key not in keys)


def _of_a_mass(base: tuple[str, int], keys: Mapping[str, Any]) -> Iterator[Fault]:
    """Exactly one of period and stiffness says how a mass vibrates."""
    if "wave_speed" in keys and "floor_length" not in keys:
        yield Fault(
            (*base, "wave_speed"), 'acts along a floor of known length; write floor_length = "20 m", or remove it'
        )
    if "period" in keys and "stiffness" in keys:
        yield Fault(
            (*base, "stiffness"),
            "period and stiffness are both given, and one follows from the other; remove one",
        )
    if "mass" not in keys:
        yield Fault((*base, "mass"), 'missing; write mass = "44.36 t", or rigid = true', absent=True)
    if "period" not in keys and "stiffness" not in keys:
        yield Fault(
            (*base, "period"),
            'missing; write period = "0.208 s", or stiffness = "40.5 MN/m", or rigid = true',
            absent=True,
        )


def _lengths(base: tuple[str, int], keys: Mapping[str, Any]) -> Iterator[Fault]:
    """Lists that have not one value for each storey."""
    lengths = {key: len(keys[key]) for key in (*LISTS, "storey_strengths") if isinstance(keys.get(key), list)}
    count = keys.get("storeys", next(iter(lengths.values()), None))
    if count is None:
        yield Fault((*base, "storeys"), "missing; write storeys = 4, or a list with one value for each storey", True)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        return
    told = f"storeys = {count}" if "storeys" in keys else f"{count} {next(iter(lengths), 'storeys')}"
    for key, length in lengths.items():
        if length != count and length:
            yield Fault(
                (*base, key),
                f"{length} value{'s' * (length != 1)} for {told}; write one for each storey, from the ground up, "
                "or one value for all",
            )


def building_of(table: Any) -> Building | Storeys:
    """The building of a table without a fault.

    Raises PoundingError for a height that its code's period is not for, and for what vibrates faster than a building.
    """
    building = _building_of(table)
    periods = _own_periods(building)
    if periods and min(periods) < LEAST_PERIOD:
        place = "" if isinstance(building, Building) else f"floor {periods.index(min(periods)) + 1} on its storeys "
        raise PoundingError(
            f"{place}would vibrate with a period of {min(periods):.3g} s, and none of a building is below "
            f"{LEAST_PERIOD:g} s; check mass and stiffness, and their units"
        )
    return building


def _own_periods(building: Building | Storeys) -> list[float]:
    """Of each mass on the springs beside it, its neighbours held: no mode of the building is slower than the least."""
    if isinstance(building, Building):
        return [] if building.is_rigid else [building.period]
    springs = [*building.stiffnesses, 0.0]
    pairs = zip(building.masses, pairwise(springs), strict=True)
    return [2.0 * pi * sqrt(mass / (below + above)) for mass, (below, above) in pairs]


def _building_of(table: Any) -> Building | Storeys:
    """The building of a table, whatever its numbers."""
    kind = kind_of({key: getattr(table, key) for key in table.model_fields_set})
    if kind == RIGID:
        return Building.rigid(table.name, table.mass)._replace(height=table.height)
    if kind == MASS_ALONE:
        period = table.period or 2.0 * pi * sqrt(table.mass / table.stiffness)
        lengths = table.floor_length, table.wave_speed
        return Building(table.name, table.mass, period, table.damping, *lengths, table.height)
    if kind == GENERATED:
        return generated(
            table.name,
            height=table.height,
            storeys=table.storeys,
            typology=table.typology,
            floor_mass=table.floor_mass,
            period=table.period or None,
            damping=table.damping,
            damping_rule=table.damping_rule,
        )
    lists = [getattr(table, key) for key in (*LISTS, "storey_strengths")]
    count = table.storeys or next(len(values) for values in lists if isinstance(values, tuple) and values)
    masses, stiffnesses, heights, strengths = (
        values if isinstance(values, tuple) else (values,) * count for values in lists
    )
    return Storeys(table.name, masses, stiffnesses, heights, table.damping, table.damping_rule, strengths)


def building_table(building: Building | Storeys) -> dict[str, Any]:
    """The building as a scene file has it: every value stated, exact."""
    if isinstance(building, Storeys):
        return _storeys_table(building)
    height = {"height": exact(building.height, HEIGHT)} if building.height > 0.0 else {}
    if building.is_rigid:
        mass = {"mass": exact(building.mass, MASS)} if MASS.allows(building.mass) else {}
        return {"name": building.name, "rigid": True, **mass, **height}
    return {
        "name": building.name,
        "mass": exact(building.mass, MASS),
        "period": exact(building.period, PERIOD),
        "damping": building.damping,
        **_floor(building),
        **height,
    }


def _floor(building: Building) -> dict[str, Any]:
    """The floor's length and wave speed, where it has a length."""
    if building.floor_length == 0.0:
        return {}
    lengths = exact(building.floor_length, FLOOR_LENGTH), exact(building.wave_speed, WAVE_SPEED)
    return dict(zip(("floor_length", "wave_speed"), lengths, strict=True))


def _storeys_table(building: Storeys) -> dict[str, Any]:
    def listed(values: tuple[float, ...], quantity: Quantity) -> list[Any]:
        return [exact(value, quantity) for value in values]

    strengths = {"storey_strengths": listed(building.strengths, STOREY_STRENGTH)} if building.strengths else {}
    return {
        "name": building.name,
        "floor_masses": listed(building.masses, FLOOR_MASS),
        "storey_stiffnesses": listed(building.stiffnesses, STIFFNESS),
        "storey_heights": listed(building.heights, STOREY_HEIGHT),
        "damping": building.damping,
        "damping_rule": building.damping_rule,
        **strengths,
    }
