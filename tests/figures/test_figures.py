"""Figures from made-up results: what they show comes from the data alone, and needs no solver."""

import json
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from sentences import refusal

from pounding_risk import figures
from pounding_risk.figures import style
from pounding_risk.figures.simulate import parting


def made_impact(mass: float, speed: float, force: list[float]) -> SimpleNamespace:
    values = np.array(force)
    return SimpleNamespace(
        law="viscous_elastoplastic",
        mass=mass,
        approach_speed=speed,
        time=np.linspace(0.0, 4e-3, len(force)),
        penetration=np.linspace(0.0, 1e-3, len(force)),
        force=values,
        peak_force=values.max(),
        restitution_asked=0.5,
        restitution=0.75,
    )


def made_run(law: str, scale: float = 1.0, first_yield: float = np.nan, parts_at: float = 1.0) -> xr.Dataset:
    """Two seconds in which the displacement is a sine, scaled after ``parts_at``."""
    time = np.linspace(0.0, 2.0, 201)
    moved = -4e-3 * np.sin(2.0 * np.pi * time) * np.where(time > parts_at, 2.0 * scale, 1.0)
    told = {"impact_count": 2, "peak_contact_force": 3e5, "peak_relative_displacement": np.abs(moved).max()}
    told |= {"first_yield_time": first_yield}
    force = np.inf if np.isnan(first_yield) else 3e5
    named = {name: ("time", moved**2) for name in ("energy_ground", "energy_damping", "energy_contact", "energy_held")}
    return xr.Dataset(
        {
            "displacement": (("time", "building", "storey"), np.zeros((201, 2, 1))),
            "relative_displacement": (("time", "contact_point"), moved[:, None]),
            "contact_force": (("time", "contact_point"), np.maximum(moved, 0.0)[:, None] * 1e8),
            "ground_acceleration": ("time", moved * 1e3),
            "contact_start": ("contact", [0.5, 1.5]),
            "contact_end": ("contact", [0.6, 1.6]),
            **named,
            **{name: ("interface", [value]) for name, value in told.items()},
        },
        coords={
            "time": time,
            "interface": ["one | other"],
            "interface_gap": ("interface", [0.005]),
            "contact_point": ["one 1 | other 1"],
            "contact_point_interface": ("contact_point", [0]),
            "contact_point_yield_force": ("contact_point", [force]),
        },
        attrs={
            "title": "A pair",
            "record": "R1",
            "polarity": "as recorded",
            "contact_model": law,
            "gap": 0.005,
            "yield_force": force,
            "pga": 4.903325,
            "status": "complete",
        },
    )


def made_scan(gaps: int = 4, forces: tuple[float, ...] = (2e5, 4e5, np.inf)) -> xr.Dataset:
    """Two records, two polarities; yielding doubles the peak in the first record and halves it in the second."""
    shape = (2, 2, 1, gaps, len(forces))
    peak = np.full(shape, 5e-3)
    peak[0, ..., 0] = 10e-3
    peak[1, ..., 0] = 2.5e-3
    count = np.ones(shape, dtype=int)
    count[:, :, :, -1] = 0
    exceeded = np.zeros(shape, dtype=int)
    exceeded[..., 0] = 1
    dims = ("record", "polarity", "contact_model", "gap", "yield_force")
    return xr.Dataset(
        {
            "peak_relative_displacement": (dims, peak),
            "impact_count": (dims, count),
            "yield_exceedance": (dims, exceeded),
            "first_yield_time": (dims, np.where(exceeded, 2.4, np.nan)),
        },
        coords={
            "record": ["R1", "R2"],
            "polarity": ["as recorded", "reversed"],
            "contact_model": ["viscous_elastoplastic"],
            "gap": np.arange(gaps) * 1e-3,
            "yield_force": list(forces),
        },
        attrs={
            "title": "A grid",
            "records": json.dumps([{"name": "R1", "event": "Here, There", "date": "1999-01-01"}]),
        },
    )


def drawn() -> dict[str, object]:
    runs = [made_run("jankowski"), made_run("viscous_elastoplastic", 0.5, 1.0)]
    impacts = [made_impact(570.0, 2.5, [0, 3e5, 3e5, 3e5, 0]), made_impact(290.0, 2.5, [0, 3e5, 3e5, 0, 0])]
    impacts.append(made_impact(570.0, 0.5, [0, 1e5, 0, 0, 0]))
    return {
        "impact": figures.impact_figure(impacts, note="assumed: all"),
        "simulation": figures.simulation_figure(runs[1]),
        "comparison": figures.comparison_figure(runs, note="assumed: all"),
        "scan": figures.scan_figure(made_scan()),
        "lines over gap": figures.scan_figure(made_scan(forces=(np.inf,))),
        "lines over force": figures.scan_figure(made_scan(gaps=1)),
        "ratio": figures.ratio_figure(made_scan()),
    }


