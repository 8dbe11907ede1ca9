"""Steps through contacts whose dampers are much quicker than the buildings: Radau IIA, as in `pair.implicit`.

An explicit step is stable only over some multiples of m/c, c = ∂F/∂δ̇. Where a contact is overdamped, e far below 0.1,
that may be a millionth of what the motion needs: neighbours that are pressed against each other creep. An implicit step
is as long as the motion allows. Its equations are solved by Newton's rule, with the derivatives of the contact forces
alone: within a step the buildings themselves move little, and what they do is found by iterating.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from pounding_risk._jit.compile import kernel
from pounding_risk._jit.memory import zeros
from pounding_risk.solver.pair.equations import ELASTIC, SHARE
from pounding_risk.solver.pair.implicit import (
    BEGIN_SLOPE,
    COEFFICIENTS,
    ITERATIONS,
    NODES,
    PARTS,
    POLYNOMIAL_OF_STAGES,
    SHORTEST,
    STIFF_ENOUGH,
    fill_response,
    fill_time_weights,
    is_solved,
    is_too_slow,
    scale_of_damped_depth,
    solve_linear,
)
from pounding_risk.solver.row.contact_points import across, compliance
from pounding_risk.solver.row.equations import slopes, uncapped
from pounding_risk.solver.row.explicit import explicit_attempt, write_explicit_polynomial
from pounding_risk.solver.row.inertia import response, subtract_response
from pounding_risk.solver.row.workspace import (
    END,
    INVERSE,
    LAST,
    MOBILITY,
    NOW,
    POLY,
    SLOPE,
    SLOPES,
    START,
    TERMS,
    TRIAL,
    VELOCITY,
)

# Rows of slopes that the explicit method needs for its other stages: u and v at the nodes, what v misses there.
AT_NODE, MISSING = SLOPE + PARTS, SLOPE + SLOPES + 2 * PARTS + 1


@kernel
def tangents(row, run, k, state):
    """(∂F/∂δ̇, ∂F/∂δ) of contact ``k``, its state in rows ``state`` [N s/m, N/m]; 0 where it is capped or cut."""
    contact = run.contacts[k]
    if contact.closed == 0.0 or int(contact.region) != ELASTIC:
        return 0.0, 0.0
    delta = max(across(row, k, run.dofs, state) - contact.gap, 0.0)
    rate = across(row, k, run.dofs, state + VELOCITY)
    force = uncapped(run, k, delta, rate)
    faster, deeper = 1e-3 * contact.speed_scale, 1e-4 * delta
    damper = (uncapped(run, k, delta, rate + faster) - force) / faster
    spring = (uncapped(run, k, delta + deeper, rate) - force) / deeper if deeper > 0.0 else 0.0
    return damper, spring


@kernel
def choose_method(row, run, group, s, h):
    """Set whether the next step is implicit: where the quickest damper acts many times within ``h``.

    A step once implicit stays so down to shorter ones, so that the choice does not alternate.
    """
    end = s + h
    time = end * end * end * end - s * s * s * s
    enough = SHORTEST if run.workspace.implicit > 0.0 else STIFF_ENOUGH
    quickest = 0.0
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            quickest = max(quickest, tangents(row, run, k, NOW)[0] * compliance(row, k))
    run.workspace.implicit = 1.0 if quickest * time > enough else 0.0


@kernel
def coupling(row, k, j):
    """B M⁻¹ Bᵀ between two contact points: how fast a force at one drives the other apart [1/kg]."""
    left = right = 0.0
    for end in range(4):
        i = row.ends[k, end]
        for far_end in range(4):
            far, product = row.ends[j, far_end], 0.0
            if i >= 0 and far == i:
                product = row.shares[k, end] * row.shares[j, far_end] * row.floors[MOBILITY, i]
            elif i >= 0 and far >= 0 and row.inertia.shape[1] > 0:
                product = row.shares[k, end] * row.shares[j, far_end] * response(row, i, far)
            if product != 0.0:
                if end < 2:
                    left += product
                else:
                    right += product
    return left + right


@kernel
def closed_points(row, run, group):
    """The closed contact points of the group, left to right."""
    count = 0
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        count += 1 if run.contacts[k].closed > 0.0 else 0
    points = zeros((count,), np.int64)
    count = 0
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            points[count] = k
            count += 1
    return points


@kernel
def newton_matrix(row, points, tables):
    """I + (B M⁻¹ Bᵀ) ⊗ responses, unknowns the changes of closing speed: contact by contact, node by node."""
    size = points.size * PARTS
    matrix = zeros((size, size), np.float64)
    for n in range(points.size):
        for m in range(points.size):
            share = coupling(row, points[n], points[m])
            if share != 0.0:
                for i in range(PARTS):
                    for j in range(PARTS):
                        matrix[n * PARTS + i, m * PARTS + j] = share * tables[m, i, j]
    for unknown in range(size):
        matrix[unknown, unknown] += 1.0
    return matrix


@kernel
def closing_changes(row, run, points, tables):
    """Changes of the closing speeds at the nodes that remove what is missing there, (contacts, nodes) [m/s].

    Solved from the left and from the right and averaged: a row and its mirror image move alike to the bit.
    """
    count = points.size
    changes = zeros((count, PARTS), np.float64)
    order = zeros((count,), np.int64)
    ordered_tables = zeros((count, PARTS, PARTS), np.float64)
    right = zeros((count * PARTS,), np.float64)
    for side in range(2):
        for n in range(count):
            source = n if side == 0 else count - 1 - n
            order[n] = points[source]
            for i in range(PARTS):
                for j in range(PARTS):
                    ordered_tables[n, i, j] = tables[source, i, j]
                right[n * PARTS + i] = across(row, order[n], run.dofs, MISSING + i)
        solve_linear(newton_matrix(row, order, ordered_tables), right)
        for n in range(count):
            target = n if side == 0 else count - 1 - n
            for i in range(PARTS):
                changes[target, i] += 0.5 * right[n * PARTS + i]
    return changes


@kernel
def correct(row, run, group, points, tables, changes):
    """Add to the speeds at the nodes what is missing there, less what the contact forces' answer takes of it."""
    dofs = run.dofs
    for i in range(PARTS):
        target = AT_NODE + SLOPES + 1 + i
        for dof in range(group.low, group.high):
            dofs[target, dof] += dofs[MISSING + i, dof]
        for n in range(points.size):
            k = points[n]
            impulse = 0.0
            for j in range(PARTS):
                impulse += tables[n, i, j] * changes[n, j]
            for end in range(4):
                dof = row.ends[k, end]
                if dof >= 0 and row.inertia.shape[1] > 0:
                    subtract_response(row, dof, row.shares[k, end] * impulse, dofs, target)
                elif dof >= 0:
                    dofs[target, dof] -= row.shares[k, end] * row.floors[INVERSE, dof] * impulse


