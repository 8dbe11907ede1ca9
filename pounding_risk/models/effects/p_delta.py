"""Weight of the floors on leaning storeys."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.models.effects import effect
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.units import STANDARD_GRAVITY

ORDER = 60  # before soil_flexibility: the foundation below has no storey height


@effect("Wilson and Habibullah (1987), Earthquake Spectra 3: storey geometric stiffness P / h")
@dataclass(frozen=True)
class PDelta:
    """Weight pushes a leaning storey further: the storey's stiffness is less by P / h.

    P is the weight of all floors above the storey, h its height. The damping stays that of the building without it. A
    building whose storey has no stiffness left would fall over, and is refused. Isolators are given with the weight on
    them: their stiffness stays. Where storeys that yield have none left past it, all of the building follow the rule
    ``kinematic`` of `hysteresis`, the same law, which reports a storey that has collapsed.
    """

    def built(self, chain: Any, building: Any) -> Any:
        """The softened chain; raises PoundingError for a building without a height."""
        if not building.heights:
            raise PoundingError(
                f"p_delta: {building.name} has no height, and P / h needs it; "
                'write height = "12 m" in its [[building]], or remove p_delta'
            )
        above = reversed(list(accumulate(reversed(chain.mass[: chain.floors].tolist()))))
        weights = [STANDARD_GRAVITY * mass for mass in above]
        geometric = [weight / height for weight, height in zip(weights, building.heights, strict=True)]
        heights = building.heights
        if getattr(building, "isolators", None):
            geometric[0], heights = 0.0, heights[1:]
        softened = chain.softened(geometric)
        past_yield = chain.hardening * chain.shear
        falls = past_yield[: chain.floors] < geometric
        if chain.laws.size or not np.any(np.isfinite(chain.strength[: chain.floors]) & falls):
            return softened
        hardening = float(np.broadcast_to(chain.hardening, chain.mass.size)[-1])  # the first may be that of isolators
        return softened.by_laws(Hysteresis("kinematic", hardening=hardening), heights)
