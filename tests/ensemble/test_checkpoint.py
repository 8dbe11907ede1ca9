"""The folder that keeps a study: nothing kept is lost by a kill, nothing half is taken, and nothing else is touched."""

import gc
import json
import os
import random
import shutil
import signal
import subprocess
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import python
from sentences import refusal

import pounding_risk
from pounding_risk.ensemble.checkpoint.chunks import Damaged, batches_of, chunk_name, read_chunk, write_chunk
from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint, folder_of, read_lines, read_study, write_line
from pounding_risk.ensemble.checkpoint.lock import Lock
from pounding_risk.ensemble.chunks import chosen, merged, pieces_of
from pounding_risk.ensemble.status import STOPPED, status
from pounding_risk.errors import PoundingError

IDENTITY = {
    "scene": {"interface": [{"gap": "20 mm"}], "grid": {"gap": ["0 mm", "5 mm"]}},
    "records": [],
    "options": {"screening": True},
    "program": {"numpy": "2", "source": "a"},
    "laws": {},
}
OTHER = {**IDENTITY, "scene": {"interface": [{"gap": "25 mm"}]}, "options": {"screening": False}}
ABOUT = About(batches=100, width=3, title="A pair", command="pounding-risk scan scene.toml")


def chunk_of(batches: range, longest: int | None = None) -> dict[str, np.ndarray]:
    """What these batches give: every number says its batch, and its place in the batch."""
    start = np.array(batches)[:, None, None]
    answers = 2 + max(batch % 4 for batch in batches) if longest is None else longest
    ragged = np.zeros((len(batches), 3, answers))
    for row, batch in enumerate(batches):
        ragged[row, :, : 2 + batch % 4] = batch + 1.0
    return {
        "raw": start + np.arange(12.0).reshape(3, 4) / 16.0,
        "how": (start[:, 0] + np.arange(3)).astype(np.int8),
        "times_ragged": ragged,
    }


def opened(path: Path, identity: dict = IDENTITY, **choices: bool) -> Checkpoint:
    """The study's folder."""
    return Checkpoint.open(path, identity, ABOUT, **choices)


def keep(folder: Checkpoint, *ranges: range) -> None:
    """Keep what these batches give."""
    for batches in ranges:
        folder.keep(batches, chunk_of(batches), 0.5)


def begun(path: Path, *ranges: range) -> None:
    """A study that was stopped when it had kept what these batches give."""
    with opened(path) as folder:
        keep(folder, *ranges)


def found(path: Path, **choices: bool) -> list[range]:
    """What the next start finds."""
    with opened(path, **choices) as folder:
        return folder.done()


def events(path: Path) -> list[str]:
    """What the log tells."""
    return [line["event"] for line in read_lines(path / "log.jsonl")]


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "results.study"


def test_what_is_kept_is_there_at_the_next_start(path):
    assert folder_of(path.with_suffix(".nc")) == folder_of(path.with_suffix(".zarr")) == folder_of(path) == path
    with opened(path) as folder:
        assert folder.done() == []
        keep(folder, range(0, 10), range(40, 41), range(10, 20))
        assert folder.done() == [range(0, 20), range(40, 41)]
    with opened(path) as folder:
        assert folder.done() == [range(0, 20), range(40, 41)]
        (whole,) = folder.chunks([range(3, 17)])
        assert all(np.array_equal(whole[name], array) for name, array in chunk_of(range(3, 17)).items())
        with pytest.raises(
            PoundingError, match="of the batches from 20 on there is no chunk; run the same command again"
        ):
            list(folder.chunks([range(15, 41)]))
        folder.clear()
    assert sorted(entry.name for entry in path.iterdir()) == ["lock", "log.jsonl", "parts", "study.json"]
    assert list((path / "parts").iterdir()) == []
    about = read_study(path)
    assert about["identity"] == IDENTITY and [about[key] for key in ("lines", *About._fields[1:])] == list(ABOUT)
    told = ["begin", "start", "kept", "kept", "kept", "stop", "start", "complete", "stop"]
    assert events(path) == told


