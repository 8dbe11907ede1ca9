"""A run of single masses whose velocities jump: from node to node, with the jumps between."""

from __future__ import annotations

from math import inf, nan

from pounding_risk._jit.compile import kernel, uncounted
from pounding_risk.solver.counters import (
    COMPLETE,
    COUNT,
    DEMAND,
    ENERGY_OPEN,
    FIRST_TOUCH,
    FIRST_YIELD,
    IMPULSE,
    NOT_FINITE,
    OPEN_FLOOR,
    OPEN_SHARE,
    PEAK_FORCE,
)
from pounding_risk.solver.row.impulsive.events import first_event, plan_event, raise_body_peaks, raise_link_extremes
from pounding_risk.solver.row.impulsive.jumps import end_rest, jump
from pounding_risk.solver.row.impulsive.motion import advance, group_of, write_groups
from pounding_risk.solver.row.impulsive.state import write_line


@kernel
def cross_interval(chain, window, rtol, terms):
    """All buildings over one node interval, with its jumps; returns False where the run ends."""
    moment, width, ground = window
    buildings = chain.table.shape[1] + 1
    for b in range(buildings):
        chain.bodies[b].since = 0.0
    write_groups(chain, 0, buildings - 1, 0.0, ground, terms)
    for i in range(buildings - 1):
        plan_event(chain, i, ground, width, terms)
    i = first_event(chain)
    while i >= 0:
        if not jump(chain, i, chain.links[i].next_event, window, rtol, terms):
            return False
        i = first_event(chain)
    for i in range(buildings - 1):
        raise_link_extremes(chain, i, width, ground, terms)
    for b in range(buildings):
        raise_body_peaks(chain, b, width, terms)
        advance(chain, b, width, terms)
    if chain.log.shape[0] > 0:
        b = 0
        while b < buildings:
            first, last = group_of(chain, b)
            if last > first:
                write_line(chain, first, last, moment + width, False)
            b = last if last > b and chain.bodies[last].mass == 0.0 else last + 1
    return True


@kernel
def march_jumps(chain, ground, step, terms, rtol, states):
    """One run from u and v of the bodies to the end of the record; those at nodes to ``states`` if it has rows."""
    states = uncounted(states)
    bodies, links, totals = chain.bodies, chain.links, chain.totals
    totals.watched_point = -1.0
    for i in range(chain.table.shape[1]):
        links[i].counters[FIRST_TOUCH] = links[i].counters[FIRST_YIELD] = nan
    nodes = ground.node_count() - 1
    for node in range(nodes):
        window = ground.node_time(step, node), ground.node_width(step, node), ground.from_node(step, node)
        if not cross_interval(chain, window, rtol, terms):
            break
        for b in range(chain.table.shape[1] + 1):
            if states.shape[0] > node + 1:
                states[node + 1, 0, b], states[node + 1, 1, b] = bodies[b].u, bodies[b].v
    end_jumps(chain, ground.node_time(step, nodes), rtol)


@kernel
def end_jumps(chain, time, rtol):
    """Close the contacts that outlast the record, and set the status where nothing has set it."""
    totals, size = chain.totals, 0.0
    for b in range(chain.table.shape[1] + 1):
        body = chain.bodies[b]
        size += abs(body.u) + abs(body.v) + body.peak_displacement + body.peak_acceleration
    for i in range(chain.table.shape[1]):
        link = chain.links[i]
        if link.rests > 0.0 and totals.status == COMPLETE:
            end_rest(link, time)
        size += abs(link.highest) + abs(link.lowest) + link.counters[IMPULSE]
        if link.counters[COUNT] > 0.0:
            # A jump has no finite force: the largest is that of a rest, if there has been one.
            link.counters[DEMAND] = nan
            link.counters[PEAK_FORCE] = link.counters[PEAK_FORCE] if link.has_rested > 0.0 else nan
    if totals.status != COMPLETE:
        return
    if not size < inf:
        totals.status = float(NOT_FINITE)
    elif not abs(totals.residual) <= (OPEN_SHARE * rtol + OPEN_FLOOR) * totals.energy:
        totals.status = float(ENERGY_OPEN)
