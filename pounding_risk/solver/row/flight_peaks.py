"""Peaks of a building in flight, and the bounds that tell where they have to be searched for.

While no storey changes its branch, y = u̇ + K⁻¹ M 1 · (slope of a_g) is a free vibration under a linear a_g, and so are
its derivatives. The energy of a free vibration only falls, which bounds every derivative of the motion from what it is
at the start:

    |ü_i| ≤ sqrt(2 E / m_i),   2 E = Σ m ü² + Σ k (y_i − y_{i−1})² + yᵀ K y,

K that of springs beside the storeys.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.taylor import highest, local_maximum_bound
from pounding_risk.solver.row.building import (
    coupling_product,
    ground_load,
    subtract_coupling,
    subtract_damping,
    write_series,
)
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.inertia import divide_by_mass, has_inertia, mass_product
from pounding_risk.solver.row.storey import is_lowest, shear_stiffness
from pounding_risk.solver.row.workspace import (
    ACCEL_NUDGED,
    ACCELERATION,
    BOTTOM,
    BOUNDS,
    CAN_YIELD,
    CONSTANT,
    COUPLED,
    DISPLACEMENT,
    DRIFT,
    FELT,
    FIRST,
    GIVE,
    INVERSE,
    MASS,
    QUICK,
    ROOT,
    STATIC,
    STOREY_FORCE,
    TANGENT,
    VELOCITY,
)
from pounding_risk.solver.workspace import SIGNAL


@kernel
def motion_bound(row, b, rise, dofs, state, accelerations):
    """2 E of building ``b``, |ü_i| ≤ sqrt(2 E / m_i), while a_g rises by ``rise``; ü in row ``accelerations``."""
    motion, below = 0.0, 0.0
    first, is_coupled = row.frame[FIRST, b], row.frame[COUPLED, b] > 0
    for i in range(first, top_of(row, b)):
        below = 0.0 if is_lowest(row, first, i, is_coupled) else below
        y = dofs[state + VELOCITY, i] + row.floors[STATIC, i] * rise.real
        motion += row.floors[MASS, i] * dofs[accelerations, i] ** 2 + dofs[TANGENT, i] * (y - below) ** 2
        below = y
    if has_inertia(row, b):
        motion += mass_product(row, b, dofs[accelerations])
    return motion + coupled_motion(row, b, rise, dofs, state)


@kernel
def coupled_motion(row, b, rise, dofs, state):
    """yᵀ K y of `motion_bound`, of the springs beside the storeys."""
    total, first, last = 0.0, row.frame[FIRST, b], top_of(row, b)
    if row.frame[COUPLED, b] > 0:
        for i in range(first, last):
            force = 0.0
            for j in range(first, last):
                y = dofs[state + VELOCITY, j] + ground_load(row, STATIC, j, rise)
                force += row.coupling[i, j - first] * y
            total += (dofs[state + VELOCITY, i] + ground_load(row, STATIC, i, rise)) * force
    return total


@kernel
def shake_bound(row, b, rise, dofs, state, accelerations, spare):
    """The same of the second derivative of ü, for peaks of acceleration; ``spare`` are two free rows."""
    # Third and fourth derivatives of u, by the same equation once and twice differentiated.
    differentiate_motion(row, b, dofs, state + VELOCITY, accelerations, rise, spare)
    differentiate_motion(row, b, dofs, accelerations, spare, 0.0, spare + 1)
    shake, below = 0.0, 0.0
    first, is_coupled = row.frame[FIRST, b], row.frame[COUPLED, b] > 0
    for i in range(first, top_of(row, b)):
        below = 0.0 if is_lowest(row, first, i, is_coupled) else below
        shake += row.floors[MASS, i] * dofs[spare + 1, i] ** 2 + dofs[TANGENT, i] * (dofs[spare, i] - below) ** 2
        below = dofs[spare, i]
    if has_inertia(row, b):
        shake += mass_product(row, b, dofs[spare + 1])
    return shake + coupling_product(row, b, spare, dofs)


@kernel
def differentiate_motion(row, b, dofs, displacements, velocities, ground, out):
    """−M⁻¹ (C · row ``velocities`` + K · row ``displacements``) − ``ground`` into row ``out``."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    below, is_coupled = 0.0, row.frame[COUPLED, b] > 0
    for i in range(first, last):
        stands = is_lowest(row, first, i, is_coupled)
        force = dofs[TANGENT, i] * (dofs[displacements, i] - (0.0 if stands else below))
        below = dofs[displacements, i]
        dofs[out, i] = -force
        if not stands:
            dofs[out, i - 1] += force
    subtract_coupling(row, b, displacements, dofs, out)
    subtract_damping(row, b, velocities, dofs, out)
    for i in range(first, last):
        dofs[out, i] = dofs[out, i] * row.floors[INVERSE, i] - ground_load(row, FELT, i, ground)
    if has_inertia(row, b):
        divide_by_mass(row, b, dofs[out])


