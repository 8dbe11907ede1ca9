"""The contact laws as formulas: what each returns for given numbers, before any motion."""

from math import inf, sqrt

import closed_forms as exact
import numpy as np
import pytest
from paths import Path, follow_pair
from scipy.integrate import quad

from pounding_risk.lab.stability.trial import shaking
from pounding_risk.models.contact.law import complete, is_path_dependent
from pounding_risk.models.contact.laws import LAWS, Bilinear, VanMier, stiffness_quantity
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.solver.pair.law_verbs import ends_itself
from pounding_risk.studies.impact import impact

YIELD = 3e5  # N
DEPTHS = np.geomspace(1e-7, 1e-2, 21)  # m


def law_of(name: str):
    kind = LAWS[name]
    return kind(9.35e7) if stiffness_quantity(kind).unit == "N/m" else kind(2.75e9)


@pytest.mark.parametrize("name", LAWS)
def test_what_a_law_says_of_itself(name: str):
    """Its flags agree with its methods, so that whoever reads a flag reads the physics."""
    law = law_of(name)
    assert law.reference and law.__doc__
    assert law.capped == (law.ceiling(YIELD) == YIELD) and (law.capped or law.ceiling(YIELD) == inf)
    assert law.needs_restitution == (law.begin(0.5, 0.3, 570.0) != law.begin(0.9, 0.3, 570.0))
    assert law.floor() in (0.0, -inf)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_without_a_damper_takes_no_viscous_energy(name: str):
    """Said of a law whose force follows from δ alone, whatever e is: what its contact takes is 0 J, and no rounding."""
    law = law_of(name)
    memory = law.begin(0.6, 0.5, 570.0)
    alike = all(law.force(memory, d, 0.4, True) == law.force(memory, d, -0.4, False) for d in DEPTHS)
    # That of the points of a table is path-dependent only where it has a way back.
    assert law.conserves() == (alike and (name == "tabulated" or not is_path_dependent(LAWS[name])))
    if law.conserves():
        assert ends_itself(law, memory, 1e-9, 1e6, 3e-7, 0.0) == (0.0, 0.0, 0.0)


def test_a_law_that_changes_the_force_of_one_without_a_damper_says_nothing_of_it():
    class Sticky(LAWS["linear"]):
        __slots__ = ()

        def begin(self, e, speed, mass):
            return 1.0

    assert not complete(Sticky)(1e8).conserves()


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if not is_path_dependent(law)])
def test_stored_energy_is_the_work_of_a_slow_push(name: str):
    """∫ min(F, plateau) dδ at rest; to 1e-10, what the quadrature resolves over the corner at yield."""
    law = law_of(name)
    for strength in (YIELD, inf):
        ceiling = law.ceiling(strength)

        def slow(depth: float, top: float = ceiling) -> float:
            free = law.force(0.0, depth, 0.0, False)
            return free if free <= top else law.plateau(depth, top)

        corner = (ceiling / law.stiffness) ** (2.0 / 3.0) if ceiling < inf else 0.0
        work = quad(slow, 0.0, 5e-3, points=[corner] if 0.0 < corner < 5e-3 else None, epsrel=1e-12, limit=200)[0]
        assert law.stored(5e-3, ceiling) == pytest.approx(work, rel=1e-10)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.5])
def test_van_mier_past_yield(exponent: float):
    """K_p δ^n with K_p from continuity at F_E; n = 0 stays there, and n = 1.5 is a test of conformance."""
    law = VanMier(2.75e9, exponent)
    depth = (YIELD / 2.75e9) ** (2.0 / 3.0)
    for times in (1.0, 1.7, 8.0):
        assert law.plateau(times * depth, YIELD) == pytest.approx(YIELD * times**exponent, rel=1e-14)


@pytest.mark.parametrize("name", LAWS)
def test_a_touch_from_rest_has_a_finite_force(name: str):
    """v0 = 0 divides in the Hertz-damp laws; what a law remembers stays finite."""
    law = law_of(name)
    memory = law.begin(0.65, 0.0, 570.0)
    assert np.all(np.isfinite(memory)) and np.isfinite(law.force(memory, 1e-6, 1e-9, True))


