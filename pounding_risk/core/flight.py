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

from pounding_risk._jit import kernel, small
from pounding_risk.core.series import (
    HERE,
    HERE_SLOPE,
    HIGH,
    LEFT,
    LOW,
    NEXT,
    NEXT_SLOPE,
    RIGHT,
    SIGNAL,
    STAGES,
    crest_bound,
    expand,
    first_rise,
    highest,
    slope_at,
    value_at,
)

BLOCK = 16  # nodes passed over at a time
TOP, BOTTOM = HERE_SLOPE, NEXT_SLOPE  # rows that only the contact phase uses otherwise
SIGNALS = 5  # relative displacement; displacement left, right; absolute acceleration left, right


class Free(NamedTuple):
    """The response without contact of one pair to one ground motion; shapes with N nodes and B blocks."""

    ground: np.ndarray  # (N,) a_g [m/s²]
    step: float  # between nodes [s]
    terms: int  # of the Taylor series over one step
    states: np.ndarray  # (N, 4) u_left, u_right, v_left, v_right
    high: np.ndarray  # (B, SIGNALS) no value in the block is larger, between nodes too; see `survey`
    low: np.ndarray  # (B, SIGNALS) nor smaller
    node_map: tuple  # free vibration over one node: 2 x 4 numbers
    block_map: tuple  # and over one block
    fastest: float  # peak relative velocity at nodes [m/s]


@small
def read_signals(pair, state, desk, row):
    """The five watched values of a state in flight; absolute acceleration is −2 ζ ω u̇ − ω² u."""
    left, right = pair
    desk[row, 0] = state[0] - state[1]
    desk[row, 1] = state[0]
    desk[row, 2] = state[1]
    desk[row, 3] = -left.fade * state[2] - left.spring * state[0]
    desk[row, 4] = -right.fade * state[3] - right.spring * state[1]


@kernel
def signal_row(signal, pair, desk, terms):
    """Row with the Taylor coefficients of a watched signal, from those of the two buildings; and their number."""
    left, right = pair
    if signal == 0:
        for n in range(terms):
            desk[SIGNAL, n] = desk[LEFT, n] - desk[RIGHT, n]
        return SIGNAL, terms
    if signal == 1:
        return LEFT, terms
    if signal == 2:
        return RIGHT, terms
    fade = left.fade if signal == 3 else right.fade
    spring = left.spring if signal == 3 else right.spring
    source = LEFT if signal == 3 else RIGHT
    for n in range(terms - 1):
        desk[SIGNAL, n] = -fade * (n + 1) * desk[source, n + 1] - spring * desk[source, n]
    return SIGNAL, terms - 1


@small
def turn_bound(oscillator, place, speed, ramp):
    """No |ü| within the interval is larger: u̇ + slope/ω² is a free vibration, whose energy only falls.

    The sum of both terms stands for the root of their squares, which it is never below and which takes longer.
    """
    drift = (oscillator.spring * speed + oscillator.ground * ramp[1]) * oscillator.inverse_omega
    pull = oscillator.ground * ramp[0] + oscillator.fade * speed + oscillator.spring * place
    return abs(drift) + abs(pull)


@small
def shake_bound(oscillator, turn):
    """Bound on the second derivative of the absolute acceleration: ω² (1 + 2ζ + 4ζ²) × the bound on |ü|."""
    ratio = oscillator.fade * oscillator.inverse_omega
    return oscillator.spring * (1.0 + ratio + ratio * ratio) * turn


@kernel
def state_at(pair, desk, terms, x):
    """(u_left, u_right, v_left, v_right) at x from the series of both buildings."""
    left, right = pair
    u_left = u_right = v_left = v_right = 0.0
    if left.inverse_omega > 0.0:
        u_left = value_at(desk, LEFT, terms, x)
        v_left = slope_at(desk, LEFT, terms, x)
    if right.inverse_omega > 0.0:
        u_right = value_at(desk, RIGHT, terms, x)
        v_right = slope_at(desk, RIGHT, terms, x)
    return u_left, u_right, v_left, v_right


