"""The plain way for a row: steps of one length, no event handling, compiled by the same numba as the solver.

As `fixed_step` has it for a pair, with matrices in place of periods and a list of contact points: the force of
each is evaluated wherever its δ > 0, with the damping constant of its speed at the start of the step in which the touch
falls. Newmark's method and central differences invert their matrices once, building by building.
"""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel, small
from pounding_risk._jit.memory import by_address
from pounding_risk.lab.baselines import fixed_step as fixed
from pounding_risk.lab.baselines.matrices import RowMatrices
from pounding_risk.lab.baselines.steppers import Contact, Newmark, contact_force, solve_force, uncapped_force

METHODS = ("newmark", "central_difference", "rk4")
NEWMARK, CENTRAL, RK4 = range(3)
BETA, GAMMA = Newmark().beta, Newmark().gamma
ENDS = 4  # masses that a contact point joins at most
AGREED, MOST_SWEEPS = 1e-13, 200  # of the largest force, to which implicit forces at several points are solved
# Columns of `Stepping.contacts`: what of a contact point stays the same during a step.
GAP, STRENGTH, LEAST, MEMORY, CLOSED = range(5)
# Rows of `Stepping.state`: displacement, velocity and acceleration before a step and after it, then what a step needs.
U, V, A, U_AFTER, V_AFTER, A_AFTER, SPARE = range(7)
ROWS = SPARE + 8


class Stepping(NamedTuple):
    """Arrays of a row for one method and step; the inverse is Newmark's or central differences'."""

    first: np.ndarray  # of the masses of each building, or of several that links join, and D
    inverse_mass: np.ndarray  # (D,) 1/kg
    stiffness: np.ndarray  # (D, D)
    damping: np.ndarray  # (D, D)
    inverse: np.ndarray  # (D, D) of M + γ h C + β h² K, or of M + ½ h C
    give: np.ndarray  # (K, K) B · inverse · Bᵀ
    ends: np.ndarray  # (K, ENDS) masses that a contact point joins
    shares: np.ndarray  # (K, ENDS) of these; 0 where there is none
    striking: np.ndarray  # (K,) kg
    contacts: np.ndarray  # (K, 5)
    forces: np.ndarray  # (3, K) N: what the points press with, before and after, and what they did a sweep ago
    state: np.ndarray  # (ROWS, D)


def stepping(row: RowMatrices, method: str, h: float) -> Stepping:
    """The arrays of a row for a method of `METHODS` and steps of ``h`` [s], at rest, without gaps or yield forces."""
    count, points = row.mass.size, len(row.shares)
    mass = np.diag(row.mass)
    if method == "newmark":
        inverse = np.linalg.inv(mass + GAMMA * h * row.damping + BETA * h * h * row.stiffness)
    else:
        inverse = np.linalg.inv(mass + 0.5 * h * row.damping)
    ends, shares = np.zeros((points, ENDS), dtype=np.int64), np.zeros((points, ENDS))
    for k in range(points):
        joined = np.flatnonzero(row.shares[k])
        ends[k, : joined.size], shares[k, : joined.size] = joined, row.shares[k, joined]
    # Bounds of blocks across which the matrices have nothing.
    cuts = [at for at in row.first if not row.stiffness[:at, at:].any() and not row.damping[:at, at:].any()]
    return Stepping(
        np.array(cuts, dtype=np.int64),
        1.0 / row.mass,
        row.stiffness,
        row.damping,
        inverse,
        row.shares @ inverse @ row.shares.T,
        ends,
        shares,
        row.striking,
        np.zeros((points, 5)),
        np.zeros((3, points)),
        np.zeros((ROWS, count)),
    )


@small
def add_product(row, matrix, factor, vector, out):
    """Add ``factor`` · matrix · row ``vector`` of the state to row ``out``, building by building."""
    for b in range(row.first.size - 1):
        for i in range(row.first[b], row.first[b + 1]):
            total = 0.0
            for j in range(row.first[b], row.first[b + 1]):
                total += matrix[i, j] * row.state[vector, j]
            row.state[out, i] += factor * total


