"""Ground-motion fields of OpenQuake: probabilities against the closed form, sites, events without a row, damage."""

import json

import commands
import numpy as np
import pytest
from damaged_tables import survey
from made_hazard import fragility
from scenes import BOTH, scene_text, single
from scipy.stats import norm
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.gmfs import read_fields, scenario_of
from pounding_risk.errors import PoundingError

G = 9.80665
ROWS = ("0,0,0.1,0.2,0.05", "0,1,0.3,0.8,0.2", "1,1,0.2,0.4,0.1", "2,0,0.4,0.5,0.1")
NEW = "\n".join(["event_id,site_id,gmv_PGA,gmv_SA(0.2),gmv_SA(0.8)", *ROWS]) + "\n"
OLD = "rlzi,sid,eid,gmv_PGA,gmv_IA\n0,0,0,0.1,1\n0,1,0,0.3,1\n0,1,1,0.2,1\n1,0,0,0.4,1\n"
CURVE = '# mean, investigation_time=50.0,imt="PGA"\nlon,lat,depth,poe-0.1,poe-0.3,poe-0.6\n23.7,38,0,0.5,0.1,0.01\n'
SCENE = scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "20 t", "0.3 s"),
    law="linear",
    gap="20 mm",
    records={"names": ["RSN6-180", "RSN6-270", "RSN1690-090"], "window": ["0 s", "8 s"], "polarity": BOTH},
    grid={"pga": ["0.1 g", "0.3 g"]},
)


@pytest.fixture
def fields(tmp_path):
    path = tmp_path / "gmf-data_7.csv"
    path.write_text("#,,,\"generated_by='OpenQuake engine 3.15.0'\"\n" + NEW)
    (tmp_path / "sitemesh_7.csv").write_text("site_id,lon,lat\n0,23.7,38.0\n1,23.8,38.1\n")
    return path


def test_lognormal_intensities_give_the_closed_form():
    """The mean of Φ(ln(im/θ)/β) over im of median m and deviation σ is Φ(ln(m/θ)/√(β² + σ²))."""
    levels = 2.0 * np.exp(0.6 * norm.ppf((np.arange(4000) + 0.5) / 4000))
    exact = norm.cdf(np.log(2.0 / 3.0) / np.hypot(0.4, 0.6))
    scenario = scenario_of(levels, fragility(), 0.95)
    assert scenario.probability == pytest.approx(exact, rel=1e-4) and scenario.left_out == 0.0
    assert scenario.low < exact < scenario.high
    sharp = scenario_of(levels, fragility(se_median=1e-9, se_dispersion=1e-9), 0.95)
    one = norm.cdf(np.log(levels / 3.0) / 0.4).std() / np.sqrt(4000)  # only the sampling of events is left
    assert sharp.high - sharp.low == pytest.approx(2 * 1.96 * one, rel=0.15)


def test_events_without_a_row_count_and_bound():
    scenario = scenario_of(np.array([3.0, 0.0, 6.0, 0.0]), fragility(), 0.95)
    weakest, strong = 0.5, norm.cdf(np.log(2.0) / 0.4)
    assert scenario.probability == pytest.approx((weakest + strong) / 4)
    assert scenario.left_out == pytest.approx(0.5 * weakest)
    assert scenario.high >= scenario.probability + scenario.left_out
    silent = scenario_of(np.zeros(4), fragility(), 0.95)
    assert silent.probability == 0.0 and np.isnan(silent.left_out)


def test_both_layouts_and_the_sites(fields):
    by_id, by_place = read_fields(f"{fields}#0"), read_fields(f"{fields}#23.71,38.0")
    np.testing.assert_allclose(by_id.levels["pga"], G * np.array([0.1, 0.0, 0.4]))
    np.testing.assert_allclose(by_place.levels["sa(0.2 s)"], G * np.array([0.2, 0.0, 0.5]))
    np.testing.assert_allclose(by_id.at("sa(0.4 s)")[2], G * np.sqrt(0.5 * 0.1))  # half way in ln(T)
    assert "0.876 km from 23.71, 38. 3 events, 2 of them with a row" in by_place.reading[0]
    assert not by_id.has("sa(1 s)") and not by_id.has("sa(0.4 s, 2 %)")
    fields.write_text(OLD)
    old = read_fields(f"{fields}#0")
    np.testing.assert_allclose(old.levels["pga"], G * np.array([0.1, 0.0, 0.4]))
    assert old.reading[1:] == ("Left out, as datasets do not hold it: gmv_IA.", "Realisations are not weighted.")


@pytest.mark.parametrize(
    ("site", "old", "new"),
    [
        ("", "", ""),
        ("#5", "", ""),
        ("#20.0,38.0", "", ""),
        ("#0", "1,1,0.2", "0,0,0.2"),
        ("#0", "0,0,0.1", "0,0,-0.1"),
        ("#0", "0,0,0.1", "0,0,x"),
        ("#0", "gmv_", "iml_"),
    ],
)
def test_files_and_sites_that_cannot_be_used(fields, site, old, new, says):
    fields.write_text(NEW.replace(old, new) if old else NEW)
    says(refusal(read_fields, f"{fields}{site}"))


