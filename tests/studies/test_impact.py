"""Isolated impacts beyond the facts of test_conformance: scaling, published tables, the cap."""

import closed_forms as exact
import numpy as np
import pytest
from scipy.optimize import brentq
from sentences import refusal, refusals

from pounding_risk.models.contact.laws import (
    LAWS,
    Hertz,
    Jankowski,
    KelvinVoigt,
    Linear,
    VanMier,
    ViscousElastoplastic,
    stiffness_quantity,
)
from pounding_risk.models.contact.relation import name_of
from pounding_risk.models.restitution import CONCRETE, constant
from pounding_risk.solver.pair.isolated import equal_stiffness
from pounding_risk.studies.impact import impact, restitution_of

MASS, SPEED, BETA = 570.0, 0.5, 2.75e9


def law_of(name: str, times: float = 1.0):
    kind = LAWS[name]
    return kind(9.35e7 * times) if stiffness_quantity(kind).unit == "N/m" else kind(BETA * times)


@pytest.mark.parametrize("name", LAWS)
def test_restitution_depends_on_nothing_but_e(name: str):
    """Not on mass, stiffness or speed over many decades; to 1e-9, the integration runs at 1e-12.

    A contact that is stiffer and stiffer shrinks to nothing.
    """
    soft, stiff = (impact(law_of(name, times), SPEED, MASS, restitution=0.65) for times in (1.0, 1e6))
    assert stiff.duration < 5e-3 * soft.duration
    reference = soft.restitution
    for times, mass, speed in ((1e-3, MASS, SPEED), (1e6, MASS, SPEED), (1.0, 1e7, SPEED), (1.0, MASS, 20.0)):
        found = impact(law_of(name, times), speed, mass, restitution=0.65).restitution
        assert found == pytest.approx(reference, rel=1e-9)
    assert impact(law_of(name), 2e-3, 3.0, restitution=0.65).restitution == pytest.approx(reference, rel=1e-9)


@pytest.mark.parametrize(("e", "xi"), exact.EXACT_JANKOWSKI.items())
def test_jankowski_is_exact_and_self_similar(e: float, xi: float):
    """The published formula inverted gives the e whose ξ is the table's; e follows to its five digits.

    δ = a1 D, F = a2 β D^1.5, t = a3 D/v0 with D = (m v0²/β)^0.4, whatever m, β and v0; a to four digits.
    """
    published = brentq(lambda x: exact.jankowski_ratio(x) - xi, 1e-3, 1.0, xtol=1e-15)
    for mass, beta, speed in ((570.0, 2.75e9, 0.5), (28860.0, 4.2e10, 0.05)):
        found = impact(Jankowski(beta), speed, mass, restitution=published)
        size = (mass * speed**2 / beta) ** 0.4
        assert found.restitution == pytest.approx(e, abs=1e-5)
        if e in exact.JANKOWSKI_PEAKS:
            depth, force, time = exact.JANKOWSKI_PEAKS[e]
            assert found.peak_penetration / size == pytest.approx(depth, abs=6e-5)
            assert found.peak_force / (beta * size**1.5) == pytest.approx(force, abs=1e-4)
            assert found.duration * speed / size == pytest.approx(time, abs=6e-4)


@pytest.mark.parametrize("e", [0.2, 0.65, 0.9])
def test_kelvin_voigt_jumps_and_pulls(e: float):
    """The force jumps to c v0 at the touch and ends at −c e v0."""
    found = impact(KelvinVoigt(9.35e7), SPEED, MASS, restitution=e)
    damping = 2.0 * exact.kelvin_voigt_ratio(e) * np.sqrt(9.35e7 * MASS)
    assert (found.force[0], found.force[-1]) == pytest.approx((damping * SPEED, -damping * e * SPEED), rel=1e-9)


@pytest.mark.parametrize(("share", "known"), exact.CAPPED.items())
def test_rebound_and_depth_under_the_published_cap(share: float, known: tuple[float, float]):
    """Eq. (3) taken literally: a lower cap rebounds more and goes deeper; three digits and two decimals.

    The closed form to 1e-9, which holds where F_E is reached on approach and the spring alone keeps it up to the turn.
    """
    for e in (0.65, 0.4, 0.8):
        free = impact(Jankowski(BETA), SPEED, MASS, restitution=e)
        cap = share * free.peak_force
        found = impact(ViscousElastoplastic(BETA), SPEED, MASS, restitution=e, yield_force=cap)
        assert found.peak_force == min(share, 1.0) * free.peak_force
        if e == 0.65:
            assert found.restitution == pytest.approx(known[0], abs=6e-4)
            assert found.peak_penetration / free.peak_penetration == pytest.approx(known[1], abs=6e-3)
        if share < {0.4: 0.5, 0.65: 0.9, 0.8: 0.9}[e]:
            closed = exact.capped_jankowski_impact(BETA, MASS, SPEED, exact.jankowski_ratio(e), cap)
            assert (found.restitution, found.peak_penetration, found.duration) == pytest.approx(closed, rel=1e-9)


