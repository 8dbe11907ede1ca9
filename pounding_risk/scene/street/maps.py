"""Files of maps as tables of a street: GeoJSON, GeoPackage, FlatGeobuf and GeoParquet, each feature a building.

Footprints are checked, repaired where what is meant is plain, and laid flat in metres; all faults are told at once by
feature. Attributes of OpenStreetMap and of Overture are read as they are. The module needs the extra [maps].
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import ceil, hypot, inf, isfinite, isnan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from pounding_risk._common.words import nearest
from pounding_risk.scene.street.footprints import Array, Geometry, last_decimal
from pounding_risk.scene.street.projection import DEGREES, Projection, system_of
from pounding_risk.scene.street.table import (
    COLUMNS,
    MAPS,
    BlockError,
    Entry,
    Mapped,
    Resolution,
    Table,
    columns_of,
    file_text,
    repeated,
    values_of,
)
from pounding_risk.units import GAP, say, shown

COARSE = 5e-3  # m on the ground; coarser coordinates are doubted
MOST_DECIMALS = 8  # of degrees that are still so coarse
FARTHEST = 1e9  # m or degrees; no coordinate of a footprint is farther
FARTHEST_APART = (
    500e3  # m; within, lengths of a transverse Mercator projection about the middle are off by 8e-4 at most
)
SMALLEST, LARGEST = 0.5, 2e3  # m, across a footprint; outside, its coordinates are taken for those of another kind
REPAIRABLE = 0.01  # share of its area by which a repair may change a footprint; else it is drawn again
MOST_FAULTS = 50  # of a map that are told
LISTED = 5  # features, or properties of a map, that a note names
WORLD = ("crs84", "4326")  # how a GeoJSON may name longitude and latitude on WGS 84, its only coordinates (RFC 7946)
GEOJSON = (".geojson", ".json")
LAYERED = {".gpkg": "GeoPackage", ".fgb": "FlatGeobuf"}
PARQUET = (".parquet", ".geoparquet")
POLYGONS = ("Polygon", "MultiPolygon")
METRES_HINT = (
    "where its coordinates are metres say so with --metres (metres=True in Python) of block, whose buildings.csv draw "
    "and export take"
)

# Tags of OpenStreetMap that are columns here; its heights are in metres unless they have one (its wiki, Key:height).
OSM_COLUMNS = {"building:levels": "storeys"}
OSM_FEET = re.compile(r"""([0-9]+(?:\.[0-9]+)?)'(?:\s*([0-9]+(?:\.[0-9]+)?)\")?""")
OTHER_TAGS = re.compile(
    r'"((?:[^"\\]|\\.)*)"=>"((?:[^"\\]|\\.)*)"'
)  # hstore, in which GDAL writes tags without a column
# Values of the tag building that mean no building with floors; the others are uses, from which no typology follows.
OSM_HOLLOW = ("no", "roof", "carport", "construction", "ruins", "collapsed", "demolished", "proposed", "tent", "bridge")
# Properties of Overture's buildings (docs.overturemaps.org/schema/reference/buildings/building); heights in metres.
OVERTURE_COLUMNS = {"num_floors": "storeys"}
OVERTURE_KEYS = ("num_floors", "has_parts", "num_floors_underground", "facade_material", "roof_shape", "is_underground")
IDS = ("id", "@id", "osm_id", "osm_way_id", "full_id")
MAPPED_FROM_IMAGES = 0.5  # m; assumed for the walls of OpenStreetMap and Overture, which say nothing of it


class Features(NamedTuple):
    """What a file of a map holds: of each feature its place there, its properties, its geometry and its id."""

    places: list[str]
    properties: list[dict[str, Any]]
    geometries: list[Geometry | None]
    ids: list[str]
    system: Any = None  # the coordinate reference system, as pyproj reads it; None where the file has none

    def chosen(self, wanted: Sequence[int]) -> Features:
        """Some of the features, by their numbers from 0."""
        keep = [(self.places[at], self.properties[at], self.geometries[at], self.ids[at]) for at in wanted]
        places, properties, geometries, ids = map(list, zip(*keep, strict=True)) if keep else ([], [], [], [])
        return Features(places, properties, geometries, ids, self.system)