@kernel
def search_interval(pair, gap, wanted, stop, terms, desk):
    """The first touch within a stretch of flight, and the peaks up to there; ``wanted`` as `unquiet` has it.

    The series of both buildings stand on the desk; ``stop`` is the length of the stretch. Returns the time of the
    touch after its start, or −1; the peaks are raised in rows HIGH and LOW.
    """
    touch = -1.0
    if wanted & 1:
        signal_row(0, pair, desk, terms)
        touch = first_rise(desk, terms, gap, stop)
        stop = touch if touch >= 0.0 else stop
    if stop > 0.0:
        for signal in range(SIGNALS):
            sides = wanted >> (1 + 2 * signal) & 3
            if sides:
                row, count = signal_row(signal, pair, desk, terms)
                if sides & 1:
                    desk[HIGH, signal] = highest(desk, row, count, 1.0, stop, desk[HIGH, signal])
                if sides & 2:
                    desk[LOW, signal] = -highest(desk, row, count, -1.0, stop, -desk[LOW, signal])
    return touch


@small
def unquiet(pair, gap, state, span, desk):
    """What a stretch of flight has to be searched for, from its ends' signals in HERE and NEXT; 0 for nothing.

    The last bit stands for a touch, then two for each signal: a new highest, a new lowest. Where there can be no
    touch the values at the end count at once, and only a crest between the ends is left to be searched for.
    """
    left, right = pair
    turn_left = turn_bound(left, state[0], state[2], span)
    turn_right = turn_bound(right, state[1], state[3], span)
    bends = (
        turn_left + turn_right,
        turn_left,
        turn_right,
        shake_bound(left, turn_left),
        shake_bound(right, turn_right),
    )
    eighth = 0.125 * span[2] * span[2]
    wanted = 0
    if max(desk[HERE, 0], desk[NEXT, 0]) + eighth * bends[0] > gap:
        wanted = 1 if crest_bound(desk[HERE, 0], desk[NEXT, 0], span[2], bends[0]) > gap else 0
    for signal in range(SIGNALS):
        bend, here, there = bends[signal], desk[HERE, signal], desk[NEXT, signal]
        if wanted & 1 == 0:
            desk[HIGH, signal] = max(desk[HIGH, signal], there)
            desk[LOW, signal] = min(desk[LOW, signal], there)
        # The coarser bound first, max + |f''| h²/8: it settles most intervals without a division.
        top, bottom = max(here, there) + eighth * bend, min(here, there) - eighth * bend
        if top > desk[HIGH, signal] and crest_bound(here, there, span[2], bend) > desk[HIGH, signal]:
            wanted |= 2 << 2 * signal
        if bottom < desk[LOW, signal] and -crest_bound(-here, -there, span[2], bend) < desk[LOW, signal]:
            wanted |= 4 << 2 * signal
        # Motion that is not finite is searched: what the search makes of it ends the run with its status.
        wanted |= 0 if abs(top) < inf else 2 << 2 * signal
    return wanted


@kernel
def lay_out(pair, state, span, terms, desk):
    """The Taylor series of both buildings over a stretch, ``span`` = (a_g, its slope, length), onto the desk."""
    expand(pair[0], state[0], state[2], span, desk, LEFT, terms)
    expand(pair[1], state[1], state[3], span, desk, RIGHT, terms)


@small
def block_is_quiet(pair, extremes, gap, block, vibration, desk):
    """True where the block can be passed over; a block of purely free motion leaves its own peaks on the desk."""
    left, right = pair
    high, low = extremes
    reach_left = sqrt(vibration[0] ** 2 + (vibration[2] * left.inverse_omega) ** 2)
    reach_right = sqrt(vibration[1] ** 2 + (vibration[3] * right.inverse_omega) ** 2)
    reach = reach_left + reach_right
    if high[block, 0] + reach > gap:
        return False
    if reach == 0.0:
        for signal in range(SIGNALS):
            desk[HIGH, signal] = max(desk[HIGH, signal], high[block, signal])
            desk[LOW, signal] = min(desk[LOW, signal], low[block, signal])
        return True
    for signal in range(SIGNALS):
        if signal == 1:
            reach = reach_left
        elif signal == 2:
            reach = reach_right
        elif signal == 3:
            reach = reach_left * (left.spring + left.fade * sqrt(left.spring))
        elif signal == 4:
            reach = reach_right * (right.spring + right.fade * sqrt(right.spring))
        if high[block, signal] + reach > desk[HIGH, signal]:
            return False
        if low[block, signal] - reach < desk[LOW, signal]:
            return False
    return True