@kernel
def evaluate_nodes(row, run, group, s, h, weights):
    """Displacements, slopes and missing speeds at the nodes from the speeds there; returns the largest of these."""
    dofs = run.dofs
    run.workspace.evaluations += PARTS * (group.high - group.low)
    for i in range(PARTS):
        for dof in range(group.low, group.high):
            total = 0.0
            for j in range(PARTS):
                total += weights[i, j] * dofs[AT_NODE + SLOPES + 1 + j, dof]
            dofs[AT_NODE + 1 + i, dof] = dofs[NOW, dof] + total
            dofs[TRIAL, dof] = dofs[AT_NODE + 1 + i, dof]
            dofs[TRIAL + VELOCITY, dof] = dofs[AT_NODE + SLOPES + 1 + i, dof]
        slopes(row, run, group, s + NODES[i] * h, TRIAL, 1 + i)
    largest = 0.0
    for i in range(PARTS):
        for dof in range(group.low, group.high):
            total = 0.0
            for j in range(PARTS):
                total += COEFFICIENTS[i, j] * dofs[SLOPE + SLOPES + 1 + j, dof]
            missing = dofs[NOW + VELOCITY, dof] + h * total - dofs[AT_NODE + SLOPES + 1 + i, dof]
            dofs[MISSING + i, dof] = missing
            largest = max(largest, abs(missing)) if missing == missing else inf
    return largest


