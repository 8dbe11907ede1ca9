"""The state in which a run of a row begins."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel
from pounding_risk.models.structures.hysteresis._numbers import BEGIN
from pounding_risk.solver.counters import FIRST_TOUCH, FIRST_YIELD
from pounding_risk.solver.row.building import accelerate
from pounding_risk.solver.row.contact_points import across
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.link import add_link_forces, begin_links
from pounding_risk.solver.row.storey import advance_storey, drift_in, has_law, set_branch
from pounding_risk.solver.row.workspace import ACCEL_START, ACCELERATION, DISPLACEMENT, DRIFT, FIRST, MARKS, NODE


@kernel
def begin_run(row, run):
    """Set the row to rest, its gaps open and its storeys elastic."""
    for mark in range(MARKS):
        for b in range(row.frame.shape[1] - 1):
            run.marks[mark, b] = 0.0
    for line in range(run.dofs.shape[0]):
        for i in range(run.dofs.shape[1]):
            run.dofs[line, i] = 0.0
    for i in range(row.floors.shape[1]):
        set_branch(row, run.dofs, i, 0.0)
        if has_law(run, i):
            advance_storey(row, run, i, BEGIN, 0.0)
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        contact.counters[FIRST_TOUCH] = nan
        contact.counters[FIRST_YIELD] = nan
        contact.gap = contact.given_gap
    run.workspace.watched_point = -1.0


@kernel
def begin_motion(row, run, free):
    """Set the row to the state at the first node of ``free``, which gives the first values of the peaks."""
    begin_run(row, run)
    dofs, size = run.dofs, 0.0
    for i in range(row.floors.shape[1]):
        for line in range(2):
            dofs[NODE + line, i] = free.states[0, line, free.first_dof + i]
            size += abs(dofs[NODE + line, i])
    begin_links(row, run, NODE)
    if size == 0.0:
        return
    for b in range(row.frame.shape[1] - 1):
        pull, _ = free.ground.from_node(free.step, 0).under(b)
        if row.frame[FIRST, b] < top_of(row, b):
            accelerate(row, b, NODE, pull, dofs, ACCEL_START)
            add_link_forces(row, run, b, b, NODE, ACCEL_START)
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            dofs[DISPLACEMENT, i], dofs[DRIFT, i] = abs(dofs[NODE, i]), abs(drift_in(row, dofs, NODE, i))
            dofs[ACCELERATION, i] = abs(dofs[ACCEL_START, i] + pull.real)
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        contact.highest, contact.lowest = max(across(row, k, dofs, NODE), 0.0), min(across(row, k, dofs, NODE), 0.0)
