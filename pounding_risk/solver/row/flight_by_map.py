"""Buildings of a row that fly on their own over one node interval, by a map from node to node."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.pair.taylor import local_maximum_bound
from pounding_risk.solver.row.building import accelerate, write_series
from pounding_risk.solver.row.contact_points import (
    across,
    compliance,
    may_have_new_extreme,
    raise_extremes,
    search_point,
    second_derivative_bound,
)
from pounding_risk.solver.row.flight_peaks import motion_bound, raise_interval_peaks
from pounding_risk.solver.row.ground_dof import end_ground, top_of
from pounding_risk.solver.row.law_events import middle_and_half
from pounding_risk.solver.row.node_map import map_motion
from pounding_risk.solver.row.storey import has_law
from pounding_risk.solver.row.workspace import (
    ACCEL_END,
    ACCEL_START,
    BOTTOM,
    BRANCH,
    CAN_YIELD,
    COUPLED,
    FIRST,
    LIMIT,
    MOTION_BOUND,
    NEXT,
    NODE,
    PLASTIC,
    ROOT,
    SPRING,
    START,
    TANGENT,
)


@kernel
def is_elastic(row, run, b):
    """True where every storey of building ``b`` is on its elastic branch, and the map about its rest holds."""
    if row.frame[CAN_YIELD, b]:
        if row.frame[COUPLED, b] > 0:
            return False  # where it rests with its plastic drifts is not known storey by storey
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            if run.dofs[BRANCH, i] != 0.0 or run.dofs[TANGENT, i] != row.floors[SPRING, i]:
                return False
    return True


@kernel
def may_yield(row, run, b, swing, step):
    """True where a storey's drift may pass its limit within the node interval, by `flight_peaks.motion_bound`."""
    below = below_end = below_bend = 0.0
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        if row.floors[BOTTOM, i] > 0.0:
            below = below_end = below_bend = 0.0
        bend = sqrt(swing) * row.floors[ROOT, i]
        start, end, plastic = run.dofs[NODE, i], run.dofs[NEXT, i], run.dofs[PLASTIC, i]
        limit = row.floors[LIMIT, i]
        if has_law(run, i):
            plastic, limit = middle_and_half(run.storeys, i)
        top = max(abs(start - below - plastic), abs(end - below_end - plastic)) + 0.125 * step * step * (
            bend + below_bend
        )
        if not top < limit:
            return True
        below, below_end, below_bend = start, end, bend
    return False


@kernel
def predict_by_map(row, run, b, window):
    """Building ``b`` over one node interval on its own: rows NODE to rows NEXT, ü at the node in ACCEL_START.

    Leaves 2 E of its bounds in row MOTION_BOUND of the marks; returns False where a storey yields, or may.
    """
    _, step, ground = window
    run.marks[MOTION_BOUND, b] = 0.0
    if row.frame[FIRST, b] == top_of(row, b):
        end_ground(row, b, ground, run.dofs, NEXT)
        return True
    run.marks[MOTION_BOUND, b] = inf
    if row.frame[CAN_YIELD, b] and not is_elastic(row, run, b):
        return False
    pull, rise = ground.under(b)
    accelerate(row, b, NODE, pull, run.dofs, ACCEL_START)
    map_motion(row, b, ground, run.dofs, NODE, NEXT)
    run.marks[MOTION_BOUND, b] = motion_bound(row, b, rise, run.dofs, NODE, ACCEL_START)
    if row.frame[CAN_YIELD, b] and may_yield(row, run, b, run.marks[MOTION_BOUND, b], step):
        run.marks[MOTION_BOUND, b] = inf
        return False
    return True


@kernel
def touch_within(row, run, interface, window, terms):
    """True where two buildings that both fly alone touch within the node interval."""
    _, step, ground = window
    swing = sqrt(max(run.marks[MOTION_BOUND, interface], run.marks[MOTION_BOUND, interface + 1]))
    has_series = False
    for k in range(row.frame[START, interface], row.frame[START, interface + 1]):
        start, end = across(row, k, run.dofs, NODE), across(row, k, run.dofs, NEXT)
        bend = swing * second_derivative_bound(row, k) + ground.ground_curves(interface + 1, step)
        top = max(start, end) + 0.125 * step * step * bend
        if not top > run.contacts[k].gap or compliance(row, k) == 0.0:
            continue
        if local_maximum_bound(start, end, step, bend) > run.contacts[k].gap:
            if not has_series:
                write_series(row, run, interface, NODE, ground, terms)
                write_series(row, run, interface + 1, NODE, ground, terms)
                has_series = True
            if search_point(row, run, k, run.contacts[k].gap, step, terms) >= 0.0:
                return True
    return False


@kernel
def update_distances(row, run, interface, window, terms):
    """Raise the extremes of the distances between two buildings that have both flown alone."""
    _, step, ground = window
    swing = sqrt(max(run.marks[MOTION_BOUND, interface], run.marks[MOTION_BOUND, interface + 1]))
    has_series = False
    for k in range(row.frame[START, interface], row.frame[START, interface + 1]):
        start, end = across(row, k, run.dofs, NODE), across(row, k, run.dofs, NEXT)
        bend = swing * second_derivative_bound(row, k) + ground.ground_curves(interface + 1, step)
        if may_have_new_extreme(run, k, start, end, step, bend):
            if not has_series:
                write_series(row, run, interface, NODE, ground, terms)
                write_series(row, run, interface + 1, NODE, ground, terms)
                has_series = True
            raise_extremes(row, run, k, step, terms)


@kernel
def update_peaks(row, run, b, window, terms):
    """Raise the peaks of a building that is alone over the interval, rows NODE to rows NEXT."""
    _, step, ground = window
    pull, rise = ground.under(b)
    accelerate(row, b, NEXT, pull + rise * step, run.dofs, ACCEL_END)
    ends = NODE, NEXT, ACCEL_START, ACCEL_END
    raise_interval_peaks(row, run, b, ends, run.marks[MOTION_BOUND, b], window, terms)
