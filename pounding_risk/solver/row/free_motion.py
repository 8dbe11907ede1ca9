"""The motion of a row without any contact, block by block of nodes: what all runs of the row have in common.

The states of a block are found first, node by node and exactly; then accelerations, bounds and peaks of a floor at all
nodes of the block, which the processor does several at a time. An interval is searched for a crest only where a bound
leaves room for one above the peak at the nodes of its block and of those before.

Buildings whose storeys may yield, and their neighbours, are brought from node to node.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from pounding_risk._jit.compile import borrowed, kernel
from pounding_risk._jit.memory import zeros
from pounding_risk.solver.counters import NOT_FINITE
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
    CAN_YIELD,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    NEXT,
    NODE,
    START,
    VELOCITY,
)


@kernel
def pass_yielding_interval(row, run, free, work, slow, busy, swings, step, terms, node, n):
    """The ``slow`` buildings over one node interval, rows NODE to rows NODE, and the distances of those that may yield.

    Their states go to ``work.paths``, the bounds of those that are linear to ``work.swings``.
    """
    window, buildings, dofs = window_at(free.ground, step, node), row.frame.shape[1] - 1, run.dofs
    for b in range(buildings):
        busy[b] = False
        if slow[b]:
            place_ground(row, b, window[2], dofs, NODE)
            busy[b] = not predict_by_map(row, run, b, window, swings)
            work.swings[0, b, n], work.swings[1, b, n] = swings[b], sqrt(swings[b])
            if not busy[b]:
                update_peaks(row, run, b, window, swings, terms)
    b = 0
    while b < buildings:
        last = b
        if busy[b]:
            while last < buildings - 1 and busy[last + 1]:
                last += 1
            watch = max(b - 1, 0), min(last + 1, buildings - 1)
            fly(row, run, (b, last), watch, window, terms)
        b = last + 1
    for i in range(buildings - 1):
        bends = row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]
        if bends and not (busy[i] or busy[i + 1]):
            update_distances(row, run, i, window, swings, terms)
    for b in range(buildings):
        if slow[b]:
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
def march_free(row, run, free, work, step, terms, states):
    """The row without any contact, from the first of ``free.states`` to the end of the record, into ``free``.

    Finds the fastest closing at every point. u and v at the nodes go to ``states`` (nodes, 2, D) where it has rows.
    """
    states = borrowed(states)
    begin_motion(row, run, free, step)
    buildings, nodes = row.frame.shape[1] - 1, free.ground.node_count() - 1
    write_peaks(row, run, free, 0)
    busy, slow = zeros((buildings,), np.bool_), zeros((buildings,), np.bool_)
    swings, bends = zeros((buildings,), np.float64), False
    for b in range(buildings):
        bends = bends or row.frame[CAN_YIELD, b] > 0
        for other in range(max(b - 1, 0), min(b + 2, buildings)):
            slow[b] = slow[b] or row.frame[CAN_YIELD, other] > 0
    for begin in range(0, nodes, free.block):
        count = min(free.block, nodes - begin)
        reset_bounds(row, run)
        for n in range(count):
            work.ground[WIDTH, n] = free.ground.node_width(step, begin + n)
            if bends:
                pass_yielding_interval(row, run, free, work, slow, busy, swings, step, terms, begin + n, n)
        for b in range(buildings):
            if not slow[b]:
                follow_building(row, run, free, work, step, b, begin, count)
                raise_building(row, run, free, work, step, terms, b, begin, count)
        for i in range(buildings - 1):
            if not (row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]):
                raise_distances(row, run, free, work, step, terms, i, begin, count)
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
    if not total < inf:
        run.workspace.status = float(NOT_FINITE)