def read_map(path: Path, *, metres: bool = False, layer: str | None = None, within: str | None = None) -> Table:
    """The buildings of a file of a map, with footprints in metres.

    Parameters
    ----------
    path
        A file with one of the endings `MAPS`.
    metres
        Whether coordinates are metres that no coordinate reference system ties to the Earth.
    layer
        Layer of a GeoPackage; None where it has one only.
    within
        Only buildings whose middle lies in there: "west, south, east, north" in degrees, or a file of polygons.

    Raises
    ------
    BlockError
        With every fault of the file.
    """
    faults: list[str] = []
    features = _features(path, layer, metres, faults)
    projection = None
    if not faults:
        projection = _projection(features, metres, faults)
    if not faults and within is not None:
        features = _within(features, within, projection, faults)
    if faults:
        raise BlockError(str(path), faults)
    table = _table(features, projection, faults)
    if len(faults) > MOST_FAULTS:
        faults[MOST_FAULTS:] = [f"and {len(faults) - MOST_FAULTS} more faults like these"]
    if not faults and not table.entries:
        inside = f" within {within}" if within is not None else ""
        faults.append(f"has no building{inside}; export the footprints again, a feature for each")
    if faults:
        raise BlockError(str(path), faults)
    return table


def written_outlines(path: Path) -> tuple[dict[tuple[str, str], Geometry], bool]:
    """Footprints of the buildings.csv that a street is written with, by street and name; whether they are in degrees.

    Raises BlockError for a table without names and footprints.
    """
    lines = csv.DictReader(file_text(path).splitlines())
    head = next((cell for cell in lines.fieldnames or () if cell.startswith("footprint [WKT")), "")
    if not {"street", "name", head} <= set(lines.fieldnames or ()):
        needed = "street, name and footprint [WKT, deg]"
        raise BlockError(str(path), [f"has no columns {needed}, as buildings.csv of block has; write it again"])
    cells = {(line["street"], line["name"]): line[head] for line in lines if line[head]}
    try:
        shapes = shapely.from_wkt(list(cells.values()))
    except shapely.errors.GEOSException as error:
        raise BlockError(str(path), [f"footprint: {error}; write the table again"]) from None
    return dict(zip(cells, shapes, strict=True)), "deg" in head


def flat_outlines(shapes: Sequence[Geometry]) -> list[Geometry]:
    """Footprints in degrees of WGS 84 in metres about their middle."""
    projection = Projection.about(shapely.get_coordinates(shapes), system_of(DEGREES))
    return [shapely.transform(shape, projection.metres) for shape in shapes]


# ------------------------------------------------------------------------------------------------ files


def _features(path: Path, layer: str | None, metres: bool, faults: list[str]) -> Features:
    """The features of a file, whatever its format."""
    suffix = path.suffix.lower()
    if layer is not None and suffix not in LAYERED:
        raise BlockError(str(path), [f"has no layers, so {shown(layer)} cannot be chosen; leave --layer out"])
    if suffix in GEOJSON:
        return _from_geojson(file_text(path), metres, faults)
    if not path.is_file():
        file_text(path)  # raises the sentence of a file that cannot be read
    kind = LAYERED.get(suffix, "GeoParquet")
    try:
        return _from_parquet(path) if suffix in PARQUET else _from_layer(path, layer)
    except BlockError:
        raise
    except Exception as error:  # of GDAL, pyogrio, pyarrow, pandas and shapely: whatever a damaged file brings about
        reason = " ".join(str(error).split())[:200]
        advice = "export the footprints again"
        raise BlockError(
            str(path), [f"cannot be read as {kind} ({reason or type(error).__name__}); {advice}"]
        ) from None


def _from_layer(path: Path, layer: str | None) -> Features:
    """A layer of a GeoPackage or of a FlatGeobuf."""
    import warnings

    import pyogrio

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of values that no column here has, such as dates, and of measured corners
        layers = {str(name): kind for name, kind in pyogrio.list_layers(path)}
        meta, fids, geometry, columns = pyogrio.raw.read(
            path, layer=_layer(path, layer, layers), return_fids=True, force_2d=False
        )
    names = [str(name) for name in meta["fields"]]
    rows = zip(*(column.tolist() for column in columns), strict=True) if names else ((),) * len(fids)
    properties = [dict(zip(names, map(_known, row), strict=True)) for row in rows]
    numbers = fids.tolist() if path.suffix.lower() == ".gpkg" else range(1, len(fids) + 1)  # as QGIS shows them
    shapes = [None] * len(fids) if geometry is None else _shapes(geometry)
    return Features([f"feature {number}" for number in numbers], properties, shapes, _ids(properties), meta["crs"])


