"""The work of a scan: which batches of its grid touch, and the time that a sample of them takes.

Where the motion without contact closes no gap, it is the result.
"""

from __future__ import annotations

from math import sqrt
from time import thread_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.order import evenly
from pounding_risk.ensemble.job import ScanInput, never
from pounding_risk.ensemble.job_choice import job_kind, job_of
from pounding_risk.ensemble.plan.size import bytes_of
from pounding_risk.motions.levels import driven
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.scene import Scene

SECONDS = 1.0  # of solving batches to learn what they cost, over all contact models
FEW = 40  # yield forces, at most, of a batch in the sample
LEAST = 4  # batches of a contact model that are solved, unless they take longer than `LONGEST`
LONGEST = 4.0  # s of solving, after which no other batch of a contact model is begun
MOST_BATCHES = 20_000  # that are looked at: of a larger grid some gaps and amplitudes, evenly drawn
SEED = 20110314  # of the sample: a scene always has the same
GOLDEN = 0.5 * (sqrt(5.0) - 1.0)  # its multiples, modulo 1, are evenly distributed however many there are


class Alone(NamedTuple):
    """Responses of a grid without contact."""

    closed: NDArray[np.float64]  # m, (records, polarities, amplitudes, gaps): more than zero where some gap is closed
    size: int  # bytes of the largest response


def alone(study: Scene, motions: tuple[Motion, ...]) -> Alone:
    """How far the motion without contact closes the tightest gap, for each motion and gap; raises as `chain_of`."""
    respond = job_kind(study).closing(study)
    shape = (len(motions), len(study.records.polarities), len(study.grid.amplitudes))
    closed, size = np.zeros((*shape, len(study.grid.gaps))), 0
    for place in np.ndindex(shape):
        motion = driven(motions[place[0]], study.records.polarities[place[1]], study.grid.amplitudes[place[2]])
        closed[place], arrays = respond(motion.reaching(study.lag))
        size = max(size, bytes_of(arrays))
    return Alone(closed, size)


class Cost(NamedTuple):
    """Time of a group of similar batches, from a sample of them."""

    batches: int
    sampled: int
    mean: float  # processor time of a batch [s]
    deviation: float  # standard deviation of it [s]

    @property
    def seconds(self) -> float:
        """Time of all batches on one thread."""
        return self.batches * self.mean

    @property
    def error(self) -> float:
        """Standard error of `seconds`; a sample of one batch of several has an error of its own size."""
        if self.sampled == 1 < self.batches:
            return self.seconds
        unknown = 1.0 - self.sampled / self.batches
        return self.batches * self.deviation * sqrt(unknown / self.sampled)


def costs(study: Scene, motions: tuple[Motion, ...], closed: NDArray[np.float64]) -> list[Cost]:
    """Time of the batches of each contact model that touch, then of all others.

    ``closed`` is that of `Alone`: batches differ mostly in how far they close their gap, so the sample is spread evenly
    over it. Runs of the tolerance check are left out. Raises as `job_choice.job_of`.
    """
    small_study, share = thinned(study)
    # The first compiles; the second is timed, without the results that the first has kept.
    scan_input, laws = ScanInput(small_study, motions), len(study.grid.contact_models)
    compiling_job, job = job_of(scan_input), job_of(scan_input)
    closings = np.repeat(closed[..., None, :], laws, axis=-2)
    laws_of_batches = np.broadcast_to(np.arange(laws)[:, None], closings.shape)
    groups = np.where(closings > 0.0, laws_of_batches, laws).reshape(-1)
    random = np.random.default_rng(SEED)
    for batch in np.unique(laws_of_batches.reshape(-1), return_index=True)[1]:
        compiling_job.solve(_one_batch(batch), never)  # compiles, or fetches from the cache
    costs = []
    for group in range(laws + 1):
        batches = np.flatnonzero(groups == group)
        if batches.size:
            sorted_batches = batches[np.argsort(closings.reshape(-1)[batches], kind="stable")]
            cost = seconds_per_batch(
                job, sorted_batches[_spread_order(batches.size, random.random())], SECONDS / (laws + 1)
            )
            costs.append(cost._replace(mean=cost.mean / share, deviation=cost.deviation / share))
    return costs


def thinned(study: Scene) -> tuple[Scene, float]:
    """The study with `FEW` of its yield forces at most, evenly drawn, and the share of them.

    A batch with thousands of yield forces may take minutes.
    """
    forces = study.grid.yield_forces
    if len(forces) <= FEW:
        return study, 1.0
    kept_forces = tuple(forces[place] for place in evenly(len(forces), FEW))
    return study.updated(grid=study.grid._replace(yield_forces=kept_forces)), FEW / len(forces)


def few_batches(study: Scene, records: int) -> tuple[Scene, float]:
    """The study with `MOST_BATCHES` batches at most, of gaps and amplitudes evenly drawn, and the share of them."""
    grid, polarities = study.grid, len(study.records.polarities)
    runs = records * polarities * len(grid.contact_models)
    if runs * len(grid.gaps) * len(grid.amplitudes) <= MOST_BATCHES:
        return study, 1.0
    room = max(1, MOST_BATCHES // runs)
    gap_places = evenly(len(grid.gaps), max(1, room // min(len(grid.amplitudes), FEW)))
    amplitude_places = evenly(len(grid.amplitudes), max(1, room // len(gap_places)))
    gaps = tuple(grid.gaps[place] for place in gap_places)
    amplitudes = tuple(grid.amplitudes[place] for place in amplitude_places)
    share = len(gaps) * len(amplitudes) / (len(grid.gaps) * len(grid.amplitudes))
    return study.updated(grid=grid._replace(gaps=gaps, amplitudes=amplitudes)), share


def seconds_per_batch(job: Any, batches: NDArray[np.int64], seconds: float) -> Cost:
    """Time of these batches: as many as ``seconds`` allow, in the order given, are solved on this thread."""
    times: list[float] = []
    for batch in batches:
        if (len(times) >= LEAST and sum(times) >= seconds) or sum(times) >= LONGEST:
            break
        motion = np.unravel_index(batch, job.shape[:-1])[:3]
        job.free(tuple(map(int, motion)))  # which a scan computes once for all batches of a motion
        start = thread_time()
        job.solve(_one_batch(batch), never)
        times.append(thread_time() - start)
    deviation = float(np.std(times, ddof=1)) if len(times) > 1 else 0.0
    return Cost(len(batches), len(times), float(np.mean(times)), deviation)


def _one_batch(batch: np.int64) -> range:
    return range(int(batch), int(batch) + 1)


def _spread_order(count: int, offset: float) -> NDArray[np.int64]:
    """The numbers 0 … ``count`` − 1 in an order whose first few, however many, are evenly distributed over them."""
    return np.argsort(np.argsort((offset + GOLDEN * np.arange(count)) % 1.0))
