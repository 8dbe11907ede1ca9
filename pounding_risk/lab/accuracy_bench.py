"""The cases of an accuracy study, and runs of them by every method: of a pair, and of a row by contact point."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import product
from math import inf, nan
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.order import evenly
from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.grid_job import peaks_under
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.row_job import RowJob
from pounding_risk.lab.accuracy_findings import OUTPUTS
from pounding_risk.lab.baselines import fixed_step
from pounding_risk.lab.baselines.matrices import RowMatrices, row_matrices
from pounding_risk.lab.baselines.row_fixed_step import solve_fixed_row
from pounding_risk.lab.baselines.solve_ivp import Contacts, solve_general
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.effects import acts_on_buildings
from pounding_risk.models.ground import SHARED
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.links import LINK
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.motions.levels import driven
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Scene
from pounding_risk.solver import counters as tally
from pounding_risk.solver.pair.api import free_response, initial_state, oscillators, workspace_for
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.cases import Limits
from pounding_risk.solver.row.outputs import closing, outputs
from pounding_risk.units import GAP, YIELD_FORCE, say

Array = NDArray[np.float64]
Timed = tuple[Array, float]  # answers, and the processor time that they took [s]
FIXED = {"Newmark average acceleration": "newmark", "central difference": "central_difference", "Runge-Kutta 4": "rk4"}
REFERENCE = 1e-12  # rtol of the event-driven reference
NAMES = tuple(OUTPUTS)[:5]  # outputs of a run; the gap required is that of the motion without contact
LAWS_OF_LINKS = "link_strength, link_slack, link_breaking_force, link_exponent or link_brace_stiffness"
OPEN = 1e3  # m: a gap that stays open, and leaves SciPy's root search a finite number


class Outcome(NamedTuple):
    """Answers, steps and times of one setting over all cases."""

    values: np.ndarray  # (cases, interfaces, OUTPUTS); NaN where a run failed, or was not made
    steps: float  # in contact, per contact
    residual: float  # largest share of energy that is unaccounted for; NaN where the method keeps no account
    seconds: float  # per case
    free_seconds: float  # per motion: a run without contact, for the gap required
    outputs: tuple[int, ...] = tuple(range(len(OUTPUTS)))  # those that the method has


class PointCase(NamedTuple):
    """One case by contact point."""

    motion: int  # its index in `Bench.motions`
    laws: Sequence[Any]
    rules: Sequence[Any]  # of restitution
    gaps: np.ndarray  # m
    yield_forces: np.ndarray  # N


class Driven(NamedTuple):
    """One motion of the grid in one polarity and amplitude, with its place on these axes and its name."""

    place: tuple[int, int, int]
    motion: Motion
    name: str


class Runs(NamedTuple):
    """Runs of some cases under one motion and one law."""

    values: Array  # (cases, interfaces, NAMES)
    contacts: float
    steps: float  # in contact, of all
    residual: float
    seconds: float  # of all


class Bench:
    """The cases that every setting runs: all motions and laws, gaps and yield forces evenly thinned."""

    most_general = 1  # runs by a method of SciPy
    has_one_force = False  # one yield force, whatever the grid
    chains: tuple[Chain, ...]  # the buildings, left to right
    points: tuple[Point, ...]  # the contact points, interface by interface

    def __init__(self, study: Scene, cases: int):
        self.study, self.driven = study, driven_motions(study)
        self.motions = tuple(each.motion for each in self.driven)
        grid = study.grid
        gaps, forces = thinned_grid(study, cases, len(self.driven))
        self.gaps, self.yield_forces = [grid.gaps[at] for at in gaps], [grid.yield_forces[at] for at in forces]
        self.limits = [self.limits_at(gap, force) for gap, force in product(gaps, forces)]  # of every batch
        self.batches = list(product(self.driven, range(len(grid.contact_models))))
        self.labels = [
            f"{each.name}, {grid.contact_models[law]}, {words}" for each, law in self.batches for words in self._words()
        ]

    def _words(self) -> Iterator[str]:
        """Gap and yield force of each case; of a row whose interfaces keep their own gaps that of one."""
        names, grid = self.study.interface_names, self.study.grid
        interface_name = self.study.gridded_interface or ("" if len(grid.gaps) > 1 else names[0])
        gap_of = f" of {interface_name}" if interface_name and len(names) > 1 else ""
        has_force = self.has_one_force or len(grid.yield_forces) > 1
        for gap, force in product(self.gaps, self.yield_forces):
            force_text = "no yielding" if force == inf else f"F_E {say(force, YIELD_FORCE)}"
            yield f"gap{gap_of} {say(gap, GAP)}" + (f", {force_text}" if has_force else "")

    # ------------------------------------------------------------------------------ as the solver of the scene has it
    def limits_at(self, gap: int, force: int) -> Limits:
        """Gaps and yield forces by contact point, from the places of both in the grid."""
        raise NotImplementedError

    def models(self, law: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """Laws and relations of restitution by contact point."""
        raise NotImplementedError

    def free_event(self, driven: Driven) -> Timed:
        """Gap required by interface [m] of the event-driven solver without contact, and its processor time [s]."""
        raise NotImplementedError

    def run_event(self, driven: Driven, law: int, limits: Sequence[Limits], rtol: float) -> Runs:
        """The event-driven solver over cases under one motion and one law, every case run."""
        raise NotImplementedError

    def run_fixed(self, method: str, driven: Driven, law: int, limits: Sequence[Limits], dt: float) -> Timed:
        """A fixed-step method over such cases, (cases, contact points, columns of `fixed_step`), and its time [s]."""
        raise NotImplementedError

    # ---------------------------------------------------------------------------------------------- what is common
    @property
    def event_only(self) -> str:
        """Effects, models and states of the scene that only the event-driven solver has; "" where every method does.

        P-Δ and soil are in the matrices of the buildings, which every method takes.
        """
        study, names = self.study, []
        if any(np.isfinite(chain.strength).any() for chain in self.chains):
            inelastic = ["inelastic_storeys"] if "inelastic_storeys" in dict(study.effects) else []
            names += inelastic + ["isolation"] * any(getattr(one, "isolators", None) for one in study.buildings)
        names += [LAWS_OF_LINKS] if any(link.law for link in study.links) else []
        names += ["floors that rotate"] if any(chain.twists for chain in self.chains) else []
        return ", ".join(filter(None, [*names, self.opensees_lacks]))

    @property
    def opensees_lacks(self) -> str:
        """As `event_only` of OpenSees, which has materials for storeys, isolators and links that yield."""
        study = self.study
        names = [effect.name for effect in study.effects if not acts_on_buildings(effect.name)]
        laws = {name: known_law(name) for name in study.model_names}
        names += [name for name, law in laws.items() if is_path_dependent(law) or is_instant(law)]
        building_facts = {
            "initial displacement or velocity": any(np.any(chain.initial) for chain in self.chains),
            "floors that move across the row": any(chain.moves_across for chain in self.chains),
            "mass_matrix": any(chain.inertia.size for chain in self.chains),
            "ground of a building's own": any(building.support != SHARED for building in study.buildings),
        }
        return ", ".join([*names, *(words for words, is_present in building_facts.items() if is_present)])

    @property
    def size(self) -> int:
        """Number of cases that every setting runs."""
        return len(self.batches) * len(self.limits)

    def point_cases(self) -> Iterator[PointCase]:
        """The cases in their order."""
        laws = range(len(self.study.grid.contact_models))
        for motion, law, limits in product(range(len(self.motions)), laws, self.limits):
            yield PointCase(motion, *self.models(law), limits.gaps, limits.yield_forces)

    @property
    def contact_points(self) -> dict[int, Point]:
        """The points at which buildings touch, by number; of a row with links there are others."""
        return {place: point for place, point in enumerate(self.points) if point.kind != LINK}

    @property
    def closed_at_rest(self) -> NDArray[np.bool_]:
        """True where the gap is closed at rest, (cases, interfaces)."""
        is_closed = [self.of_interfaces(np.minimum, limits.gaps) == 0.0 for limits in self.limits]
        return np.tile(np.array(is_closed), (len(self.batches), 1))

    def of_interfaces(self, gather: Any, at_points: Any) -> Array:
        """Values of the interfaces from those of their contact points, along the last axis."""
        contacts = list(self.contact_points)
        starts = np.flatnonzero(np.diff([point.interface for point in self.contact_points.values()], prepend=-1))
        return np.asarray(gather.reduceat(np.asarray(at_points)[..., contacts], starts, axis=-1))

    @cached_property
    def matrices(self) -> RowMatrices:
        """The buildings as SciPy's methods take them."""
        return row_matrices(self.chains, self.points, self.study.links)

    @cached_property
    def at_rest(self) -> RowMatrices:
        """The same where storeys may yield: what contacts join, and with which masses, does not depend on it."""
        return row_matrices(self.chains, self.points, self.study.links, before_yield=True)

    def warm_up(self) -> None:
        """Compile every kernel that is needed."""
        for each in self.driven:
            self.free_event(each._replace(motion=each.motion.first(3)))
        short = self.driven[0]._replace(motion=self.driven[0].motion.first(3))
        for law in range(len(self.study.grid.contact_models)):
            self.run_event(short, law, self.limits[:1], REFERENCE)
            for method in () if self.event_only else FIXED.values():
                self.run_fixed(method, short, law, self.limits[:1], inf)

    def event(self, rtol: float) -> Outcome:
        """The event-driven solver over all cases, every case run; its time has that of the motion without contact."""
        outcome = self._all(self.free_event, lambda each, law: self.run_event(each, law, self.limits, rtol))
        return outcome._replace(seconds=outcome.seconds + outcome.free_seconds * len(self.motions) / self.size)

    def fixed(self, method: str, dt: float) -> Outcome:
        """A fixed-step method over all cases in steps of about ``dt`` [s], a whole number of them a sample."""
        infinite = np.full(len(self.points), inf)

        def required(each: Driven) -> Timed:
            raw, seconds = self.run_fixed(method, each, 0, [Limits(infinite, infinite, infinite)], dt)
            gaps = np.where(raw[0, :, fixed_step.UNSTABLE] != 0.0, nan, raw[0, :, fixed_step.CLOSING])
            return self.of_interfaces(np.maximum, gaps), seconds

        def runs(each: Driven, law: int) -> Runs:
            raw, seconds = self.run_fixed(method, each, law, self.limits, dt)
            by_name: dict[str, Any] = {
                "peak_relative_displacement": raw[..., fixed_step.REACH],
                "peak_contact_force": raw[..., fixed_step.FORCE],
                "impact_count": raw[..., fixed_step.COUNT],
                "yield_exceedance": raw[..., fixed_step.DEMAND] >= [limits.yield_forces for limits in self.limits],
                "first_impact_time": raw[..., fixed_step.FIRST],
            }
            table = self._gathered(by_name)
            table[(raw[..., fixed_step.UNSTABLE] != 0.0).any(axis=1)] = nan
            count, touching = (float(raw[..., column].sum()) for column in (fixed_step.COUNT, fixed_step.TOUCHING))
            return Runs(table, count, touching, nan, seconds)

        return self._all(required, runs)

    def general(self, solver: str, rtol: float) -> Outcome:
        """SciPy over one case of each of the first motions, the first gap with the largest yield force."""
        table = np.full((self.size, self.points[-1].interface + 1, len(OUTPUTS)), nan)
        contacts, steps, durations = 0.0, 0.0, []
        index, (laws, rules) = len(self.yield_forces) - 1, self.models(0)
        case_contacts = Contacts(self.limits[index].gaps, laws, rules, self.limits[index].yield_forces)
        open_contacts = case_contacts._replace(gaps=np.full(len(laws), OPEN))
        for number, item in enumerate(self.driven[: self.most_general]):
            ground, begun = (item.motion.acceleration, item.motion.dt), process_time()
            run = solve_general(solver, self.matrices, case_contacts, ground, rtol)
            middle = process_time()
            free_run = solve_general(solver, self.matrices, open_contacts, ground, rtol)
            durations.append((middle - begun, process_time() - middle))
            contacts, steps = contacts + run.impact_count.sum(), steps + run.steps
            by_name = run._asdict() | {"yield_exceedance": run.uncapped_force >= case_contacts.yield_forces}
            start = number * self.size // len(self.motions)
            required = self.of_interfaces(np.maximum, free_run.peak_closing)
            table[start + index] = np.column_stack([self._gathered(by_name), required])
        seconds, free_seconds = np.mean(durations, axis=0)
        return Outcome(table, steps / max(contacts, 1.0), nan, float(seconds), float(free_seconds))

    def _gathered(self, points: dict[str, Array]) -> Array:
        """(..., interfaces, NAMES) from the outputs of contact points (..., contact points)."""
        gather = {"impact_count": np.add, "first_impact_time": np.fmin}
        columns = [self.of_interfaces(gather.get(name, np.maximum), points[name]) for name in NAMES]
        return np.stack(columns, axis=-1).astype(float)

    def _all(self, free: Callable[[Driven], Timed], runs: Callable[[Driven, int], Runs]) -> Outcome:
        """The outcome of all batches, each motion without contact once, before its runs."""
        required: dict[tuple[int, int, int], Array] = {}
        tables, contacts, steps, residual, seconds, free_seconds = [], 0.0, 0.0, nan, 0.0, 0.0
        for item, law in self.batches:
            if item.place not in required:
                required[item.place], own_seconds = free(item)
                free_seconds += own_seconds
            batch = runs(item, law)
            gaps = np.broadcast_to(required[item.place], batch.values.shape[:2])[..., None]
            failed = np.isnan(batch.values[..., :1])
            tables.append(np.concatenate([batch.values, np.where(failed, nan, gaps)], axis=-1))
            contacts, steps, seconds = contacts + batch.contacts, steps + batch.steps, seconds + batch.seconds
            residual = float(np.fmax(residual, batch.residual))
        times = seconds / self.size, free_seconds / len(self.motions)
        return Outcome(np.concatenate(tables), float(steps / max(contacts, 1.0)), residual, *times)


