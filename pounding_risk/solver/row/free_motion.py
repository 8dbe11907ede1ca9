"""The motion of a row without any contact, block by block of nodes: what all runs of the row have in common.

The states of a block are found first, node by node and exactly; then accelerations, bounds and peaks of a floor at all
nodes of the block, which the processor does several at a time. An interval is searched for a crest only where a bound
leaves room for one above the peak at the nodes of its block and of those before.

Buildings whose storeys may yield, and their neighbours, are brought from node to node.
"""

from __future__ import annotations

from math import inf, nan, sqrt

import numpy as np

from pounding_risk._jit.compile import borrowed, kernel
from pounding_risk._jit.memory import zeros
from pounding_risk.solver.counters import FIRST_TOUCH, FIRST_YIELD, NOT_FINITE
from pounding_risk.solver.row.building import accelerate, place_ground, raise_between, step_over, top_of, write_series
from pounding_risk.solver.row.flight import across, bend_across, raise_reach, wider
from pounding_risk.solver.row.free import fly, predict_by_map, update_distances, update_peaks
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.storey import soften
from pounding_risk.solver.row.workspace import (
    ACCEL_END,
    ACCEL_NUDGED,
    ACCEL_SPARE,
    ACCEL_START,
    ACCELERATION,
    BAND,
    BENDS,
    BOUNDS,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    INVERSE,
    JERK_START,
    MASS,
    NEXT,
    NODE,
    QUICK,
    ROOT,
    START,
    STATIC,
    TANGENT,
    VELOCITY,
)

# Rows of `FreeWork.paths`: u, v and ü of every dof; of `ground`: a_g under a building, its slope, the time to the next
# node; of `distances`: u_left − u_right of a contact point and its derivatives.
TURN = 2
PULL, RISE, WIDTH = range(3)
RATE = 1


@kernel
def begin_run(row, run):
    """Set the row to rest, its gaps open and its storeys elastic."""
    for line in range(run.dofs.shape[0]):
        for i in range(run.dofs.shape[1]):
            run.dofs[line, i] = 0.0
    for i in range(row.floors.shape[1]):
        soften(row, run.dofs, i, 0.0)
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        contact.counters[FIRST_TOUCH] = nan
        contact.counters[FIRST_YIELD] = nan
        contact.gap = contact.given_gap
    run.workspace.watched_point = -1.0


@kernel
def begin_motion(row, run, free, step):
    """Set the row to the state at the first node of ``free``, which gives the first values of the peaks."""
    begin_run(row, run)
    dofs, moved = run.dofs, 0.0
    for i in range(row.floors.shape[1]):
        for line in range(2):
            dofs[NODE + line, i] = free.states[0, line, free.first_dof + i]
            moved += abs(dofs[NODE + line, i])
    if moved == 0.0:
        return
    for b in range(row.frame.shape[1] - 1):
        pull, _ = free.ground.from_node(step, 0).under(b)
        if row.frame[FIRST, b] < top_of(row, b):
            accelerate(row, b, NODE, pull, dofs, ACCEL_START)
        below = 0.0
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            dofs[DISPLACEMENT, i], dofs[DRIFT, i] = abs(dofs[NODE, i]), abs(dofs[NODE, i] - below)
            dofs[ACCELERATION, i], below = abs(dofs[ACCEL_START, i] + pull), dofs[NODE, i]
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        contact.highest, contact.lowest = max(across(row, k, dofs, NODE), 0.0), min(across(row, k, dofs, NODE), 0.0)


@kernel
def follow_building(row, run, free, work, step, b, begin, count):
    """A linear building from rows NODE over ``count`` node intervals: its states, and the ground under it."""
    dofs = run.dofs
    for n in range(count):
        _, width, ground = window_at(free.ground, step, begin + n)
        pull, rise = ground.under(b)
        work.ground[PULL, n], work.ground[RISE, n] = pull, rise
        work.ground[PULL, n + 1] = pull + rise * width
        place_ground(row, b, ground, dofs, NODE)
        step_over(row, b, ground, dofs, NODE, NEXT)
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                work.paths[line, i, n] = dofs[NODE + line, i]
                dofs[NODE + line, i] = work.paths[line, i, n + 1] = dofs[NEXT + line, i]


