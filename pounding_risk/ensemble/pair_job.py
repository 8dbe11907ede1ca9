"""The job of a pair: compiled grids of gaps and yield forces, one contact model and one motion at a time."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cached_property
from hashlib import blake2b
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.grid_job import FREE_RESPONSES, HOW, Array, GridJob, Place, Sizes
from pounding_risk.ensemble.job import Finish, ScanInput
from pounding_risk.ensemble.laws import laws_of
from pounding_risk.ensemble.tolerance_check import SENSITIVE, AtLeastOne, changes, check_variables
from pounding_risk.motions.motion import Motion
from pounding_risk.results.labels import OUTCOME, kept_as
from pounding_risk.results.layout import Slab, bytes_per_case
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.api import free_response, initial_state, oscillators, vibration_maps, workspace_for
from pounding_risk.solver.pair.flight import SIGNALS, Free
from pounding_risk.solver.pair.grid import SIMULATED, solve_grid
from pounding_risk.solver.pair.outputs import BUILDING, COLUMNS, HIGH, LOW, RUN, building_outputs, run_outputs

RAW = "raw"
# Cases of one contact law times samples of a record: with so many, some two minutes of work, a kernel that holds the
# law's own code repays its compiling. It is a tenth faster than the one that calls laws by address.
WORTH_A_KERNEL = 3e9
OF_BUILDINGS: dict[str, Any] = {
    name: SimpleNamespace(unit=unit, words=words) for name, (unit, words, _) in BUILDING.items()
}


def respond_alone(study: Scene, motion: Motion) -> Free:
    """The response of a pair to a motion without contact."""
    pair, initial = oscillators(*study.pair), initial_state(*study.pair)
    return free_response(pair, motion.acceleration, motion.dt, study.supports, initial, motion.own_grounds)


class PairJob(GridJob):
    """The grid of two single masses that meet mass to mass. Raises as `laws.law_of`."""

    solver = "pair"
    has_storeys = False
    at_once = 8

    def __init__(self, scan_input: ScanInput):
        study = scan_input.study
        self.pair, self.laws = oscillators(*study.pair), laws_of(study)
        self.initial = initial_state(*study.pair)
        self.gaps, self.yield_forces = np.array(study.grid.gaps), np.array(study.grid.yield_forces)
        places = self.gaps[:, None], self.yield_forces[:, None]  # of one interface, of one contact point
        super().__init__(scan_input, tuple((law,) for law in self.laws), places)
        self.own_kernels = self.worth_kernels(1)
        self.caches = {"free": Shared(FREE_RESPONSES)}

    def worth_kernels(self, scenes: int) -> bool:
        motions = self.scan_input.motions
        samples = sum(motion.acceleration.size for motion in motions) / max(len(motions), 1)
        return scenes * self.batches * self.width / len(self.laws) * samples >= WORTH_A_KERNEL

    @classmethod
    def alone_key(cls, study: Scene) -> Hashable:
        # Without contact the masses play no part.
        vibrations = tuple(item._replace(mass=0.0, inverse_mass=0.0) for item in oscillators(*study.pair))
        return vibrations, initial_state(*study.pair), study.supports

    @classmethod
    def outputs(cls, study: Scene) -> dict[str, Any]:
        return RUN | OF_BUILDINGS

    @classmethod
    def free_outputs(cls, study: Scene) -> dict[str, Any]:
        return OF_BUILDINGS | {"peak_closing": RUN["peak_closing"]}

    @classmethod
    def sizes(cls, study: Scene) -> Sizes:
        raw = 8 * COLUMNS + bytes_per_case({HOW: OUTCOME[HOW], **check_variables(study.rtol)}, {})
        return cls.sizes_along(study, {"building": 2, "interface": 1}, raw)

    @classmethod
    def closing(cls, study: Scene) -> Callable[[Motion], tuple[Array, Free]]:
        gaps = np.array(study.grid.gaps)

        def respond(motion: Motion) -> tuple[Array, Free]:
            free = respond_alone(study, motion)
            return free.high[:, 0].max() - gaps, free

        return respond

    def free(self, motion: Place) -> Free:
        def respond() -> Free:
            free = respond_alone(self.study, self.ground(motion))
            self.peaks[self.free_key, motion] = free.high.max(axis=0), free.low.min(axis=0)
            return free

        return self.caches["free"].of((self.free_key, motion), respond)

    @cached_property
    def prepared(self) -> str:
        """Digest of the pair, its laws, and the maps over a step of each record."""
        steps = sorted({motion.dt for motion in self.scan_input.motions})
        maps = [vibration_maps(self.pair, step) for step in steps]
        return blake2b(repr((self.pair, self.initial, self.laws, maps)).encode(), digest_size=16).hexdigest()

    def solved(self, batches: range, stop: Callable[[], bool]) -> tuple[Chunk, NDArray[np.bool_]] | None:
        """Raw columns of every case, and whether it was simulated."""
        raw = np.zeros((len(batches), self.width, COLUMNS))
        simulated = np.zeros((len(batches), self.width), dtype=np.int8)
        for slab in self.slabs(batches):
            if stop():
                return None
            out = raw[slab.batches], simulated[slab.batches]
            self._sweep(slab, slice(None), (self.study.rtol, self.scan_input.screening), out)
        return {RAW: raw, HOW: simulated}, made(raw, simulated)

    def _sweep(
        self, slab: Slab, strengths: slice, accuracy: tuple[float, bool], out: tuple[Array, NDArray[np.int8]]
    ) -> None:
        """Fill ``out`` (raw columns, whether each case was simulated); ``how_exact`` = (rtol, screening)."""
        rtol, screening = accuracy
        grid = (self.gaps[slab.gaps], self.yield_forces[strengths], self.study.restitution)
        law, free = self.laws[slab.law], self.free(slab.motion)
        solve_grid(self.pair, free, law, grid, rtol, screening, workspace_for(free, rtol), *out, self.own_kernels)

    def repeated(self, slab: Slab, strength: int, rtol: float) -> Array:
        raw = np.zeros((1, 1, COLUMNS))
        self._sweep(slab, slice(strength, strength + 1), (rtol, False), (raw, np.zeros((1, 1), dtype=np.int8)))
        return raw[0, 0]

    def moves(self, chunk: Chunk, places: NDArray[np.bool_], repeated_runs: list[Array]) -> dict[str, Array]:
        return changes(chunk[RAW][places], np.array(repeated_runs), self.yield_forces[np.argwhere(places)[:, 1]])

    def free_values(self) -> dict[str, Array]:
        """From raw columns; the extremes are those of the continuous motion."""
        raw = np.zeros((*self.motions_shape, COLUMNS))
        for motion in np.ndindex(self.motions_shape):
            if (self.free_key, motion) not in self.peaks:
                self.free(motion)
            high, low = self.peaks[self.free_key, motion]
            raw[motion][HIGH : HIGH + SIGNALS] = np.maximum(high, 0.0)
            raw[motion][LOW : LOW + SIGNALS] = np.minimum(low, 0.0)
        return building_outputs(raw, self.study.pair, self.peaks_under()) | {"peak_closing": raw[..., HIGH, None]}

    def writer(self) -> PairWriter:
        return PairWriter(self)


class PairWriter:
    """Computes outputs from raw columns; see `job.DatasetWriter`."""

    def __init__(self, job: PairJob):
        self._job = job
        self._pgas = job.peaks_under().reshape(-1, 2)
        self._check = AtLeastOne()

    def values(self, batches: range, chunk: Chunk) -> Chunk:
        job, raw = self._job, chunk[RAW]
        pgas = self._pgas[np.arange(batches.start, batches.stop) // (job.batches // len(self._pgas))]
        variables = {
            name: values.astype(kept_as(RUN[name].whole), copy=False)[..., None]  # of the one interface
            for name, values in run_outputs(raw, job.yield_forces).items()
        }
        variables |= building_outputs(raw, job.study.pair, pgas[:, None, :])
        variables |= {"status": raw[..., STATUS].astype(np.int8), HOW: chunk[HOW]}
        if job.check_names:
            variables |= {name: chunk[name] for name in job.check_names}
            self._check.see(batches, made(raw, chunk[HOW]), chunk[SENSITIVE])
        return variables

    def finish(self) -> Finish:
        return Finish({}, self._check.patches(self._job))


def made(raw: Array, simulated: NDArray[np.int8]) -> NDArray[np.bool_]:
    """The cases that were simulated, and whose run is complete."""
    return (simulated == SIMULATED) & (raw[..., STATUS] == COMPLETE)
