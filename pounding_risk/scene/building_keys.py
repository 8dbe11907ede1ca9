"""What [[building]] tables have in common: keys of several kinds of building, and the classes that all kinds are of."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cache
from inspect import get_annotations
from math import inf
from typing import Any, ClassVar

from pounding_risk import units
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import DAMPING_RULES, MOST_STOREYS, Storeys
from pounding_risk.scene.building_tables import HYSTERESIS, ISOLATION, HysteresisTable, Isolation
from pounding_risk.scene.keys import (
    Key,
    Number,
    Section,
    Table,
    Unreadable,
    each,
    facts,
    flag,
    list_of,
    measured,
    one_of,
    one_or_more,
    text,
    whole_from,
)
from pounding_risk.scene.toml import Fault
from pounding_risk.units import Quantity, exact, shown

INITIAL = ("initial_displacement", "initial_velocity")
LISTS = ("floor_masses", "storey_stiffnesses", "storey_heights", "storey_strengths")
OF_STOREYS = (*LISTS, *INITIAL)  # keys with one value for each storey
# Keys of the ground under a building, and the fields of its support that they are.
OF_GROUND = {f"ground_{field}": field for field in ("factor", "delay", "velocity")} | {"ground_record": "records"}
# Keys that are called otherwise in the buildings that the solvers take.
IN_STRUCTURES = dict(zip(LISTS, ("masses", "stiffnesses", "heights", "strengths"), strict=True))
# A wave takes 0.29 ms through a metre of concrete, so that no building, of period 4 h / c, vibrates faster than in
# 0.1 ms; and none weighs less than a kilogram. Below these limits the work of a run grows without end.
LEAST_PERIOD = 1e-4  # s
BUILDING_PERIOD = units.PERIOD._replace(low=LEAST_PERIOD, open_low=False)
BUILDING_MASS = units.MASS._replace(low=1.0, open_low=False)
HISTORY_EXAMPLE = '["my/frame_RSN6.csv", "my/frame_RSN753.csv"]'
LEAST_FLOOR_MASS = units.FLOOR_MASS._replace(low=1.0, open_low=False)
MISSING_STIFFNESSES = (
    'missing; write storey_stiffnesses = "40 MN/m" for all storeys, a list with one for each, or period = "0.8 s" in '
    "their place"
)


def _storey_values_key(quantity: Quantity, words: str, example: str, absent: str, missing: str = "") -> Key:
    """One value for all storeys, or a list with one for each, from the ground up."""

    def read(value: Any, number: Number) -> tuple[float, ...] | float:
        if not isinstance(value, list):
            return number(value, quantity)
        if len(value) > MOST_STOREYS:
            raise Unreadable(f"the list has {len(value)} values, more than {MOST_STOREYS} storeys; check it")
        values = list_of(value, f"a value for each storey, such as {shown([quantity.example] * 2)}")
        return tuple(each(values, lambda element: number(element, quantity)))

    def write(values: tuple[float, ...] | float) -> Any:
        if isinstance(values, tuple):
            return [exact(float(value), quantity) for value in values]
        return exact(float(values), quantity)

    meaning = f"{words}: a list from the ground up, or one value for all storeys."
    return Key(meaning, read, example, absent, missing, write, {"type": ["string", "array"], **facts(quantity)})


# Keys of some kinds of building; those of all stand in `AnyBuilding`, those of one in its class.
MASS = measured(
    BUILDING_MASS,
    "Its mass.",
    absent="required, unless rigid or of storeys",
    missing='missing; write mass = "44.36 t", or rigid = true',
)
PERIOD = measured(
    BUILDING_PERIOD,
    "Its natural period, on rigid ground and without P-Δ; or write stiffness. Storeys are scaled to it.",
    absent="required, unless stiffness, storeys or rigid",
)
DAMPING = measured(units.DAMPING, "Its viscous damping, as a ratio of critical.", absent="0.05")
HEIGHT = measured(
    units.HEIGHT,
    "Height of its roof above the ground: level of a single mass, or what storeys are generated from.",
    absent="a single mass or wall is as tall as its neighbour",
    missing='missing; write height = "12 m", of the roof above the ground',
)
NO_COUNT = f"is not a count of storeys; write a whole number from 1 to {MOST_STOREYS}, such as 5"
STOREYS = Key(
    "How many storeys, where no list says it.",
    lambda value, number: whole_from(value, 1, MOST_STOREYS, NO_COUNT),
    "4",
    "as many as the lists have values",
    schema={"type": "integer"},
)
DAMPING_RULE = one_of(
    DAMPING_RULES,
    "a rule of damping",
    "How storeys are damped: the same ratio in every mode, by mass and stiffness, or by stiffness alone.",
    '"rayleigh"',
    f'"{DAMPING_RULES[0]}"',
)
FLOOR_MASSES = _storey_values_key(
    LEAST_FLOOR_MASS,
    "Mass of each floor, in place of mass",
    '["210 t", "210 t", "180 t"]',
    "a single mass",
    'missing; write floor_masses = "44 t" for all floors, or a list with one value for each',
)
STOREY_STIFFNESSES = _storey_values_key(
    units.STIFFNESS,
    "Lateral stiffness of each storey; beside period their ratios count alone. Of a building by a matrix or modes "
    "the part of it that yields, with storey_strengths",
    '"350 MN/m"',
    "a single mass; beside period those by which the first mode grows in proportion to height",
    MISSING_STIFFNESSES,
)
STOREY_STRENGTHS = _storey_values_key(
    units.STOREY_STRENGTH, "Yield shear of each storey, for inelastic_storeys", '"1400 kN"', "storeys stay elastic"
)
STOREY_HEIGHTS = _storey_values_key(
    units.STOREY_HEIGHT,
    "Height of each storey",
    '["4 m", "3 m", "3 m"]',
    "a single mass",
    'missing; write storey_heights = "3 m" for all storeys, or a list with one value for each',
)

RIGID = flag("rigid", "true for a wall that moves with the ground.")


def wrong_lengths(keys: Section, names: Iterable[str], count: int, count_text: str) -> Iterator[Fault]:
    """Faults for lists of a building that have not one value for each of its ``count`` storeys."""
    for key in names:
        length = len(keys.raw[key]) if isinstance(keys.raw.get(key), list) else 0
        if length not in (0, count):
            yield keys.fault(
                key,
                f"{length} value{'s' * (length != 1)} for {count_text}; write one for each storey, from the ground up, "
                "or one value for all",
            )


def wrong_initial(keys: Section, count: int, count_text: str) -> Iterator[Fault]:
    """Faults for lists of initial states and plans without one for each floor; a slab on isolators is a floor too."""
    words = f"{count_text} and the slab on the isolators" if "isolation" in keys else count_text
    return wrong_lengths(keys, (*INITIAL, "plan"), count + ("isolation" in keys), words)


class AnyBuilding(Table):
    """A [[building]] table of any kind, with the keys that all kinds have.

    A kind of building is a class below with its own keys and a `structure`. A key without a field of the structure
    raises TypeError there, and AttributeError in `table_of`, so that no key is lost between a file and a scene.
    """

    repair: ClassVar[str]  # for a key that this kind of building does not take
    has_storeys: ClassVar[bool] = False
    # Keys that a structure does not hold: its other fields say the same, and the depth is written beside it.
    implied: ClassVar[frozenset[str]] = frozenset({"rigid", "floor_depth"})

    name: str = text("What tables and figures call the building; each has its own.", "frame").required()
    floor_depth: float | None = measured(
        FLOOR_DEPTH,
        "Depth of its floors below their levels; with it floors of neighbours that overlap in height meet floor to "
        "floor, others meet columns.",
        '"0.3 m"',
        "0.25 m, a slab of 6 m span (ACI 318-19, table 7.3.1.1: span / 24); a quarter of the lowest storey at most",
    ).defaults_to(None)
    rigid: bool = RIGID.defaults_to(False)
    ground_factor: float = measured(
        units.GROUND_FACTOR,
        "Factor on the ground motion under it: -1 reverses it, 0 is ground that does not shake.",
        absent="1",
    ).defaults_to(1.0)
    ground_delay: float = measured(
        units.GROUND_DELAY,
        "How much later the ground motion reaches it than the building that is reached first, which has none. A "
        "run lasts until the last building has had the whole motion.",
        absent="at once",
    ).defaults_to(0.0)
    ground_velocity: float = measured(
        units.GROUND_VELOCITY,
        "Velocity of the ground under it when the record begins; initial displacement and velocity are relative to it.",
        absent="ground that rests",
    ).defaults_to(0.0)
    ground_record: tuple[str, ...] = one_or_more(
        'names no record; write a file, such as "my/record.AT2", an id of the catalogue, a generated motion, or a '
        "list with one of these for each record of the scene",
        "A record of its own under it: a file, an id of the catalogue or a generated motion as text, for all "
        "records of the scene, or a list with one for each of them. It is processed as they are, and scaled by the "
        "factor of the record that it stands beside.",
        '"my/other_station.AT2"',
        "the records of the scene",
    ).defaults_to(())

    @classmethod
    @cache
    def keys(cls) -> dict[str, Key]:
        """The declarations of its keys by name: the name, the kind's own keys, then those of more kinds."""
        keys = super().keys()
        order = (key for kind in cls.__mro__ for key in get_annotations(kind))
        return {key: keys[key] for key in dict.fromkeys(("name", *order)) if key in keys}

    def by_floor(self, key: str, count: int) -> tuple[float, ...]:
        """The values of a key that has one for each of ``count`` storeys, or one for all."""
        by_storey = getattr(self, key)
        return by_storey if isinstance(by_storey, tuple) else (by_storey,) * count

    def fields(self) -> dict[str, Any]:
        """The values of its keys under the names of a structure's fields."""
        settings = {key: getattr(self, key) for key in self.keys() if key not in self.implied}
        support = Support(**{field: settings.pop(key) for key, field in OF_GROUND.items()})
        return {IN_STRUCTURES.get(key, key): setting for key, setting in settings.items()} | {"support": support}

    def structure(self) -> Building | Storeys:
        """The building as the solvers take it; raises PoundingError for numbers that no building has."""
        raise NotImplementedError

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """The faults that more than one key of the building takes part in."""
        return iter(())


