"""A scene: buildings, what stands between neighbours, ground motions and the grid of cases, ready to be run.

It is written as TOML or in Python. Both become the tables of a scene file, which are read by one way: `read_tables`
reads every key, the checks report what does not go together, `_assembled` makes the fields of a `Scene`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib import import_module
from itertools import pairwise
from math import inf, isnan
from operator import attrgetter
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.letters import plain
from pounding_risk._common.plugins import Plugin, plugin_of
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import short_list
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import is_instant, needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import related
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import EFFECTS, supports_of
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import COLUMN, FLOOR_DEPTH, Point
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import PEAK, Level, Measure, at_pga
from pounding_risk.motions.request import RecordRequest
from pounding_risk.scene.axes import Placed, axes_in_text, axis_faults, keeping_axes, without_axes, written_axes
from pounding_risk.scene.building_keys import OF_GROUND
from pounding_risk.scene.buildings import structure_of, table_of
from pounding_risk.scene.damage import DamageState
from pounding_risk.scene.interface_checks import is_row
from pounding_risk.scene.interfaces import (
    EQUAL_TERMS,
    NO_RESTITUTION,
    PARAMETERS,
    Interface,
    interface_name,
    known_law,
    needed_restitution,
    with_stiffness_unit,
)
from pounding_risk.scene.keys import Draft, Table, in_text
from pounding_risk.scene.levels import at_periods, relative_faults
from pounding_risk.scene.overrides import ARRAYS
from pounding_risk.scene.records import Records, records_of
from pounding_risk.scene.resolved_interfaces import ResolvedInterface, resolved_interfaces, stiff_model
from pounding_risk.scene.scene_axis import UNCERTAIN, SceneAxis, has_gap
from pounding_risk.scene.sections import KEYS, Same, every_fault, overridden, read_tables, untouched, written_overrides
from pounding_risk.scene.tables import Effect, Grid, Solver, effect_tables
from pounding_risk.scene.toml import Fault, KeyPath, write_toml
from pounding_risk.scene.uncertain import UncertainNumbers
from pounding_risk.scene.uncertain_tables import Uncertain, numbers_in_text, table_of_numbers, uncertain_of
from pounding_risk.units import GAP, YIELD_FORCE, exact, say, shown

OF_EACH_INTERFACE = "each interface's own"  # label of the contact models of a scene whose interfaces differ in theirs
# The parts of a scene, and the sections of a scene file that they are.
PARTS = {"buildings": "building", "interfaces": "interface"}
PARTS |= {part: part for part in ("records", "grid", UNCERTAIN, "effects", "solver", "damage")} | {"name": "scene"}
OF_RESTITUTION = {"restitution": "rule", "restitution_words": "words", "relation": "relation"}  # of `GivenRestitution`
NO_STRENGTHS = (
    "no storey of the scene has a yield shear, so that none would yield; write storey_strengths in a [[building]], or "
    "generate one from a typology, or remove inelastic_storeys"
)


class Axes(NamedTuple):
    """The values of each dimension; one value, the scene's own, where the scene names no grid for it.

    ``amplitudes`` is ``(None,)`` where the records keep their amplitude, or have the one that [records] brings them to.
    """

    gaps: tuple[float, ...]  # m, ascending
    yield_forces: tuple[float, ...]  # N, ascending, inf last
    contact_models: tuple[str, ...]  # in the order written
    amplitudes: tuple[Level | None, ...]  # of one measure, ascending

    @property
    def measure(self) -> Measure:
        """The measure of the amplitudes; PGA where there are none."""
        return self.amplitudes[0].measure if self.amplitudes[0] is not None else PEAK

    @property
    def levels(self) -> tuple[float | None, ...]:
        """The value of each amplitude in its measure [SI]."""
        return tuple(None if level is None else level.value for level in self.amplitudes)


def _of_first(path: str, words: str) -> Any:
    """A property of a scene: that of its first interface."""
    value = attrgetter(path)
    return property(lambda scene: value(scene.interfaces[0]), doc=f"{words[:-1]}, at the first interface.")


@dataclass(frozen=True, repr=False, init=False, eq=False)
class Scene(ShortRepr):
    """One scene: buildings, what stands between neighbours, the ground motions and the grid of cases.

    Numbers may be floats in SI or text with a unit, as in a scene file. Two scenes are equal where they ask for the
    same runs; ``text``, ``source`` and ``overrides`` say where one came from and do not count.

    Parameters
    ----------
    buildings : list of SingleMass, ShearBuilding, TypologyBuilding, RigidWall, dict, or of another scene
        Left to right.
    interfaces : list of Interface, dict, or items of another scene's ``interfaces``
        One between each two buildings, or one for all of them.
    records : Records
        The ground motions, and how they are treated.
    grid : Grid, optional
        The values of each dimension of a scan; by default the one case of the interfaces and records.
    uncertain : Uncertain, optional
        Numbers that nobody knows exactly, and how they are drawn; by default none.
    effects : list of str or Effect, or dict of names and options, optional
        Effects that act.
    solver : Solver, optional
        How exactly the runs are solved.
    damage : list of DamageState or dict, optional
        States of damage, which no run reads.
    name : str
        What reports and figures call the scene.
    folder : str or path
        Folder that names of record files are relative to.

    Attributes
    ----------
    buildings : tuple of Building or Storeys
        The buildings as the solvers take them, numbers in SI.
    interfaces : tuple of ResolvedInterface
        One between each two of them, numbers in SI, every default filled in.
    records : RecordRequest
        The ground motions and how they are treated.
    grid : Axes
        The values of each dimension.
    uncertain : UncertainNumbers or None
        The numbers that are drawn, with their distributions; a scan runs along their samples.

    Raises
    ------
    SceneError
        With every fault, its key and the likely repair.
    """

    name: str
    buildings: tuple[Building | Storeys, ...]
    interfaces: tuple[ResolvedInterface, ...]
    records: RecordRequest
    grid: Axes
    rtol: float
    effects: tuple[Effect, ...]  # in the order in which they wrap a law
    is_row: bool  # whether the row solver runs it: all but two masses that meet mass to mass
    gridded_interface: str | None  # "left | right", the only one whose gap the grid varies; None for all
    axes: tuple[SceneAxis, ...]  # of other numbers of the scene, slowest first; see `scene.variants`
    uncertain: UncertainNumbers | None  # whose samples are the last of the axes
    damage: tuple[Any, ...] = field(compare=False)  # `DamageState`
    text: str = field(compare=False)
    source: str = field(compare=False)
    overrides: tuple[str, ...] = field(compare=False)
    # What makes of the scene at a place along the axes the one that is run there; see `scene.variants`.
    at_every_place: Callable[[Scene], Scene] | None = field(compare=False, default=None)

    # What the first interface says.
    gap = _of_first("gap", "Clear distance [m].")
    stiffness = _of_first("stiffness", "Contact stiffness [N/m or N/m^1.5]; None where no model has one.")
    restitution = _of_first("restitution.rule", "Relation e(v).")
    restitution_words = _of_first("restitution.words", "Name of e(v), number, damping ratio, or `NO_RESTITUTION`.")
    relation = _of_first("restitution.relation", "Relation of restitution and damping.")
    yield_force = _of_first("yield_force", "Yield force of the floors [N]; inf without yielding.")
    equal_terms = _of_first("equal_terms", "How the stiffness of other contact models follows.")
    design_penetration = _of_first("design_penetration", "Penetration for which bilinear is set up [m].")

    def __init__(
        self,
        buildings: Sequence[Any],
        interfaces: Sequence[Any],
        records: Any,
        *,
        grid: Any = None,
        uncertain: Any = None,
        effects: Any = (),
        solver: Any = None,
        damage: Sequence[Any] = (),
        name: str = "",
        folder: str | Path = ".",
    ):
        needed = {"buildings": buildings, "interfaces": interfaces, "records": records}
        others = {
            "grid": grid,
            UNCERTAIN: uncertain,
            "effects": effects or None,
            "solver": solver,
            "damage": damage or None,
            "name": name or None,
        }
        given = needed | {part: value for part, value in others.items() if value is not None}
        tables = dict(_section(part, value) for part, value in given.items())
        if not isinstance(folder, str | PathLike):
            raise SceneError("scene", [f"folder: {shown(folder)} is no folder; write one, or leave it out"])
        made = scene_of(tables, str(Path(folder) / "scene"))
        self.__dict__.update(vars(made))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self._compared() == other._compared()

    def __hash__(self) -> int:
        return hash(self._compared())

    def _compared(self) -> tuple[Any, ...]:
        """What two scenes share that ask for the same runs; an unknown level is no NaN, which differs from itself."""
        interfaces = tuple(
            interface.updated(
                points=tuple(point._replace(level=inf) if isnan(point.level) else point for point in interface.points)
            )
            for interface in self.interfaces
        )
        values = (getattr(self, part.name) for part in fields(self) if part.compare and part.name != "interfaces")
        return (interfaces, *values)

    # -------------------------------------------------------------------------------------------- reading

    def facts(self) -> Iterable[tuple[str, str]]:
        """What stands where, under which motions, and how many cases there are."""
        grid = self.grid
        yield "name", self.name
        yield "buildings", " | ".join(building.name for building in self.buildings)
        yield "gaps", short_list([say(gap, GAP) for gap in grid.gaps], 3)
        yield "contact models", ", ".join(grid.contact_models)
        yield "yield forces", short_list([say(force, YIELD_FORCE) for force in grid.yield_forces], 3)
        yield from self.axis_words()
        if self.effects:
            yield "effects", ", ".join(effect.name for effect in self.effects)
        records = self.records
        generated = (recipe.text() for recipe in records.generated)
        names = ", ".join(records.names or records.files or generated)
        yield "records", names or records.set or records.manifest or records.sites

    def axis_words(self) -> Iterator[tuple[str, str]]:
        """What varies along the axes of numbers, and how: the distributions of those that are drawn."""
        yield from ((", ".join(axis.keys), axis.words()) for axis in self.axes if not axis.dimension)
        if self.uncertain is not None:
            yield from self.uncertain.described()

    @property
    def contact_model(self) -> str:
        """Contact model of the interfaces; `OF_EACH_INTERFACE` where they differ in theirs."""
        names = {interface.contact_model for interface in self.interfaces}
        return self.interfaces[0].contact_model if len(names) == 1 else OF_EACH_INTERFACE

    @property
    def interface_names(self) -> tuple[str, ...]:
        """The name "left | right" of each interface."""
        names = [building.name for building in self.buildings]
        return tuple(interface_name(left, right) for left, right in pairwise(names))

    @property
    def points(self) -> tuple[Point, ...]:
        """The contact points, interface by interface from the ground up."""
        return tuple(point for interface in self.interfaces for point in interface.points)

    @property
    def links(self) -> tuple[Link, ...]:
        """The springs and dashpots between neighbours."""
        return tuple(link for interface in self.interfaces for link in interface.links)

    @property
    def bumpers(self) -> tuple[float, ...]:
        """How much of the gap of each interface its bumpers take up [m]; none where no table has the key."""
        lengths = [interface.bumper_length for interface in self.interfaces]
        return () if lengths[0] is None else tuple(length or 0.0 for length in lengths)

    @property
    def supports(self) -> tuple[Support, ...]:
        """What a_g is under each building, a passing wave counted; none where all stand on the records as they are."""
        return supports_of(self.buildings, self.effects)

    @property
    def lag(self) -> float:
        """Time from the arrival of the ground motion at the first building to that at the last [s]."""
        return max((support.delay for support in self.supports), default=0.0)

    @property
    def pair(self) -> tuple[Building, Building]:
        """The two single masses, left and right, of a scene that is no row."""
        left, right = self.buildings
        assert isinstance(left, Building) and isinstance(right, Building)
        return left, right

    @property
    def model_names(self) -> tuple[str, ...]:
        """The contact models of the interfaces, which `simulate` runs, and of the grid."""
        own = (interface.contact_model for interface in self.interfaces)
        return tuple(dict.fromkeys((*own, *self._gridded_models)))

    def models_of(self, *labels: str) -> tuple[str, ...]:
        """The contact models that labels of the dataset's contact models stand for, each once."""
        own = tuple(interface.contact_model for interface in self.interfaces)
        return tuple(
            dict.fromkeys(name for label in labels for name in (own if label == OF_EACH_INTERFACE else (label,)))
        )

    @property
    def _gridded_models(self) -> tuple[str, ...]:
        return tuple(name for name in self.grid.contact_models if name != OF_EACH_INTERFACE)

    def at(self, place: int) -> Scene:
        """The scene of interface ``place`` alone, from 0: its two buildings and what stands between them."""
        if len(self.interfaces) == 1:
            return self
        here, grid = self.interfaces[place], self.grid
        gaps = grid.gaps if self.gridded_interface in (None, self.interface_names[place]) else (here.gap,)
        forces = grid.yield_forces if len(grid.yield_forces) > 1 else (here.yield_force,)
        models = tuple(here.contact_model if name == OF_EACH_INTERFACE else name for name in grid.contact_models)
        return self.updated(
            buildings=self.buildings[place : place + 2],
            grid=grid._replace(gaps=gaps, yield_forces=forces, contact_models=models),
            interfaces=(
                here.updated(
                    points=tuple(point._replace(interface=0) for point in here.points),
                    links=tuple(link._replace(interface=0) for link in here.links),
                ),
            ),
            gridded_interface=None,
            damage=(),
        )

    def interface_gaps(self, gap: float) -> tuple[float, ...]:
        """The gap of each interface where that of the grid is ``gap`` [m]."""
        named = self.gridded_interface
        pairs = zip(self.interface_names, self.interfaces, strict=True)
        return tuple(gap if named in (None, name) else interface.gap for name, interface in pairs)

    def point_yield_forces(self, force: float | None = None) -> tuple[float, ...]:
        """The yield force of each of `points` [N] where that of floors is ``force``; None for each interface's own.

        A grid of one yield force leaves every interface its own. Columns keep theirs. Either end of a face that
        rotates has half of its floor's.
        """
        return tuple(
            self.column_force(point)
            if point.kind == COLUMN
            else (interface.yield_force if force is None else force) * (1.0 if point.across == inf else 0.5)
            for interface in self.interfaces
            for point in interface.points
        )

    def column_force(self, point: Point) -> float:
        """The force at which the struck column of a contact point yields [N]: its building's, or the interface's."""
        own = self.own_column_force(point)
        return self.interfaces[point.interface].column_yield_force if own == inf else own

    def own_column_force(self, point: Point) -> float:
        """The column strength of the building that is struck at a contact point [N]; infinite where it has none."""
        struck = self.struck_building(point)
        return inf if struck is None else self.buildings[struck].column_strength

    def struck_building(self, point: Point) -> int | None:
        """Whose column a floor strikes at a contact point, by its place in the row; None where floors meet."""
        floors = enumerate((point.left_floor, point.right_floor), point.interface)
        struck = (place for place, floor in floors if floor != int(floor) and not self.buildings[place].is_rigid)
        return next(struck, None)

    @property
    def striking_mass(self) -> float:
        """m1 m2 / (m1 + m2) of what strikes at the first interface [kg]; the other's mass where one is rigid.

        A single mass strikes whole, a building of storeys with a floor of average mass.
        """
        left, right = (
            len(building.masses) / building.mass
            if isinstance(building, Storeys)
            else building.oscillator().inverse_mass
            for building in self.buildings[:2]
        )
        return 1.0 / (left + right)

    # -------------------------------------------------------------------------------------------- contact laws

    def law(self, name: str | None = None, stiffness: float | None = None) -> Any:
        """The contact law ``name`` (the first interface's own by default) with the first interface's stiffness.

        A law whose stiffness has the other unit (k in N/m against β in N/m^1.5) has no value of its own in
        the scene: pass the ``stiffness`` that the scene's equal terms lead to. Raises SceneError without it, and
        for a law that needs a restitution or the buildings' floors where the scene gives none; as `law_class` for a
        name.
        """
        name = self._own_name(name)
        law = self.law_class(name)
        if law.needs_restitution and self.restitution_words == NO_RESTITUTION:
            raise SceneError(self.source, [needed_restitution(name)])
        if needs_floors(law):
            if short := self.without_floor():
                advice = 'write floor_length = "20 m" in its [[building]]'
                raise SceneError(self.source, [f"{name} needs a length of every floor, {short[0]} has none; {advice}"])
            return law.between(*self.buildings[:2])
        if is_instant(law):
            return law()
        if fault := self.lacks_table(name):
            raise SceneError(self.source, [fault])
        table = self.interfaces[0].table
        if stiffness is None and table is not None and name == TABULATED != self.stiff_name:
            stiffness = table.stiffness
        if stiffness is None and self.stiffness is None:
            unit = stiffness_quantity(law).unit
            sentence = f"{name} needs a stiffness in {unit}, and the scene gives none; write it in [[interface]]"
            raise SceneError(self.source, [sentence])
        if stiffness is None and self._other_family(name):
            unit, own = stiffness_quantity(law).unit, stiffness_quantity(known_law(self.stiff_name)).unit
            sentence = (
                f"{name} takes a stiffness in {unit}, the scene gives one in {own} for {self.stiff_name}; "
                f'write equal_terms = {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}} in [[interface]], '
                "from which it follows"
            )
            raise SceneError(self.source, [sentence])
        values: dict[str, Any] = {"stiffness": self.stiffness if stiffness is None else float(stiffness)}
        values |= {key: getattr(self.interfaces[0], key) for key in PARAMETERS if key in law._fields}
        return law(**values)

    def lacks_table(self, name: str) -> str:
        """Why a contact model without its table cannot be had; "" for other names, and where the scene gives one."""
        if name != TABULATED or self.interfaces[0].table is not None:
            return ""
        return f'the scene gives no table of forces; write table = "bumper.csv" in [[interface]] for {TABULATED}'

    def _own_name(self, name: str | None) -> str:
        return self.interfaces[0].contact_model if name in (None, OF_EACH_INTERFACE) else str(name)

    def without_floor(self) -> tuple[str, ...]:
        """The buildings of which a model of colliding floors would miss the length; a rigid one is a wall."""
        return tuple(
            building.name
            for building in self.buildings
            if not building.is_rigid and not getattr(building, "floor_length", 0.0)
        )

    def law_class(self, name: str) -> Any:
        """The class of a contact law under the scene's damping relation.

        Raises PoundingError for a name that is no law's, and for a law that the relation is not known for.
        """
        return related(known_law(self._own_name(name)), self.relation)

    def needs_equal_terms(self, name: str) -> bool:
        """True where the law's stiffness follows from the scene's equal terms, and is not the scene's own."""
        name = self._own_name(name)
        if is_instant(known_law(name)) or self.stiffness is None:
            return False
        if self.equal_terms and self.equal_terms.every_law:
            return name != self.stiff_name
        return self._other_family(name)

    def _other_family(self, name: str) -> bool:
        """True where the law's stiffness has another unit than the scene's; that of a table is its own."""
        if name == TABULATED:
            return False
        return stiffness_quantity(known_law(name)).unit != stiffness_quantity(known_law(self.stiff_name)).unit

    @property
    def stiff_name(self) -> str:
        """The contact model whose stiffness the scene gives: its own, or the grid's first that takes one."""
        own = self.interfaces[0].contact_model
        return stiff_model(own, self._gridded_models) or own

    @property
    def folder(self) -> Path:
        """The folder that record files are relative to: the scene file's."""
        return Path(self.source).parent

    # -------------------------------------------------------------------------------------------- changing

    def updated(self, **values: Any) -> Scene:
        """The scene with these fields, which are not checked; what interfaces have is set at every one.

        ``restitution``, ``restitution_words`` and ``relation`` are what the properties of these names are.
        """
        interfaces = values.get("interfaces", self.interfaces)
        if restitution := {OF_RESTITUTION[key]: values.pop(key) for key in OF_RESTITUTION if key in values}:
            interfaces = [one.updated(restitution=one.restitution._replace(**restitution)) for one in interfaces]
        between = {key: values.pop(key) for key in list(values) if key in ResolvedInterface.model_fields}
        values["interfaces"] = tuple(one.updated(**between) if between else one for one in interfaces)
        return _made({part.name: getattr(self, part.name) for part in fields(self)} | values)

    def replace(self, *overrides: str, **values: Any) -> Scene:
        """The scene with other values, checked as a scene that is read.

        Parameters
        ----------
        *overrides : str
            Keys by their paths, as ``--set`` of a command takes them: ``'building.frame.mass="50 t"'``.
        **values
            ``buildings``, ``interfaces``, ``records``, ``grid``, ``effects``, ``solver``, ``damage`` or ``name`` as a
            whole; or
            a key of the grid (``gap``, ``yield_force``, ``contact_model``, ``pga``, ``interface``), whose single value
            counts as a list of one, or of the solver (``rtol``).

        Raises
        ------
        SceneError
            As `Scene`, and for what is no key.
        """
        if wrong := [override for override in overrides if not isinstance(override, str)]:
            raise SceneError(self.source, [f"replace: {wrong[0]!r} is no override; write 'interface.gap=\"20 mm\"'"])
        tables = self.resolved()
        for key, value in values.items():
            if key in Grid.model_fields:
                single = key not in ("interface", "axes", "zip") and not isinstance(value, list | tuple | dict)
                table: Any = Grid
                tables["grid"] |= _written("grid", table(**{key: [value] if single else value}))
            elif key in Solver.model_fields:
                tables["solver"] |= Solver(**{key: value}).written()
            elif key in Uncertain.model_fields:
                tables[UNCERTAIN] = tables.get(UNCERTAIN, {}) | _written(UNCERTAIN, Uncertain(**{key: value}))
            elif key in PARTS:
                tables |= [_section(key, value)]
            else:
                known = ", ".join(PARTS)
                raise SceneError(self.source, [f"replace: no {key}; it takes {known}, or a key of grid or solver"])
        return scene_of(tables, self.source, overrides)

    def with_samples(self, points: Any) -> Scene:
        """The scene with its uncertain numbers at other points than those that are drawn, such as those of a design.

        Parameters
        ----------
        points : array
            (samples, numbers), from 0 to 1 and independent: see `UncertainNumbers.values_at`.

        Raises
        ------
        SceneError
            For a scene without uncertain numbers, and for points of another shape.
        """
        if self.uncertain is None:
            raise SceneError(self.source, ["with_samples: the scene has no uncertain numbers; write [uncertain]"])
        return self.replace(uncertain=self.uncertain.with_points(points))

    def validate(self) -> Any:
        """Check the scene and its records, and sum them up: `pounding_risk.validate`."""
        return import_module("pounding_risk").validate(self)

    def scan(self, out: str | Path | None = None, **options: Any) -> Any:
        """Run every case of the grid: `pounding_risk.scan`, whose parameters it takes."""
        return import_module("pounding_risk").scan(self, out, **options)

    # -------------------------------------------------------------------------------------------- writing

    def resolved(self) -> dict[str, Any]:
        """The scene as a dict of the scene file's shape, every value stated, quantities exact in SI units."""
        buildings = [table_of(building).written() | self._depth(at) for at, building in enumerate(self.buildings)]
        interfaces = [interface.as_written(self._gridded_models) for interface in self.interfaces]
        effects = {effect.name: effect.written() for effect in self.effects}
        return {
            "scene": {"name": self.name},
            "building": buildings,
            "interface": interfaces,
            **({"effects": effects} if effects else {}),
            "records": records_of(self.records, self.grid.amplitudes).written(),
            "grid": self._grid().written() | written_axes(self.axes),
            **({} if self.uncertain is None else {UNCERTAIN: table_of_numbers(self.uncertain)}),
            "solver": Solver.from_values({"rtol": self.rtol}).written(),
            **({"damage": [state.written() for state in self.damage]} if self.damage else {}),
        }

    def to_toml(self, *, as_written: bool = False) -> str:
        """The text of a scene file; reading it gives an equal scene.

        Parameters
        ----------
        as_written : bool
            The text that the scene was read from, with its comments, and the values of its overrides in their place;
            otherwise every value stated, in SI, as also for a scene that was not read.
        """
        if as_written and self.text:
            return written_overrides(self.text, self.overrides, self.source)
        return write_toml(self.resolved())

    def _grid(self) -> Grid:
        """The table [grid], every value stated."""
        forces = self.grid.yield_forces
        own = {interface.yield_force for interface in self.interfaces}
        # An uncertain gap is that of the grid, which then has none of its own.
        draws_gap = self.uncertain is not None and has_gap(self.uncertain.keys)
        draws_gap = draws_gap and self.grid.gaps == (self.interfaces[0].gap,)
        values = {
            "gap": () if draws_gap else self.grid.gaps,
            "interface": None if draws_gap else self.gridded_interface,
            # A grid of one yield force would be that of every interface; where they differ, each keeps its own.
            "yield_force": forces if len(forces) > 1 or len(own) < 2 else (),
            "contact_model": self._gridded_models,
            "pga": tuple(level.value for level in self.grid.amplitudes if level and level.measure == PEAK),
        }
        return Grid.from_values({key: value for key, value in values.items() if value})

    def _depth(self, place: int) -> dict[str, Any]:
        """The depth of the floors of building ``place``, as a scene file has it; nothing of a pair."""
        if not self.is_row:
            return {}
        is_last = place == len(self.interfaces)
        levels = self.interfaces[place - is_last].levels
        return {"floor_depth": exact(float(levels.right_depth if is_last else levels.left_depth), FLOOR_DEPTH)}


