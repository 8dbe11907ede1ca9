"""Files of maps as tables of a street: GeoJSON, GeoPackage, FlatGeobuf and GeoParquet, each feature a building.

Footprints are checked, repaired where what is meant is plain, and laid flat in metres; all faults are reported at
once by feature. Attributes of OpenStreetMap and of Overture are read as they are. The module needs the extra [maps].
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from math import hypot, inf, isfinite, isnan
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from pounding_risk._common.letters import without_mark
from pounding_risk._common.words import listed
from pounding_risk.streets import map_tags
from pounding_risk.streets.footprints import Geometry, last_decimal
from pounding_risk.streets.geojson import FARTHEST, POLYGONS, no_polygon
from pounding_risk.streets.map_files import DEGREES, IDS, METRES_HINT, Features, Projection, read_features, system_of
from pounding_risk.streets.table import (
    COLUMNS,
    DEGREE,
    MAPS,
    BlockError,
    Entry,
    Mapped,
    Resolution,
    Table,
    columns_of,
    file_text,
    repeated,
    values_of,
)
from pounding_risk.units import GAP, say, shown

METRE = ("metre", "meter", "m")  # as definitions of systems name it
COARSE = 5e-3  # m on the ground; coarser coordinates are doubted
MOST_DECIMALS = 8  # of degrees that are still so coarse
# m; within, lengths of a transverse Mercator projection about the middle are off by 8e-4 at most.
FARTHEST_APART = 500e3
SMALLEST, LARGEST = 0.5, 2e3  # m, across a footprint; outside, its coordinates are taken for those of another kind
PARTED = 20  # buildings left out beside the edge of an area that a note names
REPAIRABLE = 0.01  # share of its area by which a repair may change a footprint; else it is drawn again


def read_map(
    path: Path, *, metres: bool = False, layer: str | None = None, within: str | None = None, limit: float = 0.0
) -> Table:
    """The buildings of a file of a map, with footprints in metres; raises BlockError with every fault of it.

    ``metres`` says that coordinates are metres that nothing ties to the Earth; ``layer`` is that of a GeoPackage, None
    where it has one only; ``within`` keeps the buildings whose middle lies in there, "west, south, east, north" in
    degrees, or a file of polygons, and a note names those outside that are closer than ``limit`` [m] to one inside.
    """
    faults: list[str] = []
    features = read_features(path, layer, metres, faults)
    projection = None if faults else _projection(features, metres, faults)
    parted_notes: list[str] = []
    if not faults and within is not None:
        features, parted_notes = _features_within(features, within, projection, limit, faults)
    if faults:
        raise BlockError(str(path), faults)
    table = _table(features, projection, faults)
    if not faults and not table.entries:
        area_text = f" within {within}" if within is not None else ""
        faults.append(f"has no building{area_text}; export the footprints again, a feature for each")
    if faults:
        raise BlockError(str(path), faults)
    return table._replace(left_out=[*table.left_out, *parted_notes])


def written_outlines(path: Path) -> tuple[dict[tuple[str, str], Geometry], bool]:
    """Footprints of the buildings.csv that a street is written with, by street and name; whether they are in degrees.

    Raises BlockError for a table without names and footprints.
    """
    lines = csv.DictReader(file_text(path).splitlines())
    head = next((cell for cell in lines.fieldnames or () if cell.startswith("footprint [WKT")), "")
    if not {"street", "name", head} <= set(lines.fieldnames or ()):
        columns_text = "street, name and footprint [WKT, deg]"
        raise BlockError(str(path), [f"has no columns {columns_text}, as buildings.csv of block has; write it again"])
    cells = {(without_mark(line["street"]), without_mark(line["name"])): line[head] for line in lines if line[head]}
    try:
        shapes = shapely.from_wkt(list(cells.values()))
    except shapely.errors.GEOSException as error:
        raise BlockError(str(path), [f"footprint: {error}; write the table again"]) from None
    return dict(zip(cells, shapes, strict=True)), "deg" in head


def flat_outlines(shapes: Sequence[Geometry]) -> list[Geometry]:
    """Footprints in degrees of WGS 84 in metres about their middle."""
    projection = Projection.about(shapely.get_coordinates(shapes), system_of(DEGREES))
    return [shapely.transform(shape, projection.metres) for shape in shapes]


# ------------------------------------------------------------------------------------------------ geometry


def _projection(features: Features, metres: bool, faults: list[str]) -> Projection | None:
    """How coordinates of the file become metres; None where they are metres that nothing ties to the Earth."""
    system = None
    try:
        system = None if features.system is None else system_of(features.system)
    except ValueError as error:
        if not metres:  # with metres the user knows the unit of a system of the site's own
            faults.append(f"{error}; export the footprints again in another one, or {METRES_HINT}")
        return None
    if metres:
        if system is not None and (unit := system.axis_info[0].unit_name) not in METRE:
            reason = f"its coordinates are in the unit {shown(unit)} ({system.name}), so they are no metres"
            repair = "set the coordinate reference system that the file really has"
            faults.append(f"{reason}; leave out --metres (metres=True in Python), or {repair}")
        return None
    if system is None:
        faults.append(
            "has no coordinate reference system, so nobody knows what its numbers are; set it (QGIS: Layer > Set CRS) "
            f"and export the file again, or {METRES_HINT}"
        )
        return None
    shapes = [shape for shape in features.geometries if shape is not None]
    corners = shapely.get_coordinates(shapes)
    if system.is_geographic:
        faults += _degree_faults(features)
    finite = corners[np.isfinite(corners).all(axis=1)]
    return Projection.about(finite, system) if len(finite) and not faults else None


def _degree_faults(features: Features) -> list[str]:
    """One fault for all features with a corner that is no longitude and latitude."""
    corners, owners = shapely.get_coordinates(features.geometries, return_index=True)
    is_far = (np.abs(corners) > (180.0, 90.0)).any(axis=1)
    if not is_far.any():
        return []
    corner, places = corners[is_far][0], [features.places[owner] for owner in np.unique(owners[is_far])]
    repair = f"export the file in WGS 84, or {METRES_HINT}"
    if (np.abs(corners) <= (90.0, 180.0)).all() and np.ptp(corners, axis=0).max() < FARTHEST_APART / DEGREE:
        repair = "latitude stands first; write longitude before latitude"
    return [f"{listed(places)}: [{corner[0]:g}, {corner[1]:g}] is no longitude and latitude in degrees; {repair}"]


def _features_within(
    features: Features, within: str, projection: Projection | None, limit: float, faults: list[str]
) -> tuple[Features, list[str]]:
    """The features whose middle lies in a box of degrees, or in polygons of a file; a note on those close to others."""
    area = _area(within)
    if projection is None:
        if features.geometries:
            reason = "nothing ties the coordinates of this file to the Earth"
            faults.append(f"--within is in degrees, and {reason}; leave it out")
        return features, []
    bounds = np.array([shapely.bounds(shape) for shape in features.geometries], dtype=float).reshape(-1, 4)
    middles = projection.degrees(0.5 * (bounds[:, :2] + bounds[:, 2:]))
    is_inside = shapely.contains_xy(area, *middles.T)
    # The limit in units of the file, or more: a degree east, and a metre of web maps, is shorter by the cosine.
    margin = 1.1 * limit / (projection.unit * np.cos(np.radians(np.abs(middles[is_inside, 1]).max(initial=0.0))))
    boxes = shapely.box(*(bounds[is_inside] + (-margin, -margin, margin, margin)).T)
    inside_numbers, outside_numbers = np.flatnonzero(is_inside).tolist(), np.flatnonzero(~is_inside).tolist()
    close_pairs = shapely.STRtree([features.geometries[number] for number in outside_numbers]).query(boxes)
    pairs = [(inside_numbers[i], outside_numbers[j]) for i, j in close_pairs.T]
    return features.chosen(inside_numbers), _parted_notes(features, pairs, projection, limit)


def _parted_notes(
    features: Features, pairs: Sequence[tuple[int, int]], projection: Projection, limit: float
) -> list[str]:
    """A note on pairs of features, one of them left out, that are buildings closer than a limit [m]."""
    words = []
    for one, other in pairs:
        shapes = [_sound_footprint(features.geometries[number])[0] for number in (one, other)]
        tables = (map_tags.with_other_tags(features.properties[number]) for number in (one, other))
        if None in shapes or any(map(map_tags.is_part_of_building, tables)):
            continue
        distance = float(shapely.distance(*(shapely.transform(shape, projection.metres) for shape in shapes)))
        if distance < limit:
            words.append(f"{features.places[other]} ({say(distance, GAP, 3)} from {features.places[one]})")
    reason = f"left out by --within (within in Python), though closer than {say(limit, GAP)} to a building that is not"
    return [f"{listed(words, PARTED)}: {reason}; in no row and no table"] if words else []


def _area(within: str) -> Geometry:
    """The area of --within in degrees of WGS 84."""
    numbers = within.split(",")
    if len(numbers) == 4:
        try:
            west, south, east, north = map(float, numbers)
        except ValueError:
            west, south, east, north = 0.0, 0.0, 0.0, 0.0
        if -180.0 <= west < east <= 180.0 and -90.0 <= south < north <= 90.0:
            return shapely.box(west, south, east, north)
    path = Path(within)
    if path.suffix.lower() not in MAPS:
        kinds = 'no box "west, south, east, north" in degrees, and no file of polygons'
        raise BlockError("--within", [f"{shown(within)} is {kinds}; write one"])
    area = shapely.union_all(read_map_outlines(path))
    shapely.prepare(area)
    return area


def read_map_outlines(path: Path) -> list[Geometry]:
    """The polygons of a file in degrees of WGS 84, without regard to their properties; raises BlockError."""
    faults: list[str] = []
    features = read_features(path, None, False, faults)
    projection = None if faults else _projection(features, False, faults)
    shapes: list[Geometry] = []
    for place, shape in zip(features.places, features.geometries, strict=True):
        sound, _, fault = _sound_footprint(shape)
        if fault:
            faults.append(f"{place}: {fault}")
        elif sound is not None and projection is not None:
            shapes.append(shapely.transform(sound, projection.degrees))
    if not faults and not shapes:
        faults.append("has no polygon; draw one")
    if faults:
        raise BlockError(str(path), list(dict.fromkeys(faults)))
    return shapes


def _sound_footprint(shape: Geometry | None) -> tuple[Geometry | None, str, str]:
    """A valid footprint; a sentence on its repair; or a sentence on its fault."""
    if shape is None or shape.is_empty:
        return None, "", no_polygon("")
    if shape.geom_type not in POLYGONS:
        return None, "", no_polygon(shown(shape.geom_type))
    repairs = ["its Z coordinates are left out"] if shape.has_z else []
    flat = shapely.force_2d(shape)
    corners = shapely.get_coordinates(flat)
    if not (np.isfinite(corners).all() and (np.abs(corners) <= FARTHEST).all()):
        return None, "", "a coordinate is no number, or is beyond any place on the Earth; draw the footprint again"
    if shapely.is_valid(flat):
        return flat, "; ".join(repairs), ""
    sound_parts = []
    for polygon in shapely.get_parts(flat):
        valid, fault = _repaired_polygon(polygon)
        if fault:
            return None, "", fault
        sound_parts.append(valid)
    repaired = sound_parts[0] if len(sound_parts) == 1 else shapely.union_all(sound_parts)
    repairs.append(f"its outline is repaired ({shapely.is_valid_reason(flat)})")
    return repaired, "; ".join(repairs), ""


def _repaired_polygon(polygon: Geometry) -> tuple[Geometry | None, str]:
    """A valid polygon, or several, of the same area; or a sentence on its fault."""
    if shapely.is_valid(polygon):
        return polygon, ""
    polygons = [part for part in shapely.get_parts(shapely.make_valid(polygon)) if part.geom_type in POLYGONS]
    repaired = shapely.union_all(polygons)
    if repaired.area == 0.0:
        return None, "a ring has no area; draw the footprint again"
    if abs(repaired.area - polygon.area) > REPAIRABLE * polygon.area:
        reason = shapely.is_valid_reason(polygon)
        if reason.startswith("Self-intersection"):
            return None, "a ring crosses itself; draw the footprint again, its corners in turn"
        return None, f"its outline has no plain inside ({reason}); draw the footprint again"
    return repaired, ""


# ------------------------------------------------------------------------------------------------ properties


def _table(features: Features, projection: Projection | None, faults: list[str]) -> Table:
    """The buildings of a file whose coordinates can be read, with notes on what is not read, or repaired."""
    tables = [map_tags.with_other_tags(table) for table in features.properties]
    dialect = map_tags.dialect_of(tables)
    raw_tables = tables
    if dialect.name:
        tables = [dialect.read(table) for table in tables]
    heads = [key for key in dict.fromkeys(key for table in tables for key in table) if key not in IDS]
    columns, left_out = columns_of(heads, "properties", faults, dialect.columns, is_foreign=bool(dialect.name))
    columns = {head: column for head, column in columns.items() if not _lacks_unit(head, *column, tables, faults)}
    entries = []
    for number, place in enumerate(features.places):
        for head, (column, _) in columns.items():
            if column in ("left wall", "right wall") and tables[number].get(head) is not None:
                faults.append(f"{place}, {column}: the footprint says where the walls are; leave the property out")
        values = values_of(place, tables[number].items(), columns, faults)
        entries.append(Entry(place, values, features.geometries[number], Mapped(features.ids[number])))
    entries, resolution, flat_notes = _laid_flat(entries, projection, dialect, faults)
    if faults:
        return Table([], [])
    notes = [*left_out, *map_tags.notes_of(dialect, raw_tables, features.places), *flat_notes]
    if dialect.name:
        entries, part_notes = map_tags.without_parts(entries, dict(zip(features.places, raw_tables, strict=True)))
        # Buildings of one street that share a name, as shops do, get their place in the file beside it.
        keys = [(entry.values.get("street", ""), entry.values.get("name")) for entry in entries]
        shared_keys = {key for key in repeated(keys) if key[1] is not None}
        for number, (key, entry) in enumerate(zip(keys, entries, strict=True)):
            if key in shared_keys:
                values = {**entry.values, "name": f"{key[1]} ({entry.place})"}
                entries[number] = entry._replace(values=values)
        notes += part_notes
    places: dict[str, list[str]] = {}
    for entry in entries:
        places.setdefault(entry.mapped.id if entry.mapped is not None else "", []).append(entry.place)
    if shared_ids := [f"{own_id} ({listed(of)})" for own_id, of in places.items() if own_id and len(of) > 1]:
        notes.append(f"several buildings have one id, by which no inventory is joined to them: {listed(shared_ids)}")
    return Table(entries, notes, resolution)


def outlined_table(source: Path, entries: Sequence[Entry], notes: Sequence[str]) -> Table:
    """Buildings whose footprints are in degrees of WGS 84 as a table, checked, repaired and laid flat.

    Raises BlockError with every fault of the footprints.
    """
    faults: list[str] = []
    features = Features([entry.place for entry in entries], [], [entry.footprint for entry in entries], [], DEGREES)
    if not faults:
        flat, resolution, flat_notes = _laid_flat(
            entries, _projection(features, False, faults), map_tags.Dialect(), faults
        )
    if faults:
        raise BlockError(str(source), faults)
    return Table(flat, [*notes, *flat_notes], resolution)


def _laid_flat(
    entries: Sequence[Entry], projection: Projection | None, dialect: map_tags.Dialect, faults: list[str]
) -> tuple[list[Entry], Resolution, list[str]]:
    """Entries with sound footprints in metres, how finely their walls are known, and notes on both."""
    repairs: dict[str, list[str]] = {}
    sound_entries = []
    for entry in entries:
        shape, repair, fault = _sound_footprint(entry.footprint)
        if fault:
            faults.append(f"{entry.place}: {fault}")
        else:
            repairs.setdefault(repair, []).append(entry.place)
            sound_entries.append(entry._replace(footprint=shape))
    notes = [f"{listed(places)}: {repair}" for repair, places in repairs.items() if repair]
    if faults or not sound_entries:
        return [], Resolution(), []
    resolution, coarse_notes = _resolution([entry.footprint for entry in sound_entries], projection, dialect)
    flat = _entries_in_metres(sound_entries, projection)
    faults += _faults_of_extent(flat, projection)
    return flat, resolution, [*notes, *coarse_notes]


def _lacks_unit(head: str, column: str, unit: str, tables: Sequence[Mapping[str, Any]], faults: list[str]) -> bool:
    """True, with one fault for all features, where a property has numbers alone, and its name has no unit."""
    quantity = COLUMNS[column]
    cells = [table[head] for table in tables if table.get(head) is not None]
    has_numbers = cells and all(isinstance(cell, int | float) and not isinstance(cell, bool) for cell in cells)
    if quantity is None or quantity.unit == "1" or unit or not has_numbers:
        return False
    faults.append(
        f'properties: {shown(head)} has numbers without a unit; name it "{head} [{quantity.unit}]", by the unit that '
        f"it has, or write the unit in its cells ({shown(quantity.example)})"
    )
    return True


# ------------------------------------------------------------------------------------------------ metres


def _entries_in_metres(entries: list[Entry], projection: Projection | None) -> list[Entry]:
    """The entries with footprints in metres about their middle, and where that is on the Earth."""
    if projection is None:
        return entries
    shapes = np.array([entry.footprint for entry in entries], dtype=object)
    flat = shapely.transform(shapes, projection.metres)
    middles = projection.degrees(shapely.get_coordinates(shapely.centroid(shapes)))
    world = shapely.transform(shapes, projection.degrees)
    placed_entries = []
    for entry, shape, (longitude, latitude), outline in zip(entries, flat, middles.tolist(), world, strict=True):
        mapped = (entry.mapped or Mapped())._replace(longitude=longitude, latitude=latitude, outline=outline)
        placed_entries.append(entry._replace(footprint=shape, mapped=mapped))
    return placed_entries


def _faults_of_extent(entries: Sequence[Entry], projection: Projection | None) -> list[str]:
    """A fault where metres are read as degrees, or degrees as metres, and where no plane holds all footprints."""
    bounds = shapely.bounds(np.array([entry.footprint for entry in entries], dtype=object)).reshape(-1, 4)
    if not len(bounds):
        return []
    # No building is so large, or so small.
    diameters = np.hypot(bounds[:, 2] - bounds[:, 0], bounds[:, 3] - bounds[:, 1])
    if diameters.max() < SMALLEST:
        kind, repair = "as metres", "leave out --metres (metres=True in Python)"
        if projection is not None:
            kind, repair = f"as {projection.system.name}", "set the coordinate reference system that the file has"
        words = say(float(diameters.max()), GAP, 2)
        doubt = "the coordinates look like longitude and latitude"
        return [f"read {kind}, no footprint is more than {words} across: {doubt}; {repair}"]
    if projection is not None and LARGEST < diameters.min() < inf:
        kind, repair = projection.system.name, "set the coordinate reference system that the file really has"
        if projection.system.is_geographic:
            kind = "longitude and latitude"
            repair = "the coordinates look like metres; say so with --metres (metres=True in Python)"
        return [f"read as {kind}, every footprint is {say(float(diameters.min()), GAP, 2)} across or more: {repair}"]
    diagonal = hypot(*(bounds[:, 2:].max(axis=0) - bounds[:, :2].min(axis=0)))
    if diagonal <= FARTHEST_APART:
        return []
    extent_text = f"{say(diagonal, GAP, 3)} apart" if isfinite(diagonal) else "too far apart to be laid flat"
    return [
        f"{entries[0].place} to {entries[-1].place}: their footprints lie {extent_text}, and one plane holds at most "
        f"{say(FARTHEST_APART, GAP)}; give a part of them (--within), or check the coordinates"
    ]


def _resolution(
    outlines: Sequence[Geometry], projection: Projection | None, dialect: map_tags.Dialect
) -> tuple[Resolution, list[str]]:
    """How finely walls are known by the file itself, and a note where its last decimal is larger than gaps are."""
    unit = 1.0 if projection is None else projection.unit
    decimals, size = last_decimal(shapely.get_coordinates(outlines), unit, COARSE, MOST_DECIMALS)
    notes = []
    if not isnan(size):
        notes = [
            f"coordinates have {decimals} decimals, {say(size, GAP, 2)} on the ground, and gaps between footprints are "
            "no finer; give gap [mm] where it was measured"
        ]
    if dialect.name and not size > map_tags.MAPPED_FROM_IMAGES:
        rule = f"assumed of outlines of {dialect.name}, which say nothing of it"
        return Resolution(map_tags.MAPPED_FROM_IMAGES, rule), notes
    return Resolution(size, "" if isnan(size) else "the last decimal of the coordinates"), notes
