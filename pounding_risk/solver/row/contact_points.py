"""Contact points of buildings in flight: where they stand, and the search for touches and peaks of their distance."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.taylor import SIGNAL, first_rise, highest, local_maximum_bound
from pounding_risk.solver.row.inertia import response
from pounding_risk.solver.row.workspace import (
    FIRST,
    INVERSE,
    LEFT_HIGH,
    LEFT_LOW,
    MOBILITY,
    NODE,
    RIGHT_HIGH,
    RIGHT_LOW,
    ROOT,
    START,
    VELOCITY,
)


@small
def across(row, k, dofs, line):
    """u_left − u_right at contact point ``k``, less the w of the ground, from a row of the dofs (of v: its rate)."""
    total = 0.0
    for end in range(row.passage.point_ends()):
        i = row.ends[k, end]
        if i >= 0:
            total += row.shares[k, end] * dofs[line, i]
    return total


@small
def across_and_rate(row, k, dofs, state):
    """(u_left − u_right at contact point ``k``, less the w of the ground, its rate) in rows ``state``; as `across`."""
    total = rate = 0.0
    for end in range(row.passage.point_ends()):
        i = row.ends[k, end]
        if i >= 0:
            share = row.shares[k, end]
            total, rate = total + share * dofs[state, i], rate + share * dofs[state + VELOCITY, i]
    return total, rate


@kernel
def compliance(row, k):
    """1/m of both sides of contact point ``k``: B M⁻¹ Bᵀ, which for two masses is 1/m1 + 1/m2 [1/kg]."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += row.shares[k, end] * row.shares[k, end] * row.floors[MOBILITY, i]
    if row.inertia.shape[1] > 0:
        for end in range(0, 4, 2):  # both floors of a column
            if row.ends[k, end] >= 0 and row.ends[k, end + 1] >= 0:
                both = row.shares[k, end] * row.shares[k, end + 1]
                total += 2.0 * both * response(row, row.ends[k, end], row.ends[k, end + 1])
    return total


@small
def push_apart(row, k, force, dofs, line):
    """Add the accelerations that a contact force gives to the floors at both ends to a row of the dofs."""
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            dofs[line, i] -= row.shares[k, end] * row.floors[INVERSE, i] * force


@small
def power_through_ground(row, k, power, force, dofs, line):
    """``power`` [W] and what the contact force at point ``k`` does as the grounds move; velocities in row ``line``."""
    if row.passage.ground_dofs() > 0:
        power += force * row.shares[k, 4] * dofs[line, row.ends[k, 4]]
    return power


@kernel
def write_distance(row, run, k, terms):
    """The series of u_left − u_right at contact point ``k`` to the workspace."""
    signals = run.workspace.search.series
    for n in range(terms):
        signals[SIGNAL, n] = 0.0
    for end in range(row.passage.point_ends()):
        i = row.ends[k, end]
        if i >= 0:
            share = row.shares[k, end]
            for n in range(terms):
                signals[SIGNAL, n] += share * run.series[i, n]


@kernel
def search_point(row, run, k, gap, stop, terms):
    """When contact point ``k`` touches on (0, stop], or −1; the series of both buildings stand."""
    write_distance(row, run, k, terms)
    return first_rise(run.workspace.search, terms, gap, stop)


@kernel
def raise_extremes(row, run, k, stop, terms):
    """Raise the extremes of u_left − u_right at contact point ``k`` by those on [0, stop] of its series."""
    write_distance(row, run, k, terms)
    contact, search = run.contacts[k], run.workspace.search
    contact.highest = highest(search, SIGNAL, terms, 1.0, stop, contact.highest)
    contact.lowest = -highest(search, SIGNAL, terms, -1.0, stop, -contact.lowest)


