"""Spectra of required gaps: against scans of single pairs, NumPy's percentiles, rules pair by pair, and white noise."""

import json
import tomllib

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from scenes import scene_text, single, storeyed
from sentences import refusal, refusals

import pounding_risk as pr
from pounding_risk.assessment import spectra as chart
from pounding_risk.assessment.separations.rules import RULES, Case, Site
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.motions.motion import Motion
from pounding_risk.questions.spectra import few_pairs
from pounding_risk.statistics.separations import cqc, srss
from pounding_risk.studies import spectra as study

NAMES = ["RSN6-180", "RSN1690-090"]
RECORDS = {"names": NAMES, "window": ["0 s", "10 s"], "polarity": ["as recorded", "reversed"], "tail": "1 s"}
RANGE = {"periods": ("0.15 s", "1.2 s"), "right_periods": ("0.2 s", "2 s"), "num": 5}


def scene(left: str = "0.5 s", right: str = "1 s", **changes) -> dict:
    """A pair with 2 % and 7 % of damping, its records scaled by the grid."""
    buildings = single("left", "10 t", left, damping=0.02), single("right", "30 t", right, damping=0.07)
    text = scene_text(*buildings, records=RECORDS, grid={"gap": ["10 mm"], "pga": ["0.1 g", "0.4 g"]})
    return tomllib.loads(text) | changes


def noise_motions(count: int, seconds: float = 40.0, dt: float = 0.01) -> list[Motion]:
    random = np.random.default_rng(11)
    return [Motion(f"noise {k}", random.standard_normal(int(seconds / dt)), dt, {}) for k in range(count)]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return pr.spectra(scene(), **RANGE, motions=True, percentiles=(16, "50 %", 0.84))


@pytest.mark.parametrize(("row", "column"), [(0, 4), (2, 1), (4, 4), (3, 0)])
def test_each_gap_is_that_of_a_scan_of_the_pair(results, row, column):
    """At the largest amplitude of the grid, in both polarities."""
    periods = float(results["left_period"][row]), float(results["right_period"][column])
    own = pr.scan(scene(*(f"{period!r} s" for period in periods)), check_fraction=0.0).sel(pga=results["pga"].item())
    place = {"left_period": row, "right_period": column}
    gaps = results["required_gap_of_motion"].isel(place)
    np.testing.assert_allclose(gaps, own["peak_closing_free"].isel(interface=0), rtol=1e-11)
    assert list(gaps["record"].values) == list(own["record"].values)
    for at, side in enumerate(("left", "right")):
        peaks = own["peak_displacement_free"].isel(building=at)
        found = results[f"{side}_displacement_of_record"].isel({f"{side}_period": place[f"{side}_period"]})
        for polarity in own["polarity"]:
            np.testing.assert_allclose(found, peaks.sel(polarity=polarity), rtol=1e-11)


def test_percentiles_are_numpys(results):
    each = results["required_gap_of_motion"].values.reshape(4, 5, 5)
    assert results["percentile"].values.tolist() == [16.0, 50.0, 84.0]
    for place, percentile in enumerate((16, 50, 84)):
        required = np.percentile(each, percentile, axis=0, method="inverted_cdf")
        np.testing.assert_array_equal(results["required_gap"][place], required)
        peaks = np.concatenate([results["left_displacement_of_record"].values] * 2)
        left = np.percentile(peaks, percentile, axis=0, method="inverted_cdf")
        np.testing.assert_allclose(results["left_displacement"][place], left)


def test_rules_are_those_of_each_pair(results):
    assert {"abs", "srss", "cqc", "asce7", "eurocode8"} <= set(results["rule"].values)
    assert not any(RULES[name].needs for name in results["rule"].values)
    for place in ((1, 0, 3), (2, 4, 0)):
        part = results.isel(dict(zip(("percentile", "left_period", "right_period"), place, strict=True)))
        peaks = float(part["left_displacement"]), float(part["right_displacement"])
        periods = float(part["left_period"]), float(part["right_period"])
        for name in results["rule"].values:
            alone = RULES[str(name)].function(Case(peaks, periods, (0.02, 0.07), Site()))
            assert float(part["separation"].sel(rule=name)) == pytest.approx(alone, rel=1e-13)
        assert float(part["separation"].sel(rule="srss")) == pytest.approx(srss(*peaks), rel=1e-13)
        assert float(part["separation"].sel(rule="cqc")) == pytest.approx(cqc(peaks, periods, (0.02, 0.07)), rel=1e-13)


