"""Figure of an assessment: P(contact) against the gap with its bounds, fragilities, and rates against the gap.

Each panel is drawn on an axis of its own from an assessment and one of its interfaces; a report has them one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.order import evenly
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
from pounding_risk.assessment.fragility import SCALED, Fragility
from pounding_risk.assessment.rates import RateLines, rate_lines
from pounding_risk.assessment.separations.rules import COMBINATIONS
from pounding_risk.figures import style
from pounding_risk.motions.levels import say_level
from pounding_risk.results.amplitudes import intensity_label, intensity_quantity, intensity_shown, own
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.proportions import Share
from pounding_risk.statistics.required_gap import contact_steps, rounded_up
from pounding_risk.units import GAP, YIELD_FORCE, rounded, say_in

Array = NDArray[np.float64]

MOTIONS, REQUIRED = style.MEANING["motions"], style.MEANING["required gap"]
POINTS = 400
ROOM = 1.15  # of the axis of gaps, beyond what is drawn on it
HEIGHTS = (1.08, 1.115, 1.15)  # of the marks of rules, above the bars of required gaps
MOST_EMPTY = 2.0  # times what the motions need: a rule that requires more stands beyond the axis
MOST_YIELD_CURVES = 4
MOST_FORCES = 5  # of a figure of yielding
FEW = 30  # gaps that are marked on a line
RATE_MARKS = "osDv^Phx*"  # of gaps for annual rates, each named in the legend
MOST_NAMED = 2  # interfaces whose findings stand in the title
VERDICT_WORDS = {"depends": "not decided"}


def assessment_figure(assessment: Assessment, note: str = "") -> style.Figure:
    """P(contact) against the gap, fragilities at the gap, and with a hazard curve the rate of contact against the gap.

    One row for each interface.

    Parameters
    ----------
    assessment : Assessment
        As `assess` gives it.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels for each interface, three with a hazard curve; one where no interface has a fragility.
    """
    has_curves = any(not curve.fault for part in assessment.interfaces for curve in _curves(part))
    panels = [draw_contact, *([draw_fragilities] if has_curves or assessment.hazard_rows else [])]
    panels += [draw_rates] if assessment.hazard_rows else []
    rows, columns = len(assessment.interfaces), len(panels)
    figure, axes = style.blank(rows, columns, (max(6.5 * columns, 8.5), 1.0 + 5.0 * rows))
    for line, part in zip(axes, assessment.interfaces, strict=True):
        for axis, draw in zip(line, panels, strict=True):
            draw(axis, assessment, part)
        if rows > 1:
            line[0].set_title(part.name, fontsize=10, loc="left")
    first = assessment.interfaces[0]
    findings = "; ".join(_finding(part, rows > 1) for part in assessment.interfaces)
    motions = f"{counted(first.verdict.motions, 'motion')} of {counted(first.verdict.recordings, 'recording')}"
    condition = f"{assessment.title}: {motions} {first.at}"
    if draw_fragilities not in panels:
        condition += f"; no fragility at the gap: {_curves(first)[0].fault}"
    style.title(figure, findings if rows <= MOST_NAMED else _verdict_counts(assessment), condition, note)
    return figure


def _verdict_counts(assessment: Assessment) -> str:
    """Sentence on the number of gaps of a row by verdict, and the interface with most contact."""
    words = [interface.verdict.word for interface in assessment.interfaces]
    counts = ", ".join(f"{words.count(word)} {VERDICT_WORDS.get(word, word)}" for word in dict.fromkeys(words))
    worst = max(assessment.interfaces, key=lambda interface: interface.contact_at_gap().probability)
    share = worst.contact_at_gap()
    most = f"most contact at {worst.name}: {share.count} of {counted(share.runs, 'motion')}"
    return f"Of {len(words)} gaps {counts}; {most}"


def _finding(part: InterfaceAssessment, is_named: bool) -> str:
    share, name = part.contact_at_gap(), f"{part.name}: " if is_named else ""
    word = VERDICT_WORDS.get(part.verdict.word, part.verdict.word)
    rate = part.rate_verdict
    rate_text = "" if rate is None else f", and {VERDICT_WORDS.get(rate.word, rate.word)} for {rate.words}"
    return f"{name}{own(part.gap, GAP)} is {word}: {share.count} of {counted(share.runs, 'motion')} close it{rate_text}"


def draw_contact(axis: Any, assessment: Assessment, one: InterfaceAssessment) -> None:
    """The exact share of the motions that close each gap, its bounds, target, gap, required gaps and code rules."""
    closing = np.array(one.closing)
    weight = one.verdict.independent / closing.size
    steps = contact_steps(closing, weight, assessment.confidence, one.run)
    percentiles = dict.fromkeys((assessment.percentile, assessment.criterion.target_percentile))
    required = [one.required_at(percentile) for percentile in percentiles]
    rules = {rule.row.rule: rule.upper + rule.bumper for rule in one.separations if rule.upper is not None}
    bumpers = " and bumpers" if any(rule.bumper for rule in one.separations) else ""
    needed = max(closing[-1], one.gap, 1e-6)
    near_rules = [rules[name] for name in COMBINATIONS if name in rules and rules[name] <= MOST_EMPTY * needed]
    widest = ROOM * max([needed, *near_rules, *(gap.high for gap in required)])
    edges = 1e3 * np.append(steps.gaps, widest)
    bounds = (np.append(ends, ends[-1]) for ends in (steps.low, steps.high))
    words = f"{100 * assessment.confidence:g} % bounds, {counted(round(one.verdict.independent), 'independent motion')}"
    if isfinite(one.run.widest):
        words += f"; past {say_in(one.run.widest, 'mm', 3)} not run"
    axis.fill_between(edges, *bounds, step="post", color=MOTIONS, alpha=0.15, linewidth=0.0, label=words)
    axis.stairs(steps.probability, edges, baseline=None, color=MOTIONS, linewidth=1.8, label="motions that close it")
    words = f"target {assessment.target:g}"
    axis.axhline(assessment.target, color=style.MEANING["target"], linestyle=":", linewidth=1.2, label=words)
    axis.axvline(1e3 * one.gap, color=style.MEANING["gap"], linewidth=1.4, label=f"the gap, {own(one.gap, GAP)}")
    for gap, dash, height in zip(required, ("--", "-."), (1.04, 1.0), strict=False):
        bar = "bar: bounds" if gap.bounded else "bar: bounds, none above"
        end = f" to {say_in(gap.enough, 'mm', 3)}" if gap.is_between else ""
        needed = f"{'at least ' * gap.at_least}{say_in(gap.provided, 'mm', 3)}{end}"
        words = f"required by {gap.percentile:g} %: {needed} ({bar})"
        axis.axvline(1e3 * gap.gap, color=REQUIRED, linestyle=dash, linewidth=1.4, label=words)
        ends = (1e3 * gap.low, 1e3 * gap.high)
        axis.plot(ends, (height, height), color=REQUIRED, linewidth=3.0, solid_capstyle="butt")
        if not gap.bounded:
            axis.plot(ends[1], height, ">", color=REQUIRED, markersize=6)
    # Combinations as marks along the top, each at its own height as SRSS and CQC are often alike; an arrow at the end
    # stands for a combination beyond the axis.
    for marker, height, name in zip("v^D", HEIGHTS, (name for name in COMBINATIONS if name in rules), strict=False):
        is_beyond = rules[name] > widest
        label = f"{name.upper()}: {say_in(rules[name], 'mm', 3)} of the motions' peaks{bumpers}"
        label += ", beyond the axis" if is_beyond else ""
        place, shape = (widest, ">") if is_beyond else (rules[name], marker)
        axis.plot(1e3 * place, height, shape, color=style.MEANING["rule"], markersize=6, clip_on=False, label=label)
    axis.set(xlabel="gap [mm]", ylabel="P(contact) [1]", xlim=(0.0, 1e3 * widest), ylim=(0.0, 1.19))
    style.legend_under(axis, 2)


def _curves(part: InterfaceAssessment) -> list[Fragility]:
    """The fragility of contact at the gap, fitted or not, and those of yielding that could be fitted."""
    contact = next(curve for curve in part.fragility if curve.what == "contact" and curve.gap == part.gap)
    return [contact, *(curve for curve in part.fragility if curve.what == "yield" and not curve.fault)]


def draw_fragilities(axis: Any, assessment: Assessment, part: InterfaceAssessment) -> None:
    """Lognormal fragilities of contact at the gap and of yielding, with the shares at their intensities."""
    contact, *yield_curves = _curves(part)
    yields = _some_yield_curves(yield_curves, part.own_model)
    if yields:
        some_text = f", {len(yields)} of {len(yield_curves)} curves" if len(yield_curves) > len(yields) else ""
        axis.set_title(f"yielding: {style.law_words(str(yields[0].contact_model))}{some_text}", fontsize=9.5)
    drawn = [curve for curve in (contact, *yields) if not curve.fault]
    label = "P(contact), P(yield) [1]" if any(curve.what == "yield" for curve in drawn) else "P(contact) [1]"
    axis.set(xlabel=intensity_label(assessment.intensity), ylabel=label, ylim=(-0.03, 1.12))
    if not drawn:
        return style.message(axis, f"No fragility at this gap: {contact.fault}")
    _, size = intensity_shown(assessment.intensity)
    largest_im = max(max(curve.median * np.exp(2.2 * curve.dispersion), curve.stripes[-1].im) for curve in drawn)
    im = np.linspace(largest_im / POINTS, largest_im, POINTS)
    for curve, look in zip(drawn, style.STYLES, strict=False):
        _draw_curve(axis, im, curve, look)
    # Intensities at which motions close the gap, where the curve is from scaling and in the measure of the amplitude.
    is_own = contact.intensity == part.intensity
    if contact.method == SCALED and not contact.fault and is_own and part.amplitude is not None:
        reach = np.sort(part.amplitude * part.gap / np.array(part.closing)) * size
        shares = np.arange(1, reach.size + 1) / reach.size
        axis.plot(reach, shares, ".", color=MOTIONS, markersize=6, label="motions, scaled until they close the gap")
    if assessment.hazard_rows:
        _draw_hazard(axis, assessment, part)
    axis.set_xlim(0.0, largest_im * size)
    style.legend_under(axis, 1)


def _some_yield_curves(yields: list[Fragility], model: str) -> list[Fragility]:
    """Some curves of yielding, from the first to the last F_E: of the scene's own contact model or the grid's last."""
    models = [str(curve.contact_model) for curve in yields]
    drawn_model = model if model in models else models[-1] if models else ""
    curves = [curve for curve in yields if curve.contact_model == drawn_model]
    return [curves[index] for index in evenly(len(curves), MOST_YIELD_CURVES)]


def _draw_curve(axis: Any, im: Array, curve: Fragility, look: tuple[str, str]) -> None:
    """Draw one fragility, of contact with the band of its standard errors, and the shares at its intensities."""
    colour, dash = look
    subject = "contact"
    if curve.yield_force is not None:  # where floors never yield, columns do
        subject = f"$F_E$ {own(curve.yield_force, YIELD_FORCE) if np.isfinite(curve.yield_force) else 'of columns'}"
    _, size = intensity_shown(curve.intensity)
    median = say_level(curve.median, intensity_quantity(curve.intensity), 3)
    label = f"{subject}, gap {own(curve.gap, GAP)}: median {median}, dispersion {curve.dispersion:.2f}"
    label += f" ({SCALED}, times {curve.factor:.2g})" if curve.method == SCALED else ""
    axis.plot(im * size, curve.probability(im), color=colour, linestyle=dash, linewidth=1.8, label=label)
    if curve.what == "contact":
        # One standard error to either side, in the argument of the curve (delta method).
        argument = np.log(im / curve.median) / curve.dispersion
        first, second = curve.errors[0], curve.errors[1] * argument
        variance = first**2 + second**2 + 2.0 * curve.correlation * first * second
        spread = np.sqrt(np.maximum(variance, 0.0)) / curve.dispersion
        ends = [fragility_curve(np.exp(argument + side * spread), 1.0, 1.0) for side in (-1.0, 1.0)]
        if np.isfinite(ends).any():  # too few recordings have no error
            words = "one standard error to either side"
            axis.fill_between(im * size, *ends, color=colour, alpha=0.15, linewidth=0.0, label=words)
    if curve.method != SCALED:
        stripes = [stripe for stripe in curve.stripes if stripe.runs]
        ims, shares = ([stripe.im * size for stripe in stripes], [stripe.count / stripe.runs for stripe in stripes])
        sizes = [12.0 + 40.0 * stripe.runs / max(other.runs for other in stripes) for stripe in stripes]
        axis.scatter(ims, shares, sizes, color=colour, alpha=0.55, linewidths=0.0, zorder=3)


def _draw_hazard(axis: Any, assessment: Assessment, part: InterfaceAssessment) -> None:
    """Draw the range of the hazard curve, with the probability of contact in 50 years by motions of that range."""
    unit, size = intensity_shown(assessment.intensity)
    ends = [assessment.hazard_rows[end][0] * size for end in (0, -1)]
    words = f"hazard curve, {ends[0]:.3g} to {ends[1]:.3g} {unit}".rstrip()
    for curve, rate in zip(part.fragility, part.rates, strict=True):
        if curve.what == "contact" and curve.gap == part.gap and not rate.fault:
            words += (
                f": contact in 50 years {'at least ' if rate.at_least else ''}{rounded(100.0 * rate.fifty_years, 2)} %"
            )
            words += f", about {100.0 * rate.missing:.0f} % of contacts beyond it" if rate.at_least else ""
    axis.axvspan(*ends, ymin=0.0, ymax=0.03, color=style.QUIET, alpha=0.6, linewidth=0.0, label=words)


def draw_rates(axis: Any, assessment: Assessment, part: InterfaceAssessment) -> None:
    """The annual rate of contact against the gap with its bounds, the target, the gap, and the gaps for rates."""
    required = [gap for gap in part.gaps_for_rates if not gap.fault]
    lines = rate_lines(part.rates, part.gaps_for_rates)
    lacking = next((gap for gap in part.gaps_for_rates if gap.fault), None)
    axis.set(xlabel="gap [mm]", ylabel="rate of contact [1/year]")
    if not lines.gaps.size:
        return style.message(axis, f"No rate of contact: {lacking.fault if lacking else 'no fragility of contact'}")
    if len(lines.gaps) == 1:
        reason = f". For {lacking.words}: {lacking.fault}" if lacking else ""
        style.message(axis, f"A rate at one gap alone{reason}", 32)
    _draw_rate_lines(axis, lines, assessment)
    axis.set_yscale("log")
    axis.axvline(1e3 * part.gap, color=style.MEANING["gap"], linewidth=1.4, label=f"the gap, {own(part.gap, GAP)}")
    if assessment.target_rate is not None:
        words = f"target {assessment.target_rate_words}"
        axis.axhline(assessment.target_rate, color=style.MEANING["target"], linestyle=":", linewidth=1.4, label=words)
    bars = [gap for gap in required if gap.rate == assessment.target_rate]
    for number, gap in enumerate(required):
        colour, size = (REQUIRED, 8) if gap in bars else (MOTIONS, 5)
        label = f"for {gap.words}: {'at least ' if gap.at_least else ''}{say_in(rounded_up(gap.gap), 'mm', 3)}"
        mark = RATE_MARKS[number % len(RATE_MARKS)]
        axis.plot(1e3 * gap.gap, gap.rate, mark, color=colour, markersize=size, zorder=3, label=label)
    for gap in bars:
        look: dict[str, Any] = {"linewidth": 3.0, "alpha": 0.6, "solid_capstyle": "butt", "label": "its bounds"}
        axis.plot(1e3 * np.array([gap.low, gap.high]), [gap.rate] * 2, color=REQUIRED, **look)
    reach = [part.gap, lines.gaps.min(), *(gap.gap for gap in required), *(gap.high for gap in bars)]
    widest = ROOM * max(length for length in reach if np.isfinite(length))
    is_shown = (lines.gaps <= widest) & (lines.annual > 0.0)
    axis.set_xlim(0.0, 1e3 * widest)
    lowest = lines.low if len(lines.gaps) == 1 else lines.annual
    axis.set_ylim(0.5 * lowest[is_shown].min(initial=required[-1].rate if required else np.inf), None)
    axis.secondary_yaxis("right", functions=(_inverse, _inverse)).set_ylabel("return period [years]")
    style.legend_under(axis, 2)


def _draw_rate_lines(axis: Any, lines: RateLines, assessment: Assessment) -> None:
    """The rate with its bounds: a line in a band, or a mark on a bar at one gap, where a line would not be seen."""
    gaps, bounds = 1e3 * lines.gaps, f"{100 * assessment.confidence:g} % bounds, of the motions alone"
    words, mark = f"contact, under {assessment.hazard}", ""
    if len(gaps) == 1:
        axis.vlines(gaps, lines.low, lines.high, color=MOTIONS, alpha=0.4, linewidth=5.0, label=bounds)
        mark = "o"
    else:
        axis.fill_between(gaps, lines.low, lines.high, color=MOTIONS, alpha=0.15, linewidth=0.0, label=bounds)
    axis.plot(gaps, lines.annual, color=MOTIONS, marker=mark, linewidth=1.8, zorder=3 if mark else 2, label=words)


def _inverse(values: Array) -> Array:
    """Return periods of rates, and rates of return periods."""
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.asarray(values, dtype=float))


def drawn_forces(shares: Sequence[Share]) -> list[float]:
    """The yield forces of a figure of yielding [N], from the least to the largest."""
    forces = sorted({np.nan if share.yield_force is None else share.yield_force for share in shares})
    return [forces[index] for index in evenly(len(forces), MOST_FORCES)]


def draw_yielding(axis: Any, shares: Sequence[Share], gap: float) -> None:
    """P(yield) with bounds against the gap, a line for each of some yield forces, and a mark at the assessed gap."""
    forces = drawn_forces(shares)
    for force, (colour, dash) in zip(forces, style.strength_styles(len(forces)), strict=True):
        force_shares = [share for share in shares if share.yield_force == force]
        gaps = 1e3 * np.array([share.gap for share in force_shares])
        # Marks at the gaps that were run; the line between them only leads the eye.
        marker, words = "o" if len(gaps) <= FEW else "", "columns' own" if np.isinf(force) else style.force_words(force)
        look = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "linewidth": 1.8}
        axis.plot(gaps, [share.probability for share in force_shares], label=words, **look)
        if len(forces) <= 3:
            bounds = np.array([(share.low_recordings, share.high_recordings) for share in force_shares]).T
            axis.fill_between(gaps, *bounds, color=colour, alpha=0.15, linewidth=0.0)
    axis.axvline(1e3 * gap, color=style.MEANING["gap"], linewidth=1.4, label=f"the gap, {own(gap, GAP)}")
    axis.set(xlabel="gap [mm]", ylabel="P(reaching $F_E$) [1]", ylim=(-0.03, 1.03))
    style.legend_under(axis, 3)
