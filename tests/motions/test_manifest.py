"""A manifest comes back as it was, and says what is not as it was."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from sentences import refusal

from pounding_risk.motions import catalogue, manifest
from pounding_risk.motions.manifest import check_manifest, read_manifest, write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.scaling import by_factor


@pytest.fixture(scope="module")
def motions() -> list[Motion]:
    own = Motion("own, with a comma", np.array([0.1, -1.0 / 3.0, 0.2]), 0.005, {})
    return [read_motion("RSN6-180", pga="0.5 g"), read_motion("CCC-HNZ"), own, own.reversed()]


def test_rows_come_back(motions, tmp_path):
    """Every number with every digit; what is unknown is None again."""
    path = write_manifest(motions, tmp_path / "m.csv")
    check_manifest(path, motions)
    rows = read_manifest(path)
    assert rows == manifest.manifest(motions)
    assert path.read_text(encoding="utf-8").count("\n") == 5  # a header and four records
    first, raw, own, _ = rows
    assert first["sha256"] == sha256(Path(catalogue.path("RSN6-180")).read_bytes()).hexdigest()
    assert (first["magnitude"], first["npts"], first["dt [s]"]) == (6.95, 5372, 0.01)
    assert first["PGA [m/s2]"] == pytest.approx(0.5 * 9.80665, rel=1e-12) and first["azimuth [deg]"] == 180.0
    assert first["processing"].split(" | ") == list(motions[0].processing)
    assert raw["state"] == "raw" and raw["azimuth [deg]"] is None
    assert own["event"] is None and own["duration [s]"] == 0.01 and own["PGA [m/s2]"] == 1.0 / 3.0


def test_every_difference_is_told(motions, tmp_path, says):
    path = write_manifest(motions, tmp_path / "m.csv")
    changed = replace(motions[1], record={**motions[1].record, "sha256": "f" * 64})
    stronger = by_factor(motions[2], 2.0)
    says(refusal(check_manifest, path, [changed, stronger, Motion("new", np.ones(3), 0.01, {})]))


def test_a_damaged_manifest_is_refused(motions, tmp_path, says):
    path = write_manifest(motions, tmp_path / "m.csv")
    text = path.read_text(encoding="utf-8")
    for old, new in (("npts", "n"), ("5372", "many")):
        path.write_text(text.replace(old, new), encoding="utf-8")
        says(refusal(read_manifest, path))


def test_places_that_cannot_be(motions, tmp_path, says):
    says(refusal(write_manifest, motions, tmp_path / "no" / "m.csv"), refusal(read_manifest, tmp_path / "m.csv"))
