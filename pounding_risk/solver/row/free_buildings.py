"""The motion without contact of a linear building over a block of nodes: states, peaks, bounds."""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.flight_peaks import raise_interval_peaks
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.ground_dof import place_ground, top_of
from pounding_risk.solver.row.inertia import divide_by_mass, has_inertia, mass_product
from pounding_risk.solver.row.node_map import map_motion
from pounding_risk.solver.row.storey import is_lowest
from pounding_risk.solver.row.workspace import (
    ACCEL_END,
    ACCEL_NUDGED,
    ACCEL_SPARE,
    ACCEL_START,
    ACCELERATION,
    ACROSS,
    BAND,
    BOTTOM,
    BOUNDS,
    COUPLED,
    DISPLACEMENT,
    DRIFT,
    DRIVEN,
    FIRST,
    INVERSE,
    JERK_START,
    MASS,
    NEXT,
    NODE,
    QUICK,
    ROOT,
    STATIC,
    TANGENT,
    VELOCITY,
)

# Rows of `FreeWork.paths`: u, v and ü of every dof; of `ground`: a_g under a building, its slope, the time to the next
# node, and a_g and slope of a second component; of `distances`: u_left − u_right of a contact point, its derivatives.
PATH_ACCELERATION = 2
PULL, RISE, WIDTH, PULL_ACROSS, RISE_ACROSS = range(5)


@kernel
def follow_building(row, run, free, work, b, begin, count):
    """A linear building from rows NODE over ``count`` node intervals: its states, and the ground under it."""
    dofs = run.dofs
    for n in range(count):
        _, width, ground = window_at(free.ground, free.step, begin + n)
        pull, rise = ground.under(b)
        work.ground[PULL, n], work.ground[RISE, n] = pull.real, rise.real
        work.ground[PULL, n + 1] = pull.real + rise.real * width
        if row.passage.components() > 1:
            work.ground[PULL_ACROSS, n], work.ground[RISE_ACROSS, n] = pull.imag, rise.imag
            work.ground[PULL_ACROSS, n + 1] = pull.imag + rise.imag * width
        place_ground(row, b, ground, dofs, NODE)
        map_motion(row, b, ground, dofs, NODE, NEXT)
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                work.paths[line, i, n] = dofs[NODE + line, i]
                dofs[NODE + line, i] = work.paths[line, i, n + 1] = dofs[NEXT + line, i]


@kernel
def accelerate_all(row, run, work, b, count):
    """ü of a linear building at the nodes of a block; the same operations as `building.accelerate`."""
    first, last, band, nodes = row.frame[FIRST, b], top_of(row, b), row.frame[BAND, b], count + 1
    paths, spring, is_coupled = work.paths, run.dofs[TANGENT, first], row.frame[COUPLED, b] > 0
    for n in range(nodes):
        paths[PATH_ACCELERATION, first, n] = -(spring * paths[0, first, n])
    for i in range(first + 1, last):
        spring = run.dofs[TANGENT, i]
        if is_coupled and row.floors[BOTTOM, i] > 0.0:
            for n in range(nodes):
                paths[PATH_ACCELERATION, i, n] = -(spring * paths[0, i, n])
            continue
        for n in range(nodes):
            force = spring * (paths[0, i, n] - paths[0, i - 1, n])
            paths[PATH_ACCELERATION, i, n] = -force
            paths[PATH_ACCELERATION, i - 1, n] += force
    for i in range(first, last if row.frame[COUPLED, b] > 0 else first):
        for j in range(first, last):
            spring = row.coupling[i, j - first]
            for n in range(nodes):
                paths[PATH_ACCELERATION, i, n] -= spring * paths[0, j, n]
    for i in range(first, last):
        mass, inverse = row.floors[DRIVEN, i], row.floors[INVERSE, i]
        for n in range(nodes):
            paths[PATH_ACCELERATION, i, n] -= mass * work.ground[PULL, n]
        if row.passage.components() > 1:
            mass = row.floors[DRIVEN + ACROSS, i]
            for n in range(nodes):
                paths[PATH_ACCELERATION, i, n] -= mass * work.ground[PULL_ACROSS, n]
        for j in range(max(first, i - band), min(last, i + band + 1)):
            damping = row.damping[j, i - first]
            for n in range(nodes):
                paths[PATH_ACCELERATION, i, n] -= damping * paths[VELOCITY, j, n]
        for n in range(nodes):
            paths[PATH_ACCELERATION, i, n] *= inverse
    if has_inertia(row, b):
        for n in range(nodes):
            divide_by_mass(row, b, paths[PATH_ACCELERATION, :, n])


