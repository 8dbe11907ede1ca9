"""Streets as rows: which buildings of a table stand side by side, how far apart, and what the table left open.

A row is a chain of buildings whose gaps are below a limit. A wider gap parts it. Two buildings that stand closer than
the limit and that a row cannot hold as neighbours are listed with the reason; a building with none near it is alone.
What a table does not give is filled by `Rules`, and every value so filled is listed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.street.defaults import Filled, House, Notes, Rules, house
from pounding_risk.scene.street.footprints import Array, close_pairs, length, local, middle
from pounding_risk.scene.street.inventory import inventory_table
from pounding_risk.scene.street.neighbours import (
    FINEST_GAP,
    NEIGHBOURS,
    STREETS,
    BlockRow,
    ClosePair,
    Street,
    neighbours_csv,
)
from pounding_risk.scene.street.scenes import CONCRETE, FILLED, Contact, filled_csv, scene_text, slug, write_text
from pounding_risk.scene.street.table import BlockError, Entry, read_table, repeated
from pounding_risk.units import GAP, say

LONGEST_STREET = 5e3  # m, within which a plane stands for the ellipsoid to 1e-3


@dataclass(frozen=True, repr=False)
class Block(ShortRepr):
    """The rows of a street's table, the buildings in no row, and the values that were filled in.

    ``close`` are pairs that stand closer than the limit and are no neighbours in a row; without footprints they are
    not known. ``notes`` are sentences on columns that are not read and on doubtful values.
    """

    source: str
    rows: tuple[BlockRow, ...]
    in_no_row: tuple[House, ...]
    filled: tuple[Filled, ...]
    notes: tuple[str, ...] = ()
    rules: Rules = field(default_factory=Rules)
    close: tuple[ClosePair, ...] = ()

    def facts(self) -> Iterable[tuple[str, str]]:
        """Rows, buildings and number of values filled in, for its display."""
        yield "table", self.source
        yield "rows", "; ".join(" | ".join(house.name for house in row.buildings) for row in self.rows) or "none"
        yield "in no row", ", ".join(house.name for house in self.in_no_row) or "none"
        yield "close pairs in no row", str(len(self.close))
        yield "values filled in", str(len(self.filled))

    @property
    def alone(self) -> tuple[House, ...]:
        """The buildings that stand close to no other one: along the street, and with footprints in any direction."""
        beside = {(house.street, house.name) for pair in self.close for house in (pair.one, pair.other)}
        return tuple(house for house in self.in_no_row if (house.street, house.name) not in beside)

    @property
    def has_footprints(self) -> bool:
        """True where the outlines of the buildings are known, and with them what stands behind and across."""
        houses = [*self.in_no_row, *(house for row in self.rows for house in row.buildings)]
        return any(house.footprint is not None for house in houses)

    def scenes(
        self,
        records: Sequence[str] | None = None,
        *,
        contact: Contact = CONCRETE,
        tables: Mapping[str, Any] | None = None,
    ) -> dict[str, str]:
        """The scene (TOML) of each row by the name of its file.

        ``records`` are ids of the catalogue; None takes all its horizontal ones. ``tables`` adds sections, or keys to
        that of the records, such as ``{"effects": {"p_delta": {}}, "records": {"set": "fema-p695-farfield"}}``.
        Raises PoundingError for a section that belongs to the buildings.
        """
        return {
            name: scene_text(
                row,
                self.filled_of(row),
                self.close_to(row),
                self.source,
                records=records,
                contact=contact,
                tables=tables,
            )
            for name, row in zip(self.file_names(), self.rows, strict=True)
        }

    def file_names(self) -> list[str]:
        """The name of each row's scene; a number follows names that would be the same."""
        names = [slug(row.name) for row in self.rows]
        shared = set(repeated(names))
        return [f"{name}-{number}.toml" if name in shared else f"{name}.toml" for number, name in enumerate(names, 1)]

    def filled_of(self, row: BlockRow) -> list[Filled]:
        """The values that were filled in for the buildings of a row."""
        names = {house.name for house in row.buildings}
        return [value for value in self.filled if value.street == row.street and value.building in names]

    def close_to(self, row: BlockRow) -> list[ClosePair]:
        """The pairs of `close` with a building of this row."""
        members = {(row.street, house.name) for house in row.buildings}
        return [
            pair
            for pair in self.close
            if members & {(pair.one.street, pair.one.name), (pair.other.street, pair.other.name)}
        ]

    def check(self) -> None:
        """Raise BlockError, with the reason, where no two buildings are neighbours in a row."""
        if not self.rows:
            raise BlockError(self.source, [self._no_row()])

    def _no_row(self) -> str:
        limit = f"no two buildings stand within {say(self.rules.limit, GAP)} of each other along the street"
        if not self.close:
            return f"no row: {limit}; check the walls and the coordinates, or write a larger limit (--limit)"
        axis = "another direction of the street" if self.rules.axis is not None else "the direction of the street"
        part = " or a smaller --least-facing" if self.rules.least_facing > 0.0 else ""
        count = f"{len(self.close)} pair{'s stand' if len(self.close) > 1 else ' stands'}"
        return (
            f"no row: {limit} as neighbours, though {count} so close, such as {self.close[0].words}; state {axis} "
            f"(--axis){part}"
        )


