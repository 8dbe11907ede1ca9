"""Datasets come to disk block by block: whole or not at all, the same bytes for the same values; their blocks."""

import errno
import os
import re
import signal
import subprocess
import sys
import time
from math import prod

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from made_forms import SHAPE, made_template, pieces, values_of
from processes import output, python
from sentences import refusal
from sweeps import sweep

from pounding_risk._common.files import checksum, host, not_written, partial_of, remove_leftovers
from pounding_risk.ensemble.checkpoint.folder import folder_of
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.errors import PoundingError
from pounding_risk.results import layout
from pounding_risk.results.files import check_target, open_results, save
from pounding_risk.results.layout import AXES, block_shape, blocks, place, template_of, values_at
from pounding_risk.results.store import Memory, Netcdf, store_of

SUFFIXES = (".nc", ".zarr")
LATER = {"command": "pounding-risk scan é", "parts": 3, "share": 0.5}


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Several blocks in a dataset of few cases, the last one cut off."""
    monkeypatch.setattr(layout, "BLOCK_BYTES", 10_000)


def write(store, template, later=LATER):
    for block, values in pieces(template):
        store.write(block, values)
    store.finish(later)
    return store


def in_memory(template):
    return write(Memory(template), template).dataset()


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_blocks_are_several_here():
    template = made_template()
    assert block_shape(template) == (3, 2, 1, 2, 5, 3)
    assert [len(block) for block in blocks(template)] == [60, 60, 20]


def test_memory_holds_what_was_written():
    template = made_template()
    dataset = in_memory(template)
    assert dataset.sizes == {**template.skeleton.sizes}
    assert dataset["at_buildings"].dims == (*template.dims, "building")
    assert dataset.attrs == template.skeleton.attrs | LATER
    for name, values in values_of(template, range(template.batches)).items():
        np.testing.assert_array_equal(dataset[name].values.ravel(), values.ravel())


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(("shape", "run"), [(SHAPE, None), ((2, 1, 3, 1, 4, 2), 7), ((1, 1, 1, 1, 1, 1), None)])
def test_disk_gives_what_memory_gives(tmp_path, suffix, shape, run):
    """Values, labels and attributes, and the types of numbers in both; also of runs of lines that are no blocks."""
    template = made_template(shape)
    dataset, target = in_memory(template), tmp_path / f"results{suffix}"
    starts = range(0, template.batches, run) if run else ()
    runs = [range(start, min(start + run, template.batches)) for start in starts] or blocks(template)
    with store_of(template, target) as store:
        for batches in runs:
            store.write(batches, values_of(template, batches))
        store.finish(LATER)
    assert names(tmp_path) == [target.name]
    found = open_results(target)
    xr.testing.assert_identical(found, dataset)
    for name, variable in dataset.variables.items():
        if variable.dtype.kind in "if":
            assert found[name].dtype == variable.dtype, name
    assert found["status"].attrs["flag_values"].dtype == np.int8


def test_a_netcdf_file_is_as_xarray_writes_it(tmp_path):
    """Attribute for attribute, with the fill values and the lists of coordinates that xarray hides when it reads."""
    template = made_template()
    write(Netcdf(template, tmp_path / "pieces.nc"), template)
    save(in_memory(template), tmp_path / "whole.nc")
    with netCDF4.Dataset(tmp_path / "pieces.nc") as pieces_, netCDF4.Dataset(tmp_path / "whole.nc") as whole:
        assert set(pieces_.variables) == set(whole.variables)
        assert str(pieces_.__dict__) == str(whole.__dict__)
        for name, variable in whole.variables.items():
            found = pieces_[name]
            assert (found.dimensions, found.dtype) == (variable.dimensions, variable.dtype), name
            assert str(found.__dict__) == str(variable.__dict__), name
            assert found.filters() == variable.filters(), name
        assert pieces_["count"].chunking() == [3, 2, 2, 5, 3]


MANY_ATTRIBUTES = """
import sys
from made_forms import made_template, pieces
from pounding_risk.results.store import Netcdf
import xarray as xr
names = "Conventions title source dataset_version scene scene_resolved overrides rtol records processing versions "
names += "references stiffness restitution restitution_relation flags scene_axes scene_variants notes"
lengths = [7, 23, 38, 1, 689, 820, 2, 5, 2529, 675, 189, 93, 43, 4, 9, 2, 98, 468, 101]
first = {name: "x" * length for name, length in zip(names.split(), lengths)}
first["processing"] = "m/s²" * 168 + "m/s"
names = "parts scene_variants scene_file scene_sha256 options motions_sha256 kernels_digest date_created history"
later = {name: "y" * length for name, length in zip(names.split(), [14, 562, 9, 64, 43, 241, 16, 25, 85])}
template = made_template()
template = template._replace(skeleton=template.skeleton.drop_attrs(deep=False).assign_attrs(first))
store = Netcdf(template, sys.argv[1])
for block, values in pieces(template):
    store.write(block, values)
