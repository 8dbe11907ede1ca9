"""Inventories of other tools: values in SI by each format's conventions, strings of the GEM taxonomy, refusals."""

import json
import random

import numpy as np
import pytest
import shapely
from openquake.gem_taxonomy import GemTaxonomy
from sentences import refusal

from pounding_risk.errors import PoundingError
from pounding_risk.streets.defaults import Rules
from pounding_risk.streets.inventory import formats, gem, read_inventory
from pounding_risk.streets.inventory._lines import Draft, Line, Notes
from pounding_risk.streets.inventory.gem import POSITIONS, put_taxonomy, read_taxonomy, with_found, year_of
from pounding_risk.streets.rows import read_block

FOOT = 0.3048
SQUARE = "POLYGON ((23.7200 37.9800, 23.7202 37.9800, 23.7202 37.9801, 23.7200 37.9801, 23.7200 37.9800))"
NEXT = "POLYGON ((23.7202001 37.9800, 23.7204 37.9800, 23.7204 37.9801, 23.7202001 37.9801, 23.7202001 37.9800))"
OED = f"""PortNumber,AccNumber,LocNumber,CountryCode,Latitude,Longitude,NumberOfStoreys,BuildingHeight,\
BuildingHeightUnit,FloorArea,FloorAreaUnit,YearBuilt,ConstructionCode,NumberOfBuildings,Geom,LocPerilsCovered,OEDVersion,FlexiLocGap
1,A1,10,GR,37.98005,23.7201,4,42.65,,6458.3462,,1962,5153,1,"{SQUARE}",QEQ,4.0.0,
1,A1,11,GR,37.98005,23.7203,2,6.4,2,360,12,0,5103,,"{NEXT}",QEQ,4.0.0,
1,A1,12,GR,37.98105,23.7201,-1,-999,1,0,11,1990,5000,0,,QEQ,4.0.0,
"""
R2D = """id,Latitude,Longitude,NumberOfStories,YearBuilt,OccupancyClass,PlanArea [ft^2],StructureType,Footprint
1,61.217,-149.908,2,1983,RES1,3059,W1,
2,61.218,-149.908,5,1975,COM4,5000,C1M,"{""type"":""Feature"",""geometry"":{""type"":""Polygon"",""coordinates"":\
[[[-149.9084,61.2170],[-149.9084,61.2172],[-149.9080,61.2172],[-149.9080,61.2170],[-149.9084,61.2170]]]},""properties"":{}}"
"""
FEATURES = """{"type": "FeatureCollection", "features": [
{"type": "Feature", "id": "7", "properties": {"NumberOfStories": 3, "PlanArea [ft^2]": 700.5, "YearBuilt": 1974.0,
"StructureType": "RM1", "Height": null, "gap [mm]": 25}, "geometry": {"type": "Polygon", "coordinates":
[[[-81.9363, 26.4458], [-81.9362, 26.4458], [-81.9362, 26.4459], [-81.9363, 26.4458]]]}},
{"type": "Feature", "id": "8", "properties": {"NumberOfStories": 2, "StructureType": "C1", "YearBuilt": 1990,
"storeys": "a tag"},
"geometry": {"type": "Point", "coordinates": [-81.936, 26.446]}}]}
"""
METADATA = """<?xml version="1.0" encoding="UTF-8"?>
<nrml xmlns:gml="http://www.opengis.net/gml" xmlns="http://openquake.org/xmlns/nrml/0.5">
  <exposureModel id="athens" category="buildings" taxonomySource="GEM_Building_Taxonomy_3.3">
    <description>three buildings</description>
    <conversions><costTypes/><area type="per_asset" unit="SQFT" /></conversions>
    <occupancyPeriods/>
    <assets>one.csv two.csv</assets>
    <exposureFields>
      <field oq="taxonomy" input="TAXONOMY" />
      <field oq="number" input="BUILDINGS" />
      <field oq="area" input="AREA" />
      <field oq="lon" input="X" />
      <field oq="lat" input="Y" />
    </exposureFields>
  </exposureModel>
</nrml>
"""
ASSETS = """id,X,Y,TAXONOMY,BUILDINGS,AREA
{0},23.72,37.98,CR/LFINF(MUR)+CDM/H:6/RES,1,6000
{1},23.73,37.98,S/LFBR/HAPP:9+HHI:3.5/Y:1987,1,
"""


