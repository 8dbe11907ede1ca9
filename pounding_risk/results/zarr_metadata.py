"""Security check of the metadata of a Zarr store, read as plain JSON before a library opens the store.

A store names the codecs of its chunks and the types of its values, and some of these run code that the store contains:
a value of type object is a pickle. Only what `results.store` writes, and its equivalent in other versions of the
library, is accepted.
"""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Iterator
from math import prod
from pathlib import Path
from typing import Any

from pounding_risk.errors import PoundingError

# Attribute of a store that this package wrote, and may replace: its variables in order. Not in what is opened.
ZARR_MARK = "pounding_risk_variables"
CONSOLIDATED = ".zmetadata"
COMPRESSORS = ("blosc", "zstd", "zlib", "gzip", "lz4")  # they turn bytes into bytes, and nothing else
DTYPE = re.compile(r"[<>|][biuf][1248]|[<>]U[1-9]\d{0,4}")  # numbers, flags, and texts of a fixed width
TEXT_FILTER = "vlen-utf8"  # through which Zarr 3.0 writes texts, as their UTF-8; 3.1 writes them without
NAME = re.compile(r"[^./\\][^/\\]*")  # of a variable: one folder below the store's
AXES_OF = "_ARRAY_DIMENSIONS"  # attribute in which a variable's dimensions stand
LABELS = "coordinates"  # attribute in which the names of coordinates stand
# Attributes by which a reader would take the values for others; none is of ours.
PACKED = ("_FillValue", "missing_value", "scale_factor", "add_offset", "_Unsigned", "_Encoding", "dtype")
LARGEST = 1 << 31  # bytes of a piece: what Blosc, which wrote it, can hold
SOURCE = "a store of another origin, or one that was changed; it was not opened. Take what scan or convert wrote"


