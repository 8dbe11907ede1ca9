"""Fragilities of damage states with pounding and without: closed forms, SciPy's fits, mirrored scenes, and refusals."""

import csv
import json
import tomllib

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from scenes import BOTH, rigid, scene_text, single, storeyed
from scipy.optimize import minimize
from scipy.stats import norm
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.damage_curves import demands_of
from pounding_risk.assessment.damage_words import finding
from pounding_risk.assessment.hazard import Hazard
from pounding_risk.errors import PoundingError
from pounding_risk.questions.damage import damage_table, sheet
from pounding_risk.reports.exports import Options
from pounding_risk.reports.exports._fragilities import fragilities_of
from pounding_risk.results.check import kind_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.damage_fits import Observed, fit_ida
from pounding_risk.statistics.fragility import fit_capacities
from pounding_risk.statistics.hazard import annual_rate
from pounding_risk.units import STANDARD_GRAVITY

G = STANDARD_GRAVITY
NAMES = ["RSN6-180", "RSN77-164", "RSN753-000", "RSN753-090", "RSN1690-090", "NAPA-HNE"]
RECORDS = {"names": NAMES, "window": ["0 s", "10 s"], "polarity": BOTH}
MASSES = single("left", "10 t", "0.5 s", height="6 m"), single("right", "30 t", "0.8 s", height="6 m", damping=0.03)
PGAS = ["0.1 g", "0.2 g", "0.3 g", "0.4 g", "0.6 g", "0.8 g", "1.2 g"]
GRID = {"gap": ["10 mm", "900 mm"], "pga": PGAS}
PAIR = scene_text(*MASSES, law="linear", tolerance=None, records=RECORDS, grid=GRID)
STATES = [
    pr.DamageState("cracks", building="left", drift="0.6 %"),
    pr.DamageState("tiles", displacement="80 mm"),
    pr.DamageState("equipment", acceleration="2 g"),
    pr.DamageState("blow", contact_force="200 kN"),
]
STOREYS = storeyed("A", "20 t", "12 MN/m", storeys=3, storey_strengths="90 kN")
ONE_STOREY = storeyed("B", "40 t", "40 MN/m", "3.9 m", storeys=1, storey_strengths="150 kN")
ROW = scene_text(
    STOREYS,
    ONE_STOREY,
    rigid(height="12 m"),
    law="linear",
    records={"names": ["RSN6-180", "NAPA-HNE"], "window": ["0 s", "8 s"]},
    effects={"inelastic_storeys": {}},
    grid={"gap": ["10 mm", "900 mm"], "pga": ["0.2 g", "0.5 g"]},
)


@pytest.fixture(scope="module")
def scan() -> xr.Dataset:
    return pr.scan(tomllib.loads(PAIR), check_fraction=0.0)


@pytest.fixture(scope="module")
def row() -> xr.Dataset:
    return pr.scan(tomllib.loads(ROW), check_fraction=0.0)


@pytest.fixture(scope="module")
def stripes(scan) -> xr.Dataset:
    return pr.damage(scan, states=STATES)


@pytest.fixture(scope="module")
def ida(scan) -> xr.Dataset:
    return pr.damage(scan, states=STATES, method="ida")


def flat(values: xr.DataArray) -> np.ndarray:
    """By motion, in the order of a dataset."""
    return values.transpose("record", "polarity", ...).values.reshape(len(NAMES) * 2, -1)


@pytest.mark.complete
def test_without_any_touch_pounding_changes_nothing(scan):
    """At a gap that no motion closes, both curves are one, and so are all samples of recordings."""
    apart = pr.damage(scan, states=STATES[:3], gap="900 mm", method="ida")
    assert float(scan["impact_count"].sel(gap=0.9).max()) == 0.0
    for name in ("median", "dispersion", "reached", "capacity"):
        np.testing.assert_allclose(*(apart[name].sel(pounding=side) for side in ("with", "without")), rtol=1e-9)
    for ending in ("", "_low", "_high"):
        np.testing.assert_allclose(apart[f"median_ratio{ending}"], 1.0, rtol=1e-9)