@kernel
def accelerate_all(row, run, work, b, count):
    """ü of a linear building at the nodes of a block; the same operations as `building.accelerate`."""
    first, last, band, nodes = row.frame[FIRST, b], top_of(row, b), row.frame[BAND, b], count + 1
    paths, spring = work.paths, run.dofs[TANGENT, first]
    for n in range(nodes):
        paths[TURN, first, n] = -(spring * paths[0, first, n])
    for i in range(first + 1, last):
        spring = run.dofs[TANGENT, i]
        for n in range(nodes):
            force = spring * (paths[0, i, n] - paths[0, i - 1, n])
            paths[TURN, i, n] = -force
            paths[TURN, i - 1, n] += force
    for i in range(first, last):
        mass, inverse = row.floors[MASS, i], row.floors[INVERSE, i]
        for n in range(nodes):
            paths[TURN, i, n] -= mass * work.ground[PULL, n]
        for j in range(max(first, i - band), min(last, i + band + 1)):
            damping = row.damping[j, i - first]
            for n in range(nodes):
                paths[TURN, i, n] -= damping * paths[VELOCITY, j, n]
        for n in range(nodes):
            paths[TURN, i, n] *= inverse


@kernel
def bound_all(row, run, work, b, count):
    """2 E of `building.motion_bound` over each interval of a block, and its root, to ``work.swings``."""
    first, last, paths, swings = row.frame[FIRST, b], top_of(row, b), work.paths, work.swings
    mass, spring, static = row.floors[MASS, first], run.dofs[TANGENT, first], row.floors[STATIC, first]
    for n in range(count):
        speed = paths[VELOCITY, first, n] + static * work.ground[RISE, n]
        swings[0, b, n] = mass * paths[TURN, first, n] ** 2 + spring * speed * speed
    for i in range(first + 1, last):
        mass, spring = row.floors[MASS, i], run.dofs[TANGENT, i]
        static_drift = row.floors[STATIC, i] - row.floors[STATIC, i - 1]
        for n in range(count):
            rate = paths[VELOCITY, i, n] - paths[VELOCITY, i - 1, n] + static_drift * work.ground[RISE, n]
            swings[0, b, n] += mass * paths[TURN, i, n] ** 2 + spring * rate * rate
    for n in range(count):
        swings[1, b, n] = sqrt(swings[0, b, n])


@kernel
def raise_floor(row, run, work, b, i, count):
    """Raise the peaks of a floor by those at the nodes of a block; returns whether a crest between two may be higher.

    Rows BOUNDS become upper bounds in the block.
    """
    first, paths, dofs = row.frame[FIRST, b], work.paths, run.dofs
    peak, peak_drift, peak_felt = dofs[DISPLACEMENT, i], dofs[DRIFT, i], dofs[ACCELERATION, i]
    root, quick = row.floors[ROOT, i], row.floors[QUICK, first]
    root_below = row.floors[ROOT, i - 1] if i > first else 0.0
    top = top_drift = top_felt = turn_below = turn_below_after = 0.0
    here, turn, felt = abs(paths[0, i, 0]), abs(paths[TURN, i, 0]), abs(paths[TURN, i, 0] + work.ground[PULL, 0])
    drift = abs(paths[0, i, 0] - paths[0, i - 1, 0]) if i > first else here
    for n in range(count):
        after, turn_after = abs(paths[0, i, n + 1]), abs(paths[TURN, i, n + 1])
        drift_after = after
        if i > first:
            drift_after = abs(paths[0, i, n + 1] - paths[0, i - 1, n + 1])
            turn_below, turn_below_after = abs(paths[TURN, i - 1, n]), abs(paths[TURN, i - 1, n + 1])
        felt_after = abs(paths[TURN, i, n + 1] + work.ground[PULL, n + 1])
        peak, peak_drift, peak_felt = max(peak, after), max(peak_drift, drift_after), max(peak_felt, felt_after)
        eighth, swing = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n], work.swings[1, b, n]
        stir = eighth * quick * swing
        bend = min(max(turn, turn_after) + stir * root, swing * root)
        bend_below = min(max(turn_below, turn_below_after) + stir * root_below, swing * root_below)
        top = max(top, max(here, after) + eighth * bend)
        top_drift = max(top_drift, max(drift, drift_after) + eighth * (bend + bend_below))
        top_felt = max(top_felt, max(felt, felt_after) + stir * root)
        here, drift, felt, turn = after, drift_after, felt_after, turn_after
    dofs[DISPLACEMENT, i], dofs[DRIFT, i], dofs[ACCELERATION, i] = peak, peak_drift, peak_felt
    dofs[BOUNDS, i], dofs[BOUNDS + 1, i], dofs[BOUNDS + 2, i] = top, top_drift, top_felt
    return top > peak or top_drift > peak_drift or top_felt > peak_felt


