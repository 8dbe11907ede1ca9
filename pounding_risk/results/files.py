"""Datasets on disk: reading and atomic writing of netCDF-4 and Zarr.

One thread of a process may use netCDF at a time, as its library is not thread-safe. A user may call from several
threads; workers of a scan call nothing here.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
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
from pounding_risk.results.attributes import DATASET_VERSION, SOURCE, VERSION, name_of
from pounding_risk.results.check import check_dataset
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import check_axes, with_axes
from pounding_risk.results.zarr_metadata import ZARR_MARK, check_store, is_zarr_of_ours
from pounding_risk.units import shown

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


def zarr_library() -> Any:
    """The library of Zarr; raises PoundingError where one that it needs is not installed."""
    try:
        import dask.array  # noqa: F401  of chunked variables
        import zarr
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
        with NETCDF, any_name():
            dataset.to_netcdf(partial, format="NETCDF4", engine="netcdf4", encoding=netcdf_encoding(dataset))
        move_into_place(partial, target)
    except (OSError, RuntimeError) as error:  # netCDF raises both where the disk is full
        raise not_written(target, error) from None
    finally:
        discard(partial)
    return target


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
        if Path(source).suffix.lower() == ".toml":
            sentence = "is a scene, not a dataset; run it with `pounding-risk scan` and name what that writes (.nc)"
            raise PoundingError(f"{source}: {sentence}") from None
        kind = "Zarr store" if Path(source).suffix.lower() == ".zarr" else "netCDF file"
        raise PoundingError(
            f"{source}: is not a readable {kind} ({type(error).__name__}: {error}); run the scan again"
        ) from None


@contextmanager
def any_name() -> Iterator[None]:
    """Write labels of keys such as ``interface."B | C".gap`` without a warning that they are marked by no attribute.

    A dataset that is read has them as labels again.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "coordinate .* has a space in its name", xr.SerializationWarning)
        yield


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
    with NETCDF, reading(path):
        dataset = _opened(Path(path), {} if lazy else None)
        if lazy:
            return dataset
        with dataset:
            return dataset.load()


def stream_results(path: str | Path) -> xr.Dataset:
    """Open a dataset lazily and without Dask, to be read block by block and closed."""
    with NETCDF:
        default_cache = netCDF4.get_chunk_cache()
        # Each chunk of a variable is read once; by default the library would keep 16 MB of every variable.
        netCDF4.set_chunk_cache(CHUNK_CACHE, *default_cache[1:])
        try:
            return _opened(Path(path), None)
        finally:
            netCDF4.set_chunk_cache(*default_cache)


def opened_or_given(results: xr.Dataset | str | Path, name: str = "") -> tuple[xr.Dataset, str]:
    """The dataset of a file and the file's name, or a dataset in memory and the ``name`` that sentences call it by.

    Raises PoundingError for anything else, and for a dataset of another version.
    """
    if isinstance(results, xr.Dataset):
        name = name or name_of(results)
        _check_version(results, name)
        return results, name
    if isinstance(results, str | Path):
        return open_results(results), str(results)
    raise PoundingError(f"{shown(results)} is neither a dataset nor a file of one; name what `scan` returned or wrote")


def open_with_axes(results: xr.Dataset | str | Path, name: str = "") -> Results:
    """`opened_or_given` with the axes of its cases, of `scan` or not; raises as this and `with_axes`."""
    dataset, name = opened_or_given(results, name)
    return Results(with_axes(dataset, name), name)


def open_scan(results: xr.Dataset | str | Path, name: str = "") -> Results:
    """The results of `scan`, or of its file, with all axes, and checked; raises PoundingError for another dataset."""
    opened = open_with_axes(results, name)
    check_dataset(opened.dataset, opened.name)
    return opened


