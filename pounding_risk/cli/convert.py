"""The command `convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import writable

ORDER = 180


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
