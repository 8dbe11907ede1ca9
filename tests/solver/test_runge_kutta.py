"""The Runge-Kutta table checks itself, is SciPy's, and has the order it declares; linear equations against LAPACK."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import RK45
from scipy.integrate._ivp import dop853_coefficients as scipy_table
from scipy.integrate._ivp import radau as scipy_radau
from sentences import refusal

from pounding_risk.solver.pair.implicit import solve_linear
from pounding_risk.solver.runge_kutta import DOP853, DORMAND_PRINCE, RADAU, Collocation, Tableau

STAGES = len(DOP853.nodes)


def test_the_table_is_scipys():
    # SciPy keeps the same method with one estimator of 13 entries, the last for the slope at the end.
    assert np.allclose(DOP853.a, scipy_table.A[:STAGES, :STAGES], rtol=0.0, atol=2e-15 * 44.0)
    assert np.allclose(DOP853.b, scipy_table.B, rtol=0.0, atol=2e-15 * 6.0)
    assert np.allclose(DOP853.c, scipy_table.C[:STAGES], rtol=0.0, atol=2e-16)
    assert np.allclose(DOP853.e, [scipy_table.E5, scipy_table.E3], rtol=0.0, atol=2e-14)
    assert np.allclose(DOP853.late, scipy_table.A[STAGES + 1 :], rtol=0.0, atol=2e-15 * 44.0)
    assert np.allclose(DOP853.late_nodes, scipy_table.C[STAGES + 1 :], rtol=0.0, atol=2e-16)
    assert np.allclose(DOP853.d, scipy_table.D, rtol=0.0, atol=2e-15 * 280.0)
    for ours, theirs in (("a", RK45.A), ("b", RK45.B), ("c", RK45.C)):
        assert np.allclose(getattr(DORMAND_PRINCE, ours)[..., : theirs.shape[-1]], theirs, rtol=0.0, atol=1e-15 * 12.0)
    # The sign of an error estimate is a matter of taste.
    assert np.allclose(-DORMAND_PRINCE.e[0], RK45.E, rtol=0.0, atol=1e-15) or np.allclose(
        DORMAND_PRINCE.e[0], RK45.E, rtol=0.0, atol=1e-15
    )


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


def test_the_message_names_the_fault(says):
    for order, row, error in ((2, 1.1, -0.5), (3, 1.0, -0.5), (2, 1.0, -0.4)):
        given = "Heun", order, "Heun (1900)", (0.0, 1.0), ({0: row},), {0: 0.5, 1: 0.5}, ({0: 0.5, 1: error},)
        says(refusal(Tableau, *given, kind=ValueError))


def solve_growth(table: Tableau, steps: int) -> tuple[float, list[float], float]:
    """y' = y cos t from 0 to 4, y = exp(sin t): error at the end, the largest of each estimate, and the largest
    error in the middle of a step between the ends."""
    h, y, estimates, between = 4.0 / steps, 1.0, np.zeros(len(table.e)), 0.0
    stages = len(table.nodes)
    for step in range(steps):
        start, k = step * h, np.zeros(stages + 1 + len(table.late))
        for stage in range(stages):
            k[stage] = (y + h * table.a[stage] @ k[:stages]) * np.cos(start + table.c[stage] * h)
        after = y + h * table.b @ k[:stages]
        k[stages] = after * np.cos(start + h)
        for late, node in enumerate(table.late_nodes):
            k[stages + 1 + late] = (y + h * table.late[late] @ k) * np.cos(start + node * h)
        terms = [after - y, h * k[0] - (after - y), 2.0 * (after - y) - h * (k[0] + k[stages]), *h * table.d @ k]
        for x in (0.2, 0.5, 0.9):
            value = 0.0
            for row in range(len(terms) - 1, -1, -1):
                value = (x if row % 2 == 0 else 1.0 - x) * (terms[row] + value)
            exact = np.exp(np.sin(start + x * h)) / np.exp(np.sin(start)) * y
            between = max(between, abs(y + value - exact))
        estimates = np.maximum(estimates, np.abs(h * table.e @ k[: stages + 1]))
        y = after
    return abs(y - np.exp(np.sin(4.0))), list(estimates), between


@pytest.mark.parametrize(
    ("table", "steps", "orders"),
    [(DOP853, 8, (8, 6, 4, 8)), (DORMAND_PRINCE, 16, (5, 5, 5))],
    ids=lambda v: str(v)[:14],
)
def test_errors_fall_with_the_declared_order(table, steps, orders):
    """Over the whole span with h^order; within one step the estimates and the polynomial with the powers given."""
    coarse, fine = solve_growth(table, steps), solve_growth(table, 2 * steps)
    slopes = np.log2(np.array([coarse[0], *coarse[1], coarse[2]]) / np.array([fine[0], *fine[1], fine[2]]))
    assert slopes == pytest.approx(orders, abs=0.8)


def test_three_stages_of_radau_are_scipys():
    """SciPy keeps the same family's method of order 5: its nodes, and the eigenvalues of the inverse of its a."""
    three = Collocation("three stages", 5, "", tuple(scipy_radau.C))
    found = np.sort_complex(np.linalg.eigvals(np.linalg.inv(three.a)))
    known = [scipy_radau.MU_REAL, scipy_radau.MU_COMPLEX, np.conj(scipy_radau.MU_COMPLEX)]
    np.testing.assert_allclose(found, np.sort_complex(known), rtol=1e-13)


