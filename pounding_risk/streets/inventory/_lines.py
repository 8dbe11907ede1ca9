"""Lines of an inventory, and the readers of their cells: numbers with their range, points, outlines, own columns."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk._common.letters import refused
from pounding_risk._common.tables import csv_rows, split_unit, uneven
from pounding_risk._common.words import listed
from pounding_risk.streets.geojson import POLYGONS, collection_of, is_position, polygons_of, properties_of
from pounding_risk.streets.hazus import FAMILIES
from pounding_risk.streets.table import COLUMNS, NOT_KNOWN, Derived, cell_value
from pounding_risk.units import shown

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?")
HEAD = "write the head of its format and a line for each building"
SAID = 6  # columns that a note names
FIRST_YEAR, LAST_YEAR = 1000, 2100
WKT = re.compile(r"(?:SRID=(\d+);)?\s*(POINT|POLYGON|MULTIPOLYGON)\s*(?:Z|M|ZM)?\s*(\(.*\))", re.IGNORECASE | re.DOTALL)
SHAPES = {"POINT": "Point", "POLYGON": "Polygon", "MULTIPOLYGON": "MultiPolygon"}
WGS84 = "4326"
DEGREES = (180.0, 90.0)  # the largest longitude and latitude
NO_DEGREES = "{} is no longitude and latitude in degrees; write [23.73, 37.98]"
WHAT = "buildings"  # of a GeoJSON
WKT_HELP = 'write "POLYGON ((23.72 37.98, 23.73 37.98, 23.73 37.99, 23.72 37.98))", longitude before latitude'


class Line(NamedTuple):
    """A line of a table, or a feature: its cells by head in lower case, without those that are blank or not known."""

    place: str
    cells: Mapping[str, str]
    geometry: Any = None  # of a feature

    @classmethod
    def of(cls, place: str, cells: Iterable[tuple[str, Any]], geometry: Any = None) -> Line:
        """A line from all its cells by head."""
        texts = ((key_of(head), json.dumps(cell) if isinstance(cell, dict) else str(cell)) for head, cell in cells)
        known_cells = {key: text for key, text in texts if text.strip() and text.strip().lower() not in NOT_KNOWN}
        return cls(place, known_cells, geometry)


class Sheet(NamedTuple):
    """The lines of an inventory and the heads as they are written."""

    path: Path
    heads: tuple[str, ...]
    lines: list[Line]
    facts: Mapping[str, Any] = {}  # of metadata beside the table

    def unit(self, head: str) -> str:
        """The unit in brackets behind a head, "" where it has none."""
        units = (split_unit(head_text)[1] for head_text in self.heads if key_of(head_text) == head.lower())
        return next(filter(None, units), "")

    def own(self, format_heads: Iterable[str], notes: Notes, prefix: str = "") -> dict[str, tuple[str, str]]:
        """Column and unit, by key, of columns of a street's table beside the ``format_heads``.

        Foreign columns may have such names too, so a head needs a unit, as "gap [mm]", or the format's prefix for
        columns of its users. A note lists the other columns with cells, which are not read.
        """
        format_keys = {head.lower() for head in format_heads}
        columns = {}
        for key in map(key_of, self.heads):
            name = " ".join(key.removeprefix(prefix).replace("_", " ").split())
            is_own = self.unit(key) or name == "street" or (prefix and key.startswith(prefix))
            if key not in format_keys and name in COLUMNS and is_own:
                columns[key] = name, self.unit(key)
        used_keys = {key for line in self.lines for key in line.cells} - format_keys - set(columns)
        unread = [shown(head) for head in self.heads if key_of(head) in used_keys]
        if unread:
            notes.add("", f"head: {listed(unread, SAID)} {'is' if len(unread) == 1 else 'are'} not read")
        return columns

    def name_head(self, *heads: str) -> str:
        """The first of some heads whose cells differ in every line; "" where none does."""
        for head in heads:
            names = [line.cells.get(head.lower(), "") for line in self.lines]
            if all(names) and len(set(names)) == len(names):
                return head
        return ""


class Building(NamedTuple):
    """A building of an inventory: its place there, its values by column as of a street's table, and where it stands."""

    place: str  # "line 7", "feature 3" or "asset 2"
    values: Mapping[str, Any]
    longitude: float = nan  # degrees, WGS 84
    latitude: float = nan
    footprint: str = ""  # well-known text in degrees, longitude before latitude
    taxonomy: str = ""  # as it stands in the file
    year: int | None = None
    derived: tuple[Derived, ...] = ()  # values that follow from a code or a convention of the format