class PairBench(Bench):
    """Two single masses that meet mass to mass; every batch is one call of a kernel."""

    most_general = 3
    has_one_force = True

    def __init__(self, study: Scene, cases: int):
        left, right = study.pair
        self.chains, self.points = (chain_of(left), chain_of(right)), (Point(0, 1.0, 1.0, FLOOR, nan),)
        self.pair, self.initial = oscillators(left, right), initial_state(left, right)
        self.laws = [law_of(study, law) for law in study.grid.contact_models]
        self.free: dict[tuple[int, int, int], Any] = {}
        super().__init__(study, cases)

    def limits_at(self, gap: int, force: int) -> Limits:
        gaps, forces = np.array([self.study.grid.gaps[gap]]), np.array([self.study.grid.yield_forces[force]])
        return Limits(gaps, forces, forces)

    def models(self, law: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        return (self.laws[law],), (self.study.restitution,)

    def _grid(self, limits: Sequence[Limits]) -> tuple[Array, Array, Any]:
        """The gaps and yield forces of cases that are all of both, and restitution, as the kernels take them."""
        gaps, forces = ([float(limit[axis][0]) for limit in limits] for axis in (0, 1))
        return np.unique(gaps), np.unique(forces), self.study.restitution

    def free_event(self, driven: Driven) -> Timed:
        motion, begun = driven.motion, process_time()
        grounds = self.study.supports, self.initial, motion.own_grounds
        free = free_response(self.pair, motion.acceleration, motion.dt, *grounds)
        seconds = process_time() - begun
        self.free[driven.place] = free
        return np.array([max(float(free.high[:, 0].max()), 0.0)]), seconds

    def run_event(self, driven: Driven, law: int, limits: Sequence[Limits], rtol: float) -> Runs:
        grid, free = self._grid(limits), self.free[driven.place]
        shape = grid[0].size, grid[1].size
        raw, how = np.zeros((*shape, COLUMNS)), np.zeros(shape, dtype=np.int8)
        begun = process_time()
        solve_grid(self.pair, free, self.laws[law], grid, rtol, False, workspace_for(free, rtol), raw, how)
        seconds = process_time() - begun
        exceeds = raw[..., tally.DEMAND] >= grid[1]
        columns = (np.maximum(raw[..., HIGH], -raw[..., LOW]), raw[..., tally.PEAK_FORCE], raw[..., tally.COUNT])
        table = np.stack([*columns, exceeds, raw[..., tally.FIRST_TOUCH]], axis=-1)
        table[raw[..., tally.STATUS] != tally.COMPLETE] = nan
        energy = raw[..., tally.ENERGY]
        residual = np.abs(raw[..., tally.RESIDUAL]) / np.where(energy > 0.0, energy, 1.0)
        contacts, steps = raw[..., tally.COUNT].sum(), raw[..., tally.STEPS].sum()
        return Runs(table.reshape(-1, 1, len(NAMES)), contacts, steps, float(residual.max()), seconds)

    def run_fixed(self, method: str, driven: Driven, law: int, limits: Sequence[Limits], dt: float) -> Timed:
        grid, motion = self._grid(limits), driven.motion
        raw = np.zeros((grid[0].size, grid[1].size, fixed_step.COLUMNS))
        ground, begun = fixed_step.divided(motion.acceleration, motion.dt, dt), process_time()
        fixed_step.sweep_fixed(fixed_step.STEPPERS[method], self.pair, self.laws[law], grid, ground, raw)
        return raw.reshape(-1, 1, fixed_step.COLUMNS), process_time() - begun


class RowBench(Bench):
    """A row, with the outputs of each interface; every case is a call of its own."""

    def __init__(self, study: Scene, cases: int):
        self.job = RowJob(ScanInput(study, motions_of(study)))
        self.model = self.job.grid.model
        self.chains, self.points = self.model.chains, self.model.points
        super().__init__(study, cases)

    def limits_at(self, gap: int, force: int) -> Limits:
        limits = self.job.grid.limits(gap, force)
        return limits._replace(gaps=np.minimum(limits.gaps, OPEN))  # at links, which no method takes to be infinite

    def models(self, law: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        mechanics = self.job.grid.mechanics[law]
        return tuple(map(lowered, mechanics.laws)), tuple(map(lowered, mechanics.restitutions))

    def free_event(self, driven: Driven) -> Timed:
        motion, begun = driven.motion, process_time()
        ground = self.model.under(motion.drive, motion.own_grounds)
        free = rows.free_row(self.model.row(motion.dt, self.model.has_many(motion.own_grounds)), ground)
        seconds = process_time() - begun
        return np.maximum(closing(free, self.job.grid.frame)[1], 0.0), seconds

    def run_event(self, driven: Driven, law: int, limits: Sequence[Limits], rtol: float) -> Runs:
        cases, peaks = self.job.cases(driven.place, law, rtol), peaks_under(self.study, driven.motion)
        tables, steps, residual, seconds = [], 0, 0.0, 0.0
        for limit in limits:
            begun = process_time()
            run = cases.whole(limit)
            seconds += process_time() - begun
            by_name = outputs(run, limit.yield_forces, peaks, self.job.grid.frame)
            tables.append(np.column_stack([by_name[name] for name in NAMES]))
            tables[-1][run.status != tally.COMPLETE] = nan
            residual, steps = max(residual, float(np.fmax.reduce(by_name["energy_residual"]))), steps + run.steps
        contacts = float(np.nansum(np.array(tables)[..., NAMES.index("impact_count")]))
        return Runs(np.array(tables), contacts, steps, residual, seconds)

    def run_fixed(self, method: str, driven: Driven, law: int, limits: Sequence[Limits], dt: float) -> Timed:
        motion, (laws, rules), raw, seconds = driven.motion, self.models(law), [], 0.0
        ground = fixed_step.divided(motion.acceleration, motion.dt, dt)
        for each in limits:
            bounds, begun = (each.gaps, each.yield_forces), process_time()
            raw.append(solve_fixed_row(method, self.matrices, laws, rules, bounds, ground))
            seconds += process_time() - begun
        return np.array(raw), seconds


BENCHES: dict[str, type[Bench]] = {"pair": PairBench, "row": RowBench}  # by solver


def bench_of(study: Scene, cases: int) -> Bench:
    """The scene's cases with the solver that runs it: as many gaps and yield forces as fit, evenly spaced."""
    return BENCHES[job_kind(study).solver](study, cases)


def driven_motions(study: Scene) -> list[Driven]:
    """The motions of a study in each polarity and amplitude."""
    motions_driven = []
    axes = (motions_of(study), study.records.polarities, study.grid.amplitudes)
    for indices in np.ndindex(tuple(len(axis) for axis in axes)):
        motion, sense, level = (axis[index] for axis, index in zip(axes, indices, strict=True))
        level_text = "" if level is None else f" at {level.words}"
        place = indices[0], indices[1], indices[2]
        motions_driven.append(Driven(place, driven(motion, sense, level), f"{motion.name} {sense}{level_text}"))
    return motions_driven


def thinned_grid(study: Scene, cases: int, motions: int) -> tuple[list[int], list[int]]:
    """Indices of as many gaps and yield forces as fit into so many cases, evenly spaced; of one alone the scene's."""
    grid, interface_name = study.grid, study.gridded_interface
    interface = study.interfaces[study.interface_names.index(interface_name) if interface_name else 0]
    most = max(1, cases // (motions * len(grid.contact_models)))
    forces = _thinned(grid.yield_forces, max(1, int(most**0.5)) if len(grid.gaps) > 1 else most, interface.yield_force)
    return _thinned(grid.gaps, max(1, most // len(forces)), interface.gap), forces


def _thinned(levels: Sequence[float], most: int, level: float) -> list[int]:
    """Indices of at most so many of the values, first and last among them; of one alone the nearest to ``level``."""
    if most == 1 < len(levels):
        return [int(np.abs(np.nan_to_num(levels) - np.nan_to_num(level)).argmin())]
    return evenly(len(levels), most)
