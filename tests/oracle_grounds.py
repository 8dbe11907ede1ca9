"""Buildings on grounds of their own by SciPy, in absolute displacements: shares no code with the solver.

    M Ẍ = −C (Ẋ − 1 ẋ_g) − K (X − 1 x_g) + Bᵀ F,   F = β max(B X − gap, 0)^p,   x_g of each building by its own ẍ_g,

linear between samples. The state holds X of all masses and x_g of all buildings, their velocities, the impulse of each
contact, and what the dampers took; DOP853 at rtol 1e-13 runs from sample to sample of all motions and stops where a
contact point opens or closes. A rigid building has no mass of its own: what is struck is its ground. A touch that joins
makes both sides move alike, with their momentum kept, until its force would pull; it may be the only contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Body(NamedTuple):
    """A building: masses from the ground up on springs with a damping matrix, none of a wall; and its ground."""

    masses: tuple[float, ...]  # kg
    springs: tuple[float, ...]  # N/m, below each mass
    damping: np.ndarray  # N s/m
    ground: np.ndarray  # samples of a_g [m/s²], factor and all
    delay: float = 0.0  # s
    velocity: float = 0.0  # of the ground at t = 0 [m/s]
    u: tuple[float, ...] = ()  # of each mass at t = 0, relative to the ground [m]
    v: tuple[float, ...] = ()  # m/s


class Touch(NamedTuple):
    """A contact between floor ``left`` of a building and floor ``right`` of the next one; 0 is its ground.

    Floors count from 1, and 2.3 is a column 0.3 of the way from the second floor to the third.
    """

    building: int
    left: float
    right: float
    gap: float  # m
    beta: float  # N/m^p
    power: float
    joins: bool = False


class Grounds:
    """The equations of motion."""

    def __init__(self, bodies: list[Body], touches: list[Touch]):
        self.bodies, self.touches = bodies, touches
        counts = [len(body.masses) for body in bodies]
        self.count, buildings = sum(counts), len(bodies)
        firsts = np.concatenate([[0], np.cumsum(counts)])
        self.mass = np.concatenate([np.array(body.masses, dtype=float) for body in bodies])
        self.stiffness, self.damping = np.zeros((self.count, self.count)), np.zeros((self.count, self.count))
        self.stands = np.zeros((self.count, buildings))  # which ground a mass stands on
        self.drifts = np.zeros((self.count, self.count + buildings))  # over masses and grounds
        for b, body in enumerate(bodies):
            here = slice(firsts[b], firsts[b + 1])
            self.stands[here, b] = 1.0
            if not counts[b]:
                continue
            drift = np.eye(counts[b]) - np.eye(counts[b], k=-1)
            self.drifts[here, here], self.drifts[firsts[b], self.count + b] = drift, -1.0
            self.stiffness[here, here] = drift.T @ np.diag(body.springs) @ drift
            self.damping[here, here] = body.damping
        self.across = np.zeros((len(touches), self.count + buildings))  # B, over masses and grounds
        for k, touch in enumerate(touches):
            for b, floor, sign in ((touch.building, touch.left, 1.0), (touch.building + 1, touch.right, -1.0)):
                below, share = int(floor), floor % 1.0
                self.across[k, firsts[b] + below - 1 if below else self.count + b] += sign * (1.0 - share)
                if share:
                    self.across[k, firsts[b] + below] += sign * share
        self.gaps = np.array([touch.gap for touch in touches])
        self.beta = np.array([touch.beta for touch in touches])
        self.power = np.array([touch.power for touch in touches])
        self.joins = np.array([touch.joins for touch in touches])
        self.compliance = (self.across[:, : self.count] ** 2 / self.mass).sum(axis=1)
        self.joined, self.joints = np.zeros(len(touches), dtype=bool), 0
        self.peaks: dict[str, Any] = {}

    def start(self) -> np.ndarray:
        """X, x_g, Ẋ, ẋ_g, impulses and energy at t = 0."""
        rates = np.array([body.velocity for body in self.bodies])
        u, v = (
            np.concatenate([getattr(body, name) or np.zeros(len(body.masses)) for body in self.bodies]) for name in "uv"
        )
        return np.concatenate([u, np.zeros(len(rates)), v + self.stands @ rates, rates, np.zeros(len(self.gaps) + 1)])

    def forces(self, places: np.ndarray, alone: np.ndarray) -> np.ndarray:
        """Contact forces [N]: of springs, or what keeps together what would accelerate by ``alone`` without."""
        springs = self.beta * np.maximum(self.across @ places - self.gaps, 0.0) ** self.power
        return np.where(self.joins, np.where(self.joined, self.across @ alone / self.compliance, 0.0), springs)

    def slopes(self, y: np.ndarray, pulls: np.ndarray) -> np.ndarray:
        """dy/dt where the grounds accelerate by ``pulls``."""
        n, half = self.count, self.count + len(self.bodies)
        places, rates = y[:half], y[half : 2 * half]
        loose, creep = places[:n] - self.stands @ places[n:], rates[:n] - self.stands @ rates[n:]
        alone = (-self.stiffness @ loose - self.damping @ creep) / self.mass
        forces = self.forces(places, np.concatenate([alone, pulls]))
        change = alone - self.across[:, :n].T @ forces / self.mass
        return np.concatenate([rates, change, pulls, forces, [creep @ self.damping @ creep]])

    def turn(self, y: np.ndarray, pulls: np.ndarray, k: int) -> np.ndarray:
        """The state after a touch that joins, or a parting."""
        half = self.count + len(self.bodies)
        if self.joined[k]:
            self.joined[k] = False
            return y
        push, y = self.across[k] @ y[half : 2 * half] / self.compliance[k], y.copy()
        y[half : half + self.count] -= self.across[k, : self.count] * push / self.mass
        y[2 * half + k] += push
        self.joints, self.joined[k] = self.joints + 1, True
        self.joined[k] = self.slopes(y, pulls)[2 * half + k] > 0.0
        return y

    def look(self, y: np.ndarray, pulls: np.ndarray) -> None:
        """Raise the peaks of closings, openings and forces; of |u|, drifts and absolute accelerations of masses."""
        n, half = self.count, self.count + len(self.bodies)
        places, slopes = y[:half], self.slopes(y, pulls)
        found = {
            "peak_closing": self.across @ places,
            "peak_opening": -self.across @ places,
            "peak_contact_force": slopes[2 * half : -1],
            "displacement": np.abs(places[:n] - self.stands @ places[n:]),
            "drift": np.abs(self.drifts @ places),
            "acceleration": np.abs(slopes[half : half + n]),
        }
        for name, values in found.items():
            self.peaks[name] = np.maximum(self.peaks.get(name, 0.0), values)


def follow_grounds(bodies: list[Body], touches: list[Touch], step: float) -> tuple[np.ndarray, np.ndarray]:
    """(displacements of the masses in space, of the grounds) at the samples, (n, masses) and (n, buildings) [m]."""
    system = Grounds(bodies, touches)
    rows = np.array([y for y, is_sample in followed(system, step) if is_sample])
    half = system.count + len(bodies)
    return rows[:, : system.count], rows[:, system.count : half]


def peaks_of(bodies: list[Body], touches: list[Touch], step: float) -> dict[str, np.ndarray]:
    """Peaks of a run, looked for at 41 places of each interval; impulses, touches that join, energy of the dampers."""
    system = Grounds(bodies, touches)
    *_, (last, _) = followed(system, step, np.linspace(0.0, 1.0, 41))
    return {**system.peaks, "impulse": last[-1 - len(touches) : -1], "joints": system.joints, "damped": last[-1]}


def followed(system: Grounds, step: float, places: np.ndarray | None = None) -> Iterator[tuple[np.ndarray, bool]]:
    """The state at the start and at the end of each interval, and whether that is a sample; peaks at such places."""
    bodies = system.bodies
    samples = np.arange(bodies[0].ground.size) * step
    times = np.unique(np.concatenate([samples + body.delay for body in bodies]))
    times = times[times <= samples[-1] * (1.0 + 1e-12)]
    times = times[np.append(True, np.diff(times) > 1e-9 * step)]
    y = system.start()
    yield y, True
    for now, then in pairwise(times):
        middle = 0.5 * (now + then)
        ends = [[_at(body, step, middle, time) for body in bodies] for time in (now, then)]
        y = _interval(system, y, np.array(ends), then - now, places)
        yield y, bool(np.abs(samples - then).min() < 1e-9 * step)


def _at(body: Body, step: float, middle: float, time: float) -> float:
    """a_g at a time, on the straight line that holds in the middle of an interval."""
    place = int(np.floor((middle - body.delay) / step))
    if place < 0:
        return 0.0
    first, second = body.ground[place : place + 2]
    return float(first + (second - first) * ((time - body.delay) / step - place))


def _interval(system: Grounds, y: np.ndarray, ends: np.ndarray, width: float, places: np.ndarray | None) -> np.ndarray:
    """The state at the end of an interval, from contact point to contact point that opens or closes."""
    begun, half = 0.0, system.count + len(system.bodies)
    events = []

    def pulls(t: float) -> np.ndarray:
        return ends[0] + (ends[1] - ends[0]) * t / width

    for k in range(len(system.gaps)):

        def crossing(t: float, y: np.ndarray, k: int = k) -> float:
            if system.joined[k]:
                return -float(system.slopes(y, pulls(t))[2 * half + k])
            return float(system.across[k] @ y[:half] - system.gaps[k])

        crossing.terminal = True  # type: ignore[attr-defined]
        crossing.direction = float(system.joins[k])  # type: ignore[attr-defined]
        events.append(crossing)
    while begun < width:
        run = solve_ivp(
            lambda t, y: system.slopes(y, pulls(t)),
            (begun, width),
            y,
            method="DOP853",
            rtol=1e-13,
            atol=1e-17,
            events=events or None,
            first_step=(width - begun) / 4,
            dense_output=places is not None,
        )
        for t in () if places is None else begun + places * (run.t[-1] - begun):
            system.look(run.sol(t), pulls(t))
        begun, y = (run.t[-1], run.y[:, -1]) if run.status == 1 and run.t[-1] > begun else (width, run.y[:, -1])
        if run.status == 1:
            (k,) = [k for k, times in enumerate(run.t_events) if times.size][:1]
            y = system.turn(y, pulls(begun), k) if system.joins[k] else y
            # Past the crossing, so that the next run does not find it at once.
            tiny = 1e-13 * width
            y = y + tiny * system.slopes(y, pulls(begun))
            begun += tiny
    return y
