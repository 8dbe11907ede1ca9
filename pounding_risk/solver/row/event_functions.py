"""Margins of the events of a group in contact: positive until the event.

The kinds of `pair.events` for every contact, and two of a row's own: an open contact point touches, a storey changes
its branch.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import DIRECTION
from pounding_risk.solver.pair.equations import YIELDING
from pounding_risk.solver.pair.events import CUT, KNEE, MET, PART, TURN, YIELD
from pounding_risk.solver.pair.taylor import slope_at, value_at
from pounding_risk.solver.row.contact_points import across
from pounding_risk.solver.row.equations import uncapped
from pounding_risk.solver.row.explicit import between
from pounding_risk.solver.row.law_events import OVER, corner_margin, strain_margin
from pounding_risk.solver.row.link import follows_rate
from pounding_risk.solver.row.storey import creep_rate, drift_in, has_law
from pounding_risk.solver.row.workspace import (
    AT_END,
    AT_START,
    BOTTOM,
    BRANCH,
    END,
    LAST,
    LIMIT,
    NOW,
    PLASTIC,
    SLOPE,
    SLOPES,
    START,
    VELOCITY,
)

TOUCH, STRAIN, CORNER = 6, 7, 8  # CORNER: a storey with a law is loaded to the end of its branch
ROUNDED = 1e-15  # m: displacements of metres round by a part of this, and no touch can be distinguished from it


@kernel
def read_force(row, run, group, h, state, line, end):
    """Write every contact's uncapped force and its slope per unit of s at one end of the step."""
    dofs = run.dofs
    nudge = 1e-7 * h
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        contact = run.contacts[k]
        if contact.closed > 0.0:
            delta, rate = across(row, k, dofs, state) - contact.gap, across(row, k, dofs, state + VELOCITY)
            nudged_delta = delta + nudge * across(row, k, dofs, line)
            nudged_rate = rate + nudge * across(row, k, dofs, line + SLOPES)
            force = uncapped(run, k, max(delta, 0.0), rate)
            contact.force[end] = force
            contact.force_slope[end] = (uncapped(run, k, max(nudged_delta, 0.0), nudged_rate) - force) / nudge


@kernel
def force_event_function(run, kind, k, force, rise):
    """(margin, slope) of the kinds of event that the uncapped force makes."""
    contact = run.contacts[k]
    if kind == YIELD:
        sign = 1.0 if contact.region > 0.0 else -1.0
        return sign * (force - contact.strength) + MET * contact.strength, sign * rise
    sign = -1.0 if contact.region < 0.0 else 1.0
    return sign * force, sign * rise


@kernel
def strain_event_function(row, run, i, drift, rate):
    """(margin, its slope per unit of the drift's) of a storey's next change of branch."""
    branch = run.dofs[BRANCH, i]
    if branch != 0.0:
        return branch * rate + creep_rate(row, i), 0.0
    strain = drift - run.dofs[PLASTIC, i]
    side = 1.0 if strain >= 0.0 else -1.0
    return OVER * row.floors[LIMIT, i] - side * strain, -side


@small
def follows_law(row, run, i):
    """True where storey ``i`` has a law of its own, or is a link with one, which are counted behind the dofs."""
    return i >= row.floors.shape[1] or has_law(run, i)


@kernel
def law_event_function(row, run, kind, i, state, line):
    """(margin, slope per unit of s) of an event of a law, its state in rows ``state``, slopes of it in ``line``."""
    dofs, dof_count = run.dofs, row.floors.shape[1]
    if i < dof_count:
        drift, rate = drift_in(row, dofs, state, i), drift_in(row, dofs, state + VELOCITY, i)
        drift_slope, rate_slope = drift_in(row, dofs, line, i), drift_in(row, dofs, line + SLOPES, i)
        margins = law_margin(run.storeys, kind, i, drift, rate)
        direction = run.storeys[i, DIRECTION]
    else:
        k = i - dof_count
        drift, rate = across(row, k, dofs, state), across(row, k, dofs, state + VELOCITY)
        drift_slope, rate_slope = across(row, k, dofs, line), across(row, k, dofs, line + SLOPES)
        margins = law_margin(run.links, kind, k, drift, rate)
        direction = run.links[k, DIRECTION]
    if kind == STRAIN and direction != 0.0:
        return margins[0], direction * rate_slope
    return margins[0], margins[1] * drift_slope


@small
def law_margin(numbers, kind, i, drift, rate):
    """(margin, its slope per unit of the drift's) of an event of a law."""
    if kind == CORNER:
        return corner_margin(numbers, i, drift)
    return strain_margin(numbers, i, drift, rate)


