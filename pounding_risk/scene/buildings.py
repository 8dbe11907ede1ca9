"""The [[building]] tables of a scene: a mass, a rigid wall, storeys or a typology, floors by a matrix or by modes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from inspect import get_annotations
from itertools import accumulate, permutations
from math import inf, pi, sqrt
from typing import Annotated, Any, ClassVar

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.matrices import assembled, condensed, condensed_masses, symmetric
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED, Building
from pounding_risk.models.structures.storeys import (
    BY_MATRIX,
    DAMPING_RULES,
    MOST_STOREYS,
    Storeys,
    generated,
    stiffnesses_for,
)
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.scene.hysteresis import HYSTERESIS, HysteresisTable
from pounding_risk.scene.isolation import ISOLATION, Isolation
from pounding_risk.scene.keys import (
    REQUIRED,
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
)
from pounding_risk.scene.matrices import MODES, OF_DASHPOTS, OF_MASSES, OF_STIFFNESS, matrix_key
from pounding_risk.scene.plan import PLAN, PlanTable, plans_of, tables_of
from pounding_risk.scene.toml import Fault
from pounding_risk.units import (
    COLUMN_STRENGTH,
    DAMPING,
    FLOOR_LENGTH,
    FLOOR_MASS,
    GROUND_DELAY,
    GROUND_FACTOR,
    GROUND_VELOCITY,
    HEIGHT,
    INITIAL_DISPLACEMENT,
    INITIAL_VELOCITY,
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
HISTORY_EXAMPLE = '["my/frame_RSN6.csv", "my/frame_RSN753.csv"]'
LEAST_FLOOR_MASS = FLOOR_MASS._replace(low=1.0, open_low=False)

MISSING_STIFFNESSES = (
    'missing; write storey_stiffnesses = "40 MN/m" for all storeys, a list with one for each, or period = "0.8 s" in '
    "their place"
)


def _storeyed(quantity: Quantity, words: str, example: str, absent: str, missing: str = "") -> Key:
    """One value for all storeys, or a list with one for each, from the ground up."""
    usual = shown([quantity.example] * 2)

    def read(value: Any, number: Number) -> tuple[float, ...] | float:
        if not isinstance(value, list):
            return number(value, quantity)
        if len(value) > MOST_STOREYS:
            raise Unreadable(f"the list has {len(value)} values, more than {MOST_STOREYS} storeys; check it")
        values = list_of(value, f"a value for each storey, such as {usual}")
        return tuple(each(values, lambda item: number(item, quantity)))

    def write(values: tuple[float, ...] | float) -> Any:
        if isinstance(values, tuple):
            return [exact(float(value), quantity) for value in values]
        return exact(float(values), quantity)

    meaning = f"{words}: a list from the ground up, or one value for all storeys."
    return Key(meaning, read, example, absent, missing, write, {"type": ["string", "array"], **facts(quantity)})


def _storey_count(value: Any, number: Number) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST_STOREYS:
        raise Unreadable(
            f"{shown(value)} is not a count of storeys; write a whole number from 1 to {MOST_STOREYS}, such as 5"
        )
    return value


def _row_numbers(value: Any, number: Number) -> tuple[int, ...]:
    rows = tuple(list_of(value, "rows of the floors, such as [3, 6]"))
    if not all(type(row) is int and row > 0 for row in rows) or len(set(rows)) < len(rows):
        raise Unreadable(f"{shown(value)} does not name rows; write whole numbers from 1 on, each once")
    return rows


# Keys of some kinds of building; those of all stand in `AnyBuilding`, those of one in its class.
Mass = Annotated[
    float,
    measured(
        BUILDING_MASS,
        "Its mass.",
        '"44.36 t"',
        "required, unless rigid or of storeys",
        'missing; write mass = "44.36 t", or rigid = true',
    ),
]
Period = Annotated[
    float,
    measured(
        BUILDING_PERIOD,
        "Its natural period, on rigid ground and without P-Δ; or write stiffness. Storeys are scaled to it.",
        '"0.208 s"',
        "required, unless stiffness, storeys or rigid",
    ),
]
Damping = Annotated[float, measured(DAMPING, "Its viscous damping, as a ratio of critical.", "0.05", "0.05")]
Height = Annotated[
    float,
    measured(
        HEIGHT,
        "Height of its roof above the ground: level of a single mass, or what storeys are generated from.",
        '"12 m"',
        "a single mass or wall is as tall as its neighbour",
        'missing; write height = "12 m", of the roof above the ground',
    ),
]
StoreyCount = Annotated[
    int,
    Key(
        "How many storeys, where no list says it.",
        _storey_count,
        "4",
        "as many as the lists have values",
        schema={"type": "integer"},
    ),
]
DampingRule = Annotated[
    str,
    one_of(
        DAMPING_RULES,
        "a rule of damping",
        "How storeys are damped: the same ratio in every mode, by mass and stiffness, or by stiffness alone.",
        '"rayleigh"',
        f'"{DAMPING_RULES[0]}"',
    ),
]
FloorMasses = Annotated[
    tuple[float, ...] | float,
    _storeyed(
        LEAST_FLOOR_MASS,
        "Mass of each floor, in place of mass",
        '["210 t", "210 t", "180 t"]',
        "a single mass",
        'missing; write floor_masses = "44 t" for all floors, or a list with one value for each',
    ),
]
StoreyStiffnesses = Annotated[
    tuple[float, ...] | float,
    _storeyed(
        STIFFNESS,
        "Lateral stiffness of each storey; beside period their ratios count alone. Of a building by a matrix or modes "
        "the part of it that yields, with storey_strengths",
        '"350 MN/m"',
        "a single mass; beside period those by which the first mode grows in proportion to height",
        MISSING_STIFFNESSES,
    ),
]
StoreyStrengths = Annotated[
    tuple[float, ...] | float,
    _storeyed(
        STOREY_STRENGTH, "Yield shear of each storey, for inelastic_storeys", '"1400 kN"', "storeys stay elastic"
    ),
]
StoreyHeights = Annotated[
    tuple[float, ...] | float,
    _storeyed(
        STOREY_HEIGHT,
        "Height of each storey",
        '["4 m", "3 m", "3 m"]',
        "a single mass",
        'missing; write storey_heights = "3 m" for all storeys, or a list with one value for each',
    ),
]
Isolated = Annotated[Isolation | None, ISOLATION]
Rigid = Annotated[bool, flag("rigid", "true for a wall that moves with the ground.")]


def wrong_lengths(keys: Section, names: Iterable[str], count: int, stated: str) -> Iterator[Fault]:
    """Faults for lists of a building that have not one value for each of its ``count`` storeys."""
    for key in names:
        length = len(keys.raw[key]) if isinstance(keys.raw.get(key), list) else 0
        if length not in (0, count):
            yield keys.fault(
                key,
                f"{length} value{'s' * (length != 1)} for {stated}; write one for each storey, from the ground up, "
                "or one value for all",
            )


def wrong_initial(keys: Section, count: int, stated: str) -> Iterator[Fault]:
    """Faults for initial states and plans of which not each floor has one; a slab on isolators is a floor more."""
    words = f"{stated} and the slab on the isolators" if "isolation" in keys else stated
    return wrong_lengths(keys, (*INITIAL, "plan"), count + ("isolation" in keys), words)


class AnyBuilding(Table):
    """A [[building]] table of any kind, with the keys that all kinds have.

    A kind of building is a class below with its own keys and a `structure`. What a structure has no field for raises
    TypeError there, and AttributeError in `table_of`, so that no key is lost between a file and a scene.
    """

    repair: ClassVar[str]  # for a key that this kind of building does not take
    has_storeys: ClassVar[bool] = False
    # Keys that a structure does not hold: others of it say the same, and the depth is written beside it.
    implied: ClassVar[frozenset[str]] = frozenset({"rigid", "floor_depth"})

    name: Annotated[str, text("What tables and figures call the building; each has its own.", "frame", REQUIRED)]
    floor_depth: Annotated[
        float | None,
        measured(
            FLOOR_DEPTH,
            "Depth of its floors below their levels; with it floors of neighbours that overlap in height meet floor to "
            "floor, others meet columns.",
            '"0.3 m"',
            "0.25 m, a slab of 6 m span (ACI 318-19, table 7.3.1.1: span / 24); a quarter of the lowest storey at most",
        ),
    ] = None
    rigid: Rigid = False
    ground_factor: Annotated[
        float,
        measured(
            GROUND_FACTOR,
            "Factor on the ground motion under it: -1 reverses it, 0 is ground that does not shake.",
            "-1.0",
            "1",
        ),
    ] = 1.0
    ground_delay: Annotated[
        float,
        measured(
            GROUND_DELAY,
            "How much later the ground motion reaches it than the building that is reached first, which has none. A "
            "run lasts until the last building has had the whole motion.",
            '"0.1 s"',
            "at once",
        ),
    ] = 0.0
    ground_velocity: Annotated[
        float,
        measured(
            GROUND_VELOCITY,
            "Velocity of the ground under it when the record begins; initial displacement and velocity are relative "
            "to it.",
            '"0.1 m/s"',
            "ground that rests",
        ),
    ] = 0.0
    ground_record: Annotated[
        tuple[str, ...],
        one_or_more(
            'names no record; write a file, such as "my/record.AT2", an id of the catalogue, a generated motion, or a '
            "list with one of these for each record of the scene",
            "A record of its own under it: a file, an id of the catalogue or a generated motion as text, for all "
            "records of the scene, or a list with one for each of them. It is processed as they are, and scaled by the "
            "factor of the record that it stands beside.",
            '"my/other_station.AT2"',
            "the records of the scene",
        ),
    ] = ()

    @classmethod
    @cache
    def keys(cls) -> dict[str, Key]:
        """The declarations of its keys by name: the name, the kind's own keys, then those of more kinds."""
        keys = super().keys()
        order = (key for kind in cls.__mro__ for key in get_annotations(kind))
        return {key: keys[key] for key in dict.fromkeys(("name", *order)) if key in keys}

    def by_floor(self, key: str, count: int) -> tuple[float, ...]:
        """The values of a key that has one for each of ``count`` storeys, or one for all."""
        values = getattr(self, key)
        return values if isinstance(values, tuple) else (values,) * count

    def fields(self) -> dict[str, Any]:
        """The values of its keys under the names of a structure's fields."""
        own = {key: getattr(self, key) for key in self.keys() if key not in self.implied}
        support = Support(**{field: own.pop(key) for key, field in OF_GROUND.items()})
        return {IN_STRUCTURES.get(key, key): value for key, value in own.items()} | {"support": support}

    def structure(self) -> Building | Storeys:
        """The building as the solvers take it; raises PoundingError for numbers that no building has."""
        raise NotImplementedError

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """What more than one key of the building takes part in."""
        return iter(())


