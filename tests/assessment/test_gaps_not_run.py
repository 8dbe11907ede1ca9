"""Gaps at which nothing was run: those of a row across which neighbours push, and those that a grid passes over."""

import csv
import re
from math import ceil

import numpy as np
import pytest
import xarray as xr

import pounding_risk as pr
from pounding_risk.assessment.demands import motions_of
from pounding_risk.questions import adequacy
from pounding_risk.render.csv_text import csv_text
from pounding_risk.reports.exports import Options
from pounding_risk.reports.exports._layers import layers_of
from pounding_risk.results.opened import Results

BESIDE, WIDE, NARROW = "20 mm", "500 mm", "10 mm"  # a gap that a tall building closes, and two of the one beside it
RECORDS = ["RSN6-180", "RSN6-270", "RSN77-164", "RSN77-254", "RSN753-000", "RSN753-090"]
RECORDS += ["RSN1690-090", "RSN1690-360", "CCC-HN1", "CCC-HN2", "NAPA-HNE", "NAPA-HNN"]
HAZARD = "pga [g],annual rate [1/year]\n0.05,0.04\n0.1,0.015\n0.2,0.0042\n0.4,0.00085\n0.8,0.00012\n1.6,0.00001\n"


def row(gap: str, **tables) -> pr.Scene:
    """A tall building that pushes a light one against its neighbour, 24 motions."""
    masses = [("tall", "2000 t", "1.6 s"), ("mid", "100 t", "0.5 s"), ("right", "300 t", "0.25 s")]
    buildings = [pr.SingleMass(name, mass=mass, period=period) for name, mass, period in masses]
    law = pr.laws.Jankowski(stiffness="3e10 N/m^1.5")
    interfaces = [pr.Interface(gap=width, law=law, restitution=0.65) for width in (BESIDE, gap)]
    records = pr.Records(RECORDS, pga="0.4 g", polarity=["as recorded", "reversed"])
    return pr.Scene(buildings, interfaces, records, **tables)


def run(gap: str) -> xr.Dataset:
    return pr.scan(row(gap))


@pytest.fixture(scope="module")
def wide() -> xr.Dataset:
    return run(WIDE)


@pytest.fixture(scope="module")
def narrow() -> xr.Dataset:
    return run(NARROW)


def test_a_run_at_a_wide_gap_says_who_touches_at_narrower_ones(wide):
    """Until the two touch their gap plays no part: a motion that leaves it open needs the closing of that run.

    A motion that closes the gap alone and is held back in the row counts as contact, by the rule of `touching`.
    """
    (_, _), (_, there) = Results(wide).interfaces
    motions = motions_of(there)
    assert motions.run.widest == pytest.approx(0.5) and (motions.closing > 1.5 * motions.alone).any()
    for gap in ("60 mm", "100 mm"):
        touched = run(gap)["impact_count"].isel(interface=1).values.ravel() > 0
        width = float(gap[:-3]) / 1e3
        expected = motions.closing[:, 0] > width
        held = (motions.alone[:, 0] > width) & ~touched
        np.testing.assert_array_equal(touched, expected & ~held)
        assert (touched & (motions.alone[:, 0] <= width)).any()  # some are pushed