def test_the_double_difference_holds_in_the_median_of_white_noise():
    """It is exact for standard deviations, and peaks of long noise are about the same multiple of them."""
    periods = [0.3, 0.5, 0.55, 0.8, 1.2, 1.5]
    noise = pr.spectra(noise_motions(16, 80.0), periods=periods, motions=True, percentiles=[50])
    left, right = (noise[f"{side}_displacement_of_record"].values for side in ("left", "right"))
    needed = noise["required_gap_of_motion"].values
    ratios = {}
    for row, column in [(0, 1), (0, 5), (1, 2), (2, 1), (2, 3), (3, 5), (4, 5), (5, 2)]:
        peaks = left[:, row, None], right[:, column, None]
        asked = cqc(peaks, (periods[row], periods[column]), (0.05, 0.05))
        ratios[row, column] = np.median(needed[:, :, row, column] / asked)
    assert min(ratios.values()) > 0.85 and max(ratios.values()) < 1.15, ratios
    neighbours = needed[:, :, 1, 2] / srss(left[:, 1, None], right[:, 2, None])
    assert np.median(neighbours) < 0.8  # 0.5 s beside 0.55 s: correlated, which SRSS does not see


def test_exchanging_equal_buildings_changes_nothing(results):
    motions = noise_motions(3, 8.0)
    alike = pr.spectra(motions, num=7, motions=True, workers=1)
    gap = alike["required_gap"].values
    np.testing.assert_array_equal(gap, gap.transpose(0, 2, 1))
    np.testing.assert_array_equal(np.diagonal(gap, axis1=1, axis2=2), 0.0)
    xr.testing.assert_equal(alike, pr.spectra(motions, num=7, motions=True, workers=3))
    doubled = pr.spectra([motion.scaled(2.0) for motion in motions], num=7)
    np.testing.assert_array_equal(doubled["required_gap"].values, 2.0 * gap)
    # One after the other: a pair of unequal damping is not still where its periods are equal.
    assert (np.diagonal(pr.spectra(motions, num=7, damping=(0.05, 0.1))["required_gap"].values[0]) > 0.0).all()
    assert chart.is_symmetric(alike) and not chart.is_symmetric(results)


def test_records_named_and_a_scene_give_the_same():
    """Of a scene records, polarities and damping ratios are taken; nothing of its periods, masses and contact."""
    own = scene(records={**RECORDS, "pga": "0.4 g"}, grid={"gap": ["10 mm"]})
    of_scene = pr.spectra(own, **RANGE)
    of_records = pr.spectra(pr.Records(**RECORDS, pga="0.4 g"), **RANGE, damping=(0.02, "7 %"))
    for name in of_scene.data_vars:
        np.testing.assert_array_equal(of_scene[name], of_records[name])
    assert of_scene.attrs["amplitude"] == of_records.attrs["amplitude"] == "at PGA 0.4 g"
    again = pr.spectra(pr.read_scene(own, ["building.left.damping=0.3"]), **RANGE, damping=(0.02, 0.07))
    np.testing.assert_array_equal(again["required_gap"], of_scene["required_gap"])
    np.testing.assert_array_equal(pr.spectra(scene(), **RANGE)["required_gap"], of_scene["required_gap"])
    assert [record["name"] for record in json.loads(of_records.attrs["records"])] == NAMES


