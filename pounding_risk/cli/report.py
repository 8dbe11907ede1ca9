"""The command `report`: the report of a scan, as HTML or PDF."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import announce, out_or
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Confidence,
    Hazard,
    Intensity,
    IntensityLevel,
    JudgedGap,
    Percentile,
    Select,
    Site,
    Target,
    TargetRate,
    argument,
    at_site,
    chosen_results,
    option,
    out_option,
    read_optional,
)

ORDER = 150


def report(
    results: Annotated[Path, argument("RESULTS", "What scan wrote (.nc or .zarr).")],
    out: Annotated[Path | None, out_option("The report", ".html", ".pdf", absence="RESULTS.html")] = None,
    select: Select = NONE,
    gap: JudgedGap = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    intensity: Intensity = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    hazard: Hazard = None,
    site: Site = None,
    target_rate: TargetRate = None,
    others: Annotated[
        list[Path],
        typer.Option(
            "--with", help="What compare, accuracy, effects or uncertainty wrote (.nc or .zarr); repeat for several."
        ),
    ] = NONE,
    project: Annotated[str, option("Project, in the report's head.")] = "",
    author: Annotated[str, option("Author, in the report's head.")] = "",
    revision: Annotated[str, option("Revision, in the report's head.")] = "",
    date: Annotated[str, option("Date, in the report's head.", "no date")] = "",
) -> None:
    """Write a report of a scan: one HTML file, or a PDF."""
    file = out_or(out, f"{results.stem}.html")
    from pounding_risk.assessment.annual_rates import read_target_rate
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.reports import report as run
    from pounding_risk.units import GAP, PGA

    criterion = read_criterion(target, percentile, confidence, prefix="--")
    rate = read_target_rate(target_rate, hazard is not None, prefix="--")
    report_file = run(
        chosen_results(results, select, partly=True),
        file,
        hazard=at_site(hazard, site),
        also=others,
        gap=read_optional("--gap", gap, GAP),
        project=project,
        author=author,
        revision=revision,
        date=date,
        **criterion._asdict(),
        intensity=intensity,
        pga=read_optional("--pga", pga, PGA),
        intensity_level=intensity_level,
        target_rate=rate,
    )
    announce(report_file)
