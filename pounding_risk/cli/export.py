"""The command `export`: results as files of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pounding_risk.cli._common.files import announce
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Intensity,
    JudgedGap,
    Results,
    Select,
    chosen_results,
    option,
    read_optional,
)

ORDER = 185


def export(
    results: Results,
    to: Annotated[str, option("Format: nrml, pelicun or csv.")],
    out: Annotated[Path, option("The file or folder to write.", "", metavar="PATH")],
    of: Annotated[str, option("Fragilities of contact or yield.")] = "contact",
    gap: JudgedGap = None,
    pga: Amplitude = None,
    intensity: Intensity = None,
    discrete: Annotated[bool, option("Probabilities at intensities instead of parameters.", "parameters")] = False,
    select: Select = NONE,
) -> None:
    """Write fragilities, demands or tables for other tools."""
    from pounding_risk.reports.exports import export as run
    from pounding_risk.units import GAP, PGA

    written = run(
        chosen_results(results, select),
        to,
        out,
        of=of,
        gap=read_optional("--gap", gap, GAP),
        pga=read_optional("--pga", pga, PGA),
        intensity=intensity,
        discrete=discrete,
    )
    announce(*written.files)
    for sentence in written.told:
        print(f"told: {sentence}")
