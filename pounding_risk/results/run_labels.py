"""The dataset of one run with its histories: the same variables, coordinates and attributes whichever solver ran it.

A variable that a solver does not make is absent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.motions.motion import Motion
from pounding_risk.results.files import as_text, versions
from pounding_risk.results.layout import CaseVariable
from pounding_risk.results.pair_labels import OUTCOME, described, pair_variables, sources_of
from pounding_risk.results.row_labels import row_coordinates, row_variables
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE, STATUS_SENTENCES
from pounding_risk.solver.row.grid import RowGrid
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import Frame, frame_of

Array = NDArray[np.float64]
DATASET_VERSION = 2  # of the shape: 1 had no attribute for it, and another shape for a pair
TIME = ("time",)
FLOORS = ("time", "building", "storey")
POINTS = ("time", "contact_point")
GROUND = "ground acceleration; of a passing wave that under the first building"
HISTORIES = {
    "displacement": (FLOORS, "m", "displacement of the floor relative to the ground"),
    "velocity": (FLOORS, "m/s", "velocity of the floor relative to the ground"),
    "relative_displacement": (POINTS, "m", "what closes the gap: u_left - u_right, and what the ground adds"),
    "contact_force": (POINTS, "N", "contact force, compression positive"),
    "contact_impulse_so_far": (POINTS, "N s", "impulse of the contact force up to this instant"),
    "ground_acceleration": (TIME, "m/s2", GROUND),
    "building_ground_acceleration": (("time", "building"), "m/s2", "ground acceleration under the building"),
    "ground_widening": (("time", "interface"), "m", "widening of the ground between the buildings, x_right - x_left"),
    "energy_ground": (TIME, "J", "work that the ground has done on all buildings"),
    "energy_held": (TIME, "J", "kinetic and strain energy of all buildings"),
    "energy_contact": (TIME, "J", "work of the contact force, dissipated and stored"),
    "energy_damping": (TIME, "J", "energy that the structures' dampers have taken"),
}
GROUNDS = ("ground_acceleration", "building_ground_acceleration", "ground_widening")  # known after a failure too
CONTACTS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the record"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "restitution_asked": ("1", "restitution that the relation gives for this speed"),
    "peak_force": ("N", "largest force transmitted"),
    "uncapped_force": ("N", "largest force without the cap"),
    "peak_penetration": ("m", "largest penetration"),
    "yields": ("1", "times the uncapped force rose through the yield force"),
    "rebound_speed": ("m/s", "relative speed at the parting"),
    "impulse": ("N s", "impulse of the contact force"),
    "work": ("J", "work of the contact force: what the contact took"),
}


class Case(NamedTuple):
    """What is run: a motion under one contact model, with the gaps [m] and yield forces [N] of the contact points."""

    motion: Motion
    contact_model: str
    gap: float  # m, as the grid counts it: of all interfaces, or of the one that the grid varies
    yield_force: float  # N, as the grid counts it: of the floors
    gaps: Sequence[float]  # m, by interface
    yield_forces: Sequence[float]  # N, by contact point


class Trace(NamedTuple):
    """A run in full, as its solver logs it."""

    time: Array  # s
    histories: Mapping[str, Array]  # of `HISTORIES`, those that the solver makes
    contacts: Mapping[str, Array]  # of `CONTACTS` likewise, in the order of the touches
    contact_points: Sequence[int]  # index of the contact point of each contact
    variables: Mapping[str, CaseVariable]  # outputs, as a scan declares them
    outputs: Mapping[str, Any]  # their values
    status: int
    law: Any  # of the first interface, with the effects of the scene
    last: float = inf  # s, of a run that failed the last instant that is known


def run_dataset(study: Scene, case: Case, trace: Trace) -> xr.Dataset:
    """The dataset of a run."""
    coords = run_coordinates(study, case.gaps, case.yield_forces)
    attrs = {
        "dataset_version": DATASET_VERSION,
        "title": study.name,
        "contact_model": case.contact_model,
        "gap": case.gap,
        "yield_force": case.yield_force,
        "pga": case.motion.pga,
        "effects": ", ".join(effect.name for effect in study.effects),
        "references": "; ".join(sources_of(study, [trace.law])),
        "status": STATUS_SENTENCES[trace.status],
        "processing": as_text(list(case.motion.processing)),
        "scene_resolved": study.to_toml(),
        "versions": as_text(versions()),
    }
    return xr.Dataset(run_variables(trace, coords["contact_point"][1]), coords | time_of(trace.time), attrs)


def run_variables(trace: Trace, point_names: Sequence[str]) -> dict[str, Any]:
    """Histories, outputs and contacts as variables; a run that failed has no motion past its failure: NaN."""
    data: dict[str, Any] = {}
    for name, (dims, unit, words) in HISTORIES.items():
        if name in trace.histories:
            values = np.asarray(trace.histories[name])
            if trace.status != COMPLETE and name not in GROUNDS:
                known = trace.time <= trace.last
                values = np.where(known.reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)
            data[name] = (dims, values, described(unit, words))
    for name, variable in trace.variables.items():
        data[name] = (variable.dims, np.asarray(trace.outputs[name]).astype(variable.dtype), dict(variable.attrs))
    for name, (unit, words) in CONTACTS.items():
        if name in trace.contacts:
            data[f"contact_{name}"] = ("contact", trace.contacts[name], described(unit, words))
    names = np.array([point_names[index] for index in trace.contact_points], dtype=np.str_)
    return data | {"contact_place": ("contact", names, {"long_name": "contact point of the contact"})}


def outputs_of_pair() -> dict[str, CaseVariable]:
    """Outputs of a run of the pair's solver; those of a run stand at its one interface."""
    outputs = _without_outcome(pair_variables())
    return {name: output._replace(dims=output.dims or ("interface",)) for name, output in outputs.items()}


