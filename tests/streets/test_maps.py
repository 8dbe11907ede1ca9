"""Files of maps: one street in many projections and formats, what is repaired and refused, and damaged files."""

import csv
import json
import re
import tomllib
from collections.abc import Callable
from itertools import pairwise
from math import cos, degrees, radians, sin, sqrt
from pathlib import Path
from typing import Any

import commands
import geopandas
import numpy as np
import pyogrio
import pytest
import shapely
from damaged_tables import survey
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Transformer
from sweeps import sweep
from test_inventory import ASSETS, FEATURES, METADATA, OED, R2D, exposure
from test_street import STREETS

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.sobol import LEAST_SAMPLES
from pounding_risk.streets import table as street_table
from pounding_risk.streets.defaults import Rules
from pounding_risk.streets.inventory import read_inventory
from pounding_risk.streets.neighbours import floors
from pounding_risk.streets.rows import Block, footprint_outlines, footprint_rings, read_block
from pounding_risk.streets.table import BlockError

SHIPPED = Path(pr.__file__).parent / "scene" / "shipped"
GAPS = (0.02, 0.3, 0.0, 0.15)
WIDTHS = (10.0, 14.0, 8.0, 20.0, 12.0)
EQUATOR, FLATTENING = 6378137.0, 1.0 / 298.257223563


def made_street(turn: float = 0.0) -> list[shapely.Polygon]:
    """Five rectangles with one front line and `GAPS` between them, in metres, turned about the first corner."""
    left, street = 0.0, []
    for width, gap in zip(WIDTHS, (*GAPS, 0.0), strict=True):
        street.append(shapely.box(left, 0.0, left + width, 9.0 + 0.25 * width))
        left += width + gap
    around = np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]])
    return [shapely.transform(shape, lambda ring: ring @ around) for shape in street]


def in_degrees(shapes: list[shapely.Polygon], longitude: float, latitude: float) -> list[shapely.Polygon]:
    """By the ellipsoid's radii of curvature (Snyder 1987, 4-18 and 4-20): to some 0.1 mm over 70 m."""
    squashed = FLATTENING * (2.0 - FLATTENING)
    root = 1.0 - squashed * sin(radians(latitude)) ** 2
    across = EQUATOR / sqrt(root)
    scale = np.degrees(1.0 / np.array([across * cos(radians(latitude)), across * (1.0 - squashed) / root]))
    return [shapely.transform(shape, lambda ring: ring * scale + (longitude, latitude)) for shape in shapes]


def frame(shapes: list[Any], system: Any, **columns: Any) -> geopandas.GeoDataFrame:
    values = {"name": [f"No. {n}" for n in range(len(shapes))], "storeys": [3] * len(shapes), **columns}
    return geopandas.GeoDataFrame(values, geometry=shapes, crs=system)


def write(path: Path, shapes: list[Any], system: Any, layer: str | None = None, **columns: Any) -> Path:
    table = frame(shapes, system, **columns)
    if path.suffix == ".parquet":
        table.to_parquet(path)
    else:
        table.to_file(path, engine="pyogrio", layer=layer, **({"SPATIAL_INDEX": "NO"} if path.suffix == ".fgb" else {}))
    return path


def read_faults(path: Path, rules: Rules | None = None, **options: Any) -> list[str]:
    with pytest.raises(BlockError) as error:
        read_block(path, rules, **options)
    return error.value.faults


def houses(block: Block) -> list[str]:
    """Each with its id of the map; a height of a part, of feet and of a rule among them."""
    return [f"{each.mapped.id}, {each.name}: {each.height:.9g} m, {each.storeys} storeys" for each in block.houses]


def only(block: Block) -> Any:
    (row,) = block.rows
    return row


SYSTEMS = [
    ("street.gpkg", "EPSG:32756", (151.2, -33.87)),  # UTM zone 56 south
    ("street.fgb", "EPSG:3857", (151.2, -33.87)),  # of web maps, stretched by 1 / cos 33.87 degrees = 1.2
    ("street.parquet", "OGC:CRS84", (151.2, -33.87)),
    ("street.gpkg", "EPSG:2263", (-74.0, 40.7)),  # US survey feet
    ("street.geojson", "EPSG:2263", (-74.0, 40.7)),  # in its member crs, as GDAL and QGIS write it
    ("street.fgb", "EPSG:27572", (2.35, 48.85)),  # Lambert zone II on Clarke 1880 and the meridian of Paris
    ("street.parquet", "EPSG:7415", (4.9, 52.37)),  # Amersfoort with heights
]


@pytest.mark.parametrize("turn", [0.0, 0.6])
@pytest.mark.parametrize(("name", "system", "place"), SYSTEMS)
def test_a_street_is_the_same_in_every_format_and_projection(tmp_path, name, system, place, turn):
    """Gaps and sizes of rectangles in metres, on the ellipsoid of the system itself."""
    shapes = made_street(turn)
    to = Transformer.from_crs(geographic(system), system, always_xy=True)
    wanted = [shapely.transform(shape, lambda ring: np.column_stack(to.transform(*ring.T)))
              for shape in in_degrees(shapes, *place)]  # fmt: skip
    block = read_block(write(tmp_path / name, wanted, system))
    row = only(block)
    assert [house.name for house in row.buildings] == [f"No. {n}" for n in range(5)]
    # Clarke 1880 differs from WGS 84 by 4e-5, in which the test's own degrees are.
    assert row.gaps == pytest.approx(GAPS, abs=3e-4)
    areas = [house.footprint.area for house in row.buildings]
    assert areas == pytest.approx([width * (9.0 + 0.25 * width) for width in WIDTHS], rel=3e-4)
    assert row.direction == pytest.approx(90.0 - degrees(turn), abs=0.02)
    assert [pair.faced for pair in row.pairs] == pytest.approx([11.5, 11.0, 11.0, 12.0], abs=0.01)
    # Of the first house, to a datum's shift of some 200 m.
    assert (row.buildings[0].mapped.longitude, row.buildings[0].mapped.latitude) == pytest.approx(place, abs=4e-3)


