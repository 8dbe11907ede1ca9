"""Fragilities for pelicun: the curves of the assessment in its form, which it loads and whose states it samples."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from scipy import stats
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.units import STANDARD_GRAVITY

FRAME = "PND.damage.floor_displacement_of_a_frame"


@pytest.fixture(scope="module")
def written(results, tmp_path_factory):
    """Demands at 0.3 g, and fragilities against PGA."""
    return pr.export(results, "pelicun", tmp_path_factory.mktemp("p") / "demands", pga="0.3 g", intensity="pga")


def rows_of(written, name="fragility.csv") -> list[dict[str, str]]:
    """The rows of a written table by the names of its columns."""
    (file,) = (file for file in written.files if file.name == name)
    with file.open(newline="") as text:
        return list(csv.DictReader(text))


def test_medians_and_dispersions_are_those_of_the_assessment(results, damaged, written):
    rows = {row["ID"]: row for row in rows_of(written)}
    one = pr.assess(results, intensity="pga").interfaces[0]
    expected = {}
    for curve in one.fragility:
        if curve.what == "contact" and curve.gap == one.gap:
            expected["PND.contact.a_frame_wall_gap_60_mm"] = [(curve.median, curve.dispersion)]
        if curve.what == "yield" and not curve.fault:
            name = f"PND.yield.a_frame_wall_gap_60_mm_viscous_elastoplastic_FE_{curve.yield_force / 1e3:g}_kN"
            expected[name] = [(curve.median, curve.dispersion)]
    for side in ("with", "without"):
        states = [damaged.sel(state=state, pounding=side) for state in ("slight, cracks", "moderate")]
        expected[f"{FRAME}.{side}"] = [(float(state["median"]), float(state["dispersion"])) for state in states]
    blow = damaged.sel(state="blow", pounding="with")
    expected["PND.damage.contact_force.with"] = [(float(blow["median"]), float(blow["dispersion"]))]
    assert set(rows) == set(expected)
    for name, curves in expected.items():
        row = rows[name]
        assert (row["Demand-Type"], row["Demand-Unit"]) == ("Peak Ground Acceleration", "g")
        # Not directional would be 1.2 times the demand.
        assert (row["Incomplete"], row["Demand-Offset"], row["Demand-Directional"]) == ("0", "0", "1")
        for number, (median, dispersion) in enumerate(curves, start=1):
            assert row[f"LS{number}-Family"] == "lognormal"
            assert float(row[f"LS{number}-Theta_0"]) * STANDARD_GRAVITY == pytest.approx(median, rel=1e-14)
            assert float(row[f"LS{number}-Theta_1"]) == dispersion
        assert len(curves) == 2 or row["LS2-Theta_0"] == ""
    words = json.loads(written.files[-1].read_text(encoding="utf-8"))
    assert set(words) == {"_GeneralInformation", *expected}
    assert "with pounding" in words[f"{FRAME}.with"]["LimitStates"]["LS2"]["DS2"]["Description"]


@pytest.mark.complete
def test_the_demand_of_fragilities_is_in_every_file_of_demands(results, written, tmp_path):
    for name in ("a-frame-with-contact.csv", "wall-without-contact.csv"):
        units, *rows = rows_of(written, name)
        assert units["1-PGA-0-1"] == "mps2"
        assert [float(row["1-PGA-0-1"]) for row in rows] == pytest.approx([0.3 * STANDARD_GRAVITY] * 8, rel=1e-12)
    other = pr.export(results, "pelicun", tmp_path / "sa", pga="0.3 g", intensity="sa(1 s)")
    assert {row["Demand-Type"] for row in rows_of(other)} == {"Spectral Acceleration|1"}
    _, *rows = rows_of(other, "a-frame-with-contact.csv")
    at = results["record_spectral_acceleration"].interp(period=1.0)  # linear: near enough to tell a wrong motion
    expected = np.repeat((at / results["record_pga"]).values, 2) * 0.3 * STANDARD_GRAVITY
    assert [float(row["1-SA_1-0-1"]) for row in rows] == pytest.approx(expected, rel=0.02)


def test_damage_states_alone(results, damaged, tmp_path):
    written = pr.export(damaged, "pelicun", tmp_path / "of-damage")
    assert [file.name for file in written.files] == ["fragility.csv", "fragility.json"]
    assert {row["ID"].split(".")[1] for row in rows_of(written)} == {"damage"}
    asked = {"pga": "0.3 g", "intensity": "pga", "of": "yield"}
    assert len(rows_of(pr.export(results, "pelicun", tmp_path / "of-yielding", **asked))) == 2
    # One side without a curve is told.
    blow = damaged.sel(state=["blow"])
    told = pr.export(blow, "pelicun", tmp_path / "of-blow", of="damage").notes
    assert any(sentence.startswith("damage without pounding: the results hold no fragility") for sentence in told)


@pytest.mark.parametrize(("to", "name"), sweep([("nrml", "f.xml"), ("pelicun", "folder")], ("pelicun", "folder")))
def test_the_method_of_damage_states_is_an_option_and_is_said(results, damaged, to, name, tmp_path):
    """Both formats alike: the method that `damage` was run with, and no amplitude, which such curves need not."""
    written = pr.export(results, to, tmp_path / name, of="damage", intensity="pga", method="ida")
    said = "curves of damage states: ida, maximum likelihood of the intensity"
    assert any(sentence.startswith(said) for sentence in written.notes), written.notes
    usual = pr.export(damaged, to, tmp_path / f"usual-{name}", of="damage").notes
    assert any(sentence.startswith("curves of damage states: stripes, maximum likelihood of") for sentence in usual)
    if to == "pelicun":
        assert any(each.startswith("no demands are written") and "--pga" not in each for each in written.notes)
        curve = pr.damage(results, intensity="pga", method="ida").sel(state="moderate", pounding="with")
        (row,) = (row for row in rows_of(written) if row["ID"] == f"{FRAME}.with")
        assert float(row["LS2-Theta_0"]) * STANDARD_GRAVITY == pytest.approx(float(curve["median"]), rel=1e-14)


def test_pelicun_samples_the_states_of_the_curves(written):
    """Where it is installed, which no extra of this project brings: demands and fragilities to damage, end to end."""
    assessment = pytest.importorskip("pelicun.assessment")
    pandas = pytest.importorskip("pandas")
    folder, rows, blocks = written.files[0].parent, rows_of(written), 500
    asked = assessment.Assessment({"PrintLog": False, "Seed": 1})
    asked.stories = 1
    asked.demand.load_sample(str(folder / "a-frame-with-contact.csv"))
    names = [row["ID"] for row in rows]
    about = {"Units": "ea", "Location": "0", "Direction": "1", "Theta_0": 1.0, "Blocks": blocks}
    asked.asset.load_cmp_model({"marginals": pandas.DataFrame(about, index=pandas.Index(names))})
    asked.asset.generate_cmp_sample(8)
    asked.damage.load_model_parameters([str(folder / "fragility.csv")], set(names))
    asked.damage.calculate()
    sample = asked.damage.ds_model.sample
    for row in rows:
        curves = [(float(row[f"LS{n}-Theta_0"]), float(row[f"LS{n}-Theta_1"])) for n in (1, 2) if row[f"LS{n}-Theta_0"]]
        reached = [1.0, *(stats.lognorm.cdf(0.3, dispersion, scale=median) for median, dispersion in curves), 0.0]
        for state, share in enumerate(-np.diff(reached)):
            of_motions = sample[(row["ID"], "0", "1", "0", str(state))].mean()  # share of the blocks
            error = np.sqrt(share * (1.0 - share) / (8 * blocks))
            assert of_motions == pytest.approx(share, abs=4.0 * error + 1e-12)
