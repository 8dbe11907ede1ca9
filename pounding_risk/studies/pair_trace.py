"""Histories of one run of a pair, from the log of its solver: motion, contact force and energies at every instant."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.grid_job import peaks_under
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.pair_job import PairJob
from pounding_risk.models.ground import DelayedGround
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.results.run_labels import Case, Trace
from pounding_risk.scene.ground_motion import in_space
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import CONTACT_COLUMNS, FIRST_YIELD, STATUS, YIELDS, Log, make_log
from pounding_risk.solver.pair.api import Interface, free_response, initial_state, oscillators, run
from pounding_risk.solver.pair.flight import Free, state_at, write_series
from pounding_risk.solver.pair.outputs import building_outputs, run_outputs
from pounding_risk.solver.workspace import make_workspace

Array = NDArray[np.float64]
ROWS = 4096  # to begin with; a log that overflows is recorded again with the room that it needs


def pair_trace(study: Scene, case: Case) -> Trace:
    """The run of a case of a pair in full."""
    pair = oscillators(*study.pair)
    motion, supports = case.motion, study.supports
    free = free_response(pair, motion.acceleration, motion.dt, supports, initial_state(*study.pair), motion.own_grounds)
    strength = float(case.yield_forces[0])
    law = law_of(study, case.contact_model)
    raw, log = logged(pair, free, Interface(float(case.gaps[0]), law, study.restitution, strength), study.rtol)
    # A motion beyond all numbers is reported by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        run_histories = histories(pair, free, log)
        energy = energies(pair, free, run_histories)
    time, states, force, _, impulse = run_histories
    # A rigid building has no floor that moves.
    floor_states = np.where([building.is_rigid for building in study.pair], np.nan, states.reshape(-1, 2, 2))
    contacts = log.contacts[: log.used[0]]
    outputs = {name: array[None] for name, array in run_outputs(raw, strength).items()}
    outputs |= building_outputs(raw, study.pair, peaks_under(study, case.motion))
    return Trace(
        time,
        {
            "displacement": floor_states[:, 0, :, None],
            **in_space(study, motion, time, floor_states[:, 0, :, None]),
            "velocity": floor_states[:, 1, :, None],
            "relative_displacement": relative_displacement(free, time, states)[:, None],
            "contact_force": force[:, None],
            "contact_impulse_so_far": impulse[:, None],
            **_grounds_at(free, time),
            **{f"energy_{kind}": history for kind, history in energy.items()},
        },
        {name: contacts[:, column] for column, name in enumerate(CONTACT_COLUMNS)},
        [0] * len(contacts),
        {name: (output, outputs[name]) for name, output in PairJob.outputs(study).items()},
        int(raw[STATUS]),
        law,
        float(log.steps[: log.used[1], 0].max(initial=0.0)),
    )


def _grounds_at(free: Free, time: Array) -> dict[str, Array]:
    """Histories of the ground; those under each building on unlike grounds."""
    left = np.interp(time, _node_times(free), free.ground)
    if not isinstance(free.passage, DelayedGround):
        return {"ground_acceleration": left}
    right = np.interp(time, _node_times(free), free.passage.right)
    return {
        "ground_acceleration": left,
        "building_ground_acceleration": np.column_stack([left, right]),
        "ground_widening": widening(free, time)[0][:, None],
    }


def logged(pair: Any, free: Free, interface: Interface, rtol: float) -> tuple[Array, Log]:
    """A run with its log, whole: (raw columns, log)."""
    contacts, steps = ROWS, 8 * ROWS
    while True:
        log = make_log(contacts, steps, np.array([float(interface.yield_force)]))
        raw = run(pair, free, interface, rtol, log)
        if log.used[0] <= contacts and log.used[1] <= steps:
            if not isfinite(interface.law.ceiling(1.0)):
                # A law without a cap yields where its force reaches the yield force, as in `pair.solve`.
                raw[YIELDS], raw[FIRST_YIELD] = log.reached[0], log.first[0]
            return raw, log
        contacts, steps = max(contacts, int(log.used[0])), max(steps, int(log.used[1]))


def _node_times(free: Free) -> Array:
    return np.asarray(free.passage.moment(free.step, np.arange(free.ground.size)))


def relative_displacement(free: Free, time: Array, states: Array) -> Array:
    """What closes the gap at these times: u_left − u_right, and what the ground itself adds."""
    return states[:, 0] - states[:, 1] - widening(free, time)[0]


def widening(free: Free, time: Array) -> Array:
    """(w, ẇ, ẅ) of w = x_right − x_left at these times, shape (3, n)."""
    table = np.zeros((3, len(time)))
    if not isinstance(free.passage, DelayedGround):
        return table
    wave, node = free.passage, _nodes_before(free, time)
    elapsed = time - _node_times(free)[node]
    bend, slope = (wave.right - wave.left)[node], (wave.right_slope - wave.left_slope)[node]
    table[2] = bend + slope * elapsed
    table[1] = wave.rate[node] + elapsed * (bend + 0.5 * elapsed * slope)
    table[0] = wave.spread[node] + elapsed * (wave.rate[node] + elapsed * (0.5 * bend + elapsed * slope / 6.0))
    return table


def _nodes_before(free: Free, time: Array) -> NDArray[np.int64]:
    """The node at or before each time, never the last one."""
    nodes = np.searchsorted(_node_times(free), time, side="right") - 1
    return np.asarray(np.clip(nodes, 0, free.ground.size - 2), dtype=np.int64)


def histories(pair: tuple[Oscillator, Oscillator], free: Free, log: Log) -> tuple[Array, Array, Array, Array, Array]:
    """(times, states (n, 4), contact force, its work so far, its impulse so far) over the whole record.

    In contact the solver's own steps; in flight the free response plus the free vibration that the last contact
    left, in closed form, at every node.
    """
    nodes = _node_times(free)
    pieces = []
    end_time, first, sums = -np.inf, 0, np.zeros(2)
    vibration = np.zeros(4)
    for contact in [*log.contacts[: log.used[0]], None]:
        touch = np.inf if contact is None else contact[0]
        is_inside = (nodes > end_time) & (nodes < touch)
        flight = np.zeros((is_inside.sum(), 8))
        flight[:, 0] = nodes[is_inside]
        flight[:, 1:5] = free.states[is_inside] + _vibrations(pair, vibration, nodes[is_inside] - end_time)
        flight[:, 6:] = sums
        pieces.append(flight)
        if contact is None:
            break
        last = int(contact[11])
        piece = log.steps[first:last].copy()
        piece[:, 6:] += sums
        pieces.append(piece)
        first, end_time, sums = last, float(piece[-1, 0]), piece[-1, 6:]
        vibration = piece[-1, 1:5] - _free_at(pair, free, end_time)
    rows = np.concatenate(pieces)
    return rows[:, 0], rows[:, 1:5], rows[:, 5], rows[:, 6], rows[:, 7]


def _vibrations(pair: tuple[Oscillator, Oscillator], start: Array, elapsed: Array) -> Array:
    """Free vibration of both buildings from ``start`` (u, u, v, v), at times ``after`` it: shape (n, 4)."""
    states = np.zeros((len(elapsed), 4))
    if not np.any(start):
        return states
    for side, oscillator in enumerate(pair):
        if oscillator.inverse_omega == 0.0:
            continue
        zeta_omega = 0.5 * oscillator.two_zeta_omega
        rate = np.sqrt(oscillator.omega2 - zeta_omega * zeta_omega)
        decay, c, s = np.exp(-zeta_omega * elapsed), np.cos(rate * elapsed), np.sin(rate * elapsed) / rate
        u, v = start[side], start[side + 2]
        states[:, side] = decay * (u * c + (v + zeta_omega * u) * s)
        states[:, side + 2] = decay * (v * c - (oscillator.omega2 * u + zeta_omega * v) * s)
    return states


def _free_at(pair: tuple[Oscillator, Oscillator], free: Free, time: float) -> Array:
    """The free response between nodes, from its series."""
    node = int(_nodes_before(free, np.array([time]))[0])
    workspace = make_workspace()
    write_series(
        pair, tuple(free.states[node]), free.passage.interval(free.ground, free.step, node, 0.0), free.terms, workspace
    )
    return np.array(state_at(pair, workspace, free.terms, time - free.passage.moment(free.step, node)))


def energies(pair: tuple[Oscillator, Oscillator], free: Free, motion: tuple[Array, ...]) -> dict[str, Array]:
    """Energy of both buildings together at every time, by kind [J].

    Over an interval with a_g linear, −m ∫ a_g u̇ dt = −m ([a_g u] − a_g' ∫ u dt), and ∫ u dt follows from the
    equation of motion integrated once; what the structures' dampers took is what is left of the balance. A passing
    wave carries the buildings against each other: the ground then takes ∫ F ẇ dt out.
    """
    time, states, force, work, impulse = motion
    length = np.diff(time)
    put_in = -_carried(free, time, force, impulse)
    stored = np.zeros_like(time)
    for side, oscillator in enumerate(pair):
        if oscillator.inverse_omega == 0.0:
            continue
        begins, slope = _grounds(free, time, side)
        ends = begins + slope * length
        area = 0.5 * (ends + begins) * length
        u, v = states[:, side], states[:, side + 2]
        push = (1.0, -1.0)[side] * np.diff(impulse) * oscillator.inverse_mass
        placed = (-area - np.diff(v) - oscillator.two_zeta_omega * np.diff(u) - push) / oscillator.omega2
        put_in[1:] -= oscillator.mass * np.cumsum(ends * u[1:] - begins * u[:-1] - slope * placed)
        stored += 0.5 * oscillator.mass * (v * v + oscillator.omega2 * u * u)
    return {"ground": put_in, "held": stored, "contact": work, "damping": put_in + stored[0] - stored - work}


def _grounds(free: Free, time: Array, side: int) -> tuple[Array, Array]:
    """a_g under a building at the beginning of every interval between these times, and its slope there."""
    # The interval between two nodes is known by its middle: an end may stand on either side of a node by rounding.
    node = _nodes_before(free, 0.5 * (time[1:] + time[:-1]))
    elapsed = time[:-1] - _node_times(free)[node]
    if isinstance(free.passage, DelayedGround):
        wave = free.passage
        displacements, slopes = ((wave.left, wave.left_slope), (wave.right, wave.right_slope))[side]
        return displacements[node] + slopes[node] * elapsed, slopes[node]
    slope = (free.ground[node + 1] - free.ground[node]) / free.step
    return free.ground[node] + slope * elapsed, slope


def _carried(free: Free, time: Array, force: Array, impulse: Array) -> Array:
    """∫ F ẇ dt = [ẇ J] − ∫ ẅ J dt, J = ∫ F dt, up to every time; by Hermite's rule, which knows F at both ends.

    Its error is (ω h)⁴ / 720 over intervals h in which F moves with ω: some millionths.
    """
    rate, length = widening(free, time)[1], np.diff(time)
    (left, left_slope), (right, right_slope) = (_grounds(free, time, side) for side in (0, 1))
    begins, twist = right - left, right_slope - left_slope
    ends = begins + twist * length
    turns = (begins * force[:-1] - ends * force[1:]) + twist * (impulse[:-1] - impulse[1:])
    areas = 0.5 * length * (ends * impulse[1:] + begins * impulse[:-1]) + length**2 / 12.0 * turns
    return rate * impulse - np.append(0.0, np.cumsum(areas))
