"""MiniSEED: counts of a digitiser, read by ObsPy; a StationXML file beside it says what a count is."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import obspy
from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.formats import Format
from pounding_risk.formats._response import apply_sensitivity

_RECORD = re.compile(rb"\d{6}[DRQM][ \x00]")  # version 2 starts with a sequence number, version 3 with its name


def _is_mseed(file: Any) -> bool:
    """True for MiniSEED of version 2 or 3. Never raises; the position of ``file`` is left where it was."""
    try:
        place = file.tell()
        start = file.read(8)
        file.seek(place)
        return bool(_RECORD.match(start)) or start.startswith(b"MS\x03")
    except Exception:
        return False


def _read_mseed(file: Any, *, name: str = "", folder: Path | None = None, **_kwargs: Any) -> Stream:
    """Traces in m/s².

    Raises RecordError for a damaged file, a missing StationXML, and a channel that measures no acceleration.
    """
    from obspy.io.mseed import InternalMSEEDWarning

    if not _is_mseed(file):
        raise RecordError(f"{name}: does not hold MiniSEED, whatever its name says; fetch the record again")
    with warnings.catch_warnings():
        warnings.simplefilter("error", InternalMSEEDWarning)  # or damaged files are read in part
        try:
            stream = obspy.read(file, format="MSEED")
        except Exception as error:
            reason = (" ".join(str(error).split()) or type(error).__name__)[:200]
            raise RecordError(f"{name}: cannot be read as MiniSEED ({reason}); fetch the record again") from None
    size = file.seek(0, 2)
    block = min((trace.stats.mseed.record_length for trace in stream), default=1)
    if size % block:
        told = f"{size} bytes are no whole number of blocks of {block}"
        raise RecordError(f"{name}: is cut short, {told}; fetch the record again")
    for trace in stream:
        apply_sensitivity(trace, name, folder)
    return stream


FORMAT = Format(
    "MSEED",
    "MiniSEED (.mseed, with a StationXML file beside it)",
    (".mseed", ".ms", ".miniseed"),
    _is_mseed,
    _read_mseed,
    native=True,
)
