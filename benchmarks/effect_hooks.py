"""Time that the code of effects costs a scene without any: ``python benchmarks/effect_hooks.py [REPETITIONS]``.

Copies the package twice, deletes the hooks of effects from one copy, and times the benchmark's grid in both, each in a
process of its own, taking turns. A hook that is not found where it is deleted is an error, so that the list stays true.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from shortened import either

ROOT = Path(__file__).resolve().parent.parent
# File, text with the hook, text without.
HOOKS = (
    ("solver/pair/run.py", "limits.gap + workspace.counters[SET]", "limits.gap"),
    ("solver/pair/law_verbs.py", "law.resume(law.begin(e, speed, mass), damage)", "law.begin(e, speed, mass)"),
    ("solver/pair/law_verbs.py", "law.ceiling(limit) * law.hardening(speed)", "law.ceiling(limit)"),
    ("solver/pair/law_verbs.py", "law.held(memory, delta, strength) - lost", "law.stored(delta, strength)"),
    ("solver/pair/law_verbs.py", "law.yielded(loss), law.damage(memory)", "0.0, 0.0"),
    ("solver/pair/contact.py", "loss - hysteresis", "loss"),
    ("solver/pair/contact.py", "    workspace.counters[PLASTIC] += yielding[1] + hysteresis\n", ""),
    ("solver/pair/contact.py", "    workspace.counters[SET] += yielding[0]\n", ""),
    ("solver/pair/contact.py", "    workspace.counters[DAMAGE] = damage\n", ""),
    ("solver/pair/contact.py", "impact.gap - yielding[0] + peaks[2]", "impact.gap + peaks[2]"),
    (
        "solver/pair/contact.py",
        """            impact, indentation, energy_lost = turn_motion(impact, phase, delta)
            if indentation >= 0.0:
                indented, lost = indented + indentation, lost + energy_lost
""",
        "",
    ),
    (
        "solver/pair/contact.py",
        """            if indentation >= 0.0:
                phase = Phase(phase.approaching, ELASTIC, phase.ground)
""",
        "",
    ),
    ("solver/pair/flight.py", "state[0] - state[1] - widened", "state[0] - state[1]"),
    (
        "solver/pair/flight.py",
        """        w0, w1, w2, w3 = ground.widening()
        series[SIGNAL, 0] -= w0
        series[SIGNAL, 1] -= w1
        series[SIGNAL, 2] -= w2
        series[SIGNAL, 3] -= w3
""",
        "",
    ),
    ("solver/pair/flight.py", "turn_left + turn_right + ground.bend(length)", "turn_left + turn_right"),
    ("solver/pair/contact.py", "    state = ground.across(right, state, 0.0)\n", ""),
    ("solver/pair/contact.py", "ground.from_own_ground(right, state, 0.0)", "state"),
    ("solver/pair/contact.py", "ground.from_own_ground(right, state, since_touch)", "state"),
    ("solver/pair/contact.py", "ground.from_own_ground(right, state, duration)", "state"),
    ("solver/pair/peaks.py", "phase.ground.from_own_ground(right, state, time)", "state"),
    (
        "solver/pair/peaks.py",
        "phase.ground.slopes_from_own_ground(right, state_of(workspace.slopes, slope_row), cube * s, 4.0 * cube)",
        "state_of(workspace.slopes, slope_row)",
    ),
    ("solver/pair/equations.py", "(put_in - phase.ground.taken_along(right, force, state[3]))", "put_in"),
)
TIMED = """
import json, time
from throughput import make_bench, run_grid
bench = make_bench()
run_grid(bench, False, 1)
times = []
for _ in range(3):
    start = time.process_time()
    raw, how = run_grid(bench, False, 1)
    times.append((time.process_time() - start) / how.size * 1e6)
print(json.dumps({"times": times}))
"""


def copied(folder: Path, hooks: bool) -> Path:
    """A copy of the package and the benchmarks, with hooks or without."""
    for name in ("pounding_risk", "benchmarks", "records"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"), symlinks=False)
    for file, old, new in () if hooks else HOOKS:
        path = folder / "pounding_risk" / file
        text = path.read_text(encoding="utf-8")
        if text.count(old) != 1:
            raise SystemExit(f"{file}: this hook stands there {text.count(old)} times, not once:\n{old}")
        path.write_text(text.replace(old, new), encoding="utf-8")
    return folder


def timed(folder: Path) -> list[float]:
    """Processor time of one run [µs], three times, after compiling."""
    environment = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{folder / 'benchmarks'}"}
    command = [sys.executable, "-c", TIMED]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder, env=environment)
    return json.loads(done.stdout)["times"]


def main(arguments: list[str]) -> int:
    """Print the time of a run with the hooks and without, and their ratio."""
    repetitions = int(arguments[0]) if arguments else either(7, 1)
    with tempfile.TemporaryDirectory() as scratch:
        folders = [copied(Path(scratch) / name, name == "with") for name in ("with", "without")]
        times: list[list[float]] = [[], []]
        for number in range(repetitions):
            for place in (0, 1) if number % 2 else (1, 0):
                times[place] += timed(folders[place])
    with_hooks, without = map(median, times)
    print("| kernel | CPU time a run |\n| --- | ---: |")
    for name, some in zip(("with the hooks of effects, none named", "hooks deleted"), times, strict=True):
        print(f"| {name} | {median(some):.1f} µs ({min(some):.1f} µs to {max(some):.1f} µs) |")
    print(f"\nRatio of the medians {with_hooks / without:.4f}, of the shortest {min(times[0]) / min(times[1]):.4f}.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
