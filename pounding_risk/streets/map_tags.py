"""Attributes of OpenStreetMap and Overture as columns of a street, and the features that are left out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import ceil
from typing import Any, NamedTuple

import numpy as np
import shapely

from pounding_risk._common.words import listed
from pounding_risk.streets.table import Derived, Entry

OF_PART = "that of its tallest part"
# Heights of OpenStreetMap are in metres unless they have a unit (its wiki, Key:height).
OSM_FEET = re.compile(r"""([0-9]+(?:\.[0-9]+)?)'(?:\s*([0-9]+(?:\.[0-9]+)?)\")?""")
# hstore, in which GDAL writes tags without a column
OTHER_TAGS = re.compile(r'"((?:[^"\\]|\\.)*)"=>"((?:[^"\\]|\\.)*)"')
# Values of the tag building that mean no building with floors; the others are uses, from which no typology follows.
OSM_HOLLOW = ("no", "roof", "carport", "construction", "ruins", "collapsed", "demolished", "proposed", "tent", "bridge")
# Properties of Overture's buildings (docs.overturemaps.org/schema/reference/buildings/building); heights in metres.
OVERTURE_KEYS = ("num_floors", "has_parts", "num_floors_underground", "facade_material", "roof_shape", "is_underground")
MAPPED_FROM_IMAGES = 0.5  # m; assumed for the walls of OpenStreetMap and Overture, which say nothing of it


class Dialect(NamedTuple):
    """The properties of a source of maps: names of its columns, and the reader of a feature's properties."""

    name: str = ""
    columns: Mapping[str, str] = {}
    read: Callable[[Mapping[str, Any]], dict[str, Any]] = dict
    note: str = ""


def _osm_properties(tags: Mapping[str, Any]) -> dict[str, Any]:
    """The tags of a building, its height with its unit: a plain number is in metres, 12'6" in feet and inches."""
    facts = {key: tag for key, tag in tags.items() if key not in ("building", "building:part", "min_height")}
    text = str(tags.get("height", "")).strip()
    if feet := OSM_FEET.fullmatch(text):
        facts["height"] = f"{float(feet[1]) + float(feet[2] or 0.0) / 12.0!r} ft"
    else:
        facts["height"] = _height_in_metres(tags.get("height"))
    levels = str(tags.get("building:levels", "")).strip()
    if re.fullmatch(r"[0-9]+\.5", levels):  # an attic
        facts["building:levels"] = ceil(float(levels))
    return facts


