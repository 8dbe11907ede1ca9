"""A storey that can yield, V = TANGENT d + CONSTANT on each branch: bilinear, or by a law of its own.

A storey with a law (`models.structures.hysteresis`) asks it at each event for the branch that follows. Without one it
is a bilinear spring with kinematic hardening. Elastic about its plastic drift p, V = k d − (1 − α) k p; past its limit
L, V = α k d ± (1 − α) k L. It yields where d − p passes ± L and turns back where the drift's rate does; then p = d ∓ L.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import COMING, DIRECTION, POTENTIAL, SLOPE, STIFFNESS
from pounding_risk.models.structures.hysteresis._numbers import CONSTANT as LAW_CONSTANT
from pounding_risk.solver.counters import COLLAPSED
from pounding_risk.solver.pair.taylor import SIGNAL, first_rise
from pounding_risk.solver.row.law_events import OVER, advance_law, next_event_of_law
from pounding_risk.solver.row.link import is_link_of, next_event_of_link, switch_link
from pounding_risk.solver.row.workspace import (
    BOTTOM,
    BRANCH,
    CONSTANT,
    FIRST,
    LIMIT,
    MOBILITY,
    PLASTIC,
    SHEAR,
    SOFT,
    SPRING,
    TANGENT,
)


@small
def is_lowest(row, first, i, is_coupled):
    """True for the lowest storey of a building, ``first`` the body's first dof: a coupled body may hold several."""
    return i == first or (is_coupled and row.floors[BOTTOM, i] > 0.0)


@kernel
def set_branch(row, dofs, i, branch):
    """Set a storey's branch: 0 elastic about its plastic drift, ±1 yielding."""
    dofs[BRANCH, i] = branch
    soft = row.floors[SOFT, i]
    if branch == 0.0:
        dofs[TANGENT, i] = row.floors[SPRING, i]
        dofs[CONSTANT, i] = -soft * dofs[PLASTIC, i]
    else:
        dofs[TANGENT, i] = row.floors[SPRING, i] - soft
        dofs[CONSTANT, i] = branch * soft * row.floors[LIMIT, i]


@kernel
def shear_stiffness(row, dofs, i):
    """What storey shear a further drift brings [N/m]: without the part of p_delta."""
    return row.floors[SHEAR, i] + (dofs[TANGENT, i] - row.floors[SPRING, i])


@kernel
def storey_energy(row, dofs, i, drift):
    """Potential of a storey's force [J]: about its plastic drift, so that one which has yielded does not fall below 0.

    Continuous where the storey yields; where it turns, what yielding has taken leaves it.
    """
    total = 0.5 * dofs[TANGENT, i] * drift * drift
    if row.floors[SOFT, i] == 0.0:
        return total + dofs[CONSTANT, i] * drift + dofs[PLASTIC, i]  # elastic, both are 0; of a law, its branch's
    soft, plastic_drift = row.floors[SOFT, i], dofs[PLASTIC, i]
    if dofs[BRANCH, i] == 0.0:
        return total + dofs[CONSTANT, i] * drift + 0.5 * soft * plastic_drift * plastic_drift
    return total + dofs[CONSTANT, i] * (drift - plastic_drift) - 0.5 * soft * row.floors[LIMIT, i] ** 2


@small
def drift_in(row, dofs, line, i):
    """Drift of the storey below dof ``i`` from a row of `Run.dofs`."""
    return dofs[line, i] - (dofs[line, i - 1] if i > 0 and row.floors[BOTTOM, i] == 0.0 else 0.0)


@kernel
def creep_rate(row, i):
    """Drift rate against the yielding that is rounding, and no unloading [m/s]."""
    return (OVER - 1.0) * row.floors[LIMIT, i] * sqrt(row.floors[SPRING, i] * row.floors[MOBILITY, i])


@small
def has_law(run, i):
    """True where the storey below dof ``i`` has a law of its own."""
    return run.storeys.shape[1] > 0 and run.storeys[i, STIFFNESS] > 0.0


@kernel
def advance_storey(row, run, i, event, drift):
    """Follow the law of a storey past an event; a storey that has collapsed ends the run."""
    numbers, dofs = run.storeys, run.dofs
    if advance_law(numbers, run.workspace.law_arguments, i, event, drift):
        run.workspace.status = float(COLLAPSED)
        return
    # P-delta acts beside the law.
    geometric = row.floors[SPRING, i] - row.floors[SHEAR, i]
    dofs[TANGENT, i], dofs[CONSTANT, i] = numbers[i, SLOPE] + geometric, numbers[i, LAW_CONSTANT]
    dofs[BRANCH, i], dofs[PLASTIC, i] = numbers[i, DIRECTION], numbers[i, POTENTIAL]


@kernel
def next_strain(row, run, i, stop, terms):
    """When the storey below dof ``i`` changes its branch on (0, stop] of a flight, or −1."""
    search, series, dofs = run.workspace.search, run.series, run.dofs
    bottom = row.floors[BOTTOM, i] > 0.0
    if has_law(run, i):
        spare = row.floors.shape[1]
        for n in range(terms):
            series[spare, n] = series[i, n] - (0.0 if bottom else series[i - 1, n])
        return next_event_of_law(run, run.storeys, i, spare, stop, terms)
    branch = dofs[BRANCH, i]
    if branch != 0.0:
        for n in range(terms - 1):
            rate = (n + 1) * (series[i, n + 1] - (0.0 if bottom else series[i - 1, n + 1]))
            search.series[SIGNAL, n] = -branch * rate
        return first_rise(search, terms - 1, creep_rate(row, i), stop)
    earliest = -1.0
    for side in range(2):
        sign = 1.0 - 2.0 * side
        for n in range(terms):
            search.series[SIGNAL, n] = sign * (series[i, n] - (0.0 if bottom else series[i - 1, n]))
        level = OVER * row.floors[LIMIT, i] + sign * dofs[PLASTIC, i]
        time = first_rise(search, terms, level, stop if earliest < 0.0 else earliest)
        earliest = time if time >= 0.0 else earliest
    return earliest


@kernel
def switch_storey(row, run, i, line):
    """The storey below dof ``i`` changes its branch, its state in rows ``line``; returns how its potential changes.

    Links with laws are counted behind the dofs.
    """
    if i >= row.floors.shape[1]:
        return switch_link(row, run, i - row.floors.shape[1], line)
    dofs = run.dofs
    drift = drift_in(row, run.dofs, line, i)
    energy_before = storey_energy(row, dofs, i, drift)
    branch = dofs[BRANCH, i]
    if has_law(run, i):
        advance_storey(row, run, i, run.storeys[i, COMING], drift)
    elif branch == 0.0:
        set_branch(row, dofs, i, 1.0 if drift > dofs[PLASTIC, i] else -1.0)
    else:
        dofs[PLASTIC, i] = drift - branch * row.floors[LIMIT, i]
        set_branch(row, dofs, i, 0.0)
    return storey_energy(row, dofs, i, drift) - energy_before


@kernel
def first_strain(row, run, b, stop, terms):
    """(when, which) storey of building ``b`` changes its branch first on (0, stop] of a flight; (stop, −1) for none.

    Links with laws are counted behind the dofs.
    """
    storey = -1
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        if row.floors[LIMIT, i] < inf:
            time = next_strain(row, run, i, stop, terms)
            if time >= 0.0:
                stop, storey = time, i
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, b, b):
            time = next_event_of_link(row, run, k, stop, terms)
            if time >= 0.0:
                stop, storey = time, row.floors.shape[1] + k
    return stop, storey
