"""The command `records info`."""

from __future__ import annotations

from typing import Annotated

import typer

from pounding_risk.cli.records._options import Step, Unit, stated
from pounding_risk.cli.records._tables import print_record, print_source

ORDER = 20


def info(
    source: Annotated[
        str, typer.Argument(metavar="SOURCE", help="An id, a file, or file#component.", show_default=False)
    ],
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """One record: origin, terms, checksum, where its file is, PGA to Sa."""
    from pounding_risk.motions.catalogue import entries, entry
    from pounding_risk.motions.source import open_source

    if any(each.id == source for each in entries()):
        print_record(entry(source))
    else:
        print_source(open_source(source, **stated(unit, dt)._asdict()))