def test_a_linear_mass_reaches_a_state_where_scaling_says(scan, ida):
    """Demands without contact are proportional to the motion: the capacity is level × threshold / peak, between
    levels exactly, for straight lines are then no approximation."""
    peaks = flat(scan["peak_displacement_free"].sel(building="left"))[:, 0]
    scaled = 0.1 * G * 0.006 * 6.0 / peaks  # 0.6 % of 6 m
    one = ida.sel(state="cracks", pounding="without")
    status, values = flat(one["capacity_status"])[:, 0], flat(one["capacity"])[:, 0]
    assert (status == 0).sum() >= 8
    np.testing.assert_allclose(values[status == 0], scaled[status == 0], rtol=1e-6)
    assert (scaled[status == -1] <= 0.1 * G).all() and (scaled[status == 1] > 1.2 * G).all()


def test_where_all_capacities_are_known_the_fit_is_that_of_capacities(scan):
    """A threshold that all motions reach between the levels, or all but few: then the fit to what is known of each."""
    peaks = flat(scan["peak_displacement_free"].sel(building="right"))[:, 0]
    lowest, highest = 12.0 * peaks.min(), 1.0 * peaks.max()
    assert highest < lowest, "a threshold between both is reached by all motions between their levels"
    threshold = float(np.sqrt(lowest * highest))
    state = pr.DamageState("tiles", building="right", displacement=threshold)
    found = pr.damage(scan, states=[state], method="ida").sel(state="tiles", pounding="without")
    assert (found["capacity_status"] == 0).all()
    recordings = np.repeat(scan["record_recording"].values, 2)
    other = fit_capacities(0.1 * G * threshold / peaks, recordings)
    assert float(found["median"]) == pytest.approx(other.median, rel=1e-6)
    assert float(found["dispersion"]) == pytest.approx(other.dispersion, rel=1e-6)
    errors = max(other.se_median, other.se_median_recordings)
    assert float(found["median_error"]) == pytest.approx(errors, rel=1e-5)


def test_demands_are_the_variables_of_the_scan(scan, stripes):
    """Read here by hand, with contact at the scene's own gap and without."""
    own = scan.sel(gap=0.01).isel(contact_model=0, yield_force=0)
    heights = 6.0
    expected = {
        "cracks": (own["peak_displacement"], scan["peak_displacement_free"], "left", 0.006 * heights),
        "tiles": (own["peak_displacement"], scan["peak_displacement_free"], None, 0.08),
        "equipment": (own["peak_floor_acceleration"], scan["peak_floor_acceleration_free"], None, 2.0 * G),
    }
    for state, (*both, building, threshold) in expected.items():
        for side, values in zip(("with", "without"), both, strict=True):
            one = values.max("building") if building is None else values.sel(building=building)
            found = stripes["demand_ratio"].sel(state=state, pounding=side)
            np.testing.assert_allclose(flat(found), flat(one) / threshold, rtol=1e-12)
    force = own["peak_contact_force"].isel(interface=0)
    np.testing.assert_allclose(flat(stripes["demand_ratio"].sel(state="blow", pounding="with")), flat(force) / 2e5)
    assert (stripes["demand_ratio"].sel(state="blow", pounding="without") == 0.0).all()
    assert int(stripes["reached"].sel(state="blow", pounding="with").sum()) == int((force >= 2e5).sum()) > 0


def test_stripes_are_fitted_as_scipy_does(stripes):
    """The binomial likelihood of the counts, minimised without derivatives."""
    for state in ("cracks", "tiles"):
        for side in ("with", "without"):
            one = stripes.sel(state=state, pounding=side)
            reached, runs = one["reached"].values, one["runs"].values

            def lost(point, reached=reached, runs=runs):
                share = norm.cdf(np.log(stripes["level"].values / point[0]) / point[1]).clip(1e-300, 1.0 - 1e-16)
                return -float((reached * np.log(share) + (runs - reached) * np.log1p(-share)).sum())

            best = minimize(lost, [3.0, 0.5], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}).x
            assert (float(one["median"]), float(one["dispersion"])) == pytest.approx(tuple(best), rel=1e-5)
            curve = norm.cdf(np.log(stripes["im"].values / best[0]) / best[1])
            np.testing.assert_allclose(one["probability"], curve, atol=1e-5)


