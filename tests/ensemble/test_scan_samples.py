"""Samples of uncertain numbers in a scan, with drawn motions, and added later: each is the scene that `--set` makes."""

import json
import warnings

import numpy as np
import pytest
import xarray as xr
from axes import equals_the_loop, same_scan
from scenes import scene_text
from sentences import refusal
from uncertain import PERIOD, RESTITUTION, THREE, uncertain_row_text, uncertain_text

import pounding_risk as pr
from pounding_risk.ensemble import pair_job
from pounding_risk.ensemble.chunks import parted
from pounding_risk.ensemble.plan.plan import plan, validate
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.ensemble.status import status
from pounding_risk.questions.rerun import rerun
from pounding_risk.results.check import check_scan, kind_of
from pounding_risk.results.files import open_results, save
from pounding_risk.results.scene_axes import at_one_place, axes_of, selected, with_axes
from pounding_risk.results.summary import summary
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


def test_gaps_of_a_row_that_are_drawn_equal_a_loop_of_set(tmp_path):
    """Written without a warning on the space in the name of the label, and read again as they were."""
    gap = {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}
    text = uncertain_row_text({'interface."A | B".gap': gap}, 2, {"gap": None}, 2)
    whole = equals_the_loop(text, ("scene_resolved", "scene_sha256"), check_fraction=0.0)
    assert whole["interface_gap"].dims == ("sample", "gap", "interface")
    with warnings.catch_warnings():
        warnings.simplefilter("error", xr.SerializationWarning)
        saved = save(whole, tmp_path / "saved.nc")
        scan(parse_scene(text), tmp_path / "scanned.nc", check_fraction=0.0)
    for path in (saved, tmp_path / "scanned.nc"):
        assert list(open_results(path)['interface."A | B".gap'].values) == list(whole['interface."A | B".gap'].values)


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


def asked(samples, numbers=None, **more):
    return parse_scene(uncertain_text(numbers, samples=samples, **more))


@pytest.fixture
def solved(monkeypatch):
    """The scenes' numbers whose batches are solved."""
    numbers = []
    whole = pair_job.PairJob.solve

    def solve(self, batches, *stop):
        numbers.extend([self.number] * len(batches))
        return whole(self, batches, *stop)

    monkeypatch.setattr(pair_job.PairJob, "solve", solve)
    return numbers


@pytest.mark.complete
@pytest.mark.parametrize(("name", "first", "whole"), [("r.nc", 8, 16), ("r.zarr", 2, 3)])
def test_eight_and_eight_samples_are_sixteen(tmp_path, name, first, whole):
    """Every variable to the bit, and the attributes; the file that is replaced held the first of them."""
    target = tmp_path / name
    scan(asked(first), target, check_fraction=0.1)
    at_once = scan(asked(whole), check_fraction=0.1)
    same_scan(scan(asked(whole), target, check_fraction=0.1), at_once)
    same_scan(open_results(target), at_once)


@pytest.mark.complete
def test_samples_beside_an_axis_are_added(tmp_path):
    """The axis of the restitution is faster than the samples, that of damping slower."""
    axes = {"interface.restitution": [0.5, 0.8], "building.right.damping": [0.02, 0.05]}
    numbers = {"building.left.period": THREE["building.left.period"], "method": "random"}
    target = tmp_path / "r.nc"
    scan(asked(2, numbers, axes=axes), target, check_fraction=0.0)
    added = scan(asked(3, numbers, axes=axes), target, check_fraction=0.0)
    same_scan(added, scan(asked(3, numbers, axes=axes), check_fraction=0.0))


def test_samples_of_a_row_are_added(tmp_path):
    """With the counts of its parts, and motions without contact that do not differ."""
    first, whole = (parse_scene(uncertain_row_text({"interface.restitution": RESTITUTION}, count)) for count in (1, 3))
    target = tmp_path / "r.nc"
    scan(first, target, check_fraction=0.0)
    same_scan(scan(whole, target, check_fraction=0.0), scan(whole, check_fraction=0.0))


def test_adding_goes_on_where_it_was_stopped(tmp_path, solved):
    """After one of two shards; the finished file stays until the whole is written."""
    target = tmp_path / "r.nc"
    scan(asked(2), target, check_fraction=0.0)
    before = target.read_bytes()
    state = scan_shard(asked(4), target, "2/2", check_fraction=0.0)
    assert (state.cases, state.done, state.total) == (8, 8 + 4, 16)  # half of the grid, half of which was known
    assert target.read_bytes() == before and status(target).cases == 12
    solved.clear()
    added = scan(asked(4), target, check_fraction=0.0)
    assert len(solved) == 4 and set(solved) <= {2, 3}
    assert not list((tmp_path / "r.study" / "parts").iterdir())
    same_scan(added, scan(asked(4), check_fraction=0.0))


def test_what_is_another_study_is_not_added_to(tmp_path, says):
    """Nor a selection of the same one."""
    four = scan(asked(4), tmp_path / "r.nc", check_fraction=0.0)
    part = save(four.isel(sample=slice(0, 2)), tmp_path / "part.nc")
    wider = THREE | {"building.left.mass": {"distribution": "normal", "mean": "500 t", "cov": 0.2}}
    others = asked(8, wider), asked(8, THREE | {"seed": 2}), asked(2), asked(8, solver={"rtol": 1e-7})
    says([refusal(scan, other, tmp_path / "r.nc", check_fraction=0.0) for other in others])
    says(refusal(scan, asked(8), tmp_path / "r.nc", check_fraction=0.5))
    says(refusal(scan, asked(8), part, check_fraction=0.0))


def test_ranges_are_parted_into_what_is_known_and_what_is_not():
    known = [range(2, 4), range(6, 9)]
    quarters = [range(start, start + 2) for start in range(0, 8, 2)]
    assert list(parted(range(0, 8), known)) == list(zip(quarters, (False, True, False, True), strict=True))
    assert list(parted(range(2, 3), known)) == [(range(2, 3), True)]
    assert list(parted(range(4, 6), [])) == [(range(4, 6), False)]


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
