"""Assets of SimCenter's R2D: the CSV tables of its examples, and GeoJSON as BRAILS writes it.

Columns are those of NHERI-SimCenter/R2DExamples; what they mean is read in the building model MDOF-LU of
SimCenterBackendApplications: PlanArea is the area of one floor, and lengths are in the unit of the run's input.json.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from pounding_risk._common.inputs import EXPORT, read_text
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.streets.hazus import FAMILIES, family_of
from pounding_risk.streets.inventory._lines import Building, Draft, Kind, Notes, Sheet
from pounding_risk.streets.table import AREA, HEIGHT
from pounding_risk.units import QuantityError, parse

WORDS = "assets of SimCenter R2D"
OF_ASSETS = {"numberofstories", "planarea", "structuretype", "occupancyclass", "yearbuilt", "replacementcost"}
ENOUGH = 3  # of these columns, by which the head is recognised
READ = (
    *("id", "Building_ID", "Latitude", "Longitude", "NumberOfStories", "PlanArea", "StructureType", "YearBuilt"),
    *("Height", "Footprint"),
)
RUN = "input.json"  # of R2D, beside the table or in the folder above
LEAST_AREA = 10.0  # m²; a smaller floor is doubted
LENGTHS = ("m", "ft", "in", "inch", "cm", "mm")  # what R2D calls them


def recognises(heads: frozenset[str]) -> bool:
    """True for the head of a table of assets, or for the properties of such features."""
    return len(heads & OF_ASSETS) >= ENOUGH


def buildings(sheet: Sheet, faults: list[str], notes: Notes) -> Iterator[Building]:
    """The buildings of a table of assets."""
    columns, name = sheet.own(READ, notes), sheet.name_head("id", "Building_ID")
    length, unit_words = _run_unit(sheet.path)
    for line in sheet.lines:
        draft = Draft(line, faults, notes)
        if name and draft.text(name):
            draft.put("name", draft.text(name))
        storeys = draft.whole("NumberOfStories", 0, MOST_STOREYS)
        if storeys:
            draft.put("storeys", storeys)
        footprint = _outline(draft)
        _measure(draft, sheet, "Height", "height", length, unit_words)
        _measure(draft, sheet, "PlanArea", "floor area", length, unit_words)
        if draft.values.get("floor area", LEAST_AREA) < LEAST_AREA:
            draft.note(f"its PlanArea is less than {LEAST_AREA:g} m²; check its unit")
        _kind(draft)
        draft.own_columns(columns)
        yield draft.building(footprint, _point(draft), year=draft.year("YearBuilt"))


def _run_unit(path: Path) -> tuple[str, str]:
    """The unit of length of the run that a table belongs to, and where it stands; "" where no run says it."""
    for folder in (path.parent, path.parent.parent):
        try:
            units = json.loads(read_text(folder / RUN, EXPORT))["units"]
            unit = str(units["length"]).lower()
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            continue
        if unit in LENGTHS:
            return unit, f"in the unit of length of {RUN}, {unit}"
    return "", ""


def _measure(draft: Draft, sheet: Sheet, head: str, column: str, length: str, source_text: str) -> None:
    """A length or an area in the unit of its head, or of the run; not read where neither says one."""
    measure = draft.number(head, 0.0)
    if not measure:
        return
    quantity, example = (AREA, "ft^2") if column == "floor area" else (HEIGHT, "ft")
    unit = sheet.unit(head) or (f"{length}{example[2:]}" if length else "")
    if not unit:
        reason = f"neither its head nor an {RUN} beside the table says its unit"
        draft.note(f"{head} is not read, as {reason}; write {head} [{example}] into the head")
        return
    try:
        size = parse(f"{measure!r} {unit}", quantity)
    except QuantityError as error:
        draft.fault(head, str(error))
        return
    words = f"{size:.5g} m²" if quantity is AREA else f"{size:.4g} m"
    draft.put(column, size, words, "" if sheet.unit(head) else f"its {head} {source_text}")


def _kind(draft: Draft) -> None:
    """Typology and family of a structural type of Hazus, "C1" or "C1M"."""
    text = draft.text("StructureType")
    family = family_of(text)
    if family:
        draft.kind(Kind.of_hazus(family), f"StructureType {text}")
    elif text:
        draft.fault("StructureType", f'"{text}" is no type of Hazus; it may be {", ".join(FAMILIES)}')


def _outline(draft: Draft) -> str:
    """The outline of a feature, or of the GeoJSON in the column Footprint."""
    text = draft.line.cells.get("footprint")
    if text is None:
        return draft.outline("geometry", draft.line.geometry)
    try:
        shape = json.loads(text)
    except (ValueError, RecursionError) as error:
        draft.fault("Footprint", f"is not JSON ({error}); write a GeoJSON feature, or leave it empty")
        return ""
    geometry = shape.get("geometry", shape) if isinstance(shape, dict) else None
    if not isinstance(geometry, dict):
        draft.fault("Footprint", "holds no geometry; write a GeoJSON feature of a Polygon, or leave it empty")
        return ""
    return draft.outline("Footprint", geometry)


def _point(draft: Draft) -> tuple[float, float]:
    """Longitude and latitude of the columns, or of a feature that is a point."""
    geometry = draft.line.geometry
    if isinstance(geometry, dict) and geometry.get("type") == "Point" and "longitude" not in draft.line.cells:
        return draft.place_of(geometry.get("coordinates"))
    return draft.point("Longitude", "Latitude")
