"""The general way: SciPy's ``solve_ivp``, started anew at every record sample and every event, in plain Python.

The motion of all buildings is one system, a pair being a row with one contact point. Every contact point has events of
its own, of which the first ends a piece. They are found by SciPy's own root search: touch, separation, δ̇ = 0, the
uncapped force meeting the force at which the law yields, the force of a law that cannot pull meeting zero; so are the
local maxima of the relative displacement and of the force, which are read where they lie. Whatever the contact law, it
is called through its own methods.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from pounding_risk.lab.baselines.matrices import Array, RowMatrices

ABSOLUTE = 1e-14, 1e-13  # of displacements [m] and velocities [m/s]
SOLVERS = ("DOP853", "Radau")
SLACK, ELASTIC, YIELDING = -1, 0, 1  # force cut at zero, uncapped, on the plateau
CLOSING, TURN, YIELD, TENSION, MAXIMUM = range(5)  # kinds of event; the last one ends no piece
MOST_PIECES = 1000  # of one sample: a loose tolerance may find one event over and over
NUDGE = 1e-4  # of a contact's age: half the span of the difference that stands for dF/dt


class GaveUp(RuntimeError):
    """An integrator that stopped before the end of a run, with its own words."""


class Contacts(NamedTuple):
    """Gap [m], law, restitution and yield force [N] of every contact point."""

    gaps: Array
    laws: tuple[Any, ...]
    restitutions: tuple[Any, ...]
    yield_forces: Array


class Answer(NamedTuple):
    """One run by contact point: peaks and counts in SI units; ``steps`` are those with a contact closed."""

    peak_relative_displacement: Array
    peak_closing: Array
    peak_contact_force: Array
    uncapped_force: Array
    impact_count: Array
    first_impact_time: Array
    steps: float


class ScipyContact:
    """One contact point: the branch of its law that holds, what this contact remembers, and its largest values."""

    def __init__(self, row: RowMatrices, contacts: Contacts, k: int) -> None:
        self.share, count = row.shares[k], row.mass.size
        self.across = np.append(self.share, np.zeros(count))  # of the state: displacement across the point
        # Place and weight in the state of the few masses that the point touches, and what 1 N does to their rates:
        # as plain numbers, for these are taken at every call of SciPy's.
        masses = [(int(at), float(self.share[at])) for at in np.flatnonzero(self.share)]
        self.moves, self.runs = masses, [(count + at, weight) for at, weight in masses]
        self.pushes = [(count + at, weight / float(row.mass[at])) for at, weight in masses]
        self.gap, self.law, self.restitution = float(contacts.gaps[k]), contacts.laws[k], contacts.restitutions[k]
        self.mass = float(row.striking[k])
        self.strength, self.least = self.law.ceiling(contacts.yield_forces[k]), self.law.floor()
        self.part()
        self.reach = self.closing = self.peak = self.demand = self.count = 0.0
        self.first = nan

    def part(self) -> None:
        """Open the contact: no touch, on the elastic branch, its memory empty."""
        self.touching, self.approaching, self.region, self.memory, self.since = False, True, ELASTIC, 0.0, 0.0

    def depth(self, y: Sequence[float]) -> float:
        """Penetration in state ``y`` [m]; below zero while it is open."""
        closing = 0.0
        for at, weight in self.moves:
            closing += weight * y[at]
        return closing - self.gap

    def speed(self, y: Sequence[float]) -> float:
        """Approach speed in state ``y`` [m/s]."""
        speed = 0.0
        for at, weight in self.runs:
            speed += weight * y[at]
        return speed

    def uncapped(self, y: Sequence[float]) -> float:
        """The law's force without cap or cut, on the present branch [N]."""
        return float(self.law.force(self.memory, max(self.depth(y), 0.0), self.speed(y), self.approaching))

    def force(self, y: Sequence[float]) -> float:
        """Force in state ``y`` on the present branch [N]; 0 while it is open."""
        if not self.touching or self.region == SLACK:
            return 0.0
        if self.region == YIELDING:
            return float(self.law.plateau(max(self.depth(y), 0.0), self.strength))
        return self.uncapped(y)

    def after(self, event: int, y: Sequence[float], time: float) -> None:
        """Change the branch after an event in state ``y`` at ``time`` [s] of the present sample."""
        if event == CLOSING and self.touching:
            self.part()
        elif event == CLOSING:
            speed = max(self.speed(y), 0.0)
            self.memory = self.law.begin(self.restitution.at(speed), speed, self.mass)
            self.touching, self.since = True, time
        elif event == TURN:
            self.approaching = not self.approaching
        else:
            far_region = YIELDING if event == YIELD else SLACK
            self.region = ELASTIC if self.region == far_region else far_region

    def update_peaks(self, states: Array) -> None:
        """Raise every peak to states, one a row, all on the present branch."""
        closing = states @ self.across
        self.reach = max(self.reach, float(np.abs(closing).max()))
        self.closing = max(self.closing, float(closing.max()))
        if self.touching:
            listed = states.tolist()
            self.peak = max(self.peak, *(self.force(state) for state in listed))
            self.demand = max(self.demand, *(self.uncapped(state) for state in listed))


