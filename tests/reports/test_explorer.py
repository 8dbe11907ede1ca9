"""The page of `view`, of pairs and rows, holds the dataset's numbers, fetches nothing, and shows what it holds."""

import base64
import json
import re
import sys
from hashlib import sha256
from pathlib import Path

import commands
import numpy as np
import pytest
import xarray as xr
from explorer_page import Page, Reader, embedded, needs_browser, number, unpacked
from made_row import made_row
from sentences import refusal

from pounding_risk.ensemble.scan import scan
from pounding_risk.reports import explorer
from pounding_risk.results.files import save
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies import demo

pytest.importorskip("plotly")
G = 9.80665
GRID = """
[grid]
gap = ["0 mm", "4 mm", "11.5 mm"]
yield_force = ["200 kN", "450 kN", "inf"]
contact_model = ["jankowski", "viscous_elastoplastic"]
pga = ["0.3 g", "0.5 g"]
"""
CASE = ("record", "polarity", "pga", "contact_model", "gap", "yield_force")
FAILED = {"polarity": 0, "pga": 1, "contact_model": 1, "gap": 1, "yield_force": 0}  # 4 mm and 200 kN
OUT_OF_STEPS = 3  # a status that is not complete


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """A scan of 72 cases, one of them made to have failed."""
    study = parse_scene(demo.scene("paper").text + GRID, source="grid.toml")
    dataset = scan(study, check_fraction=0.2)
    for name, found in dataset.data_vars.items():
        if set(CASE) <= set(found.dims) and name not in ("status", "simulated"):
            found[FAILED] = np.nan if found.dtype.kind == "f" else -1
    dataset["status"][FAILED] = OUT_OF_STEPS
    return dataset.squeeze("interface")  # the page has no choice of the only one


@pytest.fixture(scope="module")
def written(results, tmp_path_factory) -> Path:
    """The page of these results."""
    return explorer.view(results, tmp_path_factory.mktemp("page") / "explore.html")


def test_the_page_holds_every_number_of_the_dataset(results, written):
    model = embedded(written)
    held = {variable["name"]: variable for variable in model["outputs"]} | model["states"]
    cases = {name for name, found in results.data_vars.items() if {"gap", "yield_force"} <= set(found.dims)}
    alone = {"peak_displacement_free", "peak_storey_shear_free", "peak_floor_acceleration_free"}
    assert cases | alone | {"contact"} <= set(held)
    for name in set(held) - {"contact"}:
        found = results[name].transpose(*held[name]["dims"]).values
        # To the bit: what is compared is the rounded number.
        np.testing.assert_array_equal(unpacked(model, held[name]), found.astype(held[name]["kind"]), str(name))
    count = results["impact_count"].values
    np.testing.assert_array_equal(unpacked(model, held["contact"]), np.where(count < 0, -1, count > 0))
    assert (count < 0).sum() == 1


def test_axes_are_in_engineering_units_and_an_infinite_yield_force_is_none(written):
    labels = {axis["name"]: (axis["labels"], axis["unit"]) for axis in embedded(written)["axes"]}
    assert labels["gap"] == (["0", "4", "11.5"], "mm")
    assert labels["yield_force"] == (["200", "450", "none"], "kN")
    assert labels["pga"] == (["0.3 g", "0.5 g"], "")
    assert labels["building"] == (["frame", "masonry"], "")
    assert labels["contact_model"] == (["jankowski", "viscous_elastoplastic"], "")


def test_the_head_tells_cases_and_failures(written):
    facts = " ".join(embedded(written)["facts"])
    assert "72 cases." in facts
    assert "1 failed: marked × and counted in no number." in facts
    assert "recomputed at a tighter tolerance" in facts


def test_the_page_may_run_its_own_scripts_and_fetch_nothing(written):
    page = Page(written.read_text(encoding="utf-8"))
    assert page.fetched == ["data:,"]
    assert "default-src 'none'" in page.policy
    run = [text for kind, text in page.scripts if not kind]
    sums = [base64.b64encode(sha256(text.encode()).digest()).decode() for text in run]
    assert re.search(r"script-src ([^;]*);", page.policy)[1].split() == [f"'sha256-{each}'" for each in sums]
    assert len(run) == 2


