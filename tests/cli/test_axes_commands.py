"""Commands on a scene with axes of its numbers, and `--select` on its results."""

import json
import re

import numpy as np
import pytest
from axes import AXES, pair_text
from commands import done, refused, run
from explorer_page import embedded, unpacked
from uncertain import uncertain_row_text, uncertain_text

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.results.files import open_results
from pounding_risk.results.opened import Results
from pounding_risk.statistics.required_gap import rounded_up

PLACE = ["--select", "building.left.period=0.5 s", "--select", "interface.restitution=0.8"]
PLACE += ["--select", "building.left.mass=600 t"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("axes")
    (folder / "s.toml").write_text(pair_text(AXES), encoding="utf-8")
    done("scan", folder / "s.toml", "-o", folder / "r.nc")
    return folder


def test_assess_prints_and_writes_every_place_and_select_the_whole_assessment(folder):
    told = done("assess", folder / "r.nc", "--gap", "30 mm", "-o", folder / "a.json")
    assert "30 mm" in told.output
    assert len(re.findall(r" 30 .* to .* to ", told.output)) == 12  # a row for each place
    assert "building.left.period" in told.output and "P(contact)" in told.output
    written = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert len(written["places"]) == 12 and written["places"][0]["building.left.period"] == 0.3
    assert written["idle_axes"] == ["interface.restitution", "building.left.mass"]
    assert written["own_places"] == {"building.left.period": 1, "building.left.mass": 0}
    # The widest gap required, rounded up as in an assessment: what is read suffices.
    least = rounded_up(max(place["required_gap"] for place in written["places"]))
    assert f" to {1e3 * least:.3g} mm (the most where" in told.output
    assert re.search(rf" {1e3 * least:.3g} +[\d.]+ to [\d.]+", told.output)
    one = done("assess", folder / "r.nc", *PLACE)
    assert "building.left.period = 0.5 s" in one.output and "left | right" in one.output


def test_summary_tells_what_lies_along_each_axis_and_of_some_places(folder):
    assert "(building.left.period = 0.5 s)" in run("summary", folder / "r.nc", *PLACE[:2]).output
    told = run("summary", folder / "r.nc").output
    assert "48" in told
    assert re.search(r"^building\.left\.period +0\.3 s, 0\.5 s, 0\.7 s; contact in 100 % of cases$", told, re.MULTILINE)


@pytest.mark.complete
def test_assess_draws_along_the_axes_and_a_report_has_them_and_one_place(folder):
    told = done("assess", folder / "r.nc", "--gap", "30 mm", "--figure", folder / "f.svg")
    assert (folder / "f.svg").stat().st_size > 1000
    assert "The gap required lies from" in told.output
    assert (
        "Neither P(contact) nor the gap required depends on interface.restitution, building.left.mass." in told.output
    )
    done("report", folder / "r.nc", "-o", folder / "r.html", "--gap", "30 mm", *PLACE[4:])
    page = (folder / "r.html").read_text(encoding="utf-8")
    assert "Along the axes of the scene" in page
    assert "building.left.period = 0.5 s, interface.restitution = 0.5: the scene&#39;s own values, and of" in page


def test_samples_beside_an_axis_are_answered_at_a_value_of_it(tmp_path):
    axis = {"interface.restitution": [0.5, 0.8]}
    numbers = {"building.left.mass": {"distribution": "normal", "cov": 0.1}}
    (tmp_path / "s.toml").write_text(uncertain_text(numbers, axes=axis), encoding="utf-8")
    done("scan", tmp_path / "s.toml", "-o", tmp_path / "r.nc")
    repair = re.search(r"choose with --select '(\S+)'", refused("uncertainty", tmp_path / "r.nc"))[1]
    told = done("uncertainty", tmp_path / "r.nc", "--select", repair).output
    assert "(interface.restitution = 0.5)" in told and "4 samples of 1 number" in told


@pytest.mark.parametrize("words", [["draw", "--elevation", "e.png"], ["separations"], ["assess", "--hazard", "h.csv"]])
def test_commands_that_take_one_place_say_so(folder, words):
    assert "--select 'building.left.period=0.3 s'" in refused(words[0], folder / "r.nc", *words[1:])


def test_view_lets_the_reader_choose_the_place(folder):
    done("view", folder / "r.nc", "-o", folder / "v.html", *PLACE[4:])
    model = embedded(folder / "v.html")
    assert model["pickers"][:3] == ["building.left.period", "interface.restitution", "building.left.mass"]
    assert model["start"]["building.left.period"] == 1
    labels = {axis["name"]: axis["labels"] for axis in model["axes"]}
    assert labels["building.left.period"] == ["0.3 s", "0.5 s", "0.7 s"]
    assert labels["building.left.mass"] == ["600 t"] and labels["interface.restitution"] == ["0.5", "0.8"]
    whole = pr.open_results(folder / "r.nc").sel({"building.left.mass": [6e5]}).squeeze("interface")
    outputs = {variable["name"]: variable for variable in model["outputs"]}
    for name in ("peak_contact_force", "peak_displacement", "peak_displacement_free"):
        kept = whole[name].transpose(*outputs[name]["dims"])
        np.testing.assert_array_equal(unpacked(model, outputs[name]), kept.values.astype("f4"), err_msg=name)
    assert "building.left.period" in outputs["peak_displacement_free"]["dims"]
    assert "interface.restitution" not in outputs["peak_displacement_free"]["dims"]


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """A row whose first gap the grid varies and whose second is uncertain, as files of a scan."""
    file = tmp_path_factory.mktemp("samples") / "row.toml"
    gap = {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}
    text = uncertain_row_text({"interface.2.gap": gap}, 2, {"interface": "A | B"}, 2)
    damage = '[[damage]]\nname = "slight"\ndrift = "0.5 %"\n'
    file.write_text(f"{text}\n{damage}", encoding="utf-8")
    done("scan", file, "-o", file.with_suffix(".nc"))
    return file.with_suffix(".nc")


ANSWERING = ("assess -o a.csv", "uncertainty -o u.csv", "summary", "view -o v.html", "draw --figure along=l.svg")
OF_ONE_PLACE = (
    "damage",
    "report -o r.html",
    "separations",
    "histories -o h.nc",
    *(f"draw --{option} d.svg" for option in ("elevation", "plan", "profiles")),
    *(f"draw --figure {name}=f.svg" for name in ("scan", "ratio", "assessment", "separations", "elevation")),
    *(f"export --to {name} -o x" for name in ("pelicun", "geoparquet", "csv")),
    *(f"export --to {name} -o x.{end}" for name, end in (("nrml", "xml"), ("geopackage", "gpkg"), ("taxonomy", "csv"))),
)


def test_a_row_of_uncertain_gaps_has_the_gaps_that_its_scene_states(samples):
    """Also of one gap of the grid; without the text of the scene those of the first sample."""
    dataset = open_results(samples)
    found = Results(dataset)
    assert found.gaps.values.tolist() == [[0.005, 0.01], [0.04, 0.01]]
    assert (found.varied_interface, found.scene_place) == (0, 0)
    assert Results(dataset.isel(gap=1).expand_dims("gap")).gaps.values.tolist() == [[0.04, 0.01]]
    lost = dataset.assign_attrs(scene_resolved="")
    np.testing.assert_array_equal(Results(lost).gaps, dataset["interface_gap"].isel(sample=0))


@pytest.mark.parametrize("line", [*ANSWERING, *OF_ONE_PLACE])
def test_every_command_on_a_row_of_uncertain_gaps_answers_or_says_why_not(line, samples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command, *options = line.split()
    if line in OF_ONE_PLACE:
        assert "--select 'sample=0'" in refused(command, samples, *options)
        return
    done(command, samples, *options)
    if command == "view":
        facts = embedded(tmp_path / "v.html")["facts"]
        assert "Each place along sample has gaps of its own; the axis gap has the scene's own of A | B." in facts


def test_separations_of_one_place(folder):
    done("separations", folder / "r.nc", *PLACE)


@pytest.mark.complete
def test_the_figure_of_a_scan_of_several_scenes_is_along_the_axes(folder):
    (folder / "q.toml").write_text(pair_text({"building.left.period": ["0.3 s", "0.6 s"]}), encoding="utf-8")
    done("scan", folder / "q.toml", "-o", folder / "q.nc", "--figure", folder / "q.svg")
    figures.write(figures.along_figure(pr.assess_along(folder / "q.nc")), folder / "own.svg")
    assert (folder / "q.svg").read_bytes() == (folder / "own.svg").read_bytes()


def test_samples_are_counted_added_and_chosen(tmp_path):
    scene, results = tmp_path / "s.toml", tmp_path / "r.nc"
    scene.write_text(uncertain_text(), encoding="utf-8")
    told = done("validate", scene)
    assert "4, sobol, seed 1" in told.output and "lognormal, median 0.5 s, dispersion 0.2" in told.output
    assert "3 samples are no power of two" in run("validate", scene, "--set", "uncertain.samples=3").output
    assert "8 = 2 of sample × 2 polarities × 2 gaps" in run("scan", scene, "--plan", "--samples", "2").output
    for count in ("2", "3"):
        done("scan", scene, "--samples", count, "-o", results)
    done("view", results, "-o", tmp_path / "v.html")
    (sample,) = [axis for axis in embedded(tmp_path / "v.html")["axes"] if axis["name"] == "sample"]
    first, other = pr.open_results(results)["building.left.period"].values[1:]
    assert sample["labels"][1].startswith(f"1, building.left.period {first:.10g} s, ") and first != other
    assert "sample = 2" in done("summary", results, "--select", "sample=2").output
    assert "uncertain.samples: was 3, is 2" in refused("scan", scene, "--samples", "2", "-o", results)
    assert "the uncertain numbers are at the values that the scene states" in run("modes", scene).output
