"""The joined motion of two buildings that press on each other.

Joined, the pair is one linear oscillator: shares p1 = m1/(m1+m2) and p2 of the masses weigh spring, damper and ground,

    ẍ = −(p1 q1 + p2 q2) − (p1 f1 + p2 f2) ẋ − (p1 s1 + p2 s2) x,   u_left = x + a,   u_right = x − b,

a + b the gap. Over a node interval with linear a_g, x is its own Taylor series, as in flight, and so is the force
between the buildings, F = m (A_left − A_right) with A the acceleration that each would have alone: peaks, impulse and
the moment at which F would turn to tension come from the series, without a time-step error. A rigid building has
p = 1 and holds the other where it is.
"""

from __future__ import annotations

from math import isnan
from typing import NamedTuple

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.solver.counters import AT_END, DEMAND, FINISHED, STEPS
from pounding_risk.solver.pair.contact import write_step
from pounding_risk.solver.pair.taylor import expand, first_rise, highest, slope_at, value_at
from pounding_risk.solver.workspace import BEGIN, LEFT, RIGHT, SIGNAL

ROUNDING = 1e-14  # of the displacements: no bounce so low can be distinguished from rest


class Joint(NamedTuple):
    """Two buildings in joined motion: one oscillator, and where each stands in it."""

    left: Oscillator
    right: Oscillator
    oscillator: Oscillator  # of both, but the ground; its mass is the reduced mass m1 m2 / (m1 + m2), which F needs
    share_left: float  # p1
    share_right: float
    left_offset: float  # a = u_left − x [m]
    right_offset: float  # b = x − u_right [m]


@kernel
def make_joint(pair, gap):
    """The oscillator that both buildings make when they are held together across the gap."""
    left, right = pair
    total = left.inverse_mass + right.inverse_mass
    p, q = right.inverse_mass / total, left.inverse_mass / total
    spring = p * left.omega2 + q * right.omega2
    oscillator = Oscillator(1.0 / total, 0.0, spring, p * left.two_zeta_omega + q * right.two_zeta_omega, 0.0, 0.0)
    left_offset = gap if right.inverse_mass == 0.0 else 0.0
    right_offset = gap if left.inverse_mass == 0.0 else 0.0
    # Masses without springs, as in an isolated impact, are not held anywhere.
    if spring > 0.0 and left.inverse_mass > 0.0 and right.inverse_mass > 0.0:
        left_offset = q * right.omega2 * gap / spring
        right_offset = p * left.omega2 * gap / spring
    return Joint(left, right, oscillator, p, q, left_offset, right_offset)


@small
def joined_motion(joint, state):
    """(x, ẋ) of the joined motion that takes over from a state: place and momentum of the centre of mass."""
    p, q = joint.share_left, joint.share_right
    x = p * (state[0] - joint.left_offset) + q * (state[1] + joint.right_offset)
    return x, p * state[2] + q * state[3]


@small
def state_of_both(joint, x, rate):
    """(u_left, u_right, v_left, v_right) of joined motion at ``x`` [m] and ``rate`` [m/s] of its oscillator."""
    return x + joint.left_offset, x - joint.right_offset, rate, rate


@small
def load_whole(joint, ground):
    """What pushes the joined pair, from the ground under the left building."""
    p, q = joint.share_left, joint.share_right
    left_load, right_load = ground.load_left(joint.left), ground.load_across(joint.right)
    return (
        p * left_load[0] + q * right_load[0],
        p * left_load[1] + q * right_load[1],
        p * left_load[2] + q * right_load[2],
        p * left_load[3] + q * right_load[3],
    )


@kernel
def write_tension(joint, ground, terms, workspace):
    """Row SIGNAL: the series of −F / m, tension above zero, from that of x in row LEFT; returns its terms."""
    left, right = joint.left, joint.right
    two_zeta_omega, omega2 = left.two_zeta_omega - right.two_zeta_omega, left.omega2 - right.omega2
    series = workspace.search.series
    for n in range(terms - 1):
        series[SIGNAL, n] = two_zeta_omega * ((n + 1) * series[LEFT, n + 1]) + omega2 * series[LEFT, n]
    left_load, right_load = ground.load_left(left), ground.load_across(right)
    series[SIGNAL, 0] += (left_load[0] - right_load[0]) + (
        left.omega2 * joint.left_offset + right.omega2 * joint.right_offset
    )
    for n in range(1, 4):
        series[SIGNAL, n] += left_load[n] - right_load[n]
    return terms - 1


@small
def presses(series, count):
    """True where the force between the buildings, −SIGNAL, is compression just after the start of its series."""
    for n in range(count):
        if series[SIGNAL, n] != 0.0:
            return series[SIGNAL, n] < 0.0
    return False


