"""A study as work: lines of its grid, each a pure function of its own numbers, and how a dataset follows from them.

What a line gives does not depend on who solves it, when, or together with which others: a dataset has the same bits
for any number of threads, processes, shards or chunks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from numpy.typing import NDArray

from pounding_risk.ensemble.chunks import Part
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import Form
from pounding_risk.scene.scene import Study


class Order(NamedTuple):
    """All that a job is made of; another process makes the same job from it."""

    study: Study
    motions: tuple[Motion, ...]
    screening: bool = True  # leave out runs whose answer is known
    check_fraction: float = 0.0  # of the runs, made again


class Finish(NamedTuple):
    """What is known of a dataset after its last line."""

    attrs: dict[str, Any]
    patches: tuple[tuple[int, Part], ...] = ()  # variables of single lines to write again


class Labeller(Protocol):
    """From parts, in the order of the lines, to the variables of a dataset."""

    def values(self, lines: range, part: Part) -> dict[str, NDArray[Any]]:
        """Every case variable of these lines: (lines, yield forces, its own dimensions)."""

    def finish(self) -> Finish:
        """After the last line."""


class Job(Protocol):
    """A study that can be worked through."""

    order: Order
    lines: int
    width: int  # cases in a line
    bytes_a_line: int  # of a part

    @property
    def prepared(self) -> str:
        """Digest of what runs are made of and what is computed before them, by libraries that choose by processor."""

    def law_at(self, line: int) -> int:
        """Which of the grid's contact models a line needs, compiled."""

    def solve(self, lines: range, stop: Callable[[], bool]) -> Part | None:
        """What these lines give; None where ``stop`` turned true on the way. Threads may call it at once."""

    @property
    def form(self) -> Form:
        """Of the dataset."""

    def labeller(self) -> Labeller:
        """A new one, before the first line."""


def never() -> bool:
    """What goes on to the end."""
    return False
