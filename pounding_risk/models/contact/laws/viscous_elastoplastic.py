"""The viscous elastoplastic law: Jankowski's force with a yield force."""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

from pounding_risk._jit.compile import kernel
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

ORDER = 70


@kernel
def capped_hertz_work(stiffness, delta, strength):
    """∫ min(β x^1.5, F_E) dx from 0 to δ."""
    force = stiffness * delta * sqrt(delta)
    if force <= strength:
        return hertz_work(stiffness, delta)
    yields_at = (strength / stiffness) ** (2.0 / 3.0)
    return hertz_work(stiffness, yields_at) + strength * (delta - yields_at)


class ViscousElastoplastic(NamedTuple):
    """Jankowski's force, cut at the yield force F_E in both phases, exactly as published.

    F = β δ^1.5 + c̄ δ̇ (approach) or β δ^1.5 (restitution) where that is below F_E, else F = F_E. Read
    literally the plateau is retraced on unloading: yielding dissipates nothing and clips the viscous loss, so
    that a lower F_E rebounds *more*.

    >>> ViscousElastoplastic(1e9).plateau(0.02, 4.5e5)
    450000.0

    Parameters
    ----------
    stiffness : float
        Impact stiffness β [N/m^1.5].
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Khatiwada et al. (2011), Development of pounding model for adjacent structures, eq. 3, 3a, 3b"
    capped = True
    needs_restitution = True

    begin = jankowski_damping
    force = jankowski_force
    yields_at = hertz_yields_at
    plateau = flat

    def stored(self, delta, strength):
        return capped_hertz_work(self.stiffness, delta, strength)

    ceiling = capped_at_yield
    floor = may_pull


class ViscousElastoplasticExact(ViscousElastoplastic):
    """Viscous elastoplastic with the ξ of `JankowskiExact`: e is achieved where the force stays below F_E.

    >>> round(ViscousElastoplasticExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.36816
    """

    __slots__ = ()
    begin = jankowski_exact_damping


EXACT = {ViscousElastoplastic: ViscousElastoplasticExact}
RESTITUTION_OF_RATIO = {ViscousElastoplastic: (jankowski_restitution, 1e6)}
