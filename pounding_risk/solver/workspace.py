"""Work arrays of the compiled solvers: one record for each thread, with the Runge-Kutta tableau of its tolerance."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from math import ceil
from typing import Any

import numpy as np

from pounding_risk._jit.memory import new_record, record_type
from pounding_risk._jit.sources import INTERPRETED
from pounding_risk.solver.counters import COUNTERS
from pounding_risk.solver.runge_kutta import DOP853, DORMAND_PRINCE, RADAU

MAX_TERMS = 48  # of a Taylor series
SIGNALS = 5  # relative displacement; displacement left, right; absolute acceleration left, right

# Rows of `Search.series`: the displacements of both buildings, and the signal that is searched.
LEFT, RIGHT, SIGNAL = range(3)
# Rows of a step's states and readings: at its beginning, at its end, and at a place between them.
BEGIN, END, BETWEEN = range(3)
# Rows of a step's slopes: at its beginning and at the stages that follow, at its end, at the late stages that only the
# polynomial needs, and at a place between both ends.
FIRST_STAGE, LAST = 0, len(DOP853.nodes)
SLOPES = LAST + 1 + len(DOP853.late_nodes)
BETWEEN_SLOPE = SLOPES
FELT = 7  # column of the slopes: the force that the buildings feel there
TERMS = 7  # of the polynomial between both ends of a step
NODES = RADAU.c.size  # of an implicit step

# The method by tolerance, loosest first: each serves tolerances from its own on. Most steps end at a record sample or
# an event, so that a low order saves its stages only where few digits are asked for.
METHODS = ((1e-4, DORMAND_PRINCE), (0.0, DOP853))

# A method's coefficients without the zeros. Each row of `stages`, `late` and `polynomial` lists pairs (row of slopes,
# weight), `final` lists (row of slopes, weight of the solution, of the fifth-order and of the third-order error
# estimate); −1 ends a row.
Tableau = record_type(
    stages=(LAST, 64),
    stage_nodes=(LAST,),
    final=(64,),
    late=(len(DOP853.late_nodes), 64),
    late_nodes=(len(DOP853.late_nodes),),
    polynomial=(len(DOP853.between), 64),
    stage_count=float,
    late_count=float,
    end_weight=float,  # of the slope at the end of the step in the error estimate
    exponent=float,  # of the error in the choice of the next step, 1 / order
)

# Taylor series over an interval of flight, and the ends of the parts of it that are still to be searched.
Search = record_type(series=(3, MAX_TERMS), pending=(64,))

Workspace = record_type(
    search=Search,
    start_signals=(SIGNALS,),  # signals at both ends of an interval of flight
    end_signals=(SIGNALS,),
    upper=(SIGNALS,),  # bounds of the signals over a block of intervals
    lower=(SIGNALS,),
    high=(SIGNALS,),  # largest and smallest value of every signal so far
    low=(SIGNALS,),
    counters=(COUNTERS,),
    # A step in contact. State: u_left, u_right, v_left, v_right, work, impulse, energy put in.
    states=(3, 7),
    slopes=(SLOPES + 1, FELT + 1),
    readings=(3, SIGNALS),
    reading_slopes=(3, SIGNALS),
    polynomial=(TERMS, 4),
    node_states=(NODES, 4),
    missing_speeds=(NODES, 2),
    time_weights=(NODES, NODES),  # of an implicit step, and what its contact's impulse answers to a change of speed
    response=(NODES, NODES),
    matrix=(NODES, NODES),  # its linear equations
    changes=(NODES,),
    tableau=Tableau,
)


def parts_and_terms(rate: float, dt: float) -> tuple[int, int]:
    """Node intervals a sample, and terms of the Taylor series over one, for the largest |eigenvalue| [1/s] of a motion.

    Samples are divided where it would pass more than 2.5 rad between them, so that a series sums to rounding.
    """
    parts = max(1, ceil(rate * dt / 2.5))
    step, terms, size = dt / parts, 4, 1.0
    while size > 1e-19 and terms < MAX_TERMS:
        size *= max(rate * step, 1e-3) / (terms - 3)
        terms += 1
    return parts, terms


def make_workspace(rtol: float = 0.0, kind: np.dtype = Workspace) -> Any:
    """Workspace of one thread for runs to the relative tolerance ``rtol``; ``kind`` is a record with a tableau."""
    template = _new_workspace(next(number for number, (least, _) in enumerate(METHODS) if rtol >= least), kind)
    # NumPy takes as long to copy a record with many fields as a short run takes.
    return deepcopy(template) if INTERPRETED else np.frombuffer(bytearray(template.tobytes()), kind)[0]


@cache
def _new_workspace(method: int, kind: np.dtype) -> Any:
    """Workspace with the tableau of one of `METHODS`: to write one takes longer than a run without contact."""
    workspace = new_record(kind)
    fill_tableau(workspace.tableau, METHODS[method][1])
    return workspace


def fill_tableau(tableau: Any, method: Any) -> None:
    """Write a method's coefficients into a record of the type `Tableau`."""
    count, late_count = len(method.nodes), len(method.late_nodes)
    tableau.late[:, 0] = tableau.polynomial[:, 0] = -1.0
    for target, rows in ((tableau.stages, method.a), (tableau.late, method.late), (tableau.polynomial, method.d)):
        for number, row in enumerate(rows):
            _write_nonzero(target[number], [row], count)
    tableau.stage_nodes[:count] = method.c
    tableau.late_nodes[:late_count] = method.late_nodes
    errors = np.zeros((2, count + 1))
    errors[: len(method.e)] = method.e
    weights = [np.append(method.b, 0.0), *errors * (np.arange(count + 1) < count)]
    _write_nonzero(tableau.final, weights, count)
    tableau.stage_count, tableau.late_count = count, late_count
    tableau.end_weight, tableau.exponent = errors[0, count], 1.0 / method.order


def _write_nonzero(target: np.ndarray, rows: list[np.ndarray], count: int) -> None:
    """Write the columns that are not zero in all ``rows``: the column's row of slopes, then a weight for each row."""
    columns = np.arange(len(rows[0]))
    entries = np.column_stack([np.where(columns < count, columns, columns + LAST - count), *rows])
    nonzero = entries[np.any(entries[:, 1:] != 0.0, axis=1)]
    target[: nonzero.size + 1] = [*nonzero.ravel(), -1.0]
