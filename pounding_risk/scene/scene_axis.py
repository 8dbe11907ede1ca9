"""An axis of a scan along which numbers of the scene vary: its addresses, values, labels and places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import prod
from typing import Any, NamedTuple

from pounding_risk.scene.toml import toml_value
from pounding_risk.units import legible

NO_UNIT = "1"
UNCERTAIN = "uncertain"  # the section of a scene whose numbers are drawn
SAMPLE = "sample"  # the dimension along which their samples lie
MOST_ALONE = 200  # places along one axis whose scene is made when a scene is read; `scan` makes all of them


class Labels(NamedTuple):
    """The values of a key along an axis as a dataset has them."""

    values: tuple[Any, ...]  # floats in SI, or texts, or the numbers of places
    unit: str | None  # in the words of datasets; None of texts


class SceneAxis(NamedTuple):
    """A dimension of a scan along which one key of the scene, or several together, have other values.

    Parameters
    ----------
    keys : tuple of str
        The addresses, as `--set` takes them; the first is the name of the dimension.
    values : tuple of tuple
        Of each key its values, as a scene file has them.
    dimension : str
        The name of the dimension where that is not the first key: its places are numbered from 0 along it.
    """

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    dimension: str = ""

    @property
    def name(self) -> str:
        """The name of the dimension."""
        return self.dimension or self.keys[0]

    @property
    def names(self) -> tuple[str, ...]:
        """What a place can be chosen by: the name of the dimension and the keys."""
        return tuple(dict.fromkeys((self.name, *self.keys)))

    @property
    def size(self) -> int:
        """How many places the axis has."""
        return len(self.values[0])

    def overrides(self, place: int) -> tuple[str, ...]:
        """What `--set` takes for a place along the axis."""
        return tuple(f"{key}={toml_value(values[place])}" for key, values in zip(self.keys, self.values, strict=True))

    def words(self) -> str:
        """The values, or how many there are and the two at the ends; of numbered places how many."""
        if self.dimension:
            return f"{self.size} samples of {', '.join(self.keys)}"
        places = [", ".join(legible(values[place]) for values in self.values) for place in range(self.size)]
        return "; ".join(places) if self.size <= 3 else f"{self.size} from {places[0]} to {places[-1]}"

    def labels(self) -> dict[str, Labels]:
        """The values of each key, and the number of each place where they are numbered, as a dataset has them."""
        numbers = {self.dimension: Labels(tuple(range(self.size)), NO_UNIT)} if self.dimension else {}
        return numbers | {key: labels_of(column) for key, column in zip(self.keys, self.values, strict=True)}


def labels_of(values: Sequence[Any]) -> Labels:
    """Values of a key as a dataset has them: numbers in SI with their unit where all are, or else texts."""
    if all(isinstance(value, int | float) for value in values):
        return Labels(tuple(float(value) for value in values), NO_UNIT)
    numbers, units = [], set()
    for value in values:
        number, _, unit = str(value).partition(" ")
        try:
            numbers.append(float(number))
        except ValueError:
            return Labels(tuple(map(str, values)), None)
        units |= {unit} if unit else set()
    if len(units) != 1:
        return Labels(tuple(map(str, values)), None)
    return Labels(tuple(numbers), units.pop().replace("m/s^2", "m/s2"))


def count_of(axes: Sequence[SceneAxis]) -> int:
    """How many scenes the axes make: the product of their places."""
    return prod(axis.size for axis in axes)


def overrides_at(axes: Sequence[SceneAxis], places: Sequence[int]) -> tuple[str, ...]:
    """What `--set` takes for one place along every axis."""
    return tuple(text for axis, place in zip(axes, places, strict=True) for text in axis.overrides(place))


def every_place(axes: Sequence[SceneAxis]) -> Iterator[tuple[int, ...]]:
    """Every place along all axes, the last axis fastest."""
    return product(*(range(axis.size) for axis in axes))


def alone(axes: Sequence[SceneAxis]) -> Iterator[tuple[SceneAxis, int, tuple[str, ...]]]:
    """Places along each axis by itself: (axis, place, what `--set` takes), of a long one `MOST_ALONE` of them."""
    for axis in axes:
        count = min(axis.size, MOST_ALONE)
        for place in sorted({round(number * (axis.size - 1) / max(count - 1, 1)) for number in range(count)}):
            yield axis, place, axis.overrides(place)


def has_gap(keys: Sequence[str]) -> bool:
    """True where an address among these is that of a gap."""
    return any(key.startswith("interface.") and key.endswith(".gap") for key in keys)
