"""How the value of each kind of scene key is read: text, lists and tables in, SI numbers and names out.

A reader takes what stands in the file and returns what the study needs, or raises `Unreadable` (or
QuantityError) with a sentence; `Several` where more than one part of a value is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import inf
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.contact.relation import AS_PUBLISHED, faults, is_ratio, written_ratio
from pounding_risk.models.effects import EFFECTS, defaults, read_option
from pounding_risk.models.restitution import NAMED, Restitution, constant
from pounding_risk.models.structures.contact_points import floor_number
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.scene.checks import LATER_RESTITUTION
from pounding_risk.scene.scene import EQUAL_TERMS, Effect, unknown_law
from pounding_risk.units import EXAMPLES, RESTITUTION, Quantity, parse, shown

LONGEST_AXIS = 10_000  # values of one grid key
SIDES = ("left", "right")
MEETING = '{left = "storey 2", right = "column 3 at 0.5"}'


class Unreadable(ValueError):
    """A value that a key cannot take; the sentence says what was found, what is allowed and the repair."""


class Several(Unreadable):
    """More than one fault in a value: the path below the key, and the sentence, of each."""

    def __init__(self, faults: list[tuple[tuple[str | int, ...], str]]):
        self.faults = faults
        super().__init__("; ".join(sentence for _, sentence in faults))


def words(example: str) -> Callable[[Any], str]:
    """A reader of text that is not blank."""

    def read(value: Any) -> str:
        if not isinstance(value, str) or not value.strip():
            raise Unreadable(f'{shown(value)} is not a name; write text in quotes, such as "{example}"')
        return value

    return read


def flag(key: str) -> Callable[[Any], bool]:
    """true or false, of the key of this name."""

    def read(value: Any) -> bool:
        if not isinstance(value, bool):
            raise Unreadable(f"{shown(value)} is not true or false; write {key} = true, or remove it")
        return value

    return read


def one_of(allowed: Sequence[str], what: str) -> Callable[[Any], str]:
    """A reader of one of these words; ``what`` says with its article what they are."""

    def read(value: Any) -> str:
        if value not in allowed:
            hint = nearest(value, allowed) if isinstance(value, str) else ""
            raise Unreadable(f"{shown(value)} is not {what}{hint}; it may be {', '.join(map(shown, allowed))}")
        return str(value)

    return read


def storey_count(value: Any) -> int:
    """Reader of the number of storeys of a building."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST_STOREYS:
        raise Unreadable(
            f"{shown(value)} is not a count of storeys; write a whole number from 1 to {MOST_STOREYS}, such as 5"
        )
    return value


def per_storey(quantity: Quantity) -> Callable[[Any], tuple[float, ...] | float]:
    """A reader of one value for all storeys, or of a list with one value for each, from the ground up."""
    example = shown([quantity.example] * 2)

    def read(value: Any) -> tuple[float, ...] | float:
        if not isinstance(value, list):
            return parse(value, quantity)
        if len(value) > MOST_STOREYS:
            raise Unreadable(f"the list has {len(value)} values, more than {MOST_STOREYS} storeys; check it")
        asked = list_of(value, f"a value for each storey, such as {example}")
        return tuple(each(asked, partial(parse, quantity=quantity)))

    return read


def contact_points(value: Any) -> tuple[tuple[float, float], ...]:
    """The floor numbers of a scene's own contact points: (left, right) of each, in ascending order."""
    found = each(list_of(value, f"contact = [{MEETING}]"), _meeting, distinct=True)
    return tuple(sorted(found))


def _meeting(value: Any) -> tuple[float, float]:
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a contact point; write {MEETING}")
    faults: list[tuple[tuple[str | int, ...], str]] = [
        ((key,), f"unknown key{nearest(key, SIDES)}; a contact point has left and right")
        for key in value
        if key not in SIDES
    ]
    floors = []
    for side in SIDES:
        told = value.get(side)
        floor = floor_number(told) if isinstance(told, str) else None
        if side not in value:
            faults.append(((side,), f"missing; write {MEETING}"))
        elif floor is None:
            faults.append(
                (
                    (side,),
                    f'{shown(told)} is not a place on a building; write "storey 2" for the floor on top of storey 2, '
                    'or "column 3 at 0.5" for half-way up storey 3',
                )
            )
        else:
            floors.append(floor)
    if faults:
        raise Several(faults)
    return floors[0], floors[1]


