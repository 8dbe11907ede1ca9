"""Contact points from levels: a worked case by hand, and what holds of any two buildings."""

from __future__ import annotations

from itertools import accumulate
from math import inf, isnan
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

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
from pounding_risk.scene.notes import close_calls

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
