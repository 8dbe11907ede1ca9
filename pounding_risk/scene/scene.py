"""A scene: buildings, interfaces between neighbours, ground motions and the grid of cases, ready to be run.

It is written as TOML or in Python. Both become the tables of a scene file, which are read in one way: `read_tables`
reads every key, the checks report what does not go together, `assembled` makes the fields of a `Scene`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pounding_risk._common.letters import plain
from pounding_risk._common.plugins import Plugin, plugin_of
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import PEAK, Level, at_pga
from pounding_risk.scene.axes import Placed, axes_in_text, axis_faults, keeping_axes, without_axes, written_axes
from pounding_risk.scene.building_keys import OF_GROUND
from pounding_risk.scene.buildings import structure_of, table_of
from pounding_risk.scene.damage import DamageState
from pounding_risk.scene.interfaces import Interface, interface_name, known_law, with_stiffness_unit
from pounding_risk.scene.keys import Draft, Table, in_text
from pounding_risk.scene.levels import at_periods, relative_faults
from pounding_risk.scene.overrides import ARRAYS
from pounding_risk.scene.records import Records, records_of
from pounding_risk.scene.resolved_interfaces import ResolvedInterface, is_row, resolved_interfaces
from pounding_risk.scene.scene_axis import UNCERTAIN, has_gap
from pounding_risk.scene.sections import KEYS, Same, every_fault, overridden, read_tables, untouched, written_overrides
from pounding_risk.scene.tables import Effect, Grid, Solver, effect_tables
from pounding_risk.scene.toml import Fault, KeyPath, write_toml
from pounding_risk.scene.uncertain import UncertainNumbers
from pounding_risk.scene.uncertain_tables import Uncertain, numbers_in_text, table_of_numbers, uncertain_of
from pounding_risk.scene.values import OF_EACH_INTERFACE, Axes, SceneValues
from pounding_risk.units import GAP, exact, say, shown

# ------------------------------------------------------------------------------------------------ assembly
NO_STRENGTHS = (
    "no storey of the scene has a yield shear, so that none would yield; write storey_strengths in a [[building]], or "
    "generate one from a typology, or remove inelastic_storeys"
)


def assembled(draft: Draft, usual_name: str) -> tuple[dict[str, Any], list[Fault]]:
    """The fields of the scene of tables without faults of their own, and the faults that only the whole scene has."""
    grid: Grid = Grid.from_values(draft.table("grid").values)
    records = draft.table("records")
    named_effects = draft.table("effects").values
    effects = tuple(named_effects[name] for name in EFFECTS if name in named_effects)
    as_row, uncertain = is_row(draft), uncertain_of(draft)
    buildings, faults = _buildings(draft, effects)
    levels = records.get("intensity") or ()
    faults += [Fault(("records", "intensity", "of"), sentence) for sentence in relative_faults(levels, buildings)]
    if faults:
        return {}, faults
    interfaces, faults = resolved_interfaces(draft, buildings, grid, as_row)
    first_table: Interface = Interface.from_values(draft.tables("interface")[0].values)
    table: Records = Records.from_values(records.values)
    laws = dict.fromkeys(interface.contact_model for interface in interfaces)
    gridded_name = grid.interface or None
    if not gridded_name and not grid.gap and len({interface.gap for interface in interfaces}) > 1:
        gridded_name = interface_name(buildings[0].name, buildings[1].name)  # several gaps, and no grid of them
    values = {
        "name": draft.table("scene").get("name") or usual_name,
        "buildings": buildings,
        "interfaces": interfaces,
        "records": table.request(),
        "grid": Axes(
            grid.gap or (interfaces[0].gap,),
            grid.yield_force or (first_table.yield_force,),
            grid.contact_model or (tuple(laws) if len(laws) == 1 else (OF_EACH_INTERFACE,)),
            tuple(map(at_pga, grid.pga or ())) or at_periods(levels, buildings) or (at_pga(records.get("pga")),),
        ),
        "rtol": Solver.from_values(draft.table("solver").values).rtol,
        "effects": effects,
        "is_row": as_row,
        "gridded_interface": gridded_name,
        "axes": (*(placed.axis for placed in draft.axes), *(() if uncertain is None else (uncertain.axis,))),
        "uncertain": uncertain,
        "damage": tuple(DamageState.from_values(keys.values) for keys in draft.tables("damage")),
    }
    return values, faults or _misfit_faults(SceneValues.made(values))


def _misfit_faults(scene: SceneValues) -> list[Fault]:
    """Masses that jump between walls and cannot move, or else buildings that stand in each other."""
    jumps = [name for name in scene.model_names if is_instant(known_law(name))]
    if jumps and (stuck := between_walls(scene)):
        return [stuck._replace(sentence=f"{jumps[0]}: {stuck.sentence}")]
    return list(_overlap_faults(scene))


def between_walls(scene: SceneValues) -> Fault | None:
    """The fault of masses between two rigid buildings that cannot move as rigid bodies; None where they can."""
    rigid_places = [place for place, building in enumerate(scene.buildings) if building.is_rigid]
    for left, right in pairwise(rigid_places):
        walls = f"{scene.buildings[left].name} and {scene.buildings[right].name}"
        supports = scene.supports
        if right > left + 1 and supports and supports[left] != supports[right]:
            sentence = f"{walls} move towards each other, and would crush rigid bodies between them; remove it"
            left_base, right_base = (scene.buildings[place].support for place in (left, right))
            keys = [key for key, field in OF_GROUND.items() if getattr(left_base, field) != getattr(right_base, field)]
            return Fault(("building", right, keys[0]) if keys else ("effects", "wave_passage"), sentence)
        bumpers = scene.bumpers or (0.0,) * len(scene.interfaces)
        clear_gaps = (np.subtract(scene.interface_gaps(gap), bumpers)[left:right] for gap in scene.grid.gaps)
        if right > left + 1 and not all(gaps.any() for gaps in clear_gaps):
            sentence = f"without any gap between {walls} nothing there can move, and no force is determined; write one"
            return Fault(("interface", left, "gap"), sentence)
    return None


def _overlap_faults(scene: SceneValues) -> Iterator[Fault]:
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
            (_initial_displacement_at(left, point.left_floor) - _initial_displacement_at(right, point.right_floor))
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


def _initial_displacement_at(building: Building | Storeys, floor: float) -> float:
    """Initial displacement [m] at a floor number, that of a column between those of its floors."""
    if isinstance(building, Building):
        return building.initial_displacement
    displacements = building.initial_displacement or (0.0,) * len(building.masses)
    floors = (0.0, *displacements)
    floor_below = min(int(floor), len(floors) - 2)
    return floors[floor_below] + (floor - floor_below) * (floors[floor_below + 1] - floors[floor_below])


def _buildings(draft: Draft, effects: tuple[Effect, ...]) -> tuple[tuple[Building | Storeys, ...], list[Fault]]:
    """The buildings, and a fault for each that is none, or that an effect on buildings does not fit."""
    buildings, faults = [], []
    for keys in draft.tables("building"):
        try:
            buildings.append(structure_of(keys))
            chain_of(buildings[-1], effects)
        except PoundingError as error:
            faults.append(Fault(keys.path, str(error)))
    delayed = [place for place, building in enumerate(buildings) if building.support.delay]
    if delayed and "wave_passage" in dict(effects):
        words = "the wave says when the motion reaches each building, and so does ground_delay; keep one of the two"
        faults.append(Fault(("effects", "wave_passage"), f"wave_passage: {words}"))
    if not faults and "inelastic_storeys" in dict(effects) and not any(building.strengths for building in buildings):
        faults.append(Fault(("effects", "inelastic_storeys"), NO_STRENGTHS))
    return tuple(buildings), faults


# ------------------------------------------------------------------------------------------------ scene
# The parts of a scene, and the sections of a scene file that they are.
PARTS = {"buildings": "building", "interfaces": "interface"}
PARTS |= {part: part for part in ("records", "grid", UNCERTAIN, "effects", "solver", "damage")} | {"name": "scene"}


@dataclass(frozen=True, repr=False, init=False, eq=False)
class Scene(SceneValues):
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
        needed_parts = {"buildings": buildings, "interfaces": interfaces, "records": records}
        optional_parts = {
            "grid": grid,
            UNCERTAIN: uncertain,
            "effects": effects or None,
            "solver": solver,
            "damage": damage or None,
            "name": name or None,
        }
        given_parts = needed_parts | {part: value for part, value in optional_parts.items() if value is not None}
        tables = dict(_section(part, value) for part, value in given_parts.items())
        if not isinstance(folder, str | PathLike):
            raise SceneError("scene", [f"folder: {shown(folder)} is no folder; write one, or leave it out"])
        self.__dict__.update(vars(scene_of(tables, str(Path(folder) / "scene"))))

    # -------------------------------------------------------------------------------------------- changing

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
        if flaws := [override for override in overrides if not isinstance(override, str)]:
            raise SceneError(self.source, [f"replace: {flaws[0]!r} is no override; write 'interface.gap=\"20 mm\"'"])
        tables = self.resolved()
        for key, value in values.items():
            if key in Grid.model_fields:
                is_single = key not in ("interface", "axes", "zip") and not isinstance(value, list | tuple | dict)
                table: Any = Grid
                tables["grid"] |= _file_table("grid", table(**{key: [value] if is_single else value}))
            elif key in Solver.model_fields:
                tables["solver"] |= Solver(**{key: value}).written()
            elif key in Uncertain.model_fields:
                tables[UNCERTAIN] = tables.get(UNCERTAIN, {}) | _file_table(UNCERTAIN, Uncertain(**{key: value}))
            elif key in PARTS:
                tables |= [_section(key, value)]
            else:
                parts = ", ".join(PARTS)
                raise SceneError(self.source, [f"replace: no {key}; it takes {parts}, or a key of grid or solver"])
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
        buildings = [table_of(building).written() | self._depth(index) for index, building in enumerate(self.buildings)]
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
        interface_forces = {interface.yield_force for interface in self.interfaces}
        # An uncertain gap is that of the grid, which then has none of its own.
        draws_gap = self.uncertain is not None and has_gap(self.uncertain.keys)
        draws_gap = draws_gap and self.grid.gaps == (self.interfaces[0].gap,)
        values = {
            "gap": () if draws_gap else self.grid.gaps,
            "interface": None if draws_gap else self.gridded_interface,
            # A grid of one yield force would be that of every interface; where they differ, each keeps its own.
            "yield_force": forces if len(forces) > 1 or len(interface_forces) < 2 else (),
            "contact_model": self._gridded_models,
            "pga": tuple(level.value for level in self.grid.amplitudes if level and level.measure == PEAK),
        }
        return Grid.from_values({key: value for key, value in values.items() if value})

    def _depth(self, place: int) -> dict[str, Any]:
        """The floor depth of building ``place``, as a scene file has it; nothing for a pair."""
        if not self.is_row:
            return {}
        is_last = place == len(self.interfaces)
        levels = self.interfaces[place - is_last].levels
        return {"floor_depth": exact(float(levels.right_depth if is_last else levels.left_depth), FLOOR_DEPTH)}


def _section(part: str, value: Any) -> tuple[str, Any]:
    """The section of a scene file that a part of a scene is, and its tables as the file has them."""
    section = PARTS[part]
    if part == "name":
        return section, {"name": value}
    if part == "effects":
        return section, effect_tables(value)
    if section not in ARRAYS:
        return section, _file_table(section, value)
    tables = list(value) if isinstance(value, Iterator | tuple) else value
    return section, [_file_table(section, table) for table in tables] if isinstance(tables, list) else tables


def _file_table(section: str, table: Any) -> Any:
    """A table of Python as a scene file has it."""
    if isinstance(table, Building | Storeys):
        return table_of(table).written()
    if isinstance(table, ResolvedInterface):
        return table.as_written(())
    if isinstance(table, UncertainNumbers):
        return table_of_numbers(table)
    if not isinstance(table, Table | Mapping):
        return table
    file_table = table.written() if isinstance(table, Table) else in_text(KEYS[section], table)
    if section == "grid":
        return axes_in_text(file_table, KEYS)
    if section == UNCERTAIN:
        return numbers_in_text(file_table, KEYS)
    return with_stiffness_unit(file_table) if section == "interface" and isinstance(table, Mapping) else file_table


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
        values, faults = assembled(draft, plain(Path(source).stem))
    if faults:
        raise SceneError(source, in_words(faults, lines))
    scene = Scene.made(values | {"text": text, "source": source, "overrides": overrides})
    scene = scene if text else scene.updated(text=scene.to_toml())
    if scene.axes:
        placed_axes = [*draft.axes, *(Placed((UNCERTAIN,), axis) for axis in scene.axes if axis.dimension)]
        faults = list(axis_faults(scene, placed_axes, Scenes(scene, tables, overrides).made))
    if faults:
        raise SceneError(source, in_words(faults, lines))
    return scene


class Scenes:
    """The scenes that follow from a scene as keys are set; it is made from ``tables`` and ``overrides``."""

    def __init__(self, study: Scene, tables: Mapping[str, Any], overrides: Sequence[str]):
        self._text, self._source, self._kept = study.text, study.source, keeping_axes(overrides)
        # With the overrides applied, so that applying them again changes nothing in sections that are not read again.
        self._tables = overridden(without_axes(tables), self._kept, study.source)
        self._draft, _, _ = read_tables(self._tables, self._kept, study.source)

    def made(self, overrides: Sequence[str]) -> Scene:
        """The scene with these values set, and no axes."""
        same = untouched(self._draft, overrides)
        return scene_of(self._tables, self._source, (*self._kept, *overrides), text=self._text, same=same)


# ------------------------------------------------------------------------------------------------ about scenes


def own_amplitude(scene: Scene) -> Level | None:
    """The amplitude of the grid that [records] gives too, or the largest; None where the grid has none."""
    of_records = at_pga(scene.records.pga)
    return of_records if of_records in scene.grid.amplitudes else scene.grid.amplitudes[-1]


def own_laws(scene: Scene) -> dict[str, str]:
    """Digests of the code of those contact laws, and effects, of the scene that are not the package's."""
    from pounding_risk.models.contact.register import is_own, law_digest

    kinds = {name: known_law(name) for name in scene.model_names}
    kinds |= {f"effect {effect.name}": EFFECTS[effect.name] for effect in scene.effects}
    return {name: law_digest(kind) for name, kind in kinds.items() if is_own(kind)}


def plugins_of(scene: Scene) -> list[Plugin]:
    """The plug-ins that a scene uses: contact laws, effects, kinds of motion and processing steps."""
    steps = scene.records.processing if isinstance(scene.records.processing, tuple) else ()
    used_names = {
        "laws": scene.model_names,
        "effects": [effect.name for effect in scene.effects],
        "motions": [recipe.kind for recipe in scene.records.generated],
        "steps": [step.name for step in steps],
    }
    pairs = dict.fromkeys((group, name) for group, names in used_names.items() for name in names)
    return [plugin for group, name in pairs if (plugin := plugin_of(group, name)) is not None]
