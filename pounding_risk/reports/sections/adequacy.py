"""Section on the gap: probability of contact, the gap needed, codes, yielding, fragility, sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.figures.style import (
    MEANING,
    RULE_MARKS_WORDS,
    blank,
    contact_styles,
    rule_mark,
    strength_styles,
    svg_text,
)
from pounding_risk.questions import adequacy as question
from pounding_risk.questions.required_gap import enough
from pounding_risk.questions.rules import rules
from pounding_risk.render.sheet import (
    DRAWN,
    SMALL,
    Block,
    evenly,
    figure,
    heading,
    name_of,
    number,
    paragraph,
    strength,
)
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.amplitudes import intensity_label, intensity_shown, intensity_words
from pounding_risk.statistics.required_gap import ContactSteps, RequiredGap, contact_steps
from pounding_risk.units import say_in

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pounding_risk.assessment.fragility import Fragility
    from pounding_risk.assessment.separations.table import Comparison
    from pounding_risk.statistics.proportions import Share

TITLE = "Is the gap enough?"
ORDER = 40
MOST_LINES = 5  # of one figure
MOST_CURVES = 3  # of contact, and as many of yielding
FEW = 30  # gaps that are marked in a figure
BAND = 0.16  # opacity of bounds
WIDER = 1.15  # times the widest gap of a figure: where its axis ends


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface: contact, the gap needed, codes, yielding, fragility, and what it depends on."""
    blocks = [paragraph(_terms(data))]
    for pair in data.pairs:
        if len(data.pairs) > 1:
            blocks.append(heading(pair.name, pair.anchor))
        blocks += [*_contact(data, pair), *question.required_gaps(pair.assessed), *_codes(data, pair)]
        blocks += [*_yielding(data, pair), *_fragility(data, pair), *_sensitivity(pair)]
    return blocks


def _terms(data: ReportData) -> str:
    """Definitions of a motion, of its bounds, and of contact."""
    confidence = f"{100 * data.assessment.confidence:g} %"
    decides = (
        "Whether there is contact follows from the motion without contact alone, whatever the contact model and F_E."
    )
    if data.several:
        decides = (
            "A motion counts as contact at a gap of the grid where the buildings touch in the run with all neighbours, "
            "under the scene's own contact model and F_E; at other gaps, in the stepped curve and in required gaps, "
            "where the free relative motion closes the gap, or a run in which others push the buildings together. The "
            "F_E stated is that of floors that meet; "
            "a column keeps its own, which stands with the scene."
        )
    return (
        f"A motion is a record in one polarity. Bounds are exact binomial ones of {confidence}; those by recording "
        f"take the components and polarities of a recording for as many as they really stand for. {decides}"
    )


def _contact(data: ReportData, pair: Pair) -> list[Block]:
    """Figure and table of the probability of contact against the gap."""
    assessment = data.assessment
    closing = np.array(pair.assessed.closing)
    steps = contact_steps(closing, pair.assessed.verdict.independent / closing.size, assessment.confidence)
    required = pair.assessed.required_at(assessment.criterion.target_percentile)
    target, gap = number(assessment.target, "%")["text"], enough(required.gap, unit=True)["text"]
    caption = f"{pair.name}: probability of contact against the gap{pair.at}"
    sentence = (
        f"{caption}: a step down at what each of the {counted(closing.size, 'motion')} closes, known at every gap; "
        f"its bounds by "
        f"recording; the target of {target} % and the gap required by {required.percentile:g} % of the motions, {gap}"
    )
    return [
        figure(
            f"{pair.anchor}-contact",
            svg_text(draw_contact(steps, pair.assessed.gap, assessment.target, required)),
            f"{sentence}.",
            f"{sentence}; {question.share_cells(pair.assessed.contact_at_gap())[2]['text']} % at the assessed gap.",
        ),
        *question.contact(assessment, pair.assessed),
    ]


