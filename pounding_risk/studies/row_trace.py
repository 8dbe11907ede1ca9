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
    own_grounds = case.motion.own_grounds
    ground = model.under(case.motion.drive, own_grounds)
    frame, row = frame_of(model), model.row(case.motion.dt, model.has_many(own_grounds))
    contacts = frame.contacts
    forces, peaks = model.at_points(np.array(case.yield_forces)), peaks_under(study, case.motion)
    mechanics = mechanics_of(study, model, case.contact_model, np.unique(forces[np.isfinite(forces)]))
    free = rows.free_response(row, ground)
    cases = Cases(model, mechanics, Driven(ground, case.motion.dt, peaks, free.run), study.rtol, lambda: free.motion)
    run = cases.in_full(Limits(model.gaps(np.array(case.gaps)), forces, forces))
    instants = instants_of(run.log, len(run.states), row.step)
    grounds = grounds_at(row, ground, instants.every)
    touches = contacts_of(run.log, len(model.points), instants)
    # A motion beyond all numbers is reported by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        states = motion_at(run.log, run.states, instants)
    results = with_bumpers(outputs(run, forces, peaks, frame), frame)
    displacement = _by_storey(frame, states[:, 0])
    is_known = np.isfinite(states).all(axis=(1, 2))
    after_end = np.where(is_known, 0.0, np.nan)[:, None]  # of what is zero where nothing touches
    return Trace(
        instants.every,
        {
            "displacement": displacement,
            **in_space(study, case.motion, instants.every, displacement),
            "velocity": _by_storey(frame, states[:, 1]),
            "relative_displacement": closing_at(row, states[:, 0], grounds)[:, contacts],
            "contact_force": forces_at(touches, len(model.points), instants.every)[:, contacts] + after_end,
            "contact_impulse_so_far": impulses_at(run.log, len(model.points), instants)[:, contacts] + after_end,
            **plan_histories(frame, states),
            **storey_histories(frame, instants.every, states),
            **link_histories(model, instants.every, states),
            **grounds,
        },
        {name: np.array([touch.facts[column] for touch in touches]) for column, name in enumerate(FACTS)},
        [int(np.searchsorted(contacts, touch.point)) for touch in touches],
        {name: (output, results[name]) for name, output in RowJob.outputs(study).items()},
        run.status,
        mechanics.laws[0],
        float(instants.every[is_known].max(initial=0.0)),
    )


def _by_storey(frame: Frame, of_masses: Array) -> Array:
    """Values of the masses (instants, masses) as (instants, buildings, storeys); NaN where there is none."""
    # Of no storey is mass −1; a row of rigid buildings has no mass at all.
    return np.where(
        frame.storeys >= 0, np.column_stack([of_masses, np.zeros(len(of_masses))])[:, frame.storeys], np.nan
    )


def plan_histories(frame: Frame, states: Array) -> dict[str, Array]:
    """Rotations of floors, and displacements across the row (instants, buildings, storeys), where floors have them."""
    chains, histories = frame.model.chains, {}
    for name, motions, has_motion in (
        ("floor_rotation", 1, [chain.twists for chain in chains]),
        ("displacement_across", 2, [chain.moves_across for chain in chains]),
    ):
        if any(has_motion):
            offsets = motions * np.array([[chain.floors] for chain in chains])
            places = np.where((frame.storeys >= 0) & np.array(has_motion)[:, None], frame.storeys + offsets, -1)
            histories[name] = _by_storey(frame._replace(storeys=places), states[:, 0])
    return histories


