"""What a run of a row writes down where a log is kept: its groups with contacts, step by step."""

from __future__ import annotations

from math import nan

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import IMPULSE
from pounding_risk.solver.row.flight import across
from pounding_risk.solver.row.stages import transmitted
from pounding_risk.solver.row.workspace import (
    ACTING,
    AT_TOUCH,
    BEGAN,
    BOOKED,
    CAME_AT,
    CLOSED,
    GAP,
    KEPT,
    MOVED,
    NOTED,
    NOW,
    PEAK,
    PLATEAU,
    ROOM,
    SINCE,
    SO_FAR,
    START,
    STRENGTH,
    STRONGEST,
    TOUCHED,
    WHEN,
    WHOLE,
    WHOSE,
    WRITTEN,
    YIELDED,
    line_width,
)


@small
def put(run, place, value):
    """One number into the log, which lies row by row below what is kept: an array of its own would cost every call."""
    dofs = run.kept.shape[1]
    run.kept[KEPT + place // dofs, place % dofs] = value


@kernel
def write_down(row, run, group, time):
    """One line: the group as it is in rows NOW at ``time`` [s], NaN for what is not of it.

    Lines that find no room are counted.
    """
    dofs = row.floors.shape[1]
    width = line_width(dofs, run.limits.shape[0])
    line = int(run.board[WHOLE, WRITTEN])
    run.board[WHOLE, WRITTEN] += 1.0
    if line >= run.board[WHOLE, ROOM]:
        return
    line *= width
    for place in range(line, line + width):
        put(run, place, nan)
    put(run, line + WHEN, time)
    put(run, line + WHOSE, float(group.first))
    for i in range(group.low, group.high):
        put(run, line + MOVED + i, run.desk[NOW, i])
        put(run, line + MOVED + dofs + i, run.desk[NOW + 1, i])
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        place = line + MOVED + 2 * dofs + NOTED * k
        put(run, place + ACTING, 0.0)
        put(run, place + SO_FAR, run.book[k, BOOKED + IMPULSE])
        if run.book[k, CLOSED] > 0.0:
            note_contact(row, run, k, place)


@kernel
def note_contact(row, run, k, place):
    """The columns of contact ``k``, which is closed."""
    book = run.book
    delta = max(across(row, k, run.desk, NOW) - book[k, GAP], 0.0)
    force = transmitted(run, k, delta, across(row, k, run.desk, NOW + 1))
    strongest = book[k, PLATEAU] if book[k, YIELDED] > 0.0 else min(book[k, PEAK], book[k, STRENGTH])
    put(run, place + ACTING, force)
    put(run, place + BEGAN, book[k, TOUCHED])
    put(run, place + CAME_AT, book[k, AT_TOUCH])
    put(run, place + STRONGEST, max(force, strongest))


@kernel
def take_back(row, run, first, last):
    """The lines of this interval whose group begins with one of these buildings are none: their time is NaN."""
    width = line_width(row.floors.shape[1], run.limits.shape[0])
    dofs = run.kept.shape[1]
    for line in range(int(run.board[WHOLE, SINCE]), int(min(run.board[WHOLE, WRITTEN], run.board[WHOLE, ROOM]))):
        place = line * width + WHOSE
        if first <= run.kept[KEPT + place // dofs, place % dofs] <= last:
            put(run, line * width + WHEN, nan)
