"""The command `summary`: how the cases of a dataset ended, and the range of every output."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING

from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.options import NONE, Results, Select, chosen_results
from pounding_risk.render.terminal import print_pairs, print_table

if TYPE_CHECKING:
    from pounding_risk.results.summary import Summary

ORDER = 190


def summary(results: Results, select: Select = NONE) -> None:
    """How a dataset's cases ended, and the range of every output."""
    from pounding_risk.results.summary import summary as run

    print_summary(run(chosen_results(results, select, partly=True)))


def print_summary(summary: Summary) -> None:
    """Print the counts of cases, and a line for each output and contact model."""
    from pounding_risk.results.summary import IN_RECHECKS

    counts = [(name, str(count)) for name, count in summary.counts.items() if name not in IN_RECHECKS]
    print_pairs([("title", summary.title), *summary.along, *counts, *summary.rechecks.items()])
    print()
    rows = [
        (
            name,
            law,
            str(spread.values),
            *("–" if isnan(value) else f"{value:.6g}" for value in spread[1:]),
            summary.units[name],
        )
        for name, spread_of_laws in summary.spreads.items()
        for law, spread in spread_of_laws.items()
    ]
    heads = ("output, of complete cases", "contact model", "values", "least", "mean", "largest", "")
    print_table(heads, rows, "llrrrrl")
    print_notes(summary.notes)
