"""The job of a row: every case is solved in its parts, and no part of one motion and contact model twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import RAGGED, Chunk
from pounding_risk.ensemble.job import Finish, ScanInput, never
from pounding_risk.ensemble.row_grid import row_grid
from pounding_risk.ensemble.tolerance_check import (
    SENSITIVE,
    AtLeastOne,
    check_variables,
    differences,
    drawn,
    made_again,
    not_made_again,
)
from pounding_risk.motions.motion import driven
from pounding_risk.results.files import as_text
from pounding_risk.results.layout import Slab, Template, bytes_per_case, slabs
from pounding_risk.results.pair_labels import kept_as
from pounding_risk.results.row_labels import row_skeleton, row_variables
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE, tighter
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.grid import KNOWN, SIMULATED
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import RowRun
from pounding_risk.solver.row.cases import Answered, Cases, Driven
from pounding_risk.solver.row.outputs import Outputs, outputs, variables

Place = tuple[int, ...]
MOTIONS = 128  # responses without contact that are kept, each with its motion, some hundred kB
CASES = 16  # motions under a contact model that are kept, with the runs that their cases share
NOTHING = np.zeros(0)
# How the parts of a case were answered: a key of each run, zero beyond the last, and whether the run was known before.
KEYS, ANSWERS = f"keys{RAGGED}", f"answers{RAGGED}"
OWN, FROM_LARGER = 1, 2
STATUS, HOW = "status", "simulated"


class RowJob:
    """The grid of a row; see `job.Job`. Raises as `row_grid.row_grid`."""

    def __init__(self, scan_input: ScanInput):
        self.scan_input, self.study = scan_input, scan_input.study
        self.grid = row_grid(self.study)
        self.variables = variables(self.grid.frame)
        study = self.study
        self.motions_shape = (len(scan_input.motions), len(study.records.polarities), len(study.grid.pgas))
        self.shape = (*self.motions_shape, *self.grid.shape)
        self.batches, self.width = int(np.prod(self.shape[:-1])), self.shape[-1]
        self.bytes_per_batch = self.width * bytes_per_case(row_variables(self.grid.frame), self.grid.frame.sizes)
        self._driven: Shared[Driven] = Shared(MOTIONS)
        self._cases: Shared[Cases] = Shared(CASES)

    def driven(self, motion: Place) -> Driven:
        """A motion of the grid (record, polarity, amplitude) and the row's response to it without contact."""
        record, polarity, amplitude = motion

        def respond() -> Driven:
            study = self.study
            ground = driven(
                self.scan_input.motions[record], study.records.polarities[polarity], study.grid.pgas[amplitude]
            )
            free = rows.free_row(self.grid.model.row(ground.dt), ground.acceleration)
            return Driven(ground.acceleration, ground.dt, ground.pga, free)

        return self._driven.of(motion, respond)

    def cases(self, motion: Place, law: int, rtol: float) -> Cases:
        """The cases of one motion under one contact model."""
        return Cases(self.grid.model, self.grid.mechanics[law], self.driven(motion), rtol)

    @cached_property
    def prepared(self) -> str:
        """Digest of the laws, and of every matrix of the row over a step of each record."""
        digest = blake2b(repr([mechanics.laws for mechanics in self.grid.mechanics]).encode(), digest_size=16)
        for step in sorted({motion.dt for motion in self.scan_input.motions}):
            for array in self.grid.model.row(step).row:
                digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def law_at(self, batch: int) -> int:
        """Index of the contact model that a batch needs."""
        return batch // self.shape[-2] % self.shape[-3]

    def solve(self, batches: range, stop: Callable[[], bool] = never) -> Chunk | None:
        """Outputs of every case, how its parts were answered, and how far runs that are repeated move."""
        chunk = self._empty(len(batches))
        answers: list[list[list[Answered]]] = []
        for slab in slabs(batches, self.shape, 1):
            answered = self._solved(slab, chunk, stop)
            if answered is None:
                return None
            answers.append(answered)
        own = np.ones((len(batches), self.width), dtype=bool)
        if self.scan_input.screening:
            own = np.array([_own(answered) for answered in answers]).reshape(own.shape)
            chunk |= _written(answers, self.width)
        if self.scan_input.check_fraction > 0.0:
            places = drawn(batches, own & (chunk[STATUS] == COMPLETE), self.scan_input.check_fraction)
            checked = self.checked(batches, chunk, places, stop)
            return None if checked is None else chunk | checked
        return chunk

    def _empty(self, count: int) -> Chunk:
        """Arrays of zeros for so many batches."""
        sizes = self.grid.frame.sizes
        chunk: Chunk = {
            name: np.zeros((count, self.width, *(sizes[dim] for dim in variable.dims)), kept_as(variable.whole))
            for name, variable in self.variables.items()
        }
        return chunk | {STATUS: np.zeros((count, self.width), np.int8)}

    def _solved(self, slab: Slab, chunk: Chunk, stop: Callable[[], bool]) -> list[list[Answered]] | None:
        """Solve one batch into its place in ``chunk``; returns how the parts of its cases were answered."""
        gap, key = slab.gaps.start, (slab.motion, slab.law)
        cases = self._cases.of(key, lambda: self.cases(*key, self.grid.rtol))
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
        pga = self.driven(slab.motion).pga
        for name, values in outputs(run, self.grid.yield_forces, pga, self.grid.frame).items():
            chunk[name][slab.batches] = values
        return answers

    def checked(
        self, batches: range, chunk: Chunk, places: NDArray[np.bool_], stop: Callable[[], bool]
    ) -> Chunk | None:
        """Repeat the runs at ``places`` at the tighter tolerance, the whole row at once.

        The change of a run is the largest over its interfaces.
        """
        at = np.argwhere(places)
        if not len(at):
            return not_made_again((len(batches), self.width))
        second: list[tuple[int, Outputs]] = []
        for batch, level in at:
            if stop():
                return None
            (slab,) = slabs(range(batches.start + batch, batches.start + batch + 1), self.shape, 1)
            limits = self.grid.limits(slab.gaps.start, level)
            run = self.cases(slab.motion, slab.law, tighter(self.grid.rtol)).whole(limits)
            second.append((run.status, outputs(run, self.grid.yield_forces[level], 0.0, self.grid.frame)))
        failed = np.array([status != COMPLETE for status, _ in second], dtype=bool)
        names = (*RELATIVE, *COUNTED)
        after = {name: np.array([repeated[name] for _, repeated in second]) for name in names}
        before = {name: chunk[name][places] for name in names}
        moves = differences(before, after, failed[:, None])
        return made_again(places, {name: values.max(axis=1) for name, values in moves.items()}, self.grid.rtol)

    @cached_property
    def template(self) -> Template:
        """The dataset without the values of its cases."""
        places = np.empty(self.motions_shape, dtype=object)
        for motion in np.ndindex(self.motions_shape):
            places[motion] = self.driven(motion)._replace(acceleration=NOTHING)  # of every motion at once: too much
        checks = check_variables(self.grid.rtol) if self.scan_input.check_fraction > 0.0 else {}
        skeleton = row_skeleton(self.study, self.scan_input.motions, places, self.grid)
        return Template(skeleton, row_variables(self.grid.frame) | checks, self.shape)

    def writer(self) -> RowWriter:
        """A new writer of this job's dataset, before its first batch."""
        return RowWriter(self)


