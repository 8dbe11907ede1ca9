"""A record at another time step; see `pounding_risk.motions.processing`."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, inf

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import Done, step
from pounding_risk.motions.processing.signals import Samples, band_limited, butterworth
from pounding_risk.units import Quantity

STEP = Quantity("s", 0.0, inf, "time step", open_low=True, open_high=True, example="0.005 s")
LINEAR, FOURIER = "linear", "fourier"
FINE = 0.005  # s: a tenth of the period of a building of 0.05 s
LARGEST_RATIO = 1000  # of whole numbers in dt over dt
NYQUIST_SHARE, STEEPNESS = 0.8, 20.0  # anti-alias corner over the new Nyquist frequency, order
CHANGE_OF_PEAK = 0.02
MOST = 20_000_000  # samples: 160 MB, some hours at 1 kHz


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
