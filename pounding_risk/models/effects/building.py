"""Effects that act on buildings: storeys that yield, weight that pushes them over, soil that gives way.

Each is told the chain of masses and springs that a building is (`pounding_risk.models.structures.mdof.Chain`) and says
what it becomes.
They act in the order of this module.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from math import inf, isnan, nan, pi
from typing import Any, ClassVar

from pounding_risk.errors import PoundingError
from pounding_risk.units import STANDARD_GRAVITY, Quantity

HARDENING = Quantity("1", 0.0, 1.0, "stiffness past yield over that before", open_high=True, example="0.03")
VELOCITY = Quantity("m/s", 0.0, inf, "shear wave velocity", open_low=True, open_high=True, example="200 m/s")
RADIUS = Quantity("m", 0.0, inf, "radius of the foundation", open_low=True, open_high=True, example="8 m")
DENSITY = Quantity("kg/m^3", 0.0, inf, "density of the soil", open_low=True, open_high=True, example="1800 kg/m^3")
POISSON = Quantity("1", 0.0, 0.5, "Poisson's ratio of the soil", example="0.33")
FOUNDATION = Quantity("kg", 0.0, inf, "mass of the foundation", open_low=True, open_high=True, example="100 t")


@dataclass(frozen=True)
class InelasticStoreys:
    """Storeys yield: bilinear hysteresis between drift and storey shear, with kinematic hardening.

    V = k d up to the storey's yield shear V_y, past it with the slope ``hardening`` × k (0.03 if not given); after a
    turn the storey is elastic over 2 V_y. A storey without a yield shear stays elastic, as a single mass does. What P-Δ
    takes off the stiffness acts beside the hysteresis, so that a yielding storey may have less than none left.
    """

    hardening: float

    reference: ClassVar[str] = "bilinear hysteresis with kinematic hardening; Prager (1956) for the rule"
    options: ClassVar[Mapping[str, Quantity]] = {"hardening": HARDENING}
    optional: ClassVar[tuple[str, ...]] = ("hardening",)

    @classmethod
    def on(cls, hardening: float = 0.03) -> InelasticStoreys:
        """Storeys with this stiffness past yield over that before."""
        return cls(hardening)

    def built(self, chain: Any, building: Any) -> Any:
        """The chain whose storeys yield at the building's strengths."""
        return chain.yielding(building.strengths, self.hardening) if building.strengths else chain


@dataclass(frozen=True)
class PDelta:
    """Weight pushes a leaning storey further: the storey's stiffness is less by P / h.

    P is the weight of all floors above the storey, h its height. The damping stays that of the building without it. A
    building whose storey has no stiffness left would fall over, and is refused.
    """

    reference: ClassVar[str] = "Wilson and Habibullah (1987), Earthquake Spectra 3: storey geometric stiffness P / h"
    options: ClassVar[Mapping[str, Quantity]] = {}
    optional: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def on(cls) -> PDelta:
        """It has no options."""
        return cls()

    def built(self, chain: Any, building: Any) -> Any:
        """The softened chain; raises PoundingError for a building without a height."""
        if not building.heights:
            raise PoundingError(
                f"p_delta: {building.name} has no height, and P / h needs it; "
                'write height = "12 m" in its [[building]], or remove p_delta'
            )
        above = reversed(list(accumulate(reversed(chain.mass.tolist()))))
        weights = [STANDARD_GRAVITY * mass for mass in above]
        return chain.softened([weight / height for weight, height in zip(weights, building.heights, strict=True)])


@dataclass(frozen=True)
class SoilFlexibility:
    """The foundation sways on the soil: a spring and a dashpot under each building, of a rigid disc on a half-space.

    K = 8 G r / (2 − ν), G = ρ V_s²; C = ρ V_s π r², the cone model's, whose static stiffness is K. ρ 1800 kg/m³ and ν
    1/3 if not given; the foundation weighs as much as the lowest floor if its mass is not given. The dashpot and the
    foundation come on top of the building's own mass and damping. Sway only: no rocking, no embedment, the same soil
    and radius under every building. A rigid building stays on rigid ground.

    >>> soil = SoilFlexibility.on(shear_wave_velocity=200.0, radius=8.0)
    >>> round(soil.stiffness / 1e9, 4), round(soil.dashpot / 1e6, 2)
    (2.7648, 72.38)
    """

    velocity: float  # m/s
    radius: float  # m
    density: float  # kg/m³
    poisson: float
    foundation: float  # kg; NaN for that of the lowest floor

    reference: ClassVar[str] = "Wolf (1994), Foundation Vibration Analysis Using Simple Physical Models: disc in sway"
    options: ClassVar[Mapping[str, Quantity]] = {
        "shear_wave_velocity": VELOCITY,
        "radius": RADIUS,
        "density": DENSITY,
        "poisson": POISSON,
        "foundation_mass": FOUNDATION,
    }
    optional: ClassVar[tuple[str, ...]] = ("density", "poisson", "foundation_mass")

    @classmethod
    def on(
        cls,
        shear_wave_velocity: float,
        radius: float,
        density: float = 1800.0,
        poisson: float = 1.0 / 3.0,
        foundation_mass: float = nan,
    ) -> SoilFlexibility:
        """Soil of this shear wave velocity [m/s] and density [kg/m³] under discs of this radius [m]."""
        return cls(shear_wave_velocity, radius, density, poisson, foundation_mass)

    @property
    def stiffness(self) -> float:
        """8 G r / (2 − ν) [N/m]."""
        return 8.0 * self.density * self.velocity**2 * self.radius / (2.0 - self.poisson)

    @property
    def dashpot(self) -> float:
        """ρ V_s π r² [N s/m]."""
        return self.density * self.velocity * pi * self.radius**2

    def built(self, chain: Any, building: Any) -> Any:
        """The chain on its foundation."""
        mass = float(chain.mass[0]) if isnan(self.foundation) else self.foundation
        return chain.founded(mass, self.stiffness, self.dashpot)


BUILDING_EFFECTS = (InelasticStoreys, PDelta, SoilFlexibility)
