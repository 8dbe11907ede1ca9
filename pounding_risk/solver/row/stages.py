"""Integration in contact: a group of neighbours, of which some touch, by the tableau that the pair's contacts use.

State: u and v of every dof of the group; quadratures: impulse and work of every contact, and the power that ground and
dampers put in. The clock is s with τ = s⁴ since the last touch in the group, as in `core.collide` and for its reason.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from pounding_risk._jit.compile import kernel, part, small
from pounding_risk.solver.pair.stages import BETWEEN, COUNTED, END_WEIGHT, FINAL, LATES, SLACK, TABLE, YIELDING
from pounding_risk.solver.pair.stages import LATE as LATE_TABLE
from pounding_risk.solver.pair.stages import NODE as STAGE_NODE
from pounding_risk.solver.row.building import accelerate
from pounding_risk.solver.row.flight import across, push_apart
from pounding_risk.solver.row.laws import law_force, law_plateau
from pounding_risk.solver.row.workspace import (
    APPROACHING,
    CLOSED,
    END,
    GAP,
    LAST,
    LATE,
    NOW,
    POLY,
    REGION,
    SLOPE,
    SLOPES,
    START,
    STRENGTH,
    TERMS,
    TRIAL,
    WHOLE,
    WORKED,
)


class Group(NamedTuple):
    """Neighbours that are integrated together, and what stays the same while their contacts do."""

    first: int  # building
    last: int
    low: int  # the first dof, and one past the last
    high: int
    origin: float  # of the clock, after the node [s]
    pull: float  # a_g at the node and its slope
    rise: float
    depth: float  # scales of the error control: m
    speed: float  # m/s


@small
def ground_at(group, s):
    """a_g at clock time s."""
    return group.pull + group.rise * (group.origin + s * s * s * s)


@kernel
def transmitted(run, k, delta, rate):
    """Force that the buildings feel at contact ``k`` on the branch that it is on."""
    region = int(run.book[k, REGION])
    if region == SLACK:
        return 0.0
    if region == YIELDING:
        return law_plateau(run, k, delta, run.book[k, STRENGTH])
    return uncapped(run, k, delta, rate)


@kernel
def uncapped(run, k, delta, rate):
    """The law's force without cap or cut."""
    return law_force(run, k, delta, rate, run.book[k, APPROACHING])


@kernel
def load(row, run, group, state, pull, out):
    """ü of the group under ground and contacts, from rows ``state`` into row ``out``; returns the power put in."""
    power = 0.0
    for b in range(group.first, group.last + 1):
        power += accelerate(row, b, state, pull, run.desk, out)
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.book[k, CLOSED] > 0.0:
            delta = max(across(row, k, run.desk, state) - run.book[k, GAP], 0.0)
            rate = across(row, k, run.desk, state + 1)
            force = transmitted(run, k, delta, rate)
            push_apart(row, k, force, run.desk, out)
            run.quads[SLOPES + 1, k] = force
            run.quads[SLOPES + 1, run.limits.shape[0] + k] = force * rate
    return power


@kernel
def slopes(row, run, group, s, state, stage):
    """d(state)/ds = 4 s³ d(state)/dt of the group at a stage."""
    desk, quads, points = run.desk, run.quads, run.limits.shape[0]
    clock = 4.0 * s * s * s
    line = SLOPE + stage
    power = load(row, run, group, state, ground_at(group, s), line + SLOPES)
    for i in range(group.low, group.high):
        desk[line, i] = clock * desk[state + 1, i]
    for i in range(group.low, group.high):
        desk[line + SLOPES, i] *= clock
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.book[k, CLOSED] > 0.0:
            quads[stage, k] = clock * quads[SLOPES + 1, k]
            quads[stage, points + k] = clock * quads[SLOPES + 1, points + k]
    quads[stage, 2 * points] = clock * power


@kernel
def trial_state(run, group, line, h):
    """The state at a stage whose row of the table is given, into rows TRIAL."""
    desk, table = run.desk, run.board
    for i in range(group.low, group.high):
        desk[TRIAL, i] = desk[NOW, i]
        desk[TRIAL + 1, i] = desk[NOW + 1, i]
    place = 0
    while table[line, place] >= 0.0:
        weight = h * table[line, place + 1]
        source = SLOPE + int(table[line, place])
        for i in range(group.low, group.high):
            desk[TRIAL, i] += weight * desk[source, i]
        for i in range(group.low, group.high):
            desk[TRIAL + 1, i] += weight * desk[source + SLOPES, i]
        place += 2


