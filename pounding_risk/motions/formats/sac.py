"""SAC, binary: samples of any unit, read by ObsPy; a StationXML file beside it, or the user, says what a sample is.

A header of 158 words of four bytes, then the samples as 4-byte floats. The header names no unit that programs keep to
(IDEP means nm, nm/s and nm/s², and is mostly left unset); SCALE is not applied, as SAC itself does not. Where IDEP says
that the samples are a displacement or a velocity, the file is refused.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._native import bytes_of, read_by_obspy, to_acceleration
from pounding_risk.motions.formats._text import StatedPeak, check_peak, check_step, recogniser

KIND = "SAC"
HEAD = 632  # bytes
FOOT = {6: 0, 7: 22 * 8}  # bytes after the samples, by version of the header
UNSET = -12345
STEP, EXTREMES, FIRST_WHOLE, FIRST_FLAG = 0, 1, 70, 105  # words of the header
COUNT, VERSION, TYPE, DEPENDENT = 9, 6, 15, 16  # of the whole numbers
TIME_SERIES = 1
SAME = 1e-5  # of the peak: the header's floats of 4 bytes have 7 digits, as the samples have
OTHERS = {6: "a displacement", 7: "a velocity", 50: "volts"}


def _order(start: bytes) -> str | None:
    """The byte order of a SAC header, "<" or ">"; None where there is no such header."""
    for order in "<>":
        if len(start) < HEAD:
            return None
        version = struct.unpack_from(f"{order}i", start, 4 * (FIRST_WHOLE + VERSION))[0]
        flags = struct.unpack_from(f"{order}5i", start, 4 * FIRST_FLAG)
        if version in FOOT and all(flag in (0, 1, UNSET) for flag in flags):
            return order
    return None


@recogniser(HEAD)
def _is_sac(start: str) -> bool:
    """True for a binary SAC file."""
    return _order(start.encode("latin-1")) is not None


def _read_sac(
    file: Any, *, name: str = "", folder: Path | None = None, unit: str | None = None, **_kwargs: Any
) -> Stream:
    """One trace in m/s²; ``unit`` is for a file that has no StationXML beside it.

    Raises RecordError for a damaged file, uneven steps, samples that are no acceleration, a largest one that is not
    that of DEPMIN and DEPMAX, and an unknown unit.
    """
    name, raw = bytes_of(file, name, KIND)
    order = _order(raw)
    if order is None:
        raise RecordError(f"{name}: has no header of a binary SAC file; check that this is one, or fetch it again")
    (step,) = struct.unpack_from(f"{order}f", raw, 4 * STEP)
    integers = struct.unpack_from(f"{order}40i", raw, 4 * FIRST_WHOLE)
    if integers[TYPE] not in (TIME_SERIES, UNSET) or raw[4 * FIRST_FLAG : 4 * FIRST_FLAG + 4] == bytes(4):
        raise RecordError(f"{name}: is no time series with equal steps, by its SAC header; resample it to equal steps")
    if integers[DEPENDENT] in OTHERS:
        raise RecordError(
            f"{name}: its SAC header says that it holds {OTHERS[integers[DEPENDENT]]}; take the file of the "
            "acceleration"
        )
    size = HEAD + 4 * integers[COUNT]
    if integers[COUNT] < 0 or len(raw) != size + FOOT[integers[VERSION]]:
        raise RecordError(
            f"{name}: has {len(raw)} bytes, the SAC header promises {integers[COUNT]} samples, which take "
            f"{size + FOOT[integers[VERSION]]}; fetch the record again"
        )
    # The header has 7 digits: 0.01 is meant where the float nearest to it is written.
    dt = check_step(name, float(str(np.float32(step))), f"{step:g}", "DELTA")
    trace = read_by_obspy(raw[:size], name, "SAC", KIND)[0]
    trace.stats.delta = dt
    extremes = struct.unpack_from(f"{order}2f", raw, 4 * EXTREMES)
    if UNSET not in extremes and any(extremes) and np.isfinite(extremes).all():
        stated = StatedPeak(max(abs(extreme) for extreme in extremes), 0.0, "(DEPMIN, DEPMAX)", 1.0, name)
        check_peak(trace.data.astype(np.float64), stated, relative=SAME)
    to_acceleration(trace, name, folder, unit, KIND)
    return Stream([trace])


FORMAT = Format(
    "SAC", "SAC (.sac, with a StationXML file beside it)", (".sac",), _is_sac, _read_sac, native=True, takes=("unit",)
)
