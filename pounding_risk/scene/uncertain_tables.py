"""The table [uncertain] of a scene: its keys, its numbers with their distributions in SI, and their faults."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import inf
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.models.contact.law import HERTZ_STIFFNESS, LINEAR_STIFFNESS
from pounding_risk.scene.axes import (
    Known,
    Placed,
    addressed,
    is_single,
    likely_target,
    one_value,
    reader_of,
    taken_addresses,
)
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
from pounding_risk.scene.keys import (
    Draft,
    Key,
    Number,
    Several,
    Table,
    Unreadable,
    by_address,
    each,
    list_of,
    located,
    one_of,
    options,
    whole,
)
from pounding_risk.scene.overrides import address_of, parts_of
from pounding_risk.scene.scene_axis import UNCERTAIN
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.scene.uncertain import (
    ALL,
    DRAWN,
    GIVEN,
    LEAST_LEFT,
    METHODS,
    SOBOL,
    Correlation,
    UncertainNumber,
    UncertainNumbers,
    cholesky,
)
from pounding_risk.units import Quantity, QuantityError, bounds, exact, parse, shown, si

MOST_SAMPLES = 100_000
NUMBERS = "numbers"  # the key that is written in words of its own
CORRELATION = Quantity("1", -1.0, 1.0, "correlation", open_low=True, open_high=True, example="0.5")
CUBE = Quantity("1", 0.0, 1.0, "coordinate of a point")
_CORRELATION = '{between = ["building.frame.period", "building.masonry.period"], value = 0.5}'


def _correlations(value: Any, number: Number) -> tuple[Correlation, ...]:
    def two(item: Any) -> tuple[str, str]:
        if not isinstance(item, list) or len(item) != 2 or not all(isinstance(key, str) for key in item):
            raise Unreadable(f"{shown(item)} are not two numbers of [uncertain]; write {_CORRELATION}")
        one, other = (address_of(parts_of(key)) or key for key in item)
        if one == other:
            raise Unreadable(f"{shown(one)} stands twice; name two numbers")
        return one, other

    def correlation(item: Any) -> Correlation:
        if not isinstance(item, Mapping):
            raise Unreadable(f"{shown(item)} is not a correlation; write {_CORRELATION}")
        kinds = {"between": two, "value": lambda coefficient: number(coefficient, CORRELATION)}
        missing = f"missing; write {_CORRELATION}"
        return Correlation(
            **options(item, kinds, tuple(kinds), lambda key: missing, "a correlation has between and value")
        )

    return tuple(each(list_of(value, f"correlations = [{_CORRELATION}]"), correlation))


def _points(value: Any, number: Number) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise Unreadable(f"{shown(value)} is not a list of points; write [[0.1, 0.9], [0.5, 0.5]]")
    return tuple(tuple(number(coordinate, CUBE) for coordinate in row) for row in value)


class Uncertain(Table):
    """Numbers of a scene that nobody knows exactly, each with a distribution, and how they are drawn."""

    numbers: dict[str, Any] = by_address(
        "The numbers with their distributions, by the address that --set takes; in a file each stands in "
        "[uncertain] itself.",
        f'{{"building.frame.period" = {EXAMPLE}}}',
        "at least one stands in [uncertain]",
    ).defaults_to({})
    samples: int = whole(
        "samples",
        0,
        MOST_SAMPLES,
        "How many samples a scan has; 0 leaves every number at its stated value.",
        "512",
        "256",
    ).defaults_to(256)
    method: str = one_of(
        METHODS,
        "a method",
        "How the points of the samples are drawn: scrambled Sobol points, a Latin hypercube or independent ones.",
        '"latin hypercube"',
        '"sobol"',
    ).defaults_to(SOBOL)
    seed: int = whole("seed", 0, 2**63 - 1, "Seed of the points.", "7", "1").defaults_to(1)
    motions: str = one_of(
        (ALL, DRAWN),
        "a choice of motions",
        "Under which motions each sample runs: all, every record in every polarity, or drawn, one of them, by a "
        "further coordinate of the sample's point, so that as many samples are as many runs.",
        '"drawn"',
        '"all"',
    ).defaults_to(ALL)
    correlations: tuple[Correlation, ...] = Key(
        "Correlations of the standard normals behind two numbers (a Gaussian copula): of lognormal numbers that "
        "of their logarithms.",
        _correlations,
        f"[{_CORRELATION}]",
        "the numbers are independent",
        write=lambda pairs: [{"between": list(pair.between), "value": pair.value} for pair in pairs],
        schema={"type": "array", "items": {"type": "object", "required": ["between", "value"]}},
    ).defaults_to(())
    points: tuple[tuple[float, ...], ...] = Key(
        "Points of another design in place of drawn ones: of each sample one coordinate from 0 to 1 for each "
        "uncertain number, in their order, before correlation, and a last one for the motion where it is drawn.",
        _points,
        "[[0.1, 0.9], [0.5, 0.5]]",
        "drawn by method",
        write=lambda points: [list(point) for point in points],
        schema={"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
    ).defaults_to(())

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
    "x-example": f'"building.frame.period" = {EXAMPLE}',
}


def table_of_numbers(uncertain: UncertainNumbers) -> dict[str, Any]:
    """The table [uncertain], every value stated."""
    drawn_settings = {"samples": uncertain.samples, "method": uncertain.method, "seed": uncertain.seed}
    settings: dict[str, Any] = {"points": uncertain.given} if uncertain.given else drawn_settings
    settings |= {"correlations": uncertain.correlations} if uncertain.correlations else {}
    settings |= {"motions": uncertain.motions} if uncertain.is_drawn else {}
    numbers = {number.key: number.written() for number in uncertain.numbers}
    table: Uncertain = Uncertain.from_values(settings)
    return table.written() | numbers


# ------------------------------------------------------------------------------------------------ reading

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


def taken_numbers(
    raw: dict[str, Any], set_paths: Sequence[KeyPath], keys: Known, axes: Sequence[Placed]
) -> tuple[tuple[PlacedNumber, ...], list[Fault]]:
    """Take the numbers out of the table [uncertain]: each with its place in the file; and their faults.

    A number whose keys are all ``set_paths``, set by overrides, is not uncertain: they have those values.
    """
    table = raw.get(UNCERTAIN)
    if not isinstance(table, dict):
        return (), []
    numbers: list[PlacedNumber] = []
    faults: list[Fault] = []
    example = f'"building.frame.period" = {EXAMPLE}'
    rows = taken_addresses(UNCERTAIN, table, NUMBERS, keys[UNCERTAIN], {"distribution"})
    for path, text, value in rows:
        try:
            key, targets = addressed(text, value, raw, keys, "an uncertain number", example)
            is_set = set(targets) <= set(set_paths)
            if not is_set and set(targets) & set(set_paths):
                raise Unreadable(f"--set sets a part of what {key} sets; set all of it")
            numbers.append(PlacedNumber(path, _uncertain_number(key, targets, value, raw, keys), targets, is_set))
        except ValueError as error:
            faults += [Fault(*fault) for fault in located(error, *path)]
    if faults:
        for late_key in ("correlations", "points"):  # whose faults are reported when every number can be read
            table.pop(late_key, None)
    if not rows:
        faults.append(Fault((UNCERTAIN,), f"no number is uncertain; write {example}"))
    setters = {target: f"the axis {axis.axis.name} of [grid]" for axis in axes for target in axis.targets}
    for entry in numbers:
        setter = next((setters[target] for target in entry.targets if target in setters), None)
        if setter is not None:
            faults.append(Fault(entry.path, f"sets what {setter} sets; remove one"))
        setters |= dict.fromkeys(entry.targets, entry.number.key)
    return tuple(numbers), faults


def _uncertain_number(
    key: str, targets: Sequence[KeyPath], value: Any, raw: Mapping[str, Any], keys: Known
) -> UncertainNumber:
    """The distribution of a number, in SI; raises Unreadable."""
    kind, base = _kind_of_distribution(value), _own_value(targets, raw)
    quantity = quantity_of(targets[0], keys, [*value.values(), base])
    if quantity is None and issubclass(kind, Continuous):
        raise Unreadable(
            f'{key} is no number with one unit, or none is written; write distribution = "discrete" and its values, '
            "or every number with its unit"
        )
    takes = taken_by(kind)
    parameters = {name: parameter for name, parameter in value.items() if name != "distribution"}
    parameters |= {
        name: base for name, spec in takes.items() if spec.is_own and name not in parameters and base is not None
    }
    readers = {
        name: _parameter_reader(name, spec, quantity, one_value(targets[0], keys)) for name, spec in takes.items()
    }
    needed = [name for name, spec in takes.items() if spec.is_needed]
    example = f'{{distribution = "{kind.name()}", {kind.example}}}'
    takes_words = f"{kind.name()} takes {', '.join(takes)}"
    values = options(parameters, readers, needed, lambda name: f"missing; write {example}", takes_words)
    cut_values = {name: values.pop(name) for name in CUTS if name in values and name not in kind.takes}
    number = UncertainNumber(key, kind.of(**values), quantity if issubclass(kind, Continuous) else None, **cut_values)
    if number.low >= number.high:
        raise Unreadable("low is not below high; swap them")
    if number.left < LEAST_LEFT:
        words = [f"{name} {shown(parameters[name])}" for name in ("low", "high") if abs(getattr(number, name)) < inf]
        limits = " and ".join(words) or (bounds(number.quantity) if number.quantity else "")
        raise Unreadable(f"lies outside of what the number may be, {limits}; correct the distribution")
    return number


def taken_by(kind: type[Distribution]) -> dict[str, Parameter]:
    """The keys that a distribution takes; a continuous one may be cut too."""
    cuts = {name: parameter for name, parameter in CUTS.items() if name not in kind.takes}
    return {**kind.takes, **(cuts if issubclass(kind, Continuous) else {})}


def _kind_of_distribution(value: Any) -> type[Distribution]:
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a distribution; write {EXAMPLE}")
    name = value.get("distribution")
    if name is None:
        raise Unreadable(f"the distribution is missing; write {EXAMPLE}")
    if not isinstance(name, str) or name not in KINDS:
        hint = nearest(name, KINDS)
        sentence = f"{shown(name)} is not a distribution{hint}; it may be {', '.join(map(shown, KINDS))}"
        raise Several([(("distribution",), sentence)])
    return KINDS[name]


def _own_value(targets: Sequence[KeyPath], raw: Mapping[str, Any]) -> Any:
    """The value that the scene itself states, where it is one and the same; None otherwise."""
    values: list[Any] = []
    for target in targets:
        value: Any = raw
        try:
            for part in target:
                value = value[part]
        except (LookupError, TypeError):
            value = None
        values.append(value)
    return values[0] if is_single(values[0]) and all(value == values[0] for value in values) else None


def quantity_of(target: KeyPath, keys: Known, texts: Sequence[Any]) -> Quantity | None:
    """Unit and bounds that the reader of a key takes; None where it takes no number, or its unit is not known.

    The unit of a stiffness of contact depends on the contact model: it is that of one of the ``texts``.
    """
    quantities: list[Quantity] = []

    def note(value: Any, quantity: Quantity) -> float:
        quantities.append(quantity)
        return parse(value, quantity)

    with suppress(ValueError, TypeError, LookupError, AttributeError):
        reader_of(target, keys)(0.5, note)
    if quantities:
        return quantities[0]
    if target[0] == "interface" and target[-1] == "stiffness":
        for quantity in (LINEAR_STIFFNESS, HERTZ_STIFFNESS):
            for text in texts:
                with suppress(QuantityError):
                    if isinstance(text, str) and parse(text, _unbounded(quantity)) is not None:
                        return quantity
    return None


def _unbounded(quantity: Quantity) -> Quantity:
    return quantity._replace(low=-inf, high=inf, open_low=True, open_high=True)


def _parameter_reader(
    name: str, parameter: Parameter, quantity: Quantity | None, to_text: Callable[[Any, Number], Any]
) -> Callable[[Any], Any]:
    """The function that reads the value of a key of a distribution."""

    def single(item: Any) -> Any:
        if not is_single(item):
            raise Unreadable(f"{shown(item)} is no single value")
        return to_text(item, parse)

    if parameter.kind == WEIGHTS:
        return lambda value: each(list_of(value, f"{name} = [1, 2]"), lambda item: parse(item, WEIGHT))
    if parameter.kind == VALUES:
        return lambda value: each(list_of(value, f"{name} = [0.5, 0.6]"), single, True)
    if parameter.kind == RATIO:
        return lambda value: parse(value, RATIOS._replace(words=name))
    assert quantity is not None, "a continuous distribution without one was refused"
    unbounded = _unbounded(quantity)
    if parameter.kind == WIDTH:
        unbounded = unbounded._replace(low=0.0, words=name)
    return lambda value: parse(value, unbounded)


def numbers_in_text(table: Mapping[str, Any], keys: Known) -> dict[str, Any]:
    """The table [uncertain] that Python gives, with numbers in SI of distributions as text with their unit."""
    text_table = dict(table)
    nested_numbers = text_table.pop(NUMBERS, {})
    text_table |= nested_numbers if isinstance(nested_numbers, Mapping) else {NUMBERS: nested_numbers}
    for key, value in text_table.items():
        target = () if key in keys[UNCERTAIN] else likely_target(key, keys)
        if target and isinstance(value, Mapping) and str(value.get("distribution")) in KINDS:
            text_table[key] = {name: _in_text(name, item, value, target, keys) for name, item in value.items()}
    return text_table


def _in_text(name: str, item: Any, distribution: Mapping[str, Any], target: KeyPath, keys: Known) -> Any:
    """A value of a distribution as a scene file has it; a number without a unit is in SI."""
    parameter = taken_by(KINDS[str(distribution["distribution"])]).get(name)
    if parameter is not None and parameter.kind == VALUES and isinstance(item, list | tuple):
        return [one_value(target, keys)(label, si) for label in item]
    quantity = quantity_of(target, keys, list(distribution.values()))
    if parameter is None or quantity is None or parameter.kind not in (VALUE, WIDTH) or isinstance(item, str | bool):
        return list(item) if isinstance(item, tuple) else item
    return exact(float(item), quantity) if isinstance(item, int | float) else item


# ------------------------------------------------------------------------------------------------ checks


def uncertain_checks(draft: Draft) -> Iterator[Fault]:
    """Faults for correlations of other numbers, or that no numbers can have, and for points with wrong columns."""
    table = draft.table(UNCERTAIN)
    keys = [placed.number.key for placed in draft.uncertain]
    faults: list[Fault] = []
    pairs: set[frozenset[str]] = set()
    for place, correlation in enumerate(table.get("correlations", ())):
        path, between = (UNCERTAIN, "correlations", place), correlation.between
        unknown = next((key for key in between if key not in keys), None)
        if unknown is not None:
            sentence = f"{shown(unknown)} is no number of [uncertain]{nearest(unknown, keys)}; write its distribution"
            faults.append(Fault(path, sentence))
        if frozenset(between) in pairs:
            faults.append(Fault(path, f"{' and '.join(between)} stand twice; remove one"))
        pairs.add(frozenset(between))
    points, is_drawn = table.get("points", ()), table.get("motions") == DRAWN
    misfit = next((point for point in points if len(point) != len(keys) + is_drawn), None)
    if misfit is not None:
        note = ", beside the motion, which is drawn by the last coordinate" * is_drawn
        sentence = f"a point has {len(misfit)} coordinates, and {len(keys)} numbers are uncertain{note}"
        faults.append(table.fault("points", sentence))
    if points and table.get("samples", len(points)) not in (0, len(points)):
        sentence = f"{table.get('samples')}, and points gives {len(points)}; remove one of the two"
        faults.append(table.fault("samples", sentence))
    yield from faults
    uncertain = None if faults else uncertain_of(draft)
    if uncertain is not None and cholesky(uncertain.matrix) is None:
        listing = "; ".join(f"{placed.value:g} of {' and '.join(placed.between)}" for placed in uncertain.correlations)
        sentence = f"no numbers have all of these together ({listing}): the matrix is not positive definite; lower some"
        yield table.fault("correlations", sentence)


def uncertain_of(draft: Draft) -> UncertainNumbers | None:
    """The uncertain numbers of a scene whose keys have no fault; None where all are at their stated values."""
    table: Uncertain = Uncertain.from_values(draft.table(UNCERTAIN).values)
    indices = [place for place, one in enumerate(draft.uncertain) if not one.is_set]
    keys = [draft.uncertain[place].number.key for place in indices]
    if not indices or not table.samples:
        return None
    return UncertainNumbers(
        tuple(draft.uncertain[place].number for place in indices),
        len(table.points) or table.samples,
        GIVEN if table.points else table.method,
        0 if table.points else table.seed,
        tuple(one for one in table.correlations if set(one.between) <= set(keys)),
        tuple((*(point[place] for place in indices), *point[len(draft.uncertain) :]) for point in table.points),
        table.motions,
    )
