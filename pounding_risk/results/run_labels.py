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

from pounding_risk.motions.motion import Motion
from pounding_risk.results import accessor as accessor  # registers it with xarray
from pounding_risk.results import labels
from pounding_risk.results.attributes import DATASET_VERSION, VERSION, as_text
from pounding_risk.results.variables import described
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE, STATUS_SENTENCES

Array = NDArray[np.float64]

TIME = ("time",)
FLOORS = ("time", "building", "storey")
POINTS = ("time", "contact_point")
LINKS = ("time", "link")
GROUND = "ground acceleration; on unlike grounds that under the first building"
MOVED = (
    "displacement of the ground under the building since 0 s: the double integral of the ground acceleration, from the "
    "ground velocity of the scene; a record without baseline correction drifts"
)
HISTORIES = {
    "displacement": (FLOORS, "m", "displacement of the floor relative to the ground under the building"),
    "velocity": (FLOORS, "m/s", "velocity of the floor relative to the ground under the building"),
    "absolute_displacement": (FLOORS, "m", "displacement of the floor in space: displacement + ground_displacement"),
    "floor_rotation": (FLOORS, "1", "rotation of the floor about its centre of mass, anticlockwise from above"),
    "displacement_across": (FLOORS, "m", "displacement of the floor's centre of mass across the row, to its left"),
    "drift": (FLOORS, "m", "drift of the storey below the floor; of rows with storeys that yield"),
    "storey_force": (FLOORS, "N", "shear in the spring of the storey below the floor; of rows with storeys that yield"),
    "relative_displacement": (POINTS, "m", "what closes the gap: u_left - u_right, and what the ground adds"),
    "contact_force": (POINTS, "N", "contact force, compression positive"),
    "contact_impulse_so_far": (POINTS, "N s", "impulse of the contact force up to this instant"),
    "link_stretch": (LINKS, "m", "what stretches the link: u_right - u_left; below zero what shortens it"),
    "link_force": (
        LINKS,
        "N",
        "force of the link, k stretch, or that of its law, + c rate; positive where it pulls the buildings together",
    ),
    "ground_acceleration": (TIME, "m/s2", GROUND),
    "ground_acceleration_across": (TIME, "m/s2", "ground acceleration across the row, to its left"),
    "building_ground_acceleration": (("time", "building"), "m/s2", "ground acceleration under the building"),
    "ground_displacement": (("time", "building"), "m", MOVED),
    "ground_widening": (("time", "interface"), "m", "widening of the ground between the buildings, x_right - x_left"),
    "energy_ground": (TIME, "J", "work that the ground has done on all buildings"),
    "energy_held": (TIME, "J", "kinetic and strain energy of all buildings"),
    "energy_contact": (TIME, "J", "work of the contact force, dissipated and stored"),
    "energy_damping": (TIME, "J", "energy that the structures' dampers have taken"),
}
GROUNDS = (
    "ground_acceleration",
    "ground_acceleration_across",
    "building_ground_acceleration",
    "ground_displacement",
    "ground_widening",
)  # known after a failure too
CONTACTS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the record"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "restitution_asked": ("1", "restitution that the relation gives for this speed"),
    "peak_force": ("N", "largest force transmitted"),
    "uncapped_force": ("N", "largest force without the cap"),
    "peak_penetration": ("m", "largest penetration, from the gap that permanent indentations widen"),
    "yields": ("1", "times the uncapped force rose through the yield force"),
    "rebound_speed": ("m/s", "relative speed at the parting"),
    "impulse": ("N s", "impulse of the contact force"),
    "work": ("J", "work of the contact force: what the contact took"),
}
CONTACT_PLACE = {"long_name": "contact point of the contact"}  # which the reference of outputs prints too


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
    outputs: Mapping[str, tuple[Any, Array]]  # unit and words of each output, as a scan has them, and its value
    status: int
    law: Any  # of the first interface, with the effects of the scene
    last: float = inf  # s, of a run that failed the last instant that is known


def run_dataset(study: Scene, case: Case, trace: Trace) -> xr.Dataset:
    """The dataset of a run."""
    coords = run_coordinates(study, case, trace.time)
    attrs = {
        VERSION: DATASET_VERSION,
        "title": study.name,
        "contact_model": case.contact_model,
        "gap": case.gap,
        "yield_force": case.yield_force,
        "pga": case.motion.pga,
        "effects": ", ".join(effect.name for effect in study.effects),
        "references": "; ".join(labels.sources_of(study, [trace.law])),
        "status": STATUS_SENTENCES[trace.status],
        "processing": as_text(list(case.motion.processing)),
        "scene_resolved": study.to_toml(),
        **labels.plugin_attributes(study),
    }
    return xr.Dataset(run_variables(trace, coords["contact_point"][1]), coords, attrs)


def run_variables(trace: Trace, point_names: Sequence[str]) -> dict[str, Any]:
    """Histories, outputs and contacts as variables; a run that failed has no motion past its failure: NaN."""
    variables: dict[str, Any] = {}
    for name, (dims, unit, words) in HISTORIES.items():
        if name in trace.histories:
            history = np.asarray(trace.histories[name])
            if trace.status != COMPLETE and name not in GROUNDS:
                history = np.where((trace.time <= trace.last).reshape(-1, *[1] * (history.ndim - 1)), history, np.nan)
            variables[name] = (dims, history, described(unit, words))
    for name, (output, amount) in trace.outputs.items():
        dims, dtype, attributes = labels.case_variable(name, output)
        variables[name] = (dims, np.asarray(amount).astype(dtype), dict(attributes))
    for name, (unit, words) in CONTACTS.items():
        if name in trace.contacts:
            variables[f"contact_{name}"] = ("contact", trace.contacts[name], described(unit, words))
    names = np.array([point_names[index] for index in trace.contact_points], dtype=np.str_)
    return variables | {"contact_place": ("contact", names, dict(CONTACT_PLACE))}


def run_coordinates(study: Scene, case: Case, time: Array) -> dict[str, Any]:
    """Time, interfaces, contact points, buildings and storeys of one run."""
    buildings, forces = study.buildings, np.array([case.yield_forces])
    names = [
        f"{buildings[link.interface].name} {link.left_floor:.3g} | {buildings[link.interface + 1].name} "
        f"{link.right_floor:.3g}"
        for link in sorted(study.links)
    ]
    return {
        **labels.building_coordinates(buildings),
        **labels.place_coordinates(buildings, study.points, forces),
        **({"link": ("link", names, {"long_name": "link, by the floors at its ends"})} if names else {}),
        "contact_point_yield_force": ("contact_point", forces[0], described("N", "yield force F_E")),
        "interface_gap": ("interface", list(case.gaps), described("m", "clear distance at rest")),
        **labels.bumper_coordinate(study),
        "building": ("building", [building.name for building in buildings], {"long_name": "building, left to right"}),
        "time": ("time", time, described("s", "time since the start of the record")),
    }
