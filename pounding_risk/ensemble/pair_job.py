"""The job of a pair: compiled grids of gaps and yield forces, one contact model and one motion at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.job import Finish, ScanInput, never
from pounding_risk.ensemble.laws import laws_of
from pounding_risk.ensemble.tolerance_check import (
    SENSITIVE,
    AtLeastOne,
    changes,
    check_variables,
    drawn,
    made_again,
    not_made_again,
)
from pounding_risk.models.effects import wave_of
from pounding_risk.motions.motion import driven
from pounding_risk.results.layout import Slab, Template, bytes_per_case, slabs
from pounding_risk.results.pair_labels import OUTCOME, amplitudes, pair_skeleton, pair_values, pair_variables
from pounding_risk.results.tolerance_check import tighter
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.api import free_response, oscillators, vibration_maps
from pounding_risk.solver.pair.flight import SIGNALS, Free
from pounding_risk.solver.pair.grid import SIMULATED, solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW
from pounding_risk.solver.workspace import make_workspace

AT_ONCE = 8  # batches in one call of the kernel
FREE_RESPONSES = 128  # without contact that are kept, some hundred kB each
RAW, HOW = "raw", "simulated"


class PairJob:
    """The grid of two buildings with one contact point; see `job.Job`. Raises as `laws.law_of`."""

    def __init__(self, scan_input: ScanInput):
        self.scan_input, self.study = scan_input, scan_input.study
        study = self.study
        self.pair = oscillators(*study.pair)
        self.laws = laws_of(study)
        self.gaps, self.yield_forces = np.array(study.grid.gaps), np.array(study.grid.yield_forces)
        self.motions_shape = (len(scan_input.motions), len(study.records.polarities), len(study.grid.pgas))
        self.shape = (*self.motions_shape, len(self.laws), self.gaps.size, self.yield_forces.size)
        self.batches, self.width = int(np.prod(self.shape[:-1])), self.yield_forces.size
        self.bytes_per_batch = self.width * chunk_bytes(study)
        self._free: Shared[Free] = Shared(FREE_RESPONSES)

    def free(self, motion: tuple[int, ...]) -> Free:
        """The response without contact to a motion of the grid (record, polarity, amplitude)."""
        record, polarity, amplitude = motion

        def respond() -> Free:
            study = self.study
            ground = driven(
                self.scan_input.motions[record], study.records.polarities[polarity], study.grid.pgas[amplitude]
            )
            return free_response(self.pair, ground.acceleration, ground.dt, wave_of(study.effects))

        return self._free.of(motion, respond)

    @cached_property
    def prepared(self) -> str:
        """Digest of the pair, its laws, and the maps over a step of each record."""
        steps = sorted({motion.dt for motion in self.scan_input.motions})
        maps = [vibration_maps(self.pair, step) for step in steps]
        return blake2b(repr((self.pair, self.laws, maps)).encode(), digest_size=16).hexdigest()

    def law_at(self, batch: int) -> int:
        """Index of the contact model that a batch needs."""
        return batch // self.gaps.size % len(self.laws)

    def solve(self, batches: range, stop: Callable[[], bool] = never) -> Chunk | None:
        """Raw columns of every case, whether it was simulated, and how far runs that are repeated move."""
        raw = np.zeros((len(batches), self.width, COLUMNS))
        how = np.zeros((len(batches), self.width), dtype=np.int8)
        for slab in slabs(batches, self.shape, AT_ONCE):
            if stop():
                return None
            out = raw[slab.batches], how[slab.batches]
            self._sweep(slab, slice(None), (self.study.rtol, self.scan_input.screening), out)
        chunk: Chunk = {RAW: raw, HOW: how}
        if self.scan_input.check_fraction > 0.0:
            places = drawn(batches, made(raw, how), self.scan_input.check_fraction)
            checked = self.checked(batches, chunk, places, stop)
            return None if checked is None else chunk | checked
        return chunk

    def _sweep(
        self,
        slab: Slab,
        strengths: slice,
        how_exact: tuple[float, bool],
        out: tuple[NDArray[np.float64], NDArray[np.int8]],
    ) -> None:
        """Fill ``out`` (raw columns, whether each case was simulated); ``how_exact`` = (rtol, screening)."""
        rtol, screening = how_exact
        grid = (self.gaps[slab.gaps], self.yield_forces[strengths], self.study.restitution)
        law, workspace = lowered(self.laws[slab.law]), make_workspace(rtol)
        solve_grid(self.pair, self.free(slab.motion), law, grid, rtol, screening, workspace, *out)

    def checked(
        self, batches: range, chunk: Chunk, places: NDArray[np.bool_], stop: Callable[[], bool]
    ) -> Chunk | None:
        """Repeat the runs at ``places`` (batches, yield forces) at the tighter tolerance, without screening."""
        if not places.any():
            return not_made_again((len(batches), self.width))
        rtol, at = tighter(self.study.rtol), np.argwhere(places)
        second = np.zeros((len(at), COLUMNS))
        for (batch, strength), out in zip(at, second, strict=True):
            if stop():
                return None
            (slab,) = slabs(range(batches.start + batch, batches.start + batch + 1), self.shape, 1)
            case = slice(strength, strength + 1)
            self._sweep(slab, case, (rtol, False), (out.reshape(1, 1, -1), np.zeros((1, 1), dtype=np.int8)))
        moves = changes(chunk[RAW][places], second, self.yield_forces[at[:, 1]])
        return made_again(places, moves, self.study.rtol)

    @cached_property
    def template(self) -> Template:
        """The dataset without the values of its cases."""
        variables = pair_variables()
        if self.scan_input.check_fraction > 0.0:
            variables |= check_variables(self.study.rtol)
        skeleton = pair_skeleton(self.study, self.scan_input.motions, self._alone(), self.laws)
        return Template(skeleton, variables, self.shape)

    def _alone(self) -> NDArray[np.float64]:
        """Raw columns of the responses without contact; the extremes are those of the continuous motion."""
        alone = np.zeros((*self.motions_shape, COLUMNS))
        for motion in np.ndindex(self.motions_shape):
            free = self.free(motion)
            alone[motion][HIGH : HIGH + SIGNALS] = np.maximum(free.high.max(axis=0), 0.0)
            alone[motion][LOW : LOW + SIGNALS] = np.minimum(free.low.min(axis=0), 0.0)
        return alone

    def writer(self) -> PairWriter:
        """A new writer of this job's dataset, before its first batch."""
        return PairWriter(self)