def test_a_kept_part_is_a_plain_numpy_archive(path):
    """Without this program the numbers can still be read, and nothing in them is a pickle."""
    begun(path, range(5, 8))
    with np.load(path / "parts" / "000000005-000000008.npz", allow_pickle=False) as archive:
        assert np.array_equal(archive["raw"], chunk_of(range(5, 8))["raw"])
    for array in (np.array([[1]], dtype=object), np.array(["a"]), np.zeros((2, 3)), np.array(1.0)):
        with opened(path) as folder, pytest.raises(ValueError, match="is not one row of numbers a batch of"):
            folder.keep(range(0, 3), {"raw": array}, 0.0)
    assert len(list((path / "parts").iterdir())) == 1


ranges_of_batches = st.lists(
    st.tuples(st.integers(0, 39), st.integers(1, 40)).map(lambda pair: range(pair[0], min(sum(pair), 40))), max_size=12
)


@given(ranges_of_batches, st.lists(st.integers(1, 39), max_size=6))
@settings(max_examples=25)
@pytest.mark.complete
def test_any_chunks_that_cover_the_batches_give_the_same_numbers(chunks, cuts):
    """Overlapping, of any length, in any order; and any blocks."""
    missing = [range(batch, batch + 1) for batch in range(40) if not any(batch in batches for batches in chunks)]
    ends = [0, *sorted(set(cuts)), 40]
    blocks = [range(start, stop) for start, stop in pairwise(ends)]
    with TemporaryDirectory() as folder, opened(Path(folder) / "a.study") as study:
        keep(study, *chunks, *merged(missing))
        found = list(study.chunks(blocks))
    for block, chunk in zip(blocks, found, strict=True):
        longest = chunk["times_ragged"].shape[2]
        assert longest <= 5  # of batch % 4 = 3, the longest there is
        expected = chunk_of(block, longest)
        for name, array in expected.items():
            assert chunk[name].dtype == array.dtype and np.array_equal(chunk[name], array), name


@given(ranges_of_batches)
@pytest.mark.complete
def test_no_batch_is_taken_twice(chunks):
    """The choice among overlapping chunks against counting batch by batch."""
    batches = sorted({batch for chunk in chunks for batch in chunk})
    taken = [batch for piece, home in chosen(chunks) for batch in piece if batch in home and home in chunks]
    assert taken == batches == [batch for chunk in merged(chunks) for batch in chunk]
    block = range(7, 29)
    inside = [batch for piece, home in pieces_of(block, chosen(chunks)) for batch in piece if batch in home]
    assert inside == [batch for batch in batches if batch in block]


def test_ctrl_c_in_the_middle_of_a_part_is_ctrl_c(path, monkeypatch, capsys):
    """Between an archive's opening of an entry and its use: the archive, which cannot be closed then, is not heard."""
    opening = zipfile.ZipFile.open

    def interrupted(archive, name, *choices, **more):
        entry = opening(archive, name, *choices, **more)
        if str(name).startswith("raw"):
            raise KeyboardInterrupt
        return entry

    with opened(path) as folder:
        monkeypatch.setattr(zipfile.ZipFile, "open", interrupted)
        with pytest.raises(KeyboardInterrupt):
            folder.keep(range(0, 5), chunk_of(range(0, 5)), 0.1)
        monkeypatch.undo()
        assert folder.done() == []
        assert not list((path / "parts").iterdir())
    gc.collect()
    assert capsys.readouterr().err == ""


