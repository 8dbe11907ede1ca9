"""Amplification over period ratio and gap: against single scans, the reference integrator, NumPy, and its limits."""

import tomllib

import numpy as np
import oracle
import pytest
import xarray as xr
from figure_words import words_of
from scenes import scene_text, single, storeyed
from sentences import refusal, refusals

import pounding_risk as pr
from pounding_risk.assessment import amplification as chart
from pounding_risk.errors import SceneError
from pounding_risk.figures.amplification_chart import amplification_figure
from pounding_risk.questions.amplification import FILES, amplification_table
from pounding_risk.scene.motions import motions_of
from pounding_risk.statistics.separations import srss
from pounding_risk.studies import amplification as study

PULSES = [{"kind": "ricker", "pga": pga, "period": period} for pga, period in (("0.3 g", "0.6 s"), ("0.5 g", "1 s"))]
RECORDS = {"generated": PULSES, "polarity": ["as recorded", "reversed"], "tail": "1 s"}
RANGE = {"ratios": (0.4, 0.8, 1.0, 1.7), "gaps": ("5 mm", "90 mm"), "num_gaps": 4}
RIGHT = 0.6  # s


def scene(left: float = 0.4, right: float = RIGHT, gap: float = 0.01, **changes) -> dict:
    buildings = single("tower", "400 t", f"{left!r} s"), single("hall", "150 t", f"{right!r} s", damping=0.03)
    records = changes.pop("records", RECORDS)
    return tomllib.loads(scene_text(*buildings, records=records, gap=f"{gap!r} m", **changes))


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return pr.amplification(scene(), **RANGE, motions=True)


@pytest.mark.parametrize(("ratio", "gap"), [(0, 0), (1, 1), (3, 0), (3, 3)])
def test_each_is_that_of_a_scan_of_the_pair(results, ratio, gap):
    place = {"fixed_period": 0, "period_ratio": ratio, "gap": gap}
    left = float(results["building_period"].isel(fixed_period=0, period_ratio=ratio, building=0))
    assert left == pytest.approx(RIGHT * RANGE["ratios"][ratio])
    own = pr.scan(scene(left, gap=float(results["gap"][gap])), check_fraction=0.0)
    own = own.isel(contact_model=0, gap=0, yield_force=0).squeeze("interface")
    for word, name in study.PEAKS.items():
        each = results[f"{word}_amplification_of_motion"].isel(place).values
        np.testing.assert_array_equal(each, (own[name] / own[f"{name}_free"]).values)
        np.testing.assert_array_equal(results[f"{word}_amplified"].isel(place), (each > 1.0).mean(axis=(0, 1)))
        np.testing.assert_array_equal(results[f"{word}_amplification_largest"].isel(place), each.max(axis=(0, 1)))
        for percentile in (16, 50, 84):
            told = results[f"{word}_amplification"].sel(percentile=percentile).isel(place)
            np.testing.assert_allclose(
                told, np.percentile(each.reshape(-1, 2), percentile, axis=0, method="inverted_cdf")
            )
    assert float(results["contact_share"].isel(place)) == float((own["impact_count"] > 0).mean())


def test_a_scan_along_the_period_gives_the_same(results):
    """As a dataset of `scan` has it, whose axes are the period and the gap."""
    periods = [f"{float(period)!r} s" for period in results["building_period"].isel(fixed_period=0, building=0)]
    gaps = [f"{float(gap)!r} m" for gap in results["gap"]]
    axes = {"building.tower.period": periods, "gap": gaps}
    whole = pr.scan(scene() | {"grid": axes}, check_fraction=0.0).isel(contact_model=0, yield_force=0)
    ratio = whole["peak_displacement"] / whole["peak_displacement_free"]
    ratio = ratio.transpose("record", "polarity", "building.tower.period", "gap", "building")
    told = results["displacement_amplification_of_motion"].isel(fixed_period=0)
    np.testing.assert_array_equal(told, ratio.where(np.isfinite(ratio), 1.0))


