"""Streets as rows: a table and its footprints agree, gaps are the distances, what is missing is filled and told."""

import csv
import io
import json
import math
import re
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import commands
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sentences import refusal
from sweeps import examples

import pounding_risk as pr
from pounding_risk import units as quantities
from pounding_risk._common.files import partial_of
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.motions.catalogue import entry
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import parse_scene
from pounding_risk.streets import rows as block_rows
from pounding_risk.streets import scenes as block_scenes
from pounding_risk.streets.defaults import Rules
from pounding_risk.streets.rows import Block, read_block
from pounding_risk.streets.table import BlockError

STREETS = Path(pr.__file__).resolve().parent / "scene" / "shipped"
HEAD = "name,height [m],storeys,typology,floor area [m^2],gap [mm]\n"
JSON = "street.geojson"
Street = list[dict[str, Any]]


@st.composite
def streets(draw) -> Street:
    """Two to seven buildings with one front line; gaps in whole centimetres, some of them wide enough to part rows."""
    place, found = 0.0, []
    for number in range(draw(st.integers(2, 7))):
        width, depth = (draw(st.integers(50, 250)) / 10 for _ in range(2))
        left, right = round(place, 2), round(place + width, 2)
        storeys = draw(st.integers(1, 9))
        found.append(
            {
                "name": f"No. {number}",
                "height [m]": round(storeys * draw(st.sampled_from([2.8, 3.0, 3.6])), 2),
                "storeys": storeys,
                "typology": draw(st.sampled_from(sorted(set(TYPOLOGIES) - {"masonry"}))),
                "floor area [m^2]": width * depth,
                "left wall [m]": left,
                "right wall [m]": right,
                "depth": depth,
            }
        )
        place = right + draw(st.sampled_from([0.0, 0.01, 0.05, 0.3, 1.2, 4.0]))
    return found


def as_csv(street: Street) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, [name for name in street[0] if name != "depth"], extrasaction="ignore")
    writer.writeheader()
    writer.writerows(street)
    return text.getvalue()


def as_geojson(street: Street, turn: float = 0.0, scale: tuple[float, float] = (1.0, 1.0), mirror: bool = False) -> str:
    """Footprints turned anticlockwise by an angle; ``scale`` is degrees a metre, ``mirror`` turns the street over."""
    features = []
    for each in street:
        left, right, depth = each["left wall [m]"], each["right wall [m]"], each["depth"]
        corners = np.array([(left, 0.0), (right, 0.0), (right, depth), (left, depth), (left, 0.0)])
        corners *= (-1.0 if mirror else 1.0, 1.0)
        corners = corners @ [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]] * scale
        properties = {name: each[name] for name in ("name", "height [m]", "storeys", "typology")}
        geometry = {"type": "Polygon", "coordinates": [corners.tolist()]}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return collection(*features)


def read(folder: Path, text: str, name: str = "street.csv", **rules: Any) -> Block:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_block(path, Rules(**rules))


def faults(folder: Path, text: str, name: str = "street.csv", **rules: Any) -> list[str]:
    with pytest.raises(BlockError) as error:
        read(folder, text, name, **rules)
    return error.value.faults


def outline(block: Block) -> list[tuple]:
    """Rows and buildings alone, without numbers that a survey gives."""
    rows = [tuple(house[:5] for house in row.buildings) for row in block.rows]
    return [*rows, *((house[:5],) for house in block.alone)]