class MovingBuilding(AnyBuilding):
    """A building that moves relative to the ground."""

    initial_displacement: Annotated[
        tuple[float, ...] | float,
        _storeyed(
            INITIAL_DISPLACEMENT,
            "Displacement of each floor relative to the ground when the motion begins",
            '["10 mm", "20 mm"]',
            "at rest",
        ),
    ] = ()
    initial_velocity: Annotated[
        tuple[float, ...] | float,
        _storeyed(
            INITIAL_VELOCITY,
            "Velocity of each floor relative to the ground when the motion begins",
            '"0.5 m/s"',
            "at rest",
        ),
    ] = ()
    displacement_history: Annotated[
        tuple[str, ...],
        one_or_more(
            f"names no file; write a list with one for each record of the scene, such as {HISTORY_EXAMPLE}, each with "
            "the columns time [s], floor 1 [mm], floor 2 [mm] and so on",
            "Displacement of each floor relative to the ground without contact, from a model of your own, in place of "
            "the motion that is computed: a CSV file with the columns time [s], floor 1 [mm], floor 2 [mm] and so on "
            "for each record of the scene, in their order. No contact is run then.",
            HISTORY_EXAMPLE,
            "the motion is computed",
        ),
    ] = ()


class SingleMass(MovingBuilding):
    """A building of one mass on a linear spring."""

    repair = (
        "a building of one mass has no {key}; remove {key}, or write floor_masses, storey_stiffnesses and "
        "storey_heights in place of mass and period"
    )
    implied = AnyBuilding.implied | {"stiffness"}

    mass: Mass
    period: Period = 0.0
    stiffness: Annotated[
        float, measured(STIFFNESS, "Its lateral stiffness, in place of period.", '"40.5 MN/m"', "from mass and period")
    ] = inf
    damping: Damping = 0.05
    floor_length: Annotated[
        float,
        measured(
            FLOOR_LENGTH,
            "Length of its floor along the row.",
            '"20 m"',
            "none; contact model distributed_mass needs it",
        ),
    ] = 0.0
    wave_speed: Annotated[
        float, measured(WAVE_SPEED, "Speed of a wave along its floor.", '"3500 m/s"', '"3500 m/s", concrete')
    ] = CONCRETE_WAVE_SPEED
    height: Height = 0.0

    def structure(self) -> Building:
        """The mass on its spring."""
        values = self.fields() | {key: sum(self.by_floor(key, 1)) for key in INITIAL}
        return Building(**values | {"period": self.period or 2.0 * pi * sqrt(self.mass / self.stiffness)})

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Exactly one of period and stiffness says how a mass vibrates."""
        yield from wrong_lengths(keys, INITIAL, 1, "a single mass")
        if "wave_speed" in keys and "floor_length" not in keys:
            sentence = 'acts along a floor of known length; write floor_length = "20 m", or remove it'
            yield keys.fault("wave_speed", sentence)
        if "period" in keys and "stiffness" in keys:
            sentence = "period and stiffness are both given, and one follows from the other; remove one"
            yield keys.fault("stiffness", sentence)
        if "period" not in keys and "stiffness" not in keys:
            sentence = 'missing; write period = "0.208 s", or stiffness = "40.5 MN/m", or rigid = true'
            yield keys.fault("period", sentence, absent=True)


class RigidWall(AnyBuilding):
    """A building, or the ground, that moves with the ground."""

    repair = "a rigid building moves with the ground and has no {key}; remove {key}, or rigid = true"

    rigid: Rigid = True
    mass: Mass = inf
    height: Height = 0.0

    def structure(self) -> Building:
        """The wall as the solvers take it: a building with a period of 0."""
        return Building(**self.fields(), period=0.0, damping=0.0)

    def written(self) -> dict[str, Any]:
        """As a scene file has it."""
        return super().written() | {"rigid": True}


class WithFloors(MovingBuilding):
    """A building of several floors, on the ground or on isolators."""

    implied = MovingBuilding.implied | {"isolation", "hysteresis"}

    column_strength: Annotated[
        float,
        measured(
            COLUMN_STRENGTH,
            "Force at which its columns yield where a neighbour's floor strikes them, in place of column_yield_force "
            "of the interface.",
            '"300 kN"',
            "column_yield_force of the interface",
        ),
    ] = inf
    hysteresis: Annotated[HysteresisTable | None, HYSTERESIS] = None
    isolation: Isolated = None

    def completed(self, bare: Storeys) -> Storeys:
        """The building on its isolators, with its initial state."""
        building = bare if self.isolation is None else bare.isolated(self.isolation.isolators())
        initial: dict[str, Any] = {key: self.by_floor(key, len(building.masses)) for key in INITIAL}
        return replace(building, **initial, hysteresis=None if self.hysteresis is None else self.hysteresis.law())


class OfStoreys(WithFloors):
    """A building of storeys, whose floors may rotate."""

    implied = WithFloors.implied | {"plan"}

    plan: Annotated[tuple[PlanTable, ...], PLAN] = ()

    def completed(self, bare: Storeys) -> Storeys:
        """The building on its isolators, with its initial state and the plans of its floors."""
        building = super().completed(bare)
        return replace(building, plans=plans_of(self.plan, len(building.masses)))

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """What floors that rotate do not have."""
        for key in ("isolation", "displacement_history", "hysteresis") if "plan" in keys else ():
            if key in keys:
                yield keys.fault(key, f"is not computed for floors that rotate; remove {key}, or plan")


class ShearBuilding(OfStoreys):
    """A building of storeys: floor masses on storey springs, from the ground up."""

    has_storeys = True
    repair = (
        "a building with floor_masses, storey_stiffnesses and storey_heights takes no {key}; remove {key}, or these"
    )
    implied = OfStoreys.implied | {"storeys", "period"}  # as given, its stiffnesses are those of the period

    floor_masses: FloorMasses
    storey_stiffnesses: StoreyStiffnesses = ()
    storey_heights: StoreyHeights
    damping: Damping = 0.05
    damping_rule: DampingRule = DAMPING_RULES[0]
    storey_strengths: StoreyStrengths = ()
    storeys: StoreyCount = 0
    period: Period = 0.0

    def structure(self) -> Storeys:
        """The shear building, with one value for each storey."""
        counted = LISTS if self.isolation else OF_STOREYS  # of initial states the slab is one more
        lists = [values for key in counted if isinstance(values := getattr(self, key), tuple) and values]
        count = self.storeys or len(lists[0])
        values = self.fields() | {IN_STRUCTURES[key]: self.by_floor(key, count) for key in LISTS}
        values = {key: value for key, value in values.items() if key not in INITIAL}
        if not values["stiffnesses"]:
            values["stiffnesses"] = stiffnesses_for(values["masses"], list(accumulate(values["heights"])), self.period)
        building = Storeys(**values)
        scaled = building.with_period(self.period) if self.period and self.storey_stiffnesses else building
        return self.completed(scaled)

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each storey, and neither stiffnesses nor a period."""
        yield from super().checks(keys)
        if "storey_stiffnesses" not in keys and "period" not in keys:
            yield keys.fault("storey_stiffnesses", MISSING_STIFFNESSES, absent=True)
        counted = LISTS if "isolation" in keys else OF_STOREYS
        lengths = {key: len(keys.raw[key]) for key in counted if isinstance(keys.raw.get(key), list)}
        count = keys.raw.get("storeys", next(iter(lengths.values()), None))
        if count is None:
            sentence = "missing; write storeys = 4, or a list with one value for each storey"
            yield keys.fault("storeys", sentence, absent=True)
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            return
        stated = f"storeys = {count}" if "storeys" in keys else f"{count} {next(iter(lengths), 'storeys')}"
        yield from wrong_lengths(keys, LISTS, count, stated)
        yield from wrong_initial(keys, count, stated)


