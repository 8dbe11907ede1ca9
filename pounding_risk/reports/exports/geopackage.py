"""Buildings and interfaces as layers of a GeoPackage, which QGIS opens with their styles.

Beside the layers, which GDAL writes, the file has the table ``layer_styles`` as QGIS makes it, in which it looks for
the style of a layer, and the units and words of the columns (``gpkg_data_columns``, the standard's extension for
schemas).
"""

from __future__ import annotations

import shutil
import sqlite3
import warnings
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

import xarray as xr

from pounding_risk._common.dates import now
from pounding_risk._common.files import check_target, move_into_place, not_written, partial_of
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports import Options, Written
from pounding_risk.reports.exports._layers import Layer, layers_of
from pounding_risk.reports.exports._styles import style

WORDS = "layers of buildings and interfaces, for QGIS"
ENDINGS = (".gpkg",)
SOURCE = "results"
SEVERAL = True
TAKES = ("gap", "pga", "intensity_level", "street")
NEEDED = ("geopandas", "pyogrio", "shapely", "pyproj")  # and pyarrow for GeoParquet
NO_SYSTEM = "-1"  # srs_id of coordinates that are tied to no place on the Earth
LABELS = {
    "buildings": "\"building\" || coalesce('\\n' || round(100 * \"p_contact\") || ' %', '')",
    "interfaces": "round(1000 * \"gap_m\", 1) || ' mm'",
}
KINDS = {"Point": "marker", "LineString": "line", "MultiLineString": "line"}
# As QGIS has them made by GDAL (QgsOgrProviderMetadata::saveStyle).
STYLES = """CREATE TABLE "layer_styles" ("id" INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "f_table_catalog" TEXT(256),
"f_table_schema" TEXT(256), "f_table_name" TEXT(256), "f_geometry_column" TEXT(256), "styleName" TEXT(30),
"styleQML" TEXT, "styleSLD" TEXT, "useAsDefault" BOOLEAN, "description" TEXT, "owner" TEXT(30), "ui" TEXT(30),
"update_time" DATETIME DEFAULT CURRENT_TIMESTAMP)"""
# As the standard has it (OGC 12-128r18, annex F.9).
COLUMNS = """CREATE TABLE gpkg_data_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, name TEXT, title TEXT,
description TEXT, mime_type TEXT, constraint_name TEXT, CONSTRAINT pk_gdc PRIMARY KEY (table_name, column_name),
CONSTRAINT gdc_tn UNIQUE (table_name, name))"""
SCHEMA = ("gpkg_data_columns", None, "gpkg_schema", "http://www.geopackage.org/spec121/#extension_schema", "read-write")


def write(results: list[xr.Dataset], target: Path, options: Options) -> Written:
    """Write the layers of rows into one file, whole or not at all; raises PoundingError as `layers_of`."""
    need(NEEDED, "a GeoPackage")
    file = check_target(target, ENDINGS)
    layers = layers_of(results, options)
    aside = partial_of(file)  # a folder, since GDAL writes more files beside, and wants the ending of the name
    try:
        aside.mkdir()
        _write(aside / file.name, (layers.buildings, layers.interfaces), layers.crs, layers.notes)
        move_into_place(aside / file.name, file)
    except (OSError, RuntimeError, sqlite3.Error) as error:  # those of GDAL are RuntimeErrors
        raise not_written(file, error) from None
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return Written((file,), layers.notes)


def need(names: Iterable[str], what: str) -> None:
    """Raise PoundingError where a library of the extra [maps] is not installed."""
    from importlib.util import find_spec

    absent = [name for name in names if find_spec(name) is None]
    if absent:
        raise PoundingError(f"{what} needs {', '.join(absent)}, not installed; pip install 'pounding-risk[maps]'")


def frame_of(layer: Layer, crs: str | None) -> Any:
    """A layer as a table of GeoPandas."""
    from geopandas import GeoDataFrame

    return GeoDataFrame(layer.rows, columns=list(layer.columns), geometry=layer.shapes, crs=crs)


def _write(file: Path, layers: Iterable[Layer], crs: str | None, notes: Iterable[str]) -> None:
    """Write layers, their columns and their styles."""
    from pyogrio import write_dataframe

    words = "; ".join(notes)
    time_text = f"{now().partition('+')[0]}.000Z"
    kinds = {}
    for layer in layers:
        options = {"DESCRIPTION": words} | ({"SRID": NO_SYSTEM} if crs is None else {})
        frame = frame_of(layer, crs)
        kinds[layer.name] = KINDS.get(frame.geom_type.iloc[0] if len(frame) else "LineString", "fill")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "'crs' was not provided", UserWarning)
            kind = {"driver": "GPKG", "promote_to_multi": kinds[layer.name] != "marker", "layer_options": options}
            write_dataframe(frame, file, layer=layer.name, **kind)
    with closing(sqlite3.connect(file)) as connection, connection:
        connection.execute(COLUMNS)
        connection.execute(STYLES)
        connection.execute("INSERT INTO gpkg_extensions VALUES (?, ?, ?, ?, ?)", SCHEMA)
        facts: dict[str, Any] = {"table_name": "layer_styles", "data_type": "attributes", "identifier": "layer_styles"}
        _insert(connection, "gpkg_contents", facts | {"description": "styles of the layers, for QGIS", "srs_id": 0})
        for layer in layers:
            for name, column in layer.columns.items():
                unit = f" [{column.unit}]" if column.unit not in ("", "1") else ""
                described = {"table_name": layer.name, "column_name": name, "description": column.words + unit}
                _insert(connection, "gpkg_data_columns", described)
            place = {"f_table_catalog": "", "f_table_schema": "", "f_table_name": layer.name}
            place |= {"f_geometry_column": "geom", "styleName": layer.name}
            qml = style(kinds[layer.name], LABELS[layer.name])
            look: dict[str, Any] = {"styleQML": qml, "styleSLD": "", "useAsDefault": 1}
            look |= {"description": "classes of P(contact)", "owner": "", "update_time": time_text}
            _insert(connection, "layer_styles", place | look)
        connection.execute("UPDATE gpkg_contents SET last_change = ?", (time_text,))


def _insert(connection: sqlite3.Connection, table: str, columns: dict[str, Any]) -> None:
    places = ", ".join("?" * len(columns))
    connection.execute(f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({places})", tuple(columns.values()))
