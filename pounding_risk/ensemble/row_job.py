"""The job of a row: every case is solved in its parts, and no part of one motion and contact model twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import RAGGED, Chunk
from pounding_risk.ensemble.grid_job import HOW, Array, GridJob, Place, Sizes, peaks_under
from pounding_risk.ensemble.job import Finish, ScanInput
from pounding_risk.ensemble.limits import response_bytes
from pounding_risk.ensemble.row_grid import model_of, row_grid, without_jumps
from pounding_risk.ensemble.tolerance_check import SENSITIVE, AtLeastOne, differences, not_recomputed
from pounding_risk.models.effects import acts_on_law
from pounding_risk.motions.motion import Motion
from pounding_risk.results.attributes import as_text
from pounding_risk.results.labels import WITH_BUMPERS, kept_as
from pounding_risk.results.layout import Slab
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COLLAPSED, COMPLETE, STATUS_SENTENCES
from pounding_risk.solver.pair.grid import KNOWN, SIMULATED
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import outputs as row_outputs
from pounding_risk.solver.row.api import HIGHEST, FreeResponse, RowRun
from pounding_risk.solver.row.cases import Answered, Cases, Driven
from pounding_risk.solver.row.model import RowModel

MOTIONS = 128  # of which the peaks without contact are kept
CASES = 16  # motions under a contact model that are kept, with the runs that their cases share
SOLVED = 1e-9  # m, of a gap that counts as closed: its case is solved
CLOSINGS = ("contact_point_peak_closing", "peak_closing")  # in the order of `closing`
# How the parts of a case were answered: a key of each run, zero beyond the last, and whether the run was known before.
KEYS, ANSWERS = f"keys{RAGGED}", f"answers{RAGGED}"
OWN, FROM_LARGER = 1, 2
STATUS = "status"


RESPONSE_BYTES = 256e6  # of the states without contact that are kept, where more than `LEAST_RESPONSES` motions fit
LEAST_RESPONSES = 4


def responses_held(size: float) -> int:
    """For how many motions the states without contact are kept, at so many bytes each."""
    return int(min(max(RESPONSE_BYTES / size, LEAST_RESPONSES), MOTIONS))


def grid_gaps(study: Scene, model: RowModel) -> Array:
    """The gap at each contact point of a row, by gap of the grid [m]."""
    return model.gaps(np.array([study.interface_gaps(gap) for gap in study.grid.gaps]))


def respond_alone(model: RowModel, motion: Motion) -> tuple[FreeResponse, NDArray[Any]]:
    """The response of a row to a motion without contact, and the ground under its buildings."""
    ground = model.under(motion.drive, motion.own_grounds)
    return rows.free_response(model.row(motion.dt, model.has_many(motion.own_grounds)), ground), ground


class RowJob(GridJob):
    """The grid of a row. Raises as `row_grid.row_grid`."""

    solver = "row"
    has_storeys = True

    def __init__(self, scan_input: ScanInput):
        self.grid = row_grid(scan_input.study)
        firsts = self.grid.model.bounds[:-1]  # contact points of the interfaces
        laws = tuple(tuple(mechanics.laws[first] for first in firsts) for mechanics in self.grid.mechanics)
        super().__init__(scan_input, laws, (self.grid.gaps, self.grid.yield_forces[:, self.grid.frame.contacts]))
        longest = max(scan_input.motions, key=lambda motion: motion.acceleration.size)
        responses = responses_held(response_bytes(self.study, longest))
        self.caches = {"driven": Shared(MOTIONS), "responses": Shared(responses), "cases": Shared(CASES)}

    @classmethod
    def unsolved(cls, study: Scene, law_name: str) -> str:
        return without_jumps(study, law_name)

    @classmethod
    def alone_key(cls, study: Scene) -> Hashable:
        # As text, in which an unknown level is equal to another; it has every digit.
        effects = [effect for effect in study.effects if not acts_on_law(effect.name)]
        return repr((study.buildings, effects, study.points, study.links))

    @classmethod
    def outputs(cls, study: Scene) -> dict[str, row_outputs.Variable]:
        variables = row_outputs.variables(row_outputs.frame_of(model_of(study)))
        if study.bumpers:
            for name in CLOSINGS:
                variables[name] = variables[name]._replace(words=variables[name].words + WITH_BUMPERS)
        return variables

    @classmethod
    def free_outputs(cls, study: Scene) -> dict[str, row_outputs.Variable]:
        variables = cls.outputs(study)
        closings = {name: variables[name] for name in CLOSINGS}
        return row_outputs.moving_variables(row_outputs.frame_of(model_of(study))) | closings

    @classmethod
    def endings(cls, study: Scene) -> dict[int, str]:
        return STATUS_SENTENCES if row_outputs.frame_of(model_of(study)).has_laws else super().endings(study)

    @classmethod
    def sizes(cls, study: Scene) -> Sizes:
        return cls.sizes_along(study, row_outputs.frame_of(model_of(study)).sizes)

    @classmethod
    def closing(cls, study: Scene) -> Callable[[Motion], tuple[Array, Any]]:
        model = model_of(study)
        gaps = grid_gaps(study, model)

        def respond(motion: Motion) -> tuple[Array, Any]:
            response, ground = respond_alone(model, motion)
            free = response.run
            # A response that fails is the result of its cases.
            closed = (free.points[:, HIGHEST] - gaps).max(axis=1) if free.status == COMPLETE else np.zeros(len(gaps))
            if model.is_always_solved or free.status == COLLAPSED:  # a neighbour may prevent the collapse
                closed = np.maximum(closed, SOLVED)
            return closed, (response, ground)

        return respond

    @classmethod
    def held_bytes(cls, motions: int, size: int) -> int:
        return min(motions, responses_held(max(size, 1))) * size

    def free(self, motion: Place) -> Driven:
        """A motion of the grid and the row's response to it without contact."""

        def respond() -> Driven:
            ground = self.ground(motion)
            acceleration = self.grid.model.under(ground.drive, ground.own_grounds)
            return Driven(acceleration, ground.dt, peaks_under(self.study, ground), self._response(motion).run)

        return self.caches["driven"].of((self.free_key, motion), respond)

    def _response(self, motion: Place) -> FreeResponse:
        """The row's response to a motion of the grid without contact, with its states at all nodes."""

        def respond() -> FreeResponse:
            return respond_alone(self.grid.model, self.ground(motion))[0]

        return self.caches["responses"].of((self.free_key, motion), respond)

    def cases(self, motion: Place, law: int, rtol: float) -> Cases:
        """The cases of one motion under one contact model."""
        driven = self.free(motion)
        return Cases(self.grid.model, self.grid.mechanics[law], driven, rtol, lambda: self._response(motion).motion)

    @cached_property
    def prepared(self) -> str:
        """Digest of the laws, and of every matrix of the row over a step of each record."""
        digest = blake2b(repr([mechanics.laws for mechanics in self.grid.mechanics]).encode(), digest_size=16)
        model, motions = self.grid.model, self.scan_input.motions
        for step, has_many in sorted({(motion.dt, model.has_many(motion.own_grounds)) for motion in motions}):
            for array in model.row(step, has_many).row:
                digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def solved(self, batches: range, stop: Callable[[], bool]) -> tuple[Chunk, NDArray[np.bool_]] | None:
        """Outputs of every case, and how its parts were answered."""
        chunk = self._empty(len(batches))
        answers: list[list[list[Answered]]] = []
        for slab in self.slabs(batches):
            answered = self._solved(slab, chunk, stop)
            if answered is None:
                return None
            answers.append(answered)
        is_own = np.ones((len(batches), self.width), dtype=bool)
        if self.scan_input.screening:
            is_own = np.array([_own_cases(answered) for answered in answers]).reshape(is_own.shape)
            chunk |= _answer_arrays(answers, self.width)
        return chunk, is_own & (chunk[STATUS] == COMPLETE)

    def _empty(self, count: int) -> Chunk:
        """Arrays of zeros for so many batches."""
        sizes = self.grid.frame.sizes
        chunk: Chunk = {
            name: np.zeros((count, self.width, *(sizes[dim] for dim in variable.dims)), kept_as(variable.whole))
            for name, variable in row_outputs.variables(self.grid.frame).items()
        }
        return chunk | {STATUS: np.zeros((count, self.width), np.int8)}

    def _solved(self, slab: Slab, chunk: Chunk, stop: Callable[[], bool]) -> list[list[Answered]] | None:
        """Solve one batch into its place in ``chunk``; returns how the parts of its cases were answered."""
        gap, key = slab.gaps.start, (slab.motion, slab.law)
        cases = self.caches["cases"].of((self.number, key), lambda: self.cases(*key, self.grid.rtol))
        runs, answers = [], []
        for level in range(self.width):
            if stop():
                return None
            limits = self.grid.limits(gap, level)
            run, answered = cases.in_parts(limits) if self.scan_input.screening else (cases.whole(limits), [])
            runs.append(run)
            answers.append(answered)
        run = stacked(runs)
        chunk[STATUS][slab.batches] = run.status
        outputs = row_outputs.outputs(run, self.grid.yield_forces, self.free(slab.motion).pga, self.grid.frame)
        for name, array in row_outputs.with_bumpers(outputs, self.grid.frame).items():
            chunk[name][slab.batches] = array
        return answers

    def repeated(self, slab: Slab, strength: int, rtol: float) -> tuple[int, row_outputs.Outputs]:
        """The whole row at once."""
        run = self.cases(slab.motion, slab.law, rtol).whole(self.grid.limits(slab.gaps.start, strength))
        outputs = row_outputs.outputs(run, self.grid.yield_forces[strength], 0.0, self.grid.frame)
        return run.status, row_outputs.with_bumpers(outputs, self.grid.frame)

    def moves(
        self, chunk: Chunk, places: NDArray[np.bool_], repeated_runs: list[tuple[int, row_outputs.Outputs]]
    ) -> dict[str, Array]:
        """The change of a run is the largest over its interfaces."""
        failed = np.array([status != COMPLETE for status, _ in repeated_runs], dtype=bool)
        names = (*RELATIVE, *COUNTED)
        after = {name: np.array([repeated[name] for _, repeated in repeated_runs]) for name in names}
        before = {name: chunk[name][places] for name in names}
        return {name: change.max(axis=1) for name, change in differences(before, after, failed[:, None]).items()}

    def free_values(self) -> dict[str, Array]:
        peaks = [self._peaks(motion) for motion in np.ndindex(self.motions_shape)]
        stacks = {name: np.array([outputs[name] for outputs in peaks]) for name in peaks[0]}
        stacks = row_outputs.with_bumpers(stacks, self.grid.frame)
        return {name: stack.reshape(*self.motions_shape, *stack.shape[1:]) for name, stack in stacks.items()}

    def _peaks(self, motion: Place) -> dict[str, Array]:
        """Outputs of a motion without contact."""
        if (self.free_key, motion) not in self.peaks:
            driven, frame = self.free(motion), self.grid.frame
            closings = dict(zip(CLOSINGS, row_outputs.closing(driven.free, frame), strict=True))
            self.peaks[self.free_key, motion] = row_outputs.moving_outputs(driven.free, driven.pga, frame) | closings
        return self.peaks[self.free_key, motion]

    def writer(self) -> RowWriter:
        return RowWriter(self)


