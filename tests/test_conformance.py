"""Every contact law in an isolated impact, against closed forms, conservation laws and published tables."""

from __future__ import annotations

from math import inf

import closed_forms as exact
import numpy as np
import pytest

from pounding_risk.collision import equal_stiffness, impact
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact import (
    LAWS,
    Hertz,
    Jankowski,
    Linear,
    VanMier,
    ViscousElastoplastic,
    stiffness_quantity,
)
from pounding_risk.models.restitution import CONCRETE, constant

ASKED = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8, 0.9)
# Restitution achieved for each e asked for; physics of each law integrated independently to four digits.
ACHIEVED = {
    "kelvin_voigt": ASKED,
    "kelvin_voigt_tension_cut": (0.2527, 0.3249, 0.3971, 0.4720, 0.5503, 0.6323, 0.6748, 0.7182, 0.8081, 0.9020),
    "modified_kelvin_voigt": (0.1025, 0.2055, 0.3070, 0.4071, 0.5061, 0.6046, 0.6538, 0.7030, 0.8014, 0.9004),
    "hertz_damp": (0.6653, 0.6723, 0.6842, 0.7016, 0.7252, 0.7561, 0.7748, 0.7960, 0.8471, 0.9132),
    "hertz_damp_exact": ASKED,
    "jankowski": (0.0933, 0.1915, 0.2917, 0.3930, 0.4946, 0.5962, 0.6470, 0.6977, 0.7989, 0.8997),
    "viscous_elastoplastic": (0.0933, 0.1915, 0.2917, 0.3930, 0.4946, 0.5962, 0.6470, 0.6977, 0.7989, 0.8997),
    "linear": (1.0,) * 10,
    "hertz": (1.0,) * 10,
    "van_mier": (1.0,) * 10,
    "bilinear": tuple(exact.bilinear_restitution(e) for e in ASKED),
}
PULLS = {"kelvin_voigt"}


def law_of(name: str):
    kind = LAWS[name]
    return kind(9.35e7) if stiffness_quantity(kind).unit == "N/m" else kind(2.75e9)


def test_every_law_is_in_the_table():
    assert set(ACHIEVED) == set(LAWS)


@pytest.mark.parametrize("name", LAWS)
def test_restitution_achieved(name: str):
    """The tables have four digits."""
    for asked, achieved in zip(ASKED, ACHIEVED[name], strict=True):
        found = impact(law_of(name), 0.5, 570.0, restitution=asked)
        assert found.restitution == pytest.approx(achieved, abs=5.1e-5)


@pytest.mark.parametrize("e", [0.2, 0.5, 0.65, 0.9])
def test_restitution_closed_forms(e: float):
    """To 1e-9: the integration runs at 1e-12 and a contact takes some sixty steps."""
    forms = {
        "kelvin_voigt": e,
        "kelvin_voigt_tension_cut": exact.kelvin_voigt_cut_restitution(exact.kelvin_voigt_ratio(e)),
        "modified_kelvin_voigt": exact.modified_kelvin_voigt_restitution(exact.modified_kelvin_voigt_ratio(e)),
        "hertz_damp": exact.hertz_damp_restitution(exact.hertz_damp_factor(e)),
        "hertz_damp_exact": e,
    }
    for name, achieved in forms.items():
        assert impact(law_of(name), 0.5, 570.0, restitution=e).restitution == pytest.approx(achieved, rel=1e-9), name


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_momentum_and_energy(name: str, ratio: float):
    """Momentum to 1e-12 of what the striker brought; work ½ m v0² (1 − e²), e as achieved; impulse (1 + e) m v0."""
    mass, other, speed = 1e4, 1e4 * ratio, 0.8
    found = impact(law_of(name), speed, mass, other, restitution=0.65)
    reduced = mass * other / (mass + other)
    whole = 0.5 * reduced * speed**2
    assert abs(found.momentum_change * found.impulse) < 1e-12 * mass * speed
    assert found.energy_lost == pytest.approx(exact.energy_lost(reduced, speed, found.restitution), abs=1e-9 * whole)
    assert found.impulse == pytest.approx(exact.impulse(reduced, speed, found.restitution), rel=1e-9)


@pytest.mark.parametrize("name", LAWS)
def test_force_pulls_only_where_published(name: str):
    for e in (0.1, 0.65, 1.0):
        smallest = impact(law_of(name), 0.5, 570.0, restitution=e).force.min()
        assert (smallest < 0.0) == (name in PULLS and e < 1.0)


def test_elastic_closed_forms():
    mass, speed = 570.0, 0.5
    for law, form in ((Linear(9.35e7), exact.linear_impact), (Hertz(2.75e9), exact.hertz_impact)):
        depth, force, duration = form(law.stiffness, mass, speed)
        found = impact(law, speed, mass)
        assert (found.peak_penetration, found.peak_force, found.duration) == pytest.approx(
            (depth, force, duration), rel=1e-9
        )


