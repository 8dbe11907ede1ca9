"""Executor with the workers of a Dask cluster. Only this process writes files."""

from __future__ import annotations

import hashlib
import pickle
import warnings
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from math import inf
from threading import Lock
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.ensemble.threads import Keep, Pending, Solved, solve_for
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import versions_of

if TYPE_CHECKING:
    from distributed import Client, Future

    from pounding_risk.ensemble.job import Job

ALIKE = ("pounding-risk", "numpy", "numba")  # packages that must have the same version everywhere
CONNECT, PATIENCE = 10.0, 60.0  # s, to wait for the scheduler, and for a first worker
LOOK = 2.0  # s, between counts of the workers, which come and go
TICK = 0.01  # s, between checks whether a chunk is finished
AHEAD = 2  # chunks submitted for each thread of the cluster: the one being solved, and the next
JOBS = 2  # that a worker keeps
SHOWN = 12  # digits of a digest
GO_ON = "what is done is kept; start the same command again, without --new, and it goes on from there"

Make = Callable[[Any], "Job"]  # makes a job from its input


class JobKey(NamedTuple):
    """What is sent with each chunk beside the input of the job."""

    digest: str  # of the input
    make: Make | None
    versions: dict[str, str]
    prepared: str  # `Job.prepared` in this process
    laws: dict[str, str]  # digests of laws and effects that are not this program's own


