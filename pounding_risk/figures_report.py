"""Figures of a report: small, without titles (a caption stands below each), from numbers alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import StringIO
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.figures_style import NAMELESS, QUIET, STANDARD_GRAVITY, STYLES, blank, plain, styles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
SIZE = (7.2, 3.5)
SMALL = 8.5  # points of legends and notes
FEW = 30  # gaps that are marked
BAND = 0.16  # opacity of bounds
OURS = STYLES[0][0]
MARK = "#000000"


class Line(NamedTuple):
    """A probability along gaps [m], with its bounds."""

    words: str
    gaps: Sequence[float]
    probability: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


class Mark(NamedTuple):
    """A named value on an axis [m]; ``firm`` where it is verified."""

    words: str
    value: float
    firm: bool = True


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


class Ratio(NamedTuple):
    """What a rule asks over what the same motion needs: middle 68 % and median over the motions."""

    words: str
    low: float
    middle: float
    high: float
    firm: bool


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


def report_probabilities(lines: Sequence[Line], gap: float, words: str) -> Figure:
    """Probabilities against the gap with their bounds, and a mark at the assessed gap."""
    figure, axes = blank(1, 1, SIZE)
    axis = axes[0, 0]
    for line, (colour, dash) in zip(lines, styles(len(lines)), strict=True):
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


def report_required(needed: Array, gap: float, marks: Sequence[Mark]) -> Figure:
    """The share of motions that a gap suffices for, from the gap that each needs [m], and what rules ask."""
    figure, axes = blank(1, 1, SIZE)
    axis, ordered = axes[0, 0], np.sort(needed) * 1e3
    steps = 100.0 * np.arange(1, len(ordered) + 1) / len(ordered)
    axis.step(np.r_[0.0, ordered], np.r_[0.0, steps], where="post", color=OURS, linewidth=2.0, label="motions")
    for mark, (colour, dash) in zip(marks, styles(len(marks) + 1)[1:], strict=True):
        label = mark.words if mark.firm else f"{mark.words} (unverified)"
        axis.axvline(1e3 * mark.value, color=colour, linestyle=dash, linewidth=1.5, label=label)
    _mark_gap(axis, gap)
    axis.set(xlabel="gap [mm]", ylabel="motions without contact [%]", ylim=(-3.0, 103.0))
    axis.set_xlim(left=0.0)
    axis.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _mark_gap(axis: Axes, gap: float) -> None:
    axis.axvline(
        gap * 1e3, color=MARK, linewidth=1.0, linestyle=(0, (1, 1.5)), label=f"gap assessed, {gap * 1e3:.4g} mm"
    )


def report_fragility(curves: Sequence[Curve], words: str) -> Figure:
    """Lognormal fragilities with the stripes that they were fitted to; intensities [m/s²] are drawn in g."""
    from scipy.stats import norm

    size = STANDARD_GRAVITY
    figure, axes = blank(1, 1, SIZE)
    axis = axes[0, 0]
    widest = max(stripe.intensity for curve in curves for stripe in curve.stripes)
    at = np.linspace(1e-3, 1.1, 300) * widest
    for curve, (colour, dash) in zip(curves, styles(len(curves)), strict=True):
        share = 100.0 * norm.cdf(np.log(at / curve.median) / curve.dispersion)
        axis.plot(at / size, share, color=colour, linestyle=dash, linewidth=1.8, label=curve.words)
        seen = [(each.intensity / size, 100.0 * each.reached / each.runs) for each in curve.stripes if each.runs]
        axis.plot(*np.array(seen).T, "o", color=colour, markersize=5, markerfacecolor="none")
    axis.set(xlabel=words, ylabel="probability [%]", ylim=(-3.0, 103.0))
    axis.set_xlim(0.0, float(at[-1]) / size)
    axis.legend(fontsize=SMALL)
    return figure


def report_rules(ratios: Sequence[Ratio]) -> Figure:
    """A line for each rule; open marks are of rules that are not verified, squares of those short in the median."""
    figure, axes = blank(1, 1, (SIZE[0], 0.9 + 0.22 * len(ratios)))
    axis = axes[0, 0]
    axis.axvline(1.0, color=MARK, linewidth=1.0)
    for place, each in enumerate(ratios):
        short = each.middle < 1.0
        colour = STYLES[1][0] if short else OURS
        axis.plot([each.low, each.high], [place, place], color=colour, linewidth=2.2)
        face = colour if each.firm else "white"
        axis.plot(each.middle, place, "s" if short else "o", color=colour, markerfacecolor=face, markersize=6)
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
