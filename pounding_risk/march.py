"""One pair under one ground motion: flights and contacts in turn, to the end of the record.

`march` is the compiled run of one case, `sweep` the compiled grid of gaps and yield forces for one record and
one law. Both work on the response without contact (`free_response`), which is computed once and shared.
"""

from __future__ import annotations

from math import ceil, cos, exp, inf, nan, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._jit import kernel
from pounding_risk.collide import (
    AT_END,
    ELASTIC,
    EXHAUSTED,
    FINISHED,
    FORCE,
    LAST,
    NONE,
    NOT_FINITE,
    PART,
    PLACE_LEFT,
    TURN,
    UNDERFLOW,
    YIELD,
    YIELDING,
    Phase,
    attempt,
    begin,
    crest,
    energy_of,
    hides_crest,
    reading,
    slopes,
    state_of,
    switched,
    take_step,
    transmitted,
)
from pounding_risk.flight import BLOCK, DESK, END, HIGH, LOW, MAX_TERMS, SIGNALS, STAGES, STATE, TALLY, Free, fly, survey
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures import Building, Oscillator

# The tally of one run, by place.
(
    PENETRATION,
    COUNT,
    FIRST_TOUCH,
    CONTACT_TIME,
    APPROACH,
    PEAK_FORCE,
    LOWEST_FORCE,
    IMPULSE,
    DEMAND,
    YIELDS,
    FIRST_YIELD,
    VISCOUS,
    RESIDUAL,
    ENERGY,
    HELD,
    STEPS,
    STATUS,
) = range(17)

COMPLETE, TOO_MANY_CONTACTS = 0, 5
STATUS_SENTENCES = {
    COMPLETE: "complete",
    UNDERFLOW: "the step in contact fell below what the numbers resolve; raise rtol or lower the stiffness",
    EXHAUSTED: "the step budget ran out; raise rtol or lower the stiffness",
    NOT_FINITE: "the motion is not finite; check the record and the stiffness",
    TOO_MANY_CONTACTS: "more contacts than the limit; check the gap and the record",
}
MAX_CONTACTS = 200_000
MAX_STEPS = 20_000_000

CONTACT_COLUMNS = (
    "start", "end", "approach_speed", "restitution_asked", "peak_force", "uncapped_force", "peak_penetration",
    "yields", "rebound_speed", "impulse", "work",
)  # fmt: skip
STEP_COLUMNS = ("time", "u_left", "u_right", "v_left", "v_right", "force")


class Log(NamedTuple):
    """Where a run writes what `simulate` shows; arrays without rows switch it off."""

    contacts: np.ndarray  # (rows, CONTACT_COLUMNS)
    steps: np.ndarray  # (rows, STEP_COLUMNS)
    used: np.ndarray  # (2,) rows written


class Interface(NamedTuple):
    """What stands between two neighbours."""

    gap: float  # m
    law: Any
    restitution: Restitution
    yield_force: float = inf  # N


@kernel
def write_step(log, time, state, force):
    """Append one row of the time history in contact."""
    row = log.used[1]
    if row < log.steps.shape[0]:
        log.steps[row, 0] = time
        for part in range(4):
            log.steps[row, 1 + part] = state[part]
        log.steps[row, 5] = force
    log.used[1] = row + 1


@kernel
def raise_peak(watch, sign, best, impact, phase, span, desk):
    """max(best, sign × reading over the step), with the crest between its ends; the step's rows are kept."""
    best = max(best, sign * reading(watch, impact, phase, state_of(desk, END)))
    ends = hides_crest(watch, sign, best, impact, phase, span, desk)
    if ends[0] > 0.0:
        best = max(best, crest(watch, sign, ends, impact, phase, span, desk))
        attempt(impact, phase, span[0], span[1], desk)
        slopes(impact, phase, span[0] + span[1], state_of(desk, END), desk, LAST)
    return best


