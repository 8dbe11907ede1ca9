"""Peaks within a contact step: the largest force, displacement and floor acceleration of the continuous motion."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import LOWEST_FORCE
from pounding_risk.solver.pair.readings import FORCE, peek
from pounding_risk.solver.pair.step import spread
from pounding_risk.solver.workspace import BEGIN, BETWEEN, END, SIGNALS


@kernel
def crest(watch, sign, ends, impact, phase, span, workspace):
    """The largest sign × reading inside the step, where its slope turns, and its place; on the step's polynomial.

    ``ends`` are the slopes at both ends, positive and negative. Regula falsi with halving (Illinois), from the crest
    of the cubic through both ends.
    """
    low, high = 0.0, 1.0
    low_slope, high_slope = ends
    best, there = -inf, 0.0
    side = 0
    x = low_slope / (low_slope - high_slope)
    if span[0] > 0.0:
        rise = sign * (workspace.readings[END, watch] - workspace.readings[BEGIN, watch]) / span[1]
        x = cubic_crest(rise, low_slope, high_slope)
    for _ in range(60):
        peek(impact, phase, span, x, workspace)
        if sign * workspace.readings[BETWEEN, watch] > best:
            best, there = sign * workspace.readings[BETWEEN, watch], x
        slope = sign * workspace.reading_slopes[BETWEEN, watch]
        if slope > 0.0:
            low, low_slope = x, slope
            high_slope = 0.5 * high_slope if side == 1 else high_slope
            side = 1
        else:
            high, high_slope = x, slope
            low_slope = 0.5 * low_slope if side == -1 else low_slope
            side = -1
        new = low + (high - low) * low_slope / (low_slope - high_slope)
        if not low < new < high:
            new = 0.5 * (low + high)
        # The reading is flat at its crest: a place good to 1e-5 of the step gives it to 1e-10.
        if abs(new - x) <= 1e-5 or high - low <= 1e-5:
            break
        x = new
    return best, there


@small
def cubic_crest(rise, start_slope, stop_slope):
    """Where on (0, 1) the cubic with this mean slope and these end slopes, positive and negative, is highest."""
    bend = 2.0 * (3.0 * rise - 2.0 * start_slope - stop_slope)
    twist = 3.0 * (start_slope + stop_slope - 2.0 * rise)
    # Root of start + bend x + twist x² where it falls, in the form that does not cancel.
    root = sqrt(max(bend * bend - 4.0 * twist * start_slope, 0.0))
    return min(max(2.0 * start_slope / (root - bend), 1e-3), 1.0 - 1e-3) if root > bend else 0.5


@small
def hides_crest(watch, sign, best, span, workspace):
    """Slopes of sign × reading at both ends where a crest above ``best`` may lie between them, else (0, 0)."""
    s, h = span
    end_slope = sign * workspace.reading_slopes[END, watch]
    if end_slope >= 0.0:
        return 0.0, 0.0
    if s == 0.0:
        # The slope at the touch itself may be infinite and is no measure of what follows.
        return -end_slope, end_slope
    start_slope = sign * workspace.reading_slopes[BEGIN, watch]
    if start_slope <= 0.0:
        return 0.0, 0.0
    # A concave stretch stays under the crossing of its end tangents.
    reach = h * start_slope * end_slope / (end_slope - start_slope)
    if max(sign * workspace.readings[BEGIN, watch], sign * workspace.readings[END, watch]) + reach < best:
        return 0.0, 0.0
    return start_slope, end_slope


@kernel
def raise_peak(watch, sign, best, impact, phase, span, workspace):
    """max(best, sign × reading over the step), with the crest between its ends; and whether the step is laid out.

    ``span`` = (s, h, whether the step is laid out already by `spread`).
    """
    best = max(best, sign * workspace.readings[END, watch])
    ends = hides_crest(watch, sign, best, (span[0], span[1]), workspace)
    if not ends[0] > 0.0:
        return best, span[2]
    if not span[2]:
        spread(impact, phase, (span[0], span[1]), workspace)
    return max(best, crest(watch, sign, ends, impact, phase, (span[0], span[1]), workspace)[0]), True


@small
def watch_step(impact, phase, span, peak, workspace):
    """Peaks over an accepted step into the workspace; returns this contact's peak uncapped force so far.

    The readings at its ends are those in the workspace. Error control keeps a step from hiding a crest twice as high as
    both its ends: what stays below half of the peak so far is not searched.
    """
    laid = False
    counters, readings, high, low = workspace.counters, workspace.readings, workspace.high, workspace.low
    here, there = readings[BEGIN, FORCE], readings[END, FORCE]
    peak = max(peak, here)
    if 2.0 * max(here, there) > peak:
        peak, laid = raise_peak(FORCE, 1.0, peak, impact, phase, (*span, laid), workspace)
    if impact.least == -inf and 2.0 * min(here, there) < counters[LOWEST_FORCE]:
        lowest, laid = raise_peak(FORCE, -1.0, -counters[LOWEST_FORCE], impact, phase, (*span, laid), workspace)
        counters[LOWEST_FORCE] = -lowest
    for watch in range(FORCE + 1, SIGNALS):
        here, there = readings[BEGIN, watch], readings[END, watch]
        if 2.0 * max(here, there) > high[watch]:
            high[watch], laid = raise_peak(watch, 1.0, high[watch], impact, phase, (*span, laid), workspace)
        if 2.0 * min(here, there) < low[watch]:
            lowest, laid = raise_peak(watch, -1.0, -low[watch], impact, phase, (*span, laid), workspace)
            low[watch] = -lowest
    return peak