def outputs_of_row(frame: Frame) -> dict[str, CaseVariable]:
    """Outputs of a run of the row's solver."""
    return _without_outcome(row_variables(frame))


def _without_outcome(outputs: Mapping[str, CaseVariable]) -> dict[str, CaseVariable]:
    return {name: output for name, output in outputs.items() if name not in OUTCOME}


def run_coordinates(study: Scene, gaps: Sequence[float], yield_forces: Sequence[float]) -> dict[str, Any]:
    """Interfaces, contact points, buildings and storeys of one run, without its time."""
    names = [building.name for building in study.buildings]
    return grid_coordinates(study) | {
        "contact_point_yield_force": ("contact_point", list(yield_forces), described("N", "yield force F_E")),
        "interface_gap": ("interface", list(gaps), described("m", "clear distance at rest")),
        "building": ("building", names, {"long_name": "building, left to right"}),
    }


def time_of(time: Any) -> dict[str, Any]:
    """The coordinate time [s]."""
    return {"time": ("time", time, described("s", "time since the start of the record"))}


def grid_coordinates(study: Scene) -> dict[str, Any]:
    """Interfaces, contact points, buildings and storeys of a scene, with gaps and yield forces over its grid."""
    model = RowModel([chain_of(building) for building in study.buildings], study.points)
    gaps = np.array([study.interface_gaps(gap) for gap in study.grid.gaps])
    forces = np.array([level_forces(study, force) for force in study.grid.yield_forces])
    return row_coordinates(study, RowGrid(frame_of(model), (), gaps, forces, study.rtol))


def level_forces(study: Scene, force: float) -> tuple[float, ...]:
    """Yield forces of the contact points [N] at a yield force of the grid.

    Of a grid of one yield force several interfaces have their own.
    """
    is_own = len(study.grid.yield_forces) == 1 and len(study.neighbours) > 1
    return study.point_yield_forces(None if is_own else force)