@pytest.fixture(scope="module")
def gallery():
    return drawn()


TITLES = {
    "impact": "The contact force reaches 300 kN, in isolated impacts",
    "simulation": "2 contacts, the largest force 300 kN",
    "comparison": "Identical until 1.00 s; yielding lowers the peak from 8.00 to 4.00 mm",
    "scan": "The peak relative displacement reaches 10 mm; R1 as recorded, gap 0 mm, $F_E$ = 200 kN",
    "lines over gap": "The peak relative displacement reaches 10 mm; R1 as recorded, gap 0 mm, without yielding",
    "lines over force": "The peak relative displacement reaches 10 mm; R1 as recorded, gap 0 mm, $F_E$ = 200 kN",
    "ratio": "Yielding multiplies the peak relative displacement by 0.5 to 2",
}


@pytest.mark.parametrize("name", TITLES)
def test_titles_say_what_is_drawn_and_axes_have_units(gallery, name):
    assert words_of(gallery[name]).splitlines()[0] == TITLES[name]
    for axes in gallery[name].axes:
        told = [*axes.get_shared_x_axes().get_siblings(axes), *axes.get_shared_y_axes().get_siblings(axes)]
        assert any("[" in each.get_ylabel() for each in told)
        # A scale of colours has one axis, and shared axes are labelled at the edge of the figure.
        assert any("[" in each.get_xlabel() for each in told) or axes.get_label() == "<colorbar>"


@pytest.mark.parametrize("name", TITLES)
def test_nothing_written_leaves_the_page(gallery, name):
    figure = gallery[name]
    figure.canvas.draw()
    texts = [text for text in figure.findobj(lambda artist: hasattr(artist, "get_text")) if text.get_text().strip()]
    page = figure.bbox
    for text in texts:
        if text.get_visible():
            box = text.get_window_extent()
            # Ticks beyond an axis' limits are made but not drawn.
            inside = page.x0 - 1 <= box.x0 and box.x1 <= page.x1 + 1 and page.y0 - 1 <= box.y0 and box.y1 <= page.y1 + 1
            assert inside or text.axes is None or not text.axes.bbox.padded(40).overlaps(box), text.get_text()


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_files_are_the_same_for_the_same_data(gallery, suffix, tmp_path):
    first = figures.write(gallery["lines over gap"], tmp_path / f"a{suffix}").read_bytes()
    assert figures.write(gallery["lines over gap"], tmp_path / f"b{suffix}").read_bytes() == first
    assert b"CreationDate" not in first and b"Matplotlib" not in first


@pytest.mark.complete
def test_the_same_data_drawn_anew_is_the_same_file(gallery, tmp_path):
    for name, figure in drawn().items():
        once, again = (figures.write(each, tmp_path / f"{name}.svg").read_bytes() for each in (gallery[name], figure))
        assert once == again and b"<dc:date>" not in once and b"Matplotlib" not in once


def test_parting_is_found_from_the_histories():
    one = made_run("jankowski")
    assert parting(one, made_run("viscous_elastoplastic", 0.5, parts_at=1.2)) == pytest.approx(1.0)
    assert np.isnan(parting(one, one))
    assert figures.comparison_figure([one, one]).get_suptitle().startswith("Identical throughout: peak 8.00 mm")


def test_another_law_is_not_called_yielding():
    text = figures.comparison_figure([made_run("jankowski"), made_run("hertz", 1.5)]).get_suptitle()
    assert text.startswith("Identical until 1.00 s; hertz raises the peak from 8.00 to 12.00 mm")


def test_without_a_case_to_compare_with(says):
    says([refusal(figures.ratio_figure, made_scan(forces=forces)) for forces in ((2e5, 4e5), (np.inf,))])


def test_a_grid_without_a_complete_run_is_drawn_and_said_so():
    failed = made_scan()
    failed["peak_relative_displacement"] = failed["peak_relative_displacement"] * np.nan
    failed["impact_count"] = xr.full_like(failed["impact_count"], -1)
    assert words_of(figures.scan_figure(failed)) == "No run is complete: no peak is known\nA grid, motions as recorded"
    assert figures.ratio_figure(failed).get_suptitle() == "No run is complete: no change by yielding is known"


