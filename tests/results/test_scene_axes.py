"""A dataset with axes of numbers of its scene: choosing a place, what refuses several, and what is told of them."""

import json

import numpy as np
import pytest
import xarray as xr
from axes import AXES, pair_text, same_scan
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.along import OUTPUTS, kept_words, usual_place
from pounding_risk.figures.scan import scan_figure
from pounding_risk.results.files import open_results
from pounding_risk.results.scene_axes import (
    at_one_place,
    open_axes,
    own_places,
    selected,
    with_axes,
    without_effect,
    words_of_values,
)
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import Quantity, parse

PLACE = {"building.left.period": 0.5, "interface.restitution": 0.8, "building.left.mass": 6e5}
CHOICE = ["building.left.period=0.5 s", "interface.restitution=0.8", "building.left.mass=600 t"]


@pytest.fixture(scope="module")
def whole():
    return pr.scan(parse_scene(pair_text(AXES)), check_fraction=0.2)


@pytest.fixture(scope="module")
def alone():
    values = ['building.left.period="0.5 s"', "interface.restitution=0.8", 'building.left.mass="600 t"']
    return pr.scan(parse_scene(pair_text(AXES), overrides=values), check_fraction=0.2)


@pytest.mark.parametrize(
    ("unit", "labels", "words"),
    [
        ("N s/m", [0.0, 1e6, 4e6], "0 N s/m, 1 MN s/m, 4 MN s/m"),
        ("m", [0.02, 0.0123456789], "20 mm, 12.3456789 mm"),
        ("m/s2", [0.3 * 9.80665], "0.3 g"),
        ("1", [0.5, 0.65], "0.5, 0.65"),
    ],
)
def test_values_of_an_axis_stand_in_usual_units_and_choose_them(unit, labels, words):
    dataset = xr.Dataset(coords={"number": ("number", labels, {"units": unit})})
    assert words_of_values(dataset, "number") == words
    assert [parse(each, Quantity(unit.replace("m/s2", "m/s^2"), 0.0, 1e9, "")) for each in words.split(", ")] == labels


@pytest.mark.complete
def test_every_way_of_choosing_gives_the_scan_of_the_place(whole, alone, tmp_path):
    """By label, by index, by text, from a file: that of the scene with the values set, but for how they are spelt."""
    path = pr.save(whole, tmp_path / "r.nc")
    by_index = whole.isel({"building.left.period": 1, "interface.restitution": [1], "building.left.mass": 1})
    for part in (whole.sel(PLACE), by_index, selected(whole, CHOICE), selected(open_results(path), CHOICE)):
        same_scan(with_axes(part), alone, apart=("overrides",))


def test_a_choice_of_some_keeps_the_other_axes(whole):
    part = selected(whole, CHOICE[:1])
    assert [axis.name for axis in open_axes(part)] == ["interface.restitution", "building.left.mass"]
    assert part.sizes["building.left.period"] == 1
    ranged = whole.sel({"building.left.period": slice(0.4, 0.8)})
    assert at_one_place(selected(ranged, CHOICE)).sizes["gap"] == 2


def test_a_dimension_of_the_grid_is_chosen_by_its_option(whole, says):
    says([refusal(selected, whole, [f"{name}=0.3"]) for name in ("gap", "pga")])


CHOICES = {
    "a value that is none": "building.left.period=0.51 s",
    "a mass for a period": "building.left.period=5 t",
    "an unknown axis": "building.left.perod=5",
    "no value": "building.left.period",
}


@pytest.mark.parametrize("choice", CHOICES.values(), ids=CHOICES)
def test_what_cannot_be_chosen_is_told(whole, choice, says):
    says(refusal(selected, whole, [choice]))


def test_a_lost_label_is_told(whole, alone, says):
    chosen = {key: PLACE[key] for key in list(PLACE)[:2]}
    says(refusal(with_axes, whole.isel({"building.left.mass": 0}, drop=True).sel(chosen)))
    says(refusal(pr.assess_along, alone))


def test_calls_of_one_scene_refuse_several_and_say_how_to_choose(whole, tmp_path, says):
    path = pr.save(whole, tmp_path / "r.nc")
    calls = {
        "assess": lambda: pr.assess(whole),
        "draw": lambda: pr.draw(path, elevation=tmp_path / "e.png"),
        "histories": lambda: pr.histories(path, tmp_path / "h.nc"),
        "results_figure": lambda: pr.figures.results_figure(whole, "scan"),
        "scan_figure": lambda: scan_figure(whole),
        "case": lambda: whole.pounding.case(gap="10 mm"),
        "row_case": lambda: pr.row_case(whole),
    }
    says([f"{name}: {refusal(call)}" for name, call in calls.items()])
    assert [file.name for file in tmp_path.iterdir()] == ["r.nc"]
    study = parse_scene(pair_text(AXES))
    says([refusal(call, study) for call in (pr.effects, pr.accuracy)])


def test_simulate_and_modes_take_the_values_of_the_scene_itself():
    study = parse_scene(pair_text(AXES))
    assert pr.simulate(study)["building_period"].values[0] == 0.5
    assert "building.left.period" in str(study)


def test_a_case_and_histories_of_one_place(whole, tmp_path):
    case = whole.sel(PLACE).pounding.case(gap="10 mm")
    path = pr.save(whole, tmp_path / "r.nc")
    pr.histories(path, tmp_path / "h.nc", gaps=[0.01], select=CHOICE)
    # The peaks are of the continuous motion, the histories at the samples of the record.
    sampled = np.nanmax(np.abs(open_results(tmp_path / "h.nc")["relative_displacement"].isel(polarity=0).values))
    assert 0.98 * float(case["peak_relative_displacement"].max()) < sampled
    assert sampled <= float(case["peak_relative_displacement"].max()) * (1.0 + 1e-9)


