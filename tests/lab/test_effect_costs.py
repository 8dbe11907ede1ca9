"""The `effects` command: what it switches on, what it says of changes, what it refuses, and its figure."""

import json

import commands
import numpy as np
import pytest
from figure_words import words_of
from scenes import rigid, scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.lab.effects import combinations, effects
from pounding_risk.lab.effects_findings import ALL, COMPARED, NONE, changed_cases, changes, finding, yielding
from pounding_risk.models.effects import EFFECTS, acts_on_buildings
from pounding_risk.questions.effects import sheet
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.scene.tables import Effect
from pounding_risk.studies import demo

STRAIN = {"code": "mc2010", "length": "0.6 m"}
GRID = {"gap": ["0 mm", "4 mm"], "yield_force": ["300 kN", "3 MN"], "contact_model": ["viscous_elastoplastic"]}


def scene(**more):
    """The paper's pair, a small grid, both polarities."""
    base = demo.scene("paper").resolved()
    records = {**base["records"], "polarity": ["as recorded", "reversed"]}
    return scene_of({**base, "records": records, "grid": GRID, **more})


@pytest.fixture(scope="module")
def found():
    return effects(scene(), repeats=2)


def test_every_effect_alone_and_all_together(found):
    """A scene that names none is shown all there are; what acts on another comes with it."""
    names = found["effects"].values.tolist()
    several = "permanent_set + unloading_stiffness"
    assert names == [NONE, "strain_rate", "permanent_set", several, "wave_passage", ALL]
    assert found["acts_on_all"].values.tolist() == [0, 0, 0, 0, 1, 1]
    assert sorted(json.loads(found.attrs["effects"])) == sorted(name for name in EFFECTS if not acts_on_buildings(name))
    assert found["time"].dims == ("effects",) and float(found["time_ratio"][0]) == 1.0
    assert (found["status"] == 0).all() and yielding(found) >= 3


def test_the_named_effects_alone():
    two = (Effect("permanent_set"), Effect("unloading_stiffness", (("ratio", 2.0),)))
    assert list(combinations(two)) == [NONE, "permanent_set", "permanent_set + unloading_stiffness"]
    assert list(combinations(two[:1])) == [NONE, "permanent_set"]
    assert combinations(two)["permanent_set + unloading_stiffness"] == two


def test_numbers_are_those_of_scans(found):
    """Changes by hand from two scans of the public kind."""
    with_set = pr.scan(scene(effects={"permanent_set": {}}), check_fraction=0.0)
    plain = pr.scan(scene(), check_fraction=0.0)
    for output in COMPARED:
        assert np.array_equal(found[output].sel(effects="permanent_set").values, with_set[output].values)
        assert np.array_equal(found[output].sel(effects=NONE).values, plain[output].values)
    yields = plain["yield_exceedance"].values == 1
    before, after = (each["peak_relative_displacement"].values[yields] for each in (plain, with_set))
    changed = changes(found, "permanent_set", "peak_relative_displacement")
    assert changed == pytest.approx(after / before - 1.0, abs=1e-15)
    assert changed_cases(found, "permanent_set") <= int(yields.sum())
    assert np.isposinf(changes(found, "permanent_set", "permanent_set")).any()


def test_an_effect_that_changes_nothing_is_named(found):
    """F_E out of reach: nothing yields, and all effects are idle; made by hand, one of them alone."""
    together = {"strain_rate": STRAIN, "permanent_set": {}, "unloading_stiffness": {"ratio": 2.0}}
    still = effects(scene(grid={**GRID, "yield_force": ["900 MN"]}, effects=together), repeats=1)
    assert not any(changed_cases(still, name) for name in still["effects"].values[1:])
    assert still.attrs["finding"].startswith("No effect changes a reported digit of any of the 4 cases")
    one = found.copy(deep=True)
    for output in COMPARED:
        one[output].loc[{"effects": "strain_rate"}] = found[output].sel(effects=NONE)
    assert "strain_rate change no reported digit" in finding(one)


def test_a_change_beyond_the_printed_digits_is_none(found):
    near = found.copy(deep=True)
    for output in COMPARED:
        near[output].loc[{"effects": "strain_rate"}] = found[output].sel(effects=NONE)
    key = {"effects": "strain_rate", "polarity": "as recorded"}
    value = float(f"{float(found['peak_contact_force'].sel(effects=NONE).values.flat[0]):.4g}")
    near["peak_contact_force"].loc[{"effects": NONE}] = value
    near["peak_contact_force"].loc[{"effects": "strain_rate"}] = value * (1.0 + 1e-6)
    assert changed_cases(near, "strain_rate") == 0
    near["peak_contact_force"].loc[key] = value * 1.01
    assert changed_cases(near, "strain_rate") == near["status"].sel(effects=NONE).size // 2


