"""Steps through a contact whose damper is much quicker than the buildings: Radau IIA of five stages.

An explicit step is stable only over some multiples of m/c, c = ∂F/∂δ̇. Where a contact is overdamped, e far below 0.1,
that may be a millionth of what the motion needs: bodies that are pressed against each other creep. The implicit step
solves the same equations and is as long as the motion allows. Its error estimate is what its polynomial's slopes are
off at the beginning of the step: in a stiff contact that is the error of the contact force, by the momentum that it
would move (Hairer and Wanner 1996, IV.8, filter it away; here the force is an output).
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import IMPLICIT, WORKED
from pounding_risk.solver.pair.equations import ELASTIC, SHARE, slopes, state_of, write_end_slopes
from pounding_risk.solver.pair.explicit import explicit_attempt, write_explicit_polynomial
from pounding_risk.solver.runge_kutta import RADAU
from pounding_risk.solver.workspace import BEGIN, END, FELT, FIRST_STAGE, TERMS

NODES, COEFFICIENTS, BEGIN_SLOPE, POLYNOMIAL_OF_STAGES = RADAU.c, RADAU.a, RADAU.start, RADAU.terms
PARTS = NODES.size  # nodes of a step

# A step is made implicit where the damper acts so many times within it. The explicit method is stable up to some six;
# below that its steps are the cheaper ones.
STIFF_ENOUGH, SHORTEST = 3.0, 1.0
LEAST_ITERATIONS, ITERATIONS = 2, 30
SHALLOWEST = 1e-6  # of the depth that the spring alone would allow
RESIDUE = 1e-2  # of the error that a step may make: what may be left of its equations
ROUNDED_RESIDUE = 0.3  # the same where iterating gains no more: rounding


@kernel
def solve_linear(matrix, right):
    """Solve ``matrix`` x = ``right`` by Gaussian elimination with row pivots; x is left in ``right``.

    The matrix is used up. The same on every machine, to the bit, which a library's is not.
    """
    size = right.size
    for column in range(size):
        pivot = column
        for i in range(column + 1, size):
            if abs(matrix[i, column]) > abs(matrix[pivot, column]):
                pivot = i
        if pivot != column:
            for j in range(column, size):
                matrix[column, j], matrix[pivot, j] = matrix[pivot, j], matrix[column, j]
            right[column], right[pivot] = right[pivot], right[column]
        for i in range(column + 1, size):
            factor = matrix[i, column] / matrix[column, column]
            if factor != 0.0:
                for j in range(column + 1, size):
                    matrix[i, j] -= factor * matrix[column, j]
                right[i] -= factor * right[column]
    for count_back in range(size):
        i = size - 1 - count_back
        total = right[i]
        for j in range(i + 1, size):
            total -= matrix[i, j] * right[j]
        right[i] = total / matrix[i, i]


@small
def scale_of_damped_depth(delta, depth):
    """The scale of penetration of a damped contact, which goes much less deep than its spring alone would let it."""
    return min(depth, max(delta, SHALLOWEST * depth))


@small
def is_too_slow(turn, missing, missing_before):
    """True where iterating further would cost more than a shorter step."""
    return turn + 1 == ITERATIONS or not missing < inf or (turn > 4 and missing > 0.7 * missing_before)


@small
def is_solved(turn, missing, missing_before, allowed):
    """True where the equations of a step are solved, ``missing`` now and one iteration before.

    The first guess is that nothing moves: on a short step it misses less than is allowed, and would never move.
    """
    if turn < LEAST_ITERATIONS:
        return False
    return missing <= RESIDUE * allowed or (missing > 0.5 * missing_before and missing <= ROUNDED_RESIDUE * allowed)


@small
def damper_of(impact, phase, state, force):
    """∂F/∂δ̇ of the contact [N s/m], which has this ``force``; 0 where the force is capped or cut."""
    if phase.region != ELASTIC:
        return 0.0
    u, w, v, z = state
    delta, faster = max(u - w - impact.gap, 0.0), 1e-3 * impact.speed_scale
    return (impact.law.force(impact.memory, delta, v - z + faster, phase.approaching) - force) / faster


@small
def spring_of(impact, phase, state, force):
    """∂F/∂δ of the contact [N/m], which has this ``force``; 0 where the force is capped or cut."""
    u, w, v, z = state
    delta = max(u - w - impact.gap, 0.0)
    deeper = 1e-4 * delta
    if phase.region != ELASTIC or deeper == 0.0:
        return 0.0
    return (impact.law.force(impact.memory, delta + deeper, v - z, phase.approaching) - force) / deeper


@small
def choose_method(impact, phase, s, h, workspace):
    """Set whether the next step is implicit: where the damper acts many times within ``h``.

    A step once implicit stays so down to shorter ones, so that the choice does not alternate.
    """
    end = s + h
    time = end * end * end * end - s * s * s * s
    enough = SHORTEST if workspace.counters[IMPLICIT] > 0.0 else STIFF_ENOUGH
    damper = damper_of(impact, phase, state_of(workspace.states, BEGIN), workspace.slopes[FIRST_STAGE, FELT])
    rate = damper * (impact.left.inverse_mass + impact.right.inverse_mass)
    workspace.counters[IMPLICIT] = 1.0 if rate * time > enough else 0.0


@small
def fill_time_weights(s, h, weights):
    """h a_ij dt/ds at node j: what a slope in time at node j adds at node i."""
    for j in range(PARTS):
        node_s = s + NODES[j] * h
        clock = h * 4.0 * node_s * node_s * node_s
        for i in range(PARTS):
            weights[i, j] = COEFFICIENTS[i, j] * clock


@small
def fill_response(weights, damper, spring, table):
    """Change of a contact's impulse up to node i by a change of its closing speed at node j, (nodes, nodes) [kg].

    The force changes by ∂F/∂δ̇ times that of the speed, and by ∂F/∂δ times that of the penetration, its sum.
    """
    for i in range(PARTS):
        for j in range(PARTS):
            total = 0.0
            for between in range(PARTS):
                total += weights[i, between] * weights[between, j]
            table[i, j] = damper * weights[i, j] + spring * total


@small
def evaluate_nodes(impact, phase, s, h, workspace):
    """Displacements, slopes and missing speeds at the nodes from the speeds there; returns the largest of these."""
    workspace.counters[WORKED] += PARTS
    weights = workspace.time_weights
    for i in range(PARTS):
        for body in range(2):
            total = 0.0
            for j in range(PARTS):
                total += weights[i, j] * workspace.node_states[j, 2 + body]
            workspace.node_states[i, body] = workspace.states[BEGIN, body] + total
        slopes(impact, phase, s + NODES[i] * h, state_of(workspace.node_states, i), workspace, 1 + i)
    largest = 0.0
    for i in range(PARTS):
        for body in range(2):
            total = 0.0
            for j in range(PARTS):
                total += COEFFICIENTS[i, j] * workspace.slopes[1 + j, 2 + body]
            missing = workspace.states[BEGIN, 2 + body] + h * total - workspace.node_states[i, 2 + body]
            workspace.missing_speeds[i, body] = missing
            largest = max(largest, abs(missing)) if missing == missing else inf
    return largest


@small
def correct(impact, workspace):
    """Add to the speeds at the nodes what is missing there, less what the contact force's answer takes of it."""
    left, right = impact.left.inverse_mass, impact.right.inverse_mass
    table, matrix, changes = workspace.response, workspace.matrix, workspace.changes
    for i in range(PARTS):
        for j in range(PARTS):
            matrix[i, j] = (left + right) * table[i, j]
        matrix[i, i] += 1.0
        changes[i] = workspace.missing_speeds[i, 0] - workspace.missing_speeds[i, 1]
    solve_linear(matrix, changes)
    for i in range(PARTS):
        impulse = 0.0
        for j in range(PARTS):
            impulse += table[i, j] * changes[j]
        workspace.node_states[i, 2] += workspace.missing_speeds[i, 0] - left * impulse
        workspace.node_states[i, 3] += workspace.missing_speeds[i, 1] + right * impulse


