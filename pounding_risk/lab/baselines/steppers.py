"""The contact force as a method without events sees it, and three methods with fixed steps for a pair."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from pounding_risk._jit.compile import kernel, small

CLOSE = 1e-14  # of the largest force in the bracket: as far as rounding goes
MOST_TRIALS = 100


class Contact(NamedTuple):
    """What stays the same during one step of a fixed-step method."""

    gap: float  # m
    strength: float  # force at which the law yields, inf without a cap [N]
    least: float  # smallest force, −inf where tension is not cut [N]
    memory: float  # damping constant of this contact; NaN while it is open


@small
def uncapped_force(law, contact, delta, rate):
    """The law's force without cap or cut [N]; nothing while open."""
    return law.force(contact.memory, delta, rate, rate > 0.0) if delta > 0.0 else 0.0


@small
def contact_force(law, contact, delta, rate):
    """The force that the buildings feel [N]: at most the law's plateau, never below its floor."""
    force = uncapped_force(law, contact, delta, rate)
    if force > contact.strength:
        return law.plateau(delta, contact.strength)
    return contact.least if force < contact.least else force


@kernel
def solve_force(law, contact, reach, guess):
    """The F with F = law(δ − c_δ F, δ̇ − c_v F); ``reach`` = (δ, δ̇, c_δ, c_v), δ and δ̇ without any force.

    The secant rule, kept inside a bracket and to steps that halve every other time, else bisection: law(...) falls as
    F grows, so the root lies between 0 and the force that the full penetration would give. ``guess`` is the force of
    the last step.
    """
    delta, rate, c_depth, c_rate = reach
    full = contact_force(law, contact, delta, rate)
    # NaN, an unknown damping constant, goes straight back to the caller.
    if not (full > 0.0 or full < 0.0):
        return full
    low, high = min(full, 0.0), max(full, 0.0)
    close = CLOSE * (high - low)
    previous_force = full
    previous_miss = full - contact_force(law, contact, delta - c_depth * full, rate - c_rate * full)
    force = guess if low < guess < high else 0.5 * full
    length, previous_length = inf, inf  # lengths of the steps before
    for _ in range(MOST_TRIALS):
        miss = force - contact_force(law, contact, delta - c_depth * force, rate - c_rate * force)
        if miss == 0.0:
            return force
        if miss > 0.0:
            high = force
        else:
            low = force
        step = miss * (force - previous_force) / (miss - previous_miss) if miss != previous_miss else inf
        if not low < force - step < high or abs(step) > 0.5 * previous_length:
            step = force - 0.5 * (low + high)
        previous_force, previous_miss = force, miss
        length, previous_length = abs(step), length
        force -= step
        if length <= close:
            break
    return force


@small
def acceleration(oscillator, a_g, displacement, velocity):
    """−a_g − 2 ζ ω v − ω² u [m/s²]."""
    return -oscillator.ground * a_g - oscillator.two_zeta_omega * velocity - oscillator.omega2 * displacement


class Newmark(NamedTuple):
    """Newmark's method (1959), implicit; with β = 1/4, γ = 1/2 the average acceleration of structural dynamics.

        u' = u + h v + h² ((1/2 − β) a + β a'),   v' = v + h ((1 − γ) a + γ a'),   a' = −a_g' − 2 ζ ω v' − ω² u' ∓ F'/m

    Given the contact force F' at the end of the step everything else is linear, and penetration and rate there fall
    with F'. What is left to solve is one equation in one number, F' = law(δ − c_δ F', δ̇ − c_v F'). Stable for any step
    in free vibration; the accelerations are carried along.
    """

    beta: float = 0.25
    gamma: float = 0.5
    order: float = 2.0  # where the motion is smooth

    def ready(self, pair, a_g, h):
        return (0.0, 0.0, 0.0, 0.0, -pair[0].ground * a_g, -pair[1].ground * a_g)

    def advance(self, pair, law, contact, grounds, h, state):
        left, right = pair
        bend, rise = self.beta * h * h, self.gamma * h
        early, late = (0.5 - self.beta) * h * h, (1.0 - self.gamma) * h
        u_left = state[0] + h * state[2] + early * state[4]
        u_right = state[1] + h * state[3] + early * state[5]
        v_left, v_right = state[2] + late * state[4], state[3] + late * state[5]
        stiff_left = 1.0 / (1.0 + rise * left.two_zeta_omega + bend * left.omega2)
        stiff_right = 1.0 / (1.0 + rise * right.two_zeta_omega + bend * right.omega2)
        a_left = stiff_left * acceleration(left, grounds[2], u_left, v_left)
        a_right = stiff_right * acceleration(right, grounds[2], u_right, v_right)
        yields_left, yields_right = stiff_left * left.inverse_mass, stiff_right * right.inverse_mass
        end_depth = u_left - u_right + bend * (a_left - a_right) - contact.gap
        force = 0.0
        if end_depth > 0.0:
            rate = v_left - v_right + rise * (a_left - a_right)
            give = yields_left + yields_right
            start_depth = state[0] - state[1] - contact.gap
            guess = contact_force(law, contact, start_depth, state[2] - state[3])
            force = solve_force(law, contact, (end_depth, rate, bend * give, rise * give), guess)
            a_left -= yields_left * force
            a_right += yields_right * force
        return (
            u_left + bend * a_left,
            u_right + bend * a_right,
            v_left + rise * a_left,
            v_right + rise * a_right,
            a_left,
            a_right,
        )


