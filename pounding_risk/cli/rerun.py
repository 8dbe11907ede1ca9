"""The command `rerun`: a results file made again from what it carries, and compared with it."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import announce
from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.options import New, Workers, argument, option, out_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_table

if TYPE_CHECKING:
    from pounding_risk.studies.rerun import Difference, Rerun

ORDER = 160
DIFFERS = 3  # exit status where the new results differ


def rerun(
    results: Annotated[Path, argument("RESULTS", "What scan or demo wrote (.nc).")],
    out: Annotated[Path | None, out_option("Write the new results", ".nc")] = None,
    folder: Annotated[
        Path | None, option("Folder that the scene's record files are relative to.", "the scene's, or the results'")
    ] = None,
    workers: Workers = None,
    new: New = False,
) -> None:
    """Run results again from what they carry, and compare.

    Ends with status 3 where anything differs.
    """
    from pounding_risk.studies.rerun import rerun as run

    with ProgressDisplay("rerun") as progress:
        comparison = run(results, out, folder=folder, workers=workers, new=new, progress=progress)
    print_rerun(comparison)
    announce(out)
    if not comparison.same:
        raise typer.Exit(DIFFERS)


def print_rerun(comparison: Rerun) -> None:
    """Print what differs, or that nothing does, then other versions and notes."""
    if comparison.same:
        print(f"all {comparison.compared} variables and coordinates are the same to the last bit")
    if comparison.differences:
        heads = ("differs", "in", "of", "largest difference", "relative", "")
        print_table(heads, (_row(difference, comparison) for difference in comparison.differences), "lrrrrl")
        n_same = comparison.compared - len(comparison.differences) - len(comparison.missing)
        print(f"the other {n_same} variables and coordinates are the same to the last bit")
    for heading, names in (("missing", comparison.missing), ("new", comparison.new)):
        if names:
            print(f"{heading}: {', '.join(names)}")
    for name, (was, now) in comparison.versions.items():
        print(f"version: {name} is {now}, was {was}")
    print_notes(comparison.notes)


def _row(difference: Difference, comparison: Rerun) -> tuple[str, ...]:
    """Cells of a variable that differs."""
    unit = str(comparison.dataset[difference.name].attrs.get("units", ""))
    absolute = "–" if isnan(difference.absolute) else f"{difference.absolute:.2g} {unit}".strip()
    relative = "–" if isnan(difference.relative) else f"{difference.relative:.1e}"
    return difference.name, str(difference.cases), str(difference.of), absolute, relative, difference.words