def written(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def exposure(folder):
    written(folder, "one.csv", ASSETS.format("a", "b"))
    written(folder, "two.csv", ASSETS.format("c", "d"))
    return written(folder, "exposure.xml", METADATA)


def test_a_location_file_of_oed_is_read_in_its_default_units_and_in_those_it_gives(tmp_path):
    inventory = read_inventory(written(tmp_path, "loc.csv", OED))
    first, second, third = inventory.entries
    assert inventory.kind == "an OED location file"
    assert [entry.values["name"] for entry in inventory.entries] == ["10", "11", "12"]
    assert first.values["height"] == pytest.approx(42.65 * FOOT, rel=1e-12)  # feet where no unit is given
    assert first.values["floor area"] == pytest.approx(150.0, rel=1e-6)  # 6458 sq ft are 600 m² on four floors
    assert (second.values["height"], second.values["floor area"]) == (6.4, 180.0)
    assert (first.values["typology"], second.values["typology"]) == ("concrete_frame", "masonry")
    assert (first.year, second.year) == (1962, None)
    assert (first.longitude, first.latitude) == (23.7201, 37.98005)
    assert second.footprint.startswith("POLYGON ((23.7202001 37.98, 23.7204 37.98,")
    assert set(third.values) == {"name"} and third.footprint == ""
    told = {(each.column, each.value): each.rule for each in first.derived}
    assert "feet, the unit of OED where none is given" in told["height", "13 m"]
    assert told["typology", "concrete_frame"] == "ConstructionCode 5153, concrete moment frame"
    assert any("-1 says low-rise and no number" in note for note in inventory.left_out)
    assert any('"OEDVersion"' in note for note in inventory.left_out)


def test_999_below_zero_is_unknown_in_every_number_of_oed(tmp_path):
    """OEDInputFields.csv gives it as the default of numbers that are not known."""
    blank = OED.replace("-1,-999,1,0,11,1990,5000,0", "-999,-999.0,-999,-999,-999,-999,-999,-999")
    third = read_inventory(written(tmp_path, "loc.csv", blank)).entries[2]
    assert set(third.values) == {"name"} and third.year is None


def test_block_doubts_a_floor_of_another_size_than_its_footprint(tmp_path):
    """360 m² on two floors, of an insurer who means metres and states no unit, are taken for square feet: 16.7 m²."""
    text = OED.rsplit("1,A1,12", 1)[0].replace("360,12", "360,")
    (note,) = (note for note in read_block(written(tmp_path, "loc.csv", text)).notes if "unit" in note)
    # On WGS 84 at 37.98 degrees: 17.563 m by 11.100 m.
    assert note.startswith("line 3, 11 (16.72 m² over 194.9 m²): the floor area is less than half")


def test_the_example_of_oed_is_read(root):
    """Four lines of the standard's own example, of 190 columns most of which are blank."""
    inventory = read_inventory(root / "tests/data/inventories/oed_property_location.csv")
    assert [entry.values["name"] for entry in inventory.entries] == ["1", "2", "441", "442"]
    first = inventory.entries[0]
    assert (first.longitude, first.latitude, first.year) == (-0.9000228, 52.7774602, None)
    assert all(set(entry.values) == {"name"} for entry in inventory.entries)  # code 5000 is unknown
    assert any("line 4 and 1 other: ConstructionCode 5208, steel in concrete" in note for note in inventory.left_out)


def test_assets_of_r2d_are_read_with_the_unit_of_the_head_or_of_the_run(tmp_path):
    first, second = read_inventory(written(tmp_path, "assets.csv", R2D)).entries
    assert first.values == {"name": "1", "storeys": 2, "floor area": pytest.approx(3059 * FOOT**2), "hazus type": "W1"}
    assert (second.values["typology"], second.values["hazus type"]) == ("concrete_frame", "C1")
    assert second.footprint.startswith("POLYGON ((-149.9084 61.217, ") and first.footprint == ""
    bare = written(tmp_path, "bare.csv", R2D.replace(" [ft^2]", ""))
    inventory = read_inventory(bare)
    assert "floor area" not in inventory.entries[0].values
    assert any("PlanArea is not read" in note and "PlanArea [ft^2]" in note for note in inventory.left_out)
    written(tmp_path, "input.json", json.dumps({"units": {"force": "kips", "length": "inch", "time": "sec"}}))
    in_inches = read_inventory(bare)
    assert in_inches.entries[0].values["floor area"] == pytest.approx(3059 * 0.0254**2)
    assert any("check its unit" in note for note in in_inches.left_out)


def test_features_of_r2d_are_read_with_their_outlines(tmp_path):
    first, second = read_inventory(written(tmp_path, "assets.geojson", FEATURES)).entries
    assert (first.values["name"], first.values["storeys"], first.values["gap"], first.year) == ("7", 3, 0.025, 1974)
    ring = [[-81.9363, 26.4458], [-81.9362, 26.4458], [-81.9362, 26.4459], [-81.9363, 26.4458]]
    assert shapely.from_wkt(first.footprint).equals(shapely.Polygon(ring))
    assert (second.longitude, second.latitude, second.values["storeys"]) == (-81.936, 26.446, 2)


def test_an_exposure_is_read_through_its_metadata(tmp_path):
    inventory = read_inventory(exposure(tmp_path))
    assert [entry.values["name"] for entry in inventory.entries] == ["a", "b", "c", "d"]
    assert [entry.place for entry in inventory.entries][2] == "two.csv, line 2"
    first, second = inventory.entries[:2]
    assert first.values["storeys"] == 6 and first.values["floor area"] == pytest.approx(1000.0 * FOOT**2)
    assert (first.values["typology"], first.values["hazus type"]) == ("masonry", "C3")
    assert (first.values["code level"], first.taxonomy) == ("moderate", "CR/LFINF(MUR)+CDM/H:6/RES")
    assert second.values["height"] == pytest.approx(9 * 3.5) and second.year == 1987
    assert (second.values["typology"], second.values["storeys"]) == ("braced_frame", 9)
    assert (second.longitude, second.latitude) == (23.73, 37.98)


def test_an_exposure_without_metadata_has_no_unit_of_area(tmp_path):
    text = "id,lon,lat,taxonomy,number,area\na,23.7,37.9,RES1-C2M-LC,1,400\nb,23.7,37.9,Adobe,,\n"
    inventory = read_inventory(written(tmp_path, "assets.csv", text))
    first, second = inventory.entries
    assert first.values == {"name": "a", "typology": "concrete_walls", "hazus type": "C2", "code level": "low"}
    assert second.values == {"name": "b"} and second.taxonomy == "Adobe"
    assert any("no metadata say its unit" in note for note in inventory.left_out)
    text = "id,lon,lat,taxonomy,number,area [m^2]\na,23.7,37.9,MUR/H:2,1,400\n"
    (entry,) = read_inventory(written(tmp_path, "with_unit.csv", text)).entries
    assert entry.values["floor area"] == 200.0
    assert any('"Adobe" is no string of the GEM taxonomy' in note for note in inventory.left_out)


def test_assets_may_stand_in_the_metadata(tmp_path):
    asset = '<asset id="x" number="1" area="200" taxonomy="MUR/H:2"><location lon="23.7" lat="37.9" /></asset>'
    text = METADATA.replace("one.csv two.csv", asset)
    (entry,) = read_inventory(written(tmp_path, "exposure.xml", text)).entries
    assert (entry.place, entry.longitude, entry.values["storeys"]) == ("asset 1", 23.7, 2)
    assert entry.values["floor area"] == pytest.approx(100.0 * FOOT**2)


FAULTS = {
    "a unit in brackets": ("BuildingHeight,", "BuildingHeight [m],"),
    "the year 19620": ("1962", "19620"),
    "three buildings of a line": (",5153,1", ",5153,3"),
    "half a storey": (",4,42.65", ",4.5,42.65"),
    "no unit of an area": (",360,12", ",360,3"),
    "no code": (",5103,", ",51030,"),
    "no latitude": ("37.98005,23.7203", ",23.7203"),
    "beyond the pole": ("37.98005,23.7203", "97.9,23.7203"),
    "a bracket less": ("POLYGON ((23.7200", "POLYGON (23.7200"),
    "another system": ('"' + SQUARE + '"', '"SRID=2100;' + SQUARE + '"'),
    "cells missing": ("QEQ,4.0.0,\n1,A1,11", "QEQ\n1,A1,11"),
}


@pytest.mark.parametrize("words", FAULTS)
def test_a_fault_names_its_line_and_column(tmp_path, says, words):
    assert FAULTS[words][0] in OED
    says(refusal(read_inventory, written(tmp_path, "loc.csv", OED.replace(*FAULTS[words], 1))))


def test_block_takes_an_inventory_with_footprints_and_lists_what_follows_from_codes(tmp_path):
    text = OED.rsplit("1,A1,12", 1)[0]
    street = read_block(written(tmp_path, "loc.csv", text))
    (row,) = street.rows
    assert [house.name for house in row.buildings] == ["10", "11"]
    assert row.gaps[0] == pytest.approx(1e-7 * 111.32e3 * np.cos(np.radians(37.98)), abs=2e-4)
    assert [house.typology for house in row.buildings] == ["concrete_frame", "masonry"]
    mass = [6458.3462 * FOOT**2 / 4 * 10e3 / 9.80665, 180.0 * 10e3 / 9.80665]
    assert [house.floor_mass for house in row.buildings] == pytest.approx(mass, abs=1.0)
    told = {(value.building, value.column): value.rule for value in street.filled}
    words = "its FloorArea, in square feet, the unit of OED where none is given, over its storeys"
    assert told["10", "floor area"] == words
    assert told["11", "typology"] == "ConstructionCode 5103, unreinforced masonry walls"
    assert ("10", "hazus type") not in told
    assert "read as an OED location file" in street.notes
    measured = read_block(written(tmp_path, "loc.csv", text.replace("QEQ,4.0.0,", "QEQ,4.0.0,12 mm", 1)))
    assert measured.rows[0].gaps == (0.012,)


def test_block_says_what_an_inventory_lacks(tmp_path, says):
    table = written(tmp_path, "loc.csv", OED)
    says(refusal(read_block, table), refusal(read_block, exposure(tmp_path)))
    says(refusal(read_block, table, Rules(metres=True)))


def test_metadata_that_name_no_table_or_declare_entities_are_refused(tmp_path, says):
    exposure(tmp_path)
    says(refusal(read_inventory, written(tmp_path, "other.xml", METADATA.replace("TAXONOMY", "TAXONOMI"))))
    (tmp_path / "one.csv").unlink()
    says(refusal(read_inventory, written(tmp_path, "exposure.xml", METADATA)))
    text = METADATA.replace("<nrml", '<!DOCTYPE nrml [<!ENTITY a "b">]>\n<nrml', 1)
    says(refusal(read_inventory, written(tmp_path, "exposure.xml", text)))


def test_a_table_of_a_street_is_no_inventory(tmp_path, says):
    says(refusal(read_inventory, written(tmp_path, "street.csv", "name,height [m],gap [mm]\na,12,0\nb,9,0\n")))
    assert set(formats()) == {"oed", "openquake", "r2d"}


VALID = (
    "CR/LFM+CDM+DUM/H:6/RES",
    "MDD(CR;S)/LDD(LFM;LWAL)/HAPP:4",
    "HYB(MUR;W)/LFINF(MUR)/H:1-3/Y:<1960",
    "MUR+CLBRS+MOC/LWAL/H:2+HHT:7.5/PLFR+BP2/IRR",
    "W/LPB/IRI+IRP(TOR;REC)+IRV(SOS)/EWMA",
    "S+SR/LFBR/H:12/COM:3/IRI+IRV(POP;SOS)/RSH1",
    "BPD",
    "UNK",
)
OF_VERSION_2 = {"HEX", "HBET", "HBEX", "ASS"}


@pytest.fixture(scope="module")
def standard():
    return GemTaxonomy("3.3")


def atoms_of(attributes):
    """Names of the atoms of a string, those in brackets too."""
    for attribute in attributes:
        for atom in attribute.atoms:
            yield atom.name
            yield from atoms_of(atom.arguments)


def put(text):
    """The values that a string gives, and its faults and notes."""
    faults, notes = [], Notes()
    draft = Draft(Line("line 2", {}), faults, notes)
    put_taxonomy(draft, text, "taxonomy")
    return draft.values, faults, list(notes.sentences())


@pytest.mark.parametrize("text", VALID)
def test_a_string_is_read_as_it_is_written(standard, text):
    standard.validate(text)
    attributes = read_taxonomy(text)
    assert ("/".join(map(str, attributes)) or "UNK") == text


@pytest.mark.parametrize("text", VALID)
@pytest.mark.parametrize("position", POSITIONS)
@pytest.mark.parametrize("has_pounding", [True, False])
def test_what_was_found_is_written_in_the_words_of_the_standard(standard, text, position, has_pounding):
    """Valid, canonical where the string was, and with nothing lost but an earlier position or "regular"."""
    written = with_found(text, position, has_pounding)
    report = standard.validate(written)[2]
    assert report["is_canonical"], report
    atoms = list(atoms_of(read_taxonomy(written)))
    assert [atom for atom in atoms if atom in POSITIONS] == [position]
    assert ("POP" in atoms) == (has_pounding or "POP" in text)
    kept = [atom for atom in atoms_of(read_taxonomy(text)) if atom not in (*POSITIONS, *(["IRR"] * has_pounding))]
    assert set(kept) <= set(atoms) and len(atoms) <= len(kept) + 4
    assert with_found(written, position, has_pounding) == written


def test_without_a_position_and_pounding_a_string_stays(standard):
    for text in VALID:
        assert with_found(text, "", False) == text
    assert with_found("", "BP1", True) == "BP1/IRI+IRV(POP)"
    assert with_found("", "", False) == "UNK"


def test_atoms_that_are_known_are_those_of_the_standard(standard):
    attributes = {atom["name"]: atom["attr"] for atom in standard.tax["Atom"]}
    assert {attributes[name] for name in gem.MATERIALS} == {"material"}
    assert {attributes[name] for name in (*gem.SYSTEMS, *gem.LEVELS)} == {"llrs"}
    assert {attributes[name] for name in POSITIONS} == {"shape"}
    first = {"material", "llrs", "height", "dates", "occupancy"}
    assert {attributes[name] for name in gem.BEFORE if name not in OF_VERSION_2} == first
    types = ("material_type", "type_lateral_load", "building_occupancy_class")
    of_types = {atom["name"] for atom in standard.tax["Atom"] if atom["group"] in types}
    assert of_types <= {*gem.BEFORE}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("CR/LFM+CDM/H:6", {"typology": "concrete_frame", "hazus type": "C1", "code level": "moderate", "storeys": 6}),
        ("SRC/LDUAL/HAPP:11", {"typology": "concrete_walls", "hazus type": "C2", "storeys": 11}),
        ("CR/LFINF(MUR)+CDN/H:3-6", {"typology": "masonry", "hazus type": "C3", "code level": "pre", "storeys": 5}),
        ("S/LFBR/H:4+HHI:3.5", {"typology": "braced_frame", "hazus type": "S2", "storeys": 4, "height": 14.0}),
        ("S/LFBR/HHI:3.5+H:4", {"typology": "braced_frame", "hazus type": "S2", "storeys": 4, "height": 14.0}),
        ("MUR+ADO/LWAL/HBET:2,1", {"typology": "masonry", "hazus type": "URM", "storeys": 2}),
        ("MCF/LWAL/H:3+HHT:9.5", {"typology": "masonry", "storeys": 3, "height": 9.5}),
        ("W/LWAL/H:2", {"hazus type": "W1", "storeys": 2}),
        ("CR/H:<4", {}),
        ("UNK", {}),
    ],
)
def test_typology_storeys_and_height_follow_from_a_string(text, values):
    found, faults, _ = put(text)
    assert (found, faults) == (values, [])


