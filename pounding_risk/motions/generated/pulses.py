"""Pulses of near-fault motions: Ricker, Gabor, Mavroeidis and Papageorgiou."""

from __future__ import annotations

from math import pi, radians, sqrt

import numpy as np

from pounding_risk.motions.generated import Option, Wave, motion_kind
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import PGA, Quantity

PERIOD = Quantity("s", 0.0, 1000.0, "period of a pulse", open_low=True, example="0.8 s")
WIDTH = Quantity("1", 1.0, 100.0, "width of a pulse", open_low=True, example="2")
PHASE = Quantity("deg", -360.0, 360.0, "phase", example="90 deg")
VELOCITY = Quantity("m/s", 0.0, 100.0, "velocity of a pulse", open_low=True, example="0.8 m/s")
SYMMETRIC = "symmetric"
_VELOCITY = Option("A: the amplitude of the velocity.", VELOCITY)
_PHASE = Option("ν: phase at the middle; 0 deg is symmetric in velocity, 90 deg in displacement.", PHASE, 0.0)


@motion_kind(
    "ricker",
    amplitude=("pga",),
    named_by=("period",),
    pga=Option("Largest acceleration.", PGA._replace(example="0.4 g")),
    period=Option("Period at which its Fourier spectrum is largest.", PERIOD),
    shape=Option(
        "symmetric, the second derivative of a Gaussian, or antisymmetric, the third.",
        (SYMMETRIC, "antisymmetric"),
        SYMMETRIC,
    ),
)
def ricker(*, pga: float, period: float, shape: str) -> Wave:
    """A Ricker wavelet as acceleration: no velocity and no displacement are left.

        symmetric:      a = pga (1 − 2x) exp(−x),            x = (π τ/period)²
        antisymmetric:  a = pga s (s² − 3) exp(−s²/2) / β,   s = 2π τ/(√3 period),  β = 1.3801

    τ is the time from its middle. Ricker (1943), Geophysics 8; as pulses of near-fault motions Vassiliou and Makris
    (2011), Bull. Seismol. Soc. Am. 101. It is cut 1.8 periods from its middle, 2.2 if antisymmetric, where 1e-12 of
    it is left.
    """
    if shape == SYMMETRIC:
        half = 1.8 * period

        def acceleration(times: Samples) -> Samples:
            x = (pi * (times - half) / period) ** 2
            return pga * (1.0 - 2.0 * x) * np.exp(-x)

        return Wave(acceleration, 2.0 * half, period)
    rate = 2.0 * pi / (sqrt(3.0) * period)
    half, peak = 2.2 * period, sqrt(3.0 - sqrt(6.0))  # s of the largest acceleration
    beta = abs(peak * (peak**2 - 3.0)) * float(np.exp(-0.5 * peak**2))

    def antisymmetric(times: Samples) -> Samples:
        s = rate * (times - half)
        return pga / beta * s * (s**2 - 3.0) * np.exp(-0.5 * s**2)

    return Wave(antisymmetric, 2.0 * half, period)


@motion_kind(
    "gabor",
    amplitude=("velocity",),
    named_by=("period",),
    velocity=_VELOCITY,
    period=Option("Period of the wave below the envelope.", PERIOD),
    width=Option("γ: the velocity is A/e at the time γ/ω from the middle.", WIDTH),
    phase=_PHASE,
)
def gabor(*, velocity: float, period: float, width: float, phase: float) -> Wave:
    """A Gabor wavelet as ground velocity: a cosine below a Gaussian. The ground ends at rest.

        v = A exp(−(ωτ/γ)²) cos(ωτ + ν),   ω = 2π/period,   a = dv/dt
        displacement at the end:  A √π (γ/ω) exp(−γ²/4) cos ν

    τ is the time from its middle. Gabor (1946), J. IEE 93; as the pulse from which Mavroeidis and Papageorgiou (2003)
    start. It is cut at |τ| = 0.9 γ period, where its Gaussian is 1e-14.
    """
    rate, nu = 2.0 * pi / period, radians(phase)
    half = 0.9 * width * period

    def acceleration(times: Samples) -> Samples:
        angle = rate * (times - half)
        slope = 2.0 * angle / width**2 * np.cos(angle + nu) + np.sin(angle + nu)
        return -velocity * rate * slope * np.exp(-((angle / width) ** 2))

    return Wave(acceleration, 2.0 * half, period)


@motion_kind(
    "mavroeidis_papageorgiou",
    amplitude=("velocity",),
    named_by=("period",),
    velocity=_VELOCITY,
    period=Option("1/f_p: the prevailing period.", PERIOD),
    width=Option("γ: the length of the pulse in periods.", WIDTH),
    phase=_PHASE,
)
def mavroeidis_papageorgiou(*, velocity: float, period: float, width: float, phase: float) -> Wave:
    """The near-fault velocity pulse of Mavroeidis and Papageorgiou: a cosine below one arch of a cosine.

        v = A/2 (1 + cos(ωτ/γ)) cos(ωτ + ν),   ω = 2π/period,   |τ| ≤ γ period/2,   a = dv/dt
        displacement at the end:  A sin(πγ) cos ν / (ω (1 − γ²))

    τ is the time from its middle. Velocity and acceleration start and end at zero. Mavroeidis and Papageorgiou (2003),
    Bull. Seismol. Soc. Am. 93(3), 1099-1131, with γ from 1 to 3 for records, and A of about 1 m/s.
    """
    rate, nu = 2.0 * pi / period, radians(phase)
    half = 0.5 * width * period

    def acceleration(times: Samples) -> Samples:
        angle = rate * (times - half)
        slope = np.sin(angle / width) * np.cos(angle + nu) / width + (1.0 + np.cos(angle / width)) * np.sin(angle + nu)
        return -0.5 * velocity * rate * slope

    return Wave(acceleration, 2.0 * half, period / (1.0 + 1.0 / width))
