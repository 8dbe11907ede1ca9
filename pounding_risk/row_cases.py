"""The cases of a row under one motion and one contact model: solved in parts, and no part twice.

The run of a part is known where an equal part has been solved: equal buildings, contact points, gaps, yield forces,
laws and restitutions; so it is where its yield forces lie above the largest force of the run with the grid's largest.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from concurrent.futures import Future
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk import rows
from pounding_risk.core.tally import COMPLETE, DEMAND
from pounding_risk.row_model import Part, RowModel
from pounding_risk.row_parts import HELD, Span, settled, tied
from pounding_risk.rows import CLOSING, GREW, Contacts, RowRun

Array = NDArray[np.float64]


class Runs:
    """Runs by what they are made of, each made once, by the thread that asks first."""

    def __init__(self) -> None:
        self._found: dict[Hashable, Future[RowRun]] = {}
        self._lock = Lock()

    def of(self, key: Hashable, make: Callable[[], RowRun]) -> RowRun:
        """The run of this key, made where nobody has asked for it; whoever asks meanwhile waits."""
        with self._lock:
            is_new = key not in self._found
            future = self._found.setdefault(key, Future())
        if is_new:
            try:
                future.set_result(make())
            except BaseException as error:
                future.set_exception(error)
                raise
        return future.result()


class Mechanics(NamedTuple):
    """One contact model of the grid: law and restitution at each contact point of a row."""

    laws: tuple[Any, ...]
    restitutions: tuple[Any, ...]
    capped: bool  # False where the yield force plays no part in the motion


class Limits(NamedTuple):
    """One case of the grid: what bounds the motion at each contact point."""

    gaps: Array  # m
    yield_forces: Array  # N
    largest: Array  # N, the yield forces of the grid's last case, the one that yields least


class Answered(NamedTuple):
    """How the run of a part was found: the run's key, and whether it is that of larger yield forces."""

    key: Hashable
    known: bool


class Cases:
    """Every case of one motion under one contact model, and the runs that they share."""

    def __init__(self, model: RowModel, mechanics: Mechanics, motion: tuple[Array, float], free: RowRun, rtol: float):
        self.model, self.mechanics, self.motion, self.free, self.rtol = model, mechanics, motion, free, rtol
        self._runs = Runs()

    def whole(self, limits: Limits) -> RowRun:
        """The case with all buildings solved at once, whatever is known."""
        return self._run(self.model.everything, limits.gaps, limits.yield_forces)

    def in_parts(self, limits: Limits) -> tuple[RowRun, list[Answered]]:
        """The case with only those solved together that are tied, and how each of their runs was found.

        A row none of whose interfaces the free motion closes has the free response, and no runs.
        """
        found: list[Answered] = []

        def solve(span: Span) -> tuple[RowRun, int]:
            run, answered = self._answer(span, limits)
            found.append(answered)
            return run, self.model.part(span).side(run.grew) if run.status == GREW else HELD

        shut = self.free.points[:, CLOSING] > limits.gaps
        closed = [bool(shut[start:stop].any()) for start, stop in zip(self.model.bounds, self.model.bounds[1:])]
        runs = settled(tied(closed), solve) if self.free.status == COMPLETE else {}
        return put_together(self.free, [(self.model.part(span), run) for span, run in runs.items()]), found

    def _answer(self, span: Span, limits: Limits) -> tuple[RowRun, Answered]:
        if self.mechanics.capped and not np.array_equal(limits.yield_forces, limits.largest):
            run, key = self._shared(span, limits.gaps, limits.largest)
            places = self.model.part(span).points
            given, largest = limits.yield_forces[places], limits.largest[places]
            demand = run.points[:, DEMAND]
            if run.status in (COMPLETE, GREW) and ((given > demand) | (given == largest)).all():
                return run, Answered(key, True)
        run, key = self._shared(span, limits.gaps, limits.yield_forces)
        return run, Answered(key, False)

    def _shared(self, span: Span, gaps: Array, yield_forces: Array) -> tuple[RowRun, Hashable]:
        """The run of a part, from an equal one where there is one, and its key."""
        part = self.model.part(span)
        within = np.arange(part.points.start, part.points.stop)[~part.watched]
        used = tuple((self.mechanics.laws[place], self.mechanics.restitutions[place]) for place in within)
        strengths = yield_forces[within].tobytes() if self.mechanics.capped else b""
        key = (part.structure, gaps[part.points].tobytes(), strengths, used)
        return self._runs.of(key, lambda: self._run(span, gaps, yield_forces)), key

    def _run(self, span: Span, gaps: Array, yield_forces: Array) -> RowRun:
        part = self.model.part(span)
        laws, restitutions = self.mechanics.laws[part.points], self.mechanics.restitutions[part.points]
        contacts = Contacts(gaps[part.points], yield_forces[part.points], laws, restitutions, part.watched)
        return rows.run_row(part.row, contacts, *self.motion, self.rtol)


def put_together(free: RowRun, parts: list[tuple[Part, RowRun]]) -> RowRun:
    """The whole row's run: the free response where nothing touches, each part's own where it was solved."""
    points, floors, rest = free.points.copy(), free.floors.copy(), free.rest.copy()
    status, steps, energy, residual = free.status, free.steps, free.energy, free.residual
    for part, run in parts:
        points[part.points] = run.points
        floors[part.masses], rest[part.masses] = run.floors[part.own], run.rest[part.own]
        status = status if status != COMPLETE else run.status
        steps += run.steps
        energy, residual = max(energy, run.energy), residual + run.residual
    return free._replace(
        points=points, floors=floors, rest=rest, status=status, steps=steps, energy=energy, residual=residual
    )
