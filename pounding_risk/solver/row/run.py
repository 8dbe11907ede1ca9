"""One run of a row: from node to node, each building on its own or with the neighbours that it touches.

Buildings that neither touch nor are about to fly on their own, exactly; blocks of nodes, and what lies between two
nodes, are searched only where a bound leaves room for a touch or a new peak (`blocks`). Neighbours of which some touch
form a group that is integrated together (`group`). A building next to a group looks on; should the group strike it, the
interval is made again with it as a member. What a row costs follows its contacts and its buildings, not their product.
"""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk._jit.compile import borrowed, kernel, small
from pounding_risk._jit.memory import zeros
from pounding_risk._jit.records import copy_record
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
    FREE_NODE,
    MARKS,
    MOVED,
    OPEN,
    SEARCHED,
    STATE_NODE,
    WALKED,
    begin_alone,
    bring,
    copy_point_peaks,
    end_blocks,
    has_events,
    has_new_peaks,
    join,
    part_from_free,
    predict,
)
from pounding_risk.solver.row.contact import lift_off
from pounding_risk.solver.row.flight import stay_apart
from pounding_risk.solver.row.free import meets, update_distances, update_peaks
from pounding_risk.solver.row.free_motion import begin_motion
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.group import FAILED, FLOWN, any_closed, solve_group
from pounding_risk.solver.row.trace import drop_lines
from pounding_risk.solver.row.workspace import (
    BENDS,
    DRIFT,
    FIRST,
    NEXT,
    NODE,
    NOW,
    SAVED,
    START,
    TANGENT,
    VELOCITY,
)

WATCHED = 7  # status of a run that a touch at a watched point has ended


@kernel
def save_or_restore(row, run, b, back):
    """Save, or with ``back`` restore, what an interval changes of building ``b`` and of its contact points."""
    for line in range(SAVED):
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            copy_number(run.dofs, TANGENT + line, i, run.saved, line, i, back)
    buildings = row.frame.shape[1] - 1
    levels = run.timed.shape[2]
    for k in range(row.frame[START, max(b - 1, 0)], row.frame[START, min(b + 1, buildings - 1)]):
        if back:
            # What a group on the other side has added to the distance stays.
            sides = run.contacts[k].side_extremes
            others = sides[0], sides[1], sides[2], sides[3]
            copy_record(run.saved_contacts, k, run.contacts, k)
            for column in range(4):
                run.contacts[k].side_extremes[column] = others[column]
        else:
            copy_record(run.contacts, k, run.saved_contacts, k)
        for level in range(levels):
            copy_number(run.timed[1], k, level, run.saved_laws, k, 2 * level, back)
            copy_number(run.timed[2], k, level, run.saved_laws, k, 2 * level + 1, back)
        # A law's numbers, and what its contact remembers.
        for column in range(run.laws.shape[1]):
            copy_number(run.laws, k, column, run.saved_laws, k, 2 * levels + column, back)


@small
def copy_number(array, i, j, saved, row, column, back):
    """Copy one number of an array to where it is saved, or with ``back`` from there."""
    if back:
        array[i, j] = saved[row, column]
    else:
        saved[row, column] = array[i, j]


@kernel
def restore_group(row, run, b, tied, solved):
    """Bring back the whole group that building ``b`` has been solved in."""
    first = last = b
    while first > 0 and tied[first - 1]:
        first -= 1
    while last < tied.size - 1 and tied[last]:
        last += 1
    for member in range(first, last + 1):
        if solved[member]:
            save_or_restore(row, run, member, True)
            solved[member] = False
    if run.workspace.line_room > 0.0:
        drop_lines(row, run, first, last)


