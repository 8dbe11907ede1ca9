"""Layout of the dataset of a scan: axes, variables, batches, and the blocks in which it is written.

A *batch* is the smallest piece of a grid that is solved: one record, polarity, amplitude, contact model and gap, with
all yield forces. Batches are numbered in the order of the axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.attributes import scene_dims

if TYPE_CHECKING:
    import xarray as xr

AXES = ("record", "polarity", PGA_AXIS, "contact_model", "gap", "yield_force")
AMPLITUDE = AXES.index(PGA_AXIS)  # the place of the amplitudes, whose axis is `LEVEL_AXIS` where they are no PGA
BLOCK_BYTES = 16e6  # of all variables of a block together: what writing keeps in memory


def axes_by(amplitudes: str) -> tuple[str, ...]:
    """The axes of the cases with the axis of the amplitudes, `PGA_AXIS` or `LEVEL_AXIS`."""
    return (*AXES[:AMPLITUDE], amplitudes, *AXES[AMPLITUDE + 1 :])


def amplitude_axis(dataset: xr.Dataset) -> str:
    """The name that the axis of amplitudes has in a dataset, whether or not it has such an axis."""
    return LEVEL_AXIS if LEVEL_AXIS in dataset.variables else PGA_AXIS


def axes_of_cases(dataset: xr.Dataset) -> tuple[str, ...]:
    """The axes of the cases of a dataset, in order."""
    return axes_by(amplitude_axis(dataset))


def dims_in(dataset: xr.Dataset, dims: Iterable[str]) -> tuple[str, ...]:
    """Dimensions in terms of `AXES`, as a dataset calls them."""
    return tuple(amplitude_axis(dataset) if dim == PGA_AXIS else dim for dim in dims)


class CaseVariable(NamedTuple):
    """A variable of the cases of a scan."""

    dims: tuple[str, ...]  # besides those of the cases
    dtype: np.dtype[Any]
    attrs: Mapping[str, Any]


def bytes_per_case(variables: Mapping[str, CaseVariable], sizes: Mapping[Any, int]) -> int:
    """Size of a case with these variables, before compression; ``sizes`` are those of their own dimensions."""
    return sum(variable.dtype.itemsize * prod(sizes[dim] for dim in variable.dims) for variable in variables.values())


class Template(NamedTuple):
    """A dataset without the values of its cases: dimensions, coordinates, attributes and variables."""

    skeleton: xr.Dataset  # coordinates, attributes, and every variable that does not depend on cases
    cases: Mapping[str, CaseVariable]
    shape: tuple[int, ...]  # along `axes`; an axis that the dataset does not have counts one
    of_scene: tuple[str, ...] = ()  # axes of other numbers of the scene

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes of the cases: those of other numbers of the scene, then the grid's."""
        return (*self.of_scene, *axes_of_cases(self.skeleton))

    @property
    def batches(self) -> int:
        """Number of batches of the grid."""
        return prod(self.shape[:-1])

    @property
    def width(self) -> int:
        """Number of cases in a batch: yield forces of the grid."""
        return self.shape[-1]

    @property
    def dims(self) -> tuple[str, ...]:
        """The axes that the dataset has: a scan of one amplitude has no axis ``pga``."""
        return tuple(axis for axis in self.axes if axis in self.skeleton.sizes)

    def extra(self, name: str) -> tuple[int, ...]:
        """Sizes of a case variable along its own dimensions."""
        return tuple(self.skeleton.sizes[dim] for dim in self.cases[name].dims)

    @property
    def bytes_per_case(self) -> int:
        """Size of all variables of a case, before compression."""
        return bytes_per_case(self.cases, self.skeleton.sizes)


