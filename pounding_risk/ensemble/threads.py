"""Who does the work of a study: batches handed out in chunks of some tenths of a second, and threads that solve them.

What a batch gives depends on nothing but the batch, so neither chunks nor whoever solves them can change a number.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from itertools import groupby
from math import ceil, inf
from queue import Empty, SimpleQueue
from threading import Condition, Event, Semaphore, Thread
from time import perf_counter
from typing import Any, NamedTuple, Protocol

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.errors import PoundingError

Keep = Callable[[range, Chunk, float], None]  # batches, what they give, seconds it took

SECONDS = 0.5  # a chunk's: little is lost where a run is killed, and what surrounds a chunk costs nothing beside it
LONGEST = 2.0  # s, of a chunk, whatever is asked for: Ctrl-C and a lost worker cost no more
LEAST = 0.1  # of a chunk's seconds: no smaller towards the end, where chunks shrink so that workers end together
CHUNK_BYTES = 16e6  # at most: parts wait in memory for the disk
GROWTH = 4  # a chunk has at most so many times the batches of those before: costs are told by few batches at first
MEMORY = 0.9  # weight of the chunks before the last in what a batch takes: small gaps cost more than large ones
WORKER = "pounding-worker-"  # begins the name of every thread that solves
TICK = 0.1  # s, between looks at whether to go on
ROUNDS = 16  # blocks a shard: many, as batches differ in cost, and few, as no chunk is longer than a block


class Solver(Protocol):
    """What solves batches: a job, see `jobs`."""

    scan_input: Any  # what it is made of, for another process to make the same

    def law_at(self, batch: int) -> int:
        """Which law a batch needs, compiled."""

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """What these batches give; None where ``stop`` turned true on the way. Threads may call it at once."""


class Executor(Protocol):
    """Works through what is pending."""

    def run(self, job: Solver, pending: Pending, keep: Keep) -> None:
        """Solve every pending batch and hand each part to ``keep``, on this very thread, in the order they end.

        KeyboardInterrupt, and what the job raises, come out at once: parts that are finished are kept before, and
        nobody waits for those under way. What ``keep`` raises comes out too.
        """


class Run(NamedTuple):
    """Batches side by side that need one law."""

    start: int
    stop: int
    law: int


class Pace:
    """How fast batches of one law are solved, from the chunks that came back."""

    def __init__(self) -> None:
        self.seconds, self.batches = 0.0, 0.0
        self.most = 0  # batches of the next chunk; none before the law's first batch is back

    @property
    def seconds_per_batch(self) -> float:
        """Seconds, expected."""
        return self.seconds / self.batches if self.batches else 0.0

    def learn(self, batches: int, seconds: float) -> None:
        """Batches of a chunk took so long."""
        self.seconds = MEMORY * self.seconds + seconds
        self.batches = MEMORY * self.batches + batches
        self.most = max(self.most, GROWTH * batches)


class Pending:
    """Batches to do, handed out in chunks; threads may ask at once.

    The first batch of each law goes alone, as it compiles, and other batches of the law wait for it; the others go in
    chunks of about ``seconds``, from what those before took, or of exactly ``length`` batches where that is given.
    ``law_at`` tells the law that a batch needs, ``bytes_per_batch`` what a batch's part takes.
    """

    def __init__(
        self,
        batches: Iterable[range],
        law_at: Callable[[int], int],
        *,
        bytes_per_batch: int = 0,
        seconds: float = SECONDS,
        length: int | None = None,
    ):
        self._runs, self._firsts = _runs(batches, law_at)
        self._paces = {first.law: Pace() for first in self._firsts}
        self._left = len(self._firsts) + sum(run.stop - run.start for run in self._runs)
        self._seconds = min(seconds, LONGEST)
        self._length = length
        self._most = max(1, int(CHUNK_BYTES // bytes_per_batch)) if bytes_per_batch else inf
        self._workers = self._compilers = 1
        self._compiling = 0
        self._out: dict[int, dict[int, int]] = {}  # of the chunks handed out: batches by law
        self._changed = Condition()

    @property
    def left(self) -> int:
        """Batches not handed out yet."""
        return self._left

    def shared_by(self, workers: int, compilers: int = 1) -> None:
        """So many workers take chunks; of them, this many can compile at a time."""
        with self._changed:
            self._workers, self._compilers = max(1, workers), max(1, compilers)

    def next(self, wait: float = 0.0) -> range | None:
        """A chunk; None where no batch is left, or where for ``wait`` seconds all that are wait for a first one."""
        with self._changed:
            chunk = self._chunk()
            if chunk is None and self._left and wait > 0.0:
                self._changed.wait(wait)
                chunk = self._chunk()
            return chunk

    def took(self, batches: range, seconds: float | None) -> None:
        """A chunk is back after so many seconds; None where they say nothing of other batches, as it compiled."""
        with self._changed:
            laws = [(self._paces[law], count) for law, count in self._out.pop(batches.start).items()]
            if not laws[0][0].most:
                self._compiling -= 1
                laws[0][0].most = 1
            elif seconds is not None:
                expected = [pace.seconds_per_batch * count for pace, count in laws]
                if not all(expected):
                    expected = [float(count) for _, count in laws]
                for (pace, count), share in zip(laws, expected, strict=True):
                    pace.learn(count, seconds * share / sum(expected))
            self._changed.notify_all()

    def _chunk(self) -> range | None:
        if self._firsts and self._compiling < self._compilers:
            return self._first()
        for place, run in enumerate(self._runs):
            if self._paces[run.law].most:
                return self._cut(place)
        return self._first() if self._firsts else None

    def _first(self) -> range:
        first = self._firsts.pop(0)
        self._compiling += 1
        return self._handed(first.start, {first.law: 1})

    def _cut(self, place: int) -> range:
        """A chunk from the start of a run on, over as many runs as follow without a hole and can be solved now."""
        start = stop = self._runs[place].start
        laws: dict[int, int] = {}
        while place < len(self._runs) and self._runs[place].start == stop:
            run = self._runs[place]
            count = min(run.stop - run.start, self._fitting(run.law, laws))
            if count <= 0:
                break
            laws[run.law] = laws.get(run.law, 0) + count
            stop += count
            if stop < run.stop:
                self._runs[place] = run._replace(start=stop)
                break
            del self._runs[place]
        return self._handed(start, laws)

    def _fitting(self, law: int, laws: dict[int, int]) -> int:
        """Batches of a law that can be added to a chunk of so many batches by law."""
        pace, taken = self._paces[law], sum(laws.values())
        if not pace.most:
            return 0
        if self._length is not None:
            return self._length - taken
        expected = sum(count * self._paces[each].seconds_per_batch for each, count in laws.items())

        def lines_in(seconds: float) -> float:
            return (seconds - expected) / pace.seconds_per_batch if pace.seconds_per_batch else inf

        growing = pace.most - laws.get(law, 0)
        even = ceil(self._left / (2 * self._workers)) - taken
        share = max(even, min(lines_in(LEAST * self._seconds), growing))
        fitting = int(min(growing, self._most - taken, lines_in(self._seconds), share))
        return fitting if taken else max(1, fitting)

    def _handed(self, start: int, laws: dict[int, int]) -> range:
        batches = range(start, start + sum(laws.values()))
        self._left -= len(batches)
        self._out[start] = laws
        return batches


def _runs(batches: Iterable[range], law_at: Callable[[int], int]) -> tuple[list[Run], list[Run]]:
    """Runs of batches that need one law, in order, and, taken out of them, the first batch of each law."""
    runs: list[Run] = []
    firsts: dict[int, Run] = {}
    for piece in sorted(batches, key=lambda piece: piece.start):
        start = piece.start
        for law, alike in groupby(map(law_at, piece)):
            stop = start + sum(1 for _ in alike)
            if law not in firsts:
                firsts[law] = Run(start, start + 1, law)
                start += 1
            if start < stop:
                runs.append(Run(start, stop, law))
            start = stop
    return runs, list(firsts.values())


class Solved(NamedTuple):
    """A chunk that is done."""

    batches: range
    part: Chunk
    seconds: float


class Threads:
    """Threads of this process; the kernels release the interpreter.

    One more than the machine has processors gains nothing. An interrupt leaves threads behind that are in a kernel:
    they are daemons, so that the process can end.
    """

    def __init__(self, workers: int = 1):
        if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
            raise PoundingError(f"workers is {workers}; it is a number of threads, 1 or more")
        self.workers = workers

    def run(self, job: Solver, pending: Pending, keep: Keep) -> None:
        """As `Executor.run`."""
        pending.shared_by(self.workers)
        crew = Crew(job, pending, self.workers)
        try:
            crew.start()
            crew.hand_over(keep)
        except KeyboardInterrupt:
            crew.stopped.set()
            crew.hand_over_finished(keep)
            raise
        finally:
            crew.stopped.set()


class Crew:
    """Threads that solve chunks, and the desk at which their parts are handed over."""

    def __init__(self, job: Solver, pending: Pending, workers: int):
        self.job, self.pending, self.workers = job, pending, workers
        self.expected = pending.left  # batches
        self.stopped = Event()
        self.finished: SimpleQueue[Solved | BaseException] = SimpleQueue()
        self.in_hand: Solved | None = None
        # Of chunks being solved or waiting for the disk: parts do not pile up in memory where it is slow.
        self.room = Semaphore(2 * workers + 1)

    def start(self) -> None:
        """Set the threads to work."""
        for number in range(min(self.workers, self.expected)):
            Thread(target=self._work, name=f"{WORKER}{number + 1}", daemon=True).start()

    def hand_over(self, keep: Keep) -> None:
        """Give every part to ``keep`` as it comes, until all are there; raises what a thread raised."""
        while self.expected:
            try:
                # With a limit, as a wait without one cannot be interrupted everywhere.
                found = self.finished.get(timeout=TICK)
            except Empty:
                continue
            if isinstance(found, BaseException):
                self.stopped.set()
                self.hand_over_finished(keep)
                raise found
            self._give(found, keep)

    def hand_over_finished(self, keep: Keep) -> None:
        """Give the parts that are there to ``keep``; that whose keeping was interrupted once more."""
        if self.in_hand is not None:
            self._give(self.in_hand, keep)
        while not self.finished.empty():
            found = self.finished.get()
            if not isinstance(found, BaseException):
                self._give(found, keep)

    def _give(self, found: Solved, keep: Keep) -> None:
        self.in_hand = found
        keep(*found)
        self.in_hand = None
        self.expected -= len(found.batches)
        self.room.release()

    def _work(self) -> None:
        """A thread's day."""
        try:
            while self.pending.left and not self.stopped.is_set():
                if not self.room.acquire(timeout=TICK):
                    continue
                batches = self.pending.next(TICK)
                if batches is None:
                    self.room.release()
                elif not self._solve(batches):
                    return
        except BaseException as error:  # told where the others are waited for
            self.finished.put(error)

    def _solve(self, batches: range) -> bool:
        start = perf_counter()
        part = self.job.solve(batches, self.stopped.is_set)
        if part is None:
            return False
        seconds = perf_counter() - start
        self.pending.took(batches, seconds)
        self.finished.put(Solved(batches, part, seconds))
        return True


