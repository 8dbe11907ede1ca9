"""What compiled functions take by one pointer: records of named arrays, and named tuples of arrays by address.

The fields of a record lie at fixed offsets: reading ``workspace.states`` costs nothing, no reference is counted, and
a call hands over one pointer instead of the nine numbers that describe an array.

Numba hands a tuple over field by field, and an array as some nine numbers: a call with a dozen arrays writes a hundred
numbers to the stack, and compiling it takes as many instructions. A tuple passed by address is one pointer to a table
of addresses and lengths. Its arrays are C-contiguous and belong to the caller, who holds them while the compiled
function runs. Their indices count from the start and are never below zero: an index that might be would have to be
looked at, and loops over floors would not be done several at a time.
"""

from __future__ import annotations

from copy import deepcopy
from types import SimpleNamespace
from typing import Any

import numpy as np

from pounding_risk._jit.compile import in_kernels, numba_side, small
from pounding_risk._jit.sources import INTERPRETED

Field = tuple[int, ...] | type[float] | np.dtype


def record_type(**fields: Field) -> np.dtype:
    """Type of a record whose fields are arrays of float64 (given by their shape), floats, or records.

    A name that numpy's scalars use themselves, such as ``size``, would not be found by code that is not compiled.
    """
    reserved = [name for name in fields if hasattr(np.generic, name)]
    if reserved:
        raise ValueError(f"{', '.join(reserved)}: attributes of every numpy scalar; choose other field names")
    kinds = [
        (name, np.float64, kind) if isinstance(kind, tuple) else (name, np.float64 if kind is float else kind)
        for name, kind in fields.items()
    ]
    return np.dtype((np.record, np.dtype(kinds, align=True)))


def new_record(kind: np.dtype) -> Any:
    """A record of this type, filled with zeros. Interpreted kernels get a plain object, which is faster to read."""
    return _plain(kind) if INTERPRETED else np.zeros(1, dtype=kind)[0]


def new_records(kind: np.dtype, count: int) -> Any:
    """``count`` records of this type, as `new_record` makes one."""
    return [_plain(kind) for _ in range(count)] if INTERPRETED else np.zeros(count, dtype=kind)


def set_column(records: Any, name: str, values: Any) -> None:
    """Set one field of all ``records``, with one row of ``values`` for each."""
    if INTERPRETED:
        for record, value in zip(records, np.asarray(values, dtype=np.float64), strict=True):
            setattr(record, name, value)
    else:
        records[name] = values


def column(records: Any, name: str) -> np.ndarray:
    """A copy of one field of all ``records``, a row for each."""
    return np.array([getattr(record, name) for record in records]) if INTERPRETED else records[name].copy()


def copy_record(source, i, target, j):
    """Copy record ``i`` of ``source`` over record ``j`` of ``target``."""
    target[j] = deepcopy(source[i])


if not INTERPRETED:

    @small
    def copy_record(source, i, target, j):
        target[j] = source[i]


def _plain(kind: np.dtype) -> SimpleNamespace:
    fields: dict[str, Any] = {}
    for name in kind.names or ():
        inner = kind[name]
        if inner.names:
            fields[name] = _plain(inner)
        else:
            fields[name] = np.zeros(inner.shape) if inner.shape else 0.0
    return SimpleNamespace(**fields)


def by_address(model) -> Any:
    """A named tuple for compiled functions to take by address; interpreted ones take the tuple itself.

    Its fields are C-contiguous arrays, records, numbers, or named tuples of these. The arrays must outlive the call.
    """
    return model if INTERPRETED else numba_side().by_address.ByAddress(model)


@in_kernels("memory")
def zeros(shape, dtype):
    """A new array of zeros of this shape, a tuple of integers, and of this class of numbers, inside kernels too.

    Numba's own ``np.zeros`` compiles some thirty functions with it, for its messages.
    """
    return np.zeros(shape, dtype)
