"""The contact phase: error-controlled integration that lands on every event.

State of the pair in contact: u_left, u_right, v_left, v_right, both seen from the ground under the left building, and
three quadratures: work of the contact force ∫ F δ̇ dt, impulse ∫ F dt, and the energy that the ground puts in less
what the structures' dampers take.

The start of a contact is not smooth in time (F ~ δ^(1/4) costs any method its order). The clock is therefore
s with τ = s⁴ since the touch: there δ^(1/4) ~ s, and the order of the method survives. Each step ends at a record
sample, or where the force changes its branch: δ̇ = 0, the uncapped force meets the yield force, the force would
turn to tension in a law that cuts it, the bodies part.
"""

from __future__ import annotations

from functools import cache
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel, part, small
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.solver.counters import WORKED
from pounding_risk.solver.pair.taylor import END, STAGES, STATE, TALLY
from pounding_risk.solver.runge_kutta import DOP853, DORMAND_PRINCE

# Rows of the desk that belong to the contact phase: the slopes at every stage of a step and at its end, those at the
# late stages, and what lies between both ends of a step: a polynomial's rows, a place on it and what is read there.
LAST = STAGES + len(DOP853.nodes)
POLYNOMIAL = LAST + 1 + len(DOP853.late_nodes)
TERMS = 7
PEEK, PEEK_SLOPE, PEEKED, PEEKED_RISE = range(POLYNOMIAL + TERMS, POLYNOMIAL + TERMS + 4)
# The tableau on the desk, sparse. A row for each stage with pairs (earlier row of slopes, weight); a row with the final
# weights and the error weights, (row of slopes, weight, fifth, third); pairs for the late stages and for the
# polynomial. −1 ends a row. The last columns hold a stage's node and, in row FINAL, what the method is.
TABLE = PEEKED_RISE + 1
FINAL = TABLE + len(DOP853.nodes)
LATE = FINAL + 1
BETWEEN = LATE + len(DOP853.late_nodes)
NODE, COUNTED, LATES, END_WEIGHT, POWER = 59, 60, 61, 62, 63
DESK = (BETWEEN + len(DOP853.between), 64)

# The method by tolerance, loosest first: each serves tolerances from its own on. Most steps end at a record sample or
# an event, so that a low order saves its stages only where few digits are asked for.
METHODS = ((1e-4, DORMAND_PRINCE), (0.0, DOP853))

# A run takes hundreds of steps whose errors add up: each may spend this share of the tolerance, so that the energy of
# all shipped scenes closes to the tolerance itself.
SHARE = 0.05

# What comes back of a contact is e times what came: its own error must stay this small a part of it.
REBOUND_SHARE = 0.1
ROUNDING = 1e-15  # of a displacement

SLACK, ELASTIC, YIELDING = -1, 0, 1  # force cut at zero, uncapped, on the plateau


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
    still: float  # speed below which the direction of the motion is rounding [m/s]


class Phase(NamedTuple):
    """What stays the same during one step."""

    approaching: bool
    region: int
    ground: tuple  # under the buildings, as `models.ground` has it, its clock begins at the touch


def make_desk(rtol: float = 0.0) -> np.ndarray:
    """A desk for one thread, with the tableau that suits the tolerance on it."""
    return _template(next(place for place, (least, _) in enumerate(METHODS) if rtol >= least)).copy()


@cache
def _template(place: int) -> np.ndarray:
    method = METHODS[place][1]
    stages = len(method.nodes)
    desk = np.zeros(DESK)
    desk[[TABLE, LATE, BETWEEN], 0] = -1.0
    for first, rows in ((TABLE, method.a), (LATE, method.late), (BETWEEN, method.d)):
        for place, row in enumerate(rows):
            write_pairs(desk[first + place], [row], stages)
    desk[BETWEEN + len(method.d) : BETWEEN + len(DOP853.between), 0] = -1.0
    desk[TABLE : TABLE + stages, NODE] = method.c
    desk[LATE : LATE + len(method.late), NODE] = method.late_nodes
    errors = np.zeros((2, stages + 1))
    errors[: len(method.e)] = method.e
    write_pairs(desk[FINAL], [np.append(method.b, 0.0), *errors * (np.arange(stages + 1) < stages)], stages)
    desk[FINAL, [COUNTED, LATES, END_WEIGHT]] = stages, len(method.late), errors[0, stages]
    desk[FINAL, POWER] = 1.0 / method.order
    return desk


