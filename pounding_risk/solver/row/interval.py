"""All buildings of a row over one node interval: those on their own, and groups of those that touch.

A building next to a group looks on; should the group strike it, the interval is made again with it as a member.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.blocks import OPEN, SEARCHED, WALKED, bring, join, predict
from pounding_risk.solver.row.contact_points import stay_apart
from pounding_risk.solver.row.flight_by_map import meets, update_distances, update_peaks
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.group import FAILED, FLOWN, any_closed, solve_group
from pounding_risk.solver.row.saved_state import restore_group, save_or_restore
from pounding_risk.solver.row.workspace import FIRST, NEXT, NOW, VELOCITY


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
