"""One run of a row: from node to node, each building on its own or with the neighbours that it touches.

Buildings that neither touch nor are about to fly on their own, exactly; blocks of nodes, and what lies between two
nodes, are searched only where a bound leaves room for a touch or a new peak (`blocks`). Neighbours of which some touch
form a group that is integrated together (`interval`, `group`). What a row costs follows its contacts and its buildings,
not their product.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, uncounted
from pounding_risk.solver.counters import (
    COMPLETE,
    COUNT,
    ENERGY_OPEN,
    FIRST_TOUCH,
    FIRST_YIELD,
    NOT_FINITE,
    OPEN_FLOOR,
    OPEN_SHARE,
    TALLIED,
)
from pounding_risk.solver.row.blocks import (
    begin_block_vibration,
    copy_point_peaks,
    end_blocks,
    has_events,
    has_new_peaks,
    separate_vibration,
)
from pounding_risk.solver.row.contact import lift_off
from pounding_risk.solver.row.group import any_closed
from pounding_risk.solver.row.initial_state import begin_motion
from pounding_risk.solver.row.interval import interval
from pounding_risk.solver.row.workspace import (
    BY_NODE,
    CAN_YIELD,
    DISTANCES_SEARCHED,
    DRIFT,
    FIRST,
    FLOORS_SEARCHED,
    FREE_NODE,
    GROUPED,
    MOVED,
    NEXT,
    NODE,
    STATE_NODE,
    VELOCITY,
)

WATCHED = 7  # status of a run that a touch at a watched point has ended


@kernel
def begin_block(row, run, free, node, walked):
    """Find out what has to be searched in the block that begins at ``node``; returns False where nothing has.

    With ``walked`` every building is brought from node to node.
    """
    buildings = row.frame.shape[1] - 1
    block = node // free.block
    any_walked = walked
    for b in range(buildings):
        if row.frame[CAN_YIELD, b]:
            run.marks[BY_NODE, b] = run.marks[FLOORS_SEARCHED, b] = 1.0
        else:
            run.marks[FLOORS_SEARCHED, b] = 0.0
            if run.marks[MOVED, b] > 0.0:
                begin_block_vibration(row, run, free, b, node)
                run.marks[FLOORS_SEARCHED, b] = 1.0 if has_new_peaks(row, run, free, b, block) else 0.0
            run.marks[BY_NODE, b] = 1.0 if run.marks[FLOORS_SEARCHED, b] > 0.0 or walked else 0.0
        any_walked = any_walked or run.marks[BY_NODE, b] > 0.0
    for i in range(buildings - 1):
        bends = row.frame[CAN_YIELD, i] or row.frame[CAN_YIELD, i + 1]
        run.marks[DISTANCES_SEARCHED, i] = 0.0
        if bends or any_closed(row, run, i, i + 1) or has_events(row, run, free, i, block):
            run.marks[DISTANCES_SEARCHED, i] = run.marks[BY_NODE, i] = run.marks[BY_NODE, i + 1] = 1.0
            any_walked = True
            if run.marks[MOVED, i] + run.marks[MOVED, i + 1] == 0.0:
                copy_point_peaks(row, run, free, i, block)
    return any_walked


@kernel
def struck_point(run):
    """A watched contact point that is closed or has been, or −1."""
    for k in range(run.laws.shape[0]):
        if run.contacts[k].watched > 0.0 and (run.contacts[k].closed > 0.0 or run.contacts[k].counters[COUNT] > 0.0):
            return k
    return -1


@kernel
def next_node(row, run, free, node, states):
    """Rows NEXT become rows NODE, now of ``node``; ``states`` (nodes, 2, D) takes them where it has rows."""
    for b in range(row.frame.shape[1] - 1):
        if run.marks[BY_NODE, b] == 0.0:
            continue
        if run.marks[GROUPED, b] > 0.0 and not row.frame[CAN_YIELD, b]:
            separate_vibration(row, run, free, b, node)
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                run.dofs[NODE + line, i] = run.dofs[NEXT + line, i]
                if states.shape[0] > node:
                    states[node, line, i] = run.dofs[NODE + line, i]
        run.marks[STATE_NODE, b] = node


@kernel
def march(row, run, free, rtol, states):
    """One run from the first of ``free.states`` to the end of the record; everything is left in ``run``.

    u and v at the nodes after the first go to ``states`` where it has rows.
    """
    states = uncounted(states)
    begin_motion(row, run, free)
    for b in range(row.frame.shape[1] - 1):
        run.marks[MOVED, b] = 1.0 if row.frame[CAN_YIELD, b] else 0.0
        run.marks[FREE_NODE, b] = -1.0
    node, nodes = 0, free.ground.node_count() - 1
    while node < nodes:
        if node % free.block == 0 and not begin_block(row, run, free, node, states.shape[0] > 0):
            node = min(node + free.block, nodes)
            continue
        goes_on, had_group = interval(row, run, free, node, rtol)
        if not goes_on:
            break
        node += 1
        next_node(row, run, free, node, states)
        point = struck_point(run) if had_group else -1
        if point >= 0:
            run.workspace.status, run.workspace.watched_point = float(WATCHED), float(point)
            break
    if run.workspace.status == COMPLETE:
        end_blocks(row, run, free, nodes)
    end_run(row, run, free.ground.node_time(free.step, nodes), rtol)


@kernel
def end_run(row, run, time, rtol):
    """Contacts that outlast the record are closed, and the status is set where nothing has set it."""
    total = 0.0
    for k in range(run.laws.shape[0]):
        if run.contacts[k].closed > 0.0 and run.workspace.status == COMPLETE:
            lift_off(row, run, k, time, NODE, run.contacts[k].work)
        for column in range(TALLIED):
            value = run.contacts[k].counters[column]
            if column != FIRST_TOUCH and column != FIRST_YIELD:
                total += abs(value)
        total += abs(run.contacts[k].highest) + abs(run.contacts[k].lowest)
    for i in range(row.floors.shape[1]):
        total += abs(run.dofs[NODE, i]) + abs(run.dofs[NODE + VELOCITY, i]) + run.dofs[DRIFT, i]
    if run.workspace.status != COMPLETE:
        return
    if not total < inf:
        run.workspace.status = float(NOT_FINITE)
    elif not abs(run.workspace.residual) <= (OPEN_SHARE * rtol + OPEN_FLOOR) * run.workspace.energy:
        run.workspace.status = float(ENERGY_OPEN)