@part
def explicit_attempt(row, run, group, s, h):
    """One step from rows NOW, whose slopes stand at stage 0, to rows END; returns its error.

    The error is that of `collide.explicit_attempt`, in the group's scales. The quadratures at the end stand in row
    SLOPES of ``quads``; they begin at zero with every step.
    """
    desk, table, points = run.desk, run.board, run.limits.shape[0]
    table[WHOLE, WORKED] += table[FINAL, COUNTED] * (group.high - group.low)
    for stage in range(1, int(table[FINAL, COUNTED])):
        trial_state(run, group, TABLE + stage, h)
        slopes(row, run, group, s + table[TABLE + stage, STAGE_NODE] * h, TRIAL, stage)
    end_weight = table[FINAL, END_WEIGHT]
    finish_state(row, run, group, h)
    if end_weight != 0.0:
        slopes(row, run, group, s + h, END, LAST)
    deep, fast = h / group.depth, h / group.speed
    deep, fast = deep * deep, fast * fast
    fifth = third = 0.0
    for i in range(group.low, group.high):
        a5 = b5 = a3 = b3 = 0.0
        place = 0
        while table[FINAL, place] >= 0.0:
            line = SLOPE + int(table[FINAL, place])
            u, v = desk[line, i], desk[line + SLOPES, i]
            a5, b5 = a5 + table[FINAL, place + 2] * u, b5 + table[FINAL, place + 2] * v
            a3, b3 = a3 + table[FINAL, place + 3] * u, b3 + table[FINAL, place + 3] * v
            place += 4
        if end_weight != 0.0:
            a5, b5 = a5 + end_weight * desk[SLOPE + LAST, i], b5 + end_weight * desk[SLOPE + LAST + SLOPES, i]
        fifth += deep * a5 * a5 + fast * b5 * b5
        third += deep * a3 * a3 + fast * b3 * b3
    # The sums of the contacts of the group.
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.book[k, CLOSED] > 0.0:
            sum_up(run, k, h)
            sum_up(run, points + k, h)
    sum_up(run, 2 * points, h)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@kernel
def finish_state(row, run, group, h):
    """The state at the end of a step, into rows END."""
    desk, table = run.desk, run.board
    for i in range(group.low, group.high):
        desk[END, i] = desk[NOW, i]
        desk[END + 1, i] = desk[NOW + 1, i]
    place = 0
    while table[FINAL, place] >= 0.0:
        weight = h * table[FINAL, place + 1]
        source = SLOPE + int(table[FINAL, place])
        if weight != 0.0:
            for i in range(group.low, group.high):
                desk[END, i] += weight * desk[source, i]
            for i in range(group.low, group.high):
                desk[END + 1, i] += weight * desk[source + SLOPES, i]
        place += 4


@kernel
def sum_up(run, column, h):
    """The change of one quadrature over a step, into row SLOPES."""
    total, place = 0.0, 0
    while run.board[FINAL, place] >= 0.0:
        total += run.board[FINAL, place + 1] * run.quads[int(run.board[FINAL, place]), column]
        place += 4
    run.quads[SLOPES, column] = h * total


@part
def explicit_spread(row, run, group, s, h):
    """The polynomial between both ends of the step just made, as `collide.explicit_spread`; slopes at LAST stand."""
    desk, table = run.desk, run.board
    for late in range(int(table[FINAL, LATES])):
        trial_state(run, group, LATE_TABLE + late, h)
        slopes(row, run, group, s + table[LATE_TABLE + late, STAGE_NODE] * h, TRIAL, LATE + late)
    for side in range(2):
        poly, line = POLY + side * TERMS, SLOPE + side * SLOPES
        for i in range(group.low, group.high):
            change = desk[END + side, i] - desk[NOW + side, i]
            desk[poly, i] = change
            desk[poly + 1, i] = h * desk[line, i] - change
            desk[poly + 2, i] = 2.0 * change - h * (desk[line, i] + desk[line + LAST, i])
        for term in range(TERMS - 3):
            for i in range(group.low, group.high):
                desk[poly + 3 + term, i] = 0.0
            place = 0
            while table[BETWEEN + term, place] >= 0.0:
                weight = h * table[BETWEEN + term, place + 1]
                # A row of the table past the stages stands for the end of the step and the late ones, as here.
                source = line + int(table[BETWEEN + term, place])
                for i in range(group.low, group.high):
                    desk[poly + 3 + term, i] += weight * desk[source, i]
                place += 2


@kernel
def between(run, part, i, x):
    """u (part 0) or v (part 1) of dof ``i`` at a place x of the step, 0 to 1, on the polynomial."""
    poly = POLY + part * TERMS
    rest = 1.0 - x
    total = run.desk[poly + TERMS - 1, i]
    for back in range(1, TERMS):
        term = TERMS - 1 - back
        total = run.desk[poly + term, i] + (rest if term % 2 == 0 else x) * total
    return run.desk[NOW + part, i] + x * total