class FlooredBuilding(WithFloors):
    """A building whose floors are joined by more than storey springs; ``period`` scales all stiffnesses."""

    has_storeys = True
    floor_masses: FloorMasses
    storey_heights: StoreyHeights
    period: Period = 0.0
    damping: Damping = 0.05
    storey_stiffnesses: StoreyStiffnesses = ()
    storey_strengths: StoreyStrengths = ()

    @classmethod
    @cache
    def keys(cls) -> dict[str, Key]:
        """The declarations of its keys by name, those that it must have first."""
        keys = super().keys()
        return {key: keys[key] for key in sorted(keys, key=lambda key: not cls.model_fields[key].is_required())}

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Storeys that yield have a stiffness and a strength."""
        for key, other in permutations(("storey_stiffnesses", "storey_strengths")):
            if key in keys and other not in keys:
                yield keys.fault(
                    key,
                    "a building by a matrix or modes has storeys that yield by storey_stiffnesses, the part of its "
                    f"matrix that yields, and storey_strengths; write {other} too, or remove {key}",
                )

    def floors(self, count: int) -> dict[str, Any]:
        """The fields of a structure that have one value for each of ``count`` floors, its name and its support."""
        fields = self.fields()
        stated = {key: fields[key] for key in ("name", "support", "displacement_history", "damping", "column_strength")}
        return stated | {IN_STRUCTURES[key]: self.by_floor(key, count) for key in LISTS}

    def completed(self, bare: Storeys) -> Storeys:
        """The building at the period of the table, on its isolators, with its initial state."""
        return super().completed(self.at_period(bare))

    def at_period(self, building: Storeys) -> Storeys:
        """The building, stiffer or softer as a whole, so that its first mode has the period of the table."""
        factor = (building.period / self.period) ** 2 if self.period else 1.0
        if factor == 1.0:
            return building
        matrix = factor * np.array(building.stiffness_matrix)
        dashpots = sqrt(factor) * np.array(building.damping_matrix)  # the same ratios
        return replace(
            building,
            stiffnesses=tuple(factor * stiffness for stiffness in building.stiffnesses),
            stiffness_matrix=tuple(map(tuple, matrix.tolist())),
            damping_matrix=tuple(map(tuple, dashpots.tolist())),
        )


class MatrixBuilding(FlooredBuilding):
    """A building by the stiffness matrix of its floors, or of a model that is condensed to them."""

    repair = "a building with a stiffness_matrix takes no {key}; remove {key}, or stiffness_matrix"

    stiffness_matrix: Annotated[
        Any,
        matrix_key(
            "K",
            OF_STIFFNESS,
            "Stiffness matrix of its floors along the row, from the ground up, in place of storey_stiffnesses: a file "
            "beside the scene (a row a line, or an array of NumPy), or rows; with the unit of its numbers. With "
            "floor_rows it may have rows of other places too, which are condensed.",
            "kN/m",
            "storey springs",
        ),
    ]
    floor_rows: Annotated[
        tuple[int, ...],
        Key(
            "Rows of stiffness_matrix that are floors, counted from 1, from the ground up; the others are condensed, "
            "which is exact where they carry neither mass nor damping.",
            _row_numbers,
            "[3, 6]",
            "every row is a floor",
            write=list,
            schema={"type": "array", "items": {"type": "integer"}},
        ),
    ] = ()
    damping_matrix: Annotated[
        Any,
        matrix_key(
            "C",
            OF_DASHPOTS,
            "Damping matrix of its floors, in place of damping and damping_rule.",
            "kN s/m",
            "damping by damping_rule",
        ),
    ] = ()
    mass_matrix: Annotated[
        Any,
        matrix_key(
            "M",
            OF_MASSES,
            "Mass matrix of the rows of stiffness_matrix, where masses are not lumped at floors; floor_masses beside "
            "it are those by which the ground's acceleration acts.",
            "t",
            "masses lumped at floors",
        ),
    ] = ()
    along_rows: Annotated[
        tuple[int, ...],
        Key(
            "Rows of mass_matrix that are displacements along the row, floors and others: the ground's acceleration "
            "acts on their masses.",
            _row_numbers,
            "[1, 3, 4, 6]",
            "the floors; needed where other rows have mass and no floor_masses are given",
            write=list,
            schema={"type": "array", "items": {"type": "integer"}},
        ),
    ] = ()
    floor_masses: FloorMasses = ()
    damping_rule: DampingRule = DAMPING_RULES[0]

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each floor, no masses, and what says the damping twice."""
        yield from super().checks(keys)
        matrix, names = keys.get("stiffness_matrix"), LISTS
        if "floor_masses" not in keys and "mass_matrix" not in keys:
            yield keys.fault("floor_masses", KEYS["floor_masses"].lacks("floor_masses"), absent=True)
        if "along_rows" in keys and "mass_matrix" not in keys:
            yield keys.fault("along_rows", "names rows of a mass_matrix; write one, or remove along_rows")
        elif "along_rows" in keys and "floor_masses" in keys:
            yield keys.fault(
                "along_rows",
                "floor_masses beside a mass_matrix are the masses that the ground's acceleration acts on; remove "
                "along_rows, or floor_masses, which along_rows then give",
            )
        if matrix and ("floor_rows" not in keys or keys.get("floor_rows")):
            count = len(keys.get("floor_rows") or matrix)
            yield from wrong_lengths(keys, names, count, f"{count} floors of stiffness_matrix")
            yield from wrong_initial(keys, count, f"{count} floors of stiffness_matrix")
        for key in ("damping", "damping_rule"):
            if key in keys and "damping_matrix" in keys:
                yield keys.fault(key, f"damping_matrix says it all; remove {key}, or damping_matrix")

    def structure(self) -> Storeys:
        """Its floors, the matrix condensed to them."""
        try:
            matrix = symmetric(self.stiffness_matrix, "stiffness_matrix")
            if self.floor_rows and max(self.floor_rows) > len(matrix):
                raise PoundingError(f"floor_rows names row {max(self.floor_rows)} of {len(matrix)}")
            rows = self.floor_rows or tuple(range(1, 1 + len(matrix)))
            stiffness = condensed(matrix, rows)
            masses = self._masses(matrix, rows) if self.mass_matrix else {}
        except PoundingError as error:
            raise PoundingError(f"{self.name}: {error}") from None
        rule = BY_MATRIX if self.damping_matrix else self.damping_rule
        values = self.floors(len(stiffness)) | {"damping_rule": rule, "damping_matrix": self.damping_matrix} | masses
        building = Storeys(**values, stiffness_matrix=tuple(map(tuple, stiffness.tolist())))
        return self.completed(building)

    def _masses(self, stiffness: np.ndarray, rows: tuple[int, ...]) -> dict[str, Any]:
        """The mass matrix of the floors, and the masses that the ground's acceleration acts on."""
        matrix = symmetric(self.mass_matrix, "mass_matrix")
        if len(matrix) != len(stiffness):
            raise PoundingError(
                f"mass_matrix has {counted(len(matrix), 'row')}, stiffness_matrix {len(stiffness)}; give the same rows "
                "in both, in the same order"
            )
        wrong = [row for row in self.along_rows if row > len(matrix)] or sorted(set(rows) - set(self.along_rows))
        if self.along_rows and wrong:
            words = (
                f"names row {wrong[0]} of {len(matrix)}" if wrong[0] > len(matrix) else f"lacks the floor {wrong[0]}"
            )
            raise PoundingError(f"along_rows {words}; write all rows that are displacements along the row")
        given = self.by_floor("floor_masses", len(rows))
        inertia, driven = condensed_masses(matrix, stiffness, rows, self.along_rows, given)
        return {"mass_matrix": tuple(map(tuple, inertia.tolist())), "masses": tuple(driven.tolist())}


