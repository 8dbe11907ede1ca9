"""Streets as rows: a table and its footprints agree, gaps are the distances, what is missing is filled and told."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk import units as quantities
from pounding_risk.cli import app
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.motions.catalogue import entry
from pounding_risk.scene.reader import parse_scene
from pounding_risk.streets import scenes as block_scenes
from pounding_risk.streets.defaults import Rules
from pounding_risk.streets.rows import Block, read_block
from pounding_risk.streets.table import BlockError

STREETS = Path(pr.__file__).resolve().parent / "scene" / "shipped"
HEAD = "name,height [m],storeys,typology,floor area [m^2],gap [mm]\n"
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
        assert [house.floor_mass for house in mine.buildings] == pytest.approx(
            [house.floor_mass for house in theirs.buildings], rel=1e-3
        )


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("streets")


@settings(max_examples=50)
@given(streets(), st.floats(-3.14, 3.14))
def test_a_table_and_the_footprints_of_a_street_are_the_same_rows(folder, street, turn):
    """However the footprints are turned; in metres, and in degrees near the equator, where 1e-5 degrees are 1.1 m."""
    table = read(folder, as_csv(street))
    assert_alike(table, read(folder, as_geojson(street, turn), "street.geojson", metres=True))
    walls = [(each["left wall [m]"], each["right wall [m]"]) for each in street]
    gaps = [after[0] - before[1] for before, after in pairwise(walls)]
    assert sorted(gap for row in table.rows for gap in row.gaps) == pytest.approx(sorted(g for g in gaps if g < 1.0))


@settings(max_examples=50)
@given(streets(), st.floats(-3.14, 3.14))
def test_degrees_are_as_good_as_metres(folder, street, turn):
    """At the equator, by 110.574 km a degree north and 111.320 km east, the ellipsoid's own (Snyder 1987, table 3)."""
    scale = (1.0 / 111.320e3, 1.0 / 110.574e3)
    metres = read(folder, as_geojson(street, turn), "street.geojson", metres=True)
    degrees = read(folder, as_geojson(street, turn, scale), "street.geojson")
    assert outline(metres) == outline(degrees)
    for mine, theirs in zip(metres.rows, degrees.rows, strict=True):
        assert mine.gaps == pytest.approx(theirs.gaps, abs=2e-4)


@settings(max_examples=50)
@given(streets())
def test_a_mirrored_street_is_the_mirrored_rows(folder, street):
    """Walls seen from behind reverse the rows, as do footprints listed the other way; footprints turned over do not."""
    rows = read(folder, as_csv(street)).rows
    behind = [
        {**each, "left wall [m]": -each["right wall [m]"], "right wall [m]": -each["left wall [m]"]} for each in street
    ]
    mirrored = read(folder, as_csv(behind)).rows[::-1]
    listed = read(folder, as_geojson(street[::-1]), "street.geojson", metres=True).rows[::-1]
    for reverse in (mirrored, listed):
        assert [[house.name for house in row.buildings] for row in rows] == [
            [house.name for house in row.buildings[::-1]]
            for row in sorted(reverse, key=lambda row: row.buildings[-1].name)
        ]
    turned_over = read(folder, as_geojson(street, mirror=True), "street.geojson", metres=True)
    assert_alike(read(folder, as_geojson(street), "street.geojson", metres=True), turned_over)


