"""The command `view`: a page to look around in a scan's results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import writable
from pounding_risk.cli._common.options import NONE, read_option
from pounding_risk.errors import PoundingError

ORDER = 140


def view(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="Results of a scan (.nc or .zarr).", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the page (.html).", show_default="RESULTS-view.html")
    ] = None,
    record: Annotated[list[str], typer.Option(help="Only this record; repeat for several.", show_default="all")] = NONE,
    contact_model: Annotated[
        list[str], typer.Option(help="Only this contact model; repeat for several.", show_default="all")
    ] = NONE,
    pga: Annotated[
        list[str], typer.Option(help='Only this amplitude, such as "0.5 g"; repeat for several.', show_default="all")
    ] = NONE,
) -> None:
    """Write a page to look around in a scan's results, offline."""
    target = page_file(results, out)
    from pounding_risk.reports.explorer import view as run
    from pounding_risk.units import PGA

    amplitudes = [read_option("--pga", text, PGA) for text in pga]
    run(results, target, records=record, contact_models=contact_model, pgas=amplitudes)
    typer.echo(f"written: {target} ({target.stat().st_size / 1e6:.1f} MB); open it in a browser")


def page_file(results: Path, out: Path | None) -> Path:
    """Where the page goes: ``out``, or the results' name in this folder, which is never replaced unasked."""
    name = f"{results.stem}-view.html"
    if out is None and Path(name).exists():
        raise PoundingError(f"{name} exists already; write -o {name} to replace it, or another name")
    return writable("-o", out or Path(name), (".html",)) or Path(name)
