"""Mass matrices of buildings whose masses are not lumped at their floors: M = L Lᵀ (Cholesky), and M⁻¹.

Kernels of `building`, `equations` and `flight_peaks` sum the forces on the floors of such a building, where they write
accelerations of others, and have them divided by M here.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.workspace import COUPLED, FIRST, MOBILITY


@small
def has_inertia(row, b):
    """True where building ``b`` has a mass matrix."""
    return row.frame[COUPLED, b] > 1


@kernel
def divide_by_mass(row, b, values):
    """M⁻¹ times the values of the dofs of building ``b``, in their place: L y = f, Lᵀ x = y."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    for i in range(first, last):
        value = values[i]
        for j in range(first, i):
            value -= row.inertia[i, j - first] * values[j]
        values[i] = value / row.inertia[i, i - first]
    for n in range(last - first):
        i = last - 1 - n
        value = values[i]
        for j in range(i + 1, last):
            value -= row.inertia[j, i - first] * values[j]
        values[i] = value / row.inertia[i, i - first]


@kernel
def mass_product(row, b, values):
    """xᵀ M x of the values of the dofs of building ``b``: |Lᵀ x|²."""
    first, last, total = row.frame[FIRST, b], top_of(row, b), 0.0
    for j in range(first, last):
        part = 0.0
        for i in range(j, last):
            part += row.inertia[i, j - first] * values[i]
        total += part * part
    return total


@kernel
def building_with(row, i):
    """The building of dof ``i``, −1 where it has no mass matrix."""
    b = 0
    while row.frame[FIRST, b + 1] <= i:
        b += 1
    return b if has_inertia(row, b) else -1


@kernel
def response(row, i, j):
    """(M⁻¹)_ij of two dofs of the row [1/kg]."""
    if i == j:
        return row.floors[MOBILITY, i]
    b = building_with(row, i)
    if b < 0 or not row.frame[FIRST, b] <= j < top_of(row, b):
        return 0.0
    return row.inertia[i, row.inertia.shape[1] // 2 + j - row.frame[FIRST, b]]


@kernel
def subtract_response(row, i, impulse, dofs, line):
    """Take from row ``line`` of speeds what an impulse on dof ``i`` of a row with mass matrices gives [N s]."""
    b = building_with(row, i)
    for j in range(row.frame[FIRST, b], top_of(row, b)) if b >= 0 else range(i, i + 1):
        dofs[line, j] -= response(row, i, j) * impulse
