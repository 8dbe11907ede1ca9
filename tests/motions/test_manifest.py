"""A manifest comes back as it was, and says what is not as it was."""

from __future__ import annotations

import doctest
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from pounding_risk.errors import RecordError
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


def test_the_same_records_pass(motions, tmp_path):
    check_manifest(write_manifest(motions, tmp_path / "m.csv"), motions)


def test_every_difference_is_told(motions, tmp_path):
    path = write_manifest(motions, tmp_path / "m.csv")
    changed = replace(motions[1], record={**motions[1].record, "sha256": "f" * 64})
    stronger = by_factor(motions[2], 2.0)
    with pytest.raises(RecordError) as told:
        check_manifest(path, [changed, stronger, Motion("new", np.ones(3), 0.01, {})])
    words = str(told.value)
    assert "m.csv: 6 differences from the records: " in words
    assert "RSN6-180 is not there" in words and "own, with a comma (2) is not there" in words
    assert "new is not in the manifest" in words
    assert "CCC-HNZ: the file has sha256 ffffffffffff..., the manifest says " in words and "it was changed" in words
    assert "own, with a comma: PGA [m/s2] is 0.66" in words and "own, with a comma: it was processed otherwise" in words


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda text: text.replace("npts", "n"), "its columns are name, .*; a manifest has name"),
        (lambda text: text.replace("5372", "many"), 'line 2, npts: "many" is no number'),
    ],
)
def test_a_damaged_manifest_is_refused(motions, tmp_path, edit, words):
    path = write_manifest(motions, tmp_path / "m.csv")
    path.write_text(edit(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(RecordError, match=words):
        read_manifest(path)


def test_places_that_cannot_be(motions, tmp_path):
    with pytest.raises(RecordError, match="cannot be written"):
        write_manifest(motions, tmp_path / "no" / "m.csv")
    with pytest.raises(RecordError, match=r"cannot be read .No such file.*check the name"):
        read_manifest(tmp_path / "m.csv")


def test_the_example():
    assert doctest.testmod(manifest).failed == 0
