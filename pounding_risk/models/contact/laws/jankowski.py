"""Jankowski's nonlinear viscoelastic law."""

from __future__ import annotations

from math import pi, sqrt
from typing import Annotated, NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.models.contact.damping import approach_ratio, positive_root
from pounding_risk.models.contact.law import HERTZ_STIFFNESS, flat, hertz_energy, may_pull, never_yields

ORDER = 30


@small
def jankowski_ratio(e):
    """ξ = (9 √5 / 2) (1 − e²) / (e (e (9π − 16) + 16)) (Jankowski 2006; the 2011 paper's eq. 2b, 3b)."""
    return 4.5 * sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * pi - 16.0) + 16.0))


def jankowski_damping(self, e, speed, mass):
    """2 ξ sqrt(β m), so that c̄ = this times δ^(1/4)."""
    return 2.0 * jankowski_ratio(e) * sqrt(self.stiffness * mass)


def jankowski_exact_damping(self, e, speed, mass):
    """2 ξ sqrt(β m) with ξ = (√5 / 2) ζ(e)."""
    return sqrt(5.0) * approach_ratio(e) * sqrt(self.stiffness * mass)


def jankowski_force(self, memory, delta, rate, approaching):
    """β δ^1.5, on approach with c̄ δ̇."""
    root = sqrt(delta)
    spring = self.stiffness * (delta * root)
    return spring + memory * sqrt(root) * rate if approaching else spring


class Jankowski(NamedTuple):
    """Nonlinear viscoelastic: F = β δ^1.5 + c̄ δ̇ on approach, F = β δ^1.5 on restitution.

    c̄ = 2 ξ sqrt(β sqrt(δ) m), ξ = (9 √5 / 2)(1 − e²) / (e (e (9π − 16) + 16)). The e achieved depends on ξ
    alone and is within 0.009 of the e asked for.

    >>> Jankowski(1e9).force(1e6, 1e-4, 1.0, True)
    101000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Jankowski (2005, 2006); Khatiwada et al. (2011) eq. 2, 2a, 2b"
    capped, needs_restitution = False, True

    begin, force, plateau = jankowski_damping, jankowski_force, flat
    stored, ceiling, floor = hertz_energy, never_yields, may_pull


class JankowskiExact(Jankowski):
    """Nonlinear viscoelastic: ξ = (√5 / 2) ζ, exp[−(ζ/s) atan2(s, ζ)] = e, s = sqrt(1 − ζ²).

    >>> round(JankowskiExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.36816
    """

    __slots__ = ()
    begin = jankowski_exact_damping


def jankowski_restitution(ratio: float) -> float:
    """The root in (0, 1] of (ξ (9π − 16) + 9√5/2) e² + 16 ξ e − 9√5/2 = 0; Jankowski (2006)."""
    full = 4.5 * sqrt(5.0)
    return positive_root(ratio * (9.0 * pi - 16.0) + full, 8.0 * ratio, full)


EXACT = {Jankowski: JankowskiExact}
RESTITUTION_OF_RATIO = {Jankowski: (jankowski_restitution, 1e6)}
