"""Figures of a report: small, without titles (a caption stands below each), from numbers alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import StringIO
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.figures.style import (
    MEANING,
    NAMELESS,
    QUIET,
    STANDARD_GRAVITY,
    blank,
    contact_styles,
    plain,
    rule_mark,
    strength_styles,
    styles,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pounding_risk.assessment.required_gap import ContactSteps

Array = NDArray[np.float64]
SIZE = (7.2, 3.5)
SMALL = 8.5  # points of legends and notes
FEW = 30  # gaps that are marked
BAND = 0.16  # opacity of bounds
OURS = MEANING["motions"]
WIDER = 1.15  # times the widest gap of a figure: where its axis ends


class Line(NamedTuple):
    """A probability along gaps [m], with its bounds."""

    words: str
    gaps: Sequence[float]
    probability: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


class Judged(NamedTuple):
    """What P(contact) is held against: the gap [m], the target, and the gap required for it with its bounds [m]."""

    gap: float
    target: float
    percentile: float  # %, of the required gap
    required: float
    low: float
    high: float
    is_bounded: bool  # else ``high`` is only the largest closing seen


class Stripe(NamedTuple):
    """Cases at one intensity, and how many of them reach what is asked."""

    intensity: float
    reached: int
    runs: int


class Curve(NamedTuple):
    """A lognormal fragility and the stripes that it was fitted to."""

    words: str
    median: float
    dispersion: float
    stripes: Sequence[Stripe]
    is_contact: bool  # else of yielding


class Ratio(NamedTuple):
    """What a rule asks over what the same motion needs: middle 68 % and median over the motions."""

    words: str
    low: float
    middle: float
    high: float
    verification: str


class Spread(NamedTuple):
    """Median and middle 68 % of an output, by contact model."""

    name: str
    low: float
    middle: float
    high: float


def svg_text(figure: Figure) -> str:
    """A figure as SVG to stand within a page: letters as outlines, the same bytes for the same data, no prologue."""
    from matplotlib import rc_context

    stream = StringIO()
    with rc_context({"svg.hashsalt": "pounding_risk", "svg.fonttype": "path"}):
        figure.savefig(stream, format="svg", metadata=NAMELESS[".svg"])
    text = stream.getvalue()
    # What tells of the format and its vocabulary is for files that stand alone.
    return re.sub(r"\s*<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL).strip()


def report_spectra(periods: Array, spectra: Array, buildings: Sequence[tuple[str, float]]) -> Figure:
    """Each record's Sa [m/s²], (records, periods), median, 16th and 84th percentile, and the buildings' periods."""
    figure, axes = blank(1, 1, SIZE)
    axis, values = axes[0, 0], spectra / STANDARD_GRAVITY
    many = len(values) > 1
    words = f"{len(values)} records" if many else "the record"
    look: dict[str, Any] = {"color": "#9a9a9a", "linewidth": 0.7} if many else {"color": OURS, "linewidth": 2.0}
    for place, each in enumerate(values):
        axis.plot(periods, each, label="" if place else words, **look)
    if many:
        axis.plot(periods, np.median(values, axis=0), color=OURS, linewidth=2.4, label="median")
    if len(values) > 2:
        for place, level in enumerate((16.0, 84.0)):
            label = "" if place else "16th and 84th percentile"
            axis.plot(periods, np.percentile(values, level, axis=0), "--", color=OURS, linewidth=1.3, label=label)
    for (name, period), (colour, dash) in zip(buildings, styles(len(buildings) + 1)[1:], strict=True):
        if periods[0] <= period <= periods[-1]:
            axis.axvline(period, color=colour, linestyle=dash, linewidth=1.6, label=f"{plain(name)}, {period:.3g} s")
    axis.set(xscale="log", yscale="log", xlabel="period [s]", ylabel="spectral acceleration [g]")
    axis.set_xlim(periods[0], periods[-1])
    for scale in (axis.xaxis, axis.yaxis):
        scale.set_major_formatter("{x:g}")
    axis.legend(fontsize=SMALL, loc="lower left")
    return figure


def report_contact(contact: ContactSteps, judged: Judged) -> Figure:
    """P(contact) as the steps that the motions give, with bounds, target, the required gap and the gap judged."""
    figure, axes = blank(1, 1, SIZE)
    axis = axes[0, 0]
    widest = WIDER * max(float(contact.gaps[-1]), judged.gap, judged.high, 1e-6)
    edges = 1e3 * np.append(contact.gaps, widest)
    low, high = 100.0 * contact.low, 100.0 * contact.high
    axis.fill_between(
        edges, np.append(low, low[-1]), np.append(high, high[-1]), step="post", color=OURS, alpha=BAND, linewidth=0.0,
        label="bounds by recording",
    )  # fmt: skip
    axis.stairs(100.0 * contact.probability, edges, baseline=None, color=OURS, linewidth=2.0, label="motions")
    words = f"target, {100.0 * judged.target:.4g} %"
    axis.axhline(100.0 * judged.target, color=MEANING["target"], linestyle=":", linewidth=1.4, label=words)
    _mark_required(axis, judged)
    _mark_gap(axis, judged.gap)
    axis.set(xlabel="gap [mm]", ylabel="probability of contact [%]", xlim=(0.0, 1e3 * widest), ylim=(-3.0, 109.0))
    axis.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _mark_required(axis: Axes, judged: Judged) -> None:
    """The gap that a percentile of the motions requires, and its bounds as a bar, with an arrow where there is none."""
    colour = MEANING["required gap"]
    words = f"required by {judged.percentile:g} %, {1e3 * judged.required:.4g} mm"
    axis.axvline(1e3 * judged.required, color=colour, linestyle="--", linewidth=1.5, label=words)
    bounds = "its bounds" if judged.is_bounded else "its bounds, none above"
    bar, end = (1e3 * judged.low, 1e3 * judged.high), 105.0
    axis.plot(bar, (end, end), color=colour, linewidth=3.0, solid_capstyle="butt", label=bounds)
    if not judged.is_bounded:
        axis.plot(bar[1], end, ">", color=colour, markersize=6)


def report_probabilities(lines: Sequence[Line], gap: float, words: str) -> Figure:
    """Probabilities of yielding against the gap with their bounds, by yield force, and a mark at the assessed gap."""
    figure, axes = blank(1, 1, SIZE)
    axis = axes[0, 0]
    for line, (colour, dash) in zip(lines, strength_styles(len(lines)), strict=True):
        at = np.asarray(line.gaps) * 1e3
        # Marks where it was counted; between them the line only leads the eye.
        marker = "o" if len(at) <= FEW else ""
        share = 100.0 * np.asarray(line.probability)
        axis.plot(at, share, color=colour, linestyle=dash, marker=marker, markersize=4, linewidth=1.8, label=line.words)
        if len(lines) <= 3:
            bounds = 100.0 * np.asarray(line.low), 100.0 * np.asarray(line.high)
            axis.fill_between(at, *bounds, color=colour, alpha=BAND, linewidth=0.0)
    _mark_gap(axis, gap)
    axis.set(xlabel="gap [mm]", ylabel=f"{words} [%]", ylim=(-3.0, 103.0))
    axis.legend(fontsize=SMALL)
    return figure


def _mark_gap(axis: Axes, gap: float) -> None:
    axis.axvline(1e3 * gap, color=MEANING["gap"], linewidth=1.4, label=f"gap assessed, {gap * 1e3:.4g} mm")


def report_fragility(curves: Sequence[Curve], words: str) -> Figure:
    """Lognormal fragilities with the stripes that they were fitted to; intensities [m/s²] are drawn in g."""
    from scipy.stats import norm

    size = STANDARD_GRAVITY
    figure, axes = blank(1, 1, SIZE)
    axis = axes[0, 0]
    widest = max(stripe.intensity for curve in curves for stripe in curve.stripes)
    at = np.linspace(1e-3, 1.1, 300) * widest
    of_contact = contact_styles(sum(curve.is_contact for curve in curves))
    of_yielding = strength_styles(len(curves) - len(of_contact))
    for curve in curves:
        colour, dash = (of_contact if curve.is_contact else of_yielding).pop(0)
        share = 100.0 * norm.cdf(np.log(at / curve.median) / curve.dispersion)
        axis.plot(at / size, share, color=colour, linestyle=dash, linewidth=1.8, label=curve.words)
        seen = [(each.intensity / size, 100.0 * each.reached / each.runs) for each in curve.stripes if each.runs]
        axis.plot(*np.array(seen).T, "o", color=colour, markersize=5, markerfacecolor="none")
    axis.set(xlabel=words, ylabel="probability [%]", ylim=(-3.0, 103.0))
    axis.set_xlim(0.0, float(at[-1]) / size)
    axis.legend(fontsize=SMALL)
    return figure


def report_rules(ratios: Sequence[Ratio]) -> Figure:
    """A line for each rule: squares are of those short in the median, marks as in `figures_style.RULE_MARKS`."""
    figure, axes = blank(1, 1, (SIZE[0], 0.9 + 0.22 * len(ratios)))
    axis, colour = axes[0, 0], MEANING["rule"]
    axis.axvline(1.0, color="black", linewidth=1.0)
    for place, each in enumerate(ratios):
        axis.plot([each.low, each.high], [place, place], color=colour, linewidth=2.2)
        axis.plot(each.middle, place, "s" if each.middle < 1.0 else "o", **rule_mark(each.verification))
    axis.set_yticks(range(len(ratios)), [each.words for each in ratios], fontsize=SMALL)
    axis.set_ylim(len(ratios) - 0.5, -0.5)
    axis.set_xlim(left=0.0)
    axis.set_xlabel("rule over the gap needed")
    return figure


def report_models(panels: Sequence[tuple[str, Sequence[Spread]]]) -> Figure:
    """A panel for each output: median and middle 68 % of the motions under each contact model."""
    rows = max(len(spreads) for _, spreads in panels)
    figure, axes = blank(1, len(panels), (SIZE[0], 1.4 + 0.3 * rows), sharey=True)
    for axis, (words, spreads) in zip(axes[0], panels, strict=True):
        for place, each in enumerate(spreads):
            axis.plot([each.low, each.high], [place, place], color=OURS, linewidth=5, alpha=0.35, solid_capstyle="butt")
            axis.plot(each.middle, place, "o", color=OURS, markersize=6)
        axis.set_xlabel(fill(words, 20), fontsize=9.5)
        axis.set_xlim(left=0.0)
    axes[0, 0].set_yticks(range(rows), [plain(each.name) for each in panels[0][1]], fontsize=9)
    axes[0, 0].set_ylim(rows - 0.5, -0.5)
    axes[0, 0].tick_params(axis="y", colors=QUIET, labelcolor="black")
    return figure
