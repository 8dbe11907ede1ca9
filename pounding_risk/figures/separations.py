"""Figure of code separations beside the gaps that motions need."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np

from pounding_risk.assessment.separations.rules import COMBINATIONS, DERIVED, READ
from pounding_risk.assessment.separations.table import CodeTable, Comparison
from pounding_risk.figures.style import MEANING, RULE_MARKS_WORDS, Figure, blank, rule_mark, title
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import say_in

MOST_NAMES = 48  # motions that are named below the axis; more are not
MARKS = (("^", "-"), ("s", "--"), ("D", "-."))  # of ABS, SRSS and CQC, then again


def separations_figure(table: CodeTable, note: str = "") -> Figure:
    """Separations that rules require beside the gaps that motions need.

    Parameters
    ----------
    table : CodeTable
        As `code_table` gives it.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Left: the gap that each motion needs, and what ABS, SRSS and CQC require. Right: every rule over that gap.
    """
    drawn = [comparison for comparison in table.rules if comparison.exceeded is not None]
    figure, axes = blank(1, 2, (13.5, 3.4 + 0.19 * max(len(drawn), 10)), width_ratios=(1.25, 1.0))
    layout: Any = figure.get_layout_engine()
    layout.set(h_pad=0.1)  # room for the motions' names
    _by_motion(axes[0, 0], table)
    draw_rules(axes[0, 1], drawn, table.motions)
    axes[0, 1].set_title(f"safe right of 1; {RULE_MARKS_WORDS}".replace("; full", "\nfull"), fontsize=8.5)
    left, right = table.buildings
    correlation = "" if table.correlation is None else f", correlation {table.correlation:.2f} under white noise"
    title(figure, table.finding, f"{left} | {right}, motions {table.at}{correlation}", note)
    return figure


def _by_motion(axis: Any, table: CodeTable) -> None:
    """Draw the motions in the order of the gap they need."""
    order = np.argsort(table.closing)
    positions = np.arange(order.size)
    for (mark, dash), name in zip(cycle(MARKS), COMBINATIONS, strict=False):
        separations = 1e3 * np.array(table.asked[name])[order]
        look: dict[str, Any] = {"color": MEANING["rule"], "linestyle": dash, "linewidth": 0.8, "markersize": 4.5}
        axis.plot(positions, separations, mark, label=name.upper(), **look)
    needed = 1e3 * np.array(table.closing)[order]
    axis.plot(positions, needed, "o", color=MEANING["motions"], markersize=5.0, label="gap needed")
    label = f"required by {table.percentile:g} %: {say_in(rounded_up(table.demand), 'mm', 3)}"
    axis.axhline(1e3 * table.demand, color=MEANING["required gap"], linestyle="--", linewidth=1.2, label=label)
    if order.size <= MOST_NAMES:
        names = [table.names[index].removesuffix(" as recorded").replace(" reversed", " rev.") for index in order]
        axis.set_xticks(positions, names, rotation=90, fontsize=7)
    else:
        axis.set_xlabel("motion, by the gap it needs")
    axis.set_ylabel("separation [mm]")
    axis.set_ylim(0.0, 1.25 * axis.dataLim.y1 or None)  # the legend stands above the motions
    words = "what each motion needs, and rules of its own peaks\n(no code's design displacement)"
    axis.set_title(words, fontsize=9.5)
    axis.legend(fontsize=8.5, loc="upper center", handlelength=3.0, ncols=2)


def draw_rules(axis: Any, compared: Sequence[Comparison], motions: int) -> None:
    """Median and middle 68 % of each rule over the gap needed; squares: insufficient for some of so many motions."""
    axis.axvline(1.0, color="black", linewidth=0.9)
    names = []
    for row, rule in enumerate(compared):
        axis.plot([rule.ratio_low, rule.ratio_high], [row, row], color=MEANING["rule"], linewidth=2.2)
        axis.plot(rule.ratio_median, row, "o" if rule.safe else "s", **rule_mark(rule.row.verification))
        insufficient = round((rule.exceeded or 0.0) * motions)
        look = {"transform": axis.get_yaxis_transform(), "ha": "left", "va": "center", "fontsize": 8.5}
        axis.text(1.02, row, f"{insufficient} of {motions}", weight="bold" if insufficient else "normal", **look)
        doubts = [] if rule.row.verification in (DERIVED, READ) else [rule.row.verification]
        doubts += ["superseded"] if rule.row.superseded else []
        names.append(f"{rule.row.title} ({', '.join(doubts)})" if doubts else rule.row.title)
    axis.set_yticks(range(len(compared)), names, fontsize=8.5)
    axis.set_ylim(max(len(compared), 1) - 0.5, -0.5)
    axis.set_xlim(0.0, 1.05 * max(1.0, axis.dataLim.x1))
    axis.set_xlabel("rule over the gap needed [1]: median, 16-84 %\nright: motions that it is insufficient for")