def test_the_reference_integrator_gives_the_same():
    """An oracle that shares no code with the solver, with contact and with a gap that nothing closes."""
    one = pr.amplification(scene(records={"generated": PULSES[1:]}), ratios=(0.5, 0.7, 1.7), gaps=(0.02, 0.04, 0.06),
                           motions=True)  # fmt: skip
    (motion,) = motions_of(pr.read_scene(scene(records={"generated": PULSES[1:]})))
    left, right = oracle.Oscillator(400e3, 0.5 * RIGHT), oracle.Oscillator(150e3, RIGHT, 0.03)
    struck, free = (
        oracle.integrate(oracle.Scene(left, right, "jankowski", 2.75e9, gap), motion.acceleration, motion.dt)
        for gap in (0.02, 10.0)
    )
    assert struck["impact_count"] > 0 and free["impact_count"] == 0
    cell = one.isel(record=0, polarity=0, fixed_period=0, period_ratio=0, gap=0)
    for word, name in study.PEAKS.items():
        for building, side in enumerate(("left", "right")):
            told = float(cell[f"{word}_amplification_of_motion"][building])
            assert told == pytest.approx(struck[f"{name}_{side}"] / free[f"{name}_{side}"], rel=1e-6)
            assert abs(told - 1.0) > 1e-3  # so that the comparison says something


def test_nothing_is_amplified_at_the_gap_that_all_motions_need():
    """At the gap that all but 1e-4 % of the motions need none touches; at half of it some do, and nothing is 1."""
    shares = pr.amplification(scene(), ratios=(0.5, 0.8, 1.6), gap_shares=(0.5, 1.0, 1.001), share_of="required",
                              share_percentile="99.9999 %", motions=True)  # fmt: skip
    wide = shares.sel(gap_share=1.001)
    assert (wide["contact_share"] == 0.0).all()
    assert (wide["displacement_amplification_of_motion"] == 1.0).all()
    assert (wide["acceleration_amplification"] == 1.0).all() and (wide["displacement_amplified"] == 0.0).all()
    assert (shares["contact_share"].sel(gap_share=0.5) > 0.0).all()
    np.testing.assert_allclose(shares["gap"], shares["reference_gap"] * shares["gap_share"], rtol=1e-15)


def test_equal_buildings_never_touch():
    twins = pr.amplification(scene(), ratios=(0.5, 1.0, 2.0), gaps=(0.0, 0.01, 0.02), damping=0.05)
    still = twins.sel(period_ratio=1.0)
    assert (still["contact_share"] == 0.0).all() and (still["displacement_amplification"] == 1.0).all()
    assert (twins["contact_share"].sel(period_ratio=[0.5, 2.0], gap=0.01) > 0.0).all()
    required = pr.amplification(scene(), ratios=(0.5, 1.0, 2.0), share_of="required", damping=0.05, num_gaps=2)
    assert (required["gap"].sel(period_ratio=1.0) == 0.0).all()
    assert (required["contact_share"].sel(period_ratio=1.0) == 0.0).all()


def test_a_mirrored_pair_gives_the_mirrored_results(results):
    """The same bits: in a mirrored scene the motion in the other polarity does to the left what it did to the right."""
    mirror = scene()
    mirror["building"] = mirror["building"][::-1]
    mirror["records"] = mirror["records"] | {"polarity": ["reversed", "as recorded"]}
    mirrored = pr.amplification(mirror, **RANGE, fixed="left", motions=True)
    assert mirrored["building"].values.tolist() == ["hall", "tower"]
    turned = mirrored.isel(building=[1, 0])
    for name in results.data_vars:
        np.testing.assert_array_equal(turned[name].values, results[name].values, err_msg=str(name))
    by_name = pr.amplification(mirror, **RANGE, fixed="hall")
    for name in by_name.data_vars:
        np.testing.assert_array_equal(by_name[name], mirrored[name], err_msg=str(name))