@small
def implicit_attempt(impact, phase, s, h, rtol, workspace):
    """One implicit step, as `explicit.explicit_attempt`; infinite where its equations are not solved."""
    state = state_of(workspace.states, BEGIN)
    force = workspace.slopes[FIRST_STAGE, FELT]
    damper, spring = damper_of(impact, phase, state, force), spring_of(impact, phase, state, force)
    fill_time_weights(s, h, workspace.time_weights)
    fill_response(workspace.time_weights, damper, spring, workspace.response)
    for i in range(PARTS):
        workspace.node_states[i, 2], workspace.node_states[i, 3] = state[2], state[3]
    missing_before = inf
    for turn in range(ITERATIONS):
        missing = evaluate_nodes(impact, phase, s, h, workspace)
        if is_solved(turn, missing, missing_before, SHARE * rtol * impact.speed_scale):
            break
        if is_too_slow(turn, missing, missing_before):
            return inf
        missing_before = missing
        correct(impact, workspace)
    for column in range(4):
        workspace.states[END, column] = workspace.node_states[PARTS - 1, column]
    for column in range(4, 7):
        total = 0.0
        for j in range(PARTS):
            total += COEFFICIENTS[PARTS - 1, j] * workspace.slopes[1 + j, column]
        workspace.states[END, column] = workspace.states[BEGIN, column] + h * total
    if workspace.tableau.end_weight != 0.0:
        write_end_slopes(impact, phase, s + h, workspace)
    delta = state[0] - state[1] - impact.gap
    depth = scale_of_damped_depth(delta, impact.depth_scale) if damper > 0.0 else impact.depth_scale
    return begin_defect(h, depth, impact.speed_scale, workspace)


