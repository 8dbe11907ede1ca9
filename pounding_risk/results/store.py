"""Stores that a dataset is written to block by block: in memory, as netCDF, or as Zarr, by the same calls.

A store is made from a dataset's template and takes the values of its batches. Whole blocks (`layout.blocks`) are
written at once; parts of a block are collected until another block is begun. Each block is written whole and is one
chunk of the file, so the bytes on disk depend only on the values and on the order of the calls.

netCDF is used from the calling thread, by one thread of a process at a time.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from itertools import takewhile
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore

from pounding_risk._common.files import discard, move_into_place, not_written, partial_of
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import (
    NETCDF,
    RESULTS,
    any_name,
    check_target,
    fixed_texts,
    netcdf_encoding,
    zarr_library,
)
from pounding_risk.results.layout import Template, blocks, place
from pounding_risk.results.zarr_metadata import ZARR_MARK

AGAIN = "free space and run the same command again, without --new: the chunks are kept"


class Blockwise(AbstractContextManager["Blockwise"]):
    """A store: collects batches in blocks, and refuses to be finished while batches are missing.

    Use it as a context manager: leaving it before it is finished abandons it.
    """

    def __init__(self, template: Template):
        self.template = template
        self._blocks = list(blocks(template))
        self._written = {name: np.zeros(template.batches, dtype=bool) for name in template.cases}
        self._block = range(0)  # of which parts are collected in `_held`
        self._held: dict[str, np.ndarray] = {}
        self._open = True

    def write(self, batches: range, arrays: Mapping[str, np.ndarray]) -> None:
        """Write values of batches, each (batches, cases in a batch, extra sizes), of some of the variables or all.

        Batches that were written before are overwritten. Raises PoundingError where the disk is full; nothing is left
        then.
        """
        with self._guarded():
            earliest = np.searchsorted([block.stop for block in self._blocks], batches.start, side="right")
            for block in takewhile(lambda block: block.start < batches.stop, self._blocks[earliest:]):
                shared = range(max(batches.start, block.start), min(batches.stop, block.stop))
                if block != self._block:
                    self._flush(block)
                for name, array in arrays.items():
                    rows = np.asarray(array)[shared.start - batches.start : shared.stop - batches.start]
                    self._take(block, shared, name, rows)

    def finish(self, attrs: Mapping[str, Any]) -> None:
        """Add attributes that are known at the end; the dataset is then complete, and under its final name.

        Raises PoundingError where the disk is full, ValueError where batches were not written.
        """
        with self._guarded():
            self._flush(range(0))
            holes = [name for name, written in self._written.items() if not written.all()]
            if holes:
                raise ValueError(f"batches of {', '.join(holes)} were never written")
            self._complete(attrs)
            self._open = False

    def abandon(self) -> None:
        """Remove what was written, unless the store is finished."""
        if self._open:
            self._open = False
            self._remove()

    def __exit__(self, *_: object) -> None:
        self.abandon()

    def _take(self, block: range, batches: range, name: str, array: np.ndarray) -> None:
        shape = (len(block), self.template.width, *self.template.extra(name))
        dtype = self.template.cases[name].dtype
        if array.shape != (len(batches), *shape[1:]):
            raise ValueError(f"{name} is {array.shape} for {len(batches)} batches of {shape[1:]}")
        if batches == block:
            self._held.pop(name, None)
            self._put(block, name, array.astype(dtype, casting="same_kind", copy=False))
        else:
            if name not in self._held:
                self._held[name] = (
                    self._get(block, name)
                    if self._written[name][block.start : block.stop].any()
                    else np.zeros(shape, dtype)
                )
            self._held[name][batches.start - block.start : batches.stop - block.start] = array
        self._written[name][batches.start : batches.stop] = True

    def _flush(self, block: range) -> None:
        """Write the block that is collected, before another ``block`` is."""
        for name, array in self._held.items():
            self._put(self._block, name, array)
        self._block, self._held = block, {}

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except BaseException as error:
            translated = self._translated(error)  # before anything is removed: it says how much space is left
            self.abandon()
            if translated is None:
                raise
            raise translated from None

    def _translated(self, error: BaseException) -> PoundingError | None:
        """The error to raise in place of ``error``; None where it stays as it is."""
        return None

    def _slices_of(self, block: range, name: str) -> tuple[tuple[slice, ...], tuple[int, ...]]:
        """Slices of a block along the axes of a variable, and its sizes along them."""
        extra = self.template.extra(name)
        slices = tuple(place(self.template, block).values())
        return (*slices, *(slice(None) for _ in extra)), (*(extent.stop - extent.start for extent in slices), *extra)

    @abstractmethod
    def _put(self, block: range, name: str, array: np.ndarray) -> None: ...

    @abstractmethod
    def _get(self, block: range, name: str) -> np.ndarray: ...

    @abstractmethod
    def _complete(self, attrs: Mapping[str, Any]) -> None: ...

    @abstractmethod
    def _remove(self) -> None: ...


class Memory(Blockwise):
    """Store that keeps the dataset in memory."""

    def __init__(self, template: Template):
        super().__init__(template)
        self._arrays = {
            name: np.zeros((template.batches, template.width, *template.extra(name)), variable.dtype)
            for name, variable in template.cases.items()
        }
        self._attrs: Mapping[str, Any] = {}

    def dataset(self) -> xr.Dataset:
        """The dataset that was written, with its labels."""
        sizes = tuple(self.template.skeleton.sizes[dim] for dim in self.template.dims)
        variables = {}
        for name, variable in self.template.cases.items():
            array = self._arrays[name].reshape(*sizes, *self.template.extra(name))
            variables[name] = ((*self.template.dims, *variable.dims), array, dict(variable.attrs))
        return self.template.skeleton.assign(variables).assign_attrs(self._attrs)

    def _put(self, block: range, name: str, array: np.ndarray) -> None:
        self._arrays[name][block.start : block.stop] = array

    def _get(self, block: range, name: str) -> np.ndarray:
        return self._arrays[name][block.start : block.stop].copy()

    def _complete(self, attrs: Mapping[str, Any]) -> None:
        self._attrs = dict(attrs)

    def _remove(self) -> None:
        self._arrays = {}


class OnDisk(Blockwise):
    """Store that writes beside its target and moves it into place; ``repair`` ends the sentence of a full disk."""

    _arrays: Mapping[str, Any]  # of the library, by variable; set by `_begin`

    def __init__(self, template: Template, target: str | Path, repair: str = AGAIN):
        super().__init__(template)
        self.target = check_target(target, RESULTS)
        self.partial, self._repair = partial_of(self.target), repair
        with self._guarded():
            discard(self.partial)  # left by a killed process of the same number; of a link only the link
            self._begin()

    def _translated(self, error: BaseException) -> PoundingError | None:
        # netCDF raises both where the disk is full.
        return not_written(self.target, error, self._repair) if isinstance(error, OSError | RuntimeError) else None

    @abstractmethod
    def _begin(self) -> None: ...

    def _chunked(self, name: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
        """The dimensions of a case variable, and the lengths of a block along them."""
        template, dims = self.template, (*self.template.dims, *self.template.cases[name].dims)
        block = {axis: extent.stop for axis, extent in place(template, self._blocks[0]).items()}
        return dims, tuple(block.get(dim, template.skeleton.sizes[dim]) for dim in dims)

    def _put(self, block: range, name: str, array: np.ndarray) -> None:
        slices, sizes = self._slices_of(block, name)
        self._arrays[name][slices] = array.reshape(sizes)

    def _get(self, block: range, name: str) -> np.ndarray:
        slices, _ = self._slices_of(block, name)
        shape = len(block), self.template.width, *self.template.extra(name)
        return np.asarray(self._arrays[name][slices]).reshape(shape)


class Netcdf(OnDisk):
    """A netCDF-4 file. Raises PoundingError where it cannot be written."""

    _file: Any = None

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        with NETCDF, super()._guarded():
            yield

    def _begin(self) -> None:
        skeleton = self.template.skeleton
        # Opened once: HDF5 2.2 ends the process where attributes are added to a file that was closed and opened again.
        self._file = netCDF4.Dataset(self.partial, "w", format="NETCDF4")
        with any_name():
            skeleton.dump_to_store(NetCDF4DataStore(self._file), encoding=netcdf_encoding(skeleton))
        self._file.set_auto_maskandscale(False)
        for name in self.template.cases:
            self._create(name)
        self._arrays = self._file.variables
        self._list_unattached()

    def _create(self, name: str) -> None:
        """Create a variable with the attributes that xarray would give it."""
        declared, (dims, chunk) = self.template.cases[name], self._chunked(name)
        variable = self._file.createVariable(
            name,
            declared.dtype,
            dims,
            fill_value=np.nan if declared.dtype.kind == "f" else None,
            zlib=True,
            complevel=1,
            shuffle=True,
            chunksizes=chunk,
        )
        # A block is written once: a cache of one chunk suffices, where the library would keep many of each variable.
        variable.set_var_chunk_cache(int(np.prod(chunk)) * declared.dtype.itemsize, 7, 1.0)
        labels = self._labels(dims)
        variable.setncatts(dict(declared.attrs) | ({"coordinates": " ".join(labels)} if labels else {}))

    def _labels(self, dims: tuple[str, ...]) -> list[str]:
        """Coordinates, other than axes, of a variable of these dimensions."""
        # Of a dataset by its name xarray makes an array with all its coordinates; its variables are there.
        skeleton = self.template.skeleton
        variables, labels = skeleton.variables, set(skeleton.coords) - set(skeleton.dims)
        return sorted(str(name) for name in labels if set(variables[name].dims) <= set(dims))

    def _list_unattached(self) -> None:
        """List in the file's attribute only coordinates that no variable has; xarray listed those of the skeleton's."""
        if "coordinates" not in self._file.ncattrs():
            return
        attached = {
            label
            for name, declared in self.template.cases.items()
            for label in self._labels((*self.template.dims, *declared.dims))
        }
        unattached = [name for name in self._file.coordinates.split() if name not in attached]
        if unattached:
            self._file.coordinates = " ".join(unattached)
        else:
            del self._file.coordinates

    def _complete(self, attrs: Mapping[str, Any]) -> None:
        self._file.setncatts(dict(attrs))
        self._file.close()
        move_into_place(self.partial, self.target)

    def _remove(self) -> None:
        with NETCDF:
            discard(self.partial)  # before closing, which on a full disk cannot succeed until it is
            if self._file is not None and self._file.isopen():
                with suppress(OSError, RuntimeError):  # the file has been removed
                    self._file.close()


class Zarr(OnDisk):
    """A Zarr store: a folder with one file per block and variable. Raises PoundingError where it cannot be written.

    The second format of Zarr is used, which every reader knows and in which texts have a fixed representation. Every
    chunk is written, empty or not, so that a lost one is found missing instead of being read as fill values. An older
    store of the same name is replaced in two steps, see `_common.files`.
    """

    _group: Any = None

    def _begin(self) -> None:
        import dask.array
        import zarr

        template = self.template
        skeleton = template.skeleton.drop_encoding()
        dataset, encoding = skeleton, {}
        for name, variable in template.cases.items():
            dims, chunk = self._chunked(name)
            empty = dask.array.zeros(tuple(skeleton.sizes[dim] for dim in dims), dtype=variable.dtype, chunks=chunk)
            dataset = dataset.assign({name: (dims, empty, dict(variable.attrs))})
            encoding[name] = {"chunks": chunk}
        dataset = fixed_texts(dataset).assign_attrs({ZARR_MARK: [str(name) for name in dataset.variables]})
        with zarr.config.set({"array.write_empty_chunks": True}):
            # Metadata and the skeleton; the cases' own values come block by block.
            dataset.to_zarr(self.partial, mode="w", compute=False, encoding=encoding, zarr_format=2, consolidated=True)
            self._group = zarr.open_group(self.partial, mode="r+", zarr_format=2)
            self._arrays = {name: self._group[name] for name in template.cases}

    def _complete(self, attrs: Mapping[str, Any]) -> None:
        import zarr

        arrays = (np.ndarray, np.generic)  # JSON has none
        plain = {name: attr.tolist() if isinstance(attr, arrays) else attr for name, attr in attrs.items()}
        self._group.attrs.update(plain)
        zarr.consolidate_metadata(self.partial, zarr_format=2)
        move_into_place(self.partial, self.target)

    def _remove(self) -> None:
        discard(self.partial)


def store_of(template: Template, target: str | Path, repair: str = AGAIN) -> OnDisk:
    """The store of a target by its suffix, ``.nc`` or ``.zarr``; raises PoundingError as `check_target`."""
    path = check_target(target, RESULTS)
    if path.suffix.lower() == ".zarr":
        zarr_library()  # refused here where a library is not installed
        return Zarr(template, path, repair)
    return Netcdf(template, path, repair)
