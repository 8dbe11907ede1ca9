"""Laboratory motions: a harmonic, a swept sine, a constant acceleration, still ground."""

from __future__ import annotations

from math import inf, isclose, log, pi, radians

import numpy as np

from pounding_risk.motions.generated import Option, Unfit, Wave, motion_kind
from pounding_risk.motions.processing.signals import Samples, cosine_rise
from pounding_risk.units import PGA, Quantity

PERIOD = Quantity("s", 0.0, 1000.0, "period", open_low=True, example="0.5 s")
CYCLES = Quantity("1", 0.0, 1e5, "number of cycles", open_low=True, example="10")
RISE = Quantity("s", 0.0, inf, "duration of a rise", open_high=True, example="1 s")
PHASE = Quantity("deg", -360.0, 360.0, "phase", example="0 deg")
FREQUENCY = Quantity("Hz", 0.0, 1000.0, "frequency", open_low=True, example="1 Hz")
DURATION = Quantity("s", 0.0, 1e5, "duration", open_low=True, example="10 s")
AMPLITUDE = PGA._replace(words="amplitude of the acceleration", example="0.3 g")


@motion_kind(
    "harmonic",
    amplitude=("pga",),
    named_by=("period",),
    pga=Option("Amplitude of the acceleration.", AMPLITUDE),
    period=Option("Period.", PERIOD),
    cycles=Option("How many periods it lasts.", CYCLES, 10.0),
    rise=Option("Duration over which the amplitude rises at the start, and falls at the end.", RISE, 0.0),
    phase=Option("Phase at the start; any but 0 deg and 180 deg starts with a jump without a rise.", PHASE, 0.0),
)
def harmonic(*, pga: float, period: float, cycles: float, rise: float, phase: float) -> Wave:
    """A sine with a whole or broken number of periods, with half a cosine as optional rise and fall.

        a(t) = pga w(t) sin(2π t/period + phase), 0 ≤ t ≤ cycles · period

    w is 1 but for the rise and the fall. Without them, phase 0 and whole periods, the ground ends at rest at the
    displacement pga period² cycles / 2π. Between samples the wave is a straight line, which carries
    sinc²(π step/period) of the amplitude: 1 − (2π step/period)²/12.
    """
    duration = cycles * period
    _check_rise(rise, duration)
    start = radians(phase)
    return Wave(
        lambda times: pga * _rise_and_fall(times, rise, duration) * np.sin(2.0 * pi * times / period + start),
        duration,
        period,
        _corners(rise, duration),
    )


@motion_kind(
    "swept_sine",
    amplitude=("pga",),
    named_by=("start", "end"),
    pga=Option("Amplitude of the acceleration.", AMPLITUDE),
    start=Option("Frequency at the start.", FREQUENCY._replace(example="0.5 Hz")),
    end=Option("Frequency at the end, above or below that of the start.", FREQUENCY._replace(example="10 Hz")),
    duration=Option("Its length.", DURATION._replace(example="60 s")),
    sweep=Option(
        "Frequency linear in time, or exponential: the same time in every octave.",
        ("linear", "exponential"),
        "exponential",
    ),
    rise=Option(
        "Duration over which the amplitude rises at the start, and falls at the end.",
        RISE,
        None,
        "one period of the lower frequency, at most a quarter of the duration",
    ),
)
def swept_sine(*, pga: float, start: float, end: float, duration: float, sweep: str, rise: float | None) -> Wave:
    """A sine whose frequency goes from one value to another, with half a cosine as rise and fall.

        a(t) = pga w(t) sin φ(t)
        linear:       φ = 2π (start t + (end − start) t² / (2 duration))
        exponential:  φ = 2π start duration (r^(t/duration) − 1) / ln r,  r = end / start

    The exponential sweep passes through each octave in the same time, as tests by IEC 60068-2-6 do; its phase is that
    of Farina (2000), 108th AES Convention, paper 5093.
    """
    if isclose(start, end, rel_tol=1e-9):
        raise Unfit("end", f'{end:g} Hz is the frequency of the start; write another one, or kind = "harmonic"')
    rise = min(1.0 / min(start, end), 0.25 * duration) if rise is None else rise
    _check_rise(rise, duration)
    ratio = end / start

    def cycles(times: Samples) -> Samples:
        if sweep == "linear":
            return start * times + (end - start) * times**2 / (2.0 * duration)
        return start * duration * np.expm1(log(ratio) * times / duration) / log(ratio)

    return Wave(
        lambda times: pga * _rise_and_fall(times, rise, duration) * np.sin(2.0 * pi * cycles(times)),
        duration,
        1.0 / max(start, end),
        _corners(rise, duration),
    )


@motion_kind(
    "constant_acceleration",
    amplitude=("pga",),
    named_by=("duration",),
    pga=Option("The acceleration.", AMPLITUDE),
    duration=Option("Its length, rise and fall included.", DURATION._replace(example="2 s")),
    rise=Option(
        "Duration of the straight rise at the start, and of the fall at the end; 0 s for a jump.",
        RISE._replace(example="0.1 s"),
        None,
        "a tenth of the duration",
    ),
)
def constant_acceleration(*, pga: float, duration: float, rise: float | None) -> Wave:
    """A constant acceleration between a straight rise and a straight fall.

    The ground ends at the velocity pga (duration − rise), and goes on with it. Straight lines carry it exactly. With a
    rise of 0 s it jumps on ground at rest, which is exact too, and ends within one step.
    """
    rise = 0.1 * duration if rise is None else rise
    _check_rise(rise, duration)

    def acceleration(times: Samples) -> Samples:
        if rise == 0.0:
            return np.full_like(times, pga)
        sides: Samples = np.minimum(times, duration - times) / rise
        return pga * np.clip(sides, 0.0, 1.0)

    return Wave(acceleration, duration, 2.0 * rise or duration, _corners(rise, duration))


@motion_kind(
    "still", amplitude=(), named_by=("duration",), duration=Option("Its length.", DURATION._replace(example="10 s"))
)
def still(*, duration: float) -> Wave:
    """Ground that does not move, for buildings that begin displaced or moving."""
    return Wave(np.zeros_like, duration, inf)


def _rise_and_fall(times: Samples, rise: float, duration: float) -> Samples:
    """Half a cosine from 0 to 1 over ``rise``, 1, and back."""
    if rise == 0.0:
        return np.ones_like(times)
    return cosine_rise(times / rise) * cosine_rise((duration - times) / rise)


def _corners(rise: float, duration: float) -> tuple[float, ...]:
    return (rise, duration - rise) if 0.0 < rise < 0.5 * duration else (rise,) if rise else ()


def _check_rise(rise: float, duration: float) -> None:
    if rise > 0.5 * duration * (1.0 + 1e-9):
        raise Unfit(
            "rise",
            f"{rise:g} s of rise and as much of fall do not fit into {duration:g} s; write at most "
            f"{0.5 * duration:g} s",
        )
