"""The command `histories`: time histories of chosen cases of a scene or of a scan's results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import writable
from pounding_risk.cli._common.options import NONE, read_option
from pounding_risk.cli._common.progress import Watch
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.units import Quantity

ORDER = 170
Several = Annotated[list[str], typer.Option(help="Only this one; repeat for several.", show_default="all")]


def histories(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="A scene (.toml) or what scan wrote (.nc).", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Histories (.nc).", show_default="SOURCE-histories.nc")
    ] = None,
    record: Several = NONE,
    polarity: Several = NONE,
    pga: Several = NONE,
    law: Several = NONE,
    gap: Several = NONE,
    yield_force: Several = NONE,
    largest: Annotated[
        str | None,
        typer.Option(help="Of each contact model only the case with the largest value of this output of the results."),
    ] = None,
    most: Annotated[int, typer.Option(min=1, help="Cases, at most.")] = 1000,
    folder: Annotated[
        Path | None,
        typer.Option(
            help="Folder that the record files of the results' scene are relative to.",
            show_default="the scene's, or the results'",
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default="one a processor")] = None,
) -> None:
    """Write time histories of chosen cases as one dataset."""
    name = f"{source.stem}-histories.nc"
    if out is None and Path(name).exists():
        raise PoundingError(f"{name} exists already; write -o {name} to replace it, or another name")
    target = writable("-o", out or Path(name), (".nc", ".zarr")) or Path()
    from pounding_risk.studies.histories import histories as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    with Watch("histories") as watch:
        written = run(
            source,
            target,
            records=record or None,
            polarities=polarity or None,
            laws=law or None,
            pgas=_read("--pga", pga, PGA),
            gaps=_read("--gap", gap, GAP),
            yield_forces=_read("--yield-force", yield_force, YIELD_FORCE),
            largest_of=largest,
            most=most,
            folder=folder,
            workers=workers,
            progress=watch,
            say=typer.echo,
        )
    typer.echo(f"written: {written}")


def _read(option: str, texts: list[str], quantity: Quantity) -> list[float] | None:
    """Values in SI, or None where none is named."""
    return [read_option(option, text, quantity) for text in texts] or None
