"""Values that may differ along the axes of other numbers of a scene, reduced to the axes along which they do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.scene.toml import KeyPath


class Stack:
    """Named values, or arrays of one shape, at each place along some axes; None where a name has no value."""

    def __init__(self, shape: tuple[int, ...]):
        self.shape = shape
        self._values: dict[str, list[Any]] = {}

    def add(self, number: int, values: Mapping[str, Any]) -> None:
        """Set the values at a place by its number, the last axis fastest."""
        for name, value in values.items():
            self._values.setdefault(name, [None] * prod(self.shape))[number] = value

    def reduced(self) -> dict[str, tuple[tuple[int, ...], NDArray[Any]]]:
        """Every name: along which axes its values differ, and the values, with these axes first."""
        return {name: self._reduced(values) for name, values in self._values.items()}

    def differing(self) -> dict[str, tuple[tuple[int, ...], NDArray[Any]]]:
        """`reduced`, of the names whose values differ."""
        return {name: (along, values) for name, (along, values) in self.reduced().items() if along}

    def as_lists(self, whole: bool = False) -> list[list[Any]]:
        """`differing`, or all of a ``whole``, as an attribute has them: name, axes, and the values as nested lists."""
        reduced = self.reduced() if whole else self.differing()
        return [[name, list(along), values.tolist()] for name, (along, values) in reduced.items()]

    def _reduced(self, by_place: list[Any]) -> tuple[tuple[int, ...], NDArray[Any]]:
        """The axes along which values differ, and the values, with these axes first."""
        if isinstance(by_place[0], np.ndarray):
            values = np.stack(by_place).reshape(*self.shape, *by_place[0].shape)
        else:
            values = np.empty(len(by_place), dtype=object)
            values[:] = by_place
            values = values.reshape(self.shape)
        along: list[int] = []
        for axis in reversed(range(len(self.shape))):
            if _same(values, values.take([0], axis)):
                values = values.take(0, axis)
            else:
                along.insert(0, axis)
        return tuple(along), np.asarray(values)


def _same(values: NDArray[Any], others: NDArray[Any]) -> bool:
    if values.dtype.kind != "f":
        return bool(np.all(values == others))
    return bool(np.all((values == others) | (np.isnan(values) & np.isnan(others))))


def leaves_of(nested: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """The values of nested tables with their paths; a list of plain values is one value."""
    if isinstance(nested, Mapping) and nested:
        for key, inner in nested.items():
            yield from leaves_of(inner, (*path, key))
    elif isinstance(nested, list | tuple) and any(isinstance(inner, Mapping) for inner in nested):
        for place, inner in enumerate(nested):
            yield from leaves_of(inner, (*path, place))
    else:
        yield path, nested
