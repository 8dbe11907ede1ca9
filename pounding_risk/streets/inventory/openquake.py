"""Exposure models of OpenQuake: a CSV table, or the NRML metadata that name tables and their fields.

As of the engine's manual: without metadata the columns are id, lon, lat, taxonomy, number and area; `exposureFields`
give them other names; `area` in `conversions` says its unit, and whether an area is that of a building or of an asset.
An area is taken for the built-up area of all floors.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pounding_risk.errors import PoundingError
from pounding_risk.streets.hazus import family_of
from pounding_risk.streets.inventory._lines import Building, Draft, Kind, Line, Notes, Sheet, csv_sheet, key_of
from pounding_risk.streets.inventory.gem import put_taxonomy, read_taxonomy, year_of
from pounding_risk.streets.table import BlockError, file_text
from pounding_risk.units import shown

WORDS = "an exposure model of OpenQuake"
METADATA = ".xml"
FIELDS = ("id", "lon", "lat", "taxonomy", "number", "area")
NEEDED = ("lon", "lat", "taxonomy")
SPELLINGS = {"longitude": "lon", "latitude": "lat", "buildings": "number"}  # of the global exposure model of GEM
AREAS = {
    **dict.fromkeys(("sqm", "m2", "m^2", "sq m", "square meters", "square metres"), 1.0),
    **dict.fromkeys(("sqft", "ft2", "ft^2", "sq ft", "square feet"), 0.3048**2),
}
# Occupancy, type and level of the code, as the exposure of the United States names its buildings: "RES1-W1-LC".
OF_HAZUS = re.compile(r"[A-Z]+\d*[A-Z]?-([A-Z]{1,3}\d?[LMH]?)-(HC|MC|LC|PC)")
LEVELS = {"HC": "high", "MC": "moderate", "LC": "low", "PC": "pre"}


def recognises(heads: frozenset[str]) -> bool:
    """True for the head of a table of assets without metadata."""
    return set(NEEDED) <= {SPELLINGS.get(head, head) for head in heads}


def buildings(sheet: Sheet, faults: list[str], notes: Notes) -> Iterator[Building]:
    """The buildings of an exposure."""
    heads = _heads(sheet)
    columns, name = sheet.own(heads.values(), notes), sheet.name_head(heads["id"])
    unit = sheet.unit(heads["area"]) or str(sheet.facts.get("area unit", "")).strip()
    for line in sheet.lines:
        draft = Draft(line, faults, notes)
        if name:
            draft.put("name", draft.text(name))
        taxonomy = _taxonomy(draft, heads["taxonomy"])
        draft.single(heads["number"])
        _area(draft, heads["area"], unit)
        draft.own_columns(columns)
        yield draft.building("", draft.point(heads["lon"], heads["lat"]), taxonomy=taxonomy, year=year_of(taxonomy))


def _heads(sheet: Sheet) -> Mapping[str, str]:
    """The head of each field in this table."""
    head_by_field = {SPELLINGS.get(head.lower(), head.lower()): head for head in sheet.heads}
    fields: Mapping[str, str] = sheet.facts.get("fields", {})
    return {field: fields.get(field) or head_by_field.get(field, field) for field in FIELDS}


def _taxonomy(draft: Draft, head: str) -> str:
    """The string of an asset, of GEM or of Hazus types; the columns that follow from it are set."""
    text = draft.text(head)
    hazus = OF_HAZUS.fullmatch(text)
    family = family_of(hazus[1]) if hazus else ""
    if hazus and family:
        draft.kind(Kind.of_hazus(family), f"{head} {text}")
        draft.put("code level", LEVELS[hazus[2]], rule=f"its {head}, {hazus[2]}")
        return text
    try:
        read_taxonomy(text)
    except PoundingError:
        if text:
            words = "is no string of the GEM taxonomy; typology and storeys are not read in it"
            draft.note(f"{head} {shown(text)} {words}")
        return text
    return put_taxonomy(draft, text, head)


def _area(draft: Draft, head: str, unit: str) -> None:
    """The area of a floor from that of all floors, where its unit and the storeys are known."""
    area = draft.number(head, 0.0)
    if not area:
        return
    if unit.lower() not in AREAS:
        reason = f"the unit {shown(unit)} is not known" if unit else "no metadata say its unit"
        draft.note(f'{head} is not read, as {reason}; give metadata (.xml) with <area type="per_asset" unit="SQM" />')
    elif "storeys" not in draft.values:
        draft.note(f"{head} is taken for that of all floors, whose number is missing; it is not read")
    else:
        one = area * AREAS[unit.lower()] / draft.values["storeys"]
        draft.put("floor area", one, f"{one:.5g} m²", f"its {head}, taken for that of all floors, over its storeys")


def metadata_sheet(path: Path, text: str, faults: list[str]) -> Sheet:
    """The assets of metadata: those that they hold, or those of the tables that they name."""
    model = _model(text, faults)
    if model is None:
        return Sheet(path, (), [])
    facts: dict[str, Any] = {"fields": {}}  # unit of areas and names of fields
    for element in model.iter():
        if _tag(element) == "area" and "unit" in element.attrib:
            facts["area unit"] = element.attrib["unit"]
        elif _tag(element) == "field" and element.get("oq") in FIELDS:
            if not element.get("input"):
                faults.append(f'exposureFields: the field "{element.get("oq")}" has no input; write the column\'s name')
            facts["fields"][element.get("oq")] = element.get("input", "")
    assets = next((element for element in model if _tag(element) == "assets"), None)
    if assets is None:
        faults.append("has no <assets>; name the tables in it, or write an <asset> for each building")
        return Sheet(path, (), [])
    if len(assets):
        lines = []
        for number, element in enumerate(assets, 1):
            place = next((child for child in element if _tag(child) == "location"), element)
            lines.append(Line.of(f"asset {number}", {**element.attrib, **place.attrib}.items()))
        return Sheet(path, FIELDS, lines, {**facts, "fields": {}})  # other names are those of tables
    heads: list[str] = []
    lines = []
    for name in (assets.text or "").split():
        table = path.parent / name
        try:
            sheet = csv_sheet(table, file_text(table), faults, f"{name}, ")
        except BlockError as error:
            faults += [f"<assets> names {name}, which {fault}" for fault in error.faults]
            continue
        heads += [head for head in sheet.heads if head not in heads]
        lines += sheet.lines
    if not lines and not faults:
        faults.append("<assets> names no table with a line; write the names of CSV files beside it")
    sheet = Sheet(path, tuple(heads), lines, facts)
    known_keys = {key_of(head) for head in heads}
    for field, head in _heads(sheet).items():
        if heads and head.lower() not in known_keys and (field in NEEDED or field in facts["fields"]):
            faults.append(f'no table has the column {shown(head)} for "{field}"; write its name into exposureFields')
    return sheet


def _model(text: str, faults: list[str]) -> ET.Element | None:
    """The exposure model of NRML; None with a fault where there is none."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        faults.append("declares a document type, which NRML has not; leave it out")
        return None
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError) as error:
        faults.append(f"is not XML ({error}); export the exposure again")
        return None
    model = next((element for element in root.iter() if _tag(element) == "exposureModel"), None)
    if model is None:
        faults.append(f"<{_tag(root)}> holds no <exposureModel>; give the metadata of an exposure")
    return model


def _tag(element: ET.Element) -> str:
    return str(element.tag).rpartition("}")[2]
