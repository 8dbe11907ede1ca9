"""What a run of a row writes down where a log is kept: its groups with contacts, step by step."""

from __future__ import annotations

from math import nan

from pounding_risk._jit import kernel, model_of
from pounding_risk.core.rows.flight import across
from pounding_risk.core.rows.layout import (
    ACTING,
    AT_TOUCH,
    BEGAN,
    BOOKED,
    CAME_AT,
    CLOSED,
    GAP,
    LAW,
    NOTED,
    NOW,
    PEAK,
    PLATEAU,
    ROOM,
    SO_FAR,
    START,
    STRENGTH,
    STRONGEST,
    TOUCHED,
    WHOLE,
    WRITTEN,
    YIELDED,
    line_width,
)
from pounding_risk.core.rows.stage import transmitted
from pounding_risk.core.tally import IMPULSE


@kernel
def write_down(row, run, law, group, time):
    """One line: the group as it is in rows NOW at ``time`` [s], NaN for what is not of it.

    Lines are counted beside the status of the run, so that an interval made again takes back those of its first try.
    Those that find no room are counted too.
    """
    log, dofs = run.kept, row.floors.shape[1]
    width = line_width(dofs, run.limits.shape[0])
    left = run.board[WHOLE, ROOM] - run.board[WHOLE, WRITTEN]
    run.board[WHOLE, WRITTEN] += 1.0
    if left <= 0.0:
        return
    line = log.size - int(left) * width
    for place in range(line, line + width):
        log[place] = nan
    log[line] = time
    for i in range(group.low, group.high):
        log[line + 1 + i] = run.desk[NOW, i]
        log[line + 1 + dofs + i] = run.desk[NOW + 1, i]
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        place = line + 1 + 2 * dofs + NOTED * k
        log[place + ACTING] = 0.0
        log[place + SO_FAR] = run.book[k, BOOKED + IMPULSE]
        if run.book[k, CLOSED] > 0.0:
            note_contact(row, run, law, k, place)


@kernel
def note_contact(row, run, law, k, place):
    """The columns of contact ``k``, which is closed."""
    book, log = run.book, run.kept
    delta = max(across(row, k, run.desk, NOW) - book[k, GAP], 0.0)
    force = transmitted(model_of(law, run.limits, k, LAW), run, k, delta, across(row, k, run.desk, NOW + 1))
    strongest = book[k, PLATEAU] if book[k, YIELDED] > 0.0 else min(book[k, PEAK], book[k, STRENGTH])
    log[place + ACTING] = force
    log[place + BEGAN] = book[k, TOUCHED]
    log[place + CAME_AT] = book[k, AT_TOUCH]
    log[place + STRONGEST] = max(force, strongest)
