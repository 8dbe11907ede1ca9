"""Streets as rows: which buildings of a table stand side by side, how far apart, and what the table left open.

A row is a chain of buildings whose gaps are below a limit. A wider gap parts it, and a building without a neighbour
stands alone. What a table does not give is filled by `Rules`, and every value so filled is listed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, inf, isfinite, isnan, nan, radians, sin
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.block_rules import Filled, House, Notes, Rules, house
from pounding_risk.block_scenes import CONCRETE, FILLED, Contact, filled_csv, scene_text, slug, write_texts
from pounding_risk.block_tables import BlockError, Entry, read_table, repeated
from pounding_risk.footprints import Array, Facing, azimuth, facing, length, local, middle, street_axis, turned
from pounding_risk.quantities import GAP, say, shown
from pounding_risk.scenario import parse_scene

LONGEST_STREET = 5e3  # m, within which a plane stands for the ellipsoid to 1e-3
FINEST_GAP = 4  # decimals of a metre: no survey tells less than 0.1 mm


class BlockRow(NamedTuple):
    """Buildings side by side, left to right, and the gaps between them [m]."""

    name: str
    street: str
    buildings: tuple[House, ...]
    gaps: tuple[float, ...]
    direction: float = nan  # degrees clockwise from north, from left to right; NaN without footprints


@dataclass(frozen=True)
class Block:
    """What a table holds: its rows, the buildings that stand alone, and what was filled in.

    ``notes`` are sentences on what is not read and what is doubtful.
    """

    source: str
    rows: tuple[BlockRow, ...]
    alone: tuple[House, ...]
    filled: tuple[Filled, ...]
    notes: tuple[str, ...] = ()
    rules: Rules = field(default_factory=Rules)

    def scenes(
        self,
        records: Sequence[str] | None = None,
        *,
        contact: Contact = CONCRETE,
        tables: Mapping[str, Any] | None = None,
    ) -> dict[str, str]:
        """The scene (TOML) of each row, by the name of its file.

        ``records`` are ids of the catalogue; None takes all its horizontal ones. ``tables`` adds sections, or keys to
        that of the records, such as ``{"effects": {"p_delta": {}}, "records": {"set": "fema-p695-farfield"}}``.
        Raises PoundingError for a section that belongs to the buildings.
        """
        return {
            name: scene_text(row, self.filled_of(row), self.source, records=records, contact=contact, tables=tables)
            for name, row in zip(self.file_names(), self.rows, strict=True)
        }

    def file_names(self) -> list[str]:
        """The name of each row's scene; a number tells apart those that would share one."""
        names = [slug(row.name) for row in self.rows]
        shared = set(repeated(names))
        return [f"{name}-{place}.toml" if name in shared else f"{name}.toml" for place, name in enumerate(names, 1)]

    def filled_of(self, row: BlockRow) -> list[Filled]:
        """What was filled in for the buildings of a row."""
        names = {each.name for each in row.buildings}
        return [each for each in self.filled if each.street == row.street and each.building in names]


def block(
    path: str | Path,
    out: str | Path | None = None,
    rules: Rules | None = None,
    *,
    records: Sequence[str] | None = None,
    contact: Contact = CONCRETE,
    tables: Mapping[str, Any] | None = None,
) -> Block:
    """Read a street's table, and write the scene of each row and filled.csv, what was filled in, to the folder ``out``.

    The table and ``rules`` are as for `read_block`; ``records``, ``contact`` and ``tables`` as for `Block.scenes`.
    Nothing is written where the table has a fault, or a scene would have one (SceneError).
    """
    found = read_block(path, rules)
    if out is not None:
        scenes = found.scenes(records, contact=contact, tables=tables)
        for name, text in scenes.items():
            parse_scene(text, source=name)  # so that no scene is written that cannot be read
        write_texts(Path(out), {**scenes, FILLED: filled_csv(found.filled)})
    return found


