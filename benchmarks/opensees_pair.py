"""The pair in OpenSees: two masses on springs and dampers, an impact material on a zeroLength element between them.

Newmark's average acceleration, modified Newton, NormDispIncr 1e-12. The convergence test decides: at a small step
masses move less than 1e-6 m in one, so that with a test of 1e-6 a smaller step gives a *worse* answer (the paper's
pair is off by 26 % at steps of 1e-5 s, and by 4e-6 with 1e-12). The tangent of JankowskiImpact and Hertzdamp has the
wrong sign and none has a damping tangent; at steps of 1 ms and less the masses outweigh it, and of the solvers tried
(BandGeneral, FullGeneral, UmfPack, ProfileSPD; Newton, KrylovNewton, modified Newton) all give the same answer to
seven digits and the one here is the fastest. Every impact is a line on standard error, which is silenced. Peaks are
the largest values at the steps, from envelope recorders; the time is that of `analyze` alone.
"""

from __future__ import annotations

import os
import time
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from pair_scenes import Scene

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_opensees import ITERATIONS, NEAREST, shake, silenced
from pounding_risk.models.contact.law import hertz_work
from pounding_risk.models.contact.laws.jankowski import jankowski_ratio
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building

YIELD_SHARE = 0.1  # Muthukumar's a: the yield penetration over the largest
GROUND, LEFT, RIGHT, CONTACT = 1, 2, 3, 4  # tags of nodes, elements and materials


class Answer(NamedTuple):
    """Peaks of one run and the processor's time for it."""

    peak_relative_displacement: float  # m
    peak_contact_force: float  # N
    seconds: float


def damper(building: Building) -> float:
    """c = 2 ζ ω m [N s/m]."""
    return 4.0 * pi * building.damping / building.period * building.mass


def material(scene: Scene) -> tuple[Any, ...]:
    """The scene's contact law as OpenSees takes it: name, then numbers; lengths in contact are negative there.

    Raises PoundingError for a law that OpenSees has no material for, and for an e that falls with the speed.
    """
    law, restitution = scene.interface.law, scene.interface.restitution
    gap = -max(scene.interface.gap, NEAREST)
    e = restitution.c0
    if restitution != constant(e):
        raise PoundingError(f"OpenSees takes one e for every impact, the scene has {restitution}; give it a number")
    mass = 1.0 / (1.0 / scene.left.mass + 1.0 / scene.right.mass)
    if scene.law == "Jankowski":
        return "JankowskiImpact", CONTACT, law.stiffness, jankowski_ratio(e), mass, gap, 1.5
    if scene.law == "HertzDamp":
        return "Hertzdamp", CONTACT, law.stiffness, law.begin(e, 1.0, mass), gap, 1.5
    if scene.law == "KelvinVoigt":
        return "ViscoelasticGap", CONTACT, law.stiffness, law.begin(e, 1.0, mass), gap
    raise PoundingError(f"OpenSees has no material for {scene.law}; it has Jankowski, HertzDamp and KelvinVoigt")


def bilinear_material(scene: Scene, largest: float) -> tuple[Any, ...]:
    """ImpactMaterial after Muthukumar (2003) from β and e of a Hertz law and the ``largest`` penetration [m] assumed.

    ΔE = 0.4 β δm^2.5 (1 − e²),  K_eff = β δm^0.5,  δy = 0.1 δm
    K1 = K_eff + ΔE / (0.1 δm²),  K2 = K_eff − ΔE / (0.9 δm²)
    """
    law, e = scene.interface.law, scene.interface.restitution.c0
    lost = hertz_work(law.stiffness, largest) * (1.0 - e * e)
    slope = law.stiffness * largest**0.5
    first = slope + lost / (YIELD_SHARE * largest**2)
    second = slope - lost / ((1.0 - YIELD_SHARE) * largest**2)
    gap = -max(scene.interface.gap, NEAREST)
    return "ImpactMaterial", CONTACT, first, second, -YIELD_SHARE * largest, gap


def build(ops: Any, scene: Scene, contact: tuple[Any, ...] | None) -> None:
    """Nodes, masses, springs, dampers, the impact element if any, the ground motion and the method."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (GROUND, LEFT, RIGHT):
        ops.node(node, 0.0)
    ops.fix(GROUND, 1)
    for node, building in ((LEFT, scene.left), (RIGHT, scene.right)):
        ops.mass(node, building.mass)
        ops.uniaxialMaterial("Elastic", node, building.stiffness, damper(building))
        ops.element("zeroLength", node, GROUND, node, "-mat", node, "-dir", 1)
    ops.uniaxialMaterial(*(contact or ("Elastic", CONTACT, 0.0)))
    ops.element("zeroLength", CONTACT, LEFT, RIGHT, "-mat", CONTACT, "-dir", 1)
    shake(ops, scene.acceleration, scene.dt, (LEFT, RIGHT), "Plain")


def solve_opensees(ops: Any, scene: Scene, h: float, contact: tuple[Any, ...] | None = None) -> Answer:
    """One run from rest with steps of ``h`` [s]; ``contact`` is a material in place of the scene's own.

    Raises PoundingError where a step does not converge.
    """
    steps = round(scene.duration / h)
    with TemporaryDirectory() as folder, silenced():
        build(ops, scene, contact or material(scene))
        for name, what in (("reach", ("deformation",)), ("force", ("material", 1, "stress"))):
            file = os.path.join(folder, name)
            ops.recorder("EnvelopeElement", "-file", file, "-precision", 17, "-ele", CONTACT, *what)
        begun = time.process_time()
        failed = ops.analyze(steps, h)
        seconds = time.process_time() - begun
        reached = ops.getTime()
        ops.wipe()  # closes the recorders' files
        reach, force = (np.loadtxt(Path(folder) / name) for name in ("reach", "force"))
    if failed:
        raise PoundingError(
            f"OpenSees stops at {reached:.4g} s of {scene.duration:g} s of {scene.name} ({scene.law}) with steps of "
            f"{h:g} s: no convergence in {ITERATIONS} iterations; take a smaller step"
        )
    return Answer(float(np.abs(reach).max()), -float(force.min()), seconds)


def free_motion(ops: Any, scene: Scene, h: float) -> np.ndarray:
    """Displacements of both buildings without contact at every step, shape (steps, 2) [m]."""
    steps = round(scene.duration / h)
    with silenced():
        build(ops, scene, None)
        found = np.zeros((steps, 2))
        for step in range(steps):
            ops.analyze(1, h)
            found[step] = ops.nodeDisp(LEFT, 1), ops.nodeDisp(RIGHT, 1)
        ops.wipe()
    return found
