"""Models as rows of numbers, and calls by address: what lets one compiled kernel serve models that it does not know."""

from __future__ import annotations

from threading import Lock

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from pounding_risk._jit.compile import FLAGS, INLINED, INTERPRETED


def _leaves(kind) -> int:
    """How many numbers a model of this numba type holds."""
    return sum(map(_leaves, kind.types)) if isinstance(kind, types.BaseTuple) else 1


@intrinsic
def _model_of(typingctx, model, values, place, offset):
    def codegen(context, builder, signature, arguments):
        kind, table = signature.args[0], make_array(signature.args[1])(context, builder, arguments[1])
        width = cgutils.unpack_tuple(builder, table.shape)[1]
        data = builder.gep(table.data, [builder.add(builder.mul(arguments[2], width), arguments[3])])

        def build(part, at):
            if not isinstance(part, types.BaseTuple):
                return builder.load(builder.gep(data, [context.get_constant(types.intp, at)])), at + 1
            parts = []
            for inner in part.types:
                value, at = build(inner, at)
                parts.append(value)
            return context.make_tuple(builder, part, parts), at

        return build(kind, 0)[0]

    return model(model, values, types.intp, types.intp), codegen


def model_of(model, values, place, offset):
    """A model of the kind of ``model`` with the numbers that `numbers_of` has written to ``values[place, offset:]``.

    One compiled kernel so serves contacts whose laws differ in their numbers. ``values`` is C-contiguous, of floats.
    A plain tuple, or a single number, is taken as well.
    """
    numbers = iter(values[place, offset:])

    def build(part):
        if not isinstance(part, tuple):
            return float(next(numbers))
        parts = [build(inner) for inner in part]
        return type(part)(*parts) if hasattr(part, "_fields") else tuple(parts)

    return build(model)


if not INTERPRETED:
    model_of = njit(**INLINED)(
        lambda model, values, place, offset: _model_of(model, values, place, offset)
    )


@intrinsic
def _lay_model(typingctx, model, values, place, offset):
    def codegen(context, builder, signature, arguments):
        target = _place_in(context, builder, signature.args[1], *arguments[1:4])

        def lay(part, value, at):
            if not isinstance(part, types.BaseTuple):
                number = context.cast(builder, value, part, types.float64)
                builder.store(number, builder.gep(target, [context.get_constant(types.intp, at)]))
                return at + 1
            for number, inner in enumerate(part.types):
                at = lay(inner, builder.extract_value(value, number), at)
            return at

        return context.get_constant(types.intp, lay(signature.args[0], arguments[0], 0))

    return types.intp(model, values, types.intp, types.intp), codegen


def lay_model(model, values, place, offset):
    """Write the numbers of a model, a tuple or a single number to ``values[place, offset:]``; returns how many."""
    numbers = numbers_of((model,))
    values[place, offset : offset + len(numbers)] = numbers
    return len(numbers)


if not INTERPRETED:
    lay_model = njit(**INLINED)(
        lambda model, values, place, offset: _lay_model(model, values, place, offset)
    )


def _place_in(context, builder, kind, array, row, column):
    """Address of an element of a C-contiguous array of two dimensions."""
    table = make_array(kind)(context, builder, array)
    width = cgutils.unpack_tuple(builder, table.shape)[1]
    return builder.gep(table.data, [builder.add(builder.mul(row, width), column)])


def _row_of(context, builder, signature, arguments):
    """Address of row ``arguments[2]`` of the array ``arguments[1]``."""
    first = context.get_constant(types.intp, 0)
    return _place_in(context, builder, signature.args[1], arguments[1], arguments[2], first)


@intrinsic
def _call_at(typingctx, address, values, row, a, b, c):
    def codegen(context, builder, signature, arguments):
        real = context.get_value_type(types.float64)
        kind = ir.FunctionType(real, [real.as_pointer(), real, real, real])
        entry = builder.inttoptr(builder.fptoui(arguments[0], ir.IntType(64)), kind.as_pointer())
        return builder.call(entry, [_row_of(context, builder, signature, arguments), *arguments[3:]])

    real = types.float64
    return real(real, values, types.intp, real, real, real), codegen


@intrinsic
def _call_on(typingctx, address, values, row, slots):
    def codegen(context, builder, signature, arguments):
        real = context.get_value_type(types.float64)
        kind = ir.FunctionType(real, [real.as_pointer(), real.as_pointer()])
        entry = builder.inttoptr(builder.fptoui(arguments[0], ir.IntType(64)), kind.as_pointer())
        data = make_array(signature.args[3])(context, builder, arguments[3]).data
        return builder.call(entry, [_row_of(context, builder, signature, arguments), data])

    real = types.float64
    return real(real, values, types.intp, slots), codegen


ENTERING = Lock()  # held by whoever adds to these, so that threads neither compile twice nor take each other's place
_ENTRIES: list = []  # what addresses lead to: compiled functions, which live as long as the process


def entry_of(function, arguments: int) -> float:
    """The address of a compiled function of a model's numbers and of three floats, or of an array to work on.

    A kernel that calls by address is compiled once, whatever the model; a call costs some nanoseconds more than code
    that is in place. As a float, which holds every address, it stands among the numbers that a kernel is given.
    ``arguments`` is 3 or 1.
    """
    if INTERPRETED:
        _ENTRIES.append(function)
        return float(len(_ENTRIES) - 1)
    real = types.float64
    further = [real] * 3 if arguments == 3 else [types.CPointer(real)]
    flags = {name: value for name, value in FLAGS.items() if name != "no_cfunc_wrapper"}
    compiled = numba.cfunc(real(types.CPointer(real), *further), **flags)(function)
    _ENTRIES.append(compiled)
    return float(compiled.address)


def call_at(address, values, row, a, b, c):
    """Call the function at ``address`` with the numbers in ``values[row]`` and three floats."""
    return _ENTRIES[int(address)](values[row], a, b, c)


def call_on(address, values, row, slots):
    """Call the function at ``address`` with the numbers in ``values[row]`` and an array that it reads and writes."""
    return _ENTRIES[int(address)](values[row], slots)


def as_row(pointer, count):
    """``count`` floats at a pointer as an array of one row."""
    return np.asarray(pointer)[:count].reshape(1, count)


if not INTERPRETED:
    call_at = njit(**INLINED)(
        lambda address, values, row, a, b, c: _call_at(address, values, row, a, b, c)
    )
    call_on = njit(**INLINED)(lambda address, values, row, slots: _call_on(address, values, row, slots))
    as_row = njit(**INLINED)(lambda pointer, count: numba.carray(pointer, (1, count)))


def numbers_of(model) -> list[float]:
    """Every number of a model, in the order of its fields; those of a model inside it in its place."""
    numbers: list[float] = []
    for value in model:
        numbers += numbers_of(value) if isinstance(value, tuple) else [float(value)]
    return numbers