@pytest.mark.parametrize(
    ("e", "depth", "force", "time"),
    [
        (0.2, 0.3017, 2.2177, 3.179),
        (0.5, 0.6280, 0.9008, 3.171),
        (0.65, 0.7746, 0.8203, 3.185),
        (0.9, 1.0050, 1.0158, 3.209),
    ],
)
def test_jankowski_is_self_similar(e: float, depth: float, force: float, time: float):
    """δ = a1 D, F = a2 β D^1.5, t = a3 D/v0 with D = (m v0²/β)^0.4, whatever m, β and v0; a to four digits, at the ξ
    that achieves e exactly."""
    exact_xi = {0.2: 2.48646, 0.5: 0.66785, 0.65: 0.36816, 0.9: 0.07830}[e]
    for mass, beta, speed in ((570.0, 2.75e9, 0.5), (28860.0, 4.2e10, 0.05)):
        asked = _asked_for(exact_xi)
        found = impact(Jankowski(beta), speed, mass, restitution=asked)
        size = (mass * speed**2 / beta) ** 0.4
        assert found.restitution == pytest.approx(e, abs=1e-5)
        assert found.peak_penetration / size == pytest.approx(depth, abs=1e-4)
        assert found.peak_force / (beta * size**1.5) == pytest.approx(force, abs=1e-4)
        assert found.duration * speed / size == pytest.approx(time, abs=1e-3)


def _asked_for(xi: float) -> float:
    """The e whose published ξ this is."""
    from scipy.optimize import brentq

    return brentq(lambda e: exact.jankowski_ratio(e) - xi, 1e-3, 1.0, xtol=1e-14)


@pytest.mark.parametrize(
    ("share", "achieved"),
    [
        (1.0, 0.647),
        (0.9, 0.672),
        (0.8, 0.718),
        (0.7, 0.767),
        (0.6, 0.815),
        (0.5, 0.862),
        (0.4, 0.904),
        (0.2, 0.970),
        (0.1, 0.991),
    ],
)
def test_the_published_cap_makes_the_rebound_more_elastic(share: float, achieved: float):
    """Eq. (3) read literally; three digits from an independent integration at rtol 1e-11."""
    peak = impact(Jankowski(2.75e9), 0.5, 570.0, restitution=0.65).peak_force
    found = impact(ViscousElastoplastic(2.75e9), 0.5, 570.0, restitution=0.65, yield_force=share * peak)
    assert found.restitution == pytest.approx(achieved, abs=6e-4)
    assert found.peak_force == min(share, 1.0) * peak


def test_cap_that_is_not_reached_changes_nothing():
    free = impact(Jankowski(2.75e9), 0.5, 570.0, restitution=0.65)
    for strength in (inf, free.peak_force * (1.0 + 1e-9)):
        capped = impact(ViscousElastoplastic(2.75e9), 0.5, 570.0, restitution=0.65, yield_force=strength)
        assert np.array_equal(capped.force, free.force) and capped.restitution == free.restitution


def test_van_mier_retraces_its_path():
    """No memory, so elastic at any F_E; n = 1.5 is Hertz; the plateau's depth has a closed form."""
    hertz = impact(Hertz(2.75e9), 0.5, 570.0)
    cap = 0.5 * hertz.peak_force
    flat = impact(VanMier(2.75e9), 0.5, 570.0, yield_force=cap)
    same = impact(VanMier(2.75e9, 1.5), 0.5, 570.0, yield_force=cap)
    depth = exact.capped_hertz_impact(2.75e9, 570.0, 0.5, cap)[0]
    assert flat.restitution == pytest.approx(1.0, abs=1e-9) and flat.peak_force == cap
    assert flat.peak_penetration == pytest.approx(depth, rel=1e-9)
    assert same.peak_force == pytest.approx(hertz.peak_force, rel=1e-9)


def test_restitution_of_concrete():
    """Eq. (4) of the paper; held beyond 5 m/s, where the cubic falls to zero at 7.1 m/s."""
    found = [CONCRETE.at(v) for v in (0.0, 0.5, 1.0, 2.5, 5.0, 7.2)]
    assert found == pytest.approx([0.7929, 0.6830, 0.6026, 0.4863, 0.3934, 0.3934], abs=5e-5)
    assert [CONCRETE.beyond(v) for v in (4.9, 5.1)] == [False, True]


def test_equal_terms():
    """A linear spring with Hertz's peak force: F = v0 sqrt(k m), solved for k."""
    for same, form in (
        ("peak force", lambda f, d: (f / 0.5) ** 2 / 570.0),
        ("penetration", lambda f, d: 570.0 * 0.25 / d**2),
    ):
        depth, force, _ = exact.hertz_impact(2.75e9, 570.0, 0.5)
        found = equal_stiffness(Linear, Hertz(2.75e9), 0.5, 570.0, constant(1.0), same)
        assert found == pytest.approx(form(force, depth), rel=1e-8)


def test_what_an_impact_refuses():
    with pytest.raises(PoundingError, match=r"^impact: speed is 0; it must be above zero$"):
        impact(Hertz(1e9), 0.0, 570.0)
    with pytest.raises(PoundingError, match=r"^impact: mass is -1; it must be above zero$"):
        impact(Hertz(1e9), 0.5, -1.0)
