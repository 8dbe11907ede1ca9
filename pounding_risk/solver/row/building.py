"""One building of a row: a chain of masses on storeys, its accelerations, its energy and its Taylor series.

    m ü_i = −(C u̇)_i − (K u)_i − V_i + V_{i+1} − m a_g,   V_i = k_i (u_i − u_{i−1}) + c_i

with the constants c_i of storeys that have yielded, and K of a building that is given by its stiffness matrix. While no
storey changes its branch the motion under a linear a_g is its own Taylor series.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.taylor import slope_at, value_at
from pounding_risk.solver.row.ground_dof import top_of, write_ground_series
from pounding_risk.solver.row.inertia import divide_by_mass, has_inertia, mass_product
from pounding_risk.solver.row.link import add_link_terms
from pounding_risk.solver.row.storey import is_lowest, storey_energy
from pounding_risk.solver.row.workspace import (
    ACROSS,
    BAND,
    CONSTANT,
    COUPLED,
    DRIVEN,
    FELT,
    FIRST,
    INVERSE,
    MASS,
    TANGENT,
    VELOCITY,
)


@small
def ground_load(row, line, i, pull):
    """Row ``line`` of the floors, one of STATIC, FELT and DRIVEN, of dof ``i`` times a_g, of each component."""
    load = row.floors[line, i] * pull.real
    if row.passage.components() > 1:
        load += row.floors[line + ACROSS, i] * pull.imag
    return load


@kernel
def accelerate(row, b, state, pull, dofs, out):
    """ü of building ``b`` without contact from rows ``state`` to row ``out``; ``pull`` is a_g.

    Returns the power that ground and dampers put in.
    """
    first, last = row.frame[FIRST, b], top_of(row, b)
    if last - first == 1 and row.frame[COUPLED, b] == 0:
        v, storey = dofs[state + VELOCITY, first], -(dofs[TANGENT, first] * dofs[state, first] + dofs[CONSTANT, first])
        push = (storey - row.floors[MASS, first] * pull.real) - row.damping[first, 0] * v
        dofs[out, first] = push * row.floors[INVERSE, first]
        return push * v - storey * v
    below, is_coupled = 0.0, row.frame[COUPLED, b] > 0
    for i in range(first, last):
        stands = is_lowest(row, first, i, is_coupled)
        force = dofs[TANGENT, i] * (dofs[state, i] - (0.0 if stands else below)) + dofs[CONSTANT, i]
        below = dofs[state, i]
        dofs[out, i] = -force
        if not stands:
            dofs[out, i - 1] += force
    subtract_coupling(row, b, state, dofs, out)
    storey_power = 0.0
    for i in range(first, last):
        storey_power += dofs[out, i] * dofs[state + VELOCITY, i]
        dofs[out, i] -= ground_load(row, DRIVEN, i, pull)
    subtract_damping(row, b, state + VELOCITY, dofs, out)
    power = -storey_power
    for i in range(first, last):
        power += dofs[out, i] * dofs[state + VELOCITY, i]
        dofs[out, i] *= row.floors[INVERSE, i]
    if has_inertia(row, b):
        divide_by_mass(row, b, dofs[out])
    return power


@kernel
def subtract_damping(row, b, speed, dofs, out):
    """Take the dampers' forces C · row ``speed`` from row ``out``; C is symmetric, and columns add up side by side."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    band = row.frame[BAND, b]
    for j in range(first, last):
        rate = dofs[speed, j]
        for i in range(max(first, j - band), min(last, j + band + 1)):
            dofs[out, i] -= row.damping[j, i - first] * rate


@small
def coupling_force(row, b, i, line, dofs):
    """(K u)_i of a coupled building, u in row ``line`` of the dofs."""
    first, force = row.frame[FIRST, b], 0.0
    for j in range(first, top_of(row, b)):
        force += row.coupling[i, j - first] * dofs[line, j]
    return force


@kernel
def subtract_coupling(row, b, line, dofs, out):
    """Take the forces K · row ``line`` from row ``out``, where the building has springs beside its storeys."""
    if row.frame[COUPLED, b] > 0:
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            dofs[out, i] -= coupling_force(row, b, i, line, dofs)


@kernel
def coupling_product(row, b, line, dofs):
    """xᵀ K x of a building's springs beside its storeys, x in row ``line`` of the dofs."""
    total = 0.0
    if row.frame[COUPLED, b] > 0:
        for i in range(row.frame[FIRST, b], top_of(row, b)):
            total += dofs[line, i] * coupling_force(row, b, i, line, dofs)
    return total


@kernel
def energy_of(row, b, state, dofs):
    """Kinetic energy and potential of the storeys' forces of one building [J]."""
    total, below = 0.0, 0.0
    first, is_coupled = row.frame[FIRST, b], row.frame[COUPLED, b] > 0
    for i in range(first, top_of(row, b)):
        drift = dofs[state, i] - (0.0 if is_lowest(row, first, i, is_coupled) else below)
        below = dofs[state, i]
        total += 0.5 * row.floors[MASS, i] * dofs[state + VELOCITY, i] ** 2 + storey_energy(row, dofs, i, drift)
    if is_coupled:
        total += 0.5 * coupling_product(row, b, state, dofs)
    if has_inertia(row, b):
        total += 0.5 * mass_product(row, b, dofs[state + VELOCITY])
    return total


@kernel
def write_series(row, run, b, state, ground, terms):
    """Taylor coefficients of every u of building ``b`` into ``run.series``; ``ground`` begins where they do."""
    pull, rise = ground.under(b)
    first, last = row.frame[FIRST, b], top_of(row, b)
    band, is_coupled = row.frame[BAND, b], row.frame[COUPLED, b] > 0
    series, dofs = run.series, run.dofs
    for i in range(first, last):
        series[i, 0] = run.dofs[state, i]
        series[i, 1] = run.dofs[state + VELOCITY, i]
    for i in range(last, row.frame[FIRST, b + 1]):  # braces
        series[i, 0], series[i, terms - 1] = run.dofs[state, i], 0.0
    for n in range(terms - 2):
        share = 1.0 / ((n + 1) * (n + 2))
        below = 0.0
        for i in range(first, last):
            is_bottom = is_lowest(row, first, i, is_coupled)
            force = dofs[TANGENT, i] * (series[i, n] - (0.0 if is_bottom else below))
            if n == 0:
                force += dofs[CONSTANT, i]
            below = series[i, n]
            series[i, n + 2] = -force
            if not is_bottom:
                series[i - 1, n + 2] += force
        push_of_ground = pull if n == 0 else (rise if n == 1 else 0.0)
        for i in range(first, last):
            drag = 0.0
            for j in range(max(first, i - band), min(last, i + band + 1)):
                drag += row.damping[i, j - first] * series[j, n + 1]
            force = series[i, n + 2]
            if is_coupled:
                for j in range(first, last):
                    force -= row.coupling[i, j - first] * series[j, n]
            push = (force - (n + 1) * drag) * row.floors[INVERSE, i] - ground_load(row, FELT, i, push_of_ground)
            series[i, n + 2] = push * share
        if is_coupled:
            add_link_terms(row, run, b, n, share)
        if has_inertia(row, b):
            divide_by_mass(row, b, series[:, n + 2])
    write_ground_series(row, b, ground, series, terms)


@kernel
def place_on(row, run, b, x, terms, state):
    """Write rows ``state`` of building ``b`` at x on its series."""
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        run.dofs[state, i] = value_at(run.series, i, terms, x)
        run.dofs[state + VELOCITY, i] = slope_at(run.series, i, terms, x)
