"""Commands on a scene with axes of its numbers, and `--select` on its results."""

from __future__ import annotations

import json

import pytest
from axes import AXES, pair_text
from typer.testing import CliRunner
from uncertain import uncertain_text

from pounding_risk import cli

PLACE = ["--select", "building.left.period=0.5 s", "--select", "interface.restitution=0.8"]
PLACE += ["--select", "building.left.mass=600 t"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("axes")
    (folder / "s.toml").write_text(pair_text(AXES), encoding="utf-8")
    result = CliRunner().invoke(cli.app, ["scan", str(folder / "s.toml"), "-o", str(folder / "r.nc")])
    assert result.exit_code == 0, result.output
    return folder


def run(*words):
    return CliRunner().invoke(cli.app, list(map(str, words)))


def test_assess_prints_and_writes_every_place_and_select_the_whole_assessment(folder):
    told = run("assess", folder / "r.nc", "--gap", "30 mm", "-o", folder / "a.json")
    assert told.exit_code == 0 and told.output.count("30 mm") == 12
    assert "building.left.period" in told.output and "P(contact)" in told.output
    written = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert len(written["places"]) == 12 and written["places"][0]["building.left.period"] == 0.3
    one = run("assess", folder / "r.nc", *PLACE)
    assert one.exit_code == 0 and "building.left.period = 0.5 s" in one.output and "left | right" in one.output


def test_summary_of_some_places(folder):
    assert "48" in run("summary", folder / "r.nc").output
    assert "(building.left.period = 0.5 s)" in run("summary", folder / "r.nc", *PLACE[:2]).output


@pytest.mark.parametrize("words", [["report"], ["view"], ["separations"], ["assess", "--figure", "f.png"]])
def test_commands_that_take_one_place_say_so(folder, words):
    told = run(words[0], folder / "r.nc", *words[1:])
    assert told.exit_code == 2
    assert "--select 'building.left.period=0.3 s'" in told.stderr


def test_separations_of_one_place(folder):
    told = run("separations", folder / "r.nc", *PLACE)
    assert told.exit_code == 0, told.output


def test_a_figure_of_several_scenes_is_refused_before_the_scan(folder):
    told = run("scan", folder / "s.toml", "-o", folder / "q.nc", "--figure", folder / "f.png")
    assert told.exit_code == 2 and "--figure: shows one scene" in told.stderr
    assert not (folder / "q.nc").exists()


def test_samples_are_counted_added_and_chosen(tmp_path):
    scene, results = tmp_path / "s.toml", tmp_path / "r.nc"
    scene.write_text(uncertain_text(), encoding="utf-8")
    told = run("validate", scene)
    assert told.exit_code == 0
    assert "4, sobol, seed 1" in told.output and "lognormal, median 0.5 s, dispersion 0.2" in told.output
    assert "3 samples are no power of two" in run("validate", scene, "--set", "uncertain.samples=3").output
    assert "8 = 2 of sample × 2 polarities × 2 gaps" in run("scan", scene, "--plan", "--samples", "2").output
    for count in ("2", "3"):
        told = run("scan", scene, "--samples", count, "-o", results)
        assert told.exit_code == 0, told.output
    told = run("summary", results, "--select", "sample=2")
    assert told.exit_code == 0 and "sample = 2" in told.output
    refused = run("scan", scene, "--samples", "2", "-o", results)
    assert refused.exit_code == 2 and "uncertain.samples: was 3, is 2" in refused.stderr
    assert "the uncertain numbers are at the values that the scene states" in run("modes", scene).output


def test_samples_of_a_scene_without_uncertain_numbers_are_refused(folder):
    told = run("scan", folder / "s.toml", "--samples", "8", "-o", folder / "u.nc")
    assert told.exit_code == 2 and "uncertain: no number is uncertain; write" in told.stderr
