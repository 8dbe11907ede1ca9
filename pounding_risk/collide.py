"""The contact phase: error-controlled integration that lands on every event.

State of the pair in contact: u_left, u_right, v_left, v_right, and three quadratures: work of the contact force
∫ F δ̇ dt, impulse ∫ F dt, and the energy that the ground puts in less what the structures' dampers take.

The start of a contact is not smooth in time (F ~ δ^(1/4) costs any method its order). The clock is therefore
s with τ = s⁴ since the touch: there δ^(1/4) ~ s, and the order of the method survives. Each step ends at a record
sample, or where the force changes its branch: δ̇ = 0, the uncapped force meets the yield force, the force would
turn to tension in a law that cuts it, the bodies part.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk._jit import kernel
from pounding_risk.models.structures import Oscillator
from pounding_risk.models.tableau import DOP853
from pounding_risk.series import END, STAGES, STATE

LAST = STAGES + len(DOP853.nodes)  # row of the slopes at the end of a step
# The tableau on the desk, sparse: a row for each stage with pairs (earlier stage, weight), then a row with the final
# weights and both error weights, (stage, weight, fifth, third); −1 ends a row. A stage's node stands in column NODE.
TABLE = LAST + 1
FINAL = TABLE + len(DOP853.nodes)
NODE = 60
DESK = (FINAL + 1, 64)

SLACK, ELASTIC, YIELDING = -1, 0, 1  # force cut at zero, uncapped, on the plateau
NONE, TURN, YIELD, CUT, PART = 0, 1, 2, 3, 4  # what ends a step early


class Impact(NamedTuple):
    """What stays the same during one contact."""

    left: Oscillator
    right: Oscillator
    law: tuple
    gap: float  # m
    strength: float  # force at which the law yields, inf without a cap [N]
    least: float  # smallest force, −inf where tension is not cut [N]
    memory: float  # damping constant of this contact
    speed: float  # scale of velocity for the error control [m/s]
    depth: float  # and of penetration [m]


class Phase(NamedTuple):
    """What stays the same during one step."""

    approaching: bool
    region: int
    ground: float  # a_g extrapolated to the touch [m/s²]
    ramp: float  # its slope [m/s³]


def make_desk() -> np.ndarray:
    """A desk with the tableau on it, for one thread."""
    desk = np.zeros(DESK)
    for stage, row in enumerate(DOP853.a):
        pairs = [(column, weight) for column, weight in enumerate(row) if weight != 0.0]
        desk[TABLE + stage, : 2 * len(pairs) + 1] = [*np.ravel(pairs), -1.0]
        desk[TABLE + stage, NODE] = DOP853.c[stage]
    columns = np.column_stack([np.arange(len(DOP853.b)), DOP853.b, *DOP853.e])
    used = columns[np.any(columns[:, 1:] != 0.0, axis=1)]
    desk[FINAL, : used.size + 1] = [*used.ravel(), -1.0]
    return desk


@kernel
def transmitted(impact, phase, state):
    """Force that the buildings feel on this branch of the law."""
    if phase.region == SLACK:
        return 0.0
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    if phase.region == YIELDING:
        return impact.law.plateau(delta, impact.strength)
    return impact.law.force(impact.memory, delta, state[2] - state[3], phase.approaching)


@kernel
def uncapped(impact, phase, state):
    """The law's force without cap or cut."""
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    return impact.law.force(impact.memory, delta, state[2] - state[3], phase.approaching)


@kernel
def slopes(impact, phase, s, state, desk, row):
    """d(state)/ds = 4 s³ d(state)/dt into a row: u, v of both buildings, work, impulse, energy put in."""
    left, right = impact.left, impact.right
    force = transmitted(impact, phase, state)
    cube = s * s * s
    a_g = phase.ground + phase.ramp * (cube * s)
    clock = 4.0 * cube
    drive_left = -left.ground * a_g - left.fade * state[2]
    drive_right = -right.ground * a_g - right.fade * state[3]
    desk[row, 0] = clock * state[2]
    desk[row, 1] = clock * state[3]
    desk[row, 2] = clock * ((drive_left - left.spring * state[0]) - left.inverse_mass * force)
    desk[row, 3] = clock * ((drive_right - right.spring * state[1]) + right.inverse_mass * force)
    desk[row, 4] = clock * force * (state[2] - state[3])
    desk[row, 5] = clock * force
    desk[row, 6] = clock * (left.mass * state[2] * drive_left + right.mass * state[3] * drive_right)


