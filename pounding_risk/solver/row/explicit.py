"""Explicit steps of a group in contact, by the tableau that the pair's contacts use, and the polynomial of a step."""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.explicit import row_of
from pounding_risk.solver.row.equations import slopes
from pounding_risk.solver.row.workspace import END, LAST, LATE, NOW, POLY, SLOPE, SLOPES, START, TERMS, TRIAL, VELOCITY

FEW = 16  # dofs: with more of them a stage's slopes are added to all dofs at once, which the processor does in lanes


@kernel
def trial_state(run, group, weights, row, h):
    """The state at a stage whose row of the table is given, into rows TRIAL."""
    dofs = run.dofs
    if group.high - group.low <= FEW:
        for i in range(group.low, group.high, 2):
            write_two_dofs(dofs, weights, row, h, (i, min(i + 1, group.high - 1)))
        return
    for i in range(group.low, group.high):
        dofs[TRIAL, i] = dofs[NOW, i]
        dofs[TRIAL + VELOCITY, i] = dofs[NOW + VELOCITY, i]
    entry = 0
    while weights[row, entry] >= 0.0:
        weight = h * weights[row, entry + 1]
        source = SLOPE + int(weights[row, entry])
        for i in range(group.low, group.high):
            dofs[TRIAL, i] += weight * dofs[source, i]
        for i in range(group.low, group.high):
            dofs[TRIAL + VELOCITY, i] += weight * dofs[source + SLOPES, i]
        entry += 2


@small
def write_two_dofs(dofs, weights, row, h, two):
    """As `trial_state`, of two dofs, or twice of one: their sums over the stages stay in registers."""
    i, j = two
    u, w, v, z = dofs[NOW, i], dofs[NOW, j], dofs[NOW + VELOCITY, i], dofs[NOW + VELOCITY, j]
    entry = 0
    while weights[row, entry] >= 0.0:
        weight = h * weights[row, entry + 1]
        source = SLOPE + row_of(weights[row, entry])
        u, w = u + weight * dofs[source, i], w + weight * dofs[source, j]
        v, z = v + weight * dofs[source + SLOPES, i], z + weight * dofs[source + SLOPES, j]
        entry += 2
    dofs[TRIAL, i], dofs[TRIAL, j], dofs[TRIAL + VELOCITY, i], dofs[TRIAL + VELOCITY, j] = u, w, v, z


@kernel
def explicit_attempt(row, run, group, s, h):
    """One step from rows NOW, whose slopes stand at stage 0, to rows END; returns its error.

    The error is that of `pair.explicit.explicit_attempt`, in the group's scales. The quadratures at the end stand in
    row SLOPES of ``quadratures``; they begin at zero with every step.
    """
    dofs, tableau, points = run.dofs, run.workspace.tableau, run.laws.shape[0]
    final = tableau.final
    run.workspace.evaluations += tableau.stage_count * (group.high - group.low)
    for stage in range(1, int(tableau.stage_count)):
        trial_state(run, group, tableau.stages, stage, h)
        slopes(row, run, group, s + tableau.stage_nodes[stage] * h, TRIAL, stage)
    end_weight = tableau.end_weight
    finish_state(row, run, group, h)
    if end_weight != 0.0:
        slopes(row, run, group, s + h, END, LAST)
    deep, fast = h / group.depth, h / group.speed
    deep, fast = deep * deep, fast * fast
    fifth = third = 0.0
    for i in range(group.low, group.high):
        a5 = b5 = a3 = b3 = 0.0
        entry = 0
        while final[entry] >= 0.0:
            line = SLOPE + row_of(final[entry])
            u, v = dofs[line, i], dofs[line + SLOPES, i]
            a5, b5 = a5 + final[entry + 2] * u, b5 + final[entry + 2] * v
            a3, b3 = a3 + final[entry + 3] * u, b3 + final[entry + 3] * v
            entry += 4
        if end_weight != 0.0:
            a5, b5 = a5 + end_weight * dofs[SLOPE + LAST, i], b5 + end_weight * dofs[SLOPE + LAST + SLOPES, i]
        fifth += deep * a5 * a5 + fast * b5 * b5
        third += deep * a3 * a3 + fast * b3 * b3
    # The sums of the contacts of the group.
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            sum_quadratures(run, k, points + k, h)
    sum_quadratures(run, 2 * points, 2 * points, h)
    if fifth == 0.0:
        return 0.0
    return fifth / sqrt(4.0 * (fifth + 0.01 * third))


