"""Accuracy of two single masses that meet mass to mass: their cases by every method."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, nan
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.ensemble.laws import law_of
from pounding_risk.lab.accuracy_bench import (
    FIXED,
    INITIAL_STATES,
    REFERENCE,
    Outcome,
    PointCase,
    case_labels,
    driven_motions,
    own_grounds,
    thinned_grid,
)
from pounding_risk.lab.accuracy_findings import OUTPUTS
from pounding_risk.lab.baselines import fixed_step as fixed
from pounding_risk.lab.baselines.solve_ivp import solve_general
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.scene import Scene
from pounding_risk.solver import counters as tally
from pounding_risk.solver.pair.api import Interface, free_response, initial_state, oscillators, workspace_for
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW


class Batch(NamedTuple):
    """One law under one motion: every gap with every yield force of the bench."""

    motion: int  # its index in `PairBench.motions`
    law: Any
    labels: tuple[str, ...]  # of its cases


@dataclass(frozen=True)
class PairBench:
    """The cases of a pair; see `accuracy_bench.Bench`."""

    chains: tuple[Chain, Chain]
    pair: Any
    motions: tuple[Any, ...]  # in each polarity and amplitude
    batches: tuple[Batch, ...]
    gaps: np.ndarray
    yield_forces: np.ndarray
    restitution: Any
    supports: tuple[Support, ...]
    initial: tuple[float, ...]  # of `initial_state`
    event_only: str

    most_general = 3

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of gaps and of yield forces."""
        return len(self.gaps), len(self.yield_forces)

    @property
    def size(self) -> int:
        """Number of cases that every setting runs."""
        return len(self.batches) * len(self.gaps) * len(self.yield_forces)

    @property
    def labels(self) -> tuple[str, ...]:
        """What tables call each case: motion, contact model, gap and yield force."""
        return tuple(label for batch in self.batches for label in batch.labels)

    @property
    def grid(self) -> tuple[np.ndarray, np.ndarray, Any]:
        """Gaps, yield forces and restitution, as the kernel takes them."""
        return self.gaps, self.yield_forces, self.restitution

    @property
    def closed_at_rest(self) -> np.ndarray:
        """True where the gap is closed at rest, (cases, 1)."""
        return self.by_case(0)[:, None] == 0.0

    @property
    def points(self) -> tuple[Point, ...]:
        """The one contact point, mass to mass."""
        return (Point(0, 1.0, 1.0, FLOOR, nan),)

    def point_cases(self) -> Iterator[PointCase]:
        """The cases in their order."""
        for batch in self.batches:
            for gap in self.gaps:
                for force in self.yield_forces:
                    yield PointCase(batch.motion, (batch.law,), (self.restitution,), np.array([gap]), np.array([force]))

    def by_case(self, axis: int) -> np.ndarray:
        """The gap (axis 0) or yield force (axis 1) of every case."""
        values = np.meshgrid(self.gaps, self.yield_forces, indexing="ij")[axis]
        return np.tile(values.ravel(), len(self.batches))

    def warm_up(self) -> None:
        """Compile every kernel that is needed."""
        short = tuple(motion.first(3) for motion in self.motions)
        for batch in {type(batch.law): batch for batch in self.batches}.values():
            small = replace(self, motions=short, batches=(batch,))
            small.event(REFERENCE)
            for method in () if self.event_only else FIXED.values():
                small.fixed(method, inf)

    def event(self, rtol: float) -> Outcome:
        """The event-driven solver over all cases, every case run."""
        raws, required, free_seconds, seconds = [], [], 0.0, 0.0
        frees: dict[int, Any] = {}
        for batch in self.batches:
            motion = self.motions[batch.motion]
            out, how = np.zeros((*self.shape, COLUMNS)), np.zeros(self.shape, dtype=np.int8)
            start = process_time()
            if batch.motion not in frees:
                frees[batch.motion] = free_response(
                    self.pair, motion.acceleration, motion.dt, self.supports, self.initial, motion.own_grounds
                )
                free_seconds += process_time() - start
            free = frees[batch.motion]
            solve_grid(self.pair, free, batch.law, self.grid, rtol, False, workspace_for(free, rtol), out, how)
            seconds += process_time() - start
            raws.append(out.reshape(-1, COLUMNS))
            required += [max(float(free.high[:, 0].max()), 0.0)] * how.size
        raw = np.concatenate(raws)
        columns = (np.maximum(raw[:, HIGH], -raw[:, LOW]), raw[:, tally.PEAK_FORCE], raw[:, tally.COUNT])
        exceeds = raw[:, tally.DEMAND] >= self.by_case(1)
        values = np.column_stack([*columns, exceeds, raw[:, tally.FIRST_TOUCH], required])
        values[raw[:, tally.STATUS] != tally.COMPLETE] = nan
        residual = np.abs(raw[:, tally.RESIDUAL]) / np.where(raw[:, tally.ENERGY] > 0.0, raw[:, tally.ENERGY], 1.0)
        steps = raw[:, tally.STEPS].sum() / max(raw[:, tally.COUNT].sum(), 1.0)
        return self._outcome(values, steps, float(residual.max()), seconds, free_seconds)

    def fixed(self, method: str, dt: float) -> Outcome:
        """A fixed-step method over all cases in steps of about ``dt`` [s], a whole number of them a sample."""
        stepper, rows, seconds, free_seconds, required = fixed.STEPPERS[method], [], 0.0, 0.0, []
        grounds = [fixed.divided(motion.acceleration, motion.dt, dt) for motion in self.motions]
        for batch in self.batches:
            out = np.zeros((*self.shape, fixed.COLUMNS))
            start = process_time()
            fixed.sweep_fixed(stepper, self.pair, batch.law, self.grid, grounds[batch.motion], out)
            seconds += process_time() - start
            rows.append(out.reshape(-1, fixed.COLUMNS))
        alone = (np.array([inf]), np.array([inf]), self.restitution)
        for ground in grounds:
            out = np.zeros((1, 1, fixed.COLUMNS))
            start = process_time()
            fixed.sweep_fixed(stepper, self.pair, self.batches[0].law, alone, ground, out)
            free_seconds += process_time() - start
            required.append(nan if out[0, 0, fixed.UNSTABLE] else out[0, 0, fixed.CLOSING])
        raw = np.concatenate(rows)
        exceeds = raw[:, fixed.DEMAND] >= self.by_case(1)
        gaps_required = np.repeat([required[batch.motion] for batch in self.batches], np.prod(self.shape))
        columns = (fixed.REACH, fixed.FORCE, fixed.COUNT, fixed.FIRST)
        reach, force, count, first = (raw[:, column] for column in columns)
        values = np.column_stack((reach, force, count, exceeds, first, gaps_required))
        values[raw[:, fixed.UNSTABLE] != 0.0] = nan
        steps = raw[:, fixed.TOUCHING].sum() / max(raw[:, fixed.COUNT].sum(), 1.0)
        return self._outcome(values, steps, nan, seconds, free_seconds)

    def _outcome(self, values: np.ndarray, steps: float, residual: float, seconds: float, free: float) -> Outcome:
        """An outcome from the processor times [s] of all cases and of all motions without contact."""
        return Outcome(values[:, None], steps, residual, seconds / self.size, free / len(self.motions))

    def general(self, solver: str, rtol: float) -> Outcome:
        """SciPy over one case of each of the first motions, the first gap with the largest yield force."""
        values, contacts, steps = np.full((self.size, 1, len(OUTPUTS)), nan), 0.0, 0.0
        durations: list[tuple[float, float]] = []
        width = len(self.gaps) * len(self.yield_forces)
        for number, batch in enumerate(self.batches):
            if len(durations) == self.most_general or batch.motion < len(durations):
                continue
            motion = self.motions[batch.motion]
            ground = motion.acceleration, motion.dt
            strength, start = float(self.yield_forces[-1]), process_time()
            interface = Interface(float(self.gaps[0]), batch.law, self.restitution, strength)
            run = solve_general(solver, self.pair, interface, ground, rtol)
            middle = process_time()
            # A gap of a kilometre stays open, and leaves SciPy's root search a finite number.
            alone = solve_general(solver, self.pair, Interface(1e3, batch.law, self.restitution), ground, rtol)
            durations.append((middle - start, process_time() - middle))
            contacts, steps = contacts + run.impact_count, steps + run.steps
            values[number * width + len(self.yield_forces) - 1, 0] = (
                run.peak_relative_displacement,
                run.peak_contact_force,
                run.impact_count,
                run.uncapped_force >= strength,
                run.first_impact_time,
                alone.peak_closing,
            )
        seconds, free_seconds = np.mean(durations, axis=0)
        return Outcome(values, steps / max(contacts, 1.0), nan, float(seconds), float(free_seconds))