class Kind(NamedTuple):
    """The meaning of a code of a format: family of Hazus and typology, "" where none fits, and words."""

    hazus: str
    typology: str
    words: str

    @classmethod
    def of_hazus(cls, family: str) -> Kind:
        """The kind of a family of Hazus."""
        return cls(family, FAMILIES[family].typology, FAMILIES[family].words)


class Notes:
    """Sentences on lines, each once with the lines that it holds for."""

    def __init__(self) -> None:
        self._places: dict[str, list[str]] = {}

    def add(self, place: str, words: str) -> None:
        """Note a sentence on a line; "" is the file."""
        self._places.setdefault(words, []).append(place)

    def sentences(self) -> Iterator[str]:
        """Each sentence behind its first line and the number of others."""
        for words, places in self._places.items():
            others_text = f" and {counted(len(places) - 1, 'other')}" if len(places) > 1 else ""
            yield f"{places[0]}{others_text}: {words}" if places[0] else words


class Draft:
    """A line on its way to an entry: values by column, those that are derived, and faults."""

    def __init__(self, line: Line, faults: list[str], notes: Notes) -> None:
        self.line, self.faults, self.notes = line, faults, notes
        self.values: dict[str, Any] = {}
        self.derived: list[Derived] = []

    def fault(self, head: str, words: str) -> None:
        """Note a fault of a cell."""
        self.faults.append(f"{self.line.place}, {head}: {words}")

    def note(self, words: str) -> None:
        """Note a doubt, or a cell that is not read, in this line."""
        self.notes.add(self.line.place, words)

    def text(self, head: str) -> str:
        """Words of a cell; "" where it has none."""
        words = " ".join(self.line.cells.get(head.lower(), "").split())
        fault_text = refused(words)
        if fault_text:
            self.fault(head, fault_text)
        return "" if fault_text else words

    def number(self, head: str, low: float = -inf, high: float = inf) -> float | None:
        """The number of a cell from ``low`` to ``high``; None where it has none, with a fault where it is wrong."""
        text = self.line.cells.get(head.lower(), "").strip()
        if not text:
            return None
        parsed = float(text) if NUMBER.fullmatch(text) else nan
        if isfinite(parsed) and low <= parsed <= high:
            return parsed
        least, most = (f"{bound:g}" if isfinite(bound) else "" for bound in (low, high))
        span = " to ".join(filter(None, (least, most))) if most else f"{least} or more" if least else ""
        self.fault(head, f"{shown(text)} is not a number{span and f' from {span}'}; correct it or leave it empty")
        return None

    def whole(self, head: str, low: float = -inf, high: float = inf) -> int | None:
        """The whole number of a cell, which may be written as 4.0; as `number`."""
        number = self.number(head, low, high)
        if number is None or number == round(number):
            return None if number is None else round(number)
        self.fault(head, f"{shown(self.line.cells[head.lower()])} is not a whole number; write one such as 4")
        return None

    def put(self, column: str, value: Any, words: str = "", rule: str = "") -> None:
        """Set a column; with a rule it is listed as derived, ``words`` being the value."""
        self.values[column] = value
        self.derived = [item for item in self.derived if item.column != column]
        if rule:
            self.derived.append(Derived(column, words or str(value), rule))

    def kind(self, kind: Kind, source_text: str) -> None:
        """Set typology and family from a code; ``source_text`` names it, "ConstructionCode 5153"."""
        rule = f"{source_text}, {kind.words}"
        if kind.typology:
            self.put("typology", kind.typology, rule=rule)
        else:
            exception_text = ", unless storeys are made by Hazus" if kind.hazus else ""
            fallback = "one that a column or the map gives is taken, or else the one stated for buildings without one"
            self.note(f"{rule}, has no typology here; {fallback}{exception_text}")
        if kind.hazus:
            self.put("hazus type", kind.hazus, rule=rule)

    def year(self, head: str) -> int | None:
        """The year of a cell; None for 0, an unknown one."""
        year = self.whole(head)
        if not year:
            return None
        if not FIRST_YEAR <= year <= LAST_YEAR:
            self.fault(head, f"{year} is no year from {FIRST_YEAR} to {LAST_YEAR}; correct it or leave it empty")
            return None
        return year

    def single(self, head: str, unknown: Sequence[float] = ()) -> None:
        """Refuse a line that stands for several buildings, or for a part of one."""
        number = self.number(head, 0.0)
        if number not in (None, 1.0, *unknown):
            words = "in a street each stands somewhere; write a line for each, or leave the line out"
            self.fault(head, f"the line stands for {number:g} buildings, and {words}")

    def point(self, longitude: str, latitude: str) -> tuple[float, float]:
        """Longitude and latitude in degrees; NaN where the line has neither."""
        east, north = self.number(longitude, -180.0, 180.0), self.number(latitude, -90.0, 90.0)
        cells = self.line.cells
        if (longitude.lower() in cells) != (latitude.lower() in cells):
            missing, given = (longitude, latitude) if latitude.lower() in cells else (latitude, longitude)
            self.fault(missing, f"missing beside {given}; write both or neither")
        return (nan, nan) if east is None or north is None else (east, north)

    def place_of(self, position: Any) -> tuple[float, float]:
        """Longitude and latitude of a position of GeoJSON; NaN, with a fault, where it is none."""
        if is_position(position, DEGREES):
            return float(position[0]), float(position[1])
        self.fault("geometry", NO_DEGREES.format(shown(position)))
        return nan, nan

    def outline(self, head: str, geometry: Any) -> str:
        """The outline of a GeoJSON geometry as well-known text; "" for a point, and with a fault for any other."""
        if not isinstance(geometry, dict) or geometry.get("type") == "Point":
            return ""
        try:
            return outline_text(geometry)
        except ValueError as error:
            self.fault(head, str(error))
            return ""

    def wkt(self, head: str) -> Mapping[str, Any] | None:
        """The geometry of a cell in well-known text, as of GeoJSON; None where it has none."""
        text = self.line.cells.get(head.lower(), "").strip()
        if not text:
            return None
        try:
            return outline_json(text)
        except (ValueError, RecursionError) as error:
            detail = f": {error}" if str(error).startswith("SRID") else f"; {WKT_HELP}"
            self.fault(head, f"{shown(text[:60])} is no well-known text of a polygon{detail}")
            return None

    def own_columns(self, columns: Mapping[str, tuple[str, str]]) -> None:
        """Read the columns of a street's table that stand beside those of the format, as `Sheet.own` gives them."""
        for key, (name, unit) in columns.items():
            cell = self.line.cells.get(key)
            if cell is not None:
                try:
                    self.put(name, cell_value(cell, unit, COLUMNS[name]))
                except ValueError as error:
                    self.fault(key, str(error))

    def building(self, footprint: str, point: tuple[float, float], **facts: Any) -> Building:
        """The building of the line."""
        return Building(self.line.place, self.values, *point, footprint, derived=tuple(self.derived), **facts)