@kernel
def finish_state(row, run, group, h):
    """The state at the end of a step, into rows END."""
    dofs, final = run.dofs, run.workspace.tableau.final
    if group.high - group.low <= FEW:
        for i in range(group.low, group.high, 2):
            finish_two_dofs(dofs, final, h, (i, min(i + 1, group.high - 1)))
        return
    for i in range(group.low, group.high):
        dofs[END, i] = dofs[NOW, i]
        dofs[END + VELOCITY, i] = dofs[NOW + VELOCITY, i]
    entry = 0
    while final[entry] >= 0.0:
        weight = h * final[entry + 1]
        source = SLOPE + int(final[entry])
        if weight != 0.0:
            for i in range(group.low, group.high):
                dofs[END, i] += weight * dofs[source, i]
            for i in range(group.low, group.high):
                dofs[END + VELOCITY, i] += weight * dofs[source + SLOPES, i]
        entry += 4


@small
def finish_two_dofs(dofs, final, h, two):
    """As `finish_state`, of two dofs, or twice of one."""
    i, j = two
    u, w, v, z = dofs[NOW, i], dofs[NOW, j], dofs[NOW + VELOCITY, i], dofs[NOW + VELOCITY, j]
    entry = 0
    while final[entry] >= 0.0:
        weight = h * final[entry + 1]
        source = SLOPE + row_of(final[entry])
        if weight != 0.0:
            u, w = u + weight * dofs[source, i], w + weight * dofs[source, j]
            v, z = v + weight * dofs[source + SLOPES, i], z + weight * dofs[source + SLOPES, j]
        entry += 4
    dofs[END, i], dofs[END, j], dofs[END + VELOCITY, i], dofs[END + VELOCITY, j] = u, w, v, z


@small
def sum_quadratures(run, first, second, h):
    """The changes of two quadratures over a step, or twice of one, into row SLOPES."""
    final, quadratures = run.workspace.tableau.final, run.quadratures
    total = other = 0.0
    entry = 0
    while final[entry] >= 0.0:
        weight, stage = final[entry + 1], row_of(final[entry])
        total, other = total + weight * quadratures[stage, first], other + weight * quadratures[stage, second]
        entry += 4
    quadratures[SLOPES, first], quadratures[SLOPES, second] = h * total, h * other


@kernel
def write_explicit_polynomial(row, run, group, s, h):
    """The polynomial between both ends of the step just made, as in `pair.explicit`; slopes at LAST are known."""
    dofs, tableau = run.dofs, run.workspace.tableau
    for late in range(int(tableau.late_count)):
        trial_state(run, group, tableau.late, late, h)
        slopes(row, run, group, s + tableau.late_nodes[late] * h, TRIAL, LATE + late)
    for side in range(2):
        poly, line = POLY + side * TERMS, SLOPE + side * SLOPES
        for i in range(group.low, group.high):
            change = dofs[END + side, i] - dofs[NOW + side, i]
            dofs[poly, i] = change
            dofs[poly + 1, i] = h * dofs[line, i] - change
            dofs[poly + 2, i] = 2.0 * change - h * (dofs[line, i] + dofs[line + LAST, i])
        for term in range(TERMS - 3):
            for i in range(group.low, group.high):
                dofs[poly + 3 + term, i] = 0.0
            entry = 0
            while tableau.polynomial[term, entry] >= 0.0:
                weight = h * tableau.polynomial[term, entry + 1]
                # A row of the table past the stages stands for the end of the step and the late ones, as here.
                source = line + int(tableau.polynomial[term, entry])
                for i in range(group.low, group.high):
                    dofs[poly + 3 + term, i] += weight * dofs[source, i]
                entry += 2


@kernel
def between(run, part, i, x):
    """u (part 0) or v (part 1) of dof ``i`` at a place x of the step, 0 to 1, on the polynomial."""
    poly = POLY + part * TERMS
    one_minus_x = 1.0 - x
    total = run.dofs[poly + TERMS - 1, i]
    for lower in range(1, TERMS):
        term = TERMS - 1 - lower
        total = run.dofs[poly + term, i] + (one_minus_x if term % 2 == 0 else x) * total
    return run.dofs[NOW + part, i] + x * total
