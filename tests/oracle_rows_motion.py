"""The reference integrator of rows: the motion between two events, where events are, and peaks inside steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from oracle_contact import near_tops
from oracle_flight import CONFIRMED
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq, minimize_scalar

PLACES = np.linspace(0.0, 1.0, 9)  # of a step, where events and peaks are looked for
CREEPING = 1e-7  # m/s: below this a contact starts where the depth is CONFIRMED, its touch time being noise
ABSOLUTE = 1e-16, 1e-15, 1e-8, 1e-9, 1e-8  # m, m/s; work, impulse, energies
Dense = Callable[[Any], np.ndarray]


def crossing(level: Callable[[float], float], lo: float, hi: float) -> float:
    """Where a function rises past zero; an end of it where rounding hides the sign there."""
    if level(lo) > 0.0:
        return lo
    return hi if level(hi) <= 0.0 else float(brentq(level, lo, hi, xtol=1e-18))


class Motion:
    """State: u and v of every dof, work and impulse of every contact, energy put in and damped."""

    contacts: list[Any]
    loose: np.ndarray
    slip: np.ndarray
    side: np.ndarray
    limit: np.ndarray

    def __init__(
        self, mass: np.ndarray, damping: np.ndarray, drift: np.ndarray, b: np.ndarray, gaps: np.ndarray, rtol: float
    ) -> None:
        self.mass, self.damping, self.drift, self.b, self.gaps, self.rtol = mass, damping, drift, b, gaps, rtol
        self.count, self.points = mass.size, len(gaps)
        self.inverse_mass = 1.0 / mass
        self.pushes = self.inverse_mass * b  # what a unit of contact force slows down, by point
        self.state = np.zeros(2 * self.count + 2 * self.points + 2)
        sizes = (self.count, self.count, self.points, self.points, 2)
        self.absolute = np.repeat(ABSOLUTE, sizes)
        self.now = self.clock = self.step = 0.0  # clock: since the newest touch
        self.stalled = 0  # events in a row that took no time
        # u, drift, shear, acceleration of every dof; closing, force and uncapped force of every contact.
        signals = 4 * self.count + 3 * self.points
        self.high, self.low = np.zeros(signals), np.zeros(signals)

    @property
    def u(self) -> np.ndarray:
        return self.state[: self.count]

    @property
    def v(self) -> np.ndarray:
        return self.state[self.count : 2 * self.count]

    def depths(self, u: np.ndarray) -> np.ndarray:
        """Penetrations δ of all contact points [m]."""
        return self.b @ u - self.gaps

    def make_maps(self, tangent: np.ndarray, offset: np.ndarray, gravity: np.ndarray) -> None:
        """Acceleration and signals as linear functions of the state, for storeys with V = tangent d + offset."""
        n = self.count
        stiffness = self.drift.T @ (tangent[:, None] * self.drift)
        self.slopes = -self.inverse_mass[:, None] * np.hstack([stiffness, self.damping])
        self.pull = -self.inverse_mass * (self.drift.T @ offset)
        still = np.zeros((n, n))
        seen = self.b.shape[0]
        self.readings = np.vstack([
            np.eye(n, 2 * n), np.hstack([self.drift, still]),
            np.hstack([(tangent + gravity)[:, None] * self.drift, still]), self.slopes,
            np.hstack([self.b, np.zeros((seen, n))]),
        ])  # fmt: skip
        self.readings_offset = np.concatenate([np.zeros(2 * n), offset, self.pull, np.zeros(seen)])

    # ---- one piece of the motion
    def piece(self, ground: tuple[float, float], duration: float) -> float:
        """Move on under a_g = ground[0] + ground[1] t for a duration or to the next event; the time it took."""
        # δ^¼ is not smooth in time at a touch, but in s with age = s⁴ it is: used until δ̇ first vanishes.
        power = 4 if any(c is not None and c.fresh for c in self.contacts) else 1
        begun = self.clock if power == 4 else 0.0
        start, stop = begun ** (1.0 / power), (begun + duration) ** (1.0 / power)
        if stop <= start:
            return self.pass_time(duration)
        rhs = self.equations((ground[0] - ground[1] * begun, ground[1]), power)
        more = {"first_step": min(self.step, stop - start)} if power == 1 and self.step > 0.0 else {}
        solver = self.solver(rhs, start, self.state, stop, **more)
        watches, levels = self.watched()
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(f"{message} (at {self.now} s)")
            found = self.walk(solver, rhs, watches, levels)
            if found:
                elapsed = self.pass_time(max(found[0] ** power - begun, 0.0))
                self.stalled = self.stalled + 1 if elapsed == 0.0 else 0
                for event in found[1]:
                    self.happens(*event)
                self.step = 0.0
                return elapsed
            if power == 1 and solver.t < stop:
                self.step = solver.step_size
        self.state = solver.y
        return self.pass_time(duration)

    def solver(
        self, rhs: Callable[..., np.ndarray], start: float, state: np.ndarray, stop: float, **more: Any
    ) -> DOP853 | Radau:
        """SciPy integrator of one piece of the motion."""
        return DOP853(rhs, start, state, stop, rtol=self.rtol, atol=self.absolute, **more)

    def pass_time(self, duration: float) -> float:
        self.clock += duration
        self.now += duration
        for contact in self.contacts:
            if contact is not None:
                contact.age += duration
        return duration

    def happens(self, name: str, index: int) -> None:
        raise NotImplementedError

    def equations(self, ground: tuple[float, float], power: int) -> Callable[..., np.ndarray]:
        """d(state)/dx, x the clock or its fourth root; every branch stays as it is now."""
        n, points = self.count, self.points
        closed = [(k, c.law.force, c.phase) for k, c in enumerate(self.contacts) if c is not None]
        rows = [k for k, *_ in closed]
        b, gaps, pushes = self.b[rows], self.gaps[rows], self.pushes[rows]
        slopes, pull, damping, mass = self.slopes, self.pull, self.damping, self.mass

        def rhs(x: float, y: np.ndarray) -> np.ndarray:
            time, scale = (x, 1.0) if power == 1 else (x**4, 4.0 * x**3)
            a_g = ground[0] + ground[1] * time
            v, out = y[n : 2 * n], np.zeros(y.size)
            out[:n] = v
            rates = slopes @ y[: 2 * n] + pull - a_g
            if closed:
                depth, speed = b @ y[:n] - gaps, b @ v
                for i, (k, force, phase) in enumerate(closed):
                    push = force(float(depth[i]), float(speed[i]), phase)
                    rates -= push * pushes[i]
                    out[2 * n + k], out[2 * n + points + k] = push * speed[i], push
            out[n : 2 * n] = rates
            out[-2], out[-1] = -a_g * (mass @ v), v @ damping @ v
            return scale * out

        return rhs

    # ---- events
    def watched(self) -> tuple[list[tuple[str, int]], Callable[[np.ndarray], np.ndarray]]:
        """Events that can come next, and a function of states, one a column: an event is where its row rises past 0."""
        n = self.count
        rows: list[np.ndarray] = []
        names: list[tuple[str, int]] = []
        shifts: list[float] = []
        branches: list[tuple[int, float, float, Any]] = []

        def add(name: str, index: int, sign: float, of_u: np.ndarray, of_v: np.ndarray, shift: float) -> None:
            names.append((name, index))
            rows.append(sign * np.concatenate([of_u, of_v]))
            shifts.append(shift)

        none = np.zeros(n)
        for k, contact in enumerate(self.contacts):
            if contact is None:
                add("touch", k, 1.0, self.b[k], none, -self.gaps[k] - CONFIRMED)
                continue
            add("part", k, -1.0, self.b[k], none, self.gaps[k] - 0.25 * CONFIRMED)  # a touch's δ is zero to rounding
            add("turn", k, -1.0 if contact.phase.approach else 1.0, none, self.b[k], 0.0)
            if contact.law.cap < float("inf"):
                branches.append((k, -1.0 if contact.phase.yielding else 1.0, contact.law.cap, "yield"))
            if contact.law.name == "kelvin_voigt_tension_cut":
                branches.append((k, 1.0 if contact.phase.cut else -1.0, 0.0, "cut"))
        for i in np.flatnonzero(np.isfinite(self.limit)):
            if self.side[i] != 0.0:
                add("storey", i, -self.side[i], none, self.drift[i], 0.0)
            for sign in (1.0, -1.0) if self.side[i] == 0.0 else ():
                add("storey", i, sign * self.loose[i], self.drift[i], none,
                    -sign * self.loose[i] * self.slip[i] - self.limit[i])  # fmt: skip
        names += [(name, k) for k, _, _, name in branches]
        matrix, shift = np.array(rows).reshape(len(rows), 2 * n), np.array(shifts)[:, None]

        def levels(states: np.ndarray) -> np.ndarray:
            linear = matrix @ states[: 2 * n] + shift
            more = [sign * (self.forces(k, states, True) - cap) for k, sign, cap, _ in branches]
            return np.vstack([linear, *more]) if more else linear

        return names, levels

    def forces(self, k: int, states: np.ndarray, uncapped: bool) -> np.ndarray:
        """The force of a closed contact in states, one a column; with or without its cap and cut."""
        n, contact = self.count, self.contacts[k]
        depths, speeds = self.b[k] @ states[:n] - self.gaps[k], self.b[k] @ states[n : 2 * n]
        law, phase = contact.law, contact.phase
        if uncapped:
            return np.array([law.trial(d, s, phase.approach) for d, s in zip(depths, speeds, strict=True)])
        return np.array([law.force(d, s, phase) for d, s in zip(depths, speeds, strict=True)])

    def walk(
        self, solver: DOP853 | Radau, rhs: Callable[..., np.ndarray], watches: list[tuple[str, int]], levels: Dense
    ) -> tuple[float, list[tuple[str, int]]] | None:
        """Peaks inside the last step; (where, which) of the events that end it, with the state there, or None."""
        dense, old, new = solver.dense_output(), solver.t_old, solver.t
        xs = old + PLACES * (new - old)
        xs[-1] = new
        states = dense(xs)
        states[:, -1] = solver.y
        values = levels(states)
        missed = (values[:, 0] > 0.0) & (values[:, 1] > values[:, 0])
        if missed.any() and self.stalled < 8:
            # The event before this piece has put another past its zero by a rounding.
            self.state = states[:, 0]
            return old, [watches[row] for row in np.flatnonzero(missed)]
        crossings = (values[:, :-1] <= 0.0) & (values[:, 1:] > 0.0)
        if not crossings.any():
            self.measure(dense, xs, states)
            return None
        place = int(np.flatnonzero(crossings.any(axis=0))[0])
        best, which = new, -1
        for row in np.flatnonzero(crossings[:, place]):
            x = crossing(lambda x, r=row: levels(dense(np.array([x])))[r, 0], xs[place], xs[place + 1])
            if which < 0 or x < best:
                best, which = x, int(row)
        event, state = self.land(rhs, dense, (old, best), watches[which], lambda y: levels(y[:, None])[which, 0])
        xs = old + PLACES * (event - old)
        states = np.column_stack([dense(xs[:-1]), state])
        self.measure(dense, xs, states)
        self.state = state
        after = levels(state[:, None])[:, 0]
        # Of two events at one instant rounding may put the other a little before this one.
        others = (values[:, 0] <= 0.0) & (after > 0.0)
        others[which] = True
        return event, [watches[row] for row in np.flatnonzero(others)]

    def land(
        self, rhs: Callable[..., np.ndarray], dense: Dense, span: tuple[float, float], name: tuple[str, int],
        level: Callable[[np.ndarray], float],
    ) -> tuple[float, np.ndarray]:  # fmt: skip
        """Step to the event itself, the interpolant being of lower order than the step; (where, state there)."""
        old, event = span
        begun = dense(old)
        if name[0] == "touch" and self.b[name[1]] @ dense(event)[self.count : 2 * self.count] >= CREEPING:
            confirmed = level

            def level(y: np.ndarray) -> float:
                return confirmed(y) + CONFIRMED

        state = begun
        for _ in range(3):
            if event <= old:
                return old, begun
            short = self.solver(rhs, old, begun, event, first_step=event - old)
            while short.status == "running":
                short.step()
            state = short.y
            nudge = 1e-6 * (event - old)
            slope = (level(dense(event)) - level(dense(event - nudge))) / nudge
            change = level(state) / slope if slope > 0.0 else 0.0
            if abs(change) <= 1e-15 * abs(event):
                break
            event -= change
        return event, state

    # ---- peaks
    def signals(self, states: np.ndarray) -> np.ndarray:
        """Every reading in states, one a column."""
        n, size = self.count, states.shape[1]
        linear = self.readings @ states[: 2 * n] + self.readings_offset[:, None]
        forces = np.zeros((2 * self.points, size))
        for k, contact in enumerate(self.contacts):
            if contact is not None:
                forces[k] = self.forces(k, states, False)
                forces[self.points + k] = self.forces(k, states, True)
                linear[3 * n : 4 * n] -= np.outer(self.pushes[k], forces[k])
        return np.vstack([linear, forces])

    def measure(self, dense: Dense, xs: np.ndarray, states: np.ndarray) -> None:
        """Peaks inside a step: nine points, ends included, and a search where a top shows between."""
        values = self.signals(states)
        bends = 3.0 / 8.0 * np.abs(np.diff(values, 2, axis=1)).max(axis=1)  # three times what a crest can rise
        for sign, best in ((1.0, self.high), (-1.0, self.low)):
            tops = (sign * values).max(axis=1)
            looks = np.flatnonzero((tops + bends > best) & (bends > 1e-13 * best))
            np.maximum(best, tops, out=best)
            for row in looks:
                self.search(row, sign, best, dense, (xs, sign * values[row]))

    def search(
        self, row: int, sign: float, best: np.ndarray, dense: Dense, points: tuple[np.ndarray, np.ndarray]
    ) -> None:
        """Raise a peak to the crests between the points of a step."""
        xs, values = points
        for i, rise in near_tops(values.tolist()):
            lo, hi = xs[max(i - 1, 0)], xs[min(i + 1, len(xs) - 1)]
            if values[i] + 3.0 * rise <= best[row] or hi <= lo:
                continue
            found = minimize_scalar(
                lambda x: -sign * self.signals(dense(np.array([x])))[row, 0],
                bounds=(lo, hi),
                method="bounded",
                options={"xatol": 1e-7 * (hi - lo)},
            )
            best[row] = max(best[row], -float(found.fun))

    def floor_peaks(self) -> np.ndarray:
        """Peaks of displacement, drift, shear and acceleration, shape (degrees of freedom, 4)."""
        n = self.count
        return np.maximum(self.high, self.low)[: 4 * n].reshape(4, n).T.copy()

    def contact_peaks(self) -> dict[str, np.ndarray]:
        """By point: how far it closes and opens, how deep, how hard."""
        n, k = self.count, self.points
        high, low = self.high[4 * n :].reshape(3, k), self.low[4 * n :].reshape(3, k)
        return {
            "peak_closing": high[0],
            "peak_opening": low[0],
            "peak_penetration": np.maximum(high[0] - self.gaps, 0.0),
            "peak_contact_force": high[1],
            "lowest_contact_force": 0.0 - low[1],
            "uncapped_force": high[2],
        }

    def quadratures(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Work and impulse of the contacts; energy put in and damped."""
        rest = self.state[2 * self.count :]
        return rest[: self.points], rest[self.points : 2 * self.points], rest[-2:]
