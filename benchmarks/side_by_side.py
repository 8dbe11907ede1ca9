"""This package beside OpenSees, SciPy and a fixed-step kernel at equal error: ``python benchmarks/side_by_side.py``.

Same scenes (`pair_scenes.py`), same constant e, one run each, processor time. Every method has a ladder of settings;
each rung gives an error and a time, and two methods are compared at the same error, read off between their rungs.
Errors are relative, against this package at rtol 1e-12, which is held against SciPy at rtol 1e-12. Methods take turns,
repetition by repetition, so that a busy machine slows all of them. A machine without OpenSees leaves it out and says
so. ``--figure FILE`` draws error against time; ``--quick`` does everything small.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from math import exp, log
from typing import Any, NamedTuple

import numpy as np
from opensees_pair import Answer, bilinear_material, solve_opensees
from pair_scenes import Scene, all_scenes, moderate_scenes
from rk4 import solve_rk4
from scipy_pair import solve_scipy
from throughput import in_time, range_of

from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import STYLES, blank, title, write
from pounding_risk.lab.accuracy_opensees import load
from pounding_risk.solver.pair.api import free_response, oscillators, run, workspace_for
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, RUN, run_outputs

CONVERGED = 1e-12  # rtol of the reference
FINEST_ERROR = 1e-15  # relative errors below rounding count as this
OUTPUTS = ("peak_relative_displacement", "peak_contact_force")
LEVELS = {OUTPUTS[0]: (1e-4, 1e-6), OUTPUTS[1]: (1e-3, 1e-4, 1e-6)}
ALL_LAWS = ("Jankowski", "HertzDamp", "KelvinVoigt")
GRID, ALONE = "this package, a run of a grid", "this package, a run alone"
OPENSEES, SCIPY, RK4 = "OpenSees", "SciPy", "RK4"
MARKERS = ("o", "s", "^", "D", "v")


class Case(NamedTuple):
    """A scene with what a run of a grid shares and the answer held to be right."""

    scene: Scene
    pair: Any
    free: Any
    truth: Answer


class Rung(NamedTuple):
    """One setting of a method; slow ones are repeated less often."""

    setting: float
    repeats: int


class Method(NamedTuple):
    """A way to solve a case, its settings from coarse to fine, and the laws it knows."""

    name: str
    words: str  # a setting, as a format of its number
    ladder: tuple[Rung, ...]
    laws: tuple[str, ...]
    solve: Callable[[Case, float], Answer]


class Row(NamedTuple):
    """What one rung gave: seconds a run, shape (repetitions, cases), and relative errors, shape (cases, OUTPUTS)."""

    setting: float
    seconds: np.ndarray
    errors: np.ndarray


class Read(NamedTuple):
    """Time at an error: exact between two rungs, or the end of the ladder where the ladder ends."""

    seconds: float
    more: bool = False  # the method needs more than this: its finest rung is worse


def clocked(call: Callable[[], dict[str, float]], times: int = 1) -> Answer:
    """The peaks of a call and the processor's time for one, over so many."""
    begun = time.process_time()
    for _ in range(times):
        found = call()
    seconds = (time.process_time() - begun) / times
    return Answer(found[OUTPUTS[0]], found[OUTPUTS[1]], seconds)


def peaks(pair: Any, free: Any, scene: Scene, rtol: float) -> dict[str, float]:
    """Peaks by this package, from the free response on."""
    found = run_outputs(run(pair, free, scene.interface, rtol), np.inf)
    return {name: float(found[name]) for name in OUTPUTS}


def make_case(scene: Scene) -> Case:
    """The scene with its free response and the reference's answer."""
    pair = oscillators(scene.left, scene.right)
    free = free_response(pair, scene.acceleration, scene.dt)
    return Case(scene, pair, free, clocked(lambda: peaks(pair, free, scene, CONVERGED)))


def solve_in_grid(case: Case, rtol: float) -> Answer:
    """One run as a scan makes it: free response, working space and the table of results are there already."""
    interface = case.scene.interface
    grid = (np.array([interface.gap]), np.array([interface.yield_force]), interface.restitution)
    workspace, raw, how = workspace_for(case.free, rtol), np.zeros((1, 1, COLUMNS)), np.zeros((1, 1), dtype=np.int8)

    def cell() -> dict[str, float]:
        solve_grid(case.pair, case.free, interface.law, grid, rtol, False, workspace, raw, how)
        return {name: float(RUN[name].compute(raw[0, 0], grid[1])) for name in OUTPUTS}

    return clocked(cell, 5)


def solve_alone(case: Case, rtol: float) -> Answer:
    """One run from nothing: free response, working space, all outputs."""

    def whole() -> dict[str, float]:
        free = free_response(case.pair, case.scene.acceleration, case.scene.dt)
        return peaks(case.pair, free, case.scene, rtol)

    return clocked(whole, 3)


