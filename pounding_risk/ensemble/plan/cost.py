"""The work of a grid before it is done: which of its batches touch, and what one takes on this machine.

A *batch* is the smallest piece of a grid: one record, polarity, amplitude, contact model and gap, with all yield
forces.
Where the motion without contact closes no gap, that motion is the answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import prod, sqrt
from time import thread_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.job import Job, ScanInput, never
from pounding_risk.ensemble.job_choice import job_of
from pounding_risk.ensemble.plan.size import bytes_of
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.models.effects.contact import wave_of
from pounding_risk.motions.motion import Motion, driven
from pounding_risk.scene.scene import Study
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import HIGHEST

SECONDS = 1.0  # of solving batches to learn what they cost, over all contact models
FEW = 40  # yield forces of a batch that is solved
LEAST = 4  # batches of a contact model that are solved, unless they take longer than `LONGEST`
LONGEST = 4.0  # s of solving, after which no further batch of a contact model is begun
MOST_BATCHES = 20_000  # batches of a grid that are looked at: of a larger one some gaps and amplitudes, evenly drawn
SEED = 20110314  # of the sample: the same batches for the same scene on any day
GOLDEN = 0.5 * (sqrt(5.0) - 1.0)  # multiples of it, modulo 1, fall evenly over 0 to 1 however many there are

Response = Callable[[Motion], tuple[NDArray[np.float64], int]]  # how far each gap is closed [m], and bytes


class Alone(NamedTuple):
    """A grid's motions without contact."""

    closed: NDArray[np.float64]  # m, (records, polarities, amplitudes, gaps): more than zero where some gap is closed
    size: int  # bytes of one response, the largest

    @property
    def motions(self) -> int:
        """How many there are."""
        return prod(self.closed.shape[:-1])


def alone(study: Study, motions: tuple[Motion, ...]) -> Alone:
    """How far each motion of the grid closes the tightest gap without contact; raises as `chain_of`."""
    respond = _of_row(study) if study.is_row else _of_pair(study)
    shape = (len(motions), len(study.records.polarities), len(study.grid.pgas))
    closed, size = np.zeros((*shape, len(study.grid.gaps))), 0
    for place in np.ndindex(shape):
        motion = driven(motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]])
        closed[place], held = respond(motion)
        size = max(size, held)
    return Alone(closed, size)


def _of_pair(study: Study) -> Response:
    pair, wave, gaps = oscillators(*study.pair), wave_of(study.effects), np.array(study.grid.gaps)

    def respond(motion: Motion) -> tuple[NDArray[np.float64], int]:
        free = free_response(pair, motion.acceleration, motion.dt, wave)
        return free.high[:, 0].max() - gaps, bytes_of(free)

    return respond


def _of_row(study: Study) -> Response:
    model = model_of(study)
    gaps = np.array([study.interface_gaps(gap) for gap in study.grid.gaps])[:, model.interfaces]

    def respond(motion: Motion) -> tuple[NDArray[np.float64], int]:
        free = rows.free_row(model.row(motion.dt), motion.acceleration)
        held = bytes_of(free) + motion.acceleration.nbytes
        # A response that fails is the answer as it is.
        return (free.points[:, HIGHEST] - gaps).max(axis=1) if free.status == COMPLETE else np.zeros(len(gaps)), held

    return respond


class Cost(NamedTuple):
    """What a batch takes of some that are alike, from a sample of them."""

    batches: int
    sampled: int
    mean: float  # CPU seconds a batch
    deviation: float  # of single batches

    @property
    def seconds(self) -> float:
        """Of all batches, on one thread."""
        return self.batches * self.mean

    @property
    def error(self) -> float:
        """Standard error of it; one batch of several tells no more than its own size."""
        if self.sampled == 1 < self.batches:
            return self.seconds
        left = 1.0 - self.sampled / self.batches
        return self.batches * self.deviation * sqrt(left / self.sampled)


