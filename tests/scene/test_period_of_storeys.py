"""T1 beside storeys: stiffnesses are scaled to the period, or those of a first mode in proportion to height."""

from math import pi, sin, sqrt

import numpy as np
import pytest
from axes import equals_the_loop
from scenes import rigid, scene_text, storeyed
from sentences import refusal
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk.cli import app
from pounding_risk.scene.reader import parse_scene

HEIGHTS = ["4 m", "3 m", "3 m"]
FLATS = storeyed("A", "200 t", None, HEIGHTS, period="0.8 s")
SCALED = storeyed("A", "200 t", ["3 MN/m", "2 MN/m", "2 MN/m"], HEIGHTS, period="0.8 s")


def scene(building=FLATS, **tables):
    return scene_text(building, rigid(), gap="20 mm", **tables)


@pytest.mark.parametrize("count", [1, 4, 30])
def test_a_uniform_profile_has_the_closed_form(count):
    """ω1 = 2 √(k/m) sin(π / (4 N + 2)). Both are of doubles: 1e-12 is far above the rounding of a singular value."""
    building = storeyed("A", "200 t", "7 kN/m", storeys=count, period="0.8 s")
    a = parse_scene(scene(building)).buildings[0]
    slowest = 2.0 * pi / 0.8
    assert a.stiffnesses == pytest.approx([2e5 * (slowest / (2.0 * sin(pi / (4 * count + 2)))) ** 2] * count, rel=1e-12)
    assert a.period == pytest.approx(0.8, rel=1e-12)


def test_ratios_stay_and_period_and_no_strength_moves():
    a = parse_scene(scene(SCALED | {"storey_strengths": "2 MN"})).buildings[0]
    assert a.stiffnesses[0] / a.stiffnesses[1] == pytest.approx(1.5, rel=1e-15)
    assert a.strengths == (2e6,) * 3 and a.period == pytest.approx(0.8, rel=1e-12)


def test_without_a_profile_the_first_mode_grows_with_height():
    """Oracle: the eigenvectors of K by numpy; 1e-10 is far above their rounding."""
    a = parse_scene(scene()).buildings[0]
    masses, _, stiffness = a.matrices()
    squares, vectors = np.linalg.eigh(stiffness / masses[0, 0])
    assert vectors[:, 0] / vectors[-1, 0] == pytest.approx(np.array([4.0, 7.0, 10.0]) / 10.0, rel=1e-10)
    assert 2.0 * pi / sqrt(squares[0]) == pytest.approx(0.8, rel=1e-10)


def test_a_class_of_python_a_file_and_what_they_write_are_one():
    study = parse_scene(scene())
    wall, contact = pr.RigidWall("wall"), pr.Interface("20 mm", "jankowski", "2.75e9 N/m^1.5", restitution=0.65)
    flats = pr.ShearBuilding("A", "200 t", storey_heights=["4 m", 3.0, 3.0], period=0.8)
    assert pr.Scene([flats, wall], [contact], pr.Records(["RSN6-180"])) == study.replace(name="scene")
    assert parse_scene(study.to_toml()) == study and 'period = "0.8 s"' in study.to_toml(as_written=True)


def test_modes_shows_it(tmp_path):
    (tmp_path / "scene.toml").write_text(scene(SCALED), encoding="utf-8")
    printed = CliRunner().invoke(app, ["modes", str(tmp_path / "scene.toml")], catch_exceptions=False).output
    assert "0.8" in next(line for line in printed.splitlines() if line.startswith("A "))
    assert pr.modes(tmp_path / "scene.toml")[0].periods[0] == pytest.approx(0.8, rel=1e-12)


@pytest.mark.parametrize("building", [FLATS, SCALED])
def test_it_is_an_axis_and_an_uncertain_number(building):
    axis = scene(building, records={"window": ["2 s", "4 s"]}, grid={'"building.A.period"': ["0.6 s", "1 s"]})
    whole = equals_the_loop(axis, check_fraction=0.0)
    assert whole["building_period"].values[:, 0] == pytest.approx([0.6, 1.0], rel=1e-12)
    sampled = f"{scene(building)}[uncertain]\nsamples = 4\n"
    sampled += '"building.A.period" = {distribution = "lognormal", dispersion = 0.2}\n'
    results = pr.scan(parse_scene(sampled, overrides=['records.window=["2 s", "3 s"]']))
    assert results["building_period"].values[:, 0] == pytest.approx(results["building.A.period"].values, rel=1e-12)


def test_neither_stiffness_nor_period_is_a_fault(says):
    says(refusal(parse_scene, scene(storeyed("A", "200 t", None, HEIGHTS))))
    says(refusal(parse_scene, scene(FLATS | {"period": "0.8"})), refusal(pr.ShearBuilding, "A", "200 t", period=1.0))
