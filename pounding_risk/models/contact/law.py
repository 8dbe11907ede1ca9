"""What a contact law may remember: verbs that a law without memory need not say."""

from __future__ import annotations

from typing import Protocol

from pounding_risk._jit.compile import speaks


@speaks
class Remembers(Protocol):
    """What the kernels also ask of a law, and what `complete` gives to one that does not say it: no memory."""

    def yields_at(self, force):
        """Penetration at which the elastic force reaches ``force``; only capped laws have it [m]."""

    def hardening(self, speed):
        """Factor on the yield force of a contact that begins at this approach speed."""

    def resume(self, memory, worn):
        """The contact's memory where earlier contacts of the run have left ``worn`` behind; 0 is nothing."""

    def turn(self, memory, delta, strength):
        """The motion turns back on the plateau: (memory, dent, energy lost); a dent below zero retraces the plateau."""

    def turned(self, memory, delta, approaching):
        """The contact's memory once the motion has turned at δ; ``approaching`` is how it moved before."""

    def worn(self, memory):
        """What a contact leaves behind for those after it."""

    def held(self, memory, delta, strength):
        """As ``stored``, for a law whose memory changes its spring [J]."""

    def yielded(self, loss):
        """The part of a contact's loss that its hysteresis takes, and no damper [J]."""


# What a law does that does not say otherwise.


def keeps_its_strength(self, speed):
    """No hardening."""
    return 1.0


def starts_anew(self, memory, worn):
    """Earlier contacts do not count."""
    return memory


def retraces(self, memory, delta, strength):
    """The plateau is retraced: nothing stays, nothing is lost."""
    return memory, -1.0, 0.0


def goes_on(self, memory, delta, approaching):
    """Turning changes nothing but the branch."""
    return memory


def damps(self, loss):
    """All loss is the damper's."""
    return 0.0


def leaves_nothing(self, memory):
    """Nothing for later contacts."""
    return 0.0


def holds(self, memory, delta, strength):
    """What is stored, whatever is remembered."""
    return self.stored(delta, strength)


DEFAULTS = {
    "hardening": keeps_its_strength,
    "resume": starts_anew,
    "turn": retraces,
    "turned": goes_on,
    "worn": leaves_nothing,
    "held": holds,
    "yielded": damps,
}


def complete(law: type) -> type:
    """Give a law the verbs of `Remembers` that it neither says nor inherits."""
    for verb, default in DEFAULTS.items():
        if not hasattr(law, verb):
            setattr(law, verb, default)
    return law


def remembers(law: type) -> bool:
    """True for a law whose force depends on its path, which methods that know δ and δ̇ alone cannot follow."""
    return getattr(law, "turned", goes_on) is not goes_on