def test_both_sides_of_a_street_are_rows_of_their_own(folder):
    """Buildings across a street of 14 m face nobody but their neighbours."""
    one = [{"name": f"{n}", "height [m]": 9, "storeys": 3, "typology": "masonry", "depth": 12.0} for n in range(6)]
    for n, each in enumerate(one):
        each["left wall [m]"], each["right wall [m]"] = 10.02 * (n // 2), 10.02 * (n // 2) + 10.0
    whole = json.loads(as_geojson(one))
    for n, feature in enumerate(whole["features"]):
        for corner in feature["geometry"]["coordinates"][0][:]:
            corner[1] = -14.0 - corner[1] if n % 2 else corner[1]
    block = read(folder, json.dumps(whole), "street.geojson", metres=True)
    assert [[house.name for house in row.buildings] for row in block.rows] == [["0", "2", "4"], ["1", "3", "5"]]
    assert [row.gaps for row in block.rows] == [(0.02, 0.02)] * 2
    assert [row.name for row in block.rows] == ["street, row 1", "street, row 2"]
    assert {round(row.direction, 6) for row in block.rows} == {90.0}  # east


def test_streets_of_one_file_keep_their_places(folder):
    """Two squares on one meridian, a hundredth of a degree apart: 111.229 km a degree at 50 degrees north (WGS 84)."""
    size = 1e-4
    rings = [[[x * size / 10 + 8.0, y * size / 10 + 50.0 + street / 100] for x, y in SQUARE] for street in (0, 1)]
    features = [feature([ring], street=f"{street}", **{"floor mass [t]": 80}) for street, ring in enumerate(rings)]
    block = read(folder, collection(*features), "street.geojson")
    one, other = (np.array(house.footprint.exterior.coords[0]) for house in block.alone)
    assert other - one == pytest.approx([0.0, 1112.29], abs=0.1)


def test_streets_of_one_file_are_told_apart(folder):
    text = "street,name,storeys,floor mass [t],gap [mm]\nA,1,3,90,20\nB,1,2,80,10\nA,2,4,95,\nB,2,2,80,\n"
    block = read(folder, text)
    assert [(row.name, row.gaps) for row in block.rows] == [("A", (0.02,)), ("B", (0.01,))]
    assert list(block.scenes(["RSN6-180"])) == ["a.toml", "b.toml"]
    assert {each.street for each in block.filled} == {"A", "B"}


def test_what_is_missing_is_filled_by_rule_and_told(folder):
    text = HEAD + "A,12.5,,masonry,180,20\n,,4,,200,\nC,9,3,steel_frame,150,\n"
    block = read(folder, text, gap=0.03, floor_load=8e3)
    ((row,), filled) = (block.rows, [each[1:] for each in block.filled])
    assert [house.name for house in row.buildings] == ["A", "building 2", "C"]
    assert [(house.height, house.storeys) for house in row.buildings] == [(12.5, 4), (12.0, 4), (9.0, 3)]
    assert row.gaps == (0.02, 0.03)
    # 8 kN/m² × 180 m² / 9.80665 m/s²
    assert row.buildings[0].floor_mass == pytest.approx(146839.0, abs=1.0)
    assert [each for each in filled if each[1] not in ("damping", "floor depth", "floor load", "floor mass")] == [
        ("A", "storeys", "4", "its height at 3 m a storey"),
        ("building 2", "name", "building 2", "its place in the file"),
        ("building 2", "height", "12 m", "its storeys at 3 m each"),
        ("building 2", "typology", "masonry", "stated for buildings without one"),
        ("building 2", "gap", "30 mm", "stated for neighbours without one"),
    ]
    for column in ("damping", "floor depth", "floor load", "floor mass"):
        assert len([each for each in filled if each[1] == column]) == 3
    assert next(csv.reader(block_scenes.filled_csv(block.filled).splitlines()[1:])) == list(block.filled[0])


def test_a_value_that_is_given_is_never_filled(folder):
    text = (
        "name,height [ft],storeys,typology,period [ms],damping [%],floor mass [t],floor depth [mm],gap\n"
        "A,30,3,masonry,310,4,80,220,12 mm\nB,30,3,Concrete frame,,4,80,300,\n"
    )
    block = read(folder, text)
    first, second = block.rows[0].buildings
    assert (first.height, first.period, first.damping, first.floor_mass) == (9.144, 0.31, 0.04, 80e3)
    assert (first.floor_depth, second.floor_depth) == (0.22, 0.3)
    assert block.rows[0].gaps == (0.012,) and second.period is None
    assert (first.typology, second.typology) == ("masonry", "concrete_frame")
    assert block.filled == ()


def test_walls_that_overlap_within_the_survey_touch(folder):
    text = "name,storeys,floor mass [t],left wall [m],right wall [m]\nA,3,80,0,10.06\nB,3,80,10,20\n"
    block = read(folder, text)
    assert block.rows[0].gaps == (0.0,)
    told = [each for each in block.filled if each.column == "gap"]
    assert [(each.building, each.value, each.rule) for each in told] == [
        ("A", "0 mm", "the walls overlap by 60 mm, within the survey's 100 mm")
    ]
    (fault,) = faults(folder, text, survey=0.05)
    assert "line 2, A and line 3, B: overlap by 60 mm along the street, 50 mm are allowed" in fault


def collection(*features: dict[str, Any]) -> str:
    return json.dumps({"type": "FeatureCollection", "features": list(features)})


def footprints_read(folder: Path, *features: dict[str, Any], **rules: Any) -> Block:
    return read(folder, collection(*features), "street.geojson", metres=True, **rules)


def close_words(block: Block) -> list[str]:
    return [pair.words for pair in block.close]


def test_a_building_behind_another_is_not_alone(folder):
    """30 mm clear across the axis of the street, told on every way out; one 3 m behind is alone."""
    front = [feature([SQUARE], "1"), feature([shifted(10.02)], "2")]
    block = footprints_read(
        folder, *front, feature([shifted(1.0, 10.03)], "yard"), feature([shifted(0.0, -13.0)], "far"), axis=90.0
    )
    assert [[house.name for house in row.buildings] for row in block.rows] == [["1", "2"]]
    assert [house.name for house in block.in_no_row] == ["yard", "far"]
    assert [house.name for house in block.alone] == ["far"]
    told = [
        "1 and yard: 30 mm clear, across the axis of the street",
        "2 and yard: 30 mm clear, across the axis of the street",
    ]
    assert close_words(block) == told
    (scene,) = block.scenes(["RSN6-180"]).values()
    assert (
        f"# Close to a building of this row, and not in it as its neighbour:\n#   {told[0]}\n#   {told[1]}\n" in scene
    )
    path = folder / "street.geojson"
    shown = CliRunner().invoke(app, ["block", str(path), "--metres", "--axis", "90 deg", "-o", str(folder / "out")])
    assert shown.exit_code == 0, shown.output
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


def test_a_street_with_a_corner_tells_the_pairs_of_its_other_leg(folder):
    leg = [feature([shifted(20.04, 10.03 * n)], f"leg {n}") for n in (1, 2)]
    block = footprints_read(folder, *(feature([shifted(10.02 * n)], f"{n}") for n in range(3)), *leg, axis=90.0)
    assert [[house.name for house in row.buildings] for row in block.rows] == [["0", "1", "2"]]
    assert block.alone == ()
    assert close_words(block) == [
        "1 and leg 1: 36.1 mm clear, corner to corner",  # sqrt(20² + 30²) mm
        "2 and leg 1: 30 mm clear, across the axis of the street",
        "leg 1 and leg 2: 30 mm clear, across the axis of the street",
    ]


def test_a_second_neighbour_on_one_side_is_told_and_the_longer_front_makes_the_row(folder):
    """5.4 m of B's front face A and 3.4 m of C's."""
    features = [feature([SQUARE], "A"), feature([shifted(10.02, -4.6)], "B"), feature([shifted(10.02, 6.6)], "C")]
    for order in (features, features[::-1]):
        block = footprints_read(folder, *order, axis=90.0)
        assert [[house.name for house in row.buildings] for row in block.rows] == [["A", "B"]]
        ((pair),) = block.rows[0].pairs
        assert (pair.faced, pair.share) == pytest.approx((5.4, 0.54))
        (other,) = block.close
        assert {other.one.name, other.other.name} == {"A", "C"}
        assert (other.distance, other.reason) == (0.02, "A has B as its neighbour on that side")


def test_buildings_that_face_each_other_in_a_ring_are_a_line_and_a_pair(folder):
    """A is left of B, B of C, and C of A: of such a ring no building may be lost."""
    parts = {"A": ((0.0, 0.0), (10.0, 20.0)), "B": ((3.1, 0.0), (0.0, 10.0)), "C": ((3.1, 10.0), (6.9, 20.0))}
    features = []
    for name, corners in parts.items():
        rings = [[[[x * 0.3 + u, y * 0.1 + v] for x, y in SQUARE]] for u, v in corners]  # 3 m along, 1 m across
        features.append(feature(rings, name, kind="MultiPolygon"))
    block = footprints_read(folder, *features, axis=90.0)
    assert [[house.name for house in row.buildings] for row in block.rows] == [["C", "A", "B"]]
    assert close_words(block) == ["B and C: 100 mm clear, in a ring of buildings, which is no line"]


def test_buildings_of_two_streets_are_close_all_the_same(folder):
    """In metres and in degrees, where 1e-5 degrees of latitude are 1.1122 m at 50 degrees north (WGS 84)."""
    north = [feature([shifted(0.0, 10.03)], "N", street="Mill Lane")]
    block = footprints_read(folder, feature([SQUARE], street="Quay"), *north)
    assert close_words(block) == ["A (Quay) and N (Mill Lane): 30 mm clear, in two streets"]
    assert block.alone == () and len(block.in_no_row) == 2
    features = [feature([SQUARE], street="Quay"), *north]
    for each in features:
        each["geometry"]["coordinates"] = [
            [[x * 1e-5 + 8.0, y * 1e-5 + 50.0] for x, y in each["geometry"]["coordinates"][0]]
        ]
    (pair,) = read(folder, collection(*features), "street.geojson").close
    assert pair.distance == pytest.approx(0.03 * 1.1122, abs=1e-4)  # rounded to 0.1 mm


def test_what_lies_in_another_but_overlaps_nothing_is_no_overlap(folder):
    """An L holds a small house in its corner: along the street their extents overlap, the walls do not."""
    ell = [[0, 0], [10, 0], [10, 10], [8, 10], [8, 2], [0, 2], [0, 0]]
    features = [feature([ell], "L"), feature([[[x * 0.5 + 2.0, y * 0.5 + 2.5] for x, y in SQUARE]], "yard")]
    block = footprints_read(folder, *features, axis=90.0)
    assert [row.gaps for row in block.rows] == [(1.0,)] if block.rows else True
    assert all("overlap" not in note for note in block.notes) and block.alone == ()


@pytest.mark.parametrize(("across", "length", "share"), [(9.7, "300 mm", "3 %"), (5.2, "4.8 m", "48 %"), (4.9, "", "")])
def test_neighbours_that_face_each_other_over_a_part_are_noted(folder, across, length, share):
    """Below half of the shorter front: on the terminal, in the scene and in neighbours.csv; and parted by a rule."""
    features = [feature([SQUARE], "A"), feature([shifted(10.02, across)], "B")]
    block = footprints_read(folder, *features, axis=90.0)
    notes = [note for note in block.notes if "face each other" in note]
    (scene,) = block.scenes(["RSN6-180"]).values()
    if not length:
        assert notes == [] and "face each other" not in scene
        return
    assert notes[0].startswith(f"A and B face each other over {length} of a front of 10 m ({share}): taken as full")
    assert f"#   A | B: face each other over {length} of a front of 10 m ({share})\n" in scene
    parted = footprints_read(folder, *features, axis=90.0, least_facing=0.49)
    assert parted.rows == () and close_words(parted) == [
        f"A and B: 20 mm clear, facing each other over {length} only ({share})"
    ]


def test_no_row_ends_with_status_2_and_the_reason(folder, tmp_path):
    (tmp_path / "wide.csv").write_text("name,storeys,floor mass [t],gap [m]\nA,3,80,2\nB,3,80,\n", encoding="utf-8")
    (tmp_path / "behind.geojson").write_text(
        collection(feature([SQUARE]), feature([shifted(0.0, 10.03)], "B")), "utf-8"
    )
    for words, reason in (
        (["wide.csv"], "no row: no two buildings stand within 1 m of each other along the street; check the walls"),
        (
            ["behind.geojson", "--metres", "--axis", "90 deg"],
            "as neighbours, though 1 pair stands so close, such as A and B: 30 mm clear, across the axis of the "
            "street; state another direction of the street (--axis)",
        ),
    ):
        out = tmp_path / "out"
        told = CliRunner().invoke(app, ["block", str(tmp_path / words[0]), *words[1:], "-o", str(out)])
        assert told.exit_code == 2 and not out.exists()
        assert reason in " ".join(told.stderr.split())
        assert "A" in told.stdout  # the table of what stands alone, or close, comes first
    with pytest.raises(BlockError, match="no row"):
        pr.block(tmp_path / "wide.csv", tmp_path / "out")


def test_a_gap_of_the_limit_parts_rows(folder):
    text = "name,storeys,floor mass [t],gap [m]\nA,3,80,0.99\nB,3,80,1\nC,3,80,0\nD,3,80,\n"
    block = read(folder, text)
    assert [row.gaps for row in block.rows] == [(0.99,), (0.0,)]
    assert [house.name for house in read(folder, text, limit=0.5).alone] == ["A", "B"]


def test_what_is_not_read_and_what_is_odd_is_noted(folder):
    text = (
        "name,owner,storeys,height [m],floor mass [t],floor area [m^2],note\nA,city,9,12,80,100,\nB,city,3,9,80,,seen\n"
    )
    assert read(folder, text).notes == (
        'line 1: "owner", "note" are not read',
        "line 2, A: 9 storeys in 12 m are 1.3 m each; check both, and the unit of the height",
        "line 2, A: its floor area is not used, as its floor mass is given",
    )


CSV_FAULTS = [
    ("name,height [m]\n", "has no building; write a head such as"),
    ("house,colour\nA,12\n", "line 1: names no two columns of a street"),
    ("name,hieght [m]\nA,12\n", 'line 1: "hieght [m]" is no column (did you mean "height"?); it may be name, street'),
    ("name,height [m],height [ft]\nA,12,30\n", 'line 1: "height [ft]" stands twice; leave one of the two out'),
    (HEAD + "A,x,3,masonry,180,\n", 'line 2, height: "x" is not a plain number, and the column\'s unit is m'),
    (HEAD + "A,12 m,3,masonry,180,\n", 'line 2, height: "12 m" is not a plain number'),
    (
        HEAD + "A,NA,3,masonry,180,\n",
        'line 2, height: "NA" is no value; leave it empty where it is not known, to be filled by rule',
    ),
    (HEAD + "A,12,3,n/a,180,\n", 'line 2, typology: "n/a" is no value; leave it empty where it is not known'),
    ("name,height,floor mass [t]\nA,12,80\n", 'line 2, height: "12" has no unit, and a height of a building needs one'),
    ("name,height [s],floor mass [t]\nA,12,80\n", 'line 2, height: "12 s" is a time, not a length'),
    (
        HEAD + "A,-12,3,masonry,180,\n",
        'line 2, height: "-12 m" is out of range: a height of a building must be greater',
    ),
    (HEAD + "A,12,3.5,masonry,180,\n", 'line 2, storeys: "3.5" is not a whole number of storeys'),
    (HEAD + "A,12,0,masonry,180,\n", 'line 2, storeys: "0" is out of range'),
    (HEAD + "A,12,3,masnry,180,\n", 'A, typology: "masnry" is not a typology (did you mean "masonry"?); it may be'),
    (HEAD + "A,55,14,masonry_ec8,180,\n", "line 2, A, typology: 55 m is higher than the 40 m that"),
    (HEAD + "A,12000,,masonry,180,\n", "line 2, A, height: 12000 m would be 4000 storeys of 3 m, 200 are the most"),
    (HEAD + "A,,,masonry,180,\n", "line 2, A: gives neither height nor storeys; write one of the two"),
    (HEAD + "A,12,3,masonry,,\n", "line 2, A: gives neither floor mass nor floor area; write one, or state an area"),
    (HEAD + "A,12,3,masonry,180,-5\n", 'line 2, gap: "-5 mm" is out of range'),
    (HEAD + "A,12,3,masonry,180,20\n", "A, gap: 20 mm is given, but no building stands on its right within 1 m; leave"),
    (HEAD + "A,12,3,masonry,9,\nA,12,3,masonry,9,\n", 'line 2, line 3: "A" is the name of each; tell them apart'),
    (
        "name,storeys,floor mass [t],left wall [m],right wall [m]\nA,3,80,5,2\n",
        "line 2, A, right wall: is not to the right of its left wall",
    ),
    (
        "name,storeys,floor mass [t],left wall [m],right wall [m],gap [mm]\nA,3,80,0,9,20\nB,3,80,9.5,12,\n",
        "line 2, A and line 3, B: the gap is given as 20 mm, but the walls are 500 mm apart; correct one of the two",
    ),
]


@pytest.mark.parametrize(("text", "told"), CSV_FAULTS)
def test_faults_of_a_table_are_told_with_their_line(folder, text, told):
    assert any(told in fault for fault in faults(folder, text)), faults(folder, text)


def test_all_faults_are_told_at_once(folder):
    text = HEAD + "A,x,3,masonry,180,\nB,12,3.5,masonry,180,\nC,12,3\n"
    assert [fault.partition(":")[0] for fault in faults(folder, text)] == [
        "line 2, height",
        "line 3, storeys",
        "line 4",
    ]
    text = HEAD + "A,,,masonry,180,\nB,12,3,brick,180,\nB,12,3,masonry,,\n"
    assert len(faults(folder, text)) == 4


SQUARE = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]]


