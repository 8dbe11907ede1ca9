"""K-NET and KiK-net: counts as text, read by ObsPy; the header says how many gal a count is.

The seventeen lines of the header are those of NIED (https://www.kyoshin.bosai.go.jp). Its "Max. Acc. (gal)" is the
largest sample without the offset of the whole record, so that a damaged file is seen. Times are Japanese and 15 s late;
ObsPy takes both out.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from obspy import Stream, Trace

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format
from pounding_risk.motions.formats._native import bytes_of, read_by_obspy, unreadable
from pounding_risk.motions.formats._text import StatedPeak, check_count, check_peak, quoted, recogniser, record_facts

KIND = "K-NET"
GAL = 0.01  # m/s²
FEWEST, SHARE = 0.05, 0.01  # gal, or of the peak: what a header that took another offset out differs by
AZIMUTHS = {"NS": 0.0, "EW": 90.0}
SENSORS = {"1": "borehole", "2": "surface"}  # last in the names of KiK-net's components

_LINES = {
    "Sampling Freq(Hz)": re.compile(r"(\d+)\s*Hz", re.ASCII),
    "Duration Time(s)": re.compile(r"(\d+(?:\.\d+)?)", re.ASCII),
    "Scale Factor": re.compile(r"(\d+(?:\.\d+)?)\(gal\)/(\d+(?:\.\d+)?)", re.ASCII),
    "Max. Acc. (gal)": re.compile(r"(\d+(?:\.\d+)?)", re.ASCII),
}


@recogniser(11)
def _is_knet(start: str) -> bool:
    """True for a K-NET or KiK-net file."""
    return start == "Origin Time"


def _read_knet(file: Any, *, name: str = "", **_kwargs: Any) -> Stream:
    """One trace in m/s² of a K-NET or KiK-net file.

    Raises RecordError for a header out of order, another number of samples than sampling frequency and duration
    promise, samples that are no whole numbers, and a largest one that is not the header's.
    """
    name, raw = bytes_of(file, name, KIND)
    if not raw.startswith(b"Origin Time"):
        raise RecordError(f"{name}: does not start with Origin Time, as a {KIND} file does; check that this is one")
    lines = raw[:4096].decode("latin-1").splitlines()
    (frequency,), (duration,), scale, (largest,) = (_numbers(name, lines, label) for label in _LINES)
    if not scale[0] or not scale[1] or not frequency:
        raise RecordError(f"{name}: Sampling Freq or Scale Factor is zero; fetch the record again")
    trace: Trace = read_by_obspy(raw, name, "KNET", KIND)[0]
    check_count(name, round(frequency * duration), len(trace.data), "Duration Time(s)")
    if not np.array_equal(trace.data, np.rint(trace.data)):
        raise unreadable(name, KIND, "not every sample is a whole number")
    size = GAL * scale[0] / scale[1]
    trace.data = trace.data * size
    stated = StatedPeak(largest, max(FEWEST, SHARE * largest), "gal", GAL, f"{name}: Max. Acc. (gal)")
    check_peak(trace.data - trace.data.mean(), stated, relative=0.0)
    trace.stats.calib = 1.0
    channel = trace.stats.channel
    trace.stats.record = record_facts(
        state="raw",
        event=trace.stats.knet.evot.strftime("%Y-%m-%d %H:%M UTC"),
        units=f"units: counts, times {size:.10g} m/s² per count",
        magnitude=trace.stats.knet.mag,
        date=str(trace.stats.starttime.date),
        station=trace.stats.station,
        component=channel,
        sensor=SENSORS.get(channel[2:]),
        azimuth=AZIMUTHS.get(channel[:2]),
        header_pga=largest * GAL,
    )
    return Stream([trace])


def _numbers(name: str, lines: list[str], label: str) -> tuple[float, ...]:
    """The numbers of the header line that starts with ``label``."""
    line = next((candidate for candidate in lines if candidate.startswith(label)), None)
    if line is None:
        raise RecordError(f'{name}: has no line "{label}" in its header; fetch the record again')
    match = _LINES[label].fullmatch(line[len(label) :].strip())
    if match is None or len(line) > 200:
        raise RecordError(f"{name}: {quoted(line)} does not say what a {KIND} header says there; fetch it again")
    return tuple(float(word) for word in match.groups())


FORMAT = Format(
    "KNET",
    "K-NET or KiK-net (.EW, .NS, .UD)",
    (".ew", ".ns", ".ud", *(f".{each}{place}" for each in ("ew", "ns", "ud") for place in "12"), ".knet"),
    _is_knet,
    _read_knet,
    native=True,
)
