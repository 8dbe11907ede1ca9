"""From counts to m/s² by the StationXML file that stands beside a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import obspy

from pounding_risk.errors import RecordError
from pounding_risk.formats._text import told
from pounding_risk.quantities import STANDARD_GRAVITY

if TYPE_CHECKING:
    from obspy import Trace

# What one unit of a StationXML's input is in m/s².
ACCELERATIONS = {
    **dict.fromkeys(("M/S**2", "M/S^2", "M/S/S", "M/S2", "M/(S**2)"), 1.0),
    **dict.fromkeys(("CM/S**2", "CM/S^2", "CM/S/S", "GAL"), 0.01),
    "G": STANDARD_GRAVITY,
}


def apply_sensitivity(trace: Trace, name: str, folder: Path | None) -> None:
    """Turn a trace of counts into m/s², with ``stats.record``.

    The StationXML is named as the file ``name`` with ``.xml``, or NETWORK.STATION.xml, in ``folder``. Of an
    accelerometer the sensitivity is the whole response up to tens of Hz. Raises RecordError where it is not there, does
    not know the channel, or measures no acceleration.
    """
    counts, units = _sensitivity(trace, name, folder)
    trace.data = trace.data.astype(float) / counts
    trace.stats.calib = 1.0
    trace.stats.record = told(
        state="raw",
        units=units,
        date=str(trace.stats.starttime.date),
        station=trace.stats.station,
        component=trace.stats.channel,
    )


def _sensitivity(trace: Trace, name: str, folder: Path | None) -> tuple[float, str]:
    """How many counts are one m/s², and the sentence that says so."""
    stats, path = trace.stats, Path(name)
    place = path.parent if folder is None else folder
    names = (f"{path.stem}.xml", f"{stats.network}.{stats.station}.xml")
    beside = next((place / each for each in names if (place / each).is_file()), None)
    if beside is None:
        raise RecordError(
            f"{name}: the unit is unknown, a MiniSEED file holds counts; put the StationXML of {trace.id} "
            f"beside it as {names[1]}, or hand over an ObsPy trace in m/s²"
        )
    try:
        inventory = obspy.read_inventory(str(beside), format="STATIONXML")
        sensitivity = inventory.get_response(trace.id, stats.starttime).instrument_sensitivity
        counts, unit = float(sensitivity.value), str(sensitivity.input_units).upper()
    except Exception as error:
        reason = (" ".join(str(error).split()) or type(error).__name__)[:200]
        raise RecordError(
            f"{beside}: gives no sensitivity for {trace.id} at {stats.starttime} ({reason}); fetch "
            "the StationXML of this channel with its response"
        ) from None
    if unit not in ACCELERATIONS or not counts:
        raise RecordError(
            f'{beside}: {trace.id} measures {counts:g} counts per "{unit}", which is no acceleration; take '
            "an accelerometer's channel (such as HN or BN)"
        )
    per_si = counts / ACCELERATIONS[unit]
    return per_si, f"units: counts, divided by {per_si:.10g} counts per m/s² ({beside.name})"
