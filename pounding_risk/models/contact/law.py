"""What a contact law is to the kernels, and the methods and units that several laws share.

A law is a NamedTuple whose fields are its parameters and whose methods are its physics. A kernel never asks which law
it has: it says ``law.force(...)``. A law must have the methods of `ContactLaw`; those of `PathDependence` it has by
default.

Symbols: δ penetration [m, > 0 in contact], δ̇ its rate [m/s, > 0 on approach], F force [N, > 0 compression],
k stiffness [N/m], β stiffness [N/m^1.5], m = m1 m2 / (m1 + m2), v0 approach speed at the touch, e restitution.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, sqrt
from typing import Any, Protocol, get_type_hints

from pounding_risk._jit.compile import kernel, speaks
from pounding_risk.units import Quantity

LINEAR_STIFFNESS = Quantity("N/m", 0.0, inf, "contact stiffness k", open_low=True, open_high=True)
HERTZ_STIFFNESS = Quantity("N/m^1.5", 0.0, inf, "impact stiffness β", open_low=True, open_high=True)

# Laws that divide by v0 have no value for a touch from rest. Slower touches than this count as this fast; the
# published fits of restitution start some hundred times higher.
SLOWEST_TOUCH = 1e-4  # m/s


@speaks
class ContactLaw(Protocol):
    """The methods that every law has."""

    def begin(self, e, speed, mass):
        """What this contact remembers of its start: a damping constant."""

    def force(self, memory, delta, rate, approaching):
        """Force without any cap; smooth in (δ, δ̇) for a given ``approaching``."""

    def plateau(self, delta, strength):
        """Force transmitted while the uncapped force exceeds ``strength``."""

    def stored(self, delta, strength):
        """Energy that comes back if the bodies part slowly from δ [J]."""

    def ceiling(self, yield_force):
        """The force at which the law yields: ``yield_force``, or infinity for a law without a cap."""

    def floor(self):
        """The smallest force: 0 where tension is cut, minus infinity otherwise."""


@speaks
class PathDependence(Protocol):
    """The further methods of a law whose force depends on its path; `complete` gives the others a default."""

    def yields_at(self, force):
        """Penetration at which the elastic force reaches ``force``; only capped laws have it [m]."""

    def hardening(self, speed):
        """Factor on the yield force of a contact that begins at this approach speed."""

    def resume(self, memory, damage):
        """The contact's memory where earlier contacts of the run have left ``damage`` behind; 0 is nothing."""

    def turn(self, memory, delta, strength):
        """The motion turns back on the plateau: (memory, indentation, energy lost); one below zero retraces it."""

    def crushed(self, memory, delta):
        """The motion turns back below any plateau: (memory, indentation, energy lost), as `turn`."""

    def turned(self, memory, delta, approaching):
        """The contact's memory once the motion has turned at δ; ``approaching`` is how it moved before."""

    def knee(self, memory, approaching):
        """The penetration ahead at which the slope of the force jumps, as the motion goes since it turned [m]."""

    def damage(self, memory):
        """What a contact leaves behind for those after it."""

    def held(self, memory, delta, strength):
        """As ``stored``, for a law whose memory changes its spring [J]."""

    def yielded(self, loss):
        """The part of a contact's loss that its hysteresis takes, and no damper [J]."""

    def conserves(self):
        """True where nothing but indentations takes energy: what else is missing after a contact is rounding."""


# Defaults of `PathDependence`.
DEFAULTS: dict[str, Callable[..., Any]] = {
    "hardening": lambda self, speed: 1.0,  # none
    "resume": lambda self, memory, damage: memory,  # earlier contacts do not count
    "turn": lambda self, memory, delta, strength: (memory, -1.0, 0.0),  # the plateau is retraced, nothing is lost
    "crushed": lambda self, memory, delta: (memory, -1.0, 0.0),  # what is pressed in springs back
    "turned": lambda self, memory, delta, approaching: memory,
    "knee": lambda self, memory, approaching: inf,  # none
    "damage": lambda self, memory: 0.0,  # nothing
    "held": lambda self, memory, delta, strength: self.stored(delta, strength),
    "yielded": lambda self, loss: 0.0,  # all loss is the damper's
    "conserves": lambda self: False,
}


def complete(law: type) -> type:
    """Give a law the methods of `PathDependence` that it neither has nor inherits."""
    for name, default in DEFAULTS.items():
        if not hasattr(law, name):
            setattr(law, name, default)
    if "conserves" not in vars(law) and {"begin", "force"} & vars(law).keys():
        # What a class inherits was said of another force.
        setattr(law, "conserves", DEFAULTS["conserves"])  # noqa: B010
    return law


def is_path_dependent(law: type) -> bool:
    """True for a law whose force depends on its path, which methods that know δ and δ̇ alone cannot follow."""
    return any(getattr(law, verb, DEFAULTS[verb]) is not DEFAULTS[verb] for verb in ("turned", "crushed"))


def snake_case(name: str) -> str:
    """Scene-file name of a class: ``HertzDampExact`` is ``hertz_damp_exact``."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


def stiffness_quantity(law: type) -> Quantity:
    """Unit and bounds of a law's stiffness, as stated beside its field."""
    return get_type_hints(law, include_extras=True)["stiffness"].__metadata__[0]


# Methods that several laws share; a law takes them by name, as in ``plateau = flat``.


def undamped(self, e, speed, mass):
    """``begin`` of a law without damping: 0."""
    return 0.0


def without_damper(self):
    """``conserves`` of a law whose force follows from δ alone: True."""
    return True


def flat(self, delta, strength):
    """``plateau`` of a law that is ideally plastic: the yield force."""
    return strength


def never_yields(self, yield_force):
    """``ceiling`` of a law without a cap: infinity."""
    return inf


def capped_at_yield(self, yield_force):
    """``ceiling`` of a law with a cap: the yield force."""
    return yield_force


def may_pull(self):
    """``floor`` of a law whose force is not cut at zero: minus infinity."""
    return -inf


def linear_energy(self, delta, strength):
    """``stored`` of a linear spring: k δ² / 2."""
    return 0.5 * self.stiffness * delta * delta


@kernel
def hertz_work(stiffness, delta):
    """∫ β x^1.5 dx from 0 to δ = 0.4 β δ^2.5."""
    return 0.4 * stiffness * delta * delta * sqrt(delta)


def hertz_energy(self, delta, strength):
    """``stored`` of a Hertz spring: 0.4 β δ^2.5."""
    return hertz_work(self.stiffness, delta)


def hertz_force(self, memory, delta, rate, approaching):
    """``force`` of a Hertz spring: β δ^1.5."""
    return self.stiffness * (delta * sqrt(delta))


def hertz_yields_at(self, force):
    """``yields_at`` of a Hertz spring: (F / β)^(2/3)."""
    return (force / self.stiffness) ** (2.0 / 3.0)