def _made(values: Mapping[str, Any]) -> Scene:
    scene: Scene = object.__new__(Scene)
    if unknown := set(values) - {part.name for part in fields(Scene)}:
        raise TypeError(f"a scene has no field {', '.join(sorted(unknown))}")
    scene.__dict__.update(values)
    return scene


def _section(part: str, value: Any) -> tuple[str, Any]:
    """The section of a scene file that a part of a scene is, and its tables as the file has them."""
    section = PARTS[part]
    if part == "name":
        return section, {"name": value}
    if part == "effects":
        return section, effect_tables(value)
    if section not in ARRAYS:
        return section, _written(section, value)
    tables = list(value) if isinstance(value, Iterator | tuple) else value
    return section, [_written(section, table) for table in tables] if isinstance(tables, list) else tables


def _written(section: str, table: Any) -> Any:
    """A table of Python as a scene file has it."""
    if isinstance(table, Building | Storeys):
        return table_of(table).written()
    if isinstance(table, ResolvedInterface):
        return table.as_written(())
    if isinstance(table, UncertainNumbers):
        return table_of_numbers(table)
    if not isinstance(table, Table | Mapping):
        return table
    written = table.written() if isinstance(table, Table) else in_text(KEYS[section], table)
    if section == "grid":
        return axes_in_text(written, KEYS)
    if section == UNCERTAIN:
        return numbers_in_text(written, KEYS)
    return with_stiffness_unit(written) if section == "interface" and isinstance(table, Mapping) else written


