"""The general way: SciPy's ``solve_ivp``, started anew at every record sample and every event, in plain Python.

Events are found by SciPy's own root search: touch, separation, δ̇ = 0, the uncapped force meeting the force at which
the law yields, the force of a law that cannot pull meeting zero; so are the crests of the relative displacement and
of the force, which are read where they lie. Whatever the contact law, it is asked through its own verbs.
"""

from __future__ import annotations

from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

ABSOLUTE = np.array([1e-14, 1e-14, 1e-13, 1e-13])  # m, m, m/s, m/s
SOLVERS = ("DOP853", "Radau")
SLACK, ELASTIC, YIELDING = -1, 0, 1  # force cut at zero, uncapped, on the plateau
CLOSING, TURN = 0, 1  # places in the list of events; then yielding and tension, where the law has them, and the crest
NUDGE = 1e-4  # of a contact's age: half the span of the difference that stands for dF/dt


class GaveUp(RuntimeError):
    """An integrator that stopped before the end of a run, with its own words."""


class Phase(NamedTuple):
    """Which piece of the law holds, and what this contact remembers."""

    touching: bool = False
    approaching: bool = True
    region: int = ELASTIC
    memory: float = 0.0
    since: float = 0.0  # time of the touch, from the start of the present sample [s]


class Answer(NamedTuple):
    """One run: peaks and counts in SI units; ``steps`` are those in contact."""

    peak_relative_displacement: float
    peak_closing: float
    peak_contact_force: float
    uncapped_force: float
    impact_count: float
    first_impact_time: float
    steps: float


class RunPeaks:
    """Largest values of the run so far."""

    def __init__(self) -> None:
        self.reach = self.closing = self.force = self.demand = 0.0
        self.count = self.steps = 0
        self.first = nan

    def look(self, model: ScipyPair, states: Any) -> None:
        """Raise every peak to the states given, one a row, all on the present piece of the law."""
        closing = states[:, 0] - states[:, 1]
        self.reach = max(self.reach, float(np.abs(closing).max()))
        self.closing = max(self.closing, float(closing.max()))
        if model.phase.touching:
            self.force = max(self.force, *(model.force(state) for state in states.tolist()))
            self.demand = max(self.demand, *(model.uncapped(state) for state in states.tolist()))


class ScipyPair:
    """A pair between events; state u_left, u_right, v_left, v_right."""

    def __init__(self, pair: Any, interface: Any) -> None:
        (self.left, self.right), self.interface = pair, interface
        self.law = interface.law
        self.strength, self.least = self.law.ceiling(interface.yield_force), self.law.floor()
        self.ramp = (0.0, 0.0)  # a_g at t = 0 and its slope, over the present sample
        self.phase = Phase()

    def uncapped(self, y: Any) -> float:
        """The law's force without cap or cut, on the present branch."""
        delta = max(y[0] - y[1] - self.interface.gap, 0.0)
        return self.law.force(self.phase.memory, delta, y[2] - y[3], self.phase.approaching)

    def force(self, y: Any) -> float:
        """Force that the contact transmits in state ``y``, on its present branch [N]; 0 while it is open."""
        if not self.phase.touching or self.phase.region == SLACK:
            return 0.0
        if self.phase.region == YIELDING:
            return self.law.plateau(max(y[0] - y[1] - self.interface.gap, 0.0), self.strength)
        return self.uncapped(y)

    def rates(self, t: float, y: Any) -> tuple[float, float, float, float]:
        """dy/dt of ``y`` = (u_left, u_right, v_left, v_right) [m/s, m/s²] at ``t`` [s] of the present sample."""
        u_left, u_right, v_left, v_right = y.tolist()
        a_g, force = self.ramp[0] + self.ramp[1] * t, self.force((u_left, u_right, v_left, v_right))
        left, right = self.left, self.right
        return (
            v_left,
            v_right,
            -left.ground * a_g - left.two_zeta_omega * v_left - left.omega2 * u_left - left.inverse_mass * force,
            -right.ground * a_g - right.two_zeta_omega * v_right - right.omega2 * u_right + right.inverse_mass * force,
        )

    def force_rate(self, t: float, y: Any) -> float:
        """dF/dt as a difference along the motion, times age^¾ that it may be finite at the touch, where it is 1."""
        age = t - self.phase.since
        if age <= 0.0:
            return 1.0
        shift = NUDGE * age * np.array(self.rates(t, y))
        return (self.force(y + shift) - self.force(y - shift)) / (2.0 * NUDGE * age**0.25)

    def events(self) -> list[Any]:
        """The events that end this piece, then the crests that do not: functions as ``solve_ivp`` wants them."""
        gap, phase = self.interface.gap, self.phase
        turn = -1.0 if phase.approaching else 1.0
        functions = [
            _event(lambda t, y: y[0] - y[1] - gap, -1.0 if phase.touching else 1.0, True),
            _event(lambda t, y: y[2] - y[3], turn if phase.touching else 0.0, phase.touching),
        ]
        if not phase.touching:
            return functions
        if self.strength < inf:
            falls = -1.0 if phase.region == YIELDING else 1.0
            functions.append(_event(lambda t, y: self.uncapped(y) - self.strength, falls, True))
        if self.least > -inf:
            rises = 1.0 if phase.region == SLACK else -1.0
            functions.append(_event(lambda t, y: self.uncapped(y), rises, True))
        return [*functions, _event(self.force_rate, -1.0, False)]

    def after(self, event: int, y: Any, time: float) -> Phase:
        """Branch of the law after event number ``event``, in state ``y`` at ``time`` [s] of the present sample."""
        phase = self.phase
        if event == CLOSING:
            if phase.touching:
                return Phase()
            speed = max(float(y[2] - y[3]), 0.0)
            mass = 1.0 / (self.left.inverse_mass + self.right.inverse_mass)
            memory = self.law.begin(self.interface.restitution.at(speed), speed, mass)
            return Phase(True, True, ELASTIC, memory, time)
        if event == TURN:
            return phase._replace(approaching=not phase.approaching)
        far_region = YIELDING if self.strength < inf else SLACK
        return phase._replace(region=ELASTIC if phase.region == far_region else far_region)


