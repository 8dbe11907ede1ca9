"""What `assess` prints: the verdict with its evidence, and the tables behind it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli.options import (
    FIGURES,
    Amplitude,
    Confidence,
    Figure,
    Hazard,
    Intensity,
    JudgedGap,
    Percentile,
    Target,
    read_option,
    writable,
)
from pounding_risk.cli.tables import draw, engineering, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
    from pounding_risk.assessment.fragility import Fragility
    from pounding_risk.assessment.hazard import Rate

MOST_GAPS = 12  # rows of the table of gaps; more are thinned evenly
OWN = 6  # digits of what a user has asked for
AT_LEAST = "the hazard curve ends where failures do not; give one that reaches further"
COLUMNS = "columns' own"
KEYS = {"yield_force": "F_E", "contact_model": "contact model", "polarity": "polarity"}


def assess(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="Dataset of a scan (.nc or .zarr).", show_default=False)
    ],
    gap: JudgedGap = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    intensity: Intensity = None,
    pga: Amplitude = None,
    hazard: Hazard = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write it all (.json).", show_default=False)] = None,
    figure: Figure = None,
) -> None:
    """Is this gap enough? Probabilities, required gaps, a verdict."""
    out_file, figure_file = writable("-o", out, (".json",)), writable("--figure", figure, FIGURES)
    from pounding_risk.assessment.assess import assess as run
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.units import GAP, PGA

    criterion = read_criterion(target, percentile, confidence, prefix="--")
    found = run(
        results,
        gap=None if gap is None else read_option("--gap", gap, GAP),
        hazard=hazard,
        **criterion._asdict(),
        intensity=intensity,
        pga=None if pga is None else read_option("--pga", pga, PGA),
    )
    # Files first: whoever reads only the head of the tables ends the printing.
    if out_file is not None:
        _write(found, out_file)
    if figure_file is not None:
        from pounding_risk.figures.assess import assessment_figure

        draw(assessment_figure(found), figure_file)
    print_assessment(found)


def _write(found: Assessment, target: Path) -> None:
    """Write an assessment as JSON."""
    from pounding_risk._common.files import write_whole

    text = json.dumps(found.as_dict(), ensure_ascii=False, indent=1) + "\n"
    try:
        write_whole(target, lambda file: file.write(text.encode()))
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    print(f"written: {target}")


def print_assessment(found: Assessment) -> None:
    """The verdict on each interface, and the tables that it rests on."""
    from pounding_risk.cli.print_runs import print_notes

    print(found.title)
    print(found.asked)
    print_notes(found.notes)
    if len(found.interfaces) > 1:
        print()
        _print_row(found)
    for one in found.interfaces:
        print(f"\n{one.name}\n\n{one.verdict.sentence}\n")
        for sentence in (*one.verdict.conclusion, "", *one.verdict.evidence):
            print(f"  {sentence}".rstrip())
        print(f"  In short: {one.what_matters}.\n")
        _print_required(one)
        _print_contact(one, found.confidence)
        _print_yielding(one, found)
        _print_response(one)
        _print_influences(one)
        _print_curves(one, found)
        _print_rates(one, found)
        _print_separations(one, found.percentile)
    for sentence in found.unused_keys:
        print(f"note: {sentence}")


def _print_row(found: Assessment) -> None:
    """The verdicts of a row, one line an interface."""
    heads = ("neighbours", "gap", "verdict", "contact in", "P(contact)", f"gap of {found.percentile:g} %")
    rows = []
    for one in found.interfaces:
        here = one.contact_at_gap()
        needed = next(each.gap for each in one.required if each.percentile == found.percentile)
        shares = (f"{here.count} of {here.runs}", _part(here.probability))
        rows.append((one.name, _own_length(one.gap), one.verdict.word, *shares, _length(needed)))
    print_table(heads, rows, "lrlrrr")


def _print_required(one: InterfaceAssessment) -> None:
    heads = ("gap required by", "of the sample", "bounds by recording", "lognormal", "the gap over it")
    rows = [
        (
            f"{each.percentile:g} % of the motions",
            _length(each.gap),
            f"{_length(each.low)} to {_length(each.high)}{'' if each.bounded else ' *'}",
            _length(each.fitted),
            f"{one.gap / each.gap:.2f}" if each.gap > 0.0 else "–",
        )
        for each in one.required
    ]
    print_table(heads, rows, "lrrrr")
    if not all(each.bounded for each in one.required):
        print("* the upper one is the largest seen: so few recordings do not bound this percentile")
    print()


def _print_contact(one: InterfaceAssessment, confidence: float) -> None:
    heads = ("gap", "contact in", "P(contact)", f"{100 * confidence:g} % bounds", "by recording")
    rows = [(_own_length(each.gap), *_share(each)) for each in _thinned(one)]
    print_table(heads, rows, "rrrrr")
    print("bounds take every motion for independent; those by recording count components and polarities together\n")


def _thinned(one: InterfaceAssessment) -> list[Any]:
    """The shares at some of the gaps, from the widest that all close to the narrowest that none does, and the gap's."""
    some = [place for place, each in enumerate(one.contact) if 0 < each.count < each.runs]
    first, last = (max(some[0] - 1, 0), min(some[-1] + 2, len(one.contact))) if some else (0, len(one.contact))
    step = -(-(last - first) // MOST_GAPS)
    kept = {*range(first, last, step), last - 1}
    return [each for place, each in enumerate(one.contact) if place in kept or each.gap == one.gap]


def _share(each: Any) -> tuple[str, str, str, str]:
    return (
        f"{each.count} of {each.runs}",
        _part(each.probability),
        f"{_part(each.low)} to {_part(each.high)}",
        f"{_part(each.low_recordings)} to {_part(each.high_recordings)}",
    )


def _print_yielding(one: InterfaceAssessment, found: Assessment) -> None:
    shown = [each for each in one.yielding if each.gap == one.yield_gap]
    if not shown:
        return
    print(f"The force reaches F_E, at a gap of {_own_length(one.yield_gap)}\n")
    heads = (
        "contact model",
        "F_E",
        "reached in",
        "P(yield)",
        f"{100 * found.confidence:g} % bounds",
        "by recording",
        "left out",
    )
    rows = [
        (str(each.contact_model), _force(each.yield_force), *_share(each), str(each.left_out or "–")) for each in shown
    ]
    print_table(heads, rows, "lrrrrrr")
    if len(found.interfaces) > 1:
        print("F_E is that of floors that meet; a column keeps its own, which `validate` shows of a scene")
    print(f"the scene's own F_E: {_own(one)}\n")


def _print_response(one: InterfaceAssessment) -> None:
    """What the motions do under each F_E: medians over those with contact, under the scene's own contact model."""
    shown = [each for each in one.response if each.contact_model == one.own_model and each.motions]
    if not shown:
        return
    print(f"Response against F_E, at a gap of {_own_length(one.yield_gap)}, under {one.own_model}\n")
    outputs = list(dict.fromkeys(each.output for each in shown))
    words = {each.output: each.words for each in shown}
    rows = []
    for force in dict.fromkeys(each.yield_force for each in shown):
        here = {each.output: each for each in shown if each.yield_force == force}
        values = (engineering(here[output].median, here[output].unit, 3) for output in outputs)
        rows.append((_level(force), str(max(each.motions for each in here.values())), *values))
    print_table(("F_E", "contact in", *(words[output] for output in outputs)), rows, "r" * (2 + len(outputs)))
    print(f"medians over the motions with contact, the larger of both buildings; the scene's own F_E: {_own(one)}\n")


def _own(one: InterfaceAssessment) -> str:
    """The grid's F_E that is the scene's own, or nearest to it."""
    return _level(one.own_force)


def _level(force: float) -> str:
    """A level of F_E of the grid."""
    return engineering(force, "N", OWN) if isfinite(force) else "no yielding"


def _print_influences(one: InterfaceAssessment) -> None:
    on: dict[tuple[str, str], list[str]] = {}
    for each in one.sensitivity:
        on.setdefault((KEYS[each.key], each.words), []).append(each.what)
    # What one sentence answers for all alike, such as a key of one level, stands in one row.
    rows = [
        (key, what[0] if len(what) == 1 else f"{what[0]} and {len(what) - 1} more", words)
        for (key, words), what in on.items()
    ]
    print_table(("influence of", "on", "from one level to another"), rows, "lll")
    print()


def _print_curves(one: InterfaceAssessment, found: Assessment) -> None:
    from pounding_risk.results.amplitudes import intensity_words

    heads = (
        "fragility of",
        "gap",
        "F_E",
        f"median {intensity_words(found.intensity)}",
        "dispersion",
        "s.e. ln median",
        "s.e. disp.",
        "by",
    )
    shown = list(_curves(one))
    fitted = [_curve(each) for each in shown if not each.fault]
    if fitted:
        print_table(heads, fitted, "lrrrrrrl")
        print("standard errors: as if motions were independent, then by recording")
    for fault in dict.fromkeys(each.fault for each in shown if each.fault):
        print(f"not fitted, {_named(each for each in shown if each.fault == fault)}: {fault}")
    print()


def _curves(one: InterfaceAssessment) -> Iterator[Fragility]:
    """Of contact that at the judged gap, and every one of yielding."""
    yield from (each for each in one.fragility if each.what == "contact" and each.gap == one.gap)
    yield from (each for each in one.fragility if each.what == "yield")


def _named(curves: Iterable[Fragility]) -> str:
    """Which curves: contact, or yielding by contact model and F_E."""
    forces: dict[str, list[str]] = {}
    for each in curves:
        forces.setdefault(_what(each), []).append(_force(each.yield_force))
    return "; ".join(what + (f" at F_E {', '.join(own)}" if own != ["–"] else "") for what, own in forces.items())


def _what(each: Fragility | Rate) -> str:
    """Contact, or yielding under its contact model."""
    return f"yielding, {each.contact_model}" if each.what == "yield" else each.what


def _curve(each: Fragility) -> tuple[str, ...]:
    times = "" if isnan(each.factor) else f", times {each.factor:.2g}"
    return (
        _what(each),
        _own_length(each.gap),
        _force(each.yield_force),
        engineering(each.median, "m/s2"),
        f"{each.dispersion:.3f}",
        f"{each.se_median:.3f}, {each.se_median_recordings:.3f}",
        f"{each.se_dispersion:.3f}, {each.se_dispersion_recordings:.3f}",
        f"{each.method}{times}",
    )


def _print_rates(one: InterfaceAssessment, found: Assessment) -> None:
    shown = {each for each in _curves(one) if not each.fault}
    if not one.rates or not shown:
        return
    heads = ("rate of", "gap", "F_E", "a year", "bounds", "in 50 years", "left out", "P at the weakest")
    rates = [rate for each, rate in zip(one.fragility, one.rates, strict=True) if each in shown]
    weakest, strongest = (engineering(im, "m/s2") for im in (found.hazard_rows[0][0], found.hazard_rows[-1][0]))
    print(f"Annual rates by motions from {weakest} to {strongest}, the range of {found.hazard}\n")
    print_table(heads, [_rate(each) for each in rates], "lrrrrrrr")
    if any(each.at_least for each in rates):
        print(f"at least: {AT_LEAST}")
    print("left out: the share of failures beyond the curve's ends, were it continued at the slope of its last rows;")
    print(f"stronger motions add at most {rates[0].above:.2g} a year, of weaker ones a curve says nothing")
    print("bounds carry the fragility's standard errors, the larger ones, and none of the hazard's\n")


def _rate(rate: Rate) -> tuple[str, ...]:
    least = "at least " if rate.at_least else ""
    return (
        _what(rate),
        _own_length(rate.gap),
        _force(rate.yield_force),
        f"{least}{rate.annual:.3g}",
        "–" if isnan(rate.low) else f"{rate.low:.2g} to {rate.high:.2g}",
        f"{least}{_part(rate.fifty_years)}",
        f"{100.0 * rate.missing:.0f} %",
        f"{rate.below:.2g}",
    )


def _print_separations(one: InterfaceAssessment, percentile: float) -> None:
    from pounding_risk.assessment.separations.rules import FROM_MEMORY, ONE_GROUND, QUOTED_ONLY, SHARED

    rows = [each for each in one.separations if each.middle is not None]
    if not rows:
        print("no motion closes any gap: what codes ask has nothing to be held against")
        return
    heads = ("code rule", "text", "asks for", "short in", f"over the gap of {percentile:g} %", "the gap over it")
    needed = next(each.gap for each in one.required if each.percentile == percentile)
    lines = [
        (
            each.row.title,
            each.row.verification,
            _length(each.upper),
            f"{round((each.exceeded or 0.0) * len(one.closing))} of {len(one.closing)}",
            f"{each.upper / needed:.2f}" if needed > 0.0 and each.upper is not None else "–",
            f"{one.gap / each.upper:.2f}" if each.upper else "–",
            each.row.superseded or "–",
        )
        for each in rows
    ]
    print_table((*heads, "superseded by"), lines, "llrrrrl")
    print(f"asks for: no more in {percentile:g} % of the motions, from their own displacements; short in: motions that")
    print("need more than it asks for from them; `separations` lists the clauses and who quotes them")
    for note in (FROM_MEMORY, QUOTED_ONLY, ONE_GROUND):
        if any(note in each.row.note for each in rows):
            print(f"{SHARED[note]}.")


def _force(value: float | None) -> str:
    """A yield force; where floors never yield, columns may, at their own."""
    if value is None:
        return "–"
    return engineering(value, "N") if isfinite(value) else COLUMNS


def _own_length(value: float) -> str:
    """A length that a user has asked for, in the digits that it was asked with."""
    return engineering(value, "m", OWN)


def _length(value: float | None) -> str:
    return "–" if value is None or isnan(value) else engineering(value, "m", 3)


def _part(value: float) -> str:
    return "–" if isnan(value) else f"{value:.3f}"
