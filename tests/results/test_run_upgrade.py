"""Runs that version 1 wrote are read as if this version had written them."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.cli import app
from pounding_risk.results.files import open_results
from pounding_risk.scene.reader import parse_scene

FILES = Path(__file__).parents[1] / "data" / "version1_runs"
G = 9.80665
ANEW = {"date_created", "history", "versions", "scene"}
CHOICES = {
    "simulate-pair": {"polarity": "reversed"},
    "simulate-wave": {},
    "simulate-row": {"pga": 0.3 * G},
    "histories-pair": {"records": ["RSN6-180"], "polarities": ["reversed"]},
    "histories-largest": {"largest_of": "impulse", "polarities": ["reversed"]},
    "histories-row": {"pgas": [0.3 * G]},
}
# What version 1 did not write: displacements in space, and of some files more.
IN_SPACE = {"ground_displacement", "absolute_displacement"}
ABSENT = {
    "simulate-pair": {"contact_impulse_so_far"},
    "simulate-wave": {"contact_impulse_so_far"},
    "simulate-row": {"relative_displacement"},
    "histories-row": {"relative_displacement"},
}
# Of what is written at the solver's own instants: those of a row are some microseconds earlier or later since it flies
# by blocks, and forces change by a part of themselves in that time.
CLOSE_IN_TIME = {"simulate-row": 1e-3}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files, unpacked."""
    target = tmp_path_factory.mktemp("runs")
    for packed in FILES.glob("*.gz"):
        (target / packed.stem).write_bytes(gzip.decompress(packed.read_bytes()))
    return target


def without_later_notes(dataset):
    """Without the note on a stiffness that is too soft, which the version of the files had not."""
    if "notes" in dataset.attrs:
        notes = [note for note in json.loads(dataset.attrs["notes"]) if "too soft by the rule" not in note]
        dataset.attrs["notes"] = json.dumps(notes)
    return dataset


def fresh(name, study, folder):
    """What this version writes where version 1 wrote the file."""
    if name.startswith("simulate"):
        return pr.simulate(study, **CHOICES[name])
    source = study
    if name == "histories-largest":
        source = folder / "scan.nc"
        pr.scan(study, source)
    out = pr.histories(source, folder / f"fresh-{name}.nc", **CHOICES[name])
    return open_results(out)


@pytest.mark.parametrize("name", CHOICES)
def test_it_is_a_fresh_run(folder, name):
    upgraded = open_results(folder / f"{name}.nc")
    now = without_later_notes(fresh(name, parse_scene(upgraded.attrs["scene_resolved"]), folder))
    if (
        name == "simulate-wave"
    ):  # the late building has the whole motion now: the histories of the file are the first part
        for variable, before in upgraded.data_vars.items():
            if "time" in before.dims:
                after = now[variable].isel(time=slice(upgraded.sizes["time"])).values
                np.testing.assert_allclose(
                    before, after, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(after)), err_msg=variable
                )
        return
    assert set(now.variables) - set(upgraded.variables) == IN_SPACE | ABSENT.get(name, set())
    assert set(upgraded.variables) <= set(now.variables)
    assert set(upgraded.coords) == set(now.coords)
    for variable in upgraded.variables:
        one, other = upgraded[variable].variable, now[variable].variable
        assert one.dims == other.dims and one.shape == other.shape, variable
        assert one.dtype.kind == other.dtype.kind or {one.dtype.kind, other.dtype.kind} <= set("OU"), variable
        assert set(one.attrs) == set(other.attrs), variable
        for key, value in one.attrs.items():
            # A wave was the only way to unlike grounds.
            said = value.replace("under a passing wave", "on unlike grounds") if isinstance(value, str) else value
            assert np.array_equal(said, other.attrs[key]), (variable, key)
        if one.dtype.kind in "OU":
            assert one.values.tolist() == other.values.tolist(), variable
        else:
            # To rounding, for processors and libraries other than those of the file.
            scale = float(np.nanmax(np.abs(other.values), initial=0.0, where=np.isfinite(other.values)))
            close = CLOSE_IN_TIME.get(name, 1e-9) if "time" in one.dims else 1e-9
            if variable == "energy_residual":
                close = 1e-2  # a remainder, of the size of the tolerance
            np.testing.assert_allclose(one.values, other.values, rtol=close, atol=close * scale, err_msg=variable)
    for key in set(upgraded.attrs) - ANEW:
        assert upgraded.attrs[key] == now.attrs[key], key
    assert set(now.attrs) - set(upgraded.attrs) == set()


@pytest.mark.parametrize("name", CHOICES)
def test_the_numbers_of_the_file_stay(folder, name):
    """To the bit, whatever the dimensions; a rigid building has no floor that moves."""
    plain, upgraded = xr.open_dataset(folder / f"{name}.nc"), open_results(folder / f"{name}.nc")
    same = [variable for variable in plain.data_vars if variable in upgraded]
    assert {"displacement", "contact_force"} <= set(same)
    for variable in same:
        values = upgraded[variable].values.reshape(plain[variable].shape)
        moves = ~np.isnan(values) if variable in ("displacement", "velocity") else ...
        np.testing.assert_array_equal(values[moves], plain[variable].values[moves], err_msg=variable)
    plain.close()


@pytest.mark.parametrize("name", ["simulate-pair", "simulate-wave", "simulate-row"])
def test_it_is_drawn_moved_and_written(folder, name, tmp_path):
    upgraded = open_results(folder / f"{name}.nc")
    assert figures.simulation_figure(upgraded).axes
    told = CliRunner().invoke(app, ["draw", str(folder / f"{name}.nc"), "--animation", str(tmp_path / "run.html")])
    assert told.exit_code == 0, told.output
    assert open_results(pr.save(upgraded, tmp_path / "again.nc")).identical(upgraded)


def test_lazily_too(folder):
    with open_results(folder / "histories-pair.nc", lazy=True) as upgraded:
        assert upgraded["contact_force"].dims[-2:] == ("contact_point", "sample")
        assert "displacement" in repr(upgraded)
        whole = open_results(folder / "histories-pair.nc")
        chosen = upgraded["displacement"].isel(gap=1, building=1)
        np.testing.assert_array_equal(chosen.values, whole["displacement"].isel(gap=1, building=1).values)
