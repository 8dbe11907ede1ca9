"""Size of the dataset of a grid, counted from its variables, and memory that its scan takes."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from math import prod
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.ensemble.pair_job import FREE_RESPONSES, chunk_bytes
from pounding_risk.ensemble.threads import CHUNK_BYTES
from pounding_risk.ensemble.tolerance_check import check_variables
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import AXES, BLOCK_BYTES, bytes_per_case
from pounding_risk.scene.scene import Scene

RECORD_BYTES = 60 * 8  # of the spectrum of a record
WRITER_BYTES = 40e6  # about, of the libraries that write a dataset, which a plan does not load
CHUNKS_IN_FLIGHT = 2  # per thread: one being solved, one waiting to be kept


class Sizes(NamedTuple):
    """Bytes of the variables of a dataset, before compression; coordinates, some bytes a label, are not counted."""

    case: int  # of a case, with the variables of the tolerance check
    motion: int  # of a record, polarity and amplitude: its response without contact
    chunk: int  # of a case in a chunk
    record: int = RECORD_BYTES

    def of(self, shape: Mapping[str, int]) -> int:
        """Size of a dataset with so many values along each of its axes."""
        motions = shape["record"] * shape["polarity"] * shape["pga"]
        return self.case * prod(shape.values()) + self.motion * motions + self.record * shape["record"]


def sizes(study: Scene) -> Sizes:
    """Sizes of the dataset that `scan` makes of a study."""
    return _of_row(study) if study.is_row else _of_pair(study)


def grid_bytes(study: Scene, records: int) -> int:
    """Size of the dataset of a study with so many records."""
    grid = study.grid
    values = (records, len(study.records.polarities), *map(len, (grid.pgas, grid.contact_models)))
    return sizes(study).of(dict(zip(AXES, (*values, len(grid.gaps), len(grid.yield_forces)), strict=True)))


def _of_pair(study: Scene) -> Sizes:
    from pounding_risk.results.pair_labels import pair_variables
    from pounding_risk.solver.pair.outputs import BUILDING

    along = {"building": 2}
    case = bytes_per_case(pair_variables() | check_variables(study.rtol), along)
    closing = 8
    return Sizes(case, 8 * along["building"] * len(BUILDING) + closing, chunk_bytes(study))


def _of_row(study: Scene) -> Sizes:
    from pounding_risk.ensemble.row_grid import model_of
    from pounding_risk.results.row_labels import case_variables, row_variables
    from pounding_risk.solver.row.outputs import frame_of, moving_variables

    frame = frame_of(model_of(study))
    along = frame.sizes
    case = bytes_per_case(row_variables(frame) | check_variables(study.rtol), along)
    closing = 8 * (along["interface"] + along["contact_point"])
    return Sizes(case, bytes_per_case(case_variables(moving_variables(frame)), along) + closing, case)


def memory(study: Scene, shape: Mapping[str, int], threads: int, motions: Iterable[Motion], free: int) -> int:
    """About the memory that a scan into a file takes [bytes]; ``free`` is the size of a response without contact.

    The sum of what this process holds now, the records, the responses without contact that are kept, a block of the
    dataset as it is written, and the chunks that the threads work at.
    """
    kept = min(shape["record"] * shape["polarity"] * shape["pga"], FREE_RESPONSES)
    per_case, cases = sizes(study), prod(shape.values())
    chunk = min(CHUNK_BYTES, per_case.chunk * cases)
    # A block is in memory as chunks and as variables.
    block = min(BLOCK_BYTES, per_case.of(shape)) * (1.0 + per_case.chunk / per_case.case)
    records = sum(motion.acceleration.nbytes for motion in motions)
    return int(resident() + WRITER_BYTES + records + kept * free + block + CHUNKS_IN_FLIGHT * threads * chunk)


def resident() -> int:
    """Memory of this process [bytes]: now, its peak where the system tells no more, or 0 where it tells nothing."""
    try:
        with open("/proc/self/statm", encoding="ascii") as counts:
            return int(counts.read().split()[1]) * os.sysconf("SC_PAGESIZE")
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
