"""Distributions of numbers that nobody knows exactly: each is one class here.

To add one: write its class with the keys it takes, its words, the probability below a value and the value of a
probability, and list it in `KINDS`. Reading, writing, truncation, the schema and the docs follow from the class.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from math import sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.scene.keys import Unreadable

Array = NDArray[np.float64]
ValueText = Callable[[float], str]  # a value in words, with its unit

EXAMPLE = '{distribution = "lognormal", median = "1.0 s", dispersion = 0.2}'
VALUE, WIDTH, RATIO, VALUES, WEIGHTS = "value", "width", "ratio", "values", "weights"


class Parameter(NamedTuple):
    """A key of a distribution."""

    kind: str  # VALUE: as the number itself; WIDTH: above 0, in its unit; RATIO: above 0, no unit; or lists of these
    words: str
    is_own: bool = False  # whether the scene's own value of the number stands in where it is left out
    is_needed: bool = True


class Distribution(ABC):
    """A distribution; numbers are in SI."""

    takes: ClassVar[Mapping[str, Parameter]]
    example: ClassVar[str]  # of its keys
    # The distribution of these values of its keys; raises Unreadable where they make none together.
    of: ClassVar[Callable[..., Any]]

    @classmethod
    def name(cls) -> str:
        """What a scene file calls it."""
        return cls.__name__.lower()

    @abstractmethod
    def words(self, value_text: ValueText) -> str:
        """Its name and parameters, such as "lognormal, median 1 s, dispersion 0.2"."""

    def keys(self) -> dict[str, Any]:
        """Its keys as `of` takes them: its fields."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}


class Continuous(Distribution):
    """A distribution of real numbers."""

    @abstractmethod
    def below(self, value: float) -> float:
        """The probability of less than ``value``."""

    @abstractmethod
    def quantile(self, probability: Array) -> Array:
        """The values that are not reached with these probabilities, each between 0 and 1."""


@dataclass(frozen=True)
class Normal(Continuous):
    """Normal, by its mean and its standard deviation."""

    mean: float
    deviation: float

    takes = {  # noqa: RUF012 - declared by the base class
        "mean": Parameter(VALUE, "mean", is_own=True),
        "deviation": Parameter(WIDTH, "standard deviation", is_needed=False),
        "cov": Parameter(RATIO, "standard deviation over mean, in place of deviation", is_needed=False),
    }
    example = 'mean = "800 t", deviation = "80 t"'

    @classmethod
    def of(cls, *, mean: float, deviation: float | None = None, cov: float | None = None) -> Normal:
        if (deviation is None) == (cov is None):
            raise Unreadable('normal takes deviation = "80 t" or cov = 0.1, one of the two')
        if deviation is None:
            deviation = abs(mean) * (cov or 0.0)
        if not deviation:
            raise Unreadable("a cov says nothing of a mean of 0; write the deviation")
        return cls(mean, deviation)

    def words(self, value_text: ValueText) -> str:
        return f"normal, mean {value_text(self.mean)}, deviation {value_text(self.deviation)}"

    def below(self, value: float) -> float:
        from scipy.special import ndtr  # takes longer to import than a scene takes to be read

        return float(ndtr((value - self.mean) / self.deviation))

    def quantile(self, probability: Array) -> Array:
        from scipy.special import ndtri

        return self.mean + self.deviation * ndtri(probability)


@dataclass(frozen=True)
class Lognormal(Continuous):
    """Lognormal, by its median and the standard deviation of the natural logarithm."""

    median: float
    dispersion: float

    takes = {  # noqa: RUF012
        "median": Parameter(VALUE, "median, above 0", is_own=True),
        "dispersion": Parameter(RATIO, "standard deviation of the natural logarithm"),
    }
    example = 'median = "1.0 s", dispersion = 0.2'

    @classmethod
    def of(cls, *, median: float, dispersion: float) -> Lognormal:
        if not median > 0.0:
            raise Unreadable(
                'the median of a lognormal number is above 0; correct it, or write distribution = "normal"'
            )
        return cls(median, dispersion)

    def words(self, value_text: ValueText) -> str:
        return f"lognormal, median {value_text(self.median)}, dispersion {self.dispersion:g}"

    def below(self, value: float) -> float:
        from scipy.special import ndtr

        return float(ndtr(np.log(value / self.median) / self.dispersion)) if value > 0.0 else 0.0

    def quantile(self, probability: Array) -> Array:
        from scipy.special import ndtri

        return self.median * np.exp(self.dispersion * ndtri(probability))