class MovingBuilding(AnyBuilding):
    """A building that moves relative to the ground."""

    initial_displacement: tuple[float, ...] | float = _storey_values_key(
        units.INITIAL_DISPLACEMENT,
        "Displacement of each floor relative to the ground when the motion begins",
        '["10 mm", "20 mm"]',
        "at rest",
    ).defaults_to(())
    initial_velocity: tuple[float, ...] | float = _storey_values_key(
        units.INITIAL_VELOCITY,
        "Velocity of each floor relative to the ground when the motion begins",
        '"0.5 m/s"',
        "at rest",
    ).defaults_to(())
    displacement_history: tuple[str, ...] = one_or_more(
        f"names no file; write a list with one for each record of the scene, such as {HISTORY_EXAMPLE}, each with "
        "the columns time [s], floor 1 [mm], floor 2 [mm] and so on",
        "Displacement of each floor relative to the ground without contact, from a model of your own, in place of "
        "the motion that is computed: a CSV file with the columns time [s], floor 1 [mm], floor 2 [mm] and so on "
        "for each record of the scene, in their order. No contact is run then.",
        HISTORY_EXAMPLE,
        "the motion is computed",
    ).defaults_to(())


class WithFloors(MovingBuilding):
    """A building of several floors, on the ground or on isolators."""

    implied = MovingBuilding.implied | {"isolation", "hysteresis"}

    column_strength: float = measured(
        units.COLUMN_STRENGTH,
        "Force at which its columns yield where a neighbour's floor strikes them, in place of column_yield_force "
        "of the interface.",
        absent="column_yield_force of the interface",
    ).defaults_to(inf)
    hysteresis: HysteresisTable | None = HYSTERESIS.defaults_to(None)
    isolation: Isolation | None = ISOLATION.defaults_to(None)

    def completed(self, bare_building: Storeys) -> Storeys:
        """The building on its isolators, with its initial state."""
        building = bare_building if self.isolation is None else bare_building.isolated(self.isolation.isolators())
        initial: dict[str, Any] = {key: self.by_floor(key, len(building.masses)) for key in INITIAL}
        return replace(building, **initial, hysteresis=None if self.hysteresis is None else self.hysteresis.law())