def geographic(system: str) -> Any:
    from pyproj import CRS

    own = CRS(system)
    base = own.sub_crs_list[0] if own.is_compound else own
    return "EPSG:4275" if system == "EPSG:27572" else base.geodetic_crs  # NTF, from Greenwich


def test_a_plane_of_utm_is_unrolled_by_its_scale(tmp_path):
    """On the central meridian of a zone lengths are 0.9996 of those on the ground, and 500 km is its easting.

    The meridian from the equator to 40 degrees is 4,429,529.03 m long (WGS 84), in the zone 4,427,757.22 m.
    """
    shapes = [shapely.box(500e3 + east, 4427757.22 + north, 500e3 + east + 10.0, 4427757.22 + north + 10.0)
              for east, north in ((-5.0, -5.0), (5.9, -5.0))]  # fmt: skip
    row = only(read_block(write(tmp_path / "street.gpkg", shapes, "EPSG:32633")))
    assert row.gaps == (round(0.9 / 0.9996, 4),) == (0.9004,)
    first = row.buildings[0]
    assert first.footprint.area == pytest.approx(100.0 / 0.9996**2, rel=1e-7)
    assert (first.mapped.longitude, first.mapped.latitude) == pytest.approx((15.0, 40.0), abs=1e-7)


def test_a_layer_is_chosen_and_others_are_named(tmp_path, says):
    path = tmp_path / "city.gpkg"
    for name in ("houses", "sheds"):
        frame(made_street(), "EPSG:32633").to_file(path, engine="pyogrio", layer=name)
    frame([shapely.Point(0, 0)] * 2, "EPSG:32633").to_file(path, engine="pyogrio", layer="trees")
    assert len(only(read_block(path, layer="sheds")).buildings) == 5
    says(read_faults(path), read_faults(path, layer="shed"), read_faults(path, layer="trees"))
    for name in ("street.geojson", "street.csv"):
        says(read_faults(SHIPPED / name, layer="x"))


@pytest.mark.filterwarnings("ignore:'crs' was not provided")
def test_coordinates_that_nothing_ties_to_the_earth_are_refused_unless_they_are_metres(tmp_path, says):
    path = tmp_path / "street.gpkg"
    pyogrio.write_dataframe(frame(made_street(), None), path)
    block = read_block(path, Rules(metres=True))
    assert only(block).gaps == GAPS
    assert np.isnan(only(block).buildings[0].mapped.longitude)
    degrees_of = write(tmp_path / "degrees.gpkg", in_degrees(made_street(), 15.0, 40.0), "EPSG:4326")
    larger = [shapely.affinity.scale(shape, 400, 400, origin=(0, 0)) for shape in made_street()]
    wrong = write(tmp_path / "wrong.fgb", larger, "EPSG:32633")
    far = write(tmp_path / "far.fgb", [shapely.box(250, 0, 250.1, 0.1)], "EPSG:4326")
    says(read_faults(path), read_faults(degrees_of, Rules(metres=True)), read_faults(wrong), read_faults(far))
    local = write(tmp_path / "local.geojson", made_street(), "EPSG:32633")
    site = {"type": "name", "properties": {"name": 'LOCAL_CS["site"]'}}
    local.write_text(json.dumps(json.loads(local.read_text()) | {"crs": site}))
    assert "tied to no place on the Earth" in str(read_faults(local))
    assert only(read_block(local, Rules(metres=True))).gaps == GAPS
    for name in ("feet.gpkg", "feet.geojson"):  # they were read as metres, 3.28 times as large
        says(read_faults(write(tmp_path / name, made_street(), "EPSG:2263"), Rules(metres=True)))


SPIKE = [(0, 0), (10, 0), (10, 5), (14, 5), (10, 5), (10, 10), (0, 10), (0, 0)]  # a wall out and back
BOW = [(0, 0), (9, 9), (9, 0), (0, 8), (0, 0)]


def test_what_is_plain_is_repaired_and_told(tmp_path, says):
    """A spike of no width, parts that overlap, heights of corners; a court that touches its wall in one point."""
    first = shapely.Polygon(SPIKE)
    second = shapely.MultiPolygon([shapely.box(10.5, 0, 16, 10), shapely.box(15, 0, 20, 10)])
    third = shapely.force_3d(shapely.box(20.5, 0, 30, 10), 7.0)
    court = shapely.Polygon([(31, 0), (41, 0), (41, 10), (31, 10)], [[(31, 5), (35, 3), (35, 7), (31, 5)]])
    block = read_block(write(tmp_path / "street.gpkg", [first, second, third, court], "EPSG:32633"))
    row = only(block)
    scale = 0.9996**2
    at = [house.footprint.area * scale for house in row.buildings]
    # At 500 km west of the central meridian the plane is stretched by x² / 2 R²: some 3e-3.
    assert at == pytest.approx([100.0, 95.0, 95.0, 92.0], rel=8e-3)
    assert at[0] / at[1] == pytest.approx(100.0 / 95.0, rel=1e-6)
    assert row.gaps == pytest.approx((0.5, 0.5, 1.0), rel=4e-3)
    # Words of GEOS stand in brackets.
    says([re.sub(r" \(.*?\)", "", note) for note in block.notes if note.startswith("feature")])


FAULTY = {
    "a bow": shapely.Polygon(BOW),
    "a line": shapely.Polygon([(0, 0), (1, 1), (2, 2), (0, 0)]),
    "an empty polygon": shapely.Polygon(),
    "nothing": None,
    "a point": shapely.Point(0, 0),
    "a hole outside": shapely.Polygon([(0, 0), (9, 0), (9, 9), (0, 9)], [[(20, 20), (29, 20), (29, 29), (20, 20)]]),
}


