"""Axes of numbers of a scene: a scan of all places equals a loop of `--set`, and what the scenes share is made once."""

import json
import pickle

import numpy as np
import pytest
from axes import AXES, equals_the_loop, pair_text, row_text, same_scan
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from sentences import refusal

from pounding_risk.ensemble import pair_job, row_job
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.job_choice import job_of
from pounding_risk.ensemble.plan.plan import plan, validate
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.errors import SceneError
from pounding_risk.questions.rerun import rerun
from pounding_risk.results.files import open_results
from pounding_risk.scene import variants as scenes
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.convert import convert

COUNT = 3 * 2 * 2  # places along `AXES`


@pytest.mark.complete
def test_a_product_of_axes_equals_a_loop_of_set():
    """Every variable, bit by bit, its attributes, and those of the dataset: the scene of the place among them."""
    whole = equals_the_loop(pair_text(AXES), check_fraction=0.3)
    # Axes that change the motion without contact come first; along the others that motion is one.
    assert whole["impact_count"].dims[:3] == ("building.left.period", "interface.restitution", "building.left.mass")
    assert "interface.restitution" not in whole["peak_closing_free"].dims
    assert whole["building_period"].dims == ("building.left.period", "building")
    period = whole["building.left.period"]
    assert period.attrs["units"] == "s" and np.array_equal(period, [0.3, 0.5, 0.7])
    assert whole["building.left.mass"].attrs["units"] == "kg" and list(whole["building.left.mass"]) == [5e5, 6e5]


def test_a_row_equals_a_loop_of_set():
    """Storeys, a mass of a floor by its number, the gap of one interface, and an effect on buildings."""
    axes = {"building.A.storey_stiffnesses": ["90 MN/m", "120 MN/m"], 'interface."A | B".restitution': [0.6, 0.7]}
    whole = equals_the_loop(row_text(axes, 2, effects={"p_delta": {}}))
    assert whole["building_period"].dims == ("building.A.storey_stiffnesses", "building")
    assert sum(json.loads(whole.attrs["parts"]).values()) > 0


def test_a_row_that_never_touches_equals_a_loop_of_set():
    """No part of a case is solved, so that none is counted; other interfaces have no link where one has an axis."""
    axes = {"interface.1.link_damping": ["1 MN s/m", "2 MN s/m"]}
    text = row_text(axes, 2, gap="400 mm").replace('gap = ["5 mm", "40 mm"]', 'gap = ["400 mm"]')
    equals_the_loop(text, ("scene_resolved", "scene_sha256"), check_fraction=0.0)
    assert [len(one.links) for one in parse_scene(text).interfaces] == [1, 0]


def test_axes_that_move_together_are_one_dimension():
    axes = {key: AXES[key] for key in ("building.left.period", "interface.restitution")}
    axes |= {"building.left.mass": ["500 t", "600 t", "550 t"], "zip": [["building.left.period", "building.left.mass"]]}
    whole = equals_the_loop(pair_text(axes))
    assert whole.sizes["building.left.period"] == 3 and "building.left.mass" not in whole.dims
    assert whole["building.left.mass"].dims == ("building.left.period",)


def test_grounds_of_buildings_equal_a_loop_of_set():
    """How far the grounds part is told along the axes that move them."""
    axes = {"building.right.ground_factor": [1.0, -1.0, 0.5], "building.left.ground_delay": ["0.05 s", "0.02 s"]}
    whole = equals_the_loop(pair_text(axes), check_fraction=0.0)
    assert whole["record_ground_widening_largest"].dims == (*axes, "record", "interface")


@pytest.mark.complete  # it compiles a kernel of its own
def test_grounds_of_a_row_equal_a_loop_of_set():
    """A key that the scene leaves out stands last in the building's table, elsewhere than in a scene that has it."""
    axes = {"building.B.ground_factor": [-1.0, 0.5]}
    whole = equals_the_loop(row_text(axes), ("scene_resolved", "scene_sha256"), check_fraction=0.0)
    assert whole["peak_closing_free"].dims[0] == "building.B.ground_factor"


ADDRESSES = {
    "building.left.mass": st.floats(1e5, 1e7).map(lambda value: f"{value!r} kg"),
    "building.2.period": st.floats(0.2, 2.0).map(lambda value: f"{value!r} s"),
    "building.damping": st.floats(0.0, 0.3),
    "building.right.initial_displacement": st.floats(0.0, 0.02).map(lambda value: f"{value!r} m"),
    "interface.stiffness": st.floats(1e8, 1e10).map(lambda value: f"{value!r} N/m^1.5"),
    "interface.restitution": st.floats(0.3, 1.0),
    "effects.wave_passage.velocity": st.floats(200.0, 2000.0).map(lambda value: f"{value!r} m/s"),
    "effects.wave_passage.distance": st.floats(5.0, 40.0).map(lambda value: f"{value!r} m"),
}


@settings(max_examples=8, phases=[Phase.generate])
@given(st.data())
@pytest.mark.complete
def test_any_address_equals_a_loop_of_set(data):
    """Two addresses drawn from those of buildings, interfaces and effects, with two values each."""
    keys = data.draw(st.lists(st.sampled_from(sorted(ADDRESSES)), min_size=1, max_size=2, unique=True))
    if {"building.left.mass", "building.damping"} <= set(keys):
        keys = keys[:1]
    axes = {key: data.draw(st.lists(ADDRESSES[key], min_size=2, max_size=2, unique=True)) for key in keys}
    effects = {"wave_passage": {"velocity": "500 m/s", "distance": "20 m"}}
    equals_the_loop(pair_text(axes, effects=effects), check_fraction=0.0)


