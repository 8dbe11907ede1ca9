"""Steps that cut, level, taper, resample and correct the baseline; see `pounding_risk.motions.processing`."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor, inf
from typing import NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import DRIFT_OF_PEAK, ORDER, Done, signals, step, whole
from pounding_risk.units import TIME, Quantity

PRE_EVENT, WHOLE = "pre-event", "whole"
SHORTEST_PRE_EVENT = 1.0  # s: a mean over less says little about the baseline
LONGEST_LEAD, LONGEST_TAIL = 1.0, 5.0  # s of taper
STEP = Quantity("s", 0.0, inf, "time step", open_low=True, open_high=True, example="0.005 s")
LINEAR, FOURIER = "linear", "fourier"
FINE = 0.005  # s: a tenth of the period of a building of 0.05 s
LARGEST_RATIO = 1000  # of whole numbers in dt over dt
NYQUIST_SHARE, STEEPNESS = 0.8, 20.0  # anti-alias corner over the new Nyquist frequency, order
CHANGE_OF_PEAK = 0.02
MOST = 20_000_000  # samples: 160 MB, some hours at 1 kHz
POLYNOMIAL, BILINEAR = "polynomial", "bilinear"
STRONG = (0.05, 0.95)  # of the energy: between them the shaking is strong, and shifts a baseline
SETTLING = 0.5  # of the earthquake's length up to 95 % of its energy, after that: then its waves have passed
SHORTEST_END = 10.0  # s after that from which an offset is read


@step("window", start=TIME, end=TIME)
def window(samples: signals.Samples, dt: float, *, start: float = 0.0, end: float = inf) -> Done:
    """Keep the samples from ``start`` to ``end`` [s], both included where they fall on a sample."""
    last = (len(samples) - 1) * dt
    if end <= start:
        raise RecordError(f"the window {start:g} s to {end:g} s is empty; write a start before the end")
    if start >= last:
        raise RecordError(f"the window starts at {start:g} s, the record ends at {last:g} s; write a start before that")
    first = ceil(start / dt - 1e-6)
    stop = min(len(samples), floor(min(end, last) / dt + 1e-6) + 1)
    if stop - first < 2:
        raise RecordError(
            f"the window {start:g} s to {end:g} s has fewer than 2 samples, {dt:g} s apart; write a later end"
        )
    flags: tuple[str, ...] = ()
    if last + dt / 2 < end < inf:
        flags = (f"the requested window ends at {end:g} s, the record already at {last:g} s",)
    sentence = f"window: kept {first * dt:g} s to {(stop - 1) * dt:g} s ({stop - first} samples)"
    return Done(samples[first:stop].copy(), sentence, flags, first)


@step("mean", of=(PRE_EVENT, WHOLE))
def mean(samples: signals.Samples, dt: float, *, of: str = PRE_EVENT) -> Done:
    """Subtract the mean before the earthquake arrives, or of the whole record.

    The first is the instrument's offset; it falls back to the second, flagged, without a second of quiet.
    """
    quiet = signals.quiet_before(samples, dt)
    flags: tuple[str, ...] = ()
    quiet_part, words = samples, "the whole record"
    if of == PRE_EVENT and quiet >= SHORTEST_PRE_EVENT:
        quiet_part, words = samples[: round(quiet / dt)], f"the {quiet:.2f} s before the earthquake arrives"
    elif of == PRE_EVENT:
        flags = ("less than 1 s before the earthquake arrives: the mean of the whole record was taken",)
    offset = float(quiet_part.mean())
    return Done(samples - offset, f"mean: subtracted {offset:.6g} m/s², the mean of {words}", flags)


@step("trend", order=ORDER)
def trend(samples: signals.Samples, dt: float, *, order: float = 1) -> Done:
    """Subtract the polynomial that fits the acceleration best (least squares): by default a straight line.

    It is fitted as a sum of Legendre polynomials over the record's length, which keeps order 20 as well-conditioned
    as a line.
    """
    degree = whole(order, "a trend", 1)
    position = np.linspace(-1.0, 1.0, len(samples))
    shapes = np.polynomial.legendre.legvander(position, degree)
    fit = np.linalg.lstsq(shapes, samples, rcond=None)[0]
    if degree > 1:
        return Done(samples - shapes @ fit, f"trend: subtracted a polynomial of order {degree} in acceleration")
    rate = 2.0 * float(fit[1]) / ((len(samples) - 1) * dt)
    return Done(samples - shapes @ fit, f"trend: subtracted a straight line of {rate:.6g} m/s² per s")


@step("taper", lead=TIME, tail=TIME)
def taper(samples: signals.Samples, dt: float, *, lead: float | None = None, tail: float | None = None) -> Done:
    """Bring both ends to zero by half a cosine wave of ``lead`` and ``tail`` [s].

    By time and not by a percentage, which would reach into the shaking of a record that starts late (5 % of
    RSN6-180 hides its peak). The lead stays within the quiet before the earthquake: half of it and at most
    1 s, none where it is shorter than a second; the tail is 5 s, or a tenth of a short record.
    """
    duration = (len(samples) - 1) * dt
    if lead is None:
        quiet = signals.quiet_before(samples, dt)
        lead = min(LONGEST_LEAD, quiet / 2) if quiet >= SHORTEST_PRE_EVENT else 0.0
    if tail is None:
        tail = min(LONGEST_TAIL, duration / 10)
    if lead + tail > duration:
        raise RecordError(
            f"a taper of {lead:g} s and {tail:g} s does not fit a record of {duration:g} s; write shorter"
        )
    time = np.arange(len(samples)) * dt
    weight = np.ones(len(samples))
    if lead > 0.0:
        weight *= signals.cosine_rise(time / lead)
    if tail > 0.0:
        weight *= signals.cosine_rise((duration - time) / tail)
    return Done(samples * weight, f"taper: cosine, first {lead:.3g} s and last {tail:.3g} s")


@step("resample", dt=STEP, method=(LINEAR, FOURIER))
def resample(samples: signals.Samples, dt_before: float, *, dt: float = FINE, method: str = LINEAR) -> Done:
    """Resample the motion to every ``dt`` [s], with an anti-alias filter for a longer step.

    "linear" draws straight lines, which is what a run assumes between samples: PGA stays, and every old sample where
    ``dt`` divides the old step. "fourier" is the band-limited motion through the samples, zeros put on its spectrum
    (Phillips et al. 2012); its peaks lie between samples, so PGA may grow. To a coarser ``dt`` an acausal Butterworth
    low-pass of order 20 at 0.8 of the new Nyquist frequency comes before either. A change of PGA of more than 2 % is
    flagged, as a PGA scaled to multiplies it in.

    Raises RecordError where fewer than two samples are left, and, for "fourier", where the steps have no whole ratio.
    """
    count = int((len(samples) - 1) * dt_before / dt * (1.0 + 1e-12) + 1e-9) + 1
    if count < 2:
        duration = (len(samples) - 1) * dt_before
        raise RecordError(
            f"a time step of {dt:g} s leaves one sample of a record of {duration:g} s; write a shorter one"
        )
    if count > MOST:
        raise RecordError(f"a time step of {dt:g} s makes {count} samples, {MOST} are allowed; write a longer one")
    coarser = dt > dt_before * (1.0 + 1e-9)
    corner = NYQUIST_SHARE * 0.5 / dt
    source = _low_pass(samples, dt_before, corner) if coarser else samples
    if method == FOURIER:
        resampled = _band_limited(source, dt_before, dt)[:count]
    else:
        # In units of the old step, so that old samples fall on whole numbers and come out as they were.
        times = np.arange(count) * (dt / dt_before)
        near = np.round(times)
        times = np.where(np.abs(times - near) < 1e-9 * np.maximum(near, 1.0), near, times)
        resampled = np.interp(times, np.arange(len(source)), source)
    words = f"resample: from {dt_before:g} s to {dt:g} s, {method}"
    if coarser:
        words += f", after an acausal low-pass at {corner:g} Hz"
    old, new = float(np.abs(samples).max()), float(np.abs(resampled).max())
    flags = []
    if old > 0.0 and abs(new / old - 1.0) > CHANGE_OF_PEAK:
        flags.append(f"resampling changed PGA by {100.0 * (new / old - 1.0):+.1f} %")
    return Done(resampled, words, tuple(flags), dt=dt)


def _low_pass(samples: signals.Samples, dt: float, corner: float) -> signals.Samples:
    """The samples through a Butterworth low-pass without phase, padded so that the ends do not wrap round."""
    size = 1 << (len(samples) + ceil(2.0 * STEEPNESS / corner / dt)).bit_length()
    gain = signals.butterworth(np.fft.rfftfreq(size, dt), 0.0, corner, STEEPNESS)
    return np.fft.irfft(np.fft.rfft(samples, size) * gain, size)[: len(samples)]


def _band_limited(samples: signals.Samples, before: float, after: float) -> signals.Samples:
    """The band-limited motion at a time step in a ratio of whole numbers to the old one."""
    ratio = Fraction(before / after).limit_denominator(LARGEST_RATIO)
    if ratio == 0 or abs(float(ratio) * after / before - 1.0) > 1e-9:
        raise RecordError(
            f"the time steps {before:g} and {after:g} s are in no ratio of whole numbers up to {LARGEST_RATIO}; "
            'write one that is, or method = "linear"'
        )
    return signals.band_limited(samples, ratio.numerator, ratio.denominator)


@step("baseline", scheme=(POLYNOMIAL, BILINEAR), order=ORDER, start=TIME, end=TIME)
def baseline(
    samples: signals.Samples,
    dt: float,
    *,
    scheme: str = POLYNOMIAL,
    order: float | None = None,
    start: float | None = None,
    end: float | None = None,
) -> Done:
    """Correct the baseline, which makes velocity and displacement drift.

    "polynomial": the second derivative of a polynomial of ``order`` (6) fitted to the displacement. Its constant and
    linear coefficients are zero, so the motion still starts from rest (PEER NGA-West2, Ancheta et al. 2013). Time runs
    from 0 to 1 in the fit, which keeps it well-conditioned. It comes after a band-pass, and leaves no permanent
    displacement.

    "bilinear": offsets in acceleration, for a raw record less its mean before the earthquake, in place of the
    band-pass's lower corner. A line v = v0 + a_f t is fitted to the velocity of the quiet end. Without times the
    offset a_f is subtracted from where that line is zero (Boore 2001), without free parameters. With ``start`` and
    ``end`` [s], t1 and t2, or where the line has no zero in the shaking, a_m = (v0 + a_f t2)/(t2 - t1) is subtracted
    between them and a_f from t2 on, so that velocity stays continuous (Iwan et al. 1985); t1 and t2 are the times of
    5 % and 95 % of the energy unless given. A permanent displacement stays and is reported, with the value that
    another choice of times gives, as it depends on them (Boore 2001).

    Velocity that does not come to rest is flagged, displacement only for a polynomial. Raises RecordError for options
    of the other scheme, times that do not rise, and less than 10 s of quiet at the end to read an offset from.
    """
    if scheme == BILINEAR:
        if order is not None:
            raise RecordError('order is one of a polynomial; leave it out, or write scheme = "polynomial"')
        return _bilinear(samples, dt, (start, end))
    if start is not None or end is not None:
        raise RecordError('start and end are times of offsets; leave them out, or write scheme = "bilinear"')
    degree = whole(6 if order is None else order, "a baseline", 2)
    duration = (len(samples) - 1) * dt
    share = np.linspace(0.0, 1.0, len(samples))
    powers = np.arange(2, degree + 1)
    _, displacement = signals.velocity_displacement(samples, dt)
    fit = np.linalg.lstsq(share[:, None] ** powers, displacement, rcond=None)[0]
    bend = (share[:, None] ** (powers - 2)) @ (fit * powers * (powers - 1)) / duration**2
    corrected = samples - bend
    sentence = f"baseline: subtracted the second derivative of an order-{degree} polynomial in displacement"
    words, flags = _ends(corrected, dt, ("velocity", "displacement"))
    return Done(corrected, f"{sentence}; {words}", flags)


class _Shaking(NamedTuple):
    """Times [s] of the arrival, of 5 and 95 % of the energy, and of the end of the waves."""

    arrival: float
    strong: tuple[float, float]
    quiet_from: float


class _Line(NamedTuple):
    """Velocity of the quiet end: ``speed`` [m/s] at time zero and ``slope`` [m/s²], the offset after the shaking."""

    speed: float
    slope: float

    def at(self, time: float) -> float:
        return self.speed + self.slope * time


def _bilinear(samples: signals.Samples, dt: float, asked: tuple[float | None, float | None]) -> Done:
    shaking = _shaking(samples, dt, asked[1])
    line = _line(samples, dt, shaking.quiet_from)
    zero = -line.speed / line.slope if line.slope else -1.0
    if asked == (None, None) and shaking.arrival <= zero <= shaking.quiet_from:
        corrected = samples - line.slope * _unit_step(len(samples), dt, zero)
        words = f"offset of {line.slope:.4g} m/s² subtracted from {zero:.4g} s on"
        others = shaking.strong
    else:
        start, end = (usual if time is None else time for time, usual in zip(asked, shaking.strong, strict=True))
        if end <= start:
            raise RecordError(
                f"offsets from {start:.4g} s to {end:.4g} s: the times do not rise; write an end after the start"
            )
        times = (start, end)
        corrected = samples - _offsets(len(samples), dt, line, times)
        middle = line.at(times[1]) / (times[1] - times[0])
        words = f"offsets of {middle:.4g} m/s² from {times[0]:.4g} to {times[1]:.4g} s and {line.slope:.4g} after"
        others = (shaking.arrival, shaking.quiet_from)
    instead = samples - _offsets(len(samples), dt, line, others)
    quiet_end = slice(round(shaking.quiet_from / dt), None)
    displacement, otherwise = (
        100.0 * float(signals.velocity_displacement(trace, dt)[1][quiet_end].mean()) for trace in (corrected, instead)
    )
    other_words = f"{otherwise:.3g} cm with offsets from {others[0]:.4g} and {others[1]:.4g} s on"
    permanent = f"permanent displacement {displacement:.3g} cm ({other_words})"
    ends, flags = _ends(corrected, dt, ("velocity",))
    fitted = f"fitted to the velocity after {shaking.quiet_from:.4g} s"
    return Done(corrected, f"baseline: bilinear, {words}, {fitted}; {permanent}; {ends}", flags)


def _shaking(samples: signals.Samples, dt: float, end: float | None) -> _Shaking:
    """The times of the shaking; the quiet end begins after the ``end`` of the offsets where that is given."""
    arrival = signals.quiet_before(samples, dt)
    first, last = (signals.energy_time(samples, dt, share) for share in STRONG)
    if not arrival < last > first:
        raise RecordError('the record has no shaking in which its baseline could shift; write scheme = "polynomial"')
    quiet_from = max(last + SETTLING * (last - arrival), end or 0.0)
    quiet = (len(samples) - 1) * dt - quiet_from
    if quiet < SHORTEST_END:
        raise RecordError(
            f"the bilinear scheme reads the offset from {SHORTEST_END:g} s or more of quiet after the shaking, the "
            f'record ends {max(quiet, 0.0):.3g} s after it; take a longer record, or scheme = "polynomial"'
        )
    return _Shaking(arrival, (first, last), quiet_from)


def _line(samples: signals.Samples, dt: float, quiet_from: float) -> _Line:
    """The line through the velocity from ``quiet_from`` [s] to the end (least squares, about its middle)."""
    velocity = signals.velocity_displacement(samples, dt)[0][round(quiet_from / dt) :]
    time = np.arange(len(samples))[round(quiet_from / dt) :] * dt
    middle = float(time.mean())
    slope = float((time - middle) @ velocity / ((time - middle) @ (time - middle)))
    return _Line(float(velocity.mean()) - slope * middle, slope)


def _offsets(count: int, dt: float, line: _Line, times: tuple[float, float]) -> signals.Samples:
    """The offsets [m/s²]: a_m between the two times and a_f after them."""
    middle = line.at(times[1]) / (times[1] - times[0])
    first, second = (_unit_step(count, dt, time) for time in times)
    return middle * first + (line.slope - middle) * second


def _unit_step(count: int, dt: float, time: float) -> signals.Samples:
    """Zero before ``time`` and one after it, with a ramp of one step so that its integral is exact."""
    return np.clip(np.arange(count) - time / dt + 0.5, 0.0, 1.0)


def _ends(samples: signals.Samples, dt: float, at_rest: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
    """Peaks and last values of velocity and displacement in words; flags for those that do not end at rest."""
    flags, words = [], []
    for name, trace, unit in zip(
        ("velocity", "displacement"), signals.velocity_displacement(samples, dt), ("cm/s", "cm"), strict=True
    ):
        peak, last = 100.0 * float(np.abs(trace).max()), 100.0 * float(trace[-1])
        words.append(f"peak {name} {peak:.4g} {unit}, at the end {last:.3g}")
        if name in at_rest and abs(last) > DRIFT_OF_PEAK * peak:
            share = 100.0 * abs(last) / peak
            flags.append(f"after baseline correction the {name} ends at {share:.0f} % of its peak")
    return ", ".join(words), tuple(flags)
