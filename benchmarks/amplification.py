"""Amplification over 30 period ratios × 20 gaps under 44 records: ``python benchmarks/amplification.py``.

The FEMA P-695 far-field set (16 to 100 s) at PGA 0.5 g in both polarities, through the public `amplification` with two
threads: T_left from 0.2 to 5 times T_right = 0.5 s, gaps of 0.1 to 1.05 SRSS, viscous elastoplastic contact. Beside it
a scan of each of some drawn pairs of periods, times the number of pairs, and whether the amplifications are equal. The
kernels are compiled before. Optionally the figure is written.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path

import numpy as np
from shortened import either

import pounding_risk as pr
from pounding_risk.figures import write

RATIOS, GAPS, DRAWN, THREADS = either((30, 20, 3, 2), (2, 2, 1, 2))
SET, FEW = 'set = "fema-p695-farfield"', 'names = ["RSN6-180"]'
SCENE = """
[[building]]
name = "frame"
mass = "500 t"
period = "0.5 s"
[[building]]
name = "core"
mass = "500 t"
period = "0.5 s"
[[interface]]
gap = "10 mm"
contact_model = "viscous_elastoplastic"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65
[records]
RECORDS
polarity = ["as recorded", "reversed"]
pga = "0.5 g"
""".replace("RECORDS", either(SET, FEW))


def single_scans(dataset) -> tuple[float, bool]:
    """Processor time [s] of a scan of every pair of periods, from some of them; and whether all values are equal."""
    places = np.random.default_rng(1).choice(RATIOS, DRAWN, replace=False)
    equal, cpu = True, 0.0
    for place in places:
        cell = dataset.isel(fixed_period=0, period_ratio=int(place))
        gaps = ", ".join(f'"{float(gap)!r} m"' for gap in cell["gap"])
        period = f"building.frame.period={float(cell['building_period'][0])!r} s"
        study = pr.read_scene(SCENE + f"[grid]\ngap = [{gaps}]\n", [period])
        start = time.process_time()
        own = pr.scan(study, check_fraction=0.0, workers=THREADS)
        cpu += time.process_time() - start
        own = own.isel(contact_model=0, yield_force=0)
        ratio = (own["peak_displacement"] / own["peak_displacement_free"]).transpose(
            "record", "polarity", "gap", "building"
        )
        equal &= np.array_equal(cell["displacement_amplification_of_motion"].values, ratio.values)
    return cpu / DRAWN * RATIOS, equal


def main() -> int:
    """Measure once and print a row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    few = SCENE.replace(SET, FEW)
    pr.amplification(few, num=2, num_gaps=2)  # compiles
    wall, cpu = time.perf_counter(), time.process_time()
    dataset = pr.amplification(SCENE, num=RATIOS, gap_shares=(0.1, 1.05), num_gaps=GAPS, motions=True, workers=THREADS)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    scans, equal = single_scans(dataset)
    cases = dataset["displacement_amplification_of_motion"].size // 2
    print("| runs | wall | processor | resident memory | single scans, processor | ratio | equal |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | --- |")
    print(
        f"| {cases:,} | {wall:.1f} s | {cpu:.1f} s | {memory:.0f} MB | {scans:.0f} s | {scans / cpu:.1f} "
        f"| {'every bit' if equal else 'no'} |"
    )
    print(dataset.attrs["finding"])
    if options.figure:
        write(dataset.pounding.figure(), options.figure)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