def test_every_damage_is_seen(tmp_path):
    """Each byte of a chunk changed, and each length it may be cut to: the numbers are right, or it is told."""
    batches = range(3, 5)
    numbers = {"raw": chunk_of(batches)["raw"][:, :1, :2]}
    write_chunk(tmp_path, batches, numbers, "study")
    file = tmp_path / chunk_name(batches)
    sound, found = file.read_bytes(), 0
    damaged = [sound[:place] + bytes([sound[place] ^ 0x41]) + sound[place + 1 :] for place in range(len(sound))]
    for raw in [*damaged, *(sound[:length] for length in range(0, len(sound), 7)), sound + b"more"]:
        file.write_bytes(raw)
        try:
            read, chunk = read_chunk(file, "study")
        except Damaged:
            found += 1
            continue
        assert read == batches and np.array_equal(chunk["raw"], numbers["raw"])  # a time, say, that nobody reads
    assert found > 0.7 * len(sound)  # measured 0.86 of the bytes; the others are the archive's dates and rights
    file.write_bytes(sound)
    assert "another study" in refusal(read_chunk, file, "other", kind=Damaged)
    assert "its name states other batches" in refusal(
        read_chunk, file.rename(tmp_path / chunk_name(range(4, 6))), "study", kind=Damaged
    )


def test_damaged_parts_are_removed_and_told_and_only_where_nobody_else_writes(path):
    begun(path, range(0, 10), range(10, 20), range(20, 30))
    torn = path / "parts" / chunk_name(range(10, 20))
    torn.write_bytes(torn.read_bytes()[:-40])
    aside = path / "parts" / f".{chunk_name(range(30, 40))}.elsewhere.123.partial"
    aside.write_bytes(b"half")
    (path / ".study.json.elsewhere.123.partial").write_bytes(b"half")
    mine = path / "parts" / "notes.partial"
    mine.write_text("my own", encoding="utf-8")
    with opened(path, shared=True) as folder:
        assert folder.done() == [range(0, 10), range(20, 30)]
        assert torn.exists() and aside.exists()
    with opened(path) as folder:
        assert folder.done() == [range(0, 10), range(20, 30)]
        assert not torn.exists() and not aside.exists() and mine.exists()
        whole = path / "parts" / chunk_name(range(0, 10))
        whole.write_bytes(b"changed while it runs")
        with pytest.raises(PoundingError, match=r"was damaged since: .*; run the same command again"):
            list(folder.chunks([range(0, 10)]))
        assert folder.done() == [range(20, 30)]
    removed = [line["file"] for line in read_lines(path / "log.jsonl") if line["event"] == "removed"]
    assert removed == [".study.json.elsewhere.123.partial", aside.name, torn.name, whole.name]


def test_another_identity_is_refused_with_every_difference(path, says):
    begun(path, range(0, 10))
    says(refusal(opened, path, OTHER))
    assert found(path) == [range(0, 10)]
    with opened(path, OTHER, new=True) as folder:
        assert folder.done() == [] and events(path) == ["begin", "start"]
    with opened(path) as folder:  # nothing was kept, so nothing is lost
        assert read_study(path)["identity"] == IDENTITY


def test_new_discards_the_same_study_and_nothing_that_is_not_ours(path):
    begun(path, range(0, 10))
    mine = [path / "notes.txt", path / "parts" / "figure.npz"]
    for file in mine:
        file.write_text("my own", encoding="utf-8")
    with opened(path, new=True) as folder:
        assert folder.done() == []
        folder.clear()
    assert [file.read_text(encoding="utf-8") for file in mine] == ["my own"] * 2


@pytest.mark.parametrize(
    "names", [["thesis.tex"], ["parts"], ["lock", "data.csv"], ["study.json"], ["log.jsonl"]], ids=" and ".join
)
def test_a_folder_of_the_users_own_is_never_touched(path, names, says):
    path.mkdir()
    for name in names:
        (path / name).write_text('{"mine": 1}', encoding="utf-8")
    says([refusal(opened, path, new=new) for new in (False, True)])
    assert sorted(entry.name for entry in path.iterdir()) == sorted(names)
    assert all((path / name).read_text(encoding="utf-8") == '{"mine": 1}' for name in names)