@pytest.mark.parametrize("words", FAULTY)
def test_what_is_not_plain_is_refused_by_its_feature(tmp_path, says, words):
    path = write(tmp_path / "street.parquet", [shapely.box(-12, 0, -2, 10), FAULTY[words]], "EPSG:32633")
    says(read_faults(path))


def test_buildings_within_a_box_or_polygons(tmp_path, says):
    """Faults outside do not count."""
    shapes = [*in_degrees(made_street(), 15.0, 40.0), *in_degrees([shapely.Polygon(BOW)], 15.1, 40.0)]
    path = write(tmp_path / "street.fgb", shapes, "EPSG:4326")
    assert len(only(read_block(path, within="14.99, 39.99, 15.05, 40.01")).buildings) == 5
    # The middles of the first two houses are 5 and 17.02 m east, 85.4 km to a degree at 40 degrees north.
    assert len(only(read_block(path, within=f"14.9,39.9,{15.0 + 20.0 / 85.4e3},40.1")).buildings) == 2
    area = write(tmp_path / "area.gpkg", [shapely.box(14.9, 39.9, 15.0 + 30.0 / 85.4e3, 40.1)], "EPSG:4326")
    assert len(only(read_block(path, within=str(area))).buildings) == 3
    says(read_faults(path), read_faults(path, within="1,1,2,2"), read_faults(path, within="2,1,1,2"))


@pytest.mark.parametrize("system", ["EPSG:4326", "EPSG:3857", "EPSG:32633"])
def test_a_building_beside_the_edge_of_a_box_is_named(tmp_path, system):
    """The third house is left out, 300 mm from the second one; in web maps a metre is 1.3 units at 40 degrees north."""
    path = tmp_path / "street.gpkg"
    frame(in_degrees(made_street(), 15.0, 40.0), "EPSG:4326").to_crs(system).to_file(path, engine="pyogrio")
    box = f"14.9,39.9,{15.0 + 20.0 / 85.4e3},40.1"
    for limit, parted in ((0.29, []), (0.31, ["feature 3 (300 mm from feature 2)"])):
        notes = read_block(path, Rules(limit=limit), within=box).notes
        assert [note.partition(": left out by --within")[0] for note in notes] == parted
    assert read_block(path, within="14.9,39.9,15.1,40.1").notes == ()


def test_a_file_of_openstreetmap_is_read_as_it_is(tmp_path, says):
    """Tags in columns and in other_tags, as GDAL writes them; parts stand in their buildings; shared names."""
    shapes = [*in_degrees(made_street(), 15.0, 40.0)]
    part = in_degrees([shapely.box(1.0, 1.0, 5.0, 5.0)], 15.0, 40.0)
    columns = {
        "name": ["Kiosk", "Kiosk", None, None, None, None],
        "osm_id": ["11", "12", "13", "14", "15", "16"],
        "building": ["yes", "house", "roof", "yes", "yes", None],
        "building:part": [None, None, None, None, None, "yes"],
        "height": [None, "12", "3.5", "40 ft", None, "21"],
        "other_tags": ['"building:levels"=>"7","source"=>"x"', None, None, '"building:levels"=>"2.5"', None, None],
    }
    path = tmp_path / "osm.gpkg"
    pyogrio.write_dataframe(frame(shapes + part, "EPSG:4326", **columns).drop(columns="storeys"), path)
    block = read_block(path, Rules(storeys=2))
    says(houses(block), [f"{each.building}: {each.value}, {each.rule}" for each in block.filled], block.notes)
    says(str(block.resolution.size), block.resolution.words)


def test_a_file_of_overture_is_read_as_it_is(tmp_path, says):
    """Its schema (docs.overturemaps.org/schema/reference/buildings/building): names is a table, height in metres."""
    columns = {
        "id": [f"08b2a100-{n}" for n in range(5)],
        "names": [{"primary": "Town hall", "common": None}, None, None, {"primary": "Inn"}, None],
        "height": [12.5, None, 9.0, None, 7.0],
        "num_floors": [4, 2, None, 3, 2],
        "min_height": [None, None, 3.0, None, None],
        "has_parts": [False] * 5,
        "sources": [[{"dataset": "OpenStreetMap"}]] * 5,
    }
    table = frame(in_degrees(made_street(), 15.0, 40.0), "OGC:CRS84", **columns).drop(columns=["name", "storeys"])
    table.to_parquet(tmp_path / "buildings.parquet")
    block = read_block(tmp_path / "buildings.parquet")
    says(houses(block), block.notes)


def three(tmp_path: Path, turn: float = 0.4, **rules: Any) -> Block:
    shapes = in_degrees(made_street(turn), 15.0, 40.0)
    columns = {"name": [*"abcde"], "height [m]": [9.0, 10.5, 9.0, 12.0, 9.0], "storeys": [3, 3, 3, 4, 3]}
    path = write(tmp_path / "street.gpkg", shapes, "EPSG:4326", **columns, id=[f"w{n}" for n in range(5)])
    return read_block(path, Rules(**rules))


