"""The gap that keeps contact to an annual rate, under a hazard curve.

Where the capacities of the motions are known the median of the fragility is proportional to the gap and its dispersion
is one: the gap is the median that fails at the rate, over the median at a gap of 1 m, to rounding. Elsewhere a curve
is fitted at the gaps at which one motion less closes; the gap is the smallest beyond which no curve has a higher rate.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.annual_rates import AnnualRate, read_rate
from pounding_risk.assessment.fragility import SCALED, ContactMotions
from pounding_risk.assessment.hazard import COVERED, Hazard, Rate, rate_of
from pounding_risk.statistics.fragility import Fit, fit_capacities
from pounding_risk.statistics.hazard import counted_gap, median_at_rate
from pounding_risk.units import GAP, say

Array = NDArray[np.float64]

USUAL = tuple(read_rate(f"{percent} % in 50 years") for percent in (20, 10, 5, 2, 1))
DRAWN_HALVINGS = 28  # of bounds, which 400 draws do not tell to more digits
MOST_GAPS = 100  # at which curves are fitted where capacities are not known


@dataclass(frozen=True)
class GapForRate:
    """The gap [m] at which contact has an annual rate, ``words`` as it was asked for.

    ``low`` and ``high`` are the gaps at which the bounds of the rate, which carry those of the fragility and nothing of
    the hazard's own uncertainty, pass it; ``high`` is infinite where the motions give no upper bound. ``rate_low`` and
    ``rate_high`` are those bounds at the gap. ``counted`` is the gap at which the motions, each scaled until it closes
    it, have that rate in the mean, without a lognormal distribution; NaN where scaling is not exact. ``missing`` and
    ``at_least`` as in `Rate`: where the hazard curve leaves out failures the gap must be wider. ``fault`` says why
    there is no gap (NaN).
    """

    rate: float
    words: str
    gap: float = nan
    low: float = nan
    high: float = nan
    rate_low: float = nan
    rate_high: float = nan
    counted: float = nan
    missing: float = nan
    at_least: bool = False
    fault: str = ""


class RateOfGaps:
    """The annual rate of contact at any gap: of a hazard curve and the motions of one interface.

    Parameters
    ----------
    hazard : Hazard
        The hazard curve, of the intensity of the motions.
    motions : ContactMotions
        The motions.
    confidence : float
        Of the bounds, as a fraction.
    """

    def __init__(self, hazard: Hazard, motions: ContactMotions, confidence: float) -> None:
        self.hazard, self.motions, self.confidence = hazard, motions, confidence

    def gap(self, target: AnnualRate) -> GapForRate:
        """The gap that keeps contact to a rate."""
        about = (target.rate, target.words)
        most = float(self.hazard.rate[0] - self.hazard.rate[-1])
        if target.rate >= most:
            return GapForRate(
                *about,
                fault=f"the hazard curve counts motions that come {most:.3g} times a year in all, no more often than "
                "that: give it rows of weaker motions",
            )
        if self._unit is not None:
            return self._by_scaling(target, self._unit)
        return self._by_steps(target)

    @cached_property
    def _unit(self) -> Fit | None:
        """Fragility of a gap of 1 m by scaling; None where the capacities are not known."""
        if not self.motions.linear:
            return None
        fitted = fit_capacities(self.motions.unit_capacities, self.motions.recordings)
        return None if fitted.fault else fitted

    def _by_scaling(self, target: AnnualRate, unit: Fit) -> GapForRate:
        hazard, rate = self.hazard, target.rate
        gap = float(median_at_rate(hazard, unit.dispersion, rate)) / unit.median
        curve = self.motions.curve(gap)
        if curve.fault or curve.method != SCALED:
            scaled = f"the gap would be {say(gap, GAP, 3)}, and {curve.fault or 'scaling does not reach it'}"
            return GapForRate(rate, target.words, fault=scaled)
        medians, dispersions = curve.draws()
        low, high = nan, nan
        if medians.size:
            tail = 50.0 * (1.0 - self.confidence)
            drawn = gap * median_at_rate(hazard, dispersions, rate, DRAWN_HALVINGS) / medians
            low, high = np.percentile(drawn, (tail, 100.0 - tail), method="nearest").tolist()  # inf is no number to add
        here = rate_of(hazard, curve, self.confidence)
        counted = counted_gap(hazard, self.motions.unit_capacities, rate)
        bounds = (low, high, here.low, here.high)
        return GapForRate(rate, target.words, gap, *bounds, counted, here.missing, here.at_least)

    def _by_steps(self, target: AnnualRate) -> GapForRate:
        gaps, rates, faults = self._steps
        about = (target.rate, target.words)
        if not gaps.size:
            return GapForRate(*about, fault=faults[0][1] if faults else "no motion closes any gap")
        annual, lows, highs, missing = rates
        enough = annual <= target.rate
        at = int(enough.argmax())
        if not enough.any():
            beyond = [fault for gap, fault in faults if gap > gaps[-1]][:1]
            return GapForRate(*about, fault=_refusal("widest", float(gaps[-1]), float(annual[-1]), beyond))
        if at == 0:
            beyond = [fault for gap, fault in faults if gap < gaps[0]][-1:]
            return GapForRate(*about, fault=_refusal("narrowest", float(gaps[0]), float(annual[0]), beyond))
        low, high = (_first(gaps, bound <= target.rate) for bound in (lows, highs))
        low = 0.0 if low == gaps[0] else low  # narrower gaps have no curve, and may keep the rate too
        bounds, share = (low, high, float(lows[at]), float(highs[at])), float(missing[at])
        return GapForRate(*about, float(gaps[at]), *bounds, nan, share, share > COVERED)

    @cached_property
    def _steps(self) -> tuple[Array, Array, list[tuple[float, str]]]:
        """Gaps with a fitted curve, (rate, bounds, share left out) at each, and the faults of the others by gap.

        Between two closings the curve is the same. Rates and bounds are at each gap the largest of the gaps from it
        on, so that they fall: curves that are fitted one by one may cross.
        """
        closings = np.unique(self.motions.closing)
        closings = closings[closings > 0.0]
        some = np.unique(np.linspace(0, closings.size - 1, min(closings.size, MOST_GAPS)).round().astype(int))
        gaps, rows, faults = [], [], []
        for gap in closings[some].tolist():
            rate = rate_of(self.hazard, self.motions.curve(gap), self.confidence)
            if rate.fault:
                faults.append((gap, rate.fault))
            else:
                gaps.append(gap)
                rows.append((rate.annual, rate.low, rate.high, rate.missing))
        values = np.array(rows).reshape(-1, 4).T
        falling = np.maximum.accumulate(values[:3, ::-1], axis=1)[:, ::-1]
        return np.array(gaps), np.concatenate([falling, values[3:]]), faults


def _refusal(which: str, gap: float, annual: float, beyond: list[str]) -> str:
    """Sentence on a rate that is not reached at the widest or narrowest gap with a fragility, and why that one is."""
    still, repair = ("still", "stronger") if which == "widest" else ("only", "weaker")
    why = f", and beyond it there is no fragility ({beyond[0]})" if beyond else ""
    return (
        f"at {say(gap, GAP, 3)}, the {which} gap whose fragility these motions carry, contact {still} comes "
        f"{annual:.3g} times a year{why}: scan {repair} motions, and more amplitudes"
    )


def _first(gaps: Array, enough: NDArray[np.bool_]) -> float:
    """The first gap that is wide enough, infinite where none is."""
    return float(gaps[enough.argmax()]) if enough.any() else np.inf


class RateLines(NamedTuple):
    """Annual rates of contact [1/year] with bounds at gaps [m]."""

    gaps: Array
    annual: Array
    low: Array
    high: Array


def rate_lines(rates: Iterable[Rate], gaps_for_rates: Iterable[GapForRate]) -> RateLines:
    """The annual rate of contact against the gap with its bounds, at the gaps of the grid and at those for rates."""
    points = [
        (rate.gap, rate.annual, rate.low, rate.high)
        for rate in rates
        if rate.what == "contact" and rate.gap > 0.0 and rate.annual > 0.0
    ]
    points += [(gap.gap, gap.rate, gap.rate_low, gap.rate_high) for gap in gaps_for_rates if not gap.fault]
    return RateLines(*np.array(sorted(points)).reshape(-1, 4).T)
