"""The command `report`: what an engineer hands over, from a dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import writable
from pounding_risk.cli._common.options import (
    Amplitude,
    Confidence,
    Hazard,
    Intensity,
    JudgedGap,
    Percentile,
    Target,
    read_option,
)
from pounding_risk.errors import PoundingError

ORDER = 150
PAGES = (".html", ".pdf")
NONE: list[Path] = []


def report(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="What scan wrote (.nc or .zarr).", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The report (.html or .pdf).", show_default="RESULTS.html")
    ] = None,
    gap: JudgedGap = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    intensity: Intensity = None,
    pga: Amplitude = None,
    hazard: Hazard = None,
    others: Annotated[
        list[Path],
        typer.Option("--with", help="What compare, accuracy or effects wrote (.nc or .zarr); repeat for several."),
    ] = NONE,
    project: Annotated[str, typer.Option(help="Project, in the report's head.", show_default=False)] = "",
    author: Annotated[str, typer.Option(help="Author, in the report's head.", show_default=False)] = "",
    revision: Annotated[str, typer.Option(help="Revision, in the report's head.", show_default=False)] = "",
    date: Annotated[str, typer.Option(help="Date, in the report's head.", show_default="no date")] = "",
) -> None:
    """Write a report of a scan: one HTML file, or a PDF."""
    if out is None and Path(f"{results.stem}.html").exists():
        raise PoundingError(f"{results.stem}.html exists already; write -o {results.stem}.html to replace it")
    file = writable("-o", out or Path(f"{results.stem}.html"), PAGES)
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.reports import report as run
    from pounding_risk.units import GAP, PGA

    criterion = read_criterion(target, percentile, confidence, prefix="--")
    written = run(
        results,
        file or Path(),
        hazard=hazard,
        also=others,
        gap=None if gap is None else read_option("--gap", gap, GAP),
        project=project,
        author=author,
        revision=revision,
        date=date,
        **criterion._asdict(),
        intensity=intensity,
        pga=None if pga is None else read_option("--pga", pga, PGA),
    )
    typer.echo(f"written: {written}")