def chunk_bytes(study: Scene) -> int:
    """Size of a case in a chunk: raw columns, whether it was simulated, and how far a repeated run moves."""
    return 8 * COLUMNS + bytes_per_case({HOW: OUTCOME[HOW], **check_variables(study.rtol)}, {})


class PairWriter:
    """Computes outputs from raw columns; see `job.DatasetWriter`."""

    def __init__(self, job: PairJob):
        self._job = job
        self._pgas = amplitudes(job.study, job.scan_input.motions).reshape(-1)
        self._check = AtLeastOne()

    def values(self, batches: range, chunk: Chunk) -> Chunk:
        """Every case variable of these batches."""
        job, raw = self._job, chunk[RAW]
        per_motion = job.batches // self._pgas.size
        variables = pair_values(job.study, raw, self._pgas[np.arange(batches.start, batches.stop) // per_motion])
        variables[HOW] = chunk[HOW]
        if job.scan_input.check_fraction > 0.0:
            variables |= {name: chunk[name] for name in check_variables(job.study.rtol)}
            self._check.see(batches, made(raw, chunk[HOW]), chunk[SENSITIVE])
        return variables

    def finish(self) -> Finish:
        """The repeated run of one case, where no case was drawn."""
        return Finish({}, self._check.patches(self._job))


def made(raw: NDArray[np.float64], how: NDArray[np.int8]) -> NDArray[np.bool_]:
    """The cases that were simulated, and whose run is complete."""
    return (how == SIMULATED) & (raw[..., STATUS] == COMPLETE)