store.finish(later)
with xr.open_dataset(sys.argv[1]) as written:
    assert dict(written.attrs) | first | later == dict(written.attrs)
"""


def test_attributes_that_come_late_are_written_beside_many(tmp_path):
    # HDF5 2.2 ends the process with these sizes where the file is closed and opened again in between.
    output("-c", MANY_ATTRIBUTES, str(tmp_path / "many.nc"))


@pytest.mark.parametrize("suffix", sweep(SUFFIXES, ".nc"))
def test_a_link_is_written_through_and_stays(tmp_path, suffix):
    """Beside the file that it leads to, so that the file is whole or not there, and the link is never replaced."""
    template, (far, near) = made_template((2, 1, 1, 1, 2, 1)), (tmp_path / "far", tmp_path / "near")
    far.mkdir()
    near.mkdir()
    link = near / f"results{suffix}"
    link.symlink_to(far / f"data{suffix}")
    write(store_of(made_template((1, 1, 1, 1, 2, 1)), link), made_template((1, 1, 1, 1, 2, 1)))
    for _ in range(2):  # in place of an older one of another size, and of its like
        write(store_of(template, link), template)
        assert link.is_symlink() and names(near) == [link.name] and names(far) == [f"data{suffix}"]
        xr.testing.assert_identical(open_results(link), in_memory(template))
    assert folder_of(link) == (far / "data.study").resolve()
    if suffix == ".nc":
        save(in_memory(template).assign_attrs(title="other"), link)
        assert link.is_symlink() and open_results(far / "data.nc").attrs["title"] == "other"


def test_links_that_lead_nowhere_good_are_refused(tmp_path, says):
    (tmp_path / "a.nc").symlink_to(tmp_path / "b.nc")
    (tmp_path / "b.nc").symlink_to(tmp_path / "a.nc")
    (tmp_path / "c.nc").symlink_to(tmp_path / "precious.txt")
    (tmp_path / "d.nc").symlink_to(tmp_path / "no folder" / "d.nc")
    says([refusal(check_target, tmp_path / f"{name}.nc") for name in "acd"])


def test_what_a_killed_process_left_as_a_link_is_not_followed(tmp_path):
    template, victim = made_template((2, 1, 1, 1, 2, 1)), tmp_path / "victim"
    victim.write_text("precious")
    for target in (tmp_path / "a.nc", tmp_path / "b.zarr"):
        partial_of(target).symlink_to(victim)
        write(store_of(template, target), template)
    partial_of(tmp_path / "c.nc").symlink_to(victim)
    save(in_memory(template), tmp_path / "c.nc")
    assert victim.read_text() == "precious"


def test_a_limit_on_a_file_s_size_is_told_as_what_it_is(tmp_path, monkeypatch):
    """Not as want of space; netCDF gives it a name of its own, beside which the limit is told."""
    resource = pytest.importorskip("resource")
    told = not_written(tmp_path / "a.nc", OSError(errno.EFBIG, "File too large"), "free space and try again")
    assert str(told).endswith("(File too large); raise the limit (ulimit -f) and try again")
    monkeypatch.setattr(resource, "getrlimit", lambda which: (2_000_000, 2_000_000))
    told = not_written(tmp_path / "a.nc", RuntimeError("NetCDF: HDF error"), "free space and try again")
    assert re.search(
        r"MB free; a file of this process may have 2 MB at most\); raise the limit \(ulimit -f\) and try again$",
        str(told),
    )


WRITE = """
import sys
from made_forms import made_template, pieces
from pounding_risk.results import layout
from pounding_risk.results.store import store_of
layout.BLOCK_BYTES = 10_000
template = made_template()
store = store_of(template, sys.argv[1])
for number, (block, values) in enumerate(pieces(template)):
    store.write(block, values)
    print(number, flush=True)
    sys.stdin.readline()
