"""Setbacks from a property line: counted displacements of one building, its bounds, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scenes import BOTH, scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.options import NO_LOWER, NO_UPPER
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions import intensity as measures
from pounding_risk.motions.read import read_motion
from pounding_risk.questions.setback import sheet
from pounding_risk.scene.reader import parse_scene

RECORDS = ["RSN6-180", "CCC-HN1", "NAPA-HNE"]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Three records in both polarities; no gap so wide is ever closed, so that nothing is simulated."""
    sides = (single(name, "10 t", f"{period} s", damping=0.05) for name, period in (("left", 0.5), ("right", 0.8)))
    records = {"names": RECORDS, "polarity": BOTH}
    return scan(parse_scene(scene_text(*sides, law="linear", gap="9 m", records=records)), check_fraction=0.0)


def peaks_of(period: float) -> np.ndarray:
    """Spectral displacement of each record, from the motions alone."""
    motions = [read_motion(name) for name in RECORDS]
    return np.array(
        [measures.response_spectra([one.acceleration], one.dt, [period]).displacement[0, 0] for one in motions]
    )


def test_a_setback_is_the_buildings_own_peak_displacement(results):
    """Every motion stays within the setback of all: the largest spectral displacement, and polarity changes nothing."""
    left, right = pr.setbacks(results, percentile="99 %")
    for one, period in ((left, 0.5), (right, 0.8)):
        largest = peaks_of(period).max()
        assert one.motions == 6 and one.independent == pytest.approx(3.0)
        # Both find the maximum between samples, each in its own way: 1e-9 apart, and the percentile may interpolate.
        assert one.required[-1].high == pytest.approx(largest, rel=1e-7)
        assert one.distance <= largest * (1.0 + 1e-7) and not one.required[-1].bounded
    assert [one.building for one in (left, right)] == ["left", "right"]


def test_a_rigid_building_needs_no_setback(results):
    still = results.copy()
    still["peak_displacement_free"] = results["peak_displacement_free"] * xr.DataArray([0.0, 1.0], dims="building")
    assert [one.distance > 0.0 for one in pr.setbacks(still)] == [False, True]


def test_marks_are_explained_in_a_paragraph_as_a_list_has_marks_of_its_own(results):
    blocks = sheet(pr.setbacks(results))
    assert [block["kind"] for block in blocks] == ["table", "paragraph", "list"]
    assert blocks[1]["text"].startswith(NO_LOWER) and f" {NO_UPPER} " in blocks[1]["text"]
    assert not any(item.startswith((NO_LOWER, NO_UPPER)) for item in blocks[2]["items"])


def test_a_dataset_that_is_none_is_refused(results, says):
    says(
        refusal(pr.setbacks, results.drop_vars("peak_displacement_free")),
        refusal(pr.setbacks, results.assign(peak_displacement_free=results["peak_displacement_free"] * np.nan)),
    )
