"""The model of merged buildings: one structure while pressed together."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

from pounding_risk.models.contact.law import never_yields

ORDER = 20


class Merged(NamedTuple):
    """One structure while pressed together: v' = (m1 v1 + m2 v2) / (m1 + m2); parts when F = m (A1 − A2) is tension.

    The touch takes m v0² / 2, the joined motion nothing. No restitution is needed.

    >>> Merged().strike(0.65, 1.0, 1.0)
    (0.0, nan, 0.0)

    Parameters
    ----------
    blank : float
        Not used.
    """

    blank: float = 0.0  # compiled code cannot call a method of a tuple without a field

    reference = "Chouw (2002), Influence of soil-structure interaction on pounding response of adjacent buildings"
    capped = False
    needs_restitution = False

    ceiling = never_yields

    def strike(self, e, left, right):
        return 0.0, nan, 0.0
