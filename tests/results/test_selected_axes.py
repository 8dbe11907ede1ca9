"""A dataset of which one value along an axis was selected is read as one in which that axis has one value.

xarray itself is the oracle: ``isel(gap=[0])`` keeps the axis that ``isel(gap=0)`` takes away.
"""

from __future__ import annotations

import pytest
import xarray as xr
from scenes import BOTH, scene_text, single

from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.reports import report
from pounding_risk.reports.drawings import draw
from pounding_risk.reports.explorer import view
from pounding_risk.results.selected_axes import with_axes
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
AXES = ("record", "polarity", "contact_model", "gap", "yield_force")


@pytest.fixture(scope="module", params=[PAIR, ROW], ids=["pair", "row"])
def dataset(request) -> xr.Dataset:
    return scan(parse_scene(request.param, "scene.toml"), check_fraction=0.2)


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_selected_away_comes_back(dataset, axis):
    for place in (0, 1):
        xr.testing.assert_identical(with_axes(dataset.isel({axis: place})), dataset.isel({axis: [place]}))
    assert with_axes(dataset) is dataset


def test_several_axes_come_back_in_their_order(dataset):
    chosen = dict.fromkeys(AXES, 1)
    whole = dataset.isel({axis: [place] for axis, place in chosen.items()})
    xr.testing.assert_identical(with_axes(dataset.isel(chosen)), whole)


@pytest.mark.parametrize("axis", AXES)
def test_readers_say_the_same_of_both(dataset, axis, tmp_path):
    one, whole = dataset.isel({axis: 1}), dataset.isel({axis: [1]})
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


def test_a_squeezed_dataset_is_read_as_the_whole(dataset, tmp_path):
    """Records, gaps and places of one value lose their axes; those of places come back too."""
    part = dataset.isel(record=[0], gap=[1], contact_model=[1], yield_force=[0])
    flat = part.squeeze()
    assert {"record", "gap", "storey"}.isdisjoint(flat.dims)
    assert ("interface" in flat.dims) == (dataset.sizes["interface"] > 1)
    xr.testing.assert_identical(with_axes(flat), part)
    assert repr(assess(flat).as_dict()) == repr(assess(part).as_dict())
    pages = [report(each, tmp_path / "page.html").read_text() for each in (flat, part)]
    assert pages[0] == pages[1]
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


def test_what_cannot_come_back_is_named(dataset):
    with pytest.raises(PoundingError, match=r"has lost its gap: select with a list"):
        assess(dataset.isel(gap=0, drop=True))
    with pytest.raises(PoundingError, match="has one building left"):
        assess(dataset.isel(building=0))
    if dataset.sizes["interface"] > 1:
        with pytest.raises(PoundingError, match="3 buildings and 1 of the 2 interfaces"):
            assess(dataset.isel(interface=1))
