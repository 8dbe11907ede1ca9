"""The decorator that registers an effect, and the methods that an effect on a law passes on to the law inside."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import Parameter, signature
from typing import Any

from pounding_risk._common.plugins import Registry
from pounding_risk.models.contact.law import complete, snake_case
from pounding_risk.units import Quantity, QuantityError, exact, parse

EFFECTS = Registry("effects")  # classes by scene-file name, in the order in which they act

PASSED_ON: dict[str, Callable[..., Any]] = {
    "begin": lambda self, e, speed, mass: self.law.begin(e, speed, mass),
    "force": lambda self, memory, delta, rate, approaching: self.law.force(memory, delta, rate, approaching),
    "plateau": lambda self, delta, strength: self.law.plateau(delta, strength),
    "stored": lambda self, delta, strength: self.law.stored(delta, strength),
    "ceiling": lambda self, yield_force: self.law.ceiling(yield_force),
    "floor": lambda self: self.law.floor(),
    "yields_at": lambda self, force: self.law.yields_at(force),
    "hardening": lambda self, speed: self.law.hardening(speed),
    "resume": lambda self, memory, damage: self.law.resume(memory, damage),
    "turn": lambda self, memory, delta, strength: self.law.turn(memory, delta, strength),
    "crushed": lambda self, memory, delta: self.law.crushed(memory, delta),
    "turned": lambda self, memory, delta, approaching: self.law.turned(memory, delta, approaching),
    "damage": lambda self, memory: self.law.damage(memory),
    "held": lambda self, memory, delta, strength: self.law.held(memory, delta, strength),
    "yielded": lambda self, loss: self.law.yielded(loss),
}


class PerInterface(Quantity):
    """An option that is one quantity for all interfaces, or a list with one for each, left to right."""

    __slots__ = ()


def read_option(value: Any, allowed: Quantity, number: Callable[[Any, Quantity], float] = parse) -> Any:
    """The value of an option that is a quantity, in SI: a float, or a tuple of them from a list of a `PerInterface`.

    ``number`` reads one of them: `units.parse` of a file, `units.si` of Python.
    """
    if not (isinstance(allowed, PerInterface) and isinstance(value, (list, tuple))):
        return number(value, allowed)
    if not value:
        raise QuantityError(f'[] is empty; write one value for all interfaces, as "{allowed.example}", or a list')
    return tuple(number(each, allowed) for each in value)


def written_option(value: Any, allowed: Quantity) -> Any:
    """Such a value as a scene file has it: `read_option` turns it into the very same one."""
    return [exact(float(each), allowed) for each in value] if isinstance(value, tuple) else exact(float(value), allowed)


def effect(
    reference: str,
    options: Mapping[str, Any] | None = None,
    needs: tuple[str, ...] = (),
    absent: Mapping[str, str] | None = None,
) -> Callable[[Any], Any]:
    """Make a class an effect that scenes know by its name in snake_case; for use as a decorator.

    A class with a method ``supports`` acts on the ground motion, one with ``built`` on buildings; any other wraps a law
    in its first field ``law``, and passes on every method of the law that it does not have itself. Its class method
    ``on`` makes it from the law, where there is one, and the options; without ``on`` the class itself does.

    Parameters
    ----------
    reference : str
        The source.
    options : mapping of str to Quantity or tuple of str, optional
        What a scene gives: the unit and range of a number, or the words that it may be; a `PerInterface` may be a list
        too, and ``on`` is then given a tuple. One with a default in ``on`` may be left out.
    needs : tuple of str
        Effects that a scene must name too.
    absent : mapping of str to str, optional
        Of an option whose default is NaN: what holds where it is left out.

    Returns
    -------
    callable
        The decorator; it returns the class.
    """

    def register(kind: Any) -> Any:
        name = snake_case(kind.__name__)
        if not hasattr(kind, "on"):
            kind.on = kind
        kind.reference, kind.options, kind.needs, kind.absent = reference, options or {}, needs, absent or {}
        parameters = signature(kind.on).parameters
        kind.optional = tuple(key for key in kind.options if parameters[key].default is not Parameter.empty)
        EFFECTS.enter(name, kind, kind.__module__)
        if hasattr(kind, "supports") or hasattr(kind, "built"):
            return kind
        for method, passed_on in PASSED_ON.items():
            if method not in vars(kind):
                setattr(kind, method, passed_on)
        return complete(kind)

    return register


def acts_on_ground(name: str) -> bool:
    """True for an effect that changes the ground motion and leaves the contact law as it is."""
    return hasattr(EFFECTS[name], "supports")


def acts_on_buildings(name: str) -> bool:
    """True for an effect that changes what stands on the ground, and leaves contact law and motion as they are."""
    return hasattr(EFFECTS[name], "built")


def acts_on_law(name: str) -> bool:
    """True for an effect that wraps the contact law."""
    return not acts_on_ground(name) and not acts_on_buildings(name)


def bare(law: Any) -> Any:
    """The law without its effects."""
    while hasattr(law, "law"):
        law = law.law
    return law
