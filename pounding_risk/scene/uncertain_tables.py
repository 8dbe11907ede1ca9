"""The table [uncertain] of a scene: its keys, and how it is written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pounding_risk.scene.distributions import EXAMPLE, KINDS
from pounding_risk.scene.keys import Key, Number, Table, Unreadable, each, list_of, one_of, options
from pounding_risk.scene.overrides import address_of, parts_of
from pounding_risk.scene.sampling import METHODS, SOBOL
from pounding_risk.scene.uncertain import ALL, DRAWN, Correlation, UncertainNumbers
from pounding_risk.units import Quantity, shown

MOST_SAMPLES = 100_000
NUMBERS = "numbers"  # the key that is written in words of its own
CORRELATION = Quantity("1", -1.0, 1.0, "correlation", open_low=True, open_high=True, example="0.5")
CUBE = Quantity("1", 0.0, 1.0, "coordinate of a point")
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
        raise Unreadable(f'{shown(value)} is not a table; write {{"building.frame.period" = {EXAMPLE}}}')
    return value


class Uncertain(Table):
    """Numbers of a scene that nobody knows exactly, each with a distribution, and how they are drawn."""

    numbers: Annotated[
        dict[str, Any],
        Key(
            "The numbers with their distributions, by the address that --set takes; in a file each stands in "
            "[uncertain] itself.",
            _numbers,
            f'{{"building.frame.period" = {EXAMPLE}}}',
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
    motions: Annotated[
        str,
        one_of(
            (ALL, DRAWN),
            "a choice of motions",
            "Under which motions each sample runs: all, every record in every polarity, or drawn, one of them, by a "
            "further coordinate of the sample's point, so that as many samples are as many runs.",
            '"drawn"',
            '"all"',
        ),
    ] = ALL
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
            "uncertain number, in their order, before correlation, and a last one for the motion where it is drawn.",
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
    "x-example": f'"building.frame.period" = {EXAMPLE}',
}


def table_of_numbers(uncertain: UncertainNumbers) -> dict[str, Any]:
    """The table [uncertain], every value stated."""
    drawn = {"samples": uncertain.samples, "method": uncertain.method, "seed": uncertain.seed}
    values: dict[str, Any] = {"points": uncertain.given} if uncertain.given else drawn
    values |= {"correlations": uncertain.correlations} if uncertain.correlations else {}
    values |= {"motions": uncertain.motions} if uncertain.is_drawn else {}
    numbers = {number.key: number.written() for number in uncertain.numbers}
    table: Uncertain = Uncertain.made(values)
    return table.written() | numbers
