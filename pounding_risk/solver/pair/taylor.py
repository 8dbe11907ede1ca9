"""The Taylor series of a segment of flight: values, bounds, and the search for rises and peaks.

Over one node interval a_g is linear and a building's motion is its own Taylor series, summed to rounding. Rises
and peaks are found by bisection under a bound on the second derivative, so that none is missed, whatever lies
between the two ends.

A term of a sum waits for the one before it. Sums that are needed together are therefore taken in one loop, where they
take the time of one.
"""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.workspace import MAX_TERMS, SIGNAL

# 1 / (n (n−1)): a division would take longer than all else in a term.
SHARES = np.array([0.0, 0.0] + [1.0 / (n * (n - 1)) for n in range(2, MAX_TERMS)])
FINEST = 2.0**-36  # of an interval: where the bisection stops


@kernel
def expand(oscillator, displacement, velocity, load, search, row, terms):
    """Write the Taylor coefficients of u(x) from (u, u̇) to a row of the series; ``load`` as in `GroundInterval`."""
    series = search.series
    series[row, 0] = displacement
    series[row, 1] = velocity
    two_zeta_omega, omega2 = oscillator.two_zeta_omega, oscillator.omega2
    series[row, 2] = -(two_zeta_omega * series[row, 1] + omega2 * series[row, 0] + load[0]) * SHARES[2]
    series[row, 3] = -(two_zeta_omega * 2 * series[row, 2] + omega2 * series[row, 1] + load[1]) * SHARES[3]
    series[row, 4] = -(two_zeta_omega * 3 * series[row, 3] + omega2 * series[row, 2] + load[2]) * SHARES[4]
    series[row, 5] = -(two_zeta_omega * 4 * series[row, 4] + omega2 * series[row, 3] + load[3]) * SHARES[5]
    for n in range(6, terms):
        series[row, n] = -(two_zeta_omega * (n - 1) * series[row, n - 1] + omega2 * series[row, n - 2]) * SHARES[n]


@small
def value_at(series, row, terms, x):
    """Value at x of the Taylor series in row ``row``, of so many terms: Σ c_n x^n."""
    total = 0.0
    for n in range(terms - 1, -1, -1):
        total = total * x + series[row, n]
    return total


@small
def slope_at(series, row, terms, x):
    """First derivative of a Taylor series at x: Σ n c_n x^(n−1)."""
    total = 0.0
    for n in range(terms - 1, 0, -1):
        total = total * x + n * series[row, n]
    return total


@small
def bend_at(series, row, terms, x):
    """Second derivative of a Taylor series at x: Σ n (n−1) c_n x^(n−2)."""
    total = 0.0
    for n in range(terms - 1, 1, -1):
        total = total * x + n * (n - 1) * series[row, n]
    return total


@small
def bend_within(series, row, terms, x):
    """Σ n (n−1) |c_n| x^(n−2): no second derivative on [0, x] is larger."""
    total = 0.0
    for n in range(terms - 1, 1, -1):
        total = total * x + n * (n - 1) * abs(series[row, n])
    return total


@small
def value_and_slope(series, row, terms, x):
    """(value, first derivative) of a Taylor series at x, as `value_at` and `slope_at`."""
    value = slope = 0.0
    for n in range(terms - 1, 0, -1):
        value = value * x + series[row, n]
        slope = slope * x + n * series[row, n]
    return value * x + series[row, 0], slope


@small
def slope_and_bend(series, row, terms, x):
    """(first, second derivative) of a Taylor series at x, as `slope_at` and `bend_at`."""
    slope = bend = 0.0
    for n in range(terms - 1, 1, -1):
        slope = slope * x + n * series[row, n]
        bend = bend * x + n * (n - 1) * series[row, n]
    return slope * x + series[row, 1], bend


@small
def value_and_bounds(series, row, terms, x):
    """(value, first derivative at x, bound of the second on [0, x]): `value_at`, `slope_at` and `bend_within`."""
    value = slope = bound = 0.0
    for n in range(terms - 1, 1, -1):
        value = value * x + series[row, n]
        slope = slope * x + n * series[row, n]
        bound = bound * x + n * (n - 1) * abs(series[row, n])
    value, slope = value * x + series[row, 1], slope * x + series[row, 1]
    return value * x + series[row, 0], slope, bound


@small
def bend_and_twist_within(series, row, terms, x, end):
    """`bend_at` x, and Σ n (n−1) (n−2) |c_n| end^(n−3): no third derivative on [0, ``end``] is larger."""
    bend = twist = 0.0
    for n in range(terms - 1, 2, -1):
        bend = bend * x + n * (n - 1) * series[row, n]
        twist = twist * end + n * (n - 1) * (n - 2) * abs(series[row, n])
    return bend * x + 2 * series[row, 2], twist


