"""Error against computing time of many methods and settings on a scene, with a converged run as the reference.

The event-driven solver from loose to tight tolerances; Newmark's average acceleration, central difference and
Runge-Kutta 4 with fixed steps; SciPy's DOP853 and Radau. Every compiled method runs all cases of a motion in one
compiled call, timed in processor time after it was compiled; the event-driven solver's time includes the free
response, which the cases of a motion share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import inf, nan
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.replacing import check_replaceable_scene
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.effects import wave_of
from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.motions.motion import driven
from pounding_risk.results.files import as_text, check_target, save, versions
from pounding_risk.results.labels import CONVENTIONS, described
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene, needs_pair
from pounding_risk.solver import counters as tally
from pounding_risk.solver.baselines import fixed_step as fixed
from pounding_risk.solver.baselines.solve_ivp import GaveUp, solve_general
from pounding_risk.solver.pair.api import Interface, free_response, oscillators
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW
from pounding_risk.solver.workspace import make_workspace
from pounding_risk.studies.accuracy_findings import (
    EVENT,
    FIRST,
    FORCE,
    GAP,
    LEVELS,
    OUTPUTS,
    REACH,
    errors_of,
    finding,
    times_to_reach,
)

FIXED = {
    "Newmark average acceleration": "newmark",
    "central difference": "central_difference",
    "Runge-Kutta 4": "rk4",
}
GENERAL = {"SciPy DOP853": "DOP853", "SciPy Radau": "Radau"}
RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 1e-4, 1e-5, 1e-6)  # s
GENERAL_RTOLS = {"SciPy DOP853": (1e-3, 1e-6, 1e-9, 1e-12), "SciPy Radau": (1e-3, 1e-6)}
REFERENCE = 1e-12  # rtol of the event-driven reference
REPEATS, BRIEF = 5, 1.0  # repetitions, and the seconds from which a call is timed once


class Setting(NamedTuple):
    """One method with one tolerance or step."""

    method: str
    value: float  # rtol, or the longest step [s]

    @property
    def words(self) -> str:
        """As a table has it: "event-driven, rtol 1e-06"."""
        return f"{self.method}, {'dt' if self.method in FIXED else 'rtol'} {self.value:.0e}"


class Batch(NamedTuple):
    """One law under one motion: every gap with every yield force of the bench."""

    motion: int  # its index in `Bench.motions`
    law: Any
    labels: tuple[str, ...]  # of its cases


@dataclass(frozen=True)
class Bench:
    """The cases that every setting runs."""

    pair: Any
    motions: tuple[Any, ...]  # in each polarity and amplitude
    batches: tuple[Batch, ...]
    gaps: np.ndarray
    yield_forces: np.ndarray
    restitution: Any
    wave: WavePassage | None
    event_only: str  # what of the scene only the event-driven solver models; "" where every method does

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of gaps and of yield forces."""
        return len(self.gaps), len(self.yield_forces)

    @property
    def size(self) -> int:
        """Number of cases that every setting runs."""
        return len(self.batches) * len(self.gaps) * len(self.yield_forces)

    @property
    def grid(self) -> tuple[np.ndarray, np.ndarray, Any]:
        """Gaps, yield forces and restitution, as the kernel takes them."""
        return self.gaps, self.yield_forces, self.restitution

    def by_case(self, axis: int) -> np.ndarray:
        """The gap (axis 0) or yield force (axis 1) of every case."""
        values = np.meshgrid(self.gaps, self.yield_forces, indexing="ij")[axis]
        return np.tile(values.ravel(), len(self.batches))


class Outcome(NamedTuple):
    """Answers, steps and times of one setting over all cases."""

    values: np.ndarray  # (cases, OUTPUTS)
    steps: float  # in contact, per contact
    residual: float  # largest share of energy that is unaccounted for; NaN where the method keeps no account
    seconds: float  # per case
    free_seconds: float  # per motion: a run without contact, for the gap required


