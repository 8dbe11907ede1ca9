"""A pair's study as work: compiled sweeps over the gaps and yield forces of one law under one motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.chunks import Part
from pounding_risk.ensemble.job import Finish, Order, never
from pounding_risk.ensemble.laws import laws_of
from pounding_risk.ensemble.tolerance_check import (
    AtLeastOne,
    changes,
    check_variables,
    drawn,
    made_again,
    not_made_again,
)
from pounding_risk.models.effects import wave_of
from pounding_risk.motions.motion import driven
from pounding_risk.results.layout import Form, Stretch, bytes_a_case, stretches
from pounding_risk.results.pair_labels import OUTCOME, amplitudes, pair_skeleton, pair_values, pair_variables
from pounding_risk.results.tolerance_check import tighter
from pounding_risk.scene.scene import Study
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.api import free_response, oscillators, vibration_maps
from pounding_risk.solver.pair.flight import SIGNALS, Free
from pounding_risk.solver.pair.grid import SIMULATED, solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW
from pounding_risk.solver.workspace import make_workspace

AT_ONCE = 8  # lines in one call: what Ctrl-C waits for
KEPT = 128  # responses without contact, some hundred kB each
RAW, HOW = "raw", "simulated"


class PairJob:
    """The grid of two buildings that meet mass to mass; see `jobs.Job`. Raises as `scene_laws.law_of`."""

    def __init__(self, order: Order):
        self.order, self.study = order, order.study
        study = self.study
        self.pair = oscillators(*study.pair)
        self.laws = laws_of(study)
        self.gaps, self.yield_forces = np.array(study.grid.gaps), np.array(study.grid.yield_forces)
        self.motions_shape = (len(order.motions), len(study.records.polarities), len(study.grid.pgas))
        self.shape = (*self.motions_shape, len(self.laws), self.gaps.size, self.yield_forces.size)
        self.lines, self.width = int(np.prod(self.shape[:-1])), self.yield_forces.size
        self.bytes_a_line = self.width * part_bytes(study)
        self._free: Shared[Free] = Shared(KEPT)

    def free(self, motion: tuple[int, ...]) -> Free:
        """The response without contact to a motion of the grid: record, polarity, amplitude."""
        record, polarity, amplitude = motion

        def respond() -> Free:
            study = self.study
            found = driven(self.order.motions[record], study.records.polarities[polarity], study.grid.pgas[amplitude])
            return free_response(self.pair, found.acceleration, found.dt, wave_of(study.effects))

        return self._free.of(motion, respond)

    @cached_property
    def prepared(self) -> str:
        """Of the pair, its laws, and the maps over a step of each record."""
        steps = sorted({motion.dt for motion in self.order.motions})
        maps = [vibration_maps(self.pair, step) for step in steps]
        return blake2b(repr((self.pair, self.laws, maps)).encode(), digest_size=16).hexdigest()

    def law_at(self, line: int) -> int:
        """The contact model's place in the grid."""
        return line // self.gaps.size % len(self.laws)

    def solve(self, lines: range, stop: Callable[[], bool] = never) -> Part | None:
        """Raw columns of every case, how it was answered, and what a second run of some of them told."""
        raw = np.zeros((len(lines), self.width, COLUMNS))
        how = np.zeros((len(lines), self.width), dtype=np.int8)
        for stretch in stretches(lines, self.shape, AT_ONCE):
            if stop():
                return None
            out = raw[stretch.lines], how[stretch.lines]
            self._sweep(stretch, slice(None), (self.study.rtol, self.order.screening), out)
        part: Part = {RAW: raw, HOW: how}
        if self.order.check_fraction > 0.0:
            places = drawn(lines, made(raw, how), self.order.check_fraction)
            found = self._checked(lines, raw, places, stop)
            if found is None:
                return None
            part |= found
        return part

    def _sweep(
        self,
        stretch: Stretch,
        strengths: slice,
        how_exact: tuple[float, bool],
        out: tuple[NDArray[np.float64], NDArray[np.int8]],
    ) -> None:
        """Fill ``out`` (raw columns, how each case was answered); ``how_exact`` = (rtol, screening)."""
        rtol, screening = how_exact
        grid = (self.gaps[stretch.gaps], self.yield_forces[strengths], self.study.restitution)
        law, workspace = lowered(self.laws[stretch.law]), make_workspace(rtol)
        solve_grid(self.pair, self.free(stretch.motion), law, grid, rtol, screening, workspace, *out)

    def _checked(
        self, lines: range, raw: NDArray[np.float64], places: NDArray[np.bool_], stop: Callable[[], bool]
    ) -> Part | None:
        """The runs at ``places`` (lines, yield forces) made again, at the tighter tolerance and without screening."""
        if not places.any():
            return not_made_again((len(lines), self.width))
        rtol, at = tighter(self.study.rtol), np.argwhere(places)
        second = np.zeros((len(at), COLUMNS))
        for (line, strength), out in zip(at, second, strict=True):
            if stop():
                return None
            (stretch,) = stretches(range(lines.start + line, lines.start + line + 1), self.shape, 1)
            case = slice(strength, strength + 1)
            self._sweep(stretch, case, (rtol, False), (out.reshape(1, 1, -1), np.zeros((1, 1), dtype=np.int8)))
        found = changes(raw[places], second, self.yield_forces[at[:, 1]])
        return made_again(places, found, self.study.rtol)

    def check_one(self, line: int, place: int) -> Part:
        """The variables of `recheck.check_variables` for a line, one of whose runs is made again."""
        lines = range(line, line + 1)
        part = self.solve(lines)
        places = np.arange(self.width)[None, :] == place
        found = None if part is None else self._checked(lines, part[RAW], places, never)
        assert found is not None, "nothing stops it"
        return found

    @cached_property
    def form(self) -> Form:
        """The dataset but for its cases."""
        variables = pair_variables()
        if self.order.check_fraction > 0.0:
            variables |= check_variables(self.study.rtol)
        skeleton = pair_skeleton(self.study, self.order.motions, self._alone(), self.laws)
        return Form(skeleton, variables, self.shape)

    def _alone(self) -> NDArray[np.float64]:
        """Raw columns of the responses without contact; extremes are those of the continuous motion."""
        alone = np.zeros((*self.motions_shape, COLUMNS))
        for motion in np.ndindex(self.motions_shape):
            free = self.free(motion)
            alone[motion][HIGH : HIGH + SIGNALS] = np.maximum(free.high.max(axis=0), 0.0)
            alone[motion][LOW : LOW + SIGNALS] = np.minimum(free.low.min(axis=0), 0.0)
        return alone

    def labeller(self) -> PairLabeller:
        """From raw columns to outputs."""
        return PairLabeller(self)


