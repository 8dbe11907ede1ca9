"""Datasets on disk: reading and atomic writing of netCDF-4 and Zarr.

One thread of a process may use netCDF at a time, as its library is not thread-safe. A user may call from several
threads; workers of a scan call nothing here.
"""

from __future__ import annotations

import json
from pathlib import Path
from threading import RLock
from typing import Any

import netCDF4
import xarray as xr

from pounding_risk._common import files
from pounding_risk._common.files import discard, move_into_place, moved_away, not_written, partial_of
from pounding_risk.errors import PoundingError
from pounding_risk.results import accessor as accessor  # registers it with xarray
from pounding_risk.results.attributes import SOURCE, name_of
from pounding_risk.results.check import check_dataset, check_version, reading
from pounding_risk.results.opened import Results, with_axes
from pounding_risk.results.scene_axes import check_axes
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
        import pounding_risk.results.zarr as zarr
    except ModuleNotFoundError as error:
        raise PoundingError(
            f'Zarr needs {error.name}, which is not installed; run: pip install "pounding-risk[cluster]"'
        ) from None
    return zarr


def head_of(target: Path) -> tuple[set[str], dict[str, Any]]:
    """Names of the variables and dimensions of a dataset on disk, and its attributes, without reading any values.

    Raises OSError, RuntimeError or ValueError for what is no netCDF file or no store of this package.
    """
    if target.suffix.lower() != files.STORE:
        with NETCDF, netCDF4.Dataset(target) as file:
            return {*file.dimensions, *file.variables}, {name: file.getncattr(name) for name in file.ncattrs()}
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
        As it was written.

    Raises
    ------
    PoundingError
        Where the file is missing, damaged, of another kind, or of another version.
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


def open_with_axes(results: xr.Dataset | str | Path, name: str = "") -> Results:
    """A dataset, called so in sentences, or that of a file, with the axes of its cases; of `scan` or not."""
    if isinstance(results, str | Path):
        results, name = open_results(results), str(results)
    name = name or name_of(results)
    return Results(with_axes(results, name), name)


def open_scan(results: xr.Dataset | str | Path, name: str = "") -> Results:
    """The results of `scan`, or of its file, with all axes, and checked; raises PoundingError for another dataset."""
    opened = open_with_axes(results, name)
    check_dataset(opened.dataset, opened.name)
    return opened


def _opened(source: Path, chunks: dict[str, int] | None) -> xr.Dataset:
    is_zarr = source.suffix.lower() == ".zarr"
    if not (source.is_dir() if is_zarr else source.is_file()):
        older = moved_away(source)
        raise PoundingError(
            f"{source}: no such results file; `pounding-risk scan SCENE -o {source.name}` writes one"
            + (f", or rename {older}, the results of before, which a crash left there" if older else "")
        )
    if is_zarr:
        dataset = zarr_store().opened(source, chunks)
    else:
        with reading(source):
            dataset = xr.open_dataset(source, engine="netcdf4")
    dataset.encoding[SOURCE] = str(source)  # as the user wrote it
    try:
        check_version(dataset, str(source))
        check_axes(dataset, str(source))
    except PoundingError:
        dataset.close()
        raise
    return dataset
