"""The cases of a row under one motion and one contact model: solved in parts, and no part twice.

The run of a part is known where an equal part has been solved: equal buildings, contact points, gaps, yield forces,
laws and restitutions; so it is where its yield forces lie above the largest force of the run with the grid's largest.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from hashlib import blake2b
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.solver.counters import COLLAPSED, COMPLETE, DEMAND, ENERGY, FIRST_YIELD, RESIDUAL, YIELDS
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import GREW_STATUS, HIGHEST, Contacts, RowRun
from pounding_risk.solver.row.impulsive.api import jumps, run_jumps
from pounding_risk.solver.row.model import Part, RowModel
from pounding_risk.solver.row.outputs import Frame
from pounding_risk.solver.row.partition import HELD, Span, solved_spans, tied
from pounding_risk.solver.row.workspace import FreeMotion

Array = NDArray[np.float64]


class Driven(NamedTuple):
    """A motion of the grid and the row's response to it without contact."""

    acceleration: Samples  # m/s², (n,) of all buildings or (buildings, n) of each
    dt: float  # s
    pga: Samples | float  # m/s², the peak of it, of all buildings or of each
    free: RowRun


class Mechanics(NamedTuple):
    """One contact model of the grid: law and restitution at each contact point of a row."""

    laws: tuple[Any, ...]
    restitutions: tuple[Any, ...]
    levels: Array  # N, every finite yield force of the grid, ascending

    @property
    def uncapped(self) -> NDArray[np.bool_]:
        """By contact point: True where the yield force plays no part in the motion."""
        return np.array([law.ceiling(1.0) == inf for law in self.laws])


class Limits(NamedTuple):
    """One case of the grid: what bounds the motion at each contact point."""

    gaps: Array  # m
    yield_forces: Array  # N
    largest: Array  # N, the yield forces of the grid's last case, the one that yields least


class RowGrid(NamedTuple):
    """The grid of a study of a row, as its cases need it."""

    frame: Frame
    mechanics: tuple[Mechanics, ...]  # by contact model
    gaps: Array  # (gaps, interfaces) [m]
    yield_forces: Array  # (yield forces, points of the model) [N]
    rtol: float

    @property
    def model(self) -> RowModel:
        """The row of buildings with its contact points."""
        return self.frame.model

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of contact models, gaps and yield forces."""
        return len(self.mechanics), len(self.gaps), len(self.yield_forces)

    def limits(self, gap: int, strength: int) -> Limits:
        """Gaps and yield forces of one case, by point of the model."""
        return Limits(self.model.gaps(self.gaps[gap]), self.yield_forces[strength], self.yield_forces[-1])


class Answered(NamedTuple):
    """How the run of a part was found: the run's key, and whether it is that of larger yield forces."""

    key: tuple[bytes, ...]
    known: bool


