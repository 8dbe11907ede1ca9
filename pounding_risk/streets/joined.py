"""An inventory joined to footprints: each of its buildings to the footprint that holds its point, or has its id."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from pathlib import Path

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk._common.words import listed
from pounding_risk.streets.inventory import inventory_format, read_inventory
from pounding_risk.streets.inventory._lines import Building
from pounding_risk.streets.table import DEGREE, BlockError, Entry, Table, file_text, read_table
from pounding_risk.units import shown

NEAR = 50.0  # m; a point outside of the footprint with its id counts as of the same building up to here


def with_inventory(table: Table, path: Path) -> Table:
    """The footprints of a table with the values of an inventory, which replace those that the map gives.

    Notes name buildings and footprints without each other, and footprints with several buildings. Raises BlockError as
    the readers do, and where no building has a footprint.
    """
    buildings, notes = _buildings(path)
    in_footprint, by_name, doubtful = _footprints_of(buildings, table.entries)
    if doubtful:
        repair = "give the buildings points, or leave the ids out of the map to join by its names"
        sentence = f"{listed(doubtful, 2)}; which is meant is not known; {repair}"
        raise BlockError(str(path), [sentence])
    building_of: dict[int, Building] = {}
    doubles, unplaced = [], []
    for number, building in enumerate(buildings):
        footprint = in_footprint.get(number, by_name.get(number))
        if footprint is None:
            unplaced.append(building.place)
        elif building_of.setdefault(footprint, building) is not building:
            place_text = f"with {building_of[footprint].place} in {table.entries[footprint].place}"
            doubles.append(f"{building.place} ({place_text})")
    if not building_of:
        sentence = "no building has a point in a footprint, or the id or the name of one; check coordinates and ids"
        raise BlockError(str(path), [sentence])
    entries = []
    for number, entry in enumerate(table.entries):
        given, map_id = building_of.get(number), entry.mapped is not None and entry.mapped.id
        if given is not None:
            values = {**({"name": map_id} if map_id else {}), **entry.values, **given.values}
            map_derived = (item for item in entry.derived if item.column not in given.values)
            place, derived = f"{entry.place} with {given.place}", (*map_derived, *given.derived)
            entry = entry._replace(place=place, values=values, derived=derived)
        entries.append(entry)
    missing = [entry.place for number, entry in enumerate(table.entries) if number not in building_of]
    join_text = f"{counted(len(in_footprint), 'building')} joined to footprints by point"
    notes.append(f"{path.name}: {join_text}, {len(by_name)} by id or name")
    notes += _place_notes(path, unplaced, "in no footprint, left out")
    notes += _place_notes(path, doubles, "a second building in one footprint, left out")
    notes += _place_notes(None, missing, f"not in {path.name}; taken with what the map and the rules say")
    return Table(entries, [*table.left_out, *notes], table.resolution)


def _buildings(path: Path) -> tuple[Sequence[Building], list[str]]:
    """The buildings of an inventory, or of a street's table, and notes on what is not read."""
    if path.suffix.lower() == ".csv" and inventory_format(path, file_text(path)) is None:
        table = read_table(path)
        return [Building(entry.place, entry.values) for entry in table.entries], table.left_out
    inventory = read_inventory(path)
    notes = [f"{path.name}: read as {inventory.kind}", *(f"{path.name}, {note}" for note in inventory.left_out)]
    return inventory.entries, notes


def _footprints_of(
    buildings: Sequence[Building], entries: Sequence[Entry]
) -> tuple[dict[int, int], dict[int, int], list[str]]:
    """Footprints by building: by its point, and for other buildings by name or id, if not far from the point.

    Then sentences on buildings whose name is the name of one footprint and the id of another.
    """
    import shapely

    outlines = [entry.mapped.outline if entry.mapped is not None else None for entry in entries]
    points = [_point(building) for building in buildings]
    on_earth = [number for number, outline in enumerate(outlines) if outline is not None]
    located = [number for number, (longitude, latitude) in enumerate(points) if not isnan(longitude + latitude)]
    by_point: dict[int, int] = {}
    if on_earth and located:
        tree = shapely.STRtree([outlines[number] for number in on_earth])
        places, held = tree.query(shapely.points([points[number] for number in located]), predicate="intersects")
        by_point = {located[place]: on_earth[outline] for place, outline in zip(places[::-1], held[::-1], strict=True)}
    # The footprints that have a text as their id or their name.
    owners: dict[str, dict[int, str]] = {}
    for number, entry in enumerate(entries):
        for kind, text in (("id", entry.mapped.id if entry.mapped else ""), ("name", entry.values.get("name", ""))):
            if text:
                owners.setdefault(text, {}).setdefault(number, kind)
    by_name, doubts = {}, []
    for number, building in enumerate(buildings):
        text = str(building.values.get("name", ""))
        candidates = {} if number in by_point else owners.get(text, {})
        if any(_is_near(points[number], entries[one]) for one in candidates):
            if len(candidates) == 1:
                by_name[number] = next(iter(candidates))
            elif len(set(candidates.values())) > 1:
                kinds = " and ".join(f"the {kind} of {entries[one].place}" for one, kind in candidates.items())
                doubts.append(f"{building.place}: {shown(text)} is {kinds}")
    return by_point, by_name, doubts


def _point(building: Building) -> tuple[float, float]:
    """A point of a building in degrees: one in its own outline, where it has one."""
    if building.footprint:
        import shapely

        point = shapely.point_on_surface(shapely.from_wkt(building.footprint))
        return (point.x, point.y) if not point.is_empty else (building.longitude, building.latitude)
    return building.longitude, building.latitude


def _is_near(point: tuple[float, float], entry: Entry) -> bool:
    """True where a point is not known, or lies within `NEAR` plus its size from the middle of a footprint."""
    if isnan(point[0] + point[1]) or entry.mapped is None or isnan(entry.mapped.longitude):
        return True
    north = (point[1] - entry.mapped.latitude) * DEGREE
    east = (point[0] - entry.mapped.longitude) * DEGREE * np.cos(np.radians(point[1]))
    west, south, east_end, north_end = entry.footprint.bounds
    return bool(np.hypot(east, north) < NEAR + np.hypot(east_end - west, north_end - south))


def _place_notes(path: Path | None, places: Sequence[str], words: str) -> list[str]:
    """A note that names some places; none where there are no places."""
    if not places:
        return []
    return [f"{f'{path.name}, ' if path is not None else ''}{listed(places)}: {words}"]