# ------------------------------------------------------------------------------------------------ from tables


def scene_of(
    tables: Mapping[str, Any],
    source: str = "scene",
    overrides: Sequence[str] = (),
    *,
    text: str = "",
    lines: Mapping[KeyPath, int] | None = None,
    same: Same = MappingProxyType({}),
) -> Scene:
    """The scene of the tables of a scene file, with overrides applied.

    Parameters
    ----------
    tables : mapping
        As the file has them, quantities as text.
    source : str
        The file; record files are relative to its folder.
    overrides : sequence of str
        Keys set from outside, one `path=value` each.
    text : str
        The file's text; that of the scene, every value stated, by default.
    lines : mapping, optional
        The line of each key, for sentences.
    same : mapping, optional
        Sections that were read before, as `sections.read_tables` takes them.

    Raises
    ------
    SceneError
        With every fault: its line, its key and the likely repair.
    """
    overrides = (overrides,) if isinstance(overrides, str) else tuple(overrides)
    lines = lines or {}
    draft, faults, in_words = read_tables(tables, overrides, source, same)
    faults += every_fault(draft, Path(source).parent, same)
    if not faults:
        values, faults = _assembled(draft, plain(Path(source).stem))
        values |= {"text": text, "source": source, "overrides": overrides}
    if not faults:
        faults = list(_overlaps(_made(values)))
    if faults:
        raise SceneError(source, in_words(faults, lines))
    scene = _made(values)
    scene = scene if text else scene.updated(text=scene.to_toml())
    if scene.axes:
        placed = [*draft.axes, *(Placed((UNCERTAIN,), axis) for axis in scene.axes if axis.dimension)]
        faults = list(axis_faults(scene, placed, Scenes(scene, tables, overrides).made))
    if faults:
        raise SceneError(source, in_words(faults, lines))
    return scene


