"""Assessment of gaps from a dataset of `scan`: probabilities of contact, required gaps, fragilities and a verdict.

Nothing is run. Whether a motion brings contact is known at every gap, not only at those of the grid, from its closing
without contact.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import combinations
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.assessment.annual_rates import AnnualRate, read_target_rate, return_period_words
from pounding_risk.assessment.demands import SAME_GAP, Contact, Motions, contact_of, finite_forces, is_linear, yields_of
from pounding_risk.assessment.fragility import OWN, SCALED, STRIPES, ContactMotions, Fragility, shown_as
from pounding_risk.assessment.gmfs import Fields, Scenario, scenario_of
from pounding_risk.assessment.hazard import Hazard, HazardSpectrum, Rate, curve_doubts, rate_of
from pounding_risk.assessment.intensities import Shaking, check_intensity, intensities, shaking_of
from pounding_risk.assessment.options import USUAL_CONFIDENCE, Criterion, read_criterion
from pounding_risk.assessment.rates import USUAL, GapForRate, RateCriterion, RateOfGaps, RateVerdict, judge_rate
from pounding_risk.assessment.row import column_sentences
from pounding_risk.assessment.sensitivity import (
    Influence,
    Response,
    Yielding,
    contact_influences,
    response_influences,
    responses_at,
    what_matters,
    yield_influences,
)
from pounding_risk.assessment.separations.table import Comparison, separations_of
from pounding_risk.assessment.verdict import Verdict, judge
from pounding_risk.motions.levels import read_measure
from pounding_risk.results.attributes import collapsed, collapses, isolated_buildings, moat_walls
from pounding_risk.results.check import missing_named
from pounding_risk.results.files import open_scan
from pounding_risk.results.opened import Results, yield_forces
from pounding_risk.statistics.fragility import fit, stripes_of
from pounding_risk.statistics.proportions import Share, numbered, shares
from pounding_risk.statistics.required_gap import RequiredGap, RunGaps, rounded_up
from pounding_risk.units import GAP, rounded, say

Array = NDArray[np.float64]

SCALED_ROW = (
    "Neighbours push these two together at none of the gaps and amplitudes that were run; fragilities by scaling take "
    "it that they do not at others."
)


@dataclass(frozen=True, repr=False)
class InterfaceAssessment(ShortRepr):
    """Assessment of one gap between neighbours; lengths in m, accelerations in m/s2, forces in N.

    ``contact``, ``yielding`` and ``required`` are at ``amplitude``, the assessed one of the grid [SI] (None where
    the grid has none; ``intensity`` is its measure, ``at`` says it in words), as is ``closing``, what each motion
    closes, in rising order, known at the gaps ``run`` of a row. ``yielding`` is at every gap of the grid.
    ``fragility`` of contact is at these and the assessed one, of yielding at the grid's nearest, ``yield_gap``, as
    is ``response``, what the motions do under each contact model and F_E. ``own_force`` is the grid's F_E that is
    nearest to the scene's own, ``own_model`` the scene's contact model. ``rates`` go with ``fragility``, where a
    hazard curve is given; ``gaps_for_rates`` are then the gaps that keep contact to usual rates and to the target
    rate, which ``rate_verdict`` is on. ``separations`` are those of codes, beside the motions.
    """

    name: str
    gap: float
    amplitude: float | None
    at: str
    yield_gap: float
    own_force: float
    own_model: str
    closing: tuple[float, ...]
    run: RunGaps
    contact: tuple[Share, ...]
    yielding: tuple[Share, ...]
    response: tuple[Response, ...]
    required: tuple[RequiredGap, ...]
    fragility: tuple[Fragility, ...]
    rates: tuple[Rate, ...]
    gaps_for_rates: tuple[GapForRate, ...]
    sensitivity: tuple[Influence, ...]
    what_matters: str
    separations: tuple[Comparison, ...]
    verdict: Verdict
    rate_verdict: RateVerdict | None = None
    scenario: tuple[Scenario, ...] = ()  # by fragility, where ground-motion fields are given
    intensity: str = "pga"  # of ``amplitude``, as an assessment takes it
    columns: tuple[str, ...] = ()  # which floor strikes which column, how often, what the model assumes then
    column_forces: tuple[float, ...] = ()  # F_E of columns [N], finite, where floors with another meet too

    def required_at(self, percentile: float) -> RequiredGap:
        """The gap required by a percentile [%] of the requested ones, among them 50, 84 and 95."""
        return next(required for required in self.required if required.percentile == percentile)

    def facts(self) -> Iterable[tuple[str, str]]:
        """Names of the buildings, verdict, and required gaps, as pairs of a name and words."""
        yield "between", self.name
        yield "verdict", self.verdict.sentence
        for required in self.required:
            yield f"gap of {required.percentile:g} % of the motions", say(required.provided, GAP, 3)
        for target in self.gaps_for_rates:
            if not target.fault:
                least = "at least " if target.at_least else ""
                yield f"gap for {target.words}", f"{least}{say(rounded_up(target.gap), GAP, 3)}"

    def contact_at_gap(self) -> Share:
        """The share of the motions that close the assessed gap."""
        return next(share for share in self.contact if share.gap == self.gap)


@dataclass(frozen=True, repr=False)
class Assessment(ShortRepr):
    """Assessment of every interface of a dataset, with its criterion and the runs that it rests on.

    ``confidence`` and ``target`` are fractions, ``percentile`` is in %; ``asked`` says in words how they were read.
    ``hazard`` names the hazard curve; ``hazard_rows`` are its rows, intensity [SI] and annual rate [1/year], and
    ``hazard_reading`` says how the table was read. ``target_rate`` is the accepted rate of contact [1/year], and
    ``target_rate_words`` how it was given. ``gmfs`` names the ground-motion fields, and ``gmfs_reading`` says how they
    were read. ``unused_keys`` are the keys of the scene that change nothing in it, and
    why; ``flags`` are the notes on each record, and ``left_out`` the files of records that were excluded, and why.
    """

    title: str
    cases: int
    simulated: int
    failed: int
    checked: int
    sensitive: int
    confidence: float
    percentile: float
    target: float
    asked: str
    intensity: str
    hazard: str
    hazard_rows: tuple[tuple[float, float], ...]
    interfaces: tuple[InterfaceAssessment, ...]
    notes: tuple[str, ...] = ()  # on unusual numbers of the input and of the contacts
    unused_keys: tuple[str, ...] = ()
    flags: dict[str, list[str]] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    hazard_reading: str = ""
    target_rate: float | None = None
    target_rate_words: str = ""
    gmfs: str = ""
    gmfs_reading: str = ""

    def facts(self) -> Iterable[tuple[str, str]]:
        """Scene, cases, and the verdict on each gap, as pairs of a name and words."""
        yield "study", self.title
        yield "cases", f"{self.cases}, {self.simulated} of them simulated, {self.failed} failed"
        for interface in self.interfaces:
            yield interface.name, interface.verdict.sentence
        for note in self.notes:
            yield "note", note

    @property
    def unlike_verdicts(self) -> tuple[str, ...]:
        """A sentence for each pair of gaps with as many contacts and another verdict: why it is another."""
        sentences = []
        judged_by_share = [side for side in self.interfaces if side.rate_verdict is None]
        for pair in combinations(judged_by_share, 2):
            (share, other_share), words = [side.contact_at_gap() for side in pair], {side.verdict.word for side in pair}
            if len(words) == 1 or (share.count, share.runs) != (other_share.count, other_share.runs):
                continue
            reasons = [
                f"{side.verdict.word} at {side.name}, where "
                + (
                    "the polarities alone lie on both sides of the target"
                    if side.verdict.by_polarity
                    else f"the motions have an effective sample size of {rounded(side.verdict.independent, 2)}"
                )
                for side in pair
            ]
            touch_text = f"{share.count} of {share.runs} motions touch at both"
            sentences.append(f"{touch_text}, and the verdict is {' and '.join(reasons)}.")
        return tuple(sentences)

    @property
    def criterion(self) -> Criterion:
        """Target, percentile and confidence, as the gaps were held against them."""
        return Criterion(self.target, self.percentile, self.confidence)

    @property
    def hazard_curve(self) -> Hazard | None:
        """The hazard curve, None where none was given; already checked to be of the intensity."""
        if not self.hazard_rows:
            return None
        im, rate = np.array(self.hazard_rows).T
        return Hazard(self.intensity, im, rate, self.hazard, self.hazard_reading)

    def as_dict(self) -> dict[str, Any]:
        """The assessment as tables and lists that JSON holds; None for what is not a finite number."""
        return plain(asdict(self))


class Options(NamedTuple):
    """The options of `assess`, as they were read."""

    gap: float | None
    criterion: Criterion
    level: int | None  # index of the requested amplitude
    target_rate: AnnualRate | None
    shaking: Shaking


@missing_named()
def assess(
    results: xr.Dataset | str | Path,
    *,
    gap: float | str | None = None,
    hazard: Hazard | HazardSpectrum | str | Path | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    percentile: float | str | None = None,
    intensity: str | None = None,
    target: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
    target_rate: AnnualRate | float | str | None = None,
    gmfs: Fields | str | Path | None = None,
) -> Assessment:
    """Assess gaps: P(contact), required gaps, a verdict.

    A share, such as 84 %, may be written 0.84, 84 or "84 %". A target asks for the percentile that leaves it, 90 % of
    0.1, and a percentile leaves a target, 0.16 of 84 %; where both are given the verdict uses the target.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    gap : float or str, optional
        The gap to assess [m, or text with a unit], at every interface; the scene's own by default.
    hazard : Hazard, HazardSpectrum, str or Path, optional
        A hazard curve, spectra at several rates, or a CSV file of either (`read_hazard`), from which annual rates
        follow.
    confidence : float or str
        Confidence of all bounds, above 50 %.
    percentile : float or str, optional
        Share of the motions, beside 50, 84 and 95 %, whose required gap is given; what the target asks for, or 84 %,
        by default.
    intensity : str, optional
        Intensity of the fragilities: "pga"; "sa(left)", "sa(right)" or "sa(NAME)", the pseudo-spectral acceleration at
        a building's period; "sa(longer)", "sa(shorter)" or "sa(mean)", that of 5 % damping at the longest, the shortest
        and the geometric mean of the buildings' periods; "sa(0.62 s)" at any period; "sa_avg(0.2-2 s)", the geometric
        mean over a range of periods; "pgv"; or "scale", the factors of a grid of them. By default that of the hazard
        curve; of hazard spectra, and without a hazard, the one that the scene scales its motions to, else "sa(longer)"
        with spectra and PGA without.
    target : float or str, optional
        Accepted probability of contact, against which the verdict holds P(contact) with its bounds (`verdict` states
        the rule); what the percentile leaves by default.
    pga : float or str, optional
        Amplitude of the grid to assess [m/s2, or text with a unit]; the scene's own by default where the grid has it,
        else the largest.
    intensity_level : float or str, optional
        The same for a grid of any measure: the level to assess [SI, or text with a unit]; the largest by default.
    target_rate : AnnualRate, float or str, optional
        Accepted rate of contact under the hazard curve: "1 % in 50 years", a return period such as "2475 years", or a
        rate such as "4e-4 a year", which may be a plain number.
    gmfs : Fields, str or Path, optional
        Ground-motion fields of OpenQuake with their site, ``gmf-data_1.csv#3`` (`pounding_risk.assessment.gmfs`), from
        which probabilities in a scenario or an event set follow. Without an intensity and a hazard the fragilities are
        against the first that the fields have of: the usual one, "sa(longer)", "pga".

    Returns
    -------
    Assessment
        The assessment of every interface, and what it was asked.

    Raises
    ------
    PoundingError
        For a dataset that is none of `scan`, for an option out of its range, for a target rate without a hazard curve,
        and as `read_hazard`.
    """
    opened = open_scan(results)
    gap, level = opened.read_gap(gap), opened.level(pga, intensity_level)
    rate = read_target_rate(target_rate, hazard is not None)
    criterion = read_criterion(target, percentile, confidence)
    shaking = shaking_of(opened, hazard, gmfs, intensity)
    curve, fields = shaking.hazard, shaking.fields
    options, doubts = Options(gap, criterion, level, rate, shaking), opened.record_doubts
    notes = [note for note in opened.notes if gap is None or note not in opened.nearest_notes]  # of the scene's own gap
    interfaces = tuple(
        _interface(name, interface, index, options, doubts) for index, (name, interface) in enumerate(opened.interfaces)
    )
    return Assessment(
        title=str(opened.dataset.attrs.get("title", "")),
        **opened.run_counts,
        confidence=criterion.confidence,
        percentile=criterion.percentile,
        target=criterion.target,
        asked=criterion.words,
        intensity=shaking.intensity,
        hazard=curve.source or curve.name if curve else "",
        hazard_rows=tuple(zip(curve.im.tolist(), curve.rate.tolist(), strict=True)) if curve else (),
        interfaces=interfaces,
        notes=(*notes, *curve_doubts(curve, [rate for assessed in interfaces for rate in assessed.rates])),
        unused_keys=opened.unused_keys,
        flags=opened.flags,
        left_out=opened.left_out,
        hazard_reading=shaking.reading,
        target_rate=rate.rate if rate else None,
        target_rate_words=rate.words if rate else "",
        gmfs=fields.source if fields else "",
        gmfs_reading=" ".join(fields.reading) if fields else "",
    )


def _interface(name: str, results: Results, index: int, options: Options, doubts: Sequence[str]) -> InterfaceAssessment:
    criterion, hazard, confidence = options.criterion, options.shaking.hazard, options.criterion.confidence
    if hazard is not None:
        check_intensity(results, options.shaking.intensity, hazard.name)
    contact = contact_of(results, index, options.gap, options.level, criterion)
    gap, all_motions, level, dataset = contact.gap, contact.every, contact.level, results.dataset
    columns = column_sentences(results, level, gap)
    yield_gap, yields = yields_of(dataset, gap)
    is_nearest = options.gap is not None and abs(yield_gap - gap) > SAME_GAP
    period = _return_period_words(hazard, results, all_motions.amplitudes[level])
    note = f"Forces, yielding and struck columns are those at {say(yield_gap, GAP, 4)}, the nearest gap of the grid."
    link = results.link_words(index)
    link = link and f"Springs or dampers join the two ({link}): contact and required gaps are those with them."
    walls = [name for name in moat_walls(results.scene) if name in dataset["building"].values]
    response = responses_at(results.at_level(level).dataset, yield_gap, isolated_buildings(results.scene), walls)
    sensitivity = _influences(results, contact, yields[:, level], response, criterion)
    motions = _contact_motions(results, all_motions, options.shaking.intensity)
    contact_curves = (motions.curve(share.gap) for share in contact.shares)
    fragility = (*contact_curves, *_yield_curves(results, all_motions, yield_gap, yields, motions))
    rates, gaps_for_rates, rate_verdict = _rate_results(motions, fragility, contact, options)
    events = options.shaking.events(results)
    is_scaled = any(curve.method == SCALED and not curve.fault for curve in fragility)
    row_note = SCALED_ROW * (is_scaled and isfinite(all_motions.run.widest))
    counts = (
        results.run_counts | {"unpushed": results.unpushed} | _collapses(results.at_level(level), yield_gap, contact)
    )
    verdict = judge(contact, criterion, sensitivity[0], counts, doubts)
    verdict = replace(
        verdict,
        conclusion=(*columns, *verdict.conclusion, *(rate_verdict.conclusion if rate_verdict else ())),
        evidence=(
            *verdict.evidence,
            *filter(None, (link, note * is_nearest, period, row_note, *_notes(name, results, motions, options.level))),
        ),
    )
    return InterfaceAssessment(
        name=name,
        gap=gap,
        amplitude=all_motions.amplitudes[level],
        at=contact.at,
        yield_gap=yield_gap,
        own_force=results.scene_force,
        own_model=results.scene_model,
        closing=tuple(np.sort(contact.motions.closing[:, 0]).tolist()),
        run=all_motions.run,
        contact=contact.shares,
        yielding=_yield_shares(dataset, level, contact.weight, confidence),
        response=response,
        required=tuple(contact.required.values()),
        fragility=fragility,
        rates=rates,
        gaps_for_rates=gaps_for_rates,
        sensitivity=sensitivity,
        what_matters=what_matters(sensitivity),
        separations=separations_of(results.at_level(level), criterion.percentile).rules,
        verdict=verdict,
        rate_verdict=rate_verdict,
        intensity=results.amplitudes.name,
        scenario=() if events is None else tuple(scenario_of(events, curve, confidence) for curve in fragility),
        columns=columns,
        column_forces=_column_forces(results),
    )


def _collapses(results: Results, gap: float, contact: Contact) -> dict[str, int]:
    """Motions in which a storey collapses, without contact, and those that are lost as it does with contact alone."""
    dataset = results.dataset
    is_collapsed = collapsed(dataset, without=True)
    case = dataset.isel(results.scene_contact | {"gap": int(np.abs(dataset["gap"].values - gap).argmin())})
    struck_count = int((collapsed(case) & ~is_collapsed).sum()) if contact.lost > int(is_collapsed.sum()) else 0
    return {"collapsed": int(is_collapsed.sum()), "struck": min(struck_count, contact.lost - int(is_collapsed.sum()))}


def _column_forces(results: Results) -> tuple[float, ...]:
    floors, columns = yield_forces(results.dataset.isel(results.scene_contact))
    return tuple(sorted({force for force in columns if isfinite(force) and floors and force not in floors}))


def _influences(
    results: Results, contact: Contact, yields: Array, response: Sequence[Response], criterion: Criterion
) -> tuple[Influence, ...]:
    """What contact, yielding and the response of the motions hang on; that of the polarity on contact first."""
    models, forces = tuple(map(str, results.dataset["contact_model"].values)), finite_forces(results.dataset).tolist()
    sensitivity = contact_influences(contact.motions, contact.touched, contact.gap, criterion)
    if results.scene_force in forces:
        yielding = Yielding(yields, contact.every.polarities, models, tuple(forces))
        sensitivity += yield_influences(yielding, results.scene_force, criterion.target)
    return sensitivity + response_influences(
        response, results.scene_model, results.scene_force, bool(np.isinf(forces).any())
    )


def _notes(name: str, results: Results, motions: ContactMotions, level: int | None) -> Iterator[str]:
    """Sentences beside the evidence of an interface, empty ones among them; ``level`` is the requested amplitude."""
    yield _amplitude_note(results) if level is None else ""
    yield str(results.level_notes.get(name, ""))
    for words, without in (("Motions without contact", True), ("Cases", False)):
        if storeys := collapses(results.dataset, without=without):
            yield f"{words} in which storeys collapse: {storeys}."
    if count := int(np.isinf(motions.closing).sum()):
        yield (
            f"Fragilities of contact and their rates count {count} of {motions.closing.size} motions at all amplitudes "
            "together, without a finite response, as contact at every gap."
        )


def _return_period_words(hazard: Hazard | None, results: Results, amplitude: float | None) -> str:
    """Sentence on how often the assessed amplitude comes under a hazard curve of its measure; "" without one."""
    if hazard is None or amplitude is None or hazard.name != results.amplitudes.name:
        return ""
    rate = float(np.exp(np.interp(np.log(amplitude), np.log(hazard.im), np.log(hazard.rate))))
    bound_text = "less than " if amplitude > hazard.im[-1] else "more than " if amplitude < hazard.im[0] else ""
    text = f"is exceeded {bound_text}{return_period_words(rate)} under {hazard.source or hazard.name}"
    return f"{results.amplitude_words(amplitude).removeprefix('at ')} {text}: P(contact) is that of such motions."


def _rate_results(
    motions: ContactMotions, fragility: Sequence[Fragility], contact: Contact, options: Options
) -> tuple[tuple[Rate, ...], tuple[GapForRate, ...], RateVerdict | None]:
    """Rates of the fragilities, gaps for usual rates and the target, the most frequent first, and the verdict."""
    hazard, target, confidence = options.shaking.hazard, options.target_rate, options.criterion.confidence
    if hazard is None:
        return (), (), None
    rates = tuple(rate_of(hazard, curve, confidence) for curve in fragility)
    targets = {usual.rate: usual for usual in (*USUAL, *(() if target is None else (target,)))}
    of_gaps = RateOfGaps(hazard, motions, confidence)
    gaps = {rate: of_gaps.gap(targets[rate]) for rate in sorted(targets, reverse=True)}
    verdict = None
    if target is not None:
        contact_rate = rate_of(hazard, motions.curve(contact.gap), confidence)
        criterion = RateCriterion(target, confidence, hazard.source or hazard.name)
        verdict = judge_rate(contact_rate, gaps[target.rate], criterion, contact.lost)
    return rates, tuple(gaps.values()), verdict


def _amplitude_note(results: Results) -> str:
    """Sentence on which of several amplitudes is assessed where none is requested, and why."""
    amplitudes = results.amplitudes
    if len(amplitudes.values) < 2:
        return ""
    levels = [amplitudes.words(amplitude) for amplitude in amplitudes.values if amplitude is not None]
    reason = "the largest" if results.scene_amplitude is None else "the scene's own"
    *others, last = levels
    return f"Of the amplitudes {', '.join(others)} and {last}, {levels[results.scene_level]} is assessed: {reason}."


def _yield_shares(results: xr.Dataset, level: int, weight: float, confidence: float) -> tuple[Share, ...]:
    """The share of the motions whose force reaches F_E, by gap, contact model and finite F_E.

    The motions of a recording are taken to be as alike in their forces as in what they close.
    """
    yielding: list[Share] = []
    forces, models = finite_forces(results).tolist(), results["contact_model"].values.tolist()
    if not forces:
        return ()
    for gap in map(float, results["gap"].values):
        _, yields = yields_of(results, gap)
        cases = [{"gap": gap, "contact_model": model, "yield_force": force} for model in models for force in forces]
        yielding.extend(shares(yields[:, level].reshape(len(yields), -1), cases, weight, confidence))
    return tuple(yielding)


def _contact_motions(results: Results, motions: Motions, intensity: str) -> ContactMotions:
    """The motions that fragilities of contact at any gap are fitted to."""
    amplitudes, measure = results.amplitudes, read_measure(intensity)
    # What is pushed across a gap by others does not grow with the motion.
    is_pushed = motions.alone is not None and bool((motions.closing > motions.alone)[motions.finite].any())
    linear = is_linear(results) and not is_pushed
    # No gap is wide enough for a motion in which a storey collapses.
    closing = motions.closing if linear else np.where(motions.finite, motions.closing, np.inf)
    is_used = motions.finite.all(axis=1) if linear else np.repeat(results.is_shaking, len(set(motions.polarities)))
    ims, closing = intensities(results, intensity)[is_used], closing[is_used]
    is_own = measure is not None and amplitudes.measure.is_same(measure)
    method = STRIPES if is_own and len(amplitudes.values) > 1 else OWN
    recordings = numbered(motions.recordings[is_used])
    return ContactMotions(intensity, method, ims, closing, recordings, linear, motions.run)


def _yield_curves(
    results: Results, motions: Motions, gap: float, yields: Array, of_contact: ContactMotions
) -> Iterator[Fragility]:
    """Fragilities of yielding at one gap, by contact model and finite F_E, against the same intensity."""
    intensity, method = of_contact.intensity, of_contact.method
    ims = intensities(results, intensity)
    recordings = np.repeat(motions.recordings, ims.shape[1])
    for column, model in enumerate(map(str, results.dataset["contact_model"].values)):
        for row, force in enumerate(finite_forces(results.dataset).tolist()):
            failed = yields[:, :, column, row].ravel()
            is_known = ~np.isnan(failed)
            if not is_known.any():
                continue
            im, is_reached = ims.ravel()[is_known], failed[is_known] > 0.0
            fitted = fit(im, is_reached, numbered(recordings[is_known]), shown_as(intensity))
            case = "yield", gap, force, model, intensity, method
            yield Fragility(*case, **asdict(fitted), stripes=stripes_of(im, is_reached))


def plain(fact: Any) -> Any:
    """The value as JSON holds it: None for what is not a finite number."""
    if isinstance(fact, dict):
        return {key: plain(inner) for key, inner in fact.items()}
    if isinstance(fact, list | tuple):
        return [plain(inner) for inner in fact]
    return None if isinstance(fact, float) and not isfinite(fact) else fact
