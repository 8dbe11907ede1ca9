"""Footprints: metres against the ellipsoid in space, areas against closed forms, distances against shapes moved."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt, tau

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from matplotlib.path import Path as Outline

from pounding_risk.scene.street import footprints
from pounding_risk.scene.street.footprints import Footprint, clear_between, close_pairs, faced

# WGS 84 once more, by its semi-axes, so that a slip in the module's numbers shows.
LONG_AXIS, SHORT_AXIS = 6378137.0, 6356752.314245


def rectangle(width: float, depth: float, at: tuple[float, float] = (0.0, 0.0)) -> Footprint:
    corners = np.array([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
    return Footprint((corners + at,))


def in_space(longitude: float, latitude: float) -> np.ndarray:
    """A point of the ellipsoid in Cartesian coordinates of the Earth's centre, m."""
    squashed = 1.0 - (SHORT_AXIS / LONG_AXIS) ** 2
    radius = LONG_AXIS / sqrt(1.0 - squashed * sin(radians(latitude)) ** 2)
    across = radius * cos(radians(latitude))
    east = (across * cos(radians(longitude)), across * sin(radians(longitude)))
    return np.array([*east, radius * (1.0 - squashed) * sin(radians(latitude))])


@given(
    st.floats(-179.0, 179.0),
    st.floats(-65.0, 65.0),
    st.lists(st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0)), min_size=4, max_size=8, unique=True),
)
def test_metres_are_those_of_the_ellipsoid(longitude, latitude, offsets):
    """Distances of corners within some 300 m: straight lines through space, which are shorter by 1e-10 only.

    The plane's own error is tan φ × distance / 6400 km = 2.1 × 600 m / 6400 km = 2e-4 at most; a sphere instead of the
    ellipsoid would be off by up to 7e-3.
    """
    per_degree = 111e3
    degrees = np.array(offsets) / (per_degree * cos(radians(latitude)), per_degree) + (longitude, latitude)
    (flat,) = footprints.local([Footprint((degrees,))], degrees[0])
    points = np.array([in_space(*each) for each in degrees])
    told = np.linalg.norm(flat.rings[0][:, None] - flat.rings[0], axis=2)
    true = np.linalg.norm(points[:, None] - points, axis=2)
    assert told == pytest.approx(true, rel=3e-4, abs=1e-6)


def test_east_is_x_and_north_is_y():
    corners = np.array([(10.0, 50.0), (10.001, 50.0), (10.0, 50.001)])
    (flat,) = footprints.local([Footprint((corners,))], corners[0])
    origin, east, north = flat.rings[0]
    assert east[0] > origin[0] and east[1] == origin[1]
    assert north[1] > origin[1] and north[0] == origin[0]
    # One minute of latitude is 1852 m within 0.6 %: the nautical mile.
    assert (north[1] - origin[1]) * 1000.0 / 60.0 == pytest.approx(1852.0, rel=6e-3)


def test_areas_and_centres_are_closed_forms():
    """A regular n-gon has n/2 R² sin(2π/n); a hole is taken off; an L is two rectangles."""
    angles = np.arange(7) * tau / 7
    heptagon = np.column_stack([np.cos(angles), np.sin(angles)]) * 5.0 + (1e6, 2e6)
    assert footprints.area(Footprint((heptagon,))) == pytest.approx(3.5 * 25.0 * sin(tau / 7), rel=1e-9)
    assert footprints.centre(Footprint((heptagon[::-1],))) == pytest.approx((1e6, 2e6), abs=1e-8)
    court = Footprint(rectangle(20.0, 30.0).rings, rectangle(5.0, 6.0, (4.0, 4.0)).rings)
    assert footprints.area(court) == 570.0
    wing = np.array([(0, 0), (10, 0), (10, 4), (6, 4), (6, 12), (0, 12)], float)
    assert footprints.area(Footprint((wing,))) == 10 * 4 + 6 * 8
    assert footprints.centre(Footprint((wing,))) == pytest.approx([(40 * 5 + 48 * 3) / 88, (40 * 2 + 48 * 8) / 88])
    parts = Footprint((*rectangle(4.0, 4.0).rings, *rectangle(4.0, 8.0, (10.0, 0.0)).rings))
    assert footprints.area(parts) == 48.0
    assert footprints.centre(parts) == pytest.approx([(2 * 16 + 12 * 32) / 48, (2 * 16 + 4 * 32) / 48])


@pytest.mark.parametrize(
    ("corners", "crosses"),
    [
        ([(0, 0), (4, 0), (4, 4), (0, 4)], False),
        ([(0, 0), (4, 4), (4, 0), (0, 4)], True),
        ([(0, 0), (10, 0), (10, 4), (6, 4), (6, 12), (0, 12)], False),
        ([(0, 0), (10, 0), (10, 4), (-1, 4), (6, 12), (0, 12)], True),
    ],
)
def test_an_outline_that_crosses_itself_is_seen(corners, crosses):
    assert footprints.crosses_itself(np.array(corners, float)) is crosses


