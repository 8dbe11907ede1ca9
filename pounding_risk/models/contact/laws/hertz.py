"""The Hertz spring, alone and with damping in proportion to its force."""

from __future__ import annotations

from math import log, sqrt
from typing import Annotated, NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.models.contact.law import (
    HERTZ_STIFFNESS,
    SLOWEST_TOUCH,
    flat,
    hertz_energy,
    hertz_force,
    may_pull,
    never_yields,
    undamped,
    without_damper,
)

ORDER = 20


@small
def exact_hertz_damping(e):
    """The d on (0, 1/e) with exp[d (1 + e)] = (1 + d) / (1 − d e): then e is achieved, whatever the exponent.

    Newton's rule on g(d) = d (1 + e) + ln(1 − d e) − ln(1 + d), kept inside a bracket; g > 0 left of the root. Near
    e = 1, where g is all rounding, the root's series in 1 − e, good to 1e-15.
    """
    lost = 1.0 - e
    if lost < 1e-3:
        return lost * (1.5 + lost * (1.5 + lost * (1.35 + lost * 1.2)))
    low, high = 0.0, 1.0 / e
    d = min(1.6 * (1.0 - e) / e, 0.999 / e)
    for _ in range(200):
        room = 1.0 - d * e
        value = d * (1.0 + e) + log(room) - log(1.0 + d) if room > 0.0 else -1.0
        if value > 0.0:
            low = d
        else:
            high = d
        slope = 1.0 + e - e / room - 1.0 / (1.0 + d) if room > 0.0 else 0.0
        new = d - value / slope if slope < 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - d) <= 1e-15 * d:
            break
        d = new
    return d


def hertz_damp_force(self, memory, delta, rate, approaching):
    """β δ^1.5 (1 + (d / v0) δ̇)."""
    return self.stiffness * (delta * sqrt(delta)) * (1.0 + memory * rate)


class Hertz(NamedTuple):
    """Hertz spring: F = β δ^1.5. Elastic, e = 1; peak force β^(2/5) (1.25 m v0²)^(3/5).

    >>> Hertz(1e9).force(0.0, 0.01, 1.0, True)
    1000000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Hertz (1881); Goldsmith (2001), Impact"
    capped, needs_restitution = False, False

    begin, force, plateau, stored, ceiling, floor = undamped, hertz_force, flat, hertz_energy, never_yields, may_pull
    conserves = without_damper


class HertzDamp(NamedTuple):
    """Hertz spring with penetration-proportional damping: F = β δ^1.5 (1 + d δ̇/v0), d = 0.75 (1 − e²).

    The published d is far too small below e = 0.8: 0.65 asked for gives 0.775.

    >>> HertzDamp(1e9).force(0.5, 0.01, 1.0, True)
    1500000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Muthukumar and DesRoches (2006), Earthquake Engineering and Structural Dynamics 35"
    capped, needs_restitution = False, True

    def begin(self, e, speed, mass):
        return 0.75 * (1.0 - e * e) / max(speed, SLOWEST_TOUCH)

    force, plateau, stored, ceiling, floor = hertz_damp_force, flat, hertz_energy, never_yields, may_pull


class HertzDampExact(NamedTuple):
    """Hertz-damp with the d that returns the e asked for: exp[d (1 + e)] = (1 + d) / (1 − d e).

    >>> round(HertzDampExact(1e9).begin(0.65, 1.0, 1.0), 5)
    0.7931
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Hunt and Crossley form; exact d by separation of variables; Ye, Li and Zhu (2009) for the need"
    capped, needs_restitution = False, True

    def begin(self, e, speed, mass):
        return exact_hertz_damping(e) / max(speed, SLOWEST_TOUCH)

    force, plateau, stored, ceiling, floor = hertz_damp_force, flat, hertz_energy, never_yields, may_pull


EXACT = {HertzDamp: HertzDampExact, HertzDampExact: HertzDampExact}