class Scenes:
    """The scenes that a scene becomes as keys are set; ``tables`` and ``overrides`` are those that it is made from."""

    def __init__(self, study: Scene, tables: Mapping[str, Any], overrides: Sequence[str]):
        self._text, self._source, self._kept = study.text, study.source, keeping_axes(overrides)
        # With what was set from outside, so that setting it again changes nothing in sections that are not read again.
        self._tables = overridden(without_axes(tables), self._kept, study.source)
        self._draft, _, _ = read_tables(self._tables, self._kept, study.source)

    def made(self, overrides: Sequence[str]) -> Scene:
        """The scene with these values set, and no axes."""
        same = untouched(self._draft, overrides)
        return scene_of(self._tables, self._source, (*self._kept, *overrides), text=self._text, same=same)


def _assembled(draft: Draft, usual_name: str) -> tuple[dict[str, Any], list[Fault]]:
    """The fields of the scene of tables that have each no fault, and the faults that only the whole has."""
    grid: Grid = Grid.from_values(draft.table("grid").values)
    records = draft.table("records")
    named = draft.table("effects").values
    effects = tuple(named[name] for name in EFFECTS if name in named)
    row, uncertain = is_row(draft), uncertain_of(draft)
    buildings, faults = _buildings(draft, effects)
    levels = records.get("intensity") or ()
    faults += [Fault(("records", "intensity", "of"), sentence) for sentence in relative_faults(levels, buildings)]
    if faults:
        return {}, faults
    interfaces, faults = resolved_interfaces(draft, buildings, grid, row)
    own: Interface = Interface.from_values(draft.tables("interface")[0].values)
    table: Records = Records.from_values(records.values)
    laws = dict.fromkeys(interface.contact_model for interface in interfaces)
    gridded = grid.interface or None
    if not gridded and not grid.gap and len({interface.gap for interface in interfaces}) > 1:
        gridded = interface_name(buildings[0].name, buildings[1].name)  # several gaps, and no grid of them
    values = {
        "name": draft.table("scene").get("name") or usual_name,
        "buildings": buildings,
        "interfaces": interfaces,
        "records": table.request(),
        "grid": Axes(
            grid.gap or (interfaces[0].gap,),
            grid.yield_force or (own.yield_force,),
            grid.contact_model or (tuple(laws) if len(laws) == 1 else (OF_EACH_INTERFACE,)),
            tuple(map(at_pga, grid.pga or ())) or at_periods(levels, buildings) or (at_pga(records.get("pga")),),
        ),
        "rtol": Solver.from_values(draft.table("solver").values).rtol,
        "effects": effects,
        "is_row": row,
        "gridded_interface": gridded,
        "axes": (*(placed.axis for placed in draft.axes), *(() if uncertain is None else (uncertain.axis,))),
        "uncertain": uncertain,
        "damage": tuple(DamageState.from_values(keys.values) for keys in draft.tables("damage")),
    }
    jumps = [] if faults else [name for name in _made(values).model_names if is_instant(known_law(name))]
    stuck = between_walls(_made(values)) if jumps else None
    return values, faults if stuck is None else [stuck._replace(sentence=f"{jumps[0]}: {stuck.sentence}")]