def test_contact_that_an_effect_brings_is_an_infinite_change_in_table_and_figure(found):
    """It was left out of both; and the figure left out cases without contact, so that its medians were others."""
    brought = found.copy(deep=True)
    brought["impact_count"].loc[{"effects": "wave_passage"}] = 3
    brought["impact_count"].loc[{"effects": NONE}] = 4
    brought["impact_count"][{"effects": 0, "gap": 1, "polarity": 0}] = 0
    table = next(block for block in sheet(brought) if block["kind"] == "table")
    (cell,) = (row[6] for row in table["rows"] if row[0]["text"] == "wave_passage")
    assert cell["text"] == "-25 (-25 to ∞)" and "∞: nothing without effects" in table["caption"]
    figure = figures.effects_figure(brought)
    (axis,) = (axis for axis in figure.axes if "2 from zero" in [text.get_text() for text in axis.texts])
    assert axis.get_title() == "impact count" and "from zero: nothing without effects" in words_of(figure)
    # A bar that goes on beyond the panel ends in an arrow at its edge.
    assert {line.get_xdata()[0] for line in axis.lines if line.get_marker() == ">"} == {axis.get_xlim()[1]}


@pytest.mark.complete
def test_a_scene_that_cannot_yield_knows_the_wave_alone():
    """Of all effects only those that act on one of its contact models; the changes are over all cases then."""
    found = effects(scene(grid={**GRID, "contact_model": ["merged"]}), repeats=1)
    assert found["effects"].values.tolist() == [NONE, "wave_passage"]
    assert yielding(found) == 0
    assert changes(found, "wave_passage", "impulse").size == found["status"].sel(effects=NONE).size
    assert "wave_passage changes the peak relative displacement most" in found.attrs["finding"]


@pytest.mark.complete
def test_command_prints_draws_and_writes(tmp_path):
    path = tmp_path / "scene.toml"
    of_rate = {"code": "mc1990", "length": "0.6 m", "strength": "30 MPa"}
    path.write_text(scene(effects={"strain_rate": of_rate}).to_toml())
    figure, out = tmp_path / "effects.svg", tmp_path / "effects.nc"
    told = commands.done("effects", path, "-o", out, "--figure", figure)
    lines = told.stdout.splitlines()
    assert [line.split("  ")[0] for line in lines[5:7]] == ["none", "strain_rate"]
    assert any(line.startswith("strain_rate") and "code mc1990, length 600 mm, strength" in line for line in lines)
    assert lines[0].startswith("strain_rate changes the peak relative displacement")
    dataset = pr.open_results(out)
    assert dataset.attrs["finding"] in told.stdout and "<svg" in figure.read_text()
    commands.refused("effects", path, "--figure", "f.bmp")


ROW = scene_text(
    storeyed("tall", "200 t", "180 MN/m", storeys=4, storey_strengths="2 MN"),
    single("shop", "150 t", "0.25 s", height="3 m"),
    rigid(),
    name="Four storeys beside a shop",
    gap="5 mm",
    yield_force="300 kN",
    records={"window": ["1 s", "5 s"]},
    grid={"gap": ["5 mm", "2 m"]},
)


@pytest.fixture(scope="module")
def of_row():
    return effects(parse_scene(ROW), repeats=1)


def test_a_row_that_names_none_is_shown_those_of_ground_and_buildings(of_row):
    """Its law has no cap, so that no effect of yielding acts; every other effect acts on all cases."""
    others = ["wave_passage", "inelastic_storeys", "p_delta", "soil_flexibility"]
    assert of_row["effects"].values.tolist() == [NONE, *others, ALL]
    assert of_row["acts_on_all"].values.tolist() == [0, 1, 1, 1, 1, 1]
    assert (of_row["status"] == 0).all()
    assert yielding(of_row) == 1  # of two cases one has no contact
    assert (of_row["time"] > 0.0).all()
    assert of_row.attrs["left_out"] == ""
    assert "changes the peak relative displacement most" in of_row.attrs["finding"]


