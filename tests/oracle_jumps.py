"""A reference for rows of single masses whose velocities jump: SciPy between jumps, every set of contacts at a jump.

Shares no code with the solver. Between jumps DOP853 at rtol 1e-12 is stopped at each sample of the record and at each
event; soon after a jump its steps are short, for SciPy does not see what touches and parts within one. The
complementarity problems of velocities and of accelerations are solved by trying all sets of contacts that may push: the
one whose answer keeps every sign is it.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

CLOSED, STILL = 1e-13, 1e-11  # m, what is closed, and m/s, what is no speed, but for the error of the integration


class Masses(NamedTuple):
    """Single masses in a row; an infinite mass is a wall."""

    mass: np.ndarray  # kg
    period: np.ndarray  # s
    damping: np.ndarray
    gaps: np.ndarray  # m
    e: np.ndarray  # by interface


class Answer(NamedTuple):
    """What a run has of each interface, and at its end."""

    touches: list[list[float]]  # s
    rests: list[list[float]]  # s, at which a rest has ended
    impulse: np.ndarray  # N s
    lost: np.ndarray  # J
    state: np.ndarray  # u, then v
    largest: np.ndarray  # of the distances u_left − u_right at all steps of SciPy [m]


def by_enumeration(matrix: np.ndarray, given: np.ndarray) -> np.ndarray:
    """x of w = given + matrix x ≥ 0, x ≥ 0, x·w = 0: of all sets of contacts the one that fits best."""
    best, answer = -np.inf, np.zeros(len(given))
    for kind in product((False, True), repeat=len(given)):
        pushes, x = np.array(kind, dtype=bool), np.zeros(len(given))
        if pushes.any():
            x[pushes] = np.linalg.solve(matrix[np.ix_(pushes, pushes)], -given[pushes])
        w = given + matrix @ x
        scale = np.abs(given).max(initial=1e-300)
        worst = min((np.diag(matrix) * x).min(initial=0.0), w[~pushes].min(initial=0.0)) / scale
        if worst > best:
            best, answer = worst, x
    assert best > -1e-9
    return answer


class Run:
    """One run from rest; ``slowest`` [m/s] by interface is the rebound below which pressed masses stay together."""

    def __init__(self, row: Masses, ground: np.ndarray, dt: float, slowest: np.ndarray) -> None:
        self.row, self.ground, self.dt, self.slowest = row, ground, dt, slowest
        count = len(row.mass)
        self.inverse = np.where(np.isinf(row.mass), 0.0, 1.0 / row.mass)
        self.omega = np.where(np.isinf(row.mass), 0.0, 2.0 * np.pi / row.period)
        self.between = np.eye(count - 1, count) - np.eye(count - 1, count, k=1)  # B: u_left − u_right
        self.compliance = self.between @ np.diag(self.inverse) @ self.between.T
        self.rests: set[int] = set()
        self.touched: list[list[float]] = [[] for _ in row.gaps]
        self.ended: list[list[float]] = [[] for _ in row.gaps]
        self.lost = np.zeros(count - 1)

    def alone(self, t: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        pull = np.interp(t, np.arange(len(self.ground)) * self.dt, self.ground)
        change = -pull - 2.0 * self.row.damping * self.omega * v - self.omega**2 * u
        return np.where(self.inverse > 0.0, change, 0.0)

    def forces(self, t: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Of the interfaces at rest, without a check of their sign."""
        force, held = np.zeros(len(self.lost)), sorted(self.rests)
        if held:
            pressed = (self.between @ self.alone(t, u, v))[held]
            force[held] = np.linalg.solve(self.compliance[np.ix_(held, held)], pressed)
        return force

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        count = len(self.inverse)
        u, v = y[:count], y[count : 2 * count]
        force = self.forces(t, u, v)
        return np.concatenate([v, self.alone(t, u, v) - self.inverse * (self.between.T @ force), force])

    def watched(self, i: int):
        count = len(self.inverse)

        def margin(t: float, y: np.ndarray) -> float:
            if i in self.rests:
                return -self.forces(t, y[:count], y[count : 2 * count])[i]
            return y[i] - y[i + 1] - self.row.gaps[i]

        margin.terminal, margin.direction = True, 1.0
        return margin

    def jump(self, t: float, y: np.ndarray, i: int) -> np.ndarray:
        """The event of interface ``i``: who rests afterwards, and the state then."""
        count = len(self.inverse)
        u, v = y[:count].copy(), y[count : 2 * count].copy()
        ended = {k for k in self.rests if k == i}
        open_by = self.row.gaps - self.between @ u
        closed = sorted(
            self.rests
            | {i}
            | {k for k in range(count - 1) if open_by[k] < CLOSED and self.inverse[k] + self.inverse[k + 1] > 0.0}
        )
        was = [k in self.rests for k in closed]
        before = np.where(was, 0.0, (self.between @ v)[closed])
        target = self.row.e[closed] * np.maximum(before, 0.0)
        matrix = self.compliance[np.ix_(closed, closed)]
        slow = target <= self.slowest[closed]
        while True:
            back = np.where(slow, 0.0, target)
            push = by_enumeration(matrix, -before - back)
            after = v - self.inverse * (self.between[closed].T @ push)
            apart = -(self.between @ after)[closed]
            still = [
                n
                for n, k in enumerate(closed)
                if slow[n] and k not in ended and abs(apart[n]) < STILL + 1e-10 * np.abs(v).max()
            ]
            pressed = (self.between @ self.alone(t, u, after))[closed][still]
            force = np.zeros(len(closed))
            force[still] = by_enumeration(matrix[np.ix_(still, still)], -pressed)
            wrong = slow & (target > 0.0) & (force <= 0.0)
            if not wrong.any():
                break
            slow &= ~wrong
        for n, k in enumerate(closed):
            if k in self.rests and force[n] <= 0.0:
                self.ended[k].append(t)
            elif k not in self.rests and (k == i or push[n] > 0.0):
                self.touched[k].append(t)
            self.lost[k] += 0.5 * push[n] * (before[n] - apart[n])
        self.rests = (self.rests - set(closed)) | {k for n, k in enumerate(closed) if force[n] > 0.0}
        for k in closed:
            if k not in self.rests:  # as far apart as touches are told by
                u[k] -= 1e-15 if self.inverse[k] > 0.0 else 0.0
                u[k + 1] += 1e-15 if self.inverse[k + 1] > 0.0 else 0.0
        impulse = y[2 * count :].copy()
        impulse[closed] += push
        return np.concatenate([u, after, impulse])

    def solve(self) -> Answer:
        count = len(self.inverse)
        t, y, largest = 0.0, np.zeros(3 * count - 1), np.full(count - 1, -np.inf)
        events = [self.watched(i) for i in range(count - 1)]
        jumped, kind = -np.inf, {"method": "DOP853", "rtol": 1e-12, "atol": 1e-16, "events": events}
        for node in range(1, len(self.ground)):
            while t < node * self.dt:
                soon = jumped + 2e-5
                longest = 1e-6 if t < soon else 1e-4 if t < jumped + 0.01 else 0.005
                end = min(node * self.dt, soon if t < soon else np.inf)
                part = solve_ivp(self.rates, (t, end), y, max_step=longest, **kind)
                t, y = part.t[-1], part.y[:, -1]
                largest = np.maximum(largest, (self.between @ part.y[:count]).max(axis=1))
                if part.status == 1:
                    jumped = t
                    y = self.jump(t, y, next(i for i, times in enumerate(part.t_events) if times.size))
        return Answer(self.touched, self.ended, y[2 * count :], self.lost, y[: 2 * count], largest)
