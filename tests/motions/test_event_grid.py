"""Motions of a grid of sites: the nearest site's, with factors, units, components and their facts; damaged tables."""

import json

import numpy as np
import pytest
from commands import run
from damaged_tables import survey
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.errors import RecordError
from pounding_risk.motions.ensemble import read_ensemble, sources_named
from pounding_risk.motions.manifest import write_manifest
from pounding_risk.motions.request import RecordRequest
from pounding_risk.motions.sites.event_grid import read_grid
from pounding_risk.motions.sites.places import Place, distance, nearest
from pounding_risk.scene.reader import parse_scene

G = 9.80665
PLAIN = RecordRequest(processing="none", unit="g", sites="EventGrid.csv")
HERE = PLAIN._replace(place=Place(23.731, 37.981))


def wave(seed: int) -> list[float]:
    normal = np.random.default_rng(seed).standard_normal(200)
    return (0.1 * normal * np.hanning(200)).round(7).tolist()


@pytest.fixture
def grid(tmp_path):
    """Three sites; each has two of three motions, with other factors."""
    rows = ["site0.csv,23.73,37.98,350", "site1.csv,23.75,37.98,420", "site2.csv,24.90,37.98,600"]
    (tmp_path / "EventGrid.csv").write_text("\n".join(["GP_file,Longitude,Latitude,Vs30", *rows]) + "\n")
    (tmp_path / "site0.csv").write_text("TH_file,factor\nRSN1,1.0\nRSN2,2.5\n")
    (tmp_path / "site1.csv").write_text("TH_file,factor\nRSN2,1.5\nRSN3,0.5\n")
    (tmp_path / "site2.csv").write_text("TH_file,factor\nRSN1,2.0\nRSN1,3.0\n")
    for number in (1, 2):
        motion = {"dT": 0.02, "data_x": wave(number), "data_y": wave(10 + number), "data_z": wave(20)}
        (tmp_path / f"RSN{number}.json").write_text(json.dumps(motion, indent=1))
    rows = [f"{0.02 * at:.2f},{value}" for at, value in enumerate(wave(3))]
    (tmp_path / "RSN3.csv").write_text("\n".join(["time [s],acceleration [g]", *rows]) + "\n")
    return tmp_path / "EventGrid.csv"


def test_the_nearest_sites_motions_are_taken_with_their_factors(grid):
    ensemble = read_ensemble(HERE, grid.parent)
    assert [motion.name for motion in ensemble.motions] == ["RSN1#x", "RSN1#y", "RSN2#x", "RSN2#y"]
    assert [text.rpartition("/")[2] for text in ensemble.left_out] == ["RSN1#z is vertical", "RSN2#z is vertical"]
    first, third = ensemble.motions[0], ensemble.motions[2]
    np.testing.assert_allclose(first.acceleration, G * np.array(wave(1)), rtol=1e-12)
    np.testing.assert_allclose(third.acceleration, 2.5 * G * np.array(wave(2)), rtol=1e-12)
    assert third.record["factor"] == 2.5 and first.record["factor"] == 1.0
    assert third.record["site"] == "site0.csv" and third.record["vs30"] == 350.0
    assert third.record["site_distance_km"] == pytest.approx(0.1415, abs=2e-4)  # 0.001 degrees of both
    assert "site: site0.csv at 23.73, 37.98, 0.142 km from the place of the scene" in third.processing
    assert any("times 2.5 to the factor of site0.csv" in sentence for sentence in third.processing)
    assert not any("check the place" in flag for motion in ensemble.motions for flag in motion.flags)


def test_a_far_site_is_flagged_and_a_motion_twice_counts_once(grid):
    ensemble = read_ensemble(HERE._replace(place=Place(25.5, 37.98)), grid.parent)
    assert all("52.6 km from 25.5, 37.98: check the place" in " ".join(one.flags) for one in ensemble.motions)
    assert len(ensemble.motions) == 4 and len({motion.record["recording"] for motion in ensemble.motions}) == 1


def test_both_components_turn_to_a_direction_with_one_factor(grid):
    turned = read_ensemble(HERE._replace(direction=90.0), grid.parent).motions
    assert [motion.name for motion in turned] == ["RSN1#x+RSN1#y@90", "RSN2#x+RSN2#y@90"]
    np.testing.assert_allclose(turned[1].acceleration, 2.5 * G * np.array(wave(12)), atol=1e-12)
    assert turned[1].record["factor"] == 2.5 and turned[1].record["site"] == "site0.csv"
    assert "the azimuths are unknown: 90° counts from RSN2#x" in turned[1].flags


def test_units_come_from_the_scene_or_from_the_workflow(grid, says):
    bare = HERE._replace(unit="")
    says(refusal(read_ensemble, bare, grid.parent))
    (grid.parent / "input.json").write_text(json.dumps({"RegionalEvent": {"units": {"TH_file": "mps2"}}}))
    in_si = read_ensemble(bare, grid.parent).motions[0]
    np.testing.assert_allclose(in_si.acceleration, wave(1), rtol=1e-12)
    says(refusal(read_ensemble, HERE, grid.parent))


def test_motions_may_be_columns_and_a_site_may_be_named(grid):
    sources = list(sources_named("EventGrid.csv#site1", grid.parent, [], unit="g"))
    assert [source.record["component"] for source in sources][:3] == ["x", "y", "z"]
    np.testing.assert_allclose(sources[-1].trace.data, G * np.array(wave(3)), rtol=1e-9)
    assert len(list(sources_named("EventGrid.csv", grid.parent, [], unit="g"))) == 6 + 4 + 6
    with pytest.raises(RecordError, match=r"EventGrid.csv: has 3 sites, the first at 23.73, 37.98; write place = "):
        read_ensemble(PLAIN, grid.parent)


