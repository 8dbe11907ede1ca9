"""Contact points of neighbours in a row: floor to floor at matching levels, or floor to column within a storey.

A floor is a slab whose top is its level. Two slabs overlap in height where the higher one is deeper than their levels
are apart: with the levels z_A > z_B, where z_A - z_B < d_A. Slabs that overlap are one contact point, floor to floor.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Callable
from itertools import pairwise
from math import inf, isnan, nan
from typing import Any, NamedTuple

from pounding_risk.models.structures.sdof import Building
from pounding_risk.units import Quantity

FLOOR, COLUMN = KINDS = ("floor", "column")
# m, of a floor without a depth of its own: a slab of 6 m span, of span / 24 (ACI 318-19, table 7.3.1.1, one end
# continuous). Edge beams are deeper.
USUAL_DEPTH = 0.25
DEEPEST_SHARE = 0.25  # of the lowest storey that a floor without a depth of its own takes at most
FLOOR_DEPTH = Quantity("m", 0.0, 5.0, "depth of a floor", open_low=True, example="0.25 m")
HERE = r"(storey|column) ([1-9][0-9]*)(?: at ([0-9]*\.?[0-9]+))?"  # how a scene names a place on a building
ROUNDING = 1e-9  # m, of levels that are sums of storeys
LOWEST = 0.001  # part of a storey up which a column may be met; below it is the floor
Meeting = tuple[float, float, str, float]  # floor of the left building, of the right one, kind, level [m]
IsOne = Callable[[float, float], bool]  # of a level of the left building and one of the right [m]: one contact point?


class Point(NamedTuple):
    """A contact point of a row. Floor 2.0 is the top of storey 2; 2.4 is 0.4 up the column of storey 3."""

    interface: int  # between building `interface` and the next one, from 0
    left_floor: float
    right_floor: float
    kind: str  # "floor" or "column": what the other side's floor meets
    level: float  # m above the ground; NaN where neither building has levels
    across: float = inf  # m across the row, of floors that rotate; infinite where none does
    law: tuple[float, ...] = ()  # numbers of the law of a link; empty where it is elastic, and of contacts


class LevelRule(NamedTuple):
    """When two floors are one contact point. All in m.

    Two floors whose slabs overlap in height are one: their levels differ by less than the depth of the higher one. A
    ``tolerance`` replaces the depths: levels that differ by no more than it are one.
    """

    left_depth: float = USUAL_DEPTH
    right_depth: float = USUAL_DEPTH
    tolerance: float | None = None

    def limit(self, left: float, right: float) -> float:
        """How far apart [m] floors at these levels [m] may be to be one."""
        if self.tolerance is not None:
            return self.tolerance
        return self.left_depth if left > right else self.right_depth

    @property
    def largest(self) -> float:
        """How far apart [m] two floors may be at most, whichever is the higher one."""
        return max(self.left_depth, self.right_depth) if self.tolerance is None else self.tolerance

    def is_one(self, left: float, right: float) -> bool:
        """True where floors at these levels [m] are one contact point."""
        apart, limit = abs(left - right), self.limit(left, right)
        return apart <= limit if self.tolerance is not None else apart < limit - ROUNDING


class Outline(NamedTuple):
    """The floor levels of a building, and how floors of a neighbour meet it."""

    levels: tuple[float, ...]  # m above the ground, of each floor from the bottom up
    is_mass: bool = False  # a single mass stands for a whole building, and is met once
    is_wall: bool = False  # a rigid building is met like a floor wherever it is met

    def floor_at(self, level: float) -> float:
        """The floor number at a level from the ground to the roof, part-way up a storey between two floors."""
        below = bisect_left(self.levels, level)
        foot = self.levels[below - 1] if below else 0.0
        return below + (level - foot) / (self.levels[below] - foot)

    def level_of(self, floor: float) -> float:
        """The level of a floor number [m]."""
        below = int(floor)
        foot = self.levels[below - 1] if below else 0.0
        return foot if floor == below else foot + (floor - below) * (self.levels[below] - foot)


def automatic_points(left: Any, right: Any, is_one: IsOne | None = None) -> list[Meeting]:
    """Where two neighbours meet, from the ground up: (left floor, right floor, kind, level).

    Every floor at or below the other's roof meets the other's floor that is one contact point with it, or the other's
    column there. Two floors that meet are one point, at the mean of their levels. A single mass stands for a whole
    building, and meets its neighbour once, at the lower of the two roofs; without a height it is as tall as its
    neighbour. A rigid building is a wall: floors meet it wherever they are, and without a height it is as tall as its
    neighbour. Two buildings without heights meet mass to mass.

    ``left`` and ``right`` are a `Building` or have ``levels`` [m]; ``is_one`` is as `LevelRule.is_one`, by default that
    of `usual_rule`. No floor is one with two floors of the other building: the rule's depths, or its tolerance, are
    less than half of any storey.
    """
    left_outline, right_outline = outlines(left, right)
    if isnan(left_outline.levels[-1]):
        return [(1.0, 1.0, FLOOR, nan)]
    pairs = _pairs(left_outline.levels, right_outline.levels, is_one or usual_rule(left, right).is_one)
    points = [_meeting(left_outline, right_outline, *pair) for pair in pairs]
    return points[-1:] if left_outline.is_mass or right_outline.is_mass else points


def usual_rule(left: Any, right: Any) -> LevelRule:
    """The rule of two neighbours whose floors have the usual depth."""
    return LevelRule(usual_depth(left), usual_depth(right))


def usual_depth(building: Any) -> float:
    """Depth of the floors [m] of a building that is given without one: 0.25 m, a quarter of its lowest storey at most.

    ``building`` is a `Building`, whose storey is its height, or has ``levels`` [m].
    """
    heights = [top - foot for foot, top in pairwise((0.0, *_own_levels(building)))]
    return min(USUAL_DEPTH, round(DEEPEST_SHARE * min(heights), 6)) if heights else USUAL_DEPTH


def given_point(left: Any, right: Any, left_floor: float, right_floor: float) -> Meeting:
    """The meeting of two floor numbers that a scene gives; its level is that of the floor, the mean of two floors'."""
    one, other = outlines(left, right)
    whole = [side.level_of(floor) for side, floor in ((one, left_floor), (other, right_floor)) if floor == int(floor)]
    levels = whole or [one.level_of(left_floor), other.level_of(right_floor)]
    level = nan if isnan(levels[0]) else sum(levels) / len(levels)  # math's own NaN, so that points compare equal
    return left_floor, right_floor, _kind(one, other, left_floor, right_floor), level


