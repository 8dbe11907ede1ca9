"""The central difference method, explicit: displacements at the steps, velocities half a step between them.

    v⁺ = ((1 − ζωh) v⁻ + h (−a_g − ω² u ∓ F/m)) / (1 + ζωh),   u' = u + h v⁺

The structures' dampers act on the mean of both velocities, which costs no iteration as each building has its own;
the contact's damper acts on v⁻, the last velocity known, as is usual in explicit codes. Stable in free vibration
for h < 2/ω.
"""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.lab.baselines.force import contact_force


@small
def next_velocity(oscillator, a_g, h, displacement, speed, push):
    """The velocity half a step later; ``push`` is the contact's acceleration of this building [m/s²]."""
    damp = 0.5 * h * oscillator.two_zeta_omega
    pull = -oscillator.ground * a_g - oscillator.omega2 * displacement + push
    return ((1.0 - damp) * speed + h * pull) / (1.0 + damp)


class CentralDifference(NamedTuple):
    """Leap-frog: the velocities of the state are those half a step back."""

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
