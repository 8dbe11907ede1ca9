"""Events in contact: which comes first on a step, and landing on it.

A step may end early where δ̇ = 0, where the uncapped force meets the yield force, where the force of a law that
cannot pull would turn to tension, where the bodies part, and at a knee of the force.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.equations import ELASTIC, SHARE, SLACK, YIELDING, Phase, write_end_slopes
from pounding_risk.solver.pair.explicit import next_step
from pounding_risk.solver.pair.implicit import attempt, write_polynomial
from pounding_risk.solver.pair.peaks import (
    AT_BEGIN,
    AT_BETWEEN,
    AT_END,
    FORCE,
    hides_maximum,
    local_maximum,
    read_between,
    read_end,
)
from pounding_risk.solver.workspace import END, LAST

NONE, TURN, YIELD, CUT, PART, KNEE = 0, 1, 2, 3, 4, 5  # what ends a step early
MET, BARELY = 1e-12, 1.0 + 1e-9  # of F_E: rounding, and where a local maximum differs from it
LANDED = 0.5  # of rtol: a step that ends on an event with a larger error is tried again, shorter
FEW_REFUSALS = 4  # of such steps one after the other: a corner of a law may leave every length with an error


@small
def event_function(kind, impact, phase, workspace, rows):
    """(value, slope) of the event function of a kind at a place on the step whose readings are known.

    It is positive before the event and zero at it.
    """
    row, slope_row = rows
    states, slopes = workspace.states, workspace.slopes
    force, force_slope = workspace.readings[row, FORCE], workspace.reading_slopes[row, FORCE]
    if kind == TURN:
        sign = 1.0 if phase.approaching else -1.0
        # A turn is one that rounding does not undo: bodies at rest against each other turn no more.
        rate = states[row, 2] - states[row, 3]
        return sign * rate + impact.still_speed, sign * (slopes[slope_row, 2] - slopes[slope_row, 3])
    if kind in (PART, KNEE):
        delta, rise = states[row, 0] - states[row, 1] - impact.gap, slopes[slope_row, 0] - slopes[slope_row, 1]
        if kind == PART:
            return delta, rise
        sign = -1.0 if phase.approaching else 1.0
        return sign * (delta - impact.knee_depth), sign * rise
    if kind == YIELD:
        sign = 1.0 if phase.region == YIELDING else -1.0
        # Past F_E by more than rounding, so that a plateau of no length is not left and entered again and again.
        return sign * (force - impact.strength) + MET * impact.strength, sign * force_slope
    sign = -1.0 if phase.region == SLACK else 1.0
    return sign * force, sign * force_slope


@small
def cubic(start, start_slope, stop, stop_slope, x):
    """Value at x of the cubic on [0, 1] with these values and slopes at 0 and at 1."""
    rise = stop - start
    bend = 3.0 * rise - 2.0 * start_slope - stop_slope
    twist = start_slope + stop_slope - 2.0 * rise
    return start + x * (start_slope + x * (bend + x * twist))


@kernel
def first_dip(start, start_slope, stop, stop_slope):
    """Where on (0, 1] the cubic first falls below zero, or 2 where it does not; a start at zero is above it."""
    low = 0.0
    for part in range(1, 9):
        x = 0.125 * part
        if cubic(start, start_slope, stop, stop_slope, x) < 0.0:
            high = x
            for _ in range(12):
                middle = 0.5 * (low + high)
                if cubic(start, start_slope, stop, stop_slope, middle) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        low = x
    return 2.0


@kernel
def rise_above(impact, phase, span, workspace):
    """Where on the step the uncapped force, below F_E at both ends, has its local maximum above it; 2 where it has not.

    The local maximum is that of `peaks.update_peaks`. One that passes F_E by rounding is left to it: it counts, and
    needs no landing on a plateau of no length.
    """
    ends = hides_maximum(FORCE, 1.0, impact.strength, span, workspace)
    if not ends[0] > 0.0:
        return 2.0
    write_polynomial(impact, phase, span, workspace)
    best, fraction = local_maximum(FORCE, 1.0, ends, impact, phase, span, workspace)
    return fraction if best > BARELY * impact.strength else 2.0


@small
def dip_of(kind, impact, phase, span, workspace):
    """Where on the step (0 to 1) an event of this kind comes first, or 2: a model between both ends."""
    s, h = span
    stop, stop_slope = event_function(kind, impact, phase, workspace, AT_END)
    if stop >= 0.0 and stop_slope <= 0.0:
        return 2.0
    start, start_slope = event_function(kind, impact, phase, workspace, AT_BEGIN)
    if kind == YIELD and phase.region == ELASTIC and stop >= 0.0 and start > 0.0:
        return rise_above(impact, phase, span, workspace)
    start = max(start, 0.0)
    # At the touch δ^(1/4) has no slope in t and a finite one in s; where it rises from there is all that counts.
    start_slope = h * start_slope if s > 0.0 else stop - start
    if stop >= 0.0 and start_slope >= 0.0:
        return 2.0
    dip = first_dip(start, start_slope, stop, h * stop_slope)
    return min(dip, 1.0) if stop < 0.0 else dip


@small
def is_possible(kind, impact, phase):
    """True for the kinds of event that can end the present branch of the law."""
    if kind == YIELD:
        return impact.strength < inf
    if kind == CUT:
        return impact.least_force > -inf and phase.region != YIELDING
    if kind == KNEE:
        return impact.knee_depth < inf
    return kind != PART or not phase.approaching


@small
def first_event(impact, phase, span, workspace):
    """Which event the step from BEGIN to END meets first, and where on it (0 to 1)."""
    kind, fraction = NONE, 2.0
    for candidate in range(TURN, KNEE + 1):
        if is_possible(candidate, impact, phase):
            dip = dip_of(candidate, impact, phase, span, workspace)
            if dip < fraction:
                kind, fraction = candidate, dip
    return kind, fraction


@kernel
def event_passed(landed, impact, phase, workspace):
    """An event other than ``landed`` that lies before the end of the step after all, or NONE."""
    for candidate in range(TURN, KNEE + 1):
        if candidate == landed or not is_possible(candidate, impact, phase):
            continue
        if event_function(candidate, impact, phase, workspace, AT_END)[0] < 0.0:
            return candidate
    return NONE


@kernel
def refine_event(kind, fraction, impact, phase, span, workspace):
    """Refine the place of an event on the step's polynomial: Newton's rule in a bracket; 2 where there is none.

    ``fraction`` is the guess of the model between the ends, which may see a dip that the step does not have.
    """
    h = span[1]
    crossed = event_function(kind, impact, phase, workspace, AT_END)[0] < 0.0
    low, high, trial = 0.0, 1.0, fraction
    for _ in range(40):
        read_between(impact, phase, span, trial, workspace)
        value, slope = event_function(kind, impact, phase, workspace, AT_BETWEEN)
        if value < 0.0:
            high, crossed = trial, True
        elif crossed or slope < 0.0:
            low = trial
        else:
            high = trial  # past the bottom of a dip that has not crossed yet
        new = trial - value / (h * slope) if slope < 0.0 else -1.0
        if not low < new < high:
            if slope < 0.0 and value >= 0.0 and not crossed and new >= high:
                return 2.0
            new = 0.5 * (low + high)
        # Newton's rule squares what is left; the landing repeats the step and sees to the rest.
        if abs(new - trial) <= 1e-5 or high - low <= 1e-9:
            return new if crossed or high - low > 1e-9 else 2.0
        trial = new
    return trial


@kernel
def land(kind, fraction, impact, phase, span, rtol, workspace):
    """Shorten the step until it ends on the event: Newton's rule on repeated steps, inside a bracket.

    Returns the length of the step, whose end is left in END and its slopes in LAST, whether the event is there (a dip
    that only the model between the ends had is none), and the error of the step.
    """
    s, h = span
    low, high = 0.0, h
    length, error = fraction * h, 0.0
    crossed = event_function(kind, impact, phase, workspace, AT_END)[0] < 0.0
    converged = False
    # Branches join continuously, and the end is moved along its slopes by what is left: either costs its square.
    close = 1e-3 * sqrt(rtol)
    for _ in range(50):
        error = attempt(impact, phase, s, length, rtol, workspace)
        write_end_slopes(impact, phase, s + length, workspace)
        read_end(impact, phase, (s + length, h), workspace, AT_END)
        value, slope = event_function(kind, impact, phase, workspace, AT_END)
        if value > 0.0:
            low = length
        else:
            high = length
            crossed = True
        new = length - value / slope if slope < 0.0 else low
        # Where the margin rises at a length before an event, the event is after it.
        if not low <= new <= high or (crossed and slope >= 0.0):
            new = 0.5 * (low + high)
        converged = slope < 0.0 and abs(new - length) <= close * h
        if converged:
            for part in range(7):
                workspace.states[END, part] += (new - length) * workspace.slopes[LAST, part]
            length = new
        if converged or high - low <= 1e-13 * h:
            break
        length = new
    return length, crossed or converged, error


@kernel
def switched(kind, phase):
    """Direction of motion and branch of the law after an event."""
    approaching, region = phase.approaching, phase.region
    if kind == TURN:
        approaching = not approaching
    elif kind == YIELD:
        region = ELASTIC if region == YIELDING else YIELDING
    elif kind == CUT:
        region = ELASTIC if region == SLACK else SLACK
    return Phase(approaching, region, phase.ground)


@kernel
def end_on(kind, fraction, impact, phase, span, rtol, workspace):
    """End the step on an event; returns (length, event, error), the whole length and NONE where it is not there."""
    write_polynomial(impact, phase, span, workspace)
    fraction = refine_event(kind, fraction, impact, phase, span, workspace)
    if fraction > 1.0:
        return span[1], NONE, 0.0
    length, is_reached, error = land(kind, fraction, impact, phase, span, rtol, workspace)
    # A local maximum that passes F_E by less than the tolerance may stay below it when the step is repeated: still a
    # yield.
    is_reached = is_reached or (kind == YIELD and phase.region == ELASTIC)
    return length, kind if is_reached else NONE, error


@kernel
def end_on_first(kind, fraction, impact, phase, span, rtol, workspace):
    """End the step on its first event, of which ``kind`` is a guess; returns as `end_on`."""
    length, event, error = end_on(kind, fraction, impact, phase, span, rtol, workspace)
    # The order of two events on one step is a guess of the model between its ends: look again from the landing.
    for _ in range(KNEE):
        earlier = event_passed(event, impact, phase, workspace)
        if earlier == NONE:
            break
        fraction = min(dip_of(earlier, impact, phase, (span[0], length), workspace), 1.0)
        length, event, error = end_on(earlier, fraction, impact, phase, (span[0], length), rtol, workspace)
    return length, event, error


@small
def accepted_step(impact, phase, span, rtol, workspace):
    """Try a step within ``span`` = (s, length, remaining length), and shorter ones, until the error is accepted.

    Returns (its length, its error, attempts); a length of 0 means that the step fell below what s resolves, a negative
    one that the motion is not finite.
    """
    s, h, remaining = span
    attempts = 0
    while True:
        # A sliver at the end of the span would cost a step of its own: split the remaining length evenly instead.
        if h >= remaining:
            h = remaining
        elif 2.0 * h > remaining:
            h = 0.5 * remaining
        error = attempt(impact, phase, s, h, rtol, workspace)
        attempts += 1
        if error <= SHARE * rtol:
            return h, error, attempts
        if not error >= 0.0 and attempts > 10:
            return -1.0, error, attempts
        h = next_step(h, error, rtol, workspace.tableau) if error >= 0.0 else 0.1 * h
        if s + h <= s or h < 1e-13 * remaining:
            return 0.0, error, attempts


@small
def take_step(impact, phase, span, rtol, workspace):
    """One accepted step within ``span`` = (s, length to try, remaining length, known), up to the first event on it.

    ``has_readings`` says that the readings at its beginning stand in their rows already.

    The end is left in END, its slopes on this branch in LAST. Returns (length, event, next length to try, attempts);
    the length is below or at zero as `accepted_step` gives it.
    """
    s, h, remaining, has_readings = span
    attempts, refusals = 0, 0
    while True:
        h, error, tries = accepted_step(impact, phase, (s, h, remaining), rtol, workspace)
        attempts += tries
        if h <= 0.0:
            return h, NONE, h, attempts
        if workspace.tableau.end_weight == 0.0:
            write_end_slopes(impact, phase, s + h, workspace)
        if not has_readings:
            read_end(impact, phase, (s, h), workspace, AT_BEGIN)
        read_end(impact, phase, (s + h, h), workspace, AT_END)
        event, fraction = first_event(impact, phase, (s, h), workspace)
        if event == NONE:
            return h, NONE, next_step(h, error, rtol, workspace.tableau), attempts
        whole_length = h
        h, event, error = end_on_first(event, fraction, impact, phase, (s, h), rtol, workspace)
        # Where δ^1.5 ends at the parting a step that passes it may seem better than one that ends there.
        if not error > LANDED * rtol or refusals == FEW_REFUSALS:
            return h, event, whole_length, attempts
        refusals += 1
        h = next_step(h, error, rtol, workspace.tableau)