def _layer(path: Path, layer: str | None, layers: Mapping[str, Any]) -> str:
    """The layer that is asked for, or the only one of polygons; raises BlockError."""
    if layer is not None:
        if layer not in layers:
            sentence = f"has no layer {shown(layer)}{nearest(layer, layers)}; it has {', '.join(layers) or 'none'}"
            raise BlockError(str(path), [sentence])
        return layer
    of_polygons = [name for name, kind in layers.items() if kind is not None and "Point" not in str(kind)]
    fitting = [name for name in of_polygons if "Polygon" in str(layers[name])] or of_polygons
    if len(fitting) != 1:
        if not fitting:
            raise BlockError(str(path), ["has no layer of polygons; export the footprints again"])
        names = ", ".join(fitting)
        raise BlockError(str(path), [f"has the layers {names}; say which one with --layer (layer= in Python)"])
    return fitting[0]


def _from_parquet(path: Path) -> Features:
    """A GeoParquet file, such as one of Overture."""
    import geopandas

    frame = geopandas.read_parquet(path)
    properties = [
        {str(key): _known(value) for key, value in row.items()}
        for row in frame.drop(columns=frame.active_geometry_name).to_dict("records")
    ]
    places = [f"feature {number}" for number in range(1, len(frame) + 1)]
    return Features(places, properties, list(frame.geometry.array), _ids(properties), frame.crs)


def _known(value: Any) -> Any:
    """A value of a table as Python has it; None where the table has none."""
    value = value.item() if isinstance(value, np.generic) else value
    is_missing = value is None or type(value).__name__ in ("NAType", "NaTType") or value != value
    return None if isinstance(is_missing, bool) and is_missing else value


def _shapes(geometry: Any) -> list[Geometry | None]:
    """Geometries from WKB; None where there is none, or none that can be read."""
    return [None if code is None else shapely.from_wkb(code, on_invalid="ignore") for code in geometry]


def _ids(properties: Sequence[Mapping[str, Any]]) -> list[str]:
    """The identifier of each feature; "" of one without."""
    named = (next((table[key] for key in IDS if table.get(key) is not None), "") for table in properties)
    return [str(value) if isinstance(value, str | int) else "" for value in named]


def _from_geojson(text: str, metres: bool, faults: list[str]) -> Features:
    """The features of a collection (RFC 7946)."""
    nothing = Features([], [], [], [])
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        faults.append(f"is not JSON ({error}); export the footprints again as GeoJSON")
        return nothing
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list) or document.get("type") != "FeatureCollection":
        faults.append('is no GeoJSON of footprints; write {"type": "FeatureCollection", "features": [...]}')
        return nothing
    system = str(document.get("crs", "CRS84")).lower()
    if not metres and not any(name in system for name in WORLD):
        faults.append(
            f"crs: {shown(document['crs'])} is not longitude and latitude, which GeoJSON has (RFC 7946); export the "
            f"file in WGS 84, or {METRES_HINT}"
        )
        return nothing
    tables = [feature if isinstance(feature, dict) else {} for feature in features]
    properties = [dict(own) if isinstance(own := table.get("properties"), dict) else {} for table in tables]
    shapes = []
    for number, table in enumerate(tables, start=1):
        try:
            shapes.append(_shape(table.get("geometry"), metres))
        except ValueError as error:
            faults.append(f"feature {number}: {error}")
            shapes.append(None)
    own_ids = [value if isinstance(value := table.get("id"), str | int) else None for table in tables]
    ids = [other if own is None else str(own) for own, other in zip(own_ids, _ids(properties), strict=True)]
    places = [f"feature {number}" for number in range(1, len(tables) + 1)]
    return Features(places, properties, shapes, ids, None if metres else DEGREES)