def solve_fixed(case: Case, h: float) -> Answer:
    """One run of the fixed-step kernel."""
    scene = case.scene
    return clocked(lambda: solve_rk4(case.pair, scene.interface, scene.acceleration, scene.dt, h))


def solve_general(case: Case, rtol: float) -> Answer:
    """One run of SciPy."""
    scene = case.scene
    return clocked(lambda: solve_scipy(case.pair, scene.interface, scene.acceleration, scene.dt, rtol))


Curve = tuple[list[float], list[float]]


def ladder(*rungs: tuple[float, int]) -> tuple[Rung, ...]:
    """Rungs from pairs (setting, repetitions)."""
    return tuple(Rung(*rung) for rung in rungs)


def methods(ops: Any, quick: bool) -> list[Method]:
    """Every method; OpenSees where ``ops`` is its module, not None."""
    ours = ladder(*((rtol, 9) for rtol in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)))
    fixed = ladder((2e-3, 9), (1e-3, 9), (1e-4, 5), (1e-5, 3), (1e-6, 1))
    general = ladder((1e-3, 3), (1e-6, 3), (1e-9, 3), (CONVERGED, 1))
    steps = ladder((1e-3, 5), (1e-4, 3), (1e-5, 1))
    if quick:
        fixed, general, steps = fixed[:3], general[1::2], steps[:2]
    found = [
        Method(GRID, "rtol {:.0e}", ours, ALL_LAWS, solve_in_grid),
        Method(ALONE, "rtol {:.0e}", ours, ALL_LAWS, solve_alone),
        Method(RK4, "steps of {:.0e} s", fixed, ALL_LAWS, solve_fixed),
        Method(SCIPY, "rtol {:.0e}", general, ALL_LAWS[:1], solve_general),
    ]
    if ops is not None:
        by_steps = Method(
            OPENSEES, "steps of {:.0e} s", steps, ALL_LAWS, lambda case, h: solve_opensees(ops, case.scene, h)
        )
        found.append(by_steps)
    return found


def compile_kernels(found: list[Method], cases: list[Case]) -> float:
    """Let every compiled method see every law once, on the record's first samples; seconds on the wall."""
    begun = time.perf_counter()
    for case in {case.scene.law: case for case in cases}.values():
        short = make_case(case.scene._replace(acceleration=case.scene.acceleration[:10]))
        for method in found:
            if method.name in (GRID, ALONE, RK4):
                method.solve(short, method.ladder[0].setting)
    return time.perf_counter() - begun


def relative_errors(found: Answer, truth: Answer) -> list[float]:
    """|value / truth − 1| of every output."""
    return [max(abs(value / right - 1.0), FINEST_ERROR) for value, right in zip(found[:2], truth[:2], strict=True)]


def cases_of(method: Method, cases: list[Case]) -> list[Case]:
    """The cases that a method can solve."""
    return [case for case in cases if case.scene.law in method.laws]


def places(method: Method, cases: list[Case], group: str = "") -> tuple[list[int], list[int]]:
    """Where a group's scenes that the method can solve stand among all cases, and among the method's own."""
    able = [place for place, case in enumerate(cases) if case.scene.law in method.laws]
    kept = [at for at, place in enumerate(able) if group in ("", cases[place].scene.group)]
    return [able[at] for at in kept], kept


def measure(found: list[Method], cases: list[Case], repeats: int) -> dict[str, list[Row]]:
    """Every rung of every method on every case, the methods taking turns; rows by method."""
    seconds: dict[tuple[str, float], list[list[float]]] = {}
    errors: dict[tuple[str, float], list[list[float]]] = {}
    for repeat in range(repeats):
        for method in found:
            for rung in method.ladder:
                if repeat >= rung.repeats:
                    continue
                answers = [(case, method.solve(case, rung.setting)) for case in cases_of(method, cases)]
                key = (method.name, rung.setting)
                seconds.setdefault(key, []).append([answer.seconds for _, answer in answers])
                errors[key] = [relative_errors(answer, case.truth) for case, answer in answers]
    return {
        method.name: [
            Row(rung.setting, np.array(seconds[method.name, rung.setting]), np.array(errors[method.name, rung.setting]))
            for rung in method.ladder
        ]
        for method in found
    }