class ScipyRow:
    """A row between events; state u, then v, of all masses."""

    def __init__(self, row: RowMatrices, contacts: Contacts) -> None:
        count = row.mass.size
        self.contacts = [ScipyContact(row, contacts, k) for k in range(len(contacts.laws))]
        stiffness, damping = (matrix / row.mass[:, None] for matrix in (row.stiffness, row.damping))
        self.linear = np.block([[np.zeros((count, count)), np.eye(count)], [-stiffness, -damping]])
        self.count = count
        self.ramp = (0.0, 0.0)  # a_g at t = 0 and its slope, over the present sample
        self.steps = 0

    def rates(self, t: float, y: Array) -> Array:
        """dy/dt of ``y`` = (u, v) of all masses: (v [m/s], v̇ [m/s²]) at ``t`` [s] of the present sample."""
        rates: Array = self.linear.dot(y)
        rates[self.count :] -= self.ramp[0] + self.ramp[1] * t
        for contact in self.contacts:
            if contact.touching:
                force = contact.force(y.tolist())
                for at, push in contact.pushes:
                    rates[at] -= force * push
        return rates

    def force_rate(self, contact: ScipyContact, t: float, y: Array) -> float:
        """dF/dt as a difference along the motion, times age^¾ that it may be finite at the touch, where it is 1."""
        age = t - contact.since
        if age <= 0.0:
            return 1.0
        shift = NUDGE * age * self.rates(t, y)
        change = contact.force((y + shift).tolist()) - contact.force((y - shift).tolist())
        return change / (2.0 * NUDGE * age**0.25)

    def value(self, contact: ScipyContact, kind: int, t: float, y: Array) -> float:
        """The function of an event, which happens where it passes zero."""
        if kind == MAXIMUM:
            return self.force_rate(contact, t, y)
        state = y.tolist()
        if kind == CLOSING:
            return contact.depth(state)
        if kind == TURN:
            return contact.speed(state)
        return contact.uncapped(state) - (contact.strength if kind == YIELD else 0.0)

    def events(self) -> list[tuple[ScipyContact, int, Any]]:
        """Contact, kind and function of the events that end this piece and of the local maxima that do not."""
        listed: list[tuple[ScipyContact, int, Any]] = []

        def add(contact: ScipyContact, kind: int, direction: float, terminal: bool = True) -> None:
            def event(t: float, y: Array) -> float:
                return self.value(contact, kind, t, y)

            event.direction, event.terminal = direction, terminal  # type: ignore[attr-defined]
            listed.append((contact, kind, event))

        for each in self.contacts:
            add(each, CLOSING, -1.0 if each.touching else 1.0)
            if not each.touching:
                add(each, TURN, 0.0, terminal=False)
                continue
            add(each, TURN, -1.0 if each.approaching else 1.0)
            if each.strength < inf:
                add(each, YIELD, -1.0 if each.region == YIELDING else 1.0)
            if each.least > -inf:
                add(each, TENSION, 1.0 if each.region == SLACK else -1.0)
            add(each, MAXIMUM, -1.0, terminal=False)
        return listed

    def piece(self, span: tuple[float, float], y: Array, options: dict[str, Any]) -> tuple[Array, float, bool]:
        """From a state to the first event, or to the end of the span: the state there, its time, whether it is the end.

        Raises GaveUp where SciPy does.
        """
        listed = self.events()
        functions = [function for *_, function in listed]
        solution: Any = solve_ivp(self.rates, span, y, events=functions, **options)
        if not solution.success:
            raise GaveUp(f"stopped at {float(solution.t[-1]):g} s of a sample: {solution.message}")
        states = np.vstack([solution.y.T, *(maxima for maxima in solution.y_events if len(maxima))])
        for each in self.contacts:
            each.update_peaks(states)
        self.steps += any(each.touching for each in self.contacts) * (len(solution.t) - 1)
        y, time = solution.y[:, -1].copy(), float(solution.t[-1])
        if solution.status != 1:
            return y, time, True
        # Of the events that can end a piece, the one found last.
        pairs = zip(solution.t_events, functions, strict=True)
        times = [crossings[-1] if len(crossings) and function.terminal else -1.0 for crossings, function in pairs]
        contact, event, _ = listed[int(np.argmax(times))]
        contact.after(event, y.tolist(), time)
        if event == CLOSING:
            # The root search leaves rounding in δ, which is taken out where the contact point acts.
            y[: contact.share.size] -= contact.share * contact.depth(y.tolist()) / float(contact.share @ contact.share)
            for each in self.contacts:
                each.update_peaks(y[np.newaxis])
        return y, time, False