def _event(function: Any, direction: float, terminal: bool) -> Any:
    def event(t: float, y: Any) -> float:
        return function(t, y)

    event.direction, event.terminal = direction, terminal  # type: ignore[attr-defined]
    return event


def _what_ended(solution: Any, events: list[Any]) -> int:
    """The event that ended the piece: of those that can, the one found last."""
    pairs = zip(solution.t_events, events, strict=True)
    last = [times[-1] if len(times) and event.terminal else -1.0 for times, event in pairs]
    return int(np.argmax(last))


def solve_general(solver: str, pair: Any, interface: Any, motion: tuple[Any, float], rtol: float) -> Answer:
    """One run from rest by a solver of `SOLVERS`; ``motion`` = (a_g [m/s²], time between samples [s]).

    Raises GaveUp where SciPy does, ValueError for a ground motion that is not finite.
    """
    model, peaks = ScipyPair(pair, interface), RunPeaks()
    ground, dt = np.asarray(motion[0], dtype=float), float(motion[1])
    if not np.isfinite(ground).all():
        # SciPy's step control would try again for ever.
        raise ValueError(f"sample {int(np.argmin(np.isfinite(ground)))} of the ground motion is not finite")
    options: Any = {"method": solver, "rtol": rtol, "atol": ABSOLUTE}
    y = np.zeros(4)
    for sample in range(len(ground) - 1):
        model.ramp = (float(ground[sample]), float(ground[sample + 1] - ground[sample]) / dt)
        time = 0.0
        while time < dt * (1.0 - 1e-12):
            events = model.events()
            solution: Any = solve_ivp(model.rates, (time, dt), y, events=events, **options)
            if not solution.success:
                when = f"{sample * dt + float(solution.t[-1]):g} s"
                raise GaveUp(f"{solver} at rtol {rtol:g} stopped at {when}: {solution.message}")
            peaks.look(model, np.vstack([solution.y.T, *(crests for crests in solution.y_events if len(crests))]))
            peaks.steps += model.phase.touching * (len(solution.t) - 1)
            y, time = solution.y[:, -1].copy(), float(solution.t[-1])
            if solution.status != 1:
                break
            event = _what_ended(solution, events)
            if event == CLOSING and not model.phase.touching:
                peaks.count += 1
                peaks.first = sample * dt + time if peaks.count == 1 else peaks.first
            model.phase = model.after(event, y, time)
            if event == CLOSING:
                y[0] = y[1] + interface.gap  # the root search leaves rounding in δ
                peaks.look(model, y[np.newaxis])
        model.phase = model.phase._replace(since=model.phase.since - dt)
    return Answer(
        peaks.reach, peaks.closing, peaks.force, peaks.demand, float(peaks.count), peaks.first, float(peaks.steps)
    )