def feature(ring: list, name: str = "A", kind: str = "Polygon", **more: Any) -> dict[str, Any]:
    properties = {"name": name, "storeys": 3, **more}
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": ring}}


def shifted(along: float, across: float = 0.0) -> list[list[float]]:
    return [[x + along, y + across] for x, y in SQUARE]


GEOJSON_FAULTS = [
    ("{", "is not JSON"),
    ('{"type": "Feature"}', "is no GeoJSON of footprints"),
    ([], "has no building"),
    ([{"type": "Feature", "properties": {}, "geometry": None}], "feature 1: has no geometry; a building needs its"),
    ([feature(SQUARE[0], kind="Point")], 'feature 1: has "Point"; a building needs its footprint'),
    ([feature([SQUARE[:3]])], "feature 1: a ring has fewer than four positions"),
    ([feature([SQUARE[:4]])], "feature 1: a ring does not end where it starts"),
    ([feature([[*SQUARE[:2], "x", *SQUARE[3:]]])], 'feature 1: "x" is not a position; write two numbers'),
    ([feature([[[0, 0], [1, 1], [2, 2], [0, 0]]])], "feature 1: a ring has no area"),
    ([feature([[[0, 0], [9, 9], [9, 0], [0, 8], [0, 0]]])], "feature 1: a ring crosses itself"),
    ([feature([SQUARE], **{"left wall [m]": 3})], "feature 1, left wall: the footprint says where the walls are"),
    ([feature([SQUARE], **{"height [m]": True})], "feature 1, height: true is neither text nor a number"),
    (
        [feature([SQUARE]), feature([shifted(8.0)], "B")],
        "feature 1, A and feature 2, B: overlap by 2 m along the street",
    ),
    (
        [feature([SQUARE], **{"gap [mm]": 300}), feature([shifted(10.02)], "B")],
        "the gap is given as 300 mm, but the walls are 20 mm apart",
    ),
]


