"""Section on rates: how often contact and yielding come under a hazard curve, or in an event."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.assessment.rates import rate_lines
from pounding_risk.figures.style import MEANING, blank, svg_text
from pounding_risk.questions import rates as question
from pounding_risk.render.sheet import (
    DRAWN,
    SMALL,
    Block,
    amount,
    figure,
    heading,
    paragraph,
)
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.units import say_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment

TITLE = "How often do they touch?"
ORDER = 45


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface, where a hazard curve or ground-motion fields are given."""
    blocks: list[Block] = []
    for pair in data.pairs:
        of_pair = [*_verdict(pair), *_gaps(data, pair), *question.annual_rates(data.assessment, pair.assessed)]
        of_pair += question.scenario(data.assessment, pair.assessed)
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
    asked, blocks = data.assessment, question.gaps_for_rates(data.assessment, pair.assessed)
    known = [one for one in pair.assessed.gaps_for_rates if not one.fault]
    if not known:
        return blocks
    caption = f"{pair.name}: annual rate of contact against the gap under {asked.hazard}"
    sentence = f"{caption}; its {100.0 * asked.confidence:g} % bounds carry nothing of the curve's own uncertainty"
    words = f"{sentence}; {known[-1].words} needs {amount(known[-1].gap, 'm')['text']}"
    drawing = svg_text(draw_rates(pair.assessed, asked))
    return [figure(f"{pair.anchor}-rates", drawing, f"{sentence}.", f"{words}."), *blocks]


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