def assert_alike(one: Block, other: Block) -> None:
    assert outline(one) == outline(other)
    for mine, theirs in zip(one.rows, other.rows, strict=True):
        # Both are rounded to 0.1 mm; a distance between two roundings may come out as either.
        assert mine.gaps == pytest.approx(theirs.gaps, abs=1.01e-4)
        masses, others = ([house.floor_mass for house in row.buildings] for row in (mine, theirs))
        assert masses == pytest.approx(others, rel=1e-3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("streets")


@examples(50, streets(), st.floats(-3.14, 3.14))
@pytest.mark.complete
def test_a_table_and_the_footprints_of_a_street_are_the_same_rows(folder, street, turn):
    """However the footprints are turned; in metres, and in degrees near the equator, where 1e-5 degrees are 1.1 m."""
    table = read(folder, as_csv(street))
    assert_alike(table, read(folder, as_geojson(street, turn), JSON, metres=True))
    walls = [(each["left wall [m]"], each["right wall [m]"]) for each in street]
    gaps = [after[0] - before[1] for before, after in pairwise(walls)]
    assert sorted(gap for row in table.rows for gap in row.gaps) == pytest.approx(sorted(g for g in gaps if g < 1.0))


@examples(30, streets(), st.floats(-3.14, 3.14))
@pytest.mark.complete
def test_degrees_are_as_good_as_metres(folder, street, turn):
    """At the equator, by 110.574 km a degree north and 111.320 km east, the ellipsoid's own (Snyder 1987, table 3)."""
    scale = (1.0 / 111.320e3, 1.0 / 110.574e3)
    metres = read(folder, as_geojson(street, turn), JSON, metres=True)
    degrees = read(folder, as_geojson(street, turn, scale), JSON)
    assert outline(metres) == outline(degrees)
    for mine, theirs in zip(metres.rows, degrees.rows, strict=True):
        assert mine.gaps == pytest.approx(theirs.gaps, abs=2e-4)


@examples(30, streets())
@pytest.mark.complete
def test_a_mirrored_street_is_the_mirrored_rows(folder, street):
    """Walls seen from behind reverse the rows, as do footprints listed the other way; footprints turned over do not."""
    rows = read(folder, as_csv(street)).rows
    walls = [{"left wall [m]": -each["right wall [m]"], "right wall [m]": -each["left wall [m]"]} for each in street]
    behind = [each | own for each, own in zip(street, walls, strict=True)]
    mirrored = read(folder, as_csv(behind)).rows[::-1]
    listed = read(folder, as_geojson(street[::-1]), JSON, metres=True).rows[::-1]
    for reverse in (mirrored, listed):
        back = sorted(reverse, key=lambda row: row.buildings[-1].name)
        names = [[house.name for house in row.buildings[::-1]] for row in back]
        assert [[house.name for house in row.buildings] for row in rows] == names
    turned_over = read(folder, as_geojson(street, mirror=True), JSON, metres=True)
    assert_alike(read(folder, as_geojson(street), JSON, metres=True), turned_over)


def test_streets_of_one_file_keep_their_places(folder):
    """Two squares on one meridian, a hundredth of a degree apart: 111.229 km a degree at 50 degrees north (WGS 84)."""
    size = 1e-4
    rings = [[[x * size / 10 + 8.0, y * size / 10 + 50.0 + street / 100] for x, y in SQUARE] for street in (0, 1)]
    features = [feature([ring], street=f"{street}", **{"floor mass [t]": 80}) for street, ring in enumerate(rings)]
    block = read(folder, collection(*features), JSON)
    one, other = (np.array(house.footprint.exterior.coords[0]) for house in block.alone)
    assert other - one == pytest.approx([0.0, 1112.29], abs=0.1)


def test_what_is_missing_is_filled_by_rule_and_told(folder, says):
    text = HEAD + "A,12.5,,masonry,180,20\n,,4,,200,\nC,9,3,steel_frame,150,\n"
    block = read(folder, text, gap=0.03, floor_load=8e3)
    (row,) = block.rows
    assert [house.name for house in row.buildings] == ["A", "building 2", "C"]
    assert [(house.height, house.storeys) for house in row.buildings] == [(12.5, 4), (12.0, 4), (9.0, 3)]
    assert row.gaps == (0.02, 0.03)
    # 8 kN/m² × 180 m² / 9.80665 m/s²
    assert row.buildings[0].floor_mass == pytest.approx(146839.0, abs=1.0)
    says([", ".join(each[1:]) for each in block.filled])
    assert next(csv.reader(block_scenes.filled_csv(block.filled).splitlines()[1:])) == list(block.filled[0])


def test_a_value_that_is_given_is_never_filled(folder):
    head = "name,height [ft],storeys,typology,period [ms],damping [%],floor mass [t],floor depth [mm],gap\n"
    block = read(folder, head + "A,30,3,masonry,310,4,80,220,12 mm\nB,30,3,Concrete frame,,4,80,300,\n")
    first, second = block.rows[0].buildings
    assert (first.height, first.period, first.damping, first.floor_mass) == (9.144, 0.31, 0.04, 80e3)
    assert (first.floor_depth, second.floor_depth) == (0.22, 0.3)
    assert block.rows[0].gaps == (0.012,) and second.period is None
    assert (first.typology, second.typology) == ("masonry", "concrete_frame")
    # What a table has no columns for, and the period that the second line leaves out.
    generated = [(name, column) for name in "AB" for column in ("storey stiffness", "storey strengths")]
    assert sorted((each.building, each.column) for each in block.filled) == sorted([*generated, ("B", "period")])


def test_what_the_scene_generates_is_listed(folder):
    """By the resolved scene, of its own storeys; the period by 0.0466 h^0.9 of ASCE 7."""
    block = read(folder, HEAD + "A,12,4,concrete_frame,180,20\nB,9,3,concrete_walls,150,\n")
    told = {(each.building, each.column): each.value for each in block.filled}
    assert told["A", "period"] == f"{0.0466 * 12.0**0.9:.4g} s" and told["B", "period"] == f"{0.0488 * 9.0**0.75:.4g} s"
    (text,) = block.scenes().values()
    for building in parse_scene(text).buildings:
        stiffness, strength = building.stiffnesses[0] / 1e6, building.strengths[0] / 1e3
        assert told[building.name, "storey stiffness"] == f"{stiffness:.4g} MN/m at the ground"
        assert told[building.name, "storey strengths"] == f"{strength:.4g} kN at the ground"


@pytest.mark.parametrize(
    ("height", "keys"), [(9, ["yield_force"]), (10.5, ["column_yield_force"]), (12, ["yield_force"])]
)
def test_no_yield_force_without_effect_is_written(folder, height, keys):
    """Storeys of 3 m beside others of 3 m, whose floors meet, and of 3.5 m, the lower building, whose floors do not."""
    forces = block_scenes.Contact("viscous_elastoplastic", yield_force="5 MN", column_yield_force="1 MN")
    storeys = 4 if height == 12 else 3
    block = read(folder, HEAD + f"A,15,5,masonry,180,20\nB,{height},{storeys},masonry,150,\n")
    (text,) = block.scenes(contact=forces).values()
    (interface,) = tomllib.loads(text)["interface"]
    assert [key for key in ("yield_force", "column_yield_force") if key in interface] == keys
    assert not [words for words in unused_keys(parse_scene(text)) if "yield_force" in words]


def collection(*features: dict[str, Any]) -> str:
    return json.dumps({"type": "FeatureCollection", "features": list(features)})


def footprints_read(folder: Path, *features: dict[str, Any], **rules: Any) -> Block:
    return read(folder, collection(*features), JSON, **{"metres": True} | rules)


def test_a_building_behind_another_is_not_alone(folder):
    """30 mm clear across the axis of the street, told on every way out; one 3 m behind is alone."""
    front = [feature([SQUARE], "1"), feature([shifted(10.02)], "2")]
    others = feature([shifted(1.0, 10.03)], "yard"), feature([shifted(0.0, -13.0)], "far")
    block = footprints_read(folder, *front, *others, axis=90.0)
    assert [[house.name for house in row.buildings] for row in block.rows] == [["1", "2"]]
    assert [house.name for house in block.in_no_row] == ["yard", "far"]
    assert [house.name for house in block.alone] == ["far"]
    told = [f"{front} and yard: 30 mm clear, across the axis of the street" for front in (1, 2)]
    assert [pair.words for pair in block.close] == told
    (scene,) = block.scenes(["RSN6-180"]).values()
    words = "Close to a building of this row, and not in it as its neighbour:"
    assert f"# {words}\n#   {told[0]}\n#   {told[1]}\n" in scene
    path = folder / JSON
    shown = commands.done("block", path, "--metres", "--axis", "90 deg", "-o", folder / "out")
    assert "alone, no neighbour within 1 m in any direction: far" in shown.output
    lines = [line.split() for line in shown.output.splitlines()]
    assert ["1", "yard", "30", "mm", "across", "the", "axis", "of", "the", "street"] in lines
    with (folder / "out" / "neighbours.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    assert [",".join(row) for row in rows] == [
        ",1,,2,0.02,0.01,0.03,10,1,3,0,0,neighbours in street",
        f",1,,yard,0.03,0.02,0.04,9,0.9,3,0,0,in no row: {told[0].split(', ')[1]}",
        f",2,,yard,0.03,0.02,0.04,0.98,0.098,3,0,0,in no row: {told[1].split(', ')[1]}",
    ]


def test_no_row_ends_with_status_2_and_the_reason(folder, tmp_path):
    behind = collection(feature([SQUARE]), feature([shifted(0.0, 10.03)], "B"))
    (tmp_path / "wide.csv").write_text("name,storeys,floor mass [t],gap [m]\nA,3,80,2\nB,3,80,\n", encoding="utf-8")
    (tmp_path / "behind.geojson").write_text(behind, encoding="utf-8")
    for words, reason in (
        (["wide.csv"], "no row: no two buildings stand within 1 m of each other along the street; check the walls"),
        (
            ["behind.geojson", "--metres", "--axis", "90 deg"],
            "as neighbours, though 1 pair stands so close, such as A and B: 30 mm clear, across the axis of the "
            "street; state another direction of the street (--axis)",
        ),
    ):
        out = tmp_path / "out"
        told = commands.run("block", tmp_path / words[0], *words[1:], "-o", out)
        assert told.exit_code == 2 and not out.exists()
        assert reason in " ".join(told.stderr.split())
        assert "A" in told.stdout  # the table of what stands alone, or close, comes first
    assert "no row" in refusal(pr.block, tmp_path / "wide.csv", tmp_path / "out", kind=BlockError)


CSV_FAULTS = {
    "no building": "name,height [m]\n",
    "several faults": HEAD + "A,x,3,masonry,180,\nB,12,3.5,masonry,180,\nC,12,3\n",
    "more faults": HEAD + "A,,,masonry,180,\nB,12,3,brick,180,\nB,12,3,masonry,,\n",
    "no column of a street": "house,colour\nA,12\n",
    "a misspelt column": "name,hieght [m]\nA,12\n",
    "a column twice": "name,height [m],height [ft]\nA,12,30\n",
    "a word for a height": HEAD + "A,x,3,masonry,180,\n",
    "a unit in a column with one": HEAD + "A,12 m,3,masonry,180,\n",
    "no value": HEAD + "A,NA,3,masonry,180,\n",
    "no typology": HEAD + "A,12,3,n/a,180,\n",
    "a height without a unit": "name,height,floor mass [t]\nA,12,80\n",
    "a height in seconds": "name,height [s],floor mass [t]\nA,12,80\n",
    "a negative height": HEAD + "A,-12,3,masonry,180,\n",
    "half a storey": HEAD + "A,12,3.5,masonry,180,\n",
    "no storey": HEAD + "A,12,0,masonry,180,\n",
    "a misspelt typology": HEAD + "A,12,3,masnry,180,\n",
    "typologies of the field": HEAD + "A,12,3,rc frame,180,\nB,12,3,shear walls,180,\n",
    "higher than a typology goes": HEAD + "A,55,14,masonry_ec8,180,\n",
    "too many storeys": HEAD + "A,12000,,masonry,180,\n",
    "neither height nor storeys": HEAD + "A,,,masonry,180,\n",
    "neither mass nor area": HEAD + "A,12,3,masonry,,\n",
    "a negative gap": HEAD + "A,12,3,masonry,180,-5\n",
    "a gap to nobody": HEAD + "A,12,3,masonry,180,20\n",
    "a name twice": HEAD + "A,12,3,masonry,9,\nA,12,3,masonry,9,\n",
    "walls changed": "name,storeys,floor mass [t],left wall [m],right wall [m]\nA,3,80,5,2\n",
    # By their walls C overlaps no other, and A, B and C are a row.
    "walls twice": "name,storeys,floor mass [t],left wall [m],right wall [m]\nA,3,80,0,9\nB,3,80,0,9\n",
    "walls of some": "name,storeys,floor mass [t],left wall [m],right wall [m]\n"
    "C,3,80,20.02,30\nA,3,80,0,10\nD,3,80,,\nB,3,80,10.03,20\n",
    "a gap that the walls contradict": "name,storeys,floor mass [t],left wall [m],right wall [m],gap [mm]\n"
    "A,3,80,0,9,20\nB,3,80,9.5,12,\n",
}


SQUARE = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]]


