"""The command `spectra`: from a scene or from records to a table, a dataset and a figure; what it refuses."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import commands
import numpy as np
import pytest
from scenes import scene_text

import pounding_risk as pr
from pounding_risk.assessment.spectra import shortfall
from pounding_risk.units import rounded

FEW = ["--num", "3", "--periods", "0.3 s", "0.9 s"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A folder of its own, with a scene."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(scene_text(records={"window": ["0 s", "5 s"], "pga": "0.5 g"}), encoding="utf-8")
    return tmp_path


run = partial(commands.run, "spectra")


def test_a_scene_gives_table_dataset_and_figure():
    done = run("scene.toml", *FEW, "-o", "s.nc", "--figure", "s.svg", "--percentile", "50", "--percentile", "84 %")
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    head = next(number for number, line in enumerate(lines) if line.split()[:2] == ["left", "[s]"])
    names = ["left [s]", "right [s]", "50 % [mm]", "84 % [mm]", "ABS [mm]", "SRSS [mm]", "DDC [mm]"]
    assert re.split(r" {2,}", lines[head].strip()) == names
    results = pr.open_results("s.nc")
    first = results.isel(left_period=0, right_period=0)
    shown = [*first["required_gap"].values, *first["separation"].sel(percentile=84, rule=["abs", "srss", "cqc"]).values]
    cells = lines[head + 1].split()
    assert cells[:2] == ["0.3", "0.3"]
    np.testing.assert_allclose([float(cell) for cell in cells[2:]], 1e3 * np.array(shown), rtol=5e-3)
    assert "1 motion at PGA 0.5 g (1 record as recorded)" in done.stdout and results.attrs["finding"] in done.stdout
    short = shortfall(results, "ubc97")
    (line,) = (line for line in lines if line.startswith("ubc97 "))
    assert re.split(r" {2,}", line)[1:5] == [
        "quoted",
        *(rounded(value, 3) for value in (100 * short.pairs, short.median, short.ratio)),
    ]
    assert "written: s.nc" in done.stdout and Path("s.svg").stat().st_size > 1000
    assert run("scene.toml", *FEW, "-o", "s.nc", "--set", "records.pga='0.25 g'").exit_code == 0
    np.testing.assert_allclose(pr.open_results("s.nc")["required_gap"].sel(percentile=50), 0.5 * first_gap(results))


def first_gap(results):
    return results["required_gap"].sel(percentile=50).values


def test_records_are_named_by_any_word():
    """Ids, recipes and files, each alone, in both polarities; options treat them as those of a scene would."""
    options = [
        "--window",
        "0 s",
        "5 s",
        "--pga",
        "0.5 g",
        "--motions",
        "-o",
        "s.nc",
        "--damping",
        "2 %",
        "--damping",
        "7 %",
    ]
    done = run("RSN6-180", *FEW, *options)
    assert done.exit_code == 0 and "2 motions at PGA 0.5 g (1 record in both polarities)" in done.stdout
    assert "damping      2 % beside 7 %" in done.stdout
    own = pr.spectra(
        pr.Records(["RSN6-180"], window=("0 s", "5 s"), pga="0.5 g", polarity=["as recorded", "reversed"]),
        periods=("0.3 s", "0.9 s"),
        num=3,
        damping=("2 %", "7 %"),
        motions=True,
    )
    np.testing.assert_array_equal(pr.open_results("s.nc")["required_gap_of_motion"], own["required_gap_of_motion"])
    assert run("ricker: pga=0.4 g, period=0.8 s", *FEW, "--tail", "2 s").exit_code == 0
    Path("mine.csv").write_text("".join(f"{np.sin(0.3 * k):.4f}\n" for k in range(400)))
    done = run("mine.csv", *FEW, "--unit", "m/s^2", "--dt", "0.02 s")
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "Missing argument 'SOURCE...'"),
        (["nothing.toml"], "nothing.toml"),
        (["nothing.AT2"], "nothing.AT2"),
        (["scene.toml", "RSN6-180"], "RSN6-180: stands beside the scene scene.toml"),
        (["scene.toml", "--pga", "0.3 g"], "--pga: is of records, and scene.toml states how its own are treated"),
        (["RSN6-180", "--set", "records.pga='1 g'"], "--set: changes a value of a scene"),
        (["fema-p695-farfield", "RSN6-180"], "RSN6-180: stands beside the record set fema-p695-farfield"),
        (["RSN6-180", "ricker: pga=0.4 g, period=0.8 s"], "names and generated are both given"),
        (["RSN6-180", "--periods", "2 s", "1 s"], "periods: 1 s follows 2 s"),
        (["RSN6-180", "--periods", "2 m", "1 s"], "--periods: "),
        (["RSN6-180", "--right-periods", "0 s", "1 s"], "--right-periods: "),
        (["RSN6-180", "--num", "1"], "num: 1 is not a number of periods"),
        (["RSN6-180", "--spacing", "even"], "spacing: "),
        (["RSN6-180", "--damping", "two"], "damping: "),
        (["RSN6-180", "--percentile", "100"], "--percentile"),
        (["RSN6-180", "--pga", "0.3 g", "--scale", "2"], "--pga and --scale are given"),
        (["RSN6-180", "--figure", "s.txt"], "--figure"),
        (["RSN6-180", "--rule", "italy", "--rule", "srss"], '--rule: "italy" is none of the table'),
        (["RSN6-180", "--rule", "srss"], "--rule: the figure shows two rules"),
        (["RSN6-180", "-o", "scene.toml"], "-o: scene.toml: the name must end in .nc"),
    ],
)
def test_bad_input_ends_with_status_2_and_a_sentence(words, sentence):
    assert sentence in commands.refused("spectra", *words)


def test_results_of_another_kind_are_not_replaced():
    Path("s.nc").write_text("a letter")
    done = run("scene.toml", *FEW, "-o", "s.nc")
    assert done.exit_code == 2 and "s.nc: is there already" in done.stderr and "--new" in done.stderr
    assert Path("s.nc").read_text() == "a letter"
    assert run("scene.toml", *FEW, "-o", "s.nc", "--new").exit_code == 0
