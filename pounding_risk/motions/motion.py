"""Ground motion as a run takes it: acceleration in m/s² at equal steps, with the history of its processing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from hashlib import sha256
from math import ceil, inf
from typing import Any

import numpy as np

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import Done
from pounding_risk.motions.processing.basic import MOST, window
from pounding_risk.motions.processing.signals import Samples, velocity_displacement
from pounding_risk.motions.quality import FIRST_OF_PEAK, LONGEST_STEP
from pounding_risk.motions.record import GENERATED, USABLE, check_samples, lowest_usable
from pounding_risk.motions.request import AS_RECORDED, REVERSED
from pounding_risk.units import PGA, STANDARD_GRAVITY, TAIL, TIME, QuantityError, shown, si

USUAL_FACTORS = (0.25, 4.0)
SCALE_FACTOR = "the scale factor"  # begins the flag of one that is not
LARGEST_PGA, SMALLEST_PGA = 3.0, 0.001  # g; beyond these a unit is likely wrong
ROUNDING = 1e-6  # steps: 5 s may be 1000 + 1e-13 steps of 0.005 s
WEAK_WINDOW = 0.5  # a window with less than this part of the PGA is flagged


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """One component of ground motion, ready to drive a run. It never changes; its methods return new motions.

    Parameters
    ----------
    name : str
        Name, as in results.
    acceleration : array_like, shape (n,)
        Ground acceleration [m/s²], linear between the samples; kept as a read-only array.
    dt : float
        Time step [s].
    record : dict
        Facts of the record: id, event, date, station, component, file, sha256 of the file, origin, terms, state,
        pga_recorded [m/s²], source (what it was read from), factor (what it was scaled by), start (time of the first
        sample, UTC, where known), cut_from_start [s] (where a part before the first sample was cut).
    processing : tuple of str
        One sentence for each step that was applied.
    flags : tuple of str
        One sentence for each doubt.
    own_grounds : tuple of ndarray or None
        By building of a scene, samples at the same times [m/s²] of the record that it stands on in place of this
        motion, None where it stands on this one; empty where all do.
    across : ndarray, optional
        Samples at the same times [m/s²] of the recording across the direction of this motion, 90° anticlockwise from
        it, by the same factor; None where no building of a scene moves across the row.
    tail : int
        Number of samples at the end that are zeros of `with_tail` and `reaching`, which are no part of the record.
    late : int
        Number of these that are zeros of `reaching`.

    Raises
    ------
    RecordError
        For fewer than two samples, samples that are not finite, and a time step that is not above zero.
    """

    name: str
    acceleration: Samples
    dt: float
    record: dict[str, Any]
    processing: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    own_grounds: tuple[Samples | None, ...] = ()
    across: Samples | None = None
    tail: int = 0
    late: int = 0

    def facts(self) -> Iterable[tuple[str, str]]:
        """Where the motion is from, how long and how strong it is, for its display."""
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
        if self.across is not None and self.across.shape != samples.shape:
            raise RecordError(f"{self.name}: its motion across has {self.across.size} samples, along it {samples.size}")

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
        """Times of the samples [s], from zero, shape (n,)."""
        return np.arange(len(self.acceleration)) * self.dt

    @property
    def digest(self) -> str:
        """SHA-256 of what a run takes: every sample [m/s²], then ``dt`` [s], as little-endian numbers of 8 bytes.

        The samples of `own_grounds` follow, each after the number of its building, and those of `across`, after −1.
        The zeros of `reaching`, which follow from the scene, are not counted.
        """
        prompt = self.reaching(0.0)
        beside = [*enumerate(prompt.own_grounds), (-1, prompt.across)]
        more = [np.append(place, samples) for place, samples in beside if samples is not None]
        return sha256(np.concatenate([prompt.acceleration, [self.dt], *more]).astype("<f8").tobytes()).hexdigest()

    @property
    def drive(self) -> Samples:
        """The samples that drive a row [m/s²]: complex, along + i across, where the motion has both."""
        return self.acceleration if self.across is None else self.acceleration + 1j * self.across

    def _beside(self, change: Callable[[Samples], Samples]) -> dict[str, Any]:
        """`own_grounds` and `across`, changed as the motion is."""
        changed = [None if samples is None else change(samples) for samples in (*self.own_grounds, self.across)]
        return {"own_grounds": tuple(changed[:-1]), "across": changed[-1]}

    def reversed(self) -> Motion:
        """The motion with the opposite sign. A pair is not symmetric, so that both polarities are worth a run."""
        now = self.record.get("polarity", AS_RECORDED)
        turned = replace(
            self,
            record={**self.record, "polarity": REVERSED if now == AS_RECORDED else AS_RECORDED},
            **self._beside(np.negative),
        )
        return turned.after(Done(-self.acceleration, "polarity: reversed"))

    def scaled(self, factor: float, aim: str = "") -> Motion:
        """The motion times a factor; ``aim`` says why, for the sentence. Flagged where factor or PGA are unusual."""
        samples = self.acceleration * factor
        pga = float(np.abs(samples).max())
        flags, whole = list(unit_doubts(pga, "after scaling")), self.record.get("factor", 1.0) * factor
        # Of a formula any factor is another amplitude of it, as plausible as the first one.
        is_record = self.record.get("state") != GENERATED
        if is_record and not USUAL_FACTORS[0] <= whole <= USUAL_FACTORS[1]:
            flags.append(f"{SCALE_FACTOR} {whole:.4g} is outside {USUAL_FACTORS[0]:g} to {USUAL_FACTORS[1]:g}")
        peaks = f"from PGA {self.pga / STANDARD_GRAVITY:.5g} g to {pga / STANDARD_GRAVITY:.5g} g"
        words = f"scale: times {factor:.10g}{f' to {aim}' if aim else ''}, {peaks}"
        # One factor may follow another, as a common one the median: the whole is what acts.
        before = replace(self, flags=tuple(flag for flag in self.flags if not flag.startswith(SCALE_FACTOR)))
        return before.after(Done(samples, words, tuple(flags), factor=factor))

    def scaled_to(self, pga: float | str) -> Motion:
        """The motion times one factor, so that max|a| is ``pga`` [m/s², or text such as "0.5 g"]."""
        target = in_si("pga", pga, PGA)
        if self.pga == 0.0:
            raise RecordError(f"{self.name}: every sample is zero, which no factor scales; check record and window")
        scaled = self.scaled(target / self.pga)
        if not abs(scaled.pga - target) <= 1e-12 * target:
            raise RecordError(f"{self.name}: a PGA of {target:g} m/s² is out of reach for samples of {self.pga:g} m/s²")
        return scaled

    def cut(self, start: float | str, end: float | str) -> Motion:
        """The part of the motion from ``start`` to ``end`` [s]; flagged where the strongest shaking is outside it."""
        return self.within(*span_of((start, end))).checked()

    def within(self, start: float, end: float) -> Motion:
        """As `cut`, in seconds, without the flags of `checked`."""
        done = window(self.acceleration, self.dt, start=start, end=end)
        inside = float(np.abs(done.samples).max())
        motion = replace(self, across=None).after(done)
        if self.across is not None:
            motion = replace(motion, across=window(self.across, self.dt, start=start, end=end).samples)
        if inside < WEAK_WINDOW * self.pga:
            share = f"{100.0 * inside / self.pga:.2g} % of the record's"
            motion = motion.doubted((f"the window leaves the strong shaking out: its PGA is {share}",))
        return motion

    def with_tail(self, seconds: float | str) -> Motion:
        """The motion followed by at least that duration [s] of zeros, in which the buildings vibrate freely.

        Whole time steps, after one in which a motion that does not end at zero goes to it on a straight line.
        """
        duration = in_si("tail", seconds, TAIL)
        is_still = not self.acceleration[-1] and (self.across is None or not self.across[-1])
        count, ramp = ceil(duration / self.dt - ROUNDING), not is_still and duration > 0.0
        if count > MOST:
            raise RecordError(
                f"a tail of {duration:g} s makes {count} samples, {MOST} are allowed; write a shorter one"
            )
        straight = f", after a straight line to zero over {self.dt:g} s" if ramp else ""
        words = f"tail: {count * self.dt:g} s of zeros added{straight}"
        longer = replace(self, across=None).after(Done(np.pad(self.acceleration, (0, count + ramp)), words))
        beside = self._beside(lambda samples: np.pad(samples, (0, count + ramp)))
        return replace(longer, **beside, tail=self.tail + count + ramp)

    def reaching(self, lag: float) -> Motion:
        """The motion as buildings need it of which the last is reached ``lag`` [s] after the first.

        Zeros follow it, in whole time steps, until the last building has had all of it; those for another lag go.
        """
        count = max(ceil(lag / self.dt - ROUNDING), 0) - self.late
        if count <= 0:
            return self.first(self.acceleration.size + count) if count else self
        beside = self._beside(lambda samples: np.pad(samples, (0, count)))
        longer = np.pad(self.acceleration, (0, count))
        return replace(self, acceleration=longer, **beside, tail=self.tail + count, late=self.late + count)

    def without_tail(self) -> Motion:
        """The motion without the zeros of `with_tail` and `reaching`."""
        return self.first(self.acceleration.size - self.tail) if self.tail else self

    def velocity_displacement(self) -> tuple[Samples, Samples]:
        """Ground velocity [m/s] and displacement [m] from rest, by the trapezoidal rule, shape (n,)."""
        return velocity_displacement(self.acceleration, self.dt)

    def after(self, done: Done) -> Motion:
        """The motion with the result of a step: its samples, its sentence and its flags.

        Raises RecordError where samples beside it would no longer be at the same times.
        """
        if (self.own_grounds or self.across is not None) and done.samples.size != self.acceleration.size:
            raise RecordError(f"{self.name}: other records stand beside it; cut it before they do")
        record = after_cut(self.record, done.cut * self.dt) | _corners(self.record, *done.band)
        if done.factor != 1.0:
            record["factor"] = self.record.get("factor", 1.0) * done.factor
        sentences = (*self.processing, *([done.sentence] if done.sentence else []))
        dt = self.dt if done.dt is None else done.dt
        beside = self._beside(lambda samples: done.factor * samples) if done.factor != 1.0 else {}
        tail, late = (self.tail, self.late) if done.samples.size == self.acceleration.size else (0, 0)
        return replace(
            self, acceleration=done.samples, dt=dt, record=record, processing=sentences, **beside, tail=tail, late=late
        ).doubted(done.flags)

    def first(self, count: int) -> Motion:
        """Its first samples alone, so many of them."""
        gone = self.acceleration.size - count
        tail, late = max(0, self.tail - gone), max(0, self.late - gone)
        beside = self._beside(lambda samples: samples[:count])
        return replace(self, acceleration=self.acceleration[:count], **beside, tail=tail, late=late)

    def checked(self) -> Motion:
        """The motion with flags about the samples that a run takes: a start in motion, and a long time step."""
        flags, first = [], abs(float(self.acceleration[0]))
        if first > FIRST_OF_PEAK * self.pga:
            share = f"{100.0 * first / self.pga:.1f} %"
            flags.append(f"the motion starts at {share} of its PGA: a late trigger, or a cut in motion")
        if self.dt > LONGEST_STEP:
            flags.append(f"the time step {self.dt:g} s is longer than {LONGEST_STEP:g} s: peaks may be missed")
        return self.doubted(flags)

    def doubted(self, flags: Sequence[str]) -> Motion:
        """The motion with further flags; each sentence stands once."""
        return replace(self, flags=tuple(dict.fromkeys((*self.flags, *flags))))


def after_cut(record: dict[str, Any], seconds: float) -> dict[str, Any]:
    """The facts of a record after so many ``seconds`` were cut from its start, below zero put before it."""
    if not seconds:
        return record
    record = {**record, "cut_from_start": record.get("cut_from_start", 0.0) + seconds}
    if record.get("start"):
        record["start"] = (datetime.fromisoformat(record["start"]) + timedelta(seconds=seconds)).isoformat()
    return record


def seconds_after(first: dict[str, Any], second: dict[str, Any]) -> float:
    """Seconds by which a record begins after another, by their facts; without both starts, by what was cut of each."""
    if first.get("start") and second.get("start"):
        one, other = (datetime.fromisoformat(str(record["start"])) for record in (first, second))
        return (other - one).total_seconds()
    return float(second.get("cut_from_start", 0.0)) - float(first.get("cut_from_start", 0.0))


def _corners(record: dict[str, Any], low: float, high: float) -> dict[str, float]:
    """Corners of a record after a filter of that band [Hz]: the narrower of it and the one it came with."""
    facts = {}
    if low > 0.0:
        low = max(low, record.get("low_corner") or 0.0)
        facts = {"low_corner": low, "lowest_usable_frequency": max(USABLE * low, lowest_usable(record) or 0.0)}
    if high < inf:
        facts["high_corner"] = min(high, record.get("high_corner") or inf)
    return facts


def span_of(window: Any) -> tuple[float, float]:
    """Start and end [s] of a window, numbers or text with a unit; raises RecordError for anything else."""
    if isinstance(window, str) or not isinstance(window, Sequence) or len(window) != 2:
        raise RecordError(f"window: {shown(window)} is not a start and an end; give two times such as (0.0, 6.0)")
    return in_si("window", window[0], TIME), in_si("window", window[1], TIME)


def in_si(key: str, stated: Any, quantity: Any) -> float:
    """A number in SI from a number or from text with a unit; raises RecordError that names ``key``."""
    try:
        return si(stated, quantity)
    except QuantityError as error:
        raise RecordError(f"{key}: {error}") from None


def unit_doubts(pga: float, when: str) -> tuple[str, ...]:
    """A flag for a peak [m/s²] outside the range of earthquakes, for which a unit is likely wrong."""
    in_g = pga / STANDARD_GRAVITY
    if SMALLEST_PGA <= in_g <= LARGEST_PGA:
        return ()
    side = f"above {LARGEST_PGA:g} g" if in_g > LARGEST_PGA else f"below {SMALLEST_PGA:g} g"
    return (f"PGA {when} is {in_g:.3g} g, {side}: check the unit",)
