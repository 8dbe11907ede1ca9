"""The scene's own case in a grid: where pages and verdicts begin."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from pounding_risk.results.own_case import own_amplitude, own_case

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
    place = own_case(grid(gap, force, pga))
    assert (place["gap"], place["yield_force"], place["pga"]) == places
    assert place["contact_model"] == 1


def test_an_amplitude_that_the_grid_has_not_is_none():
    assert own_amplitude(grid("0 mm", "inf", 'pga = "2.0 m/s^2"')) == 2.0
    assert own_amplitude(grid("0 mm", "inf", 'pga = "2.5 m/s^2"')) is None
    assert own_amplitude(grid("0 mm", "inf", "")) is None