store.finish({"later": 1})
"""


@pytest.mark.parametrize("suffix", sweep(SUFFIXES, ".nc"))
def test_bytes_follow_from_the_values_alone(tmp_path, suffix):
    """Two processes, at another second: no time and no name is in the bytes."""
    template, start = made_template(), int(time.time())
    write(store_of(template, tmp_path / f"one{suffix}"), template, {"later": 1})
    while int(time.time()) == start:  # times in such files have whole seconds
        time.sleep(0.02)
    run = python("-c", WRITE, tmp_path / f"other{suffix}")
    _, errors = run.communicate("\n\n\n", timeout=60)
    assert run.returncode == 0, errors
    assert checksum(tmp_path / f"one{suffix}") == checksum(tmp_path / f"other{suffix}")


@pytest.mark.complete
@pytest.mark.parametrize(("suffix", "older"), [(".nc", False), (".nc", True), (".zarr", True)])
def test_a_killed_run_leaves_the_older_results_or_none(tmp_path, suffix, older):
    target = tmp_path / f"results{suffix}"
    template = made_template()
    if older:
        write(store_of(template, target), template)
        before = checksum(target)
    run = python("-c", WRITE, target)
    assert run.stdout.readline() == "0\n"
    run.stdin.write("\n")
    run.stdin.flush()
    assert run.stdout.readline() == "1\n"
    os.kill(run.pid, signal.SIGKILL)
    run.communicate(timeout=60)
    assert target.exists() == older
    if older:
        assert checksum(target) == before
    else:
        assert "no such results file" in refusal(open_results, target)
    (left,) = remove_leftovers(target)
    assert left.name == f".{target.name}.{host()}.{run.pid}.partial"
    assert names(tmp_path) == [target.name] * older


@given(st.lists(st.tuples(st.integers(0, 139), st.integers(1, 25)), max_size=12), st.sampled_from([Memory, *SUFFIXES]))
@settings(max_examples=10)
def test_any_run_of_lines_may_be_written_over(tmp_path_factory, runs, kind):
    """Patches across blocks and within them, of some of the variables: the last one holds."""
    template = made_template()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", 10_000)
        folder = tmp_path_factory.mktemp("patched")
        store = Memory(template) if kind is Memory else store_of(template, folder / f"r{kind}")
        expected = values_of(template, range(template.batches))
        for block, values in pieces(template):
            store.write(block, values)
        for number, (first, count) in enumerate(runs):
            batches = range(first, min(first + count, template.batches))
            name = ("count", "at_buildings")[number % 2]
            expected[name][batches.start : batches.stop] = number
            store.write(batches, {name: expected[name][batches.start : batches.stop]})
        store.finish({})
        dataset = store.dataset() if kind is Memory else open_results(store.target)
    for name, values in expected.items():
        np.testing.assert_array_equal(dataset[name].values.ravel(), values.ravel(), err_msg=name)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_nothing_is_left_of_what_is_not_finished(tmp_path, suffix):
    template = made_template()
    store = store_of(template, tmp_path / f"abandoned{suffix}")
    store.write(*next(pieces(template)))
    assert len(names(tmp_path)) == 1, "it is written aside"
    store.abandon()
    store.abandon()
    assert names(tmp_path) == []
    with pytest.raises(KeyboardInterrupt), store_of(template, tmp_path / f"stopped{suffix}") as store:
        raise KeyboardInterrupt
    assert names(tmp_path) == []


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_has_holes_is_not_finished(tmp_path, suffix):
    template = made_template()
    store = store_of(template, tmp_path / f"results{suffix}")
    store.write(*next(pieces(template)))
    assert "never written" in refusal(store.finish, {}, kind=ValueError)
    assert names(tmp_path) == []
    store = store_of(template, tmp_path / f"results{suffix}")
    told = refusal(store.write, range(3), {"count": np.zeros((3, 2))}, kind=ValueError)
    assert "count is (3, 2) for 3 batches" in told
    assert names(tmp_path) == []


@pytest.mark.parametrize("suffix", sweep(SUFFIXES, ".nc"))
def test_a_full_disk_is_told_and_left_as_it_was(small_disk, suffix, monkeypatch):
    """Twice, as a file that the library cannot close may not stay in the way; then there is space, and it works."""
    monkeypatch.setattr(layout, "BLOCK_BYTES", 300_000)
    template = made_template((60, 2, 1, 2, 20, 3), variables=8)
    free = os.statvfs(small_disk).f_bfree
    for _ in range(2):
        with pytest.raises(
            PoundingError, match=r"results\S+ cannot be written .*free space and run .* chunks are kept"
        ):
            write(store_of(template, small_disk / f"results{suffix}"), template)
        assert names(small_disk) == []
        # Blocks: a folder in a tmpfs may keep one of its own.
        assert os.statvfs(small_disk).f_bfree >= free - 1
    subprocess.run(["mount", "-o", "remount,size=30m", str(small_disk)], check=True)
    write(store_of(template, small_disk / f"results{suffix}"), template)
    xr.testing.assert_identical(open_results(small_disk / f"results{suffix}"), in_memory(template))


FILE_LIMIT = 40_000  # bytes: the skeleton fits in, the cases do not


@pytest.mark.complete
def test_a_file_that_may_not_grow_is_told(tmp_path):
    """As on a full disk, without the rights of root: the system allows no file as long as this."""
    limited = (
        "import resource, signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({FILE_LIMIT}, {FILE_LIMIT}))\n"
        "from made_forms import made_template, pieces\nfrom pounding_risk.errors import PoundingError\n"
        "from pounding_risk.results.store import store_of\nimport sys\n"
        "template = made_template((20, 2, 1, 2, 40, 30))\n"
        "try:\n    store = store_of(template, sys.argv[1])\n    for piece in pieces(template):\n"
        "        store.write(*piece)\n"
        "    store.finish({})\nexcept PoundingError as error:\n    print(error)\n"
    )
    assert "cannot be written" in output("-c", limited, tmp_path / "results.nc")
    assert names(tmp_path) == []


def test_only_a_store_of_ours_is_replaced(tmp_path):
    template = made_template()
    strange = tmp_path / "strange.zarr"
    strange.mkdir()
    (strange / "thesis.txt").write_text("all of it")
    file = tmp_path / "file.zarr"
    file.write_text("no folder")
    for target in (strange, file):
        assert "is there already and no Zarr store of pounding-risk" in refusal(store_of, template, target)
    assert (strange / "thesis.txt").read_text() == "all of it"
    ours = tmp_path / "ours.zarr"
    write(store_of(template, ours), template)
    write(store_of(made_template((2, 1, 1, 1, 2, 2)), ours), made_template((2, 1, 1, 1, 2, 2)))
    assert open_results(ours).sizes["record"] == 2
    assert names(tmp_path) == ["file.zarr", "ours.zarr", "strange.zarr"]


def test_a_name_is_refused_before_the_work_that_it_would_lose(tmp_path, says):
    """The names on the way are longer than the target's, and netCDF takes no name that is not text."""
    assert check_target(tmp_path / "a.zarr", (".nc", ".zarr")).name == "a.zarr"
    says(refusal(store_of, made_template(), tmp_path / "a.h5"), refusal(check_target, tmp_path / "a.zarr"))
    assert "choose a shorter name" in refusal(check_target, tmp_path / f"{'x' * 245}.nc")
    assert "is no text in UTF-8" in refusal(check_target, tmp_path / os.fsdecode(b"raw\xff.nc"))
    room = 255 - len(partial_of(tmp_path / ".zarr").name)  # letters, in most file systems; a pid may have one more
    template, target = made_template(), tmp_path / f"{'x' * (room - 4)}.zarr"
    write(store_of(template, target), template)
    assert names(tmp_path) == [target.name]


