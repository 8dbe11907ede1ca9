"""Tables of a street: CSV or GeoJSON in, one entry for each building, with all faults by line or feature at once.

A column is named with its unit, `height [m]`, or its cells have theirs, `12.5 m`; a unit is never guessed.
"""

from __future__ import annotations

import csv
import json
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pounding_risk._common.words import nearest
from pounding_risk.errors import SceneError
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.scene.street.footprints import Array, Footprint, crosses_itself, length, local, middle, ring_area
from pounding_risk.units import DAMPING, GAP, MASS, PERIOD, Quantity, QuantityError, parse, say, shown

Item = TypeVar("Item", bound=Hashable)
POSITIVE: dict[str, Any] = {"open_low": True, "open_high": True}
HEIGHT = Quantity("m", 0.0, inf, "height of a building", example="12.5 m", **POSITIVE)
AREA = Quantity("m^2", 0.0, inf, "area of a floor", example="180 m^2", **POSITIVE)
LOAD = Quantity("Pa", 0.0, inf, "load of a floor", example="10 kN/m^2", **POSITIVE)
WALL = Quantity("m", -inf, inf, "position along the street", open_low=True, open_high=True, example="24.3 m")
DEGREE = 111.2e3  # m, of latitude
COARSE = 5e-3  # m on the ground; coarser coordinates are doubted
MOST_DECIMALS = 8  # of degrees that are still so coarse
FARTHEST = 1e9  # m or degrees; no coordinate of a footprint is farther
# Words, or the quantity of a number.
COLUMNS: dict[str, Quantity | None] = {
    "name": None,
    "street": None,
    "height": HEIGHT,
    "storeys": Quantity("1", 1.0, MOST_STOREYS, "number of storeys", example="4"),
    "typology": None,
    "period": PERIOD,
    "damping": DAMPING,
    "floor mass": MASS,
    "floor area": AREA,
    "floor load": LOAD,
    "floor depth": FLOOR_DEPTH,
    "left wall": WALL,
    "right wall": WALL,
    "gap": GAP,
    "hazus type": None,
    "code level": None,
}
# Tags of OpenStreetMap that are columns here; its heights are in metres unless they have one (its wiki, Key:height).
OSM_COLUMNS = {"building:levels": "storeys"}
OSM_UNITS = {"height": "m"}
OSM_FEET = re.compile(r"""([0-9]+(?:\.[0-9]+)?)'(?:\s*([0-9]+(?:\.[0-9]+)?)\")?""")
# Values of the tag building that mean no building with floors; the others are uses, from which no typology follows.
OSM_HOLLOW = ("no", "roof", "carport", "construction", "ruins", "collapsed", "demolished", "proposed", "tent", "bridge")
NOT_KNOWN = ("na", "n/a", "n.a.", "nan", "null", "none", "nil", "unknown", "?", "-", "--", "–", "—", "#n/a")
WORDS = ("name", "street")  # columns in which any word is a value
SMALLEST, LARGEST = 0.5, 2e3  # m, across a footprint; outside, its coordinates are taken for those of the other kind
NONE = np.empty((0, 2))
HEAD = "write a head such as 'name,height [m],storeys,typology,floor area [m^2],gap [mm]' and a line for each building"
LIKE = 0.8  # from which likeness on an unknown column is taken for a misspelt one
WORLD = ("crs84", "4326")  # how a file may name longitude and latitude on WGS 84, the only coordinates of RFC 7946


class BlockError(SceneError):
    """A street's table with one or more faults; ``faults`` holds one sentence each."""


class Derived(NamedTuple):
    """A value that an inventory does not state in so many words: column, the value in words, and where it is from."""

    column: str
    value: str
    rule: str


class Entry(NamedTuple):
    """One building of a table: its place there, and the SI value or words of each column given."""

    place: str  # "line 7" or "feature 3"
    values: Mapping[str, Any]
    footprint: Footprint | None = None  # as in the file: degrees, or metres
    derived: tuple[Derived, ...] = ()


class Table(NamedTuple):
    """The buildings of a file, and sentences about the columns that are not read."""

    entries: list[Entry]
    left_out: list[str]