def feature(ring: list, name: str = "A", kind: str = "Polygon", **more: Any) -> dict[str, Any]:
    properties = {"name": name, "storeys": 3, **more}
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": ring}}


def shifted(along: float, across: float = 0.0) -> list[list[float]]:
    return [[x + along, y + across] for x, y in SQUARE]


GEOJSON_FAULTS = {
    "no JSON": "{",
    "a feature alone": '{"type": "Feature"}',
    "no feature": [],
    "no geometry": [{"type": "Feature", "properties": {}, "geometry": None}],
    "a point": [feature(SQUARE[0], kind="Point")],
    "three positions": [feature([SQUARE[:3]])],
    "an open ring": [feature([SQUARE[:4]])],
    "a word for a position": [feature([[*SQUARE[:2], "x", *SQUARE[3:]]])],
    "no area": [feature([[[0, 0], [1, 1], [2, 2], [0, 0]]])],
    "a ring that crosses itself": [feature([[[0, 0], [9, 9], [9, 0], [0, 8], [0, 0]]])],
    "a wall beside the footprint": [feature([SQUARE], **{"left wall [m]": 3})],
    "a height that is true": [feature([SQUARE], **{"height [m]": True})],
    "an overlap": [feature([SQUARE]), feature([shifted(8.0)], "B")],
    "a building twice": [feature([SQUARE]), feature([shifted(10.02)], "B"), feature([shifted(0.01)], "C")],
    "a gap that the walls contradict": [feature([SQUARE], **{"gap [mm]": 300}), feature([shifted(10.02)], "B")],
}


