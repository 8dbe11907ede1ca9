"""Isolators under a building: a bilinear force with kinematic hardening, and a dashpot beside it.

With Q_d the force at zero displacement on the branch that yields and k_2 its stiffness, before it k_1 up to u_y:

    V = Q_d sgn(u̇) + k_2 u,     k_1 = k_2 + Q_d / u_y,     V_y = k_1 u_y = Q_d + k_2 u_y
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from pounding_risk.units import STANDARD_GRAVITY

YIELD_DISPLACEMENT = 1e-3  # m, of isolators that are given none: of a slider it stands for the stick, u_y = 0


class IsolatorLaw(NamedTuple):
    """The force of all isolators together."""

    strength: float  # N, Q_d
    soft: float  # N/m, k_2
    stiff: float  # N/m, k_1
    limit: float  # N, V_y; infinite without Q_d, as they are then linear

    @property
    def hardening(self) -> float:
        """Ratio of the stiffness after yielding to the elastic one, k_2 / k_1."""
        return self.soft / self.stiff


@dataclass(frozen=True)
class Isolators:
    """The isolators under a slab, and the slab on them.

    Lead-rubber bearings have ``strength`` Q_d and ``stiffness`` k_2; friction pendulums ``friction`` μ and ``radius``
    R, with Q_d = μ W and k_2 = W / R of the weight W of the slab and all floors. What is not given is None.

    >>> law = Isolators(6e5, 1.5, friction=0.05, radius=2.0).law(2e6)
    >>> law.soft, round(law.limit)
    (9806650.0, 990472)
    """

    slab_mass: float  # kg
    height: float  # m, of the slab above the ground
    strength: float | None = None  # N
    stiffness: float | None = None  # N/m
    friction: float | None = None
    radius: float | None = None  # m
    yield_displacement: float = YIELD_DISPLACEMENT  # m
    damping: float = 0.0  # N s/m, between the slab and the ground

    def law(self, mass: float) -> IsolatorLaw:
        """The law of isolators that carry this mass [kg], the slab's among it."""
        weight = STANDARD_GRAVITY * mass
        strength = weight * self.friction if self.strength is None else self.strength  # type: ignore[operator]
        soft = weight / self.radius if self.stiffness is None else self.stiffness  # type: ignore[operator]
        stiff = soft + strength / self.yield_displacement
        return IsolatorLaw(strength, soft, stiff, stiff * self.yield_displacement if strength else inf)
