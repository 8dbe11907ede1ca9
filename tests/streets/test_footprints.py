"""Footprints: metres against the ellipsoid in space, distances along a street against shapes moved, the axis turned."""

from math import cos, pi, radians, sin, sqrt, tau

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from matplotlib.path import Path as Drawn
from sweeps import examples

from pounding_risk.streets import footprints
from pounding_risk.streets.defaults import House, Notes, Rules
from pounding_risk.streets.footprints import Outline, close_pairs, faced, outline_of, shared_face
from pounding_risk.streets.map_files import DEGREES, Projection, system_of
from pounding_risk.streets.neighbours import Street

# WGS 84 once more, by its semi-axes, so that a slip in the module's numbers shows.
LONG_AXIS, SHORT_AXIS = 6378137.0, 6356752.314245


def rectangle(width: float, depth: float, at: tuple[float, float] = (0.0, 0.0)) -> shapely.Polygon:
    return shapely.box(*at, at[0] + width, at[1] + depth)


def seen(*corners: np.ndarray) -> Outline:
    """The outline of a footprint with these rings, as a street that runs east sees it."""
    return outline_of(shapely.MultiPolygon([shapely.Polygon(ring) for ring in corners]))


def in_space(longitude: float, latitude: float) -> np.ndarray:
    """A point of the ellipsoid in Cartesian coordinates of the Earth's centre, m."""
    squashed = 1.0 - (SHORT_AXIS / LONG_AXIS) ** 2
    radius = LONG_AXIS / sqrt(1.0 - squashed * sin(radians(latitude)) ** 2)
    across = radius * cos(radians(latitude))
    east = (across * cos(radians(longitude)), across * sin(radians(longitude)))
    return np.array([*east, radius * (1.0 - squashed) * sin(radians(latitude))])


@examples(
    50,
    st.floats(-179.0, 179.0),
    st.floats(-65.0, 65.0),
    st.lists(st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0)), min_size=4, max_size=8, unique=True),
)
def test_metres_are_those_of_the_ellipsoid(longitude, latitude, offsets):
    """Distances of corners within some 300 m: straight lines through space, which are shorter by 1e-10 only.

    The scale of the plane is 1 + x² / (2 R²), 1e-9 here; a sphere instead of the ellipsoid would be off by up to 7e-3.
    """
    per_degree = 111e3
    degrees = np.array(offsets) / (per_degree * cos(radians(latitude)), per_degree) + (longitude, latitude)
    flat = Projection.about(degrees, system_of(DEGREES)).metres(degrees)
    points = np.array([in_space(*each) for each in degrees])
    told = np.linalg.norm(flat[:, None] - flat, axis=2)
    true = np.linalg.norm(points[:, None] - points, axis=2)
    assert told == pytest.approx(true, rel=3e-9, abs=1e-6)


def test_east_is_x_and_north_is_y():
    corners = np.array([(10.0, 50.0), (10.001, 50.0), (10.0, 50.001)])
    origin, east, north = Projection.about(corners, system_of(DEGREES)).metres(corners)
    # Meridians are at an angle of Δλ sin φ to each other, 1.3e-5 here.
    assert east[0] > origin[0] and abs(east[1] - origin[1]) < 1.4e-5 * (east[0] - origin[0])
    assert north[1] > origin[1] and abs(north[0] - origin[0]) < 1.4e-5 * (north[1] - origin[1])
    # One minute of latitude is 1852 m within 0.6 %: the nautical mile.
    assert (north[1] - origin[1]) * 1000.0 / 60.0 == pytest.approx(1852.0, rel=6e-3)


def test_across_the_meridian_of_180_degrees_footprints_lie_side_by_side():
    """At the equator a degree of longitude is 111.320 km (Snyder 1987, table 3)."""
    corners = np.array([(179.999, 0.0), (-179.999, 0.0)])
    west, east = Projection.about(corners, system_of(DEGREES)).metres(corners)
    assert east[0] - west[0] == pytest.approx(222.64, abs=0.01)


