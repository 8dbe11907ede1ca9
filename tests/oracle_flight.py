"""The reference integrator between contacts: closed form, and searches that prove that they miss nothing.

Over one sample a building moves as a + b t + Re(z exp(λ t)). The second derivative of such a curve is bounded
by Σ |λ|²|z|, so a branch-and-bound search finds the first touch and every peak: nothing is missed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import NamedTuple

from oracle_laws import Oscillator
from scipy.optimize import brentq

CONFIRMED = 1e-15  # m: a touch counts once the free motion would press this deep; some ulp of a displacement


class Curve(NamedTuple):
    """f(t) = a + b t + Σ Re(z exp(λ t))."""

    a: float
    b: float
    waves: tuple[tuple[complex, complex], ...]

    def value(self, t: float) -> float:
        return self.a + self.b * t + sum((z * cmath.exp(rate * t)).real for z, rate in self.waves)

    def slope(self, t: float) -> float:
        return self.b + sum((rate * z * cmath.exp(rate * t)).real for z, rate in self.waves)

    def bend(self, t: float) -> float:
        """Upper bound of |f''| after t."""
        return sum(abs(rate) ** 2 * abs(z) * math.exp(rate.real * t) for z, rate in self.waves)

    def minus(self, other: Curve, shift: float = 0.0) -> Curve:
        waves = dict.fromkeys([rate for _, rate in (*self.waves, *other.waves)], 0j)
        for sign, curve in ((1.0, self), (-1.0, other)):
            for z, rate in curve.waves:
                waves[rate] += sign * z  # twins' waves cancel exactly
        merged = tuple((z, rate) for rate, z in waves.items())
        return Curve(self.a - other.a - shift, self.b - other.b, merged)

    def negative(self) -> Curve:
        return STILL.minus(self)


STILL = Curve(0.0, 0.0, ())


def swing(building: Oscillator, u: float, v: float, ground: tuple[float, float]) -> Curve:
    """The displacement from (u, v) on, under a_g = ground[0] + ground[1] t."""
    rate = building.rate
    if rate == 0:
        return STILL
    omega2, decay = abs(rate) ** 2, -rate.real
    b = -ground[1] / omega2
    a = (-ground[0] - 2.0 * decay * b) / omega2
    real = u - a
    return Curve(a, b, ((complex(real, -(v - b + decay * real) / rate.imag), rate),))


def floor_acceleration(motion: Curve, ground: tuple[float, float]) -> Curve:
    """Absolute acceleration ü + a_g of the floor."""
    return Curve(ground[0], ground[1], tuple((z * rate**2, rate) for z, rate in motion.waves))


def highest(curve: Curve, end: float, best: float) -> float:
    """max(best, max f on [0, end]): halves are dropped only where the bound on f'' proves them lower."""
    todo = [(0.0, curve.value(0.0), end, curve.value(end))]
    best = max(best, todo[0][1], todo[0][3])
    rounding = 1e-16 * (abs(curve.a) + sum(abs(z) for z, _ in curve.waves))
    while todo:
        lo, f_lo, hi, f_hi = todo.pop()
        width, bend = hi - lo, curve.bend(lo)
        if max(f_lo, f_hi) + bend * width**2 / 8.0 <= best + 1e-14 * abs(best) + rounding:
            continue
        if abs(curve.slope(0.5 * (lo + hi))) > 0.5 * bend * width:  # monotone: the highest is an end
            continue
        mid = 0.5 * (lo + hi)
        f_mid = curve.value(mid)
        best = max(best, f_mid)
        todo += [(lo, f_lo, mid, f_mid), (mid, f_mid, hi, f_hi)]
    return best


def first_touch(depth: Curve, end: float) -> tuple[float, float] | None:
    """(time where δ = 0, time where δ = CONFIRMED) of the first touch in [0, end], or None."""
    level = CONFIRMED
    todo = [(0.0, depth.value(0.0), end, depth.value(end))]
    while todo:
        lo, f_lo, hi, f_hi = todo.pop()
        width, bend = hi - lo, depth.bend(lo)
        if max(f_lo, f_hi) + bend * width**2 / 8.0 < level:
            continue
        slope = depth.slope(0.5 * (lo + hi))
        monotone = abs(slope) > 0.5 * bend * width or width < 1e-14
        if not monotone:
            mid = 0.5 * (lo + hi)
            f_mid = depth.value(mid)
            todo += [(mid, f_mid, hi, f_hi), (lo, f_lo, mid, f_mid)]  # the earlier half is looked at first
        elif f_hi >= level:
            sure = lo if f_lo >= level else root_between(lambda t: depth.value(t) - level, lo, hi)
            return (lo if f_lo >= 0.0 else root_between(depth.value, lo, sure)), sure
    return None


def root_between(function: Callable[[float], float], lo: float, hi: float) -> float:
    return float(brentq(function, lo, hi, xtol=1e-18, rtol=8.9e-16, maxiter=300))
