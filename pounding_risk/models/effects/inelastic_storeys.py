"""Storeys that yield."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from pounding_risk.models.effects import effect
from pounding_risk.units import Quantity

ORDER = 50  # the first on buildings: p_delta takes its part off the stiffness of the yielding storey
HARDENING = Quantity("1", 0.0, 1.0, "stiffness past yield over that before", open_high=True, example="0.03")


@effect("bilinear hysteresis with kinematic hardening; Prager (1956) for the rule", {"hardening": HARDENING})
@dataclass(frozen=True)
class InelasticStoreys:
    """Storeys yield: bilinear hysteresis between drift and storey shear, with kinematic hardening.

    V = k d up to the storey's yield shear V_y, past it with the slope ``hardening`` × k (0.03 if not given); after a
    turn the storey is elastic over 2 V_y. Storeys of a building with `hysteresis` follow its rule instead. A storey
    without a yield shear stays elastic, as a single mass does.
    What P-Δ takes off the stiffness acts beside the hysteresis, so that a yielding storey may have less than none left.
    Isolators yield by their own numbers, with this effect and without.
    """

    hardening: float = 0.03

    def built(self, chain: Any, building: Any) -> Any:
        """The chain whose storeys yield at the building's strengths."""
        if not building.strengths:
            return chain
        yielding, law = chain.yielding(building.strengths, self.hardening), building.hysteresis
        if law is None:
            return yielding
        heights = building.heights if building.isolators is None else building.heights[1:]
        return yielding.by_laws(replace(law, hardening=self.hardening), heights)