class ModalBuilding(FlooredBuilding):
    """A building by modes of motion along the row, as programs of structural analysis write them."""

    repair = "a building with modes takes no {key}; remove {key}, or modes"

    modes: Annotated[Any, MODES]
    residual_period: Annotated[
        float,
        measured(
            BUILDING_PERIOD,
            "Period of all motion that its modes leave out: floors move in it when a neighbour strikes them.",
            '"0.05 s"',
            "a third of the shortest period of modes",
        ),
    ] = 0.0

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each floor."""
        yield from super().checks(keys)
        table = keys.get("modes")
        count = len(table.shapes[0]) if table else 0
        if table:
            yield from wrong_lengths(keys, LISTS, count, f"{count} floors of modes")
            yield from wrong_initial(keys, count, f"{count} floors of modes")
            if table.dampings and "damping" in keys:
                yield keys.fault("damping", "modes has a damping of its own for each; remove one of the two")

    def structure(self) -> Storeys:
        """Its floors, with the matrices of its modes."""
        values = self.floors(len(self.modes.shapes[0]))
        masses = np.array(values["masses"])
        try:
            stiffness, dashpots = assembled(self.modes, masses, self.damping, self.residual_period)
        except PoundingError as error:
            raise PoundingError(f"{self.name}: {error}") from None
        if dashpots is not None:
            values |= {"damping_rule": BY_MATRIX, "damping": self.modes.dampings[0]}
            values["damping_matrix"] = tuple(map(tuple, dashpots.tolist()))
        return self.completed(Storeys(**values, stiffness_matrix=tuple(map(tuple, stiffness.tolist()))))


class TypologyBuilding(OfStoreys):
    """A building of which no more is known than its height, storeys, kind and mass of a floor."""

    has_storeys = True
    repair = (
        "a building generated from its typology takes no {key}; remove {key}, or write floor_masses, "
        "storey_stiffnesses and storey_heights in place of typology and floor_mass"
    )

    height: Height
    storeys: StoreyCount
    typology: Annotated[
        str,
        one_of(
            list(TYPOLOGIES),
            "a typology",
            "What storeys are generated from, with height, storeys and floor_mass: a code's approximate period, or "
            "that of period, and a stated shape of the first mode.",
            '"concrete_frame"',
            "storeys are not generated",
            f'missing; write typology = "concrete_frame", or another of {", ".join(TYPOLOGIES)}',
        ),
    ]
    floor_mass: Annotated[
        float,
        measured(
            LEAST_FLOOR_MASS,
            "Mass of every floor of generated storeys.",
            '"200 t"',
            "storeys are not generated",
            'missing; write floor_mass = "200 t", of every floor',
        ),
    ]
    period: Period = 0.0
    damping: Damping = 0.05
    damping_rule: DampingRule = DAMPING_RULES[0]

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each storey."""
        yield from super().checks(keys)
        count = keys.raw.get("storeys")
        if isinstance(count, int) and not isinstance(count, bool):
            yield from wrong_initial(keys, count, f"storeys = {count}")

    def structure(self) -> Storeys:
        """The shear building that is generated."""
        values = self.fields() | {"period": self.period or None}
        others = {field: values.pop(field) for field in ("support", "displacement_history", "column_strength")}
        bare = generated(**{field: value for field, value in values.items() if field not in INITIAL})
        return self.completed(replace(bare, **others))


