"""Features of a map as they are in its file, GeoJSON, GeoPackage, FlatGeobuf or GeoParquet, and its coordinates.

Those of any reference system become metres of a plane about the middle of a file, and degrees of WGS 84.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from pounding_risk._common.letters import plain
from pounding_risk._common.words import nearest
from pounding_risk.streets.footprints import Array, Geometry
from pounding_risk.streets.geojson import collection_of, polygons_of, properties_of
from pounding_risk.streets.table import DEGREE, BlockError, file_text
from pounding_risk.units import shown

DEGREES = "OGC:CRS84"  # longitude and latitude on WGS 84, in this order


class Projection(NamedTuple):
    """From a coordinate reference system to metres east and north of a place, and to longitude and latitude.

    The plane is a transverse Mercator projection on the system's own ellipsoid, with the scale 1 at the place: angles
    hold, and so do lengths to 1 + x² / (2 R²), some 3e-7 at 5 km from it.
    """

    system: Any
    to_metres: Any
    to_degrees: Any

    @classmethod
    def about(cls, corners: Array, system: Any) -> Projection:
        """The projection about the mean corner (n, 2) of coordinates in a system."""
        to_degrees = Transformer.from_crs(system, DEGREES, always_xy=True)
        degrees = np.column_stack(to_degrees.transform(*corners.T))
        degrees = degrees[np.isfinite(degrees).all(axis=1)]
        if not len(degrees):
            degrees = np.zeros((1, 2))
        latitude, first = float(degrees[:, 1].mean()), float(degrees[0, 0])
        # Across the meridian of 180 degrees longitudes go on.
        longitude = float(np.mean((degrees[:, 0] - first + 180.0) % 360.0 - 180.0)) + first
        ellipsoid = system.ellipsoid
        shape = f"+a={ellipsoid.semi_major_metre!r} +b={ellipsoid.semi_minor_metre!r}"
        local = f"+proj=tmerc +lat_0={latitude!r} +lon_0={longitude!r} +k=1 {shape} +units=m +type=crs"
        # A plane on an ellipsoid alone: PROJ shifts no datum on the way.
        return cls(system, Transformer.from_crs(system, CRS(local), always_xy=True), to_degrees)

    def metres(self, corners: Array) -> Array:
        """Coordinates (n, 2) as metres east and north of the middle."""
        return np.column_stack(self.to_metres.transform(*corners.T))

    def degrees(self, corners: Array) -> Array:
        """Coordinates (n, 2) as longitude and latitude."""
        return np.column_stack(self.to_degrees.transform(*corners.T))

    @property
    def unit(self) -> float:
        """One of the system's units on the ground, m."""
        factor = float(self.system.axis_info[0].unit_conversion_factor)
        return factor * 180.0 / pi * DEGREE if self.system.is_geographic else factor


def system_of(crs: Any) -> Any:
    """The horizontal coordinate reference system that a file states, None where it states none; raises ValueError."""
    try:
        system: Any = CRS.from_user_input(crs)
    except CRSError as error:
        reason = " ".join(str(error).split())[:200]
        raise ValueError(f"its coordinate reference system cannot be read ({reason})") from None
    if system.is_compound:
        system = system.sub_crs_list[0]
    if system.is_bound:
        system = system.source_crs
    if system is None or system.name.lower().startswith(("undefined", "unknown", "undetermined")):
        return None
    if not (system.is_geographic or system.is_projected):
        raise ValueError(f"its coordinate reference system, {system.name}, is tied to no place on the Earth")
    return system.to_2d()


# ------------------------------------------------------------------------------------------------ files
GEOJSON = (".geojson", ".json")
LAYERED = {".gpkg": "GeoPackage", ".fgb": "FlatGeobuf"}
PARQUET = (".parquet", ".geoparquet")
METRES_HINT = (
    "where its coordinates are metres say so with --metres (metres=True in Python) of block, whose buildings.csv draw "
    "and export take"
)
IDS = ("id", "@id", "osm_id", "osm_way_id", "full_id")


class Features(NamedTuple):
    """The features of a file of a map: the place in the file, properties, geometry and id of each."""

    places: list[str]
    properties: list[dict[str, Any]]
    geometries: list[Geometry | None]
    ids: list[str]
    system: Any = None  # the coordinate reference system, as pyproj reads it; None where the file has none

    def chosen(self, wanted: Sequence[int]) -> Features:
        """Some of the features, by their numbers from 0."""
        rows = [(self.places[at], self.properties[at], self.geometries[at], self.ids[at]) for at in wanted]
        places, properties, geometries, ids = map(list, zip(*rows, strict=True)) if rows else ([], [], [], [])
        return Features(places, properties, geometries, ids, self.system)


def read_features(path: Path, layer: str | None, metres: bool, faults: list[str]) -> Features:
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
        reason = plain(" ".join(str(error).split())[:200]) or type(error).__name__
        sentence = f"cannot be read as {kind} ({reason}); export the footprints again"
        raise BlockError(str(path), [sentence]) from None