@kernel
def begin_block(row, run, free, marks, step, node, walked):
    """Find out what has to be searched in the block that begins at ``node``; returns False where nothing has.

    With ``walked`` every building is brought from node to node.
    """
    buildings = row.frame.shape[1] - 1
    block = node // free.block
    some = walked
    for b in range(buildings):
        if row.frame[BENDS, b]:
            marks[WALKED, b] = marks[SEARCHED, b] = 1.0
        else:
            marks[SEARCHED, b] = 0.0
            if marks[MOVED, b] > 0.0:
                begin_alone(row, run, free, marks, step, b, node)
                marks[SEARCHED, b] = 1.0 if has_new_peaks(row, run, free, marks, b, block) else 0.0
            marks[WALKED, b] = 1.0 if marks[SEARCHED, b] > 0.0 or walked else 0.0
        some = some or marks[WALKED, b] > 0.0
    for i in range(buildings - 1):
        bends = row.frame[BENDS, i] or row.frame[BENDS, i + 1]
        marks[OPEN, i] = 0.0
        if bends or any_closed(row, run, i, i + 1) or has_events(row, run, free, marks, i, block):
            marks[OPEN, i] = marks[WALKED, i] = marks[WALKED, i + 1] = 1.0
            some = True
            if marks[MOVED, i] + marks[MOVED, i + 1] == 0.0:
                copy_point_peaks(row, run, free, i, block)
    return some


@kernel
def interval(row, run, free, marks, tied, busy, solved, swings, step, node, terms, rtol):
    """The row over one node interval, rows NODE to rows NEXT; returns (whether the run goes on, whether a group was).

    ``tied`` (interfaces), ``busy``, ``solved`` (buildings that need their group, and have it) and ``swings`` are this
    function's own.
    """
    buildings = row.frame.shape[1] - 1
    window = window_at(free.ground, step, node)
    some = False
    for i in range(buildings - 1):
        tied[i] = marks[OPEN, i] > 0.0 and any_closed(row, run, i, i + 1)
    for b in range(buildings):
        busy[b] = False
        if marks[WALKED, b] > 0.0:
            if (b > 0 and not tied[b - 1]) or (b < buildings - 1 and not tied[b]) or buildings == 1:
                busy[b] = not predict(row, run, free, marks, swings, step, b, node)
            else:
                bring(row, run, free, marks, step, b, node)
            some = some or busy[b]
    for i in range(buildings - 1):
        if marks[OPEN, i] > 0.0 and not (tied[i] or busy[i] or busy[i + 1]):
            tied[i] = meets(row, run, i, window, swings, terms)
        some = some or tied[i]
    if some:
        for i in range(buildings - 1):
            if tied[i]:
                busy[i] = busy[i + 1] = True
        for b in range(buildings):
            if busy[b]:
                join(row, run, free, marks, swings, step, terms, b, node)
        if not solve_groups(row, run, free, marks, tied, busy, solved, swings, step, node, terms, rtol):
            return False, True
    for b in range(buildings):
        if marks[SEARCHED, b] > 0.0 and not busy[b]:
            update_peaks(row, run, b, window, swings, terms)
    for i in range(buildings - 1):
        if marks[OPEN, i] > 0.0 and not (busy[i] or busy[i + 1]):
            update_distances(row, run, i, window, swings, terms)
    return True, some