def in_degrees(size: float, *corners: tuple[float, float]) -> list[dict[str, Any]]:
    """Squares at some longitudes and latitudes, whose unit is a size in degrees."""
    return [
        feature([[[x * size + longitude, y * size + latitude] for x, y in SQUARE]], name)
        for (longitude, latitude), name in zip(corners, "AB", strict=False)
    ]


TAGS = [{"building": "yes", "height": "12,5", "building:levels": "2-3"}]
TAGS += [{"building": "yes", "height": "12", "building:levels": "NA"}]
PLACE_FAULTS = {  # features, whether they are in metres, more of the file
    "250 degrees east": ([feature([shifted(250.0)])], False, {}),
    "latitude first": (in_degrees(1e-5, (38.0, -122.0), (38.1, -122.0)), False, {}),
    "a system without a name": ([feature([shifted(250.0)])], False, {"crs": {"name": "EPSG:28992"}}),
    # A square of 10 degrees at 5 degrees north: sqrt(2) × 1110 km; and one of 1e-4 by 1e-4.
    "metres that look like degrees": ([feature([SQUARE])], False, {}),
    "degrees said to be metres": (in_degrees(1e-5, (8.0, 50.0)), True, {}),
    # Ten degrees apart on one meridian: 111.2 km each at 45 to 55 degrees north (WGS 84).
    "larger than a plane": (in_degrees(1e-5, (8.0, 45.0), (8.0, 55.0)), False, {}),
    # No unit of a height is guessed, except of OpenStreetMap.
    "a height without a unit": ([feature([SQUARE], height="12")], True, {}),
    "tags of OpenStreetMap": (
        [feature([shifted(10.02 * n)]) | {"properties": tags} for n, tags in enumerate(TAGS)],
        True,
        {},
    ),
}


@pytest.mark.parametrize("words", CSV_FAULTS)
def test_faults_of_a_table(folder, says, words):
    says(faults(folder, CSV_FAULTS[words]))


@pytest.mark.parametrize("words", GEOJSON_FAULTS)
def test_faults_of_footprints(folder, says, words):
    features = GEOJSON_FAULTS[words]
    says(faults(folder, features if isinstance(features, str) else collection(*features), JSON, metres=True))


@pytest.mark.parametrize("words", PLACE_FAULTS)
def test_faults_of_places_and_tags(folder, says, words):
    features, metres, more = PLACE_FAULTS[words]
    says(faults(folder, json.dumps(json.loads(collection(*features)) | more), JSON, metres=metres))


@pytest.mark.parametrize("name", ["street.txt", "none.csv", "nonsense.csv"])
def test_a_file_that_is_no_table_is_told(tmp_path, says, name):
    (tmp_path / "street.csv").write_text(HEAD, encoding="utf-8")
    (tmp_path / "nonsense.csv").write_bytes(b"\xff\xfe\x00")
    says(refusal(read_block, tmp_path / name))


@pytest.mark.parametrize("rules", [{"limit": 0.0}, {"typology": "brick"}, {"axis": 400.0}], ids=str)
def test_rules_out_of_range_are_refused(rules, says):
    says(refusal(Rules, **rules))


def tagged(folder: Path, *tags: dict[str, Any]) -> Block:
    """A street of houses 20 mm apart with these tags of OpenStreetMap, and no name."""
    features = [feature([shifted(10.02 * place)]) for place in range(len(tags))]
    for each, mine in zip(features, tags, strict=True):
        each["properties"] = mine
    return footprints_read(folder, *features)