@kernel
def watch_step(impact, phase, span, peak, desk):
    """Peaks over an accepted step onto the desk; returns this contact's peak uncapped force so far."""
    peak = raise_peak(FORCE, 1.0, peak, impact, phase, span, desk)
    if impact.least == -inf:
        desk[TALLY, LOWEST_FORCE] = -raise_peak(FORCE, -1.0, -desk[TALLY, LOWEST_FORCE], impact, phase, span, desk)
    for watch in range(PLACE_LEFT, SIGNALS):
        desk[HIGH, watch] = raise_peak(watch, 1.0, desk[HIGH, watch], impact, phase, span, desk)
        desk[LOW, watch] = -raise_peak(watch, -1.0, -desk[LOW, watch], impact, phase, span, desk)
    return peak


@kernel
def touch_down(impact, held, touched, speed, desk):
    """Enter a new contact in the tally; returns the mechanical energy at the touch."""
    state = state_of(desk, STATE)
    if desk[TALLY, COUNT] == 0.0:
        desk[TALLY, FIRST_TOUCH] = touched
    desk[TALLY, COUNT] += 1.0
    desk[TALLY, APPROACH] = max(desk[TALLY, APPROACH], speed)
    desk[TALLY, HELD] += 1.0 if held else 0.0
    energy = energy_of((impact.left, impact.right), state)
    desk[TALLY, ENERGY] = max(desk[TALLY, ENERGY], energy)
    return energy


@kernel
def lift_off(impact, energy, peaks, duration, desk):
    """Close a contact in the tally; ``peaks`` = (uncapped force, transmitted force, penetration)."""
    state = state_of(desk, STATE)
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    after = energy_of((impact.left, impact.right), state)
    work = desk[STATE, 4]
    desk[TALLY, ENERGY] = max(desk[TALLY, ENERGY], after)
    desk[TALLY, RESIDUAL] += abs(after - energy - (desk[STATE, 6] - work))
    desk[TALLY, VISCOUS] += work - impact.law.stored(delta, impact.strength)
    desk[TALLY, CONTACT_TIME] += duration
    desk[TALLY, IMPULSE] += desk[STATE, 5]
    desk[TALLY, DEMAND] = max(desk[TALLY, DEMAND], peaks[0])
    desk[TALLY, PEAK_FORCE] = max(desk[TALLY, PEAK_FORCE], peaks[1])
    desk[TALLY, PENETRATION] = max(desk[TALLY, PENETRATION], peaks[2])
    desk[HIGH, 0] = max(desk[HIGH, 0], impact.gap + peaks[2])


@kernel
def write_contact(log, values, desk):
    """Append one row to the list of contacts."""
    row = log.used[0]
    if row < log.contacts.shape[0]:
        state = state_of(desk, STATE)
        for column in range(8):
            log.contacts[row, column] = values[column]
        log.contacts[row, 8] = state[3] - state[2]
        log.contacts[row, 9] = desk[STATE, 5]
        log.contacts[row, 10] = desk[STATE, 4]
    log.used[0] = row + 1


@kernel
def ramp_at(free, node, since):
    """a_g = a + b τ over one node interval that began ``since`` after the touch: (a, b)."""
    slope = (free.ground[node + 1] - free.ground[node]) / free.step
    return free.ground[node] - slope * since, slope


