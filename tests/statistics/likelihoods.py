"""The largest of a likelihood of two numbers, and what its curvature says of their errors, without derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

Lost = Callable[[np.ndarray], float]  # a negative log-likelihood


def best_of(lost: Lost, start: list[float]) -> np.ndarray:
    """Where the likelihood is largest, by Nelder and Mead; a top is flat: half the digits."""
    options = {"xatol": 1e-9, "fatol": 1e-12}
    return minimize(lost, start, method="Nelder-Mead", options=options).x


def curvature_errors(lost: Lost, best: np.ndarray, step: float = 1e-4) -> tuple[float, ...]:
    """Standard errors from central second differences."""
    units = step * np.eye(2)
    second = [
        [
            (lost(best + a + b) - lost(best + a - b) - lost(best - a + b) + lost(best - a - b)) / (4.0 * step**2)
            for b in units
        ]
        for a in units
    ]
    return tuple(np.sqrt(np.diag(np.linalg.inv(np.array(second)))))