def _shape(geometry: Any, metres: bool) -> Geometry:
    """The geometry of a feature of a GeoJSON; raises ValueError with what is wrong with it."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    parts = geometry.get("coordinates") if isinstance(geometry, dict) else None
    if kind not in POLYGONS or not isinstance(parts, list) or not parts:
        raise ValueError(_no_polygon("" if kind is None else shown(kind)))
    polygons = []
    for polygon in [parts] if kind == "Polygon" else parts:
        outer, *holes = [_ring(ring, metres) for ring in (polygon if isinstance(polygon, list) and polygon else [None])]
        polygons.append(shapely.Polygon(outer, holes))
    return polygons[0] if kind == "Polygon" else shapely.MultiPolygon(polygons)


def _no_polygon(kind: str) -> str:
    return f"has {kind or 'no geometry'}; a building needs its footprint, a Polygon or a MultiPolygon"


def _ring(ring: Any, metres: bool) -> Array:
    """The positions of a ring, the first of them repeated at its end; raises ValueError."""
    if not isinstance(ring, list) or len(ring) < 4:
        raise ValueError("a ring has fewer than four positions, the first of them repeated at its end; draw it again")
    for position in ring:
        if not (isinstance(position, list) and len(position) >= 2 and all(map(_is_number, position[:2]))):
            raise ValueError(f"{shown(position)} is not a position; write two numbers, such as [174.776, -41.286]")
    corners = np.array([position[:2] for position in ring], dtype=np.float64)
    if not metres and (np.abs(corners) > (180.0, 90.0)).any():
        raise ValueError(_no_degrees(corners[(np.abs(corners) > (180.0, 90.0)).any(axis=1)][0]))
    if not np.array_equal(corners[0], corners[-1]):
        raise ValueError("a ring does not end where it starts; repeat its first position at its end")
    return corners


def _no_degrees(corner: Array) -> str:
    return (
        f"[{corner[0]:g}, {corner[1]:g}] is no longitude and latitude in degrees; export the file in WGS 84, or "
        f"{METRES_HINT}"
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= FARTHEST


# ------------------------------------------------------------------------------------------------ geometry


def _projection(features: Features, metres: bool, faults: list[str]) -> Projection | None:
    """How coordinates of the file become metres; None where they are metres that nothing ties to the Earth."""
    system = None
    try:
        system = None if features.system is None else system_of(features.system)
    except ValueError as error:
        faults.append(f"{error}; export the footprints again in another one, or {METRES_HINT}")
        return None
    if metres:
        if system is not None and system.is_geographic:
            faults.append(
                f"its coordinates are degrees ({system.name}), so they are no metres; leave out --metres (metres=True "
                "in Python)"
            )
        return None
    if system is None:
        faults.append(
            "has no coordinate reference system, so nobody knows what its numbers are; set it (QGIS: Layer > Set CRS) "
            f"and export the file again, or {METRES_HINT}"
        )
        return None
    shapes = [shape for shape in features.geometries if shape is not None]
    corners = shapely.get_coordinates(shapes)
    if system.is_geographic:
        outside = (np.abs(corners) > (180.0, 90.0)).any(axis=1)
        for number, shape in enumerate(features.geometries) if outside.any() else ():
            own = shapely.get_coordinates(shape)
            far = own[(np.abs(own) > (180.0, 90.0)).any(axis=1)]
            if len(far):
                faults.append(f"{features.places[number]}: {_no_degrees(far[0])}")
    finite = corners[np.isfinite(corners).all(axis=1)]
    return Projection.about(finite, system) if len(finite) and not faults else None


def _within(features: Features, within: str, projection: Projection | None, faults: list[str]) -> Features:
    """The features whose middle lies in a box of degrees, or in polygons of a file."""
    area = _area(within)
    bounds = np.array([shapely.bounds(shape) for shape in features.geometries], dtype=float).reshape(-1, 4)
    middles = 0.5 * (bounds[:, :2] + bounds[:, 2:])
    if projection is not None:
        middles = projection.degrees(middles)
    elif features.geometries:
        faults.append(
            "--within is in degrees, and nothing ties the coordinates of this file to the Earth; leave it out"
        )
    return features.chosen(np.flatnonzero(shapely.contains_xy(area, *middles.T)).tolist())


def _area(within: str) -> Geometry:
    """What --within gives, in degrees of WGS 84."""
    numbers = within.split(",")
    if len(numbers) == 4:
        try:
            west, south, east, north = map(float, numbers)
        except ValueError:
            west, south, east, north = 0.0, 0.0, 0.0, 0.0
        if -180.0 <= west < east <= 180.0 and -90.0 <= south < north <= 90.0:
            return shapely.box(west, south, east, north)
    path = Path(within)
    if path.suffix.lower() not in MAPS:
        raise BlockError(
            "--within",
            [f'{shown(within)} is no box "west, south, east, north" in degrees, and no file of polygons; write one'],
        )
    table = read_map_outlines(path)
    area = shapely.union_all(table)
    shapely.prepare(area)
    return area


def read_map_outlines(path: Path) -> list[Geometry]:
    """The polygons of a file in degrees of WGS 84, without regard to their properties; raises BlockError."""
    faults: list[str] = []
    features = _features(path, None, False, faults)
    projection = None if faults else _projection(features, False, faults)
    shapes: list[Geometry] = []
    for place, shape in zip(features.places, features.geometries, strict=True):
        sound, _, fault = _sound(shape)
        if fault:
            faults.append(f"{place}: {fault}")
        elif sound is not None and projection is not None:
            shapes.append(shapely.transform(sound, projection.degrees))
    if not faults and not shapes:
        faults.append("has no polygon; draw one")
    if faults:
        raise BlockError(str(path), list(dict.fromkeys(faults)))
    return shapes


def _sound(shape: Geometry | None) -> tuple[Geometry | None, str, str]:
    """A footprint that has an inside; what was repaired; or what is wrong with it."""
    if shape is None or shape.is_empty:
        return None, "", _no_polygon("")
    if shape.geom_type not in POLYGONS:
        return None, "", _no_polygon(shown(shape.geom_type))
    told = ["its Z coordinates are left out"] if shape.has_z else []
    flat = shapely.force_2d(shape)
    corners = shapely.get_coordinates(flat)
    if not (np.isfinite(corners).all() and (np.abs(corners) <= FARTHEST).all()):
        return None, "", "a coordinate is no number, or is beyond any place on the Earth; draw the footprint again"
    if shapely.is_valid(flat):
        return flat, "; ".join(told), ""
    parts = []
    for part in shapely.get_parts(flat):
        whole, fault = _repaired(part)
        if fault:
            return None, "", fault
        parts.append(whole)
    repaired = parts[0] if len(parts) == 1 else shapely.union_all(parts)
    told.append(f"its outline is repaired ({shapely.is_valid_reason(flat)})")
    return repaired, "; ".join(told), ""


def _repaired(polygon: Geometry) -> tuple[Geometry | None, str]:
    """A valid polygon, or several, of the same area; or what is wrong with it."""
    if shapely.is_valid(polygon):
        return polygon, ""
    whole = shapely.make_valid(polygon)
    polygons = [part for part in shapely.get_parts(whole) if part.geom_type in POLYGONS]
    repaired = shapely.union_all(polygons)
    if repaired.area == 0.0:
        return None, "a ring has no area; draw the footprint again"
    if abs(repaired.area - polygon.area) > REPAIRABLE * polygon.area:
        reason = shapely.is_valid_reason(polygon)
        if reason.startswith("Self-intersection"):
            return None, "a ring crosses itself; draw the footprint again, its corners in turn"
        return None, f"its outline has no plain inside ({reason}); draw the footprint again"
    return repaired, ""


# ------------------------------------------------------------------------------------------------ properties


class Dialect(NamedTuple):
    """Whose properties a file has: names of columns there, and how those of a feature are read."""

    name: str = ""
    columns: Mapping[str, str] = {}
    read: Callable[[Mapping[str, Any]], dict[str, Any]] = dict
    note: str = ""


def _of_osm(tags: Mapping[str, Any]) -> dict[str, Any]:
    """The tags of a building, its height with its unit: a plain number is in metres, 12'6" in feet and inches."""
    values = {key: value for key, value in tags.items() if key not in ("building", "building:part", "min_height")}
    text = str(tags.get("height", "")).strip()
    if feet := OSM_FEET.fullmatch(text):
        values["height"] = f"{float(feet[1]) + float(feet[2] or 0.0) / 12.0!r} ft"
    else:
        values["height"] = _in_metres(tags.get("height"))
    levels = str(tags.get("building:levels", "")).strip()
    if re.fullmatch(r"[0-9]+\.5", levels):  # an attic
        values["building:levels"] = ceil(float(levels))
    return values