def _event_only(study: Scene) -> str:
    """What only the event-driven solver has: effects, path-dependent and impulsive models, initial states, grounds."""
    paths = (
        name for name in study.grid.contact_models if is_path_dependent(known_law(name)) or is_instant(known_law(name))
    )
    begun = [INITIAL_STATES] if any(initial_state(*study.pair)) else []
    return ", ".join([*(effect.name for effect in study.effects), *paths, *begun, *own_grounds(study)])


def pair_bench(study: Scene, cases: int) -> PairBench:
    """The scene's cases: all motions and laws, and as many gaps and yield forces as fit, evenly spaced."""
    grid, motions = study.grid, driven_motions(study)
    gaps, forces = (
        [values[index] for index in indices]
        for values, indices in zip(
            (grid.gaps, grid.yield_forces), thinned_grid(study, cases, len(motions)), strict=True
        )
    )
    batches = [
        Batch(number, law_of(study, law), tuple(case_labels(driven.name, law, gaps, forces)))
        for number, driven in enumerate(motions)
        for law in grid.contact_models
    ]
    left, right = study.pair
    return PairBench(
        (chain_of(left), chain_of(right)),
        oscillators(left, right),
        tuple(driven.motion for driven in motions),
        tuple(batches),
        np.array(gaps),
        np.array(forces),
        study.restitution,
        study.supports,
        initial_state(left, right),
        _event_only(study),
    )