@st.composite
def stars(draw) -> np.ndarray:
    """Outlines of three to nine corners at rising angles: convex or not, never crossing themselves."""
    count = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(3.0, 12.0), min_size=count, max_size=count)))
    angles = np.arange(count) * tau / count + draw(st.floats(0.0, 1.0))
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def overlap(one: np.ndarray, other: np.ndarray) -> bool:
    closed = [Drawn(np.vstack([each, each[:1]]), closed=True) for each in (one, other)]
    return closed[0].intersects_path(closed[1], filled=True)


@given(stars(), stars(), st.floats(-8.0, 8.0))
@pytest.mark.complete
def test_moved_together_by_their_clear_distance_two_outlines_touch(left, right, across):
    """Less by 10 µm leaves them apart, more by that lets them overlap; matplotlib tells which."""
    right = right + np.array([40.0, across])
    gap = footprints.clear_distance(seen(left), seen(right))
    common = min(left[:, 1].max(), right[:, 1].max()) - max(left[:, 1].min(), right[:, 1].min())
    assume(abs(common) > 1e-3)
    if common < 0.0:
        assert gap == np.inf
        return
    assert 16.0 <= gap <= 64.0  # radii are 12 at most
    assert not overlap(left, right - (gap - 1e-5, 0.0))
    assert overlap(left, right - (gap + 1e-5, 0.0))


def test_a_building_in_a_court_is_clear_and_one_within_the_walls_is_not():
    court = rectangle(20.0, 30.0) - rectangle(8.0, 8.0, (4.0, 4.0))
    others = (rectangle(2.0, 2.0, at) for at in ((5.0, 6.0), (14.0, 20.0), (20.0, 30.0), (23.0, 34.0)))
    told = [close_pairs([court, other], 6.0)[1].tolist() for other in others]
    assert told == [[1.0], [0.0], [0.0], [5.0]]  # in the court, in the walls, corner on corner, and 3, 4, 5


@given(st.lists(st.tuples(st.floats(0.0, 60.0), st.floats(0.0, 60.0)), min_size=2, max_size=12))
@pytest.mark.complete
def test_no_close_pair_is_missed(places):
    """Squares of 6 m anywhere: their distance is that of two intervals on each axis."""
    pairs, distances = close_pairs([rectangle(6.0, 6.0, place) for place in places], 2.0)
    close = {tuple(pair): distance for pair, distance in zip(pairs.tolist(), distances, strict=True)}
    for one, (x, y) in enumerate(places):
        for other, (u, v) in enumerate(places[:one]):
            apart = float(np.hypot(max(abs(x - u) - 6.0, 0.0), max(abs(y - v) - 6.0, 0.0)))
            if abs(apart - 2.0) > 1e-9:
                assert ((other, one) in close) == (apart < 2.0)
            if apart < 2.0 - 1e-9:
                assert close[other, one] == pytest.approx(apart, abs=1e-9)


def test_groups_are_what_hangs_together():
    """In the order of their first buildings; 1 stands alone."""
    pairs = np.array([[0, 5], [2, 3], [3, 4], [5, 6]])
    assert [group.tolist() for group in footprints.groups(7, pairs)] == [[[0, 5], [5, 6]], [[2, 3], [3, 4]]]
    assert footprints.groups(3, np.empty((0, 2), np.int64)) == []


@pytest.mark.parametrize(
    ("at", "face"), [((10.5, -2.0), (8.0, 0.8)), ((3.0, 10.4), (7.0, 0.7)), ((10.3, 10.3), (0.0, 0.0))]
)
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_shared_face_is_along_the_walls_of_the_two(at, face, angle):
    """Two squares of 10 m beside, behind and at the corner of each other, turned or not."""
    turn = np.array([[cos(angle), sin(angle)], [-sin(angle), cos(angle)]])
    pair = [shapely.transform(rectangle(10.0, 10.0, place), lambda ring: ring @ turn) for place in ((0.0, 0.0), at)]
    assert shared_face(*pair, 1.1) == pytest.approx(face, abs=1e-9)
    assert shared_face(*pair[::-1], 1.1) == pytest.approx(face, abs=1e-9)


