"""Exact damping relations: the same contact laws, each with the damping that returns the e asked for.

The published ξ(e) are approximations, or belong to a law that may pull. The exact form of a law is the published law
with another ``begin`` and nothing else, so that the choice is made when a kernel is compiled.

One relation serves three laws. In x = δ^(5/4) the approach under Jankowski's law,
m v dv/dδ = −β δ^1.5 − 2 ξ sqrt(β m) δ^(1/4) v, is v dv/dx = −0.8 (β/m) x − 1.6 ξ sqrt(β/m) v: the linear
oscillator of ratio ζ = sqrt(0.8) ξ, whose elastic energy at the turn is the same share of the approach's.
Kelvin-Voigt without tension loses as much again on its way out as on its way in, so that its e is the square.

The bilinear law has no damper: there the loop is what follows from e, and a loop takes only so much.
"""

from __future__ import annotations

from math import atan2, log, pi, sqrt

from pounding_risk._jit.compile import small


@small
def speed_lost(ratio):
    """−ln e of x'' + 2 ζ x' + x = 0, damped until it turns and elastic after: (ζ/s) atan2(s, ζ), s = sqrt(1 − ζ²).

    (ζ/s) ln(ζ + s), s = sqrt(ζ² − 1), where ζ > 1; a series in q = 1/ζ² − 1 where the two meet, good to 1e-12.
    """
    room = (1.0 - ratio) * (1.0 + ratio)
    if abs(room) < 1e-4:
        q = room / (ratio * ratio)
        return 1.0 - q * (1.0 / 3.0 - q / 5.0)
    s = sqrt(abs(room))
    return ratio / s * (atan2(s, ratio) if room > 0.0 else log(ratio + s))


@small
def approach_ratio(e):
    """The ζ on [0, inf) with exp[−(ζ/s) atan2(s, ζ)] = e, for e in (0, 1]: that of `speed_lost`.

    Newton's rule from the published approximation, whose e is within 0.007: four rounds at most are needed.
    """
    if e >= 1.0:
        return 0.0
    goal = -log(e)
    ratio = (1.0 - e * e) / (e * (e * (pi - 2.0) + 2.0))
    for _ in range(20):
        room = (1.0 - ratio) * (1.0 + ratio)
        lost = speed_lost(ratio)
        slope = (lost - ratio * ratio) / (ratio * room) if abs(room) >= 1e-4 else 2.0 / 3.0
        change = (goal - lost) / slope
        ratio += change
        if abs(change) <= 1e-9 * ratio:
            break
    return ratio


def positive_root(square: float, half: float, constant: float) -> float:
    """The positive root e of square e² + 2 half e − constant = 0, without a difference of like numbers."""
    return constant / (half + sqrt(half * half + square * constant))
