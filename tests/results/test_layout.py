"""The blocks of a dataset: every line once, in order, each a box of the axes, and none too big for memory."""

from __future__ import annotations

from math import prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_forms import SHAPE, made_form, values_of

from pounding_risk.results import layout
from pounding_risk.results.layout import AXES, block_shape, blocks, form_of, place, values_at
from pounding_risk.results.store import Memory

shapes = st.tuples(*[st.integers(1, 7)] * 5, st.integers(1, 4))


@settings(max_examples=30)
@given(shapes, st.integers(1, 40_000))
def test_blocks_cover_every_line_once_as_boxes(shape, most):
    form = made_form(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", most)
        found, sizes = list(blocks(form)), block_shape(form)
        boxes = [place(form, block) for block in found]
    assert [line for block in found for line in block] == list(range(form.lines))
    assert sizes[-1] == form.width, "a line is never broken"
    numbers = np.arange(form.lines).reshape([form.skeleton.sizes.get(axis, 1) for axis in AXES[:-1]])
    for block, box in zip(found, boxes, strict=True):
        assert tuple(box) == form.dims
        where = tuple(box.get(axis, slice(None)) for axis in AXES[:-1])
        assert numbers[where].ravel().tolist() == list(block)
    bytes_a_line = form.bytes_a_case * form.width
    assert max(map(len, found)) * bytes_a_line <= max(most, bytes_a_line)
    # Chunks of a file have one shape: only the last along an axis may be cut off.
    assert all(
        box[axis].start % size == 0 for box in boxes for axis, size in zip(AXES, sizes, strict=True) if axis in box
    )


@settings(max_examples=30)
@given(shapes, st.integers(1, 40_000))
def test_blocks_are_as_large_as_they_may_be(shape, most):
    """A larger block would be another box: the next axis out is not begun while one within is broken."""
    form = made_form(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", most)
        sizes = block_shape(form)
    broken = [axis for axis in range(5) if sizes[axis] < shape[axis]]
    if broken:
        inner = broken[-1]
        assert all(size == 1 for size in sizes[:inner])
        grown = (sizes[inner] + 1) * prod(sizes[inner + 1 :])
        assert grown * form.bytes_a_case > most


def test_the_form_of_a_dataset_is_the_form_it_was_made_of():
    form = made_form()
    memory = Memory(form)
    memory.write(range(form.lines), values_of(form, range(form.lines)))
    memory.finish({})
    found = form_of(memory.dataset())
    assert found.skeleton.identical(form.skeleton)
    assert (found.shape, found.dims, found.bytes_a_case) == (SHAPE, form.dims, form.bytes_a_case)
    assert {name: (each.dims, each.dtype) for name, each in found.cases.items()} == {
        name: (each.dims, each.dtype) for name, each in form.cases.items()
    }
    block = list(blocks(form))[-1]
    for name, values in values_at(memory.dataset(), found, block, form.cases).items():
        np.testing.assert_array_equal(values, values_of(form, block)[name])


def test_a_dataset_without_cases_is_all_skeleton():
    skeleton = made_form().skeleton.drop_dims(["gap", "contact_model", "yield_force", "polarity"])
    form = form_of(skeleton.isel(record=0, drop=True))
    assert (form.lines, form.width, dict(form.cases)) == (1, 1, {})
    assert list(blocks(form)) == [range(1)]