@kernel
def pound(pair, free, law, limits, rtol, start, state, desk, log):
    """One contact from the touch at ``start`` = (node, time after it) to the moment the bodies part.

    Returns (how it ended, node, time after it, state then).
    """
    node, offset = start
    impact, speed = begin(pair, free.fastest, law, limits, state)
    desk[STATE, :8] = 0.0
    for part in range(4):
        desk[STATE, part] = state[part]
    touched = node * free.step + offset
    energy = touch_down(impact, limits[2].beyond(speed), touched, speed, desk)
    peak, plateau, depth, yielded, stalled = 0.0, 0.0, 0.0, 0, 0
    since = -offset  # of the current node, after the touch
    s, h = 0.0, sqrt(sqrt(0.3 * impact.depth / impact.speed))
    ramp = ramp_at(free, node, since)
    phase = Phase(True, ELASTIC, ramp[0], ramp[1])
    slopes(impact, phase, s, state, desk, STAGES)
    write_step(log, touched, state, transmitted(impact, phase, state))
    finish = EXHAUSTED
    while desk[TALLY, STEPS] < MAX_STEPS:
        left = sqrt(sqrt(since + free.step)) - s
        if left <= 1e-13 * s:
            node += 1
            if node >= free.ground.size - 1:
                finish = AT_END
                break
            since = node * free.step - touched
            ramp = ramp_at(free, node, since)
            phase = Phase(phase.approaching, phase.region, ramp[0], ramp[1])
            slopes(impact, phase, s, state, desk, STAGES)
            continue
        moved, event, h, attempts = take_step(impact, phase, (s, h, left), rtol, desk)
        desk[TALLY, STEPS] += attempts
        if moved <= 0.0 and event == NONE:
            finish = UNDERFLOW if moved == 0.0 else NOT_FINITE
            break
        peak = watch_step(impact, phase, (s, moved), peak, desk)
        s += moved
        for part in range(7):
            desk[STATE, part] = desk[END, part]
        state = state_of(desk, STATE)
        time = touched + s * s * s * s
        delta = state[0] - state[1] - impact.gap
        if phase.region == YIELDING:
            plateau = max(plateau, transmitted(impact, phase, state))
        write_step(log, time, state, transmitted(impact, phase, state))
        # Events that follow each other without progress are rounding; a few are harmless, many are a defect.
        stalled = stalled + 1 if moved <= 1e-12 * s else 0
        if event == PART or stalled > 50:
            finish = FINISHED if event == PART else UNDERFLOW
            break
        if event == TURN and phase.approaching:
            depth = max(depth, delta)
        if event == YIELD and phase.region == ELASTIC:
            peak, plateau = max(peak, impact.strength), max(plateau, impact.strength)
            yielded += 1
            if yielded == 1:
                desk[TALLY, YIELDS] += 1.0
                if desk[TALLY, YIELDS] == 1.0:
                    desk[TALLY, FIRST_YIELD] = time
        if event == NONE:
            for part in range(7):
                desk[STAGES, part] = desk[LAST, part]
        else:
            phase = switched(event, phase)
            slopes(impact, phase, s, state, desk, STAGES)
    depth = max(depth, state[0] - state[1] - impact.gap)
    duration = s * s * s * s
    force = plateau if yielded > 0 else peak
    lift_off(impact, energy, (peak, force, depth), duration, desk)
    e = limits[2].at(speed)
    write_contact(log, (touched, touched + duration, speed, e, force, peak, depth, float(yielded)), desk)
    return finish, node, duration - since, state


@kernel
def march(pair, free, law, limits, rtol, desk, log):
    """One run from rest to the end of the record; ``limits`` = (gap, yield force, restitution).

    Peaks are left in rows HIGH and LOW of the desk, everything else in row TALLY.
    """
    desk[HIGH, :SIGNALS] = 0.0
    desk[LOW, :SIGNALS] = 0.0
    desk[TALLY, :] = 0.0
    desk[TALLY, FIRST_TOUCH] = nan
    desk[TALLY, FIRST_YIELD] = nan
    state = (0.0, 0.0, 0.0, 0.0)
    node, offset = 0, 0.0
    while True:
        node, offset, state = fly(pair, free, limits[0], (node, offset), state, desk)
        if node < 0:
            break
        if desk[TALLY, COUNT] >= MAX_CONTACTS:
            desk[TALLY, STATUS] = TOO_MANY_CONTACTS
            break
        finish, node, offset, state = pound(pair, free, law, limits, rtol, (node, offset), state, desk, log)
        if finish == AT_END:
            break
        if finish != FINISHED:
            desk[TALLY, STATUS] = finish
            break
    total = desk[TALLY, IMPULSE]
    for signal in range(SIGNALS):
        total += desk[HIGH, signal] + desk[LOW, signal]
    if not abs(total) < inf:
        desk[TALLY, STATUS] = NOT_FINITE


@kernel
def no_log():
    """A log that writes nothing."""
    return Log(np.zeros((0, 11)), np.zeros((0, 6)), np.zeros(2, dtype=np.int64))


def oscillators(left: Building, right: Building) -> tuple[Oscillator, Oscillator]:
    """The pair as the kernels see it."""
    return left.oscillator(), right.oscillator()


