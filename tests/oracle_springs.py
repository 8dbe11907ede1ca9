"""The reference of linear systems whose contacts are linear springs: SciPy's DOP853 from touch to parting."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Linear(NamedTuple):
    """M ü + C u̇ + K u = −M feltᵀ a_g − sharesᵀ F, F = spring (shares u − gap) at each contact that is closed."""

    masses: np.ndarray  # a vector, or the matrix M
    stiffness: np.ndarray
    damping: np.ndarray
    shares: np.ndarray  # (contacts, masses)
    spring: float
    gap: float
    felt: Any = 1.0  # (components of the ground, masses), where not all feel the only one


def segments(
    system: Linear, ground: Any, dt: float, places: int
) -> Iterator[tuple[bool, np.ndarray, np.ndarray, np.ndarray]]:
    """From rest, between samples and events: is a sample its end, u at so many places of it, forces and ü + a_g there.

    ``ground`` is a_g at the samples, a column for each component, of which the first counts in ü + a_g; u and ü are
    (masses, places) and forces (contacts, places).
    """
    size, count = len(system.masses), len(system.shares)
    inverse = np.linalg.inv(system.masses) if system.masses.ndim > 1 else np.diag(1.0 / system.masses)
    felt, ground = system.felt * np.ones((1, size)), np.reshape(ground, (len(ground), -1))

    def motion(t: float, y: np.ndarray, k: int, closed: np.ndarray) -> np.ndarray:
        pull = felt.T @ (ground[k] + (ground[k + 1] - ground[k]) * (t / dt - k))
        u, v = y[:size], y[size:]
        force = np.where(closed, system.spring * (system.shares @ u - system.gap), 0.0)
        push = system.damping @ v + system.stiffness @ u + system.shares.T @ force
        return np.concatenate([v, -inverse @ push - pull])

    def closing_of(place: int) -> Any:
        return lambda t, y, *_: system.shares[place] @ y[:size] - system.gap

    events = [closing_of(place) for place in range(count)]
    state, closed = np.zeros(2 * size), np.zeros(count, dtype=bool)
    for k in range(len(ground) - 1):
        t, stop = k * dt, (k + 1) * dt
        while t < stop:
            for touch, shut in zip(events, closed, strict=True):
                touch.terminal, touch.direction = True, -1.0 if shut else 1.0
            found = solve_ivp(
                motion, (t, stop), state, "DOP853", args=(k, closed), events=events, rtol=1e-12, atol=1e-15,
                dense_output=True,
            )  # fmt: skip
            times = np.linspace(t, found.t[-1], places)
            states = found.sol(times)
            path = states[:size]
            rates = [motion(at, state, k, closed)[size:] for at, state in zip(times, states.T, strict=True)]
            shaken = np.transpose(rates) + np.interp(times / dt, range(len(ground)), ground[:, 0])
            forces = np.where(closed[:, None], system.spring * (system.shares @ path - system.gap), 0.0)
            t, state = found.t[-1], found.y[:, -1]
            yield bool(t == stop), path, forces, shaken
            if found.status == 1:
                place = int(np.argmax([passed.size > 0 for passed in found.t_events]))
                closed[place] = not closed[place]


class Extremes(NamedTuple):
    """What a run reaches at so many places of each interval."""

    high: np.ndarray  # of the watched displacements
    low: np.ndarray
    force: np.ndarray  # of each contact
    shaken: np.ndarray  # |ü + a_g| of each mass
    contacts: int  # from no contact to some
    samples: np.ndarray  # u at the samples


def extremes(system: Linear, ground: Any, dt: float, places: int, watched: Any = None) -> Extremes:
    """A whole run; ``watched`` are the shares of the masses in displacements that are watched, else each mass is."""
    watched = np.eye(len(system.masses)) if watched is None else np.asarray(watched)
    high, force = np.zeros(len(watched)), np.zeros(len(system.shares))
    low, shaken, samples = np.zeros(len(watched)), np.zeros(len(system.masses)), [np.zeros(len(system.masses))]
    contacts, closed = 0, False
    for is_sample, path, forces, accelerations in segments(system, ground, dt, places):
        moved = watched @ path
        high, low = np.maximum(high, moved.max(axis=1)), np.minimum(low, moved.min(axis=1))
        force = np.maximum(force, forces.max(axis=1))
        shaken = np.maximum(shaken, np.abs(accelerations).max(axis=1))
        contacts, closed = contacts + bool(forces.any() and not closed), bool(forces.any())
        samples += [path[:, -1]] * is_sample
    return Extremes(high, low, force, shaken, contacts, np.array(samples))
