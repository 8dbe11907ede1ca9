"""Chunks, threads and Ctrl-C: every batch once, the same bits in any chunk, nothing lost by an end at any moment."""

import json
import os
import signal
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from chunked_work import SCENE, Interrupted, Kept, Numbers, ScanInput, full_disk, pending_of, scanned
from hypothesis import given
from hypothesis import strategies as st
from processes import output, python
from scenes import scene_text, single
from sentences import refusal

from pounding_risk import cli
from pounding_risk.ensemble import scan as ensemble
from pounding_risk.ensemble import threads
from pounding_risk.ensemble.scan import scan_shard
from pounding_risk.ensemble.status import status
from pounding_risk.ensemble.threads import (
    CHUNK_BYTES,
    PIECE,
    ROUNDS,
    SECONDS,
    Pending,
    Threads,
    read_shard,
    shard_batches,
    solve_for,
)
from pounding_risk.errors import PoundingError, Stopped
from pounding_risk.results.store import Netcdf
from pounding_risk.scene.reader import parse_scene

# A weak motion that closes no gap and is done at once; then lines of 10,000 runs of a stiff pair over 150 s, each of
# them one compiled call that takes the better part of a minute.
LONG = scene_text(
    single("left", "500 t", "0.1 s"),
    single("right", "800 t", "0.06 s"),
    name="stopped",
    law="viscous_elastoplastic",
    gap=None,
    records={"names": ["CCC-HN1"]},
    grid={
        "gap": ["0.02 mm", "0.03 mm", "0.04 mm"],
        "pga": ["0.001 g", "0.5 g"],
        "yield_force": {"start": "10 kN", "stop": "20 kN", "num": 10000},
    },
    solver={"rtol": 1e-11},
)


def events(folder: Path) -> list[str]:
    log = folder / "r.study" / "log.jsonl"
    return [json.loads(line)["event"] for line in log.read_text().splitlines()] if log.exists() else []


@pytest.mark.complete
def test_ctrl_c_waits_for_no_kernel_and_keeps_what_is_done_and_the_old_file(tmp_path):
    (tmp_path / "scene.toml").write_text(LONG)
    (tmp_path / "r.nc").write_bytes(b"the results of yesterday")
    words = ["scan", "scene.toml", "-o", "r.nc", "--new", "--no-screening", "--workers", "2"]
    child = python("-m", "pounding_risk", *words, cwd=tmp_path)
    try:
        limit = time.monotonic() + 300.0
        while events(tmp_path).count("kept") < 2 and child.poll() is None and time.monotonic() < limit:
            time.sleep(0.05)
        time.sleep(0.5)  # both threads are in kernels by then
        child.send_signal(signal.SIGINT)
        # The kernels under way take far longer than this.
        out, err = child.communicate(timeout=20.0)
    finally:
        child.kill()
    assert (child.returncode, out) == (130, ""), err
    assert events(tmp_path)[-1] == "stop"
    told = status(tmp_path / "r.nc")
    assert told.state == "stopped" and 0 < told.cases < told.total
    kept = f"{told.cases} of {told.total} cases are kept in r.study; the same command without --new goes on from there"
    assert err.splitlines()[-1] == f"pounding-risk: stopped by Ctrl-C; {kept}"
    assert "Traceback" not in err
    assert (tmp_path / "r.nc").read_bytes() == b"the results of yesterday"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.nc", "r.study", "scene.toml"]


def test_ctrl_c_before_a_command_is_reached_shows_no_traceback(monkeypatch):
    """While typer still builds the commands, which takes some tenths of a second."""

    def interrupted(**_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "app", interrupted)
    monkeypatch.setattr(cli, "_block_imports", lambda words: None)  # other tests need Dask
    monkeypatch.setattr(cli, "_exit_past_threads", lambda end: None)  # other tests' threads may live here
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 130


SCRIPT = Path(__file__).parents[1] / "killed_scans.py"


