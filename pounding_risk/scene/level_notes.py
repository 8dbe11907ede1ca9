"""Notes on a row's contact points: floors that a small change of levels or depths would let meet otherwise.

Floor to floor, a contact yields at the floors' F_E; floor to column, at the column's. Where a few centimetres of level
decide between the two, a reader of the results has to know.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan
from typing import Any, NamedTuple

from pounding_risk.models.structures.contact_points import ROUNDING, LevelRule, automatic_points, outlines
from pounding_risk.scene.resolved_interfaces import ResolvedInterface
from pounding_risk.scene.scene import Scene
from pounding_risk.units import STOREY_HEIGHT, say

NEAR, NEAR_SHARE = 0.05, 0.2  # m, and share of the limit: nearer than the larger of both is near
MOST_TOLD = 3  # pairs of floors of an interface that are named


class CloseCall(NamedTuple):
    """Two floors of which a small change of levels or depths makes another kind of contact."""

    left_floor: int
    right_floor: int
    apart: float  # m, in level
    limit: float  # m, up to which they are one contact point
    is_one: bool


def level_notes(study: Scene) -> dict[str, str]:
    """What to know of each interface of a row where close calls decide what meets what, by its name."""
    notes = {}
    for place, interface in enumerate(study.interfaces):
        sides = study.buildings[place], study.buildings[place + 1]
        calls = [] if interface.contact else close_calls(*sides, interface.levels)
        if calls:
            notes[study.interface_names[place]] = _sentence(sides, interface, calls)
    return notes


def close_calls(left: Any, right: Any, rule: LevelRule) -> list[CloseCall]:
    """Floors whose kind of contact a small change of levels, depths or tolerance would alter, from the ground up.

    How far they are apart in level differs from the limit by less than 50 mm or 20 % of it, whichever is more; or it
    is above a tolerance and below the depth of the higher floor, so that slabs that overlap are not taken to meet.
    """
    levels = [side.levels for side in outlines(left, right)]
    if isnan(levels[0][-1]):
        return []
    kinds = _kinds(left, right, rule)
    calls = []
    for i, low in enumerate(levels[0], 1):
        for j, high in enumerate(levels[1], 1):
            if _is_close(rule, low, high) and _kinds(left, right, _Flipped(rule, low, high)) != kinds:
                calls.append(CloseCall(i, j, abs(low - high), rule.limit(low, high), rule.is_one(low, high)))
    return calls


class _Flipped(NamedTuple):
    """A rule but for floors at two levels [m], which are one where it parts them, and two where it joins them."""

    rule: LevelRule
    left: float
    right: float

    def is_one(self, left: float, right: float) -> bool:
        """As that of the rule, flipped at the two levels."""
        return self.rule.is_one(left, right) != ((left, right) == (self.left, self.right))


def _kinds(left: Any, right: Any, rule: LevelRule | _Flipped) -> list[str]:
    return [kind for _, _, kind, _ in automatic_points(left, right, rule.is_one)]


def _is_close(rule: LevelRule, left: float, right: float) -> bool:
    """True where floors at these levels [m] are near the limit of being one, on either side."""
    apart, limit = abs(left - right), rule.limit(left, right)
    overlap = rule._replace(tolerance=None).is_one(left, right)
    return abs(apart - limit) < max(NEAR, NEAR_SHARE * limit) - ROUNDING or (overlap and not rule.is_one(left, right))


def _sentence(sides: tuple[Any, Any], interface: ResolvedInterface, calls: list[CloseCall]) -> str:
    """What is taken to meet what at an interface, and what would change it."""
    more = f" and {len(calls) - MOST_TOLD} more" if len(calls) > MOST_TOLD else ""
    pairs = "; ".join(_pair(sides, call) for call in calls[:MOST_TOLD])
    return f"{pairs[0].upper()}{pairs[1:]}{more}. {' '.join(_repairs(interface.levels, calls))}"


def _pair(sides: tuple[Any, Any], call: CloseCall) -> str:
    """Two floors of a close call, and how they are taken."""
    kind = "floor to floor" if call.is_one else "floor to column"
    floors = f"floors {call.left_floor} of {sides[0].name} and {call.right_floor} of {sides[1].name}"
    apart, limit = (say(length, STOREY_HEIGHT) for length in (call.apart, call.limit))
    return f"{floors} are {apart} apart in level, limit {limit}: taken as {kind}"


def _repairs(rule: LevelRule, calls: list[CloseCall]) -> Iterator[str]:
    """What would change the kind of contact, and how a scene settles it."""
    if any(call.is_one for call in calls):
        yield "Slightly farther apart, floors strike columns, and the contact yields at column_yield_force."
    if any(not call.is_one for call in calls):
        yield "Slightly nearer, or deeper, floors meet floors, and the contact yields at yield_force."
    if rule.tolerance is None:
        yield "Check the levels, write the floor_depth of both buildings, or give the points in contact."
    else:
        depths = " and ".join(dict.fromkeys(say(depth, STOREY_HEIGHT) for depth in rule[:2]))
        yield (
            f"The tolerance of {say(rule.tolerance, STOREY_HEIGHT)} stands in place of floors {depths} deep; check the "
            "levels, or remove tolerance."
        )
