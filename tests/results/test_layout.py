"""The blocks of a dataset: every batch once, in order, each a box of the axes, and none too big for memory."""

from __future__ import annotations

from math import prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_forms import SHAPE, made_template, values_of

from pounding_risk.results import layout
from pounding_risk.results.layout import AXES, block_shape, blocks, place, template_of, values_at
from pounding_risk.results.store import Memory

shapes = st.tuples(*[st.integers(1, 7)] * 5, st.integers(1, 4))


@settings(max_examples=20)
@given(shapes, st.integers(1, 40_000))
def test_blocks_cover_every_line_once_as_boxes_as_large_as_they_may_be(shape, most):
    template = made_template(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", most)
        found, sizes = list(blocks(template)), block_shape(template)
        boxes = [place(template, block) for block in found]
    assert [batch for block in found for batch in block] == list(range(template.batches))
    assert sizes[-1] == template.width, "a batch is never broken"
    numbers = np.arange(template.batches).reshape([template.skeleton.sizes.get(axis, 1) for axis in AXES[:-1]])
    for block, box in zip(found, boxes, strict=True):
        assert tuple(box) == template.dims
        where = tuple(box.get(axis, slice(None)) for axis in AXES[:-1])
        assert numbers[where].ravel().tolist() == list(block)
    bytes_per_batch = template.bytes_per_case * template.width
    assert max(map(len, found)) * bytes_per_batch <= max(most, bytes_per_batch)
    # Chunks of a file have one shape: only the last along an axis may be cut off.
    assert all(
        box[axis].start % size == 0 for box in boxes for axis, size in zip(AXES, sizes, strict=True) if axis in box
    )
    # A larger block would be another box: the next axis out is not begun while one within is broken.
    broken = [axis for axis in range(5) if sizes[axis] < shape[axis]]
    if broken:
        inner = broken[-1]
        assert all(size == 1 for size in sizes[:inner])
        assert (sizes[inner] + 1) * prod(sizes[inner + 1 :]) * template.bytes_per_case > most


def test_the_form_of_a_dataset_is_the_form_it_was_made_of():
    template = made_template()
    memory = Memory(template)
    memory.write(range(template.batches), values_of(template, range(template.batches)))
    memory.finish({})
    found = template_of(memory.dataset())
    assert found.skeleton.identical(template.skeleton)
    assert (found.shape, found.dims, found.bytes_per_case) == (SHAPE, template.dims, template.bytes_per_case)
    assert {name: (each.dims, each.dtype) for name, each in found.cases.items()} == {
        name: (each.dims, each.dtype) for name, each in template.cases.items()
    }
    block = list(blocks(template))[-1]
    for name, values in values_at(memory.dataset(), found, block, template.cases).items():
        np.testing.assert_array_equal(values, values_of(template, block)[name])


def test_a_dataset_without_cases_is_all_skeleton():
    skeleton = made_template().skeleton.drop_dims(["gap", "contact_model", "yield_force", "polarity"])
    template = template_of(skeleton.isel(record=0, drop=True))
    assert (template.batches, template.width, dict(template.cases)) == (1, 1, {})
    assert list(blocks(template)) == [range(1)]