def test_only_what_was_left_of_the_target_itself_is_removed(tmp_path):
    """Names may hold what is a pattern elsewhere, and begin alike."""
    theirs = (".b.nc.node1.4711.partial", ".[ab].nc.old.nc.node1.4711.partial", ".[ab].nc.mine.partial")
    for name in (".[ab].nc.node1.4711.partial", *theirs):
        (tmp_path / name).write_bytes(b"half")
    assert [path.name for path in remove_leftovers(tmp_path / "[ab].nc")] == [".[ab].nc.node1.4711.partial"]
    assert names(tmp_path) == sorted(theirs)


@pytest.mark.complete
def test_a_crash_between_two_names_is_told(tmp_path):
    """The older store is whole under the name that the sentence gives."""
    template, target = made_template(), tmp_path / "results.zarr"
    write(store_of(template, target), template)
    target.rename(tmp_path / ".results.zarr.here.4711.old")
    with pytest.raises(PoundingError, match=r"rename \S+\.results\.zarr\.here\.4711\.old, the results of before"):
        open_results(target)
    write(store_of(template, target), template)
    assert [path.name for path in remove_leftovers(target)] == [".results.zarr.here.4711.old"]
    assert names(tmp_path) == ["results.zarr"]


def test_a_zarr_store_that_lost_pieces_and_what_is_none_are_told(tmp_path, says):
    """Zarr itself would read lost pieces as missing values."""
    template, target = made_template(), tmp_path / "results.zarr"
    write(store_of(template, target), template)
    next(path for path in sorted((target / "count").iterdir()) if path.name[0] != ".").unlink()
    says([refusal(open_results, target, lazy=lazy) for lazy in (False, True)])
    (target / ".zmetadata").write_text("{")
    assert ".zmetadata: cannot be read as JSON" in refusal(open_results, target)
    (tmp_path / "folder.zarr").mkdir()
    says(refusal(open_results, tmp_path / "folder.zarr"))


