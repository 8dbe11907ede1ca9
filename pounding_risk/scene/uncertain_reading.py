"""The numbers of [uncertain] as they are read, each with its distribution in SI, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import inf
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.models.contact.law import HERTZ_STIFFNESS, LINEAR_STIFFNESS
from pounding_risk.scene.axes import Known, Placed, addressed, likely_target, one_value, reader_of, unquoted
from pounding_risk.scene.distributions import (
    EXAMPLE,
    KINDS,
    RATIO,
    VALUE,
    VALUES,
    WEIGHTS,
    WIDTH,
    Continuous,
    Distribution,
    Parameter,
)
from pounding_risk.scene.keys import Draft, Key, Number, Section, Several, Unreadable, each, list_of, options
from pounding_risk.scene.overrides import parts_of
from pounding_risk.scene.sampling import cholesky
from pounding_risk.scene.scene_axis import UNCERTAIN
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.scene.uncertain import DRAWN, GIVEN, LEAST_LEFT, Correlation, UncertainNumber, UncertainNumbers
from pounding_risk.scene.uncertain_tables import NUMBERS, Uncertain
from pounding_risk.units import Quantity, QuantityError, bounds, exact, parse, shown, si

CUTS = {
    name: Parameter(VALUE, f"where it is cut {side}", is_needed=False)
    for name, side in (("low", "below"), ("high", "above"))
}
RATIOS = Quantity("1", 0.0, inf, "ratio", open_low=True, open_high=True, example="0.2")
WEIGHT = Quantity("1", 0.0, inf, "weight", open_low=True, open_high=True, example="1.0")


class PlacedNumber(NamedTuple):
    """An uncertain number, where it stands in the file, and what it sets in the tables of the scene."""

    path: KeyPath
    number: UncertainNumber
    targets: tuple[KeyPath, ...]
    is_set: bool  # from outside, so that it is uncertain no more


# ------------------------------------------------------------------------------------------------ reading


def taken_numbers(
    raw: dict[str, Any], outside: Sequence[KeyPath], known: Known, axes: Sequence[Placed]
) -> tuple[tuple[PlacedNumber, ...], list[Fault]]:
    """Take the numbers out of the table [uncertain]: each with its place in the file; and what is wrong with them.

    A number whose key was set from ``outside`` is uncertain no more: the key has that value.
    """
    table = raw.get(UNCERTAIN)
    if not isinstance(table, dict):
        return (), []
    placed: list[PlacedNumber] = []
    faults: list[Fault] = []
    asked = list(_entries(table, known[UNCERTAIN]))
    for path, text, value in asked:
        try:
            placed.append(_placed(path, text, value, raw, outside, known))
        except Several as error:
            faults += [Fault((*path, *below), sentence) for below, sentence in error.faults]
        except ValueError as error:
            faults.append(Fault(path, str(error)))
    if faults:
        for of_all in ("correlations", "points"):  # which are told when every number can be read
            table.pop(of_all, None)
    if not asked:
        faults.append(Fault((UNCERTAIN,), f'no number is uncertain; write "building.frame.period" = {EXAMPLE}'))
    return tuple(placed), faults + list(_twice(placed, axes))


def _entries(table: dict[str, Any], own: Known | Mapping[str, Key]) -> Iterator[tuple[KeyPath, str, Any]]:
    """The numbers as written, taken out of the table: where each stands, its address, and its distribution."""
    nested = table.pop(NUMBERS, {})
    if isinstance(nested, dict):
        yield from (((UNCERTAIN, NUMBERS, key), key, value) for key, value in nested.items())
    else:
        yield (UNCERTAIN, NUMBERS), "", nested
    for key in [key for key in table if key not in own]:
        if "." in key or (isinstance(table[key], dict) and "distribution" in table[key]):
            yield (UNCERTAIN, key), key, table.pop(key)
        elif isinstance(table[key], dict):
            yield from unquoted((UNCERTAIN, key), table.pop(key), {"distribution"})


def _placed(
    path: KeyPath, text: str, value: Any, raw: Mapping[str, Any], outside: Sequence[KeyPath], known: Known
) -> PlacedNumber:
    """An uncertain number from its address and its distribution; raises Unreadable."""
    if len(parts_of(text)) < 2:
        raise Unreadable(
            f'{shown(text or value)} is no key of the scene; write for example "building.frame.period" = {EXAMPLE}'
        )
    address = addressed(text, raw, known, "an uncertain number")
    is_set = set(address.targets) <= set(outside)
    if not is_set and set(address.targets) & set(outside):
        raise Unreadable(f"--set sets a part of what {address.key} sets; set all of it")
    number = _number(address.key, address.targets, value, raw, known)
    return PlacedNumber(path, number, address.targets, is_set)


def _number(key: str, targets: Sequence[KeyPath], value: Any, raw: Mapping[str, Any], known: Known) -> UncertainNumber:
    """The distribution of a number, in SI; raises Unreadable."""
    kind, own = _kind(value), own_value(targets, raw)
    quantity = quantity_of(targets[0], known, [*value.values(), own])
    if quantity is None and issubclass(kind, Continuous):
        raise Unreadable(
            f'{key} is no number with one unit, or none is written; write distribution = "discrete" and its values, '
            "or every number with its unit"
        )
    takes = taken_by(kind)
    given = {name: item for name, item in value.items() if name != "distribution"}
    given |= {name: own for name, one in takes.items() if one.is_own and name not in given and own is not None}
    readers = {name: _reader(name, one, quantity, one_value(targets[0], known)) for name, one in takes.items()}
    needed = [name for name, one in takes.items() if one.is_needed]
    example = f'{{distribution = "{kind.name()}", {kind.example}}}'
    takes_words = f"{kind.name()} takes {', '.join(takes)}"
    values = options(given, readers, needed, lambda name: f"missing; write {example}", takes_words)
    cuts = {name: values.pop(name) for name in CUTS if name in values and name not in kind.takes}
    number = UncertainNumber(key, kind.of(**values), quantity if issubclass(kind, Continuous) else None, **cuts)
    _check_cut(number, given)
    return number


def _check_cut(number: UncertainNumber, given: Mapping[str, Any]) -> None:
    """Raise Unreadable for a distribution of which its bounds leave nothing."""
    if number.low >= number.high:
        raise Unreadable("low is not below high; swap them")
    if number.left < LEAST_LEFT:
        cuts = [f"{name} {shown(given[name])}" for name in ("low", "high") if abs(getattr(number, name)) < inf]
        allowed = " and ".join(cuts) or (bounds(number.quantity) if number.quantity else "")
        raise Unreadable(f"lies outside of what the number may be, {allowed}; correct the distribution")


def taken_by(kind: type[Distribution]) -> dict[str, Parameter]:
    """The keys that a distribution takes; a continuous one may be cut too."""
    cuts = {name: one for name, one in CUTS.items() if name not in kind.takes}
    return {**kind.takes, **(cuts if issubclass(kind, Continuous) else {})}


def _kind(value: Any) -> type[Distribution]:
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a distribution; write {EXAMPLE}")
    name = value.get("distribution")
    if name is None:
        raise Unreadable(f"the distribution is missing; write {EXAMPLE}")
    if not isinstance(name, str) or name not in KINDS:
        hint = nearest(name, KINDS) if isinstance(name, str) else ""
        sentence = f"{shown(name)} is not a distribution{hint}; it may be {', '.join(map(shown, KINDS))}"
        raise Several([(("distribution",), sentence)])
    return KINDS[name]


def own_value(targets: Sequence[KeyPath], raw: Mapping[str, Any]) -> Any:
    """The value that the scene itself states, where it is one; None where it is not."""
    stated = [_stated(target, raw) for target in targets]
    single = isinstance(stated[0], int | float | str) and not isinstance(stated[0], bool)
    return stated[0] if single and all(value == stated[0] for value in stated) else None


def _stated(target: KeyPath, raw: Any) -> Any:
    value = raw
    for part in target:
        try:
            value = value[part]
        except (LookupError, TypeError):
            return None
    return value


def quantity_of(target: KeyPath, known: Known, texts: Sequence[Any]) -> Quantity | None:
    """Unit and bounds of a key: what its reader asks for; None where that is no number, or of a unit not known.

    The unit of a stiffness of contact depends on the contact model: it is that of one of the ``texts``.
    """
    asked: list[Quantity] = []

    def note(value: Any, quantity: Quantity) -> float:
        asked.append(quantity)
        return parse(value, quantity)

    with suppress(ValueError, TypeError, LookupError, AttributeError):
        reader_of(target, known)(0.5, note)
    if asked:
        return asked[0]
    if target[0] == "interface" and target[-1] == "stiffness":
        fitting = (
            quantity for quantity in (LINEAR_STIFFNESS, HERTZ_STIFFNESS) if any(_fits(text, quantity) for text in texts)
        )
        return next(fitting, None)
    return None


def _fits(text: Any, quantity: Quantity) -> bool:
    with suppress(QuantityError):
        return isinstance(text, str) and parse(text, _unbounded(quantity)) is not None
    return False


def _unbounded(quantity: Quantity) -> Quantity:
    return quantity._replace(low=-inf, high=inf, open_low=True, open_high=True)


def _reader(
    name: str, parameter: Parameter, quantity: Quantity | None, one: Callable[[Any, Number], Any]
) -> Callable[[Any], Any]:
    """How the value of a key of a distribution is read."""
    if parameter.kind == WEIGHTS:
        return lambda value: each(list_of(value, f"{name} = [1, 2]"), lambda item: parse(item, WEIGHT))
    if parameter.kind == VALUES:
        return lambda value: each(list_of(value, f"{name} = [0.5, 0.6]"), lambda item: one(_single(item), parse), True)
    if parameter.kind == RATIO:
        return lambda value: parse(value, RATIOS._replace(words=name))
    assert quantity is not None, "told before"
    if parameter.kind == WIDTH:
        width = _unbounded(quantity)._replace(low=0.0, words=name)
        return lambda value: parse(value, width)
    return lambda value: parse(value, _unbounded(quantity))


def _single(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise Unreadable(f"{shown(value)} is no single value")
    return value


def _twice(placed: Sequence[PlacedNumber], axes: Sequence[Placed]) -> Iterator[Fault]:
    """A fault for each number that sets what another, or an axis of [grid], sets."""
    setters = {target: f"the axis {axis.axis.name} of [grid]" for axis in axes for target in axis.targets}
    for one in placed:
        other = next((setters[target] for target in one.targets if target in setters), None)
        if other is not None:
            yield Fault(one.path, f"sets what {other} sets; remove one")
        setters |= dict.fromkeys(one.targets, one.number.key)


def numbers_in_text(table: Mapping[str, Any], known: Known) -> dict[str, Any]:
    """The table [uncertain] that Python gives, with numbers in SI of distributions as text with their unit."""
    written = dict(table)
    nested = written.pop(NUMBERS, {})
    written |= nested if isinstance(nested, Mapping) else {NUMBERS: nested}
    for key, value in written.items():
        target = () if key in known[UNCERTAIN] else likely_target(key, known)
        if target and isinstance(value, Mapping) and str(value.get("distribution")) in KINDS:
            written[key] = {name: _in_text(name, item, value, target, known) for name, item in value.items()}
    return written


def _in_text(name: str, item: Any, value: Mapping[str, Any], target: KeyPath, known: Known) -> Any:
    """A value of a distribution as a scene file has it; a number without a unit is in SI."""
    parameter = taken_by(KINDS[str(value["distribution"])]).get(name)
    if parameter is not None and parameter.kind == VALUES and isinstance(item, list | tuple):
        return [one_value(target, known)(one, si) for one in item]
    quantity = quantity_of(target, known, list(value.values()))
    if parameter is None or quantity is None or parameter.kind not in (VALUE, WIDTH) or isinstance(item, str | bool):
        return list(item) if isinstance(item, tuple) else item
    return exact(float(item), quantity) if isinstance(item, int | float) else item


# ------------------------------------------------------------------------------------------------ checks


def uncertain_checks(draft: Draft) -> Iterator[Fault]:
    """Correlations of what is not uncertain, or that no numbers can have; points of another number of columns."""
    table = draft.table(UNCERTAIN)
    keys = [one.number.key for one in draft.uncertain]
    faults = [*_wrong_pairs(table.get("correlations", ()), keys), *_wrong_points(table, len(keys))]
    yield from faults
    uncertain = None if faults else uncertain_of(draft)
    if uncertain is not None and cholesky(uncertain.matrix) is None:
        named = "; ".join(f"{one.value:g} of {' and '.join(one.between)}" for one in uncertain.correlations)
        sentence = f"no numbers have all of these together ({named}): the matrix is not positive definite; lower some"
        yield table.fault("correlations", sentence)


def _wrong_points(table: Section, count: int) -> Iterator[Fault]:
    """A fault for points that are not of ``count`` numbers, or as many as the samples."""
    points, is_drawn = table.get("points", ()), table.get("motions") == DRAWN
    wrong = next((point for point in points if len(point) != count + is_drawn), None)
    if wrong is not None:
        last = ", beside the motion, which is drawn by the last coordinate" * is_drawn
        yield table.fault("points", f"a point has {len(wrong)} coordinates, and {count} numbers are uncertain{last}")
    if points and table.get("samples", len(points)) not in (0, len(points)):
        yield table.fault("samples", f"{table.get('samples')}, and points gives {len(points)}; remove one of the two")


def _wrong_pairs(correlations: Sequence[Correlation], keys: Sequence[str]) -> Iterator[Fault]:
    known: set[frozenset[str]] = set()
    for place, correlation in enumerate(correlations):
        path = (UNCERTAIN, "correlations", place)
        unknown = next((key for key in correlation.between if key not in keys), None)
        if unknown is not None:
            yield Fault(
                path, f"{shown(unknown)} is no number of [uncertain]{nearest(unknown, keys)}; write its distribution"
            )
        if frozenset(correlation.between) in known:
            yield Fault(path, f"{' and '.join(correlation.between)} stand twice; remove one")
        known.add(frozenset(correlation.between))


def uncertain_of(draft: Draft) -> UncertainNumbers | None:
    """The uncertain numbers of a scene whose keys have no fault; None where all are at their stated values."""
    table: Uncertain = Uncertain.made(draft.table(UNCERTAIN).values)
    kept = [place for place, one in enumerate(draft.uncertain) if not one.is_set]
    keys = [draft.uncertain[place].number.key for place in kept]
    if not kept or not table.samples:
        return None
    return UncertainNumbers(
        tuple(draft.uncertain[place].number for place in kept),
        len(table.points) or table.samples,
        GIVEN if table.points else table.method,
        0 if table.points else table.seed,
        tuple(one for one in table.correlations if set(one.between) <= set(keys)),
        tuple((*(point[place] for place in kept), *point[len(draft.uncertain) :]) for point in table.points),
        table.motions,
    )
