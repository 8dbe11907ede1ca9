"""The work of a grid before it is done: its lines, which of them touch, and what one takes on this machine.

A *line* is the smallest piece of a grid: one record, polarity, amplitude, contact model and gap, with all yield forces.
Where the motion without contact closes no gap, that motion is the answer.
"""

from __future__ import annotations

from functools import cached_property
from math import sqrt
from time import thread_time
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pounding_risk import rows
from pounding_risk._jit import lowered
from pounding_risk.core.collide import make_desk
from pounding_risk.core.sweep import sweep
from pounding_risk.core.tally import COMPLETE
from pounding_risk.ensemble import free_responses, laws_of
from pounding_risk.motions import Motion, driven
from pounding_risk.outputs import COLUMNS
from pounding_risk.pair import oscillators
from pounding_risk.plan_sizes import bytes_of
from pounding_risk.row_cases import Cases, Driven
from pounding_risk.row_grid import RowGrid, model_of, row_grid
from pounding_risk.row_outputs import outputs
from pounding_risk.row_scan import stacked
from pounding_risk.rows import HIGHEST
from pounding_risk.study import Study

SECONDS = 1.0  # of solving lines to learn what they cost, over all contact models
LEAST = 4  # lines of a contact model that are solved, however long they take
SEED = 20110314  # of the sample: the same lines for the same scene on any day
GOLDEN = 0.5 * (sqrt(5.0) - 1.0)  # multiples of it, modulo 1, fall evenly over 0 to 1 however many there are


class Work(Protocol):
    """A grid that can be solved by the line."""

    def law_at(self, line: int) -> int:
        """The contact model's place in the grid."""

    def solve(self, lines: range) -> Any:
        """What these lines give."""

    def closed(self) -> NDArray[np.float64]:
        """How far the motion without contact closes the tightest gap [m]: (records, polarities, amplitudes, gaps).

        Lines in which it closes none have no value above zero.
        """

    @property
    def bytes_held(self) -> int:
        """Of the responses without contact."""


class PairWork:
    """Two buildings that meet mass to mass; raises as `ensemble.law_of` where lines are solved."""

    def __init__(self, study: Study, motions: tuple[Motion, ...]):
        self.study, self.pair = study, oscillators(*study.pair)
        self.frees = free_responses(study, motions)
        self.gaps, self.yield_forces = np.array(study.grid.gaps), np.array(study.grid.yield_forces)
        self._laws: tuple[Any, ...] = ()

    def closed(self) -> NDArray[np.float64]:
        """See `Work`."""
        closing = np.array([free.high[:, 0].max() for free in self.frees.flat]).reshape(self.frees.shape)
        return closing[..., None] - self.gaps

    def law_at(self, line: int) -> int:
        """See `Work`."""
        return line // self.gaps.size % len(self.study.grid.contact_models)

    def solve(self, lines: range) -> NDArray[np.float64]:
        """See `Work`."""
        self._laws = self._laws or laws_of(self.study)
        shape, rtol = (*self.frees.shape, len(self._laws), self.gaps.size), self.study.rtol
        raw = np.zeros((len(lines), self.yield_forces.size, COLUMNS))
        how = np.zeros(raw.shape[:2], np.int8)
        for place, line in enumerate(lines):
            *motion, law, gap = map(int, np.unravel_index(line, shape))
            grid = self.gaps[gap : gap + 1], self.yield_forces, self.study.restitution
            out = raw[place : place + 1], how[place : place + 1]
            free = self.frees[tuple(motion)]
            sweep(self.pair, free, lowered(self._laws[law]), grid, rtol, True, make_desk(rtol), *out)
        return raw

    @property
    def bytes_held(self) -> int:
        """See `Work`."""
        return sum(map(bytes_of, self.frees.flat))