@pytest.mark.parametrize(("features", "told"), GEOJSON_FAULTS)
def test_faults_of_footprints_are_told_with_their_feature(folder, features, told):
    text = features if isinstance(features, str) else collection(*features)
    found = faults(folder, text, "street.geojson", metres=True)
    assert any(told in fault for fault in found), found


def test_coordinates_that_are_not_degrees_are_refused(folder):
    collection = {"type": "FeatureCollection", "features": [feature([shifted(250.0)])]}
    (fault,) = faults(folder, json.dumps(collection), "street.geojson")
    assert fault.startswith("feature 1: [250, 0] is no longitude and latitude in degrees")
    (fault,) = faults(folder, json.dumps({**collection, "crs": {"name": "EPSG:28992"}}), "street.geojson")
    assert fault.startswith('crs: {name = "EPSG:28992"} is not longitude and latitude')
    assert "its coordinates are metres say so with --metres (metres=True in Python)" in fault
    (fault,) = faults(folder, json.dumps({**collection, "features": [feature([SQUARE])]}), "street.geojson")
    # A square of 10 degrees at 5 degrees north: sqrt(2) × 1110 km.
    assert fault == (
        "read as longitude and latitude, every footprint is 1.6e6 m across or more: the coordinates look like metres; "
        "say so with --metres (metres=True in Python)"
    )
    small = [[x * 1e-5 + 8.0, y * 1e-5 + 50.0] for x, y in SQUARE]
    (fault,) = faults(folder, json.dumps({**collection, "features": [feature([small])]}), "street.geojson", metres=True)
    # A square of 1e-4 by 1e-4.
    assert fault == (
        "read as metres, no footprint is more than 0.14 mm across: the coordinates look like longitude and latitude; "
        "leave out --metres (metres=True in Python)"
    )


