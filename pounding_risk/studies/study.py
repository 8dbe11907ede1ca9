"""The skeleton of a study: its file is checked before any work, threads solve its batches, its dataset is saved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import cpu_count
from pathlib import Path
from typing import Any, cast

import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.progress import Progress
from pounding_risk.ensemble.chunks import Chunk, joined
from pounding_risk.ensemble.job import Job
from pounding_risk.ensemble.replacing import check_replaceable
from pounding_risk.ensemble.threads import Pending, Threads
from pounding_risk.motions.levels import Level
from pounding_risk.motions.motion import Motion
from pounding_risk.results.files import check_target, save
from pounding_risk.results.labels import measure_attributes
from pounding_risk.results.variables import described


def check_out(out: str | Path | None, command: str, new: bool) -> Path | None:
    """The file of the dataset; raises PoundingError where it cannot be written or holds other than ``command`` made."""
    if out is None:
        return None
    target = check_target(out)
    check_replaceable(target, command, new=new)
    return target


def saved(dataset: xr.Dataset, command: str, target: Path | None, **attributes: Any) -> xr.Dataset:
    """The dataset of a study with its last attributes and what made it, written where it has a file."""
    dataset.attrs |= attributes | created(f"pounding_risk.{command}")
    if target is not None:
        save(dataset, target)
    return dataset


class Batches:
    """Work in numbered batches, which the threads of a scan solve; the results do not depend on their number."""

    batches: int
    bytes_per_batch: int

    def one(self, number: int) -> Chunk:
        """Results of one batch; the first axis of every array is the batches'."""
        raise NotImplementedError

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """Results of these batches; None where it was stopped."""
        chunks = []
        for number in batches:
            if stop():
                return None
            chunks.append(self.one(number))
        return joined(chunks)

    def run(self, keep: Callable[[range, Chunk], None], workers: int | None, progress: Progress | None) -> None:
        """Solve all batches and pass each chunk to ``keep`` as it is finished, in any order."""
        done = 0

        def kept(batches: range, chunk: Chunk, seconds: float) -> None:
            nonlocal done
            keep(batches, chunk)
            done += len(batches)
            if progress is not None:
                progress(done, self.batches)

        pending = Pending([range(self.batches)], lambda _: 0, bytes_per_batch=self.bytes_per_batch)
        Threads(workers or cpu_count() or 1).run(cast(Job, self), pending, kept)

    def solved(self, workers: int | None = None, progress: Progress | None = None) -> Chunk:
        """Results of all batches, in their order."""
        chunks: dict[int, Chunk] = {}
        self.run(lambda batches, chunk: chunks.update({batches.start: chunk}), workers, progress)
        return joined([chunks[start] for start in sorted(chunks)])


def motion_coordinates(motions: Sequence[Motion], polarities: Sequence[str], level: Level | None) -> dict[str, Any]:
    """Coordinates of motions at one amplitude, which is that of a ``level`` where the grid of a scene sets it."""
    pgas = [motion.pga for motion in motions]
    coords: dict[str, Any] = {
        "record": ("record", [motion.name for motion in motions], {"long_name": "ground motion"}),
        "polarity": ("polarity", list(polarities), {"long_name": "sign of the ground motion"}),
        "record_pga": ("record", pgas, described("m/s2", "peak ground acceleration that the buildings felt")),
    }
    if level is not None:
        coords[level.measure.axis] = ((), level.value, measure_attributes(level.measure))
    return coords