@kernel
def storey_event_function(row, run, kind, i, state, line):
    """(margin, slope per unit of s) of an event of a storey or link; rows of its state and of its slopes."""
    if follows_law(row, run, i):
        return law_event_function(row, run, kind, i, state, line)
    dofs, branch = run.dofs, run.dofs[BRANCH, i]
    if branch != 0.0:
        rate = drift_in(row, dofs, state + VELOCITY, i)
        return branch * rate + creep_rate(row, i), branch * drift_in(row, dofs, line + SLOPES, i)
    value, turn = strain_event_function(row, run, i, drift_in(row, dofs, state, i), 0.0)
    return value, turn * drift_in(row, dofs, line, i)


@kernel
def event_function(row, run, kind, k, at_end):
    """(margin, slope per unit of s) of an event at the start or the end of a step."""
    dofs = run.dofs
    state = END if at_end else NOW
    line = SLOPE + LAST if at_end else SLOPE
    if kind >= STRAIN:
        return storey_event_function(row, run, kind, k, state, line)
    contact = run.contacts[k]
    if kind == TOUCH:
        return contact.gap + ROUNDED - across(row, k, dofs, state), -across(row, k, dofs, line)
    if kind == TURN:
        sign = 1.0 if contact.approaching > 0.0 else -1.0
        return sign * across(row, k, dofs, state + VELOCITY) + contact.still_speed, sign * across(
            row, k, dofs, line + SLOPES
        )
    if kind == PART:
        return across(row, k, dofs, state) - contact.gap, across(row, k, dofs, line)
    if kind == KNEE:
        sign = -1.0 if contact.approaching > 0.0 else 1.0
        return sign * (across(row, k, dofs, state) - contact.gap - contact.knee_depth), sign * across(
            row, k, dofs, line
        )
    at = AT_END if at_end else AT_START
    return force_event_function(run, kind, k, contact.force[at], contact.force_slope[at])


@kernel
def across_between(row, run, group, k, part, x, time):
    """u_left − u_right (part 0) or its rate at x of the step; ``time`` is the time on the spectators' series."""
    total = 0.0
    for end in range(row.passage.point_ends()):
        i = row.ends[k, end]
        if i >= 0:
            if group.low <= i < group.high:
                value = between(run, part, i, x)
            elif part == 0:
                value = value_at(run.series, i, group.terms, time)
            else:
                value = slope_at(run.series, i, group.terms, time)
            total += row.shares[k, end] * value
    return total


@kernel
def event_function_between(row, run, group, kind, k, x, span):
    """The margin of an event at a place x of the step, 0 to 1, on the polynomial; ``span`` = (s, h, base)."""
    if kind in (STRAIN, CORNER):
        if k >= row.floors.shape[1]:
            link = k - row.floors.shape[1]
            drift = across_between(row, run, group, link, 0, x, 0.0)
            rate = across_between(row, run, group, link, 1, x, 0.0)
            return law_margin(run.links, kind, link, drift, rate)[0]
        drift, rate = between(run, 0, k, x), between(run, 1, k, x)
        if row.floors[BOTTOM, k] == 0.0:
            drift, rate = drift - between(run, 0, k - 1, x), rate - between(run, 1, k - 1, x)
        if has_law(run, k):
            return law_margin(run.storeys, kind, k, drift, rate)[0]
        return strain_event_function(row, run, k, drift, rate)[0]
    contact = run.contacts[k]
    clock = span[0] + x * span[1]
    time = group.origin + clock * clock * clock * clock - span[2]
    if kind == TOUCH:
        return contact.gap + ROUNDED - across_between(row, run, group, k, 0, x, time)
    if kind == TURN:
        sign = 1.0 if contact.approaching > 0.0 else -1.0
        return sign * across_between(row, run, group, k, 1, x, time) + contact.still_speed
    delta = across_between(row, run, group, k, 0, x, time) - contact.gap
    if kind == PART:
        return delta
    if kind == KNEE:
        return contact.knee_depth - delta if contact.approaching > 0.0 else delta - contact.knee_depth
    rate = across_between(row, run, group, k, 1, x, time)
    force = uncapped(run, k, max(delta, 0.0), rate)
    return force_event_function(run, kind, k, force, 0.0)[0]


@kernel
def is_possible(row, run, kind, k):
    """True for the kinds of event that contact ``k``, or storey ``k``, can meet as it is."""
    if kind >= STRAIN:
        if k >= row.floors.shape[1]:
            link = k - row.floors.shape[1]
            return not follows_rate(run, link) and (kind == STRAIN or run.links[link, DIRECTION] != 0.0)
        return row.floors[LIMIT, k] < inf if kind == STRAIN else has_law(run, k) and run.dofs[BRANCH, k] != 0.0
    contact = run.contacts[k]
    if kind == TOUCH:
        return contact.closed == 0.0
    if contact.closed == 0.0:
        return False
    if kind == YIELD:
        return contact.strength < inf
    if kind == CUT:
        return contact.least_force > -inf and int(contact.region) != YIELDING
    if kind == KNEE:
        return contact.knee_depth < inf
    return kind != PART or contact.approaching == 0.0
