"""Contact models without a force-penetration law: the velocities jump at the touch, and nothing penetrates.

A module here is found by its file, as a law is: see `pounding_risk.models.contact.laws`. A model is a NamedTuple like a
law, with a method ``strike`` of its own. Kernels see by its type that it has one, so that the laws of force compile to
code that knows nothing of jumps.

    v1' = v1 − (1 + e) (v1 − v2) m2 / (m1 + m2),   v2' = v2 + (1 + e) (v1 − v2) m1 / (m1 + m2)

Where the buildings press on each other once the rebound has gone, they move as one structure:

    F = m (A1 − A2),   m = m1 m2 / (m1 + m2),   A the acceleration that each building would have alone,

and part when F would be tension. In a row of single masses several touches at one instant are resolved together, by
Newton's restitution at all closed interfaces (theory of rows); distributed_mass is for pairs.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from pounding_risk._jit.compile import speaks
from pounding_risk.models._discovery import classes_of, documented, modules_in_order
from pounding_risk.models.contact.law import snake_case
from pounding_risk.models.contact.laws import LAWS


@speaks
class InstantLaw(Protocol):
    """What the kernels ask of a contact model without a force-penetration law."""

    def strike(self, e, left, right):
        """What a touch is like where the restitution relation gives ``e``, between inverse masses (0 is rigid).

        Returns (separation speed over approach speed, largest force over approach speed [N s/m], duration [s]). The
        force is NaN where the impulse has no duration.
        """


INSTANT_LAWS: dict[str, type] = {
    snake_case(name): documented(law)
    for module in modules_in_order(__name__)
    for name, law in classes_of(module).items()
    if "strike" in vars(law)
}
globals().update({law.__name__: law for law in INSTANT_LAWS.values()})
LAWS.reserve(INSTANT_LAWS)
# Everything that a scene may name, a user's own laws included: the laws of force first.
CONTACT_MODELS: Mapping[str, type] = ChainMap(INSTANT_LAWS, LAWS)

if TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """The classes of the modules, by name."""


def is_instant(law: object) -> bool:
    """True for a model, or its class, whose velocities jump; it has no stiffness."""
    return hasattr(law, "strike")


def only_in_pairs(law: object) -> str:
    """Why a model whose velocities jump, or its class, is not for rows of single masses; "" where it is.

    One for rows has ``only_in_pairs = ""``; its separation speed is in proportion to e, and it has no finite force.
    """
    return getattr(law, "only_in_pairs", "nothing says how several of its touches at one instant go together")


def needs_floors(law: object) -> bool:
    """True for a model, or its class, that collides floors: it has a length of each, and a finite force."""
    return is_instant(law) and hasattr(law, "between")