def _overture_properties(table: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a building of Overture: its heights are in metres, its name is the primary one."""
    names = table.get("names")
    if isinstance(names, str) and names.startswith("{"):
        try:
            names = json.loads(names)
        except ValueError:
            names = None
    flat_name = table.get("names.primary", table.get("names_primary"))
    primary = names.get("primary") if isinstance(names, Mapping) else flat_name
    unread_keys = ("names", "names.primary", "names_primary", "min_height")
    facts = {key: fact for key, fact in table.items() if key not in unread_keys}
    return facts | {"name": table.get("name") or primary, "height": _height_in_metres(table.get("height"))}


def _height_in_metres(height: Any) -> Any:
    is_plain = re.fullmatch(r"[0-9]+(\.[0-9]+)?", str(height).strip()) and not isinstance(height, bool)
    return f"{str(height).strip()} m" if is_plain else height


OSM = Dialect(
    "OpenStreetMap",
    {"building:levels": "storeys"},
    _osm_properties,
    "tags of OpenStreetMap: a height without a unit is in metres, building:levels are the storeys, and building is a "
    "use, from which no typology follows; give typology where it is known",
)
OVERTURE = Dialect(
    "Overture",
    {"num_floors": "storeys"},
    _overture_properties,
    "properties of Overture: height is in metres, num_floors are the storeys, and no typology follows from the others",
)


def dialect_of(tables: Sequence[Mapping[str, Any]]) -> Dialect:
    """The dialect of these properties, by their names."""
    keys = {str(key) for table in tables for key in table}
    if "building" in keys or any(key.startswith("building:") for key in keys):
        return OSM
    return OVERTURE if keys.intersection(OVERTURE_KEYS) else Dialect()


def with_other_tags(table: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a feature, with each tag that GDAL writes into one common column."""
    properties = dict(table)
    tags = properties.pop("other_tags", None)
    return dict(OTHER_TAGS.findall(tags)) | properties if isinstance(tags, str) else properties


def notes_of(dialect: Dialect, tables: Sequence[Mapping[str, Any]], places: Sequence[str]) -> Iterator[str]:
    """Notes on how properties of a map are read, and on features that may be no building, or begin above the ground."""
    if not dialect.name:
        return
    yield dialect.note
    hollow: dict[str, list[str]] = {}
    raised_places = []
    for place, table in zip(places, tables, strict=True):
        kind = str(table.get("building", "")).strip().lower()
        if kind in OSM_HOLLOW:
            hollow.setdefault(kind, []).append(place)
        if re.fullmatch(r"[0-9]+(\.[0-9]+)?( m)?", low := str(table.get("min_height", "")).strip()):
            raised_places += [place] if float(low.removesuffix(" m")) > 0.0 and not is_part_of_building(table) else []
    for kind, places_of_kind in hollow.items():
        their, them = ("its", "it") if len(places_of_kind) == 1 else ("their", "them")
        repair = f"leave {them} out where nothing with floors stands there"
        yield f'{listed(places_of_kind)}: {their} tag building is "{kind}"; {repair}'
    if raised_places:
        yield f"{listed(raised_places)}: min_height is above 0, as of a bridge; taken from the ground up"


def is_part_of_building(table: Mapping[str, Any]) -> bool:
    """True of a part of a building: of OpenStreetMap by its tag, of Overture by the building that it names."""
    part = str(table.get("building:part") or "no").strip().lower()
    building = str(table.get("building") or "no").strip().lower()
    return bool(table.get("building_id")) or (part != "no" and building == "no")


def without_parts(entries: list[Entry], tables: Mapping[str, Mapping[str, Any]]) -> tuple[list[Entry], list[str]]:
    """The buildings without the parts that lie in them; a building without a height is as tall as its tallest part."""
    is_part = np.array([is_part_of_building(tables[entry.place]) for entry in entries], bool)
    if not is_part.any() or is_part.all():
        return entries, []
    whole = [entry for entry, part in zip(entries, is_part, strict=True) if not part]
    parts = [entry for entry, part in zip(entries, is_part, strict=True) if part]
    inner = shapely.point_on_surface(np.array([entry.footprint for entry in parts], dtype=object))
    of, inside = shapely.STRtree([entry.footprint for entry in whole]).query(inner, predicate="within")
    held = dict(zip(of.tolist(), inside.tolist(), strict=True))
    tallest: dict[int, dict[str, Any]] = {}
    for number, building in held.items():
        own, largest = parts[number].values, tallest.setdefault(building, {})
        largest |= {key: max(largest.get(key, 0), own[key]) for key in ("height", "storeys") if key in own}
    for number, largest in tallest.items():
        taken = {key: value for key, value in largest.items() if key not in whole[number].values}
        of_part = (Derived(key, f"{value:g}{' m' if key == 'height' else ''}", OF_PART) for key, value in taken.items())
        values, derived = {**taken, **whole[number].values}, (*whole[number].derived, *of_part)
        whole[number] = whole[number]._replace(values=values, derived=derived)
    lone = [part for number, part in enumerate(parts) if number not in held]
    notes = []
    if held:
        notes.append(
            f"{listed([parts[number].place for number in held])}: parts of buildings, which stand in the outlines of "
            "those; a building without a height, or storeys, has those of its tallest part"
        )
    if lone:
        notes.append(f"{listed([part.place for part in lone])}: parts that stand in no building; read as buildings")
    return [*whole, *lone], notes