@kernel
def second_derivative_bound(row, k):
    """|second derivative of u_left − u_right + w| over sqrt(2 E), E the larger bound of both buildings' motion."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += abs(row.shares[k, end]) * row.floors[ROOT, i]
    return total


@kernel
def may_have_new_extreme(run, k, start, end, span, bend):
    """True where a new extreme of a distance may lie inside a segment of flight; those at its end are entered.

    The bounds of the distance are widened by those of the segment.
    """
    eighth = 0.125 * span * span * bend
    contact = run.contacts[k]
    contact.highest = max(contact.highest, end)
    contact.lowest = min(contact.lowest, end)
    top, bottom = max(start, end) + eighth, min(start, end) - eighth
    # The coarser bounds first: they settle most segments without a division.
    if top > contact.highest or bottom < contact.lowest:
        top, bottom = local_maximum_bound(start, end, span, bend), -local_maximum_bound(-start, -end, span, bend)
    contact.upper_bound, contact.lower_bound = max(contact.upper_bound, top), min(contact.lower_bound, bottom)
    # What is not finite is searched, and ends the run with its status.
    return top > contact.highest or bottom < contact.lowest or not abs(top) < inf


@kernel
def part_of_distance(row, k, low, high, dofs, line):
    """What the dofs from ``low`` to ``high`` add to u_left − u_right at contact point ``k``, from a row of the dofs."""
    total = 0.0
    for end in range(row.passage.point_ends()):
        i = row.ends[k, end]
        if low <= i < high:
            total += row.shares[k, end] * dofs[line, i]
    return total


@kernel
def unwatched_points(row, span, watch, side):
    """(first, past the last) contact point of a group's left or right interface, where nobody looks on across it."""
    if side == 0 and watch[0] == span[0] and span[0] > 0:
        return row.frame[START, span[0] - 1], row.frame[START, span[0]]
    if side == 1 and watch[1] == span[1] and span[1] < row.frame.shape[1] - 2:
        return row.frame[START, span[1]], row.frame[START, span[1] + 1]
    return 0, 0


@kernel
def begin_unwatched_extremes(row, run, span, watch):
    """Extremes of a group's own part of the distances that nobody looks across, at the start of an interval."""
    low, high = row.frame[FIRST, span[0]], row.frame[FIRST, span[1] + 1]
    for side in range(2):
        first, last = unwatched_points(row, span, watch, side)
        column = RIGHT_HIGH if side == 0 else LEFT_HIGH
        for k in range(first, last):
            sides = run.contacts[k].side_extremes
            sides[column] = sides[column + 1] = part_of_distance(row, k, low, high, run.dofs, NODE)


@kernel
def raise_unwatched_extremes(row, run, span, watch, stop, terms):
    """Raise those extremes by the series of a flight on [0, stop]."""
    search = run.workspace.search
    low, high = row.frame[FIRST, span[0]], row.frame[FIRST, span[1] + 1]
    for side in range(2):
        first, last = unwatched_points(row, span, watch, side)
        column = RIGHT_HIGH if side == 0 else LEFT_HIGH
        for k in range(first, last):
            for n in range(terms):
                search.series[SIGNAL, n] = 0.0
            for end in range(row.passage.point_ends()):
                i = row.ends[k, end]
                if low <= i < high:
                    for n in range(terms):
                        search.series[SIGNAL, n] += row.shares[k, end] * run.series[i, n]
            sides = run.contacts[k].side_extremes
            sides[column] = highest(search, SIGNAL, terms, 1.0, stop, sides[column])
            sides[column + 1] = -highest(search, SIGNAL, terms, -1.0, stop, -sides[column + 1])


@kernel
def stay_apart(row, run, interface):
    """True where two groups that did not look across an interface have kept clear of it, and of its extremes so far."""
    for k in range(row.frame[START, interface], row.frame[START, interface + 1]):
        contact, sides = run.contacts[k], run.contacts[k].side_extremes
        high, low = sides[LEFT_HIGH] + sides[RIGHT_HIGH], sides[LEFT_LOW] + sides[RIGHT_LOW]
        if not (high < min(contact.gap, contact.highest) and low > contact.lowest):
            return False
    return True
