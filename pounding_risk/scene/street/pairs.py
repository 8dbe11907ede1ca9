"""Pairs of buildings of a street's table that stand close: neighbours in a row, and those that no row holds.

A row is one line of buildings. Two that stand closer than the limit across the street's axis, at a corner, in two
streets, or as a second neighbour on one side can pound all the same, and are named here with their clear distance.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from math import isnan, nan
from typing import TYPE_CHECKING, NamedTuple

from pounding_risk.units import GAP, say

if TYPE_CHECKING:
    from pounding_risk.scene.street.defaults import House

NEIGHBOURS = "neighbours.csv"
PARTIAL = 0.5  # share of the shorter front; neighbours that face each other over less are noted
ACROSS = "across the axis of the street"
CORNER = "corner to corner"
STREETS = "in two streets"
HEADS = (
    "street",
    "building",
    "other street",
    "other building",
    "clear distance [m]",
    "faced [m]",
    "faced share",
    "held",
)


class Neighbours(NamedTuple):
    """Two neighbours in a row, with the length over which they face each other, NaN without footprints."""

    left: House
    right: House
    gap: float  # m
    faced: float = nan  # m, across the axis of the street
    share: float = nan  # of the shorter front

    @property
    def is_partial(self) -> bool:
        """True where they face each other over less than half of the shorter front."""
        return self.share < PARTIAL

    @property
    def faced_words(self) -> str:
        """The length in words."""
        front = self.faced / self.share if self.share > 0.0 else nan
        return (
            f"face each other over {say(self.faced, GAP, 2)} of a front of {say(front, GAP, 3)} ({percent(self.share)})"
        )


class ClosePair(NamedTuple):
    """Two buildings that stand closer than the limit, and are no neighbours in a row."""

    one: House
    other: House
    distance: float  # m, clear, in any direction; 0 where they touch
    reason: str

    @property
    def names(self) -> tuple[str, str]:
        """Both by name, and by street where there are two."""
        if self.one.street == self.other.street:
            return self.one.name, self.other.name
        return tuple(f"{house.name} ({house.street or 'no street'})" for house in (self.one, self.other))  # type: ignore[return-value]

    @property
    def words(self) -> str:
        """The pair in one sentence without an end."""
        return f"{' and '.join(self.names)}: {say(self.distance, GAP, 3)} clear, {self.reason}"


def percent(share: float) -> str:
    """A share in words."""
    return f"{100.0 * share:.2g} %"


def neighbours_csv(rows: Iterable[tuple[str, Sequence[Neighbours]]], close: Iterable[ClosePair]) -> str:
    """Every pair that stands close as CSV: those of each named row, then those that no row holds, with the reason."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    for name, pairs in rows:
        for each in pairs:
            measured = ["" if isnan(value) else f"{value:.4g}" for value in (each.faced, each.share)]
            writer.writerow((*_who(each.left, each.right), f"{each.gap:.6g}", *measured, f"neighbours in {name}"))
    for pair in close:
        writer.writerow((*_who(pair.one, pair.other), f"{pair.distance:.6g}", "", "", f"in no row: {pair.reason}"))
    return text.getvalue()


def _who(one: House, other: House) -> tuple[str, str, str, str]:
    return one.street, one.name, other.street, other.name