def accuracy(
    study: Scene | str | Path,
    out: str | Path | None = None,
    *,
    cases: int = 24,
    budget: float = 20.0,
    scipy: bool = True,
    new: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Error and computing time of many settings of many methods on the cases of a scene.

    The event-driven solver from loose to tight tolerances, three fixed-step methods and two of SciPy's are set against
    the event-driven solver at rtol 1e-12. A setting that would take more than ``budget`` for one pass, or gives up, is
    left out and named. Effects, contact models that remember their path and impulsive models are known to the
    event-driven solver alone: then only its own tolerances are compared.

    Parameters
    ----------
    study : Scene or path
        A scene of a pair, or the path of its TOML file.
    out : path, optional
        File for the dataset, ``.nc``.
    cases : int
        Most cases to run, about; the grid is thinned evenly along gaps and yield forces.
    budget : float
        Longest processor time of one pass of a setting over all cases [s].
    scipy : bool
        Run SciPy's methods, on the first few cases only.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of settings done and of all settings.

    Returns
    -------
    xarray.Dataset
        Along setting, case, output and level: ``error`` (relative for amounts and times; of counts the difference over
        the count; of the yield exceedance 0 or 1), ``value``, ``reference``, ``time`` [s per run],
        ``steps_per_contact``, ``energy_residual``, and ``time_to_reach`` [s] an error level. The attribute ``finding``
        names the cheapest setting whose printed digits no longer change.

    Raises
    ------
    PoundingError
        As `scan`, before the first run; also, unless ``new``, if ``out`` holds other results.
    """
    target = None if out is None else check_target(out)
    study = needs_pair(as_scene(study), "accuracy")
    if target is not None:
        check_replaceable_scene(target, "accuracy", study, new)
    bench = bench_of(study, cases)
    left_out = [f"fixed steps and SciPy: they know no {bench.event_only}"] if bench.event_only else []
    compile_time = warm_up(bench)
    reference = run_event(bench, REFERENCE).values
    outcomes = run_settings(bench, budget, scipy, left_out, progress or (lambda done, total: None))
    dataset = _dataset(study, bench, outcomes, reference)
    dataset.attrs |= {
        "finding": finding(dataset),
        "left_out": as_text(left_out),
        "reference": _reference_words(dataset, reference),
        "compile_seconds": compile_time,
    }
    if target is not None:
        save(dataset, target)
    return dataset


def _event_only(study: Scene) -> str:
    """Effects, path-dependent and impulsive models of the scene, which only the event-driven solver has."""
    paths = (
        name for name in study.grid.contact_models if is_path_dependent(known_law(name)) or is_instant(known_law(name))
    )
    return ", ".join([*(effect.name for effect in study.effects), *paths])


def bench_of(study: Scene, cases: int) -> Bench:
    """The scene's cases: all motions and laws, and as many gaps and yield forces as fit, evenly spaced."""
    grid = study.grid
    senses, amplitudes = study.records.polarities, grid.pgas
    motions, names = [], []
    for motion, sense, pga in product(motions_of(study), senses, amplitudes):
        motions.append(driven(motion, sense, pga))
        names.append(f"{motion.name} {sense}" + ("" if pga is None else f" {pga:.4g} m/s2"))
    most = max(1, cases // (len(motions) * len(grid.contact_models)))
    strengths = _thinned(grid.yield_forces, max(1, int(most**0.5)) if len(grid.gaps) > 1 else most)
    gaps = _thinned(grid.gaps, max(1, most // len(strengths)))
    batches = []
    for (number, name), law in product(enumerate(names), grid.contact_models):
        labels = (f"{name}, {law}, gap {gap:.4g} m, F_E {force:.4g} N" for gap, force in product(gaps, strengths))
        batches.append(Batch(number, lowered(law_of(study, law)), tuple(labels)))
    pair = oscillators(*study.pair)
    levels = np.array(gaps), np.array(strengths)
    return Bench(
        pair, tuple(motions), tuple(batches), *levels, study.restitution, wave_of(study.effects), _event_only(study)
    )


def _thinned(values: tuple[float, ...], most: int) -> tuple[float, ...]:
    """At most so many of the values, first and last among them where there is room."""
    if len(values) <= most:
        return values
    indices = np.unique(np.linspace(0, len(values) - 1, max(most, 2)).round().astype(int))
    return tuple(values[index] for index in (indices if most > 1 else indices[-1:]))


def run_event(bench: Bench, rtol: float) -> Outcome:
    """The event-driven solver over all cases, every case run."""
    raws, required, free_seconds, seconds = [], [], 0.0, 0.0
    frees: dict[int, Any] = {}
    for batch in bench.batches:
        motion = bench.motions[batch.motion]
        out, how = np.zeros((*bench.shape, COLUMNS)), np.zeros(bench.shape, dtype=np.int8)
        start = process_time()
        if batch.motion not in frees:
            frees[batch.motion] = free_response(bench.pair, motion.acceleration, motion.dt, bench.wave)
            free_seconds += process_time() - start
        free = frees[batch.motion]
        solve_grid(bench.pair, free, batch.law, bench.grid, rtol, False, make_workspace(rtol), out, how)
        seconds += process_time() - start
        raws.append(out.reshape(-1, COLUMNS))
        required += [max(float(free.high[:, 0].max()), 0.0)] * how.size
    raw = np.concatenate(raws)
    columns = (np.maximum(raw[:, HIGH], -raw[:, LOW]), raw[:, tally.PEAK_FORCE], raw[:, tally.COUNT])
    exceeds = raw[:, tally.DEMAND] >= bench.by_case(1)
    values = np.column_stack([*columns, exceeds, raw[:, tally.FIRST_TOUCH], required])
    values[raw[:, tally.STATUS] != tally.COMPLETE] = nan
    residual = np.abs(raw[:, tally.RESIDUAL]) / np.where(raw[:, tally.ENERGY] > 0.0, raw[:, tally.ENERGY], 1.0)
    steps = raw[:, tally.STEPS].sum() / max(raw[:, tally.COUNT].sum(), 1.0)
    return Outcome(values, steps, float(residual.max()), seconds / bench.size, free_seconds / len(bench.motions))


def run_fixed(bench: Bench, method: str, dt: float) -> Outcome:
    """A fixed-step method over all cases in steps of about ``dt`` [s], a whole number of them a sample."""
    stepper, rows, seconds, free_seconds, required = fixed.STEPPERS[method], [], 0.0, 0.0, []
    grounds = [fixed.divided(motion.acceleration, motion.dt, dt) for motion in bench.motions]
    for batch in bench.batches:
        out = np.zeros((*bench.shape, fixed.COLUMNS))
        start = process_time()
        fixed.sweep_fixed(stepper, bench.pair, batch.law, bench.grid, grounds[batch.motion], out)
        seconds += process_time() - start
        rows.append(out.reshape(-1, fixed.COLUMNS))
    alone = (np.array([inf]), np.array([inf]), bench.restitution)
    for ground in grounds:
        out = np.zeros((1, 1, fixed.COLUMNS))
        start = process_time()
        fixed.sweep_fixed(stepper, bench.pair, bench.batches[0].law, alone, ground, out)
        free_seconds += process_time() - start
        required.append(nan if out[0, 0, fixed.UNSTABLE] else out[0, 0, fixed.CLOSING])
    raw = np.concatenate(rows)
    exceeds = raw[:, fixed.DEMAND] >= bench.by_case(1)
    gaps_required = np.repeat([required[batch.motion] for batch in bench.batches], np.prod(bench.shape))
    columns = (fixed.REACH, fixed.FORCE, fixed.COUNT, fixed.FIRST)
    reach, force, count, first = (raw[:, column] for column in columns)
    values = np.column_stack((reach, force, count, exceeds, first, gaps_required))
    values[raw[:, fixed.UNSTABLE] != 0.0] = nan
    steps = raw[:, fixed.TOUCHING].sum() / max(raw[:, fixed.COUNT].sum(), 1.0)
    return Outcome(values, steps, nan, seconds / bench.size, free_seconds / len(bench.motions))


def run_general(bench: Bench, solver: str, rtol: float, most: int) -> Outcome:
    """SciPy over one case of each of the first motions, the first gap with the largest yield force; others are NaN."""
    values, contacts, steps = np.full((bench.size, len(OUTPUTS)), nan), 0.0, 0.0
    durations: list[tuple[float, float]] = []
    width = len(bench.gaps) * len(bench.yield_forces)
    for number, batch in enumerate(bench.batches):
        if len(durations) == most or batch.motion < len(durations):
            continue
        motion = bench.motions[batch.motion]
        ground = motion.acceleration, motion.dt
        strength, start = float(bench.yield_forces[-1]), process_time()
        interface = Interface(float(bench.gaps[0]), batch.law, bench.restitution, strength)
        run = solve_general(solver, bench.pair, interface, ground, rtol)
        middle = process_time()
        # A gap of a kilometre stays open, and leaves SciPy's root search a finite number.
        alone = solve_general(solver, bench.pair, Interface(1e3, batch.law, bench.restitution), ground, rtol)
        durations.append((middle - start, process_time() - middle))
        contacts, steps = contacts + run.impact_count, steps + run.steps
        values[number * width + len(bench.yield_forces) - 1] = (
            run.peak_relative_displacement,
            run.peak_contact_force,
            run.impact_count,
            run.uncapped_force >= strength,
            run.first_impact_time,
            alone.peak_closing,
        )
    seconds, free_seconds = np.mean(durations, axis=0)
    return Outcome(values, steps / max(contacts, 1.0), nan, float(seconds), float(free_seconds))


def warm_up(bench: Bench) -> float:
    """Compile every kernel that is needed; returns the seconds it took."""
    start = process_time()
    short = tuple(replace(motion, acceleration=motion.acceleration[:3]) for motion in bench.motions)
    for batch in {type(batch.law): batch for batch in bench.batches}.values():
        small = replace(bench, motions=short, batches=(batch,))
        run_event(small, REFERENCE)
        for method in () if bench.event_only else FIXED.values():
            run_fixed(small, method, inf)
    return process_time() - start


def run_settings(
    bench: Bench, budget: float, scipy: bool, left_out: list[str], progress: Callable[[int, int], None]
) -> dict[Setting, Outcome]:
    """Every setting that keeps to the budget; quick ones several times in turns, of which the median counts."""
    runs = dict(_settings(bench, scipy))
    outcomes: dict[Setting, list[Outcome]] = {}
    pace: dict[str, float] = {}  # seconds of a pass times the step, by fixed-step method
    for number, (setting, call) in enumerate(runs.items()):
        progress(number, len(runs))
        expected = pace.get(setting.method, 0.0) / setting.value
        if setting.method in FIXED and expected > budget:
            left_out.append(f"{setting.words}: would take about {expected:.0f} s, more than the budget of {budget:g} s")
            continue
        start = process_time()
        try:
            outcomes[setting] = [call()]
        except GaveUp as reason:
            left_out.append(f"{setting.words}: {reason}")
            continue
        pace[setting.method] = (process_time() - start) * setting.value
    brief = [s for s, all_of in outcomes.items() if all_of[0].seconds * bench.size < BRIEF and s.method not in GENERAL]
    for _ in range(REPEATS - 1):
        for setting in brief:
            outcomes[setting].append(runs[setting]())
    progress(len(runs), len(runs))
    return {setting: _middle(repeated) for setting, repeated in outcomes.items()}


def _settings(bench: Bench, scipy: bool) -> Iterator[tuple[Setting, Callable[[], Outcome]]]:
    for rtol in RTOLS:
        yield Setting(EVENT, rtol), partial(run_event, bench, rtol)
    if bench.event_only:
        return
    longest = max(motion.dt for motion in bench.motions)
    for (name, method), dt in product(FIXED.items(), STEPS):
        # A step above the longest sample is that sample again.
        if dt <= longest * (1.0 + 1e-9):
            yield Setting(name, dt), partial(run_fixed, bench, method, dt)
    most = min(3, len(bench.motions))
    for name, method in GENERAL.items() if scipy else ():
        for rtol in GENERAL_RTOLS[name]:
            yield Setting(name, rtol), partial(run_general, bench, method, rtol, most)


def _middle(outcomes: list[Outcome]) -> Outcome:
    times = {key: median(getattr(outcome, key) for outcome in outcomes) for key in ("seconds", "free_seconds")}
    return outcomes[0]._replace(**times)


def _dataset(study: Scene, bench: Bench, by_setting: dict[Setting, Outcome], reference: np.ndarray) -> xr.Dataset:
    settings, outcomes = list(by_setting), list(by_setting.values())
    errors = np.stack([errors_of(outcome.values, reference.copy()) for outcome in outcomes])
    for number, setting in enumerate(settings):
        # SciPy runs some cases only: what was not run has no error.
        if setting.method in GENERAL:
            errors[number][np.isnan(outcomes[number].values[:, REACH])] = nan
    # Where the gap is closed at rest, the moment of the first touch is rounding; no method can have it right.
    errors[:, bench.by_case(0) == 0.0, FIRST] = nan
    times = np.array([[o.seconds] * GAP + [o.free_seconds] for o in outcomes])
    labels = [label for batch in bench.batches for label in batch.labels]
    coords: dict[str, Any] = {
        "setting": [setting.words for setting in settings],
        "method": ("setting", [setting.method for setting in settings]),
        "parameter": ("setting", [setting.value for setting in settings], {"long_name": "rtol, or longest step [s]"}),
        "case": labels,
        "output": list(OUTPUTS),
        "level": ("level", list(LEVELS), {"long_name": "error level"}),
        "solver": list(dict.fromkeys(setting.method for setting in settings)),
    }
    variables = {
        "error": (("setting", "case", "output"), errors, described("1", "error against the reference")),
        "value": (("setting", "case", "output"), np.stack([o.values for o in outcomes]), {"long_name": "answer"}),
        "reference": (("case", "output"), reference, {"long_name": f"event-driven solver at rtol {REFERENCE:g}"}),
        "time": (("setting", "output"), times, described("s", "processor time per run")),
        "steps_per_contact": ("setting", [o.steps for o in outcomes], described("1", "steps per contact")),
        "energy_residual": (
            "setting",
            [o.residual for o in outcomes],
            described("1", "largest energy residual of a run; NaN where the method keeps no account"),
        ),
    }
    dataset = xr.Dataset(variables, coords=coords)
    reach = np.array([[times_to_reach(dataset, name, output) for output in OUTPUTS] for name in coords["solver"]])
    words = "time per run at which every case is within the error level; NaN where that is not reached"
    dataset["time_to_reach"] = (("solver", "output", "level"), reach, described("s", words))
    return dataset.assign_attrs(
        Conventions=CONVENTIONS,
        title=study.name,
        source="pounding_risk: accuracy and time of its solvers",
        scene=study.text or study.to_toml(),
        scene_resolved=study.to_toml(),
        versions=as_text(versions()),
        **created("pounding_risk.accuracy"),
    )


def _reference_words(dataset: xr.Dataset, reference: np.ndarray) -> str:
    words = f"event-driven solver at rtol {REFERENCE:g}"
    for rtol in GENERAL_RTOLS["SciPy DOP853"][::-1]:
        name = Setting("SciPy DOP853", rtol).words
        if name in dataset["setting"].values:
            errors = dataset["error"].sel(setting=name).values
            run = ~np.isnan(errors[:, REACH])
            apart = max(errors[run, REACH].max(), errors[run, FORCE].max())
            return (
                f"{words}; {name} differs from it by {apart:.0e} at most in displacement and force ({run.sum()} runs)"
            )
    return words