def test_words_of_a_user_stay_words(results, tmp_path):
    evil = "</script><script>alert(1)</script>{{data}}"
    told = results.assign_attrs(title=evil, scene=evil)
    path = explorer.view(told, tmp_path / "page.html")
    assert len(Page(path.read_text(encoding="utf-8")).scripts) == 3
    assert embedded(path)["title"] == evil


def test_the_same_results_make_the_same_page(results, written, tmp_path):
    assert explorer.view(results, tmp_path / "again.html").read_bytes() == written.read_bytes()


@pytest.mark.complete
def test_a_part_is_chosen_by_record_model_and_amplitude(results, tmp_path):
    part = {"records": ["RSN6-180"], "contact_models": ["jankowski"], "pgas": [0.5 * G]}
    model = embedded(explorer.view(results, tmp_path / "part.html", **part))
    sizes = {axis["name"]: axis["labels"] for axis in model["axes"]}
    assert (sizes["contact_model"], sizes["pga"]) == (["jankowski"], ["0.5 g"])
    force = next(each for each in model["outputs"] if each["name"] == "peak_contact_force")
    ordered = results.sel(contact_model=["jankowski"]).isel(pga=[1])
    np.testing.assert_array_equal(unpacked(model, force), ordered["peak_contact_force"].values.astype("f4"))


