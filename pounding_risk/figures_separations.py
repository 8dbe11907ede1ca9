"""Figure of code separations beside the gaps that motions need."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.figures_style import QUIET, STYLES, blank, title
from pounding_risk.separations import COMBINATIONS, CodeTable, Comparison

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_NAMES = 48  # motions that are named below the axis; more are not
MARKS = ("^", "s", "D")


def separations_figure(table: CodeTable, note: str = "") -> Figure:
    """Left: the gap that each motion needs, and what ABS, SRSS and CQC ask for. Right: every rule over that gap."""
    drawn = [each for each in table.rules if each.exceeded is not None]
    figure, axes = blank(1, 2, (13.5, 3.4 + 0.19 * max(len(drawn), 10)), width_ratios=(1.25, 1.0))
    layout: Any = figure.get_layout_engine()
    layout.set(h_pad=0.1)  # room for the motions' names
    _by_motion(axes[0, 0], table)
    _by_rule(axes[0, 1], drawn, table)
    left, right = table.buildings
    correlation = "" if table.correlation is None else f", correlation {table.correlation:.2f} under white noise"
    title(figure, table.finding, f"{left} | {right}, motions {table.at}{correlation}", note)
    return figure


def _by_motion(axis: Any, table: CodeTable) -> None:
    """Motions in the order of the gap they need."""
    order = np.argsort(table.closing)
    place = np.arange(order.size)
    for (colour, dash), mark, name in zip(STYLES, MARKS, COMBINATIONS, strict=False):
        asked = 1e3 * np.array(table.asked[name])[order]
        axis.plot(place, asked, mark, color=colour, linestyle=dash, linewidth=0.8, markersize=4.5, label=name.upper())
    axis.plot(place, 1e3 * np.array(table.closing)[order], "o", color="black", markersize=5.0, label="gap needed")
    told = f"that of {table.percentile:g} %: {1e3 * table.demand:.1f} mm"
    axis.axhline(1e3 * table.demand, color=QUIET, linestyle=":", linewidth=1.2, label=told)
    if order.size <= MOST_NAMES:
        axis.set_xticks(place, [_short(table.names[at]) for at in order], rotation=90, fontsize=7)
    else:
        axis.set_xlabel("motion, by the gap it needs")
    axis.set_ylabel("separation [mm]")
    axis.set_ylim(bottom=0.0)
    axis.set_title("what each motion needs, and what is asked for from its own spectrum", fontsize=9.5)
    axis.legend(fontsize=8.5, loc="upper left", handlelength=3.0)


def _short(name: str) -> str:
    """A motion's name as short as a tick's label has to be."""
    return name.removesuffix(" as recorded").replace(" reversed", " rev.")


def _by_rule(axis: Any, drawn: list[Comparison], table: CodeTable) -> None:
    """Median and middle 68 % of each rule over the gap needed; an open mark where the clause is not verified."""
    axis.axvline(1.0, color="black", linewidth=0.9)
    for row, each in enumerate(drawn):
        colour = "#0072B2" if each.safe else "#D55E00"
        axis.plot([each.ratio_low, each.ratio_high], [row, row], color=colour, linewidth=2.2)
        face = colour if each.row.verified else "white"
        axis.plot(each.ratio_median, row, "o" if each.safe else "s", color=colour, markerfacecolor=face, markersize=6)
        short = round((each.exceeded or 0.0) * table.motions)
        told = f"short in {short} of {table.motions}" if short else "holds in all"
        where = {"transform": axis.get_yaxis_transform(), "ha": "left", "va": "center", "fontsize": 8.5}
        axis.text(1.01, row, told, color=colour, **where)
    words = [each.row.title + ("" if each.row.verified else " (not verified)") for each in drawn]
    axis.set_yticks(range(len(drawn)), words, fontsize=8.5)
    axis.set_ylim(max(len(drawn), 1) - 0.5, -0.5)
    axis.set_xlabel("rule over the gap needed [1]: median, 16-84 % of the motions")
    axis.set_title("safe right of 1", fontsize=9.5)
