"""Ground motion as a run takes it: acceleration in m/s² at equal steps, and the history of how it got there.

`read_motion` is the one door: a record of the catalogue, a file or an ObsPy trace goes in, raw or processed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.chain import DEFAULT_CHAIN, Done, Step, read_steps
from pounding_risk.motions.processing.signals import Samples, velocity_displacement
from pounding_risk.motions.quality import AT_REST, LASTING, OFFSET_OF_PEAK, failed, quality
from pounding_risk.motions.request import AS_RECORDED, REVERSED, conflicts
from pounding_risk.motions.scaling import asked, to_pga, unit_doubts
from pounding_risk.motions.source import (
    RAW,
    USABLE,
    Source,
    check_samples,
    check_shaking,
    components,
    lowest_usable,
    open_source,
)
from pounding_risk.motions.treatment import Treatment, cut, doubts, extended, treated, turned_round
from pounding_risk.units import PGA, SCALE, STANDARD_GRAVITY, STEP, TAIL, TIME, shown

if TYPE_CHECKING:
    from obspy import Stream, Trace

CHANGE_OF_PEAK = 0.02


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """One component of ground motion, ready to drive a run.

    ``acceleration`` [m/s²], shape (n,), read-only, one sample every ``dt`` [s], linear between them.
    ``record`` says where it is from: id, event, date, station, component, file, sha256 of the file, origin,
    terms, state, pga_recorded [m/s²], source (what it was read from), factor (what it was scaled by), start, the time
    of the first sample (UTC) where it is known, and cut_from_start [s] where a part before the first sample was cut.
    ``processing`` has one sentence a step, ``flags`` one a doubt.

    Raises RecordError for fewer than two samples, samples that are not finite, and ``dt`` not above zero.
    """

    name: str
    acceleration: Samples
    dt: float
    record: dict[str, Any]
    processing: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()

    def facts(self) -> Iterable[tuple[str, str]]:
        """Where the motion is from, how long and how strong it is."""
        yield "name", self.name
        if self.record.get("event"):
            yield "event", str(self.record["event"])
        yield "samples", f"{self.acceleration.size} every {self.dt:g} s, {self.duration:g} s"
        yield "PGA", f"{self.pga / STANDARD_GRAVITY:.4g} g"
        yield "processing", "; ".join(self.processing) or "none"
        for flag in self.flags:
            yield "doubt", flag

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
        return turned.after(turned_round(self.acceleration))

    def scaled_to(self, pga: float | str) -> Motion:
        """The motion times one factor, so that max|a| is ``pga`` [m/s², or text such as "0.5 g"]."""
        return to_pga(self, pga)

    def cut(self, start: float | str, end: float | str) -> Motion:
        """The part of the motion from ``start`` to ``end`` [s]; flagged where the strongest shaking is not in it."""
        part = self.after(cut(self.acceleration, self.dt, _span((start, end))))
        return part.doubted(doubts(part.acceleration, self.dt))

    def with_tail(self, seconds: float | str) -> Motion:
        """The motion with zeros of that duration [s] after it: the buildings swing freely."""
        return self.after(extended(self.acceleration, self.dt, asked("tail", seconds, TAIL)))

    def velocity_displacement(self) -> tuple[Samples, Samples]:
        """Ground velocity [m/s] and displacement [m] from rest, by the trapezoidal rule, shape (n,)."""
        return velocity_displacement(self.acceleration, self.dt)

    def after(self, done: Done) -> Motion:
        """The motion with the samples of a step, its sentence and its doubts."""
        factor = self.record.get("factor", 1.0) * done.factor
        record = {**self.record, "factor": factor} if done.factor != 1.0 else self.record
        changed = replace(
            self,
            acceleration=done.samples,
            record=_later(record, done.cut * self.dt),
            processing=(*self.processing, *([done.sentence] if done.sentence else [])),
        )
        return changed.doubted(done.flags)

    def doubted(self, flags: Sequence[str]) -> Motion:
        """The motion with further doubts, each told once."""
        return replace(self, flags=tuple(dict.fromkeys((*self.flags, *flags))))


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
    leaves a processed one as it is; "none" leaves both; a list of tables names the steps
    (`pounding_risk.motions.processing.chain`).
    After that come ``window`` (start, end) [s], ``polarity`` ("as recorded" or "reversed"), one of ``pga`` [m/s²]
    and ``scale`` (factor), and ``tail`` [s] of zeros. Numbers are SI; text has its unit ("6 s", "0.5 g").

    Raises RecordError for what cannot be read or trusted, with the repair.
    """
    how = _treatment(window=window, pga=pga, scale=scale, polarity=polarity, tail=tail)
    opened = open_source(source, unit=unit, dt=None if dt is None else asked("dt", dt, STEP))
    return treated([processed(opened, processing)], how)[0]


