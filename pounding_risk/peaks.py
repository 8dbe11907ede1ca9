"""Peaks within a contact step: the largest force, displacement and floor acceleration of the continuous motion."""

from __future__ import annotations

from math import inf

from pounding_risk._jit import kernel
from pounding_risk.collide import ELASTIC, LAST, attempt, nudged, slopes, state_of, transmitted, uncapped
from pounding_risk.flight import SIGNALS
from pounding_risk.series import END, HERE, HIGH, LOW, NEXT, STAGES, STATE, TALLY
from pounding_risk.tally import LOWEST_FORCE

# What is watched; past the force, the numbers are those of the signals watched in flight.
FORCE, PLACE_LEFT, PLACE_RIGHT, SHAKE_LEFT, SHAKE_RIGHT = 0, 1, 2, 3, 4


@kernel
def reading(watch, impact, phase, state):
    """A watched quantity in contact: uncapped force, displacement or absolute acceleration of a building."""
    if watch == FORCE:
        return uncapped(impact, phase, state)
    if watch == PLACE_LEFT:
        return state[0]
    if watch == PLACE_RIGHT:
        return state[1]
    force = transmitted(impact, phase, state)
    if watch == SHAKE_LEFT:
        left = impact.left
        return (-left.fade * state[2] - left.spring * state[0]) - left.inverse_mass * force
    right = impact.right
    return (-right.fade * state[3] - right.spring * state[1]) + right.inverse_mass * force


@kernel
def reading_slope(watch, impact, phase, state, desk, row, h):
    """Its derivative along the slopes of a row, per unit of s, over a ten-millionth of the step."""
    nudge = 1e-7 * h
    ahead = nudged(state, desk, row, nudge)
    return (reading(watch, impact, phase, ahead) - reading(watch, impact, phase, state)) / nudge


@kernel
def crest(watch, sign, ends, impact, phase, span, desk):
    """The largest sign × reading inside the step, where its slope turns; found on repeated steps.

    ``ends`` are the slopes at both ends, positive and negative. Regula falsi with halving (Illinois). Rows END
    and LAST are overwritten.
    """
    s, h = span
    low, high = 0.0, h
    low_slope, high_slope = ends
    best = -inf
    side = 0
    for _ in range(60):
        length = low + (high - low) * low_slope / (low_slope - high_slope)
        if not low < length < high:
            length = 0.5 * (low + high)
        attempt(impact, phase, s, length, desk)
        state = state_of(desk, END)
        slopes(impact, phase, s + length, state, desk, LAST)
        best = max(best, sign * reading(watch, impact, phase, state))
        slope = sign * reading_slope(watch, impact, phase, state, desk, LAST, h)
        if slope > 0.0:
            moved = length - low
            low, low_slope = length, slope
            high_slope = 0.5 * high_slope if side == 1 else high_slope
            side = 1
        else:
            moved = high - length
            high, high_slope = length, slope
            low_slope = 0.5 * low_slope if side == -1 else low_slope
            side = -1
        # The reading is flat at its crest: a place good to 1e-5 of the step gives it to 1e-10.
        if moved <= 1e-5 * h or high - low <= 1e-5 * h:
            break
    return best


@kernel
def hides_crest(watch, sign, best, impact, phase, span, desk):
    """Slopes of sign × reading at both ends where a crest above ``best`` may lie between them, else (0, 0).

    The readings themselves stand in rows HERE and NEXT.
    """
    s, h = span
    end_slope = sign * reading_slope(watch, impact, phase, state_of(desk, END), desk, LAST, h)
    if end_slope >= 0.0:
        return 0.0, 0.0
    if s == 0.0:
        # The slope at the touch itself may be infinite and is no measure of what follows.
        return -end_slope, end_slope
    start_slope = sign * reading_slope(watch, impact, phase, state_of(desk, STATE), desk, STAGES, h)
    if start_slope <= 0.0:
        return 0.0, 0.0
    # A concave stretch stays under the crossing of its end tangents.
    reach = h * start_slope * end_slope / (end_slope - start_slope)
    if max(sign * desk[HERE, watch], sign * desk[NEXT, watch]) + reach < best:
        return 0.0, 0.0
    return start_slope, end_slope


@kernel
def read_contact(impact, phase, state, desk, row):
    """Everything that is watched in contact, into a row: `reading` of each kind."""
    force = transmitted(impact, phase, state)
    left, right = impact.left, impact.right
    desk[row, FORCE] = force if phase.region == ELASTIC else uncapped(impact, phase, state)
    desk[row, PLACE_LEFT] = state[0]
    desk[row, PLACE_RIGHT] = state[1]
    desk[row, SHAKE_LEFT] = (-left.fade * state[2] - left.spring * state[0]) - left.inverse_mass * force
    desk[row, SHAKE_RIGHT] = (-right.fade * state[3] - right.spring * state[1]) + right.inverse_mass * force


@kernel
def raise_peak(watch, sign, best, impact, phase, span, desk):
    """max(best, sign × reading over the step), with the crest between its ends; the step's rows are kept."""
    here, there = sign * desk[HERE, watch], sign * desk[NEXT, watch]
    best = max(best, there)
    # Error control keeps a step from hiding a crest twice as high as both its ends.
    if 2.0 * max(here, there) <= best:
        return best
    ends = hides_crest(watch, sign, best, impact, phase, span, desk)
    if ends[0] > 0.0:
        best = max(best, crest(watch, sign, ends, impact, phase, span, desk))
        attempt(impact, phase, span[0], span[1], desk)
        slopes(impact, phase, span[0] + span[1], state_of(desk, END), desk, LAST)
    return best


@kernel
def watch_step(impact, phase, span, peak, desk):
    """Peaks over an accepted step onto the desk; returns this contact's peak uncapped force so far."""
    read_contact(impact, phase, state_of(desk, STATE), desk, HERE)
    read_contact(impact, phase, state_of(desk, END), desk, NEXT)
    peak = max(peak, desk[HERE, FORCE])
    for part in range(2 * SIGNALS):
        watch, sign = part // 2, 1.0 - 2.0 * (part % 2)
        if watch == FORCE and sign < 0.0 and impact.least > -inf:
            continue
        if watch == FORCE:
            best = peak if sign > 0.0 else -desk[TALLY, LOWEST_FORCE]
        else:
            best = desk[HIGH, watch] if sign > 0.0 else -desk[LOW, watch]
        best = raise_peak(watch, sign, best, impact, phase, span, desk)
        if watch == FORCE and sign > 0.0:
            peak = best
        elif watch == FORCE:
            desk[TALLY, LOWEST_FORCE] = -best
        elif sign > 0.0:
            desk[HIGH, watch] = best
        else:
            desk[LOW, watch] = -best
    return peak
