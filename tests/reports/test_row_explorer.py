"""The page of `view` on a row: an interface to choose, its two buildings and their storeys, as the dataset has them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from explorer_page import Reader, embedded, needs_browser, number, unpacked
from made_row import made_row
from sentences import refusal

from pounding_risk.reports import explorer
from pounding_risk.results.opened import Results

pytest.importorskip("plotly")


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Six records in two polarities, one run failed."""
    return made_row(failed=True)


@pytest.fixture(scope="module")
def written(results, tmp_path_factory):
    return explorer.view(results, tmp_path_factory.mktemp("page") / "row.html")


@pytest.mark.complete
def test_the_page_of_a_row_holds_its_interfaces_and_storeys(results, written):
    model = embedded(written)
    assert model["pickers"][-1] == "interface"
    assert {axis["name"]: axis["labels"] for axis in model["axes"]}["interface"] == list(results["interface"].values)
    held = {variable["name"]: variable for variable in model["outputs"]}
    for name in ("impact_count", "peak_contact_force", "peak_closing_free", "peak_drift", "peak_drift_free"):
        found = results[name].transpose(*held[name]["dims"]).values
        np.testing.assert_array_equal(unpacked(model, held[name]), found.astype(held[name]["kind"]))
    model["axes"].append({"name": "storey", "labels": list(range(model["profiles"]["storeys"]))})
    names = []
    for each in model["profiles"]["quantities"]:
        for variable in (each["struck"], each["free"]):
            found = results[variable["name"]].transpose(*variable["dims"]).values
            np.testing.assert_array_equal(unpacked(model, variable), found.astype("f4"))
            names.append(variable["name"])
    assert names[:2] == ["storey_drift", "storey_drift_free"]
    assert [len(levels) for levels in model["profiles"]["levels"]] == [5, 3, 2, 7, 1, 0]


def test_the_row_stands_below_in_elevation_and_plan(results, written):
    page = written.read_text("utf-8")
    pictures = page[page.index('<section id="row"') : page.index("</section>", page.index('<section id="row"'))]
    assert pictures.count("<svg") == 2 and "http" not in pictures.replace("http://www.w3.org/", "")
    assert explorer.row_pictures(results.drop_vars("contact_point_impact_count")) == ""


def test_profiles_that_are_too_many_are_left_out_and_told(results, monkeypatch):
    monkeypatch.setattr(explorer, "MOST_OF_STOREYS", 100)
    model = explorer.page_model(results)
    assert model["profiles"] is None
    assert any("Storey profiles are left out" in each for each in model["facts"])


def test_whose_gap_the_axis_has_is_told():
    model = explorer.page_model(made_row(records=2, named=1))
    assert "The gap is that of Arcade | Theatre; the others keep their own." in model["facts"]
    columns = "The yield force is that of contacts between floors; those with a column have the column's."
    assert columns in model["facts"]


def test_the_cases_of_all_interfaces_count(results, monkeypatch, says, tmp_path):
    monkeypatch.setattr(explorer, "MOST_CASES", results["status"].size * 5 - 1)
    says(refusal(explorer.view, results, tmp_path / "page.html"))


@needs_browser
def test_an_interface_is_chosen_and_its_buildings_are_shown(driver, results, written):
    driver.get_log("browser")
    reader = Reader(driver, written)
    reader.pick(record="MADE-02", polarity="reversed", interface="Theatre | Tower")
    seen = reader.column(1)
    one = results.isel(record=1, polarity=1, **Results(results).scene_case)
    force, drift = one["peak_contact_force"].isel(interface=2), one["peak_drift"]
    assert number(seen["peak_contact_force"]) == pytest.approx(float(force) / 1e3, rel=5e-4)  # four digits
    for side, name in (("left", "Theatre"), ("right", "Tower")):
        assert number(seen[f"peak_drift {side}"]) == pytest.approx(float(drift.sel(building=name)) * 1e3, rel=5e-4)
    drawn = driver.execute_script(
        "return document.getElementById('profiles').data.map((one) => [one.name, one.x, one.y])"
    )
    assert [name for name, _, _ in drawn] == ["without contact", "with contact"] * 2
    tower = one["storey_drift"].sel(building="Tower").values * 1e3
    np.testing.assert_allclose(drawn[3][1], np.repeat(tower, 2), rtol=2e-7)  # float32 has seven digits
    assert drawn[3][2][-1] == pytest.approx(22.4)
    assert driver.get_log("browser") == []
