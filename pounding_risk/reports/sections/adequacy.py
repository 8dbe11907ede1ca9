"""Is the gap enough: probabilities against the gap, the gap needed, what codes ask, fragility, rates, influences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.required_gap import contact_steps
from pounding_risk.assessment.separations.rules import FROM_MEMORY, QUOTED_ONLY, SHARED
from pounding_risk.figures.report import (
    Curve,
    Judged,
    Line,
    Ratio,
    Stripe,
    report_contact,
    report_fragility,
    report_probabilities,
    report_rules,
    svg_text,
)
from pounding_risk.figures.style import RULE_MARKS_WORDS
from pounding_risk.reports.blocks import (
    KEPT,
    MISSING,
    Block,
    Cell,
    amount,
    between,
    count,
    evenly,
    figure,
    head,
    heading,
    listing,
    name_of,
    number,
    paragraph,
    strength,
    table,
)
from pounding_risk.reports.material import Material, Pair
from pounding_risk.results.amplitudes import intensity_words

MOST_LINES = 5  # of one figure
MOST_CURVES = 3  # of contact, and as many of yielding
SHARES = [("motions", "r"), ("probability [%]", "r"), ("bounds [%]", "r"), ("bounds by recording [%]", "r")]
SHARE_LINE = ("gap", "probability", "low_recordings", "high_recordings")  # what is drawn of a share
ACCELERATION = "m/s2"


def adequacy(material: Material) -> list[Block]:
    """Each interface in turn: contact, the gap needed, codes, yielding, fragility, rates, and what sways it."""
    blocks = [paragraph(_terms(material))]
    for pair in material.pairs:
        if len(material.pairs) > 1:
            blocks.append(heading(pair.name, pair.anchor))
        for part in (contact, required, codes, yielding, fragility, rates, influences):
            blocks += part(material, pair)
    return blocks


def _terms(material: Material) -> str:
    """What a motion and its bounds are."""
    confidence = f"{100 * material.assessment.confidence:g} %"
    decides = (
        "Whether there is contact follows from the motion without contact alone, whatever the contact model and F_E."
    )
    if material.is_row:
        decides = (
            "A motion counts as contact where it closes the gap by itself, or where contact elsewhere in the row made "
            "the buildings touch in a run, under any contact model and F_E. The F_E told is that of floors that meet; "
            "a column keeps its own, which stands with the scene."
        )
    return (
        f"A motion is a record in one polarity. Bounds are exact binomial ones of {confidence}; those by recording "
        f"take the components and polarities of a recording for as many as they really stand for. {decides}"
    )


def contact(material: Material, pair: Pair) -> list[Block]:
    """Probability of contact against the gap: figure and table."""
    shares, asked = pair.found.contact, material.assessment
    heads = [(head("gap", "m"), "r"), ("with contact", "r"), *SHARES]
    rows = [[number(each.gap, "m"), *_counted(each)] for each in shares]
    closing, judged = np.array(pair.found.closing), _judged(material, pair)
    steps = contact_steps(closing, pair.found.verdict.independent / closing.size, asked.confidence)
    target, gap = number(asked.target, "%")["text"], amount(judged.required, "m")["text"]
    caption = f"{pair.name}: probability of contact against the gap{pair.at}"
    said = (
        f"{caption}: a step down at what each of the {counted(closing.size, 'motion')} closes, known at every gap; "
        f"its bounds by "
        f"recording; the target of {target} % and the gap required by {judged.percentile:g} % of the motions, {gap}"
    )
    return [
        figure(
            f"{pair.anchor}-contact",
            svg_text(report_contact(steps, judged)),
            f"{said}.",
            f"{said}; {_counted(pair.found.contact_at_gap())[2]['text']} % at the assessed gap.",
        ),
        table(
            f"{pair.name}: motions with contact against the gap{pair.at}.",
            heads,
            rows,
            keep=_near(shares, pair.found.gap),
        ),
    ]


def _judged(material: Material, pair: Pair) -> Judged:
    """What P(contact) is held against, with the gap required for the target."""
    criterion = material.assessment.criterion
    required = pair.found.required_at(criterion.target_percentile)
    bounds = (required.low, required.high, required.bounded)
    return Judged(pair.found.gap, criterion.target, required.percentile, required.gap, *bounds)


def _counted(one: Any) -> list[Cell]:
    """Count, runs, probability and both bounds of a share, as the columns of `SHARES`."""
    bounds = [(one.low, one.high), (one.low_recordings, one.high_recordings)]
    shown = [between(*ends, "%", 3) for ends in bounds]
    return [count(one.count), count(one.runs), number(one.probability, "%", 3), *shown]


def _line(words: str, shares: Sequence[Any]) -> Line:
    columns = [[getattr(each, name) for each in shares] for name in SHARE_LINE]
    return Line(words, *columns)


def _near(shares: Sequence[Any], gap: float) -> list[int]:
    """Rows spread evenly over the gaps, and the one nearest to the assessed gap."""
    nearest = min(range(len(shares)), key=lambda place: abs(shares[place].gap - gap))
    return sorted({*evenly(len(shares), KEPT - 1), nearest})


def required(material: Material, pair: Pair) -> list[Block]:
    """The gap that percentiles of the motions need, with their bounds."""
    heads = [("motions that it suffices for [%]", "r"), (head("gap", "m"), "r"), (head("bounds", "m"), "r")]
    heads += [(head("of a lognormal fit", "m"), "r"), ("", "l")]
    rows = [
        [
            number(each.percentile),
            number(each.gap, "m"),
            between(each.low, each.high, "m"),
            number(each.fitted, "m"),
            "" if each.bounded else "so few recordings give no upper bound: the largest seen",
        ]
        for each in pair.found.required
    ]
    return [
        table(f"{pair.name}: gap needed, by {counted(len(pair.found.closing), 'motion')} without contact.", heads, rows)
    ]


def codes(material: Material, pair: Pair) -> list[Block]:
    """What each rule asks, motion by motion, over the gap that the motion needs."""
    found = pair.codes
    upper = f"{found.percentile:g} %"
    heads = [
        ("rule", "l"),
        ("clause", "l"),
        ("text of the clause", "l"),
        (head("median", "m"), "r"),
        (head(upper, "m"), "r"),
    ]
    heads += [("over the gap needed: median (16 to 84 %)", "r"), ("falls short in", "r"), ("note", "l")]
    common = _common([each.row.note for each in found.rules if each.row.separation is not None])
    rows = [_rule(each, found.motions, common) for each in found.rules]
    drawn = [_ratio(each) for each in found.rules if each.ratio_median is not None]
    caption = f"{pair.name}: what rules ask over the gap that the same motion needs"
    blocks = [
        paragraph(" ".join([f"{found.finding}.", *(f"Everywhere {each}." for each in common), *_doubts(found.rules)])),
        table(f"{pair.name}: separations that rules ask, from the displacements of the same motions.", heads, rows),
    ]
    if drawn:
        motions = counted(found.motions, "motion")
        said = f"{caption}: median and middle 68 % of {motions}; safe right of 1; {RULE_MARKS_WORDS}"
        blocks.insert(
            1, figure(f"{pair.anchor}-rules", svg_text(report_rules(drawn)), f"{said}.", f"{said}. {found.finding}.")
        )
    return blocks


def _doubts(rules: Sequence[Any]) -> list[str]:
    """What to think of clauses that were not read, where there are such."""
    return [f"{SHARED[note]}." for note in (FROM_MEMORY, QUOTED_ONLY) if any(note in each.row.note for each in rules)]


def _ratio(one: Any) -> Ratio:
    """A rule as it is drawn."""
    return Ratio(one.row.title, one.ratio_low, one.ratio_median, one.ratio_high, one.row.verification)


def _common(notes: Sequence[str]) -> list[str]:
    """What every note says, so that it is said once."""
    said = [note.split("; ") for note in notes]
    return [each for each in said[0] if all(each in others for others in said)] if said else []


def _rule(one: Any, motions: int, common: Sequence[str]) -> list[Cell | str]:
    row = one.row
    facts: list[Cell | str] = [row.title, row.clause, row.verification]
    told = {*common, FROM_MEMORY, QUOTED_ONLY}  # below the table, and in its column of texts
    note = "; ".join(each for each in row.note.split("; ") if each not in told) or MISSING
    if one.exceeded is None:
        return [*facts, number(_or_nan(row.separation), "m"), MISSING, MISSING, MISSING, note]
    ratio = [number(each, digits=3) for each in (one.ratio_median, one.ratio_low, one.ratio_high)]
    shown = {
        "text": f"{ratio[0]['text']} ({ratio[1]['text']} to {ratio[2]['text']})",
        "parts": [each["raw"] for each in ratio],
    }
    short = round(one.exceeded * motions)
    counted = {"text": f"{short} of {motions}", "parts": [short, motions]}
    return [*facts, number(one.middle, "m"), number(one.upper, "m"), shown, counted, note]


def _model(one: Any) -> str:
    """The contact model that a result is of; contact itself depends on none."""
    return name_of(one.contact_model) if one.contact_model else "any"


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else value


def yielding(material: Material, pair: Pair) -> list[Block]:
    """Probability of reaching the yield force against the gap, and by F_E and model at the grid's nearest gap."""
    found, gap = pair.found.yielding, pair.found.yield_gap
    if not found:
        return []
    forces = sorted({_or_nan(each.yield_force) for each in found})
    lines = []
    for force in (forces[place] for place in evenly(len(forces), MOST_LINES)):
        mine = [each for each in found if each.yield_force == force and each.contact_model == material.law]
        lines.append(_line(f"$F_E$ {strength(force, unit=True)['text']}", mine))
    caption = f"{pair.name}: probability that the contact force reaches F_E{pair.at}, under {name_of(material.law)}"
    heads = [("contact model", "l"), (head("F_E", "N"), "r"), ("reach it", "r"), *SHARES]
    here = [each for each in found if each.gap == gap]
    rows = [[_model(each), strength(each.yield_force), *_counted(each)] for each in here]
    at = f"{pair.name}: probability of reaching F_E at a gap of {amount(gap, 'm')['text']}{pair.at}."
    return [
        figure(
            f"{pair.anchor}-yielding",
            svg_text(report_probabilities(lines, pair.found.gap, "probability of reaching $F_E$")),
            f"{caption}.",
            f"{caption}, against the gap, for {len(lines)} yield forces; the table has the numbers at one gap.",
        ),
        table(at, heads, rows, keep=_of_law(here, material.law), note="some of the scene's own contact model"),
    ]