@kernel
def solve_groups(row, run, free, marks, tied, busy, solved, swings, step, node, terms, rtol):
    """Every group of busy buildings over the interval; returns False where the run has ended.

    A building that looks on at a group and is struck joins it, and the group is solved again. Groups side by side do
    not look on at each other: each keeps what it adds to the distance between them, and where the sum leaves room for a
    touch, or a new extreme, they are one group after all.
    """
    buildings = row.frame.shape[1] - 1
    window = window_at(free.ground, step, node)
    run.workspace.first_line = run.workspace.lines_written
    for b in range(buildings):
        solved[b] = False
        if busy[b]:
            save_or_restore(row, run, b, False)
    b = 0
    while b < buildings:
        if solved[b] or not busy[b]:
            b += 1
            continue
        first = last = b
        while last < buildings - 1 and tied[last]:
            last += 1
        watch = (
            first - 1 if first > 0 and not busy[first - 1] else first,
            last + 1 if last < buildings - 1 and not busy[last + 1] else last,
        )
        before = run.workspace.residual
        how, edge = solve_group(row, run, (first, last), watch, window, terms, rtol)
        if how == FAILED:
            return False
        for member in range(first, last + 1):
            solved[member] = True
        if how == FLOWN:
            for i in range(row.frame[FIRST, first], row.frame[FIRST, last + 1]):
                run.dofs[NEXT, i] = run.dofs[NOW, i]
                run.dofs[NEXT + VELOCITY, i] = run.dofs[NOW + VELOCITY, i]
            b = last + 1
            if first > 0 and busy[first - 1] and not stay_apart(row, run, first - 1):
                edge = first - 1
            elif b < buildings and solved[b] and not stay_apart(row, run, last):
                edge = last
            else:
                continue
        # A building that has only looked on is struck, or groups may meet: both sides are made again, as one.
        run.workspace.residual = before
        restore_group(row, run, first, tied, solved)
        for other in (edge, edge + 1):
            if not busy[other]:
                # Those on its far side have looked on at its free motion, and have raised extremes by it.
                for far in (other - 1, other + 1):
                    if 0 <= far < buildings and solved[far]:
                        restore_group(row, run, far, tied, solved)
                join(row, run, free, marks, swings, step, terms, other, node)
                save_or_restore(row, run, other, False)
                busy[other] = True
            elif solved[other]:
                restore_group(row, run, other, tied, solved)
        tied[edge] = True
        b = 0
    return True


@kernel
def struck_point(run):
    """A watched contact point that is closed, or −1."""
    for k in range(run.laws.shape[0]):
        if run.contacts[k].watched > 0.0 and (run.contacts[k].closed > 0.0 or run.contacts[k].counters[COUNT] > 0.0):
            return k
    return -1


@kernel
def next_node(row, run, free, marks, busy, step, node, states):
    """Rows NEXT become rows NODE, now of ``node``; ``states`` (nodes, 2, D) takes them where it has rows."""
    for b in range(row.frame.shape[1] - 1):
        if marks[WALKED, b] == 0.0:
            continue
        if busy[b] and not row.frame[BENDS, b]:
            part_from_free(row, run, free, marks, step, b, node)
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                run.dofs[NODE + line, i] = run.dofs[NEXT + line, i]
                if states.shape[0] > node:
                    states[node, line, i] = run.dofs[NODE + line, i]
        marks[STATE_NODE, b] = node


@kernel
def march(row, run, free, step, terms, rtol, states):
    """One run from the first of ``free.states`` to the end of the record; everything is left in ``run``.

    u and v at the nodes after the first go to ``states`` where it has rows.
    """
    states = borrowed(states)
    begin_motion(row, run, free, step)
    buildings = row.frame.shape[1] - 1
    tied, busy = zeros((buildings,), np.bool_), zeros((buildings,), np.bool_)
    solved, swings = zeros((buildings,), np.bool_), zeros((buildings,), np.float64)
    marks = zeros((MARKS, buildings), np.float64)
    for b in range(buildings):
        marks[MOVED, b] = 1.0 if row.frame[BENDS, b] else 0.0
        marks[FREE_NODE, b] = -1.0
    node, nodes = 0, free.ground.node_count() - 1
    while node < nodes:
        if node % free.block == 0 and not begin_block(row, run, free, marks, step, node, states.shape[0] > 0):
            node = min(node + free.block, nodes)
            continue
        goes_on, grouped = interval(row, run, free, marks, tied, busy, solved, swings, step, node, terms, rtol)
        if not goes_on:
            break
        node += 1
        next_node(row, run, free, marks, busy, step, node, states)
        point = struck_point(run) if grouped else -1
        if point >= 0:
            run.workspace.status, run.workspace.watched_point = float(WATCHED), float(point)
            break
    if run.workspace.status == COMPLETE:
        end_blocks(row, run, free, marks, step, nodes)
    end_run(row, run, free.ground.node_time(step, nodes), rtol)


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
