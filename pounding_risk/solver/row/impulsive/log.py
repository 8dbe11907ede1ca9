"""What a run of single masses whose velocities jump writes down where a log is kept."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import COUNT, IMPULSE
from pounding_risk.solver.row.workspace import ACTING, BEGAN, CAME_AT, MOVED, NOTED, SO_FAR, STRONGEST, WHEN, WHOSE


@kernel
def write_line(chain, first, last, time, jumped):
    """A line of the log: these buildings now; with ``jumped`` contacts that begin and end at once are in it."""
    bodies, links, log, totals = chain.bodies, chain.links, chain.log, chain.totals
    line = int(totals.lines_written)
    totals.lines_written += 1.0
    if line >= log.shape[0]:
        return
    for place in range(log.shape[1]):
        log[line, place] = nan
    log[line, WHEN], log[line, WHOSE] = time, float(first)
    masses = (log.shape[1] - MOVED - NOTED * chain.table.shape[1]) // 2
    for b in range(first, last + 1):
        if bodies[b].mass > 0.0:
            log[line, MOVED + int(bodies[b].dof)] = bodies[b].u
            log[line, MOVED + masses + int(bodies[b].dof)] = bodies[b].v
    for k in range(first, last):
        link, place = links[k], MOVED + 2 * masses + NOTED * k
        log[line, place + ACTING], log[line, place + SO_FAR] = 0.0, link.counters[IMPULSE]
        if link.rests > 0.0 or (jumped and link.begun == time and link.counters[COUNT] > 0.0):
            log[line, place + ACTING] = link.acting if link.rests > 0.0 else 0.0
            log[line, place + BEGAN], log[line, place + CAME_AT] = link.begun, link.came_at
            log[line, place + STRONGEST] = max(link.strongest, link.acting) if link.rests > 0.0 else nan
