"""The command `histories`: time histories of chosen cases of a scene or of a scan's results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import announce, out_or
from pounding_risk.cli._common.options import NONE, Select, Workers, argument, option, out_option, read_option
from pounding_risk.cli._common.progress import ProgressDisplay

if TYPE_CHECKING:
    from pounding_risk.units import Quantity

ORDER = 170
Several = Annotated[list[str], option("Only this one; repeat for several.", "all")]


def histories(
    source: Annotated[Path, argument("SOURCE", "A scene (.toml) or what scan wrote (.nc).")],
    out: Annotated[Path | None, out_option("Histories", ".nc", ".zarr", absence="SOURCE-histories.nc")] = None,
    record: Several = NONE,
    polarity: Several = NONE,
    pga: Several = NONE,
    intensity_level: Several = NONE,
    law: Several = NONE,
    gap: Several = NONE,
    yield_force: Several = NONE,
    select: Select = NONE,
    largest: Annotated[
        str | None, option("Of each contact model only the case with the largest value of this output of the results.")
    ] = None,
    most: Annotated[int, option("Cases, at most.", min=1)] = 1000,
    folder: Annotated[
        Path | None,
        option("Folder that the record files of the results' scene are relative to.", "the scene's, or the results'"),
    ] = None,
    workers: Workers = None,
) -> None:
    """Write time histories of chosen cases as one dataset."""
    target = out_or(out, f"{source.stem}-histories.nc")
    from pounding_risk.studies.histories import histories as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    with ProgressDisplay("histories") as progress:
        file = run(
            source,
            target,
            records=record or None,
            polarities=polarity or None,
            laws=law or None,
            pgas=_values("--pga", pga, PGA),
            intensity_levels=intensity_level or None,
            gaps=_values("--gap", gap, GAP),
            yield_forces=_values("--yield-force", yield_force, YIELD_FORCE),
            largest_of=largest,
            select=select,
            most=most,
            folder=folder,
            workers=workers,
            progress=progress,
            say=typer.echo,
        )
    announce(file)


def _values(option: str, texts: list[str], quantity: Quantity) -> list[float] | None:
    """The SI values of an option that may be repeated; None where it is not given."""
    return [read_option(option, text, quantity) for text in texts] or None
