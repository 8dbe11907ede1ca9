"""The reference integrator of rows against what is known without it: the pair's, closed forms, the ledger of energy."""

import math
from typing import Any

import closed_forms as known
import numpy as np
import pytest
from oracle import CONCRETE, WALL, Oscillator, Scene
from oracle import integrate as integrate_pair
from oracle_rows import RIGID, Meeting, Row, Tower, integrate, tower

pytestmark = pytest.mark.complete  # of the integrator of the tests, whose sources are digested with its kept answers
DT = 0.01


def swell(duration: float, peak: float, dt: float = DT) -> np.ndarray:
    """Sines of 0.9, 2.3 and 5.1 Hz that grow, with corners at the samples."""
    t = np.arange(round(duration / dt) + 1) * dt
    waves = np.sin(2 * np.pi * 0.9 * t) + 0.6 * np.sin(2 * np.pi * 2.3 * t + 1.0) + 0.4 * np.sin(2 * np.pi * 5.1 * t)
    a = t * waves
    return a * (peak / np.abs(a).max())


def single(building: Oscillator) -> Tower:
    """One mass as a row has it."""
    if building.period == 0.0:
        return RIGID
    omega = 2.0 * math.pi / building.period
    damping = np.array([[2.0 * building.damping * omega * building.mass]])
    return tower([building.mass], [building.mass * omega**2], damping)


SLENDER = tower([25e3] * 3, [3.46e6] * 3, 0.0191)
STOCKY = tower([90e3, 80e3, 70e3], [9e7, 8e7, 6e7], 0.0015)


@pytest.mark.parametrize(
    "scene",
    [
        Scene(Oscillator(5e5, 0.5), Oscillator(8e5, 1.0), "viscous_elastoplastic", 2.75e9, 0.01, 0.65, 1e6),
        Scene(Oscillator(5e4, 0.1), Oscillator(5e4, 0.5), "kelvin_voigt_tension_cut", 2e9, 0.003, 0.5, 3e5),
        Scene(Oscillator(1e5, 0.6), WALL, "hertz_damp_exact", 4e9, 0.015, CONCRETE),
        Scene(Oscillator(4e4, 0.25), Oscillator(16e4, 1.4), "van_mier", 3e9, 0.01, 0.65, 1e5, 0.5),
    ],
    ids=lambda scene: scene.law,
)
def test_two_single_masses_are_a_pair(scene: Scene):
    """Both integrate at rtol 1e-12; some thousand steps add up to 1e-10."""
    ground = swell(4.0, 4.0)
    meeting = Meeting(0, 1.0, 1.0, scene.gap, *_contact(scene))
    true = integrate_pair(scene, ground, DT)
    found = integrate([single(scene.left), single(scene.right)], [meeting], ground, DT)
    assert true["impact_count"] >= 3
    for name, value in found.points.items():
        if name in true and name not in ("lowest_contact_force", "energy_viscous"):
            assert value[0] == pytest.approx(true[name], rel=1e-9, nan_ok=True), name
    # Differences of large numbers: against those.
    force, depth = true["peak_contact_force"], true["peak_penetration"]
    for name, whole in (("lowest_contact_force", force), ("energy_viscous", force * depth)):
        assert found.points[name][0] == pytest.approx(true[name], abs=1e-9 * whole), name
    for row, side in zip(found.floors, ("left", "right"), strict=False):
        assert row[0] == pytest.approx(true[f"peak_displacement_{side}"], rel=1e-9)
        assert row[3] == pytest.approx(true[f"peak_floor_acceleration_{side}"], rel=1e-9)


def _contact(scene: Scene) -> tuple[Any, ...]:
    return scene.law, scene.stiffness, scene.restitution, scene.yield_force, scene.plastic_exponent, scene.fastest


