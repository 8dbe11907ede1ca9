"""Samples of uncertain numbers in a scan: each is the scene that `--set` makes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from axes import equals_the_loop, same_scan
from scenes import scene_text
from sentences import refusal
from uncertain import RESTITUTION, THREE, uncertain_row_text, uncertain_text

import pounding_risk as pr
from pounding_risk.ensemble.plan.plan import plan, validate
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.questions.rerun import rerun
from pounding_risk.results.check import kind_of
from pounding_risk.results.files import open_results
from pounding_risk.results.scene_axes import at_one_place, axes_of, selected
from pounding_risk.scene.reader import parse_scene


def test_a_scan_of_samples_equals_a_loop_of_set():
    """Every variable, bit by bit, and the attributes: notes on the distributions are those of the whole alone."""
    wide = {"interface.restitution": {"distribution": "normal", "mean": 0.65, "deviation": 0.3}}
    whole = equals_the_loop(uncertain_text(THREE | wide, samples=3), check_fraction=0.3)
    assert whole["impact_count"].dims[0] == "sample" and list(whole["sample"]) == [0, 1, 2]
    assert whole["building.left.period"].dims == ("sample",) and whole["building.left.period"].attrs["units"] == "s"
    assert whole["building.left.period"].attrs["distribution"] == "lognormal, median 0.5 s, dispersion 0.2"
    assert whole["sample"].attrs["drawn"] == "sobol, seed 1"
    notes = json.loads(whole.attrs["notes"])
    assert any("which leaves out 13.7 % of it" in note for note in notes)
    assert any("3 samples are no power of two" in note for note in notes)
    alone = json.loads(at_one_place(whole.isel(sample=1)).attrs.get("notes", "[]"))
    assert not any("leaves out" in note or "power of two" in note for note in alone)
    assert kind_of(whole) == "scan"


@pytest.mark.complete
def test_samples_stand_beside_axes_and_are_chosen_by_number(says):
    text = uncertain_text(
        {"building.left.damping": {"distribution": "uniform", "low": 0.02, "high": 0.1}},
        samples=2,
        axes={"interface.restitution": [0.5, 0.8]},
    )
    whole = equals_the_loop(text, check_fraction=0.0)
    assert whole["impact_count"].dims[:2] == ("sample", "interface.restitution")  # damping changes the free motion
    one = selected(whole, ["sample=1", "interface.restitution=0.8"])
    same_scan(at_one_place(one), at_one_place(whole.isel(sample=1).sel({"interface.restitution": 0.8})))
    says(refusal(selected, whole, ["sample=2"]), refusal(pr.assess, whole))


@pytest.mark.complete
def test_gaps_that_are_drawn_equal_a_loop_of_set():
    """The label of the gap is the stated one, beside that of each sample; of one sample it is its own."""
    gap = '[uncertain]\nsamples = 3\n"interface.gap" = {distribution = "uniform", low = "8 mm", high = "12 mm"}\n'
    apart = ("scene_resolved", "scene_sha256")  # in which the gap of the grid stands elsewhere
    whole = equals_the_loop(scene_text(records={"window": ["0 s", "6 s"]}) + gap, apart, check_fraction=0.0)
    assert list(whole["gap"]) == [0.01] and whole["interface_gap"].dims == ("sample", "gap", "interface")
    assert np.array_equal(whole["interface_gap"].values.ravel(), whole["interface.gap"])
    assert len(set(whole["peak_contact_force"].values.ravel())) > 1


def test_contacts_beyond_a_table_are_counted_from_the_gap_of_each_sample():
    """As many as have a deeper penetration, by the solver; with the stated gap there would be one more."""
    gap = {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}
    end, table = 0.1345, {"penetration": ["0 mm", "134.5 mm"], "force": ["0 kN", "2690 kN"]}
    law = {"law": "tabulated", "stiffness": None, "restitution": None, "table": table}
    whole = pr.scan(uncertain_text({"interface.gap": gap}, 3, grid={"gap": None}, **law), check_fraction=0.0)
    (note,) = [note for note in pr.summary(whole).notes if "passes the table's last point" in note]
    beyond = int((whole["peak_penetration"] > end).sum())
    assert f", in {beyond} cases: " in note and 0 < beyond < whole["peak_penetration"].size


def test_gaps_of_a_row_that_are_drawn_equal_a_loop_of_set():
    gap = {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}
    text = uncertain_row_text({'interface."A | B".gap': gap}, 2, {"gap": None}, 2)
    whole = equals_the_loop(text, ("scene_resolved", "scene_sha256"), check_fraction=0.0)
    assert whole["interface_gap"].dims == ("sample", "gap", "interface")


def test_files_and_shards_have_the_same_bits_and_are_run_again(tmp_path):
    """With words among the values of a number: of 8 Sobol points each quarter of the probability has two."""
    words = {"interface.restitution": {"distribution": "discrete", "values": ["concrete", 0.6], "weights": [1, 3]}}
    study, target = parse_scene(uncertain_text(THREE | words, samples=8)), tmp_path / "r.nc"
    eight = scan(study, check_fraction=0.1)
    assert sorted(eight["interface.restitution"].values) == ["0.6"] * 6 + ["concrete"] * 2
    for number in (2, 1):
        scan_shard(study, target, f"{number}/2", check_fraction=0.1)
    same_scan(scan(study, target, check_fraction=0.1), eight)
    assert axes_of(open_results(target)) == study.axes
    assert rerun(target).same


@pytest.mark.complete
def test_a_plan_counts_the_samples_and_tells_the_distributions():
    study = parse_scene(uncertain_text(THREE | {"method": "random", "seed": 4}, samples=300))
    checked = validate(study)
    assert checked.shape["sample"] == 300 and checked.cases == 300 * 2 * 2
    words = dict(checked.summary())
    assert words["samples"] == "300, random, seed 4"
    assert words["interface.restitution"] == "uniform from 0.4 to 0.8"
    assert "300 of sample" in words["cases"]
    assert plan(parse_scene(uncertain_text(samples=8))).seconds > 0.0


def test_calls_of_one_scene_say_how_they_take_the_stated_values(says):
    study = parse_scene(uncertain_text())
    (note,) = [note for note in json.loads(pr.simulate(study).attrs["notes"]) if "uncertain" in note]
    says(note, [refusal(call, study) for call in (pr.compare, pr.effects, pr.accuracy)])


@pytest.mark.complete
def test_a_row_of_samples_counts_its_parts():
    numbers = {"building.A.storey_stiffnesses": {"distribution": "lognormal", "dispersion": 0.2}}
    whole = equals_the_loop(uncertain_row_text(numbers | {"interface.restitution": RESTITUTION}, 2), check_fraction=0.0)
    assert sum(json.loads(whole.attrs["parts"]).values()) > 0