def read_time(level: float, errors: Sequence[float], seconds: Sequence[float]) -> Read:
    """The time a method needs for an error: log-log between the rungs around it, given from coarse to fine.

    A rung counts with the largest error of itself and all finer ones, so that none gains from a lucky sign. A method
    that is never so inaccurate counts with its cheapest rung; one that is never so accurate needs more than its finest.
    """
    held = np.maximum.accumulate(np.asarray(errors, dtype=float)[::-1])[::-1]
    if level >= held[0]:
        return Read(float(min(seconds)))
    if level < held[-1]:
        return Read(float(seconds[-1]), more=True)
    fine = int(np.argmax(held <= level))
    share = log(held[fine - 1] / level) / log(held[fine - 1] / held[fine])
    return Read(exp((1.0 - share) * log(seconds[fine - 1]) + share * log(seconds[fine])))


def curve(rows: list[Row], output: int, over: Callable[[Any], Any], chosen: list[int]) -> Curve:
    """Errors and seconds of a method's rungs, coarse to fine: ``over`` the chosen cases, mean time of a run."""
    errors = [float(over(row.errors[chosen, output])) for row in rows]
    return errors, [float(np.median(row.seconds, axis=0)[chosen].mean()) for row in rows]


def ratio_words(theirs: Read, ours: Read) -> str:
    """Ratio of two times as text."""
    value = theirs.seconds / ours.seconds
    if theirs.more and ours.more:
        return "neither gets there"
    sign = "> " if theirs.more else "< " if ours.more else ""
    return f"{sign}{value:,.0f}" if value >= 10.0 else f"{sign}{value:.2g}"


