"""Two buildings on two grounds by SciPy, in absolute displacements: shares no code with the solver.

    m_L Ẍ_L = −c_L (Ẋ_L − ẋ_L) − k_L (X_L − x_L) − F,   m_R Ẍ_R = −c_R (Ẋ_R − ẋ_R) − k_R (X_R − x_R) + F,
    δ = X_L − X_R − gap,   ẍ_L and ẍ_R given, linear between samples.

A rigid building is its ground. ``hertz`` is F = β δ^1.5; ``merged`` joins the buildings at a touch and parts them when
F would be tension. DOP853 at rtol 1e-12, interval by interval. Rows of chains have `oracle_grounds`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

PLACES = np.linspace(0.0, 1.0, 41)  # of an interval, where peaks are looked for
LEFT, RIGHT, GROUND_LEFT, GROUND_RIGHT, DAMPED, IMPULSE = 0, 2, 4, 6, 8, 9  # places of the state: X, Ẋ, ..., sums


class Side(NamedTuple):
    mass: float
    stiffness: float
    damping: float
    moves: bool


def side_of(mass: float, period: float, damping: float) -> Side:
    """A building of no period is rigid."""
    if period == 0.0:
        return Side(1.0, 0.0, 0.0, False)
    omega = 2.0 * np.pi / period
    return Side(mass, mass * omega**2, 2.0 * mass * damping * omega, True)


class Run:
    """One run, its state and its peaks."""

    def __init__(self, buildings, gap: float, law: str, beta: float):
        self.sides = [side_of(*numbers) for numbers in buildings]
        self.gap, self.law, self.beta = gap, law, beta
        self.joined, self.touches, self.y = False, 0, np.zeros(10)
        self.peaks = dict.fromkeys(("closing", "opening", "u_left", "u_right", "a_left", "a_right", "force"), 0.0)

    def pulls(self, y):
        """Spring and damper on each building, and what the dampers take."""
        found, power = [], 0.0
        for side, at, ground in zip(self.sides, (LEFT, RIGHT), (GROUND_LEFT, GROUND_RIGHT), strict=True):
            speed = y[at + 1] - y[ground + 1]
            found.append(-side.damping * speed - side.stiffness * (y[at] - y[ground]))
            power += side.damping * speed * speed
        return *found, power

    def force(self, y, grounds):
        """Contact force [N]."""
        one, other, _ = self.pulls(y)
        left, right = self.sides
        if self.law == "hertz":
            return self.beta * max(y[LEFT] - y[RIGHT] - self.gap, 0.0) ** 1.5
        if not self.joined:
            return 0.0
        if not right.moves:
            return one - left.mass * grounds[1]
        if not left.moves:
            return right.mass * grounds[0] - other
        return (one * right.mass - other * left.mass) / (left.mass + right.mass)

    def slopes(self, y, grounds):
        one, other, power = self.pulls(y)
        push = self.force(y, grounds)
        left, right = self.sides
        a = (one - push) / left.mass if left.moves else grounds[0]
        b = (other + push) / right.mass if right.moves else grounds[1]
        return [y[1], a, y[3], b, y[5], grounds[0], y[7], grounds[1], power, push]

    def interval(self, a, b, step: float):
        """From one sample to the next; a and b are (left, right) accelerations at both."""
        now = 0.0
        a, b = np.array(a), np.array(b)

        def grounds(t):
            return a + (b - a) * t / step

        while now < step * (1.0 - 1e-13):
            events = []
            if self.law == "merged":
                events = [lambda t, y: self.force(y, grounds(t)) if self.joined else y[LEFT] - y[RIGHT] - self.gap]
                events[0].terminal, events[0].direction = True, -1.0 if self.joined else 1.0
            found = solve_ivp(
                lambda t, y: self.slopes(y, grounds(t)),
                (now, step),
                self.y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-15,
                events=events or None,
                dense_output=True,
                first_step=(step - now) / 8,
            )
            now = found.t[-1]
            for place in PLACES * (now - found.t[0]) + found.t[0]:
                self.look(found.sol(place), grounds(place))
            self.y = found.y[:, -1]
            if found.status == 1:
                self.turn(grounds(now))

    def turn(self, grounds):
        """Switch the state at a touch or a separation."""
        if self.joined:
            self.joined = False
            return
        left, right = self.sides
        self.touches += 1
        speed = self.y[LEFT + 1] - self.y[RIGHT + 1]
        p = left.mass / (left.mass + right.mass) if left.moves and right.moves else float(not left.moves)
        common = p * self.y[LEFT + 1] + (1.0 - p) * self.y[RIGHT + 1]
        mass = left.mass * (1.0 - p) if left.moves else right.mass
        self.y[IMPULSE] += mass * speed
        self.y[LEFT + 1] = self.y[RIGHT + 1] = common
        self.joined = True
        self.joined = self.force(self.y, grounds) > 0.0

    def look(self, y, grounds):
        closing = y[LEFT] - y[RIGHT]
        slopes = self.slopes(y, grounds)
        values = {
            "closing": closing,
            "opening": -closing,
            "u_left": abs(y[LEFT] - y[GROUND_LEFT]),
            "u_right": abs(y[RIGHT] - y[GROUND_RIGHT]),
            "a_left": abs(slopes[1]),
            "a_right": abs(slopes[3]),
            "force": slopes[9],
        }
        for name, value in values.items():
            self.peaks[name] = max(self.peaks[name], float(value))


def follow(buildings, gap: float, law: str, beta: float, ground, step: float, lag: float) -> dict[str, float]:
    """Peaks, impulse and what the dampers took.

    ``buildings`` = (mass, period, damping ratio) of both; ``ground`` is a_g sampled every ``step``, zero at first, and
    one of them has it later by ``lag``: from sample to sample of both motions.
    """
    run = Run(buildings, gap, law, beta)
    samples = np.arange(len(ground)) * step
    times = np.unique(np.concatenate([samples, (samples + abs(lag))[samples + abs(lag) < samples[-1]]]))
    times = times[np.append(True, np.diff(times) > 1e-9)]
    prompt = np.interp(times, samples, ground)
    late = np.interp(times - abs(lag), samples, ground, left=0.0)
    both = np.column_stack([prompt, late] if lag >= 0.0 else [late, prompt])
    for (now, a), (then, b) in pairwise(zip(times, both, strict=True)):
        run.interval(a, b, then - now)
    sums = {"impulse": float(run.y[IMPULSE]), "damped": float(run.y[DAMPED]), "touches": float(run.touches)}
    return {**run.peaks, **sums}
