"""Small systems of linear equations, against LAPACK."""

from __future__ import annotations

import numpy as np
import pytest

from pounding_risk.solver.pair.implicit import solve_linear


@pytest.mark.parametrize("size", [1, 2, 5, 20])
def test_it_solves_what_lapack_solves(size: int):
    """Residuals of a few roundings, whatever the condition; a zero on the diagonal needs the pivots."""
    random = np.random.default_rng(size)
    matrix, right = random.standard_normal((size, size)), random.standard_normal(size)
    if size > 1:
        matrix[0, 0] = 0.0
    found = right.copy()
    solve_linear(matrix.copy(), found)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), rtol=1e-10)
    assert np.abs(matrix @ found - right).max() <= 1e-14 * size * np.abs(matrix).max() * np.abs(found).max()