def draw_contact(steps: ContactSteps, gap: float, target: float, required: RequiredGap) -> Figure:
    """P(contact) in steps with bounds, the target (a fraction), the assessed gap [m], and the gap required for it."""
    drawn, axes = blank(1, 1, DRAWN)
    axis, colour = axes[0, 0], MEANING["motions"]
    widest = WIDER * max(float(steps.gaps[-1]), gap, required.high, 1e-6)
    edges = 1e3 * np.append(steps.gaps, widest)
    low, high = (100.0 * np.append(bound, bound[-1]) for bound in (steps.low, steps.high))
    look: dict[str, Any] = {"step": "post", "alpha": BAND, "linewidth": 0.0}
    axis.fill_between(edges, low, high, color=colour, label="bounds by recording", **look)
    axis.stairs(100.0 * steps.probability, edges, baseline=None, color=colour, linewidth=2.0, label="motions")
    words = f"target, {100.0 * target:.4g} %"
    axis.axhline(100.0 * target, color=MEANING["target"], linestyle=":", linewidth=1.4, label=words)
    _mark_required(axis, required)
    _mark_gap(axis, gap)
    axis.set(xlabel="gap [mm]", ylabel="probability of contact [%]", xlim=(0.0, 1e3 * widest), ylim=(-3.0, 109.0))
    axis.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return drawn


def _mark_required(axis: Axes, required: RequiredGap) -> None:
    """A line at the required gap, and a bar of its bounds that ends in an arrow where there is none from above."""
    colour = MEANING["required gap"]
    words = f"required by {required.percentile:g} %, {say_in(required.provided, 'mm', 3)}"
    axis.axvline(1e3 * required.gap, color=colour, linestyle="--", linewidth=1.5, label=words)
    words = "its bounds" if required.bounded else "its bounds, none above"
    bar, height = (1e3 * required.low, 1e3 * required.high), 105.0
    axis.plot(bar, (height, height), color=colour, linewidth=3.0, solid_capstyle="butt", label=words)
    if not required.bounded:
        axis.plot(bar[1], height, ">", color=colour, markersize=6)


def _mark_gap(axis: Axes, gap: float) -> None:
    axis.axvline(1e3 * gap, color=MEANING["gap"], linewidth=1.4, label=f"gap assessed, {say_in(gap, 'mm')}")


def _codes(data: ReportData, pair: Pair) -> list[Block]:
    """Figure and table of what each rule requires, motion by motion, over the gap that the motion needs."""
    codes, blocks = pair.codes, rules(data.assessment.percentile, pair.assessed)
    compared = [rule for rule in codes.rules if rule.ratio_median is not None]
    if compared:
        caption = f"{pair.name}: what rules require over the gap that the same motion needs"
        motions = counted(codes.motions, "motion")
        caption = f"{caption}: median and middle 68 % of {motions}; safe right of 1; {RULE_MARKS_WORDS}"
        drawing = svg_text(draw_rules(compared))
        blocks.insert(1, figure(f"{pair.anchor}-rules", drawing, f"{caption}.", f"{caption}. {codes.finding}."))
    return blocks


def draw_rules(compared: Sequence[Comparison]) -> Figure:
    """A line for each rule; squares are of those short in the median, marks are filled as in `style.RULE_MARKS`."""
    drawn, axes = blank(1, 1, (DRAWN[0], 0.9 + 0.22 * len(compared)))
    axis, colour = axes[0, 0], MEANING["rule"]
    axis.axvline(1.0, color="black", linewidth=1.0)
    for index, rule in enumerate(compared):
        axis.plot([rule.ratio_low, rule.ratio_high], [index, index], color=colour, linewidth=2.2)
        is_short = (rule.ratio_median or 0.0) < 1.0
        axis.plot(rule.ratio_median, index, "s" if is_short else "o", **rule_mark(rule.row.verification))
    axis.set_yticks(range(len(compared)), [rule.row.title for rule in compared], fontsize=SMALL)
    axis.set_ylim(len(compared) - 0.5, -0.5)
    axis.set_xlim(left=0.0)
    axis.set_xlabel("rule over the gap needed")
    return drawn


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else value


