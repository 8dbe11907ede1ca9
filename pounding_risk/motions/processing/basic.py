"""Steps that cut, level, taper and resample a record; see `pounding_risk.motions.processing`."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor, inf

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import ORDER, Done, step, whole
from pounding_risk.motions.processing.signals import Samples, band_limited, butterworth, cosine_rise, quiet_before
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


@step("window", start=TIME, end=TIME)
def window(samples: Samples, dt: float, *, start: float = 0.0, end: float = inf) -> Done:
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
def mean(samples: Samples, dt: float, *, of: str = PRE_EVENT) -> Done:
    """Subtract the mean before the earthquake arrives, or of the whole record.

    The first is the instrument's offset; it falls back to the second, flagged, without a second of quiet.
    """
    quiet = quiet_before(samples, dt)
    flags: tuple[str, ...] = ()
    part, words = samples, "the whole record"
    if of == PRE_EVENT and quiet >= SHORTEST_PRE_EVENT:
        part, words = samples[: round(quiet / dt)], f"the {quiet:.2f} s before the earthquake arrives"
    elif of == PRE_EVENT:
        flags = ("less than 1 s before the earthquake arrives: the mean of the whole record was taken",)
    offset = float(part.mean())
    return Done(samples - offset, f"mean: subtracted {offset:.6g} m/s², the mean of {words}", flags)


@step("trend", order=ORDER)
def trend(samples: Samples, dt: float, *, order: float = 1) -> Done:
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
def taper(samples: Samples, dt: float, *, lead: float | None = None, tail: float | None = None) -> Done:
    """Bring both ends to zero by half a cosine wave of ``lead`` and ``tail`` [s].

    By time and not by a percentage, which would reach into the shaking of a record that starts late (5 % of
    RSN6-180 hides its peak). The lead stays within the quiet before the earthquake: half of it and at most
    1 s, none where it is shorter than a second; the tail is 5 s, or a tenth of a short record.
    """
    duration = (len(samples) - 1) * dt
    if lead is None:
        quiet = quiet_before(samples, dt)
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
        weight *= cosine_rise(time / lead)
    if tail > 0.0:
        weight *= cosine_rise((duration - time) / tail)
    return Done(samples * weight, f"taper: cosine, first {lead:.3g} s and last {tail:.3g} s")


@step("resample", dt=STEP, method=(LINEAR, FOURIER))
def resample(samples: Samples, dt_before: float, *, dt: float = FINE, method: str = LINEAR) -> Done:
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


def _low_pass(samples: Samples, dt: float, corner: float) -> Samples:
    """The samples through a Butterworth low-pass without phase, padded so that the ends do not wrap round."""
    size = 1 << (len(samples) + ceil(2.0 * STEEPNESS / corner / dt)).bit_length()
    gain = butterworth(np.fft.rfftfreq(size, dt), 0.0, corner, STEEPNESS)
    return np.fft.irfft(np.fft.rfft(samples, size) * gain, size)[: len(samples)]


def _band_limited(samples: Samples, before: float, after: float) -> Samples:
    """The band-limited motion at a time step in a ratio of whole numbers to the old one."""
    ratio = Fraction(before / after).limit_denominator(LARGEST_RATIO)
    if ratio == 0 or abs(float(ratio) * after / before - 1.0) > 1e-9:
        raise RecordError(
            f"the time steps {before:g} and {after:g} s are in no ratio of whole numbers up to {LARGEST_RATIO}; "
            'write one that is, or method = "linear"'
        )
    return band_limited(samples, ratio.numerator, ratio.denominator)
