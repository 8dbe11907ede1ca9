"""The log of a row's run, read: every contact with its forces, and the motion between the nodes of the run.

A line of the log is a group of buildings of which some touch, at the end of a step of the solver: its displacements
and velocities, and at each of its contact points the force, the impulse so far and what the present contact is.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.solver.row.workspace import (
    LINE_POINT_COLUMNS,
    LINE_STATES,
    LINE_TIME,
    POINT_APPROACH_SPEED,
    POINT_FORCE,
    POINT_IMPULSE,
    POINT_PEAK_FORCE,
    POINT_TOUCH_TIME,
)

Array = NDArray[np.float64]
CLOSE = 1e-6  # of a node interval: instants nearer than this to a node are the node's


FACTS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the histories"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "peak_force": ("N", "largest force transmitted"),
    "impulse": ("N s", "impulse of the contact force"),
}


class ContactHistory(NamedTuple):
    """One contact of a run."""

    point: int  # of its contact point
    facts: tuple[float, ...]  # as `FACTS` names them
    instants: Array  # s, of the steps of the solver
    forces: Array  # N, at these


class Instants(NamedTuple):
    """The times [s] of a run's history: its nodes, and every step in contact."""

    nodes: Array
    lines: Array  # of the log, in its order
    every: Array  # all of them, ascending


def instants_of(log: Array, nodes: int, step: float) -> Instants:
    """The instants of a run of so many nodes ``step`` [s] apart; a line at the end of an interval is the node's."""
    times = log[:, LINE_TIME].copy()
    nearest_node = np.rint(times / step)
    is_node = np.abs(times - nearest_node * step) <= CLOSE * step
    times[is_node] = nearest_node[is_node] * step
    at_nodes: Array = step * np.arange(nodes, dtype=np.float64)
    return Instants(at_nodes, times, np.unique(np.concatenate([at_nodes, times])))


def contacts_of(log: Array, points: int, instants: Instants) -> list[ContactHistory]:
    """Every contact of a run, by the time of its touch."""
    noted = _by_point(log, points)
    contacts = []
    for point in range(points):
        closed = np.isfinite(noted[:, point, POINT_TOUCH_TIME])
        lines, times, impulse_before = noted[closed, point], instants.lines[closed], 0.0
        # A contact is what has begun at one time.
        begins = np.flatnonzero(np.diff(lines[:, POINT_TOUCH_TIME], prepend=np.nan)).tolist()
        for first, past in pairwise([*begins, len(lines)]):
            last = lines[past - 1]
            strongest, impulse = lines[first:past, POINT_PEAK_FORCE].max(), last[POINT_IMPULSE] - impulse_before
            facts = (
                float(value)
                for value in (last[POINT_TOUCH_TIME], times[past - 1], last[POINT_APPROACH_SPEED], strongest, impulse)
            )
            contacts.append(ContactHistory(point, tuple(facts), times[first:past], lines[first:past, POINT_FORCE]))
            impulse_before = last[POINT_IMPULSE]
    return sorted(contacts, key=lambda contact: contact.facts[0])


def forces_at(contacts: list[ContactHistory], points: int, instants: Array) -> Array:
    """Contact force [N] at these instants (instants, points): the solver's own at its steps, straight between them."""
    forces = np.zeros((len(instants), points))
    for contact in contacts:
        first = np.searchsorted(instants, contact.instants[0])
        past = np.searchsorted(instants, contact.instants[-1], side="right")
        forces[first:past, contact.point] = np.interp(instants[first:past], contact.instants, contact.forces)
    return forces


def impulses_at(log: Array, points: int, instants: Instants) -> Array:
    """Impulse of each contact point up to every instant [N s], (instants, points); exact at the solver's steps."""
    noted = _by_point(log, points)
    impulses = np.zeros((len(instants.every), points))
    for point in range(points):
        lines = np.isfinite(noted[:, point, POINT_IMPULSE])
        if lines.any():
            impulses[:, point] = np.interp(
                instants.every, instants.lines[lines], noted[lines, point, POINT_IMPULSE], left=0.0
            )
    return impulses


def motion_at(log: Array, states: Array, instants: Instants) -> Array:
    """u [m] and v [m/s] of every mass at every instant, (instants, 2, masses).

    A building moves as the solver has it at the nodes and at the steps of its group; at the instants of others it is
    on the cubic through displacement and velocity on both sides: off by (ω Δ)⁴ / 384 of what moves with ω over Δ.
    """
    masses = states.shape[2]
    motion = np.empty((len(instants.every), 2, masses))
    for mass in range(masses):
        lines = np.isfinite(log[:, LINE_STATES + mass])
        knots, first = np.unique(np.concatenate([instants.nodes, instants.lines[lines]]), return_index=True)
        motions = np.concatenate(
            [states[:, :, mass], log[lines][:, [LINE_STATES + mass, LINE_STATES + masses + mass]]]
        )[first]
        motion[:, :, mass] = _cubic(knots, motions, instants.every)
    return motion


def _by_point(log: Array, points: int) -> Array:
    """What the log notes of every contact point, (lines, points, NOTED)."""
    return log[:, log.shape[1] - LINE_POINT_COLUMNS * points :].reshape(len(log), points, LINE_POINT_COLUMNS)


def _cubic(knots: Array, motions: Array, instants: Array) -> Array:
    """Values and rates (instants, 2) between those at the knots (knots, 2)."""
    before = np.clip(np.searchsorted(knots, instants, side="right") - 1, 0, len(knots) - 2)
    length = np.diff(knots)[before]
    x = (instants - knots[before]) / length
    (u, v), (end, speed) = motions[before].T, motions[before + 1].T
    rise, lean, bend = end - u, length * v, length * speed
    value = u + x * (lean + x * (3.0 * rise - 2.0 * lean - bend + x * (lean + bend - 2.0 * rise)))
    rate = v + x * (6.0 * rise - 4.0 * lean - 2.0 * bend + x * 3.0 * (lean + bend - 2.0 * rise)) / length
    at_knot = (x == 0.0)[:, None] | (x == 1.0)[:, None]
    at_knots = np.where((x == 1.0)[:, None], motions[before + 1], motions[before])
    return np.where(at_knot, at_knots, np.column_stack([value, rate]))
