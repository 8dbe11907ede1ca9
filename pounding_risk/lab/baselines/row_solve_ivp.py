"""The general way for a row: SciPy's ``solve_ivp``, as `solve_ivp` has it for a pair, with a list of contact points.

The motion of all buildings is one system; every contact point has events of its own, of which the first ends a piece.
"""

from __future__ import annotations

from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pounding_risk.lab.baselines.row import RowMatrices
from pounding_risk.lab.baselines.solve_ivp import (
    ABSOLUTE,
    ELASTIC,
    NUDGE,
    SLACK,
    YIELDING,
    GaveUp,
    Phase,
    _event,
    _what_ended,
)

Array = NDArray[np.float64]
CLOSING, TURN, YIELD, TENSION, CREST = range(5)  # what an event is


class RowContacts(NamedTuple):
    """Gap [m], law, restitution and yield force [N] of every contact point."""

    gaps: Array
    laws: tuple[Any, ...]
    restitutions: tuple[Any, ...]
    yield_forces: Array


class RowAnswer(NamedTuple):
    """One run by contact point: peaks and counts in SI units; ``steps`` are those with a contact closed."""

    peak_relative_displacement: Array
    peak_closing: Array
    peak_contact_force: Array
    uncapped_force: Array
    impact_count: Array
    first_impact_time: Array
    steps: float


class ScipyRow:
    """A row between events; state u, then v, of all masses."""

    def __init__(self, row: RowMatrices, contacts: RowContacts) -> None:
        self.row, self.contacts, self.count = row, contacts, row.mass.size
        self.strengths = [law.ceiling(f) for law, f in zip(contacts.laws, contacts.yield_forces, strict=True)]
        self.least = [law.floor() for law in contacts.laws]
        self.ramp = (0.0, 0.0)  # a_g at t = 0 and its slope, over the present sample
        self.phases = [Phase() for _ in contacts.laws]
        self.stiffness, self.damping = (matrix / row.mass[:, None] for matrix in (row.stiffness, row.damping))
        self.shares, self.pushes = row.shares, row.shares / row.mass
        points = len(contacts.laws)
        self.reach, self.closing, self.peak, self.demand = np.zeros((4, points))
        self.impacts, self.first, self.steps = np.zeros(points), np.full(points, nan), 0

    def depth(self, k: int, y: Array) -> float:
        """Penetration at contact point ``k`` in state ``y`` [m]; below zero while it is open."""
        return float(self.shares[k] @ y[: self.count]) - float(self.contacts.gaps[k])

    def rate(self, k: int, y: Array) -> float:
        """Closing speed of contact point ``k`` in state ``y``, the rate of its penetration [m/s]."""
        return float(self.shares[k] @ y[self.count :])

    def uncapped(self, k: int, y: Array) -> float:
        """The law's force without cap or cut, on the present branch [N]."""
        phase = self.phases[k]
        depth = max(self.depth(k, y), 0.0)
        return float(self.contacts.laws[k].force(phase.memory, depth, self.rate(k, y), phase.approaching))

    def force(self, k: int, y: Array) -> float:
        """Force that contact point ``k`` transmits in state ``y``, on its present branch [N]; 0 while it is open."""
        phase = self.phases[k]
        if not phase.touching or phase.region == SLACK:
            return 0.0
        if phase.region == YIELDING:
            return float(self.contacts.laws[k].plateau(max(self.depth(k, y), 0.0), self.strengths[k]))
        return self.uncapped(k, y)

    def rates(self, t: float, y: Array) -> Array:
        """dy/dt of ``y`` = (u, v) of all masses: (v [m/s], v̇ [m/s²]) at ``t`` [s] of the present sample."""
        u, v = y[: self.count], y[self.count :]
        pull = -self.stiffness @ u - self.damping @ v - (self.ramp[0] + self.ramp[1] * t)
        for k, phase in enumerate(self.phases):
            if phase.touching:
                pull -= self.pushes[k] * self.force(k, y)
        return np.concatenate([v, pull])

    def force_rate(self, k: int, t: float, y: Array) -> float:
        """dF/dt as a difference along the motion, times age^¾ that it may be finite at the touch, where it is 1."""
        age = t - self.phases[k].since
        if age <= 0.0:
            return 1.0
        shift = NUDGE * age * self.rates(t, y)
        return (self.force(k, y + shift) - self.force(k, y - shift)) / (2.0 * NUDGE * age**0.25)

    def events(self) -> list[tuple[int, int, Any]]:
        """(contact point, what it is, function) of the events that end this piece and of the crests that do not."""
        listed = []
        for k, phase in enumerate(self.phases):
            turn = -1.0 if phase.approaching else 1.0
            listed.append((k, CLOSING, _event(_of(self.depth, k), -1.0 if phase.touching else 1.0, True)))
            listed.append((k, TURN, _event(_of(self.rate, k), turn if phase.touching else 0.0, phase.touching)))
            if not phase.touching:
                continue
            if self.strengths[k] < inf:
                falls = -1.0 if phase.region == YIELDING else 1.0
                listed.append((k, YIELD, _event(_of(self.uncapped, k, self.strengths[k]), falls, True)))
            if self.least[k] > -inf:
                rises = 1.0 if phase.region == SLACK else -1.0
                listed.append((k, TENSION, _event(_of(self.uncapped, k), rises, True)))
            listed.append((k, CREST, _event(_crest(self.force_rate, k), -1.0, False)))
        return listed

    def happens(self, k: int, event: int, y: Array, time: float) -> None:
        """Change the branch of contact point ``k`` after an event."""
        phase = self.phases[k]
        if event == CLOSING and phase.touching:
            self.phases[k] = Phase()
        elif event == CLOSING:
            speed = max(self.rate(k, y), 0.0)
            memory = self.contacts.laws[k].begin(
                self.contacts.restitutions[k].at(speed), speed, float(self.row.striking[k])
            )
            self.phases[k] = Phase(True, True, ELASTIC, memory, time)
        elif event == TURN:
            self.phases[k] = phase._replace(approaching=not phase.approaching)
        else:
            far_region = YIELDING if event == YIELD else SLACK
            self.phases[k] = phase._replace(region=ELASTIC if phase.region == far_region else far_region)

    def look(self, states: Array) -> None:
        """Raise every peak to the states given, one a row, all on the present branches."""
        closing = states[:, : self.count] @ self.shares.T
        self.reach = np.maximum(self.reach, np.abs(closing).max(axis=0))
        self.closing = np.maximum(self.closing, closing.max(axis=0))
        for k, phase in enumerate(self.phases):
            if phase.touching:
                self.peak[k] = max(self.peak[k], *(self.force(k, state) for state in states))
                self.demand[k] = max(self.demand[k], *(self.uncapped(k, state) for state in states))

    def piece(self, span: tuple[float, float], y: Array, options: dict[str, Any]) -> tuple[Array, float, bool]:
        """From a state to the first event, or to the end of the span: the state there, its time and if it is the end.

        Raises GaveUp where SciPy does.
        """
        listed = self.events()
        functions = [function for *_, function in listed]
        solution: Any = solve_ivp(self.rates, span, y, events=functions, **options)
        if not solution.success:
            raise GaveUp(f"stopped at {float(solution.t[-1]):g} s of a sample: {solution.message}")
        self.look(np.vstack([solution.y.T, *(crests for crests in solution.y_events if len(crests))]))
        self.steps += any(phase.touching for phase in self.phases) * (len(solution.t) - 1)
        y, time = solution.y[:, -1].copy(), float(solution.t[-1])
        if solution.status != 1:
            return y, time, True
        k, event, _ = listed[_what_ended(solution, functions)]
        self.happens(k, event, y, time)
        if event == CLOSING:
            # The root search leaves rounding in δ, which is taken out where the contact point acts.
            share = self.shares[k]
            y[: self.count] -= share * self.depth(k, y) / float(share @ share)
            self.look(y[np.newaxis])
        return y, time, False


