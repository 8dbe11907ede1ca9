"""10,000 samples of a pair under 44 records without contact: ``python benchmarks/uncertain_free.py``.

Periods and damping ratios of both buildings are lognormal, the motions the FEMA P-695 far-field set in both polarities
(880,000 motions of a pair) through `studies.uncertainty.free_motion` with two threads. Measured in a process of its
own, once its kernel is compiled, from the scene's text to the finished dataset: wall and processor time, and peak
memory. Beside it scans of the scenes at some drawn samples: the largest difference of a closing, and the processor time
that they would take for all samples.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time

import numpy as np
from shortened import either

import pounding_risk as pr
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.variants import Variants
from pounding_risk.studies.uncertainty import free_motion

SAMPLES, THREADS, DRAWN = either((10_000, 2, 5), (4, 2, 1))
SCENE = """
[[building]]
name = "left"
mass = "500 t"
period = "0.5 s"

[[building]]
name = "right"
mass = "800 t"
period = "0.8 s"

[[interface]]
gap = "40 mm"
contact_model = "jankowski"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65

[records]
RECORDS
polarity = ["as recorded", "reversed"]

[uncertain]
samples = COUNT
method = "random"
seed = 1
"building.left.period" = {distribution = "lognormal", median = "0.5 s", dispersion = 0.2}
"building.right.period" = {distribution = "lognormal", median = "0.8 s", dispersion = 0.2}
"building.left.damping" = {distribution = "lognormal", median = 0.05, dispersion = 0.4}
"building.right.damping" = {distribution = "lognormal", median = 0.05, dispersion = 0.4}
"""
FEW = 'names = ["RSN6-180"]\nwindow = ["0 s", "3 s"]'


def scene(count: int, records: str = either('set = "fema-p695-farfield"', FEW)):
    """The scene with so many samples."""
    return parse_scene(SCENE.replace("COUNT", str(count)).replace("RECORDS", records))


def measure(count: int) -> dict[str, float]:
    """One dataset in this process, its kernel compiled before."""
    free_motion(scene(2, FEW))
    wall, cpu = time.perf_counter(), time.process_time()
    study = scene(count)
    dataset = free_motion(study, workers=THREADS)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    touching = float((dataset["peak_closing_free"] > 0.04).mean())
    single, difference = scans(dataset, study, count)
    return {
        "wall": wall,
        "cpu": cpu,
        "memory": memory,
        "touching": touching,
        "loop": single,
        "difference": difference,
    }


def scans(dataset, study, count: int) -> tuple[float, float]:
    """Processor time [s] of a scan for every sample, from some of them, and the largest relative difference.

    The gap is one that no motion closes, so that no run of contact is timed.
    """
    variants, cpu, difference = Variants(study), 0.0, 0.0
    drawn = np.random.default_rng(1).choice(count, DRAWN, replace=False)
    for turn, number in enumerate([drawn[0], *drawn]):  # the first one compiles
        one = variants.scene(int(number)).replace(gap="10 m")
        start = time.process_time()
        alone = pr.scan(one)["peak_closing_free"]
        cpu += (time.process_time() - start) * (turn > 0)
        found = dataset["peak_closing_free"].isel(sample=int(number))
        difference = max(difference, float(np.abs(found / alone - 1.0).max()))
    return cpu / DRAWN * count, difference


def main() -> int:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=SAMPLES)
    parser.add_argument("--only", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(options.samples)))
        return 0
    command = [sys.executable, __file__, "--only", "--samples", str(options.samples)]
    found = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
    print("| samples | wall | processor | peak memory | loop of scans, processor | ratio | largest difference |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    print(
        f"| {options.samples:,} | {found['wall']:.1f} s | {found['cpu']:.1f} s | {found['memory']:.0f} MB "
        f"| {found['loop']:.0f} s | {found['loop'] / found['cpu']:.0f} | {found['difference']:.0e} |"
    )
    print(f"P(contact) at the stated gap: {found['touching']:.3f}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