def _of_law(shares: Sequence[Any], law: str) -> list[int]:
    """Rows of one contact model, evenly spread."""
    mine = [place for place, each in enumerate(shares) if each.contact_model == law]
    return [mine[place] for place in evenly(len(mine), KEPT)]


def fragility(material: Material, pair: Pair) -> list[Block]:
    """Lognormal fragilities: curves and stripes, and the table of medians and dispersions with standard errors."""
    found = [each for each in pair.found.fragility if np.isfinite(each.median) and np.isfinite(each.dispersion)]
    refused = _not_fitted(pair)
    if not found:
        return refused
    heads = [("of", "l"), (head("gap", "m"), "r"), ("contact model", "l"), (head("F_E", "N"), "r")]
    heads += [(head("median", ACCELERATION), "r"), ("error of its ln; by recording", "r"), ("dispersion", "r")]
    heads += [("its error; by recording", "r"), ("from", "l")]
    rows = [_fitted(each) for each in found]
    words = intensity_words(material.assessment.intensity)
    drawn = _drawn(found, material.law, pair.found)
    curves = [
        Curve(_what(each), each.median, each.dispersion, _stripes(each), each.what == "contact") for each in drawn
    ]
    caption = f"{pair.name}: lognormal fragility against {words}; rings are shares of the motions"
    drawing = svg_text(report_fragility(curves, f"{words} [g]"))
    keep = sorted(found.index(each) for each in drawn)
    note = "those of the figure"
    return [
        figure(
            f"{pair.anchor}-fragility", drawing, f"{caption}.", f"{caption}; the table has medians and dispersions."
        ),
        table(f"{pair.name}: fragility against {words}, by maximum likelihood.", heads, rows, keep=keep, note=note),
        *refused,
    ]


