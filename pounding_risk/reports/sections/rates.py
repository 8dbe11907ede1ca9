"""Section on rates: how often contact and yielding come under a hazard curve, or in an event."""

from __future__ import annotations

from functools import partial

from pounding_risk.figures.assess import draw_rates
from pounding_risk.figures.style import panel
from pounding_risk.questions import rates as question
from pounding_risk.questions.adequacy import enough
from pounding_risk.render.sheet import Block, figure, heading, paragraph
from pounding_risk.reports.data import Pair, ReportData

TITLE = "How often do they touch?"
ORDER = 45


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface, where a hazard curve or ground-motion fields are given."""
    assessment, blocks = data.assessment, []
    for pair in data.pairs:
        verdict = pair.assessed.rate_verdict
        of_pair = [] if verdict is None else [paragraph(sentence) for sentence in verdict.conclusion]
        of_pair += [*_gaps(data, pair), *question.annual_rates(assessment, pair.assessed)]
        of_pair += question.scenario(assessment, pair.assessed)
        if of_pair and len(data.pairs) > 1:
            blocks.append(heading(pair.name, f"{pair.anchor}-how-often"))
        blocks += of_pair
    reading = assessment.hazard_reading
    return [paragraph(reading), *blocks] if blocks and reading else blocks


def _gaps(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of the rate of contact against the gap, and table of the gaps that keep it to usual rates."""
    assessment, one = data.assessment, pair.assessed
    blocks = question.gaps_for_rates(assessment, one)
    known = [gap for gap in one.gaps_for_rates if not gap.fault]
    if not known:
        return blocks
    sentence = (
        f"{pair.name}: annual rate of contact against the gap under {assessment.hazard}; its "
        f"{100.0 * assessment.confidence:g} % bounds carry nothing of the curve's own uncertainty"
    )
    alt = f"{sentence}; {known[-1].words} needs {enough(known[-1].gap, unit=True)['text']}."
    drawing = partial(panel, draw_rates, assessment, one)
    return [figure(f"{pair.anchor}-rates", drawing, f"{sentence}.", alt), *blocks]
