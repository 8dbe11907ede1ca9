"""Contact laws: the force between two buildings as a function of penetration and its rate. One module a law or family.

A module here is found by its file. It holds the classes of its laws, each with formula, parameters, source and
example; ``ORDER``, its place in tables and grids; in ``EXACT`` the class that each law becomes under the exact relation
of damping to restitution; in ``RESTITUTION_OF_RATIO``, where the law is published with a damping ratio ξ, the function
that gives e from ξ and the largest ξ, 1 itself excluded. Commands, conformance tests and docs find them in `LAWS`.

A law of the user's own takes its units and shared methods from here too: `pounding_risk.contact_law` registers it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pounding_risk._common.plugins import Registry
from pounding_risk.models._discovery import classes_of, documented, modules_in_order
from pounding_risk.models.contact.law import *  # noqa: F403 - what a law of the user's own takes
from pounding_risk.models.contact.law import ContactLaw, complete, snake_case

LAWS = Registry("laws")  # classes by scene-file name; a user's own are added as they are defined
EXACT: dict[type, type] = {}  # the class that a law becomes under the exact relation; some are exact as they are
RESTITUTION_OF_RATIO: dict[str, tuple[Callable[[float], float], float]] = {}

_REQUIRED = [name for name in vars(ContactLaw) if not name.startswith("_")]

for _module in modules_in_order(__name__):
    _classes = classes_of(_module)
    globals().update(_classes)
    # The exact form of a law inherits its methods, and has no name of its own in a scene.
    for _name, _law in _classes.items():
        if all(method in vars(_law) for method in _REQUIRED):
            LAWS.enter(snake_case(_name), documented(complete(_law)), __name__)
    EXACT |= getattr(_module, "EXACT", {})
    RESTITUTION_OF_RATIO |= {
        snake_case(law.__name__): inverse for law, inverse in getattr(_module, "RESTITUTION_OF_RATIO", {}).items()
    }

SHIPPED = tuple(LAWS.members)

if TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """The classes of the modules, by name."""