class RowWriter:
    """Finds which cases of a row were simulated, and counts their parts; see `job.DatasetWriter`.

    A run counts for the first case that needs it, in the order of the grid, largest yield force first, among the cases
    of one motion and contact model. So the count does not depend on the chunks.
    """

    def __init__(self, job: RowJob):
        self._job = job
        self._seen: set[int] = set()
        self._parts: Counter[str] = Counter()
        self._check = AtLeastOne()

    def values(self, batches: range, chunk: Chunk) -> Chunk:
        job = self._job
        simulated = np.full((len(batches), job.width), SIMULATED, dtype=np.int8)
        if job.scan_input.screening:
            simulated[:] = 0
            for place, batch in enumerate(batches):
                if batch % job.shape[-2] == 0:  # the first gap of another motion or contact model
                    self._seen.clear()
                self._count_parts(chunk[KEYS][place], chunk[ANSWERS][place], simulated[place])
        answers = {name: chunk[name] for name in (*row_outputs.variables(job.grid.frame), STATUS)} | {HOW: simulated}
        if job.check_names:
            is_own = simulated == SIMULATED
            for name, missing in not_recomputed(simulated.shape).items():
                # A run that an earlier batch has made may have been repeated here as well: it counts there.
                answers[name] = np.where(is_own, chunk[name], missing)
            self._check.see(batches, is_own & (chunk[STATUS] == COMPLETE), answers[SENSITIVE])
        return answers

    def _count_parts(self, keys: NDArray[np.uint64], answers: NDArray[np.int8], simulated: NDArray[np.int8]) -> None:
        """Set in ``how`` which cases of a batch were simulated, and count their parts."""
        for level in reversed(range(len(simulated))):
            for key, answer in zip(keys[level].tolist(), answers[level].tolist(), strict=True):
                if not answer:
                    break
                is_new = key not in self._seen
                self._seen.add(key)
                known_label = "known from a larger yield force" if answer == FROM_LARGER else "equal"
                self._parts["solved" if is_new else known_label] += 1
                simulated[level] |= SIMULATED if is_new else KNOWN

    def finish(self) -> Finish:
        counts = dict(self._parts)
        return Finish({"parts": as_text(counts)} if counts else {}, self._check.patches(self._job), counts)