def _not_fitted(pair: Pair) -> list[Block]:
    """Which curves there are none of, and why: contact at the judged gap, yielding, and at how many other gaps."""
    faults: dict[str, list[str]] = {}
    others = 0
    for each in pair.found.fragility:
        if each.fault and each.what == "contact" and each.gap != pair.found.gap:
            others += 1
        elif each.fault:
            model = f" under {name_of(each.contact_model)}" if each.contact_model else ""
            faults.setdefault(each.fault, []).append(f"{_what(each)}{model}".replace("$F_E$", "F_E"))
    told = [f"{'; '.join(which)}: {fault}." for fault, which in faults.items()]
    if others:
        told.append(f"contact at {others} other gap{'s' * (others > 1)}: `assess -o` writes the reason of each.")
    return [paragraph(f"{pair.name}, not fitted:"), listing(told)] if told else []


def _fitted(one: Any) -> list[Cell | str]:
    return [
        one.what,
        number(one.gap, "m"),
        _model(one),
        strength(one.yield_force),
        number(one.median, ACCELERATION),
        _error(one.se_median, one.se_median_recordings),
        number(one.dispersion, digits=3),
        _error(one.se_dispersion, one.se_dispersion_recordings),
        one.method,
    ]


def _error(plain: float, clustered: float) -> Cell:
    cells = [number(each, digits=2) for each in (plain, clustered)]
    return {"text": f"{cells[0]['text']}; {cells[1]['text']}", "parts": [cell["raw"] for cell in cells]}