@kernel
def may_crest(row, run, work, b, n):
    """True where a floor of a building may pass a peak between two nodes of a block; `raise_floor` for one interval.

    Otherwise rows BOUNDS are raised by the bounds in the interval.
    """
    first, last, paths, dofs = row.frame[FIRST, b], top_of(row, b), work.paths, run.dofs
    eighth, swing = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n], work.swings[1, b, n]
    stir = eighth * row.floors[QUICK, first] * swing
    below = below_after = bend_below = 0.0
    for i in range(first, last):
        here, after, root = paths[0, i, n], paths[0, i, n + 1], row.floors[ROOT, i]
        turn, turn_after = paths[TURN, i, n], paths[TURN, i, n + 1]
        felt, felt_after = turn + work.ground[PULL, n], turn_after + work.ground[PULL, n + 1]
        bend = min(max(abs(turn), abs(turn_after)) + stir * root, swing * root)
        most = max(abs(here), abs(after)) + eighth * bend
        most_drift = max(abs(here - below), abs(after - below_after)) + eighth * (bend + bend_below)
        most_felt = max(abs(felt), abs(felt_after)) + stir * root
        if most > dofs[DISPLACEMENT, i] or most_drift > dofs[DRIFT, i] or most_felt > dofs[ACCELERATION, i]:
            return True
        dofs[ACCEL_NUDGED, i], dofs[ACCEL_SPARE, i], dofs[JERK_START, i] = most, most_drift, most_felt
        below, below_after, bend_below = here, after, bend
    for i in range(first, last):
        dofs[BOUNDS, i] = max(dofs[BOUNDS, i], dofs[ACCEL_NUDGED, i])
        dofs[BOUNDS + 1, i] = max(dofs[BOUNDS + 1, i], dofs[ACCEL_SPARE, i])
        dofs[BOUNDS + 2, i] = max(dofs[BOUNDS + 2, i], dofs[JERK_START, i])
    return False


@kernel
def place_at(row, run, work, b, n, line):
    """The state of a building at a node of the block to rows ``line``."""
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        run.dofs[line, i], run.dofs[line + VELOCITY, i] = work.paths[0, i, n], work.paths[VELOCITY, i, n]


@kernel
def raise_building(row, run, free, work, step, terms, b, begin, count):
    """The peaks of a linear building over a block, and upper bounds in it."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    if last == first:
        return
    accelerate_all(row, run, work, b, count)
    bound_all(row, run, work, b, count)
    some = False
    for i in range(first, last):
        some = raise_floor(row, run, work, b, i, count) or some
    if not some:
        return
    # Interval by interval, with finer bounds where a crest may be higher.
    for i in range(first, last):
        for line in range(3):
            run.dofs[BOUNDS + line, i] = 0.0
    for n in range(count):
        if not may_crest(row, run, work, b, n):
            continue
        place_at(row, run, work, b, n, NODE)
        place_at(row, run, work, b, n + 1, NEXT)
        for i in range(first, last):
            run.dofs[ACCEL_START, i], run.dofs[ACCEL_END, i] = work.paths[TURN, i, n], work.paths[TURN, i, n + 1]
        ends = NODE, NEXT, ACCEL_START, ACCEL_END
        _, width, ground = window_at(free.ground, step, begin + n)
        raise_between(row, run, b, ends, work.swings[0, b, n], ground, width, terms)
    place_at(row, run, work, b, count, NODE)


@kernel
def place_across(row, work, k, place, count):
    """u_left − u_right of a contact point, less the w of the ground, and both its derivatives at the nodes of a block.

    The second derivative is that of the floors, without ẅ.
    """
    for line in range(3):
        for n in range(count + 1):
            work.distances[line, place, n] = 0.0
        for end in range(4 if line == TURN else row.passage.point_ends()):
            i = row.ends[k, end]
            if i >= 0:
                share = row.shares[k, end]
                for n in range(count + 1):
                    work.distances[line, place, n] += share * work.paths[line, i, n]


@kernel
def stir_across(row, k):
    """|fourth derivative of u_left − u_right| over sqrt(2 E), as `flight.bend_across`, that of w left out."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += abs(row.shares[k, end]) * row.floors[ROOT, i] * row.floors[QUICK, i]
    return total


@kernel
def write_bends(row, free, work, step, interface, k, place, begin, count):
    """Upper bounds of |second derivative of u_left − u_right| over each interval of a block, to ``work.bends``."""
    bend, stir = bend_across(row, k), stir_across(row, k)
    for n in range(count):
        swing = max(work.swings[1, interface, n], work.swings[1, interface + 1, n])
        eighth = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n]
        at_nodes = max(abs(work.distances[TURN, place, n]), abs(work.distances[TURN, place, n + 1]))
        work.bends[place, n] = min(at_nodes + eighth * stir * swing, bend * swing)
    for n in range(count):
        ground = free.ground.from_node(step, begin + n)
        work.bends[place, n] += ground.ground_curves(interface + 1, work.ground[WIDTH, n])


