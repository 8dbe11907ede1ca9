"""Calls by address, and models whose numbers stand at one, as numba and LLVM write them: see `_jit/calls.py`."""

from __future__ import annotations

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

REAL = ir.DoubleType()
OF_NUMBERS = ir.FunctionType(REAL, [REAL.as_pointer(), REAL, REAL, REAL])
OF_SLOTS = ir.FunctionType(REAL, [REAL.as_pointer(), REAL.as_pointer()])


def _leaves(kind) -> int:
    """How many numbers a model of this numba type holds."""
    return sum(map(_leaves, kind.types)) if isinstance(kind, types.BaseTuple) else 1


def _row_of(context, builder, signature, arguments):
    """Address of row ``arguments[2]`` of the C-contiguous array ``arguments[1]`` of two dimensions."""
    table = make_array(signature.args[1])(context, builder, arguments[1])
    width = cgutils.unpack_tuple(builder, table.shape)[1]
    return builder.gep(table.data, [builder.mul(arguments[2], width)])


def _pointer(builder, address):
    return builder.inttoptr(builder.fptoui(address, ir.IntType(64)), REAL.as_pointer())


def _called(builder, address, kind, arguments):
    entry = builder.inttoptr(builder.fptoui(address, ir.IntType(64)), kind.as_pointer())
    return builder.call(entry, arguments)


@intrinsic
def call_at(typingctx, address, values, row, a, b, c):
    def codegen(context, builder, signature, arguments):
        row = _row_of(context, builder, signature, arguments)
        return _called(builder, arguments[0], OF_NUMBERS, [row, *arguments[3:]])

    real = types.float64
    return real(real, values, types.intp, real, real, real), codegen


@intrinsic
def call_on(typingctx, address, values, row, slots):
    def codegen(context, builder, signature, arguments):
        row = _row_of(context, builder, signature, arguments)
        data = make_array(signature.args[3])(context, builder, arguments[3]).data
        return _called(builder, arguments[0], OF_SLOTS, [row, data])

    real = types.float64
    return real(real, values, types.intp, slots), codegen


@intrinsic
def leaves_of(typingctx, model):
    count = _leaves(model)
    return types.intp(model), lambda context, builder, signature, arguments: context.get_constant(types.intp, count)


@intrinsic
def model_at(typingctx, model, numbers, offset):
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
def lay_at(typingctx, model, numbers, offset):
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


@intrinsic
def call_numbers(typingctx, address, numbers, a, b, c):
    def codegen(context, builder, signature, arguments):
        return _called(builder, arguments[0], OF_NUMBERS, [_pointer(builder, arguments[1]), *arguments[2:]])

    return types.float64(*[types.float64] * 5), codegen


@intrinsic
def call_slots(typingctx, address, numbers, slots):
    def codegen(context, builder, signature, arguments):
        return _called(builder, arguments[0], OF_SLOTS, [_pointer(builder, pointer) for pointer in arguments[1:]])

    return types.float64(*[types.float64] * 3), codegen


@intrinsic
def read_slot(typingctx, slots, number):
    def codegen(context, builder, signature, arguments):
        return builder.load(builder.gep(_pointer(builder, arguments[0]), [arguments[1]]))

    return types.float64(types.float64, types.intp), codegen


@intrinsic
def write_slots(typingctx, slots, values):
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


entry_of_numbers = _compiled_to((types.float64,) * 3, OF_NUMBERS)
entry_of_slots = _compiled_to((types.CPointer(types.float64),), OF_SLOTS)
