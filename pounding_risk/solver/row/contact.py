"""A contact of a row, from its touch to its parting, in the book and in the tally."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import (
    APPROACH,
    CONTACT_TIME,
    COUNT,
    DEMAND,
    FIRST_TOUCH,
    FIRST_YIELD,
    HELD,
    PEAK_FORCE,
    PENETRATION,
    PLASTIC,
    SET,
    VISCOUS,
    YIELDS,
)
from pounding_risk.solver.pair.stages import ELASTIC, REBOUND_SHARE, ROUNDING
from pounding_risk.solver.row.flight import across, compliance
from pounding_risk.solver.row.laws import law_begin, law_part, law_turn
from pounding_risk.solver.row.workspace import (
    APPROACHING,
    ASKED,
    AT_TOUCH,
    BOOKED,
    CLOSED,
    DEEPEST,
    DENTED,
    DEPTH,
    FASTEST,
    FORCES,
    GAP,
    HIGHEST,
    LEAST,
    LOST,
    NOW,
    PACE,
    PEAK,
    PLATEAU,
    REGION,
    ROOM,
    RULE,
    SPEED,
    START,
    STILL,
    STRENGTH,
    TOUCHED,
    WHOLE,
    WORN,
    YIELDED,
)


@kernel
def touch_down(row, run, k, time):
    """Contact ``k`` begins at ``time`` with the state in rows NOW."""
    book, desk = run.book, run.desk
    c = run.limits
    rule = Restitution(c[k, RULE], c[k, RULE + 1], c[k, RULE + 2], c[k, RULE + 3], c[k, RULE + 4])
    speed = max(across(row, k, desk, NOW + 1), 0.0)
    mass = 1.0 / compliance(row, k)
    e = rule.at(speed)
    scale = max(speed, 1e-3 * run.limits[k, FASTEST], 1e-12)
    strength, least, depth = law_begin(run, k, e, speed, mass, book[k, WORN], scale, run.limits[k, FORCES])
    size = 0.0
    for end in range(4):
        if row.ends[k, end] >= 0:
            size = max(size, abs(desk[NOW, row.ends[k, end]]))
    book[k, CLOSED] = 1.0
    book[k, STRENGTH], book[k, LEAST] = strength, least
    book[k, SPEED], book[k, DEPTH] = scale, depth
    # As the pair has it: δ is a difference of displacements, and what they round by becomes a speed.
    book[k, STILL] = (1e-14 + 4.0 * ROUNDING * size / depth) * scale
    book[k, APPROACHING], book[k, REGION] = 1.0, float(ELASTIC)
    book[k, TOUCHED], book[k, AT_TOUCH], book[k, ASKED] = time, speed, e
    # Crests below the largest force so far are of no account, unless each contact's own are asked for.
    own = run.timed.shape[2] > 0 or run.board[WHOLE, ROOM] > 0.0
    book[k, PEAK] = 0.0 if own else book[k, BOOKED + DEMAND]
    book[k, PLATEAU] = book[k, DEEPEST] = book[k, YIELDED] = book[k, DENTED] = book[k, LOST] = 0.0
    book[k, PACE] = 0.3 * depth / scale
    if book[k, BOOKED + COUNT] == 0.0:
        book[k, BOOKED + FIRST_TOUCH] = time
    book[k, BOOKED + COUNT] += 1.0
    book[k, BOOKED + APPROACH] = max(book[k, BOOKED + APPROACH], speed)
    book[k, BOOKED + HELD] += 1.0 if rule.beyond(speed) else 0.0


@kernel
def own_tolerance(run, k, rtol):
    """What comes back of a contact is e times what came: its error must stay a small part of that."""
    return min(rtol, REBOUND_SHARE * run.book[k, ASKED])


@kernel
def turn(row, run, k, delta):
    """The motion of contact ``k`` turns at ``delta``; as `core.pound` has it."""
    book = run.book
    approaching = book[k, APPROACHING] > 0.0
    if approaching:
        book[k, DEEPEST] = max(book[k, DEEPEST], delta + book[k, DENTED])
    dent, taken = law_turn(run, k, delta, book[k, STRENGTH], book[k, APPROACHING], book[k, REGION])
    if dent >= 0.0:
        # What stays widens the gap, here and for the contacts after this one.
        book[k, GAP] += dent
        book[k, DENTED] += dent
        book[k, LOST] += taken
        book[k, REGION] = float(ELASTIC)
    book[k, APPROACHING] = 0.0 if approaching else 1.0


@kernel
def note_yield(run, k, time):
    """The uncapped force of contact ``k`` has met F_E."""
    book = run.book
    book[k, PEAK], book[k, PLATEAU] = max(book[k, PEAK], book[k, STRENGTH]), max(book[k, PLATEAU], book[k, STRENGTH])
    book[k, YIELDED] += 1.0
    if book[k, YIELDED] == 1.0:
        book[k, BOOKED + YIELDS] += 1.0
        if book[k, BOOKED + YIELDS] == 1.0:
            book[k, BOOKED + FIRST_YIELD] = time


@kernel
def lift_off(row, run, k, time, line, work):
    """Contact ``k`` ends at ``time``, its state in rows ``line``; ``work`` is what its force has taken in all [J]."""
    book = run.book
    delta = max(across(row, k, run.desk, line) - book[k, GAP], 0.0)
    book[k, DEEPEST] = max(book[k, DEEPEST], delta + book[k, DENTED])
    loss, hysteresis, worn = law_part(run, k, delta, book[k, STRENGTH], work - book[k, LOST])
    book[k, BOOKED + VISCOUS] += loss - hysteresis
    book[k, BOOKED + PLASTIC] += book[k, LOST] + hysteresis
    book[k, BOOKED + SET] += book[k, DENTED]
    book[k, WORN] = worn
    book[k, BOOKED + CONTACT_TIME] += time - book[k, TOUCHED]
    force = book[k, PLATEAU] if book[k, YIELDED] > 0.0 else min(book[k, PEAK], book[k, STRENGTH])
    book[k, BOOKED + DEMAND] = max(book[k, BOOKED + DEMAND], book[k, PEAK])
    book[k, BOOKED + PEAK_FORCE] = max(book[k, BOOKED + PEAK_FORCE], force)
    book[k, BOOKED + PENETRATION] = max(book[k, BOOKED + PENETRATION], book[k, DEEPEST])
    run.book[k, HIGHEST] = max(run.book[k, HIGHEST], book[k, GAP] - book[k, DENTED] + book[k, DEEPEST])
    for level in range(run.timed.shape[2]):
        run.timed[2, k, level] += 1.0 if run.timed[0, k, level] <= book[k, PEAK] else 0.0
    book[k, CLOSED] = 0.0


@kernel
def scales(row, run, first, last):
    """(when the last touch was, smallest scale of penetration, of speed, shortest pace) of a group's contacts."""
    book = run.book
    touched, depth, speed, pace = -inf, inf, inf, inf
    for k in range(row.frame[START, first], row.frame[START, last]):
        if book[k, CLOSED] > 0.0:
            touched = max(touched, book[k, TOUCHED])
            depth, speed = min(depth, book[k, DEPTH]), min(speed, book[k, SPEED])
            pace = min(pace, book[k, PACE])
    return touched, depth, speed, pace
