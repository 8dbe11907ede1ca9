"""Error against computing time of many methods and settings on a scene, with a converged run as the reference.

The event-driven solver from loose to tight tolerances; Newmark's average acceleration, central difference and
Runge-Kutta 4 with fixed steps; SciPy's DOP853 and Radau. Every compiled method is timed in processor time after it was
compiled; the event-driven solver's time includes the free response, which the cases of a motion share. A case's error
is that of the interface where it is largest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from math import inf, nan
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.ensemble.replacing import check_replaceable_scene
from pounding_risk.errors import PoundingError
from pounding_risk.lab import accuracy_findings as findings
from pounding_risk.lab.accuracy_bench import FIXED, REFERENCE, Bench, Outcome, bench_of
from pounding_risk.lab.accuracy_findings import COUNT, EVENT, FIRST, FORCE, GAP, LEVELS, OUTPUTS, REACH
from pounding_risk.lab.accuracy_opensees import hindrance, opensees_outcome
from pounding_risk.lab.baselines.solve_ivp import GaveUp
from pounding_risk.render.sheet import computing_time
from pounding_risk.results.attributes import as_text, versions
from pounding_risk.results.files import check_target
from pounding_risk.results.labels import CONVENTIONS, described
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.variants import check_one_scene
from pounding_risk.studies.study import saved
from pounding_risk.units import Quantity, si

CHECK = "SciPy DOP853"  # confirms the reference
GENERAL = {CHECK: "DOP853", "SciPy Radau": "Radau"}
OPENSEES = "OpenSees"
STEPPED = (*FIXED, OPENSEES)  # methods whose settings are steps
RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 1e-4, 1e-5, 1e-6)  # s
OPENSEES_STEPS = (1e-2, 1e-3, 1e-4)  # s
GENERAL_RTOLS = {CHECK: (1e-3, 1e-6, 1e-9, 1e-12), "SciPy Radau": (1e-3, 1e-6)}
ANSWER = ("case", "interface", "output")
AT_CAP = 1e-9  # share of F_E within which a peak force is one that the law caps
VISIBLE, NEARER = 1e-6, 0.1  # a difference of SciPy's that needs a cause; one that is nearer than another
REPEATS, BRIEF = 5, 1.0  # repetitions, and the seconds from which a call is timed once
FAR = 10.0  # times of the tightest event-driven setting from which a method that is less accurate is refined no further


class Setting(NamedTuple):
    """One method with one tolerance or step."""

    method: str
    value: float  # rtol, or the longest step [s]

    @property
    def words(self) -> str:
        """As a table has it: "event-driven, rtol 1e-06"."""
        return f"{self.method}, {'dt' if self.method in STEPPED else 'rtol'} {self.value:.0e}"


LEAST_ONE = Quantity("1", 1.0, inf, "number of cases", open_high=True, example="24")
BUDGET = Quantity("1", 0.0, inf, "number of seconds", open_low=True, example="20")
TIGHTEST = Setting(EVENT, RTOLS[-1])
CONFIRMING = Setting(CHECK, GENERAL_RTOLS[CHECK][-1])  # it is always run


def accuracy(
    study: Scene | str | Path,
    out: str | Path | None = None,
    *,
    cases: int = 24,
    budget: float = 20.0,
    scipy: bool = True,
    new: bool = False,
    progress: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Error and computing time of each setting of each method.

    The event-driven solver from loose to tight tolerances, three fixed-step methods, OpenSees where openseespy is
    installed and has the scene's law, and two methods of SciPy are set against the event-driven solver at rtol 1e-12. A
    setting that would take more than ``budget`` for one pass, or gives up, is left out and named. A method is refined
    no further once it takes ten times as long as the tightest event-driven setting, with no smaller error in any
    output; SciPy's DOP853 at its tightest tolerance, which confirms the reference, is always run. Methods that do not
    know what the scene has, such as an effect on the contact, an impulsive model, storeys that yield (which OpenSees
    knows) or a mass matrix, are not run: the attribute ``left_out`` says which and why.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    out : path, optional
        File for the dataset, ``.nc``.
    cases : int
        Most cases to run, but one of every motion and contact model at least; the grid is thinned evenly along gaps
        and yield forces, to the scene's own last.
    budget : float
        Longest processor time of one pass of a setting over all cases [s].
    scipy : bool
        Run SciPy's methods, on the first few cases only.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of settings done and of all settings.
    say : callable, optional
        Takes a line about the time of all this, after the event-driven settings.

    Returns
    -------
    xarray.Dataset
        Along setting, case, output and level: ``error`` (relative for amounts and times; of counts the difference over
        the count; of the yield exceedance 0 or 1; the largest of the interfaces), ``value`` and ``reference`` of every
        interface, ``time`` [s per run], ``steps_per_contact``, ``energy_residual``, and ``time_to_reach`` [s] an error
        level. The attribute ``finding`` names the cheapest setting whose printed digits no longer change.

    Raises
    ------
    PoundingError
        As `scan`, before the first run; also, unless ``new``, if ``out`` holds other results.
    """
    target = None if out is None else check_target(out)
    si(cases, LEAST_ONE, "accuracy: cases")
    si(budget, BUDGET, "accuracy: budget")
    study = as_scene(study)
    check_one_scene(study, "accuracy")
    if target is not None:
        check_replaceable_scene(target, "accuracy", study, new)
    bench = bench_of(study, cases)
    left_out = [f"fixed steps and SciPy: they know no {bench.event_only}"] if bench.event_only else []
    optional = set(GENERAL) if scipy else set()
    if reason := hindrance(bench):
        left_out.append(f"{OPENSEES}: {reason}")
    else:
        optional.add(OPENSEES)
    start = process_time()
    bench.warm_up()
    compile_time = process_time() - start
    reference = bench.event(REFERENCE).values
    if capped_count := int(_capped(bench, reference).any(axis=1).sum()):
        words = "the law caps it at F_E, which every method finds"
        left_out.append(f"peak contact force of {capped_count} of {bench.size} cases: {words}")
    if collapsed := int(np.isnan(reference[..., REACH]).any(axis=1).sum()):
        left_out.append(f"{collapsed} of {bench.size} cases: the reference ends before the record, as storeys collapse")
    outcomes = run_settings(
        bench, reference, budget, optional, left_out, progress or (lambda done, total: None), say or (lambda text: None)
    )
    dataset = _dataset(study, bench, outcomes, reference)
    facts = {"left_out": as_text(left_out), "reference": _reference_words(dataset), "compile_seconds": compile_time}
    return saved(dataset, "accuracy", target, finding=findings.finding(dataset), **facts)


