"""The plain way: steps of one length, no event handling, compiled by the same numba as the solver.

    m ü + 2 ζ ω m u̇ + ω² m u = −m a_g(t) ∓ F(δ, δ̇)

a_g is linear between samples and every sample is divided into equal steps, so that no step straddles a kink of the
ground motion. The force is evaluated wherever δ > 0; touches, yielding and separation fall where they fall. A contact's
damping constant is that of the speed at the start of the step in which the touch falls. Peaks are the largest
values at steps; the first touch is put where the line between two steps crosses the gap.
"""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.compile import kernel, speaks
from pounding_risk.lab.baselines.steppers import CentralDifference, Contact, Newmark, Rk4, contact_force, uncapped_force

# The columns of one run.
REACH, CLOSING, FORCE, DEMAND, COUNT, FIRST, TOUCHING, UNSTABLE = range(8)
COLUMNS = 8


@speaks
class Stepper(Protocol):
    """The methods of a stepper; a state is (u_left, u_right, v_left, v_right, and two numbers of its own)."""

    def ready(self, pair, a_g, h):
        """The state at rest before the first step, of ``h`` [s]; ``a_g`` [m/s²] is the ground's acceleration then."""

    def advance(self, pair, law, contact, grounds, h, state):
        """The state one step of h [s] later; ``grounds`` are a_g at its start, middle and end."""


class Ground(NamedTuple):
    """A ground motion and how each of its samples is divided."""

    acceleration: np.ndarray  # m/s²
    dt: float  # between samples [s]
    parts: int  # steps a sample


STEPPERS = {"newmark": Newmark(), "central_difference": CentralDifference(), "rk4": Rk4()}


@kernel
def damping(pair, law, restitution, state):
    """The damping constant of a contact that this state, just before it, leads to."""
    speed = max(state[2] - state[3], 0.0)
    return law.begin(restitution.at(speed), speed, 1.0 / (pair[0].inverse_mass + pair[1].inverse_mass))


@kernel
def march_fixed(stepper, pair, law, limits, ground, out):
    """One run from rest; ``limits`` = (gap, yield force, restitution), ``ground`` a `Ground`, ``out`` (COLUMNS,).

    A motion that is not finite ends the run, which is then UNSTABLE.
    """
    gap, yield_force, restitution = limits
    a_g, dt, parts = ground
    strength, least = law.ceiling(yield_force), law.floor()
    h, share = dt / parts, 1.0 / parts
    state, contact = stepper.ready(pair, a_g[0], h), Contact(gap, strength, least, nan)
    touching = False
    reach, closest, peak, demand, count, first, steps = 0.0, 0.0, 0.0, 0.0, 0.0, nan, 0.0
    out[UNSTABLE] = 0.0
    for sample in range(a_g.size - 1):
        start, rise = a_g[sample], a_g[sample + 1] - a_g[sample]
        for part in range(parts):
            x = part * share
            grounds = start + rise * x, start + rise * (x + 0.5 * share), start + rise * (x + share)
            previous = state
            state = stepper.advance(pair, law, contact, grounds, h, previous)
            closing = state[0] - state[1]
            # While open, the damping constant is NaN: a step whose force needs it is NaN, and is computed again.
            if not (touching or closing <= gap):
                contact = Contact(gap, strength, least, damping(pair, law, restitution, previous))
                state = stepper.advance(pair, law, contact, grounds, h, previous)
                closing = state[0] - state[1]
            reach, closest = max(reach, abs(closing)), max(closest, closing)
            if closing > gap:
                rate = state[2] - state[3]
                demand = max(demand, uncapped_force(law, contact, closing - gap, rate))
                peak = max(peak, contact_force(law, contact, closing - gap, rate))
                steps += 1.0
                if not touching:
                    count += 1.0
                    if count == 1.0:
                        open_gap = gap - (previous[0] - previous[1])
                        first = sample * dt + h * (part + open_gap / (open_gap + closing - gap))
                touching = True
            elif touching or contact.memory == contact.memory:
                contact = Contact(gap, strength, least, nan)
                touching = False
        if not abs(state[0]) + abs(state[1]) + abs(state[2]) + abs(state[3]) < inf:
            out[UNSTABLE] = 1.0
            break
    out[REACH], out[CLOSING], out[FORCE], out[DEMAND] = reach, closest, peak, demand
    out[COUNT], out[FIRST], out[TOUCHING] = count, first, steps


@kernel
def sweep_fixed(stepper, pair, law, grid, ground, out):
    """Every gap and yield force of one law under one motion; ``grid`` as in `pair.grid`, ``out`` (…, …, COLUMNS)."""
    gaps, yield_forces, restitution = grid
    for g in range(gaps.size):
        for f in range(yield_forces.size):
            march_fixed(stepper, pair, law, (gaps[g], yield_forces[f], restitution), ground, out[g, f])


def divided(acceleration: np.ndarray, dt: float, h: float) -> Ground:
    """A ground motion [m/s²] sampled every ``dt`` [s], in steps of about ``h`` [s], a whole number of them a sample."""
    return Ground(np.ascontiguousarray(acceleration, dtype=np.float64), float(dt), max(1, round(dt / h)))
