"""A row's whole grid: every case solved in its parts, no part twice, on threads over motions, laws and gaps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk import rows
from pounding_risk.core.sweep import KNOWN, SIMULATED
from pounding_risk.core.tally import COMPLETE
from pounding_risk.motions import Motion, driven
from pounding_risk.recheck import as_variables, chosen, differences
from pounding_risk.rechecked import COUNTED, RELATIVE, tighter
from pounding_risk.row_cases import Answered, Cases, Driven
from pounding_risk.row_dataset import ScannedRow, labelled_row
from pounding_risk.row_grid import row_grid
from pounding_risk.row_outputs import Outputs, Variable, outputs, variables
from pounding_risk.rows import RowRun
from pounding_risk.scan_dataset import AXES
from pounding_risk.study import Study
from pounding_risk.threads import How, Progress, counter, work_through

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Place = tuple[int, ...]


class RowChunk(NamedTuple):
    """A piece of work: one gap of one contact model under one motion; places along the dataset's axes."""

    motion: Place  # record, polarity, amplitude
    law: int
    gap: int


class Done(NamedTuple):
    """What a piece of work tells: how each of its cases was answered, by yield force; None where all were run."""

    chunk: RowChunk
    answered: list[list[Answered]] | None


class Sheet:
    """The cases of one motion under one contact model: their runs while work lasts, then how they were answered."""

    def __init__(self, cases: Cases, gaps: int):
        self.cases: Cases | None = cases
        self.answers: list[list[list[Answered]]] = [[] for _ in range(gaps)]
        self.left = gaps

    def settle(self, how: NDArray[np.int8], parts: Counter[str]) -> None:
        """Say which cases, ``how`` (gaps, yield forces), have a run of their own, and count the parts.

        An answer is told as the run of the first case that has it, in the grid's order, largest yield force first:
        so the count is the same whichever thread was first.
        """
        self.cases = None
        seen: set[Any] = set()
        for gap, levels in enumerate(self.answers):
            for level in reversed(range(len(levels))):
                for key, known in levels[level]:
                    is_new = key not in seen
                    seen.add(key)
                    parts["solved" if is_new else "known from a larger yield force" if known else "equal"] += 1
                    how[gap, level] |= SIMULATED if is_new else KNOWN
        self.answers = []


