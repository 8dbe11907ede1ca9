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
    holding, named, doubtful = _footprints_of(buildings, table.entries)
    if doubtful:
        repair = "give the buildings points, or leave the ids out of the map to join by its names"
        sentence = f"{listed(doubtful, 2)}; which is meant is not known; {repair}"
        raise BlockError(str(path), [sentence])
    first: dict[int, Building] = {}
    doubled, without = [], []
    for number, building in enumerate(buildings):
        footprint = holding.get(number, named.get(number))
        if footprint is None:
            without.append(building.place)
        elif first.setdefault(footprint, building) is not building:
            beside = f"with {first[footprint].place} in {table.entries[footprint].place}"
            doubled.append(f"{building.place} ({beside})")
    if not first:
        sentence = "no building has a point in a footprint, or the id or the name of one; check coordinates and ids"
        raise BlockError(str(path), [sentence])
    entries = []
    for number, entry in enumerate(table.entries):
        own, held = first.get(number), entry.mapped is not None and entry.mapped.id
        if own is not None:
            values = {**({"name": held} if held else {}), **entry.values, **own.values}
            of_map = (one for one in entry.derived if one.column not in own.values)
            place, derived = f"{entry.place} with {own.place}", (*of_map, *own.derived)
            entry = entry._replace(place=place, values=values, derived=derived)
        entries.append(entry)
    missing = [entry.place for number, entry in enumerate(table.entries) if number not in first]
    by_point = f"{counted(len(holding), 'building')} joined to footprints by point"
    notes.append(f"{path.name}: {by_point}, {len(named)} by id or name")
    notes += _note(path, without, "in no footprint, left out")
    notes += _note(path, doubled, "a second building in one footprint, left out")
    notes += _note(None, missing, f"not in {path.name}; taken with what the map and the rules say")
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
    """Footprints by building: those that hold its point, and for others those with its name or id, if not elsewhere.

    Then what is the name of one footprint and the id of another, for buildings without a point in one.
    """
    import shapely

    outlines = [entry.mapped.outline if entry.mapped is not None else None for entry in entries]
    points = [_point(building) for building in buildings]
    on_earth = [number for number, outline in enumerate(outlines) if outline is not None]
    located = [number for number, (longitude, latitude) in enumerate(points) if not isnan(longitude + latitude)]
    holding: dict[int, int] = {}
    if on_earth and located:
        tree = shapely.STRtree([outlines[number] for number in on_earth])
        places, held = tree.query(shapely.points([points[number] for number in located]), predicate="intersects")
        holding = {located[place]: on_earth[outline] for place, outline in zip(places[::-1], held[::-1], strict=True)}
    # The footprints that have a text as their id or their name.
    owners: dict[str, dict[int, str]] = {}
    for number, entry in enumerate(entries):
        for kind, text in (("id", entry.mapped.id if entry.mapped else ""), ("name", entry.values.get("name", ""))):
            if text:
                owners.setdefault(text, {}).setdefault(number, kind)
    named, doubtful = {}, []
    for number, building in enumerate(buildings):
        text = str(building.values.get("name", ""))
        those = {} if number in holding else owners.get(text, {})
        if any(_is_near(points[number], entries[one]) for one in those):
            if len(those) == 1:
                named[number] = next(iter(those))
            elif len(set(those.values())) > 1:
                kinds = " and ".join(f"the {kind} of {entries[one].place}" for one, kind in those.items())
                doubtful.append(f"{building.place}: {shown(text)} is {kinds}")
    return holding, named, doubtful


def _point(building: Building) -> tuple[float, float]:
    """A point of a building in degrees: one in its own outline, where it has one."""
    if building.footprint:
        import shapely

        inner = shapely.point_on_surface(shapely.from_wkt(building.footprint))
        return (inner.x, inner.y) if not inner.is_empty else (building.longitude, building.latitude)
    return building.longitude, building.latitude


def _is_near(point: tuple[float, float], entry: Entry) -> bool:
    """True where a point is not known, or lies near the middle of a footprint, less than its size and `NEAR` away."""
    if isnan(point[0] + point[1]) or entry.mapped is None or isnan(entry.mapped.longitude):
        return True
    north = (point[1] - entry.mapped.latitude) * DEGREE
    east = (point[0] - entry.mapped.longitude) * DEGREE * np.cos(np.radians(point[1]))
    low_x, low_y, high_x, high_y = entry.footprint.bounds
    return bool(np.hypot(east, north) < NEAR + np.hypot(high_x - low_x, high_y - low_y))


def _note(path: Path | None, places: Sequence[str], words: str) -> list[str]:
    """A note that names some places; none where there are no places."""
    if not places:
        return []
    return [f"{f'{path.name}, ' if path is not None else ''}{listed(places)}: {words}"]
