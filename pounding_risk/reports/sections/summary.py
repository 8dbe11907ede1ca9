"""Section on the summary: the verdict on each gap, the numbers and sentences behind it, and caveats."""

from __future__ import annotations

from typing import Any

from pounding_risk._common.counted import counted
from pounding_risk.assessment.separations.rules import MEMORY, QUOTED
from pounding_risk.questions.required_gap import bounds_cell, enough
from pounding_risk.render.sheet import (
    KEPT,
    Block,
    Cell,
    amount,
    between,
    count,
    facts,
    head,
    heading,
    listing,
    number,
    paragraph,
    table,
)
from pounding_risk.reports.data import Pair, ReportData

TITLE = "Summary"
ORDER = 10


def write(data: ReportData) -> list[Block]:
    """The verdict on each interface with its evidence, and the caveats that a reader of this page alone must know."""
    blocks: list[Block] = []
    if len(data.pairs) > 1:
        struck = [f"{pair.name}: {' '.join(pair.assessed.columns)}" for pair in data.pairs if pair.assessed.columns]
        blocks = [listing(struck)] if struck else []
        blocks += [_verdicts(data), *map(paragraph, data.assessment.unlike_verdicts)]
    for pair in data.pairs:
        verdict = pair.assessed.verdict
        blocks += [
            {
                "kind": "verdict",
                "name": pair.name,
                "word": verdict.word,
                "conclusion": list(verdict.conclusion),
                "sentence": verdict.sentence,
            },
            paragraph(data.assessment.asked),
            listing(verdict.evidence),
            facts(f"{pair.name}: the numbers behind the verdict.", _numbers(data, pair)),
        ]
    caveats = _caveats(data)
    if caveats:
        blocks += [heading("To keep in mind", "caveats"), listing(caveats)]
    return blocks


def _verdicts(data: ReportData) -> Block:
    """The verdicts of a row, one line an interface."""
    percentile = data.assessment.percentile
    heads = [("neighbours", "l"), (head("gap", "m"), "r"), ("verdict", "l"), ("with contact", "r"), ("motions", "r")]
    heads += [("probability [%]", "r"), (head(f"gap that {percentile:g} % need", "m"), "r")]
    rows: list[list[Cell | str]] = []
    for pair in data.pairs:
        here = pair.assessed.contact_at_gap()
        needed = pair.assessed.required_at(percentile).gap
        shares = [count(here.count), count(here.runs), number(here.probability, "%", 3)]
        rows.append([pair.name, number(pair.assessed.gap, "m"), pair.assessed.verdict.word, *shares, enough(needed)])
    worst = sorted(range(len(rows)), key=lambda at: -data.pairs[at].assessed.contact_at_gap().probability)
    note = "those with most contact"
    return table("The gaps of the row, left to right.", heads, rows, keep=sorted(worst[:KEPT]), note=note)


def _numbers(data: ReportData, pair: Pair) -> list[tuple[str, Cell | str]]:
    assessed, assessment = pair.assessed, data.assessment
    here, bounds = assessed.contact_at_gap(), f"{100 * assessment.confidence:g} % bounds"
    rows: list[tuple[str, Cell | str]] = [
        ("gap assessed", amount(assessed.gap, "m")),
        ("motions with contact", count(here.count)),
        ("motions", count(here.runs)),
        ("probability of contact [%]", number(here.probability, "%", 3)),
        (f"its {bounds} by recording [%]", between(here.low_recordings, here.high_recordings, "%", 3)),
        (f"its {bounds}, were all motions independent [%]", between(here.low, here.high, "%", 3)),
        ("probability allowed [%]", number(assessment.target, "%", 3)),
        *_required(assessed, assessment.percentile),
        *([] if assessment.criterion.agrees else _required(assessed, assessment.criterion.target_percentile)),
        *_by_rate(assessed),
        ("motions that need most", _governing(assessed.verdict)),
        ("cases of the dataset", count(assessment.cases)),
        ("of these failed, excluded from what contact does", count(assessment.failed)),
        ("recomputed at a tighter tolerance", count(assessment.checked)),
        ("of these sensitive", count(assessment.sensitive)),
    ]
    return rows


def _required(assessed: Any, percentile: float) -> list[tuple[str, Cell | str]]:
    required = assessed.required_at(percentile)
    ratio = assessed.gap / required.gap if required.gap > 0.0 else float("nan")
    return [
        (f"gap that {percentile:g} % of the motions need", enough(required.gap, unit=True)),
        (f"its bounds [mm]{'' if required.bounded else ' (* the largest seen, no bound)'}", bounds_cell(required)),
        ("gap over that", number(ratio, digits=3)),
    ]


def _by_rate(assessed: Any) -> list[tuple[str, Cell | str]]:
    """Rows on the rate of contact, where a target rate is given."""
    verdict = assessed.rate_verdict
    if verdict is None:
        return []
    required = verdict.required
    return [
        ("contacts a year at the gap assessed", number(verdict.annual, digits=3)),
        ("its bounds [1/year]", between(verdict.low, verdict.high, "1", 3)),
        (f"verdict for {verdict.words}", verdict.word),
        (f"gap for {verdict.words}{', at least' if required.at_least else ''}", amount(required.gap, "m")),
        ("its bounds [mm]", between(required.low, required.high, "m")),
    ]


def _governing(verdict: Any) -> Cell:
    """The motions that close most, with the gap that each needs."""
    cells = [amount(motion.closing, "m") for motion in verdict.governing]
    words = [
        f"{motion.record} {motion.polarity} ({cell['text']})"
        for motion, cell in zip(verdict.governing, cells, strict=True)
    ]
    return {"text": ", ".join(words), "parts": [cell["raw"] for cell in cells]}


def _caveats(data: ReportData) -> list[str]:
    assessment, sentences = data.assessment, []
    if assessment.failed:
        sentences.append(
            f"{assessment.failed} of {counted(assessment.cases, 'case')} failed: they are excluded from what contact "
            "does. Whether there is "
            f"contact follows from the motion without it{', and in a row from the runs' if data.several else ''}."
        )
    if assessment.sensitive:
        runs = counted(assessment.checked, "run")
        sentences.append(f"{assessment.sensitive} of the {runs} recomputed are sensitive to the tolerance.")
    if not assessment.checked:
        sentences.append("No run was recomputed at a tighter tolerance: how exact the numbers are was not measured.")
    sentences += assessment.notes
    if data.facts("flags", {}):
        sentences.append("There are doubts about some records; they stand with the records.")
    if data.facts("left_out", []):
        sentences.append("Some files that the scene names were excluded; they stand with the records.")
    if data.facts("unused_keys", []):
        sentences.append("Some keys of the scene have no effect in it; they are listed with the scene.")
    rules = [rule.row for pair in data.pairs for rule in pair.codes.rules]
    if any(row.verification in (MEMORY, QUOTED) for row in rules):
        sentences.append(
            "Some rules of codes are quoted by others or from memory: their clauses were not read; see there."
        )
    if any(row.superseded for row in rules):
        sentences.append("Some rules are of editions that later ones supersede; they are named there.")
    return sentences
