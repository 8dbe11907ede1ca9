"""The catalogue says the truth about every record, and nothing but the catalogue's bytes is read."""

import shutil
from hashlib import sha256
from importlib import metadata
from types import SimpleNamespace

import numpy as np
import obspy
import pytest
from sentences import refusal

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue

G = 9.80665
ENTRIES = catalogue.entries()
SHIPPED = [entry for entry in ENTRIES if not entry.package]
ASKED = [
    *("RSN6-180", "RSN6-270", "RSN77-164", "RSN77-254", "RSN753-000", "RSN753-090", "RSN1690-090"),
    *("RSN1690-360", "CCC-HN1", "CCC-HN2", "CCC-HNZ", "NAPA-HNE", "NAPA-HNN", "NAPA-HNZ"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A copy of the records folder that a test may damage."""
    copy = tmp_path / "records"
    shutil.copytree(catalogue.records_folder(), copy)
    monkeypatch.setattr(catalogue, "records_folder", lambda: copy)
    catalogue._catalogue.cache_clear()
    yield copy
    catalogue._catalogue.cache_clear()


def test_the_records_a_scene_may_name():
    ids = [entry.id for entry in ENTRIES]
    assert set(ASKED) <= set(ids)
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.id)
def test_the_catalogue_equals_the_data(entry):
    assert sha256(catalogue.path(entry.id).read_bytes()).hexdigest() == entry.sha256
    trace = catalogue.load(entry.id)[0]
    assert (trace.stats.npts, trace.stats.delta, trace.stats.calib) == (entry.npts, entry.dt, 1.0)
    samples = trace.data - (trace.data.mean() if entry.state == "raw" else 0.0)
    assert np.abs(samples).max() / G == pytest.approx(entry.pga_g, rel=3e-4)
    assert entry.duration == pytest.approx((entry.npts - 1) * entry.dt)


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.id)
def test_every_record_says_where_it_is_from_and_on_what_terms(entry):
    assert entry.origin and entry.terms and entry.event and entry.station and entry.date
    assert 5.0 < entry.magnitude < 8.0
    assert entry.state in ("raw", "processed")
    assert entry.horizontal == (entry.component[-1] not in "PNZ" or entry.component == "HNN")


def test_the_aftershock_is_not_taken_for_the_mainshock():
    entry = catalogue.entry("RSN1690-090")
    assert entry.date == "1994-01-18"
    assert "aftershock" in entry.note and "aftershock" in entry.event


def test_published_peaks():
    """NGA-West2's own El Centro, and the peaks in the header of the Ridgecrest accelerogram."""
    assert round(catalogue.entry("RSN6-180").pga_g, 3) == 0.281
    assert [round(catalogue.entry(f"CCC-{name}").pga_g, 3) for name in ("HN1", "HN2", "HNZ")] == [0.471, 0.567, 0.361]


@pytest.mark.parametrize("entry", SHIPPED, ids=lambda entry: entry.id)
def test_the_stationxml_states_the_same_sensitivity(entry):
    """And ObsPy's own removal of the sensitivity gives the same samples."""
    stream = obspy.read(str(catalogue.path(entry.id)), format="MSEED")
    station = f"{stream[0].stats.network}.{stream[0].stats.station}.xml"
    inventory = obspy.read_inventory(str(catalogue.records_folder() / station), format="STATIONXML")
    stream.remove_sensitivity(inventory)
    assert np.allclose(stream[0].data, catalogue.load(entry.id)[0].data, rtol=1e-14, atol=0.0)


def test_the_shipped_files_are_compact():
    files = [path for path in catalogue.records_folder().iterdir() if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 600_000


def test_the_raw_records_are_whole_micro_g():
    samples = catalogue.load("CCC-HN1")[0].data / G * 1e6
    assert np.abs(samples - np.round(samples)).max() < 1e-6


@pytest.mark.parametrize("asked", ["RSN6-18", "El Centro", "RSN753-00", "ccc-hn1", "Kobe"])
def test_an_unknown_id_names_the_nearest(asked, says):
    says(refusal(catalogue.entry, asked))


def test_a_missing_package_and_another_version_name_the_repair(monkeypatch, tmp_path, says):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(catalogue.metadata, "distribution", missing)
    says(refusal(catalogue.load, "RSN6-180"))
    other = SimpleNamespace(version="0.9.0", locate_file=lambda path: tmp_path / path)
    monkeypatch.setattr(catalogue.metadata, "distribution", lambda name: other)
    says(refusal(catalogue.load, "RSN6-180").replace(" 0.9.0", " (version 0.9.0)"))


def test_changed_and_missing_files_are_refused(folder, says):
    path = folder / "CCC-HN1.mseed"
    raw = bytearray(path.read_bytes())
    raw[5000] ^= 1
    path.write_bytes(raw)
    (folder / "NAPA-HNE.mseed").unlink()
    told = refusal(catalogue.load, "CCC-HN1")
    assert f"has sha256 {sha256(raw).hexdigest()[:12]}..., the catalogue says 3fcdf90d2dfc...: " in told
    says(told, refusal(catalogue.load, "NAPA-HNE"))


def test_the_folder_is_found_in_a_checkout_and_in_a_wheel(tmp_path, monkeypatch):
    package = tmp_path / "site" / "pounding_risk"
    (package / "motions").mkdir(parents=True)
    monkeypatch.setattr(catalogue, "__file__", str(package / "motions" / "catalogue.py"))
    with pytest.raises(RecordError, match=r"no catalogue\.toml there"):
        catalogue.records_folder()
    for folder in (tmp_path / "site" / "records", package / "motions" / "records"):  # checkout, then wheel
        folder.mkdir()
        (folder / "catalogue.toml").touch()
        assert catalogue.records_folder() == folder