def test_a_map_is_not_larger_than_a_plane_holds(folder):
    """Two squares on one meridian, ten degrees apart: 111.2 km each at 45 to 55 degrees north (WGS 84)."""
    rings = [[[x * 1e-5 + 8.0, y * 1e-5 + 45.0 + north] for x, y in SQUARE] for north in (0.0, 10.0)]
    features = [feature([ring], name) for ring, name in zip(rings, "AB", strict=True)]
    (fault,) = faults(folder, collection(*features), "street.geojson")
    assert "feature 1 to feature 2: their footprints lie 1.11e6 m apart, and one plane holds at most 5e5 m" in fault


def tagged(folder: Path, *tags: dict[str, Any], faulty: bool = False) -> Any:
    """A street of houses 20 mm apart with these tags of OpenStreetMap, and no name."""
    features = [feature([shifted(10.02 * place)]) for place in range(len(tags))]
    for each, mine in zip(features, tags, strict=True):
        each["properties"] = mine
    return (faults if faulty else read)(folder, collection(*features), "street.geojson", metres=True)


def test_tags_of_openstreetmap_are_read(folder):
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
    assert [each.building for each in block.filled if each.column == "typology"] == [
        f"building {n}" for n in range(1, 6)
    ]
    assert block.notes[:3] == (
        'properties: "addr:street", "source" are not read',
        "tags of OpenStreetMap: a height without a unit is in metres, building:levels are the storeys, and building is "
        "a use, from which no typology follows; give typology where it is known",
        'feature 5: its tag building is "roof"; leave it out where nothing with floors stands there',
    )