def level_gap(left: Any, right: Any, left_floor: float, right_floor: float) -> float:
    """How far apart the levels of two floor numbers are [m]; 0 where they are not known."""
    left_outline, right_outline = outlines(left, right)
    apart = abs(left_outline.level_of(left_floor) - right_outline.level_of(right_floor))
    return 0.0 if isnan(apart) else apart


def floor_number(words: str) -> float | None:
    """The floor number of "storey 2" (its top, 2.0) or "column 3 at 0.5" (2.5); None for other words.

    >>> floor_number("storey 2"), floor_number("column 3 at 0.4"), floor_number("column 3 at 1.4")
    (2.0, 2.4, None)
    """
    match = re.fullmatch(HERE, " ".join(words.split()))
    if not match or (match[1] == "column") != (match[3] is not None):
        return None
    if match[3] is None:
        return float(match[2])
    share = float(match[3])
    return int(match[2]) - 1 + share if LOWEST <= share <= 1.0 - LOWEST else None


def floor_words(floor: float) -> str:
    """What `floor_number` reads as this very floor.

    >>> floor_words(2.0), floor_words(2.4)
    ('storey 2', 'column 3 at 0.4')
    """
    below = int(floor)
    if floor == below:
        return f"storey {below}"
    texts = (f"column {below + 1} at {floor - below:.{digits}f}" for digits in range(1, 40))
    return next(text for text in texts if floor_number(text) == floor)


def outlines(left: Any, right: Any) -> tuple[Outline, Outline]:
    """The outlines of two neighbours; one without a height of its own is as tall as the other."""
    left_levels, right_levels = _own_levels(left), _own_levels(right)
    tops = (left_levels or right_levels or (nan,))[-1:], (right_levels or left_levels or (nan,))[-1:]
    return _outline(left, left_levels or tops[0]), _outline(right, right_levels or tops[1])


def _own_levels(building: Any) -> tuple[float, ...]:
    if isinstance(building, Building):
        return (building.height,) if building.height > 0.0 else ()
    return tuple(building.levels)


def _outline(building: Any, levels: tuple[float, ...]) -> Outline:
    is_mass = isinstance(building, Building) and not building.is_rigid
    return Outline(levels, is_mass, building.is_rigid)


def _pairs(
    lefts: tuple[float, ...], rights: tuple[float, ...], is_one: IsOne
) -> list[tuple[float | None, float | None]]:
    """The levels that meet, from the ground up to the lower roof; None where a floor meets no floor."""
    pairs: list[tuple[float | None, float | None]] = []
    i = j = 0
    while i < len(lefts) and j < len(rights):
        if is_one(lefts[i], rights[j]):
            pairs.append((lefts[i], rights[j]))
        elif lefts[i] < rights[j]:
            pairs.append((lefts[i], None))
        else:
            pairs.append((None, rights[j]))
        i, j = i + (pairs[-1][0] is not None), j + (pairs[-1][1] is not None)
    return pairs


def _meeting(one: Outline, other: Outline, low: float | None, high: float | None) -> Meeting:
    levels = [level for level in (low, high) if level is not None]
    level = sum(levels) / len(levels)
    left, right = one.floor_at(level if low is None else low), other.floor_at(level if high is None else high)
    return left, right, _kind(one, other, left, right), level


def _kind(one: Outline, other: Outline, left: float, right: float) -> str:
    """Column where a floor meets a building between its floors, unless that is a wall."""
    between = (left != int(left) and not one.is_wall) or (right != int(right) and not other.is_wall)
    return COLUMN if between else FLOOR
