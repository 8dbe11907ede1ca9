"""Effects: what a scene may add to its contact law, to the ground motion under it, or to its buildings.

A module here is found by its file, and holds one effect: a class with its options, source and formula, made known by
the decorator `effect`; and ``ORDER``, its place among the effects. They act in that order, whatever the order in a
scene. An effect of yielding wraps a law and changes some of its methods; one of the ground gives each building a motion
of its own; one of buildings changes their storeys or what they stand on. A scene without effects hands the kernels the
bare law on level ground, so that an effect that is not named is not in the machine code.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from inspect import signature
from math import isnan
from typing import TYPE_CHECKING, Any

from pounding_risk.errors import PoundingError
from pounding_risk.models._discovery import modules_in_order
from pounding_risk.models.contact.law import snake_case
from pounding_risk.models.effects._effect import (
    EFFECTS,
    PASSED_ON,
    PerInterface,
    acts_on_buildings,
    acts_on_ground,
    acts_on_law,
    bare,
    effect,
    read_option,
    written_option,
)
from pounding_risk.models.ground import SHARED, Support
from pounding_risk.units import Quantity, exact, say

if TYPE_CHECKING:
    from pounding_risk.models.effects.wave_passage import WavePassage
    from pounding_risk.models.structures.sdof import Building
    from pounding_risk.models.structures.storeys import Storeys

    def __getattr__(name: str) -> Any:
        """The classes of the modules, by name."""


__all__ = [
    "EFFECTS",
    "PASSED_ON",
    "PerInterface",
    "acts_on_buildings",
    "acts_on_ground",
    "acts_on_law",
    "bare",
    "effect",
    "read_option",
    "written_option",
]

_MODULES = [module.__name__ for module in modules_in_order(__name__)]
_own = sorted(EFFECTS.members.items(), key=lambda member: _MODULES.index(member[1].__module__))
EFFECTS.members = dict(_own)
globals().update({kind.__name__: kind for _, kind in _own})


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


def wave_of(effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> WavePassage | None:
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