def test_tags_of_openstreetmap_that_cannot_be_read_are_told(folder):
    odd = {"building": "yes", "height": "12,5", "building:levels": "2-3"}
    found = tagged(folder, odd, {"building": "yes", "height": "12", "building:levels": "NA"}, faulty=True)
    assert [fault.partition(";")[0].partition(" and a")[0] for fault in found] == [
        'feature 1, height: "12,5" is not a number with a unit (write a decimal point, not a comma)',
        'feature 1, storeys: "2-3" has a unit, but a number of storeys is a plain number',
        'feature 2, storeys: "NA" is no value',
    ]
    # Elsewhere a height without a unit is refused: none is guessed.
    assert any("has no unit" in fault for fault in tagged(folder, {"height": "12", "storeys": 4}, faulty=True))


@pytest.mark.parametrize(
    ("decimals", "metres", "told"), [(6, False, "110 mm"), (8, False, ""), (2, True, "10 mm"), (3, True, "")]
)
def test_coordinates_too_coarse_for_gaps_are_noted(folder, decimals, metres, told):
    """A degree of latitude is 111.2 km: six decimals are 0.11 m, eight 1.1 mm."""
    size = 1.0 if metres else 1e-5
    corners = [[round(x * size * 1.23456789, decimals), round(y * size * 1.23456789, decimals)] for x, y in SQUARE]
    text = collection(feature([corners], **{"floor mass [t]": 80}))
    notes = read(folder, text, "street.geojson", metres=metres).notes
    assert [f"{told} on the ground" in note for note in notes] == ([True] if told else [])


