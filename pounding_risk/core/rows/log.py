"""What a run of a row writes down where a log is kept: its groups with contacts, step by step."""

from __future__ import annotations

from math import nan

from pounding_risk._jit import kernel
from pounding_risk.core.rows.flight import across
from pounding_risk.core.rows.layout import (
    ACTING,
    AT_TOUCH,
    BEGAN,
    BOOKED,
    CAME_AT,
    CLOSED,
    GAP,
    NOTED,
    NOW,
    PEAK,
    PLATEAU,
    SO_FAR,
    START,
    STRENGTH,
    STRONGEST,
    TOUCHED,
    WHOLE,
    WRITTEN,
    YIELDED,
)
from pounding_risk.core.rows.stage import transmitted
from pounding_risk.core.tally import IMPULSE


@kernel
def write_down(row, run, group, time):
    """One line: the group as it is in rows NOW at ``time`` [s], NaN for what is not of it.

    Lines are counted beside the status of the run, so that an interval made again takes back those of its first try.
    Those that find no room are counted too.
    """
    log, dofs = run.log, row.floors.shape[1]
    line = int(run.board[WHOLE, WRITTEN])
    run.board[WHOLE, WRITTEN] += 1.0
    if line >= log.shape[0]:
        return
    for place in range(log.shape[1]):
        log[line, place] = nan
    log[line, 0] = time
    for i in range(group.low, group.high):
        log[line, 1 + i] = run.desk[NOW, i]
        log[line, 1 + dofs + i] = run.desk[NOW + 1, i]
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        place = 1 + 2 * dofs + NOTED * k
        log[line, place + ACTING] = 0.0
        log[line, place + SO_FAR] = run.book[k, BOOKED + IMPULSE]
        if run.book[k, CLOSED] > 0.0:
            note_contact(row, run, k, line, place)


@kernel
def note_contact(row, run, k, line, place):
    """The columns of contact ``k``, which is closed."""
    book, log = run.book, run.log
    delta = max(across(row, k, run.desk, NOW) - book[k, GAP], 0.0)
    force = transmitted(run, k, delta, across(row, k, run.desk, NOW + 1))
    strongest = book[k, PLATEAU] if book[k, YIELDED] > 0.0 else min(book[k, PEAK], book[k, STRENGTH])
    log[line, place + ACTING] = force
    log[line, place + BEGAN] = book[k, TOUCHED]
    log[line, place + CAME_AT] = book[k, AT_TOUCH]
    log[line, place + STRONGEST] = max(force, strongest)
