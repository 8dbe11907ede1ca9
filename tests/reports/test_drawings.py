"""The commands that draw, assess and separate a row, on a made dataset on disk."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from commands import done, refused, run
from figure_words import words_of
from made_row import STREET, made_row, made_run
from sentences import refusal
from streets_drawn import street_file

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.assessment.row import row_case
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.errors import PoundingError
from pounding_risk.figures.scan import scan_figure
from pounding_risk.reports.drawings import footprints_of
from pounding_risk.results.files import save

PICTURES = {"elevation": "e.svg", "profiles": "q.pdf"}


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """A row's dataset on disk."""
    return save(made_row(records=3), tmp_path_factory.mktemp("row") / "row.nc")


@pytest.mark.complete
def test_draw_writes_what_is_asked_for(file, tmp_path):
    words = [word for name, path in PICTURES.items() for word in (f"--{name}", tmp_path / path)]
    told = done("draw", file, *words, "--gap", "50 mm", "--building", "Tower", "--yield-force", "inf")
    starts = {"e.svg": b"<?xml", "q.pdf": b"%PDF"}
    assert {name: (tmp_path / name).read_bytes()[: len(start)] for name, start in starts.items()} == starts
    drawn = (tmp_path / "e.svg").read_text("utf-8")
    assert "gap 50 mm, $F_E$ = 300 kN of columns, floors without yielding" in drawn
    assert told.output.count("written: ") == 2


def test_draw_animates_a_run(tmp_path):
    path = save(made_run(3.0), tmp_path / "run.nc")
    done("draw", path, "--animation", tmp_path / "run.html")
    assert (tmp_path / "run.html").read_text("utf-8").startswith("<!doctype html>")


REFUSED = {
    "nothing to draw": [],
    "no picture": ["--elevation", "e.gif"],
    "another model": ["--plan", "p.png", "--contact-model", "hertz"],
    "another building": ["--profiles", "q.png", "--building", "Turm"],
    "a scan to animate": ["--animation", "a.html"],
    "a figure misspelt": ["--figure", "ratoi=n.png"],
    "a figure without a file": ["--figure", "ratio"],
}


@pytest.mark.parametrize("case", REFUSED)
def test_draw_refuses_in_words_and_writes_nothing(file, case, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    says(refused("draw", file, *REFUSED[case]))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.complete
def test_any_figure_is_drawn_by_its_name(file, tmp_path):
    """The same file as by its function."""
    drawn, expected = tmp_path / "r.svg", tmp_path / "expected.svg"
    assert done("draw", file, "--figure", f"ratio={drawn}").output.count("written: ") == 1
    figures.write(figures.ratio_figure(pr.open_results(file)), expected)
    assert drawn.read_bytes() == expected.read_bytes()


def test_several_rows_share_a_plan_only(file, says, tmp_path):
    says(refusal(pr.draw, [file, file], elevation=tmp_path / "e.png"))
    (path,) = pr.draw([file, file], plan=tmp_path / "p.svg")
    assert path.read_text("utf-8").count("<!-- Corner -->") == 4  # two rows in two panels


def test_a_plan_takes_the_footprints_of_a_street(file, tmp_path):
    street = street_file(tmp_path / "street.geojson", [("", name) for name in (*(one.name for one in STREET), "Lone")])
    done("draw", file, "--plan", tmp_path / "p.svg", "--street", street)
    assert "no result given" in (tmp_path / "p.svg").read_text("utf-8")


def test_buildings_of_one_name_in_two_streets_stand_apart(tmp_path):
    """Each row in the street that its title begins with; by their names alone both would be in one place."""
    names = [one.name for one in STREET]
    street = street_file(tmp_path / "street.geojson", [(of, name) for of in ("High St", "Low St") for name in names])
    rows = [row_case(made_row(records=2).assign_attrs(title=f"{of}, row 1")) for of in ("Low St", "High St")]
    footprints = footprints_of(street, rows)
    low, high = (np.concatenate([footprints[at, name][0] for name in names]) for at in (0, 1))
    assert high[:, 0].max() < low[:, 0].min()  # Low St goes on east of High St
    panel = figures.plan_figure(rows, footprints).axes[0]
    (drawn,) = (each for each in panel.collections if each.get_array() is not None)
    assert len({tuple(path.vertices[0]) for path in drawn.get_paths()}) == 2 * len(names)
    assert "High St Corner" in footprints_of(street, rows[:1])
    with pytest.raises(PoundingError, match=r"Corner.* of several rows would stand in one footprint"):
        figures.plan_figure(rows, {name: footprints[0, name] for name in names})


def test_assess_and_separations_speak_of_every_interface(file):
    told = done("assess", file)
    names = [f"{one.name} | {other.name}" for one, other in pairwise(STREET)]
    assert all(f"\n{name}\n" in told.output for name in names)
    assert "columns' own" in told.output
    summed = told.output.partition("verdict")[2].partition("Corner | Arcade\n")[0]
    assert [line.partition("  ")[0] for line in summed.splitlines()[1:] if "|" in line] == names
    rules = run("separations", file)
    assert all(name in rules.output for name in names)
    one = done("separations", file, "--interface", "Theatre | Tower")
    assert "displacement, Tower" in one.output and "Corner" not in one.output
    refused("separations", file, "--interface", "Tower")


def largest_of(figure) -> float:
    """The largest value of the maps of a figure."""
    meshes = [mesh for axis in figure.axes for mesh in axis.collections if mesh.get_array() is not None]
    return max(float(np.nanmax(mesh.get_array())) for mesh in meshes)


def test_the_figure_of_a_scan_shows_the_largest_of_all_interfaces(file):
    results = pr.open_results(file)
    figure = scan_figure(results)
    said = words_of(figure).replace("\n", " ")
    assert "the largest of 5 interfaces" in said
    assert largest_of(figure) == pytest.approx(1e3 * float(results["peak_relative_displacement"].isel(pga=1).max()))


def test_the_figure_of_a_scan_that_varies_one_gap_shows_that_interface():
    results = made_row(records=2, gaps=(0.0, 0.02), named=1, own_gaps=(0.03, 0.02, 0.04, 0.04, 0.04))
    figure = scan_figure(results)
    assert f"{STREET[1].name} | {STREET[2].name}, whose gap varies" in words_of(figure).replace("\n", " ")
    peaks = results["peak_relative_displacement"].isel(pga=1, interface=1)
    assert largest_of(figure) == pytest.approx(1e3 * float(peaks.max()))


def test_code_table_asks_for_one_interface(file, says):
    says(refusal(code_table, pr.open_results(file)))