def costs(study: Study, motions: tuple[Motion, ...], closed: NDArray[np.float64]) -> list[Cost]:
    """What the batches of a grid take: those of each contact model that touch, then all others.

    ``closed`` as `Alone` has it: batches differ mostly by how far they close their gap, so a sample spreads over that.
    What is made again at a tighter tolerance is left out. Raises as `jobs.job_of`.
    """
    few, share = thinned(study)
    # What one job has learnt on the way, compiled code apart, the other has not.
    order, laws = ScanInput(few, motions), len(study.grid.contact_models)
    first, job = job_of(order), job_of(order)
    everywhere = np.repeat(closed[..., None, :], laws, axis=-2)
    kinds = np.broadcast_to(np.arange(laws)[:, None], everywhere.shape)
    kind = np.where(everywhere > 0.0, kinds, laws).reshape(-1)
    random = np.random.default_rng(SEED)
    for batch in np.unique(kinds.reshape(-1), return_index=True)[1]:
        first.solve(_one(batch), never)  # compiles, or fetches from the cache
    found = []
    for each in range(laws + 1):
        batches = np.flatnonzero(kind == each)
        if batches.size:
            ordered = batches[np.argsort(everywhere.reshape(-1)[batches], kind="stable")]
            cost = seconds_per_batch(job, ordered[_spread(batches.size, random.random())], SECONDS / (laws + 1))
            found.append(cost._replace(mean=cost.mean / share, deviation=cost.deviation / share))
    return found


def thinned(study: Study) -> tuple[Study, float]:
    """The study with `FEW` yield forces at most, from all over its own, and which share of them these are.

    A batch of thousands of yield forces takes minutes, and what it costs is told by some of them.
    """
    forces = study.grid.yield_forces
    if len(forces) <= FEW:
        return study, 1.0
    return replace(study, grid=study.grid._replace(yield_forces=_evenly(forces, FEW))), FEW / len(forces)


def few_batches(study: Study, records: int) -> tuple[Study, float]:
    """The study with `MOST_BATCHES` batches at most, of gaps and amplitudes from all over its own, and their share.

    What a plan learns of batches that touch and of their cost it learns from these, whatever the grid.
    """
    grid, polarities = study.grid, len(study.records.polarities)
    rest = records * polarities * len(grid.contact_models)
    if rest * len(grid.gaps) * len(grid.pgas) <= MOST_BATCHES:
        return study, 1.0
    room = max(1, MOST_BATCHES // rest)
    gaps = _evenly(grid.gaps, max(1, room // min(len(grid.pgas), FEW)))
    pgas = _evenly(grid.pgas, max(1, room // len(gaps)))
    share = len(gaps) * len(pgas) / (len(grid.gaps) * len(grid.pgas))
    return replace(study, grid=grid._replace(gaps=gaps, pgas=pgas)), share


def _evenly(values: tuple[Any, ...], most: int) -> tuple[Any, ...]:
    """``most`` of these values at most, the first and the last among them."""
    if len(values) <= most:
        return values
    places = np.linspace(0, len(values) - 1, most).round().astype(int)
    return tuple(values[place] for place in places)


def seconds_per_batch(job: Job, batches: NDArray[np.int64], seconds: float) -> Cost:
    """What these batches take: as many of them as ``seconds`` allow, in the order given, are solved on this thread."""
    taken: list[float] = []
    for batch in batches:
        if (len(taken) >= LEAST and sum(taken) >= seconds) or sum(taken) >= LONGEST:
            break
        _respond(job, batch)
        start = thread_time()
        job.solve(_one(batch), never)
        taken.append(thread_time() - start)
    return Cost(
        len(batches), len(taken), float(np.mean(taken)), float(np.std(taken, ddof=1)) if len(taken) > 1 else 0.0
    )


def _respond(job: Any, batch: np.int64) -> None:
    """Solve the motion without contact, which a scan does once for all batches of a motion."""
    motion = tuple(int(place) for place in np.unravel_index(batch, job.shape[:-1])[:3])
    (job.driven if job.study.is_row else job.free)(motion)


def _one(batch: np.int64) -> range:
    return range(int(batch), int(batch) + 1)


def _spread(count: int, offset: float) -> NDArray[np.int64]:
    """The places 0 … ``count`` − 1 in an order of which any beginning lies evenly over all of them."""
    return np.argsort(np.argsort((offset + GOLDEN * np.arange(count)) % 1.0))