def test_gaps_are_as_uncertain_as_walls(tmp_path):
    """Uniform from the larger of 0 and d - r to d + r; what the caller gives of gaps counts."""
    known, block = three(tmp_path), three(tmp_path, resolution="0.1 m")
    assert "uncertain" not in tomllib.loads(only_scene(known))
    assert "the file does not say how well its outlines are known (--resolution" in known.gap_words
    ends = [(max(gap - 0.1, 0.0), gap + 0.1) for gap in only(block).gaps]
    assert np.array([pair.gaps for pair in only(block).pairs]) == pytest.approx(np.array(ends), abs=1e-6)
    scene = parse_scene(only_scene(block))
    assert scene.uncertain is not None and scene.uncertain.samples == LEAST_SAMPLES  # of which shares have bounds
    assert scene.uncertain.keys == tuple(f"interface.{number}.gap" for number in (1, 2, 3, 4))
    assert only(block).gaps == only(known).gaps
    for number, (low, high) in zip(scene.uncertain.numbers, ends, strict=True):
        assert (number.distribution.low, number.distribution.high) == pytest.approx((low, high), abs=1e-6)
    assert "# Measured gaps are uniform within 100 mm of the distance of the walls (as stated).\n" in only_scene(block)
    stated = three(tmp_path, resolution=0.0)
    assert "uncertain" not in tomllib.loads(only_scene(stated)) and "taken for known" in stated.gap_words
    few = {"uncertain": {"samples": 8, "interface.gap": {"distribution": "uniform", "low": "0 mm", "high": "9 mm"}}}
    own = tomllib.loads(only_scene(block, tables=few))["uncertain"]
    assert own == {**few["uncertain"]}
    gaps_of_grid = tomllib.loads(only_scene(block, tables={"grid": {"gap": ["10 mm", "20 mm"]}}))
    assert "uncertain" not in gaps_of_grid
    assert "uncertain" not in tomllib.loads(only_scene(known, tables={"uncertain": {"samples": 8}}))


def only_scene(block: Block, **options: Any) -> str:
    (text,) = block.scenes(["RSN6-180"], **options).values()
    return text


@pytest.mark.complete
def test_gaps_that_were_measured_otherwise_are_known(tmp_path):
    shapes = in_degrees(made_street(), 15.0, 40.0)
    path = write(tmp_path / "street.gpkg", shapes, "EPSG:4326", **{"gap [mm]": [20.0, None, None, None, None]})
    uncertain = parse_scene(only_scene(read_block(path, Rules(resolution=0.05)))).uncertain
    assert uncertain is not None and len(uncertain.numbers) == 3


def test_a_given_gap_is_refused_where_the_file_has_no_order(tmp_path, says):
    """That of the second building is to the third, as the note says, and to the first where right is the other way."""
    for name, order in (("street.gpkg", [0, 1, 2, 3, 4]), ("mixed.gpkg", [4, 1, 0, 2, 3])):
        shapes = [in_degrees(made_street(), 15.0, 40.0)[number] for number in order]
        columns = {"name": [f"No. {number}" for number in order], "gap [mm]": [90.0 if n == 1 else None for n in order]}
        write(tmp_path / name, shapes, "EPSG:4326", **columns)
    block = read_block(tmp_path / "street.gpkg", Rules(survey=0.3))
    assert [pair.right.name for pair in only(block).pairs if pair.gap == 0.09] == ["No. 2"]
    says(block.notes, read_faults(tmp_path / "mixed.gpkg", Rules(survey=0.3)))
    for axis, name in ((90.0, "No. 2"), (270.0, "No. 0")):
        pairs = only(read_block(tmp_path / "mixed.gpkg", Rules(survey=0.3, axis=axis))).pairs
        assert [pair.right.name for pair in pairs if pair.gap == 0.09] == [name]


def test_the_last_decimal_of_coordinates_is_the_resolution(tmp_path):
    """Six decimals of a degree of 111.2 km are 0.1112 m; walls that overlap by less touch."""
    shapes = [shapely.set_precision(shape, 1e-6) for shape in in_degrees(made_street(), 15.0, 40.0)]
    block = read_block(write(tmp_path / "street.fgb", shapes, "EPSG:4326"))
    assert block.resolution.size == pytest.approx(0.1112)
    assert any("coordinates have 6 decimals, 110 mm on the ground" in note for note in block.notes)
    for pair, gap in zip(only(block).pairs, GAPS, strict=True):
        low, high = pair.gaps
        assert low <= gap <= high and high - low <= 2 * 0.1112


def test_the_middle_of_a_row_stands_where_motions_of_sites_are_asked_for(tmp_path):
    """The mean of the middles of its buildings."""
    block = three(tmp_path, turn=0.0)
    tables = {"records": {"sites": "EventGrid.csv"}}
    (text,) = block.scenes(tables=tables).values()
    records = tomllib.loads(text)["records"]
    assert records["sites"] == "EventGrid.csv"
    left = np.cumsum([0.0, *(width + gap for width, gap in zip(WIDTHS, GAPS, strict=False))])
    east = np.mean(left + 0.5 * np.array(WIDTHS))
    assert records["place"]["longitude"] == pytest.approx(15.0 + east / 85.394e3, abs=2e-6)  # of a degree at 40 north
    assert records["place"]["latitude"] == pytest.approx(40.0 + 0.5 * (9.0 + 0.25 * 12.8) / 111.035e3, abs=2e-6)
    assert "place" not in tomllib.loads(only_scene(block))["records"]


@given(st.integers(1, 9), st.integers(1, 9), st.floats(2.5, 4.0), st.floats(2.5, 4.0))
def test_floors_that_miss_are_counted_by_hand(one, other, low, high):
    """Floors of 0.25 m meet where the higher of two levels is less than that above the other."""
    from pounding_risk.streets.defaults import House

    houses = [House("x", "", count * each, count, "masonry", 1e5, 0.05) for count, each in ((one, low), (other, high))]
    levels = [[each * (n + 1) for n in range(count)] for count, each in ((one, low), (other, high))]
    told = floors(*houses)
    meeting = [(a, b) for a in levels[0] for b in levels[1] if abs(a - b) < 0.25 - 1e-9]
    assert told.meet == len(meeting)
    roof = min(levels[0][-1], levels[1][-1])
    paired = {level for pair in meeting for level in pair}
    missing = [level for side in levels for level in side if level <= roof and level not in paired]
    assert told.miss == len(missing)
    same = floors(houses[0], houses[0])
    assert same == (one, 0, 0.0)


