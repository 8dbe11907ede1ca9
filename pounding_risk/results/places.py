"""Coordinates of the places of a dataset: buildings, storeys, interfaces and contact points. No solver is imported."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from pounding_risk.models.structures.contact_points import Point
from pounding_risk.results.variables import described


def place_coordinates(buildings: Sequence[Any], points: Sequence[Point], yield_forces: np.ndarray) -> dict[str, Any]:
    """Labels of the places and facts on each, as xarray takes them.

    ``buildings`` are `Building` or `Storeys`, ``yield_forces`` [N] those of the grid at each contact point.
    """
    names = [building.name for building in buildings]
    forces = described("N", "yield force F_E at the contact point; inf never yields")
    return {
        "interface": ("interface", list(interface_labels(names)), {"long_name": "neighbours, left | right"}),
        "contact_point": (
            "contact_point",
            [_label(point, names) for point in points],
            {"long_name": "contact point: the floors at which two neighbours meet, left | right"},
        ),
        **_of_points(points),
        "contact_point_yield_force": (("yield_force", "contact_point"), yield_forces, forces),
        **_of_buildings(buildings),
    }


def building_coordinates(buildings: Sequence[Any]) -> dict[str, Any]:
    """Mass, first period and damping of each building; NaN for a rigid one."""
    facts = {"mass": ("kg", "mass"), "period": ("s", "first period of vibration"), "damping": ("1", "damping ratio")}
    coords = {}
    for name, (unit, words) in facts.items():
        values = [np.nan if building.is_rigid else getattr(building, name) for building in buildings]
        coords[f"building_{name}"] = ("building", values, described(unit, f"{words} of the building"))
    return coords


def interface_labels(names: Sequence[str]) -> tuple[str, ...]:
    """The label "left | right" of each two neighbours."""
    return tuple(f"{left} | {right}" for left, right in pairwise(names))


def _label(point: Point, names: Sequence[str]) -> str:
    """Such as "A 2 | B 2", or "A 2 | B 1.4" where a floor of A meets a column of B."""
    left, right = names[point.interface], names[point.interface + 1]
    return f"{left} {point.left_floor:.3g} | {right} {point.right_floor:.3g}"


def _of_points(points: Sequence[Point]) -> dict[str, Any]:
    facts = {
        "interface": {"long_name": "index of the contact point's interface, from 0"},
        "level": described("m", "level above the ground; NaN where not known"),
        "kind": {"long_name": "kind of contact point: two floors, or a floor and a column"},
        "left_floor": described("1", "floor of the left building"),
        "right_floor": described("1", "floor of the right building"),
    }
    return {
        f"contact_point_{name}": ("contact_point", [getattr(point, name) for point in points], attrs)
        for name, attrs in facts.items()
    }


def _of_buildings(buildings: Sequence[Any]) -> dict[str, Any]:
    """Facts on each building and its storeys; NaN where a rigid one, or one without storeys, has no such value."""
    storeys = [storey_count(building) for building in buildings]
    levels = np.full((len(buildings), max(1, *storeys)), np.nan)
    for place, building in enumerate(buildings):
        given = list(accumulate(building.heights))
        levels[place, : len(given)] = given
    heights = [building.height if building.height > 0.0 else np.nan for building in buildings]
    return {
        "building_height": ("building", heights, described("m", "level of the roof; NaN where not given")),
        "building_storeys": ("building", storeys, described("1", "storeys; a rigid building has none")),
        "building_position": (
            "building",
            positions(len(buildings)),
            {"long_name": "position of the building in the row: end or interior"},
        ),
        "storey": ("storey", np.arange(levels.shape[1]) + 1, described("1", "storey, from the ground up")),
        "floor_level": (
            ("building", "storey"),
            levels,
            described("m", "level of the floor above the storey; NaN where not given"),
        ),
    }


def storey_count(building: Any) -> int:
    """Number of storeys of a building: one of a single mass, none of a rigid building."""
    return 0 if building.is_rigid else len(getattr(building, "masses", (building.mass,)))


def positions(count: int) -> list[str]:
    """Position of each of so many buildings: end or interior, or alone."""
    return ["alone"] if count == 1 else ["end", *["interior"] * (count - 2), "end"]