def test_ratios_are_with_over_without(ida):
    median, at = ida["median"], ida["probability_at"]
    np.testing.assert_allclose(ida["median_ratio"], median.sel(pounding="with") / median.sel(pounding="without"))
    np.testing.assert_allclose(ida["at_intensity"], median.sel(pounding="without"))
    compared = ida.isel(state=slice(0, 2))
    np.testing.assert_allclose(compared["probability_at"].sel(pounding="without"), 0.5, rtol=1e-12)
    np.testing.assert_allclose(compared["probability_ratio_at"], at.isel(state=slice(0, 2)).sel(pounding="with") / 0.5)
    assert (compared["median_ratio_low"] < compared["median_ratio"]).all()
    assert (compared["median_ratio"] < compared["median_ratio_high"]).all()
    np.testing.assert_allclose(
        compared["probability_ratio"],
        compared["probability"].sel(pounding="with") / compared["probability"].sel(pounding="without"),
    )


def test_a_ratio_needs_both_curves(scan):
    """Contact forces have no curve without pounding: no ratio either, at any intensity."""
    force = float(scan["peak_contact_force"].sel(gap=0.01).isel(pga=3).median())
    blow = pr.damage(scan, states=[pr.DamageState("blow", contact_force=force)], method="ida").sel(state="blow")
    assert np.isfinite(blow["probability"].sel(pounding="with")).all()
    for name in ("median_ratio", "probability_ratio", "probability_ratio_at", "probability_ratio_high"):
        assert np.isnan(blow[name]).all(), name


def test_percentiles_of_demands_are_numpys(ida):
    values = ida["demand_ratio"].sel(state="tiles", pounding="with")
    found = ida["demand_percentile"].sel(state="tiles", pounding="with", percentile=84)
    np.testing.assert_allclose(found, np.percentile(flat(values), 84, axis=0))


@pytest.mark.complete
def test_a_mirrored_scene_has_the_same_curves(ida):
    """Buildings exchanged and polarities turned: each motion does in the mirror what it does here."""
    turned = scene_text(*reversed(MASSES), law="linear", records=RECORDS, grid={**GRID, "gap": ["10 mm"]})
    mirrored = pr.damage(pr.scan(tomllib.loads(turned), check_fraction=0.0), states=STATES, method="ida")
    for name in ("median", "dispersion", "median_ratio", "reached", "median_ratio_low"):
        np.testing.assert_allclose(mirrored[name], ida[name], rtol=2e-5, err_msg=name)


@pytest.mark.filterwarnings("error")
def test_a_cloud_of_motions_as_recorded():
    scene = scene_text(*MASSES, law="linear", records=RECORDS, gap="10 mm")
    scan = pr.scan(tomllib.loads(scene), check_fraction=0.0)
    found = pr.damage(scan, states=[*STATES[:2], STATES[3]], intensity="sa(0.6 s)", at="0.4 g")
    assert found.attrs["method"] == "cloud" and found.sizes["level"] == 1
    im, demand = flat(found["motion_intensity"]).ravel(), flat(found["demand_ratio"].isel(state=0, pounding=1)).ravel()
    slope, start = np.polyfit(np.log(im), np.log(demand), 1)
    assert float(found["median"].isel(state=0, pounding=1)) == pytest.approx(np.exp(-start / slope), rel=1e-9)
    assert (found["at_intensity"] == 0.4 * G).all()
    assert "no force acts between buildings" in str(found["fault"].sel(state="blow", pounding="without").item())
    assert "a contact force is capped where the contact yields" in found.attrs["assumptions"]
    assert "Sa(0.6 s)" in found.attrs["finding"]


