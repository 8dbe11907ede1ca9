"""Tables of a street: CSV or GeoJSON in, one entry a building, with every fault by line or feature at once.

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
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pounding_risk.contact_points import FLOOR_DEPTH
from pounding_risk.errors import SceneError
from pounding_risk.footprints import Array, Footprint, crosses_itself, ring_area
from pounding_risk.quantities import DAMPING, GAP, MASS, PERIOD, Quantity, QuantityError, parse, say, shown
from pounding_risk.scene_text import nearest
from pounding_risk.storeys import MOST_STOREYS

Item = TypeVar("Item", bound=Hashable)
POSITIVE: dict[str, Any] = {"open_low": True, "open_high": True}
HEIGHT = Quantity("m", 0.0, inf, "height of a building", example="12.5 m", **POSITIVE)
AREA = Quantity("m^2", 0.0, inf, "area of a floor", example="180 m^2", **POSITIVE)
LOAD = Quantity("Pa", 0.0, inf, "load of a floor", example="10 kN/m^2", **POSITIVE)
WALL = Quantity("m", -inf, inf, "position along the street", open_low=True, open_high=True, example="24.3 m")
DEGREE = 111.2e3  # m, of latitude
COARSE = 5e-3  # m on the ground; coordinates that tell no less are doubted
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
}
NONE = np.empty((0, 2))
HEAD = "write a head such as 'name,height [m],storeys,typology,floor area [m^2],gap [mm]' and a line for each building"
LIKE = 0.8  # from which likeness on an unknown column is taken for a misspelt one
WORLD = ("crs84", "4326")  # how a file may name longitude and latitude on WGS 84, the only coordinates of RFC 7946


class BlockError(SceneError):
    """A street's table with one or more faults; ``faults`` holds one sentence each."""


class Entry(NamedTuple):
    """One building as the table has it: where it stands there, the SI value or words of each column given."""

    place: str  # "line 7" or "feature 3"
    values: Mapping[str, Any]
    footprint: Footprint | None = None  # as in the file: degrees, or metres


class Table(NamedTuple):
    """The buildings of a file, and the columns that are not read, in words."""

    entries: list[Entry]
    left_out: list[str]


def read_table(path: Path, metres: bool = False) -> Table:
    """The table of a .csv, .geojson or .json file; raises BlockError with every fault of it."""
    kinds: dict[str, Callable[[str, list[str]], Table]] = {
        ".csv": _read_csv,
        ".geojson": lambda text, faults: _read_geojson(text, faults, metres),
        ".json": lambda text, faults: _read_geojson(text, faults, metres),
    }
    read = kinds.get(path.suffix.lower())
    if read is None:
        raise BlockError(str(path), [f'"{path.suffix}" is no table of a street; give a .csv or a .geojson file'])
    if metres and path.suffix.lower() == ".csv":
        raise BlockError(str(path), ["a CSV has no coordinates to be in metres; leave the option out"])
    faults: list[str] = []
    table = read(_text(path), faults)
    if not faults and not table.entries:
        faults.append(f"has no building; {HEAD}")
    if faults:
        raise BlockError(str(path), faults)
    return table


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise BlockError(str(path), [f"byte {error.start} is not UTF-8; save the file with that encoding"]) from None
    except OSError as error:
        folder = path.parent
        names = [each.name for each in folder.iterdir()] if folder.is_dir() else []
        near = nearest(path.name, names)
        raise BlockError(str(path), [f"cannot be read ({error.strerror}){near}; check the name"]) from None


def _columns(heads: Sequence[str], where: str, faults: list[str]) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Column and unit of each head that is one, and what is left out; faults for heads that are nearly one."""
    found: dict[str, tuple[str, str]] = {}
    left_out = []
    for head in heads:
        parted = re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", head, re.DOTALL)
        name = " ".join((parted[1] if parted else head).replace("_", " ").lower().split())
        unit = (parted[2] or "").strip() if parted else ""
        near = nearest(name, COLUMNS, LIKE)
        if name not in COLUMNS:
            if near:
                faults.append(f"{where}: {shown(head)} is no column{near}; it may be {', '.join(COLUMNS)}")
            elif name:
                left_out.append(f"{where}: {shown(head)} is not read")
        elif name in (column for column, _ in found.values()):
            faults.append(f"{where}: {shown(head)} stands twice; leave one of the two out")
        else:
            found[head] = name, unit
    return found, left_out


def _read_csv(text: str, faults: list[str]) -> Table:
    """Lines under a head; those that start with # are left out."""
    lines = ("\n" if line.startswith("#") else line for line in text.splitlines(keepends=True))
    reader = csv.reader(lines, strict=True)
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        faults.append(f"line {reader.line_num}: is not CSV ({error}); {HEAD}")
        return Table([], [])
    if not rows:
        faults.append(f"the file is empty; {HEAD}")
        return Table([], [])
    at, heads = rows[0]
    if len(heads) == 1 and ";" in heads[0]:
        faults.append(f"line {at}: the columns are parted by semicolons; write commas, and decimal points in numbers")
        return Table([], [])
    columns, left_out = _columns(heads, f"line {at}", faults)
    if len(columns) < 2 and not faults:
        faults.append(f"line {at}: names no two columns of a street; {HEAD}")
    entries = []
    for at, cells in rows[1:]:
        place = f"line {at}"
        if len(cells) != len(heads):
            faults.append(f"{place}: has {len(cells)} cells, the head has {len(heads)}; write one a column")
        else:
            entries.append(Entry(place, _values(place, zip(heads, cells, strict=True), columns, faults)))
    return Table(entries, left_out)