@small
def across(row, k, vector):
    """What row ``vector`` of the state is across contact point ``k``: left less right."""
    total = 0.0
    for end in range(row.ends.shape[1]):
        total += row.shares[k, end] * row.state[vector, row.ends[k, end]]
    return total


@small
def subtract_force(row, k, force, out):
    """Take a contact force from row ``out``: it pushes the left building back, the right one on."""
    for end in range(row.ends.shape[1]):
        row.state[out, row.ends[k, end]] -= row.shares[k, end] * force


@small
def contact_of(row, k):
    """The `Contact` of point ``k``: gap [m], yield and smallest force [N], damping constant, NaN while it is open."""
    contact = row.contacts[k]
    return Contact(contact[GAP], contact[STRENGTH], contact[LEAST], contact[MEMORY])


@kernel
def subtract_contact_forces(row, laws, u, v, out):
    """Take the contact forces of displacements and velocities in rows ``u`` and ``v`` from row ``out``."""
    for k in range(row.ends.shape[0]):
        delta = across(row, k, u) - row.contacts[k, GAP]
        if not delta <= 0.0:
            subtract_force(row, k, contact_force(laws[k], contact_of(row, k), delta, across(row, k, v)), out)


@kernel
def accelerate(row, laws, a_g, u, v, out):
    """ü of displacements and velocities in rows ``u`` and ``v``, to row ``out``."""
    row.state[out] = 0.0
    add_product(row, row.stiffness, -1.0, u, out)
    add_product(row, row.damping, -1.0, v, out)
    subtract_contact_forces(row, laws, u, v, out)
    for i in range(row.inverse_mass.size):
        row.state[out, i] = row.state[out, i] * row.inverse_mass[i] - a_g


@kernel
def advance_rk4(row, laws, grounds, h):
    """Classical Runge-Kutta of order 4: slopes of displacements in four rows from SPARE on, then of velocities."""
    state = row.state
    state[SPARE] = state[V]
    accelerate(row, laws, grounds[0], U, V, SPARE + 4)
    for stage in range(1, 4):
        part = h if stage == 3 else 0.5 * h
        for i in range(state.shape[1]):
            state[U_AFTER, i] = state[U, i] + part * state[SPARE + stage - 1, i]
            state[V_AFTER, i] = state[V, i] + part * state[SPARE + 3 + stage, i]
            state[SPARE + stage, i] = state[V_AFTER, i]
        accelerate(row, laws, grounds[2] if stage == 3 else grounds[1], U_AFTER, V_AFTER, SPARE + 4 + stage)
    for i in range(state.shape[1]):
        for slope, out in ((SPARE, U_AFTER), (SPARE + 4, V_AFTER)):
            total = state[slope, i] + 2.0 * (state[slope + 1, i] + state[slope + 2, i]) + state[slope + 3, i]
            state[out, i] = state[out - U_AFTER, i] + h / 6.0 * total


@kernel
def advance_central(row, laws, grounds, h):
    """Leap-frog: (M + ½ h C) v⁺ = (M − ½ h C) v⁻ + h (−M a_g − K u − Bᵀ F), u' = u + h v⁺; F of u and v⁻."""
    state = row.state
    state[SPARE] = 0.0
    add_product(row, row.stiffness, -h, U, SPARE)
    add_product(row, row.damping, -0.5 * h, V, SPARE)
    state[SPARE + 1] = 0.0
    subtract_contact_forces(row, laws, U, V, SPARE + 1)
    for i in range(state.shape[1]):
        state[SPARE, i] += h * state[SPARE + 1, i] + (state[V, i] - h * grounds[0]) / row.inverse_mass[i]
    state[V_AFTER] = 0.0
    add_product(row, row.inverse, 1.0, SPARE, V_AFTER)
    for i in range(state.shape[1]):
        state[U_AFTER, i] = state[U, i] + h * state[V_AFTER, i]