def _drawn(found: Sequence[Any], law: str, one: Any) -> list[Any]:
    """Some curves of contact, that of the assessed gap among them, and some of yielding under the scene's law."""
    touching = [each for each in found if each.what == "contact"]
    yields = [each for each in found if each.what != "contact" and each.contact_model == law]
    own = [each for each in touching if each.gap == one.gap]
    some = [touching[place] for place in evenly(len(touching), MOST_CURVES)] if touching else []
    chosen = {id(each): each for each in [*own, *some][:MOST_CURVES]}
    chosen |= {id(each): each for each in (yields[place] for place in evenly(len(yields), MOST_CURVES))}
    return [each for each in found if id(each) in chosen] or list(found[:MOST_CURVES])


def _what(one: Any) -> str:
    gap = f"{one.what}, gap {amount(one.gap, 'm')['text']}"
    return gap if one.yield_force is None else f"{gap}, $F_E$ {strength(one.yield_force, unit=True)['text']}"


def _stripes(one: Any) -> list[Stripe]:
    return [Stripe(each.im, each.count, each.runs) for each in one.stripes]


def rates(material: Material, pair: Pair) -> list[Block]:
    """Annual rate and 50-year probability, where a hazard curve is given."""
    found = [each for each in pair.found.rates if np.isfinite(each.annual)]
    if not found:
        return []
    heads = [("of", "l"), (head("gap", "m"), "r"), ("contact model", "l"), (head("F_E", "N"), "r")]
    heads += [("a year", "r"), ("bounds", "r"), ("in 50 years [%]", "r"), ("P at the weakest [%]", "r")]
    heads += [("left out [%]", "r")]
    rows: list[list[Cell | str]] = [
        [
            each.what,
            number(each.gap, "m"),
            _model(each),
            strength(each.yield_force),
            _at_least(number(each.annual, digits=3), each),
            between(each.low, each.high, "1", 3),
            _at_least(number(each.fifty_years, "%", 3), each),
            number(each.below, "%", 2),
            number(each.missing, "%", 2),
        ]
        for each in found
    ]
    source, curve = material.assessment.hazard, material.assessment.hazard_rows
    weakest, strongest = (amount(im, ACCELERATION)["text"] for im in (curve[0][0], curve[-1][0]))
    stronger = number(curve[-1][1], digits=3)["text"]
    least = "Where a rate is at least so much, the curve ends where failures do not. " if _any_cut(found) else ""
    told = (
        f"Rates count motions from {weakest} to {strongest}, the range of the curve. {least}Left out is the share of "
        "the failures beyond the curve's ends, were it continued at the slope of its last rows; stronger motions add "
        f"at most {stronger} a year, and of weaker ones the curve says nothing. Bounds carry the fragility's standard "
        "errors and nothing of the curve's own uncertainty."
    )
    return [table(f"{pair.name}: annual rate under the hazard curve {source}.", heads, rows), paragraph(told)]


def _at_least(cell: Cell, rate: Any) -> Cell:
    """A number of a rate, and whether it is a lower bound alone."""
    return {**cell, "text": f"at least {cell['text']}"} if rate.at_least else cell


def _any_cut(rates: Sequence[Any]) -> bool:
    return any(each.at_least for each in rates)


def influences(material: Material, pair: Pair) -> list[Block]:
    """What the verdict depends on: polarity, F_E, contact model."""
    found = pair.found.sensitivity
    if not found:
        return []
    told = (f"{each.what}, by {name_of(each.key)}: {each.words}." for each in found)
    return [
        heading("What sways it", f"{pair.anchor}-influences"),
        paragraph(f"{pair.found.what_matters[:1].upper()}{pair.found.what_matters[1:]}."),
        listing(told),
    ]
