"""A street on a map: footprints side by side."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

EAST, NORTH = 174.776, -41.286  # degrees
WIDE, DEEP, APART = 1.1e-4, 1.2e-4, 1.0e-6


def corner(at: int) -> tuple[float, float]:
    """Longitude and latitude of a building's corner in the south-west; every other one stands back."""
    return EAST + at * (WIDE + APART), NORTH + 2e-5 * (at % 2)


def street_file(path: Path, buildings: Sequence[tuple[str, str]]) -> Path:
    """A GeoJSON of buildings (street, name)."""
    features = []
    for at, (street, name) in enumerate(buildings):
        x, y = corner(at)
        ring = [[x, y], [x + WIDE, y], [x + WIDE, y + DEEP], [x, y + DEEP], [x, y]]
        about = {"name": name, "height [m]": 9.0, "storeys": 3, "typology": "masonry"}
        about |= {"street": street} if street else {}
        geometry = {"type": "Polygon", "coordinates": [ring]}
        features.append({"type": "Feature", "properties": about, "geometry": geometry})
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8")
    return path
