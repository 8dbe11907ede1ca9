"""Rigid bodies: an instant impulse with restitution, and one structure while pressed together."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

from pounding_risk.models.contact.law import never_yields

ORDER = 10


class Stereomechanical(NamedTuple):
    """Instant impulse: separation speed v1' = e v0, impulse (1 + e) m v0, energy taken (1 − e²) m v0² / 2.

    A train of ever smaller bounces ends in resting contact: the buildings then move as one while they press.

    >>> Stereomechanical().strike(0.65, 1.0, 1.0)
    (0.65, nan, 0.0)
    """

    unused: float = 0.0  # compiled code cannot call a method of a tuple without a field

    reference = "Goldsmith (1960, 2001), Impact: The Theory and Physical Behaviour of Colliding Solids"
    capped, needs_restitution = False, True
    only_in_pairs = ""

    ceiling = never_yields

    def strike(self, e, left, right):
        return e, nan, 0.0


class Merged(NamedTuple):
    """One structure while pressed together: v' = (m1 v1 + m2 v2) / (m1 + m2); parts when F = m (A1 − A2) is tension.

    The touch takes m v0² / 2, the joined motion nothing. No restitution is needed.

    >>> Merged().strike(0.65, 1.0, 1.0)
    (0.0, nan, 0.0)
    """

    unused: float = 0.0  # compiled code cannot call a method of a tuple without a field

    reference = "Chouw (2002), Influence of soil-structure interaction on pounding response of adjacent buildings"
    capped, needs_restitution = False, False
    only_in_pairs = ""

    ceiling = never_yields

    def strike(self, e, left, right):
        return 0.0, nan, 0.0
