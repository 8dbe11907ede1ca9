"""Newmark's method (1959), implicit; with β = 1/4, γ = 1/2 the average acceleration of structural dynamics.

    u' = u + h v + h² ((1/2 − β) a + β a'),   v' = v + h ((1 − γ) a + γ a'),   a' = −a_g' − 2 ζ ω v' − ω² u' ∓ F'/m

Given the contact force F' at the end of the step everything else is linear, and penetration and rate there fall
with F'. What is left to solve is one equation in one number, F' = law(δ − c_δ F', δ̇ − c_v F').
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from pounding_risk._jit.compile import kernel, small
from pounding_risk.lab.baselines.force import contact_force

CLOSE = 1e-14  # of the largest force in the bracket: as far as rounding goes
MOST_TRIALS = 100


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
    previous_force, previous_miss = (
        full,
        full - contact_force(law, contact, delta - c_depth * full, rate - c_rate * full),
    )
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
    """Average acceleration: implicit, stable for any step in free vibration; the accelerations are carried along."""

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
