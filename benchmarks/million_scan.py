"""A million cases solved and written, in memory that does not grow with them: ``python benchmarks/million_scan.py``.

The pair of T 0.5 and 1.0 s under the twelve horizontal components that ship, both polarities, two laws, 100 gaps and
210 yield forces: 1,008,000 cases, and a tenth of them beside it. Each in a process of its own, by two threads into a
file, its kernels compiled before; the largest resident memory is the process's.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from shortened import either

import pounding_risk
from pounding_risk.ensemble.scan import scan
from pounding_risk.scene.reader import read_scene
from pounding_risk.scene.scene import Scene, scene_of

THREADS = 2
LAWS = ("jankowski", "viscous_elastoplastic")
SIZES = either({"a tenth": (100, 21), "a million": (100, 210)}, {"a few": (2, 3)})  # gaps, yield forces


def measure(gaps: int, strengths: int) -> dict[str, float]:
    """Time and peak memory of one scan in this process."""
    study = study_of(gaps, strengths)
    with tempfile.TemporaryDirectory() as folder:
        out, start = Path(folder) / "results.nc", time.perf_counter()
        dataset = scan(study, out, check_fraction=0.01, workers=THREADS)
        seconds = time.perf_counter() - start
        return {
            "cases": int(dataset["status"].size),
            "wall": seconds,
            "file": out.stat().st_size / 1e6,
            "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        }


def study_of(gaps: int, strengths: int) -> Scene:
    """The grid's study; the records are those of the scene `compare.toml` that ships."""
    shipped = Path(pounding_risk.__file__).parent / "scene" / "shipped" / "compare.toml"
    forces = [f"{force:.6g} N" for force in np.geomspace(1e5, 1e7, strengths - 1)]
    return scene_of(
        {
            "building": [
                {"name": "left", "mass": "500 t", "period": "0.5 s", "damping": 0.05},
                {"name": "right", "mass": "800 t", "period": "1.0 s", "damping": 0.05},
            ],
            "interface": [{"contact_model": LAWS[0], "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}],
            "records": {
                "names": list(read_scene(shipped).records.names),
                "polarity": ["as recorded", "reversed"],
            },
            "grid": {
                "gap": {"start": "0 mm", "stop": "300 mm", "num": gaps},
                "yield_force": [*forces, "inf"],
                "contact_model": list(LAWS),
            },
        }
    )


def main() -> int:
    """Measure each size in a process of its own and print a table."""
    if len(sys.argv) == 3:
        measure(2, 3)  # compiles
        print(json.dumps(measure(int(sys.argv[1]), int(sys.argv[2]))))
        return 0
    print("| grid | cases | time | file | largest resident memory |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, (gaps, strengths) in SIZES.items():
        command = [sys.executable, __file__, str(gaps), str(strengths)]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        print(
            f"| {name} | {found['cases']:,} | {found['wall']:.0f} s | {found['file']:.0f} MB | {found['peak']:.0f} MB |"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
