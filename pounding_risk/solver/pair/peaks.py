"""Peaks within a contact step: the largest force, displacement and floor acceleration of the continuous motion."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import LOWEST_FORCE
from pounding_risk.solver.pair.equations import ELASTIC, slopes, state_along_slopes, state_of, transmitted, uncapped
from pounding_risk.solver.pair.explicit import state_between
from pounding_risk.solver.pair.implicit import write_polynomial
from pounding_risk.solver.workspace import BEGIN, BETWEEN, BETWEEN_SLOPE, END, FELT, FIRST_STAGE, LAST, SIGNALS

# Readings in contact; from 1 on they are numbered as the signals in flight.
FORCE, DISPLACEMENT_LEFT, DISPLACEMENT_RIGHT, ACCELERATION_LEFT, ACCELERATION_RIGHT = 0, 1, 2, 3, 4


@small
def read_contact(impact, phase, state, force, time, workspace, row):
    """Write the readings of a state and the force felt in it: uncapped force, displacements, absolute accelerations."""
    readings = workspace.readings
    left, right = impact.left, impact.right
    readings[row, FORCE] = force if phase.region == ELASTIC else uncapped(impact, phase, state)
    u, w, v, z = phase.ground.from_own_ground(right, state, time)
    readings[row, DISPLACEMENT_LEFT] = u
    readings[row, DISPLACEMENT_RIGHT] = w
    readings[row, ACCELERATION_LEFT] = (-left.two_zeta_omega * v - left.omega2 * u) - left.inverse_mass * force
    readings[row, ACCELERATION_RIGHT] = (-right.two_zeta_omega * z - right.omega2 * w) + right.inverse_mass * force


@small
def read_end(impact, phase, position, workspace, rows):
    """Write the readings and their slopes per unit of s at ``position`` = (s, length of the step).

    ``rows`` are those of the place: (of states and readings, of slopes), whose slopes `equations.slopes` has written.
    The slope of the force is a difference over a ten-millionth of the step; all else is linear in it and in the slopes
    of the state.
    """
    row, slope_row = rows
    rise = workspace.reading_slopes
    left, right = impact.left, impact.right
    state = state_of(workspace.states, row)
    s, h = position
    cube = s * s * s
    nudge = 1e-7 * h
    nudged_state = state_along_slopes(state, workspace.slopes, slope_row, nudge)
    force = workspace.slopes[slope_row, FELT]
    read_contact(impact, phase, state, force, cube * s, workspace, row)
    rise[row, FORCE] = (uncapped(impact, phase, nudged_state) - workspace.readings[row, FORCE]) / nudge
    force_slope = rise[row, FORCE]
    if phase.region != ELASTIC:
        force_slope = (transmitted(impact, phase, nudged_state) - force) / nudge
    u, w, v, z = phase.ground.slopes_from_own_ground(right, state_of(workspace.slopes, slope_row), cube * s, 4.0 * cube)
    rise[row, DISPLACEMENT_LEFT] = u
    rise[row, DISPLACEMENT_RIGHT] = w
    rise[row, ACCELERATION_LEFT] = (-left.two_zeta_omega * v - left.omega2 * u) - left.inverse_mass * force_slope
    rise[row, ACCELERATION_RIGHT] = (-right.two_zeta_omega * z - right.omega2 * w) + right.inverse_mass * force_slope


# Rows of a place on the step: of its state and readings, and of its slopes.
AT_BEGIN = (BEGIN, FIRST_STAGE)
AT_END = (END, LAST)
AT_BETWEEN = (BETWEEN, BETWEEN_SLOPE)


@small
def read_between(impact, phase, span, x, workspace):
    """Write state, slopes and readings at a place x of the step, 0 to 1, on its polynomial."""
    s, h = span
    state = state_between(x, workspace)
    for part in range(4):
        workspace.states[BETWEEN, part] = state[part]
    slopes(impact, phase, s + x * h, state, workspace, BETWEEN_SLOPE)
    read_end(impact, phase, (s + x * h, h), workspace, AT_BETWEEN)


@kernel
def local_maximum(reading, sign, ends, impact, phase, span, workspace):
    """The largest sign × reading inside the step, where its slope turns, and its place; on the step's polynomial.

    ``ends`` are the slopes at both ends, positive and negative. Regula falsi with halving (Illinois), from the local
    maximum of the cubic through both ends.
    """
    low, high = 0.0, 1.0
    low_slope, high_slope = ends
    best, best_x = -inf, 0.0
    side = 0
    x = low_slope / (low_slope - high_slope)
    if span[0] > 0.0:
        rise = sign * (workspace.readings[END, reading] - workspace.readings[BEGIN, reading]) / span[1]
        x = cubic_maximum(rise, low_slope, high_slope)
    for _ in range(60):
        read_between(impact, phase, span, x, workspace)
        if sign * workspace.readings[BETWEEN, reading] > best:
            best, best_x = sign * workspace.readings[BETWEEN, reading], x
        slope = sign * workspace.reading_slopes[BETWEEN, reading]
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
        # The reading is flat at its local maximum: a place good to 1e-5 of the step gives it to 1e-10.
        if abs(new - x) <= 1e-5 or high - low <= 1e-5:
            break
        x = new
    return best, best_x


@small
def cubic_maximum(rise, start_slope, stop_slope):
    """Where on (0, 1) the cubic with this mean slope and these end slopes, positive and negative, is highest."""
    bend = 2.0 * (3.0 * rise - 2.0 * start_slope - stop_slope)
    twist = 3.0 * (start_slope + stop_slope - 2.0 * rise)
    # Root of start + bend x + twist x² where it falls, in the form that does not cancel.
    root = sqrt(max(bend * bend - 4.0 * twist * start_slope, 0.0))
    return min(max(2.0 * start_slope / (root - bend), 1e-3), 1.0 - 1e-3) if root > bend else 0.5


@small
def hides_maximum(reading, sign, best, span, workspace):
    """Slopes of sign × reading at both ends where a local maximum above ``best`` may lie between them, else (0, 0)."""
    s, h = span
    end_slope = sign * workspace.reading_slopes[END, reading]
    if end_slope >= 0.0:
        return 0.0, 0.0
    if s == 0.0:
        # The slope at the touch itself may be infinite and is no measure of what follows.
        return -end_slope, end_slope
    start_slope = sign * workspace.reading_slopes[BEGIN, reading]
    if start_slope <= 0.0:
        return 0.0, 0.0
    # A concave stretch stays under the crossing of its end tangents.
    reach = h * start_slope * end_slope / (end_slope - start_slope)
    if max(sign * workspace.readings[BEGIN, reading], sign * workspace.readings[END, reading]) + reach < best:
        return 0.0, 0.0
    return start_slope, end_slope


@small
def peak_so_far(reading, sign, peak, workspace):
    """The largest sign × reading of the run so far; of the force in compression that of the contact, ``peak``."""
    if reading == FORCE:
        return peak if sign > 0.0 else -workspace.counters[LOWEST_FORCE]
    return workspace.high[reading] if sign > 0.0 else -workspace.low[reading]


@small
def update_peaks(impact, phase, span, peak, workspace):
    """Peaks over an accepted step into the workspace; returns this contact's peak uncapped force so far.

    The readings at its ends are those in the workspace. Error control keeps a step from hiding a local maximum twice as
    high as both its ends: what stays below half of the peak so far is not searched.
    """
    has_polynomial = False
    readings = workspace.readings
    peak = max(peak, readings[BEGIN, FORCE])
    for reading in range(SIGNALS):
        for side in range(2):
            sign = 1.0 - 2.0 * side
            if reading == FORCE and side == 1 and impact.least_force > -inf:
                continue
            best = peak_so_far(reading, sign, peak, workspace)
            start, end = sign * readings[BEGIN, reading], sign * readings[END, reading]
            if not 2.0 * max(start, end) > best:
                continue
            best = max(best, end)
            ends = hides_maximum(reading, sign, best, span, workspace)
            if ends[0] > 0.0:
                if not has_polynomial:
                    write_polynomial(impact, phase, span, workspace)
                    has_polynomial = True
                best = max(best, local_maximum(reading, sign, ends, impact, phase, span, workspace)[0])
            if reading > FORCE and side == 0:
                workspace.high[reading] = best
            elif reading > FORCE:
                workspace.low[reading] = -best
            elif side == 0:
                peak = best
            else:
                workspace.counters[LOWEST_FORCE] = -best
    return peak
