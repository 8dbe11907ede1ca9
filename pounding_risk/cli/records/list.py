"""The command `records list`: the records of the catalogue, of a set, or of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pounding_risk.cli._common.notes import print_left_out
from pounding_risk.cli._common.options import option
from pounding_risk.cli.records._options import Set, Step, Unit, find_sources, stated_facts
from pounding_risk.cli.records._tables import print_records, print_sources
from pounding_risk.errors import PoundingError

ORDER = 10


def list(
    set: Set = None,
    folder: Annotated[Path | None, option("A folder of record files.")] = None,
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """The records of the catalogue, of a set, or of a folder."""
    if set is None and folder is None:
        from pounding_risk.motions.catalogue import entries

        return print_records(entries())
    if folder is not None and not folder.is_dir():
        raise PoundingError(f"--folder: {folder} is not a folder; check the name")
    sources = find_sources([str(folder)] if folder else [], set, stated_facts(unit, dt), lenient=True)
    print_sources([source for group in sources.groups for source in group])
    print_left_out(sources.left_out)
