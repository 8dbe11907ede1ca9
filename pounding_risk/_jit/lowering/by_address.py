"""Named tuples of arrays that compiled functions take by address, as numba sees them: see `_jit/memory.py`."""

from __future__ import annotations

import hashlib
import operator
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, lower_builtin, lower_getattr_generic, register_model, unbox
from numba.np.arrayobj import (
    getitem_array_tuple,
    getitem_arraynd_intp,
    load_item,
    make_array,
    populate_array,
    setitem_array,
    store_item,
)


class AddressedArray(types.Array):
    """Type of an array of a tuple passed by address: its indices are not below zero."""

    def __init__(self, array_type):
        super().__init__(array_type.dtype, array_type.ndim, array_type.layout, readonly=not array_type.mutable)


class AddressedType(types.Type):
    """Type of a named tuple that is taken by address; ``tuple_type`` is the tuple's own."""

    def __init__(self, tuple_type):
        self.tuple_type = tuple_type
        self.kinds = tuple(map(_kind_by_address, tuple_type.types))
        super().__init__(f"by address {tuple_type.name}")

    @property
    def mangling_args(self):
        """A short name in the symbols of compiled functions."""
        return "addressed" + hashlib.sha256(self.name.encode()).hexdigest()[:16], ()

    def field(self, name):
        """(number of the table's entries before a field, the field's type)."""
        entry = 0
        for field, kind in zip(self.tuple_type.fields, self.kinds, strict=True):
            if field == name:
                return entry, kind
            entry += _entries(kind)
        return None


def _kind_by_address(kind):
    """Type of a field in a tuple passed by address: arrays, also those in named tuples, are `AddressedArray`."""
    if isinstance(kind, types.Array):
        return AddressedArray(kind)
    if isinstance(kind, types.BaseNamedTuple):
        inner = tuple(map(_kind_by_address, kind.types))
        return kind if inner == tuple(kind.types) else types.NamedTuple(inner, kind.instance_class)
    return kind


def _entries(kind) -> int:
    """How many entries of the table a field of this type takes."""
    if isinstance(kind, types.BaseTuple):
        return sum(map(_entries, kind.types))
    return 1 + kind.ndim if isinstance(kind, types.Array) else 1


_TYPES: dict[Any, tuple[AddressedType, Any]] = {}  # by `_form`, with the dtypes whose ids are in it


def _form(value):
    """What decides about the type of a field; numba takes a millisecond to find that of a record."""
    if isinstance(value, tuple):
        return type(value), *map(_form, value)
    if isinstance(value, np.ndarray):
        return id(value.dtype), value.ndim, value.flags.writeable
    return id(value.dtype) if isinstance(value, np.void) else type(value)


def _type_of(model) -> AddressedType:
    """The type of a named tuple that is passed by address."""
    form = _form(model)
    if form not in _TYPES:
        dtypes = [value.dtype for value in model if hasattr(value, "dtype")]
        _TYPES[form] = AddressedType(numba.typeof(model)), dtypes
    return _TYPES[form][0]


class ByAddress:
    """A named tuple with the table of its addresses; the tuple's fields can be read as its own."""

    def __init__(self, model):
        self._model = model
        self._numba_type_ = _type_of(model)
        self._table = np.array([entry for value in model for entry in _entries_of(value)], dtype=np.int64)
        self._address = self._table.ctypes.data

    def __getattr__(self, name):
        return getattr(self._model, name)


def _entries_of(value) -> list[int]:
    """The table's entries of one field: its address and lengths, or its numbers."""
    if isinstance(value, tuple):
        return [entry for inner in value for entry in _entries_of(inner)]
    if isinstance(value, np.ndarray):
        if not value.flags.c_contiguous:
            raise ValueError(f"an array of shape {value.shape} is not C-contiguous and cannot be passed by address")
        return [value.ctypes.data, *value.shape]
    if isinstance(value, np.void):
        return [_address_of_record(value)]
    return [int(value)] if isinstance(value, int) else [int(np.float64(value).view(np.int64))]


def _address_of_record(record: np.void) -> int:
    """Address of a record; most are the only one of an array, whose address is read in a tenth of the time."""
    array: Any = record.base  # which numpy declares to be None
    if isinstance(array, np.ndarray) and array.size == 1:
        return array.ctypes.data
    return record.__array_interface__["data"][0]


@register_model(AddressedType)
class _AddressedModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.IntType(64).as_pointer())


