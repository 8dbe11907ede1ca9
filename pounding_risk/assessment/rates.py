"""The gap that keeps contact to an annual rate under a hazard curve, and the verdict on a gap by its rate.

Where the capacities of the motions are known the median of the fragility is proportional to the gap and its dispersion
is one: the gap is the median that fails at the rate, over the median at a gap of 1 m, to rounding. Elsewhere a curve
is fitted at the gaps at which one motion less closes; the gap is the smallest beyond which no curve has a higher rate.

A gap is adequate where the upper bound of the rate is no more than the target, inadequate where the lower bound is
above it, and depends otherwise. A rate that a hazard curve gives only a lower bound of, as it ends where contact does
not, shows no gap to be adequate, and neither do motions some of which have no finite response.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, isnan, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.order import evenly
from pounding_risk.assessment.annual_rates import AnnualRate, read_rate, return_period_words
from pounding_risk.assessment.fragility import SCALED, ContactMotions, not_run
from pounding_risk.assessment.hazard import COVERED, Hazard, Rate, rate_of
from pounding_risk.assessment.options import percent_words
from pounding_risk.assessment.verdict import ADEQUATE, DEPENDS, INADEQUATE
from pounding_risk.statistics.fragility import Fit, fit_capacities
from pounding_risk.statistics.hazard import counted_gap, in_years, median_at_rate
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import GAP, rounded, say

Array = NDArray[np.float64]

USUAL = tuple(read_rate(f"{percent} % in 50 years") for percent in (20, 10, 5, 2, 1))
EVERY = 8  # step of the drawn dispersions whose median is solved; the others are interpolated
DRAWN_HALVINGS = 28  # of bounds: the draws resolve no more digits
MOST_GAPS = 100  # at which curves are fitted where capacities are not known
WIDEST = 100.0  # m; a wider bound, such as that of a dispersion from two recordings, is none
SHAPE = "Scaling a motion keeps the shape of its spectrum; that of motions as rare as the hazard curve says may differ."
TOO_SHORT = "the hazard curve ends where contact does not"


@dataclass(frozen=True)
class GapForRate:
    """The gap [m] at which contact has an annual rate, ``words`` as it was given.

    ``low`` and ``high`` are the gaps at which the bounds of the rate, which carry those of the fragility and nothing of
    the hazard's own uncertainty, pass it; ``high`` is infinite where the motions give no upper bound, or one above
    100 m and 100 times the gap. ``rate_low`` and ``rate_high`` are those bounds at the gap. ``counted`` is the gap at
    which the motions, each scaled until it closes it, have that rate in the mean, without a lognormal distribution; NaN
    where scaling is not exact. ``missing`` and ``at_least`` as in `Rate`: where the hazard curve leaves out failures
    the gap must be wider. ``fault`` says why there is no gap (NaN).
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
    """The annual rate of contact at any gap: of a hazard curve and the motions of one interface."""

    def __init__(self, hazard: Hazard, motions: ContactMotions, confidence: float) -> None:
        self.hazard, self.motions, self.confidence = hazard, motions, confidence

    def gap(self, target: AnnualRate) -> GapForRate:
        """The gap that keeps contact to a rate."""
        about = (target.rate, target.words)
        limit = float(self.hazard.rate[0])
        if target.rate >= limit:
            return GapForRate(
                *about,
                fault=f"the hazard curve counts motions that come {limit:.3g} times a year in all, no more often than "
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

    def _by_scaling(self, target: AnnualRate, unit_fit: Fit) -> GapForRate:
        hazard, rate = self.hazard, target.rate
        gap = float(median_at_rate(hazard, unit_fit.dispersion, rate)) / unit_fit.median
        curve = self.motions.curve(gap)
        if curve.fault or curve.method != SCALED:
            fault = f"the gap would be {say(gap, GAP, 3)}, and {curve.fault or 'scaling does not reach it'}"
            return GapForRate(rate, target.words, fault=fault)
        medians, dispersions = curve.draws()
        low, high = nan, nan
        if medians.size:
            tail = 50.0 * (1.0 - self.confidence)
            knots = np.append(np.sort(dispersions)[::EVERY], dispersions.max())
            unit_gaps = np.log(median_at_rate(hazard, knots, rate, DRAWN_HALVINGS))
            gaps = gap * np.exp(np.interp(dispersions, knots, unit_gaps)) / medians
            low, high = np.percentile(gaps, (tail, 100.0 - tail), method="nearest").tolist()  # inf is no number to add
            high = high if high <= max(WIDEST, 100.0 * gap) else inf
        contact_rate = rate_of(hazard, curve, self.confidence)
        by_count = counted_gap(hazard, self.motions.unit_capacities, rate)
        bounds = (low, high, contact_rate.low, contact_rate.high)
        return GapForRate(rate, target.words, gap, *bounds, by_count, contact_rate.missing, contact_rate.at_least)

    def _by_steps(self, target: AnnualRate) -> GapForRate:
        gaps, rates, faults = self._steps
        about = (target.rate, target.words)
        if not gaps.size:
            return GapForRate(*about, fault=faults[0][1] if faults else "no motion closes any gap")
        annual, lows, highs, missing = rates
        is_enough = annual <= target.rate
        place = int(is_enough.argmax())
        if not is_enough.any():
            faults_beyond = [fault for gap, fault in faults if gap > gaps[-1]][:1]
            is_unrun = bool((self.motions.closing > self.motions.run.widest).any())  # of a row
            unrun = not_run(self.motions.run, inf) if is_unrun else ""
            fault = _refusal("widest", float(gaps[-1]), float(annual[-1]), faults_beyond, unrun)
            return GapForRate(*about, fault=fault)
        if place == 0:
            faults_beyond = [fault for gap, fault in faults if gap < gaps[0]][-1:]
            return GapForRate(*about, fault=_refusal("narrowest", float(gaps[0]), float(annual[0]), faults_beyond))
        with_end = np.append(gaps, np.inf)  # where no gap is wide enough
        low, high = (float(with_end[np.append(bound <= target.rate, True).argmax()]) for bound in (lows, highs))
        low = 0.0 if low == gaps[0] else low  # narrower gaps have no curve, and may keep the rate too
        bounds, share = (low, high, float(lows[place]), float(highs[place])), float(missing[place])
        return GapForRate(*about, float(gaps[place]), *bounds, nan, share, share > COVERED)

    @cached_property
    def _steps(self) -> tuple[Array, Array, list[tuple[float, str]]]:
        """Gaps with a fitted curve, (rate, bounds, share left out) at each, and the faults of the others by gap.

        Between two closings the curve is the same. Rates and bounds are at each gap the largest of the gaps from it
        on, so that they fall: curves that are fitted one by one may cross.
        """
        closings = np.unique([self.motions.run.above(width) for width in np.unique(self.motions.closing).tolist()])
        closings = closings[(closings > 0.0) & np.isfinite(closings)]
        gaps, rows, faults = [], [], []
        for gap in closings[evenly(closings.size, MOST_GAPS)].tolist():
            rate = rate_of(self.hazard, self.motions.curve(gap), self.confidence)
            if rate.fault:
                faults.append((gap, rate.fault))
            else:
                gaps.append(gap)
                rows.append((rate.annual, rate.low, rate.high, rate.missing))
        columns = np.array(rows).reshape(-1, 4).T
        falling = np.maximum.accumulate(columns[:3, ::-1], axis=1)[:, ::-1]
        return np.array(gaps), np.concatenate([falling, columns[3:]]), faults


def _refusal(end_name: str, gap: float, annual: float, faults_beyond: list[str], unrun: str = "") -> str:
    """Sentence on a rate that is not reached at the widest or narrowest gap with a fragility, and why that one is.

    ``unrun`` is that of a row that was not run at wider ones.
    """
    adverb, repair = ("still", "stronger") if end_name == "widest" else ("only", "weaker")
    reason = f", and beyond it there is no fragility ({faults_beyond[0]})" if faults_beyond else ""
    scan_words = f"; {unrun}" if unrun else f"{reason}: scan {repair} motions, and more amplitudes"
    return (
        f"at {say(gap, GAP, 3)}, the {end_name} gap whose fragility these motions carry, contact {adverb} comes "
        f"{annual:.3g} times a year{scan_words}"
    )


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


# ------------------------------------------------------------------------------------------------ the verdict


@dataclass(frozen=True)
class RateVerdict:
    """The verdict on a gap by the target rate [1/year], ``words`` as it was given, and the gap to provide for it.

    ``annual``, ``low`` and ``high`` are the rate of contact at the gap and its bounds; NaN where it has none.
    ``conclusion`` stands in that of the `Verdict` too.
    """

    word: str
    sentence: str
    conclusion: tuple[str, ...]
    target: float
    words: str
    annual: float
    low: float
    high: float
    required: GapForRate


class RateCriterion(NamedTuple):
    """What a rate of contact is held against: the target, the confidence of the bounds, and the name of the hazard."""

    target: AnnualRate
    confidence: float
    source: str


def judge_rate(at_gap: Rate, required: GapForRate, criterion: RateCriterion, lost: int = 0) -> RateVerdict:
    """The verdict on a gap by its rate of contact ``at_gap``; the docstring of this module states the rule.

    ``required`` is the gap that keeps contact to the target; ``lost`` motions without a finite response are in neither.
    """
    target, confidence = criterion.target, percent_words(criterion.confidence)
    word = DEPENDS
    if at_gap.low > target.rate:
        word = INADEQUATE
    elif at_gap.high <= target.rate and not (at_gap.at_least or lost):
        word = ADEQUATE
    sentence = f"{word.capitalize()} by rate: {_finding(at_gap, target, confidence)}{_why(word, at_gap, target, lost)}"
    advice = _provide(required, criterion)
    rates = at_gap.annual, at_gap.low, at_gap.high
    return RateVerdict(word, sentence, (f"{sentence} {advice}",), target.rate, target.words, *rates, required)


def _finding(at_gap: Rate, target: AnnualRate, confidence: str) -> str:
    gap = say(at_gap.gap, GAP, 3)
    if at_gap.fault:
        return f"how often contact comes at a gap of {gap} is not known ({at_gap.fault})"
    prefix = "at least " if at_gap.at_least else ""
    shares = [in_years(rate, target.years) for rate in (at_gap.annual, at_gap.low, at_gap.high)]
    chance_text, *ends = (f"{rounded(100.0 * share, 2)} %" for share in shares)
    scope_text = ", of what the curve holds" if at_gap.at_least else ""
    bounds = f" ({confidence} bounds {ends[0]} to {ends[1]}{scope_text})" if isfinite(at_gap.low) else ""
    period = return_period_words(at_gap.annual) if at_gap.annual > 0.0 else "never"
    years_text = "1 year" if target.years == 1.0 else f"{target.years:g} years"
    return f"at a gap of {gap} contact comes {prefix}{period}, {prefix}{chance_text} in {years_text}{bounds}"


def _why(word: str, at_gap: Rate, target: AnnualRate, lost: int) -> str:
    if at_gap.fault:
        return "."
    target_text = target.words if target.words.endswith("%") else f"the target of {target.words}"
    if word == ADEQUATE:
        return f", within {target_text} throughout."
    if word == INADEQUATE:
        return f", above {target_text} throughout."
    reason = ""
    if at_gap.high <= target.rate:
        reason = f", as {TOO_SHORT}" if at_gap.at_least else f", as {counted(lost, 'motion')} without a finite response"
        reason += "" if at_gap.at_least else f" {'is' if lost == 1 else 'are'} not in it"
    return f": on which side of {target_text} it is stays open{reason}."


def _provide(required: GapForRate, criterion: RateCriterion) -> str:
    target = criterion.target
    rate = target.words if target.words.startswith("once") else f"{target.words} ({return_period_words(target.rate)})"
    aim_text = f"contact no more often than {rate} under {criterion.source}"
    if required.fault:
        return f"No gap can be given for {aim_text}: {required.fault}."
    gap = say(rounded_up(required.gap), GAP, 3)
    prefix = "at least " if required.at_least else ""
    bounds = "none" if isnan(required.low) else f"at least {say(required.low, GAP, 3)}"
    if isfinite(required.high) and not required.at_least:
        bounds = f"{say(required.low, GAP, 3)} to {say(rounded_up(required.high), GAP, 3)}"
    sentence = f"Provide {prefix}{gap} for {aim_text} ({percent_words(criterion.confidence)} bounds {bounds})"
    sentence += f", as {TOO_SHORT}." if required.at_least else "."
    if not isnan(required.counted):
        method_text = ", with the hazard curve continued at its last slope" if required.at_least else ""
        counted_words = say(rounded_up(required.counted), GAP, 3)
        sentence += f" Counted motion by motion, without a lognormal curve{method_text}, it is {counted_words}."
    return sentence