def test_the_dataset_is_written_read_and_known(results, tmp_path, says):
    path = tmp_path / "spectra.nc"
    made = pr.spectra(scene(), path, **RANGE)
    read = pr.open_results(path)
    xr.testing.assert_identical(read, made)
    assert read.pounding.kind == "spectra" and made.attrs["finding"] in repr(read.pounding).replace("\n", " ")
    assert "required_gap_of_motion" not in read and "required_gap_of_motion" in results
    units = {name: read[name].attrs["units"] for name in ("required_gap", "separation", "left_period", "percentile")}
    assert units == {"required_gap": "m", "separation": "m", "left_period": "s", "percentile": "%"}
    pr.spectra(scene(), path, **RANGE)  # its own results are replaced
    path.write_text("a letter")
    says(refusal(pr.spectra, scene(), path, **RANGE))
    assert path.read_text() == "a letter"
    pr.spectra(scene(), path, **RANGE, new=True)


def test_the_finding_counts_the_pairs(results):
    """By loops over the dataset's numbers."""
    found = chart.shortfall(results, "srss")
    gap = results["required_gap"].sel(percentile=84.0).values
    asked = results["separation"].sel(percentile=84.0, rule="srss").values
    ratios = {place: gap[place] / asked[place] for place in np.ndindex(gap.shape)}
    place = max(ratios, key=lambda place: ratios[place])
    assert found.pairs == np.mean([ratio > 1.0 for ratio in ratios.values()])
    assert found.ratio == ratios[place]
    assert found.periods == (float(results["left_period"][place[0]]), float(results["right_period"][place[1]]))
    assert found.median == np.median(list(ratios.values()))
    words = results.attrs["finding"]
    assert words.startswith("The gap that 84 % of 4 motions need exceeds SRSS at ") and "; DDC at " in words
    still = pr.spectra(noise_motions(1, 2.0), num=3)
    still["required_gap"][:] = 0.0
    assert chart.finding(still).endswith("exceeds SRSS at no pair of periods; DDC at no pair of periods")


def test_the_table_has_each_pair_once_where_both_sides_are_alike(results):
    rows = list(few_pairs(results))
    assert len(rows) == 16 and rows[0][:2] == (pytest.approx(0.15), pytest.approx(0.2))
    assert rows[-1][2:-3] == tuple(results["required_gap"][:, -1, -1].values)
    alike = list(few_pairs(pr.spectra(noise_motions(2, 4.0), num=4)))
    assert len(alike) == 6 and all(row[0] < row[1] for row in alike)


def test_the_figure_says_what_it_shows(results, says):
    figure = pr.figures.gap_spectra_figure
    for options in ({}, {"percentile": 16.0}, {"rules": ["eurocode8", "ubc97"]}):
        says(words_of(figure(results, **options)))
    assert words_of(results.pounding.figure()) == words_of(figure(results))
    says(
        refusal(figure, results, rules=["srss", "eurocode9"]),
        refusal(figure, results, rules=["srss", "srss"]),
        refusal(figure, results, 95.0),
        refusal(figure, xr.Dataset()),
    )


def test_sections_next_to_equal_periods_are_drawn_where_others_lie_between():
    """Of equal periods no gap is needed: a straight line from there to the next ones is far below what is."""

    def drawn(num: int) -> list[str]:
        axis = pr.figures.gap_spectra_figure(pr.spectra(noise_motions(1, 2.0), num=num)).axes[3]
        return [line.get_label() for line in axis.lines if line.get_label().startswith("right = ")]

    assert drawn(12) == ["right = 0.5 left"] and len(drawn(100)) == 3


def test_motions_that_do_not_suit_the_periods_are_flagged():
    coarse = Motion("coarse", np.sin(np.arange(0.0, 40.0, 0.1)), 0.02, {})
    flags = json.loads(pr.spectra([coarse], periods=("0.05 s", "1 s"), num=2).attrs["flags"])
    assert any("time step of the stiffest building" in flag for flag in flags["coarse"])
    assert "coarse" not in json.loads(pr.spectra([coarse], periods=("0.8 s", "1 s"), num=2).attrs["flags"])
    upright = Motion("upright", coarse.acceleration, 0.01, {"component": "UP"})
    flags = json.loads(pr.spectra([upright], periods=("0.8 s", "1 s"), num=2).attrs["flags"])
    assert any(flag.startswith("a vertical component") for flag in flags["upright"])


