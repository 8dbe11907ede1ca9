"""Explicit steps of a contact by a Runge-Kutta tableau, their length, and the polynomial of a step."""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.compile import small
from pounding_risk.solver.counters import WORKED
from pounding_risk.solver.pair.equations import SHARE, slopes, state_of, write_end_slopes
from pounding_risk.solver.workspace import BEGIN, END, FIRST_STAGE, LAST, TERMS

ROW_BITS = 31  # no fewer than rows of slopes


@small
def row_of(number):
    """A row of slopes from its number in the tableau.

    The mask changes nothing: it shows the compiler that no row is counted from the end, which it would look for at
    every one.
    """
    return int(number) & ROW_BITS


@small
def trial_state(weights, row, h, workspace):
    """The state at a stage whose row of the tableau is given."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    entry = 0
    while weights[row, entry] >= 0.0:
        weight = weights[row, entry + 1]
        u, w, v, z = state_of(workspace.slopes, row_of(weights[row, entry]))
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        entry += 2
    u, w, v, z = state_of(workspace.states, BEGIN)
    return u + h * a, w + h * b, v + h * c, z + h * d


@small
def explicit_attempt(impact, phase, s, h, workspace):
    """One step of the tableau from the state BEGIN, whose slopes are known, to END; returns its error.

    The error is that of the embedded pair (for DOP853, Hairer's 8(5,3)), in units of the contact's scales of
    penetration and speed. The tableau is read from an array: written out in the code it is no faster and takes ten
    times as long to compile, and sums of a known length fall to LLVM's loop vectoriser, which makes them half as
    fast again.
    """
    tableau = workspace.tableau
    final = tableau.final
    workspace.counters[WORKED] += tableau.stage_count
    for stage in range(1, int(tableau.stage_count)):
        trial = trial_state(tableau.stages, stage, h, workspace)
        slopes(impact, phase, s + tableau.stage_nodes[stage] * h, trial, workspace, stage)
    a, b, c, d, work, impulse, power = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    a5, b5, c5, d5, a3, b3, c3, d3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    entry = 0
    while final[entry] >= 0.0:
        row = row_of(final[entry])
        weight, fifth, third = final[entry + 1], final[entry + 2], final[entry + 3]
        u, w, v, z = state_of(workspace.slopes, row)
        a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
        a5, b5, c5, d5 = a5 + fifth * u, b5 + fifth * w, c5 + fifth * v, d5 + fifth * z
        a3, b3, c3, d3 = a3 + third * u, b3 + third * w, c3 + third * v, d3 + third * z
        work += weight * workspace.slopes[row, 4]
        impulse += weight * workspace.slopes[row, 5]
        power += weight * workspace.slopes[row, 6]
        entry += 4
    for column, change in enumerate((a, b, c, d, work, impulse, power)):
        workspace.states[END, column] = workspace.states[BEGIN, column] + h * change
    if tableau.end_weight != 0.0:
        write_end_slopes(impact, phase, s + h, workspace)
        weight = tableau.end_weight
        u, w, v, z = state_of(workspace.slopes, LAST)
        a5, b5, c5, d5 = a5 + weight * u, b5 + weight * w, c5 + weight * v, d5 + weight * z
    deep, fast = h / impact.depth_scale, h / impact.speed_scale
    fifth = deep * deep * (a5 * a5 + b5 * b5) + fast * fast * (c5 * c5 + d5 * d5)
    third = deep * deep * (a3 * a3 + b3 * b3) + fast * fast * (c3 * c3 + d3 * d3)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@small
def write_explicit_polynomial(impact, phase, span, workspace):
    """Write the polynomial between both ends of the step just made, ``span`` = (s, h).

    With x from 0 to 1: y = y0 + x (P0 + (1−x) (P1 + x (P2 + (1−x) (P3 + ...)))), Hairer's continuous extension.
    """
    s, h = span
    tableau, states, polynomial = workspace.tableau, workspace.states, workspace.polynomial
    for late in range(int(tableau.late_count)):
        trial = trial_state(tableau.late, late, h, workspace)
        slopes(impact, phase, s + tableau.late_nodes[late] * h, trial, workspace, LAST + 1 + late)
    for column in range(4):
        change = states[END, column] - states[BEGIN, column]
        start, end = workspace.slopes[FIRST_STAGE, column], workspace.slopes[LAST, column]
        polynomial[0, column] = change
        polynomial[1, column] = h * start - change
        polynomial[2, column] = 2.0 * change - h * (start + end)
    for row in range(TERMS - 3):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        entry = 0
        while tableau.polynomial[row, entry] >= 0.0:
            weight = tableau.polynomial[row, entry + 1]
            u, w, v, z = state_of(workspace.slopes, row_of(tableau.polynomial[row, entry]))
            a, b, c, d = a + weight * u, b + weight * w, c + weight * v, d + weight * z
            entry += 2
        for column, value in enumerate((a, b, c, d)):
            polynomial[3 + row, column] = h * value


@small
def state_between(x, workspace):
    """The state at a place x of the step, 0 to 1, on the polynomial."""
    one_minus_x = 1.0 - x
    a, b, c, d = state_of(workspace.polynomial, TERMS - 1)
    for lower in range(1, TERMS):
        row = TERMS - 1 - lower
        factor = one_minus_x if row % 2 == 0 else x
        u, w, v, z = state_of(workspace.polynomial, row)
        a, b, c, d = u + factor * a, w + factor * b, v + factor * c, z + factor * d
    u, w, v, z = state_of(workspace.states, BEGIN)
    return u + x * a, w + x * b, v + x * c, z + x * d


@small
def next_step(h, error, rtol, tableau):
    """Step length from the last one: 0.9 (SHARE rtol / error)^(1/order), kept within 1/5 and 5."""
    if error == 0.0:
        return 5.0 * h
    share = SHARE * rtol / error
    # Roots are several times faster than a power, and this is the usual method's.
    change = sqrt(sqrt(sqrt(share))) if tableau.exponent == 0.125 else share**tableau.exponent
    return h * min(5.0, max(0.2, 0.9 * change))