def test_a_summary_counts_all_places_and_of_some_only_these(whole):
    assert pr.summary(whole).counts["cases"] == 12 * 4
    assert pr.summary(selected(whole, CHOICE[:1])).counts["cases"] == 4 * 4
    assert pr.summary(whole.sel(PLACE)).counts["cases"] == 4
    assert pr.summary(whole.sel(PLACE)).along == ()
    assert ("building.left.period", "0.3 s, 0.5 s, 0.7 s") in list(whole.pounding.facts())


def test_contact_along_axes_is_that_of_assess_at_each_place(whole):
    """Probability with bounds and the gap required; four places beside the assessment of their own datasets."""
    along = pr.assess_along(whole, gap="30 mm", percentile=84)
    dims = ("building.left.period", "interface.restitution", "building.left.mass", "interface")
    assert {along[name].dims for name in OUTPUTS} == {dims}
    assert along["building.left.period"].attrs["units"] == "s"
    for place in ((0, 0, 0), (1, 1, 0), (2, 0, 1), (2, 1, 1)):
        chosen = dict(zip(dims, place, strict=False))
        (one,) = pr.assess(whole.isel(chosen), gap="30 mm", percentile=84).interfaces
        here, share, need = along.isel(chosen | {"interface": 0}), one.contact_at_gap(), one.required_at(84.0)
        assert float(here["contact_probability"]) == share.probability
        assert float(here["contact_probability_high"]) == share.high_recordings
        assert [float(here[f"required_gap{end}"]) for end in ("", "_low", "_high")] == [need.gap, need.low, need.high]
    assert along["required_gap"].max() > along["required_gap"].min()


def test_the_scene_s_own_place_is_known(whole):
    """Of the period and the mass, whose own values are among those of the axes; not of the restitution."""
    assert own_places(whole) == {"building.left.period": 1, "building.left.mass": 0}
    part = whole.isel({"building.left.period": [0, 2], "building.left.mass": [0]})
    assert own_places(part) == {}
    along = pr.assess_along(whole, gap="30 mm")
    assert json.loads(along.attrs["own_places"]) == own_places(whole)
    assert json.loads(along.attrs["idle_axes"]) == ["interface.restitution", "building.left.mass"]
    place = usual_place(along)
    assert place.places == {"building.left.period": 1, "building.left.mass": 0, "interface.restitution": 0}
    assert place.why == "the scene's own values, and of interface.restitution those that need the widest gap"
    widest = usual_place(pr.assess_along(part, gap="30 mm"))
    needed = along["required_gap"].isel({"building.left.mass": 0, "interface.restitution": 0, "interface": 0})
    assert widest.places["building.left.period"] == int(needed.values[[0, 2]].argmax())
    assert widest.why == "those that need the widest gap"


def test_where_the_target_is_kept_is_told(whole, says):
    """Made-up shares: from one value on, up to one, at some, everywhere; the worst interface decides."""
    along = pr.assess_along(whole, gap="30 mm", target="16 %")
    one = along.isel({"interface.restitution": [0], "building.left.mass": [0]}).squeeze(drop=True)
    one = one.expand_dims("interface")

    def told(*shares: float, made=one) -> str:
        high = xr.full_like(made["contact_probability"], 0.5)
        share = xr.full_like(high, 0.0) + xr.DataArray(list(shares), dims="building.left.period")
        return kept_words(made.assign(contact_probability=share, contact_probability_high=high))

    says([told(*shares) for shares in ((0.5, 0.16, 0.1), (0.1, 0.2, 0.3), (0.1, 0.2, 0.1), (0.0, 0.0, 0.0))])
    backwards = one.isel({"building.left.period": [2, 1, 0]})
    from_last = along.assign(contact_probability=0.0 * along["required_gap"] + (along["building.left.period"] > 0.6))
    two = xr.concat([one, one], "interface").assign_coords(interface=["a", "b"])
    two["contact_probability"][{"interface": 1}] = 1.0
    says(told(0.1, 0.16, 0.5, made=backwards), kept_words(from_last), kept_words(two))


def test_an_axis_without_effect_is_told():
    """By the scan, as of any key without effect, and by the summary of what was computed."""
    study = parse_scene(pair_text({"building.left.height": ["3 m", "6 m"], "building.left.period": ["0.3 s", "0.5 s"]}))
    dataset = pr.scan(study, check_fraction=0.0)
    (sentence,) = unused_keys(study)
    assert sentence.startswith("building.left.height: no effect: two single masses meet mass to mass")
    assert json.loads(dataset.attrs["unused_keys"]) == [sentence]
    assert without_effect(dataset) == ("building.left.height",)
    assert dict(pr.summary(dataset).along)["building.left.height"] == "3 m, 6 m; no output depends on it"
    one = dataset.copy(deep=True)
    one["peak_closing"][{"building.left.height": 1, "gap": 0}] += 1e-12
    assert without_effect(one) == ()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("scene_axes", "[{}]"),
        ("scene_axes", "{"),
        ("scene_variants", '{"tables": [[1]]}'),
        ("scene_variants", "null"),
        ("scene_variants", '{"attributes": null}'),
    ],
    ids=["no keys", "no JSON", "no table", "nothing", "no attributes"],
)
def test_damaged_attributes_are_told(whole, name, text, says):
    says(refusal(pr.assess, whole.sel(PLACE).assign_attrs({name: text})))