@pytest.mark.parametrize("hardening", [0.0, 0.05, 0.4])
def test_a_yielding_storey_goes_where_its_energy_ends(hardening: float):
    """a_g at a step from rest, no damping: m |a_g| u = area under V(u) at the first, largest displacement."""
    mass, stiffness, strength, pull = 1e4, 4e6, 3e4, 2.0
    chain = tower([mass], [stiffness], strength=np.array([strength]), hardening=hardening)
    found = integrate([chain], [], np.full(41, -pull), DT)
    d = strength / stiffness
    # F d/2 + F (u − d) + h k (u − d)²/2 = m p u, for x = u − d
    a, b, c = 0.5 * hardening * stiffness, strength - mass * pull, 0.5 * strength * d - mass * pull * d
    x = -c / b if a == 0.0 else (-b + math.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    assert found.floors[0, 0] == pytest.approx(d + x, rel=1e-10)
    assert found.floors[0, 2] == pytest.approx(strength + hardening * stiffness * x, rel=1e-10)
    assert found.rest[0, 1] == pytest.approx(x, rel=1e-9)
    assert abs(found.open_energy) < 1e-11


def test_a_column_meets_a_wall_with_the_mass_of_its_point():
    """0.3 up the storey between two free masses: 1/m = 0.3²/m_2 + 0.7²/m_1, and Hertz's closed form for it."""
    masses, share, speed = (3e4, 5e4), 0.3, 0.4
    row = Row([tower(masses, (1e-9, 1e-9)), RIGID], [Meeting(0, 1.0 + share, 1.0, 0.0, "hertz", 2e9)])
    row.state[2:4] = speed
    found = row.go(np.zeros(11), 0.02)
    mass = 1.0 / (share**2 / masses[1] + (1.0 - share) ** 2 / masses[0])
    depth, force, duration = known.hertz_impact(2e9, mass, speed)
    assert found.points["peak_penetration"][0] == pytest.approx(depth, rel=1e-10)
    assert found.points["peak_contact_force"][0] == pytest.approx(force, rel=1e-10)
    assert found.points["contact_time"][0] == pytest.approx(duration, rel=1e-10)
    # What the wall gives is shared as a lever shares it: m_1 Δv_1 = −0.7 I, m_2 Δv_2 = −0.3 I, I = 2 m v.
    impulse = 2.0 * mass * speed
    assert found.state[2:] == pytest.approx(
        [speed - 0.7 * impulse / masses[0], speed - 0.3 * impulse / masses[1]], rel=1e-9
    )


ROWS = {
    "storeys and columns": (
        [SLENDER, STOCKY],
        [Meeting(0, f, g, 0.01, "jankowski", 2.75e9, CONCRETE) for f, g in ((0.8, 1.0), (1.0, 1.3), (2.3, 3.0))],
    ),
    "yielding storeys": (
        [SLENDER._replace(strength=np.full(3, 1.2e5), hardening=0.03), STOCKY],
        [Meeting(0, f, f, 0.01, "viscous_elastoplastic", 2.75e9, 0.65, 8e5) for f in (1.0, 2.0, 3.0)],
    ),
    "four in a row": (
        [SLENDER, single(Oscillator(9e4, 0.3)), STOCKY, RIGID],
        [
            Meeting(i, *floors, 0.008, "kelvin_voigt_tension_cut", 3e8, 0.5, 4e5)
            for i, floors in enumerate(((3.0, 1.0), (1.0, 3.0), (3.0, 1.0)))
        ],
    ),
}


@pytest.mark.parametrize("name", ROWS)
def test_energy_closes_and_tolerances_agree(name: str):
    """Every joule put in is moved, stored, damped or taken by contacts and storeys; rtol 1e-10 moves peaks by 1e-8."""
    towers, meetings = ROWS[name]
    ground = swell(3.0, 5.0)
    fine, coarse = (integrate(towers, meetings, ground, DT, rtol) for rtol in (1e-12, 1e-10))
    assert abs(fine.open_energy) < 1e-11
    assert fine.points["impact_count"].max() >= 3
    np.testing.assert_array_equal(fine.points["impact_count"], coarse.points["impact_count"])
    np.testing.assert_allclose(coarse.floors, fine.floors, rtol=1e-8)
    np.testing.assert_allclose(coarse.points["peak_contact_force"], fine.points["peak_contact_force"], rtol=1e-8)
