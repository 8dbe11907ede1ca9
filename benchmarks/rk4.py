"""The plain way: classical Runge-Kutta of order 4 with a fixed step, no event handling, compiled by the same numba.

    m ü + 2 ζ ω m u̇ + ω² m u = −m a_g(t) ∓ F(δ, δ̇)

a_g is linear between samples and every sample is divided into equal steps, so that no step straddles a kink of the
ground motion. The force is asked for wherever δ > 0; touches, yielding and separation fall where they fall, and
peaks are the largest values at the steps.
"""

from __future__ import annotations

import numpy as np

from pounding_risk._jit import kernel

OUTPUTS = ("peak_relative_displacement", "peak_contact_force", "impact_count")


@kernel
def contact_force(law, memory, strength, delta, rate):
    """The law's force at one instant: nothing when apart, never more than its plateau."""
    if delta <= 0.0:
        return 0.0
    force = law.force(memory, delta, rate, rate > 0.0)
    return law.plateau(delta, strength) if force > strength else force


@kernel
def derivative(pair, law, contact, a_g, state):
    """d(u_left, u_right, v_left, v_right)/dt; ``contact`` = (gap, damping constant, yield force)."""
    left, right = pair
    gap, memory, strength = contact
    force = contact_force(law, memory, strength, state[0] - state[1] - gap, state[2] - state[3])
    return (
        state[2],
        state[3],
        -left.ground * a_g - left.fade * state[2] - left.spring * state[0] - left.inverse_mass * force,
        -right.ground * a_g - right.fade * state[3] - right.spring * state[1] + right.inverse_mass * force,
    )


@kernel
def moved(state, slope, h):
    """state + h slope."""
    return (
        state[0] + h * slope[0],
        state[1] + h * slope[1],
        state[2] + h * slope[2],
        state[3] + h * slope[3],
    )


@kernel
def rk4_step(pair, law, contact, grounds, h, state):
    """One step; ``grounds`` are a_g at its start, middle and end."""
    k1 = derivative(pair, law, contact, grounds[0], state)
    k2 = derivative(pair, law, contact, grounds[1], moved(state, k1, 0.5 * h))
    k3 = derivative(pair, law, contact, grounds[1], moved(state, k2, 0.5 * h))
    k4 = derivative(pair, law, contact, grounds[2], moved(state, k3, h))
    sixth = h / 6.0
    return (
        state[0] + sixth * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]),
        state[1] + sixth * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
        state[2] + sixth * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2]),
        state[3] + sixth * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3]),
    )


@kernel
def march_rk4(pair, law, limits, ground, dt, parts, out):
    """One run from rest; ``limits`` = (gap, yield force, restitution), ``parts`` steps a sample, ``out`` as OUTPUTS."""
    gap, yield_force, restitution = limits
    strength = law.ceiling(yield_force)
    mass = 1.0 / (pair[0].inverse_mass + pair[1].inverse_mass)
    state, memory, touching = (0.0, 0.0, 0.0, 0.0), 0.0, False
    reach, peak, count = 0.0, 0.0, 0.0
    h = dt / parts
    for sample in range(ground.size - 1):
        start, rise = ground[sample], ground[sample + 1] - ground[sample]
        for part in range(parts):
            grounds = (
                start + rise * (part / parts),
                start + rise * ((part + 0.5) / parts),
                start + rise * ((part + 1.0) / parts),
            )
            if not touching:
                # Should a touch fall into this step, the speed at its start is the approach speed.
                speed = state[2] - state[3]
                memory = law.begin(restitution.at(max(speed, 0.0)), max(speed, 0.0), mass)
            contact = (gap, memory, strength)
            state = rk4_step(pair, law, contact, grounds, h, state)
            closing, rate = state[0] - state[1], state[2] - state[3]
            reach = max(reach, abs(closing))
            if closing > gap:
                peak = max(peak, contact_force(law, memory, strength, closing - gap, rate))
                count += 0.0 if touching else 1.0
            touching = closing > gap
    out[0], out[1], out[2] = reach, peak, count


def solve_rk4(pair, interface, acceleration, dt: float, h: float) -> dict[str, float]:
    """One run with steps of about ``h`` [s], a whole number of them a sample; `OUTPUTS` in SI units."""
    out = np.zeros(len(OUTPUTS))
    limits = (float(interface.gap), float(interface.yield_force), interface.restitution)
    parts = max(1, round(dt / h))
    march_rk4(pair, interface.law, limits, np.asarray(acceleration, dtype=float), float(dt), parts, out)
    return dict(zip(OUTPUTS, out.tolist(), strict=True))
