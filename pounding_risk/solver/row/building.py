"""One building of a row: a chain of masses on storeys, its accelerations, its Taylor series, and bounds on it.

    m ü_i = −(C u̇)_i − V_i + V_{i+1} − m a_g,   V_i = k_i (u_i − u_{i−1}) + c_i

with the constants c_i of storeys that have yielded. While no storey changes its branch the motion under a linear a_g is
its own Taylor series; y = u̇ + K⁻¹ M 1 · (slope of a_g) is then a free vibration, and so are its derivatives. The
energy of a free vibration only falls, which bounds every derivative of the motion from what it is at the start:

    |ü_i| ≤ sqrt(2 E / m_i),   2 E = Σ m ü² + Σ k (y_i − y_{i−1})².
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.pair.taylor import (
    SIGNAL,
    highest,
    slope_at,
    value_at,
)
from pounding_risk.solver.row.storey import shear_stiffness, storey_energy
from pounding_risk.solver.row.workspace import (
    A_NUDGED,
    BAND,
    BENDS,
    CONSTANT,
    DRIFT,
    FIRST,
    FORCE,
    INVERSE,
    MAP,
    MASS,
    PLACE,
    PLASTIC,
    QUICK,
    SHAKE,
    SOFT,
    SPRING,
    STATIC,
    TANGENT,
)


@kernel
def accelerate(row, b, state, pull, desk, out):
    """ü of building ``b`` without contact from rows ``state``, ``state`` + 1 into row ``out``; ``pull`` is a_g.

    Returns the power that ground and dampers put in.
    """
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    below = 0.0
    for i in range(first, last):
        force = desk[TANGENT, i] * (desk[state, i] - below) + desk[CONSTANT, i]
        below = desk[state, i]
        desk[out, i] = -force
        if i > first:
            desk[out, i - 1] += force
    held = 0.0
    for i in range(first, last):
        held += desk[out, i] * desk[state + 1, i]
        desk[out, i] -= row.floors[MASS, i] * pull
    drag(row, b, state + 1, desk, out)
    power = -held
    for i in range(first, last):
        power += desk[out, i] * desk[state + 1, i]
        desk[out, i] *= row.floors[INVERSE, i]
    return power


@kernel
def drag(row, b, speed, desk, out):
    """Take the dampers' forces C · row ``speed`` from row ``out``; C is symmetric, and columns add up side by side."""
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    band = row.frame[BAND, b]
    for j in range(first, last):
        rate = desk[speed, j]
        for i in range(max(first, j - band), min(last, j + band + 1)):
            desk[out, i] -= row.damping[j, i - first] * rate


@kernel
def energy_of(row, b, state, desk):
    """Kinetic energy and potential of the storeys' forces of one building [J]."""
    total, below = 0.0, 0.0
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        drift = desk[state, i] - below
        below = desk[state, i]
        total += 0.5 * row.floors[MASS, i] * desk[state + 1, i] ** 2 + storey_energy(row, desk, i, drift)
    return total


@kernel
def lay_series(row, run, b, state, pull, rise, terms):
    """Taylor coefficients of every u of building ``b`` into ``run.series``; a_g = pull + rise x."""
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    band = row.frame[BAND, b]
    series, desk = run.series, run.desk
    for i in range(first, last):
        series[i, 0] = run.desk[state, i]
        series[i, 1] = run.desk[state + 1, i]
    for n in range(terms - 2):
        share = 1.0 / ((n + 1) * (n + 2))
        below = 0.0
        for i in range(first, last):
            force = desk[TANGENT, i] * (series[i, n] - below)
            if n == 0:
                force += desk[CONSTANT, i]
            below = series[i, n]
            series[i, n + 2] = -force
            if i > first:
                series[i - 1, n + 2] += force
        ground = pull if n == 0 else (rise if n == 1 else 0.0)
        for i in range(first, last):
            drag = 0.0
            for j in range(max(first, i - band), min(last, i + band + 1)):
                drag += row.damping[i, j - first] * series[j, n + 1]
            push = (series[i, n + 2] - (n + 1) * drag) * row.floors[INVERSE, i] - ground
            series[i, n + 2] = push * share


