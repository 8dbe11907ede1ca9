"""The interface of a job: a scan as batches, each a pure function of its number, and the dataset that follows.

The result of a batch does not depend on who solves it, when, or together with which others: a dataset has the same bits
for any number of threads, processes, shards or chunks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from numpy.typing import NDArray

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import Template
from pounding_risk.scene.scene import Scene


class ScanInput(NamedTuple):
    """All that a job is made from; another process makes the same job from it."""

    study: Scene
    motions: tuple[Motion, ...]
    screening: bool = True  # leave out runs whose result follows from another run
    check_fraction: float = 0.0  # share of the runs that is repeated at a tighter tolerance


class Finish(NamedTuple):
    """Attributes and corrections of a dataset that are known only after the last batch."""

    attrs: dict[str, Any]
    patches: tuple[tuple[int, Chunk], ...] = ()  # variables of single batches to be written again
    counts: dict[str, int] = {}  # noqa: RUF012 - that add up where one dataset is made by several writers


class DatasetWriter(Protocol):
    """Computes the variables of a dataset from chunks, which are passed in the order of the batches."""

    def values(self, batches: range, chunk: Chunk) -> dict[str, NDArray[Any]]:
        """Every case variable of these batches: (batches, yield forces, its own dimensions)."""

    def finish(self) -> Finish:
        """Attributes and corrections, to be asked for after the last batch."""


class Job(Protocol):
    """A scan that an executor can work through."""

    scan_input: ScanInput
    batches: int  # of the grid
    width: int  # cases in a batch
    bytes_per_batch: int  # of its results in a chunk

    @property
    def prepared(self) -> str:
        """Digest of the input of runs, and of numbers that libraries compute before them and that depend on the CPU."""

    def law_at(self, batch: int) -> int:
        """Index of the contact model that a batch needs compiled."""

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """Results of these batches; None where ``stop`` turned true meanwhile. Several threads may call it at once."""

    @property
    def template(self) -> Template:
        """The dataset without the values of its cases."""

    def writer(self) -> DatasetWriter:
        """A new dataset writer, before the first batch."""


def never() -> bool:
    """Stop condition that is never true."""
    return False
