"""The viscous elastoplastic law: Jankowski's force with a yield force."""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

from pounding_risk.models.contact.law import (
    HERTZ_STIFFNESS,
    capped_at_yield,
    flat,
    hertz_work,
    hertz_yields_at,
    may_pull,
)
from pounding_risk.models.contact.laws.jankowski import (
    jankowski_damping,
    jankowski_exact_damping,
    jankowski_force,
    jankowski_restitution,
)

ORDER = 60


class ViscousElastoplastic(NamedTuple):
    """Jankowski's force, cut at the yield force F_E in both phases, exactly as published.

    F = β δ^1.5 + c̄ δ̇ (approach) or β δ^1.5 (restitution) where that is below F_E, else F = F_E. Read
    literally the plateau is retraced on unloading: yielding dissipates nothing and clips the viscous loss, so
    that a lower F_E rebounds *more*.

    >>> ViscousElastoplastic(1e9).plateau(0.02, 4.5e5)
    450000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Khatiwada et al. (2011), Development of pounding model for adjacent structures, eq. 3, 3a, 3b"
    capped, needs_restitution = True, True

    begin, force, plateau = jankowski_damping, jankowski_force, flat
    yields_at = hertz_yields_at

    def stored(self, delta, strength):
        if self.stiffness * delta * sqrt(delta) <= strength:
            return hertz_work(self.stiffness, delta)
        yields_at = self.yields_at(strength)
        return hertz_work(self.stiffness, yields_at) + strength * (delta - yields_at)

    ceiling, floor = capped_at_yield, may_pull


class ViscousElastoplasticExact(ViscousElastoplastic):
    """Viscous elastoplastic with the ξ of `JankowskiExact`: e is achieved where the force stays below F_E.

    >>> round(ViscousElastoplasticExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.36816
    """

    __slots__ = ()
    begin = jankowski_exact_damping


EXACT = {ViscousElastoplastic: ViscousElastoplasticExact}
RESTITUTION_OF_RATIO = {ViscousElastoplastic: (jankowski_restitution, 1e6)}
