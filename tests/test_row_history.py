"""Histories of a row's run: forces from the momentum of the floors, against forces that an integrator knows."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk.chains import Chain
from pounding_risk.cli import app
from pounding_risk.contact_points import Point
from pounding_risk.row_history import closing_of, contact_forces, storey_shears
from pounding_risk.row_model import RowModel

STIFF, GAP = 4e7, 0.004  # N/m and m, of two springs between the buildings
CHAINS = [
    Chain(np.array([4e4, 4e4, 3e4]), np.array([3e7, 2.5e7, 2e7]), np.array([3e7, 2.5e7, 2e7]), 4e4 * np.eye(3),
          np.full(3, np.inf), 0.0, 0),
    Chain(np.array([5e4, 5e4]), np.array([6e7, 6e7]), np.array([6e7, 6e7]), 3e4 * np.eye(2),
          np.full(2, np.inf), 0.0, 0),
]  # fmt: skip
POINTS = [Point(0, 1.0, 0.8, "column", 3.2), Point(0, 2.5, 2.0, "column", 8.0)]
SCENE = """
[scene]
name = "Two and a wall"
[[building]]
name = "tall"
storeys = 3
floor_masses = "40 t"
storey_stiffnesses = "30 MN/m"
storey_heights = "3 m"
[[building]]
name = "low"
mass = "60 t"
period = "0.2 s"
height = "6 m"
[[interface]]
gap = "5 mm"
contact_model = "linear"
stiffness = "80 MN/m"
[records]
names = ["RSN6-180"]
window = ["0 s", "4 s"]
"""


def matrices() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses, damping and stiffness of both buildings, by hand."""
    mass = np.concatenate([chain.mass for chain in CHAINS])
    damping, stiffness = np.zeros((5, 5)), np.zeros((5, 5))
    for first, chain in ((0, CHAINS[0]), (3, CHAINS[1])):
        for place, spring in enumerate(chain.spring):
            at = first + place
            damping[at, at] = chain.damping[place, place]
            stiffness[at, at] += spring
            if place:
                stiffness[at - 1, at - 1] += spring
                stiffness[at, at - 1] -= spring
                stiffness[at - 1, at] -= spring
    return mass, damping, stiffness


def test_a_floor_number_closes_by_the_floors_beside_it():
    closing = closing_of(RowModel(CHAINS, POINTS))
    # 0.8 up the first storey of the right one: 0.8 of its first floor; 2.5: half of floors 2 and 3.
    np.testing.assert_allclose(closing, [[1.0, 0.0, 0.0, -0.8, 0.0], [0.0, 0.5, 0.5, 0.0, -1.0]], atol=1e-15)


def test_forces_follow_from_the_momentum_of_the_floors():
    """Springs between two buildings, integrated by SciPy, whose force is known from the displacements."""
    model = RowModel(CHAINS, POINTS)
    closing = closing_of(model)
    mass, damping, stiffness = matrices()
    step = 2.5e-4
    time = np.arange(0.0, 2.0, step)

    def ground(t: float) -> float:
        return 5.0 * np.sin(9.0 * t)

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        u, v = state[:5], state[5:]
        force = STIFF * np.maximum(closing @ u - GAP, 0.0)
        return np.concatenate([v, (-damping @ v - stiffness @ u - closing.T @ force) / mass - ground(t)])

    solved = solve_ivp(rates, (0.0, time[-1]), np.zeros(10), "DOP853", time, rtol=1e-9, atol=1e-12, max_step=1e-3)
    states = solved.y.T.reshape(-1, 2, 5)
    acceleration = 5.0 * np.sin(9.0 * time)
    found = contact_forces(model, states, (acceleration, step), closing, np.full(2, GAP))
    known = STIFF * np.maximum(states[:, 0] @ closing.T - GAP, 0.0)
    mean = np.concatenate([np.zeros((1, 2)), 0.5 * (known[1:] + known[:-1])])
    assert (known.max(axis=0) > 1e5).all()
    # The trapezoidal rule is off by the curvature of forces that last 20 ms and more, over 0.25 ms.
    np.testing.assert_allclose(found, mean, atol=2e-3 * known.max())
    np.testing.assert_allclose(found.sum(axis=0), known.sum(axis=0), rtol=1e-3)


def test_shears_of_yielding_storeys_follow_their_loop():
    """One cycle of a bilinear spring: F = k d to the strength, then the hardening stiffness, back along k."""
    stiffness, strength, hardening = 1e6, 1e4, 0.1
    chain = Chain(*(np.array([each]) for each in (1.0, stiffness, stiffness)), np.zeros((1, 1)), np.array([strength]),
                  hardening, 0)  # fmt: skip
    drift = np.array([0.0, 0.005, 0.01, 0.03, 0.02, 0.01, -0.02])
    # Past yield F = 1e4 + 1e5 (d − 0.01); from 0.03 (1.2e4) back by k over 0.02, then on along the lower line.
    wanted = [0.0, 5e3, 1e4, 1.2e4, 2e3, -8e3, -1.1e4]
    np.testing.assert_allclose(storey_shears(chain, drift[:, None])[:, 0], wanted, rtol=1e-12)


@pytest.mark.slow
def test_a_run_of_a_row_tells_what_its_tally_has(tmp_path):
    """Compiles the row solver under the linear law."""
    path = tmp_path / "row.toml"
    path.write_text(SCENE, "utf-8")
    run = pr.simulate(path)
    assert list(run["building"].values) == ["tall", "low"]
    step = float(run["time"][1] - run["time"][0])
    assert step <= 1e-3
    force = run["contact_force"].values
    impulse = run["contact_point_impulse"].values
    assert (run["contact_point_impact_count"].values > 0).any()
    # What the floors' momentum gives, by the trapezoidal rule, is what was integrated in contact.
    np.testing.assert_allclose(force.sum(axis=0) * step, impulse, rtol=2e-2, atol=1e-3 * impulse.max())
    np.testing.assert_allclose(force.max(axis=0), run["contact_point_peak_contact_force"], rtol=3e-2)  # a mean of 1 ms
    peak = np.abs(run["displacement"]).max(("time", "storey"))
    np.testing.assert_allclose(peak, run["peak_displacement"], rtol=1e-3)  # between instants
    told = CliRunner().invoke(app, ["simulate", str(path), "-o", str(tmp_path / "run.nc")])
    assert told.exit_code == 0, told.output
    assert re.search(r"tall \| low +5 mm +\d+", told.output)
    drawn = CliRunner().invoke(app, ["draw", str(tmp_path / "run.nc"), "--animation", str(tmp_path / "run.html")])
    assert drawn.exit_code == 0, drawn.output
    refused = CliRunner().invoke(app, ["simulate", str(path), "--figure", str(tmp_path / "run.png")])
    assert refused.exit_code == 2
    assert "this scene is a row" in refused.stderr
