"""How large the dataset of a grid is, counted from its variables, and how much memory its scan takes."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.ensemble.pair_job import FREE_RESPONSES, chunk_bytes
from pounding_risk.ensemble.threads import CHUNK_BYTES
from pounding_risk.ensemble.tolerance_check import check_variables
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import AXES, BLOCK_BYTES, bytes_per_case
from pounding_risk.scene.scene import Study

if TYPE_CHECKING:
    from pounding_risk.ensemble.plan.numbers import PlanNumbers

READ_FOR = 60 * 8  # bytes a record: its spectrum
WRITER = 40e6  # bytes, about, of the libraries that write a dataset, which a plan has no need of
CHUNKS_IN_FLIGHT = 2  # a thread: one that it fills, one that waits to be kept


class Sizes(NamedTuple):
    """Bytes of the variables of a dataset, before compression; coordinates, some bytes a label, are not counted."""

    case: int  # with those that tell what was made again
    motion: int  # a record, polarity and amplitude: what is known without contact
    part: int  # a case of a part, which is kept on the way
    record: int = READ_FOR

    def of(self, shape: Mapping[str, int]) -> int:
        """Of a dataset with so many values along each of its axes."""
        motions = shape["record"] * shape["polarity"] * shape["pga"]
        return self.case * prod(shape.values()) + self.motion * motions + self.record * shape["record"]


def sizes(study: Study) -> Sizes:
    """Of the dataset that `scan` makes of a study."""
    return _of_row(study) if study.is_row else _of_pair(study)


def grid_bytes(study: Study, records: int) -> int:
    """Of the dataset of a study with so many records."""
    grid = study.grid
    values = (records, len(study.records.polarities), *map(len, (grid.pgas, grid.contact_models)))
    return sizes(study).of(dict(zip(AXES, (*values, len(grid.gaps), len(grid.yield_forces)), strict=True)))


def _of_pair(study: Study) -> Sizes:
    from pounding_risk.results.pair_labels import pair_variables
    from pounding_risk.solver.pair.outputs import BUILDING

    along = {"building": 2}
    case = bytes_per_case(pair_variables() | check_variables(study.rtol), along)
    closing = 8
    return Sizes(case, 8 * along["building"] * len(BUILDING) + closing, chunk_bytes(study))


def _of_row(study: Study) -> Sizes:
    from pounding_risk.ensemble.row_grid import model_of
    from pounding_risk.results.row_labels import case_variables, row_variables
    from pounding_risk.solver.row.outputs import frame_of, moving_variables

    frame = frame_of(model_of(study))
    along = frame.sizes
    case = bytes_per_case(row_variables(frame) | check_variables(study.rtol), along)
    closing = 8 * (along["interface"] + along["contact_point"])
    return Sizes(case, bytes_per_case(case_variables(moving_variables(frame)), along) + closing, case)


def memory(plan: PlanNumbers, motions: Iterable[Motion], free: int) -> int:
    """About the memory that a scan into a file takes [bytes]; ``free`` is that of a response without contact.

    What this process holds now, the records, the responses that are kept, a block of the dataset as it is written, and
    the parts that the threads are at.
    """
    shape = plan.shape
    kept = min(shape["record"] * shape["polarity"] * shape["pga"], FREE_RESPONSES)
    a_case = sizes(plan.study)
    part = min(CHUNK_BYTES, a_case.part * plan.cases)
    # A block stands there as parts and as variables.
    block = min(BLOCK_BYTES, plan.bytes) * (1.0 + a_case.part / a_case.case)
    records = sum(motion.acceleration.nbytes for motion in motions)
    return int(resident() + WRITER + records + kept * free + block + CHUNKS_IN_FLIGHT * plan.threads * part)


def resident() -> int:
    """Memory of this process now; its largest so far where a system tells no more, 0 where it tells nothing [bytes]."""
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
    """Of all arrays in nested tuples."""
    if isinstance(arrays, np.ndarray):
        return int(arrays.nbytes)
    return sum(map(bytes_of, arrays)) if isinstance(arrays, tuple) else 0
