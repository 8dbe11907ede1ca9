"""How a row lies in memory: its buildings and contact points, and the arrays that a run works on.

A building is a chain of masses, degrees of freedom (dofs) numbered from the bottom up and through all buildings in
turn; a rigid building has none. A contact point lies on two dofs at most of either neighbour: at a floor it has a share
of 1 of that floor, part-way up a column shares of the floors below and above it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk.core.series import MAX_TERMS
from pounding_risk.core.tally import TALLIED
from pounding_risk.models.tableau import DOP853

# Rows of `Row.floors`, by dof.
MASS, INVERSE, SPRING, SHEAR, LIMIT, SOFT, STATIC, BOTTOM = range(8)
# Rows of `Run.live`, by dof: the storey's branch and what follows from it, V = TANGENT d + CONSTANT.
TANGENT, CONSTANT, PLASTIC, BRANCH = range(4)
# Rows of `Run.peaks`, by dof.
PLACE, DRIFT, FORCE, SHAKE = range(4)

# Columns of `Run.book`: what a contact point remembers while a run lasts.
(
    CLOSED,
    GAP,  # with the dents of the contacts so far
    STRENGTH,
    MEMORY,
    SPEED,  # scale of velocity for the error control
    DEPTH,  # and of penetration
    STILL,  # speed below which the direction of the motion is rounding
    APPROACHING,
    REGION,
    TOUCHED,  # when
    AT_TOUCH,  # approach speed
    ASKED,  # restitution
    PEAK,  # uncapped force of this contact so far
    PLATEAU,  # transmitted force past yield
    DEEPEST,
    YIELDED,
    DENTED,
    LOST,
    PACE,  # length that the next step should have
    WORN,
    START_FORCE,
    START_RISE,
    END_FORCE,
    END_RISE,
    WORK,
) = range(25)
BOOKED = 25

STAGES = len(DOP853.nodes)
LAST = STAGES  # slopes at the end of a step
LATE = STAGES + 1
SLOPES = LATE + len(DOP853.late_nodes)
TERMS = 7

# Rows of the desk, by dof: states, each a row of u and one of v behind it, accelerations, slopes, the step's polynomial.
NODE, NEXT, NOW, END, TRIAL, PEEK, NUDGED = range(0, 14, 2)
A_START, A_END, A_PEEK, A_NUDGED, J_START, J_END = range(14, 20)
POLY = 20  # TERMS rows of u, TERMS of v
SLOPE = POLY + 2 * TERMS  # SLOPES rows of du/ds, SLOPES of dv/ds
ROWS = SLOPE + 2 * SLOPES

STATUS, STEPS, ENERGY, RESIDUAL, GREW = range(5)  # of `Run.whole`


class Row(NamedTuple):
    """What stays the same for every run of a row; B buildings, D dofs, K contact points."""

    first: np.ndarray  # (B + 1,) dofs of building b are first[b] to first[b + 1] − 1
    start: np.ndarray  # (B,) points of interface i are start[i] to start[i + 1] − 1
    ends: np.ndarray  # (K, 4) dofs: left upper and lower, right upper and lower; −1 is the ground
    shares: np.ndarray  # (K, 4) of these, below zero on the right: their sum is u_left − u_right
    floors: np.ndarray  # (8, D)
    damping: np.ndarray  # (D, N) row i of C
    maps: np.ndarray  # (...,) over one node interval: (u, v, a_g, its slope) to (u, v), building by building
    map_start: np.ndarray  # (B,)
    bends: np.ndarray  # (B,) 1 where a storey can yield


class Run(NamedTuple):
    """What one run of a row works on and leaves behind."""

    gaps: np.ndarray  # (K,) m
    strengths: np.ndarray  # (K,) yield forces F_E [N]
    laws: np.ndarray  # (K, numbers) of the contact laws
    rules: np.ndarray  # (K, numbers) of the restitutions
    watched: np.ndarray  # (K,) 1 where a touch ends the run
    fastest: np.ndarray  # (K,) peak closing or parting speed at nodes without contact [m/s]
    levels: np.ndarray  # (L,) forces whose first reaching is timed [N], ascending
    first: np.ndarray  # (K, L) when a force first reaches a level, NaN for never [s]
    reached: np.ndarray  # (K, L) contacts in which it does
    book: np.ndarray  # (K, BOOKED)
    tally: np.ndarray  # (K, TALLIED)
    reach: np.ndarray  # (2, K) highest and lowest u_left − u_right
    peaks: np.ndarray  # (4, D)
    live: np.ndarray  # (4, D)
    whole: np.ndarray  # (5,)
    desk: np.ndarray  # (ROWS, D)
    quads: np.ndarray  # (SLOPES + 2, 2 K + 1) impulse and work of each contact, and the power put in
    series: np.ndarray  # (D, MAX_TERMS) Taylor coefficients of u
    table: np.ndarray  # the tableau, as `collide.make_desk` writes it
    board: np.ndarray  # (14, 64) where `series` searches
    kept: np.ndarray  # what an interval begins with, should it have to be made again


def new_run(row: Row, contacts, levels: np.ndarray, table: np.ndarray) -> Run:
    """Arrays for one run; ``contacts`` = (gaps, yield forces, laws, rules, watched, fastest)."""
    dofs, points = row.floors.shape[1], row.ends.shape[0]
    kept = 8 * dofs + points * (BOOKED + TALLIED + 2 + 2 * levels.size) + 5
    return Run(
        *contacts,
        levels,
        np.full((points, levels.size), np.nan),
        np.zeros((points, levels.size)),
        np.zeros((points, BOOKED)),
        np.zeros((points, TALLIED)),
        np.zeros((2, points)),
        np.zeros((4, dofs)),
        np.zeros((4, dofs)),
        np.zeros(5),
        np.zeros((ROWS, dofs)),
        np.zeros((SLOPES + 2, 2 * points + 1)),
        np.zeros((dofs, MAX_TERMS)),
        table,
        np.zeros((14, 64)),
        np.zeros(kept),
    )
