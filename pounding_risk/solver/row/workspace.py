"""How a row lies in memory: its buildings and contact points, and the arrays that a run works on.

A building is a chain of masses, degrees of freedom (dofs) numbered from the bottom up and through all buildings in
turn; a rigid building has none. A contact point lies on two dofs at most of either neighbour: at a floor it has a share
of 1 of that floor, part-way up a column shares of the floors below and above it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import small
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import TALLIED
from pounding_risk.solver.pair.taylor import LEFT, MAX_TERMS
from pounding_risk.solver.runge_kutta import DOP853

# Rows of `Row.floors`, by dof.
MASS, INVERSE, SPRING, SHEAR, LIMIT, SOFT, STATIC, BOTTOM, QUICK = range(9)
# Rows of `Row.frame`, by building: its first dof, the first point of the interface on its right, of its map, yielding,
# how far from its diagonal the damping matrix reaches.
FIRST, START, MAP, BENDS, BAND = range(5)
# Columns of `Run.limits`: what a point is given, its restitution, where the verbs of its law stand; its law's numbers,
# and behind these what its contact remembers.
GAPS, FORCES, WATCHING, FASTEST, RULE = range(5)
FORCE_VERB = RULE + len(Restitution._fields)
PLATEAU_VERB, BEGIN_VERB, TURN_VERB, PART_VERB, LAW = range(FORCE_VERB + 1, FORCE_VERB + 6)

# Columns of `Run.book`: what a contact point remembers; its tally and the extremes of its distance follow.
(
    CLOSED,
    GAP,  # with the dents of the contacts so far
    STRENGTH,
    SPEED,  # scale of velocity for the error control
    DEPTH,  # and of penetration
    LEAST,  # smallest force: 0 where tension is cut, −∞ otherwise
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
    LEFT_HIGH,  # extremes over an interval of what the left building adds to the distance, and the right one
    LEFT_LOW,
    RIGHT_HIGH,
    RIGHT_LOW,
) = range(29)
BOOKED = 29
HIGHEST, LOWEST, COLUMNS = BOOKED + TALLIED, BOOKED + TALLIED + 1, BOOKED + TALLIED + 2

STAGES = len(DOP853.nodes)
LAST = STAGES  # slopes at the end of a step
LATE = STAGES + 1
SLOPES = LATE + len(DOP853.late_nodes)
TERMS = 7

# Rows of the desk, by dof: states, a row of u and one of v each, accelerations, slopes, the polynomial of a step.
NODE, NEXT, NOW, END, TRIAL, NUDGED = range(0, 12, 2)
A_START, A_END, A_NUDGED, A_SPARE, J_START, J_END = range(12, 18)
POLY = 18  # TERMS rows of u, TERMS of v
SLOPE = POLY + 2 * TERMS  # SLOPES rows of du/ds, SLOPES of dv/ds
# By dof too: the storey's branch and what follows from it, V = TANGENT d + CONSTANT; and the peaks so far.
TANGENT, CONSTANT, PLASTIC, BRANCH, PLACE, DRIFT, FORCE, SHAKE = range(SLOPE + 2 * SLOPES, SLOPE + 2 * SLOPES + 8)
ROWS = SHAKE + 1

WHOLE = LEFT  # row of the board, which only the pair uses otherwise
STATUS, STEPS, ENERGY, RESIDUAL, GREW, WRITTEN, COUNTS = range(7)
ROOM, SINCE = COUNTS, COUNTS + 1  # lines that the log has room for; the first of the present interval
# Whether the present step is implicit; evaluations of the equations of motion in contact, mass by mass.
IMPLICIT, WORKED = 16, 17
BOARD_PLACE = 8  # of that row, from where on a law's verbs are handed what they work on

# Columns of a line of the log: when, the first building of the group; then u and v of every dof, then point by point:
WHEN, WHOSE, MOVED = range(3)
ACTING, SO_FAR, BEGAN, CAME_AT, STRONGEST, NOTED = range(6)
KEPT = 8  # rows of `Run.kept` that an interval begins with


class Row(NamedTuple):
    """What stays the same for every run of a row; B buildings, D dofs, K contact points."""

    frame: np.ndarray  # (5, B + 1) dofs of building b are FIRST[b] to FIRST[b + 1] − 1; so are points of START
    ends: np.ndarray  # (K, 4) dofs: left upper and lower, right upper and lower; −1 is the ground
    shares: np.ndarray  # (K, 4) of these, below zero on the right: their sum is u_left − u_right
    floors: np.ndarray  # (9, D)
    damping: np.ndarray  # (D, N) row i of C
    maps: np.ndarray  # (...,) over one node interval, (u, v) from u, v, a_g and its slope in turn; building by building


class Run(NamedTuple):
    """What one run of a row works on and leaves behind. Few arrays: every call hands all of them on."""

    limits: np.ndarray  # (K, ...) see GAPS; C-contiguous
    timed: np.ndarray  # (3, K, L) levels of force, when each is first reached, contacts in which it is
    book: np.ndarray  # (K, COLUMNS)
    desk: np.ndarray  # (ROWS, D)
    quads: np.ndarray  # (SLOPES + 2, 2 K + 1) impulse and work of each contact, and the power put in
    series: np.ndarray  # (D, MAX_TERMS) Taylor coefficients of u
    board: np.ndarray  # the pair's desk: where series are searched, and the tableau of the contact phase
    kept: np.ndarray  # (KEPT, D) what an interval begins with, should it have to be made again; below it the log
    kept_book: np.ndarray  # (K, ...) the same of the contact points


def new_run(row: Row, limits: np.ndarray, levels: np.ndarray, board: np.ndarray, lines: int = 0) -> Run:
    """Arrays for one run; ``levels`` [N] are those that are timed, ``lines`` the room of the log, 0 for none."""
    dofs, points = row.floors.shape[1], row.ends.shape[0]
    timed = np.zeros((3, points, levels.size))
    timed[0], timed[1] = levels, np.nan
    board[WHOLE, ROOM] = lines
    return Run(
        limits,
        timed,
        np.zeros((points, COLUMNS)),
        np.zeros((ROWS, dofs)),
        np.zeros((SLOPES + 2, 2 * points + 1)),
        np.zeros((dofs, MAX_TERMS)),
        board,
        np.zeros((KEPT + -(-lines * line_width(dofs, points) // max(dofs, 1)), dofs)),
        np.zeros((points, COLUMNS + 2 * levels.size + limits.shape[1] - LAW)),
    )


@small
def line_width(dofs, points):
    """Numbers in a line of the log."""
    return MOVED + 2 * dofs + NOTED * points


def log_of(run: Run) -> np.ndarray:
    """The lines that a run has written to its log; those taken back are left out."""
    width = line_width(run.desk.shape[1], run.limits.shape[0])
    flat = run.kept[KEPT:].ravel()
    log = flat[: flat.size // width * width].reshape(-1, width)[: int(run.board[WHOLE, WRITTEN])]
    return log[np.isfinite(log[:, WHEN])]
