"""Section on rates: how often contact and yielding come under a hazard curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pounding_risk.assessment.gap_for_rate import GapForRate, rate_lines
from pounding_risk.assessment.rate_verdict import SHAPE
from pounding_risk.figures.style import MEANING, blank, svg_text
from pounding_risk.render.sheet import (
    DRAWN,
    SMALL,
    Block,
    Cell,
    amount,
    between,
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
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.amplitudes import intensity_unit
from pounding_risk.units import say_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
    from pounding_risk.assessment.hazard import Rate

TITLE = "How often do they touch?"
ORDER = 45


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface, where a hazard curve is given."""
    blocks: list[Block] = []
    for pair in data.pairs:
        of_pair = [*_verdict(pair), *_gaps(data, pair), *_rates(data, pair)]
        if of_pair and len(data.pairs) > 1:
            blocks.append(heading(pair.name, f"{pair.anchor}-how-often"))
        blocks += of_pair
    reading = data.assessment.hazard_reading
    return [paragraph(reading), *blocks] if blocks and reading else blocks


def _verdict(pair: Pair) -> list[Block]:
    """The verdict on the gap by its rate of contact, where a target rate is given."""
    verdict = pair.assessed.rate_verdict
    return [] if verdict is None else [paragraph(sentence) for sentence in verdict.conclusion]


def _gaps(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of the rate of contact against the gap, and table of the gaps that keep it to usual rates."""
    gaps, asked = pair.assessed.gaps_for_rates, data.assessment
    faults = dict.fromkeys(one.fault for one in gaps if one.fault)
    refused = [f"{', '.join(one.words for one in gaps if one.fault == fault)}: {fault}." for fault in faults]
    known = [one for one in gaps if not one.fault]
    left = [paragraph(f"{pair.name}, no gap for"), listing(refused)] if refused else []
    if not known:
        return left
    heads = [("contact no more often than", "l"), ("a year", "r"), (head("gap", "m"), "r"), (head("bounds", "m"), "r")]
    heads += [(head("motions counted", "m"), "r"), ("beyond the curve [%]", "r")]
    rows: list[list[Cell | str]] = [
        [
            f"{one.words}{', the target' if one.rate == asked.target_rate else ''}",
            number(one.rate, digits=3),
            _at_least(number(one.gap, "m"), one),
            between(one.low, one.high, "m"),
            number(one.counted, "m"),
            number(one.missing, "%", 2),
        ]
        for one in known
    ]
    caption = f"{pair.name}: annual rate of contact against the gap under {asked.hazard}"
    sentence = f"{caption}; its {100.0 * asked.confidence:g} % bounds carry nothing of the curve's own uncertainty"
    words = f"{sentence}; {known[-1].words} needs {amount(known[-1].gap, 'm')['text']}"
    explained = "Motions counted: each motion scaled until it closes the gap, without a lognormal curve. " + SHAPE
    return [
        figure(f"{pair.anchor}-rates", svg_text(draw_rates(pair.assessed, asked)), f"{sentence}.", f"{words}."),
        table(f"{pair.name}: gap that keeps contact to a rate under {asked.hazard}.", heads, rows),
        *([] if all(np.isnan(one.counted) for one in known) else [paragraph(explained)]),
        *left,
    ]


def draw_rates(one: InterfaceAssessment, asked: Assessment) -> Figure:
    """The annual rate of contact against the gap with bounds, the target, the assessed gap, and gaps for rates."""
    drawn, axes = blank(1, 1, DRAWN)
    axis, lines = axes[0, 0], rate_lines(one.rates, one.gaps_for_rates)
    colour = MEANING["motions"]
    axis.fill_between(1e3 * lines.gaps, lines.low, lines.high, color=colour, alpha=0.16, linewidth=0.0, label="bounds")
    axis.plot(1e3 * lines.gaps, lines.annual, color=colour, linewidth=2.0, label="rate of contact")
    known = [gap for gap in one.gaps_for_rates if not gap.fault]
    for gap in known:
        is_target = gap.rate == asked.target_rate
        look = {"color": MEANING["required gap"] if is_target else colour, "markersize": 7 if is_target else 4}
        label = f"for {gap.words}, {say_in(gap.gap, 'mm', 3)}"
        axis.plot(1e3 * gap.gap, gap.rate, "o", label=label, zorder=3, **look)
    axis.axvline(1e3 * one.gap, color=MEANING["gap"], linewidth=1.4, label=f"gap assessed, {say_in(one.gap, 'mm')}")
    if asked.target_rate is not None:
        words = f"target, {asked.target_rate_words}"
        axis.axhline(asked.target_rate, color=MEANING["target"], linestyle=":", linewidth=1.4, label=words)
    widest = 1.15 * max(one.gap, *(gap.gap for gap in known))
    axis.set(xlabel="gap [mm]", ylabel="rate of contact [1/year]", xlim=(0.0, 1e3 * widest), yscale="log")
    axis.set_ylim(0.5 * min(gap.rate for gap in known), None)
    axis.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return drawn


def _rates(data: ReportData, pair: Pair) -> list[Block]:
    """Table of annual rates and 50-year probabilities, where a hazard curve is given."""
    rates = [rate for rate in pair.assessed.rates if np.isfinite(rate.annual)]
    if not rates:
        return []
    heads = [("of", "l"), (head("gap", "m"), "r"), ("contact model", "l"), (head("F_E", "N"), "r")]
    heads += [("a year", "r"), ("bounds", "r"), ("in 50 years [%]", "r"), ("P at the weakest [%]", "r")]
    heads += [("beyond the curve [%]", "r")]
    rows: list[list[Cell | str]] = [
        [
            rate.what,
            number(rate.gap, "m"),
            _model(rate),
            strength(rate.yield_force),
            _at_least(number(rate.annual, digits=3), rate),
            between(rate.low, rate.high, "1", 3),
            _at_least(number(rate.fifty_years, "%", 3), rate),
            number(rate.below, "%", 2),
            number(rate.missing, "%", 2),
        ]
        for rate in rates
    ]
    source, curve = data.assessment.hazard, data.assessment.hazard_rows
    weakest, strongest = (
        amount(im, intensity_unit(data.assessment.intensity))["text"] for im in (curve[0][0], curve[-1][0])
    )
    stronger = number(curve[-1][1], digits=3)["text"]
    is_cut = any(rate.at_least for rate in rates)
    least = "Where a rate is at least so much, the curve ends where failures do not. " if is_cut else ""
    explained = (
        f"Rates count motions from {weakest} to {strongest}, the range of the curve. {least}Beyond the curve is the "
        "share of the failures past its ends, were it continued at the slope of its last rows; stronger motions add "
        f"at most {stronger} a year, and of weaker ones the curve says nothing. Bounds carry the uncertainty of "
        "the fragility from so few motions, and nothing of the curve's own uncertainty."
    )
    return [table(f"{pair.name}: annual rate under the hazard curve {source}.", heads, rows), paragraph(explained)]


def _at_least(cell: Cell, rate: Rate | GapForRate) -> Cell:
    """The cell of a rate or gap, with "at least" where the number is only a lower bound."""
    return {**cell, "text": f"at least {cell['text']}"} if rate.at_least else cell


def _model(rate: Rate) -> str:
    """The contact model of a rate; contact itself depends on none."""
    return name_of(rate.contact_model) if rate.contact_model else "any"