def processed(source: Source, processing: str | Sequence[Mapping[str, Any]] = "auto") -> Motion:
    """A record after the steps of ``processing``, as in `read_motion`, before window, polarity, amplitude and tail."""
    chain = _chain(processing, source.record["state"])
    log = _Log(source)
    check_shaking(log.samples, source.name, "its sensitivity and unit, or leave the record out")
    _process(log, chain)
    # A window comes after the chain and not before: the offset is seen in the quiet before the earthquake
    # and the drift at its end, and a filter rings where a record is cut in mid-shaking. A cut that is to come
    # earlier, such as one of two earthquakes in a file, is a step of the chain.
    record = {**source.record, "polarity": AS_RECORDED, "factor": log.factor}
    record = _later(record, log.start) | log.corners()
    return Motion(str(record["id"]), log.samples, log.dt, record, tuple(log.sentences)).doubted(log.flags)


def read_trace(
    source: str | Path | Trace, *, unit: str | None = None, dt: float | str | None = None, **choices: Any
) -> Trace:
    """As `read_motion`, as an ObsPy trace in m/s² whose ``stats.processing`` has the history."""
    opened = open_source(source, unit=unit, dt=None if dt is None else asked("dt", dt, STEP))
    motion = read_motion(opened, **choices)
    trace = opened.trace.copy()  # the one that was handed over stays as it was
    trace.data = np.array(motion.acceleration)
    if trace.stats.delta != motion.dt:
        trace.stats.delta = motion.dt
    trace.stats.starttime += motion.record.get("cut_from_start", 0.0)
    trace.stats.processing = list(motion.processing)
    return trace


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


def _treatment(
    *,
    window: tuple[float | str, float | str] | None,
    pga: float | str | None,
    scale: float | str | None,
    polarity: str,
    tail: float | str,
) -> Treatment:
    """What `read_motion` is asked to do after the processing, in SI; raises RecordError for what it cannot do."""
    given = [key for key, value in (("pga", pga), ("scale", scale)) if value is not None]
    for _, sentence in conflicts(given):
        raise RecordError(sentence)
    if polarity not in (AS_RECORDED, REVERSED):
        raise RecordError(f'polarity: {shown(polarity)} is not one; it may be "{AS_RECORDED}" or "{REVERSED}"')
    return Treatment(
        window=None if window is None else _span(window),
        polarity=polarity,
        pga=None if pga is None else asked("pga", pga, PGA),
        scale=None if scale is None else asked("scale", scale, SCALE),
        tail=asked("tail", tail, TAIL),
    )


def _later(record: dict[str, Any], seconds: float) -> dict[str, Any]:
    """The facts of a record of which so much was cut from the start."""
    if not seconds:
        return record
    record = {**record, "cut_from_start": record.get("cut_from_start", 0.0) + seconds}
    if record.get("start"):
        record["start"] = (datetime.fromisoformat(record["start"]) + timedelta(seconds=seconds)).isoformat()
    return record


class _Log:
    """Samples on their way through the steps, with the sentence and the doubts of each."""

    def __init__(self, found: Source):
        self.samples: Samples = np.array(found.trace.data, dtype=np.float64)
        self.dt = float(found.trace.stats.delta)
        self.start = 0.0
        self.flags = [*found.doubts, *unit_doubts(found.record["pga_recorded"], "as recorded")]
        self.factor, self.band = 1.0, (0.0, inf)
        self.raw = found.record["state"] == RAW
        self._record = found.record
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
