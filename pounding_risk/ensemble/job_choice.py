"""The job of a scene: of a pair, or of a row."""

from __future__ import annotations

from pounding_risk.ensemble.job import Job, Order


def job_of(order: Order) -> Job:
    """The job of a pair or of a row; raises as `ensemble.laws.law_of` and `ensemble.row_grid.row_grid`."""
    if order.study.is_row:
        from pounding_risk.ensemble.row_job import RowJob  # a pair needs none of it

        return RowJob(order)
    from pounding_risk.ensemble.pair_job import PairJob

    return PairJob(order)
