"""Tables of a street: CSV in, one entry for each building, with all faults by line at once; columns of maps too.

A column is named with its unit, `height [m]`, or its cells have theirs, `12.5 m`; a unit is never guessed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from importlib.util import find_spec
from math import inf, nan
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from pounding_risk._common.inputs import EXPORT, Unfit, text_of
from pounding_risk._common.letters import refused, without_mark
from pounding_risk._common.tables import csv_rows, split_unit, uneven
from pounding_risk._common.words import FIRST, listed, nearest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.units import DAMPING, GAP, MASS, PERIOD, Quantity, parse_cell, shown

Item = TypeVar("Item", bound=Hashable)
POSITIVE: dict[str, Any] = {"open_low": True, "open_high": True}
HEIGHT = Quantity("m", 0.0, inf, "height of a building", example="12.5 m", **POSITIVE)
AREA = Quantity("m^2", 0.0, inf, "area of a floor", example="180 m^2", **POSITIVE)
LOAD = Quantity("Pa", 0.0, inf, "load of a floor", example="10 kN/m^2", **POSITIVE)
STOREYS = Quantity("1", 1.0, MOST_STOREYS, "number of storeys", example="4")
WALL = Quantity("m", -inf, inf, "position along the street", open_low=True, open_high=True, example="24.3 m")
# Words, or the quantity of a number.
COLUMNS: dict[str, Quantity | None] = {
    "name": None,
    "street": None,
    "height": HEIGHT,
    "storeys": STOREYS,
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
NOT_KNOWN = ("na", "n/a", "n.a.", "nan", "null", "none", "nil", "unknown", "?", "-", "--", "–", "—", "#n/a")
WORDS = ("name", "street")  # columns in which any word is a value
HEAD = "write a head such as 'name,height [m],storeys,typology,floor area [m^2],gap [mm]' and a line for each building"
LIKE = 0.8  # likeness above which an unknown column is taken for a misspelt one


MAPS = (".geojson", ".json", ".gpkg", ".fgb", ".parquet", ".geoparquet")  # files with a footprint for each building
NEEDED = ("shapely", "pyproj", "pyogrio", "geopandas", "pyarrow")  # by these: the extra [maps]


DEGREE = 111.2e3  # m, of latitude


class BlockError(SceneError):
    """A street's table with one or more faults; ``faults`` holds one sentence each."""


class Mapped(NamedTuple):
    """Where a building is on the Earth, as far as its file says."""

    id: str = ""  # of its feature
    longitude: float = nan  # degrees, of its middle
    latitude: float = nan
    outline: Any = None  # a polygon of shapely in degrees of WGS 84


class Resolution(NamedTuple):
    """How far off the distance of two walls may be according to the file, and the origin of that number."""

    size: float = nan  # m; NaN where it is finer than gaps are
    words: str = ""


class Derived(NamedTuple):
    """A value that a file does not state itself: column, the value in words, and the rule that it is from."""

    column: str
    value: str
    rule: str


class Entry(NamedTuple):
    """One building of a table: its place there, and the SI value or words of each column given."""

    place: str  # "line 7" or "feature 3"
    values: Mapping[str, Any]
    footprint: Any = None  # a polygon of shapely, m
    mapped: Mapped | None = None
    derived: tuple[Derived, ...] = ()


class Table(NamedTuple):
    """The buildings of a file, sentences on columns that are not read, and how finely their walls are known."""

    entries: list[Entry]
    left_out: list[str]
    resolution: Resolution = Resolution()


def read_table(path: Path) -> Table:
    """The table of a .csv file; raises BlockError with every fault of it."""
    faults: list[str] = []
    text = file_text(path)
    rows = csv_rows(text, faults, HEAD)
    entries: list[Entry] = []
    left_out: list[str] = []
    if rows:
        number, heads = rows[0]
        columns, left_out = columns_of(heads, f"line {number}", faults)
        left_out += _with_mark(text.splitlines()[number:], number + 1, len(heads))
        if len(columns) < 2 and not faults:
            faults.append(f"line {number}: names no two columns of a street; {HEAD}")
        for number, cells in rows[1:]:
            place = f"line {number}"
            if words := uneven(cells, heads):
                faults.append(f"{place}: {words}")
            else:
                entries.append(Entry(place, values_of(place, zip(heads, cells, strict=True), columns, faults)))
    if not faults and not entries:
        faults.append(f"has no building; {HEAD}")
    if faults:
        raise BlockError(str(path), faults)
    return Table(entries, left_out)


