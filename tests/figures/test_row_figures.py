"""Figures of rows show what the dataset says, and draw every building, gap and contact point of it.

The dataset is made, not solved (`made_row`): what is checked is what is drawn of it.
"""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from made_row import STREET, made_row
from matplotlib.collections import PathCollection
from matplotlib.text import Text
from scenes import scene_text, single
from sentences import refusal
from sweeps import sweep

from pounding_risk.assessment.row import RowCase, any_of_building, row_case
from pounding_risk.ensemble.scan import scan
from pounding_risk.figures.row import (
    LABELLED,
    ON_A_LINE,
    PANELS,
    amplification,
    elevation_figure,
    has_storeys,
    of_which_buildings,
    plan_figure,
    profile,
    profiles_figure,
    where_words,
)
from pounding_risk.figures.simulate import simulation_figure
from pounding_risk.figures.style import in_lines
from pounding_risk.reports.drawings import draw
from pounding_risk.reports.sections.row import contact_finding, drift_finding, struck_finding
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.simulate import simulate

TWO_MASSES = scene_text(
    single("A", "44 t", "0.2 s", height="6 m"), single("B", "80 t", "0.1 s"), law="hertz", gap="1 mm"
)
HERE = {"gap": 0.05, "yield_force": 4e5, "contact_model": "viscous_elastoplastic"}


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Six motions in two polarities, one run failed."""
    return made_row(gaps=(0.0, 0.02, 0.05), failed=True)


@pytest.fixture(scope="module")
def case(results) -> RowCase:
    """The widest gap at the larger amplitude, where some touch and some do not."""
    return row_case(results, gap=0.05)


def texts(figure) -> str:
    """Everything that is written in a figure, lines joined."""
    return "\n".join(each.get_text() for each in figure.findobj(Text))


def test_the_cell_is_the_scenes_own_unless_another_is_asked_for(results, says):
    own = row_case(results)  # the scene: 20 mm and 400 kN, and of two amplitudes the larger
    assert [float(own.results[name]) for name in ("gap", "yield_force", "pga")] == [0.02, 4e5, 0.4 * 9.80665]
    other = row_case(results, gap=0.04, yield_force=np.inf, pga=0.2 * 9.80665)
    assert [float(other.results[name]) for name in ("gap", "yield_force")] == [0.05, np.inf]
    says(refusal(row_case, results, contact_model="hertz"))


def test_shares_count_complete_runs_only(results):
    first = row_case(results, gap=0.0)
    count = results["contact_point_impact_count"].sel(gap=0.0, yield_force=4e5).isel(pga=1, contact_model=0)
    for at, place in enumerate(first.points):
        mine = count.isel(contact_point=at).values
        assert place.touch.runs == 11  # of 12, one failed
        assert place.touch.contact == (mine > 0).sum() / 11
    assert np.isnan(any_of_building(first, "impact_count", 2)[0])
    assert np.isfinite(any_of_building(first, "impact_count", 2)[1:]).all()


@pytest.mark.complete
def test_two_single_masses_are_drawn_with_the_contact_of_their_interface(tmp_path, says):
    """Their one contact point is their interface; nothing is known of storeys."""
    pair = scan(parse_scene(TWO_MASSES, overrides=['records.window=["1 s", "3 s"]']), check_fraction=0.0)
    case = row_case(pair)
    (place,), (touch,) = case.points, case.touches
    assert (place.touch, place.level, place.kind) == (touch, 6.0, "floor") and touch.contact == 1.0
    assert touch.impacts == int(pair["impact_count"].squeeze())
    assert touch.force == float(pair["peak_contact_force"].squeeze())
    assert contact_finding(case).startswith("Contact between A and B: 1 of 1 motion, ")
    assert "springs or dampers" not in texts(elevation_figure(case)) and plan_figure(case).axes
    says(refusal(draw, pair, profiles=tmp_path / "storeys.png"))


def test_the_elevation_says_which_neighbours_a_damper_joins():
    overrides = ['records.window=["1 s", "3 s"]', 'interface.link_damping="0.2 MN s/m"']
    linked = row_case(scan(parse_scene(TWO_MASSES, overrides=overrides), check_fraction=0.0))
    assert "springs or dampers join A and B; they are not drawn" in texts(elevation_figure(linked))


def test_a_building_without_a_height_is_as_tall_as_its_neighbour(case):
    kiosk, vault = case.buildings[-2:]
    assert (vault.height, vault.is_rigid, kiosk.height) == (4.0, True, 4.0)
    assert f"no height is given of {vault.name}: the one drawn is nominal" in texts(elevation_figure(case))


def test_the_elevation_draws_each_contact_point_at_its_level_in_its_share(case, results):
    figure = elevation_figure(case)
    drawn = [each for each in figure.findobj(PathCollection) if each.get_array() is not None]
    seen = {
        (round(float(y), 6), round(float(share), 6))
        for each in drawn
        for (_, y), share in zip(each.get_offsets(), each.get_array(), strict=True)
    }
    count = results["contact_point_impact_count"].sel(gap=0.05, yield_force=4e5).isel(pga=1, contact_model=0)
    levels = results["contact_point_level"].values
    wanted = {
        (round(float(level), 6), round(float((count.isel(contact_point=at) > 0).mean()), 6))
        for at, level in enumerate(levels)
    }
    assert seen == wanted
    said = texts(figure)
    assert all(each.name in said for each in STREET)
    assert said.count("50 mm\n") == 5
    shares = (results["impact_count"].sel(HERE).isel(pga=1) > 0).mean(("record", "polarity")).values
    finding = contact_finding(case)
    assert finding.startswith(f"Contact at {(shares > 0).sum()} of 5 interfaces, most often between Corner and Arcade")
    assert f"{round(12 * shares.max())} of 12 motions" in finding


@pytest.mark.complete
def test_a_long_row_is_drawn_in_lines_that_share_a_building(case):
    long = _repeated(case, 4)
    figure = elevation_figure(long)
    lines = [axis for axis in figure.axes if axis.get_ylabel() == "height [m]"]
    assert len(lines) == 4  # 24 buildings, 8 on a line with one shared
    assert len(long.buildings) <= ON_A_LINE * 4
    for building in long.buildings:
        assert building.name in texts(figure)
    assert figure.get_figwidth() < 17.0


def _repeated(case: RowCase, times: int) -> RowCase:
    """The same row again and again, as one: for what is drawn of it only."""
    count = len(case.buildings)
    buildings = tuple(each._replace(name=f"{each.name} {turn}") for turn in range(times) for each in case.buildings)
    gaps = ((*case.gaps, 0.05) * times)[: count * times - 1]
    touches = ((*case.touches, case.touches[0]) * times)[: count * times - 1]
    places = tuple(
        each._replace(interface=each.interface + turn * count) for turn in range(times) for each in case.points
    )
    names = [f"{one.name} | {other.name}" for one, other in pairwise(buildings)]
    results = case.results[["record", "polarity", "pga", "gap", "yield_force", "contact_model"]]
    heights = "building", np.tile(case.results["building_height"].values, times)
    results = results.assign_coords(
        interface=names, building=[each.name for each in buildings], building_height=heights
    )
    return RowCase(results, buildings, gaps, places, touches)


def test_the_plan_colours_each_building_by_its_own_share(case, results):
    figure = plan_figure(case)
    for collection, (name, _) in zip(figure.findobj(PathCollection), PANELS, strict=True):
        values = results[name].sel(HERE).isel(pga=1).values.reshape(12, 5)
        sides = np.concatenate([values[:, :1], np.maximum(values[:, :-1], values[:, 1:]), values[:, -1:]], axis=1)
        np.testing.assert_allclose(collection.get_array(), (sides > 0).mean(axis=0), rtol=1e-12)  # sums of 12
    assert "100 %" in texts(figure)


def test_the_plan_takes_footprints_and_says_whose_is_missing(case, says):
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 12.0], [0.0, 12.0]])
    given = {each.name: square + np.array([11.0 * at, 0.0]) for at, each in enumerate(STREET)}
    figure = plan_figure(case, {**given, "Lone": square + np.array([90.0, 0.0])})
    assert "no result given" in texts(figure)  # whether or not it stands in a row
    drawn = figure.findobj(PathCollection)[0].get_paths()
    np.testing.assert_array_equal(drawn[3].vertices[:4], given["Tower"])
    del given["Tower"]
    says(refusal(plan_figure, case, given))
    says(refusal(plan_figure, case, {**given, "Tower": [[0.0, 0.0], [1.0, 1.0]]}))


def test_courts_of_footprints_stay_open_and_a_scale_and_the_north_are_drawn(case):
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    shifts = {each.name: np.array([11.0 * at, 0.0]) for at, each in enumerate(STREET)}
    given = {name: [10.0 * square + shift, 3.0 + 4.0 * square[::-1] + shift] for name, shift in shifts.items()}
    axis = plan_figure(case, given).axes[0]
    for path in axis.collections[0].get_paths():
        # Filled by the number of turns around a place: 1 within the building, 1 - 1 within the court.
        x, y = np.moveaxis(np.array(path.to_polygons()), -1, 0)
        assert (0.5 * (x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]).sum(axis=1)).tolist() == pytest.approx(
            [100.0, -16.0]
        )
    (bar,) = axis.lines
    length = np.ptp(bar.get_xdata())
    assert 5.0 <= length <= 54.0 / 4
    assert [words.get_text() for words in axis.texts[-2:]] == [f"{length:g} m", "N"]
    assert not plan_figure(case).axes[0].lines  # nominal widths have no scale


@pytest.mark.parametrize("turned", [0.0, 33.0, 90.0])
def test_names_stay_within_their_footprints_or_are_left_out(case, turned):
    """However narrow a building is, and however its street lies; the legend says where a name is missing."""
    cosine, sine = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    widths, walls = [1.0, 4.0, 6.0, 14.0, 30.0, 9.0], [0.0, 1.1, 5.2, 11.3, 25.4, 55.5]
    given = {
        each.name: (square * (wide, 13.0) + (wall, 0.0)) @ np.array([[cosine, sine], [-sine, cosine]])
        for each, wide, wall in zip(STREET, widths, walls, strict=True)
    }
    figure = plan_figure(case, given)
    figure.draw_without_rendering()
    for axis in figure.axes[:2]:
        names = [label for label in axis.texts if "\n" in label.get_text()]
        assert [label.get_visible() for label in names] == [False, *5 * [True]]
        for label, corners in zip(names[1:], list(given.values())[1:], strict=True):
            middle = axis.transData.transform(0.5 * (corners.min(axis=0) + corners.max(axis=0)))
            box, room = label.get_window_extent(), np.ptp(axis.transData.transform(corners), axis=0)
            np.testing.assert_allclose(0.5 * (box.min + box.max), middle, atol=2.0)  # pixels
            assert (box.size <= room).all()
    assert figure.legends[0].get_title().get_text().startswith("no name")


def test_profiles_are_percentiles_over_the_motions_that_touch(case, results):
    here = results.sel(HERE).isel(pga=1)
    touching = (here["impact_count"].isel(interface=0) > 0).values.ravel()  # the first building has one interface
    drift = here["storey_drift"].isel(building=0).values.reshape(12, -1)[touching, :5]
    found = profile(case, 0, "storey_drift")
    assert found.motions == touching.sum() < 12
    # In % of a storey of 3.2 m; only the order of two products differs.
    np.testing.assert_allclose(found.struck, 100 * np.percentile(drift, (16, 50, 84), axis=0) / 3.2, rtol=1e-12)
    free = here["storey_drift_free"].isel(building=0).values.reshape(12, -1)[touching, :5]
    np.testing.assert_allclose(found.free, 100 * np.percentile(free, (16, 50, 84), axis=0) / 3.2, rtol=1e-12)
    ratio = np.median(drift.max(axis=1) / free.max(axis=1))
    assert amplification(case, 0) == pytest.approx(ratio, rel=1e-12)


def test_profiles_tell_ends_from_interiors_and_name_what_is_not_there(case, says):
    said = texts(profiles_figure(case, ["Corner", "Tower"]))
    assert "Corner (end)" in said
    assert "Tower (interior)" in said
    assert "times at the row's ends" in drift_finding(case)
    says(refusal(profiles_figure, case, ["Turm"]))
    says(refusal(profiles_figure, case, ["Vault"]))


def test_profiles_of_some_buildings_say_of_which(case, monkeypatch):
    assert not of_which_buildings(case)
    monkeypatch.setattr("pounding_risk.figures.row.MOST_BUILDINGS", 1)
    words = (
        f"1 of {sum(map(has_storeys, case.buildings))} buildings with storeys: those whose drift contact raises most"
    )
    assert words in " ".join(texts(profiles_figure(case)).split())
    assert "with storeys" not in texts(profiles_figure(case, ["Corner"]))


def test_a_row_that_nothing_touches_says_so(results):
    still = results.copy(deep=True)
    for name in ("impact_count", "yield_exceedance", "contact_point_impact_count", "contact_point_yield_exceedance"):
        still[name][:] = 0
    case = row_case(still, gap=0.05)
    assert contact_finding(case) == "No contact in 12 motions"
    assert struck_finding(case) == "No building touches a neighbour in 12 motions"
    assert profile(case, 0, "storey_drift").motions == 0
    assert np.isnan(amplification(case, 0))
    assert "no contact" in texts(profiles_figure(case, ["Corner"]))


def test_a_cell_without_a_complete_run_says_so():
    case = row_case(made_row(records=1, failed=True).isel(polarity=[0]), gap=0.0)
    assert contact_finding(case) == "No run of 1 motion is complete"
    for figure in (elevation_figure(case), plan_figure(case), profiles_figure(case, ["Corner"])):
        assert figure.axes


def test_the_plan_of_several_rows_is_headed_by_all_their_gaps(results):
    narrow, wide = row_case(results, gap=0.02), row_case(results, gap=0.05)
    assert "2 rows: gaps 20 to 50 mm" in texts(plan_figure([narrow, wide])).replace("\n", " ")


def test_the_columns_own_yield_force_stands_beside_that_of_floors(case):
    results = case.results
    forces, is_column = results["contact_point_yield_force"], results["contact_point_kind"].values == "column"
    columns = f"{forces.values[is_column].min() / 1e3:.0f} kN"
    assert f"(of columns {columns})" in texts(elevation_figure(case)).replace("\n", " ")
    of_columns = forces.copy(data=np.where(is_column, forces.values, np.inf))
    changed = case._replace(results=results.assign_coords(contact_point_yield_force=of_columns))
    assert f"F_E = {columns} of columns, floors without yielding" in where_words(changed)


def test_a_line_that_breaks_leaves_no_single_word():
    text = " ".join(["word"] * 13)  # 64 letters
    assert [len(line.split()) for line in in_lines(text, 60).splitlines()] == [7, 6]
    assert in_lines("a gap of 60 mm, as much as 16 %", 14).splitlines() == ["a gap of", "60 mm, as", "much as 16 %"]
    assert in_lines("short", 60) == "short"
    assert in_lines("", 60) == ""


@pytest.mark.parametrize("draws", sweep([elevation_figure, plan_figure, profiles_figure], plan_figure))
@pytest.mark.complete
def test_the_legend_stands_above_the_caption(case, draws):
    """The layout gives both one place; here no line of the caption reaches into the legend."""
    figure = draws(case, note="a note that stands on a line of its own")
    figure.draw_without_rendering()
    caption = next(words for words in figure.texts if words.get_text() == figure.get_supxlabel())
    lines = caption.get_text().strip("\n").count("\n") + 1
    assert lines >= 2
    (legend,) = figure.legends
    top = caption.get_window_extent().y0 + lines * caption.get_fontsize() * figure.dpi / 72.0
    assert legend.get_window_extent().y0 >= top
    panels = min(axis.get_tightbbox().y0 for axis in figure.axes)
    assert legend.get_window_extent().y1 <= panels + 1.0


@pytest.mark.complete
def test_a_city_is_coloured_without_names(case):
    """More buildings than can be read: each in its own share still, and nothing is written on them."""
    rows = [case] * (LABELLED // len(case.buildings) + 1)
    figure = plan_figure(rows)
    for axis in figure.axes[:2]:
        (drawn,) = (each for each in axis.collections if isinstance(each, PathCollection))
        assert len(drawn.get_paths()) == len(rows) * len(case.buildings) > LABELLED
        assert [each.get_text() for each in axis.texts] == []
    shares = figure.axes[0].collections[0].get_array().filled(np.nan)
    few = plan_figure(case).axes[0].collections[0].get_array().filled(np.nan)
    assert np.array_equal(shares, np.tile(few, len(rows)), equal_nan=True)


def test_the_force_at_a_roof_leaves_the_peak_of_that_roof_legible():
    """Of a low building whose roof strikes the columns of a tall one at its left, in a row that fills the page."""
    tall, low = {"floor_masses": "200 t", "storeys": 5, "period": "0.7 s"}, {"floor_masses": "100 t", "storeys": 3}
    row = [
        {"name": name, **(low | {"period": "0.2 s"} if at % 2 else tall), "storey_heights": f"{3.0 + 0.7 * (at % 2)} m"}
        for at, name in enumerate("ABCDE")
    ]
    figure = simulation_figure(simulate(parse_scene(scene_text(*row, stiffness="8e10 N/m^1.5"))))
    figure.canvas.draw()
    written = [text for text in figure.axes[-1].texts if text.get_text()]
    peaks, forces = ([text for text in written if text.get_text().endswith(end)] for end in (" mm", "×"))
    assert len(peaks) == 5 and len(forces) >= 4
    boxes = [[text.get_window_extent() for text in kind] for kind in (peaks, forces)]
    assert not [peak for peak in boxes[0] for force in boxes[1] if peak.overlaps(force)]