def run_settings(
    bench: Bench,
    reference: np.ndarray,
    budget: float,
    optional: set[str],
    left_out: list[str],
    progress: Callable[[int, int], None],
    say: Callable[[str], None],
) -> dict[Setting, Outcome]:
    """Every setting that keeps to the budget, until its method is far behind; quick ones several times: the median."""
    runs = dict(_settings(bench, optional))
    outcomes: dict[Setting, list[Outcome]] = {}
    last: dict[str, tuple[Setting, float]] = {}  # of each method, with the seconds of a pass
    begun = process_time()
    for number, (setting, call) in enumerate(runs.items()):
        progress(number, len(runs))
        previous, seconds = last.get(setting.method, (setting, 0.0))
        if number == len(RTOLS):
            say(_time_words(bench, process_time() - begun, budget, len(runs) - number, bool(optional & set(GENERAL))))
        expected = seconds * (previous.value / setting.value if setting.method in STEPPED else 1.0)
        if expected > budget and setting != CONFIRMING:
            time = computing_time(expected)["text"]
            left_out.append(f"{setting.words}: would take about {time}, more than the budget of {budget:g} s")
            continue
        if previous in outcomes and (cause := _far_behind(bench, reference, outcomes, previous)):
            left_out.append(f"{setting.words}: not run: {cause}")
            continue
        start = process_time()
        try:
            outcomes[setting] = [call()]
        except (GaveUp, PoundingError) as reason:
            left_out.append(f"{setting.words}: {reason}")
            continue
        last[setting.method] = setting, process_time() - start
    longest = FAR * outcomes[TIGHTEST][0].seconds if TIGHTEST in outcomes else inf
    quick_settings = [
        setting
        for setting, (first,) in outcomes.items()
        if first.seconds * bench.size < BRIEF and first.seconds <= longest and setting.method not in GENERAL
    ]
    for _ in range(REPEATS - 1):
        for setting in quick_settings:
            outcomes[setting].append(runs[setting]())
    progress(len(runs), len(runs))
    medians = {}
    for setting, repeats in outcomes.items():
        times = {key: median(getattr(outcome, key) for outcome in repeats) for key in ("seconds", "free_seconds")}
        medians[setting] = repeats[0]._replace(**times)
    return medians


