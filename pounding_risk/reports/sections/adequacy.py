"""Section on the gap: probability of contact, the gap needed, codes, yielding, fragility, sensitivity."""

from __future__ import annotations

from functools import partial
from math import isinf

from pounding_risk._common.counted import counted
from pounding_risk.assessment.separations.table import short_in
from pounding_risk.figures.assess import draw_contact, draw_fragilities, draw_yielding, drawn_forces
from pounding_risk.figures.separations import draw_rules
from pounding_risk.figures.style import RULE_MARKS_WORDS, panel
from pounding_risk.questions import adequacy as question
from pounding_risk.render.sheet import Block, amount, figure, heading, name_of, number, paragraph
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.amplitudes import intensity_words

TITLE = "Is the gap enough?"
ORDER = 40
OF_A_PAIR = (
    "Whether there is contact follows from the motion without contact alone, whatever the contact model and F_E."
)
OF_A_ROW = (
    "A motion counts as contact at a gap of the grid where the buildings touch in the run with all neighbours, under "
    "the scene's own contact model and F_E; at other gaps, in the stepped curve and in required gaps, where the free "
    "relative motion closes the gap, or a run in which others push the buildings together. At gaps wider than those "
    "that were run that is not known, and required gaps are lower bounds. The F_E stated is that of floors that meet, "
    "or of columns where none meet; both stand with the scene."
)


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface: contact, the gap needed, codes, yielding, fragility, and what it depends on."""
    blocks = [
        paragraph(
            f"A motion is a record in one polarity. Bounds are exact binomial ones of "
            f"{100 * data.assessment.confidence:g} %; those by recording take the components and polarities of a "
            f"recording for as many as they really stand for. {OF_A_ROW if data.several else OF_A_PAIR}"
        )
    ]
    for pair in data.pairs:
        if len(data.pairs) > 1:
            blocks.append(heading(pair.name, pair.anchor))
        blocks += [*_contact(data, pair), *question.required_gaps(pair.assessed), *_codes(data, pair)]
        blocks += [*_yielding(data, pair), *_fragility(data, pair)]
        influences = question.influences(pair.assessed)
        blocks += [heading("Sensitivity", f"{pair.anchor}-influences"), *influences] if influences else []
    return blocks


def _contact(data: ReportData, pair: Pair) -> list[Block]:
    """Figure and table of the probability of contact against the gap."""
    assessment, one = data.assessment, pair.assessed
    required = one.required_at(assessment.criterion.target_percentile)
    target, gap = number(assessment.target, "%")["text"], question.need(required, unit=True)["text"]
    gaps = "every gap"
    if one.run.steps:
        gaps = "the gaps of the grid"
    elif not isinf(one.run.widest):
        gaps = f"gaps of up to {amount(one.run.widest, 'm')['text']}, the widest that was run"
    sentence = (
        f"{pair.name}: probability of contact against the gap{pair.at}: a step down at what each of the "
        f"{counted(len(one.closing), 'motion')} closes, known at {gaps}; its bounds by recording; the target of "
        f"{target} % and the gap required by {required.percentile:g} % of the motions, {gap}"
    )
    alt = f"{sentence}; {question.share_cells(one.contact_at_gap())[2]['text']} % at the assessed gap."
    drawing = partial(panel, draw_contact, assessment, one)
    return [figure(f"{pair.anchor}-contact", drawing, f"{sentence}.", alt), *question.contact(assessment, one)]


def _codes(data: ReportData, pair: Pair) -> list[Block]:
    """Figure and table of what each rule requires, motion by motion, over the gap that the motion needs."""
    assessed, blocks = pair.assessed, question.rules(data.assessment.percentile, pair.assessed)
    compared = [rule for rule in assessed.separations if rule.ratio_median is not None]
    if compared:
        motions = sum(closing > 0.0 for closing in assessed.closing)
        caption = (
            f"{pair.name}: what rules require over the gap that the same motion needs: median and middle 68 % of "
            f"{counted(motions, 'motion')}; safe right of 1; {RULE_MARKS_WORDS}"
        )
        drawing = partial(panel, draw_rules, compared, motions, height=1.1 + 0.22 * len(compared))
        alt = f"{caption}. {short_in(assessed.separations, motions)}."
        blocks.insert(1, figure(f"{pair.anchor}-rules", drawing, f"{caption}.", alt))
    return blocks


def _yielding(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of P(yield) against the gap, where it is known at several, and table of it by F_E and contact model."""
    assessed = pair.assessed
    blocks = question.yielding(data.assessment, assessed) if assessed.yielding else []
    shares = [share for share in assessed.yielding if share.contact_model == data.law]
    if len({share.gap for share in shares if share.runs}) < 2:
        return blocks
    caption = f"{pair.name}: probability that the contact force reaches F_E{pair.at}, under {name_of(data.law)}"
    alt = f"{caption}, against the gap, for {len(drawn_forces(shares))} yield forces; the table has one gap's numbers."
    drawing = partial(panel, draw_yielding, shares, assessed.gap)
    return [figure(f"{pair.anchor}-yielding", drawing, f"{caption}.", alt), *blocks]


def _fragility(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of lognormal fragilities and stripes, and table of medians and dispersions with standard errors."""
    blocks = question.fragilities(data.assessment, pair.assessed)
    if not question.fitted(pair.assessed):
        return blocks
    words = intensity_words(data.assessment.intensity)
    caption = f"{pair.name}: lognormal fragility against {words}; dots are shares of the motions"
    alt = f"{caption}; the table has medians and dispersions."
    drawing = partial(panel, draw_fragilities, data.assessment, pair.assessed)
    return [figure(f"{pair.anchor}-fragility", drawing, f"{caption}.", alt), *blocks]
