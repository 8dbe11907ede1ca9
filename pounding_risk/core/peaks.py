"""Peaks within a contact step: the largest force, displacement and floor acceleration of the continuous motion."""

from __future__ import annotations

from math import inf

from pounding_risk._jit import kernel, small
from pounding_risk.core.collide import LAST, attempt, slopes, state_of
from pounding_risk.core.events import END_ROWS, FORCE, read_end
from pounding_risk.core.flight import SIGNALS
from pounding_risk.core.series import END, HERE, HERE_SLOPE, HIGH, LOW, NEXT, NEXT_SLOPE, TALLY
from pounding_risk.core.tally import LOWEST_FORCE


@kernel
def crest(watch, sign, ends, impact, phase, span, desk):
    """The largest sign × reading inside the step, where its slope turns; found on repeated steps.

    ``ends`` are the slopes at both ends, positive and negative. Regula falsi with halving (Illinois). Rows END,
    LAST, NEXT and NEXT_SLOPE are overwritten.
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
        read_end(impact, phase, h, desk, END_ROWS)
        best = max(best, sign * desk[NEXT, watch])
        slope = sign * desk[NEXT_SLOPE, watch]
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


@small
def hides_crest(watch, sign, best, span, desk):
    """Slopes of sign × reading at both ends where a crest above ``best`` may lie between them, else (0, 0)."""
    s, h = span
    end_slope = sign * desk[NEXT_SLOPE, watch]
    if end_slope >= 0.0:
        return 0.0, 0.0
    if s == 0.0:
        # The slope at the touch itself may be infinite and is no measure of what follows.
        return -end_slope, end_slope
    start_slope = sign * desk[HERE_SLOPE, watch]
    if start_slope <= 0.0:
        return 0.0, 0.0
    # A concave stretch stays under the crossing of its end tangents.
    reach = h * start_slope * end_slope / (end_slope - start_slope)
    if max(sign * desk[HERE, watch], sign * desk[NEXT, watch]) + reach < best:
        return 0.0, 0.0
    return start_slope, end_slope


@small
def raise_peak(watch, sign, best, impact, phase, span, desk):
    """max(best, sign × reading over the step), with the crest between its ends; the step's rows are kept."""
    here, there = sign * desk[HERE, watch], sign * desk[NEXT, watch]
    best = max(best, there)
    # Error control keeps a step from hiding a crest twice as high as both its ends.
    if 2.0 * max(here, there) <= best:
        return best
    ends = hides_crest(watch, sign, best, span, desk)
    if ends[0] > 0.0:
        best = max(best, crest(watch, sign, ends, impact, phase, span, desk))
        attempt(impact, phase, span[0], span[1], desk)
        slopes(impact, phase, span[0] + span[1], state_of(desk, END), desk, LAST)
        read_end(impact, phase, span[1], desk, END_ROWS)
    return best


@small
def watch_step(impact, phase, span, peak, desk):
    """Peaks over an accepted step onto the desk; returns this contact's peak uncapped force so far.

    Its readings stand on the desk already.
    """
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
