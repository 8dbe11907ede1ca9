"""Figure of code separations beside the gaps that motions need."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.separations.rules import COMBINATIONS, DERIVED, READ
from pounding_risk.assessment.separations.table import CodeTable, Comparison
from pounding_risk.figures.style import MEANING, RULE_MARKS_WORDS, blank, rule_mark, title
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import say_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_NAMES = 48  # motions that are named below the axis; more are not
MARKS = (("^", "-"), ("s", "--"), ("D", "-."))  # of ABS, SRSS and CQC, then again


def separations_figure(table: CodeTable, note: str = "") -> Figure:
    """Separations that rules ask for beside the gaps that motions need.

    Parameters
    ----------
    table : CodeTable
        As `code_table` gives it.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Left: the gap that each motion needs, and what ABS, SRSS and CQC ask for. Right: every rule over that gap.
    """
    drawn = [comparison for comparison in table.rules if comparison.exceeded is not None]
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
        axis.set_xticks(positions, [_short(table.names[at]) for at in order], rotation=90, fontsize=7)
    else:
        axis.set_xlabel("motion, by the gap it needs")
    axis.set_ylabel("separation [mm]")
    axis.set_ylim(bottom=0.0)
    axis.set_title(
        "what each motion needs, and rules of its own elastic peaks (no code's design displacement)", fontsize=9.5
    )
    axis.legend(fontsize=8.5, loc="upper left", handlelength=3.0)


def _short(name: str) -> str:
    """Name of a motion, shortened for a tick label."""
    return name.removesuffix(" as recorded").replace(" reversed", " rev.")


def _by_rule(axis: Any, drawn: list[Comparison], table: CodeTable) -> None:
    """Median and middle 68 % of each rule over the gap needed; squares are of rules that fall short in some motion."""
    axis.axvline(1.0, color="black", linewidth=0.9)
    colour = MEANING["rule"]
    for row, comparison in enumerate(drawn):
        axis.plot([comparison.ratio_low, comparison.ratio_high], [row, row], color=colour, linewidth=2.2)
        axis.plot(
            comparison.ratio_median, row, "o" if comparison.safe else "s", **rule_mark(comparison.row.verification)
        )
        short = round((comparison.exceeded or 0.0) * table.motions)
        words = f"short in {short} of {table.motions}" if short else "holds in all"
        where = {"transform": axis.get_yaxis_transform(), "ha": "left", "va": "center", "fontsize": 8.5}
        axis.text(1.01, row, words, weight="bold" if short else "normal", **where)
    axis.set_yticks(range(len(drawn)), [_rule_words(comparison) for comparison in drawn], fontsize=8.5)
    axis.set_ylim(max(len(drawn), 1) - 0.5, -0.5)
    axis.set_xlabel("rule over the gap needed [1]: median, 16-84 % of the motions")
    axis.set_title(f"safe right of 1; {RULE_MARKS_WORDS}", fontsize=8.5)


def _rule_words(comparison: Comparison) -> str:
    """Title of a rule, with what keeps its clause from being relied on."""
    row = comparison.row
    doubts = [] if row.verification in (DERIVED, READ) else [row.verification]
    doubts += ["superseded"] if row.superseded else []
    return f"{row.title} ({', '.join(doubts)})" if doubts else row.title
