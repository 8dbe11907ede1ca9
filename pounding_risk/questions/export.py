"""The command of `export`: results and scenes as files of other tools."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pounding_risk.questions._declaration import Option

if TYPE_CHECKING:
    from pounding_risk.reports.exports import Written

ORDER = 185
FUNCTION = "reports.exports"
SUBJECT = "results or scenes"
OPTIONS = {"target": Option("--out -o")}


def notes(written: Written) -> Iterator[str]:
    """What the files do not hold."""
    yield from (f"note: {sentence}" for sentence in written.notes)
