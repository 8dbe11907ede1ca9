"""The command `assess`: the verdict on each gap with its evidence, and the tables behind it."""

from __future__ import annotations

import json
from math import isnan
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
    from pounding_risk.assessment.assess import Assessment

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
    from pounding_risk.cli.uncertainty import print_uncertainty

    if out is not None:
        raise PoundingError(
            f"{out}: samples of uncertain numbers are written by `pounding-risk uncertainty RESULTS -o uncertainty.nc`"
        )
    assessed = uncertainty(results, **options)
    draw(figure, "uncertainty.uncertainty_figure", assessed)
    print_uncertainty(assessed)
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
    from pounding_risk.questions import adequacy as question
    from pounding_risk.questions import rates
    from pounding_risk.questions.rules import rules
    from pounding_risk.render.sheet import paragraph

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
        parts = [
            *question.required_gaps(interface),
            *question.contact(assessment, interface),
            *question.yielding(assessment, interface),
            *question.response(interface),
            *question.influences(interface),
            *question.fragilities(assessment, interface),
            *([paragraph(assessment.hazard_reading)] if assessment.hazard_reading and interface.rates else []),
            *rates.annual_rates(assessment, interface),
            *rates.scenario(assessment, interface),
            *rates.gaps_for_rates(assessment, interface),
        ]
        print_sheet([*parts, *rules(assessment.percentile, interface)])
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


def _given_length(value: float) -> str:
    """A length in the digits in which it was given."""
    return engineering(value, "m", GIVEN_DIGITS)


def _length(value: float | None) -> str:
    return "–" if value is None or isnan(value) else engineering(value, "m", 3)


def _probability(value: float) -> str:
    return "–" if isnan(value) else f"{value:.3f}"
