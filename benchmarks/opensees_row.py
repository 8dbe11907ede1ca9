"""Rows of buildings in OpenSees: shear chains of zeroLength springs, an impact material where floors meet.

Newmark's average acceleration, modified Newton, NormDispIncr 1e-12, as in `opensees_pair.py` and for its reasons.
Storeys are Elastic materials with a dashpot of their own: any damping in proportion to masses and stiffnesses is a set
of those, the same matrix on both sides. Peaks are the largest values at the steps.
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from opensees_pair import ITERATIONS, NEAREST, TEST, silenced
from row_scenes import RowScene

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.laws.jankowski import jankowski_ratio
from pounding_risk.models.structures.mdof import Chain

GROUND = 1  # node; mass i is node i + 2


class RowAnswer(NamedTuple):
    """Peaks of one run and the processor's time for it."""

    peak_displacement: np.ndarray  # m, of every mass
    peak_contact_force: np.ndarray  # N, of every contact point
    seconds: float


def dashpots(chain: Chain) -> tuple[np.ndarray, np.ndarray]:
    """Dashpots along the storeys and from every floor to the ground [N s/m] that make up the damping matrix.

    Raises PoundingError where it is not tridiagonal, as modal damping is not.
    """
    matrix, beside = chain.damping, np.diag(chain.damping, -1)
    storeys = np.append(0.0, -beside)  # the lowest is one to the ground
    to_ground = np.diag(matrix) - storeys - np.append(storeys[1:], 0.0)
    made = np.diag(np.diag(matrix)) + np.diag(beside, 1) + np.diag(beside, -1)
    if not np.allclose(made, matrix, rtol=1e-12, atol=1e-12 * np.abs(matrix).max()):
        raise PoundingError(
            'OpenSees has dashpots between neighbouring floors only; give damping_rule = "rayleigh" or "stiffness"'
        )
    return storeys, to_ground


def impact_material(scene: RowScene, tag: int, point: tuple[int, int, int]) -> tuple[Any, ...]:
    """The scene's law at a contact point as OpenSees takes it; lengths in contact are negative there."""
    masses = np.concatenate([chain.mass for chain in scene.chains])
    left, right = scene.masses_at(point)
    mass = 1.0 / (1.0 / masses[left] + 1.0 / masses[right])
    e, law, gap = scene.restitution.c0, scene.law, -max(scene.gap, NEAREST)
    if type(law).__name__ == "Jankowski":
        return "JankowskiImpact", tag, law.stiffness, jankowski_ratio(e), mass, gap, 1.5
    return "Hertzdamp", tag, law.stiffness, law.begin(e, 1.0, mass), gap, 1.5


def build(ops: Any, scene: RowScene) -> list[int]:
    """Nodes, storeys, contacts, the ground motion and the method; returns the contacts' elements."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(GROUND, 0.0)
    ops.fix(GROUND, 1)
    tag = GROUND
    for first, chain in zip(scene.first, scene.chains, strict=False):
        storeys, to_ground = dashpots(chain)
        for floor, mass in enumerate(chain.mass.tolist()):
            node = first + floor + 2
            ops.node(node, 0.0)
            ops.mass(node, mass)
            below = node - 1 if floor else GROUND
            for spring, dashpot, other in (
                (float(chain.spring[floor]), float(storeys[floor]), below),
                (0.0, float(to_ground[floor]), GROUND),
            ):
                tag += 1
                ops.uniaxialMaterial("Elastic", tag, spring, dashpot)
                ops.element("zeroLength", tag, other, node, "-mat", tag, "-dir", 1, "-doRayleigh", 0)
    contacts = []
    for point in scene.points:
        tag += 1
        left, right = scene.masses_at(point)
        ops.uniaxialMaterial(*impact_material(scene, tag, point))
        ops.element("zeroLength", tag, left + 2, right + 2, "-mat", tag, "-dir", 1)
        contacts.append(tag)
    ops.timeSeries("Path", 1, "-dt", scene.dt, "-values", *scene.acceleration.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    for mass in range(scene.first[-1]):
        # At rest the first sample acts already; Newmark's rule would start from none and lose an order.
        ops.setNodeAccel(mass + 2, 1, -float(scene.acceleration[0]), "-commit")
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", TEST, ITERATIONS)
    ops.algorithm("ModifiedNewton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    return contacts


def solve_opensees_row(ops: Any, scene: RowScene, h: float) -> RowAnswer:
    """One run from rest with steps of ``h`` [s]. Raises PoundingError where a step does not converge."""
    steps = round(scene.duration / h)
    with TemporaryDirectory() as folder, silenced():
        contacts = build(ops, scene)
        reach, force = (os.path.join(folder, name) for name in ("reach", "force"))
        nodes = range(2, scene.first[-1] + 2)
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
