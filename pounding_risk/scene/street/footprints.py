"""Footprints of buildings: metres from longitude and latitude, the axis of a street, clear distances.

Along a street, coordinates are u along its axis and v across it, so that neighbours of a row follow each other in u.
`close_pairs` and `clear_between` measure in any direction, which a row does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import cos, hypot, inf, pi, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EQUATOR, FLATTENING = 6378137.0, 1.0 / 298.257223563  # m; WGS 84, on which GeoJSON stands (RFC 7946, 4)
WALLS = 256  # of a ring, compared at a time
GRID = 0.5  # share of the walls' length that must agree on one rectangular grid, else the axis is that of the centres


class Footprint(NamedTuple):
    """The outline of a building: corners (n, 2) of each outer ring and of each hole, the first not repeated."""

    rings: tuple[Array, ...]
    holes: tuple[Array, ...] = ()


class Facing(NamedTuple):
    """Two footprints that face each other: the one at smaller u, the other, and their clear distance in m."""

    left: int
    right: int
    gap: float  # negative where they overlap


def middle(footprints: Sequence[Footprint]) -> Array:
    """The mean corner of the outer rings."""
    mean: Array = np.concatenate([ring for footprint in footprints for ring in footprint.rings]).mean(axis=0)
    return mean


def local(footprints: Sequence[Footprint], origin: Array) -> list[Footprint]:
    """Degrees of longitude and latitude to metres east and north of an origin, in degrees too.

    x = N cos φ₀ (λ − λ'), y = M (φ − φ'), with the ellipsoid's radii of curvature at the mean corner's latitude φ₀:
    across the meridian N = a / sqrt(1 − e² sin² φ₀), along it M = N (1 − e²) / (1 − e² sin² φ₀). A length is off by
    some tan φ₀ × distance from the mean corner / 6400 km: 1e-4 of it at the ends of a street of one kilometre.
    """
    squashed = FLATTENING * (2.0 - FLATTENING)  # e²
    latitude = radians(middle(footprints)[1])
    root = 1.0 - squashed * sin(latitude) ** 2
    across = EQUATOR / sqrt(root)
    scale = np.radians([across * cos(latitude), across * (1.0 - squashed) / root])
    return [moved(footprint, lambda ring: (ring - origin) * scale) for footprint in footprints]


def moved(footprint: Footprint, how: Callable[[Array], Array]) -> Footprint:
    """The footprint with ``how`` applied to the corners of every ring."""
    return Footprint(*(tuple(how(ring) for ring in rings) for rings in footprint))


def turned(footprints: Sequence[Footprint], axis: Array) -> list[Footprint]:
    """The footprints in coordinates along and across a unit vector."""
    to = np.array([[axis[0], -axis[1]], [axis[1], axis[0]]])
    return [moved(footprint, lambda ring: ring @ to) for footprint in footprints]


def ring_area(ring: Array) -> float:
    """Signed area of a ring (shoelace formula), positive where its corners run anticlockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def area(footprint: Footprint) -> float:
    """Area within the outer rings, less that of the holes, m²."""
    outer, inner = (sum(abs(ring_area(ring)) for ring in rings) for rings in footprint)
    return outer - inner


def centre(footprint: Footprint) -> Array:
    """Centroid of the area within the outer rings."""
    weights, centres = [], []
    for ring in footprint.rings:
        relative = ring - ring[0]
        after = np.roll(relative, -1, axis=0)
        crossed = relative[:, 0] * after[:, 1] - after[:, 0] * relative[:, 1]
        weights.append(abs(0.5 * crossed.sum()))
        centres.append(ring[0] + ((relative + after) * crossed[:, None]).sum(axis=0) / (3.0 * crossed.sum()))
    return np.average(centres, axis=0, weights=weights)


