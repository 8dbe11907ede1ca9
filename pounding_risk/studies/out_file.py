"""The file that a call writes its dataset to, checked before any work."""

from __future__ import annotations

from pathlib import Path

from pounding_risk.ensemble.replacing import check_replaceable
from pounding_risk.results.files import check_target


def check_out(out: str | Path | None, command: str, new: bool) -> Path | None:
    """The file of the dataset; raises PoundingError where it cannot be written or holds other than ``command`` made."""
    if out is None:
        return None
    target = check_target(out)
    check_replaceable(target, command, new=new)
    return target
