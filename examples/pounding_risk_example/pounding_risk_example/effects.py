"""An effect on contact: `weathered = {share = 0.8}` in `[effects]` of a scene."""

from typing import Any, NamedTuple

from pounding_risk.models.effects import effect
from pounding_risk.units import Quantity

SHARE = Quantity("1", 0.0, 1.0, "remaining share of the yield force", open_low=True, example="0.8")


@effect(reference="an example, no measurement", options={"share": SHARE})
class Weathered(NamedTuple):
    """Deteriorated concrete: the yield force is F_E × share in every contact."""

    law: Any
    share: float

    def hardening(self, speed):
        return self.share * self.law.hardening(speed)
