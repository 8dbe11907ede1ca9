"""Blocks of `assess` under a hazard curve or ground-motion fields: annual rates, gaps for rates, P in an event."""

from __future__ import annotations

from math import isfinite, isnan
from typing import TYPE_CHECKING

from pounding_risk.assessment.rates import SHAPE, GapForRate
from pounding_risk.questions.adequacy import EVENT_HEADS, OF_GAP, Row, at_least, enough, event_cells, of_gap
from pounding_risk.render.sheet import Block, Cell, amount, between, head, joined, listing, number, paragraph, table
from pounding_risk.results.amplitudes import intensity_unit, intensity_words

if TYPE_CHECKING:
    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment

AT_LEAST = (
    "At least: the hazard curve ends where failures do not, and no bound counts what lies beyond; give one that "
    "reaches further. "
)


def annual_rates(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of annual rates and probabilities in 50 years, where a hazard curve is given."""
    rates = [rate for rate in pair.rates if isfinite(rate.annual)]
    if not rates:
        return []
    heads = [*EVENT_HEADS, "a year", "bounds", "in 50 years [%]", "P at the weakest [%]", "beyond the curve [%]"]
    rows: list[Row] = []
    for rate in rates:
        row = [*event_cells(rate), at_least(number(rate.annual, digits=3), rate.at_least)]
        row += [between(rate.low, rate.high, "1", 3), at_least(number(rate.fifty_years, "%", 3), rate.at_least)]
        rows.append([*row, number(rate.below, "%", 2), number(rate.missing, "%", 2)])
    curve, unit = assessment.hazard_rows, intensity_unit(assessment.intensity)
    weakest, strongest = (amount(im, unit)["text"] for im in (curve[0][0], curve[-1][0]))
    words = (
        f"Rates count motions from {weakest} to {strongest}, the range of the curve, and stronger ones to fail as "
        f"often as at {strongest}. "
        f"{AT_LEAST * any(rate.at_least for rate in rates)}Beyond the curve is the "
        "share of the failures that are not counted, were it continued at the slope of its last rows; stronger motions "
        f"add at most {number(curve[-1][1], digits=3)['text']} a year, and of weaker ones the curve says nothing. "
        "Bounds carry the uncertainty of the fragility from so few motions, and nothing of the curve's own uncertainty."
    )
    caption = f"{pair.name}: annual rates under the hazard curve {assessment.hazard}."
    return [table(caption, heads, rows, keep=of_gap(pair, rates), note=OF_GAP), paragraph(words)]


def gaps_for_rates(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of the gaps that keep contact to usual rates and to the target, and why there are none for others."""
    gaps = pair.gaps_for_rates
    valid = [gap for gap in gaps if not gap.fault]
    blocks: list[Block] = []
    if valid:
        heads = ["contact no more often than", "a year", head("gap", "m"), head("bounds", "m")]
        heads += [head("motions counted", "m"), "beyond the curve [%]"]
        rows: list[Row] = []
        for gap in valid:
            words = f"{gap.words}{', the target' if gap.rate == assessment.target_rate else ''}"
            row: Row = [words, number(gap.rate, digits=3), gap_for_rate(gap)]
            ends = number(gap.low, "m"), enough(gap.high)
            row += [at_least(ends[0], True) if gap.at_least else joined(*ends), enough(gap.counted)]
            rows.append([*row, number(gap.missing, "%", 2)])
        blocks.append(table(f"{pair.name}: gap that keeps contact to a rate under {assessment.hazard}.", heads, rows))
        note = AT_LEAST * any(gap.at_least for gap in valid)
        if not all(isnan(gap.counted) for gap in valid):
            note += "Motions counted: each motion scaled until it closes the gap, without a lognormal curve. "
            note += SHAPE
        blocks += [paragraph(note.strip())] if note else []
    faults = dict.fromkeys(gap.fault for gap in gaps if gap.fault)
    fault_lines = [f"{', '.join(gap.words for gap in gaps if gap.fault == fault)}: {fault}." for fault in faults]
    return [*blocks, *([paragraph(f"{pair.name}, no gap for"), listing(fault_lines, mark="")] if fault_lines else [])]


def scenario(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of the probabilities in a scenario or an event set, where ground-motion fields are given."""
    valid = [result for result in pair.scenario if not result.fault]
    if not valid:
        return []
    bounds = f"{100 * assessment.confidence:g} % bounds [%]"
    heads = [*EVENT_HEADS, "P in an event [%]", bounds, "excluded events add at most [%]"]
    rows: list[Row] = []
    for result in valid:
        row = [*event_cells(result), number(result.probability, "%", 3), between(result.low, result.high, "%", 3)]
        rows.append([*row, number(result.left_out, "%", 2)])
    words = intensity_words(assessment.intensity)
    caption = f"{pair.name}: probability in an event of {assessment.gmfs}, by its {words} at the site."
    note = (
        "Bounds carry the fragility's uncertainty, that the events are a sample, and the excluded events: events "
        "without a row at the site are below the engine's least intensity, and count as without failure."
    )
    return [
        table(caption, heads, rows, keep=of_gap(pair, valid), note=OF_GAP),
        paragraph(f"{assessment.gmfs_reading} {note}".strip()),
    ]


def gap_for_rate(required: GapForRate) -> Cell:
    """A gap for a rate of contact, rounded up as other required gaps are; "–" where there is none."""
    return at_least(enough(required.gap), required.at_least)
