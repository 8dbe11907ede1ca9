"""Random motions: white noise, and white noise through the filters of Kanai and Tajimi and of Clough and Penzien.

The spectral density S₀ of the white noise is two-sided over angular frequency: the variance of a motion is its integral
from −∞ to ∞. One-sided over frequency it is 4π S₀ in (m/s²)²/Hz.

Random numbers are those of PCG64 (O'Neill 2014) through the inverse of the normal distribution: NumPy keeps the stream
of that generator in all versions, but not its normal deviates.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np

from pounding_risk.motions.generated._envelopes import OF_ENVELOPE, Envelope, read_envelope
from pounding_risk.motions.generated._kind import Form, Option, Sampled, Unfit, closed, largest_in_g, motion_kind
from pounding_risk.motions.processing.signals import Samples, velocity_displacement
from pounding_risk.units import PGA, STANDARD_GRAVITY, Quantity

AS_DRAWN, AT_REST = "as drawn", "at rest"
LEAST_JUMP = 0.02  # of the peak: what an envelope leaves at its end is no jump
STEP = 0.005  # s: that of noise where none is given
FINEST = 50.0  # steps a period of a stiff filter, at least
COARSEST = 10.0
ROUNDING = 1e-15  # of a variance: below it there is none
FREQUENCY = Quantity("Hz", 0.0, 100.0, "frequency of a filter", open_low=True, example="2.5 Hz")
RATIO = Quantity("1", 0.0, 10.0, "damping ratio of a filter", open_low=True, example="0.6")
DURATION = Quantity("s", 0.0, 1e5, "duration", open_low=True, example="20 s")
RMS = PGA._replace(words="root mean square of the acceleration", example="0.1 g")
PSD = Quantity(
    "m^2/s^3", 0.0, 1e6, "two-sided spectral density over angular frequency", open_low=True, example="0.01 m^2/s^3"
)
OF_NOISE: dict[str, Any] = {
    "duration": Option("Its length.", DURATION),
    "rms": Option("Root mean square of the acceleration while the envelope is 1.", RMS, None, "follows from psd"),
    "psd": Option("S₀: spectral density of the white noise, two-sided, per rad/s.", PSD, None, "follows from rms"),
    **OF_ENVELOPE,
    "ends": Option(
        "How the ground ends: as drawn, in motion, or at rest, less a straight line of time times the envelope.",
        (AS_DRAWN, AT_REST),
        AS_DRAWN,
    ),
}
STRENGTH = ("rms", "psd")


@dataclass(frozen=True)
class Filter:
    """A linear filter of white noise without a direct part: dz = A z dt + b dW, a = c z."""

    drift: Samples  # A [1/s], (n, n)
    drive: Samples  # b, (n,)
    output: Samples  # c, (n,)

    def covariance(self) -> Samples:
        """Stationary covariance of the state for S₀ = 1 m²/s³, whose white noise has the intensity 2π."""
        from scipy.linalg import solve_continuous_lyapunov

        return solve_continuous_lyapunov(self.drift, -2.0 * pi * np.outer(self.drive, self.drive))

    def _move(self, time: float) -> Samples:
        """exp(A t): what becomes of a state in this time [s]."""
        from scipy.linalg import expm  # takes longer to import than most scenes to read

        return expm(self.drift * time)

    def variance(self) -> float:
        """Stationary variance of the acceleration for S₀ = 1 m²/s³."""
        return float(self.output @ self.covariance() @ self.output)

    def correlation(self, lag: float) -> float:
        """Correlation of accelerations that are ``lag`` [s] apart."""
        covariance = self.covariance()
        moved = self.output @ self._move(lag) @ covariance @ self.output
        return float(moved / (self.output @ covariance @ self.output))

    def sampled(self, step: float, numbers: Samples) -> Samples:
        """Samples of the stationary acceleration for S₀ = 1 m²/s³, from normal numbers of shape (samples, n).

        State and noise of a step are exact, z(t + h) = exp(A h) z(t) + w with the covariance P − exp(A h) P exp(A h)ᵀ
        of w (Van Loan 1978), so that samples have the covariance of the continuous motion whatever the step.
        """
        covariance = self.covariance()
        size = np.sqrt(np.diag(covariance))  # states of one size, so that none is lost in the rounding of another
        covariance = covariance / np.outer(size, size)
        move = self._move(step) * size / size[:, None]
        spread = _lower(covariance - move @ covariance @ move.T)
        states = numbers @ spread.T
        states[0] = _lower(covariance) @ numbers[0]
        for number in range(1, len(states)):
            states[number] += move @ states[number - 1]
        return states @ (size * self.output)


@dataclass(frozen=True)
class Noise(Form):
    """Noise below an envelope; one of ``rms`` and ``psd`` is given."""

    filter: Filter | None  # what the white noise goes through; None for white noise
    rms: float | None  # m/s²
    psd: float | None  # S₀, m²/s³
    duration: float  # s
    envelope: Envelope  # the factor on it
    ends: str  # `AS_DRAWN` or `AT_REST`
    shortest_period: float = 0.0  # s, of the stiffest filter; 0 without one

    def default_step(self) -> float:
        """`STEP`, or as many as `FINEST` steps in a period of the filter."""
        if not self.shortest_period or self.shortest_period >= FINEST * STEP:
            return STEP
        return float(f"{self.shortest_period / FINEST:.2g}")

    def check(self, step: float) -> None:
        """Raise Unfit for fewer than `COARSEST` steps in a period of the filter."""
        super().check(step)
        if self.duration < 2.0 * step:
            raise Unfit("step", f"{step:g} s leaves no two samples in {self.duration:g} s; write a shorter one")
        if self.shortest_period and step > self.shortest_period / COARSEST * (1.0 + 1e-9):
            raise Unfit(
                "step",
                f"{step:g} s is too long for a filter of {1.0 / self.shortest_period:g} Hz; write "
                f'step = "{self.shortest_period / COARSEST:.3g} s" or less, a tenth of its period, or leave it out',
            )

    def density(self, step: float) -> float:
        """Spectral density S₀ of the white noise [m²/s³] for samples ``step`` [s] apart."""
        return self.rms**2 / self._variance(step) if self.rms is not None else float(self.psd or 0.0)

    def _variance(self, step: float) -> float:
        """Variance for S₀ = 1 m²/s³; of white noise it is that up to the Nyquist frequency, 2π/step."""
        return 2.0 * pi / step if self.filter is None else self.filter.variance()

    def sampled(self, step: float, seed: int) -> Sampled:
        """The samples of a seed."""
        self.check(step)
        times = step * np.arange(round(self.duration / step) + 1)
        shape = self.envelope.at(times)
        if self.filter is None:
            stationary = sqrt(self._variance(step)) * normal_numbers(seed, (len(times),))
        else:
            stationary = self.filter.sampled(step, normal_numbers(seed, (len(times), len(self.filter.drive))))
        samples = sqrt(self.density(step)) * shape * stationary
        sentences = [f"seed {seed}: normal numbers of PCG64", *self._sentences(step)]
        if self.ends == AT_REST:
            line = shape * _line_to_rest(samples, shape, times)
            samples = samples - line
            sentences.append(
                f"ends at rest: less a straight line times the envelope, {largest_in_g(line):.2g} g at most"
            )
        return closed(samples, step, tuple(sentences), least=LEAST_JUMP)

    def _sentences(self, step: float) -> Iterator[str]:
        """Strength, envelope, and what the step leaves of the spectrum."""
        density = self.density(step)
        rms = sqrt(density * self._variance(step)) / STANDARD_GRAVITY
        correlation = 0.0 if self.filter is None else self.filter.correlation(step)
        band = "the samples have the covariance of the continuous motion"
        if self.filter is None:
            white = f"white up to {0.5 / step:g} Hz as samples"
            band = f"{white}, and within 10 % up to {0.125 / step:.3g} Hz between them"
        yield (
            f"S₀ {density:.5g} m²/s³ (two-sided, per rad/s), {4.0 * pi * density:.5g} (m/s²)²/Hz one-sided; rms "
            f"{rms:.4g} g of the samples while the envelope is 1"
        )
        yield self.envelope.sentence
        yield (
            f"step {step:g} s: {band}; straight lines between samples keep "
            f"{100.0 * (2.0 + correlation) / 3.0:.3g} % of the variance"
        )


@motion_kind("white_noise", amplitude=STRENGTH, random=True, **OF_NOISE)
def white_noise(*, rms: float | None, psd: float | None, **keys: Any) -> Noise:
    """White noise, limited by its step: independent normal samples, a straight line between each two.

        variance of the samples = 2π S₀ / step
        spectrum of the motion between them = S₀ sinc⁴(ω step/2),  variance 2/3 of that of the samples

    ``psd`` keeps the spectrum whatever the step, ``rms`` the size of the samples. Clough and Penzien (1993), Dynamics
    of Structures.
    """
    return _noise(None, rms, psd, 0.0, **keys)


@motion_kind(
    "kanai_tajimi",
    amplitude=STRENGTH,
    random=True,
    **OF_NOISE,
    frequency=Option("f_g: frequency of the ground.", FREQUENCY, 2.5),
    damping=Option("ζ_g: its damping ratio.", RATIO, 0.6),
)
def kanai_tajimi(*, rms: float | None, psd: float | None, frequency: float, damping: float, **keys: Any) -> Noise:
    """White noise through a ground layer that vibrates as one mass.

        S(ω) = S₀ (1 + 4ζ²r²) / ((1 − r²)² + 4ζ²r²),   r = f/f_g
        variance = π S₀ ω_g (1 + 4ζ²) / (2ζ)

    It has power down to frequency 0, so that the ground drifts. Firm ground: 2.5 Hz and 0.6. Kanai (1957), Bull.
    Earthq. Res. Inst. 35; Tajimi (1960), 2nd WCEE. Samples follow from the exact solution of the layer between them.
    """
    rate = 2.0 * pi * frequency
    drift = np.array([[0.0, 1.0], [-(rate**2), -2.0 * damping * rate]])
    layer = Filter(drift, np.array([0.0, -1.0]), drift[1].copy())
    return _noise(layer, rms, psd, 1.0 / frequency, **keys)


@motion_kind(
    "clough_penzien",
    amplitude=STRENGTH,
    random=True,
    **OF_NOISE,
    frequency=Option("f_g: frequency of the ground.", FREQUENCY, 2.5),
    damping=Option("ζ_g: its damping ratio.", RATIO, 0.6),
    low_frequency=Option(
        "f_f: frequency below which the second filter cuts.", FREQUENCY._replace(example="0.25 Hz"), 0.25
    ),
    low_damping=Option("ζ_f: its damping ratio.", RATIO, 0.6),
)
def clough_penzien(
    *,
    rms: float | None,
    psd: float | None,
    frequency: float,
    damping: float,
    low_frequency: float,
    low_damping: float,
    **keys: Any,
) -> Noise:
    """Kanai and Tajimi's noise through a second filter, which takes out the lowest frequencies.

        S(ω) = S_KT(ω) r⁴ / ((1 − r²)² + 4ζ_f²r²),   r = f/f_f

    Velocity and displacement of the stationary motion have a finite variance. Clough and Penzien (1975), Dynamics of
    Structures. Samples follow from the exact solution of both filters between them.
    """
    if low_frequency >= frequency:
        raise Unfit(
            "low_frequency", f"{low_frequency:g} Hz is not below frequency, {frequency:g} Hz; write a lower one"
        )
    rate, low = 2.0 * pi * frequency, 2.0 * pi * low_frequency
    layer = [-(rate**2), -2.0 * damping * rate]
    second = [*layer, -(low**2), -2.0 * low_damping * low]
    drift = np.array([[0.0, 1.0, 0.0, 0.0], [*layer, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], second])
    both = Filter(drift, np.array([0.0, -1.0, 0.0, 0.0]), drift[3].copy())
    return _noise(both, rms, psd, 1.0 / frequency, **keys)


def _noise(
    through: Filter | None,
    rms: float | None,
    psd: float | None,
    shortest_period: float,
    *,
    duration: float,
    envelope: str,
    rise: float | None,
    level: float | None,
    last: float | None,
    ends: str,
) -> Noise:
    """Noise of these keys; raises Unfit where its strength is not given, or twice."""
    if (rms is None) == (psd is None):
        fault = "missing" if rms is None else "rms and psd are both given, and each sets the strength"
        raise Unfit("rms", f'{fault}; write one of rms = "0.1 g" and psd = "0.01 m^2/s^3"')
    shape = read_envelope(envelope, duration, rise, level, last)
    return Noise(through, rms, psd, duration, shape, ends, shortest_period)


def _line_to_rest(samples: Samples, shape: Samples, times: Samples) -> Samples:
    """The straight line of time that, times the envelope, has the final velocity and displacement of the samples."""

    def ends(motion: Samples) -> tuple[float, float]:
        velocity, displacement = velocity_displacement(np.append(motion, 0.0), float(times[1]))
        return float(velocity[-1]), float(displacement[-1])

    along = times / times[-1]
    matrix = np.array([ends(shape), ends(shape * along)]).T
    level, slope = np.linalg.solve(matrix, np.array(ends(samples)))
    return level + slope * along


def normal_numbers(seed: int, shape: tuple[int, ...]) -> Samples:
    """Normal numbers of a seed: the upper 53 bits of PCG64 as the middle of equal shares of (0, 1), inverted."""
    from scipy.special import ndtri

    bits = np.random.PCG64(seed).random_raw(int(np.prod(shape))) >> np.uint64(11)
    numbers: Samples = ndtri((bits.astype(np.float64) + 0.5) * 2.0**-53)
    return numbers.reshape(shape)


def _lower(matrix: Samples) -> Samples:
    """A Cholesky factor of a matrix that may be singular; its diagonal is not below 0, so that there is one."""
    size = len(matrix)
    factor = np.zeros((size, size))
    for column in range(size):
        pivot = matrix[column, column] - factor[column] @ factor[column]
        if pivot <= ROUNDING:
            continue
        factor[column, column] = sqrt(pivot)
        for row in range(column + 1, size):
            factor[row, column] = (matrix[row, column] - factor[row] @ factor[column]) / factor[column, column]
    return factor
