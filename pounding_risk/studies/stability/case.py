"""What a hard case is, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from pounding_risk.solver.counters import COMPLETE, STATUS_SENTENCES
from pounding_risk.studies.stability.trial import Trial


class Bound(NamedTuple):
    """The largest figure that a case may have: ``fixed`` + ``times`` × rtol, and why."""

    fixed: float
    times: float
    why: str

    def at(self, rtol: float) -> float:
        """The bound at a tolerance."""
        return self.fixed + self.times * rtol


class Case(NamedTuple):
    """One hard case. ``figure`` runs it and returns by how much, without a unit, the invariant is missed."""

    number: str
    group: str
    scene: str
    invariant: str
    figure: Callable[[Trial], float]
    bound: Bound
    laws: tuple[str, ...]


class Row(NamedTuple):
    """What came of one case under one law. ``seconds`` counts the compiling of a law that was not used before."""

    case: Case
    law: str
    figure: float
    bound: float
    status: str
    steps: int
    seconds: float

    @property
    def holds(self) -> bool:
        """True where the runs ended as they should and the figure, a number, keeps its bound."""
        return self.status == STATUS_SENTENCES[COMPLETE] and self.figure <= self.bound