def _opened(source: Path, chunks: dict[str, int] | None) -> xr.Dataset:
    is_zarr = source.suffix.lower() == ".zarr"
    if not (source.is_dir() if is_zarr else source.is_file()):
        older, checkpoint = moved_away(source), files.led_to(source).with_suffix(files.CHECKPOINT)
        repair = f"`pounding-risk scan SCENE -o {source.name}` writes one"
        if checkpoint.is_dir():
            repair = (
                f"its scan, in {checkpoint}, is not finished: `pounding-risk status {source}` says how far it is, and "
                "with which command it goes on"
            )
        raise PoundingError(
            f"{source}: no such results file; {repair}"
            + (f", or rename {older}, the results of before, which a crash left there" if older else "")
        )
    if is_zarr:
        dataset = _opened_store(source, chunks)
    else:
        with reading(source):
            dataset = xr.open_dataset(source, engine="netcdf4")
    dataset.encoding[SOURCE] = str(source)  # as the user wrote it
    try:
        _check_version(dataset, str(source))
        check_axes(dataset, str(source))
    except PoundingError:
        dataset.close()
        raise
    return dataset


def _check_version(dataset: xr.Dataset, label: str) -> None:
    """Raise PoundingError for a dataset of another version; one that states none is judged by its variables alone."""
    version = dataset.attrs.get(VERSION, DATASET_VERSION)
    if not isinstance(version, int | np.integer) or version < 1:
        raise PoundingError(
            f"{label}: the attribute {VERSION} is {shown(version)}, not a whole number from 1 on: the file was changed "
            "since it was written; take the one that scan wrote"
        )
    if version == DATASET_VERSION:
        return
    since, repair = ", written before the first release", "run the scan again"
    if version > DATASET_VERSION:
        since, repair = "", "run: pip install --upgrade pounding-risk"
    scope = f"this version of pounding-risk reads version {DATASET_VERSION}"
    raise PoundingError(f"{label}: is a dataset of version {version}{since}, and {scope}; {repair}")


# ------------------------------------------------------------------------------------------------ Zarr


def _opened_store(path: Path, chunks: dict[str, int] | None) -> xr.Dataset:
    """Open a Zarr store lazily, with Dask arrays where ``chunks`` is not None.

    Raises PoundingError where it was not written by this package, names a codec or a type that could run code (see
    `zarr_metadata`), or where pieces of it are missing.
    """
    zarr = zarr_library()
    check_store(path)
    with reading(path):
        group = zarr.open_consolidated(path, mode="r", zarr_format=2)
        lacking = {name: array.nchunks - array.nchunks_initialized for name, array in group.arrays()}
        if missing := [f"{name} lacks {count}" for name, count in lacking.items() if count > 0]:
            raise PoundingError(f"{path}: pieces of it are missing ({'; '.join(missing)}); run the scan again")
        # Values are what is stored: nothing of ours is packed or a date, and an attribute must not make it one.
        stored = xr.open_zarr(
            path, chunks=None, consolidated=True, zarr_format=2, mask_and_scale=False, decode_times=False
        )
        return _labelled(stored.assign({name: _watched(path, stored[name], chunks) for name in stored.data_vars}))


class _Watched(BackendArray):
    """A variable of a store, read when it is used: one that cannot be read then is damage of the store."""

    def __init__(self, path: Path, variable: xr.Variable):
        self.path, self.variable, self.shape, self.dtype = path, variable, variable.shape, variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        with reading(self.path):
            return _encodable(self.variable[key].values)


def _watched(path: Path, array: xr.DataArray, chunks: dict[str, int] | None) -> xr.Variable:
    """The variable with its pieces watched, as a Dask array of the stored pieces where ``chunks`` is not None."""
    raw = array.variable
    watched = xr.Variable(raw.dims, indexing.LazilyIndexedArray(_Watched(path, raw)), raw.attrs, raw.encoding)
    if chunks is None or not raw.ndim:
        return watched
    return watched.chunk(dict(zip(raw.dims, raw.encoding["chunks"], strict=True)) | chunks)


def _encodable(values: np.ndarray) -> np.ndarray:
    """The values; raises ValueError for texts with letters that do not exist, as damaged bytes give."""
    if values.dtype.kind == "U":
        codes = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("="))).view(np.uint32)
        if np.any((codes > 0x10FFFF) | ((codes >= 0xD800) & (codes < 0xE000))):
            raise ValueError("a text has letters that do not exist")
    return values


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


def fixed_texts(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with texts of a fixed width; netCDF gives them as objects, which Zarr would write otherwise."""
    texts = {name: variable.astype(str) for name, variable in dataset.variables.items() if variable.dtype.kind in "OT"}
    coords = {name: text for name, text in texts.items() if name in dataset.coords}
    return dataset.assign_coords(coords).assign({name: text for name, text in texts.items() if name not in coords})