@pytest.mark.complete
def test_a_killed_scan_ends_in_the_file_of_one_that_nobody_disturbed(tmp_path):
    """Fifty kills at random moments of five studies.

    Bit-identical each time, with one to four threads, and at no moment a partial file under the final name.
    """
    if not hasattr(os, "fork"):
        pytest.skip("SIGKILL and fork are POSIX")
    told = json.loads(output(SCRIPT, tmp_path, 5, 50, 20110314, timeout=600))
    assert told["wrong"] == []
    assert told["kills"] >= 50 and told["studies"] >= 5


class Timed(Numbers):
    """A job on a clock of its own: ``cost`` tells the seconds of a batch."""

    def __init__(self, scan_input, cost, monkeypatch):
        super().__init__(scan_input)
        self.cost, self.now = cost, 0.0
        monkeypatch.setattr(threads, "perf_counter", lambda: self.now)

    def solve(self, batches, stop):
        self.now += sum(map(self.cost, batches))
        return super().solve(batches, stop)


def drained(job, pieces=None, **more):
    """Chunks as one worker solves them: (batches, seconds)."""
    pending, chunks = pending_of(job, pieces, **more), []
    while not pending.is_done:
        handed = pending.next()
        solved = solve_for(job, handed, lambda: False, pending.mean)
        assert len(solved.chunk["value"]) == len(solved.batches)
        pending.took(handed, solved.batches, solved.seconds)
        chunks.append((solved.batches, solved.seconds))
    assert pending.left == 0
    return chunks


def serial(scan_input):
    """Every batch alone, one after the other."""
    kept = Kept(scan_input.batches)
    job = Numbers(scan_input)
    for batch in range(scan_input.batches):
        kept(range(batch, batch + 1), job.solve(range(batch, batch + 1), lambda: False), 1.0)
    return kept.value


@given(
    batches=st.integers(1, 300),
    laws=st.integers(1, 5),
    run=st.integers(1, 40),
    workers=st.integers(1, 6),
    length=st.none() | st.integers(1, 400),
    cost=st.floats(0.0, 3.0),
    data=st.data(),
)
@pytest.mark.complete
def test_every_batch_is_solved_once(batches, laws, run, workers, length, cost, data):
    """Whatever comes back when, in whole or in part: chunks are apart, and together what was asked for."""
    job = Numbers(ScanInput(batches, laws, run))
    first = data.draw(st.integers(0, batches))
    last = data.draw(st.integers(first, batches))
    pieces = [range(last, batches), range(0, first)]  # out of order, with a hole
    pending = pending_of(job, pieces, length=length)
    pending.shared_by(workers)
    out, found, begun, ready = [], [], set(), set()
    while not pending.is_done:
        handed = pending.next() if len(out) < workers else None
        if handed is not None:
            assert len(handed) > 0
            needs = {job.law_at(batch) for batch in handed}
            assert needs <= ready or (len(handed) == 1 and not needs & begun), "two compile one law"
            assert length is None or len(handed) <= length
            begun |= needs
            out.append(handed)
            continue
        handed = out.pop(data.draw(st.integers(0, len(out) - 1)))
        solved = handed[: data.draw(st.integers(1, len(handed)))]
        pending.took(handed, solved, cost * len(solved))
        ready |= {job.law_at(batch) for batch in solved}
        found += solved
    assert not out and sorted(found) == [*range(first), *range(last, batches)]
    assert pending.next() is None


def test_a_chunk_ends_after_half_a_second(monkeypatch):
    """By the clock: the first batch, which compiles, is alone; then chunks take what was asked for, until the end."""
    cost = 0.01
    job = Timed(ScanInput(batches=4000, laws=1), lambda batch: 30.0 if batch == 0 else cost, monkeypatch)
    chunks = drained(job)
    sized = SECONDS / cost
    lengths = [len(batches) for batches, _ in chunks]
    assert lengths[0] == 1
    assert lengths[1:-8] == pytest.approx([sized] * len(lengths[1:-8]), abs=1)
    assert max(lengths) <= sized
    assert min(lengths[1:-1]) >= PIECE / cost - 1
    assert sum(lengths[-4:]) < 4 * sized, "chunks shrink towards the end"


