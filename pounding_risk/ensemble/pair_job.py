"""A pair's study as work: compiled sweeps over the gaps and yield forces of one law under one motion."""

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
    AtLeastOne,
    changes,
    check_variables,
    drawn,
    made_again,
    not_made_again,
)
from pounding_risk.models.effects.contact import wave_of
from pounding_risk.motions.motion import driven
from pounding_risk.results.layout import Slab, Template, bytes_per_case, slabs
from pounding_risk.results.pair_labels import OUTCOME, amplitudes, pair_skeleton, pair_values, pair_variables
from pounding_risk.results.tolerance_check import tighter
from pounding_risk.scene.scene import Study
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.api import free_response, oscillators, vibration_maps
from pounding_risk.solver.pair.flight import SIGNALS, Free
from pounding_risk.solver.pair.grid import SIMULATED, sweep
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW
from pounding_risk.solver.pair.stages import make_desk

AT_ONCE = 8  # batches in one call: what Ctrl-C waits for
KEPT = 128  # responses without contact, some hundred kB each
RAW, HOW = "raw", "simulated"


class PairJob:
    """The grid of two buildings that meet mass to mass; see `jobs.Job`. Raises as `scene_laws.law_of`."""

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
        self._free: Shared[Free] = Shared(KEPT)

    def free(self, motion: tuple[int, ...]) -> Free:
        """The response without contact to a motion of the grid: record, polarity, amplitude."""
        record, polarity, amplitude = motion

        def respond() -> Free:
            study = self.study
            found = driven(
                self.scan_input.motions[record], study.records.polarities[polarity], study.grid.pgas[amplitude]
            )
            return free_response(self.pair, found.acceleration, found.dt, wave_of(study.effects))

        return self._free.of(motion, respond)

    @cached_property
    def prepared(self) -> str:
        """Of the pair, its laws, and the maps over a step of each record."""
        steps = sorted({motion.dt for motion in self.scan_input.motions})
        maps = [vibration_maps(self.pair, step) for step in steps]
        return blake2b(repr((self.pair, self.laws, maps)).encode(), digest_size=16).hexdigest()

    def law_at(self, batch: int) -> int:
        """The contact model's place in the grid."""
        return batch // self.gaps.size % len(self.laws)

    def solve(self, batches: range, stop: Callable[[], bool] = never) -> Chunk | None:
        """Raw columns of every case, how it was answered, and what a second run of some of them told."""
        raw = np.zeros((len(batches), self.width, COLUMNS))
        how = np.zeros((len(batches), self.width), dtype=np.int8)
        for slab in slabs(batches, self.shape, AT_ONCE):
            if stop():
                return None
            out = raw[slab.batches], how[slab.batches]
            self._sweep(slab, slice(None), (self.study.rtol, self.scan_input.screening), out)
        part: Chunk = {RAW: raw, HOW: how}
        if self.scan_input.check_fraction > 0.0:
            places = drawn(batches, made(raw, how), self.scan_input.check_fraction)
            found = self._checked(batches, raw, places, stop)
            if found is None:
                return None
            part |= found
        return part

    def _sweep(
        self,
        slab: Slab,
        strengths: slice,
        how_exact: tuple[float, bool],
        out: tuple[NDArray[np.float64], NDArray[np.int8]],
    ) -> None:
        """Fill ``out`` (raw columns, how each case was answered); ``how_exact`` = (rtol, screening)."""
        rtol, screening = how_exact
        grid = (self.gaps[slab.gaps], self.yield_forces[strengths], self.study.restitution)
        law, desk = lowered(self.laws[slab.law]), make_desk(rtol)
        sweep(self.pair, self.free(slab.motion), law, grid, rtol, screening, desk, *out)

    def _checked(
        self, batches: range, raw: NDArray[np.float64], places: NDArray[np.bool_], stop: Callable[[], bool]
    ) -> Chunk | None:
        """The runs at ``places`` (batches, yield forces) made again, at the tighter tolerance and without screening."""
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
        found = changes(raw[places], second, self.yield_forces[at[:, 1]])
        return made_again(places, found, self.study.rtol)

    def check_one(self, batch: int, place: int) -> Chunk:
        """The variables of `recheck.check_variables` for a batch, one of whose runs is made again."""
        batches = range(batch, batch + 1)
        part = self.solve(batches)
        places = np.arange(self.width)[None, :] == place
        found = None if part is None else self._checked(batches, part[RAW], places, never)
        assert found is not None, "nothing stops it"
        return found

    @cached_property
    def template(self) -> Template:
        """The dataset but for its cases."""
        variables = pair_variables()
        if self.scan_input.check_fraction > 0.0:
            variables |= check_variables(self.study.rtol)
        skeleton = pair_skeleton(self.study, self.scan_input.motions, self._alone(), self.laws)
        return Template(skeleton, variables, self.shape)

    def _alone(self) -> NDArray[np.float64]:
        """Raw columns of the responses without contact; extremes are those of the continuous motion."""
        alone = np.zeros((*self.motions_shape, COLUMNS))
        for motion in np.ndindex(self.motions_shape):
            free = self.free(motion)
            alone[motion][HIGH : HIGH + SIGNALS] = np.maximum(free.high.max(axis=0), 0.0)
            alone[motion][LOW : LOW + SIGNALS] = np.minimum(free.low.min(axis=0), 0.0)
        return alone

    def writer(self) -> PairWriter:
        """From raw columns to outputs."""
        return PairWriter(self)


def chunk_bytes(study: Study) -> int:
    """Of a case of a part: raw columns, how it was answered, and what a second run told."""
    return 8 * COLUMNS + bytes_per_case({HOW: OUTCOME[HOW], **check_variables(study.rtol)}, {})


class PairWriter:
    """Outputs from raw columns; see `jobs.DatasetWriter`."""

    def __init__(self, job: PairJob):
        self._job = job
        self._pgas = amplitudes(job.study, job.scan_input.motions).reshape(-1)
        self._watch = AtLeastOne()

    def values(self, batches: range, part: Chunk) -> Chunk:
        """Every case variable of these batches."""
        job, raw = self._job, part[RAW]
        a_motion = job.batches // self._pgas.size
        found = pair_values(job.study, raw, self._pgas[np.arange(batches.start, batches.stop) // a_motion])
        found[HOW] = part[HOW]
        if job.scan_input.check_fraction > 0.0:
            found |= {name: part[name] for name in check_variables(job.study.rtol)}
            self._watch.see(batches, made(raw, part[HOW]), part["sensitive"])
        return found

    def finish(self) -> Finish:
        """One run is made again where none was drawn."""
        missing = self._watch.missing
        return Finish({}) if missing is None else Finish({}, ((missing[0], self._job.check_one(*missing)),))


def made(raw: NDArray[np.float64], how: NDArray[np.int8]) -> NDArray[np.bool_]:
    """The cases that had a run of their own, and a complete one."""
    return (how == SIMULATED) & (raw[..., STATUS] == COMPLETE)
