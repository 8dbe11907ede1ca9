"""Choice of the job of a scene: pair or row."""

from __future__ import annotations

from pounding_risk.ensemble.job import Job, ScanInput


def job_of(scan_input: ScanInput) -> Job:
    """The job of a pair or of a row; raises as `ensemble.laws.law_of` and `ensemble.row_grid.row_grid`."""
    if scan_input.study.is_row:
        from pounding_risk.ensemble.row_job import RowJob  # a pair needs none of it

        return RowJob(scan_input)
    from pounding_risk.ensemble.pair_job import PairJob

    return PairJob(scan_input)
