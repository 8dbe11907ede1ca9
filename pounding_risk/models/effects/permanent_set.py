"""Permanent indentations: yielding widens the gap."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.models.effects import bare, effect

ORDER = 20  # inside unloading_stiffness, which acts on its indentations


@effect(reference="plastic penetration with memory; Khatiwada et al. (2011) name gap widening as ignored")
class PermanentSet(NamedTuple):
    """Yielding leaves an indentation: what is pressed in past the elastic penetration at F_E stays and widens the gap.

    Where the motion turns back on the plateau at δ, δ_p = δ − (F_E/β)^(2/3) is added to the gap, and the law goes on
    from δ − δ_p. The indentation takes F_E δ_p. Without viscosity e = v_y / v0, v_y² = 0.8 F_E^(5/3) β^(−2/3) / m. This
    is the memory that the published law lacks; Khatiwada et al. (2011) name the widening of the gap as ignored.
    """

    law: Any

    @classmethod
    def on(cls, law: Any) -> PermanentSet:
        """The law with this memory; raises PoundingError for a law that hardens on its plateau."""
        if getattr(bare(law), "plastic_exponent", 0.0) != 0.0:
            raise PoundingError(
                "permanent_set: van_mier with a plastic_exponent above 0 hardens while it yields, and what it "
                "remembers of that is not published; write plastic_exponent = 0, or remove permanent_set"
            )
        return cls(law)

    def turn(self, memory, delta, strength):
        force = self.law.plateau(delta, strength)
        springs_back = min(self.law.yields_at(force), delta)
        lost = self.law.stored(delta, strength) - self.law.stored(springs_back, inf)
        return memory, delta - springs_back, lost