def test_the_implicit_method_is_radaus_of_order_nine():
    """C(5), B(9), the nodes those of the polynomial d⁴/dx⁴ (x⁴ (x − 1)⁵); what decays at once is gone after a step."""
    powers = np.arange(1, 6)
    np.testing.assert_allclose(
        RADAU.a @ RADAU.c[:, None] ** (powers - 1), RADAU.c[:, None] ** powers / powers, rtol=0.0, atol=1e-15
    )
    for power in range(1, 10):
        assert abs(RADAU.a[-1] @ RADAU.c ** (power - 1) - 1.0 / power) < 1e-15
    assert abs(RADAU.a[-1] @ RADAU.c**9 - 0.1) > 1e-9
    whole = np.polynomial.Polynomial([0, 0, 0, 0, 1.0]) * np.polynomial.Polynomial([-1.0, 1.0]) ** 5
    np.testing.assert_allclose(np.sort(whole.deriv(4).roots().real), RADAU.c, atol=1e-13)
    growth = 1.0 - 1e12 * RADAU.a[-1] @ np.linalg.solve(np.eye(5) + 1e12 * RADAU.a, np.ones(5))
    assert abs(growth) < 1e-3


def test_the_polynomial_of_an_implicit_step():
    """A polynomial of degree 5 comes back everywhere, and so does the slope at the beginning of one of degree 4."""
    wanted = np.polynomial.Polynomial([0.7, -1.3, 2.0, 0.4, -3.0, 1.1])
    terms = RADAU.terms @ (wanted(RADAU.c) - wanted(0.0))
    for x in (0.03, 0.4, 0.77, 1.0):
        value = 0.0
        for row in range(4, -1, -1):
            value = (x if row % 2 == 0 else 1.0 - x) * (terms[row] + value)
        assert wanted(0.0) + value == pytest.approx(wanted(x), rel=1e-12)
    assert RADAU.start @ wanted.deriv()(RADAU.c) == pytest.approx(wanted.deriv()(0.0), rel=1e-13)


def test_wrong_nodes_are_refused():
    with pytest.raises(ValueError, match=r"^Radau.*: quadrature condition \d \(off by"):
        replace(RADAU, nodes=(RADAU.nodes[0] + 1e-9, *RADAU.nodes[1:]))
    assert "the last node is not the end" in refusal(replace, RADAU, kind=ValueError, nodes=(*RADAU.nodes[:-1], 0.99))


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
