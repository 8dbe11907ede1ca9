"""One run: flights and contacts in turn, from rest to the end of the record."""

from __future__ import annotations

from math import inf, nan

from pounding_risk._jit.compile import by_verb, kernel, small, uncounted
from pounding_risk.solver.counters import (
    AT_END,
    COMPLETE,
    COUNT,
    ENERGY,
    ENERGY_OPEN,
    FINISHED,
    FIRST_TOUCH,
    FIRST_YIELD,
    IMPULSE,
    MAX_CONTACTS,
    NOT_FINITE,
    OPEN_FLOOR,
    OPEN_SHARE,
    RESIDUAL,
    SET,
    STATUS,
    TOO_MANY_CONTACTS,
    Log,
)
from pounding_risk.solver.pair.contact import integrate_contact
from pounding_risk.solver.pair.equations import Limits
from pounding_risk.solver.pair.flight import Free, fly
from pounding_risk.solver.pair.impulsive import impulsive_contact
from pounding_risk.solver.workspace import SIGNALS

# A touch begins a jump of the velocities under a law that has one, otherwise a contact of finite force.
begin_contact = by_verb("strike", 2, impulsive_contact, integrate_contact)


@small
def borrow_free(free):
    """The same free response, its arrays' references not counted: for a kernel whose caller holds them."""
    return Free(
        uncounted(free.ground),
        free.step,
        free.terms,
        uncounted(free.states),
        uncounted(free.high),
        uncounted(free.low),
        free.node_map,
        free.block_map,
        free.fastest,
        free.passage.uncounted(),
    )


@small
def borrow_log(log):
    """The same log, its arrays' references not counted: for a kernel whose caller holds them."""
    return Log(
        uncounted(log.contacts),
        uncounted(log.steps),
        uncounted(log.levels),
        uncounted(log.first),
        uncounted(log.reached),
        uncounted(log.used),
    )


@kernel
def march(pair, free, law, limits, rtol, workspace, log):
    """One run from rest to the end of the record; ``limits`` as `equations.Limits`.

    Leaves the largest and smallest signals and the counters in the workspace.
    """
    # The caller holds all arrays until this returns.
    free, log = borrow_free(free), borrow_log(log)
    workspace.high[:] = 0.0
    workspace.low[:] = 0.0
    workspace.counters[:] = 0.0
    workspace.counters[FIRST_TOUCH] = nan
    workspace.counters[FIRST_YIELD] = nan
    state = (0.0, 0.0, 0.0, 0.0)
    node, offset = 0, 0.0
    while True:
        # The gap is as wide as the indentations of the contacts before have left it.
        gap = limits.gap + workspace.counters[SET]
        node, offset, state = fly(pair, free, gap, (node, offset), state, workspace)
        if node < 0:
            break
        if workspace.counters[COUNT] >= MAX_CONTACTS:
            workspace.counters[STATUS] = TOO_MANY_CONTACTS
            break
        limits_now = Limits(gap, limits.yield_force, limits.restitution)
        finish, node, offset, state = begin_contact(
            pair, free, law, limits_now, rtol, (node, offset), state, workspace, log
        )
        if finish == AT_END:
            break
        if finish != FINISHED:
            workspace.counters[STATUS] = finish
            break
    total = workspace.counters[IMPULSE]
    # Whatever is not finite in the ground motion stays in the free response; a search only passes it over.
    for part in range(4):
        total += free.states[free.ground.size - 1, part]
    for signal in range(SIGNALS):
        total += workspace.high[signal] + workspace.low[signal]
    if not abs(total) < inf:
        workspace.counters[STATUS] = NOT_FINITE
    elif workspace.counters[STATUS] == COMPLETE:
        limit = (OPEN_SHARE * rtol + OPEN_FLOOR) * workspace.counters[ENERGY]
        if not abs(workspace.counters[RESIDUAL]) <= limit:
            workspace.counters[STATUS] = ENERGY_OPEN