def test_what_a_string_leaves_open_is_told():
    assert any("bounds the storeys and gives no number" in note for note in put("CR/LFM/H:<4")[2])
    assert any("CR, concrete of an unknown system" in note for note in put("CR/H:4")[2])
    assert year_of("CR/LFM/Y:1987/RES") == 1987 and year_of("CR/Y:<1960") is None and year_of("CR/YAPP:1930") == 1930


@pytest.mark.parametrize("text", ["/M", "M/", "+M", "M++S", "MDD(W", "MDD(W,Z)", "MDD()", "M)", "cr/lfm", "C R", "H:"])
def test_what_is_no_string_is_refused_by_both(standard, text):
    with pytest.raises(ValueError, match=r"\S"):
        standard.validate(text)
    with pytest.raises(PoundingError, match=r'write (one such as "CR/LFM|as "CR/LFM|as "LFINF)'):
        read_taxonomy(text)


def test_storeys_and_heights_out_of_range_are_faults():
    for text, words in [("CR/H:0", "gives no storeys"), ("CR/H:900", "gives no storeys"), ("CR/HHT:0", "no height")]:
        assert words in put(text)[1][0]
    assert "line 2, taxonomy: " in put("CR/")[1][0]


def test_any_text_is_read_or_refused():
    dice = random.Random(7)
    letters = "CRLFMSH:123+/;()UNKIV<>-. é\n"
    for _ in range(3000):
        text = "".join(dice.choice(letters) for _ in range(dice.randint(0, 12)))
        try:
            attributes = read_taxonomy(text)
        except PoundingError as error:
            assert str(error).isprintable()
        else:
            assert ("/".join(map(str, attributes)) or "UNK") == text
    with pytest.raises(PoundingError):
        read_taxonomy("M(" * 200 + ")" * 200)