def part_bytes(study: Study) -> int:
    """Of a case of a part: raw columns, how it was answered, and what a second run told."""
    return 8 * COLUMNS + bytes_a_case({HOW: OUTCOME[HOW], **check_variables(study.rtol)}, {})


class PairLabeller:
    """Outputs from raw columns; see `jobs.Labeller`."""

    def __init__(self, job: PairJob):
        self._job = job
        self._pgas = amplitudes(job.study, job.order.motions).reshape(-1)
        self._watch = AtLeastOne()

    def values(self, lines: range, part: Part) -> Part:
        """Every case variable of these lines."""
        job, raw = self._job, part[RAW]
        a_motion = job.lines // self._pgas.size
        found = pair_values(job.study, raw, self._pgas[np.arange(lines.start, lines.stop) // a_motion])
        found[HOW] = part[HOW]
        if job.order.check_fraction > 0.0:
            found |= {name: part[name] for name in check_variables(job.study.rtol)}
            self._watch.see(lines, made(raw, part[HOW]), part["sensitive"])
        return found

    def finish(self) -> Finish:
        """One run is made again where none was drawn."""
        missing = self._watch.missing
        return Finish({}) if missing is None else Finish({}, ((missing[0], self._job.check_one(*missing)),))


def made(raw: NDArray[np.float64], how: NDArray[np.int8]) -> NDArray[np.bool_]:
    """The cases that had a run of their own, and a complete one."""
    return (how == SIMULATED) & (raw[..., STATUS] == COMPLETE)
