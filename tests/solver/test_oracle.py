"""The tests' own integrators of pairs and rows against closed forms, energy and each other."""

import ast
import math
from pathlib import Path
from typing import Any

import closed_forms as known
import numpy as np
import oracle
import oracle_rows
import pytest
from oracle import CONCRETE, WALL, Oscillator, Scene, integrate
from oracle_flight import Curve, first_touch, highest
from oracle_rows import RIGID, Meeting, Row, Tower, tower
from scipy.linalg import expm

from pounding_risk.models.contact.laws import LAWS
from pounding_risk.studies.impact import impact

pytestmark = pytest.mark.complete  # of the integrator of the tests, whose sources are digested with its kept answers
LEFT, RIGHT = Oscillator(44.36e3, 0.208), Oscillator(82.60e3, 0.007)
MASS = 1.0 / (1.0 / LEFT.mass + 1.0 / RIGHT.mass)
STIFFNESS = {law: 1e9 if law in oracle.LINEAR else 4.2e10 for law in oracle.LAWS}
CAPPED = ("van_mier", "viscous_elastoplastic")


def test_the_oracle_shares_nothing_with_the_solver():
    for file in Path(__file__).parents[1].glob("oracle*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.startswith("pounding_risk") for name in names), file


# ---------------------------------------------------------------------------------------- isolated impacts
@pytest.mark.parametrize("e", [0.05, 0.1, 0.25, 0.4, 0.5, 0.65, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("law", oracle.LAWS)
def test_an_impact_is_that_of_the_solver_which_is_held_to_closed_forms(law: str, e: float):
    """Of every law in tests/models/test_conformance.py, under a cap in tests/studies/test_impact.py."""
    speed = 0.5
    for cap in (math.inf, 2e4, 2e5, 1e6, 2.8e6) if law in CAPPED else (math.inf,):
        scene = Scene(LEFT, RIGHT, law, STIFFNESS[law], restitution=e, yield_force=cap)  # type: ignore[arg-type]
        found = oracle.impact(scene, speed)
        known = impact(LAWS[law](STIFFNESS[law]), speed, LEFT.mass, RIGHT.mass, restitution=e, yield_force=cap)
        assert found["restitution"] == pytest.approx(known.restitution, abs=1e-11)
        outputs = ("peak_penetration", "peak_contact_force", "duration", "impulse")
        values = known.peak_penetration, known.peak_force, known.duration, known.impulse
        assert [found[name] for name in outputs] == pytest.approx(values, rel=1e-10)
        assert found["energy_lost"] == pytest.approx(known.energy_lost, abs=1e-10 * MASS)
        if e > 0.1:  # below, Kelvin and Voigt's pull is largest between two steps of the solver
            near = 1e-11 * known.peak_force  # where a law does not pull, both land so near zero
            assert found["lowest_contact_force"] == pytest.approx(min(known.force.min(), 0.0), rel=1e-10, abs=near)
        velocities = speed - known.impulse / LEFT.mass, known.impulse / RIGHT.mass
        assert (found["velocity_left"], found["velocity_right"]) == pytest.approx(velocities, abs=1e-11)
        assert found["yield_count"] == float(known.peak_force == cap)
        if law == "van_mier":
            assert found["peak_uncapped_force"] == pytest.approx(4.2e10 * known.peak_penetration**1.5, rel=1e-10)


# ----------------------------------------------------------------------------------- free vibration, forced
def record(seed: int = 1, count: int = 400, dt: float = 0.01) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=count) * np.sin(np.pi * np.arange(count) / (count - 1)) * 3.0


def by_matrix_exponential(period: float, damping: float, a: np.ndarray, dt: float, parts: int) -> np.ndarray:
    """u, ü + a_g at ``parts`` points of every sample, from expm of the state with the ramp appended."""
    omega = 2.0 * math.pi / period
    system = np.array(
        [[0, 1, 0, 0], [-(omega**2), -2 * damping * omega, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float
    )
    step = expm(system * dt / parts)
    y, rows = np.zeros(4), []
    for k in range(len(a) - 1):
        y[2:] = a[k], (a[k + 1] - a[k]) / dt
        for _ in range(parts):
            y = step @ y
            rows.append((y[0], -2 * damping * omega * y[1] - omega**2 * y[0]))
    return np.array(rows)


@pytest.mark.parametrize("period", [0.007, 0.1, 0.5, 2.0])
def test_free_response_between_samples(period: float):
    """A far neighbour: peaks against a matrix exponential at 400 points of each sample."""
    a, dt, parts = record(), 0.01, 400
    found = integrate(Scene(Oscillator(1e5, period), oracle.WALL, "hertz", 1e9, gap=1e3), a, dt)
    rows = by_matrix_exponential(period, 0.05, a, dt, parts)
    peaks = np.abs(rows).max(axis=0)
    # A point lies within dt/800 of the top, so it is short of it by at most ½ (ω dt/800)² of the motion.
    short = 0.5 * (2.0 * math.pi / period * dt / 800) ** 2 + 1e-11
    for name, peak in zip(("peak_displacement_left", "peak_floor_acceleration_left"), peaks, strict=True):
        assert peak * (1.0 - 1e-11) <= found[name] <= peak * (1.0 + 3.0 * short)
    assert found["peak_relative_displacement"] == found["peak_displacement_left"]
    assert found["impact_count"] == 0 and math.isnan(found["first_impact_time"])


def test_linear_contact_is_a_chain_of_linear_oscillators():
    """Linear spring and a wall: two linear systems in turn, stepped by matrix exponentials."""
    a, dt, parts, mass, k = record(3, 200), 0.01, 4000, 1e5, 4e7
    scene = Scene(Oscillator(mass, 0.4), oracle.WALL, "linear", k, gap=0.004)
    found = integrate(scene, a, dt)
    omega, touching = 2.0 * math.pi / 0.4, False
    free = np.array([[0, 1, 0, 0], [-(omega**2), -0.1 * omega, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float)
    pressed = free.copy()
    pressed[1, 0] -= k / mass
    pressed = np.vstack([np.hstack([pressed, [[0], [k / mass * 0.004], [0], [0]]]), np.zeros(5)])
    steps = [expm(np.pad(free, (0, 1)) * dt / parts), expm(pressed * dt / parts)]
    y, top, count = np.array([0.0, 0, 0, 0, 1]), 0.0, 0
    for i in range(len(a) - 1):
        y[2:4] = a[i], (a[i + 1] - a[i]) / dt
        for _ in range(parts):
            count += not touching and y[0] > 0.004
            touching = y[0] > 0.004
            y = steps[int(touching)] @ y
            top = max(top, abs(y[0]))
    # The switch comes up to one step of 2.5 µs late: an error of 2.5e-6 (k/m)^½ ≈ 5e-5 at worst.
    assert found["impact_count"] == count and count >= 3
    assert found["peak_displacement_left"] == pytest.approx(top, rel=5e-5)
    assert found["energy_viscous"] == pytest.approx(0.0, abs=1e-6)


# --------------------------------------------------------------------------------------------- the searches
def test_a_double_touch_within_a_sample_is_found():
    """A fast ripple on a slow wave rises above zero twice between two samples."""
    ripple = complex(-0.05, 1.0) * 900.0
    depth = Curve(-1e-3, 0.0, ((1.05e-3 + 0j, ripple),))
    # At t = 0 it presses already; seen from just after, the next local maximum is lower than 1e-3.
    assert first_touch(Curve(-1e-3, 0.0, ((0.9e-3 + 0j, ripple),)), 0.05) is None
    late = Curve(-1e-3, 0.0, ((0.9e-3j, complex(2.0, 900.0)),))
    touch = first_touch(late, 0.1)
    assert touch is not None
    times = np.linspace(0.0, 0.1, 2_000_001)
    values = late.a + (0.9e-3j * np.exp(complex(2.0, 900.0) * times)).real
    assert touch[0] == pytest.approx(times[np.argmax(values > 0.0)], abs=6e-8)
    assert highest(depth, 0.05, 0.0) == pytest.approx(5e-5, rel=1e-12)


@pytest.mark.parametrize("height", [1e-6, 1e-9, 1e-12])
def test_a_grazing_touch_is_found(height: float):
    """The local maximum of a wave stands above zero by 1e-12 of a millimetre."""
    local_maximum = Curve(-1e-3 + height * 1e-3, 0.0, ((1e-3j, 300j),))
    assert (first_touch(local_maximum, 0.02) is not None) == (height * 1e-3 >= 1e-15)
    assert first_touch(Curve(-1e-3 - height * 1e-3, 0.0, ((1e-3j, 300j),)), 0.02) is None


# ---------------------------------------------------------------------------------------------- convergence
@pytest.mark.parametrize("law", oracle.LAWS)
def test_tightening_moves_nothing(law: str):
    """rtol 1e-9 against 1e-12: closed gap, long contacts, yielding, both buildings flexible."""
    cap = 1.5e5 if law in CAPPED else math.inf
    pair = Oscillator(5e4, 0.3), Oscillator(9e4, 0.15)
    scene = Scene(*pair, law, STIFFNESS[law] / 4.0, 0.001, 0.6, cap)
    loose, tight = (integrate(scene, record(7, 250), 0.01, rtol) for rtol in (1e-9, 1e-12))
    assert tight["impact_count"] >= 5
    for name, value in tight.items():
        close = pytest.approx(value, rel=1e-8, abs=1e-4 if name == "energy_viscous" else 1e-12, nan_ok=True)
        if name != "lowest_contact_force":
            assert loose[name] == close, name
    assert loose["lowest_contact_force"] == pytest.approx(
        tight["lowest_contact_force"], abs=1e-8 * tight["peak_contact_force"]
    )


def test_elastic_laws_keep_energy_over_a_run():
    pair = Oscillator(5e4, 0.3), Oscillator(9e4, 0.15)
    for law in ("linear", "hertz", "van_mier"):
        scene = Scene(*pair, law, STIFFNESS[law] / 4.0, 0.001, 0.6, 1.5e5, 0.3)
        found = integrate(scene, record(7, 250), 0.01)
        assert found["energy_viscous"] == pytest.approx(0.0, abs=1e-6)  # of contacts that store some 1e2 J


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
    true = integrate(scene, ground, DT)
    found = oracle_rows.integrate([single(scene.left), single(scene.right)], [meeting], ground, DT)
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
    found = oracle_rows.integrate([chain], [], np.full(41, -pull), DT)
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
    fine, coarse = (oracle_rows.integrate(towers, meetings, ground, DT, rtol) for rtol in (1e-12, 1e-10))
    assert abs(fine.open_energy) < 1e-11
    assert fine.points["impact_count"].max() >= 3
    np.testing.assert_array_equal(fine.points["impact_count"], coarse.points["impact_count"])
    np.testing.assert_allclose(coarse.floors, fine.floors, rtol=1e-8)
    np.testing.assert_allclose(coarse.points["peak_contact_force"], fine.points["peak_contact_force"], rtol=1e-8)