def between_walls(scene: Scene) -> Fault | None:
    """What keeps masses between two rigid buildings from moving as rigid bodies; None where they can."""
    rigid = [place for place, building in enumerate(scene.buildings) if building.is_rigid]
    for left, right in pairwise(rigid):
        walls = f"{scene.buildings[left].name} and {scene.buildings[right].name}"
        supports = scene.supports
        if right > left + 1 and supports and supports[left] != supports[right]:
            sentence = f"{walls} move towards each other, and would crush rigid bodies between them; remove it"
            one, other = (scene.buildings[place].support for place in (left, right))
            keys = [key for key, field in OF_GROUND.items() if getattr(one, field) != getattr(other, field)]
            return Fault(("building", right, keys[0]) if keys else ("effects", "wave_passage"), sentence)
        bumpers = scene.bumpers or (0.0,) * len(scene.interfaces)
        clear = (np.subtract(scene.interface_gaps(gap), bumpers)[left:right] for gap in scene.grid.gaps)
        if right > left + 1 and not all(gaps.any() for gaps in clear):
            sentence = f"without any gap between {walls} nothing there can move, and no force is determined; write one"
            return Fault(("interface", left, "gap"), sentence)
    return None


def _overlaps(scene: Scene) -> Iterator[Fault]:
    """A fault for every interface that initial displacements close by more than its smallest gap."""
    smallest = scene.interface_gaps(min(scene.grid.gaps))
    for place, (gap, interface) in enumerate(zip(smallest, scene.interfaces, strict=True)):
        left, right = scene.buildings[place : place + 2]
        bumper = interface.bumper_length or 0.0
        if bumper > gap:
            yield Fault(
                ("interface", place, "bumper_length"),
                f"{say(bumper, GAP)} do not fit into a gap of {say(gap, GAP)}; write shorter bumpers "
                "or wider gaps, which are those between the faces",
            )
            continue
        closing = max(
            (_initial_place(left, point.left_floor) - _initial_place(right, point.right_floor))
            for point in interface.points
        )
        if closing > gap - bumper:
            of_bumper = f", {say(gap - bumper, GAP)} of them clear of bumpers" if bumper else ""
            yield Fault(
                ("interface", place, "gap"),
                f"{say(gap, GAP)}{of_bumper}, and the initial_displacement of {left.name} and {right.name} closes "
                f"{say(closing, GAP)}: they would stand in each other when the motion begins; write wider gaps or "
                "smaller displacements",
            )


