"""Writing a motion to a file that other programs and this package read: plain columns in m/s², or PEER AT2 in g."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.files import check_target, write_whole
from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import one_trace
from pounding_risk.motions.read import open_source
from pounding_risk.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from obspy import Trace

    from pounding_risk.motions.motion import Motion

SUFFIXES = (".csv", ".at2")
AT2_COLUMNS = 5  # samples on a line
# Starts of the sentences of steps that leave a raw record raw: it keeps its offset and drift.
HARMLESS = ("units: ", "window: ", "polarity: ", "scale: ", "tail: ", "resample: ", "rotation: ", "cut: ")


def write_motion(motion: Motion, path: str | Path) -> Path:
    """Write a motion to a file whose suffix names the format; the file appears under its name when it is whole.

    Parameters
    ----------
    motion : Motion
        The motion to write.
    path : str or Path
        ``.csv``: columns of time [s] and acceleration [m/s²] with every digit, below the facts and the processing
        steps, so that the same samples are read again. ``.at2``: acceleration in g with eight digits, as PEER writes
        it, with the filter's corners; a component whose name says no azimuth is called by that. It is read again as a
        processed record.

    Returns
    -------
    Path
        The file written, after symbolic links.

    Raises
    ------
    PoundingError
        For another suffix, and where the file cannot be written.
    """
    target = check_target(path, SUFFIXES)
    if target.suffix.lower() == ".csv":
        return write_columns(motion, target)
    from pounding_risk.motions.formats.peer_at2 import azimuth_of  # imports ObsPy

    record, day = motion.record, str(motion.record.get("date") or "")
    with suppress(ValueError):  # month/day/year, as PEER writes a date; text that is no ISO date stays as it is
        iso = date.fromisoformat(day)
        day = f"{iso.month}/{iso.day}/{iso.year}"
    component, azimuth = str(record.get("component") or ""), record.get("azimuth")
    if azimuth is not None and azimuth_of(component) != azimuth:
        component = f"{azimuth:03g} ({component})"  # what stands in brackets is no part of the name
    title = (record.get("event"), day, record.get("station"), component)
    corners = [
        f"{name}={record[key]!r} Hz" for name, key in (("HP", "low_corner"), ("LP", "high_corner")) if record.get(key)
    ]
    values = motion.acceleration / STANDARD_GRAVITY
    lines = [
        "PEER AT2 RECORD, WRITTEN BY POUNDING_RISK",
        ", ".join(" ".join(str(part or "").split()) for part in title),
        " ".join(["ACCELERATION TIME SERIES IN UNITS OF G" + (". FILTER POINTS:" if corners else ""), *corners]),
        f"NPTS= {len(values)}, DT= {motion.dt!r} SEC",
    ]
    for start in range(0, len(values), AT2_COLUMNS):
        lines.append("".join(f"{value:15.7E}" for value in values[start : start + AT2_COLUMNS]))
    return write_text(target, "\n".join([*lines, ""]).encode("latin-1", errors="replace"), "choose another place")


def write_columns(source: Motion | Trace, path: str | Path) -> Path:
    """Write a motion or an ObsPy trace in m/s² as columns of time and acceleration, read back bit for bit.

    Parameters
    ----------
    source : Motion or obspy.Trace
        Acceleration [m/s²].
    path : str or Path
        The file; any suffix.

    Returns
    -------
    Path
        The file written. Its head states unit, time step, state, number of samples, their peak and what is known of
        the recording.

    Raises
    ------
    RecordError
        For samples that no run could use, and where the file cannot be written.
    """
    from pounding_risk.motions.formats.columns import FACTS  # imports ObsPy, and reading a manifest needs none of it

    samples, dt, stated, history = _of_motion(source) if hasattr(source, "acceleration") else _of_trace(source)
    lines = ["# ground acceleration", "# unit = m/s^2", f"# dt = {dt!r} s", f"# samples = {len(samples)}"]
    lines += [f"# peak = {max(map(abs, samples))!r} m/s^2"]
    facts = {key: stated.get(key) for key in ("state", "starttime", *FACTS, "source")}
    lines += [f"# {key} = {_one_line(value)}" for key, value in facts.items() if value not in (None, "")]
    lines += [f"# processing: {_one_line(step)}" for step in history]
    lines += ["time [s], acceleration [m/s^2]"]
    lines += [f"{at * dt!r}, {value!r}" for at, value in enumerate(samples)]
    return write_text(Path(path), ("\n".join(lines) + "\n").encode(), "choose another place")


def write_text(target: Path, text: bytes, repair: str) -> Path:
    """Write a whole file; raises RecordError, which ends with the ``repair``, where it cannot be written."""
    try:
        write_whole(target, lambda file: file.write(text))
    except OSError as error:
        raise RecordError(f"{target}: cannot be written ({error.strerror}); {repair}") from None
    return target


def state_of(motion: Motion) -> str:
    """Whether a motion is "raw" or "processed": a raw record is so until a correcting step is taken."""
    # Of a rotated motion the steps of its components stand behind their names.
    steps = (line for line in motion.processing if not line.partition(": ")[2].startswith(HARMLESS))
    is_processed = any(not line.startswith(HARMLESS) for line in steps)
    return "processed" if is_processed else str(motion.record.get("state", "processed"))


def _of_motion(motion: Any) -> tuple[list[float], float, dict[str, Any], Sequence[str]]:
    """Samples, time step, facts and history of a motion; a raw record is processed once a correcting step was taken."""
    state = state_of(motion)
    source = [str(motion.record[key]) for key in ("id", "file", "sha256", "origin") if motion.record.get(key)]
    facts = {**motion.record, "state": state, "starttime": motion.record.get("start"), "source": ", ".join(source)}
    return motion.acceleration.tolist(), float(motion.dt), facts, motion.processing


def _of_trace(trace: Any) -> tuple[list[float], float, dict[str, Any], Sequence[str]]:
    """Samples, time step, facts and history of an ObsPy trace."""
    source = open_source(one_trace(trace))
    stats = source.trace.stats
    history = stats.get("processing", [])
    state = "processed" if history else stats.get("record", {}).get("state", "processed")
    facts = {**source.record, "state": state, "starttime": stats.starttime, "source": ""}
    return np.asarray(source.trace.data, dtype=np.float64).tolist(), float(stats.delta), facts, (*history, source.units)


def _one_line(value: Any) -> str:
    """A fact as text on one line, without characters that cannot be printed."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in str(value)).split())
