"""Figure of advice on a contact: how the main outputs change with its stiffness, with the range to take shaded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.figures.style import QUIET, STYLES, blank, legend_below, plain, title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.studies.advice import Advice, Influence
    from pounding_risk.studies.advice_stiffness import StiffnessRange

MOST_PANELS = 3  # interfaces that are drawn, the first ones
BAND = "#009E73"
# Outputs in the order of their colours, dashes and markers.
DRAWN = {
    "peak_contact_force": ("peak contact force", "o"),
    "peak_floor_acceleration": ("peak floor acceleration", "s"),
    "impulse": ("impulse", "^"),
    "impact_count": ("impact count", "D"),
    "peak_displacement": ("peak displacement", "v"),
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
    figure, axes = blank(1, max(len(ranges), 1), size=(4.0 + 4.2 * max(len(ranges), 1), 5.4), sharey=True)
    if not ranges or not advice.influences:
        reason = "no contact in any case" if ranges else "the contact model has no stiffness"
        axes[0, 0].text(0.5, 0.5, reason, ha="center", color=QUIET, transform=axes[0, 0].transAxes)
    for axis, one in zip(axes.flat, ranges, strict=False):
        _panel(axis, advice, one)
    axes[0, 0].set_ylabel("median over that with the scene's stiffness [-]")
    left_out = len(advice.ranges) - len(ranges)
    more = f"; {counted(left_out, 'more interface')} not drawn" if left_out else ""
    condition = (
        f"{plain(advice.scene)}; gap {advice.gap}; {advice.touched} of {counted(advice.cases, 'case')} with contact; "
        "shaded: contacts longer than a wave's passage through a floor and shorter than a tenth of the shorter "
        f"period; dotted: the scene's stiffness; ticks at the foot: published rules{more}"
    )
    title(figure, plain(advice.finding), condition, note)
    handles = axes[0, 0].get_legend_handles_labels()[0]
    if handles:
        legend_below(figure, handles, len(handles))
    return figure


def _panel(axis: Any, advice: Advice, one: StiffnessRange) -> None:
    """The curves of one interface."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_title(plain(one.interface), fontsize=10, loc="left")
    axis.set_xlabel(f"contact stiffness [{one.unit.replace('^1.5', '$^{1.5}$')}]")
    if not one.is_empty:
        axis.axvspan(one.low, one.high, color=BAND, alpha=0.15, linewidth=0)
    axis.axvline(one.own, color=QUIET, linestyle=":", linewidth=1.2)
    drawn = []
    for number, (output, (words, marker)) in enumerate(DRAWN.items()):
        curve = _widest(advice, one, output)
        if curve is None:
            continue
        place = "" if curve.place == one.interface else f", {curve.place}"
        colour, dash = STYLES[number]
        values = 1.0 + np.array(curve.medians)
        stiffnesses = one.own * np.array([float(text.removeprefix("× ")) for text in curve.tried])
        axis.plot(stiffnesses, values, dash, color=colour, marker=marker, markersize=5, label=words)
        drawn.append(values)
        if place:
            axis.annotate(
                plain(place.removeprefix(", ")),
                (stiffnesses[-1], values[-1]),
                xytext=(4, 0),
                textcoords="offset points",
                fontsize=7.5,
                color=colour,
                va="center",
            )
    if drawn:
        ends = np.concatenate(drawn)
        ends = ends[np.isfinite(ends) & (ends > 0.0)]
        axis.set_ylim(min(0.5, 0.8 * ends.min()), max(2.0, 1.25 * ends.max()))
        axis.set_xlim(one.own / 200.0, one.own * 400.0)
    foot = axis.get_xaxis_transform()
    rules = [rule.equivalent for rule in one.rules]
    low, high = axis.get_xlim()
    for value in rules:
        if low < value < high:
            axis.plot([value, value], [0.0, 0.03], color="black", linewidth=1.4, transform=foot)
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_formatter(NullFormatter())


def _widest(advice: Advice, one: StiffnessRange, output: str) -> Influence | None:
    """The curve of an output: at the interface, or of that building beside it, no wall, whose values change most."""
    places = [one.interface, *(name for name in one.buildings if name != one.wall)]
    curves = [advice.influence("stiffness", output, place) for place in places]
    defined = [curve for curve in curves if curve is not None and curve.verdict]
    return max(defined, key=lambda curve: float(np.nanmax(np.abs(curve.medians))), default=None)
