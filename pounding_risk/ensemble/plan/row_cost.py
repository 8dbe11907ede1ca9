"""What a run of a row costs: processor time of whole runs of some cases of a scene's grid."""

from __future__ import annotations

from time import process_time
from typing import NamedTuple

import numpy as np

from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.row_job import RowJob
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Study
from pounding_risk.solver.row.cases import Cases, Limits


class RowBench(NamedTuple):
    """Cases of a row's grid, thinned evenly."""

    cases: tuple[tuple[Cases, Limits], ...]

    def seconds(self) -> float:
        """Processor time of one run, all buildings solved at once; the motion without contact is known before."""
        start = process_time()
        for cases, limits in self.cases:
            cases.whole(limits)
        return (process_time() - start) / len(self.cases)


def row_bench(study: Study, most: int) -> RowBench:
    """``most`` cases of a row's grid, or all; raises as `row_grid`."""
    job = RowJob(ScanInput(study, motions_of(study)))
    places = list(np.ndindex(job.shape))
    chosen = np.unique(np.linspace(0, len(places) - 1, min(most, len(places))).round().astype(int))
    found = []
    for record, polarity, pga, law, gap, force in (places[at] for at in chosen):
        found.append((job.cases((record, polarity, pga), law, study.rtol), job.grid.limits(gap, force)))
    return RowBench(tuple(found))
