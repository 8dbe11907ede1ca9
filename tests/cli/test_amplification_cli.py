"""The command `amplification`: table, dataset and figure of a scene or of records; what it refuses."""

from __future__ import annotations

import csv
from functools import partial
from pathlib import Path

import commands
import pytest
from scenes import scene_text

import pounding_risk as pr

PULSE = {"generated": [{"kind": "ricker", "pga": "0.4 g", "period": "0.8 s"}]}
FEW = ["--num", "3", "--num-gaps", "2"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A folder of its own, with a scene."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(scene_text(records=PULSE), encoding="utf-8")
    return tmp_path


run = partial(commands.run, "amplification")


def test_a_scene_gives_table_dataset_csv_and_figure():
    done = run("scene.toml", *FEW, "-o", "a.nc", "--table", "a.csv", "--figure", "a.svg", "--fixed", "left")
    assert done.exit_code == 0, done.output
    results = pr.open_results("a.nc")
    assert results.attrs["fixed"] == "left" and results.attrs["finding"] in done.stdout
    assert "T(right) / T(left)" in done.stdout and "gap / SRSS" in done.stdout and "contact in" in done.stdout
    with open("a.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3 * 2 * 2
    cell = results.isel(fixed_period=0, period_ratio=0, gap_share=0, building=1)
    assert rows[1]["building"] == "right"
    assert float(rows[1]["displacement_amplification_84"]) == float(
        cell["displacement_amplification"].sel(percentile=84)
    )
    assert float(rows[1]["gap"]) == float(cell["gap"])
    assert Path("a.svg").stat().st_size > 1000 and "written: a.nc" in done.stdout


def test_records_at_several_periods_and_gaps():
    words = ["ricker: pga=0.4 g, period=0.8 s", *FEW, "--period", "0.4 s", "--period", "0.8 s", "--mass-ratio", "2"]
    done = run(*words, "--gaps", "1 cm", "5 cm", "--percentile", "84")
    assert done.exit_code == 0, done.output
    assert "contact stereomechanical; its jumps have no finite acceleration" in done.stdout
    assert "m(left) / m(right) = 2" in done.stdout and "beside" in done.stdout and "gap / SRSS" not in done.stdout


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["scene.toml", "--gaps", "1 s", "2 s"], "--gaps: "),
        (["scene.toml", "--period", "1 m"], "--period: "),
        (["scene.toml", "--pga", "0.3 g"], "--pga: is of records, and scene.toml states how its own are treated"),
        (["scene.toml", "--percentile", "100"], "--percentile"),
        (["scene.toml", "--share-of", "asce"], '--share-of: "asce" is none (did you mean "asce7"?)'),
        (["scene.toml", "--table", "a.txt"], "--table"),
        (["scene.toml", "--mass-ratio", "2"], "--mass-ratio: the scene has the masses"),
    ],
)
def test_bad_input_ends_with_status_2_and_a_sentence(words, sentence):
    assert sentence in commands.refused("amplification", *words)
