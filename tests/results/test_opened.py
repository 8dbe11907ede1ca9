"""Results opened: the axes that a selection took away, the version of the dataset, and the scene's own case.

xarray itself is the oracle of axes: ``isel(gap=[0])`` keeps the axis that ``isel(gap=0)`` takes away.
"""

import json

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from matplotlib.figure import Figure
from scenes import BOTH, scene_text, single
from sentences import refusal

from pounding_risk.assessment.along import assess_along
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.ensemble.scan import scan
from pounding_risk.reports import report
from pounding_risk.reports.drawings import draw
from pounding_risk.reports.explorer import view
from pounding_risk.results.attributes import DATASET_VERSION, VERSION
from pounding_risk.results.files import open_results, open_scan, save
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import with_axes
from pounding_risk.results.summary import summary
from pounding_risk.scene.reader import parse_scene

PAIR = scene_text(
    single("A", "44 t", "0.2 s"),
    single("B", "80 t", "0.1 s"),
    law="viscous_elastoplastic",
    gap="2 mm",
    records={"names": ["RSN6-180", "RSN6-270"], "window": ["0 s", "4 s"], "polarity": BOTH},
    grid={
        "gap": ["2 mm", "8 mm"],
        "yield_force": ["50 kN", "inf"],
        "contact_model": ["viscous_elastoplastic", "hertz"],
        "pga": ["0.3 g", "0.5 g"],
    },
)
ROW = PAIR.replace(
    "[[interface]]", '[[building]]\nname = "C"\nmass = "90 t"\nperiod = "0.3 s"\n[[interface]]'
)  # one interface's table stands for both
AXES = ("gap", "record", "polarity", "contact_model", "yield_force")


def drawn(figure: Figure) -> str:
    """What a figure shows, in place of its picture, which takes four times longer: titles, letters and lines."""
    parts = [(each.get_title(), each.get_xlabel(), each.get_ylabel()) for each in figure.axes]
    parts += [(str(each.get_xydata()), each.get_color()) for axes in figure.axes for each in axes.lines]
    return repr(parts + [[text.get_text() for text in axes.texts] for axes in figure.axes]) + words_of(figure)


@pytest.fixture(autouse=True)
def neither_scripts_nor_pictures(monkeypatch) -> None:
    """A word for Plotly's 4 MB, and what figures show."""
    monkeypatch.setattr("plotly.offline.get_plotlyjs", lambda: "Plotly")
    for place in ("reports.document", "figures.style"):
        monkeypatch.setattr(f"pounding_risk.{place}.svg_text", drawn)


@pytest.fixture(scope="module", params=[PAIR, ROW], ids=["pair", "row"])
def dataset(request) -> xr.Dataset:
    return scan(parse_scene(request.param, "scene.toml"), check_fraction=0.2)


def test_axes_selected_away_come_back_in_their_order(dataset):
    for axis in AXES:
        xr.testing.assert_identical(with_axes(dataset.isel({axis: 1})), dataset.isel({axis: [1]}))
    assert with_axes(dataset) is dataset
    chosen = dict.fromkeys(AXES, 1)
    whole = dataset.isel({axis: [place] for axis, place in chosen.items()})
    xr.testing.assert_identical(with_axes(dataset.isel(chosen)), whole)


@pytest.mark.complete
def test_readers_say_the_same_of_both(dataset, tmp_path):
    """All of them put axes back alike, so that one axis tells of every reader."""
    one, whole = dataset.isel(gap=1), dataset.isel(gap=[1])
    # As text, in which a NaN equals a NaN.
    assert repr(assess(one).as_dict()) == repr(assess(whole).as_dict())
    assert repr(summary(one)) == repr(summary(whole))
    pages = [[make(each, tmp_path / "page.html").read_text() for make in (view, report)] for each in (one, whole)]
    assert pages[0] == pages[1]
    if dataset.sizes["building"] == 2:
        assert repr(code_table(one)) == repr(code_table(whole))
    else:
        pictures = [draw(each, elevation=tmp_path / "row.svg")[0].read_bytes() for each in (one, whole)]
        assert pictures[0] == pictures[1]


def test_a_squeezed_dataset_is_read_as_the_whole(dataset):
    """Records, gaps and places of one value lose their axes; those of places come back too."""
    part = dataset.isel(record=[0], gap=[1], contact_model=[1], yield_force=[0])
    flat = part.squeeze()
    assert {"record", "gap", "storey"}.isdisjoint(flat.dims)
    assert ("interface" in flat.dims) == (dataset.sizes["interface"] > 1)
    xr.testing.assert_identical(with_axes(flat), part)
    assert repr(assess(flat).as_dict()) == repr(assess(part).as_dict())
    assert repr(summary(flat)) == repr(summary(part))
    if dataset.sizes["interface"] == 1:
        bare = dataset.squeeze("interface", drop=True)
        assert repr(assess(bare).as_dict()) == repr(assess(dataset).as_dict())


