"""Isolated buildings against the reference integrator of rows, closed forms and the ledger of energy.

M ü + C u̇ + K u + e_1 V(u_1) = −M 1 a_g(t),     V elastic about its plastic offset, V = k_2 u ± Q_d past it
"""

from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from oracle_rows import Meeting, Tower, integrate, tower
from scenes import rigid, scene_text, storeyed
from scipy.linalg import eigh

import pounding_risk as pr
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.scene.reader import parse_scene

G = 9.80665  # m/s²
LEAD = {
    "slab_mass": "600 t",
    "height": "1.5 m",
    "strength": "900 kN",
    "stiffness": "5 MN/m",
    "yield_displacement": "10 mm",
    "damping": "200 kN s/m",
}
SLIDER = {"slab_mass": "600 t", "height": "1.5 m", "friction": 0.05, "radius": "2 m"}
SHAKEN = {"window": ["0 s", "8 s"], "pga": "0.5 g"}
STILL = {"names": None, "generated": [{"kind": "still", "duration": "9 s", "step": "0.01 s"}]}


def isolated(isolation: dict[str, Any], **more: Any) -> dict[str, Any]:
    return storeyed("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m", isolation=isolation, **more)


def scene(building: dict[str, Any], gap: str = "9 m", **tables: Any) -> Any:
    return parse_scene(scene_text(rigid(height="1.5 m"), building, gap=gap, records=SHAKEN, **tables))


def shaken(run: Any) -> tuple[np.ndarray, float]:
    """The scaled record at its own samples, 10 ms apart: the times of a run have those of its events too."""
    times = run["time"].values
    even = 0.01 * np.arange(round(times[-1] / 0.01) + 1)
    return np.interp(even, times, run["ground_acceleration"].values.ravel()), 0.01


def tower_of(building: Any, law: tuple[float, float, float]) -> Tower:
    """For the reference, with ``law`` = (Q_d, k_2, u_y) from the numbers of its scene."""
    strength, soft, limit = law
    stiff = soft + strength / limit
    strengths = np.array([stiff * limit, *[inf] * (len(building.masses) - 1)])
    springs = [stiff, *building.stiffnesses[1:]]
    return tower(building.masses, springs, chain_of(building).damping, strength=strengths, hardening=soft / stiff)


@pytest.mark.parametrize(
    ("isolation", "law"),
    [(LEAD, (900e3, 5e6, 0.01)), (SLIDER, (0.05 * 1.5e6 * G, 1.5e6 * G / 2.0, 1e-3))],
    ids=["lead", "slider"],
)
def test_under_an_earthquake_it_is_the_reference(isolation, law):
    """Both are exact between events but for rounding, ten times the reference's 1e-12, and again for accelerations."""
    study = scene(isolated(isolation))
    run = pr.simulate(study).sel(building="A")
    known = integrate([tower_of(study.buildings[1], law)], [], *shaken(run))
    for column, name in enumerate(("storey_displacement", "storey_drift", "storey_shear", "storey_acceleration")):
        np.testing.assert_allclose(run[name].values[:3], known.floors[:, column], rtol=1e-11 if column < 3 else 1e-10)
    assert float(run["storey_ductility"][0]) > 2.0


# ------------------------------------------------------------------------------------------------ closed forms

MU, RADIUS = 0.05, 2.0


def pendulum(yield_displacement: float, records: dict[str, Any] = STILL, **more: Any) -> Any:
    """One mass of 1000 t on friction pendulums: a floor of 1 kg, at 100 rad/s, changes peaks by less than 1e-9."""
    isolation = {"slab_mass": "999999 kg", "height": "1.5 m", "friction": MU, "radius": f"{RADIUS} m"}
    isolation |= {"yield_displacement": f"{yield_displacement} m"}
    building = storeyed("A", ["1 kg"], "10 kN/m", "4 m", damping=0.0, isolation=isolation, **more)
    return parse_scene(scene_text(rigid(height="1.5 m"), building, gap="9 m", records=records))