def law_name(value: Any) -> str:
    """Reader of the name of a contact model; raises Unreadable for an unknown one."""
    if not isinstance(value, str) or value not in CONTACT_MODELS:
        if isinstance(value, str):
            raise Unreadable(unknown_law(value))
        raise Unreadable(f"{shown(value)} is not the name of a contact model; it may be {', '.join(CONTACT_MODELS)}")
    return value


def restitution(value: Any) -> tuple[Restitution, str, str]:
    """e(v), the words for it, and its relation to damping: a value alone, or a table of value and relation."""
    if not isinstance(value, dict):
        return *_restitution(value), AS_PUBLISHED
    wrong: list[tuple[tuple[str | int, ...], str]] = [((key,), sentence) for key, sentence in faults(value)]
    try:
        rule, told = _restitution(value.get("value", 1.0))  # a value that is missing is among the faults
    except ValueError as error:
        wrong.append((("value",), str(error)))
    if is_ratio(value.get("value")) and value.get("relation", AS_PUBLISHED) != AS_PUBLISHED:
        wrong.append((("relation",), "a damping ratio ξ is that of the published relation; remove relation, or give e"))
    if wrong:
        raise Several(wrong)
    return rule, told, value.get("relation", AS_PUBLISHED)


def _restitution(value: Any) -> tuple[Restitution, str]:
    """A number in (0, 1], the name of a relation e(v) or a damping ratio of a law; with the words for it."""
    if is_ratio(value):
        e, told = written_ratio(value)
        return constant(e), told
    if isinstance(value, str) and value[:1].isalpha() and value.lower() not in ("inf", "nan"):
        if value in NAMED:
            return NAMED[value], value
        names = ", ".join(f'"{name}"' for name in NAMED)
        if value in LATER_RESTITUTION:
            raise Unreadable(f"{shown(value)} is not in this version; write a number such as 0.6, or one of {names}")
        raise Unreadable(
            f"{shown(value)} is not a named restitution{nearest(value, NAMED)}; "
            f"write a number such as 0.65, or one of {names}"
        )
    e = parse(value, RESTITUTION)
    return constant(e), f"{e!r}"


def same(value: Any) -> str:
    """What the laws of both families have in common."""
    if value not in EQUAL_TERMS:
        known = " or ".join(f'"{terms}"' for terms in EQUAL_TERMS)
        hint = nearest(value, EQUAL_TERMS) if isinstance(value, str) else ""
        raise Unreadable(f"{shown(value)} is not a common ground of contact models{hint}; it may be {known}")
    return str(value)


def effect(name: str) -> Callable[[Any], Effect]:
    """Reader of the table of options of an effect."""
    kind: Any = EFFECTS[name]

    def option(key: str, value: Any) -> Any:
        allowed = kind.options[key]
        if isinstance(allowed, Quantity):
            return read_option(value, allowed)
        if value not in allowed:
            hint = nearest(value, allowed) if isinstance(value, str) else ""
            raise Unreadable(f"{shown(value)} is not one of {', '.join(map(shown, allowed))}{hint}; write one of these")
        return value

    def read(value: Any) -> Effect:
        if not isinstance(value, dict):
            raise Unreadable(f"{shown(value)} is not a table; write {name} = {{{_options(kind)}}}, or remove it")
        faults: list[tuple[tuple[str | int, ...], str]] = []
        found = []
        for key in [*value, *(key for key in kind.options if key not in value and key not in kind.optional)]:
            try:
                if key not in kind.options:
                    raise Unreadable(
                        f"unknown key{nearest(key, kind.options)}; {name} takes {_options(kind, True) or 'no keys'}"
                    )
                if key not in value:
                    raise Unreadable(f"missing; write {name} = {{{_options(kind)}}}")
                found.append((key, option(key, value[key])))
            except ValueError as error:
                faults.append(((key,), str(error)))
        if faults:
            raise Several(faults)
        return Effect(name, tuple(sorted({**defaults(name), **dict(found)}.items())))

    return read


def _options(kind: Any, every: bool = False) -> str:
    """An effect's keys as a scene has them, each with an example; those that may be left out too where ``every`` is."""
    examples = {
        key: shown(allowed.example if allowed.unit != "1" else float(allowed.example))
        if isinstance(allowed, Quantity)
        else shown(allowed[-1])
        for key, allowed in kind.options.items()
    }
    return ", ".join(f"{key} = {example}" for key, example in examples.items() if every or key not in kind.optional)


