"""Which footprints stand close to each other, in whatever direction, and over what length two of a row face each other.

`footprints` measures along a street, as a row of buildings needs it; here is what a row cannot see.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, inf, radians, sqrt

import numpy as np

from pounding_risk.scene.street.footprints import Array, Footprint, local, middle, parted, reaches

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
    found = []
    for one, other in sorted(_near_boxes(footprints, reach, metres)):
        pair = [footprints[one], footprints[other]]
        flat = pair if metres else local(pair, middle(pair))
        distance = clear_between(flat[0], flat[1], reach)
        if distance < reach:
            found.append((one, other, distance))
    return found


def _near_boxes(footprints: Sequence[Footprint], reach: float, metres: bool) -> Iterator[tuple[int, int]]:
    """Places of pairs, the smaller first, of which the boxes around all corners are within reach."""
    if not footprints:
        return
    boxes = np.array([_box(each) for each in footprints])  # (n, low and high, 2)
    margin = np.full((len(boxes), 2), reach)
    if not metres:
        highest = np.minimum(np.abs(boxes[:, :, 1]).max(axis=1), 89.0)
        margin /= METRES_A_DEGREE * np.column_stack([[cos(radians(each)) for each in highest], np.ones(len(boxes))])
    low, high = boxes[:, 0], boxes[:, 1] + margin
    order = np.argsort(low[:, 1], kind="stable")
    ends = np.searchsorted(low[order, 1], high[order, 1], side="right")
    for place, (one, end) in enumerate(zip(order, ends, strict=True)):
        others = order[place + 1 : end]
        # Both margins, as a building farther from the equator has the larger one.
        beside = (low[others, 0] <= high[one, 0]) & (low[one, 0] <= high[others, 0])
        yield from ((min(int(one), int(other)), max(int(one), int(other))) for other in others[beside])


def _box(footprint: Footprint) -> tuple[Array, Array]:
    corners = np.concatenate(footprint.rings)
    return corners.min(axis=0), corners.max(axis=0)


def clear_between(one: Footprint, other: Footprint, reach: float = inf) -> float:
    """The least distance [m] between two footprints in metres, in any direction.

    0 where they touch or overlap; inf where it is more than ``reach``. A court is outside of its building.
    """
    walls, others = (_walls(each, _box(beside), reach) for each, beside in ((one, other), (other, one)))
    nearest = min((_squared(*block) for block in _blocks(walls, others)), default=inf)
    if nearest == 0.0 or _holds(one, other) or _holds(other, one):
        return 0.0
    return sqrt(nearest)


def _walls(footprint: Footprint, beside: tuple[Array, Array], reach: float) -> Array:
    """Start and end (n, 2, 2) of each wall, of courts too, that is within reach of a box."""
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
    """The square of the least distance between some walls and others; 0 where two cross."""
    if _cross(walls, others):
        return 0.0
    ends, other_ends = walls.reshape(-1, 2), others.reshape(-1, 2)
    return min(_from_corners(ends, others), _from_corners(other_ends, walls))


def _cross(walls: Array, others: Array) -> bool:
    """True where a wall crosses another: each ends on both sides of the other's line."""
    one, other = (walls[:, 0], walls[:, 1]), (others[:, 0], others[:, 1])
    return bool(np.any(parted(one, other) & parted(other, one).T))


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
    """Over what length across u [m] two footprints face each other, and that length over the shorter of both fronts.

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
