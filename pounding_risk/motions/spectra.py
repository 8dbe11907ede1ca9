"""Linear oscillators under sampled ground motions: the peaks behind response spectra, for all periods of all records.

ü + 2 ζ ω u̇ + ω² u = −a_g with a_g linear between the samples is solved exactly from node to node (Nigam and Jennings
1969). Nodes lie closer than the samples where T is short: at least 32 a period. The coefficients are power series of
one step, which do not cancel as the closed forms do.

Eight periods go side by side, so that the processor's vectors are used. That loop keeps the largest values at the nodes
of each block of samples; a quantity q exceeds them between nodes by h² / 8 max|q̈| at most, so that only the few blocks
within that of the largest value are gone through again for their local maxima, with 128 nodes a period. Between those,
q is the cubic through its values and slopes at both, off by (ω h)⁴ / 384 = 1.5e-8 of the peak, and more where the
ground turns sharply under much damping: 4e-6 at worst in 400 noises, square waves and sines with ζ up to 0.99. The
largest value at 32 nodes a period would be low by up to 0.5 %.

Along all directions of two components, the local maxima are those of the cubics between 32 nodes a period: off by 4e-6
where a motion is free, 1e-4 at worst under white noise with ζ = 0.7.
"""

from __future__ import annotations

from math import ceil, copysign, pi, sqrt

import numpy as np

from pounding_risk._jit.compile import kernel, small

LANES = 8  # periods side by side
BLOCK = 32  # samples, or nodes of a path, whose largest values are kept together
NODES_A_PERIOD = 32
FINER = 4  # steps for one where local maxima are looked for
CUBIC_RISE = 4.0 / 27.0  # a cubic on [0, h] is at most its larger end + 4/27 h (|slope| + |slope|)
TERMS = 20  # of the series in ω h ≤ 0.2: the next is below 1e-17 of the first for ζ ≤ 1

# Rows of the workspace, of one number for each period: state, coefficients; and of u, u̇ and ü + a_g the largest value
# and by how much that between two nodes may be larger.
U, V, UU, UV, UA, UB, VU, VV, VA, VB, TWO_ZETA_OMEGA, OMEGA2, PEAK = range(13)
EXCESS = PEAK + 3
ROWS = 18
MARKS = 5  # rows kept for each block: u and u̇ at its beginning, and the largest three at its nodes
BETWEEN = 1.1  # a second derivative between nodes over the largest at nodes: with ω h ≤ 0.2 less than this


@kernel
def series(kind, omega2, two_zeta_omega, h):
    """u and u̇ after a step h, from 1 in one of: u (0), u̇ (1), a_g (2) and the rise of a_g over the step (3)."""
    now = 1.0 if kind == 0 else 0.0
    after = h if kind == 1 else 0.0
    u, rate = now + after, after
    for n in range(TERMS):
        load = 1.0 if (kind == 2 and n == 0) or (kind == 3 and n == 1) else 0.0
        new = -(h * h * (load + omega2 * now) + two_zeta_omega * h * (n + 1) * after) / ((n + 1) * (n + 2))
        u += new
        rate += (n + 2) * new
        now, after = after, new
    return u, rate / h


@kernel
def prepare(lane, period, damping, h, workspace):
    """Coefficients of one step of one oscillator at rest."""
    omega = 2.0 * pi / period
    two_zeta_omega, omega2 = 2.0 * damping * omega, omega * omega
    workspace[U * LANES + lane] = workspace[V * LANES + lane] = 0.0
    workspace[TWO_ZETA_OMEGA * LANES + lane], workspace[OMEGA2 * LANES + lane] = two_zeta_omega, omega2
    for kind in range(4):
        u, v = series(kind, omega2, two_zeta_omega, h)
        workspace[(UU + kind) * LANES + lane], workspace[(VU + kind) * LANES + lane] = u, v


@small
def larger(a, b):
    """The larger of two numbers, neither NaN: one instruction."""
    return a if a > b else b


@small
def advance(lane, u, v, here, rise, workspace):
    """u and u̇ at the next node; a_g is ``here`` at this one and rises by ``rise``."""
    next_u = (
        workspace[UU * LANES + lane] * u
        + workspace[UV * LANES + lane] * v
        + (workspace[UA * LANES + lane] * here + workspace[UB * LANES + lane] * rise)
    )
    next_v = (
        workspace[VU * LANES + lane] * u
        + workspace[VV * LANES + lane] * v
        + (workspace[VA * LANES + lane] * here + workspace[VB * LANES + lane] * rise)
    )
    return next_u, next_v


