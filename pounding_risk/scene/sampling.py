"""Points in the unit cube at which uncertain numbers are drawn, and their correlation.

The points of "sobol" and "random" are one sequence each: those of fewer samples are the first of more.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SOBOL, HYPERCUBE, RANDOM = "sobol", "latin hypercube", "random"
METHODS = (SOBOL, HYPERCUBE, RANDOM)
GROWING = (SOBOL, RANDOM)  # to which samples can be added
EDGE = 2.0**-53  # a point at 0 or 1, where a quantile may be infinite, stands this far inside


def points_of(method: str, samples: int, dimensions: int, seed: int) -> Array:
    """Independent points in the open unit cube, one row for each sample; the same for the same seed."""
    return inside(_drawn(method, samples, dimensions, np.random.default_rng(seed)))


def inside(points: Array) -> Array:
    """The points with those at an end of [0, 1] just inside."""
    return np.clip(points, EDGE, 1.0 - EDGE)


def _drawn(method: str, samples: int, dimensions: int, generator: np.random.Generator) -> Array:
    if method == RANDOM:
        return generator.random((samples, dimensions))  # row by row, so that more samples only follow
    from scipy.stats import qmc  # takes longer to import than a scene takes to be read

    if method == HYPERCUBE:
        return qmc.LatinHypercube(dimensions, seed=generator).random(samples)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of samples that are no power of two, which `uncertain.notes` tells
        return qmc.Sobol(dimensions, scramble=True, seed=generator).random(samples)


def cholesky(matrix: Sequence[Sequence[float]]) -> list[list[float]] | None:
    """The lower factor L of a symmetric matrix L Lᵀ, by rows; None where it is not positive definite.

    Written out, so that its bits do not depend on a library.
    """
    factor = [[0.0] * len(matrix) for _ in matrix]
    for row, values in enumerate(matrix):
        for column in range(row + 1):
            rest = values[column] - sum(factor[row][k] * factor[column][k] for k in range(column))
            if column < row:
                factor[row][column] = rest / factor[column][column]
            elif rest > LEAST:
                factor[row][row] = sqrt(rest)
            else:
                return None
    return factor


LEAST = 1e-12  # variance of a number that the others leave open; below it they determine the number


def correlated(points: Array, matrix: Sequence[Sequence[float]]) -> Array:
    """Points whose standard normals, number by number, have this positive definite correlation matrix.

    A Gaussian copula: a column that is correlated with none before it stays as it is.
    """
    from scipy.special import ndtr, ndtri

    factor = cholesky(matrix)
    assert factor is not None, "checked when the scene was read"
    made = points.copy()
    normals = ndtri(points)
    for row, weights in enumerate(factor):
        if any(weights[:row]):
            # Column by column and no matrix product, whose bits depend on how many samples there are.
            total = normals[:, row] * weights[row]
            for column in range(row):
                total = total + normals[:, column] * weights[column]
            made[:, row] = ndtr(total)
    return inside(made)