@kernel
def implicit_attempt(row, run, group, s, h):
    """One implicit step, as `explicit.explicit_attempt`; infinite where its equations are not solved."""
    dofs = run.dofs
    points = closed_points(row, run, group)
    weights, table = zeros((PARTS, PARTS), np.float64), zeros((PARTS, PARTS), np.float64)
    fill_time_weights(s, h, weights)
    tables = zeros((points.size, PARTS, PARTS), np.float64)
    shallowest = group.depth
    for n in range(points.size):
        k = points[n]
        damper, spring = tangents(row, run, k, NOW)
        fill_response(weights, damper, spring, table)
        for i in range(PARTS):
            for j in range(PARTS):
                tables[n, i, j] = table[i, j]
        if damper > 0.0:
            shallowest = min(
                shallowest,
                scale_of_damped_depth(across(row, k, dofs, NOW) - run.contacts[k].gap, run.contacts[k].depth_scale),
            )
    for dof in range(group.low, group.high):
        for i in range(PARTS):
            dofs[AT_NODE + SLOPES + 1 + i, dof] = dofs[NOW + VELOCITY, dof]
    missing_before = inf
    for turn in range(ITERATIONS):
        missing = evaluate_nodes(row, run, group, s, h, weights)
        if is_solved(turn, missing, missing_before, SHARE * group.tolerance * group.speed):
            break
        if is_too_slow(turn, missing, missing_before):
            return inf
        missing_before = missing
        correct(row, run, group, points, tables, closing_changes(row, run, points, tables))
    end_step(row, run, group, points, h)
    if run.workspace.tableau.end_weight != 0.0:
        slopes(row, run, group, s + h, END, LAST)
    return begin_defect(run, group, h, shallowest)


@kernel
def end_step(row, run, group, points, h):
    """The last node, which is the end of the step, to rows END, and the quadratures to row SLOPES."""
    dofs, quadratures, all_points = run.dofs, run.quadratures, run.laws.shape[0]
    for dof in range(group.low, group.high):
        dofs[END, dof] = dofs[AT_NODE + PARTS, dof]
        dofs[END + VELOCITY, dof] = dofs[AT_NODE + SLOPES + PARTS, dof]
    for n in range(2 * points.size + 1):
        column = 2 * all_points
        if n < 2 * points.size:
            column = points[n // 2] + (all_points if n % 2 else 0)
        total = 0.0
        for j in range(PARTS):
            total += COEFFICIENTS[PARTS - 1, j] * quadratures[1 + j, column]
        quadratures[SLOPES, column] = h * total


@kernel
def begin_defect(run, group, h, depth):
    """The error of the step: how far its polynomial's slopes are off at its beginning, over the step, in the scales."""
    dofs = run.dofs
    total = 0.0
    for dof in range(group.low, group.high):
        u_defect, v_defect = -dofs[SLOPE, dof], -dofs[SLOPE + SLOPES, dof]
        for j in range(PARTS):
            u_defect += BEGIN_SLOPE[j] * dofs[SLOPE + 1 + j, dof]
            v_defect += BEGIN_SLOPE[j] * dofs[SLOPE + SLOPES + 1 + j, dof]
        u_defect, v_defect = u_defect / depth, v_defect / group.speed
        total += u_defect * u_defect + v_defect * v_defect
    return h * sqrt(total)


@kernel
def write_implicit_polynomial(run, group):
    """The polynomial of the implicit step just made, as `explicit.write_explicit_polynomial` writes it."""
    dofs = run.dofs
    for side in range(2):
        poly, nodes = POLY + side * TERMS, AT_NODE + side * SLOPES + 1
        for term in range(TERMS):
            for dof in range(group.low, group.high):
                total = 0.0
                if term < PARTS:
                    for i in range(PARTS - 1):
                        total += POLYNOMIAL_OF_STAGES[term, i] * (dofs[nodes + i, dof] - dofs[NOW + side, dof])
                    total += POLYNOMIAL_OF_STAGES[term, PARTS - 1] * (dofs[END + side, dof] - dofs[NOW + side, dof])
                dofs[poly + term, dof] = total


@kernel
def attempt(row, run, group, s, h):
    """One step from rows NOW, whose slopes stand at stage 0, to rows END; returns its error in the group's scales."""
    run.workspace.has_polynomial = 0.0
    if run.workspace.implicit > 0.0:
        return implicit_attempt(row, run, group, s, h)
    return explicit_attempt(row, run, group, s, h)


@kernel
def write_polynomial(row, run, group, s, h):
    """Write the polynomial between both ends of the step just made, unless it is written; slopes at LAST stand."""
    if run.workspace.has_polynomial > 0.0:
        return
    run.workspace.has_polynomial = 1.0
    if run.workspace.implicit > 0.0:
        write_implicit_polynomial(run, group)
    else:
        write_explicit_polynomial(row, run, group, s, h)