def test_a_file_or_no_folder_above_is_refused(path, says):
    path.write_text("a file", encoding="utf-8")
    says(refusal(opened, path), refusal(opened, path.parent / "missing" / "results.study"))


def test_a_study_that_was_killed_as_it_began_begins_again(path):
    path.mkdir()
    (path / "lock").write_text("", encoding="utf-8")
    (path / ".study.json.here.12.partial").write_text("{", encoding="utf-8")
    with opened(path) as folder:
        keep(folder, range(0, 10))
        assert folder.done() == [range(0, 10)]
    assert not list(path.glob("*.partial"))


def test_half_a_line_of_the_log_hurts_nothing(path):
    """As a process leaves it that is killed while it writes."""
    with opened(path):
        pass
    log = path / "log.jsonl"
    whole = log.read_bytes()
    for length in (len(whole) - 1, len(whole) - 5, len(whole) - 60):
        log.write_bytes(whole[:length])
        write_line(log, "after")
        write_line(log, "again")
        assert events(path)[-2:] == ["after", "again"]
    log.write_bytes(b'\n[1]\nnonsense\n{"event": 1}\n\xff\n')
    assert events(path) == []


LOOP = """
import random
import numpy as np
from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint
folder = Checkpoint.open({path!r}, {identity}, About(10**6, 3))
print("open", flush=True)
dice = random.Random({seed})
folder.done()
while True:
    start = dice.randrange(10**5)
    batches = range(start, start + dice.randrange(1, 400))
    folder.keep(batches, {{"raw": np.random.random((len(batches), 3, 20))}}, 0.0)
    print(batches.start, batches.stop, flush=True)
"""


def child(code: str, **names: object) -> subprocess.Popen[str]:
    """A process that runs this code with this very package."""
    return python("-c", code.format(tests=str(Path(__file__).parents[1]), **names))


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.complete)])
@pytest.mark.skipif(os.name != "posix", reason="kill -9 is of POSIX systems")
def test_a_kill_at_any_moment_loses_nothing_that_was_kept(path, kills):
    """Every file under a chunk's name is whole, and whatever `keep` has returned from is found."""
    dice, told, asides = random.Random(8), set(), 0
    for seed in range(kills):
        process = child(LOOP, path=str(path), identity=IDENTITY, seed=seed)
        assert process.stdout.readline() == "open\n", process.stderr.read()
        # So many chunks however slow the machine, and then any moment of writing another.
        first = [process.stdout.readline() for _ in range(seed % 5)]
        time.sleep(dice.uniform(0.0, 0.02))
        process.send_signal(signal.SIGKILL)
        rest, errors = process.communicate(timeout=60)
        assert (process.returncode, errors) == (-signal.SIGKILL, "")
        whole = rest.splitlines() if rest.endswith("\n") else rest.splitlines()[:-1]
        told |= {range(*map(int, line.split())) for line in (*first, *whole)}
        asides += len(list((path / "parts").glob("*.partial")))
        files = [entry.name for entry in (path / "parts").iterdir() if not entry.name.endswith(".partial")]
        with opened(path) as folder:
            done = folder.done()
            for batches in map(batches_of, files):
                assert read_chunk(path / "parts" / chunk_name(batches), folder._digest)[0] == batches
        assert told <= set(map(batches_of, files))
        assert merged([*done, *told]) == done
        assert not list((path / "parts").glob("*.partial"))
    assert len(told) >= sum(seed % 5 for seed in range(kills))  # no two of these seeds begin on one batch
    assert "removed" not in events(path) or asides > 0