def test_a_force_that_is_capped_at_the_threshold_has_the_median_of_the_counts():
    """F_E is the threshold, as of a column's strength: by intervals IDA agrees with stripes; lines are 27 % higher.

    Intervals and counts are two likelihoods of the same 12 motions at levels 1.2 to 2 times apart: a few per cent.
    """
    text = scene_text(*MASSES, law="viscous_elastoplastic", yield_force="300 kN", records=RECORDS, gap="40 mm")
    scan = pr.scan({**tomllib.loads(text), "grid": {"gap": ["40 mm"], "pga": PGAS}}, check_fraction=0.0)
    state = pr.DamageState("yields", contact_force="300 kN")
    ida, counted = (pr.damage(scan, states=[state], method=name).sel(state="yields") for name in ("ida", "stripes"))
    one = ida.sel(pounding="with").transpose("record", "polarity", "level", ...)
    yields = scan["yield_exceedance"].squeeze().transpose("record", "polarity", "pga").values
    np.testing.assert_array_equal(one["demand_ratio"].values >= 1.0, yields == 1)
    assert float(one["demand_ratio"].max()) == 1.0 and (one["capacity_status"] == 3).any()
    recordings = np.repeat(scan["record_recording"].values, 2)
    of_lines = fit_ida(Observed(flat(one["motion_intensity"]), flat(one["demand_ratio"]), recordings))
    median = float(one["median"])
    assert median == pytest.approx(float(counted["median"].sel(pounding="with")), rel=0.05)
    assert of_lines.median > 1.2 * median
    above = pr.DamageState("above", contact_force="301 kN")
    assert "no run exceeds; write a threshold of 300 kN or less" in refusal(pr.damage, scan, states=[above])


def test_without_contact_a_contact_force_is_said_to_be_impossible(ida):
    fault = str(ida["fault"].sel(state="blow", pounding="without").item())
    assert fault.startswith("no force acts between buildings") and "scan" not in fault
    assert not any("blow, without" in note and "levels" in note for note in json.loads(ida.attrs["assumptions"]))


@pytest.mark.complete
def test_levels_of_a_measure_are_those_of_the_curves():
    """Of PGV, whose unit is another; the capacity of a linear mass is again that of scaling."""
    levels = [0.1, 0.2, 0.4, 0.8, 1.6]
    asked = {"measure": "pgv", "levels": [f"{level} m/s" for level in levels]}
    records = {"names": NAMES[:3], "window": ["0 s", "8 s"], "intensity": asked}
    scan = pr.scan(tomllib.loads(scene_text(*MASSES, law="linear", records=records)), check_fraction=0.0)
    state = pr.DamageState("x", building="left", displacement="60 mm")
    found = pr.damage(scan, states=[state], method="ida", at="50 cm/s")
    assert found["level"].values.tolist() == levels and found.attrs["intensity"] == "pgv"
    assert {found[name].attrs["units"] for name in ("level", "im", "median", "capacity", "at_intensity")} == {"m/s"}
    assert found["at_intensity"].item() == 0.5 and "Median PGV" in found.attrs["finding"]
    one = found.sel(state="x", pounding="without").squeeze("polarity")
    peaks = scan["peak_displacement_free"].sel(building="left").squeeze("polarity").transpose("record", "intensity")
    known = one["capacity_status"].values == 0
    assert known.any()
    np.testing.assert_allclose(one["capacity"][known], (0.1 * 0.06 / peaks[:, 0])[known], rtol=1e-6)


def test_annual_rates_are_those_of_the_curves(scan, says):
    hazard = Hazard("pga", np.array([0.02, 0.5, 2.0, 20.0, 100.0]), np.array([10.0, 0.1, 5e-3, 2e-5, 5e-7]))
    found = pr.damage(scan, states=STATES[:2], hazard=hazard, method="ida")
    for state in found["state"].values:
        for side in ("with", "without"):
            one = found.sel(state=state, pounding=side)
            rate = float(annual_rate(hazard, float(one["median"]), float(one["dispersion"])))
            assert float(one["annual_rate"]) == pytest.approx(rate, rel=1e-12)
            assert one["annual_rate_low"] < rate < one["annual_rate_high"]
    rates = found["annual_rate"]
    np.testing.assert_allclose(found["annual_rate_ratio"], rates.sel(pounding="with") / rates.sel(pounding="without"))
    assert found.attrs["finding"].startswith(
        "Annual rate and median PGA, with pounding at 10 mm over without: cracks rate"
    )
    opposed = found.assign(median_ratio=("state", [0.94, 0.94]), annual_rate_ratio=("state", [0.91, 1.1]))
    first, second = finding(opposed).split("; ")
    assert "cracks rate 0.91" in first and "they point opposite ways" in first and "opposite" not in second
    says(refusal(pr.damage, scan, states=STATES, hazard=hazard, intensity="sa(left)"))