@small
def watched(lane, u, v, ground, workspace):
    """ü + a_g, ü, and the slope of ü + a_g."""
    total = -(workspace[TWO_ZETA_OMEGA * LANES + lane] * v + workspace[OMEGA2 * LANES + lane] * u)
    bend = total - ground
    return total, bend, -(workspace[TWO_ZETA_OMEGA * LANES + lane] * bend + workspace[OMEGA2 * LANES + lane] * v)


@kernel
def nodes(ground, parts, workspace, marks):
    """Eight oscillators through a record, each sample interval in ``parts`` steps."""
    for i in range(ground.size - 1):
        if i % BLOCK == 0:
            for lane in range(LANES):
                u, v = workspace[U * LANES + lane], workspace[V * LANES + lane]
                marks[i // BLOCK, U * LANES + lane], marks[i // BLOCK, V * LANES + lane] = u, v
                keep_start(lane, u, v, workspace)
        rise = (ground[i + 1] - ground[i]) / parts
        for part in range(parts):
            here = ground[i] + part * rise
            for lane in range(LANES):
                u, v = advance(lane, workspace[U * LANES + lane], workspace[V * LANES + lane], here, rise, workspace)
                workspace[U * LANES + lane], workspace[V * LANES + lane] = u, v
                total = workspace[TWO_ZETA_OMEGA * LANES + lane] * v + workspace[OMEGA2 * LANES + lane] * u
                workspace[PEAK * LANES + lane] = larger(abs(u), workspace[PEAK * LANES + lane])
                workspace[(PEAK + 1) * LANES + lane] = larger(abs(v), workspace[(PEAK + 1) * LANES + lane])
                workspace[(PEAK + 2) * LANES + lane] = larger(abs(total), workspace[(PEAK + 2) * LANES + lane])
        for slot in range(3 * LANES):
            marks[i // BLOCK, 2 * LANES + slot] = workspace[PEAK * LANES + slot]


@small
def keep_start(lane, u, v, workspace):
    """The first node of a block: its values are the largest so far."""
    workspace[PEAK * LANES + lane], workspace[(PEAK + 1) * LANES + lane] = abs(u), abs(v)
    workspace[(PEAK + 2) * LANES + lane] = abs(
        workspace[TWO_ZETA_OMEGA * LANES + lane] * v + workspace[OMEGA2 * LANES + lane] * u
    )


@small
def largest_mark(marks, column):
    """The largest of a column; NaN where one is."""
    best = marks[0, column]
    for block in range(1, marks.shape[0]):
        if marks[block, column] > best or marks[block, column] != marks[block, column]:
            best = marks[block, column]
        if best != best:
            break
    return best


@kernel
def sum_up(lane, shaking, h, workspace, marks):
    """The largest values at nodes, and how much larger those between may be; ``shaking`` is max|a_g| and max|ȧ_g|."""
    for which in range(3):
        workspace[(PEAK + which) * LANES + lane] = largest_mark(marks, (2 + which) * LANES + lane)
    two_zeta_omega, omega2 = workspace[TWO_ZETA_OMEGA * LANES + lane], workspace[OMEGA2 * LANES + lane]
    # The second derivatives of u, u̇ and ü + a_g, from the equation of motion and its derivatives.
    second = BETWEEN * (workspace[(PEAK + 2) * LANES + lane] + shaking[0])
    third = two_zeta_omega * second + BETWEEN * omega2 * workspace[(PEAK + 1) * LANES + lane] + shaking[1]
    workspace[EXCESS * LANES + lane] = h * h / 8.0 * second
    workspace[(EXCESS + 1) * LANES + lane] = h * h / 8.0 * third
    workspace[(EXCESS + 2) * LANES + lane] = h * h / 8.0 * (two_zeta_omega * third + omega2 * second)


@kernel
def local_maximum(best, ends, slopes, h):
    """The larger of ``best`` and the local maxima inside of |the cubic with these values and slopes at both ends|."""
    if larger(abs(ends[0]), abs(ends[1])) + CUBIC_RISE * h * (abs(slopes[0]) + abs(slopes[1])) <= best:
        return best
    # ends[0] + start x + bend x² + twist x³
    start, stop, rise = h * slopes[0], h * slopes[1], ends[1] - ends[0]
    bend, twist = 3.0 * rise - 2.0 * start - stop, start + stop - 2.0 * rise
    square = bend * bend - 3.0 * twist * start
    if square <= 0.0:
        return best
    root = -(bend + copysign(sqrt(square), bend))  # the form that does not cancel
    for x in (start / root, root / (3.0 * twist) if twist != 0.0 else 0.0):
        if 0.0 < x < 1.0:
            best = larger(abs(ends[0] + x * (start + x * (bend + x * twist))), best)
    return best


@kernel
def local_maxima(ground, parts, h, lane, block, desks, marks):
    """Go through one block again for one oscillator, in finer steps, and keep what is larger between its nodes."""
    workspace, finer = desks
    u, v = marks[block, U * LANES + lane], marks[block, V * LANES + lane]
    for i in range(block * BLOCK, min((block + 1) * BLOCK, ground.size - 1)):
        rise = (ground[i + 1] - ground[i]) / parts
        for part in range(parts):
            here = ground[i] + part * rise
            total, bend, turn = watched(lane, u, v, here, finer)
            next_u, next_v = advance(lane, u, v, here, rise, finer)
            next_total, next_bend, next_turn = watched(lane, next_u, next_v, here + rise, finer)
            slot = PEAK * LANES + lane
            workspace[slot] = local_maximum(larger(abs(next_u), workspace[slot]), (u, next_u), (v, next_v), h)
            slot += LANES
            workspace[slot] = local_maximum(larger(abs(next_v), workspace[slot]), (v, next_v), (bend, next_bend), h)
            slot += LANES
            workspace[slot] = local_maximum(
                larger(abs(next_total), workspace[slot]), (total, next_total), (turn, next_turn), h
            )
            u, v = next_u, next_v


@small
def may_be_higher(lane, block, workspace, marks):
    """True where a block has a value at a node so large that one between its nodes may be the largest."""
    for which in range(3):
        here = marks[block, (2 + which) * LANES + lane] + workspace[(EXCESS + which) * LANES + lane]
        if here > workspace[(PEAK + which) * LANES + lane]:
            return True
    return False


@small
def peaks_of_eight(ground, dt, periods, damping, shaking, desks, marks):
    """Peaks of up to eight oscillators, the shortest period first, into the first workspace; as `sum_up`."""
    workspace, finer = desks
    parts = parts_of(dt, periods[0])
    h = dt / parts
    for lane in range(LANES):
        prepare(lane, periods[min(lane, periods.size - 1)], damping, h, workspace)
        prepare(lane, periods[min(lane, periods.size - 1)], damping, h / FINER, finer)
    nodes(ground, parts, workspace, marks)
    for lane in range(periods.size):
        sum_up(lane, shaking, h, workspace, marks)
        for block in range(marks.shape[0]):
            if may_be_higher(lane, block, workspace, marks):
                local_maxima(ground, parts * FINER, h / FINER, lane, block, desks, marks)


@small
def parts_of(dt, period):
    """Into how many steps a sample interval is divided."""
    return int(max(1.0, ceil(NODES_A_PERIOD * dt / period - 1e-9)))


@small
def blocks_of(steps):
    """How many blocks so many steps make."""
    return (steps + BLOCK - 1) // BLOCK


def spectra(grounds, starts, steps, periods, damping):
    """max|u| [m], max|u̇| [m/s], max|ü + a_g| [m/s²], shape (3, records, periods), from rest, within the records.

    ``grounds`` holds the records one after another [m/s²], record k from ``starts[k]`` to ``starts[k + 1]``, every
    ``steps[k]`` [s]. ``periods`` [s] are in rising order.
    """
    # Record by record, so that what is handed over has one layout in memory whatever its size.
    peaks = np.empty((steps.size, 3, periods.size))
    desks = np.empty(ROWS * LANES), np.empty(ROWS * LANES)
    for record in range(steps.size):
        ground = grounds[starts[record] : starts[record + 1]]
        marks = np.empty((blocks_of(ground.size - 1), MARKS * LANES))
        shaking = float(np.abs(ground).max()), float(np.abs(np.diff(ground)).max() / steps[record])
        peaks_of_record(ground, float(steps[record]), periods, damping, shaking, desks, marks, peaks[record])
    return np.ascontiguousarray(peaks.transpose(1, 0, 2))


@kernel
def peaks_of_record(ground, dt, periods, damping, shaking, desks, marks, peaks):
    """As `spectra`, of one record; ``shaking`` as `sum_up`, the desks and marks are room to work in."""
    for first in range(0, periods.size, LANES):
        few = periods[first : first + LANES]
        peaks_of_eight(ground, dt, few, damping, shaking, desks, marks)
        for lane in range(few.size):
            for which in range(3):
                peaks[which, first + lane] = desks[0][(PEAK + which) * LANES + lane]


@kernel
def follow(ground, parts, lane, workspace, path):
    """u and u̇ of one oscillator at every node."""
    u, v, node = 0.0, 0.0, 0
    path[0, 0], path[0, 1] = u, v
    for i in range(ground.size - 1):
        rise = (ground[i + 1] - ground[i]) / parts
        for part in range(parts):
            u, v = advance(lane, u, v, ground[i] + part * rise, rise, workspace)
            node += 1
            path[node, 0], path[node, 1] = u, v


@kernel
def project(paths, block, turns, quiet, largest):
    """The largest |u| at the nodes of a block along every direction, where it is above ``quiet`` along any."""
    cosines, sines = turns[0], turns[1]
    largest[:] = 0.0
    for node in range(block * BLOCK, min((block + 1) * BLOCK + 1, paths.shape[1])):
        x, y = paths[0, node, 0], paths[1, node, 0]
        if x * x + y * y <= quiet * quiet:
            continue
        for k in range(largest.size):
            largest[k] = larger(abs(cosines[k] * x + sines[k] * y), largest[k])


@kernel
def maximum_along(paths, block, c, s, h, best):
    """The larger of ``best`` and the local maxima of |u| between the nodes of a block along one direction."""
    for node in range(block * BLOCK, min((block + 1) * BLOCK, paths.shape[1] - 1)):
        ends = c * paths[0, node, 0] + s * paths[1, node, 0], c * paths[0, node + 1, 0] + s * paths[1, node + 1, 0]
        slopes = c * paths[0, node, 1] + s * paths[1, node, 1], c * paths[0, node + 1, 1] + s * paths[1, node + 1, 1]
        best = local_maximum(best, ends, slopes, h)
    return best


@kernel
def bend_of_both(paths, two_zeta_omega, omega2, shaking):
    """No ü between nodes is larger, along no direction; ``shaking`` is the largest a_g of any."""
    u = v = 0.0
    for node in range(paths.shape[1]):
        u = larger(paths[0, node, 0] * paths[0, node, 0] + paths[1, node, 0] * paths[1, node, 0], u)
        v = larger(paths[0, node, 1] * paths[0, node, 1] + paths[1, node, 1] * paths[1, node, 1], v)
    return BETWEEN * (two_zeta_omega * sqrt(v) + omega2 * sqrt(u) + shaking)


@kernel
def turn_around(paths, h, bend, turns, peaks):
    """max|u| along every direction into ``peaks``, from the paths of both components."""
    marks = np.empty((blocks_of(paths.shape[1] - 1), peaks.size))
    excess = h * h / 8.0 * bend
    peaks[:] = 0.0
    for block in range(marks.shape[0]):
        # Beside a shorter vector than this, no direction finds its peak.
        project(paths, block, turns, larger(peaks.min() - excess, 0.0), marks[block])
        for k in range(peaks.size):
            peaks[k] = larger(marks[block, k], peaks[k])
    for k in range(peaks.size):
        for block in range(marks.shape[0]):
            if marks[block, k] + excess > peaks[k]:
                peaks[k] = maximum_along(paths, block, turns[0, k], turns[1, k], h, peaks[k])


@kernel
def directions(first, second, dt, periods, damping, turns):
    """max|u| [m] of every period along every direction, shape (periods, directions).

    ``first`` and ``second`` are two perpendicular components of a_g [m/s²] at the same times; ``turns`` the cosines and
    sines of the angles from the first towards the second. The oscillators are linear: each answers once to each.
    """
    peaks = np.empty((periods.size, turns.shape[1]))
    workspace = np.empty(ROWS * LANES)
    shaking = np.sqrt((first * first + second * second).max())
    for k in range(periods.size):
        parts = parts_of(dt, periods[k])
        prepare(0, periods[k], damping, dt / parts, workspace)
        paths = np.empty((2, (first.size - 1) * parts + 1, 2))
        follow(first, parts, 0, workspace, paths[0])
        follow(second, parts, 0, workspace, paths[1])
        bend = bend_of_both(paths, workspace[TWO_ZETA_OMEGA * LANES], workspace[OMEGA2 * LANES], shaking)
        turn_around(paths, dt / parts, bend, turns, peaks[k])
    return peaks
