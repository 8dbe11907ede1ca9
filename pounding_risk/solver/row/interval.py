"""All buildings of a row over one node interval: those on their own, and groups of those that touch.

A building next to a group looks on; should the group strike it, the interval is repeated with it as a member.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.blocks import bring_to_node, join_group, predict_interval
from pounding_risk.solver.row.contact_points import stay_apart
from pounding_risk.solver.row.flight_by_map import touch_within, update_distances, update_peaks
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.group import FAILED, FLOWN, any_closed, solve_group
from pounding_risk.solver.row.saved_state import restore_group, save_or_restore
from pounding_risk.solver.row.workspace import (
    BY_NODE,
    DISTANCES_SEARCHED,
    FIRST,
    FLOORS_SEARCHED,
    GROUPED,
    NEXT,
    NOW,
    SOLVED,
    TIED,
    VELOCITY,
)


@kernel
def interval(row, run, free, node, rtol):
    """The row over the interval after ``node``, rows NODE to rows NEXT, with its peaks and contacts.

    Leaves in the marks which interfaces tie buildings to groups (TIED), and which buildings are in one (GROUPED).
    Returns (whether the run goes on, whether there was a group).
    """
    buildings, marks = row.frame.shape[1] - 1, run.marks
    window = window_at(free.ground, free.step, node)
    any_grouped = False
    for i in range(buildings - 1):
        is_tied = marks[DISTANCES_SEARCHED, i] > 0.0 and any_closed(row, run, i, i + 1)
        marks[TIED, i] = 1.0 if is_tied else 0.0
    for b in range(buildings):
        marks[GROUPED, b] = 0.0
        if marks[BY_NODE, b] > 0.0:
            is_left_free, is_right_free = (
                b > 0 and marks[TIED, b - 1] == 0.0,
                b < buildings - 1 and marks[TIED, b] == 0.0,
            )
            if is_left_free or is_right_free or buildings == 1:
                marks[GROUPED, b] = 0.0 if predict_interval(row, run, free, b, node) else 1.0
            else:
                bring_to_node(row, run, free, b, node)
            any_grouped = any_grouped or marks[GROUPED, b] > 0.0
    for i in range(buildings - 1):
        if marks[DISTANCES_SEARCHED, i] > 0.0 and marks[TIED, i] + marks[GROUPED, i] + marks[GROUPED, i + 1] == 0.0:
            marks[TIED, i] = 1.0 if touch_within(row, run, i, window, free.terms) else 0.0
        any_grouped = any_grouped or marks[TIED, i] > 0.0
    if any_grouped:
        for i in range(buildings - 1):
            if marks[TIED, i] > 0.0:
                marks[GROUPED, i] = marks[GROUPED, i + 1] = 1.0
        for b in range(buildings):
            if marks[GROUPED, b] > 0.0:
                join_group(row, run, free, b, node)
        if not solve_groups(row, run, free, node, rtol):
            return False, True
    for b in range(buildings):
        if marks[FLOORS_SEARCHED, b] > 0.0 and marks[GROUPED, b] == 0.0:
            update_peaks(row, run, b, window, free.terms)
    for i in range(buildings - 1):
        if marks[DISTANCES_SEARCHED, i] > 0.0 and marks[GROUPED, i] + marks[GROUPED, i + 1] == 0.0:
            update_distances(row, run, i, window, free.terms)
    return True, any_grouped


@kernel
def solve_groups(row, run, free, node, rtol):
    """Every group of the buildings marked GROUPED over the interval; returns False where the run has ended.

    A building that looks on at a group and is struck joins it, and the group is solved again. Groups side by side do
    not look on at each other: each keeps what it adds to the distance between them, and where the sum leaves room for a
    touch, or a new extreme, they are one group after all.
    """
    buildings, marks = row.frame.shape[1] - 1, run.marks
    window = window_at(free.ground, free.step, node)
    run.workspace.first_line = run.workspace.lines_written
    for b in range(buildings):
        marks[SOLVED, b] = 0.0
        if marks[GROUPED, b] > 0.0:
            save_or_restore(row, run, b, False)
    b = 0
    while b < buildings:
        if marks[SOLVED, b] > 0.0 or marks[GROUPED, b] == 0.0:
            b += 1
            continue
        first = last = b
        while last < buildings - 1 and marks[TIED, last] > 0.0:
            last += 1
        watch = (
            first - 1 if first > 0 and marks[GROUPED, first - 1] == 0.0 else first,
            last + 1 if last < buildings - 1 and marks[GROUPED, last + 1] == 0.0 else last,
        )
        residual_before = run.workspace.residual
        outcome, edge = solve_group(row, run, (first, last), watch, window, free.terms, rtol)
        if outcome == FAILED:
            return False
        for member in range(first, last + 1):
            marks[SOLVED, member] = 1.0
        if outcome == FLOWN:
            for i in range(row.frame[FIRST, first], row.frame[FIRST, last + 1]):
                run.dofs[NEXT, i] = run.dofs[NOW, i]
                run.dofs[NEXT + VELOCITY, i] = run.dofs[NOW + VELOCITY, i]
            b = last + 1
            if first > 0 and marks[GROUPED, first - 1] > 0.0 and not stay_apart(row, run, first - 1):
                edge = first - 1
            elif b < buildings and marks[SOLVED, b] > 0.0 and not stay_apart(row, run, last):
                edge = last
            else:
                continue
        # A building that has only looked on is struck, or groups may meet: both sides are repeated, as one.
        run.workspace.residual = residual_before
        restore_group(row, run, first)
        tie(row, run, free, edge, node)
        b = 0
    return True


@kernel
def tie(row, run, free, edge, node):
    """Tie both buildings at interface ``edge`` to one group, with what they have been solved in brought back."""
    buildings, marks = row.frame.shape[1] - 1, run.marks
    for struck in (edge, edge + 1):
        if marks[GROUPED, struck] == 0.0:
            # Those on its far side have looked on at its free motion, and have raised extremes by it.
            for neighbour in (struck - 1, struck + 1):
                if 0 <= neighbour < buildings and marks[SOLVED, neighbour] > 0.0:
                    restore_group(row, run, neighbour)
            join_group(row, run, free, struck, node)
            save_or_restore(row, run, struck, False)
            marks[GROUPED, struck] = 1.0
        elif marks[SOLVED, struck] > 0.0:
            restore_group(row, run, struck)
    marks[TIED, edge] = 1.0
