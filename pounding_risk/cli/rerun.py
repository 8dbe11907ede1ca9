"""The command `rerun`: a results file made again from what it carries, and held against itself."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import writable
from pounding_risk.cli._common.options import New
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli._common.tables import print_table

if TYPE_CHECKING:
    from pounding_risk.studies.rerun import Difference, Rerun

ORDER = 160
DIFFERS = 3  # the status with which the command ends where the results are others


def rerun(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="What scan or demo wrote (.nc).", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the new results (.nc).", show_default=False)
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            help="Folder that the scene's record files are relative to.", show_default="the scene's, or the results'"
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default="one a processor")] = None,
    new: New = False,
) -> None:
    """Run results again from what they carry, and compare.

    Ends with status 3 where anything differs.
    """
    target = writable("-o", out, (".nc",))
    from pounding_risk.studies.rerun import rerun as run

    with Watch("rerun") as watch:
        found = run(results, target, folder=folder, workers=workers, new=new, progress=watch)
    print_rerun(found)
    if target is not None:
        typer.echo(f"written: {target}")
    if not found.same:
        raise typer.Exit(DIFFERS)


def print_rerun(found: Rerun) -> None:
    """What differs, or that nothing does; then what else is not as it was."""

    if found.same:
        typer.echo(f"all {found.compared} variables and coordinates are the same to the last bit")
    if found.differences:
        heads = ("differs", "in", "of", "largest difference", "relative", "")
        print_table(heads, (_row(each, found) for each in found.differences), "lrrrrl")
        same = found.compared - len(found.differences) - len(found.missing)
        typer.echo(f"the other {same} variables and coordinates are the same to the last bit")
    for what, names in (("missing", found.missing), ("new", found.new)):
        if names:
            typer.echo(f"{what}: {', '.join(names)}")
    for name, (was, now) in found.versions.items():
        typer.echo(f"version: {name} is {now}, was {was}")
    for note in found.notes:
        typer.echo(f"note: {note}")


def _row(each: Difference, found: Rerun) -> tuple[str, ...]:
    unit = str(found.dataset[each.name].attrs.get("units", ""))
    absolute = "–" if isnan(each.absolute) else f"{each.absolute:.2g} {unit}".strip()
    relative = "–" if isnan(each.relative) else f"{each.relative:.1e}"
    return each.name, str(each.cases), str(each.of), absolute, relative, each.words
