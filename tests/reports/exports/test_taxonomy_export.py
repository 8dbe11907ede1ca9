"""The table of GEM strings and OED codes: what it says of a row, held against the dataset and GEM's validator."""

import csv

import numpy as np
import pytest
from openquake.gem_taxonomy import GemTaxonomy
from scenes import BOTH, scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports.taxonomy import oed_code

NAMES = ["flats", "shop", "tower"]
INVENTORY = """id,lon,lat,taxonomy
flats,23.7,37.9,CR/LFM+CDL/H:2/RES/BPD/IRI+IRV(SOS)
tower,23.7,37.9,a tower
"""


@pytest.fixture(scope="module")
def results():
    """Three buildings, 5 mm and 600 mm apart, under two motions and their reverse."""
    text = scene_text(
        storeyed("flats", "100 t", "90 MN/m", "3 m", storeys=2, damping=0.05),
        single("shop", "150 t", "0.4 s", height="5 m", damping=0.05),
        single("tower", "900 t", "0.9 s", height="20 m", damping=0.05),
        records={"names": ["RSN6-180", "RSN753-000"], "polarity": BOTH, "window": ["0 s", "10 s"], "pga": "0.4 g"},
        interfaces=[{"gap": gap, "contact_model": "linear", "stiffness": "100 MN/m"} for gap in ("5 mm", "600 mm")],
    )
    return pr.scan(pr.read_scene(text))


def table(results, tmp_path, **asked):
    """The rows of the table by building, and what the export tells."""
    written = pr.export(results, "taxonomy", tmp_path / "buildings.csv", **asked)
    with written.files[0].open(newline="") as text:
        return {row["building"]: row for row in csv.DictReader(text)}, written.notes


def test_positions_codes_and_pounding_are_those_of_the_row(results, tmp_path):
    rows, told = table(results, tmp_path)
    assert list(rows) == NAMES
    assert [rows[name]["position"] for name in NAMES] == ["BP1", "BP1", "BPD"]  # 0.6 m is more than 4 % of 5 m
    assert [rows[name]["OED Pounding"] for name in NAMES] == ["1", "1", "3"]
    assert [rows[name]["nearest building"] for name in NAMES] == ["shop", "flats", "shop"]
    touched = (results["impact_count"].values.reshape(4, -1, 2) > 0).any(axis=1)  # (motions, interfaces)
    share = touched.mean(axis=0)
    assert share[0] > 0.5 and share[1] == 0.0
    values = [float(rows[name]["P(contact)"]) for name in NAMES]
    assert values == pytest.approx([share[0], share[0], share[1]])
    assert [rows[name]["POP"] for name in NAMES] == ["yes", "yes", "no"]
    assert rows["tower"]["amplitude"] and "16 %" in rows["tower"]["rule of POP"]
    assert any("BP3 is never written" in sentence for sentence in told)


def test_strings_are_those_of_the_standard_and_keep_the_inventory(results, tmp_path):
    inventory = tmp_path / "assets.csv"
    inventory.write_text(INVENTORY, encoding="utf-8")
    rows, told = table(results, tmp_path, inventory=inventory)
    assert rows["flats"]["GEM taxonomy"] == "CR/LFM+CDL/H:2/RES/BP1/IRI+IRV(SOS;POP)"
    assert (rows["flats"]["taxonomy of"], rows["tower"]["taxonomy of"]) == ("assets.csv", "the scene")
    assert rows["tower"]["GEM taxonomy"] == "BPD"
    standard = GemTaxonomy("3.3")
    for row in rows.values():
        assert standard.validate(row["GEM taxonomy"])[2]["is_canonical"]
    assert any("2 buildings without a GEM string in assets.csv: shop, tower" in sentence for sentence in told)