def read_table(path: Path, metres: bool = False) -> Table:
    """The table of a .csv, .geojson or .json file; raises BlockError with every fault of it."""
    kinds: dict[str, Callable[[str, list[str]], Table]] = {
        ".csv": _read_csv,
        ".geojson": lambda text, faults: _read_geojson(text, faults, metres),
        ".json": lambda text, faults: _read_geojson(text, faults, metres),
    }
    reader = kinds.get(path.suffix.lower())
    if reader is None:
        raise BlockError(str(path), [f'"{path.suffix}" is no table of a street; give a .csv or a .geojson file'])
    if metres and path.suffix.lower() == ".csv":
        raise BlockError(str(path), ["a CSV has no coordinates to be in metres; leave the option out"])
    faults: list[str] = []
    table = reader(file_text(path), faults)
    if not faults and not table.entries:
        faults.append(f"has no building; {HEAD}")
    if faults:
        raise BlockError(str(path), faults)
    return table


def file_text(path: Path) -> str:
    """The text of a file; raises BlockError where it cannot be read, or is not UTF-8."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise BlockError(str(path), [f"byte {error.start} is not UTF-8; save the file with that encoding"]) from None
    except OSError as error:
        folder = path.parent
        names = [file.name for file in folder.iterdir()] if folder.is_dir() else []
        near = nearest(path.name, names)
        raise BlockError(str(path), [f"cannot be read ({error.strerror}){near}; check the name"]) from None


def _columns(
    heads: Sequence[str], where: str, faults: list[str], tags: Mapping[str, str] = MappingProxyType({})
) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Column and unit of each known head, and a note on the unknown ones; faults for heads that are nearly known.

    ``tags`` are columns that have another name in the file.
    """
    columns: dict[str, tuple[str, str]] = {}
    left_out = []
    for head in heads:
        parted = re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", head, re.DOTALL)
        name = " ".join((parted[1] if parted else head).replace("_", " ").lower().split())
        name = tags.get(name, name)
        unit = (parted[2] or "").strip() if parted else ""
        near = nearest(name, COLUMNS, LIKE)
        if name not in COLUMNS:
            if near:
                faults.append(f"{where}: {shown(head)} is no column{near}; it may be {', '.join(COLUMNS)}")
            elif name:
                left_out.append(head)
        elif name in (column for column, _ in columns.values()):
            faults.append(f"{where}: {shown(head)} stands twice; leave one of the two out")
        else:
            columns[head] = name, unit
    verb = "is" if len(left_out) == 1 else "are"
    return columns, [f"{where}: {', '.join(map(shown, left_out))} {verb} not read"] if left_out else []


def csv_rows(text: str, faults: list[str], head: str) -> list[tuple[int, list[str]]]:
    """Number and cells of each line that is not blank, the head first; [] with a fault, which tells to write ``head``.

    Lines that start with # are left out.
    """
    lines = ("\n" if line.startswith("#") else line for line in text.splitlines(keepends=True))
    reader = csv.reader(lines, strict=True)
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        faults.append(f"line {reader.line_num}: is not CSV ({error}); {head}")
        return []
    if not rows:
        faults.append(f"the file is empty; {head}")
        return []
    at, heads = rows[0]
    if len(heads) == 1 and ";" in heads[0]:
        faults.append(f"line {at}: the columns are parted by semicolons; write commas, and decimal points in numbers")
        return []
    return rows


def _read_csv(text: str, faults: list[str]) -> Table:
    """The lines under a head."""
    rows = csv_rows(text, faults, HEAD)
    at, heads = rows[0] if rows else (0, [])
    if not rows:
        return Table([], [])
    columns, left_out = _columns(heads, f"line {at}", faults)
    if len(columns) < 2 and not faults:
        faults.append(f"line {at}: names no two columns of a street; {HEAD}")
    entries = []
    for at, cells in rows[1:]:
        where = f"line {at}"
        if len(cells) != len(heads):
            faults.append(f"{where}: has {len(cells)} cells, the head has {len(heads)}; write one a column")
        else:
            entries.append(Entry(where, _values(where, zip(heads, cells, strict=True), columns, faults)))
    return Table(entries, left_out)


