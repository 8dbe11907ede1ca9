"""Random motions: white noise, and white noise through the filters of Kanai and Tajimi and of Clough and Penzien.

An envelope says how the amplitude grows and decays, by the times at which it does.

The spectral density S₀ of the white noise is two-sided over angular frequency: the variance of a motion is its integral
from −∞ to ∞. One-sided over frequency it is 4π S₀ in (m/s²)²/Hz.

Random numbers are those of PCG64 (O'Neill 2014) through the inverse of the normal distribution: NumPy keeps the stream
of that generator in all versions, but not its normal deviates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import exp, inf, log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.motions.generated import Form, Option, Sampled, Unfit, motion_kind
from pounding_risk.motions.generated._forms import closed, largest_in_g
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
NONE, TRAPEZOID, EXPONENTIAL, GAMMA = "none", "trapezoid", "exponential", "gamma"
_TIME = Quantity("s", 0.0, inf, "time of an envelope", open_low=True, open_high=True, example="2 s")
_LEVEL = Quantity("s", 0.0, inf, "duration of a constant amplitude", open_high=True, example="8 s")
_SHARE = Quantity("1", 0.0, 1.0, "share of the largest amplitude", open_low=True, open_high=True, example="0.01")
# The keys of an envelope, for every kind of noise.
OF_ENVELOPE = {
    "envelope": Option(
        "How the amplitude grows and decays: trapezoid (Jennings, Housner and Tsai), exponential (Shinozuka and Sato), "
        "gamma (Saragoni and Hart), or none.",
        (TRAPEZOID, EXPONENTIAL, GAMMA, NONE),
        TRAPEZOID,
    ),
    "rise": Option("Time at which the envelope reaches 1.", _TIME, None, "a tenth of the duration"),
    "level": Option("How long a trapezoid stays at 1.", _LEVEL, None, "four tenths of the duration"),
    "last": Option("Value of the envelope at the end.", _SHARE, None, "0.01"),
}
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
OF_GROUND: dict[str, Any] = {
    "frequency": Option("f_g: frequency of the ground.", FREQUENCY, 2.5),
    "damping": Option("ζ_g: its damping ratio.", RATIO, 0.6),
}
STRENGTH = ("rms", "psd")


class Envelope(NamedTuple):
    """The factor on stationary noise at times [s] from its start, at most 1, and its parameters in words."""

    at: Callable[[Samples], Samples]
    sentence: str


def read_envelope(
    envelope: str, duration: float, rise: float | None, level: float | None, last: float | None
) -> Envelope:
    """The envelope of these keys.

        trapezoid:    (t/t₁)², 1, exp(−c (t − t₂))          Jennings, Housner and Tsai (1969), 4th WCEE
        exponential:  (exp(−αt) − exp(−βt)) / its maximum   Shinozuka and Sato (1967), J. Eng. Mech. Div. 93(EM1)
        gamma:        (t/t₁)^b exp(b (1 − t/t₁))            Saragoni and Hart (1974), Earthq. Eng. Struct. Dyn. 2

    t₁ is ``rise`` and t₂ − t₁ is ``level`` [s]; c, α and β, and b follow from ``last``, the value at ``duration`` [s].
    Raises Unfit for keys that the envelope does not have, and for times that do not fit.
    """
    times = {"rise": rise, "level": level, "last": last}
    allowed = {NONE: (), TRAPEZOID: tuple(times)}.get(envelope, ("rise", "last"))
    for key, time in times.items():
        if time is not None and key not in allowed:
            raise Unfit(key, f'envelope "{envelope}" has no {key}; remove it, or choose another envelope')
    if envelope == NONE:
        return Envelope(np.ones_like, "envelope: none, stationary from its first sample to its last")
    peak = 0.1 * duration if rise is None else rise
    share = 0.01 if last is None else last
    if peak >= duration:
        raise Unfit("rise", f"{peak:g} s is not within the duration of {duration:g} s; write a shorter one")
    if envelope == TRAPEZOID:
        return _trapezoid(duration, peak, 0.4 * duration if level is None else level, share)
    return _exponential(duration, peak, share) if envelope == EXPONENTIAL else _gamma(duration, peak, share)


def _trapezoid(duration: float, rise: float, level: float, last: float) -> Envelope:
    end = rise + level
    if end >= duration:
        raise Unfit("level", f"{level:g} s after a rise of {rise:g} s leave no decay within {duration:g} s; shorten it")
    rate = -log(last) / (duration - end)

    def at(times: Samples) -> Samples:
        decay = np.exp(-rate * np.maximum(times - end, 0.0))
        return np.minimum(times / rise, 1.0) ** 2 * decay

    return Envelope(at, f"envelope: trapezoid, t₁ {rise:.4g} s, t₂ {end:.4g} s, c {rate:.4g} 1/s")


def _exponential(duration: float, rise: float, last: float) -> Envelope:
    """α and β of the time of the maximum, ln(β/α)/(β − α), and of the value at the end, by their ratio."""
    from scipy.optimize import brentq

    def rates(log_ratio: float) -> tuple[float, float]:
        slow = log_ratio / (rise * np.expm1(log_ratio))
        return slow, slow * exp(log_ratio)

    def shape(times: Samples | float, slow: float, fast: float) -> Samples:
        return np.exp(-slow * np.asarray(times)) * -np.expm1(-(fast - slow) * np.asarray(times))

    def excess(log_ratio: float) -> float:
        slow, fast = rates(log_ratio)
        return float(shape(duration, slow, fast) / shape(rise, slow, fast)) - last

    least = excess(1e-6) + last
    if excess(1e-6) > 0.0:
        raise Unfit(
            "last",
            f"an exponential envelope that reaches 1 at {rise:g} s is at least {least:.3g} after {duration:g} s, not "
            f"{last:g}; write a larger one, or a shorter rise",
        )
    slow, fast = rates(brentq(excess, 1e-6, 700.0, xtol=1e-14, rtol=1e-14))
    top = shape(rise, slow, fast)
    return Envelope(
        lambda times: shape(times, slow, fast) / top, f"envelope: exponential, α {slow:.4g} 1/s, β {fast:.4g} 1/s"
    )


def _gamma(duration: float, rise: float, last: float) -> Envelope:
    power = log(last) / (log(duration / rise) + 1.0 - duration / rise)

    def at(times: Samples) -> Samples:
        ratio = times / rise
        return ratio**power * np.exp(power * (1.0 - ratio))

    return Envelope(at, f"envelope: gamma, b {power:.4g}, c {power / rise:.4g} 1/s")


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
def white_noise(**keys: Any) -> Noise:
    """White noise, limited by its step: independent normal samples, a straight line between each two.

        variance of the samples = 2π S₀ / step
        spectrum of the motion between them = S₀ sinc⁴(ω step/2),  variance 2/3 of that of the samples

    ``psd`` keeps the spectrum whatever the step, ``rms`` the size of the samples. Clough and Penzien (1993), Dynamics
    of Structures.
    """
    return _noise(None, 0.0, **keys)


@motion_kind("kanai_tajimi", amplitude=STRENGTH, random=True, **OF_NOISE, **OF_GROUND)
def kanai_tajimi(*, frequency: float, damping: float, **keys: Any) -> Noise:
    """White noise through a ground layer that vibrates as one mass.

        S(ω) = S₀ (1 + 4ζ²r²) / ((1 − r²)² + 4ζ²r²),   r = f/f_g
        variance = π S₀ ω_g (1 + 4ζ²) / (2ζ)

    It has power down to frequency 0, so that the ground drifts. Firm ground: 2.5 Hz and 0.6. Kanai (1957), Bull.
    Earthq. Res. Inst. 35; Tajimi (1960), 2nd WCEE. Samples follow from the exact solution of the layer between them.
    """
    rate = 2.0 * pi * frequency
    drift = np.array([[0.0, 1.0], [-(rate**2), -2.0 * damping * rate]])
    return _noise(Filter(drift, np.array([0.0, -1.0]), drift[1].copy()), 1.0 / frequency, **keys)


@motion_kind(
    "clough_penzien",
    amplitude=STRENGTH,
    random=True,
    **OF_NOISE,
    **OF_GROUND,
    low_frequency=Option(
        "f_f: frequency below which the second filter cuts.", FREQUENCY._replace(example="0.25 Hz"), 0.25
    ),
    low_damping=Option("ζ_f: its damping ratio.", RATIO, 0.6),
)
def clough_penzien(*, frequency: float, damping: float, low_frequency: float, low_damping: float, **keys: Any) -> Noise:
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
    return _noise(both, 1.0 / frequency, **keys)


def _noise(
    through: Filter | None,
    shortest_period: float,
    *,
    rms: float | None,
    psd: float | None,
    duration: float,
    ends: str,
    **envelope: Any,
) -> Noise:
    """Noise of these keys; raises Unfit where its strength is not given, or twice."""
    if (rms is None) == (psd is None):
        fault = "missing" if rms is None else "rms and psd are both given, and each sets the strength"
        raise Unfit("rms", f'{fault}; write one of rms = "0.1 g" and psd = "0.01 m^2/s^3"')
    shape = read_envelope(duration=duration, **envelope)
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