def test_a_gap_wider_than_those_run_is_not_shown_to_be_enough(narrow, tmp_path):
    """Without the row's runs none of the motions closes it; a run there has contact in several."""
    hazard = tmp_path / "hazard.csv"
    hazard.write_text(HAZARD)
    pushed = run("100 mm")["impact_count"].isel(interface=1).values
    one = pr.assess(narrow, gap="100 mm", hazard=hazard, target_rate="475 years").interfaces[1]
    share = one.contact_at_gap()
    assert (share.count, share.high, share.high_recordings) == (0, 1.0, 1.0) and (pushed > 0).sum() > 2
    assert one.verdict.word == one.rate_verdict.word == "depends"
    assert "the row was run at gaps of up to 10 mm here" in one.verdict.sentence
    # The row of the hazard curve for 0.4 g: 8.5e-4 a year.
    assert "PGA 0.4 g is exceeded once in 1176 years" in " ".join(one.verdict.evidence)
    assert "a scan with the gap of 100 mm does" in " ".join(one.verdict.conclusion)
    assert all(need.at_least and not need.bounded for need in one.required)
    assert any("Provide at least" in sentence and "scan such gaps" in sentence for sentence in one.verdict.conclusion)
    assert all("the row was run at gaps of up to 10 mm" in gap.fault for gap in one.gaps_for_rates)
    assert [curve.fault == "" for curve in one.fragility if curve.gap == 0.1] == [False]
    single = pr.assess(narrow.isel(polarity=[0])).interfaces[1].what_matters
    assert single == "the polarity, the contact model and F_E had one value each, so that their influence is not shown"


@pytest.fixture(scope="module")
def together() -> xr.Dataset:
    return pr.scan(row(NARROW, grid={"gap": ["0 mm", "50 mm", "300 mm"]}))


def test_gaps_that_vary_together_are_known_at_the_steps_of_the_grid_alone(together):
    """At 300 mm everywhere nobody pushes, which says nothing of 100 mm everywhere, where the tall building does."""
    one = pr.assess(together, gap="100 mm").interfaces[1]
    share, finer = one.contact_at_gap(), pr.scan(row(NARROW, grid={"gap": [f"{gap} mm" for gap in range(0, 301, 10)]}))
    really = float((finer["impact_count"].isel(interface=1).sel(gap=0.1) > 0).mean())
    assert share.probability < really < share.high_recordings and one.verdict.word == "depends"
    assert "the row was run at gaps of 50 mm and 300 mm here" in one.verdict.sentence
    assert "a scan with the gap of 100 mm does" in " ".join(one.verdict.conclusion)
    assert {curve.gap: "50 mm and 300 mm" in curve.fault for curve in one.fragility}[0.1]
    for need, true in zip(one.required, pr.assess(finer).interfaces[1].required, strict=True):
        assert need.is_between and need.enough == pytest.approx(0.3) and need.gap <= true.enough <= need.enough
        assert need.high <= need.enough
    median, *_ = one.required
    assert median.bounded and median.high == median.enough  # the order statistics of the motions' own are 38 to 69 mm


def test_what_to_provide_is_a_gap_that_was_run_and_no_push_counts_as_free(together):
    """Of the free motion alone: the closing of rank 84 %, and those above a gap wider than any that was run."""
    closing = np.sort(together["peak_closing_free"].isel(interface=1).values.ravel())
    one, free = pr.assess(together).interfaces[1].verdict, 1e3 * closing[ceil(0.84 * closing.size) - 1]
    assert (
        one.conclusion[1].startswith("Provide at least 300 mm for") and "need no more than 300 mm (" in one.evidence[0]
    )
    (told,) = re.findall(r"without a push by neighbours ([\d.]+) mm would do", one.conclusion[1])
    assert 0.0 <= float(told) - free < 0.1  # rounded up to three digits
    wider = pr.assess(pr.scan(row(NARROW, grid={"gap": ["20 mm", "60 mm"]}))).interfaces[1].verdict.conclusion[1]
    ((provided, count),) = re.findall(r"at least ([\d.]+) mm .*; (\d+) of .* without a push", wider)
    assert int(count) == (1e3 * closing > float(provided)).sum()


def test_a_required_gap_between_two_that_were_run_is_a_range_in_every_view(together):
    sheet = adequacy.required_gaps(pr.assess(together).interfaces[1])
    (row, *_), heads = [cells for cells in sheet[0]["rows"] if cells[0]["text"] == "84"], sheet[0]["heads"]
    assert row[heads.index("required gap [mm]")]["text"] == "68.4 to 300"
    written = csv_text(sheet).splitlines()
    assert written[1].split(",")[1:3] == ["required gap [mm]", "required gap up to [mm]"]
    assert [float(cell) for cell in written[3].split(",")[1:3]] == pytest.approx([68.34, 300.0], abs=0.01)


