"""An inventory joined to footprints: each of its buildings to the footprint that holds its point, or has its id."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.streets.inventory import inventory_format, read_inventory
from pounding_risk.streets.inventory._lines import Building
from pounding_risk.streets.table import BlockError, Entry, Table, file_text, read_table, repeated

NAMED = 5  # places that a note names
NEAR = 50.0  # m; a point outside of the footprint with its id counts as of the same building up to here
METRES_A_DEGREE = 111.2e3  # of latitude


class Match(NamedTuple):
    """A building of an inventory and the number of its footprint; None where it has none."""

    building: Building
    footprint: int | None
    by_point: bool = False


def with_inventory(table: Table, path: Path) -> Table:
    """The footprints of a table with the values of an inventory, which replace those that the map gives.

    Buildings and footprints without each other, and footprints with several buildings, are told. Raises BlockError as
    the readers do, and where no building has a footprint.
    """
    buildings, notes = _buildings(path)
    matches = _matched(buildings, table.entries)
    first: dict[int, Building] = {}
    doubled = []
    for match in matches:
        if match.footprint is not None and first.setdefault(match.footprint, match.building) is not match.building:
            beside = first[match.footprint].place
            doubled.append(f"{match.building.place} (with {beside} in {table.entries[match.footprint].place})")
    if not first:
        sentence = "no building has a point in a footprint, or the id or the name of one; check coordinates and ids"
        raise BlockError(str(path), [sentence])
    entries = [_joined(entry, first.get(number)) for number, entry in enumerate(table.entries)]
    by_point = sum(match.by_point for match in matches)
    by_id = sum(match.footprint is not None for match in matches) - by_point
    told = [f"{path.name}: {counted(by_point, 'building')} joined to footprints by point, {by_id} by id or name"]
    told += _sentence(path, [match.building.place for match in matches if match.footprint is None],
                      "in no footprint, left out")  # fmt: skip
    told += _sentence(path, doubled, "a second building in one footprint, left out")
    missing = [entry.place for number, entry in enumerate(table.entries) if number not in first]
    told += _sentence(None, missing, f"not in {path.name}; taken with what the map and the rules say")
    return Table(entries, [*table.left_out, *notes, *told], table.resolution)


def _buildings(path: Path) -> tuple[Sequence[Building], list[str]]:
    """The buildings of an inventory, or of a street's table, and notes on what is not read."""
    if path.suffix.lower() == ".csv" and inventory_format(path, file_text(path)) is None:
        own = read_table(path)
        return [Building(entry.place, entry.values) for entry in own.entries], own.left_out
    inventory = read_inventory(path)
    notes = [f"{path.name}: read as {inventory.kind}", *(f"{path.name}, {note}" for note in inventory.left_out)]
    return inventory.entries, notes


def _matched(buildings: Sequence[Building], entries: Sequence[Entry]) -> list[Match]:
    """Each building with its footprint: that which holds its point, else that with its id or name, if not elsewhere."""
    import shapely

    outlines = [entry.mapped.outline if entry.mapped is not None else None for entry in entries]
    points = [_point(building) for building in buildings]
    on_earth = [number for number, outline in enumerate(outlines) if outline is not None]
    holding: dict[int, int] = {}
    asked = [number for number, (x, y) in enumerate(points) if not isnan(x + y)]
    if on_earth and asked:
        tree = shapely.STRtree([outlines[number] for number in on_earth])
        places, held = tree.query(shapely.points([points[number] for number in asked]), predicate="intersects")
        holding = {asked[place]: on_earth[outline] for place, outline in zip(places[::-1], held[::-1], strict=True)}
    by_name = _by_name(entries)
    matches = []
    for number, building in enumerate(buildings):
        named = by_name.get(str(building.values.get("name", "")))
        if number in holding:
            matches.append(Match(building, holding[number], True))
        elif named is not None and _is_near(points[number], entries[named]):
            matches.append(Match(building, named))
        else:
            matches.append(Match(building, None))
    return matches


def _point(building: Building) -> tuple[float, float]:
    """A point of a building in degrees: one in its own outline, where it has one."""
    if building.footprint:
        import shapely

        inner = shapely.point_on_surface(shapely.from_wkt(building.footprint))
        return (inner.x, inner.y) if not inner.is_empty else (building.longitude, building.latitude)
    return building.longitude, building.latitude


def _by_name(entries: Sequence[Entry]) -> dict[str, int]:
    """The number of the footprint that alone has an id, or a name."""
    named: dict[str, int] = {}
    for texts in (
        [entry.values.get("name", "") for entry in entries],
        [entry.mapped.id if entry.mapped is not None else "" for entry in entries],
    ):
        shared = set(repeated(texts))
        named |= {text: number for number, text in enumerate(texts) if text and text not in shared}
    return named


def _is_near(point: tuple[float, float], entry: Entry) -> bool:
    """True where a point is not known, or lies near the middle of a footprint, less than its size and `NEAR` away."""
    if isnan(point[0] + point[1]) or entry.mapped is None or isnan(entry.mapped.longitude):
        return True
    north = (point[1] - entry.mapped.latitude) * METRES_A_DEGREE
    east = (point[0] - entry.mapped.longitude) * METRES_A_DEGREE * np.cos(np.radians(point[1]))
    low_x, low_y, high_x, high_y = entry.footprint.bounds
    return bool(np.hypot(east, north) < NEAR + np.hypot(high_x - low_x, high_y - low_y))


def _joined(entry: Entry, building: Building | None) -> Entry:
    """A footprint with the values of its building."""
    if building is None:
        return entry
    own = {"name": entry.mapped.id} if entry.mapped is not None and entry.mapped.id else {}
    return entry._replace(
        place=f"{entry.place} with {building.place}",
        values={**own, **entry.values, **building.values},
        derived=(*entry.derived, *building.derived),
    )


def _sentence(path: Path | None, places: Iterable[str], words: str) -> list[str]:
    """A note that names some places; none where there are no places."""
    named = list(places)
    if not named:
        return []
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return [f"{f'{path.name}, ' if path is not None else ''}{', '.join(named[:NAMED])}{more}: {words}"]
