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

from math import inf, sqrt
from typing import NamedTuple

from pounding_risk._jit.compile import by_verb, kernel, small
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.solver.counters import WORKED
from pounding_risk.solver.workspace import BEGIN, END, FELT, FIRST_STAGE, LAST, TERMS

# A run takes hundreds of steps whose errors add up: each may spend this share of the tolerance, so that the energy of
# all shipped scenes closes to the tolerance itself.
SHARE = 0.05

# What comes back of a contact is e times what came: its own error must stay this small a part of it.
REBOUND_SHARE = 0.1
ROUNDING = 1e-15  # of a displacement
ROW_BITS = 31  # no fewer than rows of slopes

SLACK, ELASTIC, YIELDING = -1, 0, 1  # force cut at zero, uncapped, on the plateau


class Limits(NamedTuple):
    """Gap, yield force and restitution of one run at the contact."""

    gap: float  # m
    yield_force: float  # N, inf never yields
    restitution: Restitution


class Impact(NamedTuple):
    """Quantities that are constant during one contact."""

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
    """Branch of the law and ground motion, constant during one step."""

    approaching: bool
    region: int
    ground: tuple  # under the buildings, of the types in `models.effects.ground`, its clock begins at the touch


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
def slopes(impact, phase, s, state, workspace, row):
    """Write d(state)/ds = 4 s³ d(state)/dt, of u, v, work, impulse and energy put in, and the force, to a row."""
    left, right = impact.left, impact.right
    force = transmitted(impact, phase, state)
    cube = s * s * s
    clock = 4.0 * cube
    slope = workspace.slopes
    drive_left = -left.ground * phase.ground.left_at(cube * s) - left.two_zeta_omega * state[2]
    drive_right = -phase.ground.across_at(right, cube * s) - right.two_zeta_omega * state[3]
    slope[row, 0] = clock * state[2]
    slope[row, 1] = clock * state[3]
    slope[row, 2] = clock * ((drive_left - left.omega2 * state[0]) - left.inverse_mass * force)
    slope[row, 3] = clock * ((drive_right - right.omega2 * state[1]) + right.inverse_mass * force)
    slope[row, 4] = clock * force * (state[2] - state[3])
    slope[row, 5] = clock * force
    put_in = left.mass * state[2] * drive_left + right.mass * state[3] * drive_right
    slope[row, 6] = clock * (put_in - phase.ground.taken_along(right, force, state[3]))
    slope[row, FELT] = force


@small
def state_of(rows, row):
    """(u_left, u_right, v_left, v_right) from a row of states or of slopes."""
    return rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3]


@small
def row_of(number):
    """A row of slopes from its number in the tableau.

    The mask changes nothing: it tells the compiler that no row is counted from the end, which it would look for at
    every one.
    """
    return int(number) & ROW_BITS


