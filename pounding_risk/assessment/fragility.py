"""Fragilities of contact at any gap, from what each motion closes without contact.

Of linear buildings from the intensity at which each motion closes the gap, which is then known. Elsewhere from the
motions that close it at the scanned intensities.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.motions.levels import say_level
from pounding_risk.motions.motion import USUAL_FACTORS
from pounding_risk.results.amplitudes import intensity_quantity, intensity_unit
from pounding_risk.statistics import fragility as curves
from pounding_risk.statistics.fragility import Fit, Shown, Stripe, fragility_curve
from pounding_risk.statistics.hazard import draws
from pounding_risk.statistics.proportions import independent_motions
from pounding_risk.statistics.required_gap import EVERY_GAP, RunGaps
from pounding_risk.units import GAP, say

Array = NDArray[np.float64]

STRIPES, OWN, SCALED = "multiple stripes", "each motion at its own intensity", "scaled motions"


def shown_as(intensity: str) -> Shown:
    """How sentences write an intensity."""
    quantity = intensity_quantity(intensity)
    return lambda level, digits: say_level(level, quantity, digits)


@dataclass(frozen=True)
class Fragility:
    """P(``what`` | intensity) at one gap [m], and for yielding at one F_E [N] and contact model.

    ``median`` and the ``stripes`` are in the `unit` of the intensity; for the rest see `Fit`. ``note`` says why the
    scanned intensities give no curve of their own where the motions are scaled, and ``factor`` by how much the nearest
    scanned motions are scaled to the median; NaN otherwise. ``independent`` is the number of independent motions that a
    curve of scaled motions is from; NaN of the others.
    """

    what: str  # "contact" or "yield"
    gap: float
    yield_force: float | None
    contact_model: str | None
    intensity: str
    method: str
    median: float
    dispersion: float
    se_median: float
    se_dispersion: float
    se_median_recordings: float
    se_dispersion_recordings: float
    correlation: float
    fault: str
    note: str = ""
    stripes: tuple[Stripe, ...] = field(default=(), repr=False)
    factor: float = np.nan
    independent: float = np.nan
    recordings: int = 0

    @property
    def unit(self) -> str:
        """SI unit of the intensity, as datasets write it: "m/s2", of PGV "m/s"."""
        return intensity_unit(self.intensity)

    @property
    def errors(self) -> tuple[float, float]:
        """The larger standard errors, as `Fit.errors`."""
        larger = max(self.se_median, self.se_median_recordings)
        return larger, max(self.se_dispersion, self.se_dispersion_recordings)

    def draws(self) -> tuple[Array, Array]:
        """Medians and dispersions that the motions leave possible, as `statistics.hazard.draws` has them; else empty.

        Of scaled motions the capacities are a sample of n ``independent`` ones. Of other fits the error of β gives the
        degrees of freedom ν = β²/(2 se²), no more than one less than the ``recordings``.
        """
        median_error, dispersion_error = self.errors
        if not np.isfinite(self.errors).all():
            return np.empty(0), np.empty(0)
        if self.independent > 1.0:
            median_error, degrees = self.dispersion / np.sqrt(self.independent), self.independent - 1.0
        else:
            with np.errstate(divide="ignore"):
                by_error = 0.5 * np.square(np.divide(self.dispersion, dispersion_error))
            degrees = max(min(float(by_error), self.recordings - 1.0), 1.0)
        return draws((self.median, self.dispersion), median_error, degrees)

    def probability(self, im: Array) -> Array:
        """P(failure) at these intensities; NaN where nothing could be fitted."""
        return fragility_curve(im, self.median, self.dispersion)


class ContactMotions(NamedTuple):
    """Motions with a finite response: their intensities, and how far each closes the gap.

    ``linear`` says that the closing is proportional to the motion: scaled by gap over closing it just closes a gap.
    ``run`` are the gaps at which pushes by neighbours are known.
    """

    intensity: str
    method: str  # of fits to the scanned intensities, `STRIPES` or `OWN`
    ims: Array  # (motions, amplitudes) [SI]
    closing: Array  # (motions, amplitudes) [m]
    recordings: NDArray[np.int64]  # (motions,) from 0 without gaps
    linear: bool
    run: RunGaps = EVERY_GAP

    def curve(self, gap: float) -> Fragility:
        """The fragility of contact at a gap [m]; its ``fault`` says why there is none."""
        im, is_touching = self.ims.ravel(), (self.closing > gap).ravel()
        recordings = np.repeat(self.recordings, self.ims.shape[1])
        curve = curves.fit(im, is_touching, recordings, shown_as(self.intensity))
        method, note, factor, independent = self.method, "", np.nan, np.nan
        if self.linear:
            scaled, scaled_factor = self._by_scaling(gap)
            if curve.fault or not scaled.fault:
                curve, method, note, factor = scaled, SCALED, curve.fault, scaled_factor
                independent = np.nan if curve.fault else self.independent
        if self.is_unknown(gap):
            curve, note, factor, independent = Fit(fault=not_run(self.run, gap)), "", np.nan, np.nan
        case = "contact", gap, None, None, self.intensity, method
        stripes = curves.stripes_of(im, is_touching)
        return Fragility(*case, **asdict(curve), note=note, stripes=stripes, factor=factor, independent=independent)

    def is_unknown(self, gap: float) -> bool:
        """True where neighbours may push the two together across a gap [m], as the row was not run at it.

        Scaled motions are taken to push at no other amplitude what they do not push at those that were run.
        """
        if self.linear:
            return gap > self.run.widest
        return bool((self.closing > self.run.below(gap)).sum() > (self.closing > gap).sum())

    @property
    def unit_capacities(self) -> Array:
        """The intensity [SI] at which each motion closes a metre, (motions,); inf where it closes nothing."""
        reach = np.divide(1.0, self.closing, where=self.closing > 0.0, out=np.full(self.closing.shape, np.inf))
        return np.asarray((self.ims * reach)[:, 0])

    @property
    def independent(self) -> float:
        """Number of independent motions, by how alike the capacities of a recording are."""
        return independent_motions(np.log(self.unit_capacities), self.recordings)

    def _by_scaling(self, gap: float) -> tuple[Fit, float]:
        """Fragility of the intensities at which scaled motions close the gap, and the factor of the nearest motions."""
        reach = np.divide(gap, self.closing, where=self.closing > 0.0, out=np.full(self.closing.shape, np.inf))
        fitted = curves.fit_capacities((self.ims * reach)[:, 0], self.recordings)
        if fitted.fault:
            return fitted, np.nan
        factor, fault = out_of_scale(fitted, np.exp(np.log(reach).mean(axis=0)), shown_as(self.intensity))
        return (Fit(fault=fault), np.nan) if fault else (fitted, factor)


def not_run(run: RunGaps, gap: float) -> str:
    """Sentence on a gap [m] at which a row was not run."""
    narrower_gaps = [step for step in run.steps if step < gap]
    if gap > run.widest or not run.steps:
        gaps, others = f"gaps of up to {say(run.widest, GAP, 3)}", "wider ones"
    elif narrower_gaps:
        gaps = f"gaps of {say(narrower_gaps[-1], GAP, 3)} and {say(run.above(gap), GAP, 3)}"
        others = "those between"
    else:
        gaps, others = f"gaps of {say(run.steps[0], GAP, 3)} and more", "narrower ones"
    return f"the row was run at {gaps} here, and neighbours may push the two together across {others}: scan such gaps"


def out_of_scale(fitted: Fit, factors: Array, shown: Shown = curves.plain) -> tuple[float, str]:
    """Factor of the nearest scanned motions to the median, and a sentence on why it is too large or "".

    ``factors`` (amplitudes,) are those from each scanned amplitude to the median. Linear buildings scale exactly; a
    record that is scaled beyond the usual factors is no record of such an earthquake, and no building stays linear.
    """
    nearest = float(factors[np.abs(np.log(factors)).argmin()])
    low, high = USUAL_FACTORS
    is_between = factors.min() <= 1.0 <= factors.max()
    if is_between or low <= nearest <= high:
        return nearest, ""
    repair = "stronger" if nearest > high else "weaker"
    return nearest, (
        f"the median by scaling, {shown(fitted.median, 3)}, takes the motions that were tested times "
        f"{nearest:.3g}, outside {low:g} to {high:g}: scan {repair} motions"
    )
