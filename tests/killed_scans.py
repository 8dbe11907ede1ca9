"""Scans killed by SIGKILL at random moments, resumed, and compared with undisturbed scans.

Run in a process of its own: `python killed_scans.py FOLDER STUDIES KILLS SEED` prints what happened. Each start is
a fork, with its kernels compiled and read, so that what is killed is work and not the start of Python.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

from scenes import BOTH, scene_text, single

from pounding_risk.ensemble.scan import scan
from pounding_risk.ensemble.threads import Threads
from pounding_risk.scene.reader import parse_scene

LATEST = 0.5  # s after a start, of a kill


def pair(period: float, gaps: int) -> str:
    """A pair with a grid of so many gaps."""
    return scene_text(
        single("left", "500 t", f"{period} s"),
        single("right", "800 t", "1.0 s"),
        name="killed",
        gap=None,
        records={"names": ["RSN6-180", "CCC-HN1"], "polarity": BOTH},
        grid={
            "gap": {"start": "0 mm", "stop": "60 mm", "num": gaps},
            "yield_force": ["1 MN", "2 MN", "4 MN", "8 MN", "inf"],
            "contact_model": ["jankowski", "viscous_elastoplastic"],
        },
    )


def ended(child: int) -> bool:
    """Whether a child has ended; it is not waited for."""
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def start(study, target: Path, workers: int) -> int:
    """A scan in a child process, whose exit status tells whether it came to its end."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            scan(study, target, screening=False, executor=Threads(workers))
            status = 0
        finally:
            os._exit(status)
    return child


def disturbed(study, target: Path, expected: bytes, chance: random.Random, most: int) -> tuple[int, list[str]]:
    """Kill start after start, ``most`` at most, until one comes to its end: (kills, what is wrong).

    Whatever is there under the final name at any moment must be the whole file.
    """
    wrong, kills = [], 0
    while True:
        child, end = start(study, target, chance.choice((1, 2, 3, 4))), time.monotonic() + chance.uniform(0.0, LATEST)
        while not ended(child) and (kills == most or time.monotonic() < end):
            time.sleep(0.001)
        if not ended(child):
            os.kill(child, signal.SIGKILL)
        _, code = os.waitpid(child, 0)
        if target.exists() and target.read_bytes() != expected:
            wrong.append(f"{target.name} was there after {kills} kills, and was not whole")
        if not os.WIFSIGNALED(code):
            if code or not target.exists():
                wrong.append(f"{target.name}: a start that nobody killed ended with {code}")
            return kills, wrong
        kills += 1


def main(folder: Path, studies: int, kills: int, seed: int) -> None:
    """Print of how many studies and kills, and what was wrong.

    More studies than asked for where some came to their end before their share of the kills, as on a fast machine.
    """
    chance, killed, number, wrong = random.Random(seed), 0, -1, []
    while killed < kills or number + 1 < studies:
        number += 1
        study = parse_scene(pair(0.3 + 0.02 * number, 81 + 4 * number))
        whole, again = folder / f"whole-{number}" / "results.nc", folder / f"killed-{number}" / "results.nc"
        for target in (whole, again):
            target.parent.mkdir()
        scan(study, whole, screening=False, workers=1)
        found, faults = disturbed(study, again, whole.read_bytes(), chance, kills // studies)
        left = [path.name for path in again.parent.rglob("*") if "partial" in path.name or path.suffix == ".npz"]
        wrong += [*faults, *(f"study {number} leaves {name}" for name in left)]
        killed += found
    print(json.dumps({"studies": number + 1, "kills": killed, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