def test_lazy_results(tmp_path):
    template = made_template()
    dataset = in_memory(template)
    for suffix in SUFFIXES:
        write(store_of(template, tmp_path / f"results{suffix}"), template)
    with open_results(tmp_path / "results.zarr", lazy=True) as found:
        assert {size for sizes in found["count"].chunks for size in sizes} <= {1, 2, 3, 5}
        assert found["count"].data.npartitions == len(list(blocks(template)))
        assert found["record_event"].chunks is None, "labels are there"
        assert int(found["count"].sum()) == int(dataset["count"].sum())
    with open_results(tmp_path / "results.nc", lazy=True) as found:
        assert found["count"].chunks is None
        assert not found["count"].variable._in_memory
        xr.testing.assert_identical(found, dataset)


THREADS = """
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from made_forms import made_template, pieces
from pounding_risk.results.files import open_results, save
from pounding_risk.results.store import Netcdf

template = made_template()
written = list(pieces(template))

def write(number):
    target = Path(f"{number}.nc")
    with Netcdf(template, target) as store:
        for block, values in written:
            store.write(block, values)
        store.finish({})
    save(open_results(target), f"{number}-copy.nc")
    return open_results(f"{number}-copy.nc")

with ThreadPoolExecutor(8) as threads:
    found = list(threads.map(write, range(16)))
assert all(each.identical(found[0]) for each in found)
"""