@kernel
def advance_newmark(row, laws, grounds, h):
    """Average acceleration: without any force first, then with the forces that fit what they lead to."""
    state, forces = row.state, row.forces
    bend, rise = BETA * h * h, GAMMA * h
    for i in range(state.shape[1]):
        state[U_AFTER, i] = state[U, i] + h * state[V, i] + (0.5 - BETA) * h * h * state[A, i]
        state[V_AFTER, i] = state[V, i] + (1.0 - GAMMA) * h * state[A, i]
        state[SPARE, i] = -grounds[2] / row.inverse_mass[i]
    add_product(row, row.stiffness, -1.0, U_AFTER, SPARE)
    add_product(row, row.damping, -1.0, V_AFTER, SPARE)
    state[A_AFTER] = 0.0
    add_product(row, row.inverse, 1.0, SPARE, A_AFTER)
    solve_forces(row, laws, bend, rise)
    state[SPARE] = 0.0
    for k in range(row.ends.shape[0]):
        subtract_force(row, k, forces[1, k], SPARE)
    add_product(row, row.inverse, 1.0, SPARE, A_AFTER)
    for i in range(state.shape[1]):
        state[U_AFTER, i] += bend * state[A_AFTER, i]
        state[V_AFTER, i] += rise * state[A_AFTER, i]


@kernel
def solve_forces(row, laws, bend, rise):
    """The forces of all contact points at the end of a step, to row 1 of ``forces``, from those at its start.

    Point by point, each with the forces of the others as they are, until none moves (Gauss and Seidel): every force
    falls with its own and B · inverse · Bᵀ is positive definite, so that this ends.
    """
    forces, points = row.forces, row.ends.shape[0]
    forces[1] = 0.0
    for _ in range(MOST_SWEEPS):
        largest_force, largest_change = 0.0, 0.0
        for k in range(points):
            reaction = 0.0
            for j in range(points):
                if j != k:
                    reaction += row.give[k, j] * forces[1, j]
            depth = across(row, k, U_AFTER) + bend * (across(row, k, A_AFTER) - reaction) - row.contacts[k, GAP]
            force = 0.0
            if not depth <= 0.0:
                rate = across(row, k, V_AFTER) + rise * (across(row, k, A_AFTER) - reaction)
                give = row.give[k, k]
                force = solve_force(laws[k], contact_of(row, k), (depth, rate, bend * give, rise * give), forces[0, k])
            largest_change = max(largest_change, abs(force - forces[1, k]))
            forces[1, k] = force
            largest_force = max(largest_force, abs(force))
            if not abs(force) < inf:
                return
        if largest_change <= AGREED * largest_force or points == 1:
            return


@small
def advance(method, row, laws, grounds, h):
    """One step of ``h`` [s] from rows U, V, A to rows U_AFTER, V_AFTER, A_AFTER; ``grounds`` at start, middle, end."""
    if method == NEWMARK:
        advance_newmark(row, laws, grounds, h)
    elif method == CENTRAL:
        advance_central(row, laws, grounds, h)
    else:
        advance_rk4(row, laws, grounds, h)


@kernel
def begin_contacts(row, laws, rules):
    """Give a damping constant to each contact that the step begins; True where there is one.

    While open, it is NaN: a step whose force needs it is NaN from there on, and is computed again.
    """
    begun = False
    for k in range(row.ends.shape[0]):
        contact = row.contacts[k]
        if contact[MEMORY] == contact[MEMORY] or across(row, k, U_AFTER) <= contact[GAP]:
            continue
        speed = max(across(row, k, V), 0.0)
        contact[MEMORY] = laws[k].begin(rules[k].at(speed), speed, row.striking[k])
        begun = True
    return begun


