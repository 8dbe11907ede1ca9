"""Sheet of `summary`: how the cases of a dataset ended, and the range of every output."""

from __future__ import annotations

from pounding_risk.render.sheet import Block, count, facts, listing, table, worded
from pounding_risk.results.summary import IN_RECHECKS, Summary

ORDER = 190
FUNCTION = "results.summary"
HEADS = ("output, of complete cases", "contact model", "values", "least", "mean", "largest", "unit")


def sheet(summary: Summary) -> list[Block]:
    """Counts of cases, and a line for each output and contact model."""
    counts = [(name, count(number)) for name, number in summary.counts.items() if name not in IN_RECHECKS]
    units = {name: unit.replace("m/s2", "m/s²") for name, unit in summary.units.items()}
    rows = [
        [name, law, count(spread.values), *(worded(number, f"{number:.6g}") for number in spread[1:]), units[name]]
        for name, spread_of_laws in summary.spreads.items()
        for law, spread in spread_of_laws.items()
    ]
    return [
        facts("", [("title", summary.title), *summary.along, *counts, *summary.rechecks.items()]),
        table("Ranges in SI units.", HEADS, rows),
        listing(summary.notes),
    ]
