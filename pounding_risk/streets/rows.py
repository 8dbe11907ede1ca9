"""Streets as rows: which buildings of a table stand side by side, how far apart, and which values the table lacks.

A row is a chain of buildings whose gaps are below a limit. A wider gap parts it. Two buildings that stand closer than
the limit and that a row cannot hold as neighbours are listed with the reason; a building with none near it is alone.
Values that a table does not give are filled by `Rules`, and each is listed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isnan
from pathlib import Path
from typing import Any

from pounding_risk._common.letters import csv_text
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.written import write_folder
from pounding_risk.scene.reader import parse_scene
from pounding_risk.streets.defaults import Completed, Filled, House, Notes, Rules, unnamed
from pounding_risk.streets.footprints import Array, rings
from pounding_risk.streets.inventory import inventory_table
from pounding_risk.streets.inventory._lines import Notes as Doubts
from pounding_risk.streets.joined import with_inventory
from pounding_risk.streets.neighbours import (
    INSIDE,
    NEIGHBOURS,
    NO_AXIS,
    BlockRow,
    ClosePair,
    Street,
    between_streets,
    neighbours_csv,
)
from pounding_risk.streets.scenes import CONCRETE, FILLED, Contact, filled_csv, scene_text, slug
from pounding_risk.streets.table import (
    MAPS,
    BlockError,
    Entry,
    Mapped,
    Resolution,
    Table,
    need_maps,
    read_table,
    repeated,
)
from pounding_risk.units import GAP, parse, say, shown

BUILDINGS = "buildings.csv"
BUILDING_HEADS = (
    *("street", "name", "id", "place in the file", "row", "position", "sides adjoined"),
    *("longitude [deg]", "latitude [deg]"),
)
SIDES = ("none", "one", "two", "three", "four")
DIGITS = 9  # decimals of degrees, 0.1 mm


@dataclass(frozen=True, repr=False)
class Block(ShortRepr):
    """The rows of a street's table, the buildings in no row, and the values that were filled in.

    ``close`` are pairs that stand closer than the limit and are no neighbours in a row; without footprints they are
    not known. ``sides`` has for each building, by its street and name, the number of its sides (left, right, front and
    back) on which another one is closer than the limit. ``resolution`` is how far off measured gaps may be. ``notes``
    are sentences on columns that are not read and on doubtful values.
    """

    source: str
    rows: tuple[BlockRow, ...]
    in_no_row: tuple[House, ...]
    filled: tuple[Filled, ...]
    notes: tuple[str, ...] = ()
    rules: Rules = field(default_factory=Rules)
    close: tuple[ClosePair, ...] = ()
    sides: Mapping[tuple[str, str], int] = field(default_factory=dict)
    resolution: Resolution = field(default_factory=Resolution)

    def facts(self) -> Iterable[tuple[str, str]]:
        """Rows, buildings and number of values filled in, for its display."""
        yield "table", self.source
        yield "rows", "; ".join(" | ".join(house.name for house in row.buildings) for row in self.rows) or "none"
        yield "in no row", ", ".join(house.name for house in self.in_no_row) or "none"
        yield "close pairs in no row", str(len(self.close))
        if self.sides:
            yield "sides adjoined", "; ".join(f"{words} {number}" for words, number in self.sides_adjoined())
        yield "gaps", self.gap_words
        yield "values filled in", str(len(self.filled))

    @property
    def alone(self) -> tuple[House, ...]:
        """The buildings that stand close to no other one: along the street, and with footprints in any direction."""
        close_names = {(house.street, house.name) for pair in self.close for house in (pair.one, pair.other)}
        return tuple(house for house in self.in_no_row if (house.street, house.name) not in close_names)

    @cached_property
    def houses(self) -> tuple[House, ...]:
        """All buildings: those of the rows, and those in none."""
        return *(house for row in self.rows for house in row.buildings), *self.in_no_row

    @property
    def has_footprints(self) -> bool:
        """True where the outlines of the buildings are known, and with them what stands behind and across."""
        return any(house.footprint is not None for house in self.houses)

    def sides_adjoined(self) -> list[tuple[str, int]]:
        """How many buildings have another one on none, one, two, three or four of their sides."""
        counts = Counter(self.sides.values())
        return [(words, counts[number]) for number, words in enumerate(SIDES) if counts[number]]

    @property
    def gap_words(self) -> str:
        """How well the gaps between walls are known, in words."""
        if not self.has_footprints and all(isnan(house.walls[0]) for house in self.houses):
            text = "gaps are those of the table, or the stated one where it has none"
            return f"{text}; --resolution changes none, as no walls are known" if self.resolution.size > 0.0 else text
        if self.resolution.size > 0.0:
            size = say(self.resolution.size, GAP, 3)
            return f"measured gaps are uniform within {size} of the distance of the walls ({self.resolution.words})"
        if not self.has_footprints:
            return "gaps are those of the table or the distances of its walls, or the stated one where it has neither"
        if self.resolution.size == 0.0:
            return "gaps are the distances of the walls, which are taken for known (as stated)"
        option = "--resolution, resolution in Python, makes them distributions"
        return f"gaps are the distances of the walls; the file does not say how well its outlines are known ({option})"

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
        shared: dict[str, Any] = {"records": records, "contact": contact, "tables": tables, "gaps": self.gap_words}
        rows = zip(self.file_names(), self.rows, self._by_row(), strict=True)
        return {name: scene_text(row, *own, self.source, **shared) for name, row, own in rows}

    def file_names(self) -> list[str]:
        """The name of each row's scene; a number follows names that would be the same, or all where one has it."""
        names = [slug(row.name) for row in self.rows]

        def files(numbered: set[str]) -> list[str]:
            return [
                f"{name}-{number}.toml" if name in numbered else f"{name}.toml" for number, name in enumerate(names, 1)
            ]

        some = files(set(repeated(names)))
        return files(set(names)) if any(repeated(some)) else some

    def _by_row(self) -> list[tuple[list[Filled], list[ClosePair]]]:
        """For each row the values that were filled in for its buildings, and the pairs of `close` with one of these."""
        row_of = {(row.street, house.name): number for number, row in enumerate(self.rows) for house in row.buildings}
        by_row: list[tuple[list[Filled], list[ClosePair]]] = [([], []) for _ in self.rows]
        for filled in self.filled:
            if (filled.street, filled.building) in row_of:
                by_row[row_of[filled.street, filled.building]][0].append(filled)
        for pair in self.close:
            names = {(house.street, house.name) for house in (pair.one, pair.other)}
            for number in {row_of[name] for name in names & row_of.keys()}:
                by_row[number][1].append(pair)
        return by_row

    def buildings_csv(self) -> str:
        """Every building as CSV: its row and place in it, the sides adjoined, where it is, and its footprint.

        A footprint is WKT in degrees of WGS 84, or in metres where nothing ties the coordinates to the Earth.
        """
        mapped_houses = (house.mapped for house in self.houses if house.footprint is not None)
        in_metres = any(mapped is None or mapped.outline is None for mapped in mapped_houses)
        lines: list[Iterable[Any]] = [(*BUILDING_HEADS, f"footprint [WKT, {'m' if in_metres else 'deg'}]")]

        def add(house: House, row: str, position: str) -> None:
            mapped = house.mapped or Mapped()
            where = ["" if isnan(degrees) else f"{degrees:.8f}" for degrees in (mapped.longitude, mapped.latitude)]
            outline, wkt = house.footprint if in_metres else mapped.outline, ""
            if outline is not None:
                import shapely

                wkt = str(shapely.to_wkt(outline, rounding_precision=3 if in_metres else DIGITS))
            names = house.street, house.name, mapped.id, house.place, row
            lines.append((*names, position, self.sides.get((house.street, house.name), ""), *where, wkt))

        for row in self.rows:
            for number, member in enumerate(row.buildings):
                add(member, row.name, "end" if number in (0, len(row.buildings) - 1) else "interior")
        for single in self.in_no_row:
            add(single, "", "in no row")
        return csv_text(lines)

    def check(self) -> None:
        """Raise BlockError, with the reason, where no two buildings are neighbours in a row."""
        if self.rows:
            return
        words = f"no row: no two buildings stand within {say(self.rules.limit, GAP)} of each other along the street"
        if self.close:
            axis = "another direction of the street" if self.rules.axis is not None else "the direction of the street"
            option = " or a smaller --least-facing" if self.rules.least_facing > 0.0 else ""
            count = f"{len(self.close)} pair{'s stand' if len(self.close) > 1 else ' stands'}"
            others = [pair for pair in self.close if pair.reason != INSIDE]
            words += f" as neighbours, though {count} so close, such as {(others or self.close)[0].words}; "
            words += f"state {axis} (--axis){option}" if others else NO_AXIS
        else:
            words += "; check the walls and the coordinates, or write a larger limit (--limit)"
        raise BlockError(self.source, [words])


