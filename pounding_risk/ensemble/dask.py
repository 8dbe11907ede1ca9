"""Batches solved by the workers of a Dask cluster; what they give is kept by this process, which alone writes files."""

from __future__ import annotations

import hashlib
import pickle
import warnings
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from importlib import metadata
from math import inf
from threading import Lock
from time import monotonic, perf_counter, sleep
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.threads import Keep, Pending, Solver
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from distributed import Client, Future, as_completed

ALIKE = ("pounding-risk", "numpy", "numba")  # what numbers come from: of one version everywhere
CONNECT, PATIENCE = 10.0, 60.0  # s, to the scheduler, and until a first worker is there
LOOK = 2.0  # s, between looks at how many workers there are: they come and go
TICK = 0.01  # s, between looks at whether a chunk is back
AHEAD = 2  # chunks in flight for each thread of the cluster: the one being solved, and the next
JOBS = 2  # kept by a worker
GO_ON = "what is done is kept; start the same command again, without --new, and it goes on from there"

Make = Callable[[Any], Solver]  # a job from its input


class Told(NamedTuple):
    """What each chunk brings along, beside the input."""

    digest: str  # of the input
    make: Make | None
    versions: dict[str, str]
    prepared: str  # as the job here says it, see `jobs.Job`


class Made(NamedTuple):
    """A job on a worker, and the laws that it has compiled or loaded."""

    job: Solver
    ready: set[int]


class Back(NamedTuple):
    """What a chunk gives."""

    part: Chunk
    seconds: float
    tells: bool  # what other batches take: not where it compiled


class Dask:
    """The workers of a Dask cluster: the address of its scheduler, or a ``distributed.Client``.

    ``make`` makes the job from its input on the workers, which must find it by its name; `jobs.job_of` where none is
    given. Raises PoundingError where Dask is not installed, the scheduler does not answer, has no workers, or they
    have other versions of what numbers come from.
    """

    def __init__(self, cluster: Client | str, make: Make | None = None):
        self._own = isinstance(cluster, str)
        self._client = _connected(cluster) if isinstance(cluster, str) else cluster
        self._make = make
        try:
            if isinstance(cluster, str):
                self._wait_for_workers(cluster)
            self._check_versions()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Leave a scheduler that was named by its address; a client that was given stays as it is."""
        if self._own:
            self._client.close()

    def run(self, job: Solver, pending: Pending, keep: Keep) -> None:
        """As `Executor.run`; a worker that is lost costs the time of its chunks.

        Raises PoundingError where the scheduler is lost, workers die one after the other, or a scheduler that was
        named by its address has none any more.
        """
        # A client's own cluster may be one that grows when a queue lets it; an address has what was started there.
        flight = Flight(self._client, pending, keep, PATIENCE if self._own else inf)
        try:
            flight.take_off(job, self._make)
            flight.land()
        except KeyboardInterrupt:
            flight.keep_finished()
            raise
        finally:
            flight.cancel()

    def _wait_for_workers(self, address: str) -> None:
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise PoundingError(
                f"the scheduler {address} has no workers after {PATIENCE:g} s; start some with `dask worker {address}`"
            ) from None

    def _check_versions(self) -> None:
        """Of the workers that are there; those that come later are checked with their first chunk."""
        told: Any = self._client.get_versions(packages=list(ALIKE))
        ours = told["client"]["packages"]
        for address, worker in told["workers"].items():
            theirs = worker["packages"]
            check_alike(
                address, {name: _version(theirs[name]) for name in ALIKE}, {n: _version(ours[n]) for n in ALIKE}
            )


def _version(found: str | None) -> str:
    return found or "not installed"


def check_alike(where: str, theirs: Mapping[str, str], ours: Mapping[str, str]) -> None:
    """Raise PoundingError where a worker's versions are not this program's own."""
    differences = [f"{name} {theirs[name]} there, {mine} here" for name, mine in ours.items() if theirs[name] != mine]
    if differences:
        raise PoundingError(
            f"the worker {where} would give other numbers: {'; '.join(differences)}; install the same versions on all "
            "machines of the cluster"
        )


def _connected(address: str) -> Client:
    try:
        from distributed import Client, Security
        from distributed.comm import get_address_host, parse_address
    except ImportError:
        raise PoundingError(
            "a Dask cluster needs the extra [cluster]: pip install 'pounding-risk[cluster]'; threads need nothing more"
        ) from None
    try:
        if Security().require_encryption and parse_address(address)[0] == "tcp":
            raise PoundingError(
                f'"{address}" is not encrypted, and the Dask configuration here asks for encryption '
                "(distributed.comm.require-encryption); write tls:// for a scheduler that was started with "
                "--protocol tls"
            )
        get_address_host(address)  # a client of no address cannot be closed any more, and tells so for 20 s
        return Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise PoundingError(
            f'no Dask scheduler answers at "{address}" ({error}); start one with `dask scheduler`, which prints its '
            "address, such as tcp://10.0.0.1:8786"
        ) from None


def _lost(why: str) -> PoundingError:
    return PoundingError(f"the Dask scheduler was lost, or dropped the work (reason: {why}); {GO_ON}")


class Flight:
    """The chunks on their way to the workers and back."""

    def __init__(self, client: Client, pending: Pending, keep: Keep, patience: float = inf):
        self.client, self.pending, self.keep = client, pending, keep
        self.patience, self.manned = patience, monotonic()  # s without a worker, and when there was one
        self.chunks: dict[Future, range] = {}
        self.landed: as_completed | None = None
        self.in_hand: tuple[range, Chunk, float] | None = None
        self.scan_input: Future | None = None
        self.room, self.looked = 0, -LOOK

    def take_off(self, job: Solver, make: Make | None) -> None:
        """Hand the input over, once for all chunks: a task of its own, so that no worker's loss loses it."""
        from distributed import as_completed

        payload = pickle.dumps(job.scan_input)
        self.told = Told(hashlib.sha256(payload).hexdigest(), make, _versions(), _prepared(job))
        with warnings.catch_warnings():
            # Records are large, and go to the scheduler once.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            self.scan_input = self.client.submit(_handed_over, payload, key=f"pounding-scan_input-{self.told.digest}")
        self.landed = as_completed([], loop=self.client.loop, with_results=True, raise_errors=False)
        self._send()

    def land(self) -> None:
        """Keep what comes back, and send more, until all is there."""
        while self.chunks:
            self._keep_next()
            self._send()
        assert not self.pending.left, "batches wait, and nothing is on its way"

    def keep_finished(self) -> None:
        """Keep what is back already; that whose keeping was interrupted once more."""
        if self.in_hand is not None:
            self.keep(*self.in_hand)
        while self.landed is not None and self.landed.has_ready():
            future, found = next(self.landed)
            if isinstance(found, Back):
                self.keep(self.chunks.pop(future), found.part, found.seconds)

    def cancel(self) -> None:
        """Leave what is still on its way; the scheduler forgets the input too."""
        if self.chunks and self.client.status == "running":
            self.client.cancel(list(self.chunks))
        self.chunks.clear()
        if self.scan_input is not None:
            self.scan_input.release()

    def _send(self) -> None:
        """Chunks for every thread of the cluster and some more, which wait for it there."""
        if monotonic() - self.looked > LOOK:
            self._look()
        while len(self.chunks) < self.room:
            batches = self.pending.next()
            if batches is None:
                return
            future = self.client.submit(_solved, self.scan_input, self.told, batches, pure=False)
            self.chunks[future] = batches
            assert self.landed is not None, "sent before take-off"
            self.landed.add(future)

    def _look(self) -> None:
        """See how many threads there are; raises PoundingError where there was none for too long."""
        try:
            threads = sum(self.client.nthreads().values())
        except OSError as error:
            raise _lost(str(error)) from None
        self.looked = monotonic()
        if threads:
            self.manned = self.looked
        elif self.looked - self.manned > self.patience:
            raise PoundingError(
                f"the Dask scheduler has had no workers for {self.patience:g} s: they have ended, or were killed; "
                f"start some again; {GO_ON}"
            )
        threads = max(1, threads)
        self.pending.shared_by(threads, compilers=threads)
        self.room = AHEAD * threads

    def _keep_next(self) -> None:
        assert self.landed is not None, "landed before take-off"
        while not self.landed.has_ready():
            sleep(TICK)
            if monotonic() - self.looked > LOOK:
                self._look()
        future, found = next(self.landed)
        batches = self.chunks.pop(future)
        # Not the future's status: a worker may be lost once its answer is here.
        if not isinstance(found, Back):
            future.release()
            self.keep_finished()
            raise self._told_apart(batches, found)
        self.pending.took(batches, found.seconds if found.tells else None)
        self.in_hand = batches, found.part, found.seconds
        self.keep(*self.in_hand)
        self.in_hand = None

    def _told_apart(self, batches: range, found: Any) -> BaseException:
        """What a chunk that is not solved says to the user: its own error, or that of the cluster."""
        from distributed import KilledWorker

        if isinstance(found, CancelledError):
            return _lost(getattr(found, "reason", "unknown"))
        _, error, trace = found
        if isinstance(error, KilledWorker):
            return PoundingError(
                f"the batches {batches.start} to {batches.stop - 1} of the grid ended "
                f"{error.allowed_failures + 1} workers, one after the other; give workers more memory, and see their "
                f"logs; {GO_ON}"
            )
        return error.with_traceback(trace)


