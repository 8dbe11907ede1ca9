"""Buildings of storeys: modes against SciPy and closed forms, damping rules, generated buildings, published ones."""

from __future__ import annotations

from math import pi, sin, sqrt

import numpy as np
import pytest
import scipy.linalg
from sentences import refusal

from pounding_risk.models.structures.storeys import (
    DAMPING_RULES,
    RAYLEIGH_SHARE,
    Storeys,
    generated,
    stiffnesses_for,
    yield_shears,
)
from pounding_risk.models.structures.typologies import TYPOLOGIES

# Jankowski (2008), Earthquake Engineering and Structural Dynamics 37: two buildings of three storeys, with the storeys'
# dampers; and Cole's two of two storeys, with floors of 1600 and 3000 kN and periods of 0.2 and 0.3 s.
JANKOWSKI = ((25e3, 3.46e6, 6.609e4, 1.2001), (1e6, 2.215e9, 1.058e7, 0.29998))
COLE = ((1600e3, 420e6, 0.2), (3000e3, 350e6, 0.3))


def random_building(seed: int, floors: int = 7, **more) -> Storeys:
    rng = np.random.default_rng(seed)
    values = (rng.uniform(0.5, 2.0, floors) * scale for scale in (3e5, 4e8, 3.0))
    return Storeys("random", *(tuple(each) for each in values), **more)


def known_modes(building: Storeys) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies and shapes with φᵀ M φ = 1, by SciPy, from matrices that are put together here."""
    count = len(building.masses)
    stiffness = np.zeros((count, count))
    for place, spring in enumerate(building.stiffnesses):
        stiffness[place, place] += spring
        if place:
            stiffness[place - 1, place - 1] += spring
            stiffness[place, place - 1] -= spring
            stiffness[place - 1, place] -= spring
    squares, shapes = scipy.linalg.eigh(stiffness, np.diag(building.masses))
    return np.sqrt(squares), shapes


# ------------------------------------------------------------------------------------------------ modes


@pytest.mark.parametrize("floors", [1, 2, 7, 40])
@pytest.mark.parametrize("seed", range(3))
def test_modes_are_those_of_scipy(seed: int, floors: int):
    """SciPy's frequencies have the rounding of the fastest, some 1e4 times the slowest in square."""
    building = random_building(seed, floors)
    frequencies, shapes = building.vibration()
    known, forms = known_modes(building)
    assert frequencies == pytest.approx(known, rel=1e-10)
    assert np.abs(forms.T @ np.diag(building.masses) @ shapes) == pytest.approx(np.eye(floors), abs=1e-9)
    assert (shapes[-1] > 0.0).all()


@pytest.mark.parametrize("floors", [1, 2, 3, 10, 60])
def test_uniform_building(floors: int):
    """ω_j = 2 sqrt(k / m) sin((2j − 1) π / (2 (2n + 1))); rounding alone."""
    building = Storeys("uniform", (3e5,) * floors, (4e8,) * floors, (3.0,) * floors)
    known = [2.0 * sqrt(4e8 / 3e5) * sin((2 * j - 1) * pi / (2 * (2 * floors + 1))) for j in range(1, floors + 1)]
    assert building.vibration().frequencies == pytest.approx(np.array(known), rel=1e-13)


def test_slow_modes_keep_their_digits_on_a_stiff_storey():
    """A storey a billion times stiffer is a rigid joint to 1e-9: the masses above and below move as one."""
    stiff = Storeys("stiff", (1e5, 2e5, 3e5), (1e8, 1e17, 2e8), (3.0,) * 3)
    joined = Storeys("joined", (3e5, 3e5), (1e8, 2e8), (3.0, 3.0))
    assert stiff.vibration().frequencies[:2] == pytest.approx(joined.vibration().frequencies, rel=1e-8)


@pytest.mark.parametrize(("mass", "stiffness", "damper", "period"), JANKOWSKI)
def test_jankowski_2008(mass: float, stiffness: float, damper: float, period: float):
    """Periods and dampers to the digits that are published."""
    building = Storeys("A", (mass,) * 3, (stiffness,) * 3, (3.0,) * 3, 0.05, "stiffness")
    assert building.period == pytest.approx(period, abs=6e-5)
    _, damping, _ = building.matrices()
    assert -damping[0, 1] == pytest.approx(damper, rel=5e-4)


@pytest.mark.parametrize(("weight", "stiffness", "period"), COLE)
def test_cole(weight: float, stiffness: float, period: float):
    """To the digit that is published."""
    building = Storeys("B", (weight / 9.81,) * 2, (stiffness,) * 2, (3.0,) * 2)
    assert building.period == pytest.approx(period, abs=1e-3)


