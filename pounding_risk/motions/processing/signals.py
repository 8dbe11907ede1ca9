"""Numerics of a sampled acceleration: integrals, the arrival of an earthquake, a filter's response.

Arrays in, arrays out; the steps of `pounding_risk.motions.processing` put them to use.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.floating[Any]]
# m/s²: strong-motion instruments resolve some 1e-6 m/s² at best (2 g full scale over a dynamic range of 140 to 155 dB).
LEAST_SHAKING = 1e-6
PICK_MARGIN = 0.5  # s before the picked onset: an emergent first arrival starts before it is seen


def velocity_displacement(samples: Samples, dt: float) -> tuple[Samples, Samples]:
    """Velocity [m/s] and displacement [m] from rest, by the trapezoidal rule twice."""
    velocity = _integral(samples, dt)
    return velocity, _integral(velocity, dt)


def onset(samples: Samples, dt: float) -> float:
    """Arrival of the earthquake [s after the first sample], by the Akaike criterion of two noises.

    The samples up to the peak are split where two stationary noises of different variance explain them best:
    least k ln var(a[:k]) + (n - k - 1) ln var(a[k:]) (Maeda 1985). A second pass up to shortly after the
    first split finds the P wave where the first found the S wave. 0 where the record is too short for it.
    """
    end = int(np.argmax(np.abs(samples - samples.mean()))) + 1
    pick = _split(samples[:end])
    pick = _split(samples[: min(end, pick + max(1, round(2.0 / dt)))])
    return pick * dt


def quiet_before(samples: Samples, dt: float) -> float:
    """Time [s] before the arrival of the earthquake, with a margin; 0 where the record starts in motion."""
    return max(0.0, onset(samples, dt) - PICK_MARGIN)


def butterworth(frequency: Samples, low: float, high: float, order: float) -> Samples:
    """Amplitude of a Butterworth high-pass and low-pass in series; a high-pass removes the mean."""
    gain: Samples = 1.0 / np.sqrt(1.0 + (frequency / high) ** (2.0 * order))
    if low > 0.0:
        gain[0] = 0.0
        gain[1:] /= np.sqrt(1.0 + (low / frequency[1:]) ** (2.0 * order))
    return gain


def filtered(samples: Samples, dt: float, corners: tuple[float, float], order: float) -> tuple[Samples, int]:
    """Samples through an acausal Butterworth filter between ``corners`` [Hz], with pads, and the pad's length.

    The pads keep the ends from wrapping round: 0.75 n/low seconds (Converse and Brady 1992), of the upper corner where
    there is no lower one.
    """
    low, high = corners
    pad = ceil(0.75 * order / (low or high) / dt)
    size = 1 << (len(samples) + 2 * pad - 1).bit_length()  # more zeros still, and a fast transform
    gain = butterworth(np.fft.rfftfreq(size, dt), low, high, order)
    passed: Samples = np.fft.irfft(np.fft.rfft(np.pad(samples, pad), size) * gain, size)[: len(samples) + 2 * pad]
    return passed, pad


def band_limited(samples: Samples, numerator: int, denominator: int) -> Samples:
    """Samples at numerator/denominator times the rate, without what the lower rate cannot carry.

    The spectrum is cut off or goes on with zeros. The motion is taken for periodic after a tenth of its length of
    zeros, which come with it.
    """
    blocks = 2 * ceil(1.1 * len(samples) / (2 * denominator))
    size, grown = blocks * denominator, blocks * numerator
    spectrum = np.fft.rfft(samples, size)
    edge = min(size, grown) // 2
    coefficients = np.zeros(grown // 2 + 1, dtype=complex)
    coefficients[: edge + 1] = spectrum[: edge + 1]
    # At the lower Nyquist frequency half of the amplitude belongs to the negative frequency; a coarser sampling
    # has none.
    coefficients[edge] *= 0.5 if grown > size else float(grown == size)
    return np.fft.irfft(coefficients, grown) * (numerator / denominator)


def energy_time(samples: Samples, dt: float, share: float) -> float:
    """Time [s] at which ``share`` of the integral of a² is reached; 0 for samples of zeros."""
    energy = np.cumsum(samples**2)
    return float(np.searchsorted(energy, share * energy[-1])) * dt


def cosine_rise(position: Samples) -> Samples:
    """Half a cosine from 0 at 0 to 1 at 1."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(position, 0.0, 1.0))


def _integral(samples: Samples, dt: float) -> Samples:
    """The integral from zero at the first sample, by the trapezoidal rule."""
    integral = np.zeros(len(samples))
    np.cumsum(0.5 * dt * (samples[1:] + samples[:-1]), out=integral[1:])
    return integral


def _split(samples: Samples) -> int:
    """The number of samples before the change of variance; 0 where there are too few for it."""
    n = len(samples)
    if n < 20:
        return 0
    centred = samples - samples[: n // 10 + 1].mean()
    tiny = np.finfo(float).tiny + 1e-30 * float(np.max(np.abs(centred))) ** 2
    before = np.arange(1, n + 1)
    head, squares = np.cumsum(centred), np.cumsum(centred**2)
    after = np.maximum(n - before, 1)
    var_before = np.maximum(squares / before - (head / before) ** 2, tiny)
    var_after = np.maximum((squares[-1] - squares) / after - ((head[-1] - head) / after) ** 2, tiny)
    criterion = before * np.log(var_before) + (n - before - 1) * np.log(var_after)
    return int(np.argmin(criterion[5:-5])) + 6
