"""The command `damage`: from a scan and its states to tables, a dataset, a CSV file and figures; what it refuses."""

from __future__ import annotations

import csv
from pathlib import Path

import commands
import numpy as np
import pytest
from figure_words import words_of
from scenes import scene_text, single

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.figures import damage_figure, ida_figure, results_figure

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
    """A folder with a scan, a hazard curve and other states."""
    folder = tmp_path_factory.mktemp("damage")
    pr.scan(pr.read_scene(SCENE), folder / "scan.nc", check_fraction=0.0)
    (folder / "hazard.csv").write_text("pga [g],annual rate\n0.05,0.1\n0.2,0.005\n2,1e-5\n", encoding="utf-8")
    (folder / "other.toml").write_text('[[damage]]\nname = "blow"\ncontact_force = "50 kN"\n', encoding="utf-8")
    return folder


def run(folder: Path, monkeypatch, *words: str):
    monkeypatch.chdir(folder)
    return commands.run("damage", *words)


@pytest.mark.complete
def test_a_scan_gives_tables_a_dataset_and_figures(folder, monkeypatch):
    asked = ["scan.nc", "--method", "ida", "--hazard", "hazard.csv", "--at", "0.1 g", "-o", "d.nc"]
    done = run(folder, monkeypatch, *asked, "--figure", "d.svg", "--ida-figure", "i.svg")
    assert done.exit_code == 0, done.output
    results = pr.open_results(folder / "d.nc")
    lines = done.stdout.splitlines()
    tiles = [line.split() for line in lines if line.startswith("tiles")]
    one = results.sel(state="tiles")
    median = float(one["median"].sel(pounding="with")) / 9.80665
    assert tiles[0][:8] == [
        "tiles",
        "floor",
        "displacement",
        "≥",
        "20",
        "mm",
        "with",
        str(int(one["reached"][0].sum())),
    ]
    assert float(tiles[0][9]) == pytest.approx(median, rel=5e-3)
    assert float(tiles[2][1]) == pytest.approx(float(one["median_ratio"]), rel=5e-3)
    assert results["at_intensity"].values == pytest.approx(0.980665)
    rate = float(one["annual_rate"].sel(pounding="with"))
    assert float(tiles[3][1]) == pytest.approx(rate, rel=5e-3)
    assert results.attrs["finding"] in done.stdout and "ruin has no ratio" in results.attrs["finding"]
    assert "note: ruin, with pounding: no curve: no motion reaches" in done.stdout
    assert all((folder / name).exists() for name in ("d.svg", "i.svg"))
    assert run(folder, monkeypatch, *asked).exit_code == 0  # the same results are replaced
    refused = run(folder, monkeypatch, "scan.nc", "-o", "scan.nc")
    assert refused.exit_code == 2 and "holds the results of scan, not those of damage" in refused.stderr


def test_states_of_a_file_and_a_table(folder, monkeypatch):
    done = run(folder, monkeypatch, "scan.nc", "--states", "other.toml", "-o", "d.csv")
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader((folder / "d.csv").read_text(encoding="utf-8").splitlines()))
    assert [(row["state"], row["pounding"]) for row in rows] == [("blow", "with"), ("blow", "without")]
    assert int(rows[0]["reached"]) > 0 == int(rows[1]["reached"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--states", "none.toml"], "none.toml: 1 fault\n  - no such file"),
        (["--gap", "5 mm"], "gap 5 mm is not in the grid, which has 10 mm"),
        (["--method", "clouds"], 'method: "clouds" is none (did you mean "cloud"?)'),
        (["--figure", "d.gif"], "--figure: "),
    ],
)
def test_what_it_refuses_ends_with_status_2(folder, monkeypatch, words, said):
    done = run(folder, monkeypatch, "scan.nc", *words)
    assert done.exit_code == 2 and said in done.stderr and "Traceback" not in done.stderr


def test_figures_say_the_finding(folder):
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
    assert words_of(demands).startswith("Demands of the motions against their intensity")
    assert [axis.get_title() for axis in demands.axes] == ["with pounding", "without pounding"]
    limits = [line.get_xdata()[0] for line in demands.axes[0].get_lines() if line.get_linestyle() == ":"]
    assert limits == [20.0, 40.0, 20000.0]  # mm
    assert words_of(results_figure(results)) == words_of(damage_figure(results))
    assert words_of(results_figure(results, "ida")) == words_of(demands)
    with pytest.raises(PoundingError, match="this is no dataset of `pounding-risk damage`"):
        damage_figure(pr.open_results(folder / "scan.nc"))
    with pytest.raises(PoundingError, match="have one level each; curves of demands need several"):
        ida_figure(results.isel(level=[0]))


def test_a_report_has_a_section_on_the_states(folder):
    """With the numbers of the command; none for a scene without states."""
    from pounding_risk.assessment.assess import assess
    from pounding_risk.reports.data import ReportData
    from pounding_risk.reports.document import SECTIONS

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