def _values(
    where: str, cells: Iterable[tuple[str, Any]], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> dict[str, Any]:
    """The values of one building: SI numbers and words by column, without blanks."""
    values = {}
    for head, cell in cells:
        if head not in columns or cell is None or (isinstance(cell, str) and not cell.strip()):
            continue
        column, unit = columns[head]
        try:
            if column not in WORDS and isinstance(cell, str) and cell.strip().lower() in NOT_KNOWN:
                raise ValueError(
                    f"{shown(cell)} is no value; leave it empty where it is not known, to be filled by rule"
                )
            values[column] = cell_value(cell, unit, COLUMNS[column])
        except ValueError as error:
            faults.append(f"{where}, {column}: {error}")
    return values


def cell_value(cell: Any, unit: str, quantity: Quantity | None) -> Any:
    """The value of one cell; raises ValueError with a sentence."""
    if isinstance(cell, bool) or not isinstance(cell, str | int | float):
        raise ValueError(f"{shown(cell)} is neither text nor a number; write one of the two")
    text = str(cell).strip()
    if quantity is None:
        words = " ".join(text.split())
        if not words.isprintable():
            raise ValueError(f"{shown(words)} has a character that cannot be printed; leave it out")
        return words
    if unit and not re.fullmatch(r"[+-]?[0-9.]+([eE][+-]?[0-9]+)?", text):
        raise QuantityError(f"{shown(text)} is not a plain number, and the column's unit is {unit}; write a number")
    value = parse(f"{text} {unit}" if unit else text, quantity)
    if quantity is COLUMNS["storeys"]:
        if value != round(value):
            raise ValueError(f"{shown(text)} is not a whole number of storeys; write one such as 4")
        return round(value)
    return value


def _read_geojson(text: str, faults: list[str], metres: bool) -> Table:
    """The features of a collection (RFC 7946), each a polygon or several with the columns as properties."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        faults.append(f"is not JSON ({error}); export the footprints again as GeoJSON")
        return Table([], [])
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list) or document.get("type") != "FeatureCollection":
        faults.append('is no GeoJSON of footprints; write {"type": "FeatureCollection", "features": [...]}')
        return Table([], [])
    system = str(document.get("crs", "CRS84")).lower()
    if not metres and not any(name in system for name in WORLD):
        faults.append(
            f"crs: {shown(document['crs'])} is not longitude and latitude, which GeoJSON has (RFC 7946); export the "
            "file in WGS 84, or where its coordinates are metres say so with --metres (metres=True in Python)"
        )
        return Table([], [])
    properties = [each.get("properties") if isinstance(each, dict) else None for each in features]
    tables = [each if isinstance(each, dict) else {} for each in properties]
    is_osm = any(key == "building" or str(key).startswith("building:") for each in tables for key in each)
    if is_osm:
        tables = [_in_metres_of_osm(each) for each in tables]
    heads = list(dict.fromkeys(key for each in tables for key in each if not (is_osm and key == "building")))
    columns, left_out = _columns(heads, "properties", faults, OSM_COLUMNS if is_osm else {})
    left_out += _osm_notes(tables) if is_osm else []
    entries = []
    for number, (feature, table) in enumerate(zip(features, tables, strict=True), start=1):
        where = f"feature {number}"
        _check_twins(where, table, columns, faults)
        values = _values(where, table.items(), columns, faults)
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        footprint = _footprint(where, geometry, metres, faults)
        if footprint is not None:
            entries.append(Entry(where, values, footprint))
    footprints = [each.footprint for each in entries if each.footprint is not None]
    if not faults:
        faults += _other_coordinates(footprints, metres)
    return Table(entries, [*left_out, *_coarse(footprints, metres)])


def _in_metres_of_osm(tags: Mapping[str, Any]) -> dict[str, Any]:
    """The tags of a building, its height with its unit: a plain number is in metres, 12'6" in feet and inches."""
    values = dict(tags)
    for key, unit in OSM_UNITS.items():
        text = str(tags.get(key, "")).strip()
        feet = OSM_FEET.fullmatch(text)
        if feet:
            values[key] = f"{float(feet[1]) + float(feet[2] or 0.0) / 12.0!r} ft"
        elif re.fullmatch(r"[0-9]+(\.[0-9]+)?", text):
            values[key] = f"{text} {unit}"
    return values


def _osm_notes(tables: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Notes on how tags of OpenStreetMap are read, and on features that may be no building."""
    yield (
        "tags of OpenStreetMap: a height without a unit is in metres, building:levels are the storeys, and building is "
        "a use, from which no typology follows; give typology where it is known"
    )
    for number, tags in enumerate(tables, start=1):
        kind = str(tags.get("building", "")).strip().lower()
        if kind in OSM_HOLLOW:
            yield f'feature {number}: its tag building is "{kind}"; leave it out where nothing with floors stands there'


def _other_coordinates(footprints: Sequence[Footprint], metres: bool) -> Iterator[str]:
    """A fault where metres are read as degrees, or degrees as metres: no building is that large, or that small."""
    if not footprints:
        return
    if metres:
        widest = max(length([footprint]) for footprint in footprints)
        if widest < SMALLEST:
            yield (
                f"read as metres, no footprint is more than {say(widest, GAP, 2)} across: the coordinates look like "
                "longitude and latitude; leave out --metres (metres=True in Python)"
            )
        return
    least = min(length(local([footprint], middle([footprint]))) for footprint in footprints)
    if least > LARGEST:
        yield (
            f"read as longitude and latitude, every footprint is {say(least, GAP, 2)} across or more: the coordinates "
            "look like metres; say so with --metres (metres=True in Python)"
        )


def _coarse(footprints: Iterable[Footprint | None], metres: bool) -> Iterator[str]:
    """A note where the last decimal of the coordinates is larger on the ground than gaps are."""
    numbers = np.concatenate([NONE, *(ring for footprint in footprints if footprint for ring in footprint.rings)])
    for decimals in range(MOST_DECIMALS):
        size = 10.0**-decimals * (1.0 if metres else DEGREE)
        if size >= COARSE and (numbers == numbers.round(decimals)).all():
            yield (
                f"coordinates have {decimals} decimals, {say(size, GAP, 2)} on the ground, and gaps between footprints "
                "are no finer; give gap [mm] where it was measured"
            )
            return


def _check_twins(
    where: str, table: Mapping[str, Any], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> None:
    """Note a fault for positions of walls beside a footprint, which has them."""
    for head in table:
        column = columns.get(head, ("", ""))[0]
        if column in ("left wall", "right wall") and table[head] is not None:
            faults.append(f"{where}, {column}: the footprint says where the walls are; leave the property out")


def _footprint(where: str, geometry: Any, metres: bool, faults: list[str]) -> Footprint | None:
    """The outline of a feature; None, and a fault, where it has none."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    parts = geometry.get("coordinates") if isinstance(geometry, dict) else None
    if kind not in ("Polygon", "MultiPolygon") or not isinstance(parts, list) or not parts:
        kind_words = "no geometry" if kind is None else shown(kind)
        faults.append(f"{where}: has {kind_words}; a building needs its footprint, a Polygon or a MultiPolygon")
        return None
    polygons = [parts] if kind == "Polygon" else parts
    rings: list[Array] = []
    holes: list[Array] = []
    for polygon in polygons:
        for number, ring in enumerate(polygon if isinstance(polygon, list) and polygon else [None]):
            corners, wrong = _ring(ring, metres)
            if wrong:
                faults.append(f"{where}: {wrong}")
                return None
            (holes if number else rings).append(corners)
    return Footprint(tuple(rings), tuple(holes))


def _ring(ring: Any, metres: bool) -> tuple[Array, str]:
    """The corners of a ring without the last one, which is the first again; or what is wrong with it."""
    if not isinstance(ring, list) or len(ring) < 4:
        return NONE, "a ring has fewer than four positions, the first of them repeated at its end; draw it again"
    for position in ring:
        numbers = isinstance(position, list) and len(position) >= 2 and all(map(_is_number, position[:2]))
        if not numbers:
            return NONE, f"{shown(position)} is not a position; write two numbers, such as [174.776, -41.286]"
    corners = np.array([position[:2] for position in ring], dtype=np.float64)
    if not metres and (np.abs(corners) > (180.0, 90.0)).any():
        far = corners[(np.abs(corners) > (180.0, 90.0)).any(axis=1)][0]
        return NONE, (
            f"[{far[0]:g}, {far[1]:g}] is no longitude and latitude in degrees; export the file in WGS 84, or where "
            "its coordinates are metres say so with --metres (metres=True in Python)"
        )
    if not np.array_equal(corners[0], corners[-1]):
        return NONE, "a ring does not end where it starts; repeat its first position at its end"
    corners_distinct = corners[:-1][np.any(corners[1:] != corners[:-1], axis=1)]
    if len(corners_distinct) < 3 or ring_area(corners_distinct) == 0.0:
        return NONE, "a ring has no area; draw the footprint again"
    if crosses_itself(corners_distinct):
        return NONE, "a ring crosses itself; draw the footprint again, its corners in turn"
    return corners_distinct, ""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= FARTHEST


def repeated(items: Iterable[Item]) -> Iterator[Item]:
    """The items that stand more than once."""
    return (item for item, times in Counter(items).items() if times > 1)