def block(
    path: str | Path,
    out: str | Path | None = None,
    rules: Rules | None = None,
    *,
    records: Sequence[str] | None = None,
    contact: Contact = CONCRETE,
    tables: Mapping[str, Any] | None = None,
) -> Block:
    """Read a street's table, and write the scenes of its rows to a folder.

    Parameters
    ----------
    path : str or Path
        The table, as for `read_block`.
    out : str or Path, optional
        Folder for the files of `write_block`; None writes nothing.
    rules : Rules, optional
        As for `read_block`.
    records : sequence of str, optional
        Ids of the catalogue; None takes all its horizontal ones.
    contact : Contact
        The law of contact of every interface, as a scene file writes it.
    tables : mapping, optional
        Further sections of the scenes, or keys of [records], as for `Block.scenes`.

    Returns
    -------
    Block
        The rows of the table. Nothing is written where the table has a fault.
    """
    street = read_block(path, rules)
    if out is not None:
        write_block(street, out, records=records, contact=contact, tables=tables)
    return street


def write_block(
    street: Block,
    out: str | Path,
    *,
    records: Sequence[str] | None = None,
    contact: Contact = CONCRETE,
    tables: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write the scene of each row, filled.csv with the values filled in, and neighbours.csv with every close pair.

    Parameters
    ----------
    street : Block
        The rows of a table.
    out : str or Path
        The folder, made where it is missing.
    records : sequence of str, optional
        Ids of the catalogue; None takes all its horizontal ones.
    contact : Contact
        The law of contact of every interface, as a scene file writes it.
    tables : mapping, optional
        Further sections of the scenes, or keys of [records], as for `Block.scenes`.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    BlockError
        Where there is no row.
    SceneError
        Where a scene would have a fault; nothing is written then.
    """
    street.check()
    scenes = street.scenes(records, contact=contact, tables=tables)
    for name, text in scenes.items():
        parse_scene(text, source=name)  # so that no scene is written that cannot be read
    pairs = neighbours_csv(((row.name, row.pairs) for row in street.rows), street.close)
    texts = {**scenes, FILLED: filled_csv(street.filled), NEIGHBOURS: pairs}
    for name, text in texts.items():
        write_text(Path(out) / name, text)
    return [Path(out) / name for name in texts]


def read_block(path: str | Path, rules: Rules | None = None) -> Block:
    """Read the rows of a street's table.

    Parameters
    ----------
    path : str or Path
        A .csv file with a head and a line for each building, or a .geojson file (RFC 7946) with a Polygon or a
        MultiPolygon for each building and the columns as properties.
    rules : Rules, optional
        What fills missing values, and what makes a row.

    Returns
    -------
    Block
        Rows, buildings in no row, and the values that were filled in.

    Raises
    ------
    BlockError
        With every fault: values that cannot be read, values that are missing, and buildings that overlap.

    Notes
    -----
    Columns, each with its unit in brackets, `height [m]`, or in its cells: name, street (one table may have several),
    height, storeys, typology, period, damping, floor mass, or floor area and floor load, gap (to the building on the
    right), and in a CSV left wall and right wall (positions along the street). Without walls the lines are in the order
    of the street. Lines of a CSV that start with # are left out.

    The axis of a street is that of ``rules``, or the direction of its walls in which most of its buildings face each
    other, pointing as the file lists them.
    """
    source, rules = Path(path), rules or Rules()
    table = inventory_table(source, rules.metres) or read_table(source, rules.metres)
    notes = Notes([], [], list(table.left_out))
    numbers = {entry.place: number for number, entry in enumerate(table.entries, start=1)}
    outlines = [entry.footprint for entry in table.entries if entry.footprint is not None]
    origin = middle(outlines) if outlines else None  # one for all streets, so that a plan can show them
    rows: list[BlockRow] = []
    in_no_row: list[House] = []
    close: list[ClosePair] = []
    every: list[tuple[House, Entry]] = []
    for street in dict.fromkeys(entry.values.get("street", "") for entry in table.entries):
        entries_of_street = [entry for entry in table.entries if entry.values.get("street", "") == street]
        entries = entries_of_street if rules.metres else _in_metres(entries_of_street, origin, notes.faults)
        houses = [house(numbers[entry.place], entry, rules, notes) for entry in entries]
        lined_up = Street(houses, [entry.place for entry in entries], rules, notes).lined_up()
        in_no_row += [row.buildings[0] for row in lined_up.rows if not row.gaps]
        rows += _named(street or source.stem, [row for row in lined_up.rows if row.gaps])
        close += lined_up.close
        every += zip(houses, entries_of_street, strict=True)
    if notes.faults:
        raise BlockError(str(source), notes.faults)
    close += _between_streets(every, rules)
    facts = tuple(notes.filled), tuple(notes.doubts), rules, tuple(close)
    return Block(source.name, tuple(rows), tuple(in_no_row), *facts)


def _between_streets(every: Sequence[tuple[House, Entry]], rules: Rules) -> list[ClosePair]:
    """Pairs of buildings of two streets that stand closer than the limit; footprints are those of the file."""
    outlined = [(house, entry.footprint) for house, entry in every if entry.footprint is not None]
    pairs = close_pairs([footprint for _, footprint in outlined], rules.limit, rules.metres)
    return [
        ClosePair(outlined[first][0], outlined[second][0], round(distance, FINEST_GAP), STREETS)
        for first, second, distance in pairs
        if outlined[first][0].street != outlined[second][0].street
    ]


def _in_metres(entries: Sequence[Entry], origin: Array | None, faults: list[str]) -> list[Entry]:
    """The entries of a street with their footprints, where they have any, in metres."""
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
