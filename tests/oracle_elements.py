"""Central differences of masses with elements between them, from numbers alone: everything that yields, at one time.

Elements have the deformation x = row of shares · u and the force f that opposes it. Springs yield with kinematic
hardening, which makes storeys, isolators, links and links that slip; stops act past an offset, which makes contacts and
hooks, and break; one with an offset of −∞ acts both ways. Braced dampers have the force k_b y with
ẏ = ẋ − (k_b |y| / c)^(1/α) sgn y. The error falls with the square of the step, kinks aside.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

Array = np.ndarray


@dataclass
class Elements:
    """Elements by kind, each with its shares {dof: share}."""

    springs: list[tuple[dict[int, float], float, float, float]] = field(default_factory=list)  # k, hardening, limit
    stops: list[tuple[dict[int, float], float, float, float]] = field(default_factory=list)  # k, offset, breaks at
    dampers: list[tuple[dict[int, float], float, float, float]] = field(default_factory=list)  # c, α, k_b


@dataclass
class Motion:
    """What became of a run, by dof and by element in their order."""

    displacement: Array  # largest |u|
    springs: Array  # (2, count): largest |x|, and |plastic x| at the end
    stops: Array  # (4, count): largest x and force, how often it begins to act, whether it is broken
    first: Array  # s, when each stop first acts
    dampers: Array  # (2, count): largest force, energy taken


def shaken(mass: Array, damping: Array, elements: Elements, ground: Array, step: float) -> Motion:
    """From rest under a ground acceleration at every step."""
    kinds = elements.springs, elements.stops, elements.dampers
    rows = [np.zeros((len(kind), mass.size)) for kind in kinds]
    for of_kind, kind in zip(rows, kinds, strict=True):
        for row, element in zip(of_kind, kind, strict=True):
            row[list(element[0])] = list(element[0].values())
    springs, stops, dampers = rows
    k, hardening, limit = np.array([one[1:] for one in kinds[0]]).reshape(-1, 3).T
    soft, held = hardening * k, (1.0 - hardening) * np.where(limit < inf, limit, 1e30)
    stiff, offset, breaks = np.array([one[1:] for one in kinds[1]]).reshape(-1, 3).T
    c, power, brace = np.array([one[1:] for one in kinds[2]]).reshape(-1, 3).T
    before = np.diag(mass) / step**2 - damping / (2.0 * step)
    inverse = np.linalg.inv(np.diag(mass) / step**2 + damping / (2.0 * step))
    now = past = np.zeros(mass.size)
    plastic, y, whole, acts = np.zeros(k.size), np.zeros(c.size), np.ones(stiff.size), np.zeros(stiff.size, dtype=bool)
    peak, reach, far, push = np.zeros(mass.size), np.zeros(k.size), np.zeros(stiff.size), np.zeros(stiff.size)
    count, first, largest, taken = np.zeros(stiff.size), np.full(stiff.size, np.nan), np.zeros(c.size), np.zeros(c.size)

    def speed(y: Array) -> Array:
        return np.sign(y) * (brace * np.abs(y) / c) ** (1.0 / power)

    for number, pull in enumerate(ground):
        x, reached = springs @ now, stops @ now
        past_offset = np.where(offset > -inf, reached - offset, reached)
        elastic = np.clip((k - soft) * (x - plastic), -held, held)
        plastic = x - elastic / (k - soft)
        trial = stiff * np.where(offset > -inf, np.maximum(past_offset, 0.0), past_offset)
        whole *= np.abs(trial) < breaks
        force = whole * trial
        load = -mass * pull - springs.T @ (soft * x + elastic) - stops.T @ force - dampers.T @ (brace * y)
        past, now = now, inverse @ (load + 2.0 * mass / step**2 * now - before @ past)
        begins = (past_offset > 0.0) & ~acts
        first = np.where(begins & np.isnan(first), number * step, first)
        count, acts = count + begins, past_offset > 0.0
        moved = dampers @ (now - past)
        middle = y + 0.5 * (moved - step * speed(y))
        y = y + moved - step * speed(middle)
        taken += step * brace * middle * speed(middle)
        for best, value in ((peak, past), (reach, x), (push, force), (largest, brace * y)):
            np.maximum(best, np.abs(value), out=best)
        np.maximum(far, reached, out=far)
    return Motion(
        peak, np.array([reach, np.abs(plastic)]), np.array([far, push, count, 1.0 - whole]), first,
        np.array([largest, taken]),
    )  # fmt: skip