@kernel
def bound_all(row, run, work, b, count):
    """2 E of `flight_peaks.motion_bound` over each interval of a block, and its root, to ``work.swings``."""
    first, last, paths, swings = row.frame[FIRST, b], top_of(row, b), work.paths, work.swings
    mass, spring, static = row.floors[MASS, first], run.dofs[TANGENT, first], row.floors[STATIC, first]
    is_coupled = row.frame[COUPLED, b] > 0
    for n in range(count):
        speed = paths[VELOCITY, first, n] + static * work.ground[RISE, n]
        swings[0, b, n] = mass * paths[PATH_ACCELERATION, first, n] ** 2 + spring * speed * speed
    for i in range(first + 1, last):
        mass, spring = row.floors[MASS, i], run.dofs[TANGENT, i]
        if is_coupled and row.floors[BOTTOM, i] > 0.0:
            for n in range(count):
                rate = paths[VELOCITY, i, n] + row.floors[STATIC, i] * work.ground[RISE, n]
                swings[0, b, n] += mass * paths[PATH_ACCELERATION, i, n] ** 2 + spring * rate * rate
            continue
        static_drift = row.floors[STATIC, i] - row.floors[STATIC, i - 1]
        for n in range(count):
            rate = paths[VELOCITY, i, n] - paths[VELOCITY, i - 1, n] + static_drift * work.ground[RISE, n]
            swings[0, b, n] += mass * paths[PATH_ACCELERATION, i, n] ** 2 + spring * rate * rate
    for i in range(first, last if row.frame[COUPLED, b] > 0 else first):
        for j in range(first, last):
            spring, one, other = row.coupling[i, j - first], row.floors[STATIC, i], row.floors[STATIC, j]
            for n in range(count):
                rise = work.ground[RISE, n]
                rate, other_rate = paths[VELOCITY, i, n] + one * rise, paths[VELOCITY, j, n] + other * rise
                if row.passage.components() > 1:
                    rise = work.ground[RISE_ACROSS, n]
                    rate += row.floors[STATIC + ACROSS, i] * rise
                    other_rate += row.floors[STATIC + ACROSS, j] * rise
                swings[0, b, n] += spring * (rate * other_rate)
    for n in range(count):
        if has_inertia(row, b):
            swings[0, b, n] += mass_product(row, b, paths[PATH_ACCELERATION, :, n])
        swings[1, b, n] = sqrt(swings[0, b, n])


@kernel
def raise_floor(row, run, work, b, i, count):
    """Raise the peaks of a floor by those at the nodes of a block; returns whether one between two may be higher.

    Rows BOUNDS become upper bounds in the block.
    """
    first, paths, dofs = row.frame[FIRST, b], work.paths, run.dofs
    has_below = not is_lowest(row, first, i, row.frame[COUPLED, b] > 0)
    peak, peak_drift, peak_felt = dofs[DISPLACEMENT, i], dofs[DRIFT, i], dofs[ACCELERATION, i]
    root, quick = row.floors[ROOT, i], row.floors[QUICK, first]
    root_below = row.floors[ROOT, i - 1] if has_below else 0.0
    top = top_drift = top_felt = turn_below = turn_below_end = 0.0
    start, turn, felt_start = (
        abs(paths[0, i, 0]),
        abs(paths[PATH_ACCELERATION, i, 0]),
        abs(paths[PATH_ACCELERATION, i, 0] + work.ground[PULL, 0]),
    )
    drift = abs(paths[0, i, 0] - paths[0, i - 1, 0]) if has_below else start
    for n in range(count):
        end, turn_end = abs(paths[0, i, n + 1]), abs(paths[PATH_ACCELERATION, i, n + 1])
        drift_end = end
        if has_below:
            drift_end = abs(paths[0, i, n + 1] - paths[0, i - 1, n + 1])
            turn_below, turn_below_end = (
                abs(paths[PATH_ACCELERATION, i - 1, n]),
                abs(paths[PATH_ACCELERATION, i - 1, n + 1]),
            )
        felt_end = abs(paths[PATH_ACCELERATION, i, n + 1] + work.ground[PULL, n + 1])
        peak, peak_drift, peak_felt = max(peak, end), max(peak_drift, drift_end), max(peak_felt, felt_end)
        eighth, swing = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n], work.swings[1, b, n]
        stir = eighth * quick * swing
        bend = min(max(turn, turn_end) + stir * root, swing * root)
        bend_below = min(max(turn_below, turn_below_end) + stir * root_below, swing * root_below)
        top = max(top, max(start, end) + eighth * bend)
        top_drift = max(top_drift, max(drift, drift_end) + eighth * (bend + bend_below))
        top_felt = max(top_felt, max(felt_start, felt_end) + stir * root)
        start, drift, felt_start, turn = end, drift_end, felt_end, turn_end
    dofs[DISPLACEMENT, i], dofs[DRIFT, i], dofs[ACCELERATION, i] = peak, peak_drift, peak_felt
    dofs[BOUNDS, i], dofs[BOUNDS + 1, i], dofs[BOUNDS + 2, i] = top, top_drift, top_felt
    return top > peak or top_drift > peak_drift or top_felt > peak_felt


