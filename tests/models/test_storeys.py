"""Buildings of storeys: modes against SciPy and closed forms, damping rules, and where the floors of two meet."""

from itertools import accumulate
from math import inf, isnan, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from sentences import refusal, refusals

from pounding_risk.models.structures.contact_points import (
    COLUMN,
    FLOOR,
    LevelRule,
    automatic_points,
    given_point,
    level_gap,
    outlines,
    usual_depth,
)
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import (
    DAMPING_RULES,
    RAYLEIGH_SHARE,
    Storeys,
    generated,
    stiffnesses_for,
    yield_shears,
)
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.scene.notes import close_calls

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
WRONG = {
    "masses": [(), (1e5, -1.0)],
    "stiffnesses": [(1e8,)],
    "heights": [(3.0, float("nan")), (3.0, 0.0)],
    "strengths": [(1e6,), (1e6, 0.0)],
    "damping": [1.0],
    "damping_rule": ["raleigh"],
}
NOT_GENERATED = {"typology": ["masonary"], "storeys": [0, 2.5, True], "height": [0.0], "floor_mass": [float("inf")]}


def test_buildings_that_cannot_be(says):
    """Nor be generated, such as higher than a code allows."""
    says(*refusals(Storeys, "A", wrong=WRONG, **GOOD))
    says(*refusals(generated, "A", wrong=NOT_GENERATED | {"period": [0.0]}, **HOUSE))
    says(refusal(generated, "A", **HOUSE | {"typology": "masonry_ec8", "height": 41.0}))


ROUNDING = 1e-9  # m: levels are sums of some thirty storeys


class Tower(NamedTuple):
    """A building with floors at these levels."""

    levels: tuple[float, ...]
    is_rigid: bool = False


def mass(height: float = 0.0) -> Building:
    return Building("mass", 1e5, 0.5, 0.05, height=height)


def wall(height: float = 0.0) -> Building:
    return Building("wall", inf, 0.0, 0.0, height=height)


def tower(*heights: float) -> Tower:
    return Tower(tuple(accumulate(heights)))


THREE, TWO = tower(3.0, 3.0, 3.0), tower(4.0, 3.5)


@pytest.mark.parametrize(
    ("left", "right", "points"),
    [
        (THREE, tower(3.0, 3.02), [(1, 1, FLOOR, 3.0), (2, 2, FLOOR, 6.01)]),
        # 3 m is 3/4 up its first storey; 4 m is 1/3 up the second, 6 m 2/3.5 up; 7.5 m is half-way up the third.
        (
            THREE,
            TWO,
            [(1, 0.75, COLUMN, 3.0), (4 / 3, 1, COLUMN, 4.0), (2, 11 / 7, COLUMN, 6.0), (2.5, 2, COLUMN, 7.5)],
        ),
        (tower(3.0), tower(4.0), [(1, 0.75, COLUMN, 3.0)]),
        (mass(6.0), THREE, [(1, 2, FLOOR, 6.0)]),
        (mass(7.5), THREE, [(1, 2.5, COLUMN, 7.5)]),
        (mass(18.0), THREE, [(0.5, 3, COLUMN, 9.0)]),
        (mass(), THREE, [(1, 3, FLOOR, 9.0)]),
        (mass(6.0), mass(), [(1, 1, FLOOR, 6.0)]),
        (mass(6.0), mass(6.04), [(1, 1, FLOOR, 6.02)]),
        (mass(6.0), mass(8.0), [(1, 0.75, COLUMN, 6.0)]),
        (wall(), THREE, [(1 / 3, 1, FLOOR, 3.0), (2 / 3, 2, FLOOR, 6.0), (1, 3, FLOOR, 9.0)]),
        (wall(4.0), THREE, [(0.75, 1, FLOOR, 3.0), (1, 4 / 3, COLUMN, 4.0)]),
        (wall(), mass(6.0), [(1, 1, FLOOR, 6.0)]),
        (wall(12.0), mass(6.0), [(0.5, 1, FLOOR, 6.0)]),
    ],
)
def test_points_worked_by_hand(left, right, points):
    """Both ways round; the formulas are ratios of small numbers, right to some roundings."""
    for one, other, wanted in ((left, right, points), (right, left, [(b, a, *rest) for a, b, *rest in points])):
        found = automatic_points(one, other)
        assert [point[2] for point in found] == [point[2] for point in wanted]
        for point, told in zip(found, wanted, strict=True):
            assert (point[0], point[1], point[3]) == pytest.approx((told[0], told[1], told[3]), rel=1e-12)


@pytest.mark.parametrize("other", [mass(), wall()])
def test_two_without_heights_meet_mass_to_mass(other):
    ((left, right, kind, level),) = automatic_points(mass(), other)
    assert (left, right, kind) == (1.0, 1.0, FLOOR)
    assert isnan(level)


def test_a_given_point_has_the_level_of_its_floor():
    assert given_point(THREE, TWO, 2.0, 1.5) == (2.0, 1.5, COLUMN, 6.0)
    assert given_point(THREE, wall(9.0), 2.0, 0.5) == (2.0, 0.5, FLOOR, 6.0)
    assert level_gap(THREE, TWO, 2.0, 1.5) == pytest.approx(0.25)
    assert level_gap(mass(), mass(), 1.0, 1.0) == 0.0


def kinds(left, right, rule: LevelRule) -> list[str]:
    return [point[2] for point in automatic_points(left, right, rule.is_one)]


@pytest.mark.parametrize("higher", [0.053, 0.09, 0.15, 0.249])
def test_slabs_that_overlap_meet_floor_to_floor(higher):
    """A slab of 250 mm whose top is less than that above the other's: by hand, both are one point half-way up."""
    low, high = tower(3.0), tower(3.0 + higher, 3.0)
    for left, right in ((low, high), (high, low)):
        assert automatic_points(left, right) == [(1.0, 1.0, FLOOR, pytest.approx(3.0 + higher / 2, rel=1e-12))]