@dataclass(frozen=True)
class Uniform(Continuous):
    """Uniform from low to high."""

    low: float
    high: float

    takes = {"low": Parameter(VALUE, "lowest value"), "high": Parameter(VALUE, "highest value")}  # noqa: RUF012
    example = "low = 0.4, high = 0.8"

    @classmethod
    def of(cls, *, low: float, high: float) -> Uniform:
        if not low < high:
            raise Unreadable("low is not below high; swap them")
        return cls(low, high)

    def words(self, value_text: ValueText) -> str:
        return f"uniform from {value_text(self.low)} to {value_text(self.high)}"

    def below(self, value: float) -> float:
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)

    def quantile(self, probability: Array) -> Array:
        return self.low + (self.high - self.low) * probability


@dataclass(frozen=True)
class Triangular(Continuous):
    """Triangular from low to high, with the highest density at mode."""

    low: float
    mode: float
    high: float

    takes = {  # noqa: RUF012
        "low": Parameter(VALUE, "lowest value"),
        "mode": Parameter(VALUE, "most likely value", is_own=True),
        "high": Parameter(VALUE, "highest value"),
    }
    example = 'low = "30 mm", mode = "50 mm", high = "60 mm"'

    @classmethod
    def of(cls, *, low: float, mode: float, high: float) -> Triangular:
        if not (low <= mode <= high and low < high):
            raise Unreadable("low, mode and high are not in this order; correct them")
        return cls(low, mode, high)

    def words(self, value_text: ValueText) -> str:
        return f"triangular from {value_text(self.low)} to {value_text(self.high)}, mode {value_text(self.mode)}"

    def below(self, value: float) -> float:
        width, value = self.high - self.low, min(max(value, self.low), self.high)
        if value < self.mode:
            return (value - self.low) ** 2 / (width * (self.mode - self.low))
        if value == self.high:
            return 1.0
        return 1.0 - (self.high - value) ** 2 / (width * (self.high - self.mode))

    def quantile(self, probability: Array) -> Array:
        rising, falling = self.mode - self.low, self.high - self.mode
        width = rising + falling
        low = self.low + np.sqrt(probability * width * rising)
        return np.where(probability * width < rising, low, self.high - sqrt(width * falling) * np.sqrt(1 - probability))


@dataclass(frozen=True)
class Discrete(Distribution):
    """Some values, numbers or words, each with a weight; without weights all are equally likely."""

    values: tuple[Any, ...]
    weights: tuple[float, ...]

    takes = {  # noqa: RUF012
        "values": Parameter(VALUES, "the values"),
        "weights": Parameter(WEIGHTS, "a weight of each, in proportion to its probability", is_needed=False),
    }
    example = 'values = ["linear", "hertz"], weights = [1, 2]'

    @classmethod
    def of(cls, *, values: Sequence[Any], weights: Sequence[float] | None = None) -> Discrete:
        weights = (1.0,) * len(values) if weights is None else tuple(weights)
        if len(weights) != len(values):
            raise Unreadable(f"{len(values)} values and {len(weights)} weights; write one for each value")
        return cls(tuple(values), weights)

    def words(self, value_text: ValueText) -> str:
        total = sum(self.weights)
        shares = (
            f"{value} ({100.0 * weight / total:.3g} %)" for value, weight in zip(self.values, self.weights, strict=True)
        )
        return f"discrete, {', '.join(shares)}"

    def places(self, probability: Array) -> NDArray[np.int64]:
        """Which of the values stands at these probabilities: the weights add up in the order of the values."""
        cumulative_weights = np.cumsum(self.weights)
        return np.searchsorted(cumulative_weights[:-1] / cumulative_weights[-1], probability, side="right")


KINDS: Mapping[str, type[Distribution]] = {
    kind.name(): kind for kind in (Normal, Lognormal, Uniform, Triangular, Discrete)
}