def test_small_gaps_do_not_make_a_long_chunk(monkeypatch):
    """Batches cost 40 times less along each run of gaps; a chunk keeps below a few times what was asked for."""
    job = Timed(ScanInput(batches=5000, laws=1, run=50), lambda at: 0.08 if at % 50 < 10 else 0.002, monkeypatch)
    took = [seconds for _, seconds in drained(job)]
    assert max(took) <= 2.0  # a piece of 50 cheap batches, and then one with ten costly ones
    assert np.mean(took[8:-8]) == pytest.approx(SECONDS, rel=0.35)


def test_a_batch_that_takes_long_is_a_chunk(monkeypatch):
    took = drained(Timed(ScanInput(batches=40, laws=2), lambda batch: 5.0, monkeypatch))
    assert {len(batches) for batches, _ in took} == {1}


def test_a_chunk_is_no_larger_than_memory_allows():
    pending = Pending([range(10_000)], lambda batch: 0, bytes_per_batch=int(CHUNK_BYTES // 7))
    lengths = []
    while (handed := pending.next()) is not None:
        lengths.append(len(handed))
        pending.took(handed, handed, 1e-6)
    assert max(lengths) == 7


def test_laws_that_take_turns_make_chunks_of_one_duration(monkeypatch):
    """Two laws by turns, one twenty times dearer."""
    scan_input = ScanInput(batches=20_000, laws=2, run=25)
    job = Timed(scan_input, lambda batch: 0.004 if batch // 25 % 2 else 0.0002, monkeypatch)
    # Whole runs of both laws: one run more or less is 25 × 4 ms.
    assert [seconds for _, seconds in drained(job)][-40:-15] == pytest.approx([SECONDS] * 25, abs=0.15)


def test_a_chunk_spans_laws_but_not_holes():
    job = Numbers(ScanInput(batches=400, laws=4, run=5))
    chunks = [batches for batches, _ in drained(job, length=64)]
    assert max(len({job.law_at(batch) for batch in batches}) for batches in chunks) == 4
    pieces = [range(0, 50), range(60, 90)]
    apart = [batches for batches, _ in drained(job, pieces, length=64)]
    assert all(batches.stop <= 50 or batches.start >= 60 for batches in apart)


@pytest.mark.parametrize(("workers", "length"), [(1, None), (1, 5000), (2, 1), (2, None), (4, 1), (4, 7)])
def test_threads_give_the_same_bits(workers, length):
    scan_input = ScanInput(batches=500, laws=3)
    job, kept = Numbers(scan_input), Kept(scan_input.batches)
    Threads(workers).run(job, pending_of(job, length=length), kept)
    assert np.array_equal(kept.value, serial(scan_input))
    assert (kept.times == 1).all()
    assert length is None or max(map(len, kept.chunks)) <= length


@pytest.fixture(scope="module")
def in_one_go():
    """A real scan: all batches but the first of each law in one chunk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ensemble, "Pending", partial(Pending, length=10_000))
        return scanned(workers=1)


@pytest.mark.parametrize(("workers", "length"), [(1, 1), (2, None), (2, 5), (4, 3)])
def test_a_scan_has_the_same_bits_on_any_threads_in_any_chunks(in_one_go, monkeypatch, workers, length):
    assert int(in_one_go["simulated"].sum()) > 40
    assert int((in_one_go["sensitive"] >= 0).sum()) > 10
    monkeypatch.setattr(ensemble, "Pending", partial(Pending, length=length))
    assert scanned(workers=workers).identical(in_one_go)


def test_a_scan_has_the_same_bits_in_shards(in_one_go, tmp_path):
    """Three shards, the last first, and a scan that puts them together: the very bytes of a scan in one go."""
    whole, sharded = tmp_path / "whole.nc", tmp_path / "sharded.nc"
    scanned(out=whole)
    study = parse_scene(SCENE)
    for number in (3, 1, 2):
        assert not sharded.exists()
        found = scan_shard(study, sharded, f"{number}/3", check_fraction=0.25)
    assert found[1] == in_one_go["status"].size
    told = []
    assert scanned(out=sharded, progress=lambda *counts: told.append(counts)).identical(in_one_go)
    assert told == [(found[1], found[1])], "nothing is left to solve"
    assert sharded.read_bytes() == whole.read_bytes()


@pytest.mark.parametrize(("new", "again"), [(False, "the same command"), (True, "the same command without --new")])
def test_ctrl_c_while_results_are_written_says_what_is_kept(in_one_go, monkeypatch, tmp_path, new, again):
    """All is solved by then; and after --new the same command would throw it away."""
    target, cases = tmp_path / "r.nc", in_one_go["status"].size

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Netcdf, "finish", interrupted)
        told = refusal(scanned, out=target, new=new, kind=Stopped)
    assert told == f"{cases} of {cases} cases are kept in {tmp_path / 'r.study'}; {again} goes on from there"
    assert [path.name for path in tmp_path.iterdir()] == ["r.study"]
    told = []
    scanned(out=target, progress=lambda *counts: told.append(counts))
    assert told == [(cases, cases)] and target.exists()


def test_no_law_compiles_on_two_threads():
    """Other laws go on meanwhile."""
    begun, over = [], []
    scan_input = ScanInput(batches=60, laws=3, run=10)

    class Compiling(Numbers):
        def solve(self, batches, stop):
            law = self.law_at(batches.start)
            if law not in begun:
                assert len(batches) == 1
                begun.append(law)
                time.sleep(0.05)
                over.append(law)
            assert {self.law_at(batch) for batch in batches} <= set(over), "solved while it compiles elsewhere"
            return super().solve(batches, stop)

    job, kept = Compiling(scan_input), Kept(scan_input.batches)
    Threads(4).run(job, pending_of(job), kept)
    assert np.array_equal(kept.value, serial(scan_input))


def test_parts_are_kept_by_the_caller_and_do_not_pile_up():
    scan_input, alive = ScanInput(batches=200, laws=1), []

    class Counted(Numbers):
        def solve(self, batches, stop):
            alive.append(1)
            return super().solve(batches, stop)

    def keep(batches, part, seconds):
        assert threading.current_thread() is threading.main_thread()
        time.sleep(0.002)  # a slow disk
        most.append(len(alive))
        alive.pop()

    most: list[int] = []
    job = Counted(scan_input)
    Threads(2).run(job, pending_of(job, length=1), keep)
    assert len(most) == 200
    assert max(most) <= 5  # two threads, twice as many parts, and the one in hand


def test_nothing_to_do_is_done():
    job, kept = Numbers(ScanInput()), Kept(1000)
    Threads(2).run(job, pending_of(job, []), kept)
    assert kept.chunks == []


def test_what_a_line_raises_reaches_the_caller_with_its_place():
    scan_input = ScanInput(batches=400, fault=200, seconds=1e-4)
    job, kept = Numbers(scan_input), Kept(scan_input.batches)
    with pytest.raises(PoundingError, match="batch 200 cannot be solved") as error:
        Threads(2).run(job, pending_of(job, length=10), kept)
    assert error.traceback[-1].name == "solve"
    assert 0 < kept.times.sum() < 400, "what was done is kept, the rest is left"


def test_a_full_disk_stops_the_threads():
    scan_input = ScanInput(batches=400, seconds=1e-4)
    job = Numbers(scan_input)
    before = set(threading.enumerate())  # threads of other tests may be ending meanwhile
    assert "no space" in refusal(Threads(2).run, job, pending_of(job, length=10), full_disk)
    for _ in range(100):
        if not (left := set(threading.enumerate()) - before):
            break
        time.sleep(0.02)
    assert not left, "threads go on"


def test_what_is_finished_is_kept_when_a_run_is_interrupted():
    """Also the part in hand, once more, and those that wait behind it."""
    scan_input = ScanInput(batches=300, laws=1)
    job, kept = Numbers(scan_input), Interrupted(scan_input.batches, pause=0.1)  # until there is no room
    with pytest.raises(KeyboardInterrupt):
        Threads(2).run(job, pending_of(job, length=10), kept)
    assert kept.tries[2] == kept.tries[3]
    assert len(kept.chunks) >= 2 + 5  # room for two threads is five
    found = kept.times > 0
    assert np.array_equal(kept.value[found], serial(scan_input)[found])


IN_A_KERNEL = r"""
import sys, time
import numba
import numpy as np
from pounding_risk.ensemble.threads import Pending, Threads

@numba.njit(nogil=True)
def spin(rounds):
    x = 0.5
    for _ in range(rounds):
        x = 3.9 * x * (1.0 - x)
    return x

spin(1)  # compiled

class Job:
    scan_input = None
    def solve(self, batches, stop):
        sys.stdout.write("in\n")  # one write: two threads do this at once
        sys.stdout.flush()
        spin(60_000_000_000)  # minutes
        return {}

try:
    Threads(2).run(Job(), Pending([range(4)], lambda batch: batch % 2), print)
except KeyboardInterrupt:
    print("stopped", flush=True)
    sys.exit(130)
"""


@pytest.mark.complete
def test_an_interrupt_does_not_wait_for_a_kernel():
    """A process with minutes of work in two kernels is gone at Ctrl-C, in good order."""
    process = python("-c", IN_A_KERNEL)
    try:
        assert process.stdout.readline() == "in\n"
        time.sleep(0.3)  # from there into the kernel
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)  # the kernels need minutes
    finally:
        process.kill()
    assert (process.returncode, out.split()[-1], err) == (130, "stopped", "")


@pytest.mark.parametrize("count", [1, 2, 3, 7, 32])
@pytest.mark.parametrize("batches", [0, 1, 2, 31, 100, 13_200])
def test_shards_are_the_grid(batches, count):
    """Together every batch, apart from each other, and of nearly one size."""
    shards = [shard_batches(batches, (number, count)) for number in range(1, count + 1)]
    each = [[batch for piece in pieces for batch in piece] for pieces in shards]
    assert sorted(batch for one in each for batch in one) == list(range(batches))
    assert all(one == sorted(one) for one in each)
    assert all(pieces == sorted(pieces, key=lambda piece: piece.start) for pieces in shards)
    # No shard has more than a block more than another.
    assert max(map(len, each)) - min(map(len, each)) <= max(1, -(-batches // (count * ROUNDS)))


@pytest.mark.parametrize("gaps", [8, 20, 21, 50, 64])
@pytest.mark.parametrize("count", [2, 3, 8])
def test_shards_cost_alike_where_small_gaps_cost_more(gaps, count):
    """The cost of a batch falls with its gap, to nothing; shards differ by a sixth at most."""
    batches = gaps * 60
    work = [
        sum(
            max(0.0, 1.0 - 1.5 * (batch % gaps) / gaps)
            for piece in shard_batches(batches, (number, count))
            for batch in piece
        )
        for number in range(1, count + 1)
    ]
    assert max(work) / np.mean(work) < 7 / 6


def test_a_shard_is_read_and_refused_in_words(says):
    assert read_shard("2/8") == (2, 8)
    says([refusal(read_shard, text) for text in ("0/8", "9/8", "2", "1/0")])
    says(refusal(shard_batches, 10, (3, 2)), refusal(Threads, 0))
