"""The solver against an integrator that shares nothing with it: SciPy, restarted at every sample and event.

Peaks are never excused. What is: the time of the first touch of a pair that starts from rest with a closed
gap, a limit of 0/0 that moves by milliseconds for 1e-11 m, and with it the time spent in contact.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from bursts import burst
from oracle import CONCRETE, WALL, Oscillator, Scene, integrate
from sweeps import sweep

from pounding_risk.models import restitution
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.read import read_motion
from pounding_risk.solver.pair.api import Interface, solve

GRAVITY = 9.80665
FRAME, MASONRY = Oscillator(44.36e3, 0.208), Oscillator(82.60e3, 0.007)
PAPER = Scene(FRAME, MASONRY, "viscous_elastoplastic", 4.2e10, 0.0, CONCRETE, 450e3)


class Shaking(NamedTuple):
    """a_g [m/s²] and its step [s]."""

    acceleration: np.ndarray
    dt: float


def drawn(seed: int, dt: float, peak: float, duration: float = 7.0) -> Callable[[], Shaking]:
    """A motion of a seed."""
    return lambda: Shaking(burst(seed, peak, dt, duration), dt)


def real(name: str, start: float, stop: float, pga: float, polarity: str = "as recorded") -> Callable[[], Shaking]:
    """A record of the catalogue, windowed and scaled [g]."""

    def make() -> Shaking:
        motion = read_motion(name, window=(start, stop), pga=pga * GRAVITY, polarity=polarity)
        return Shaking(motion.acceleration, motion.dt)

    return make


def pair(t_left: float, t_right: float, m_left: float, m_right: float, damping: float = 0.05) -> tuple[Oscillator, ...]:
    """Periods [s], masses [t]."""
    return Oscillator(1e3 * m_left, t_left, damping), Oscillator(1e3 * m_right, t_right, damping)


def el_centro(stop: float, pga: float, component: str = "180", polarity: str = "as recorded") -> Callable[[], Shaking]:
    return real(f"RSN6-{component}", 0, stop, pga, polarity)


CUT, MODIFIED, EXACT, CAPPED = "kelvin_voigt_tension_cut", "modified_kelvin_voigt", "hertz_damp_exact", PAPER.law
HARDENING = pair(0.3, 0.12, 80, 20)
# Periods 0.1 to 2 s (and the paper's 0.007 s), masses 1:10 to 10:1, gaps 0 to 0.1 m, F_E from 10 kN to none.
# Buildings, law, stiffness, gap, and where they are not 0.65 and without limit e, F_E and the exponent; the motion.
RUNS = {
    "paper": (FRAME, MASONRY, CAPPED, 4.2e10, 0.0, CONCRETE, 450e3, el_centro(6, 0.5)),
    "paper-reversed": (FRAME, MASONRY, CAPPED, 4.2e10, 0.0, CONCRETE, 450e3, el_centro(6, 0.5, polarity="reversed")),
    "paper-uncapped": (FRAME, MASONRY, "jankowski", 4.2e10, 0.0, CONCRETE, el_centro(6, 0.5)),
    "linear": (*pair(0.3, 0.9, 100, 300), "linear", 4e8, 0.01, el_centro(8, 0.4, "270")),
    "kelvin-voigt": (*pair(0.8, 0.25, 200, 20), "kelvin_voigt", 9.35e7, 0.005, 0.4, drawn(1, 0.01, 4.0)),
    "tension-cut": (*pair(0.1, 0.5, 50, 50), CUT, 2e9, 0.003, real("CCC-HN1", 24, 32, 0.5)),
    "modified-kv": (*pair(1.2, 0.3, 25, 250), MODIFIED, 5e8, 0.02, CONCRETE, 1e6, drawn(2, 0.005, 3.0)),
    "hertz": (*pair(0.5, 1.0, 500, 800), "hertz", 2.75e9, 0.02, 0.65, 4e6, el_centro(8, 0.35)),
    "hertz-damp": (*pair(2.0, 0.6, 900, 90), "hertz_damp", 2.75e9, 0.1, 0.6, drawn(3, 0.02, 9.0, 9.0)),
    "hertz-damp-exact": (*pair(0.4, 0.2, 60, 90), EXACT, 4.2e10, 0.0, 0.5, real("RSN753-000", 2, 9, 0.4)),
    "jankowski": (*pair(0.5, 1.0, 500, 800), "jankowski", 2.75e9, 0.05, real("CCC-HN2", 24, 33, 0.4)),
    "jankowski-wall": (Oscillator(1e5, 0.6), WALL, "jankowski", 4e9, 0.015, CONCRETE, drawn(4, 0.01, 3.0)),
    "van-mier": (*pair(0.25, 1.4, 40, 160), "van_mier", 3e9, 0.01, 0.65, 1e5, drawn(5, 0.01, 3.0)),
    "van-mier-hardening": (*HARDENING, "van_mier", 3e10, 0.002, 0.65, 2e5, 0.5, el_centro(7, 0.4, "270")),
    # A fast return from far beyond the yield depth: one step may reach the plateau's end and the parting.
    "deep-plateau": (*pair(0.27, 1.93, 43, 164, 0.03), "van_mier", 3e10, 0.0, 0.65, 1e5, el_centro(8, 0.5)),
    "deeper-plateau": (*pair(0.2524, 1.3954, 30.63, 8.0), "van_mier", 2.74e10, 0.03, 0.65, 1e4, el_centro(8, 0.42)),
    "low-cap": (*pair(0.5817, 1.1878, 17.14, 9.744), CAPPED, 2.07e9, 0.0, 0.65, 1e4, el_centro(8, 0.25, "270")),
    "middle-cap": (*pair(0.5, 1.0, 500, 800), CAPPED, 2.75e9, 0.01, 0.65, 1e6, el_centro(8, 0.5)),
    "yields-twice": (*pair(0.26, 0.11, 180, 75), CAPPED, 4e9, 0.0, 0.65, 5e4, drawn(6, 0.01, 5.0)),
}
# A cap and none, a damper cut off, a wall, a plastic branch that hardens.
QUICK = ("paper", "tension-cut", "jankowski-wall", "van-mier-hardening")
SCENES = {name: Scene(*numbers) for name, (*numbers, _) in RUNS.items()}


def by_solver(scene: Scene, shaking: Shaking) -> dict[str, float]:
    buildings = [
        Building.rigid(name) if b.period == 0.0 else Building(name, *b)
        for name, b in (("left", scene.left), ("right", scene.right))
    ]
    e = scene.restitution
    relation = restitution.constant(e) if isinstance(e, int | float) else restitution.Restitution(*e, scene.fastest)
    law = LAWS[scene.law]
    model = law(scene.stiffness, scene.plastic_exponent) if scene.law == "van_mier" else law(scene.stiffness)
    between = Interface(scene.gap, model, relation, scene.yield_force)
    return solve(*buildings, between, shaking.acceleration, shaking.dt, rtol=1e-9)


# Relative tolerance of each output at the solver's rtol of 1e-9.
TOLERANCES = {
    # What the project promises of peaks. Nothing makes others of the same motion less certain.
    **dict.fromkeys(("peak_relative_displacement", "peak_contact_force", "peak_closing", "peak_opening"), 1e-6),
    **dict.fromkeys(("peak_penetration", "peak_approach_speed"), 1e-6),
    **{f"peak_{peak}_{side}": 1e-6 for peak in ("displacement", "floor_acceleration") for side in ("left", "right")},
    # δ^1.5 of a depth that may be many times the yield depth: 1.5 times its relative error.
    "yield_demand": 1.5e-6,
    # Sums over all contacts: errors of one sign can add where those of a peak do not.
    "contact_time": 3e-6,
    "impulse": 3e-6,
}


@pytest.mark.parametrize("name", sweep(RUNS, *QUICK))
def test_solver_agrees_with_scipy(name: str):
    scene, motion = SCENES[name], RUNS[name][-1]()
    true, found = integrate(scene, *motion), by_solver(scene, motion)
    assert found["status"] == 0
    assert true["impact_count"] >= 2, "a scene without contacts compares nothing"
    assert found["impact_count"] == true["impact_count"]
    assert found["yield_count"] == true["yielding_contacts"]  # contacts in which the force reaches F_E
    closed = scene.gap == 0.0
    # From rest with a closed gap the first touch is a matter of rounding; contact time starts with it.
    slack = abs(found["first_impact_time"] - true["first_impact_time"]) if closed else 0.0
    if not closed:
        assert found["first_impact_time"] == pytest.approx(true["first_impact_time"], abs=1e-9)  # a root of free flight
    assert slack <= 5e-3
    differences = {
        name: (found[name], true[name])
        for name, rel in TOLERANCES.items()
        if not abs(found[name] - true[name]) <= rel * abs(true[name]) + (slack if name == "contact_time" else 0.0)
    }
    assert differences == {}
    # 1 µs, as promised.
    assert found["first_yield_time"] == pytest.approx(true["first_yield_time"], rel=0, abs=1e-6, nan_ok=True)
    # Pull and energy are differences: measured against the peak force and against the work that makes them.
    peak, stored = true["peak_contact_force"], true["peak_contact_force"] * true["peak_penetration"]
    assert found["lowest_contact_force"] == pytest.approx(true["lowest_contact_force"], abs=1e-6 * peak)
    assert found["energy_viscous"] == pytest.approx(true["energy_viscous"], rel=3e-6, abs=3e-6 * stored)


def test_scenes_cover_what_they_should():
    scenes = list(SCENES.values())
    # Laws with a path have their own whole run against SciPy, in tests/models.
    assert {scene.law for scene in scenes} == {name for name, law in LAWS.items() if not is_path_dependent(law)}
    ratios = [s.left.mass / s.right.mass for s in scenes if math.isfinite(s.right.mass)]
    assert min(ratios) <= 0.1 and max(ratios) >= 10.0
    periods = [b.period for s in scenes for b in (s.left, s.right)]
    assert 0.1 in periods and 2.0 in periods
    assert {0.0, 0.1} <= {s.gap for s in scenes}
    assert {1e4, math.inf} <= {s.yield_force for s in scenes}
