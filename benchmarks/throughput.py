"""Throughput of a grid, beside a fixed-step kernel and SciPy: ``python benchmarks/throughput.py``.

The pair of T 0.5 and 1.0 s, 500 and 800 t, ζ 5 %, β 2.75e9 N/m^1.5, e 0.65, viscous elastoplastic contact, under the
full El Centro record RSN6-180 as recorded (53.7 s). Grid: 50 gaps from 0 to 100 mm, and 45 yield forces: 44 spaced
evenly in the logarithm from 100 kN to 10 MN, and infinite. Methods take turns, repetition by repetition, so that a
busy machine slows all of them; medians, the fastest and the slowest are printed. Compile time is told apart.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from statistics import median
from typing import Any, NamedTuple

import numpy as np
from rk4 import solve_rk4
from scipy_pair import solve_scipy
from shortened import either

from pounding_risk.ensemble.scan import scan
from pounding_risk.models.contact.laws import ViscousElastoplastic
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.read import read_motion
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, RUN, run_outputs
from pounding_risk.solver.workspace import make_workspace

LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
LAW, RESTITUTION = ViscousElastoplastic(2.75e9), constant(0.65)
RECORD, THREADS, RTOL, CONVERGED = "RSN6-180", 2, 1e-6, 1e-11
CASES_A_PIECE = 100  # small pieces, so that neither thread waits long at the end
GAPS, YIELD_FORCES, SAMPLES, REPEATS = either((50, 45, None, 7), (11, 9, 600, 1))  # no samples: all of them
# Cases (gap [m], F_E [N]) on which methods are set side by side: several contacts, with and without yielding.
CASES = ((0.01, np.inf), (0.02, np.inf), (0.02, 3e5), (0.03, 1e6), (0.04, np.inf), (0.06, 6e5))
ERRORS = ("peak_relative_displacement", "peak_contact_force")

SCENE = """
[scene]
name = "throughput"
[[building]]
name = "left"
mass = "500 t"
period = "0.5 s"
damping = 0.05
[[building]]
name = "right"
mass = "800 t"
period = "1.0 s"
damping = 0.05
[[interface]]
gap = "0 mm"
contact_model = "viscous_elastoplastic"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65
[records]
names = ["RSN6-180"]
"""


class Bench(NamedTuple):
    """Buildings, motion and grid that every method is given."""

    pair: Any
    acceleration: np.ndarray
    dt: float
    gaps: np.ndarray
    yield_forces: np.ndarray


class Spent(NamedTuple):
    """Seconds of one call: on the wall, and of the processor over all threads."""

    wall: float
    cpu: float


def make_bench(gaps: int = GAPS, yield_forces: int = YIELD_FORCES, samples: int | None = SAMPLES) -> Bench:
    """The grid of the benchmark, or a smaller one on the record's first samples."""
    motion = read_motion(RECORD)
    strengths = np.append(np.geomspace(1e5, 1e7, yield_forces - 1), np.inf)
    pair = oscillators(LEFT, RIGHT)
    return Bench(pair, motion.acceleration[:samples], motion.dt, np.linspace(0.0, 0.1, gaps), strengths)


def run_grid(bench: Bench, screening: bool, threads: int, rtol: float = RTOL) -> tuple[np.ndarray, np.ndarray]:
    """The grid by the compiled sweep, the free response included; raw columns, and 1 where a run was made."""
    free = free_response(bench.pair, bench.acceleration, bench.dt)
    shape = (len(bench.gaps), len(bench.yield_forces))
    raw, how = np.zeros((*shape, COLUMNS)), np.zeros(shape, dtype=np.int8)
    width = max(1, CASES_A_PIECE // shape[1])

    def work(first: int) -> None:
        piece = slice(first, first + width)
        grid = (bench.gaps[piece], bench.yield_forces, RESTITUTION)
        solve_grid(bench.pair, free, LAW, grid, rtol, screening, make_workspace(rtol), raw[piece], how[piece])

    pieces = range(0, shape[0], width)
    if threads == 1:
        for first in pieces:
            work(first)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(work, pieces))
    return raw, how


