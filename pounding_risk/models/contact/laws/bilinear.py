"""The bilinear truss: a force-penetration loop in place of a damper."""

from __future__ import annotations

from math import inf, nan, sqrt
from typing import Annotated, NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.models.contact.law import HERTZ_STIFFNESS, SLOWEST_TOUCH, flat, may_pull, never_yields
from pounding_risk.units import Quantity

ORDER = 40
DESIGN_PENETRATION = Quantity(
    "m", 0.0, inf, "design penetration δ_m of the bilinear law", open_high=True, example="10 mm"
)
# With all of the force plastic, K2 = 0, the elastic part gives back δ_y K δ_m / 2 = K δ_m² / 20 of the 0.4 K δ_m²
# that the touch brings. A larger loop would need K2 < 0, which pulls on the way back.
BILINEAR_LOWEST = sqrt(0.05 / 0.4)


@small
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


class Bilinear(NamedTuple):
    """Bilinear truss: K1 up to δ_y, then K2; back along K1 and K2 through the origin. The loop is the loss, no damper.

    With K = β sqrt(δ_m), E = β δ_m^2.5 (1 − e²) / 2.5, δ_y = 0.1 δ_m: K1 = K + E / (0.1 δ_m²), K2 = K − E / (0.9 δ_m²),
    so that the force at δ_m is K δ_m and the loop to δ_m takes E. The e achieved is larger than the e asked for,
    sqrt((1 − q) / (1 + q)), q = 0.4 (1 − e²), at δ_m, and depends on how far δ goes. δ_m = 0 stands for the
    penetration of a Hertz spring at this approach speed, (1.25 m v0² / β)^0.4; then e is the same at any speed.

    >>> round(Bilinear(1e9, 0.01).force(Bilinear(1e9, 0.01).begin(1.0, 1.0, 1.0), 0.005, 0.0, True))
    500000
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]
    design_penetration: Annotated[float, DESIGN_PENETRATION] = 0.0

    reference = "Muthukumar and DesRoches (2006); OpenSees ImpactMaterial for the form"
    capped, needs_restitution = False, True

    def begin(self, e, speed, mass):
        depth = self.design_penetration
        if depth == 0.0:
            fast = max(speed, SLOWEST_TOUCH)
            depth = (1.25 * mass * fast * fast / self.stiffness) ** 0.4
        whole = self.stiffness * sqrt(depth)
        loop = self.stiffness * depth**2.5 * (1.0 - e * e) / 2.5
        yields_at = 0.1 * depth
        steep = loop / (yields_at * depth) + loop / ((depth - yields_at) * depth)  # K1 − K2
        # K2, K1 − K2, δ_y, and the δ from which the elastic part is measured.
        return whole - loop / ((depth - yields_at) * depth), steep, yields_at, 0.0

    def force(self, memory, delta, rate, approaching):
        flat, steep, yields_at, anchor = memory
        return flat * delta + steep * min(max(delta - anchor, 0.0), yields_at)

    def turned(self, memory, delta, approaching):
        flat, steep, yields_at, anchor = memory
        anchor = max(anchor, delta - yields_at) if approaching else min(anchor, delta)
        return flat, steep, yields_at, anchor

    def knee(self, memory, approaching):
        _, steep, yields_at, anchor = memory
        if approaching:
            return anchor + yields_at if steep != 0.0 else inf
        return anchor if anchor > 0.0 else inf

    plateau = flat

    def stored(self, delta, strength):
        depth = self.design_penetration
        return 0.5 * self.stiffness * sqrt(max(depth, delta)) * delta * delta

    def held(self, memory, delta, strength):
        flat, steep, yields_at, anchor = memory
        elastic = min(max(delta - anchor, 0.0), yields_at)
        return 0.5 * (flat * delta * delta + steep * elastic * elastic)

    def yielded(self, loss):
        return loss

    ceiling, floor = never_yields, may_pull


class BilinearExact(Bilinear):
    """Bilinear truss whose loop returns the e asked for: K2 = K (1 − Q), K1 = K2 + 10 K Q, K = β sqrt(δ_m), Q(e).

    δ_m follows each approach speed. Under a given one touches that bring less than K δ_m² / 20 do not yield, whatever
    the loop, so that none returns e at every speed: the loop is NaN then, as it is for e below sqrt(1/8) = 0.354.

    >>> [round(bilinear_loop(e), 5) for e in (0.65, 0.8)]
    [0.38607, 0.20928]
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        fast = max(speed, SLOWEST_TOUCH)
        depth = (1.25 * mass * fast * fast / self.stiffness) ** 0.4
        whole = self.stiffness * sqrt(depth)
        share = bilinear_loop(e) if self.design_penetration == 0.0 else nan
        return whole * (1.0 - share), 10.0 * whole * share, 0.1 * depth, 0.0

    @staticmethod
    def out_of_reach(e: float, design_penetration: float) -> str:
        """A sentence where this e cannot be returned, under this design penetration [m]; "" where it can."""
        if design_penetration > 0.0:
            return (
                "bilinear with a design_penetration of its own returns another e at every approach speed, and no loop "
                "the one asked for; remove design_penetration, which then follows each approach speed, "
                'or write relation = "published"'
            )
        if e < BILINEAR_LOWEST:
            return (
                f"bilinear returns no e below {BILINEAR_LOWEST:.3f} without pulling, and {e:g} is asked for; "
                'write a larger e, or relation = "published"'
            )
        return ""


EXACT = {Bilinear: BilinearExact}