@pytest.mark.complete
def test_damaged_files_are_read_soundly_or_refused_by_name(fields):
    def check(read):
        assert all(np.isfinite(levels).all() and (levels >= 0.0).all() for levels in read.levels.values())

    outcomes = survey(fields, lambda: read_fields(f"{fields}#0"), check)
    assert min(outcomes["read"], outcomes["refused"]) > 200


def test_a_place_needs_the_table_of_sites(fields, says):
    (fields.parent / "sitemesh_7.csv").unlink()
    says(refusal(read_fields, f"{fields}#23.7,38.0"))


def test_an_assessment_tells_the_probability_in_an_event(fields, monkeypatch, says):
    scan = fields.parent / "scan.nc"
    dataset = pr.scan(pr.read_scene(SCENE), scan, check_fraction=0.0)
    assessed = pr.assess(dataset, gmfs=f"{fields}#1")
    (pair,) = assessed.interfaces
    contact = next(one for one in pair.fragility if one.what == "contact" and one.gap == pair.gap)
    scenario = next(one for one in pair.scenario if one.what == "contact" and one.gap == pair.gap)
    by_hand = norm.cdf(np.log(G * np.array([0.3, 0.2]) / contact.median) / contact.dispersion).sum() / 3
    assert assessed.intensity == "pga" and scenario.probability == pytest.approx(by_hand)
    at_sa = pr.assess(dataset, gmfs=f"{fields}#1", intensity="sa(0.5 s)")
    assert len(at_sa.interfaces[0].scenario) == len(at_sa.interfaces[0].fragility)
    says(refusal(pr.assess, dataset, gmfs=f"{fields}#1", intensity="sa(1 s)"))
    monkeypatch.chdir(fields.parent)
    done = commands.done("assess", "scan.nc", "--gmfs", "gmf-data_7.csv", "--site", "23.8,38.1", "-o", "a.json")
    assert "probability in an event of gmf-data_7.csv#23.8,38.1, by its PGA at the site" in done.output
    written = json.loads((fields.parent / "a.json").read_text())
    assert written["interfaces"][0]["scenario"][0]["probability"] is not None
    (fields.parent / "curve.csv").write_text(CURVE)
    done = commands.done("assess", "scan.nc", "--hazard", "curve.csv", "--site", "23.71,38")
    assert "The site is at 23.7, 38, 0.876 km from 23.71, 38" in done.output


def test_states_of_damage_have_their_probability_in_an_event(fields):
    states = [{"name": "cracks", "displacement": "20 mm"}]
    scanned = pr.scan(pr.read_scene(SCENE), check_fraction=0.0)
    dataset = pr.damage(scanned, states=states, method="ida", gmfs=f"{fields}#0")
    for side in ("with", "without"):
        one = dataset.sel(pounding=side, state="cracks")
        each = norm.cdf(np.log(G * np.array([0.1, 0.4]) / float(one["median"])) / float(one["dispersion"]))
        assert float(one["event_probability"]) == pytest.approx(each.sum() / 3)
    assert any("3 events, 2 of them with a row" in sentence for sentence in json.loads(dataset.attrs["assumptions"]))


@pytest.mark.parametrize("column", [0, 1], ids=["event_id", "site_id"])
@pytest.mark.parametrize("found", ["3.7", "3\t", "\t3", "3\t7", "-3", "-inf", "nan", "1e3", "", "\u0663", "0x3"])
def test_an_id_that_is_none_is_refused_by_its_line(found, column, fields):
    """A row of such an id would count for another site, and the event as without shaking at this one."""
    name = ("event_id", "site_id")[column]
    rows = [row.split(",") for row in ROWS]
    rows[1][column] = found
    fields.write_text(NEW.partition("\n")[0] + "\n" + "".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
    told = f"gmf-data_7.csv, line 3: {name} is .*; it must be a whole number such as 3"
    with pytest.raises(PoundingError, match=told):
        read_fields(f"{fields}#0")


@pytest.mark.parametrize("found", ["-3", "-inf", "3.7", "1\t"])
def test_an_id_of_the_mesh_that_is_none_is_refused_by_its_line(found, fields):
    (fields.parent / "sitemesh_7.csv").write_text(f"site_id,lon,lat\n0,23.7,38.0\n{found},23.8,38.1\n")
    with pytest.raises(PoundingError, match=r"sitemesh_7.csv, line 3: site_id is .*; it must be a whole number"):
        read_fields(f"{fields}#23.7,38.0")


def test_an_id_with_zeros_before_it_is_the_same_site(fields):
    fields.write_text(NEW.replace("1,1,0.2", "1,01,0.2"))
    assert read_fields(f"{fields}#1").at("pga") == pytest.approx(G * np.array([0.3, 0.2, 0.0]))
