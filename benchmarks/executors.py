"""Time that chunks, threads, shards, the journal and a Dask cluster cost: ``python benchmarks/executors.py``.

One grid through the public `scan` by every way of solving it, in turns, so that a busy machine slows all of them alike;
medians of the repeats. The pair of T 0.5 and 1.0 s, 500 and 800 t, ζ 5 %, β 2.75e9 N/m^1.5, e 0.65, no runs made again:

- 20,000 cases: El Centro (RSN6-180, 53.7 s) at five amplitudes and both polarities, 2 laws, 50 gaps, 20 yield forces;
- ``--far-field``, 264,000 cases: the 44 components of the FEMA P-695 far-field set, 6 laws, 50 gaps, 20 yield forces.

``solving`` is what the executor takes, from the first chunk to the last part kept; ``in all`` adds records, responses
without contact and the dataset; ``processor`` is the solving's over all threads of this process, which other processes
of the machine disturb less. "In one call" is a single thread that solves the whole grid without any chunks. Kernels
are compiled, and the cluster is started and has loaded them, before.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.ensemble.job import never
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.ensemble.threads import Executor, Threads
from pounding_risk.results.summary import counted
from pounding_risk.scene.scene import scene_of

PROCESSES, SHARDS = 2, 3
LAWS = ("jankowski", "viscous_elastoplastic")
MORE_LAWS = ("hertz", "hertz_damp", "hertz_damp_exact", "jankowski", "van_mier", "viscous_elastoplastic")
BESIDE = "2 threads"  # what ratios are of


class Spent(NamedTuple):
    """Seconds of one scan."""

    whole: float
    solving: float
    processor: float  # of it, all threads of this process
    chunks: int


class Timed:
    """An executor that measures its time."""

    def __init__(self, executor: Executor):
        self.executor, self.seconds, self.processor, self.chunks = executor, 0.0, 0.0, 0

    def run(self, job: Any, pending: Any, keep: Any) -> None:
        """Run the job with the executor and add the time."""

        def kept(*found: Any) -> None:
            self.chunks += 1
            keep(*found)

        start, spent = time.perf_counter(), time.process_time()
        self.executor.run(job, pending, kept)
        self.seconds += time.perf_counter() - start
        self.processor += time.process_time() - spent


class OneCall:
    """The whole grid in one call on this thread: what chunks are held against."""

    def run(self, job: Any, pending: Any, keep: Any) -> None:
        """As `Executor.run`, without any of its promises."""
        batches = range(job.batches)
        keep(batches, job.solve(batches, never), 0.0)


def study_of(records: dict[str, Any], gaps: int, strengths: int, laws: Sequence[str], pgas: Sequence[str]) -> Any:
    """Scene whose grid is scanned."""
    forces = [f"{force:.6g} N" for force in np.geomspace(1e5, 1e7, strengths - 1)]
    grid: dict[str, Any] = {
        "gap": {"start": "0 mm", "stop": "300 mm", "num": gaps},
        "yield_force": [*forces, "inf"],
        "contact_model": list(laws),
    }
    if pgas:
        grid["pga"] = list(pgas)
    return scene_of(
        {
            "building": [
                {"name": "left", "mass": "500 t", "period": "0.5 s", "damping": 0.05},
                {"name": "right", "mass": "800 t", "period": "1.0 s", "damping": 0.05},
            ],
            "interface": [
                {
                    "gap": "50 mm",
                    "contact_model": "viscous_elastoplastic",
                    "stiffness": "2.75e9 N/m^1.5",
                    "restitution": 0.65,
                }
            ],
            "records": records,
            "grid": grid,
        }
    )


def in_memory(study: Any, executor: Executor) -> Spent:
    """A scan that keeps nothing on disk."""
    timed, start = Timed(executor), time.perf_counter()
    scan(study, check_fraction=0.0, executor=timed)
    return Spent(time.perf_counter() - start, timed.seconds, timed.processor, timed.chunks)


def on_disk(study: Any, executor: Executor) -> Spent:
    """A scan with its parts, its log and its file."""
    timed = Timed(executor)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        scan(study, Path(folder) / "results.nc", check_fraction=0.0, executor=timed)
        return Spent(time.perf_counter() - start, timed.seconds, timed.processor, timed.chunks)


def in_shards(study: Any) -> Spent:
    """Shards one after the other, each on two threads, and what puts them together."""
    timed = Timed(Threads(2))
    with tempfile.TemporaryDirectory() as folder:
        out, start = Path(folder) / "results.nc", time.perf_counter()
        for number in range(1, SHARDS + 1):
            scan_shard(study, out, f"{number}/{SHARDS}", check_fraction=0.0, executor=timed)
        scan(study, out, check_fraction=0.0)
        return Spent(time.perf_counter() - start, timed.seconds, timed.processor, timed.chunks)


def started(stack: ExitStack) -> Executor:
    """A cluster of two processes on this machine."""
    from distributed import Client, LocalCluster

    from pounding_risk.ensemble.dask import Dask

    cluster = LocalCluster(
        n_workers=PROCESSES, threads_per_worker=1, host="127.0.0.1", dashboard_address=":0", silence_logs=50
    )
    client = stack.enter_context(Client(stack.enter_context(cluster), set_as_default=False))
    return Dask(client)


def measure(study: Any, ways: dict[str, Callable[[Any], Spent]], repeats: int) -> dict[str, list[Spent]]:
    """Every way in turn, as often as asked."""
    found: dict[str, list[Spent]] = {name: [] for name in ways}
    for _ in range(repeats):
        for name, way in ways.items():
            found[name].append(way(study))
            print(f"{name}: {found[name][-1].solving:.2f} s", file=sys.stderr)
    return found


def tell(found: dict[str, list[Spent]]) -> None:
    """The table, and the shares of chunks and journal."""

    def middle(name: str, what: str = "solving") -> float:
        return median(getattr(spent, what) for spent in found[name])

    print("| way | chunks | solving | least to largest | beside 2 threads | processor | in all |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, spent in found.items():
        seconds = sorted(one.solving for one in spent)
        print(
            f"| {name} | {middle(name, 'chunks'):.0f} | {middle(name):.2f} s | {seconds[0]:.2f} to {seconds[-1]:.2f} s "
            f"| {middle(name) / middle(BESIDE):.2f} | {middle(name, 'processor'):.2f} s "
            f"| {middle(name, 'whole'):.2f} s |"
        )
    print(f"\nTwo threads solve {middle('1 thread') / middle(BESIDE):.2f} times as fast as one.")
    for what in ("solving", "processor"):
        chunks = middle("1 thread", what) / middle("in one call", what) - 1.0
        journal = middle("2 threads, on disk", what) / middle(BESIDE, what) - 1.0
        told = f"chunks take {100.0 * chunks:+.1f} % on one thread, the journal {100.0 * journal:+.1f} % on two"
        print(f"By {what}: {told}.")


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure all ways and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--far-field", action="store_true", help="264,000 cases; needs the extra [ensembles]")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--gaps", type=int, default=50)
    parser.add_argument("--no-dask", action="store_true")
    parser.add_argument("--numbers", metavar="FILE", help="JSON to write, every repeat")
    asked = parser.parse_args(arguments)
    if asked.far_field:
        records, laws, pgas = {"set": "fema-p695-farfield"}, MORE_LAWS, ()
    else:
        records, laws, pgas = {"names": ["RSN6-180"]}, LAWS, ("0.1 g", "0.2 g", "0.3 g", "0.4 g", "0.5 g")
        records["polarity"] = ["as recorded", "reversed"]
    study = study_of(records, asked.gaps, 20, laws, pgas)
    small = study_of({"names": ["RSN6-180"], "window": ["0 s", "6 s"]}, 5, 4, laws, ())
    with ExitStack() as stack:
        ways: dict[str, Callable[[Any], Spent]] = {
            "in one call": lambda study: in_memory(study, OneCall()),
            "1 thread": lambda study: in_memory(study, Threads(1)),
            BESIDE: lambda study: in_memory(study, Threads(2)),
            "4 threads": lambda study: in_memory(study, Threads(4)),
            "2 threads, on disk": lambda study: on_disk(study, Threads(2)),
            f"{SHARDS} shards, on disk": in_shards,
        }
        if not asked.no_dask:
            cluster = started(stack)
            ways[f"Dask, {PROCESSES} processes"] = lambda study: in_memory(study, cluster)
            ways[f"Dask, {PROCESSES} processes, on disk"] = lambda study: on_disk(study, cluster)
        measure(small, ways, 1)
        counts = counted(scan(study, check_fraction=0.0))
        found = measure(study, ways, asked.repeats)
    print(f"{counts['cases']:,} cases, {counts['simulated']:,} with a run of their own; {asked.repeats} repeats\n")
    tell(found)
    if asked.numbers:
        Path(asked.numbers).write_text(json.dumps(found, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