def _yielding(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of P(yield) against the gap, and table of it by F_E and contact model."""
    shares = pair.assessed.yielding
    if not shares:
        return []
    forces = sorted({_or_nan(share.yield_force) for share in shares})
    by_force = {}
    for force in (forces[index] for index in evenly(len(forces), MOST_LINES)):
        same = [share for share in shares if share.yield_force == force and share.contact_model == data.law]
        by_force[f"$F_E$ {strength(force, unit=True)['text']}"] = same
    caption = f"{pair.name}: probability that the contact force reaches F_E{pair.at}, under {name_of(data.law)}"
    return [
        figure(
            f"{pair.anchor}-yielding",
            svg_text(draw_yielding(by_force, pair.assessed.gap)),
            f"{caption}.",
            f"{caption}, against the gap, for {len(by_force)} yield forces; the table has the numbers at one gap.",
        ),
        *question.yielding(data.assessment, pair.assessed),
    ]


def draw_yielding(by_force: dict[str, list[Share]], gap: float) -> Figure:
    """P(yield) with bounds against the gap, a line for each yield force, and a mark at the assessed gap [m]."""
    drawn, axes = blank(1, 1, DRAWN)
    axis = axes[0, 0]
    for (words, shares), (colour, dash) in zip(by_force.items(), strength_styles(len(by_force)), strict=True):
        gaps = np.array([share.gap for share in shares]) * 1e3
        # Marks where it was counted; between them the line only leads the eye.
        marker = "o" if len(gaps) <= FEW else ""
        look = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "linewidth": 1.8}
        axis.plot(gaps, 100.0 * np.array([share.probability for share in shares]), label=words, **look)
        if len(by_force) <= 3:
            bounds = 100.0 * np.array([(share.low_recordings, share.high_recordings) for share in shares]).T
            axis.fill_between(gaps, *bounds, color=colour, alpha=BAND, linewidth=0.0)
    _mark_gap(axis, gap)
    axis.set(xlabel="gap [mm]", ylabel="probability of reaching $F_E$ [%]", ylim=(-3.0, 103.0))
    axis.legend(fontsize=SMALL)
    return drawn


def _fragility(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of lognormal fragilities and stripes, and table of medians and dispersions with standard errors."""
    curves, blocks = question.fitted(pair.assessed), question.fragilities(data.assessment, pair.assessed)
    if not curves:
        return blocks
    words = intensity_words(data.assessment.intensity)
    drawn = _drawn_curves(curves, data.law, pair.assessed.gap)
    caption = f"{pair.name}: lognormal fragility against {words}; rings are shares of the motions"
    drawing = svg_text(draw_fragility(drawn, intensity_label(data.assessment.intensity)))
    alt = f"{caption}; the table has medians and dispersions."
    return [figure(f"{pair.anchor}-fragility", drawing, f"{caption}.", alt), *blocks]


def draw_fragility(curves: Sequence[Fragility], words: str) -> Figure:
    """Lognormal fragilities with the stripes that they were fitted to; accelerations are drawn in g, PGV in cm/s."""
    drawn, axes = blank(1, 1, DRAWN)
    axis = axes[0, 0]
    widest = max(stripe.im for curve in curves for stripe in curve.stripes)
    im = np.linspace(1e-3, 1.1, 300) * widest
    of_contact = contact_styles(sum(curve.what == "contact" for curve in curves))
    of_yielding = strength_styles(len(curves) - len(of_contact))
    _, size = intensity_shown(curves[0].intensity)
    for curve in curves:
        colour, dash = (of_contact if curve.what == "contact" else of_yielding).pop(0)
        look = {"color": colour, "linestyle": dash, "linewidth": 1.8}
        axis.plot(
            im * size, 100.0 * curve.probability(im), label=question.curve_words(curve).replace("F_E", "$F_E$"), **look
        )
        points = [(stripe.im * size, 100.0 * stripe.count / stripe.runs) for stripe in curve.stripes if stripe.runs]
        axis.plot(*np.array(points).T, "o", color=colour, markersize=5, markerfacecolor="none")
    axis.set(xlabel=words, ylabel="probability [%]", ylim=(-3.0, 103.0))
    axis.set_xlim(0.0, float(im[-1]) * size)
    axis.legend(fontsize=SMALL)
    return drawn


def _drawn_curves(curves: Sequence[Fragility], law: str, gap: float) -> list[Fragility]:
    """Some curves of contact, that of the assessed gap among them, and some of yielding under the scene's law."""
    touching = [curve for curve in curves if curve.what == "contact"]
    yields = [curve for curve in curves if curve.what != "contact" and curve.contact_model == law]
    at_gap = [curve for curve in touching if curve.gap == gap]
    some = [touching[index] for index in evenly(len(touching), MOST_CURVES)] if touching else []
    chosen = {id(curve) for curve in [*at_gap, *some][:MOST_CURVES]}
    chosen |= {id(yields[index]) for index in evenly(len(yields), MOST_CURVES)}
    return [curve for curve in curves if id(curve) in chosen] or list(curves[:MOST_CURVES])


def _sensitivity(pair: Pair) -> list[Block]:
    """What the verdict depends on: polarity, F_E, contact model."""
    blocks = question.influences(pair.assessed)
    return [heading("Sensitivity", f"{pair.anchor}-influences"), *blocks] if blocks else []
