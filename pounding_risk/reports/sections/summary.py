"""Section on the summary: the verdict on each gap, the numbers and sentences behind it, and caveats."""

from __future__ import annotations

from pounding_risk._common.counted import counted
from pounding_risk.assessment.options import PUSHED
from pounding_risk.assessment.separations.rules import MEMORY, QUOTED
from pounding_risk.questions.adequacy import bounds_cell, need
from pounding_risk.questions.assess import columns, row, verdict
from pounding_risk.render.sheet import Block, Cell, amount, between, count, facts, heading, listing, number, paragraph
from pounding_risk.reports.data import Pair, ReportData

TITLE = "Summary"
ORDER = 10


def write(data: ReportData) -> list[Block]:
    """The verdict on each interface with its evidence, and the caveats that a reader of this page alone must know."""
    struck = columns(data.assessment)
    blocks = [listing(struck)] if struck else []
    blocks += row(data.assessment) if len(data.pairs) > 1 else []
    for pair in data.pairs:
        box, evidence = verdict(pair.assessed)
        numbers = facts(f"{pair.name}: the numbers behind the verdict.", _numbers(data, pair))
        blocks += [box, paragraph(data.assessment.asked), evidence, numbers]
    caveats = _caveats(data)
    if caveats:
        blocks += [heading("To keep in mind", "caveats"), listing(caveats)]
    return blocks


def _numbers(data: ReportData, pair: Pair) -> list[tuple[str, Cell | str]]:
    assessed, assessment = pair.assessed, data.assessment
    share, bounds = assessed.contact_at_gap(), f"{100 * assessment.confidence:g} % bounds"
    rows: list[tuple[str, Cell | str]] = [
        ("gap assessed", amount(assessed.gap, "m")),
        ("motions with contact", count(share.count)),
        ("motions", count(share.runs)),
        ("probability of contact [%]", number(share.probability, "%", 3)),
        (f"its {bounds} by recording [%]", between(share.low_recordings, share.high_recordings, "%", 3)),
        (f"its {bounds}, were all motions independent [%]", between(share.low, share.high, "%", 3)),
        ("probability allowed [%]", number(assessment.target, "%", 3)),
    ]
    for percentile in dict.fromkeys((assessment.percentile, assessment.criterion.target_percentile)):
        required = assessed.required_at(percentile)
        ratio = assessed.gap / required.gap if required.gap > 0.0 else float("nan")
        no_bound = "" if required.bounded else " (* the largest seen, no bound)"
        no_bound = f" ({PUSHED} the row was not run so wide, no bound)" if required.is_pushed else no_bound
        rows.append((f"gap that {percentile:g} % of the motions need", need(required, unit=True)))
        rows += [(f"its bounds [mm]{no_bound}", bounds_cell(required)), ("gap over that", number(ratio, digits=3))]
    if (by_rate := assessed.rate_verdict) is not None:
        gap = by_rate.required
        rows += [
            ("contacts a year at the gap assessed", number(by_rate.annual, digits=3)),
            ("its bounds [1/year]", between(by_rate.low, by_rate.high, "1", 3)),
            (f"verdict for {by_rate.words}", by_rate.word),
            (f"gap for {by_rate.words}{', at least' if gap.at_least else ''}", amount(gap.gap, "m")),
            ("its bounds [mm]", between(gap.low, gap.high, "m")),
        ]
    governing = [(motion, amount(motion.closing, "m")) for motion in assessed.verdict.governing]
    motions_text = ", ".join(f"{motion.record} {motion.polarity} ({cell['text']})" for motion, cell in governing)
    return [
        *rows,
        ("motions that need most", {"text": motions_text, "parts": [cell["raw"] for _, cell in governing]}),
        ("cases of the dataset", count(assessment.cases)),
        ("of these failed, excluded from what contact does", count(assessment.failed)),
        ("recomputed at a tighter tolerance", count(assessment.checked)),
        ("of these sensitive", count(assessment.sensitive)),
    ]


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
    sentences += [f"{note.removesuffix('.')}." for note in assessment.notes]
    if data.facts("flags", {}):
        sentences.append("There are doubts about some records; they stand with the records.")
    if data.facts("left_out", []):
        sentences.append("Some files that the scene names were excluded; they stand with the records.")
    if data.facts("unused_keys", []):
        sentences.append("Some keys of the scene have no effect in it; they are listed with the scene.")
    rules = [rule.row for pair in data.pairs for rule in pair.assessed.separations]
    if any(each.verification in (MEMORY, QUOTED) for each in rules):
        sentences.append(
            "Some rules of codes are quoted by others or from memory: their clauses were not read; see there."
        )
    if any(each.superseded for each in rules):
        sentences.append("Some rules are of editions that later ones supersede; they are named there.")
    return sentences
