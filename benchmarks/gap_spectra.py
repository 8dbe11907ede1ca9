"""Required gaps of 100 × 100 periods under 44 records, beside single pairs: ``python benchmarks/gap_spectra.py``.

The FEMA P-695 far-field set (16 to 100 s) through the public `spectra` with two threads, T from 0.1 to 2 s on both
sides, damping 5 % (one half of the pairs is the other mirrored), then 5 % beside 2 % (every pair is followed). Each in
a process of its own, once its kernel is compiled; wall and processor time are from the first record read to the
finished dataset. Beside it the motion without contact of single pairs, as a scan computes it: processor time of some
drawn pairs under every fourth record, times the number of pairs and records, and the largest difference of the gaps.
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

import pounding_risk as pr
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.solver.pair.api import free_response, oscillators

MOTIONS = either({"set": "fema-p695-farfield"}, {"names": ["RSN6-180"]})
PERIODS, THREADS = ("0.1 s", "2 s"), 2
NUM, DRAWN, EVERY = either((100, 12, 4), (3, 2, 1))
DAMPINGS = {"alike": (0.05, 0.05), "unlike": (0.05, 0.02)}


def records() -> pr.Records:
    """The set as recorded, in both polarities."""
    return pr.Records(**MOTIONS, polarity=["as recorded", "reversed"])


def measure(which: str) -> dict[str, float]:
    """One dataset in this process, its kernel compiled before."""
    pr.spectra(pr.Records(["RSN6-180"]), num=2, damping=DAMPINGS[which])
    wall, cpu = time.perf_counter(), time.process_time()
    dataset = pr.spectra(records(), periods=PERIODS, num=NUM, damping=DAMPINGS[which], workers=THREADS, motions=True)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    single, difference = single_pairs(dataset, DAMPINGS[which])
    return {"wall": wall, "cpu": cpu, "memory": memory, "single": single, "difference": difference}


def single_pairs(dataset, dampings: tuple[float, float]) -> tuple[float, float]:
    """Processor time [s] of all pairs one by one, from some of them, and the largest relative difference of gaps."""
    motions = read_ensemble(records().request(), Path()).motions[::EVERY]
    random = np.random.default_rng(1)
    drawn = random.choice(NUM * NUM, DRAWN, replace=False)
    cpu, difference = 0.0, 0.0
    for count, number in enumerate([drawn[0], *drawn]):  # the first one compiles
        row, column = divmod(int(number), NUM)
        periods = float(dataset["left_period"][row]), float(dataset["right_period"][column])
        pair = oscillators(*(Building("", 1.0, *numbers) for numbers in zip(periods, dampings, strict=True)))
        start = time.process_time()
        free = [free_response(pair, motion.acceleration, motion.dt) for motion in motions]
        cpu += (time.process_time() - start) * (count > 0)
        gaps = dataset["required_gap_of_motion"][::EVERY, :, row, column].values
        alone = np.array([[one.high[:, 0].max(), -one.low[:, 0].min()] for one in free])
        difference = max(difference, float(np.abs(gaps / alone - 1.0).max()))
    return cpu / (DRAWN * len(motions)) * NUM * NUM * dataset.sizes["record"], difference


def main() -> int:
    """Measure both in turn and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=tuple(DAMPINGS), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(options.only)))
        return 0
    print("| damping | wall | processor | resident memory | single pairs, processor | ratio | largest difference |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for which, (left, right) in DAMPINGS.items():
        command = [sys.executable, __file__, "--only", which]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        print(
            f"| {100 * left:g} % beside {100 * right:g} % | {found['wall']:.1f} s | {found['cpu']:.1f} s "
            f"| {found['memory']:.0f} MB | {found['single']:.0f} s | {found['single'] / found['cpu']:.0f} "
            f"| {found['difference']:.0e} |"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