@small
def turned(maps, vibration):
    """The free vibration (u_left, u_right, v_left, v_right) advanced by the maps of both buildings."""
    a, b = maps
    u, w, v, z = vibration
    return a[0] * u + a[1] * v, b[0] * w + b[1] * z, a[2] * u + a[3] * v, b[2] * w + b[3] * z


@small
def with_free(states, node, vibration):
    """The whole motion at a node."""
    return (
        states[node, 0] + vibration[0],
        states[node, 1] + vibration[1],
        states[node, 2] + vibration[2],
        states[node, 3] + vibration[3],
    )


@kernel
def fly(pair, free, gap, start, state, desk):
    """Fly from ``start`` = (node, time after it) with ``state`` to the next touch or the end of the record.

    Returns (node, time after it, state) of the touch; node is −1 at the end of the record. A start at (0, 0) is
    the free response itself.
    """
    node, offset = start
    ground, states, terms, extremes = free.ground, free.states, free.terms, (free.high, free.low)
    last = ground.size - 1
    vibration = (0.0, 0.0, 0.0, 0.0)
    if node > 0 or offset > 0.0:
        slope = (ground[node + 1] - ground[node]) / free.step
        length = free.step - offset
        span = (ground[node] + slope * offset, slope, length)
        lay_out(pair, state, span, terms, desk)
        ahead = state_at(pair, desk, terms, length)
        read_signals(pair, state, desk, HERE)
        read_signals(pair, ahead, desk, NEXT)
        touch = search_interval(pair, gap, unquiet(pair, gap, state, span, desk), length, terms, desk)
        if touch >= 0.0:
            return node, offset + touch, state_at(pair, desk, terms, touch)
        state = ahead
        node += 1
        vibration = (
            state[0] - states[node, 0],
            state[1] - states[node, 1],
            state[2] - states[node, 2],
            state[3] - states[node, 3],
        )
    while node < last:
        if node % BLOCK == 0 and block_is_quiet(pair, extremes, gap, node // BLOCK, vibration, desk):
            vibration = turned(free.block_map, vibration)
            node += BLOCK
            continue
        stop = min(last, node - node % BLOCK + BLOCK)
        state = with_free(states, node, vibration)
        read_signals(pair, state, desk, NEXT)
        while node < stop:
            span = (ground[node], (ground[node + 1] - ground[node]) / free.step, free.step)
            vibration = turned(free.node_map, vibration)
            ahead = with_free(states, node + 1, vibration)
            for signal in range(SIGNALS):
                desk[HERE, signal] = desk[NEXT, signal]
            read_signals(pair, ahead, desk, NEXT)
            wanted = unquiet(pair, gap, state, span, desk)
            if wanted:
                lay_out(pair, state, span, terms, desk)
                touch = search_interval(pair, gap, wanted, free.step, terms, desk)
                if touch >= 0.0:
                    return node, touch, state_at(pair, desk, terms, touch)
            state = ahead
            node += 1
    return -1, 0.0, state


@kernel
def ramp_map(oscillator, step, terms, desk):
    """u and u̇ after one node interval from (u, u̇, a_g at its start, slope of a_g): 2 x 4 numbers."""
    places, speeds = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if oscillator.inverse_omega > 0.0:
        for part in range(4):
            place, speed = (1.0 if part == 0 else 0.0), (1.0 if part == 1 else 0.0)
            ramp = (1.0 if part == 2 else 0.0, 1.0 if part == 3 else 0.0)
            expand(oscillator, place, speed, ramp, desk, LEFT, terms)
            desk[HERE, part] = value_at(desk, LEFT, terms, step)
            desk[NEXT, part] = slope_at(desk, LEFT, terms, step)
        places = (desk[HERE, 0], desk[HERE, 1], desk[HERE, 2], desk[HERE, 3])
        speeds = (desk[NEXT, 0], desk[NEXT, 1], desk[NEXT, 2], desk[NEXT, 3])
    return places, speeds


@small
def ramped(ramp_maps, place, speed, span):
    """(u, u̇) at the end of a node interval."""
    a, b = ramp_maps
    return (
        a[0] * place + a[1] * speed + a[2] * span[0] + a[3] * span[1],
        b[0] * place + b[1] * speed + b[2] * span[0] + b[3] * span[1],
    )


@small
def widen(pair, state, span, desk):
    """Raise rows TOP and BOTTOM over what the signals can be within an interval, max and min ± |f''| h²/8."""
    left, right = pair
    turn_left = turn_bound(left, state[0], state[2], span)
    turn_right = turn_bound(right, state[1], state[3], span)
    bends = (
        turn_left + turn_right,
        turn_left,
        turn_right,
        shake_bound(left, turn_left),
        shake_bound(right, turn_right),
    )
    for signal in range(SIGNALS):
        reach = 0.125 * bends[signal] * span[2] * span[2]
        here, there = desk[HERE, signal], desk[NEXT, signal]
        desk[TOP, signal] = max(desk[TOP, signal], max(here, there) + reach)
        desk[BOTTOM, signal] = min(desk[BOTTOM, signal], min(here, there) - reach)


@kernel
def survey(pair, step, terms, ground, states, extremes):
    """Fill the free response: states at the nodes, and bounds of every watched signal in every block.

    The bounds of a block that raises a peak of the record so far are that peak, exactly; the largest of all blocks
    is therefore the peak of the whole free motion, and a run that has only flown freely knows its own.
    """
    desk = np.zeros((STAGES, 64))
    maps = ramp_map(pair[0], step, terms, desk), ramp_map(pair[1], step, terms, desk)
    last = ground.size - 1
    for block in range(extremes[0].shape[0]):
        first, stop = block * BLOCK, min(last, block * BLOCK + BLOCK)
        desk[TOP, :SIGNALS] = -inf
        desk[BOTTOM, :SIGNALS] = inf
        state = (states[first, 0], states[first, 1], states[first, 2], states[first, 3])
        read_signals(pair, state, desk, NEXT)
        for node in range(first, stop):
            span = (ground[node], (ground[node + 1] - ground[node]) / step, step)
            left, right = ramped(maps[0], state[0], state[2], span), ramped(maps[1], state[1], state[3], span)
            ahead = (left[0], right[0], left[1], right[1])
            for signal in range(SIGNALS):
                desk[HERE, signal] = desk[NEXT, signal]
            read_signals(pair, ahead, desk, NEXT)
            widen(pair, state, span, desk)
            for part in range(4):
                states[node + 1, part] = ahead[part]
            state = ahead
        measure_block(pair, step, terms, ground, states, (first, stop), desk)
        for signal in range(SIGNALS):
            extremes[0][block, signal] = min(desk[TOP, signal], desk[HIGH, signal])
            extremes[1][block, signal] = max(desk[BOTTOM, signal], desk[LOW, signal])


@kernel
def measure_block(pair, step, terms, ground, states, nodes, desk):
    """Raise the peaks so far, rows HIGH and LOW, by those of a block that can raise them."""
    record = False
    for signal in range(SIGNALS):
        record |= desk[TOP, signal] > desk[HIGH, signal] or desk[BOTTOM, signal] < desk[LOW, signal]
    if not record:
        return
    still = (0.0, 0.0, 0.0, 0.0)
    read_signals(pair, with_free(states, nodes[0], still), desk, NEXT)
    for node in range(nodes[0], nodes[1]):
        span = (ground[node], (ground[node + 1] - ground[node]) / step, step)
        state = with_free(states, node, still)
        for signal in range(SIGNALS):
            desk[HERE, signal] = desk[NEXT, signal]
        read_signals(pair, with_free(states, node + 1, still), desk, NEXT)
        wanted = unquiet(pair, inf, state, span, desk)
        if wanted:
            lay_out(pair, state, span, terms, desk)
            search_interval(pair, inf, wanted, step, terms, desk)
