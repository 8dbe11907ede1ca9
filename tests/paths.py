"""A pair whose contact force follows a path, by SciPy: it stops at every turn and shares nothing with the solver."""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Path:
    """A force without a path; δ is from the gap as it was built, and `left` where bodies part."""

    left = 0.0

    def begin(self) -> None:
        """Of a contact."""

    def force(self, delta: float) -> float:
        """While bodies touch."""
        raise NotImplementedError

    def corner(self, delta: float) -> float:
        """Above zero where the force has another law."""
        return -1.0

    def turned(self, delta: float, inwards: bool) -> None:
        """Where the rate of δ changes its sign."""


class Followed(NamedTuple):
    """Largest |u| and force, and the number of contacts."""

    apart: float
    force: float
    touches: int


def follow_pair(left: Any, right: Any, gap: float, path: Path, ground: np.ndarray, dt: float) -> Followed:
    """Two damped buildings with the contact between them."""
    times = np.arange(len(ground)) * dt
    numbers = [(b.mass, b.stiffness, 2.0 * b.damping * sqrt(b.stiffness * b.mass)) for b in (left, right)]
    state, now, touching, way = np.zeros(4), 0.0, False, 1.0
    largest, force, touches = 0.0, 0.0, 0

    def pushed(y):
        return path.force(y[0] - y[1] - gap) if touching and y[0] - y[1] - gap > path.left else 0.0

    def slopes(t, y):
        a, push = float(np.interp(t, times, ground)), pushed(y)
        rates = [
            -a - (k * u + c * v + sign * push) / m
            for (m, k, c), u, v, sign in zip(numbers, y[:2], y[2:], (1.0, -1.0), strict=True)
        ]
        return [y[2], y[3], *rates]

    def gone(t, y):
        return y[0] - y[1] - gap - path.left

    def turns(t, y):
        return way * (y[2] - y[3])

    def bends(t, y):
        return path.corner(y[0] - y[1] - gap)

    gone.terminal = turns.terminal = bends.terminal = True
    turns.direction, bends.direction = -1.0, 1.0
    while now < times[-1]:
        gone.direction = -1.0 if touching else 1.0
        stop = times[np.searchsorted(times, now, side="right")]
        events = [gone, turns] if touching else [gone]
        if touching and bends(now, state) < -1e-9:
            events.append(bends)
        done = solve_ivp(
            slopes, (now, stop), state, "DOP853", rtol=1e-11, atol=1e-14, max_step=dt / 8, events=events,
            dense_output=True,
        )  # fmt: skip
        fine = done.sol(np.linspace(now, done.t[-1], 40))
        largest = max(largest, np.abs(fine[0] - fine[1]).max())
        force = max(force, max(map(pushed, fine.T)))
        now, state = done.t[-1], done.y[:, -1]
        if done.status != 1:
            continue
        if len(done.t_events[0]):
            touching, way = not touching, 1.0
            touches += touching
            path.begin()
        elif len(done.t_events[1]):
            path.turned(state[0] - state[1] - gap, way > 0.0)
            way = -way
    return Followed(largest, force, touches)
