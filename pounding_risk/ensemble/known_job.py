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
        """Σ share u at these times, which include its own, and du/ds at both ends of each interval, s 0 to 1."""
        u = self.moved @ shares
        if self.rates is None:
            displacements = np.interp(times, self.times, u)
            return displacements, np.diff(displacements), np.diff(displacements)
        intervals = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        step = self.times[intervals + 1] - self.times[intervals]
        s = (times - self.times[intervals]) / step
        start, end = (step * (self.rates @ shares)[intervals + side] for side in (0, 1))
        rise = u[intervals + 1] - u[intervals]
        bend, twist = 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise
        displacements = u[intervals] + s * (start + s * (bend + s * twist))
        slopes = (start + s * (2.0 * bend + 3.0 * s * twist)) / step
        lengths = np.diff(times)
        return displacements, slopes[:-1] * lengths, slopes[1:] * lengths


def extremes(displacements: Array, starts: Array, ends: Array) -> tuple[float, float]:
    """Largest and smallest value of cubics one after the other, from their values and slopes at the ends of each."""
    rise = np.diff(displacements)
    bend, twist = 3.0 * rise - 2.0 * starts - ends, starts + ends - 2.0 * rise
    values = [displacements]
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(bend**2 - 3.0 * twist * starts)  # NaN where the cubic does not turn
        q = -(bend + np.copysign(root, bend))
        for s in (q / (3.0 * twist), starts / q):
            s = np.where((s > 0.0) & (s < 1.0), s, 0.0)
            values.append(displacements[:-1] + s * (starts + s * (bend + s * twist)))
    all_values = np.concatenate(values)
    return float(all_values.max()), float(all_values.min())


def with_known(study: Scene, model: RowModel, motion: Motion, free: RowRun) -> RowRun:
    """The motion of a row without contact, with the histories of its known buildings in place of computed motion."""
    if free.status != COMPLETE:
        return free
    points, floors, rest_state = free.points.copy(), free.floors.copy(), free.rest.copy()
    paths = _paths(study, model, motion)
    for place, building in enumerate(study.buildings):
        if building.displacement_history:
            dofs = slice(*model.firsts[place : place + 2])
            u = paths[place].moved
            drifts = np.diff(u, axis=1, prepend=0.0)
            floors[dofs] = rest_state[dofs] = np.nan  # no shear, acceleration and plastic drift is known
            floors[dofs, DISPLACEMENT], floors[dofs, DRIFT] = np.abs(u).max(axis=0), np.abs(drifts).max(axis=0)
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
            points[k, HIGHEST], points[k, LOWEST] = extremes(*(sum(piece) for piece in pieces))
    return free._replace(points=points, floors=floors, rest=rest_state)


def _paths(study: Scene, model: RowModel, motion: Motion) -> list[Path]:
    """The motion of the masses of each building."""
    histories, times = histories_beside(study, motion), np.asarray(motion.times, dtype=np.float64)
    states = np.zeros((len(times), 2, 0))
    if any(place not in histories and chain.mass.size for place, chain in enumerate(model.chains)):
        states = rows.free_row(model.row(motion.dt), motion.acceleration, states=True).states
    paths = []
    for place, chain in enumerate(model.chains):
        if place in histories:
            displacements = np.zeros((len(histories[place].times), chain.mass.size))
            displacements[:, chain.foundations : chain.foundations + chain.floors] = histories[place].floors
            paths.append(Path(histories[place].times, displacements))
        else:
            dofs = slice(*model.firsts[place : place + 2])
            paths.append(Path(times, states[:, 0, dofs], states[:, 1, dofs]))
    return paths


class KnownCases(NamedTuple):
    """Every case of one motion, none of which is run; as `Cases`."""

    free: RowRun

    def in_parts(self, limits: Limits) -> tuple[RowRun, list[Answered]]:
        """The motion without contact, whose status says where contact would follow; there are no runs."""
        closes = self.free.status == COMPLETE and bool((self.free.points[:, HIGHEST] > limits.gaps).any())
        return (self.free._replace(status=UNPUSHED) if closes else self.free), []


class KnownJob(RowJob):
    """The grid of a row in which a building moves as files say."""

    def __init__(self, scan_input: ScanInput):
        super().__init__(scan_input._replace(screening=True))  # no case is a run of its own
        self.caches["known"] = Shared(MOTIONS)

    @classmethod
    def closing(cls, study: Scene) -> Callable[[Motion], tuple[Array, Any]]:
        respond, model = super().closing(study), model_of(study)
        gaps = grid_gaps(study, model)

        def respond_known(motion: Motion) -> tuple[Array, Any]:
            closed, (response, ground) = respond(motion)
            run = with_known(study, model, motion, response.run)
            known_closing = (run.points[:, HIGHEST] - gaps).max(axis=1) if run.status == COMPLETE else closed
            return known_closing, (response, ground)

        return respond_known

    @classmethod
    def endings(cls, study: Scene) -> dict[int, str]:
        return super().endings(study) | {UNPUSHED: UNPUSHED_SENTENCE}

    def free(self, motion: Place) -> Driven:
        def respond() -> Driven:
            computed = RowJob.free(self, motion)
            run = with_known(self.study, self.grid.model, self.ground(motion), computed.free)
            return computed._replace(free=run)

        return self.caches["known"].of((self.free_key, motion), respond)

    def _solved(self, slab: Slab, chunk: Chunk, stop: Callable[[], bool]) -> list[list[Answered]] | None:
        answers = super()._solved(slab, chunk, stop)
        self._without_known_ductility(chunk)
        return answers

    def _peaks(self, motion: Place) -> dict[str, Array]:
        return self._without_known_ductility(super()._peaks(motion))

    def _without_known_ductility(self, outputs: dict[str, Any]) -> dict[str, Any]:
        """The outputs with NaN for the ductility of known buildings, whose yield drift is not known."""
        if "storey_ductility" in outputs:
            is_known = [bool(building.displacement_history) for building in self.study.buildings]
            outputs["storey_ductility"][..., is_known, :] = np.nan
        return outputs

    def cases(self, motion: Place, law: int, rtol: float) -> Any:
        """The cases of one motion, whatever the contact model."""
        return KnownCases(self.free(motion).free)