def test_sides_and_positions_are_told(tmp_path):
    """A row of three with a house behind the middle one, and one that stands alone."""
    shapes = [shapely.box(x, y, x + 10, y + 10) for x, y in ((0, 0), (10.1, 0), (20.2, 0), (10.1, 10.1), (50, 0))]
    block = read_block(write(tmp_path / "street.gpkg", shapes, "EPSG:32633"), Rules(axis=90.0))
    assert [block.sides["", f"No. {n}"] for n in range(5)] == [1, 3, 1, 1, 0]
    assert block.sides_adjoined() == [("none", 1), ("one", 3), ("three", 1)]
    rows = list(csv.DictReader(block.buildings_csv().splitlines()))
    assert [row["name"] for row in rows] == [f"No. {n}" for n in range(5)]
    assert [row["position"] for row in rows] == ["end", "interior", "end", "in no row", "in no row"]
    assert [row["sides adjoined"] for row in rows] == [*"13110"]
    assert [row["place in the file"] for row in rows] == [f"feature {n}" for n in range(1, 6)]
    outline = shapely.from_wkt(rows[0]["footprint [WKT, deg]"])
    assert outline.centroid.x == pytest.approx(float(rows[0]["longitude [deg]"]), abs=1e-8)


COURT = shapely.box(0, 0, 30, 30).difference(shapely.box(10, 10, 20, 20))
WINGS = shapely.MultiPolygon([shapely.box(0, 0, 10, 12), shapely.box(20.1, 0, 30, 12)])
HORSESHOE = shapely.box(0, 0, 30, 20).difference(shapely.box(8, 8, 22, 20))
CORNER = shapely.box(0, 0, 30, 20).difference(shapely.box(10.05, 5, 30, 20))


@pytest.mark.parametrize(
    ("around", "inner", "sides", "rows"),
    [
        (COURT, (10.3, 10.3, 19.7, 19.7), 4, (0, 0)),
        (WINGS, (10.05, 0, 20.05, 12), 2, (0, 0)),
        (HORSESHOE, (8.2, 8.2, 21.8, 20), 3, (0, 1)),  # open to the north
        (CORNER, (10.1, 4.95, 28, 20), 2, (0, 1)),  # by 50 mm on the wing, which the survey explains
    ],
    ids=["court", "wings", "horseshoe", "corner"],
)
@pytest.mark.parametrize("turn", [0.0, 20.0])
def test_sides_of_a_building_in_another_are_counted_by_walls(tmp_path, around, inner, sides, rows, turn):
    """Of both the same; with the axis east and north, neither of which makes a row of a house in a court."""
    shapes = [shapely.affinity.rotate(shape, -turn, origin=(0, 0)) for shape in (around, shapely.box(*inner))]
    path = write(tmp_path / "street.parquet", shapes, None)
    for axis, number in zip((90.0, 0.0), rows, strict=True):
        block = read_block(path, Rules(metres=True, axis=axis + turn, resolution=0.0))
        assert list(block.sides.values()) == [sides, sides] and len(block.rows) == number
        inside = [pair.reason.startswith("one stands in a court") for pair in block.close]
        assert inside == ([] if number else [rows == (0, 0)])
    if rows == (0, 0):
        with pytest.raises(BlockError, match=r"between its parts; no direction makes a row of such two: write a \.csv"):
            block.check()
        assert "--axis" not in commands.run("block", str(path), "--metres").output


def test_streets_at_an_angle_have_an_axis_of_their_own(tmp_path):
    """Two rows of one file, 30 degrees apart and 100 m away: none has the axis of the other."""
    away = [shapely.affinity.translate(shape, 500e3, 1e6) for shape in made_street(0.0)]
    away += [shapely.affinity.translate(shape, 500e3, 1e6 + 100.0) for shape in made_street(radians(30.0))]
    block = read_block(write(tmp_path / "city.gpkg", away, "EPSG:32633"))
    assert [row.name for row in block.rows] == ["city, row 1", "city, row 2"]
    assert [row.direction for row in block.rows] == pytest.approx([90.0, 60.0], abs=1e-3)
    assert [row.gaps for row in block.rows] == [pytest.approx(GAPS, abs=2e-4)] * 2


def test_gaps_of_a_terrace_on_a_curve_are_square_to_its_walls(tmp_path):
    """Nine sectors of a ring with 40 mm between parallel walls, the outermost 39 degrees askew to the axis."""
    shapes = []
    for middle in np.radians(11.0 * np.arange(-4, 5)):
        sides = [(middle + side * radians(5.5), -side * 0.02) for side in (-1, 1)]
        (a, b), (c, d) = ([np.array([sin(t), cos(t)]) * r + np.array([cos(t), -sin(t)]) * inward for r in (40.0, 52.0)]
                          for t, inward in sides)  # fmt: skip
        shapes.append(shapely.Polygon([a, b, d, c]))
    row = only(read_block(write(tmp_path / "street.parquet", shapes, None), Rules(metres=True, resolution=0.0)))
    apart = [one.distance(other) for one, other in pairwise(shapes)]
    assert row.gaps == pytest.approx(apart, abs=1e-4) and apart == pytest.approx([0.04] * 8, abs=1e-4)
    assert row.pairs[0].faced == pytest.approx(12.0 * cos(radians(38.5)), abs=0.05)


@pytest.mark.parametrize("below", [4.95, 5.0, 5.3])
def test_a_house_that_touches_the_wing_beside_it_does_not_overlap_it(tmp_path, below):
    """In the corner of an L, on whose wing it stands, or by 50 mm in it: walls within the survey's 0.1 m touch."""
    corner = shapely.Polygon([(0, 0), (20, 0), (20, 5), (10, 5), (10, 15), (0, 15)])
    shapes = [corner, shapely.box(10.05, below, 20, 15), shapely.box(20.03, 0, 30, 15)]
    path = write(tmp_path / "street.parquet", shapes, None)
    row = only(read_block(path, Rules(metres=True, axis=90.0, resolution=0.0)))
    assert len(row.buildings) == (2 if below < 5.1 else 3)


