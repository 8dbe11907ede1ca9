"""Datasets on disk: netCDF-4 that is whole or not there, and the provenance that goes with it.

One thread of a process may touch netCDF at a time: the libraries below crash otherwise. Nothing here is called
from a worker.
"""

from __future__ import annotations

import json
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

import xarray as xr

from pounding_risk.errors import PoundingError

LIBRARIES = ("pounding-risk", "numpy", "scipy", "numba", "xarray", "netCDF4", "obspy")


def versions() -> dict[str, str]:
    """Versions of what computed a result."""
    found = {"python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def check_target(path: str | Path, suffixes: tuple[str, ...] = (".nc",)) -> Path:
    """The path of a file that can be written; raises PoundingError before any work is done.

    Its folder must exist and be writable, its suffix be one of ``suffixes``, and it must not be a folder.
    """
    target = Path(path)
    folder = target.parent
    if not target.name:
        raise PoundingError(f"{target}: names no file; write one such as results{suffixes[0]}")
    if target.suffix.lower() not in suffixes:
        allowed = " or ".join(suffixes)
        raise PoundingError(f"{target}: the name must end in {allowed}; write {target.with_suffix(suffixes[0])}")
    if target.is_dir():
        raise PoundingError(f"{target}: is a folder; name a file in it")
    if not folder.is_dir():
        raise PoundingError(f"{target}: the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK):
        raise PoundingError(f"{target}: the folder {folder} cannot be written to; choose another one")
    return target


def save(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write a dataset as netCDF-4 under a temporary name, sync it, and move it into place.

    Whoever has the old file open keeps it; a run that is killed leaves no file under the final name. Raises
    PoundingError where the file cannot be written.
    """
    target = check_target(path)
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    encoding: dict[Any, dict[str, Any]] = {name: {"_FillValue": None} for name in dataset.coords}
    for name, variable in dataset.data_vars.items():
        if variable.dtype.kind in "if" and variable.ndim:
            encoding[name] = {"zlib": True, "complevel": 1, "shuffle": True}
        if variable.dtype.kind == "i":
            encoding.setdefault(name, {})["_FillValue"] = None
    try:
        dataset.to_netcdf(partial, format="NETCDF4", engine="netcdf4", encoding=encoding)
        with open(partial, "rb") as written:
            os.fsync(written.fileno())
        os.replace(partial, target)
    except OSError as error:
        raise PoundingError(
            f"{target}: cannot be written ({error.strerror or error}); free space or choose another place"
        ) from None
    finally:
        partial.unlink(missing_ok=True)
    return target


def open_results(path: str | Path) -> xr.Dataset:
    """A dataset from disk, read whole and closed, so that the file can be written again.

    Raises PoundingError where the file is missing or is no netCDF.
    """
    source = Path(path)
    if not source.is_file():
        raise PoundingError(f"{source}: no such results file; `pounding-risk scan SCENE -o {source.name}` writes one")
    try:
        return xr.load_dataset(source, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise PoundingError(f"{source}: is not a readable netCDF file ({error}); run the scan again") from None


def told(dataset: xr.Dataset, name: str, default: Any) -> Any:
    """What an attribute written by `as_text` holds, ``default`` where there is none.

    Raises PoundingError where the attribute is damaged.
    """
    try:
        return json.loads(dataset.attrs[name]) if name in dataset.attrs else default
    except (TypeError, ValueError):
        raise PoundingError(
            f'the attribute "{name}" of the results cannot be read: the file was changed since; run the scan again'
        ) from None


def as_text(value: Any) -> str:
    """JSON for an attribute: netCDF attributes hold no tables."""
    return json.dumps(value, ensure_ascii=False, sort_keys=True, default=str)