def test_tags_of_openstreetmap_are_read(folder, says):
    """Its wiki on heights: metres unless a unit is there, feet and inches as 41'6". 41.5 × 0.3048 = 12.6492 m."""
    block = tagged(
        folder,
        {"building": "apartments", "height": "12", "building:levels": "4", "addr:street": "High Street", "source": "x"},
        {"building": "yes", "height": "12.5 m", "building:levels": 4},
        {"building": "house", "height": "41'6\"", "building:levels": "4"},
        {"building": "house", "height": "30 ft", "building:levels": None},
        {"building": "roof", "height": 3, "building:levels": "1"},
    )
    (row,) = block.rows
    assert [house.height for house in row.buildings] == pytest.approx([12.0, 12.5, 12.6492, 9.144, 3.0], rel=1e-12)
    assert [house.storeys for house in row.buildings] == [4, 4, 4, 3, 1]
    assert {house.typology for house in row.buildings} == {"masonry"}  # filled in, and listed so
    filled = [each.building for each in block.filled if each.column == "typology"]
    assert filled == [f"building {n}" for n in range(1, 6)]
    says(block.notes)


def layout(block: Block) -> Iterator[str]:
    """Rows with gaps and faced lengths, what stands alone or close, notes, and what the scenes say of it."""
    for row, file in zip(block.rows, block.file_names(), strict=True):
        gaps = [f" | {1e3 * pair.gap:.4g} mm, {pair.faced:.3g} m, {pair.share:.3g} | " for pair in row.pairs]
        names = "".join(house.name + gap for house, gap in zip(row.buildings, [*gaps, ""], strict=True))
        yield f"{row.name}, {row.direction:.4g} deg, {file}: {names}"
    for words, houses in (("alone", block.alone), ("in no row", block.in_no_row)):
        yield f"{words}: {', '.join(house.name for house in houses)}"
    yield from (f"close: {pair.words}, {pair.distance:.4g} m" for pair in block.close)
    yield from (f"filled: {each}" for each in block.filled if each.column == "gap")
    yield from (f"note: {note}" for note in block.notes)
    for scene in block.scenes(["RSN6-180"]).values():
        yield from (line for line in scene.splitlines() if line.startswith("#   "))


def facing(across: float) -> list[dict[str, Any]]:
    """Two squares of 10 m beside each other, one further back."""
    return [feature([SQUARE], "A"), feature([shifted(10.02, across)], "B")]


def rounded(decimals: int, size: float) -> list[dict[str, Any]]:
    """A square whose corners have so many decimals."""
    ring = [[round(each * size * 1.23456789, decimals) for each in corner] for corner in SQUARE]
    return [feature([ring], **{"floor mass [t]": 80})]


EAST = {"axis": 90.0}
BESIDES = [feature([SQUARE], "A"), feature([shifted(10.02, -4.6)], "B"), feature([shifted(10.02, 6.6)], "C")]
RING = {"A": [(0.0, 0.0), (10.0, 20.0)], "B": [(3.1, 0.0), (0.0, 10.0)], "C": [(3.1, 10.0), (6.9, 20.0)]}
QUAY = [feature([SQUARE], street="Quay"), feature([shifted(0.0, 10.03)], "N", street="Mill Lane")]
# At 50 degrees north, where 1e-5 degrees of latitude are 1.1122 m (WGS 84).
QUAY_IN_DEGREES = [
    feature([[[x * 1e-5 + 8.0, (y + north) * 1e-5 + 50.0] for x, y in SQUARE]], name, street=street)
    for north, name, street in ((0.0, "A", "Quay"), (10.03, "N", "Mill Lane"))
]
ELL = [[0, 0], [10, 0], [10, 10], [8, 10], [8, 2], [0, 2], [0, 0]]
MASSES, WALLS = (
    "street,name,storeys,floor mass [t],gap [mm]\n",
    "name,storeys,floor mass [t],left wall [m],right wall [m]\n",
)
LIMITS = "name,storeys,floor mass [t],gap [m]\nA,3,80,0.99\nB,3,80,1\nC,3,80,0\nD,3,80,\n"
ODD = "name,owner,storeys,height [m],floor mass [t],floor area [m^2],note\nA,city,9,12,80,100,\nB,city,3,9,80,,seen\n"
SIDES = (("north", 0.0), ("south", -24.0))
STREET_NAMES = ("Main St", "Main St.", "Main St 2")
LIKE_NAMES = MASSES.replace(",gap [mm]", "") + "".join(
    f"{name},{name} {n},3,80\n" for name in STREET_NAMES for n in "ab"
)
HOUSE_NUMBERS = f"# a street, made, for this\n{HEAD}"
HOUSE_NUMBERS += '"#1",9,3,,80,20\n#2,9,3,,80,\n# no house\n#3,9,3,,80,30\nB,9,3,,80,\n'


def box(name: str, left: float, right: float, depth: float) -> dict[str, Any]:
    """A footprint on the front line of a street that runs east."""
    return feature([[(left, 0.0), (right, 0.0), (right, depth), (left, depth), (left, 0.0)]], name)


