"""MiniSEED: counts of a digitiser, read by ObsPy; a StationXML file beside it says what a count is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._mseed_blocks import KIND, check_blocks
from pounding_risk.motions.formats._native import bytes_of, read_by_obspy, start_bytes
from pounding_risk.motions.formats._response import to_acceleration

_RECORD = re.compile(rb"\d{6}[DRQM][ \x00]")  # a block starts with its number
_THIRD = b"MS\x03"  # how one of version 3 starts


def _is_mseed(file: Any) -> bool:
    """True for MiniSEED. Never raises; the position of ``file``, a path or a binary file, is left where it was."""
    try:
        start = start_bytes(file, 8)
        return _RECORD.match(start) is not None or start.startswith(_THIRD)
    except Exception:
        return False


def _read_mseed(
    file: Any, *, name: str = "", folder: Path | None = None, unit: str | None = None, **_kwargs: Any
) -> Stream:
    """Traces in m/s²; ``unit`` is for a file of no counts that has no StationXML beside it.

    Raises RecordError for a damaged file, a missing StationXML, and a channel that measures no acceleration.
    """
    from obspy.io.mseed import InternalMSEEDWarning

    name, raw = bytes_of(file, name, KIND)
    if raw.startswith(_THIRD):
        raise RecordError(f"{name}: is MiniSEED of version 3, which ObsPy does not read; convert it to version 2")
    if not _RECORD.match(raw):
        raise RecordError(f"{name}: does not hold MiniSEED, whatever its name says; fetch the record again")
    check_blocks(raw, name)
    stream = read_by_obspy(raw, name, "MSEED", KIND, refused=InternalMSEEDWarning)
    for trace in stream:
        to_acceleration(trace, name, folder, unit, KIND)
    return stream


FORMAT = Format(
    "MSEED",
    "MiniSEED (.mseed, with a StationXML file beside it)",
    (".mseed", ".ms", ".miniseed"),
    _is_mseed,
    _read_mseed,
    native=True,
    takes=("unit",),
)
