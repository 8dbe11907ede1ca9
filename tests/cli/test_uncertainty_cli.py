"""The command `uncertainty`, and `assess` of a dataset with samples of uncertain numbers."""

from __future__ import annotations

import pytest
from commands import refused, run
from scenes import BOTH, scene_text, storeyed

import pounding_risk as pr
from pounding_risk.scene.toml import write_toml

NUMBERS = {"building.left.period": {"distribution": "lognormal", "dispersion": 0.2}}
PULSES = [{"kind": "ricker", "pga": "0.4 g", "period": f"{period} s"} for period in (0.5, 0.8, 1.2)]
SCENE = {"law": "linear", "gap": "60 mm", "records": {"generated": PULSES, "polarity": BOTH}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("uncertain")
    text = f"{scene_text(**SCENE)}\n{write_toml({'uncertain': {'samples': 8} | NUMBERS})}"
    (folder / "s.toml").write_text(text, encoding="utf-8")
    result = run("scan", folder / "s.toml", "-o", folder / "r.nc")
    assert result.exit_code == 0, result.output
    return folder


def test_a_scene_gives_verdict_tables_dataset_and_figure(folder):
    files = folder / "u.nc", folder / "u.svg"
    told = run("uncertainty", folder / "s.toml", "--tornado", "--sobol", 8, "-o", files[0], "--figure", files[1])
    assert told.exit_code == 0, told.output
    dataset = pr.open_results(files[0]).isel(interface=0)
    share = f"P(contact) at a gap of 60 mm is {100 * float(dataset['judged_probability']):.0f} %"
    assert share in told.stdout and dataset["narrowing"].item() in told.stdout
    for words in (
        "8, sobol, seed 1",
        "total share",
        "at 90 %",
        "Fragility of contact against pga",
        "No run of contact",
    ):
        assert words in told.stdout, words
    assert files[1].stat().st_size > 1000
    more = run("uncertainty", folder / "s.toml", "--samples", 16, "--set", "interface.gap='70 mm'")
    assert "over 16 samples" in more.stdout and "at a gap of 70 mm" in more.stdout
    assert "total share" not in more.stdout


def test_a_dataset_is_read_and_assess_says_the_same(folder):
    told = run("uncertainty", folder / "r.nc", "--output", "peak_penetration", "--target", "20 %")
    assert told.exit_code == 0, told.output
    assert "in the variance of peak penetration" in told.stdout
    assert "at 90 %" not in told.stdout and "No run of contact" not in told.stdout
    usual = run("uncertainty", folder / "r.nc", "--gap", "70 mm")
    assessed = run("assess", folder / "r.nc", "--gap", "70 mm", "--figure", folder / "a.svg")
    assert assessed.exit_code == 0, assessed.output
    assert all(line in assessed.stdout for line in usual.stdout.splitlines())
    assert "--select sample=0" in assessed.stdout and (folder / "a.svg").exists()
    one = run("assess", folder / "r.nc", "--select", "sample=0")
    assert one.exit_code == 0 and "left | right" in one.stdout


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["uncertainty", "r.nc", "--tornado"], "--tornado: each number is moved alone"),
        (["uncertainty", "r.nc", "--set", "interface.gap='1 mm'"], "--set: changes a value of a scene"),
        (["uncertainty", "r.nc", "--sobol", "8"], "sobol: of a scene alone"),
        (["uncertainty", "s.toml", "--output", "peak"], "output: "),
        (["assess", "r.nc", "--hazard", "h.csv"], "--hazard: is not joined with samples"),
        (["assess", "r.nc", "-o", "a.json"], "pounding-risk uncertainty RESULTS -o uncertainty.nc"),
    ],
)
def test_what_is_refused_is_told(folder, words, sentence, monkeypatch):
    monkeypatch.chdir(folder)
    assert sentence in refused(*words)


@pytest.mark.complete
def test_every_interface_of_a_row_has_its_own_part(folder):
    buildings = (storeyed("A", "200 t", "9e7 N/m", storeys=2), storeyed("B", "300 t", "3e7 N/m", storeys=2))
    row = scene_text(*buildings, storeyed("C", "150 t", "3e8 N/m", storeys=2), **SCENE)
    numbers = {"building.B.damping": {"distribution": "lognormal", "median": 0.05, "dispersion": 0.4}}
    (folder / "row.toml").write_text(f"{row}\n{write_toml({'uncertain': {'samples': 4} | numbers})}", encoding="utf-8")
    told = run("uncertainty", folder / "row.toml", "--figure", folder / "row.svg")
    assert told.exit_code == 0, told.output
    assert "\nA | B\n" in told.stdout and "\nB | C\n" in told.stdout
    assert "neighbours further along the row may push" in told.stdout
