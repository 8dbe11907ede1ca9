"""The commands `convert` and `summary`: results as another kind of file, and in a few numbers."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.options import writable

AGAIN = ("made again", "of these sensitive")  # counts that the sentences on them tell
Results = Annotated[
    Path, typer.Argument(metavar="RESULTS", help="Dataset of a scan (.nc or .zarr).", show_default=False)
]


def convert(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="A dataset of any command (.nc or .zarr).", show_default=False)
    ],
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="Where it goes (.zarr or .nc).", show_default=False)],
) -> None:
    """Write a dataset as Zarr or as netCDF, whatever its size."""
    from pounding_risk.results.files import RESULTS
    from pounding_risk.studies.convert import convert as run

    writable("TARGET", target, RESULTS)
    typer.echo(f"written: {run(source, target)}")


def summary(results: Results) -> None:
    """How a dataset's cases ended, and the range of every output."""
    from pounding_risk.results.summary import summary as run

    print_summary(run(results))


def print_summary(found: Any) -> None:
    """Counts, and a line for each output and contact model."""
    from pounding_risk.cli._common.tables import print_pairs, print_table
    from pounding_risk.cli.simulate import print_notes

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
