"""Accuracy of a row: its cases by every method, with the outputs of each interface."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from math import inf, nan
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.grid_job import peaks_under
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.row_job import RowJob
from pounding_risk.lab.accuracy_bench import (
    FIXED,
    INITIAL_STATES,
    REFERENCE,
    Driven,
    Outcome,
    PointCase,
    case_labels,
    driven_motions,
    own_grounds,
    thinned_grid,
)
from pounding_risk.lab.accuracy_findings import OUTPUTS
from pounding_risk.lab.baselines import fixed_step, row_fixed_step
from pounding_risk.lab.baselines.row import RowMatrices, row_matrices
from pounding_risk.lab.baselines.row_solve_ivp import RowContacts, solve_general_row
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.effects import acts_on_buildings
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.cases import Limits
from pounding_risk.solver.row.outputs import closing, outputs

Array = NDArray[np.float64]
NAMES = tuple(OUTPUTS)[:5]  # what a run has of each interface; the gap required is that of the motion without contact


class Batch(NamedTuple):
    """One law under one motion: every gap with every yield force of the bench."""

    driven: Driven
    law: int


class RowBench:
    """The cases of a row; see `accuracy_bench.Bench`. All motions and laws, gaps and yield forces evenly thinned."""

    most_general = 1

    def __init__(self, study: Scene, cases: int):
        self.study, self.driven = study, driven_motions(study)
        self.job = RowJob(ScanInput(study, motions_of(study)))
        self.model = self.job.grid.model
        gaps, forces = thinned_grid(study, cases, len(self.driven))
        self.width = len(forces)  # cases of one gap, the first of `limits`
        self.limits: list[Limits] = [self.job.grid.limits(gap, force) for gap in gaps for force in forces]
        laws = study.grid.contact_models
        self.batches = [Batch(driven, law) for driven in self.driven for law in range(len(laws))]
        self.motions = tuple(driven.motion for driven in self.driven)
        given_gaps = [study.grid.gaps[index] for index in gaps]
        # With one yield force in the grid every interface has its own.
        several = len(study.grid.yield_forces) > 1
        given_forces = [study.grid.yield_forces[index] for index in forces] if several else []
        self.labels = tuple(
            label
            for driven, law in self.batches
            for label in case_labels(driven.name, laws[law], given_gaps, given_forces)
        )
        self.event_only = self._event_only()

    def _event_only(self) -> str:
        """Effects, path-dependent and impulsive models of the scene, which only the event-driven solver has.

        P-Δ and soil are in the matrices of the buildings, which every method takes.
        """
        yields = any(np.isfinite(chain.strength).any() for chain in self.model.chains)
        effects = [effect.name for effect in self.study.effects if not acts_on_buildings(effect.name)]
        storeys = ["inelastic_storeys"] if yields else []
        begun = [INITIAL_STATES] if any(chain.initial.size for chain in self.model.chains) else []
        paths = filter(_has_path, self.study.model_names)
        return ", ".join([*effects, *storeys, *paths, *begun, *own_grounds(self.study)])

    @property
    def chains(self) -> tuple[Chain, ...]:
        """The buildings, left to right."""
        return self.model.chains

    @property
    def points(self) -> tuple[Point, ...]:
        """The contact points, interface by interface."""
        return self.model.points

    def point_cases(self) -> Iterator[PointCase]:
        """The cases in their order."""
        for number, law in np.ndindex(len(self.driven), len(self.study.grid.contact_models)):
            laws, rules = self.models(law)
            for limits in self.limits:
                yield PointCase(number, laws, rules, limits.gaps, limits.yield_forces)

    @property
    def size(self) -> int:
        """Number of cases that every setting runs."""
        return len(self.batches) * len(self.limits)

    @property
    def closed_at_rest(self) -> NDArray[np.bool_]:
        """True where the gap is closed at rest, (cases, interfaces)."""
        closed = [self._gathered(np.minimum, limits.gaps) == 0.0 for limits in self.limits]
        return np.tile(np.array(closed), (len(self.batches), 1))

    def _gathered(self, gather: Any, values: Array) -> Array:
        """Values of the interfaces from those of their contact points, along the first axis."""
        return np.asarray(gather.reduceat(values, self.model.bounds[:-1], axis=0))

    @cached_property
    def matrices(self) -> RowMatrices:
        """The row as the other methods take it."""
        return row_matrices(self.model.chains, self.model.points)

    def models(self, law: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """Laws and relations of restitution by contact point."""
        mechanics = self.job.grid.mechanics[law]
        return tuple(map(lowered, mechanics.laws)), tuple(map(lowered, mechanics.restitutions))

    def warm_up(self) -> None:
        """Compile every kernel that is needed."""
        short = self.motions[0].first(3)
        for law in range(len(self.study.grid.contact_models)):
            self.job.cases(self.driven[0].place, law, REFERENCE).whole(self.limits[0])
            for method in () if self.event_only else FIXED.values():
                self._by_steps(method, (short, law, self.limits[0]), inf)

    def event(self, rtol: float) -> Outcome:
        """The event-driven solver over all cases, the whole row at once, every case run."""
        values, residual, steps, seconds, free_seconds = [], 0.0, 0, 0.0, 0.0
        required = {}
        for driven, law in self.batches:
            motion, begun = driven.motion, process_time()
            if driven.place not in required:
                own = motion.own_grounds
                under = self.model.under(motion.acceleration, own)
                free = rows.free_row(self.model.row(motion.dt, self.model.has_many(own)), under)
                free_seconds += process_time() - begun
                required[driven.place] = np.maximum(closing(free, self.model)[1], 0.0)
            cases = self.job.cases(driven.place, law, rtol)
            for limits in self.limits:
                begun = process_time()
                run = cases.whole(limits)
                seconds += process_time() - begun
                values_of_run = outputs(run, limits.yield_forces, peaks_under(self.study, motion), self.job.grid.frame)
                values.append(np.column_stack([*(values_of_run[name] for name in NAMES), required[driven.place]]))
                values[-1][run.status != COMPLETE] = nan
                residual, steps = max(residual, float(np.nanmax(values_of_run["energy_residual"]))), steps + run.steps
        table = np.array(values)
        return self._outcome(table, steps, residual, seconds + free_seconds, free_seconds)

    def fixed(self, method: str, dt: float) -> Outcome:
        """A fixed-step method over all cases in steps of about ``dt`` [s], a whole number of them a sample."""
        values, steps, seconds, free_seconds = [], 0.0, 0.0, 0.0
        open_limits = self.limits[0]._replace(gaps=np.full(len(self.model.points), inf))
        required = {}
        for driven, law in self.batches:
            if driven.place not in required:
                free, run_seconds = self._by_steps(method, (driven.motion, law, open_limits), dt)
                required[driven.place] = self._gathered(np.maximum, free[:, fixed_step.CLOSING])
                free_seconds += run_seconds
            for limits in self.limits:
                raw, run_seconds = self._by_steps(method, (driven.motion, law, limits), dt)
                seconds, steps = seconds + run_seconds, steps + raw[:, fixed_step.TOUCHING].sum()
                points = {
                    "peak_relative_displacement": raw[:, fixed_step.REACH],
                    "peak_contact_force": raw[:, fixed_step.FORCE],
                    "impact_count": raw[:, fixed_step.COUNT],
                    "yield_exceedance": (raw[:, fixed_step.DEMAND] >= limits.yield_forces).astype(float),
                    "first_impact_time": raw[:, fixed_step.FIRST],
                }
                values.append(self._of_interfaces(points, required[driven.place]))
                values[-1][(raw[:, fixed_step.UNSTABLE] != 0.0).any()] = nan
        return self._outcome(np.array(values), steps, nan, seconds, free_seconds)

    def _of_interfaces(self, points: dict[str, Array], required: Array) -> Array:
        """(interfaces, OUTPUTS) from the outputs of contact points and the gaps required."""
        gather = {"impact_count": np.add, "first_impact_time": np.fmin}
        columns = [self._gathered(gather.get(name, np.maximum), points[name]) for name in NAMES]
        return np.column_stack([*columns, required])

    def _by_steps(self, method: str, case: tuple[Any, int, Limits], dt: float) -> tuple[Array, float]:
        """One run in steps, (contact points, columns of `fixed_step`), and its processor time [s]."""
        motion, law, limits = case
        ground = fixed_step.divided(motion.acceleration, motion.dt, dt)
        laws, rules = self.models(law)
        begun = process_time()
        bounds = limits.gaps, limits.yield_forces
        return row_fixed_step.solve_fixed_row(
            method, self.matrices, laws, rules, bounds, ground
        ), process_time() - begun

    def general(self, solver: str, rtol: float) -> Outcome:
        """SciPy over one case of each of the first motions, the first gap with the largest yield force."""
        shape = (len(self.batches), len(self.limits), len(self.model.bounds) - 1, len(OUTPUTS))
        values, contacts, steps = np.full(shape, nan), 0.0, 0.0
        durations: list[tuple[float, float]] = []
        for number, (driven, law) in enumerate(self.batches):
            if len(durations) == self.most_general or law > 0:
                continue
            limits, (laws, rules) = self.limits[self.width - 1], self.models(law)
            ground, begun = (driven.motion.acceleration, driven.motion.dt), process_time()
            there = RowContacts(limits.gaps, laws, rules, limits.yield_forces)
            run = solve_general_row(solver, self.matrices, there, ground, rtol)
            middle = process_time()
            # A gap of a kilometre stays open, and leaves SciPy's root search a finite number.
            far = there._replace(gaps=np.full(len(laws), 1e3))
            alone = solve_general_row(solver, self.matrices, far, ground, rtol)
            durations.append((middle - begun, process_time() - middle))
            contacts, steps = contacts + run.impact_count.sum(), steps + run.steps
            points = {name: getattr(run, name) for name in NAMES if name != "yield_exceedance"}
            points["yield_exceedance"] = (run.uncapped_force >= limits.yield_forces).astype(float)
            values[number, self.width - 1] = self._of_interfaces(points, self._gathered(np.maximum, alone.peak_closing))
        seconds, free_seconds = np.mean(durations, axis=0)
        table = values.reshape(self.size, *shape[2:])
        return Outcome(table, steps / max(contacts, 1.0), nan, float(seconds), float(free_seconds))

    def _outcome(self, values: Array, steps: float, residual: float, seconds: float, free_seconds: float) -> Outcome:
        """An outcome from the steps in contact and processor times [s] of all cases."""
        contacts = max(float(np.nansum(values[:, :, NAMES.index("impact_count")])), 1.0)
        times = seconds / self.size, free_seconds / len(self.motions)
        return Outcome(values, steps / contacts, residual, *times)


def _has_path(name: str) -> bool:
    return is_path_dependent(known_law(name)) or is_instant(known_law(name))