@pytest.mark.parametrize("e", [0.3, 0.65, 1.0])
def test_bilinear_loop(e: float):
    """Force K δ_m at δ_m; the loop to δ_m and back takes β δ_m^2.5 (1 − e²) / 2.5; inside it the slope is K1."""
    law, depth = Bilinear(2.75e9, 0.004), 0.004
    memory = law.begin(e, 0.5, 570.0)
    back = law.turned(memory, depth, True)
    assert law.force(memory, depth, 0.1, True) == pytest.approx(2.75e9 * sqrt(depth) * depth, rel=1e-12)
    way = np.array(
        [law.force(memory, x, 0.1, True) - law.force(back, x, -0.1, False) for x in np.linspace(0, depth, 20001)]
    )
    # Piecewise linear: the sum over 20,000 parts is off by the square of one at four corners.
    assert np.trapezoid(way, dx=depth / 20000) == pytest.approx(
        2.75e9 * depth**2.5 * (1 - e * e) / 2.5, rel=1e-6, abs=1e-9
    )
    steep = (law.force(back, depth, 0, False) - law.force(back, depth - 1e-5, 0, False)) / 1e-5
    assert steep == pytest.approx(memory[0] + memory[1], rel=1e-9)
    again = law.turned(back, 0.5 * depth, False)  # reloading from the lower line starts with K1 as well
    assert law.force(again, 0.5 * depth, 0, True) == pytest.approx(law.force(back, 0.5 * depth, 0, False), rel=1e-12)
    more = law.force(again, 0.5 * depth + 1e-5, 0, True) - law.force(again, 0.5 * depth, 0, True)
    assert more / 1e-5 == pytest.approx(memory[0] + memory[1], rel=1e-9)
    # What is held is the work of the slow way out, two straight lines, so that the quadrature rounds only.
    out = quad(lambda x: law.force(back, x, -0.1, False), 0.0, depth, points=[0.9 * depth], epsrel=1e-12)[0]
    assert law.held(memory, 0.0, inf) == 0.0 and law.held(back, depth, inf) == pytest.approx(out, rel=1e-12)


@pytest.mark.parametrize(("e", "achieved"), exact.BILINEAR_DESIGN.items())
def test_bilinear_as_deep_as_designed(e: float, achieved: float):
    """Its table has three digits; the closed form is met to 1e-9, peak force, depth and loss with it."""
    stiffness, depth, mass = 2.75e9, 0.004, 570.0
    whole, loop = stiffness * sqrt(depth), stiffness * depth**2.5 * (1.0 - e * e) / 2.5
    speed = sqrt((whole * depth**2 + loop) / mass)
    found = impact(Bilinear(stiffness, depth), speed, mass, restitution=e)
    share = 0.4 * (1.0 - e * e)
    assert found.restitution == pytest.approx(sqrt((1.0 - share) / (1.0 + share)), rel=1e-9)
    assert found.restitution == pytest.approx(achieved, abs=5.1e-4)
    assert (found.peak_penetration, found.peak_force) == pytest.approx((depth, whole * depth), rel=1e-9)
    assert found.energy_lost == pytest.approx(loop, rel=1e-9)


class Loop(Path):
    """The bilinear law with a design penetration, at e = 0.65."""

    def __init__(self, stiffness: float, depth: float):
        loop, self.reach, self.anchor = stiffness * depth**2.5 * (1.0 - 0.65**2) / 2.5, 0.1 * depth, 0.0
        self.steep = stiffness * sqrt(depth) + loop / (0.1 * depth**2)
        self.flat = stiffness * sqrt(depth) - loop / (0.9 * depth**2)

    def begin(self):
        self.anchor = 0.0

    def force(self, delta):
        return self.flat * delta + (self.steep - self.flat) * float(np.clip(delta - self.anchor, 0.0, self.reach))

    def turned(self, delta, inwards):
        self.anchor = max(self.anchor, delta - self.reach) if inwards else min(self.anchor, delta)


def test_bilinear_run_against_scipy():
    """Whole run, path and all; to 1e-5, what the fine samples and SciPy's steps over the corners leave."""
    pair = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 0.31, 0.05)
    ground = shaking(4.0, duration=3.0)
    found = solve(*pair, Interface(0.004, Bilinear(2.75e9, 0.005), constant(0.65)), ground, 0.01, rtol=1e-10)
    largest, force, touches = follow_pair(*pair, 0.004, Loop(2.75e9, 0.005), ground, 0.01)
    assert touches == found["impact_count"] >= 4.0
    assert found["energy_plastic"] > 0.0 == found["energy_viscous"]  # its loss is that of the path
    assert found["energy_residual"] < 1e-5 and found["lowest_contact_force"] >= 0.0 == found["permanent_set"]
    assert found["peak_relative_displacement"] == pytest.approx(largest, rel=1e-5)
    assert found["peak_contact_force"] == pytest.approx(force, rel=1e-4)
