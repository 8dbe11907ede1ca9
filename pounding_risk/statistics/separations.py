"""How the peak displacements of two buildings combine to the separation between them: ABS, SRSS, CQC.

    >>> from pounding_risk.statistics.separations import abs_sum, cqc, srss
    >>> abs_sum(0.03, 0.04), srss(0.03, 0.04)
    (0.07, 0.05)
    >>> round(cqc((0.03, 0.04), (0.9, 1.0), (0.05, 0.05)), 5)
    0.03694

Peaks of one motion do not coincide in time, so that the sum is a bound and what is between 0 and it a matter of
correlation. Each takes numbers or arrays, peaks of at least 0 in any one unit of length, and gives the like; all raise
PoundingError for a number out of its range.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pounding_risk.errors import PoundingError

Pair = tuple[ArrayLike, ArrayLike]  # left and right


def abs_sum(left: ArrayLike, right: ArrayLike) -> Any:
    """Sum of the peaks, S = d_A + d_B: no motion needs more, for |u_A − u_B| ≤ |u_A| + |u_B| at any time."""
    first, second = _displacements(left, right)
    return _unboxed(first + second)


def srss(left: ArrayLike, right: ArrayLike) -> Any:
    """Square root of the sum of squares, S = √(d_A² + d_B²): as if the two buildings moved independently."""
    return _unboxed(np.hypot(*_displacements(left, right)))


def cqc(displacements: Pair, periods: Pair, dampings: Pair) -> Any:
    """Double-difference, or complete quadratic, combination: S = √(d_A² + d_B² − 2 ρ d_A d_B).

    ρ is that of `white_noise_correlation`, of periods [s] and damping ratios, which a building that does not move need
    not have. Exact for the standard deviations of displacements under stationary white noise; for peaks as far as every
    peak is the same multiple of its standard deviation. Since ρ ≥ 0 it asks for no more than SRSS. Source: Jeng, Kasai
    and Maison (1992), Earthquake Spectra 8(2).
    """
    first, second = _displacements(*displacements)
    moves = np.broadcast_to((first > 0.0) & (second > 0.0), np.broadcast(first, second, *periods, *dampings).shape)
    # Where one stands still its period may be missing; any will do, for the product is zero.
    moving_pairs = [(np.where(moves, pair[0], 1.0), np.where(moves, pair[1], 1.0)) for pair in (periods, dampings)]
    correlation = np.asarray(white_noise_correlation(*moving_pairs))
    squared = np.square(first - second) + 2.0 * (1.0 - correlation) * first * second
    return _unboxed(np.sqrt(squared))


def white_noise_correlation(periods: Pair, dampings: Pair) -> Any:
    """Correlation ρ of the displacements of two oscillators under one stationary white noise, from 0 to 1.

        ρ = 8 √(ζ_A ζ_B) (ζ_B + r ζ_A) r^(3/2) / [(1 − r²)² + 4 ζ_A ζ_B r (1 + r²) + 4 (ζ_A² + ζ_B²) r²]
        r = T_B / T_A

    Periods [s] are above zero and finite, damping ratios from 0 to 1. Exact, for unequal damping too; the same with A
    and B exchanged. Two undamped oscillators of one period move alike, ρ = 1; of two periods ρ = 0. Source: Der
    Kiureghian (1981), Earthquake Engineering and Structural Dynamics 9.
    """
    first, second = (np.asarray(period, dtype=float) for period in periods)
    left, right = (np.asarray(damping, dtype=float) for damping in dampings)
    for period in (first, second):
        _refuse(period, ~(np.isfinite(period) & (period > 0.0)), "period [s]", "greater than 0 and finite")
    for damping in (left, right):
        _refuse(damping, ~((damping >= 0.0) & (damping <= 1.0)), "damping ratio", "from 0 to 1")
    ratio = second / first
    top = 8.0 * np.sqrt(left * right) * (right + ratio * left) * ratio**1.5
    distance = np.square((1.0 - ratio) * (1.0 + ratio))
    base = distance + 4.0 * left * right * ratio * (1.0 + ratio**2) + 4.0 * (left**2 + right**2) * ratio**2
    alike = base == 0.0  # one period, no damping: the limit of equal damping
    return _unboxed(np.minimum(np.where(alike, 1.0, top / np.where(alike, 1.0, base)), 1.0))  # rounding may exceed it


def _displacements(left: ArrayLike, right: ArrayLike) -> tuple[Any, Any]:
    pair = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
    for displacement in pair:
        _refuse(displacement, ~(displacement >= 0.0), "peak displacement", "at least 0")
    return pair


def _refuse(values: Any, wrong: Any, name: str, bounds: str) -> None:
    if wrong.any():
        raise PoundingError(f"a {name} is {values[wrong].flat[0]:g}; it must be {bounds}: give the building's own")


def _unboxed(value: Any) -> Any:
    """A number for numbers, an array for arrays."""
    return float(value) if np.ndim(value) == 0 else value
