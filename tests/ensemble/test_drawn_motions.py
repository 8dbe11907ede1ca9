"""Motions that are drawn with samples of uncertain numbers: each sample is the scan of its numbers and motion."""

from __future__ import annotations

import json

import numpy as np
import pytest
from axes import same_scan
from sentences import refusal
from uncertain import PERIOD, RESTITUTION, THREE, uncertain_row_text, uncertain_text

from pounding_risk.ensemble.plan.plan import plan, validate
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.questions.rerun import rerun
from pounding_risk.results.check import check_scan
from pounding_risk.results.files import open_results
from pounding_risk.results.scene_axes import selected, with_axes
from pounding_risk.results.summary import summary
from pounding_risk.scene.reader import parse_scene

RECORDS = ["RSN6-180", "RSN1690-090"]
BOTH = ["as recorded", "reversed"]
SHORT = {"names": RECORDS, "window": ["0 s", "5 s"], "polarity": BOTH}


def drawn_text(samples=8, records=None, numbers=None, **more):
    """A pair whose samples have each one motion of two records in two polarities."""
    drawn = (THREE if numbers is None else numbers) | {"motions": "drawn"}
    return uncertain_text(drawn, samples=samples, records=records or SHORT, **more)


def narrow(dataset):
    """The dataset with texts as short as those that are left."""
    texts = [name for name in dataset.variables if dataset[name].dtype.kind == "U"]
    return dataset.assign_coords(
        {name: dataset[name].copy(data=np.array(dataset[name].values.tolist())) for name in texts}
    )


def set_as(here):
    """What sets the numbers and the motion of a sample."""
    motion = f'records.names=["{here["record"].item()}"]', f'records.polarity="{here["polarity"].item()}"'
    return [*json.loads(here.attrs.pop("overrides")), *motion]


def each_equals_a_scan(text, **options):
    """The scan of a scene with drawn motions, of which each sample is that of its numbers, record and polarity."""
    whole = scan(parse_scene(text), **options)
    for number in range(whole.sizes["sample"]):
        here = with_axes(selected(whole, [f"sample={number}"]))
        alone = scan(parse_scene(text, overrides=set_as(here)), **options)
        alone.attrs.pop("overrides")
        same_scan(narrow(here), alone)
    return whole


def test_each_sample_equals_the_scan_of_its_numbers_and_motion():
    whole = each_equals_a_scan(drawn_text(samples=8), check_fraction=0.3)
    assert whole["impact_count"].dims == ("sample", "contact_model", "gap", "yield_force", "interface")
    assert whole["record"].dims == whole["polarity"].dims == whole["record_pga"].dims == ("sample",)
    assert whole["sample"].attrs["drawn"] == "sobol, seed 1, each under one motion that is drawn with it"
    pairs = list(zip(whole["record"].values.tolist(), whole["polarity"].values.tolist(), strict=True))
    assert sorted(pairs) == sorted([(record, polarity) for record in RECORDS for polarity in BOTH] * 2)
    assert whole.attrs["motions_drawn"] == 4
    check_scan(whole, "it")
    assert summary(whole).counts["cases"] == 8 * 2


def test_levels_and_axes_stand_beside_drawn_motions(tmp_path):
    """Each sample runs every level of intensity, and every place along another axis; and samples are added to them."""
    numbers = {"building.left.damping": {"distribution": "uniform", "low": 0.02, "high": 0.1}}
    records = SHORT | {"intensity": {"measure": "pgv", "levels": ["10 cm/s", "40 cm/s"]}}
    text, fewer = (
        drawn_text(samples, records, numbers, axes={"interface.restitution": [0.5, 0.8]}) for samples in (4, 2)
    )
    whole = scan(parse_scene(text), check_fraction=0.0)
    assert whole["impact_count"].dims[:3] == ("sample", "interface.restitution", "intensity")
    here = with_axes(selected(whole, ["sample=2", "interface.restitution=0.8"]))
    alone = scan(parse_scene(text, overrides=set_as(here)), check_fraction=0.0)
    alone.attrs.pop("overrides")
    same_scan(narrow(here), alone)
    scan(parse_scene(fewer), tmp_path / "r.nc", check_fraction=0.0)
    same_scan(scan(parse_scene(text), tmp_path / "r.nc", check_fraction=0.0), whole)


