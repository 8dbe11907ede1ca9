"""Both curves of a damage state, with pounding and without, and samples of both from a bootstrap of recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.damage_demands import demands_of
from pounding_risk.assessment.fragility import shown_as
from pounding_risk.assessment.hazard import Hazard
from pounding_risk.statistics.damage_fits import METHODS, Capacities, Observed, capacities, expanded_tail
from pounding_risk.statistics.fragility import Fit, fragility_curve, of_one_intensity

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

POUNDING = ("with", "without")
DRAWS, SEED = 1000, 20110314  # samples of recordings
NO_CONTACT = "no force acts between buildings without contact, so that no motion can reach the state"
LOST = 0.05  # share of samples without a value from which on there are no bounds


class Motions(NamedTuple):
    """Intensities of the motions, (motions, levels), and their recordings."""

    ims: Array
    recordings: Labels
    records: tuple[str, ...]
    polarities: tuple[str, ...]

    @property
    def levels(self) -> Array | None:
        """The intensities that all motions have, level by level; None where they differ."""
        known = self.ims[np.isfinite(self.ims).all(axis=1)]
        alike = len(known) > 0 and all(map(of_one_intensity, known.T))
        return np.asarray(np.median(known, axis=0)) if alike else None


class Options(NamedTuple):
    """What `damage` was asked, as it was read."""

    intensity: str
    method: str
    confidence: float
    hazard: Hazard | None
    at: float | None
    recordings: int
    fields: Array | None = None  # intensities of the events of ground-motion fields at the site

    @property
    def tails(self) -> tuple[float, float]:
        """The percentages between which the bounds lie, of a bootstrap of so many recordings."""
        tail = 100.0 * expanded_tail(self.confidence, self.recordings)
        return tail, 100.0 - tail


@dataclass(frozen=True)
class Curves:
    """Both curves of a state: with pounding, then without; ratios are with over without, with bounds."""

    state: Any
    ratios: tuple[Array, Array]  # demands over the threshold, (motions, levels)
    fits: tuple[Fit, Fit]
    found: tuple[Capacities, Capacities]
    drawn: tuple[Array, Array]  # ln θ and β of samples of recordings, NaN where there is no curve

    @property
    def drawn_alike(self) -> tuple[Array, Array]:
        """The samples in which both have a curve."""
        both = np.isfinite(self.drawn[0]).all(axis=1) & np.isfinite(self.drawn[1]).all(axis=1)
        return self.drawn[0][both], self.drawn[1][both]

    @property
    def lost(self) -> int:
        """Samples in which one has no curve."""
        return len(self.drawn[0]) - len(self.drawn_alike[0])

    @property
    def is_compared(self) -> bool:
        """Whether both have a curve."""
        return not any(fit.fault for fit in self.fits)

    def probability(self, im: Array) -> tuple[Array, Array]:
        """Probabilities of the state at these intensities, with pounding and without."""
        with_contact, without = (fragility_curve(im, fit.median, fit.dispersion) for fit in self.fits)
        return with_contact, without

    def bounds(self, of_samples: Array, tails: tuple[float, float]) -> tuple[Array, Array]:
        """Bounds from values by sample along the first axis; NaN where too many samples have no curve."""
        if not self.is_compared or self.lost > LOST * len(self.drawn[0]):
            return np.full(of_samples.shape[1:], np.nan), np.full(of_samples.shape[1:], np.nan)
        known = ~np.isnan(of_samples)
        enough = known.sum(axis=0) >= (1.0 - LOST) * len(self.drawn[0])
        shown = np.where(enough, of_samples, 0.0)
        # Each bound is one sample's own value, as a ratio may be infinite.
        low = np.nanpercentile(shown, tails[0], axis=0, method="lower")
        high = np.nanpercentile(shown, tails[1], axis=0, method="higher")
        return np.where(enough, low, np.nan), np.where(enough, high, np.nan)


def curves_of(case: xr.Dataset, state: Any, motions: Motions, options: Options, weights: Array) -> Curves:
    """Both curves of a state; a run that failed with contact is left out of both."""
    demands = demands_of(case, state)
    known = np.isfinite(motions.ims) & np.isfinite(demands.with_contact) & np.isfinite(demands.without)
    ratios = [np.where(known, values, np.nan) for values in demands[:2]]
    method = METHODS[options.method]
    shown = shown_as(options.intensity)
    seen = [Observed(motions.ims, values, motions.recordings, shown, demands.jumps) for values in ratios]
    fits = [method.fit(one) for one in seen]
    if state.demand.interfaces:
        fits[1] = Fit(fault=NO_CONTACT)
    nothing = np.full((len(weights), 2), np.nan)
    drawn = [nothing if fit.fault else method.drawn(one, weights) for fit, one in zip(fits, seen, strict=True)]
    found = [capacities(motions.ims, values, demands.jumps) for values in ratios]
    return Curves(state, _pair(ratios), _pair(fits), _pair(found), _pair(drawn))


def _pair(values: Sequence[Any]) -> Any:
    with_contact, without = values
    return with_contact, without