def test_heights_and_mass():
    building = Storeys("A", (2e5, 1e5), (4e8, 3e8), (4.0, 3.0))
    assert (building.levels, building.height, building.mass) == ((4.0, 7.0), 7.0, 3e5)
    assert not building.is_rigid and isinstance(Storeys("B", [1, 2], [3, 4], [5, 6]).masses, tuple)


# ------------------------------------------------------------------------------------------------ damping


def ratios(building: Storeys) -> np.ndarray:
    """ζ of each mode by SciPy's modes; the modes are not coupled."""
    frequencies, shapes = known_modes(building)
    modal = shapes.T @ building.matrices()[1] @ shapes
    assert modal == pytest.approx(np.diag(np.diag(modal)), abs=1e-9 * np.abs(modal).max())
    return np.diag(modal) / (2.0 * frequencies)


def test_modal_damping_is_equal_in_every_mode():
    building = random_building(4, damping=0.07)
    assert ratios(building) == pytest.approx(np.full(7, 0.07), rel=1e-9)


def test_stiffness_damping_grows_with_frequency():
    building = random_building(4, damping=0.02, damping_rule="stiffness")
    frequencies, _ = known_modes(building)
    assert ratios(building) == pytest.approx(0.02 * frequencies / frequencies[0], rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_rayleigh_damping(seed: int):
    """ζ in two modes, less between them, more past them; the second is the one that completes 95 % of the mass."""
    building = random_building(seed, damping=0.05, damping_rule="rayleigh")
    second = building._second_mode()
    found = ratios(building)
    _, shapes = known_modes(building)
    shares = np.cumsum((np.array(building.masses) @ shapes) ** 2) / building.mass
    assert second >= 2 and shares[second - 1] >= RAYLEIGH_SHARE
    assert second == 2 or shares[second - 2] < RAYLEIGH_SHARE
    assert found[[0, second - 1]] == pytest.approx([0.05, 0.05], rel=1e-9)
    assert (found[1 : second - 1] < 0.05).all() and (found[second:] > 0.05).all()


@pytest.mark.parametrize("rule", DAMPING_RULES)
def test_one_storey_is_a_single_mass_under_every_rule(rule: str):
    """c = 2 ζ sqrt(k m)."""
    _, damping, _ = Storeys("A", (3e5,), (4e8,), (3.0,), 0.05, rule).matrices()
    assert damping == pytest.approx(np.array([[2.0 * 0.05 * sqrt(4e8 * 3e5)]]), rel=1e-14)


@pytest.mark.parametrize("rule", DAMPING_RULES)
def test_damping_takes_energy(rule: str):
    """Symmetric to the last bit, and no motion gains from it."""
    _, damping, _ = random_building(9, 20, damping_rule=rule).matrices()
    assert np.array_equal(damping, damping.T) and np.linalg.eigvalsh(damping)[0] > 0.0


# ------------------------------------------------------------------------------------------------ generated


@pytest.mark.parametrize("seed", range(4))
def test_stiffnesses_give_period_and_shape_back(seed: int):
    """SciPy's first mode of what the inverse problem found is the one that was asked for."""
    rng = np.random.default_rng(seed)
    masses, shape = rng.uniform(1e5, 4e5, 9), np.cumsum(rng.uniform(0.1, 1.0, 9))
    building = Storeys("A", tuple(masses), stiffnesses_for(masses, shape, 0.83), (3.0,) * 9)
    frequencies, shapes = known_modes(building)
    assert 2.0 * pi / frequencies[0] == pytest.approx(0.83, rel=1e-10)
    assert shapes[:, 0] / shapes[-1, 0] == pytest.approx(shape / shape[-1], rel=1e-9)


def test_storeys_yield_together_in_the_first_mode():
    """Shears K u of the first mode at S_a = A_y, u = Γ φ S_a / ω²; the base shear is A_y times the mode's mass."""
    masses, shape = np.array([3e5, 2e5, 2e5, 1e5]), np.array([0.2, 0.5, 0.8, 1.0])
    building = Storeys("A", tuple(masses), stiffnesses_for(masses, shape, 0.5), (3.0,) * 4)
    frequencies, shapes = known_modes(building)
    factor = masses @ shapes[:, 0]
    drifts = np.diff(factor * shapes[:, 0] * 1.7 / frequencies[0] ** 2, prepend=0.0)
    found = yield_shears(masses, shape, 1.7)
    assert found == pytest.approx(tuple(np.array(building.stiffnesses) * drifts), rel=1e-9)
    assert found[0] == pytest.approx(1.7 * factor**2, rel=1e-9)


@pytest.mark.parametrize("name", TYPOLOGIES)
def test_generated_buildings(name: str):
    """The period of the code's formula, the stated shape, equal storeys; taller is weaker for its weight."""
    kind = TYPOLOGIES[name]
    building = generated("A", height=24.0, storeys=8, typology=name, floor_mass=3e5)
    frequencies, shapes = known_modes(building)
    assert 2.0 * pi / frequencies[0] == pytest.approx(kind.code.coefficient * 24.0**kind.code.exponent, rel=1e-10)
    levels = np.array(building.levels) / 24.0
    assert shapes[:, 0] / shapes[-1, 0] == pytest.approx(levels**kind.power, rel=1e-9)
    assert building.heights == (3.0,) * 8 and building.masses == (3e5,) * 8
    low = generated("B", height=6.0, storeys=2, typology=name, floor_mass=3e5)
    assert low.strengths[0] / low.mass > building.strengths[0] / building.mass
    assert building.strengths[0] == pytest.approx(
        9.80665 * kind.yield_accelerations[-1] * 24e5 * (shapes[:, 0].sum() * 3e5) ** 2 / 24e5, rel=1e-9
    )


def test_a_period_given_is_kept():
    building = generated("A", height=50.0, storeys=12, typology="steel_frame_ec8", floor_mass=3e5, period=1.9)
    assert building.period == pytest.approx(1.9, rel=1e-12)


def test_periods_in_metres_are_those_in_feet():
    """ASCE 7 prints C_t for feet as well; both agree to the three digits printed."""
    feet = {"concrete_frame": 0.016, "steel_frame": 0.028, "braced_frame": 0.03}
    feet |= dict.fromkeys(("concrete_walls", "masonry"), 0.02)
    for name, coefficient in feet.items():
        code = TYPOLOGIES[name].code
        assert code.verified and code.coefficient == pytest.approx(coefficient / 0.3048**code.exponent, abs=6e-5)
    assert not any(kind.code.verified for name, kind in TYPOLOGIES.items() if name.endswith("_ec8"))


def test_rises():
    """Hazus: low-rise to 3 storeys, mid-rise to 7; masonry low-rise to 2."""
    frame, masonry = TYPOLOGIES["concrete_frame"], TYPOLOGIES["masonry"]
    rises = {1: 0.125, 3: 0.125, 4: 0.104, 7: 0.104, 8: 0.049, 30: 0.049}
    assert {count: frame.yield_acceleration(count) for count in rises} == rises
    assert [masonry.yield_acceleration(count) for count in (1, 2, 3)] == [0.2, 0.2, 0.111]


# ------------------------------------------------------------------------------------------------ words

GOOD = {"masses": (1e5, 1e5), "stiffnesses": (1e8, 1e8), "heights": (3.0, 3.0)}
HOUSE = {"height": 9.0, "storeys": 3, "typology": "masonry", "floor_mass": 2e5}
BAD = {
    "no floor": {"masses": ()},
    "a floor below zero": {"masses": (1e5, -1.0)},
    "one stiffness": {"stiffnesses": (1e8,)},
    "a height that is no number": {"heights": (3.0, float("nan"))},
    "a storey of no height": {"heights": (3.0, 0.0)},
    "one strength": {"strengths": (1e6,)},
    "no strength": {"strengths": (1e6, 0.0)},
    "critical damping": {"damping": 1.0},
    "a rule misspelt": {"damping_rule": "raleigh"},
}
NOT_GENERATED = {
    "a typology misspelt": {"typology": "masonary"},
    "no storey": {"storeys": 0},
    "half a storey": {"storeys": 2.5},
    "true storeys": {"storeys": True},
    "no height": {"height": 0.0},
    "floors without end": {"floor_mass": float("inf")},
    "no period": {"period": 0.0},
    "higher than a code allows": {"typology": "masonry_ec8", "height": 41.0},
}


@pytest.mark.parametrize("fault", BAD)
def test_buildings_that_cannot_be(fault: str, says):
    says(refusal(Storeys, "A", **{**GOOD, **BAD[fault]}))


@pytest.mark.parametrize("fault", NOT_GENERATED)
def test_buildings_that_cannot_be_generated(fault: str, says):
    says(refusal(generated, "A", **{**HOUSE, **NOT_GENERATED[fault]}))
