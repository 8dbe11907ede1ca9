"""The animation of a run holds the run, keeps the peaks of contacts, is small, fetches nothing, moves in a browser."""

import base64
import re
import zlib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from explorer_page import embedded, needs_browser
from made_row import made_run
from sentences import refusal

from pounding_risk.reports import animation

RATE = 50.0


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """Twenty seconds at 200 instants a second."""
    return made_run()


@pytest.fixture(scope="module")
def written(run, tmp_path_factory) -> Path:
    """Its page."""
    return animation.animate(run, tmp_path_factory.mktemp("page") / "run.html")


def unpacked(text: str) -> np.ndarray:
    """16-bit numbers: deflated, all first bytes before all second ones."""
    found = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, -1)
    return np.ascontiguousarray(found.T).reshape(-1).view("<i2")


def test_the_peak_of_each_contact_point_is_a_frame(run, written):
    model = embedded(written)
    force = unpacked(model["force"]).reshape(model["frames"], -1) * model["strongest"]
    peak = run["contact_force"].values.max(axis=0)
    # Rounded to a step of the strongest over 32,000, half of one at most.
    np.testing.assert_allclose(force.max(axis=0), peak, atol=0.5001 * peak.max() / animation.FORCES)
    assert peak.max() > 0.0


def test_a_frame_with_contact_shows_the_instant_of_its_largest_force(run, written):
    model = embedded(written)
    moved = unpacked(model["displacement"]).reshape(model["frames"], -1).cumsum(axis=0) * model["largest"]
    time, strongest = run["time"].values, run["contact_force"].values.max(axis=1)
    floors = run["displacement"].values[:, np.isfinite(run["displacement"].values).any(axis=0)]
    assert model["rate"] == RATE
    checked = 0
    for frame in range(1, model["frames"] - 1):
        inside = (time > (frame - 1) / RATE + 1e-9) & (time <= frame / RATE + 1e-9)
        if not strongest[inside].max(initial=0.0) > 0.0:
            continue
        at = np.flatnonzero(inside)[strongest[inside].argmax()]
        assert model["time"][frame] == pytest.approx(time[at], abs=5e-5)  # four decimals
        np.testing.assert_allclose(moved[frame], floors[at], atol=0.51 * model["largest"])  # half a step
        checked += 1
    assert checked > 50


def test_a_long_row_stays_small_with_fewer_frames(run, tmp_path):
    """Thirty buildings over a minute: the rate falls until the page is small."""
    rows = xr.concat([run.isel(building=slice(0, 5)).drop_vars("building")] * 6, "building", data_vars="minimal")
    noise = np.random.default_rng(1).normal(0.0, 0.01, rows["displacement"].shape)
    long = rows.assign(displacement=rows["displacement"] + noise).assign_coords(
        time=3.0 * run["time"].values, building=[f"B{place}" for place in range(30)]
    )
    path = animation.animate(long, tmp_path / "long.html")
    assert path.stat().st_size <= animation.LARGEST
    assert embedded(path)["rate"] < RATE
    assert len(embedded(path)["buildings"]) == 30


def test_a_run_without_contact_stands_too(run, tmp_path):
    still = run.assign(contact_force=0.0 * run["contact_force"])
    model = embedded(animation.animate(still, tmp_path / "still.html"))
    assert "Nothing touches" in model["facts"]
    assert not unpacked(model["force"]).any()


def test_links_are_told_as_what_is_not_drawn(run, written, tmp_path):
    linked = run.assign_coords(link=["A 2 | B 2"])
    told = embedded(animation.animate(linked, tmp_path / "linked.html"))["facts"]
    words = "springs or dampers between neighbours not drawn"
    assert words in told and words not in embedded(written)["facts"]


def test_what_is_no_run_is_told(run, says, tmp_path):
    for dataset, name in (
        (run.drop_vars("contact_force"), "a.html"),
        (run.isel(time=slice(0, 1)), "a.html"),
        (run, "a.gif"),
    ):
        says(refusal(animation.animate, dataset, tmp_path / name))


def test_the_page_holds_one_script_by_its_checksum_and_names_no_other_place(written):
    text = written.read_text("utf-8")
    assert written.stat().st_size < animation.LARGEST
    assert "default-src 'none'" in text
    assert set(re.findall(r"https?://[^\"']+", text)) == {"http://www.w3.org/2000/svg"}  # a name, never fetched


@pytest.mark.parametrize("page", ["animation", "explorer"])
def test_the_constants_of_a_script_are_declared(page):
    """One that is not stops a page at the moment that needs it, such as more contacts at once than are named."""
    script = (files("pounding_risk.reports") / f"{page}_page" / "page.js").read_text("utf-8")
    code = re.sub(r"//.*|\"[^\"\n]*\"", "", script)
    used = set(re.findall(r"\b[A-Z]{3,}(?:_[A-Z]+)*\b", code))
    assert used <= {*re.findall(r"const ([A-Z_]+) =", script), "JSON"}


@needs_browser
def test_it_plays_and_goes_to_contacts_in_a_browser(driver, run, written):
    from selenium.webdriver.support.ui import WebDriverWait

    driver.get_log("browser")
    driver.get(written.as_uri())
    wait = WebDriverWait(driver, 30, 0.02)
    wait.until(lambda page: page.execute_script("return document.body.dataset.ready === 'yes'"))
    peak = float(run["contact_force"].max())
    scale = re.search(r"line: largest contact force, 0 to ([\d.]+) (MN|kN)", driver.find_element("id", "scale").text)
    assert scale and float(scale[1]) * {"MN": 1e6, "kN": 1e3}[scale[2]] == pytest.approx(peak, rel=5e-3)
    driver.find_element("id", "next").click()
    told = driver.find_element("id", "reading").text
    seconds = float(told.split()[0])
    near = run["contact_force"].sel(time=seconds, method="nearest", tolerance=0.003).values
    assert "Contact: " in told
    assert near.max() > 0.0
    assert len(driver.find_elements("css selector", "#row .touch")) == (near > 0.0).sum()
    before = driver.find_element("css selector", "#row .building").get_attribute("d")
    driver.find_element("id", "play").click()
    wait.until(lambda page: int(page.find_element("id", "at").get_attribute("value")) > seconds * RATE + 5)
    driver.find_element("id", "play").click()
    assert driver.find_element("css selector", "#row .building").get_attribute("d") != before
    assert driver.get_log("browser") == []
