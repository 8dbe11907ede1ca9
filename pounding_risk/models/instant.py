"""Contact models without a force-penetration law: the velocities jump at the touch, and nothing penetrates.

A model is a NamedTuple like the laws of `contact`, with one verb of its own, ``rebound``. Kernels see by its type that
it has this verb, so that the laws of `contact` compile to code that knows nothing of jumps. All of its verbs together
are those that a grid asks of any law, and ``rebound``.

    v1' = v1 − (1 + e) (v1 − v2) m2 / (m1 + m2),   v2' = v2 + (1 + e) (v1 − v2) m1 / (m1 + m2)

Where the buildings press on each other once the rebound has gone, they move as one structure:

    F = m (A1 − A2),   m = m1 m2 / (m1 + m2),   A the acceleration that each building would have alone,

and part when F would be tension.
"""

from __future__ import annotations

import inspect
import sys
from collections import ChainMap
from collections.abc import Mapping
from typing import NamedTuple, Protocol

from pounding_risk._jit import speaks
from pounding_risk.models.contact import LAWS, never_yields, snake_case


@speaks
class InstantLaw(Protocol):
    """What the kernels ask of a contact model without a force-penetration law."""

    def rebound(self, e):
        """Separation speed after the touch over approach speed, where the restitution relation gives ``e``."""


class Stereomechanical(NamedTuple):
    """Instant impulse: separation speed v1' = e v0, impulse (1 + e) m v0, energy taken (1 − e²) m v0² / 2.

    A train of ever smaller bounces ends in resting contact: the buildings then move as one while they press.

    >>> Stereomechanical().rebound(0.65)
    0.65
    """

    blank: float = 0.0  # no parameter: compiled code cannot call a method of a tuple without a field

    reference = "Goldsmith (1960, 2001), Impact: The Theory and Physical Behaviour of Colliding Solids"
    capped = False
    needs_restitution = True

    ceiling = never_yields

    def rebound(self, e):
        return e


class Merged(NamedTuple):
    """One structure while pressed together: v' = (m1 v1 + m2 v2) / (m1 + m2); parts when F = m (A1 − A2) is tension.

    The touch takes m v0² / 2, the joined motion nothing. No restitution is needed.

    >>> Merged().rebound(0.65)
    0.0
    """

    blank: float = 0.0  # no parameter: compiled code cannot call a method of a tuple without a field

    reference = "Chouw (2002), Influence of soil-structure interaction on pounding response of adjacent buildings"
    capped = False
    needs_restitution = False

    ceiling = never_yields

    def rebound(self, e):
        return 0.0


def _instant_laws() -> dict[str, type]:
    members = vars(sys.modules[__name__]).items()
    return {
        snake_case(name): member
        for name, member in members
        if inspect.isclass(member) and issubclass(member, tuple) and "rebound" in vars(member)
    }


INSTANT_LAWS: dict[str, type] = _instant_laws()
# Everything that a scene may name, a user's own laws included: those of `contact` first.
CONTACT_MODELS: Mapping[str, type] = ChainMap(INSTANT_LAWS, LAWS)


def is_instant(law: object) -> bool:
    """True for a model, or its class, whose velocities jump; it has no stiffness."""
    return hasattr(law, "rebound")