@small
def next_velocity(oscillator, a_g, h, displacement, speed, push):
    """The velocity half a step later; ``push`` is the contact's acceleration of this building [m/s²]."""
    damp = 0.5 * h * oscillator.two_zeta_omega
    pull = -oscillator.ground * a_g - oscillator.omega2 * displacement + push
    return ((1.0 - damp) * speed + h * pull) / (1.0 + damp)


class CentralDifference(NamedTuple):
    """The central difference method, explicit: the velocities of the state are those half a step back.

        v⁺ = ((1 − ζωh) v⁻ + h (−a_g − ω² u ∓ F/m)) / (1 + ζωh),   u' = u + h v⁺

    The structures' dampers act on the mean of both velocities, which costs no iteration as each building has its own;
    the contact's damper acts on v⁻, the last velocity known, as is usual in explicit codes. Stable in free vibration
    for h < 2/ω.
    """

    order: float = 2.0  # where the motion is smooth

    def ready(self, pair, a_g, h):
        # At rest at the start: half a step earlier the velocity was −(h/2) a, a = −a_g.
        return (0.0, 0.0, 0.5 * h * pair[0].ground * a_g, 0.5 * h * pair[1].ground * a_g, 0.0, 0.0)

    def advance(self, pair, law, contact, grounds, h, state):
        left, right = pair
        force = contact_force(law, contact, state[0] - state[1] - contact.gap, state[2] - state[3])
        v_left = next_velocity(left, grounds[0], h, state[0], state[2], -left.inverse_mass * force)
        v_right = next_velocity(right, grounds[0], h, state[1], state[3], right.inverse_mass * force)
        return (state[0] + h * v_left, state[1] + h * v_right, v_left, v_right, 0.0, 0.0)


@small
def derivative(pair, law, contact, a_g, state):
    """d/dt of the state (u_left, u_right, v_left, v_right) [m/s, m/s²] under ``a_g`` [m/s²]."""
    left, right = pair
    force = contact_force(law, contact, state[0] - state[1] - contact.gap, state[2] - state[3])
    return (
        state[2],
        state[3],
        -left.ground * a_g - left.two_zeta_omega * state[2] - left.omega2 * state[0] - left.inverse_mass * force,
        -right.ground * a_g - right.two_zeta_omega * state[3] - right.omega2 * state[1] + right.inverse_mass * force,
    )


@small
def state_along_slope(state, slope, h):
    """The state after a time h at a constant slope: state + h slope."""
    return (state[0] + h * slope[0], state[1] + h * slope[1], state[2] + h * slope[2], state[3] + h * slope[3])


class Rk4(NamedTuple):
    """Classical Runge-Kutta of order 4 (Kutta 1901): four evaluations of the contact force a step.

    The pair as four equations of first order, u̇ = v, v̇ = −a_g − 2 ζ ω v − ω² u ∓ F/m; nothing else is carried along.
    """

    order: float = 4.0  # where the motion is smooth

    def ready(self, pair, a_g, h):
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def advance(self, pair, law, contact, grounds, h, state):
        k1 = derivative(pair, law, contact, grounds[0], state)
        k2 = derivative(pair, law, contact, grounds[1], state_along_slope(state, k1, 0.5 * h))
        k3 = derivative(pair, law, contact, grounds[1], state_along_slope(state, k2, 0.5 * h))
        k4 = derivative(pair, law, contact, grounds[2], state_along_slope(state, k3, h))
        sixth = h / 6.0
        return (
            state[0] + sixth * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]),
            state[1] + sixth * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
            state[2] + sixth * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2]),
            state[3] + sixth * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3]),
            0.0,
            0.0,
        )