def storey_histories(frame: Frame, time: Array, states: Array) -> dict[str, Array]:
    """Drifts and spring shears of all storeys (instants, buildings, storeys), of a row of which one yields.

    A law is followed from instant to instant and over the turns between them.
    """
    if not frame.yields:
        return {}
    model = frame.model
    shears, drift_table = (np.full((len(states), model.firsts[-1]), np.nan) for _ in range(2))
    for first, chain in zip(model.firsts, model.chains, strict=False):
        hardening = np.broadcast_to(chain.hardening, chain.mass.size)
        drifts, rates = (states[:, line, first : first + chain.mass.size] @ chain.drifts().T for line in (0, 1))
        drift_table[:, first : first + chain.mass.size] = drifts
        for storey, (stiffness, strength) in enumerate(zip(chain.shear, chain.strength, strict=True)):
            law = chain.laws[storey] if chain.laws.size else np.zeros(0)
            if not law.any() and np.isfinite(strength):
                law = Hysteresis("kinematic", hardening=float(hardening[storey])).numbers(stiffness, strength, inf)
            is_known = np.isfinite(drifts[:, storey])
            forces = stiffness * drifts[is_known, storey]
            if law.any():
                forces = followed(law, time[is_known], drifts[is_known, storey], rates[is_known, storey])
            shears[is_known, first + storey] = forces if stiffness else np.nan
    return {"drift": _by_storey(frame, drift_table), "storey_force": _by_storey(frame, shears)}


def followed(law: Array, time: Array, displacements: Array, rate: Array) -> Array:
    """Forces [N] of a law at displacements [m] and rates [m/s] of these times [s], the turns between them passed too.

    Where the rate changes its sign between two times, the displacement turns where the cubic through both does.
    """
    length, rise = np.diff(time), np.diff(displacements)
    start, end = length * rate[:-1], length * rate[1:]
    turns = np.flatnonzero(start * end < 0.0)
    a, b, c = start[turns], (3.0 * rise - 2.0 * start - end)[turns], (start + end - 2.0 * rise)[turns]
    # 3 c x² + 2 b x + a has one root between 0 and 1, at which it goes from the sign of a to the other.
    root = np.sqrt(np.maximum(b * b - 3.0 * a * c, 0.0)) * np.sign(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(b * root > 0.0, (-b - root) / (3.0 * c), a / (root - b))
    share = np.clip(np.where(np.isfinite(share), share, 0.0), 0.0, 1.0)
    turn_points = displacements[turns] + share * (a + share * (b + share * c))
    path = np.insert(displacements, turns + 1, turn_points)
    places = np.arange(displacements.size) + np.searchsorted(turns, np.arange(displacements.size))
    return forces_along(law, path)[places]


def link_histories(model: RowModel, time: Array, states: Array) -> dict[str, Array]:
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
            forces[:, place] = -followed(np.array(link.law), time, -stretched[:, place], -rate[:, place])
    return {"link_stretch": stretched, "link_force": forces + dashpots * rate}


def grounds_at(row: RowLayout, under: Samples, time: Array) -> dict[str, Array]:
    """Histories of the ground; those under each building on unlike grounds. ``under`` is a_g under them [m/s²]."""
    nodes = nodes_of(row, under)
    if row.arrivals is None:
        ground = np.interp(time, row.step * np.arange(nodes.size), nodes)
        across = {"ground_acceleration_across": ground.imag} if np.iscomplexobj(ground) else {}
        return {"ground_acceleration": ground.real, **across}
    table = arriving(nodes, row.step, row.arrivals)
    times = (row.step * np.arange(nodes.shape[-1])[:, None] + row.arrivals.offsets).ravel()[: len(table)]
    node = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(table) - 1)
    elapsed = (time - times[node])[:, None]
    pull, rise, bend, twist, spread, rate = np.moveaxis(table[node], -1, 0)
    under = pull + rise * elapsed
    widening = spread + elapsed * (rate + elapsed * (0.5 * bend + elapsed * twist / 6.0))
    return {
        "ground_acceleration": under[:, 0],
        "building_ground_acceleration": under,
        "ground_widening": widening[:, 1:],
    }


def closing_at(row: RowLayout, displacements: Array, grounds: dict[str, Array]) -> Array:
    """What closes the gap at each contact point (instants, points), from displacements of the masses."""
    dofs = np.zeros((len(displacements), row.row.floors.shape[1] + 1))  # of each dof; dof −1 is the ground
    dofs[:, row.masses] = displacements[:, : row.masses.size]
    if row.arrivals is not None:
        dofs[:, row.row.frame[FIRST, 2:] - 1] = grounds["ground_widening"]
    return (dofs[:, row.row.ends] * row.row.shares).sum(axis=-1)
