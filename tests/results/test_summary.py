"""Datasets summed up and converted block by block: as the whole dataset in memory says, from either kind of file."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr
from commands import done, refused
from made_row import made_row
from scenes import two_records
from sentences import refusal

import pounding_risk
from pounding_risk.ensemble.scan import scan
from pounding_risk.results import layout
from pounding_risk.results.files import open_results, save
from pounding_risk.results.summary import counted, failures, summary
from pounding_risk.results.tolerance_check import findings
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.convert import convert

PAIR = two_records(law="jankowski", stiffness="2e9 N/m^1.5")
PAIR = PAIR.replace("[grid]", '[grid]\nyield_force = ["100 kN", "inf"]')


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A pair's scan, a row's made one and a history, each as netCDF and converted."""
    folder = tmp_path_factory.mktemp("files")
    history = xr.Dataset({"u_left": ("time", np.sin(np.arange(50.0)))}, {"time": np.arange(50) * 0.01}, {"dt": 0.01})
    made = {
        "pair": scan(parse_scene(PAIR), check_fraction=0.4),
        "row": made_row(records=2, failed=True),
        "history": history.assign_coords(building=["left", "right"]),
    }
    for name, dataset in made.items():
        save(dataset, folder / f"{name}.nc")
        with blocks_of(dataset):
            convert(folder / f"{name}.nc", folder / f"{name}.zarr")
    return folder


@contextmanager
def blocks_of(dataset: xr.Dataset) -> Iterator[None]:
    """Blocks so small that there are some, if there are cases."""
    template = layout.template_of(dataset)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", template.bytes_per_case * template.batches * template.width / 2.5)
        assert len(list(layout.blocks(template))) >= 3 or not template.cases
        yield


@pytest.mark.parametrize("name", ["pair", "row", "history"])
def test_there_and_back_is_the_same_dataset(files, tmp_path, name):
    """Values, the order of the variables, and the types of numbers in values and attributes."""
    first = open_results(files / f"{name}.nc")
    with blocks_of(first):
        convert(files / f"{name}.zarr", tmp_path / "back.nc")
    there, back = open_results(files / f"{name}.zarr"), open_results(tmp_path / "back.nc")
    xr.testing.assert_identical(there, first)
    xr.testing.assert_identical(back, first)
    assert list(there.data_vars) == list(back.data_vars)
    for key, value in first.attrs.items():
        assert type(back.attrs[key]) is type(value), key
    for each in first.variables:
        assert back[each].dtype == first[each].dtype, each
        for key, value in first[each].attrs.items():
            assert np.asarray(back[each].attrs[key]).dtype == np.asarray(value).dtype, (each, key)


def test_what_cannot_be_converted_is_told(files, tmp_path, says):
    (tmp_path / "broken.nc").write_bytes((files / "pair.nc").read_bytes()[:5000])
    places = [(tmp_path / "none.nc", tmp_path / "some.zarr"), (files / "pair.nc", tmp_path / "pair.h5")]
    says([refusal(convert, *each) for each in places])
    assert "is the source itself" in refusal(convert, files / "pair.nc", files / "pair.nc")
    assert "is not a readable netCDF file" in refusal(convert, tmp_path / "broken.nc", tmp_path / "broken.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.nc"]


@pytest.mark.parametrize(("name", "suffix"), [("pair", ".zarr"), ("row", ".nc")])
def test_a_summary_is_what_the_whole_dataset_says(files, name, suffix):
    """The rechecks too, which are streamed."""
    dataset = open_results(files / f"{name}{suffix}")
    with blocks_of(dataset):
        found = summary(files / f"{name}{suffix}")
        with open_results(files / f"{name}{suffix}", lazy=True) as lazy:
            assert list(findings(lazy)) == list(findings(dataset))
    assert bool(found.rechecks) == (name == "pair")
    if name == "pair":
        runs = f"{found.counts['recomputed']} of {found.counts['simulated']} runs"
        assert found.rechecks["recomputed"].startswith(runs)
    status = dataset["status"].values
    assert found.counts["cases"] == status.size
    assert found.counts["simulated"] == int((dataset["simulated"] == 1).sum())
    complete = dataset["status"] == 0
    for variable, by_law in found.spreads.items():
        for law, spread in by_law.items():
            values = dataset[variable].where(complete).sel(contact_model=law).values
            values = values[np.isfinite(values)]
            assert spread.values == values.size, variable
            if values.size:
                assert (spread.least, spread.largest) == (values.min(), values.max()), variable
                # Sums of doubles in another order: some thousand values of one sign at most.
                assert spread.mean == pytest.approx(values.mean(), rel=1e-12, abs=1e-300), variable
    assert {"status", "simulated", "sensitive"}.isdisjoint(found.spreads)
    assert found.units["peak_contact_force" if name == "pair" else "peak_floor_acceleration"] in ("N", "m/s2")


def test_failures_are_counted_by_their_sentence(files):
    """The sentences are the dataset's own; without them its flags' words."""
    dataset = open_results(files / "pair.nc")
    dataset["status"].values.flat[:3] = [3, 3, 6]
    found = failures(dataset)
    assert found == {
        "the step budget ran out; raise rtol or lower the stiffness": 2,
        "the energy of the contacts does not close; lower rtol": 1,
    }
    assert counted(dataset) == {**counted(open_results(files / "pair.nc")), **found}
    del dataset["status"].attrs["sentences"]
    assert list(failures(dataset).values()) == [2, 1]
    assert next(iter(failures(dataset))).startswith("the step budget ran out raise")
    row = failures(open_results(files / "row.nc"))
    assert row and not any("status " in words for words in row)


def test_a_summary_is_of_a_scan_only(files, says):
    assert "is no dataset of a scan" in refusal(summary, files / "history.nc")
    says(refusal(summary, open_results(files / "pair.nc").drop_attrs()))


@pytest.mark.complete
def test_the_commands_print_and_write(files, tmp_path):
    told = done("summary", files / "pair.zarr").stdout
    assert "cases" in told and "peak_contact_force" in told and "nan" not in told
    converted = done("convert", files / "pair.zarr", tmp_path / "pair.nc").stdout
    assert converted == f"written: {tmp_path / 'pair.nc'}\n"
    assert "must end in .nc or .zarr" in refused("convert", files / "pair.zarr", tmp_path / "pair.csv")
    assert pounding_risk.summary is summary and pounding_risk.convert is convert
