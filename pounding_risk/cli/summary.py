"""The commands `convert` and `summary`: results as another kind of file, and in a few numbers."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.tables import print_pairs, print_table

ORDER = 190
AGAIN = ("made again", "of these sensitive")  # counts that the sentences on them tell
Results = Annotated[
    Path, typer.Argument(metavar="RESULTS", help="Dataset of a scan (.nc or .zarr).", show_default=False)
]


def summary(results: Results) -> None:
    """How a dataset's cases ended, and the range of every output."""
    from pounding_risk.results.summary import summary as run

    print_summary(run(results))


def print_summary(found: Any) -> None:
    """Counts, and a line for each output and contact model."""

    told = [(name, str(count)) for name, count in found.counts.items() if name not in AGAIN]
    print_pairs([("title", found.title), *told, *found.rechecks.items()])
    print()
    rows = [
        (
            name,
            law,
            str(spread.values),
            *("–" if isnan(value) else f"{value:.6g}" for value in spread[1:]),
            found.units[name],
        )
        for name, by_law in found.spreads.items()
        for law, spread in by_law.items()
    ]
    print_table(
        ("output, of complete cases", "contact model", "values", "least", "mean", "largest", ""), rows, "llrrrrl"
    )
    print_notes(found.notes)
