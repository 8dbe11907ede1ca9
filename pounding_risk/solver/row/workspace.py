"""How a row lies in memory: its buildings and contact points, and the arrays that a run works on.

A building is a chain of masses, degrees of freedom (dofs) numbered from the bottom up and through all buildings in
turn; a rigid building has none. A contact point lies on two dofs at most of either neighbour: at a floor it has a share
of 1 of that floor, part-way up a column shares of the floors below and above it. With a passing wave each building has
one dof more, its last, which is the ground's (`ground`); the right one's is a fifth of a contact point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import small
from pounding_risk._jit.memory import new_records, record_type
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.hysteresis import called
from pounding_risk.solver.counters import TALLIED
from pounding_risk.solver.row.ground import (
    ArrivingRow,
    ArrivingRowGround,
    PlaneRow,
    PlaneRowGround,
    UniformRow,
    UniformRowGround,
)
from pounding_risk.solver.runge_kutta import DOP853
from pounding_risk.solver.workspace import LAST, MAX_TERMS, TERMS, Search, Tableau, make_workspace

# Rows of `Row.floors`, by dof. With an energy E in the building no displacement is larger than SWAY sqrt(2 E), no drift
# than GIVE sqrt(2 E), and no velocity than ROOT sqrt(2 E). MOBILITY is (M⁻¹)_ii. FELT is 1 where a_g acts, 0 of
# rotations, DRIVEN the mass where it acts, STATIC the displacement under a steady a_g of 1. ACROSS rows behind each of
# these three stands the same of a_g across the row, where it acts too (`ground.PlaneRow`). Of a building with a mass
# matrix MASS is 0, INVERSE 1 and FELT as DRIVEN: in place of accelerations stand forces, until `inertia` divides them.
MASS, INVERSE, SPRING, SHEAR, LIMIT, SOFT, BOTTOM, QUICK, ROOT, SWAY, GIVE, MOBILITY, STATIC, FELT, DRIVEN = range(15)
ACROSS = 3
# Rows of `Row.frame`, by building: its first dof, the first point of the interface on its right, of its map, yielding,
# how far from its diagonal the damping matrix reaches, of its map in `FreeMotion.block_maps`, above zero where it has
# springs in `coupling`, above one where it has a mass matrix in `inertia` too, how many of its dofs are braces of
# dampers (`link`), its last ones.
FIRST, START, MAP, CAN_YIELD, BAND, BLOCK_MAP, COUPLED, BRACES = range(8)
# Fields of a contact by end of the step, and extremes over an interval of what either building adds to the distance.
AT_START, AT_END = 0, 1
LEFT_HIGH, LEFT_LOW, RIGHT_HIGH, RIGHT_LOW = range(4)

# A contact point: what it is given, what its present contact is, and what the contacts so far have left.
Contact = record_type(
    given_gap=float,  # m
    yield_force=float,  # N
    watched=float,  # above zero where a touch ends the run
    fastest=float,  # peak closing or parting speed without contact [m/s]
    rule=(len(Restitution._fields),),
    force_verb=float,  # addresses of the law's compiled functions
    plateau_verb=float,
    begin_verb=float,
    turn_verb=float,
    part_verb=float,
    closed=float,  # above zero while the buildings touch
    gap=float,  # with the indentations of the contacts so far [m]
    strength=float,  # force at which the law yields [N]
    speed_scale=float,  # of the error control [m/s]
    depth_scale=float,  # of the error control [m]
    least_force=float,  # 0 where tension is cut, −∞ otherwise [N]
    still_speed=float,  # below which the direction of the motion is rounding [m/s]
    knee_depth=float,  # penetration ahead at which the slope of the force jumps, inf for none [m]
    approaching=float,
    region=float,
    touch_time=float,  # s
    approach_speed=float,  # m/s
    restitution=float,
    peak_force=float,  # uncapped, of this contact so far [N]
    plateau_force=float,  # transmitted past yield [N]
    peak_penetration=float,  # m
    yields=float,  # times that this contact has yielded
    indentation=float,  # m
    plastic_energy=float,  # J
    next_step=float,  # length that the next step should have [s]
    damage=float,  # what earlier contacts have left behind
    work=float,  # J
    energy=float,  # largest of its groups at a touch or parting [J]
    force=(2,),  # uncapped, at both ends of the step [N]
    force_slope=(2,),
    side_extremes=(4,),  # m
    counters=(TALLIED,),
    highest=float,  # u_left − u_right [m]
    lowest=float,
    upper_bound=float,  # of u_left − u_right since the bounds were last reset [m]
    lower_bound=float,
)

LATE = LAST + 1  # slopes at the late stages
SLOPES = LATE + len(DOP853.late_nodes)

VERBS = tuple(name for name in Contact.names or () if name.endswith("_verb"))

# Rows of `Run.dofs`: states, a row of displacements followed by one of velocities each; accelerations and their slopes;
# what contacts have added to the free motion, now, at the start of the block of nodes and to work with; the free
# motion; upper bounds of |u|, |drift| and |absolute acceleration| since they were last reset; the polynomial of a step;
# its slopes.
VELOCITY = 1
NODE, NEXT, NOW, END, TRIAL, NUDGED = range(0, 12, 2)
ACCEL_START, ACCEL_END, ACCEL_NUDGED, ACCEL_SPARE, JERK_START, JERK_END = range(12, 18)
VIBRATION, VIBRATION_BEFORE, VIBRATION_SPARE, FREE = range(18, 26, 2)
BOUNDS = 26
POLY = 29  # TERMS rows of u, TERMS of v
SLOPE = POLY + 2 * TERMS  # SLOPES rows of du/ds, SLOPES of dv/ds
# The storey's branch and what follows from it, V = TANGENT d + CONSTANT; its plastic drift, of a storey with a law of
# its own the potential at no drift on its branch [J]; and the peaks so far.
TANGENT, CONSTANT, PLASTIC, BRANCH, DISPLACEMENT, DRIFT, STOREY_FORCE, ACCELERATION = range(
    SLOPE + 2 * SLOPES, SLOPE + 2 * SLOPES + 8
)
ROWS = ACCELERATION + 1
SAVED = ROWS - TANGENT  # rows of `Run.saved` that an interval begins with

# Rows of `Run.marks`, by building: whether it has been in a group, or its storeys may yield; the node of its VIBRATION
# rows; the node of its NODE rows; whether it has been on its own since the start of the block; whether it is brought
# from node to node, and its floors are searched for peaks, in this block; upper bounds of the displacements and
# accelerations of its vibration, over SWAY and ROOT; the node of its FREE rows, −1 where they stand nowhere; 2 E of the
# bounds on its motion alone over the present interval; whether it needs a group, and has been solved in one. By
# interface: whether its distances are searched in this block; whether it ties both buildings to one group.
(
    MOVED, VIBRATION_NODE, STATE_NODE, ALONE, BY_NODE, FLOORS_SEARCHED, DISPLACEMENT_BOUND, ACCELERATION_BOUND,
    FREE_NODE, MOTION_BOUND, GROUPED, SOLVED, DISTANCES_SEARCHED, TIED, MARKS,
) = range(15)  # fmt: skip

RowWorkspace = record_type(
    search=Search,
    tableau=Tableau,
    status=float,
    steps=float,
    energy=float,  # largest of a group at a touch or parting [J]
    residual=float,  # what the contacts leave unaccounted for [J]
    watched_point=float,  # one that was touched, −1 where none was
    collapse_time=float,  # of a storey, where the status says that one has collapsed [s]
    implicit=float,  # above zero where the present step is
    has_polynomial=float,  # above zero once that of the present step is written
    evaluations=float,  # of the equations of motion in contact, mass by mass
    line_room=float,  # lines that the log has room for
    lines_written=float,
    first_line=float,  # of the present interval
    law_arguments=(8,),  # what a law's functions are given and give back
)

# Columns of a line of the log: when, the first building of the group; then u and v of every dof, then point by point:
LINE_TIME, LINE_BUILDING, LINE_STATES = range(3)
POINT_FORCE, POINT_IMPULSE, POINT_TOUCH_TIME, POINT_APPROACH_SPEED, POINT_PEAK_FORCE, LINE_POINT_COLUMNS = range(6)


class Row(NamedTuple):
    """Arrays that are the same for every run of a row; B buildings, D dofs, K contact points."""

    frame: np.ndarray  # (8, B + 1) dofs of building b are FIRST[b] to FIRST[b + 1] − 1; so are points of START
    ends: np.ndarray  # (K, 4 or 5) dofs: left upper and lower, right upper and lower, ground; −1 is none
    shares: np.ndarray  # (K, 4 or 5) of these, below zero on the right: their sum is u_left − u_right
    floors: np.ndarray  # (15, D); (18, D) where a_g acts across the row too
    damping: np.ndarray  # (D, N) row i of C
    coupling: np.ndarray  # (D, N) row i of the stiffness matrix beside the storey springs; (D, 0) where no row has one
    maps: np.ndarray  # (...,) over one node interval, (u, v) from u, v, a_g and its slope; by width and building
    passage: UniformRow | PlaneRow | ArrivingRow
    storeys: np.ndarray  # (D, ...) numbers of the law of each storey, zero without one; (D, 0) where no row has one
    links: np.ndarray  # (K, ...) the same of the points at which links with laws stand; (0, 0) where no row has one
    inertia: np.ndarray  # (D, 2 N) row i of L, M = L Lᵀ, and of M⁻¹; (D, 0) where no row has a mass matrix


class FreeMotion(NamedTuple):
    """The motion of a row without contact under one ground motion, which all runs share; N nodes in P blocks.

    The arrays are those of the whole row, also for a part of it.
    """

    ground: UniformRowGround | PlaneRowGround | ArrivingRowGround
    step: float  # between two samples, of which the ground makes nodes [s]
    terms: int  # of the Taylor series over an interval
    states: np.ndarray  # (P + 1, 2, D) u and v at the start of each block, and at the last node
    floor_bounds: np.ndarray  # (P, 3, D) no |u|, |drift|, |absolute acceleration| in the block is larger
    floor_peaks: np.ndarray  # (P + 1, 3, D) largest of each up to the start of the block, and in the whole record
    point_bounds: np.ndarray  # (P, 2, K) no u_left − u_right in the block is larger, and none smaller
    point_peaks: np.ndarray  # (P + 1, 2, K) largest and smallest up to the start of the block, and in the whole record
    fastest: np.ndarray  # (K,) peak closing or parting speed at nodes [m/s]
    block_maps: np.ndarray  # of a free vibration over one block, column by column, building by building
    block: int  # nodes a block
    first_dof: int = 0  # of a part
    first_point: int = 0


class FreeWork(NamedTuple):
    """Arrays for one block of `free_motion.march_free`, of n nodes."""

    paths: np.ndarray  # (3, D, n + 1) u, v and ü at its nodes
    swings: np.ndarray  # (2, B, n) 2 E of the bounds on the motion of a building over each interval, and its root
    ground: np.ndarray  # (3 or 5, n + 1) a_g under the present building, its slope, the time to the next node; across
    distances: np.ndarray  # (3, K, n + 1) u_left − u_right at the points of the present interface, its two derivatives
    bends: np.ndarray  # (K, n) no second derivative of these is larger over an interval


class Run(NamedTuple):
    """Work arrays and results of one run of a row."""

    laws: np.ndarray  # (K, ...) the numbers of each law and what its contact remembers; C-contiguous
    timed: np.ndarray  # (3, K, L) levels of force, when each is first reached, contacts in which it is
    contacts: np.ndarray  # (K,) records of the type `Contact`
    dofs: np.ndarray  # (ROWS, D)
    quadratures: np.ndarray  # (SLOPES + 2, 2 K + 1) impulse and work of each contact, and the power put in
    series: np.ndarray  # (D + 1, MAX_TERMS) Taylor coefficients of u, and of a drift to work with
    workspace: np.record  # of the type `RowWorkspace`
    saved: np.ndarray  # (SAVED, D) what an interval begins with, should it have to be repeated; below it the log
    saved_contacts: np.ndarray  # (K,) the same of the contact points
    saved_laws: np.ndarray  # (K, ...) of their levels and laws
    marks: np.ndarray  # (MARKS, B)
    storeys: np.ndarray  # (D, ...) as `Row.storeys`, with the addresses of the laws and what they remember
    saved_storeys: np.ndarray  # (D, ...) the same where an interval begins
    links: np.ndarray  # (K, ...) as `Row.links`
    saved_links: np.ndarray  # (K, ...) the same where an interval begins


def new_run(row: Row, laws: np.ndarray, levels: np.ndarray, rtol: float = 0.0, lines: int = 0) -> Run:
    """Arrays for one run; ``levels`` [N] are those that are timed, ``lines`` the room of the log, 0 for none."""
    dofs, points = row.floors.shape[1], row.ends.shape[0]
    timed = np.zeros((3, points, levels.size))
    timed[0], timed[1] = levels, np.nan
    workspace = make_workspace(rtol, RowWorkspace)
    workspace.line_room = lines
    return Run(
        laws,
        timed,
        new_records(Contact, points),
        np.zeros((ROWS, dofs)),
        np.zeros((SLOPES + 2, 2 * points + 1)),
        np.zeros((dofs + 1, MAX_TERMS)),
        workspace,
        np.zeros((SAVED + -(-lines * width_of_line(dofs, points) // max(dofs, 1)), dofs)),
        new_records(Contact, points),
        np.zeros((points, 2 * levels.size + laws.shape[1])),
        np.zeros((MARKS, row.frame.shape[1] - 1)),
        called(row.storeys),
        np.zeros(row.storeys.shape),
        called(row.links),
        np.zeros(row.links.shape),
    )


def width_of_line(dofs, points):
    """How many numbers a line of the log has, with so many dofs and contact points."""
    return LINE_STATES + 2 * dofs + LINE_POINT_COLUMNS * points


line_width = small(width_of_line)  # the same for kernels


def log_of(run: Run) -> np.ndarray:
    """The lines that a run has written to its log; those taken back are left out."""
    width = width_of_line(run.dofs.shape[1], run.laws.shape[0])
    flat = run.saved[SAVED:].ravel()
    log = flat[: flat.size // width * width].reshape(-1, width)[: int(run.workspace.lines_written)]
    return log[np.isfinite(log[:, LINE_TIME])]
