"""Where buildings and interfaces are on a map: the footprints of a street, or nominal places along the row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import cos, radians
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.streets.table import DEGREE

ALONG, ACROSS = 10.0, 20.0  # m between buildings of a row and between rows, where no footprints are given
HALF = 2.0  # m, half of the line of an interface there
REACH = 0.3  # m by which a wall may stand farther from the other building than the nearest point, to be its face
WGS84 = "EPSG:4326"
Rows = Sequence[tuple[str, Sequence[str]]]  # title and names of the buildings of each


class Places(NamedTuple):
    """Shapes of shapely of all buildings and all interfaces, row after row; their system, and sentences on them."""

    buildings: list[Any]
    interfaces: list[Any]
    crs: str | None
    notes: tuple[str, ...]


def nominal_places(rows: Rows) -> Places:
    """Points of buildings side by side, rows one below the other, and a line across the row for each interface."""
    from shapely import LineString, Point

    buildings, interfaces = [], []
    for number, (_, names) in enumerate(rows):
        low = -ACROSS * number
        buildings += [Point(ALONG * k, low) for k in range(len(names))]
        middles = (ALONG * (k + 0.5) for k in range(len(names) - 1))
        interfaces += [LineString([(middle, low - HALF), (middle, low + HALF)]) for middle in middles]
    notes = (
        f"not georeferenced: buildings are points {ALONG:g} m apart in the order of the row, whatever their widths; "
        "give the footprints with --street"
    )
    return Places(buildings, interfaces, None, (notes,))


def street_places(street: Path, rows: Rows) -> Places:
    """Footprints of buildings, and the face that each interface has; raises PoundingError where one is missing."""
    from pounding_risk.streets.rows import footprint_outlines

    outlines, is_degrees = footprint_outlines(street)
    crs = WGS84 if is_degrees else None
    if not outlines:
        raise PoundingError(f"{street}: has no footprints; layers to scale need a map with polygons")
    buildings, interfaces = [], []
    for title, names in rows:
        shapes = of_row(outlines, title, names, street)
        buildings += shapes
        interfaces += [face_of(left, right, is_degrees) for left, right in pairwise(shapes)]
    notes = [f"footprints are those of {street.name}, in {crs or 'metres of no known reference system'}"]
    other_count = len(outlines) - len(buildings)
    if other_count > 0:
        count_text = counted(other_count, "footprint")
        notes.append(f"{count_text} of it without a building of the results: in no layer")
    return Places(buildings, interfaces, crs, tuple(notes))


def of_row(outlines: Mapping[tuple[str, str], Any], title: str, names: Sequence[str], source: Path) -> list[Any]:
    """The footprints of a row's buildings, all of one street; raises PoundingError where none has them all."""
    streets = [
        street
        for street in dict.fromkeys(street for street, _ in outlines)
        if all((street, name) in outlines for name in names)
    ]
    title_streets = [street for street in streets if street and title.startswith(street)]
    if len(streets) == 1 or title_streets:
        street = max(title_streets or streets, key=len)
        return [outlines[street, name] for name in names]
    if streets:
        raise PoundingError(
            f"{source}: {len(streets)} streets have buildings with the names of {title}: {', '.join(streets)}; begin "
            "the scene's title with the name of its street"
        )
    outline_names = {name for _, name in outlines}
    missing_names = [name for name in names if name not in outline_names]
    if missing_names:
        raise PoundingError(f"{source}: has no footprint of {', '.join(missing_names)} of {title}; name it there")
    raise PoundingError(f"{source}: the buildings of {title} are of several streets there; a row is of one")


def face_of(left: Any, right: Any, is_degrees: bool) -> Any:
    """The part of a building's outline that faces the other one: within `REACH` of their clear distance.

    Degrees are laid flat about the middle of both buildings, as lengths there differ along both axes.
    """
    from shapely import line_merge, union_all
    from shapely.affinity import scale

    origin = union_all([left, right]).centroid
    across, along = (DEGREE * cos(radians(origin.y)), DEGREE) if is_degrees else (1.0, 1.0)
    left_shape, right_shape = (scale(shape, across, along, origin=origin) for shape in (left, right))
    face = left_shape.boundary.intersection(right_shape.buffer(left_shape.distance(right_shape) + REACH))
    merged = line_merge(face) if face.geom_type.startswith("Multi") else face
    return scale(merged, 1.0 / across, 1.0 / along, origin=origin)
