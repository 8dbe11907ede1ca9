"""The [[building]] tables of a scene: a mass, a rigid wall, storeys or a typology; all kinds, and checks."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from math import inf, pi, sqrt
from typing import Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED, Building
from pounding_risk.models.structures.storeys import DAMPING_RULES, Storeys, generated, stiffnesses_for
from pounding_risk.models.structures.typologies import ELSEWHERE, TYPOLOGIES
from pounding_risk.scene import building_keys
from pounding_risk.scene.building_keys import AnyBuilding, MovingBuilding, WithFloors, wrong_initial, wrong_lengths
from pounding_risk.scene.building_tables import PLAN, HysteresisTable, Isolation, PlanTable
from pounding_risk.scene.keys import Key, Section, measured, one_of, repeated_names
from pounding_risk.scene.matrix_buildings import MatrixBuilding, ModalBuilding
from pounding_risk.scene.toml import Fault
from pounding_risk.units import FLOOR_LENGTH, STIFFNESS, WAVE_SPEED


class SingleMass(MovingBuilding):
    """A building of one mass on a linear spring."""

    repair = (
        "a building of one mass has no {key}; remove {key}, or write floor_masses, storey_stiffnesses and "
        "storey_heights in place of mass and period"
    )
    implied = AnyBuilding.implied | {"stiffness"}

    mass: float = building_keys.MASS.required()
    period: float = building_keys.PERIOD.defaults_to(0.0)
    stiffness: float = measured(
        STIFFNESS, "Its lateral stiffness, in place of period.", absent="from mass and period"
    ).defaults_to(inf)
    damping: float = building_keys.DAMPING.defaults_to(0.05)
    floor_length: float = measured(
        FLOOR_LENGTH, "Length of its floor along the row.", absent="none; contact model distributed_mass needs it"
    ).defaults_to(0.0)
    wave_speed: float = measured(
        WAVE_SPEED, "Speed of a wave along its floor.", absent='"3500 m/s", concrete'
    ).defaults_to(CONCRETE_WAVE_SPEED)
    height: float = building_keys.HEIGHT.defaults_to(0.0)

    def structure(self) -> Building:
        """The mass on its spring."""
        fields = self.fields() | {key: sum(self.by_floor(key, 1)) for key in building_keys.INITIAL}
        return Building(**fields | {"period": self.period or 2.0 * pi * sqrt(self.mass / self.stiffness)})

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Exactly one of period and stiffness says how a mass vibrates."""
        yield from wrong_lengths(keys, building_keys.INITIAL, 1, "a single mass")
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

    rigid: bool = building_keys.RIGID.defaults_to(True)
    mass: float = building_keys.MASS.defaults_to(inf)
    height: float = building_keys.HEIGHT.defaults_to(0.0)

    def structure(self) -> Building:
        """The wall as the solvers take it: a building with a period of 0."""
        return Building(**self.fields(), period=0.0, damping=0.0)

    def written(self) -> dict[str, Any]:
        """As a scene file has it."""
        return super().written() | {"rigid": True}


