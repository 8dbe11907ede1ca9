"""Distances between two linear buildings without contact over a block of nodes: extremes, bounds, largest rates."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.building import write_series
from pounding_risk.solver.row.contact_points import bend_across, raise_reach, wider
from pounding_risk.solver.row.free_buildings import TURN, WIDTH, place_at
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.workspace import NODE, QUICK, ROOT, START

RATE = 1


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
    """|fourth derivative of u_left − u_right| over sqrt(2 E), as `contact_points.bend_across`, that of w left out."""
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