def test_every_line_has_a_look_of_its_own():
    """Six records in two polarities are twelve lines, of which colours and dashes alone made six."""
    one = made_scan(forces=(np.inf,)).isel(record=[0, 1, 0, 1, 0, 1]).assign_coords(record=list("ABCDEF"))
    lines = figures.scan_figure(one).axes[0].get_lines()
    assert len({(line.get_color(), line.get_linestyle(), line.get_marker()) for line in lines}) == len(lines) == 12


def test_maps_name_the_earthquake_where_it_is_known(gallery):
    headings = [axes.get_title() for axes in gallery["scan"].axes if axes.get_title()]
    assert headings == ["R1\nHere 1999", "R2"]


def test_a_grid_in_any_order_is_drawn_in_rising_order(gallery):
    turned = made_scan().isel(gap=slice(None, None, -1), yield_force=[1, 2, 0])
    for name, draw in (("scan", figures.scan_figure), ("ratio", figures.ratio_figure)):
        for axes, expected in zip(draw(turned).axes[:4], gallery[name].axes, strict=False):
            np.testing.assert_array_equal(axes.collections[0].get_array(), expected.collections[0].get_array())
    ticks = [text.get_text() for text in figures.scan_figure(turned).axes[0].get_yticklabels()]
    assert ticks == ["200", "400", "∞"]


def test_the_law_shown_is_named_where_there_are_several():
    several = xr.concat([made_scan(), made_scan().assign_coords(contact_model=["jankowski"])], "contact_model")
    told = words_of(figures.scan_figure(several)).splitlines()[1]
    assert told.startswith("A grid, jankowski, motions as recorded; ")
    strong = xr.concat([made_scan().assign_coords(pga=value) for value in (1.961330, 4.903325)], "pga")
    assert words_of(figures.ratio_figure(strong)).splitlines()[1].startswith("A grid, motions at PGA 0.5 g; ")


@pytest.mark.parametrize("forces", [(2e5, 4e5, np.inf), (np.inf,)])
def test_many_records_are_put_together(forces):
    """Forty-four records were a strip of 44 panels: above six, the percentiles of all motions stand for them."""
    one = made_scan(forces=forces)
    names = [f"R{place}" for place in range(44)]
    many = one.isel(record=np.arange(44) % 2).assign_coords(record=names)
    shares = xr.DataArray(np.linspace(0.5, 1.5, 44), dims="record", coords={"record": names})
    many["peak_relative_displacement"] = many["peak_relative_displacement"] * shares
    figure = figures.scan_figure(many)
    assert figure.get_size_inches()[0] <= 10.0
    if len(forces) > 1:
        maps = [each for each in figure.axes if each.collections and "displacement [mm]" not in each.get_ylabel()]
        median = np.asarray(maps[1].collections[0].get_array())
        expected = np.median(many["peak_relative_displacement"].values * 1e3, axis=(0, 1))[0].T
        np.testing.assert_allclose(median, expected, rtol=1e-12)  # rounding of the quantile's interpolation
        heads = [axes.get_title().split("\n")[0] for axes in maps[:3]]
        assert heads == ["16th percentile", "median", "84th percentile"]


def test_a_figure_is_a_function_of_a_module_of_its_folder():
    """Every module but the shared style makes a figure, and every figure is a name of the package."""
    names, found = set(dir(figures)), []
    for file in Path(figures.__file__).parent.glob("[!_]*.py"):
        module = import_module(f"{figures.__name__}.{file.stem}")
        values = {name: value for name, value in vars(module).items() if name.endswith("_figure") and name[0] != "_"}
        own = [name for name, value in values.items() if value.__module__ == module.__name__]
        assert set(own) <= names and bool(own) is (file.stem != "style"), file.stem
        found += own
    assert len(found) == len(set(found))
    with pytest.raises(AttributeError, match="no_figure"):
        _ = figures.no_figure


@pytest.mark.parametrize("embedded", [False, True])
def test_panels_stand_at_round_places(tmp_path, embedded):
    """The solver of the layout leaves a rounding error that differs from one call to the next."""
    figure, axes = style.blank(2, 1, (6.0, 4.0))
    axes[0, 0].plot([0.0, 1.0], [0.0, 1.0 / 3.0])
    axes[1, 0].set_ylabel("a label of\ntwo lines")
    style.title(figure, "a headline", "a caption")
    write = figures.write if not embedded else lambda one, _: style.svg_text(one)
    write(figure, tmp_path / "figure.svg")
    for axis in figure.axes:
        ends = axis.get_position(original=True).extents
        assert np.array_equal(ends, np.round(ends, 6))