def test_rates_that_a_hazard_curve_cuts_off_are_lower_bounds_without_a_ratio(scan):
    whole = Hazard("pga", np.array([0.5, 2.0, 20.0]), np.array([0.1, 5e-3, 2e-5]))
    found = pr.damage(scan, states=STATES[:2], hazard=whole, method="ida")
    missing = found["annual_rate_missing"].max("pounding").values
    assert missing[0] > 0.05 > missing[1]
    assert np.isnan(found["annual_rate_ratio"].values).tolist() == [True, False]
    assert f"cracks median {float(found['median_ratio'][0]):.2f}" in found.attrs["finding"]
    assert "lie beyond the hazard curve" in found.attrs["finding"]
    (table,) = [block for block in sheet(found) if "Annual rates" in block.get("caption", "")]
    assert "Two such numbers have no ratio" in table["caption"]
    texts = [[cell["text"] if isinstance(cell, dict) else cell for cell in row] for row in table["rows"]]
    assert "at least" in " ".join(texts[0]) and "at least" not in " ".join(texts[1])


def test_the_gaps_of_a_row_are_those_of_its_interfaces():
    """Not that of the grid, which is the first's alone: of three each by its name, of more their range."""
    chain = [single(name, f"{20 + at} t", "0.5 s") for at, name in enumerate("ABCDE")]
    for gaps, words in (
        (["1 m", "30 mm"], "1 m (A | B) and 30 mm (B | C)"),
        (["1 m", "30 mm", "40 mm", "50 mm"], "30 mm to 1 m, by interface"),
    ):
        scene = tomllib.loads(scene_text(*chain[: len(gaps) + 1], law="linear", records={"names": NAMES[:1]}))
        scene["interface"] = [{**scene["interface"][0], "gap": gap} for gap in gaps]
        found = pr.damage(pr.scan(scene, check_fraction=0.0), states=[pr.DamageState("x", displacement="1 mm")])
        assert f"with pounding at {words}" in found.attrs["finding"]
        assert f"gap {words}, linear" in sheet(found)[2]["caption"]
        (row, _) = csv.DictReader(damage_table(found).splitlines())
        assert (row["gap of A | B [m]"], row["gap of B | C [m]"]) == ("1.0", "0.03") and "gap [m]" not in row


def test_a_row_without_its_drifts_has_no_drift_of_roofs_instead(row):
    for name in ("storey_drift_free", "storey_drift"):
        with pytest.raises(PoundingError, match=f"the results have no variable {name}, "):
            pr.damage(row.drop_vars(name), states=[pr.DamageState("x", drift=0.01)])