@kernel
def state_of(desk, row):
    """(u_left, u_right, v_left, v_right) from a row."""
    return desk[row, 0], desk[row, 1], desk[row, 2], desk[row, 3]


@kernel
def attempt(impact, phase, s, h, desk):
    """One step of the tableau from row STATE, whose slopes are in row STAGES, to row END; returns its error.

    The error is that of Hairer's 8(5,3) pair, in units of the contact's scales of penetration and speed. The
    table is read from the desk: written out in the code it is no faster and takes ten times as long to compile,
    and sums of a known length fall to LLVM's loop vectoriser, which makes them half as fast again.
    """
    k = STAGES
    for stage in range(1, LAST - STAGES):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        place = 0
        while desk[TABLE + stage, place] >= 0.0:
            weight = desk[TABLE + stage, place + 1]
            u, w, v, z = state_of(desk, k + int(desk[TABLE + stage, place]))
            a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
            place += 2
        u, w, v, z = state_of(desk, STATE)
        trial = (u + h * a, w + h * b, v + h * c, z + h * d)
        slopes(impact, phase, s + desk[TABLE + stage, NODE] * h, trial, desk, k + stage)
    a, b, c, d, work, impulse, power = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    a5, b5, c5, d5, a3, b3, c3, d3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    place = 0
    while desk[FINAL, place] >= 0.0:
        row = k + int(desk[FINAL, place])
        weight, fifth, third = desk[FINAL, place + 1], desk[FINAL, place + 2], desk[FINAL, place + 3]
        u, w, v, z = state_of(desk, row)
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        a5, b5, c5, d5 = a5 + fifth * u, b5 + fifth * w, c5 + fifth * v, d5 + fifth * z
        a3, b3, c3, d3 = a3 + third * u, b3 + third * w, c3 + third * v, d3 + third * z
        work += weight * desk[row, 4]
        impulse += weight * desk[row, 5]
        power += weight * desk[row, 6]
        place += 4
    for part, change in enumerate((a, b, c, d, work, impulse, power)):
        desk[END, part] = desk[STATE, part] + h * change
    deep, fast = h / impact.depth, h / impact.speed
    fifth = deep * deep * (a5 * a5 + b5 * b5) + fast * fast * (c5 * c5 + d5 * d5)
    third = deep * deep * (a3 * a3 + b3 * b3) + fast * fast * (c3 * c3 + d3 * d3)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@kernel
def nudged(state, desk, row, nudge):
    """The state a little further along its slopes."""
    return (
        state[0] + nudge * desk[row, 0],
        state[1] + nudge * desk[row, 1],
        state[2] + nudge * desk[row, 2],
        state[3] + nudge * desk[row, 3],
    )


@kernel
def margin(kind, impact, phase, state):
    """A function that is positive on the branch and negative past the event."""
    if kind == TURN:
        rate = state[2] - state[3]
        return rate if phase.approaching else -rate
    if kind == PART:
        return state[0] - state[1] - impact.gap
    force = uncapped(impact, phase, state)
    if kind == YIELD:
        return force - impact.strength if phase.region == YIELDING else impact.strength - force
    return -force if phase.region == SLACK else force


@kernel
def margin_slope(kind, impact, phase, state, desk, row, h):
    """Derivative of `margin` along the slopes of a row, per unit of s, over a ten-millionth of the step."""
    if kind == TURN:
        change = desk[row, 2] - desk[row, 3]
        return change if phase.approaching else -change
    if kind == PART:
        return desk[row, 0] - desk[row, 1]
    nudge = 1e-7 * h
    ahead = nudged(state, desk, row, nudge)
    return (margin(kind, impact, phase, ahead) - margin(kind, impact, phase, state)) / nudge


