"""Arrays of a run of single masses whose velocities jump, and what it writes down where a log is kept."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel
from pounding_risk._jit.memory import record_type
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import COUNT, IMPULSE, TALLIED
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
from pounding_risk.solver.workspace import MAX_TERMS, Search

Body = record_type(
    mass=float,  # kg, 0 of a rigid building
    inverse=float,  # 1/kg
    omega2=float,  # 1/s²
    two_zeta_omega=float,  # 1/s
    dof=float,  # number of the mass among those of the row
    has_been_struck=float,  # above zero once a contact has changed its motion
    since=float,  # start of its series, after the node [s]
    u=float,  # m, then
    v=float,  # m/s, then
    pull=float,  # a_g under it, then [m/s²]
    rise=float,  # m/s³
    velocity_after=float,  # velocity after the jump that is being found [m/s]
    series=(MAX_TERMS,),
    peak_displacement=float,  # m
    peak_acceleration=float,  # absolute [m/s²]
)
Link = record_type(
    gap=float,  # m
    rule=(len(Restitution._fields),),
    fastest=float,  # peak closing or parting speed of the row without contact [m/s]
    watched=float,  # above zero where a touch ends the run
    rests=float,  # above zero while both neighbours move as one
    next_event=float,  # touch, or end of a rest, after the node [s]
    is_event=float,  # above zero where the jump that is being found is that event
    closing=float,  # speed before it [m/s]
    target=float,  # e times the closing speed [m/s]
    slow=float,  # above zero where it is not to rebound
    impulse=float,  # impulse [N s]
    presses=float,  # above zero where there is a force after it
    touch_time=float,  # time of the present contact [s]
    approach_speed=float,  # its approach speed [m/s]
    peak_force=float,  # its largest force at rest [N]
    acting_force=float,  # force at rest, now [N]
    force=(MAX_TERMS,),  # series of that force [N]
    has_rested=float,
    counters=(TALLIED,),
    highest=float,  # u_left − u_right, with the ground's part [m]
    lowest=float,
)
Totals = record_type(
    search=Search,
    status=float,
    energy=float,  # largest at a jump [J]
    residual=float,  # what jumps leave unaccounted for [J]
    steps=float,  # segments of motion of buildings that rest on each other
    watched_point=float,
    lines_written=float,
)


class Chain(NamedTuple):
    """Arrays of one run; B buildings, L = B − 1 interfaces."""

    bodies: np.ndarray  # (B,) records of the type `Body`
    links: np.ndarray  # (L,) records of the type `Link`
    table: np.ndarray  # (TABLE_ROWS, L) as `complementarity` has it
    totals: np.record  # of the type `Totals`
    log: np.ndarray  # (lines, numbers) as `write_line` fills it


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
            log[line, column + POINT_TOUCH_TIME] = link.touch_time
            log[line, column + POINT_APPROACH_SPEED] = link.approach_speed
            log[line, column + POINT_PEAK_FORCE] = max(link.peak_force, link.acting_force) if link.rests > 0.0 else nan
