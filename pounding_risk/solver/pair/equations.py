"""Equations of motion in contact: state, quadratures and clock of the integration, and the contact as it begins.

State of the pair in contact: u_left, u_right, v_left, v_right, both seen from the ground under the left building, and
three quadratures: work of the contact force ∫ F δ̇ dt, impulse ∫ F dt, and the energy that the ground puts in less
what the structures' dampers take.

The start of a contact is not smooth in time (F ~ δ^(1/4) costs any method its order). The clock is therefore
s with τ = s⁴ since the touch: there δ^(1/4) ~ s, and the order of the method survives. Each step ends at a record
sample, or where the force changes its branch: δ̇ = 0, the uncapped force meets the yield force, the force would
turn to tension in a law that cuts it, the bodies part.
"""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.solver.pair.law_verbs import law_starts
from pounding_risk.solver.workspace import END, FELT, LAST

# A run takes hundreds of steps whose errors add up: each may spend this share of the tolerance, so that the energy of
# all shipped scenes closes to the tolerance itself.
SHARE = 0.05
# What comes back of a contact is e times what came: its own error must stay this small a part of it.
REBOUND_SHARE = 0.1
ROUNDING = 1e-15  # of a displacement
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
    least_force: float  # smallest force, −inf where tension is not cut [N]
    memory: float  # damping constant of this contact
    speed_scale: float  # scale of velocity for the error control [m/s]
    depth_scale: float  # and of penetration [m]
    still_speed: float  # speed below which the direction of the motion is rounding [m/s]
    knee_depth: float  # penetration ahead at which the slope of the force jumps, inf for none [m]


class Phase(NamedTuple):
    """Branch of the law and ground motion, constant during one step."""

    approaching: bool
    region: int
    ground: tuple  # under the buildings, of the types in `models.effects.ground`, its clock begins at the touch


@small
def transmitted(impact, phase, state):
    """Force that the buildings feel [N] in ``state`` = (u_left, u_right, v_left, v_right), on this branch."""
    if phase.region == SLACK:
        return 0.0
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    if phase.region == YIELDING:
        return impact.law.plateau(delta, impact.strength)
    return impact.law.force(impact.memory, delta, state[2] - state[3], phase.approaching)


@small
def uncapped(impact, phase, state):
    """The law's force [N] in ``state`` = (u_left, u_right, v_left, v_right), without cap or cut."""
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
def write_end_slopes(impact, phase, s, workspace):
    """Write the slopes at the end of a step to row LAST."""
    slopes(impact, phase, s, state_of(workspace.states, END), workspace, LAST)


@small
def state_along_slopes(state, slope, row, nudge):
    """``state`` moved along the slopes in row ``row`` of ``slope`` by ``nudge``, a length of the clock s."""
    return (
        state[0] + nudge * slope[row, 0],
        state[1] + nudge * slope[row, 1],
        state[2] + nudge * slope[row, 2],
        state[3] + nudge * slope[row, 3],
    )


@kernel
def energy_of(pair, state):
    """Kinetic and strain energy of both buildings in ``state`` = (u_left, u_right, v_left, v_right) [J]."""
    left, right = pair
    kinetic = left.mass * state[2] ** 2 + right.mass * state[3] ** 2
    strain = left.mass * left.omega2 * state[0] ** 2 + right.mass * right.omega2 * state[1] ** 2
    return 0.5 * (kinetic + strain)


@kernel
def new_impact(pair, fastest, law, limits, state, damage):
    """The `Impact` of a contact that begins, its approach speed [m/s] and its coefficient of restitution.

    ``damage`` is the damage that earlier contacts of the run have left in the law.
    """
    left, right = pair
    gap, yield_force, restitution = limits
    speed = max(state[2] - state[3], 0.0)
    mass = 1.0 / (left.inverse_mass + right.inverse_mass)
    e = restitution.at(speed)
    # Errors count against this contact's own scale, but not against less than a thousandth of the motion's.
    scale = max(speed, 1e-3 * fastest, 1e-12)
    memory, strength, least_force, depth, knee = law_starts(law, e, speed, mass, damage, yield_force, scale)
    # δ is a difference of displacements: what they round by, the contact's stiffness turns into a speed.
    still_speed = (1e-14 + 4.0 * ROUNDING * max(abs(state[0]), abs(state[1])) / depth) * scale
    impact = Impact(left, right, law, gap, strength, least_force, memory, scale, depth, still_speed, knee)
    return impact, speed, e
