"""The command `assess`: the verdict on each gap with its evidence, and the tables behind it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.files import draw, write_text
from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Confidence,
    Figure,
    Gmfs,
    Hazard,
    Intensity,
    IntensityLevel,
    JudgedGap,
    Percentile,
    Results,
    Select,
    Site,
    Target,
    TargetRate,
    at_site,
    opened_results,
    out_option,
    read_optional,
)
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, print_sheet, print_table

if TYPE_CHECKING:
    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
    from pounding_risk.assessment.fragility import Fragility
    from pounding_risk.assessment.gap_for_rate import GapForRate
    from pounding_risk.assessment.gmfs import Scenario
    from pounding_risk.assessment.hazard import Rate

ORDER = 130
MOST_PLACES = 60  # rows of the table along axes
MOST_GAPS = 12  # rows of the table of gaps; more are thinned evenly
GIVEN_DIGITS = 6  # of values that a user has given
AT_LEAST = "the hazard curve ends where failures do not; give one that reaches further"
COLUMNS = "columns' own"
SAMPLE = "sample"  # the axis of uncertain numbers
KEYS = {"yield_force": "F_E", "contact_model": "contact model", "polarity": "polarity"}


def assess(
    results: Results,
    gap: JudgedGap = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    intensity: Intensity = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    hazard: Hazard = None,
    gmfs: Gmfs = None,
    site: Site = None,
    target_rate: TargetRate = None,
    setback: Annotated[
        bool, typer.Option("--setback", help="Instead: distance of each building from a property line.")
    ] = False,
    select: Select = NONE,
    out: Annotated[Path | None, out_option("Write it all", ".json")] = None,
    figure: Figure = None,
) -> None:
    """Is this gap enough? Probabilities, required gaps, a verdict."""
    from pounding_risk.assessment.annual_rates import read_target_rate
    from pounding_risk.assessment.assess import assess as run
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.results.scene_axes import check_settled, open_axes
    from pounding_risk.units import GAP, PGA

    if setback:
        idle = {
            "--gap": gap, "--intensity": intensity, "--hazard": hazard, "--gmfs": gmfs, "--site": site,
            "--target-rate": target_rate, "--figure": figure,
        }  # fmt: skip
        for name, value in idle.items():
            if value is not None:
                raise PoundingError(f"{name}: is not taken with --setback, which no neighbour enters; leave it out")
    hazard, gmfs = (at_site(hazard, site), gmfs) if gmfs is None else (hazard, at_site(gmfs, site))
    criterion = read_criterion(target, percentile, confidence, prefix="--")
    rate = read_target_rate(target_rate, hazard is not None, prefix="--")
    chosen = opened_results(results, select)
    if setback:
        amplitude = {"pga": read_optional("--pga", pga, PGA), "intensity_level": intensity_level}
        return _assess_setbacks(chosen, out, **criterion._asdict(), **amplitude)
    if not isinstance(chosen, Path) and [axis.name for axis in open_axes(chosen)] == [SAMPLE]:
        judged = read_optional("--gap", gap, GAP), read_optional("--pga", pga, PGA)
        if hazard is not None or gmfs is not None:
            option = "--gmfs" if hazard is None else "--hazard"
            raise PoundingError(
                f"{option}: is not joined with samples of uncertain numbers; choose one with --select sample=0"
            )
        return _assess_samples(
            chosen, out, figure, gap=judged[0], pga=judged[1], intensity=intensity, **criterion._asdict()
        )
    if not isinstance(chosen, Path) and open_axes(chosen):
        if hazard is not None or intensity is not None or gmfs is not None:
            check_settled(chosen, str(results))
        judged = read_optional("--gap", gap, GAP), read_optional("--pga", pga, PGA)
        amplitude = {"pga": judged[1], "intensity_level": intensity_level}
        return _assess_along(chosen, out, figure, gap=judged[0], **amplitude, **criterion._asdict())
    assessment = run(
        chosen,
        gap=read_optional("--gap", gap, GAP),
        hazard=hazard,
        **criterion._asdict(),
        intensity=intensity,
        pga=read_optional("--pga", pga, PGA),
        intensity_level=intensity_level,
        target_rate=rate,
        gmfs=gmfs,
    )
    # Files first: a reader of the first lines alone, such as `head`, ends the printing.
    if out is not None:
        write_text(out, json.dumps(assessment.as_dict(), ensure_ascii=False, indent=1) + "\n")
    draw(figure, "assess.assessment_figure", assessment)
    print_assessment(assessment)


def _assess_setbacks(results: Any, out: Path | None, **options: Any) -> None:
    """Print and write the setback from a property line that each building requires."""
    from dataclasses import asdict

    from pounding_risk.assessment.assess import plain
    from pounding_risk.assessment.required_gap import rounded_up
    from pounding_risk.assessment.setback import ASSUMED, setbacks

    found = setbacks(results, **options)
    if out is not None:
        facts = plain({"assumed": ASSUMED, "setbacks": [asdict(one) for one in found]})
        write_text(out, json.dumps(facts, ensure_ascii=False, indent=1) + "\n")
    first = found[0]
    print(f"Setback from a property line, {first.motions} motions {first.at}\n")
    heads = ("building", "of the motions", "setback", "bounds by recording")
    rows = [
        (
            one.building,
            f"{required.percentile:g} %",
            _length(rounded_up(required.gap)),
            f"{_length(required.low)} to {_length(required.high)}{'' if required.bounded else ' *'}",
        )
        for one in found
        for required in one.required
    ]
    print_table(heads, rows, "lrrr")
    if not all(required.bounded for one in found for required in one.required):
        print("* the upper one is the largest seen: so few recordings do not bound this percentile")
    print("\n".join(("", *(f"{sentence}." for sentence in ASSUMED))))


def _assess_samples(results: Any, out: Path | None, figure: Path | None, **options: Any) -> None:
    """Print what `uncertainty` says of a dataset whose cases lie along samples of uncertain numbers."""
    from pounding_risk.assessment.uncertain import uncertainty
    from pounding_risk.questions.uncertainty import sheet

    if out is not None:
        raise PoundingError(
            f"{out}: samples of uncertain numbers are written by `pounding-risk uncertainty RESULTS -o uncertainty.nc`"
        )
    assessed = uncertainty(results, **options)
    draw(figure, "uncertainty.uncertainty_figure", assessed)
    print_sheet(sheet(assessed))
    print("`pounding-risk uncertainty` has more of this; `--select sample=0` gives the whole assessment of one sample")


def _assess_along(results: Any, out: Path | None, figure: Path | None, **options: Any) -> None:
    """Print, write and draw contact and required gap at every place along the axes."""
    from pounding_risk.assessment.along import IDLE, OWN, along_finding, assess_along, idle_words

    assessed = assess_along(results, **options)
    table = assessed.to_dataframe().reset_index()
    if out is not None:
        rows = table.astype(object).where(table.notna(), None).to_dict("records")
        facts = dict(assessed.attrs) | {name: json.loads(assessed.attrs[name]) for name in (OWN, IDLE)}
        write_text(out, json.dumps(facts | {"places": rows}, ensure_ascii=False, indent=1) + "\n")
    draw(figure, "along.along_figure", assessed)
    print(f"{assessed.attrs['title']}\n{assessed.attrs['asked']}\n{along_finding(assessed)}.")
    idle = idle_words(assessed)
    print(f"{idle[0].upper()}{idle[1:]}.\n" if idle else "")
    keys = [str(name) for name in assessed.coords if name != "interface"]
    several = assessed.sizes["interface"] > 1
    heads = (*keys, *(["interface"] if several else []), "gap", "P(contact)", "bounds", "gap required", "bounds")
    rows = [_cells_along(row, keys, assessed, several) for row in table.to_dict("records")[:MOST_PLACES]]
    print_table(heads, rows, "l" * (len(keys) + several) + "rrrrr")
    if len(table) > MOST_PLACES:
        print(f"and {len(table) - MOST_PLACES} more; --out writes them all, --select chooses some")
    print(f"motions {assessed.attrs['motions']}; `--select` of one value along each axis gives the whole assessment")


def _cells_along(row: dict[str, Any], keys: list[str], assessed: Any, several: bool) -> tuple[str, ...]:
    """Cells of one place along the axes."""
    units = {key: str(assessed[key].attrs.get("units", "1")) for key in keys}
    values = [row[key] if isinstance(row[key], str) else engineering(row[key], units[key], 6) for key in keys]
    return (
        *values,
        *([str(row["interface"])] if several else []),
        _given_length(row["assessed_gap"]),
        _probability(row["contact_probability"]),
        f"{_probability(row['contact_probability_low'])} to {_probability(row['contact_probability_high'])}",
        _length(row["required_gap"]),
        f"{_length(row['required_gap_low'])} to {_length(row['required_gap_high'])}",
    )


def print_assessment(assessment: Assessment) -> None:
    """Print the verdict on each interface, and the tables that it rests on."""
    print(assessment.title)
    for interface in assessment.interfaces:
        for sentence in interface.columns:
            print(f"{interface.name}: {sentence}" if len(assessment.interfaces) > 1 else sentence)
    print(assessment.asked)
    print_notes(assessment.notes)
    if len(assessment.interfaces) > 1:
        print()
        _print_row(assessment)
    for interface in assessment.interfaces:
        print(f"\n{interface.name}\n\n{interface.verdict.sentence}\n")
        shown = interface.verdict.conclusion[len(interface.columns) :]  # columns stand at the top
        for sentence in (*shown, "", *interface.verdict.evidence):
            print(f"  {sentence}".rstrip())
        print(f"  In short: {interface.what_matters}.\n")
        _print_required_gaps(interface)
        _print_contact(interface, assessment.confidence)
        _print_yielding(interface, assessment)
        _print_response(interface)
        _print_sensitivity(interface)
        _print_fragilities(interface, assessment)
        _print_rates(interface, assessment)
        _print_scenario(interface, assessment)
        _print_gaps_for_rates(interface, assessment)
        _print_separations(interface, assessment.percentile)
    print_notes(assessment.unused_keys)


def _print_row(assessment: Assessment) -> None:
    """Print the verdicts of a row, one line an interface."""
    heads = ["neighbours", "gap", "verdict", "contact in", "P(contact)", f"gap of {assessment.percentile:g} %"]
    if assessment.target_rate is not None:
        heads += [f"for {assessment.target_rate_words}", "gap for it"]
    rows = []
    for interface in assessment.interfaces:
        share = interface.contact_at_gap()
        cells = (f"{share.count} of {share.runs}", _probability(share.probability))
        required = _length(interface.required_at(assessment.percentile).provided)
        by_rate = interface.rate_verdict
        rate = () if by_rate is None else (by_rate.word, _length(by_rate.required.gap))
        rows.append((interface.name, _given_length(interface.gap), interface.verdict.word, *cells, required, *rate))
    print_table(heads, rows, "lrlrrrlr"[: len(heads)])
    for sentence in assessment.unlike_verdicts:
        print(sentence)


def _print_required_gaps(interface: InterfaceAssessment) -> None:
    from pounding_risk.assessment.required_gap import NO_BOUND

    heads = ("gap required by", "by count", "bounds by recording", "lognormal", "the gap over it")
    rows = [
        (
            f"{required.percentile:g} % of the motions",
            _length(required.provided),
            required.bounds_words,
            _length(required.fitted),
            f"{interface.gap / required.gap:.2f}" if required.gap > 0.0 else "–",
        )
        for required in interface.required
    ]
    print_table(heads, rows, "lrrrr")
    for mark, words in NO_BOUND.items():
        if any(mark in required.bounds_words for required in interface.required):
            print(f"{mark} {words}")
    print()


def _print_contact(interface: InterfaceAssessment, confidence: float) -> None:
    heads = ("gap", "contact in", "P(contact)", f"{100 * confidence:g} % bounds", "by recording")
    rows = [(_given_length(share.gap), *_share_cells(share)) for share in _thinned_shares(interface)]
    print_table(heads, rows, "rrrrr")
    print("bounds take every motion for independent; those by recording count components and polarities together\n")


def _thinned_shares(interface: InterfaceAssessment) -> list[Any]:
    """Shares of contact from the widest gap that all motions close to the narrowest that none does, and at the gap."""
    shares = interface.contact
    partial = [number for number, share in enumerate(shares) if 0 < share.count < share.runs]
    first, last = (max(partial[0] - 1, 0), min(partial[-1] + 2, len(shares))) if partial else (0, len(shares))
    step = -(-(last - first) // MOST_GAPS)
    shown = {*range(first, last, step), last - 1}
    return [share for number, share in enumerate(shares) if number in shown or share.gap == interface.gap]


def _share_cells(share: Any) -> tuple[str, str, str, str]:
    """Cells of a share of the motions: count, probability, and bounds by motion and by recording."""
    return (
        f"{share.count} of {share.runs}",
        _probability(share.probability),
        f"{_probability(share.low)} to {_probability(share.high)}",
        f"{_probability(share.low_recordings)} to {_probability(share.high_recordings)}",
    )


def _print_yielding(interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Print the shares of the motions in which the force reaches F_E, at the gap of the yielding."""
    shares = [share for share in interface.yielding if share.gap == interface.yield_gap]
    if not shares:
        return
    print(f"The force reaches F_E, at a gap of {_given_length(interface.yield_gap)}\n")
    bounds = f"{100 * assessment.confidence:g} % bounds"
    heads = ("contact model", "F_E", "reached in", "P(yield)", bounds, "by recording", "excluded")
    rows = [
        (str(share.contact_model), _force(share.yield_force), *_share_cells(share), str(share.left_out or "–"))
        for share in shares
    ]
    print_table(heads, rows, "lrrrrrr")
    if len(assessment.interfaces) > 1:
        print("F_E is that of floors that meet; a column keeps its own, which `validate` shows of a scene")
    print(f"the scene's own F_E: {_level(interface.own_force, interface)}\n")