def test_shares_are_of_the_rule_at_the_same_periods():
    shares = pr.amplification(scene(), ratios=(0.5, 0.8, 1.6), gap_shares=(0.2, 0.6), num_gaps=3, share_percentile=50)
    periods = shares["building_period"].isel(fixed_period=0)
    alone = pr.spectra(scene(), periods=periods.isel(building=0).values, right_periods=(0.3, RIGHT, 0.9),
                       percentiles=[50])  # fmt: skip
    at = alone.sel(percentile=50, right_period=RIGHT)
    np.testing.assert_allclose(shares["reference_gap"][0], at["separation"].sel(rule="srss"), rtol=1e-13)
    peaks = at["left_displacement"].values, float(at["right_displacement"])
    np.testing.assert_allclose(shares["reference_gap"][0], srss(*peaks), rtol=1e-13)
    np.testing.assert_allclose(shares["gap"][0, :, 1], 0.4 * srss(*peaks), rtol=1e-13)
    one = pr.amplification(scene(), ratios=(0.5, 0.8, 1.6), gaps=shares["gap"][0, 1].values)
    same = shares["displacement_amplification"].isel(period_ratio=1).values
    np.testing.assert_array_equal(one["displacement_amplification"].isel(period_ratio=1), same)


@pytest.mark.complete
def test_records_stand_for_masses_whose_velocities_jump():
    """Of masses that jump the ratio alone counts; the acceleration of a jump is not finite, so it is left out."""
    kept = pr.Records(**RECORDS)
    few = {"ratios": (0.5, 0.7, 2.0), "gaps": (0.01, 0.02, 0.04), "periods": RIGHT}
    heavy = pr.amplification(kept, **few, mass_ratio=400 / 150, damping=(0.05, 0.03))
    assert "acceleration_amplification" not in heavy and heavy.attrs["contact_model"] == "stereomechanical"
    own = pr.amplification(scene(law="stereomechanical", stiffness=None), **few)
    np.testing.assert_allclose(heavy["displacement_amplification"], own["displacement_amplification"], rtol=1e-9)
    several = pr.amplification(kept, ratios=(0.5, 0.7, 2.0), gaps=(0.01, 0.02, 0.04), periods=(0.3, RIGHT), workers=1)
    alone = pr.amplification(kept, **few, workers=2)
    np.testing.assert_array_equal(several["displacement_amplification"].sel(fixed_period=RIGHT),
                                  alone["displacement_amplification"].isel(fixed_period=0))  # fmt: skip
    assert "beside 0." in several.attrs["finding"]


def test_the_scene_s_own_case_is_run(says):
    """Of a grid the own contact model and yield force, and the largest amplitude where none is the scene's."""
    pulses = {"generated": [{**PULSES[1], "pga": "0.2 g"}]}
    grid = {"gap": ["1 mm"], "contact_model": ["jankowski", "viscous_elastoplastic"], "pga": ["0.1 g", "0.5 g"]}
    few = {"ratios": (0.5, 0.7, 2.0), "gaps": (0.01, 0.02, 0.04)}
    of_grid = pr.amplification(scene(grid=grid, records=pulses), **few)
    own = pr.amplification(scene(records={"generated": PULSES[1:]}), **few)
    np.testing.assert_allclose(of_grid["displacement_amplification"], own["displacement_amplification"], rtol=1e-9)
    assert float(of_grid["pga"]) == pytest.approx(0.5 * 9.80665) and "0.5 g" in of_grid.attrs["amplitude"]
    along = scene(grid={"gap": ["1 mm"], "building.tower.mass": ["300 t", "400 t"]})
    says(refusal(pr.amplification, along, kind=SceneError))