@kernel
def write_signal(row, run, signal, i, under, terms):
    """The Taylor series of a watched signal of dof ``i`` to the workspace; returns its number of terms.

    ``under`` = (a_g at the start of the series, its slope). The storey shear is that of `SHEAR` and of the
    yielding part.
    """
    signals, series = run.workspace.search.series, run.series
    if signal == ACCELERATION:
        for n in range(terms - 2):
            signals[SIGNAL, n] = (n + 1) * (n + 2) * series[i, n + 2]
        signals[SIGNAL, 0] += under[0].real
        signals[SIGNAL, 1] += under[1].real
        return terms - 2
    bottom = row.floors[BOTTOM, i] > 0.0
    for n in range(terms):
        signals[SIGNAL, n] = series[i, n] - (series[i - 1, n] if signal != DISPLACEMENT and not bottom else 0.0)
    if signal == STOREY_FORCE:
        stiffness = shear_stiffness(row, run.dofs, i)
        for n in range(terms):
            signals[SIGNAL, n] *= stiffness
        signals[SIGNAL, 0] += run.dofs[CONSTANT, i]
    return terms


@kernel
def raise_flight_peaks(row, run, b, ground, stop, terms):
    """Raise the peaks of building ``b`` by those of its series on [0, stop]; ``ground`` begins where they do.

    A signal is searched only where the sum of its terms' sizes passes its peak.
    """
    first, last = row.frame[FIRST, b], top_of(row, b)
    dofs, series = run.dofs, run.series
    pull, rise = ground.under(b)
    is_coupled = row.frame[COUPLED, b] > 0
    for i in range(first, last):
        has_below = not is_lowest(row, first, i, is_coupled)
        reach = drift = shake = 0.0
        power = 1.0
        for n in range(terms):
            below = series[i - 1, n] if has_below else 0.0
            reach += power * abs(series[i, n])
            drift += power * abs(series[i, n] - below)
            if n + 2 < terms:
                shake += power * abs((n + 1) * (n + 2) * series[i, n + 2])
            power *= stop
        shake += abs(pull.real) + abs(rise.real) * stop
        # Put so that what is not finite is searched.
        if not reach <= dofs[DISPLACEMENT, i]:
            raise_signal(row, run, DISPLACEMENT, i, (pull, rise), stop, terms)
        if not drift <= dofs[DRIFT, i]:
            raise_signal(row, run, DRIFT, i, (pull, rise), stop, terms)
        if not shake <= dofs[ACCELERATION, i]:
            raise_signal(row, run, ACCELERATION, i, (pull, rise), stop, terms)
        if (
            row.frame[CAN_YIELD, b]
            and not shear_stiffness(row, dofs, i) * drift + abs(dofs[CONSTANT, i]) <= dofs[STOREY_FORCE, i]
        ):
            raise_signal(row, run, STOREY_FORCE, i, (pull, rise), stop, terms)


@kernel
def raise_signal(row, run, signal, i, under, stop, terms):
    """Raise the peak of one signal by that of its series on [0, stop]."""
    count = write_signal(row, run, signal, i, under, terms)
    best = highest(run.workspace.search, SIGNAL, count, 1.0, stop, run.dofs[signal, i])
    run.dofs[signal, i] = highest(run.workspace.search, SIGNAL, count, -1.0, stop, best)


@small
def size_bound(start, stop, span, bend):
    """The largest size of a function with |f''| ≤ ``bend`` and these values at the ends of the span."""
    return max(local_maximum_bound(start, stop, span, bend), local_maximum_bound(-start, -stop, span, bend))