def write_pairs(target: np.ndarray, rows: list[np.ndarray], stages: int) -> None:
    """Write the columns of a tableau that any of the rows uses: its row of slopes, then a weight for each row."""
    columns = np.arange(len(rows[0]))
    entries = np.column_stack([np.where(columns < stages, columns, columns + LAST - STAGES - stages), *rows])
    used = entries[np.any(entries[:, 1:] != 0.0, axis=1)]
    target[: used.size + 1] = [*used.ravel(), -1.0]


@small
def transmitted(impact, phase, state):
    """Force that the buildings feel on this branch of the law."""
    if phase.region == SLACK:
        return 0.0
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    if phase.region == YIELDING:
        return impact.law.plateau(delta, impact.strength)
    return impact.law.force(impact.memory, delta, state[2] - state[3], phase.approaching)


@small
def uncapped(impact, phase, state):
    """The law's force without cap or cut."""
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    return impact.law.force(impact.memory, delta, state[2] - state[3], phase.approaching)


@small
def slopes(impact, phase, s, state, desk, row):
    """d(state)/ds = 4 s³ d(state)/dt into a row: u, v of both buildings, work, impulse, energy put in."""
    left, right = impact.left, impact.right
    force = transmitted(impact, phase, state)
    cube = s * s * s
    clock = 4.0 * cube
    drive_left = -left.ground * phase.ground.left_at(cube * s) - left.fade * state[2]
    drive_right = -phase.ground.across_at(right, cube * s) - right.fade * state[3]
    desk[row, 0] = clock * state[2]
    desk[row, 1] = clock * state[3]
    desk[row, 2] = clock * ((drive_left - left.spring * state[0]) - left.inverse_mass * force)
    desk[row, 3] = clock * ((drive_right - right.spring * state[1]) + right.inverse_mass * force)
    desk[row, 4] = clock * force * (state[2] - state[3])
    desk[row, 5] = clock * force
    put_in = left.mass * state[2] * drive_left + right.mass * state[3] * drive_right
    desk[row, 6] = clock * (put_in - phase.ground.taken_along(right, force, state[3]))


@small
def state_of(desk, row):
    """(u_left, u_right, v_left, v_right) from a row."""
    return desk[row, 0], desk[row, 1], desk[row, 2], desk[row, 3]