class RowScan:
    """One scan of a row: the grid, the motions with their free responses, and the dataset's arrays as they fill."""

    def __init__(self, study: Study, motions: tuple[Motion, ...], workers: int):
        self.study, self.motions, self.workers = study, motions, workers
        self.grid = row_grid(study)
        self.driven = self._free_responses()
        self.shape = (*self.driven.shape, *self.grid.shape)
        self.variables = variables(self.grid.frame)
        self.arrays = {name: self._empty(variable) for name, variable in self.variables.items()}
        self.status, self.how = np.zeros(self.shape, np.int8), np.zeros(self.shape, np.int8)
        self.parts: Counter[str] = Counter()

    def _empty(self, variable: Variable) -> NDArray[Any]:
        frame = self.grid.frame
        buildings, storeys = frame.storeys.shape
        sizes = {"building": buildings, "storey": storeys, "interface": buildings - 1}
        sizes["contact_point"] = len(frame.model.points)
        shape = (*self.shape, *(sizes[dim] for dim in variable.dims))
        return np.zeros(shape, np.int32 if variable.whole else np.float64)

    def _free_responses(self) -> NDArray[Any]:
        """`Driven` by record, polarity and amplitude."""
        study, model = self.study, self.grid.model
        found = np.empty((len(self.motions), len(study.records.polarities), len(study.grid.pgas)), dtype=object)

        def respond(place: Place) -> None:
            motion = driven(self.motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]])
            free = rows.free_row(model.row(motion.dt), motion.acceleration)
            found[place] = Driven(motion.acceleration, motion.dt, motion.pga, free)

        places = list(np.ndindex(found.shape))
        respond(places[0])  # compiles
        with ThreadPoolExecutor(self.workers) as pool:
            list(pool.map(respond, places[1:]))
        return found

    def cases(self, motion: Place, law: int, rtol: float) -> Cases:
        """The cases of one motion under one contact model."""
        return Cases(self.grid.model, self.grid.mechanics[law], self.driven[motion], rtol)

    def run(self, screening: bool, progress: Progress | None) -> None:
        """Fill the arrays."""
        laws, gaps, strengths = self.grid.shape
        sheets = {
            (motion, law): Sheet(self.cases(motion, law, self.grid.rtol), gaps)
            for motion in np.ndindex(self.driven.shape)
            for law in range(laws)
        }
        count = counter(self.how.size, progress)

        def work(chunk: RowChunk) -> Done:
            cases = sheets[chunk.motion, chunk.law].cases
            assert cases is not None, "a sheet keeps its cases until its last chunk is done"
            limits = [self.grid.limits(chunk.gap, level) for level in range(strengths)]
            if screening:
                found = [cases.in_parts(each) for each in limits]
                self._keep(chunk, [run for run, _ in found])
                return Done(chunk, [answered for _, answered in found])
            self._keep(chunk, [cases.whole(each) for each in limits])
            return Done(chunk, None)

        def advance(done: Done) -> None:
            chunk, sheet = done.chunk, sheets[done.chunk.motion, done.chunk.law]
            place = (*chunk.motion, chunk.law)
            sheet.left -= 1
            if done.answered is None:
                self.how[(*place, chunk.gap)] = SIMULATED
            else:
                sheet.answers[chunk.gap] = done.answered
            if sheet.left == 0:
                sheet.settle(self.how[place], self.parts)
            count(strengths)

        work_through(self._chunks(), work, self.workers, advance)

    def _chunks(self) -> Iterator[RowChunk]:
        laws, gaps, _ = self.grid.shape
        for motion in np.ndindex(self.driven.shape):
            for law in range(laws):
                for gap in range(gaps):
                    yield RowChunk(motion, law, gap)

    def _keep(self, chunk: RowChunk, runs: list[RowRun]) -> None:
        """Write the outputs of a chunk's runs, one a yield force, to their places."""
        place = (*chunk.motion, chunk.law, chunk.gap)
        run = stacked(runs)
        self.status[place] = run.status
        found = outputs(run, self.grid.yield_forces, self.driven[chunk.motion].pga, self.grid.frame)
        for name, values in found.items():
            self.arrays[name][place] = values

    def check(self, fraction: float) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, Any]]]:
        """A share of the runs made again at a tighter tolerance, the whole row at once: what moves, at most.

        Over all interfaces of a run; as `recheck.check_runs`.
        """
        places = chosen((self.how == SIMULATED) & (self.status == COMPLETE), fraction)
        at, rtol = tuple(places.T), tighter(self.grid.rtol)

        def again(place: NDArray[np.int64]) -> tuple[int, Outputs]:
            *motion, law, gap, level = map(int, place)
            run = self.cases(tuple(motion), law, rtol).whole(self.grid.limits(gap, level))
            return run.status, outputs(run, self.grid.yield_forces[level], 0.0, self.grid.frame)

        with ThreadPoolExecutor(self.workers) as pool:
            second = list(pool.map(again, places))
        failed = np.array([status != COMPLETE for status, _ in second], dtype=bool)
        names = (*RELATIVE, *COUNTED)
        after = {name: np.array([found[name] for _, found in second]) for name in names}
        before = {name: self.arrays[name][at] for name in names}
        interfaces = self.grid.gaps.shape[1]
        shape = len(places), interfaces
        found = differences(before, {name: after[name].reshape(shape) for name in names}, failed[:, None])
        largest = {name: values.max(axis=1) for name, values in found.items()}
        return {
            name: (AXES, values, told)
            for name, (values, told) in as_variables(largest, places, self.how.shape, self.grid.rtol).items()
        }


def stacked(runs: list[RowRun]) -> RowRun:
    """Runs of one row as one, with an axis of runs before the others."""
    fields = [np.stack([np.asarray(value) for value in values]) for values in zip(*runs, strict=True)]
    return RowRun._make(fields)


def scan_row(study: Study, motions: tuple[Motion, ...], how_much: How) -> xr.Dataset:
    """The dataset of a row's grid; raises as `row_grid.row_grid`."""
    one = RowScan(study, motions, how_much.workers)
    one.run(how_much.screening, how_much.progress)
    checks = one.check(how_much.check_fraction) if how_much.check_fraction > 0.0 else {}
    made = ScannedRow(motions, one.driven, one.grid, one.arrays, one.variables, one.status, one.how, one.parts)
    return labelled_row(study, made, checks)