def _time_words(bench: Bench, seconds: float, budget: float, others: int, has_scipy: bool) -> str:
    """What the other methods may take, stated before they run."""
    words = f"{bench.size} cases: {seconds:.2g} s for {len(RTOLS)} tolerances of the event-driven solver"
    if bench.event_only:
        return words
    words += (
        f"; at most {budget:g} s for each of {others} settings of other methods, {others * budget / 60.0:.2g} min of "
        "processor time in all, less with a smaller --budget or fewer --cases"
    )
    return f"{words}, and what SciPy's first and tightest take" if has_scipy else words


def _far_behind(bench: Bench, reference: np.ndarray, outcomes: dict[Setting, list[Outcome]], setting: Setting) -> str:
    """Why a method needs no finer setting than this one; "" where it does, or where it confirms the reference."""
    ratio = outcomes[setting][0].seconds / outcomes[TIGHTEST][0].seconds if TIGHTEST in outcomes else 0.0
    if setting.method in (EVENT, CHECK) or ratio < FAR:
        return ""
    errors = (_errors(bench, item, outcomes[item][0], reference) for item in (setting, TIGHTEST))
    largest, least = (np.fmax.reduce(case_errors, axis=0) for case_errors in errors)
    if (largest < least).any():  # false for NaN, an output that the method does not have
        return ""
    return f"{setting.words} takes {ratio:.0f} times as long as {TIGHTEST.words}, with no smaller error in any output"


def _settings(bench: Bench, optional: set[str]) -> Iterator[tuple[Setting, Callable[[], Outcome]]]:
    for rtol in RTOLS:
        yield Setting(EVENT, rtol), partial(bench.event, rtol)
    longest = max(motion.dt for motion in bench.motions)
    for (name, method), dt in () if bench.event_only else product(FIXED.items(), STEPS):
        # A step above the longest sample is that sample again.
        if dt <= longest * (1.0 + 1e-9):
            yield Setting(name, dt), partial(bench.fixed, method, dt)
    for dt in OPENSEES_STEPS if OPENSEES in optional else ():
        if dt <= longest * (1.0 + 1e-9):
            yield Setting(OPENSEES, dt), partial(opensees_outcome, bench, dt)
    for name, method in () if bench.event_only else GENERAL.items():
        for rtol in GENERAL_RTOLS[name] if name in optional else ():
            yield Setting(name, rtol), partial(bench.general, method, rtol)


