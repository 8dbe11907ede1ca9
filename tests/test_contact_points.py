"""Contact points from levels: a worked case by hand, and what holds of any two buildings."""

from __future__ import annotations

from itertools import accumulate
from math import inf, isnan
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pounding_risk.contact_points import COLUMN, FLOOR, automatic_points, given_point, level_gap, outlines
from pounding_risk.models.structures import Building

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


TOLERANCES = st.floats(1e-3, 0.5)
TOWERS = st.lists(st.floats(1.1, 8.0) | st.sampled_from([2.8, 3.0, 3.5]), min_size=1, max_size=30).map(
    lambda heights: tower(*heights)
)
BUILDINGS = st.one_of(TOWERS, st.builds(mass, st.floats(1.0, 50.0)), st.builds(wall, st.floats(1.0, 50.0)))


@given(left=BUILDINGS | st.just(mass()), right=BUILDINGS | st.just(wall()), tolerance=TOLERANCES)
def test_points_of_any_two(left, right, tolerance):
    found = automatic_points(left, right, tolerance)
    mirrored = automatic_points(right, left, tolerance)
    assert [(b, a, *rest) for a, b, *rest in found] == mirrored or all(isnan(point[3]) for point in found)
    assert found, "two buildings side by side can always touch"
    sides = outlines(left, right)
    tops = [side.levels[-1] for side in sides]
    for a, b, kind, level in found:
        assert a > 0.0 < b, "a point at the ground"
        assert a == int(a) or b == int(b), "a column against a column"
        if not isnan(level):
            assert abs(sides[0].level_of(a) - sides[1].level_of(b)) <= tolerance + ROUNDING
            assert level <= min(tops) + tolerance
        assert kind == FLOOR or a != int(a) or b != int(b)
    assert len({point[0] for point in found}) == len({point[1] for point in found}) == len(found)
    assert sorted(found) == found, "points cross each other"
    if not isnan(found[-1][3]):
        assert abs(found[-1][3] - min(tops)) <= tolerance, "the lower roof has no point"


@given(left=TOWERS, right=TOWERS, tolerance=TOLERANCES)
def test_every_floor_up_to_the_other_roof_has_its_point(left, right, tolerance):
    found = automatic_points(left, right, tolerance)
    for side, (one, other) in enumerate(((left, right), (right, left))):
        met = {point[side] for point in found}
        assert all(place + 1.0 in met for place, level in enumerate(one.levels) if level <= other.levels[-1])
