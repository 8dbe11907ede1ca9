"""All buildings of a row over one node interval: those on their own, and groups of those that touch.

A building next to a group looks on; should the group strike it, the interval is made again with it as a member.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.blocks import (
    BY_NODE,
    DISTANCES_SEARCHED,
    FLOORS_SEARCHED,
    bring_to_node,
    join_group,
    predict_interval,
)
from pounding_risk.solver.row.contact_points import stay_apart
from pounding_risk.solver.row.flight_by_map import touch_within, update_distances, update_peaks
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.group import FAILED, FLOWN, any_closed, solve_group
from pounding_risk.solver.row.saved_state import restore_group, save_or_restore
from pounding_risk.solver.row.workspace import FIRST, NEXT, NOW, VELOCITY


@kernel
def interval(row, run, free, marks, tied, grouped, solved, swings, step, node, terms, rtol):
    """The row over one node interval, rows NODE to rows NEXT; returns (whether the run goes on, whether a group was).

    ``tied`` (interfaces), ``grouped``, ``solved`` (buildings that need their group, and have it) and ``swings`` are
    this function's own.
    """
    buildings = row.frame.shape[1] - 1
    window = window_at(free.ground, step, node)
    any_grouped = False
    for i in range(buildings - 1):
        tied[i] = marks[DISTANCES_SEARCHED, i] > 0.0 and any_closed(row, run, i, i + 1)
    for b in range(buildings):
        grouped[b] = False
        if marks[BY_NODE, b] > 0.0:
            if (b > 0 and not tied[b - 1]) or (b < buildings - 1 and not tied[b]) or buildings == 1:
                grouped[b] = not predict_interval(row, run, free, marks, swings, step, b, node)
            else:
                bring_to_node(row, run, free, marks, step, b, node)
            any_grouped = any_grouped or grouped[b]
    for i in range(buildings - 1):
        if marks[DISTANCES_SEARCHED, i] > 0.0 and not (tied[i] or grouped[i] or grouped[i + 1]):
            tied[i] = touch_within(row, run, i, window, swings, terms)
        any_grouped = any_grouped or tied[i]
    if any_grouped:
        for i in range(buildings - 1):
            if tied[i]:
                grouped[i] = grouped[i + 1] = True
        for b in range(buildings):
            if grouped[b]:
                join_group(row, run, free, marks, swings, step, terms, b, node)
        if not solve_groups(row, run, free, marks, tied, grouped, solved, swings, step, node, terms, rtol):
            return False, True
    for b in range(buildings):
        if marks[FLOORS_SEARCHED, b] > 0.0 and not grouped[b]:
            update_peaks(row, run, b, window, swings, terms)
    for i in range(buildings - 1):
        if marks[DISTANCES_SEARCHED, i] > 0.0 and not (grouped[i] or grouped[i + 1]):
            update_distances(row, run, i, window, swings, terms)
    return True, any_grouped


@kernel
def solve_groups(row, run, free, marks, tied, grouped, solved, swings, step, node, terms, rtol):
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
        if grouped[b]:
            save_or_restore(row, run, b, False)
    b = 0
    while b < buildings:
        if solved[b] or not grouped[b]:
            b += 1
            continue
        first = last = b
        while last < buildings - 1 and tied[last]:
            last += 1
        watch = (
            first - 1 if first > 0 and not grouped[first - 1] else first,
            last + 1 if last < buildings - 1 and not grouped[last + 1] else last,
        )
        residual_before = run.workspace.residual
        outcome, edge = solve_group(row, run, (first, last), watch, window, terms, rtol)
        if outcome == FAILED:
            return False
        for member in range(first, last + 1):
            solved[member] = True
        if outcome == FLOWN:
            for i in range(row.frame[FIRST, first], row.frame[FIRST, last + 1]):
                run.dofs[NEXT, i] = run.dofs[NOW, i]
                run.dofs[NEXT + VELOCITY, i] = run.dofs[NOW + VELOCITY, i]
            b = last + 1
            if first > 0 and grouped[first - 1] and not stay_apart(row, run, first - 1):
                edge = first - 1
            elif b < buildings and solved[b] and not stay_apart(row, run, last):
                edge = last
            else:
                continue
        # A building that has only looked on is struck, or groups may meet: both sides are made again, as one.
        run.workspace.residual = residual_before
        restore_group(row, run, first, tied, solved)
        for struck in (edge, edge + 1):
            if not grouped[struck]:
                # Those on its far side have looked on at its free motion, and have raised extremes by it.
                for neighbour in (struck - 1, struck + 1):
                    if 0 <= neighbour < buildings and solved[neighbour]:
                        restore_group(row, run, neighbour, tied, solved)
                join_group(row, run, free, marks, swings, step, terms, struck, node)
                save_or_restore(row, run, struck, False)
                grouped[struck] = True
            elif solved[struck]:
                restore_group(row, run, struck, tied, solved)
        tied[edge] = True
        b = 0
    return True