@kernel
def raise_distance(run, work, k, place, count):
    """Raise the extremes of a distance by those at the nodes of a block; returns whether others may lie between two.

    Its bounds become those in the block, and its largest rate is raised.
    """
    contact = run.contacts[k]
    high, low, fastest = contact.highest, contact.lowest, contact.fastest
    top, bottom, here = -inf, inf, work.distances[0, place, 0]
    for n in range(count):
        there = work.distances[0, place, n + 1]
        high, low, fastest = max(high, there), min(low, there), max(fastest, abs(work.distances[RATE, place, n + 1]))
        sag = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n] * work.bends[place, n]
        top, bottom = max(top, max(here, there) + sag), min(bottom, min(here, there) - sag)
        here = there
    contact.highest, contact.lowest, contact.fastest = high, low, fastest
    contact.upper_bound, contact.lower_bound = top, bottom
    return top > high or bottom < low


@kernel
def raise_distances(row, run, free, work, step, terms, interface, begin, count):
    """Extremes, bounds and largest rates of the distances between two linear buildings over a block."""
    start, stop, some = row.frame[START, interface], row.frame[START, interface + 1], False
    for k in range(start, stop):
        place_across(row, work, k, k - start, count)
        write_bends(row, free, work, step, interface, k, k - start, begin, count)
        some = raise_distance(run, work, k, k - start, count) or some
    if not some:
        return
    for k in range(start, stop):
        run.contacts[k].upper_bound, run.contacts[k].lower_bound = -inf, inf
    for n in range(count):
        _, width, ground = window_at(free.ground, step, begin + n)
        laid = False
        for k in range(start, stop):
            here, there = work.distances[0, k - start, n], work.distances[0, k - start, n + 1]
            if not wider(run, k, here, there, width, work.bends[k - start, n]):
                continue
            for b in range(interface, interface + 2):
                if not laid:
                    place_at(row, run, work, b, n, NODE)
                    write_series(row, run, b, NODE, ground, terms)
            laid = True
            raise_reach(row, run, k, width, terms)
    for b in range(interface, interface + 2):
        place_at(row, run, work, b, count, NODE)


@kernel
def bend_freely(row, run, free, work, slow, busy, swings, step, terms, node, n):
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
        bends = row.frame[BENDS, i] or row.frame[BENDS, i + 1]
        if bends and not (busy[i] or busy[i + 1]):
            update_distances(row, run, i, window, swings, terms)
    for b in range(buildings):
        if slow[b]:
            for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
                for line in range(2):
                    work.paths[line, i, n] = dofs[NODE + line, i]
                    dofs[NODE + line, i] = work.paths[line, i, n + 1] = dofs[NEXT + line, i]
    for i in range(buildings - 1):
        if row.frame[BENDS, i] or row.frame[BENDS, i + 1]:
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
    known = total < inf
    for i in range(row.floors.shape[1]):
        for line in range(3):
            peak = DISPLACEMENT if line == 0 else (DRIFT if line == 1 else ACCELERATION)
            free.floor_bounds[block, line, i] = min(run.dofs[BOUNDS + line, i], run.dofs[peak, i]) if known else inf
    for k in range(run.laws.shape[0]):
        contact = run.contacts[k]
        free.point_bounds[block, 0, k] = min(contact.upper_bound, contact.highest) if known else inf
        free.point_bounds[block, 1, k] = max(contact.lower_bound, contact.lowest) if known else -inf


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
        bends = bends or row.frame[BENDS, b] > 0
        for other in range(max(b - 1, 0), min(b + 2, buildings)):
            slow[b] = slow[b] or row.frame[BENDS, other] > 0
    for begin in range(0, nodes, free.block):
        count = min(free.block, nodes - begin)
        reset_bounds(row, run)
        for n in range(count):
            work.ground[WIDTH, n] = free.ground.node_width(step, begin + n)
            if bends:
                bend_freely(row, run, free, work, slow, busy, swings, step, terms, begin + n, n)
        for b in range(buildings):
            if not slow[b]:
                follow_building(row, run, free, work, step, b, begin, count)
                raise_building(row, run, free, work, step, terms, b, begin, count)
        for i in range(buildings - 1):
            if not (row.frame[BENDS, i] or row.frame[BENDS, i + 1]):
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
