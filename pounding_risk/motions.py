"""Ground motion as a run takes it: acceleration in m/s² at equal steps, and the history of how it got there.

`read_motion` is the one door: a record of the catalogue, a file or an ObsPy trace goes in, raw or processed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.processing import (
    DEFAULT_CHAIN,
    Done,
    Step,
    read_steps,
    window,
)
from pounding_risk.quality import AT_REST, FIRST_OF_PEAK, LASTING, LONGEST_STEP, OFFSET_OF_PEAK, failed, quality
from pounding_risk.quantities import PGA, SCALE, STEP, TAIL, TIME, shown
from pounding_risk.record_request import AS_RECORDED, REVERSED
from pounding_risk.resampling import MOST
from pounding_risk.scaling import asked, scale_samples, scale_samples_to, unit_doubts
from pounding_risk.signals import Samples, velocity_displacement
from pounding_risk.sources import RAW, USABLE, Source, check_samples, components, lowest_usable, open_source

if TYPE_CHECKING:
    from obspy import Stream, Trace

CHANGE_OF_PEAK = 0.02
WEAK_WINDOW = 0.5  # a window with less than this part of the PGA is flagged


@dataclass(frozen=True, eq=False)
class Motion:
    """One component of ground motion, ready to drive a run.

    ``acceleration`` [m/s²], shape (n,), read-only, one sample every ``dt`` [s], linear between them.
    ``record`` says where it is from: id, event, date, station, component, file, sha256 of the file, origin,
    terms, state, pga_recorded [m/s²], source (what it was read from), factor (what it was scaled by), and start, the
    time of the first sample (UTC) where it is known.
    ``processing`` has one sentence a step, ``flags`` one a doubt.

    Raises RecordError for fewer than two samples, samples that are not finite, and ``dt`` not above zero.
    """

    name: str
    acceleration: Samples
    dt: float
    record: dict[str, Any]
    processing: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        samples = np.array(self.acceleration, dtype=np.float64)
        check_samples(samples, self.dt, self.name)
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
    def times(self) -> Samples:
        """When each sample is [s], from zero, shape (n,)."""
        return np.arange(len(self.acceleration)) * self.dt

    @property
    def digest(self) -> str:
        """sha256 of what runs see: every sample [m/s²], then ``dt`` [s], as 8 bytes each, least significant first."""
        return sha256(np.append(self.acceleration, self.dt).astype("<f8").tobytes()).hexdigest()

    def reversed(self) -> Motion:
        """The motion with the other sign: a pair is not symmetric, so both directions are worth a run."""
        now = self.record.get("polarity", AS_RECORDED)
        turned = replace(self, record={**self.record, "polarity": REVERSED if now == AS_RECORDED else AS_RECORDED})
        return turned.after(_reverse(self.acceleration))

    def scaled_to(self, pga: float | str) -> Motion:
        """The motion times one factor, so that max|a| is ``pga`` [m/s², or text such as "0.5 g"]."""
        return self.after(scale_samples_to(self.acceleration, asked("pga", pga, PGA), self.name))

    def cut(self, start: float | str, end: float | str) -> Motion:
        """The part of the motion from ``start`` to ``end`` [s]; flagged where the strongest shaking is not in it."""
        done = _cut(self.acceleration, self.dt, _span((start, end)))
        part = replace(self, record=_later(self.record, done.cut * self.dt))
        return part.after(done._replace(flags=(*done.flags, *_doubts(done.samples, self.dt))))

    def with_tail(self, seconds: float | str) -> Motion:
        """The motion with zeros of that duration [s] after it: the buildings swing freely."""
        return self.after(_extend(self.acceleration, self.dt, asked("tail", seconds, TAIL)))

    def velocity_displacement(self) -> tuple[Samples, Samples]:
        """Ground velocity [m/s] and displacement [m] from rest, by the trapezoidal rule, shape (n,)."""
        return velocity_displacement(self.acceleration, self.dt)

    def after(self, done: Done) -> Motion:
        """The motion with the samples of a step, its sentence and its doubts."""
        factor = self.record.get("factor", 1.0) * done.factor
        return replace(
            self,
            acceleration=done.samples,
            record={**self.record, "factor": factor} if done.factor != 1.0 else self.record,
            processing=(*self.processing, *([done.sentence] if done.sentence else [])),
            flags=tuple(dict.fromkeys((*self.flags, *done.flags))),
        )


def driven(motion: Motion, polarity: str, pga: float | None) -> Motion:
    """A motion in one polarity, scaled to one amplitude of the grid."""
    turned = motion.reversed() if polarity == REVERSED else motion
    return turned if pga is None else turned.scaled_to(pga)


def read_motion(
    source: str | Path | Trace | Source,
    *,
    window: tuple[float | str, float | str] | None = None,
    pga: float | str | None = None,
    scale: float | str | None = None,
    processing: str | Sequence[Mapping[str, Any]] = "auto",
    polarity: str = AS_RECORDED,
    tail: float | str = 0.0,
    unit: str | None = None,
    dt: float | str | None = None,
) -> Motion:
    """The ground motion of a record: read, processed, cut, scaled.

    ``source`` is an id of the catalogue ("RSN6-180") or of a published set, a path to a file of a known format (of
    several components one is named after "#": "quake.V2A#N28W"), or an ObsPy trace in m/s². ``unit`` ("cm/s^2") and
    ``dt`` [s] are for files that do not state theirs. ``processing`` "auto" filters and corrects a raw record and
    leaves a processed one as it is; "none" leaves both; a list of tables names the steps (`pounding_risk.processing`).
    After that come ``window`` (start, end) [s], ``polarity`` ("as recorded" or "reversed"), one of ``pga`` [m/s²]
    and ``scale`` (factor), and ``tail`` [s] of zeros. Numbers are SI; text has its unit ("6 s", "0.5 g").

    Raises RecordError for what cannot be read or trusted, with the repair.
    """
    trace, record, flags = _prepared(
        source,
        window=window,
        pga=pga,
        scale=scale,
        processing=processing,
        polarity=polarity,
        tail=tail,
        unit=unit,
        dt=dt,
    )
    name = str(record["id"])
    return Motion(name, trace.data, trace.stats.delta, record, tuple(trace.stats.processing), flags)


def read_trace(source: str | Path | Trace, **choices: Any) -> Trace:
    """As `read_motion`, as an ObsPy trace in m/s² whose ``stats.processing`` has the history."""
    return _prepared(source, **choices)[0]


def read_stream(source: str | Path | Stream, **choices: Any) -> Stream:
    """As `read_trace`, of every component of a file or of an ObsPy stream, as an ObsPy stream.

    Each is treated by itself; a stream in pieces is to be merged before.
    """
    from obspy import Stream

    if isinstance(source, Stream):
        return Stream([read_trace(trace, **choices) for trace in source])
    if isinstance(source, str | Path) and Path(source).is_file():
        unit, dt = choices.pop("unit", None), choices.pop("dt", None)
        step = None if dt is None else asked("dt", dt, STEP)
        return Stream([read_trace(each, **choices) for each in components(Path(source), unit=unit, dt=step)])
    return Stream([read_trace(source, **choices)])


def _prepared(
    source: str | Path | Trace | Source,
    *,
    window: tuple[float | str, float | str] | None = None,
    pga: float | str | None = None,
    scale: float | str | None = None,
    processing: str | Sequence[Mapping[str, Any]] = "auto",
    polarity: str = AS_RECORDED,
    tail: float | str = 0.0,
    unit: str | None = None,
    dt: float | str | None = None,
) -> tuple[Trace, dict[str, Any], tuple[str, ...]]:
    """The processed trace, the record it is of, and the doubts about it."""
    target = None if pga is None else asked("pga", pga, PGA)
    factor = None if scale is None else asked("scale", scale, SCALE)
    quiet = asked("tail", tail, TAIL)
    span = None if window is None else _span(window)
    if target is not None and factor is not None:
        raise RecordError("pga and scale are both given; a record is scaled by one of them: leave one out")
    if polarity not in (AS_RECORDED, REVERSED):
        raise RecordError(f'polarity: {shown(polarity)} is not one; it may be "{AS_RECORDED}" or "{REVERSED}"')
    found = open_source(source, unit=unit, dt=None if dt is None else asked("dt", dt, STEP))
    chain = _chain(processing, found.record["state"])
    log = _Log(found)
    _process(log, chain)
    # The window comes after the chain and not before: the offset is seen in the quiet before the earthquake
    # and the drift at its end, and a filter rings where a record is cut in mid-shaking. A cut that is to come
    # earlier, such as one of two earthquakes in a file, is a step of the chain.
    if span is not None:
        log.add(_cut(log.samples, log.dt, span))
    if polarity == REVERSED:
        log.add(_reverse(log.samples))
    if target is not None:
        log.add(scale_samples_to(log.samples, target, found.name))
    if factor is not None:
        log.add(scale_samples(log.samples, factor))
    log.flags += _doubts(log.samples, log.dt)
    if quiet > 0.0:
        log.add(_extend(log.samples, log.dt, quiet))
    record = _later({**found.record, "polarity": polarity, "factor": log.factor}, log.start) | log.corners()
    return log.trace(), record, tuple(dict.fromkeys(log.flags))


def _later(record: dict[str, Any], seconds: float) -> dict[str, Any]:
    """The facts of a record that starts later, where its start is known."""
    if not seconds or not record.get("start"):
        return record
    return {**record, "start": (datetime.fromisoformat(record["start"]) + timedelta(seconds=seconds)).isoformat()}


class _Log:
    """Samples on their way through the steps, with the sentence and the doubts of each."""

    def __init__(self, found: Source):
        self.samples: Samples = np.array(found.trace.data, dtype=np.float64)
        self.dt = float(found.trace.stats.delta)
        self.start, self.flags = 0.0, list(unit_doubts(found.record["pga_recorded"], "as recorded"))
        self.factor, self.band = 1.0, (0.0, inf)
        self.raw = found.record["state"] == RAW
        self._source, self._record = found.trace, found.record
        self.sentences = [*found.trace.stats.get("processing", []), found.units]

    def add(self, done: Done) -> None:
        """Take over what a step gave."""
        self.samples, self.start = done.samples, self.start + done.cut * self.dt
        self.dt = self.dt if done.dt is None else done.dt
        self.factor *= done.factor
        self.band = max(self.band[0], done.band[0]), min(self.band[1], done.band[1])
        self.sentences.append(done.sentence)
        self.flags += done.flags

    def corners(self) -> dict[str, float]:
        """Facts of a record that a filter here has changed: its own corners, and those it came with, the narrower."""
        (low, high), facts = self.band, {}
        if low > 0.0:
            low = max(low, self._record.get("low_corner") or 0.0)
            usable = max(USABLE * low, lowest_usable(self._record) or 0.0)
            facts = {"low_corner": low, "lowest_usable_frequency": usable}
        if high < inf:
            facts["high_corner"] = min(high, self._record.get("high_corner") or inf)
        return facts

    def trace(self) -> Trace:
        """The samples as an ObsPy trace; the one they came from stays as it was."""
        trace = self._source.copy()
        trace.data = self.samples
        if trace.stats.delta != self.dt:
            trace.stats.delta = self.dt
        trace.stats.starttime += self.start
        trace.stats.processing = list(self.sentences)
        return trace


def _process(log: _Log, chain: Sequence[Step]) -> None:
    """Every step of the chain; flagged where they change PGA by more than 2 %, or leave an offset."""
    centred = log.samples - log.samples.mean() if log.raw else log.samples
    before = float(np.abs(centred).max())
    log.flags += failed(quality(log.samples, log.dt, checks=LASTING))
    for step in chain:
        log.add(step.apply(log.samples, log.dt))
    # A baseline correction tells itself how the motion ends, and may leave a permanent displacement in.
    if not any(step.name == "baseline" for step in chain):
        log.flags += failed(quality(log.samples, log.dt, checks=AT_REST))
    after = float(np.abs(log.samples).max())
    if chain and before > 0.0 and abs(after / before - 1.0) > CHANGE_OF_PEAK:
        log.flags.append(f"processing changed PGA by {100.0 * (after / before - 1.0):+.1f} %")
    offset = abs(float(log.samples.mean()))
    if offset > OFFSET_OF_PEAK * after:
        log.flags.append(f"the mean of the record is {100.0 * offset / after:.0f} % of its PGA: subtract it")


def _chain(processing: Any, state: str) -> Sequence[Step]:
    """The steps that ``processing`` stands for."""
    if not isinstance(processing, str) and isinstance(processing, Sequence):
        return read_steps(processing)
    if processing == "auto":
        # Filtering a processed record again is the commonest way to damage one.
        return DEFAULT_CHAIN if state == RAW else ()
    if processing != "none":
        raise RecordError(
            f'processing: {shown(processing)} is not one; it may be "auto", "none" or a list of steps such '
            'as [{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]'
        )
    return ()


def _span(given: Any) -> tuple[float, float]:
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        raise RecordError(f"window: {shown(given)} is not a start and an end; give two times such as (0.0, 6.0)")
    return asked("window", given[0], TIME), asked("window", given[1], TIME)


def _cut(samples: Samples, dt: float, span: tuple[float, float]) -> Done:
    """The part of a record that a run sees; flagged where the strongest shaking is not in it."""
    done = window(samples, dt, start=span[0], end=span[1])
    peak, kept = float(np.abs(samples).max()), float(np.abs(done.samples).max())
    if kept >= WEAK_WINDOW * peak:
        return done
    flag = f"the window leaves the strong shaking out: its PGA is {100.0 * kept / peak:.2g} % of the record's"
    return done._replace(flags=(*done.flags, flag))


def _reverse(samples: Samples) -> Done:
    return Done(-samples, "polarity: reversed")


def _extend(samples: Samples, dt: float, seconds: float) -> Done:
    count = round(seconds / dt)
    if count > MOST:
        raise RecordError(f"a tail of {seconds:g} s makes {count} samples, {MOST} are allowed; write a shorter one")
    return Done(np.pad(samples, (0, count)), f"tail: {count * dt:g} s of zeros added")


def _doubts(samples: Samples, dt: float) -> tuple[str, ...]:
    """What a user should know about the samples that a run sees."""
    flags = []
    peak, first = float(np.abs(samples).max()), abs(float(samples[0]))
    if first > FIRST_OF_PEAK * peak:
        share = f"{100.0 * first / peak:.1f} %"
        flags.append(f"the motion starts at {share} of its PGA: a late trigger, or a cut in motion")
    if dt > LONGEST_STEP:
        flags.append(f"the time step {dt:g} s is longer than {LONGEST_STEP:g} s: peaks may be missed")
    return tuple(flags)
