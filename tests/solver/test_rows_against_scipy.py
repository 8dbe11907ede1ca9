"""The row solver against an integrator that shares nothing with it: SciPy in physical coordinates, a whole row at once.

No modes, no closed flight and no parts of a row there: what is modal, skipped or solved apart in the solver is held
against one direct integration. Its answers are kept (`kept_references`), each as long as nothing that it follows from
has changed. Peaks are never excused. What is: the time of the first touch of neighbours that start from rest with a
closed gap, a limit of 0/0, and with it the time spent in contact.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_rows import Answer, Meeting
from row_cases import CASES, by_solver, named
from scenes import scene_text

from pounding_risk.models.contact.laws import LAWS
from pounding_risk.scene.reader import parse_scene
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


SIDES = ("left", "right")
NAMES = {"Jankowski": "jankowski", "HertzDamp": "hertz_damp"}


def truth_of(scene: Any) -> Answer:
    """A scene of the benchmarks by the reference integrator."""
    law, e = NAMES[type(scene.law).__name__], scene.restitution.c0
    meetings = [
        Meeting(interface, left, right, scene.gap, law, scene.law.stiffness, e)
        for interface, left, right in scene.points
    ]
    return reference(scene.chains, meetings, scene.acceleration, scene.dt)


@pytest.mark.complete
@pytest.mark.parametrize("name", ["three_storey_pair", "row_of_four"])
def test_opensees_converges_to_the_reference(ops, name: str):
    """Steps of a tenth: touches fall inside them, so that errors fall by about ten and peaks between steps by more."""
    import row_scenes
    from opensees_row import errors_of, solve_opensees_row

    scene = getattr(row_scenes, name)()
    true = truth_of(scene)
    assert true.points["impact_count"].min() >= 3
    known = true.floors[:, 0], true.points["peak_contact_force"]
    coarse, fine = (errors_of(solve_opensees_row(ops, scene, h), known) for h in (1e-3, 1e-4))
    assert np.all(np.array(coarse) < 1e-2)
    assert np.all(np.array(fine) < 6e-4)
    assert np.all(np.array(fine) < 0.3 * np.array(coarse)), (coarse, fine)


def test_dashpots_make_up_the_damping_matrix():
    """Dashpots between floors and to the ground, put together again, are C."""
    from row_scenes import even

    from pounding_risk.lab.accuracy_opensees import joins

    for rule in ("stiffness", "rayleigh", "modal"):
        chain = even("a", 4, 1e5, 1e8, rule)
        matrix = np.zeros((5, 5))
        for (one, other), dashpot in joins(chain.damping).items():
            ends = np.eye(5)[one] - np.eye(5)[other]
            matrix += dashpot * np.outer(ends, ends)
        np.testing.assert_allclose(matrix[1:, 1:], chain.damping, rtol=1e-12, atol=1e-6)
        assert len(joins(chain.damping)) == {"stiffness": 4, "rayleigh": 7, "modal": 10}[rule]


BENT = [[320, -180, 30], [-180, 230, -90], [30, -90, 65]]  # MN/m
JOINED = {
    "a linked row": {"storey_stiffnesses": ["180 MN/m", "150 MN/m", "90 MN/m"]},
    "a stiffness matrix": {"stiffness_matrix": {"values": BENT, "unit": "MN/m"}},
    "a part of it that yields": {
        "stiffness_matrix": {"values": BENT, "unit": "MN/m"},
        "storey_stiffnesses": ["60 MN/m", "40 MN/m", "15 MN/m"],
        "storey_strengths": ["400 kN", "300 kN", "100 kN"],
    },
}


@pytest.mark.parametrize("name", JOINED)
def test_opensees_converges_to_links_and_matrices(ops, name: str):
    """Without contact Newmark's error is a quarter where the step is halved, beside which a peak is missed by a part.

    Contacts begin inside steps: their force is within 1 % at a millisecond.
    """
    from pounding_risk.lab.accuracy_bench import bench_of
    from pounding_risk.lab.accuracy_findings import FORCE, GAP
    from pounding_risk.lab.accuracy_opensees import opensees_outcome

    hall = {"name": "hall", "floor_masses": ["200 t", "200 t", "150 t"], "storey_heights": "4 m", **JOINED[name]}
    tower = {"name": "tower", "floor_masses": "210 t", "storeys": 4, "storey_stiffnesses": "300 MN/m"}
    link = {"link_stiffness": "20 MN/m", "link_damping": "1 MN s/m"} if name == "a linked row" else {}
    keys = {"records": {"window": ["1 s", "5 s"], "pga": "0.5 g"}, "contact": [dict.fromkeys(SIDES, "storey 3")]}
    effects = {"inelastic_storeys": {}} if "storey_strengths" in hall else None
    text = scene_text(hall, tower | {"storey_heights": "4 m"}, gap="4 mm", effects=effects, **keys, **link)
    bench = bench_of(parse_scene(text), 1)
    known = bench.event(1e-12).values[0, 0]
    coarse, fine = (opensees_outcome(bench, step).values[0, 0] for step in (2e-3, 1e-3))
    gaps = [abs(found[GAP] / known[GAP] - 1.0) for found in (coarse, fine)]
    assert gaps[0] < 1e-3 and gaps[1] < 0.4 * gaps[0]
    assert known[FORCE] > 1e5 and fine[FORCE] == pytest.approx(known[FORCE], rel=1e-2)
