"""Features of a map as they are in its file: GeoJSON, GeoPackage, FlatGeobuf and GeoParquet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from pounding_risk._common.letters import plain
from pounding_risk._common.words import nearest
from pounding_risk.streets.footprints import Geometry
from pounding_risk.streets.geojson import collection_of, polygons_of, properties_of
from pounding_risk.streets.projection import DEGREES
from pounding_risk.streets.table import BlockError, file_text
from pounding_risk.units import shown

GEOJSON = (".geojson", ".json")
LAYERED = {".gpkg": "GeoPackage", ".fgb": "FlatGeobuf"}
PARQUET = (".parquet", ".geoparquet")
METRES_HINT = (
    "where its coordinates are metres say so with --metres (metres=True in Python) of block, whose buildings.csv draw "
    "and export take"
)
IDS = ("id", "@id", "osm_id", "osm_way_id", "full_id")


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
        own = _layer(path, layer, layers)
        meta, fids, geometry, columns = pyogrio.raw.read(path, layer=own, return_fids=True, force_2d=False)
    names = [str(name) for name in meta["fields"]]
    rows = zip(*(column.tolist() for column in columns), strict=True) if names else ((),) * len(fids)
    properties = [dict(zip(names, map(_known, row), strict=True)) for row in rows]
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
    rows = frame.drop(columns=frame.active_geometry_name).to_dict("records")
    properties = [{str(key): _known(cell) for key, cell in row.items()} for row in rows]
    places = [f"feature {number}" for number in range(1, len(frame) + 1)]
    return Features(places, properties, list(frame.geometry.array), _ids(properties), frame.crs)


def _known(cell: Any) -> Any:
    """A value of a table as Python has it; None where the table has none."""
    cell = cell.item() if isinstance(cell, np.generic) else cell
    is_missing = cell is None or type(cell).__name__ in ("NAType", "NaTType") or cell != cell
    return None if isinstance(is_missing, bool) and is_missing else cell


def _ids(properties: Sequence[Mapping[str, Any]]) -> list[str]:
    """The identifier of each feature; "" of one without."""
    named = (next((table[key] for key in IDS if table.get(key) is not None), "") for table in properties)
    return [str(identifier) if isinstance(identifier, str | int) else "" for identifier in named]


def _from_geojson(text: str, metres: bool, faults: list[str]) -> Features:
    """The features of a collection, in the system that it names, as GDAL and QGIS do, or in WGS 84 (RFC 7946)."""
    collection = collection_of(text, "footprints", faults)
    system = collection.get("crs", None if metres else DEGREES)
    if isinstance(system, dict):
        named = properties_of(system)
        system = named.get("name", named.get("code", ""))
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
    """The geometry of a feature of a GeoJSON; raises ValueError with what is wrong with it."""
    polygons = []
    for rings in polygons_of(geometry):
        outer, *holes = [np.array([position[:2] for position in ring], dtype=np.float64) for ring in rings]
        polygons.append(shapely.Polygon(outer, holes))
    return polygons[0] if geometry["type"] == "Polygon" else shapely.MultiPolygon(polygons)
