"""Peaks in a step in contact: forces, distances, displacements, drifts and accelerations of the continuous motion."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel
from pounding_risk.models.structures.hysteresis._numbers import BRACE, FASTEST, STIFFNESS, TAKEN
from pounding_risk.solver.counters import FIRST_YIELD, LOWEST_FORCE
from pounding_risk.solver.pair.equations import ELASTIC
from pounding_risk.solver.row.contact import note_yield
from pounding_risk.solver.row.contact_points import across, part_of_distance, unwatched_points
from pounding_risk.solver.row.equations import accelerate_group, ground_at, transmitted
from pounding_risk.solver.row.explicit import between
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.implicit import write_polynomial
from pounding_risk.solver.row.link import brace_of, damper_speed, follows_rate, force_in_contact, is_braced, is_link_of
from pounding_risk.solver.row.local_maxima import (
    PUSH,
    REACH,
    SIDE,
    SPEED,
    extreme_over_step,
    local_maximum,
    may_hide_maximum,
    peak_over_step,
    signal_between,
)
from pounding_risk.solver.row.storey import drift_in, shear_stiffness
from pounding_risk.solver.row.workspace import (
    ACCEL_END,
    ACCEL_NUDGED,
    ACCEL_START,
    ACCELERATION,
    AT_END,
    AT_START,
    CAN_YIELD,
    CONSTANT,
    DISPLACEMENT,
    DRIFT,
    END,
    FIRST,
    JERK_END,
    JERK_START,
    LAST,
    LEFT_HIGH,
    NOW,
    NUDGED,
    RIGHT_HIGH,
    SLOPE,
    SLOPES,
    START,
    STOREY_FORCE,
    VELOCITY,
)

# Places on [0, 1] and weights of Gauss and Legendre's five points.
GAUSS = (
    (0.046910077030668, 0.1184634425280945),
    (0.2307653449471585, 0.2393143352496833),
    (0.5, 0.2844444444444444),
    (0.7692346550528415, 0.2393143352496833),
    (0.953089922969332, 0.1184634425280945),
)


@kernel
def accelerations(row, run, group, s, h, at_end):
    """Write ü at one end of the step and its slope per unit of s to the rows ACCEL_ and JERK_ of that end."""
    dofs = run.dofs
    state, line = (END, SLOPE + LAST) if at_end else (NOW, SLOPE)
    out, rises = (ACCEL_END, JERK_END) if at_end else (ACCEL_START, JERK_START)
    clock = s + h if at_end else s
    nudge = 1e-7 * h
    accelerate_group(row, run, group, state, ground_at(group, clock), out)
    for i in range(group.low, group.high):
        dofs[NUDGED, i] = dofs[state, i] + nudge * dofs[line, i]
        dofs[NUDGED + VELOCITY, i] = dofs[state + VELOCITY, i] + nudge * dofs[line + SLOPES, i]
    accelerate_group(row, run, group, NUDGED, ground_at(group, clock + nudge), ACCEL_NUDGED)
    for b in range(group.first, group.last + 1):
        pull, nudged_pull = ground_at(group, clock).under(b)[0], ground_at(group, clock + nudge).under(b)[0]
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            dofs[rises, i] = ((dofs[ACCEL_NUDGED, i] + nudged_pull.real) - (dofs[out, i] + pull.real)) / nudge


@kernel
def update_floor_peaks(row, run, group, span):
    """Raise the peaks of every dof of the group by those over an accepted step, ``span`` = (s, h, base)."""
    dofs = run.dofs
    s, h = span[0], span[1]
    cube = s * s * s
    searches_acceleration = s == 0.0
    end = s + h
    clock, clock_end = 4.0 * cube, 4.0 * end * end * end
    ground, ground_end = ground_at(group, s), ground_at(group, end)
    line, last = SLOPE, SLOPE + LAST
    for b in range(group.first, group.last + 1):
        pull, pull_end = ground.under(b)[0], ground_end.under(b)[0]
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            ends = dofs[NOW, i], dofs[END, i], dofs[line, i], dofs[last, i]
            peak = dofs[DISPLACEMENT, i]
            dofs[DISPLACEMENT, i] = peak_over_step(row, run, group, (DISPLACEMENT, i), peak, ends, span)
            ends = (
                drift_in(row, dofs, NOW, i),
                drift_in(row, dofs, END, i),
                drift_in(row, dofs, line, i),
                drift_in(row, dofs, last, i),
            )
            dofs[DRIFT, i] = peak_over_step(row, run, group, (DRIFT, i), dofs[DRIFT, i], ends, span)
            if row.frame[CAN_YIELD, b]:
                k, c = shear_stiffness(row, dofs, i), dofs[CONSTANT, i]
                ends = k * ends[0] + c, k * ends[1] + c, k * ends[2], k * ends[3]
                peak = dofs[STOREY_FORCE, i]
                dofs[STOREY_FORCE, i] = peak_over_step(row, run, group, (STOREY_FORCE, i), peak, ends, span)
            if not searches_acceleration:
                felt_start = dofs[line + SLOPES, i] / clock + pull.real
                felt_end = dofs[last + SLOPES, i] / clock_end + pull_end.real
                dofs[ACCELERATION, i] = max(dofs[ACCELERATION, i], abs(felt_end))
                searches_acceleration = 2.0 * max(abs(felt_start), abs(felt_end)) > dofs[ACCELERATION, i]
    if searches_acceleration:
        accelerations(row, run, group, s, h, False)
        accelerations(row, run, group, s, h, True)
        for b in range(group.first, group.last + 1):
            pull, pull_end = ground.under(b)[0], ground_end.under(b)[0]
            for i in range(row.frame[FIRST, b], top_of(row, b)):
                felt_start, felt_end = dofs[ACCEL_START, i] + pull.real, dofs[ACCEL_END, i] + pull_end.real
                ends = felt_start, felt_end, dofs[JERK_START, i], dofs[JERK_END, i]
                peak = max(dofs[ACCELERATION, i], abs(felt_start))
                dofs[ACCELERATION, i] = peak_over_step(row, run, group, (ACCELERATION, i), peak, ends, span)


@kernel
def update_point_peaks(row, run, group, span, origin_time):
    """Raise the peak forces of closed contacts and the extremes of all distances by those over an accepted step.

    ``span`` = (s, h, base), ``origin_time`` = time of the clock's origin [s].
    """
    dofs = run.dofs
    for k in range(row.frame[START, group.watched_first], row.frame[START, group.watched_last]):
        inside = row.frame[START, group.first] <= k < row.frame[START, group.last]
        contact = run.contacts[k]
        if inside and contact.closed > 0.0:
            update_force_peak(row, run, group, k, span, origin_time)
        else:
            start, end = across(row, k, dofs, NOW), across(row, k, dofs, END)
            start_slope, end_slope = across(row, k, dofs, SLOPE), across(row, k, dofs, SLOPE + LAST)
            ends = start, end, start_slope, end_slope
            contact.highest = extreme_over_step(row, run, group, (REACH, k, 1.0), contact.highest, ends, span)
            ends = -start, -end, -start_slope, -end_slope
            contact.lowest = -extreme_over_step(row, run, group, (REACH, k, -1.0), -contact.lowest, ends, span)
    for side in range(2):
        first, last = unwatched_points(row, (group.first, group.last), (group.watched_first, group.watched_last), side)
        for k in range(first, last):
            update_side_extremes(row, run, group, k, RIGHT_HIGH if side == 0 else LEFT_HIGH, span)
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, group.first, group.last) and follows_rate(run, k):
            update_damper(row, run, group, k, span)


@kernel
def update_damper(row, run, group, k, span):
    """Largest speed and energy of a damper go on by an accepted step, the energy by five points of Gauss."""
    dofs = run.dofs
    if is_braced(run, k):
        i = brace_of(run, k)
        start, end = damper_speed(run, k, dofs[NOW, i]), damper_speed(run, k, dofs[END, i])
        # Its local maxima are those of the brace's deformation: slopes are needed for their signs and their ratio.
        rise, rise_end = brace_rise(run, k, NOW, SLOPE), brace_rise(run, k, END, SLOPE + LAST)
    else:
        start, end = across(row, k, dofs, NOW + VELOCITY), across(row, k, dofs, END + VELOCITY)
        rise, rise_end = across(row, k, dofs, SLOPE + SLOPES), across(row, k, dofs, SLOPE + SLOPES + LAST)
    for side in range(2):
        sign = 1.0 - 2.0 * side
        ends = sign * start, sign * end, sign * rise, sign * rise_end
        best = run.links[k, FASTEST]
        run.links[k, FASTEST] = extreme_over_step(row, run, group, (SPEED, k, sign), best, ends, span)
    write_polynomial(row, run, group, span[0], span[1])
    for x, weight in GAUSS:
        clock = span[0] + x * span[1]
        speed = signal_between(row, run, group, SPEED, k, x, span)
        if is_braced(run, k):
            power = run.links[k, BRACE] * between(run, 0, brace_of(run, k), x) * speed
        else:
            power = (force_in_contact(run, k, speed) + run.links[k, STIFFNESS] * speed) * speed
        run.links[k, TAKEN] += weight * power * 4.0 * clock * clock * clock * span[1]


@kernel
def brace_rise(run, k, state, line):
    """Slope per unit of s of the speed of a damper on a brace, its state and slopes in these rows."""
    i = brace_of(run, k)
    damper_speed(run, k, run.dofs[state, i])
    return run.links[k, BRACE] * run.workspace.law_arguments[3] * run.dofs[line, i]


@kernel
def update_side_extremes(row, run, group, k, column, span):
    """Extremes over a step of the group's own part of a distance across which nobody looks."""
    dofs, sides = run.dofs, run.contacts[k].side_extremes
    low, high = group.low, group.high
    start, end = part_of_distance(row, k, low, high, dofs, NOW), part_of_distance(row, k, low, high, dofs, END)
    start_slope, end_slope = (
        part_of_distance(row, k, low, high, dofs, SLOPE),
        part_of_distance(row, k, low, high, dofs, SLOPE + LAST),
    )
    for side in range(2):
        sign, extreme = 1.0 - 2.0 * side, column + side
        ends = sign * start, sign * end, sign * start_slope, sign * end_slope
        best = extreme_over_step(row, run, group, (SIDE, k, sign), sign * sides[extreme], ends, span)
        sides[extreme] = sign * best


