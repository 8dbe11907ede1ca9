"""Ground motion as a run takes it: acceleration in m/s² at equal steps, and the history of how it got there.

`read_motion` is the one door: a record of the catalogue, a file or an ObsPy trace goes in, raw or processed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk import catalogue
from pounding_risk.errors import RecordError
from pounding_risk.formats import read_file, single_trace
from pounding_risk.processing import (
    DEFAULT_CHAIN,
    Done,
    Samples,
    Step,
    read_steps,
    si,
    velocity_displacement,
    window,
)
from pounding_risk.quantities import PGA, SCALE, STANDARD_GRAVITY, TAIL, TIME, QuantityError, shown

if TYPE_CHECKING:
    from obspy import Trace

AS_RECORDED, REVERSED = "as recorded", "reversed"
RAW, PROCESSED = "raw", "processed"
LARGEST_PGA, SMALLEST_PGA = 3.0, 0.001  # g; beyond these a unit is likely wrong
LONGEST_STEP = 0.02  # s; longer steps miss peaks
FIRST_OF_PEAK, OFFSET_OF_PEAK, CHANGE_OF_PEAK = 0.02, 0.05, 0.02
USUAL_FACTORS = (0.25, 4.0)


@dataclass(frozen=True, eq=False)
class Motion:
    """One component of ground motion, ready to drive a run.

    ``acceleration`` [m/s²], shape (n,), read-only, one sample every ``dt`` [s], linear between them.
    ``record`` says where it is from: id, event, date, station, component, file, sha256 of the file, origin,
    terms, state, pga_recorded [m/s²]. ``processing`` has one sentence a step, ``flags`` one a doubt.

    Raises RecordError for fewer than two samples, samples that are not finite, and ``dt`` not above zero.
    """

    name: str
    acceleration: NDArray[np.float64]
    dt: float
    record: dict[str, Any]
    processing: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        samples = np.array(self.acceleration, dtype=np.float64)
        _check(samples, self.dt, self.name)
        samples.flags.writeable = False
        object.__setattr__(self, "acceleration", samples)

    @property
    def pga(self) -> float:
        """Peak ground acceleration max|a| [m/s²]."""
        return float(np.abs(self.acceleration).max())

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return (len(self.acceleration) - 1) * self.dt

    @property
    def times(self) -> NDArray[np.float64]:
        """When each sample is [s], from zero, shape (n,)."""
        return np.arange(len(self.acceleration)) * self.dt

    def reversed(self) -> Motion:
        """The motion with the other sign: a pair is not symmetric, so both directions are worth a run."""
        now = self.record.get("polarity", AS_RECORDED)
        turned = replace(
            self, record={**self.record, "polarity": REVERSED if now == AS_RECORDED else AS_RECORDED}
        )
        return turned._after(_reverse(self.acceleration))

    def scaled_to(self, pga: float | str) -> Motion:
        """The motion times one factor, so that max|a| is ``pga`` [m/s², or text such as "0.5 g"]."""
        return self._after(_scale(self.acceleration, _asked("pga", pga, PGA), None, self.name))

    def with_tail(self, seconds: float | str) -> Motion:
        """The motion with zeros of that duration [s] after it: the buildings swing freely."""
        return self._after(_extend(self.acceleration, self.dt, _asked("tail", seconds, TAIL)))

    def velocity_displacement(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Ground velocity [m/s] and displacement [m] from rest, by the trapezoidal rule, each of shape (n,)."""
        return velocity_displacement(self.acceleration, self.dt)

    def _after(self, done: Done) -> Motion:
        return replace(
            self,
            acceleration=done.samples,
            processing=(*self.processing, *([done.sentence] if done.sentence else [])),
            flags=tuple(dict.fromkeys((*self.flags, *done.flags))),
        )


class _Source(NamedTuple):
    """A record before anything is done to it: trace in m/s², where it is from, raw or processed."""

    name: str
    trace: Trace
    record: dict[str, Any]
    units: str


