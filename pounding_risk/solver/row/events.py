"""Events of a group in contact: which comes first on a step, and landing on it.

The kinds of `pair.events` for every contact, and two of a row's own: an open contact point touches, a storey changes
its branch. Margins are positive until the event.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.pair.equations import ELASTIC, SHARE
from pounding_risk.solver.pair.events import CUT, FEW_REFUSALS, LANDED, NONE, TURN, YIELD, first_dip
from pounding_risk.solver.pair.explicit import next_step
from pounding_risk.solver.pair.taylor import slope_at, value_at
from pounding_risk.solver.row.equations import is_balanced, slopes
from pounding_risk.solver.row.event_functions import (
    CORNER,
    STRAIN,
    TOUCH,
    event_function,
    event_function_between,
    is_possible,
    read_force,
)
from pounding_risk.solver.row.implicit import attempt, write_polynomial
from pounding_risk.solver.row.link import is_link_of
from pounding_risk.solver.row.workspace import (
    AT_END,
    AT_START,
    END,
    FIRST,
    LAST,
    LIMIT,
    NOW,
    SLOPE,
    SLOPES,
    START,
    VELOCITY,
)


@kernel
def dip_of(row, run, group, kind, k, span):
    """Where on the step, 0 to 1, an event comes first, or 2 for nowhere.

    A cubic between both ends shows where its event function falls below zero; where it may dip below zero between two
    ends above it, the polynomial of the step does.
    """
    s, h = span[0], span[1]
    stop, stop_slope = event_function(row, run, kind, k, True)
    if stop >= 0.0 and stop_slope <= 0.0 and kind != TURN:
        return 2.0
    start, start_slope = event_function(row, run, kind, k, False)
    if stop >= 0.0 and (stop_slope <= 0.0 or s == 0.0):
        return 2.0
    start = max(start, 0.0)
    start_slope = h * start_slope if s > 0.0 else stop - start
    if stop >= 0.0 and start_slope >= 0.0:
        return 2.0
    dip = first_dip(start, start_slope, stop, h * stop_slope)
    if stop < 0.0:
        return min(dip, 1.0)
    # The reach of a parabola through both slopes separates most steps without a dip from those with one.
    if dip > 1.0:
        reach = start_slope * h * stop_slope / (h * stop_slope - start_slope)
        if min(start, stop) + reach >= 0.0:
            return 2.0
        dip = -start_slope / (h * stop_slope - start_slope)
    write_polynomial(row, run, group, s, h)
    bottom = lowest_point(row, run, group, kind, k, span, dip)
    value = event_function_between(row, run, group, kind, k, bottom, span)
    # Rounding is no event: the motion that only grazes goes on as it was.
    return bottom if value < -dip_tolerance(run, kind, k) else 2.0


@kernel
def dip_tolerance(run, kind, k):
    """How far a margin may dip without an event: rounding."""
    if kind == YIELD:
        return 1e-9 * run.contacts[k].strength
    return 0.0


@kernel
def lowest_point(row, run, group, kind, k, span, guess):
    """Where on the step a margin that falls at its start and rises at its end is lowest: golden section."""
    low, high, x = 0.0, 1.0, min(max(guess, 0.05), 0.95)
    value = event_function_between(row, run, group, kind, k, x, span)
    for _ in range(40):
        if value < -dip_tolerance(run, kind, k):
            return x
        is_left_wider = x - low > high - x
        trial = x - 0.381966 * (x - low) if is_left_wider else x + 0.381966 * (high - x)
        trial_value = event_function_between(row, run, group, kind, k, trial, span)
        if trial_value < value:
            if is_left_wider:
                high = x
            else:
                low = x
            x, value = trial, trial_value
        elif is_left_wider:
            low = trial
        else:
            high = trial
        if high - low < 1e-4:
            break
    return x


@kernel
def first_of_storey(row, run, group, i, span, so_far):
    """The first event of `first_event` ``so_far``, or that of storey ``i`` where it comes before it."""
    event, event_k, fraction = so_far
    for kind in (STRAIN, CORNER):
        if is_possible(row, run, kind, i):
            dip = dip_of(row, run, group, kind, i, span)
            if dip < fraction:
                event, event_k, fraction = kind, i, dip
    return event, event_k, fraction


@kernel
def first_event(row, run, group, span):
    """(kind, contact or storey, where on the step) of the event that a step meets first; (NONE, −1, 2) for none."""
    event, event_k, fraction = NONE, -1, 2.0
    for k in range(row.frame[START, group.watched_first], row.frame[START, group.watched_last]):
        inside = row.frame[START, group.first] <= k < row.frame[START, group.last]
        for kind in range(TURN, TOUCH + 1):
            if (inside or kind == TOUCH) and is_possible(row, run, kind, k):
                dip = dip_of(row, run, group, kind, k, span)
                if dip < fraction:
                    event, event_k, fraction = kind, k, dip
    for i in range(group.low, group.high):
        if row.floors[LIMIT, i] < inf:
            event, event_k, fraction = first_of_storey(row, run, group, i, span, (event, event_k, fraction))
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, group.first, group.last):
            i = row.floors.shape[1] + k
            event, event_k, fraction = first_of_storey(row, run, group, i, span, (event, event_k, fraction))
    return event, event_k, fraction


@kernel
def refine_event(row, run, group, kind, k, fraction, span):
    """Refine the place of an event on the step's polynomial: regula falsi with halving; 2 where there is none.

    ``fraction`` lies past the event, or at a guess of it.
    """
    high, above = 1.0, event_function_between(row, run, group, kind, k, 1.0, span)
    value = event_function_between(row, run, group, kind, k, fraction, span)
    if value < 0.0:
        high, above = fraction, value
    elif not above < 0.0:
        return 2.0
    low, below = 0.0, max(event_function_between(row, run, group, kind, k, 0.0, span), 0.0)
    if value >= 0.0:
        low, below = fraction, value
    side = 0
    x = high
    for _ in range(60):
        x = low + (high - low) * below / (below - above)
        if not low < x < high:
            x = 0.5 * (low + high)
        value = event_function_between(row, run, group, kind, k, x, span)
        if value < 0.0:
            move, high, above = high - x, x, value
            below = 0.5 * below if side == 1 else below
            side = 1
        else:
            move, low, below = x - low, x, value
            above = 0.5 * above if side == -1 else above
            side = -1
        if high - low <= 1e-9 or (move <= 1e-7 and abs(value) <= 1e-7 * abs(below - above)):
            break
    return x


@kernel
def fill_spectators(row, run, group, time, line):
    """The neighbours that only look on, ``time`` the start of their series, into rows ``line``."""
    for b in range(group.watched_first, group.watched_last + 1):
        if not group.first <= b <= group.last:
            for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
                run.dofs[line, i] = value_at(run.series, i, group.terms, time)
                run.dofs[line + VELOCITY, i] = slope_at(run.series, i, group.terms, time)


@kernel
def fill_ends(row, run, group, span):
    """Spectators at both ends of a step, and their slopes per unit of s; ``span`` = (s, h, base)."""
    for at_end in range(2):
        s = span[0] + span[1] if at_end else span[0]
        cube = s * s * s
        time = group.origin + cube * s - span[2]
        fill_spectators(row, run, group, time, END if at_end else NOW)
        line = SLOPE + LAST if at_end else SLOPE
        for b in range(group.watched_first, group.watched_last + 1):
            if not group.first <= b <= group.last:
                for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
                    run.dofs[line, i] = 4.0 * cube * run.dofs[(END if at_end else NOW) + VELOCITY, i]
                    run.dofs[line + SLOPES, i] = 0.0


@kernel
def land(row, run, group, kind, k, fraction, span):
    """Shorten the step until it ends on the event, as `pair.events.land`; returns (length, if it is there, error)."""
    s, h = span[0], span[1]
    low, high, length, error = 0.0, h, fraction * h, 0.0
    crossed = event_function(row, run, kind, k, True)[0] < 0.0
    converged = False
    close = 1e-3 * sqrt(group.tolerance)
    for _ in range(50):
        error = attempt(row, run, group, s, length)
        slopes(row, run, group, s + length, END, LAST)
        fill_ends(row, run, group, (s, length, span[2]))
        if kind in (YIELD, CUT):
            read_force(row, run, group, h, END, SLOPE + LAST, AT_END)
        value, slope = event_function(row, run, kind, k, True)
        if value > 0.0:
            low = length
        else:
            high, crossed = length, True
        new = length - value / slope if slope < 0.0 else low
        # Where the margin rises at a length before an event, the event is after it.
        if not low <= new <= high or (crossed and slope >= 0.0):
            new = 0.5 * (low + high)
        converged = slope < 0.0 and abs(new - length) <= close * h
        if converged:
            move_end_along_slopes(row, run, group, new - length)
            length = new
        if converged or high - low <= 1e-13 * h:
            break
        length = new
    return length, crossed or converged, error


@kernel
def move_end_along_slopes(row, run, group, length):
    """Move the end of a step, state and quadratures, along its slopes by a ``length`` of the clock s."""
    dofs, points = run.dofs, run.laws.shape[0]
    for i in range(group.low, group.high):
        dofs[END, i] += length * dofs[SLOPE + LAST, i]
        dofs[END + VELOCITY, i] += length * dofs[SLOPE + LAST + SLOPES, i]
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        for column in (k, points + k):
            run.quadratures[SLOPES, column] += length * run.quadratures[LAST, column]
    run.quadratures[SLOPES, 2 * points] += length * run.quadratures[LAST, 2 * points]


@kernel
def passed_by_storey(row, run, i, landed, landed_k):
    """The kind of an event of storey ``i`` that `event_passed` looks for, or NONE."""
    for kind in (STRAIN, CORNER):
        if (landed == kind and i == landed_k) or not is_possible(row, run, kind, i):
            continue
        if event_function(row, run, kind, i, True)[0] < 0.0:
            return kind
    return NONE


@kernel
def event_passed(row, run, group, landed, landed_k):
    """An event other than the one landed on that lies before the end of the step after all, or NONE."""
    for k in range(row.frame[START, group.watched_first], row.frame[START, group.watched_last]):
        inside = row.frame[START, group.first] <= k < row.frame[START, group.last]
        for kind in range(TURN, TOUCH + 1):
            if (kind == landed and k == landed_k) or not (inside or kind == TOUCH):
                continue
            if is_possible(row, run, kind, k) and event_function(row, run, kind, k, True)[0] < 0.0:
                return kind, k
    for i in range(group.low, group.high):
        if row.floors[LIMIT, i] < inf:
            kind = passed_by_storey(row, run, i, landed, landed_k)
            if kind != NONE:
                return kind, i
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, group.first, group.last):
            i = row.floors.shape[1] + k
            kind = passed_by_storey(row, run, i, landed, landed_k)
            if kind != NONE:
                return kind, i
    return NONE, -1


@kernel
def read_step_end(row, run, group, span):
    """Readings at the end of the step, whose slopes at LAST stand."""
    fill_ends(row, run, group, span)
    read_force(row, run, group, span[1], END, SLOPE + LAST, AT_END)


@kernel
def accepted_step(row, run, group, s, h, remaining):
    """Try a step from s of length ``h``, and shorter ones, until the error and the energy are within the tolerance.

    The state at its end is left in rows END. Returns (its length, its error, attempts); a length of 0 means that the
    step fell below what s resolves, a negative one that the motion is not finite.
    """
    attempts, was_halved = 0, False
    while True:
        # A sliver at the end would cost a step of its own: split the remaining length evenly instead.
        if h >= remaining:
            h = remaining
        elif 2.0 * h > remaining:
            h = 0.5 * remaining
        error = attempt(row, run, group, s, h)
        attempts += 1
        if error <= SHARE * group.tolerance:
            if was_halved or is_balanced(row, run, group):
                return h, error, attempts
            was_halved, h = True, 0.5 * h
            continue
        if not error >= 0.0 and attempts > 10:
            return -1.0, error, attempts
        h = next_step(h, error, group.tolerance, run.workspace.tableau) if error >= 0.0 else 0.1 * h
        if s + h <= s or h < 1e-13 * remaining:
            return 0.0, error, attempts


@kernel
def end_on_first(row, run, group, event, span):
    """End the step on its first event, of which ``event`` = (kind, contact or storey, where on it) is a guess.

    Returns (length, kind, contact or storey, error), the whole length and NONE where no event is there.
    """
    s, h, base = span
    kind, k, fraction = event
    write_polynomial(row, run, group, s, h)
    fraction = refine_event(row, run, group, kind, k, fraction, span)
    if fraction > 1.0:
        return h, NONE, -1, 0.0
    full_length, error = h, 0.0
    for _ in range(8):
        h, is_reached, error = land(row, run, group, kind, k, fraction, (s, full_length, base))
        read_step_end(row, run, group, (s, h, base))
        if not is_reached and not (kind == YIELD and int(run.contacts[k].region) == ELASTIC):
            return h, NONE, -1, error
        earlier, earlier_k = event_passed(row, run, group, kind, k)
        if earlier == NONE:
            break
        # The order of two events on one step is a guess of the model between its ends: look again from the landing.
        write_polynomial(row, run, group, s, h)
        start = event_function(row, run, earlier, earlier_k, False)[0]
        fraction = refine_event(row, run, group, earlier, earlier_k, 1.0, (s, h, base)) if start > 0.0 else 0.0
        fraction, full_length, kind, k = min(fraction, 1.0), h, earlier, earlier_k
    return h, kind, k, error


@kernel
def take_step(row, run, group, span, remaining):
    """One accepted step, shortened to its first event; ``span`` = (s, h to try, base of the spectators' series).

    The state at its end is left in rows END, its slopes in those of LAST. Returns (length, kind of event, contact or
    storey, next length to try, attempts); the length is below or at zero as `accepted_step` gives it.
    """
    s, h, base = span
    attempts, refusals = 0, 0
    while True:
        h, error, tries = accepted_step(row, run, group, s, h, remaining)
        attempts += tries
        if h <= 0.0:
            return h, NONE, -1, h, attempts
        if run.workspace.tableau.end_weight == 0.0:
            slopes(row, run, group, s + h, END, LAST)
        read_force(row, run, group, h, NOW, SLOPE, AT_START)
        read_step_end(row, run, group, (s, h, base))
        event = first_event(row, run, group, (s, h, base))
        if event[0] == NONE:
            return h, NONE, -1, next_step(h, error, group.tolerance, run.workspace.tableau), attempts
        whole_length = h
        h, kind, k, error = end_on_first(row, run, group, event, (s, h, base))
        if not error > LANDED * group.tolerance or refusals == FEW_REFUSALS:
            return h, kind, k, whole_length, attempts
        refusals += 1
        h = next_step(h, error, group.tolerance, run.workspace.tableau)
