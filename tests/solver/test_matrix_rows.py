"""Buildings by matrices and modes in rows: chains written in these forms, and a frame that is no chain.

Oracles: the integrator in physical coordinates by which chains are held, whose kept answers the same chains must have
when they are written as matrices; and SciPy's DOP853 on the equations of a bending frame, written down here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kept_references import reference
from oracle_springs import Linear, segments
from row_cases import CASES, Case, Shaking, by_solver, meeting, named, single
from scipy.linalg import block_diag, eigh
from test_rows_against_scipy import differences

import pounding_risk as pr
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.solver import counters

ELASTIC = [name for name, case in CASES.items() if not any(np.isfinite(c.strength).any() for c in case.chains)]


def as_matrix(chain: Chain) -> Chain:
    """The same building without storey springs."""
    if chain.mass.size < 2:
        return chain
    nothing = np.zeros(chain.mass.size)
    return chain._replace(spring=nothing, shear=nothing, coupling=chain.stiffness())


@pytest.mark.parametrize("name", ELASTIC)
def test_chains_as_matrices_agree_with_scipy_and_with_chains(name: str):
    """To the tolerances of chains against SciPy; to the chain itself within 1e-9, ten times the solver's rtol of 1e-10.

    Both take the same steps but for rounding, which contacts that follow each other let grow.
    """
    case = CASES[name]
    chain = by_solver(case, 1e-10)
    run = by_solver(case._replace(chains=tuple(map(as_matrix, case.chains))), 1e-10)
    assert run.status == counters.COMPLETE
    true = reference(case.chains, case.meetings, *case.shaking.samples())
    late = np.nan_to_num(np.abs(named(run)["first_impact_time"] - true.points["first_impact_time"]))
    assert differences(named(run), true.points, late) == {}
    moves = [0, 1, 3]  # of u, drift, shear, acceleration: there is no storey whose shear there would be
    np.testing.assert_allclose(run.floors[:, moves], true.floors[:, moves], rtol=1e-6)
    np.testing.assert_allclose(run.floors[:, moves], chain.floors[:, moves], rtol=1e-9)
    for output in ("peak_closing", "peak_contact_force", "impulse"):
        np.testing.assert_allclose(named(run)[output], named(chain)[output], rtol=1e-9, atol=1e-9)


MASSES, GAP, SPRING = np.array([200e3, 200e3, 150e3]), 0.004, 5e8
BENT = 1e6 * np.array([[320.0, -180.0, 30.0], [-180.0, 230.0, -90.0], [30.0, -90.0, 65.0]])  # N/m
HALL = pr.MatrixBuilding(
    "hall", stiffness_matrix=BENT.tolist(), floor_masses=MASSES.tolist(), storey_heights="4 m", damping_rule="stiffness"
)
STRIKE = Case(
    (chain_of(HALL.structure()), single(300e3, 0.3)),
    (meeting(0, 3.0, 1.0, GAP, "linear", stiffness=SPRING, restitution=1.0),),
    Shaking("RSN6-180", 1.5, 4.5, 0.6),
)


def by_scipy(ground: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, float, int]:
    """Peaks of the floors, of their drifts, the peak force and the contacts: roof against a mass, a spring between."""
    slowest = np.sqrt(np.linalg.eigvals(BENT / MASSES[:, None]).real.min())
    omega = 2.0 * np.pi / 0.3
    damping = block_diag(2.0 * 0.05 / slowest * BENT, 0.1 * omega * 300e3)
    shares = np.array([[0.0, 0.0, 1.0, -1.0]])
    system = Linear(np.append(MASSES, 300e3), block_diag(BENT, omega**2 * 300e3), damping, shares, SPRING, GAP)
    peaks, drifts, force, contacts, closed = np.zeros(3), np.zeros(3), 0.0, 0, False
    for _, path, forces in segments(system, ground, dt, PLACES):
        peaks = np.maximum(peaks, np.abs(path[:3]).max(axis=1))
        drifts = np.maximum(drifts, np.abs(np.diff(path[:3], axis=0, prepend=0.0)).max(axis=1))
        force = max(force, float(forces.max()))
        contacts += forces.any() and not closed
        closed = bool(forces.any())
    return peaks, drifts, force, contacts


PLACES = 100  # in an interval, at which SciPy's motion is looked at


def test_a_bending_frame_is_that_of_scipy():
    """The fastest motion, in contact, passes 0.6 rad an interval: its maximum lies (0.6 / 99)² / 8 = 5e-6 higher."""
    ground, dt = STRIKE.shaking.samples()
    peaks, drifts, force, contacts = by_scipy(ground, dt)
    run = by_solver(STRIKE)
    assert contacts > 3 and named(run)["impact_count"].item() == contacts
    np.testing.assert_allclose(run.floors[:3, 0], peaks, rtol=5e-6)
    np.testing.assert_allclose(run.floors[:3, 1], drifts, rtol=5e-6)
    assert named(run)["peak_contact_force"].item() == pytest.approx(force, rel=5e-6)
    assert np.isnan(run.floors[:3, 2]).all() and not np.isnan(run.floors[3, 2])


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
