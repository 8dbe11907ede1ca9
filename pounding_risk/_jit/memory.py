"""New arrays inside kernels. Numba's own ``np.zeros`` compiles some thirty functions with it, for its messages."""

from __future__ import annotations

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_new_ref
from numba.extending import intrinsic
from numba.np.arrayobj import _empty_nd_impl

from pounding_risk._jit.compile import INTERPRETED

zeros = np.zeros  # (shape, dtype): a tuple of integers, a class of numbers

if not INTERPRETED:

    @intrinsic
    def zeros(typingctx, shape, dtype):
        """A new array of zeros of this shape, a tuple of integers."""
        array = types.Array(dtype.dtype, len(shape), "C")

        def codegen(context, builder, signature, arguments):
            lengths = cgutils.unpack_tuple(builder, arguments[0])
            kinds = signature.args[0]
            lengths = [context.cast(builder, n, kind, types.intp) for n, kind in zip(lengths, kinds, strict=True)]
            made = _empty_nd_impl(context, builder, array, lengths)
            cgutils.memset(builder, made.data, builder.mul(made.itemsize, made.nitems), 0)
            return impl_ret_new_ref(context, builder, array, made._getvalue())

        return array(shape, dtype), codegen
