"""Models as rows of numbers, and calls by address: what lets one compiled kernel serve models that it does not know.

Compiled code has the functions of the same names in `lowering/calls.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import Lock
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from pounding_risk._jit.compile import in_kernels

ENTERING = Lock()  # held by whoever adds to these, so that threads neither compile twice nor take each other's place
_ENTRIES: list = []  # what addresses lead to: compiled functions, which live as long as the process


@in_kernels("calls")
def call_at(address, values, row, a, b, c):
    """Call the function at ``address`` with the numbers in ``values[row]`` and three floats."""
    return _ENTRIES[int(address)](values[row], a, b, c)


@in_kernels("calls")
def call_on(address, values, row, slots):
    """Call the function at ``address`` with the numbers in ``values[row]`` and an array that it reads and writes."""
    return _ENTRIES[int(address)](values[row], slots)


def numbers_of(model) -> list[float]:
    """Every number of a model, in the order of its fields; those of a model inside it in its place."""
    numbers: list[float] = []
    for value in model:
        numbers += numbers_of(value) if isinstance(value, tuple) else [float(value)]
    return numbers


# What follows serves models whose numbers stand at an address of their own: a pointer in compiled code, a float that
# holds it among the numbers of a kernel, and an array in what Python itself runs.


@in_kernels("calls")
def leaves_of(model) -> int:
    """How many numbers a model, a tuple or a number holds."""
    return len(numbers_of((model,)))


@in_kernels("calls")
def model_at(model, numbers, offset):
    """A model of the kind of ``model`` with the numbers from ``numbers[offset]`` on; of a number the number itself."""
    remaining = iter(numbers[offset:])

    def build(part):
        if not isinstance(part, tuple):
            return float(next(remaining))
        parts = [build(inner) for inner in part]
        return type(part)(*parts) if hasattr(part, "_fields") else tuple(parts)

    return build(model)


@in_kernels("calls")
def lay_at(model, numbers, offset):
    """Write the numbers of a model, a tuple or a single number from ``numbers[offset]`` on; returns how many."""
    written = numbers_of((model,))
    numbers[offset : offset + len(written)] = written
    return len(written)


_ARRAYS: WeakValueDictionary[int, Any] = WeakValueDictionary()  # arrays by their address, for Python


def address_of(array: np.ndarray) -> float:
    """The address of an array of floats, which must outlive its use."""
    address = int(array.ctypes.data)
    _ARRAYS[address] = array
    return float(address)


@in_kernels("calls")
def call_numbers(address, numbers, a, b, c):
    """Call the function at ``address`` with the numbers at another and three floats."""
    return _ENTRIES[int(address)](_ARRAYS[int(numbers)], a, b, c)


@in_kernels("calls")
def call_slots(address, numbers, slots):
    """Call the function at ``address`` with the numbers at another and the floats at a third, read and written."""
    return _ENTRIES[int(address)](_ARRAYS[int(numbers)], _ARRAYS[int(slots)])


@in_kernels("calls")
def read_slot(slots, number):
    """The float number ``number``, from 0, of those at the address ``slots``."""
    return float(_ARRAYS[int(slots)][number])


@in_kernels("calls")
def write_slots(slots, values):
    """Write a tuple of floats to the address ``slots`` and after."""
    _ARRAYS[int(slots)][: len(values)] = values


def _entered(function: Callable[..., float], model, memory) -> float:
    _ENTRIES.append(partial(function, model, memory))
    return float(len(_ENTRIES) - 1)


@in_kernels("calls")
def entry_of_numbers(function, model, memory):
    """The address of ``function(model, memory, numbers, a, b, c)`` for models and memories of these kinds.

    ``function`` is `small`; the numbers of ``model`` and ``memory`` play no part. In compiled code only: the kernel
    that asks holds the machine code, so that the cache keeps it as it keeps every kernel.
    """
    return _entered(function, model, memory)


@in_kernels("calls")
def entry_of_slots(function, model, memory):
    """As `entry_of_numbers`, of ``function(model, memory, numbers, slots)``."""
    return _entered(function, model, memory)