# On the workers.

_made: OrderedDict[str, Made] = OrderedDict()
_making = Lock()


def _handed_over(payload: bytes) -> bytes:
    """The input, as it is: a task, so that it is made again where the worker that held it is lost."""
    return payload


def _solved(payload: bytes, told: Told, batches: range) -> Back:
    """What batches give."""
    from pounding_risk.ensemble.job import (
        never,  # all that solves: the scheduler, which reads this file too, needs none of it
    )

    made = _job(payload, told)
    laws = set(map(made.job.law_at, batches))
    tells = laws <= made.ready
    start = perf_counter()
    part = made.job.solve(batches, never)
    assert part is not None, "nobody stops a chunk here: it is short"
    seconds = perf_counter() - start
    made.ready.update(laws)
    return Back(part, seconds, tells)


def _job(payload: bytes, told: Told) -> Made:
    """The input's job, made once in each process."""
    from pounding_risk.ensemble.job_choice import job_of

    with _making:
        if told.digest not in _made:
            check_alike(_address(), _versions(), told.versions)
            job = (told.make or job_of)(pickle.loads(payload))
            if _prepared(job) != told.prepared:
                raise PoundingError(
                    f"the worker {_address()} would give other last digits: another kind of processor, for which "
                    "libraries compute in other ways; set the same OPENBLAS_CORETYPE on all machines, or use machines "
                    "of one kind"
                )
            _made[told.digest] = Made(job, set())
            while len(_made) > JOBS:
                _made.popitem(last=False)
        _made.move_to_end(told.digest)
        return _made[told.digest]


def _prepared(job: Solver) -> str:
    """What the job says of its preparation; nothing where it has none."""
    return getattr(job, "prepared", "")


def _address() -> str:
    from distributed import get_worker

    return str(get_worker().address)


def _versions() -> dict[str, str]:
    """What numbers come from, here: also the kernels' very text, as a version may be worked on."""
    from pounding_risk._jit.compile import source_digest

    found = {"kernels": source_digest()}
    for name in ALIKE:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
