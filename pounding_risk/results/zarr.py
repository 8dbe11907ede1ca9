"""Zarr stores that `store` wrote, as datasets. Needs the extra ``cluster``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import dask.array  # noqa: F401  of chunked variables: missing, it is named at once
import numpy as np
import xarray as xr
import zarr
from xarray.backends import BackendArray
from xarray.core import indexing

from pounding_risk.errors import PoundingError
from pounding_risk.results.check import reading
from pounding_risk.results.zarr_metadata import ZARR_MARK, check_store


def fixed_texts(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with texts of a fixed width; netCDF gives them as objects, which Zarr would write otherwise."""
    texts = {name: variable.astype(str) for name, variable in dataset.variables.items() if variable.dtype.kind in "OT"}
    coords = {name: text for name, text in texts.items() if name in dataset.coords}
    return dataset.assign_coords(coords).assign({name: text for name, text in texts.items() if name not in coords})


def opened(path: Path, chunks: dict[str, int] | None) -> xr.Dataset:
    """Open a store lazily, with Dask arrays where ``chunks`` is not None.

    Raises PoundingError where it was not written by this package, names a codec or a type that could run code (see
    `zarr_metadata`), or where pieces of it are missing.
    """
    check_store(path)
    with reading(path):
        if missing := _missing_pieces(path):
            raise PoundingError(f"{path}: pieces of it are missing ({'; '.join(missing)}); run the scan again")
        # Values are what is stored: nothing of ours is packed or a date, and an attribute must not make it one.
        stored = xr.open_zarr(
            path, chunks=None, consolidated=True, zarr_format=2, mask_and_scale=False, decode_times=False
        )
        return _labelled(stored.assign({name: _watched(path, stored[name], chunks) for name in stored.data_vars}))


class _Watched(BackendArray):
    """A variable of a store, read when it is used: a piece that cannot be read then is told as damage of the store."""

    def __init__(self, path: Path, variable: xr.Variable):
        self.path, self.variable, self.shape, self.dtype = path, variable, variable.shape, variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        with reading(self.path):
            return _encodable(self.variable[key].values)


def _watched(path: Path, array: xr.DataArray, chunks: dict[str, int] | None) -> xr.Variable:
    """The variable with its pieces watched, as a Dask array of the stored pieces where ``chunks`` is not None."""
    whole = array.variable
    lazy = indexing.LazilyIndexedArray(_Watched(path, whole))
    watched = xr.Variable(whole.dims, lazy, whole.attrs, whole.encoding)
    if chunks is None or not whole.ndim:
        return watched
    return watched.chunk(dict(zip(whole.dims, whole.encoding["chunks"], strict=True)) | chunks)


def _encodable(values: np.ndarray) -> np.ndarray:
    """The values; raises ValueError for texts with letters that do not exist, as damaged bytes give."""
    if values.dtype.kind == "U":
        codes = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("="))).view(np.uint32)
        if np.any((codes > 0x10FFFF) | ((codes >= 0xD800) & (codes < 0xE000))):
            raise ValueError("a text has letters that do not exist")
    return values


def _missing_pieces(path: Path) -> list[str]:
    """Variables of which chunks are missing, and how many."""
    group = zarr.open_consolidated(path, mode="r", zarr_format=2)
    counts = {name: array.nchunks - array.nchunks_initialized for name, array in group.arrays()}
    return [f"{name} lacks {count}" for name, count in counts.items() if count > 0]


def _labelled(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset as it was written: its labels in memory, its variables in order, its flags of their own type."""
    for name in dataset.coords:
        _encodable(dataset.variables[name].load().values)
    for variable in dataset.variables.values():
        variable.attrs.pop("_FillValue", None)  # of Zarr, for pieces that are not there
        if "flag_values" in variable.attrs:  # JSON keeps no types, and CF wants the variable's own
            variable.attrs["flag_values"] = np.array(variable.attrs["flag_values"], dtype=variable.dtype)
    ordered = {name: dataset.variables[name] for name in dataset.attrs.pop(ZARR_MARK)}
    coords = {name: ordered.pop(name) for name in list(ordered) if name in dataset.coords}
    return xr.Dataset(ordered, coords, dataset.attrs)
