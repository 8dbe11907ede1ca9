"""The command `convert`: a dataset in the other file format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pounding_risk.cli._common.files import announce, writable
from pounding_risk.cli._common.options import argument

ORDER = 180


def convert(
    source: Annotated[Path, argument("SOURCE", "A dataset of any command (.nc or .zarr).")],
    target: Annotated[Path, argument("TARGET", "Where it goes (.zarr or .nc).")],
) -> None:
    """Write a dataset as Zarr or as netCDF, whatever its size."""
    from pounding_risk.results.files import RESULTS
    from pounding_risk.studies.convert import convert as run

    writable("TARGET", target, RESULTS)
    announce(run(source, target))
