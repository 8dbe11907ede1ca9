"""Ground motions of tests that no record gives: drawn from a seed, with a peak that is asked for."""

from __future__ import annotations

import numpy as np


def burst(seed: int, peak: float, dt: float = 0.01, duration: float = 5.0) -> np.ndarray:
    """Eight sines of random frequency under a half-sine envelope, of which the first sample is zero."""
    random = np.random.default_rng(seed)
    t = np.arange(round(duration / dt) + 1) * dt
    waves = [random.normal() * np.sin(2 * np.pi * f * t + random.uniform(0, 6)) for f in random.uniform(0.4, 8, 8)]
    a = np.sum(waves, axis=0) * np.sin(np.pi * t / t[-1])
    return a * (peak / np.abs(a).max())