def read_motion(
    source: str | Path | Trace,
    *,
    window: tuple[float | str, float | str] | None = None,
    pga: float | str | None = None,
    scale: float | str | None = None,
    processing: str | Sequence[Mapping[str, Any]] = "auto",
    polarity: str = AS_RECORDED,
    tail: float | str = 0.0,
) -> Motion:
    """The ground motion of a record: read, processed, cut, scaled.

    ``source`` is an id of the catalogue ("RSN6-180"), a path to a file (PEER AT2; MiniSEED with StationXML),
    or an ObsPy trace in m/s². ``processing`` "auto" filters and corrects a raw record and leaves a processed
    one as it is; "none" leaves both; a list of tables names the steps (`pounding_risk.processing`). After
    that come ``window`` (start, end) [s], ``polarity`` ("as recorded" or "reversed"), one of ``pga`` [m/s²]
    and ``scale`` (factor), and ``tail`` [s] of zeros. Numbers are SI; text has its unit ("6 s", "0.5 g").

    Raises RecordError for what cannot be read or trusted, with the repair.
    """
    trace, record, flags = _prepared(
        source, window=window, pga=pga, scale=scale, processing=processing, polarity=polarity, tail=tail
    )
    name = str(record["id"])
    return Motion(name, trace.data, trace.stats.delta, record, tuple(trace.stats.processing), flags)


def read_trace(source: str | Path | Trace, **choices: Any) -> Trace:
    """As `read_motion`, as an ObsPy trace in m/s² whose ``stats.processing`` has the history."""
    return _prepared(source, **choices)[0]


def _prepared(
    source: str | Path | Trace,
    *,
    window: tuple[float | str, float | str] | None = None,
    pga: float | str | None = None,
    scale: float | str | None = None,
    processing: str | Sequence[Mapping[str, Any]] = "auto",
    polarity: str = AS_RECORDED,
    tail: float | str = 0.0,
) -> tuple[Trace, dict[str, Any], tuple[str, ...]]:
    """The processed trace, the record it is of, and the doubts about it."""
    target = None if pga is None else _asked("pga", pga, PGA)
    factor = None if scale is None else _asked("scale", scale, SCALE)
    quiet = _asked("tail", tail, TAIL)
    span = None if window is None else _span(window)
    if target is not None and factor is not None:
        raise RecordError("pga and scale are both given; a record is scaled by one of them: leave one out")
    if polarity not in (AS_RECORDED, REVERSED):
        raise RecordError(
            f'polarity: {shown(polarity)} is not one; it may be "{AS_RECORDED}" or "{REVERSED}"'
        )
    found = _found(source)
    chain = _chain(processing, found.record["state"])
    log = _Log(found)
    _process(log, chain)
    # The window comes after the chain and not before: the offset is seen in the quiet before the earthquake and
    # the drift at its end, and a filter rings where a record is cut in mid-shaking. A cut that is to come
    # earlier, such as one of two earthquakes in a file, is a step of the chain.
    if span is not None:
        log.add(_cut(log.samples, log.dt, span))
    if polarity == REVERSED:
        log.add(_reverse(log.samples))
    if target is not None or factor is not None:
        log.add(_scale(log.samples, target, factor, found.name))
    log.flags += _doubts(log.samples, log.dt)
    if quiet > 0.0:
        log.add(_extend(log.samples, log.dt, quiet))
    record = {**found.record, "polarity": polarity}
    return log.trace(), record, tuple(dict.fromkeys(log.flags))


class _Log:
    """Samples on their way through the steps, with the sentence and the doubts of each."""

    def __init__(self, found: _Source):
        self.samples: Samples = np.array(found.trace.data, dtype=np.float64)
        self.dt = float(found.trace.stats.delta)
        self.start, self.flags = 0, list(_unit_doubts(found.record["pga_recorded"], "as recorded"))
        self.raw = found.record["state"] == RAW
        self._source = found.trace
        self.sentences = [*found.trace.stats.get("processing", []), found.units]

    def add(self, done: Done) -> None:
        """Take over what a step gave."""
        self.samples, self.start = done.samples, self.start + done.cut
        self.sentences.append(done.sentence)
        self.flags += done.flags

    def trace(self) -> Trace:
        """The samples as an ObsPy trace; the one they came from stays as it was."""
        trace = self._source.copy()
        trace.data = self.samples
        trace.stats.starttime += self.start * self.dt
        trace.stats.processing = list(self.sentences)
        return trace


