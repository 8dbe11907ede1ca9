"""From tables without a fault of their own to the values of a scene, with the faults that only a whole scene has."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import at_pga
from pounding_risk.scene.building_keys import OF_GROUND
from pounding_risk.scene.buildings import structure_of
from pounding_risk.scene.damage import DamageState
from pounding_risk.scene.interface_checks import is_row
from pounding_risk.scene.interfaces import Interface, interface_name, known_law
from pounding_risk.scene.keys import Draft
from pounding_risk.scene.levels import at_periods, relative_faults
from pounding_risk.scene.records import Records
from pounding_risk.scene.resolved_interfaces import resolved_interfaces
from pounding_risk.scene.tables import Effect, Grid, Solver
from pounding_risk.scene.toml import Fault
from pounding_risk.scene.uncertain_tables import uncertain_of
from pounding_risk.scene.values import OF_EACH_INTERFACE, Axes, SceneValues
from pounding_risk.units import GAP, say

NO_STRENGTHS = (
    "no storey of the scene has a yield shear, so that none would yield; write storey_strengths in a [[building]], or "
    "generate one from a typology, or remove inelastic_storeys"
)


def assembled(draft: Draft, usual_name: str) -> tuple[dict[str, Any], list[Fault]]:
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
    first: Interface = Interface.from_values(draft.tables("interface")[0].values)
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
            grid.yield_force or (first.yield_force,),
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
    return values, faults or _misfits(SceneValues.made(values))


def _misfits(scene: SceneValues) -> list[Fault]:
    """Masses that jump between walls and cannot move, or else buildings that stand in each other."""
    jumps = [name for name in scene.model_names if is_instant(known_law(name))]
    if jumps and (stuck := between_walls(scene)):
        return [stuck._replace(sentence=f"{jumps[0]}: {stuck.sentence}")]
    return list(_overlaps(scene))


def between_walls(scene: SceneValues) -> Fault | None:
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


def _overlaps(scene: SceneValues) -> Iterator[Fault]:
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
