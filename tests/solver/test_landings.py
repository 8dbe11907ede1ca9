"""Steps that end on an event keep the tolerance, as all others: from the closed form of an elastic rebound."""

from math import sqrt

import numpy as np
import pytest
from scenes import scene_text, single

import pounding_risk as pr
from pounding_risk.models.contact.laws import Bilinear, Jankowski
from pounding_risk.scene.reader import parse_scene

STIFFNESS = 4.2e10  # N/m^1.5
MASSES = (44.36e3, 82.6e3)  # kg
REDUCED = 1.0 / sum(1.0 / mass for mass in MASSES)
# Of 1,500 impacts 2.7 rtol was the most, of those below 2.3; steps that ended at a parting once added up to 86.
MOST = 5.0


@pytest.mark.parametrize("rtol", [1e-9, 1e-10])
def test_a_rebound_is_that_of_the_energy_at_the_peak(rtol):
    """Jankowski's force is β δ^1.5 on the way back: v = sqrt(4 β / 5 m) δ_max^(5/4), whatever was lost before."""
    random = np.random.default_rng(3)
    speeds, restitutions = 10.0 ** random.uniform(-2.5, 0.3, 400), random.uniform(0.3, 0.9, 400)
    speeds[0], restitutions[0] = 0.10661006693343802, 0.41225658098988593  # 68 rtol at 1e-10 before
    law = Jankowski(STIFFNESS)
    impacts = [
        pr.impact(law, speed, *MASSES, restitution=e, rtol=rtol) for speed, e in zip(speeds, restitutions, strict=True)
    ]
    peaks = np.array([impact.peak_penetration for impact in impacts])
    rebounds = speeds * np.array([impact.restitution for impact in impacts])
    errors = np.abs(rebounds / (sqrt(0.8 * STIFFNESS / REDUCED) * peaks**1.25) - 1.0)
    assert errors.max() < MOST * rtol


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-10])
def test_knees_of_bilinear_are_met(rtol):
    """Energy on straight lines: what the touch brings, less the loop (K1 − K2) δ_y (δ_max − δ_y), comes back."""
    random = np.random.default_rng(5)
    speeds, restitutions = 10.0 ** random.uniform(-2.5, 0.3, 300), random.uniform(0.4, 0.95, 300)
    depth, errors = 3e-4, []
    for speed, e in zip(speeds, restitutions, strict=True):
        loop, whole = STIFFNESS * depth**2.5 * (1.0 - e * e) / 2.5, STIFFNESS * sqrt(depth)
        steep, flat = whole + loop / (0.1 * depth**2), whole - loop / (0.9 * depth**2)
        brought, force = 0.5 * REDUCED * speed**2, steep * 0.1 * depth
        left = max(brought - 0.05 * force * depth, 0.0)  # at the knee
        past_knee = (sqrt(force**2 + 2.0 * flat * left) - force) / flat
        expected = sqrt(1.0 - (steep - flat) * 0.1 * depth * past_knee / brought)
        found = pr.impact(Bilinear(STIFFNESS, depth), speed, *MASSES, restitution=e, rtol=rtol).restitution
        errors.append(abs(found - expected))
    assert max(errors) < rtol  # 0.8 of it was the most; steps across a knee were off by 3 to 2,500


@pytest.mark.parametrize(
    ("rtol", "speed", "e"),
    [
        (1e-9, 1.0041584545797277, 0.4013923867962517),
        (1e-9, 1.7000544904074455, 0.724886862412345),
        (1e-10, 0.18261276848451607, 0.35597526525084827),
    ],
)
def test_a_row_has_the_impulse_of_the_pair(rtol, speed, e):
    """Two bodies on springs of 1000 s, and a third that nothing reaches: off by 17 to 21 rtol before."""
    bodies = [
        single(name, f"{mass} kg", "1000 s", damping=0.0)
        for name, mass in zip("abc", (*MASSES, MASSES[1]), strict=True)
    ]
    bodies[0]["initial_velocity"] = f"{speed!r} m/s"
    contact = {"contact_model": "jankowski", "stiffness": f"{STIFFNESS} N/m^1.5", "restitution": e}

    def impulse(count, rtol):
        gaps = [{"gap": gap, **contact} for gap in ("1 mm", "8 m")[: count - 1]]
        quiet = {"window": ["0 s", "0.3 s"], "scale": 1e-9}
        text = scene_text(*bodies[:count], interfaces=gaps, records=quiet, solver={"rtol": rtol})
        return pr.simulate(parse_scene(text)).contact_impulse.values.item(0)

    assert impulse(3, rtol) == pytest.approx(impulse(2, 1e-12), rel=MOST * rtol)
