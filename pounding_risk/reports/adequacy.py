"""Is the gap enough: verdicts, probabilities against the gap, the gap needed, fragility, rates, what codes ask."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pounding_risk.figures_report import (
    Curve,
    Line,
    Mark,
    Stripe,
    report_fragility,
    report_probabilities,
    report_required,
    svg_text,
)
from pounding_risk.reports.content import (
    Block,
    Cell,
    amount,
    between,
    evenly,
    facts,
    figure,
    head,
    heading,
    listing,
    name_of,
    number,
    paragraph,
    table,
)
from pounding_risk.reports.material import Material

MOST_LINES = 5  # of one figure
MOST_MARKS = 5


def summary(material: Material) -> list[Block]:
    """The verdict on each interface, with the numbers behind it, and what to keep in mind."""
    found = material.assessment
    blocks: list[Block] = []
    for each in found.interfaces:
        blocks.append(verdict_of(each))
        blocks.append(facts(f"{each.name}: the numbers behind the verdict.", _key_numbers(each)))
    caveats = _caveats(material)
    if caveats:
        blocks += [heading("To keep in mind", "caveats"), listing(caveats)]
    return blocks


def verdict_of(interface: Any) -> Block:
    """The verdict on one interface as a block."""
    return {
        "kind": "verdict",
        "name": interface.name,
        "word": interface.verdict.word,
        "sentence": interface.verdict.sentence,
    }


def _key_numbers(interface: Any) -> list[tuple[str, Cell | str]]:
    verdict = interface.verdict
    told: list[tuple[str, Cell | str]] = [("gap of the scene", amount(interface.gap, "m"))]
    for each in interface.required:
        told.append((f"gap that suffices for {each.percentile:g} % of the motions", amount(each.gap, "m")))
        told.append(("its bounds [mm]", between(each.low, each.high, "m")))
    told.append(("margin", amount(verdict.margin, "m") if verdict.margin is not None else "–"))
    told.append(("governing motions", ", ".join(map(str, verdict.governing)) or "–"))
    told.append(("runs behind it", number(verdict.runs)))
    told.append(("of these failed, counted neither way", number(verdict.failed)))
    told.append(("of those made again, sensitive", number(verdict.sensitive)))
    return told


def _caveats(material: Material) -> list[str]:
    """What a reader of the first page alone must know."""
    found, told = material.assessment, []
    if found.failed:
        told.append(f"{found.failed} of {found.cases} cases failed and are counted neither as contact nor as none.")
    if found.sensitive:
        told.append(f"{found.sensitive} of the {found.checked} runs made again are sensitive to the tolerance.")
    if material.facts("flags", {}):
        told.append("There are doubts about some records; they stand with the records.")
    if material.facts("left_out", []):
        told.append("Some files named by the scene were left out; they stand with the records.")
    if any(not row.verified for each in found.interfaces for row in each.separations):
        told.append("Separations of codes marked unverified were not checked against the text of the code.")
    return told


def adequacy(material: Material) -> list[Block]:
    """Each interface in turn: contact, yielding, the gap needed, codes, fragility, rates, and what sways it."""
    interfaces = material.assessment.interfaces
    blocks: list[Block] = []
    for place, each in enumerate(interfaces, start=1):
        anchor = f"interface-{place}"
        if len(interfaces) > 1:
            blocks.append(heading(each.name, anchor))
        for part in (contact, required, yielding, fragility, rates, sensitivity):
            blocks += part(material, each, anchor)
    return blocks


def contact(material: Material, interface: Any, anchor: str) -> list[Block]:
    """Probability of contact against the gap: figure and table."""
    shares = interface.contact
    heads = [
        (head("gap", "m"), "r"),
        ("with contact", "r"),
        ("motions", "r"),
        ("probability [%]", "r"),
        ("bounds [%]", "r"),
    ]
    rows = [
        [
            number(each.gap, "m"),
            number(each.count),
            number(each.runs),
            number(each.probability, "%", 3),
            between(each.low, each.high, "%", 3),
        ]
        for each in shares
    ]
    caption = f"{interface.name}: probability of contact against the gap, with its bounds"
    return [
        figure(
            f"{anchor}-contact",
            svg_text(report_probabilities([_line("contact", shares)], interface.gap, "probability of contact")),
            f"{caption}.",
            f"{caption}, falling from {rows[0][3]['text']} % at {rows[0][0]['text']} mm to {rows[-1][3]['text']} % at "  # type: ignore[index]
            f"{rows[-1][0]['text']} mm; the table has the numbers.",  # type: ignore[index]
        ),
        table(f"{caption}.", heads, rows, keep=_near(shares, interface.gap)),
    ]


def _line(words: str, shares: Sequence[Any]) -> Line:
    columns = [[getattr(each, name) for each in shares] for name in ("gap", "probability", "low", "high")]
    return Line(words, *columns)


def _near(shares: Sequence[Any], gap: float) -> list[int]:
    """Rows spread evenly over the gaps, and the one nearest to the scene's."""
    nearest = min(range(len(shares)), key=lambda place: abs(shares[place].gap - gap))
    return sorted({*evenly(len(shares), 11), nearest})


