"""A contact law: `contact_model = "hunt_crossley"` in a scene."""

from math import sqrt
from typing import Annotated, NamedTuple

import pounding_risk as pr
from pounding_risk.models.contact import laws as contact


@pr.contact_law
class HuntCrossley(NamedTuple):
    """Hertz spring with damping: F = β δ^1.5 (1 + d δ̇ / v0), d = 1.5 (1 − e)."""

    stiffness: Annotated[float, contact.HERTZ_STIFFNESS]
    capped, needs_restitution = False, True
    reference = "Hunt and Crossley (1975), Journal of Applied Mechanics 42"

    def begin(self, e, speed, mass):
        return 1.5 * (1.0 - e) / max(speed, contact.SLOWEST_TOUCH)

    def force(self, memory, delta, rate, approaching):
        return self.stiffness * delta * sqrt(delta) * (1.0 + memory * rate)

    plateau, stored, ceiling, floor = contact.flat, contact.hertz_energy, contact.never_yields, contact.may_pull