def test_changes_of_a_row_are_those_of_scans(of_row):
    """By hand from two scans: every interface and every building counts."""
    plain, softer = (pr.scan(parse_scene(ROW + more), check_fraction=0.0) for more in ("", "[effects]\np_delta = {}\n"))
    for output in ("peak_relative_displacement", "peak_storey_shear"):
        before, after = (each[output].values.ravel() for each in (plain, softer))
        known = np.isfinite(before)
        found = changes(of_row, "p_delta", output)
        assert found == pytest.approx(after[known] / before[known] - 1.0, abs=1e-15)
    assert changes(of_row, "p_delta", "peak_relative_displacement").size == 2 * 2  # interfaces, cases
    assert changed_cases(of_row, "p_delta") == 2
    # The wall has no storeys; weights of some MN against storeys of some 100 MN/m take a hundredth of them.
    assert 0.0 < np.abs(changes(of_row, "p_delta", "peak_storey_shear")).max() < 0.1


@pytest.mark.complete
def test_what_has_no_place_in_a_row_is_said():
    """Neither strengths nor a height: two effects are left out, with the reason."""
    bare = ROW.replace('storey_strengths = "2 MN"\n', "").replace('"0.25 s"\nheight = "3 m"', '"0.25 s"')
    found = effects(parse_scene(bare), repeats=1)
    assert found["effects"].values.tolist() == [NONE, "wave_passage", "soil_flexibility", ALL]
    assert "no building gives storey_strengths" in found.attrs["left_out"]
    assert "p_delta: shop has no height" in found.attrs["left_out"]


def test_command_and_figure_of_a_row(of_row, tmp_path):
    drawn = figures.effects_figure(of_row)
    assert "shown: 1 of 2 cases that yield" in words_of(drawn).replace("\n", " ")
    assert "dots: a case at one interface" in words_of(drawn).replace("\n", " ")
    for axis in drawn.axes[:5]:  # fewer than a hundred values, so that the panel holds them all
        low, high = axis.get_xlim()
        dots = [line.get_xdata() for line in axis.lines if line.get_marker() == "."]
        assert all(low < value < high for values in dots for value in values)
    path = tmp_path / "row.toml"
    path.write_text(ROW + "[effects]\np_delta = {}\n", "utf-8")
    told = commands.done("effects", path, "--figure", tmp_path / "effects.png")
    assert [line.split("  ")[0] for line in told.stdout.splitlines()[5:7]] == ["none", "p_delta"]


def test_figure_is_the_same_for_the_same_data(found, tmp_path):
    for name in ("a.svg", "b.svg"):
        figures.write(figures.effects_figure(found), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    drawn = figures.effects_figure(found)
    assert found.attrs["finding"][:40] in drawn.get_suptitle()
    labels = [axis.get_xlabel() for axis in drawn.axes]
    assert "widening of the gap at the end [mm]" in labels and "over that without effects [1]" in labels


def test_an_output_that_is_zero_in_every_case_has_no_panel(found):
    """Its panel had no bar, no dot away from the line at zero, and no word on why."""
    titles = [axis.get_title() for axis in figures.effects_figure(found).axes]
    idle = found.copy(deep=True)
    idle["permanent_set"][:] = 0.0
    drawn = figures.effects_figure(idle)
    left = [axis.get_title() for axis in drawn.axes if axis.get_visible()]
    assert [title for title in titles if title not in left] == ["permanent set"] and left[-1] == "time of a run"
    assert "no panel, as above zero in no case: permanent set" in words_of(drawn).replace("\n", " ")


def test_what_links_do_not_stand_is_left_out_and_failed_runs_change_no_count(found):
    pair = single("a", "200 t", "0.9 s"), single("b", "200 t", "0.4 s")
    given = {"gap": "20 mm", "records": {"window": ["0 s", "6 s"], "pga": "0.4 g"}}
    linked = effects(parse_scene(scene_text(*pair, link_stiffness="10 MN/m", **given)), repeats=1)
    assert linked["effects"].values.tolist() == [NONE, "soil_flexibility"]
    assert "wave_passage: interface.link_stiffness: links are computed" in linked.attrs["left_out"]
    failed = found.copy(deep=True)
    failed["impact_count"].loc[{"effects": "wave_passage"}] = -1
    assert changes(failed, "wave_passage", "impact_count").size == 0
    # Nor is there a sentence on the largest change of what no run has.
    failed["peak_relative_displacement"].loc[{"effects": failed["effects"].values[1:]}] = np.nan
    assert "No change of the peak relative displacement is known" in finding(failed)
