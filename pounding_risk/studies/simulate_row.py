"""Time histories of one run of a row: motion of every floor, force at every contact point, and every contact.

The run is, to the bit, the one that a scan makes of the case, recorded at the nodes of the record and at every step in
contact.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk.ensemble.row_grid import mechanics_of, row_grid
from pounding_risk.motions.motion import Motion
from pounding_risk.results.files import as_text, versions
from pounding_risk.results.labels import described, places_of, sources_of
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import RowRun
from pounding_risk.solver.row.cases import Cases, Driven, Limits
from pounding_risk.solver.row.grid import RowGrid
from pounding_risk.solver.row.outputs import outputs, variables
from pounding_risk.solver.row.trace_reader import (
    FACTS,
    Instants,
    Touched,
    contacts_of,
    forces_at,
    impulses_at,
    instants_of,
    motion_at,
)

Array = NDArray[np.float64]
FLOORS = ("time", "building", "storey")
POINTS = ("time", "contact_point")


class Cell(NamedTuple):
    """What is run: a motion under one contact model, with the gaps [m] and yield forces [N] of the contact points."""

    motion: Motion
    law: str
    gaps: Array
    yield_forces: Array


def cell_of(study: Scene, motion: Motion, law: str, gap: float | None, yield_force: float | None) -> Cell:
    """The scene's own gaps and yield forces, or those named.

    A gap is that of all interfaces, but of the only one that the grid varies where it names one.
    """
    varied = study.gridded_interface if len(study.grid.gaps) > 1 else None
    pairs = zip(study.interface_names, study.neighbours, strict=True)
    gaps = [neighbour.gap if gap is None or varied not in (None, name) else gap for name, neighbour in pairs]
    return Cell(motion, law, np.array(gaps), np.array(study.point_yield_forces(yield_force)))


def row_histories(study: Scene, cell: Cell) -> xr.Dataset:
    """The run with its histories, and every output of a case; raises as `row_grid`.

    Dimensions: time [s] (nodes of the record and every step in contact), building, storey, interface, contact_point,
    contact.
    """
    grid = row_grid(study)
    run, ground = _run(study, grid, cell)
    instants = instants_of(run.log, ground[0].size, ground[1])
    touches = contacts_of(run.log, len(grid.model.points), instants)
    data = _motion(grid, run, instants) | _forces(run, instants, touches)
    ground_acceleration = np.interp(instants.every, instants.nodes, ground[0])
    data["ground_acceleration"] = ("time", ground_acceleration, described("m/s2", "ground acceleration"))
    values = outputs(run, cell.yield_forces, cell.motion.pga, grid.frame)
    for name, variable in variables(grid.frame).items():
        data[name] = (variable.dims, values[name], described(variable.unit, variable.words))
    coords = places_of(study, grid.gaps, grid.yield_forces)
    coords["contact_point_yield_force"] = ("contact_point", cell.yield_forces, described("N", "yield force F_E"))
    coords["interface_gap"] = ("interface", cell.gaps, described("m", "clear distance at rest"))
    names = [building.name for building in study.buildings]
    coords["building"] = ("building", names, {"long_name": "building, left to right"})
    coords["time"] = ("time", instants.every, described("s", "time since the start of the record"))
    data |= _of_contacts(touches, coords["contact_point"][1])
    return xr.Dataset(data, coords=coords, attrs=_attributes(study, cell, run.status))


def _run(study: Scene, grid: RowGrid, cell: Cell) -> tuple[RowRun, tuple[Array, float]]:
    """The run of the case, and a_g at its nodes with the time between them."""
    model, motion = grid.model, cell.motion
    finite = np.unique(cell.yield_forces[np.isfinite(cell.yield_forces)])
    mechanics = mechanics_of(study, model, cell.law, finite)
    row = model.row(motion.dt)
    free = rows.free_row(row, motion.acceleration)
    cases = Cases(model, mechanics, Driven(motion.acceleration, motion.dt, motion.pga, free), study.rtol)
    run = cases.in_full(Limits(cell.gaps[model.interfaces], cell.yield_forces, cell.yield_forces))
    return run, (rows.nodes_of(row, motion.acceleration), row.step)


def _motion(grid: RowGrid, run: RowRun, instants: Instants) -> dict[str, Any]:
    """Displacements and velocities at every instant."""
    # A motion beyond all numbers is told by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        states = motion_at(run.log, run.states, instants)
    words = (("displacement", "m"), ("velocity", "m/s"))
    return {
        name: (
            FLOORS,
            _by_storey(grid, states[:, part]),
            described(unit, f"{name} of the floor relative to the ground"),
        )
        for part, (name, unit) in enumerate(words)
    }


def _forces(run: RowRun, instants: Instants, touches: list[Touched]) -> dict[str, Any]:
    """Contact forces and their impulses at every instant."""
    points = run.points.shape[0]
    words = "impulse of the contact force up to this instant"
    return {
        "contact_force": (
            POINTS,
            forces_at(touches, points, instants.every),
            described("N", "contact force, compression positive"),
        ),
        "contact_impulse_so_far": (POINTS, impulses_at(run.log, points, instants), described("N s", words)),
    }


def _of_contacts(touches: list[Touched], labels: list[str]) -> dict[str, Any]:
    """Facts of each contact of the run, in the order of their beginnings."""
    facts: dict[str, Any] = {
        f"contact_{name}": ("contact", np.array([touch.facts[column] for touch in touches]), described(unit, words))
        for column, (name, (unit, words)) in enumerate(FACTS.items())
    }
    where = np.array([labels[touch.place] for touch in touches], dtype=np.str_)
    return facts | {"contact_place": ("contact", where, {"long_name": "contact point of the contact"})}


def _by_storey(grid: RowGrid, values: Array) -> Array:
    """Values of the masses (instants, masses) as (instants, buildings, storeys); NaN where there is none."""
    indices = grid.frame.storeys
    return np.where(indices >= 0, values[:, np.maximum(indices, 0)] if values.shape[1] else np.nan, np.nan)


def _attributes(study: Scene, cell: Cell, status: int) -> dict[str, Any]:
    law = study.law_at(0, cell.law)
    return {
        "title": study.name,
        "contact_model": cell.law,
        "pga": cell.motion.pga,
        "effects": ", ".join(effect.name for effect in study.effects),
        "references": "; ".join(sources_of(study, [law])),
        "status": STATUS_SENTENCES[status],
        "processing": as_text(list(cell.motion.processing)),
        "scene_resolved": study.to_toml(),
        "versions": as_text(versions()),
    }
