"""What is read in contact, at the ends of a step and between them: the uncapped force and the signals of flight."""

from __future__ import annotations

from pounding_risk._jit.compile import small
from pounding_risk.solver.pair.stages import (
    ELASTIC,
    LAST,
    PEEK,
    PEEK_SLOPE,
    PEEKED,
    PEEKED_RISE,
    nudged,
    slopes,
    state_between,
    state_of,
    transmitted,
    uncapped,
)
from pounding_risk.solver.pair.taylor import END, HERE, HERE_SLOPE, NEXT, NEXT_SLOPE, STAGES, STATE

# What is watched for its peak; past the force, the numbers are those of the signals watched in flight.
FORCE, PLACE_LEFT, PLACE_RIGHT, SHAKE_LEFT, SHAKE_RIGHT = 0, 1, 2, 3, 4


@small
def read_contact(impact, phase, state, time, desk, row):
    """Everything that is watched in contact, into a row: uncapped force, displacements, absolute accelerations."""
    force = transmitted(impact, phase, state)
    left, right = impact.left, impact.right
    desk[row, FORCE] = force if phase.region == ELASTIC else uncapped(impact, phase, state)
    u, w, v, z = phase.ground.apart(right, state, time)
    desk[row, PLACE_LEFT] = u
    desk[row, PLACE_RIGHT] = w
    desk[row, SHAKE_LEFT] = (-left.fade * v - left.spring * u) - left.inverse_mass * force
    desk[row, SHAKE_RIGHT] = (-right.fade * z - right.spring * w) + right.inverse_mass * force


@small
def read_end(impact, phase, place, desk, rows):
    """Readings and their slopes per unit of s at ``place`` = (s, length of the step), an end of a step or between.

    ``rows`` = (state, slopes of the state, readings, slopes of the readings). The slope of the force is a difference
    over a ten-millionth of the step; all else is linear in it and in the slopes of the state.
    """
    source, tangent, values, rises = rows
    left, right = impact.left, impact.right
    state = state_of(desk, source)
    s, h = place
    cube = s * s * s
    nudge = 1e-7 * h
    ahead = nudged(state, desk, tangent, nudge)
    read_contact(impact, phase, state, cube * s, desk, values)
    desk[rises, FORCE] = (uncapped(impact, phase, ahead) - desk[values, FORCE]) / nudge
    felt = desk[rises, FORCE]
    if phase.region != ELASTIC:
        felt = (transmitted(impact, phase, ahead) - transmitted(impact, phase, state)) / nudge
    u, w, v, z = phase.ground.apart_slopes(right, state_of(desk, tangent), cube * s, 4.0 * cube)
    desk[rises, PLACE_LEFT] = u
    desk[rises, PLACE_RIGHT] = w
    desk[rises, SHAKE_LEFT] = (-left.fade * v - left.spring * u) - left.inverse_mass * felt
    desk[rises, SHAKE_RIGHT] = (-right.fade * z - right.spring * w) + right.inverse_mass * felt


BEGIN_ROWS = (STATE, STAGES, HERE, HERE_SLOPE)
END_ROWS = (END, LAST, NEXT, NEXT_SLOPE)
PEEK_ROWS = (PEEK, PEEK_SLOPE, PEEKED, PEEKED_RISE)


@small
def peek(impact, phase, span, x, desk):
    """State and readings at a place x of the step, 0 to 1, into PEEK_ROWS; `spread` has laid out the step."""
    s, h = span
    state = state_between(x, desk)
    for part in range(4):
        desk[PEEK, part] = state[part]
    slopes(impact, phase, s + x * h, state, desk, PEEK_SLOPE)
    read_end(impact, phase, (s + x * h, h), desk, PEEK_ROWS)