def _process(log: _Log, chain: Sequence[Step]) -> None:
    """Every step of the chain; flagged where they change PGA by more than 2 %, or leave an offset."""
    centred = log.samples - log.samples.mean() if log.raw else log.samples
    before = float(np.abs(centred).max())
    for step in chain:
        log.add(step.apply(log.samples, log.dt))
    after = float(np.abs(log.samples).max())
    if chain and before > 0.0 and abs(after / before - 1.0) > CHANGE_OF_PEAK:
        log.flags.append(f"processing changed PGA by {100.0 * (after / before - 1.0):+.1f} %")
    offset = abs(float(log.samples.mean()))
    if offset > OFFSET_OF_PEAK * after:
        log.flags.append(f"the mean of the record is {100.0 * offset / after:.0f} % of its PGA: subtract it")


def _chain(processing: str | Sequence[Mapping[str, Any]], state: str) -> Sequence[Step]:
    """The steps that ``processing`` stands for."""
    if processing == "none":
        return ()
    if processing == "auto":
        # Filtering a processed record again is the commonest way to damage one.
        return DEFAULT_CHAIN if state == RAW else ()
    if isinstance(processing, str) or not isinstance(processing, Sequence):
        raise RecordError(
            f'processing: {shown(processing)} is not one; it may be "auto", "none" or a list of steps such as '
            '[{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]'
        )
    return read_steps(processing)


def _found(source: str | Path | Trace) -> _Source:
    """The record that ``source`` stands for, its samples checked."""
    if isinstance(source, str) and _is_id(source):
        found = _of_catalogue(source)
    elif isinstance(source, str | Path):
        found = _of_file(Path(source))
    else:
        found = _of_trace(source)
    _check(found.trace.data, found.trace.stats.delta, found.name)
    samples = np.asarray(found.trace.data, dtype=np.float64)
    offset = samples.mean() if found.record["state"] == RAW else 0.0
    found.record["pga_recorded"] = float(np.abs(samples - offset).max())
    return found


def _is_id(source: str) -> bool:
    """True for an id of the catalogue, and for a word that looks like one rather than like a path."""
    if any(found.id == source for found in catalogue.entries()):
        return True
    return not (Path(source).suffix or "/" in source or "\\" in source or Path(source).exists())


def _of_catalogue(id: str) -> _Source:
    found = catalogue.entry(id)
    trace = catalogue.load(id)[0]
    keys = ("id", "event", "magnitude", "date", "station", "component", "azimuth", "state", "format", "file")
    more = ("package", "version", "sha256", "origin", "terms", "note")
    record = {key: getattr(found, key) for key in (*keys, *more)}
    counts = f"counts, divided by {found.sensitivity:.10g} counts per m/s²"
    return _Source(
        id, trace, record, f"units: {'g, times 9.80665 m/s²' if found.sensitivity == 1.0 else counts}"
    )


def _of_file(path: Path) -> _Source:
    read = read_file(path)
    record = {**_told(read.trace), "id": path.stem, "state": read.state, "format": read.format}
    record.update(file=str(path), sha256=read.sha256, origin="a file of the user", terms="")
    return _Source(str(path), read.trace, record, read.units)


def _of_trace(source: Any) -> _Source:
    """A trace in memory: its samples are m/s² by contract, and processed by whoever made it."""
    from obspy import Stream, Trace

    if isinstance(source, Stream):
        source = single_trace(source, "the ObsPy stream")
    if not isinstance(source, Trace):
        raise RecordError(
            f"{shown(source)} is not a record; give an id of the catalogue, a path, or an ObsPy trace in m/s²"
        )
    name = source.id if source.id.strip(".") else "trace"
    if source.stats.calib != 1.0:
        raise RecordError(
            f"{name}: the trace has calib {source.stats.calib:g}, so its samples are no m/s² yet; multiply them "
            "by it and set stats.calib = 1"
        )
    record = {**_told(source), "id": name, "state": PROCESSED, "format": "ObsPy trace", "file": ""}
    digest = sha256(np.ascontiguousarray(source.data, dtype="<f8").tobytes()).hexdigest()
    record.update(sha256=digest, origin="an ObsPy trace of the user", terms="")
    return _Source(name, source, record, "units: m/s², as given")


def _told(trace: Trace) -> dict[str, Any]:
    """What a trace's header says about the recording."""
    at2 = trace.stats.get("peer_at2", {})
    told = {key: at2.get(key, "") for key in ("event", "date")}
    date = str(trace.stats.starttime.date) if told["date"] or not at2 else ""
    return {**told, "date": date, "station": trace.stats.station, "component": trace.stats.channel}