def _print_response(interface: InterfaceAssessment) -> None:
    """Print the response under each F_E: medians over the motions with contact, under the scene's contact model."""
    medians = [item for item in interface.response if item.contact_model == interface.own_model and item.motions]
    if not medians:
        return
    print(f"Response against F_E, at a gap of {_given_length(interface.yield_gap)}, under {interface.own_model}\n")
    words = {median.output: median.words for median in medians}
    rows = []
    for force in dict.fromkeys(median.yield_force for median in medians):
        of_force = {median.output: median for median in medians if median.yield_force == force}
        shown = (of_force.get(output) for output in words)  # none where no motion has a finite value of an output
        values = ("–" if median is None else engineering(median.median, median.unit, 3) for median in shown)
        rows.append((_level(force, interface), str(max(median.motions for median in of_force.values())), *values))
    print_table(("F_E", "contact in", *words.values()), rows, "r" * (2 + len(words)))
    own_force = _level(interface.own_force, interface)
    print(f"medians over the motions with contact, the larger of both buildings; the scene's own F_E: {own_force}\n")


def _print_sensitivity(interface: InterfaceAssessment) -> None:
    """Print the influence of each key of the grid on each output; outputs with the same words stand in one row."""
    outputs: dict[tuple[str, str], list[str]] = {}
    for influence in interface.sensitivity:
        outputs.setdefault((KEYS[influence.key], influence.words), []).append(influence.what)
    rows = [
        (key, names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more", words)
        for (key, words), names in outputs.items()
    ]
    print_table(("influence of", "on", "from one level to another"), rows, "lll")
    print()


def _print_fragilities(interface: InterfaceAssessment, assessment: Assessment) -> None:
    from pounding_risk.results.amplitudes import intensity_words

    median = f"median {intensity_words(assessment.intensity)}"
    heads = ("fragility of", "gap", "F_E", median, "dispersion", "s.e. ln median", "s.e. disp.", "by")
    curves = list(_shown_curves(interface))
    fitted = [_curve_cells(curve) for curve in curves if not curve.fault]
    if fitted:
        print_table(heads, fitted, "lrrrrrrl")
        print("standard errors: as if motions were independent, then by recording")
    for fault in dict.fromkeys(curve.fault for curve in curves if curve.fault):
        print(f"not fitted, {_curve_names(curve for curve in curves if curve.fault == fault)}: {fault}")
    print()


def _shown_curves(interface: InterfaceAssessment) -> Iterator[Fragility]:
    """The fragility of contact at the judged gap, and every fragility of yielding."""
    yield from (curve for curve in interface.fragility if curve.what == "contact" and curve.gap == interface.gap)
    yield from (curve for curve in interface.fragility if curve.what == "yield")


def _curve_names(curves: Iterable[Fragility]) -> str:
    """What the curves are of: contact, or yielding by contact model and F_E."""
    forces: dict[str, list[str]] = {}
    for curve in curves:
        forces.setdefault(_event(curve), []).append(_force(curve.yield_force))
    return "; ".join(event + (f" at F_E {', '.join(of)}" if of != ["–"] else "") for event, of in forces.items())


def _event(curve: Fragility | Rate | Scenario) -> str:
    """What a curve or rate is of: contact, or yielding under its contact model."""
    return f"yielding, {curve.contact_model}" if curve.what == "yield" else curve.what


def _curve_cells(curve: Fragility) -> tuple[str, ...]:
    times = "" if isnan(curve.factor) else f", times {curve.factor:.2g}"
    return (
        _event(curve),
        _given_length(curve.gap),
        _force(curve.yield_force),
        engineering(curve.median, curve.unit),
        f"{curve.dispersion:.3f}",
        f"{curve.se_median:.3f}, {curve.se_median_recordings:.3f}",
        f"{curve.se_dispersion:.3f}, {curve.se_dispersion_recordings:.3f}",
        f"{curve.method}{times}",
    )


def _print_rates(interface: InterfaceAssessment, assessment: Assessment) -> None:
    from pounding_risk.results.amplitudes import intensity_unit

    curves = {curve for curve in _shown_curves(interface) if not curve.fault}
    if not interface.rates or not curves:
        return
    heads = ("rate of", "gap", "F_E", "a year", "bounds", "in 50 years", "beyond the curve", "P at the weakest")
    rates = [rate for curve, rate in zip(interface.fragility, interface.rates, strict=True) if curve in curves]
    hazard = assessment.hazard_rows
    unit = intensity_unit(assessment.intensity)
    weakest, strongest = (engineering(intensity, unit) for intensity in (hazard[0][0], hazard[-1][0]))
    print(f"Annual rates by motions from {weakest} to {strongest}, the range of {assessment.hazard}")
    print(f"{assessment.hazard_reading}\n".lstrip())
    print_table(heads, [_rate_cells(rate) for rate in rates], "lrrrrrrr")
    if any(rate.at_least for rate in rates):
        print(f"at least: {AT_LEAST}")
    print("beyond the curve: share of failures past its ends, were it continued at the slope of its last rows;")
    print(f"stronger motions add at most {rates[0].above:.2g} a year, of weaker ones a curve says nothing")
    print("bounds carry the fragility's uncertainty from so few motions, and nothing of the hazard's own\n")


def _print_scenario(interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Print the probabilities in a scenario or an event set, where ground-motion fields are given."""
    known = [one for one in interface.scenario if not one.fault]
    shown = [one for one in known if one.what == "yield" or one.gap == interface.gap]
    if not shown:
        return
    from pounding_risk.results.amplitudes import intensity_words

    words = intensity_words(assessment.intensity)
    print(f"Probability in an event of {assessment.gmfs}, by its {words} at the site")
    print(f"{assessment.gmfs_reading}\n")
    heads = ("of", "gap", "F_E", "P in an event", f"{100 * assessment.confidence:g} % bounds", "by excluded events")
    rows = [
        (
            _event(one),
            _given_length(one.gap),
            _force(one.yield_force),
            _probability(one.probability),
            "–" if isnan(one.low) else f"{_probability(one.low)} to {_probability(one.high)}",
            "–" if isnan(one.left_out) else f"at most +{one.left_out:.2g}",
        )
        for one in shown
    ]
    print_table(heads, rows, "lrrrrr")
    print("bounds carry the fragility's uncertainty, that the events are a sample, and the excluded events:")
    print("events without a row at the site are below the engine's least intensity, and count as without failure\n")


def _print_gaps_for_rates(interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Print the gap that keeps contact to each usual rate and to the target, and why there is none."""
    from pounding_risk.assessment.rate_verdict import SHAPE

    gaps = interface.gaps_for_rates
    known = [_gap_cells(one, one.rate == assessment.target_rate) for one in gaps if not one.fault]
    if known:
        print(f"Gaps that keep contact to a rate under {assessment.hazard}\n")
        heads = ("contact no more often than", "a year", "gap", "bounds", "motions counted", "beyond the curve")
        print_table(heads, known, "lrrrrr")
        if any(one.at_least for one in gaps):
            print(f"at least: {AT_LEAST}")
        if not all(isnan(one.counted) for one in gaps):
            print("motions counted: each motion scaled until it closes the gap, without a lognormal curve")
            print(SHAPE)
    for fault in dict.fromkeys(one.fault for one in gaps if one.fault):
        print(f"no gap for {', '.join(one.words for one in gaps if one.fault == fault)}: {fault}")
    if gaps:
        print()


def _gap_cells(one: GapForRate, is_target: bool) -> tuple[str, ...]:
    from pounding_risk.assessment.rate_verdict import gap_bounds

    return (
        f"{one.words}{', the target' if is_target else ''}",
        f"{one.rate:.3g}",
        f"{'at least ' if one.at_least else ''}{_length(one.gap)}",
        gap_bounds(one),
        _length(one.counted),
        f"{100.0 * one.missing:.0f} %",
    )


def _rate_cells(rate: Rate) -> tuple[str, ...]:
    at_least = "at least " if rate.at_least else ""
    return (
        _event(rate),
        _given_length(rate.gap),
        _force(rate.yield_force),
        f"{at_least}{rate.annual:.3g}",
        "–" if isnan(rate.low) else f"{rate.low:.2g} to {rate.high:.2g}",
        f"{at_least}{_probability(rate.fifty_years)}",
        f"{100.0 * rate.missing:.0f} %",
        f"{rate.below:.2g}",
    )


def _print_separations(interface: InterfaceAssessment, percentile: float) -> None:
    """Print what the rules of building codes ask for, beside what the motions need."""
    from pounding_risk.assessment.separations.rules import FROM_MEMORY, ONE_GROUND, OWN_PEAKS, QUOTED_ONLY, SHARED

    comparisons = [comparison for comparison in interface.separations if comparison.middle is not None]
    if not comparisons:
        print("no motion closes any gap: what codes ask has nothing to be held against")
        return
    heads = ("code rule", "text", "required", "insufficient for", f"rule / {percentile:g} % gap", "gap / rule")
    required = interface.required_at(percentile).gap
    n_closing = len(interface.closing)
    rows = [
        (
            rule.row.title,
            rule.row.verification,
            _length(rule.upper),
            f"{round((rule.exceeded or 0.0) * n_closing)} of {n_closing}",
            f"{rule.upper / required:.2f}" if required > 0.0 and rule.upper is not None else "–",
            f"{interface.gap / rule.upper:.2f}" if rule.upper else "–",
            rule.row.superseded or "–",
        )
        for rule in comparisons
    ]
    print_table((*heads, "superseded by"), rows, "llrrrrl")
    print(f"required: no more in {percentile:g} % of the motions, {OWN_PEAKS};")
    print("insufficient for: motions that need more than the rule requires from them;")
    print("`separations` lists the clauses and who quotes them, and applies the rules to design displacements")
    for note in (FROM_MEMORY, QUOTED_ONLY, ONE_GROUND):
        if any(note in rule.row.note for rule in comparisons):
            print(f"{SHARED[note]}.")


def _force(value: float | None) -> str:
    """A yield force; where it is infinite only columns yield, at their own."""
    if value is None:
        return "–"
    return engineering(value, "N") if isfinite(value) else COLUMNS


def _level(force: float, interface: InterfaceAssessment) -> str:
    """A yield force of the grid, in the digits in which it was given; where it is infinite, whether columns yield."""
    if isfinite(force):
        return engineering(force, "N", GIVEN_DIGITS)
    return COLUMNS if any(share.yield_force == force for share in interface.yielding) else "no yielding"


def _given_length(value: float) -> str:
    """A length in the digits in which it was given."""
    return engineering(value, "m", GIVEN_DIGITS)


def _length(value: float | None) -> str:
    return "–" if value is None or isnan(value) else engineering(value, "m", 3)


def _probability(value: float) -> str:
    return "–" if isnan(value) else f"{value:.3f}"