@pytest.mark.complete
def test_threads_of_a_user_take_turns_at_netcdf(tmp_path):
    """Without turns the process ends by a signal: of the first run of three threads, each with a scan of its own."""
    output("-c", THREADS, cwd=tmp_path)


@pytest.mark.parametrize("call", [scan, lambda scene, out: scan_shard(scene, out, "1/2")])
def test_a_missing_extra_is_told_before_any_work(call, tmp_path, monkeypatch):
    """Not when all is solved and only the file is left to write; the scene is not even read."""
    monkeypatch.setitem(sys.modules, "zarr", None)
    calls = (lambda: call(tmp_path / "no scene.toml", target), lambda: store_of(made_template(), target))
    target = tmp_path / "results.zarr"
    assert all('pip install "pounding-risk[cluster]"' in refusal(each) for each in calls)
    assert names(tmp_path) == []
    target.mkdir()
    assert 'pip install "pounding-risk[cluster]"' in refusal(open_results, target)


shapes = st.tuples(*[st.integers(1, 7)] * 5, st.integers(1, 4))


@settings(max_examples=20)
@given(shapes, st.integers(1, 40_000))
def test_blocks_cover_every_line_once_as_boxes_as_large_as_they_may_be(shape, most):
    template = made_template(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(layout, "BLOCK_BYTES", most)
        found, sizes = list(blocks(template)), block_shape(template)
        boxes = [place(template, block) for block in found]
    assert [batch for block in found for batch in block] == list(range(template.batches))
    assert sizes[-1] == template.width, "a batch is never broken"
    numbers = np.arange(template.batches).reshape([template.skeleton.sizes.get(axis, 1) for axis in AXES[:-1]])
    for block, box in zip(found, boxes, strict=True):
        assert tuple(box) == template.dims
        where = tuple(box.get(axis, slice(None)) for axis in AXES[:-1])
        assert numbers[where].ravel().tolist() == list(block)
    bytes_per_batch = template.bytes_per_case * template.width
    assert max(map(len, found)) * bytes_per_batch <= max(most, bytes_per_batch)
    # Chunks of a file have one shape: only the last along an axis may be cut off.
    assert all(
        box[axis].start % size == 0 for box in boxes for axis, size in zip(AXES, sizes, strict=True) if axis in box
    )
    # A larger block would be another box: the next axis out is not begun while one within is broken.
    broken = [axis for axis in range(5) if sizes[axis] < shape[axis]]
    if broken:
        inner = broken[-1]
        assert all(size == 1 for size in sizes[:inner])
        assert (sizes[inner] + 1) * prod(sizes[inner + 1 :]) * template.bytes_per_case > most


def test_the_form_of_a_dataset_is_the_form_it_was_made_of():
    template = made_template()
    memory = Memory(template)
    memory.write(range(template.batches), values_of(template, range(template.batches)))
    memory.finish({})
    found = template_of(memory.dataset())
    assert found.skeleton.identical(template.skeleton)
    assert (found.shape, found.dims, found.bytes_per_case) == (SHAPE, template.dims, template.bytes_per_case)
    assert {name: (each.dims, each.dtype) for name, each in found.cases.items()} == {
        name: (each.dims, each.dtype) for name, each in template.cases.items()
    }
    block = list(blocks(template))[-1]
    for name, values in values_at(memory.dataset(), found, block, template.cases).items():
        np.testing.assert_array_equal(values, values_of(template, block)[name])


def test_a_dataset_without_cases_is_all_skeleton():
    skeleton = made_template().skeleton.drop_dims(["gap", "contact_model", "yield_force", "polarity"])
    template = template_of(skeleton.isel(record=0, drop=True))
    assert (template.batches, template.width, dict(template.cases)) == (1, 1, {})
    assert list(blocks(template)) == [range(1)]
