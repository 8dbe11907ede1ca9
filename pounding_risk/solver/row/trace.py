"""What a run of a row writes down where a log is kept: its groups with contacts, step by step."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import IMPULSE
from pounding_risk.solver.row.contact_points import across
from pounding_risk.solver.row.equations import transmitted
from pounding_risk.solver.row.workspace import (
    ACTING,
    BEGAN,
    CAME_AT,
    MOVED,
    NOTED,
    NOW,
    SAVED,
    SO_FAR,
    START,
    STRONGEST,
    VELOCITY,
    WHEN,
    WHOSE,
    line_width,
)


@small
def write_number(run, place, value):
    """Write one number to the log, which follows the saved rows: an array of its own would cost every call."""
    dofs = run.saved.shape[1]
    run.saved[SAVED + place // dofs, place % dofs] = value


@kernel
def write_line(row, run, group, time):
    """One line: the group as it is in rows NOW at ``time`` [s], NaN for what is not of it.

    Lines that find no room are counted.
    """
    dofs = row.floors.shape[1]
    width = line_width(dofs, run.laws.shape[0])
    line = int(run.workspace.lines_written)
    run.workspace.lines_written += 1.0
    if line >= run.workspace.line_room:
        return
    line *= width
    for place in range(line, line + width):
        write_number(run, place, nan)
    write_number(run, line + WHEN, time)
    write_number(run, line + WHOSE, float(group.first))
    for i in range(group.low, group.high):
        write_number(run, line + MOVED + i, run.dofs[NOW, i])
        write_number(run, line + MOVED + dofs + i, run.dofs[NOW + VELOCITY, i])
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        place = line + MOVED + 2 * dofs + NOTED * k
        write_number(run, place + ACTING, 0.0)
        write_number(run, place + SO_FAR, run.contacts[k].counters[IMPULSE])
        if run.contacts[k].closed > 0.0:
            write_contact(row, run, k, place)


@kernel
def write_contact(row, run, k, place):
    """The columns of contact ``k``, which is closed."""
    contact = run.contacts[k]
    delta = max(across(row, k, run.dofs, NOW) - contact.gap, 0.0)
    force = transmitted(run, k, delta, across(row, k, run.dofs, NOW + VELOCITY))
    strongest = contact.plateau_force if contact.yields > 0.0 else min(contact.peak_force, contact.strength)
    write_number(run, place + ACTING, force)
    write_number(run, place + BEGAN, contact.touch_time)
    write_number(run, place + CAME_AT, contact.approach_speed)
    write_number(run, place + STRONGEST, max(force, strongest))


@kernel
def drop_lines(row, run, first, last):
    """The lines of this interval whose group begins with one of these buildings are none: their time is NaN."""
    width = line_width(row.floors.shape[1], run.laws.shape[0])
    dofs = run.saved.shape[1]
    for line in range(int(run.workspace.first_line), int(min(run.workspace.lines_written, run.workspace.line_room))):
        place = line * width + WHOSE
        if first <= run.saved[SAVED + place // dofs, place % dofs] <= last:
            write_number(run, line * width + WHEN, nan)
