"""Which buildings of a row must be solved together, and what happens where pounding ties more of them.

Interfaces that the free motion closes tie buildings into parts. A part is solved with its neighbours beside it,
which move freely as long as nothing touches them; where the part touches one, it grows by it and is solved again. If
none is touched, all buildings move as in the whole row: the motions put together obey every equation of the row, and
its motion is unique.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeVar

Answer = TypeVar("Answer")

HELD, LEFTWARDS, RIGHTWARDS = 0, -1, 1  # how a part's run ended: alone, or touching a neighbour on this side


class Span(NamedTuple):
    """Buildings that are solved together, by number from the left, both ends included."""

    first: int
    last: int

    def meets(self, other: Span) -> bool:
        """True where the two share a building or stand side by side: either would watch the other move freely."""
        return self.first <= other.last + 1 and other.first <= self.last + 1

    def joined(self, other: Span) -> Span:
        """Smallest range of buildings that holds both ranges."""
        return Span(min(self.first, other.first), max(self.last, other.last))

    def grown(self, side: int) -> Span:
        """The range with the neighbour on this side added."""
        return Span(self.first - (side == LEFTWARDS), self.last + (side == RIGHTWARDS))


def tied(closed: Iterable[bool]) -> list[Span]:
    """The parts of a row, left to right, of which these interfaces are closed.

    Parts that stand side by side are one: neither may take the other for a neighbour that moves freely.
    """
    return gathered(Span(interface, interface + 1) for interface, shut in enumerate(closed) if shut)


def gathered(spans: Iterable[Span]) -> list[Span]:
    """The same buildings in as few spans as stand apart, left to right."""
    groups: list[Span] = []
    for span in sorted(spans):
        if groups and groups[-1].meets(span):
            groups[-1] = groups[-1].joined(span)
        else:
            groups.append(span)
    return groups


def solved_spans(spans: list[Span], solve: Callable[[Span], tuple[Answer, int]]) -> dict[Span, Answer]:
    """The answer of every part, once all stand alone: from the left, each grown as its own run demands.

    ``solve`` gives a part's answer and how it ended: `HELD`, or the side on which it touches a neighbour.
    """
    answers: dict[Span, tuple[Answer, int]] = {}
    while True:
        for span in spans:
            if span not in answers:
                answers[span] = solve(span)
            side = answers[span][1]
            if side != HELD:
                spans = gathered([*(other for other in spans if other != span), span.grown(side)])
                break
        else:
            return {span: answers[span][0] for span in spans}