def test_motions_of_one_name_get_a_number():
    motion = noise_motions(1, 2.0)[0]
    assert list(pr.spectra([motion, motion], num=2)["record"].values) == ["noise 0 (1)", "noise 0 (2)"]


STOREYS = storeyed("tall", ["20 t", "20 t"], ["9e6 N/m", "9e6 N/m"], ["3 m", "3 m"])
LEFT, RIGHT = single("left", "10 t", "0.5 s"), single("right", "30 t", "1 s")


@pytest.mark.parametrize(
    ("buildings", "effects"),
    [
        ([LEFT, RIGHT, single("third", "1 t", "1 s")], {}),
        ([LEFT, {"name": "wall", "rigid": True}], {}),
        ([LEFT, STOREYS], {}),
        ([LEFT, {**RIGHT, "initial_displacement": "5 mm"}], {}),
        ([LEFT, RIGHT], {"wave_passage": {"velocity": "300 m/s", "distance": "20 m"}}),
    ],
)
def test_a_scene_that_is_no_pair_on_one_ground_is_refused(buildings, effects, says):
    text = scene_text(*buildings, effects=None, records=RECORDS)
    tables = tomllib.loads(text) | ({"effects": effects} if effects else {})
    says(refusal(pr.spectra, tables, num=2, kind=SceneError))


@pytest.mark.parametrize(
    ("heights", "interface", "sentence"),
    [
        ((None, None), {"link_damping": "1 MN s/m"}, "interface: a link joins the two"),
        ((None, None), {"bumper_length": "5 mm"}, "interface.bumper_length: gaps here are clear of bumpers"),
        (("6 m", "9 m"), {}, "building: they meet part-way up one of them"),
    ],
)
def test_what_changes_the_closing_of_two_masses_is_refused(heights, interface, sentence):
    pair = [side | {"height": height} for side, height in zip((LEFT, RIGHT), heights, strict=True)]
    for call in (pr.spectra, pr.amplification):
        with pytest.raises(SceneError, match=sentence):
            call(scene_text(*pair, records=RECORDS, **interface))


WRONG = {
    "periods": ["1 s", ["1 s"], (0.5, 0.5), ("0 s", "1 s"), (1e-4, 1.0)],
    "right_periods": [("2 s", "1 s")],
    "num": [1, 1001],
    "spacing": ["even"],
    "damping": [(0.05, 0.05, 0.05), 1.5],
    "percentiles": [(), (101,)],
}


def test_what_cannot_be_meant_is_refused(says):
    says(*refusals(pr.spectra, noise_motions(1, 1.0), num=2, wrong=WRONG))


def test_sources_without_motions_are_refused():
    for nothing in ([], [3], 7):
        with pytest.raises(PoundingError, match=r"holds no motions; give a scene, pr\.Records"):
            pr.spectra(nothing)  # type: ignore[arg-type]


def test_more_memory_than_there_should_be_is_refused(monkeypatch, says):
    monkeypatch.setattr(study, "MOST_BYTES", 1e6)
    says(refusal(pr.spectra, noise_motions(2, 1.0), num=200))


def test_listed_and_linear_periods():
    motion = noise_motions(1, 2.0)
    listed = pr.spectra(motion, periods=["0.2 s", 0.3, 0.7])
    assert listed["left_period"].values.tolist() == [0.2, 0.3, 0.7]
    even = pr.spectra(motion, periods=(0.2, 0.6), num=5, spacing="linear")
    np.testing.assert_allclose(even["right_period"], [0.2, 0.3, 0.4, 0.5, 0.6], rtol=1e-14)
    ratios = pr.spectra(motion, periods=(0.2, 0.8), num=3)["left_period"].values
    np.testing.assert_allclose(ratios, [0.2, 0.4, 0.8], rtol=1e-14)
