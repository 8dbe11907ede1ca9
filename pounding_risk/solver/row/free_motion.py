"""The motion of a row without any contact, block by block of nodes: what all runs of the row have in common.

The states of a block are found first, node by node and exactly; then accelerations, bounds and peaks of a floor at all
nodes of the block, which the processor does several at a time. An interval is searched for a local maximum only where a
bound leaves room for one above the peak at the nodes of its block and of those before.

Buildings whose storeys may yield, and their neighbours, are brought from node to node.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, uncounted
from pounding_risk.solver.counters import COLLAPSED, COMPLETE, NOT_FINITE
from pounding_risk.solver.row.contact_points import across
from pounding_risk.solver.row.flight_by_map import predict_by_map, update_distances, update_peaks
from pounding_risk.solver.row.flight_by_series import fly
from pounding_risk.solver.row.free_buildings import WIDTH, follow_building, raise_building
from pounding_risk.solver.row.free_distances import raise_distances
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.ground_dof import place_ground
from pounding_risk.solver.row.initial_state import begin_motion
from pounding_risk.solver.row.workspace import (
    ACCELERATION,
    BOUNDS,
    BY_NODE,
    CAN_YIELD,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    GROUPED,
    MOTION_BOUND,
    NEXT,
    NODE,
    START,
    VELOCITY,
)


@kernel
def pass_yielding_interval(row, run, free, work, node, n):
    """The buildings marked BY_NODE over one node interval, rows NODE to rows NODE.

    These are the buildings whose storeys may yield, and their neighbours. Raises their peaks and those of the distances
    to them. ``n`` is the number of the interval in its block: states go to ``work.paths``, bounds of the motion to
    ``work.swings``. Marks in GROUPED those that a storey's change of branch makes fly on their series.
    """
    buildings, dofs, marks = row.frame.shape[1] - 1, run.dofs, run.marks
    window = window_at(free.ground, free.step, node)
    for b in range(buildings):
        marks[GROUPED, b] = 0.0
        if marks[BY_NODE, b] > 0.0:
            place_ground(row, b, window[2], dofs, NODE)
            is_alone = predict_by_map(row, run, b, window)
            work.swings[0, b, n], work.swings[1, b, n] = marks[MOTION_BOUND, b], sqrt(marks[MOTION_BOUND, b])
            if is_alone:
                update_peaks(row, run, b, window, free.terms)
            else:
                marks[GROUPED, b] = 1.0
    b = 0
    while b < buildings:
        last = b
        if marks[GROUPED, b] > 0.0:
            while last < buildings - 1 and marks[GROUPED, last + 1] > 0.0:
                last += 1
            watch = max(b - 1, 0), min(last + 1, buildings - 1)
            fly(row, run, (b, last), watch, window, free.terms)
            if int(run.workspace.status) == COLLAPSED:
                return  # the time of the collapse is not that of a change of branch of the next ones
        b = last + 1
    for i in range(buildings - 1):
        can_yield = row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]
        if can_yield and marks[GROUPED, i] + marks[GROUPED, i + 1] == 0.0:
            update_distances(row, run, i, window, free.terms)
    for b in range(buildings):
        if marks[BY_NODE, b] > 0.0:
            for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
                for line in range(2):
                    work.paths[line, i, n] = dofs[NODE + line, i]
                    dofs[NODE + line, i] = work.paths[line, i, n + 1] = dofs[NEXT + line, i]
    for i in range(buildings - 1):
        if row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]:
            for k in range(row.frame[START, i], row.frame[START, i + 1]):
                run.contacts[k].fastest = max(run.contacts[k].fastest, abs(across(row, k, dofs, NODE + VELOCITY)))


@kernel
def reset_bounds(row, run):
    """Rows BOUNDS, and the bounds of the distances, as at the start of a block."""
    for i in range(row.floors.shape[1]):
        for line in range(3):
            run.dofs[BOUNDS + line, i] = 0.0
    for k in range(run.laws.shape[0]):
        run.contacts[k].upper_bound, run.contacts[k].lower_bound = -inf, inf


@kernel
def write_peaks(row, run, free, block):
    """Write down the peaks up to the start of a block."""
    for i in range(row.floors.shape[1]):
        for line in range(3):
            peak = DISPLACEMENT if line == 0 else (DRIFT if line == 1 else ACCELERATION)
            free.floor_peaks[block, line, i] = run.dofs[peak, i]
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        free.point_peaks[block, 0, k], free.point_peaks[block, 1, k] = contact.highest, contact.lowest


@kernel
def close_block(row, run, free, block):
    """Write down the state at the end of a block, the bounds in it, and the peaks up to its end.

    After a state that is not finite nothing is bounded.
    """
    write_peaks(row, run, free, block + 1)
    total = 0.0
    for i in range(row.floors.shape[1]):
        for line in range(2):
            free.states[block + 1, line, i] = run.dofs[NODE + line, i]
            total += abs(run.dofs[NODE + line, i])
    is_finite = total < inf
    for i in range(row.floors.shape[1]):
        for line in range(3):
            peak = DISPLACEMENT if line == 0 else (DRIFT if line == 1 else ACCELERATION)
            free.floor_bounds[block, line, i] = min(run.dofs[BOUNDS + line, i], run.dofs[peak, i]) if is_finite else inf
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        free.point_bounds[block, 0, k] = min(contact.upper_bound, contact.highest) if is_finite else inf
        free.point_bounds[block, 1, k] = max(contact.lower_bound, contact.lowest) if is_finite else -inf


@kernel
def march_free(row, run, free, work, states):
    """The row without any contact, from the first of ``free.states`` to the end of the record, into ``free``.

    Leaves the peaks in ``run``, and the fastest closing or parting at every point. u and v at the nodes go to
    ``states`` (nodes, 2, D) where it has rows.
    """
    states = uncounted(states)
    begin_motion(row, run, free)
    buildings, nodes = row.frame.shape[1] - 1, free.ground.node_count() - 1
    write_peaks(row, run, free, 0)
    any_yields = False
    for b in range(buildings):
        any_yields = any_yields or row.frame[CAN_YIELD, b] > 0
        for neighbour in range(max(b - 1, 0), min(b + 2, buildings)):
            if row.frame[CAN_YIELD, neighbour] > 0:
                run.marks[BY_NODE, b] = 1.0
    for begin in range(0, nodes, free.block):
        count = min(free.block, nodes - begin)
        reset_bounds(row, run)
        for n in range(count):
            work.ground[WIDTH, n] = free.ground.node_width(free.step, begin + n)
            if any_yields:
                pass_yielding_interval(row, run, free, work, begin + n, n)
                if int(run.workspace.status) == COLLAPSED:
                    return
        for b in range(buildings):
            if run.marks[BY_NODE, b] == 0.0:
                follow_building(row, run, free, work, b, begin, count)
                raise_building(row, run, free, work, b, begin, count)
        for i in range(buildings - 1):
            if not (row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]):
                raise_distances(row, run, free, work, i, begin, count)
        close_block(row, run, free, begin // free.block)
        if states.shape[0] > 0:
            for n in range(count + 1):
                for line in range(2):
                    for i in range(row.floors.shape[1]):
                        states[begin + n, line, i] = work.paths[line, i, n]
    total = 0.0
    for i in range(row.floors.shape[1]):
        total += (
            abs(run.dofs[NODE, i]) + abs(run.dofs[NODE + VELOCITY, i]) + run.dofs[DRIFT, i] + run.dofs[ACCELERATION, i]
        )
    if int(run.workspace.status) == COMPLETE and not total < inf:
        run.workspace.status = float(NOT_FINITE)
