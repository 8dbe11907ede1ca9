"""The command `records info`: all that is known of one record, and its intensity measures."""

from __future__ import annotations

from typing import Annotated

from pounding_risk.cli._common.options import argument
from pounding_risk.cli.records._options import Step, Unit, stated_facts
from pounding_risk.cli.records._tables import print_record, print_source

ORDER = 20


def info(
    source: Annotated[str, argument("SOURCE", "An id, a file, or file#component.")],
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """One record: origin, terms, checksum, where its file is, PGA to Sa."""
    from pounding_risk.motions.catalogue import entries, entry
    from pounding_risk.motions.source import open_source

    if any(known.id == source for known in entries()):
        print_record(entry(source))
    else:
        print_source(open_source(source, **stated_facts(unit, dt)))