def crosses_itself(ring: Array) -> bool:
    """True where two sides of a ring that do not follow each other meet; such an outline has no inside.

    Walls whose bounding boxes are apart cannot meet: a group of successive walls is compared only with those whose box
    meets the group's, so that a ring of many corners takes little memory.
    """
    start, end = ring, np.roll(ring, -1, axis=0)
    low, high = np.minimum(start, end), np.maximum(start, end)
    for first in range(0, len(ring), WALLS):
        group = slice(first, first + WALLS)
        near = np.all((low <= high[group].max(axis=0)) & (high >= low[group].min(axis=0)), axis=1)
        for others in np.array_split(np.flatnonzero(near), max(1, near.sum() // WALLS)):
            walls = start[group], end[group]
            other_walls = start[others], end[others]
            if np.any(straddles(walls, other_walls) & straddles(other_walls, walls).T):
                return True
    return False


def straddles(walls: tuple[Array, Array], others: tuple[Array, Array]) -> NDArray[np.bool_]:
    """For walls (rows) and ``others`` (columns): True where the other ends on both sides of the line of the wall."""
    start, step = walls[0], walls[1] - walls[0]

    def side(of: Array) -> Array:
        apart = of[None, :, :] - start[:, None, :]
        return np.sign(step[:, None, 0] * apart[..., 1] - step[:, None, 1] * apart[..., 0])

    return side(others[0]) * side(others[1]) < 0.0


def street_axis(footprints: Sequence[Footprint], farthest: float, tolerance: float) -> Array:
    """The unit vector along a street: the walls' direction in which most buildings face each other.

    Walls agree on a rectangular grid, the argument of Σ length exp(4 i angle), which leaves two directions; where less
    than half of their length agrees, these are the principal ones of the buildings' centres. The one along which more
    pairs face each other within ``farthest`` is the axis; of equals, the one nearer to the line of the centres. It
    points as the file lists the buildings, first to last, and east where that is undecided.
    """
    centres = np.array([centre(footprint) for footprint in footprints])
    centres -= centres.mean(axis=0)
    walls = np.concatenate([np.roll(ring, -1, axis=0) - ring for footprint in footprints for ring in footprint.rings])
    lengths, angles = np.hypot(*walls.T), np.arctan2(walls[:, 1], walls[:, 0])
    agreed = np.sum(lengths * np.exp(4j * angles))
    xx, yy, xy = (centres[:, 0] ** 2).sum(), (centres[:, 1] ** 2).sum(), (centres[:, 0] * centres[:, 1]).sum()
    line = 0.5 * float(np.arctan2(2.0 * xy, xx - yy))
    nearest = line
    if abs(agreed) >= GRID * lengths.sum():
        grid = 0.25 * float(np.angle(agreed))
        nearest = grid + 0.5 * pi * round((line - grid) / (0.5 * pi))
    candidates = [np.array([cos(angle), sin(angle)]) for angle in (nearest, nearest + 0.5 * pi)]
    met = [len(facing(turned(footprints, axis), farthest, tolerance)) for axis in candidates]
    axis = candidates[int(np.argmax(met))]
    listed = np.arange(len(centres)) - 0.5 * (len(centres) - 1)
    along = float(listed @ (centres @ axis))
    return -axis if along < 0.0 or (along == 0.0 and axis[0] < 0.0) else axis


def azimuth(axis: Array) -> float:
    """Degrees clockwise from north of a vector (east, north)."""
    return float(np.degrees(np.arctan2(axis[0], axis[1])) % 360.0)


def facing(footprints: Sequence[Footprint], farthest: float, tolerance: float) -> list[Facing]:
    """Pairs that face each other along u within ``farthest``, over more than ``tolerance`` of v.

    The clear distance is measured along u: the least, over all v that both reach, from the last wall of the left one
    to the first of the right one. Both are linear between corners, so that the least is at a corner of one of them.
    """
    ends = np.array([_ends(facing_pair) for facing_pair in footprints])  # (n, 2 of low and high, 2 of u and v)
    low, high = ends[:, 0], ends[:, 1]
    over = np.minimum(high[:, None, 1], high[None, :, 1]) - np.maximum(low[:, None, 1], low[None, :, 1])
    apart = low[None, :, 0] - high[:, None, 0]  # from one to the next at larger u
    near = (over > tolerance) & (np.maximum(apart, apart.T) < farthest)
    pairs_facing = []
    for first, second in zip(*np.nonzero(np.triu(near, 1)), strict=True):
        pairs = ((int(first), int(second)), (int(second), int(first)))
        nearest = [Facing(*pair, clear_distance(*(footprints[number] for number in pair))) for pair in pairs]
        best = max(nearest, key=lambda facing_pair: facing_pair.gap)
        if best.gap < farthest:
            pairs_facing.append(best)
    return pairs_facing


def _ends(footprint: Footprint) -> tuple[Array, Array]:
    corners = np.concatenate(footprint.rings)
    return corners.min(axis=0), corners.max(axis=0)


def clear_distance(left: Footprint, right: Footprint) -> float:
    """The least distance along u from ``left`` to ``right``, negative where they overlap; inf where no v is common."""
    (_, bottom), (_, top) = np.maximum(_ends(left)[0], _ends(right)[0]), np.minimum(_ends(left)[1], _ends(right)[1])
    across = np.concatenate([ring[:, 1] for footprint in (left, right) for ring in footprint.rings])
    levels = np.unique(np.append(across[(across >= bottom) & (across <= top)], (bottom, top)))
    walls = reaches(right, levels, -1.0) - reaches(left, levels, 1.0)
    return float(walls.min(initial=inf)) if bottom <= top else inf


def reaches(footprint: Footprint, levels: Array, side: float) -> Array:
    """The largest u of the outline at each v (``side`` 1), or the smallest (−1); ∓inf where there is none."""
    starts = np.concatenate(footprint.rings)
    ends = np.concatenate([np.roll(ring, -1, axis=0) for ring in footprint.rings])
    low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
    reached = [levels]  # of no level none
    for first in range(0, len(levels), WALLS):  # some at a time, beside their own walls: corners may be many
        group = levels[first : first + WALLS]
        near = (low <= group.max()) & (high >= group.min())
        reached.append(_reached(starts[near], ends[near], group, side))
    return np.concatenate(reached[1:] or reached)


def _reached(starts: Array, ends: Array, levels: Array, side: float) -> Array:
    """As `reaches`, for walls from ``starts`` to ``ends``."""
    rise = ends[:, 1] - starts[:, 1]
    # A wall along u counts by its ends, each of which starts a wall.
    part = (levels[:, None] - starts[:, 1]) / np.where(rise == 0.0, inf, rise)
    reached = np.where(rise == 0.0, levels[:, None] == starts[:, 1], (part >= 0.0) & (part <= 1.0))
    places = starts[:, 0] + part * (ends[:, 0] - starts[:, 0])
    return side * np.where(reached, side * places, -inf).max(axis=1, initial=-inf)


def length(footprints: Sequence[Footprint]) -> float:
    """The diagonal of the bounding box of all corners."""
    corners = np.concatenate([ring for footprint in footprints for ring in footprint.rings])
    return hypot(*(corners.max(axis=0) - corners.min(axis=0)))


MOST_AT_ONCE = 200_000  # distances of a corner from a wall that are computed in one array
METRES_A_DEGREE = 110e3  # less than a degree of latitude has anywhere (110.57 km at the equator), so that boxes reach


def close_pairs(footprints: Sequence[Footprint], reach: float, metres: bool) -> list[tuple[int, int, float]]:
    """All pairs of footprints with a clear distance below ``reach``, in any direction.

    Parameters
    ----------
    footprints
        Corners in metres, or in degrees of longitude and latitude.
    reach
        m; a pair that is so far apart is not close.
    metres
        Whether coordinates are metres; else each pair is laid flat about its own middle.

    Returns
    -------
    list of (first place, second place, clear distance [m])
        In the order of the places; 0 m where two footprints touch or overlap.
    """
    close = []
    for first, second in sorted(_near_boxes(footprints, reach, metres)):
        pair = [footprints[first], footprints[second]]
        flat = pair if metres else local(pair, middle(pair))
        distance = clear_between(flat[0], flat[1], reach)
        if distance < reach:
            close.append((first, second, distance))
    return close


def _near_boxes(footprints: Sequence[Footprint], reach: float, metres: bool) -> Iterator[tuple[int, int]]:
    """Indices of pairs, the smaller first, whose bounding boxes are within reach."""
    if not footprints:
        return
    boxes = np.array([_box(footprint) for footprint in footprints])  # (n, low and high, 2)
    margin = np.full((len(boxes), 2), reach)
    if not metres:
        highest = np.minimum(np.abs(boxes[:, :, 1]).max(axis=1), 89.0)
        margin /= METRES_A_DEGREE * np.column_stack(
            [[cos(radians(footprint)) for footprint in highest], np.ones(len(boxes))]
        )
    low, high = boxes[:, 0], boxes[:, 1] + margin
    order = np.argsort(low[:, 1], kind="stable")
    ends = np.searchsorted(low[order, 1], high[order, 1], side="right")
    for number, (index, end) in enumerate(zip(order, ends, strict=True)):
        others = order[number + 1 : end]
        # Both margins, as a building farther from the equator has the larger one.
        beside = (low[others, 0] <= high[index, 0]) & (low[index, 0] <= high[others, 0])
        yield from ((min(int(index), int(other)), max(int(index), int(other))) for other in others[beside])


def _box(footprint: Footprint) -> tuple[Array, Array]:
    corners = np.concatenate(footprint.rings)
    return corners.min(axis=0), corners.max(axis=0)


def clear_between(first: Footprint, second: Footprint, reach: float = inf) -> float:
    """The least distance [m] between two footprints in metres, in any direction.

    0 where they touch or overlap; inf where it is more than ``reach``. A court is outside of its building.
    """
    walls, others = (_walls(footprint, _box(beside), reach) for footprint, beside in ((first, second), (second, first)))
    nearest = min((_squared(*block) for block in _blocks(walls, others)), default=inf)
    if nearest == 0.0 or _holds(first, second) or _holds(second, first):
        return 0.0
    return sqrt(nearest)


def _walls(footprint: Footprint, beside: tuple[Array, Array], reach: float) -> Array:
    """Start and end (n, 2, 2) of each wall, of courts too, within reach of a box."""
    every = (*footprint.rings, *footprint.holes)
    walls = np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in every])
    near = (walls.max(axis=1) >= beside[0] - reach) & (walls.min(axis=1) <= beside[1] + reach)
    return walls[near.all(axis=1)]