def _vibration_map(oscillator: Oscillator, time: float) -> tuple[float, float, float, float]:
    """Free vibration over ``time``: u and u̇ at its end from those at its start, as four numbers."""
    if oscillator.inverse_omega == 0.0:
        return (0.0, 0.0, 0.0, 0.0)
    fade = 0.5 * oscillator.fade
    rate = sqrt(oscillator.spring - fade * fade)
    decay, c, s = exp(-fade * time), cos(rate * time), sin(rate * time)
    return (
        decay * (c + fade / rate * s),
        decay * s / rate,
        -decay * oscillator.spring / rate * s,
        decay * (c - fade / rate * s),
    )


def free_response(pair: tuple[Oscillator, Oscillator], acceleration: np.ndarray, dt: float) -> Free:
    """The response of both buildings without contact to a_g [m/s²] sampled every ``dt`` [s], from rest.

    Exact for a_g linear between samples. Samples are divided where the stiffer building would pass more than
    2.5 rad of its vibration between them, so that a Taylor series sums to rounding over every interval.
    """
    omega = max(0.0 if o.inverse_omega == 0.0 else 1.0 / o.inverse_omega for o in pair)
    parts = max(1, ceil(omega * dt / 2.5))
    count = (len(acceleration) - 1) * parts + 1
    ground = np.interp(np.arange(count) / parts, np.arange(len(acceleration)), acceleration)
    step = dt / parts
    terms, size = 4, 1.0
    while size > 1e-19 and terms < MAX_TERMS:
        size *= max(omega * step, 1e-3) / (terms - 3)
        terms += 1
    blocks = ceil((count - 1) / BLOCK)
    states = np.zeros((count, 4))
    extremes = np.zeros((blocks, SIGNALS)), np.zeros((blocks, SIGNALS))
    survey(pair, step, terms, ground, states, extremes)
    node_map, block_map = (tuple(_vibration_map(o, span) for o in pair) for span in (step, BLOCK * step))
    fastest = float(np.abs(states[:, 2] - states[:, 3]).max())
    return Free(ground, step, terms, states, *extremes, node_map, block_map, fastest)


def run(pair, free: Free, interface: Interface, rtol: float, log: Log | None = None) -> np.ndarray:
    """`march` for one interface; returns the desk."""
    desk = np.zeros(DESK)
    limits = (float(interface.gap), float(interface.yield_force), interface.restitution)
    march(pair, free, interface.law, limits, float(rtol), desk, log or no_log())
    return desk


def solve(left: Building, right: Building, interface: Interface, acceleration, dt: float, *, rtol: float = 1e-6):
    """One run of a pair: every output by name, SI units; NaN where a run failed (its status says why)."""
    pair = oscillators(left, right)
    free = free_response(pair, np.asarray(acceleration, dtype=np.float64), float(dt))
    return outputs(run(pair, free, interface, rtol), interface.yield_force)


def outputs(desk: np.ndarray, yield_force: float) -> dict[str, float]:
    """The named outputs of one run."""
    tally, high, low = desk[TALLY], desk[HIGH], desk[LOW]
    return {
        "peak_closing": high[0],
        "peak_opening": -low[0],
        "peak_relative_displacement": max(high[0], -low[0]),
        "peak_penetration": tally[PENETRATION],
        "impact_count": tally[COUNT],
        "first_impact_time": tally[FIRST_TOUCH],
        "contact_time": tally[CONTACT_TIME],
        "peak_approach_speed": tally[APPROACH],
        "peak_contact_force": tally[PEAK_FORCE],
        "lowest_contact_force": tally[LOWEST_FORCE],
        "impulse": tally[IMPULSE],
        "yield_demand": tally[DEMAND] / yield_force,
        "yield_exceedance": float(tally[DEMAND] >= yield_force),
        "yield_count": tally[YIELDS],
        "first_yield_time": tally[FIRST_YIELD],
        "energy_viscous": tally[VISCOUS],
        "energy_plastic": 0.0,
        "energy_residual": tally[RESIDUAL] / tally[ENERGY] if tally[ENERGY] > 0.0 else 0.0,
        "peak_displacement_left": max(high[1], -low[1]),
        "peak_displacement_right": max(high[2], -low[2]),
        "peak_floor_acceleration_left": max(high[3], -low[3]),
        "peak_floor_acceleration_right": max(high[4], -low[4]),
        "status": tally[STATUS],
        "steps": tally[STEPS],
    }