@kernel
def update_force_peak(row, run, group, k, span, origin_time):
    """Peak uncapped force of a contact over a step, the yield that it may be, the lowest force of a law that pulls."""
    contact = run.contacts[k]
    start, end_force, start_slope, end_slope = (
        contact.force[AT_START],
        contact.force[AT_END],
        contact.force_slope[AT_START],
        contact.force_slope[AT_END],
    )
    peak_before = contact.peak_force
    best = max(peak_before, start)
    if 2.0 * max(start, end_force) > best:
        best = max(best, end_force)
        if may_hide_maximum(start, end_force, start_slope, end_slope, span[0], span[1], best):
            write_polynomial(row, run, group, span[0], span[1])
            best = max(best, local_maximum(row, run, group, (PUSH, k, 1.0), span)[0])
    if best > peak_before and run.timed.shape[2] > 0:
        time_levels(row, run, group, k, best, span, origin_time)
    contact.peak_force = best
    if contact.least_force == -inf:
        lowest = min(start, end_force)
        if 2.0 * lowest < contact.counters[LOWEST_FORCE]:
            if may_hide_maximum(
                -start,
                -end_force,
                -start_slope,
                -end_slope,
                span[0],
                span[1],
                -min(lowest, contact.counters[LOWEST_FORCE]),
            ):
                write_polynomial(row, run, group, span[0], span[1])
                lowest = min(lowest, -local_maximum(row, run, group, (PUSH, k, -1.0), span)[0])
            contact.counters[LOWEST_FORCE] = min(contact.counters[LOWEST_FORCE], lowest)
    if int(contact.region) == ELASTIC and contact.strength < inf and best > peak_before and best >= contact.strength:
        # A local maximum that just passes F_E is a yield too, though no branch of it is landed on.
        end = span[0] + span[1]
        note_yield(run, k, origin_time + end * end * end * end)
    if int(contact.region) > ELASTIC:
        delta = max(across(row, k, run.dofs, END) - contact.gap, 0.0)
        rate = across(row, k, run.dofs, END + VELOCITY)
        force = transmitted(run, k, delta, rate)
        contact.plateau_force = max(contact.plateau_force, force)


@kernel
def time_levels(row, run, group, k, best, span, origin_time):
    """Time the levels that the uncapped force of contact ``k`` reaches first on this step."""
    contact = run.contacts[k]
    for level in range(run.timed.shape[2]):
        if run.timed[0, k, level] > best or run.timed[1, k, level] == run.timed[1, k, level]:
            continue
        x = 0.0
        if contact.force[AT_START] < run.timed[0, k, level]:
            write_polynomial(row, run, group, span[0], span[1])
            low, high = 0.0, 1.0
            if contact.force[AT_END] < run.timed[0, k, level]:
                high = local_maximum(row, run, group, (PUSH, k, 1.0), span)[1]
            for _ in range(50):
                x = 0.5 * (low + high)
                if signal_between(row, run, group, PUSH, k, x, span) < run.timed[0, k, level]:
                    low = x
                else:
                    high = x
            x = high
        s = span[0] + x * span[1]
        run.timed[1, k, level] = origin_time + s * s * s * s
        if contact.counters[FIRST_YIELD] != contact.counters[FIRST_YIELD]:
            contact.counters[FIRST_YIELD] = run.timed[1, k, level]
