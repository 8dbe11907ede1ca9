"""Reading through ObsPy, for formats that it has: by name of the format, without warnings, errors as one sentence.

Counts become m/s² by a StationXML file beside the record, or by the unit that the user states.
"""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import obspy
from obspy import Stream, Trace

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import TO_GIVE, known_unit, size_of_unit, unit_sentence
from pounding_risk.motions.formats._text import check_step, record_facts, text_of

LONGEST_REASON = 200  # characters of what ObsPy says
STAGES_APART = 0.05  # of the total; stages may state their gains at other frequencies than the total
LEVEL = 45.0  # degrees of dip; a channel above is vertical
BY_NAME = {"N": 0.0, "E": 90.0}  # azimuths [degrees], by the last letter of a channel


class NoAcceleration(RecordError):
    """The channel of a file measures something else."""


def bytes_of(file: Any, name: str, kind: str) -> tuple[str, bytes]:
    """Name and bytes of a path or of an open file; ``kind`` is the format in words."""
    name, text = text_of(file, name, kind)
    return name, text.encode("latin-1")


def unreadable(name: str, kind: str, reason: str) -> RecordError:
    """The error for a damaged file; a reason from ObsPy may quote its bytes."""
    plain = "".join(letter if letter.isprintable() else " " for letter in reason[:LONGEST_REASON])
    return RecordError(f"{name}: cannot be read as {kind} ({' '.join(plain.split())}); fetch the record again")


def read_by_obspy(raw: bytes, name: str, format: str, kind: str, *, refused: type[Warning] | None = None) -> Stream:
    """Every trace that ObsPy finds in the bytes of a file of the ``format`` of that name.

    A warning of the class ``refused`` is an error, as it means damage that ObsPy reads around; others, about header
    fields that nothing here uses, are not shown. Raises RecordError for what ObsPy cannot read, for samples that are no
    finite numbers, fewer than two of them, and a time step out of range.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if refused is not None:
            warnings.simplefilter("error", refused)
        try:
            stream = obspy.read(BytesIO(raw), format=format)
        except Exception as error:  # its readers let out whatever happens: ValueError, struct.error, their own
            raise unreadable(name, kind, str(error).strip() or type(error).__name__) from None
    for trace in stream:
        check_step(name, trace.stats.delta, f"{trace.stats.delta:g}", "the time step")
        if trace.data.dtype.kind not in "if" or not np.isfinite(trace.data).all():
            raise unreadable(name, kind, "not every sample is a finite number")
        if len(trace.data) < 2:
            count = "1 sample" if len(trace.data) else "no sample"
            raise RecordError(f"{name}: has {count} in {trace.id}; a record needs at least 2")
    return stream


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
    names = (f"{Path(name).stem}.xml", f"{trace.stats.network}.{trace.stats.station}.xml")
    folder = Path(name).parent if folder is None else folder
    beside = next((folder / file for file in names if (folder / file).is_file()), None)
    azimuth, upright = _placed(trace)
    is_counts = trace.data.dtype.kind == "i"
    samples = trace.data.astype(np.float64)
    if beside is not None:
        counts, units, azimuth, upright = _sensitivity(trace, beside)
        trace.data, state = samples / counts, "raw"
    elif unit is not None:
        size = size_of_unit(unit, f"{name}: unit as given")
        units, state = unit_sentence(unit, size), "raw" if is_counts else "processed"
        with np.errstate(over="ignore"):
            trace.data = samples * size
        if not np.isfinite(trace.data).all():
            raise unreadable(name, kind, "samples are too large for a number in m/s²")
    else:
        raise RecordError(
            f"{name}: the unit is unknown, a {kind} file holds counts; put the StationXML of "
            f"{trace.id} beside it as {names[1]}, or, where its samples are no counts, give their unit: "
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
        **({"vertical": True} if upright and not trace.stats.channel.upper().endswith("Z") else {}),  # else by its name
    )


def _placed(trace: Trace) -> tuple[float | None, bool]:
    """Azimuth of a channel [degrees clockwise from north], and whether it is vertical, by its header and its name.

    CMPAZ and CMPINC of SAC, the latter from the vertical; without them the orientation code of SEED, of which N and E
    are within 5° of north and east.
    """
    header = trace.stats.get("sac", {})
    inclined = float(header.get("cmpinc", 90.0))
    if "cmpinc" in header and abs(90.0 - inclined) > LEVEL:
        return None, True
    code = trace.stats.channel.upper()[-1:]
    if code == "Z":  # whose CMPAZ, if there is one, points nowhere
        return None, True
    return float(header["cmpaz"]) if "cmpaz" in header else BY_NAME.get(code), False


def _sensitivity(trace: Trace, beside: Path) -> tuple[float, str, float | None, bool]:
    """Counts per m/s², the sentence that says so, and the channel's azimuth, and whether it is vertical, by `_placed`.

    The file's own direction comes before that of the header.
    """
    stats = trace.stats
    try:
        inventory = obspy.read_inventory(str(beside), format="STATIONXML")
        response = inventory.get_response(trace.id, stats.starttime)
        sensitivity = response.instrument_sensitivity
        if sensitivity is None or sensitivity.value is None:
            raise ValueError("its response states no total sensitivity")
        counts, unit = float(sensitivity.value), str(sensitivity.input_units).upper()
        output = str(sensitivity.output_units or "counts")
        placed = inventory.get_channel_metadata(trace.id, stats.starttime)
    except Exception as error:
        reason = (" ".join(str(error).split()) or type(error).__name__)[:200]
        raise RecordError(
            f"{beside}: gives no sensitivity for {trace.id} at {stats.starttime} ({reason}); fetch "
            "the StationXML of this channel with its response"
        ) from None
    if "COUNT" not in output.upper():  # also "digital counts"
        raise RecordError(
            f"{beside}: the sensitivity of {trace.id} is in {output[:40]} and not in counts; fetch the StationXML of "
            "this channel with the response of its digitiser"
        )
    size = known_unit(unit)
    if size is None or not counts:
        raise NoAcceleration(
            f'{beside}: {trace.id} measures {counts:g} counts per "{unit}", which is no acceleration; take '
            "an accelerometer's channel (such as HN or BN)"
        )
    per_si = counts / size
    _check_stages(f"{beside}: {trace.id}", response, per_si)
    # A vertical has no azimuth, and its dip may be left out.
    azimuth, upright = _placed(trace)
    upright = upright or abs(placed["dip"] or 0.0) > LEVEL
    azimuth = None if upright else azimuth if placed["azimuth"] is None else float(placed["azimuth"])
    return per_si, f"units: counts, divided by {per_si:.10g} counts per m/s² ({beside.name})", azimuth, upright


def _check_stages(where: str, response: Any, per_si: float) -> None:
    """Raise RecordError where the total sensitivity [counts per m/s²] is not what the gains of the stages make.

    Responses without stages, or with one whose gain or unit is unknown, have nothing to compare.
    """
    gains = [stage.stage_gain for stage in response.response_stages]
    size = known_unit(str(response.response_stages[0].input_units).upper()) if gains else None
    if size is None or not all(gains):
        return
    made = float(np.prod(gains)) / size
    if abs(per_si / made - 1.0) > STAGES_APART:
        raise RecordError(
            f"{where} has a total sensitivity of {per_si:.6g} counts per m/s², and the gains of its stages make "
            f"{made:.6g}; fetch the StationXML of this channel again, or correct the wrong one"
        )