def _initial_place(building: Building | Storeys, floor: float) -> float:
    """Initial displacement [m] at a floor number, that of a column between those of its floors."""
    if isinstance(building, Building):
        return building.initial_displacement
    displacements = building.initial_displacement or (0.0,) * len(building.masses)
    floors = (0.0, *displacements)
    below = min(int(floor), len(floors) - 2)
    return floors[below] + (floor - below) * (floors[below + 1] - floors[below])


def _buildings(draft: Draft, effects: tuple[Effect, ...]) -> tuple[tuple[Building | Storeys, ...], list[Fault]]:
    """The buildings, and a fault for each that is none, or that an effect on buildings does not fit."""
    buildings, faults = [], []
    for keys in draft.tables("building"):
        try:
            buildings.append(structure_of(keys))
            chain_of(buildings[-1], effects)
        except PoundingError as error:
            faults.append(Fault(keys.path, str(error)))
    late = [place for place, building in enumerate(buildings) if building.support.delay]
    if late and "wave_passage" in dict(effects):
        words = "the wave says when the motion reaches each building, and so does ground_delay; keep one of the two"
        faults.append(Fault(("effects", "wave_passage"), f"wave_passage: {words}"))
    if not faults and "inelastic_storeys" in dict(effects) and not any(building.strengths for building in buildings):
        faults.append(Fault(("effects", "inelastic_storeys"), NO_STRENGTHS))
    return tuple(buildings), faults


