"""The row solver against an integrator that shares nothing with it: SciPy in physical coordinates, a whole row at once.

No modes, no closed flight and no parts of a row there: what is modal, skipped or solved apart in the solver is held
against one direct integration. Its answers are kept (`kept_references`), each as long as nothing that it follows from
has changed. Peaks are never excused. What is: the time of the first touch of neighbours that start from rest with a
closed gap, a limit of 0/0, and with it the time spent in contact.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_rows import Answer
from row_cases import CASES, by_solver, named

from pounding_risk.models.contact.laws import LAWS
from pounding_risk.solver import counters
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

RTOL = 1e-9
# Relative tolerance at the solver's rtol of 1e-9: what the project promises of peaks, and of what follows from them.
PEAKS = dict.fromkeys(("peak_closing", "peak_opening", "peak_penetration", "peak_contact_force"), 1e-6)
TOLERANCES = {
    **PEAKS,
    "peak_approach_speed": 1e-6,
    # δ^1.5 of a depth that may be many times the yield depth: 1.5 times its relative error.
    "uncapped_force": 1.5e-6,
    # Sums over all contacts: errors of one sign can add where those of a peak do not.
    "contact_time": 3e-6,
    "impulse": 3e-6,
}


@cache
def truth(name: str) -> Answer:
    case = CASES[name]
    return reference(case.chains, case.meetings, *case.shaking.samples())


def differences(found: dict[str, np.ndarray], true: dict[str, np.ndarray], slack: np.ndarray) -> dict[str, Any]:
    """Outputs that are further off than their tolerances; a slack [s] is that of first touches."""
    off = {}
    for name, rel in TOLERANCES.items():
        allowed = rel * np.abs(true[name]) + (slack if name == "contact_time" else 0.0)
        if not np.all(np.abs(found[name] - true[name]) <= allowed):
            off[name] = (found[name], true[name])
    return off


def at_rest(case: Any, true: Answer) -> np.ndarray:
    """Drifts at the end, and plastic ones p: of storeys with laws those without shear, d − V / k = (1 − h) p."""
    soft = [
        chain.hardening * (chain.laws.any(axis=1) if chain.laws.size else np.zeros(chain.mass.size))
        for chain in case.chains
    ]
    return true.rest * np.column_stack([np.ones(len(true.rest)), 1.0 - np.concatenate(soft)])


@pytest.mark.parametrize("name", CASES)
def test_row_agrees_with_scipy(name: str):
    case = CASES[name]
    true, run = truth(name), by_solver(case)
    found, points = named(run), true.points
    assert run.status == counters.COMPLETE
    assert points["impact_count"].sum() >= 3, "a row without contacts compares nothing"
    np.testing.assert_array_equal(found["impact_count"], points["impact_count"])
    closed = np.array([each.gap == 0.0 for each in case.meetings])
    late = np.abs(np.nan_to_num(found["first_impact_time"] - points["first_impact_time"]))
    assert np.all(late <= np.where(closed, 5e-3, 1e-9))  # a root of free flight, or a matter of rounding
    assert differences(found, points, np.where(closed, late, 0.0)) == {}
    force, depth = points["peak_contact_force"], points["peak_penetration"]
    # Pull and energy are differences: measured against the peak force and against the work that makes them.
    assert np.all(np.abs(found["lowest_contact_force"] - points["lowest_contact_force"]) <= 1e-6 * force)
    energy = np.abs(found["energy_viscous"] - points["energy_viscous"])
    assert np.all(energy <= 3e-6 * (points["energy_viscous"] + force * depth))
    np.testing.assert_allclose(run.floors, true.floors, rtol=1e-6, err_msg="u, drift, shear, acceleration by dof")
    # What is left at the end is a small part of what was there.
    drift = true.floors[:, 1:2]
    assert np.all(np.abs(run.rest[:, :2] - at_rest(case, true)) <= 1e-6 * drift)
    if LAWS[case.meetings[0].law].capped:
        np.testing.assert_array_equal(found["yielding_contacts"], points["yielding_contacts"])
        np.testing.assert_allclose(found["first_yield_time"], points["first_yield_time"], rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_free_flight_of_a_row_is_direct_integration(name: str):
    """Without contact the solver has no step error at all; what is left is SciPy's."""
    case = CASES[name]
    acceleration, dt = case.shaking.samples()
    true = reference(case.chains, (), acceleration, dt)
    free = rows.free_row(lay_out(case.chains, (), dt), acceleration)
    np.testing.assert_allclose(free.floors, true.floors, rtol=1e-9)
    assert np.all(np.abs(free.rest[:, :2] - at_rest(case, true)) <= 1e-9 * true.floors[:, 1:2])


def test_cases_cover_what_they_should():
    chains = [chain for case in CASES.values() for chain in case.chains]
    meetings = [each for case in CASES.values() for each in case.meetings]
    assert {len(chain.mass) for chain in chains} >= {0, 1, 2, 3, 5}
    assert any(each.left_floor != int(each.left_floor) for each in meetings)
    assert any(each.right_floor != int(each.right_floor) for each in meetings)
    assert {0, 1} == {chain.foundations for chain in chains}
    assert any(np.isfinite(chain.strength).any() for chain in chains)
    assert any((chain.spring < chain.shear).any() for chain in chains)
    assert {len(case.chains) for case in CASES.values()} >= {2, 3, 5}
    assert 0.0 in {each.gap for each in meetings}
    # Damping that no set of dashpots between floors makes, and damping that is one.
    assert any(abs(chain.damping[0, -1]) > 0.0 for chain in chains if len(chain.mass) > 2)
    assert any(chain.damping[0, -1] == 0.0 for chain in chains if len(chain.mass) > 2)