def test_a_plan_takes_footprints_of_any_map(tmp_path):
    block = three(tmp_path)
    pr.block(tmp_path / "street.gpkg", tmp_path / "out", records=["RSN6-180"])
    of_map, of_table = footprint_rings(tmp_path / "street.gpkg"), footprint_rings(tmp_path / "out" / "buildings.csv")
    assert list(of_map) == list(of_table) == [("", name) for name in "abcde"]
    for name, (ring,) in of_map.items():
        assert of_table[name][0] == pytest.approx(ring, abs=1e-3)  # about another middle by less
    assert block.houses[0].mapped.id == "w0"
    for source in (tmp_path / "street.gpkg", tmp_path / "out" / "buildings.csv"):
        outlines, in_degrees = footprint_outlines(source)
        assert in_degrees and list(outlines) == [("", name) for name in "abcde"]
        first = in_degrees and outlines["", "a"].centroid
        assert (first.x, first.y) == pytest.approx((15.0, 40.0), abs=1e-4)
    renamed = (tmp_path / "out" / "buildings.csv").rename(tmp_path / "renamed.csv")
    assert list(footprint_outlines(renamed)[0]) == [("", name) for name in "abcde"]
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "buildings.csv").write_text("name\na\n")
    with pytest.raises(BlockError, match="has no columns street, name and footprint"):
        footprint_rings(tmp_path / "none" / "buildings.csv")


def test_a_plan_has_the_courts_of_footprints(tmp_path):
    of = [500e3 + 20.0 * n for n in range(2)]
    shapes = [shapely.box(x, 0.0, x + 19.9, 20.0) - shapely.box(x + 5.0, 5.0, x + 9.0, 8.0) for x in of]
    path = write(tmp_path / "street.gpkg", shapes, "EPSG:32633", name=["a", "b"])
    for outer, court in footprint_rings(path).values():
        assert shapely.LinearRing(outer).is_ccw and not shapely.LinearRing(court).is_ccw
        assert shapely.Polygon(court).area == pytest.approx(12.0, rel=1e-3)


def test_one_id_of_several_buildings_is_told(tmp_path):
    shapes = [shapely.box(500e3 + 20.1 * n, 0.0, 500e3 + 20.1 * n + 20.0, 20.0) for n in range(4)]
    path = write(tmp_path / "street.gpkg", shapes, "EPSG:32633", id=["w1", "w2", "w1", None], height=["9 m"] * 4)
    (note,) = [note for note in read_block(path).notes if "one id" in note]
    assert note.endswith(": w1 (feature 1, feature 3)")


def test_scenes_of_a_street_take_the_motions_of_their_sites(tmp_path, says):
    three(tmp_path)
    (tmp_path / "EventGrid.csv").write_text("GP_file,Longitude,Latitude\nfar.csv,15.5,40\nnear.csv,15.001,40\n")
    (tmp_path / "near.csv").write_text("TH_file,factor\nRSN1,2.0\n")
    wave = (0.1 * np.sin(np.linspace(0.0, 9.0, 100))).tolist()
    (tmp_path / "RSN1.json").write_text(json.dumps({"dT": 0.02, "data_x": wave}))
    folder = str(tmp_path)
    words = ["block", f"{folder}/street.gpkg", "-o", f"{folder}/out", "--sites", f"{folder}/EventGrid.csv"]
    commands.done(*words, "--unit", "g")
    study = pr.read_scene(tmp_path / "out" / "street.toml")
    assert study.records.sites == "../EventGrid.csv"
    (motion,) = gathered(study).motions
    assert motion.name == "RSN1"
    assert motion.acceleration[50] == pytest.approx(2.0 * 9.80665 * wave[50], rel=1e-12)
    more = (["--pga", "0.3 g"], ["--record", "RSN6-180"], ["--sites", "none.csv"])
    for wrong in ([*words[:2], "--unit", "g"], *([*words, *each] for each in more)):
        says(" ".join(commands.refused(*wrong).split()))


def test_numbers_without_a_unit_are_one_fault(tmp_path, says):
    path = write(tmp_path / "street.gpkg", in_degrees(made_street(), 15.0, 40.0), "EPSG:4326", height=[9.0] * 5)
    says(read_faults(path))
    with pytest.raises(BlockError) as error:
        read_block(write(tmp_path / "crossed.parquet", [shapely.Polygon(BOW)] * 80, "EPSG:32633"))
    assert len(error.value.faults) == 80
    assert str(error.value).splitlines()[0].endswith(": 80 faults")
    assert len(str(error.value).splitlines()) == 52 and str(error.value).endswith("and 30 more faults")


def test_the_command_reads_a_map(tmp_path, says):
    three(tmp_path)
    words = ["block", str(tmp_path / "street.gpkg"), "-o", str(tmp_path / "out"), "--resolution", "0.1 m"]
    told = commands.done(*words, "--samples", "16", "--record", "RSN6-180")
    assert "measured gaps are uniform within 100 mm of the distance of the walls (as stated)" in told.output
    assert "by buildings: 2 on one, 3 on two" in told.output
    assert tomllib.loads((tmp_path / "out" / "street.toml").read_text())["uncertain"]["samples"] == 16
    for wrong in (
        "--samples 16",
        "--samples 16 --resolution 0m",
        "--samples 0 --resolution 1m",
        "--within x",
        "--layer x",
        "--storeys 0",
        "--resolution 5",
    ):
        says(" ".join(commands.refused(*words[:2], *wrong.split()).split()))


