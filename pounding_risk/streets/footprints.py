"""Which footprints face each other, over which length, and the axis of a street; pairs close in any direction.

Footprints are shapely polygons in metres. Along a street, coordinates are u along its axis and v across it, so that
neighbours of a row follow each other in u. shapely, of the extra [maps], is imported where there are footprints.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, inf, nan, pi, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pairs = NDArray[np.int64]  # (n, 2), places of footprints, the smaller first
Geometry = Any  # a Polygon or MultiPolygon of shapely

WALLS = 256  # levels that are compared with the walls beside them at a time
SHORTEST = 1e-3  # m; walls between corners that are closer across u are rounding errors of one
GRID = 0.5  # share of the walls' length that must agree on one rectangular grid, else the axis is that of the centres


class Facing(NamedTuple):
    """Two footprints that face each other: the one at smaller u, the other, and their clear distance in m."""

    left: int
    right: int
    gap: float  # negative where they overlap
    faced: float = nan  # m, across the street
    share: float = nan  # of the shorter front
    overlap: float = 0.0  # m, of walls that touch by a rule


class Outline(NamedTuple):
    """The walls of the outer rings of a footprint, from ``starts`` to ``ends`` (n, 2) of u and v, and its extent."""

    starts: Array
    ends: Array
    low: Array
    high: Array


def rings(footprint: Geometry, *, with_courts: bool = False) -> tuple[Array, ...]:
    """Corners (n, 2) of each outer ring, the first not repeated; or of every ring, those of courts clockwise."""
    import shapely
    from shapely.geometry.polygon import orient

    polygons = shapely.get_parts(footprint)
    outer = shapely.get_exterior_ring(polygons)
    all_rings = shapely.get_rings([orient(polygon) for polygon in polygons]) if with_courts else outer
    return tuple(shapely.get_coordinates(ring)[:-1] for ring in all_rings)


def outline_of(footprint: Geometry) -> Outline:
    """The walls of the outer rings, in the footprint's own coordinates."""
    corners = rings(footprint)
    starts = np.concatenate(corners)
    ends = np.concatenate([part for ring in corners for part in (ring[1:], ring[:1])])
    return Outline(starts, ends, starts.min(axis=0), starts.max(axis=0))


def close_pairs(footprints: Sequence[Geometry], reach: float) -> tuple[Pairs, Array]:
    """All pairs of footprints with a clear distance up to ``reach`` [m], by their places, and those distances."""
    import shapely

    shapes = np.array(footprints, dtype=object)
    first, second = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=reach)
    pairs = np.column_stack([first, second])[first < second]
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs, shapely.distance(shapes[pairs[:, 0]], shapes[pairs[:, 1]])


