"""Damage states of a scan in figures and in the report."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from figure_words import words_of
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.assess import assess
from pounding_risk.figures import damage_figure, ida_figure, results_figure
from pounding_risk.questions.damage import sheet as damage_sheet
from pounding_risk.reports.data import ReportData
from pounding_risk.reports.document import SECTIONS

STATES = """
[[damage]]
name = "tiles"
displacement = "20 mm"

[[damage]]
name = "cracks"
displacement = "40 mm"

[[damage]]
name = "ruin"
displacement = "20 m"
"""
SCENE = STATES + scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "30 t", "0.8 s", damping=0.03),
    name="Two of $2",
    law="linear",
    gap="10 mm",
    records={"names": ["RSN6-180", "RSN77-164", "NAPA-HNE"], "window": ["0 s", "8 s"]},
    grid={"pga": ["0.05 g", "0.1 g", "0.2 g", "0.4 g"]},
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a scan."""
    folder = tmp_path_factory.mktemp("damage")
    pr.scan(pr.read_scene(SCENE), folder / "scan.nc", check_fraction=0.0)
    return folder


def test_figures_say_the_finding(folder, says):
    results = pr.damage(folder / "scan.nc", method="ida")
    figure = damage_figure(results, note="of a test")
    above, below = figure.axes
    headline, caption = words_of(figure).split("\n", 1)
    assert headline.startswith("Median PGA with pounding at 10 mm over that without: tiles ")
    assert f"{float(results['median_ratio'][0]):.2f}" in headline
    assert "3 motions at PGA 0.05 g to 0.4 g" in caption.replace("\n", " ") and "of a test" in caption
    solid, dashed = (
        [line for line in above.get_lines() if line.get_linestyle() == dash and len(line.get_xdata()) > 2]
        for dash in ("-", "--")
    )
    assert len(solid) == len(dashed) == 3 and below.get_yscale() == "log"
    assert [line.get_color() for line in solid] == [line.get_color() for line in dashed]
    with_pounding = results["probability"].sel(state="tiles", pounding="with")
    assert solid[0].get_ydata() == pytest.approx(with_pounding.values)
    demands = ida_figure(results)
    assert words_of(demands).splitlines()[0] == headline
    assert [axis.get_title() for axis in demands.axes] == ["with pounding", "without pounding"]
    far = results.assign(demand_ratio=results["demand_ratio"].where(results["pounding"] == "without", 1e5))
    count = far["demand_ratio"].sel(state="tiles", pounding="with").size
    titles = [axis.get_title() for axis in ida_figure(far).axes]
    assert titles == [f"with pounding; {count} of {count} demands beyond the axis, up to 2e+06 mm", "without pounding"]
    limits = [line.get_xdata()[0] for line in demands.axes[0].get_lines() if line.get_linestyle() == ":"]
    assert limits == [20.0, 40.0, 20000.0]  # mm
    assert words_of(results_figure(results)) == words_of(damage_figure(results))
    drawn = next(block for block in damage_sheet(results) if block["kind"] == "figure")
    assert not drawn["svg"]().get_suptitle()  # the sentence above it says the same
    assert "bands: bounds by recording" in drawn["caption"]
    assert words_of(results_figure(results, "ida")) == words_of(demands)
    says(refusal(damage_figure, pr.open_results(folder / "scan.nc")), refusal(ida_figure, results.isel(level=[0])))


def test_a_report_has_a_section_on_the_states(folder):
    """With the numbers of the command; none for a scene without states."""
    results = pr.open_results(folder / "scan.nc")
    blocks = SECTIONS["damage"].write(ReportData(results, assess(results), {}))
    found = pr.damage(results)
    assert [block["kind"] for block in blocks] == ["paragraph", "figure", "table", "table", "list"]
    assert blocks[0]["text"] == f"{found.attrs['finding']}."
    medians = [row[5]["raw"] for row in blocks[2]["rows"]]
    expected = found["median"].values.ravel()
    assert [np.nan if one is None else one for one in medians] == pytest.approx(expected, nan_ok=True)
    bare = results.assign_attrs(scene_resolved=results.attrs["scene_resolved"].partition("[[damage]]")[0])
    assert SECTIONS["damage"].write(ReportData(bare, assess(results), {})) == []
    other = results.assign_attrs(scene_resolved=results.attrs["scene_resolved"].replace("displacement", "ductility"))
    other.attrs["scene_resolved"] = other.attrs["scene_resolved"].replace('0.02 m"', '2"')
    del other.attrs["scene_sha256"]
    (said,) = SECTIONS["damage"].write(ReportData(other, assess(results), {}))
    assert said["text"].startswith("The damage states of the scene have no fragilities: ")
