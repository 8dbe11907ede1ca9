"""One pair under one ground motion: the response without contact, and a run with it."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, cos, exp, inf, isfinite, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.models.ground import DelayedGround, Support, UniformGround, accelerations, delayed, divided, is_apart
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import Building, Oscillator
from pounding_risk.solver.counters import FIRST_YIELD, STATUS, STEPS, TALLIED, YIELDS, Log, make_log
from pounding_risk.solver.pair.equations import Limits
from pounding_risk.solver.pair.flight import BLOCK, Free
from pounding_risk.solver.pair.free import fill_free_response
from pounding_risk.solver.pair.laws import by_address
from pounding_risk.solver.pair.outputs import building_outputs, run_outputs
from pounding_risk.solver.pair.run import march
from pounding_risk.solver.workspace import SIGNALS, make_workspace, parts_and_terms

AT_REST = (0.0, 0.0, 0.0, 0.0)  # of `initial_state`


class Interface(NamedTuple):
    """Gap, contact law, restitution and yield force between two neighbours."""

    gap: float  # m
    law: Any
    restitution: Restitution
    yield_force: float = inf  # N


def oscillators(left: Building, right: Building) -> tuple[Oscillator, Oscillator]:
    """Both buildings as the kernels take them."""
    return left.oscillator(), right.oscillator()


def initial_state(left: Building, right: Building) -> tuple[float, float, float, float]:
    """u of both [m] and u̇ of both [m/s] when the motion begins."""
    return left.initial_displacement, right.initial_displacement, left.initial_velocity, right.initial_velocity


def _vibration_map(oscillator: Oscillator, time: float) -> tuple[float, float, float, float]:
    """Free vibration over ``time``: u and u̇ at its end from those at its start, as four numbers."""
    if oscillator.inverse_omega == 0.0:
        return (0.0, 0.0, 0.0, 0.0)
    zeta_omega = 0.5 * oscillator.two_zeta_omega
    rate = sqrt(oscillator.omega2 - zeta_omega * zeta_omega)
    decay, c, s = exp(-zeta_omega * time), cos(rate * time), sin(rate * time)
    return (
        decay * (c + zeta_omega / rate * s),
        decay * s / rate,
        -decay * oscillator.omega2 / rate * s,
        decay * (c - zeta_omega / rate * s),
    )


def vibration_maps(pair: tuple[Oscillator, Oscillator], time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Free vibration of both buildings over ``time`` [s], as `_vibration_map` gives it for one."""
    return _vibration_map(pair[0], time), _vibration_map(pair[1], time)


def free_response(
    pair: tuple[Oscillator, Oscillator],
    acceleration: np.ndarray,
    dt: float,
    supports: Sequence[Support] = (),
    initial: Sequence[float] = AT_REST,
    own: Sequence[np.ndarray | None] = (),
) -> Free:
    """The response of both buildings without contact to a_g [m/s²] sampled every ``dt`` [s].

    ``supports`` and ``own`` say what a_g is under each, as `accelerations` takes them. It begins as ``initial``, of
    `initial_state`.

    Exact for a_g linear between samples; NaN from the first sample on that is not finite. Samples are divided
    where the stiffer building would pass more than 2.5 rad of its vibration between them, so that a Taylor series
    sums to rounding over every interval.
    """
    free = at_rest(pair, acceleration, dt, supports, own)
    free.states[0] = initial
    fill_free_response(pair, free, make_workspace())
    passage = free.passage
    closing = free.states[:, 2] - free.states[:, 3] - (passage.rate if isinstance(passage, DelayedGround) else 0.0)
    return free._replace(fastest=float(np.abs(closing).max()))


def at_rest(
    pair: tuple[Oscillator, Oscillator],
    acceleration: np.ndarray,
    dt: float,
    supports: Sequence[Support] = (),
    own: Sequence[np.ndarray | None] = (),
) -> Free:
    """Arrays of a `free_response` that has not been computed yet: the pair at rest at every node."""
    omega = max(0.0 if o.inverse_omega == 0.0 else 1.0 / o.inverse_omega for o in pair)
    parts, terms = parts_and_terms(omega, dt)
    under = accelerations(supports, np.asarray(acceleration), own)
    ground = np.where(np.isfinite(under), under, np.nan) if parts == 1 else divided(under, parts)
    step = dt / parts
    passage: UniformGround | DelayedGround = UniformGround(parts)
    if is_apart(supports, under):
        left, right = supports
        passing = delayed(ground, step, right.delay - left.delay, right.velocity - left.velocity)
        ground, passage = passing.left, passing._replace(maps=vibration_maps(pair, step - passing.first))
    states = np.zeros((ground.size, 4))
    blocks = ceil((ground.size - 1) / BLOCK)
    high, low = np.zeros((2, blocks, SIGNALS))
    node_map, block_map = (vibration_maps(pair, time) for time in (passage.width(step, 0), passage.moment(step, BLOCK)))
    return Free(ground, step, terms, states, high, low, node_map, block_map, 0.0, passage)


def workspace_for(free: Free, rtol: float) -> Any:
    """Workspace of one thread for runs over ``free`` to the relative tolerance ``rtol``.

    Where a building vibrates within a sample it is that vibration, and no longer the samples, that limits the steps:
    the method of the tightest tolerances then takes fewer evaluations at the loose ones too.
    """
    return make_workspace(rtol if free.passage.straight(0) == 1 else 0.0)


def run(pair, free: Free, interface: Interface, rtol: float, log: Log | None = None) -> np.ndarray:
    """`march` for one interface; returns its raw columns (see `outputs`)."""
    workspace = workspace_for(free, rtol)
    limits = Limits(float(interface.gap), float(interface.yield_force), interface.restitution)
    march(pair, free, by_address(interface.law), limits, float(rtol), workspace, log or make_log(0, 0, np.zeros(0)))
    return np.concatenate([workspace.counters[:TALLIED], workspace.high, workspace.low])


def solve(
    left: Building,
    right: Building,
    interface: Interface,
    acceleration,
    dt: float,
    *,
    supports: Sequence[Support] = (),
    rtol: float = 1e-6,
) -> dict[str, float]:
    """One run of a pair under a_g [m/s²] sampled every ``dt`` [s]: every output by name, in SI units.

    ``supports`` say what a_g is under each building. The run ends with the last sample: zeros have to follow a motion
    that reaches a building late, as `Motion.reaching` adds them. Outputs per building carry ``_left`` or ``_right``. A
    failed run is NaN, or −1 in counts; ``status`` says why.
    A law without a cap counts its yielding too: its force reaches the yield force.
    """
    ground = np.asarray(acceleration, dtype=np.float64)
    pair = oscillators(left, right)
    capped = isfinite(interface.law.ceiling(1.0))
    log = make_log(0, 0, np.zeros(0) if capped else np.array([float(interface.yield_force)]))
    free = free_response(pair, ground, float(dt), supports, initial_state(left, right))
    raw = run(pair, free, interface, rtol, log)
    if not capped:
        raw[YIELDS], raw[FIRST_YIELD] = log.reached[0], log.first[0]
    named = {name: float(value) for name, value in run_outputs(raw, interface.yield_force).items()}
    peaks = np.abs(accelerations(supports, ground)).max(axis=-1)
    sides = building_outputs(raw, (left, right), np.broadcast_to(peaks, 2))
    for name, values in sides.items():
        named[f"{name}_left"], named[f"{name}_right"] = float(values[0]), float(values[1])
    return {**named, "status": float(raw[STATUS]), "steps": float(raw[STEPS])}