class OfStoreys(WithFloors):
    """A building of storeys, whose floors may rotate."""

    implied = WithFloors.implied | {"plan"}

    plan: tuple[PlanTable, ...] = PLAN.defaults_to(())

    def completed(self, bare_building: Storeys) -> Storeys:
        """The building on its isolators, with its initial state and the plans of its floors."""
        building = super().completed(bare_building)
        plans = tuple(table.plan() for table in self.plan)  # one for all floors, or one for each
        return replace(building, plans=plans * len(building.masses) if len(plans) == 1 else plans)

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

    floor_masses: tuple[float, ...] | float = building_keys.FLOOR_MASSES.required()
    storey_stiffnesses: tuple[float, ...] | float = building_keys.STOREY_STIFFNESSES.defaults_to(())
    storey_heights: tuple[float, ...] | float = building_keys.STOREY_HEIGHTS.required()
    damping: float = building_keys.DAMPING.defaults_to(0.05)
    damping_rule: str = building_keys.DAMPING_RULE.defaults_to(DAMPING_RULES[0])
    storey_strengths: tuple[float, ...] | float = building_keys.STOREY_STRENGTHS.defaults_to(())
    storeys: int = building_keys.STOREYS.defaults_to(0)
    period: float = building_keys.PERIOD.defaults_to(0.0)

    def structure(self) -> Storeys:
        """The shear building, with one value for each storey."""
        # Lists of initial states have one more value, of the slab on isolators.
        list_keys = building_keys.LISTS if self.isolation else building_keys.OF_STOREYS
        lists = [fields for key in list_keys if isinstance(fields := getattr(self, key), tuple) and fields]
        count = self.storeys or len(lists[0])
        fields = self.fields() | {
            building_keys.IN_STRUCTURES[key]: self.by_floor(key, count) for key in building_keys.LISTS
        }
        fields = {key: setting for key, setting in fields.items() if key not in building_keys.INITIAL}
        if not fields["stiffnesses"]:
            fields["stiffnesses"] = stiffnesses_for(fields["masses"], list(accumulate(fields["heights"])), self.period)
        building = Storeys(**fields)
        scaled_building = building.with_period(self.period) if self.period and self.storey_stiffnesses else building
        return self.completed(scaled_building)

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each storey, and neither stiffnesses nor a period."""
        yield from super().checks(keys)
        if "storey_stiffnesses" not in keys and "period" not in keys:
            yield keys.fault("storey_stiffnesses", building_keys.MISSING_STIFFNESSES, absent=True)
        list_keys = building_keys.LISTS if "isolation" in keys else building_keys.OF_STOREYS
        lengths = {key: len(keys.raw[key]) for key in list_keys if isinstance(keys.raw.get(key), list)}
        count = keys.raw.get("storeys", next(iter(lengths.values()), None))
        if count is None:
            sentence = "missing; write storeys = 4, or a list with one value for each storey"
            yield keys.fault("storeys", sentence, absent=True)
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            return
        count_text = f"storeys = {count}" if "storeys" in keys else f"{count} {next(iter(lengths), 'storeys')}"
        yield from wrong_lengths(keys, building_keys.LISTS, count, count_text)
        yield from wrong_initial(keys, count, count_text)


class TypologyBuilding(OfStoreys):
    """A building of which no more is known than its height, storeys, kind and mass of a floor."""

    has_storeys = True
    repair = (
        "a building generated from its typology takes no {key}; remove {key}, or write floor_masses, "
        "storey_stiffnesses and storey_heights in place of typology and floor_mass"
    )

    height: float = building_keys.HEIGHT.required()
    storeys: int = building_keys.STOREYS.required()
    typology: str = one_of(
        list(TYPOLOGIES),
        "a typology",
        "What storeys are generated from, with height, storeys and floor_mass: a code's approximate period, or "
        "that of period, and a stated shape of the first mode.",
        '"concrete_frame"',
        "storeys are not generated",
        f'missing; write typology = "concrete_frame", or another of {", ".join(TYPOLOGIES)}; with a known period '
        "write floor_masses, storey_heights and period in place of typology, floor_mass and height",
        ELSEWHERE,
    ).required()
    floor_mass: float = measured(
        building_keys.LEAST_FLOOR_MASS,
        "Mass of every floor of generated storeys.",
        '"200 t"',
        "storeys are not generated",
        'missing; write floor_mass = "200 t", of every floor',
    ).required()
    period: float = building_keys.PERIOD.defaults_to(0.0)
    damping: float = building_keys.DAMPING.defaults_to(0.05)
    damping_rule: str = building_keys.DAMPING_RULE.defaults_to(DAMPING_RULES[0])

    @classmethod
    def checks(cls, keys: Section) -> Iterator[Fault]:
        """Lists that have not one value for each storey."""
        yield from super().checks(keys)
        count = keys.raw.get("storeys")
        if isinstance(count, int) and not isinstance(count, bool):
            yield from wrong_initial(keys, count, f"storeys = {count}")

    def structure(self) -> Storeys:
        """The shear building that is generated."""
        fields = self.fields() | {"period": self.period or None}
        other_fields = {field: fields.pop(field) for field in ("support", "displacement_history", "column_strength")}
        storeys = generated(
            **{field: setting for field, setting in fields.items() if field not in building_keys.INITIAL}
        )
        return self.completed(replace(storeys, **other_fields))


KINDS: tuple[type[AnyBuilding], ...] = (
    SingleMass,
    RigidWall,
    ShearBuilding,
    TypologyBuilding,
    MatrixBuilding,
    ModalBuilding,
)
KEYS: Mapping[str, Key] = {name: key for kind in KINDS for name, key in kind.keys().items()}


def kind_of(keys: Mapping[str, Any]) -> type[AnyBuilding]:
    """The kind of building of a [[building]] table, by the keys that it has."""
    if keys.get("rigid") is True:
        return RigidWall
    if "stiffness_matrix" in keys or "modes" in keys:
        return MatrixBuilding if "stiffness_matrix" in keys else ModalBuilding
    if "mass_matrix" in keys and "storey_stiffnesses" not in keys:
        return MatrixBuilding
    if any(key in keys for key in building_keys.LISTS[:3]):
        return ShearBuilding
    if "typology" in keys or "floor_mass" in keys or ("storeys" in keys and "mass" not in keys):
        return TypologyBuilding
    return SingleMass


def building_checks(buildings: Sequence[Section], count: int) -> Iterator[Fault]:
    """All faults that more than one key of the buildings takes part in; ``count`` includes what is no table."""
    yield from repeated_names(buildings, "building")
    for keys in buildings:
        kind = _kind_of_section(keys)
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
    rigid_indices = {int(keys.path[1]) for keys in buildings if keys.kind is RigidWall}
    walls = sorted(rigid_indices & {index + 1 for index in rigid_indices})  # with a rigid left neighbour
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


def _kind_of_section(keys: Section) -> type[AnyBuilding]:
    assert issubclass(keys.kind, AnyBuilding)
    return keys.kind


def structure_of(keys: Section) -> Building | Storeys:
    """The building of a table without a fault.

    Raises PoundingError for a height that its code's period is not for, and for what vibrates faster than a building.
    """
    table = _kind_of_section(keys).from_values(keys.values)
    try:
        building = table.structure()
    except TypeError as error:
        if "got an unexpected keyword argument" not in str(error):
            raise  # a mistake of another kind
        repair_text = "a key needs a field of its name in pounding_risk/models/structures (sdof.py, storeys.py)"
        raise TypeError(f"{type(table).__name__} in {type(table).__module__}: {error}; {repair_text}") from error
    # Each mass on the springs beside it, its neighbours held: no mode is slower than the fastest of these.
    if isinstance(building, Building):
        periods = [] if building.is_rigid else [building.period]
    else:
        springs = np.diag(building.elastic_stiffness())[: len(building.masses)].tolist()
        periods = [2.0 * pi * sqrt(mass / spring) for mass, spring in zip(building.masses, springs, strict=True)]
    if periods and min(periods) < building_keys.LEAST_PERIOD:
        place = "" if isinstance(building, Building) else f"floor {periods.index(min(periods)) + 1} on its storeys "
        raise PoundingError(
            f"{place}would vibrate with a period of {min(periods):.3g} s, and none of a building is below "
            f"{building_keys.LEAST_PERIOD:g} s; check mass and stiffness, and their units"
        )
    return building


def table_of(building: Building | Storeys) -> AnyBuilding:
    """The table of a building, with every value that it has."""
    kind: type[AnyBuilding] = ShearBuilding
    if not isinstance(building, Storeys):
        kind = RigidWall if building.is_rigid else SingleMass
    implied = kind.implied
    if isinstance(building, Storeys) and building.stiffness_matrix:
        kind = MatrixBuilding
        implied = kind.implied | {"floor_rows", "along_rows", "interior_modes", "period"}
        implied |= {"damping", "damping_rule"} if building.damping_matrix else set()
    stated_values = {key: getattr(building, key) for key in building_keys.INITIAL if getattr(building, key)}
    if isinstance(building, Storeys) and building.isolators is not None:
        stated_values["isolation"], building = Isolation.of(building.isolators), building.superstructure()
    if isinstance(building, Storeys) and building.hysteresis is not None:
        stated_values["hysteresis"] = HysteresisTable.of(building.hysteresis)
    if isinstance(building, Storeys) and building.plans:
        plans = building.plans[:1] if len(set(building.plans)) == 1 else building.plans
        stated_values["plan"] = tuple(map(PlanTable.of, plans))
    for key in set(kind.key_names()) - implied:
        if key in building_keys.OF_GROUND:
            setting = getattr(building.support, building_keys.OF_GROUND[key])
        else:
            setting = getattr(building, building_keys.IN_STRUCTURES.get(key, key))
        is_default = setting == kind.model_fields[key].default and (
            key in building_keys.OF_GROUND or setting in (0.0, inf, ())
        )
        if not is_default and (setting or key not in building_keys.INITIAL):
            stated_values[key] = setting
    if "floor_length" not in stated_values:
        stated_values.pop("wave_speed", None)
    return kind.from_values(stated_values)