@examples(30, stars(), stars(), st.floats(-20.0, 20.0), st.floats(0.5, 60.0))
@pytest.mark.complete
def test_the_faced_length_is_that_of_lines_along_the_street(left, right, across, reach):
    """Lines a step apart in v, cut with both outlines by hand: each of some forty corners is off by a step at most."""
    right = right + np.array([40.0, across])
    low, high = max(left[:, 1].min(), right[:, 1].min()), min(left[:, 1].max(), right[:, 1].max())
    length, share, _ = faced(seen(left), seen(right), reach)
    assert share == pytest.approx(length / min(np.ptp(left[:, 1]), np.ptp(right[:, 1])), abs=1e-12)
    if high <= low:
        assert length == 0.0
        return
    lines = np.linspace(low, high, 1002)[1:-1]
    gaps = np.array([min(cuts(right, v)) - max(cuts(left, v)) for v in lines])
    step = (high - low) / 1001
    assert length == pytest.approx((gaps < reach).sum() * step, abs=40 * step)


def cuts(corners: np.ndarray, v: float) -> list[float]:
    """Where a line along the street cuts an outline."""
    walls = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return [a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in walls if (a[1] > v) != (b[1] > v)]


def test_parts_that_do_not_reach_a_line_do_not_count():
    """A building of two parts faces another through the part that is beside it."""
    whole = shapely.MultiPolygon([rectangle(4.0, 4.0), rectangle(8.0, 4.0, (0.0, 10.0))])
    parts, low, high, between = (
        outline_of(shape) for shape in (whole, *(rectangle(5.0, 3.0, (9.0, north)) for north in (0.5, 10.5, 5.5)))
    )
    assert footprints.clear_distance(parts, low) == 5.0
    assert footprints.clear_distance(parts, high) == 1.0
    assert footprints.clear_distance(parts, between) == np.inf
    both = np.array([[0, 1]])
    assert footprints.facing([low, parts], both, 6.0, 0.1) == [footprints.Facing(1, 0, 5.0)]
    assert footprints.facing([low, parts], both, 5.0, 0.1) == []
    beside = [outline_of(rectangle(4.0, 4.0, at)) for at in ((0.0, 0.0), (4.5, 3.95))]
    assert footprints.facing(beside, both, 6.0, 0.1) == []


@given(st.floats(-pi, pi), st.lists(st.tuples(st.floats(5.0, 25.0), st.floats(8.0, 30.0)), min_size=2, max_size=6))
@pytest.mark.complete
def test_the_axis_turns_with_the_street(angle, sizes):
    """Rectangles with one front line, some 20 mm apart: the axis is that line, whatever their depths."""
    place, street = 0.0, []
    for width, depth in sizes:
        street.append(rectangle(width, depth, (place, 0.0)))
        place += width + 0.02
    around = np.array([cos(angle), sin(angle)])
    turn = np.array([around, [-around[1], around[0]]])
    facing_it = [shapely.transform(each, lambda ring: ring @ turn) for each in street]
    houses = [House(f"{n}", "", 9.0, 3, "masonry", 1e5, 0.05, footprint=each) for n, each in enumerate(facing_it)]
    for order, sign in ((1, 1.0), (-1, -1.0)):
        (row,) = Street(houses[::order], [house.name for house in houses], Rules(), Notes([], [], [])).lined_up().rows
        assert [house.name for house in row.buildings] == [house.name for house in houses[::order]]
        assert row.gaps == pytest.approx([0.02] * len(row.gaps), abs=1e-9)
        expected = np.degrees(pi / 2 - angle) + (180.0 if sign < 0.0 else 0.0)
        assert cos(radians(row.direction - expected)) == pytest.approx(1.0, abs=1e-12)


def test_walls_without_a_grid_leave_the_line_of_the_centres():
    triangles = [np.array([(0, 0), (9, 0), (4.5, 7.8)], float) + np.array([10.0, 3.0]) * n for n in range(5)]
    shapes = [shapely.Polygon(each) for each in triangles]
    axis, across = footprints.axes(shapes, [outline_of(shape) for shape in shapes])
    assert axis == pytest.approx(np.array([10.0, 3.0]) / sqrt(109.0), abs=1e-9)
    assert axis @ across == pytest.approx(0.0, abs=1e-12)
    assert footprints.azimuth(np.array([1.0, 0.0])) == 90.0
