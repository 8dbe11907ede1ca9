"""GeoJSON (RFC 7946): the features of a collection, their properties, and the rings of their polygons."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pounding_risk.units import shown

FARTHEST = 1e9  # m or degrees; no coordinate of a footprint is farther
POLYGONS = ("Polygon", "MultiPolygon")


def collection_of(text: str, noun: str, faults: list[str], is_typed: bool = True) -> dict[str, Any]:
    """The collection of a file, its features as tables; without features, and with a fault, where it is none.

    ``noun`` is what it holds, for the fault. With ``is_typed`` its type has to say that it is a collection.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        faults.append(f"is not JSON ({error}); export the {noun} again as GeoJSON")
        return {"features": []}
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list) or (is_typed and document.get("type") != "FeatureCollection"):
        faults.append(f'is no GeoJSON of {noun}; write {{"type": "FeatureCollection", "features": [...]}}')
        return {"features": []}
    return {**document, "features": [feature if isinstance(feature, dict) else {} for feature in features]}


def properties_of(feature: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a feature; none where they are no table."""
    properties = feature.get("properties")
    return properties if isinstance(properties, dict) else {}


def polygons_of(geometry: Any) -> list[list[list[Any]]]:
    """The rings of each polygon of a geometry; raises ValueError with the fault.

    A ring has four positions or more, of two finite numbers or more, and ends where it starts.
    """
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    rings_of_parts = geometry.get("coordinates") if isinstance(geometry, dict) else None
    if kind not in POLYGONS or not isinstance(rings_of_parts, list) or not rings_of_parts:
        raise ValueError(no_polygon("" if kind is None else shown(kind)))
    polygons = [rings_of_parts] if kind == "Polygon" else rings_of_parts
    for polygon in polygons:
        for ring in polygon if isinstance(polygon, list) and polygon else [None]:
            _check_ring(ring)
    return polygons


def no_polygon(kind: str) -> str:
    """The fault of a feature of another kind of geometry."""
    return f"has {kind or 'no geometry'}; a building needs its footprint, a Polygon or a MultiPolygon"


def _check_ring(ring: Any) -> None:
    if not isinstance(ring, list) or len(ring) < 4:
        raise ValueError("a ring has fewer than four positions, the first of them repeated at its end; draw it again")
    for position in ring:
        if not is_position(position):
            raise ValueError(f"{shown(position)} is not a position; write two numbers, such as [174.776, -41.286]")
    if ring[0][:2] != ring[-1][:2]:
        raise ValueError("a ring does not end where it starts; repeat its first position at its end")


def is_position(position: Any, limits: tuple[float, float] = (FARTHEST, FARTHEST)) -> bool:
    """True for two numbers or more, the first two of a size within ``limits``."""
    numbers = position[:2] if isinstance(position, list) else []
    return len(numbers) == 2 and all(
        type(number) in (int, float) and abs(number) <= limit for number, limit in zip(numbers, limits, strict=True)
    )