class RowWork:
    """A row of buildings; raises as `row_grid.row_grid` where lines are solved."""

    def __init__(self, study: Study, motions: tuple[Motion, ...]):
        self.study, self.model = study, model_of(study)
        self.driven = np.empty((len(motions), len(study.records.polarities), len(study.grid.pgas)), dtype=object)
        for place in np.ndindex(self.driven.shape):
            motion = driven(motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]])
            free = rows.free_row(self.model.row(motion.dt), motion.acceleration)
            self.driven[place] = Driven(motion.acceleration, motion.dt, motion.pga, free)

    @cached_property
    def grid(self) -> RowGrid:
        """Laws and all that is needed to solve; a stiffness by equal terms takes runs to find."""
        return row_grid(self.study)

    def closed(self) -> NDArray[np.float64]:
        """See `Work`."""
        gaps = np.array([self.study.interface_gaps(gap) for gap in self.study.grid.gaps])[:, self.model.interfaces]
        frees = [one.free for one in self.driven.flat]
        found = np.array([(free.points[:, HIGHEST] - gaps).max(axis=1) for free in frees])
        found[[free.status != COMPLETE for free in frees]] = 0.0
        return found.reshape(*self.driven.shape, len(gaps))

    def law_at(self, line: int) -> int:
        """See `Work`."""
        grid = self.study.grid
        return line // len(grid.gaps) % len(grid.contact_models)

    def solve(self, lines: range) -> list[dict[str, NDArray[Any]]]:
        """See `Work`; nothing is known from other lines."""
        laws, gaps, strengths = self.grid.shape
        found = []
        for line in lines:
            *motion, law, gap = map(int, np.unravel_index(line, (*self.driven.shape, laws, gaps)))
            one = self.driven[tuple(motion)]
            cases = Cases(self.grid.model, self.grid.mechanics[law], one, self.grid.rtol)
            runs = [cases.in_parts(self.grid.limits(gap, level))[0] for level in range(strengths)]
            found.append(outputs(stacked(runs), self.grid.yield_forces, one.pga, self.grid.frame))
        return found

    @property
    def bytes_held(self) -> int:
        """See `Work`."""
        return sum(map(bytes_of, self.driven.flat))


def work_of(study: Study, motions: tuple[Motion, ...]) -> Work:
    """The work of a pair's or a row's grid, its motions without contact solved."""
    return RowWork(study, motions) if study.is_row else PairWork(study, motions)


class Cost(NamedTuple):
    """What a line takes of some that are alike, from a sample of them."""

    lines: int
    sampled: int
    mean: float  # CPU seconds a line
    deviation: float  # of single lines

    @property
    def seconds(self) -> float:
        """Of all lines, on one thread."""
        return self.lines * self.mean

    @property
    def error(self) -> float:
        """Standard error of it; a sample of one line tells no more than its own size, one of all has none."""
        if self.sampled == 1 < self.lines:
            return self.seconds
        left = 1.0 - self.sampled / self.lines
        return self.lines * self.deviation * sqrt(left / self.sampled)


def seconds_a_line(work: Work, lines: NDArray[np.int64], seconds: float) -> Cost:
    """What these lines take: as many of them as ``seconds`` allow, in the order given, are solved on this thread.

    One of them is solved before: it compiles, or fetches from the cache, what it needs.
    """
    work.solve(_one(lines[0]))
    taken: list[float] = []
    for line in lines:
        if len(taken) >= LEAST and sum(taken) >= seconds:
            break
        start = thread_time()
        work.solve(_one(line))
        taken.append(thread_time() - start)
    return Cost(len(lines), len(taken), float(np.mean(taken)), float(np.std(taken, ddof=1)) if len(taken) > 1 else 0.0)


def _one(line: np.int64) -> range:
    return range(int(line), int(line) + 1)


def costs(work: Work, closed: NDArray[np.float64], laws: int) -> list[Cost]:
    """What the lines of a grid take: those of each contact model that touch, then all others.

    ``closed`` as `Work.closed`. Lines differ mostly by how far they close their gap, so a sample spreads over that.
    """
    everywhere = np.repeat(closed[..., None, :], laws, axis=-2)
    kinds = np.broadcast_to(np.arange(laws)[:, None], everywhere.shape[-2:])
    kind = np.where(everywhere > 0.0, kinds, laws).reshape(-1)
    random = np.random.default_rng(SEED)
    found = []
    for each in range(laws + 1):
        lines = np.flatnonzero(kind == each)
        if lines.size:
            ordered = lines[np.argsort(everywhere.reshape(-1)[lines], kind="stable")]
            found.append(seconds_a_line(work, ordered[_spread(lines.size, random.random())], SECONDS / (laws + 1)))
    return found


def _spread(count: int, offset: float) -> NDArray[np.int64]:
    """The places 0 … ``count`` − 1 in an order of which any beginning lies evenly over all of them."""
    return np.argsort(np.argsort((offset + GOLDEN * np.arange(count)) % 1.0))
