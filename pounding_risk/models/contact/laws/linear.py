"""The linear spring."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pounding_risk.models.contact.law import LINEAR_STIFFNESS, flat, linear_energy, may_pull, never_yields, undamped

ORDER = 10


class Linear(NamedTuple):
    """Linear spring: F = k δ. Elastic, e = 1; peak force v0 sqrt(k m), duration π sqrt(m/k).

    >>> Linear(1e8).force(0.0, 0.01, 1.0, True)
    1000000.0

    Parameters
    ----------
    stiffness : float
        Contact stiffness k [N/m].
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "linear spring"
    capped = False
    needs_restitution = False

    begin = undamped

    def force(self, memory, delta, rate, approaching):
        return self.stiffness * delta

    plateau = flat
    stored = linear_energy
    ceiling = never_yields
    floor = may_pull
