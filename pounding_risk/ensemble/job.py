"""A study as work: batches of its grid, each a pure function of its own numbers, and how a dataset follows from them.

What a batch gives does not depend on who solves it, when, or together with which others: a dataset has the same bits
for any number of threads, processes, shards or chunks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from numpy.typing import NDArray

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import Template
from pounding_risk.scene.scene import Study


class ScanInput(NamedTuple):
    """All that a job is made of; another process makes the same job from it."""

    study: Study
    motions: tuple[Motion, ...]
    screening: bool = True  # leave out runs whose answer is known
    check_fraction: float = 0.0  # of the runs, made again


class Finish(NamedTuple):
    """What is known of a dataset after its last batch."""

    attrs: dict[str, Any]
    patches: tuple[tuple[int, Chunk], ...] = ()  # variables of single batches to write again


class DatasetWriter(Protocol):
    """From parts, in the order of the batches, to the variables of a dataset."""

    def values(self, batches: range, part: Chunk) -> dict[str, NDArray[Any]]:
        """Every case variable of these batches: (batches, yield forces, its own dimensions)."""

    def finish(self) -> Finish:
        """After the last batch."""


class Job(Protocol):
    """A study that can be worked through."""

    scan_input: ScanInput
    batches: int
    width: int  # cases in a batch
    bytes_per_batch: int  # of a part

    @property
    def prepared(self) -> str:
        """Digest of what runs are made of and what is computed before them, by libraries that choose by processor."""

    def law_at(self, batch: int) -> int:
        """Which of the grid's contact models a batch needs, compiled."""

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """What these batches give; None where ``stop`` turned true on the way. Threads may call it at once."""

    @property
    def template(self) -> Template:
        """Of the dataset."""

    def writer(self) -> DatasetWriter:
        """A new one, before the first batch."""


def never() -> bool:
    """What goes on to the end."""
    return False