def read_shard(text: str) -> tuple[int, int]:
    """Which shard of how many ``i/n`` names, counted from one; raises PoundingError for anything else."""
    found = re.fullmatch(r"\s*(\d+)\s*/\s*(\d+)\s*", text)
    if not found:
        raise PoundingError(f'"{text}" is no shard; write which of how many, such as 2/8')
    shard = int(found[1]), int(found[2])
    _check_shard(shard)
    return shard


def _check_shard(shard: tuple[int, int]) -> None:
    number, count = shard
    if not 1 <= number <= count:
        raise PoundingError(f"there is no shard {number}/{count}; shards are counted from 1/{count} to {count}/{count}")


def shard_batches(batches: int, shard: tuple[int, int]) -> list[range]:
    """The batches of one shard, ``(2, 8)`` the second of eight, of so many in all: blocks from all over the grid.

    Together the shards are the grid, and no two share a batch. The order of the shards turns from round to round, so
    that a shard does not get the small gaps each time. Raises PoundingError for a shard that there is not.
    """
    _check_shard(shard)
    number, count = shard
    length = max(1, ceil(batches / (count * ROUNDS)))
    found: list[range] = []
    for turn in range(ceil(batches / (count * length))):
        start = (turn * count + (number - 1 + turn) % count) * length
        stop = min(start + length, batches)
        if start >= stop:
            continue
        if found and found[-1].stop == start:
            start = found.pop().start
        found.append(range(start, stop))
    return found
