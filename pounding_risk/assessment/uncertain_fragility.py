"""Fragilities of contact over samples of uncertain numbers and motions: of the motions alone, and in all.

Linear buildings close a gap under a motion that is scaled by gap over closing: so every motion has a capacity in every
sample, and ln capacity has the components of variance of ln closing and ln intensity together. The curve of the motions
alone has the mean of ln capacity and the dispersion of the motions within a sample; the one in all adds what the
samples differ by (the composite curve of Kennedy and Ravindra, Nuclear Engineering and Design 79, 1984).
"""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment import demands as data
from pounding_risk.assessment.fragility import out_of_scale, shown_as
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import spectral, usual_intensity
from pounding_risk.statistics.crossed_contact import CrossedClosings
from pounding_risk.statistics.fragility import ALONE, Fit

if TYPE_CHECKING:
    from pounding_risk.assessment.uncertain_samples import Asked, Samples

Array = NDArray[np.float64]

CURVES = ("motions alone", "total")


class Capacities(NamedTuple):
    """Logarithms of the intensities at which motions close a gap, (samples, motions), or why there are none."""

    logs: Array | None
    closings: CrossedClosings  # whose motions and recordings they have
    intensity: str
    fault: str

    @classmethod
    def of(cls, subject: Samples, index: int, closings: CrossedClosings, gap: float, asked: Asked) -> Capacities:
        """The capacities at a gap [m] of an interface."""
        one_sample = data.interfaces(subject.first_sample)[index][1]
        intensity = usual_intensity(one_sample) if asked.intensity is None else asked.intensity
        if intensity.startswith("sa(") and spectral(intensity[3:-1]) is None:
            if asked.intensity is not None:
                raise PoundingError(
                    f"intensity {intensity!r}: a building's period may differ between samples; write pga, or a period "
                    "such as sa(0.5 s)"
                )
            intensity = "pga"
        reach = subject.reach_of(subject.dataset, index, asked.level)[:, closings.order]
        drawn = subject.gaps_of(subject.dataset, index, gap)
        gaps = np.full(len(reach), gap) if drawn is None else drawn
        fault = cls._fault(subject, index, (reach, gaps), one_sample)
        if not fault and closings.recordings.max() == 0:
            fault = ALONE
        if fault:
            return cls(None, closings, intensity, fault)
        ims = data.intensities(one_sample, intensity)
        ims = subject.by_outcome(ims[:, min(subject.level(asked.level), ims.shape[1] - 1)], closings)
        factors = np.log(gaps)[:, None] - np.log(reach)
        logs = np.log(ims) + factors
        _, fault = out_of_scale(Fit(median=float(np.exp(logs.mean()))), np.exp([factors.mean()]), shown_as(intensity))
        return cls(None if fault else logs, closings, intensity, fault)

    @staticmethod
    def _fault(subject: Samples, index: int, closed: tuple[Array, Array], one_sample: Any) -> str:
        """Why there are no capacities; ``closed`` is what motions close and the gap of each sample [m]."""
        reach, gaps = closed
        if not data.is_linear(one_sample):
            return "the motion without contact is not linear: closings do not grow with the motion"
        if subject.is_inner(index) and "impact_count" in subject.dataset:
            return "contact elsewhere in the row may push buildings across the gap, which does not grow with the motion"
        if gaps.min() <= 0.0:
            return "a closed gap is touched by the weakest motion"
        if not (reach.min() > 0.0 and np.isfinite(reach).all()):
            return "a motion closes nothing, or has no finite response, in some sample"
        return ""

    def fitted(self, confidence: float) -> tuple[Array, Array]:
        """Median [SI] and dispersion of both curves with bounds, each (curves, 3)."""
        if self.logs is None:
            return np.full((2, 3), nan), np.full((2, 3), nan)
        from scipy.stats import t as student

        analysis, counted = self.closings.of_logs(self.logs)
        alone, total = (
            np.sqrt(analysis.variance_bounds(of, confidence))
            for of in (lambda one: one.motions + one.interaction, lambda one: one.total)
        )
        variance = counted.variance_of_mean(analysis.all)
        if self.closings.is_drawn:  # what motions do in a sample is not told from what they do in the mean over samples
            alone = np.full(3, nan)
        freedom = max(min(counted.motions, float(counted.samples)) - 1.0, 1.0)
        half = float(student.ppf(0.5 * (1.0 + confidence), freedom)) * np.sqrt(variance)
        median = np.exp(self.logs.mean() + np.array([0.0, -half, half]))
        return np.stack([median, median]), np.stack([alone, total])
