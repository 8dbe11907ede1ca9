"""Scan the grid of a scene: records × polarities × amplitudes × contact models × gaps × yield forces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from math import prod
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.files import remove_leftovers
from pounding_risk._common.progress import Progress
from pounding_risk.ensemble.chunks import Chunk, ChunksInMemory, joined, merged, parted, without
from pounding_risk.ensemble.job import DatasetWriter, ScanInput
from pounding_risk.ensemble.job_choice import job_of
from pounding_risk.ensemble.limits import check_dataset, check_disk, check_held, check_memory, check_scenes
from pounding_risk.ensemble.plan.size import grid_bytes, shape_of
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.ensemble.threads import Executor, Keep, Pending, Threads, read_shard, shard_batches
from pounding_risk.ensemble.variant_job import VariantJob, VariantWriter
from pounding_risk.errors import Stopped
from pounding_risk.results.attributes import as_text
from pounding_risk.results.files import RESULTS, check_target, open_results, zarr_library
from pounding_risk.results.layout import blocks
from pounding_risk.results.provenance import provenance
from pounding_risk.results.store import Blockwise, Memory, store_of
from pounding_risk.results.tolerance_check import check_share
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene

if TYPE_CHECKING:
    from pounding_risk.ensemble.checkpoint.folder import Checkpoint
    from pounding_risk.motions.ensemble import MotionEnsemble

LAZY = 1e8  # bytes; a larger dataset is returned lazily


class ShardDone(NamedTuple):
    """Progress of a scan after one of its shards."""

    cases: int  # of this shard
    done: int  # cases of the scan that are done, by any shard
    total: int  # cases of the scan
    folder: Path  # the checkpoint


class RunOptions(NamedTuple):
    """How the runs of a scene are made, as `scan` takes it."""

    executor: Executor
    screening: bool = True
    check_fraction: float = 0.0
    progress: Progress | None = None
    command: str = ""


class Scan:
    """A scan that is ready to run: its job, the attributes of its dataset, and its executor.

    The ``ensemble`` of motions is that of the scene, unless one is given.
    """

    def __init__(self, study: Scene | str | Path, options: RunOptions, ensemble: MotionEnsemble | None = None):
        self.executor, self.progress, self.command = options.executor, options.progress, options.command
        screening, check_fraction = options.screening, check_share(options.check_fraction)
        self.study = as_scene(study)
        ensemble = gathered(self.study) if ensemble is None else ensemble
        motions = len(ensemble.motions)
        self.bytes = grid_bytes(self.study, motions)
        check_dataset(self.study, prod(shape_of(self.study, motions).values()), self.bytes)
        check_memory(self.study, ensemble.motions)
        self.job = job_of(ScanInput(self.study, ensemble.motions, screening, check_fraction))
        if isinstance(self.job, VariantJob):
            check_scenes(self.job.variants, ensemble.motions)
        self.known: list[range] = []  # batches that a finished scan of fewer samples has
        self.attrs: dict[str, Any] = provenance(self.study, ensemble.motions, screening, check_fraction)
        if self.command:
            self.attrs["command"] = self.command
        if notes := () if self.study.axes else of_input(self.study, ensemble.motions):
            self.attrs["notes"] = as_text(list(notes))
        if ensemble.left_out:
            self.attrs["left_out"] = as_text(list(ensemble.left_out))
        if ensemble.copies:
            self.attrs["copies"] = as_text(list(ensemble.copies))

    def check_room(self, target: Path) -> None:
        """Raise SceneError where the disk has no room for the dataset of a scan that is not begun yet."""
        from pounding_risk.ensemble.checkpoint.folder import folder_of

        if not folder_of(target).exists():
            check_disk(self.study, self.bytes, target.parent)

    def work(self, wanted: list[range], done: list[range], keep: Keep) -> None:
        """Solve the wanted batches that are not done; the progress is that of all that are wanted."""
        job, width = self.job, self.job.width
        missing = without(wanted, [*done, *self.known])
        total = width * sum(map(len, wanted))
        solved = total - width * sum(map(len, missing))
        if self.progress:
            self.progress(solved, total)

        def keep_and_report(batches: range, chunk: Chunk, seconds: float) -> None:
            nonlocal solved
            keep(batches, chunk, seconds)
            solved += width * len(batches)
            if self.progress:
                self.progress(solved, total)

        if missing:
            self.executor.run(job, Pending(missing, job.law_at, bytes_per_batch=job.bytes_per_batch), keep_and_report)

    def assemble(self, chunks: Callable[[Iterable[range]], Iterator[Chunk]], store: Blockwise, begun: str = "") -> None:
        """Write the dataset, block by block; ``begun`` is the time at which the scan was, where that is not now."""
        writer = self.job.writer()
        spans = [(span, list(parted(span, self.known))) for span in blocks(self.job.template)]
        solved = chunks([lines for _, ranges in spans for lines, is_known in ranges if not is_known])
        with store:
            for span, ranges in spans:
                pieces = [_values(writer, lines, None if is_known else next(solved)) for lines, is_known in ranges]
                store.write(span, pieces[0] if len(pieces) == 1 else joined(pieces))
            finish = writer.finish()
            for batch, patch in finish.patches:
                store.write(range(batch, batch + 1), patch)
            self.close()  # before the file is replaced that it reads
            store.finish(finish.attrs | self.attrs | created(self.command or "pounding_risk.scan", begun))

    def in_memory(self) -> xr.Dataset:
        """Solve every batch and return the dataset, without a file."""
        check_held(self.study, self.bytes)
        chunks = ChunksInMemory()
        self.work([range(self.job.batches)], [], chunks.keep)
        memory = Memory(self.job.template)  # after the runs, which have found the peaks without contact that are in it
        self.assemble(chunks.chunks, memory)
        return memory.dataset()

    def checkpoint(self, target: Path, *, new: bool, shared: bool) -> Checkpoint:
        """Open the checkpoint beside the results."""
        from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint, folder_of, is_begun
        from pounding_risk.ensemble.identity import identity
        from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable

        facts = About(self.job.batches, self.job.width, self.study.name, self.command)
        study, path = identity(self.job.scan_input, self.job.prepared), folder_of(target)
        if not new and isinstance(self.job, VariantJob) and self.study.uncertain is not None:
            from pounding_risk.ensemble.known_samples import known_samples

            # The cases of a finished scan of fewer samples of the same scene, where there is one.
            self.job.known = known_samples(target, study, self.study.axes, self.job.shape[len(self.study.axes) :])
            self.known = self.job.known_batches()
        # A scan that was allowed to replace the file when it began need not be allowed again.
        if not self.known and not is_begun(path, study):
            choice = {"choice": OTHER_NAME} if shared else {}
            check_replaceable(target, "scan", study, new, **choice)
        checkpoint = Checkpoint.open(path, study, facts, new=new, shared=shared)
        if self.known:
            checkpoint.log("known", cases=self.job.width * sum(map(len, self.known)), file=target.name)
        return checkpoint

    def close(self) -> None:
        """Close the finished scan whose cases are taken, where there is one."""
        if isinstance(self.job, VariantJob) and self.job.known is not None:
            self.job.known.close()

    def fill(self, checkpoint: Checkpoint, wanted: list[range]) -> None:
        """Solve the wanted batches that are not in the checkpoint."""
        self.work(wanted, checkpoint.done(), checkpoint.keep)


def _values(writer: DatasetWriter, batches: range, chunk: Chunk | None) -> Chunk:
    """Every case variable of these batches, which are known where there is no chunk of them."""
    if chunk is not None:
        return writer.values(batches, chunk)
    assert isinstance(writer, VariantWriter), "nothing else has samples"
    return writer.known(batches)


@contextmanager
def stoppable(checkpoint: Checkpoint) -> Iterator[None]:
    """Turn Ctrl-C into Stopped, which says what is kept and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        raise Stopped(
            f"{checkpoint.kept()} are kept in {checkpoint.path}; {checkpoint.again} goes on from there"
        ) from None