def _values(
    place: str, cells: Iterable[tuple[str, Any]], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> dict[str, Any]:
    """What one building gives: SI values and words by column, without blanks."""
    values = {}
    for head, cell in cells:
        if head not in columns or cell is None or (isinstance(cell, str) and not cell.strip()):
            continue
        column, unit = columns[head]
        try:
            values[column] = _value(cell, unit, COLUMNS[column])
        except ValueError as error:
            faults.append(f"{place}, {column}: {error}")
    return values


def _value(cell: Any, unit: str, quantity: Quantity | None) -> Any:
    """One cell; raises ValueError with a sentence."""
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
        whole = json.loads(text)
    except (ValueError, RecursionError) as error:
        faults.append(f"is not JSON ({error}); export the footprints again as GeoJSON")
        return Table([], [])
    features = whole.get("features") if isinstance(whole, dict) else None
    if not isinstance(features, list) or whole.get("type") != "FeatureCollection":
        faults.append('is no GeoJSON of footprints; write {"type": "FeatureCollection", "features": [...]}')
        return Table([], [])
    system = str(whole.get("crs", "CRS84")).lower()
    if not metres and not any(known in system for known in WORLD):
        faults.append(
            f"crs: {shown(whole['crs'])} is not longitude and latitude, which GeoJSON has (RFC 7946); export the file "
            "in WGS 84, or where its coordinates are metres say so with the option metres"
        )
        return Table([], [])
    properties = [each.get("properties") if isinstance(each, dict) else None for each in features]
    tables = [each if isinstance(each, dict) else {} for each in properties]
    columns, left_out = _columns(list(dict.fromkeys(key for each in tables for key in each)), "properties", faults)
    entries = []
    for number, (feature, table) in enumerate(zip(features, tables, strict=True), start=1):
        place = f"feature {number}"
        _check_twins(place, table, columns, faults)
        values = _values(place, table.items(), columns, faults)
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        footprint = _footprint(place, geometry, metres, faults)
        if footprint is not None:
            entries.append(Entry(place, values, footprint))
    return Table(entries, [*left_out, *_coarse([each.footprint for each in entries], metres)])


def _coarse(footprints: Iterable[Footprint | None], metres: bool) -> Iterator[str]:
    """A note where the last decimal of the coordinates is larger on the ground than gaps are."""
    numbers = np.concatenate([NONE, *(ring for each in footprints if each for ring in each.rings)])
    for decimals in range(MOST_DECIMALS):
        size = 10.0**-decimals * (1.0 if metres else DEGREE)
        if size >= COARSE and (numbers == numbers.round(decimals)).all():
            yield (
                f"coordinates have {decimals} decimals, {say(size, GAP, 2)} on the ground, and gaps between footprints "
                "are no finer; give gap [mm] where it was measured"
            )
            return


def _check_twins(
    place: str, table: Mapping[str, Any], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> None:
    """Walls have no place beside footprints, which say where they are."""
    for head in table:
        column = columns.get(head, ("", ""))[0]
        if column in ("left wall", "right wall") and table[head] is not None:
            faults.append(f"{place}, {column}: the footprint says where the walls are; leave the property out")


def _footprint(place: str, geometry: Any, metres: bool, faults: list[str]) -> Footprint | None:
    """The outline of a feature; None, and a fault, where it has none."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    parts = geometry.get("coordinates") if isinstance(geometry, dict) else None
    if kind not in ("Polygon", "MultiPolygon") or not isinstance(parts, list) or not parts:
        told = "no geometry" if kind is None else shown(kind)
        faults.append(f"{place}: has {told}; a building needs its footprint, a Polygon or a MultiPolygon")
        return None
    polygons = [parts] if kind == "Polygon" else parts
    rings: list[Array] = []
    holes: list[Array] = []
    for polygon in polygons:
        for number, ring in enumerate(polygon if isinstance(polygon, list) and polygon else [None]):
            corners, wrong = _ring(ring, metres)
            if wrong:
                faults.append(f"{place}: {wrong}")
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
            "its coordinates are metres say so with the option metres"
        )
    if not np.array_equal(corners[0], corners[-1]):
        return NONE, "a ring does not end where it starts; repeat its first position at its end"
    kept = corners[:-1][np.any(corners[1:] != corners[:-1], axis=1)]
    if len(kept) < 3 or ring_area(kept) == 0.0:
        return NONE, "a ring has no area; draw the footprint again"
    if crosses_itself(kept):
        return NONE, "a ring crosses itself; draw the footprint again, its corners in turn"
    return kept, ""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= FARTHEST


def repeated(items: Iterable[Item]) -> Iterator[Item]:
    """Those that stand more than once."""
    return (item for item, times in Counter(items).items() if times > 1)
