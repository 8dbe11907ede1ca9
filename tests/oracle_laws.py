"""The reference integrator's scene and contact laws, written from the published formulas."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scipy.optimize import brentq

SLOWEST = 1e-4  # m/s: the least approach speed that a Hertz-damp law divides by
CONCRETE = (0.7929, -0.2529, 0.0696, -0.0070)  # paper eq. (4), powers of the speed in m/s
LINEAR = (
    "linear",
    "kelvin_voigt",
    "kelvin_voigt_tension_cut",
    "modified_kelvin_voigt",
)  # N/m
LAWS = (*LINEAR, "hertz", "hertz_damp", "hertz_damp_exact", "jankowski", "van_mier", "viscous_elastoplastic")


class Oscillator(NamedTuple):
    """A building: mass [kg], period [s] (0: rigid, moves with the ground), damping ratio."""

    mass: float
    period: float
    damping: float = 0.05

    @property
    def rate(self) -> complex:
        """λ = −ζω + iω√(1−ζ²); 0 for a rigid building."""
        if self.period == 0.0:
            return 0j
        omega = 2.0 * math.pi / self.period
        return omega * complex(-self.damping, math.sqrt(1.0 - self.damping**2))


WALL = Oscillator(math.inf, 0.0, 0.0)


@dataclass(frozen=True)
class Scene:
    """A pair; ``restitution`` is e or the coefficients of a cubic, held constant beyond ``fastest`` [m/s]."""

    left: Oscillator
    right: Oscillator
    law: str
    stiffness: float
    gap: float = 0.0
    restitution: float | Sequence[float] = 0.65
    yield_force: float = math.inf
    plastic_exponent: float = 0.0
    fastest: float = 5.0

    def e(self, speed: float) -> float:
        if isinstance(self.restitution, int | float):
            return float(self.restitution)
        v = min(speed, self.fastest)
        return sum(c * v**power for power, c in enumerate(self.restitution))


def coefficients(building: Oscillator) -> tuple[float, float, float]:
    """(ω², 2ζω, 1/m); zeros for a rigid building, which nothing moves."""
    if building.period == 0.0:
        return 0.0, 0.0, 0.0
    omega = 2.0 * math.pi / building.period
    return omega**2, 2.0 * building.damping * omega, 1.0 / building.mass


def damping_ratio(law: str, e: float) -> float:
    """ξ (or d of the Hertz-damp family) of a law that should return e, by its published formula."""
    if law in ("kelvin_voigt", "kelvin_voigt_tension_cut"):
        return -math.log(e) / math.hypot(math.pi, math.log(e))
    if law == "modified_kelvin_voigt":
        return (1.0 - e * e) / (e * (e * (math.pi - 2.0) + 2.0))
    if law in ("jankowski", "viscous_elastoplastic"):
        return 4.5 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))
    if law == "hertz_damp":
        return 0.75 * (1.0 - e * e)
    if law == "hertz_damp_exact":
        return exact_hertz_damp(e)
    return 0.0


def exact_hertz_damp(e: float) -> float:
    """d > 0 with exp[d (1+e)] = (1+d)/(1−d e); d = 0 also solves it and is not meant."""
    if e == 1.0:
        return 0.0
    return float(brentq(lambda d: math.log1p(d) - math.log1p(-d * e) - d * (1.0 + e), 1e-7 * (1 - e), (1 - 1e-15) / e))


class Law:
    """The force of one contact: its restitution, and so its damping, are fixed by the speed of the touch."""

    def __init__(self, scene: Scene, speed: float) -> None:
        self.name, self.k, self.cap, self.n = (
            scene.law,
            scene.stiffness,
            scene.yield_force,
            scene.plastic_exponent,
        )
        masses = (scene.left.mass, scene.right.mass)
        mass = 1.0 / sum(1.0 / m for m in masses)
        ratio = damping_ratio(scene.law, scene.e(speed))
        self.per_speed = ratio / max(speed, SLOWEST) if scene.law.startswith("hertz_damp") else 0.0
        self.linear = scene.law in LINEAR
        # c of a linear law; of Jankowski's law c = 2 ξ √(β m) δ^¼, of which the constant part stands here.
        self.c = 0.0 if scene.law.startswith("hertz") else 2.0 * ratio * math.sqrt(self.k * mass)
        self.approach_only = scene.law in ("modified_kelvin_voigt", "jankowski", "viscous_elastoplastic")

    def trial(self, depth: float, speed: float, approach: bool) -> float:
        """The force without its cap, and before tension is cut."""
        damper = self.c * speed if approach or not self.approach_only else 0.0
        if self.linear:
            return self.k * depth + damper
        depth = max(depth, 0.0)
        root = math.sqrt(depth)
        elastic = self.k * depth * root
        return elastic * (1.0 + self.per_speed * speed) + damper * math.sqrt(root)

    def force(self, depth: float, speed: float, phase: Phase) -> float:
        """The contact force in one smooth phase of the contact."""
        if phase.cut:
            return 0.0
        if phase.yielding and self.name == "viscous_elastoplastic":
            return self.cap
        if phase.yielding and self.name == "van_mier":
            return self.cap * (max(depth, 0.0) / (self.cap / self.k) ** (2.0 / 3.0)) ** self.n
        return self.trial(depth, speed, phase.approach)

    def recoverable(self, depth: float) -> float:
        """What the force gives back on a slow way out from this depth."""
        if depth <= 0.0:
            return 0.0
        if self.linear:
            return 0.5 * self.k * depth**2
        limit = (self.cap / self.k) ** (2.0 / 3.0)
        if depth <= limit or self.name not in ("viscous_elastoplastic", "van_mier"):
            return 0.4 * self.k * depth**2.5
        n = self.n if self.name == "van_mier" else 0.0
        return 0.4 * self.cap * limit + self.cap * limit * ((depth / limit) ** (n + 1.0) - 1.0) / (n + 1.0)


@dataclass
class Phase:
    """What makes a law smooth: which of its branches holds."""

    approach: bool = True
    yielding: bool = False
    cut: bool = False
