"""Van Mier's elastoplastic law."""

from __future__ import annotations

from math import sqrt
from typing import Annotated, NamedTuple

from pounding_risk.models.contact.law import (
    HERTZ_STIFFNESS,
    capped_at_yield,
    hertz_force,
    hertz_work,
    hertz_yields_at,
    may_pull,
    undamped,
    without_damper,
)
from pounding_risk.units import Quantity

ORDER = 50
EXPONENT = Quantity("1", 0.0, 1.5, "exponent n of the plastic branch")


class VanMier(NamedTuple):
    """Elastoplastic: F = K_e δ^1.5 below yield, F = K_p δ^n past it, the same path on unloading.

    K_p follows from continuity at F_E: K_p = F_E / δ_y^n, δ_y = (F_E / K_e)^(2/3). n = 0 is ideally plastic;
    n = 1.5 is Hertz again. The published model gives no general K_e, K_p or n.

    >>> VanMier(1e9, 0.0).plateau(1.0, 5e5)
    500000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]
    plastic_exponent: Annotated[float, EXPONENT] = 0.0

    reference = "van Mier et al. (1991), Journal of Structural Engineering 117; Khatiwada et al. (2011) eq. 1"
    capped, needs_restitution = True, False

    begin, force, conserves = undamped, hertz_force, without_damper
    yields_at = hertz_yields_at

    def plateau(self, delta, strength):
        return strength * (delta / self.yields_at(strength)) ** self.plastic_exponent

    def stored(self, delta, strength):
        if self.stiffness * delta * sqrt(delta) <= strength:
            return hertz_work(self.stiffness, delta)
        n = self.plastic_exponent
        yields_at = self.yields_at(strength)
        plastic = strength * yields_at * ((delta / yields_at) ** (n + 1.0) - 1.0) / (n + 1.0)
        return hertz_work(self.stiffness, yields_at) + plastic

    ceiling, floor = capped_at_yield, may_pull
