"""What a run of a row writes down where a log is kept: its groups with contacts, step by step."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import IMPULSE
from pounding_risk.solver.row.contact_points import across
from pounding_risk.solver.row.equations import transmitted
from pounding_risk.solver.row.workspace import (
    LINE_BUILDING,
    LINE_POINT_COLUMNS,
    LINE_STATES,
    LINE_TIME,
    NOW,
    POINT_APPROACH_SPEED,
    POINT_FORCE,
    POINT_IMPULSE,
    POINT_PEAK_FORCE,
    POINT_TOUCH_TIME,
    SAVED,
    START,
    VELOCITY,
    line_width,
)


@small
def write_number(run, position, value):
    """Write one number to the log, which follows the saved rows: an array of its own would cost every call."""
    dofs = run.saved.shape[1]
    run.saved[SAVED + position // dofs, position % dofs] = value


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
    for position in range(line, line + width):
        write_number(run, position, nan)
    write_number(run, line + LINE_TIME, time)
    write_number(run, line + LINE_BUILDING, float(group.first))
    for i in range(group.low, group.high):
        write_number(run, line + LINE_STATES + i, run.dofs[NOW, i])
        write_number(run, line + LINE_STATES + dofs + i, run.dofs[NOW + VELOCITY, i])
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        position = line + LINE_STATES + 2 * dofs + LINE_POINT_COLUMNS * k
        write_number(run, position + POINT_FORCE, 0.0)
        write_number(run, position + POINT_IMPULSE, run.contacts[k].counters[IMPULSE])
        if run.contacts[k].closed > 0.0:
            write_contact(row, run, k, position)


@kernel
def write_contact(row, run, k, position):
    """Write the columns of contact ``k``, which is closed, at ``position`` of the log: force, touch, largest force."""
    contact = run.contacts[k]
    delta = max(across(row, k, run.dofs, NOW) - contact.gap, 0.0)
    force = transmitted(run, k, delta, across(row, k, run.dofs, NOW + VELOCITY))
    strongest = contact.plateau_force if contact.yields > 0.0 else min(contact.peak_force, contact.strength)
    write_number(run, position + POINT_FORCE, force)
    write_number(run, position + POINT_TOUCH_TIME, contact.touch_time)
    write_number(run, position + POINT_APPROACH_SPEED, contact.approach_speed)
    write_number(run, position + POINT_PEAK_FORCE, max(force, strongest))


@kernel
def drop_lines(row, run, first, last):
    """The lines of this interval whose group begins with one of these buildings are none: their time is NaN."""
    width = line_width(row.floors.shape[1], run.laws.shape[0])
    dofs = run.saved.shape[1]
    for line in range(int(run.workspace.first_line), int(min(run.workspace.lines_written, run.workspace.line_room))):
        position = line * width + LINE_BUILDING
        if first <= run.saved[SAVED + position // dofs, position % dofs] <= last:
            write_number(run, line * width + LINE_TIME, nan)