def outline_json(text: str) -> Mapping[str, Any]:
    """Well-known text as a geometry of GeoJSON; raises ValueError where it is not one in degrees of WGS 84."""
    match = WKT.fullmatch(text)
    if match is None:
        raise ValueError(text)
    if (match[1] or WGS84) != WGS84:
        raise ValueError(f"SRID {match[1]} is not longitude and latitude on WGS 84 ({WGS84}); write it in degrees")
    numbers = re.sub(r"[^(),]+", lambda match_text: _position(match_text[0]), match[3])
    shape = json.loads(numbers.replace("(", "[").replace(")", "]"))
    return {"type": SHAPES[match[2].upper()], "coordinates": shape}


def outline_text(geometry: Mapping[str, Any]) -> str:
    """A polygon or several in well-known text; raises ValueError with the fault of any other geometry."""
    if geometry.get("type") not in POLYGONS:
        raise ValueError(f"{shown(geometry.get('type'))} is no outline; a footprint is a Polygon or a MultiPolygon")
    texts = [f"({', '.join(map(_ring_text, polygon))})" for polygon in polygons_of(geometry)]
    return f"POLYGON {texts[0]}" if geometry["type"] == "Polygon" else f"MULTIPOLYGON ({', '.join(texts)})"


def _ring_text(ring: Sequence[Any]) -> str:
    """A ring in well-known text; raises ValueError where it is none in degrees."""
    for position in ring:
        if not is_position(position, DEGREES):
            raise ValueError(NO_DEGREES.format(shown(position)))
    return f"({', '.join(f'{float(longitude)!r} {float(latitude)!r}' for longitude, latitude, *_ in ring)})"