@small
def trial_state(table, h, desk):
    """The state at a stage whose row of the table is given."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    place = 0
    while desk[table, place] >= 0.0:
        weight = desk[table, place + 1]
        u, w, v, z = state_of(desk, STAGES + int(desk[table, place]))
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        place += 2
    u, w, v, z = state_of(desk, STATE)
    return u + h * a, w + h * b, v + h * c, z + h * d


@part
def explicit_attempt(impact, phase, s, h, desk):
    """One step of the tableau from row STATE, whose slopes are in row STAGES, to row END; returns its error.

    The error is that of the embedded pair (for DOP853, Hairer's 8(5,3)), in units of the contact's scales of
    penetration and speed. The table is read from the desk: written out in the code it is no faster and takes ten
    times as long to compile, and sums of a known length fall to LLVM's loop vectoriser, which makes them half as
    fast again.
    """
    k = STAGES
    desk[TALLY, WORKED] += desk[FINAL, COUNTED]
    for stage in range(1, int(desk[FINAL, COUNTED])):
        trial = trial_state(TABLE + stage, h, desk)
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
    for column, change in enumerate((a, b, c, d, work, impulse, power)):
        desk[END, column] = desk[STATE, column] + h * change
    if desk[FINAL, END_WEIGHT] != 0.0:
        finish(impact, phase, s + h, desk)
        weight = desk[FINAL, END_WEIGHT]
        u, w, v, z = state_of(desk, LAST)
        a5, b5, c5, d5 = a5 + weight * u, b5 + weight * w, c5 + weight * v, d5 + weight * z
    deep, fast = h / impact.depth, h / impact.speed
    fifth = deep * deep * (a5 * a5 + b5 * b5) + fast * fast * (c5 * c5 + d5 * d5)
    third = deep * deep * (a3 * a3 + b3 * b3) + fast * fast * (c3 * c3 + d3 * d3)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@small
def finish(impact, phase, s, desk):
    """Slopes at the end of a step, into row LAST."""
    slopes(impact, phase, s, state_of(desk, END), desk, LAST)


@part
def explicit_spread(impact, phase, span, desk):
    """The polynomial between both ends of the step just made, ``span`` = (s, h); rows END and LAST are its end's.

    With x from 0 to 1: y = y0 + x (P0 + (1−x) (P1 + x (P2 + (1−x) (P3 + ...)))), Hairer's continuous extension.
    """
    s, h = span
    for late in range(int(desk[FINAL, LATES])):
        trial = trial_state(LATE + late, h, desk)
        slopes(impact, phase, s + desk[LATE + late, NODE] * h, trial, desk, LAST + 1 + late)
    for column in range(4):
        change = desk[END, column] - desk[STATE, column]
        desk[POLYNOMIAL, column] = change
        desk[POLYNOMIAL + 1, column] = h * desk[STAGES, column] - change
        desk[POLYNOMIAL + 2, column] = 2.0 * change - h * (desk[STAGES, column] + desk[LAST, column])
    for row in range(TERMS - 3):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        place = 0
        while desk[BETWEEN + row, place] >= 0.0:
            weight = desk[BETWEEN + row, place + 1]
            u, w, v, z = state_of(desk, STAGES + int(desk[BETWEEN + row, place]))
            a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
            place += 2
        for column, value in enumerate((a, b, c, d)):
            desk[POLYNOMIAL + 3 + row, column] = h * value


@small
def state_between(x, desk):
    """The state at a place x of the step, 0 to 1, on the polynomial."""
    rest = 1.0 - x
    a, b, c, d = state_of(desk, POLYNOMIAL + TERMS - 1)
    for back in range(1, TERMS):
        row = TERMS - 1 - back
        factor = rest if row % 2 == 0 else x
        u, w, v, z = state_of(desk, POLYNOMIAL + row)
        a, b, c, d = u + factor * a, w + factor * b, v + factor * c, z + factor * d
    u, w, v, z = state_of(desk, STATE)
    return u + x * a, w + x * b, v + x * c, z + x * d


@small
def nudged(state, desk, row, nudge):
    """The state a little further along its slopes."""
    return (
        state[0] + nudge * desk[row, 0],
        state[1] + nudge * desk[row, 1],
        state[2] + nudge * desk[row, 2],
        state[3] + nudge * desk[row, 3],
    )


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


@small
def next_step(h, error, rtol, desk):
    """Step length from the last one: 0.9 (SHARE rtol / error)^(1/order), kept within 1/5 and 5."""
    if error == 0.0:
        return 5.0 * h
    left = SHARE * rtol / error
    # Roots are several times faster than a power, and this is the usual method's.
    change = sqrt(sqrt(sqrt(left))) if desk[FINAL, POWER] == 0.125 else left ** desk[FINAL, POWER]
    return h * min(5.0, max(0.2, 0.9 * change))


@kernel
def begin(pair, fastest, law, limits, state, worn):
    """Freeze what a contact remembers of its start; returns the `Impact`, the approach speed and e.

    ``worn`` is what earlier contacts of the run have left behind.
    """
    left, right = pair
    gap, yield_force, restitution = limits
    speed = max(state[2] - state[3], 0.0)
    mass = 1.0 / (left.inverse_mass + right.inverse_mass)
    e = restitution.at(speed)
    memory = law.resume(law.begin(e, speed, mass), worn)
    strength = law.ceiling(yield_force) * law.hardening(speed)
    # Errors count against this contact's own scale, but not against less than a thousandth of the motion's.
    scale = max(speed, 1e-3 * fastest, 1e-12)
    depth = depth_of(law, 0.5 * mass * scale * scale, 1e-2 * scale)
    # δ is a difference of displacements: what they round by, the contact's stiffness turns into a speed.
    still = (1e-14 + 4.0 * ROUNDING * max(abs(state[0]), abs(state[1])) / depth) * scale
    impact = Impact(left, right, law, gap, strength, law.floor(), memory, scale, depth, still)
    return impact, speed, e
