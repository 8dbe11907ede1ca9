"""Buildings and interfaces as GeoParquet: a folder with a file each, with units and words in the columns' metadata."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import xarray as xr

from pounding_risk._common.written import write_folder
from pounding_risk.reports.exports import Options, Written
from pounding_risk.reports.exports._layers import Layer, layers_of
from pounding_risk.reports.exports.geopackage import NEEDED, frame_of, need

WORDS = "layers of buildings and interfaces as GeoParquet"
ENDINGS = ("",)
SOURCE = "results"
SEVERAL = True
TAKES = ("gap", "pga", "intensity_level", "street")


def write(results: list[xr.Dataset], target: Path, options: Options) -> Written:
    """Write the layers of rows, a file each; raises PoundingError as `layers_of`."""
    need((*NEEDED, "pyarrow"), "GeoParquet")
    layers = layers_of(results, options)
    files = (
        (f"{layer.name}.parquet", parquet_of(layer, layers.crs)) for layer in (layers.buildings, layers.interfaces)
    )
    return Written(write_folder(target, files), layers.notes)


def parquet_of(layer: Layer, crs: str | None) -> bytes:
    """The bytes of a layer's file; each column has ``units`` and ``long_name`` in its metadata, as in a dataset."""
    from pyarrow import parquet

    plain_file = BytesIO()
    frame_of(layer, crs).to_parquet(plain_file, index=False)
    plain_file.seek(0)
    table = parquet.read_table(plain_file)
    schema = table.schema
    for name, column in layer.columns.items():
        index = schema.get_field_index(name)
        metadata = {"long_name": column.words} | ({"units": column.unit} if column.unit else {})
        schema = schema.set(index, schema.field(index).with_metadata(metadata))
    file = BytesIO()
    parquet.write_table(table.cast(schema), file)
    return file.getvalue()