@pytest.fixture(scope="module")
def in_memory():
    return scan(parse_scene(pair_text(AXES)), check_fraction=0.1)


@pytest.mark.complete
def test_files_shards_threads_and_reruns_have_the_same_bits(in_memory, tmp_path):
    """A netCDF file made in three shards, a Zarr store, one thread, and the scan again from its file."""
    study = parse_scene(pair_text(AXES))
    target = tmp_path / "r.nc"
    for number in (3, 1, 2):
        scan_shard(study, target, f"{number}/3", check_fraction=0.1)
    same_scan(scan(study, target, check_fraction=0.1), in_memory)
    same_scan(scan(study, check_fraction=0.1, workers=1), in_memory)
    convert(target, tmp_path / "r.zarr")
    same_scan(open_results(tmp_path / "r.zarr"), in_memory)
    assert rerun(target).same


def test_a_scan_goes_on_where_it_was_stopped(in_memory, tmp_path, monkeypatch):
    """The batches that are kept are not solved again."""
    study, target = parse_scene(pair_text(AXES)), tmp_path / "r.nc"
    scan_shard(study, target, "1/2", check_fraction=0.1)
    solved = []
    whole = pair_job.PairJob.solve

    def solve(self, batches, *stop):
        solved.extend((self.number, batch) for batch in batches)
        return whole(self, batches, *stop)

    monkeypatch.setattr(pair_job.PairJob, "solve", solve)
    monkeypatch.setattr(pair_job.AtLeastOne, "patches", lambda self, job: ())
    scan(study, target, check_fraction=0.1)
    assert len(solved) == len(set(solved)) == COUNT * 2 * 2 // 2  # of polarities and gaps, half


def test_the_motion_without_contact_is_computed_once_for_scenes_that_share_it(monkeypatch):
    """Masses and restitution do not change it: three periods, two polarities; of rows restitution does not."""
    calls = []
    monkeypatch.setattr(pair_job, "free_response", _counting(pair_job.free_response, calls))
    scan(parse_scene(pair_text(AXES)), workers=1)
    assert len(calls) == 3 * 2
    calls.clear()
    monkeypatch.setattr(row_job.rows, "free_response", _counting(row_job.rows.free_response, calls))
    axes = {"interface.restitution": [0.5, 0.6, 0.7], "building.A.storey_stiffnesses": ["90 MN/m", "120 MN/m"]}
    scan(parse_scene(row_text(axes)), workers=1)
    assert len(calls) == 2 * 2


def _counting(function, calls):
    def counted(*arguments):
        calls.append(arguments)
        return function(*arguments)

    return counted


@pytest.mark.complete
def test_a_plan_counts_every_case_and_times_some_scenes(monkeypatch):
    planned = plan(parse_scene(pair_text(AXES)))
    assert planned.shape["building.left.period"] == 3 and planned.cases == COUNT * 2 * 2
    words = dict(planned.summary())
    assert "3 of building.left.period" in words["cases"] and planned.seconds > 0.0
    whole = scan(parse_scene(pair_text(AXES)), check_fraction=0.1)
    assert planned.bytes >= sum(whole[name].nbytes for name in whole.data_vars)


@pytest.mark.complete
def test_ten_thousand_scenes_are_validated_without_making_each(monkeypatch):
    """Each axis alone: 100 + 100 scenes, beside the few that are told."""
    made = []
    whole = scenes.Variants.made
    monkeypatch.setattr(scenes.Variants, "made", lambda *given: made.append(given) or whole(*given))
    axes = {
        "building.left.period": {"start": "0.3 s", "stop": "0.7 s", "num": 100},
        "building.right.period": {"start": "0.3 s", "stop": "0.7 s", "num": 100},
    }
    assert validate(parse_scene(pair_text(axes))).cases == 10_000 * 2 * 2
    assert 0 < len(made) <= 3 * 200


def test_a_fault_of_two_values_together_names_both_before_any_run():
    """Each displacement alone leaves the buildings apart, both together do not."""
    moved = {"left": "8 mm", "right": "-8 mm"}
    axes = {f"building.{name}.initial_displacement": ["0 m", value] for name, value in moved.items()}
    told = refusal(scan, parse_scene(pair_text(axes)), kind=SceneError)
    assert 'building.left.initial_displacement = "0.008 m"' in told
    assert 'building.right.initial_displacement = "-0.008 m"' in told


def test_another_process_makes_the_same_job_from_its_input(in_memory):
    """As a worker of a cluster does: from the pickled input, batches across the border of two places."""
    study = parse_scene(pair_text(AXES))
    job = job_of(pickle.loads(pickle.dumps(ScanInput(study, gathered(study).motions, True, 0.1))))
    chunk = job.solve(range(2, 7))
    values = job.writer().values(range(2, 7), chunk)["peak_contact_force"]
    assert np.array_equal(values.ravel(), in_memory["peak_contact_force"].values.ravel()[2:7])
    assert job.prepared == job_of(ScanInput(study, gathered(study).motions)).prepared
