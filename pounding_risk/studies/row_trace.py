"""Histories of one run of a row, from the log of its solver: floors, contact points and every contact.

The run is, to the bit, the one that a scan makes of the case, recorded at the nodes of the record and at every step in
contact.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.grid_job import peaks_under
from pounding_risk.ensemble.row_grid import mechanics_of, model_of
from pounding_risk.ensemble.row_job import RowJob
from pounding_risk.models.ground import arriving
from pounding_risk.models.structures.hysteresis import Hysteresis, forces_along
from pounding_risk.models.structures.links import stretch
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.results.run_labels import Case, Trace
from pounding_risk.scene.ground_motion import in_space
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.cases import Cases, Driven, Limits
from pounding_risk.solver.row.layout import RowLayout, nodes_of
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import Frame, frame_of, outputs, with_bumpers
from pounding_risk.solver.row.trace_reader import FACTS, contacts_of, forces_at, impulses_at, instants_of, motion_at
from pounding_risk.solver.row.workspace import FIRST

Array = NDArray[np.float64]


def row_trace(study: Scene, case: Case) -> Trace:
    """The run of a case of a row in full; raises as `row_grid`."""
    model = model_of(study)
    own = case.motion.own_grounds
    under = model.under(case.motion.acceleration, own)
    frame, row = frame_of(model), model.row(case.motion.dt, model.has_many(own))
    contacts = frame.contacts
    forces, peaks = model.at_points(np.array(case.yield_forces)), peaks_under(study, case.motion)
    mechanics = mechanics_of(study, model, case.contact_model, np.unique(forces[np.isfinite(forces)]))
    free = rows.free_response(row, under)
    cases = Cases(model, mechanics, Driven(under, case.motion.dt, peaks, free.run), study.rtol, lambda: free.motion)
    run = cases.in_full(Limits(model.gaps(np.array(case.gaps)), forces, forces))
    instants = instants_of(run.log, len(run.states), row.step)
    grounds = grounds_at(row, under, instants.every)
    touches = contacts_of(run.log, len(model.points), instants)
    # A motion beyond all numbers is reported by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        states = motion_at(run.log, run.states, instants)
    values = with_bumpers(outputs(run, forces, peaks, frame), frame)
    displacement = _by_storey(frame, states[:, 0])
    known = instants.every[np.isfinite(states).all(axis=(1, 2))]
    return Trace(
        instants.every,
        {
            "displacement": displacement,
            **in_space(study, case.motion, instants.every, displacement),
            "velocity": _by_storey(frame, states[:, 1]),
            "relative_displacement": closing_at(row, states[:, 0], grounds)[:, contacts],
            "contact_force": forces_at(touches, len(model.points), instants.every)[:, contacts],
            "contact_impulse_so_far": impulses_at(run.log, len(model.points), instants)[:, contacts],
            **storey_histories(frame, states),
            **link_histories(model, states),
            **grounds,
        },
        {name: np.array([touch.facts[column] for touch in touches]) for column, name in enumerate(FACTS)},
        [int(np.searchsorted(contacts, touch.point)) for touch in touches],
        {name: (output, values[name]) for name, output in RowJob.outputs(study).items()},
        run.status,
        mechanics.laws[0],
        float(known.max(initial=0.0)),
    )


def _by_storey(frame: Frame, values: Array) -> Array:
    """Values of the masses (instants, masses) as (instants, buildings, storeys); NaN where there is none."""
    # Of no storey is mass −1; a row of rigid buildings has no mass at all.
    return np.where(frame.storeys >= 0, np.column_stack([values, np.zeros(len(values))])[:, frame.storeys], np.nan)


def storey_histories(frame: Frame, states: Array) -> dict[str, Array]:
    """Drifts and spring shears of all storeys (instants, buildings, storeys), of a row of which one yields.

    A law is followed from instant to instant: a turn between two of them is missed, and what it changes.
    """
    if not frame.yields:
        return {}
    model = frame.model
    shears, moved = (np.full((len(states), model.firsts[-1]), np.nan) for _ in range(2))
    for first, chain in zip(model.firsts, model.chains, strict=False):
        hardening = np.broadcast_to(chain.hardening, chain.mass.size)
        drifts = states[:, 0, first : first + chain.mass.size] @ chain.drifts().T
        moved[:, first : first + chain.mass.size] = drifts
        for storey, (stiffness, strength) in enumerate(zip(chain.shear, chain.strength, strict=True)):
            law = chain.laws[storey] if chain.laws.size else np.zeros(0)
            if not law.any() and np.isfinite(strength):
                law = Hysteresis("kinematic", hardening=float(hardening[storey])).numbers(stiffness, strength, inf)
            known = np.isfinite(drifts[:, storey])
            along = forces_along(law, drifts[known, storey]) if law.any() else stiffness * drifts[known, storey]
            shears[known, first + storey] = along if stiffness else np.nan
    return {"drift": _by_storey(frame, moved), "storey_force": _by_storey(frame, shears)}


def link_histories(model: RowModel, states: Array) -> dict[str, Array]:
    """What links are stretched by, and their forces (instants, links); nothing of a row without links."""
    if not model.links:
        return {}
    shares = np.array([stretch(link, model.chains) for link in model.links]).T
    springs = np.array([link.stiffness for link in model.links])
    dashpots = np.array([0.0 if link.exponent else link.damping for link in model.links])
    masses = model.firsts[-1]
    stretched, rate = states[:, 0, :masses] @ shares, states[:, 1, :masses] @ shares
    forces, brace = springs * stretched, masses
    for place, link in enumerate(model.links):
        if link.is_braced:
            forces[:, place] -= link.brace * states[:, 0, brace]
            brace += 1
        elif link.exponent and link.damping:
            forces[:, place] += forces_along(np.array(link.law), rate[:, place])
        elif link.law:  # followed from instant to instant; its displacement is that of the left end from the right one
            forces[:, place] = -forces_along(np.array(link.law), -stretched[:, place])
    return {"link_stretch": stretched, "link_force": forces + dashpots * rate}


def grounds_at(row: RowLayout, under: Samples, time: Array) -> dict[str, Array]:
    """Histories of the ground; those under each building on unlike grounds. ``under`` is a_g under them [m/s²]."""
    nodes = nodes_of(row, under)
    if row.arrivals is None:
        return {"ground_acceleration": np.interp(time, row.step * np.arange(nodes.size), nodes)}
    table = arriving(nodes, row.step, row.arrivals)
    times = (row.step * np.arange(nodes.shape[-1])[:, None] + row.arrivals.offsets).ravel()[: len(table)]
    node = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(table) - 1)
    after = (time - times[node])[:, None]
    pull, rise, bend, twist, spread, rate = np.moveaxis(table[node], -1, 0)
    under = pull + rise * after
    widening = spread + after * (rate + after * (0.5 * bend + after * twist / 6.0))
    return {
        "ground_acceleration": under[:, 0],
        "building_ground_acceleration": under,
        "ground_widening": widening[:, 1:],
    }


def closing_at(row: RowLayout, values: Array, grounds: dict[str, Array]) -> Array:
    """What closes the gap at each contact point (instants, points), from displacements of the masses."""
    moved = np.zeros((len(values), row.row.floors.shape[1] + 1))  # of each dof; dof −1 is the ground
    moved[:, row.masses] = values[:, : row.masses.size]
    if row.arrivals is not None:
        moved[:, row.row.frame[FIRST, 2:] - 1] = grounds["ground_widening"]
    return (moved[:, row.row.ends] * row.row.shares).sum(axis=-1)
