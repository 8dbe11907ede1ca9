"""Histories of one run of a row, from the log of its solver: floors, contact points and every contact.

The run is, to the bit, the one that a scan makes of the case, recorded at the nodes of the record and at every step in
contact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.row_grid import mechanics_of, model_of
from pounding_risk.results.run_labels import Case, Trace
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import Laid, RowRun
from pounding_risk.solver.row.cases import Cases, Driven, Limits, Mechanics
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import Frame, frame_of, outputs, variables
from pounding_risk.solver.row.trace_reader import FACTS, contacts_of, forces_at, impulses_at, instants_of, motion_at

Array = NDArray[np.float64]


def row_trace(study: Scene, case: Case) -> Trace:
    """The run of a case of a row in full; raises as `row_grid`."""
    model = model_of(study)
    frame, row, forces = frame_of(model), model.row(case.motion.dt), np.array(case.yield_forces)
    mechanics = mechanics_of(study, model, case.contact_model, np.unique(forces[np.isfinite(forces)]))
    run = _run(model, mechanics, case, study.rtol)
    ground = rows.nodes_of(row, case.motion.acceleration)
    instants = instants_of(run.log, ground.size, row.step)
    touches = contacts_of(run.log, len(model.points), instants)
    # A motion beyond all numbers is told by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        states = motion_at(run.log, run.states, instants)
    values = outputs(run, forces, case.motion.pga, frame)
    known = instants.every[np.isfinite(states).all(axis=(1, 2))]
    return Trace(
        instants.every,
        {
            "displacement": _by_storey(frame, states[:, 0]),
            "velocity": _by_storey(frame, states[:, 1]),
            "relative_displacement": _closing(row, states[:, 0]),
            "contact_force": forces_at(touches, len(model.points), instants.every),
            "contact_impulse_so_far": impulses_at(run.log, len(model.points), instants),
            "ground_acceleration": np.interp(instants.every, instants.nodes, ground),
        },
        {name: np.array([touch.facts[column] for touch in touches]) for column, name in enumerate(FACTS)},
        [touch.place for touch in touches],
        {name: (output, values[name]) for name, output in variables(frame).items()},
        run.status,
        mechanics.laws[0],
        float(known.max(initial=0.0)),
    )


def _run(model: RowModel, mechanics: Mechanics, case: Case, rtol: float) -> RowRun:
    motion, forces = case.motion, np.array(case.yield_forces)
    free = rows.free_row(model.row(motion.dt), motion.acceleration)
    cases = Cases(model, mechanics, Driven(motion.acceleration, motion.dt, motion.pga, free), rtol)
    return cases.in_full(Limits(np.array(case.gaps)[model.interfaces], forces, forces))


def _by_storey(frame: Frame, values: Array) -> Array:
    """Values of the masses (instants, masses) as (instants, buildings, storeys); NaN where there is none."""
    return np.where(frame.storeys >= 0, _with_ground(values)[:, frame.storeys], np.nan)


def _closing(row: Laid, values: Array) -> Array:
    """u_left − u_right at each contact point (instants, points), from displacements of the masses."""
    return (_with_ground(values)[:, row.row.ends] * row.row.shares).sum(axis=-1)


def _with_ground(values: Array) -> Array:
    """Values of the masses and, as the last one, of the ground: mass −1 of a contact point or storey."""
    return np.column_stack([values, np.zeros(len(values))])