def _own_cases(answered: list[list[Answered]]) -> list[bool]:
    """Which cases of a batch have a run that no larger yield force of the batch has."""
    seen: set[tuple[bytes, ...]] = set()
    is_own = []
    for case_answers in reversed(answered):
        keys = {key for key, _ in case_answers}
        is_own.append(not keys <= seen)
        seen |= keys
    return is_own[::-1]


def _answer_arrays(answers: list[list[list[Answered]]], width: int) -> Chunk:
    """How the parts of each case were answered, as numbers."""
    longest = max((len(case_answers) for batch in answers for case_answers in batch), default=0)
    keys = np.zeros((len(answers), width, longest), dtype=np.uint64)
    codes = np.zeros(keys.shape, dtype=np.int8)
    for batch, cases in enumerate(answers):
        for level, case_answers in enumerate(cases):
            for place, (key, is_known) in enumerate(case_answers):
                keys[batch, level, place] = _number(key)
                codes[batch, level, place] = FROM_LARGER if is_known else OWN
    return {KEYS: keys, ANSWERS: codes}


def _number(key: tuple[bytes, ...]) -> int:
    """A number for the key of a run, equal in every process; of a million keys two are equal in one of 4e7 scans."""
    digest = blake2b(digest_size=8)
    for piece in key:
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return int.from_bytes(digest.digest(), "little")


def stacked(runs: list[RowRun]) -> RowRun:
    """Runs of one row as one, with an axis of runs before the others."""
    fields: list[Any] = [np.stack([np.asarray(output) for output in column]) for column in zip(*runs, strict=True)]
    return RowRun._make(fields)
