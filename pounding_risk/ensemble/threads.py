"""Executors of a scan: who solves the batches of a grid, in chunks of about half a second.

The result of a batch depends on its number alone, so neither the boundaries of the chunks nor the thread that solves
them change any bit of a dataset. `concurrent.futures` is not used: the interpreter waits for its threads at exit, and
Ctrl-C would wait for kernels that may run for minutes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from itertools import groupby, islice
from math import ceil
from queue import Empty, SimpleQueue
from threading import Condition, Event, Semaphore, Thread
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple, Protocol

from pounding_risk.ensemble.chunks import Chunk, joined
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.ensemble.job import Job

Keep = Callable[[range, Chunk, float], None]  # batches, their results, seconds it took

SECONDS = 0.5  # of work in a chunk: what a kill loses; keeping a chunk takes little beside it
PIECE = 0.1  # s, of the pieces of a chunk, between which its time is looked at
GROWTH = 4  # ratio of the lengths of a piece and the one before, at most: batches differ in cost by orders of magnitude
SHORTEST = 1e-9  # s, of a batch: what clocks resolve, and below it shares would have no end
UNTIMED = 1000  # batches of a range, at most, before any batch is timed
CHUNK_BYTES = 16e6  # of a chunk at most: chunks wait in memory for the disk
WORKER = "pounding-worker-"  # begins the name of every thread that solves
TICK = 0.1  # s, between checks of whether to go on
ROUNDS = 16  # blocks per shard: many, as batches differ in cost, and few, as no chunk is longer than a block


class Executor(Protocol):
    """Solves all pending batches of a job."""

    def run(self, job: Job, pending: Pending, keep: Keep) -> None:
        """Solve every pending batch and pass each chunk to ``keep``, on the calling thread, as the chunks are finished.

        KeyboardInterrupt and errors of the job are raised at once: chunks that are finished are kept before, and
        chunks under way are not waited for. Errors of ``keep`` are raised too.
        """


class Solved(NamedTuple):
    """A finished chunk: its batches, results and seconds of work."""

    batches: range
    chunk: Chunk
    seconds: float


def solve_for(job: Job, batches: range, stop: Callable[[], bool], mean: float = 0.0) -> Solved | None:
    """Solve batches, from the first on, until about `SECONDS` are over; None where ``stop`` turned true meanwhile.

    At least one batch is solved. Batches are solved in pieces of `PIECE` seconds or less, each timed to size the next;
    ``mean`` is what a batch took so far [s], as cheap batches are followed by costly ones.
    """
    start, elapsed, done, length = perf_counter(), 0.0, batches.start, 1
    pieces: list[Chunk] = []
    while True:
        piece = job.solve(range(done, min(done + length, batches.stop)), stop)
        if piece is None:
            return None
        pieces.append(piece)
        solved, now = min(length, batches.stop - done), perf_counter() - start
        done += solved
        cost, elapsed = max((now - elapsed) / solved, mean), now
        if done == batches.stop or elapsed + cost > SECONDS:
            return Solved(range(batches.start, done), joined(pieces) if len(pieces) > 1 else piece, elapsed)
        fitting = int(min(PIECE, SECONDS - elapsed) / cost) if cost > 0.0 else GROWTH * solved
        length = max(1, min(GROWTH * solved, fitting))


class Run(NamedTuple):
    """Successive batches of one contact model."""

    start: int
    stop: int
    law: int


class Pending:
    """Batches still to be solved, handed out as ranges. Several threads may use it at once.

    The first batch of each contact model is handed out alone, as solving it compiles; the others of that model wait for
    it. A worker that solves only the beginning of a range gives the rest back. ``law_at`` gives the model of a batch,
    ``bytes_per_batch`` the size of its results; ``length`` fixes the length of the ranges.
    """

    def __init__(
        self,
        batches: Iterable[range],
        law_at: Callable[[int], int],
        *,
        bytes_per_batch: int = 0,
        length: int | None = None,
    ):
        self._runs: list[Run] = []
        self._firsts: dict[int, int] = {}  # first batch of each contact model that nobody has begun
        for span in sorted(batches, key=lambda span: span.start):
            start = span.start
            for law, group in groupby(map(law_at, span)):
                stop = start + sum(1 for _ in group)
                is_first = self._firsts.setdefault(law, start) == start
                if start + is_first < stop:
                    self._runs.append(Run(start + is_first, stop, law))
                start = stop
        self.left = len(self._firsts) + sum(run.stop - run.start for run in self._runs)  # not handed out
        self._length = length
        self._longest = max(1, int(CHUNK_BYTES // bytes_per_batch)) if bytes_per_batch else self.left
        self._workers = self._compilers = 1
        self._compiled: set[int] = set()
        self._compiling = 0
        self._handed_out: dict[int, list[Run]] = {}  # by first batch
        self._solved, self._seconds = 0, 0.0
        self._changed = Condition()

    @property
    def is_done(self) -> bool:
        """True where every batch has been solved."""
        with self._changed:
            return not (self.left or self._handed_out)

    @property
    def mean(self) -> float:
        """Seconds that a batch took so far, without those that compiled; 0 before any is solved."""
        return self._seconds / self._solved if self._solved else 0.0

    def shared_by(self, workers: int, compilers: int = 1) -> None:
        """Set how many workers take ranges, and how many of them can compile at a time."""
        with self._changed:
            self._workers, self._compilers = max(1, workers), max(1, compilers)

    def next(self, wait: float = 0.0) -> range | None:
        """A range to solve; None where there is none now, nor within ``wait`` seconds."""
        with self._changed:
            batches = self._next()
            if batches is None and wait > 0.0 and (self.left or self._handed_out):
                self._changed.wait(wait)
                batches = self._next()
            return batches

    def took(self, batches: range, solved: range, seconds: float) -> None:
        """Report which batches, from the first on, of a range were solved, and in how many seconds."""
        with self._changed:
            runs = self._handed_out.pop(batches.start)
            if runs[0].law not in self._compiled:
                self._compiled.add(runs[0].law)
                self._compiling -= 1
            else:
                self._solved, self._seconds = self._solved + len(solved), self._seconds + seconds
            self._runs[:0] = [run._replace(start=max(run.start, solved.stop)) for run in runs if run.stop > solved.stop]
            self.left += batches.stop - solved.stop
            self._changed.notify_all()

    def _next(self) -> range | None:
        position = next((index for index, run in enumerate(self._runs) if run.law in self._compiled), None)
        if self._firsts and (self._compiling < self._compilers or position is None):
            law = next(iter(self._firsts))
            first = self._firsts.pop(law)
            self._compiling += 1
            return self._hand_out([Run(first, first + 1, law)])
        return None if position is None else self._cut(position)

    def _cut(self, position: int) -> range:
        """A range from the start of a run, over as many further runs as follow without a hole and are compiled."""
        stop = self._runs[position].start
        limit = stop + (self._length or self._share())
        runs: list[Run] = []
        for run in islice(self._runs, position, None):
            if stop == limit or run.start != stop or run.law not in self._compiled:
                break
            stop = min(run.stop, limit)
            runs.append(run._replace(stop=stop))
        remainder = self._runs[position + len(runs) - 1]._replace(start=stop)
        self._runs[position : position + len(runs)] = [remainder] if remainder.start < remainder.stop else []
        return self._hand_out(runs)

    def _share(self) -> int:
        """Batches of a range: of four chunks at most; towards the end fewer, so that workers end together."""
        mean = max(self.mean, SHORTEST)
        piece_batches = int(PIECE / mean) if self.mean else 1
        chunk_batches = int(4.0 * SECONDS / mean) if self.mean else UNTIMED
        return max(1, min(self._longest, chunk_batches, max(ceil(self.left / (2 * self._workers)), piece_batches)))

    def _hand_out(self, runs: list[Run]) -> range:
        batches = range(runs[0].start, runs[-1].stop)
        self._handed_out[batches.start] = runs
        self.left -= len(batches)
        return batches


class Threads:
    """Executor with threads of this process; the compiled kernels release the interpreter.

    More threads than the machine has processors gain nothing. After an interrupt, threads that are in a kernel are left
    behind: they are daemon threads, so that the process can end.

    Parameters
    ----------
    workers : int
        Number of threads.

    Raises
    ------
    PoundingError
        Where ``workers`` is not a whole number of 1 or more.
    """

    def __init__(self, workers: int = 1):
        if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
            raise PoundingError(f"workers is {workers}; it is a number of threads, 1 or more")
        self.workers = workers

    def run(self, job: Job, pending: Pending, keep: Keep) -> None:
        """Solve every pending batch; see `Executor.run`."""
        pending.shared_by(self.workers)
        run = ThreadedRun(job, pending, self.workers)
        try:
            for number in range(min(self.workers, run.expected)):
                Thread(target=run.work, name=f"{WORKER}{number + 1}", daemon=True).start()
            run.hand_over(keep)
        except KeyboardInterrupt:
            run.stopped.set()
            run.hand_over_finished(keep)
            raise
        finally:
            run.stopped.set()


class ThreadedRun:
    """The threads of one run, and the queue through which the calling thread receives their chunks."""

    def __init__(self, job: Job, pending: Pending, workers: int):
        self.job, self.pending = job, pending
        self.expected = pending.left  # batches whose results have not been kept
        self.stopped = Event()
        self.finished: SimpleQueue[Solved | BaseException] = SimpleQueue()
        self.being_kept: Solved | None = None
        # Chunks that are being solved or wait for the disk: they do not pile up in memory where the disk is slow.
        self.room = Semaphore(2 * workers + 1)

    def hand_over(self, keep: Keep) -> None:
        """Pass every chunk to ``keep`` as it is finished, until all are; raises what a thread raised."""
        while self.expected:
            try:
                # With a limit, as a wait without one cannot be interrupted on every system.
                solved = self.finished.get(timeout=TICK)
            except Empty:
                continue
            if isinstance(solved, BaseException):
                self.stopped.set()
                self.hand_over_finished(keep)
                raise solved
            self._keep(solved, keep)

    def hand_over_finished(self, keep: Keep) -> None:
        """Pass the chunks that are finished to ``keep``; also, once more, the chunk that it was interrupted at."""
        if self.being_kept is not None:
            self._keep(self.being_kept, keep)
        while not self.finished.empty():
            solved = self.finished.get()
            if not isinstance(solved, BaseException):
                self._keep(solved, keep)

    def _keep(self, solved: Solved, keep: Keep) -> None:
        self.being_kept = solved
        keep(*solved)
        self.being_kept = None
        self.expected -= len(solved.batches)
        self.room.release()

    def work(self) -> None:
        """Solve ranges of the pending batches until all are solved or the run is stopped."""
        try:
            while not (self.stopped.is_set() or self.pending.is_done):
                if not self.room.acquire(timeout=TICK):
                    continue
                batches = self.pending.next(TICK)
                if batches is None:
                    self.room.release()
                    continue
                solved = solve_for(self.job, batches, self.stopped.is_set, self.pending.mean)
                if solved is None:
                    return
                self.pending.took(batches, solved.batches, solved.seconds)
                self.finished.put(solved)
        except BaseException as error:  # raised again on the calling thread
            self.finished.put(error)


def read_shard(text: str) -> tuple[int, int]:
    """Read a shard ``i/n``, the i-th of n counted from one; raises PoundingError for anything else."""
    numbers = re.fullmatch(r"\s*(\d+)\s*/\s*(\d+)\s*", text)
    if not numbers:
        raise PoundingError(f'"{text}" is no shard; write which of how many, such as 2/8')
    shard = int(numbers[1]), int(numbers[2])
    _check_shard(shard)
    return shard


def _check_shard(shard: tuple[int, int]) -> None:
    number, count = shard
    if not 1 <= number <= count:
        raise PoundingError(f"there is no shard {number}/{count}; shards are counted from 1/{count} to {count}/{count}")


def shard_batches(batches: int, shard: tuple[int, int]) -> list[range]:
    """The batches of one shard of a grid of so many batches; ``(2, 8)`` is the second of eight shards.

    The shards have no batch in common and make up the grid. A shard is blocks from all over the grid, and the order of
    the shards rotates from round to round, so that no shard gets the small gaps each time. Raises PoundingError for a
    shard that does not exist.
    """
    _check_shard(shard)
    number, count = shard
    length = max(1, ceil(batches / (count * ROUNDS)))
    spans: list[range] = []
    for turn in range(ceil(batches / (count * length))):
        start = (turn * count + (number - 1 + turn) % count) * length
        stop = min(start + length, batches)
        if start >= stop:
            continue
        if spans and spans[-1].stop == start:
            start = spans.pop().start
        spans.append(range(start, stop))
    return spans
