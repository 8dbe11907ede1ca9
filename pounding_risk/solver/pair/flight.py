"""Free flight: two linear buildings between contacts, exactly, and the search for what happens on the way.

A building's motion is its response without contact, which every run of an ensemble shares and which is
computed once (`Free`), plus a free vibration h(t) left by the contacts so far. Within one node interval a_g is
linear and the motion is its own Taylor series, summed to rounding; touches and peaks are found on that series
by bisection under a bound on its second derivative, so that none is missed, whatever lies between two nodes.
A block of nodes is passed over when the largest free value in it plus a bound on h,

    |h(t)| ≤ R = sqrt(h² + (ḣ/ω)²),   |a_h(t)| ≤ (1 + 2 ζ) ω² R      (the energy of a free vibration only falls),

can neither close the gap nor set a new peak: the cost of a run follows its contacts, not its samples.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.ground import DelayedGround, UniformGround
from pounding_risk.solver.pair.taylor import expand, first_rise, highest, local_maximum_bound, value_and_slope
from pounding_risk.solver.workspace import LEFT, RIGHT, SIGNAL, SIGNALS

BLOCK = 16  # nodes passed over at a time
TOUCH = 1 << SIGNALS  # the bit of a touch in a mask whose lower bits are those of the signals
EVERY_SIGNAL = TOUCH - 1


class Free(NamedTuple):
    """The response without contact of one pair to one ground motion; shapes with N nodes and B blocks."""

    ground: np.ndarray  # (N,) a_g, with a passing wave that under the left building [m/s²]
    step: float  # between samples, of which the passage makes nodes [s]
    terms: int  # of the Taylor series over one step
    states: np.ndarray  # (N, 4) u_left, u_right, v_left, v_right
    high: np.ndarray  # (B, SIGNALS) no value in the block is larger, between nodes too; see `fill_free_response`
    low: np.ndarray  # (B, SIGNALS) nor smaller
    node_map: tuple  # free vibration over one node: 2 x 4 numbers
    block_map: tuple  # and over one block
    fastest: float  # peak closing or parting speed at nodes [m/s]
    passage: UniformGround | DelayedGround  # how the motion comes to the right building


@small
def read_signals(pair, state, widened, signals):
    """Write the five signals of a state in flight to ``signals``; absolute acceleration is −2 ζ ω u̇ − ω² u.

    ``widened`` is what the ground itself has widened the gap by.
    """
    left, right = pair
    signals[0] = state[0] - state[1] - widened
    signals[1] = state[0]
    signals[2] = state[1]
    signals[3] = -left.two_zeta_omega * state[2] - left.omega2 * state[0]
    signals[4] = -right.two_zeta_omega * state[3] - right.omega2 * state[1]


@kernel
def write_signal(signal, pair, ground, workspace, terms):
    """Row with the Taylor coefficients of a watched signal, from those of the two buildings; and their number."""
    left, right = pair
    series = workspace.search.series
    if signal == 0:
        for n in range(terms):
            series[SIGNAL, n] = series[LEFT, n] - series[RIGHT, n]
        w0, w1, w2, w3 = ground.widening()
        series[SIGNAL, 0] -= w0
        series[SIGNAL, 1] -= w1
        series[SIGNAL, 2] -= w2
        series[SIGNAL, 3] -= w3
        return SIGNAL, terms
    if signal == 1:
        return LEFT, terms
    if signal == 2:
        return RIGHT, terms
    two_zeta_omega = left.two_zeta_omega if signal == 3 else right.two_zeta_omega
    omega2 = left.omega2 if signal == 3 else right.omega2
    source = LEFT if signal == 3 else RIGHT
    for n in range(terms - 1):
        series[SIGNAL, n] = -two_zeta_omega * (n + 1) * series[source, n + 1] - omega2 * series[source, n]
    return SIGNAL, terms - 1


@small
def turn_bound(oscillator, displacement, speed, load):
    """No |ü| within the interval is larger: u̇ + slope/ω² is a free vibration, whose energy only falls.

    The sum of both terms stands for the root of their squares, which it is never below and which takes longer.
    """
    drift = (oscillator.omega2 * speed + load[1]) * oscillator.inverse_omega
    pull = load[0] + oscillator.two_zeta_omega * speed + oscillator.omega2 * displacement
    return abs(drift) + abs(pull)


@small
def shake_bound(oscillator, turn):
    """Bound on the second derivative of the absolute acceleration: ω² (1 + 2ζ + 4ζ²) × the bound on |ü|."""
    ratio = oscillator.two_zeta_omega * oscillator.inverse_omega
    return oscillator.omega2 * (1.0 + ratio + ratio * ratio) * turn


@small
def bend_bounds(pair, state, ground, length):
    """Bounds on the second derivatives of the watched signals within a segment of flight."""
    left, right = pair
    turn_left = turn_bound(left, state[0], state[2], ground.load_left(left))
    turn_right = turn_bound(right, state[1], state[3], ground.load_right(right))
    return (
        turn_left + turn_right + ground.bend(length),
        turn_left,
        turn_right,
        shake_bound(left, turn_left),
        shake_bound(right, turn_right),
    )


@kernel
def state_at(pair, workspace, terms, x):
    """(u_left, u_right, v_left, v_right) at x from the series of both buildings."""
    left, right = pair
    series = workspace.search.series
    u_left = u_right = v_left = v_right = 0.0
    if left.inverse_omega > 0.0:
        u_left, v_left = value_and_slope(series, LEFT, terms, x)
    if right.inverse_omega > 0.0:
        u_right, v_right = value_and_slope(series, RIGHT, terms, x)
    return u_left, u_right, v_left, v_right


@kernel
def search_interval(pair, gap, mask, span, terms, workspace):
    """The first touch within a segment of flight, and the peaks up to there; ``mask`` as `search_mask` has it.

    The series of both buildings stand in the workspace; ``span`` = (ground, length) of the segment. Returns the time of
    the touch after its start, or −1; the largest and smallest signals so far are updated.
    """
    ground, stop = span
    touch = -1.0
    if mask & 1:
        write_signal(0, pair, ground, workspace, terms)
        touch = first_rise(workspace.search, terms, gap, stop)
        stop = touch if touch >= 0.0 else stop
    if stop > 0.0:
        for signal in range(SIGNALS):
            sides = mask >> (1 + 2 * signal) & 3
            if sides:
                row, count = write_signal(signal, pair, ground, workspace, terms)
                if sides & 1:
                    workspace.high[signal] = highest(workspace.search, row, count, 1.0, stop, workspace.high[signal])
                if sides & 2:
                    workspace.low[signal] = -highest(workspace.search, row, count, -1.0, stop, -workspace.low[signal])
    return touch


@small
def search_mask(pair, gap, state, span, watched, workspace):
    """What a segment of flight has to be searched for, from the signals at its ends; 0 for nothing.

    The last bit stands for a touch, then two for each signal: a new highest, a new lowest. Where there can be no
    touch the values at the end count at once, and only a local maximum between the ends is left to be searched for.
    Signals without their bit in ``watched`` can set no peak here.
    """
    ground, length = span
    bends = bend_bounds(pair, state, ground, length)
    eighth = 0.125 * length * length
    mask = 0
    if max(workspace.start_signals[0], workspace.end_signals[0]) + eighth * bends[0] > gap:
        mask = (
            1
            if local_maximum_bound(workspace.start_signals[0], workspace.end_signals[0], length, bends[0]) > gap
            else 0
        )
    for signal in range(SIGNALS):
        if watched >> signal & 1 == 0:
            continue
        bend, start, end = bends[signal], workspace.start_signals[signal], workspace.end_signals[signal]
        if mask & 1 == 0:
            workspace.high[signal] = max(workspace.high[signal], end)
            workspace.low[signal] = min(workspace.low[signal], end)
        # The coarser bound first, max + |f''| h²/8: it settles most intervals without a division.
        top, bottom = max(start, end) + eighth * bend, min(start, end) - eighth * bend
        if top > workspace.high[signal] and local_maximum_bound(start, end, length, bend) > workspace.high[signal]:
            mask |= 2 << 2 * signal
        if bottom < workspace.low[signal] and -local_maximum_bound(-start, -end, length, bend) < workspace.low[signal]:
            mask |= 4 << 2 * signal
        # Motion that is not finite is searched: what the search makes of it ends the run with its status.
        mask |= 0 if abs(top) < inf else 2 << 2 * signal
    return mask


@kernel
def write_series(pair, state, ground, terms, workspace):
    """Write the Taylor series of both buildings over a segment of flight to the workspace."""
    expand(pair[0], state[0], state[2], ground.load_left(pair[0]), workspace.search, LEFT, terms)
    expand(pair[1], state[1], state[3], ground.load_right(pair[1]), workspace.search, RIGHT, terms)


@small
def reaches(pair, vibration):
    """How far the watched signals of a free vibration reach from zero, now and for ever after."""
    left, right = pair
    reach_left = sqrt(vibration[0] ** 2 + (vibration[2] * left.inverse_omega) ** 2)
    reach_right = sqrt(vibration[1] ** 2 + (vibration[3] * right.inverse_omega) ** 2)
    return (
        reach_left + reach_right,
        reach_left,
        reach_right,
        reach_left * (left.omega2 + left.two_zeta_omega * sqrt(left.omega2)),
        reach_right * (right.omega2 + right.two_zeta_omega * sqrt(right.omega2)),
    )


@small
def block_mask(extremes, gap, block, reach, workspace):
    """What may happen in a block of a motion that is within ``reach`` of the free one; 0 for nothing.

    A bit for each signal that may set a new peak, and `TOUCH`.
    """
    high, low = extremes
    mask = TOUCH if high[block, 0] + reach[0] > gap else 0
    for signal in range(SIGNALS):
        above, below = high[block, signal] + reach[signal], low[block, signal] - reach[signal]
        if above > workspace.high[signal] or below < workspace.low[signal]:
            mask |= 1 << signal
    return mask


@small
def advance_vibration(maps, vibration):
    """The free vibration (u_left, u_right, v_left, v_right) advanced by the maps of both buildings."""
    a, b = maps
    u, w, v, z = vibration
    return a[0] * u + a[1] * v, b[0] * w + b[1] * z, a[2] * u + a[3] * v, b[2] * w + b[3] * z


@small
def with_free(states, node, vibration):
    """The motion at a node: free response plus free vibration (u_left, u_right, v_left, v_right)."""
    return (
        states[node, 0] + vibration[0],
        states[node, 1] + vibration[1],
        states[node, 2] + vibration[2],
        states[node, 3] + vibration[3],
    )


@kernel
def fly(pair, free, gap, start, state, workspace):
    """Fly from ``start`` = (node, time after it) with ``state`` to the next touch or the end of the record.

    Returns (node, time after it, state) of the touch; node is −1 at the end of the record. A start at (0, 0) is
    the free response itself.
    """
    node, offset = start
    passage, states, terms, extremes = free.passage, free.states, free.terms, (free.high, free.low)
    last = free.ground.size - 1
    vibration = (0.0, 0.0, 0.0, 0.0)
    if node > 0 or offset > 0.0:
        ground = passage.interval(free.ground, free.step, node, offset)
        span = (ground, passage.width(free.step, node) - offset)
        write_series(pair, state, ground, terms, workspace)
        next_state = state_at(pair, workspace, terms, span[1])
        read_signals(pair, state, ground.widening()[0], workspace.start_signals)
        read_signals(pair, next_state, passage.widened(node + 1), workspace.end_signals)
        mask = search_mask(pair, gap, state, span, EVERY_SIGNAL, workspace)
        touch = search_interval(pair, gap, mask, span, terms, workspace)
        if touch >= 0.0:
            return node, offset + touch, state_at(pair, workspace, terms, touch)
        state = next_state
        node += 1
        vibration = (
            state[0] - states[node, 0],
            state[1] - states[node, 1],
            state[2] - states[node, 2],
            state[3] - states[node, 3],
        )
    while node < last:
        block, reach = node // BLOCK, reaches(pair, vibration)
        watched = block_mask(extremes, gap, block, reach, workspace)
        purely_free = reach[0] == 0.0
        if node % BLOCK == 0 and (watched == 0 or (purely_free and watched < TOUCH)):
            if purely_free:
                for signal in range(SIGNALS):
                    workspace.high[signal] = max(workspace.high[signal], extremes[0][block, signal])
                    workspace.low[signal] = min(workspace.low[signal], extremes[1][block, signal])
            vibration = advance_vibration(free.block_map, vibration)
            node += BLOCK
            continue
        stop = min(last, node - node % BLOCK + BLOCK)
        state = with_free(states, node, vibration)
        read_signals(pair, state, passage.widened(node), workspace.end_signals)
        while node < stop:
            span = (passage.interval(free.ground, free.step, node, 0.0), passage.width(free.step, node))
            vibration = advance_vibration(passage.node_maps(free.node_map, node), vibration)
            next_state = with_free(states, node + 1, vibration)
            for signal in range(SIGNALS):
                workspace.start_signals[signal] = workspace.end_signals[signal]
            read_signals(pair, next_state, passage.widened(node + 1), workspace.end_signals)
            mask = search_mask(pair, gap, state, span, watched, workspace)
            if mask:
                write_series(pair, state, span[0], terms, workspace)
                touch = search_interval(pair, gap, mask, span, terms, workspace)
                if touch >= 0.0:
                    return node, touch, state_at(pair, workspace, terms, touch)
            state = next_state
            node += 1
    return -1, 0.0, state