def test_yielding_never_adds_energy():
    """The lower the cap the closer to elastic, and never beyond it.

    The peak is F_E itself; the row of the history that lands on the yield may miss it by 1e-8 of a step.
    """
    shares = np.geomspace(1e-3, 1.0, 13)
    peak = impact(Jankowski(BETA), SPEED, MASS, restitution=0.65).peak_force
    runs = [impact(ViscousElastoplastic(BETA), SPEED, MASS, restitution=0.65, yield_force=peak * s) for s in shares]
    achieved = [run.restitution for run in runs]
    assert np.all(np.diff(achieved) < 0.0) and achieved[0] <= 1.0
    for run, share in zip(runs, shares, strict=True):
        assert run.energy_lost >= 0.0 and run.peak_force <= peak * share
        assert run.force.max() <= peak * share * (1.0 + 1e-8)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_van_mier_plateau(share: float):
    """Depth and duration of the retraced plateau in closed form."""
    cap = share * exact.hertz_impact(BETA, MASS, SPEED)[1]
    depth, duration = exact.capped_hertz_impact(BETA, MASS, SPEED, cap)
    found = impact(VanMier(BETA), SPEED, MASS, yield_force=cap)
    assert (found.peak_penetration, found.duration) == pytest.approx((depth, duration), rel=1e-9)
    assert found.peak_force == cap and found.restitution == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("exponent", [0.5, 1.0])
def test_van_mier_hardening(exponent: float):
    """Between the plateau and Hertz: elastic, and the energy at the deepest point is the whole."""
    law = VanMier(BETA, exponent)
    cap = 0.4 * exact.hertz_impact(BETA, MASS, SPEED)[1]
    found = impact(law, SPEED, MASS, yield_force=cap)
    assert found.restitution == pytest.approx(1.0, abs=1e-9)
    assert law.stored(found.peak_penetration, cap) == pytest.approx(0.5 * MASS * SPEED**2, rel=1e-9)
    assert found.peak_force == pytest.approx(law.plateau(found.peak_penetration, cap), rel=1e-9)


def test_e_of_concrete_is_that_of_the_touch():
    for speed, e in exact.CONCRETE.items():
        if speed > 0.0:
            found = impact(KelvinVoigt(9.35e7), speed, MASS, restitution=CONCRETE)
            assert found.restitution_asked == CONCRETE.at(speed) == pytest.approx(e, abs=6e-4)
            assert found.restitution == pytest.approx(CONCRETE.at(speed), abs=1e-9)
    fast = [impact(KelvinVoigt(9.35e7), speed, MASS, restitution=CONCRETE).restitution for speed in (5.0, 7.2, 30.0)]
    assert fast == pytest.approx([CONCRETE.at(5.0)] * 3, abs=1e-9)


def test_history_is_that_of_the_motion():
    """Starts at the touch and ends at the parting; the force's sum over the steps is the impulse."""
    found = impact(Hertz(BETA), SPEED, MASS)
    assert (found.time[0], found.penetration[0], found.force[0], found.rate[0]) == (0.0, 0.0, 0.0, SPEED)
    assert found.time[-1] == pytest.approx(found.duration, rel=1e-12)
    assert abs(found.penetration[-1]) < 1e-12 * found.peak_penetration
    assert np.all(np.diff(found.time) >= 0.0)
    assert np.trapezoid(found.force, found.time) == pytest.approx(found.impulse, rel=0.02)


def test_what_an_impact_refuses(says):
    wrong = {"speed": [0.0, -0.5, float("nan")], "mass": [0.0, -1.0], "other_mass": [-2.0], "yield_force": [0.0]}
    says(*refusals(impact, ViscousElastoplastic(BETA), speed=SPEED, mass=MASS, wrong=wrong))


@pytest.mark.parametrize("e", [0.0, -0.1, 1.1, float("nan")])
def test_restitution_outside_its_range(e: float, says):
    told = refusal(restitution_of, e)
    says(told)
    assert refusal(impact, Jankowski(BETA), SPEED, MASS, restitution=e) == told


def test_names_and_relations():
    assert [name_of(type(law_of(name))) for name in LAWS] == list(LAWS)
    assert restitution_of("concrete") == CONCRETE and restitution_of("0.65") == constant(0.65)
    assert "restitution 'steel'" in refusal(restitution_of, "steel")


def test_equal_terms():
    """A linear spring with Hertz's peak force: F = v0 sqrt(k m), solved for k."""
    for same, form in (
        ("peak force", lambda f, d: (f / 0.5) ** 2 / 570.0),
        ("penetration", lambda f, d: 570.0 * 0.25 / d**2),
    ):
        depth, force, _ = exact.hertz_impact(2.75e9, 570.0, 0.5)
        found = equal_stiffness(Linear, Hertz(2.75e9), 0.5, 570.0, constant(1.0), same)
        assert found == pytest.approx(form(force, depth), rel=1e-8)
