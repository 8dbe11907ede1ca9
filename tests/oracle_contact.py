"""The reference integrator in contact: SciPy's DOP853, stopped at every record sample and every event."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from oracle_flight import root_between
from oracle_laws import Law, Phase, Scene, coefficients
from scipy.integrate import DOP853
from scipy.optimize import minimize_scalar

# state: depth, its rate, u_L, v_L, u_R, v_R, work of the contact force, its impulse
ABSOLUTE = np.array([1e-17, 1e-15, 1e-16, 1e-15, 1e-16, 1e-15, 1e-8, 1e-9])
MEASURES = ("force", "pull", "trial", "u_left", "u_right", "a_left", "a_right", "depth")
POINTS = np.linspace(0.0, 1.0, 9)
LANDS_ON = {"part": 0, "turn": 1}  # the entry of the state that is zero at an event


class Peaks(dict[str, float]):
    """The largest value so far of everything that has a peak."""

    def raise_to(self, name: str, value: float) -> None:
        if value > self.get(name, 0.0):
            self[name] = value


class Contact:
    """One contact from touch to separation; ``age`` is the time since the touch."""

    def __init__(self, scene: Scene, state: list[float], peaks: Peaks, rtol: float) -> None:
        self.scene, self.peaks, self.rtol, self.state, self.age = scene, peaks, rtol, state, 0.0
        self.speed = state[1]
        self.law, self.phase, self.fresh, self.parted = Law(scene, self.speed), Phase(), True, False
        self.yields: list[float] = []  # ages at which the trial force reached the yield force
        self.first_flags()
        peaks.raise_to("approach", self.speed)

    def first_flags(self) -> None:
        if self.law.trial(self.state[0], self.state[1], True) >= self.law.cap:  # a damper may yield at once
            self.phase.yielding = True
            self.yields.append(0.0)

    def advance(self, ground: tuple[float, float], duration: float) -> float:
        """Integrate under a_g = ground[0] + ground[1] t for a duration or to separation; the time it took."""
        start, end, stalled = self.age, self.age + duration, 0
        while not self.parted and self.age < end:
            before = self.age
            self.segment((ground[0] - ground[1] * start, ground[1]), end)
            stalled = stalled + 1 if self.age == before else 0
            if stalled > 8:
                raise RuntimeError(f"events without progress at age {self.age}, state {self.state}")
        return self.age - start if self.parted else duration

    def segment(self, ground: tuple[float, float], end: float) -> None:
        """From the current age to the next event or the end; ``ground`` is a_g against the age."""
        # δ^¼ is not smooth in time at the touch, but in s with age = s⁴ it is: used until δ̇ first vanishes.
        power = 4 if self.fresh else 1
        x, stop = self.age ** (1.0 / power), end ** (1.0 / power)
        rhs = self.equations(ground, power)
        if stop <= x:
            self.age = end
            return
        solver = DOP853(rhs, x, np.array(self.state), stop, rtol=self.rtol, atol=ABSOLUTE)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(f"{message} (age {self.age}, state {self.state})")
            if self.walk(solver, rhs, ground, power):
                return
        self.age, self.state = end, solver.y.tolist()

    def walk(self, solver: DOP853, rhs: Callable[..., list[float]], ground: tuple[float, float], power: int) -> bool:
        """Look for events and peaks inside the last step; whether an event ended the segment."""
        dense, old, new = solver.dense_output(), solver.t_old, solver.t
        xs = old + POINTS * (new - old)
        xs[-1] = new
        states = dense(xs).T.tolist()
        found = self.earliest_event(dense, xs, states)
        if found is not None:
            name, event = found
            # The interpolant is of lower order than the step: step to the event itself.
            first = event - old
            state = dense(old).tolist()
            if first > 0.0:
                short = DOP853(rhs, old, dense(old), event, rtol=self.rtol, atol=ABSOLUTE, first_step=first)
                while short.status == "running":
                    short.step()
                state = short.y.tolist()
            if name in LANDS_ON:
                state[LANDS_ON[name]] = 0.0
            xs = old + POINTS * first
            states = [*dense(xs[:-1]).T.tolist(), state]
        self.measure(dense, xs, states, ground, power)
        if found is None:
            return False
        self.age, self.state = event**power, states[-1]
        self.turn(name)
        return True

    def equations(self, ground: tuple[float, float], power: int) -> Callable[..., list[float]]:
        """dy/dx, x the age or its fourth root, in plain floats; the phase stays as it is now."""
        (kl, dl, il), (kr, dr, ir) = (coefficients(b) for b in (self.scene.left, self.scene.right))
        moves_l, moves_r = (float(b.period != 0.0) for b in (self.scene.left, self.scene.right))
        (g0, g1), force, phase = ground, self.law.force, self.phase

        def rhs(x: float, y: np.ndarray) -> list[float]:
            depth, speed, ul, vl, ur, vr, _, _ = y.tolist()
            age, scale = (x, 1.0) if power == 1 else (x**4, 4.0 * x**3)
            push = force(depth, speed, phase)
            pull_l, pull_r = -dl * vl - kl * ul - push * il, -dr * vr - kr * ur + push * ir
            ag = g0 + g1 * age
            closing = pull_l - pull_r - ag * (moves_l - moves_r)
            al, ar = pull_l - ag * moves_l, pull_r - ag * moves_r
            return [scale * d for d in (speed, closing, vl, al, vr, ar, push * speed, push)]

        return rhs

    # ---- events
    def watches(self) -> list[tuple[str, int, Callable[[list[float]], float]]]:
        """(name, direction, function of the state) of each event that can come next."""
        law, phase = self.law, self.phase

        def trial(y: list[float]) -> float:
            return law.trial(y[0], y[1], phase.approach)

        found = [
            ("part", -1, lambda y: y[0]),
            ("turn", -1 if phase.approach else 1, lambda y: y[1]),
        ]
        if law.cap < float("inf"):
            found.append(("yield", -1 if phase.yielding else 1, lambda y: trial(y) - law.cap))
        if law.name == "kelvin_voigt_tension_cut":
            found.append(("cut", 1 if phase.cut else -1, trial))
        return found

    def earliest_event(
        self, dense: Callable[..., np.ndarray], xs: np.ndarray, states: list[list[float]]
    ) -> tuple[str, float] | None:
        best: tuple[str, float] | None = None
        for name, direction, function in self.watches():
            values = [direction * function(y) for y in states]
            for i in range(len(values) - 1):
                if values[i] <= 0.0 < values[i + 1]:
                    x = root_between(lambda x, g=function: g(dense(x).tolist()), xs[i], xs[i + 1])  # type: ignore[misc]
                    if best is None or x < best[1]:
                        best = name, x
                    break
        return best

    def turn(self, name: str) -> None:
        if name == "part":
            self.parted = True
        elif name == "turn":
            self.phase.approach = not self.phase.approach
            self.fresh = False
        elif name == "cut":
            self.phase.cut = not self.phase.cut
        else:
            self.phase.yielding = not self.phase.yielding
            if self.phase.yielding:
                self.yields.append(self.age)

    # ---- peaks
    def measures(self, y: list[float], ag: float) -> tuple[float, ...]:
        """In the order of MEASURES; a rigid building's acceleration is the ground's."""
        depth, speed, ul, vl, ur, vr, _, _ = y
        push = self.law.force(depth, speed, self.phase)
        (kl, dl, il), (kr, dr, ir) = (coefficients(b) for b in (self.scene.left, self.scene.right))
        al, ar = -dl * vl - kl * ul - push * il, -dr * vr - kr * ur + push * ir
        trial = self.law.trial(depth, speed, self.phase.approach)
        return push, -push, trial, abs(ul), abs(ur), abs(al), abs(ar), depth

    def measure(
        self,
        dense: Callable[..., np.ndarray],
        xs: np.ndarray,
        states: list[list[float]],
        ground: tuple[float, float],
        power: int,
    ) -> None:
        """Peaks inside one step: nine points, ends included, and a search where a top shows between."""
        rows = [self.measures(y, 0.0) for y in states]
        for index, name in enumerate(MEASURES):
            values = [row[index] for row in rows]
            top = max(values)
            self.peaks.raise_to(name, top)
            if top < 0.0:
                continue
            for i, rise in near_tops(values):
                # The parabola says how far the top stands above the points; three times that is a safe guess.
                if top + 3.0 * rise <= self.peaks.get(name, 0.0):
                    continue
                lo, hi = xs[max(i - 1, 0)], xs[min(i + 1, len(xs) - 1)]
                if hi <= lo:
                    continue
                search = minimize_scalar(
                    lambda x, k=index: -self.measures(dense(x).tolist(), 0.0)[k],  # type: ignore[misc]
                    bounds=(lo, hi),
                    method="bounded",
                    options={"xatol": 1e-9 * (hi - lo)},
                )
                self.peaks.raise_to(name, -float(search.fun))


def near_tops(values: list[float]) -> list[tuple[int, float]]:
    """(index, rise above it) of each point beside a maximum: inner tops, and ends that turn inward."""
    tops = []
    for i in range(1, len(values) - 1):
        before, here, after = values[i - 1 : i + 2]
        if here >= max(before, after) and here > min(before, after):
            tops.append((i, (before - after) ** 2 / (8.0 * (2.0 * here - before - after))))
    for end, a, b in ((0, 1, 2), (len(values) - 1, len(values) - 2, len(values) - 3)):
        # The parabola through three points, at the end: its slope inwards and its bend, in steps of a point.
        slope, bend = (
            -1.5 * values[end] + 2.0 * values[a] - 0.5 * values[b],
            values[end] - 2.0 * values[a] + values[b],
        )
        if values[end] >= values[a] and slope > 0.0 > bend:
            tops.append((end, -(slope**2) / (2.0 * bend)))
    return tops
