"""The report of a row: a section on the row whose numbers are the dataset's, and nothing that assumes a pair."""

import numpy as np
import pytest
import xarray as xr
from made_row import STREET, made_row
from scenes import rigid, scene_text, storeyed

import pounding_risk as pr
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.row import row_case
from pounding_risk.figures.row import amplification, profiles_figure
from pounding_risk.questions import simulate
from pounding_risk.reports import document as model
from pounding_risk.reports import explorer
from pounding_risk.reports import html as page
from pounding_risk.reports.data import ReportData
from pounding_risk.reports.sections import adequacy, response, row, scene
from pounding_risk.results.scene_axes import with_axes
from pounding_risk.results.summary import summary
from pounding_risk.scene.reader import parse_scene

HERE = {"gap": 0.02, "yield_force": 4e5, "contact_model": "viscous_elastoplastic"}


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Three buildings, two interfaces, one failed run."""
    whole = made_row(records=4, failed=True)
    points = np.flatnonzero(whole["contact_point_interface"].values < 2)
    return whole.isel(building=slice(0, 3), interface=slice(0, 2), contact_point=points)


@pytest.fixture(scope="module")
def data(results) -> ReportData:
    return ReportData(results, assess(results), {})


@pytest.fixture(scope="module")
def blocks(data) -> list:
    return row.write(data)


def rows_of(blocks: list, start: str) -> list:
    (one,) = [each for each in blocks if each["kind"] == "table" and each["caption"].startswith(start)]
    return one["rows"]


def test_links_have_their_forces_and_are_among_what_is_assumed():
    """A hook between two frames, one of which degrades: it breaks under one record."""
    frames = [
        storeyed("A", ["200 t"] * 2, "150 MN/m", ["3 m"] * 2, storey_strengths="1 MN",
                 hysteresis={"rule": "peak_oriented"}),
        storeyed("B", ["300 t"] * 2, "500 MN/m", ["3 m"] * 2),
    ]  # fmt: skip
    hook = {"link_stiffness": "50 MN/m", "link_slack": "5 mm", "link_breaking_force": "700 kN"}
    records = {"names": ["RSN6-180", "NAPA-HNE"], "window": ["1 s", "5 s"], "pga": "0.4 g"}
    dataset = pr.scan(
        parse_scene(scene_text(*frames, gap="1 m", records=records, effects={"inelastic_storeys": {}}, **hook))
    )
    data = ReportData(dataset, assess(dataset), {})
    rows = {cells[1]["text"].partition(" [")[0]: cells for cells in rows_of(row.write(data), "Springs and dampers")}
    broken = dataset["broken_links"].squeeze().values
    assert sorted(broken) == [0.0, 1.0]
    assert rows["number of links that break"][3]["raw"] == 1.0
    assert rows["force of the spring"][3]["raw"] == pytest.approx(7e5)
    assert rows["stretch"][3]["raw"] == dataset["peak_link_stretch"].max()
    assert "force of the damper with link_exponent or on a brace" not in rows
    told = str(scene.write(data))
    assert "Springs or dampers without mass join A and B; what is called without contact has them too." in told
    assert "yield, those of A by the rule peak_oriented, and others" in told
    assert "as if alone" not in str(response.write(data))


def test_drifts_of_isolated_buildings_are_those_above_the_isolators(tmp_path):
    """What a moat wall does to the storeys is not hidden by the isolators, which it holds back."""
    isolation = {"slab_mass": "600 t", "height": "1.5 m", "friction": 0.05, "radius": "2 m"}
    hospital = storeyed("hospital", ["500 t", "400 t"], "800 MN/m", "4 m", isolation=isolation)
    strong = {"window": ["0 s", "6 s"], "pga": "0.6 g", "polarity": ["as recorded", "reversed"]}
    study = parse_scene(scene_text(rigid(height="1.5 m"), hospital, gap="20 mm", records=strong))
    results = pr.scan(study)
    one = results.isel(building=1, gap=0, yield_force=0, contact_model=0)
    struck, free = (one[name].values[..., 1:].max(axis=-1) for name in ("storey_drift", "storey_drift_free"))
    assert (one["impact_count"] > 0).all() and (struck > 1.5 * free).all()
    raised = np.median(struck / free)
    case = row_case(results)
    assert amplification(case, 1) == pytest.approx(raised, rel=1e-12)
    assert row.drift_finding(case).startswith(f"With contact the largest storey drift above isolators is {raised:.2f} ")
    data = ReportData(results, assess(results), {})
    # Sliders of R = 2 m: the pendulum's 2 pi sqrt(R / g), made longer by the storeys.
    stated = next(text for text in map(str, scene.write(data)) if "isolators yield" in text)
    period = float(stated.partition("while they yield it is ")[2].partition(" s.")[0])
    assert 0.0 <= period / (2.0 * np.pi * np.sqrt(2.0 / 9.80665)) - 1.0 < 0.01
    assert "Storeys above them stay elastic." in stated
    (rows,) = [each["rows"] for each in response.write(data)[:1]]
    (cells,) = [cells for cells in map(str, rows) if "peak storey drift above the isolators [mm]" in cells]
    assert "hospital" in cells
    title = profiles_figure(case).axes[0].get_title()
    assert title == "hospital (end)\n2 of 2 motions; storey 1: its isolators"
    # Columns are explained where some are struck; what displacements are is written once, not in each rule's row.
    assert "up the columns" not in str(row.write(data))
    blocks = adequacy.write(data)
    assert str(blocks).count("Displacements are the peaks of models whose storeys or isolators may yield") == 1
    assert str(blocks).count("those for the moat of an isolated one are in ASCE/SEI 7, chapter 17") == 1
    (rules,) = (block for block in blocks if "separations that rules require" in block.get("caption", ""))
    assert "may yield" not in str([cells[-1] for cells in rules["rows"] if not cells[0]["text"].startswith("UBC")])
    told = explorer.page_model(results)["facts"]
    words = "Storey 1 of hospital is its isolators, which peak drift counts."
    assert words in told and words in summary(results).notes
    notes = pr.export(results, "pelicun", tmp_path / "demands").notes
    assert "hospital: 1-PFA-1-1 is of the slab on isolators, and 1-PID-1-1 of the isolators over its height" in notes
    run = pr.simulate(study)
    told = str(simulate.sheet(run))
    assert "hospital: peak drift is that above the isolators, which are storey 1" in told
    assert str(float(run["storey_drift"][1, 1:].max())) in told
    # The isolators have a displacement, with the wall and without, and no row of storeys that yield.
    (moved,) = [cells for cells in rows if cells[1]["text"] == "largest displacement of the isolators [mm]"]
    by_wall = 1e3 * one["storey_drift"].values[..., 0]
    assert moved[3]["text"].startswith(f"{np.median(by_wall):.3g} (")
    assert not any("ductility" in cells[1]["text"] for cells in rows)
    assert not any("ductility" in each.words for each in assess(results).interfaces[0].response)
    assert "displacement of isolators [mm]" in told and "storey ductility" not in told
    assert pr.figures.hysteresis_figure(run).axes[0].get_title().startswith("hospital, isolators: ductility")


def test_two_buildings_have_no_plan_and_no_summary_of_none():
    """A row of two: its elevation says what a plan would, and there is no interior."""
    two = with_axes(made_row(records=3, street=STREET[:2], own_gaps=(0.02,), forces=(4e5,)))
    blocks = row.write(ReportData(two, assess(two, pga=two["pga"].values[0]), {}))
    text = str(blocks)
    assert "row-elevation" in text and "row-plan" not in text and "interior" not in text
    assert "the row's ends" not in text and "largest storey drift is" in text
    parts = adequacy.write(ReportData(two, assess(two, pga=two["pga"].values[0]), {}))
    assert "scan several to see." not in str(parts)
    (said,) = {part["text"] for part in parts if "scan several" in str(part.get("text"))}
    assert said.startswith("The grid has one ") and said.endswith(": scan several to see what they change.")


def test_the_tables_of_a_row_are_the_datasets(results, blocks):
    here = results.sel(HERE).isel(pga=1)
    for at, cells in enumerate(rows_of(blocks, "Neighbours")):
        count = here["impact_count"].isel(interface=at).values
        assert cells[0]["text"] == str(results["interface"].values[at])
        assert cells[2]["raw"] == (count >= 0).sum() == 8  # the failed run is at another gap
        assert cells[3]["raw"] == (count > 0).mean()
        force = here["peak_contact_force"].isel(interface=at).values[count > 0]
        assert cells[6]["raw"] == np.median(force)
    for at, cells in enumerate(rows_of(blocks, "Contact points")):
        assert cells[4]["raw"] == float(results["contact_point_level"].values[at])
        yields = here["contact_point_yield_exceedance"].isel(contact_point=at).values
        assert cells[7]["raw"] == yields.mean()


def test_ends_and_interiors_stand_apart(results, blocks):
    rows = rows_of(blocks, "With contact over without")
    assert [cells[1]["text"] for cells in rows[:3]] == ["end", "interior", "interior"]
    here = results.sel(HERE).isel(pga=1)
    touched = (here["impact_count"].isel(interface=0) > 0).values.ravel()
    drift = [here[name].isel(building=0).values.ravel()[touched] for name in ("peak_drift", "peak_drift_free")]
    assert rows[0][2]["raw"] == np.median(drift[0] / drift[1])
    assert rows[-2][0]["text"].startswith("1 end:")
    assert rows[-1][0]["text"].startswith("2 interiors:")


def test_every_interface_has_its_verdict_figures_and_tables(data, no_pictures):
    """And nothing says that it is a pair's report."""
    built = model.build(data)
    told = {section["name"]: section["blocks"] for section in built["sections"]}
    verdicts = [block["name"] for block in told["summary"] if block["kind"] == "verdict"]
    assert verdicts == ["Corner | Arcade", "Arcade | Theatre"]
    (summed,) = [block for block in told["summary"] if block["kind"] == "table"]
    assert [cells[0]["text"] for cells in summed["rows"]] == verdicts
    assert [cells[3]["raw"] for cells in summed["rows"]] == [
        pair.assessed.contact_at_gap().count for pair in data.pairs
    ]
    assert page.page(built).count("Arcade | Theatre") > 8
    assert "row" in [section["name"] for section in built["sections"]]
    said = str(built["sections"])
    assert "moves as one mass" not in said
    assert "follows from the motion without contact alone" not in said
    assert "Both buildings" not in said
    (buildings,) = [
        block
        for section in built["sections"]
        for block in section["blocks"]
        if block["kind"] == "table" and block["caption"] == "Buildings, left to right."
    ]
    assert [cells[4]["text"] for cells in buildings["rows"]] == ["5", "3", "2"]
    names = [block["name"] for section in built["sections"] for block in section["blocks"] if block["kind"] == "figure"]
    assert len(names) == len(set(names))
    assert {"row-elevation", "row-plan", "row-profiles", "interface-2-contact"} <= set(names)