REFUSED = {
    "another record": {"records": ["RSN6-18"]},
    "another contact model": {"contact_models": ["hertz"]},
    "another amplitude": {"pgas": [0.4 * G]},
    "no plotly": {},
    "40 cases at most": {},
    "20 cases at most": {},
    "10 cases at most": {},
    "no scan": {},
    "no page": {},
    "no file": {},
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_page_can_hold_is_refused(results, case, says, tmp_path, monkeypatch):
    """Of too many cases with a part that fits."""
    if "at most" in case:
        monkeypatch.setattr(explorer, "MOST_CASES", int(case[:2]))
    if case == "no plotly":
        monkeypatch.setitem(sys.modules, "plotly.offline", None)
    other = {"no scan": results.drop_vars("status"), "no file": tmp_path / "results.nc"}
    path = tmp_path / ("page.htm" if case == "no page" else "page.html")
    says(refusal(explorer.view, other.get(case, results), path, **REFUSED[case]))
    assert not list(tmp_path.iterdir())
    if case == "20 cases at most":
        part = {"contact_models": ["jankowski"], "pgas": [0.3 * G]}
        assert explorer.view(results, path, **part).exists()


def test_further_axes_are_picked_like_the_others(results):
    row = xr.concat([results, results], xr.Variable("interface", ["A | B", "B | C"]), data_vars="all")
    model = explorer.page_model(row)
    assert "interface" in model["pickers"]
    assert "interface" not in model["together"]
    force = next(each for each in model["outputs"] if each["name"] == "peak_contact_force")
    assert unpacked(model, force).size == 2 * results["peak_contact_force"].size


def test_files_without_whole_sentences_have_their_words(results):
    plain = results.copy()
    del plain["status"].attrs["sentences"]
    assert explorer.page_model(plain)["statuses"]["3"].startswith("the step budget ran out raise rtol")


def test_axes_that_were_taken_out_are_put_back(results):
    one = results.isel(gap=0, yield_force=0, pga=0)
    model = explorer.page_model(one)
    labels = {axis["name"]: axis["labels"] for axis in model["axes"]}
    assert (labels["gap"], labels["yield_force"]) == (["0"], ["200"])
    assert "Motions at PGA 0.3 g." in model["facts"]


def test_the_command(results, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save(results, "results.nc")
    done = commands.run("view", "results.nc", "--pga", "0.5 g")
    assert (done.exit_code, done.stdout[:27]) == (0, "written: results-view.html\n")
    assert [axis["labels"] for axis in embedded(Path("results-view.html"))["axes"] if axis["name"] == "pga"] == [
        ["0.5 g"]
    ]
    again = commands.refused("view", "results.nc")
    assert "results-view.html exists already; write -o results-view.html to replace it" in again


# ---- in a browser --------------------------------------------------------------------------------------------------
@pytest.fixture
def reader(driver, written) -> Reader:
    """The page at its first gap and yield force."""
    page = Reader(driver, written)
    page.to_corner()
    return page


FACTORS = {"m": 1e3, "N": 1e-3, "J": 1e-3, "N s": 1e-3, "m/s2": 1.0 / G}


def expected(results: xr.Dataset, key: str, case: dict) -> float:
    """What the page must show of a case: in engineering units; NaN where a count is not defined."""
    name, _, building = key.partition(" ")
    found = results[name].isel({dim: place for dim, place in case.items() if dim in results[name].dims})
    value = found.values[int(building)] if building else found.values[()]
    if found.dtype.kind == "i" and value < 0:
        return np.nan
    return float(value) * FACTORS.get(found.attrs["units"], 1.0)


@needs_browser
def test_a_cell_shows_the_numbers_of_its_case(reader, results):
    reader.pick(polarity="reversed", amplitude="0.5 g", contact_model="viscous_elastoplastic")
    reader.pick(output="peak contact force [kN]")
    reader.press("\ue014", "\ue013")  # right, up: 4 mm and 450 kN
    assert reader.text("reading").startswith("gap 4 mm, yield force 450 kN: 450 kN; complete")
    case = {"record": 0, "polarity": 1, "pga": 1, "contact_model": 1, "gap": 1, "yield_force": 1}
    seen = reader.column(1)
    assert seen.pop("contact") == "yes"
    assert seen.pop("yield_exceedance") == "yes"
    assert len(seen) > 25
    for key, words in seen.items():
        # Four digits are shown.
        assert number(words) == pytest.approx(expected(results, key, case), rel=5e-4, nan_ok=True), key


@needs_browser
def test_the_map_is_the_dataset_and_a_failed_run_is_a_cross_without_a_number(reader, results):
    reader.pick(polarity="as recorded", amplitude="0.5 g", contact_model="viscous_elastoplastic")
    reader.pick(output="peak contact force [kN]")
    drawn = reader.drawn()
    one = results.isel(record=0, polarity=0, pga=1, contact_model=1)
    force = one["peak_contact_force"].transpose("yield_force", "gap").values / 1e3
    # Float32 has seven digits.
    np.testing.assert_allclose(np.array(drawn["z"], dtype=float), force, rtol=2e-7, equal_nan=True)
    assert drawn["z"][0][1] is None
    assert (drawn["x"], drawn["y"]) == ([1], [0])
    reader.press("\ue014")
    assert "yield force 200 kN: × failed; × failed: the step budget ran out; raise rtol" in reader.text("reading")
    seen = reader.column(1)
    assert {words for key, words in seen.items() if "free" not in key} == {"× failed"}
    assert number(seen["peak_displacement_free 0"]) > 0.0
    assert "the run failed; no number" in reader.text("legend")


@needs_browser
@pytest.mark.parametrize(("statistic", "share"), [("median", 0.5), ("84th percentile", 0.84), ("largest", 1.0)])
def test_all_motions_together_are_their_quantiles_without_the_failed(reader, results, statistic, share):
    together = results.sel(contact_model="viscous_elastoplastic").isel(record=0, pga=1)
    together = together.transpose("polarity", "yield_force", "gap", ...)
    reader.pick(amplitude="0.5 g", contact_model="viscous_elastoplastic")
    shares = np.where(together["impact_count"] < 0, np.nan, together["impact_count"] > 0)
    np.testing.assert_allclose(reader.drawn()["z"], np.nanmean(shares, axis=0), rtol=1e-15)
    reader.pick(output="peak relative displacement [mm]", of_several_motions=statistic)
    peaks = np.nanquantile(together["peak_relative_displacement"].values * 1e3, share, axis=0)
    np.testing.assert_allclose(reader.drawn()["z"], peaks, rtol=2e-7)  # float32 has seven digits
    reader.press("\ue014")
    assert "2 motions, × 1 failed" in reader.text("reading")
    # Of the two motions one closes 11.5 mm, and it alone has a time of first impact.
    reader.press("\ue010")
    first = together["first_impact_time"].isel(gap=2, yield_force=0).values
    assert np.isnan(first).tolist() == [True, False]
    seen = reader.column(1)["first_impact_time"]
    assert seen.endswith(" s (of 1)")
    assert number(seen) == pytest.approx(first[1], rel=5e-4)  # four digits
    # The gap that a share of the motions needs is counted: of two motions 84 % need that of the second.
    needed = 1e3 * together["peak_closing_free"].values.ravel()
    assert needed.size == 2 and np.ptp(needed) > 0.01 * needed.max()
    counted = needed.mean() if share == 0.5 else needed.max()
    assert number(reader.column(1)["peak_closing_free"]) == pytest.approx(counted, rel=5e-4)


@needs_browser
def test_two_cells_are_pinned_and_compared(driver, reader):
    reader.pick(polarity="reversed", contact_model="jankowski", output="impulse [kN s]")
    reader.press("a")
    reader.pick(contact_model="viscous_elastoplastic")
    reader.press("\ue013", "b")
    reader.press("\ue014", "\ue014")
    heads = driver.execute_script(
        "return [...document.querySelectorAll('#table thead th')].map((each) => each.innerText)"
    )
    assert ["jankowski" in head for head in heads] == [False, False, True, False, False]
    assert "gap 0 mm, yield force 450 kN" in heads[3]
    one, other, ratio = (reader.column(place)["impulse"] for place in (2, 3, 4))
    assert number(ratio) == pytest.approx(number(other) / number(one), rel=1e-3)  # of four digits each
    marks = driver.execute_script("return document.getElementById('map').layout.annotations.map((note) => note.text)")
    assert marks == ["<b>A</b>", "<b>B</b>"]
    reader.click("unpin")
    assert driver.execute_script("return document.querySelectorAll('#table thead th').length") == 2


@needs_browser
def test_the_page_begins_at_the_scenes_own_case(driver, written):
    reader = Reader(driver, written)
    assert reader.text("reading").startswith("gap 0 mm, yield force 450 kN")
    chosen = driver.execute_script(
        "return [...document.querySelectorAll('select')].map((one) => [one.name, one.selectedOptions[0]?.text])"
    )
    assert {"contact model": "viscous_elastoplastic", "amplitude": "0.5 g"}.items() <= dict(chosen).items()


@needs_browser
def test_the_mouse_chooses_the_cell_under_it(driver, reader):
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(driver).move_to_element(driver.find_element("css selector", "#map .nsewdrag")).click().perform()
    reader.until("return document.getElementById('reading').textContent.startsWith('gap 4 mm, yield force 450 kN')")


@needs_browser
def test_the_page_asks_for_nothing_and_complains_of_nothing(driver, written):
    driver.get_log("performance")
    driver.get_log("browser")
    reader = Reader(driver, written)
    reader.pick(polarity="reversed", output="peak contact force [kN]")
    reader.press("\ue014", "a")
    for button in ("pin-B", "steady", "unpin"):
        reader.click(button)
    events = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    asked = {event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"}
    assert written.as_uri() in asked
    assert all(url == written.as_uri() or url.startswith(("data:", "blob:")) for url in asked)
    assert driver.get_log("browser") == []
    names = driver.execute_script(
        "return [...document.querySelectorAll('.modebar-btn')].map((each) => each.dataset.title)"
    )
    assert len(names) >= 5
    assert not [name for name in names if re.search("[Ss]hare|[Cc]loud|[Uu]pload", name)]


@needs_browser
def test_a_browser_that_cannot_unpack_is_told(driver, written):
    script = driver.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument", {"source": "delete window.DecompressionStream"}
    )
    try:
        assert "needs a browser of 2023 or later" in Reader(driver, written).text("trouble")
    finally:
        driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)


@pytest.fixture(scope="module")
def row_results() -> xr.Dataset:
    """Six records in two polarities, one run failed."""
    return made_row(failed=True)


@pytest.fixture(scope="module")
def row_written(row_results, tmp_path_factory):
    return explorer.view(row_results, tmp_path_factory.mktemp("page") / "row.html")


@pytest.mark.complete
def test_the_page_of_a_row_holds_its_interfaces_and_storeys(row_results, row_written):
    model = embedded(row_written)
    assert model["pickers"][-1] == "interface"
    assert {axis["name"]: axis["labels"] for axis in model["axes"]}["interface"] == list(
        row_results["interface"].values
    )
    held = {variable["name"]: variable for variable in model["outputs"]}
    for name in ("impact_count", "peak_contact_force", "peak_closing_free", "peak_drift", "peak_drift_free"):
        found = row_results[name].transpose(*held[name]["dims"]).values
        np.testing.assert_array_equal(unpacked(model, held[name]), found.astype(held[name]["kind"]))
    model["axes"].append({"name": "storey", "labels": list(range(model["profiles"]["storeys"]))})
    names = []
    for each in model["profiles"]["quantities"]:
        for variable in (each["struck"], each["free"]):
            found = row_results[variable["name"]].transpose(*variable["dims"]).values
            np.testing.assert_array_equal(unpacked(model, variable), found.astype("f4"))
            names.append(variable["name"])
    assert names[:2] == ["storey_drift", "storey_drift_free"]
    assert [len(levels) for levels in model["profiles"]["levels"]] == [5, 3, 2, 7, 1, 0]


def test_the_row_stands_below_in_elevation_and_plan(row_results, row_written):
    page = row_written.read_text("utf-8")
    pictures = page[page.index('<section id="row"') : page.index("</section>", page.index('<section id="row"'))]
    assert pictures.count("<svg") == 2 and "http" not in pictures.replace("http://www.w3.org/", "")
    assert explorer.row_pictures(row_results.drop_vars("contact_point_impact_count")) == ""


def test_profiles_that_are_too_many_are_left_out_and_told(row_results, monkeypatch):
    monkeypatch.setattr(explorer, "MOST_OF_STOREYS", 100)
    model = explorer.page_model(row_results)
    assert model["profiles"] is None
    assert any("Storey profiles are left out" in each for each in model["facts"])


def test_whose_gap_the_axis_has_is_told():
    model = explorer.page_model(made_row(records=2, named=1))
    assert "The gap is that of Arcade | Theatre; the others keep their own." in model["facts"]
    columns = "The yield force is that of contacts between floors; those with a column have the column's."
    assert columns in model["facts"]


def test_the_cases_of_all_interfaces_count(row_results, monkeypatch, says, tmp_path):
    monkeypatch.setattr(explorer, "MOST_CASES", row_results["status"].size * 5 - 1)
    says(refusal(explorer.view, row_results, tmp_path / "page.html"))


@needs_browser
def test_an_interface_is_chosen_and_its_buildings_are_shown(driver, row_results, row_written):
    driver.get_log("browser")
    reader = Reader(driver, row_written)
    reader.pick(record="MADE-02", polarity="reversed", interface="Theatre | Tower")
    seen = reader.column(1)
    one = row_results.isel(record=1, polarity=1, **Results(row_results).scene_case)
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


@needs_browser
def test_the_words_of_the_axis_of_yield_forces_are_whole_beside_its_title(driver, row_written):
    Reader(driver, row_written)
    ticks, title, left = driver.execute_script(
        "const map = document.getElementById('map'), box = (one) => one.getBoundingClientRect();"
        "const ticks = [...map.querySelectorAll('.ytick text')].map((one) => [one.textContent, box(one).left]);"
        "return [ticks, box(map.querySelector('.ytitle')).right, box(map).left]"
    )
    assert "columns' own" in dict(ticks)
    assert left < title < min(place for _, place in ticks)