def test_the_finding_is_of_the_stiffer_and_the_softer_building(results):
    periods = results["building_period"].isel(fixed_period=0).values
    values = results["displacement_amplification"].sel(percentile=84).isel(fixed_period=0).values
    stiffer = max(values[r, g, b] for r in range(4) for g in range(4) for b in range(2)
                  if periods[r, b] <= periods[r, 1 - b])  # fmt: skip
    place = chart.worst(results, stiffer=True)
    assert place.value == stiffer > 1.0
    at = {"percentile": 84, "building": place.building, "period_ratio": place.ratio, "gap": place.gap}
    cell = results["displacement_amplification"].sel(at)
    assert float(cell.isel(fixed_period=0)) == stiffer
    words = results.attrs["finding"]
    assert f"the stiffer building up to {stiffer:.2f} times (T(tower) / T(hall) = {place.ratio:.2g}" in words
    still = results.assign(displacement_amplification=xr.ones_like(results["displacement_amplification"]))
    assert chart.finding(still).endswith("the stiffer building nowhere; the softer one nowhere")


def test_the_dataset_is_written_read_and_drawn(results, tmp_path, says):
    path = tmp_path / "a.nc"
    made = pr.amplification(scene(), path, **RANGE)
    read = pr.open_results(path)
    xr.testing.assert_identical(read, made)
    assert read.pounding.kind == "amplification" and made.attrs["finding"] in repr(read.pounding).replace("\n", " ")
    units = {name: read[name].attrs["units"] for name in ("displacement_amplification", "gap", "period_ratio")}
    assert units == {"displacement_amplification": "1", "gap": "m", "period_ratio": "1"}
    says(refusal(pr.spectra, scene(), path, num=2))
    table = amplification_table(read)
    assert len(table) == 4 * 4 * 2
    row = table.query("period_ratio == 0.8 and building == 'hall'").set_index("gap").loc[[read["gap"][1].item()]]
    formula = read.assign_coords(building=["=1+1", "hall"])
    FILES["table"].write(formula, tmp_path / "a.csv")
    assert ",'=1+1," in (tmp_path / "a.csv").read_text()  # which no spreadsheet runs
    cell = read.isel(fixed_period=0, gap=1).sel(period_ratio=0.8, building="hall")
    assert float(row["displacement_amplification_84"].iloc[0]) == float(cell["displacement_amplification"][2])
    assert float(row["contact_share"].iloc[0]) == float(cell["contact_share"])
    words = words_of(read.pounding.figure())
    assert words.startswith("Pounding raises the peak displacement that 84 % of the motions do not exceed: the stiffer")
    assert "m(tower) / m(hall) = 2.67" in words
    figure = amplification_figure(results, "acceleration", percentile=50)
    assert figure.get_suptitle().startswith("Pounding raises the peak acceleration that 50 % of the motions do not")
    drawn = figure.axes[2].get_lines()[0].get_ydata()
    told = results["acceleration_amplification"].sel(percentile=50).isel(fixed_period=0, gap=0, building=0)
    np.testing.assert_array_equal(drawn, told)


WRONG = {
    "ratios": [(0.0, 2.0), (2.0, 1.0)],
    "num": [1],
    "gaps": [("20 mm", "10 mm")],
    "gap_shares": ["0.5"],
    "share_of": ["srs", "italy"],
    "fixed": ["middle"],
    "periods": [(0.5, 0.5), "0 s", 1e-4],
    "mass_ratio": [2.0],
    "percentiles": [()],
}


def test_what_cannot_be_meant_is_refused(says):
    says(*refusals(pr.amplification, scene(), wrong=WRONG))
    says(refusal(pr.amplification, scene(), gaps=("1 mm", "2 mm"), gap_shares=(0.1, 1)))


def test_other_buildings_and_sources_are_refused(monkeypatch, says):
    storeys = storeyed("A", "200 t", "9e7 N/m", storeys=2), single("B", "300 t", "0.5 s")
    tables = tomllib.loads(scene_text(*storeys, records=RECORDS))
    says(refusal(pr.amplification, tables, kind=SceneError), refusal(pr.amplification, [3]))
    monkeypatch.setattr(study, "MOST_BYTES", 1e3)
    says(refusal(pr.amplification, scene()))
