"""Classical Runge-Kutta of order 4 (Kutta 1901): four evaluations of the contact force a step."""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.lab.baselines.force import contact_force


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
    return (
        state[0] + h * slope[0],
        state[1] + h * slope[1],
        state[2] + h * slope[2],
        state[3] + h * slope[3],
    )


class Rk4(NamedTuple):
    """The pair as four equations of first order: u̇ = v, v̇ = −a_g − 2 ζ ω v − ω² u ∓ F/m.

    Nothing is carried from step to step but the state itself.
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