def turns(run: Any) -> tuple[np.ndarray, np.ndarray]:
    """Times and displacements of the turns: while it slides it is a harmonic motion about ∓ μ R."""
    omega = sqrt(G / RADIUS)
    u, v = (run[name].values[:, 1, 0] for name in ("displacement", "velocity"))
    last = np.flatnonzero((v[:-1] * v[1:] < 0.0) & (np.abs(u[:-1]) > MU * RADIUS))
    side = np.sign(v[last])
    from_middle, speed = u[last] + side * MU * RADIUS, v[last] / omega
    times = run["time"].values[last] + np.arctan2(side * speed, side * from_middle) / omega
    return times, side * np.hypot(from_middle, speed) - side * MU * RADIUS


@pytest.mark.parametrize("limit", [1e-3, 1e-8])
def test_a_free_pendulum_has_its_period_and_its_decay(limit):
    """Between turns A and B: A − B = 2 μ R (1 − 2 u_y / (A + B)), by the work of the force along the branch.

    A half cycle lasts π √(R / g) where u_y is 0; with 1e-8 m the elastic part of it lasts some 0.3 ms.
    """
    times, peaks = turns(pr.simulate(pendulum(limit, initial_velocity="1.5 m/s")))
    before, after = np.abs(peaks[:-1]), np.abs(peaks[1:])
    assert before.size >= 2 and (np.diff(np.sign(peaks)) != 0.0).all()
    decay = 2.0 * MU * RADIUS * (1.0 - 2.0 * limit / (before + after))
    assert before - after == pytest.approx(decay, abs=1e-9)
    if limit < 1e-6:
        assert np.diff(times) == pytest.approx(pi * sqrt(RADIUS / G), rel=2e-4)


def test_a_steady_cycle_takes_the_area_of_its_loop():
    """4 Q_d (D − u_y) is the work of the ground over a cycle; the trapezoidal rule at 1 ms is good to 1e-5 at kinks."""
    motion = {"kind": "harmonic", "pga": "1 m/s^2", "period": "2 s", "cycles": 40.0, "step": "1 ms"}
    run = pr.simulate(pendulum(1e-3, records={"names": None, "generated": [motion]}))
    cycle = slice(78_000, 80_000)
    u, v = (run[name].values[cycle, 1, 0] for name in ("displacement", "velocity"))
    work = -1e6 * np.sum(run["ground_acceleration"].values.ravel()[cycle] * v) * 1e-3
    assert work == pytest.approx(4.0 * MU * 1e6 * G * (np.abs(u).max() - 1e-3), rel=1e-4)


# ------------------------------------------------------------------------------------------------ with contact


def by_hand(isolation: dict[str, Any], **more: Any) -> dict[str, Any]:
    """The same building with its slab and isolators among its storeys."""
    stiff = 5e6 + 900e3 / 0.01
    springs = [f"{stiff!r} N/m", "800 MN/m", "600 MN/m"]
    strengths = [f"{stiff * 0.01!r} N", *(more.pop("storey_strengths", None) or ["inf", "inf"])]
    return storeyed(
        "A", ["600 t", "500 t", "400 t"], springs, ["1.5 m", "4 m", "4 m"], storey_strengths=strengths, **more
    )


@pytest.mark.parametrize("strengths", [None, ["7 MN", "4 MN"]], ids=["elastic above", "yielding above"])
@pytest.mark.parametrize("gap", ["0 mm", "60 mm"])
def test_against_its_wall_it_is_the_storeys_by_hand_that_other_tests_hold_to_the_oracle(gap, strengths):
    """To the bit, peaks, contacts and energies; the wall is as tall as the slab, so that the slab alone strikes it."""
    undamped = {key: value for key, value in LEAD.items() if key != "damping"}
    inelastic = {"inelastic_storeys": {"hardening": 5e6 / (5e6 + 900e3 / 0.01)}}
    more = {"damping": 0.0} | ({"storey_strengths": strengths} if strengths else {})
    one = pr.simulate(scene(isolated(undamped, **more), gap, effects=inelastic if strengths else None))
    other = pr.simulate(scene(by_hand(undamped, **more), gap, effects=inelastic))
    assert int(one["impact_count"].sum()) > 0 and one.sizes["contact_point"] == 1
    for name in one.data_vars:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