class Dask:
    """Executor with the workers of a Dask cluster.

    Parameters
    ----------
    cluster : distributed.Client or str
        A client, or the address of a scheduler.
    make : callable, optional
        Makes the job from its input on the workers, which must be able to import it; `job_choice.job_of` by default.

    Raises
    ------
    PoundingError
        Where Dask is not installed, the scheduler does not answer or has no workers, or the workers have other versions
        of the packages that numbers depend on.
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
        """Disconnect from a scheduler that was named by its address; a client that was passed in stays open."""
        if self._own:
            self._client.close()

    def run(self, job: Job, pending: Pending, keep: Keep) -> None:
        """Solve every pending batch; see `Executor.run`. A worker that is lost costs the time of its chunks.

        Raises PoundingError where the scheduler is lost, workers die one after the other, or a scheduler that was
        named by its address has no workers any more.
        """
        # A client's own cluster may grow when a queue lets it; behind an address are the workers that were started.
        run = ClusterRun(self._client, pending, keep, PATIENCE if self._own else inf)
        try:
            run.start(job, self._make)
            run.collect()
        except KeyboardInterrupt:
            run.keep_finished()
            raise
        finally:
            run.cancel()

    def _wait_for_workers(self, address: str) -> None:
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise PoundingError(
                f"the scheduler {address} has no workers after {PATIENCE:g} s; start some with `dask worker {address}`"
            ) from None

    def _check_versions(self) -> None:
        """Check the workers that are there; those that join later are checked with their first chunk."""
        versions: Any = self._client.get_versions(packages=list(ALIKE))

        def installed(machine: Mapping[str, Any]) -> dict[str, str]:
            return {name: machine["packages"][name] or "not installed" for name in ALIKE}

        for address, worker in versions["workers"].items():
            check_alike(address, installed(worker), installed(versions["client"]))


def check_alike(worker: str, remote: Mapping[str, str], local: Mapping[str, str]) -> None:
    """Raise PoundingError where a worker's versions are not this program's own."""
    differences = [
        f"{name} {remote[name]} there, {version} here" for name, version in local.items() if remote[name] != version
    ]
    if differences:
        raise PoundingError(
            f"the worker {worker} would give other numbers: {'; '.join(differences)}; install the same versions on all "
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
        get_address_host(address)  # a client of an invalid address cannot be closed, and logs so for 20 s
        return Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise PoundingError(
            f'no Dask scheduler answers at "{address}" ({error}); start one with `dask scheduler`, which prints its '
            "address, such as tcp://10.0.0.1:8786"
        ) from None


def _lost_error(reason: str) -> PoundingError:
    return PoundingError(f"the Dask scheduler was lost, or dropped the work (reason: {reason}); {GO_ON}")


class ClusterRun:
    """The chunks of one run that are submitted to the cluster."""

    def __init__(self, client: Client, pending: Pending, keep: Keep, patience: float = inf):
        from distributed import as_completed

        self.client, self.pending, self.keep = client, pending, keep
        self.patience, self.last_worker = patience, monotonic()  # s without a worker; when there was one
        self.submitted: dict[Future, range] = {}
        self.finished = as_completed([], loop=client.loop, with_results=True, raise_errors=False)
        self.being_kept: Solved | None = None
        self.payload: Future | None = None  # the pickled input of the job
        self.room, self.last_count = 0, -LOOK

    def start(self, job: Job, make: Make | None) -> None:
        """Submit the input, once for all chunks and as a task, which Dask repeats where its worker is lost."""
        payload = pickle.dumps(job.scan_input)
        self.key = JobKey(hashlib.sha256(payload).hexdigest(), make, _versions(), _prepared(job), _laws(job.scan_input))
        with warnings.catch_warnings():
            # Records are large, and go to the scheduler once.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            self.payload = self.client.submit(_payload_task, payload, key=f"pounding-order-{self.key.digest}")
        self._submit()

    def collect(self) -> None:
        """Keep the chunks that are finished, and submit more, until every batch is solved."""
        while self.submitted:
            self._keep_next()
            self._submit()
        assert self.pending.is_done, "batches wait, and nothing is submitted"

    def keep_finished(self) -> None:
        """Keep the chunks that are finished; also, once more, the chunk whose keeping was interrupted."""
        if self.being_kept is not None:
            self.keep(*self.being_kept)
        while self.finished.has_ready():
            future, solved = next(self.finished)
            if isinstance(solved, Solved):
                del self.submitted[future]
                self.keep(*solved)

    def cancel(self) -> None:
        """Cancel what is still submitted, and let the scheduler forget the input."""
        if self.submitted and self.client.status == "running":
            self.client.cancel(list(self.submitted))
        self.submitted.clear()
        if self.payload is not None:
            self.payload.release()

    def _submit(self) -> None:
        """Submit chunks for every thread of the cluster, and some that wait there."""
        if monotonic() - self.last_count > LOOK:
            self._count_workers()
        while len(self.submitted) < self.room:
            batches = self.pending.next()
            if batches is None:
                return
            future = self.client.submit(_solve, self.payload, self.key, batches, self.pending.mean, pure=False)
            self.submitted[future] = batches
            self.finished.add(future)

    def _count_workers(self) -> None:
        """Count the threads of the cluster; raises PoundingError where there was none for too long."""
        try:
            threads = sum(self.client.nthreads().values())
        except OSError as error:
            raise _lost_error(str(error)) from None
        self.last_count = monotonic()
        if threads:
            self.last_worker = self.last_count
        elif self.last_count - self.last_worker > self.patience:
            raise PoundingError(
                f"the Dask scheduler has had no workers for {self.patience:g} s: they have ended, or were killed; "
                f"start some again; {GO_ON}"
            )
        threads = max(1, threads)
        self.pending.shared_by(threads, compilers=threads)
        self.room = AHEAD * threads

    def _keep_next(self) -> None:
        while not self.finished.has_ready():
            sleep(TICK)
            if monotonic() - self.last_count > LOOK:
                self._count_workers()
        future, solved = next(self.finished)
        batches = self.submitted.pop(future)
        # Not the future's status: a worker may be lost once its results are here.
        if not isinstance(solved, Solved):
            future.release()
            self.keep_finished()
            raise self._error(batches, solved)
        self.pending.took(batches, solved.batches, solved.seconds)
        self.being_kept = solved
        self.keep(*solved)
        self.being_kept = None

    def _error(self, batches: range, failure: Any) -> BaseException:
        """The error to raise for a chunk that was not solved: that of the job, or of the cluster."""
        from distributed import KilledWorker

        if isinstance(failure, CancelledError):
            return _lost_error(getattr(failure, "reason", "unknown"))
        _, error, trace = failure
        if isinstance(error, KilledWorker):
            return PoundingError(
                f"the batches {batches.start} to {batches.stop - 1} of the grid ended "
                f"{error.allowed_failures + 1} workers, one after the other; give workers more memory, and see their "
                f"logs; {GO_ON}"
            )
        return error.with_traceback(trace)


# Run on the workers.

_jobs: OrderedDict[str, Job] = OrderedDict()
_making = Lock()


def _payload_task(payload: bytes) -> bytes:
    """The pickled input of a job, as a task, which Dask repeats where the worker that holds it is lost."""
    return payload


def _solve(payload: bytes, key: JobKey, batches: range, mean: float) -> Solved:
    """Solve batches, from the first on, for the time of a chunk; see `solve_for`."""
    # The scheduler imports this module too, and needs none of the solver.
    from pounding_risk.ensemble.job import never

    solved = solve_for(_job(payload, key), batches, never, mean)
    assert solved is not None, "nobody stops a chunk on a worker: it is short"
    return solved


def _job(payload: bytes, key: JobKey) -> Job:
    """The job of an input, made once in each process."""
    from pounding_risk.ensemble.job_choice import job_of

    with _making:
        if key.digest not in _jobs:
            check_alike(_address(), _versions(), key.versions)
            job = (key.make or job_of)(_unpickled(payload, key))
            if _prepared(job) != key.prepared:
                raise PoundingError(
                    f"the worker {_address()} would give other last digits: another kind of processor, for which "
                    "libraries compute in other ways; set the same OPENBLAS_CORETYPE on all machines, or use machines "
                    "of one kind"
                )
            _jobs[key.digest] = job
            while len(_jobs) > JOBS:
                _jobs.popitem(last=False)
        _jobs.move_to_end(key.digest)
        return _jobs[key.digest]


def _unpickled(payload: bytes, key: JobKey) -> Any:
    """The input of a job; raises PoundingError where a law or an effect of it is not here, or has other code."""
    try:
        scan_input = pickle.loads(payload)
        laws = _laws(scan_input)
    except (ImportError, AttributeError, KeyError, PoundingError) as error:
        if not key.laws:
            raise
        raise PoundingError(
            f"the worker {_address()} does not know {', '.join(key.laws)}: {error}; install the plug-ins of this "
            "machine on all machines of the cluster"
        ) from None
    check_alike(
        _address(), *({f"code of {name}": code[:SHOWN] for name, code in codes.items()} for codes in (laws, key.laws))
    )
    return scan_input


def _laws(scan_input: Any) -> dict[str, str]:
    """Digests of those laws and effects of the input of a job that are not this program's own."""
    from pounding_risk.scene.scene import own_laws

    return own_laws(scan_input.study) if getattr(scan_input, "study", None) else {}


def _prepared(job: Job) -> str:
    """`Job.prepared`; "" for a job without it."""
    return getattr(job, "prepared", "")


def _address() -> str:
    from distributed import get_worker

    return str(get_worker().address)


def _versions() -> dict[str, str]:
    """Versions of the packages that numbers depend on, and the digest of the kernels' source, which may be edited."""
    from pounding_risk._jit.sources import source_digest

    return {"kernels": source_digest()} | versions_of(ALIKE)
