"""264,000 cases of 44 records, screened and not: ``python benchmarks/far_field_grid.py FOLDER``.

44 records × 50 gaps × 20 yield forces × 6 laws: the pair of `far_field.toml` under the FEMA P-695 far-field set (16 to
100 s) at the default tolerance, through the public `scan` on two threads. FOLDER is where `far_field.py` wrote the set.
Each scan runs in a process of its own, once its kernels are compiled; wall and processor time are from the first record
read to the finished dataset, the largest resident memory is the process's.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from shortened import either

from pounding_risk.ensemble.scan import scan
from pounding_risk.results.summary import counted
from pounding_risk.scene.reader import read_scene

LAWS = ("hertz", "hertz_damp", "hertz_damp_exact", "jankowski", "van_mier", "viscous_elastoplastic")[either(0, 5) :]
GAPS, YIELD_FORCES, THREADS = either((50, 20, 2), (2, 3, 2))


def overrides(gaps: int, yield_forces: int) -> list[str]:
    """Changes of the scene's values, as after ``--set``."""
    forces = [f"{force:.6g} N" for force in np.geomspace(1e5, 1e7, yield_forces - 1)]
    return [
        'records.polarity=["as recorded"]',
        f'grid.gap={{start = "0 mm", stop = "300 mm", num = {gaps}}}',
        f"grid.yield_force={json.dumps([*forces, 'inf'])}",
        f"grid.contact_model={json.dumps(LAWS)}",
    ]


def measure(folder: Path, screening: bool) -> dict[str, float]:
    """One scan in this process, its kernels compiled by a small one first."""
    scene = folder / "far_field.toml"
    scan(read_scene(scene, overrides(2, 3)), check_fraction=0.0, workers=THREADS)
    wall, cpu = time.perf_counter(), time.process_time()
    dataset = scan(
        read_scene(scene, overrides(GAPS, YIELD_FORCES)), screening=screening, check_fraction=0.0, workers=THREADS
    )
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    counts = counted(dataset)
    failed = int((dataset["status"].values != 0).sum())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {"cases": counts["cases"], "runs": counts["simulated"], "failed": failed} | {
        "wall": wall,
        "cpu": cpu,
        "memory": memory,
    }


def main() -> int:
    """Measure both ways in turn, each in a process of its own, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where far_field.py wrote the records")
    parser.add_argument("--only", choices=("screened", "every"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(options.folder, options.only == "screened")))
        return 0
    found = {}
    for which in ("screened", "every"):
        command = [sys.executable, __file__, str(options.folder), "--only", which]
        found[which] = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    print("| scan | cases | runs made | failed | wall | processor | resident memory |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for which, words in (("screened", "screening on"), ("every", "every case run")):
        one = found[which]
        counts = f"{one['cases']:,} | {one['runs']:,} | {one['failed']}"
        print(f"| {words} | {counts} | {one['wall']:.1f} s | {one['cpu']:.1f} s | {one['memory']:.0f} MB |")
    print(f"\nWithout screening {found['every']['wall'] / found['screened']['wall']:.1f} times as long.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
