"""Named tuples of arrays that compiled functions take by address.

Numba hands a tuple over field by field, and an array as some nine numbers: a call with a dozen arrays writes a hundred
numbers to the stack, and compiling it takes as many instructions. A tuple passed by address is one pointer to a table
of addresses and lengths. Its arrays are C-contiguous and belong to the caller, who holds them while the compiled
function runs. Their indices count from the start and are never below zero: an index that might be would have to be
looked at, and loops over floors would not be done several at a time.
"""

from __future__ import annotations

from typing import Any

from pounding_risk._jit.compile import numba_side
from pounding_risk._jit.sources import INTERPRETED


def by_address(model) -> Any:
    """A named tuple for compiled functions to take by address; interpreted ones take the tuple itself.

    Its fields are C-contiguous arrays, records, numbers, or named tuples of these. The arrays must outlive the call.
    """
    return model if INTERPRETED else numba_side().by_address.ByAddress(model)
