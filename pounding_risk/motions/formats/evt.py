"""Kinemetrics EVT: counts of an Altus recorder (K2, Etna), read by ObsPy; its header says how many volts one g is.

A tag of 16 bytes stands before the header and before each frame of samples, with the sum of all their bytes: a damaged
file is seen. Kinemetrics calibrates in volts per g, here standard gravity 9.80665 m/s²; ObsPy's own factor takes 9.81.
"""

from __future__ import annotations

import struct
from typing import Any

from obspy import Stream, Trace

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._native import bytes_of, read_by_obspy, unreadable
from pounding_risk.motions.formats._text import recogniser, record_facts
from pounding_risk.units import STANDARD_GRAVITY

KIND = "Kinemetrics EVT"
TAG = struct.Struct(">cBBBLHHHH")  # sync, byte order, version, instrument, type, length, data length, serial, checksum
FULL_SCALE = 2**23  # counts of 24 bits
HEADER, FRAME = 1, 2  # types of a tag
# Codes of Kinemetrics for sensors of acceleration: any, FBA of all ranges, FBA-23, EpiSensor, Güralp CMG-5.
ACCELEROMETERS = {1, *range(10, 17), 20, 32, 39}


@recogniser(TAG.size)
def _is_evt(start: str) -> bool:
    """True for a Kinemetrics EVT file."""
    sync, order, _, _, kind, length, *_ = TAG.unpack(start.encode("latin-1"))
    return sync == b"K" and order == 1 and kind == HEADER and length in (2040, 2736)


def _read_evt(file: Any, *, name: str = "", **_kwargs: Any) -> Stream:
    """A trace in m/s² for each accelerometer of a Kinemetrics EVT file; other sensors are left out.

    Raises RecordError for a checksum that is not that of the bytes, a file cut short, another number of samples than
    the header says, a channel without sensitivity, and a file without any accelerometer.
    """
    name, raw = bytes_of(file, name, KIND)
    _check_sums(raw, name)
    stream = read_by_obspy(raw, name, "KINEMETRICS_EVT", KIND)
    for trace in stream:
        promised = int(trace.stats.kinemetrics_evt.nscans)
        if promised != len(trace.data):
            raise unreadable(name, KIND, f"the header promises {promised} samples, {len(trace.data)} found")
    accelerometers = [trace for trace in stream if trace.stats.kinemetrics_evt.chan_sensortype in ACCELEROMETERS]
    if not accelerometers:
        types = ", ".join(str(trace.stats.kinemetrics_evt.chan_sensortype) for trace in stream)
        raise RecordError(
            f"{name}: no channel is of an accelerometer (sensor types {types}); take the record of an accelerograph"
        )
    return Stream([_in_si(trace, name) for trace in accelerometers])


def _in_si(trace: Trace, name: str) -> Trace:
    header = trace.stats.kinemetrics_evt
    volts, per_g = float(header.chan_fullscale), float(header.chan_sensitivity)
    if not (0.0 < volts < 1e3 and 0.0 < per_g < 1e3):
        cause = f"channel {trace.stats.channel} has a full scale of {volts:g} V and {per_g:g} V per g"
        raise RecordError(f"{name}: {cause}, which gives no acceleration; fetch the record again")
    size = volts / FULL_SCALE / per_g * STANDARD_GRAVITY
    trace.data = trace.data.astype(float) * size
    trace.stats.calib = 1.0
    direction = str(header.chan_id).strip()
    unnamed = "" if direction else "; the file names no direction of its channels, of which one may be vertical"
    trace.stats.record = record_facts(
        state="raw",
        units=f"units: counts, times {size:.10g} m/s² per count ({per_g:g} V per g){unnamed}",
        date=str(trace.stats.starttime.date),
        station=trace.stats.station,
        component=direction or trace.stats.channel,
    )
    return trace


def _check_sums(raw: bytes, name: str) -> None:
    """Raise RecordError where the bytes after a tag do not sum up to what it says, and where they end before."""
    at, frames = 0, -1
    while raw[at : at + TAG.size].strip(b"\0"):
        if len(raw) - at < TAG.size:
            raise RecordError(f"{name}: is cut short, {len(raw) - at} bytes are left at byte {at}; fetch it again")
        sync, order, _, _, kind, length, more, _, checksum = TAG.unpack_from(raw, at)
        if sync != b"K" or order != 1 or kind not in (HEADER, FRAME):
            raise unreadable(name, KIND, f"there is no tag of a frame at byte {at}")
        body = raw[at + TAG.size : at + TAG.size + length + more]
        if len(body) < length + more:
            cause = f"the frame at byte {at} has {length + more} bytes, {len(body)} are left"
            raise RecordError(f"{name}: is cut short, {cause}; fetch it again")
        if sum(body) & 0xFFFF != checksum:
            raise unreadable(name, KIND, f"the checksum of the frame at byte {at} is wrong")
        at, frames = at + TAG.size + len(body), frames + 1
    if frames < 1 or raw[at:].strip(b"\0"):
        raise unreadable(name, KIND, f"there are no samples, or other bytes after them, at byte {at}")


FORMAT = Format("KINEMETRICS_EVT", "Kinemetrics EVT (.evt)", (".evt",), _is_evt, _read_evt, native=True)
