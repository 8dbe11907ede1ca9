"""The contact force as a method without events sees it: from penetration and its rate at one instant."""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk._jit.compile import small


class Contact(NamedTuple):
    """What stays the same during one step of a fixed-step method."""

    gap: float  # m
    strength: float  # force at which the law yields, inf without a cap [N]
    least: float  # smallest force, −inf where tension is not cut [N]
    memory: float  # damping constant of this contact; NaN while the buildings are apart


@small
def uncapped_force(law, contact, delta, rate):
    """The law's force without cap or cut [N]; nothing when apart."""
    return law.force(contact.memory, delta, rate, rate > 0.0) if delta > 0.0 else 0.0


@small
def contact_force(law, contact, delta, rate):
    """The force that the buildings feel [N]: at most the law's plateau, never below its floor."""
    force = uncapped_force(law, contact, delta, rate)
    if force > contact.strength:
        return law.plateau(delta, contact.strength)
    return contact.least if force < contact.least else force
