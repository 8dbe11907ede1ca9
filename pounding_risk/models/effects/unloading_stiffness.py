"""Another contact stiffness after yielding."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from pounding_risk.models.effects import effect
from pounding_risk.units import Quantity

ORDER = 30  # around permanent_set, whose indentations it changes
RATIO = Quantity("1", 0.0, inf, "ratio of unloading to loading stiffness", open_low=True, open_high=True, example="1.5")


@effect(
    reference="stiffness after yielding; Khatiwada et al. (2011) name it as altered by chipping, spalling and dents",
    options={"ratio": RATIO},
    needs=("permanent_set",),
)
class UnloadingStiffness(NamedTuple):
    """After yielding the contact is stiffer or softer: ratio × β while it unloads and in all contacts after it.

    Unloading starts at the force of the plateau, so that δ_p = δ − (F_E / (ratio β))^(2/3); where a soft contact
    would spring back by more than δ, it springs back by δ with the stiffness that takes. Acts on what
    `PermanentSet` leaves. Khatiwada et al. (2011) name both as changed by chipping, spalling and dents.
    """

    law: Any
    ratio: float

    # The memory is that of the law inside and the factor on its spring.

    def begin(self, e, speed, mass):
        return self.law.begin(e, speed, mass), 1.0

    def resume(self, memory, damage):
        return self.law.resume(memory[0], damage), damage if damage > 0.0 else 1.0

    def force(self, memory, delta, rate, approaching):
        spring = self.law.force(memory[0], delta, 0.0, False)
        return self.law.force(memory[0], delta, rate, approaching) + (memory[1] - 1.0) * spring

    def turn(self, memory, delta, strength):
        force = self.law.plateau(delta, strength)
        springs_back = min(self.law.yields_at(force / self.ratio), delta)
        factor = force / self.law.force(memory[0], springs_back, 0.0, False)
        lost = self.held(memory, delta, strength) - factor * self.law.stored(springs_back, inf)
        return (memory[0], factor), delta - springs_back, lost

    def crushed(self, memory, delta):
        inside, indentation, lost = self.law.crushed(memory[0], delta)
        return (inside, memory[1]), indentation, lost

    def turned(self, memory, delta, approaching):
        return self.law.turned(memory[0], delta, approaching), memory[1]

    def knee(self, memory, approaching):
        return self.law.knee(memory[0], approaching)

    def held(self, memory, delta, strength):
        yields_at = self.law.yields_at(strength / memory[1])
        if not delta > yields_at:
            return memory[1] * self.law.stored(delta, inf)
        return memory[1] * self.law.stored(yields_at, inf) + strength * (delta - yields_at)

    def damage(self, memory):
        return memory[1] if memory[1] != 1.0 else 0.0
