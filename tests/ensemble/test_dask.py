"""A real cluster of two processes: the same bits, one input each, a worker killed without loss, and errors in words."""

import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from chunked_work import Interrupted, Kept, Numbers, ScanInput, full_disk, pending_of, scanned
from sentences import refusal

from pounding_risk.ensemble import dask as dask_executor
from pounding_risk.ensemble.dask import Dask
from pounding_risk.errors import PoundingError

distributed = pytest.importorskip("distributed")
complete = pytest.mark.complete  # all that starts a cluster

made: Counter[ScanInput] = Counter()  # on the workers


def counted(scan_input):
    """A job, and how often it was made in this process."""
    made[scan_input] += 1
    return Numbers(scan_input)


def times_made(scan_input):
    return made[scan_input]


@pytest.fixture(scope="module")
def client():
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=":0", silence_logs=50
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


def expected(scan_input):
    return Numbers(scan_input._replace(seconds=0.0)).solve(range(scan_input.batches), lambda: False)["value"]


def forgotten(client):
    """Whether the scheduler has nothing left to do within a while."""
    for _ in range(100):
        if not client.run_on_scheduler(lambda dask_scheduler: len(dask_scheduler.tasks)):
            return True
        time.sleep(0.05)
    return False


@complete
@pytest.mark.parametrize("length", [None, 1, 64])
def test_two_processes_give_the_same_bits(client, length):
    scan_input = ScanInput(batches=150, laws=3, seconds=1e-3, run=7)
    job, kept = Numbers(scan_input), Kept(scan_input.batches, scan_input.seconds)
    Dask(client, counted).run(job, pending_of(job, length=length), kept)
    assert np.array_equal(kept.value, expected(scan_input))
    assert (kept.times == 1).all()
    assert os.getpid() not in kept.processes
    assert len(kept.processes) == 2
    assert set(client.run(times_made, scan_input).values()) == {1}, "a job is made once in each process"
    assert forgotten(client)


@complete
def test_a_scan_has_the_same_bits_on_a_cluster(client, tmp_path):
    """In memory and, by way of a study's folder that this process alone writes, on disk."""
    here = scanned(workers=1)
    assert scanned(executor=Dask(client)).identical(here)
    assert scanned(executor=Dask(client), out=tmp_path / "far.nc").identical(here)
    scanned(out=tmp_path / "near.nc")
    assert (tmp_path / "far.nc").read_bytes() == (tmp_path / "near.nc").read_bytes()


@complete
def test_a_worker_killed_on_the_way_costs_nothing(client):
    """Also that which held the input: both are killed, one after the other, while chunks are under way."""
    scan_input = ScanInput(batches=160, laws=2, seconds=8e-3)
    job, kept = Numbers(scan_input), Kept(scan_input.batches, scan_input.seconds)
    victims = list(client.run(os.getpid).values())

    def keep(batches, part, seconds):
        kept(batches, part, seconds)
        if victims and len(kept.chunks) in (8, 14):
            os.kill(victims.pop(), signal.SIGKILL)

    Dask(client, counted).run(job, pending_of(job, length=4), keep)
    assert victims == []
    assert np.array_equal(kept.value, expected(scan_input))
    assert (kept.times == 1).all(), "no batch is kept twice"
    client.wait_for_workers(2, timeout=30)


@complete
def test_a_line_that_ends_every_worker_is_told(client):
    """After one worker here, as the next takes a second to start; Dask itself tries four."""

    def allow(failures, dask_scheduler):
        dask_scheduler.allowed_failures = failures

    client.run_on_scheduler(allow, 0)
    job, kept = Numbers(ScanInput(batches=60, laws=1, deadly=31)), Kept(60)
    try:
        with pytest.raises(PoundingError, match=r"ended 1 workers, one after.*more memory.*what is done is kept"):
            Dask(client, counted).run(job, pending_of(job, length=5), kept)
    finally:
        client.run_on_scheduler(allow, 3)
        client.wait_for_workers(2, timeout=60)
    assert kept.times[31] == 0


@complete
def test_an_interrupt_keeps_what_is_back_and_drops_the_rest(client):
    scan_input = ScanInput(batches=400, laws=1, seconds=2e-3)
    job, kept = Numbers(scan_input), Interrupted(scan_input.batches, scan_input.seconds, pause=0.3)
    with pytest.raises(KeyboardInterrupt):
        Dask(client, counted).run(job, pending_of(job, length=10), kept)
    assert kept.tries[2] == kept.tries[3], "the part in hand is kept"
    assert len(kept.chunks) > 3
    found = kept.times > 0
    assert np.array_equal(kept.value[found], expected(scan_input)[found])
    assert forgotten(client), "the scheduler goes on"


@complete
def test_what_a_user_can_repair_comes_back_as_it_is(client):
    job, kept = Numbers(ScanInput(batches=60, fault=31)), Kept(60)
    with pytest.raises(PoundingError, match=r"^batch 31 cannot be solved; leave it out$"):
        Dask(client, counted).run(job, pending_of(job, length=5), kept)
    blunder = Numbers(ScanInput(batches=60, blunder=31))
    with pytest.raises(ZeroDivisionError, match="batch 31"):
        Dask(client, counted).run(blunder, pending_of(blunder, length=5), kept)
    assert forgotten(client)