@register_model(AddressedArray)
class _AddressedArrayModel(models.ArrayModel):
    pass


@infer_getattr
class _AddressedFields(AttributeTemplate):
    key = AddressedType

    def generic_resolve(self, kind, name):
        entry = kind.field(name)
        return None if entry is None else entry[1]


@unbox(AddressedType)
def _unbox_address(kind, addressed, c):
    number = c.pyapi.object_getattr_string(addressed, "_address")
    address = c.pyapi.number_as_ssize_t(number)
    c.pyapi.decref(number)
    pointer = c.builder.inttoptr(address, c.context.get_value_type(kind))
    return NativeValue(pointer, is_error=cgutils.is_not_null(c.builder, c.pyapi.err_occurred()))


@lower_getattr_generic(AddressedType)
def _read_field(context, builder, kind, pointer, name):
    first_entry, field = kind.field(name)

    def entry(number):
        loaded = builder.load(builder.gep(pointer, [context.get_constant(types.intp, number)]))
        # The table does not change during the call: what has been read need not be read again.
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
        return loaded

    def read(part, first):
        value_type = context.get_value_type(part)
        if isinstance(part, types.BaseTuple):
            values = []
            for inner in part.types:
                values.append(read(inner, first))
                first += _entries(inner)
            return context.make_tuple(builder, part, values)
        if isinstance(part, types.Array):
            return _array(context, builder, part, [entry(first + number) for number in range(1 + part.ndim)])
        if isinstance(part, types.Record):
            return builder.inttoptr(entry(first), value_type)
        return builder.bitcast(entry(first), value_type)

    return read(field, first_entry)


def _array(context, builder, kind, entries):
    """An array of the caller's, its references not counted, from its address and lengths."""
    view = make_array(kind)(context, builder)
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    shape, strides = entries[1:], [context.get_constant(types.intp, size)]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    populate_array(
        view,
        data=builder.inttoptr(entries[0], view.data.type),
        shape=shape,
        strides=strides,
        itemsize=context.get_constant(types.intp, size),
        meminfo=None,
    )
    return view._getvalue()


def _item(context, builder, kind, array, index_types, indices):
    """Pointer to the element of an array at so many indices, none below zero."""
    view = make_array(kind)(context, builder, array)
    offset = context.get_constant(types.intp, 0)
    lengths = cgutils.unpack_tuple(builder, view.shape)
    for length, index_type, index in zip(lengths, index_types, indices, strict=True):
        position = context.cast(builder, index, index_type, types.intp)
        offset = builder.add(builder.mul(offset, length), position)
    return builder.gep(view.data, [offset])


def _are_integers(index_types) -> bool:
    return all(isinstance(kind, types.Integer) for kind in index_types)


@lower_builtin(operator.getitem, AddressedArray, types.Integer)
def _get_at(context, builder, signature, arguments):
    kind, index_type = signature.args
    if kind.ndim != 1:
        return getitem_arraynd_intp(context, builder, signature, arguments)
    return load_item(context, builder, kind, _item(context, builder, kind, arguments[0], [index_type], [arguments[1]]))


@lower_builtin(operator.getitem, AddressedArray, types.BaseTuple)
def _get_at_tuple(context, builder, signature, arguments):
    kind, index_types = signature.args[0], tuple(signature.args[1])
    if len(index_types) != kind.ndim or not _are_integers(index_types):
        return getitem_array_tuple(context, builder, signature, arguments)
    indices = cgutils.unpack_tuple(builder, arguments[1], count=kind.ndim)
    return load_item(context, builder, kind, _item(context, builder, kind, arguments[0], index_types, indices))


@lower_builtin(operator.setitem, AddressedArray, types.Any, types.Any)
def _set_at(context, builder, signature, arguments):
    kind, index_type, value_type = signature.args
    index_types, indices = (index_type,), [arguments[1]]
    if isinstance(index_type, types.BaseTuple):
        index_types, indices = tuple(index_type), cgutils.unpack_tuple(builder, arguments[1], count=len(index_type))
    if len(index_types) != kind.ndim or not _are_integers(index_types):
        return setitem_array(context, builder, signature, arguments)
    value = context.cast(builder, arguments[2], value_type, kind.dtype)
    store_item(context, builder, kind, value, _item(context, builder, kind, arguments[0], index_types, indices))
    return context.get_dummy_value()