# ------------------------------------------------------------------------------------------------ about scenes


def own_amplitude(scene: Scene) -> Level | None:
    """The amplitude of the grid that [records] gives too, or the largest; None where the grid has none."""
    own = at_pga(scene.records.pga)
    return own if own in scene.grid.amplitudes else scene.grid.amplitudes[-1]


def own_laws(scene: Scene) -> dict[str, str]:
    """Digests of the code of those contact laws, and effects, of the scene that are not the package's."""
    from pounding_risk.models.contact.register import is_own, law_digest

    kinds = {name: known_law(name) for name in scene.model_names}
    kinds |= {f"effect {effect.name}": EFFECTS[effect.name] for effect in scene.effects}
    return {name: law_digest(kind) for name, kind in kinds.items() if is_own(kind)}


def plugins_of(scene: Scene) -> list[Plugin]:
    """The plug-ins that a scene uses: contact laws, effects, kinds of motion and processing steps."""
    steps = scene.records.processing if isinstance(scene.records.processing, tuple) else ()
    used = {
        "laws": scene.model_names,
        "effects": [effect.name for effect in scene.effects],
        "motions": [recipe.kind for recipe in scene.records.generated],
        "steps": [step["step"] for step in steps],
    }
    pairs = dict.fromkeys((group, name) for group, names in used.items() for name in names)
    return [plugin for group, name in pairs if (plugin := plugin_of(group, name)) is not None]