@kernel
def raise_peaks(joint, ground, terms, stop, workspace):
    """Peaks of displacement and of absolute acceleration over a joined segment, x in row LEFT."""
    left, right, oscillator = joint.left, joint.right, joint.oscillator
    series = workspace.search.series
    x = series[LEFT, 0]
    for n in range(terms):
        series[RIGHT, n] = series[LEFT, n]
    for n in range(terms - 1):
        series[SIGNAL, n] = (
            -oscillator.two_zeta_omega * ((n + 1) * series[LEFT, n + 1]) - oscillator.omega2 * series[LEFT, n]
        )
    # ẍ + a_g: without a wave nothing of a_g is left but where a rigid building carries the other along.
    push, widening, ground_left = load_whole(joint, ground), ground.widening(), ground.under_left()
    for n in range(4):
        series[SIGNAL, n] -= push[n]
        series[RIGHT, n] -= widening[n]
    series[SIGNAL, 0] += ground_left[0]
    series[SIGNAL, 1] += ground_left[1]
    series[LEFT, 0] += joint.left_offset
    series[RIGHT, 0] -= joint.right_offset
    if left.inverse_mass > 0.0:
        raise_signal(1, LEFT, terms, stop, workspace)
        raise_signal(3, SIGNAL, terms - 1, stop, workspace)
    if right.inverse_mass > 0.0:
        raise_signal(2, RIGHT, terms, stop, workspace)
        raise_signal(4, SIGNAL, terms - 1, stop, workspace)
    series[LEFT, 0] = x


@kernel
def raise_signal(signal, row, terms, stop, workspace):
    """Raise a signal's peaks by those of a row's series on [0, stop]."""
    workspace.high[signal] = highest(workspace.search, row, terms, 1.0, stop, workspace.high[signal])
    workspace.low[signal] = -highest(workspace.search, row, terms, -1.0, stop, -workspace.low[signal])


@small
def state_set_apart(joint, state, spread):
    """The state of a parting: further apart by a rounding, so that flight does not begin with a touch of rounding.

    ``spread`` is the relative displacement of the grounds [m], a cubic that flight takes from another origin.
    """
    clear = 4e-16 * (abs(state[0]) + abs(state[1]) + (joint.left_offset + joint.right_offset)) + ROUNDING * abs(spread)
    u_left = state[0] - clear if joint.left.inverse_mass > 0.0 else 0.0
    u_right = state[1] + clear if joint.right.inverse_mass > 0.0 else 0.0
    return u_left, u_right, state[2], state[3]


@small
def write_state(workspace, state):
    """Write (u_left, u_right, v_left, v_right) to row BEGIN of the states, from which the log is written."""
    for part in range(4):
        workspace.states[BEGIN, part] = state[part]


@kernel
def time_levels(mass, largest, count, span, workspace, log):
    """Time the levels that F reaches first on a joined segment, ``span`` = (its start, its length); −F/m in SIGNAL."""
    series = workspace.search.series
    while log.used[2] < log.levels.size and log.levels[log.used[2]] <= mass * largest:
        level = log.levels[log.used[2]] / mass
        time = 0.0
        if -series[SIGNAL, 0] < level:
            for n in range(count):
                series[SIGNAL, n] = -series[SIGNAL, n]
            root = first_rise(workspace.search, count, level, span[1])
            for n in range(count):
                series[SIGNAL, n] = -series[SIGNAL, n]
            # A local maximum that reaches it by rounding has no root.
            time = root if root >= 0.0 else span[1]
        log.first[log.used[2]] = span[0] + time
        log.used[2] += 1


@kernel
def move_joined(joint, free, start, x, rate, workspace, log):
    """Joined motion from ``start`` until F falls to zero or the record ends; x, ẋ at its start are given.

    Returns (how it ended, node, time after it, state seen from the own grounds, largest force).
    """
    node, offset = start
    mass, terms, series = joint.oscillator.mass, free.terms, workspace.search.series
    largest = 0.0
    while True:
        ground = free.passage.interval(free.ground, free.step, node, offset)
        span = free.passage.width(free.step, node) - offset
        expand(joint.oscillator, x, rate, load_whole(joint, ground), workspace.search, LEFT, terms)
        count = write_tension(joint, ground, terms, workspace)
        root = first_rise(workspace.search, count, 0.0, span)
        stop = root if root >= 0.0 else span
        largest = highest(workspace.search, SIGNAL, count, -1.0, stop, largest)
        if not isnan(workspace.counters[DEMAND]):
            time_levels(mass, largest, count, (free.passage.moment(free.step, node) + offset, stop), workspace, log)
        push, power = 0.0, stop
        for n in range(count):
            push -= series[SIGNAL, n] * power / (n + 1)
            power *= stop
        workspace.states[BEGIN, 5] += mass * push
        force = max(-mass * value_at(series, SIGNAL, count, stop), 0.0) if root < 0.0 else 0.0
        raise_peaks(joint, ground, terms, stop, workspace)
        x, rate = value_at(series, LEFT, terms, stop), slope_at(series, LEFT, terms, stop)
        workspace.counters[STEPS] += 1.0
        offset += stop
        state = state_of_both(joint, x, rate)
        write_state(workspace, state)
        state = ground.from_own_ground(joint.right, state, stop)
        write_step(log, free.passage.moment(free.step, node) + offset, force, state, workspace)
        if root >= 0.0:
            return FINISHED, node, offset, state, mass * largest
        node, offset = node + 1, 0.0
        if node >= free.ground.size - 1:
            return AT_END, node, offset, state, mass * largest