def test_an_inventory_without_names_is_refused(tmp_path):
    """Joined to a map, its lines are in another order than "building 1" and "building 2" of the map."""
    results = pr.scan(scene_text(*(single(f"building {n}", "100 t", "0.8 s", height="9 m") for n in (1, 2)), gap="1 m"))
    inventory = tmp_path / "assets.csv"
    inventory.write_text("lon,lat,taxonomy\n23.7,37.9,CR/LFM/H:2\n23.7,37.8,S/LFM/H:5\n", encoding="utf-8")
    with pytest.raises(PoundingError, match='has none of the buildings, such as "building 1"'):
        table(results, tmp_path, inventory=inventory)


def test_a_typology_is_material_and_system(tmp_path):
    """That of the scene as it was written and overridden: of every value stated no typology is left."""
    kinds = zip(("walls", "frame"), ("masonry", "steel_frame_ec8"), strict=True)
    rest = {"height": "9 m", "storeys": 3, "floor_mass": "100 t"}
    buildings = [{"name": name, "typology": typology, **rest} for name, typology in kinds]
    text = scene_text(*buildings, records={"window": ["0 s", "3 s"]}, gap="1 m")
    results = pr.scan(pr.read_scene(text, ['building.walls.typology="concrete_walls"']))
    rows, _ = table(results, tmp_path)
    assert [row["GEM taxonomy"] for row in rows.values()] == ["CR/LWAL/H:3/BPD", "S/LFM/H:3/BPD"]


def test_a_gap_that_is_asked_for_is_judged(results, tmp_path):
    rows, told = table(results, tmp_path, gap="3 m")
    assert {row["position"] for row in rows.values()} == {"BPD"}
    assert {row["OED Pounding"] for row in rows.values()} == {"5"}
    # Flats and shop were run at 5 mm, where they touch; shop and tower do not at 600 mm, and so do at no wider gap.
    assert [rows[name]["POP"] for name in NAMES] == ["not known", "not known", "no"]
    assert any("flats | shop: contact at a gap of 3 m is not known" in sentence for sentence in told)


def test_a_building_without_a_height_has_no_position(tmp_path):
    pair = single("frame", "100 t", "0.8 s"), single("wall", "200 t", "0.3 s")
    results = pr.scan(pr.read_scene(scene_text(*pair, gap="10 mm", records={"window": ["0 s", "6 s"]})))
    rows, told = table(results, tmp_path)
    assert {row["position"] for row in rows.values()} == {""}
    assert any("no position of frame, wall: the scene gives no height" in sentence for sentence in told)


@pytest.mark.parametrize(
    ("gap", "code"), [(0.0, 1), (0.249, 1), (0.25, 2), (0.5, 3), (0.999, 3), (1.0, 4), (2.0, 5), (30.0, 5)]
)
def test_codes_of_oed_are_those_of_its_list(gap, code):
    assert oed_code(gap) == code
    assert np.searchsorted([0.25, 0.5, 1.0, 2.0], gap, side="right") + 1 == code


@pytest.mark.complete
def test_pounding_is_that_of_any_gap_of_the_building(tmp_path):
    """A mass between two walls, of which either polarity strikes another one."""
    wall = {"rigid": True, "height": "5 m"}
    text = scene_text(
        {"name": "left", **wall},
        single("shop", "150 t", "0.4 s", height="5 m"),
        {"name": "right", **wall},
        records={"names": ["RSN6-180"], "polarity": BOTH, "window": ["0 s", "10 s"], "pga": "0.4 g"},
        interfaces=[{"gap": "30 mm", "contact_model": "linear", "stiffness": "100 MN/m"}] * 2,
    )
    results = pr.scan(text)
    touched = results["impact_count"].values.reshape(2, 2) > 0  # (polarities, interfaces)
    assert touched.sum(axis=0).tolist() == [1, 1] and touched.any(axis=1).all()
    rows, _ = table(results, tmp_path)
    assert [rows[name]["P(contact)"] for name in ("left", "shop", "right")] == ["0.5", "1", "0.5"]
    assert "2 of 2 do" in rows["shop"]["rule of POP"]