KINDS: tuple[type[AnyBuilding], ...] = (
    SingleMass,
    RigidWall,
    ShearBuilding,
    TypologyBuilding,
    MatrixBuilding,
    ModalBuilding,
)
KEYS: Mapping[str, Key] = {name: key for kind in KINDS for name, key in kind.keys().items()}
INITIAL = ("initial_displacement", "initial_velocity")
LISTS = ("floor_masses", "storey_stiffnesses", "storey_heights", "storey_strengths")
OF_STOREYS = (*LISTS, *INITIAL)  # keys with one value for each storey
# Keys of the ground under a building, and the fields of its support that they are.
OF_GROUND = {f"ground_{field}": field for field in ("factor", "delay", "velocity")} | {"ground_record": "records"}
# Keys that are called otherwise in the buildings that the solvers take.
IN_STRUCTURES = dict(zip(LISTS, ("masses", "stiffnesses", "heights", "strengths"), strict=True))


def kind_of(keys: Mapping[str, Any]) -> type[AnyBuilding]:
    """What a [[building]] table is of, by the keys that it has."""
    if keys.get("rigid") is True:
        return RigidWall
    if "stiffness_matrix" in keys or "modes" in keys:
        return MatrixBuilding if "stiffness_matrix" in keys else ModalBuilding
    if "mass_matrix" in keys and "storey_stiffnesses" not in keys:
        return MatrixBuilding
    if any(key in keys for key in LISTS[:3]):
        return ShearBuilding
    if "typology" in keys or "floor_mass" in keys or ("storeys" in keys and "mass" not in keys):
        return TypologyBuilding
    return SingleMass