def _from_layer(path: Path, layer: str | None) -> Features:
    """A layer of a GeoPackage or of a FlatGeobuf."""
    import warnings

    import pyogrio

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of values that no column here has, such as dates, and of measured corners
        layers = {str(name): kind for name, kind in pyogrio.list_layers(path)}
        layer_name = _layer(path, layer, layers)
        meta, fids, geometry, columns = pyogrio.raw.read(path, layer=layer_name, return_fids=True, force_2d=False)
    names = [str(name) for name in meta["fields"]]
    rows = zip(*(column.tolist() for column in columns), strict=True) if names else ((),) * len(fids)
    properties = [dict(zip(names, map(_plain_cell, row), strict=True)) for row in rows]
    numbers = fids.tolist() if path.suffix.lower() == ".gpkg" else range(1, len(fids) + 1)  # as QGIS shows them
    # None where there is no geometry, or none that can be read.
    shapes = [None] * len(fids) if geometry is None else list(shapely.from_wkb(geometry, on_invalid="ignore"))
    return Features([f"feature {number}" for number in numbers], properties, shapes, _ids(properties), meta["crs"])


def _layer(path: Path, layer: str | None, layers: Mapping[str, Any]) -> str:
    """The layer that is chosen, or the only one of polygons; raises BlockError."""
    if layer is not None:
        if layer not in layers:
            sentence = f"has no layer {shown(layer)}{nearest(layer, layers)}; it has {', '.join(layers) or 'none'}"
            raise BlockError(str(path), [sentence])
        return layer
    polygon_layers = [name for name, kind in layers.items() if kind is not None and "Point" not in str(kind)]
    candidates = [name for name in polygon_layers if "Polygon" in str(layers[name])] or polygon_layers
    if len(candidates) != 1:
        if not candidates:
            raise BlockError(str(path), ["has no layer of polygons; export the footprints again"])
        names = ", ".join(candidates)
        raise BlockError(str(path), [f"has the layers {names}; say which one with --layer (layer= in Python)"])
    return candidates[0]


def _from_parquet(path: Path) -> Features:
    """A GeoParquet file, such as one of Overture."""
    import geopandas

    frame = geopandas.read_parquet(path)
    rows = frame.drop(columns=frame.active_geometry_name).to_dict("records")
    properties = [{str(key): _plain_cell(cell) for key, cell in row.items()} for row in rows]
    places = [f"feature {number}" for number in range(1, len(frame) + 1)]
    return Features(places, properties, list(frame.geometry.array), _ids(properties), frame.crs)


def _plain_cell(cell: Any) -> Any:
    """A value of a table as Python has it; None where the table has none."""
    cell = cell.item() if isinstance(cell, np.generic) else cell
    is_missing = cell is None or type(cell).__name__ in ("NAType", "NaTType") or cell != cell
    return None if isinstance(is_missing, bool) and is_missing else cell


def _ids(properties: Sequence[Mapping[str, Any]]) -> list[str]:
    """The identifier of each feature; "" of one without."""
    identifiers = (next((table[key] for key in IDS if table.get(key) is not None), "") for table in properties)
    return [str(identifier) if isinstance(identifier, str | int) else "" for identifier in identifiers]


def _from_geojson(text: str, metres: bool, faults: list[str]) -> Features:
    """The features of a collection, in the system that it names, as GDAL and QGIS do, or in WGS 84 (RFC 7946)."""
    collection = collection_of(text, "footprints", faults)
    system = collection.get("crs", None if metres else DEGREES)
    if isinstance(system, dict):
        crs_properties = properties_of(system)
        system = crs_properties.get("name", crs_properties.get("code", ""))
    tables = collection["features"]
    places = [f"feature {number}" for number in range(1, len(tables) + 1)]
    properties = [dict(properties_of(table)) for table in tables]
    shapes = []
    for place, table in zip(places, tables, strict=True):
        try:
            shapes.append(_shape(table.get("geometry")))
        except ValueError as error:
            faults.append(f"{place}: {error}")
            shapes.append(None)
    own_ids = [identifier if isinstance(identifier := table.get("id"), str | int) else None for table in tables]
    ids = [other if own is None else str(own) for own, other in zip(own_ids, _ids(properties), strict=True)]
    return Features(places, properties, shapes, ids, system)


def _shape(geometry: Any) -> Geometry:
    """The geometry of a feature of a GeoJSON; raises ValueError with its fault."""
    polygons = []
    for rings in polygons_of(geometry):
        outer, *holes = [np.array([position[:2] for position in ring], dtype=np.float64) for ring in rings]
        polygons.append(shapely.Polygon(outer, holes))
    return polygons[0] if geometry["type"] == "Polygon" else shapely.MultiPolygon(polygons)
