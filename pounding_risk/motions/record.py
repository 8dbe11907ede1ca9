"""A record before anything is done to it."""

from __future__ import annotations

from typing import Any, NamedTuple

RAW, PROCESSED = "raw", "processed"


class Source(NamedTuple):
    """A record before anything is done to it: trace in m/s², where it is from, raw or processed."""

    name: str
    trace: Any  # obspy.Trace, float samples, calib 1
    record: dict[str, Any]
    units: str
    doubts: tuple[str, ...] = ()  # about how it was read, a sentence each