@pytest.mark.parametrize("higher", [0.25, 0.251, 0.4])
def test_slabs_that_do_not_overlap_meet_columns(higher):
    low, high = tower(3.0), tower(3.0 + higher, 3.0)
    assert [point[2:] for point in automatic_points(low, high)] == [(COLUMN, 3.0)]
    assert [point[2:] for point in automatic_points(high, low)] == [(COLUMN, 3.0)]


@pytest.mark.parametrize("apart", [0.125, 0.25])
def test_the_depth_of_the_higher_floor_decides_at_both_sides_of_the_limit(apart):
    """At the limit slabs touch by a line, a micrometre below it they overlap."""
    low, high = Tower((3.0, 6.0)), Tower((3.0 + apart, 6.0))
    deep, thin = apart + 1e-6, 0.01
    assert kinds(low, high, LevelRule(thin, deep)) == kinds(high, low, LevelRule(deep, thin)) == [FLOOR, FLOOR]
    for rule, left, right in ((LevelRule(deep, apart), low, high), (LevelRule(apart, deep), high, low)):
        assert kinds(left, right, rule) == [COLUMN, COLUMN, FLOOR]  # the lower floor's depth has no say


def test_a_tolerance_stands_in_place_of_depths():
    low, high = Tower((3.0, 6.0)), Tower((3.125, 6.0))
    assert kinds(low, high, LevelRule(0.5, 0.5, tolerance=0.0625)) == [COLUMN, COLUMN, FLOOR]
    assert kinds(low, high, LevelRule(0.01, 0.01, tolerance=0.125)) == [FLOOR, FLOOR]  # a tolerance holds its end


def test_floors_are_usually_as_deep_as_a_slab_and_less_in_a_model():
    """ACI 318-19, table 7.3.1.1, one end continuous: 6 m / 24. A shaking-table model of 0.4 m storeys has thin ones."""
    assert usual_depth(THREE) == usual_depth(mass(6.0)) == usual_depth(mass()) == 6.0 / 24.0
    assert usual_depth(tower(0.6, 0.4)) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("apart", "rule", "calls"),
    [
        (0.0, LevelRule(), []),
        (0.19, LevelRule(), []),
        (0.21, LevelRule(), [(1, 1, True)]),
        (0.29, LevelRule(), [(1, 1, False)]),
        (0.31, LevelRule(), []),
        (0.09, LevelRule(tolerance=0.05), [(1, 1, False)]),
        (0.2, LevelRule(tolerance=0.05), [(1, 1, False)]),  # far from the tolerance, and slabs overlap all the same
        (0.26, LevelRule(tolerance=0.05), []),
        (0.45, LevelRule(0.5, 0.5), [(1, 1, True)]),  # within 20 %
    ],
)
def test_what_a_small_change_would_alter_is_told(apart, rule, calls):
    low, high = tower(3.0, 4.0), tower(3.0 + apart, 4.0 - apart)
    for left, right in ((low, high), (high, low)):
        assert [(call.left_floor, call.right_floor, call.is_one) for call in close_calls(left, right, rule)] == calls


def test_nothing_is_told_where_the_kind_of_contact_stays():
    """A floor is met like a floor wherever it meets a wall; masses without heights have no levels."""
    assert close_calls(wall(9.2), THREE, LevelRule()) == []
    assert close_calls(mass(), mass(), LevelRule()) == []


DEPTHS = st.floats(1e-3, 0.5)  # less than half of any storey below
RULES = st.builds(LevelRule, DEPTHS, DEPTHS, st.none() | DEPTHS)
TOWERS = st.lists(st.floats(1.1, 8.0) | st.sampled_from([2.8, 3.0, 3.5]), min_size=1, max_size=30).map(
    lambda heights: tower(*heights)
)
BUILDINGS = st.one_of(TOWERS, st.builds(mass, st.floats(1.0, 50.0)), st.builds(wall, st.floats(1.0, 50.0)))


@given(left=BUILDINGS | st.just(mass()), right=BUILDINGS | st.just(wall()), rule=RULES)
def test_points_of_any_two(left, right, rule):
    found = automatic_points(left, right, rule.is_one)
    mirrored = automatic_points(right, left, LevelRule(rule.right_depth, rule.left_depth, rule.tolerance).is_one)
    assert [(b, a, *rest) for a, b, *rest in found] == mirrored or all(isnan(point[3]) for point in found)
    assert found, "two buildings side by side can always touch"
    sides = outlines(left, right)
    tops = [side.levels[-1] for side in sides]
    for a, b, kind, level in found:
        assert a > 0.0 < b, "a point at the ground"
        assert a == int(a) or b == int(b), "a column against a column"
        if not isnan(level):
            assert abs(sides[0].level_of(a) - sides[1].level_of(b)) <= rule.largest + ROUNDING
            assert level <= min(tops) + rule.largest
        assert kind == FLOOR or a != int(a) or b != int(b)
    assert len({point[0] for point in found}) == len({point[1] for point in found}) == len(found)
    assert sorted(found) == found, "points cross each other"
    if not isnan(found[-1][3]):
        assert abs(found[-1][3] - min(tops)) <= rule.largest, "the lower roof has no point"


@given(left=TOWERS, right=TOWERS, rule=RULES)
def test_every_floor_up_to_the_other_roof_has_its_point(left, right, rule):
    found = automatic_points(left, right, rule.is_one)
    for side, (one, other) in enumerate(((left, right), (right, left))):
        met = {point[side] for point in found}
        assert all(place + 1.0 in met for place, level in enumerate(one.levels) if level <= other.levels[-1])
