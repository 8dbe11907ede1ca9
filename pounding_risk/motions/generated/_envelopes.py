"""Envelopes of noise: how its amplitude grows and decays, by the times at which it does."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, log
from typing import NamedTuple

import numpy as np

from pounding_risk.motions.generated._kind import Option, Unfit
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import Quantity

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
    for key, value in times.items():
        if value is not None and key not in allowed:
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