def block_shape(template: Template) -> tuple[int, ...]:
    """Sizes along the axes of the blocks in which a dataset is written: whole trailing axes, and a part of one before.

    They follow from the template alone, so that the bytes of a file do not depend on the chunks of the scan.
    """
    batch_limit = max(1, int(BLOCK_BYTES // max(1, template.bytes_per_case * template.width)))  # batches
    shape = [1] * len(template.shape)
    shape[-1] = template.width
    for axis in reversed(range(len(template.shape) - 1)):
        shape[axis] = min(template.shape[axis], batch_limit)
        if shape[axis] < template.shape[axis]:
            break
        batch_limit //= shape[axis]
    return tuple(shape)


def blocks(template: Template) -> Iterator[range]:
    """The batches of each block, in order."""
    sizes = block_shape(template)[:-1]
    split_axis = next((axis for axis, size in enumerate(sizes) if size > 1), len(sizes) - 1)
    batches_below = prod(template.shape[split_axis + 1 : -1])
    run = template.shape[split_axis] * batches_below  # batches of one index of the axes before
    for first in range(0, template.batches, run):
        for start in range(first, first + run, sizes[split_axis] * batches_below):
            yield range(start, min(start + sizes[split_axis] * batches_below, first + run))


class Slab(NamedTuple):
    """Successive batches of one motion and one contact model."""

    motion: tuple[int, ...]  # record, polarity, amplitude
    law: int
    gaps: slice
    batches: slice  # among the batches that were asked for


def slabs(batches: range, shape: tuple[int, ...], most: int) -> Iterator[Slab]:
    """The batches in slabs of ``most`` at most, in order; ``shape`` is a template's."""
    gaps = shape[-2]
    start = batches.start
    while start < batches.stop:
        *motion, law, gap = (int(place) for place in np.unravel_index(start, shape[:-1]))
        count = min(most, gaps - gap, batches.stop - start)
        first = start - batches.start
        yield Slab(tuple(motion), law, slice(gap, gap + count), slice(first, first + count))
        start += count


def place(template: Template, block: range) -> dict[str, slice]:
    """Where a block of `blocks` lies along `Template.dims`."""
    starts = np.unravel_index(block.start, template.shape[:-1]) if template.batches else ()
    sizes = block_shape(template)
    slices = {AXES[-1]: slice(0, template.width)}
    for axis, start, size, length in zip(template.axes, starts, sizes, template.shape, strict=False):
        slices[axis] = slice(int(start), min(int(start) + size, length))
    return {axis: slices[axis] for axis in template.dims}


def template_of(dataset: xr.Dataset) -> Template:
    """The template of an existing dataset; the values of its cases are not read.

    A dataset without the axes of a scan has no case variables: all of it is the skeleton.
    """
    of_scene = scene_dims(dataset)
    axes = (*of_scene, *axes_of_cases(dataset))
    dims, variables = tuple(axis for axis in axes if axis in dataset.sizes), dataset.variables
    cases = {
        str(name): CaseVariable(
            tuple(map(str, variable.dims[len(dims) :])), variable.dtype.newbyteorder("="), dict(variable.attrs)
        )
        for name, variable in ((name, variables[name]) for name in dataset.data_vars)
        if dims and variable.dims[: len(dims)] == dims and variable.dtype.kind in "if"
    }
    shape = tuple(dataset.sizes.get(axis, 1) for axis in axes)
    return Template(dataset.drop_vars(cases).load(), cases, shape, of_scene)


def values_at(dataset: xr.Dataset, template: Template, block: range, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Case variables of a dataset in a block of its template: (batches, cases in a batch, extra sizes)."""
    slices = place(template, block)
    return {
        name: dataset.variables[name].isel(slices).values.reshape(len(block), template.width, *template.extra(name))
        for name in names
    }


def streamed(dataset: xr.Dataset, names: Iterable[str]) -> Iterator[dict[str, np.ndarray]]:
    """Values of variables of equal dimensions, piece by piece: of case variables by block, of others at once."""
    template, wanted_names = template_of(dataset), list(names)
    if set(wanted_names) <= set(template.cases):
        for block in blocks(template):
            yield values_at(dataset, template, block, wanted_names)
    else:
        yield {name: dataset[name].values for name in wanted_names}