def law_names(value: Any) -> tuple[str, ...]:
    """The contact models of a grid, in the order written."""
    asked = list_of(value, 'contact_model = ["jankowski", "hertz"]')
    return tuple(each(asked, law_name, distinct=True))


def axis(quantity: Quantity) -> Callable[[Any], tuple[float, ...]]:
    """A reader of grid values: an ascending list, or {start, stop, num}."""
    example = EXAMPLES[quantity.unit]

    def read(value: Any) -> tuple[float, ...]:
        if isinstance(value, dict):
            return _spaced(value, quantity)
        if not isinstance(value, list):
            raise Unreadable(
                f"{shown(value)} is not a list; write a list such as [{shown(example)}], "
                f"or {{start = ..., stop = {shown(example)}, num = 11}}"
            )
        asked = list_of(value, f"a list such as [{shown(example)}]")
        values = each(asked, lambda item: parse(item, quantity), distinct=True)
        if any(after < before for before, after in pairwise(values)):
            order = [text for _, text in sorted(zip(values, value, strict=True), key=lambda pair: pair[0])]
            raise Unreadable(f"the values are not in ascending order; write {shown(order)}")
        return tuple(values)

    return read


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 2 <= value <= LONGEST_AXIS:
        raise Unreadable(f"{shown(value)} is not a count of values; write a whole number from 2 to {LONGEST_AXIS}")
    return value


def _bound(value: Any, quantity: Quantity) -> float:
    found = parse(value, quantity)
    if found == inf:
        raise Unreadable(f'{shown(value)} cannot bound even steps; write a list that ends with "inf" instead')
    return found


def _spaced(value: dict[str, Any], quantity: Quantity) -> tuple[float, ...]:
    """``num`` values from start to stop, both included, evenly spaced."""
    bound = partial(_bound, quantity=quantity)
    readers: dict[str, Callable[[Any], Any]] = {"start": bound, "stop": bound, "num": _count}
    faults: list[tuple[tuple[str | int, ...], str]] = []
    for key in value:
        if key not in readers:
            faults.append(((key,), f"unknown key{nearest(key, readers)}; a range has start, stop and num"))
    found: dict[str, Any] = {}
    for key, reader in readers.items():
        try:
            if key not in value:
                raise Unreadable("missing; a range has start, stop and num")
            found[key] = reader(value[key])
        except ValueError as error:
            faults.append(((key,), str(error)))
    if not faults and found["stop"] <= found["start"]:
        sentence = (
            f"{shown(value['stop'])} is not above start {shown(value['start'])}; "
            "swap them, or write a list with one value"
        )
        faults.append((("stop",), sentence))
    if faults:
        raise Several(faults)
    # In decimal fractions: the third of 51 values from 0 to 0.1 is 0.004, and no neighbour of it.
    start, stop, steps = Fraction(repr(found["start"])), Fraction(repr(found["stop"])), found["num"] - 1
    return tuple(float(start + (stop - start) * step / steps) for step in range(steps + 1))


def list_of(value: Any, example: str) -> list[Any]:
    """A list that is neither empty nor absurdly long."""
    if not isinstance(value, list):
        raise Unreadable(f"{shown(value)} is not a list; write {example}")
    if not value:
        raise Unreadable(f"the list is empty; write {example}, or remove it")
    if len(value) > LONGEST_AXIS:
        raise Unreadable(f"the list has {len(value)} values, more than {LONGEST_AXIS}; split the scene in several")
    return value


def each(values: list[Any], read: Callable[[Any], Any], distinct: bool = False) -> list[Any]:
    """Every element read; all that fail, and where asked all that repeat another, are told at once."""
    found: list[Any] = []
    faults: list[tuple[tuple[str | int, ...], str]] = []
    first: dict[Any, Any] = {}
    for index, value in enumerate(values):
        try:
            found.append(read(value))
        except Several as error:
            faults += [((index, *below), sentence) for below, sentence in error.faults]
            continue
        except ValueError as error:
            faults.append(((index,), str(error)))
            continue
        if distinct and found[-1] in first:
            other = first[found[-1]]
            also = "" if other == value else f", first as {shown(other)}"
            faults.append(((index,), f"{shown(value)} stands twice{also}; remove one"))
        first.setdefault(found[-1], value)
    if faults:
        raise Several(faults)
    return found
