"""Motions in which a storey collapses: at the levels where they do, no gap is wide enough; nothing forgets them."""

import csv
import sqlite3
from math import inf

import numpy as np
import pytest
from explorer_page import unpacked
from figure_words import words_of
from scenes import scene_text, storeyed
from scipy.optimize import minimize
from scipy.special import log_ndtr

import pounding_risk as pr
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.demands import motions_of
from pounding_risk.questions.along import findings
from pounding_risk.questions.simulate import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.reports.data import ReportData
from pounding_risk.reports.explorer import page_model
from pounding_risk.reports.sections import records
from pounding_risk.results.opened import Results

G = 9.80665
LAW = {"rule": "peak_oriented", "backbone": [[4.0, 1.15], [12.0, 0.3]], "collapse_drift": 0.03}
STRENGTHS = {"storey_strengths": ["1100 kN", "700 kN"], "hysteresis": LAW}
FRAME = storeyed("frame", ["200 t", "180 t"], ["150 MN/m", "120 MN/m"], "3.2 m", **STRENGTHS)
WALL = storeyed("wall", ["180 t"], "700 MN/m", ["3.2 m"])
RECORDS = {
    "names": ["RSN6-180", "RSN6-270", "RSN753-000", "RSN753-090", "CCC-HN1", "NAPA-HNE"],
    "window": ["0 s", "15 s"],
}
INELASTIC = {"inelastic_storeys": {}, "p_delta": {}}
DAMAGE = '[[damage]]\nname = "blow"\ncontact_force = "1 MN"\n'


def scene(grid, **more):
    return scene_text(FRAME, WALL, effects=INELASTIC, gap="40 mm", records=RECORDS, grid=grid, **more) + DAMAGE


@pytest.fixture(scope="module")
def results():
    """Six motions at three levels: at 0.4 g one closes 40 mm, at 0.8 g the frame collapses in five."""
    whole = pr.scan(scene({"pga": ["0.2 g", "0.4 g", "0.8 g"]}))
    fell = whole["status"].squeeze().values > 0
    assert fell.sum(axis=0).tolist() == [0, 0, 5]
    closing = whole["peak_closing_free"].squeeze().values
    assert ((closing > 0.04) & ~fell).sum(axis=0).tolist() == [0, 1, 0]
    return whole


def test_a_level_counts_the_motions_that_collapse_at_another(results):
    one = pr.assess(results, pga="0.4 g").interfaces[0]
    assert (one.contact[0].count, one.contact[0].runs) == (1, 6)
    assert len(one.closing) == 6
    assert not any("finite response, and counted" in sentence for sentence in one.verdict.evidence)
    lost = pr.assess(results, pga="0.8 g").interfaces[0]
    assert (lost.contact[0].count, lost.contact[0].runs) == (0, 1)
    assert any("counted against the verdict: 5 motions" in sentence for sentence in lost.verdict.evidence)
    assert any("storey 1 of frame in 5, first at 2.225 s" in sentence for sentence in lost.verdict.evidence)
    times = results["storey_collapse_time"]
    assert (times.max(("building", "storey")).notnull() == (results["status"] > 0)).all()


def test_a_level_at_which_every_motion_collapses_is_said_to_be_one(results):
    lost = results.isel(record=results["status"].squeeze().values[:, 2] > 0)
    assert pr.assess(lost, pga="0.4 g").interfaces
    told = r"in every motion at PGA 0\.8 g a storey collapses.*at 0\.2 g, 0\.4 g motions can be .* --pga"
    with pytest.raises(pr.PoundingError, match=told):
        pr.assess(lost)