OPENER = """
import sys
from pathlib import Path
from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint
sys.path[:0] = [{tests!r}, {tests!r} + "/ensemble"]
from test_checkpoint import ABOUT, IDENTITY, keep
folder = Checkpoint.open(Path("{path}"), IDENTITY, ABOUT, shared={shared})
keep(folder, range(*{batches}))
print("open", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def others() -> Iterator[list[subprocess.Popen[str]]]:
    """Processes that end with the test."""
    found: list[subprocess.Popen[str]] = []
    yield found
    for process in found:
        process.kill()
        process.communicate()


def holder(others: list, path: Path, shared: bool, batches: tuple[int, int]) -> subprocess.Popen[str]:
    """Another process that has the folder open, and has kept some batches."""
    others.append(child(OPENER, path=path, shared=shared, batches=batches))
    assert others[-1].stdout.readline() == "open\n"
    return others[-1]


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
@pytest.mark.complete
def test_a_second_start_is_refused_and_told_who_runs(path, others):
    first = holder(others, path, False, (0, 10))
    for choices in ({}, {"new": True}):
        assert f"(pid {first.pid}), since 2" in refusal(opened, path, **choices)
    first.kill()  # the system lets go of a lock whose process was killed
    first.wait()
    assert found(path) == [range(0, 10)]


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
def test_shards_share_a_folder_and_nobody_takes_it_from_them(path, others):
    holder(others, path, True, (0, 10))
    with opened(path, shared=True) as folder:
        keep(folder, range(50, 60))
        assert folder.done() == [range(0, 10), range(50, 60)]
        with pytest.raises(PoundingError, match=r"another run is writing this study: .* and "):
            opened(path)
    assert "other runs are writing this study here" in refusal(opened, path, shared=True, new=True)
    with pytest.raises(PoundingError, match=r'writing another study here(.|\n)*was "20 mm", is "25 mm"'):
        opened(path, OTHER, shared=True)
    others[0].kill()
    others[0].wait()
    assert found(path) == [range(0, 10), range(50, 60)]


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
@pytest.mark.complete
def test_shards_that_start_at_once_share_a_new_folder(path, others):
    """As a batch system starts them: one begins the study, and the others wait for it and find it."""
    for first in (0, 10, 20):
        others.append(child(OPENER, path=path, shared=True, batches=(first, first + 10)))
    assert [process.stdout.readline() for process in others] == ["open\n"] * 3
    assert found(path, shared=True) == [range(0, 30)]
    assert events(path).count("begin") == 1


@pytest.mark.skipif(os.name != "posix", reason="without flock there is no lock")
def test_who_asks_for_the_state_refuses_nobody(path):
    """Asking takes the lock for an instant; starts in between, alone and shared, only wait for it."""
    over = threading.Event()

    def ask() -> None:
        while not over.is_set():
            pounding_risk.status(path)

    asking = threading.Thread(target=ask)
    asking.start()
    try:
        for shared in (False, True) * 20:
            with opened(path, shared=shared):
                pass
    finally:
        over.set()
        asking.join()


def test_a_full_disk_is_told_and_the_study_goes_on_after_it(small_disk):
    path = small_disk / "results.study"
    filling = small_disk / "other.bin"
    filling.write_bytes(bytes(200_000))
    large = {"raw": np.ones((10, 3, 100))}  # 24 kB
    with opened(path) as folder:
        with pytest.raises(PoundingError) as full:
            for start in range(0, 100, 10):
                folder.keep(range(start, start + 10), large, 0.1)
        kept = folder.done()
        cases = 3 * sum(map(len, kept))
        assert 0 < cases < 300
        assert str(full.value) == (
            f"{path}: no space is left there (No space left on device); {cases} of 300 cases are kept; "
            "free space and run the same command again"
        )
        assert not list(path.rglob("*.partial"))
        with suppress(OSError):
            (small_disk / "rest.bin").write_bytes(bytes(100_000))
        folder.log("a line that finds no space" + 5000 * ".")
    (small_disk / "rest.bin").unlink()
    filling.unlink()
    with opened(path) as folder:
        assert folder.done() == kept
        folder.keep(range(90, 100), large, 0.1)
        assert folder.done() == [*kept, range(90, 100)]


def test_the_state_of_a_study_on_a_disk_that_is_only_read(small_disk):
    begun(small_disk / "results.study", range(0, 10))
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    assert status(small_disk / "results.nc").state == STOPPED


def test_after_new_the_same_command_would_discard_what_is_kept(small_disk):
    with opened(small_disk / "results.study", new=True) as folder:
        assert "run the same command without --new again" in refusal(
            folder.keep, range(0, 100), {"raw": np.ones((100, 3, 1000))}, 0.1
        )
        # As many as there are files, whether or not anybody has looked into them yet.
        assert folder.kept() == "0 of 300 cases"


def test_no_space_to_begin_is_told(small_disk):
    with suppress(OSError), open(small_disk / "other.bin", "wb") as file:
        while True:
            file.write(bytes(4096))
            file.flush()
    with pytest.raises(PoundingError, match=r"no space is left there .*; free space and run the same command again"):
        opened(small_disk / "results.study")


LIMITED = """
import resource, sys
sys.path[:0] = [{tests!r}, {tests!r} + "/ensemble"]
from pathlib import Path
from test_checkpoint import opened, keep, chunk_of
from pounding_risk.errors import PoundingError
folder = opened(Path({path!r}))
keep(folder, range(0, 5))
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
try:
    keep(folder, range(5, 100))