def _check(samples: Any, dt: float, name: str) -> None:
    """Refuse what no run could use."""
    if not (isfinite(dt) and dt > 0.0):
        raise RecordError(f"{name}: the time step is {dt:g} s; it must be greater than 0: check the record")
    if np.ma.isMaskedArray(samples) and np.ma.count_masked(samples):
        gaps = int(np.ma.count_masked(samples))
        raise RecordError(f"{name}: has gaps ({gaps} samples are missing); cut or fill them before")
    if np.ndim(samples) != 1 or len(samples) < 2:
        count = np.size(samples)
        raise RecordError(f"{name}: has {count} sample{'s' if count != 1 else ''}; a record needs at least 2")
    wrong = np.flatnonzero(~np.isfinite(samples))
    if len(wrong):
        raise RecordError(
            f"{name}: {len(wrong)} sample{'s are' if len(wrong) > 1 else ' is'} not finite, the first at index "
            f"{wrong[0]} (t = {wrong[0] * dt:g} s); repair or replace the record"
        )


def _asked(key: str, value: Any, quantity: Any) -> float:
    try:
        return si(value, quantity)
    except QuantityError as error:
        raise RecordError(f"{key}: {error}") from None


def _span(asked: Any) -> tuple[float, float]:
    if isinstance(asked, str) or not isinstance(asked, Sequence) or len(asked) != 2:
        raise RecordError(
            f"window: {shown(asked)} is not a start and an end; give two times such as (0.0, 6.0)"
        )
    return _asked("window", asked[0], TIME), _asked("window", asked[1], TIME)


def _cut(samples: Samples, dt: float, span: tuple[float, float]) -> Done:
    return window(samples, dt, start=span[0], end=span[1])


def _reverse(samples: Samples) -> Done:
    return Done(-samples, "polarity: reversed")


def _scale(samples: Samples, target: float | None, factor: float | None, name: str) -> Done:
    """Scale by one factor, to max|a| = ``target`` [m/s²] or by ``factor``."""
    peak = float(np.abs(samples).max())
    if factor is None:
        assert target is not None
        if peak == 0.0:
            raise RecordError(
                f"{name}: every sample is zero, which no factor scales; check record and window"
            )
        factor = target / peak
    scaled = samples * factor
    pga = float(np.abs(scaled).max())
    if target is not None and not abs(pga - target) <= 1e-12 * target:
        raise RecordError(f"{name}: a PGA of {target:g} m/s² is out of reach for samples of {peak:g} m/s²")
    flags = list(_unit_doubts(pga, "after scaling"))
    if not USUAL_FACTORS[0] <= factor <= USUAL_FACTORS[1]:
        flags.append(f"the scale factor {factor:.4g} is outside {USUAL_FACTORS[0]:g} to {USUAL_FACTORS[1]:g}")
    sentence = f"scale: times {factor:.10g}, from PGA {peak / STANDARD_GRAVITY:.5g} g to {pga / STANDARD_GRAVITY:.5g} g"
    return Done(scaled, sentence, tuple(flags))


def _extend(samples: Samples, dt: float, seconds: float) -> Done:
    count = round(seconds / dt)
    return Done(np.pad(samples, (0, count)), f"tail: {count * dt:g} s of zeros added")


def _unit_doubts(pga: float, when: str) -> tuple[str, ...]:
    """A peak that no earthquake, or no earthquake of interest, has."""
    in_g = pga / STANDARD_GRAVITY
    if SMALLEST_PGA <= in_g <= LARGEST_PGA:
        return ()
    side = f"above {LARGEST_PGA:g} g" if in_g > LARGEST_PGA else f"below {SMALLEST_PGA:g} g"
    return (f"PGA {when} is {in_g:.3g} g, {side}: check the unit",)


def _doubts(samples: Samples, dt: float) -> tuple[str, ...]:
    """What a user should know about the samples that a run sees."""
    flags = []
    peak, first = float(np.abs(samples).max()), abs(float(samples[0]))
    if first > FIRST_OF_PEAK * peak:
        flags.append(
            f"the motion starts at {100.0 * first / peak:.1f} % of its PGA: late trigger, or cut in mid-shaking"
        )
    if dt > LONGEST_STEP:
        flags.append(f"the time step {dt:g} s is longer than {LONGEST_STEP:g} s: peaks may be missed")
    return tuple(flags)
