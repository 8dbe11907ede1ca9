"""Location files of OED, the Open Exposure Data standard of Oasis LMF (Loc, versions 3 to 5).

Fields, defaults and codes are those of OEDInputFields.csv, ConstructionValues.csv and OtherValues.csv of
OasisLMF/ODS_OpenExposureData (version 5.0.0): an area is that of all floors, in square feet where no unit is given, a
height in feet.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import MappingProxyType

from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.streets.inventory._lines import Building, Draft, Kind, Notes, Sheet
from pounding_risk.streets.inventory.gem import put_taxonomy

WORDS = "an OED location file"
REQUIRED = "locnumber"
BESIDE = {"portnumber", "accnumber", "countrycode", "locperilscovered", "loccurrency", "constructioncode"}
OWN = "flexiloc"  # how heads of columns start that the standard does not have
READ = (
    *("LocNumber", "LocName", "AccNumber", "PortNumber", "Longitude", "Latitude", "Geom", "NumberOfStoreys"),
    *("BuildingHeight", "BuildingHeightUnit", "FloorArea", "FloorAreaUnit", "YearBuilt", "ConstructionCode"),
    *("NumberOfBuildings", "OrgConstructionScheme", "OrgConstructionCode"),
)
LONGEST_GEOM = 250  # characters that the field holds
# Name and size in SI of the codes of units; the first of each is the default.
LENGTHS = {1: ("feet", 0.3048), 2: ("metres", 1.0), 3: ("kilometres", 1e3), 4: ("miles", 1609.344)}
AREAS = {11: ("square feet", 0.3048**2), 12: ("square metres", 1.0), 13: ("acres", 4046.8564224), 14: ("hectares", 1e4)}
BLANK = ("-999", "-999.0")  # of a number that is not known
RISES = {-1: "low", -2: "mid", -3: "high"}
UNKNOWN, FIRST_CODE, LAST_CODE = 5000, 5000, 8999
CODES = MappingProxyType(
    {
        **dict.fromkeys((5050, 5051, 5052), "W1"),
        **dict.fromkeys((5101, 5102, 5103, 5108, 5110), "URM"),
        5105: "RM1",  # its floors are of wood
        **dict.fromkeys((5151, 5152), "C2"),
        **dict.fromkeys((5153, 5154, 5158), "C1"),
        5155: "PC1",
        5157: "PC2",
        5159: "C3",
        5201: "S3",
        5202: "S2",
        **dict.fromkeys((5203, 5204, 5205), "S1"),
        5206: "S5",
        5207: "S4",
    }
)
# Codes without a single family, some of which have a typology.
OTHERS = MappingProxyType(
    {
        5100: Kind("", "masonry", "masonry"),
        5104: Kind("", "masonry", "unreinforced masonry in a bearing frame"),
        5106: Kind("", "masonry", "reinforced masonry walls with moment frames"),
        5107: Kind("", "masonry", "reinforced masonry walls"),
        5109: Kind("", "masonry", "confined masonry"),
        5150: Kind("", "", "reinforced concrete of an unknown system"),
        5156: Kind("", "", "precast concrete frame"),
        5200: Kind("", "", "steel of an unknown system"),
        5208: Kind("", "", "steel in concrete, of an unknown system"),
    }
)


def recognises(heads: frozenset[str]) -> bool:
    """True for the head of a location file."""
    return REQUIRED in heads and bool(heads & BESIDE)


def buildings(sheet: Sheet, faults: list[str], notes: Notes) -> Iterator[Building]:
    """The buildings of a location file."""
    for head in filter(sheet.unit, READ):
        faults.append(f"head: {head} has a unit in brackets, which OED says by a code; write {head}Unit, and its code")
    columns, name = sheet.own(READ, notes, OWN), sheet.name_head("LocName", "LocNumber")
    for line in sheet.lines:
        known_cells = {key: cell for key, cell in line.cells.items() if cell.strip() not in BLANK}
        draft = Draft(line._replace(cells=known_cells), faults, notes)
        identifiers = [draft.text(head) for head in ((name,) if name else ("PortNumber", "AccNumber", "LocNumber"))]
        if "-".join(filter(None, identifiers)):
            draft.put("name", "-".join(filter(None, identifiers)))
        _size(draft)
        _kind(draft)
        draft.single("NumberOfBuildings", unknown=(0.0,))
        year, taxonomy = draft.year("YearBuilt"), ""
        if draft.text("OrgConstructionScheme").upper().startswith("GEM") and draft.text("OrgConstructionCode"):
            taxonomy = put_taxonomy(draft, draft.text("OrgConstructionCode"), "OrgConstructionCode")
        draft.own_columns(columns)
        geometry = draft.wkt("Geom")
        if geometry is None and len(line.cells.get("geom", "")) >= LONGEST_GEOM:
            draft.fault("Geom", f"the field holds {LONGEST_GEOM} characters, at which its text may be cut off")
        point = draft.point("Longitude", "Latitude")
        if geometry is not None and geometry["type"] == "Point" and point != point:
            point = draft.place_of(geometry["coordinates"][0])
        yield draft.building(draft.outline("Geom", geometry), point, taxonomy=taxonomy, year=year)


def _size(draft: Draft) -> None:
    """Storeys, height, and the area of a floor, which is that of all floors over their number."""
    storeys = draft.whole("NumberOfStoreys", -3, MOST_STOREYS)
    if storeys and storeys > 0:
        draft.put("storeys", storeys)
    elif storeys:
        draft.note(f"NumberOfStoreys {storeys} says {RISES[storeys]}-rise and no number; it is not read")
    height = draft.number("BuildingHeight", 0.0)
    if height:
        words, size = _unit(draft, "BuildingHeightUnit", LENGTHS)
        rule = f"its BuildingHeight, {words}" if words else ""
        draft.put("height", height * size, f"{height * size:.4g} m", rule)
    area = draft.number("FloorArea", 0.0)
    if not area:
        return
    words, size = _unit(draft, "FloorAreaUnit", AREAS)
    if "storeys" not in draft.values:
        draft.note("FloorArea is that of all floors, whose number is missing; it is not read")
        return
    one = area * size / draft.values["storeys"]
    draft.put("floor area", one, f"{one:.5g} m²", f"its FloorArea{words and f', {words},'} over its storeys")


def _unit(draft: Draft, head: str, units: dict[int, tuple[str, float]]) -> tuple[str, float]:
    """Words for a unit that is not given, "" for one that is, and its size in SI."""
    default = next(iter(units))
    code = draft.whole(head)
    if code is not None and code in units:
        return "", units[code][1]
    if code is not None:
        allowed = ", ".join(f"{code} ({name})" for code, (name, _) in units.items())
        draft.fault(head, f"{code} is no unit of it; it may be {allowed}")
    return f"in {units[default][0]}, the unit of OED where none is given", units[default][1]


def _kind(draft: Draft) -> None:
    """Typology and family of a construction code."""
    code = draft.whole("ConstructionCode")
    if code in (None, UNKNOWN):
        return
    if not FIRST_CODE <= code <= LAST_CODE:
        draft.fault("ConstructionCode", f"{code} is no code of OED, {FIRST_CODE} to {LAST_CODE}; correct it")
        return
    other_kind = OTHERS.get(code, Kind("", "", "a code that is not among those read"))
    draft.kind(Kind.of_hazus(CODES[code]) if code in CODES else other_kind, f"ConstructionCode {code}")