def scan(
    study: Scene | str | Path,
    out: str | Path | None = None,
    *,
    screening: bool = True,
    check_fraction: float = 0.01,
    workers: int | None = None,
    executor: Executor | None = None,
    new: bool = False,
    progress: Progress | None = None,
    command: str = "",
) -> xr.Dataset:
    """Run every case of the grid of a scene.

    Parameters
    ----------
    study : Scene, str or Path
        A scene, the path of a scene file, or the text of one.
    out : str or Path, optional
        File to write, ending in .nc or .zarr. Results are kept in a folder beside it as they are computed (``r.study``
        for ``r.nc``), and the same call goes on from there after an interruption. A file that is there is replaced
        where it holds the same scan; of one with fewer samples of the same uncertain numbers the cases are taken, and
        only the others are solved. Without ``out`` the dataset is in memory only.
    screening : bool
        Leave out runs whose result follows exactly from another run; the results are the same without it.
    check_fraction : float
        Share of the runs, from 0 to 1, that is repeated at a tighter tolerance, drawn at random, one run at least
        unless it is 0: the variables ``sensitive`` and ``change_...``.
    workers : int, optional
        Number of threads; one per processor by default. Results do not depend on it.
    executor : Executor, optional
        What solves the batches instead of threads, such as `Dask`.
    new : bool
        Discard what is kept of an earlier run, and replace whatever is under the name ``out``.
    progress : callable, optional
        Called with the number of cases done and the number of all cases.
    command : str
        The command line, for the attributes of the dataset.

    Returns
    -------
    xarray.Dataset
        Dimensions are record, polarity, pga (where the grid has several) [m/s2], or intensity where its levels are of
        another measure, contact_model, gap [m] and yield_force [N]; one of each axis of other numbers, by its address,
        and sample of uncertain ones; and those of the places, of which each variable has its own: interface,
        contact_point, building and storey; period [s] is of the records' spectra.
        A dataset of more than 100 MB that was written is read lazily.

    Raises
    ------
    SceneError
        For a scene with faults, or one that needs more memory or disk than there is.
    RecordError
        For a record that cannot be used.
    PoundingError
        For an ``out`` that cannot be written or holds other results, a checkpoint of another scan, and a full disk.
    Stopped
        At Ctrl-C, with what is kept; it is a KeyboardInterrupt.
    """
    target = None if out is None else _target(out)
    executor = executor or Threads(workers or cpu_count() or 1)
    run = Scan(study, RunOptions(executor, screening, check_fraction, progress, command))
    if target is None:
        return run.in_memory()
    run.check_room(target)
    with run.checkpoint(target, new=new, shared=False) as checkpoint:
        for path in remove_leftovers(target):  # the holder of the checkpoint is alone at the target
            checkpoint.log("removed", file=path.name, why="a process was killed while it wrote this")
        with stoppable(checkpoint):
            run.fill(checkpoint, [range(run.job.batches)])
            run.assemble(checkpoint.chunks, store_of(run.job.template, target), checkpoint.begun)
        checkpoint.clear()
    template = run.job.template
    return open_results(target, lazy=template.bytes_per_case * template.batches * template.width > LAZY)


