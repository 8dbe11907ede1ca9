"""A scene's whole grid: records × polarities × amplitudes × contact laws × gaps × yield forces → one dataset."""

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
from pounding_risk.ensemble.chunks import Chunk, ChunksInMemory, merged, without
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.job_choice import job_of
from pounding_risk.ensemble.limits import check_dataset, check_disk, check_held, check_memory
from pounding_risk.ensemble.plan.size import grid_bytes
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.ensemble.threads import Executor, Keep, Pending, Threads, read_shard, shard_batches
from pounding_risk.errors import Stopped
from pounding_risk.results.files import RESULTS, as_text, check_target, open_results, zarr_store
from pounding_risk.results.layout import blocks
from pounding_risk.results.provenance import provenance
from pounding_risk.results.store import Blockwise, Memory, store_of
from pounding_risk.results.tolerance_check import check_share
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import as_study
from pounding_risk.scene.scene import Study

if TYPE_CHECKING:
    from pounding_risk.ensemble.checkpoint.folder import Checkpoint

LAZY = 1e8  # bytes: a larger dataset is not read whole when it has been written


class ShardDone(NamedTuple):
    """What a shard has done, and how much of the study is done by all of them."""

    cases: int  # of this shard
    done: int
    total: int  # of the study
    folder: Path


class Scan:
    """A scan about to be made: its job, what its dataset says of itself, and who works."""

    def __init__(
        self,
        study: Study | str | Path,
        *,
        screening: bool,
        check_fraction: float,
        executor: Executor,
        progress: Progress | None,
        command: str,
    ):
        check_fraction = check_share(check_fraction)
        self.study = as_study(study)
        found = gathered(self.study)
        motions = len(found.motions)
        shape = (motions, len(self.study.records.polarities), *map(len, self.study.grid))
        self.bytes = grid_bytes(self.study, motions)
        check_dataset(self.study, prod(shape), self.bytes)
        check_memory(self.study, found.motions)
        self.job = job_of(ScanInput(self.study, found.motions, screening, check_fraction))
        self.command, self.executor, self.progress = command, executor, progress
        self.attrs: dict[str, Any] = provenance(self.study, found.motions, screening, check_fraction)
        if command:
            self.attrs["command"] = command
        if notes := of_input(self.study, found.motions):
            self.attrs["notes"] = as_text(list(notes))
        if found.left_out:
            self.attrs["left_out"] = as_text(list(found.left_out))
        if found.copies:
            self.attrs["copies"] = as_text(list(found.copies))

    def check_room(self, target: Path) -> None:
        """Raise SceneError where the disk has no room for what is not begun yet."""
        from pounding_risk.ensemble.checkpoint.folder import folder_of

        if not folder_of(target).exists():
            check_disk(self.study, self.bytes, target.parent)

    def work(self, wanted: list[range], done: list[range], keep: Keep) -> None:
        """Solve those of the wanted batches that are not done, and tell the progress among all that are wanted."""
        job, width = self.job, self.job.width
        left = without(wanted, done)
        total = width * sum(map(len, wanted))
        solved = total - width * sum(map(len, left))
        if self.progress:
            self.progress(solved, total)

        def kept(batches: range, part: Chunk, seconds: float) -> None:
            nonlocal solved
            keep(batches, part, seconds)
            solved += width * len(batches)
            if self.progress:
                self.progress(solved, total)

        if left:
            self.executor.run(job, Pending(left, job.law_at, bytes_per_batch=job.bytes_per_batch), kept)

    def assemble(self, parts: Callable[[Iterable[range]], Iterator[Chunk]], store: Blockwise, begun: str = "") -> None:
        """Write the dataset, block by block; ``begun`` is when its study was, where that is not now."""
        job, writer = self.job, self.job.writer()
        spans = list(blocks(job.template))
        with store:
            for batches, part in zip(spans, parts(spans), strict=True):
                store.write(batches, writer.values(batches, part))
            finish = writer.finish()
            for batch, patch in finish.patches:
                store.write(range(batch, batch + 1), patch)
            store.finish(finish.attrs | self.attrs | created(self.command or "pounding_risk.scan", begun))

    def folder(self, target: Path, *, new: bool, shared: bool) -> Checkpoint:
        """The study's folder beside its results, open."""
        from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint, folder_of, is_begun
        from pounding_risk.ensemble.identity import identity
        from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable

        about = About(self.job.batches, self.job.width, self.study.name, self.command)
        known, path = identity(self.job.scan_input, self.job.prepared), folder_of(target)
        # What was begun with leave to replace the file goes on without being asked again.
        if not is_begun(path, known):
            choice = {"choice": OTHER_NAME} if shared else {}
            check_replaceable(target, "scan", known, new, **choice)
        return Checkpoint.open(path, known, about, new=new, shared=shared)

    def fill(self, folder: Checkpoint, wanted: list[range]) -> None:
        """Work on what the folder lacks."""
        self.work(wanted, folder.done(), folder.keep)