def test_gaps_that_vary_together_say_nothing_beyond_the_widest(together):
    beyond = pr.assess(together, gap="400 mm").interfaces[1]
    assert beyond.verdict.word == "depends" and beyond.contact_at_gap().high == 1.0
    assert "the row was run at gaps of up to 300 mm here" in beyond.verdict.sentence


def test_the_layers_of_a_row_have_the_bounds_of_its_assessment(together):
    layers = layers_of([together], Options(gap="100 mm"))
    for one, row_of_layer in zip(pr.assess(together, gap="100 mm").interfaces, layers.interfaces.rows, strict=True):
        share = one.contact_at_gap()
        bounds = share.probability, share.low_recordings, share.high_recordings
        assert tuple(row_of_layer[f"p_contact{end}"] for end in ("", "_low", "_high")) == bounds
        assert row_of_layer["required_gap_p84_m"] == max(one.required_at(84.0).gap, 0.3)  # the widest that was run
    assert any(note.startswith("mid | right: contact at a gap of 100 mm is not known") for note in layers.notes)
    widest = max(each["p_contact_high"] for each in layers.interfaces.rows)
    assert layers.buildings.rows[1]["p_contact_high"] >= widest  # at either side of the building


def test_the_taxonomy_of_a_building_that_neighbours_may_push_says_so(together, tmp_path):
    pr.export(together, "taxonomy", tmp_path / "row.csv", gap="100 mm")
    rows = {row["building"]: row for row in csv.DictReader((tmp_path / "row.csv").read_text().splitlines())}
    assert rows["right"]["POP"] == "not known" and float(rows["right"]["P(contact) high"]) > 0.9


def test_a_gap_narrower_than_those_run_together_is_not_known():
    """Alone none of the motions closes 272 mm; a grid from 300 mm on says nothing of pushes there."""
    wide_grid = pr.scan(row(NARROW, grid={"gap": ["300 mm", "400 mm"]}))
    one = pr.assess(wide_grid, gap="272 mm").interfaces[1]
    assert one.verdict.word == "depends" and one.contact_at_gap().high_recordings == 1.0
    words = "at gaps of 300 mm and more here, and neighbours may push the two together across narrower ones"
    assert words in one.verdict.sentence


def test_one_gap_that_varies_beside_others_that_do_not_is_known_between_its_steps():
    alone = pr.scan(row(NARROW, grid={"gap": ["0 mm", "50 mm", "300 mm"], "interface": "mid | right"}))
    one, wider = (pr.assess(alone, gap=gap).interfaces[1] for gap in ("100 mm", "400 mm"))
    touched = run("100 mm")["impact_count"].isel(interface=1).values > 0
    assert one.contact_at_gap().count == touched.sum()  # no motion is held back here
    assert not any(need.is_between for need in one.required)
    # Whoever does not touch at 300 mm does not at 400 mm; the others may.
    widest = pr.assess(alone, gap="300 mm").interfaces[1].contact_at_gap()
    beyond = wider.contact_at_gap()
    assert widest.count > 0 and beyond.high == widest.high < 1.0 and beyond.high_recordings == widest.high_recordings


def test_samples_that_were_not_run_show_no_gap_of_a_row_to_be_adequate():
    """No sample closes 250 mm without contact; of a pair, on which nobody pushes, that would be adequate."""
    uncertain = {"samples": 8, "building.right.period": {"distribution": "uniform", "low": "0.2 s", "high": "0.3 s"}}
    answer = pr.uncertainty(row("250 mm", uncertain=uncertain), target=0.45)
    sentences = dict(zip(answer["interface"].values.tolist(), answer["sentence"].values.tolist(), strict=True))
    shares = answer["contact_probability"].sel(interface="mid | right")
    assert float(shares.sel(gap=0.25, method="nearest")) == 0.0
    assert sentences["mid | right"].startswith("Depends: over 8 samples")
    assert "but for what neighbours may push across it, which was not run" in sentences["mid | right"]


