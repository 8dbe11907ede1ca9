"""Strong-motion files: which formats are read, how one is told from another, and the formats ObsPy lacks.

A format that ObsPy lacks is a module here with a pair of functions: ``_is_x(file) -> bool`` never raises;
``_read_x(file, headonly=False, **kwargs) -> Stream`` gives m/s² with ``stats.calib = 1`` or raises
RecordError. Two entry points make it known to ObsPy, so that ``obspy.read`` opens such files in any script
once this package is installed:

    [project.entry-points."obspy.plugin.waveform"]
    PEER_AT2 = "pounding_risk.formats.peer_at2"
    [project.entry-points."obspy.plugin.waveform.PEER_AT2"]
    isFormat = "pounding_risk.formats.peer_at2:_is_at2"
    readFormat = "pounding_risk.formats.peer_at2:_read_at2"

`read_file` itself never lets ObsPy guess: its detection unpickles a file that looks like one of its own
pickles, which runs whatever code the file holds. Formats are an allow-list, told by content.
"""

from __future__ import annotations

import re
import warnings
from difflib import get_close_matches
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.errors import RecordError
from pounding_risk.quantities import STANDARD_GRAVITY, shown

if TYPE_CHECKING:
    from obspy import Stream, Trace

READ = "PEER AT2 (.at2) and MiniSEED (.mseed, with a StationXML file beside it)"
LARGEST = 256 * 2**20  # bytes; an hour at 200 Hz has 6 MB
# What one unit of a StationXML's input is in m/s².
ACCELERATIONS = {
    **dict.fromkeys(("M/S**2", "M/S^2", "M/S/S", "M/S2", "M/(S**2)"), 1.0),
    **dict.fromkeys(("CM/S**2", "CM/S^2", "CM/S/S", "GAL"), 0.01),
    "G": STANDARD_GRAVITY,
}
_MSEED2 = re.compile(rb"\d{6}[DRQM][ \x00]")


class FileRead(NamedTuple):
    """What a file holds: one trace in m/s², whether it is raw or processed, and what was read."""

    trace: Trace
    state: str  # "raw" or "processed"
    format: str
    sha256: str
    units: str  # a sentence: how the samples became m/s²


def read_file(path: Path) -> FileRead:
    """The one record in a file, in m/s², by a format of the allow-list.

    A MiniSEED file holds counts, so it needs a StationXML file beside it that says what a count is: named as
    the file itself with ``.xml``, or NETWORK.STATION.xml.

    Raises RecordError for a missing, empty or unknown file, several components, gaps, and an unknown unit.
    """
    raw = _bytes(path)
    format_name = _format(path, raw)
    digest = sha256(raw).hexdigest()
    if format_name == "PEER_AT2":
        from pounding_risk.formats.peer_at2 import _read_at2

        trace = single_trace(_read_at2(BytesIO(raw), name=str(path)), str(path))
        return FileRead(trace, "processed", format_name, digest, "units: g, times 9.80665 m/s²")
    trace = single_trace(_read_mseed(path, raw), str(path))
    per_unit, units = _sensitivity(path, trace)
    trace.data = trace.data.astype(float) / per_unit
    trace.stats.calib = 1.0
    return FileRead(trace, "raw", format_name, digest, units)


def single_trace(stream: Stream, name: str) -> Trace:
    """The one trace of a stream; raises RecordError for none, several components, gaps, mixed time steps."""
    traces = list(stream)
    if not traces:
        raise RecordError(f"{name}: holds no samples; check the file")
    components = list(dict.fromkeys(trace.id for trace in traces))
    if len(components) > 1:
        raise RecordError(
            f"{name}: holds {len(components)} components ({', '.join(components)}), one is needed; read it "
            "with ObsPy and hand over one trace in m/s², or split the file"
        )
    steps = sorted({trace.stats.delta for trace in traces})
    if len(steps) > 1:
        listed = " and ".join(f"{dt:g}" for dt in steps)
        raise RecordError(f"{name}: has time steps of {listed} s in one record; resample it to one before")
    if len(traces) > 1:
        raise RecordError(
            f"{name}: is in {len(traces)} pieces, with gaps or overlaps between them, the first at "
            f"{traces[0].stats.endtime}; cut the piece you want, or fill the gaps yourself"
        )
    return traces[0]


def one_trace(source: Any) -> Trace:
    """The trace that an ObsPy trace or stream in memory is; raises RecordError for anything else."""
    from obspy import Stream, Trace

    if isinstance(source, Stream):
        return single_trace(source, "the ObsPy stream")
    if not isinstance(source, Trace):
        raise RecordError(
            f"{shown(source)} is not a record; give an id of the catalogue, a path, or an ObsPy trace in m/s²"
        )
    return source