def test_a_selection_of_site_motions_survives_its_manifest(grid):
    motions = read_ensemble(HERE, grid.parent).motions
    write_manifest(motions, grid.parent / "chosen.csv")
    again = read_ensemble(PLAIN._replace(sites="", manifest="chosen.csv"), grid.parent).motions
    for one, other in zip(motions, again, strict=True):
        np.testing.assert_allclose(one.acceleration, other.acceleration, rtol=1e-14)


def scene(more: str = "", source: str = 'sites = "EventGrid.csv"') -> str:
    buildings = single("a", "40 t", "0.3 s"), single("b", "60 t", "0.5 s")
    text = scene_text(*buildings, law="linear", gap="20 mm", records={"names": None, "unit": "g"})
    return f"{text}{source}\n{more}\n"


PLACE = "place = {longitude = 23.75, latitude = 37.98}"


def test_a_scene_has_sites_and_its_place(grid):
    read = parse_scene(scene(PLACE), str(grid.parent / "scene.toml"))
    assert read.records.place == Place(23.75, 37.98) and PLACE in read.to_toml()
    built = pr.Records(sites="EventGrid.csv", place={"longitude": 23.75, "latitude": 37.98}, unit="g")
    assert built.request().place == read.records.place


KEYS = {
    "half a place": ("place = {longitude = 23.75}",),
    "a place beyond the pole": ("place = {longitude = 23.75, latitude = 123.0}",),
    "a letter for a longitude": ('place = {longitude = "x", latitude = 1}',),
    "a name of a place": ('place = "Athens"',),
    "an amplitude": ('pga = "0.3 g"',),
    "files beside sites": ('files = ["RSN1.json"]',),
    "a place without sites": (PLACE, 'files = ["RSN1.json"]'),
    "a grid that is not there": (PLACE, 'sites = "Grid.csv"'),
}


@pytest.mark.parametrize("words", KEYS)
def test_keys_that_do_not_fit_are_refused(grid, says, words):
    says(refusal(parse_scene, scene(*KEYS[words]), str(grid.parent / "scene.toml")))


DAMAGES = {
    "a letter for a latitude": ("EventGrid.csv", "37.98,420", "x,420"),
    "a site twice": ("EventGrid.csv", "23.75,37.98", "23.73,37.98"),
    "no latitude": ("EventGrid.csv", "Latitude", "Lat"),
    "a negative factor": ("site0.csv", "2.5", "-1"),
    "a motion that is not there": ("site0.csv", "RSN2", "RSN9"),
    "intensities for motions": ("site0.csv", "TH_file,factor", "PGA,SA"),
    "a step backwards": ("RSN1.json", '"dT": 0.02', '"dT": -0.02'),
    "a letter for a sample": ("RSN1.json", '"data_x": [', '"data_x": [\n"a",'),
    "a sample more": ("RSN1.json", '"data_x": [', '"data_x": [\n0.0,'),
    "an open bracket": ("RSN1.json", "]", ""),
    "another peak": ("RSN1.json", '"dT"', '"PGA_x": 9.0, "dT"'),
}


@pytest.mark.parametrize("words", DAMAGES)
def test_damaged_files_are_refused_with_their_line(grid, says, words):
    file, old, new = DAMAGES[words]
    path = grid.parent / file
    path.write_text(path.read_text().replace(old, new, 1))
    says(refusal(read_ensemble, HERE, grid.parent))


@pytest.mark.complete
def test_thousands_of_damaged_grids_end_in_a_sentence_or_in_places(grid):
    def check(sites):
        assert all(abs(one.place.latitude) <= 90.0 and np.isfinite(one.place).all() for one in sites)

    outcomes = survey(grid, lambda: read_grid(grid), check)
    assert min(outcomes["read"], outcomes["refused"]) > 200


def test_distances_are_those_of_the_sphere():
    assert distance(Place(0.0, 0.0), Place(180.0, 0.0)) == pytest.approx(np.pi * 6371.0088)
    assert distance(Place(10.0, 0.0), Place(10.0, 1.0)) == pytest.approx(np.pi / 180.0 * 6371.0088)
    assert distance(Place(179.9, 10.0), Place(-179.9, 10.0)) == pytest.approx(distance(Place(0, 10), Place(0.2, 10)))
    geodesic = pytest.importorskip("pyproj").Geod(ellps="WGS84").inv(23.73, 37.98, 22.94, 40.64)[2] / 1e3
    assert distance(Place(23.73, 37.98), Place(22.94, 40.64)) == pytest.approx(geodesic, rel=6e-3)
    assert nearest([Place(0, 0), Place(5, 0), Place(5, 1)], Place(4.8, 0.1)).position == 1


def test_the_commands_on_records_take_a_grid(grid, monkeypatch):
    monkeypatch.chdir(grid.parent)

    def said(*words):
        done = run("records", *words)
        assert not done.exit_code
        return done.stdout

    sites = said("info", "EventGrid.csv")
    assert "site0.csv" in sites and "350 m/s" in sites and "1 to 2.5" in sites
    one = said("info", "EventGrid.csv#23.9,37.98", "--unit", "g")
    assert "site1.csv at 23.75, 37.98, 13.1 km away" in one and "check the place" in one
    assert said("list", "--folder", "EventGrid.csv#site2", "--unit", "g").count("RSN1.json#x") == 2
