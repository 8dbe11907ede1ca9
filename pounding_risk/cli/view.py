"""The command `view`: an interactive page of a scan's results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import out_or
from pounding_risk.cli._common.options import NONE, Select, argument, chosen_results, option, out_option, read_option

ORDER = 140


def view(
    results: Annotated[Path, argument("RESULTS", "Results of a scan (.nc or .zarr).")],
    out: Annotated[Path | None, out_option("Write the page", ".html", absence="RESULTS-view.html")] = None,
    select: Select = NONE,
    record: Annotated[list[str], option("Only this record; repeat for several.", "all")] = NONE,
    contact_model: Annotated[list[str], option("Only this contact model; repeat for several.", "all")] = NONE,
    pga: Annotated[list[str], option('Only this amplitude, such as "0.5 g"; repeat for several.', "all")] = NONE,
    intensity_level: Annotated[list[str], option("Only this level of intensity; repeat for several.", "all")] = NONE,
) -> None:
    """Write a page to look around in a scan's results, offline."""
    target = out_or(out, f"{results.stem}-view.html")
    from pounding_risk.reports.explorer import view as run
    from pounding_risk.units import PGA

    amplitudes = [read_option("--pga", text, PGA) for text in pga]
    run(
        chosen_results(results, select),
        target,
        records=record,
        contact_models=contact_model,
        pgas=amplitudes,
        intensity_levels=intensity_level,
    )
    typer.echo(f"written: {target} ({target.stat().st_size / 1e6:.1f} MB); open it in a browser")