@kernel
def may_have_maximum(row, run, work, b, n):
    """True where a floor of a building may pass a peak between two nodes of a block; `raise_floor` for one interval.

    Otherwise rows BOUNDS are raised by the bounds in the interval.
    """
    first, last, paths, dofs = row.frame[FIRST, b], top_of(row, b), work.paths, run.dofs
    eighth, swing = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n], work.swings[1, b, n]
    stir, is_coupled = eighth * row.floors[QUICK, first] * swing, row.frame[COUPLED, b] > 0
    start_below = end_below = bend_below = 0.0
    for i in range(first, last):
        if is_coupled and row.floors[BOTTOM, i] > 0.0:
            start_below = end_below = bend_below = 0.0
        start, end, root = paths[0, i, n], paths[0, i, n + 1], row.floors[ROOT, i]
        turn, turn_end = paths[PATH_ACCELERATION, i, n], paths[PATH_ACCELERATION, i, n + 1]
        felt_start, felt_end = turn + work.ground[PULL, n], turn_end + work.ground[PULL, n + 1]
        bend = min(max(abs(turn), abs(turn_end)) + stir * root, swing * root)
        top = max(abs(start), abs(end)) + eighth * bend
        top_drift = max(abs(start - start_below), abs(end - end_below)) + eighth * (bend + bend_below)
        top_felt = max(abs(felt_start), abs(felt_end)) + stir * root
        if top > dofs[DISPLACEMENT, i] or top_drift > dofs[DRIFT, i] or top_felt > dofs[ACCELERATION, i]:
            return True
        dofs[ACCEL_NUDGED, i], dofs[ACCEL_SPARE, i], dofs[JERK_START, i] = top, top_drift, top_felt
        start_below, end_below, bend_below = start, end, bend
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
def raise_building(row, run, free, work, b, begin, count):
    """The peaks of a linear building over a block, and upper bounds in it."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    if last == first:
        return
    accelerate_all(row, run, work, b, count)
    bound_all(row, run, work, b, count)
    may_pass = False
    for i in range(first, last):
        may_pass = raise_floor(row, run, work, b, i, count) or may_pass
    if not may_pass:
        return
    # Interval by interval, with finer bounds where a local maximum may be higher.
    for i in range(first, last):
        for line in range(3):
            run.dofs[BOUNDS + line, i] = 0.0
    for n in range(count):
        if not may_have_maximum(row, run, work, b, n):
            continue
        place_at(row, run, work, b, n, NODE)
        place_at(row, run, work, b, n + 1, NEXT)
        for i in range(first, last):
            run.dofs[ACCEL_START, i], run.dofs[ACCEL_END, i] = (
                work.paths[PATH_ACCELERATION, i, n],
                work.paths[PATH_ACCELERATION, i, n + 1],
            )
        ends = NODE, NEXT, ACCEL_START, ACCEL_END
        window = window_at(free.ground, free.step, begin + n)
        raise_interval_peaks(row, run, b, ends, work.swings[0, b, n], window, free.terms)
    place_at(row, run, work, b, count, NODE)