@st.composite
def stars(draw) -> np.ndarray:
    """Outlines of three to nine corners at rising angles: convex or not, never crossing themselves."""
    count = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(3.0, 12.0), min_size=count, max_size=count)))
    angles = np.arange(count) * tau / count + draw(st.floats(0.0, 1.0))
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def overlap(one: np.ndarray, other: np.ndarray) -> bool:
    closed = [Outline(np.vstack([each, each[:1]]), closed=True) for each in (one, other)]
    return closed[0].intersects_path(closed[1], filled=True)


@given(stars(), stars(), st.floats(-8.0, 8.0))
def test_moved_together_by_their_clear_distance_two_outlines_touch(left, right, across):
    """Less by 10 µm leaves them apart, more by that lets them overlap; matplotlib tells which."""
    right = right + np.array([40.0, across])
    gap = footprints.clear_distance(Footprint((left,)), Footprint((right,)))
    common = min(left[:, 1].max(), right[:, 1].max()) - max(left[:, 1].min(), right[:, 1].min())
    assume(abs(common) > 1e-3)
    if common < 0.0:
        assert gap == np.inf
        return
    assert 16.0 <= gap <= 64.0  # radii are 12 at most
    assert not overlap(left, right - (gap - 1e-5, 0.0))
    assert overlap(left, right - (gap + 1e-5, 0.0))


def sampled(corners: np.ndarray, step: float) -> np.ndarray:
    """Points on an outline, no farther apart than a step."""
    ends = np.roll(corners, -1, axis=0)
    walls = zip(corners, ends, np.hypot(*(ends - corners).T), strict=True)
    return np.concatenate(
        [start + (end - start) * np.linspace(0, 1, int(w / step) + 2)[:, None] for start, end, w in walls]
    )


@given(stars(), stars(), st.floats(-pi, pi), st.floats(0.0, 40.0))
def test_the_clear_distance_in_any_direction_is_that_of_points_on_the_walls(one, other, angle, away):
    """Points a step apart are as far apart as the outlines, or farther by a step; 0 where matplotlib sees overlap."""
    other = other + away * np.array([cos(angle), sin(angle)])
    step = 0.05
    told = clear_between(Footprint((one,)), Footprint((other,)))
    assert told == pytest.approx(clear_between(Footprint((other,)), Footprint((one,))), rel=1e-12)
    if overlap(one, other):
        assert told == 0.0
        return
    here, there = sampled(one, step), sampled(other, step)
    least = min(float(np.hypot(*(there - point).T).min()) for point in here)
    assert least - step <= told <= least + 1e-9
    assert clear_between(Footprint((one,)), Footprint((other,)), told + 0.1) == pytest.approx(told, rel=1e-12)


def test_a_building_in_a_court_is_clear_and_one_within_the_walls_is_not():
    court = Footprint(rectangle(20.0, 30.0).rings, rectangle(8.0, 8.0, (4.0, 4.0)).rings)
    assert clear_between(court, rectangle(2.0, 2.0, (5.0, 6.0))) == 1.0
    assert clear_between(rectangle(2.0, 2.0, (14.0, 20.0)), court) == 0.0
    assert clear_between(court, rectangle(2.0, 2.0, (20.0, 30.0))) == 0.0  # corner on corner
    assert clear_between(court, rectangle(2.0, 2.0, (23.0, 34.0))) == 5.0  # 3, 4, 5


@given(st.lists(st.tuples(st.floats(0.0, 60.0), st.floats(0.0, 60.0)), min_size=2, max_size=12), st.booleans())
def test_no_close_pair_is_missed(places, metres):
    """Squares of 6 m anywhere: their distance is that of two intervals on each axis. In degrees too, at 60° north."""
    per_degree = (1.0, 1.0) if metres else (55.80e3, 111.41e3)  # m, WGS 84 (Snyder 1987, table 3)
    squares = [rectangle(6.0, 6.0, place) for place in places]
    origin = np.array([0.0, 0.0] if metres else [10.0, 60.0])
    given_ones = [footprints.moved(each, lambda ring: ring / per_degree + origin) for each in squares]
    close = {(one, other): distance for one, other, distance in close_pairs(given_ones, 2.0, metres)}
    for one, (x, y) in enumerate(places):
        for other, (u, v) in enumerate(places[:one]):
            apart = float(np.hypot(max(abs(x - u) - 6.0, 0.0), max(abs(y - v) - 6.0, 0.0)))
            if abs(apart - 2.0) > 0.01:  # degrees of one latitude over 60 m, rounded to four digits
                assert ((other, one) in close) == (apart < 2.0)
            if apart < 1.99:
                assert close[other, one] == pytest.approx(apart, abs=1e-9 if metres else 0.01)


