"""Choice of the solver of a scene: the only place that asks which one runs it."""

from __future__ import annotations

from pounding_risk.ensemble.grid_job import GridJob
from pounding_risk.ensemble.job import Job, ScanInput
from pounding_risk.scene.known_motions import has_known_motion
from pounding_risk.scene.scene import Scene


def job_kind(study: Scene) -> type[GridJob]:
    """The kind of job that runs a scene."""
    if has_known_motion(study):
        from pounding_risk.ensemble.known_job import KnownJob

        return KnownJob
    if study.is_row:
        from pounding_risk.ensemble.row_job import RowJob  # a pair needs none of it

        return RowJob
    from pounding_risk.ensemble.pair_job import PairJob

    return PairJob


def job_of(scan_input: ScanInput) -> Job:
    """The job of a scene, with all its axes; raises as `grid_job_of`, and as `variant_job.VariantJob`."""
    if scan_input.study.axes:
        from pounding_risk.ensemble.variant_job import VariantJob

        return VariantJob(scan_input, job_kind(scan_input.study))
    return grid_job_of(scan_input)


def grid_job_of(scan_input: ScanInput) -> GridJob:
    """The job of a scene without axes of other numbers; raises as `laws.law_of` and `row_grid.row_grid`."""
    return job_kind(scan_input.study)(scan_input)  # type: ignore[call-arg]