def scan_shard(
    study: Scene | str | Path,
    out: str | Path,
    shard: str,
    *,
    screening: bool = True,
    check_fraction: float = 0.01,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    command: str = "",
) -> ShardDone:
    """Run one shard of a scan, and keep its results in the folder beside ``out``.

    Any number of processes, on machines that share the folder, may run shards at once. When all have ended, `scan` with
    the same arguments writes ``out``.

    Parameters
    ----------
    study : Scene, str or Path
        A scene, or the path of a scene file.
    out : str or Path
        File of the scan, ending in .nc or .zarr.
    shard : str
        Which shard of how many: "2/8" is the second of eight.
    screening : bool
        As for `scan`.
    check_fraction : float
        As for `scan`.
    workers : int, optional
        As for `scan`.
    executor : Executor, optional
        As for `scan`.
    progress : callable, optional
        Called with the number of cases done and the number of all cases of the shard.
    command : str
        As for `scan`.

    Returns
    -------
    ShardDone
        The cases of the shard, and how many of the scan are done.

    Raises
    ------
    PoundingError
        For a shard that does not exist, and as `scan`, which raises other errors too.
    """
    target, which = _target(out), read_shard(shard)
    executor = executor or Threads(workers or cpu_count() or 1)
    run = Scan(study, RunOptions(executor, screening, check_fraction, progress, command))
    run.check_room(target)
    wanted = merged(shard_batches(run.job.batches, which))
    with run.checkpoint(target, new=False, shared=True) as checkpoint:
        checkpoint.log("shard", shard=shard)
        with stoppable(checkpoint):
            run.fill(checkpoint, wanted)
        done = merged([*checkpoint.done(), *run.known])
    run.close()
    width = run.job.width
    return ShardDone(
        width * sum(map(len, wanted)), width * sum(map(len, done)), width * run.job.batches, checkpoint.path
    )


def _target(out: str | Path) -> Path:
    """The path to write the dataset to; raises PoundingError where that could not be done in the end."""
    target = check_target(out, RESULTS)
    if target.suffix.lower() == ".zarr":
        zarr_library()
    return target