def read_block(path: str | Path, rules: Rules | None = None) -> Block:
    """The rows of a street's table, .csv or .geojson.

    A CSV has a head and a line for each building, a GeoJSON (RFC 7946) a feature with a Polygon or a MultiPolygon and
    the columns as properties. Columns, each with its unit in brackets, `height [m]`, or in its cells: name, street (one
    table may have several), height, storeys, typology, period, damping, floor mass, or floor area and floor load, gap
    (to the building on the right), and in a CSV left wall and right wall (positions along the street). Without walls
    the lines are in the order of the street. Lines of a CSV that start with # are left out.

    ``rules`` fill what is missing, and say what makes a row. A street's axis is theirs, or the walls' direction in
    which most of its buildings face each other, pointing as the file lists them.

    Raises BlockError with every fault: what is no value, what is missing, and buildings that overlap.
    """
    source, rules = Path(path), rules or Rules()
    table = read_table(source, rules.metres)
    notes = Notes([], [], list(table.left_out))
    numbers = {entry.place: number for number, entry in enumerate(table.entries, start=1)}
    outlines = [entry.footprint for entry in table.entries if entry.footprint is not None]
    origin = middle(outlines) if outlines else None  # one for all streets, so that a plan can show them
    rows: list[BlockRow] = []
    alone: list[House] = []
    for street in dict.fromkeys(entry.values.get("street", "") for entry in table.entries):
        entries = [entry for entry in table.entries if entry.values.get("street", "") == street]
        if not rules.metres:
            entries = _in_metres(entries, origin, notes.faults)
        houses = [house(numbers[entry.place], entry, rules, notes) for entry in entries]
        found = list(_Street(houses, [entry.place for entry in entries], rules, notes).rows())
        alone += [row.buildings[0] for row in found if not row.gaps]
        rows += _named(street or source.stem, [row for row in found if row.gaps])
    if notes.faults:
        raise BlockError(str(source), notes.faults)
    return Block(source.name, tuple(rows), tuple(alone), tuple(notes.filled), tuple(notes.doubts), rules)


def _in_metres(entries: Sequence[Entry], origin: Array | None, faults: list[str]) -> list[Entry]:
    """Entries of one street with their footprints, if they have any, in metres."""
    if origin is None:
        return list(entries)
    footprints = local([entry.footprint for entry in entries if entry.footprint is not None], origin)
    if length(footprints) > LONGEST_STREET:
        places = f"{entries[0].place} to {entries[-1].place}"
        faults.append(
            f"{places}: their footprints lie {say(length(footprints), GAP, 3)} apart, a street has at most "
            f'{say(LONGEST_STREET, GAP)}; tell streets apart in a property "street"'
        )
    return [entry._replace(footprint=flat) for entry, flat in zip(entries, footprints, strict=True)]


def _named(name: str, rows: Sequence[BlockRow]) -> list[BlockRow]:
    """The rows of a street, numbered where there are several."""
    if len(rows) == 1:
        return [rows[0]._replace(name=name)]
    return [row._replace(name=f"{name}, row {number}") for number, row in enumerate(rows, start=1)]