@pytest.mark.parametrize("isolation", [LEAD, SLIDER], ids=["lead", "slider"])
@pytest.mark.parametrize("gap", ["0 mm", "60 mm"])
def test_no_energy_is_lost_at_the_wall(isolation, gap):
    """At rtol 1e-6 contacts leave some 1e-6 of the energy; the other tests of rows allow 1e-5."""
    run = pr.simulate(scene(isolated(isolation), gap))
    assert int(run["impact_count"].sum()) > 0
    assert np.abs(run["energy_residual"].values).max() < 1e-5


def without_springs(form: str) -> dict[str, Any]:
    """The building of two storeys on fixed ground by its matrix, or by both of its modes."""
    spring = np.array([[1400e6, -600e6], [-600e6, 600e6]])
    keys = {"name": "A", "floor_masses": ["500 t", "400 t"], "storey_heights": "4 m"}
    if form == "matrix":
        return keys | {"stiffness_matrix": {"values": spring.tolist(), "unit": "N/m"}}
    squares, shapes = eigh(spring, np.diag([500e3, 400e3]))
    return keys | {"modes": {"period": [f"{2.0 * pi / sqrt(one)!r} s" for one in squares], "shape": shapes.T.tolist()}}


@pytest.mark.parametrize("form", ["matrix", "modes"])
def test_by_a_matrix_or_modes_it_is_the_building_of_storeys(form):
    """Within 1e-9, ten times rtol; shears above the isolators, and with them the largest, are not known."""
    begun = {"initial_displacement": ["5 mm", "10 mm", "15 mm"]}
    built = without_springs(form) | begun | {"isolation": LEAD}
    solver = {"rtol": 1e-10}
    one, other = (pr.simulate(scene(given, "60 mm", solver=solver)) for given in (isolated(LEAD, **begun), built))
    assert int(one["impact_count"].sum()) > 1 and int(other["impact_count"].sum()) == int(one["impact_count"].sum())
    for name in ("storey_displacement", "peak_contact_force", "impulse", "storey_ductility", "storey_acceleration"):
        known = one[name].values
        np.testing.assert_allclose(other[name].values, known, rtol=0.0, atol=1e-9 * np.nanmax(np.abs(known)))
    shear = other["storey_shear"].sel(building="A").values
    assert shear[0] == pytest.approx(float(one["storey_shear"].sel(building="A")[0]), rel=1e-9)
    assert np.isnan(shear[1:]).all() and np.isnan(other["peak_storey_shear"].sel(building="A"))


def test_a_wall_that_gives_is_the_reference():
    """Slab, floor and a wall on a bilinear spring, contact by a linear one: to what the project promises of peaks."""
    isolation = {key: value for key, value in LEAD.items() if key != "damping"}
    wall = storeyed("wall", ["40 t"], ["60 MN/m"], ["1.5 m"], storey_strengths=["900 kN"], damping=0.0)
    building = storeyed("A", ["900 t"], ["800 MN/m"], "4 m", isolation=isolation, damping=0.0)
    inelastic = {"inelastic_storeys": {"hardening": 0.05}}
    keys = {"law": "linear", "stiffness": "1500 MN/m", "gap": "60 mm", "effects": inelastic, "solver": {"rtol": 1e-9}}
    study = parse_scene(scene_text(wall, building, records=SHAKEN, **keys))
    run = pr.simulate(study)
    gives = tower([40e3], [60e6], strength=np.array([900e3]), hardening=0.05)
    meeting = Meeting(0, 1.0, 1.0, 0.06, "linear", 1500e6, 1.0)
    towers = [gives, tower_of(study.buildings[1], (900e3, 5e6, 0.01))]
    known = integrate(towers, [meeting], *shaken(run), 1e-11)
    for column, name in enumerate(("storey_displacement", "storey_drift", "storey_shear", "storey_acceleration")):
        found = run[name].sel(building="wall").values[:1], run[name].sel(building="A").values[:2]
        np.testing.assert_allclose(np.concatenate(found), known.floors[:, column], rtol=1e-6)
    assert run["impact_count"].item() == known.points["impact_count"][0] > 2
    assert run["peak_contact_force"].item() == pytest.approx(known.points["peak_contact_force"][0], rel=1e-6)
    assert float(run["storey_ductility"].sel(building="wall")[0]) > 1.5