def required(material: Material, interface: Any, anchor: str) -> list[Block]:
    """The gap that each motion needs, the percentiles, and what codes ask beside them."""
    needed = material.results["peak_closing_free"].values.ravel()
    rows = interface.separations
    marks = [Mark(f"{each.percentile:g} % of the motions", each.gap) for each in interface.required]
    marks += [Mark(row.rule, row.separation, row.verified) for row in rows][: MOST_MARKS - len(marks)]
    told = [f"{mark.words} {amount(mark.value, 'm')['text']}" for mark in marks]
    caption = f"{interface.name}: the share of motions for which a gap suffices, and what rules ask"
    heads = [("motions without contact [%]", "r"), (head("gap", "m"), "r"), (head("bounds", "m"), "r")]
    percentiles = [
        [number(each.percentile), number(each.gap, "m"), between(each.low, each.high, "m")]
        for each in interface.required
    ]
    blocks = [
        figure(
            f"{anchor}-required",
            svg_text(report_required(needed, interface.gap, marks)),
            f"{caption}.",
            f"{caption}: {', '.join(told)}.",
        ),
        table(
            f"{interface.name}: gap needed, from the motion without contact of {needed.size} motions.",
            heads,
            percentiles,
        ),
    ]
    return blocks + _codes(interface, needed)


def _codes(interface: Any, needed: Any) -> list[Block]:
    """What each rule asks, and for how many of the motions that suffices."""
    if not interface.separations:
        return []
    heads = [("rule", "l"), ("clause", "l"), (head("separation", "m"), "r"), ("suffices for [%]", "r"), ("", "l")]
    rows = []
    for row in interface.separations:
        told = [*([] if row.verified else ["unverified"]), *([row.note] if row.note else [])]
        enough = np.nan if not np.isfinite(row.separation) else float(np.mean(needed <= row.separation))
        clause = ", ".join(str(each) for each in (row.clause, row.year) if each)
        rows.append([row.rule, clause, number(row.separation, "m"), number(enough, "%", 3), "; ".join(told)])
    return [
        table(f"{interface.name}: separations that rules ask, beside the motions that they suffice for.", heads, rows)
    ]


