"""Distances between two linear buildings without contact over a block of nodes: extremes, bounds, largest rates."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.building import write_series
from pounding_risk.solver.row.contact_points import may_have_new_extreme, raise_extremes, second_derivative_bound
from pounding_risk.solver.row.free_buildings import PATH_ACCELERATION, WIDTH, place_at
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.workspace import NODE, QUICK, ROOT, START

RATE = 1


@kernel
def place_across(row, work, k, point, count):
    """u_left − u_right of a contact point, less the w of the ground, and both its derivatives at the nodes of a block.

    The second derivative is that of the floors, without ẅ.
    """
    for line in range(3):
        for n in range(count + 1):
            work.distances[line, point, n] = 0.0
        for end in range(4 if line == PATH_ACCELERATION else row.passage.point_ends()):
            i = row.ends[k, end]
            if i >= 0:
                share = row.shares[k, end]
                for n in range(count + 1):
                    work.distances[line, point, n] += share * work.paths[line, i, n]


@kernel
def fourth_derivative_bound(row, k):
    """|fourth derivative of u_left − u_right| over sqrt(2 E), as `second_derivative_bound`, that of w left out."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += abs(row.shares[k, end]) * row.floors[ROOT, i] * row.floors[QUICK, i]
    return total


@kernel
def write_bends(row, free, work, interface, k, begin, count):
    """Upper bounds of |second derivative of u_left − u_right| over each interval of a block, to ``work.bends``."""
    point = k - row.frame[START, interface]
    bend, stir = second_derivative_bound(row, k), fourth_derivative_bound(row, k)
    for n in range(count):
        swing = max(work.swings[1, interface, n], work.swings[1, interface + 1, n])
        eighth = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n]
        at_nodes = max(
            abs(work.distances[PATH_ACCELERATION, point, n]), abs(work.distances[PATH_ACCELERATION, point, n + 1])
        )
        work.bends[point, n] = min(at_nodes + eighth * stir * swing, bend * swing)
    for n in range(count):
        ground = free.ground.from_node(free.step, begin + n)
        work.bends[point, n] += ground.ground_curves(interface + 1, work.ground[WIDTH, n])


@kernel
def raise_distance(run, work, k, point, count):
    """Raise the extremes of a distance by those at the nodes of a block; returns whether others may lie between two.

    Its bounds become those in the block, and its largest rate is raised.
    """
    contact = run.contacts[k]
    high, low, fastest = contact.highest, contact.lowest, contact.fastest
    top, bottom, start = -inf, inf, work.distances[0, point, 0]
    for n in range(count):
        end = work.distances[0, point, n + 1]
        high, low, fastest = max(high, end), min(low, end), max(fastest, abs(work.distances[RATE, point, n + 1]))
        sag = 0.125 * work.ground[WIDTH, n] * work.ground[WIDTH, n] * work.bends[point, n]
        top, bottom = max(top, max(start, end) + sag), min(bottom, min(start, end) - sag)
        start = end
    contact.highest, contact.lowest, contact.fastest = high, low, fastest
    contact.upper_bound, contact.lower_bound = top, bottom
    return top > high or bottom < low


@kernel
def raise_distances(row, run, free, work, interface, begin, count):
    """Extremes, bounds and largest rates of the distances between two linear buildings over a block."""
    first_point, past_point, may_pass = row.frame[START, interface], row.frame[START, interface + 1], False
    for k in range(first_point, past_point):
        place_across(row, work, k, k - first_point, count)
        write_bends(row, free, work, interface, k, begin, count)
        may_pass = raise_distance(run, work, k, k - first_point, count) or may_pass
    if not may_pass:
        return
    for k in range(first_point, past_point):
        run.contacts[k].upper_bound, run.contacts[k].lower_bound = -inf, inf
    for n in range(count):
        _, width, ground = window_at(free.ground, free.step, begin + n)
        has_series = False
        for k in range(first_point, past_point):
            start, end = work.distances[0, k - first_point, n], work.distances[0, k - first_point, n + 1]
            if not may_have_new_extreme(run, k, start, end, width, work.bends[k - first_point, n]):
                continue
            for b in range(interface, interface + 2):
                if not has_series:
                    place_at(row, run, work, b, n, NODE)
                    write_series(row, run, b, NODE, ground, free.terms)
            has_series = True
            raise_extremes(row, run, k, width, free.terms)
    for b in range(interface, interface + 2):
        place_at(row, run, work, b, count, NODE)