@small
def local_maximum_bound(start, stop, span, bend):
    """The largest value that a function with |f''| ≤ bend and these end values can take on the span."""
    rise = (stop - start) / span
    half = 0.5 * bend * span
    if abs(rise) >= half:
        return max(start, stop)
    return 0.5 * (start + stop) + 0.25 * half * span + 0.25 * rise * rise * span / half


@kernel
def root_between(search, terms, level, low, high):
    """The x in (low, high] where the rising series of row SIGNAL meets ``level``: Newton's rule in the bracket."""
    x = high
    for _ in range(100):
        value, slope = value_and_slope(search.series, SIGNAL, terms, x)
        excess = value - level
        if excess > 0.0:
            high = x
        else:
            low = x
        new = x - excess / slope if slope > 0.0 else low
        if not low <= new <= high:
            new = 0.5 * (low + high)
        # Rounding of the series' value moves its root by eps × level / slope: no rule does better.
        floor = 4e-16 * (high + abs(level) / slope) if slope > 0.0 else 4e-16 * high
        if abs(new - x) <= floor or high - low <= floor:
            return new
        x = new
    return x


@kernel
def first_rise(search, terms, level, stop):
    """The first x in (0, stop] where the series of row SIGNAL rises through ``level``, or −1.

    The series starts at or below ``level``; what is above it by rounding counts as at it.
    """
    if level == inf:
        return -1.0
    start = 0.0
    at_start = min(search.series[SIGNAL, 0] - level, 0.0)
    slope = search.series[SIGNAL, 1]
    if slope < 0.0:
        # Departing: nothing can be back before 2 |slope| / bend.
        bend = bend_within(search.series, SIGNAL, terms, stop)
        start = -2.0 * slope / bend if bend > 0.0 else stop
        if start >= stop:
            return -1.0
        value, slope = value_and_slope(search.series, SIGNAL, terms, start)
        at_start = min(value - level, 0.0)
    finest = stop * FINEST
    search.pending[0] = stop
    top = 0
    while top >= 0:
        end = search.pending[top]
        value, end_slope, bend = value_and_bounds(search.series, SIGNAL, terms, end)
        at_end = value - level
        span = end - start
        # Put so that NaN, which is never above anything, ends the search: the run's status states it.
        quiet = not local_maximum_bound(at_start, at_end, span, bend) > 0.0
        if not quiet and at_end > 0.0 and slope + end_slope > bend * span:
            return root_between(search, terms, level, start, end)
        if not quiet and span <= finest and at_end > 0.0:
            return end
        if quiet or span <= finest:
            start, at_start, slope = end, at_end, end_slope
            top -= 1
        else:
            top += 1
            search.pending[top] = 0.5 * (start + end)
    return -1.0


@kernel
def summit(search, row, terms, sign, start, end):
    """The largest sign × series on a segment that is concave throughout: Newton's rule for its slope."""
    if sign * slope_at(search.series, row, terms, start) <= 0.0:
        return sign * value_at(search.series, row, terms, start)
    if sign * slope_at(search.series, row, terms, end) >= 0.0:
        return sign * value_at(search.series, row, terms, end)
    low, high = start, end
    x = 0.5 * (start + end)
    for _ in range(60):
        slope, bend = slope_and_bend(search.series, row, terms, x)
        slope = sign * slope
        if slope > 0.0:
            low = x
        else:
            high = x
        new = x - slope / (sign * bend)
        if not low < new < high:
            new = 0.5 * (low + high)
        # Flat at the summit: a place good to 1e-8 gives the value to rounding.
        has_converged = abs(new - x) <= 1e-8 * (end - start)
        x = new
        if has_converged:
            break
    return sign * value_at(search.series, row, terms, x)


@kernel
def highest(search, row, terms, sign, stop, best):
    """max(best, sign × series of a row on [0, stop]), to rounding."""
    start = 0.0
    at_start = sign * search.series[row, 0]
    best = max(best, at_start)
    finest = stop * FINEST
    search.pending[0] = stop
    top = 0
    while top >= 0:
        end = search.pending[top]
        value, _, bound = value_and_bounds(search.series, row, terms, end)
        at_end = sign * value
        best = max(best, at_end)
        span = end - start
        local_maximum = local_maximum_bound(at_start, at_end, span, bound)
        is_searched = not local_maximum > best + 1e-15 * abs(best) or span <= finest
        if not is_searched:
            bend, twist = bend_and_twist_within(search.series, row, terms, 0.5 * (start + end), end)
            bend, spread = sign * bend, 0.5 * span * twist
            if bend + spread < 0.0:
                best = max(best, summit(search, row, terms, sign, start, end))
            # A segment that is convex throughout is highest at an end.
            is_searched = abs(bend) > spread
        if is_searched:
            start, at_start = end, at_end
            top -= 1
        else:
            top += 1
            search.pending[top] = 0.5 * (start + end)
    return best
