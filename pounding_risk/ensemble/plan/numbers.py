"""The numbers of a plan: cases, batches, chunks, bytes, seconds."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, prod
from typing import TYPE_CHECKING, NamedTuple

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.scene.scene import Study

if TYPE_CHECKING:
    from pounding_risk.ensemble.plan.compilation import Kernels


class PlannedRecord(NamedTuple):
    """A ground motion as the runs will see it, before polarity and the grid's amplitudes."""

    name: str
    event: str
    state: str  # "raw" or "processed", as it was found
    duration: float  # s, the tail included
    dt: float  # s
    pga: float  # m/s²
    flags: tuple[str, ...]  # one doubt a sentence
    processing: tuple[str, ...]  # one step a sentence


@dataclass(frozen=True, repr=False)
class PlanNumbers(ShortRepr):
    """The numbers of a plan: a scene without a fault, its records, and what its run takes on this machine.

    What would take compiling to know is None unless that was asked for.
    """

    study: Study
    records: tuple[PlannedRecord, ...]
    kernels: Kernels  # compiled before the plan was made
    bytes: int  # of the dataset's variables, before compression
    memory: int  # bytes, about, of a scan into a file
    threads: int
    notes: tuple[str, ...] = ()  # on unusual numbers of the scene and its records
    left_out: tuple[str, ...] = ()  # what of the files named is no record of the scene, and why
    changes: tuple[str, ...] = ()  # what `--set` changes, a value a line
    unused: tuple[str, ...] = ()  # keys of the scene that change nothing in it, and why
    compiled: bool = False  # whether the plan has compiled what was missing
    screened: int | None = None  # batches that the motion without contact answers, since it closes no gap
    share: float = 1.0  # of the batches that were looked at to learn what follows; a large grid is drawn from evenly
    seconds: float | None = None  # of solving, on so many threads
    error: float | None = None  # standard error of it [s]
    sampled: int = 0  # batches that were solved to learn this

    @property
    def shape(self) -> dict[str, int]:
        """How many values each dimension of the dataset has, in its order; one where the scene names no grid."""
        return shape_of(self.study, len(self.records))

    @property
    def cases(self) -> int:
        """The cases of the grid; some of them will be known without a run of their own."""
        return prod(self.shape.values())

    @property
    def batches(self) -> int:
        """The batches of the grid: all yield forces of a motion, contact model and gap."""
        return self.cases // self.shape["yield_force"]

    @property
    def chunks(self) -> int | None:
        """About as many as the run will have: the first batch of each contact model alone, the rest by time."""
        if self.seconds is None:
            return None
        from pounding_risk.ensemble.threads import SECONDS

        return min(self.batches, self.shape["contact_model"] + ceil(self.seconds * self.threads / SECONDS))

    @property
    def shaking(self) -> float:
        """Ground motion in all, over all cases [s]."""
        each = self.cases // len(self.records)
        return each * sum(record.duration for record in self.records)


def shape_of(study: Study, records: int) -> dict[str, int]:
    """How many values each dimension of the dataset has, by its name, in its order."""
    grid = study.grid
    return {
        "record": records,
        "polarity": len(study.records.polarities),
        "pga": len(grid.pgas),
        "contact_model": len(grid.contact_models),
        "gap": len(grid.gaps),
        "yield_force": len(grid.yield_forces),
    }
