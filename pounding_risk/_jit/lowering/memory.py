"""Arrays that kernels make, and arrays whose references they do not count."""

from __future__ import annotations

from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_new_ref
from numba.extending import intrinsic
from numba.np.arrayobj import _empty_nd_impl, make_array, populate_array

from pounding_risk._jit.lowering.build import small


@intrinsic
def zeros(typingctx, shape, dtype):
    """A new array of zeros of this shape, a tuple of integers."""
    array = types.Array(dtype.dtype, len(shape), "C")

    def codegen(context, builder, signature, arguments):
        lengths = cgutils.unpack_tuple(builder, arguments[0])
        kinds = signature.args[0]
        lengths = [context.cast(builder, n, kind, types.intp) for n, kind in zip(lengths, kinds, strict=True)]
        view = _empty_nd_impl(context, builder, array, lengths)
        cgutils.memset(builder, view.data, builder.mul(view.itemsize, view.nitems), 0)
        return impl_ret_new_ref(context, builder, array, view._getvalue())

    return array(shape, dtype), codegen


@intrinsic
def _without_reference(typingctx, array):
    def codegen(context, builder, signature, arguments):
        make = make_array(signature.args[0])
        source, view = make(context, builder, arguments[0]), make(context, builder)
        populate_array(
            view,
            data=source.data,
            shape=cgutils.unpack_tuple(builder, source.shape),
            strides=cgutils.unpack_tuple(builder, source.strides),
            itemsize=source.itemsize,
            meminfo=cgutils.get_null_value(source.meminfo.type),
            parent=cgutils.get_null_value(source.parent.type),
        )
        return view._getvalue()

    return array(array), codegen


uncounted = small(lambda array: _without_reference(array))