PLACED: dict[str, tuple[Any, dict[str, Any]]] = {
    "the corner of a street": (  # sqrt(20² + 30²) mm from corner to corner
        [feature([shifted(10.02 * n)], f"{n}") for n in range(3)]
        + [feature([shifted(20.04, 10.03 * n)], f"leg {n}") for n in (1, 2)],
        EAST,
    ),
    "two neighbours on one side": (BESIDES, EAST),  # 5.4 m of B's front face A and 3.4 m of C's
    "two neighbours in another order": (BESIDES[::-1], EAST),
    "a ring of buildings": (  # A is left of B, B of C, and C of A; parts of 3 m along and 1 m across
        [
            feature([[[[x * 0.3 + u, y * 0.1 + v] for x, y in SQUARE]] for u, v in corners], name, "MultiPolygon")
            for name, corners in RING.items()
        ],
        EAST,
    ),
    "buildings of two streets": (QUAY, {}),
    "buildings of two streets in degrees": (QUAY_IN_DEGREES, {"metres": False}),
    "a house in the corner of another": (
        [feature([ELL], "L"), feature([[[x * 0.5 + 2.0, y * 0.5 + 2.5] for x, y in SQUARE]], "yard")],
        EAST,
    ),
    **{f"facing over {10 - across:.2g} m": (facing(across), EAST) for across in (9.7, 5.2, 4.9)},
    "facing over too little": (facing(5.2), EAST | {"least_facing": 0.49}),
    **{f"a street to {axis:g} degrees": (facing(0.0), {"axis": axis}) for axis in (90.0, 270.0, 0.0)},
    "streets in a column": (MASSES + "A,1,3,90,20\nB,1,2,80,10\nA,2,4,95,\nB,2,2,80,\n", {}),
    "streets of like names": (MASSES + "A b,1,3,90,20\nA b,2,4,95,\na-B,1,2,80,10\na-B,2,2,80,\n", {}),
    "a gap of the limit": (LIMITS, {}),
    "a gap above the limit": (LIMITS, {"limit": 0.5}),
    "walls that overlap within the survey": (WALLS + "A,3,80,0,10.06\nB,3,80,10,20\n", {}),
    "columns that are not read, odd heights": (ODD, {}),
    # A degree of latitude is 111.2 km: six decimals are 0.11 m, eight 1.1 mm.
    **{f"{decimals} decimals of degrees": (rounded(decimals, 1e-5), {"metres": False}) for decimals in (6, 8)},
    **{f"{decimals} decimals of metres": (rounded(decimals, 1.0), {}) for decimals in (2, 3)},
    "both sides of a street of 14 m": (  # none faces anybody across it
        [feature([shifted(10.02 * n, across)], f"{side} {n}") for n in range(3) for side, across in SIDES],
        {},
    ),
    "a thinner building between two": (  # 9.5 m of the fronts of 10 m are behind it
        [box("A", 0.0, 10.0, 10.0), box("B", 10.1, 14.1, 9.5), box("C", 14.2, 24.0, 10.0)],
        {"limit": 6.0},
    ),
    "a staircase of nine": (  # each beside the last 30 % of the one before
        [feature([shifted(10.1 * n, 7.0 * n)], f"{n}") for n in range(9)],
        EAST,
    ),
    "names that are one as a file's": (LIKE_NAMES, {}),  # a number behind two of them may make the third
    "a house number read as a comment": (HOUSE_NUMBERS, {}),  # what starts with #, unless it is in quotes
}


@pytest.mark.parametrize("words", PLACED)
def test_rows_and_what_is_told_of_them(folder, says, words):
    given, rules = PLACED[words]
    block = read(folder, given, **rules) if isinstance(given, str) else footprints_read(folder, *given, **rules)
    says(list(layout(block)))


@pytest.fixture(scope="module")
def shipped() -> tuple[Block, Block]:
    return read_block(STREETS / "street.csv"), read_block(STREETS / JSON)


