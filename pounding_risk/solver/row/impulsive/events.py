"""Single masses between two jumps: peaks, and the next touch or end of a rest."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import IMPULSE
from pounding_risk.solver.pair.joined import ROUNDING
from pounding_risk.solver.pair.taylor import first_rise, highest
from pounding_risk.solver.row.impulsive.motion import displacement_of
from pounding_risk.solver.workspace import LEFT, RIGHT, SIGNAL


@kernel
def move_series(body, terms, x, search, row):
    """The series of a building with its x counted from ``x`` on, to a row of the workspace."""
    for n in range(terms):
        search.series[row, n] = body.series[n]
    if x > 0.0 and body.mass > 0.0:
        for k in range(terms - 1):
            for n in range(terms - 2, k - 1, -1):
                search.series[row, n] += x * search.series[row, n + 1]


@kernel
def write_distance(chain, i, since, ground, terms):
    """The series of u_left − u_right − w of interface ``i`` from ``since`` on; ``ground`` begins at the node."""
    left, right, search = chain.bodies[i], chain.bodies[i + 1], chain.totals.search
    move_series(left, terms, since - left.since, search, LEFT)
    move_series(right, terms, since - right.since, search, RIGHT)
    for n in range(terms):
        search.series[SIGNAL, n] = search.series[LEFT, n] - search.series[RIGHT, n]
    w, rate, bend, twist = ground.later(since).ground_moves(i + 1)
    search.series[SIGNAL, 0] -= w
    search.series[SIGNAL, 1] -= rate
    search.series[SIGNAL, 2] -= 0.5 * bend
    search.series[SIGNAL, 3] -= twist / 6.0


@kernel
def raise_body_peaks(chain, b, t, terms):
    """Raise the peaks of building ``b`` by those from the start of its series to ``t``."""
    body, search = chain.bodies[b], chain.totals.search
    x = t - body.since
    if body.mass == 0.0 or x <= 0.0:
        return
    reach, shake, power = 0.0, abs(body.pull) + abs(body.rise) * x, 1.0
    for n in range(terms):
        reach += abs(body.series[n]) * power
        if n + 2 < terms:
            shake += (n + 1) * (n + 2) * abs(body.series[n + 2]) * power
        power *= x
    # Put so that what is not finite is searched.
    if not reach <= body.peak_displacement:
        move_series(body, terms, 0.0, search, SIGNAL)
        for sign in (1.0, -1.0):
            body.peak_displacement = highest(search, SIGNAL, terms, sign, x, body.peak_displacement)
    if not shake <= body.peak_acceleration:
        for n in range(terms - 2):
            search.series[SIGNAL, n] = (n + 1) * (n + 2) * body.series[n + 2]
        search.series[SIGNAL, 0] += body.pull
        search.series[SIGNAL, 1] += body.rise
        for sign in (1.0, -1.0):
            body.peak_acceleration = highest(search, SIGNAL, terms - 2, sign, x, body.peak_acceleration)


@small
def common_start(chain, i):
    """Where the distance at interface ``i`` begins to be that of both series, after the node [s]."""
    return max(chain.bodies[i].since, chain.bodies[i + 1].since)


@kernel
def raise_link_extremes(chain, i, t, ground, terms):
    """Raise the extremes of interface ``i`` by those up to ``t``; at rest, its force and impulse."""
    link, search = chain.links[i], chain.totals.search
    since = common_start(chain, i)
    x = t - since
    if x <= 0.0:
        return
    if link.rests > 0.0:
        push, link.acting_force, power = 0.0, 0.0, 1.0
        for n in range(terms - 2):
            search.series[SIGNAL, n] = link.force[n]
            link.acting_force += link.force[n] * power
            power *= x
            push += link.force[n] * power / (n + 1)
        link.counters[IMPULSE] += push
        link.peak_force = highest(search, SIGNAL, terms - 2, 1.0, x, link.peak_force)
        link.acting_force = max(link.acting_force, 0.0)
        return
    write_distance(chain, i, since, ground, terms)
    spread, power = 0.0, x
    for n in range(1, terms):
        spread += abs(search.series[SIGNAL, n]) * power
        power *= x
    centre = search.series[SIGNAL, 0]
    if not centre + spread <= link.highest:
        link.highest = highest(search, SIGNAL, terms, 1.0, x, link.highest)
    if not centre - spread >= link.lowest:
        link.lowest = -highest(search, SIGNAL, terms, -1.0, x, -link.lowest)


@kernel
def plan_event(chain, i, ground, width, terms):
    """Find the next event of interface ``i`` in the interval: its touch, or the end of its rest; infinite for none."""
    link, search = chain.links[i], chain.totals.search
    link.next_event = inf
    since = common_start(chain, i)
    if since >= width or chain.bodies[i].mass + chain.bodies[i + 1].mass == 0.0:
        return
    if link.rests > 0.0:
        for n in range(terms - 2):
            search.series[SIGNAL, n] = -link.force[n]
        root = first_rise(search, terms - 2, 0.0, width - since)
    else:
        write_distance(chain, i, since, ground, terms)
        root = first_rise(search, terms, link.gap, width - since)
    if root >= 0.0:
        link.next_event = since + root


@kernel
def is_closed(chain, i, t, ground, terms):
    """True where an interface rests at ``t``, or is closed but for rounding."""
    left, right, link = chain.bodies[i], chain.bodies[i + 1], chain.links[i]
    if link.rests > 0.0:
        return True
    if left.mass + right.mass == 0.0:
        return False
    u_left, u_right = displacement_of(left, terms, t - left.since), displacement_of(right, terms, t - right.since)
    # Of the largest displacements so far: those of the moment may be none at all.
    rounding = ROUNDING * (left.peak_displacement + right.peak_displacement + link.gap)
    return u_left - u_right - ground.later(t).ground_moves(i + 1)[0] >= link.gap - rounding


@kernel
def chain_at(chain, i, t, ground, terms):
    """(first, last) interface of those closed at ``t`` in a line with ``i``, up to rigid buildings."""
    bodies, end = chain.bodies, chain.table.shape[1] - 1
    first = last = i
    while first > 0 and bodies[first].mass > 0.0 and is_closed(chain, first - 1, t, ground, terms):
        first -= 1
    while last < end and bodies[last + 1].mass > 0.0 and is_closed(chain, last + 1, t, ground, terms):
        last += 1
    return first, last


@kernel
def first_event(chain):
    """The interface whose event comes first in the interval, the leftmost of several, or −1."""
    earliest, best = inf, -1
    for i in range(chain.table.shape[1]):
        if chain.links[i].next_event < earliest:
            earliest, best = chain.links[i].next_event, i
    return best