def ratio_rows(measured: dict[str, list[Row]], cases: list[Case], found: list[Method], group: str = "") -> list[str]:
    """Table: the other methods' time over this package's at equal error, of the median scene and of the worst.

    "Every scene" is the setting that the worst scene needs, used for all. ``group`` keeps the scenes of that group; a
    method is compared on the scenes that it can solve.
    """
    heads = [f"{kind} scene: times a run {way}" for kind in ("median", "every") for way in ("of a grid", "alone")]
    rows = [
        f"| {group or 'all scenes'}: against | at an error of | {' | '.join(heads)} |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for method in found:
        if method.name in (GRID, ALONE):
            continue
        ours, its = places(method, cases, group)
        for output, name in enumerate(OUTPUTS):
            for level in LEVELS[name]:
                told = []
                for over in (np.median, np.max):
                    theirs = read_time(level, *curve(measured[method.name], output, over, its))
                    for us in (GRID, ALONE):
                        told.append(ratio_words(theirs, read_time(level, *curve(measured[us], output, over, ours))))
                rows.append(f"| {method.name} | {level:.0e}, {name.replace('_', ' ')} | {' | '.join(told)} |")
    return rows


def rung_rows(measured: dict[str, list[Row]], found: list[Method]) -> list[str]:
    """Table: every rung with its time and its errors."""
    rows = [
        "| one run, mean of the scenes | CPU time | repetitions | error of peak displacement | error of peak force |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    for method in found:
        for row in measured[method.name]:
            errors = [f"{np.median(row.errors[:, i]):.0e}, worst {row.errors[:, i].max():.0e}" for i in range(2)]
            spent = range_of(row.seconds.mean(axis=1).tolist(), in_time)
            label = f"{method.name}, {method.words.format(row.setting)}"
            rows.append(f"| {label} | {spent} | {len(row.seconds)} | {errors[0]} | {errors[1]} |")
    return rows


def bilinear_rows(ops: Any, cases: list[Case], steps: Sequence[float]) -> list[str]:
    """Table: ImpactMaterial, whose law no scene has, against its own run at the smallest step.

    β and e are those of the Hertz-damp scenes. The largest penetration that its formula assumes is that of a spring
    β δ^1.5 under the scene's peak force.
    """
    answers: dict[float, list[Answer]] = {h: [] for h in steps}
    for case in cases:
        if case.scene.law == "HertzDamp":
            largest = (case.truth.peak_contact_force / case.scene.interface.law.stiffness) ** (2.0 / 3.0)
            contact = bilinear_material(case.scene, largest)
            for h in steps:
                answers[h].append(solve_opensees(ops, case.scene, h, contact))
    rows = [
        f"| OpenSees ImpactMaterial, against steps of {steps[-1]:.0e} s | CPU time | change of peak displacement | "
        "change of peak force |",
        "| --- | ---: | ---: | ---: |",
    ]
    for h in steps[:-1]:
        pairs = zip(answers[h], answers[steps[-1]], strict=True)
        errors = np.array([relative_errors(one, finest) for one, finest in pairs])
        told = [f"{np.median(errors[:, i]):.0e}, worst {errors[:, i].max():.0e}" for i in range(2)]
        spent = in_time(float(np.mean([one.seconds for one in answers[h]])))
        rows.append(f"| steps of {h:.0e} s | {spent} | {told[0]} | {told[1]} |")
    return rows


def reference_line(measured: dict[str, list[Row]]) -> str:
    """How far reference and SciPy are apart, on the scenes that SciPy's script can do."""
    worst = measured[SCIPY][-1].errors.max(axis=0)
    return (
        f"Reference: this package at rtol {CONVERGED:.0e}; SciPy at rtol {measured[SCIPY][-1].setting:.0e} differs "
        f"by at most {worst[0]:.0e} in peak displacement and {worst[1]:.0e} in peak force (Jankowski scenes)."
    )


def versions() -> str:
    """Processor and versions of the libraries."""
    told = [f"Python {platform.python_version()}"]
    for name in ("numba", "scipy", "openseespy"):
        try:
            told.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            told.append(f"{name} not installed")
    return ", ".join(told)


def finding(measured: dict[str, list[Row]], cases: list[Case], found: list[Method]) -> str:
    """The figure's title: a run of a grid against the last of the methods, at an error of 1e-4."""
    peer = found[-1]
    own, kept = places(peer, cases)
    told = []
    for over in (np.median, np.max):
        ratios = []
        for output in range(len(OUTPUTS)):
            theirs = read_time(1e-4, *curve(measured[peer.name], output, over, kept))
            ratios.append(ratio_words(theirs, read_time(1e-4, *curve(measured[GRID], output, over, own))))
        told.append(" and ".join(ratios))
    return (
        f"Peak displacement and force to 1e-4: {peer.name} takes {told[0]} times a grid run's time for the median "
        f"scene,\n{told[1]} times at settings that suffice for every scene"
    )


def work_precision(measured: dict[str, list[Row]], cases: list[Case], found: list[Method]) -> Any:
    """Error against time of every method: median of the scenes bold, the worst scene pale."""
    figure, axes = blank(1, 2, (11.0, 5.2), sharey=True)
    for at, method in enumerate(found):
        colour, dash = STYLES[at]
        every = list(range(len(cases_of(method, cases))))
        for output, axis in enumerate(axes[0]):
            for over, look in ((np.median, {"linewidth": 2.0}), (np.max, {"linewidth": 0.9, "alpha": 0.5})):
                errors, seconds = curve(measured[method.name], output, over, every)
                label = method.name if over is np.median else None
                axis.loglog(seconds, errors, color=colour, linestyle=dash, marker=MARKERS[at], label=label, **look)
    for axis, words in zip(axes[0], ("peak relative displacement", "peak contact force"), strict=True):
        axis.set(xlabel="processor time of one run [s]", title=words)
    axes[0, 0].set_ylabel("relative error")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(found), fontsize=9)
    condition = f"{len(cases)} scenes: bold the median, pale the worst; SciPy on the {ALL_LAWS[0]} scenes only"
    title(figure, finding(measured, cases, found), condition)
    return figure


def opensees_or_reason() -> tuple[Any, str]:
    """OpenSees' module, or None and the sentence that says why not."""
    try:
        return load(), ""
    except PoundingError as reason:
        return None, f"OpenSees is left out: {reason}"


def main(arguments: list[str] | None = None) -> int:
    """Print the tables, draw the figure."""
    parser = argparse.ArgumentParser(description="This package beside OpenSees, SciPy and a fixed-step kernel.")
    parser.add_argument("--figure", metavar="FILE", help="draw error against time (PNG, SVG or PDF)")
    parser.add_argument("--repeats", type=int, default=9, help="repetitions of quick methods, at most 9 (9)")
    parser.add_argument("--quick", action="store_true", help="three scenes of 6 s, coarse settings, one repetition")
    asked = parser.parse_args(arguments)
    ops, reason = opensees_or_reason()
    scenes = moderate_scenes(600, (0.02,)) if asked.quick else all_scenes()
    found = methods(ops, asked.quick)
    begun = time.perf_counter()
    cases = [make_case(scene) for scene in scenes]
    compiled = time.perf_counter() - begun + compile_kernels(found, cases)
    measured = measure(found, cases, 1 if asked.quick else asked.repeats)
    print(f"{versions()}. {len(cases)} scenes; median (least to largest) of the repetitions.", end="\n\n")
    print("\n".join(rung_rows(measured, found)), end="\n\n")
    print("Time over this package's at equal error:", end="\n\n")
    groups = list(dict.fromkeys(case.scene.group for case in cases))
    for group in ("", *groups) if len(groups) > 1 else ("",):
        print("\n".join(ratio_rows(measured, cases, found, group)), end="\n\n")
    if ops is not None:
        steps = [rung.setting for rung in found[-1].ladder]
        print("\n".join(bilinear_rows(ops, cases, steps)), end="\n\n")
    print(reference_line(measured), f"Compiling or loading the kernels: {compiled:.1f} s, apart.", sep="\n")
    if reason:
        print(reason)
    if asked.figure:
        write(work_precision(measured, cases, found), asked.figure)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
