"""The reference integrator against what is known without it: closed forms, tables, matrix exponentials."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from pathlib import Path

import closed_forms as known
import numpy as np
import oracle
import pytest
from oracle import Oscillator, Scene, impact, integrate
from oracle_flight import Curve, first_touch, highest
from oracle_laws import exact_hertz_damp
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

pytestmark = pytest.mark.complete  # of the integrator of the tests, whose sources are digested with its kept answers
LEFT, RIGHT = Oscillator(44.36e3, 0.208), Oscillator(82.60e3, 0.007)
MASS = 1.0 / (1.0 / LEFT.mass + 1.0 / RIGHT.mass)
STIFFNESS = {law: 1e9 if law in oracle.LINEAR else 4.2e10 for law in oracle.LAWS}


def collision(law: str, e: float = 0.65, speed: float = 0.5, **more: float) -> dict[str, float]:
    return impact(Scene(LEFT, RIGHT, law, STIFFNESS[law], restitution=e, **more), speed)  # type: ignore[arg-type]


def test_the_oracle_shares_nothing_with_the_solver():
    for file in Path(__file__).parents[1].glob("oracle*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.startswith("pounding_risk") for name in names), file


# ---------------------------------------------------------------------------------------------- restitution
@pytest.mark.parametrize(
    ("law", "e", "achieved"), [(law, e, a) for law, row in known.ACHIEVED.items() for e, a in row.items()]
)
def test_restitution_achieved_is_the_table(law: str, e: float, achieved: float):
    assert collision(law, e)["restitution"] == pytest.approx(achieved, abs=0.51e-4)


@pytest.mark.parametrize("e", [0.05, 0.1, 0.25, 0.4, 0.5, 0.65, 0.8, 0.95, 1.0])
def test_restitution_achieved_is_the_closed_form(e: float):
    exact = {
        "linear": 1.0,
        "hertz": 1.0,
        "van_mier": 1.0,
        "kelvin_voigt": e,
        "kelvin_voigt_tension_cut": known.kelvin_voigt_cut_restitution(known.kelvin_voigt_ratio(e)),
        "modified_kelvin_voigt": known.modified_kelvin_voigt_restitution(known.modified_kelvin_voigt_ratio(e)),
        "hertz_damp": known.hertz_damp_restitution(known.hertz_damp_factor(e)),
        "hertz_damp_exact": e,
    }
    for law, value in exact.items():
        assert collision(law, e)["restitution"] == pytest.approx(value, abs=1e-11), law


@pytest.mark.parametrize("law", oracle.LAWS)
def test_momentum_impulse_and_energy_follow_from_the_restitution(law: str):
    cap = 8e5 if law in ("van_mier", "viscous_elastoplastic") else math.inf
    found = collision(law, 0.5, 0.7, yield_force=cap)
    e = found["restitution"]
    v1, v2 = known.velocities(LEFT.mass, RIGHT.mass, 0.7, 0.0, e)
    assert LEFT.mass * found["velocity_left"] + RIGHT.mass * found["velocity_right"] == pytest.approx(
        LEFT.mass * 0.7, rel=1e-12
    )
    assert (found["velocity_left"], found["velocity_right"]) == pytest.approx((v1, v2), abs=1e-11)
    assert found["impulse"] == pytest.approx(known.impulse(MASS, 0.7, e), rel=1e-10)
    assert found["energy_lost"] == pytest.approx(known.energy_lost(MASS, 0.7, e), abs=1e-10 * MASS)


# ------------------------------------------------------------------------------ peak force, depth, duration
@pytest.mark.parametrize("speed", [0.01, 0.5, 5.0])
def test_elastic_laws(speed: float):
    for law, exact in (("linear", known.linear_impact), ("hertz", known.hertz_impact)):
        found = collision(law, speed=speed)
        depth, force, duration = exact(STIFFNESS[law], MASS, speed)
        assert found["peak_penetration"] == pytest.approx(depth, rel=1e-11)
        assert found["peak_contact_force"] == pytest.approx(force, rel=1e-11)
        assert found["duration"] == pytest.approx(duration, rel=1e-11)


@pytest.mark.parametrize("e", [0.2, 0.65, 0.9])
def test_kelvin_voigt(e: float):
    found, xi = collision("kelvin_voigt", e), known.kelvin_voigt_ratio(e)
    depth, duration = known.kelvin_voigt_impact(1e9, MASS, 0.5, xi)
    assert found["peak_penetration"] == pytest.approx(depth, rel=1e-11)
    assert found["duration"] == pytest.approx(duration, rel=1e-11)
    pull = -2.0 * xi * math.sqrt(1e9 * MASS) * e * 0.5  # F = c v where δ is back at zero
    assert found["lowest_contact_force"] == pytest.approx(pull, rel=1e-10)
    for law in ("kelvin_voigt_tension_cut", "modified_kelvin_voigt"):
        found = collision(law, e)
        assert found["lowest_contact_force"] >= -1e-11 * found["peak_contact_force"]  # lands so near zero


@pytest.mark.parametrize(("e", "xi"), known.EXACT_JANKOWSKI.items())
def test_jankowski_table(e: float, xi: float):
    """The table is made with the exact ξ, so look for the e whose published ξ it is."""
    asked = float(brentq(lambda x: known.jankowski_ratio(x) - xi, 0.01, 1.0))
    for speed in (0.05, 2.0):
        found = collision("jankowski", asked, speed)
        assert found["restitution"] == pytest.approx(e, abs=1.1e-5)
        if e in known.JANKOWSKI_PEAKS:
            unit = (MASS * speed**2 / 4.2e10) ** 0.4
            depth, force, duration = known.JANKOWSKI_PEAKS[e]
            assert found["peak_penetration"] / unit == pytest.approx(depth, abs=0.6e-4)
            assert found["peak_contact_force"] / (4.2e10 * unit**1.5) == pytest.approx(force, abs=0.6e-4)
            assert found["duration"] * speed / unit == pytest.approx(duration, abs=0.6e-3)


@pytest.mark.parametrize("e", [0.2, 0.4, 0.65, 0.9])
def test_jankowski_in_the_fourth_root_of_depth(e: float):
    """On approach dv/dδ = −F/(m v); with δ = p⁴ D all is smooth, and there is neither time nor an event."""
    xi = known.jankowski_ratio(e)

    def slope(p: float, y: np.ndarray) -> list[float]:
        return [-4.0 * p**3 * (p**6 / y[0] + 2.0 * xi * p)]

    way = solve_ivp(slope, (0.0, 1.2), [1.0], "DOP853", rtol=1e-13, atol=1e-15, dense_output=True, events=_slow)
    p = np.linspace(0.0, way.t[-1], 400_001)
    found = collision("jankowski", e, 0.5)
    unit = (MASS * 0.25 / 4.2e10) ** 0.4
    force = (p**6 + 2.0 * xi * p * way.sol(p)[0]).max()  # points 2.5e-6 apart: short of the top by < 1e-9
    assert found["peak_contact_force"] / (4.2e10 * unit**1.5) == pytest.approx(force, rel=1e-9)
    # Stopped at v = v0/10⁴: the rest of the depth is v²/2 over the force there.
    rest = 0.5e-8 / way.t[-1] ** 6
    assert found["peak_penetration"] / unit == pytest.approx(way.t[-1] ** 4 + rest, rel=1e-9)


def _slow(_: float, y: np.ndarray) -> float:
    return float(y[0]) - 1e-4


_slow.terminal = True  # type: ignore[attr-defined]


@pytest.mark.parametrize(("case", "force"), known.TYPICAL_PEAKS.items())
def test_typical_peak_forces(case: tuple[float, float], force: float):
    beta, speed = case
    masses = Oscillator(2 * 28.9e3, 1.0), Oscillator(2 * 28.9e3, 1.0)
    found = impact(Scene(*masses, "jankowski", beta), speed)
    assert found["peak_contact_force"] == pytest.approx(
        1e3 * force, rel=6e-4, abs=510.0
    )  # the table's mass and force are rounded


def test_exact_hertz_damp_factor():
    for e, d in known.EXACT_HERTZ_DAMP.items():
        assert exact_hertz_damp(e) == pytest.approx(d, abs=0.6e-5)
        assert known.hertz_damp_restitution(exact_hertz_damp(e)) == pytest.approx(e, abs=1e-13)


# ------------------------------------------------------------------------------------------ laws with a cap
def test_the_capped_law_rebounds_more_the_lower_its_cap():
    whole = collision("viscous_elastoplastic")
    for share, (e, depth) in known.CAPPED.items():
        cap = share * whole["peak_contact_force"] * (1.0 + 1e-9 * (share == 1.0))
        found = collision("viscous_elastoplastic", yield_force=cap)
        assert found["restitution"] == pytest.approx(e, abs=0.6e-3)
        assert found["peak_penetration"] / whole["peak_penetration"] == pytest.approx(depth, abs=0.6e-2)
        assert found["yield_count"] == (share < 1.0)
        assert found["peak_contact_force"] == pytest.approx(min(cap, whole["peak_contact_force"]), rel=1e-11)
    for e_asked, row in known.CAPPED_OTHER.items():
        peak = collision("jankowski", e_asked)["peak_contact_force"]
        for share, e in row.items():
            found = collision("viscous_elastoplastic", e_asked, yield_force=share * peak)
            assert found["restitution"] == pytest.approx(e, abs=0.6e-3)


@pytest.mark.parametrize("cap", [2e4, 2e5, 1e6])
def test_van_mier_plateau(cap: float):
    found = collision("van_mier", yield_force=cap)
    depth, duration = known.capped_hertz_impact(4.2e10, MASS, 0.5, cap)
    assert found["restitution"] == pytest.approx(1.0, abs=1e-10)
    assert found["peak_penetration"] == pytest.approx(depth, rel=1e-11)
    assert found["duration"] == pytest.approx(duration, rel=1e-11)
    assert found["peak_uncapped_force"] == pytest.approx(4.2e10 * depth**1.5, rel=1e-11)


def test_van_mier_hardening_keeps_energy():
    """With an exponent n the force at the deepest point follows from the energy alone."""
    cap, n = 3e5, 0.4
    found = collision("van_mier", yield_force=cap, plastic_exponent=n)
    depth_y = (cap / 4.2e10) ** (2.0 / 3.0)
    plastic = 0.5 * MASS * 0.25 - 0.4 * cap * depth_y
    depth = depth_y * (1.0 + plastic * (n + 1.0) / (cap * depth_y)) ** (1.0 / (n + 1.0))
    assert found["peak_penetration"] == pytest.approx(depth, rel=1e-11)
    assert found["peak_contact_force"] == pytest.approx(cap * (depth / depth_y) ** n, rel=1e-11)


def test_the_striker_of_van_mier():
    """Uncapped 96, 64, 662 and 441 kN; a cap makes equal plateaus, longer for the heavier striker."""
    heavy, light = (Scene(Oscillator(m, 1.0), oracle.WALL, "jankowski", 2.75e9) for m in (570.0, 290.0))
    peaks = [impact(s, v)["peak_contact_force"] / 1e3 for v in (0.5, 2.5) for s in (heavy, light)]
    # Peaks scale as m^0.6 v^1.2, so equal ones take a cap.
    assert peaks[0] / peaks[1] == pytest.approx((570 / 290) ** 0.6, rel=1e-9)
    assert peaks[2] / peaks[0] == pytest.approx(5.0**1.2, rel=1e-9)
    assert peaks == pytest.approx([96, 64, 662, 441], rel=0.01)
    capped = [impact(replace(s, law="viscous_elastoplastic", yield_force=3e5), 2.5) for s in (heavy, light)]
    assert [c["peak_contact_force"] for c in capped] == pytest.approx([3e5, 3e5], rel=1e-12)
    assert capped[0]["duration"] > 1.5 * capped[1]["duration"]


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


def test_free_vibration_after_a_pulse():
    """One triangle of ground acceleration, then rest: the velocity it leaves, and its decay."""
    period, damping, dt = 1.0, 0.02, 0.001
    a = np.zeros(3001)
    a[1] = 5.0
    found = integrate(Scene(Oscillator(1e5, period, damping), oracle.WALL, "hertz", 1e9, gap=1.0), a, dt)
    omega, s = 2.0 * math.pi / period, math.sqrt(1.0 - damping**2)
    v = 5.0 * dt  # the pulse is short: its width enters at (ω dt)² = 4e-5
    peak = v / omega * math.exp(-damping / s * math.atan2(s, damping))
    assert found["peak_displacement_left"] == pytest.approx(peak, rel=1e-4)
    second = peak * math.exp(-damping * math.pi / s)
    assert found["peak_closing"] == pytest.approx(second, rel=1e-4)  # away first, back half a period later


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
    # At t = 0 it presses already; seen from just after, the next crest is lower than 1e-3.
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
    """The crest of a wave stands above zero by 1e-12 of a millimetre."""
    crest = Curve(-1e-3 + height * 1e-3, 0.0, ((1e-3j, 300j),))
    assert (first_touch(crest, 0.02) is not None) == (height * 1e-3 >= 1e-15)
    assert first_touch(Curve(-1e-3 - height * 1e-3, 0.0, ((1e-3j, 300j),)), 0.02) is None


# ---------------------------------------------------------------------------------------------- convergence
@pytest.mark.parametrize("law", oracle.LAWS)
def test_tightening_moves_nothing(law: str):
    """rtol 1e-9 against 1e-12: closed gap, long contacts, yielding, both buildings flexible."""
    cap = 1.5e5 if law in ("van_mier", "viscous_elastoplastic") else math.inf
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


def test_mirrored_pair():
    """Swap the buildings and turn the ground motion round: the same run, left for right."""
    pair, a = (Oscillator(5e4, 0.3), Oscillator(9e4, 0.15)), record(7, 250)
    one = integrate(Scene(*pair, "jankowski", 4e9, 0.001), a, 0.01)
    two = integrate(Scene(*pair[::-1], "jankowski", 4e9, 0.001), -a, 0.01)
    swapped = {"left": "right", "right": "left"}
    for name, value in one.items():
        stem, _, side = name.rpartition("_")
        twin = f"{stem}_{swapped[side]}" if side in swapped else name
        assert two[twin] == pytest.approx(value, rel=1e-9, nan_ok=True), name


def test_nothing_happens_without_ground_motion():
    found = integrate(Scene(LEFT, RIGHT, "jankowski", 4.2e10), np.zeros(100), 0.01)
    assert all(value == 0.0 or math.isnan(value) for value in found.values())


def test_twins_never_meet():
    found = integrate(Scene(LEFT, LEFT, "jankowski", 4.2e10), record(), 0.01)
    assert found["impact_count"] == 0.0 and found["peak_relative_displacement"] == 0.0