def test_demands_of_storeys_and_columns(row):
    """The largest of the storeys over their heights, of one storey, of yielding, and on a struck column."""
    states = [
        pr.DamageState("drift", drift=0.01),
        pr.DamageState("first", building="A", storey=1, drift=0.01),
        pr.DamageState("residual", building="A", residual_drift=0.002),
        pr.DamageState("shear", building="A", storey_shear="80 kN"),
        pr.DamageState("column", column_shear="1 kN"),
        pr.DamageState("mass", building="B", ductility=2),
    ]
    found = pr.damage(row, states=states)["demand_ratio"].isel(polarity=0).transpose("state", "pounding", "record", ...)
    own = row.sel(gap=0.01).isel(contact_model=0, yield_force=0, polarity=0).transpose("record", "pga", ...)
    free = row.isel(polarity=0).transpose("record", "pga", ...)
    heights = np.array([[3.0, 3.0, 3.0], [3.9, np.nan, np.nan]])
    for side, part, ending in ((0, own, ""), (1, free, "_free")):
        drifts = part[f"storey_drift{ending}"].values[:, :, :2] / heights
        np.testing.assert_allclose(found[0, side], np.nanmax(drifts, axis=(2, 3)) / 0.01)
        np.testing.assert_allclose(found[1, side], drifts[:, :, 0, 0] / 0.01)
        rest = part[f"storey_residual_drift{ending}"].values[:, :, 0]
        np.testing.assert_allclose(found[2, side], rest.max(axis=-1) / 3.0 / 0.002)
        np.testing.assert_allclose(found[3, side], part[f"peak_storey_shear{ending}"].values[:, :, 0] / 8e4)
        # A yielding single mass: its one drift over strength / stiffness.
        ductility = part[f"storey_drift{ending}"].values[:, :, 1, 0] / (15e4 / 40e6)
        np.testing.assert_allclose(found[5, side], ductility / 2.0)
    # At a gap that nothing closes storeys yield as they do without contact.
    assert float(row["impact_count"].sel(gap=0.9).max()) == 0.0
    apart = pr.damage(row, states=states[:4], gap="900 mm")["demand_ratio"]
    np.testing.assert_allclose(*(apart.sel(pounding=side) for side in ("with", "without")), rtol=1e-6)
    assert float(found[5, 1].max()) > 0.5  # it yields
    columns = row["contact_point_kind"].values == "column"
    assert 0 < columns.sum() < columns.size
    force = own["contact_point_peak_contact_force"].values[..., columns].max(axis=-1)
    np.testing.assert_allclose(found[4, 0], force / 1e3)
    assert float(found[4, 0].max()) > 0.0 and (found[4, 1] == 0.0).all()


def test_demands_of_links_are_those_of_the_device_with_contact_and_without():
    """Its stroke in both directions and its forces; what joins two buildings acts without contact too."""
    link = {"link_stiffness": "5 MN/m", "link_damping": "400 kN s/m", "link_exponent": 0.4}
    old, new = single("old", "300 t", "0.6 s"), single("new", "200 t", "0.3 s")
    levels = {"grid": {"pga": ["0.1 g", "0.4 g"]}}
    results = pr.scan(parse_scene(scene_text(old, new, gap="10 mm", **levels, **link)))
    thresholds = {"link_stretch": 0.02, "link_shortening": 0.01, "link_spring_force": 1e5, "link_damper_force": 2e5}
    states = [pr.DamageState(key, interface="old | new", **{key: value}) for key, value in thresholds.items()]
    found = pr.damage(results, states=states)
    assert "the buildings with their links but without contact under the same motion" in str(sheet(found))
    (stated,) = (words for words in pr.assess(results).interfaces[0].verdict.evidence if "join the two" in words)
    assert "(link_stiffness = 5 MN/m, link_damping = 400 kN s/m)" in stated
    case = results.isel(gap=0, contact_model=0, yield_force=0)
    for state, (key, value) in enumerate(thresholds.items()):
        for side, ending in enumerate(("", "_free")):
            peaks = case[f"peak_{key}{ending}"].squeeze().values
            assert (peaks > 0.0).all()
            np.testing.assert_allclose(found["demand_ratio"].values[state, side].ravel(), peaks / value)
    assert states[0].words == "stretch of a link at old | new ≥ 20 mm"
    without = pr.scan(parse_scene(scene_text(old, new, gap="10 mm", **levels)))
    assert "link_stretch: no link joins them; write link_stiffness" in refusal(pr.damage, without, states=states[:1])


def test_shears_are_capped_by_strengths_of_their_own_storeys_alone(row):
    """Beside a building that yields the shear of an elastic one is no capped demand, of which a fit knows less."""
    case = row.isel(gap=0, contact_model=0, yield_force=0)
    ductility = case["storey_ductility"]
    beside = case.assign(storey_ductility=ductility.where(case["building"] != "A"))
    upper = case.assign(storey_ductility=ductility.where(case["storey"] > 1))
    first = pr.DamageState("first", building="A", storey=1, storey_shear="80 kN")
    shear = pr.DamageState("shear", building="A", storey_shear="80 kN")
    every = pr.DamageState("every", storey_shear="80 kN")
    found = [demands_of(one, state).jumps for one in (case, beside, upper) for state in (first, shear, every)]
    assert found == [True, True, True, False, False, True, False, True, True]


