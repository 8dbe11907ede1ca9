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

from pounding_risk._jit import kernel, small
from pounding_risk.core.series import END, STAGES, STATE
from pounding_risk.models.structures import Oscillator
from pounding_risk.models.tableau import DOP853

LAST = STAGES + len(DOP853.nodes)  # row of the slopes at the end of a step
# The tableau on the desk, sparse: a row for each stage with pairs (earlier stage, weight), then a row with the final
# weights and both error weights, (stage, weight, fifth, third); −1 ends a row. A stage's node stands in column NODE.
TABLE = LAST + 1
FINAL = TABLE + len(DOP853.nodes)
NODE = 60
DESK = (FINAL + 1, 64)

# A run takes hundreds of steps whose errors add up: each may spend this share of the tolerance, so that the energy of
# all shipped scenes closes to the tolerance itself.
SHARE = 0.05

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


@small
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
def next_step(h, error, rtol):
    """Step length from the last one: 0.9 (SHARE rtol / error)^(1/8), kept within 1/5 and 5."""
    if error == 0.0:
        return 5.0 * h
    return h * min(5.0, max(0.2, 0.9 * sqrt(sqrt(sqrt(SHARE * rtol / error)))))


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