def building_checks(buildings: Sequence[Section], count: int) -> Iterator[Fault]:
    """All faults that more than one key of the buildings takes part in; ``count`` counts what are no tables too."""
    first: dict[str, int] = {}
    for keys in buildings:
        index, name, kind = int(keys.path[1]), keys.get("name"), _kind(keys)
        if name and first.setdefault(name, index) != index:
            yield keys.fault(
                "name",
                f"{shown(name)} is the name of building {first[name] + 1} too; give every building a name of its own",
            )
        for key in KEYS:
            if key in keys and key not in kind.model_fields:
                yield keys.fault(key, kind.repair.format(key=key))
        yield from kind.checks(keys)
    if count < 2:
        yield Fault(
            ("building",),
            f"{count} building{'s' * (count != 1)}: a scene has two, left and right; "
            "write a second [[building]] (rigid = true for a wall that moves with the ground)",
        )
    rigid = {int(keys.path[1]) for keys in buildings if keys.kind is RigidWall}
    walls = sorted(rigid & {index + 1 for index in rigid})  # whose left neighbour is one too
    for index in walls:
        sentence = (
            "both buildings are rigid, so that no run is needed; give one of them a mass and a period"
            if count == 2
            else "its left neighbour is rigid too, and two walls never meet; write both as one, or give one a mass and "
            "a period"
        )
        yield Fault(("building", index, "rigid"), sentence)
    delays = [keys.get("ground_delay", 0.0) for keys in buildings]
    if delays and len(delays) == count and all(delay > 0.0 for delay in delays):
        yield buildings[0].fault(
            "ground_delay",
            "every building has a delay, so that time would begin before the motion; count delays from the building "
            "that is reached first, and remove its ground_delay",
        )