class _Street(NamedTuple):
    """The buildings of one street, where each stands in the file, and what lines them up."""

    houses: list[House]
    places: list[str]
    rules: Rules
    notes: Notes

    def rows(self) -> Iterator[BlockRow]:
        """Rows, and buildings alone as rows without a gap, in the order of their first buildings."""
        self._check_names()
        direction, axis = nan, self.rules.axis
        if all(each.footprint is not None for each in self.houses):
            footprints = [each.footprint for each in self.houses if each.footprint is not None]
            reach, least = self.rules.limit + self.rules.survey, self.rules.survey
            if axis is None:
                along = street_axis(footprints, reach, least)
            else:
                along = np.array([sin(radians(axis)), cos(radians(axis))])
            direction = azimuth(along)
            pairs = facing(turned(footprints, along), reach, least)
        else:
            pairs = list(_by_walls([each.walls for each in self.houses]))
        # A wall that is a rounding error beyond another does not overlap it.
        rounded = [pair._replace(gap=round(pair.gap, FINEST_GAP) + 0.0) for pair in pairs]
        settled = [pair._replace(gap=self._gap(pair)) for pair in rounded]
        kept = [pair for pair in settled if pair.gap < self.rules.limit]
        self._check_line(kept)
        after = {pair.left: pair for pair in kept}
        for first in sorted(set(range(len(self.houses))) - {pair.right for pair in kept}):
            members, gaps = [first], []
            while members[-1] in after and len(members) <= len(self.houses):
                pair = after[members[-1]]
                members.append(pair.right)
                gaps.append(pair.gap)
            buildings = tuple(self.houses[place] for place in members)
            yield BlockRow("", buildings[0].street, buildings, tuple(gaps), direction)

    def _where(self, place: int) -> str:
        return f"{self.places[place]}, {self.houses[place].name}"

    def _check_names(self) -> None:
        for name in repeated(each.name for each in self.houses):
            places = [where for each, where in zip(self.houses, self.places, strict=True) if each.name == name]
            self.notes.faults.append(f"{', '.join(places)}: {shown(name)} is the name of each; tell them apart")

    def _gap(self, pair: Facing) -> float:
        """The gap of two neighbours: as given, as measured, or by rule."""
        left = self.houses[pair.left]
        both = f"{self._where(pair.left)} and {self._where(pair.right)}"
        survey = self.rules.survey

        def fill(gap: float, rule: str) -> float:
            self.notes.filled.append(Filled(left.street, left.name, "gap", say(gap, GAP), rule))
            return gap

        if pair.gap < -survey:
            self.notes.faults.append(
                f"{both}: overlap by {say(-pair.gap, GAP, 3)} along the street, {say(survey, GAP)} are allowed to the "
                "survey; correct the walls, or give a building behind the others a street of its own"
            )
            return inf
        if isfinite(left.gap):
            if abs(left.gap - pair.gap) > survey:
                self.notes.faults.append(
                    f"{both}: the gap is given as {say(left.gap, GAP)}, but the walls are {say(pair.gap, GAP, 3)} "
                    "apart; correct one of the two"
                )
            return left.gap
        if isnan(pair.gap):
            return fill(self.rules.gap, "stated for neighbours without one")
        if pair.gap < 0.0:
            return fill(0.0, f"the walls overlap by {say(-pair.gap, GAP, 2)}, within the survey's {say(survey, GAP)}")
        return pair.gap

    def _check_line(self, kept: Sequence[Facing]) -> None:
        """A fault for a building with two neighbours on one side, and for a gap that leads nowhere."""
        onward = [(pair.left, pair.right) for pair in kept]
        for side, ways in (("right", onward), ("left", [(right, left) for left, right in onward])):
            for place in repeated(own for own, _ in ways):
                faced = " and ".join(self._where(other) for own, other in ways if own == place)
                self.notes.faults.append(
                    f"{self._where(place)}: has two neighbours on its {side}, {faced}; a row is one line: leave one "
                    "out, or give it a street of its own"
                )
        started = {pair.left for pair in kept}
        for place, each in enumerate(self.houses):
            if place not in started and each.gap < self.rules.limit:
                self.notes.faults.append(
                    f"{self._where(place)}, gap: {say(each.gap, GAP)} is given, but no building stands on its right "
                    f"within {say(self.rules.limit, GAP)}; leave the gap out, or correct the order"
                )


def _by_walls(walls: Sequence[tuple[float, float]]) -> Iterator[Facing]:
    """Each building and the next: by their left walls where all are given, else as the file lists them."""
    order: Iterable[int] = range(len(walls))
    if not any(isnan(left) for left, _ in walls):
        order = sorted(order, key=lambda place: walls[place][0])
    for left, right in pairwise(order):
        yield Facing(left, right, walls[right][0] - walls[left][1])