def _dataset(study: Scene, bench: Bench, by_setting: dict[Setting, Outcome], reference: np.ndarray) -> xr.Dataset:
    settings, outcomes = list(by_setting), list(by_setting.values())
    errors = np.stack([_errors(bench, item, outcome, reference) for item, outcome in by_setting.items()])
    times = np.array([[o.seconds] * GAP + [o.free_seconds] for o in outcomes])
    coords: dict[str, Any] = {
        "setting": [setting.words for setting in settings],
        "method": ("setting", [setting.method for setting in settings]),
        "parameter": ("setting", [setting.value for setting in settings], {"long_name": "rtol, or longest step [s]"}),
        "case": list(bench.labels),
        "interface": list(study.interface_names),
        "output": list(OUTPUTS),
        "level": ("level", list(LEVELS), {"long_name": "error level"}),
        "solver": list(dict.fromkeys(setting.method for setting in settings)),
    }
    error_attrs = described("1", "error against the reference, the largest of the interfaces")
    residual_attrs = described("1", "largest energy residual of a run; NaN where the method keeps no account")
    variables = {
        "error": (("setting", "case", "output"), errors, error_attrs),
        "value": (("setting", *ANSWER), np.stack([o.values for o in outcomes]), {"long_name": "answer"}),
        "reference": (ANSWER, reference, {"long_name": f"event-driven solver at rtol {REFERENCE:g}"}),
        "time": (("setting", "output"), times, described("s", "processor time per run")),
        "steps_per_contact": ("setting", [o.steps for o in outcomes], described("1", "steps per contact")),
        "energy_residual": ("setting", [o.residual for o in outcomes], residual_attrs),
    }
    dataset = xr.Dataset(variables, coords=coords)
    reach = [[findings.times_to_reach(dataset, name, output) for output in OUTPUTS] for name in coords["solver"]]
    words = "time per run at which every case is within the error level; NaN where that is not reached"
    dataset["time_to_reach"] = (("solver", "output", "level"), np.array(reach), described("s", words))
    return dataset.assign_attrs(
        Conventions=CONVENTIONS,
        title=study.name,
        source="pounding_risk: accuracy and time of its solvers",
        scene=study.text or study.to_toml(),
        scene_resolved=study.to_toml(),
        versions=as_text(versions()),
        unused_keys=as_text(unused_keys(study)),
    )


def _errors(bench: Bench, setting: Setting, outcome: Outcome, reference: np.ndarray) -> np.ndarray:
    """Errors of a setting (cases, outputs): of each case the largest of its interfaces; NaN where there is none."""
    errors = findings.errors_of(outcome.values, reference.copy())
    if setting.method in GENERAL:
        # SciPy runs some cases only: what was not run has no error.
        errors[np.isnan(outcome.values[..., REACH])] = nan
    errors[..., [output for output in range(len(OUTPUTS)) if output not in outcome.outputs]] = nan
    # Where the gap is closed at rest, the moment of the first touch is rounding; no method can have it right.
    errors[bench.closed_at_rest, FIRST] = nan
    errors[_capped(bench, reference), FORCE] = nan
    errors[np.isnan(reference[..., REACH])] = nan
    return np.asarray(np.fmax.reduce(errors, axis=1))


def _capped(bench: Bench, reference: np.ndarray) -> np.ndarray:
    """True where the peak force is a yield force, (cases, interfaces): it is so by any method, however inaccurate."""
    pairs = zip(reference[..., FORCE, None], (case.yield_forces for case in bench.point_cases()), strict=True)
    return np.array([np.isclose(forces, own_forces, rtol=AT_CAP, atol=0.0).any(axis=1) for forces, own_forces in pairs])


def _reference_words(dataset: xr.Dataset) -> str:
    """The reference, and how far SciPy is from it at the tightest tolerance and, where that is nearer, at another."""
    words = f"event-driven solver at rtol {REFERENCE:g}"
    sentences = []
    for rtol in GENERAL_RTOLS[CHECK][::-1]:
        name = Setting(CHECK, rtol).words
        if name in dataset["setting"].values:
            errors = dataset["error"].sel(setting=name).values
            is_run = ~np.isnan(errors[:, REACH])
            counts = int((errors[is_run, COUNT] > 0.0).sum())
            sentences.append((float(np.nanmax(errors[is_run][:, [REACH, FORCE]])), name, int(is_run.sum()), counts))
    if not sentences:
        return words
    difference, name, runs, counts = sentences[0]
    words += f"; {name} differs from it by {difference:.0e} at most in displacement and force ({runs} runs)"
    nearest = min(sentences)
    if nearest[0] < NEARER * difference and difference > VISIBLE:
        reason = f"it counts other impacts in {counts} of them" if counts else "with the same impacts"
        words += f": {reason}, and {nearest[1]} differs by {nearest[0]:.0e}, so that the former is SciPy's own error"
    return words