def _kind(keys: Section) -> type[AnyBuilding]:
    assert issubclass(keys.kind, AnyBuilding)
    return keys.kind


def structure_of(keys: Section) -> Building | Storeys:
    """The building of a table without a fault.

    Raises PoundingError for a height that its code's period is not for, and for what vibrates faster than a building.
    """
    building = _kind(keys).from_values(keys.values).structure()
    # Of each mass on the springs beside it, its neighbours held: no mode of the building is slower than the least.
    if isinstance(building, Building):
        periods = [] if building.is_rigid else [building.period]
    else:
        springs = np.diag(building.elastic_stiffness())[: len(building.masses)].tolist()
        periods = [2.0 * pi * sqrt(mass / spring) for mass, spring in zip(building.masses, springs, strict=True)]
    if periods and min(periods) < LEAST_PERIOD:
        place = "" if isinstance(building, Building) else f"floor {periods.index(min(periods)) + 1} on its storeys "
        raise PoundingError(
            f"{place}would vibrate with a period of {min(periods):.3g} s, and none of a building is below "
            f"{LEAST_PERIOD:g} s; check mass and stiffness, and their units"
        )
    return building


def table_of(building: Building | Storeys) -> AnyBuilding:
    """The table of a building, every value stated that it has."""
    kind: type[AnyBuilding] = ShearBuilding
    if not isinstance(building, Storeys):
        kind = RigidWall if building.is_rigid else SingleMass
    implied = kind.implied
    if isinstance(building, Storeys) and building.stiffness_matrix:
        kind = MatrixBuilding
        implied = kind.implied | {"floor_rows", "along_rows", "period"}
        implied |= {"damping", "damping_rule"} if building.damping_matrix else set()
    stated = {key: getattr(building, key) for key in INITIAL if getattr(building, key)}
    if isinstance(building, Storeys) and building.isolators is not None:
        stated["isolation"], building = Isolation.of(building.isolators), building.superstructure()
    if isinstance(building, Storeys) and building.hysteresis is not None:
        stated["hysteresis"] = HysteresisTable.of(building.hysteresis)
    if isinstance(building, Storeys) and building.plans:
        stated["plan"] = tables_of(building.plans)
    for key in set(kind.key_names()) - implied:
        if key in OF_GROUND:
            value = getattr(building.support, OF_GROUND[key])
        else:
            value = getattr(building, IN_STRUCTURES.get(key, key))
        is_usual = value == kind.model_fields[key].default and (key in OF_GROUND or value in (0.0, inf, ()))
        if not is_usual and (value or key not in INITIAL):
            stated[key] = value
    if "floor_length" not in stated:
        stated.pop("wave_speed", None)
    return kind.from_values(stated)
