"""The command `records list`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli.records._options import Set, Step, Unit, find, stated
from pounding_risk.cli.records._tables import print_left_out, print_records, print_sources
from pounding_risk.errors import PoundingError

ORDER = 10


def list(
    set: Set = None,
    folder: Annotated[Path | None, typer.Option(help="A folder of record files.", show_default=False)] = None,
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """The records of the catalogue, of a set, or of a folder."""

    if set is None and folder is None:
        from pounding_risk.motions.catalogue import entries

        print_records(entries())
        return

    if folder is not None and not folder.is_dir():
        raise PoundingError(f"--folder: {folder} is not a folder; check the name")
    found = find([str(folder)] if folder else [], set, stated(unit, dt), lenient=True)
    print_sources([source for group in found.groups for source in group])
    print_left_out(found.left_out)