def _blocks(walls: Array, others: Array) -> Iterator[tuple[Array, Array]]:
    """Walls against walls in blocks that fit in memory."""
    step = max(MOST_AT_ONCE // max(len(others), 1), 1)
    for start in range(0, len(walls) if len(others) else 0, step):
        for first in range(0, len(others), MOST_AT_ONCE):
            yield walls[start : start + step], others[first : first + MOST_AT_ONCE]


def _squared(walls: Array, others: Array) -> float:
    """The square of the least distance between two groups of walls; 0 where two cross."""
    if _cross(walls, others):
        return 0.0
    ends, other_ends = walls.reshape(-1, 2), others.reshape(-1, 2)
    return min(_from_corners(ends, others), _from_corners(other_ends, walls))


def _cross(walls: Array, others: Array) -> bool:
    """True where a wall crosses another: each ends on both sides of the other's line."""
    first, second = (walls[:, 0], walls[:, 1]), (others[:, 0], others[:, 1])
    return bool(np.any(straddles(first, second) & straddles(second, first).T))


def _from_corners(corners: Array, walls: Array) -> float:
    """The square of the least distance of corners from walls."""
    start, step = walls[None, :, 0], (walls[:, 1] - walls[:, 0])[None]
    apart = corners[:, None] - start
    part = np.clip((apart * step).sum(axis=2) / (step**2).sum(axis=2), 0.0, 1.0)
    return float((((apart - part[..., None] * step) ** 2).sum(axis=2)).min())


def _holds(outer: Footprint, inner: Footprint) -> bool:
    """True where a ring of ``inner``, none of whose walls crosses one of ``outer``, lies inside it."""
    return any(_inside(ring[0], outer) for ring in inner.rings)


def _inside(corner: Array, footprint: Footprint) -> bool:
    """True where a ray from the corner to the right crosses the walls, of courts too, an odd number of times."""
    walls = np.concatenate(
        [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (*footprint.rings, *footprint.holes)]
    )
    (x0, y0), (x1, y1) = walls[:, 0].T, walls[:, 1].T
    spans = (y0 > corner[1]) != (y1 > corner[1])
    at = x0[spans] + (corner[1] - y0[spans]) / (y1[spans] - y0[spans]) * (x1[spans] - x0[spans])
    return bool(np.count_nonzero(at > corner[0]) % 2)


def faced(left: Footprint, right: Footprint, farthest: float) -> tuple[float, float]:
    """The length across u [m] over which two footprints face each other, and its share of the shorter front.

    They face each other where both reach and the distance from ``left`` to ``right`` along u is below ``farthest``
    [m]. Between two corners that distance is linear, and so is known from two levels in between.
    """
    levels = np.unique(np.concatenate([ring[:, 1] for each in (left, right) for ring in each.rings]))
    steps = np.diff(levels)
    inner = (levels[:-1] + 0.25 * steps, levels[:-1] + 0.75 * steps)
    apart = np.array([reaches(right, each, -1.0) - reaches(left, each, 1.0) for each in inner])
    both = np.isfinite(apart).all(axis=0)  # inf where one of them does not reach
    low, high = np.sort(apart[:, both], axis=0)
    spread = high - low  # over half of the interval
    start, whole = low - 0.5 * spread, 2.0 * spread
    share = np.clip((farthest - start) / np.where(spread > 0.0, whole, 1.0), 0.0, 1.0)
    share = np.where(spread > 0.0, share, low < farthest)
    length = float(steps[both] @ share)
    fronts = [float(np.ptp(np.concatenate(each.rings)[:, 1])) for each in (left, right)]
    return length, min(length / min(fronts), 1.0)
