"""The Runge-Kutta table checks itself, is SciPy's, and has the order it declares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as scipy_table

from pounding_risk.models.tableau import DOP853, Tableau

STAGES = len(DOP853.nodes)


def test_the_table_is_scipys():
    # SciPy keeps the same method with one estimator of 13 entries, the last for the slope at the end.
    assert np.allclose(DOP853.a, scipy_table.A[:STAGES, :STAGES], rtol=0.0, atol=2e-15 * 44.0)
    assert np.allclose(DOP853.b, scipy_table.B, rtol=0.0, atol=2e-15 * 6.0)
    assert np.allclose(DOP853.c, scipy_table.C[:STAGES], rtol=0.0, atol=2e-16)
    assert np.allclose(DOP853.e, [scipy_table.E5[:STAGES], scipy_table.E3[:STAGES]], rtol=0.0, atol=2e-14)


def test_the_method_is_explicit_and_its_arrays_cannot_be_written():
    assert not np.triu(DOP853.a).any()
    for array in (DOP853.a, DOP853.b, DOP853.c, DOP853.e):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_a_changed_digit_is_refused():
    """Every coefficient that a sum reaches: an error of 1e-9 in one of them must not pass."""
    wrong: list[dict] = [
        {"weights": {**DOP853.weights, column: DOP853.weights[column] + 1e-9}} for column in DOP853.weights
    ]
    wrong += [{"nodes": tuple(c + 1e-9 * (i == at) for i, c in enumerate(DOP853.nodes))} for at in range(STAGES)]
    for at, row in enumerate(DOP853.rows):
        for column, value in row.items():
            rows = [*DOP853.rows]
            rows[at] = {**row, column: value + 1e-9}
            wrong.append({"rows": tuple(rows)})
    for at, row in enumerate(DOP853.errors):
        for column, value in row.items():
            errors = [*DOP853.errors]
            errors[at] = {**row, column: value + 1e-9}
            wrong.append({"errors": tuple(errors)})
    for change in wrong:
        with pytest.raises(ValueError, match=r"^DOP853: .*off by"):
            replace(DOP853, **change)


def test_the_message_names_the_fault():
    nodes, weights, errors = (0.0, 1.0), {0: 0.5, 1: 0.5}, ({0: 0.5, 1: -0.5},)
    with pytest.raises(ValueError, match=r"^Heun: a row does not sum to its node \(off by 1.0e-01\)$"):
        Tableau("Heun", 2, "Heun (1900)", nodes, ({0: 1.1},), weights, errors)
    with pytest.raises(ValueError, match=r"^Heun: quadrature condition 3 \(off by 1.7e-01\)$"):
        Tableau("Heun", 3, "Heun (1900)", nodes, ({0: 1.0},), weights, errors)
    with pytest.raises(ValueError, match=r"^Heun: an error estimator does not sum to zero \(off by 1"):
        Tableau("Heun", 2, "Heun (1900)", nodes, ({0: 1.0},), weights, ({0: 0.5, 1: -0.4},))


def integrate(steps: int) -> tuple[float, float, float]:
    """y' = y cos t from 0 to 4, y = exp(sin t): error at the end, and the larger of each estimator."""
    h, y, estimates = 4.0 / steps, 1.0, np.zeros(2)
    for step in range(steps):
        k = np.zeros(STAGES)
        for stage in range(STAGES):
            time = (step + DOP853.c[stage]) * h
            k[stage] = (y + h * DOP853.a[stage] @ k) * np.cos(time)
        y += h * DOP853.b @ k
        estimates = np.maximum(estimates, np.abs(h * DOP853.e @ k))
    return abs(y - np.exp(np.sin(4.0))), estimates[0], estimates[1]


def test_the_error_falls_with_the_declared_order():
    coarse, fine = integrate(8), integrate(16)
    slopes = np.log2(np.array(coarse) / np.array(fine))
    # The error over the whole span falls with h^8; within one step the estimators fall with h^6 and h^4.
    assert slopes[0] == pytest.approx(DOP853.order, abs=0.7)
    assert slopes[1] == pytest.approx(6.0, abs=0.7)
    assert slopes[2] == pytest.approx(4.0, abs=0.7)
