"""Work on threads: pieces of a grid, the first of each law alone, as it compiles; kernels release the interpreter."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import NamedTuple, Protocol, TypeVar

Progress = Callable[[int, int], None]
Done = TypeVar("Done")


class How(NamedTuple):
    """How a grid is worked through."""

    screening: bool  # leave out runs whose answer is known
    check_fraction: float  # of the runs, made again
    workers: int  # threads
    progress: Progress | None


class Piece(Protocol):
    """A piece of work that knows which of the grid's contact laws it needs."""

    @property
    def law(self) -> int:
        """The law's place in the grid."""


Some = TypeVar("Some", bound=Piece)


def work_through(
    pieces: Iterable[Some], work: Callable[[Some], Done], workers: int, advance: Callable[[Done], None]
) -> None:
    """Do every piece; ``advance`` is told what each gave, here and not on its thread, in the order they end.

    An interrupt waits for the pieces under way and drops the others.
    """
    # The first piece of each law compiles its kernel: not on two threads at once.
    laws: set[int] = set()
    rest: list[Some] = []
    for piece in pieces:
        if piece.law in laws:
            rest.append(piece)
        else:
            laws.add(piece.law)
            advance(work(piece))
    pool = ThreadPoolExecutor(workers)
    try:
        for future in as_completed([pool.submit(work, piece) for piece in rest]):
            advance(future.result())
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def counter(total: int, progress: Progress | None) -> Callable[[int], None]:
    """What tells ``progress`` how many of the ``total`` cases are done."""
    done = 0

    def advance(size: int) -> None:
        nonlocal done
        done += size
        if progress:
            progress(done, total)

    return advance