def test_a_run_that_collapses_does_not_say_that_nothing_touched(capsys):
    run = pr.simulate(pr.read_scene(scene({"pga": ["0.8 g"]})), record="RSN6-180")
    print_sheet(sheet(run))
    told = capsys.readouterr().out
    assert "status" in told and "collapsed" in told and "no contact" not in told
    assert "storey 2 of frame at 2.347 s" in told  # without contact, storey 1 would at 2.272 s
    drifts = run["drift"].sel(building="frame", storey=2).dropna("time")
    # The histories end at the node before; the storey collapses at 3 % of 3.2 m.
    assert 2.337 <= float(drifts["time"][-1]) <= 2.347
    assert 0.09 < abs(float(drifts[-1])) < 0.096


def test_a_fragility_counts_collapse_as_contact(results):
    """Maximum likelihood by another optimiser over all 18 runs, of which 1 and 5 are contacts."""
    one = pr.assess(results, pga="0.4 g").interfaces[0]
    curve = next(curve for curve in one.fragility if curve.what == "contact")
    im = np.repeat([0.2, 0.4, 0.8], 6)
    failed = np.r_[np.zeros(6), [1], np.zeros(5), np.ones(5), [0]].astype(bool)

    def loss(both):
        z = (np.log(im) - both[0]) / np.exp(both[1])
        return -np.where(failed, log_ndtr(z), log_ndtr(-z)).sum()

    found = minimize(loss, (np.log(0.5), np.log(0.3)), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
    # Flat to rounding of the likelihood within its square root.
    assert curve.median / G == pytest.approx(np.exp(found.x[0]), rel=1e-5)
    assert curve.dispersion == pytest.approx(np.exp(found.x[1]), rel=1e-5)
    assert sum(stripe.runs for stripe in curve.stripes) == 18
    assert any("5 of 18 motions" in sentence for sentence in one.verdict.evidence)


def test_along_an_axis_they_count_as_contact():
    key = "building.frame.hysteresis.collapse_drift"
    grid = {"pga": ["0.8 g"], key: [0.03, 0.2]}
    along = pr.assess_along(pr.scan(scene(grid)), target="20 %")
    first = along.isel({key: 0, "interface": 0})
    assert float(first["contact_probability"]) == 5 / 6
    assert float(first["required_gap"]) == inf
    assert int(first["motions_without_response"]) == 5
    # None of them touches, were they no contact: the lower bound is that of 0 of 6.
    assert float(first["contact_probability_low"]) == 0.0
    words = " ".join(findings(along))
    assert "∞ (no gap is wide enough)" in words
    assert "motions have no finite response, up to 5 of them" in words


def test_a_setback_and_separations_tell_them(results):
    frame, _ = pr.setbacks(results, pga="0.8 g")
    assert (frame.motions, frame.lost) == (6, 5)
    assert [one.gap for one in frame.required] == [inf, inf, inf]
    table = pr.code_table(results.sel(pga=0.8 * G, method="nearest").expand_dims("pga", 2))
    notes = [rule.row.note for rule in table.rules]
    assert all("without the 5 of 6 motions" in note for note in notes)
    assert any("may yield, not reduced" in note for note in notes) and not any("linear model" in note for note in notes)
    # 0.7 R ΔS of UBC 97 is of elastic analyses: the peak of a model that yields is its ΔM, without 0.7.
    told = {rule.row.rule for rule in table.rules if "the rule then requires 1 / 0.7 of this value" in rule.row.note}
    assert told == {"ubc97", "ubc97_boundary"}


def test_reports_and_pages_show_no_gap_for_them(results):
    """Not what the buildings close until one collapses, at 0.8 g in five of six motions."""
    fell = results["status"].squeeze().values[:, 2] > 0
    data = ReportData(results, assess(results, pga="0.8 g"), {})
    (table,) = [block for block in records.write(data) if block.get("caption", "").startswith("Records.")]
    assert table["caption"].endswith("; – without a finite response, for which no gap is wide enough.")
    assert [row[-1]["raw"] is None for row in table["rows"]] == fell.tolist()
    page = page_model(results)
    (needed,) = [one for one in page["outputs"] if one["name"] == "peak_closing_free"]
    assert np.isnan(unpacked(page, needed)).sum() == 5


def test_samples_count_them(results):
    drawn = "[uncertain]\nsamples = 4\nmotions = {motions!r}\n".format
    for motions in ("all", "drawn"):
        text = scene({"pga": ["0.8 g"]}) + drawn(motions=motions).replace("'", '"')
        text += '"building.frame.damping" = {distribution = "uniform", low = 0.04, high = 0.06}\n'
        samples = pr.scan(text)
        fell = (samples["status"].values > 0).ravel()
        closes = (samples["peak_closing_free"].values > 0.04).ravel() | fell
        answer = pr.uncertainty(samples)
        assert fell.any()
        assert float(answer["judged_probability"][0]) == pytest.approx(closes.mean(), rel=1e-12)
        assert (answer["gap"].values >= 0.0).all()


def test_exports_count_them(results, tmp_path):
    written = pr.export(results, "taxonomy", tmp_path / "t.csv", pga="0.8 g")
    rows = list(csv.DictReader((tmp_path / "t.csv").open(encoding="utf-8")))
    assert [row["P(contact)"] for row in rows] == ["0.833333", "0.833333"]
    assert any("5 motions of 6 without a finite response" in note for note in written.notes)
    written = pr.export(results, "geopackage", tmp_path / "g.gpkg", pga="0.8 g")
    with sqlite3.connect(tmp_path / "g.gpkg") as connection:
        found = connection.execute("select p_contact, p_contact_low, required_gap_p84_m, motions from interfaces")
        assert found.fetchone() == (pytest.approx(5 / 6), 0.0, None, 6)
    assert any("5 motions of 6 without a finite response" in note for note in written.notes)
    pr.export(results, "csv", tmp_path / "tables")
    cases = list(csv.DictReader((tmp_path / "tables" / "interfaces.csv").open(encoding="utf-8")))
    assert [row["impact_count"] for row in cases].count("") == 5
    assert not any(value == "-1" for row in cases for value in row.values())
    floors = list(csv.DictReader((tmp_path / "tables" / "buildings.csv").open(encoding="utf-8")))
    assert len(floors) == 2 * results["status"].size  # none of a failed run is left out
    storeys = list(csv.DictReader((tmp_path / "tables" / "storeys.csv").open(encoding="utf-8")))
    assert len(storeys) == 3 * results["status"].size  # two of the frame, one of the wall


def test_a_building_that_stands_is_not_damaged_by_the_collapse_of_another():
    """The frame collapses in five of six motions, 50 m away from a wall whose own drift is then not known."""
    far = scene_text(
        FRAME, WALL, effects=INELASTIC, gap="50 m", records=RECORDS, grid={"pga": ["0.2 g", "0.4 g", "0.8 g"]}
    )
    tables = "".join(
        f'[[damage]]\nname = "of {name}"\nbuilding = "{name}"\ndrift = "{drift} %"\n'
        for name, drift in (("wall", 9), ("frame", 2))
    )
    found = pr.damage(pr.scan(far + tables))
    wall, frame = (found.sel(state=f"of {name}", pounding="without") for name in ("wall", "frame"))
    assert int(wall["reached"].sum()) == 0 and int(wall["runs"].sum()) == 13
    assert int(frame["reached"].sum()) >= 5 and int(frame["runs"].sum()) == 18
    assert "runs in which frame collapses are left out" in found.attrs["assumptions"]


def struck_row(**more) -> pr.Scene:
    """A weak building that only a blow of its neighbour makes collapse, and a third one 160 mm beside it."""
    floors = {"storey_heights": "3.2 m", "damping": 0.05}
    yielding = {"rule": "peak_oriented", "backbone": [[3.0, 1.05], [7.0, 0.1]], "collapse_drift": 0.03}
    storeys = {"storey_strengths": ["700 kN", "600 kN"], "hysteresis": yielding}
    chains = [
        ("hammer", ["900 t", "900 t"], ["140 MN/m", "120 MN/m"], {}),
        ("weak", ["100 t", "80 t"], ["160 MN/m", "130 MN/m"], storeys),
        ("far", ["150 t", "150 t"], ["300 MN/m", "250 MN/m"], {}),
    ]
    buildings = [
        pr.ShearBuilding(name, floor_masses=masses, storey_stiffnesses=springs, **floors, **laws)
        for name, masses, springs, laws in chains
    ]
    law = pr.laws.Jankowski(stiffness="2e10 N/m^1.5")
    interfaces = [pr.Interface(gap=gap, law=law, restitution=0.6) for gap in ("5 mm", "160 mm")]
    names = ["RSN6-180", "RSN77-164", "RSN753-090", "NAPA-HNN"]
    polarity = ["as recorded", "reversed"]
    ground = pr.Records(names, pga="0.22 g", polarity=polarity, window=["0 s", "10 s"])
    effects = {"inelastic_storeys": {"hardening": 0.05}, "p_delta": {}}
    return pr.Scene(buildings, interfaces, ground, effects=effects, **more)


def test_a_storey_that_pounding_makes_collapse_counts_against_the_verdict_on_the_next_gap(tmp_path):
    """The run ends there: whether the weak building would have met the far one later is not known."""
    struck = pr.scan(struck_row())
    fell = struck["status"].values.ravel() > 0
    assert fell.sum() == 4 and struck["storey_collapse_time_free"].isnull().all()
    assert (struck["peak_closing_free"].isel(interface=1) < 0.16).all()  # alone they leave the gap open
    beside, beyond = pr.assess(struck, target=0.3).interfaces
    assert (beside.contact_at_gap().count, beside.contact_at_gap().runs) == (8, 8)  # they touch before it
    here = beyond.contact_at_gap()
    assert (here.count, here.runs) == (0, 4) and beyond.verdict.word == "depends"
    lost = "counted against the verdict: 4 motions; in 4 of them pounding in the row makes a storey collapse"
    assert lost in " ".join(beyond.verdict.evidence)
    assert any("No gap can be shown to keep 30 %: 4 of 8 motions" in sentence for sentence in beyond.verdict.conclusion)
    pr.export(struck, "taxonomy", tmp_path / "row.csv")
    rows = {row["building"]: row for row in csv.DictReader((tmp_path / "row.csv").read_text().splitlines())}
    assert float(rows["far"]["P(contact)"]) == pytest.approx(4 / 8) and float(rows["far"]["P(contact) low"]) == 0.0


def test_a_gap_at_which_pounding_makes_a_storey_collapse_in_every_motion_is_not_known():
    struck = pr.scan(struck_row()).isel(record=[0, 2])
    assert (struck["status"] > 0).all()
    one = pr.assess(struck).interfaces[1]
    share = one.contact_at_gap()
    assert (share.count, share.runs, share.high_recordings, one.verdict.word) == (0, 4, 1.0, "depends")
    assert one.verdict.sentence.endswith("in the runs at this gap pounding makes a storey collapse, or they fail.")
    assert all(need.at_least for need in one.required)


def test_samples_in_which_pounding_makes_a_storey_collapse_are_on_neither_side():
    drift = {"distribution": "uniform", "low": 0.02, "high": 0.05}
    samples = {"samples": 4, "building.weak.hysteresis.collapse_drift": drift}
    struck = pr.scan(struck_row(uncertain=samples))
    fell = struck["status"].values > 0
    answer = pr.uncertainty(struck, target=0.3).sel(interface="weak | far")
    assert float(answer["judged_probability"]) == pytest.approx(fell.mean())
    assert float(answer["judged_probability_low"]) < 0.01 and str(answer["sentence"].item()).startswith("Depends")
    assert f"weak | far: {fell.sum()} of {fell.size} outcomes without a finite response" in answer.attrs["assumptions"]


def test_a_gap_at_which_pounding_makes_a_storey_collapse_is_not_shown_to_be_enough():
    """Two motions leave 20 mm open alone, and make the weak building fall where it is 20 mm from either neighbour."""
    struck = pr.scan(struck_row(grid={"gap": ["10 mm", "20 mm", "300 mm"], "pga": ["0.35 g"]}))
    fell = struck["status"].transpose(..., "gap").values.reshape(8, 3) > 0
    alone = struck["peak_closing_free"].isel(interface=1).values.ravel()
    assert fell.sum(axis=0).tolist() == [2, 2, 0] and 0.01 < alone[fell[:, 0]].max() < 0.02
    runs = [pr.assess(struck, gap=gap).interfaces[1].contact_at_gap().runs for gap in ("10 mm", "20 mm", "300 mm")]
    assert runs == [7, 6, 8]  # one of the two closes 10 mm alone
    motions = motions_of(Results(struck).interfaces[1][1])
    needs = [motions.run.above(closing) for closing in motions.closing[fell[:, 1], 0].tolist()]
    assert needs == pytest.approx([0.3, 0.3]) and motions.finite.all()


def test_a_collapse_is_an_infinite_demand(tmp_path):
    """It was 10 times the threshold: of a threshold of 0.01 % less than the drift of frames that stand."""
    grid = {"pga": ["0.2 g", "0.6 g", "0.8 g"]}
    table = '[[damage]]\nname = "frame"\nbuilding = "frame"\ndrift = "0.01 %"\n'
    results = pr.scan(scene_text(FRAME, WALL, effects=INELASTIC, gap="40 mm", records=RECORDS, grid=grid) + table)
    fell = (results["status"].squeeze(drop=True) > 0).transpose("record", "pga").values
    heights = np.array([3.2, 3.2])[:, None, None]
    drifts = results["storey_drift"].squeeze(drop=True).sel(building="frame").isel(storey=slice(2))
    own = np.where(fell, inf, (drifts.transpose("storey", "record", "pga").values / heights).max(axis=0) / 1e-4)
    pr.damage(results).pounding.save(tmp_path / "d.nc")
    found = pr.open_results(tmp_path / "d.nc").sel(state="frame", pounding="with")
    ratios = found["demand_ratio"].squeeze(drop=True).transpose("record", "level").values
    np.testing.assert_allclose(ratios, own, rtol=1e-12)
    assert ratios[~fell].max() > 10.0
    # Of six motions 16, 50 and 84 % lie at places 0.8, 2.5 and 4.2 of those in rising order, from 0.
    ranked, shares = np.sort(own, axis=0), found["demand_percentile"].values
    assert fell.sum(axis=0).tolist() == [0, 3, 5]
    np.testing.assert_allclose(shares[0, :2], ranked[0, :2] + 0.8 * (ranked[1, :2] - ranked[0, :2]), rtol=1e-12)
    np.testing.assert_allclose(shares[1, 0], 0.5 * (ranked[2, 0] + ranked[3, 0]), rtol=1e-12)
    assert np.isinf(shares).tolist() == [[False, False, True], [False, True, True], [False, True, True]]
    told = pr.damage(results, method="cloud")["fault"].sel(state="frame", pounding="with").item()
    assert "collapses in 8 of 18 runs" in told and "take stripes" in told
    one_level = results.sel(pga=[0.8 * G], method="nearest")
    for data, method in ((one_level, "stripes"), (one_level.isel(record=[int(np.argmin(fell[:, 2]))]), "cloud")):
        assert pr.damage(data).attrs["method"] == method
    figure = pr.figures.ida_figure(pr.open_results(tmp_path / "d.nc"))
    assert "8 of 18 runs collapse" in figure.axes[0].get_title()
    assert "lines end before a collapse" in words_of(figure)