@contextmanager
def stoppable(folder: Checkpoint) -> Iterator[None]:
    """While there are parts: Ctrl-C becomes Stopped, which says what is kept and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        raise Stopped(f"{folder.kept()} are kept in {folder.path}; {folder.again} goes on from there") from None


def scan(
    study: Study | str | Path,
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
    """Run every case of a scene's grid and return (and write to ``out``) one labelled dataset.

    Dimensions: record, polarity, pga (of several), contact_model [name], gap [m],
    yield_force [N]; see `outputs` for the variables. A row's are by interface, contact_point, building and storey as
    well; see `row_outputs`. ``screening`` leaves out runs whose answer is known exactly;
    the answers are the same without it. About ``check_fraction`` of the runs, drawn at random, one at least, are
    made again at a tighter tolerance: the variables ``sensitive`` and ``change_...`` say how far they move (see
    `recheck`). ``workers`` threads do the work, or an ``executor`` (see `executors`, `dask_executor`); no bit depends
    on it.

    What is solved on the way to an ``out`` (.nc or .zarr) is kept in a folder beside it: a second start goes on from
    there, unless ``new`` discards it. A file that is there is replaced where it is of the same study, and anything else
    only with ``new``. A dataset of more than 100 MB comes back lazy. ``command`` is the command
    batch, kept as an attribute. ``progress`` is called with (cases done, cases in all).

    Raises SceneError for a faulty scene, RecordError for a record that cannot be used, PoundingError for an
    ``out`` that cannot be written or holds other results, a study of another scene in its folder or a
    ``check_fraction`` outside 0 to 1, all of them before the first run. Raises PoundingError where the disk is full,
    and Stopped, a KeyboardInterrupt, where Ctrl-C ends it.
    """
    target = None if out is None else _target(out)
    one = Scan(
        study,
        screening=screening,
        check_fraction=check_fraction,
        executor=executor or Threads(workers or cpu_count() or 1),
        progress=progress,
        command=command,
    )
    whole = [range(one.job.batches)]
    if target is None:
        check_held(one.study, one.bytes)
        held, made = ChunksInMemory(), Memory(one.job.template)
        one.work(whole, [], held.keep)
        one.assemble(held.chunks, made)
        return made.dataset()
    one.check_room(target)
    with one.folder(target, new=new, shared=False) as folder:
        for path in remove_leftovers(target):  # whoever holds the folder is alone at the target
            folder.log("removed", file=path.name, why="a process was killed while it wrote this")
        with stoppable(folder):
            one.fill(folder, whole)
            one.assemble(folder.chunks, store_of(one.job.template, target), folder.begun)
        folder.clear()
    template = one.job.template
    return open_results(target, lazy=template.bytes_per_case * template.batches * template.width > LAZY)


def scan_shard(
    study: Study | str | Path,
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
    """Work on one ``shard`` of a scan, "2/8" the second of eight, and keep it in the study's folder beside ``out``.

    Any number of processes on machines that share the folder may do so at once. When all have ended, `scan` with the
    same arguments writes ``out``. Raises as `scan`.
    """
    target, which = _target(out), read_shard(shard)
    one = Scan(
        study,
        screening=screening,
        check_fraction=check_fraction,
        executor=executor or Threads(workers or cpu_count() or 1),
        progress=progress,
        command=command,
    )
    one.check_room(target)
    wanted = merged(shard_batches(one.job.batches, which))
    with one.folder(target, new=False, shared=True) as folder:
        folder.log("shard", shard=shard)
        with stoppable(folder):
            one.fill(folder, wanted)
        done = folder.done()
    width = one.job.width
    return ShardDone(width * sum(map(len, wanted)), width * sum(map(len, done)), width * one.job.batches, folder.path)


def _target(out: str | Path) -> Path:
    """Where the dataset goes; raises PoundingError, before any work, where it could not be written in the end."""
    target = check_target(out, RESULTS)
    if target.suffix.lower() == ".zarr":
        zarr_store()
    return target