@small
def trial_state(weights, row, h, workspace):
    """The state at a stage whose row of the tableau is given."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    place = 0
    while weights[row, place] >= 0.0:
        weight = weights[row, place + 1]
        u, w, v, z = state_of(workspace.slopes, row_of(weights[row, place]))
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        place += 2
    u, w, v, z = state_of(workspace.states, BEGIN)
    return u + h * a, w + h * b, v + h * c, z + h * d


@small
def explicit_attempt(impact, phase, s, h, workspace):
    """One step of the tableau from the state BEGIN, whose slopes are known, to END; returns its error.

    The error is that of the embedded pair (for DOP853, Hairer's 8(5,3)), in units of the contact's scales of
    penetration and speed. The tableau is read from an array: written out in the code it is no faster and takes ten
    times as long to compile, and sums of a known length fall to LLVM's loop vectoriser, which makes them half as
    fast again.
    """
    tableau = workspace.tableau
    final = tableau.final
    workspace.counters[WORKED] += tableau.stage_count
    for stage in range(1, int(tableau.stage_count)):
        trial = trial_state(tableau.stages, stage, h, workspace)
        slopes(impact, phase, s + tableau.stage_nodes[stage] * h, trial, workspace, stage)
    a, b, c, d, work, impulse, power = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    a5, b5, c5, d5, a3, b3, c3, d3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    place = 0
    while final[place] >= 0.0:
        row = row_of(final[place])
        weight, fifth, third = final[place + 1], final[place + 2], final[place + 3]
        u, w, v, z = state_of(workspace.slopes, row)
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        a5, b5, c5, d5 = a5 + fifth * u, b5 + fifth * w, c5 + fifth * v, d5 + fifth * z
        a3, b3, c3, d3 = a3 + third * u, b3 + third * w, c3 + third * v, d3 + third * z
        work += weight * workspace.slopes[row, 4]
        impulse += weight * workspace.slopes[row, 5]
        power += weight * workspace.slopes[row, 6]
        place += 4
    for column, change in enumerate((a, b, c, d, work, impulse, power)):
        workspace.states[END, column] = workspace.states[BEGIN, column] + h * change
    if tableau.end_weight != 0.0:
        finish(impact, phase, s + h, workspace)
        weight = tableau.end_weight
        u, w, v, z = state_of(workspace.slopes, LAST)
        a5, b5, c5, d5 = a5 + weight * u, b5 + weight * w, c5 + weight * v, d5 + weight * z
    deep, fast = h / impact.depth, h / impact.speed
    fifth = deep * deep * (a5 * a5 + b5 * b5) + fast * fast * (c5 * c5 + d5 * d5)
    third = deep * deep * (a3 * a3 + b3 * b3) + fast * fast * (c3 * c3 + d3 * d3)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@small
def finish(impact, phase, s, workspace):
    """Write the slopes at the end of a step to row LAST."""
    slopes(impact, phase, s, state_of(workspace.states, END), workspace, LAST)


@small
def explicit_spread(impact, phase, span, workspace):
    """Write the polynomial between both ends of the step just made, ``span`` = (s, h).

    With x from 0 to 1: y = y0 + x (P0 + (1−x) (P1 + x (P2 + (1−x) (P3 + ...)))), Hairer's continuous extension.
    """
    s, h = span
    tableau, states, polynomial = workspace.tableau, workspace.states, workspace.polynomial
    for late in range(int(tableau.late_count)):
        trial = trial_state(tableau.late, late, h, workspace)
        slopes(impact, phase, s + tableau.late_nodes[late] * h, trial, workspace, LAST + 1 + late)
    for column in range(4):
        change = states[END, column] - states[BEGIN, column]
        start, end = workspace.slopes[FIRST_STAGE, column], workspace.slopes[LAST, column]
        polynomial[0, column] = change
        polynomial[1, column] = h * start - change
        polynomial[2, column] = 2.0 * change - h * (start + end)
    for row in range(TERMS - 3):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        place = 0
        while tableau.polynomial[row, place] >= 0.0:
            weight = tableau.polynomial[row, place + 1]
            u, w, v, z = state_of(workspace.slopes, row_of(tableau.polynomial[row, place]))
            a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
            place += 2
        for column, value in enumerate((a, b, c, d)):
            polynomial[3 + row, column] = h * value


@small
def state_between(x, workspace):
    """The state at a place x of the step, 0 to 1, on the polynomial."""
    rest = 1.0 - x
    a, b, c, d = state_of(workspace.polynomial, TERMS - 1)
    for back in range(1, TERMS):
        row = TERMS - 1 - back
        factor = rest if row % 2 == 0 else x
        u, w, v, z = state_of(workspace.polynomial, row)
        a, b, c, d = u + factor * a, w + factor * b, v + factor * c, z + factor * d
    u, w, v, z = state_of(workspace.states, BEGIN)
    return u + x * a, w + x * b, v + x * c, z + x * d


@small
def nudged(state, slope, row, nudge):
    """The state a little further along its slopes."""
    return (
        state[0] + nudge * slope[row, 0],
        state[1] + nudge * slope[row, 1],
        state[2] + nudge * slope[row, 2],
        state[3] + nudge * slope[row, 3],
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
    strain = left.mass * left.omega2 * state[0] ** 2 + right.mass * right.omega2 * state[1] ** 2
    return 0.5 * (kinetic + strain)


@small
def next_step(h, error, rtol, tableau):
    """Step length from the last one: 0.9 (SHARE rtol / error)^(1/order), kept within 1/5 and 5."""
    if error == 0.0:
        return 5.0 * h
    share = SHARE * rtol / error
    # Roots are several times faster than a power, and this is the usual method's.
    change = sqrt(sqrt(sqrt(share))) if tableau.exponent == 0.125 else share**tableau.exponent
    return h * min(5.0, max(0.2, 0.9 * change))


@small
def starts_itself(law, e, speed, mass, worn, limit, scale):
    """(memory, force at which the law yields, smallest force, scale of penetration) of a contact that begins.

    ``worn`` is the damage that earlier contacts have left, ``limit`` the yield force, ``scale`` that of the velocity.
    """
    memory = law.resume(law.begin(e, speed, mass), worn)
    strength = law.ceiling(limit) * law.hardening(speed)
    return memory, strength, law.floor(), depth_of(law, 0.5 * mass * scale * scale, 1e-2 * scale)


@small
def turns_itself(law, memory, delta, strength, approaching, yielding):
    """(memory, dent, energy lost) once the motion has turned at δ; a dent below zero leaves the gap as it is."""
    memory = law.turned(memory, delta, approaching)
    if approaching:
        changed, dent, taken = law.turn(memory, delta, strength) if yielding else law.crushed(memory, delta)
        if dent >= 0.0:
            return changed, dent, taken
    return memory, -1.0, 0.0


@small
def ends_itself(law, memory, delta, strength, work, lost):
    """(loss, the part of it that hysteresis takes, damage left behind) of a contact that parts.

    ``work`` is that of its force, ``lost`` what dents have taken of it.
    """
    loss = work - law.held(memory, delta, strength) - lost
    return loss, law.yielded(loss), law.worn(memory)


@small
def starts_called(law, e, speed, mass, worn, limit, scale):
    """As `starts_itself`, of a law by address."""
    return law.begin_contact(e, speed, mass, worn, limit, scale)


@small
def turns_called(law, memory, delta, strength, approaching, yielding):
    """As `turns_itself`, of a law by address."""
    return law.turn_contact(memory, delta, strength, approaching, yielding)


@small
def ends_called(law, memory, delta, strength, work, lost):
    """As `ends_itself`, of a law by address."""
    return law.end_contact(memory, delta, strength, work, lost)


law_starts = by_verb("begin_contact", 0, starts_called, starts_itself)
law_turns = by_verb("turn_contact", 0, turns_called, turns_itself)
law_ends = by_verb("end_contact", 0, ends_called, ends_itself)


@kernel
def new_impact(pair, fastest, law, limits, state, worn):
    """The `Impact` of a contact that begins, its approach speed [m/s] and its coefficient of restitution.

    ``worn`` is the damage that earlier contacts of the run have left in the law.
    """
    left, right = pair
    gap, yield_force, restitution = limits
    speed = max(state[2] - state[3], 0.0)
    mass = 1.0 / (left.inverse_mass + right.inverse_mass)
    e = restitution.at(speed)
    # Errors count against this contact's own scale, but not against less than a thousandth of the motion's.
    scale = max(speed, 1e-3 * fastest, 1e-12)
    memory, strength, least, depth = law_starts(law, e, speed, mass, worn, yield_force, scale)
    # δ is a difference of displacements: what they round by, the contact's stiffness turns into a speed.
    still = (1e-14 + 4.0 * ROUNDING * max(abs(state[0]), abs(state[1])) / depth) * scale
    impact = Impact(left, right, law, gap, strength, least, memory, scale, depth, still)
    return impact, speed, e