def _position(text: str) -> str:
    """A position of well-known text as JSON, x and y; blanks between brackets stay."""
    words = text.split()
    if not words:
        return ""
    if len(words) < 2 or not all(NUMBER.fullmatch(word) for word in words):
        raise ValueError(text)
    return f"[{float(words[0])!r}, {float(words[1])!r}]"


def heads_of(path: Path, text: str) -> list[str]:
    """Heads of a table, or keys of the first features' properties, in lower case; [] where it is neither."""
    if path.suffix.lower() == ".csv":
        first = next((line for line in io.StringIO(text) if line.strip() and not line.startswith("#")), "")
        rows = csv_rows(first, [], HEAD)
        heads = rows[0][1] if rows else []
    else:
        first_features = collection_of(text, WHAT, [], is_typed=False)["features"][:10]
        heads = list(dict.fromkeys(key for feature in first_features for key in properties_of(feature)))
    return [key_of(head) for head in heads]


def key_of(head: str) -> str:
    """A head in lower case, without its unit in brackets."""
    return split_unit(head)[0].lower()


def sheet_of(path: Path, text: str, faults: list[str]) -> Sheet:
    """The lines of a CSV table, or the features of a GeoJSON file."""
    if path.suffix.lower() == ".csv":
        return csv_sheet(path, text, faults)
    features = collection_of(text, WHAT, faults, is_typed=False)["features"]
    heads = tuple(dict.fromkeys(key for feature in features for key in properties_of(feature)))
    lines = []
    for number, feature in enumerate(features, start=1):
        cells = {"id": feature.get("id"), **properties_of(feature)}
        lines.append(Line.of(f"feature {number}", cells.items(), feature.get("geometry")))
    return Sheet(path, heads, lines)


def csv_sheet(path: Path, text: str, faults: list[str], prefix: str = "") -> Sheet:
    """The lines of a CSV table; ``prefix`` stands before their numbers where a file has several tables."""
    rows = csv_rows(text, faults, HEAD)
    if not rows:
        return Sheet(path, (), [])
    at, heads = rows[0][0], tuple(head.strip() for head in rows[0][1])
    keys = [key_of(head) for head in heads]
    repeats = sorted({head for head in heads if head and keys.count(key_of(head)) > 1})
    if repeats:
        faults.append(f"{prefix}line {at}: {', '.join(map(shown, repeats))} stands twice; leave one of the two out")
        return Sheet(path, heads, [])
    lines = []
    for at, cells in rows[1:]:
        if words := uneven(cells, heads):
            faults.append(f"{prefix}line {at}: {words}")
        else:
            lines.append(Line.of(f"{prefix}line {at}", zip(heads, cells, strict=True)))
    return Sheet(path, heads, lines)
