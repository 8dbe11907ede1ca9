"""The table [uncertain] of a scene: how its numbers, distributions and correlations are read and checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import inf
from typing import Annotated, Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.models.contact.law import HERTZ_STIFFNESS, LINEAR_STIFFNESS
from pounding_risk.scene.axes import Known, Placed, addressed, likely_target, one_value, reader_of, unquoted
from pounding_risk.scene.distributions import (
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
from pounding_risk.scene.keys import (
    Draft,
    Key,
    Number,
    Section,
    Several,
    Table,
    Unreadable,
    each,
    list_of,
    one_of,
    options,
)
from pounding_risk.scene.overrides import address_of, parts_of
from pounding_risk.scene.sampling import METHODS, SOBOL, cholesky
from pounding_risk.scene.scene_axis import UNCERTAIN, SceneAxis
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.scene.uncertain import GIVEN, LEAST_LEFT, Correlation, UncertainNumber, UncertainNumbers
from pounding_risk.units import Quantity, QuantityError, bounds, exact, parse, shown

MOST_SAMPLES = 100_000
NUMBERS = "numbers"  # the key that is written in words of its own
CUTS = {
    name: Parameter(VALUE, f"where it is cut {side}", is_needed=False)
    for name, side in (("low", "below"), ("high", "above"))
}
RATIOS = Quantity("1", 0.0, inf, "ratio", open_low=True, open_high=True, example="0.2")
WEIGHT = Quantity("1", 0.0, inf, "weight", open_low=True, open_high=True, example="1.0")
CORRELATION = Quantity("1", -1.0, 1.0, "correlation", open_low=True, open_high=True, example="0.5")
CUBE = Quantity("1", 0.0, 1.0, "coordinate of a point")
_EXAMPLE = '{distribution = "lognormal", median = "1.0 s", dispersion = 0.2}'
_CORRELATION = '{between = ["building.frame.period", "building.masonry.period"], value = 0.5}'


def whole(name: str, low: int, high: int, words: str, example: str, absent: str) -> Key:
    """A whole number, of the key of this name."""

    def read(value: Any, number: Number) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise Unreadable(f"{shown(value)} is not a whole number from {low} to {high}; write {name} = {example}")
        return value

    return Key(words, read, example, absent, schema={"type": "integer", "minimum": low, "maximum": high})


def _correlations(value: Any, number: Number) -> tuple[Correlation, ...]:
    return tuple(each(list_of(value, f"correlations = [{_CORRELATION}]"), lambda item: _correlation(item, number)))


def _correlation(value: Any, number: Number) -> Correlation:
    if not isinstance(value, Mapping):
        raise Unreadable(f"{shown(value)} is not a correlation; write {_CORRELATION}")
    takes = "a correlation has between and value"
    kinds = {"between": _two, "value": lambda item: number(item, CORRELATION)}
    return Correlation(**options(value, kinds, tuple(kinds), lambda key: f"missing; write {_CORRELATION}", takes))


def _two(value: Any) -> tuple[str, str]:
    if not isinstance(value, list) or len(value) != 2 or not all(isinstance(item, str) for item in value):
        raise Unreadable(f"{shown(value)} are not two numbers of [uncertain]; write {_CORRELATION}")
    one, other = (address_of(parts_of(item)) or item for item in value)
    if one == other:
        raise Unreadable(f"{shown(one)} stands twice; name two numbers")
    return one, other


def _points(value: Any, number: Number) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise Unreadable(f"{shown(value)} is not a list of points; write [[0.1, 0.9], [0.5, 0.5]]")
    return tuple(tuple(number(item, CUBE) for item in row) for row in value)


def _numbers(value: Any, number: Number) -> dict[str, Any]:
    """Numbers by their addresses, whose distributions are read where the scene is known."""
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise Unreadable(f'{shown(value)} is not a table; write {{"building.frame.period" = {_EXAMPLE}}}')
    return value


class Uncertain(Table):
    """Numbers of a scene that nobody knows exactly, each with a distribution, and how they are drawn."""

    numbers: Annotated[
        dict[str, Any],
        Key(
            "The numbers with their distributions, by the address that --set takes; in a file each stands in "
            "[uncertain] itself.",
            _numbers,
            f'{{"building.frame.period" = {_EXAMPLE}}}',
            "at least one stands in [uncertain]",
            schema={"type": "object"},
        ),
    ] = {}  # noqa: RUF012 - read as a key, and never changed
    samples: Annotated[
        int,
        whole(
            "samples",
            0,
            MOST_SAMPLES,
            "How many samples a scan has; 0 leaves every number at its stated value.",
            "512",
            "256",
        ),
    ] = 256
    method: Annotated[
        str,
        one_of(
            METHODS,
            "a method",
            "How the points of the samples are drawn: scrambled Sobol points, a Latin hypercube or independent ones.",
            '"latin hypercube"',
            '"sobol"',
        ),
    ] = SOBOL
    seed: Annotated[int, whole("seed", 0, 2**63 - 1, "Seed of the points.", "7", "1")] = 1
    correlations: Annotated[
        tuple[Correlation, ...],
        Key(
            "Correlations of the standard normals behind two numbers (a Gaussian copula): of lognormal numbers that "
            "of their logarithms.",
            _correlations,
            f"[{_CORRELATION}]",
            "the numbers are independent",
            write=lambda given: [{"between": list(one.between), "value": one.value} for one in given],
            schema={"type": "array", "items": {"type": "object", "required": ["between", "value"]}},
        ),
    ] = ()
    points: Annotated[
        tuple[tuple[float, ...], ...],
        Key(
            "Points of another design in place of drawn ones: of each sample one coordinate from 0 to 1 for each "
            "uncertain number, in their order, before correlation.",
            _points,
            "[[0.1, 0.9], [0.5, 0.5]]",
            "drawn by method",
            write=lambda points: [list(point) for point in points],
            schema={"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
        ),
    ] = ()

    def written(self) -> dict[str, Any]:
        """The keys that are given, as a scene file has them: a number stands beside the other keys."""
        written = super().written()
        return written | written.pop(NUMBERS, {})


# One of [uncertain], in the schema.
DISTRIBUTION = {
    "type": "object",
    "properties": {"distribution": {"enum": list(KINDS)}},
    "required": ["distribution"],
    "description": "Distribution of the number of this address, as --set takes it.",
    "x-example": f'"building.frame.period" = {_EXAMPLE}',
}


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
    if not asked:
        faults.append(Fault((UNCERTAIN,), f'no number is uncertain; write "building.frame.period" = {_EXAMPLE}'))
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
            f'{shown(text or value)} is no key of the scene; write for example "building.frame.period" = {_EXAMPLE}'
        )
    address = addressed(text, raw, known, "an uncertain number")
    is_set = set(address.targets) <= set(outside)
    if not is_set and set(address.targets) & set(outside):
        raise Unreadable(f"--set sets a part of what {address.key} sets; set all of it")
    number = _number(address.key, address.targets, value, raw, known)
    return PlacedNumber(path, number, address.targets, is_set)


def _number(key: str, targets: Sequence[KeyPath], value: Any, raw: Mapping[str, Any], known: Known) -> UncertainNumber:
    """The distribution of a number, in SI; raises Unreadable."""
    kind = _kind(value)
    own = own_value(targets, raw)
    quantity = quantity_of(targets[0], known, [*value.values(), own])
    if quantity is None and issubclass(kind, Continuous):
        raise Unreadable(
            f'{key} is no number with one unit, or none is written; write distribution = "discrete" and its values, '
            "or every number with its unit"
        )
    given = {name: item for name, item in value.items() if name != "distribution"}
    takes = taken_by(kind)
    given |= {name: own for name, one in takes.items() if one.is_own and name not in given and own is not None}
    readers = {name: _reader(name, one, quantity, one_value(targets[0], known)) for name, one in takes.items()}
    needed = [name for name, one in takes.items() if one.is_needed]
    example = f'{{distribution = "{kind.name()}", {kind.example}}}'
    values = options(
        given, readers, needed, lambda name: f"missing; write {example}", f"{kind.name()} takes {', '.join(takes)}"
    )
    cuts = {name: values.pop(name) for name in CUTS if name in values and name not in kind.takes}
    number = UncertainNumber(key, kind.of(**values), quantity if issubclass(kind, Continuous) else None, **cuts)
    if number.low >= number.high:
        raise Unreadable("low is not below high; swap them")
    if number.left < LEAST_LEFT:
        allowed = (
            bounds(quantity) if quantity and not cuts else " and ".join(f"{name} {shown(given[name])}" for name in cuts)
        )
        raise Unreadable(f"lies outside of what the number may be, {allowed}; correct the distribution")
    return number


def taken_by(kind: type[Distribution]) -> dict[str, Parameter]:
    """The keys that a distribution takes; a continuous one may be cut too."""
    return dict(kind.takes) | (
        {name: one for name, one in CUTS.items() if name not in kind.takes} if issubclass(kind, Continuous) else {}
    )


def _kind(value: Any) -> type[Distribution]:
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a distribution; write {_EXAMPLE}")
    name = value.get("distribution")
    if name is None:
        raise Unreadable(f"the distribution is missing; write {_EXAMPLE}")
    if not isinstance(name, str) or name not in KINDS:
        hint = nearest(name, KINDS) if isinstance(name, str) else ""
        sentence = f"{shown(name)} is not a distribution{hint}; it may be {', '.join(map(shown, KINDS))}"
        raise Several([(("distribution",), sentence)])
    return KINDS[name]


def own_value(targets: Sequence[KeyPath], raw: Mapping[str, Any]) -> Any:
    """The value that the scene itself states, where it is one; None where it is not."""
    found: list[Any] = []
    for target in targets:
        value: Any = raw
        for part in target:
            with_part = isinstance(value, dict) and part in value
            with_part = with_part or (isinstance(value, list) and isinstance(part, int) and part < len(value))
            value = value[part] if with_part else None
        found.append(value)
    single = isinstance(found[0], int | float | str) and not isinstance(found[0], bool)
    return found[0] if single and all(value == found[0] for value in found) else None


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
        if key in known[UNCERTAIN] or not isinstance(value, Mapping) or value.get("distribution") not in KINDS:
            continue
        target = likely_target(key, known)
        if target:
            written[key] = {name: _in_text(name, item, value, target, known) for name, item in value.items()}
    return written


def _in_text(name: str, item: Any, value: Mapping[str, Any], target: KeyPath, known: Known) -> Any:
    """A value of a distribution as a scene file has it; a number without a unit is in SI."""
    from pounding_risk.units import si

    parameter = taken_by(KINDS[value["distribution"]]).get(name)
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
    points = table.get("points", ())
    wrong = next((point for point in points if len(point) != count), None)
    if wrong is not None:
        yield table.fault("points", f"a point has {len(wrong)} coordinates, and {count} numbers are uncertain")
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
        tuple(tuple(point[place] for place in kept) for point in table.points),
    )


def sample_places(draft: Draft, axis: SceneAxis) -> Placed:
    """The axis of the samples with its place in the file."""
    return Placed((UNCERTAIN,), axis)


def table_of_numbers(uncertain: UncertainNumbers) -> dict[str, Any]:
    """The table [uncertain], every value stated."""
    drawn = {"samples": uncertain.samples, "method": uncertain.method, "seed": uncertain.seed}
    values: dict[str, Any] = {"points": uncertain.given} if uncertain.given else drawn
    values |= {"correlations": uncertain.correlations} if uncertain.correlations else {}
    numbers = {number.key: number.written() for number in uncertain.numbers}
    table: Uncertain = Uncertain.made(values)
    return table.written() | numbers