def is_zarr_of_ours(path: Path) -> bool:
    """Whether a folder is a Zarr store that this package wrote."""
    try:
        attrs = json.loads((path / ".zattrs").read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(attrs, dict) and ZARR_MARK in attrs


def check_store(path: Path) -> None:
    """Check everything that the metadata of a store could make a library do; no chunk is read.

    Raises PoundingError where the folder holds anything but plain files in one folder a variable, where metadata cannot
    be read, and where they name a codec or a type that this package does not write.
    """
    if not is_zarr_of_ours(path):
        raise PoundingError(f"{path}: is no Zarr store of pounding-risk; name what scan or convert wrote")
    _check_files(path)
    content = _json(path / CONSOLIDATED)  # the metadata of all variables, from which the library reads them
    documents = content.get("metadata") if isinstance(content, dict) else None
    if not isinstance(documents, dict) or not all(isinstance(document, dict) for document in documents.values()):
        raise PoundingError(f"{path / CONSOLIDATED}: holds no table of metadata; run the scan again")
    for name, document in documents.items():
        _check_document(path, name, document)
    for file in sorted(path.glob("*/.zarray")):
        _check_document(path, f"{file.parent.name}/.zarray", _json(file))
    _check_names(path, documents)
    _check_pieces(path, documents)


def _check_files(path: Path) -> None:
    """Refuse links, devices, and folders in folders: the chunks of a store are plain files."""
    for folder, entries in _entries(path):
        for entry in entries:
            mode = entry.stat(follow_symlinks=False).st_mode
            if stat.S_ISREG(mode) or (folder == path and stat.S_ISDIR(mode)):
                continue
            kind = "a symbolic link" if stat.S_ISLNK(mode) else "a folder" if stat.S_ISDIR(mode) else "no plain file"
            raise PoundingError(f"{path}: {Path(entry.path).relative_to(path)} is {kind}: {SOURCE}")
    for file in (path / "zarr.json", *path.glob("*/zarr.json")):
        if file.exists():
            raise PoundingError(f"{path}: {file.relative_to(path)} is of Zarr's third format: {SOURCE}")


def _entries(path: Path) -> Iterator[tuple[Path, list[os.DirEntry[str]]]]:
    """The entries of the folder of a store, and of each folder directly in it."""
    try:
        top = list(os.scandir(path))
        yield path, top
        for entry in top:
            yield Path(entry.path), list(os.scandir(entry.path)) if entry.is_dir(follow_symlinks=False) else []
    except OSError as error:
        raise PoundingError(f"{error.filename or path}: cannot be read ({error.strerror}); check its rights") from None


def _json(file: Path) -> Any:
    """A metadata file; raises PoundingError where it cannot be read."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        json.dumps(content, ensure_ascii=False).encode()  # half a letter, which JSON can hold, is no text
        return content
    except FileNotFoundError:
        raise PoundingError(f"{file}: is missing: the store is not whole; run the scan again") from None
    except (OSError, ValueError, RecursionError) as error:
        raise PoundingError(f"{file}: cannot be read as JSON ({error}); run the scan again") from None


def _check_document(path: Path, name: str, document: Any) -> None:
    """Check one entry of the metadata, such as "impact_count/.zarray"."""
    variable, _, kind = name.rpartition("/")
    if kind not in (".zgroup", ".zattrs", ".zarray") or (variable and not NAME.fullmatch(variable)):
        raise PoundingError(f"{path}: its metadata hold {name!r}, which is no entry of such a store: {SOURCE}")
    if kind == ".zarray":
        fault = _array_fault(document)
        if fault:
            raise PoundingError(f"{path}: the variable {variable}: {fault}: {SOURCE}")
    if kind != ".zattrs":
        return
    dims = document.get(AXES_OF)
    if variable and (not isinstance(dims, list) or not all(isinstance(dim, str) and dim for dim in dims)):
        raise PoundingError(f"{path}: the variable {variable} names no dimensions; run the scan again")
    if variable and len(set(dims)) < len(dims):
        raise PoundingError(f"{path}: the variable {variable} names a dimension twice: {SOURCE}")
    if packed := [attr for attr in PACKED if variable and attr in document]:
        raise PoundingError(f"{path}: the variable {variable} has the attribute {packed[0]}: {SOURCE}")
    if variable and " since " in str(document.get("units", "")):  # netCDF would make a date of it; none of ours is one
        raise PoundingError(f"{path}: the variable {variable} has the units {document['units']!r}: {SOURCE}")
    for attr, value in document.items():
        if attr in (AXES_OF, ZARR_MARK) or (isinstance(value, str) if attr == LABELS else _is_attribute(value)):
            continue
        owner = f" of the variable {variable}" if variable else ""
        value_text = repr(value) if len(repr(value)) < 40 else f"{repr(value)[:40]}..."
        kinds = "text" if attr == LABELS else "text or numbers"
        raise PoundingError(f"{path}: the attribute {attr}{owner} is {value_text}, not {kinds}: {SOURCE}")


def _is_attribute(value: Any) -> bool:
    """True for what netCDF can hold too: a text, a number, or a list of numbers or of texts."""
    if isinstance(value, list):
        return bool(value) and (all(map(_is_number, value)) or all(isinstance(text, str) for text in value))
    return isinstance(value, str) or _is_number(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, float) or (type(value) is int and abs(value) < 1 << 63)


def _array_fault(document: Any) -> str:
    """The fault of the metadata of a variable; "" where there is none."""
    if not isinstance(document, dict):
        return "its metadata are no table"
    dtype, compressor, filters = (document.get(key) for key in ("dtype", "compressor", "filters"))
    if not isinstance(dtype, str) or not DTYPE.fullmatch(dtype):
        return f"values of type {dtype!r} can hold code; allowed are numbers and texts of a fixed width"
    filter_list = filters if isinstance(filters, list) else [filters] if filters else []
    if unknown := [_codec(codec) for codec in filter_list if not ("U" in dtype and _codec(codec) == TEXT_FILTER)]:
        return f"the filter {unknown[0]} is not allowed; {f'{TEXT_FILTER} is' if 'U' in dtype else 'none is'}"
    if compressor is not None and _codec(compressor) not in COMPRESSORS:
        return f"the codec {_codec(compressor)} is not allowed; one of {', '.join(COMPRESSORS)} is"
    shape, chunks = document.get("shape", []), document.get("chunks", [])
    if not (_are_sizes(shape, 0) and _are_sizes(chunks, 1)) or len(shape) != len(chunks):
        return f"its shape {shape!r} and the shape of its pieces {chunks!r} are not those of an array"
    size = prod(chunks) * int(dtype[2:]) * (4 if "U" in dtype else 1)
    if size > LARGEST:
        return f"a piece would hold {size:.3g} bytes, more than the {LARGEST:.3g} that one can"
    return ""


def _codec(codec: Any) -> str:
    """The name of a codec, shortened where it is no name."""
    name = codec.get("id") if isinstance(codec, dict) else codec
    return name if isinstance(name, str) and len(name) < 40 else repr(name)[:40]


def _are_sizes(sizes: Any, least: int) -> bool:
    return isinstance(sizes, list) and all(type(size) is int and size >= least for size in sizes)


def _check_names(path: Path, documents: dict[str, dict[str, Any]]) -> None:
    """Check that the variables are those that the store was marked with when it was written."""
    marked_names = documents.get(".zattrs", {}).get(ZARR_MARK)
    arrays = {name.rpartition("/")[0] for name in documents if name.endswith("/.zarray")}
    if not isinstance(marked_names, list) or not all(isinstance(name, str) for name in marked_names):
        raise PoundingError(f"{path}: the attribute {ZARR_MARK} is no list of names; run the scan again")
    if missing := sorted(set(marked_names) - arrays):
        raise PoundingError(f"{path}: the variables {', '.join(missing)} are missing; run the scan again")
    if added := sorted(arrays - set(marked_names)):
        raise PoundingError(f"{path}: the variables {', '.join(added)} were added to it: {SOURCE}")
    if undocumented := sorted(name for name in arrays if f"{name}/.zattrs" not in documents):
        raise PoundingError(f"{path}: the variables {', '.join(undocumented)} name no dimensions; run the scan again")


def _check_pieces(path: Path, documents: dict[str, dict[str, Any]]) -> None:
    """Check that each variable has files for its pieces; of a damaged shape the library would list a great many."""
    for name, document in documents.items():
        if name.endswith("/.zarray"):
            variable = name.removesuffix("/.zarray")
            sizes = zip(document.get("shape", []), document.get("chunks", []), strict=True)
            expected = prod(-(-size // piece) for size, piece in sizes)
            pieces = sum(not file.name.startswith(".") for file in (path / variable).glob("*"))
            if pieces < expected:
                raise PoundingError(
                    f"{path}: pieces of it are missing ({variable} lacks {expected - pieces}); run the scan again"
                )
