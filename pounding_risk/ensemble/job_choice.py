"""Choice of the solver of a scene: the only place that asks which one runs it."""

from __future__ import annotations

from pounding_risk.ensemble.grid_job import GridJob
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.scene.scene import Scene


def job_kind(study: Scene) -> type[GridJob]:
    """The kind of job that runs a scene."""
    if study.is_row:
        from pounding_risk.ensemble.row_job import RowJob  # a pair needs none of it

        return RowJob
    from pounding_risk.ensemble.pair_job import PairJob

    return PairJob


def job_of(scan_input: ScanInput) -> GridJob:
    """The job of a scene; raises as `ensemble.laws.law_of` and `ensemble.row_grid.row_grid`."""
    return job_kind(scan_input.study)(scan_input)  # type: ignore[call-arg]
