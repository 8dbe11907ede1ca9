"""MiniSEED: counts of a digitiser, read by ObsPy; a StationXML file beside it says what a count is."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any

from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._native import NoAcceleration, bytes_of, read_by_obspy, to_acceleration, unreadable
from pounding_risk.motions.formats._text import recogniser

KIND = "MiniSEED"
HEAD = 48  # bytes of the fixed header
SMALLEST, LARGEST = 7, 20  # powers of two of a block's length in bytes
YEARS = (1900, 2100)
# Fewest bytes of a sample by code of the encoding: whole numbers of 2, 3 and 4 bytes, floats, Steim 1 and 2 (up to four
# and seven samples in four bytes). The others take one at least, or are not read.
DENSEST = {1: 2.0, 2: 3.0, 3: 4.0, 4: 4.0, 5: 8.0, 10: 1.0, 11: 4.0 / 7.0}

_START = re.compile(rb"[\d \x00]{6}[DRQM][ \x00]")
_NAMES = re.compile(rb"[ -~\x00]{12}")


def check_blocks(raw: bytes, name: str) -> None:
    """Raise RecordError where a file of MiniSEED of version 2 is not a series of blocks with sound headers.

    The compiled reader of ObsPy prints tracebacks at some damaged bytes, reads around others, and reads on past the end
    of a block that promises more samples than it holds. SEED manual 2.4 (2012), chapter 8: a fixed header of 48 bytes,
    then a chain of blockettes, of which number 1000 says how the samples are written and how long the block is.
    """
    at = 0
    while at < len(raw):
        try:
            length = _length(raw, at)
        except (ValueError, struct.error) as error:
            reason = str(error) if isinstance(error, ValueError) else "its header leads out of the file"
            raise unreadable(name, KIND, f"block at byte {at}: {reason}") from None
        if at + length > len(raw):
            cause = f"the block at byte {at} has {length} bytes, {len(raw) - at} are left"
            raise RecordError(f"{name}: is cut short, {cause}; fetch the record again")
        at += length


def _length(raw: bytes, at: int) -> int:
    """Length of the block at a byte; raises ValueError for a header out of order."""
    if len(raw) - at < HEAD:
        raise ValueError(f"{len(raw) - at} bytes are no header")
    if not _START.match(raw, at):
        raise ValueError("it does not start with a number and the letter D, R, Q or M")
    if not _NAMES.fullmatch(raw, at + 8, at + 20):
        raise ValueError("its station and channel are no plain letters")
    order = ">" if YEARS[0] <= struct.unpack_from(">H", raw, at + 20)[0] <= YEARS[1] else "<"
    year, day, hour, minute, second, fraction = struct.unpack_from(f"{order}HHBBBxH", raw, at + 20)
    if not (YEARS[0] <= year <= YEARS[1] and 1 <= day <= 366 and hour < 24 and minute < 60 and second <= 60):
        raise ValueError("its time is no time of day")
    samples, factor = struct.unpack_from(f"{order}Hh", raw, at + 30)
    start, blockette = struct.unpack_from(f"{order}HH", raw, at + 44)
    if fraction > 9999 or (samples and not factor):
        raise ValueError("its time or sampling rate is out of range")
    encoding, power = _format(raw, at, blockette, order)
    length = 1 << power
    if samples and not HEAD <= start < length:
        raise ValueError(f"its samples start at byte {start} of {length}")
    if samples * DENSEST.get(encoding, 1.0) > length - start:
        raise ValueError(f"it promises {samples} samples, more than {length - start} bytes hold")
    return length


def _format(raw: bytes, at: int, blockette: int, order: str) -> tuple[int, int]:
    """Encoding and power of two of the length in blockette 1000; raises ValueError where the chain leads elsewhere."""
    before = HEAD - 1
    while before < blockette:
        number, following = struct.unpack_from(f"{order}HH", raw, at + blockette)
        if number == 1000:
            encoding, _, power = struct.unpack_from("BBB", raw, at + blockette + 4)
            if not SMALLEST <= power <= LARGEST:
                raise ValueError(f"its length of 2^{power} bytes is out of range")
            return encoding, power
        before, blockette = blockette, following
    raise ValueError("it has no blockette 1000, which says how long it is")


_RECORD = re.compile(rb"\d{6}[DRQM][ \x00]")  # a block starts with its number
_THIRD = b"MS\x03"  # how one of version 3 starts


@recogniser(8)
def _is_mseed(start: str) -> bool:
    """True for MiniSEED, of version 3 too, which is refused in words."""
    raw = start.encode("latin-1")
    return _RECORD.match(raw) is not None or raw.startswith(_THIRD)


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
    others: list[NoAcceleration] = []
    left = ""
    for trace in list(stream):
        try:
            to_acceleration(trace, name, folder, unit, KIND)
        except NoAcceleration as error:
            others.append(error)
            stream.remove(trace)
            left = trace.id
    if others and not stream:
        raise others[0]
    for trace in stream if others else ():
        trace.stats.record.units += f"; {len(others)} of the file's channels measure no acceleration, such as {left}"
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
