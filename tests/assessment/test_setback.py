"""Setbacks from a property line: counted displacements of one building, its bounds, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from scenes import BOTH, scene_text, single
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk import cli
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.motions import intensity as measures
from pounding_risk.motions.read import read_motion
from pounding_risk.results.files import save
from pounding_risk.scene.reader import parse_scene

RECORDS = ["RSN6-180", "CCC-HN1", "NAPA-HNE"]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Three records in both polarities; no gap so wide is ever closed, so that nothing is simulated."""
    sides = (single(name, "10 t", f"{period} s", damping=0.05) for name, period in (("left", 0.5), ("right", 0.8)))
    records = {"names": RECORDS, "polarity": BOTH}
    return scan(parse_scene(scene_text(*sides, law="linear", gap="9 m", records=records)), check_fraction=0.0)


def peaks_of(period: float) -> np.ndarray:
    """Spectral displacement of each record, from the motions alone."""
    motions = [read_motion(name) for name in RECORDS]
    return np.array(
        [measures.response_spectra([one.acceleration], one.dt, [period]).displacement[0, 0] for one in motions]
    )


def test_a_setback_is_the_buildings_own_peak_displacement(results):
    """Every motion stays within the setback of all: the largest spectral displacement, and polarity changes nothing."""
    left, right = pr.setbacks(results, percentile="99 %")
    for one, period in ((left, 0.5), (right, 0.8)):
        largest = peaks_of(period).max()
        assert one.motions == 6 and one.independent == pytest.approx(3.0)
        # Both find the maximum between samples, each in its own way: 1e-9 apart, and the percentile may interpolate.
        assert one.required[-1].high == pytest.approx(largest, rel=1e-7)
        assert one.distance <= largest * (1.0 + 1e-7) and not one.required[-1].bounded
    assert [one.building for one in (left, right)] == ["left", "right"]


def test_a_rigid_building_needs_no_setback(results):
    still = results.copy()
    still["peak_displacement_free"] = results["peak_displacement_free"] * xr.DataArray([0.0, 1.0], dims="building")
    assert [one.distance > 0.0 for one in pr.setbacks(still)] == [False, True]


def run(*words: object):
    return CliRunner().invoke(cli.app, ["assess", *map(str, words)], prog_name="pounding-risk")


def test_the_command_prints_and_writes_the_setbacks(results, tmp_path):
    save(results, tmp_path / "r.nc")
    answer = run(tmp_path / "r.nc", "--setback", "--percentile", "90 %", "-o", tmp_path / "s.json")
    assert answer.exit_code == 0, answer.output
    expected = pr.setbacks(results, percentile="90 %")
    rows = [line.split() for line in answer.output.splitlines() if " 90 " in line and " to " in line]
    for one, row in zip(expected, rows, strict=True):
        assert row[0] == one.building
        assert one.distance <= 1e-3 * float(row[2]) <= one.distance * 1.01  # rounded up to three digits
    for words in ("to whichever side it is larger", "No neighbour is there", "not δM of a code"):
        assert words in answer.output
    written = json.loads((tmp_path / "s.json").read_text())
    assert [one["building"] for one in written["setbacks"]] == ["left", "right"] and len(written["assumed"]) == 3


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--gap", "30 mm"), "--gap: is not taken with --setback"),
        (("--hazard", "h.csv"), "--hazard: is not taken with --setback"),
        (("--figure", "f.png"), "--figure: is not taken with --setback"),
        (("--percentile", "30 %"), '--percentile: "30 %" is 30 %'),
    ],
)
def test_what_a_setback_does_not_take_is_refused(results, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    save(results, "r.nc")
    answer = run("r.nc", "--setback", *words)
    assert answer.exit_code == 2 and told in answer.stderr


def test_a_dataset_that_is_none_is_refused(results):
    with pytest.raises(PoundingError, match="the dataset: has no peak_displacement_free"):
        pr.setbacks(results.drop_vars("peak_displacement_free"))
    with pytest.raises(PoundingError, match="no motion of the dataset moves the ground and has a finite response of"):
        pr.setbacks(results.assign(peak_displacement_free=results["peak_displacement_free"] * np.nan))
