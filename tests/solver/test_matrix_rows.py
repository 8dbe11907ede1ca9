"""Buildings by matrices and modes in rows: chains written in these forms, and frames that are no chain.

Oracles: the integrator in physical coordinates by which chains are held, whose kept answers the same chains must have
when they are written as matrices; and SciPy's DOP853 on the equations of a bending frame, written down here.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_springs import Linear, extremes
from row_cases import CASES, EL_CENTRO, RIGID, Case, Shaking, by_solver, contacts_of, meeting, named, points_of, single
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, eigh
from sweeps import sweep
from test_links import OF_LAWS as LINKED
from test_links import model as linked_row
from test_links import run as run_linked
from test_rows_against_scipy import differences

import pounding_risk as pr
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.solver import counters
from pounding_risk.solver.row.api import run_row
from pounding_risk.solver.row.layout import lay_out

ELASTIC = [name for name, case in CASES.items() if not any(np.isfinite(c.strength).any() for c in case.chains)]


def as_matrix(chain: Chain) -> Chain:
    """The same building without storey springs."""
    if chain.mass.size < 2:
        return chain
    nothing = np.zeros(chain.mass.size)
    return chain._replace(spring=nothing, shear=nothing, coupling=chain.stiffness())


def as_matrices(chain: Chain) -> Chain:
    """The same building, its masses a matrix too."""
    return as_matrix(chain)._replace(inertia=np.diag(chain.mass)) if chain.mass.size > 1 else chain


@pytest.mark.parametrize("form", [as_matrix, as_matrices])
@pytest.mark.parametrize("name", ELASTIC)
def test_chains_as_matrices_agree_with_scipy_and_with_chains(name: str, form: Callable[[Chain], Chain]):
    """To the tolerances of chains against SciPy; to the chain itself within 1e-9, ten times the solver's rtol of 1e-10.

    Both take the same steps but for rounding, which contacts that follow each other let grow.
    """
    case = CASES[name]
    chain = by_solver(case, 1e-10)
    run = by_solver(case._replace(chains=tuple(map(form, case.chains))), 1e-10)
    assert run.status == counters.COMPLETE
    true = reference(case.chains, case.meetings, *case.shaking.samples())
    late = np.nan_to_num(np.abs(named(run)["first_impact_time"] - true.points["first_impact_time"]))
    assert differences(named(run), true.points, late) == {}
    moves = [0, 1, 3]  # of u, drift, shear, acceleration: there is no storey whose shear there would be
    np.testing.assert_allclose(run.floors[:, moves], true.floors[:, moves], rtol=1e-6)
    np.testing.assert_allclose(run.floors[:, moves], chain.floors[:, moves], rtol=1e-9)
    for output in ("peak_closing", "peak_contact_force", "impulse"):
        np.testing.assert_allclose(named(run)[output], named(chain)[output], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", sorted(set(CASES) - set(ELASTIC)))
def test_yielding_storeys_beside_matrices_are_those_of_chains(name: str):
    """A matrix of no springs and one of their own masses beside them; within 1e-8, a hundred times rtol."""
    case = CASES[name]
    chains = [
        chain._replace(coupling=np.zeros((chain.mass.size,) * 2), inertia=np.diag(chain.mass)) for chain in case.chains
    ]
    known, found = by_solver(case, 1e-10), by_solver(case._replace(chains=tuple(chains)), 1e-10)
    assert found.status == counters.COMPLETE
    np.testing.assert_allclose(found.floors, known.floors, rtol=1e-8)
    for output in ("peak_closing", "peak_contact_force", "impulse"):
        np.testing.assert_allclose(named(found)[output], named(known)[output], rtol=1e-8, atol=1e-9)


MASSES, GAP, SPRING = np.array([200e3, 200e3, 150e3]), 0.004, 5e8
BENT = 1e6 * np.array([[320.0, -180.0, 30.0], [-180.0, 230.0, -90.0], [30.0, -90.0, 65.0]])  # N/m
KEYS = {"stiffness_matrix": BENT.tolist(), "storey_heights": "4 m", "damping_rule": "stiffness"}
HALL = pr.MatrixBuilding("hall", **KEYS, floor_masses=MASSES.tolist())
STRIKE = Case(
    (chain_of(HALL.structure()), single(300e3, 0.3)),
    (meeting(0, 3.0, 1.0, GAP, "linear", stiffness=SPRING, restitution=1.0),),
    Shaking("RSN6-180", 1.5, 4.5, 0.6),
)


def by_scipy(
    ground: np.ndarray, dt: float, inertia: np.ndarray, driven: np.ndarray, shares: tuple[float, ...] = (0.0, 0.0, 1.0)
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, int]:
    """Peaks of the floors, of their drifts and accelerations, the peak force and the contacts of a frame and a mass.

    A spring is between the mass and these ``shares`` of the floors; ``driven`` are the masses that a_g acts on.
    """
    slowest = np.sqrt(eigh(BENT, inertia, eigvals_only=True)[0])
    omega = 2.0 * np.pi / 0.3
    damping = block_diag(2.0 * 0.05 / slowest * BENT, 0.1 * omega * 300e3)
    felt = np.append(np.linalg.solve(inertia, driven), 1.0)
    system = Linear(
        block_diag(inertia, 300e3), block_diag(BENT, omega**2 * 300e3), damping, np.array([[*shares, -1.0]]), SPRING,
        GAP, felt[None],
    )  # fmt: skip
    floors = np.eye(3, 4)
    found = extremes(system, ground, dt, PLACES, [*floors, *np.diff(floors, axis=0, prepend=0.0)])
    largest = np.maximum(found.high, -found.low)
    return largest[:3], largest[3:], found.shaken[:3], found.force.item(), found.contacts


PLACES = 100  # in an interval, at which SciPy's motion is looked at


def test_modes_give_the_results_of_the_matrix():
    """All three modes, of six printed digits: within 1e-4, some times the rounding of 5e-7 that contacts let grow."""
    squares, shapes = eigh(BENT, np.diag(MASSES))
    table = {
        "period": (2.0 * np.pi / np.sqrt(squares)).tolist(),
        "shape": np.round(shapes / np.abs(shapes).max(axis=0), 6).T.tolist(),
    }
    building = pr.ModalBuilding("hall", modes=table, floor_masses=MASSES.tolist(), storey_heights="4 m")
    of_modes = STRIKE._replace(chains=(chain_of(building.structure()), STRIKE.chains[1]))
    modal = chain_of(replace(HALL.structure(), damping_rule="modal"))
    known = by_solver(STRIKE._replace(chains=(modal, STRIKE.chains[1])))
    np.testing.assert_allclose(by_solver(of_modes).floors[:, [0, 1, 3]], known.floors[:, [0, 1, 3]], rtol=1e-4)


# Masses of the frame that are not lumped at its floors.
BOUND = 1e3 * np.array([[180.0, 40.0, 5.0], [40.0, 190.0, 35.0], [5.0, 35.0, 120.0]])  # kg
SLAB = {
    "slab_mass": "150 t",
    "height": "3 m",
    "strength": "400 kN",
    "stiffness": "4 MN/m",
    "yield_displacement": "10 mm",
}
HEAVY = pr.MatrixBuilding("hall", **KEYS, mass_matrix=BOUND.tolist())


OTHERS = (200e3, 260e3, 170e3)


@pytest.mark.parametrize(
    ("frame", "floor", "driven"),
    [(HALL, 3.0, ()), (HEAVY, 3.0, ()), (HEAVY, 2.4, ()), (HEAVY, 3.0, OTHERS), (HEAVY, 2.4, OTHERS)],
)
def test_a_bending_frame_is_that_of_scipy(frame: pr.MatrixBuilding, floor: float, driven: tuple[float, ...]):
    """At its roof and at a column; under a_g on its row sums, and on other masses, as condensed ones are.

    The fastest motion, in contact, passes 0.6 rad an interval: its maximum lies (0.6 / 99)² / 8 = 5e-6 higher.
    """
    shares = (0.0, 0.0, 1.0) if floor == 3.0 else (0.0, 0.6, 0.4)
    inertia = np.diag(MASSES) if frame is HALL else BOUND
    building = replace(frame.structure(), masses=driven) if driven else frame.structure()
    pushed = np.array(driven) if driven else inertia.sum(axis=1)
    ground, dt = STRIKE.shaking.samples()
    peaks, drifts, shakes, force, contacts = by_scipy(ground, dt, inertia, pushed, shares)
    struck = (meeting(0, floor, 1.0, GAP, "linear", stiffness=SPRING, restitution=1.0),)
    run = by_solver(STRIKE._replace(chains=(chain_of(building), STRIKE.chains[1]), meetings=struck))
    assert np.isnan(run.floors[:3, 2]).all() and not np.isnan(run.floors[3, 2])
    assert contacts > 2 and named(run)["impact_count"].item() == contacts
    np.testing.assert_allclose(run.floors[:3, 0], peaks, rtol=5e-6)
    np.testing.assert_allclose(run.floors[:3, 1], drifts, rtol=5e-6)
    np.testing.assert_allclose(run.floors[:3, 3], shakes, rtol=2e-5)
    assert named(run)["peak_contact_force"].item() == pytest.approx(force, rel=5e-6)
    assert abs(run.residual) <= 1e-8 * run.energy


def test_a_frame_that_creeps_against_a_wall_is_that_of_radau():
    """Dampers of two points, at a column and the roof, much quicker than the frame: implicit steps, coupled by M⁻¹.

    Pushed from rest by a constant a_g it touches at once, and by the linear law of one damper on approach. SciPy's
    Radau at 1e-10 on the same equations; the solver's rtol is 1e-8, ten times that is allowed; Radau's
    forces are those at its steps, of 0.2 ms at most, and their peak between two is up to 5e-7 higher.
    """
    stiffness, e, pull, duration = 2e9, 1e-3, -4.0, 0.4
    shares = np.array([[0.0, 0.6, 0.4], [0.0, 0.0, 1.0]])
    damping = 2.0 * 0.05 / np.sqrt(eigh(BENT, BOUND, eigvals_only=True)[0]) * BENT
    effective = 1.0 / np.einsum("ki,ij,kj->k", shares, np.linalg.inv(BOUND), shares)
    ratio = (1.0 - e * e) / (e * (e * (np.pi - 2.0) + 2.0))  # Mahmoud and Jankowski (2011)
    dashpots = 2.0 * ratio * np.sqrt(stiffness * effective)

    def force(y: np.ndarray) -> np.ndarray:
        depth, rate = shares @ y[:3], shares @ y[3:]
        return stiffness * np.maximum(depth, 0.0) + dashpots * np.maximum(rate, 0.0) * (depth >= 0.0)

    def motion(t: float, y: np.ndarray) -> np.ndarray:
        push = damping @ y[3:] + BENT @ y[:3] + shares.T @ force(y) + BOUND.sum(axis=1) * pull
        return np.concatenate([y[3:], -np.linalg.solve(BOUND, push)])

    found = solve_ivp(motion, (0.0, duration), np.zeros(6), "Radau", rtol=1e-10, atol=1e-16, max_step=2e-4)
    walls = (meeting(0, 2.4, 1.0, 0.0, "modified_kelvin_voigt", stiffness=stiffness, restitution=e),
             meeting(0, 3.0, 1.0, 0.0, "modified_kelvin_voigt", stiffness=stiffness, restitution=e))  # fmt: skip
    layout = lay_out((chain_of(HEAVY.structure()), RIGID), points_of(walls), 0.01)
    run = run_row(layout, contacts_of(walls), np.full(round(duration / 0.01) + 1, pull), rtol=1e-8)
    assert run.status == counters.COMPLETE and named(run)["impact_count"].tolist() == [1.0, 1.0]
    np.testing.assert_allclose(run.floors[:, 0], np.abs(found.y[:3]).max(axis=1), rtol=1e-7)
    forces = np.array([force(y) for y in found.y.T])
    np.testing.assert_allclose(named(run)["peak_contact_force"], forces.max(axis=0), rtol=1e-6)
    assert run.steps < 3000  # explicit ones would be some c / m times the duration, 4e6


@pytest.mark.parametrize("name", sweep(LINKED, "hook", "damper", "damper on a brace"))
def test_linked_buildings_with_mass_matrices_are_those_with_masses(name: str):
    """Within 1e-9, ten times rtol, as without links."""
    chains, touching, links = LINKED[name]
    ground, dt = EL_CENTRO._replace(start=1.5, stop=3.5, pga=0.5).samples()
    known = run_linked(linked_row(chains, touching, links), 0.004, ground, dt)
    found = run_linked(linked_row(tuple(map(as_matrices, chains)), touching, links), 0.004, ground, dt)
    assert found.status == counters.COMPLETE
    np.testing.assert_allclose(found.floors[:, [0, 1, 3]], known.floors[:, [0, 1, 3]], rtol=1e-9)
    np.testing.assert_allclose(found.points[:, counters.PEAK_FORCE], known.points[:, counters.PEAK_FORCE], rtol=1e-9)


# Storeys of a frame that yield, beside walls half as stiff that do not: a part of the matrix of both.
PART = np.array([90e6, 60e6, 45e6])  # N/m, of each storey
FORCES = np.array([4e5, 3e5, 2e5])  # N, of the yielding part
OF_STOREYS = {"floor_masses": MASSES.tolist(), "storey_heights": "4 m"}


def dual(form: str, **more: Any) -> Any:
    """Both as storeys of one bilinear law, or by a matrix or modes with a part that yields."""
    if form == "storeys":
        keys = {"storey_stiffnesses": (1.5 * PART).tolist(), "storey_strengths": (1.5 * FORCES).tolist()}
        return pr.ShearBuilding("dual", **OF_STOREYS, **keys | more)
    keys = OF_STOREYS | {"storey_stiffnesses": PART.tolist(), "storey_strengths": FORCES.tolist()}
    whole = chain_of(Storeys("", tuple(MASSES), tuple(1.5 * PART), (4.0,) * 3)).stiffness()
    if form == "matrix":
        return pr.MatrixBuilding("dual", stiffness_matrix=whole.tolist(), **keys | more)
    squares, shapes = eigh(whole, np.diag(MASSES))
    modes = {"period": (2.0 * np.pi / np.sqrt(squares)).tolist(), "shape": shapes.T.tolist()}
    return pr.ModalBuilding("dual", modes=modes, **keys | more)


def beside_a_shed(building: Any, hardening: float | None, **effects: Any) -> Any:
    """A run of it beside a mass, under a strong record."""
    shed = pr.SingleMass("shed", "300 t", "0.3 s", height="12 m")
    contact = pr.Interface("10 mm", "jankowski", "1e10 N/m^1.5", restitution=0.65)
    records = pr.Records(["RSN6-180"], window=["1.5 s", "6 s"], pga="0.6 g")
    effects = ({"inelastic_storeys": {"hardening": hardening}} if hardening is not None else {}) | effects
    return pr.simulate(pr.Scene([building, shed], [contact], records, effects=effects, solver=pr.Solver(rtol=1e-10)))


@pytest.mark.parametrize("more", [{}, {"isolation": SLAB}, {"period": "0.6 s"}], ids=["", "isolated", "at a period"])
@pytest.mark.parametrize("form", ["matrix", "modes"])
def test_a_part_of_a_matrix_that_yields_is_storeys_that_harden(form: str, more: dict[str, Any]):
    """Springs k1 that yield beside k2 = k1 / 2 are one bilinear spring of k1 + k2, of the strength V_y (k1 + k2) / k1.

    Its hardening is (k2 + h k1) / (k1 + k2). Within 1e-8, a hundred times rtol: yielding lets rounding grow.
    """
    h = 0.04
    found = beside_a_shed(dual(form, **more), h, p_delta={})
    stretched = {"storey_strengths": (1.5 * FORCES).tolist()}
    known = beside_a_shed(dual("storeys", **more | stretched), (0.5 + h) / 1.5, p_delta={})
    assert int(known["impact_count"].sum()) > 1 and float(known["storey_ductility"].max()) > 2.0
    of_storeys = ("storey_displacement", "storey_drift", "storey_ductility", "storey_acceleration")
    for name in ("impact_count", "peak_closing", "peak_contact_force", *of_storeys):
        np.testing.assert_allclose(found[name], known[name], rtol=1e-8, atol=1e-12, err_msg=name)
    assert abs(float(found["energy_residual"].max())) < 1e-8


def test_an_elastic_matrix_under_p_delta_is_linked_to_storeys_with_a_law():
    """One body. The spring of its storeys is that of P-delta alone, below zero; no warning is given of it."""
    whole = chain_of(Storeys("", tuple(MASSES), tuple(PART), (4.0,) * 3)).stiffness()
    forms = (
        pr.MatrixBuilding("tower", stiffness_matrix=whole.tolist(), **OF_STOREYS),
        pr.ShearBuilding("tower", storey_stiffnesses=PART.tolist(), **OF_STOREYS),
    )
    contact = pr.Interface("10 mm", "jankowski", "1e10 N/m^1.5", restitution=0.65, link_damping="200 kN s/m")
    records = pr.Records(["RSN6-180"], window=["1.5 s", "4 s"], pga="0.6 g")
    effects: dict[str, Any] = {"inelastic_storeys": {}, "p_delta": {}}
    law = dual("storeys", hysteresis={"rule": "peak_oriented"})
    solver = pr.Solver(rtol=1e-10)
    runs = [pr.simulate(pr.Scene([one, law], [contact], records, effects=effects, solver=solver)) for one in forms]
    assert int(runs[0]["impact_count"].sum()) > 1 and float(runs[0]["storey_ductility"].max()) > 2.0
    for name in ("impact_count", "peak_closing", "storey_displacement", "storey_residual_drift"):
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=1e-7, atol=1e-12, err_msg=name)


def test_a_single_floor_by_a_matrix_is_a_mass_and_with_a_part_that_yields_one_storey():
    """With its own mass matrix it is the mass to the bit; a part of its spring yields as in the building of storeys."""
    keys = {"floor_masses": "400 t", "storey_heights": "12 m", "stiffness_matrix": [[300e6]]}
    one = pr.MatrixBuilding("hall", **keys)
    by_mass = pr.MatrixBuilding("hall", **keys | {"mass_matrix": [[400e3]]})
    runs = [beside_a_shed(building, None) for building in (one, by_mass)]
    for name in runs[0].data_vars:
        np.testing.assert_array_equal(runs[0][name], runs[1][name], err_msg=name)
    part = pr.MatrixBuilding("hall", **keys, storey_stiffnesses="200 MN/m", storey_strengths="800 kN")
    storeys = {"floor_masses": "400 t", "storey_heights": "12 m", "storeys": 1, "storey_stiffnesses": "300 MN/m"}
    whole = pr.ShearBuilding("hall", **storeys, storey_strengths="1200 kN")
    found, known = beside_a_shed(part, 0.05), beside_a_shed(whole, (0.5 + 0.05) / 1.5)
    assert int(known["impact_count"].sum()) > 1 and float(known["storey_ductility"].max()) > 2.0
    for name in ("impact_count", "peak_contact_force", "storey_displacement", "storey_ductility"):
        np.testing.assert_allclose(found[name], known[name], rtol=1e-8, err_msg=name)
