"""Rows by this package beside OpenSees at equal error: ``python benchmarks/rows_side_by_side.py``.

Same buildings, same damping matrix, same constant e, one run each, processor time of the run alone: free response and
working space are this package's own, OpenSees' model is built before its clock starts. Errors are relative, against
this package at rtol 1e-12, which tests/validation holds against SciPy. ``--fine`` gives OpenSees steps of 1e-5 s as
well (four minutes more); ``--quick`` does three seconds of the first row, once. Without OpenSees the other lines still
come.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from opensees_row import RowAnswer, errors_of, solve_opensees_row
from row_scenes import RowScene, row_of_four, ten_and_eight, three_storey_pair
from side_by_side import read_time
from throughput import in_time, range_of

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_opensees import load
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.solver.counters import PEAK_FORCE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

CONVERGED = 1e-12
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
STEPS, FINEST = (1e-3, 1e-4), 1e-5  # s


def contacts_of(scene: RowScene) -> Any:
    """Gaps, yield forces, laws and restitutions of all contact points."""
    count = len(scene.points)
    return rows.Contacts(
        np.full(count, scene.gap),
        np.full(count, np.inf),
        [scene.law] * count,
        [scene.restitution] * count,
    )


def solve_row(scene: RowScene, rtol: float, times: int = 1) -> RowAnswer:
    """One run from rest by this package, and the processor's time for one, over so many."""
    points = [Point(interface, float(left), float(right), FLOOR, np.nan) for interface, left, right in scene.points]
    row, contacts = lay_out(scene.chains, points, scene.dt), contacts_of(scene)
    free = rows.free_response(row, scene.acceleration).motion
    begun = time.process_time()
    for _ in range(times):
        run = rows.run_row(row, contacts, scene.acceleration, rtol=rtol, free=free)
    seconds = (time.process_time() - begun) / times
    return RowAnswer(run.floors[:, 0], run.points[:, PEAK_FORCE], seconds)


def ladder(scene: RowScene, ops: Any, fine: bool) -> dict[str, list[tuple[str, Callable[[], RowAnswer]]]]:
    """Methods and their settings, coarse to fine."""
    found = {"this package": [(f"rtol {rtol:.0e}", lambda rtol=rtol: solve_row(scene, rtol, 5)) for rtol in TOLERANCES]}
    if ops is not None:
        steps = (*STEPS, FINEST) if fine else STEPS
        found["OpenSees"] = [(f"steps of {h:.0e} s", lambda h=h: solve_opensees_row(ops, scene, h)) for h in steps]
    return found  # type: ignore[return-value]


def table(scene: RowScene, ops: Any, fine: bool, repeats: int) -> list[str]:
    """One scene: every method and setting, and how many times this package's time at the same error it takes."""
    truth = solve_row(scene, CONVERGED)
    known = truth.peak_displacement, truth.peak_contact_force
    rungs = ladder(scene, ops, fine)
    seconds: dict[tuple[str, str], list[float]] = {}
    errors: dict[tuple[str, str], tuple[float, float]] = {}
    for repeat in range(repeats):
        for method, settings in rungs.items():
            for setting, solve in settings:
                if repeat and np.median(seconds[method, setting]) > 20.0:
                    continue
                answer = solve()
                seconds.setdefault((method, setting), []).append(answer.seconds)
                errors[method, setting] = errors_of(answer, known)
    own = [(errors["this package", name], median(seconds["this package", name])) for name, _ in rungs["this package"]]
    lines = [
        f"| {scene.name}, {scene.duration:g} s | CPU time a run | error of peak displacement | of peak force | "
        "over this package's time at equal error, displacement | force |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for (method, setting), spent in seconds.items():
        found, ratios = errors[method, setting], ["", ""]
        if method != "this package":
            for output in range(2):
                read = read_time(found[output], [error[output] for error, _ in own], [one for _, one in own])
                ratios[output] = f"{median(spent) / read.seconds:,.0f}"
        cells = [range_of(spent, in_time), *(f"{error:.0e}" for error in found), *ratios]
        lines.append(f"| {method}, {setting} | {' | '.join(cells)} |")
    return lines


def main(arguments: list[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--fine", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--repeats", type=int, default=5)
    asked = parser.parse_args(arguments)
    try:
        ops = load()
    except PoundingError as reason:
        print(f"OpenSees is left out: {reason}", end="\n\n")
        ops = None
    scenes = [three_storey_pair, row_of_four, ten_and_eight]
    for make in scenes[:1] if asked.quick else scenes:
        scene = make(3.0) if asked.quick else make()
        solve_row(scene._replace(acceleration=scene.acceleration[:10]), 1e-6)  # compiles
        print("\n".join(table(scene, ops, asked.fine, 1 if asked.quick else asked.repeats)), end="\n\n", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