@kernel
def place_on(row, run, b, x, terms, state):
    """Rows ``state``, ``state`` + 1 of building ``b`` at x on its series."""
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        run.desk[state, i] = value_at(run.series, i, terms, x)
        run.desk[state + 1, i] = slope_at(run.series, i, terms, x)


@kernel
def step_over(row, b, pull, rise, desk, state, out):
    """Building ``b`` over one node interval, exactly, from rows ``state`` to rows ``out``."""
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    count = last - first
    place = row.frame[MAP, b]
    if row.frame[BENDS, b]:
        settle_about(row, b, desk, state, -1.0)
    for i in range(count):
        desk[out, first + i] = desk[out + 1, first + i] = 0.0
    # Column by column: what adds up side by side is done several at a time.
    for j in range(2 * count + 2):
        ground = pull if j == 2 * count else rise
        given = desk[state + j // count, first + j % count] if j < 2 * count else ground
        for part in range(2):
            for i in range(count):
                desk[out + part, first + i] += row.maps[place + i] * given
            place += count
    if row.frame[BENDS, b]:
        settle_about(row, b, desk, state, 1.0)
        settle_about(row, b, desk, out, 1.0)


@kernel
def settle_about(row, b, desk, state, sign):
    """Add ``sign`` times the displacements at which a building rests, with the plastic drifts that it has."""
    rest = 0.0
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        rest += row.floors[SOFT, i] * desk[PLASTIC, i] / row.floors[SPRING, i]
        desk[state, i] += sign * rest


@kernel
def motion_bound(row, b, rise, desk, state, here):
    """2 E of building ``b``, |ü_i| ≤ sqrt(2 E / m_i), while a_g rises by ``rise``; ü in row ``here``."""
    motion, below = 0.0, 0.0
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        y = desk[state + 1, i] + row.floors[STATIC, i] * rise
        motion += row.floors[MASS, i] * desk[here, i] ** 2 + desk[TANGENT, i] * (y - below) ** 2
        below = y
    return motion


@kernel
def shake_bound(row, b, rise, desk, state, here, spare):
    """The same of the second derivative of ü, for peaks of acceleration; ``spare`` are two free rows."""
    # Third and fourth derivatives of u, by the same equation once and twice differentiated.
    derive(row, b, desk, state + 1, here, rise, spare)
    derive(row, b, desk, here, spare, 0.0, spare + 1)
    shake, below = 0.0, 0.0
    for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
        shake += row.floors[MASS, i] * desk[spare + 1, i] ** 2 + desk[TANGENT, i] * (desk[spare, i] - below) ** 2
        below = desk[spare, i]
    return shake


@kernel
def derive(row, b, desk, place, speed, ground, out):
    """−M⁻¹ (C · row ``speed`` + K · row ``place``) − ``ground`` into row ``out``."""
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    below = 0.0
    for i in range(first, last):
        force = desk[TANGENT, i] * (desk[place, i] - below)
        below = desk[place, i]
        desk[out, i] = -force
        if i > first:
            desk[out, i - 1] += force
    drag(row, b, speed, desk, out)
    for i in range(first, last):
        desk[out, i] = desk[out, i] * row.floors[INVERSE, i] - ground


@kernel
def lay_signal(row, run, signal, i, bottom, pull, rise, terms):
    """The Taylor series of a watched signal of dof ``i`` onto the board; returns its number of terms.

    ``bottom`` is true for the lowest dof of a building. The storey shear is that of `SHEAR` and of the yielding part.
    """
    board, series = run.board, run.series
    if signal == SHAKE:
        for n in range(terms - 2):
            board[SIGNAL, n] = (n + 1) * (n + 2) * series[i, n + 2]
        board[SIGNAL, 0] += pull
        board[SIGNAL, 1] += rise
        return terms - 2
    for n in range(terms):
        board[SIGNAL, n] = series[i, n] - (series[i - 1, n] if signal != PLACE and not bottom else 0.0)
    if signal == FORCE:
        stiffness = shear_stiffness(row, run.desk, i)
        for n in range(terms):
            board[SIGNAL, n] *= stiffness
        board[SIGNAL, 0] += run.desk[CONSTANT, i]
    return terms


@kernel
def raise_peaks(row, run, b, pull, rise, stop, terms):
    """Raise the peaks of building ``b`` by those of its series on [0, stop]; a_g = pull + rise x.

    A signal is searched only where the sum of its terms' sizes passes its peak.
    """
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    desk, series = run.desk, run.series
    for i in range(first, last):
        place = drift = shake = 0.0
        power = 1.0
        for n in range(terms):
            below = series[i - 1, n] if i > first else 0.0
            place += power * abs(series[i, n])
            drift += power * abs(series[i, n] - below)
            if n + 2 < terms:
                shake += power * abs((n + 1) * (n + 2) * series[i, n + 2])
            power *= stop
        shake += abs(pull) + abs(rise) * stop
        # Put so that what is not finite is searched.
        if not place <= desk[PLACE, i]:
            raise_signal(row, run, PLACE, i, first, pull, rise, stop, terms)
        if not drift <= desk[DRIFT, i]:
            raise_signal(row, run, DRIFT, i, first, pull, rise, stop, terms)
        if not shake <= desk[SHAKE, i]:
            raise_signal(row, run, SHAKE, i, first, pull, rise, stop, terms)
        if row.frame[BENDS, b] and not shear_stiffness(row, desk, i) * drift + abs(desk[CONSTANT, i]) <= desk[FORCE, i]:
            raise_signal(row, run, FORCE, i, first, pull, rise, stop, terms)


@kernel
def raise_signal(row, run, signal, i, first, pull, rise, stop, terms):
    """Raise the peak of one signal by that of its series on [0, stop]."""
    count = lay_signal(row, run, signal, i, i == first, pull, rise, terms)
    best = highest(run.board, SIGNAL, count, 1.0, stop, run.desk[signal, i])
    run.desk[signal, i] = highest(run.board, SIGNAL, count, -1.0, stop, best)


@kernel
def raise_between(row, run, b, ends, motion, pull, rise, step, terms):
    """Peaks of a building over one node interval of free flight; the search only where a bound does not settle it.

    ``ends`` = (rows of states at the start, at the end, of ü at the start, at the end), ``motion`` as `motion_bound`.
    The bound on the shaking is first (ω + c)² times that on the motion, ω the fastest mode and c the strongest damper.
    """
    first, last = row.frame[FIRST, b], row.frame[FIRST, b + 1]
    if last == first:
        return  # a rigid building has no dof, and as the last one no place in the arrays either
    desk = run.desk
    eighth = 0.125 * step * step
    swing, laid, exact = sqrt(motion), False, False
    shake = row.floors[QUICK, first] * swing
    below = below_end = below_bend = 0.0
    for i in range(first, last):
        root = sqrt(row.floors[INVERSE, i])
        bend = swing * root
        here, there = desk[ends[0], i], desk[ends[1], i]
        drift, drift_end = here - below, there - below_end
        felt, felt_end = desk[ends[2], i] + pull, desk[ends[3], i] + (pull + rise * step)
        desk[PLACE, i] = max(desk[PLACE, i], abs(there))
        desk[DRIFT, i] = max(desk[DRIFT, i], abs(drift_end))
        desk[SHAKE, i] = max(desk[SHAKE, i], abs(felt_end))
        wanted = max(abs(here), abs(there)) + eighth * bend > desk[PLACE, i]
        drifts = max(abs(drift), abs(drift_end)) + eighth * (bend + below_bend) > desk[DRIFT, i]
        shakes = max(abs(felt), abs(felt_end)) + eighth * shake * root > desk[SHAKE, i]
        if shakes and not exact:
            shake, exact = sqrt(shake_bound(row, b, rise, desk, ends[0], ends[2], A_NUDGED)), True
            shakes = max(abs(felt), abs(felt_end)) + eighth * shake * root > desk[SHAKE, i]
        odd = not abs(there) + abs(felt_end) < inf
        below, below_end, below_bend = here, there, bend
        if (wanted or drifts or shakes or odd) and not laid:
            lay_series(row, run, b, ends[0], pull, rise, terms)
            laid = True
        if wanted or odd:
            raise_signal(row, run, PLACE, i, first, pull, rise, step, terms)
        if drifts or odd:
            raise_signal(row, run, DRIFT, i, first, pull, rise, step, terms)
        if shakes or odd:
            raise_signal(row, run, SHAKE, i, first, pull, rise, step, terms)
