"""What a run of single masses whose velocities jump writes down where a log is kept."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import COUNT, IMPULSE
from pounding_risk.solver.row.workspace import (
    LINE_BUILDING,
    LINE_POINT_COLUMNS,
    LINE_STATES,
    LINE_TIME,
    POINT_APPROACH_SPEED,
    POINT_FORCE,
    POINT_IMPULSE,
    POINT_PEAK_FORCE,
    POINT_TOUCH_TIME,
)


@kernel
def write_line(chain, first, last, time, jumped):
    """A line of the log: these buildings now; with ``jumped`` contacts that begin and end at once are in it."""
    bodies, links, log, totals = chain.bodies, chain.links, chain.log, chain.totals
    line = int(totals.lines_written)
    totals.lines_written += 1.0
    if line >= log.shape[0]:
        return
    for column in range(log.shape[1]):
        log[line, column] = nan
    log[line, LINE_TIME], log[line, LINE_BUILDING] = time, float(first)
    masses = (log.shape[1] - LINE_STATES - LINE_POINT_COLUMNS * chain.table.shape[1]) // 2
    for b in range(first, last + 1):
        if bodies[b].mass > 0.0:
            log[line, LINE_STATES + int(bodies[b].dof)] = bodies[b].u
            log[line, LINE_STATES + masses + int(bodies[b].dof)] = bodies[b].v
    for k in range(first, last):
        link, column = links[k], LINE_STATES + 2 * masses + LINE_POINT_COLUMNS * k
        log[line, column + POINT_FORCE], log[line, column + POINT_IMPULSE] = 0.0, link.counters[IMPULSE]
        if link.rests > 0.0 or (jumped and link.touch_time == time and link.counters[COUNT] > 0.0):
            log[line, column + POINT_FORCE] = link.acting_force if link.rests > 0.0 else 0.0
            log[line, column + POINT_TOUCH_TIME], log[line, column + POINT_APPROACH_SPEED] = (
                link.touch_time,
                link.approach_speed,
            )
            log[line, column + POINT_PEAK_FORCE] = max(link.peak_force, link.acting_force) if link.rests > 0.0 else nan
