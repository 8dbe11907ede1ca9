"""The buildings of one street in rows: neighbours, the gaps between them, and close pairs that no row holds.

A row is one line of buildings. Two that stand closer than the limit across the street's axis, at a corner, in two
streets, or as a second neighbour on one side can pound too. They are listed with their clear distance.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import cos, inf, isfinite, isnan, nan, radians, sin
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.letters import csv_text
from pounding_risk._common.words import listed
from pounding_risk.models.structures.contact_points import COLUMN, LevelRule, automatic_points
from pounding_risk.streets import footprints
from pounding_risk.streets.defaults import Filled, House, Notes, Rules
from pounding_risk.streets.footprints import Array, Facing, Outline, Pairs
from pounding_risk.streets.table import repeated
from pounding_risk.units import GAP, say, shown

NEIGHBOURS = "neighbours.csv"
ROUNDED = 6  # decimals of a metre
FINEST_GAP = 4  # decimals of a metre: no survey resolves less than 0.1 mm
LISTED = 5  # neighbours that a note names
SAME = 0.95  # of the larger of two footprints; with more in common they are one building drawn twice
PARTIAL = 0.5  # share of the shorter front; neighbours that face each other over less are noted
ACROSS = "across the axis of the street"
CORNER = "corner to corner"
INSIDE = "one stands in a court of the other, or between its parts"
NO_AXIS = "no direction makes a row of such two: write a .csv of them with their gap"
STREETS = "in two streets"
HEADS = (
    *("street", "building", "other street", "other building"),
    *("clear distance [m]", "least gap [m]", "largest gap [m]", "faced [m]", "faced share"),
    *("floors that meet", "floors that miss", "largest offset of floors [m]", "held"),
)


class Floors(NamedTuple):
    """How the floors of two buildings stand to each other, from the ground to the lower roof."""

    meet: int  # pairs of floors that meet floor to floor
    miss: int  # floors of either that meet a column of the other
    offset: float  # m, of the floor that is farthest from any floor of the other; 0 where all are level


class _Levels(NamedTuple):
    """The levels of the floors of a building [m], its storeys all as high, as a scene has them."""

    levels: tuple[float, ...]
    is_rigid: bool = False


def floors(one: House, other: House, tolerance: float | None = None) -> Floors:
    """How the floors of two buildings stand to each other, by their heights, storeys and depths of floors.

    A ``tolerance`` of levels that meet [m] stands in place of the depths of the floors.
    """
    sides = [
        _Levels(tuple(storey * house.height / house.storeys for storey in range(1, house.storeys + 1)))
        for house in (one, other)
    ]
    rule = LevelRule(one.floor_depth, other.floor_depth, tolerance)
    points = automatic_points(sides[0], sides[1], rule.is_one)
    lower = min(side.levels[-1] for side in sides)
    # Without a tolerance: of all floors up to the lower roof, how far the nearest floor of the other is.
    offsets = [
        min(abs(level - other_level) for other_level in there.levels)
        for here, there in (sides, sides[::-1])
        for level in here.levels
        if level <= lower + rule.largest
    ]
    miss = sum(point[2] == COLUMN for point in points)
    return Floors(len(points) - miss, miss, round(max(offsets), ROUNDED))


class Neighbours(NamedTuple):
    """Two neighbours in a row, with the length over which they face each other, NaN without footprints."""

    left: House
    right: House
    gap: float  # m
    faced: float = nan  # m, across the axis of the street
    share: float = nan  # of the shorter front
    resolution: float = nan  # m, within which a measured gap is uniform; NaN of one that is known
    overlap: float = 0.0  # m, of walls that are measured to overlap, and touch

    @property
    def gaps(self) -> tuple[float, float]:
        """The least and the largest gap [m]; both the gap itself where that is known."""
        return within(self.gap - self.overlap, self.resolution)

    @property
    def is_partial(self) -> bool:
        """True where they face each other over less than half of the shorter front."""
        return self.share < PARTIAL

    @property
    def faced_words(self) -> str:
        """The faced length and its share in words."""
        front = say(self.faced / self.share if self.share > 0.0 else nan, GAP, 3)
        return f"face each other over {say(self.faced, GAP, 2)} of a front of {front} ({percent(self.share)})"


class ClosePair(NamedTuple):
    """Two buildings that stand closer than the limit, and are no neighbours in a row."""

    one: House
    other: House
    distance: float  # m, clear, in any direction; 0 where they touch
    reason: str
    faced: float = nan  # m, along the grid of their own walls
    share: float = nan  # of the shorter front
    resolution: float = nan  # m

    @property
    def names(self) -> tuple[str, str]:
        """The names of both, with their streets where these are two."""
        if self.one.street == self.other.street:
            return self.one.name, self.other.name
        return tuple(f"{house.name} ({house.street or 'no street'})" for house in (self.one, self.other))  # type: ignore[return-value]

    @property
    def words(self) -> str:
        """The pair in one sentence without its full stop."""
        return f"{' and '.join(self.names)}: {say(self.distance, GAP, 3)} clear, {self.reason}"


def percent(share: float) -> str:
    """A share in per cent, in words."""
    return f"{100.0 * share:.2g} %"


def within(gap: float, resolution: float) -> tuple[float, float]:
    """The ends of a gap that is known to within a resolution [m]; none is below 0."""
    spread = 0.0 if isnan(resolution) else resolution
    return round(max(gap - spread, 0.0), ROUNDED), round(max(gap + spread, 0.0), ROUNDED)


def neighbours_csv(
    rows: Iterable[tuple[str, Sequence[Neighbours]]], close: Iterable[ClosePair], tolerance: float | None = None
) -> str:
    """Every close pair as CSV: the neighbours of each named row, then the pairs that no row holds, with the reason."""
    lines: list[Iterable[Any]] = [HEADS]

    def add(one: House, other: House, gap: float, pair: Neighbours | ClosePair, held: str) -> None:
        gap_ends = [
            f"{end:.6g}" for end in (pair.gaps if isinstance(pair, Neighbours) else within(gap, pair.resolution))
        ]
        faced_texts = ["" if isnan(length) else f"{length:.4g}" for length in (pair.faced, pair.share)]
        meet, miss, offset = floors(one, other, tolerance)
        names = one.street, one.name, other.street, other.name
        lines.append((*names, f"{gap:.6g}", *gap_ends, *faced_texts, meet, miss, f"{offset:.4g}", held))

    for name, pairs in rows:
        for pair in pairs:
            add(pair.left, pair.right, pair.gap, pair, f"neighbours in {name}")
    for lone in close:
        add(lone.one, lone.other, lone.distance, lone, f"in no row: {lone.reason}")
    return csv_text(lines)


def reach(rules: Rules) -> float:
    """The distance [m] within which buildings are looked at."""
    return rules.limit + rules.survey


def close_pair(one: House, other: House, distance: float, reason: str, rules: Rules, resolution: float) -> ClosePair:
    """Two buildings with footprints and their clear distance [m], with the length over which they face each other."""
    face = footprints.shared_face(one.footprint, other.footprint, reach(rules))
    return ClosePair(one, other, round(distance, FINEST_GAP), reason, *face, resolution)


def between_streets(houses: Sequence[House], rules: Rules, resolution: float) -> Iterator[ClosePair]:
    """Pairs of buildings of two streets that stand closer than the limit."""
    with_footprint = [house for house in houses if house.footprint is not None]
    if with_footprint:
        pairs, distances = footprints.close_pairs([house.footprint for house in with_footprint], rules.limit)
        for pair, distance in zip(pairs.tolist(), distances.tolist(), strict=True):
            one, other = (with_footprint[number] for number in pair)
            if one.street != other.street and distance < rules.limit:
                yield close_pair(one, other, distance, STREETS, rules, resolution)


class BlockRow(NamedTuple):
    """Buildings side by side, left to right, and the gaps between them [m]."""

    name: str
    street: str
    buildings: tuple[House, ...]
    gaps: tuple[float, ...]
    direction: float = nan  # degrees clockwise from north, from left to right; NaN without footprints
    pairs: tuple[Neighbours, ...] = ()  # one for each gap


class LinedUp(NamedTuple):
    """The rows of a street, single buildings as rows without a gap, and the close pairs that no row holds."""

    rows: list[BlockRow]
    close: list[ClosePair]
    sides: list[int]  # of each building, how many have another one closer than the limit; empty without footprints


class View(NamedTuple):
    """Buildings that stand close to each other, seen along and across their axis."""

    axes: tuple[Array, Array]  # unit vectors (east, north)
    outlines: Mapping[int, Outline]
    along: list[Facing]
    across: list[Facing]


class Street(NamedTuple):
    """The buildings of one street with their places in the file, and the rules by which they are lined up."""

    houses: list[House]
    places: list[str]
    rules: Rules
    notes: Notes
    resolution: float = nan  # m, of measured gaps

    def lined_up(self) -> LinedUp:
        """Rows in the order of their first buildings, and the pairs that no row holds."""
        for name in repeated(house.name for house in self.houses):
            places = [place for house, place in zip(self.houses, self.places, strict=True) if house.name == name]
            self.notes.faults.append(f"{', '.join(places)}: {shown(name)} is the name of each; tell them apart")
        shapes = [house.footprint for house in self.houses if house.footprint is not None]
        if len(shapes) < len(self.houses):
            return self._lined_up_by_walls()
        # Each group of close buildings has an axis of its own, unless one is stated.
        near, clearances = footprints.close_pairs(shapes, reach(self.rules))
        distances = dict(zip(map(tuple, near.tolist()), clearances.tolist(), strict=True))
        views = [self._view(shapes, pairs) for pairs in footprints.groups(len(shapes), near)]
        outlines = {number: outline for view in views for number, outline in view.outlines.items()}
        directions = {number: footprints.azimuth(view.axes[0]) for view in views for number in view.outlines}
        reasons: dict[frozenset[int], str] = {}
        # Whether a pair overlaps across the street, as where one building reaches around the other.
        across = {frozenset(pair[:2]): pair.gap < -self._overlap for view in views for pair in view.across}
        along_pairs = (pair for view in views for pair in view.along)
        adjacent = self._adjacent(self._possible_neighbours(along_pairs, outlines, across, reasons), reasons)
        rows = list(self._rows(adjacent, directions))
        self._note_partial([each for row in rows for each in row.pairs if each.is_partial])
        self._note_given(rows)
        neighbours, close = {frozenset(neighbour[:2]) for neighbour in adjacent}, []
        for (first, second), distance in distances.items():
            key = frozenset((first, second))
            if distance < self.rules.limit and key not in neighbours:
                reason = reasons.get(key)
                if not reason:  # they do not face each other along the street
                    low, high = ([getattr(outlines[at], end)[0] for at in key] for end in ("low", "high"))
                    reason = INSIDE if across.get(key) else ACROSS if min(high) > max(low) else CORNER
                pair = self.houses[first], self.houses[second]
                close.append(close_pair(*pair, distance, reason, self.rules, self.resolution))
        return LinedUp(rows, close, self._sides(views))

    def _lined_up_by_walls(self) -> LinedUp:
        """Each building and the next without footprints: by their left walls, or without any as the file lists them."""
        walls = [house.walls for house in self.houses]
        without_wall = [self._label(number) for number, (left, _) in enumerate(walls) if isnan(left)]
        order = range(len(walls)) if without_wall else sorted(range(len(walls)), key=lambda number: walls[number][0])
        if 0 < len(without_wall) < len(walls):
            repair = "write it, or leave the walls of all buildings out"
            self.notes.faults.append(
                f"{listed(without_wall)}: no left wall, by which the others are in order; {repair}"
            )
            return LinedUp([], [], [])
        facings = [Facing(left, right, walls[right][0] - walls[left][1]) for left, right in pairwise(order)]
        return LinedUp(list(self._rows(self._adjacent(facings, {}), {})), [], [])  # without footprints no more is known

    @property
    def _overlap(self) -> float:
        """The largest overlap [m] of walls that are taken to touch."""
        return self.rules.survey if isnan(self.resolution) else max(self.rules.survey, self.resolution)

    def _view(self, shapes: Sequence[Any], pairs: Pairs) -> View:
        """The buildings of close pairs along the stated axis, or the one along which most of them face each other."""
        members, local = np.unique(pairs, return_inverse=True)
        own = [shapes[member] for member in members]
        stated = self.rules.axis
        plain = [footprints.outline_of(shape) for shape in own]
        if stated is None:
            both = footprints.axes(own, plain)
        else:
            along = np.array([sin(radians(stated)), cos(radians(stated))])  # east, north
            both = along, np.array([-along[1], along[0]])
        outlines = [[footprints.turned(outline, axis) for outline in plain] for axis in both]
        near, survey = local.reshape(-1, 2), self.rules.survey
        facings = [
            [pair._replace(left=int(members[pair.left]), right=int(members[pair.right])) for pair in own]
            for own in (footprints.facing(seen, near, reach(self.rules), survey) for seen in outlines)
        ]
        first = int(stated is None and len(facings[1]) > len(facings[0]))
        axes, seen = (both[first], both[1 - first]), dict(zip(members.tolist(), outlines[first], strict=True))
        return View(axes, seen, facings[first], facings[1 - first])

    def _sides(self, views: Sequence[View]) -> list[int]:
        """The number of sides of each building, left, right, front and back, on which another one is close."""
        sides: set[tuple[int, str]] = set()
        for view in views:
            for direction, pairs in (("along", view.along), ("across", view.across)):
                for pair in pairs:
                    if pair.gap < -self._overlap:
                        sides.update(self._walls_around(*pair[:2], view.axes))
                    elif pair.gap < self.rules.limit:
                        sides |= {(pair.left, f"{direction} +"), (pair.right, f"{direction} -")}
        counts = Counter(number for number, _ in sides)
        return [counts[number] for number in range(len(self.houses))]

    def _walls_around(self, one: int, other: int, axes: tuple[Array, Array]) -> Iterator[tuple[int, str]]:
        """The sides of two buildings on which their walls are close, where one reaches around the other."""
        shapes = [self.houses[number].footprint for number in (one, other)]
        for direction, axis in zip(("along", "across"), axes, strict=True):
            outlines = [footprints.turned(footprints.outline_of(shape), axis) for shape in shapes]
            inner = int(np.prod(outlines[1].high - outlines[1].low) < np.prod(outlines[0].high - outlines[0].low))
            (first, bottom), (last, top) = outlines[inner].low, outlines[inner].high
            limit, inset = self.rules.limit, self._overlap
            for side, other_side, start in (("+", "-", last), ("-", "+", first - limit)):
                strip = footprints.box_along(axis, (start, bottom + inset), (start + limit, top - inset))
                if strip.intersects(shapes[1 - inner]):
                    yield (one, other)[inner], f"{direction} {side}"
                    yield (one, other)[1 - inner], f"{direction} {other_side}"

    def _possible_neighbours(
        self,
        pairs: Iterable[Facing],
        outlines: Mapping[int, Outline],
        across: Mapping[frozenset[int], bool],
        reasons: dict[frozenset[int], str],
    ) -> Iterator[Facing]:
        """The pairs that may be neighbours in a row; ``reasons`` gets a sentence for each that may not.

        ``across`` has the pairs that face each other across the street, and whether they overlap there too.
        """
        for pair in pairs:
            length, share, nearest = footprints.faced(outlines[pair.left], outlines[pair.right], reach(self.rules))
            key, is_overlap = frozenset((pair.left, pair.right)), pair.gap < -self._overlap
            if is_overlap and not self._lie_on_each_other(pair):
                # The footprints do not overlap: one is in the other's corner or court, or the street bends.
                reasons[key] = INSIDE if across.get(key, True) else ACROSS
            elif not is_overlap and share < self.rules.least_facing:
                reasons[key] = f"facing each other over {say(length, GAP, 2)} only ({percent(share)})"
            else:
                gap = min(pair.gap, nearest) if pair.gap > 0.0 else pair.gap
                yield pair._replace(gap=gap, faced=length, share=share)

    def _lie_on_each_other(self, pair: Facing) -> bool:
        """True where two footprints share more than a strip as wide as the accuracy of the survey."""
        left, right = (self.houses[number].footprint for number in pair[:2])
        return not left.intersection(right).buffer(-0.5 * self._overlap).is_empty

    def _overlap_words(self, left: int, right: int, gap: float) -> str:
        """The fault of two buildings that overlap; equal footprints, or else walls, are one building listed twice."""
        one, other = self.houses[left], self.houses[right]
        if one.footprint is None or other.footprint is None:
            is_same = one.walls == other.walls
        else:
            common = one.footprint.intersection(other.footprint).area
            is_same = common > SAME * max(one.footprint.area, other.footprint.area)
        if is_same:
            return "stand in the same place, as one building that is listed twice; leave one of the two out"
        return (
            f"overlap by {say(-gap, GAP, 3)} along the street, {say(self._overlap, GAP)} are allowed to the survey; "
            "correct the walls, state the direction of the street (--axis), or give a building behind the others a "
            "street of its own"
        )

    def _adjacent(self, facings: Iterable[Facing], reasons: dict[frozenset[int], str]) -> list[Facing]:
        """The pairs that are neighbours: at most one on each side of a building, with the gap that holds."""
        limit, neighbours = self.rules.limit, []
        # A wall that is a rounding error beyond another does not overlap it.
        rounded = [pair._replace(gap=round(pair.gap, FINEST_GAP) + 0.0) for pair in facings]
        for left, right, gap, *_ in rounded:
            if gap < -self._overlap:
                words = self._overlap_words(left, right, gap)
                self.notes.faults.append(f"{self._label(left)} and {self._label(right)}: {words}")
        for pair in _line_pairs(_unhidden_pairs(rounded), limit):
            gap = self._gap(pair)
            if gap < limit:
                neighbours.append(pair._replace(gap=gap, overlap=-pair.gap if pair.gap < 0.0 else 0.0))
            else:
                is_given = isfinite(self.houses[pair.left].gap)
                words = f"{say(gap, GAP)} apart along the street"
                reasons[frozenset(pair[:2])] = f"{words}, as given" if is_given else words
        right_of = {pair.left: pair.right for pair in neighbours}
        left_of = {right: left for left, right in right_of.items()}
        for left, right, *_ in rounded:
            if right_of.get(left) == right:
                continue
            reason = "in a ring of buildings, which is no line"
            ends = (left, right_of[left]) if left in right_of else (right, left_of[right]) if right in left_of else ()
            if ends:
                one, other = (self.houses[number].name for number in ends)
                reason = f"{one} has {other} as its neighbour on that side"
            reasons.setdefault(frozenset((left, right)), reason)
        # A gap that is given to the right of the last building of a row.
        for number, house in enumerate(self.houses):
            if number not in right_of and house.gap < limit:
                self.notes.faults.append(
                    f"{self._label(number)}, gap: {say(house.gap, GAP)} is given, but no building stands on its right "
                    f"within {say(limit, GAP)}; leave the gap out, or correct the order"
                )
        return neighbours

    def _rows(self, adjacent: Sequence[Facing], directions: Mapping[int, float]) -> Iterator[BlockRow]:
        pair_of_left = {pair.left: pair for pair in adjacent}
        for first in sorted(set(range(len(self.houses))) - {pair.right for pair in adjacent}):
            pairs, last = [], first
            while last in pair_of_left:
                left, right, gap, length, share, overlap = pair_of_left[last]
                left_house, right_house = self.houses[left], self.houses[right]
                has_walls = left_house.footprint is not None or not isnan(right_house.walls[0] - left_house.walls[1])
                resolution = self.resolution if has_walls and isnan(left_house.gap) else nan
                touching = 0.0 if isnan(resolution) else overlap
                pairs.append(Neighbours(left_house, right_house, gap, length, share, resolution, touching))
                last = right
            buildings = (self.houses[first], *(neighbour.right for neighbour in pairs))
            gaps = tuple(neighbour.gap for neighbour in pairs)
            yield BlockRow("", self.houses[first].street, buildings, gaps, directions.get(first, nan), tuple(pairs))

    def _note_partial(self, pairs: Sequence[Neighbours]) -> None:
        """A note on neighbours that face each other over a part of their fronts."""
        texts = [f"{pair.left.name} and {pair.right.name} {pair.faced_words}" for pair in pairs]
        if texts:
            self.notes.doubts.add(
                "",
                f"{_few(texts)}: taken as full neighbours, though a blow beside the middle turns buildings, which a "
                "row leaves out; --least-facing (least_facing in Python) parts neighbours that face each other over "
                "less",
            )

    def _note_given(self, rows: Sequence[BlockRow]) -> None:
        """A note on the pairs that given gaps belong to; a fault for a row that the file does not list in order.

        The gap of a building is that to its right, which the order of the file says where no axis is stated.
        """
        numbers = {house.place: number for number, house in enumerate(self.houses)}
        gap_words = []
        for row in rows:
            order = [numbers[house.place] for house in row.buildings]
            given = [self._label(number) for number in order if isfinite(self.houses[number].gap)]
            if given and self.rules.axis is None and order != sorted(order):
                options = f'--axis "{row.direction:.0f} deg" or "{(row.direction + 180.0) % 360.0:.0f} deg"'
                self.notes.faults.append(
                    f"{listed(given, 1)}, gap: is that to the building on the right, and the file does not list the "
                    f"row from left to right; list it so, or state which way is from left to right ({options})"
                )
            gap_words += [
                f"{say(left.gap, GAP)} between {left.name} and {right.name}"
                for left, right in pairwise(row.buildings)
                if isfinite(left.gap)
            ]
        if gap_words:
            self.notes.doubts.add("", f"gap, as given, is that to the building on the right: {_few(gap_words)}")

    def _label(self, number: int) -> str:
        return f"{self.places[number]}, {self.houses[number].name}"

    def _gap(self, pair: Facing) -> float:
        """The gap of two neighbours: as given, as measured, or by rule."""
        left, survey = self.houses[pair.left], self._overlap

        def fill(gap: float, rule: str) -> float:
            self.notes.filled.append(Filled(left.street, left.name, "gap", say(gap, GAP), rule))
            return gap

        if pair.gap < -survey:
            return inf  # a fault
        if isfinite(left.gap):
            if abs(left.gap - pair.gap) > survey:
                self.notes.faults.append(
                    f"{self._label(pair.left)} and {self._label(pair.right)}: the gap is given as "
                    f"{say(left.gap, GAP)}, but the walls are {say(pair.gap, GAP, 3)} apart; correct one of the two"
                )
            return left.gap
        if isnan(pair.gap):
            return fill(self.rules.gap, "stated for neighbours without one")
        if pair.gap < 0.0:
            return fill(0.0, f"the walls overlap by {say(-pair.gap, GAP, 2)}, within the survey's {say(survey, GAP)}")
        return pair.gap


def _few(sentences: Sequence[str]) -> str:
    """The first sentences on pairs of neighbours, and how many more there are."""
    more_text = f"; and {len(sentences) - LISTED} more ({NEIGHBOURS})" if len(sentences) > LISTED else ""
    return f"{'; '.join(sentences[:LISTED])}{more_text}"


def _unhidden_pairs(pairs: Sequence[Facing]) -> list[Facing]:
    """The pairs with their faced length less the part hidden by a building between them, which both of them face."""
    to_right: dict[int, dict[int, float]] = {}
    to_left: dict[int, set[int]] = {}
    for pair in pairs:
        to_right.setdefault(pair.left, {})[pair.right] = pair.faced
        to_left.setdefault(pair.right, set()).add(pair.left)
    unhidden = []
    for pair in pairs:
        between = to_right[pair.left].keys() & to_left[pair.right]
        hidden = max((min(to_right[pair.left][one], to_right[one][pair.right]) for one in between), default=0.0)
        unhidden.append(pair._replace(faced=max(pair.faced - hidden, 0.0)) if hidden > 0.0 else pair)
    return unhidden


def _line_pairs(pairs: Iterable[Facing], limit: float) -> list[Facing]:
    """The pairs that make lines: on each side one neighbour, with the longest faced length within the limit."""
    right_of: dict[int, int] = {}
    left_of: dict[int, int] = {}
    line_pairs = []
    for pair in sorted(pairs, key=lambda pair: (pair.gap >= limit, -pair.faced, pair.gap)):
        end = pair.right  # of the line that this pair would lengthen, or close to a ring
        while end != pair.left and end in right_of:
            end = right_of[end]
        if pair.left not in right_of and pair.right not in left_of and end != pair.left:
            right_of[pair.left], left_of[pair.right] = pair.right, pair.left
            line_pairs.append(pair)
    return sorted(line_pairs, key=lambda pair: pair[:2])