@kernel
def cubic(start, start_slope, stop, stop_slope, x):
    """Cubic through two values and slopes on [0, 1]."""
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
def dip_of(kind, impact, phase, span, desk):
    """Where on the step (0 to 1) an event of this kind comes first, or 2: a model between both ends."""
    s, h = span
    end = state_of(desk, END)
    stop = margin(kind, impact, phase, end)
    if kind == TURN and abs(stop) <= 1e-14 * impact.speed:
        return 2.0
    state = state_of(desk, STATE)
    start = max(margin(kind, impact, phase, state), 0.0)
    stop_slope = h * margin_slope(kind, impact, phase, end, desk, LAST, h)
    if stop >= 0.0 and stop_slope <= 0.0:
        return 2.0
    # At the touch δ^(1/4) has no slope in t and a finite one in s; where it rises from there is all that counts.
    start_slope = stop - start
    if s > 0.0:
        start_slope = h * margin_slope(kind, impact, phase, state, desk, STAGES, h)
    if stop >= 0.0 and start_slope >= 0.0:
        return 2.0
    dip = first_dip(start, start_slope, stop, stop_slope)
    return min(dip, 1.0) if stop < 0.0 else dip


@kernel
def is_watched(kind, impact, phase):
    """True for the kinds of event that this branch of the law can end with."""
    if kind == YIELD:
        return impact.strength < inf
    if kind == CUT:
        return impact.least > -inf and phase.region != YIELDING
    return kind != PART or not phase.approaching


@kernel
def first_event(impact, phase, span, desk):
    """Which event the step from row STATE to row END meets first, and where on it (0 to 1)."""
    kind, place = NONE, 2.0
    for candidate in range(TURN, PART + 1):
        if is_watched(candidate, impact, phase):
            dip = dip_of(candidate, impact, phase, span, desk)
            if dip < place:
                kind, place = candidate, dip
    return kind, place


@kernel
def event_passed(landed, impact, phase, desk):
    """An event other than ``landed`` that lies before the end of the step after all, or NONE."""
    end = state_of(desk, END)
    for candidate in range(TURN, PART + 1):
        if candidate != landed and is_watched(candidate, impact, phase):
            slack = 1e-14 * impact.speed if candidate == TURN else 0.0
            if margin(candidate, impact, phase, end) < -slack:
                return candidate
    return NONE


@kernel
def land(kind, place, impact, phase, span, desk):
    """Shorten the step until it ends on the event: Newton's rule on repeated steps, inside a bracket.

    Returns the length of the step, whose end is left in row END and its slopes in row LAST, and whether the event
    is there: a dip that only the model between the ends had is none.
    """
    s, h = span
    low, high = 0.0, h
    length = place * h
    crossed = margin(kind, impact, phase, state_of(desk, END)) < 0.0
    converged = False
    # Branches join continuously, so that a landing this close costs its square in the state; where the bodies
    # part a law may drop a force that it still had.
    close = 1e-13 if kind == PART else 1e-8
    for _ in range(50):
        attempt(impact, phase, s, length, desk)
        end = state_of(desk, END)
        slopes(impact, phase, s + length, end, desk, LAST)
        value = margin(kind, impact, phase, end)
        if value > 0.0:
            low = length
        else:
            high = length
            crossed = True
        slope = margin_slope(kind, impact, phase, end, desk, LAST, h)
        new = length - value / slope if slope < 0.0 else low
        if not low <= new <= high:
            new = 0.5 * (low + high)
        converged = slope < 0.0 and abs(new - length) <= close * h
        if converged or high - low <= 1e-13 * h:
            break
        length = new
    return length, crossed or converged


