"""Effects: what a scene may add to its contact law, to the ground motion under it, or to its buildings.

A module here is found by its file, and holds one effect: a class with its options, source and formula, made known by
the decorator `effect`; and ``ORDER``, its place among the effects. They act in that order, whatever the order in a
scene. An effect of yielding wraps a law and changes some of its methods; one of the ground gives each building a motion
of its own; one of buildings changes their storeys or what they stand on. A scene without effects hands the kernels the
bare law on level ground, so that an effect that is not named is not in the machine code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import Parameter, signature
from math import isnan
from typing import TYPE_CHECKING, Any

from pounding_risk._common.plugins import Registry
from pounding_risk.errors import PoundingError
from pounding_risk.models._discovery import modules_in_order
from pounding_risk.models.contact.law import complete, snake_case
from pounding_risk.models.ground import SHARED, Support
from pounding_risk.units import Quantity, QuantityError, exact, parse, say

if TYPE_CHECKING:
    from pounding_risk.models.structures.sdof import Building
    from pounding_risk.models.structures.storeys import Storeys

    def __getattr__(name: str) -> Any:
        """The classes of the modules, by name."""


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
    "knee": lambda self, memory, approaching: self.law.knee(memory, approaching),
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


def refusal(kind: Any, name: str = "") -> str:
    """Why the effect ``name``, by default any of yielding, does not act on this class of law; "" where it does."""
    if kind.capped or (name and not acts_on_law(name)):
        return ""
    return "has no yield force, so that nothing yields"


def with_effects(law: Any, effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> Any:
    """Wrap a law in the effects that act on laws.

    Parameters
    ----------
    law : ContactLaw
        The bare law.
    effects : iterable of (str, mapping or pairs)
        Names and options [SI]; they act in the order of `EFFECTS`. Those that act on no law are passed over.

    Returns
    -------
    ContactLaw
        The law, wrapped.

    Raises
    ------
    PoundingError
        For a law that an effect does not act on.
    """
    options_by_name = {name: dict(options) for name, options in effects if acts_on_law(name)}
    why = refusal(type(bare(law)))
    if options_by_name and why:
        kind = snake_case(type(bare(law)).__name__)
        raise PoundingError(f"{', '.join(options_by_name)}: {kind} {why}; remove the effect, or leave {kind} out")
    for name in EFFECTS:
        if name in options_by_name:
            law = EFFECTS[name].on(law, **options_by_name[name])
    return law


def wave_of(effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> Any:
    """What these effects, (name, options) each, do to the ground motion; None where they leave it as it is."""
    waves = [EFFECTS[name].on(**dict(options)) for name, options in effects if acts_on_ground(name)]
    if len(waves) > 1:
        raise PoundingError(
            "effects: two of them change the ground motion, and it cannot be known in which order; keep one"
        )
    return waves[0] if waves else None


def supports_of(
    buildings: Sequence[Building | Storeys], effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]
) -> tuple[Support, ...]:
    """What each building stands on, with the delays of a passing wave; none where all stand on the motion as it is."""
    supports = [building.support for building in buildings]
    wave = wave_of(effects)
    if wave is not None:
        late = wave.arrivals(len(supports)).tolist()
        supports = [support._replace(delay=support.delay + time) for support, time in zip(supports, late, strict=True)]
    return tuple(supports) if any(support != SHARED for support in supports) else ()


def building_effects(effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> tuple[Any, ...]:
    """Those of these effects, (name, options) each, that act on buildings, in the order of `EFFECTS`."""
    options_by_name = {name: dict(options) for name, options in effects if acts_on_buildings(name)}
    return tuple(EFFECTS[name].on(**options_by_name[name]) for name in EFFECTS if name in options_by_name)


def references(law: Any) -> str:
    """Sources of a law and of its effects, joined by semicolons."""
    return f"{references(law.law)}; {law.reference}" if hasattr(law, "law") else law.reference


def defaults(name: str) -> dict[str, Any]:
    """The options of an effect that have a default of their own: a number in SI, or a word."""
    parameters = signature(EFFECTS[name].on).parameters
    values = {key: parameters[key].default for key in EFFECTS[name].optional}
    return {key: value for key, value in values.items() if isinstance(value, str) or not isnan(value)}


def default_words(name: str, option: str) -> str:
    """The default of an effect's option as a table shows it; "required" where there is none."""
    kind = EFFECTS[name]
    if option not in kind.optional:
        return "required"
    return kind.absent[option] if option in kind.absent else option_words(kind.options[option], defaults(name)[option])


def option_words(allowed: Quantity | tuple[str, ...], value: Any) -> str:
    """The value of an option with its unit."""
    if isinstance(value, tuple):
        return ", ".join(option_words(allowed, one) for one in value)
    return say(value, allowed) if isinstance(allowed, Quantity) else str(value)


def default_example(name: str, option: str) -> str:
    """The default as a scene file has it; in words where it has none of its own."""
    allowed, known = EFFECTS[name].options[option], defaults(name)
    if option not in known:
        return default_words(name, option)
    value = exact(known[option], allowed) if isinstance(allowed, Quantity) else known[option]
    return f'"{value}"' if isinstance(value, str) else f"{value:.6g}"


# The modules, which import from here, in the order in which their effects act.
_MODULES = [module.__name__ for module in modules_in_order(__name__)]
EFFECTS.members = dict(sorted(EFFECTS.members.items(), key=lambda member: _MODULES.index(member[1].__module__)))
globals().update({kind.__name__: kind for kind in EFFECTS.members.values()})
