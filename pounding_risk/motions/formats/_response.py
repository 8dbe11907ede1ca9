"""Counts to m/s², by a StationXML file beside the record or by the unit that the user states."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import obspy

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._native import unreadable
from pounding_risk.motions.formats._text import record_facts
from pounding_risk.motions.formats._unit import TO_GIVE, known, sentence, size_of

if TYPE_CHECKING:
    from obspy import Trace

LEVEL = 45.0  # degrees of dip; a channel above is vertical


def to_acceleration(trace: Trace, name: str, folder: Path | None, unit: str | None, kind: str) -> None:
    """Turn a trace whose file has no unit into m/s², with ``stats.record``; ``kind`` is the format in words.

    The StationXML is named as the file ``name`` with ``.xml``, or NETWORK.STATION.xml, in ``folder``. Of an
    accelerometer the sensitivity is the whole response up to tens of Hz. Without that file, ``unit`` says what a sample
    is. Counts of a digitiser are raw; so are whole numbers with a unit, but fractions are what a program made of them.

    Raises RecordError where neither is there, the file does not know the channel, or no acceleration is measured.
    """
    # A file name is made of them.
    if not trace.id.isprintable() or set("/\\") & set(trace.stats.network + trace.stats.station):
        raise unreadable(name, kind, "its station and channel are no plain letters")
    beside, azimuth = _beside(trace, name, folder), None
    is_counts = trace.data.dtype.kind == "i"
    samples = trace.data.astype(np.float64)
    if beside is not None:
        counts, units, azimuth = _sensitivity(trace, beside)
        trace.data, state = samples / counts, "raw"
    elif unit is not None:
        size = size_of(unit, f"{name}: unit as given")
        units, state = sentence(unit, size), "raw" if is_counts else "processed"
        with np.errstate(over="ignore"):
            trace.data = samples * size
        if not np.isfinite(trace.data).all():
            raise unreadable(name, kind, "samples are too large for a number in m/s²")
    else:
        raise RecordError(
            f"{name}: the unit is unknown, a {kind} file holds counts; put the StationXML of "
            f"{trace.id} beside it as {_names(trace, name)[1]}, or, where its samples are no counts, give their unit: "
            f"{TO_GIVE}"
        )
    trace.stats.calib = 1.0
    trace.stats.record = record_facts(
        state=state,
        units=units,
        date=str(trace.stats.starttime.date),
        station=trace.stats.station,
        component=trace.stats.channel,
        azimuth=azimuth,
    )


def _names(trace: Trace, name: str) -> tuple[str, str]:
    return f"{Path(name).stem}.xml", f"{trace.stats.network}.{trace.stats.station}.xml"


def _beside(trace: Trace, name: str, folder: Path | None) -> Path | None:
    """The StationXML of a trace, where there is one."""
    beside = Path(name).parent if folder is None else folder
    return next((beside / file_name for file_name in _names(trace, name) if (beside / file_name).is_file()), None)


def _sensitivity(trace: Trace, beside: Path) -> tuple[float, str, float | None]:
    """Counts per m/s², the sentence that says so, and the azimuth of the channel."""
    stats = trace.stats
    try:
        inventory = obspy.read_inventory(str(beside), format="STATIONXML")
        sensitivity = inventory.get_response(trace.id, stats.starttime).instrument_sensitivity
        counts, unit = float(sensitivity.value), str(sensitivity.input_units).upper()
        placed = inventory.get_channel_metadata(trace.id, stats.starttime)
    except Exception as error:
        reason = (" ".join(str(error).split()) or type(error).__name__)[:200]
        raise RecordError(
            f"{beside}: gives no sensitivity for {trace.id} at {stats.starttime} ({reason}); fetch "
            "the StationXML of this channel with its response"
        ) from None
    size = known(unit)
    if size is None or not counts:
        raise RecordError(
            f'{beside}: {trace.id} measures {counts:g} counts per "{unit}", which is no acceleration; take '
            "an accelerometer's channel (such as HN or BN)"
        )
    per_si = counts / size
    return (
        per_si,
        f"units: counts, divided by {per_si:.10g} counts per m/s² ({beside.name})",
        _azimuth(placed, stats.channel),
    )


def _azimuth(placed: Mapping[str, Any], channel: str) -> float | None:
    """Degrees clockwise from north; None for a vertical, whose dip may be left out, and where nothing is said."""
    upright = channel.upper().endswith("Z") or abs(placed["dip"] or 0.0) > LEVEL
    return None if upright or placed["azimuth"] is None else float(placed["azimuth"])
