"""Calls by address, and models whose numbers stand at one, as numba and LLVM write them: see `_jit/calls.py`."""

from __future__ import annotations

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from pounding_risk._jit.lowering.build import small

REAL = ir.DoubleType()
OF_NUMBERS = ir.FunctionType(REAL, [REAL.as_pointer(), REAL, REAL, REAL])
OF_SLOTS = ir.FunctionType(REAL, [REAL.as_pointer(), REAL.as_pointer()])


def _leaves(kind) -> int:
    """How many numbers a model of this numba type holds."""
    return sum(map(_leaves, kind.types)) if isinstance(kind, types.BaseTuple) else 1


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


@intrinsic
def _leaves_of(typingctx, model):
    count = _leaves(model)
    return types.intp(model), lambda context, builder, signature, arguments: context.get_constant(types.intp, count)


@intrinsic
def _model_at(typingctx, model, numbers, offset):
    def codegen(context, builder, signature, arguments):
        def build(part, entry):
            if not isinstance(part, types.BaseTuple):
                return builder.load(builder.gep(start, [context.get_constant(types.intp, entry)])), entry + 1
            parts = []
            for inner in part.types:
                value, entry = build(inner, entry)
                parts.append(value)
            return context.make_tuple(builder, part, parts), entry

        start = builder.gep(arguments[1], [arguments[2]])
        return build(signature.args[0], 0)[0]

    return model(model, numbers, types.intp), codegen


@intrinsic
def _lay_at(typingctx, model, numbers, offset):
    def codegen(context, builder, signature, arguments):
        start = builder.gep(arguments[1], [arguments[2]])

        def lay(part, value, entry):
            if not isinstance(part, types.BaseTuple):
                number = context.cast(builder, value, part, types.float64)
                builder.store(number, builder.gep(start, [context.get_constant(types.intp, entry)]))
                return entry + 1
            for number, inner in enumerate(part.types):
                entry = lay(inner, builder.extract_value(value, number), entry)
            return entry

        return context.get_constant(types.intp, lay(signature.args[0], arguments[0], 0))

    return types.intp(model, numbers, types.intp), codegen


def _pointer(builder, address):
    return builder.inttoptr(builder.fptoui(address, ir.IntType(64)), ir.DoubleType().as_pointer())


def _called(builder, address, kind, arguments):
    entry = builder.inttoptr(builder.fptoui(address, ir.IntType(64)), kind.as_pointer())
    return builder.call(entry, arguments)


@intrinsic
def _call_numbers(typingctx, address, numbers, a, b, c):
    def codegen(context, builder, signature, arguments):
        return _called(builder, arguments[0], OF_NUMBERS, [_pointer(builder, arguments[1]), *arguments[2:]])

    return types.float64(*[types.float64] * 5), codegen


@intrinsic
def _call_slots(typingctx, address, numbers, slots):
    def codegen(context, builder, signature, arguments):
        return _called(builder, arguments[0], OF_SLOTS, [_pointer(builder, pointer) for pointer in arguments[1:]])

    return types.float64(*[types.float64] * 3), codegen


@intrinsic
def _read_slot(typingctx, slots, number):
    def codegen(context, builder, signature, arguments):
        return builder.load(builder.gep(_pointer(builder, arguments[0]), [arguments[1]]))

    return types.float64(types.float64, types.intp), codegen


@intrinsic
def _write_slots(typingctx, slots, values):
    def codegen(context, builder, signature, arguments):
        start = _pointer(builder, arguments[0])
        for number in range(len(signature.args[1])):
            value = builder.extract_value(arguments[1], number)
            builder.store(value, builder.gep(start, [context.get_constant(types.intp, number)]))
        return context.get_dummy_value()

    return types.none(types.float64, types.UniTuple(types.float64, len(values))), codegen


def _compiled_to(further, kind):
    @intrinsic
    def entry(typingctx, function, model, memory):
        kinds = (model, memory, types.CPointer(types.float64), *further)
        typingctx.resolve_function_type(function, kinds, {})
        compiled = function.dispatcher.overloads[kinds]

        def codegen(context, builder, signature, arguments):
            target = ir.Function(builder.module, kind, builder.module.get_unique_name("verb"))
            target.linkage = "internal"
            inside = ir.IRBuilder(target.append_basic_block())
            unused = [context.get_constant_null(one) for one in (model, memory)]
            function = context.declare_function(builder.module, compiled.fndesc)
            context.add_linking_libs((compiled.library,))
            _, result = context.call_conv.call_function(inside, function, types.float64, kinds, [*unused, *target.args])
            inside.ret(result)
            return builder.uitofp(builder.ptrtoint(target, ir.IntType(64)), REAL)

        return types.float64(function, model, memory), codegen

    return entry


call_at = small(lambda address, values, row, a, b, c: _call_at(address, values, row, a, b, c))
call_on = small(lambda address, values, row, slots: _call_on(address, values, row, slots))
leaves_of = small(lambda model: _leaves_of(model))
model_at = small(lambda model, numbers, offset: _model_at(model, numbers, offset))
lay_at = small(lambda model, numbers, offset: _lay_at(model, numbers, offset))
call_numbers = small(lambda address, numbers, a, b, c: _call_numbers(address, numbers, a, b, c))
call_slots = small(lambda address, numbers, slots: _call_slots(address, numbers, slots))
read_slot = small(lambda slots, place: _read_slot(slots, place))
write_slots = small(lambda slots, values: _write_slots(slots, values))
entry_of_numbers = _compiled_to((types.float64,) * 3, OF_NUMBERS)
entry_of_slots = _compiled_to((types.CPointer(types.float64),), OF_SLOTS)