def test_states_of_one_interface_or_contact_point(row):
    label = str(row["contact_point"].values[0])
    states = [
        pr.DamageState("right", interface="B | wall", contact_force="1 kN"),
        pr.DamageState("point", contact_point=label, contact_force="1 kN"),
    ]
    found = pr.damage(row, states=states)["demand_ratio"].sel(pounding="with").isel(polarity=0)
    own = row.sel(gap=0.01).isel(contact_model=0, yield_force=0, polarity=0)
    at_wall = own["peak_contact_force"].sel(interface="B | wall").transpose("record", "pga")
    np.testing.assert_allclose(found.sel(state="right"), at_wall / 1e3)
    point = own["contact_point_peak_contact_force"].isel(contact_point=0).transpose("record", "pga")
    np.testing.assert_allclose(found.sel(state="point"), point / 1e3)


def test_a_state_that_no_run_reaches_is_told(scan, says):
    found = pr.damage(scan, states=[pr.DamageState("ruin", displacement="9 m")], method="ida")
    assert np.isnan(found["median"]).all() and (found["reached"] == 0).all()
    says(found.attrs["finding"], json.loads(found.attrs["assumptions"]))


def test_a_state_that_the_dataset_lacks_is_left_out_and_the_others_are_answered(scan, ida, stripes):
    """Said with its reason in the sheet, the CSV, both figures and exports; the other states keep their bits."""
    pull = pr.DamageState("pull", link_spring_force="500 kN")
    why = "link_spring_force: no link there has a spring; take link_stretch"
    for method, alone in (("ida", ida), ("stripes", stripes)):
        found = pr.damage(scan, states=[pull, *STATES], method=method)
        xr.testing.assert_identical(found.isel(state=slice(1, None)).drop_attrs(), alone.drop_attrs())
        assert not found["runs"].isel(state=0).any() and np.isnan(found["demand_ratio"].isel(state=0)).all()
        shown = str(sheet(found))
        assert f"; pull is left out ({why})." in shown and f"pull is left out: {why}." in shown
        rows = list(csv.DictReader(damage_table(found).splitlines()))
        assert [(row["fault"], row["runs"], row["median [m/s2]"]) for row in rows[:2]] == [(why, "0", "")] * 2
        words = words_of(found.pounding.figure())
        assert why in words and "pull:" not in words
        words = words_of(found.pounding.figure("ida"))
        assert "no run has the demand of pull" in words and "link" not in words
        told = "; ".join(fragilities_of(found, Options()).notes)
        assert f"pull, with pounding: no curve, {why}" in told


def test_states_that_the_dataset_lacks_are_refused_where_there_are_no_others(scan, says):
    pull = {"name": "pull", "link_spring_force": "500 kN"}
    says(refusal(pr.damage, scan, states=[pull, {"name": "part", "link_stretch": "20 mm"}]))


def test_the_same_motions_give_the_same_bounds(scan, ida):
    again = pr.damage(scan, states=STATES, method="ida")
    assert again.identical(ida)


def test_states_of_the_scene_and_a_file_that_overrides_them(scan, tmp_path):
    text = '[[damage]]\nname = "cracks"\nbuilding = "left"\ndrift = "0.6 %"\n'
    own = scan.assign_attrs(scene_resolved=scan.attrs["scene_resolved"] + "\n" + text)
    del own.attrs["scene_sha256"]
    assert pr.damage(own)["state_words"].item() == "storey drift of left ≥ 0.6 %"
    file = tmp_path / "states.toml"
    file.write_text(text.replace("0.6 %", "0.9 %"), encoding="utf-8")
    assert pr.damage(own, states=file)["state_words"].item() == "storey drift of left ≥ 0.9 %"