def test_large_outlines_are_compared_in_blocks(monkeypatch):
    """The same distance whatever fits into memory at once."""
    angles = np.arange(700) * tau / 700
    ring = np.column_stack([np.cos(angles), np.sin(angles)]) * 20.0
    round_ones = Footprint((ring,)), Footprint((ring + np.array([40.03, 0.0]),))
    whole = clear_between(*round_ones)
    assert whole == pytest.approx(0.03, rel=1e-9)
    monkeypatch.setattr("pounding_risk.scene.street.footprints.MOST_AT_ONCE", 97)
    assert clear_between(*round_ones) == whole
    assert clear_between(*round_ones, 0.1) == whole


@given(stars(), stars(), st.floats(-20.0, 20.0), st.floats(0.5, 60.0))
def test_the_faced_length_is_that_of_lines_along_the_street(left, right, across, reach):
    """Lines a step apart in v, cut with both outlines by hand: each of some forty corners is off by a step at most."""
    right = right + np.array([40.0, across])
    low, high = max(left[:, 1].min(), right[:, 1].min()), min(left[:, 1].max(), right[:, 1].max())
    length, share = faced(Footprint((left,)), Footprint((right,)), reach)
    assert share == pytest.approx(length / min(np.ptp(left[:, 1]), np.ptp(right[:, 1])), abs=1e-12)
    if high <= low:
        assert length == 0.0
        return
    lines = np.linspace(low, high, 1002)[1:-1]
    gaps = np.array([first(right, v) - last(left, v) for v in lines])
    step = (high - low) / 1001
    assert length == pytest.approx((gaps < reach).sum() * step, abs=40 * step)


def cuts(corners: np.ndarray, v: float) -> list[float]:
    """Where a line along the street cuts an outline."""
    walls = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return [a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in walls if (a[1] > v) != (b[1] > v)]


def first(corners: np.ndarray, v: float) -> float:
    return min(cuts(corners, v))


def last(corners: np.ndarray, v: float) -> float:
    return max(cuts(corners, v))


def test_parts_that_do_not_reach_a_line_do_not_count():
    """A building of two parts faces another through the part that is beside it."""
    parts = Footprint((*rectangle(4.0, 4.0).rings, *rectangle(8.0, 4.0, (0.0, 10.0)).rings))
    low, high = rectangle(5.0, 3.0, (9.0, 0.5)), rectangle(5.0, 3.0, (9.0, 10.5))
    assert footprints.clear_distance(parts, low) == 5.0
    assert footprints.clear_distance(parts, high) == 1.0
    assert footprints.clear_distance(parts, rectangle(5.0, 3.0, (9.0, 5.5))) == np.inf
    assert footprints.facing([low, parts], 6.0, 0.1) == [footprints.Facing(1, 0, 5.0)]
    assert footprints.facing([low, parts], 5.0, 0.1) == []
    assert footprints.facing([rectangle(4.0, 4.0), rectangle(4.0, 4.0, (4.5, 3.95))], 6.0, 0.1) == []


@given(st.floats(-pi, pi), st.lists(st.tuples(st.floats(5.0, 25.0), st.floats(8.0, 30.0)), min_size=2, max_size=6))
def test_the_axis_turns_with_the_street(angle, sizes):
    """Rectangles with one front line, some 20 mm apart: the axis is that line, whatever their depths."""
    place, street = 0.0, []
    for width, depth in sizes:
        street.append(rectangle(width, depth, (place, 0.0)))
        place += width + 0.02
    around = np.array([cos(angle), sin(angle)])
    facing_it = [footprints.moved(each, lambda ring: ring @ [around, [-around[1], around[0]]]) for each in street]
    axis = footprints.street_axis(facing_it, 1.0, 0.1)
    assert axis == pytest.approx(around, abs=1e-9)
    assert footprints.azimuth(axis) == pytest.approx(np.degrees(pi / 2 - angle) % 360.0, abs=1e-6)
    assert footprints.street_axis(facing_it[::-1], 1.0, 0.1) == pytest.approx(-around, abs=1e-9)


def test_walls_without_a_grid_leave_the_line_of_the_centres():
    triangles = [np.array([(0, 0), (9, 0), (4.5, 7.8)], float) + np.array([10.0, 3.0]) * n for n in range(5)]
    axis = footprints.street_axis([Footprint((each,)) for each in triangles], 1.0, 0.1)
    assert axis == pytest.approx(np.array([10.0, 3.0]) / sqrt(109.0), abs=1e-9)
