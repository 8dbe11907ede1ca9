"""Sheet of `assess`: the verdict on each gap with its evidence, and the tables that it rests on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.questions import adequacy, rates
from pounding_risk.questions.required_gap import enough
from pounding_risk.questions.rules import rules
from pounding_risk.render.sheet import KEPT, MISSING, Block, count, head, heading, listing, number, paragraph, table

if TYPE_CHECKING:
    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment


def sheet(assessment: Assessment) -> list[Block]:
    """The verdicts, then the tables of each interface, left to right.

    Parameters
    ----------
    assessment : Assessment
        An answer of `assess`.

    Returns
    -------
    list of Block
        Without what its dataset or options do not give, such as rates without a hazard curve.
    """
    blocks = [paragraph("\n".join([assessment.title, *columns(assessment), assessment.asked]))]
    blocks += [listing(assessment.notes)] if assessment.notes else []
    blocks += row(assessment) if len(assessment.interfaces) > 1 else []
    for place, one in enumerate(assessment.interfaces, start=1):
        blocks += [
            heading(one.name, f"interface-{place}"),
            *verdict(one),
            *adequacy.required_gaps(one),
            *adequacy.contact(assessment, one),
            *adequacy.yielding(assessment, one),
            *adequacy.response(one),
            *adequacy.influences(one),
            *adequacy.fragilities(assessment, one),
            *([paragraph(assessment.hazard_reading)] if assessment.hazard_reading and one.rates else []),
            *rates.annual_rates(assessment, one),
            *rates.scenario(assessment, one),
            *rates.gaps_for_rates(assessment, one),
            *rules(assessment.percentile, one),
        ]
    return [*blocks, *([listing(assessment.unused_keys)] if assessment.unused_keys else [])]


def columns(assessment: Assessment) -> list[str]:
    """Sentences on columns that floors strike, each with its interface where there are several."""
    several = len(assessment.interfaces) > 1
    return [f"{one.name}: {words}" if several else words for one in assessment.interfaces for words in one.columns]


def verdict(one: InterfaceAssessment) -> tuple[Block, Block]:
    """The verdict on a gap with what to provide, and its evidence."""
    judged = one.verdict
    box = {
        "kind": "verdict",
        "name": one.name,
        "word": judged.word,
        "conclusion": list(judged.conclusion[len(one.columns) :]),  # columns stand at the top
        "sentence": judged.sentence,
    }
    return box, listing([*judged.evidence, f"In short: {one.what_matters}."], mark="  ")


def row(assessment: Assessment) -> list[Block]:
    """Table of the verdicts of a row, one line an interface, and why equal counts have other verdicts."""
    heads = [("neighbours", "l"), (head("gap", "m"), "r"), ("verdict", "l"), ("contact in", "r"), ("of", "r")]
    heads += [("P(contact) [%]", "r"), (head(f"required by {assessment.percentile:g} %", "m"), "r")]
    if assessment.target_rate is not None:
        heads += [(f"for {assessment.target_rate_words}", "l"), (head("gap for it", "m"), "r")]
    rows: list[adequacy.Row] = []
    for one in assessment.interfaces:
        cells: adequacy.Row = [one.name, number(one.gap, "m", adequacy.GIVEN), one.verdict.word]
        here, required = one.contact_at_gap(), one.required_at(assessment.percentile)
        cells += [count(here.count), count(here.runs), number(here.probability, "%", 3), enough(required.gap)]
        if assessment.target_rate is not None:
            by_rate = one.rate_verdict
            cells += [MISSING, MISSING] if by_rate is None else [by_rate.word, number(by_rate.required.gap, "m")]
        rows.append(cells)
    worst = sorted(range(len(rows)), key=lambda at: -assessment.interfaces[at].contact_at_gap().probability)
    note = "those with most contact"
    verdicts = table("The gaps of the row, left to right.", heads, rows, keep=sorted(worst[:KEPT]), note=note)
    return [verdicts, *map(paragraph, assessment.unlike_verdicts)]
