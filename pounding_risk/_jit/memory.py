"""New arrays inside kernels. Numba's own ``np.zeros`` compiles some thirty functions with it, for its messages."""

from __future__ import annotations

import numpy as np

from pounding_risk._jit.compile import in_kernels


@in_kernels("memory")
def zeros(shape, dtype):
    """A new array of zeros of this shape, a tuple of integers, and of this class of numbers."""
    return np.zeros(shape, dtype)
