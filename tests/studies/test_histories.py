"""Histories of chosen cases: against `simulate` at the samples, against the results' peaks, and what is refused."""

from itertools import product
from math import inf

import numpy as np
import pytest
from scenes import BOTH, TWO_AND_A_WALL, scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.results import layout
from pounding_risk.results.run_labels import GROUNDS
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.counters import STATUS, STATUS_SENTENCES
from pounding_risk.studies import pair_trace
from pounding_risk.studies.histories import WRITTEN

SCENE = scene_text(
    single("left", "44.36 t", "0.208 s"),
    single("right", "82.60 t", "0.4 s"),
    name="Two under two",
    gap="5 mm",
    records={"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "6 s"], "polarity": BOTH},
    grid={
        "gap": ["2 mm", "5 mm", "10 mm"],
        "yield_force": ["200 kN", "inf"],
        "contact_model": ["jankowski", "viscous_elastoplastic"],
        "pga": ["0.2 g", "0.5 g"],
    },
)
G = 9.80665


@pytest.fixture(scope="module")
def study():
    return parse_scene(SCENE)


@pytest.fixture(scope="module")
def results(study, tmp_path_factory):
    path = tmp_path_factory.mktemp("histories") / "results.nc"
    pr.scan(study, path)
    return path


@pytest.fixture(scope="module")
def written(results):
    """Two records, one polarity, two laws, two gaps, both yield forces."""
    out = results.with_name("histories.nc")
    pr.histories(results, out, polarities=["reversed"], pgas=[0.5 * G], gaps=[0.01, 0.002])
    return pr.open_results(out)


def at_times(run, times):
    """A run of `simulate` at these times, which are among its own but for rounding."""
    found = run.sel(time=times, method="nearest")
    assert np.abs(found["time"].values - times).max() < 1e-12
    return found


@pytest.mark.complete
def test_labels_are_those_of_the_results(written, results):
    whole = pr.open_results(results)
    chosen = whole.sel(polarity=["reversed"], pga=[0.5 * G], gap=[0.002, 0.01])
    assert written["status"].dims == chosen["status"].dims
    for name in ("record", "polarity", "pga", "contact_model", "gap", "yield_force", "building", "record_sha256"):
        np.testing.assert_array_equal(written[name].values, chosen[name].values)
    np.testing.assert_array_equal(written["status"].values, chosen["status"].values)
    for name, variable in written.data_vars.items():
        assert variable.attrs["long_name"], name
        assert name == "status" or variable.attrs["units"], name
    assert written.attrs["scene_resolved"] == whole.attrs["scene_resolved"]
    assert set(WRITTEN) < set(written.data_vars)


def test_each_record_has_its_own_time(written, study):
    motions = {motion.name: motion for motion in motions_of(study)}
    lengths = {name: motion.times.size for name, motion in motions.items()}
    assert len(set(lengths.values())) > 1 and written.sizes["sample"] == max(lengths.values())
    for name, motion in motions.items():
        one, size = written.sel(record=name), lengths[name]
        np.testing.assert_array_equal(one["time"].values[:size], motion.times)
        assert np.isnan(one["time"].values[size:]).all()
        assert np.isnan(one["displacement"].values[..., size:]).all()
        assert np.isfinite(one["displacement"].values[..., :size]).all()
        shaken = one["ground_acceleration"].values.squeeze()[:size]
        np.testing.assert_array_equal(shaken, motion.reversed().scaled_to(0.5 * G).acceleration)


def test_they_are_those_of_simulate_at_the_samples(written, study):
    """To the bit: it is the same run, whether alone or among others."""
    labels = [written[axis].values.tolist() for axis in ("record", "contact_model", "gap", "yield_force")]
    for record, law, gap, force in product(*labels):
        run = pr.simulate(study, record=record, polarity="reversed", law=law, gap=gap, yield_force=force, pga=0.5 * G)
        case = written.sel(record=record, contact_model=law, gap=gap, yield_force=force).isel(polarity=0, pga=0)
        times = case["time"].values[np.isfinite(case["time"].values)]
        wanted = at_times(run, times)
        for name in WRITTEN:
            found = case[name].values[..., : times.size]
            np.testing.assert_array_equal(found, np.moveaxis(wanted[name].values, 0, -1), err_msg=name)


def test_no_history_passes_its_peak(written, results):
    """What sampling misses: a sine of 0.208 s at 10 ms loses (ω Δ / 2)² / 2 = 1.1 %, and one in contact is quicker."""
    peaks = pr.open_results(results).sel(polarity=["reversed"], pga=[0.5 * G], gap=[0.002, 0.01])
    for name, peak, least in (
        ("relative_displacement", "peak_relative_displacement", 0.9),
        ("displacement", "peak_displacement", 0.95),
        ("contact_force", "peak_contact_force", 0.0),
    ):
        ratio = np.abs(written[name]).max("sample") / peaks[peak].where(peaks[peak] > 0.0)
        # A sum in another order: rounding.
        assert float(ratio.max()) <= 1.0 + 1e-12, name
        assert float(ratio.min()) >= least, name
    assert float(peaks["impact_count"].max()) > 5


def test_a_scene_gives_what_its_results_give(study, results, written, tmp_path, monkeypatch):
    """On one thread, and written in many small blocks."""
    monkeypatch.setattr(layout, "BLOCK_BYTES", 1.0)
    told, counts = [], []
    out = tmp_path / "same.nc"

    def say(sentence):
        assert not out.exists()
        told.append(sentence)

    choice = {"polarities": ["reversed"], "pgas": [0.5 * G * (1.0 + 1e-13)], "gaps": [0.002, 0.01]}
    pr.histories(study, out, **choice, workers=1, say=say, progress=lambda *done: counts.append(done))
    found = pr.open_results(out)
    assert found.identical(written.assign_attrs(scene=found.attrs["scene"]))
    assert told == ["16 cases, 601 samples: about 0.9 MB before compression"]
    assert counts[-1] == (16, 16)
    # Values of 8 bytes: smooth ones halve, forces are mostly 0.
    assert out.stat().st_size < 0.6e6


@pytest.mark.parametrize("output", ["peak_displacement", "impact_count"])
def test_the_largest_case_of_each_contact_model(results, study, tmp_path, output):
    whole = pr.open_results(results)
    pr.histories(results, tmp_path / "most.nc", largest_of=output, gaps=[0.005, 0.01])
    found = pr.open_results(tmp_path / "most.nc")
    assert found["displacement"].dims == ("contact_model", "building", "storey", "sample")
    for law in whole["contact_model"].values:
        case = found.sel(contact_model=law)
        place = {axis: case[axis].item() for axis in ("record", "polarity", "pga", "gap", "yield_force")}
        here = whole[output].sel(contact_model=law, gap=[0.005, 0.01])
        assert float(here.sel(place).max()) == float(here.max())
        run = pr.simulate(study, law=str(law), **place)
        times = case["time"].values[np.isfinite(case["time"].values)]
        wanted = at_times(run, times)["contact_force"].values[:, 0]
        np.testing.assert_array_equal(case["contact_force"].values[0, : times.size], wanted)


def test_what_is_not_there_is_refused_before_anything_is_written(results, study, tmp_path, says):
    out = tmp_path / "none.nc"
    grid = study.grid
    many = study.updated(grid=grid._replace(gaps=tuple(np.linspace(1e-3, 2e-2, 20).tolist())))
    for source, asked in (
        (results, {"gaps": [0.011]}),
        (results, {"yield_forces": [2.1e5]}),
        (results, {"records": ["RSN6-18"]}),
        (results, {"laws": []}),
        (results, {"most": 10}),
        (results, {"largest_of": "peak_force"}),
        (results, {"largest_of": "first_yield_time", "yield_forces": [inf]}),
        (study, {"largest_of": "impact_count"}),
        (study.updated(grid=grid._replace(amplitudes=(None,))), {"pgas": [1.0]}),
        (many, {"gaps": [5.5e-3]}),
    ):
        says(refusal(pr.histories, source, out, **asked))
    bare = pr.save(pr.open_results(results).drop_attrs(), tmp_path / "bare.nc")
    says(refusal(pr.histories, bare, out), refusal(pr.histories, bare, bare))
    assert [path.name for path in tmp_path.iterdir()] == ["bare.nc"]


def test_a_run_that_fails_has_no_motion_past_its_failure(study, tmp_path, monkeypatch):
    """A run said to fail after its last contact: nobody swings on as if parted. (Real failures take a minute.)"""
    whole = pr.simulate(study, gap=0.002, yield_force=inf, pga=0.5 * G)
    real, failure = pair_trace.run, max(STATUS_SENTENCES)

    def failing(*given):
        raw = real(*given)
        raw[STATUS] = failure
        return raw

    monkeypatch.setattr(pair_trace, "run", failing)
    one = study.updated(records=study.records._replace(names=("RSN6-180",), polarities=("as recorded",)))
    choice = {"gaps": [0.002], "yield_forces": [inf], "pgas": [0.5 * G], "laws": ["jankowski"]}
    pr.histories(one, tmp_path / "failed.nc", **choice)
    found = pr.open_results(tmp_path / "failed.nc").squeeze()
    assert int(found["status"]) == failure
    past = found["time"].values > float(whole["contact_end"].values.max())
    assert 0 < past.sum() < past.size
    for name in set(WRITTEN) - set(GROUNDS):
        told = found[name].values.reshape(-1, past.size)
        np.testing.assert_array_equal(np.isnan(told), np.broadcast_to(past, told.shape), err_msg=name)
    assert all(np.isfinite(found[name].values).all() for name in ("ground_acceleration", "ground_displacement"))


def test_an_interrupt_leaves_no_file(results, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pr.histories(results, tmp_path / "stopped.nc", gaps=[0.002], progress=stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.complete
def test_a_row_floor_by_floor(tmp_path):
    study = parse_scene(TWO_AND_A_WALL)
    pr.scan(study, tmp_path / "row.nc")
    pr.histories(tmp_path / "row.nc", tmp_path / "histories.nc", pgas=[0.3 * G])
    found, whole = pr.open_results(tmp_path / "histories.nc"), pr.open_results(tmp_path / "row.nc")
    assert found["displacement"].dims[-3:] == ("building", "storey", "sample")
    assert found["contact_force"].dims[-2:] == ("contact_point", "sample")
    np.testing.assert_array_equal(found["contact_point"].values, whole["contact_point"].values)
    np.testing.assert_array_equal(found["status"].values, whole["status"].sel(pga=[0.3 * G]).values)
    for gap in found["gap"].values:
        case = found.sel(gap=gap).squeeze()
        wanted = at_times(pr.simulate(study, gap=float(gap), pga=0.3 * G), case["time"].values)
        # The row's solver makes no energies.
        for name in ("displacement", "relative_displacement", "contact_force"):
            np.testing.assert_array_equal(case[name].values, np.moveaxis(wanted[name].values, 0, -1), err_msg=name)
    peak = whole["storey_displacement"].sel(pga=[0.3 * G])
    assert float((np.abs(found["displacement"]).max("sample") / peak).max()) <= 1.0 + 1e-12
    # The wall does not move, and the interface that the grid does not vary keeps its gap.
    assert found["interface_gap"].values.tolist() == [[3e-3, 3e-3], [9e-3, 3e-3]]
