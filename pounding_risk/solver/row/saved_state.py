"""What an interval begins with: saved, so that it can be repeated with other buildings in a group."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk._jit.memory import copy_record
from pounding_risk.solver.row.link import is_link_of
from pounding_risk.solver.row.trace import drop_lines
from pounding_risk.solver.row.workspace import FIRST, SAVED, SOLVED, START, TANGENT, TIED


@kernel
def save_or_restore(row, run, b, restore):
    """Save, or with ``restore`` restore, what an interval changes of building ``b`` and of its contact points."""
    for line in range(SAVED):
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            copy_number(run.dofs, TANGENT + line, i, run.saved, line, i, restore)
    for column in range(run.storeys.shape[1]):
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            copy_number(run.storeys, i, column, run.saved_storeys, i, column, restore)
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, b, b):
            for column in range(run.links.shape[1]):
                copy_number(run.links, k, column, run.saved_links, k, column, restore)
    buildings = row.frame.shape[1] - 1
    levels = run.timed.shape[2]
    for k in range(row.frame[START, max(b - 1, 0)], row.frame[START, min(b + 1, buildings - 1)]):
        if restore:
            # What a group on the other side has added to the distance stays.
            sides = run.contacts[k].side_extremes
            extremes = sides[0], sides[1], sides[2], sides[3]
            copy_record(run.saved_contacts, k, run.contacts, k)
            for column in range(4):
                run.contacts[k].side_extremes[column] = extremes[column]
        else:
            copy_record(run.contacts, k, run.saved_contacts, k)
        for level in range(levels):
            copy_number(run.timed[1], k, level, run.saved_laws, k, 2 * level, restore)
            copy_number(run.timed[2], k, level, run.saved_laws, k, 2 * level + 1, restore)
        # A law's numbers, and what its contact remembers.
        for column in range(run.laws.shape[1]):
            copy_number(run.laws, k, column, run.saved_laws, k, 2 * levels + column, restore)


@small
def copy_number(array, i, j, saved, row, column, restore):
    """Copy one number of an array to where it is saved, or with ``restore`` from there."""
    if restore:
        array[i, j] = saved[row, column]
    else:
        saved[row, column] = array[i, j]


@kernel
def restore_group(row, run, b):
    """Bring back the whole group that building ``b`` has been solved in."""
    first = last = b
    while first > 0 and run.marks[TIED, first - 1] > 0.0:
        first -= 1
    while last < row.frame.shape[1] - 2 and run.marks[TIED, last] > 0.0:
        last += 1
    for member in range(first, last + 1):
        if run.marks[SOLVED, member] > 0.0:
            save_or_restore(row, run, member, True)
            run.marks[SOLVED, member] = 0.0
    if run.workspace.line_room > 0.0:
        drop_lines(row, run, first, last)
