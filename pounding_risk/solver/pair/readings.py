"""What is read in contact, at the ends of a step and between them: the uncapped force and the signals of flight."""

from __future__ import annotations

from pounding_risk._jit.compile import small
from pounding_risk.solver.pair.stages import (
    ELASTIC,
    nudged,
    slopes,
    state_between,
    state_of,
    transmitted,
    uncapped,
)
from pounding_risk.solver.workspace import BEGIN, BETWEEN, BETWEEN_SLOPE, END, FIRST_STAGE, LAST

# What is watched for its peak; past the force, the numbers are those of the signals watched in flight.
FORCE, PLACE_LEFT, PLACE_RIGHT, SHAKE_LEFT, SHAKE_RIGHT = 0, 1, 2, 3, 4


@small
def read_contact(impact, phase, state, time, workspace, row):
    """Write the readings of a state: uncapped force, displacements, absolute accelerations."""
    reading = workspace.readings
    force = transmitted(impact, phase, state)
    left, right = impact.left, impact.right
    reading[row, FORCE] = force if phase.region == ELASTIC else uncapped(impact, phase, state)
    u, w, v, z = phase.ground.apart(right, state, time)
    reading[row, PLACE_LEFT] = u
    reading[row, PLACE_RIGHT] = w
    reading[row, SHAKE_LEFT] = (-left.fade * v - left.spring * u) - left.inverse_mass * force
    reading[row, SHAKE_RIGHT] = (-right.fade * z - right.spring * w) + right.inverse_mass * force


@small
def read_end(impact, phase, place, workspace, rows):
    """Write the readings and their slopes per unit of s at ``place`` = (s, length of the step).

    ``rows`` are those of the place: (of states and readings, of slopes). The slope of the force is a difference over a
    ten-millionth of the step; all else is linear in it and in the slopes of the state.
    """
    row, slope_row = rows
    rise = workspace.reading_slopes
    left, right = impact.left, impact.right
    state = state_of(workspace.states, row)
    s, h = place
    cube = s * s * s
    nudge = 1e-7 * h
    ahead = nudged(state, workspace.slopes, slope_row, nudge)
    read_contact(impact, phase, state, cube * s, workspace, row)
    rise[row, FORCE] = (uncapped(impact, phase, ahead) - workspace.readings[row, FORCE]) / nudge
    felt = rise[row, FORCE]
    if phase.region != ELASTIC:
        felt = (transmitted(impact, phase, ahead) - transmitted(impact, phase, state)) / nudge
    u, w, v, z = phase.ground.apart_slopes(right, state_of(workspace.slopes, slope_row), cube * s, 4.0 * cube)
    rise[row, PLACE_LEFT] = u
    rise[row, PLACE_RIGHT] = w
    rise[row, SHAKE_LEFT] = (-left.fade * v - left.spring * u) - left.inverse_mass * felt
    rise[row, SHAKE_RIGHT] = (-right.fade * z - right.spring * w) + right.inverse_mass * felt


# Rows of a place on the step: of its state and readings, and of its slopes.
AT_BEGIN = (BEGIN, FIRST_STAGE)
AT_END = (END, LAST)
AT_BETWEEN = (BETWEEN, BETWEEN_SLOPE)


@small
def peek(impact, phase, span, x, workspace):
    """Write state, slopes and readings at a place x of the step, 0 to 1, on its polynomial."""
    s, h = span
    state = state_between(x, workspace)
    for part in range(4):
        workspace.states[BETWEEN, part] = state[part]
    slopes(impact, phase, s + x * h, state, workspace, BETWEEN_SLOPE)
    read_end(impact, phase, (s + x * h, h), workspace, AT_BETWEEN)
