"""Named tuples that kernels take by address, and arrays that kernels make."""

from typing import NamedTuple

import numba
import numpy as np
import pytest
from processes import compiled

from pounding_risk._jit.compile import kernel, small
from pounding_risk._jit.lowering.by_address import AddressedType
from pounding_risk._jit.memory import by_address, new_record, new_records, record_type, zeros

Part = record_type(values=(2, 3), total=float)


class Rule(NamedTuple):
    """A model inside a bundle."""

    scale: float
    offset: float


class Bundle(NamedTuple):
    """One field of every kind that can be passed by address."""

    table: np.ndarray  # (rows, columns)
    places: np.ndarray  # (n,) of integers
    cube: np.ndarray  # (a, b, c)
    parts: np.ndarray  # (k,) records
    desk: np.record
    rule: Rule
    factor: float


def bundle() -> Bundle:
    return Bundle(
        np.arange(12.0).reshape(3, 4),
        np.array([2, 0, 1]),
        np.arange(24.0).reshape(2, 3, 4),
        new_records(Part, 2),
        new_record(Part),
        Rule(3.0, 0.5),
        7.0,
    )


@small
def corner(given, i):
    """An element that a helper reads: the bundle is handed on."""
    return given.table[given.places[i], 3] + given.cube[1, 2, i]


@kernel
def work_on(given):
    """Read every field, write to three of them; a sum of what was read."""
    total = given.rule.scale * given.factor + given.rule.offset
    for i in range(given.places.shape[0]):
        total += corner(given, i)
    for row in range(given.table.shape[0]):
        for column in range(given.table.shape[1]):
            given.table[row, column] += 1.0
    for k in range(len(given.parts)):
        given.parts[k].values[1, 2] += total
        given.parts[k].total = float(k + 1)
    given.desk.total = total
    return total


def expected(given: Bundle) -> float:
    """The sum by numpy alone."""
    return 3.0 * 7.0 + 0.5 + given.table[given.places, 3].sum() + given.cube[1, 2, :3].sum()


def test_a_kernel_reads_and_writes_what_it_is_lent():
    given = bundle()
    wanted, before = expected(given), given.table.copy()
    assert work_on(by_address(given)) == wanted
    assert np.array_equal(given.table, before + 1.0)
    assert [part.total for part in given.parts] == [1.0, 2.0]
    assert [part.values[1, 2] for part in given.parts] == [wanted, wanted]
    assert given.desk.total == wanted


def test_fields_are_read_through_what_is_lent():
    given = bundle()
    assert by_address(given).table is given.table and by_address(given).rule == given.rule


@compiled
def test_lengths_are_those_of_each_array():
    """One compiled form serves bundles of all sizes."""
    given = bundle()
    work_on(by_address(given))
    forms = len(work_on.signatures)
    longer = given._replace(table=np.ones((5, 4)), places=np.array([4, 3, 2, 1]), cube=np.ones((2, 3, 9)))
    assert work_on(by_address(longer)) == 21.5 + 4 * 2.0
    assert np.array_equal(longer.table, np.full((5, 4), 2.0)) and len(work_on.signatures) == forms


@compiled
def test_a_bundle_is_one_pointer():
    """The reason for it: numba hands a tuple over number by number."""
    from llvmlite import ir
    from numba.core.registry import cpu_target

    kind = numba.typeof(by_address(bundle()))
    assert isinstance(kind, AddressedType)
    assert isinstance(cpu_target.target_context.get_value_type(kind), ir.PointerType)
    assert len(kind.mangling_args[0]) < 30


@compiled
def test_an_array_with_gaps_cannot_be_lent():
    given = bundle()
    with pytest.raises(ValueError, match="not C-contiguous"):
        by_address(given._replace(table=given.table.T))


@compiled
def test_a_field_that_is_none_is_told():
    @kernel
    def ask(given):
        return given.height

    with pytest.raises(numba.TypingError, match="height"):
        ask(by_address(bundle()))


@kernel
def fill(rows, columns):
    """A table that a kernel makes, and a count of places in one of integers."""
    made = zeros((rows, columns), np.float64)
    count = zeros((columns,), np.int64)
    flags = zeros((columns,), np.bool_)
    for row in range(rows):
        for column in range(columns):
            made[row, column] += row + 0.5
            count[column] += 1
            flags[column] = not flags[column]
    return made, count, flags


def test_arrays_that_kernels_make_begin_at_zero():
    for _ in range(3):  # memory that was used before is zero too
        made, count, flags = fill(3, 4)
        assert np.array_equal(made, np.repeat([[0.5], [1.5], [2.5]], 4, axis=1))
        assert np.array_equal(count, [3] * 4) and count.dtype == np.int64
        assert flags.all() and flags.dtype == np.bool_