@kernel
def raise_interval_peaks(row, run, b, ends, motion, window, terms):
    """Peaks of a building over one node interval of free flight; the search only where a bound does not settle it.

    ``ends`` = (rows of states at the start, at the end, of ü at the start, at the end), ``motion`` as `motion_bound`,
    ``window`` as `ground.window_at`.
    The bounds from the energy of the motion come first, that on the shaking (ω + c)² times as large, ω the fastest mode
    and c the strongest damper: they settle most intervals. Then those from the energies of its derivatives, which let a
    second derivative grow only so fast from what it is at the start. Rows BOUNDS are raised by the bounds, which lie
    above the peaks.
    """
    first, last = row.frame[FIRST, b], top_of(row, b)
    if last == first:
        return  # a rigid building has no mass, and as the last one no place in the arrays either
    dofs = run.dofs
    _, step, ground = window
    pull, rise = ground.under(b)
    eighth = 0.125 * step * step
    swing, has_series, has_exact_bound = sqrt(motion), False, False
    shake, is_coupled = row.floors[QUICK, first] * swing, row.frame[COUPLED, b] > 0
    start_below = end_below = bend_below = turn_below = 0.0
    for i in range(first, last):
        if is_coupled and row.floors[BOTTOM, i] > 0.0:
            start_below = end_below = bend_below = turn_below = 0.0
        root, turn = row.floors[ROOT, i], dofs[ends[2], i]
        bend = swing * root
        start, end = dofs[ends[0], i], dofs[ends[1], i]
        drift, drift_end = start - start_below, end - end_below
        felt_start, felt_end = turn + pull.real, dofs[ends[3], i] + (pull.real + rise.real * step)
        dofs[DISPLACEMENT, i] = max(dofs[DISPLACEMENT, i], abs(end))
        dofs[DRIFT, i] = max(dofs[DRIFT, i], abs(drift_end))
        dofs[ACCELERATION, i] = max(dofs[ACCELERATION, i], abs(felt_end))
        top = max(abs(start), abs(end)) + eighth * bend
        top_drift = max(abs(drift), abs(drift_end)) + eighth * (bend + bend_below)
        top_felt = max(abs(felt_start), abs(felt_end)) + eighth * shake * root
        if top > dofs[DISPLACEMENT, i] or top_drift > dofs[DRIFT, i] or top_felt > dofs[ACCELERATION, i]:
            if not has_exact_bound:  # leaves the third and fourth derivatives of u at the start in rows ACCEL_NUDGED
                shake, has_exact_bound = sqrt(shake_bound(row, b, rise, dofs, ends[0], ends[2], ACCEL_NUDGED)), True
            late_bend = abs(turn) + step * (abs(dofs[ACCEL_NUDGED, i]) + 0.5 * step * shake * root)
            late_bend_drift = abs(turn - turn_below) + step * shake * row.floors[GIVE, i]
            top = size_bound(start, end, step, min(bend, late_bend))
            top_drift = size_bound(drift, drift_end, step, min(bend + bend_below, late_bend_drift))
            late_bend_felt = abs(dofs[ACCEL_NUDGED + 1, i]) + step * sqrt(row.floors[QUICK, first]) * shake * root
            top_felt = size_bound(felt_start, felt_end, step, min(shake * root, late_bend_felt))
        dofs[BOUNDS, i] = max(dofs[BOUNDS, i], top)
        dofs[BOUNDS + 1, i] = max(dofs[BOUNDS + 1, i], top_drift)
        dofs[BOUNDS + 2, i] = max(dofs[BOUNDS + 2, i], top_felt)
        searches_displacement = top > dofs[DISPLACEMENT, i]
        searches_drift, searches_acceleration = top_drift > dofs[DRIFT, i], top_felt > dofs[ACCELERATION, i]
        is_not_finite = not abs(end) + abs(felt_end) < inf
        start_below, end_below, bend_below, turn_below = start, end, bend, turn
        if (searches_displacement or searches_drift or searches_acceleration or is_not_finite) and not has_series:
            write_series(row, run, b, ends[0], ground, terms)
            has_series = True
        if searches_displacement or is_not_finite:
            raise_signal(row, run, DISPLACEMENT, i, (pull, rise), step, terms)
        if searches_drift or is_not_finite:
            raise_signal(row, run, DRIFT, i, (pull, rise), step, terms)
        if searches_acceleration or is_not_finite:
            raise_signal(row, run, ACCELERATION, i, (pull, rise), step, terms)