@settings(max_examples=150)
@given(
    st.sampled_from(["street.csv", "street.geojson"]),
    st.floats(0.0, 1.0),
    st.integers(0, 12),
    st.sampled_from(["", "0", "-1", "1e400", "nan", "null", "[]", '"', ",", "\n", "\0", "12 m", "gap [mm]"]),
)
def test_a_damaged_file_is_read_or_refused_in_words(folder, name, place, taken, put):
    """Anything but a block, or sentences, would be a fault of the reader."""
    text = (STREETS / name).read_text(encoding="utf-8")
    start = int(place * len(text))
    try:
        block = read(folder, text[:start] + put + text[start + taken :], name)
    except BlockError as error:
        assert all(len(fault) > 20 for fault in error.faults)
    else:
        assert block.rows or block.in_no_row


@pytest.mark.parametrize("name", ["street.txt", "none.csv", "nonsense.csv"])
def test_a_file_that_is_no_table_is_told(folder, name):
    (folder / "street.csv").write_text(HEAD, encoding="utf-8")
    (folder / "nonsense.csv").write_bytes(b"\xff\xfe\x00")
    told = {"street.txt": "is no table of a street", "none.csv": "cannot be read", "nonsense.csv": "is not UTF-8"}
    with pytest.raises(BlockError, match=told[name]):
        read_block(folder / name)


@pytest.mark.parametrize(
    ("rules", "told"),
    [
        ({"limit": 0.0}, "rules, limit: 0 is out of range: a gap that parts rows must be greater than 0 m"),
        ({"typology": "brick"}, '"brick" is not a typology'),
        ({"axis": 400.0}, "rules, axis: 400 is out of range"),
    ],
)
def test_rules_out_of_range_are_refused(rules, told):
    with pytest.raises(PoundingError, match=told):
        Rules(**rules)


def test_an_axis_that_is_given_is_taken(folder):
    """The direction from north, from left to right: due west turns a row that runs east."""
    text = collection(feature([SQUARE]), feature([shifted(10.5)], "B"))
    east, west = (read(folder, text, "street.geojson", metres=True, axis=axis).rows[0] for axis in (90.0, 270.0))
    assert [house.name for house in east.buildings] == ["A", "B"]
    assert [house.name for house in west.buildings] == ["B", "A"]
    assert east.gaps == west.gaps == (0.5,)
    north = read(folder, text, "street.geojson", metres=True, axis=0.0)
    assert [house.name for house in north.in_no_row] == ["A", "B"] and north.alone == ()
    assert [pair.words for pair in north.close] == ["A and B: 500 mm clear, across the axis of the street"]


