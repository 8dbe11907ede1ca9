"""Datasets on disk: reading and atomic writing of netCDF-4 and Zarr.

One thread of a process may use netCDF at a time, as its library is not thread-safe. A user may call from several
threads; workers of a scan call nothing here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from pounding_risk._common import files
from pounding_risk._common.files import discard, move_into_place, moved_away, not_written, partial_of
from pounding_risk.errors import PoundingError
from pounding_risk.results import accessor as accessor  # registers it with xarray
from pounding_risk.results.scene_axes import check_axes
from pounding_risk.results.upgrade import upgrade, widened
from pounding_risk.results.zarr_metadata import ZARR_MARK, is_zarr_of_ours

RESULTS = (".nc", ".zarr")  # suffixes of a dataset
NETCDF = RLock()  # held while netCDF is used
CHUNK_CACHE = 1 << 20  # bytes per variable


def check_target(path: str | Path, suffixes: tuple[str, ...] = (".nc",)) -> Path:
    """The path of a dataset that can be written; raises PoundingError before any work is done.

    As `files.check_target`; a ``.zarr`` that is there must be a store of this package.
    """
    target = files.check_target(path, suffixes)
    if target.suffix.lower() == files.STORE and target.exists() and not is_zarr_of_ours(target):
        raise PoundingError(f"{target}: is there already and no Zarr store of pounding-risk; choose another name")
    return target


def zarr_store() -> Any:
    """The module that reads and writes Zarr; raises PoundingError where a library that it needs is not installed."""
    try:
        return import_module("pounding_risk.results.zarr")
    except ModuleNotFoundError as error:
        raise PoundingError(
            f'Zarr needs {error.name}, which is not installed; run: pip install "pounding-risk[cluster]"'
        ) from None


def head_of(target: Path) -> tuple[set[str], dict[str, Any]]:
    """Names of the variables and dimensions of a dataset on disk, and its attributes, without reading any values.

    Raises OSError, RuntimeError or ValueError for what is no netCDF file or no store of this package.
    """
    return _head_of_store(target) if target.suffix.lower() == files.STORE else _head_of_file(target)


def _head_of_file(target: Path) -> tuple[set[str], dict[str, Any]]:
    with NETCDF, netCDF4.Dataset(target) as file:
        return {*file.dimensions, *file.variables}, {name: file.getncattr(name) for name in file.ncattrs()}


def _head_of_store(target: Path) -> tuple[set[str], dict[str, Any]]:
    attrs = json.loads((target / ".zattrs").read_text(encoding="utf-8"))
    names = attrs.get(ZARR_MARK) if isinstance(attrs, dict) else None
    return (set(map(str, names)), attrs) if isinstance(names, list) else (set(), {})


def netcdf_encoding(dataset: xr.Dataset) -> dict[Any, dict[str, Any]]:
    """How variables are stored: numbers compressed, and no fill value where nothing may be missing."""
    encoding: dict[Any, dict[str, Any]] = {name: {"_FillValue": None} for name in dataset.coords}
    for name, variable in dataset.data_vars.items():
        if variable.dtype.kind in "if" and variable.ndim:
            encoding[name] = {"zlib": True, "complevel": 1, "shuffle": True}
        if variable.dtype.kind == "i":
            encoding.setdefault(name, {})["_FillValue"] = None
    return encoding


def save(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write a dataset as netCDF-4, atomically: under a temporary name, synced, and moved into place.

    Parameters
    ----------
    dataset : xarray.Dataset
        What to write.
    path : str or Path
        File, ending in .nc. A process that has an older file of this name open keeps it.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    PoundingError
        Where the file cannot be written.
    """
    target = check_target(path)
    partial = partial_of(target)
    try:
        discard(partial)
        with NETCDF:
            dataset.to_netcdf(partial, format="NETCDF4", engine="netcdf4", encoding=netcdf_encoding(dataset))
        move_into_place(partial, target)
    except (OSError, RuntimeError) as error:  # netCDF raises both where the disk is full
        raise not_written(target, error) from None
    finally:
        discard(partial)
    return target


def open_results(path: str | Path, lazy: bool = False) -> xr.Dataset:
    """Read a dataset from netCDF or Zarr.

    Parameters
    ----------
    path : str or Path
        File ending in .nc, or folder ending in .zarr.
    lazy : bool
        Read values only when they are used, and close the dataset afterwards. Those of a Zarr store are Dask arrays;
        those of a netCDF file are not, as only one thread may read them. By default all values are read and the file
        is closed, so that it can be written again.

    Returns
    -------
    xarray.Dataset
        As it was written; one of an older version in the shape of this version, see `results.upgrade`.

    Raises
    ------
    PoundingError
        Where the file is missing, damaged, of another kind, or of a newer version.
    """
    if not lazy:
        with NETCDF, reading(path), _opened(Path(path), None) as dataset:
            return dataset.load()
    with NETCDF:
        return _opened(Path(path), {})


def stream_results(path: str | Path) -> xr.Dataset:
    """Open a dataset lazily and without Dask, to be read block by block and closed."""
    with NETCDF:
        usual = netCDF4.get_chunk_cache()
        # Each chunk of a variable is read once; by default the library would keep 16 MB of every variable.
        netCDF4.set_chunk_cache(CHUNK_CACHE, *usual[1:])
        try:
            return _opened(Path(path), None)
        finally:
            netCDF4.set_chunk_cache(*usual)


def _opened(source: Path, chunks: dict[str, int] | None) -> xr.Dataset:
    is_zarr = source.suffix.lower() == ".zarr"
    if not (source.is_dir() if is_zarr else source.is_file()):
        older = moved_away(source)
        raise PoundingError(
            f"{source}: no such results file; `pounding-risk scan SCENE -o {source.name}` writes one"
            + (f", or rename {older}, the results of before, which a crash left there" if older else "")
        )
    if is_zarr:
        dataset = upgrade(zarr_store().opened(source, chunks), str(source), _widened)
    else:
        with reading(source):
            dataset = upgrade(xr.open_dataset(source, engine="netcdf4"), str(source), _widened)
    try:
        check_axes(dataset, str(source))
    except PoundingError:
        dataset.close()
        raise
    return dataset


class _Widened(BackendArray):
    """A variable on disk with another axis of length 1 behind the others; values are read when they are used."""

    def __init__(self, variable: xr.Variable):
        self.variable, self.shape, self.dtype = variable, (*variable.shape, 1), variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        return self.variable[key[:-1]].values[..., None][..., key[-1]]


def _widened(variable: xr.Variable, dim: str) -> xr.Variable:
    """As `upgrade.widened`, without reading any values."""
    if variable.chunks is not None:  # of Dask arrays
        return widened(variable, dim)
    lazy = indexing.LazilyIndexedArray(_Widened(variable))
    return xr.Variable((*variable.dims, dim), lazy, variable.attrs)


@contextmanager
def reading(source: str | Path, kinds: tuple[type[Exception], ...] = (Exception,)) -> Iterator[None]:
    """Turn errors of these kinds while a dataset is read into PoundingError.

    All kinds by default: the libraries may raise anything for a damaged file.
    """
    try:
        yield
    except (PoundingError, MemoryError):
        raise
    except kinds as error:
        kind = "Zarr store" if Path(source).suffix.lower() == ".zarr" else "netCDF file"
        raise PoundingError(
            f"{source}: is not a readable {kind} ({type(error).__name__}: {error}); run the scan again"
        ) from None
