"""The job of a scene in which a building moves as files say: the motion without contact, and no contact run.

Every other building is computed as in any row. At a contact point with a known floor the distance is found from both
sides: the known floors straight between their samples, the computed ones as the cubic through displacements and
velocities at the samples of the record, which differs from their motion by at most h⁴/384 max|d⁴u/dt⁴|, h the time
step. A case whose motion closes no gap is complete; where one is closed, what follows depends on contact that pushes
back, and the case has the status UNPUSHED.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.grid_job import Array, Place
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.ensemble.row_job import MOTIONS, RowJob, grid_gaps
from pounding_risk.motions.motion import Motion
from pounding_risk.results.layout import Slab
from pounding_risk.results.variables import UNPUSHED, UNPUSHED_SENTENCE
from pounding_risk.scene.known_motions import histories_beside
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import HIGHEST, LOWEST, RowRun
from pounding_risk.solver.row.cases import Answered, Driven, Limits
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import AT_END, DISPLACEMENT, DRIFT


class Path(NamedTuple):
    """Displacement of masses: straight between samples, or by velocities at them as a cubic."""

    times: Array  # s
    moved: Array  # m, (times, masses)
    rates: Array | None = None  # m/s

    def pieces(self, times: Array, shares: Array) -> tuple[Array, Array, Array]:
        """Σ share u at these times, among them all of its own, and du/ds at both ends of each interval, s 0 to 1."""
        u = self.moved @ shares
        if self.rates is None:
            displacements = np.interp(times, self.times, u)
            return displacements, np.diff(displacements), np.diff(displacements)
        within = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        step = self.times[within + 1] - self.times[within]
        s = (times - self.times[within]) / step
        start, end = (step * (self.rates @ shares)[within + at] for at in (0, 1))
        rise = u[within + 1] - u[within]
        bend, twist = 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise
        displacements = u[within] + s * (start + s * (bend + s * twist))
        slopes = (start + s * (2.0 * bend + 3.0 * s * twist)) / step
        lengths = np.diff(times)
        return displacements, slopes[:-1] * lengths, slopes[1:] * lengths


def extremes(displacements: Array, starts: Array, ends: Array) -> tuple[float, float]:
    """Largest and smallest value of cubics one after the other, from their values and slopes at the ends of each."""
    rise = np.diff(displacements)
    bend, twist = 3.0 * rise - 2.0 * starts - ends, starts + ends - 2.0 * rise
    every = [displacements]
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(bend**2 - 3.0 * twist * starts)  # NaN where the cubic does not turn
        turned = -(bend + np.copysign(root, bend))
        for s in (turned / (3.0 * twist), starts / turned):
            s = np.where((s > 0.0) & (s < 1.0), s, 0.0)
            every.append(displacements[:-1] + s * (starts + s * (bend + s * twist)))
    together = np.concatenate(every)
    return float(together.max()), float(together.min())


def with_known(study: Scene, model: RowModel, motion: Motion, free: RowRun) -> RowRun:
    """The motion of a row without contact, with that of its known buildings in place of what was computed of them."""
    if free.status != COMPLETE:
        return free
    points, floors, rest_state = free.points.copy(), free.floors.copy(), free.rest.copy()
    paths = _paths(study, model, motion)
    for place, building in enumerate(study.buildings):
        if building.displacement_history:
            dofs = slice(*model.firsts[place : place + 2])
            moved = paths[place].moved
            drifts = np.diff(moved, axis=1, prepend=0.0)
            floors[dofs] = rest_state[dofs] = np.nan  # no shear, acceleration and plastic drift is known
            floors[dofs, DISPLACEMENT], floors[dofs, DRIFT] = np.abs(moved).max(axis=0), np.abs(drifts).max(axis=0)
            rest_state[dofs, AT_END] = drifts[-1]
    layout = model.row(motion.dt).row
    for k, point in enumerate(model.points):
        sides = point.interface, point.interface + 1
        if any(study.buildings[side].displacement_history for side in sides):
            shares = np.zeros(len(floors))
            ends = layout.ends[k, :4]
            np.add.at(shares, ends[ends >= 0], layout.shares[k, :4][ends >= 0])
            known_sides = [(paths[side], shares[slice(*model.firsts[side : side + 2])]) for side in sides]
            # Σ share u over both, until the first of them ends.
            times = np.unique(np.concatenate([path.times for path, _ in known_sides]))
            times = times[times <= min(path.times[-1] for path, _ in known_sides)]
            pieces = zip(*(path.pieces(times, dofs) for path, dofs in known_sides), strict=True)
            points[k, HIGHEST], points[k, LOWEST] = extremes(*(sum(one) for one in pieces))
    return free._replace(points=points, floors=floors, rest=rest_state)


def _paths(study: Scene, model: RowModel, motion: Motion) -> list[Path]:
    """The motion of the masses of each building."""
    known, times = histories_beside(study, motion), np.asarray(motion.times, dtype=np.float64)
    states = np.zeros((len(times), 2, 0))
    if any(place not in known and chain.mass.size for place, chain in enumerate(model.chains)):
        states = rows.free_row(model.row(motion.dt), motion.acceleration, states=True).states
    paths = []
    for place, chain in enumerate(model.chains):
        if place in known:
            moved = np.zeros((len(known[place].times), chain.mass.size))
            moved[:, chain.foundations : chain.foundations + chain.floors] = known[place].floors
            paths.append(Path(known[place].times, moved))
        else:
            dofs = slice(*model.firsts[place : place + 2])
            paths.append(Path(times, states[:, 0, dofs], states[:, 1, dofs]))
    return paths


class KnownCases(NamedTuple):
    """Every case of one motion, of which none is run; as `Cases`."""

    free: RowRun

    def in_parts(self, limits: Limits) -> tuple[RowRun, list[Answered]]:
        """The motion without contact, whose status says where contact would follow; there are no runs."""
        closes = self.free.status == COMPLETE and bool((self.free.points[:, HIGHEST] > limits.gaps).any())
        return (self.free._replace(status=UNPUSHED) if closes else self.free), []


class KnownJob(RowJob):
    """The grid of a row in which a building moves as files say."""

    def __init__(self, scan_input: ScanInput):
        super().__init__(scan_input._replace(screening=True))  # no case is a run of its own
        self.held["known"] = Shared(MOTIONS)

    @classmethod
    def closing(cls, study: Scene) -> Callable[[Motion], tuple[Array, Any]]:
        respond, model = super().closing(study), model_of(study)
        gaps = grid_gaps(study, model)

        def respond_known(motion: Motion) -> tuple[Array, Any]:
            closed, (response, under) = respond(motion)
            run = with_known(study, model, motion, response.run)
            known = (run.points[:, HIGHEST] - gaps).max(axis=1) if run.status == COMPLETE else closed
            return known, (response, under)

        return respond_known

    @classmethod
    def endings(cls, study: Scene) -> dict[int, str]:
        return super().endings(study) | {UNPUSHED: UNPUSHED_SENTENCE}

    def free(self, motion: Place) -> Driven:
        def respond() -> Driven:
            computed = RowJob.free(self, motion)
            run = with_known(self.study, self.grid.model, self.ground(motion), computed.free)
            return computed._replace(free=run)

        return self.held["known"].of((self.free_key, motion), respond)

    def _solved(self, slab: Slab, chunk: Chunk, stop: Callable[[], bool]) -> list[list[Answered]] | None:
        answers = super()._solved(slab, chunk, stop)
        self._forget(chunk)
        return answers

    def _peaks(self, motion: Place) -> dict[str, Array]:
        return self._forget(super()._peaks(motion))

    def _forget(self, outputs: dict[str, Any]) -> dict[str, Any]:
        """No yield drift of a known building is known."""
        if "storey_ductility" in outputs:
            known = [bool(building.displacement_history) for building in self.study.buildings]
            outputs["storey_ductility"][..., known, :] = np.nan
        return outputs

    def cases(self, motion: Place, law: int, rtol: float) -> Any:
        """The cases of one motion, whatever the contact model."""
        return KnownCases(self.free(motion).free)