def test_the_dataset_and_its_table(ida, tmp_path):
    assert kind_of(ida) == "damage" == ida.pounding.kind
    assert ida.attrs["finding"] in repr(ida.pounding).replace("\n", " ")
    pr.save(ida, tmp_path / "d.nc")
    again = pr.open_results(tmp_path / "d.nc")
    xr.testing.assert_allclose(again, ida)
    rows = list(csv.DictReader(damage_table(again).splitlines()))
    assert [row["state"] for row in rows[::2]] == [state.name for state in STATES]
    assert float(rows[0]["median [m/s2]"]) == pytest.approx(float(ida["median"][0, 0]), rel=1e-12)
    assert rows[7]["median [m/s2]"] == "" and rows[7]["fault"].startswith("no force acts between buildings")
    assert int(rows[0]["reached"]) == int(ida["reached"][0, 0].sum())


REFUSED = [
    {"states": [{"name": "x", "building": "lft", "drift": "1 %"}]},
    {"states": [{"name": "x", "ductility": 2}]},
    {"states": [{"name": "x", "column_shear": "1 kN"}]},
    {"states": [{"name": "x", "storey": 2, "drift": "1 %"}]},
    {"states": [{"name": "x", "contact_point": "left 1 | right 2", "contact_force": "1 N"}]},
    {"method": "idea"},
    {"gap": "11 mm"},
    {"contact_model": "herz"},
    {"intensity": "sa(roof)"},
    {"at": "3 s"},
    {"confidence": 0.3},
    {"states": None},
]


@pytest.mark.parametrize("asked", REFUSED, ids=str)
def test_what_cannot_be_answered_is_refused_with_its_repair(scan, asked, says):
    says(refusal(pr.damage, scan, **{"states": STATES, **asked}))


def test_a_drift_needs_heights_and_a_building_that_moves(row, says):
    bare = scene_text(*(single(name, "10 t", "0.5 s") for name in "AB"), records={"window": ["0 s", "2 s"]})
    scan = pr.scan(tomllib.loads(bare), check_fraction=0.0)
    says(
        refusal(pr.damage, scan, states=[pr.DamageState("x", drift=0.01)]),
        refusal(pr.damage, row, states=[pr.DamageState("x", building="wall", drift=0.01)]),
        refusal(pr.damage, row, states=[pr.DamageState("x", building="B", storey=2, ductility=2)]),
    )


def test_jumps_in_velocity_have_no_acceleration_and_no_force():
    """What a dataset has there is that between the jumps: less than without contact, whose floors no wall stops."""
    grid = {"gap": ["10 mm", "900 mm"], "pga": PGAS, "contact_model": ["jankowski", "stereomechanical"]}
    text = scene_text(*MASSES, tolerance=None, records=RECORDS, grid=grid)
    results = pr.scan(tomllib.loads(text), check_fraction=0.0)
    found = pr.damage(results, states=STATES, gap="10 mm", contact_model="stereomechanical")
    touched = (results["impact_count"].sel(gap=0.01, contact_model="stereomechanical") > 0).values
    runs = found["runs"].sum("level")
    for state, known in (("tiles", touched.size), ("equipment", (~touched).sum()), ("blow", (~touched).sum())):
        assert (runs.sel(state=state) == known).all()
    assert f"equipment: {touched.sum()} runs of {touched.size} failed, or have no such demand" in str(found.attrs)
    reached = (
        f"blow is reached in 0 of {(~touched).sum()} runs with pounding, not known of {touched.sum()} others, and in"
    )
    assert reached in found.attrs["finding"]  # of those without contact alone
    (one,) = pr.assess(results, gap="10 mm").interfaces
    counts = {item.output: item.motions for item in one.response if item.contact_model == "stereomechanical"}
    assert counts["peak_floor_acceleration"] == counts["peak_contact_force"] == 0 < counts["peak_relative_displacement"]
    words = {each.output: each.words for each in one.sensitivity if each.key == "contact_model"}
    assert words["peak_contact_force"].endswith(("scan several to see", "not defined for stereomechanical"))