class Cases:
    """Every case of one motion under one contact model, and the runs that they share."""

    def __init__(
        self,
        model: RowModel,
        mechanics: Mechanics,
        driven: Driven,
        rtol: float,
        motion: Callable[[], FreeMotion] | None = None,
    ):
        """``motion`` gives the whole row's motion without contact; it is found anew where it is not given."""
        self.model, self.mechanics, self.driven, self.rtol = model, mechanics, driven, rtol
        self._motion = motion or (lambda: self._own_motion)
        self._uncapped = mechanics.uncapped
        self._many = driven.acceleration.ndim == 2
        self._runs: Shared[RowRun] = Shared()
        self._met: dict[Span, bytes] = {}

    @cached_property
    def _own_motion(self) -> FreeMotion:
        """The whole row's motion without contact."""
        return rows.free_response(self.model.row(self.driven.dt, self._many), self.driven.acceleration).motion

    def whole(self, limits: Limits) -> RowRun:
        """The case with all buildings solved at once, whatever is known."""
        return self._whole(limits, histories=False)

    def in_full(self, limits: Limits) -> RowRun:
        """As `whole`, the same run to the bit, with u and v at the nodes and the log of its groups."""
        return self._whole(limits, histories=True)

    def _whole(self, limits: Limits, *, histories: bool) -> RowRun:
        span = self.model.everything
        part_run = self._run(span, limits.gaps, limits.yield_forces, histories=histories)
        run = self._levelled(part_run, limits.yield_forces, self._uncapped)
        row_run = put_together(self.driven.free, [(self._part(span), run)])
        return row_run._replace(states=run.states, log=run.log)

    def in_parts(self, limits: Limits) -> tuple[RowRun, list[Answered]]:
        """The case with only those solved together that are tied, and how each of their runs was found.

        A row none of whose interfaces the free motion closes has the free response, and no runs.
        """
        answers: list[Answered] = []

        def solve(span: Span) -> tuple[RowRun, int]:
            run, answered = self._answer(span, limits)
            answers.append(answered)
            return run, self._part(span).side(run.grew) if run.status == GREW_STATUS else HELD

        free, bounds = self.driven.free, self.model.body_bounds
        shut = free.points[:, HIGHEST] > limits.gaps
        is_solved = self.model.is_always_solved or free.status == COLLAPSED  # a storey, which a neighbour may hold up
        closed = [is_solved or bool(shut[start:stop].any()) for start, stop in pairwise(bounds)]
        runs = solved_spans(tied(closed), solve) if free.status in (COMPLETE, COLLAPSED) else {}
        return put_together(free, [(self._part(span), run) for span, run in runs.items()]), answers

    def _part(self, span: Span) -> Part:
        return self.model.part(span, self.driven.dt, self._many)

    def _answer(self, span: Span, limits: Limits) -> tuple[RowRun, Answered]:
        points = self._part(span).points
        yield_forces, largest, uncapped = limits.yield_forces[points], limits.largest[points], self._uncapped[points]
        if not uncapped.all() and not np.array_equal(yield_forces, largest):
            run, key = self._shared(span, limits.gaps, limits.largest)
            unyielding = (yield_forces > run.points[:, DEMAND]) | (yield_forces == largest) | uncapped
            if run.status in (COMPLETE, GREW_STATUS) and unyielding.all():
                return self._levelled(run, yield_forces, uncapped), Answered(key, True)
        run, key = self._shared(span, limits.gaps, limits.yield_forces)
        return self._levelled(run, yield_forces, uncapped), Answered(key, False)

    def _shared(self, span: Span, gaps: Array, yield_forces: Array) -> tuple[RowRun, tuple[bytes, ...]]:
        """The run of a part, from an equal one where there is one, and its key."""
        part = self._part(span)
        within = np.arange(part.points.start, part.points.stop)[~part.watched]
        strengths = yield_forces[within].tobytes() if not self._uncapped.all() else b""
        key = (part.structure, gaps[part.points].tobytes(), strengths, self._meeting(span, within))
        return self._runs.of(key, lambda: self._run(span, gaps, yield_forces)), key

    def _meeting(self, span: Span, within: NDArray[np.int64]) -> bytes:
        """Laws and restitutions at the contact points of a part, all numbers of them; kept for the next time."""
        if span not in self._met:
            contact_models = [(self.mechanics.laws[k], self.mechanics.restitutions[k]) for k in within]
            self._met[span] = blake2b(repr(contact_models).encode(), digest_size=16).digest()
        return self._met[span]

    def _run(self, span: Span, gaps: Array, yield_forces: Array, *, histories: bool = False) -> RowRun:
        part, mechanics = self._part(span), self.mechanics
        points = part.points
        contacts = Contacts(
            gaps[points], yield_forces[points], mechanics.laws[points], mechanics.restitutions[points], part.watched
        )
        acceleration = part.under(self.driven.acceleration)
        if jumps(mechanics.laws):
            free = self._free_of(part)
            return run_jumps(part.row, contacts, acceleration, free, rtol=self.rtol, histories=histories)
        return rows.run_row(
            part.row,
            contacts,
            acceleration,
            rtol=self.rtol,
            levels=mechanics.levels if self._uncapped.any() else None,
            histories=histories,
            free=rows.motion_of_part(part.row, self._motion(), acceleration, part.first_dof, points.start),
        )

    def _free_of(self, part: Part) -> RowRun:
        """The motion without contact of the buildings of a part and of the neighbours beside it.

        The fastest closing is that of the whole row: neighbours that move alike until others strike them have none.
        """
        free, first = self.driven.free, part.masses.start - part.own_masses.start
        masses = slice(first, first + part.row.masses.size)
        return free._replace(
            points=free.points[part.points],
            floors=free.floors[masses],
            rest=free.rest[masses],
            fastest=np.full(len(part.watched), free.fastest.max(initial=0.0)),
        )

    def _levelled(self, run: RowRun, yield_forces: Array, uncapped: NDArray[np.bool_]) -> RowRun:
        """The run with the contacts counted whose force reaches these yield forces, where a law has no cap."""
        levels = self.mechanics.levels
        if not uncapped.any() or not run.reached.size:
            return run
        points, finite = run.points.copy(), np.isfinite(yield_forces)
        level = np.where(finite, np.searchsorted(levels, yield_forces), 0)[:, None]
        reached = np.where(finite, np.take_along_axis(run.reached, level, 1)[:, 0], 0.0)
        first = np.where(finite, np.take_along_axis(run.first, level, 1)[:, 0], np.nan)
        points[uncapped, YIELDS], points[uncapped, FIRST_YIELD] = reached[uncapped], first[uncapped]
        return run._replace(points=points)


def put_together(free: RowRun, parts: list[tuple[Part, RowRun]]) -> RowRun:
    """The whole row's run: the free response where nothing touches, each part's own where it was solved.

    Every contact point has the energy ledger of its part.
    """
    points, floors, rest = free.points.copy(), free.floors.copy(), free.rest.copy()
    status, steps = free.status, free.steps
    if parts and status == COLLAPSED:  # without contact; with it the row's own run says
        status = COMPLETE
    for part, run in parts:
        points[part.points] = run.points
        within = points[part.points]
        within[~part.watched, RESIDUAL], within[~part.watched, ENERGY] = abs(run.residual), run.energy
        floors[part.masses], rest[part.masses] = run.floors[part.own_masses], run.rest[part.own_masses]
        status = status if status != COMPLETE else run.status
        steps += run.steps
    return free._replace(points=points, floors=floors, rest=rest, status=status, steps=steps)