def _with_mark(lines: Sequence[str], first: int, columns: int) -> list[str]:
    """A note on lines that start with #, from the ``first`` on, and have a cell for each column as buildings have."""
    comments = [(number, line) for number, line in enumerate(lines, first) if line.startswith("#")]
    places = [f"line {number}" for number, line in comments if line.count(",") >= columns - 1]
    repair = "put a name that starts with # in quotes"
    return [f"{', '.join(places)}: left out, as what starts with # is a comment; {repair}"] if places else []


def need_maps(source: str) -> None:
    """Raise PoundingError where a library of the extra [maps] is not installed."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise PoundingError(
            f"{source}: footprints need {', '.join(missing)}, not installed; pip install 'pounding-risk[maps]', or "
            "give a .csv with the positions of walls"
        )


def file_text(path: Path) -> str:
    """The text of a file; raises BlockError where it cannot be read, or is not UTF-8."""
    try:
        return text_of(path, EXPORT)
    except Unfit as error:
        raise BlockError(str(path), [str(error.strerror)]) from None


def columns_of(
    heads: Sequence[str],
    place: str,
    faults: list[str],
    tags: Mapping[str, str] = MappingProxyType({}),
    *,
    is_foreign: bool = False,
) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Column and unit of each known head, and a note on the unknown ones; faults for heads that are nearly known.

    ``tags`` are columns that have another name in the file. In a file with names of another source (``is_foreign``)
    none is taken for misspelt.
    """
    columns: dict[str, tuple[str, str]] = {}
    left_out = []
    for head in heads:
        name, unit = split_unit(head)
        name = tags.get(name.lower()) or " ".join(name.replace("_", " ").lower().split())
        hint = nearest(name, COLUMNS, LIKE)
        if name not in COLUMNS:
            if hint and not is_foreign:
                faults.append(f"{place}: {shown(head)} is no column{hint}; it may be {', '.join(COLUMNS)}")
            elif name:
                left_out.append(head)
        elif name in (column for column, _ in columns.values()):
            faults.append(f"{place}: {shown(head)} stands twice; leave one of the two out")
        else:
            columns[head] = name, unit
    verb = "is" if len(left_out) == 1 else "are"
    words = listed([*map(shown, left_out)], FIRST if is_foreign else len(left_out))
    return columns, [f"{place}: {words} {verb} not read"] if left_out else []


def values_of(
    place: str, cells: Iterable[tuple[str, Any]], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> dict[str, Any]:
    """The values of one building: SI numbers and words by column, without blanks."""
    values = {}
    for head, cell in cells:
        if head not in columns or cell is None or (isinstance(cell, str) and not cell.strip()):
            continue
        column, unit = columns[head]
        try:
            if column not in WORDS and isinstance(cell, str) and cell.strip().lower() in NOT_KNOWN:
                repair = "leave it empty where it is not known, to be filled by rule"
                raise ValueError(f"{shown(cell)} is no value; {repair}")
            values[column] = cell_value(cell, unit, COLUMNS[column])
        except ValueError as error:
            faults.append(f"{place}, {column}: {error}")
    return values


def cell_value(cell: Any, unit: str, quantity: Quantity | None) -> Any:
    """The value of one cell; raises ValueError with a sentence."""
    if isinstance(cell, bool) or not isinstance(cell, str | int | float):
        raise ValueError(f"{shown(cell)} is neither text nor a number; write one of the two")
    text = str(cell).strip()
    if quantity is None:
        words = without_mark(" ".join(text.split()))
        if fault_text := refused(words):
            raise ValueError(fault_text)
        return words
    value = parse_cell(text, unit, quantity)
    if quantity is STOREYS:
        if value != round(value):
            raise ValueError(f"{shown(text)} is not a whole number of storeys; write one such as 4")
        return round(value)
    return value


def repeated(items: Iterable[Item]) -> Iterator[Item]:
    """The items that stand more than once."""
    return (item for item, times in Counter(items).items() if times > 1)