except PoundingError as error:
    print(error)
print(folder.done())
"""


@pytest.mark.skipif(os.name != "posix", reason="limits on files are of POSIX systems")
@pytest.mark.complete
def test_a_limit_on_files_is_told_as_what_it_is(path, says):
    """A real refusal of the system in the middle of a write, where no file system can be mounted either."""
    out, err = child(LIMITED, path=str(path)).communicate(timeout=60)
    assert err == ""
    says(out)
    assert not list(path.rglob("*.partial"))


@pytest.mark.parametrize("name", ["lock", "log.jsonl", "study.json", "parts"])
def test_a_link_in_a_study_s_folder_is_not_followed(path, tmp_path, name):
    """A lock was emptied when it was taken, whatever it led to."""
    victim = tmp_path / "victim"
    if name == "parts":
        victim.mkdir()
        (victim / chunk_name(range(0, 5))).write_text("precious")
    else:
        victim.write_text("precious")
    begun(path, range(0, 5))
    target = path / name
    shutil.rmtree(target) if target.is_dir() else target.unlink()
    target.symlink_to(victim)
    for new in (False, True):
        with pytest.raises(PoundingError, match=f"{name} in it is a symbolic link.*; nothing was touched: remove"):
            opened(path, new=new)
    with suppress(PoundingError):  # it may tell what it can, and change nothing
        status(path)
    assert target.is_symlink()
    kept = victim / chunk_name(range(0, 5)) if name == "parts" else victim
    assert kept.read_text() == "precious"


def test_a_lock_or_log_that_becomes_a_link_is_not_followed(path, tmp_path):
    """Between the look into the folder and the opening."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    path.mkdir()
    for name in ("lock", "log.jsonl"):
        (path / name).symlink_to(victim)
    with pytest.raises(OSError):
        Lock(path / "lock")
    write_line(path / "log.jsonl", "event")
    assert victim.read_text() == "precious"


def test_a_part_that_is_a_link_is_removed_and_told(path, tmp_path):
    begun(path, range(0, 10))
    chunk = path / "parts" / chunk_name(range(0, 10))
    victim = chunk.rename(tmp_path / "victim.npz")
    chunk.symlink_to(victim)
    assert found(path) == []
    assert not chunk.is_symlink() and victim.stat().st_size > 0
    assert "it is a symbolic link" in (path / "log.jsonl").read_text()


def test_a_study_of_another_version_is_left_as_it_is(path):
    begun(path, range(0, 10))
    file = path / "study.json"
    found = json.loads(file.read_text(encoding="utf-8"))
    for text in (json.dumps({**found, "format": "pounding_risk study 99"}), "{", "[]"):
        file.write_text(text, encoding="utf-8")
        assert "is not a study of this version of pounding-risk" in refusal(opened, path, new=True)
    assert len(list((path / "parts").iterdir())) == 1
