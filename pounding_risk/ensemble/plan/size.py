"""Size of the dataset of a grid, counted from its variables, and memory that its scan takes."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from math import prod
from typing import Any

import numpy as np

from pounding_risk.ensemble.grid_job import Sizes
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.limits import own_memory
from pounding_risk.ensemble.threads import CHUNK_BYTES
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import AMPLITUDE, BLOCK_BYTES, axes_by
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import SAMPLE

WRITER_BYTES = 40e6  # about, of the libraries that write a dataset, which a plan does not load
CHUNKS_IN_FLIGHT = 2  # per thread: one being solved, one waiting to be kept


def sizes(study: Scene) -> Sizes:
    """Sizes of the dataset that `scan` makes of a study."""
    return job_kind(study).sizes(study)


def shape_of(study: Scene, records: int) -> dict[str, int]:
    """Number of values along each dimension of the dataset, by its name, in order; 1 of what is no dimension.

    Where each sample has a motion that is drawn with it there is one record and one polarity.
    """
    grid = study.grid
    motions = (1, 1) if is_drawn(study) else (records, len(study.records.polarities))
    lengths = (*motions, *map(len, (grid.amplitudes, grid.contact_models)))
    grid_lengths = dict(
        zip(axes_by(grid.measure.axis), (*lengths, len(grid.gaps), len(grid.yield_forces)), strict=True)
    )
    return {axis.name: axis.size for axis in study.axes} | grid_lengths


def is_drawn(study: Scene) -> bool:
    """True where each sample of a scene has one motion, which is drawn with it."""
    return study.uncertain is not None and study.uncertain.is_drawn


def grid_bytes(study: Scene, records: int) -> int:
    """Size of the dataset of a study with so many records."""
    return sizes(study).of(shape_of(study, records))


def memory(study: Scene, shape: Mapping[str, int], threads: int, motions: Iterable[Motion], free: int) -> int:
    """About the memory that a scan into a file takes [bytes]; ``free`` is the size of a response without contact.

    The sum of what this process holds now, the records, the responses without contact that are kept, a block of the
    dataset as it is written, and the chunks that the threads work at.
    """
    motions_axes = axes_by(study.grid.measure.axis)[: AMPLITUDE + 1]
    # Where a motion is drawn with each sample, so many are driven one after the other.
    responses = prod(shape[axis] for axis in motions_axes) * (shape[SAMPLE] if is_drawn(study) else 1)
    caches = job_kind(study).held_bytes(responses, free)
    per_case, cases = sizes(study), prod(shape.values())
    chunk = min(CHUNK_BYTES, per_case.chunk * cases)
    # A block is in memory as chunks and as variables.
    block = min(BLOCK_BYTES, per_case.of(shape)) * (1.0 + per_case.chunk / per_case.case)
    records = sum(motion.acceleration.nbytes for motion in motions)
    return int(resident() + WRITER_BYTES + records + caches + block + CHUNKS_IN_FLIGHT * threads * chunk)


def resident() -> int:
    """Memory of this process [bytes]: now, its peak where the system reports no more, or 0 where it reports nothing."""
    try:
        return own_memory(1)
    except OSError:
        pass
    try:
        import resource
    except ImportError:
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def bytes_of(arrays: Any) -> int:
    """Size of all arrays in nested tuples."""
    if isinstance(arrays, np.ndarray):
        return int(arrays.nbytes)
    return sum(map(bytes_of, arrays)) if isinstance(arrays, tuple) else 0