def block(
    path: str | Path,
    out: str | Path | None = None,
    rules: Rules | None = None,
    *,
    layer: str | None = None,
    within: str | None = None,
    inventory: str | Path | None = None,
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
    layer, within, inventory : str, optional
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
    street = read_block(path, rules, layer=layer, within=within, inventory=inventory)
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
    """Write the scene of each row, and tables of the buildings, of every close pair and of the values filled in.

    The tables are buildings.csv, neighbours.csv and filled.csv; the options are those of `block`. Returns the files.
    Raises BlockError where there is no row, SceneError where a scene would have a fault, PoundingError where a file
    cannot be written; none is left then.
    """
    street.check()
    folder, scenes = Path(out), street.scenes(records, contact=contact, tables=tables)
    tolerance = None if contact.tolerance is None else parse(contact.tolerance, GAP)
    pairs = neighbours_csv(((row.name, row.pairs) for row in street.rows), street.close, tolerance)
    texts = {**scenes, FILLED: filled_csv(street.filled), NEIGHBOURS: pairs, BUILDINGS: street.buildings_csv()}

    def checked() -> Iterator[tuple[str, str]]:  # once the folder exists: else ../EventGrid.csv would lead nowhere
        for name, text in scenes.items():
            parse_scene(text, source=str(folder / name))
        yield from texts.items()

    return list(write_folder(folder, checked()))


def read_block(
    path: str | Path,
    rules: Rules | None = None,
    *,
    layer: str | None = None,
    within: str | None = None,
    inventory: str | Path | None = None,
) -> Block:
    """Read the rows of a street's table, or of a map of footprints.

    Parameters
    ----------
    path : str or Path
        A .csv file with a head and a line for each building, or a file with a Polygon or a MultiPolygon for each and
        the columns as properties: GeoJSON (RFC 7946), GeoPackage, FlatGeobuf or GeoParquet, in any coordinate reference
        system. Files of maps need the extra ``pounding-risk[maps]``.
    rules : Rules, optional
        What fills missing values, and what makes a row.
    layer : str, optional
        Layer of a GeoPackage; needed where it has several of polygons.
    within : str, optional
        Only buildings of a map whose middle lies in there: "west, south, east, north" in degrees, or a file of
        polygons.
    inventory : str or Path, optional
        Table with the values of the buildings of a map: an inventory of OED, R2D or OpenQuake, or a street's table. A
        building stands in the footprint that holds its point, or has the id or the name of one.

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
    right), and in a CSV left wall and right wall (positions along the street; left walls of all buildings or of none).
    Without walls the lines are in the order of the street. Lines of a CSV that start with # are left out.

    Footprints are laid flat by a transverse Mercator projection about their middle, whose scale is 1 there. The axis of
    a street is that of ``rules``; without it each group of buildings that hang together has that direction of its walls
    in which most of them face each other, pointing as the file lists them.
    """
    source, rules = Path(path), rules or Rules()
    table = _table(source, rules, layer, within, inventory)
    resolution = table.resolution if rules.resolution is None else Resolution(rules.resolution, "as stated")
    notes = Notes([], [], Doubts())
    numbers = {entry.place: number for number, entry in enumerate(table.entries, start=1)}
    rows: list[BlockRow] = []
    in_no_row: list[House] = []
    close: list[ClosePair] = []
    sides: dict[tuple[str, str], int] = {}
    houses_read: list[House] = []
    streets: dict[str, list[Entry]] = {}
    for entry in table.entries:
        streets.setdefault(entry.values.get("street", ""), []).append(entry)
    for street, entries in streets.items():
        houses = [Completed(numbers[entry.place], entry, rules, notes).house() for entry in entries]
        lined_up = Street(houses, [entry.place for entry in entries], rules, notes, resolution.size).lined_up()
        in_no_row += [row.buildings[0] for row in lined_up.rows if not row.gaps]
        name, street_rows = street or source.stem, [row for row in lined_up.rows if row.gaps]
        rows += [
            row._replace(name=f"{name}, row {at}" if len(street_rows) > 1 else name)
            for at, row in enumerate(street_rows, 1)
        ]
        close += lined_up.close
        sides |= {(house.street, house.name): number for house, number in zip(houses, lined_up.sides, strict=False)}
        houses_read += houses
    if notes.faults:
        raise BlockError(str(source), notes.faults)
    if len(streets) > 1:
        close += between_streets(houses_read, rules, resolution.size)
    facts = tuple(notes.filled), (*table.left_out, *notes.doubts.sentences()), rules, tuple(close), sides, resolution
    return Block(source.name, tuple(rows), tuple(in_no_row), *facts)


def footprint_rings(path: str | Path) -> dict[tuple[str, str], tuple[Array, ...]]:
    """Rings (n, 2) [m] of the footprints of a street, by street and name; empty for a table without footprints.

    Outer rings turn anticlockwise, those of courts clockwise.

    The file is a map of footprints as `read_block` takes it, or the buildings.csv that `write_block` writes; raises
    PoundingError as `read_block`.
    """
    if not _is_buildings_csv(Path(path)):
        return {key: rings(entry.footprint, with_courts=True) for key, entry in _named_entries(Path(path)).items()}
    outlines, in_degrees = footprint_outlines(path)
    shapes = list(outlines.values())
    if in_degrees and shapes:
        from pounding_risk.streets.maps import flat_outlines

        shapes = flat_outlines(shapes)
    return {key: rings(shape, with_courts=True) for key, shape in zip(outlines, shapes, strict=True)}


def footprint_outlines(path: str | Path) -> tuple[dict[tuple[str, str], Any], bool]:
    """Footprints of a street as polygons of shapely, by street and name, and whether they are in degrees of WGS 84.

    Files and errors are those of `footprint_rings`. Coordinates that are not in degrees are metres that nothing ties to
    the Earth.
    """
    source = Path(path)
    if _is_buildings_csv(source):
        need_maps(str(source))
        from pounding_risk.streets.maps import written_outlines

        return written_outlines(source)
    entries = _named_entries(source)
    on_earth = {key: entry.mapped.outline for key, entry in entries.items() if entry.mapped is not None}
    if all(outline is not None for outline in on_earth.values()):
        return on_earth, True
    return {key: entry.footprint for key, entry in entries.items()}, False


def _is_buildings_csv(source: Path) -> bool:
    """True for the buildings.csv of `write_block`, under any name: no table of a street has footprints as WKT."""
    if source.name == BUILDINGS:
        return True
    if source.suffix.lower() != ".csv" or not source.is_file():
        return False
    with source.open("rb") as file:
        return b"footprint [WKT" in file.readline(1000)


def _named_entries(source: Path) -> dict[tuple[str, str], Entry]:
    """The entries of a table that have a footprint, by street and name."""
    entries = enumerate(_table(source, Rules(), None, None, None).entries, start=1)
    return {
        (entry.values.get("street", ""), entry.values.get("name", unnamed(number))): entry
        for number, entry in entries
        if entry.footprint is not None
    }


def _table(source: Path, rules: Rules, layer: str | None, within: str | None, inventory: str | Path | None) -> Table:
    """The buildings of a file, by its ending and its head."""
    suffix = source.suffix.lower()
    if inventory is None and layer is None and within is None:
        table = inventory_table(source, rules.metres)
        if table is not None:
            return table
    if suffix in MAPS:
        need_maps(str(source))
        from pounding_risk.streets.maps import read_map

        table = read_map(source, metres=rules.metres, layer=layer, within=within, limit=rules.limit)
        return table if inventory is None else with_inventory(table, Path(inventory))
    if suffix != ".csv":
        kinds = ", ".join((".csv", *MAPS))
        raise BlockError(
            str(source), [f"{shown(suffix or str(source))} is no table of a street; give a file that ends in {kinds}"]
        )
    if rules.metres:
        raise BlockError(str(source), ["a CSV has no coordinates to be in metres; leave the option out"])
    options = {"layer": layer, "within": within, "inventory": inventory}
    if stated := [name for name, option in options.items() if option is not None]:
        raise BlockError(str(source), [f"a CSV has no footprints, so --{stated[0]} chooses nothing; leave it out"])
    return read_table(source)