def run_scan(bench: Bench, screening: bool) -> Any:
    """The same grid by the public call: the record read and processed, the labelled dataset made."""
    gaps = [f"{gap!r} m" for gap in bench.gaps.tolist()]
    strengths = [f"{force!r} N" if force < np.inf else "inf" for force in bench.yield_forces.tolist()]
    window = ["0 s", f"{(len(bench.acceleration) - 1) * bench.dt} s"]
    keys = f"window = {window}\n[grid]\ngap = {gaps}\nyield_force = {strengths}\n[solver]\nrtol = {RTOL}\n"
    return scan(parse_scene(SCENE + keys), screening=screening, workers=THREADS)


def timed(call: Callable[[], Any]) -> tuple[Any, Spent]:
    """The call's value and what it took."""
    wall, cpu = time.perf_counter(), time.process_time()
    value = call()
    return value, Spent(time.perf_counter() - wall, time.process_time() - cpu)


def solve_package(bench: Bench, interface: Interface, rtol: float) -> dict[str, float]:
    """One run as in the grid, the free response being shared by all cases of a record."""
    raw = run(bench.pair, shared_free(bench), interface, rtol)
    return {name: float(value) for name, value in run_outputs(raw, interface.yield_force).items() if name in RUN}


_FREE: dict[int, Any] = {}


def shared_free(bench: Bench) -> Any:
    """The free response of the benchmark's record, made once."""
    if id(bench.acceleration) not in _FREE:
        _FREE[id(bench.acceleration)] = free_response(bench.pair, bench.acceleration, bench.dt)
    return _FREE[id(bench.acceleration)]


def methods(bench: Bench, scipy: bool) -> dict[str, Callable[[Interface], dict[str, float]]]:
    """Everything that solves one case, by name; the first is what the others are measured against."""

    def package(rtol: float) -> Callable[[Interface], dict[str, float]]:
        return lambda interface: solve_package(bench, interface, rtol)

    def fixed(h: float) -> Callable[[Interface], dict[str, float]]:
        return lambda interface: solve_rk4(bench.pair, interface, bench.acceleration, bench.dt, h)

    def general(rtol: float) -> Callable[[Interface], dict[str, float]]:
        return lambda interface: solve_scipy(bench.pair, interface, bench.acceleration, bench.dt, rtol)

    found = {f"this package, rtol {rtol:.0e}": package(rtol) for rtol in (1e-6, 1e-4, 1e-9)}
    found |= {f"RK4, fixed steps of {h:.0e} s": fixed(h) for h in (1e-4, 1e-5)}
    if scipy:
        found |= {f"SciPy DOP853, rtol {rtol:.0e}": general(rtol) for rtol in (1e-6, 1e-10)}
    return found


def worst_errors(values: list[dict[str, float]], truths: list[dict[str, float]]) -> list[tuple[float, float]]:
    """(median, worst) relative error of each output of ERRORS over the cases."""
    found = []
    for name in ERRORS:
        errors = [abs(value[name] / truth[name] - 1.0) for value, truth in zip(values, truths, strict=True)]
        found.append((median(errors), max(errors)))
    return found


def range_of(values: list[float], form: Callable[[float], str]) -> str:
    """Text "median (least to largest)" of values."""
    return f"{form(median(values))} ({form(min(values))} to {form(max(values))})"


def per_second(value: float) -> str:
    """A rate with separated thousands."""
    return f"{value:,.0f}"


def in_time(seconds: float) -> str:
    """Seconds in a unit that suits them."""
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.0f} µs"