def test_added_samples_equal_those_drawn_at_once(tmp_path):
    target = tmp_path / "r.nc"
    scan(parse_scene(drawn_text(4)), target, check_fraction=0.1)
    at_once = scan(parse_scene(drawn_text(8)), check_fraction=0.1)
    same_scan(scan(parse_scene(drawn_text(8)), target, check_fraction=0.1), at_once)
    same_scan(open_results(target), at_once)


@pytest.mark.complete
def test_a_row_of_storeys_under_drawn_motions(tmp_path):
    """Shards, a file and a second run of it have the same bits, and each sample those of a scan of its own."""
    text = uncertain_row_text({"method": "random", "motions": "drawn", "interface.restitution": RESTITUTION}, 3)
    study, target = parse_scene(text), tmp_path / "r.nc"
    whole = scan(study, check_fraction=0.0)
    for number in (2, 1):
        scan_shard(study, target, f"{number}/2", check_fraction=0.0)
    same_scan(scan(study, target, check_fraction=0.0), whole)
    assert rerun(target).same
    for number in range(3):
        here = with_axes(selected(whole, [f"sample={number}"]))
        values = json.loads(here.attrs["overrides"])
        polarity = f'records.polarity="{here["polarity"].item()}"'
        alone = scan(parse_scene(text, overrides=[*values, polarity]), check_fraction=0.0)
        assert np.array_equal(here["peak_contact_force"], alone["peak_contact_force"])
        assert np.array_equal(here["peak_closing_free"], alone["peak_closing_free"])


@pytest.mark.parametrize("method", ["sobol", "latin hypercube"])
def test_the_design_draws_every_motion_alike_often(method):
    """64 points share 7 × 2 motions: each is drawn 64/14 times, to within one; and none by where a number is."""
    numbers = parse_scene(drawn_text(64, numbers=THREE | {"method": method})).uncertain
    drawn = numbers.drawn_motions(7, 2)
    counts = np.bincount(2 * drawn.records + drawn.polarities, minlength=14)
    assert counts.sum() == 64 and counts.min() >= 3 and counts.max() <= 6
    first = numbers.points()[:, 0]
    assert abs(np.corrcoef(first, drawn.records)[0, 1]) < 0.25


def test_points_that_are_given_choose_the_motion_by_their_last_coordinate(says):
    """Of two records in two polarities each has a quarter of the coordinate."""
    numbers = {"interface.restitution": RESTITUTION}
    table = {"points": [[0.5, 0.1], [0.5, 0.3], [0.5, 0.99], [0.25, 1.0]]}
    study = parse_scene(drawn_text(4, numbers=numbers | table))
    drawn = study.uncertain.drawn_motions(2, 2)
    assert drawn.records.tolist() == [0, 0, 1, 1] and drawn.polarities.tolist() == [0, 1, 1, 1]
    assert parse_scene(study.to_toml()) == study
    says(refusal(parse_scene, drawn_text(4, numbers=numbers | {"points": [[0.5]] * 4})))


def test_a_plan_counts_one_motion_a_sample():
    checked = validate(parse_scene(drawn_text(300, numbers={"building.left.period": PERIOD})))
    assert checked.cases == 300 * 2 and "300 of sample" in dict(checked.summary())["cases"]
    assert "each under one motion" in dict(checked.summary())["samples"]
    assert plan(parse_scene(drawn_text(8))).seconds > 0.0


def test_a_hypercube_of_drawn_motions_cannot_be_added_to(tmp_path, says):
    numbers = {"building.left.period": PERIOD, "method": "latin hypercube"}
    scan(parse_scene(drawn_text(2, numbers=numbers)), tmp_path / "r.nc", check_fraction=0.0)
    says(refusal(scan, parse_scene(drawn_text(4, numbers=numbers)), tmp_path / "r.nc", check_fraction=0.0))