def _of(function: Any, k: int, less: float = 0.0) -> Any:
    return lambda t, y: function(k, y) - less


def _crest(function: Any, k: int) -> Any:
    return lambda t, y: function(k, t, y)


def solve_general_row(
    solver: str, row: RowMatrices, contacts: RowContacts, motion: tuple[Any, float], rtol: float
) -> RowAnswer:
    """One run from rest by a solver of `solve_ivp.SOLVERS`; ``motion`` = (a_g [m/s²], time between samples [s]).

    Raises GaveUp where SciPy does, ValueError for a ground motion that is not finite.
    """
    ground, dt = np.asarray(motion[0], dtype=float), float(motion[1])
    if not np.isfinite(ground).all():
        raise ValueError(f"sample {int(np.argmin(np.isfinite(ground)))} of the ground motion is not finite")
    model = ScipyRow(row, contacts)
    absolute = np.repeat([ABSOLUTE[0], ABSOLUTE[-1]], row.mass.size)
    options: dict[str, Any] = {"method": solver, "rtol": rtol, "atol": absolute}
    y = np.zeros(2 * row.mass.size)
    for sample in range(len(ground) - 1):
        model.ramp = (float(ground[sample]), float(ground[sample + 1] - ground[sample]) / dt)
        time, at_end = 0.0, False
        while not at_end and time < dt * (1.0 - 1e-12):
            closed = [phase.touching for phase in model.phases]
            try:
                y, time, at_end = model.piece((time, dt), y, options)
            except GaveUp as reason:
                raise GaveUp(f"{solver} at rtol {rtol:g}, sample {sample}: {reason}") from None
            for k, phase in enumerate(model.phases):
                if phase.touching and not closed[k]:
                    model.impacts[k] += 1.0
                    model.first[k] = sample * dt + time if model.impacts[k] == 1.0 else model.first[k]
        model.phases = [phase._replace(since=phase.since - dt) for phase in model.phases]
    return RowAnswer(model.reach, model.closing, model.peak, model.demand, model.impacts, model.first, model.steps)