@pytest.fixture(scope="module")
def shipped() -> tuple[Block, Block]:
    return read_block(STREETS / "street.csv"), read_block(STREETS / "street.geojson")


def test_the_shipped_street_is_thirty_buildings_in_three_rows(shipped):
    table, prints = shipped
    assert [len(row.buildings) for row in table.rows] == [11, 12, 6]
    assert [house.name for house in table.alone] == ["47"]
    assert table.notes == ()
    columns = [each.column for each in table.filled]
    missing = {"height": 3, "storeys": 2, "typology": 2, "floor load": 8, "gap": 2}
    missing |= {"damping": 30, "floor mass": 30, "floor depth": 30}
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
    assert "made street" in (STREETS / "street.geojson").read_text(encoding="utf-8")


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


@settings(max_examples=25)
@given(streets())
def test_every_scene_of_a_street_is_read(folder, street):
    assert_read(read(folder, as_csv(street)))


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
    with pytest.raises(
        PoundingError, match='"building" cannot be given; it may be effects, records, grid, uncertain, solver'
    ):
        table.scenes(tables={"building": []})


@given(st.floats(1e-3, 1e3))
def test_what_is_written_is_read_back_to_the_bit(value):
    for quantity in (quantities.GAP, quantities.MASS, quantities.PERIOD):
        assert quantities.parse(block_scenes.written(value, quantity), quantity) == value


def test_files_are_told_apart(folder):
    text = "street,name,storeys,floor mass [t],gap [mm]\nA b,1,3,90,20\nA b,2,4,95,\na-B,1,2,80,10\na-B,2,2,80,\n"
    assert read(folder, text).file_names() == ["a-b-1.toml", "a-b-2.toml"]


def test_the_command_writes_what_the_call_returns(tmp_path):
    out = tmp_path / "scenes"
    told = CliRunner().invoke(app, ["block", str(STREETS / "street.csv"), "-o", str(out), "--pga", "0.3 g"])
    assert told.exit_code == 0, told.output
    scenes = [f"street-row-{n}.toml" for n in (1, 2, 3)]
    assert sorted(each.name for each in out.iterdir()) == ["buildings.csv", "filled.csv", "neighbours.csv", *scenes]
    assert "alone, no neighbour within 1 m along the street: 47" in told.output
    assert re.search(r"street, row 2 +12 +2 to 9 +0 mm to 100 mm +23, 25", told.output)
    block = pr.block(STREETS / "street.csv", tmp_path / "again", tables={"records": {"pga": "0.3 g"}})
    assert {name: (out / name).read_text(encoding="utf-8") for name in block.file_names()} == block.scenes(
        tables={"records": {"pga": "0.3 g"}}
    )
    for name in ("buildings.csv", "filled.csv", "neighbours.csv", *block.file_names()):
        assert (out / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_a_faulty_table_ends_with_status_2_and_writes_nothing(tmp_path):
    (tmp_path / "bad.csv").write_text(HEAD + "A,x,3,masonry,180,\n", encoding="utf-8")
    out = tmp_path / "scenes"
    for words in (
        [str(tmp_path / "bad.csv")],
        [str(STREETS / "street.csv"), "--record", "RSN6"],
        [str(STREETS / "street.csv"), "--floor-load", "10 kN"],
        [str(STREETS / "street.csv"), "--stiffness", "10 kN/m"],
        [str(STREETS / "street.csv"), "--contact-model", "hertzian"],
        [str(STREETS / "street.csv"), "--contact-model", "stereomechanical"],
        [str(STREETS / "street.csv"), "--restitution", "2"],
        [str(STREETS / "street.csv"), "--tolerance", "5"],
        [str(STREETS / "street.csv"), "--metres"],
    ):
        told = CliRunner().invoke(app, ["block", *words, "-o", str(out)])
        assert told.exit_code == 2, told.output
        assert told.stderr.startswith("pounding-risk: ")
        assert not out.exists()
    with pytest.raises(SceneError, match="yield_force"):
        pr.block(STREETS / "street.csv", out, contact=block_scenes.Contact(yield_force="2"))
    assert not out.exists()