def test_an_option_without_effect_is_noted_or_refused(tmp_path, says):
    """Of a map whose houses lack typology and load alone; the area and the gap are those of its footprints."""
    three(tmp_path)
    can_act = {"--typology": "steel_frame", "--floor-load": "9 kN/m^2", "--storeys": "4", "--storey-height": "3.5 m"}
    words = ["block", str(tmp_path / "street.gpkg"), *(word for pair in can_act.items() for word in pair)]
    found = re.findall(r"(--[a-z-]+): without effect", commands.done(*words).output)
    assert found == ["--storey-height", "--storeys"]
    for file, wrong in (
        ("street.gpkg", ("--gap", "30 mm")),
        ("street.gpkg", ("--floor-area", "90 m^2")),
        ("t.csv", ("--axis", "30 deg")),
        ("t.csv", ("--least-facing", "10 %")),
    ):
        (tmp_path / "t.csv").write_text("name,storeys,floor mass [t]\na,3,80\nb,3,80\n")
        says(" ".join(commands.refused("block", tmp_path / file, *wrong).split()))
    assert "--gap" not in commands.run("block", str(tmp_path / "t.csv"), "--gap", "30 mm").output


def test_without_the_extra_a_table_is_read_and_a_map_is_refused(monkeypatch):
    monkeypatch.setattr(street_table, "find_spec", lambda name: None if name == "pyproj" else name)
    assert len(read_block(SHIPPED / "street.csv").rows) == 3
    with pytest.raises(PoundingError, match=r"footprints need pyproj, .* pip install 'pounding-risk\[maps\]'"):
        read_block(SHIPPED / "street.geojson")


def oed(lines: list[tuple[str, float, float, int]]) -> str:
    head = "PortNumber,AccNumber,LocNumber,CountryCode,Latitude,Longitude,NumberOfStoreys,ConstructionCode,"
    rows = [f"1,A,{name},GR,{y:.8f},{x:.8f},{storeys},5103,QEQ\n" for name, x, y, storeys in lines]
    return f"{head}LocPerilsCovered\n{''.join(rows)}"


def test_an_inventory_is_joined_to_footprints_by_its_points(tmp_path, says):
    """In any order; one beside all footprints, a second one in a footprint and a footprint without one are told."""
    shapes = in_degrees(made_street(0.3), 23.7, 37.9)
    table = frame(shapes, "EPSG:4326").drop(columns=["name", "storeys"])
    table.to_crs("EPSG:2100").to_file(tmp_path / "street.gpkg", engine="pyogrio")  # Greek grid
    inner = [shapely.point_on_surface(shape) for shape in shapes]
    lines = [(f"L{n}", inner[n].x, inner[n].y, n + 2) for n in (4, 0, 1, 2)]
    lines += [("L9", 23.71, 37.9, 3), ("L0b", inner[0].x + 1e-6, inner[0].y, 7)]
    (tmp_path / "loc.csv").write_text(oed(lines))
    block = read_block(tmp_path / "street.gpkg", Rules(storeys=1), inventory=tmp_path / "loc.csv")
    storeys = {"L0": 2, "L1": 3, "L2": 4, "building 4": 1, "L4": 6}
    assert [(house.name, house.storeys) for house in only(block).buildings] == [*storeys.items()]
    assert only(block).gaps == pytest.approx(GAPS, abs=3e-4)
    says(block.notes)
    assert {each.value for each in block.filled if each.column == "typology" and each.building == "L0"} == {"masonry"}
    (tmp_path / "far.csv").write_text(oed([("L1", 25.0, 37.0, 2)]))
    says(read_faults(tmp_path / "street.gpkg", inventory=tmp_path / "far.csv"))


def test_an_inventory_is_joined_by_ids_where_points_agree(tmp_path, says):
    """A street's table by the ids of the map; and a point some metres beside the walls of the footprint of its id."""
    shapes = in_degrees(made_street(), 23.7, 37.9)
    path = tmp_path / "street.fgb"
    write(path, shapes, "EPSG:4326", id=[f"w{n}" for n in range(5)])
    lines = "".join(f"w{n},{n + 1},90\n" for n in range(5))
    (tmp_path / "table.csv").write_text(f"name,storeys,floor mass [t]\n{lines}")
    block = read_block(path, inventory=tmp_path / "table.csv")
    found = [(house.name, house.storeys, house.floor_mass) for house in block.houses]
    assert found == [(f"w{n}", n + 1, 90e3) for n in range(5)]
    beside = [("w0", 23.7 - 1e-5, 37.9, 4), ("w1", 23.75, 37.9, 5)]  # 0.9 m and 4 km away
    (tmp_path / "loc.csv").write_text(oed(beside))
    joined = read_block(path, inventory=tmp_path / "loc.csv")
    assert [house.storeys for house in joined.houses] == [4, 3, 3, 3, 3]
    assert "loc.csv, line 3: in no footprint, left out" in joined.notes
    command = ["block", str(path), "--inventory", str(tmp_path / "loc.csv")]
    assert "1 by id or name" in commands.run(*command).output
    says(read_faults(SHIPPED / "street.csv", inventory=tmp_path / "loc.csv"))


def test_a_code_without_a_typology_leaves_that_of_the_map(tmp_path):
    """OED 5050 is a light wood frame, of which no typology is one; the second house has none in the map either."""
    shapes = in_degrees(made_street(), 23.7, 37.9)
    path = write(tmp_path / "street.fgb", shapes, "EPSG:4326", typology=["concrete_walls", *4 * [None]])
    lines = [(f"L{n}", *shapely.point_on_surface(shapes[n]).coords[0], 3) for n in (0, 1)]
    (tmp_path / "loc.csv").write_text(oed(lines).replace(",5103,", ",5050,"))
    block = read_block(path, inventory=tmp_path / "loc.csv")
    assert [house.typology for house in block.houses[:2]] == ["concrete_walls", "masonry"]
    (note,) = [note for note in block.notes if "has no typology here" in note]
    assert "one that a column or the map gives is taken, or else the one stated" in note


