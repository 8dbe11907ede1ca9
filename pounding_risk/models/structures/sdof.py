"""Buildings as the solver sees them: linear single-degree-of-freedom oscillators, or rigid blocks."""

from __future__ import annotations

from math import inf, pi
from typing import Annotated, NamedTuple

from pounding_risk import units
from pounding_risk.models._discovery import documented
from pounding_risk.models.ground import SHARED, Support

# sqrt(E/ρ) of concrete C25/30 is 3490 m/s: E_cm = 31 GPa (EN 1992-1-1, Table 3.1), 25 kN/m³ (EN 1991-1-1, Table A.1).
CONCRETE_WAVE_SPEED = 3500.0  # m/s


@documented
class Building(NamedTuple):
    """A mass on a linear spring and damper, u measured relative to the ground.

        ü + 2 ζ ω u̇ + ω² u = −a_g(t) + (contact forces) / m,     ω = 2π / T

    ``period`` 0 means rigid: the building moves with the ground and cannot be pushed. ``floor_length`` is that of the
    floor in the direction of the row, 0 where it is not known; only contact models that collide floors use it, and
    with it ``wave_speed``. ``initial_displacement`` and ``initial_velocity`` are u and u̇ when the motion begins.
    ``support`` says what a_g is under it. Files of ``displacement_history`` give u without contact in place of the
    equation.
    """

    name: str
    mass: Annotated[float, units.MASS]
    period: Annotated[float, units.PERIOD]
    damping: Annotated[float, units.DAMPING]
    floor_length: Annotated[float, units.FLOOR_LENGTH] = 0.0
    wave_speed: Annotated[float, units.WAVE_SPEED] = CONCRETE_WAVE_SPEED
    height: Annotated[float, units.HEIGHT] = 0.0
    initial_displacement: Annotated[float, units.INITIAL_DISPLACEMENT] = 0.0
    initial_velocity: Annotated[float, units.INITIAL_VELOCITY] = 0.0
    support: Support = SHARED
    displacement_history: tuple[str, ...] = ()

    @classmethod
    def rigid(cls, name: str, mass: float = inf) -> Building:
        """A building that moves with the ground; its mass plays no part in the motion."""
        return cls(name, mass, 0.0, 0.0)

    @property
    def is_rigid(self) -> bool:
        """True where the building moves with the ground."""
        return self.period == 0.0

    @property
    def heights(self) -> tuple[float, ...]:
        """Height of its one storey [m]; empty where it is not known."""
        return (self.height,) if self.height > 0.0 else ()

    @property
    def strengths(self) -> tuple[float, ...]:
        """Yield shears of its storeys [N]: none, a single mass stays elastic."""
        return ()

    @property
    def column_strength(self) -> float:
        """Force at which its column yields where a floor strikes it [N]: none of its own."""
        return inf

    @property
    def stiffness(self) -> float:
        """k = m (2π/T)² [N/m]; infinite for a rigid building."""
        return inf if self.is_rigid else self.mass * (2.0 * pi / self.period) ** 2

    def oscillator(self) -> Oscillator:
        """The numbers that the kernels work with."""
        if self.is_rigid:
            return Oscillator(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        omega = 2.0 * pi / self.period
        return Oscillator(
            float(self.mass), 1.0 / self.mass, omega * omega, 2.0 * self.damping * omega, 1.0, 1.0 / omega
        )


class Oscillator(NamedTuple):
    """A building in the kernels: ü = −ground a_g − two_zeta_omega u̇ − omega2 u ± inverse_mass F.

    All zero means rigid. ``mass`` serves the energy ledger only, where a rigid building counts nothing.
    """

    mass: float  # kg
    inverse_mass: float  # 1/kg
    omega2: float  # ω², 1/s²
    two_zeta_omega: float  # 2 ζ ω, 1/s
    ground: float  # 1, or 0 where the building moves with the ground or there is none
    inverse_omega: float  # 1/ω, s


def free_mass(mass: float) -> Oscillator:
    """A mass without a spring, as in an isolated impact; an infinite one is a fixed wall."""
    if mass == inf:
        return Oscillator(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Oscillator(float(mass), 1.0 / mass, 0.0, 0.0, 0.0, 0.0)