def _bytes(path: Path) -> bytes:
    """The bytes of a file, at most ``LARGEST``."""
    if path.is_dir():
        raise RecordError(f"{path}: is a folder; name a record file in it")
    try:
        size = path.stat().st_size
        if size > LARGEST:
            raise RecordError(f"{path}: has {size >> 20} MiB, at most {LARGEST >> 20} are read; cut the record before")
        raw = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        others = [other.name for other in path.parent.iterdir()] if path.parent.is_dir() else []
        near = get_close_matches(path.name, others, 3, 0.6)
        hint = f" (did you mean {' or '.join(near)}?)" if near else ""
        raise RecordError(f"{path}: no such record file{hint}; check the name and the folder") from None
    except OSError as error:
        raise RecordError(f"{path}: cannot be read ({error.strerror}); check its permissions") from None
    if not raw:
        raise RecordError(f"{path}: is empty (0 bytes); fetch the record again")
    return raw


def _format(path: Path, raw: bytes) -> str:
    """The format by content; the extension only where the content says nothing, for a better message."""
    from pounding_risk.formats.peer_at2 import _is_at2

    start = raw[:512].lstrip().lower()
    if start.startswith((b"<!doctype html", b"<html")):
        raise RecordError(f"{path}: is a web page, not a record; the download failed: fetch the record again")
    if raw[:1] == b"\x80" or b"obspy.core.stream" in raw[:100]:
        raise RecordError(f"{path}: is a Python pickle, which can run code and is never read; {READ} are read")
    if _is_at2(BytesIO(raw)):
        return "PEER_AT2"
    if _MSEED2.match(raw) or raw.startswith(b"MS\x03"):
        return "MSEED"
    if path.suffix.lower() == ".at2":
        return "PEER_AT2"  # its reader says which line is missing
    if path.suffix.lower() in (".mseed", ".ms", ".miniseed"):
        raise RecordError(f"{path}: does not hold MiniSEED, whatever its name says; fetch the record again")
    raise RecordError(f"{path}: is not a known record format; {READ} are read: convert the record to one of them")


def _read_mseed(path: Path, raw: bytes) -> Stream:
    import obspy
    from obspy.io.mseed import InternalMSEEDWarning

    with warnings.catch_warnings():
        warnings.simplefilter("error", InternalMSEEDWarning)  # or damaged files are read in part
        try:
            stream = obspy.read(BytesIO(raw), format="MSEED")
        except Exception as error:
            raise RecordError(
                f"{path}: cannot be read as MiniSEED ({_reason(error)}); fetch the record again"
            ) from None
    block = min((trace.stats.mseed.record_length for trace in stream), default=1)
    if len(raw) % block:
        size = f"{len(raw)} bytes are no whole number of blocks of {block}"
        raise RecordError(f"{path}: is cut short, {size}; fetch the record again")
    return stream


def _sensitivity(path: Path, trace: Trace) -> tuple[float, str]:
    """How many counts are one m/s², and the sentence that says so, from the StationXML beside the file."""
    import obspy

    stats = trace.stats
    names = (f"{path.stem}.xml", f"{stats.network}.{stats.station}.xml")
    beside = next((path.parent / name for name in names if (path.parent / name).is_file()), None)
    if beside is None:
        raise RecordError(
            f"{path}: the unit is unknown, a MiniSEED file holds counts; put the StationXML of {trace.id} "
            f"beside it as {names[1]}, or hand over an ObsPy trace in m/s²"
        )
    try:
        inventory = obspy.read_inventory(str(beside), format="STATIONXML")
        sensitivity = inventory.get_response(trace.id, stats.starttime).instrument_sensitivity
        counts, unit = float(sensitivity.value), str(sensitivity.input_units).upper()
    except Exception as error:
        raise RecordError(
            f"{beside}: gives no sensitivity for {trace.id} at {stats.starttime} ({_reason(error)}); fetch "
            "the StationXML of this channel with its response"
        ) from None
    if unit not in ACCELERATIONS or not counts:
        raise RecordError(
            f'{beside}: {trace.id} measures {counts:g} counts per "{unit}", which is no acceleration; take '
            "an accelerometer's channel (such as HN or BN)"
        )
    per_si = counts / ACCELERATIONS[unit]
    return per_si, f"units: counts, divided by {per_si:.10g} counts per m/s² ({beside.name})"


def _reason(error: Exception) -> str:
    """The first words of another library's error, on one line."""
    return (" ".join(str(error).split()) or type(error).__name__)[:200]
