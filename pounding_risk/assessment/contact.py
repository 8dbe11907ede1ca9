"""What the motions of one interface close, at one amplitude of a dataset of `scan`: shares and required gaps."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment import demands as data
from pounding_risk.assessment.demands import Motions
from pounding_risk.assessment.options import Criterion
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import amplitude_words
from pounding_risk.results.own_case import own_level, scene_gap
from pounding_risk.statistics.proportions import Share, independent_motions, labels, logs_of, shares
from pounding_risk.statistics.required_gap import USUAL_PERCENTILES, RequiredGap, required_gaps

if TYPE_CHECKING:
    import xarray as xr


class Contact(NamedTuple):
    """What the motions of one interface close, at one amplitude."""

    gap: float  # m, the assessed one
    every: Motions  # at all amplitudes
    level: int  # index of the amplitude
    at: str  # the amplitude in words
    motions: Motions  # at this amplitude, with a finite response
    independent: float  # motions that these stand for
    shares: tuple[Share, ...]  # that close each gap of the grid, and the assessed one
    required: dict[float, RequiredGap]  # by percentile [%]
    touched: NDArray[np.bool_]  # by motion: contact at the assessed gap

    @property
    def weight(self) -> float:
        """What one motion counts for, at most 1."""
        return self.independent / len(self.motions.records)

    @property
    def at_gap(self) -> Share:
        """The share of the motions that close the assessed gap."""
        return next(share for share in self.shares if share.gap == self.gap)

    @property
    def lost(self) -> int:
        """Motions without a finite response."""
        return int((~self.every.finite).sum())


def contact_of(results: xr.Dataset, index: int, gap: float | None, level: int | None, criterion: Criterion) -> Contact:
    """Contact at the interface ``index``, whose part of a dataset `demands.interfaces` gives.

    Without a gap [m] and the index of an amplitude the scene's own are taken. Raises PoundingError where no motion has
    a finite response.
    """
    gap = scene_gap(results, index) if gap is None else gap
    level = own_level(results) if level is None else level
    every = data.motions_of(results)
    finite = np.flatnonzero(every.finite)
    if not finite.size:
        raise PoundingError(
            "no motion of the dataset moves the ground and has a finite response; check the records and the buildings"
        )
    here = slice(level, level + 1)
    motions = Motions(
        tuple(every.records[motion] for motion in finite),
        tuple(every.polarities[motion] for motion in finite),
        labels(list(every.recordings[finite])),
        (every.amplitudes[level],),
        every.closing[finite, here],
        every.finite[finite],
        None if every.alone is None else every.alone[finite, here],
    )
    closing = motions.closing[:, 0]
    independent = independent_motions(logs_of(closing), motions.recordings)
    weight = independent / closing.size
    gaps = np.unique([*map(float, results["gap"].values), gap]).tolist()
    touched = np.stack([data.touching(results, every, one)[finite, level] for one in gaps], axis=1)
    percentiles = (*USUAL_PERCENTILES, criterion.percentile, criterion.target_percentile)
    return Contact(
        gap,
        every,
        level,
        amplitude_words(results, every.amplitudes[level]),
        motions,
        independent,
        shares(touched.astype(float), [{"gap": one} for one in gaps], weight, criterion.confidence),
        {one.percentile: one for one in required_gaps(closing, weight, percentiles, criterion.confidence)},
        touched[:, gaps.index(gap)],
    )