def solve_general(solver: str, row: RowMatrices, contacts: Contacts, motion: tuple[Any, float], rtol: float) -> Answer:
    """One run from rest by a solver of `SOLVERS`; ``motion`` = (a_g [m/s²], time between samples [s]).

    Raises GaveUp where SciPy does, ValueError for a ground motion that is not finite.
    """
    ground, dt = np.asarray(motion[0], dtype=float), float(motion[1])
    if not np.isfinite(ground).all():
        # SciPy's step control would try again for ever.
        raise ValueError(f"sample {int(np.argmin(np.isfinite(ground)))} of the ground motion is not finite")
    model = ScipyRow(row, contacts)
    options: dict[str, Any] = {"method": solver, "rtol": rtol, "atol": np.repeat(ABSOLUTE, row.mass.size)}
    y = np.zeros(2 * row.mass.size)
    for sample in range(len(ground) - 1):
        model.ramp = (float(ground[sample]), float(ground[sample + 1] - ground[sample]) / dt)
        time, at_end, pieces = 0.0, False, 0
        while not at_end and time < dt * (1.0 - 1e-12):
            pieces += 1
            if pieces > MOST_PIECES:
                raise GaveUp(f"{solver} at rtol {rtol:g}, sample {sample}: finds the same event again at {time:g} s")
            open_ones = [each for each in model.contacts if not each.touching]
            try:
                y, time, at_end = model.piece((time, dt), y, options)
            except GaveUp as reason:
                raise GaveUp(f"{solver} at rtol {rtol:g}, sample {sample}: {reason}") from None
            for each in open_ones:
                if each.touching:
                    each.count += 1.0
                    each.first = sample * dt + time if each.count == 1.0 else each.first
        for each in model.contacts:
            each.since -= dt
    names = ("reach", "closing", "peak", "demand", "count", "first")
    of_points = (np.array([getattr(each, name) for each in model.contacts]) for name in names)
    return Answer._make([*of_points, float(model.steps)])
