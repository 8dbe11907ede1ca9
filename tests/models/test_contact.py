"""The contact laws as formulas: what each returns for given numbers, before any motion."""

from __future__ import annotations

from math import inf, sqrt

import closed_forms as exact
import numpy as np
import pytest
from scipy.integrate import quad

from pounding_risk.models.contact import (
    LAWS,
    VanMier,
    ViscousElastoplastic,
    exact_hertz_damping,
    jankowski_ratio,
    kelvin_voigt_ratio,
    stiffness_quantity,
)

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
def test_full_restitution_takes_no_energy(name: str):
    """e = 1 leaves no damping: the force on approach is the force on restitution."""
    law = law_of(name)
    memory = law.begin(1.0, 0.5, 570.0)
    assert memory == 0.0
    for depth in DEPTHS:
        assert law.force(memory, depth, 0.4, True) == law.force(memory, depth, -0.4, False)


@pytest.mark.parametrize("name", LAWS)
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


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if law.capped])
def test_the_plateau_joins_the_elastic_branch(name: str):
    """Where β δ^1.5 = F_E both branches have one value."""
    law = law_of(name)
    depth = (YIELD / law.stiffness) ** (2.0 / 3.0)
    assert law.plateau(depth, YIELD) == pytest.approx(YIELD, rel=1e-14)
    assert law.force(0.0, depth, 0.0, False) == pytest.approx(YIELD, rel=1e-14)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.5])
def test_van_mier_past_yield(exponent: float):
    """K_p δ^n with K_p from continuity at F_E; n = 1.5 is K_e δ^1.5 again, n = 0 stays at F_E."""
    law = VanMier(2.75e9, exponent)
    depth = (YIELD / 2.75e9) ** (2.0 / 3.0)
    for times in (1.0, 1.7, 8.0):
        assert law.plateau(times * depth, YIELD) == pytest.approx(YIELD * times**exponent, rel=1e-14)
    if exponent == 1.5:
        assert law.plateau(5e-3, YIELD) == pytest.approx(2.75e9 * 5e-3**1.5, rel=1e-14)


@pytest.mark.parametrize(("e", "d"), exact.EXACT_HERTZ_DAMP.items())
def test_exact_damping_of_hertz_damp(e: float, d: float):
    """Five digits of the table, and the relation itself to rounding."""
    found = exact_hertz_damping(e)
    assert found == pytest.approx(d, abs=6e-6)
    assert found * (1.0 + e) == pytest.approx(np.log1p(found) - np.log1p(-found * e), rel=1e-13)


@pytest.mark.parametrize("e", [1e-3, 0.01, 0.05, 0.2, 0.98, 0.999, 1.0 - 1e-9, 1.0])
def test_exact_damping_has_a_root_everywhere(e: float):
    """0 ≤ d < 1/e, so that the force 1 + d δ̇/v0 with |δ̇| ≤ e v0 on restitution cannot pull."""
    found = exact_hertz_damping(e)
    assert 0.0 <= found < 1.0 / e and (found > 0.0) == (e < 1.0)


def test_damping_ratios():
    """ξ of Kelvin-Voigt and of Jankowski's eq. (2b) at the usual concrete value, to their printed digits."""
    assert kelvin_voigt_ratio(0.65) == pytest.approx(0.13585, abs=5e-6)
    assert jankowski_ratio(0.65) == pytest.approx(0.3728, abs=5e-5)
    assert kelvin_voigt_ratio(1.0) == jankowski_ratio(1.0) == 0.0


@pytest.mark.parametrize("name", LAWS)
def test_force_on_approach(name: str):
    """Positive, rising with depth and with speed."""
    law = law_of(name)
    memory = law.begin(0.65, 0.5, 570.0)
    forces = [law.force(memory, depth, 0.3, True) for depth in DEPTHS]
    assert forces[0] > 0.0 and np.all(np.diff(forces) > 0.0)
    assert law.force(memory, 1e-3, 0.4, True) >= law.force(memory, 1e-3, 0.3, True)


@pytest.mark.parametrize("name", LAWS)
def test_a_touch_from_rest_has_a_finite_force(name: str):
    """v0 = 0 divides in the Hertz-damp laws; what a law remembers stays finite."""
    law = law_of(name)
    memory = law.begin(0.65, 0.0, 570.0)
    assert np.isfinite(memory) and np.isfinite(law.force(memory, 1e-6, 1e-9, True))


def test_viscous_elastoplastic_is_jankowski_below_yield():
    law, free = ViscousElastoplastic(2.75e9), LAWS["jankowski"](2.75e9)
    memory = law.begin(0.65, 0.5, 570.0)
    assert memory == free.begin(0.65, 0.5, 570.0) == 2.0 * jankowski_ratio(0.65) * sqrt(2.75e9 * 570.0)
    for depth in DEPTHS:
        for rate, approaching in ((0.2, True), (-0.2, False)):
            assert law.force(memory, depth, rate, approaching) == free.force(memory, depth, rate, approaching)