class RowWriter:
    """Settles which cases of a row were simulated, and counts its parts; see `job.DatasetWriter`.

    A run counts for the first case that has it, in the order of the grid, largest yield force first, among the cases of
    one motion and contact model. So the count does not depend on the chunks.
    """

    def __init__(self, job: RowJob):
        self._job = job
        self._seen: set[int] = set()
        self._parts: Counter[str] = Counter()
        self._check = AtLeastOne()

    def values(self, batches: range, chunk: Chunk) -> Chunk:
        """Every case variable of these batches."""
        job = self._job
        how = np.full((len(batches), job.width), SIMULATED, dtype=np.int8)
        if job.scan_input.screening:
            how[:] = 0
            for place, batch in enumerate(batches):
                if batch % job.shape[-2] == 0:  # the first gap of another motion or contact model
                    self._seen.clear()
                self._settle(chunk[KEYS][place], chunk[ANSWERS][place], how[place])
        variables = {name: chunk[name] for name in (*job.variables, STATUS)} | {HOW: how}
        if job.scan_input.check_fraction > 0.0:
            own = how == SIMULATED
            for name, none in not_made_again(how.shape).items():
                # A run that an earlier batch has made may have been repeated here as well: it counts there.
                variables[name] = np.where(own, chunk[name], none)
            self._check.see(batches, own & (chunk[STATUS] == COMPLETE), variables[SENSITIVE])
        return variables

    def _settle(self, keys: NDArray[np.uint64], answers: NDArray[np.int8], how: NDArray[np.int8]) -> None:
        """Set in ``how`` which cases of a batch were simulated, and count their parts."""
        for level in reversed(range(len(how))):
            for key, answer in zip(keys[level].tolist(), answers[level].tolist(), strict=True):
                if not answer:
                    break
                is_new = key not in self._seen
                self._seen.add(key)
                known = "known from a larger yield force" if answer == FROM_LARGER else "equal"
                self._parts["solved" if is_new else known] += 1
                how[level] |= SIMULATED if is_new else KNOWN

    def finish(self) -> Finish:
        """The count of parts, and the repeated run of one case, where no case was drawn."""
        return Finish({"parts": as_text(dict(self._parts))}, self._check.patches(self._job))


def _own(answered: list[list[Answered]]) -> list[bool]:
    """Which cases of a batch have a run that no larger yield force of the batch has."""
    seen: set[tuple[bytes, ...]] = set()
    own = []
    for of_case in reversed(answered):
        keys = {key for key, _ in of_case}
        own.append(not keys <= seen)
        seen |= keys
    return own[::-1]


def _written(answers: list[list[list[Answered]]], width: int) -> Chunk:
    """How the parts of each case were answered, as numbers."""
    most = max((len(of_case) for batch in answers for of_case in batch), default=0)
    keys = np.zeros((len(answers), width, most), dtype=np.uint64)
    known = np.zeros(keys.shape, dtype=np.int8)
    for batch, cases in enumerate(answers):
        for level, of_case in enumerate(cases):
            for place, (key, is_known) in enumerate(of_case):
                keys[batch, level, place] = _number(key)
                known[batch, level, place] = FROM_LARGER if is_known else OWN
    return {KEYS: keys, ANSWERS: known}


def _number(key: tuple[bytes, ...]) -> int:
    """A number for the key of a run, equal in every process; of a million keys two are equal in one of 4e7 scans."""
    digest = blake2b(digest_size=8)
    for piece in key:
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return int.from_bytes(digest.digest(), "little")


def stacked(runs: list[RowRun]) -> RowRun:
    """Runs of one row as one, with an axis of runs before the others."""
    fields: list[Any] = [np.stack([np.asarray(value) for value in values]) for values in zip(*runs, strict=True)]
    return RowRun._make(fields)