def test_what_the_row_was_run_at_is_bounded_as_before(wide):
    """A required gap below the widest run, with its bounds, carries no mark; P(contact) there is counted."""
    one = pr.assess(wide).interfaces[1]
    median = one.required_at(50.0)
    assert median.high <= 0.5 and not median.is_pushed and not median.at_least
    assert one.contact_at_gap().high_recordings < 1.0 and "the row was run" not in one.verdict.sentence
    assert one.run.widest == pytest.approx(0.5) and not one.run.steps


def test_fragilities_by_scaling_say_that_they_take_nobody_to_push(together):
    """Nobody pushes the tall building at the end of the row; the light one beside it is pushed, and not scaled."""
    said = [" ".join(one.verdict.evidence) for one in pr.assess(together).interfaces]
    assert ["fragilities by scaling take it that they do not at others" in evidence for evidence in said] == [
        True,
        False,
    ]


def test_a_gap_and_a_force_that_the_grid_passes_over_are_named():
    """Of the two nearest the answers are; P(contact) and required gaps are those of the gap itself."""
    masses = [pr.SingleMass("left", mass="500 t", period="1 s"), pr.SingleMass("right", mass="800 t", period="0.5 s")]
    law = pr.laws.ViscousElastoplastic(stiffness="2e11 N/m^1.5")
    between = pr.Interface(gap="30 mm", law=law, restitution=0.65, yield_force="4 MN")
    records = pr.Records(RECORDS[:4], pga="0.4 g")
    grid = {"gap": ["0 mm", "40 mm"], "yield_force": ["3 MN", "inf"]}
    state = {"name": "moved", "building": "left", "displacement": "60 mm"}
    scanned = pr.scan(pr.Scene(masses, [between], records, grid=grid, damage=[state]))
    named = [
        "gap: the scene's own, 30 mm, is not in the grid; forces, yielding and damage are those at 40 mm, the nearest "
        "there: add it to gap in [grid]",
        "yield_force: the scene's own, 4000 kN, is not in the grid; forces, yielding and damage are those at 3000 kN, "
        "the nearest there: add it to yield_force in [grid]",
    ]
    assert [note for note in pr.assess(scanned).notes if "not in the grid" in note] == named
    assert all(note in pr.damage(scanned).attrs["assumptions"] for note in named)
    asked = pr.assess(scanned, gap="10 mm")
    assert not any("not in the grid" in note for note in asked.notes)
    evidence = {gap: " ".join(pr.assess(scanned, gap=gap).interfaces[0].verdict.evidence) for gap in ("10 mm", "40 mm")}
    assert "struck columns are those at 0 mm, the nearest gap of the grid" in evidence["10 mm"]
    assert "nearest gap" not in evidence["40 mm"]


def test_a_row_whose_own_gaps_were_not_run_together_is_told():
    """The gaps of [grid] are those of every interface: 20 mm and 10 mm are run where nothing else is asked for."""
    told = {}
    for gap, grid in ((NARROW, {"gap": ["10 mm", "20 mm"]}), (NARROW, {}), (BESIDE, {"gap": ["10 mm", "20 mm"]})):
        dataset = pr.scan(row(gap, grid=grid), check_fraction=0.0)
        was_run = (np.abs(Results(dataset).gaps.values - [0.02, float(gap[:-3]) / 1e3]) < 1e-9).all(axis=1).any()
        told[gap, len(grid)] = [note for note in pr.assess(dataset).notes if "scene's own gaps" in note]
        assert len(told[gap, len(grid)]) == int(not was_run)
    (note,) = told[NARROW, 1]
    assert note.startswith("gap: the row with the scene's own gaps, 20 mm, 10 mm, was not run: [grid] gap sets every")
