"""Ten gaps of the study of codes' gaps, by state transitions of NumPy and SciPy alone."""

from __future__ import annotations

from itertools import combinations, pairwise
from math import pi, sqrt

import numpy as np
import pytest
from scipy.linalg import expm

import pounding_risk as pr

PERIODS = (0.1, 0.5, 0.9, 1.3, 3.0)
PAIRS = list(combinations(range(len(PERIODS)), 2))
PARTS = 16  # of a sample


def displacement(acceleration: np.ndarray, dt: float, period: float, damping: float) -> np.ndarray:
    """Of an oscillator at rest, at parts of the samples, the ground's acceleration straight between these."""
    omega, step = 2.0 * pi / period, dt / PARTS
    system = np.zeros((4, 4))
    system[0, 1] = system[2, 3] = 1.0
    system[1] = -(omega**2), -2.0 * damping * omega, -1.0, 0.0
    advance = expm(system * step)
    state, found = np.zeros(2), [0.0]
    for first, second in pairwise(acceleration):
        whole = np.array([*state, first, (second - first) / dt])
        for _ in range(PARTS):
            whole = advance @ whole
            found.append(whole[0])
        state = whole[:2]
    return np.array(found)


def test_ten_gaps_and_their_srss():
    """Peaks between parts of a sample are missed by (ω h)² / 8, at 0.1 s and 0.625 ms 2e-4; twice for a difference."""
    names = ["RSN6-180", "RSN77-254", "RSN753-000", "RSN1690-090", "NAPA-HNE"]
    gaps = pr.spectra(
        pr.Records(names, pga="0.3 g"), periods=list(PERIODS), damping=0.05, percentiles=[50], motions=True
    )
    needed = gaps["required_gap_of_motion"].squeeze("polarity")
    for place, (one, other) in enumerate(PAIRS):
        name = names[place % len(names)]
        motion = pr.read_motion(name, pga="0.3 g")
        sides = [displacement(motion.acceleration, motion.dt, PERIODS[k], 0.05) for k in (one, other)]
        found = needed.sel(record=name).isel(left_period=one, right_period=other).item()
        assert found == pytest.approx((sides[0] - sides[1]).max(), rel=5e-4)
        peaks = [gaps[f"{side}_displacement_of_record"].sel(record=name) for side in ("left", "right")]
        known = [peaks[0].isel(left_period=one).item(), peaks[1].isel(right_period=other).item()]
        assert known == pytest.approx([np.abs(side).max() for side in sides], rel=5e-4)
    medians = [float(gaps["left_displacement"].sel(percentile=50).isel(left_period=k)) for k in (1, 2)]
    asked = gaps["separation"].sel(rule="srss", percentile=50).isel(left_period=1, right_period=2).item()
    assert asked == pytest.approx(sqrt(medians[0] ** 2 + medians[1] ** 2), rel=1e-12)