@kernel
def depth_of(law, energy, guess):
    """Penetration at which an uncapped law has stored ``energy``: a scale, good to a tenth."""
    depth = guess
    for _ in range(200):
        stored = law.stored(depth, inf)
        if not stored > 0.0:
            depth *= 1e3
            continue
        ratio = energy / stored
        if 0.8 < ratio < 1.25:
            break
        depth *= sqrt(ratio)
    return depth


@kernel
def energy_of(pair, state):
    """Kinetic and strain energy of both buildings [J]."""
    left, right = pair
    kinetic = left.mass * state[2] ** 2 + right.mass * state[3] ** 2
    strain = left.mass * left.spring * state[0] ** 2 + right.mass * right.spring * state[1] ** 2
    return 0.5 * (kinetic + strain)


@kernel
def switched(kind, phase):
    """The phase after an event."""
    approaching, region = phase.approaching, phase.region
    if kind == TURN:
        approaching = not approaching
    elif kind == YIELD:
        region = ELASTIC if region == YIELDING else YIELDING
    elif kind == CUT:
        region = ELASTIC if region == SLACK else SLACK
    return Phase(approaching, region, phase.ground, phase.ramp)


@kernel
def next_step(h, error, rtol):
    """Step length from the last one: 0.9 (rtol / 10 error)^(1/8), kept within 1/5 and 5."""
    if error == 0.0:
        return 5.0 * h
    return h * min(5.0, max(0.2, 0.9 * sqrt(sqrt(sqrt(0.1 * rtol / error)))))


@kernel
def take_step(impact, phase, span, rtol, desk):
    """One accepted step within ``span`` = (s, length to try, length left), shortened to the first event on it.

    The end is left in row END, its slopes on this branch in row LAST. Returns (length, event, next length to
    try, attempts); a length of 0 means that the step fell below what s resolves, a negative one that the motion
    is not finite.
    """
    s, h, left = span
    attempts = 0
    while True:
        # A sliver at the end of the span would cost a step of its own: split what is left evenly instead.
        if h >= left:
            h = left
        elif 2.0 * h > left:
            h = 0.5 * left
        error = attempt(impact, phase, s, h, desk)
        attempts += 1
        # A contact takes some ten steps and a run some ten contacts: each step may spend a tenth of the tolerance.
        if error <= 0.1 * rtol:
            break
        if not error >= 0.0 and attempts > 60:
            return -1.0, NONE, h, attempts
        h = next_step(h, error, rtol) if error >= 0.0 else 0.1 * h
        if s + h <= s or h < 1e-13 * left:
            return 0.0, NONE, h, attempts
    slopes(impact, phase, s + h, state_of(desk, END), desk, LAST)
    following = next_step(h, error, rtol)
    event, place = first_event(impact, phase, (s, h), desk)
    if event != NONE:
        following = h
        h, there = land(event, place, impact, phase, (s, h), desk)
        event = event if there else NONE
        # The order of two events on one step is a guess of the model between its ends: look again from the landing.
        for _ in range(PART):
            earlier = event_passed(event, impact, phase, desk)
            if earlier == NONE:
                break
            event = earlier
            place = min(dip_of(event, impact, phase, (s, h), desk), 1.0)
            h, there = land(event, place, impact, phase, (s, h), desk)
    return h, event, following, attempts


@kernel
def begin(pair, fastest, law, limits, state):
    """Freeze what a contact remembers of its start; returns the `Impact` and the approach speed."""
    left, right = pair
    gap, yield_force, restitution = limits
    speed = max(state[2] - state[3], 0.0)
    mass = 1.0 / (left.inverse_mass + right.inverse_mass)
    memory = law.begin(restitution.at(speed), speed, mass)
    # Errors count against this contact's own scale, but not against less than a thousandth of the motion's.
    scale = max(speed, 1e-3 * fastest, 1e-12)
    depth = depth_of(law, 0.5 * mass * scale * scale, 1e-2 * scale)
    return Impact(left, right, law, gap, law.ceiling(yield_force), law.floor(), memory, scale, depth), speed
