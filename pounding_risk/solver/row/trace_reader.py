"""The log of a row's run, read: every contact with its forces, and the motion between the nodes of the run.

A line of the log is a group of buildings of which some touch, at the end of a step of the solver: its displacements
and velocities, and at each of its contact points the force, the impulse so far and what the present contact is.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.solver.row.workspace import ACTING, BEGAN, CAME_AT, MOVED, NOTED, SO_FAR, STRONGEST, WHEN

Array = NDArray[np.float64]
CLOSE = 1e-6  # of a node interval: instants nearer than this to a node are the node's


FACTS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the record"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "peak_force": ("N", "largest force transmitted"),
    "impulse": ("N s", "impulse of the contact force"),
}


class Touched(NamedTuple):
    """One contact of a run."""

    place: int  # of its contact point
    facts: tuple[float, ...]  # as `FACTS` names them
    instants: Array  # s, of the steps of the solver
    forces: Array  # N, at these


class Instants(NamedTuple):
    """The times [s] at which a run is told: its nodes, and every step in contact."""

    nodes: Array
    lines: Array  # of the log, in its order
    every: Array  # all of them, ascending


def instants_of(log: Array, nodes: int, step: float) -> Instants:
    """The instants of a run of so many nodes ``step`` [s] apart; a line at the end of an interval is the node's."""
    times = log[:, WHEN].copy()
    near = np.rint(times / step)
    is_node = np.abs(times - near * step) <= CLOSE * step
    times[is_node] = near[is_node] * step
    at_nodes: Array = step * np.arange(nodes, dtype=np.float64)
    return Instants(at_nodes, times, np.unique(np.concatenate([at_nodes, times])))


def contacts_of(log: Array, points: int, instants: Instants) -> list[Touched]:
    """Every contact of a run, by the time of its touch."""
    noted = _by_point(log, points)
    contacts = []
    for point in range(points):
        closed = np.isfinite(noted[:, point, BEGAN])
        own, times, before = noted[closed, point], instants.lines[closed], 0.0
        # A contact is what has begun at one time.
        begins = np.flatnonzero(np.diff(own[:, BEGAN], prepend=np.nan)).tolist()
        for first, past in pairwise([*begins, len(own)]):
            last = own[past - 1]
            strongest, impulse = own[first:past, STRONGEST].max(), last[SO_FAR] - before
            facts = (float(value) for value in (last[BEGAN], times[past - 1], last[CAME_AT], strongest, impulse))
            contacts.append(Touched(point, tuple(facts), times[first:past], own[first:past, ACTING]))
            before = last[SO_FAR]
    return sorted(contacts, key=lambda contact: contact.facts[0])


def forces_at(contacts: list[Touched], points: int, instants: Array) -> Array:
    """Contact force [N] at these instants (instants, points): the solver's own at its steps, straight between them."""
    forces = np.zeros((len(instants), points))
    for contact in contacts:
        first = np.searchsorted(instants, contact.instants[0])
        past = np.searchsorted(instants, contact.instants[-1], side="right")
        forces[first:past, contact.place] = np.interp(instants[first:past], contact.instants, contact.forces)
    return forces


def impulses_at(log: Array, points: int, instants: Instants) -> Array:
    """Impulse of each contact point up to every instant [N s], (instants, points); exact at the solver's steps."""
    noted = _by_point(log, points)
    impulses = np.zeros((len(instants.every), points))
    for point in range(points):
        own = np.isfinite(noted[:, point, SO_FAR])
        if own.any():
            impulses[:, point] = np.interp(instants.every, instants.lines[own], noted[own, point, SO_FAR], left=0.0)
    return impulses


def motion_at(log: Array, states: Array, instants: Instants) -> Array:
    """u [m] and v [m/s] of every mass at every instant, (instants, 2, masses).

    A building moves as the solver has it at the nodes and at the steps of its group; at the instants of others it is
    on the cubic through displacement and velocity on both sides: off by (ω Δ)⁴ / 384 of what moves with ω over Δ.
    """
    masses = states.shape[2]
    motion = np.empty((len(instants.every), 2, masses))
    for mass in range(masses):
        own = np.isfinite(log[:, MOVED + mass])
        knots, first = np.unique(np.concatenate([instants.nodes, instants.lines[own]]), return_index=True)
        moved = np.concatenate([states[:, :, mass], log[own][:, [MOVED + mass, MOVED + masses + mass]]])[first]
        motion[:, :, mass] = _cubic(knots, moved, instants.every)
    return motion


def _by_point(log: Array, points: int) -> Array:
    """What the log notes of every contact point, (lines, points, NOTED)."""
    return log[:, log.shape[1] - NOTED * points :].reshape(len(log), points, NOTED)


def _cubic(knots: Array, moved: Array, instants: Array) -> Array:
    """Values and rates (instants, 2) between those at the knots (knots, 2)."""
    before = np.clip(np.searchsorted(knots, instants, side="right") - 1, 0, len(knots) - 2)
    length = np.diff(knots)[before]
    x = (instants - knots[before]) / length
    (u, v), (end, speed) = moved[before].T, moved[before + 1].T
    rise, lean, bend = end - u, length * v, length * speed
    value = u + x * (lean + x * (3.0 * rise - 2.0 * lean - bend + x * (lean + bend - 2.0 * rise)))
    rate = v + x * (6.0 * rise - 4.0 * lean - 2.0 * bend + x * 3.0 * (lean + bend - 2.0 * rise)) / length
    at_knot = (x == 0.0)[:, None] | (x == 1.0)[:, None]
    known = np.where((x == 1.0)[:, None], moved[before + 1], moved[before])
    return np.where(at_knot, known, np.column_stack([value, rate]))
