"""Peaks within a contact step: the largest force, displacement and floor acceleration of the continuous motion."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import LOWEST_FORCE
from pounding_risk.solver.pair.flight import SIGNALS
from pounding_risk.solver.pair.readings import FORCE, peek
from pounding_risk.solver.pair.stages import PEEKED, PEEKED_RISE
from pounding_risk.solver.pair.step import spread
from pounding_risk.solver.pair.taylor import HERE, HERE_SLOPE, HIGH, LOW, NEXT, NEXT_SLOPE, TALLY


@kernel
def crest(watch, sign, ends, impact, phase, span, desk):
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
        rise = sign * (desk[NEXT, watch] - desk[HERE, watch]) / span[1]
        x = cubic_crest(rise, low_slope, high_slope)
    for _ in range(60):
        peek(impact, phase, span, x, desk)
        if sign * desk[PEEKED, watch] > best:
            best, there = sign * desk[PEEKED, watch], x
        slope = sign * desk[PEEKED_RISE, watch]
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


@kernel
def raise_peak(watch, sign, best, impact, phase, span, desk):
    """max(best, sign × reading over the step), with the crest between its ends; and whether the step is laid out.

    ``span`` = (s, h, whether the step is laid out already by `spread`).
    """
    best = max(best, sign * desk[NEXT, watch])
    ends = hides_crest(watch, sign, best, (span[0], span[1]), desk)
    if not ends[0] > 0.0:
        return best, span[2]
    if not span[2]:
        spread(impact, phase, (span[0], span[1]), desk)
    return max(best, crest(watch, sign, ends, impact, phase, (span[0], span[1]), desk)[0]), True


@small
def watch_step(impact, phase, span, peak, desk):
    """Peaks over an accepted step onto the desk; returns this contact's peak uncapped force so far.

    Its readings stand on the desk already. Error control keeps a step from hiding a crest twice as high as both its
    ends: what stays below half of the peak so far is not looked at.
    """
    laid = False
    here, there = desk[HERE, FORCE], desk[NEXT, FORCE]
    peak = max(peak, here)
    if 2.0 * max(here, there) > peak:
        peak, laid = raise_peak(FORCE, 1.0, peak, impact, phase, (*span, laid), desk)
    if impact.least == -inf and 2.0 * min(here, there) < desk[TALLY, LOWEST_FORCE]:
        lowest, laid = raise_peak(FORCE, -1.0, -desk[TALLY, LOWEST_FORCE], impact, phase, (*span, laid), desk)
        desk[TALLY, LOWEST_FORCE] = -lowest
    for watch in range(FORCE + 1, SIGNALS):
        here, there = desk[HERE, watch], desk[NEXT, watch]
        if 2.0 * max(here, there) > desk[HIGH, watch]:
            desk[HIGH, watch], laid = raise_peak(watch, 1.0, desk[HIGH, watch], impact, phase, (*span, laid), desk)
        if 2.0 * min(here, there) < desk[LOW, watch]:
            lowest, laid = raise_peak(watch, -1.0, -desk[LOW, watch], impact, phase, (*span, laid), desk)
            desk[LOW, watch] = -lowest
    return peak