def grid_rows(bench: Bench, repeats: int) -> tuple[list[str], str]:
    """Table of the grid in all its ways, and a line on compile time and error."""
    size = len(bench.gaps) * len(bench.yield_forces)
    sweep_of = {
        "sweep, 2 threads, every case run": lambda: run_grid(bench, False, THREADS),
        "sweep, 1 thread, every case run": lambda: run_grid(bench, False, 1),
        "sweep, 2 threads, screened": lambda: run_grid(bench, True, THREADS),
        "`scan()`, 2 threads, every case run": lambda: run_scan(bench, False),
        "`scan()`, 2 threads, screened": lambda: run_scan(bench, True),
    }
    first = {name: timed(call) for name, call in sweep_of.items()}
    spent: dict[str, list[Spent]] = {name: [] for name in sweep_of}
    for _ in range(repeats):
        for name, call in sweep_of.items():
            spent[name].append(timed(call)[1])
    rows = [
        "| grid | cases | runs made | runs a second, wall | cases a second, wall | CPU time a run |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, (value, _) in first.items():
        made = int(value["simulated"].sum()) if name.startswith("`scan") else int(value[1].sum())
        runs = range_of([made / one.wall for one in spent[name]], per_second)
        cases = range_of([size / one.wall for one in spent[name]], per_second)
        cpu = range_of([one.cpu / made for one in spent[name]], in_time)
        rows.append(f"| {name} | {size:,} | {made:,} | {runs} | {cases} | {cpu} |")
    begun = next(iter(first.values()))[1].wall - median(one.wall for one in spent[next(iter(spent))])
    return rows, f"Loading or compiling the kernels: {begun:.1f} s, apart from the table."


def grid_error(bench: Bench) -> str:
    """How far every tenth or so of the grid is from a converged run."""
    part = bench._replace(
        gaps=bench.gaps[::5].copy(), yield_forces=bench.yield_forces[::4].copy()
    )  # kernels take contiguous arrays
    raw, truth = run_grid(part, False, THREADS)[0], run_grid(part, False, THREADS, CONVERGED)[0]
    told = []
    for name in ERRORS:
        value, right = (RUN[name].compute(columns, part.yield_forces) for columns in (raw, truth))
        error = np.abs(value - right) / np.where(right > 0.0, right, 1.0)
        told.append(f"{name.replace('_', ' ')} {np.median(error):.0e} (median) {error.max():.0e} (worst)")
    counts = np.sum(RUN["impact_count"].compute(raw, 0.0) != RUN["impact_count"].compute(truth, 0.0))
    return (
        f"Error of the grid at rtol {RTOL:.0e} on {raw[..., 0].size} of its cases: {', '.join(told)}; "
        f"{counts} impact counts differ."
    )


def method_rows(bench: Bench, repeats: int, scipy: bool) -> list[str]:
    """Table of single cases: time, error, and time over this package's."""
    interfaces = [Interface(gap, LAW, RESTITUTION, strength) for gap, strength in CASES]
    truths = [solve_package(bench, interface, CONVERGED) for interface in interfaces]
    ways = methods(bench, scipy)
    short = bench._replace(acceleration=bench.acceleration[:10])
    for call in methods(short, False).values():
        call(interfaces[0])  # compiles
    values: dict[str, list[dict[str, float]]] = {}
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for repeat in range(repeats):
        for name, call in ways.items():
            if name.startswith("SciPy") and repeat:
                continue  # seconds a run: once is enough
            clock = time.thread_time()
            values[name] = [call(interface) for interface in interfaces]
            seconds[name].append((time.thread_time() - clock) / len(interfaces))
    base = median(seconds[next(iter(ways))])
    rows = [
        f"| one run, mean of {len(CASES)} cases | CPU time | over this package's | error of peak displacement | "
        "error of peak force |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    for name in ways:
        errors = [f"{middle:.0e}, worst {worst:.0e}" for middle, worst in worst_errors(values[name], truths)]
        ratio = median(seconds[name]) / base
        rows.append(f"| {name} | {range_of(seconds[name], in_time)} | {ratio:,.3g} | {errors[0]} | {errors[1]} |")
    return rows


def main(arguments: list[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Throughput of a grid of cases, beside other ways to solve them.")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="repetitions of every method (7)")
    parser.add_argument("--gaps", type=int, default=GAPS, help="gaps in the grid (50)")
    parser.add_argument("--yield-forces", type=int, default=YIELD_FORCES, help="yield forces in the grid (45)")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="only the record's first samples")
    parser.add_argument("--no-scipy", action="store_true", help="leave out SciPy, which takes half a minute")
    asked = parser.parse_args(arguments)
    bench = make_bench(asked.gaps, asked.yield_forces, asked.samples)
    rows, begun = grid_rows(bench, asked.repeats)
    seconds = (len(bench.acceleration) - 1) * bench.dt
    print(f"{RECORD}, {seconds:.1f} s, dt {bench.dt:g} s; median (least to largest) of {asked.repeats} repetitions.\n")
    print("\n".join(rows), "", begun, grid_error(bench), "", sep="\n")
    print("\n".join(method_rows(bench, asked.repeats, not asked.no_scipy)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