@kernel
def update_peaks(row, laws, moment, h, out):
    """Raise the peaks of every contact point by the state after a step from ``moment`` [s], and end contacts."""
    for k in range(row.ends.shape[0]):
        contact, peaks = row.contacts[k], out[k]
        closing, previous_closing = across(row, k, U_AFTER), across(row, k, U)
        delta = closing - contact[GAP]
        peaks[fixed.REACH] = max(peaks[fixed.REACH], abs(closing))
        peaks[fixed.CLOSING] = max(peaks[fixed.CLOSING], closing)
        row.forces[0, k] = 0.0
        if delta > 0.0:
            rate = across(row, k, V_AFTER)
            force = contact_force(laws[k], contact_of(row, k), delta, rate)
            row.forces[0, k] = force
            peaks[fixed.DEMAND] = max(peaks[fixed.DEMAND], uncapped_force(laws[k], contact_of(row, k), delta, rate))
            peaks[fixed.FORCE] = max(peaks[fixed.FORCE], force)
            peaks[fixed.TOUCHING] += 1.0
            if contact[CLOSED] == 0.0:
                peaks[fixed.COUNT] += 1.0
                if peaks[fixed.COUNT] == 1.0:
                    open_gap = contact[GAP] - previous_closing
                    peaks[fixed.FIRST] = moment + h * open_gap / (open_gap + delta)
            contact[CLOSED] = 1.0
        else:
            contact[CLOSED], contact[MEMORY] = 0.0, nan


@kernel
def march_row(method, row, laws, rules, limits, ground, out):
    """One run from rest; ``limits`` = (gaps, yield forces) by contact point, ``out`` (K, COLUMNS).

    A motion that is not finite ends the run, which is then UNSTABLE.
    """
    gaps, yield_forces = limits
    a_g, dt, parts = ground
    h, share = dt / parts, 1.0 / parts
    state = row.state
    state[:] = 0.0
    # At rest at the start; central differences have the velocity half a step earlier.
    state[A] = -a_g[0]
    if method == CENTRAL:
        state[V] = 0.5 * h * a_g[0]
    out[:] = 0.0
    out[:, fixed.FIRST] = nan
    row.forces[:] = 0.0
    for k in range(row.ends.shape[0]):
        row.contacts[k, GAP], row.contacts[k, STRENGTH] = gaps[k], laws[k].ceiling(yield_forces[k])
        row.contacts[k, LEAST], row.contacts[k, MEMORY], row.contacts[k, CLOSED] = laws[k].floor(), nan, 0.0
    for sample in range(a_g.size - 1):
        start, rise = a_g[sample], a_g[sample + 1] - a_g[sample]
        for part in range(parts):
            x = part * share
            grounds = start + rise * x, start + rise * (x + 0.5 * share), start + rise * (x + share)
            advance(method, row, laws, grounds, h)
            for _ in range(row.ends.shape[0] + 1):
                if not begin_contacts(row, laws, rules):
                    break
                advance(method, row, laws, grounds, h)
            update_peaks(row, laws, sample * dt + part * h, h, out)
            state[U : A + 1] = state[U_AFTER : A_AFTER + 1]
        total = 0.0
        for i in range(state.shape[1]):
            total += abs(state[U, i]) + abs(state[V, i])
        if not total < inf:
            out[:, fixed.UNSTABLE] = 1.0
            return


def solve_fixed_row(method, row, laws, rules, limits, ground: fixed.Ground) -> np.ndarray:
    """One run by a method of `METHODS`: (contact points, COLUMNS) as in `fixed_step`.

    ``laws`` and ``rules`` of restitution are tuples by contact point, of one class each.
    """
    out = np.zeros((len(row.shares), fixed.COLUMNS))
    arrays = stepping(row, method, ground.dt / ground.parts)
    gaps, forces = (np.asarray(limit, dtype=np.float64) for limit in limits)
    march_row(METHODS.index(method), by_address(arrays), laws, rules, (gaps, forces), ground, out)
    return out
