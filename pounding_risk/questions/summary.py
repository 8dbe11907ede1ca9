"""Sheet of `summary`: how the cases of a dataset ended, and the range of every output."""

from __future__ import annotations

from math import isfinite, isnan
from typing import TYPE_CHECKING

from pounding_risk.render.sheet import Block, Cell, count, facts, listing, table
from pounding_risk.results.summary import IN_RECHECKS

if TYPE_CHECKING:
    from pounding_risk.results.summary import Summary

ORDER = 190
FUNCTION = "results.summary"
HEADS = (("output, of complete cases", "l"), ("contact model", "l"), ("values", "r"), ("least", "r"), ("mean", "r"))


def sheet(summary: Summary) -> list[Block]:
    """Counts of cases, and a line for each output and contact model.

    Parameters
    ----------
    summary : Summary
        An answer of `summary`.
    """
    counts = [(name, count(number)) for name, number in summary.counts.items() if name not in IN_RECHECKS]
    rows = [
        [name, law, count(spread.values), *map(_value, spread[1:]), summary.units[name]]
        for name, spread_of_laws in summary.spreads.items()
        for law, spread in spread_of_laws.items()
    ]
    return [
        facts("", [("title", summary.title), *summary.along, *counts, *summary.rechecks.items()]),
        table("Ranges in SI units.", (*HEADS, ("largest", "r"), ("unit", "l")), rows),
        listing(summary.notes),
    ]


def _value(value: float) -> Cell:
    return {"text": "–" if isnan(value) else f"{value:.6g}", "raw": value if isfinite(value) else None}
