"""What the components of one recording share, told from the facts of a record alone."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any


def recording(record: Mapping[str, Any], name: str) -> Hashable:
    """What the components of one recording share; the ``name`` itself where nothing is told of the station.

    Where no event is told, the minute in which a record starts stands for it: two earthquakes of a day are two.
    """
    if record.get("rsn"):
        return record["rsn"]
    event = record.get("event") or str(record.get("start") or "")[:16]
    told = (event, *(record.get(key) or "" for key in ("date", "station", "sensor")))
    return told if told[2] else name