def test_the_shipped_street_is_thirty_buildings_in_three_rows(shipped):
    table, prints = shipped
    assert [len(row.buildings) for row in table.rows] == [11, 12, 6]
    assert [house.name for house in table.alone] == ["47"]
    assert table.notes == ()
    columns = [each.column for each in table.filled]
    missing = {"height": 3, "storeys": 2, "typology": 2, "floor load": 8, "gap": 2}
    missing |= {"damping": 30, "floor mass": 30, "floor depth": 30}
    missing |= {"period": 30, "storey stiffness": 30, "storey strengths": 30}
    assert {name: columns.count(name) for name in set(columns)} == missing
    (part,) = prints.rows
    assert (part.buildings[0].name, part.buildings[-1].name) == ("23", "45")
    # Areas in the table have one decimal, of 94 m² or more.
    for mine, theirs in zip(table.rows[1].buildings, part.buildings, strict=True):
        assert mine[:5] == theirs[:5]
        assert mine.floor_mass == pytest.approx(theirs.floor_mass, rel=6e-4)
    # Coordinates of 1e-10 degrees are 0.01 mm, gaps 0.1 mm.
    assert part.gaps == pytest.approx(table.rows[1].gaps, abs=1.01e-4)
    assert part.direction == pytest.approx(57.0, abs=1e-3)
    assert [each.column for each in prints.filled if each.column == "gap"] == []
    assert "made street" in (STREETS / "street.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert "made street" in (STREETS / JSON).read_text(encoding="utf-8")


def test_scenes_hold_every_value_of_their_rows(shipped):
    """TOML that the standard library reads, with the very numbers; records that the catalogue knows."""
    for block in shipped:
        for row, text in zip(block.rows, block.scenes().values(), strict=True):
            scene = tomllib.loads(text)
            for house, table in zip(row.buildings, scene["building"], strict=True):
                facts = house.name, house.storeys, house.typology
                assert (table["name"], table["storeys"], table["typology"]) == facts
                assert quantities.parse(table["height"], quantities.GAP) == house.height
                assert quantities.parse(table["floor_mass"], quantities.MASS) == house.floor_mass
                assert table["damping"] == house.damping
                assert quantities.parse(table["floor_depth"], quantities.GAP) == house.floor_depth == 0.25
            gaps = [quantities.parse(table["gap"], quantities.GAP) for table in scene["interface"]]
            assert tuple(gaps) == row.gaps
            assert all(entry(name).horizontal for name in scene["records"]["names"])
            assert f"# {len(row.buildings)} buildings of {block.source}" in text


def assert_read(block: Block) -> None:
    """Every scene of a block is read as a row of its buildings and gaps."""
    for row, (name, text) in zip(block.rows, block.scenes(["RSN6-180"]).items(), strict=True):
        study = parse_scene(text, source=name)
        assert study.is_row
        assert [each.name for each in study.buildings] == [house.name for house in row.buildings]
        assert tuple(each.gap for each in study.interfaces) == row.gaps
        for house, built in zip(row.buildings, study.buildings, strict=True):
            assert built.masses == (house.floor_mass,) * house.storeys
            assert built.height == pytest.approx(house.height, rel=1e-12)  # a sum of storeys
            # The period of the chain, an eigenvalue, is the typology's formula C_t h^x.
            code = TYPOLOGIES[house.typology].code
            assert built.period == pytest.approx(code.coefficient * house.height**code.exponent, rel=1e-9)
        for (left, right), neighbour in zip(pairwise(row.buildings), study.interfaces, strict=True):
            highest = max(point.level for point in neighbour.points)
            assert highest == pytest.approx(min(left.height, right.height), abs=0.125 + 1e-9)
            # Two roofs that overlap meet half-way: within half of a floor's 250 mm.


def test_every_scene_of_the_shipped_street_is_read(shipped):
    for block in shipped:
        assert_read(block)


@examples(25, streets())
@pytest.mark.complete
def test_every_scene_of_a_street_is_read(folder, street):
    assert_read(read(folder, as_csv(street)))


def test_the_stiffness_of_a_street_is_one_that_advise_keeps(shipped):
    table, _ = shipped
    scenes = [parse_scene(text) for text in table.scenes(["RSN6-180"]).values()]
    assert len(scenes) == 3
    assert not [note for study in scenes for note in of_input(study, ()) if "a contact at" in note]


def test_sections_of_a_scene_can_be_given(shipped):
    table, _ = shipped
    more = {"records": {"pga": "0.3 g"}, "grid": {"pga": ["0.2 g"]}, "effects": {"p_delta": {}}}
    contact = block_scenes.CONCRETE._replace(yield_force="2 MN", stiffness=None)
    scene = tomllib.loads(table.scenes(["RSN6-180"], contact=contact, tables=more)["street-row-1.toml"])
    assert scene["records"] == {"names": ["RSN6-180"], "polarity": ["as recorded", "reversed"], "pga": "0.3 g"}
    assert scene["grid"] == {"pga": ["0.2 g"]} and scene["effects"] == {"p_delta": {}}
    known = {"gap": "0 mm", "contact_model": "jankowski", "restitution": 0.65, "yield_force": "2 MN"}
    assert scene["interface"][0] == known
    other = tomllib.loads(table.scenes(tables={"records": {"set": "fema-p695-farfield"}})["street-row-1.toml"])
    assert other["records"] == {"polarity": ["as recorded", "reversed"], "set": "fema-p695-farfield"}
    words = '"building" cannot be given; it may be effects, records, grid, uncertain, solver'
    with pytest.raises(PoundingError, match=words):
        table.scenes(tables={"building": []})


@given(st.floats(1e-3, 1e3))
def test_what_is_written_is_read_back_to_the_bit(value):
    for quantity in (quantities.GAP, quantities.MASS, quantities.PERIOD):
        assert quantities.parse(block_scenes.written(value, quantity), quantity) == value


def test_the_command_writes_what_the_call_returns(tmp_path):
    out = tmp_path / "scenes"
    told = commands.done("block", STREETS / "street.csv", "-o", out, "--pga", "0.3 g")
    scenes = [f"street-row-{n}.toml" for n in (1, 2, 3)]
    assert sorted(each.name for each in out.iterdir()) == ["buildings.csv", "filled.csv", "neighbours.csv", *scenes]
    assert "alone, no neighbour within 1 m along the street: 47" in told.output
    assert re.search(r"street, row 2 +12 +2 to 9 +0 mm to 100 mm +23, 25", told.output)
    block = pr.block(STREETS / "street.csv", tmp_path / "again", tables={"records": {"pga": "0.3 g"}})
    texts = block.scenes(tables={"records": {"pga": "0.3 g"}})
    assert {name: (out / name).read_text(encoding="utf-8") for name in block.file_names()} == texts
    for name in ("buildings.csv", "filled.csv", "neighbours.csv", *block.file_names()):
        assert (out / name).read_bytes() == (tmp_path / "again" / name).read_bytes()
    (out / "old.toml").touch()
    told = commands.run("block", STREETS / "street.csv", "-o", out, "--pga", "0.3 g")
    assert f"note: old.toml in {out}: not of this street" in told.output


def test_a_faulty_table_ends_with_status_2_and_writes_nothing(tmp_path, says):
    (tmp_path / "bad.csv").write_text(HEAD + "A,x,3,masonry,180,\n", encoding="utf-8")
    out = tmp_path / "scenes"
    street = str(STREETS / "street.csv")
    options = ["--record RSN6", "--floor-load 10kN", "--stiffness 10kN/m", "--contact-model hertzian"]
    options += ["--contact-model stereomechanical", "--restitution 2", "--tolerance 5", "--metres"]
    options += ["--record my/a.V2A", "--code-level low", "--typology brick"]
    for words in ([str(tmp_path / "bad.csv")], *([street, *option.split()] for option in options)):
        told = commands.refused("block", *words, "-o", out)
        assert not out.exists()
        says(" ".join(told.split()).replace(str(STREETS), "SHIPPED"))
    with pytest.raises(SceneError, match="yield_force"):
        pr.block(STREETS / "street.csv", out, contact=block_scenes.Contact(yield_force="2"))
    assert not out.exists()


def test_of_many_scenes_the_first_are_named(tmp_path, monkeypatch):
    monkeypatch.setattr("pounding_risk.cli.block.LISTED", 2)
    told = commands.run("block", str(STREETS / "street.csv"), "-o", tmp_path)
    said = [
        line.removeprefix(f"written: {tmp_path}/") for line in told.output.splitlines() if line.startswith("written")
    ]
    assert said == ["street-row-1.toml", "street-row-2.toml", "filled.csv", "neighbours.csv", "buildings.csv"]
    assert told.output.rstrip().endswith("and 1 more scene, the last of them street-row-3.toml")
    assert len(list(tmp_path.glob("*.toml"))) == 3


def test_gaps_and_floors_of_a_table_with_walls_are_told(tmp_path):
    """Storeys of 10 ft, whose levels differ by less than 1e-12 m in a float, and walls 20 mm apart."""
    head = "name,height [ft],storeys,floor mass [t],left wall [m],right wall [m]\n"
    (tmp_path / "ft.csv").write_text(f"{head}A,40,4,80,0,10\nB,50,5,80,10.02,20\n", encoding="utf-8")
    told = commands.run("block", tmp_path / "ft.csv", "-o", tmp_path / "out").stdout
    assert "distances of its walls" in told and "µm" not in told
    with (tmp_path / "out" / "neighbours.csv").open(newline="") as file:
        (pair,) = csv.DictReader(file)
    assert (pair["clear distance [m]"], pair["largest offset of floors [m]"]) == ("0.02", "0")


def test_the_tolerance_of_the_scenes_is_that_of_the_floors_told(tmp_path):
    """Storeys of 3 m and 3.5 m: the first floors meet within 0.6 m, and not by a depth of 0.25 m."""
    table = tmp_path / "street.csv"
    table.write_text("name,height [m],storeys,floor area [m^2]\nA,9,3,80\nB,10.5,3,80\n", encoding="utf-8")
    told = commands.run("block", table, "-o", tmp_path / "out", "--tolerance", "0.6 m")
    (pair,) = csv.DictReader((tmp_path / "out" / "neighbours.csv").read_text(encoding="utf-8").splitlines())
    assert (pair["floors that meet"], pair["floors that miss"]) == ("1", "3")
    assert re.search(r"A +B +0 mm +not known +1 +3 +1.5 m", told.output)


def test_walls_that_overlap_leave_what_their_resolution_does(tmp_path):
    """0.3 m of overlap known to 0.5 m: a gap of 0.2 m at most; of 0.5 m there is none left."""
    text = WALLS + "A,3,80,0,10.3\nB,3,80,10,20.5\nC,3,80,20,30\nD,3,80,30.6,40\n"
    (row,) = read(tmp_path, text, resolution=0.5, limit=2.0).rows
    assert [pair.gaps for pair in row.pairs] == [(0.0, 0.2), (0.0, 0.0), (0.1, 1.1)]
    assert row.gaps == (0.0, 0.0, 0.6)


def test_a_resolution_of_walls_that_no_building_has_is_told_to_change_nothing(tmp_path):
    block = read(tmp_path, HEAD + "A,9,3,,80,20\nB,9,3,,80,\n", resolution=0.5)
    assert block.rows[0].pairs[0].gaps == (0.02, 0.02)
    assert "--resolution changes none" in block.gap_words and "uniform" not in block.gap_words


@pytest.mark.parametrize("error", [PoundingError, OSError, KeyboardInterrupt])
def test_an_error_leaves_no_new_folder_behind(tmp_path, monkeypatch, error):
    def fails(text: str, source: str) -> None:
        raise error("no scene")

    monkeypatch.setattr(block_rows, "parse_scene", fails)
    (tmp_path / "kept").mkdir()
    for folder in (tmp_path / "new" / "deeper", tmp_path / "kept"):
        with pytest.raises(error):
            block_rows.write_block(read_block(STREETS / "street.csv"), folder)
    assert [path.name for path in tmp_path.rglob("*")] == ["kept"]


def test_a_file_that_cannot_be_written_leaves_no_other_behind(tmp_path):
    """The scenes were in place when the table of the buildings, the last one, failed."""
    partial_of(tmp_path / "buildings.csv").mkdir()
    with pytest.raises(PoundingError, match=r"buildings.csv: cannot be written"):
        block_rows.write_block(read_block(STREETS / "street.csv"), tmp_path)
    assert [path.name for path in tmp_path.iterdir() if not path.name.startswith(".")] == []
