"""What the components of one recording share, told from the facts of a record alone."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any


def recording(record: Mapping[str, Any], name: str) -> Hashable:
    """What the components of one recording share; the ``name`` itself where nothing is told of the station."""
    if record.get("rsn"):
        return record["rsn"]
    told = tuple(record.get(key) or "" for key in ("event", "date", "station"))
    return told if told[2] else name