@small
def begin_defect(h, depth, speed, workspace):
    """The error of the step: how far its polynomial's slopes are off at its beginning, over the step, in the scales.

    Both buildings' shares are added before the next kind of slope, so that a mirrored pair has the same bits.
    """
    total = 0.0
    for kind in range(2):
        scale, of_kind = depth if kind == 0 else speed, 0.0
        for column in range(2 * kind, 2 * kind + 2):
            off = -workspace.slopes[FIRST_STAGE, column]
            for j in range(PARTS):
                off += BEGIN_SLOPE[j] * workspace.slopes[1 + j, column]
            off = off / scale
            of_kind += off * off
        total += of_kind
    return h * sqrt(total)


@small
def write_implicit_polynomial(workspace):
    """The polynomial of the implicit step just made, as `explicit.write_explicit_polynomial` leaves it."""
    states = workspace.states
    for term in range(TERMS):
        for column in range(4):
            start, total = states[BEGIN, column], 0.0
            if term < PARTS:
                for i in range(PARTS - 1):
                    total += POLYNOMIAL_OF_STAGES[term, i] * (workspace.node_states[i, column] - start)
                total += POLYNOMIAL_OF_STAGES[term, PARTS - 1] * (states[END, column] - start)
            workspace.polynomial[term, column] = total


@small
def attempt(impact, phase, s, h, rtol, workspace):
    """One step from BEGIN, whose slopes are known, to END; returns its error in the contact's scales."""
    if workspace.counters[IMPLICIT] > 0.0:
        return implicit_attempt(impact, phase, s, h, rtol, workspace)
    return explicit_attempt(impact, phase, s, h, workspace)


@kernel
def write_polynomial(impact, phase, span, workspace):
    """Write the polynomial between both ends of the step just made, ``span`` = (s, h)."""
    if workspace.counters[IMPLICIT] > 0.0:
        write_implicit_polynomial(workspace)
    else:
        write_explicit_polynomial(impact, phase, span, workspace)
