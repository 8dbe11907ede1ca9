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
    HIGH,
    LEFT,
    LOW,
    NEXT,
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
SIGNALS = 5  # relative displacement; displacement left, right; absolute acceleration left, right


class Free(NamedTuple):
    """The response without contact of one pair to one ground motion; shapes with N nodes and B blocks."""

    ground: np.ndarray  # (N,) a_g [m/s²]
    step: float  # between nodes [s]
    terms: int  # of the Taylor series over one step
    states: np.ndarray  # (N, 4) u_left, u_right, v_left, v_right
    high: np.ndarray  # (B, SIGNALS) largest value in the block, between nodes too
    low: np.ndarray  # (B, SIGNALS)
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
    """No |ü| within the interval is larger: u̇ + slope/ω² is a free vibration, whose energy only falls."""
    drift = (oscillator.spring * speed + oscillator.ground * ramp[1]) * oscillator.inverse_omega
    pull = oscillator.ground * ramp[0] + oscillator.fade * speed + oscillator.spring * place
    return sqrt(drift * drift + pull * pull)


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
def search_interval(pair, gap, state, span, terms, desk):
    """One stretch of flight inside a node interval: the first touch in it, and the peaks up to there.

    ``state`` at its start, ``span`` = (a_g there, slope of a_g, length). Returns the time of the touch after the
    start, or −1; the peaks are raised in rows HIGH and LOW, the series of both buildings left on the desk.
    """
    left, right = pair
    expand(left, state[0], state[2], span, desk, LEFT, terms)
    expand(right, state[1], state[3], span, desk, RIGHT, terms)
    signal_row(0, pair, desk, terms)
    touch = first_rise(desk, terms, gap, span[2])
    stop = touch if touch >= 0.0 else span[2]
    if stop > 0.0:
        for signal in range(SIGNALS):
            row, count = signal_row(signal, pair, desk, terms)
            desk[HIGH, signal] = highest(desk, row, count, 1.0, stop, desk[HIGH, signal])
            desk[LOW, signal] = -highest(desk, row, count, -1.0, stop, -desk[LOW, signal])
    return touch


@small
def interval_is_quiet(pair, gap, state, span, desk):
    """True where neither a touch nor a new peak fits between the two ends (their signals in HERE and NEXT)."""
    left, right = pair
    turn_left = turn_bound(left, state[0], state[2], span)
    turn_right = turn_bound(right, state[1], state[3], span)
    for signal in range(SIGNALS):
        if signal == 0:
            bend = turn_left + turn_right
        elif signal == 1:
            bend = turn_left
        elif signal == 2:
            bend = turn_right
        elif signal == 3:
            bend = shake_bound(left, turn_left)
        else:
            bend = shake_bound(right, turn_right)
        here, there = desk[HERE, signal], desk[NEXT, signal]
        # The coarser bound first, max + |f''| h²/8: it settles most intervals without a division.
        reach = 0.125 * bend * span[2] * span[2]
        top, bottom = max(here, there) + reach, min(here, there) - reach
        if top <= desk[HIGH, signal] and bottom >= desk[LOW, signal] and (signal > 0 or top <= gap):
            continue
        crest = crest_bound(here, there, span[2], bend)
        if crest > desk[HIGH, signal] or (signal == 0 and crest > gap):
            return False
        if -crest_bound(-here, -there, span[2], bend) < desk[LOW, signal]:
            return False
    return True


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
        touch = search_interval(pair, gap, state, (ground[node] + slope * offset, slope, length), terms, desk)
        if touch >= 0.0:
            return node, offset + touch, state_at(pair, desk, terms, touch)
        state = state_at(pair, desk, terms, length)
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
            if not interval_is_quiet(pair, gap, state, span, desk):
                touch = search_interval(pair, gap, state, span, terms, desk)
                if touch >= 0.0:
                    return node, touch, state_at(pair, desk, terms, touch)
            state = ahead
            node += 1
    return -1, 0.0, state


@kernel
def survey(pair, step, terms, ground, states, extremes):
    """Fill the free response: states at the nodes, and the extremes of every watched signal in every block."""
    high, low = extremes
    desk = np.zeros((STAGES, 64))
    for node in range(ground.size - 1):
        block = node // BLOCK
        state = (states[node, 0], states[node, 1], states[node, 2], states[node, 3])
        if node % BLOCK == 0:
            read_signals(pair, state, desk, HIGH)
            read_signals(pair, state, desk, LOW)
        span = (ground[node], (ground[node + 1] - ground[node]) / step, step)
        search_interval(pair, inf, state, span, terms, desk)
        ahead = state_at(pair, desk, terms, step)
        for part in range(4):
            states[node + 1, part] = ahead[part]
        for signal in range(SIGNALS):
            high[block, signal] = desk[HIGH, signal]
            low[block, signal] = desk[LOW, signal]
