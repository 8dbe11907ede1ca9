"""Exact damping relations: the same contact laws, each with the damping that returns the e asked for.

The published ξ(e) are approximations, or belong to a law that may pull. A class below is its published law with
another ``begin`` and nothing else, so that the choice is made when a kernel is compiled.

One relation serves three laws. In x = δ^(5/4) the approach under Jankowski's law,
m v dv/dδ = −β δ^1.5 − 2 ξ sqrt(β m) δ^(1/4) v, is v dv/dx = −0.8 (β/m) x − 1.6 ξ sqrt(β/m) v: the linear
oscillator of ratio ζ = sqrt(0.8) ξ, whose elastic energy at the turn is the same share of the approach's.
Kelvin-Voigt without tension loses as much again on its way out as on its way in, so that its e is the square.

The bilinear law has no damper: there the loop is what follows from e, and a loop takes only so much.
"""

from __future__ import annotations

from math import atan2, log, nan, pi, sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.models.contact.laws import (
    SLOWEST_TOUCH,
    Bilinear,
    HertzDamp,
    HertzDampExact,
    Jankowski,
    KelvinVoigt,
    KelvinVoigtTensionCut,
    ModifiedKelvinVoigt,
    ViscousElastoplastic,
)


@kernel
def speed_lost(ratio):
    """−ln e of x'' + 2 ζ x' + x = 0, damped until it turns and elastic after: (ζ/s) atan2(s, ζ), s = sqrt(1 − ζ²).

    (ζ/s) ln(ζ + s), s = sqrt(ζ² − 1), where ζ > 1; a series in q = 1/ζ² − 1 where the two meet, good to 1e-12.
    """
    room = (1.0 - ratio) * (1.0 + ratio)
    if abs(room) < 1e-4:
        q = room / (ratio * ratio)
        return 1.0 - q * (1.0 / 3.0 - q / 5.0)
    s = sqrt(abs(room))
    return ratio / s * (atan2(s, ratio) if room > 0.0 else log(ratio + s))


@kernel
def approach_ratio(e):
    """The ζ on [0, inf) with exp[−(ζ/s) atan2(s, ζ)] = e, for e in (0, 1]: that of `speed_lost`.

    Newton's rule from the published approximation, whose e is within 0.007: four rounds at most are needed.
    """
    if e >= 1.0:
        return 0.0
    goal = -log(e)
    ratio = (1.0 - e * e) / (e * (e * (pi - 2.0) + 2.0))
    for _ in range(20):
        room = (1.0 - ratio) * (1.0 + ratio)
        lost = speed_lost(ratio)
        slope = (lost - ratio * ratio) / (ratio * room) if abs(room) >= 1e-4 else 2.0 / 3.0
        change = (goal - lost) / slope
        ratio += change
        if abs(change) <= 1e-9 * ratio:
            break
    return ratio


# With all of the force plastic, K2 = 0, the elastic part gives back δ_y K δ_m / 2 = K δ_m² / 20 of the 0.4 K δ_m²
# that the touch brings. A larger loop would need K2 < 0, which pulls on the way back.
BILINEAR_LOWEST = sqrt(0.05 / 0.4)


@kernel
def bilinear_loop(e):
    """The share Q of K δ_m that is plastic, with which the bilinear law returns e at the speed that gives δ_m.

    x, the deepest penetration over δ_m, is the root above 0.1 of (1 − Q) x² / 2 + Q (x − 0.05) = 0.4, the energy of
    the touch over K δ_m², with the loop Q (x − 0.1) = L = 0.4 (1 − e²); without Q it is a cubic, convex from the
    elastic x = sqrt(0.8) down to the root, so that Newton's rule falls onto it. NaN where Q would be above 1.
    """
    if e < BILINEAR_LOWEST:
        return nan
    lost = 0.4 * (1.0 - e) * (1.0 + e)
    x = sqrt(0.8)
    for _ in range(50):
        value = ((0.5 * x - 0.5 * (0.1 + lost)) * x + lost - 0.4) * x + 0.04 - 0.05 * lost
        change = value / ((1.5 * x - (0.1 + lost)) * x + lost - 0.4)
        x -= change
        if abs(change) <= 1e-15 * x:
            break
    return min(lost / (x - 0.1), 1.0)


def jankowski_exact_damping(self, e, speed, mass):
    """2 ξ sqrt(β m) with ξ = (√5 / 2) ζ(e)."""
    return sqrt(5.0) * approach_ratio(e) * sqrt(self.stiffness * mass)


class KelvinVoigtTensionCutExact(KelvinVoigtTensionCut):
    """Kelvin-Voigt that cannot pull: c = 2 ξ sqrt(k m), exp[−2 (ξ/s) atan2(s, ξ)] = e, s = sqrt(1 − ξ²).

    >>> round(KelvinVoigtTensionCutExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.14994
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        """c = 2 ξ sqrt(k m)."""
        return 2.0 * approach_ratio(sqrt(e)) * sqrt(self.stiffness * mass)


class ModifiedKelvinVoigtExact(ModifiedKelvinVoigt):
    """Dashpot on approach only: c = 2 ξ sqrt(k m), exp[−(ξ/s) atan2(s, ξ)] = e, s = sqrt(1 − ξ²).

    >>> round(ModifiedKelvinVoigtExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.32929
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        """c = 2 ξ sqrt(k m)."""
        return 2.0 * approach_ratio(e) * sqrt(self.stiffness * mass)


class JankowskiExact(Jankowski):
    """Nonlinear viscoelastic: ξ = (√5 / 2) ζ, exp[−(ζ/s) atan2(s, ζ)] = e, s = sqrt(1 − ζ²).

    >>> round(JankowskiExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.36816
    """

    __slots__ = ()
    begin = jankowski_exact_damping


class ViscousElastoplasticExact(ViscousElastoplastic):
    """Viscous elastoplastic with the ξ of `JankowskiExact`: e is achieved where the force stays below F_E.

    >>> round(ViscousElastoplasticExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.36816
    """

    __slots__ = ()
    begin = jankowski_exact_damping


class BilinearExact(Bilinear):
    """Bilinear truss whose loop returns the e asked for: K2 = K (1 − Q), K1 = K2 + 10 K Q, K = β sqrt(δ_m), Q(e).

    δ_m follows each approach speed. Under a given one touches that bring less than K δ_m² / 20 do not yield, whatever
    the loop, so that none returns e at every speed: the loop is NaN then, as it is for e below sqrt(1/8) = 0.354.

    >>> [round(bilinear_loop(e), 5) for e in (0.65, 0.8)]
    [0.38607, 0.20928]
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        """K2, K1 − K2, δ_y, and the place from which the elastic part is measured."""
        fast = max(speed, SLOWEST_TOUCH)
        depth = (1.25 * mass * fast * fast / self.stiffness) ** 0.4
        whole = self.stiffness * sqrt(depth)
        share = bilinear_loop(e) if self.design_penetration == 0.0 else nan
        return whole * (1.0 - share), 10.0 * whole * share, 0.1 * depth, 0.0


# The law that each published law becomes; two are exact as they are.
EXACT: dict[type, type] = {
    KelvinVoigt: KelvinVoigt,
    KelvinVoigtTensionCut: KelvinVoigtTensionCutExact,
    ModifiedKelvinVoigt: ModifiedKelvinVoigtExact,
    HertzDamp: HertzDampExact,
    HertzDampExact: HertzDampExact,
    Jankowski: JankowskiExact,
    Bilinear: BilinearExact,
    ViscousElastoplastic: ViscousElastoplasticExact,
}
