"""Time of a run over the least time that the machine needs for its operations: ``python benchmarks/floor.py [GAP_MM]``.

Times the parts that cannot be left out, each in a compiled loop of its own: one attempt at a step in contact, one look
at a block of 16 samples and at one sample in flight. Counts how often a run of the benchmark's pair needs each (as
`profile_run.py` counts), and sets the run's time beside the sum. Floating-point operations of an attempt are counted
from the tableau and the contact law.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from shortened import either
from throughput import LAW, RESTITUTION, RTOL, make_bench, run_grid

from pounding_risk._jit.compile import kernel
from pounding_risk.models.ground import UniformInterval
from pounding_risk.solver.pair.api import free_response
from pounding_risk.solver.pair.equations import ELASTIC, Phase, new_impact, slopes, state_of
from pounding_risk.solver.pair.flight import EVERY_SIGNAL, block_mask, reaches, search_mask
from pounding_risk.solver.pair.implicit import attempt
from pounding_risk.solver.runge_kutta import DOP853
from pounding_risk.solver.workspace import BEGIN, FIRST_STAGE, make_workspace

LOOPS, REPEATS = either((200_000, 7), (100, 1))
TOUCH = (0.02, 0.0, 0.4, -0.1)  # u_left, u_right [m], v_left, v_right [m/s]
FORCE_OPERATIONS = 60  # in `slopes` with Jankowski's law: products, sums and two square roots, counted by hand


@kernel
def repeat_attempts(pair, law, restitution, workspace, count):
    """So many attempts at the same step in contact."""
    impact, _, _ = new_impact(pair, 0.5, law, (TOUCH[0], np.inf, restitution), TOUCH, 0.0)
    phase = Phase(True, ELASTIC, UniformInterval(0.5, 10.0))
    for part in range(4):
        workspace.states[BEGIN, part] = TOUCH[part]
    slopes(impact, phase, 0.0, state_of(workspace.states, BEGIN), workspace, FIRST_STAGE)
    total = 0.0
    for number in range(count):
        total += attempt(impact, phase, 0.0, 0.3 + 1e-9 * (number % 7), RTOL, workspace)
    return total


@kernel
def repeat_blocks(pair, free, workspace, count):
    """So many looks at blocks in flight."""
    total = 0
    for number in range(count):
        vibration = (1e-3, 2e-3, 0.01, 0.01 + 1e-9 * (number % 7))
        reach = reaches(pair, vibration)
        total += block_mask((free.high, free.low), 0.1, number % free.high.shape[0], reach, workspace)
    return total


@kernel
def repeat_samples(pair, free, workspace, count):
    """So many looks at sample intervals in flight."""
    total = 0
    for number in range(count):
        workspace.end_signals[0] = 1e-9 * (number % 7)
        span = (UniformInterval(free.ground[number % free.ground.size], 10.0), free.step)
        total += search_mask(pair, 0.1, (1e-3, 2e-3, 0.01, 0.01), span, EVERY_SIGNAL, workspace)
    return total


def nanoseconds(call: Any, *arguments: Any) -> float:
    """Median time of one turn of the loop."""
    call(*arguments, 10)
    times = []
    for _ in range(REPEATS):
        start = process_time()
        call(*arguments, LOOPS)
        times.append((process_time() - start) / LOOPS * 1e9)
    return float(np.median(times))


def counts(gap: float) -> dict[str, float]:
    """How often a run needs each part; counted uncompiled in a process of its own."""
    code = (
        "import json, sys, profile_run; calls = profile_run.profile(float(sys.argv[1]), float('inf'));"
        "print(json.dumps({'attempt': sum(n for (part, _), n in calls.items() if part == 'attempt'),"
        "'contacts': calls['begin_contact', 'march'], 'block': calls['block_mask', 'fly'],"
        "'sample': calls['search_mask', 'fly']}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(gap)], check=True, capture_output=True, text=True, cwd=Path(__file__).parent
    )
    return json.loads(done.stdout)


def main(arguments: list[str]) -> int:
    """Print the floor, part by part, and the run over it."""
    gap = float(arguments[0]) * 1e-3 if arguments else 0.01
    bench = make_bench()
    bench = bench._replace(gaps=np.array([gap]), yield_forces=np.full(200, 1e12))
    free, workspace = free_response(bench.pair, bench.acceleration, bench.dt), make_workspace(RTOL)
    workspace.high[:], workspace.low[:] = 1e3, -1e3
    unit = {
        "attempt": nanoseconds(repeat_attempts, bench.pair, LAW, RESTITUTION, workspace),
        "block": nanoseconds(repeat_blocks, bench.pair, free, workspace),
        "sample": nanoseconds(repeat_samples, bench.pair, free, workspace),
    }
    number = counts(gap)
    run_grid(bench, False, 1)
    times = []
    for _ in range(REPEATS):
        start = process_time()
        run_grid(bench, False, 1)
        times.append((process_time() - start) / 200 * 1e6)
    pairs = sum(len(row) for row in DOP853.rows)
    operations = 8 * pairs + 26 * len(DOP853.weights) + FORCE_OPERATIONS * (len(DOP853.nodes) - 1)
    words = {
        "attempt": f"attempts at a step in contact, {operations:,} operations each",
        "block": "blocks of 16 samples looked at in flight",
        "sample": "samples looked at in flight",
    }
    print("| part | in one run | each | together |\n| --- | ---: | ---: | ---: |")
    floor = 0.0
    for name, what in words.items():
        spent = unit[name] * number[name] * 1e-3
        floor += spent
        print(f"| {what} | {number[name]:,} | {unit[name]:.0f} ns | {spent:.0f} µs |")
    run = float(np.median(times))
    print(f"| sum: what cannot be left out | | | {floor:.0f} µs |")
    print(f"| one run, {number['contacts']} contacts | | | {run:.0f} µs, {run / floor:.2f} times the sum |")
    print(f"\nAn attempt does {operations / unit['attempt']:.1f} operations a nanosecond.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