def groups(count: int, pairs: Pairs) -> list[Pairs]:
    """The pairs of each group of footprints that are connected by pairs, ordered by the first footprint of each."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, group = connected_components(links, directed=False)
    order = np.argsort(group[pairs[:, 0]], kind="stable")
    starts = np.flatnonzero(np.diff(group[pairs[order, 0]], prepend=-1))
    return sorted(np.split(pairs[order], starts[1:]), key=lambda members: int(members.min())) if len(pairs) else []


def turned(outline: Outline, axis: Array) -> Outline:
    """An outline of metres east and north in coordinates along and across a unit vector."""
    rotation = np.array([[axis[0], -axis[1]], [axis[1], axis[0]]])
    starts = outline.starts @ rotation
    return Outline(starts, outline.ends @ rotation, starts.min(axis=0), starts.max(axis=0))


def box_along(axis: Array, low: tuple[float, float], high: tuple[float, float]) -> Geometry:
    """A rectangle in metres east and north, from ``low`` to ``high`` along and across a unit vector."""
    import shapely

    rotation = np.array([[axis[0], axis[1]], [-axis[1], axis[0]]])
    return shapely.transform(shapely.box(*low, *high), lambda corners: corners @ rotation)


def axes(footprints: Sequence[Geometry], outlines: Sequence[Outline]) -> tuple[Array, Array]:
    """Two unit vectors (east, north), at right angles: directions in which a street may run, the likelier one first.

    Walls agree on a rectangular grid, the argument of Σ length exp(4 i angle), which leaves two directions; where less
    than half of their length agrees, these are the principal ones of the buildings' centres. The likelier one is nearer
    to the line of the centres. Each points as the file lists the buildings, first to last, and east where that is
    undecided.
    """
    import shapely

    centres = shapely.get_coordinates(shapely.centroid(np.array(footprints, dtype=object)))
    centres -= centres.mean(axis=0)
    walls = np.concatenate([outline.ends - outline.starts for outline in outlines])
    lengths, angles = np.hypot(*walls.T), np.arctan2(walls[:, 1], walls[:, 0])
    grid_sum = np.sum(lengths * np.exp(4j * angles))
    xx, yy, xy = (centres[:, 0] ** 2).sum(), (centres[:, 1] ** 2).sum(), (centres[:, 0] * centres[:, 1]).sum()
    line = 0.5 * float(np.arctan2(2.0 * xy, xx - yy))
    nearest = line
    if abs(grid_sum) >= GRID * lengths.sum():
        grid = 0.25 * float(np.angle(grid_sum))
        nearest = grid + 0.5 * pi * round((line - grid) / (0.5 * pi))

    def pointing(angle: float) -> Array:
        axis = np.array([cos(angle), sin(angle)])
        along = float((np.arange(len(centres)) - 0.5 * (len(centres) - 1)) @ (centres @ axis))
        return -axis if along < 0.0 or (along == 0.0 and axis[0] < 0.0) else axis

    return pointing(nearest), pointing(nearest + 0.5 * pi)


def azimuth(axis: Array) -> float:
    """Degrees clockwise from north of a vector (east, north)."""
    return float(np.degrees(np.arctan2(axis[0], axis[1])) % 360.0)


def facing(outlines: Sequence[Outline], pairs: Pairs, farthest: float, tolerance: float) -> list[Facing]:
    """The pairs that face each other along u within ``farthest``, over more than ``tolerance`` of v.

    The clear distance is measured along u: the least, over all v that both reach, from the last wall of the left one
    to the first of the right one. Both are linear between corners, so that the least is at a corner of one of them.
    """
    if not len(pairs):
        return []
    low, high = (np.array([outline[end] for outline in outlines]) for end in (2, 3))  # (n, 2 of u and v)
    first, second = pairs.T
    over = np.minimum(high[first, 1], high[second, 1]) - np.maximum(low[first, 1], low[second, 1])
    ahead = low[second, 0] - high[first, 0], low[first, 0] - high[second, 0]  # from one to the next at larger u
    pairs_facing = []
    for k in np.flatnonzero((over > tolerance) & (np.maximum(*ahead) < farthest)):
        i, j = int(first[k]), int(second[k])
        # The order is known where one footprint lies wholly before the other along u.
        known_orders = [order for order, gap in zip(((i, j), (j, i)), ahead, strict=True) if gap[k] >= 0.0]
        orders_tried = known_orders or ((i, j), (j, i))
        nearest = [Facing(left, right, clear_distance(outlines[left], outlines[right])) for left, right in orders_tried]
        best = max(nearest, key=lambda pair: pair.gap)
        if best.gap < farthest:
            pairs_facing.append(best)
    return pairs_facing


def clear_distance(left: Outline, right: Outline) -> float:
    """The least distance along u from ``left`` to ``right``, negative where they overlap; inf where no v is common."""
    bottom, top = max(left.low[1], right.low[1]), min(left.high[1], right.high[1])
    across = np.concatenate([left.starts[:, 1], right.starts[:, 1]])
    levels = np.append(across[(across >= bottom) & (across <= top)], (bottom, top))
    walls = reaches(right, levels, -1.0) - reaches(left, levels, 1.0)
    return float(walls.min(initial=inf)) if bottom <= top else inf


def reaches(outline: Outline, levels: Array, side: float) -> Array:
    """The largest u of the outline at each v (``side`` 1), or the smallest (−1); ∓inf where there is none."""
    starts, ends = outline.starts, outline.ends
    if len(levels) <= WALLS and len(starts) <= WALLS:
        return _reaches_of_walls(starts, ends, levels, side)
    low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
    results = []
    for first in range(0, len(levels), WALLS):  # some at a time, beside their own walls: corners may be many
        group = levels[first : first + WALLS]
        is_near = (low <= group.max()) & (high >= group.min())
        results.append(_reaches_of_walls(starts[is_near], ends[is_near], group, side))
    return np.concatenate(results)


def _reaches_of_walls(starts: Array, ends: Array, levels: Array, side: float) -> Array:
    """As `reaches`, for walls from ``starts`` to ``ends``."""
    rise = ends[:, 1] - starts[:, 1]
    # A wall along u counts by its ends, each of which starts a wall.
    share = (levels[:, None] - starts[:, 1]) / np.where(rise == 0.0, inf, rise)
    is_reached = np.where(rise == 0.0, levels[:, None] == starts[:, 1], (share >= 0.0) & (share <= 1.0))
    u_at_level = starts[:, 0] + share * (ends[:, 0] - starts[:, 0])
    return side * np.where(is_reached, side * u_at_level, -inf).max(axis=1, initial=-inf)


def faced(left: Outline, right: Outline, farthest: float) -> tuple[float, float, float]:
    """The length across u [m] over which two outlines face each other, its share of the shorter front, the distance.

    They face each other where both reach and the distance from ``left`` to ``right`` along u is below ``farthest``
    [m]. Between two corners that distance is linear, and so is known from two levels in between. The third value [m] is
    the distance of the walls there in any direction: square to walls that are askew to u it is less than along u. It is
    infinite where none face each other.
    """
    import shapely

    levels = np.unique(np.concatenate([left.starts[:, 1], right.starts[:, 1]]))
    steps = np.diff(levels)
    inner = (levels[:-1] + 0.25 * steps, levels[:-1] + 0.75 * steps)
    sides = np.array([[reaches(outline, level, side) for level in inner] for outline, side in ((left, 1), (right, -1))])
    clear = sides[1] - sides[0]
    in_both = np.isfinite(clear).all(axis=0)  # inf where one of them does not reach
    low, high = np.sort(clear[:, in_both], axis=0)
    spread = high - low  # over half of the interval
    start, width = low - 0.5 * spread, 2.0 * spread
    share = np.clip((farthest - start) / np.where(spread > 0.0, width, 1.0), 0.0, 1.0)
    share = np.where(spread > 0.0, share, low < farthest)
    length = float(steps[in_both] @ share)
    fronts = [float(outline.high[1] - outline.low[1]) for outline in (left, right)]
    is_long = in_both & (steps > SHORTEST)
    below, above = sides[:, 0, is_long], sides[:, 1, is_long]
    ends = np.stack([1.5 * below - 0.5 * above, 1.5 * above - 0.5 * below], axis=-1)  # at both ends of each interval
    across = np.broadcast_to(np.stack([levels[:-1], levels[1:]], axis=-1)[is_long], ends.shape)
    walls = shapely.linestrings(np.stack([ends, across], axis=-1))
    return length, min(length / min(fronts), 1.0), float(shapely.distance(*walls).min(initial=inf))


def shared_face(one: Geometry, other: Geometry, farthest: float) -> tuple[float, float]:
    """The length over which two footprints face each other along the grid of their own walls, and its share.

    The direction with the longer length counts, as for a building in the corner of another one.
    """
    best = 0.0, 0.0
    outlines = outline_of(one), outline_of(other)
    for axis in axes([one, other], outlines):
        pair = turned(outlines[0], axis), turned(outlines[1], axis)
        for face in facing(pair, np.array([[0, 1]]), farthest, 0.0):
            best = max(best, faced(pair[face.left], pair[face.right], farthest)[:2])
    return best


def last_decimal(numbers: Array, unit: float, coarse: float, most: int) -> tuple[int, float]:
    """The decimals of coordinates, and the size of the last one on the ground [m]; NaN where below ``coarse`` [m].

    ``unit`` is one of the coordinates' units in metres; at most so many decimals are looked at.
    """
    rounding = 4.0 * np.spacing(np.abs(numbers))  # programs that snap to a grid multiply by its step
    for decimals in range(most):
        size = 10.0**-decimals * unit
        if size >= coarse and (np.abs(numbers - numbers.round(decimals)) <= rounding).all():
            return decimals, size
    return most, nan
