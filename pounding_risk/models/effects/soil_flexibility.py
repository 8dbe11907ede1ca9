"""Foundations that sway on the soil."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isnan, nan, pi
from typing import Any

from pounding_risk.models.effects import effect
from pounding_risk.units import Quantity

ORDER = 70  # the last on buildings: it puts the finished building on a foundation
VELOCITY = Quantity("m/s", 0.0, inf, "shear wave velocity", open_low=True, open_high=True, example="200 m/s")
RADIUS = Quantity("m", 0.0, inf, "radius of the foundation", open_low=True, open_high=True, example="8 m")
DENSITY = Quantity("kg/m^3", 0.0, inf, "density of the soil", open_low=True, open_high=True, example="1800 kg/m^3")
POISSON = Quantity("1", 0.0, 0.5, "Poisson's ratio of the soil", example="0.33")
FOUNDATION = Quantity("kg", 0.0, inf, "mass of the foundation", open_low=True, open_high=True, example="100 t")


@effect(
    reference="Wolf (1994), Foundation Vibration Analysis Using Simple Physical Models: disc in sway",
    options={
        "shear_wave_velocity": VELOCITY,
        "radius": RADIUS,
        "density": DENSITY,
        "poisson": POISSON,
        "foundation_mass": FOUNDATION,
    },
    absent={"foundation_mass": "the mass of the lowest floor"},
)
@dataclass(frozen=True)
class SoilFlexibility:
    """The foundation sways on the soil: a spring and a dashpot under each building, of a rigid disc on a half-space.

    K = 8 G r / (2 − ν), G = ρ V_s²; C = ρ V_s π r², the cone model's, whose static stiffness is K. ρ 1800 kg/m³ and ν
    1/3 if not given; the foundation weighs as much as the lowest floor if its mass is not given. The dashpot and the
    foundation come on top of the building's own mass and damping. Sway only: no rocking, no embedment, the same soil
    and radius under every building. A rigid building stays on rigid ground.

    >>> soil = SoilFlexibility(shear_wave_velocity=200.0, radius=8.0)
    >>> round(soil.stiffness / 1e9, 4), round(soil.dashpot / 1e6, 2)
    (2.7648, 72.38)
    """

    shear_wave_velocity: float  # m/s
    radius: float  # m
    density: float = 1800.0  # kg/m³
    poisson: float = 1.0 / 3.0
    foundation_mass: float = nan  # kg; NaN for that of the lowest floor

    @property
    def stiffness(self) -> float:
        """8 G r / (2 − ν) [N/m]."""
        return 8.0 * self.density * self.shear_wave_velocity**2 * self.radius / (2.0 - self.poisson)

    @property
    def dashpot(self) -> float:
        """ρ V_s π r² [N s/m]."""
        return self.density * self.shear_wave_velocity * pi * self.radius**2

    def built(self, chain: Any, building: Any) -> Any:
        """The chain on its foundation."""
        mass = float(chain.mass[0]) if isnan(self.foundation_mass) else self.foundation_mass
        return chain.founded(mass, self.stiffness, self.dashpot)