def test_a_name_that_is_the_id_of_another_footprint_joins_nothing(tmp_path, says):
    """House numbers beside ids that count from 1; a point in a footprint decides."""
    shapes = in_degrees(made_street(), 23.7, 37.9)
    numbers = {"name": ["1", "3", "5", "7", "9"], "id": ["1", "2", "3", "4", "5"]}
    path = write(tmp_path / "street.fgb", shapes, "EPSG:4326", **numbers)
    (tmp_path / "table.csv").write_text("name,storeys\n1,2\n3,4\n5,6\n")
    says(read_faults(path, inventory=tmp_path / "table.csv"))
    inner = shapely.point_on_surface(shapes[1])
    (tmp_path / "loc.csv").write_text(oed([("3", inner.x, inner.y, 7), ("4", 23.75, 37.9, 5), ("9", 23.75, 37.9, 5)]))
    assert [house.storeys for house in read_block(path, inventory=tmp_path / "loc.csv").houses] == [3, 7, 3, 3, 3]


def test_what_an_inventory_states_is_not_listed_as_that_of_a_part(tmp_path):
    shapes = in_degrees([*made_street(), shapely.box(1.0, 1.0, 5.0, 5.0)], 23.7, 37.9)
    columns = {"building": ["yes"] * 5 + [None], "building:part": [None] * 5 + ["yes"], "id": [*"abcdef"]}
    levels, height = ["3", "3", "3", "3", "3", "7"], [None] * 5 + ["21"]
    path = tmp_path / "osm.gpkg"
    table = frame(shapes, "EPSG:4326", **columns, **{"building:levels": levels, "height": height})
    pyogrio.write_dataframe(table.drop(columns=["name", "storeys"]), path)
    (tmp_path / "table.csv").write_text("name,height [m]\na,12\n")
    for inventory, listed in ((None, ["21 m"]), (tmp_path / "table.csv", [])):
        block = read_block(path, inventory=inventory)
        assert [each.value for each in block.filled if "part" in each.rule] == listed


def test_an_inventory_with_outlines_of_its_own_is_a_street(tmp_path):
    shapes = in_degrees(made_street(), 23.7, 37.9)
    head = "PortNumber,AccNumber,LocNumber,CountryCode,NumberOfStoreys,ConstructionCode,LocPerilsCovered,Geom\n"
    lines = [f'1,A,L{n},GR,{n + 2},5103,QEQ,"{shape.wkt}"\n' for n, shape in enumerate(shapes)]
    (tmp_path / "loc.csv").write_text(head + "".join(lines))
    row = only(read_block(tmp_path / "loc.csv"))
    assert [house.name for house in row.buildings] == [f"L{n}" for n in range(5)]
    assert row.gaps == pytest.approx(GAPS, abs=3e-4)
    assert row.buildings[0].mapped.longitude == pytest.approx(23.7 + 5.0 / 87.96e3, abs=1e-6)


def test_a_scene_of_uncertain_gaps_is_scanned_and_assessed_as_it_is(tmp_path):
    """P(contact) of a sample is the share of the motions that close more than its gap."""
    shapes = in_degrees(made_street()[:2], 15.0, 40.0)
    path = write(tmp_path / "street.gpkg", shapes, "EPSG:4326", **{"storeys": [3, 2], "typology": ["masonry"] * 2})
    tables = {"records": {"window": ["0 s", "6 s"], "pga": "0.5 g"}, "uncertain": {"samples": 4}}
    pr.block(path, tmp_path, Rules(resolution=0.01), records=["RSN6-180"], tables=tables)
    results = pr.scan(tmp_path / "street.toml")
    gaps = results["interface.1.gap"].values
    assert ((gaps > 0.01) & (gaps < 0.03)).all() and len(set(gaps)) == 4
    answer = pr.uncertainty(results)
    closing = results["peak_closing_free"].values.ravel()
    expected = [(closing > gap).mean() for gap in gaps]
    assert answer["contact_probability_of_sample"].values.ravel() == pytest.approx(expected)
    assert 0.0 < np.mean(expected) < 1.0, closing


ALONE = ASSETS.format("a", "b").replace("X,Y,TAX", "lon,lat,tax")
INVENTORIES = {"oed.csv": OED, "r2d.csv": R2D, "r2d.geojson": FEATURES, "assets.csv": ALONE, "metadata.xml": METADATA}
# By the name of the file: its reader, and how many copies are made.
FILES = {
    **{
        name: (read_block, 40)
        for name in ("street.csv", "street.geojson", "street.gpkg", "street.fgb", "street.parquet")
    },
    **{name: (read_inventory, 80) for name in INVENTORIES},
}


def sound(path: Path) -> None:
    """Write the file as it should be."""
    if path.name in INVENTORIES:
        exposure(path.parent)
        path.write_text(INVENTORIES[path.name], encoding="utf-8")
    elif path.suffix in (".csv", ".geojson"):
        path.write_bytes((STREETS / path.name).read_bytes())
    else:
        write(path, in_degrees(made_street(), 15.0, 40.0), "EPSG:4326")


def in_words(read: Callable[[Path], Any], path: Path) -> Any:
    try:
        return read(path)
    except BlockError as error:
        assert error.faults and all(len(fault) > 20 and fault.isprintable() for fault in error.faults), error.faults
        raise


@pytest.mark.parametrize("times", sweep([1, 5], 1))
@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused_in_words(tmp_path, name, times):
    path, (read, count) = tmp_path / name, FILES[name]
    sound(path)

    def check(found: Any) -> None:
        assert not isinstance(found, Block) or found.houses

    found = survey(path, lambda: in_words(read, path), check, count * times, longest=20_000)
    assert found["refused"] >= count * times / 10