def yielding(material: Material, interface: Any, anchor: str) -> list[Block]:
    """Probability of reaching the yield force against the gap, and by F_E and model at the scene's gap."""
    finite = [each for each in interface.yielding if np.isfinite(each.yield_force)]
    if not finite:
        return []
    forces = sorted({each.yield_force for each in finite})
    lines = []
    for force in (forces[place] for place in evenly(len(forces), MOST_LINES)):
        mine = [each for each in finite if each.yield_force == force and each.contact_model == material.law]
        lines.append(_line(f"F_E {amount(force, 'N')['text']}", mine))
    caption = f"{interface.name}: probability that the contact force reaches F_E, under {name_of(material.law)}"
    gap = min({each.gap for each in finite}, key=lambda value: abs(value - interface.gap))
    here = [each for each in finite if each.gap == gap]
    heads = [
        ("contact model", "l"),
        (head("F_E", "N"), "r"),
        ("reach it", "r"),
        ("motions", "r"),
        ("probability [%]", "r"),
        ("bounds [%]", "r"),
    ]
    rows = [[name_of(each.contact_model), number(each.yield_force, "N"), *_counted(each)] for each in here]
    at = f"{interface.name}: probability of reaching F_E at a gap of {amount(gap, 'm')['text']}."
    return [
        figure(
            f"{anchor}-yielding",
            svg_text(report_probabilities(lines, interface.gap, "probability of reaching $F_E$")),
            f"{caption}.",
            f"{caption}, against the gap, for {len(lines)} yield forces; the table has the numbers at the scene's gap.",
        ),
        table(at, heads, rows),
    ]


def fragility(material: Material, interface: Any, anchor: str) -> list[Block]:
    """Lognormal fragilities: curves and stripes, and the table of medians and dispersions with standard errors."""
    found = [each for each in interface.fragility if np.isfinite(each.median) and np.isfinite(each.dispersion)]
    if not found:
        return []
    unit = "m/s2"
    heads = [
        ("of", "l"),
        ("contact model", "l"),
        (head("gap", "m"), "r"),
        (head("F_E", "N"), "r"),
        (head("median", unit), "r"),
    ]
    heads += [(head("standard error", unit), "r"), ("dispersion", "r"), ("standard error", "r")]
    rows = [
        [
            each.what,
            name_of(each.contact_model or "any"),
            number(each.gap, "m"),
            _force(each.yield_force),
            number(each.median, unit),
            number(each.se_median, unit, 3),
            number(each.dispersion, digits=3),
            number(each.se_dispersion, digits=3),
        ]
        for each in found
    ]
    drawn = [found[place] for place in evenly(len(found), MOST_LINES) if found[place].dispersion > 0.0]
    curves = [Curve(_what(each), each.median, each.dispersion, _stripes(each)) for each in drawn]
    words = found[0].intensity
    caption = f"{interface.name}: lognormal fragility against {words}; rings are the shares of the motions"
    blocks = [table(f"{interface.name}: fragility against {words}, by maximum likelihood.", heads, rows)]
    if curves:
        drawing = svg_text(report_fragility(curves, f"{words} [g]", unit))
        blocks.insert(
            0,
            figure(f"{anchor}-fragility", drawing, f"{caption}.", f"{caption}; the table has medians and dispersions."),
        )
    return blocks


def _force(force: float | None) -> Cell:
    return number(np.nan if force is None else force, "N")


def _what(one: Any) -> str:
    gap = f"{one.what}, gap {amount(one.gap, 'm')['text']}"
    return gap if one.yield_force is None else f"{gap}, F_E {amount(one.yield_force, 'N')['text']}"


def _stripes(one: Any) -> list[Stripe]:
    return [
        Stripe(*(tuple(each)[:3] if not hasattr(each, "intensity") else (each.intensity, each.count, each.runs)))
        for each in one.stripes
    ]


def rates(material: Material, interface: Any, anchor: str) -> list[Block]:
    """Annual rate and 50-year probability, where a hazard curve is given."""
    if not interface.rates:
        return []
    heads = [(head("gap", "m"), "r"), ("a year", "r"), ("in 50 years [%]", "r")]
    rows = [
        [number(each.gap, "m"), number(each.annual, digits=3), number(each.fifty_years, "%", 3)]
        for each in interface.rates
    ]
    return [table(f"{interface.name}: rate of contact under the hazard curve given.", heads, rows)]


def sensitivity(material: Material, interface: Any, anchor: str) -> list[Block]:
    """What the verdict depends on: F_E, contact model, polarity."""
    if not interface.sensitivity:
        return []
    return [
        heading("What sways it", f"{anchor}-sensitivity"),
        listing(each.words for each in interface.sensitivity),
        *([] if material.assessment.checked else [paragraph("No run was made again at a tighter tolerance.")]),
    ]
