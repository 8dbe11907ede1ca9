"""Time of one grid of a pair and of one row in two checkouts: ``python benchmarks/two_trees.py OLD NEW``.

The same scenes through the public `scan`, on one thread, every case run. The checkouts take turns, a fresh process each
time, so that a busy machine slows both; in each process kernels are compiled before and the median of some scans is
taken. Printed are the medians over the processes in processor seconds, their ratio, and whether the results are equal
bit for bit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

from shortened import either

RECORD = {"names": ["RSN6-180"]}
CONTACT = {"stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}
PAIR = {
    "building": [
        {"name": "left", "mass": "500 t", "period": "0.5 s", "damping": 0.05},
        {"name": "right", "mass": "800 t", "period": "1.0 s", "damping": 0.05},
    ],
    "interface": [{"gap": "0 mm", "contact_model": "viscous_elastoplastic", "yield_force": "1 MN", **CONTACT}],
    "records": RECORD,
    "grid": {
        "gap": {"start": "0 mm", "stop": "100 mm", "num": either(100, 2)},
        "yield_force": [f"{100 * 10 ** (step / 7):.6g} kN" for step in range(15)],
    },
}
STOREYS = {"floor_masses": "200 t", "storey_stiffnesses": "200 MN/m", "storey_heights": "3 m"}
ROW = {
    "building": [{"name": f"house {at + 1}", "storeys": 2 + at, **STOREYS} for at in range(4)],
    "interface": [{"gap": "10 mm", "contact_model": "jankowski", **CONTACT}],
    "records": {**RECORD, "pga": "0.4 g"},
    "grid": {"gap": ["5 mm", "20 mm"]},
}
SCENES = {"pair": PAIR, "row": ROW}


def times(repeats: int) -> dict[str, Any]:
    """Processor seconds of a scan of each scene, median of ``repeats``, and the SHA-256 of all its numbers."""
    import pounding_risk as pr

    measured = {}
    for name, tables in SCENES.items():
        scene, seconds = pr.read_scene(tables), []
        for _ in range(repeats + 1):  # the first compiles
            begun = time.process_time()
            dataset = pr.scan(scene, screening=False, check_fraction=0.0, workers=1)
            seconds.append(time.process_time() - begun)
        numbers = [dataset[name].values for name in sorted(dataset.data_vars) if dataset[name].dtype.kind in "fi"]
        digest = hashlib.sha256(b"".join(values.tobytes() for values in numbers)).hexdigest()
        measured[name] = [median(seconds[1:]), digest]
    return measured


def in_checkout(folder: Path, repeats: int) -> dict[str, Any]:
    """`times` in a fresh process that imports the package from a checkout."""
    command = [sys.executable, str(Path(__file__).resolve()), "--one", "--repeats", str(repeats)]
    environment = {**os.environ, "PYTHONPATH": str(folder.resolve())}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, cwd=folder)
    return json.loads(done.stdout.splitlines()[-1])


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="CHECKOUT", help="the old one and the new one")
    parser.add_argument("--turns", type=int, default=either(5, 1), help="processes of each checkout (5)")
    parser.add_argument("--repeats", type=int, default=either(5, 1), help="scans in a process (5)")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.one:
        print(json.dumps(times(options.repeats)))
        return 0
    if len(options.folders) != 2:
        parser.error("name two checkouts: the old one and the new one")
    turns = [[in_checkout(folder, options.repeats) for folder in options.folders] for _ in range(options.turns)]
    print("| scene | old [s] | new [s] | new / old, median (least to largest) | bits |\n|---|---|---|---|---|")
    for name in SCENES:
        old, new = ([turn[side][name] for turn in turns] for side in (0, 1))
        ratios = sorted(after[0] / before[0] for before, after in zip(old, new, strict=True))
        same = len({digest for _, digest in (*old, *new)}) == 1
        columns = (median(value[0] for value in old), median(value[0] for value in new))
        spread = f"{median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f})"
        print(f"| {name} | {columns[0]:.4f} | {columns[1]:.4f} | {spread} | {'equal' if same else 'differ'} |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