def _of_overture(table: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a building of Overture: its heights are in metres, its name is the primary one."""
    names = table.get("names")
    if isinstance(names, str) and names.startswith("{"):
        try:
            names = json.loads(names)
        except ValueError:
            names = None
    primary = (
        names.get("primary") if isinstance(names, Mapping) else table.get("names.primary", table.get("names_primary"))
    )
    values = {
        key: value
        for key, value in table.items()
        if key not in ("names", "names.primary", "names_primary", "min_height")
    }
    return values | {"name": table.get("name") or primary, "height": _in_metres(table.get("height"))}


def _in_metres(height: Any) -> Any:
    is_plain = re.fullmatch(r"[0-9]+(\.[0-9]+)?", str(height).strip()) and not isinstance(height, bool)
    return f"{str(height).strip()} m" if is_plain else height


OSM = Dialect(
    "OpenStreetMap",
    OSM_COLUMNS,
    _of_osm,
    "tags of OpenStreetMap: a height without a unit is in metres, building:levels are the storeys, and building is a "
    "use, from which no typology follows; give typology where it is known",
)
OVERTURE = Dialect(
    "Overture",
    OVERTURE_COLUMNS,
    _of_overture,
    "properties of Overture: height is in metres, num_floors are the storeys, and no typology follows from the others",
)


def _dialect(tables: Sequence[Mapping[str, Any]]) -> Dialect:
    """Whose properties these are, by their names."""
    keys = {str(key) for table in tables for key in table}
    if "building" in keys or any(key.startswith("building:") for key in keys):
        return OSM
    return OVERTURE if keys.intersection(OVERTURE_KEYS) else Dialect()


def _table(features: Features, projection: Projection | None, faults: list[str]) -> Table:
    """The buildings of a file whose coordinates can be read, with notes on what is not read, or repaired."""
    tables = [_with_other_tags(table) for table in features.properties]
    dialect = _dialect(tables)
    raw = tables
    if dialect.name:
        tables = [dialect.read(table) for table in tables]
    heads = [key for key in dict.fromkeys(key for table in tables for key in table) if key not in IDS]
    columns, left_out = columns_of(heads, "properties", faults, dialect.columns, is_foreign=bool(dialect.name))
    columns = {head: column for head, column in columns.items() if not _lacks_unit(head, *column, tables, faults)}
    entries = []
    for number, place in enumerate(features.places):
        _check_twins(place, tables[number], columns, faults)
        values = values_of(place, tables[number].items(), columns, faults)
        entries.append(Entry(place, values, features.geometries[number], Mapped(features.ids[number])))
    entries, resolution, told = _laid_flat(entries, projection, dialect, faults)
    if faults:
        return Table([], [])
    notes = [*left_out, *_notes_of(dialect, raw, features.places), *told]
    if dialect.name:
        entries, parts_told = _without_parts(entries, dict(zip(features.places, raw, strict=True)))
        entries = _named_apart(entries)
        notes += parts_told
    return Table(entries, notes, resolution)


def outlined_table(source: Path, entries: Sequence[Entry], notes: Sequence[str]) -> Table:
    """Buildings whose footprints are in degrees of WGS 84 as a table, checked, repaired and laid flat.

    Raises BlockError with every fault of the footprints.
    """
    faults: list[str] = []
    features = Features([entry.place for entry in entries], [], [entry.footprint for entry in entries], [], DEGREES)
    projection = _projection(features, False, faults)
    flat, resolution, told = (
        _laid_flat(entries, projection, Dialect(), faults) if not faults else ([], Resolution(), [])
    )
    if faults:
        raise BlockError(str(source), faults)
    return Table(flat, [*notes, *told], resolution)


def _laid_flat(
    entries: Sequence[Entry], projection: Projection | None, dialect: Dialect, faults: list[str]
) -> tuple[list[Entry], Resolution, list[str]]:
    """Entries with sound footprints in metres, how finely their walls are known, and notes on both."""
    repairs: dict[str, list[str]] = {}
    sound = []
    for entry in entries:
        shape, told, fault = _sound(entry.footprint)
        if fault:
            faults.append(f"{entry.place}: {fault}")
        else:
            repairs.setdefault(told, []).append(entry.place)
            sound.append(entry._replace(footprint=shape))
    notes = [f"{_several(places)}: {told}" for told, places in repairs.items() if told]
    if faults or not sound:
        return [], Resolution(), []
    resolution, coarse = _resolution([entry.footprint for entry in sound], projection, dialect)
    flat = _flat(sound, projection)
    faults += _other_coordinates([entry.footprint for entry in flat], projection) or _far_apart(flat)
    return flat, resolution, [*notes, *coarse]


def _lacks_unit(head: str, column: str, unit: str, tables: Sequence[Mapping[str, Any]], faults: list[str]) -> bool:
    """True, with one fault for all features, where a property has numbers alone, and its name has no unit."""
    quantity = COLUMNS[column]
    numbers = [table[head] for table in tables if table.get(head) is not None]
    if quantity is None or quantity.unit == "1" or unit or not numbers:
        return False
    if not all(isinstance(number, int | float) and not isinstance(number, bool) for number in numbers):
        return False
    faults.append(
        f'properties: {shown(head)} has numbers without a unit; name it "{head} [{quantity.unit}]", by the unit that '
        f"it has, or write the unit in its cells ({shown(quantity.example)})"
    )
    return True


def _several(places: Sequence[str]) -> str:
    more = f" and {len(places) - LISTED} more" if len(places) > LISTED else ""
    return f"{', '.join(places[:LISTED])}{more}"


def _with_other_tags(table: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a feature; of tags that GDAL writes into one column each by itself."""
    own = dict(table)
    tags = own.pop("other_tags", None)
    return dict(OTHER_TAGS.findall(tags)) | own if isinstance(tags, str) else own


def _notes_of(dialect: Dialect, tables: Sequence[Mapping[str, Any]], places: Sequence[str]) -> Iterator[str]:
    """Notes on how properties of a map are read, and on features that may be no building, or begin above the ground."""
    if not dialect.name:
        return
    yield dialect.note
    hollow: dict[str, list[str]] = {}
    raised = []
    for place, table in zip(places, tables, strict=True):
        kind = str(table.get("building", "")).strip().lower()
        if kind in OSM_HOLLOW:
            hollow.setdefault(kind, []).append(place)
        if re.fullmatch(r"[0-9]+(\.[0-9]+)?( m)?", low := str(table.get("min_height", "")).strip()):
            raised += [place] if float(low.removesuffix(" m")) > 0.0 and not _is_part(table) else []
    for kind, own in hollow.items():
        one = len(own) == 1
        yield (
            f'{_several(own)}: {"its" if one else "their"} tag building is "{kind}"; leave {"it" if one else "them"} '
            f"out where nothing with floors stands there"
        )
    if raised:
        yield f"{_several(raised)}: min_height is above 0, as of a bridge; taken from the ground up"


def _is_part(table: Mapping[str, Any]) -> bool:
    """True of a part of a building: of OpenStreetMap by its tag, of Overture by the building that it names."""
    part = str(table.get("building:part") or "no").strip().lower()
    building = str(table.get("building") or "no").strip().lower()
    return bool(table.get("building_id")) or (part != "no" and building == "no")


def _without_parts(entries: list[Entry], tables: Mapping[str, Mapping[str, Any]]) -> tuple[list[Entry], list[str]]:
    """The buildings without the parts that lie in them; a building without a height is as tall as its tallest part."""
    is_part = np.array([_is_part(tables[entry.place]) for entry in entries], bool)
    if not is_part.any() or is_part.all():
        return entries, []
    whole = [entry for entry, part in zip(entries, is_part, strict=True) if not part]
    parts = [entry for entry, part in zip(entries, is_part, strict=True) if part]
    inner = shapely.point_on_surface(np.array([entry.footprint for entry in parts], dtype=object))
    of, inside = shapely.STRtree([entry.footprint for entry in whole]).query(inner, predicate="within")
    held = dict(zip(of.tolist(), inside.tolist(), strict=True))
    tallest: dict[int, dict[str, Any]] = {}
    for number, building in held.items():
        own, most = parts[number].values, tallest.setdefault(building, {})
        most |= {key: max(most.get(key, 0), own[key]) for key in ("height", "storeys") if key in own}
    whole = [entry._replace(values={**tallest.get(number, {}), **entry.values}) for number, entry in enumerate(whole)]
    alone = [part for number, part in enumerate(parts) if number not in held]
    notes = []
    if held:
        notes.append(
            f"{_several([parts[number].place for number in held])}: parts of buildings, which stand in the outlines of "
            "those; a building without a height, or storeys, has those of its tallest part"
        )
    if alone:
        notes.append(f"{_several([part.place for part in alone])}: parts that stand in no building; read as buildings")
    return [*whole, *alone], notes


def _named_apart(entries: list[Entry]) -> list[Entry]:
    """Buildings of one street that share a name, as shops do, by their name and their place in the file."""
    keys = [(entry.values.get("street", ""), entry.values.get("name")) for entry in entries]
    shared = set(repeated(keys))
    return [
        entry._replace(values={**entry.values, "name": f"{key[1]} ({entry.place})"})
        if key in shared and key[1] is not None
        else entry
        for key, entry in zip(keys, entries, strict=True)
    ]


def _check_twins(
    where: str, table: Mapping[str, Any], columns: Mapping[str, tuple[str, str]], faults: list[str]
) -> None:
    """Note a fault for positions of walls beside a footprint, which has them."""
    for head in table:
        column = columns.get(head, ("", ""))[0]
        if column in ("left wall", "right wall") and table[head] is not None:
            faults.append(f"{where}, {column}: the footprint says where the walls are; leave the property out")


# ------------------------------------------------------------------------------------------------ metres


def _flat(entries: list[Entry], projection: Projection | None) -> list[Entry]:
    """The entries with footprints in metres about their middle, and where that is on the Earth."""
    if projection is None:
        return entries
    shapes = np.array([entry.footprint for entry in entries], dtype=object)
    flat = shapely.transform(shapes, projection.metres)
    middles = projection.degrees(shapely.get_coordinates(shapely.centroid(shapes)))
    world = shapely.transform(shapes, projection.degrees)
    return [
        entry._replace(
            footprint=shape, mapped=(entry.mapped or Mapped())._replace(longitude=x, latitude=y, outline=outline)
        )
        for entry, shape, (x, y), outline in zip(entries, flat, middles.tolist(), world, strict=True)
    ]


def _far_apart(entries: Sequence[Entry]) -> list[str]:
    """A fault where footprints lie so far apart that no plane holds them."""
    bounds = shapely.bounds(np.array([entry.footprint for entry in entries], dtype=object)).reshape(-1, 4)
    if not len(bounds):
        return []
    wide = hypot(*(bounds[:, 2:].max(axis=0) - bounds[:, :2].min(axis=0)))
    if wide <= FARTHEST_APART:
        return []
    apart = f"{say(wide, GAP, 3)} apart" if isfinite(wide) else "too far apart to be laid flat"
    return [
        f"{entries[0].place} to {entries[-1].place}: their footprints lie {apart}, and one plane holds at most "
        f"{say(FARTHEST_APART, GAP)}; give a part of them (--within), or check the coordinates"
    ]


def _other_coordinates(footprints: Sequence[Geometry], projection: Projection | None) -> list[str]:
    """A fault where metres are read as degrees, or degrees as metres: no building is that large, or that small."""
    bounds = shapely.bounds(np.array(footprints, dtype=object)).reshape(-1, 4)
    if not len(bounds):
        return []
    across = np.hypot(bounds[:, 2] - bounds[:, 0], bounds[:, 3] - bounds[:, 1])
    if across.max() < SMALLEST:
        kind, repair = "as metres", "leave out --metres (metres=True in Python)"
        if projection is not None:
            kind, repair = f"as {projection.system.name}", "set the coordinate reference system that the file has"
        words = say(float(across.max()), GAP, 2)
        return [
            f"read {kind}, no footprint is more than {words} across: the coordinates look like longitude and latitude; "
            f"{repair}"
        ]
    if projection is None or not LARGEST < across.min() < inf:
        return []
    kind, repair = projection.system.name, "set the coordinate reference system that the file really has"
    if projection.system.is_geographic:
        kind = "longitude and latitude"
        repair = "the coordinates look like metres; say so with --metres (metres=True in Python)"
    return [f"read as {kind}, every footprint is {say(float(across.min()), GAP, 2)} across or more: {repair}"]


def _resolution(
    outlines: Sequence[Geometry], projection: Projection | None, dialect: Dialect
) -> tuple[Resolution, list[str]]:
    """How finely walls are known by the file itself, and a note where its last decimal is larger than gaps are."""
    unit = 1.0 if projection is None else projection.unit
    decimals, size = last_decimal(shapely.get_coordinates(outlines), unit, COARSE, MOST_DECIMALS)
    notes = []
    if not isnan(size):
        notes = [
            f"coordinates have {decimals} decimals, {say(size, GAP, 2)} on the ground, and gaps between footprints are "
            "no finer; give gap [mm] where it was measured"
        ]
    if dialect.name and not size > MAPPED_FROM_IMAGES:
        return Resolution(MAPPED_FROM_IMAGES, f"assumed of outlines of {dialect.name}, which say nothing of it"), notes
    return Resolution(size, "" if isnan(size) else "the last decimal of the coordinates"), notes