@complete
def test_a_disk_that_is_full_drops_the_rest(client):
    job = Numbers(ScanInput(batches=60))
    with pytest.raises(PoundingError, match="no space"):  # without its name, which would hold the chunks of the run
        Dask(client, counted).run(job, pending_of(job, length=5), full_disk)
    assert forgotten(client)


@complete
def test_workers_of_other_versions_are_refused(client, monkeypatch):
    """Those that are there before any chunk; those that come later, and sources that were edited, with the first."""
    job = Numbers(ScanInput(batches=20))
    cluster = Dask(client, counted)
    ours = dask_executor._versions()
    for name, value, words in (
        ("_versions", lambda: {**ours, "kernels": "edited"}, r"other numbers: kernels \w+ there, edited here; install"),
        ("_prepared", lambda job: "by another processor", r"other last digits: .*OPENBLAS_CORETYPE"),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(dask_executor, name, value)
            with pytest.raises(PoundingError, match=rf"worker tcp://127.*{words}"):
                cluster.run(job, pending_of(job), Kept(20))
    told = client.get_versions(packages=list(dask_executor.ALIKE))
    next(iter(told["workers"].values()))["packages"]["numba"] = "0.1"
    monkeypatch.setattr(client, "get_versions", lambda packages: told)
    assert re.search(r"numba 0\.1 there, \d[.\d]+ here", refusal(Dask, client, counted))


CLUSTER = """
import sys, time
from distributed import LocalCluster
if __name__ == "__main__":
    many = int(sys.argv[1])
    cluster = LocalCluster(
        n_workers=many, threads_per_worker=1, processes=False, host="127.0.0.1", protocol="tcp", dashboard_address=":0"
    )
    print(cluster.scheduler_address, flush=True)
    time.sleep(300)
"""


@pytest.fixture
def apart(root):
    """Starts a scheduler with some workers in a process of their own: its address, and the process."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(root), *map(str, Path(__file__).parents[:2])])}
    started = []

    def start(workers):
        process = subprocess.Popen(
            [sys.executable, "-c", CLUSTER, str(workers)], env=environment, stdout=subprocess.PIPE, text=True
        )
        started.append(process)
        return process.stdout.readline().strip(), process

    yield start
    for process in started:
        process.kill()
        process.communicate()


SLOW = ScanInput(batches=300, laws=1, seconds=2e-3)


def lost_after_five(cluster, lose, words):
    """What is kept of a run that loses its cluster after five chunks, and ends with these words."""
    job, kept = Numbers(SLOW), Kept(SLOW.batches, SLOW.seconds)

    def keep(batches, part, seconds):
        kept(batches, part, seconds)
        if len(kept.chunks) == 5:
            lose()

    try:
        with pytest.raises(PoundingError, match=words):
            cluster.run(job, pending_of(job, length=10), keep)
    finally:
        cluster.close()
    return kept


@complete
def test_a_scheduler_that_goes_away_is_told(apart):
    address, process = apart(1)
    words = r"scheduler was lost.*connection-lost.*what is done is kept; start the same command"
    kept = lost_after_five(Dask(address, counted), process.kill, words)
    found = kept.times > 0
    assert 41 <= found.sum() < 300  # the first batch alone, and four chunks
    assert np.array_equal(kept.value[found], expected(SLOW)[found])


@complete
def test_workers_that_are_all_gone_are_told(apart, monkeypatch):
    """Where somebody started them by hand nobody starts others: a scan that waits for ever helps no one."""
    address, _ = apart(1)
    cluster = Dask(address, counted)
    monkeypatch.setattr(dask_executor, "PATIENCE", 0.3)
    monkeypatch.setattr(dask_executor, "LOOK", 0.1)

    async def gone(dask_scheduler):
        for worker in list(dask_scheduler.workers):
            await dask_scheduler.remove_worker(worker, stimulus_id="gone")

    words = r"has had no workers for 0\.3 s: .*start some again; what is done is kept"
    lost_after_five(cluster, lambda: cluster._client.run_on_scheduler(gone), words)


@complete
def test_a_scheduler_without_workers_is_told(apart, monkeypatch):
    monkeypatch.setattr(dask_executor, "PATIENCE", 0.3)
    address, _ = apart(0)
    with pytest.raises(PoundingError, match=rf"has no workers after 0\.3 s; start some with `dask worker {address}`"):
        Dask(address)


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setattr(dask_executor, "CONNECT", 0.3)
    with pytest.raises(PoundingError, match=r'no Dask scheduler answers at "tcp://127.0.0.1:9" .*`dask scheduler`'):
        Dask("tcp://127.0.0.1:9")  # the port of a service that nobody runs
    assert 'answers at "nowhere"' in refusal(Dask, "nowhere")


def test_a_missing_extra_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'pounding-risk[cluster]'" in refusal(Dask, "tcp://127.0.0.1:8786")


def test_an_address_that_is_none_is_told_before_a_client_is_made(monkeypatch):
    """A client of no address cannot be closed: it printed a traceback, after 20 s."""
    monkeypatch.setattr(distributed, "Client", None)
    assert 'no Dask scheduler answers at "head" (missing port number' in refusal(Dask, "head")
