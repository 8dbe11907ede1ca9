"""Plain methods for rows: matrices against the tests' own, contacts against their integrator, one point as a pair."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pytest
from oracle_rows import Answer, Row, integrate
from row_cases import CASES, SOIL, Shaking, jankowski, meeting, points_of, single, storeys

from pounding_risk.lab.baselines import fixed_step as fixed
from pounding_risk.lab.baselines.matrices import row_matrices
from pounding_risk.lab.baselines.row_fixed_step import METHODS, solve_fixed_row
from pounding_risk.lab.baselines.solve_ivp import Contacts, solve_general
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import oscillators

LAW, STIFFNESS, E = "kelvin_voigt_tension_cut", 2e8, 0.6
CUT: Any = {"law": LAW, "stiffness": STIFFNESS, "restitution": E}
CHAINS = (storeys(3, 70e3, 4e7), single(150e3, 0.25), storeys(2, 300e3, 1.5e8, damping_rule="rayleigh"))
# A column between floors, and two floors of one building that may touch at once.
MEETINGS = (meeting(0, 2.5, 1.0, 0.006, **CUT), meeting(1, 1.0, 2.0, 0.008, **CUT), meeting(1, 1.0, 1.0, 0.004, **CUT))
GAPS = np.array([each.gap for each in MEETINGS])
LAWS_THERE = (LAWS[LAW](STIFFNESS),) * len(MEETINGS)
RULES = (constant(E),) * len(MEETINGS)


@pytest.fixture(scope="module")
def ground() -> tuple[np.ndarray, float]:
    return Shaking("CCC-HN1", 24.0, 27.0, 0.5).samples()


@pytest.fixture(scope="module")
def truth(ground) -> Answer:
    return integrate(CHAINS, MEETINGS, *ground)


@pytest.mark.parametrize("name", ["5 and 3 storeys, floors against columns", "single, rigid, storeys", "soil"])
def test_matrices_are_those_of_the_tests(name):
    """The integrator of the tests builds its own, from the same masses, springs and floor numbers."""
    case = CASES[name]
    found, expected = row_matrices(case.chains, points_of(case.meetings)), Row(case.chains, case.meetings)
    assert found.mass == pytest.approx(1.0 / expected.inverse_mass, rel=1e-15)
    assert np.array_equal(found.damping, expected.damping)
    assert found.stiffness == pytest.approx(expected.drift.T @ np.diag(expected.spring) @ expected.drift, rel=1e-12)
    assert found.shares == pytest.approx(expected.b, abs=1e-12)
    assert found.striking == pytest.approx(1.0 / (expected.b**2 @ expected.inverse_mass), rel=1e-12)


def test_storeys_that_yield_have_no_matrix():
    chains = CASES["yielding storeys"].chains
    with pytest.raises(ValueError, match="no stiffness matrix"):
        row_matrices(chains, ())
    assert row_matrices(jankowski(SOIL), ()).mass.size == 8


@pytest.mark.parametrize("method", METHODS)
def test_contacts_converge_to_the_integrator_of_the_tests(method, ground, truth):
    """First order, as touches fall inside steps: three contact points, two of them on the same building."""
    assert truth.points["impact_count"].min() >= 2
    row, bounds = row_matrices(CHAINS, points_of(MEETINGS)), (GAPS, np.full(3, inf))
    for h, error in ((1e-4, 2e-2), (1e-5, 2e-3)):
        found = solve_fixed_row(method, row, LAWS_THERE, RULES, bounds, fixed.divided(*ground, h))
        for column, name in ((fixed.CLOSING, "peak_closing"), (fixed.FORCE, "peak_contact_force")):
            assert found[:, column] == pytest.approx(truth.points[name], rel=error), (h, name)
        assert not found[:, fixed.UNSTABLE].any()
    assert np.array_equal(found[:, fixed.COUNT], truth.points["impact_count"])
    assert found[:, fixed.FIRST] == pytest.approx(truth.points["first_impact_time"], abs=1e-5)
    assert found[:, fixed.TOUCHING] * 1e-5 == pytest.approx(truth.points["contact_time"], rel=2e-3)


@pytest.mark.parametrize("method", METHODS)
def test_one_contact_point_is_that_of_a_pair(method):
    """The same steps as `fixed_step`, with matrices in place of periods: to rounding, grown over the contacts."""
    left, right = Building("left", 5e4, 0.3, 0.05), Building("right", 9e4, 0.15, 0.05)
    a = np.random.default_rng(7).normal(size=150) * np.sin(np.pi * np.arange(150) / 149.0) * 3.0
    motion, law = fixed.Ground(a, 0.01, 20), LAWS[LAW](2.5e8)
    expected = np.zeros(fixed.COLUMNS)
    limits = (1e-3, 1.5e5, constant(E))
    fixed.march_fixed(fixed.STEPPERS[method], oscillators(left, right), law, limits, motion, expected)
    row = row_matrices([chain_of(left), chain_of(right)], points_of([meeting(0, 1.0, 1.0, 1e-3)]))
    (found,) = solve_fixed_row(method, row, (law,), (constant(E),), ([1e-3], [1.5e5]), motion)
    assert expected[fixed.COUNT] >= 5 and found == pytest.approx(expected, rel=1e-9)


def test_a_step_beyond_the_stability_limit_is_unstable(ground):
    """Central difference past h = 2/ω of a stiff storey; Newmark's method has no limit."""
    stiff = (storeys(2, 50e3, 4e9), single(150e3, 0.25))
    row = row_matrices(stiff, points_of(MEETINGS[:1])[:1])
    for method, unstable in (("central_difference", True), ("newmark", False)):
        found = solve_fixed_row(
            method, row, LAWS_THERE[:1], RULES[:1], (np.array([1e3]), np.array([inf])), fixed.divided(*ground, 1.0)
        )
        assert (not np.isfinite(found[0, fixed.REACH]) or found[0, fixed.REACH] > 1.0 or found[0, -1] > 0) == unstable


@pytest.mark.parametrize(("solver", "rtol", "error"), [("DOP853", 1e-10, 1e-7), ("Radau", 1e-6, 1e-4)])
def test_scipy_agrees_with_the_integrator_of_the_tests(solver, rtol, error, ground, truth):
    """Another search for events: errors add up over the contacts, force crests are those of SciPy's interpolant."""
    there = Contacts(GAPS, LAWS_THERE, RULES, np.full(3, inf))
    found = solve_general(solver, row_matrices(CHAINS, points_of(MEETINGS)), there, ground, rtol)
    assert np.array_equal(found.impact_count, truth.points["impact_count"])
    for name in ("peak_closing", "peak_contact_force", "first_impact_time"):
        assert getattr(found, name) == pytest.approx(truth.points[name], rel=error), name
    assert found.steps >= found.impact_count.max()


def test_a_ground_motion_that_is_not_finite_is_refused(ground):
    a = ground[0].copy()
    a[20] = np.nan
    there = Contacts(GAPS, LAWS_THERE, RULES, np.full(3, inf))
    with pytest.raises(ValueError, match="sample 20 of the ground motion is not finite"):
        solve_general("DOP853", row_matrices(CHAINS, points_of(MEETINGS)), there, (a, ground[1]), 1e-6)
