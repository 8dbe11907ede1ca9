"""Rows of buildings in OpenSees, as `lab/accuracy_opensees.py` builds them, with the peaks of every floor.

Newmark's average acceleration, modified Newton, NormDispIncr 1e-12, for the reasons in `opensees_pair.py`. Peaks are
the largest values at the steps.
"""

from __future__ import annotations

import os
import time
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from row_scenes import RowScene

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_bench import PointCase
from pounding_risk.lab.accuracy_opensees import ITERATIONS, build, silenced
from pounding_risk.models.structures.contact_points import FLOOR, Point


class RowAnswer(NamedTuple):
    """Peaks of one run and the processor's time for it."""

    peak_displacement: np.ndarray  # m, of every mass
    peak_contact_force: np.ndarray  # N, of every contact point
    seconds: float


def solve_opensees_row(ops: Any, scene: RowScene, h: float) -> RowAnswer:
    """One run from rest with steps of ``h`` [s]. Raises PoundingError where a step does not converge."""
    steps = round(scene.duration / h)
    with TemporaryDirectory() as folder, silenced():
        points = [Point(interface, left, right, FLOOR, nan) for interface, left, right in scene.points]
        count = len(points)
        case = PointCase(0, (scene.law,) * count, (scene.restitution,) * count, np.full(count, scene.gap), np.empty(0))
        contacts = build(ops, scene.chains, points, case, scene)
        reach, force = (os.path.join(folder, name) for name in ("reach", "force"))
        nodes = range(2, sum(chain.mass.size for chain in scene.chains) + 2)
        ops.recorder("EnvelopeNode", "-file", reach, "-precision", 17, "-node", *nodes, "-dof", 1, "disp")
        ops.recorder("EnvelopeElement", "-file", force, "-precision", 17, "-ele", *contacts, "material", 1, "stress")
        begun = time.process_time()
        failed = ops.analyze(steps, h)
        seconds = time.process_time() - begun
        reached = ops.getTime()
        ops.wipe()  # closes the recorders' files
        # Rows: smallest, largest, largest in size.
        peaks, forces = (np.loadtxt(Path(file), ndmin=2) for file in (reach, force))
    if failed:
        raise PoundingError(
            f"OpenSees stops at {reached:.4g} s of {scene.duration:g} s of {scene.name} with steps of {h:g} s: no "
            f"convergence in {ITERATIONS} iterations; take a smaller step"
        )
    return RowAnswer(peaks[2], -forces[0], seconds)


def errors_of(found: RowAnswer, known: tuple[np.ndarray, np.ndarray]) -> tuple[float, float]:
    """Relative errors of the peak displacements, the worst mass, and of the peak forces, against the largest one."""
    displacement, force = known
    return (
        float(np.abs(found.peak_displacement / displacement - 1.0).max()),
        float(np.abs(found.peak_contact_force - force).max() / force.max()),
    )
