"""Fragilities of contact at any gap, from what each motion closes without contact.

Of linear buildings the intensity at which each motion closes a gap is known: from those, which is all that can be known
of the motions. Where it is not, from who closes the gap at the intensities that were scanned.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment import fragility as curves
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.results.amplitudes import intensity_quantity
from pounding_risk.statistics.proportions import independent_motions

Array = NDArray[np.float64]


class ContactMotions(NamedTuple):
    """Motions with a finite response: their intensities, and how far each closes the gap.

    ``linear`` says that the closing is proportional to the motion: scaled by gap over closing it just closes a gap.
    """

    intensity: str
    method: str  # of fits to the scanned intensities, `fragility.STRIPES` or `fragility.OWN`
    ims: Array  # (motions, amplitudes) [SI]
    closing: Array  # (motions, amplitudes) [m]
    recordings: NDArray[np.int64]  # (motions,) from 0 without gaps
    linear: bool

    def curve(self, gap: float) -> Fragility:
        """The fragility of contact at a gap [m]; its ``fault`` says why there is none."""
        im, touching = self.ims.ravel(), (self.closing > gap).ravel()
        who = np.repeat(self.recordings, self.ims.shape[1])
        curve = curves.fit(im, touching, who, intensity_quantity(self.intensity))
        method, note, factor, independent = self.method, "", np.nan, np.nan
        if self.linear:
            scaled, times = self._by_scaling(gap)
            if curve.fault or not scaled.fault:
                curve, method, note, factor = scaled, curves.SCALED, curve.fault, times
                independent = np.nan if curve.fault else self.independent
        about: dict[str, Any] = {"what": "contact", "gap": gap, "yield_force": None, "contact_model": None}
        about |= {"intensity": self.intensity, "method": method, "note": note, "factor": factor}
        stripes = curves.stripes_of(im, touching)
        return Fragility(**about, **asdict(curve), stripes=stripes, independent=independent)

    @property
    def unit_capacities(self) -> Array:
        """The intensity [SI] at which each motion closes a metre, (motions,); inf where it closes nothing."""
        reach = np.divide(1.0, self.closing, where=self.closing > 0.0, out=np.full(self.closing.shape, np.inf))
        return np.asarray((self.ims * reach)[:, 0])

    @property
    def independent(self) -> float:
        """Number of independent motions, by how alike the capacities of a recording are."""
        return independent_motions(np.log(self.unit_capacities), self.recordings)

    def _by_scaling(self, gap: float) -> tuple[curves.Fit, float]:
        """Fragility of the intensities at which scaled motions close the gap, and the factor of the nearest motions."""
        reach = np.divide(gap, self.closing, where=self.closing > 0.0, out=np.full(self.closing.shape, np.inf))
        fitted = curves.fit_capacities((self.ims * reach)[:, 0], self.recordings)
        if fitted.fault:
            return fitted, np.nan
        quantity = intensity_quantity(self.intensity)
        factor, fault = curves.out_of_scale(fitted, np.exp(np.log(reach).mean(axis=0)), quantity)
        return (curves.Fit(fault=fault), np.nan) if fault else (fitted, factor)
