"""Figure of advice on a contact: how the main outputs change with its stiffness, with the range to take shaded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.figures.style import QUIET, STYLES, Figure, beside, blank, legend_below, message, plain, title
from pounding_risk.units import SHOWN

if TYPE_CHECKING:
    from pounding_risk.studies.advice import Advice
    from pounding_risk.studies.advice_stiffness import StiffnessRange

MOST_PANELS = 3  # interfaces that are drawn, the first ones
BAND = "#009E73"
LINE = 9.5  # points between the labels of two curves
# Words, marker, colour and dash of each output that is drawn.
DRAWN = {
    "peak_contact_force": ("peak contact force", "o", *STYLES[0]),
    "peak_floor_acceleration": ("peak floor acceleration", "s", *STYLES[1]),
    "impulse": ("impulse", "^", *STYLES[2]),
    "impact_count": ("impact count", "D", *STYLES[3]),
    "peak_displacement": ("peak displacement", "v", "#000000", "-"),
}


def advice_figure(advice: Advice, note: str = "") -> Figure:
    """Median outputs against the contact stiffness, over those with the scene's, a panel for each interface.

    Parameters
    ----------
    advice : Advice
        Advice on a scene whose contact has a stiffness.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        The recommended range is shaded, the scene's stiffness a dotted line, published rules ticks at the foot. Of the
        two buildings at an interface the one is drawn whose output changes more. Without any contact, or any
        stiffness, the panel says so.
    """
    ranges = advice.ranges[:MOST_PANELS]
    figure, axes = blank(1, max(len(ranges), 1), size=(5.4 + 4.2 * max(len(ranges), 1), 5.4), sharey=True)
    if not ranges or not advice.influences:
        reason = "no contact in any case" if ranges else "the contact model has no stiffness"
        message(axes[0, 0], reason)
    reach, labels = [1.0], []
    for axis, stiffness_range in zip(axes.flat, ranges, strict=False):
        panel_ratios, panel_labels = _panel(axis, advice, stiffness_range)
        reach += panel_ratios
        labels.append(panel_labels)
    axes[0, 0].set_ylim(min(0.5, 0.8 * min(reach)), max(2.0, 1.25 * max(reach)))
    axes[0, 0].set_ylabel("median over that with the scene's stiffness [1]")
    left_out = len(advice.ranges) - len(ranges)
    more_text = f"; {counted(left_out, 'more interface')} not drawn" if left_out else ""
    condition = (
        f"{plain(advice.scene)}; gap {advice.gap}; {advice.touched} of {counted(advice.cases, 'case')} with contact; "
        "shaded: contacts longer than a wave's passage through a floor and shorter than a tenth of the shorter "
        f"period; dotted: the scene's stiffness; ticks at the foot: published rules{more_text}"
    )
    title(figure, plain(advice.finding), condition, note)
    handles = axes[0, 0].get_legend_handles_labels()[0]
    if handles:
        legend_below(figure, handles, len(handles))
    figure.draw_without_rendering()  # which lays the panels out
    for panel_labels in labels:
        lowest = -np.inf  # points; a label that would overlap the one below is lifted
        for label in sorted(panel_labels, key=lambda label: float(label.xy[1])):
            height = label.axes.transData.transform(label.xy)[1] * 72.0 / label.axes.figure.dpi
            position = max(height, lowest)
            label.set_position((5, position - height))
            lowest = position + LINE
    return figure


def _panel(axis: Any, advice: Advice, stiffness_range: StiffnessRange) -> tuple[list[float], list[Any]]:
    """The curves of one interface; the values drawn, and the labels at their ends."""
    _frame(axis, stiffness_range)
    # The curve of each output whose values change most: at the interface, or of a building beside it that is no wall.
    places = [stiffness_range.interface, *(name for name in stiffness_range.buildings if name != stiffness_range.wall)]
    drawn_ratios: list[float] = []
    labels: list[Any] = []
    for output, (words, marker, colour, dash) in DRAWN.items():
        curves = [advice.influence("stiffness", output, place) for place in places]
        candidates = [curve for curve in curves if curve is not None and curve.verdict]
        if not candidates:
            continue
        curve = max(candidates, key=lambda curve: float(np.nanmax(np.abs(curve.medians))))
        ratios = 1.0 + np.array(curve.medians)
        ratios[~(ratios > 0.0)] = np.nan  # none at all has no place on an axis of powers of ten
        multiples = np.array([float(text.removeprefix("× ")) for text in curve.tried])
        stiffnesses = SHOWN[stiffness_range.unit][1] * stiffness_range.own * multiples
        axis.plot(stiffnesses, ratios, dash, color=colour, marker=marker, markersize=5, label=words)
        drawn_ratios += ratios[np.isfinite(ratios)].tolist()
        if curve.place != stiffness_range.interface and np.isfinite(ratios[-1]):
            end = float(stiffnesses[-1]), float(ratios[-1])
            labels.append(beside(axis, plain(curve.place), end, (5, 0), 7.5, color=colour))
    return drawn_ratios, labels


def _frame(axis: Any, stiffness_range: StiffnessRange) -> None:
    """Axes with the range, the scene's stiffness and the published rules."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_title(plain(stiffness_range.interface), fontsize=10, loc="left")
    unit, factor = SHOWN[stiffness_range.unit]
    own_stiffness = factor * stiffness_range.own
    axis.set_xlabel(f"contact stiffness [{unit.replace('^1.5', '$^{1.5}$')}]")
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.set_xlim(own_stiffness / 200.0, own_stiffness * 400.0)
    if not stiffness_range.is_empty:
        axis.axvspan(factor * stiffness_range.low, factor * stiffness_range.high, color=BAND, alpha=0.15, linewidth=0)
    axis.axvline(own_stiffness, color=QUIET, linestyle=":", linewidth=1.2)
    low, high = axis.get_xlim()
    for rule in stiffness_range.rules:
        if low < factor * rule.equivalent < high:
            ends = [factor * rule.equivalent] * 2, [0.0, 0.03]
            axis.plot(*ends, color="black", linewidth=1.4, transform=axis.get_xaxis_transform())