def test_neighbours_selected_from_a_row_are_assessed_as_in_it(dataset):
    """With the runs of the whole row; the contact points are those between them."""
    whole = assess(dataset)
    for at in range(dataset.sizes["interface"]):
        for interface in (at, [at]):
            one = dataset.isel(interface=interface, building=slice(at, at + 2))
            assert repr(assess(one).interfaces) == repr(whole.interfaces[at : at + 1])
            assert with_axes(one)["contact_point_interface"].values.tolist() == [0]


def test_one_amplitude_of_several_is_assessed(dataset):
    assert assess(dataset.isel(pga=0)).interfaces[0].closing == assess(dataset, pga="0.3 g").interfaces[0].closing


def test_what_cannot_come_back_is_named(dataset, says):
    lost = [dataset.isel(gap=0, drop=True), dataset.isel(building=0)]
    lost += [dataset.isel(interface=1)] if dataset.sizes["interface"] > 1 else []
    says([refusal(assess, one) for one in lost])


def test_a_dataset_of_another_version_is_refused(dataset, tmp_path, says):
    """In memory and on disk, as netCDF and lazily."""
    versions = [dataset.assign_attrs({VERSION: version}) for version in (0, 1, 3, "two")]
    told = [refusal(open_scan, other) for other in versions]
    says(told)
    for read in (assess, assess_along, code_table, summary, lambda other: other.pounding.figure()):
        assert refusal(read, versions[1]) == told[1]
    for write, target in ((report, tmp_path / "other.html"), (view, tmp_path / "page.html")):
        assert refusal(write, versions[1], target) == told[1]
    file = save(versions[1], tmp_path / "other.nc")
    for read in (open_results, assess, summary, lambda path: open_results(path, lazy=True)):
        assert refusal(read, file) == told[1].replace("the dataset", str(file))


def test_datasets_of_other_commands_have_no_version(tmp_path):
    made = xr.Dataset({"median_ratio": ("building", [1.2, 0.8])})
    xr.testing.assert_identical(open_results(save(made, tmp_path / "damage.nc")), made)


def test_results_have_their_scene_and_version(dataset, tmp_path):
    opened = open_scan(save(dataset, tmp_path / "results.nc"))
    assert (opened.name, opened.dataset.attrs[VERSION]) == (str(tmp_path / "results.nc"), DATASET_VERSION)
    assert [table["name"] for table in opened.scene["building"]] == dataset["building"].values.tolist()


SCENE = """
[[interface]]
gap = "{gap}"
contact_model = "jankowski"
yield_force = "{force}"
[records]
{pga}
"""


def grid(gap: str, force: str, pga: str) -> xr.Dataset:
    axes = {
        "contact_model": ["hertz", "jankowski"],
        "gap": [0.0, 0.01, 0.02],
        "yield_force": [2e5, 4.5e5, np.inf],
        "pga": [1.0, 2.0, 3.0],
    }
    return xr.Dataset(coords=axes, attrs={"scene_resolved": SCENE.format(gap=gap, force=force, pga=pga)})


@pytest.mark.parametrize(
    ("gap", "force", "pga", "places"),
    [
        ("0.01 m", "450000.0 N", 'pga = "2.0 m/s^2"', (1, 1, 1)),
        ("20 mm", "inf", "", (2, 2, 2)),  # no amplitude of its own: the largest
        ("19 mm", "460 kN", 'pga = "1.5 m/s^2"', (2, 1, 2)),  # not on the grid: the nearest gap and force
    ],
)
def test_the_scenes_own_case_is_found(gap, force, pga, places):
    place = Results(grid(gap, force, pga)).scene_case
    assert (place["gap"], place["yield_force"], place["pga"]) == places
    assert place["contact_model"] == 1


def test_an_amplitude_that_the_grid_has_not_is_none():
    assert Results(grid("0 mm", "inf", 'pga = "2.0 m/s^2"')).scene_amplitude == 2.0
    assert Results(grid("0 mm", "inf", 'pga = "2.5 m/s^2"')).scene_amplitude is None
    assert Results(grid("0 mm", "inf", "")).scene_amplitude is None


@pytest.mark.parametrize(
    ("events", "words"),
    [
        (["E", "E", "E", "F", "F", "F"], "6 recordings are of 2 earthquakes, 3 of them of E: bounds take"),
        (["E", "E", "E", "", "", ""], "3 recordings are of 1 earthquake, 3 of them of E: bounds take"),
        (["E", "E", "F", "F", "G", "G"], ""),  # as in the far-field set of FEMA P-695: bounds hold (docs/theory/gap.md)
        ([""] * 6, ""),  # not known
    ],
)
def test_recordings_of_one_earthquake_are_noted(events, words):
    labels = {"record": [f"R{index}" for index in range(6)], "record_event": ("record", events)}
    notes = Results(xr.Dataset(coords=labels)).event_notes
    assert len(notes) == bool(words) and all(words in note and "too narrow" in note for note in notes)


def test_components_of_one_recording_are_no_recordings_of_one_earthquake():
    facts = [{"name": f"R{index}", "event": "E", "date": "2011-03-14", "station": "S"} for index in range(6)]
    labels = {"record": [fact["name"] for fact in facts], "record_event": ("record", ["E"] * 6)}
    assert Results(xr.Dataset(coords=labels, attrs={"records": json.dumps(facts)})).event_notes == ()
